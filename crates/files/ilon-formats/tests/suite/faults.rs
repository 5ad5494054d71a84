//! Invalid robots: each fault is reported with its file, line, element and repair.
//!
//! Every case is a valid robot with one change, so that the reported fault is the change. A list of
//! cases, as long as there are faults.

use crate::common;

use common::{SPEC, line_of, small};
use ilon_formats::{Fault, LoadRobot, RobotError, Spec, generate};
use ilon_robot::Robot;
use test_case::test_case;

fn fault_of(text: &str) -> RobotError {
    match Robot::from_urdf_str(text, "small.urdf") {
        Ok(_) => panic!("it loaded"),
        Err(error) => error,
    }
}

#[test]
fn of_the_good_robot_only_what_is_not_read_is_remarked() {
    let robot = Robot::from_urdf_str(&small(), "small.urdf").expect("a good robot");
    assert_eq!(robot.wheels.len(), 3);
    let subjects: Vec<&str> = robot.remarks.iter().map(|r| r.subject.as_str()).collect();
    assert_eq!(subjects, ["hubs"]);
}

#[test_case(
    r#"<mass value="5"/>"#,
    r#"<mass value="-5"/>"#,
    r#"value="-5""#,
    "link `base_link`, `<mass>`: `value` is -5, but must be above 0",
    "make `value` above 0";
    "negative mass"
)]
#[test_case(
    r#"<mass value="5"/>"#,
    r#"<mass value="0"/>"#,
    r#"value="0""#,
    "link `base_link`, `<mass>`: `value` is 0, but must be above 0",
    "make `value` above 0";
    "zero mass"
)]
#[test_case(
    r#"<axis xyz="0 1 0"/>"#,
    r#"<axis xyz="0 0 0"/>"#,
    r#"xyz="0 0 0"/>"#,
    "joint `wheel_1`, `<axis>`: the axis is zero and has no direction",
    "give the axis a direction, such as `<axis xyz=\"0 1 0\"/>`";
    "zero axis"
)]
#[test_case(
    r#"<axis xyz="0 1 0"/>"#,
    r#"<axis xyz="0 1 y"/>"#,
    r#"xyz="0 1 y""#,
    "joint `wheel_1`, `<axis>`: `xyz=\"0 1 y\"` does not hold 3 numbers",
    "write 3 numbers, separated by spaces";
    "not a number"
)]
#[test_case(
    r#"<mass value="5"/>"#,
    r#"<mass value="nan"/>"#,
    r#"value="nan""#,
    "link `base_link`, `<mass>`: `value=\"nan\"` is not finite",
    "write a finite number; a limit that does not exist is left out";
    "nan"
)]
#[test_case(
    r#"velocity="20""#,
    r#"velocity="inf""#,
    r#"velocity="inf""#,
    "joint `wheel_1`, `<limit>`: `velocity=\"inf\"` is not finite",
    "write a finite number; a limit that does not exist is left out";
    "infinite"
)]
#[test_case(
    r#"<joint name="wheel_1" type="continuous">"#,
    r#"<joint name="wheel_1" type="rolling">"#,
    r#"type="rolling""#,
    "joint `wheel_1`: `rolling` is not a type of joint",
    "use `continuous` for wheels and rollers and `fixed` for what does not move";
    "unknown joint type"
)]
#[test_case(
    r#"<child link="wheel_1_link"/>"#,
    r#"<child link="wheel_one"/>"#,
    r#"link="wheel_one""#,
    "joint `wheel_1`, `<child>`: there is no link `wheel_one`",
    "add the link, or correct its name here";
    "unknown link"
)]
#[test_case(
    r#"<joint name="wheel_2" "#,
    r#"<joint name="wheel_1" "#,
    r#"<joint name="wheel_1" type="continuous">
    <parent link="base_link"/>
    <child link="wheel_2_link"/>"#,
    "joint `wheel_1`: the name is taken by the joint on line 17",
    "give each link and each joint a name of its own";
    "duplicate joint"
)]
#[test_case(
    r#"<mass value="5"/>"#,
    r#"<mass value="${mass}"/>"#,
    r#"value="${mass}""#,
    "it cannot be expanded: the name `mass` is not defined, in `${mass}`",
    "repair the place that is named; a file that you trust can be expanded by the xacro of ROS, which runs what stands in it";
    "unexpanded value"
)]
#[test_case(
    r#"<child link="wheel_2_link"/>"#,
    r#"<child link="wheel_1_link"/>"#,
    r#"<joint name="wheel_2" "#,
    "joint `wheel_2`: its child `wheel_1_link` already hangs by joint `wheel_1`",
    "remove one of the joints: a URDF is a tree";
    "two parents"
)]
#[test_case(
    r#"<parent link="base_link"/>"#,
    r#"<parent link="wheel_1_roller_1_link"/>"#,
    r#"<link name="wheel_1_link">"#,
    "link `wheel_1_link`: the links hang by one another in a loop",
    "remove one joint of the loop: a URDF is a tree with one root";
    "loop at the root"
)]
fn one_change_is_reported_with_place_and_repair(
    good: &str,
    bad: &str,
    place: &str,
    message: &str,
    help: &str,
) {
    let text = small();
    assert!(text.contains(good), "no {good} to change");
    let text = text.replacen(good, bad, 1);
    let error = fault_of(&text);
    let line = line_of(&text, place);
    assert_eq!(error.to_string(), format!("small.urdf:{line}: {message}"));
    assert_eq!(error.help(), help);
    assert_eq!(error.line(), Some(line));
    assert_eq!(error.text(), Some(text.as_str()));
}

#[test]
fn a_missing_file_is_reported_with_its_path() {
    let error = Robot::load("no/such/robot.urdf").expect_err("there is none");
    assert_eq!(
        error.to_string(),
        "no/such/robot.urdf: cannot be read: there is no such file"
    );
    assert_eq!(error.place(), None);
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_without_an_end_is_not_read_for_ever() {
    let error = Robot::load("/dev/zero").expect_err("no robot");
    assert_eq!(
        error.to_string(),
        "/dev/zero: cannot be read: it is a device, not a file"
    );
}

#[test]
fn malformed_xml_is_reported_with_its_line() {
    let text = small().replacen("</inertial>", "</inertia>", 1);
    let error = fault_of(&text);
    let line = line_of(&text, "</inertia>");
    assert_eq!(
        error.to_string(),
        format!("small.urdf:{line}: not well-formed XML: expected 'inertial' tag, not 'inertia'")
    );
    assert_eq!(
        error.help(),
        "close every element and quote every attribute"
    );
}

/// A declaration says nothing of the robot. Gazebo reads such files. Lines keep their numbers.
#[test]
fn a_malformed_declaration_of_xml_is_left_out() {
    let text = small();
    let robot = Robot::from_urdf_str(&text, "small.urdf").expect("a good robot");
    let (_, text) = text.split_once("?>").expect("a declaration");
    for declaration in [
        "<?xml version=1.0 ?>",
        "<?xml\nversion=\"1.0\"?>",
        "<?xml version='1.0'\n?>",
    ] {
        let declared = format!("{declaration}{text}");
        let read = Robot::from_urdf_str(&declared, "small.urdf").expect("the same robot");
        assert_eq!(read.wheels, robot.wheels, "{declaration}");
        let faulty = declared.replacen(r#"<mass value="5"/>"#, r#"<mass value="-5"/>"#, 1);
        let place = fault_of(&faulty).place().expect("a line").line;
        assert_eq!(
            place,
            line_of(&faulty, r#"<mass value="-5"/>"#),
            "{declaration}"
        );
    }
}

#[test]
fn a_file_of_another_format_is_reported_apart() {
    let error = fault_of("<launch/>");
    assert_eq!(
        error.to_string(),
        "small.urdf:1: `<launch>`: its root element is `<launch>`, where `<robot>`, `<sdf>` or `<mujoco>` is read"
    );
}

#[test_case(
    r#"<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="x"><xacro:wheel/></robot>"#;
    "declared"
)]
#[test_case(r#"<robot name="x"><xacro:wheel/></robot>"#; "undeclared")]
fn xacro_elements_are_reported_as_such(text: &str) {
    let error = fault_of(text);
    assert!(
        matches!(
            error.fault(),
            Fault::Xacro { .. } | Fault::MissingElement { .. }
        ),
        "{error}"
    );
    assert_eq!(error.line(), Some(1));
}

#[test]
fn a_missing_inertia_is_reported_at_its_inertial() {
    let text = small();
    let from = text.find("<inertia ").expect("an inertia");
    let to = from + text[from..].find("/>").expect("its end") + 2;
    let text = format!("{}{}", &text[..from], &text[to..]);
    let error = fault_of(&text);
    let line = line_of(&text, "<inertial>");
    assert_eq!(
        error.to_string(),
        format!(
            "small.urdf:{line}: link `base_link`, `<inertial>`: the element `<inertia>` is missing"
        )
    );
}

#[test]
fn an_inertia_that_no_body_has_is_reported_with_its_moments() {
    // Of the moments 1, 1 and 3 kg m^2 the last exceeds the sum of the others: it would need
    // negative mass.
    let text = with_first_inertia(r#"ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="3""#);
    assert_eq!(
        fault_of(&text).to_string(),
        format!(
            "small.urdf:{}: link `base_link`, `<inertia>`: no body has the principal moments 1.000e0, 1.000e0 and \
             3.000e0 kg m^2: the largest exceeds the sum of the others",
            line_of(&text, "izz=\"3\"")
        )
    );
}

#[test]
fn an_inertia_that_is_not_positive_definite_is_reported() {
    // Positive diagonal elements, but eigenvalues 1 +- 2.
    let text = with_first_inertia(r#"ixx="1" ixy="2" ixz="0" iyy="1" iyz="0" izz="1""#);
    let error = fault_of(&text);
    let Fault::InertiaNotPositive { least } = error.fault() else {
        panic!("{error}")
    };
    // The eigensolver loses at most two digits on numbers of order one.
    assert!((least + 1.0).abs() < 1e-13);
}

fn with_first_inertia(attributes: &str) -> String {
    let text = small();
    let from = text.find("<inertia ").expect("an inertia");
    let to = from + text[from..].find("/>").expect("its end") + 2;
    format!("{}<inertia {attributes}/>{}", &text[..from], &text[to..])
}

#[test]
fn several_roots_are_reported_by_name() {
    let text = small().replacen("</robot>", "<link name=\"stray\"/></robot>", 1);
    assert_eq!(
        fault_of(&text).to_string(),
        format!(
            "small.urdf:{}: link `stray`: 2 links hang by no joint: `base_link`, `stray`",
            line_of(&text, "\"stray\"")
        )
    );
}

#[test]
fn a_wheel_that_does_not_turn_is_one_too_few() {
    let turning = "<joint name=\"wheel_3\" type=\"continuous\">";
    let text = small().replacen(turning, "<joint name=\"wheel_3\" type=\"fixed\">", 1);
    let error = fault_of(&text);
    assert_eq!(
        error.to_string(),
        format!(
            "small.urdf:{}: joint `wheel_3`: carries 8 passive rollers, but does not turn; without it the robot has 2 \
             wheel(s), but moving freely in the plane takes three",
            line_of(&text, "<joint name=\"wheel_3\"")
        )
    );
    assert_eq!(
        error.help(),
        "make the joint `continuous`, with the hub's axis"
    );
}

#[test]
fn two_wheels_are_too_few() {
    // The third wheel and all below it are left out.
    let text = small();
    let from = text
        .find("  <joint name=\"wheel_3\"")
        .expect("the third wheel, last in the file");
    let text = format!("{}</robot>\n", &text[..from]);
    assert_eq!(
        fault_of(&text).to_string(),
        format!(
            "small.urdf:{}: `<robot>`: 2 wheels with passive rollers: `wheel_1`, `wheel_2`, but moving freely in the \
             plane takes three",
            line_of(&text, "<robot ")
        )
    );
}

#[test]
fn rollers_that_turn_about_the_hub_axis_are_reported_as_gamma_90() {
    // In a roller's link z is the roller's axis and, at gamma = 0, y lies along the hub axis.
    let text = small().replace(r#"<axis xyz="0 0 1"/>"#, r#"<axis xyz="0 1 0"/>"#);
    assert_eq!(
        fault_of(&text).to_string(),
        format!(
            "small.urdf:{}: joint `wheel_1_roller_1`: gamma = 90 deg: the roller turns about the hub axis, and the wheel \
             cannot drive",
            line_of(&text, "wheel_1_roller_1\"")
        )
    );
}

#[test]
fn gaps_between_rollers_are_reported_in_degrees() {
    // Without every outermost sphere the stack ends at 2/3 of the half length, where the roller
    // hands over at atan(2/3 tan(pi/8)) = 15.435 deg from its middle instead of 22.5 deg: gaps of
    // 14.13 deg in pitches of 45 deg.
    let whole = small();
    let outermost: Vec<&str> = whole
        .lines()
        .filter(|l| l.contains("<collision>") && l.contains("0.0157401153"))
        .collect();
    assert_eq!(outermost.len(), 3 * 8 * 2, "two a roller");
    let text: String = whole
        .lines()
        .filter(|l| !outermost.contains(l))
        .flat_map(|l| [l, "\n"])
        .collect();
    assert_eq!(
        fault_of(&text).to_string(),
        format!(
            "small.urdf:{}: joint `wheel_1`: the rollers leave gaps of up to 14.13 deg, 31.4 % of the turn, over which \
             the wheel falls between them",
            line_of(&text, "<joint name=\"wheel_1\"")
        )
    );
}

#[test]
fn rollers_that_stand_closer_than_they_are_thick_are_remarked_with_their_line() {
    // Balls of 20 mm on a ring of 38 mm: 2 * 38 mm * sin(22.5 deg) = 29.08 mm between neighbours.
    let ball = r#"<collision><geometry><sphere radius="0.02"/></geometry></collision>"#;
    let mut text = String::new();
    for line in small().lines() {
        let in_roller = line.contains("<collision>") && line.contains("<sphere");
        // One ball in place of each stack, at its middle.
        if !in_roller {
            text += line;
        } else if line.contains("xyz=\"0 0 0\"") {
            text += ball;
        }
        text += "\n";
    }
    // The wheels now reach 58 mm from their hubs.
    let robot = Robot::from_urdf_str(&text, "crowd.urdf").expect("a robot with a doubt");
    let crowded = robot
        .remarks
        .iter()
        .find(|r| r.subject == "wheel `wheel_2`" && r.text.contains("run into each other"))
        .expect("a remark");
    assert!(
        crowded
            .text
            .contains("stand 29.08 mm apart, but are 40.00 mm thick"),
        "{}",
        crowded.text
    );
    let line = line_of(&text, "<joint name=\"wheel_2\"");
    assert_eq!(crowded.line, Some(line));
    assert!(
        crowded
            .to_string()
            .starts_with(&format!("wheel `wheel_2` (line {line}): "))
    );
}

#[test]
fn wheels_at_different_heights_are_reported() {
    // Three wheels 200 mm around the middle, the first of them raised: the other two are 100 mm
    // behind the middle, so that it tilts over the 300 mm between by atan(10
    // mm / 300 mm) = 1.91 deg, which is accepted with a remark, and by 6.7 deg for 35 mm.
    let text = small();
    let raised = |z: &str| text.replacen("xyz=\"0.2 0 0.05\"", &format!("xyz=\"0.2 0 {z}\""), 1);
    let robot = Robot::from_urdf_str(&raised("0.06"), "small.urdf").expect("a little uneven");
    let remark = robot.remarks.iter().find(|r| r.subject == "the robot");
    assert_eq!(
        remark.expect("remarked").text,
        "its wheels do not reach equally low: it stands rolled by 0.00 deg and pitched by 1.91 deg"
    );
    let text = raised("0.085");
    assert_eq!(
        fault_of(&text).to_string(),
        format!(
            "small.urdf:{}: joint `wheel_1`: it ends 35.00 mm above the lowest wheel; the robot leans 6.7 deg on its wheels; up to \
             5 deg are taken",
            line_of(&text, "<joint name=\"wheel_1\"")
        )
    );
}

#[test]
fn a_leaning_hub_axis_is_reported_in_degrees() {
    // atan(0.1) = 5.71 deg.
    let text = small().replacen(r#"<axis xyz="0 1 0"/>"#, r#"<axis xyz="0 1 0.1"/>"#, 1);
    assert_eq!(
        fault_of(&text).to_string(),
        format!(
            "small.urdf:{}: joint `wheel_1`: the hub axis leans 5.7 deg out of the ground plane",
            line_of(&text, "<joint name=\"wheel_1\"")
        )
    );
}

#[test]
fn millimetres_are_recognised() {
    let of_wheel = SPEC.replace("radius_m = 0.05", "radius_m = 50");
    let spec = Spec::from_toml_str(&of_wheel, "small.toml").expect("a good form");
    assert_eq!(
        generate(&spec).expect_err("a wheel of 50 m").to_string(),
        "small: `wheel.radius_m` is 50, but must be a length in metres, below 5: 50 mm are 0.05"
    );
    // Every length of a URDF a thousand times larger: the wheel measures 50 m. Axes are directions,
    // of any length.
    let mut text = small();
    for attribute in ["xyz=\"", "radius=\"", "length=\"", "size=\""] {
        let mut parts = text.split(attribute);
        let mut scaled = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let (numbers, rest) = part.split_once('"').expect("it is closed");
            let larger = numbers.split(' ').map(|number| {
                let number: f64 = number.parse().expect("a number");
                (1000.0 * number).to_string()
            });
            let larger: Vec<String> = larger.collect();
            scaled += &format!("{attribute}{}\"{rest}", larger.join(" "));
        }
        text = scaled;
    }
    assert_eq!(
        fault_of(&text).to_string(),
        format!(
            "small.urdf:{}: joint `wheel_1`: the wheel has a radius of 50.0 m",
            line_of(&text, "<joint name=\"wheel_1\"")
        )
    );
}

#[test]
fn a_tower_of_elements_is_refused_before_it_fells_a_parser() {
    let text = format!("<robot>{}", "<a>".repeat(200_000));
    assert_eq!(
        fault_of(&text).to_string(),
        "small.urdf:1: too large to be read: elements nested more than 100 deep, where at most 100 levels are read"
    );
}

#[test]
fn entities_are_refused() {
    let bomb =
        "<!DOCTYPE robot [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;\">]><robot name=\"&b;\"/>";
    assert!(matches!(fault_of(bomb).fault(), Fault::Xml { .. }));
}

#[test_case("[wheel]\n", "[wheel]\nsize = 3\n", 8; "unknown key")]
#[test_case("mass_kg = 5.0", "mass_kg = \"heavy\"", 5; "wrong type")]
#[test_case("count = 3", "count = ", 19; "malformed")]
fn a_bad_description_is_reported_with_its_line(good: &str, bad: &str, line: usize) {
    let error =
        Spec::from_toml_str(&SPEC.replacen(good, bad, 1), "small.toml").expect_err("it is bad");
    assert_eq!(error.line(), Some(line), "{error}");
}

#[test_case(
    "hub_mass_kg = 0.2",
    "hub_mass_kg = -1.0",
    "small: `wheel.hub_mass_kg` is -1, but must be a finite number above 0"
)]
#[test_case(
    "gamma_deg = 0.0",
    "gamma_deg = 90.0",
    "small: `wheels.ring.gamma_deg` is 90, but must be from -85 to 85 degrees: nearer to 90 the rollers turn with the hub and carry no drive"
)]
#[test_case(
    "count = 3",
    "count = 2",
    "small: `wheels` is 2, but must be from 3 to 1000 wheels"
)]
#[test_case(
    "radius_m = 0.012",
    "radius_m = 0.003",
    "small: rollers of 3.00 mm radius taper to nothing before they reach their neighbours"
)]
#[test_case(
    "per_row = 8",
    "per_row = 2",
    "small: `rollers.per_row` is 2, but must be from 3 to 1000"
)]
fn a_description_out_of_range_is_refused(good: &str, bad: &str, message: &str) {
    let spec =
        Spec::from_toml_str(&SPEC.replacen(good, bad, 1), "small.toml").expect("well formed");
    assert_eq!(
        generate(&spec).expect_err("out of range").to_string(),
        message
    );
}

/// Reads a description from a file; returns all of its faults, each with its line.
fn faults_of_description(text: &str) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("small.toml");
    std::fs::write(&file, text).expect("written");
    let error = Robot::load(&file).expect_err("it is refused");
    let all = std::iter::once(&error).chain(error.others());
    let told = all.map(|error| {
        let told = error.to_string();
        let at = told.find("small.toml").expect("the file's name");
        told[at..].to_owned()
    });
    told.collect()
}

/// Misspelt, missing and wrong keys of all tables are told together, then all values out of their
/// ranges: two rounds at most.
#[test]
fn all_faults_of_a_description_are_told_with_their_lines() {
    let text = SPEC
        .replacen("mass_kg = 5.0", "mas_kg = 5.0", 1)
        .replacen("hub_mass_kg = 0.2", "hub_mass_kg = \"light\"", 1)
        .replacen("count = 3", "cuont = 3", 1);
    let told = faults_of_description(&text);
    let line = |of: &str| line_of(&text, of);
    for (line, words) in [
        (line("mas_kg"), "unknown key `chassis.mas_kg`"),
        (
            line("hub_mass_kg"),
            "`wheel.hub_mass_kg` is a text, but must be a number",
        ),
        (line("cuont"), "unknown key `wheels.ring.cuont`"),
    ] {
        let expected = format!("small.toml:{line}: {words}");
        assert!(told.contains(&expected), "{expected}: {told:?}");
    }
    assert_eq!(told.len(), 3, "{told:?}");
    let text = SPEC
        .replacen("mass_kg = 5.0", "mass_kg = -5.0", 1)
        .replacen("radius_m = 0.05", "radius_m = 50", 1)
        .replacen("gamma_deg = 0.0", "gamma_deg = 90.0", 1);
    let told = faults_of_description(&text);
    let line = |of: &str| line_of(&text, of);
    for (line, key) in [
        (line("mass_kg = -5.0"), "chassis.mass_kg"),
        (line("radius_m = 50"), "wheel.radius_m"),
        (line("gamma_deg"), "wheels.ring.gamma_deg"),
    ] {
        let expected = format!("small.toml:{line}: `{key}` is ");
        assert!(
            told.iter().any(|told| told.starts_with(&expected)),
            "{expected}: {told:?}"
        );
    }
    assert_eq!(told.len(), 3, "{told:?}");
}

/// Each slip is one fault with its line, whatever table it is in; nothing that follows from it is
/// told.
#[test_case("radius_m = 0.05", "radius_m = 50", &["radius_m = 50"]; "millimetres of a wheel")]
#[test_case("radius_m = 0.012", "radius_m = -0.012", &["radius_m = -0.012"]; "rollers without a size")]
#[test_case("radius_m = 0.012", "radius_m = 0.002", &["radius_m = 0.002"]; "slender rollers")]
#[test_case("radius_m = 0.012", "radius_m = -1\nbearings = \"bushings\"", &["radius_m = -1"]; "axles of such rollers")]
#[test_case("[0.3, 0.3, 0.1]", "[0, 0.3, -0.1]", &["size_m", "size_m"]; "two sides of a box")]
#[test_case("distance_m = 0.2", "distance_m = nan", &["distance_m"]; "a ring without a size")]
#[test_case(
    "[wheels.ring]\ncount = 3\ndistance_m = 0.2\ngamma_deg = 0.0",
    "[wheels.mecanum]\naxles_m = [0.2, -0.2]\nhalf_width_m = 0.2\ngamma_deg = 90",
    &["gamma_deg"];
    "both signs of gamma"
)]
#[test_case(
    "mass_kg = 0.01",
    "mass_kg = 0.01\nprofile_m = [[-0.01, 0.012], [0.01, -0.012]]",
    &["[rollers]"];
    "a profile below the axle"
)]
#[test_case(
    "gamma_deg = 0.0",
    "gamma_deg = 0\n[overrides.wheel_8]\nradius_m = 0.05\n[overrides.wheel_9]\n[overrides.wheel_1]\nhub_mass_kg = 0\nper_row = 2",
    &["[overrides.wheel_8]", "[overrides.wheel_9]", "hub_mass_kg = 0\n", "per_row = 2"];
    "four in overrides"
)]
#[test_case(
    "mass_kg = 0.01",
    "mass_kg = 0.01\naxle_friction = 0.1\naxle_radius_m = 0.02\nrows = 3\ntread.stiffness_n_m = -1\ntread.damping_n_s_m = -1",
    &["axle_radius_m", "rows", "tread.stiffness", "tread.damping"];
    "four of the rollers"
)]
#[test_case(
    "gamma_deg = 0.0",
    "gamma_deg = 0\n[suspension.s]\nwheels = [\"wheel_7\", \"wheel_1\"]\nmass_kg = -1\nlaw.rocker.limit_deg = 95\nlaw.rocker.friction_n_m = -1",
    &["wheels = [", "mass_kg = -1", "law.rocker.limit", "law.rocker.friction"];
    "four of a suspension"
)]
fn one_slip_is_one_fault(good: &str, bad: &str, at: &[&str]) {
    assert!(SPEC.contains(good));
    let text = SPEC.replacen(good, bad, 1);
    let told = faults_of_description(&text);
    let line = |told: &String| told.split(':').nth(1).and_then(|line| line.parse().ok());
    let mut lines: Vec<Option<usize>> = told.iter().map(line).collect();
    lines.sort_unstable();
    let mut expected: Vec<_> = at.iter().map(|at| Some(line_of(&text, at))).collect();
    expected.sort_unstable();
    assert_eq!(lines, expected, "{told:#?}");
}

/// However many faults a text has, a few are told: each holds the text.
#[test]
fn a_description_full_of_faults_tells_the_first_of_them() {
    let many: String = (0..50)
        .map(|i| format!("[overrides.w{i}]\nradius_m = \"x\"\n"))
        .collect();
    assert_eq!(faults_of_description(&format!("{SPEC}\n{many}")).len(), 20);
}

#[test]
fn inertias_far_beyond_the_size_of_many_rollers_are_reported_at_once() {
    // A roller of 10 g and 24 mm diameter with an inertia for one metre: the radius of gyration is
    // 1 m.
    let heavy = r#"<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>"#;
    let mut text = String::new();
    let mut of_roller = false;
    for line in small().lines() {
        of_roller = (of_roller || line.contains("<link name=\"wheel_2_roller_"))
            && !line.contains("</link>");
        let inertia = line.find("<inertia ").filter(|_| of_roller);
        match inertia {
            Some(at) => {
                let end = at + line[at..].find("/>").expect("it ends") + 2;
                text += &format!("{}{heavy}{}\n", &line[..at], &line[end..]);
            }
            None => text += &format!("{line}\n"),
        }
    }
    let error = fault_of(&text);
    let all = std::iter::once(&error).chain(error.others());
    let too_large = all.filter(|e| matches!(e.fault(), Fault::InertiaTooLarge { .. }));
    assert_eq!(too_large.count(), 8);
    let options = common::options(|o| o.repair = true);
    assert!(Robot::from_urdf_str_with(&text, "small.urdf", &options).is_ok());
}

/// Each wheel is compared with all others, so a file with thousands is refused earlier, and so is
/// one with a DTD, with its own message.
#[test]
fn thousands_of_wheels_and_a_dtd_are_refused_in_words() {
    let links: String = (0..2000)
        .map(|i| {
            format!(
                "<link name=\"l{i}\"/><joint name=\"j{i}\" type=\"continuous\"><parent link=\"b\"/><child link=\"l{i}\"/><axis xyz=\"0 1 0\"/></joint>"
            )
        })
        .collect();
    let star = format!("<robot name=\"x\"><link name=\"b\"/>{links}</robot>");
    let said = fault_of(&star).to_string();
    assert!(said.contains("2000 joints turn as wheels do"), "{said}");
    let dtd = "<!DOCTYPE robot SYSTEM \"robot.dtd\"><robot name=\"x\"><link name=\"b\"/></robot>";
    let fault = fault_of(dtd);
    let (said, help) = (fault.to_string(), fault.help());
    // It is well-formed.
    assert!(!said.contains("well-formed"), "{said}");
    assert!(help.contains("<!DOCTYPE"), "{help}");
}
