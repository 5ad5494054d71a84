//! A place where bodies are near each other as a potential contact: its velocities as functions of
//! the bodies' rates.

use nalgebra::Vector3;

use crate::contact::frame::frame;
use crate::contact::reactions::reaction::{Member, Part, Partner};
use crate::contact::reactions::row::{Row, Side};
use crate::contact::scene::{Scene, Scenes};
use crate::contact::search::candidate::Candidate;
use crate::robot::axial_play::AxleSlide;
use crate::robot::state::State;

/// A roller that may touch something.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axle {
    /// Its body's index among the articulated bodies.
    pub body: usize,
    pub wheel: usize,
    pub roller: usize,
    /// Its axis in the middle of the step, in the floor's frame.
    pub axis: Vector3<f64>,
    /// Its rate about its axis at the beginning of the step, in rad/s.
    pub before_rad_s: f64,
    /// Its rate after a jump at the beginning of the step.
    pub start_rad_s: f64,
    /// Its rate at the end of the step without any reaction, and then with them, in rad/s.
    pub rate_rad_s: f64,
    /// Its rate change per angular impulse of 1 N m s, in rad/s; `None` if it has seized and turns
    /// with the hub.
    pub response: Option<f64>,
    /// The same without its bearing's damping; 0 if it has seized.
    pub free_response: f64,
    /// Its axial motion.
    pub slide: AxleSlide,
    /// Load of its contacts at the beginning of the step, in N.
    pub load_n: f64,
}

impl Axle {
    /// Its rates about its axis and along it at the beginning of the step, in rad/s and m/s.
    pub fn before(&self) -> (f64, f64) {
        (self.before_rad_s, self.slide.before_m_s)
    }

    /// The same rates, currently known.
    pub fn now(&self) -> (f64, f64) {
        (self.rate_rad_s, self.slide.rate_m_s)
    }

    /// Its rate changes per impulse of 1 N m s about its axis and of 1 N s along it, in rad/s and
    /// m/s.
    pub fn responses(&self) -> [f64; 2] {
        [self.response.unwrap_or(0.0), self.slide.response_1_kg]
    }
}

/// A place where two bodies are near each other, as a potential contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PotentialContact {
    /// Distance from B at the beginning of the step, in metres, by its velocity in the middle.
    pub gap_before_m: f64,
    /// Normal and two tangents.
    pub frame: [Vector3<f64>; 3],
    /// They contain the coefficients of axles, but not yet the indices of these.
    pub rows: [Row; 3],
    /// The rollers that turn about their axes, of A and of B.
    pub axles: [Option<Axle>; 2],
    /// Velocity of A relative to B along the frame at the beginning of the step, in m/s.
    pub before: Vector3<f64>,
    /// The same at its end without any reaction.
    pub free: Vector3<f64>,
}

impl Scenes<'_> {
    /// Converts a place where two bodies are near each other to a potential contact.
    pub fn potential_contact(&self, place: &Candidate) -> PotentialContact {
        let a = self.of(place.a.body);
        let b = match place.b {
            Partner::Of(Member { body, part }) => Some((self.of(body), part)),
            Partner::Ground | Partner::Itself => None,
        };
        let part = place.a.part;
        let (frame, tangent) = match place.turning.came_down_at_m {
            // A roller that came down has its tangents of the beginning of the step; along the
            // normal its current place counts.
            Some(at_m) => (
                frame(place.normal, a.axis_of(part, &a.step.before)),
                (&a.step.before, at_m),
            ),
            None => (
                frame(place.normal, place.along),
                (&a.step.middle, place.place_m),
            ),
        };
        let row = |(state, at_m): (&State, Vector3<f64>), direction: Vector3<f64>| {
            let mut row = Row::of_one(a.side(part, state, at_m, direction));
            // Set only if it exists: a side is large, and most contacts are with the ground.
            if let Some((scene, part)) = &b {
                let side = scene.side(*part, &scene.step.middle, place.place_m, direction);
                row.b = Some(side.reversed());
            }
            row
        };
        // Complete before it is returned, because its rows are large and should not be moved.
        let mut contact = PotentialContact {
            gap_before_m: place.gap_m,
            frame,
            rows: [
                row((&a.step.middle, place.place_m), frame[0]),
                row(tangent, frame[1]),
                row(tangent, frame[2]),
            ],
            axles: [
                a.axle(part),
                b.as_ref().and_then(|(scene, part)| scene.axle(*part)),
            ],
            before: Vector3::zeros(),
            free: Vector3::zeros(),
        };
        let velocities = |rates: for<'s> fn(&'s Scene<'_>) -> &'s [f64],
                          of_axle: fn(&Axle) -> (f64, f64)| {
            let of_side = |side: &Side, scene: &Scene<'_>, axle: &Option<Axle>| {
                let of_axle = side.axle.zip(axle.as_ref().map(of_axle));
                side.of_bodies(rates(scene))
                    + of_axle.map_or(0.0, |((_, c), (rad_s, m_s))| c * rad_s + side.slide * m_s)
            };
            let of = |row: &Row| {
                let of_a = of_side(&row.a, &a, &contact.axles[0]);
                let of_b = row.b.as_ref().zip(b.as_ref());
                of_a + of_b.map_or(0.0, |(side, (scene, _))| {
                    of_side(side, scene, &contact.axles[1])
                })
            };
            let [normal, along, across] = &contact.rows;
            Vector3::new(of(normal), of(along), of(across))
        };
        let tangential = |v: &Vector3<f64>| Vector3::new(0.0, v.y, v.z);
        let turning = &place.turning;
        let now = velocities(|scene| &scene.step.rates_before, Axle::before);
        let free = velocities(|scene| &scene.step.rates_free, Axle::now);
        contact.gap_before_m -= 0.5 * self.dt_s * now.x;
        contact.before = now - tangential(&turning.until_m_s);
        contact.free = free + tangential(&turning.from_m_s);
        contact
    }
}

impl Scene<'_> {
    /// The axis of a part's roller in a state, in the floor's frame; any direction for other parts.
    fn axis_of(&self, part: Part, state: &State) -> Vector3<f64> {
        match part {
            Part::Roller(wheel, roller) => {
                let axis_in_hub = self.wheels[wheel].rollers[roller].axis_in_hub;
                state.hubs()[wheel].rotation * axis_in_hub
            }
            _ => Vector3::x(),
        }
    }

    /// The roller of a part, if it has one, with its rate without reactions.
    fn axle(&self, part: Part) -> Option<Axle> {
        let Part::Roller(wheel, roller) = part else {
            return None;
        };
        let state = &self.wheels[wheel].rollers[roller];
        let hub = &self.step.middle.hubs()[wheel];
        Some(Axle {
            body: self.index,
            wheel,
            roller,
            axis: hub.rotation * state.axis_in_hub,
            before_rad_s: state.axial_rate_rad_s,
            start_rad_s: state.axial_rate_rad_s,
            rate_rad_s: match state.seized {
                true => state.axial_rate_rad_s,
                false => state.free_rate_rad_s(self.dt_s),
            },
            response: (!state.seized).then_some(state.response(self.dt_s)),
            free_response: if state.seized {
                0.0
            } else {
                state.response(0.0)
            },
            slide: state.slide_on_ground(),
            load_n: 0.0,
        })
    }

    /// The velocity of a point of a part along a direction as a function of the robot's rates, in
    /// the pose of a state.
    ///
    /// A roller moves with its hub except for its rate about its own axis d: with w that rate, W
    /// the hub's angular velocity and l the lever from the roller's middle, v = v_hub + (w - W . d)
    /// d x l.
    fn side(
        &self,
        part: Part,
        state: &State,
        place_m: Vector3<f64>,
        direction: Vector3<f64>,
    ) -> Side {
        let Part::Roller(wheel, roller) = part else {
            let joint = match part {
                Part::Link(joint) => Some(joint),
                _ => None,
            };
            return self.moving_with(joint, state, (&place_m, &direction), &Vector3::zeros());
        };
        let hub = &state.hubs()[wheel];
        let roller = &self.wheels[wheel].rollers[roller];
        let axis = hub.rotation * roller.axis_in_hub;
        let share = if roller.seized {
            0.0
        } else {
            axis.dot(&(place_m - roller.center_m(hub)).cross(&direction))
        };
        let carried = -share * axis;
        let joint = self.wheels[wheel].joint;
        let mut side = self.moving_with(Some(joint), state, (&place_m, &direction), &carried);
        if !roller.seized {
            side.axle = Some((0, share));
            if roller.slide.is_some() {
                side.slide = axis.dot(&direction);
            }
        }
        side
    }
}
