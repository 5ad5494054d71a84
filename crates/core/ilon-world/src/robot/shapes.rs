//! The parts of a robot whose contacts with the ground are found by parry: its chassis, bodies on
//! joints, and rollers with the shapes of their file.

use std::cell::RefCell;

use ilon_robot::MassProperties;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use crate::ContactSolver;
use crate::contact::search::solid::Solid;
use crate::engine::{convert, groups};
use crate::ground::{self, Ground};
use crate::robot::shared_robot::{BodyShape, SharedRobot};
use crate::robot::state::State;
use crate::robot::wheel::WheelBody;

/// The shapes of a robot near the ground.
///
/// The search uses a rapier world that is created once something of the robot comes near the
/// ground: a robot that stays on its wheels needs none.
#[derive(Clone, Default)]
pub(crate) struct Shapes {
    near: Option<Box<Near>>,
    is_near: bool,
}

/// The robot and the ground in rapier.
#[derive(Clone)]
struct Near {
    colliders: ColliderSet,
    broad_phase: BroadPhaseBvh,
    narrow_phase: NarrowPhase,
    /// The chassis and bodies on joints, in the order of the robot's shapes.
    bodies: Vec<ColliderHandle>,
    /// Each with its wheel and its index on it.
    rollers: Vec<(ColliderHandle, usize, usize)>,
}

/// rapier's work space for the search, and sets of objects that no world here has.
struct Room {
    pipeline: CollisionPipeline,
    islands: IslandManager,
    bodies: RigidBodySet,
}

thread_local! {
    static ROOM: RefCell<Room> = RefCell::new(Room {
        pipeline: CollisionPipeline::new(),
        islands: IslandManager::new(),
        bodies: RigidBodySet::new(),
    });
}

/// A robot's parts in their poses, and the ground.
#[derive(Clone, Copy)]
pub(crate) struct Placed<'a> {
    pub robot: &'a SharedRobot,
    pub chassis_mass: &'a MassProperties,
    pub wheels: &'a [WheelBody],
    pub state: &'a State,
    pub ground: &'a Ground,
    /// Contacts further from the ground than this are ignored, in metres.
    pub within_m: f64,
}

impl Shapes {
    /// Finds the places near the ground.
    pub fn find(&mut self, placed: &Placed<'_>) {
        self.is_near = placed.has_modelled_rollers() || placed.bodies_are_near();
        if self.is_near {
            let near = self.near.get_or_insert_with(|| Box::new(Near::new(placed)));
            near.find(placed);
        }
    }

    /// Passes the places where the chassis and bodies on joints are near the ground to `show`: the
    /// body's joint, the point on the ground, the normal out of it, and the distance.
    pub fn of_bodies(
        &self,
        robot: &SharedRobot,
        mut show: impl FnMut(&BodyShape, Vector3<f64>, Vector3<f64>, f64),
    ) {
        if let Some(near) = self.near.as_ref().filter(|_| self.is_near) {
            for (collider, of) in near.bodies.iter().zip(robot.shapes()) {
                near.show(*collider, &mut |place_m, normal, gap_m| {
                    show(of, place_m, normal, gap_m)
                });
            }
        }
    }

    /// The same for the rollers of a wheel, each with its index.
    pub fn of_rollers(
        &self,
        wheel: usize,
        mut show: impl FnMut(usize, Vector3<f64>, Vector3<f64>, f64),
    ) {
        if let Some(near) = self.near.as_ref().filter(|_| self.is_near) {
            let of_wheel = near.rollers.iter().filter(|(_, of, _)| *of == wheel);
            for (collider, _, roller) in of_wheel {
                near.show(*collider, &mut |place_m, normal, gap_m| {
                    show(*roller, place_m, normal, gap_m)
                });
            }
        }
    }
}

impl Placed<'_> {
    fn has_modelled_rollers(&self) -> bool {
        let mut rollers = self.wheels.iter().flat_map(|wheel| &wheel.rollers);
        rollers.any(|roller| roller.shape.is_some())
    }

    /// The shapes of chassis and bodies on joints with their poses in the floor's frame.
    fn shapes(&self) -> impl Iterator<Item = (Isometry3<f64>, &SharedShape)> {
        let center_m = self.chassis_mass.center_of_mass_m;
        let shapes = self.robot.shapes().iter();
        shapes.map(move |of| {
            let floor_from_carrier = self.state.carrier(of.joint, &center_m);
            (floor_from_carrier * of.carrier_from_shape, &of.shape)
        })
    }

    /// Whether the bounding boxes of these shapes reach the ground.
    fn bodies_are_near(&self) -> bool {
        self.shapes().any(|(floor_from_shape, shape)| {
            let solid = Solid {
                shape,
                floor_from_shape,
            };
            self.ground.reaches(&solid.bounds().grown(self.within_m))
        })
    }
}

impl Near {
    fn new(placed: &Placed<'_>) -> Self {
        let mut colliders = ColliderSet::new();
        ground::insert_into(placed.ground, &mut colliders, ContactSolver::Ilon);
        let mut insert = |shape: &SharedShape, groups: InteractionGroups| {
            colliders.insert(
                ColliderBuilder::new(shape.clone())
                    // Nothing here is a body of rapier, which moves none of it.
                    .active_collision_types(ActiveCollisionTypes::all())
                    .collision_groups(groups)
                    .solver_groups(InteractionGroups::none()),
            )
        };
        let bodies = placed.robot.shapes().iter();
        let bodies = bodies
            .map(|of| insert(&of.shape, groups::CHASSIS))
            .collect();
        let mut rollers = Vec::new();
        for (wheel, body) in placed.wheels.iter().enumerate() {
            for (index, roller) in body.rollers.iter().enumerate() {
                if let Some(shape) = &roller.shape {
                    rollers.push((insert(shape, groups::ROLLER), wheel, index));
                }
            }
        }
        Self {
            colliders,
            broad_phase: BroadPhaseBvh::new(),
            narrow_phase: NarrowPhase::new(),
            bodies,
            rollers,
        }
    }

    /// Places everything, and runs rapier's search.
    fn find(&mut self, placed: &Placed<'_>) {
        let mut place = |collider: ColliderHandle, floor_from_shape: &Isometry3<f64>| {
            if let Some(collider) = self.colliders.get_mut(collider) {
                collider.set_position(convert::pose(floor_from_shape));
            }
        };
        for (collider, (floor_from_shape, _)) in self.bodies.iter().zip(placed.shapes()) {
            place(*collider, &floor_from_shape);
        }
        for (collider, wheel, roller) in &self.rollers {
            let hub = &placed.state.hubs()[*wheel];
            let rotation = UnitQuaternion::from_matrix(&hub.rotation);
            let floor_from_hub = Isometry3::from_parts(hub.center_m.into(), rotation);
            let roller = &placed.wheels[*wheel].rollers[*roller];
            let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), roller.angle_rad);
            place(
                *collider,
                &(floor_from_hub * roller.hub_from_roller * turned),
            );
        }
        ROOM.with_borrow_mut(|room| {
            room.pipeline.step(
                placed.within_m,
                &mut room.islands,
                &mut self.broad_phase,
                &mut self.narrow_phase,
                &mut room.bodies,
                &mut self.colliders,
                &(),
                &(),
            );
        });
    }

    /// Passes the places where a collider is near the ground to `show`.
    fn show(
        &self,
        collider: ColliderHandle,
        show: &mut impl FnMut(Vector3<f64>, Vector3<f64>, f64),
    ) {
        for pair in self.narrow_phase.contact_pairs_with(collider) {
            let is_first = pair.collider1 == collider;
            let ground = if is_first {
                pair.collider2
            } else {
                pair.collider1
            };
            let rapier_from_ground = self.colliders[ground].position();
            for manifold in pair.manifolds() {
                // A manifold's normal points from its first shape to its second.
                let towards_second = convert::to_vector(manifold.data.normal);
                let normal = if is_first {
                    -towards_second
                } else {
                    towards_second
                };
                for point in &manifold.points {
                    let on_ground = if is_first {
                        point.local_p2
                    } else {
                        point.local_p1
                    };
                    let place_m = convert::to_vector(*rapier_from_ground * on_ground);
                    show(place_m, normal, point.dist);
                }
            }
        }
    }
}
