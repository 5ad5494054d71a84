//! What the motors of wheels give.

use ilon_world::World;

/// The power that the motor of each wheel gave in the last step, in W; negative where it braked.
pub(super) fn motor_powers_w(world: &World) -> impl Iterator<Item = f64> {
    let robot = world.robot();
    let rates_rad_s = robot.wheel_rates_rad_s().iter();
    let torques_n_m = robot.motor_torques_n_m().iter();
    torques_n_m
        .zip(rates_rad_s)
        .map(|(torque_n_m, rate_rad_s)| torque_n_m * rate_rad_s)
}
