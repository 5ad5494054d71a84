//! The answer of a careful engineer for an ambiguous file if there is only one, and otherwise none.

use std::f64::consts::TAU;
use std::path::Path;

use ilon_formats::{Diagnosis, Fault, LoadOptions, LoadRobot, RollerForms, Spec, generate};
use ilon_robot::Robot;
use test_case::test_case;

use crate::common::{SPEC, options};

const MASS: &str = r#"<inertial><mass value="0.5"/><inertia ixx="3.5e-4" ixy="0" ixz="0" iyy="6.25e-4" iyz="0" izz="3.5e-4"/></inertial>"#;
const BODY: &str = r#"<link name="base_link"><inertial><mass value="8"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.15"/></inertial></link>"#;
const PLACES: [(&str, f64, f64); 4] = [
    ("front_left", 0.15, 0.13),
    ("front_right", 0.15, -0.13),
    ("rear_left", -0.15, 0.13),
    ("rear_right", -0.15, -0.13),
];

/// A wheel of a radius on a joint of a type, about an axis.
fn wheel(name: &str, kind: &str, place: [f64; 3], axis: &str, radius_m: f64) -> String {
    let [x, y, z] = place;
    let turned = match axis {
        "0 1 0" => "1.5707963267948966 0 0",
        _ => "0 1.5707963267948966 0",
    };
    format!(
        r#"<link name="{name}_link">{MASS}<collision><origin rpy="{turned}"/><geometry><cylinder radius="{radius_m}" length="0.04"/></geometry></collision></link>
        <joint name="{name}" type="{kind}"><parent link="base_link"/><child link="{name}_link"/><origin xyz="{x} {y} {z}"/><axis xyz="{axis}"/><limit lower="-1.5" upper="1.5" effort="1" velocity="9"/></joint>"#
    )
}

/// Four wheels that are called mecanum wheels and arranged as such.
fn mecanum_wheels() -> String {
    let wheels = PLACES.iter().map(|(name, x, y)| {
        let name = format!("mecanum_{name}");
        wheel(&name, "continuous", [*x, *y, 0.0], "0 1 0", 0.05)
    });
    wheels.collect()
}

/// The same as bodies of MJCF, whose angles are in degrees.
fn mecanum_bodies() -> String {
    let bodies = PLACES.iter().map(|(name, x, y)| {
        format!(
            r#"<body name="mecanum_{name}" pos="{x} {y} 0" euler="90 0 0"><joint name="{name}" axis="0 0 1"/><geom type="cylinder" size="0.05 0.02"/></body>"#
        )
    });
    bodies.collect()
}

fn robot(name: &str, inside: &str) -> String {
    format!(r#"<robot name="{name}" xmlns:xacro="http://www.ros.org/wiki/xacro">{inside}</robot>"#)
}

fn diagnosed(folder: &Path, name: &str, text: &str) -> Diagnosis {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    Robot::diagnose(&path, &LoadOptions::default(), |_| true)
}

fn said(diagnosis: &Diagnosis) -> String {
    let of = |error: &ilon_formats::RobotError| format!("{error}\n{}\n", error.help());
    diagnosis.faults.iter().map(of).collect()
}

/// Round segments of two arms on level axes that are not parallel, as omni wheels have: they turn
/// within limits, and are not called wheels. With names of wheels they are asked about.
#[test_case("joint", false)]
#[test_case("wheel", true)]
fn segments_of_arms_are_no_wheels(called: &str, are_wheels: bool) {
    let arms = [
        ("a", 0.1, 0.1),
        ("b", 0.1, -0.1),
        ("c", -0.1, 0.1),
        ("d", -0.1, -0.1),
    ];
    let parts = arms.iter().enumerate().map(|(i, (name, x, y))| {
        let axis = ["0 1 0", "1 0 0"][i % 2];
        wheel(
            &format!("{called}_{name}"),
            "revolute",
            [*x, *y, 0.5],
            axis,
            0.025,
        )
    });
    let text = robot(
        "omni_robot",
        &format!("{BODY}{}", parts.collect::<String>()),
    );
    let read = Robot::from_urdf_str(&text, "r.urdf");
    let folder = tempfile::tempdir().unwrap();
    let diagnosis = diagnosed(folder.path(), "r.urdf", &text);
    let is_taken = read.is_ok() || diagnosis.proposal.is_some() || diagnosis.question.is_some();
    assert_eq!(is_taken, are_wheels, "{}", said(&diagnosis));
}

/// Four wheels that are called mecanum wheels, of which one is smaller by mistake and so stands
/// above the floor of the others: three are no mecanum robot, and the message names the fourth.
#[test]
fn mecanum_wheels_are_not_proposed_for_three_of_four() {
    let four = |radius_m: f64| {
        let parts = PLACES.iter().enumerate().map(|(i, (name, x, y))| {
            let own_m = if i == 0 { radius_m } else { 0.05 };
            wheel(name, "continuous", [*x, *y, 0.0], "0 1 0", own_m)
        });
        robot(
            "mecanum_car",
            &format!("{BODY}{}", parts.collect::<String>()),
        )
    };
    assert!(Robot::from_urdf_str(&four(0.05), "r.urdf").is_ok());
    let folder = tempfile::tempdir().unwrap();
    let diagnosis = diagnosed(folder.path(), "r.urdf", &four(0.03));
    assert_eq!(diagnosis.proposal, None);
    let said = said(&diagnosis);
    assert!(
        said.contains("speaks of mecanum wheels, which stand on both sides"),
        "{said}"
    );
    // 50 - 30 mm.
    assert!(
        said.contains("`front_left` stands 20 mm above the floor"),
        "{said}"
    );
}

/// The small robot without some of the eight rollers of its first wheel.
fn without_rollers(numbers: &[usize]) -> String {
    let mut text = generate(&Spec::from_toml_str(SPEC, "small.toml").unwrap()).unwrap();
    for number in numbers {
        for (start, end) in [
            (
                format!("<link name=\"wheel_1_roller_{number}_link\""),
                "</link>",
            ),
            (
                format!("<joint name=\"wheel_1_roller_{number}\""),
                "</joint>",
            ),
        ] {
            let from = text
                .find(&start)
                .unwrap_or_else(|| panic!("{start} in {text}"));
            let to = from + text[from..].find(end).unwrap() + end.len();
            text.replace_range(from..to, "");
        }
    }
    text
}

/// Of eight rollers, 45 degrees apart, one or two are part of the hub's mesh: the others leave a
/// gap of 45 or 90 degrees, which neither longer rollers nor the file's own shapes can close.
#[test_case(&[3], 1, 45.0)]
#[test_case(&[3, 4], 2, 90.0)]
fn a_wheel_that_lacks_rollers_is_not_proposed(lacks: &[usize], count: usize, gap_deg: f64) {
    let folder = tempfile::tempdir().unwrap();
    let text = without_rollers(lacks);
    let diagnosis = diagnosed(folder.path(), "r.urdf", &text);
    assert_eq!(diagnosis.proposal, None, "{}", said(&diagnosis));
    let Fault::RollersHaveGaps {
        missing,
        of,
        widest_gap_deg,
        ..
    } = diagnosis.faults[0].fault()
    else {
        panic!("{}", said(&diagnosis));
    };
    assert_eq!((*missing, *of), (count, 8));
    // Rollers of the generator hand over without a gap, to rounding.
    assert!((widest_gap_deg - gap_deg).abs() < 0.01, "{widest_gap_deg}");
    let repair = options(|o| o.repair = true);
    assert!(Robot::from_urdf_str_with(&text, "r.urdf", &repair).is_err());
    // With the file's own shapes the remark describes the wheel: at half of the gap from straight
    // down it hangs rho (1 - cos) lower.
    let as_modelled = options(|o| o.rollers = RollerForms::AsModelled);
    let read = Robot::from_urdf_str_with(&text, "r.urdf", &as_modelled).unwrap();
    let dip_mm = 50.0 * (1.0 - (0.5 * gap_deg).to_radians().cos());
    let words = format!("it falls {dip_mm:.1} mm");
    let remark = |r: &ilon_robot::Remark| {
        r.text.contains("it does not roll")
            && r.text.contains(&words)
            && r.text.contains(&format!("{count} of 8"))
    };
    assert!(
        read.robot.remarks.iter().any(remark),
        "{words}: {:#?}",
        read.robot.remarks
    );
}

/// An abbreviation suffices to propose mecanum rollers, but not to accept them; a part of a word
/// does not.
#[test_case("mini_mec_robot", "", true)]
#[test_case("r3s-MEC", "", true)]
#[test_case("mechanic_robot", "", false)]
#[test_case(
    "mini_mec_robot",
    r#"<gazebo><plugin name="d" filename="libgazebo_ros_diff_drive.so"/></gazebo>"#,
    false
)]
fn mecanum_wheels_in_short(name: &str, more: &str, is_proposed: bool) {
    let parts = PLACES
        .iter()
        .map(|(name, x, y)| wheel(name, "continuous", [*x, *y, 0.0], "0 1 0", 0.05));
    let text = robot(name, &format!("{more}{BODY}{}", parts.collect::<String>()));
    let folder = tempfile::tempdir().unwrap();
    assert!(Robot::from_urdf_str(&text, "r.urdf").is_err());
    let diagnosis = diagnosed(folder.path(), "r.urdf", &text);
    assert_eq!(
        diagnosis.proposal.is_some(),
        is_proposed,
        "{}",
        said(&diagnosis)
    );
}

/// A size and a kind in the name of the hub's content: the wheel proper may be a link of its own.
#[test]
fn a_hub_holds_the_wheel_that_is_called_after_its_size() {
    let places = (0..3).map(|i| TAU * f64::from(i) / 3.0);
    let parts = places.enumerate().map(|(i, angle)| {
        let (s, c) = angle.sin_cos();
        let (x, y) = (0.2 * c, 0.2 * s);
        // 51 mm as a solid disc of 0.5 kg: 0.5 * 0.5 kg * (51 mm)^2 = 6.5e-4 kg m^2.
        format!(
            r#"<link name="mount_{i}"><collision><geometry><cylinder radius="0.028" length="0.01"/></geometry></collision></link>
            <link name="tyre_{i}"><inertial><mass value="0.5"/><inertia ixx="3.5e-4" ixy="0" ixz="0" iyy="3.5e-4" iyz="0" izz="6.5e-4"/></inertial>
            <collision><geometry><mesh filename="4-Omni-Directional-Wheel.stl"/></geometry></collision></link>
            <joint name="servo_{i}" type="continuous"><parent link="base_link"/><child link="mount_{i}"/><origin xyz="{x} {y} 0.0179" rpy="0 1.5707963267948966 {angle}"/><axis xyz="0 0 1"/></joint>
            <joint name="held_{i}" type="fixed"><parent link="mount_{i}"/><child link="tyre_{i}"/></joint>"#
        )
    });
    let text = robot("kiwi", &format!("{BODY}{}", parts.collect::<String>()));
    let folder = tempfile::tempdir().unwrap();
    let proposal = diagnosed(folder.path(), "r.urdf", &text)
        .proposal
        .expect("a radius");
    assert_eq!(proposal.wheel_radius_m, Some(0.0508));
}

/// An argument without a value, and what depends on it: only settings of another program, the
/// wheels' mass, or which of two robots it is.
#[test_case(r#"<gazebo><x>$(arg place)</x></gazebo>"#, "0.5", true; "where a simulator puts it")]
#[test_case(r#"<xacro:if value="$(arg place)"><gazebo/></xacro:if>"#, "0.5", true; "a truth value")]
#[test_case("", "${0.5 + 0.1 * $(arg place)}", false; "a mass")]
#[test_case(r#"<xacro:if value="${'$(arg place)' == 'indoors'}"><link name="lamp"/></xacro:if>"#, "0.5", false; "a text that it is compared with")]
#[test_case(r#"<xacro:if value="${$(arg place) == 5}"><link name="lamp"/></xacro:if>"#, "0.5", false; "a number that it is compared with")]
#[test_case(r#"<xacro:if value="${$(arg place) > 5}"><link name="lamp"/></xacro:if>"#, "0.5", false; "a number that it is measured by")]
#[test_case("", "${0.5 if $(arg place) &lt; 5 else 0.7}", false; "a mass of many")]
#[test_case(r#"<xacro:property name="kg" value="0.5"/><xacro:if value="${$(arg place) > 1}"><xacro:property name="kg" value="0.7"/></xacro:if>"#, "${kg}", false; "a mass from more than one on")]
#[test_case(r#"<xacro:property name="kg" value="0.5"/><xacro:if value="${$(arg place) &lt; 0}"><xacro:property name="kg" value="0.7"/></xacro:if>"#, "${kg}", false; "a mass below nothing")]
fn an_argument_may_have_any_value_where_the_robot_is_the_same(
    more: &str,
    mass: &str,
    any_does: bool,
) {
    let wheels = mecanum_wheels().replace(
        r#"<mass value="0.5"/>"#,
        &format!(r#"<mass value="{mass}"/>"#),
    );
    let text = robot("r", &format!("{more}{BODY}{}", wheels));
    let folder = tempfile::tempdir().unwrap();
    let diagnosis = diagnosed(folder.path(), "r.xacro", &text);
    let given = diagnosis
        .proposal
        .as_ref()
        .map(|options| options.arguments.contains_key("place"));
    assert_eq!(given, any_does.then_some(true), "{}", said(&diagnosis));
    assert_eq!(
        said(&diagnosis).contains("whatever it is, the robot is the same"),
        any_does
    );
}

/// A package named only by an argument's default may be missing if nothing is read from it.
#[test]
fn a_package_that_an_argument_names_may_be_missing() {
    let argument = r#"<xacro:arg name="settings" default="$(find nowhere)/controllers.yaml"/><gazebo><parameters>$(arg settings)</parameters></gazebo>"#;
    let text = robot("r", &format!("{argument}{BODY}{}", mecanum_wheels()));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.xacro");
    std::fs::write(&path, &text).unwrap();
    let read = Robot::load(&path).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(read.wheels.len(), 4);
    assert!(
        read.remarks
            .iter()
            .any(|r| r.text.contains("`nowhere` is not known"))
    );
}

/// A pose with only a position has no rotation, as SDF's default.
#[test]
fn a_place_alone_is_a_pose_in_sdf() {
    let sdf = |turn: &str| {
        let wheels = PLACES.iter().map(|(name, x, y)| {
            format!(
                r#"<link name="{name}"><pose>{x} {y} 0.05 1.5707963267948966 0 0</pose><inertial><mass>0.5</mass><inertia><ixx>3.5e-4</ixx><iyy>3.5e-4</iyy><izz>6.25e-4</izz></inertia></inertial>
                <collision name="c"><geometry><cylinder><radius>0.05</radius><length>0.04</length></cylinder></geometry></collision></link>
                <joint name="mecanum_{name}" type="revolute"><parent>base</parent><child>{name}</child><axis><xyz>0 0 1</xyz></axis></joint>"#
            )
        });
        format!(
            r#"<sdf version="1.9"><model name="m"><link name="base"><pose>0 0 0.1{turn}</pose><inertial><mass>8</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.15</izz></inertia></inertial></link>{}</model></sdf>"#,
            wheels.collect::<String>()
        )
    };
    let read =
        |turn: &str| Robot::from_urdf_str(&sdf(turn), "r.sdf").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(read(""), read(" 0 0 0"));
}

/// Files written under Windows have backslashes in paths. MuJoCo reads them everywhere.
#[test]
fn a_mesh_is_found_by_a_path_of_windows() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("meshes")).unwrap();
    let tetrahedron =
        "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::fs::write(folder.path().join("meshes/top.obj"), tetrahedron).unwrap();
    let read = |mesh: &str| {
        let text = format!(
            r#"<mujoco><asset><mesh name="top" file="{mesh}"/></asset><worldbody><body name="base"><freejoint/><geom type="mesh" mesh="top"/>{}</body></worldbody></mujoco>"#,
            mecanum_bodies()
        );
        let path = folder.path().join("r.xml");
        std::fs::write(&path, text).unwrap();
        Robot::load(&path).unwrap_or_else(|e| panic!("{e}"))
    };
    assert_eq!(read(r"meshes\top.obj"), read("meshes/top.obj"));
}

/// A body of MJCF with a mesh as its only mass: the twelve triangles of a box have the mass of
/// MuJoCo's box, 1000 kg/m^3.
#[test]
fn a_body_of_an_mjcf_weighs_what_its_mesh_does() {
    let folder = tempfile::tempdir().unwrap();
    let corner = |i: usize| {
        let sign = |bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
        format!("v {} {} {}\n", 0.1 * sign(1), 0.2 * sign(2), 0.05 * sign(4))
    };
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let faces = sides
        .iter()
        .map(|[a, b, c, d]| format!("f {} {} {} {}\n", a + 1, b + 1, c + 1, d + 1));
    let mesh: String = (0..8).map(corner).chain(faces).collect();
    std::fs::write(folder.path().join("box.obj"), mesh).unwrap();
    let mjcf = |geom: &str| {
        format!(
            r#"<mujoco><compiler angle="degree"/><asset><mesh name="box" file="box.obj"/></asset><worldbody><body name="base"><freejoint/><geom {geom} pos="0.01 0 0.1" euler="0 0 20"/>{}</body></worldbody></mujoco>"#,
            mecanum_bodies()
        )
    };
    let read = |geom: &str| {
        let path = folder.path().join("r.xml");
        std::fs::write(&path, mjcf(geom)).unwrap();
        Robot::load(&path)
            .unwrap_or_else(|e| panic!("{e}"))
            .chassis
            .mass
    };
    // Meshes are read in f32, whose rounding is 6e-8; their moments depend on its third power.
    let (of_mesh, of_box) = (
        read(r#"type="mesh" mesh="box""#),
        read(r#"type="box" size="0.1 0.2 0.05""#),
    );
    assert!((of_mesh.mass_kg / of_box.mass_kg - 1.0).abs() < 1e-6);
    assert!((of_mesh.center_of_mass_m - of_box.center_of_mass_m).norm() < 1e-6);
    assert!(
        (of_mesh.inertia_kg_m2 - of_box.inertia_kg_m2).norm() < 1e-6 * of_box.inertia_kg_m2.norm()
    );
    // Half of the mass at half of the density, and any value by a mass.
    let half = read(r#"type="mesh" mesh="box" density="500""#);
    assert!((half.mass_kg / of_box.mass_kg - 0.5).abs() < 1e-6);
    let given = read(r#"type="mesh" mesh="box" mass="2""#);
    assert!((given.mass_kg - 2.0).abs() < 1e-12);
}

/// Simplified mecanum wheels: a ball that turns below each wheel, about the axis of the roller on
/// the ground. gamma is the angle from the hub's axis, y, to the rolling direction, which is across
/// that axis.
#[test_case([1.0, -1.0], -45.0)]
#[test_case([1.0, 1.0], 45.0)]
#[test_case([0.5, -0.8660254037844386], -60.0)]
fn one_joint_turns_in_place_of_rollers(front_left: [f64; 2], gamma_deg: f64) {
    let balls = PLACES.iter().map(|(name, x, y)| {
        let mirrored = (x * y).signum();
        let [along, across] = front_left;
        let own = wheel(name, "continuous", [*x, *y, 0.0], "0 1 0", 0.02);
        format!(
            r#"{own}<link name="{name}_ball">{MASS}<collision><geometry><sphere radius="0.05"/></geometry></collision></link>
            <joint name="{name}_slip" type="continuous"><parent link="{name}_link"/><child link="{name}_ball"/><axis xyz="{along} {} 0"/></joint>"#,
            mirrored * across
        )
    });
    let text = robot("r", &format!("{BODY}{}", balls.collect::<String>()));
    let read = Robot::from_urdf_str(&text, "r.urdf").unwrap_or_else(|e| panic!("{e}"));
    for (wheel, (name, x, y)) in read.wheels.iter().zip(PLACES) {
        assert_eq!(wheel.name, name);
        assert!((wheel.radius_m - 0.05).abs() < 1e-12);
        let should = gamma_deg * (x * y).signum();
        assert!(
            (wheel.gamma_rad.to_degrees() - should).abs() < 1e-9,
            "{name}: {}",
            wheel.gamma_rad
        );
        // The ball is part of the wheel: 0.5 kg each.
        let rollers_kg: f64 = wheel.rollers.iter().map(|r| r.mass_kg).sum();
        assert!((wheel.hub.mass_kg + rollers_kg - 1.0).abs() < 1e-12);
    }
    let speaks = |r: &ilon_robot::Remark| r.text.contains("turns in place of rollers");
    assert!(read.remarks.iter().any(speaks));
}

/// A plug-in that moves a base in all directions and a weak name agree on wheels that turn and do
/// not steer; either alone is insufficient, and a fixed wheel does not count.
#[test_case("mecabot", "continuous", "drive", true)]
#[test_case("bot", "continuous", "omni_steering", true)]
#[test_case("bot", "continuous", "drive", false)]
#[test_case("mecabot", "fixed", "drive", false)]
#[test_case("mecabot", "continuous", "", false)]
fn a_base_that_is_moved_in_all_directions(name: &str, kind: &str, plugin: &str, is_proposed: bool) {
    let more = match plugin {
        "" => String::new(),
        name => format!(
            r#"<gazebo><plugin name="{name}" filename="libgazebo_ros_planar_move.so"/></gazebo>"#
        ),
    };
    let parts = PLACES
        .iter()
        .map(|(name, x, y)| wheel(&format!("{name}_wheel"), kind, [*x, *y, 0.0], "0 1 0", 0.05));
    let text = robot(name, &format!("{more}{BODY}{}", parts.collect::<String>()));
    let folder = tempfile::tempdir().unwrap();
    let diagnosis = diagnosed(folder.path(), "r.urdf", &text);
    assert_eq!(
        diagnosis.proposal.is_some(),
        is_proposed,
        "{}",
        said(&diagnosis)
    );
    let says = said(&diagnosis).contains("that moves the base in all directions, the name");
    assert_eq!(says, is_proposed);
}

/// A boolean argument without a value: the file contains the wheels only with one of the two, which
/// is chosen. A number is not chosen in this way.
#[test_case(r#"<xacro:if value="$(arg simulated)"><gazebo><plugin name="mecanum_drive" filename="x.so"/></gazebo></xacro:if>"#, Some("true"))]
#[test_case(r#"<xacro:unless value="$(arg simulated)"><gazebo><plugin name="mecanum_drive" filename="x.so"/></gazebo></xacro:unless>"#, Some("false"))]
#[test_case(r#"<gazebo><plugin name="mecanum_drive" filename="x.so"/></gazebo><link name="tip"><collision><geometry><sphere radius="$(arg simulated)"/></geometry></collision></link><joint name="t" type="fixed"><parent link="base_link"/><child link="tip"/><origin xyz="0 0 2"/></joint>"#, None)]
fn a_truth_value_with_which_a_file_says_more(more: &str, value: Option<&str>) {
    let parts = PLACES
        .iter()
        .map(|(name, x, y)| wheel(name, "continuous", [*x, *y, 0.0], "0 1 0", 0.05));
    let text = robot("r", &format!("{more}{BODY}{}", parts.collect::<String>()));
    let folder = tempfile::tempdir().unwrap();
    let diagnosis = diagnosed(folder.path(), "r.xacro", &text);
    let given = diagnosis
        .proposal
        .as_ref()
        .and_then(|options| options.arguments.get("simulated"));
    assert_eq!(given.map(String::as_str), value, "{}", said(&diagnosis));
}

/// An include in an included file of MJCF is relative to that file or to the first.
#[test]
fn an_include_within_an_include_is_sought_beside_both() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    };
    let wheels = format!("<mujocoinclude>{}</mujocoinclude>", mecanum_bodies());
    let path = write(
        "r.xml",
        r#"<mujoco><compiler angle="degree"/><worldbody><include file="parts/base.xml"/></worldbody></mujoco>"#,
    );
    let base = r#"<mujocoinclude><body name="base"><freejoint/><geom type="box" size="0.1 0.1 0.02" pos="0 0 0.1"/><include file="wheels.xml"/></body></mujocoinclude>"#;
    write("parts/base.xml", base);
    assert!(Robot::load(&path).is_err());
    for place in ["parts/wheels.xml", "wheels.xml"] {
        let written = write(place, &wheels);
        let read = Robot::load(&path).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(read.wheels.len(), 4, "{place}");
        std::fs::remove_file(written).unwrap();
    }
}

/// A renamed package: the only folder near the file that holds all missing files is proposed,
/// before anything is left out. If two folders hold them, or none, missing rollers are not
/// replaced.
#[test_case(&["description"], true)]
#[test_case(&["description", "old/description"], true; "another that is farther below")]
#[test_case(&["description", "copy"], false; "two that are as near")]
#[test_case(&["description/parts/other"], false; "none that is around it")]
fn a_package_of_another_name_is_known_by_what_it_holds(folders: &[&str], is_found: bool) {
    let folder = tempfile::tempdir().unwrap();
    let write = |path: &Path, text: &str| {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    let rollers = robot("parts", r#"<xacro:property name="stands" value="0.4"/>"#);
    for of in folders {
        write(&folder.path().join(of).join("urdf/roller.xacro"), &rollers);
    }
    let include = r#"<xacro:include filename="$(find old_name)/urdf/roller.xacro"/>"#;
    let text = robot("r", &format!("{include}{BODY}{}", mecanum_wheels()));
    let path = folder.path().join("description/robots/r.xacro");
    write(&path, &text);
    let diagnosis = Robot::diagnose(&path, &LoadOptions::default(), |_| true);
    let proposed = diagnosis
        .proposal
        .as_ref()
        .map(|options| options.packages.clone());
    let named = proposed.as_ref().and_then(|packages| packages.first());
    assert_eq!(named.is_some(), is_found, "{}", said(&diagnosis));
    if let Some(package) = named {
        assert_eq!(package.name, "old_name");
        assert!(package.folder.ends_with("description"), "{package:?}");
    } else {
        assert_eq!(diagnosis.proposal, None);
    }
}
