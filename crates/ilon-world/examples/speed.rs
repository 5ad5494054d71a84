//! Temporary.
use ilon_formats::LoadRobot;
use ilon_robot::{Pose, Robot};
use ilon_world::{Floor, GroundBox, Relief, RollerBodies, Settings, World};
use nalgebra::{Vector2, Vector3};
fn main() {
    let ground = std::env::args().nth(1).unwrap();
    let steps: usize = std::env::args().nth(2).unwrap().parse().unwrap();
    let plate = |center_x_m: f64, half_x_m: f64, height_m: f64| GroundBox {
        center_m: Vector3::new(center_x_m, 0.0, 0.0),
        half_sides_m: Vector3::new(half_x_m, 3.0, height_m),
        heading_rad: 0.0,
        pitch_rad: 0.0,
    };
    let cell = std::env::args().nth(3).map_or(0.02, |c| c.parse().unwrap());
    let n = (3.0 / cell) as i32;
    let heights = |height_m: &dyn Fn(f64, f64) -> f64| {
        let at_m = |index: i32| cell * f64::from(index - n);
        let row = |row| (0..2*n+1).map(move |column| height_m(at_m(column), at_m(row)));
        Some(Relief {
            cell_m: cell,
            center_m: Vector2::zeros(),
            heights_m: (0..2*n+1).map(|of| row(of).collect()).collect(),
        })
    };
    let mut floor = Floor::default();
    match &*ground {
        "plane" => {}
        "box" => floor.boxes.push(plate(0.0, 3.0, 0.01)),
        "heights" => floor.relief = heights(&|_, _| 0.01),
        "bars" => {
            let bars = (-30..30).map(|bar| plate(0.1 * f64::from(bar), 0.005, 0.002));
            floor.boxes.extend(bars);
        }
        "hill" => floor.relief = heights(&|x, y| 0.004 * ((20.0 * x).sin() + (13.0 * y + 5.0 * x).sin()) + if x > 2.0 {0.3} else {0.0}),
        _ => floor.relief = heights(&|x, y| 0.004 * ((20.0 * x).sin() + (13.0 * y + 5.0 * x).sin())),
    }
    let robot = Robot::load("assets/robots/mecanum4.urdf").unwrap();
    let settings = Settings { dt_s: 1e-3, roller_bodies: RollerBodies::Near, ..Settings::default() };
    let mut world = World::new(&robot, &floor, Pose { heading_rad: 0.35, ..Pose::default() }, &settings).unwrap();
    let mut torques_n_m = vec![0.0; 4];
    let mut hash = 0u64; let mut n_step = 0;
    let mut one = || {
        for (i, torque_n_m) in torques_n_m.iter_mut().enumerate() {
            let asked_rad_s = if i % 2 == 0 { 4.0 } else { -4.0 };
            *torque_n_m = 0.05 * (asked_rad_s - world.robot().wheel_rates_rad_s()[i]);
        }
        world.robot_mut().apply(&torques_n_m);
        world.step();
        n_step += 1;
        if std::env::var("SHOW").is_ok() && (n_step < 20 || n_step % 100 == 0) { let r = world.robot(); println!("{n_step} {:?} {:.17} {:?}", r.state().pose, r.state().height_m, r.contacts().iter().map(|c| (c.normal_force_n, c.touching_rollers)).collect::<Vec<_>>()); }
        let s = world.robot().state();
        for x in [s.pose.x_m, s.pose.y_m, s.height_m, s.pitch_rad, s.pose.heading_rad] { hash = hash.rotate_left(7) ^ x.to_bits().wrapping_mul(0x9E3779B97F4A7C15); }
    };
        for k in 0..1000 { one();  }
    let start = std::time::Instant::now();
    for _ in 0..steps { one(); }
    println!("{ground}: {:.2} us/step, hash {hash:x}, {:?}", start.elapsed().as_secs_f64() / steps as f64 * 1e6, world.robot().state().pose);
}
