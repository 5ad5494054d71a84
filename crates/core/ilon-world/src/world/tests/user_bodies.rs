//! The stored data of user bodies from step to step.

use ilon_robot::Pose as PlanarPose;
use rapier3d::prelude::*;

use super::{World, shipped};
use crate::{Floor, Settings, WorldObject};

/// A body beside a robot is coupled to each step, with its four contacts on the floor: no more than
/// these are kept.
#[test]
fn what_is_kept_of_a_body_beside_a_robot_does_not_grow() {
    let robot = shipped("mecanum4");
    let (floor, settings) = (Floor::default(), Settings::default());
    let mut world =
        World::new(&robot, &floor, PlanarPose::default(), &settings).expect("it stands on a plane");
    let mut front_m = 0.0_f64;
    world.each_part(|object, part| {
        if matches!(object, WorldObject::Robot(_)) {
            front_m = front_m.max(part.bounds().most_m.x);
        }
    });
    let rapier = world.rapier_mut().expect("ilon solves the contacts");
    // Half a millimetre before the robot, which counts as near.
    let x_m = front_m + 0.0505;
    let place = RigidBodyBuilder::dynamic().translation(Vector::new(x_m, 0.0, 0.05));
    rapier.insert(place, ColliderBuilder::cuboid(0.05, 0.05, 0.05).mass(1.0));
    let mut beside = 0;
    for _ in 0..3000 {
        world.step();
        let rapier = world.user_bodies.as_ref().expect("it was asked for");
        assert!(rapier.kept() <= 8, "{} contacts", rapier.kept());
        beside += usize::from(rapier.kept() > 0);
    }
    assert!(beside > 500, "it was beside in {beside} steps");
}
