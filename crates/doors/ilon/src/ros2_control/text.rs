//! The parameters as files for ROS 2.

use std::fmt::Write;

use ilon_robot::Robot;

use super::drive_parameters::{Controller, DriveParameters};
use crate::simulate::Limits;

/// The parameters as YAML for `ros2_control_node`, with the speeds that the wheels allow for Nav2's
/// MPPI controller. With `limits` also the accelerations for MPPI and for Nav2's velocity smoother.
pub fn yaml(robot: &Robot, drive: &DriveParameters, limits: Option<&Limits>) -> String {
    let name = one_line(&robot.name);
    let mut text = format!(
        "# Controllers of ros2_controllers (Jazzy and later) for the robot \"{name}\", made by ilon {version}.\n\
         # Start them on its URDF with a <ros2_control> block (`ilon inspect ROBOT --ros2-control FILE`).\n\
         controller_manager:\n  ros__parameters:\n    update_rate: 100\n    joint_state_broadcaster:\n      \
         type: joint_state_broadcaster/JointStateBroadcaster\n",
        version = env!("CARGO_PKG_VERSION"),
    );
    let base = quoted(&robot.chassis.name);
    match &drive.controller {
        Controller::Mecanum {
            wheels,
            wheels_radius_m,
            center_sum_m,
            base_frame_offset_m: [x_m, y_m],
            base_frame_offset_rad,
        } => {
            let [front_left, front_right, rear_right, rear_left] =
                wheels.each_ref().map(|w| quoted(w));
            let _ = write!(
                text,
                "    mecanum_drive_controller:\n      type: mecanum_drive_controller/MecanumDriveController\n\n\
                 # Reference: ~/reference (geometry_msgs/TwistStamped). Remap ~/tf_odometry to /tf, or odom -> {base} is missing there.\n\
                 mecanum_drive_controller:\n  ros__parameters:\n    reference_timeout: 0.5\n    \
                 front_left_wheel_command_joint_name: {front_left}\n    front_right_wheel_command_joint_name: {front_right}\n    \
                 rear_right_wheel_command_joint_name: {rear_right}\n    rear_left_wheel_command_joint_name: {rear_left}\n    \
                 kinematics:\n      base_frame_offset: {{x: {x}, y: {y}, theta: {theta}}}\n{radius}      \
                 wheels_radius: {wheels_radius_m:.6}\n      \
                 # Half of the wheelbase and half of the track together, times what turning on rollers loses.\n      \
                 sum_of_robot_center_projection_on_X_Y_axis: {center_sum_m:.6}\n{frames}    \
                 pose_covariance_diagonal: [0.001, 0.001, 1000000.0, 1000000.0, 1000000.0, 0.01]\n    \
                 twist_covariance_diagonal: [0.001, 0.001, 1000000.0, 1000000.0, 1000000.0, 0.01]\n{speeds}",
                speeds = speeds(drive, limits),
                x = number(*x_m),
                y = number(*y_m),
                theta = number(*base_frame_offset_rad),
                radius = about_radius(drive, *wheels_radius_m, "      "),
                frames = frames(&base),
            );
        }
        Controller::Omni {
            wheels,
            wheel_offset_rad,
            robot_radius_m,
            wheel_radius_m,
        } => {
            let wheels: Vec<String> = wheels.iter().map(|wheel| quoted(wheel)).collect();
            let _ = write!(
                text,
                "    omni_wheel_drive_controller:\n      type: omni_wheel_drive_controller/OmniWheelDriveController\n\n\
                 # Reference: ~/cmd_vel (geometry_msgs/TwistStamped).\n\
                 omni_wheel_drive_controller:\n  ros__parameters:\n    cmd_vel_timeout: 0.5\n    \
                 wheel_names: [{names}]\n    wheel_offset: {offset}\n    \
                 # The distance of the wheels from the origin, times what turning on rollers loses.\n    \
                 robot_radius: {robot_radius_m:.6}\n{radius}    wheel_radius: {wheel_radius_m:.6}\n{frames}    \
                 diagonal_covariance:\n      pose: [0.001, 0.001, 1000000.0, 1000000.0, 1000000.0, 0.01]\n      \
                 twist: [0.001, 0.001, 1000000.0, 1000000.0, 1000000.0, 0.01]\n",
                names = wheels.join(", "),
                offset = number(*wheel_offset_rad),
                radius = about_radius(drive, *wheel_radius_m, "    "),
                frames = frames(&base),
            );
        }
    }
    text.push_str(&mppi(robot, drive));
    if let Some(limits) = limits {
        text.push_str(&accelerations(drive, limits));
    }
    text
}

/// Speeds and accelerations for the mecanum controller, which limits each axis separately; empty if
/// there are none. An omitted value is unlimited, and an omitted reverse limit equals the forward
/// one.
fn speeds(drive: &DriveParameters, limits: Option<&Limits>) -> String {
    let speeds = drive.box_within();
    let accelerations = limits.map(|limits| limits.acceleration_box);
    if speeds.is_none() && accelerations.is_none() {
        return String::new();
    }
    let of = |axis: usize| {
        let speed = speeds.map(|of| format!("max_velocity: {:.4}", of[axis]));
        let acceleration = accelerations.map(|of| {
            let most = of[axis];
            format!(
                "max_acceleration: {most:.4}, max_deceleration: {:.4}",
                -most
            )
        });
        [speed, acceleration]
            .into_iter()
            .flatten()
            .collect::<Vec<_>>()
            .join(", ")
    };
    format!(
        "    # Limits of the reference, from ros2_controllers 6.8, 5.16 (Kilted) or 4.41 (Jazzy) on: boxes of which every corner can be driven.\n    \
         linear:\n      x: {{{}}}\n      y: {{{}}}\n    angular:\n      z: {{{}}}\n",
        of(0),
        of(1),
        of(2)
    )
}

/// The accelerations for Nav2. The omni-wheel controller of ros2_controllers has no such
/// parameters.
fn accelerations(drive: &DriveParameters, limits: &Limits) -> String {
    let [x, y, yaw] = limits.acceleration_box;
    let mppi = match drive.box_within() {
        // The keys of the controller stand above.
        Some(_) => "",
        None => "controller_server:\n  ros__parameters:\n    FollowPath:\n",
    };
    let mut text = format!(
        "{mppi}      # Accelerations without slip or lack of torque on a floor of friction {friction}, of which every corner of the box can be had\n      \
         # from rest, less a tenth.\n      ax_max: {x:.4}\n      ax_min: {:.4}\n      ay_max: {y:.4}\n      ay_min: {:.4}\n      az_max: {yaw:.4}\n",
        -x,
        -y,
        friction = limits.friction
    );
    text.push_str(&dwb(drive, limits));
    let _ = write!(
        text,
        "\n# The same for Nav2's velocity smoother: x, y and yaw.\nvelocity_smoother:\n  ros__parameters:\n    \
         max_accel: [{x:.4}, {y:.4}, {yaw:.4}]\n    max_decel: [{:.4}, {:.4}, {:.4}]\n",
        -x, -y, -yaw
    );
    text
}

/// The same for Nav2's DWB controller, as an alternative to MPPI; empty if the wheels have no rate
/// limits.
fn dwb(drive: &DriveParameters, limits: &Limits) -> String {
    let Some([vx, vy, wz]) = drive.box_within() else {
        return String::new();
    };
    let [x, y, yaw] = limits.acceleration_box;
    format!(
        "    # The same for Nav2's DWB controller; to take it: controller_plugins: [\"FollowPathDWB\"].\n    FollowPathDWB:\n      \
         plugin: \"dwb_core::DWBLocalPlanner\"\n      min_vel_x: {:.4}\n      max_vel_x: {vx:.4}\n      min_vel_y: {:.4}\n      \
         max_vel_y: {vy:.4}\n      max_vel_theta: {wz:.4}\n      min_speed_xy: 0.0\n      max_speed_xy: {:.4}\n      \
         min_speed_theta: 0.0\n      acc_lim_x: {x:.4}\n      acc_lim_y: {y:.4}\n      acc_lim_theta: {yaw:.4}\n      \
         decel_lim_x: {:.4}\n      decel_lim_y: {:.4}\n      decel_lim_theta: {:.4}\n",
        -vx,
        -vy,
        vx.hypot(vy),
        -x,
        -y,
        -yaw
    )
}

fn frames(base: &str) -> String {
    format!("    base_frame_id: {base}\n    odom_frame_id: odom\n    enable_odom_tf: true\n")
}

/// What the radius is right for, as comments.
fn about_radius(drive: &DriveParameters, rolling_m: f64, indent: &str) -> String {
    // A value that rounds to zero has no sign.
    let percent = |share: f64| ((share - 1.0) * 1e4).round() / 1e2 + 0.0;
    let [x, y, yaw] = drive.real_over_asked.map(percent);
    let mut text = format!(
        "{indent}# The wheels' own radius is {:.6} m, and {rolling_m:.6} m is what they roll on. Without slip the real motion differs from\n\
         {indent}# the motion asked for by {x:+.2} % ahead, {y:+.2} % to the side and {yaw:+.2} % in a turn.\n",
        drive.radius_m
    );
    if y.abs() > 0.1 {
        text.push_str(&format!(
            "{indent}# The controller has no parameter for the side alone: its odometry is off by as much there.\n"
        ));
    }
    text
}

/// The speeds that the wheels allow, for Nav2.
fn mppi(robot: &Robot, drive: &DriveParameters) -> String {
    let mut text = String::from("\n# Speeds for Nav2's MPPI controller (motion_model: \"Omni\").");
    let Some([vx, vy, wz]) = drive.box_within() else {
        text.push_str(" The file of the robot sets no rate limits of its wheels:\n# give its joints <limit velocity=...>, and they follow.\n");
        return text;
    };
    text.push_str(" The wheels allow all twists with |a vx + b vy + c wz| <= 1 for each row\n# (a, b, c) in s/m, s/m and s/rad:\n");
    for ((row, limit), wheel) in drive
        .rates
        .row_iter()
        .zip(&drive.rate_limits_rad_s)
        .zip(&robot.wheels)
    {
        let [a, b, c] = [row[0], row[1], row[2]].map(|entry| entry / limit);
        let _ = writeln!(
            text,
            "#   [{a:+.5}, {b:+.5}, {c:+.5}]  {}",
            one_line(&wheel.name)
        );
    }
    let alone = |twist| 1.0 / drive.share(twist);
    use ilon_robot::Twist;
    let _ = write!(
        text,
        "# That is {:.3} m/s ahead, {:.3} m/s to the side or {:.3} rad/s, each alone. MPPI knows no such shape, only a box: this is the\n\
         # largest in these proportions of which every corner can be rolled.\n\
         controller_server:\n  ros__parameters:\n    FollowPath:\n      plugin: \"nav2_mppi_controller::MPPIController\"\n      \
         motion_model: \"Omni\"\n      vx_max: {vx:.4}\n      vx_min: {:.4}\n      vy_max: {vy:.4}\n      wz_max: {wz:.4}\n",
        alone(Twist::new(1.0, 0.0, 0.0)),
        alone(Twist::new(0.0, 1.0, 0.0)),
        alone(Twist::new(0.0, 0.0, 1.0)),
        -vx,
    );
    text
}

/// A number with a decimal point in YAML: ROS 2 refuses integers for such parameters.
pub(super) fn number(value: f64) -> String {
    // A value that rounds to zero has no sign.
    format!("{:.6}", if value.abs() < 5e-7 { 0.0 } else { value })
}

/// A quoted YAML string with any content.
pub(super) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// The text without characters that would end a comment.
pub(super) fn one_line(text: &str) -> String {
    text.chars()
        .map(|letter| if letter.is_control() { ' ' } else { letter })
        .collect()
}
