//! A robot stepped from outside, without the loop of a run. Every tenth of a second it tries
//! several motions on copies of itself, with all rollers and contacts, and takes the one that ends
//! nearest to its goal.

use ilon::robot::Twist;
use ilon::simulate::{Plant, WheelCommand, load_robot, resolve};
use nalgebra::Vector2;

const GOAL_M: Vector2<f64> = Vector2::new(0.6, 0.4);
const PERIOD_S: f64 = 0.1;
/// The look-ahead, in periods.
const AHEAD: usize = 3;

fn main() -> Result<(), ilon::Error> {
    let scenario = ilon::Scenario::load("assets/scenarios/mecanum4_lateral.toml")?;
    let robot = load_robot(&scenario)?;
    let mut plant = Plant::new(&resolve(&scenario, &robot)?, &robot)?;

    // Eight directions at 0.3 m/s, the same slowly, and standing still.
    let directions = (0..8).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_4);
    let mut motions: Vec<Twist> = directions
        .flat_map(|angle| [0.3, 0.06].map(|speed| (speed, angle)))
        .map(|(speed, angle)| Twist::new(speed * angle.cos(), speed * angle.sin(), 0.0))
        .collect();
    motions.push(Twist::default());

    let off_m = |plant: &Plant| (plant.truth().pose.position_m() - GOAL_M).norm();
    let mut rates_rad_s = vec![0.0; robot.wheels.len()];
    for _ in 0..40 {
        let here = plant.snapshot();
        let mut best = (f64::INFINITY, Twist::default());
        for motion in &motions {
            plant.kinematics().wheel_rates(*motion, &mut rates_rad_s);
            plant.advance(WheelCommand::Rates(&rates_rad_s), AHEAD as f64 * PERIOD_S)?;
            if off_m(&plant) < best.0 {
                best = (off_m(&plant), *motion);
            }
            plant.restore(&here)?;
        }
        plant.kinematics().wheel_rates(best.1, &mut rates_rad_s);
        plant.advance(WheelCommand::Rates(&rates_rad_s), PERIOD_S)?;
    }
    println!("ends {:.0} mm off its goal", 1e3 * off_m(&plant));
    // The slow motions move 18 mm within the look-ahead: half of that is their resolution.
    assert!(off_m(&plant) < 0.018);
    Ok(())
}
