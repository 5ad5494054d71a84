//! What the ground and dry bearings do to the robot in a step.
//!
//! rapier moves the robot as if nothing touched it: its mass matrix, gravity, motors and the forces of turning frames. It
//! says where rollers and chassis are near the ground. The impulses that follow are solved for here, all at once and to
//! the end, and change the rates with which the step is taken.

use ilon_robot::Robot;
use nalgebra::{DMatrixViewMut, Vector3};
use rapier3d::prelude::*;

use super::World;
use crate::RollerShape;
use crate::assembly::Assembly;
use crate::convert;
use crate::ground::Ground;
use crate::impulse_problem::{ImpulseProblem, Law};
use crate::state::State;

/// A contact that would still open at this rate, in m/s, after a step without impulses is none: other contacts do not
/// change it by as much. It spares rough ground most of its foreseen contacts.
const OPEN_M_S: f64 = 0.1;

/// What a reaction acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// The chassis touches the ground.
    Chassis,
    /// A roller touches the ground: wheel and slot.
    Roller(usize, usize),
    /// The bearing of a wheel.
    Hub(usize),
    /// The bearing of a roller: wheel and slot.
    Axle(usize, usize),
}

/// One reaction of the last step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reaction {
    pub part: Part,
    /// Where, in the floor's frame, in metres; nowhere for a bearing.
    pub at_m: Vector3<f64>,
    /// For a contact the ground's normal and two tangents, in the floor's frame, of which the first lies along the
    /// roller.
    pub frame: [Vector3<f64>; 3],
    /// Coulomb friction coefficient of a contact.
    pub friction: f64,
    /// Impulse on the robot along `frame`, in N s; of a bearing the first number, in N m s.
    pub impulse: Vector3<f64>,
}

impl Reaction {
    /// Which numbers of the impulse the part has.
    fn rows(&self) -> std::ops::Range<usize> {
        match self.part {
            Part::Chassis | Part::Roller(..) => 0..3,
            Part::Hub(_) | Part::Axle(..) => 0..1,
        }
    }

    /// The impulse on the robot in the floor's frame, in N s: normal and tangential part.
    pub fn on_robot_n_s(&self) -> (Vector3<f64>, Vector3<f64>) {
        let [normal, along, across] = self.frame;
        let p = &self.impulse;
        (p.x * normal, p.y * along + p.z * across)
    }
}

/// How a velocity follows from the robot's rates, and a unit impulse there goes into its degrees of freedom: those of the
/// chassis, and of up to two joints.
#[derive(Clone, Copy, Debug)]
struct Row {
    chassis: [f64; 6],
    joints: [(usize, f64); 2],
}

impl Row {
    fn dot(&self, rates: impl Fn(usize) -> f64) -> f64 {
        let chassis = self.chassis.iter().enumerate().map(|(i, c)| c * rates(i));
        let joints = self.joints.iter().map(|&(i, c)| c * rates(i));
        chassis.sum::<f64>() + joints.sum::<f64>()
    }
}

/// A hinge, in the floor's frame.
#[derive(Clone, Copy, Debug)]
struct Hinge {
    axis: Vector3<f64>,
    on_axis_m: Vector3<f64>,
    dof: usize,
}

/// A place where a part of the robot is near the ground.
#[derive(Clone, Copy, Debug)]
struct Nearby {
    part: Part,
    at_m: Vector3<f64>,
    gap_m: f64,
    frame: [Vector3<f64>; 3],
    hinges: [Option<Hinge>; 2],
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
        self.part != other.part
            && self.on_its_end
            && self.gap_m >= other.gap_m
            && normal.dot(&other.frame[0]) > 1.0 - 1e-6
            && step_m.abs() < ONE_PLANE_M
    }
}

/// The reactions of the last step, and room for those of the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Reactions {
    nearby: Vec<Nearby>,
    all: Vec<Reaction>,
    before: Vec<Reaction>,
    rows: Vec<Row>,
    problem: ImpulseProblem,
    /// What the unit impulse of each row does to every rate, row by row.
    responses: Vec<Real>,
    change: Vec<f64>,
    displacement: Vec<Real>,
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
            for &(dof, c) in &row.joints {
                impulse[dof] += c as Real;
            }
        }
        solve(&mut self.responses);
        let responses = &self.responses;
        self.problem.set_response(|row, column| {
            self.rows[row].dot(|dof| f64::from(responses[column * dofs + dof]))
        });

        // What acted in the last step is most of what acts in this one.
        let mut row = 0;
        for (i, reaction) in self.all.iter().enumerate() {
            let of_part = |r: &&Reaction| r.part == reaction.part;
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
                row += 1;
            }
        }
    }
}

/// Everything that a step's reactions depend on, as rapier left it.
struct Scene<'a> {
    rapier: &'a PhysicsWorld,
    ground: &'a Ground,
    robot: &'a Robot,
    assembly: &'a Assembly,
    before: &'a State,
    dt_s: f64,
}

impl World {
    /// Solves for the reactions of the step that rapier has just taken without any, and corrects the rates by them.
    pub(super) fn react(&mut self) {
        let scene = Scene {
            rapier: &self.rapier,
            ground: &self.ground,
            robot: &self.robot,
            assembly: &self.assembly,
            before: &self.before,
            dt_s: self.settings.dt_s,
        };
        let reactions = &mut self.reactions;
        reactions.clear();
        scene.gather(reactions);
        let multibody = &self.rapier.multibody_joints[self.assembly.multibody];
        let dofs = multibody.ndofs();
        let rows = reactions.rows.len();
        reactions.solve(dofs, |impulses| {
            let mut impulses = DMatrixViewMut::from_slice(impulses, dofs, rows);
            multibody.inv_augmented_mass().solve_mut(&mut impulses);
        });

        let Reactions {
            change,
            displacement,
            ..
        } = reactions;
        let multibody = self.assembly.multibody_mut(&mut self.rapier);
        let mut rates = multibody.generalized_velocity_mut();
        displacement.clear();
        for (dof, change) in change.iter().enumerate() {
            rates[dof] = (f64::from(rates[dof]) + change) as Real;
            // The chassis is put where it belongs by itself.
            let moved = if dof < 6 {
                0.0
            } else {
                change * self.settings.dt_s
            };
            displacement.push(moved as Real);
        }
        multibody.apply_displacements(displacement);
    }
}

impl Scene<'_> {
    /// Collects all contacts and dry bearings.
    fn gather(&self, reactions: &mut Reactions) {
        let chassis = &self.rapier.bodies[self.assembly.chassis];
        for collider in chassis.colliders() {
            self.find(
                &mut reactions.nearby,
                Part::Chassis,
                *collider,
                [None, None],
            );
        }
        self.touch(reactions);
        for (index, (body, wheel)) in (self.assembly.wheels.iter())
            .zip(&self.robot.wheels)
            .enumerate()
        {
            let floor_from_hub = self.before.floor_from_hub(index);
            let hub = Hinge {
                axis: floor_from_hub.rotation * Vector3::z(),
                on_axis_m: floor_from_hub.translation.vector,
                dof: body.hub_dof,
            };
            self.rub(
                reactions,
                Part::Hub(index),
                hub.dof,
                wheel.joint.friction_n_m,
            );
            for (place, slot) in body.slots.iter().enumerate() {
                let roller = &body.rollers[slot.roller];
                let center_m = roller.hub_from_roller.translation.vector;
                let axle = Hinge {
                    axis: floor_from_hub.rotation * roller.axis_in_hub(),
                    on_axis_m: hub.on_axis_m + floor_from_hub.rotation * center_m,
                    dof: slot.dof,
                };
                let part = Part::Roller(index, place);
                let hinges = [Some(hub), Some(axle)];
                self.find(&mut reactions.nearby, part, slot.collider, hinges);
                let part = Part::Axle(index, place);
                self.rub(reactions, part, slot.dof, roller.friction_n_m);
            }
            self.touch(reactions);
        }
    }

    fn rate(&self, dof: usize) -> f64 {
        self.assembly.rate(self.rapier, dof)
    }

    /// Adds a bearing, if it is a dry one.
    fn rub(&self, reactions: &mut Reactions, part: Part, dof: usize, friction_n_m: f64) {
        if friction_n_m <= 0.0 {
            return;
        }
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
        let row = Row {
            chassis: [0.0; 6],
            joints: [(dof, 1.0), (dof, 0.0)],
        };
        reactions.push(law, reaction, &[row], &[self.rate(dof)]);
    }

    /// Collects where a collider of the robot, which hangs on hinges, is near the ground.
    fn find(
        &self,
        nearby: &mut Vec<Nearby>,
        part: Part,
        collider: ColliderHandle,
        hinges: [Option<Hinge>; 2],
    ) {
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
                let along = hinges[1].map_or_else(Vector3::x, |axle| axle.axis);
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
                    nearby.push(Nearby {
                        part,
                        at_m: self.ground.rapier_origin_m() + in_rapier_m,
                        gap_m: f64::from(point.dist),
                        frame: frame(normal, along),
                        hinges,
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
            let Nearby {
                part,
                at_m,
                gap_m,
                frame,
                hinges,
                ..
            } = *place;
            let rows = frame.map(|direction| self.row(at_m, direction, hinges));
            let free = rows.map(|row| row.dot(|dof| self.rate(dof)));
            let approach_m_s = if gap_m > 0.0 {
                gap_m / self.dt_s
            } else {
                gap_m * push_out_per_s
            };
            if free[0] + approach_m_s > OPEN_M_S {
                continue;
            }
            let friction = self.ground.friction_at(&at_m);
            let law = Law::Contact {
                friction,
                approach_m_s,
                softness,
            };
            let reaction = Reaction {
                part,
                at_m,
                frame,
                friction,
                impulse: Vector3::zeros(),
            };
            reactions.push(law, reaction, &rows, &free);
        }
        reactions.nearby = nearby;
        reactions.nearby.clear();
    }

    /// How the velocity of a place along a direction follows from the robot's rates.
    fn row(&self, at_m: Vector3<f64>, direction: Vector3<f64>, hinges: [Option<Hinge>; 2]) -> Row {
        let center_m = self.before.floor_from_chassis.translation.vector;
        let turn = (at_m - center_m).cross(&direction);
        let about = |hinge: Option<Hinge>| {
            hinge.map_or((0, 0.0), |hinge| {
                let lever_m = at_m - hinge.on_axis_m;
                (hinge.dof, hinge.axis.dot(&lever_m.cross(&direction)))
            })
        };
        Row {
            chassis: [
                direction.x,
                direction.y,
                direction.z,
                turn.x,
                turn.y,
                turn.z,
            ],
            joints: hinges.map(about),
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
