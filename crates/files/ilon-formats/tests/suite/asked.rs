//! Questions about an ambiguous file, all at once; and information in files that makes questions
//! unnecessary.

use std::path::Path;

use ilon_formats::{Diagnosis, Fault, Handedness, LoadOptions, LoadRobot, Remedy};
use ilon_robot::Robot;
use test_case::test_case;

/// A chassis of 8 kg with the inertia of a box of 0.4 x 0.2 x 0.1 m, to two digits.
const BODY: &str = r#"<link name="base_link"><inertial><mass value="8"/><inertia ixx="0.033" ixy="0" ixz="0" iyy="0.11" iyz="0" izz="0.13"/></inertial></link>"#;
/// A solid disc of 0.5 kg and 50 mm: 0.5 * 0.5 kg * (50 mm)^2 = 6.25e-4 kg m^2.
const AS_DISC: &str =
    r#"<inertia ixx="3.5e-4" ixy="0" ixz="0" iyy="6.25e-4" iyz="0" izz="3.5e-4"/>"#;
/// A solid ball of 0.5 kg and 50 mm: 0.4 * 0.5 kg * (50 mm)^2 = 5e-4 kg m^2.
const AS_BALL: &str = r#"<inertia ixx="5e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="5e-4"/>"#;
const MESH: &str = r#"<collision><geometry><mesh filename="MESH"/></geometry></collision>"#;
const DISC: &str = r#"<collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.04"/></geometry></collision>"#;
/// The same, turned wrongly: about x, whereas the joint turns about y.
const ACROSS: &str = r#"<collision><origin rpy="0 1.5707963267948966 0"/><geometry><cylinder radius="0.05" length="0.04"/></geometry></collision>"#;
const ABOUT_Y: &str = r#"<axis xyz="0 1 0"/>"#;
const PLACES: [(&str, f64, f64); 4] = [
    ("front_left", 0.15, 0.13),
    ("front_right", 0.15, -0.13),
    ("rear_left", -0.15, 0.13),
    ("rear_right", -0.15, -0.13),
];

/// Four wheels at a height above the base, with an inertia and additional content in each.
fn wheels(z: f64, inertia: &str, inside: &str) -> String {
    let each = PLACES.iter().map(|(name, x, y)| {
        format!(
            r#"<link name="{name}_link"><inertial><mass value="0.5"/>{inertia}</inertial>{inside}</link>
            <joint name="{name}" type="continuous"><parent link="base_link"/><child link="{name}_link"/><origin xyz="{x} {y} {z}"/>{ABOUT_Y}</joint>"#
        )
    });
    each.collect()
}

fn robot(inside: &str) -> String {
    format!(r#"<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{inside}</robot>"#)
}

fn diagnosed(folder: &Path, name: &str, text: &str) -> Diagnosis {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(&path, text).unwrap();
    Robot::diagnose(&path, &LoadOptions::default(), |_| true)
}

/// Questions about a mecanum file, and the radius that is proposed for its wheels, in millimetres.
/// A cylinder across the axis is a clue, and an inertia that is equal about all axes is that of a
/// ball, r = sqrt(5 I / (2 m)) = 50 mm.
#[test_case(0.05, AS_DISC, ACROSS, Some(50.0); "a cylinder across the axis, its height and its inertia")]
#[test_case(0.0, AS_BALL, ACROSS, Some(50.0); "a cylinder across the axis and a ball")]
#[test_case(0.0, "<inertia ixx=\"1e-3\" ixy=\"0\" ixz=\"0\" iyy=\"1.6e-3\" iyz=\"0\" izz=\"1e-3\"/>", ACROSS, None; "a cylinder across the axis that nothing confirms")]
#[test_case(0.05, AS_BALL, MESH, Some(50.0); "height and a ball")]
#[test_case(0.08, AS_DISC, ACROSS, Some(50.0); "a height above no floor, which cylinder and inertia outvote")]
fn clues_that_are_turned_or_round(z: f64, inertia: &str, inside: &str, radius_mm: Option<f64>) {
    let folder = tempfile::tempdir().unwrap();
    let text = robot(&format!("{BODY}{}", wheels(z, inertia, inside)));
    let diagnosis = diagnosed(folder.path(), "mecanum.urdf", &text);
    let proposed = diagnosis
        .proposal
        .and_then(|options| options.wheel_radius_m);
    // To a tenth of a millimetre, as proposed.
    assert_eq!(proposed.map(|m| (1e4 * m).round() / 10.0), radius_mm);
}

/// Plain wheels with a missing mesh on a chassis without inertia: rollers, radius and repair are
/// one question.
#[test]
fn all_that_is_missing_is_asked_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let bare = BODY.replace(
        r#"<inertia ixx="0.033" ixy="0" ixz="0" iyy="0.11" iyz="0" izz="0.13"/>"#,
        "",
    );
    let shape = r#"<collision><geometry><box size="0.4 0.2 0.1"/></geometry></collision></link>"#;
    let bare = bare.replace("</link>", shape);
    let text = robot(&format!("{bare}{}", wheels(0.0, AS_DISC, MESH)));
    let diagnosis = diagnosed(folder.path(), "r.urdf", &text);
    assert!(diagnosis.proposal.is_none());
    let question = diagnosis.question.expect("a question");
    assert!(
        matches!(
            &question.asked[..],
            [
                Remedy::WhichRollers { wheels, parallel: true },
                Remedy::WheelRadius { guess_m: None }
            ] if wheels.len() == 4
        ),
        "{:?}",
        question.asked
    );
    let mut options = question.options;
    assert!(options.repair && options.wheels.is_none() && options.wheel_radius_m.is_none());
    let has = |is: fn(&Fault) -> bool| diagnosis.faults.iter().any(|error| is(error.fault()));
    assert!(has(|fault| matches!(
        fault,
        Fault::MissingElement { child: "inertia" }
    )));
    assert!(has(|fault| matches!(fault, Fault::NoRollers { .. })));
    assert!(has(|fault| matches!(fault, Fault::WheelSizeUnknown { .. })));
    // Consequences of a stand-in's size are not faults.
    assert!(!has(|fault| matches!(
        fault,
        Fault::ChassisBelowFloor { .. }
    )));
    // With the answer, the file is read.
    let rollers = ilon_formats::WheelOptions::new(9, Handedness::XDeg(45.0));
    options.wheels = Some(rollers.on(PLACES.map(|place| place.0.to_owned()).to_vec()));
    options.wheel_radius_m = Some(0.08);
    let robot = Robot::load_with(folder.path().join("r.urdf"), &options).unwrap();
    assert_eq!(robot.robot.wheels[0].radius_m, 0.08);
}

/// Known rollers and an unknown radius: the question contains the proposal for the first and asks
/// for the second.
#[test]
fn what_is_known_stands_in_the_question() {
    let folder = tempfile::tempdir().unwrap();
    let text = robot(&format!("{BODY}{}", wheels(0.0, AS_DISC, MESH)));
    let diagnosis = diagnosed(folder.path(), "mecanum.urdf", &text);
    let question = diagnosis.question.expect("a question");
    assert_eq!(question.asked, [Remedy::WheelRadius { guess_m: None }]);
    let rollers = question.options.wheels.expect("rollers");
    assert_eq!(rollers.gamma, Handedness::XDeg(45.0));
}

/// Four parallel wheels in the X that are all called omni wheels: only mecanum rollers let them
/// move sideways. If only two are called so, the others may be plain driven ones.
#[test_case("", Some(45.0))]
#[test_case("rear", None)]
fn parallel_wheels_that_are_called_omni_wheels(plain: &str, gamma_deg: Option<f64>) {
    let folder = tempfile::tempdir().unwrap();
    let mut text = robot(&format!("{BODY}{}", wheels(0.0, AS_DISC, DISC)));
    for (name, ..) in PLACES
        .iter()
        .filter(|place| plain.is_empty() || !place.0.starts_with(plain))
    {
        text = text.replace(name, &format!("omni_{name}"));
    }
    let diagnosis = diagnosed(folder.path(), "r.urdf", &text);
    let gamma = diagnosis
        .proposal
        .map(|options| options.wheels.expect("rollers").gamma);
    assert_eq!(gamma, gamma_deg.map(Handedness::XDeg));
}

/// The settings of a plug-in's controllers tell what drives the wheels, and their size.
#[test_case("mecanum_drive_controller/MecanumDriveController", true)]
#[test_case("diff_drive_controller/DiffDriveController", false)]
fn controllers_say_which_wheels_they_drive(kind: &str, is_mecanum: bool) {
    let folder = tempfile::tempdir().unwrap();
    let settings = format!(
        "controller_manager:\n  ros__parameters:\n    base:\n      type: {kind}  # drives\nbase:\n  ros__parameters:\n    \
         kinematics.wheels_radius: 0.05\n"
    );
    std::fs::create_dir(folder.path().join("config")).unwrap();
    std::fs::write(folder.path().join("config/c.yaml"), settings).unwrap();
    let plugin = r#"<gazebo><plugin filename="libgz_ros2_control.so"><parameters>config/c.yaml</parameters></plugin></gazebo>"#;
    let text = robot(&format!("{BODY}{}{plugin}", wheels(0.0, AS_DISC, DISC)));
    let path = folder.path().join("r.urdf");
    std::fs::write(&path, &text).unwrap();
    let loaded = Robot::load_with(&path, &LoadOptions::default()).expect("driven");
    let gamma = loaded.inferred.map(|rollers| rollers.gamma);
    assert_eq!(gamma, is_mecanum.then_some(Handedness::XDeg(45.0)));
    assert_eq!(loaded.robot.wheels[0].has_tyre(), !is_mecanum);
    // With a missing mesh, the setting and the inertia agree on 50 mm.
    let text = text.replace(DISC, MESH);
    let diagnosis = diagnosed(folder.path(), "r.urdf", &text);
    let radius_m = diagnosis
        .proposal
        .and_then(|options| options.wheel_radius_m);
    assert_eq!(radius_m, is_mecanum.then_some(0.05));
}

/// A mesh with a path of another machine is found in the package that the path names.
#[test]
fn a_mesh_of_another_machine_is_found_in_its_package() {
    let folder = tempfile::tempdir().unwrap();
    let mut obj = String::from("v 0 0 0\n");
    for k in 0..36 {
        let (s, c) = (std::f64::consts::TAU * f64::from(k) / 36.0).sin_cos();
        obj.push_str(&format!("v {} 0 {}\n", 0.05 * c, 0.05 * s));
    }
    for k in 0..36 {
        obj.push_str(&format!("f 1 {} {}\n", 2 + k, 2 + (k + 1) % 36));
    }
    let meshes = folder.path().join("ws/base_description/meshes");
    std::fs::create_dir_all(&meshes).unwrap();
    std::fs::write(meshes.join("wheel.obj"), obj).unwrap();
    let text = |mesh: &str| {
        let inside = MESH.replace("MESH", mesh);
        robot(&format!("{BODY}{}", wheels(0.0, AS_DISC, &inside)))
    };
    let read = |mesh: &str| {
        let path = folder.path().join("ws/base_description/urdf/mecanum.urdf");
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text(mesh)).unwrap();
        Robot::load_with(&path, &LoadOptions::default())
    };
    for mesh in [
        "file:///home/ada/ws/install/base_description/share/base_description/meshes/wheel.obj",
        "/home/ada/src/base_description/meshes/wheel.obj",
    ] {
        let robot = read(mesh).unwrap().robot;
        assert!((robot.wheels[0].radius_m - 0.05).abs() < 1e-6);
    }
    // A file in no package around stays missing, under its own name.
    let missing = read("/home/ada/src/another/meshes/tyre.obj").unwrap_err();
    let words = missing.others()[0].to_string();
    assert!(
        words.contains("`/home/ada/src/another/meshes/tyre.obj`"),
        "{words}"
    );
}

/// A xacro file from before 2014 is recognised, and a repair reads it.
#[test]
fn xacro_without_prefixes_is_read_by_a_repair() {
    let folder = tempfile::tempdir().unwrap();
    let parts = r#"<robot xmlns:xacro="http://ros.org/wiki/xacro"><property name="QUARTER" value="${pi / 2}"/><property name="" value="3"/>
        <macro name="tread" params="r"><collision><origin rpy="${QUARTER} 0 0"/><geometry><cylinder radius="${r}" length="0.04"/></geometry></collision></macro></robot>"#;
    std::fs::write(folder.path().join("parts.xacro"), parts).unwrap();
    let text = robot(&format!(
        r#"<include filename="parts.xacro"/>{BODY}{}"#,
        wheels(0.0, AS_DISC, r#"<if value="1"><tread r="0.05"/></if>"#)
    ));
    let called = text.replace("<tread", "<xacro:tread");
    let diagnosis = diagnosed(folder.path(), "mecanum.xacro", &called);
    let fault = diagnosis.faults[0].to_string();
    assert!(
        fault.contains("stand without the prefix `xacro:`, as until 2014"),
        "{fault}"
    );
    let proposal = diagnosis.proposal.expect("a repair");
    assert!(proposal.repair && proposal.wheel_radius_m.is_none());
    // Calls without a prefix are calls too, with a remark.
    let path = folder.path().join("old.mecanum.xacro");
    std::fs::write(&path, &text).unwrap();
    let mut options = LoadOptions::default();
    options.repair = true;
    let robot = Robot::load_with(&path, &options).unwrap().robot;
    assert_eq!(robot.wheels[0].radius_m, 0.05);
    let said = robot
        .remarks
        .iter()
        .any(|r| r.text.contains("read as until 2014"));
    assert!(said, "{:?}", robot.remarks);
}

/// Wheels without shape and mass: their size is unknown, and is requested with the rest.
#[test]
fn wheels_of_nothing_are_asked_about_whole() {
    let folder = tempfile::tempdir().unwrap();
    let text = robot(&format!("{BODY}{}", wheels(0.0, AS_DISC, "")));
    let inertial = format!(r#"<inertial><mass value="0.5"/>{AS_DISC}</inertial>"#);
    let diagnosis = diagnosed(folder.path(), "r.urdf", &text.replace(&inertial, ""));
    let question = diagnosis.question.expect("a question");
    assert_eq!(question.asked.len(), 2, "{:?}", question.asked);
}

/// An argument used only in names needs no question: one whose name suggests a text gets a text,
/// any other a number.
#[test_case("robot_name", "robot")]
#[test_case("wheel_count", "0")]
fn arguments_that_only_name_things(name: &str, value: &str) {
    let folder = tempfile::tempdir().unwrap();
    let text = robot(&format!(
        r#"<xacro:arg name="{name}"/><link name="$(arg {name})_tip"/><joint name="tip" type="fixed"><parent link="base_link"/><child link="$(arg {name})_tip"/></joint>{BODY}{}"#,
        wheels(0.0, AS_DISC, DISC)
    ));
    let diagnosis = diagnosed(folder.path(), "mecanum.xacro", &text);
    let given = diagnosis
        .proposal
        .map(|options| options.arguments[name].clone());
    assert_eq!(given.as_deref(), Some(value));
    assert!(diagnosis.question.is_none());
}

/// Wheels on fixed joints with missing meshes: called wheels, with the axis that their joints
/// state, they are asked about.
#[test]
fn fixed_wheels_whose_meshes_are_missing_are_asked_about() {
    let folder = tempfile::tempdir().unwrap();
    let inside = MESH.replace("MESH", "mecanum_right.stl");
    let text = robot(&format!("{BODY}{}", wheels(0.05, AS_DISC, &inside)));
    let text = text.replace("continuous", "fixed");
    let diagnosis = diagnosed(folder.path(), "r.urdf", &text);
    let proposal = diagnosis.proposal.expect("height and inertia agree");
    assert_eq!(proposal.wheel_radius_m, Some(0.05));
    // Without the axis, or without a name like a wheel's, nothing is taken for one.
    for other in [
        text.replace(ABOUT_Y, ""),
        text.replace("mecanum_right", "m"),
    ] {
        let other = diagnosed(folder.path(), "r.urdf", &other);
        assert!(other.proposal.is_none() && other.question.is_none());
    }
}

/// An arm above a steered base also turns about a vertical joint, and is no wheel of it.
#[test]
fn an_arm_is_no_steered_wheel() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = BODY.to_owned();
    let inertial = format!(r#"<inertial><mass value="0.5"/>{AS_DISC}</inertial>"#);
    for (name, x, y, z) in PLACES
        .iter()
        .map(|(name, x, y)| (*name, *x, *y, 0.0))
        .chain([("arm", 0.0, 0.0, 0.3)])
    {
        text += &format!(
            r#"<link name="{name}_fork">{inertial}</link><joint name="{name}_steer" type="continuous"><parent link="base_link"/><child link="{name}_fork"/>
            <origin xyz="{x} {y} {z}"/><axis xyz="0 0 1"/></joint><link name="{name}_link">{inertial}{DISC}</link>
            <joint name="{name}" type="continuous"><parent link="{name}_fork"/><child link="{name}_link"/>{ABOUT_Y}</joint>"#
        );
    }
    let path = folder.path().join("r.urdf");
    std::fs::write(&path, robot(&text)).unwrap();
    let loaded = Robot::load(&path).expect("steered wheels on tyres");
    let names: Vec<&str> = loaded.wheels.iter().map(|w| w.name.as_str()).collect();
    assert_eq!(names, PLACES.map(|place| place.0));
}
