//! Constants of a mecanum drive for Pedro Pathing.

use ilon_control::ControlError;
use ilon_robot::{Robot, Twist};

use super::road_runner::{BATTERY_V, Feedforward, INCH_M};
use crate::ros2_control::{Controller, DriveParameters};
use crate::scenario::{DcMotor, World};

/// Initial speed of the coasting in Pedro's tuners, in m/s: 30 in/s.
const COASTED_FROM_M_S: f64 = 30.0 * INCH_M;

/// What Pedro's tuners measure in one direction.
struct Tuned {
    /// The speed at full power, in m/s.
    top_m_s: f64,
    /// The mean deceleration without power from 30 in/s to rest, in m/s^2.
    coasting_m_s2: f64,
}

impl Tuned {
    /// From the voltages of a wheel's rim. The robot's speed is `gained` times the rim's.
    fn of(feedforward: &Feedforward, gained: f64) -> Self {
        let Feedforward {
            ks_v,
            kv_v_s_m,
            ka_v_s2_m,
            drag_v_s_m,
        } = *feedforward;
        let rim_m_s = COASTED_FROM_M_S / gained;
        // m v' = -(kS + d v) stops after kA / d ln(1 + d v0 / kS), and without d after kA v0 / kS.
        let growth = drag_v_s_m * rim_m_s / ks_v;
        let volts = match growth.is_finite() && growth > 1e-9 {
            true => drag_v_s_m * rim_m_s / libm::log1p(growth),
            false => ks_v,
        };
        Self {
            top_m_s: gained * ((BATTERY_V - ks_v) / kv_v_s_m).max(0.0),
            coasting_m_s2: gained * volts / ka_v_s2_m,
        }
    }
}

/// The constants that Pedro Pathing's automatic tuners would find, as Java; `None` unless `drive`
/// has mecanum wheels. The ratio of sideways to forward distance is `measured`, or otherwise that
/// of the rollers' geometry.
///
/// # Errors
/// As [`Feedforward::of`].
pub fn pedro(
    robot: &Robot,
    drive: &DriveParameters,
    (dc, world): (&DcMotor, &World),
    measured: Option<f64>,
) -> Result<Option<String>, ControlError> {
    let Controller::Mecanum { .. } = &drive.controller else {
        return Ok(None);
    };
    let of = |way, gained| Feedforward::of(robot, dc, way, world).map(|of| Tuned::of(&of, gained));
    let ahead = of(Twist::new(1.0, 0.0, 0.0), 1.0)?;
    let left = of(
        Twist::new(0.0, 1.0, 0.0),
        measured.unwrap_or(drive.real_over_asked[1]),
    )?;
    let name: String = robot.name.chars().filter(|c| !c.is_control()).collect();
    Ok(Some(format!(
        "// Pedro Pathing's constants for the robot \"{name}\", made by ilon {version}: what its tuners would measure, in inches.\n\
         public static FollowerConstants followerConstants = new FollowerConstants()\n        .mass({mass:.3})\n        \
         .forwardZeroPowerAcceleration({ahead_stop:.3})\n        .lateralZeroPowerAcceleration({left_stop:.3});\n\n\
         // At full power on {BATTERY_V} V.\n\
         public static MecanumConstants driveConstants = new MecanumConstants()\n        .maxPower(1)\n        \
         .xVelocity({ahead_top:.3})\n        .yVelocity({left_top:.3});\n",
        version = env!("CARGO_PKG_VERSION"),
        mass = robot.mass_kg(),
        ahead_stop = 0.0 - ahead.coasting_m_s2 / INCH_M,
        left_stop = 0.0 - left.coasting_m_s2 / INCH_M,
        ahead_top = ahead.top_m_s / INCH_M,
        left_top = left.top_m_s / INCH_M,
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// kS + d v at 30 in/s = 0.762 m/s; k in V, V s/m, V s^2/m.
    #[test]
    fn a_robot_coasts_as_its_friction_has_it() {
        let of = |ks_v, drag_v_s_m| {
            let feedforward = Feedforward {
                ks_v,
                kv_v_s_m: 6.0,
                ka_v_s2_m: 0.5,
                drag_v_s_m,
            };
            Tuned::of(&feedforward, 1.0)
        };
        // Dry friction alone: 1 V / 0.5 V s^2/m = 2 m/s^2 at any speed, and (12 - 1) / 6 m/s at
        // full power.
        let dry = of(1.0, 0.0);
        assert!((dry.coasting_m_s2 - 2.0).abs() < 1e-12);
        assert!((dry.top_m_s - 11.0 / 6.0).abs() < 1e-12);
        // With 1 V s/m in addition: 0.762 / (0.5 ln 1.762) m/s^2, between 2 and 2 x 1.762.
        let wet = of(1.0, 1.0);
        assert!((wet.coasting_m_s2 - 0.762 / (0.5 * 1.762_f64.ln())).abs() < 1e-12);
        // Without friction the robot does not slow down.
        assert_eq!(of(0.0, 0.0).coasting_m_s2, 0.0);
    }
}
