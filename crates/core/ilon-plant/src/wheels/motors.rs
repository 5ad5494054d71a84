//! The motors of a scenario's robot.

use ilon_control::{DcMotor, Motor, MotorCurve};
use ilon_robot::Robot;

use ilon_scenario::Error;
use ilon_scenario::robot::wheel_index;
use ilon_scenario::scenario::Scenario;

/// The motors of a scenario's robot.
pub(crate) fn motors(scenario: &Scenario, robot: &Robot) -> Result<Vec<Motor>, Error> {
    let curve = match scenario.motors.dc {
        Some(dc) => MotorCurve::dc(DcMotor {
            stall_torque_n_m: dc.stall_torque_n_m,
            no_load_rate_rad_s: dc.no_load_rate_rad_s,
            current_limit_n_m: dc.current_limit_n_m.unwrap_or(f64::INFINITY),
            regenerates: dc.regeneration,
        })?,
        None => MotorCurve::Flat,
    };
    let wheels = robot.wheels.iter();
    let motors: Result<Vec<Motor>, _> = wheels
        .map(|wheel| Motor::new(&wheel.motor, curve))
        .collect();
    let mut motors = motors?;
    for (name, strength) in &scenario.motors.wheels {
        let motor = &mut motors[wheel_index(name, robot, "`motors.wheels` is")?];
        *motor = motor.with_strength([strength.forwards, strength.backwards])?;
    }
    Ok(motors)
}
