//! What the ground and dry bearings do to the robot in a step.
//!
//! rapier moves chassis and hubs as if nothing touched them: their mass matrix, gravity, motors and the forces of turning
//! frames. It says where rollers and chassis are near the ground. The impulses that follow are solved for here, all at once
//! and to the end, and change the rates with which the step is taken.

use ilon_robot::Robot;
use nalgebra::{DMatrixViewMut, Vector3};
use rapier3d::prelude::*;

use crate::RollerShape;
use crate::contact::problem::{ImpulseProblem, Law};
use crate::contact::reaction::{Part, Reaction};
use crate::engine::convert;
use crate::ground::Ground;
use crate::robot::assembly::Assembly;
use crate::robot::state::State;

/// A contact that would still open at this rate, in m/s, after a step without impulses is none: other contacts do not
/// change it by as much. It spares rough ground most of its foreseen contacts.
const OPEN_M_S: f64 = 0.1;

/// How a velocity follows from the robot's rates, and what a unit impulse there does to them: those of the chassis, of a
/// wheel, and of a roller about its axis.
#[derive(Clone, Copy, Debug)]
struct Row {
    chassis: [f64; 6],
    /// Degree of freedom and share.
    hub: Option<(usize, f64)>,
    /// Place among the axles and share.
    axle: Option<(usize, f64)>,
}

impl Row {
    /// The part of the velocity that chassis and wheel make.
    fn of_bodies(&self, rates: impl Fn(usize) -> f64) -> f64 {
        let chassis = self.chassis.iter().enumerate().map(|(i, c)| c * rates(i));
        chassis.sum::<f64>() + self.hub.map_or(0.0, |(dof, c)| c * rates(dof))
    }
}

/// A wheel, in the floor's frame.
#[derive(Clone, Copy, Debug)]
struct Hub {
    axis: Vector3<f64>,
    center_m: Vector3<f64>,
    /// Its turning among the robot's degrees of freedom.
    dof: usize,
}

/// A roller near the ground.
#[derive(Clone, Copy, Debug)]
struct Axle {
    wheel: usize,
    roller: usize,
    /// Its axis and middle, in the floor's frame.
    axis: Vector3<f64>,
    center_m: Vector3<f64>,
    /// Its rate about its axis without any reaction, and then with them, in rad/s.
    rate_rad_s: f64,
    /// What an angular impulse of 1 N m s does to it, in rad/s; `None` where it turns with the hub because it has seized.
    response: Option<f64>,
}

/// A place where a part of the robot is near the ground.
#[derive(Clone, Copy, Debug)]
struct Nearby {
    part: Part,
    at_m: Vector3<f64>,
    gap_m: f64,
    frame: [Vector3<f64>; 3],
    /// What it hangs on.
    on: Option<(Hub, Axle)>,
    /// Whether it is the outermost end of a roller's barrel.
    on_its_end: bool,
}

impl Nearby {
    /// Whether a roller has handed the wheel over to another, which stands on the same plane and is nearer to it.
    ///
    /// Barrels that follow each other without a gap make a wheel round, and rigid: beyond its end a roller is higher than
    /// the next one and carries nothing. But in the step of the hand-over both are within a micrometre of the ground, and
    /// two that stick in one step rub against each other's way.
    fn handed_over_to(&self, other: &Self) -> bool {
        /// Far above what f32 makes of a plane, and far below any step in a ground.
        const ONE_PLANE_M: f64 = 1e-5;
        let normal = &self.frame[0];
        let step_m = normal.dot(&(other.at_m - self.at_m));
        // Of two that are equally near one must stay.
        let nearer = other.gap_m < self.gap_m
            || other.gap_m == self.gap_m && (!other.on_its_end || other.part < self.part);
        self.part != other.part
            && self.on_its_end
            && nearer
            && normal.dot(&other.frame[0]) > 1.0 - 1e-6
            && step_m.abs() < ONE_PLANE_M
    }
}

/// The reactions of the last step, and room for those of the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reactions {
    nearby: Vec<Nearby>,
    /// Of the rollers that touch.
    axles: Vec<Axle>,
    all: Vec<Reaction>,
    before: Vec<Reaction>,
    rows: Vec<Row>,
    problem: ImpulseProblem,
    /// What the unit impulse of each row does to every rate, row by row.
    responses: Vec<Real>,
    change: Vec<f64>,
    error: f64,
}

impl Reactions {
    /// The reactions of the last step.
    pub fn all(&self) -> &[Reaction] {
        &self.all
    }

    /// By how much the laws were broken in the last step, in m/s or rad/s.
    pub fn error(&self) -> f64 {
        self.error
    }

    fn clear(&mut self) {
        std::mem::swap(&mut self.all, &mut self.before);
        self.all.clear();
        self.rows.clear();
        self.axles.clear();
        self.problem.clear();
    }

    /// Adds a law and where it acts.
    fn push(&mut self, law: Law, reaction: Reaction, rows: &[Row], free: &[f64]) {
        self.problem.push(law, free);
        self.rows.extend_from_slice(rows);
        self.all.push(reaction);
    }

    /// Solves for the impulses, given how impulses answer: `solve` takes generalised impulses, one of `dofs` numbers
    /// after the other, to the rates that they give.
    fn solve(&mut self, dofs: usize, solve: impl FnOnce(&mut [Real])) {
        let rows = self.rows.len();
        self.responses.clear();
        self.responses.resize(rows * dofs, 0.0);
        for (row, impulse) in self.rows.iter().zip(self.responses.chunks_exact_mut(dofs)) {
            for (dof, c) in row.chassis.iter().enumerate() {
                impulse[dof] = *c as Real;
            }
            if let Some((dof, c)) = row.hub {
                impulse[dof] = c as Real;
            }
        }
        solve(&mut self.responses);
        let (rows, axles, responses) = (&self.rows, &self.axles, &self.responses);
        self.problem.set_response(|row, column| {
            let (at, by) = (&rows[row], &rows[column]);
            let of_bodies = at.of_bodies(|dof| f64::from(responses[column * dofs + dof]));
            match (at.axle, by.axle) {
                (Some((i, a)), Some((j, b))) if i == j => {
                    of_bodies + a * b * axles[i].response.unwrap_or(0.0)
                }
                _ => of_bodies,
            }
        });

        // What acted in the last step is most of what acts in this one.
        let mut row = 0;
        for (i, reaction) in self.all.iter().enumerate() {
            let of_part = |other: &&Reaction| reaction.part.follows(other.part);
            let place = self.all[..i].iter().filter(of_part).count();
            if let Some(before) = self.before.iter().filter(of_part).nth(place) {
                for k in reaction.rows() {
                    self.problem.suppose(row + k, before.impulse[k]);
                }
            }
            row += reaction.rows().len();
        }
        self.error = self.problem.solve();

        let mut row = 0;
        self.change.clear();
        self.change.resize(dofs, 0.0);
        for reaction in &mut self.all {
            for k in reaction.rows() {
                let impulse = self.problem.impulses()[row];
                reaction.impulse[k] = impulse;
                let response = &self.responses[row * dofs..][..dofs];
                for (change, rate) in self.change.iter_mut().zip(response) {
                    *change += impulse * f64::from(*rate);
                }
                if let Some((axle, c)) = self.rows[row].axle {
                    let axle = &mut self.axles[axle];
                    axle.rate_rad_s += impulse * c * axle.response.unwrap_or(0.0);
                }
                row += 1;
            }
        }
    }
}

/// Everything that a step's reactions depend on, as rapier left it.
pub(crate) struct Scene<'a> {
    pub rapier: &'a PhysicsWorld,
    pub ground: &'a Ground,
    pub robot: &'a Robot,
    pub assembly: &'a Assembly,
    pub before: &'a State,
    pub dt_s: f64,
}

/// A roller that the ground touched in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TouchedRoller {
    pub wheel: usize,
    pub roller: usize,
    /// Its rate about its axis after the step, in rad/s.
    pub rate_rad_s: f64,
}

impl Reactions {
    /// Solves for the reactions of the step that rapier has just taken without any.
    pub fn react(&mut self, scene: &Scene<'_>) {
        self.clear();
        scene.gather(self);
        let multibody = &scene.rapier.multibody_joints[scene.assembly.multibody];
        let dofs = multibody.ndofs();
        let rows = self.rows.len();
        self.solve(dofs, |impulses| {
            let mut impulses = DMatrixViewMut::from_slice(impulses, dofs, rows);
            multibody.inv_augmented_mass().solve_mut(&mut impulses);
        });
    }

    /// By how much the reactions change each rate of the robot.
    pub fn change(&self) -> &[f64] {
        &self.change
    }

    /// The rollers that the ground touched.
    pub fn touched(&self) -> impl Iterator<Item = TouchedRoller> {
        self.axles.iter().map(|axle| TouchedRoller {
            wheel: axle.wheel,
            roller: axle.roller,
            rate_rad_s: axle.rate_rad_s,
        })
    }
}

impl Scene<'_> {
    /// Collects all contacts and dry bearings.
    fn gather(&self, reactions: &mut Reactions) {
        let chassis = &self.rapier.bodies[self.assembly.chassis];
        for collider in chassis.colliders() {
            self.find(reactions, Part::Chassis, *collider, None);
        }
        self.touch(reactions);
        for (index, wheel) in self.robot.wheels.iter().enumerate() {
            self.gather_wheel(reactions, index, wheel.joint.friction_n_m);
        }
    }

    fn gather_wheel(&self, reactions: &mut Reactions, index: usize, friction_n_m: f64) {
        let body = &self.assembly.wheels[index];
        let floor_from_hub = self.before.floor_from_hub(index);
        let hub_rate_in_hub = self.before.hub_rate_in_hub(index);
        let hub = Hub {
            axis: floor_from_hub.rotation * Vector3::z(),
            center_m: floor_from_hub.translation.vector,
            dof: body.hub_dof,
        };
        if friction_n_m > 0.0 {
            let row = Row {
                chassis: [0.0; 6],
                hub: Some((hub.dof, 1.0)),
                axle: None,
            };
            self.rub(reactions, Part::Hub(index), row, friction_n_m);
        }

        for slot in &body.slots {
            let roller = &body.rollers[slot.roller];
            let center_in_hub_m = roller.hub_from_roller.translation.vector;
            let axle = Axle {
                wheel: index,
                roller: slot.roller,
                axis: floor_from_hub.rotation * roller.axis_in_hub,
                center_m: hub.center_m + floor_from_hub.rotation * center_in_hub_m,
                rate_rad_s: roller.free_rate_rad_s(&hub_rate_in_hub, self.dt_s),
                response: (!roller.seized).then_some(roller.response),
            };
            let part = Part::Roller(index, slot.roller);
            self.find(reactions, part, slot.collider, Some((hub, axle)));
        }
        let others = reactions.axles.len();
        self.touch(reactions);

        for i in others..reactions.axles.len() {
            let axle = reactions.axles[i];
            let friction_n_m = body.rollers[axle.roller].friction_n_m;
            if friction_n_m > 0.0 && axle.response.is_some() {
                // Its spin against the hub.
                let d = axle.axis;
                let row = Row {
                    chassis: [0.0, 0.0, 0.0, -d.x, -d.y, -d.z],
                    hub: Some((hub.dof, -d.dot(&hub.axis))),
                    axle: Some((i, 1.0)),
                };
                self.rub(reactions, Part::Axle(index, axle.roller), row, friction_n_m);
            }
        }
    }

    /// Adds a dry bearing.
    fn rub(&self, reactions: &mut Reactions, part: Part, row: Row, friction_n_m: f64) {
        let law = Law::Bearing {
            most_n_m_s: friction_n_m * self.dt_s,
        };
        let reaction = Reaction {
            part,
            at_m: Vector3::zeros(),
            frame: [Vector3::zeros(); 3],
            friction: 0.0,
            impulse: Vector3::zeros(),
        };
        let of_axle = |(axle, c): (usize, f64)| c * reactions.axles[axle].rate_rad_s;
        let free = self.of_bodies(&row) + row.axle.map_or(0.0, of_axle);
        reactions.push(law, reaction, &[row], &[free]);
    }

    /// The part of a velocity that chassis and wheel make without any reaction.
    fn of_bodies(&self, row: &Row) -> f64 {
        row.of_bodies(|dof| self.assembly.rate(self.rapier, dof))
    }

    /// Collects where a collider is near the ground.
    fn find(
        &self,
        reactions: &mut Reactions,
        part: Part,
        collider: ColliderHandle,
        on: Option<(Hub, Axle)>,
    ) {
        let along = on.map_or_else(Vector3::x, |(_, axle)| axle.axis);
        let barrel = self.rapier.colliders[collider]
            .shape()
            .as_shape::<RollerShape>();
        for pair in self.rapier.narrow_phase.contact_pairs_with(collider) {
            let is_first = pair.collider1 == collider;
            let ground = if is_first {
                pair.collider2
            } else {
                pair.collider1
            };
            let rapier_from_ground = self.rapier.colliders[ground].position();
            for manifold in pair.manifolds() {
                // A manifold's normal points from its first shape to its second.
                let towards_second = convert::to_f64(manifold.data.normal);
                let normal = if is_first {
                    -towards_second
                } else {
                    towards_second
                };
                let on_its_end = barrel.is_some_and(|barrel| {
                    let place_m = barrel.support_place_m(-normal.dot(&along) as Real);
                    place_m.abs() >= barrel.half_length_m()
                });
                for point in &manifold.points {
                    let on_ground = if is_first {
                        point.local_p2
                    } else {
                        point.local_p1
                    };
                    let in_rapier_m = convert::to_f64(*rapier_from_ground * on_ground);
                    reactions.nearby.push(Nearby {
                        part,
                        at_m: self.ground.rapier_origin_m() + in_rapier_m,
                        gap_m: f64::from(point.dist),
                        frame: frame(normal, along),
                        on,
                        on_its_end,
                    });
                }
            }
        }
    }

    /// Turns the places that were found on the chassis or on one wheel into contacts.
    fn touch(&self, reactions: &mut Reactions) {
        let softness = &self.rapier.integration_parameters.contact_softness;
        let dt = self.dt_s as Real;
        let push_out_per_s = f64::from(softness.erp_inv_dt(dt));
        let softness = 1.0 / f64::from(softness.cfm_factor(dt)) - 1.0;
        let nearby = std::mem::take(&mut reactions.nearby);
        for place in &nearby {
            if nearby.iter().any(|other| place.handed_over_to(other)) {
                continue;
            }
            let axles = &reactions.axles;
            let of_this = |axle: &Axle| Part::Roller(axle.wheel, axle.roller) == place.part;
            let known = axles.iter().position(of_this);
            let rows = (place.frame)
                .map(|direction| self.row(place, direction, known.unwrap_or(axles.len())));
            let free = rows.map(|row| {
                let of_axle =
                    |(_, axle): (Hub, Axle)| row.axle.map_or(0.0, |(_, c)| c * axle.rate_rad_s);
                self.of_bodies(&row) + place.on.map_or(0.0, of_axle)
            });
            let gap_m = place.gap_m;
            let approach_m_s = if gap_m > 0.0 {
                gap_m / self.dt_s
            } else {
                gap_m * push_out_per_s
            };
            if free[0] + approach_m_s > OPEN_M_S {
                continue;
            }
            if let (None, Some((_, axle))) = (known, place.on) {
                reactions.axles.push(axle);
            }
            let friction = self.ground.friction_at(&place.at_m);
            let law = Law::Contact {
                friction,
                approach_m_s,
                softness,
            };
            let reaction = Reaction {
                part: place.part,
                at_m: place.at_m,
                frame: place.frame,
                friction,
                impulse: Vector3::zeros(),
            };
            reactions.push(law, reaction, &rows, &free);
        }
        reactions.nearby = nearby;
        reactions.nearby.clear();
    }

    /// How the velocity of a place along a direction follows from the robot's rates.
    ///
    /// A roller moves with its hub but for its rate about its own axis d: with w that rate, W the hub's angular velocity
    /// and l the lever from the roller's middle, v = v_hub + (w - W . d) d x l.
    fn row(&self, place: &Nearby, direction: Vector3<f64>, axle_index: usize) -> Row {
        let chassis_m = self.before.floor_from_chassis.translation.vector;
        let mut turn = (place.at_m - chassis_m).cross(&direction);
        let (mut hub_row, mut axle_row) = (None, None);
        if let Some((hub, axle)) = &place.on {
            let mut of_hub = (place.at_m - hub.center_m).cross(&direction);
            if axle.response.is_some() {
                let share = axle
                    .axis
                    .dot(&(place.at_m - axle.center_m).cross(&direction));
                turn -= share * axle.axis;
                of_hub -= share * axle.axis;
                axle_row = Some((axle_index, share));
            }
            hub_row = Some((hub.dof, hub.axis.dot(&of_hub)));
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

/// A normal and two tangents, of which the first lies along a direction as far as it can.
fn frame(normal: Vector3<f64>, along: Vector3<f64>) -> [Vector3<f64>; 3] {
    let tangent = |v: Vector3<f64>| (v - normal * normal.dot(&v)).try_normalize(1e-3);
    let first = tangent(along)
        .or_else(|| tangent(Vector3::x()))
        .or_else(|| tangent(Vector3::y()))
        .unwrap_or_else(Vector3::z);
    [normal, first, normal.cross(&first)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nearby(roller: usize, gap_m: f64, on_its_end: bool) -> Nearby {
        Nearby {
            part: Part::Roller(0, roller),
            at_m: Vector3::new(0.0, 0.01 * roller as f64, 0.0),
            gap_m,
            frame: frame(Vector3::z(), Vector3::x()),
            on: None,
            on_its_end,
        }
    }

    /// Whatever two neighbours do at a hand-over, a wheel on a plane keeps at least one contact, and a roller that stands
    /// on its barrel and not on its end keeps its own.
    #[test]
    fn a_hand_over_leaves_a_wheel_one_contact() {
        for (a_ends, b_ends) in [(true, true), (true, false), (false, true), (false, false)] {
            for gap_m in [-1e-7, 0.0, 1e-7] {
                let (a, b) = (nearby(3, gap_m, a_ends), nearby(4, 0.0, b_ends));
                let gone = [a.handed_over_to(&b), b.handed_over_to(&a)];
                assert_ne!(gone, [true, true]);
                assert!(a_ends || !gone[0]);
                assert!(b_ends || !gone[1]);
                assert!(!(a_ends && b_ends) || gone[0] != gone[1]);
            }
        }
    }

    /// On a step in the ground both stay: they stand on two planes.
    #[test]
    fn rollers_on_two_planes_do_not_hand_over() {
        let (mut a, b) = (nearby(3, 0.0, true), nearby(4, 0.0, false));
        a.at_m.z = 1e-3;
        assert!(!a.handed_over_to(&b));
        a.at_m.z = 0.0;
        a.frame = frame(Vector3::new(0.1, 0.0, 1.0).normalize(), Vector3::x());
        assert!(!a.handed_over_to(&b));
    }
}
