//! Links, joints and masses in various styles, and settings that are read or remarked.

use std::f64::consts::{FRAC_PI_4, PI};

use super::{fault_of, load, mecanum, remarked};
use crate::traits::common::{self, SPEC, small};
use ilon_formats::{Fault, LoadOptions, LoadRobot, Spec, generate};
use ilon_robot::Robot;
use test_case::test_case;

#[test]
fn names_say_nothing() {
    let original = load(&small());
    let text = small()
        .replace("wheel_", "left_gripper_")
        .replace("roller_", "camera_")
        .replace("base_link", "front_left_wheel");
    let renamed = load(&text);
    assert_eq!(renamed.wheels.len(), 3);
    for (p, q) in original.wheels.iter().zip(&renamed.wheels) {
        assert_eq!(
            (p.body_from_hub, p.radius_m, p.rollers.len()),
            (q.body_from_hub, q.radius_m, q.rollers.len())
        );
    }
}

#[test]
fn a_fixed_link_between_hub_and_rollers_is_part_of_the_hub() {
    // The rim is on a fixed joint below the hub, turned about the hub axis, and the first wheel's
    // rollers are on the rim.
    let rim = r#"<link name="rim"><inertial><mass value="0.1"/>
        <inertia ixx="1e-4" ixy="0" ixz="0" iyy="2e-4" iyz="0" izz="1e-4"/></inertial></link>
        <joint name="rim" type="fixed"><parent link="wheel_1_link"/><child link="rim"/><origin rpy="0 0.3 0"/></joint></robot>"#;
    let text = small()
        .replace(
            r#"<parent link="wheel_1_link"/>"#,
            r#"<parent link="rim"/>"#,
        )
        .replace("</robot>", rim);
    let robot = load(&text);
    assert_eq!(robot.wheels[0].rollers.len(), 8);
    // 0.2 kg of the hub and 0.1 kg of the rim; about the hub axis 0.2 * 0.03^2 / 2 + 2e-4.
    assert!((robot.wheels[0].hub.mass_kg - 0.3).abs() < 1e-15);
    assert!(
        (robot.wheels[0].hub.inertia_kg_m2[(2, 2)] - (0.2 * 0.03 * 0.03 / 2.0 + 2e-4)).abs()
            < 1e-16
    );
    // The rim turns all places by 0.3 rad: the roller that pointed down is there.
    let first = robot.wheels[0]
        .rollers
        .iter()
        .find(|r| r.name == "wheel_1_roller_1")
        .expect("there");
    assert!((first.place_rad() - 0.3).abs() < 1e-14);
}

#[test]
fn a_root_without_inertia_takes_that_of_what_is_fixed_to_it() {
    let footprint = r#"<link name="base_footprint"/><joint name="foot" type="fixed"><parent link="base_footprint"/>
        <child link="base_link"/><origin xyz="0 0 0.01"/></joint></robot>"#;
    let robot = load(&small().replace("</robot>", footprint));
    assert_eq!(robot.chassis.name, "base_footprint");
    assert!((robot.chassis.mass.mass_kg - 5.0).abs() < 1e-15);
    assert!((robot.chassis.mass.center_of_mass_m.z - 0.07).abs() < 1e-15);
    assert!((robot.ride_height_m() + 0.01).abs() < 1e-15);
}

/// A robot with a camera of a mass, with the given inertia text, on a joint.
fn with_camera(mass_kg: f64, inertia: &str, joint: &str) -> String {
    let camera = format!(
        r#"<link name="camera"><inertial><origin xyz="0 0 0"/><mass value="{mass_kg}"/>{inertia}</inertial></link>
        <joint name="mount" type="{joint}"><parent link="base_link"/><child link="camera"/><axis xyz="0 0 1"/>
        <origin xyz="0 0 0.1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#
    );
    small().replace("</robot>", &camera)
}

/// Reads a robot whose file has a fault.
fn try_load(text: &str) -> Result<Robot, ilon_formats::RobotError> {
    Robot::from_urdf_str(text, "camera.urdf")
}

#[test]
fn a_light_part_of_the_chassis_is_no_reason_to_refuse_a_robot_for_how_its_mass_is_spread() {
    // Products larger than the moments: the smallest principal moment is negative.
    let wrong = r#"<inertia ixx="2e-9" ixy="7e-9" ixz="0" iyy="2e-9" iyz="0" izz="2e-9"/>"#;
    let plain = load(&small()).chassis.mass;
    for (inertia, joint, at) in [
        (wrong, "fixed", "inertia"),
        (wrong, "revolute", "inertia"),
        ("", "fixed", "inertial"),
    ] {
        let robot = try_load(&with_camera(0.01, inertia, joint)).expect("it is taken");
        let subject = format!("link `camera`, `<{at}>`");
        assert!(remarked(&robot, &subject, "repaired: its inertia"));
        let mass = &robot.chassis.mass;
        assert!((mass.mass_kg - plain.mass_kg - 0.01).abs() < 1e-15);
        // About the common centre of mass the camera counts as a point, plus its largest own
        // inertia: that of a ball of 1500 kg/m^3.
        let reduced_kg = 0.01 * plain.mass_kg / (0.01 + plain.mass_kg);
        let apart_m = 0.1 - plain.center_of_mass_m.z;
        let by_place = plain.inertia_kg_m2[(0, 0)] + reduced_kg * apart_m * apart_m;
        let own = mass.inertia_kg_m2[(0, 0)] - by_place;
        let radius_m = (3.0 * 0.01 / (4.0 * PI * 1500.0_f64)).cbrt();
        let ball_kg_m2 = 0.4 * 0.01 * radius_m * radius_m;
        assert!((own - ball_kg_m2).abs() < 1e-15, "{own}");
    }
    // A heavy part, a part of a moving body, and a missing mass are refused as before.
    for text in [
        with_camera(1.0, wrong, "fixed"),
        with_camera(0.01, wrong, "continuous"),
        with_camera(0.01, wrong, "fixed").replacen(r#"<mass value="0.01"/>"#, "", 1),
    ] {
        let error = try_load(&text).expect_err("refused").to_string();
        assert!(error.contains("camera"), "{error}");
    }
}

#[test]
fn an_arm_is_held_at_zero_and_weighs_on_the_chassis() {
    let arm = r#"<link name="arm"><inertial><origin xyz="0 0 1"/><mass value="5"/>
        <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
        <joint name="shoulder" type="revolute"><parent link="base_link"/><child link="arm"/><axis xyz="0 1 0"/>
        <origin xyz="0 0 0.1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#;
    let robot = load(&small().replace("</robot>", arm));
    assert!((robot.chassis.mass.mass_kg - 10.0).abs() < 1e-15);
    // Half of the mass at 0.06 m, half at 1.1 m.
    assert!((robot.chassis.mass.center_of_mass_m.z - 0.58).abs() < 1e-15);
    // About x: the box 5 (0.3^2 + 0.1^2) / 12 and the arm 0.1, and both 0.52 m off the common
    // centre.
    let about_x = 5.0 * (0.3 * 0.3 + 0.1 * 0.1) / 12.0 + 0.1 + 10.0 * 0.52 * 0.52;
    assert!((robot.chassis.mass.inertia_kg_m2[(0, 0)] - about_x).abs() < 1e-13);
    assert!(remarked(&robot, "joint `shoulder`", "held at zero"));
}

#[test]
fn a_revolute_joint_of_many_turns_is_a_wheel() {
    let text = small().replace(
        "<joint name=\"wheel_1\" type=\"continuous\">",
        "<joint name=\"wheel_1\" type=\"revolute\">",
    );
    let text = text.replacen(
        r#"<limit effort="1" velocity="20"/>"#,
        r#"<limit effort="1" velocity="20" lower="-1e9" upper="1e9"/>"#,
        1,
    );
    assert_eq!(load(&text).wheels.len(), 3);
}

#[test]
fn an_axis_that_points_inward_keeps_the_sense_of_its_joint() {
    let outward = load(&small());
    let inward = load(&small().replace(r#"<axis xyz="0 1 0"/>"#, r#"<axis xyz="0 -1 0"/>"#));
    for (p, q) in outward.wheels.iter().zip(&inward.wheels) {
        assert!((p.axis() + q.axis()).norm() < 1e-15);
        assert!((p.position_m() - q.position_m()).norm() < 1e-15);
        // Handedness is a property of the wheel, not of the sign of its axis.
        assert!((p.gamma_rad - q.gamma_rad).abs() < 1e-14);
    }
    let inward = load(&mecanum().replace(r#"<axis xyz="0 1 0"/>"#, r#"<axis xyz="0 -1 0"/>"#));
    let gammas: Vec<f64> = inward
        .wheels
        .iter()
        .map(|w| w.gamma_rad / FRAC_PI_4)
        .collect();
    for (gamma, expected) in gammas.iter().zip([-1.0, 1.0, 1.0, -1.0]) {
        assert!((gamma - expected).abs() < 1e-13, "{gammas:?}");
    }
}

#[test]
fn settings_of_other_programs_are_remarked() {
    let text = small().replace(
        "</robot>",
        "<gazebo reference=\"base_link\"/><gazebo/><transmission name=\"${unexpanded}\"/></robot>",
    );
    let text = text.replacen("<axis", "<joint_properties damping=\"1\"/><axis", 1);
    let robot = load(&text);
    assert!(remarked(&robot, "`<gazebo>`", "2 in the file, not read"));
    assert!(remarked(
        &robot,
        "`<transmission>`",
        "1 in the file, of which only gear ratios are read"
    ));
    assert!(remarked(
        &robot,
        "`<joint_properties>`",
        "1 in the joints of the file, not read"
    ));
}

#[test]
fn a_chassis_below_the_floor_is_told() {
    // A box of 0.3 x 0.3 x 0.1 m, its centre 0.03 m high: 20 mm of it are below the floor.
    let spec = SPEC.replace("[0.0, 0.0, 0.06]", "[0.0, 0.0, 0.03]");
    let text = generate(&Spec::from_toml_str(&spec, "low.toml").expect("good")).expect("in range");
    let Fault::ChassisBelowFloor { deep_mm, .. } = fault_of(&text) else {
        panic!("another fault")
    };
    assert!((deep_mm - 20.0).abs() < 1e-9);
}

/// The box's lower side at a clearance. On the floor the chassis carries the robot in place of the
/// wheels, so that it does not move. From a thousandth of the radius above it, 0.05 mm, down to any
/// depth below it is refused, and the repair leaves it out.
#[test_case(-1e-3, "reaches 1.0 mm below"; "below it")]
#[test_case(-0.2e-3, "reaches 0.2 mm below"; "within what a file is rounded by")]
#[test_case(0.0, "it is 0.000 mm above"; "on it")]
#[test_case(0.02e-3, "it is 0.020 mm above"; "nearly")]
#[test_case(2e-3, ""; "above")]
fn a_chassis_that_touches_the_floor_at_rest_is_refused_and_repaired(clearance_m: f64, words: &str) {
    let height_m = 0.05 + clearance_m;
    let spec = SPEC.replace("[0.0, 0.0, 0.06]", &format!("[0.01, 0.02, {height_m}]"));
    let text = generate(&Spec::from_toml_str(&spec, "low.toml").expect("good")).expect("in range");
    let Err(error) = Robot::from_urdf_str(&text, "low.urdf") else {
        assert!(words.is_empty());
        return;
    };
    let said = error.to_string();
    assert!(
        !words.is_empty() && said.contains(words) && said.contains("x = 0.010 m, y = 0.020 m"),
        "{said}"
    );
    assert_eq!(error.remedies(), [ilon_formats::Remedy::Repair]);
    let options = common::options(|o| o.repair = true);
    let repaired = Robot::from_urdf_str_with(&text, "low.urdf", &options)
        .expect("repaired")
        .robot;
    assert!(repaired.chassis.collisions.is_empty());
}

/// A chain of links, as programs generate: twice as many links take about twice as long. With
/// quadratic time, when each joint was compared with all above it, this took a minute.
#[test]
fn a_long_chain_of_fixed_links_ends_soon() {
    const LINKS: usize = 60_000;
    let mut chain = String::new();
    let mut above = "base_link".to_owned();
    for k in 0..LINKS {
        chain += &format!(
            "<link name=\"c{k}\"/><joint name=\"cj{k}\" type=\"fixed\"><parent link=\"{above}\"/><child link=\"c{k}\"/></joint>"
        );
        above = format!("c{k}");
    }
    let text = small().replace("</robot>", &format!("{chain}</robot>"));
    let begun = std::time::Instant::now();
    let robot = Robot::from_urdf_str(&text, "chain.urdf").expect("it loads");
    assert_eq!(robot.wheels.len(), 3);
    let took = begun.elapsed().as_secs_f64();
    println!("{LINKS} links in {took:.2} s");
    assert!(took < 20.0, "{took} s");
}

/// Very many shapes of one link below the floor are found and left out in some times as long as it
/// takes to read as many above it. When each was looked for from the first one on, the times for
/// 40,000 differed by more than a factor of ten.
#[test]
fn very_many_shapes_below_the_floor_are_refused_soon() {
    const SHAPES: usize = 40_000;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("shapes.urdf");
    let seconds = |z_m: f64, proposed: bool| {
        let shape = format!(
            "<collision><origin xyz=\"0 0 {z_m}\"/><geometry><box size=\"0.1 0.1 0.01\"/></geometry></collision>"
        );
        let shapes = shape.repeat(SHAPES) + "</link>";
        let text = small().replacen("</link>", &shapes, 1);
        std::fs::write(&path, text).expect("a file");
        let begun = std::time::Instant::now();
        let diagnosis = Robot::diagnose(&path, &LoadOptions::default(), |_| true);
        assert_eq!(diagnosis.proposal.is_some_and(|of| of.repair), proposed);
        begun.elapsed().as_secs_f64()
    };
    let (above_s, below_s) = (seconds(0.3, false), seconds(-5.0, true));
    println!("{SHAPES} shapes in {above_s:.2} and {below_s:.2} s");
    assert!(below_s < 8.0 * above_s, "{below_s} {above_s}");
}

/// 64 MB may hold three million links, with which each stage takes minutes: they are refused
/// before.
#[test_case("<link name=\"l{}\"/>", 1; "links alone")]
#[test_case("<joint name=\"j{}\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>", 3; "joints alone")]
fn more_links_and_joints_than_are_read_in_seconds_are_refused(part: &str, elements: usize) {
    let parts = (0..500_000 / elements).map(|k| part.replace("{}", &k.to_string()));
    let text = small().replace(
        "</robot>",
        &format!("{}</robot>", parts.collect::<String>()),
    );
    let begun = std::time::Instant::now();
    let error = Robot::from_urdf_str(&text, "many.urdf").unwrap_err();
    assert!(matches!(error.fault(), Fault::TooLarge { .. }), "{error}");
    let took = begun.elapsed().as_secs_f64();
    println!("{} bytes in {took:.2} s", text.len());
    assert!(took < 20.0, "{took} s");
}

/// The line of each fault is found without counting all lines above it: that took minutes here.
#[test]
fn tens_of_thousands_of_faults_end_soon() {
    let mass = "<inertial><mass value=\"1\"/></inertial>";
    let links = format!("<link name=\"twice\">{mass}</link>\n").repeat(40_000);
    let text = format!("<robot name=\"r\">{links}</robot>");
    let begun = std::time::Instant::now();
    let error = Robot::from_urdf_str(&text, "many.urdf").unwrap_err();
    assert_eq!((error.line(), error.others().len()), (Some(2), 49));
    let took = begun.elapsed().as_secs_f64();
    println!("{} bytes in {took:.2} s", text.len());
    assert!(took < 20.0, "{took} s");
}

/// A body of 50 characters of MJCF is 600 of URDF, so that a megabyte took 11 s of a release build.
/// A scene of a thousand bodies is read.
#[test_case("<body name=\"x{}\"><geom type=\"sphere\" size=\".01\"/></body>"; "bodies")]
#[test_case("<geom type=\"sphere\" size=\".01\"/>"; "geoms")]
#[test_case("<geom type=\"capsule\" size=\".01\" fromto=\"0 0 0 0 0 1\"/>"; "capsules")]
#[test_case("<body><joint name=\"q{}\" type=\"slide\" axis=\"0 0 1\"/><geom size=\".01\"/></body>"; "joints")]
fn a_megabyte_of_mjcf_is_too_much_and_a_thousand_parts_are_not(part: &str) {
    let refused = |count: usize| {
        let parts = (0..count).map(|k| part.replace("{}", &k.to_string()));
        let parts: String = parts.collect();
        let text = format!(
            "<mujoco><worldbody><body name=\"b\"><freejoint/><geom type=\"box\" size=\".2 .2 .02\" mass=\"5\"/>{parts}</body></worldbody></mujoco>"
        );
        let error = Robot::from_urdf_str(&text, "many.xml").expect_err("no wheels");
        matches!(error.fault(), Fault::TooLarge { .. })
    };
    assert!(refused((1 << 20) / part.len()));
    assert!(!refused(1000));
}

#[test]
fn a_declaration_that_comes_late_is_told_how_to_mend() {
    let error = Robot::from_urdf_str(
        "\n<!-- by me -->\n<?xml version=\"1.0\"?>\n<robot name=\"a\"/>",
        "late.urdf",
    )
    .unwrap_err();
    let help = error.help();
    assert!(help.contains("stands at the very beginning"), "{help}");
}

#[test]
fn steered_wheels_are_told_apart_from_swedish_ones() {
    let mut text = String::from("<robot name=\"r\"><link name=\"base\"/>");
    for i in 0..4 {
        let inertial = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>";
        text += &format!(
            "<link name=\"fork{i}\">{inertial}</link><link name=\"wheel{i}\">{inertial}</link>\
             <joint name=\"steer{i}\" type=\"continuous\"><parent link=\"base\"/><child link=\"fork{i}\"/><axis xyz=\"0 0 1\"/></joint>\
             <joint name=\"roll{i}\" type=\"continuous\"><parent link=\"fork{i}\"/><child link=\"wheel{i}\"/><axis xyz=\"0 1 0\"/></joint>"
        );
    }
    text += "</robot>";
    let names = ["roll0", "roll1", "roll2", "roll3"].map(str::to_owned);
    let Fault::Steered { wheels, .. } = fault_of(&text) else {
        panic!("another fault")
    };
    assert_eq!(wheels, names);
}

/// Descriptions and options take degrees: 0.7854 is remarked as no mecanum wheel's, 0 and 45 are
/// not.
#[test_case("0.7854", Some("an angle of 45 deg given in radians"))]
#[test_case("45.0", None)]
#[test_case("0.05", None)]
fn an_angle_gamma_in_radians_is_remarked(gamma_deg: &str, said: Option<&str>) {
    let spec = SPEC
        .split("[wheels.ring]")
        .next()
        .expect("a description")
        .to_owned()
        + &format!("[wheels.ring]\ncount = 3\ndistance_m = 0.3\ngamma_deg = {gamma_deg}\n");
    let urdf = generate(&Spec::from_toml_str(&spec, "r.toml").expect("good")).expect("in range");
    let remarks = load(&urdf).remarks;
    let odd = remarks
        .iter()
        .find(|remark| remark.text.contains("radians"));
    match said {
        Some(said) => assert!(
            odd.is_some_and(|remark| remark.text.contains(said)),
            "{remarks:?}"
        ),
        None => assert!(odd.is_none(), "{odd:?}"),
    }
}

/// Hub axes point outward on a ring, so that a wheel extends by its radius to both sides of its
/// place: neighbours of five meet within rho / tan(36 deg) of the middle, plus half of their width.
#[test_case(0.5, true)]
#[test_case(3.0, false)]
fn wheels_that_pass_through_each_other_are_remarked(radii: f64, meet: bool) {
    let base = Spec::from_toml_str(SPEC, "r.toml").expect("good");
    let distance_m = radii * base.wheel.radius_m;
    let spec = SPEC
        .split("[wheels.ring]")
        .next()
        .expect("a description")
        .to_owned()
        + &format!("[wheels.ring]\ncount = 5\ndistance_m = {distance_m}\ngamma_deg = 0\n");
    let urdf = generate(&Spec::from_toml_str(&spec, "r.toml").expect("good")).expect("in range");
    let found = load(&urdf)
        .remarks
        .iter()
        .any(|r| r.text.contains("reaches into"));
    assert_eq!(found, meet);
}
