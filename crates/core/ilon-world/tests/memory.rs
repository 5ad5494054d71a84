//! The memory of a world: a test binary of its own, because the allocator is counted for the whole
//! process.

use std::alloc::System;

use ilon_formats::LoadRobot;
use ilon_robot::{Pose, Robot};
use ilon_world::{Floor, RollerBodies, Settings, SharedRobot, World};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// A world after some steps, and the bytes that it keeps.
fn driven(build: impl FnOnce() -> World) -> (World, usize) {
    let region = Region::new(ALLOCATOR);
    let mut world = build();
    for _ in 0..300 {
        world.robot_mut().apply(&[0.1, -0.1, -0.1, 0.1]);
        world.step();
    }
    let change = region.change();
    let kept = change.bytes_allocated - change.bytes_deallocated;
    (world, kept + size_of::<World>())
}

/// Worlds of a shared robot keep only their states; the robot's constant parts exist once. A world
/// built from an unshared robot has those too: 36 rollers of 7 + 3 + 4 + 4 numbers and more, and
/// their names.
#[test]
fn worlds_of_a_shared_robot_keep_what_changes_alone() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/mecanum4.urdf"
    );
    let robot = Robot::load(path).expect("a shipped robot");
    let shared = SharedRobot::from(&robot);
    let settings = Settings {
        dt_s: 1.0 / 240.0,
        roller_bodies: RollerBodies::Near,
        ..Settings::default()
    };
    let (floor, start) = (Floor::default(), Pose::default());
    let (first, of_its_own) = driven(|| World::new(&robot, &floor, start, &settings).unwrap());
    let (second, of_shared) = driven(|| World::new(&shared, &floor, start, &settings).unwrap());
    println!("{of_its_own} bytes, {of_shared} of a shared robot");
    assert_eq!(first.robot().state(), second.robot().state());
    assert!(of_its_own > of_shared + 36 * 18 * size_of::<f64>());
    // Half of it are the states of 36 rollers. The solver belongs to the thread, and there is no
    // rapier world while the chassis stays off the ground.
    assert!(of_shared < 20_000, "{of_shared}");
}
