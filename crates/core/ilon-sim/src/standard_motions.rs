//! Five motions that characterise a robot: ahead, to the left, diagonal, an arc, and a turn on the
//! spot.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use ilon_control::{Kinematics, SpeedLimits, Turn, sharpest_turn};
use ilon_robot::{Robot, Twist};

use crate::Error;

/// The names of the motions. Each covers one metre, or one turn on the spot, or what a slow robot
/// does in a minute.
pub const MOTIONS: [&str; 5] = ["ahead", "left", "diagonal", "arc", "turn"];

/// Each is driven at this share of the robot's top speed, within the limits in m/s and rad/s below.
/// Chosen.
const SHARE_OF_TOP: f64 = 0.4;
const SPEED_M_S: f64 = 0.3;
const RATE_RAD_S: f64 = 1.0;
/// The radius of the arc, in metres, and at least this many times that of the sharpest turn which
/// limits of steering joints leave. Chosen.
const ARC_M: f64 = 0.5;
const WIDER: f64 = 1.25;
/// A turn of such a robot is wider than its sharpest by this factor. Chosen.
const WITHIN_LIMITS: f64 = 1.05;
/// The time from rest to full speed, in seconds. Chosen.
const RAMP_S: f64 = 0.5;

/// The longest time at full speed, in seconds. Chosen.
const LONGEST_S: f64 = 60.0;

/// One of the motions, at a speed that the robot reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct StandardMotion {
    /// Its name, one of [`MOTIONS`].
    pub name: &'static str,
    /// The twist of the body's origin at full speed, in the body frame.
    pub twist_in_body: Twist,
    /// Its duration from rest, in seconds.
    pub duration_s: f64,
}

impl StandardMotion {
    /// The same motion over `amount` metres, or turns on the spot.
    #[must_use]
    pub fn over(self, amount: f64) -> Self {
        // The ramp costs half its duration at full speed.
        let lost_s = 0.5 * RAMP_S;
        Self {
            duration_s: (self.duration_s - lost_s) * amount + lost_s,
            ..self
        }
    }

    /// Its lines in a scenario: `twist` and `run`.
    pub fn toml(&self) -> String {
        let Twist {
            vx_m_s,
            vy_m_s,
            omega_rad_s,
        } = self.twist_in_body;
        format!(
            "twist = {{ vx_m_s = {vx_m_s}, vy_m_s = {vy_m_s}, omega_rad_s = {omega_rad_s}, rest_s = 0.0, ramp_s = {RAMP_S}, settle_s = 0.2 }}\n\
             run.duration_s = {:.3}\n",
            self.duration_s
        )
    }
}

/// The motions of a robot, in the order of [`MOTIONS`]; `None` for one that its tyres exclude. A
/// robot whose steering does not let it turn on the spot turns as sharply as it can.
///
/// # Errors
/// For wheels from whose rates no twist follows.
pub fn standard_motions(robot: &Robot) -> Result<[Option<StandardMotion>; 5], Error> {
    let motors = robot.wheels.iter().map(|wheel| wheel.motor.velocity_rad_s);
    let kinematics = Kinematics::new(robot)?;
    let tops = SpeedLimits::new(&kinematics, &motors.collect::<Vec<_>>());
    // Of a robot on tyres ahead, or to the left where its wheels roll along y.
    let [ahead_m_s, left_m_s] = [0.0, FRAC_PI_2].map(|rad| tops.top_speed_m_s(rad));
    let tops_m_s = [tops.top_speed_range_m_s().0, ahead_m_s, left_m_s];
    let least_m_s = tops_m_s.into_iter().find(|m_s| *m_s > 0.0);
    let least_m_s = least_m_s.unwrap_or_default();
    let sharpest = sharpest_turn(robot, &robot.start_positions());
    let wide = sharpest.filter(|turn| turn.radius_m > 0.0);
    let turn_m = wide.map_or(0.0, |Turn { twist_in_body, .. }| {
        WITHIN_LIMITS * twist_in_body.vx_m_s
    });
    // On tyres the origin need not stand still where the robot turns.
    let turning = kinematics.reachable(Twist::new(turn_m, 0.0, 1.0));
    let arc_m = ARC_M.max(WIDER * wide.map_or(0.0, |turn| turn.radius_m));
    let v = readable(SPEED_M_S.min(SHARE_OF_TOP * least_m_s));
    let w = readable(RATE_RAD_S.min(SHARE_OF_TOP / tops.share(turning)));
    let arc = readable((0.5 * v).min(0.5 * w * arc_m));
    let diagonal = readable(v * FRAC_1_SQRT_2);
    let of = |place: usize, twist: [f64; 3], lasts_s: f64| {
        let linear = Twist::new(twist[0], twist[1], 0.0);
        let can = tops.share(linear).is_finite() && lasts_s.is_finite();
        can.then(|| StandardMotion {
            name: MOTIONS[place],
            twist_in_body: Twist::new(twist[0], twist[1], twist[2]),
            // The ramp takes half its time of full speed.
            duration_s: lasts_s.min(LONGEST_S) + 0.5 * RAMP_S,
        })
    };
    Ok([
        of(0, [v, 0.0, 0.0], 1.0 / v),
        of(1, [0.0, v, 0.0], 1.0 / v),
        of(2, [diagonal, diagonal, 0.0], 1.0 / v),
        of(3, [arc, 0.0, readable(arc / arc_m)], 1.0 / arc),
        of(4, [readable(turn_m * w), 0.0, w], std::f64::consts::TAU / w),
    ])
}

/// A number with three significant digits, for a readable file.
fn readable(x: f64) -> f64 {
    ilon_trace::significant(x, 3)
}

#[cfg(test)]
mod tests {
    use ilon_formats::LoadRobot;

    use super::*;

    #[test]
    fn each_goes_a_metre_or_turns_once_or_a_minute_within_what_the_motors_can() {
        let mut robot =
            Robot::load("../../../assets/robots/mecanum4.toml").expect("a shipped robot");
        for limit_rad_s in [f64::INFINITY, 2.0] {
            for wheel in &mut robot.wheels {
                wheel.motor.velocity_rad_s = limit_rad_s;
            }
            let kinematics = Kinematics::new(&robot).expect("four wheels");
            for motion in standard_motions(&robot).expect("four wheels") {
                let motion = motion.expect("on rollers");
                let twist = motion.twist_in_body;
                let way_m = twist.linear_m_s().norm() * (motion.duration_s - 0.25);
                let turns = twist.omega_rad_s * (motion.duration_s - 0.25) / std::f64::consts::TAU;
                let amount = if way_m > 0.0 { way_m } else { turns };
                // Speeds have three digits.
                let is_whole = (amount - 1.0).abs() < 6e-3;
                let is_cut = motion.duration_s == LONGEST_S + 0.25 && amount < 1.0;
                assert!(is_whole || is_cut, "{motion:?}");
                assert!(is_whole || limit_rad_s == 2.0, "{motion:?}");
                let mut rates = [0.0; 4];
                kinematics.wheel_rates(twist, &mut rates);
                assert!(
                    rates.iter().all(|rate| rate.abs() < 0.9 * limit_rad_s),
                    "{rates:?}"
                );
            }
        }
    }

    /// The shipped tricycle, steered by up to 74.5 degrees 0.45 m ahead of its axle, turns about
    /// 0.45 / tan(74.5 deg) = 0.125 m beside the axle's middle at the sharpest.
    #[test]
    fn a_robot_that_cannot_turn_on_the_spot_turns_as_sharply_as_it_can() {
        let robot = Robot::load("../../../assets/robots/tricycle.urdf").expect("a shipped robot");
        let motions = standard_motions(&robot).expect("it drives");
        let [Some(_), None, None, Some(arc), Some(turn)] = motions else {
            panic!("{motions:?}");
        };
        let radius_m =
            |motion: StandardMotion| motion.twist_in_body.vx_m_s / motion.twist_in_body.omega_rad_s;
        assert!((radius_m(arc) - ARC_M).abs() < 5e-3, "{arc:?}");
        assert!(
            (radius_m(turn) - WITHIN_LIMITS * 0.125).abs() < 1e-3,
            "{turn:?}"
        );
    }

    /// Its wheels roll along y, which is to the left, at 12 rad/s and 60 mm at most: 0.72 m/s.
    #[test]
    fn a_robot_on_tyres_that_rolls_to_its_left_is_driven_there() {
        let text = std::fs::read_to_string("../../../assets/robots/differential.urdf").unwrap();
        let text = text.replace("velocity=\"30\"", "velocity=\"12\"");
        let turned = "<robot name=\"turned\"><link name=\"top\"/><joint name=\"turn\" type=\"fixed\"><parent link=\"top\"/><child link=\"base_link\"/><origin rpy=\"0 0 1.5707963267948966\"/></joint>";
        let text = text.replacen("<robot name=\"differential\">", turned, 1);
        let robot = Robot::from_urdf_str(&text, "turned.urdf").expect("two wheels");
        let motions = standard_motions(&robot).expect("it drives");
        let [None, Some(left), None, None, Some(_)] = motions else {
            panic!("{motions:?}");
        };
        let top_m_s: f64 = 0.72;
        let speed_m_s = SPEED_M_S.min(SHARE_OF_TOP * top_m_s);
        assert!(
            (left.twist_in_body.vy_m_s - speed_m_s).abs() < 1e-3,
            "{left:?}"
        );
        assert_eq!(left.twist_in_body.vx_m_s, 0.0);
    }

    /// Speed grows evenly over the ramp, so that the way is v (T - ramp / 2).
    #[test]
    fn over_a_length_each_goes_that_length_and_the_diagonal_to_the_left() {
        let robot = Robot::load("../../../assets/robots/mecanum4.toml").expect("a shipped robot");
        let motions = standard_motions(&robot).expect("four wheels");
        for motion in motions.into_iter().flatten() {
            let way = |of: StandardMotion| of.duration_s - 0.5 * RAMP_S;
            for amount in [0.5, 3.0] {
                let share = way(motion.over(amount)) / way(motion);
                assert!((share - amount).abs() < 1e-12, "{motion:?} {share}");
            }
        }
        let diagonal = motions[2].expect("on rollers").twist_in_body;
        let heading_deg = libm::atan2(diagonal.vy_m_s, diagonal.vx_m_s).to_degrees();
        assert!((heading_deg - 45.0).abs() < 1e-9, "{heading_deg}");
    }

    /// The point is where its steering lets it turn, whatever its motors can.
    #[test]
    fn a_tricycle_turns_about_the_same_point_at_any_speed() {
        let radius_m = |limit_rad_s: f64| {
            let mut robot =
                Robot::load("../../../assets/robots/tricycle.toml").expect("a shipped robot");
            for wheel in &mut robot.wheels {
                wheel.motor.velocity_rad_s = limit_rad_s;
            }
            let [.., turn] = standard_motions(&robot).expect("three wheels");
            let twist = turn.expect("it can turn").twist_in_body;
            (twist.omega_rad_s, twist.vx_m_s / twist.omega_rad_s)
        };
        let ((fast, far_m), (slow, near_m)) = (radius_m(30.0), radius_m(3.0));
        assert!(slow < 0.5 * fast, "{slow} {fast}");
        // Both speeds have three digits.
        assert!((far_m / near_m - 1.0).abs() < 0.01, "{far_m} {near_m}");
    }
}
