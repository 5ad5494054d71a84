//! What a world asks of the allocator: a file of its own, because it counts for the whole process.

use std::alloc::System;

use ilon_robot::{Pose, Robot};
use ilon_world::{Floor, RollerBodies, Settings, SharedRobot, World};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

fn kept_bytes(region: &Region<'_, System>) -> isize {
    let change = region.change();
    change.bytes_allocated as isize - change.bytes_deallocated as isize + change.bytes_reallocated
}

/// A world of a robot that is shared.
#[test]
fn worlds_of_a_shared_robot_are_small() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../assets/robots/mecanum4.urdf"
    );
    let robot = Robot::load(path).expect("a shipped robot");
    let shared = SharedRobot::from(&robot);
    let settings = Settings {
        dt_s: 1.0 / 240.0,
        roller_bodies: RollerBodies::Near,
        ..Settings::default()
    };
    let region = Region::new(ALLOCATOR);
    let world = World::new(&shared, &Floor::default(), Pose::default(), &settings);
    let mut world = world.expect("a robot on a plane");
    println!("built {}", kept_bytes(&region));
    for _ in 0..300 {
        world.apply(&[0.1, -0.1, -0.1, 0.1]);
        world.step();
    }
    println!("stepped {} + {}", kept_bytes(&region), size_of::<World>());
}
