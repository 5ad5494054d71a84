//! What the program chooses where the scenario leaves it open.

use std::f64::consts::TAU;

use ilon_control::DynamicModel;
use ilon_robot::Robot;

use crate::scenario::{LoopTiming, Rollers, Scenario, WheelLaw};

/// The longest step on an open plane, in seconds. Mean motion is as accurate at 20 steps a second as at 1000, but how a
/// roller starts to slide, and is spun up when it takes over, is smeared over a step (`docs/accuracy.md`).
const LONGEST_ON_A_PLANE_S: f64 = 1.0 / 240.0;
/// Steps that a roller's passage over the ground takes at least: one that is missed altogether is never felt.
const STEPS_PER_PASSAGE: f64 = 6.0;
/// The shortest step that a sampled wheel loop is given for its bandwidth, in seconds; below, its gains give way.
const SHORTEST_FOR_LOOP_S: f64 = 1.0 / 2000.0;

/// The parts in which a step is taken while a roller is about to slide, in seconds: what a fast turn on the edge of its grip
/// loses to slip is then within a tenth of its limit (`docs/accuracy.md`).
const SPLIT_DT_S: f64 = 1e-4;

/// The parts in which a step is taken for `"auto"` while a roller is near its grip; none where edges and bumps decide.
pub(super) fn split_dt_s(scenario: &Scenario) -> Option<f64> {
    is_open_plane(scenario).then_some(SPLIT_DT_S)
}

/// Whether exact rollers roll on nothing but a plane.
fn is_open_plane(scenario: &Scenario) -> bool {
    let floor = &scenario.world.floor;
    let round = scenario.robot.rollers == Rollers::Barrel;
    round && floor.boxes.is_empty() && floor.rough.is_none()
}

/// The physics step for `"auto"`, in seconds: the longest that serves the contacts, the passing of the rollers and the
/// wheel loop, shortened to divide the control period.
pub(super) fn physics_dt_s(scenario: &Scenario, robot: &Robot, model: &DynamicModel) -> f64 {
    let longest_s = contact_s(scenario, robot).min(loop_s(scenario, model));
    let control_dt_s = scenario.run.control_dt_s;
    // A part in 10^9 keeps a period that is a whole number of steps but for rounding from taking one more.
    let steps = (control_dt_s / longest_s - 1e-9).ceil().max(1.0);
    control_dt_s / steps
}

/// What the contacts allow: the world's measured default, and longer steps for exact rollers on an open plane where the
/// wheels' rates are bounded.
fn contact_s(scenario: &Scenario, robot: &Robot) -> f64 {
    let default_s = ilon_world::Settings::default().dt_s;
    let limit_rad_s = scenario
        .guidance
        .wheel_rate_limit_rad_s
        .unwrap_or(f64::INFINITY)
        .min(robot.wheel_rate_limit_rad_s());
    let rollers = robot.wheels.iter().map(|wheel| wheel.rollers.len()).max();
    let passage_s = TAU / (rollers.unwrap_or(1) as f64 * limit_rad_s);
    let longest_s = if is_open_plane(scenario) && limit_rad_s.is_finite() {
        LONGEST_ON_A_PLANE_S
    } else {
        default_s
    };
    if limit_rad_s.is_finite() {
        longest_s.min(passage_s / STEPS_PER_PASSAGE)
    } else {
        longest_s
    }
}

/// What the wheel loop allows. A PID that is sampled once a step must leave a wheel in the air in peace: k_p dt <= J_air.
/// Computed torque is sampled too: a bandwidth w needs w dt of a tenth or so to be what it says.
fn loop_s(scenario: &Scenario, model: &DynamicModel) -> f64 {
    let wheel_loop = &scenario.wheel_loop;
    match (wheel_loop.law, wheel_loop.timing) {
        (WheelLaw::Pid, LoopTiming::Continuous) => f64::INFINITY,
        (WheelLaw::Pid, LoopTiming::Sampled) => {
            let asked_n_m_s = model.ground_inertia_kg_m2() * wheel_loop.bandwidth_rad_s;
            let proportional_n_m_s = wheel_loop.proportional_n_m_s.unwrap_or(asked_n_m_s);
            (model.air_inertia_kg_m2() / proportional_n_m_s).max(SHORTEST_FOR_LOOP_S)
        }
        _ => 0.12 / wheel_loop.bandwidth_rad_s,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen_s(lines: &str) -> f64 {
        let urdf = include_str!("../../../../assets/robots/mecanum4.urdf");
        let robot = Robot::from_urdf_str(urdf, "mecanum4").unwrap();
        let text = format!("robot.file = \"\"\ntwist = {{}}\nrun.duration_s = 1.0\n{lines}");
        let scenario = Scenario::from_toml(&text, "test", "").unwrap();
        let model = super::super::drive::dynamic_model(&robot).unwrap();
        physics_dt_s(&scenario, &robot, &model)
    }

    #[test]
    fn the_chosen_step_divides_the_control_period_and_is_no_longer_than_the_longest() {
        for control_dt_s in [0.01, 1.0 / 30.0, 0.0007, 0.0123] {
            let dt_s = chosen_s(&format!("run.control_dt_s = {control_dt_s}"));
            let steps = control_dt_s / dt_s;
            assert!((steps - steps.round()).abs() < 1e-9 * steps);
            assert!(dt_s <= LONGEST_ON_A_PLANE_S * (1.0 + 1e-9));
        }
    }

    #[test]
    fn on_a_plane_the_step_follows_the_rollers_that_pass() {
        let slow = "run.control_dt_s = 0.1\n";
        // Nine rollers at 10 rad/s: one passes in 2 pi / 90 = 69.8 ms, a sixth of which is longer than 1/240 s; at the
        // motors' 30 rad/s a sixth is 3.88 ms. 24 and 26 steps a control period.
        let at = |limit_rad_s: f64| {
            chosen_s(&format!(
                "{slow}guidance.wheel_rate_limit_rad_s = {limit_rad_s}"
            ))
        };
        assert!((at(10.0) - 0.1 / 24.0).abs() < 1e-12);
        assert!((at(100.0) - 0.1 / 26.0).abs() < 1e-12);
        // On a kerb, and under rollers as modelled, it is the step that holds for contacts of all kinds.
        let kerb = "world.floor.boxes = [{ x_m = 1.0, y_m = 0.0, length_x_m = 0.1, length_y_m = 1.0, height_m = 0.01 }]\n";
        assert!((chosen_s(&format!("{slow}{kerb}")) - 0.002).abs() < 1e-12);
        let modelled = "robot.rollers = \"as_modelled\"\n";
        assert!((chosen_s(&format!("{modelled}{slow}")) - 0.002).abs() < 1e-12);
    }

    #[test]
    fn a_sampled_loop_gets_a_step_that_leaves_a_wheel_in_the_air_stable() {
        let sampled = "wheel_loop.timing = \"sampled\"\n";
        // Half a millisecond is the least; a soft loop of 5 rad/s needs no shorter step than the contacts.
        assert!((chosen_s(sampled) - 0.01 / 18.0).abs() < 1e-4);
        let soft = format!("{sampled}wheel_loop.bandwidth_rad_s = 5.0");
        assert!((chosen_s(&soft) - 0.01 / 3.0).abs() < 1e-12);
    }
}
