//! Joints that are neither a wheel's nor a roller's: which of them move, what is read of them, and which are refused.

use ilon_formats::{JointOptions, LoadOptions, LoadRobot, Loaded, RoleOption};
use ilon_robot::{JointKind, JointRole, Robot};
use nalgebra::Vector3;
use test_case::test_case;

const MASS: &str = r#"<inertial><mass value="0.5"/><inertia ixx="3.5e-4" ixy="0" ixz="0" iyy="6.25e-4" iyz="0" izz="3.5e-4"/></inertial>"#;
const DISC: &str = r#"<collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.04"/></geometry></collision>"#;
const LIMIT: &str = r#"<limit lower="-0.1" upper="0.1" effort="0" velocity="0"/>"#;

/// Four wheels of which the front ones hang by joint `rock` of a kind, about an axis, with something in it, and a link of a mass.
fn text((kind, axis): (&str, &str), inside: &str, mass: &str) -> String {
    let mut text = format!(
        r#"<robot name="r"><link name="base_link"><inertial><mass value="8"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.15"/></inertial></link>
        <link name="rocker">{mass}</link><joint name="rock" type="{kind}"><parent link="base_link"/><child link="rocker"/><origin xyz="0.15 0 0.01"/>
        <axis xyz="{axis}"/>{inside}</joint>"#
    );
    for (name, x, y) in [
        ("front_left", 0.0, 0.13),
        ("front_right", 0.0, -0.13),
        ("rear_left", -0.15, 0.13),
        ("rear_right", -0.15, -0.13),
    ] {
        let (parent, z) = if x == 0.0 {
            ("rocker", 0.0)
        } else {
            ("base_link", 0.01)
        };
        text += &format!(
            r#"<link name="mecanum_{name}_link">{MASS}{DISC}</link><joint name="mecanum_{name}" type="continuous"><parent link="{parent}"/>
            <child link="mecanum_{name}_link"/><origin xyz="{x} {y} {z}"/><axis xyz="0 1 0"/></joint>"#
        );
    }
    text + "</robot>"
}

fn load(text: &str, asked: &[(&str, JointOptions)]) -> Result<Loaded, String> {
    let mut options = LoadOptions::default();
    for (name, joint) in asked {
        options.joints.insert((*name).to_owned(), joint.clone());
    }
    Robot::from_urdf_str_with(text, "r.urdf", &options).map_err(|error| error.to_string())
}

fn remarked(robot: &Robot, subject: &str, words: &str) -> bool {
    let mut remarks = robot.remarks.iter();
    remarks.any(|remark| remark.subject == subject && remark.text.contains(words))
}

#[test]
fn a_rocker_that_nothing_drives_is_free_with_its_limits_and_damping() {
    let inside = format!(r#"{LIMIT}<dynamics damping="0.3" friction="0.2"/>"#);
    let robot = load(&text(("revolute", "1 0 0"), &inside, MASS), &[])
        .unwrap()
        .robot;
    let [joint] = &robot.joints[..] else {
        panic!("{:?}", robot.joints);
    };
    assert_eq!(
        (joint.name.as_str(), joint.kind),
        ("rock", JointKind::Turns)
    );
    assert_eq!((joint.role, joint.parent), (JointRole::Free, None));
    assert_eq!(joint.limits, [-0.1, 0.1]);
    assert_eq!((joint.damping, joint.friction), (0.3, 0.2));
    let axis = joint.body_from_joint.rotation * Vector3::z();
    assert!((axis - Vector3::x()).norm() < 1e-12);
    assert!((joint.center_of_mass_m() - Vector3::new(0.15, 0.0, 0.01)).norm() < 1e-12);
    let carriers: Vec<_> = robot.wheels.iter().map(|wheel| wheel.carrier).collect();
    assert_eq!(carriers, [Some(0), Some(0), None, None]);
    assert!(remarked(&robot, "joint `rock`", "free: nothing drives it"));
    // Its body is no part of the chassis any more.
    assert!((robot.chassis.mass.mass_kg - 8.0).abs() < 1e-12);
    assert!((robot.mass_kg() - 10.5).abs() < 1e-12);
}

/// What something drives, and what could only fall to its stop, is held.
#[test_case(("revolute", "1 0 0"), r#"<limit lower="-0.1" upper="0.1" effort="5" velocity="1"/>"#; "a joint with an effort")]
#[test_case(("revolute", "0 1 0"), LIMIT; "an arm with its wheels on its axis")]
#[test_case(("prismatic", "0 0 1"), LIMIT; "a slide whose spring nobody says")]
fn what_is_driven_or_would_fall_is_held(joint: (&str, &str), inside: &str) {
    let robot = load(&text(joint, inside, MASS), &[]).unwrap().robot;
    assert!(robot.joints.is_empty(), "{:?}", robot.joints);
    assert!(remarked(&robot, "joint `rock`", "held at zero"));
    assert!((robot.chassis.mass.mass_kg - 8.5).abs() < 1e-12);
}

#[test]
fn a_spring_that_is_asked_for_is_there() {
    let spring = JointOptions {
        stiffness_n_m: Some(4000.0),
        damping_n_s_m: Some(20.0),
        preload_n: Some(-3.0),
        ..JointOptions::default()
    };
    let robot = load(
        &text(("prismatic", "0 0 1"), LIMIT, MASS),
        &[("rock", spring)],
    )
    .unwrap()
    .robot;
    let joint = &robot.joints[0];
    assert_eq!((joint.kind, joint.damping), (JointKind::Slides, 20.0));
    let spring = joint.spring().expect("it is sprung");
    assert_eq!(spring.force_at(0.01), -43.0);
    // What it stores is what it gives back: the mean force over the way.
    let stored_j = joint.stored_j(0.01) - joint.stored_j(0.0);
    assert!((stored_j - 0.01 * 0.5 * (3.0 + 43.0)).abs() < 1e-12);
}

fn with(change: impl Fn(&mut JointOptions)) -> JointOptions {
    let mut options = JointOptions::default();
    change(&mut options);
    options
}

const ROCKER: (&str, &str) = ("revolute", "1 0 0");

#[test_case(ROCKER, LIMIT, MASS, with(|o| o.role = Some(RoleOption::Sprung)), "without a stiffness"; "sprung without a stiffness")]
#[test_case(ROCKER, LIMIT, MASS, with(|o| o.stiffness_n_m = Some(1.0)), "write `stiffness_n_m_rad`"; "the unit of a slide")]
#[test_case(ROCKER, LIMIT, MASS, with(|o| o.stiffness_n_m_rad = Some(-1.0)), "above 0"; "a stiffness below 0")]
#[test_case(ROCKER, LIMIT, MASS, with(|o| o.friction_n_m = Some(f64::NAN)), "not below 0"; "a friction that is no number")]
#[test_case(ROCKER, LIMIT, MASS, with(|o| (o.role, o.rest_rad) = (Some(RoleOption::Held), Some(0.1))), "it is held"; "held, and sprung")]
#[test_case(ROCKER, LIMIT, MASS, with(|o| (o.role, o.rest_rad) = (Some(RoleOption::Free), Some(0.1))), "it is free"; "free, and sprung")]
#[test_case(ROCKER, LIMIT, MASS, with(|_| ()), "nobody says"; "nothing at all")]
#[test_case(ROCKER, LIMIT, "", with(|o| o.role = Some(RoleOption::Free)), "no mass"; "a body without mass")]
#[test_case(ROCKER, r#"<limit lower="0.1" upper="-0.1" effort="0" velocity="0"/>"#, MASS, with(|o| o.role = Some(RoleOption::Free)), "not below its upper"; "limits the wrong way round")]
#[test_case(("fixed", "1 0 0"), "", MASS, with(|o| o.role = Some(RoleOption::Free)), "it is fixed"; "a fixed joint")]
#[test_case(("floating", "1 0 0"), "", MASS, with(|o| o.role = Some(RoleOption::Free)), "floats"; "a floating joint")]
fn what_cannot_be_is_refused_in_words(
    joint: (&str, &str),
    inside: &str,
    mass: &str,
    asked: JointOptions,
    words: &str,
) {
    let error = load(&text(joint, inside, mass), &[("rock", asked)]).unwrap_err();
    assert!(error.contains(words) && error.contains("rock"), "{error}");
}

#[test]
fn a_joint_that_is_not_there_and_one_of_a_wheel_are_refused() {
    let free = || with(|options| options.role = Some(RoleOption::Free));
    let text = text(ROCKER, LIMIT, MASS);
    let error = load(&text, &[("rok", free())]).unwrap_err();
    assert!(error.contains("there is no joint `rok`"), "{error}");
    let error = load(&text, &[("mecanum_rear_left", free())]).unwrap_err();
    assert!(error.contains("a wheel's or a roller's own"), "{error}");
}

/// A differential bar as URDF has it: a joint that follows another.
#[test]
fn a_mimic_joint_is_coupled_to_the_joint_that_it_follows() {
    let mut text = text(ROCKER, LIMIT, MASS);
    let bar = format!(
        r#"<link name="bar">{MASS}</link><joint name="bar_joint" type="revolute"><parent link="base_link"/><child link="bar"/><axis xyz="1 0 0"/>{LIMIT}
        <mimic joint="rock" multiplier="-0.5" offset="0.01"/></joint></robot>"#
    );
    text = text.replace("</robot>", &bar);
    let free = with(|options| options.role = Some(RoleOption::Free));
    let robot = load(&text, &[("bar_joint", free)]).unwrap().robot;
    let [coupling] = robot.couplings[..] else {
        panic!("{:?}", robot.couplings);
    };
    let name = |place: usize| robot.joints[place].name.as_str();
    assert_eq!(
        (name(coupling.joint), name(coupling.follows)),
        ("bar_joint", "rock")
    );
    assert_eq!((coupling.factor, coupling.offset), (-0.5, 0.01));
}
