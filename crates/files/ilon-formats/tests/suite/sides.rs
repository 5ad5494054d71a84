//! Robots whose wheels are placed or roll in contradiction to their names and the frame.

use ilon_formats::LoadRobot;
use ilon_robot::Robot;

/// Four plain mecanum wheels, each with its name, its position and its joint's axis.
fn remarks(wheels: [(&str, f64, f64); 4], axis: &str) -> String {
    let wheel = |(name, x, y): (&str, f64, f64)| {
        format!(
            r#"<link name="{name}"><inertial><mass value="0.5"/><inertia ixx="0.0004" ixy="0" ixz="0" iyy="0.0006" iyz="0" izz="0.0004"/></inertial>
<collision><origin rpy="{rpy}"/><geometry><cylinder radius="0.05" length="0.04"/></geometry></collision></link>
<joint name="mecanum_{name}" type="continuous"><parent link="base"/><child link="{name}"/><origin xyz="{x} {y} 0"/><axis xyz="{axis}"/></joint>"#,
            rpy = if axis.ends_with("0 0") {
                "0 1.5707963267948966 0"
            } else {
                "1.5707963267948966 0 0"
            },
        )
    };
    let text = format!(
        r#"<robot name="r"><link name="base"><inertial><mass value="10"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.3"/></inertial></link>
{}</robot>"#,
        wheels.map(wheel).join("\n")
    );
    let robot = Robot::from_urdf_str(&text, "r.urdf").unwrap();
    let said = robot.remarks.iter().map(ToString::to_string);
    said.collect::<Vec<_>>().join("\n")
}

#[test]
fn names_and_axes_that_fit_the_frame_are_not_remarked() {
    for names in [
        ["front_left", "front_right", "rear_left", "rear_right"],
        ["lf_wheel", "rf_wheel", "lb_wheel", "rb_wheel"],
        ["wheel_1", "wheel_2", "wheel_3", "wheel_4"],
    ] {
        let [fl, fr, rl, rr] = names;
        let said = remarks(
            [
                (fl, 0.2, 0.18),
                (fr, 0.2, -0.18),
                (rl, -0.2, 0.18),
                (rr, -0.2, -0.18),
            ],
            "0 1 0",
        );
        assert!(!said.contains("body's frame"), "{said}");
    }
}

#[test]
fn exchanged_names_turned_frames_and_hubs_along_x_are_remarked() {
    let said = remarks(
        [
            ("fl", 0.2, -0.18),
            ("fr", 0.2, 0.18),
            ("rl", -0.2, -0.18),
            ("rr", -0.2, 0.18),
        ],
        "0 1 0",
    );
    assert!(
        said.contains("the left of the robot lies along -y"),
        "{said}"
    );
    let said = remarks(
        [
            ("fl", -0.2, 0.18),
            ("fr", -0.2, -0.18),
            ("rl", 0.2, 0.18),
            ("rr", 0.2, -0.18),
        ],
        "0 1 0",
    );
    assert!(
        said.contains("the front of the robot lies along -x"),
        "{said}"
    );
    // Rotated by half a turn: both are remarked, and no wheels are exchanged.
    let said = remarks(
        [
            ("fl", -0.2, -0.18),
            ("fr", -0.2, 0.18),
            ("rl", 0.2, -0.18),
            ("rr", 0.2, 0.18),
        ],
        "0 1 0",
    );
    assert!(
        said.contains("lies along -x and its left along -y"),
        "{said}"
    );
    let said = remarks(
        [
            ("fl", -0.18, 0.2),
            ("fr", 0.18, 0.2),
            ("rl", -0.18, -0.2),
            ("rr", 0.18, -0.2),
        ],
        "1 0 0",
    );
    assert!(said.contains("their hubs lie along x"), "{said}");
    assert!(
        said.contains("lies along y and its left along -x"),
        "{said}"
    );
}
