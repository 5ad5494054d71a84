//! Robots as people write them, one trait a test: each is a good robot written in another way.

mod common;

use std::f64::consts::{FRAC_PI_4, PI};
use std::path::{Path, PathBuf};

use common::{SPEC, line_of, options, small};
use ilon_robot::{
    Fault, Handedness, LoadOptions, Package, Remedy, Robot, RollerForm, RollerForms, Spec,
    WheelOptions, generate,
};
use nalgebra::Vector3;
use test_case::test_case;

fn load(text: &str) -> Robot {
    Robot::from_urdf_str(text, "small.urdf").unwrap_or_else(|e| panic!("{e}"))
}

fn fault_of(text: &str) -> Fault {
    match Robot::from_urdf_str(text, "small.urdf") {
        Ok(_) => panic!("it loaded"),
        Err(error) => error.fault().clone(),
    }
}

/// The mecanum robot of 45 degrees with the body of the small one.
fn mecanum() -> String {
    let spec = SPEC
        .split("[wheels.ring]")
        .next()
        .expect("a description")
        .to_owned()
        + "[wheels.mecanum]\naxles_m = [0.2, -0.2]\nhalf_width_m = 0.25\ngamma_deg = 45.0\n";
    generate(&Spec::from_toml_str(&spec, "mecanum.toml").expect("a good description"))
        .expect("in range")
}

/// The same text with every collision of a roller replaced by one.
fn with_roller_collision(text: &str, collision: &str) -> String {
    let mut out = String::new();
    let mut in_roller = false;
    for line in text.lines() {
        if line.contains("<link name=") {
            in_roller = line.contains("_roller_");
            out.push_str(line);
            out.push('\n');
            if in_roller {
                out.push_str(collision);
                out.push('\n');
            }
        } else if !(in_roller && line.contains("<collision>")) {
            out.push_str(line);
            out.push('\n');
        }
    }
    out
}

fn remarked(robot: &Robot, subject: &str, text: &str) -> bool {
    robot
        .remarks
        .iter()
        .any(|r| r.subject == subject && r.text.contains(text))
}

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
    // The rim hangs by a fixed joint below the hub, turned about the hub axis, and the first wheel's rollers by the rim.
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
    // The rim turns all places by 0.3 rad: the roller that pointed down stands there.
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

/// A robot that carries a camera of a mass, with an inertia as it is written, on a joint.
fn with_camera(mass_kg: f64, inertia: &str, joint: &str) -> String {
    let camera = format!(
        r#"<link name="camera"><inertial><origin xyz="0 0 0"/><mass value="{mass_kg}"/>{inertia}</inertial></link>
        <joint name="mount" type="{joint}"><parent link="base_link"/><child link="camera"/><axis xyz="0 0 1"/>
        <origin xyz="0 0 0.1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#
    );
    small().replace("</robot>", &camera)
}

/// Reads a robot whose file has a fault.
fn try_load(text: &str) -> Result<Robot, ilon_robot::RobotError> {
    Robot::from_urdf_str(text, "camera.urdf")
}

#[test]
fn a_light_part_of_the_chassis_is_no_reason_to_refuse_a_robot_for_how_its_mass_is_spread() {
    // Products that are larger than the moments: the least principal moment is below 0.
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
        // About the common centre of mass the camera counts by its place alone, but for what it could have of its own: as a ball of
        // 1500 kg/m^3.
        let reduced_kg = 0.01 * plain.mass_kg / (0.01 + plain.mass_kg);
        let apart_m = 0.1 - plain.center_of_mass_m.z;
        let by_place = plain.inertia_kg_m2[(0, 0)] + reduced_kg * apart_m * apart_m;
        let own = mass.inertia_kg_m2[(0, 0)] - by_place;
        let radius_m = (3.0 * 0.01 / (4.0 * PI * 1500.0_f64)).cbrt();
        let ball_kg_m2 = 0.4 * 0.01 * radius_m * radius_m;
        assert!((own - ball_kg_m2).abs() < 1e-15, "{own}");
    }
    // A heavy part, a part of something that turns, and a mass that is missing are refused as before.
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
    // About x: the box 5 (0.3^2 + 0.1^2) / 12 and the arm 0.1, and both 0.52 m off the common centre.
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
        // Handedness is of the wheel, not of the sense in which its axis is written.
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
        "1 in the file: the ratios of gears are read"
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
    let Fault::ChassisBelowFloor { deep_mm } = fault_of(&text) else {
        panic!("another fault")
    };
    assert!((deep_mm - 20.0).abs() < 1e-9);
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

// --- Rollers of other shapes. The small robot: rho 50 mm, r 12 mm, a 38 mm, eight rollers, gamma 0.

#[test]
fn a_lone_sphere_is_a_barrel_that_reaches_its_neighbours() {
    let robot = load(&with_roller_collision(
        &small(),
        r#"<collision><geometry><sphere radius="0.012"/></geometry></collision>"#,
    ));
    for roller in &robot.wheels[0].rollers {
        assert!((roller.radius_m - 0.012).abs() < 1e-15);
        // L = 2 a tan(pi / 8).
        assert!((roller.length_m - 2.0 * 0.038 * (PI / 8.0).tan()).abs() < 1e-14);
    }
    // Between two spheres the hub sinks to a cos(pi/8) + r: by 38 (1 - cos(pi/8)) = 2.89 mm.
    assert!(remarked(&robot, "wheel `wheel_1`", "dip 2.89 mm"));
}

#[test]
fn a_capsule_spans_the_centres_of_its_ends() {
    let robot = load(&with_roller_collision(
        &small(),
        r#"<collision><geometry><capsule radius="0.012" length="0.032"/></geometry></collision>"#,
    ));
    assert!((robot.wheels[0].radius_m - 0.05).abs() < 1e-15);
    for roller in &robot.wheels[0].rollers {
        assert!((roller.length_m - 0.032).abs() < 1e-15);
    }
}

#[test]
fn taken_as_modelled_rollers_keep_the_shapes_of_their_file_gaps_and_all() {
    // Short cylinders with gaps between them, and a ball off the middle of each: as barrels they would be refused.
    let text = with_roller_collision(
        &small(),
        r#"<collision><geometry><cylinder radius="0.012" length="0.01"/></geometry></collision>
        <collision><origin xyz="0 0 0.004"/><geometry><sphere radius="0.01"/></geometry></collision>"#,
    );
    assert!(matches!(fault_of(&text), Fault::RollersHaveGaps { .. }));
    let options = options(|o| {
        o.rollers = RollerForms::AsModelled;
    });
    let loaded = Robot::from_urdf_str_with(&text, "short.urdf", &options).expect("as it is");
    assert!(loaded.outlines[0].gap_share > 0.1);
    let wheel = &loaded.robot.wheels[0];
    for roller in &wheel.rollers {
        let RollerForm::AsModelled(modelled) = &roller.form else {
            panic!("{:?}", roller.form);
        };
        // Along its axis, either way: the cylinder to 5 mm, the ball to 14 mm on its side.
        let reach = |z: f64| {
            let reaches = modelled
                .shapes
                .iter()
                .map(|s| s.reach_m(&Vector3::new(0.0, 0.0, z)));
            reaches.fold(f64::NEG_INFINITY, f64::max)
        };
        let mut ends = [reach(1.0), reach(-1.0)];
        ends.sort_by(f64::total_cmp);
        // The file's turns are written with ten digits or so.
        assert!(
            (ends[0] - 0.006).abs() < 1e-8 && (ends[1] - 0.014).abs() < 1e-8,
            "{ends:?}"
        );
        // The profile tells the same.
        assert!((modelled.profile.support_m(1.0) - reach(1.0)).abs() < 1e-8);
        assert!((modelled.profile.support_m(-1.0) - reach(-1.0)).abs() < 1e-8);
        // Across the axis it is as thick as the cylinder.
        assert!((modelled.profile.support_m(0.0) - 0.012).abs() < 1e-15);
    }
    // A roller points straight down: the wheel stands on its cylinder.
    assert!(
        (wheel.reach_at_rest_m() - 0.05).abs() < 1e-6,
        "{}",
        wheel.reach_at_rest_m()
    );
}

#[test_case(r#"<cylinder radius="0.012" length="0.0383"/>"#; "cylinder")]
#[test_case(r#"<box size="0.024 0.024 0.0383"/>"#; "square box")]
fn a_roller_that_is_cut_flat_ends_where_its_last_sphere_touches(geometry: &str) {
    let robot = load(&with_roller_collision(
        &small(),
        &format!("<collision><geometry>{geometry}</geometry></collision>"),
    ));
    assert!((robot.wheels[0].radius_m - 0.05).abs() < 1e-15);
    for roller in &robot.wheels[0].rollers {
        // With gamma = 0 the sphere at t = a tan(phi) touches at t + s sin(phi) = rho sin(phi): the cut at 19.15 mm is
        // touched at phi = asin(19.15 / 50).
        let phi = (0.01915f64 / 0.05).asin();
        assert!((roller.length_m - 2.0 * 0.038 * phi.tan()).abs() < 1e-12);
    }
}

#[test]
fn a_cylinder_across_its_axis_is_no_roller() {
    let text = with_roller_collision(
        &small(),
        r#"<collision><origin rpy="1.57 0 0"/><geometry><cylinder radius="0.012" length="0.04"/></geometry></collision>"#,
    );
    assert_eq!(fault_of(&text), Fault::RollerNotRound);
}

#[test]
fn a_stack_of_cylinders_is_fitted_as_the_barrel_that_it_stands_for() {
    // The surface of the barrel in 41 discs of 1 mm (see `barrel_rings_mm` for its shape).
    let discs: String = (-20..=20)
        .map(|i| {
            let z: f64 = 0.019 * f64::from(i) / 20.0;
            let r = (0.05f64.powi(2) - z * z).sqrt() - 0.038;
            format!(
                "<collision><origin xyz=\"0 0 {z}\"/><geometry><cylinder radius=\"{r}\" length=\"1e-4\"/></geometry></collision>"
            )
        })
        .collect();
    let robot = load(&with_roller_collision(&small(), &discs));
    // A disc of half-width 50 um leans over by that times the slope of the surface, 0.4 at most, and the chords between
    // discs fall short by 1.3 um.
    assert!(
        (robot.wheels[0].radius_m - 0.05).abs() < 2e-5,
        "{}",
        robot.wheels[0].radius_m
    );
}

#[test]
fn rollers_of_the_common_length_overlap_by_what_geometry_says() {
    // Nine rollers at 45 deg, rho 50 mm, a 38 mm. The common L = 2 rho sin(pi/n) / sin(delta) reaches
    // atan(L/2 sin(delta) / a) = atan(50 sin(20 deg) / 38) = 24.23 deg to each side of pitches of 40 deg: 8.46 deg of
    // each, 76.1 deg of a turn.
    let spec = SPEC
        .split("[wheels.ring]")
        .next()
        .expect("a description")
        .replace("per_row = 8", "per_row = 9")
        + "[wheels.mecanum]\naxles_m = [0.2, -0.2]\nhalf_width_m = 0.25\ngamma_deg = 45.0\n";
    let text =
        generate(&Spec::from_toml_str(&spec, "mecanum.toml").expect("good")).expect("in range");
    let length_m = 2.0 * 0.05 * (PI / 9.0).sin() / FRAC_PI_4.sin();
    let capsule = format!(
        "<collision><geometry><capsule radius=\"0.012\" length=\"{length_m}\"/></geometry></collision>"
    );
    let loaded = Robot::from_urdf_str_with(
        &with_roller_collision(&text, &capsule),
        "m.urdf",
        &LoadOptions::default(),
    )
    .unwrap_or_else(|e| panic!("{e}"));
    assert!(remarked(
        &loaded.robot,
        "wheel `rear_left`",
        "over 76.1 deg of each turn (21.1 %) two rollers touch"
    ));
    assert!((loaded.outlines[0].overlap_share - 76.1 / 360.0).abs() < 1e-3);
    // A capsule sticks out where the barrel tapers: the centre of its end is hypot(a, L/2 cos(45 deg)) from the hub axis.
    // Samples a tenth of a degree apart miss the peak by 54 mm (0.05 deg)^2 / 2 = 2e-8 m at most.
    let peak_m = 0.038f64.hypot(0.5 * length_m * FRAC_PI_4.cos()) + 0.012;
    assert!((loaded.outlines[0].peak_radius_m - peak_m).abs() < 3e-8);
    assert!(remarked(
        &loaded.robot,
        "wheel `rear_left`",
        "rolls on a radius of 53.25 mm"
    ));
}

// --- Meshes.

/// A folder of its own for each test, below the build's.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder to write to");
    folder
}

/// Vertices of the barrel of the small robot in millimetres, turned about z: rings of 24 points at 41 places. The surface
/// that touches the ground at wheel angle phi is at rho sin(phi) along the axis, rho cos(phi) - a from it.
fn barrel_rings_mm() -> Vec<Vec<[f64; 3]>> {
    (-20..=20)
        .map(|i| {
            let phi = PI / 8.0 * f64::from(i) / 20.0;
            let (z, r) = (50.0 * phi.sin(), 50.0 * phi.cos() - 38.0);
            (0..24)
                .map(|j| {
                    let (s, c) = (2.0 * PI * f64::from(j) / 24.0).sin_cos();
                    [r * c, r * s, z]
                })
                .collect()
        })
        .collect()
}

fn triangles(rings: &[Vec<[f64; 3]>]) -> Vec<[[f64; 3]; 3]> {
    let mut all = Vec::new();
    for pair in rings.windows(2) {
        for j in 0..24 {
            let next = (j + 1) % 24;
            all.push([pair[0][j], pair[0][next], pair[1][j]]);
            all.push([pair[0][next], pair[1][next], pair[1][j]]);
        }
    }
    all
}

fn binary_stl(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![0u8; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0u8; 12]);
        for x in triangle.iter().flatten() {
            bytes.extend((*x as f32).to_le_bytes());
        }
        bytes.extend([0u8; 2]);
    }
    bytes
}

fn text_stl(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut text = String::from("solid roller\n");
    for triangle in triangles {
        text += "facet normal 0 0 1\nouter loop\n";
        for [x, y, z] in triangle {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid roller\n").into_bytes()
}

fn obj(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut text = String::new();
    for [x, y, z] in triangles.iter().flatten() {
        text += &format!("v {x} {y} {z}\n");
    }
    for i in 0..triangles.len() {
        text += &format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
    }
    text.into_bytes()
}

/// In inches, shifted and turned a quarter about x, which the scene takes back.
fn dae(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let inch = 25.4;
    let mut numbers = String::new();
    for [x, y, z] in triangles.iter().flatten() {
        // Turned by +90 deg about x, (x, y, z) is (x, -z, y); then shifted by one along x.
        numbers += &format!("{} {} {} ", x / inch + 1.0, -z / inch, y / inch);
    }
    // Of a unit of 25.4 the URDF's scale makes millimetres.
    format!(
        r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
        <asset><unit name="inch" meter="{inch}"/><up_axis>Y_UP</up_axis></asset>
        <library_geometries><geometry id="g"><mesh>
        <source id="p"><float_array id="a" count="0">{numbers}</float_array></source>
        <vertices id="v"><input semantic="POSITION" source="#p"/></vertices></mesh></geometry></library_geometries>
        <library_visual_scenes><visual_scene id="s"><node><rotate>1 0 0 -90</rotate>
        <node><matrix>1 0 0 -1 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#g"/></node></node>
        </visual_scene></library_visual_scenes></COLLADA>"##
    )
    .into_bytes()
}

fn with_mesh(mesh: &str) -> String {
    with_roller_collision(
        &small(),
        &format!(
            "<collision><geometry><mesh filename=\"{mesh}\" scale=\"0.001 0.001 0.001\"/></geometry></collision>"
        ),
    )
}

#[test_case("roller.stl", binary_stl; "binary stl")]
#[test_case("roller_text.STL", text_stl; "text stl")]
#[test_case("roller.obj", obj; "obj")]
#[test_case("roller.dae", dae; "dae")]
fn the_barrel_of_a_mesh_is_fitted(file: &str, write: fn(&[[[f64; 3]; 3]]) -> Vec<u8>) {
    let folder = folder("meshes");
    std::fs::write(folder.join(file), write(&triangles(&barrel_rings_mm()))).expect("writable");
    std::fs::write(folder.join(format!("{file}.urdf")), with_mesh(file)).expect("writable");
    let loaded = Robot::load_with(folder.join(format!("{file}.urdf")), &LoadOptions::default())
        .unwrap_or_else(|e| panic!("{e}"));
    let wheel = &loaded.robot.wheels[0];
    // Between rings 22.5 / 20 deg apart the hull's chord lies rho (1 - cos(0.56 deg)) = 2.4 um below the circle, and its
    // mean two thirds of that.
    assert!((wheel.radius_m - 0.05).abs() < 3e-6, "{}", wheel.radius_m);
    for roller in &wheel.rollers {
        assert!((roller.radius_m - 0.012).abs() < 3e-6);
        // The last ring is where neighbours hand over; 3 um of rho move the end by rho tan / a of that at most.
        assert!(
            (roller.length_m - 2.0 * 0.038 * (PI / 8.0).tan()).abs() < 2e-5,
            "{}",
            roller.length_m
        );
    }
    assert!(
        loaded.outlines[0].ripple_m < 5e-6,
        "{:?}",
        loaded.outlines[0]
    );
}

/// The small robot as xacro: its first wheel's place is computed, its links of rollers come from a macro of another file.
fn as_xacro(include: &str) -> (String, String) {
    let text = small()
        .replacen(
            "<robot name",
            "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" name",
            1,
        )
        .replacen(
            "xyz=\"0.2 0 0.05\"",
            "xyz=\"${arm + 0.1} 0 ${2 * half_m}\"",
            1,
        );
    assert!(
        text.contains("${arm"),
        "the first wheel stands at 0.2 0 0.05"
    );
    let start = text
        .find("<link name=\"wheel_1_roller_1_link\">")
        .expect("a roller");
    let end = start + text[start..].find("</link>").expect("its end") + "</link>".len();
    let link = text[start..end].replace("wheel_1_roller_1_link", "${name}_link");
    let library = format!(
        "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n<xacro:property name=\"half_m\" value=\"0.025\"/>\n\
         <xacro:macro name=\"roller\" params=\"name\">{link}</xacro:macro>\n</robot>"
    );
    let main = format!(
        "{}<xacro:roller name=\"wheel_1_roller_1\"/>{}",
        &text[..start],
        &text[end..]
    );
    let first_link = main.find("<link").expect("a link");
    let main = format!(
        "{}<xacro:include filename=\"{include}\"/>\n<xacro:arg name=\"arm\" default=\"0.1\"/>\n\
         <xacro:property name=\"arm\" value=\"$(arg arm)\"/>\n{}",
        &main[..first_link],
        &main[first_link..]
    );
    (main, library)
}

#[test]
fn xacro_is_expanded_without_ros() {
    let folder = folder("xacro");
    let (main, library) = as_xacro("$(find parts)/urdf/roller.xacro");
    std::fs::create_dir_all(folder.join("elsewhere/urdf")).expect("a folder");
    std::fs::write(folder.join("elsewhere/urdf/roller.xacro"), library).expect("written");
    let file = folder.join("robot.urdf.xacro");
    std::fs::write(&file, main).expect("written");

    // A package of another name than its folder has to be told.
    let error = Robot::load(&file).expect_err("no such package");
    let package = "parts".to_owned();
    let Fault::MissingFiles { files } = error.fault() else {
        panic!("{error}")
    };
    assert_eq!(files[0].package, Some(package.clone()));
    assert_eq!(error.remedies()[0], Remedy::Package { name: package });

    let options = options(|o| {
        o.packages = vec![Package {
            name: "parts".to_owned(),
            folder: folder.join("elsewhere"),
        }];
    });
    let robot = Robot::load_with(&file, &options).expect("expanded").robot;
    assert!(remarked(&robot, "xacro", "expanded with arm = 0.1"));
    let plain = load(&small());
    assert_eq!(robot.wheels.len(), plain.wheels.len());
    for (p, q) in robot.wheels.iter().zip(&plain.wheels) {
        // Sums of a few decimal numbers.
        assert!((p.position_m() - q.position_m()).norm() < 1e-15);
        assert_eq!(p.rollers.len(), q.rollers.len());
        assert!((p.radius_m - q.radius_m).abs() < 1e-12);
    }
}

#[test]
fn packages_are_found_by_option_and_beside_the_file() {
    let folder = folder("packages");
    let package = folder.join("my_robot");
    std::fs::create_dir_all(package.join("meshes")).expect("writable");
    std::fs::create_dir_all(package.join("urdf")).expect("writable");
    let stl = binary_stl(&triangles(&barrel_rings_mm()));
    std::fs::write(package.join("meshes/roller.stl"), stl).expect("writable");
    let inside = package.join("urdf/robot.urdf");
    std::fs::write(&inside, with_mesh("package://my_robot/meshes/roller.stl")).expect("writable");
    assert!(
        Robot::load(&inside).is_ok(),
        "a package around the file is found"
    );

    let text = with_mesh("package://elsewhere/meshes/roller.stl");
    let options = options(|o| {
        o.packages = vec![Package {
            name: "elsewhere".to_owned(),
            folder: package,
        }];
    });
    assert!(Robot::from_urdf_str_with(&text, "robot.urdf", &options).is_ok());
    let error = Robot::from_urdf_str(&text, "robot.urdf").expect_err("not known");
    let name = "elsewhere".to_owned();
    assert_eq!(error.remedies()[0], Remedy::Package { name });
}

#[test_case("none.stl", None, "there is no such file"; "missing")]
#[test_case("cut.stl", Some(&binary_stl(&triangles(&barrel_rings_mm()))[..1000]), "it is cut short: fewer triangles than it says"; "cut short")]
#[test_case("roller.step", Some(&b"ISO-10303-21;"[..]), "meshes of the kind `.step` are not read, but `.stl`, `.obj` and `.dae` are"; "other kind")]
#[test_case("empty.obj", Some(&b""[..]), "it holds no vertices"; "empty")]
fn a_mesh_that_cannot_be_read_is_told(file: &str, bytes: Option<&[u8]>, expected: &str) {
    let folder = folder("bad_meshes");
    if let Some(bytes) = bytes {
        std::fs::write(folder.join(file), bytes).expect("writable");
    }
    let urdf = folder.join("robot.urdf");
    let error = Robot::from_urdf_str(&with_mesh(file), &urdf.display().to_string())
        .expect_err("unreadable");
    let Fault::WheelSizeUnknown {
        reason: Some(reason),
        ..
    } = error.fault()
    else {
        panic!("{error}")
    };
    assert!(reason.ends_with(expected), "{reason}");
    assert!(error.line().is_some());
}

// --- Wheels without rollers.

/// The mecanum robot with plain cylinders for wheels.
fn plain_wheels() -> String {
    let mut out = String::new();
    let mut skipping = false;
    for line in mecanum().lines() {
        let opens = line.starts_with("  <joint") || line.starts_with("  <link");
        if opens {
            skipping = line.contains("_roller_");
        }
        if !skipping || line.starts_with("</robot>") {
            out.push_str(&line.replace(r#"<cylinder radius="0.03""#, r#"<cylinder radius="0.05""#));
            out.push('\n');
        }
    }
    out
}

fn rollers() -> WheelOptions {
    let mut rollers = WheelOptions::new(9, Handedness::XDeg(45.0));
    rollers.roller_radius_m = Some(0.012);
    rollers.roller_mass_kg = Some(0.01);
    rollers.damping_n_m_s = 1e-6;
    rollers
}

#[test]
fn wheels_without_rollers_are_told_by_name() {
    let Fault::NoRollers { wheels, .. } = fault_of(&plain_wheels()) else {
        panic!("another fault")
    };
    assert_eq!(
        wheels,
        ["front_left", "front_right", "rear_left", "rear_right"]
    );
}

#[test]
fn rollers_put_into_bare_wheels_make_the_robot_that_has_them() {
    let options = options(|o| {
        o.wheels = Some(rollers());
    });
    let given = Robot::from_urdf_str_with(&plain_wheels(), "plain.urdf", &options)
        .unwrap_or_else(|e| panic!("{e}"))
        .robot;
    // The same robot described with nine rollers.
    let spec = SPEC
        .split("[wheels.ring]")
        .next()
        .expect("a description")
        .replace("per_row = 8", "per_row = 9")
        + "[wheels.mecanum]\naxles_m = [0.2, -0.2]\nhalf_width_m = 0.25\ngamma_deg = 45.0\n";
    let spec = Spec::from_toml_str(&spec, "mecanum.toml").expect("a good description");
    let described = load(&generate(&spec).expect("in range"));
    for (p, q) in given.wheels.iter().zip(&described.wheels) {
        assert_eq!(p.name, q.name);
        assert!((p.gamma_rad - q.gamma_rad).abs() < 1e-13);
        assert!((p.radius_m - q.radius_m).abs() < 1e-15);
        // The rollers' mass is taken from the wheel's: 0.2 kg less 9 * 0.01 kg.
        assert!((p.hub.mass_kg - 0.11).abs() < 1e-15);
        assert_eq!(p.rollers.len(), q.rollers.len());
        for a in &p.rollers {
            let b = q
                .rollers
                .iter()
                .find(|b| b.name == a.name)
                .expect("the same names");
            assert!((a.length_m - b.length_m).abs() < 1e-13);
            assert!((a.axial_inertia_kg_m2 - b.axial_inertia_kg_m2).abs() < 1e-17);
            assert!((a.center_in_hub_m - b.center_in_hub_m).norm() < 1e-14);
            assert!((a.axis_in_hub.into_inner() - b.axis_in_hub.into_inner()).norm() < 1e-13);
        }
    }
}

#[test]
fn a_heavy_wheel_keeps_its_mass_and_inertia_when_rollers_are_put_in() {
    let text = plain_wheels().replace(
        r#"ixx="7.16666666666667e-5" ixy="0" ixz="0" iyy="7.16666666666667e-5" iyz="0" izz="9e-5""#,
        r#"ixx="4e-4" ixy="0" ixz="0" iyy="4e-4" iyz="0" izz="6e-4""#,
    );
    assert!(text.contains("6e-4"), "the inertia that is replaced");
    let options = options(|o| {
        o.wheels = Some(rollers());
    });
    let robot = Robot::from_urdf_str_with(&text, "plain.urdf", &options)
        .unwrap_or_else(|e| panic!("{e}"))
        .robot;
    for wheel in &robot.wheels {
        let rollers_kg: f64 = wheel.rollers.iter().map(|r| r.mass_kg).sum();
        assert!((wheel.hub.mass_kg + rollers_kg - 0.2).abs() < 1e-15);
        // About the hub axis a roller adds m a^2, and of its own inertia J cos^2 + K sin^2 with the angle of 45 deg.
        let of_rollers: f64 = wheel
            .rollers
            .iter()
            .map(|r| {
                r.mass_kg * 0.038 * 0.038
                    + 0.5 * (r.axial_inertia_kg_m2 + r.transverse_inertia_kg_m2)
            })
            .sum();
        assert!((wheel.hub.inertia_kg_m2[(2, 2)] + of_rollers - 6e-4).abs() < 1e-15);
    }
}

#[test_case(|o: &mut WheelOptions| o.joints = vec!["none".to_owned()], "there is no joint `none`; wheels could be `front_left`, `front_right`, `rear_left`, `rear_right`"; "unknown joint")]
#[test_case(|o: &mut WheelOptions| o.rollers = 2, "`rollers` is 2, but must be from 3 to 1000"; "too few")]
#[test_case(|o: &mut WheelOptions| o.gamma = Handedness::AllDeg(90.0), "`gamma` is 90, but must be from -85 to 85 degrees"; "right angle")]
#[test_case(|o: &mut WheelOptions| o.gamma = Handedness::EachDeg(vec![0.0]), "`gamma.each_deg` is 1 numbers, but must be as long as the list of wheels"; "short list")]
#[test_case(|o: &mut WheelOptions| o.roller_mass_kg = Some(0.1), "`roller_mass_kg` is 0.1, but must be so light that all rollers weigh less than the wheel"; "heavy")]
#[test_case(|o: &mut WheelOptions| o.roller_radius_m = Some(0.001), "rollers of 1.00 mm radius taper to nothing before they reach their neighbours"; "slender")]
fn rollers_that_do_not_fit_are_refused(change: fn(&mut WheelOptions), expected: &str) {
    let mut wheels = rollers();
    change(&mut wheels);
    let options = options(|o| {
        o.wheels = Some(wheels);
    });
    let error = Robot::from_urdf_str_with(&plain_wheels(), "plain.urdf", &options)
        .expect_err("it does not fit");
    assert_eq!(error.fault().to_string(), expected);
}

// --- Repairs.

#[test]
fn a_repair_says_what_it_changed_and_keeps_the_lines() {
    // No inertia for the chassis, a second limit, and outermost spheres that are left out.
    let text = small().replacen(
        r#"<limit effort="1" velocity="20"/>"#,
        "<limit effort=\"1\" velocity=\"20\"/><limit effort=\"9\"\n velocity=\"9\"/>",
        1,
    );
    let from = text.find("<inertia ").expect("an inertia");
    let to = from + text[from..].find("/>").expect("its end") + 2;
    let text = format!("{}{}", &text[..from], &text[to..]);
    let text: String = text
        .lines()
        .filter(|l| !(l.contains("<collision>") && l.contains("0.0157401153")))
        .flat_map(|l| [l, "\n"])
        .collect();
    let options = options(|o| {
        o.repair = true;
    });
    assert!(Robot::from_urdf_str(&text, "broken.urdf").is_err());
    let robot = Robot::from_urdf_str_with(&text, "broken.urdf", &options)
        .unwrap_or_else(|e| panic!("{e}"))
        .robot;
    assert!(remarked(
        &robot,
        "link `base_link`, `<inertial>`",
        "repaired: its inertia is taken as that of a solid of its shapes that weighs 5 kg"
    ));
    assert!(remarked(
        &robot,
        "joint `wheel_1`, `<limit>`",
        "stands here a second time: the first is read"
    ));
    assert!(remarked(
        &robot,
        "wheel `wheel_3`",
        "repaired: rollers made longer to close gaps of up to 14.13 deg"
    ));
    assert_eq!(robot.wheels[0].motor.effort_n_m, 1.0);
    for roller in &robot.wheels[0].rollers {
        assert!((roller.length_m - 2.0 * 0.038 * (PI / 8.0).tan()).abs() < 1e-13);
    }
    // A fault that is left is told at its line in the file as it is.
    let text = text.replace(r#"<mass value="0.01"/>"#, r#"<mass value="-1"/>"#);
    let error =
        Robot::from_urdf_str_with(&text, "broken.urdf", &options).expect_err("a negative mass");
    assert_eq!(error.line(), Some(line_of(&text, "value=\"-1\"")));
}

// --- Whatever the bytes.

/// `ILON_DAMAGE_ROUNDS=100000` looks longer.
#[test]
fn no_damage_to_the_text_fells_the_loader() {
    let text = small();
    let rounds =
        std::env::var("ILON_DAMAGE_ROUNDS").map_or(600, |r| r.parse().expect("a number of rounds"));
    // A linear congruential generator (Knuth's MMIX constants): the same damage in every run.
    let mut state = 1973u64;
    let mut random = |below: usize| {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 33) as usize % below
    };
    let spices = [
        "0",
        "-1",
        "1e308",
        "nan",
        "inf",
        "\"",
        "<",
        "</link>",
        "continuous",
        "fixed",
        "",
        " ",
        "1e-320",
        "&amp;",
        "\u{fffd}",
        "<limit/>",
        "base_link",
        "1e9",
    ];
    let options = [
        LoadOptions::default(),
        options(|o| {
            o.repair = true;
        }),
        options(|o| {
            o.wheels = Some(rollers());
        }),
    ];
    let mut loaded = 0;
    for round in 0..rounds {
        let mut damaged = text.clone();
        for _ in 0..=random(3) {
            let boundary = |i: usize| {
                (0..=i)
                    .rev()
                    .find(|&i| damaged.is_char_boundary(i))
                    .unwrap_or(0)
            };
            let from = boundary(random(damaged.len()));
            let to = boundary((from + random(40)).min(damaged.len())).max(from);
            damaged.replace_range(from..to, spices[random(spices.len())]);
        }
        match Robot::from_urdf_str_with(&damaged, "damaged.urdf", &options[round % 3]) {
            Ok(robot) => {
                loaded += 1;
                let finite = |w: &ilon_robot::Wheel| {
                    w.radius_m.is_finite() && w.hub.inertia_kg_m2.iter().all(|x| x.is_finite())
                };
                assert!(robot.robot.wheels.iter().all(finite));
            }
            Err(error) => assert!(!error.to_string().is_empty() && !error.help().is_empty()),
        }
    }
    // Some damage hits what is not read; most does not.
    assert!(loaded > 0 && loaded < rounds, "{loaded}");
}

#[test]
fn a_closing_bracket_in_quotes_closes_no_element() {
    let mut text = small().replace("</robot>", "");
    for i in 0..200 {
        text += &format!("<gazebo reference=\"a > b {i}\"/>\n");
    }
    assert_eq!(load(&(text + "</robot>")).wheels.len(), 3);
}

#[test]
fn thousands_of_rollers_load_in_good_time() {
    let spec = SPEC.replace("per_row = 8", "per_row = 1000");
    let text = generate(&Spec::from_toml_str(&spec, "many.toml").expect("good")).expect("in range");
    let start = std::time::Instant::now();
    assert_eq!(load(&text).wheels[0].rollers.len(), 1000);
    // A second or two on a slow machine; anything quadratic takes minutes.
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
    println!("{} bytes in {:?}", text.len(), start.elapsed());
}

#[test]
fn a_long_chain_of_links_loads_in_good_time() {
    let mut chain = String::new();
    for i in 0..20_000 {
        let parent = if i == 0 {
            "base_link".to_owned()
        } else {
            format!("c{}", i - 1)
        };
        chain += &format!(
            "<link name=\"c{i}\"/><joint name=\"c{i}\" type=\"fixed\"><parent link=\"{parent}\"/><child link=\"c{i}\"/></joint>\n"
        );
    }
    let start = std::time::Instant::now();
    assert_eq!(
        load(&small().replace("</robot>", &(chain + "</robot>")))
            .wheels
            .len(),
        3
    );
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
    println!("{:?}", start.elapsed());
}

/// Degrees are what descriptions and options take: 0.7854 of them are no mecanum wheel, 0 and 45 are nothing odd.
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

/// Hub axes point outward on a ring, so that a wheel reaches by its radius to both sides of its place: neighbours of five meet within
/// rho / tan(36 deg) of the middle, plus half of their width.
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
