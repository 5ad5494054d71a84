//! What a place near the ground would be as a contact: how its velocities follow from the robot's rates.

use nalgebra::Vector3;
use rapier3d::math::Real;

use crate::contact::candidates::{Candidate, frame};
use crate::contact::reaction::Part;
use crate::contact::scene::Scene;
use crate::robot::state::State;

/// How a velocity follows from the robot's rates, and what a unit impulse there does to them: those of the chassis, of a
/// wheel, and of a roller about its axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub chassis: [f64; 6],
    /// Degree of freedom and share.
    pub hub: Option<(usize, f64)>,
    /// Place among the axles and share.
    pub axle: Option<(usize, f64)>,
}

impl Row {
    /// The part of the velocity that chassis and wheel make, with these rates by degree of freedom.
    pub fn of_bodies(&self, rates: &[f64]) -> f64 {
        self.sum(|dof| rates[dof])
    }

    /// The same of rates as rapier has them.
    pub fn of_bodies_f32(&self, rates: &[Real]) -> f64 {
        self.sum(|dof| f64::from(rates[dof]))
    }

    fn sum(&self, rate: impl Fn(usize) -> f64) -> f64 {
        let chassis = self.chassis.iter().enumerate().map(|(i, c)| c * rate(i));
        chassis.sum::<f64>() + self.hub.map_or(0.0, |(dof, c)| c * rate(dof))
    }
}

/// A roller that may touch the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axle {
    pub wheel: usize,
    pub roller: usize,
    /// Its axis in the middle of the step, in the floor's frame.
    pub axis: Vector3<f64>,
    /// Its rate about its axis when the step began, in rad/s.
    pub before_rad_s: f64,
    /// What it starts from once a jump is over.
    pub start_rad_s: f64,
    /// Its rate at the end of the step without any reaction, and then with them, in rad/s.
    pub rate_rad_s: f64,
    /// What an angular impulse of 1 N m s does to it, in rad/s; `None` where it turns with the hub because it has seized.
    pub response: Option<f64>,
    /// What it would do if its bearing did not act; 0 where it has seized.
    pub free_response: f64,
}

/// A place near the ground, as the contact that it would be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PotentialContact {
    pub candidate: Candidate,
    /// Distance from the ground when the step began, in metres, as its velocity in the middle has it.
    pub gap_before_m: f64,
    /// Normal and two tangents.
    pub frame: [Vector3<f64>; 3],
    /// The share of an axle stands in them, its place among the axles not yet.
    pub rows: [Row; 3],
    pub axle: Option<Axle>,
    /// Velocity along the frame when the step began, in m/s.
    pub before: Vector3<f64>,
    /// And at its end without any reaction.
    pub free: Vector3<f64>,
}

impl Scene<'_> {
    /// What a place near the ground would be as a contact.
    pub fn potential_contact(&self, place: &Candidate) -> PotentialContact {
        let axle = self.axle(place.part);
        let in_the_middle = frame(place.normal, place.along);
        let row = |direction: Vector3<f64>| self.row(place, self.middle, place.place_m, direction);
        let (frame, rows) = match place.turning.came_down_at_m {
            Some(at_m) => {
                // A roller that came down: its tangents as they were then. Across the ground it is where it is now.
                let axes = frame(place.normal, self.axis_of(place.part, self.before));
                let tangent = |direction| self.row(place, self.before, at_m, direction);
                (axes, [row(axes[0]), tangent(axes[1]), tangent(axes[2])])
            }
            None => (in_the_middle, in_the_middle.map(row)),
        };
        let velocities = |rates: &[f64], axle_rad_s: Option<f64>| {
            let of = |row: &Row| {
                let of_axle = (row.axle.zip(axle_rad_s)).map_or(0.0, |((_, c), rate)| c * rate);
                row.of_bodies(rates) + of_axle
            };
            Vector3::new(of(&rows[0]), of(&rows[1]), of(&rows[2]))
        };
        let tangential = |v: &Vector3<f64>| Vector3::new(0.0, v.y, v.z);
        let turning = &place.turning;
        let now = velocities(self.rates_before, axle.map(|a| a.before_rad_s));
        let free = velocities(self.rates_free, axle.map(|a| a.rate_rad_s));
        PotentialContact {
            candidate: *place,
            gap_before_m: place.gap_m - 0.5 * self.dt_s * now.x,
            frame,
            rows,
            before: now - tangential(&turning.until_m_s),
            free: free + tangential(&turning.from_m_s),
            axle,
        }
    }

    /// The axis of a part's roller in a state, in the floor's frame; any direction of what is none.
    fn axis_of(&self, part: Part, state: &State) -> Vector3<f64> {
        match part {
            Part::Roller(wheel, roller) => {
                let axis_in_hub = self.assembly.wheels[wheel].rollers[roller].axis_in_hub;
                state.hubs()[wheel].rotation * axis_in_hub
            }
            _ => Vector3::x(),
        }
    }

    /// The roller of a part, if it is one's, with the rate that it has without reactions.
    fn axle(&self, part: Part) -> Option<Axle> {
        let Part::Roller(wheel, roller) = part else {
            return None;
        };
        let state = &self.assembly.wheels[wheel].rollers[roller];
        let hub = &self.middle.hubs()[wheel];
        Some(Axle {
            wheel,
            roller,
            axis: hub.rotation * state.axis_in_hub,
            before_rad_s: state.axial_rate_rad_s,
            start_rad_s: state.axial_rate_rad_s,
            rate_rad_s: state.free_rate_rad_s(self.dt_s),
            response: (!state.seized).then_some(state.response(self.dt_s)),
            free_response: if state.seized {
                0.0
            } else {
                state.response(0.0)
            },
        })
    }

    /// How the velocity of a place along a direction follows from the robot's rates, in the pose that it has in a state.
    ///
    /// A roller moves with its hub but for its rate about its own axis d: with w that rate, W the hub's angular velocity
    /// and l the lever from the roller's middle, v = v_hub + (w - W . d) d x l.
    fn row(
        &self,
        place: &Candidate,
        state: &State,
        place_m: Vector3<f64>,
        direction: Vector3<f64>,
    ) -> Row {
        let mut turn = (place_m - state.center_m()).cross(&direction);
        let (mut hub_row, mut axle_row) = (None, None);
        if let Part::Roller(wheel, roller) = place.part {
            let hub = &state.hubs()[wheel];
            let mut of_hub = (place_m - hub.center_m).cross(&direction);
            let body = &self.assembly.wheels[wheel];
            let roller = &body.rollers[roller];
            if !roller.seized {
                let axis = hub.rotation * roller.axis_in_hub;
                let lever_m = place_m - roller.center_m(hub);
                let share = axis.dot(&lever_m.cross(&direction));
                turn -= share * axis;
                of_hub -= share * axis;
                axle_row = Some((0, share));
            }
            hub_row = Some((body.hub_dof, hub.axis().dot(&of_hub)));
        }
        Row {
            chassis: [
                direction.x,
                direction.y,
                direction.z,
                turn.x,
                turn.y,
                turn.z,
            ],
            hub: hub_row,
            axle: axle_row,
        }
    }
}
