//! Fast rotation on the spot: hand-overs use part of the grip, and the robot turns further than its
//! touching rollers give (docs/slip.md).
//!
//! With its touching roller at phi from straight down, a wheel at (X, Y) with the rate q' gives
//! omega = q' rho cos(phi) / (X + Y cos(phi) + a sin(phi)), with a = rho - r. From the end of one
//! roller to the beginning of the next that jumps by 9 % on robot A. Wheel and new roller adapt
//! within the hand-over, with friction at its limit for a time that grows with the speed and falls
//! with the grip; during that time they do not roll.

use ilon_formats::LoadRobot;
use ilon_robot::Robot;
use ilon_sim::Simulation;
use ilon_sim::scenario::Scenario;

const URDF: &str = include_str!("../../../../../assets/robots/mecanum4.urdf");

/// The excess of robot A's rotation on the spot over that of its touching rollers, in per cent.
fn excess(rate_rad_s: f64, friction: f64, dt_s: f64) -> f64 {
    let text = format!(
        "robot.file = \"\"\nworld.floor.friction = {friction}\n[twist]\nomega_rad_s = {rate_rad_s}\nrest_s = 0.1\nramp_s = 0.5\nsettle_s = 0.4\n\
         [run]\nduration_s = 2.0\nphysics_dt_s = {dt_s:e}\n"
    );
    let scenario = Scenario::from_toml(&text, "spin", "").unwrap();
    let robot = Robot::from_urdf_str(URDF, "mecanum4").unwrap();
    let run = Simulation::with_robot(&scenario, &robot).unwrap().run();
    100.0 * (run.summary.twist_ratio_contact.omega.unwrap() - 1.0)
}

/// Rolling changes by 9 % at each hand-over, and the friction that adapts wheel and robot is
/// limited. So the excess of a rotation is not an error of the step, is the same in both senses,
/// and vanishes as the grip grows or the rotation slows down: both shorten the share of the time in
/// which something slides, and the first also the sliding itself.
#[test]
fn a_fast_turn_gains_what_hand_overs_take_of_the_grip() {
    let usual = excess(4.8, 0.6, 2.5e-4);
    // 0.21 % in steps of 0.25 to 0.05 ms, over 3 s; the shorter interval has other phases at its
    // ends.
    assert!((usual - 0.21).abs() < 0.03, "{usual}");
    let finer = excess(4.8, 0.6, 1.25e-4);
    assert!((usual - finer).abs() < 0.02, "{usual} {finer}");
    let back = excess(-4.8, 0.6, 2.5e-4);
    assert!((usual - back).abs() < 1e-3, "{usual} {back}");
    let (slippery, grips) = (excess(4.8, 0.3, 2.5e-4), excess(4.8, 1.2, 2.5e-4));
    assert!(
        slippery > 2.0 * usual && grips < 0.5 * usual,
        "{slippery} {usual} {grips}"
    );
    let slow = excess(2.4, 0.6, 2.5e-4);
    assert!(slow < 0.25 * usual, "{slow} {usual}");
}
