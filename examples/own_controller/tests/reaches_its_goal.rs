//! Tests the controller on a simulated robot with real rollers: that it arrives, and that it keeps
//! its speed limit.

use ilon::simulate::{Commanded, Controller, Moment, Simulation};
use own_controller::{GoToGoal, Pose};

/// Implements ilon's controller trait.
struct InIlon(GoToGoal);

impl Controller for InIlon {
    fn command(&mut self, now: &Moment<'_>, wheels: &mut [f64]) -> Commanded {
        let here = Pose {
            x: now.seen.pose.x_m,
            y: now.seen.pose.y_m,
            heading: now.seen.pose.heading_rad,
        };
        wheels.copy_from_slice(&self.0.wheel_rates(here));
        Commanded::Rates
    }
}

const SCENARIO: &str = r#"
[robot]
file = "../../assets/robots/mecanum4.urdf"
heading_deg = 60

[reference.hold_pose] # what the summary measures against
x_m = 1.0
y_m = 0.5
heading_deg = 0

[sensors.pose] # a camera: 30 pictures a second, 50 ms late, 2 mm of noise
rate_hz = 30
latency_s = 0.05
position_noise_m = 0.002

[run]
duration_s = 12
"#;

#[test]
fn it_arrives_and_keeps_to_its_speed() -> Result<(), ilon::Error> {
    let scenario = ilon::Scenario::from_toml(SCENARIO, "go to goal", env!("CARGO_MANIFEST_DIR"))?;
    let controller = GoToGoal {
        goal: Pose {
            x: 1.0,
            y: 0.5,
            heading: 0.0,
        },
        arm: 0.15 + 0.16,
        wheel_radius: 0.05,
        top_speed: 0.4,
    };
    let run = Simulation::with_controller(&scenario, InIlon(controller))?.run();

    // Noise of 2 mm and a gain of 1/s leave less than that; 1 cm is the tolerance of a docking
    // station.
    let off_m = run.summary.position_error_final_m.unwrap_or(f64::INFINITY);
    assert!(off_m < 0.01, "{off_m} m off the goal");
    for record in run.trace.records() {
        let speed_m_s = record.truth.twist_in_body.linear_m_s().norm();
        // From rest the rates are commanded in one step, to which a critically damped PI responds
        // with an overshoot of e^-2 = 13.5 %; the rest is for camera noise.
        assert!(speed_m_s < 1.2 * 0.4, "{speed_m_s} m/s at {} s", record.t_s);
    }
    Ok(())
}
