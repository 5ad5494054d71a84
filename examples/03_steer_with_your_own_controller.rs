//! A custom controller in place of the guidance: a plain proportional law, judged on the same
//! circle.

use ilon::robot::{Twist, wrap_angle};
use ilon::simulate::{Commanded, Controller, Moment, Simulation};

struct Proportional {
    gain_per_s: f64,
}

impl Controller for Proportional {
    fn command(&mut self, now: &Moment<'_>, wheels: &mut [f64]) -> Commanded {
        if let Some(desired) = now.desired {
            let (goal, here) = (desired.pose, now.seen.pose);
            let error_in_world = Twist::new(
                goal.x_m - here.x_m,
                goal.y_m - here.y_m,
                wrap_angle(goal.heading_rad - here.heading_rad),
            );
            let twist_in_body = error_in_world
                .scaled(self.gain_per_s)
                .rotated(-here.heading_rad);
            now.kinematics.wheel_rates(twist_in_body, wheels);
        }
        Commanded::Rates
    }
}

fn main() -> Result<(), ilon::Error> {
    let mut scenario = ilon::Scenario::load("assets/scenarios/mecanum4_circle.toml")?;
    scenario.run.duration_s = 20.0;
    let controller = Proportional { gain_per_s: 1.0 };
    let run = Simulation::with_controller(&scenario, controller)?.run();

    // Without feedforward the robot trails the reference by speed / gain: 0.2 m/s over 1/s.
    let off_m = run.summary.position_error_final_m.unwrap_or(f64::NAN);
    println!("trails the circle by {off_m:.3} m");
    assert!((off_m - 0.2).abs() < 0.02);
    Ok(())
}
