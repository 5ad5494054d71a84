//! What is kept of bodies of a program's own from step to step.

use ilon_robot::Pose as PlanarPose;
use nalgebra::Vector3;
use rapier3d::prelude::*;

use super::{World, shipped};
use crate::{Floor, Settings};

/// A body that sleeps beside a robot is a guest in each step, with its four places on the floor: no more than these are kept.
#[test]
fn what_is_kept_of_a_body_that_sleeps_does_not_grow() {
    let robot = shipped("mecanum4");
    let (floor, settings) = (Floor::default(), Settings::default());
    let mut world =
        World::new(&robot, &floor, PlanarPose::default(), &settings).expect("it stands on a plane");
    let (from_m, back) = (Vector3::new(1.0, 0.0, 0.05), -Vector3::x());
    let front = world.cast_ray(from_m, back, 1.0).expect("the robot");
    let rapier = world.rapier_mut().expect("ilon solves the contacts");
    // Half a millimetre before the robot, which is near.
    let x_m = front.place_m.x as f32 + 0.0505;
    let place = RigidBodyBuilder::dynamic().translation(Vector::new(x_m, 0.0, 0.05));
    rapier.insert(place, ColliderBuilder::cuboid(0.05, 0.05, 0.05).mass(1.0));
    let (mut asleep, mut beside) = (0, 0);
    for _ in 0..3000 {
        world.step();
        let rapier = world.rapier.as_ref().expect("it was asked for");
        assert!(rapier.kept() <= 8, "{} contacts", rapier.kept());
        beside += usize::from(rapier.kept() > 0);
        asleep += usize::from(rapier.is_at_rest());
    }
    assert!(
        asleep > 500 && beside > 500,
        "it slept in {asleep} steps, beside in {beside}"
    );
}
