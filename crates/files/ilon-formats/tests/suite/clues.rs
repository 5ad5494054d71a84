//! Proposals for files without wheel sizes or rollers: none is based on a single clue.

use std::f64::consts::TAU;
use std::path::Path;

use ilon_formats::{Diagnosis, Fault, Handedness, LoadOptions, LoadRobot, Remedy};
use ilon_robot::Robot;
use nalgebra::Vector3;
use test_case::test_case;

/// Four wheels of 50 mm by their inertia, solid discs of 0.5 kg: 0.5 * 0.5 kg * (50
/// mm)^2 = 6.25e-4 kg m^2.
const MASS: &str = r#"<inertial><mass value="0.5"/><inertia ixx="3.5e-4" ixy="0" ixz="0" iyy="6.25e-4" iyz="0" izz="3.5e-4"/></inertial>"#;
const BODY: &str = r#"<link name="base_link"><inertial><mass value="8"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.15"/></inertial></link>"#;
const MESH: &str = r#"<collision><geometry><mesh filename="MESH"/></geometry></collision>"#;
const DISC: &str = r#"<collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.04"/></geometry></collision>"#;

fn joint(name: &str, kind: &str, place: [f64; 3], yaw_rad: f64, axis: &str) -> String {
    let [x, y, z] = place;
    format!(
        r#"<joint name="{name}" type="{kind}"><parent link="base_link"/><child link="{name}_link"/><origin xyz="{x} {y} {z}" rpy="0 0 {yaw_rad}"/>{axis}</joint>"#
    )
}

fn link(name: &str, inside: &str) -> String {
    format!(r#"<link name="{name}_link">{MASS}{inside}</link>"#)
}

const PLACES: [(&str, f64, f64); 4] = [
    ("front_left", 0.15, 0.13),
    ("front_right", 0.15, -0.13),
    ("rear_left", -0.15, 0.13),
    ("rear_right", -0.15, -0.13),
];
const ABOUT_Y: &str = r#"<axis xyz="0 1 0"/>"#;

/// Four wheels at a height above the base, with additional content in each.
fn wheels(z: f64, inside: &str) -> String {
    let each = PLACES.iter().map(|(name, x, y)| {
        link(name, inside) + &joint(name, "continuous", [*x, *y, z], 0.0, ABOUT_Y)
    });
    each.collect()
}

fn robot(inside: &str) -> String {
    format!(r#"<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{inside}</robot>"#)
}

fn diagnosed(folder: &Path, name: &str, text: &str) -> (std::path::PathBuf, Diagnosis) {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    let diagnosis = Robot::diagnose(&path, &LoadOptions::default(), |_| true);
    (path, diagnosis)
}

/// A missing mesh, the height of its axis above the base, additional content of the file, and the
/// proposed radius, in millimetres.
#[test_case(0.0, "wheel.stl", "", None; "the inertia alone")]
#[test_case(0.0965, "wheel.stl", "", None; "a height that the inertia denies")]
#[test_case(0.05, "wheel.stl", "", Some(50.0); "height and inertia")]
#[test_case(0.05, "wheel.stl", r#"<xacro:property name="wheel_radius" value="0.0762"/>"#, None; "a property that denies both")]
#[test_case(0.0, "wheel.stl", r#"<xacro:property name="wheel_radius" value="0.0505"/>"#, Some(50.5); "property and inertia")]
#[test_case(0.0, "wheel.stl", r#"<xacro:property name="wheel_diameter" value="${2 * 0.05}"/>"#, Some(50.0); "a diameter that is computed")]
#[test_case(0.0, "wheel.stl", r#"<xacro:arg name="wheel_radius" default="0.05"/>"#, Some(50.0); "an argument")]
#[test_case(0.0, "wheel.stl", r#"<xacro:property name="roller_radius" value="0.05"/>"#, None; "a property of something else")]
#[test_case(0.0, "wheel.stl", "<gazebo><plugin><wheelDiameter>0.1</wheelDiameter></plugin></gazebo>", Some(50.0); "a setting of a plug-in")]
#[test_case(0.0, "wheel_100mm.stl", "", Some(50.0); "a size in a name")]
#[test_case(0.0762, "mecanum_6inch.stl", "", Some(76.2); "inches and the height")]
#[test_case(0.0, "4-Mecanum-Wheel.stl", "", Some(50.8); "inches whose sign is lost")]
#[test_case(0.0, "wheel_250.stl", "", None; "a size that the inertia denies")]
#[test_case(0.0, "wheel.stl", r#"<link name="base_footprint"/><joint name="foot" type="fixed"><parent link="base_link"/><child link="base_footprint"/><origin xyz="0 0 -0.05"/></joint>"#, Some(50.0); "a frame on the floor below the root")]
#[test_case(0.5, "wheel.stl", r#"<xacro:property name="wheel_radius" value="0.5"/>"#, None; "wheels that would cut into each other")]
fn a_radius_is_proposed_where_two_clues_agree(
    z: f64,
    mesh: &str,
    more: &str,
    radius_mm: Option<f64>,
) {
    let folder = tempfile::tempdir().unwrap();
    let text = robot(&format!(
        "{more}{BODY}{}",
        wheels(z, &MESH.replace("MESH", mesh)).replace("front_", "mecanum_front_")
    ));
    let (path, diagnosis) = diagnosed(folder.path(), "r.xacro", &text);
    let proposed = diagnosis
        .proposal
        .as_ref()
        .and_then(|options| options.wheel_radius_m);
    // To a tenth of a millimetre, as proposed.
    assert_eq!(proposed.map(|m| (1e4 * m).round() / 10.0), radius_mm);
    let fault = diagnosis
        .faults
        .iter()
        .find_map(|error| match error.fault() {
            Fault::WheelSizeUnknown { clues, .. } => Some(clues),
            _ => None,
        });
    let clues = fault.expect("the radius is asked for");
    assert!(!clues.clues.is_empty(), "each has an inertia");
    // If it is accepted, the robot's remarks name the clues.
    if let Some(options) = diagnosis.proposal {
        let taken = Robot::load_with(&path, &options).unwrap().robot;
        let said = taken
            .remarks
            .iter()
            .filter(|r| r.text.contains("as given; for it speak"));
        assert_eq!(said.count(), 4);
    }
}

/// Rollers without geometry on a ring of 67 mm: no smaller wheel can carry them.
#[test_case(0.0179, None)]
#[test_case(0.08, Some(0.08))]
fn a_wheel_reaches_beyond_the_axes_of_its_rollers(radius_m: f64, proposed_m: Option<f64>) {
    let inertia = 0.5 * 0.5 * radius_m * radius_m;
    let mass = MASS
        .replace("6.25e-4", &inertia.to_string())
        .replace("3.5e-4", &(0.6 * inertia).to_string());
    let mut text = BODY.to_owned();
    for (name, x, y) in PLACES {
        text += &format!("<link name=\"{name}_link\">{mass}</link>");
        text += &joint(name, "continuous", [x, y, radius_m], 0.0, ABOUT_Y);
        for k in 0..8 {
            let (s, c) = (std::f64::consts::TAU * f64::from(k) / 8.0).sin_cos();
            text += &format!(
                r#"<link name="{name}_{k}"><inertial><mass value="0.01"/><inertia ixx="1e-6" ixy="0" ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/></inertial></link>
                <joint name="{name}_r{k}" type="continuous"><parent link="{name}_link"/><child link="{name}_{k}"/><origin xyz="{} 0 {}"/><axis xyz="{} 1 {}"/></joint>"#,
                0.067 * s,
                0.067 * c,
                c,
                -s
            );
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let (_, diagnosis) = diagnosed(folder.path(), "r.urdf", &robot(&text));
    let clues = diagnosis
        .faults
        .iter()
        .find_map(|error| match error.fault() {
            Fault::WheelSizeUnknown { clues, .. } => Some(clues),
            _ => None,
        });
    let clues = clues.expect("the radius is asked for");
    assert!(
        clues.least_m.iter().any(|(m, _)| (m - 0.067).abs() < 1e-9),
        "{clues:?}"
    );
    assert_eq!(clues.proposed_m(), proposed_m);
}

/// Wheels on a ring that face outward, as on a robot of three omni wheels.
fn outward(name: &str) -> String {
    let each = (0..3).map(|i| {
        let angle = std::f64::consts::TAU * f64::from(i) / 3.0 + 0.2;
        let place = [0.3 * angle.cos(), 0.3 * angle.sin(), 0.0];
        let name = format!("{name}_{i}");
        let yaw_rad = angle - std::f64::consts::FRAC_PI_2;
        link(&name, DISC) + &joint(&name, "continuous", place, yaw_rad, ABOUT_Y)
    });
    each.collect()
}

fn gamma_of(text: &str) -> Option<Handedness> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.urdf");
    std::fs::write(&path, text).unwrap();
    match Robot::load_with(&path, &LoadOptions::default()) {
        Ok(loaded) => Some(loaded.inferred?.gamma),
        Err(_) => {
            let diagnosis = Robot::diagnose(&path, &LoadOptions::default(), |_| true);
            Some(diagnosis.proposal?.wheels?.gamma)
        }
    }
}

#[test]
fn wheels_of_two_kinds_in_one_file_are_given_each_their_own_gamma() {
    let mecanum = wheels(0.0, DISC)
        .replace("front_", "mecanum_front_")
        .replace("rear_", "mecanum_rear_");
    let x = [-45.0, 45.0, 45.0, -45.0];
    for others in ["omni", "aux"] {
        let text = robot(&format!("{BODY}{mecanum}{}", outward(others)));
        let Some(Handedness::EachDeg(gammas)) = gamma_of(&text) else {
            panic!("one gamma for all");
        };
        assert_eq!(gammas, [&x[..], &[0.0; 3]].concat());
    }
    // Alone each kind is what it was.
    let alone = gamma_of(&robot(&format!("{BODY}{}", outward("wheel"))));
    assert_eq!(alone, Some(Handedness::AllDeg(0.0)));
    assert_eq!(
        gamma_of(&robot(&format!("{BODY}{mecanum}"))),
        Some(Handedness::XDeg(45.0))
    );
    // Mecanum wheels in another arrangement are asked about.
    assert_eq!(
        gamma_of(&robot(&format!("{BODY}{}", outward("mecanum")))),
        None
    );
}

/// A robot that is called a mecanum one, with each wheel turned by its rollers' angle: as omni
/// wheels the four would have another lever arm. It is asked about, unless its wheels themselves
/// are called omni wheels.
#[test_case("mecanum_bot", "", "wheel", false; "the robot's name")]
#[test_case("r", "<gazebo><plugin filename=\"libmecanum_drive.so\"/></gazebo>", "wheel", false; "a plug-in")]
#[test_case("mecanum_bot", "", "omni_wheel", true; "wheels that are called omni wheels")]
#[test_case("r", "", "wheel", true; "nothing said")]
fn a_mecanum_robot_whose_hubs_are_not_parallel_is_asked_about(
    robot_name: &str,
    plugin: &str,
    wheel: &str,
    is_inferred: bool,
) {
    let each = (0..4).map(|i| {
        let (ahead, left) = ([0.08, 0.08, -0.08, -0.08][i], [0.1, -0.1, 0.1, -0.1][i]);
        let yaw_rad = std::f64::consts::FRAC_PI_4.copysign(ahead * left);
        let name = format!("{wheel}_{i}");
        link(&name, DISC) + &joint(&name, "continuous", [ahead, left, 0.0], yaw_rad, ABOUT_Y)
    });
    let text = robot(&format!("{BODY}{}{plugin}", each.collect::<String>()));
    let text = text.replacen("name=\"r\"", &format!("name=\"{robot_name}\""), 1);
    let gamma = gamma_of(&text);
    assert_eq!(gamma, is_inferred.then_some(Handedness::AllDeg(0.0)));
    if !is_inferred {
        let folder = tempfile::tempdir().unwrap();
        let (_, diagnosis) = diagnosed(folder.path(), "r.urdf", &text);
        let asked = diagnosis.faults[0].remedies();
        let is_asked = matches!(
            &asked[..],
            [Remedy::WhichRollers {
                parallel: false,
                ..
            }]
        );
        assert!(is_asked, "{asked:?}");
    }
}

/// Plain wheels on parallel axes roll as they are. Without the word mecanum they are asked about,
/// and no rollers are proposed; one word in a name, a mesh, the robot's name or a plug-in suffices
/// for a proposal.
#[test_case("", None; "nothing said")]
#[test_case("name", Some(45.0); "a wheel's name")]
#[test_case("robot", Some(45.0); "the robot's name")]
#[test_case("plugin", Some(45.0); "a plug-in")]
fn rollers_are_proposed_only_where_the_file_speaks_for_them(clue: &str, gamma_deg: Option<f64>) {
    let plain = robot(&format!("{BODY}{}", wheels(0.0, DISC)));
    let text = match clue {
        "name" => plain.replace("front_left", "mecanum_front_left"),
        "robot" => plain.replacen("name=\"r\"", "name=\"mecanum_r\"", 1),
        "plugin" => plain.replace(
            "</robot>",
            "<gazebo><plugin filename=\"libmecanum_drive.so\"/></gazebo></robot>",
        ),
        _ => plain,
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.urdf");
    std::fs::write(&path, &text).unwrap();
    let mut options = LoadOptions::default();
    options.infer_rollers = false;
    let diagnosis = Robot::diagnose(&path, &options, |_| true);
    let gamma = diagnosis
        .proposal
        .map(|proposal| proposal.wheels.expect("rollers").gamma);
    assert_eq!(gamma, gamma_deg.map(Handedness::XDeg));
    let asked: Vec<Remedy> = diagnosis.faults[0].remedies();
    let is_asked = matches!(&asked[..], [Remedy::WhichRollers { wheels, parallel: true }] if wheels.len() == 4);
    assert_eq!(is_asked, gamma_deg.is_none(), "{asked:?}");
}

/// A file that has rollers, but only if an argument requests them.
#[test_case("<xacro:arg name=\"rollers\" default=\"false\"/>", "$(arg rollers)", "rollers", "true"; "a truth value")]
#[test_case("<xacro:arg name=\"roller_type\" default=\"basic\"/>", "${'$(arg roller_type)' == 'full'}", "roller_type", "full"; "a text that is compared")]
#[test_case("<xacro:arg name=\"kind\" default=\"basic\"/><xacro:property name=\"k\" value=\"$(arg kind)\"/>", "${k in ['real', 'full']}", "kind", "real"; "a property that stands for it")]
#[test_case("<xacro:arg name=\"kind\" default=\"basic\"/>", "$(eval kind == 'full')", "kind", "full"; "an eval")]
fn a_value_of_the_files_own_argument_comes_before_rollers_that_are_invented(
    declared: &str,
    condition: &str,
    name: &str,
    value: &str,
) {
    let folder = tempfile::tempdir().unwrap();
    let spec = "name = 'r'\n[chassis]\nshape.box = { size_m = [0.3, 0.3, 0.1] }\nmass_kg = 5.0\ncenter_m = [0, 0, 0.06]\n\
                [wheel]\nradius_m = 0.05\nhub_mass_kg = 0.2\nhub_radius_m = 0.03\nhub_width_m = 0.04\nmotor_effort_n_m = 1\n\
                motor_velocity_rad_s = 20\n[rollers]\nper_row = 9\nradius_m = 0.012\nmass_kg = 0.01\n\
                [wheels.mecanum]\naxles_m = [0.2, -0.2]\nhalf_width_m = 0.25\ngamma_deg = 45\n";
    let spec = ilon_formats::Spec::from_toml_str(spec, "r.toml").unwrap();
    let urdf = ilon_formats::generate(&spec).unwrap();
    let mut text = String::new();
    let mut in_roller = false;
    for line in urdf.lines() {
        let opens = line.starts_with("  <link") || line.starts_with("  <joint");
        if opens || line.starts_with("</robot>") {
            let is_roller = opens && line.contains("_roller_");
            if is_roller != in_roller {
                text += &if is_roller {
                    format!("<xacro:if value=\"{condition}\">")
                } else {
                    "</xacro:if>".to_owned()
                };
            }
            in_roller = is_roller;
        }
        text += line;
        text.push('\n');
    }
    let text = text.replacen(
        "<robot ",
        "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" ",
        1,
    );
    let at = text.find("<link").unwrap();
    let text = format!("{}{declared}{}", &text[..at], &text[at..]);
    let (path, diagnosis) = diagnosed(folder.path(), "r.xacro", &text);
    let proposal = diagnosis.proposal.expect("the file has what it takes");
    assert_eq!(
        proposal.arguments.get(name).map(String::as_str),
        Some(value)
    );
    assert_eq!((proposal.wheels, proposal.wheel_radius_m), (None, None));
    let fault = diagnosis.faults[0].fault();
    assert!(matches!(fault, Fault::NoRollers { .. }), "{fault:?}");
    let mut options = LoadOptions::default();
    options.arguments = proposal.arguments;
    let robot = Robot::load_with(&path, &options).unwrap().robot;
    assert_eq!(robot.wheels[0].rollers.len(), 9);
}

#[test]
fn a_joint_between_chassis_and_wheels_that_is_held_is_remarked_with_the_wheels_that_it_carries() {
    let rocker = format!(
        r#"{BODY}<link name="rocker">{MASS}</link><joint name="rock" type="revolute"><parent link="base_link"/><child link="rocker"/>
        <axis xyz="1 0 0"/><limit lower="-0.1" upper="0.1" effort="5" velocity="1"/></joint>{}"#,
        wheels(0.0, DISC)
    );
    let text = robot(&rocker.replace("front_", "mecanum_front_"));
    // The front wheels are on the rocker.
    let text = ["left", "right"].iter().fold(text, |text, side| {
        let from =
            format!("<parent link=\"base_link\"/><child link=\"mecanum_front_{side}_link\"/>");
        assert!(text.contains(&from));
        text.replace(&from, &from.replace("base_link", "rocker"))
    });
    let robot = Robot::from_urdf_str(&text, "r.urdf").unwrap();
    let words = "it lies between the chassis and `mecanum_front_left`, `mecanum_front_right`, and is held at zero: their loads are \
                 those of wheels on a rigid frame";
    let said = |subject: &str, words: &str| {
        let mut remarks = robot.remarks.iter();
        remarks.any(|r| r.subject == subject && r.text.starts_with(words))
    };
    assert!(said("joint `rock`", words), "{:?}", robot.remarks);
}

#[test]
fn a_mass_that_stands_as_text_is_read_and_not_weighed() {
    let text = robot(&format!("{BODY}{}", wheels(0.0, DISC)))
        .replace("front_", "mecanum_front_")
        .replace(r#"<mass value="8"/>"#, "<mass>12.0</mass>");
    let mut options = LoadOptions::default();
    options.repair = true;
    assert!(Robot::from_urdf_str(&text, "r.urdf").is_err());
    let robot = Robot::from_urdf_str_with(&text, "r.urdf", &options)
        .unwrap()
        .robot;
    assert!((robot.chassis.mass.mass_kg - 12.0).abs() < 1e-12);
    let said = robot
        .remarks
        .iter()
        .any(|r| r.text.contains("its mass of 12 kg stands as text"));
    assert!(said, "{:?}", robot.remarks);
}

#[test]
fn a_fixed_wheel_turns_about_the_axis_that_its_joint_states() {
    let ball = r#"<collision><geometry><sphere radius="0.05"/></geometry></collision>"#;
    let fixed = |inside: &str| {
        robot(&format!(
            "{BODY}{}",
            wheels(0.0, inside).replace("continuous", "fixed")
        ))
    };
    let named = |text: &str, radius_m: Option<f64>| {
        let rollers = ilon_formats::WheelOptions::new(12, Handedness::XDeg(45.0));
        let mut options = LoadOptions::default();
        options.wheels = Some(rollers.on(PLACES.iter().map(|place| place.0.to_owned()).collect()));
        options.wheel_radius_m = radius_m;
        Robot::from_urdf_str_with(text, "r.urdf", &options)
    };
    // Symmetric about every axis, and a missing shape.
    assert_eq!(
        named(&fixed(ball), None).unwrap().robot.wheels[0].radius_m,
        0.05
    );
    let missing = fixed(&MESH.replace("MESH", "no.stl"));
    let asked = named(&missing, None).unwrap_err();
    assert!(
        matches!(asked.fault(), Fault::WheelSizeUnknown { .. }),
        "{asked}"
    );
    assert_eq!(
        named(&missing, Some(0.06)).unwrap().robot.wheels[0].radius_m,
        0.06
    );
    // Without an axis there is no wheel, and the message says what would help.
    let bare = named(&fixed(ball).replace(ABOUT_Y, ""), None).unwrap_err();
    assert!(
        bare.to_string()
            .contains("an `<axis>` in the joint would say"),
        "{bare}"
    );
}

/// Fixed parts: wheels, a motor mount before each, and the rollers on them.
#[test]
fn brackets_and_rollers_that_do_not_turn_are_no_wheels_beside_the_real_ones() {
    let mut text = format!("{BODY}{}", wheels(0.0, DISC).replace("continuous", "fixed"));
    for (name, x, y) in PLACES {
        let mount = format!("{name}_mount");
        text += &link(
            &mount,
            &DISC.replace("0.05", "0.048").replace("0.04\"", "0.02\""),
        );
        text += &joint(&mount, "fixed", [x, 0.9 * y, 0.0], 0.0, ABOUT_Y);
        let roller = format!("{name}_roller");
        text += &link(&roller, &DISC.replace("0.05", "0.01"));
        text += &joint(&roller, "fixed", [x, y, -0.035], 0.0, ABOUT_Y);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mecanum.urdf");
    std::fs::write(&path, robot(&text)).unwrap();
    let loaded = Robot::load_with(&path, &LoadOptions::default()).unwrap();
    let wheels = loaded.inferred.expect("rollers");
    assert_eq!(wheels.joints, PLACES.map(|place| place.0.to_owned()));
}

#[test]
fn one_line_of_a_macro_is_at_fault_once() {
    let text = robot(&format!(
        r#"{BODY}<xacro:macro name="w" params="n"><link name="w${{n}}"><inertial><mass value="-1"/>
        <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link></xacro:macro>{}"#,
        (0..22)
            .map(|i| format!("<xacro:w n=\"{i}\"/>"))
            .collect::<String>()
    ));
    let folder = tempfile::tempdir().unwrap();
    let (_, diagnosis) = diagnosed(folder.path(), "r.xacro", &text);
    let faults = ilon_formats::RobotError::by_place(diagnosis.faults);
    assert_eq!(faults.len(), 1);
    assert!(
        faults[0]
            .to_string()
            .contains("and 21 others of the same place"),
        "{}",
        faults[0]
    );
}

#[test]
fn what_is_no_robot_is_called_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 12345\n";
    let told =
        |name: &str, text: &str| diagnosed(folder.path(), name, text).1.faults[0].to_string();
    assert!(told("r.urdf", pointer).contains("`git lfs pull` fetches it"));
    assert!(
        told("r.proto", "PROTO R [] {}")
            .contains("a PROTO of Webots is not read; URDF, xacro, SDF")
    );
    assert!(told("r.usda", "#usda 1.0").contains("USD is not read"));
    std::fs::write(folder.path().join("lfs.stl"), pointer).unwrap();
    let meshes = robot(&format!(
        "{BODY}{}",
        wheels(0.0, &MESH.replace("MESH", "lfs.stl")).replace("front_", "mecanum_front_")
    ));
    let all = diagnosed(folder.path(), "m.urdf", &meshes).1.faults;
    assert!(
        all.iter()
            .any(|fault| fault.to_string().contains("a pointer of Git LFS")),
        "{all:?}"
    );
    assert!(told("none.urdf", &robot(BODY)).contains("The file has 1 link and no joints"));
}

#[test]
fn shapes_without_a_size_are_left_out_by_a_repair() {
    let dummy = r#"<link name="tip"><collision><geometry><box size="0 0 0"/></geometry></collision></link>
        <joint name="tip" type="fixed"><parent link="base_link"/><child link="tip"/></joint>"#;
    let text =
        robot(&format!("{BODY}{}{dummy}", wheels(0.0, DISC))).replace("front_", "mecanum_front_");
    let mut options = LoadOptions::default();
    options.repair = true;
    let loaded = Robot::from_urdf_str_with(&text, "r.urdf", &options).unwrap();
    assert!(
        loaded
            .robot
            .remarks
            .iter()
            .any(|r| r.text.contains("left out: it has no size"))
    );
    // A negative radius is never replaced by a guess.
    let wrong = text.replace(r#"<box size="0 0 0"/>"#, r#"<sphere radius="-1"/>"#);
    assert!(Robot::from_urdf_str_with(&wrong, "r.urdf", &options).is_err());
}

/// A frame with a mass of 0 and an inertia, as exporters of arms write it: nothing shows a mass, so
/// that it has none.
#[test]
fn an_inertia_without_mass_and_shapes_is_left_out_by_a_repair() {
    let frame = r#"<link name="flange"><inertial><mass value="0"/>
        <inertia ixx="0.3" ixy="0" ixz="0.3" iyy="0" iyz="0" izz="0.3"/></inertial></link>
        <joint name="flange" type="fixed"><parent link="base_link"/><child link="flange"/></joint>"#;
    let without =
        robot(&format!("{BODY}{}", wheels(0.0, DISC))).replace("front_", "mecanum_front_");
    let text = without.replace("</robot>", &format!("{frame}</robot>"));
    let mut options = LoadOptions::default();
    assert!(Robot::from_urdf_str_with(&text, "r.urdf", &options).is_err());
    options.repair = true;
    let loaded = |text: &str| {
        Robot::from_urdf_str_with(text, "r.urdf", &options)
            .unwrap()
            .robot
    };
    let repaired = loaded(&text);
    assert_eq!(repaired.chassis.mass, loaded(&without).chassis.mass);
    let words = "left out: it has neither mass nor shapes";
    assert!(repaired.remarks.iter().any(|r| r.text.contains(words)));
}

/// An arm of six hinges stands beside a base of four wheels: the base is the robot.
#[test]
fn of_the_bodies_of_an_mjcf_the_one_with_wheels_is_the_robot() {
    let inertial = r#"<inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>"#;
    let arm = (0..6).fold(String::new(), |inner, i| {
        format!(r#"<body name="arm_{i}" pos="0 0 0.1">{inertial}<joint type="hinge" axis="0 1 0"/>{inner}</body>"#)
    });
    let wheels = PLACES.iter().map(|(name, x, y)| {
        format!(
            r#"<body name="{name}_link" pos="{x} {y} 0.05">{inertial}<joint name="{name}" type="hinge" axis="0 1 0"/>
            <geom type="cylinder" size="0.05 0.02" euler="90 0 0"/></body>"#
        )
    });
    let text = format!(
        r#"<mujoco><worldbody>{arm}<body name="base">{inertial}<freejoint/>{}</body></worldbody></mujoco>"#,
        wheels.collect::<String>()
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mecanum.xml");
    std::fs::write(&path, &text).unwrap();
    let loaded = Robot::load_with(&path, &LoadOptions::default()).unwrap();
    let wheels = loaded.inferred.expect("rollers");
    assert_eq!(wheels.joints, PLACES.map(|place| place.0.to_owned()));
    let robot = loaded.robot;
    assert!(
        robot
            .remarks
            .iter()
            .any(|r| r.text.contains("of 2 bodies below the world"))
    );
}

/// A wheel as one mesh in the frame of its link, whose axis is y: a spindle for each of its
/// rollers, with a given ratio of its end radius to its middle radius, and a hub. On every third
/// roller the facets may be denser towards one end.
fn drawn(wheel: &ilon_robot::Wheel, ends: f64, is_uneven: bool) -> String {
    const AROUND: usize = 24;
    const ALONG: usize = 8;
    let (mut vertices, mut faces, mut count) = (String::new(), String::new(), 0);
    let mut spindle =
        |center: Vector3<f64>, axis: Vector3<f64>, radii_m: [f64; 2], length_m, closer: i32| {
            let across = axis.cross(&Vector3::new(0.3, -0.5, 0.8)).normalize();
            let third = axis.cross(&across);
            for i in 0..=ALONG {
                let t = 2.0 * (i as f64 / ALONG as f64).powi(closer) - 1.0;
                let r = radii_m[0] + (radii_m[1] - radii_m[0]) * t * t;
                for j in 0..AROUND {
                    let (sin, cos) = (TAU * j as f64 / AROUND as f64).sin_cos();
                    let p = center + axis * (0.5 * length_m * t) + (across * cos + third * sin) * r;
                    let p: Vector3<f64> = wheel.body_from_hub.rotation * p;
                    vertices.push_str(&format!("v {} {} {}\n", p.x, p.y, p.z));
                }
            }
            for i in 0..ALONG {
                for j in 0..AROUND {
                    let [a, b] = [j, (j + 1) % AROUND].map(|j| count + 1 + i * AROUND + j);
                    faces.push_str(&format!(
                        "f {a} {b} {}\nf {b} {} {}\n",
                        a + AROUND,
                        b + AROUND,
                        a + AROUND
                    ));
                }
            }
            count += (ALONG + 1) * AROUND;
        };
    for (i, roller) in wheel.rollers.iter().enumerate() {
        let axis = roller.axis_in_hub.into_inner();
        let radii_m = [roller.radius_m, ends * roller.radius_m];
        let closer = if is_uneven && i % 3 == 0 { 2 } else { 1 };
        spindle(
            roller.center_in_hub_m,
            axis,
            radii_m,
            roller.length_m,
            closer,
        );
    }
    spindle(Vector3::zeros(), Vector3::z(), [0.025, 0.025], 0.04, 1);
    format!("o wheel\n{vertices}{faces}")
}

fn shipped() -> Robot {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/mecanum4.urdf"
    );
    Robot::load(file).expect("the shipped robot")
}

/// A wheel rolls on its rollers' middles: the ends of rollers drawn as cylinders reach further and
/// do not count, nor does the distribution of facets. Ring and roller of a wheel of 50 mm make
/// 50 mm; coordinates are read in f32.
#[test_case(0.6, false; "barrels")]
#[test_case(1.0, false; "cylinders")]
#[test_case(1.0, true; "cylinders of other facets")]
fn a_mesh_of_rollers_is_as_large_as_they_are_in_their_middles(ends: f64, is_uneven: bool) {
    let shipped = shipped();
    let folder = tempfile::tempdir().unwrap();
    let mut inside = BODY.to_owned();
    for (name, x, y) in PLACES {
        let mesh = format!("{name}.obj");
        let wheel = shipped
            .wheels
            .iter()
            .find(|wheel| wheel.name.contains(name));
        let text = drawn(wheel.expect("a wheel"), ends, is_uneven);
        std::fs::write(folder.path().join(&mesh), text).unwrap();
        inside += &link(name, &MESH.replace("MESH", &mesh));
        inside += &joint(name, "continuous", [x, y, 0.0], 0.0, ABOUT_Y);
    }
    let path = folder.path().join("base.urdf");
    std::fs::write(&path, robot(&inside)).unwrap();
    let loaded = Robot::load_with(&path, &LoadOptions::default()).expect("it is read");
    assert_eq!(loaded.inferred.expect("rollers").rollers, 9);
    let radii_m: Vec<f64> = loaded.robot.wheels.iter().map(|w| w.radius_m).collect();
    assert!(
        radii_m.iter().all(|m| (m - 0.05).abs() < 1e-7),
        "{radii_m:?}"
    );
    // Bit for bit: a rigid robot with four unequal wheels stands on three.
    assert!(radii_m.iter().all(|m| *m == radii_m[0]), "{radii_m:?}");
}

/// Four wheels without telling names are read as their meshes show: number, thickness and angle of
/// the rollers, with handedness by place. If one mesh is drawn on all of them, that is remarked.
#[test_case(|i| i, "", None; "each wheel's own")]
#[test_case(|i| i, "", Some(0.055); "what touches is larger than what is shown")]
#[test_case(|_| 0, " (handed otherwise than in the usual X, in which they stand)", None; "one mesh on all")]
fn rollers_that_a_mesh_shows_are_taken(of: fn(usize) -> usize, but: &str, touches_m: Option<f64>) {
    let shipped = shipped();
    let folder = tempfile::tempdir().unwrap();
    let mut inside = BODY.to_owned();
    for (i, (name, x, y)) in PLACES.iter().enumerate() {
        let mesh = format!("{name}.obj");
        let of = shipped
            .wheels
            .iter()
            .find(|wheel| wheel.name.contains(PLACES[of(i)].0));
        std::fs::write(
            folder.path().join(&mesh),
            drawn(of.expect("a wheel"), 0.6, false),
        )
        .unwrap();
        let shown = MESH.replace("collision", "visual").replace("MESH", &mesh);
        let touches = touches_m.map(|m| DISC.replace("0.05\"", &format!("{m}\"")));
        inside += &link(name, &(shown + &touches.unwrap_or_default()));
        inside += &joint(name, "continuous", [*x, *y, 0.0], 0.0, ABOUT_Y);
    }
    let path = folder.path().join("base.urdf");
    std::fs::write(&path, robot(&inside)).unwrap();
    let loaded = Robot::load_with(&path, &LoadOptions::default()).expect("it is read");
    let rollers = loaded.inferred.expect("rollers");
    assert_eq!(
        (rollers.rollers, rollers.gamma),
        (9, Handedness::XDeg(45.0))
    );
    // To a tenth of a millimetre, as in the message; scaled from the drawing, whose radius is
    // 50 mm.
    let radius_m = shipped.wheels[0].rollers[0].radius_m * touches_m.unwrap_or(0.05) / 0.05;
    assert!((rollers.roller_radius_m.expect("a radius") - radius_m).abs() < 1e-4);
    for (wheel, drawn) in loaded.robot.wheels.iter().zip(&shipped.wheels) {
        assert!(
            (wheel.gamma_rad - drawn.gamma_rad).abs() < 1e-9,
            "{}",
            wheel.name
        );
    }
    let said: Vec<String> = loaded.robot.remarks.iter().map(|r| r.to_string()).collect();
    let words = format!(
        "at 45 deg on each{but} they are Swedish wheels, and each is given the 9 rollers that its mesh shows"
    );
    assert!(said.iter().any(|line| line.contains(&words)), "{said:?}");
}

/// Omni wheels beside mecanum wheels on parallel axes: their names distinguish them.
#[test]
fn an_omni_wheel_on_the_axis_of_mecanum_wheels_is_no_mecanum_wheel() {
    let mecanum = wheels(0.0, DISC)
        .replace("front_", "mecanum_front_")
        .replace("rear_", "mecanum_rear_");
    let omni = |name: &str, place: [f64; 3], yaw_rad: f64| {
        link(name, DISC) + &joint(name, "continuous", place, yaw_rad, ABOUT_Y)
    };
    let beside =
        omni("omni_left", [0.0, 0.13, 0.0], 0.0) + &omni("omni_right", [0.0, -0.13, 0.0], 0.0);
    let ahead = omni("omni_ahead", [0.3, 0.0, 0.0], std::f64::consts::FRAC_PI_2);
    let x = [-45.0, 45.0, 45.0, -45.0];
    for (others, count) in [(beside.clone(), 2), (beside + &ahead, 3)] {
        for plugin in [
            "",
            "<gazebo><plugin filename=\"libmecanum_drive.so\"/></gazebo>",
        ] {
            let text = robot(&format!("{BODY}{mecanum}{others}{plugin}"));
            let Some(Handedness::EachDeg(gammas)) = gamma_of(&text) else {
                panic!("one gamma for all");
            };
            assert_eq!(gammas, [&x[..], &[0.0; 3][..count]].concat());
        }
    }
}

/// Four wheels, each below a joint with a vertical axis: continuous, or limited as on most servos.
fn steered(kind: &str) -> String {
    let inertial = MASS;
    let each = PLACES.iter().map(|(name, x, y)| {
        format!(
            r#"<link name="{name}_fork">{inertial}</link><joint name="{name}_steer" type="{kind}"><parent link="base_link"/><child link="{name}_fork"/>
            <origin xyz="{x} {y} 0.1"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
            <link name="{name}_link">{inertial}{DISC}</link>
            <joint name="{name}" type="continuous"><parent link="{name}_fork"/><child link="{name}_link"/><origin xyz="0 0 -0.1"/>{ABOUT_Y}</joint>"#
        )
    });
    each.collect()
}

/// Steered wheels move a robot in all directions without rollers, and such robots are called
/// omnidirectional too.
#[test_case("continuous"; "without end")]
#[test_case("revolute"; "within limits")]
fn steered_wheels_of_a_robot_that_is_called_omnidirectional_are_given_no_rollers(kind: &str) {
    let folder = tempfile::tempdir().unwrap();
    let shown = r#"<visual><geometry><mesh filename="package://omni_cart/meshes/wheel.stl"/></geometry></visual><collision>"#;
    let text = robot(&format!("{BODY}{}", steered(kind)))
        .replacen("name=\"r\"", "name=\"omni_cart\"", 1)
        .replace("<collision>", shown);
    let path = folder.path().join("omni_cart.urdf");
    std::fs::write(&path, text).unwrap();
    let robot = Robot::load(&path).expect("steered wheels on tyres");
    let names: Vec<&str> = robot.wheels.iter().map(|w| w.name.as_str()).collect();
    assert_eq!(names, PLACES.map(|place| place.0));
    assert!(robot.wheels.iter().all(|wheel| wheel.has_tyre()));
}

/// Joints that move a whole base over the plane, as above robots for learning whose wheels do not
/// turn, steer none of its wheels; those of a fork for each wheel do.
#[test_case(false; "one for the base")]
#[test_case(true; "one for each wheel")]
fn a_joint_that_turns_the_whole_base_steers_no_wheel(are_forks: bool) {
    let upright = |name: &str, parent: &str, child: &str, [x, y]: [f64; 2]| {
        format!(
            r#"<link name="{child}">{MASS}</link><joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>
            <origin xyz="{x} {y} 0"/><axis xyz="0 0 1"/></joint>"#
        )
    };
    let each = PLACES.iter().map(|(name, x, y)| {
        let (above, [at_x, at_y]) = match are_forks {
            true => (format!("{name}_fork"), [0.0, 0.0]),
            false => ("turned".to_owned(), [*x, *y]),
        };
        let fork = upright(&format!("{name}_steer"), "base_link", &above, [*x, *y]);
        let fork = if are_forks { fork } else { String::new() };
        let wheel = format!("wheel_{name}");
        let joint = joint(&wheel, "fixed", [at_x, at_y, 0.0], 0.0, ABOUT_Y);
        let hangs = format!("<parent link=\"{above}\"/>");
        fork + &link(&wheel, DISC) + &joint.replace(r#"<parent link="base_link"/>"#, &hangs)
    });
    let base = match are_forks {
        true => String::new(),
        false => upright("yaw", "base_link", "turned", [0.0, 0.0]),
    };
    let text = robot(&format!("{BODY}{base}{}", each.collect::<String>()));
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = diagnosed(folder.path(), "r.urdf", &text);
    // Only steered ones are given tyres.
    let on_tyres = Robot::load(&path).is_ok_and(|robot| robot.wheels[0].has_tyre());
    assert_eq!(on_tyres, are_forks);
}

/// For four parallel wheels of a robot called omnidirectional, mecanum rollers are proposed, as no
/// others let it move sideways: not if its plug-in drives plain wheels, and never silently.
#[test_case("omni_bot", "", Some(45.0); "omni")]
#[test_case("HolonomicBase", "", Some(45.0); "holonomic")]
#[test_case("nonholonomic_base", "", None; "its contrary")]
#[test_case("omni_bot", "libgazebo_ros_diff_drive.so", None; "driven by two sides")]
#[test_case("omni_bot", "gz-sim-diff-drive-system", None; "driven by two sides in another program")]
#[test_case("omni_bot", "libgazebo_ros_skid_steer_drive.so", None; "driven by skidding")]
fn a_robot_that_is_called_omnidirectional(name: &str, plugin: &str, gamma_deg: Option<f64>) {
    let folder = tempfile::tempdir().unwrap();
    let plugin = format!("<gazebo><plugin filename=\"{plugin}\" name=\"p\"/></gazebo>");
    let text = robot(&format!("{BODY}{}{plugin}", wheels(0.0, DISC)));
    let text = text.replacen("name=\"r\"", &format!("name=\"{name}\""), 1);
    let (path, diagnosis) = diagnosed(folder.path(), "r.urdf", &text);
    assert!(Robot::load(&path).is_err());
    let gamma = diagnosis
        .proposal
        .map(|proposal| proposal.wheels.expect("rollers").gamma);
    assert_eq!(gamma, gamma_deg.map(Handedness::XDeg));
    let help = diagnosis.faults[0].help();
    let words = format!("the name `{name}`");
    assert_eq!(help.contains(&words), gamma_deg.is_some(), "{help}");
}

/// A comment above wheels that reads as their heading tells what they are, subject to confirmation:
/// not a longer text, and not for wheels that are driven as plain ones.
#[test_case("===== MECANUM WHEELS =====", "", true; "a heading")]
#[test_case("the base once had mecanum wheels, and was slow, so they were replaced", "", false; "a story")]
#[test_case("<mecanum/>", "", false; "what is commented out")]
#[test_case("MECANUM WHEELS", "libgazebo_ros_diff_drive.so", false; "driven by two sides")]
fn a_heading_says_what_wheels_are(comment: &str, plugin: &str, does: bool) {
    let folder = tempfile::tempdir().unwrap();
    let plugin = format!("<gazebo><plugin filename=\"{plugin}\" name=\"p\"/></gazebo>");
    let text = robot(&format!(
        "{BODY}<!-- {comment} -->{}{plugin}",
        wheels(0.0, DISC)
    ));
    let (path, diagnosis) = diagnosed(folder.path(), "r.urdf", &text);
    assert!(Robot::load(&path).is_err());
    let gamma = diagnosis
        .proposal
        .map(|proposal| proposal.wheels.expect("rollers").gamma);
    assert_eq!(gamma, does.then_some(Handedness::XDeg(45.0)));
    let help = diagnosis.faults[0].help();
    assert_eq!(
        help.contains("the comment `MECANUM WHEELS`"),
        does,
        "{help}"
    );
}

/// A proposed number of rollers without evidence is called assumed.
#[test]
fn what_is_assumed_of_a_proposal_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let text = robot(&format!("{BODY}{}", wheels(0.05, MESH)));
    let (_, diagnosis) = diagnosed(folder.path(), "mecanum.urdf", &text);
    assert!(diagnosis.proposal.is_some(), "{:?}", diagnosis.faults);
    let help = diagnosis.faults[0].help();
    assert!(
        help.contains("the name `mecanum.urdf`; that they are 12 on a wheel is assumed"),
        "{help}"
    );
}

/// A plug-in that moves the base in any way proves nothing, but is named when rollers are asked
/// about.
#[test]
fn a_hint_that_is_not_enough_is_listed() {
    let folder = tempfile::tempdir().unwrap();
    let plugin = r#"<gazebo><plugin filename="libgazebo_ros_planar_move.so" name="p"/></gazebo>"#;
    let text = robot(&format!("{BODY}{}{plugin}", wheels(0.0, DISC)));
    let (_, diagnosis) = diagnosed(folder.path(), "r.urdf", &text);
    assert_eq!(diagnosis.proposal, None);
    let help = diagnosis.faults[0].help();
    assert!(
        help.contains("`libgazebo_ros_planar_move.so` moves the base"),
        "{help}"
    );
}

/// Wheels on fixed joints with an axis, with cylinders that lie across it: cylinder and inertia
/// agree on the radius.
#[test]
fn a_fixed_wheel_whose_cylinder_lies_across_its_axis_is_a_wheel() {
    let folder = tempfile::tempdir().unwrap();
    let across = DISC.replace("rpy=\"1.5707963267948966 0 0\"", "");
    let text = robot(&format!("{BODY}{}", wheels(0.02, &across)));
    let text = text
        .replace("continuous", "fixed")
        .replace("_link\"", "_wheel\"");
    let text = text.replace("base_wheel", "base_link");
    let (_, diagnosis) = diagnosed(folder.path(), "mecanum.urdf", &text);
    let proposal = diagnosis.proposal.expect("a proposal");
    assert_eq!(proposal.wheel_radius_m, Some(0.05));
    let rollers = proposal.wheels.expect("rollers");
    assert_eq!(rollers.gamma, Handedness::XDeg(45.0));
    assert_eq!(rollers.joints, PLACES.map(|place| place.0.to_owned()));
}

/// The wrists of two arms on a base that turns as a whole are no steered wheels.
#[test]
fn the_wrists_of_two_arms_are_no_steered_wheels() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = format!(
        r#"<link name="floor"/><joint name="turns" type="continuous"><parent link="floor"/><child link="base_link"/><axis xyz="0 0 1"/></joint>{BODY}"#
    );
    for (name, y) in [("left", 0.1), ("right", -0.1)] {
        text += &link(name, DISC);
        text += &joint(name, "continuous", [0.1, y, 0.8], 0.0, ABOUT_Y);
    }
    let (_, diagnosis) = diagnosed(folder.path(), "r.urdf", &robot(&text));
    assert!(
        matches!(diagnosis.faults[0].fault(), Fault::TooFewWheels { .. }),
        "{:?}",
        diagnosis.faults
    );
}

/// The roller thickness in a mesh is not usable for a wheel with unknown radius.
#[test]
fn rollers_of_a_wheel_of_unknown_size_are_asked_for_without_their_thickness() {
    let shipped = shipped();
    let folder = tempfile::tempdir().unwrap();
    let mut inside = BODY.to_owned();
    // The collision shape is larger than the visual one, and lies across the axis.
    let across =
        r#"<collision><geometry><cylinder radius="0.07" length="0.04"/></geometry></collision>"#;
    for ((name, x, y), wheel) in PLACES.iter().zip(&shipped.wheels) {
        let mesh = format!("{name}.obj");
        std::fs::write(folder.path().join(&mesh), drawn(wheel, 0.6, false)).unwrap();
        let shown = MESH.replace("collision", "visual").replace("MESH", &mesh);
        inside += &link(name, &(shown + across));
        inside += &joint(name, "continuous", [*x, *y, 0.0], 0.0, ABOUT_Y);
    }
    // An inertia as of a disc of 60 mm agrees with neither: 0.5 * 0.5 kg * (60 mm)^2 = 9e-4 kg m^2.
    let text = robot(&inside).replace("iyy=\"6.25e-4\"", "iyy=\"9e-4\"");
    let text = text.replace("3.5e-4", "5e-4");
    let (_, diagnosis) = diagnosed(folder.path(), "base.urdf", &text);
    let question = diagnosis.question.expect("the radius is asked for");
    assert_eq!(question.asked, [Remedy::WheelRadius { guess_m: None }]);
    let rollers = question.options.wheels.expect("rollers");
    assert_eq!((rollers.rollers, rollers.roller_radius_m), (9, None));
}
