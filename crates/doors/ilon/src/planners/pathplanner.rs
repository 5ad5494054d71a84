//! `settings.json` for PathPlanner.

use serde_json::{Value, json};

use super::Swerve;

/// The motor in place of the robot's own: WPILib's NEO at 12 V, as PathPlanner accepts only motors
/// that it knows.
const MOTOR: &str = "NEO";
const STALL_N_M: f64 = 2.6;
const STALL_A: f64 = 105.0;
const FREE_A: f64 = 1.8;
const FREE_RAD_S: f64 = 5676.0 / 60.0 * std::f64::consts::TAU;

/// The robot as PathPlanner's settings, for `src/main/deploy/pathplanner/settings.json`.
///
/// The gear ratio and current limit give a NEO the torque of [`Swerve::torque_n_m`] at rest and
/// zero torque at the top speed. They differ from the real ones.
pub fn pathplanner(swerve: &Swerve) -> String {
    // Rate at zero current and 12 V: the free speed plus what the motor's own losses take of it.
    let empty_rad_s = FREE_RAD_S / (1.0 - FREE_A / STALL_A);
    let gearing = empty_rad_s * swerve.wheel_radius_m / swerve.speed_m_s;
    let current_a = swerve.torque_n_m / (gearing * STALL_N_M / STALL_A);
    let [front_m, back_m, left_m, right_m] = swerve.reach_m;
    let [fl, fr, bl, br] = swerve.modules_m;
    let [ahead, left, turning] = swerve.acceleration_box;
    let mut settings = json!({
        "robotWidth": left_m + right_m,
        "robotLength": front_m + back_m,
        "holonomicMode": true,
        "pathFolders": [],
        "autoFolders": [],
        "defaultMaxVel": swerve.speed_m_s,
        "defaultMaxAccel": ahead.min(left),
        "defaultMaxAngVel": swerve.yaw_rate_rad_s.to_degrees(),
        "defaultMaxAngAccel": turning.to_degrees(),
        "defaultNominalVoltage": 12.0,
        "robotMass": swerve.mass_kg,
        "robotMOI": swerve.inertia_kg_m2,
        "robotWheelbase": fl[0] - bl[0],
        "robotTrackwidth": fl[1] - fr[1],
        "driveWheelRadius": swerve.wheel_radius_m,
        "driveGearing": gearing,
        "maxDriveSpeed": swerve.speed_m_s,
        "driveMotorType": MOTOR,
        "driveCurrentLimit": current_a,
        "wheelCOF": swerve.friction,
        "bumperOffsetX": 0.5 * (front_m - back_m),
        "bumperOffsetY": 0.5 * (left_m - right_m),
        "robotFeatures": [],
    });
    for (name, [x_m, y_m]) in [("fl", fl), ("fr", fr), ("bl", bl), ("br", br)] {
        settings[format!("{name}ModuleX")] = Value::from(x_m);
        settings[format!("{name}ModuleY")] = Value::from(y_m);
    }
    format!("{settings:#}\n")
}
