//! One step of the world: time, and what it asks of the allocator, for three robots driving sideways.

use divan::{AllocProfiler, Bencher};
use ilon_formats::LoadRobot;
use ilon_robot::{Pose, Robot};
use ilon_world::{Floor, RollerBodies, Settings, World};

#[global_allocator]
static ALLOCATOR: AllocProfiler = AllocProfiler::system();

const ROBOTS: [&str; 3] = ["volksbot", "mecanum4", "mecanum6"];

fn main() {
    divan::main();
}

/// With the shapes of all rollers in the world.
#[divan::bench(args = ROBOTS)]
fn all(bencher: Bencher, robot: &str) {
    bench(bencher, robot, RollerBodies::All);
}

/// With the shapes of the rollers near the ground.
#[divan::bench(args = ROBOTS)]
fn near(bencher: Bencher, robot: &str) {
    bench(bencher, robot, RollerBodies::Near);
}

/// Steps of 1 ms of a robot that turns its wheels against each other by a proportional loop, after a second of warm-up.
fn bench(bencher: Bencher, robot: &str, roller_bodies: RollerBodies) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/robots");
    let robot = Robot::load(format!("{folder}/{robot}.urdf")).expect("a shipped robot loads");
    let settings = Settings {
        dt_s: 1e-3,
        roller_bodies,
        ..Settings::default()
    };
    let start = Pose {
        heading_rad: 0.35,
        ..Pose::default()
    };
    let mut world = World::new(&robot, &Floor::default(), start, &settings)
        .expect("a shipped robot stands on a plane");
    let mut torques_n_m = vec![0.0; robot.wheels.len()];
    let mut step = || {
        for (i, torque_n_m) in torques_n_m.iter_mut().enumerate() {
            let asked_rad_s = if i % 2 == 0 { 4.0 } else { -4.0 };
            *torque_n_m = 0.05 * (asked_rad_s - world.robot().wheel_rates_rad_s()[i]);
        }
        world.robot_mut().apply(&torques_n_m);
        world.step();
    };
    for _ in 0..1000 {
        step();
    }
    bencher.bench_local(step);
}
