//! Choices of the program where a scenario leaves them open (steps, gains, contacts), checks of
//! loops and wheels before a run, and [`Resolved`].

pub mod bearing_drag;
pub mod defaults;
pub mod loop_stability;
mod resolved;
pub mod stability;
pub mod wheel_loop;
pub mod wheels_to_spare;

use ilon_control::WrongHands;
use ilon_robot::Robot;

pub use resolved::{Choices, Resolved, kinematics_of};

/// Remarks wheels whose handedness does not fit their places.
pub fn wrong_hands(robot: &Robot) -> Option<String> {
    let wrong = WrongHands::of(&robot.wheels);
    wrong.map(|wrong| format!("the wheels: {wrong}"))
}

/// Remarks a driven wheel that is a little larger or smaller than all others: a controller may take
/// them for equal.
pub fn odd_wheel(robot: &Robot) -> Option<String> {
    /// Radii within this share count as equal; a larger difference than the second is intended.
    /// Chosen.
    const SHARES: std::ops::Range<f64> = 2e-3..0.05;
    let driven = || {
        robot
            .wheels
            .iter()
            .filter(|wheel| wheel.motor.effort_n_m > 0.0)
    };
    driven().enumerate().find_map(|(index, wheel)| {
        let others = driven().enumerate().filter(|(other, _)| *other != index);
        let radii_m = others.map(|(_, other)| other.radius_m);
        let least_m = radii_m.clone().fold(f64::INFINITY, f64::min);
        let most_m = radii_m.clone().fold(0.0, f64::max);
        let share = wheel.radius_m / least_m - 1.0;
        let are_equal = most_m < (1.0 + SHARES.start) * least_m && radii_m.count() > 1;
        (are_equal && SHARES.contains(&share.abs())).then(|| {
            let way = if share > 0.0 { "larger" } else { "smaller" };
            format!(
                "wheel `{}` is {:.1} % {way} than the others: each wheel is commanded by its own radius here; a controller that takes \
                 all for equal drifts, and `ilon explain` shows how",
                wheel.name,
                100.0 * share.abs()
            )
        })
    })
}

#[cfg(test)]
mod tests {
    use ilon_formats::LoadRobot;

    use super::*;

    /// A wheel 2 % larger than three equal ones is remarked; equal wheels, and one that is as large
    /// as a designer means it to be, are not.
    #[test]
    fn a_wheel_a_little_larger_than_the_others_is_remarked() {
        let mut robot =
            Robot::load("../../../assets/robots/mecanum4.toml").expect("a shipped robot");
        assert_eq!(odd_wheel(&robot), None);
        let radius_m = robot.wheels[0].radius_m;
        robot.wheels[0].radius_m = 1.02 * radius_m;
        let remark = odd_wheel(&robot).expect("a remark");
        assert!(remark.contains("`front_left` is 2.0 % larger"), "{remark}");
        robot.wheels[0].motor.effort_n_m = 0.0;
        assert_eq!(odd_wheel(&robot), None, "nothing commands it");
        robot.wheels[0].motor = robot.wheels[1].motor;
        robot.wheels[0].radius_m = 1.2 * radius_m;
        assert_eq!(odd_wheel(&robot), None);
    }
}
