//! The parameters of controllers for robots on tyres as YAML.

use std::fmt::Write;

use ilon_robot::Robot;

use super::on_tyres::{TyreController, TyreDrive};
use super::text::{number, one_line, quoted};

/// The parameters as YAML for `ros2_control_node`.
pub fn yaml_on_tyres(robot: &Robot, drive: &TyreDrive) -> String {
    let (name, class) = drive.controller.called();
    let mut text = format!(
        "# Controllers of ros2_controllers (Jazzy and later) for the robot \"{robot}\", made by ilon {version}.\n\
         # Start them on its URDF with a <ros2_control> block (`ilon inspect ROBOT --ros2-control FILE`).\n\
         controller_manager:\n  ros__parameters:\n    update_rate: 100\n    joint_state_broadcaster:\n      \
         type: joint_state_broadcaster/JointStateBroadcaster\n    {name}:\n      type: {class}\n\n",
        robot = one_line(&robot.name),
        version = env!("CARGO_PKG_VERSION"),
    );
    let [x_m, y_m] = drive.origin_m;
    if x_m.hypot(y_m) > 1e-4 {
        let _ = writeln!(
            text,
            "# Its odometry is that of the point ({}, {}) m of {}: give that point a frame, and name it as base_frame_id.",
            number(x_m),
            number(y_m),
            one_line(&robot.chassis.name)
        );
    }
    let base = quoted(&robot.chassis.name);
    let speed_m_s = drive.radius_m * drive.rate_rad_s;
    let _ = match &drive.controller {
        TyreController::Differential { .. } => differential(&mut text, drive, &base, speed_m_s),
        TyreController::Tricycle { .. } => tricycle(&mut text, drive, &base),
        TyreController::Steering { .. } => steering(&mut text, drive, &base),
    };
    text
}

/// Covariances to start with, as their documentation proposes.
const COVARIANCES: &str = "    pose_covariance_diagonal: [0.001, 0.001, 1000000.0, 1000000.0, 1000000.0, 0.01]\n    \
                           twist_covariance_diagonal: [0.001, 0.001, 1000000.0, 1000000.0, 1000000.0, 0.01]\n";

impl TyreController {
    /// Its name and its class.
    fn called(&self) -> (String, String) {
        let of = |name: &str, class: &str| (name.to_owned(), format!("{name}/{class}"));
        match self {
            Self::Differential { .. } => of("diff_drive_controller", "DiffDriveController"),
            Self::Tricycle { .. } => of("tricycle_controller", "TricycleController"),
            Self::Steering { kind, .. } => {
                let (first, rest) = kind.split_at(1);
                let class = format!("{}{rest}SteeringController", first.to_uppercase());
                of(&format!("{kind}_steering_controller"), &class)
            }
        }
    }
}

fn listed(names: &[String]) -> String {
    let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
    format!("[{}]", names.join(", "))
}

fn frames(base: &str) -> String {
    format!(
        "    base_frame_id: {base}\n    odom_frame_id: odom\n    enable_odom_tf: true\n{COVARIANCES}"
    )
}

fn differential(
    text: &mut String,
    drive: &TyreDrive,
    base: &str,
    speed_m_s: f64,
) -> std::fmt::Result {
    let TyreController::Differential {
        sides: [left, right],
        separation_m,
        is_skid,
    } = &drive.controller
    else {
        return Ok(());
    };
    write!(
        text,
        "# Reference: ~/cmd_vel (geometry_msgs/TwistStamped).\ndiff_drive_controller:\n  ros__parameters:\n    \
         cmd_vel_timeout: 0.5\n    left_wheel_names: {}\n    right_wheel_names: {}\n    \
         wheel_separation: {}\n    wheel_radius: {}\n",
        listed(left),
        listed(right),
        number(*separation_m),
        number(drive.radius_m)
    )?;
    if *is_skid {
        text.push_str(
            "    # Its tyres scrub in turns, and it turns less than their rates say: measure by how much on your floor, or read the\n    \
             # share of the yaw rate in the report of a turn, and give its inverse.\n    wheel_separation_multiplier: 1.0\n",
        );
    }
    text.push_str(&frames(base));
    if speed_m_s.is_finite() {
        // |v| + |omega| separation / 2 <= speed: half of both at once.
        let yaw_rad_s = 2.0 * speed_m_s / separation_m;
        write!(
            text,
            "    # Both at once are what the wheels' rates allow: {speed_m_s:.3} m/s ahead, or {yaw_rad_s:.3} rad/s on the spot, each alone.\n    \
             linear:\n      x: {{max_velocity: {:.4}, min_velocity: {:.4}}}\n    angular:\n      z: {{max_velocity: {:.4}, min_velocity: {:.4}}}\n",
            0.5 * speed_m_s,
            -0.5 * speed_m_s,
            0.5 * yaw_rad_s,
            -0.5 * yaw_rad_s
        )?;
    }
    Ok(())
}

fn tricycle(text: &mut String, drive: &TyreDrive, base: &str) -> std::fmt::Result {
    let TyreController::Tricycle {
        joints: [traction, steering],
        wheelbase_m,
        limit_rad,
    } = &drive.controller
    else {
        return Ok(());
    };
    write!(
        text,
        "# Reference: ~/cmd_vel (geometry_msgs/TwistStamped).\ntricycle_controller:\n  ros__parameters:\n    \
         cmd_vel_timeout: 500\n    traction_joint_name: {}\n    steering_joint_name: {}\n    wheelbase: {}\n    wheel_radius: {}\n{}",
        quoted(traction),
        quoted(steering),
        number(*wheelbase_m),
        number(drive.radius_m),
        frames(base)
    )?;
    if drive.rate_rad_s.is_finite() {
        let rate = number(drive.rate_rad_s);
        writeln!(
            text,
            "    # In rad/s of the wheel.\n    traction:\n      max_velocity: {rate}"
        )?;
    }
    if limit_rad.is_finite() {
        writeln!(
            text,
            "    steering:\n      max_position: {}",
            number(*limit_rad)
        )?;
    }
    Ok(())
}

fn steering(text: &mut String, drive: &TyreDrive, base: &str) -> std::fmt::Result {
    let TyreController::Steering {
        kind,
        traction,
        steering,
        wheelbase_m,
        tracks_m: [traction_m, steering_m],
    } = &drive.controller
    else {
        return Ok(());
    };
    write!(
        text,
        "# Reference: ~/reference (geometry_msgs/TwistStamped).\n{kind}_steering_controller:\n  ros__parameters:\n    \
         reference_timeout: 0.5\n    traction_joints_names: {}\n    steering_joints_names: {}\n    wheelbase: {}\n",
        listed(traction),
        listed(steering),
        number(*wheelbase_m)
    )?;
    match *kind {
        "bicycle" => writeln!(
            text,
            "    traction_wheel_radius: {}",
            number(drive.radius_m)
        )?,
        _ => writeln!(
            text,
            "    traction_track_width: {}\n    traction_wheels_radius: {}",
            number(*traction_m),
            number(drive.radius_m)
        )?,
    }
    if *kind == "ackermann" {
        writeln!(text, "    steering_track_width: {}", number(*steering_m))?;
    }
    text.push_str("    # It reads the rates of the driven wheels.\n    position_feedback: false\n");
    text.push_str(&frames(base));
    Ok(())
}
