//! Robots as people build them: joints to the world above the base, rollers for show, wheels that do not fit the others.

use ilon_formats::{Fault, LoadRobot, RobotError};
use ilon_robot::Robot;

const PLACES: [(&str, f64, f64); 4] = [
    ("fl", 0.2, 0.18),
    ("fr", 0.2, -0.18),
    ("rl", -0.2, 0.18),
    ("rr", -0.2, -0.18),
];

const BASE: &str = r#"<link name="base"><inertial><mass value="10"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.3"/></inertial></link>"#;

fn link(name: &str, shape: &str) -> String {
    format!(
        r#"<link name="{name}"><inertial><mass value="0.5"/><inertia ixx="0.0004" ixy="0" ixz="0" iyy="0.0006" iyz="0" izz="0.0004"/></inertial>{shape}</link>"#
    )
}

fn joint(name: &str, kind: &str, [parent, child]: [&str; 2], origin: &str, axis: &str) -> String {
    format!(
        r#"<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin {origin}/><axis xyz="{axis}"/></joint>"#
    )
}

const DISC: &str = r#"<collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.04"/></geometry></collision>"#;

/// Wheels with a disc, below a link each.
fn wheels(named: &str, below: &str) -> String {
    let wheel = |(name, x, y): (&str, f64, f64)| {
        let name = format!("{named}_{name}");
        let place = format!(r#"xyz="{x} {y} 0""#);
        link(&name, DISC)
            + &joint(
                &format!("{name}_joint"),
                "continuous",
                [below, &name],
                &place,
                "0 1 0",
            )
    };
    PLACES.map(wheel).concat()
}

fn robot(parts: &[&str]) -> Result<Robot, RobotError> {
    Robot::from_urdf_str(
        &format!(r#"<robot name="r">{}</robot>"#, parts.concat()),
        "r.urdf",
    )
}

/// gamma of each wheel, in degrees.
fn gammas(robot: &Robot) -> Vec<f64> {
    robot
        .wheels
        .iter()
        .map(|wheel| wheel.gamma_rad.to_degrees().round())
        .collect()
}

/// Slides along x and y and a turn, each with a link of its own, above wheels with and without rollers.
#[test]
fn joints_to_the_world_above_the_base_are_no_wheel() {
    let to_world = |last: &str| {
        [
            r#"<link name="world"/><link name="at_x"/><link name="at_y"/>"#.to_owned(),
            joint("world_x", "prismatic", ["world", "at_x"], "", "1 0 0").replace(
                "<axis",
                r#"<limit lower="-9" upper="9" effort="1" velocity="1"/><axis"#,
            ),
            joint("world_y", "prismatic", ["at_x", "at_y"], "", "0 1 0").replace(
                "<axis",
                r#"<limit lower="-9" upper="9" effort="1" velocity="1"/><axis"#,
            ),
            joint("world_yaw", "continuous", ["at_y", last], "", "0 0 1"),
        ]
        .concat()
    };
    let found = robot(&[&to_world("base"), BASE, &wheels("mecanum", "base")]).unwrap();
    assert_eq!(gammas(&found), [-45.0, 45.0, 45.0, -45.0]);
    // Rollers of their own stay rollers of the wheels.
    let small = crate::common::small();
    let plain = Robot::from_urdf_str(&small, "small.urdf").unwrap();
    let below = small.replace("</robot>", &format!("{}</robot>", to_world("base_link")));
    let found = Robot::from_urdf_str(&below, "small.urdf").unwrap();
    let rollers = |robot: &Robot| -> Vec<usize> {
        robot
            .wheels
            .iter()
            .map(|wheel| wheel.rollers.len())
            .collect()
    };
    assert_eq!(rollers(&found), rollers(&plain));
}

/// A cylinder on a cross joint in the hub, and two on its rim: they turn nothing on the floor, and are part of the wheel.
#[test]
fn rollers_for_show_are_part_of_their_wheels() {
    let small =
        r#"<collision><geometry><cylinder radius="0.01" length="0.03"/></geometry></collision>"#;
    for places in [&["0 0 0"][..], &["0 0 -0.04"], &["0 0 -0.04", "0 0 0.04"]] {
        let mut parts = vec![BASE.to_owned(), wheels("mecanum", "base")];
        for (name, ..) in PLACES {
            for (k, place) in places.iter().enumerate() {
                let (own, hub) = (format!("show_{name}_{k}"), format!("mecanum_{name}"));
                let origin = format!(r#"xyz="{place}""#);
                parts.push(link(&own, small));
                parts.push(joint(
                    &format!("{own}_joint"),
                    "continuous",
                    [&hub, &own],
                    &origin,
                    "1 0 0",
                ));
            }
        }
        let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
        let found = robot(&parts).unwrap();
        assert_eq!(gammas(&found), [-45.0, 45.0, 45.0, -45.0]);
        assert!(
            found
                .wheels
                .iter()
                .all(|wheel| (wheel.radius_m - 0.05).abs() < 1e-12)
        );
    }
}

/// Three wheels in a row and a fourth that is steered: the refusal names it, with the reason.
#[test]
fn wheels_that_are_left_out_of_a_proposal_are_named() {
    let steer = joint(
        "steer",
        "revolute",
        ["base", "fork"],
        r#"xyz="-0.2 -0.18 0""#,
        "0 0 1",
    )
    .replace(
        "<axis",
        r#"<limit lower="-1" upper="1" effort="1" velocity="1"/><axis"#,
    );
    let all = wheels("wheel", "base").replace(
        r#"<parent link="base"/><child link="wheel_rr"/><origin xyz="-0.2 -0.18 0"/>"#,
        r#"<parent link="fork"/><child link="wheel_rr"/><origin/>"#,
    );
    let error = robot(&[BASE, &link("fork", ""), &steer, &all]).unwrap_err();
    assert!(matches!(error.fault(), Fault::NoRollers { wheels, .. } if wheels.len() == 3));
    let said = error.to_string();
    assert!(
        said.contains("left out: `wheel_rr_joint` (hangs by an upright joint that steers it)"),
        "{said}"
    );
}

/// The sentences of a refusal that lists joints.
#[test]
fn a_file_without_wheels_says_what_was_looked_at() {
    let arm: String = (0..6)
        .map(|k| {
            let (above, own) = (
                if k == 0 {
                    "base".to_owned()
                } else {
                    format!("arm{}", k - 1)
                },
                format!("arm{k}"),
            );
            link(&own, "")
                + &joint(
                    &format!("joint{k}"),
                    "revolute",
                    [&above, &own],
                    r#"xyz="0 0 0.2""#,
                    "0 0 1",
                )
                .replace(
                    "<axis",
                    r#"<limit lower="-1" upper="1" effort="1" velocity="1"/><axis"#,
                )
        })
        .collect();
    let said = robot(&[BASE, &arm]).unwrap_err().to_string();
    assert_eq!(
        said,
        "r.urdf:1: `<robot>`: no wheels with passive rollers, but moving freely in the plane takes three. Looked at: `joint0` turns within limits, and it has \
         no geometry; `joint1` turns within limits, and it has no geometry; `joint2` turns within limits, and it has no geometry; and 3 more. The file has 7 \
         links, and joints of which 6 turn within limits"
    );
    assert!(said.len() < 2 * 240);
}
