//! Robots as users build them: joints to the world above the base, decorative rollers, wheels that
//! do not match the others.

use ilon_formats::{Fault, Handedness, LoadOptions, LoadRobot, Remedy, RobotError};
use ilon_robot::Robot;
use test_case::test_case;

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

/// Wheels with a disc, each below a link.
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

/// Slides along x and y and a turn, each with its own link, above wheels with and without rollers.
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
    // Modelled rollers stay rollers of the wheels.
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

/// A cylinder on a cross joint in the hub, and two on its rim: they do not roll on the floor, and
/// are part of the wheel.
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

/// Wheels without mass and shape: a radius alone does not make them wheels, so it is not requested
/// alone; the obstacle is reported.
#[test]
fn a_question_that_no_answer_helps_says_what_stands_in_the_way() {
    let folder = tempfile::tempdir().unwrap();
    let diagnose = |text: &str| {
        let path = folder.path().join("r.urdf");
        std::fs::write(&path, format!(r#"<robot name="r">{text}</robot>"#)).unwrap();
        let diagnosis = Robot::diagnose(&path, &LoadOptions::default(), |_| true);
        diagnosis.question.expect("a question")
    };
    let bare = |name: &str| format!(r#"<link name="{name}"/>"#);
    let all = |link: &dyn Fn(&str) -> String| {
        let wheel = |(name, x, y): (&str, f64, f64)| {
            let own = format!("mecanum_{name}");
            link(&own)
                + &joint(
                    &own,
                    "continuous",
                    ["base", &own],
                    &format!(r#"xyz="{x} {y} 0""#),
                    "0 1 0",
                )
        };
        BASE.to_owned() + &PLACES.map(wheel).concat()
    };
    let blocked = diagnose(&all(&bare)).in_the_way.expect("blocked");
    assert!(
        blocked.contains("neither it nor anything fixed to it has mass"),
        "{blocked}"
    );
    // With mass only the radius is requested.
    let question = diagnose(&all(&|name| link(name, "")));
    assert_eq!(
        (&question.asked[..], question.in_the_way),
        (&[Remedy::WheelRadius { guess_m: None }][..], None)
    );
    // Wheels in a line: with any rollers, they do not form an X.
    let line = all(&|name| link(name, DISC))
        .replace("mecanum_", "plain_")
        .replace("-0.18", "0.18");
    let question = diagnose(&line);
    assert!(
        question
            .in_the_way
            .is_some_and(|what| what.contains("middle line"))
    );
}

/// Arguments without a value are requested together.
#[test]
fn all_arguments_that_are_missing_are_asked_for_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.xacro");
    std::fs::write(
        &path,
        format!(
            r#"<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="half"/><xacro:arg name="other"/>
<xacro:property name="h" value="$(arg half)"/><xacro:property name="o" value="$(arg other)"/>{BASE}
<xacro:if value="${{h == 'left'}}"><link name="x"/></xacro:if><xacro:if value="${{o == 'left'}}"><link name="y"/></xacro:if></robot>"#
        ),
    )
    .unwrap();
    let diagnosis = Robot::diagnose(&path, &LoadOptions::default(), |_| true);
    let names: Vec<String> = diagnosis
        .question
        .expect("a question")
        .asked
        .into_iter()
        .filter_map(|remedy| match remedy {
            Remedy::Argument { name, .. } => Some(name),
            _ => None,
        })
        .collect();
    assert_eq!(names, ["half", "other"]);
}

/// `<insert_block>` without its prefix inserts nothing: all wheels would be in one place. The
/// repair reads it.
#[test]
fn blocks_of_xacro_without_their_prefix_are_repaired() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.xacro");
    let calls = PLACES.map(|(name, x, y)| {
        format!(r#"<xacro:wheel name="mecanum_{name}"><origin xyz="{x} {y} 0"/></xacro:wheel>"#)
    });
    let wheel = link("${name}", DISC);
    std::fs::write(
        &path,
        format!(
            r#"<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:macro name="wheel" params="name *place">{wheel}
<joint name="${{name}}_joint" type="continuous"><parent link="base"/><child link="${{name}}"/><insert_block name="place"/><axis xyz="0 1 0"/></joint></xacro:macro>
{BASE}{}</robot>"#,
            calls.concat()
        ),
    )
    .unwrap();
    let error = Robot::load(&path).unwrap_err();
    assert!(
        matches!(error.fault(), Fault::OldXacro { tag } if tag == "insert_block"),
        "{error}"
    );
    assert_eq!(error.line(), Some(3));
    let diagnosis = Robot::diagnose(&path, &LoadOptions::default(), |_| true);
    assert!(diagnosis.proposal.is_some_and(|options| options.repair));
    assert_eq!(
        gammas(&diagnosis.loaded.unwrap().robot),
        [-45.0, 45.0, 45.0, -45.0]
    );
}

/// The axis of the roller on the ground is the direction of larger friction, in whichever order the
/// two are given. In the wheel's frame it turns with the wheel, which is remarked.
#[test]
fn directions_of_friction_are_read_in_either_order() {
    let text = |fdir1: &dyn Fn(f64) -> String| {
        let settings = PLACES.map(|(name, x, y)| {
            format!(
                r#"<gazebo reference="plain_{name}">{}</gazebo>"#,
                fdir1(-(x * y).signum())
            )
        });
        format!("{BASE}{}{}", wheels("plain", "base"), settings.concat())
    };
    // Along (1, -1) at the front left and the rear right: gamma is -45 there.
    let along = |side: f64| {
        format!(r#"<mu1>1</mu1><mu2>0</mu2><fdir1 expressed_in="base">1 {side} 0</fdir1>"#)
    };
    let across = |side: f64| {
        format!(
            r#"<mu1>0</mu1><mu2>1</mu2><fdir1 expressed_in="base">1 {} 0</fdir1>"#,
            -side
        )
    };
    for fdir1 in [&along as &dyn Fn(f64) -> String, &across] {
        assert_eq!(
            gammas(&robot(&[&text(fdir1)]).unwrap()),
            [-45.0, 45.0, 45.0, -45.0]
        );
    }
    // Along and across parallel hubs, plain wheels have it that slide sideways: tyres are offered,
    // and no omni wheels, which could not drive.
    let ahead =
        |_: f64| r#"<mu1>1</mu1><mu2>0</mu2><fdir1 expressed_in="base">1 0 0</fdir1>"#.to_owned();
    let help = robot(&[&text(&ahead)]).unwrap_err().help();
    assert!(help.contains("let them roll on tyres"), "{help}");
    // In the wheel's own frame: proposed if it is oblique; otherwise a plain wheel may have it too.
    let turning = |side: f64| format!("<mu1>1</mu1><mu2>0</mu2><fdir1>1 {side} 0</fdir1>");
    let error = robot(&[&text(&turning)]).unwrap_err();
    let help = error.help();
    assert!(
        help.contains("the `<fdir1>` of `plain_fl` and the others"),
        "{help}"
    );
    let [Remedy::Rollers(rollers)] = &error.remedies()[..] else {
        panic!("{:?}", error.remedies());
    };
    assert_eq!(
        rollers.gamma,
        Handedness::EachDeg(vec![-45.0, 45.0, 45.0, -45.0])
    );
    let ahead = |_: f64| "<mu1>1</mu1><mu2>0</mu2><fdir1>1 0 0</fdir1>".to_owned();
    let help = robot(&[&text(&ahead)]).unwrap_err().help();
    assert!(
        help.contains("`<fdir1>` of `plain_fl` names no frame but the wheel's own"),
        "{help}"
    );
}

/// A friction that is not a number does not count as 1, with which `mu2` 0 would grip along the
/// direction: it is named with its line.
#[test_case("abc"; "words")]
#[test_case(""; "nothing")]
#[test_case("1,0"; "a decimal comma")]
#[test_case("nan"; "not a number")]
fn frictions_that_are_no_numbers_are_named_with_their_line(mu: &str) {
    let settings = PLACES.map(|(name, x, y)| {
        let side = -(x * y).signum();
        format!(
            r#"<gazebo reference="plain_{name}">
<mu1>{mu}</mu1><mu2>0</mu2><fdir1 expressed_in="base">1 {side} 0</fdir1></gazebo>"#
        )
    });
    let before = format!("{BASE}{}", wheels("plain", "base"));
    let help = robot(&[&before, &settings.concat()]).unwrap_err().help();
    let said = format!("is not a number, but `{mu}`");
    let named = help.contains("the `<fdir1>` of `plain_fl` cannot be used: the `mu1` on line ");
    assert!(named && help.contains(&said), "{help}");
}

/// Fixed roller joints are one fault, which a repair fixes; the chassis's clearance is relative to
/// the floor of the rollers, not of the hub. Joints with a stop after a turn are treated as
/// continuous, with a remark; unreachable stops are ignored.
#[test]
fn rollers_that_do_not_turn_are_a_fault_and_stops_a_remark() {
    let plain = crate::common::small();
    let with_rollers = |kind: &str| {
        let line = |line: &str| match line.contains("<joint") && line.contains("_roller_") {
            true => line.replace("type=\"continuous\"", kind),
            false => line.to_owned(),
        };
        plain.lines().map(line).collect::<Vec<_>>().join("\n")
    };
    let fixed = with_rollers("type=\"fixed\"");
    let error = Robot::from_urdf_str(&fixed, "small.urdf").unwrap_err();
    assert!(error.others().is_empty(), "{error}");
    let Fault::RollersDoNotTurn { wheels, .. } = error.fault() else {
        panic!("{error}");
    };
    assert_eq!(wheels.len(), 3, "{error}");
    let mut options = LoadOptions::default();
    options.repair = true;
    let repaired = Robot::from_urdf_str_with(&fixed, "small.urdf", &options)
        .unwrap()
        .robot;
    let whole = Robot::from_urdf_str(&plain, "small.urdf").unwrap();
    let sizes = |robot: &Robot| -> Vec<(usize, f64)> {
        robot
            .wheels
            .iter()
            .map(|wheel| (wheel.rollers.len(), wheel.radius_m))
            .collect()
    };
    assert_eq!(sizes(&repaired), sizes(&whole));
    let stopped = |most: &str| {
        let limit = format!(
            "type=\"revolute\"><limit lower=\"-{most}\" upper=\"{most}\" effort=\"1\" velocity=\"99\"/"
        );
        let text = with_rollers(&limit).replace("<limit effort=\"0\" velocity=\"1000\"/>", "");
        let robot = Robot::from_urdf_str(&text, "small.urdf").unwrap();
        let said = robot.remarks.iter().map(ToString::to_string);
        said.filter(|said| said.contains("its limits stop it after"))
            .count()
    };
    assert!(stopped("3.15") > 10);
    assert_eq!(stopped("1e16"), 0);
}

/// Three rollers of four have a shape: the ring of their axes, 38 mm, and their radius, 12 mm,
/// determine the wheel; a hub of 42 mm with the inertia of such a disc does not.
#[test]
fn a_hub_is_no_clue_where_rollers_are_known() {
    let mut text = crate::common::small();
    let plain = Robot::from_urdf_str(&text, "small.urdf").unwrap();
    assert!((plain.wheels[0].radius_m - 0.05).abs() < 1e-9);
    // One roller of each wheel loses its shape.
    for wheel in 1..=3 {
        let start = text
            .find(&format!("<link name=\"wheel_{wheel}_roller_1_link\""))
            .unwrap();
        let end = start + text[start..].find("</link>").unwrap();
        let shapes = ["<visual", "<collision"].map(|tag| text[start..end].find(tag));
        let kept = shapes.into_iter().flatten().min().unwrap();
        text.replace_range(start + kept..end, "");
    }
    let hub = r#"<visual><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.042" length="0.02"/></geometry></visual>"#;
    let text = text.replace(
        "<link name=\"wheel_1_link\">",
        &format!("<link name=\"wheel_1_link\">{hub}"),
    );
    let error = Robot::from_urdf_str(&text, "small.urdf").unwrap_err();
    let Fault::WheelSizeUnknown { clues, .. } = error.fault() else {
        panic!("{error}");
    };
    let radii: Vec<f64> = clues
        .clues
        .iter()
        .flat_map(|clue| clue.radii_m.clone())
        .collect();
    assert!(radii.iter().any(|m| (m - 0.05).abs() < 1e-4), "{clues:?}");
    assert!(
        clues.proposed_m().is_none_or(|m| (m - 0.05).abs() < 1e-4),
        "{clues:?}"
    );
}
