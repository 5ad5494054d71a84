//! Wheels without rollers: recognised by how they can be driven, or named.

use ilon_formats::{Fault, LoadOptions, LoadRobot, RobotError, TyreOptions};
use ilon_robot::{CollisionShape, JointRole, Robot};

const SKID: &str = include_str!("../../../../../assets/robots/skid4.urdf");
const DIFFERENTIAL: &str = include_str!("../../../../../assets/robots/differential.urdf");
const MECANUM: &str = include_str!("../../../../../assets/robots/mecanum4.urdf");
const SWERVE: &str = include_str!("../../../../../assets/robots/swerve4.urdf");
const TRICYCLE: &str = include_str!("../../../../../assets/robots/tricycle.urdf");

fn load(urdf: &str) -> Robot {
    Robot::from_urdf_str(urdf, "robot.urdf").expect("a robot on tyres")
}

fn names(robot: &Robot) -> Vec<&str> {
    robot
        .wheels
        .iter()
        .map(|wheel| wheel.name.as_str())
        .collect()
}

#[test]
fn wheels_that_a_plug_in_drives_as_plain_ones_roll_on_tyres() {
    let robot = load(SKID);
    assert_eq!(robot.wheels.len(), 4);
    for wheel in &robot.wheels {
        assert!(wheel.has_tyre() && wheel.is_round());
        assert!((wheel.rollers[0].length_m - 0.05).abs() < 1e-12);
        // All mass stays with the hub.
        assert!((wheel.hub.mass_kg - 1.0).abs() < 1e-12 && wheel.rollers[0].mass_kg == 0.0);
    }
    // Nothing says so without the plug-in.
    let silent = SKID.replace("diff_drive", "some_drive");
    let silent = silent.replace("skid_steer", "some_other");
    let error = Robot::from_urdf_str(&silent, "robot.urdf").unwrap_err();
    assert!(
        error.to_string().contains("4 wheels without rollers"),
        "{error}"
    );
    let mut options = LoadOptions::default();
    options.tyres = Some(TyreOptions::default());
    let loaded = Robot::from_urdf_str_with(&silent, "robot.urdf", &options).expect("asked for");
    assert_eq!(names(&loaded.robot), names(&robot));
}

#[test]
fn a_pair_of_wheels_rolls_on_tyres_beside_casters_that_swivel_freely() {
    let robot = load(DIFFERENTIAL);
    assert_eq!(names(&robot), ["left", "right"]);
    assert_eq!(robot.joints.len(), 4);
    assert!(
        robot
            .joints
            .iter()
            .all(|joint| joint.role == JointRole::Free)
    );
}

/// Meshes of casters' wheels carry the robot as the cylinders of their size.
#[test]
fn casters_whose_wheels_are_meshes_roll_as_cylinders() {
    let (sides, radius_m) = (64, 0.03);
    let mut mesh = String::new();
    for k in 0..sides {
        let (s, c) = (std::f64::consts::TAU * f64::from(k) / f64::from(sides)).sin_cos();
        for z_m in [-0.01, 0.01] {
            mesh += &format!("v {} {} {z_m}\n", radius_m * c, radius_m * s);
        }
    }
    for k in 0..sides {
        let [a, b] = [2 * k + 1, 2 * ((k + 1) % sides) + 1];
        mesh += &format!("f {a} {b} {}\nf {b} {} {}\n", a + 1, b + 1, a + 1);
    }
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("caster.obj"), mesh).expect("a mesh");
    let cylinder = "<cylinder radius=\"0.03\" length=\"0.02\"/>";
    let meshed = DIFFERENTIAL.replace(cylinder, "<mesh filename=\"caster.obj\"/>");
    let file = folder.path().join("robot.urdf");
    std::fs::write(&file, meshed).expect("a file");
    let robot = Robot::load(file.to_str().expect("a path")).expect("it is read");
    let drawn = load(DIFFERENTIAL);
    for (of, drawn) in robot.joints.iter().zip(&drawn.joints) {
        let [of, drawn] = [of, drawn].map(|joint| &joint.body.collisions);
        assert_eq!(of.len(), drawn.len());
        for (of, drawn) in of.iter().zip(drawn) {
            // Meshes hold numbers of 32 bits.
            let down = -nalgebra::Vector3::z();
            assert!((of.reach_m(&down) - drawn.reach_m(&down)).abs() < 1e-7);
            let is_round = |of: &ilon_robot::Collision| {
                matches!(of.shape, ilon_robot::CollisionShape::Cylinder { radius_m, length_m }
                    if (radius_m - 0.03).abs() + (length_m - 0.02).abs() < 1e-7)
            };
            assert!(is_round(of) && is_round(drawn), "{:?}", of.shape);
        }
    }
}

/// Casters steer nothing, beside wheels that do not turn in the file, or of which one follows the
/// other.
/// A joint without `<axis>` turns about x, across which these cylinders lie: they show that y is meant,
/// which points to the left.
#[test]
fn an_axis_that_is_not_stated_is_that_of_the_cylinder_if_repaired() {
    let bare = SKID.replace("<axis xyz=\"0 1 0\"/>", "");
    let error = Robot::from_urdf_str(&bare, "robot.urdf").expect_err("no axis");
    let is_told = |error: &RobotError| matches!(error.fault(), Fault::NoAxis);
    let all: Vec<&RobotError> = std::iter::once(&error).chain(error.others()).collect();
    assert_eq!(
        all.iter().filter(|error| is_told(error)).count(),
        4,
        "{all:?}"
    );
    let mut options = LoadOptions::default();
    options.repair = true;
    let read = Robot::from_urdf_str_with(&bare, "robot.urdf", &options).expect("repaired");
    let words = "repaired: its joint states no `<axis>`: 0 1 0, along its cylinder";
    assert!(said(&read.robot, words), "{:?}", read.robot.remarks);
    let whole = load(SKID);
    for (wheel, of) in read.robot.wheels.iter().zip(&whole.wheels) {
        let apart = wheel.body_from_hub.inverse() * of.body_from_hub;
        assert!(apart.translation.vector.norm() < 1e-9 && apart.rotation.angle() < 1e-6);
        assert!((wheel.radius_m - of.radius_m).abs() < 1e-9);
    }
}

/// A square box stands for the wheel inside it, as a shape and as a mesh: one of 120 mm for a wheel of
/// 60 mm radius. One of 120 mm by 90 mm is no wheel.
#[test]
fn a_mesh_that_is_a_square_box_is_a_wheel_as_a_box_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("robot.urdf");
    let cylinder = "<cylinder radius=\"0.06\" length=\"0.025\"/>";
    for (high_m, radius_m) in [(0.12, Some(0.06)), (0.09, None)] {
        let mut mesh = String::new();
        for corner in 0..8 {
            let of = |bit: u32, size_m: f64| size_m * (f64::from(corner >> bit & 1) - 0.5);
            mesh += &format!("v {} {} {}\n", of(0, 0.12), of(1, high_m), of(2, 0.025));
        }
        mesh += "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";
        std::fs::write(folder.path().join("box.obj"), mesh).expect("a mesh");
        let boxed = DIFFERENTIAL.replace(cylinder, "<mesh filename=\"box.obj\"/>");
        std::fs::write(&file, boxed).expect("a robot");
        let read = Robot::load(&file).map(|robot| robot.wheels[0].radius_m);
        match radius_m {
            // Meshes hold numbers of 24 bits, 4 nm at this size.
            Some(radius_m) => assert!((read.expect("two wheels") - radius_m).abs() < 1e-8),
            None => {
                let said = read.expect_err("no wheels").to_string();
                assert!(said.contains("75.0 mm from the axis one way"), "{said}");
            }
        }
    }
}

/// The wheels' floor is 30 mm below the casters' axles. By 0.3 mm, which is rounding, a rigid robot
/// would stand on its casters and not drive; by 3 mm it is meant.
#[test]
fn casters_that_reach_below_the_floor_by_rounding_end_on_it() {
    let words = "this caster's wheel reaches 0.30 mm below the wheels' floor";
    for (in_file, radius_m) in [("0.03", 0.03), ("0.0303", 0.03), ("0.033", 0.033)] {
        let cylinder = format!("<cylinder radius=\"{in_file}\" length=\"0.02\"/>");
        let robot =
            load(&DIFFERENTIAL.replace("<cylinder radius=\"0.03\" length=\"0.02\"/>", &cylinder));
        let shapes = robot.joints.iter().flat_map(|of| &of.body.collisions);
        let radii: Vec<f64> = shapes
            .filter_map(|of| match of.shape {
                CollisionShape::Cylinder { radius_m, .. } => Some(radius_m),
                _ => None,
            })
            .collect();
        assert_eq!(radii.len(), 2, "{in_file}");
        assert!(
            radii.iter().all(|m| (m - radius_m).abs() < 1e-12),
            "{radii:?}"
        );
        assert_eq!(said(&robot, words), in_file == "0.0303", "{in_file}");
    }
}

/// Two wheels of 60 mm radius at the height of a box that reaches 120 mm down: the robot lies on it,
/// level, with its wheels in the air. It is not a caster.
#[test]
fn a_level_robot_that_lies_on_its_chassis_does_not_stand_on_its_wheels() {
    let (before, rest) = DIFFERENTIAL
        .split_once("<link name=\"front_caster_fork\">")
        .unwrap();
    let (_, after) = rest.rsplit_once("</joint>").unwrap();
    let low = format!("{before}{after}").replace("xyz=\"0 0 0.11\"", "xyz=\"0 0 -0.01\"");
    let error = Robot::from_urdf_str(&low, "robot.urdf").unwrap_err();
    let Fault::ChassisBelowFloor { deep_mm, .. } = error.fault() else {
        panic!("{error}")
    };
    assert!((deep_mm - 60.0).abs() < 1e-9, "{error}");
}

#[test]
fn casters_are_no_wheels_of_a_pair_that_does_not_turn() {
    let joint = |name: &str| format!("<joint name=\"{name}\" type=\"continuous\">");
    let fixed = ["left", "right"]
        .iter()
        .fold(DIFFERENTIAL.to_owned(), |text, name| {
            text.replace(&joint(name), &joint(name).replace("continuous", "fixed"))
        });
    let robot = load(&fixed);
    assert_eq!(names(&robot), ["left", "right"]);
    assert_eq!(robot.joints.len(), 4);
    let end = "<child link=\"right_wheel\"/>";
    let mimic = DIFFERENTIAL.replace(end, &format!("{end}<mimic joint=\"left\"/>"));
    let error = Robot::from_urdf_str(&mimic, "robot.urdf").unwrap_err();
    assert!(!error.to_string().contains("steered wheels"), "{error}");
}

/// The size of two wheels side by side whose mesh is not found is asked for; that rollers are
/// missing is not said. Two turning segments of an arm are no wheels.
#[test]
fn the_size_of_a_pair_of_wheels_is_asked_for() {
    let cylinder = r#"<cylinder radius="0.06" length="0.025"/>"#;
    assert_eq!(DIFFERENTIAL.matches(cylinder).count(), 4);
    let unknown = DIFFERENTIAL.replace(
        cylinder,
        r#"<mesh filename="package://robot_meshes/meshes/disc.stl"/>"#,
    );
    let error = Robot::from_urdf_str(&unknown, "robot.urdf").unwrap_err();
    let (words, help) = (error.to_string(), error.help());
    let named = words.contains("does not show its radius") && words.contains("`robot_meshes`");
    assert!(
        named && help.contains("say the wheels' radius"),
        "{words}; {help}"
    );
    let mut options = LoadOptions::default();
    options.wheel_radius_m = Some(0.06);
    options.leave_out_missing = true;
    let loaded = Robot::from_urdf_str_with(&unknown, "robot.urdf", &options).expect("its size");
    assert_eq!(names(&loaded.robot), ["left", "right"]);
    let arm = unknown
        .replace("wheel", "segment")
        .replace("disc", "segment");
    let error = Robot::from_urdf_str(&arm, "robot.urdf").unwrap_err();
    assert!(
        !error.to_string().contains("does not show its radius"),
        "{error}"
    );
}

/// Casters of a robot on rollers are free too, where the file calls them so or shows a disc about
/// the axle: held, they would carry the robot as its chassis does.
#[test]
fn casters_beside_rollers_swivel_freely() {
    let (start, end) = ("<link name=\"front_caster_fork\">", "</joint>");
    let from = DIFFERENTIAL.find(start).expect("its first fork");
    let to = DIFFERENTIAL.rfind(end).expect("its last joint") + end.len();
    let casters = format!("{}</robot>", &DIFFERENTIAL[from..to]);
    let robot = load(&MECANUM.replace("</robot>", &casters));
    assert_eq!((robot.wheels.len(), robot.joints.len()), (4, 4));
    let mut roles = robot.joints.iter().map(|joint| joint.role);
    assert!(roles.all(|role| role == JointRole::Free));
    let unnamed = casters.replace("caster", "part");
    let robot = load(&MECANUM.replace("</robot>", &unnamed));
    assert_eq!(robot.joints.len(), 4, "{:?}", robot.remarks);
    // High above the floor the same is no caster.
    let raised = unnamed.replace("0 0.06\"/>", "0 0.46\"/>");
    assert_ne!(raised, unnamed);
    let robot = load(&MECANUM.replace("</robot>", &raised));
    assert_eq!(robot.joints.len(), 0, "{:?}", robot.remarks);
}

/// Whatever it is called: by its trail, behind a joint that turns endlessly without a drive. A
/// wheel straight below such a joint has none, nor is one with a drive a caster; both are steered.
#[test]
fn a_caster_is_known_by_its_trail() {
    let urdf = DIFFERENTIAL.replace("caster", "fork");
    let robot = load(&urdf);
    assert_eq!(names(&robot), ["left", "right"]);
    assert!(
        robot
            .joints
            .iter()
            .all(|joint| joint.role == JointRole::Free)
    );
    let steered = |urdf: &str| {
        let robot = load(urdf);
        let wheels = robot.wheels.iter();
        wheels
            .filter(|wheel| robot.steering_of(wheel).is_some())
            .count()
    };
    assert_eq!(steered(&urdf.replace("-0.025 0 -0.03", "0 0.025 -0.03")), 2);
    // A twelfth of the wheel's radius is a trail, whatever that is in metres.
    assert_eq!(
        steered(&urdf.replace("-0.025 0 -0.03", "-0.0025 0 -0.03")),
        0
    );
    let drive = r#"<axis xyz="0 0 1"/><limit effort="5" velocity="5"/>"#;
    assert_eq!(steered(&urdf.replace(r#"<axis xyz="0 0 1"/>"#, drive)), 2);
}

/// A ball is no wheel, on a joint that turns, or an upright one and another, or none; nor is a
/// foot, nor what is called a caster and does not swivel: the robot stands on them without
/// friction.
#[test]
fn a_caster_that_does_not_swivel_rolls_in_every_direction() {
    let (bare, _) = DIFFERENTIAL
        .split_once("<link name=\"front_caster_fork\">")
        .expect("its fork");
    let link = |name: &str, shape: &str| {
        format!(
            r#"<link name="{name}"><inertial><mass value="0.1"/><inertia ixx="3.6e-5" ixy="0" ixz="0" iyy="3.6e-5" iyz="0" izz="3.6e-5"/></inertial>{shape}</link>"#
        )
    };
    let joint = |name: &str, parent: &str, place: &str, axis: &str| {
        format!(
            r#"<joint name="{name}_joint" type="continuous"><parent link="{parent}"/><child link="{name}"/><origin xyz="{place}"/><axis xyz="{axis}"/></joint>"#
        )
    };
    let ball = r#"<collision><geometry><sphere radius="0.03"/></geometry></collision>"#;
    let roll = r#"<collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.03" length="0.02"/></geometry></collision>"#;
    let alone = |name: &str, shape: &str| {
        link(name, shape) + &joint(name, "base_link", "0.16 0 0.03", "0 1 0")
    };
    let swivels = [
        link("pivot", ""),
        joint("pivot", "base_link", "0.16 0 0.03", "0 0 1"),
        link("round", ball),
        joint("round", "pivot", "0 0 0", "0 1 0"),
    ];
    // Across the wheels' axles, as of omni wheels.
    let fixed = |part: String| {
        part.replace("continuous", "fixed")
            .replace("0 1 0", "1 0 0")
    };
    let across = roll.replace("1.5707963267948966 0 0", "0 1.5707963267948966 0");
    let casters = [
        alone("round", ball),
        fixed(alone("round", ball)),
        fixed(alone("foot", &across)),
        alone("caster", roll),
        swivels.concat(),
    ];
    for caster in casters {
        let robot = load(&format!("{bare}{caster}</robot>"));
        assert_eq!(names(&robot), ["left", "right"]);
        assert!(robot.joints.is_empty(), "{:?}", robot.joints);
        let slides = robot
            .chassis
            .collisions
            .iter()
            .filter(|of| of.friction == Some(0.0));
        assert_eq!(slides.count(), 1);
    }
}

#[test]
fn steered_wheels_are_driven_and_their_upright_joints_are_servos() {
    let robot = load(SWERVE);
    assert_eq!(robot.wheels.len(), 4);
    for wheel in &robot.wheels {
        let joint = robot.steering_of(wheel).expect("steered");
        assert!(robot.joints[joint].name.ends_with("_steer"));
        assert!(wheel.motor.effort_n_m > 0.0);
    }
}

#[test]
fn of_wheels_of_which_only_some_have_a_torque_the_others_roll_along() {
    let robot = load(TRICYCLE);
    let efforts: Vec<f64> = robot
        .wheels
        .iter()
        .map(|wheel| wheel.motor.effort_n_m)
        .collect();
    assert_eq!(names(&robot), ["drive", "left", "right"]);
    assert_eq!(efforts, [6.0, 0.0, 0.0]);
}

/// A caster's wheel on a tyre that nothing drives goes on to swivel freely: no servo steers it.
#[test]
fn a_caster_that_is_given_a_tyre_swivels_freely() {
    let mut tyres = TyreOptions::default();
    tyres.free = vec!["rear_caster_roll".to_owned()];
    let mut options = LoadOptions::default();
    options.tyres = Some(tyres);
    let loaded = Robot::from_urdf_str_with(DIFFERENTIAL, "robot.urdf", &options);
    let robot = loaded.expect("a robot on tyres").robot;
    let swivels: Vec<bool> = robot.wheels.iter().map(|of| robot.swivels(of)).collect();
    assert_eq!(names(&robot), ["left", "right", "rear_caster_roll"]);
    assert_eq!(swivels, [false, false, true]);
}

/// A robot that speaks of mecanum wheels is none on tyres: it is asked for its rollers as before.
#[test]
fn what_calls_itself_mecanum_gets_no_tyres() {
    let urdf = SWERVE.replace("robot name=\"swerve4\"", "robot name=\"mecanum_base\"");
    let error = Robot::from_urdf_str(&urdf, "robot.urdf").unwrap_err();
    assert!(error.to_string().contains("steered wheels"), "{error}");
}

#[test]
fn a_tyre_that_is_none_is_refused_with_its_numbers() {
    for (width_m, shoulder_m) in [(0.0, 0.0), (0.03, 0.02), (0.3, 0.09), (-1.0, 0.0)] {
        let mut tyres = TyreOptions::default();
        tyres.width_m = Some(width_m);
        tyres.shoulder_radius_m = Some(shoulder_m);
        let mut options = LoadOptions::default();
        options.tyres = Some(tyres);
        let error = Robot::from_urdf_str_with(SKID, "robot.urdf", &options).unwrap_err();
        assert!(error.to_string().contains("tyre"), "{error}");
    }
}

/// A pair of wheels of radius 50 mm on an axle 0.1 m ahead of a chassis's middle, and balls of
/// radius 20 mm fixed to it, each at a place x and with its lowest point at a height, in metres.
fn on_balls(balls_m: &[[f64; 2]]) -> String {
    let ball = |(k, [x_m, low_m]): (usize, &[f64; 2])| {
        format!(
            r#"<link name="ball{k}"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
            <joint name="hold{k}" type="fixed"><parent link="base"/><child link="ball{k}"/><origin xyz="{x_m} 0 {z_m}"/></joint>"#,
            z_m = low_m + 0.02
        )
    };
    let wheel = |(side, y_m): (&str, f64)| {
        format!(
            r#"<link name="{side}"><inertial><mass value="0.4"/><inertia ixx="3e-4" ixy="0" ixz="0" iyy="5e-4" iyz="0" izz="3e-4"/></inertial>
            <collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.02"/></geometry></collision></link>
            <joint name="{side}_wheel" type="continuous"><parent link="base"/><child link="{side}"/>
            <origin xyz="0.1 {y_m} 0.05"/><axis xyz="0 1 0"/><limit effort="2" velocity="20"/></joint>"#
        )
    };
    let balls: String = balls_m.iter().enumerate().map(ball).collect();
    let wheels: String = [("left", 0.15), ("right", -0.15)].map(wheel).concat();
    format!(
        r#"<robot name="balls"><link name="base"><inertial><origin xyz="0 0 0.1"/><mass value="5"/>
        <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.08"/></inertial>
        <collision><origin xyz="0 0 0.12"/><geometry><box size="0.3 0.25 0.05"/></geometry></collision></link>{wheels}{balls}</robot>"#
    )
}

fn glides(robot: &Robot) -> usize {
    let shapes = robot.chassis.collisions.iter();
    shapes.filter(|shape| shape.friction == Some(0.0)).count()
}

fn said(robot: &Robot, words: &str) -> bool {
    robot
        .remarks
        .iter()
        .any(|remark| remark.to_string().contains(words))
}

#[test]
fn balls_fixed_to_the_chassis_are_casters() {
    let robot = load(&on_balls(&[[-0.1, 0.0], [0.25, 0.0]]));
    assert_eq!(glides(&robot), 2);
    let pose = robot.standing_pose().expect("on wheels and a ball");
    assert!(pose.tilt_rad() < 1e-12 && said(&robot, "taken for ball casters"));
    // One that is rounded to 0.4 mm too low reaches just down to the floor.
    let robot = load(&on_balls(&[[-0.1, -4e-4]]));
    let pose = robot.standing_pose().expect("on wheels and a ball");
    assert!(pose.tilt_rad() < 1e-9 && glides(&robot) == 1);
    assert!(said(&robot, "up to 0.40 mm below"));
    // One that is only shown carries too, unlike one of a lamp.
    let shown = on_balls(&[[-0.1, 0.0], [0.1, 0.2]]);
    let ball = r#"<geometry><sphere radius="0.02"/></geometry></collision>"#;
    let visual = ball.replace("collision", "visual");
    let shown = shown.replace(&format!("<collision>{ball}"), &format!("<visual>{visual}"));
    let robot = load(&shown);
    let balls = robot.chassis.collisions.iter();
    assert_eq!((glides(&robot), balls.count()), (1, 2));
    assert!(said(&robot, "carry it as they are shown"));
}

/// Wheels and balls below a joint that turns them all under the chassis, the balls on joints of
/// their own.
#[test]
fn balls_of_a_body_that_is_steered_are_casters() {
    let module = r#"<link name="module"><inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
        <joint name="roll" type="continuous"><parent link="base"/><child link="module"/><axis xyz="0 0 1"/><limit effort="30" velocity="3"/></joint></robot>"#;
    let balls = on_balls(&[[-0.1, 0.0], [0.25, -4e-4]]);
    let urdf = balls
        .replace(r#"<parent link="base"/>"#, r#"<parent link="module"/>"#)
        .replace(
            r#"type="fixed">"#,
            r#"type="continuous"><axis xyz="1 0 0"/>"#,
        )
        .replace("</robot>", module);
    let robot = load(&urdf);
    assert_eq!(names(&robot), ["left_wheel", "right_wheel"]);
    let shapes = &robot.joints[0].body.collisions;
    assert!(robot.joints[0].name == "roll" && shapes.len() == 2);
    for shape in shapes {
        assert_eq!(shape.friction, Some(0.0));
        let low_m = -shape.reach_m(&-nalgebra::Vector3::z());
        assert!(low_m.abs() < 1e-12, "{low_m}");
    }
    assert!(said(&robot, "taken for ball casters"));
}

/// The ball's lowest point at (-0.2, -0.01) m from that of the axle: the robot pitches until both
/// are level. The wheels roll on their rims, the ball on its own: atan by lowest points, to second
/// order in the angle.
#[test]
fn a_caster_that_is_longer_or_shorter_than_the_wheels_tilts_the_robot() {
    for low_m in [-0.01, 0.01] {
        let robot = load(&on_balls(&[[-0.1, low_m]]));
        let pose = robot.standing_pose().expect("on wheels and a ball");
        // Positive pitch lowers the front.
        let expected_rad = f64::atan2(-low_m, 0.2);
        let off_rad = pose.pitch_rad - expected_rad;
        assert!(off_rad.abs() < 0.1 * expected_rad.abs(), "{pose:?}");
        for wheel in &robot.wheels {
            assert!(pose.gap_m(wheel).abs() < 1e-9, "{pose:?}");
        }
        assert_eq!(glides(&robot), 1);
    }
}

#[test]
fn a_chassis_that_lifts_the_wheels_is_refused() {
    let both_low = on_balls(&[[-0.1, -0.01], [0.25, -0.01]]);
    let error = Robot::from_urdf_str(&both_low, "robot.urdf").unwrap_err();
    assert!(error.to_string().contains("10.0 mm below"), "{error}");
    // Four wheels stand alone: what else reaches the floor would rub.
    let skid = SKID.replace("0 0 0.12", "0 0 0.05");
    let error = Robot::from_urdf_str(&skid, "robot.urdf").unwrap_err();
    assert!(error.to_string().contains("touches the floor"), "{error}");
}

/// Without anything that reaches the floor besides its two wheels a robot would swing about its
/// axle. A mesh of the chassis may show what does: here a block down to the floor, whose corners
/// behind the axle carry the centre of mass.
#[test]
fn two_wheels_alone_are_refused_and_a_mesh_may_show_the_casters() {
    let alone = on_balls(&[]);
    let error = Robot::from_urdf_str(&alone, "robot.urdf").unwrap_err();
    assert!(error.to_string().contains("two wheels alone"), "{error}");
    let folder = tempfile::tempdir().expect("a folder");
    let corners = |k: usize| {
        let pick = |bit: usize, low: f32, high: f32| if k & bit == 0 { low } else { high };
        [pick(1, -0.2, 0.0), pick(2, -0.1, 0.1), pick(4, 0.0, 0.1)]
    };
    let mut stl = vec![0_u8; 80];
    stl.extend(6_u32.to_le_bytes());
    for k in 0..6 {
        let triangle = [[0.0; 3], corners(k), corners(k + 1), corners(k + 2)];
        stl.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
        stl.extend([0, 0]);
    }
    std::fs::write(folder.path().join("block.stl"), stl).expect("a mesh");
    let meshed = alone.replace(
        r#"<collision><origin xyz="0 0 0.12"/><geometry><box size="0.3 0.25 0.05"/>"#,
        r#"<collision><geometry><mesh filename="block.stl"/>"#,
    );
    let file = folder.path().join("robot.urdf");
    std::fs::write(&file, meshed).expect("a file");
    let robot = Robot::load(file.to_str().expect("a path")).expect("it stands");
    let pose = robot.standing_pose().expect("on wheels and block");
    assert!(pose.tilt_rad() < 1e-9 && glides(&robot) == 1, "{pose:?}");
}

/// A file for viewers may hold its wheels still. Two that are called wheels are a pair, as if they
/// turned, if nothing else turns; a third one would leave open which two are driven.
#[test]
fn two_wheels_that_a_file_holds_still_are_a_pair_with_a_remark() {
    let still = |urdf: &str| urdf.replace("\"continuous\"", "\"fixed\"");
    let file = on_balls(&[[-0.1, 0.0]]);
    let (held, turning) = (load(&still(&file)), load(&file));
    assert_eq!(names(&held), ["left_wheel", "right_wheel"]);
    for (held, turning) in held.wheels.iter().zip(&turning.wheels) {
        assert!((held.position_m() - turning.position_m()).norm() < 1e-12);
        assert!((held.radius_m - turning.radius_m).abs() < 1e-12 && held.has_tyre());
    }
    let words = "their joints do not turn in the file, and are taken to";
    assert!(said(&held, words) && !said(&turning, words));

    let drums = still(&file).replace("_wheel", "_drum");
    let ball = "<collision><geometry><sphere radius=\"0.02\"/>";
    let disc = "<collision><origin rpy=\"1.5707963267948966 0 0\"/><geometry><cylinder radius=\"0.05\" length=\"0.02\"/>";
    let three = on_balls(&[[-0.1, 0.03]])
        .replace(ball, disc)
        .replace("hold0", "rear_wheel");
    let three = still(&three);
    let rear = "name=\"rear_wheel\" type=";
    let one_turns = three.replace(
        &format!("{rear}\"fixed\">"),
        &format!("{rear}\"continuous\"><axis xyz=\"0 1 0\"/>"),
    );
    assert_ne!(three, one_turns);
    for refused in [drums, three, one_turns] {
        assert!(Robot::from_urdf_str(&refused, "robot.urdf").is_err());
    }
}

/// Tyres of 50 mm width stand side by side down to 50 mm, whatever their radius of 80 mm.
#[test]
fn tyres_reach_into_one_another_by_their_width() {
    for (y_m, reaches) in [(0.06, false), (0.026, false), (0.024, true)] {
        let near = SKID
            .replace(" 0.2 0.08\"", &format!(" {y_m} 0.08\""))
            .replace(" -0.2 0.08\"", &format!(" -{y_m} 0.08\""));
        assert_eq!(
            said(&load(&near), "it reaches into wheel"),
            reaches,
            "{y_m}"
        );
    }
}

/// A ball that turns is a caster beside two wheels that a file holds still, as one that does not.
#[test]
fn a_ball_that_turns_leaves_a_still_pair_its_wheels() {
    let still = on_balls(&[[-0.1, 0.0]]).replace("\"continuous\"", "\"fixed\"");
    let (held, turns) = (
        "\"hold0\" type=\"fixed\">",
        "\"hold0\" type=\"continuous\"><axis xyz=\"0 1 0\"/>",
    );
    let robot = load(&still.replace(held, turns));
    assert_eq!(names(&robot), ["left_wheel", "right_wheel"]);
    assert_eq!(glides(&robot), 1);
}
