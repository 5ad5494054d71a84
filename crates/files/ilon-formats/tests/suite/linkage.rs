//! Joints of neither wheels nor rollers: which of them move, their properties, and refusals.

use ilon_formats::{JointOptions, LoadOptions, LoadRobot, Loaded, RoleOption};
use ilon_robot::{JointKind, JointRole, JointServo, JointSpring, Robot, Roller, Wheel};
use nalgebra::Vector3;
use test_case::test_case;

const MASS: &str = r#"<inertial><mass value="0.5"/><inertia ixx="3.5e-4" ixy="0" ixz="0" iyy="6.25e-4" iyz="0" izz="3.5e-4"/></inertial>"#;
const DISC: &str = r#"<collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.04"/></geometry></collision>"#;
const LIMIT: &str = r#"<limit lower="-0.1" upper="0.1" effort="0" velocity="0"/>"#;

/// Four wheels, of which the front ones are on joint `rock` of a kind, about an axis, with
/// additional content, and a link of a mass.
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
    // Its body is no longer a part of the chassis.
    assert!((robot.chassis.mass.mass_kg - 8.0).abs() < 1e-12);
    assert!((robot.mass_kg() - 10.5).abs() < 1e-12);
}

/// A joint that is driven, or that could only fall to its stop, is held.
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
    // The stored energy is the work that it returns: the mean force over the path.
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

/// A differential bar in URDF: a joint that mimics another.
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

const DRIVEN: &str = r#"<limit lower="-0.1" upper="0.1" effort="5" velocity="2"/>"#;

/// A servo has the limits of the file and gains for the moving inertia, so that naming the role is
/// sufficient.
#[test]
fn a_driven_joint_has_the_limits_of_its_file_and_gains_of_what_it_moves() {
    let driven = with(|o| o.role = Some(RoleOption::Driven));
    let text = text(ROCKER, DRIVEN, MASS);
    let robot = load(&text, &[("rock", driven.clone())]).unwrap().robot;
    let servo = *robot.joints[0].servo().expect("it is driven");
    // Two wheels of 0.5 kg at 0.13 m, and the inertia across the axle of each and of the body,
    // without that of rollers about their axles, on which they turn freely.
    let rolls = |wheel: &Wheel| -> f64 {
        let along = |roller: &Roller| (wheel.body_from_hub * roller.axis_in_hub.into_inner()).x;
        let rollers = wheel.rollers.iter();
        let each = rollers.map(|roller| roller.axial_inertia_kg_m2 * along(roller).powi(2));
        each.sum()
    };
    let of_wheels = robot.wheels[..2]
        .iter()
        .map(|wheel| 0.5 * 0.13 * 0.13 + 3.5e-4 - rolls(wheel));
    let inertia = of_wheels.sum::<f64>() + 3.5e-4;
    let expected = JointServo {
        effort: 5.0,
        rate_limit: 2.0,
        ..JointServo::for_inertia(inertia)
    };
    assert!((servo.stiffness / expected.stiffness - 1.0).abs() < 1e-9);
    assert!((servo.damping / expected.damping - 1.0).abs() < 1e-9);
    assert_eq!((servo.effort, servo.rate_limit), (5.0, 2.0));
    assert!(remarked(&robot, "joint `rock`", "10 Hz, critically damped"));
    let said = with(|o| {
        (o.role, o.stiffness_n_m_rad) = (Some(RoleOption::Driven), Some(400.0));
        (o.effort_n_m, o.rate_limit_rad_s, o.target_rad) = (Some(3.0), Some(1.0), Some(0.05));
    });
    let robot = load(&text, &[("rock", said)]).unwrap().robot;
    let servo = *robot.joints[0].servo().expect("it is driven");
    assert_eq!((servo.stiffness, servo.effort), (400.0, 3.0));
    assert_eq!((servo.rate_limit, servo.target), (1.0, 0.05));
    assert!((servo.damping - JointServo::damping_for(inertia, 400.0)).abs() < 1e-9);
}

fn servo(change: impl Fn(&mut JointOptions)) -> JointOptions {
    with(|o| {
        o.role = Some(RoleOption::Driven);
        change(o);
    })
}

#[test_case(servo(|o| o.effort_n = Some(1.0)), "write `effort_n_m`"; "the effort of a slide")]
#[test_case(servo(|o| o.effort_n_m = Some(0.0)), "above 0"; "no effort")]
#[test_case(servo(|o| o.rate_limit_rad_s = Some(-1.0)), "above 0"; "a rate below zero")]
#[test_case(servo(|o| o.target_rad = Some(0.2)), "beyond its limits"; "a target beyond the limits")]
#[test_case(servo(|o| o.preload_n_m = Some(1.0)), "preload of a spring"; "a spring's preload")]
#[test_case(with(|o| o.target_rad = Some(0.1)), "role = \"driven\""; "a target without a servo")]
#[test_case(with(|o| (o.role, o.effort_n_m) = (Some(RoleOption::Free), Some(1.0))), "role = \"driven\""; "the effort of a free joint")]
fn what_no_servo_can_be_is_refused_in_words(asked: JointOptions, words: &str) {
    let error = load(&text(ROCKER, DRIVEN, MASS), &[("rock", asked)]).unwrap_err();
    assert!(error.contains(words) && error.contains("rock"), "{error}");
}

/// Four wheels, of which the front ones are on joint `rock`, in SDF; `dynamics` is the content of
/// that joint.
fn sdf(dynamics: &str) -> String {
    let inertial = |mass: f64| {
        format!(
            "<inertial><mass>{mass}</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>"
        )
    };
    let mut text = format!(
        r#"<sdf version="1.9"><model name="r"><link name="base">{}</link>
        <link name="rocker"><pose>0.15 0 0.01 0 0 0</pose>{}</link>
        <joint name="rock" type="prismatic"><parent>base</parent><child>rocker</child>
        <axis><xyz>0 0 1</xyz><limit><lower>-0.02</lower><upper>0.03</upper></limit>{dynamics}</axis></joint>"#,
        inertial(8.0),
        inertial(0.5)
    );
    for (name, parent, x, y) in [
        ("front_left", "rocker", 0.15, 0.13),
        ("front_right", "rocker", 0.15, -0.13),
        ("rear_left", "base", -0.15, 0.13),
        ("rear_right", "base", -0.15, -0.13),
    ] {
        text += &format!(
            r#"<link name="mecanum_{name}_link"><pose>{x} {y} 0.01 0 0 0</pose>{}<collision name="c"><pose>0 0 0 1.5707963267948966 0 0</pose>
            <geometry><cylinder><radius>0.05</radius><length>0.04</length></cylinder></geometry></collision></link>
            <joint name="mecanum_{name}" type="revolute"><parent>{parent}</parent><child>mecanum_{name}_link</child><axis><xyz>0 1 0</xyz></axis></joint>"#,
            inertial(0.5)
        );
    }
    text + "</model></sdf>"
}

/// The force is -stiffness (q - reference) - damping times the rate, as in Gazebo.
#[test]
fn a_spring_of_sdf_is_read() {
    let dynamics = "<dynamics><damping>60</damping><friction>2</friction><spring_stiffness>4000</spring_stiffness>\
                    <spring_reference>-0.006</spring_reference></dynamics>";
    let robot = load(&sdf(dynamics), &[]).unwrap().robot;
    let joint = &robot.joints[0];
    assert_eq!(joint.limits, [-0.02, 0.03]);
    assert_eq!((joint.damping, joint.friction), (60.0, 2.0));
    let spring = joint.spring().expect("it is sprung");
    assert!((spring.force_at(0.01) + 4000.0 * 0.016).abs() < 1e-9);
    assert!(remarked(&robot, "joint `rock`", "4000 N/m about -0.006 m"));
    // Without stiffness it is held, as a slide without support.
    let dynamics = "<dynamics><spring_stiffness>0</spring_stiffness></dynamics>";
    assert!(load(&sdf(dynamics), &[]).unwrap().robot.joints.is_empty());
    // The scenario overrides it.
    let held = with(|o| o.role = Some(RoleOption::Held));
    let dynamics = "<dynamics><spring_stiffness>4000</spring_stiffness></dynamics>";
    let robot = load(&sdf(dynamics), &[("rock", held)]).unwrap().robot;
    assert!(robot.joints.is_empty());
}

/// The same robot in MJCF, whose joint `rock` is a hinge about x with these attributes, and whose
/// angles are in degrees.
fn mjcf(attributes: &str, default: &str) -> String {
    let wheel = |name: &str, x: f64, y: f64| {
        format!(
            r#"<body name="mecanum_{name}_link" pos="{x} {y} 0"><joint name="mecanum_{name}" axis="0 1 0"/>
            <geom type="cylinder" size="0.05 0.02" zaxis="0 1 0" mass="0.5"/></body>"#
        )
    };
    format!(
        r#"<mujoco><default><default class="susp"><joint {default}/></default></default><worldbody><body name="base" pos="0 0 0.04"><freejoint/>
        <geom type="box" size="0.2 0.1 0.03" mass="8"/>
        <body name="rocker" pos="0.15 0 0"><joint name="rock" class="susp" axis="1 0 0" {attributes}/>
        <geom type="box" size="0.02 0.1 0.01" mass="0.5" contype="0" conaffinity="0"/>{}{}</body>{}{}</body></worldbody></mujoco>"#,
        wheel("front_left", 0.0, 0.13),
        wheel("front_right", 0.0, -0.13),
        wheel("rear_left", -0.15, 0.13),
        wheel("rear_right", -0.15, -0.13),
    )
}

/// MuJoCo's force is -stiffness (q - springref), with the body drawn at q = ref, angles in degrees;
/// attributes are inherited from classes.
#[test]
fn a_spring_of_mjcf_is_read_with_its_reference_and_class() {
    let attributes = r#"springref="3" ref="1" range="-9 11" limited="true" frictionloss="0.2""#;
    let robot = load(&mjcf(attributes, r#"stiffness="40" damping="0.5""#), &[]);
    let robot = robot.unwrap().robot;
    let joint = &robot.joints[0];
    assert_eq!((joint.damping, joint.friction), (0.5, 0.2));
    let JointRole::Sprung(JointSpring {
        stiffness, rest, ..
    }) = joint.role
    else {
        panic!("{joint:?}");
    };
    assert_eq!(stiffness, 40.0);
    assert!((rest - 2.0_f64.to_radians()).abs() < 1e-12, "{rest}");
    let limits = joint.limits.map(f64::to_degrees);
    assert!(
        (limits[0] + 10.0).abs() < 1e-9 && (limits[1] - 10.0).abs() < 1e-9,
        "{limits:?}"
    );
    assert!(remarked(&robot, "joint `rock`", "as the file says"));
    let plain = load(&mjcf(r#"springdamper="0.1 1" range="-9 11""#, ""), &[]);
    let plain = plain.unwrap().robot;
    assert!(remarked(&plain, "joint `rock`", "`springdamper`"));
    // A rest position that the joint cannot reach would pull permanently.
    let far = r#"stiffness="40" springref="-9223372036854775808" range="-9 11""#;
    let far = load(&mjcf(far, ""), &[]).unwrap().robot;
    assert!(remarked(&far, "joint `rock`", "which no joint reaches"));
}

/// A link without mass that carries wheels moves with 1 % of what they weigh, which is said: 10 g of
/// two wheels of 0.5 kg, at their common centre. One that carries nothing that weighs cannot move.
#[test]
fn a_link_without_mass_takes_a_share_of_what_it_carries() {
    let robot = load(&text(("revolute", "1 0 0"), LIMIT, ""), &[])
        .unwrap()
        .robot;
    let [rocker] = &robot.joints[..] else {
        panic!("{:?}", robot.joints);
    };
    assert!(rocker.role == JointRole::Free, "{:?}", rocker.role);
    let mass = &rocker.body.mass;
    assert!((mass.mass_kg - 0.01).abs() < 1e-12 && mass.center_of_mass_m.norm() < 1e-12);
    assert!(remarked(
        &robot,
        "joint `rock`",
        "takes 1 % of what it carries, 10.000 g"
    ));
    let empty = r#"<link name="flag"/><joint name="rock" type="revolute"><parent link="base_link"/><child link="flag"/>
        <axis xyz="1 0 0"/><limit lower="-0.1" upper="0.1" effort="0" velocity="0"/></joint></robot>"#;
    let alone = text(("fixed", "1 0 0"), "", MASS).replace("\"rock\"", "\"bar\"");
    let alone = alone.replace("</robot>", empty);
    let free = with(|o| o.role = Some(RoleOption::Free));
    let error = load(&alone, &[("rock", free)]).unwrap_err();
    assert!(
        error.contains("no mass") && error.contains("flag"),
        "{error}"
    );
}

/// A rocker that is held because of an error reports it, with what would make it free.
#[test_case(r#"<limit lower="0.1" upper="-0.1" effort="0" velocity="0"/>"#, MASS, "exchange them"; "limits the wrong way round")]
#[test_case(r#"<limit lower="0" upper="0" effort="0" velocity="0"/>"#, MASS, "held: both of its limits are 0, so that it cannot move; set them apart"; "no way at all")]
#[test_case(r#"<limit lower="-0.1" upper="0.1" effort="0" velocity="0"/><mimic joint="rock"/>"#, MASS, "it mimics itself"; "a mimic of itself")]
#[test_case(r#"<limit lower="-0.1" upper="0.1" effort="0" velocity="0"/><mimic joint="nobody"/>"#, MASS, "which is no joint of the file"; "a mimic of nobody")]
#[test_case(r#"<limit lower="-0.1" upper="0.1" effort="0" velocity="0"/><mimic joint="mecanum_rear_left"/>"#, MASS, "give that one a role"; "a mimic of a wheel")]
fn a_rocker_that_is_held_says_why(inside: &str, mass: &str, words: &str) {
    let robot = load(&text(("revolute", "1 0 0"), inside, mass), &[]);
    let robot = robot.unwrap().robot;
    assert!(robot.joints.is_empty(), "{:?}", robot.joints);
    assert!(
        remarked(&robot, "joint `rock`", words),
        "{:?}",
        robot.remarks
    );
}

#[test]
fn a_mimic_by_no_number_is_refused() {
    let inside = format!(r#"{LIMIT}<mimic joint="mecanum_rear_left" multiplier="nan"/>"#);
    let refused = load(&text(("revolute", "1 0 0"), &inside, MASS), &[]).unwrap_err();
    assert!(refused.contains("multiplier"), "{refused}");
}

/// `<ilon_spring>` defines the spring that URDF cannot express.
#[test]
fn a_spring_beside_a_joint_is_read() {
    let said = |spring: &str| {
        let slide = text(("prismatic", "0 0 1"), LIMIT, MASS);
        load(
            &slide.replace("</robot>", &format!("{spring}</robot>")),
            &[],
        )
    };
    let robot = said(r#"<ilon_spring joint="rock" stiffness="4000" rest="-0.006" preload="3"/>"#);
    let robot = robot.unwrap().robot;
    let spring = robot.joints[0].spring().expect("it is sprung");
    assert!((spring.force_at(0.01) - (3.0 - 4000.0 * 0.016)).abs() < 1e-9);
    for (wrong, words) in [
        (r#"<ilon_spring joint="rock"/>"#, "stiffness"),
        (r#"<ilon_spring joint="rock" stiffness="-4"/>"#, "stiffness"),
        (
            r#"<ilon_spring joint="rock" stiffness="4" rest="nan"/>"#,
            "rest",
        ),
        (r#"<ilon_spring joint="rack" stiffness="4"/>"#, "rack"),
        (r#"<ilon_spring stiffness="4"/>"#, "joint"),
    ] {
        let refused = said(wrong).unwrap_err();
        assert!(refused.contains(words), "{refused}");
    }
}

#[test_case("<spring_stiffness>-4000</spring_stiffness>", "must be 0 or above"; "a stiffness below 0")]
#[test_case("<spring_stiffness>stiff</spring_stiffness>", "`spring_stiffness` of joint `rock`"; "a stiffness in words")]
#[test_case("<spring_stiffness>nan</spring_stiffness>", "no finite number"; "a stiffness that is no number")]
#[test_case("<spring_stiffness>4000</spring_stiffness><spring_reference>inf</spring_reference>", "`spring_reference`"; "a reference nowhere")]
fn a_spring_of_sdf_that_cannot_be_is_refused(inside: &str, words: &str) {
    let refused = load(&sdf(&format!("<dynamics>{inside}</dynamics>")), &[]).unwrap_err();
    assert!(refused.contains(words), "{refused}");
}

#[test]
fn a_stiffness_of_mjcf_that_cannot_be_is_remarked() {
    let robot = load(&mjcf(r#"stiffness="-5" range="-9 11""#, ""), &[]);
    let robot = robot.unwrap().robot;
    assert!(
        remarked(&robot, "joint `rock`", "no spring's"),
        "{:?}",
        robot.remarks
    );
}

/// A lift driven by the user, whose two further stages mimic it: the second one through the first,
/// which it precedes in the file.
fn stages(first: &str, second: &str, mass: &str) -> String {
    let stage = |name: &str, parent: &str, limit: &str, mimics: &str| {
        format!(
            r#"<link name="{name}_link">{mass}</link><joint name="{name}" type="prismatic"><parent link="{parent}"/><child link="{name}_link"/>
            <axis xyz="0 0 1"/><limit {limit} effort="50" velocity="1"/>{mimics}</joint>"#
        )
    };
    let low = r#"<link name="lift_link"><inertial><mass value="0.5"/><inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial></link>
        <joint name="lift" type="prismatic"><parent link="base_link"/><child link="lift_link"/><axis xyz="0 0 1"/><limit lower="0" upper="0.3" effort="80" velocity="1"/></joint>"#;
    let stages = stage(
        "second",
        "first_link",
        second,
        r#"<mimic joint="first" multiplier="0.5"/>"#,
    ) + &stage(
        "first",
        "lift_link",
        first,
        r#"<mimic joint="lift" multiplier="-2" offset="0.01"/>"#,
    ) + low;
    text(("fixed", "1 0 0"), "", MASS).replace("</robot>", &format!("{stages}</robot>"))
}

const WIDE: &str = r#"lower="-1" upper="1""#;

fn role(role: RoleOption) -> JointOptions {
    JointOptions {
        role: Some(role),
        ..JointOptions::default()
    }
}

/// A joint that mimics a moving joint follows it, and a servo's gains are for all that moves with
/// it: at 1 m/s of the lift its stage moves at -1 m/s and the next at -2 m/s, each of 0.5 kg, so
/// that twice the energy is 0.5 (1 + 1 + 4) J.
#[test]
fn joints_that_mimic_one_that_moves_follow_it() {
    let text = stages(WIDE, WIDE, MASS);
    let robot = load(&text, &[("lift", role(RoleOption::Driven))])
        .unwrap()
        .robot;
    let names: Vec<&str> = robot
        .joints
        .iter()
        .map(|joint| joint.name.as_str())
        .collect();
    assert_eq!(names, ["lift", "first", "second"]);
    assert!(
        robot.joints[1..]
            .iter()
            .all(|joint| joint.role == JointRole::Free)
    );
    let couplings = robot
        .couplings
        .iter()
        .map(|of| (of.joint, of.follows, of.factor, of.offset));
    let couplings: Vec<_> = couplings.collect();
    assert_eq!(couplings, [(1, 0, -2.0, 0.01), (2, 1, 0.5, 0.0)]);
    assert!(remarked(&robot, "joint `second`", "it follows `first`"));
    // 1 - 2 = -1, and -1 + 0.5 (-2) = -2.
    let inertia = robot.inertia_on_joint(0);
    assert!(
        (inertia - 0.5 * (1.0 + 1.0 + 4.0)).abs() < 1e-12,
        "{inertia}"
    );
    let servo = robot.joints[0].servo().expect("it is driven");
    assert!((servo.stiffness / JointServo::stiffness_for(inertia) - 1.0).abs() < 1e-12);
    // If the lift is held, so are its followers; and the user may hold a follower.
    assert!(load(&text, &[]).unwrap().robot.joints.is_empty());
    let held = [
        ("lift", role(RoleOption::Driven)),
        ("first", role(RoleOption::Held)),
    ];
    assert_eq!(load(&text, &held).unwrap().robot.joints.len(), 1);
}

/// A follower that cannot move reports why, and so do its own followers.
#[test_case(r#"lower="0" upper="0""#, WIDE, MASS, "first", "both of its limits are 0", 1; "no way")]
#[test_case(WIDE, r#"lower="1" upper="-1""#, MASS, "second", "is not below its upper one", 2; "limits the wrong way round")]
#[test_case(WIDE, WIDE, "", "first", "which has no mass", 1; "no mass")]
fn a_follower_that_is_held_says_why(
    first: &str,
    second: &str,
    mass: &str,
    joint: &str,
    words: &str,
    moving: usize,
) {
    let lift = ("lift", role(RoleOption::Driven));
    let robot = load(&stages(first, second, mass), &[lift]).unwrap().robot;
    assert_eq!(robot.joints.len(), moving);
    let subject = format!("joint `{joint}`");
    assert!(remarked(&robot, &subject, words), "{:?}", robot.remarks);
    assert!(remarked(&robot, &subject, "though it mimics"));
}

/// Eight springs in a row, as of a gripper's rubber on an arm: six move, as many as may follow one
/// another; the last two are held, with a remark each, where they were refused.
#[test]
fn of_a_long_chain_of_springs_the_last_are_held() {
    let spring = r#"stiffness="40" range="-9 11""#;
    let mut nested = String::new();
    for i in (0..8).rev() {
        let (x, geom) = (
            0.05,
            r#"<geom type="box" size="0.01 0.01 0.01" mass="0.1" contype="0" conaffinity="0"/>"#,
        );
        nested = format!(
            r#"<body name="part{i}" pos="{x} 0 0.02"><joint name="spring{i}" axis="0 0 1" {spring}/>{geom}{nested}</body>"#
        );
    }
    let text = mjcf("range=\"-9 11\"", "").replace(
        r#"<body name="rocker""#,
        &format!(r#"{nested}<body name="rocker""#),
    );
    let robot = load(&text, &[]).unwrap().robot;
    let moves = |name: &str| robot.joints.iter().any(|joint| joint.name == name);
    for i in 0..8 {
        let name = format!("spring{i}");
        assert_eq!(moves(&name), i < 6, "{name}");
        let is_said = remarked(
            &robot,
            &format!("joint `{name}`"),
            "6 joints that move precede it",
        );
        assert_eq!(is_said, i >= 6, "{name}");
    }
}
