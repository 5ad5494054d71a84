//! One step of the world: time and allocations, for three robots driving sideways.

use divan::{AllocProfiler, Bencher};
use ilon_formats::LoadRobot;
use ilon_robot::{Pose, Robot};
use ilon_world::{Floor, GroundBox, Relief, RollerBodies, Settings, World};
use nalgebra::{Vector2, Vector3};

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

/// On a plate as a box, on the same plate as heights, on bars as boxes, and on waves as heights.
/// The first two have the same contacts.
#[divan::bench(args = ["box", "heights", "bars", "waves"])]
fn ground(bencher: Bencher, ground: &str) {
    let plate = |center_x_m: f64, half_x_m: f64, height_m: f64| GroundBox {
        center_m: Vector3::new(center_x_m, 0.0, 0.0),
        half_sides_m: Vector3::new(half_x_m, 3.0, height_m),
        heading_rad: 0.0,
        pitch_rad: 0.0,
    };
    let heights = |height_m: &dyn Fn(f64, f64) -> f64| {
        let at_m = |index: i32| 0.02 * f64::from(index - 150);
        let row = |row| (0..301).map(move |column| height_m(at_m(column), at_m(row)));
        Some(Relief {
            cell_m: 0.02,
            center_m: Vector2::zeros(),
            heights_m: (0..301).map(|of| row(of).collect()).collect(),
        })
    };
    let mut floor = Floor::default();
    match ground {
        "box" => floor.boxes.push(plate(0.0, 3.0, 0.01)),
        "heights" => floor.relief = heights(&|_, _| 0.01),
        "bars" => {
            let bars = (-30..30).map(|bar| plate(0.1 * f64::from(bar), 0.005, 0.002));
            floor.boxes.extend(bars);
        }
        _ => {
            floor.relief = heights(&|x, y| 0.001 * ((20.0 * x).sin() + (13.0 * y + 5.0 * x).sin()))
        }
    }
    drive(bencher, "mecanum4", RollerBodies::Near, &floor);
}

fn bench(bencher: Bencher, robot: &str, roller_bodies: RollerBodies) {
    drive(bencher, robot, roller_bodies, &Floor::default());
}

/// Steps of 1 ms of a robot that turns its wheels against each other with a proportional loop,
/// after a second of warm-up.
fn drive(bencher: Bencher, robot: &str, roller_bodies: RollerBodies, floor: &Floor) {
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
    let mut world =
        World::new(&robot, floor, start, &settings).expect("a shipped robot stands there");
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
