//! `ilon inspect --pathplanner`, `--choreo`, `--road-runner`: a robot for the planners of robot
//! contests.

use std::f64::consts::TAU;

use ilon::inspect::conditions;
use ilon::planners::{Feedforward, Swerve, choreo, pathplanner};
use ilon::robot::{Robot, Twist};
use ilon::simulate::Limits;
use ilon_formats::LoadRobot;
use serde_json::Value;

use crate::support::{Folder, ended_with, stdout};

const ROBOT: &str = "../../../assets/robots/mecanum4.urdf";

fn under(settings: &[&str]) -> (ilon::Scenario, Robot, Limits) {
    let robot = Robot::load(ROBOT).expect("a robot");
    let settings: Vec<_> = settings
        .iter()
        .map(|s| s.parse().expect("a setting"))
        .collect();
    let files = ilon::files::FileAccess::anywhere();
    let (scenario, robot) = conditions(&settings, &robot, &files).expect("conditions");
    let limits = Limits::held(&scenario, &robot).expect("limits");
    (scenario, robot, limits)
}

/// A small generator of numbers in 0 to 1, the same each time.
fn draws() -> impl FnMut() -> f64 {
    let mut state = 7_u64;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// The robot can reach every acceleration that four modules within their friction give; with a
/// third more friction it cannot reach all.
#[test]
fn what_the_swerve_drive_can_do_the_robot_can() {
    for settings in [
        &["world.floor.friction=0.8"][..],
        &["world.floor.friction=0.3", "world.floor.slope_deg=3"],
        &["faults.0.payload={ mass_kg = 5, x_m = 0.1, z_m = 0.3 }"],
    ] {
        let (scenario, robot, limits) = under(settings);
        let swerve = Swerve::of(&robot, &limits).expect("four wheels");
        let force_n = swerve.friction * 9.8 * swerve.mass_kg / 4.0;
        let mut draw = draws();
        let mut most: f64 = 0.0;
        let polytope = limits.polytope.as_ref().expect("a polytope");
        for _ in 0..2000 {
            let mut sum = [0.0; 3];
            for [x, y] in swerve.modules_m {
                let (fy, fx) = (TAU * draw()).sin_cos();
                let (fx, fy) = (force_n * fx, force_n * fy);
                sum[0] += fx / swerve.mass_kg;
                sum[1] += fy / swerve.mass_kg;
                sum[2] += (x * fy - y * fx) / swerve.inertia_kg_m2;
            }
            most = most.max(polytope.share(Twist::new(sum[0], sum[1], sum[2])));
        }
        // At most nine tenths; random draws come near.
        assert!(most <= 0.9 + 1e-9, "{most}");
        assert!(most > 0.7, "{most}");
        assert_eq!(scenario.world.gravity_m_s2, 9.81);
    }
}

/// In closed form: robot A of 11.36 kg on 0.05 m wheels. k_A ahead is 12 V (m + 4 J / rho^2)
/// rho / 4 / stall per speed of the rim, k_V 12 V / (rho w0) beside the damping, and k_S friction
/// alone.
#[test]
fn feedforward_is_as_by_hand() {
    let (scenario, mut robot, _) =
        under(&["motors.dc={ stall_torque_n_m = 2.0, no_load_rate_rad_s = 30.0 }"]);
    let dc = scenario.motors.dc.as_ref().expect("motors");
    let ahead =
        Feedforward::of(&robot, dc, Twist::new(1.0, 0.0, 0.0), &scenario.world).expect("a model");
    let radius_m = robot.wheels[0].radius_m;
    let damping = robot.wheels[0].joint.damping_n_m_s;
    let by_hand = 12.0 * (1.0 / (radius_m * 30.0) + damping / radius_m / 2.0);
    assert!(
        (ahead.kv_v_s_m / by_hand - 1.0).abs() < 1e-9,
        "{ahead:?} {by_hand}"
    );
    let mass_alone = 12.0 * robot.mass_kg() * radius_m / 4.0 / 2.0;
    assert!(
        ahead.ka_v_s2_m > mass_alone && ahead.ka_v_s2_m < 1.2 * mass_alone,
        "{ahead:?} {mass_alone}"
    );
    assert!(ahead.ks_v.abs() < 1e-9, "{ahead:?}");
    // Bushings of mu a / r resist a sideways motion with sqrt(2) mu m g a / r: rho / 4 of it at
    // each wheel.
    for wheel in &mut robot.wheels {
        wheel.surface.axle_friction = 0.2;
        wheel.surface.axle_radius_m = 2e-3;
    }
    let of = |robot: &Robot, twist| {
        Feedforward::of(robot, dc, twist, &scenario.world)
            .expect("a model")
            .ks_v
    };
    let force_n =
        2.0_f64.sqrt() * 0.2 * robot.mass_kg() * 9.81 * 2e-3 / robot.wheels[0].rollers[0].radius_m;
    let by_hand = 12.0 * force_n * radius_m / 4.0 / 2.0;
    let left = of(&robot, Twist::new(0.0, 1.0, 0.0));
    assert!((left / by_hand - 1.0).abs() < 1e-6, "{left} {by_hand}");
    assert!(of(&robot, Twist::new(1.0, 0.0, 0.0)).abs() < 1e-9);
    // A floor with a drag of 0.02 of the load resists any straight motion with 0.02 m g, rho / 4 of
    // it at each wheel.
    let (carpet, robot, _) = under(&["world.floor.rolling_resistance=0.02"]);
    let by_hand = 12.0 * 0.02 * robot.mass_kg() * 9.81 * radius_m / 4.0 / 2.0;
    for way in [Twist::new(1.0, 0.0, 0.0), Twist::new(0.0, 1.0, 0.0)] {
        let found = Feedforward::of(&robot, dc, way, &carpet.world).expect("a model");
        assert!(
            (found.ks_v / by_hand - 1.0).abs() < 1e-9,
            "{found:?} {by_hand}"
        );
    }
}

/// PathPlannerLib's reading of the file: at the top speed no torque is left, at rest the motor
/// gives the friction limit.
#[test]
fn files_say_what_the_planners_read() {
    let (_, robot, limits) = under(&[]);
    let swerve = Swerve::of(&robot, &limits).expect("four wheels");
    let settings: Value = serde_json::from_str(&pathplanner(&swerve)).expect("JSON");
    let number = |key: &str| settings[key].as_f64().unwrap_or_else(|| panic!("{key}"));
    // WPILib's NEO: torque per ampere, and the current at a rate on 12 V.
    let (kt, ohm) = (2.6 / 105.0, 12.0 / 105.0);
    let kv = 5676.0 / 60.0 * TAU / (12.0 - ohm * 1.8);
    let rate = number("maxDriveSpeed") / number("driveWheelRadius") * number("driveGearing");
    let lost_a = (12.0 - rate / kv) / ohm;
    assert!(lost_a.abs() < 1e-9, "{lost_a}");
    let torque_n_m = number("driveCurrentLimit") * kt * number("driveGearing");
    let friction_n_m =
        number("wheelCOF") * number("robotMass") / 4.0 * 9.8 * number("driveWheelRadius");
    assert!((torque_n_m / friction_n_m - 1.0).abs() < 1e-9);
    assert_eq!(settings["holonomicMode"], true);
    // One number for one limit: 30 rad/s times 0.05 m over the lever on which its rollers turn,
    // 0.31 m and a hundredth, as in the controllers' parameters.
    let drive = ilon::ros2_control::DriveParameters::of(&robot)
        .expect("it drives")
        .expect("mecanum wheels");
    let yaw_rate_rad_s = 1.0 / drive.share(Twist::new(0.0, 0.0, 1.0));
    assert!((number("defaultMaxAngVel").to_radians() / yaw_rate_rad_s - 1.0).abs() < 1e-12);
    assert!(
        (yaw_rate_rad_s / (30.0 * 0.05 / 0.31) - 0.99).abs() < 2e-3,
        "{yaw_rate_rad_s}"
    );
    for (key, sign_x, sign_y) in [
        ("fl", 1.0, 1.0),
        ("fr", 1.0, -1.0),
        ("bl", -1.0, 1.0),
        ("br", -1.0, -1.0),
    ] {
        assert!(sign_x * number(&format!("{key}ModuleX")) > 0.0);
        assert!(sign_y * number(&format!("{key}ModuleY")) > 0.0);
    }
    let project: Value = serde_json::from_str(&choreo(&swerve)).expect("JSON");
    assert_eq!(project["version"], 2);
    let config = project["config"].as_object().expect("a table");
    for key in [
        "frontLeft",
        "backLeft",
        "mass",
        "inertia",
        "gearing",
        "radius",
        "vmax",
        "tmax",
        "cof",
        "bumper",
        "differentialTrackWidth",
    ] {
        assert!(config.contains_key(key), "{key}");
    }
    assert_eq!(config["mass"]["val"].as_f64(), Some(swerve.mass_kg));
    let motor_n_m = config["tmax"]["val"].as_f64().expect("a number");
    assert!((motor_n_m / friction_n_m - 1.0).abs() < 1e-9);
}

#[test]
fn files_are_written_and_robots_that_are_no_swerve_drive_are_refused() {
    let folder = Folder::new();
    std::fs::copy(ROBOT, folder.path("mecanum4.urdf")).expect("a copy");
    let dc = "motors.dc={ stall_torque_n_m = 2.0, no_load_rate_rad_s = 30.0 }";
    let all = [
        "inspect",
        "mecanum4.urdf",
        "--pathplanner",
        "settings.json",
        "--choreo",
        "a.chor",
    ];
    ended_with(0, &folder.ilon(&all));
    assert!(folder.read("settings.json").contains("wheelCOF"));
    assert!(folder.read("a.chor").contains("generationFeatures"));
    let java = ["inspect", "mecanum4.urdf", "--road-runner", "Params.java"];
    assert!(ended_with(2, &folder.ilon(&java)).contains("motors.dc"));
    let mut with_motors = java.to_vec();
    with_motors.extend(["--set", dc]);
    ended_with(0, &folder.ilon(&with_motors));
    let text = folder.read("Params.java");
    assert!(
        text.contains("public double kS = 0.0000;") && text.contains("* inPerTick;"),
        "{text}"
    );
    // The same motors for Pedro Pathing: without friction the rims turn at 30 rad/s of 50 mm,
    // 1.5 m/s or 59.06 in/s, and nothing stops the robot; sideways its nine rollers lose 2 % of
    // that.
    let mut pedro = vec!["inspect", "mecanum4.urdf", "--pedro", "Constants.java"];
    assert!(ended_with(2, &folder.ilon(&pedro)).contains("motors.dc"));
    pedro.extend(["--set", dc]);
    ended_with(0, &folder.ilon(&pedro));
    let text = folder.read("Constants.java");
    assert!(text.contains(".mass(11.360)"), "{text}");
    let number = |key: &str| -> f64 {
        let rest = &text[text.find(key).expect(key) + key.len()..];
        rest[..rest.find(')').expect("it ends")]
            .parse()
            .expect("a number")
    };
    // With the bearing friction of the file.
    assert!(
        (number(".xVelocity(") / 59.055 - 1.0).abs() < 0.02,
        "{text}"
    );
    let sideways = number(".yVelocity(") / number(".xVelocity(");
    assert!((sideways / 0.98 - 1.0).abs() < 0.005, "{text}");
    assert!(number(".forwardZeroPowerAcceleration(") <= 0.0, "{text}");
    // Identification results: a floor with drag, and the sideways ratio; settings override them.
    let found = r#"{ "parameters": { "radius_m": { "value": 0.05 }, "world.floor.rolling_resistance": { "value": 0.02 } },
                     "gains": { "sideways_over_ahead": { "value": 0.957 } } }"#;
    folder.write("identified.json", found);
    let mut identified = with_motors.clone();
    identified.extend(["--identified", "identified.json"]);
    ended_with(0, &folder.ilon(&identified));
    let text = folder.read("Params.java");
    assert!(text.contains("lateralInPerTick = 0.95700 *"), "{text}");
    // 12 V of 2 N m for 0.02 of 11.36 kg on four wheels of 0.05 m.
    assert!(text.contains("public double kS = 0.1672;"), "{text}");
    identified.extend(["--set", "world.floor.rolling_resistance=0"]);
    ended_with(0, &folder.ilon(&identified));
    assert!(
        folder
            .read("Params.java")
            .contains("public double kS = 0.0000;")
    );
    let mut none = with_motors.clone();
    none.extend(["--identified", "Params.java"]);
    assert!(ended_with(2, &folder.ilon(&none)).contains("is no `identified.json`"));
    // Three wheels.
    let three = ["inspect", "robot.urdf", "--choreo", "b.chor"];
    assert!(ended_with(2, &folder.ilon(&three)).contains("four wheels"));
    // If a robot cannot even stand, planner files are refused: with zeros they would not drive.
    let steep = ["--set", "world.floor.slope_deg=40", "--set", dc];
    for file in [
        &["--road-runner", "Steep.java"][..],
        &["--limits", "--ros2-controllers", "steep.yaml"],
        &["--pathplanner", "steep.json"],
    ] {
        let asked = [&["inspect", "mecanum4.urdf"][..], file, &steep].concat();
        let said = ended_with(2, &folder.ilon(&asked));
        assert!(said.contains("cannot") && said.contains("stand"), "{said}");
        assert!(!folder.path(file[file.len() - 1]).exists());
    }
    // Each implies the limits, as identification results do.
    for alone in [["--choreo", "c.chor"], ["--identified", "identified.json"]] {
        let inspected = folder.ilon(&["inspect", "mecanum4.urdf", alone[0], alone[1]]);
        ended_with(0, &inspected);
        let words = stdout(&inspected);
        assert!(words.contains("accelerations without slip"), "{words}");
    }
}
