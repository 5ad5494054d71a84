//! Robots on tyres at the command's edges: what is printed, pages, exports, controllers, planners.

use serde_json::Value;
use test_case::test_case;

use crate::support::{Folder, ended_with, python};

const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");

fn robot(name: &str) -> String {
    format!("{ROBOTS}/{name}")
}

fn printed(folder: &Folder, command: &[&str]) -> String {
    let output = folder.ilon(command);
    ended_with(0, &output);
    String::from_utf8(output.stdout).expect("text")
}

/// Nothing that is said of a robot on tyres is said of rollers, and no speed is infinite.
#[test_case("differential.urdf")]
#[test_case("skid4.urdf")]
#[test_case("swerve4.urdf")]
#[test_case("tricycle.urdf")]
#[test_case("tricycle.toml")]
fn neither_text_nor_page_speaks_of_rollers(name: &str) {
    let folder = Folder::new();
    let text = printed(&folder, &["inspect", &robot(name), "--html", "page.html"]);
    let about = text.split("remarks on the file").next().expect("text");
    assert!(!about.contains("roller"), "{about}");
    assert!(about.contains("rank of all rows"), "{about}");
    let page = std::fs::read_to_string(folder.path("page.html")).expect("a page");
    let said = page.split("id=\"remarks\"").next().expect("text");
    let said = said
        .split("<script")
        .map(|part| part.split("</script>").last().unwrap_or(part));
    let said: String = said.collect();
    for word in [
        "inf m/s",
        "rollers 1",
        "touching roller",
        "NaN",
        "axis of the roller",
    ] {
        assert!(!said.contains(word), "{name}: {word}");
    }
}

/// Where the axle is 0.2 m behind the origin, and the steered wheel 0.45 m ahead of it.
#[test]
fn what_tyres_hold_is_in_the_data() {
    let folder = Folder::new();
    let text = printed(&folder, &["inspect", &robot("tricycle.urdf"), "--json"]);
    let seen: Value = serde_json::from_str(&text).expect("JSON");
    let tyres = &seen["tyres"];
    assert_eq!(tyres["reachable_twists"], 2);
    assert_eq!(
        tyres["rows"][1]["wheels"],
        serde_json::json!(["left", "right"])
    );
    assert_eq!(tyres["rows"][1]["row"], serde_json::json!([0.0, 1.0, -0.2]));
    let radius_m = tyres["turning_radius_m"].as_f64().expect("a radius");
    assert!((radius_m - 0.45 / 1.3_f64.tan()).abs() < 1e-9);
    assert_eq!(seen["wheels"][0]["rollers"], 0);
    assert_eq!(seen["wheels"][0]["tyre"]["width_m"], 0.03);
}

/// A tricycle that drives 30 degrees to the left of its frame's x: `ilon run` has no motion for it.
#[test]
fn a_robot_that_no_standard_motion_fits_is_refused() {
    let folder = Folder::new();
    let ahead = std::fs::read_to_string(robot("tricycle.toml")).expect("a shipped robot");
    let mut beside = ahead.replace("\n[[wheels]]", "\n[[wheels]]\naxis_deg = 120");
    let (sin, cos) = std::f64::consts::FRAC_PI_6.sin_cos();
    for (of_ahead, [x, y]) in [
        ("[0.25, 0]", [0.25, 0.0]),
        ("[-0.2, 0.18]", [-0.2, 0.18]),
        ("[-0.2, -0.18]", [-0.2, -0.18]),
    ] {
        let turned = [x * cos - y * sin, x * sin + y * cos];
        assert!(beside.contains(of_ahead), "{of_ahead}");
        beside = beside.replace(of_ahead, &format!("{turned:?}"));
    }
    folder.write("beside.toml", &beside);
    let words = ended_with(2, &folder.ilon(&["run", "beside.toml", "--no-report"]));
    assert!(
        words.contains("none of the standard motions fits `beside`"),
        "{words}"
    );
    assert!(!folder.path("out").exists(), "{words}");
}

/// A wheel alone is refused in words of tyres.
#[test]
fn one_wheel_on_a_tyre_is_refused_as_such() {
    let folder = Folder::new();
    let output = folder.ilon(&[
        "inspect",
        &robot("differential.urdf"),
        "--tyres",
        "--wheels",
        "left",
    ]);
    ended_with(2, &output);
    let words = String::from_utf8_lossy(&output.stderr).replace("\n  │ ", " ");
    assert!(words.contains("1 wheel to roll on a tyre"), "{words}");
    assert!(!words.contains("three"), "{words}");
}

fn exported(folder: &Folder, name: &str, options: &[&str]) -> Vec<Value> {
    let robot = robot(name);
    let command = [&["export", &robot, "--json", "--out", "there"], options].concat();
    serde_json::from_str(&printed(folder, &command)).expect("JSON")
}

/// The exported files drive as the robot does, and the URDF is read as a robot on the same tyres.
#[test_case("differential.urdf", 2)]
#[test_case("skid4.urdf", 4)]
#[test_case("swerve4.urdf", 4)]
#[test_case("offset4.urdf", 4)]
#[test_case("tricycle.urdf", 3)]
fn tyres_are_exported_by_where_they_touch(name: &str, wheels: usize) {
    let folder = Folder::new();
    for format in exported(&folder, name, &["--mjcf", "--sdf", "--urdf"]) {
        // MuJoCo's contacts of a cylinder are two, and a tyre touches at three places.
        let shape = match format["format"] == "mjcf" {
            true => "3 ellipsoids",
            false => "a cylinder",
        };
        assert_eq!(format["shapes"], serde_json::json!([shape]));
        // Their lowest line is the tyre's.
        assert!(format["fit_error_mm"].as_f64().expect("a number") < 1e-9);
        for drive in format["drives"].as_array().expect("drives") {
            let of = |key: &str| drive[key].as_f64().expect("a number");
            assert!(
                (of("expected") - 1.0).abs() + (of("as_made") - 1.0).abs() < 1e-9,
                "{drive}"
            );
        }
    }
    let stem = name.trim_end_matches(".urdf");
    let file = format!("there/{stem}.urdf");
    let read = printed(&folder, &["inspect", &file, "--json"]);
    let there = printed(&folder, &["inspect", &robot(name), "--json"]);
    let [read, there] =
        [read, there].map(|text| serde_json::from_str::<Value>(&text).expect("JSON"));
    assert_eq!(read["wheels"].as_array().expect("wheels").len(), wheels);
    for key in ["width_m", "shoulder_radius_m"] {
        let of = |seen: &Value| seen["wheels"][0]["tyre"][key].as_f64().expect("a number");
        assert!((of(&read) - of(&there)).abs() < 1e-12, "{key}");
    }
    let mass = |seen: &Value| seen["mass_kg"].as_f64().expect("a mass");
    assert!((mass(&read) - mass(&there)).abs() < 1e-9);
}

/// MuJoCo at a step of 2 ms is within 0.1 % of ilon, also where tyres slide: a contact's friction
/// there is Coulomb's as long as what slides hardly moves the load.
#[test_case("differential.urdf")]
#[test_case("skid4.urdf")]
#[test_case("swerve4.urdf")]
#[test_case("offset4.urdf")]
#[test_case("tricycle.urdf")]
fn mujoco_drives_a_robot_on_tyres_as_ilon_does(name: &str) {
    if python("mujoco").is_none() {
        return;
    }
    let folder = Folder::new();
    let formats = exported(&folder, name, &["--mjcf", "--verify"]);
    for drive in formats[0]["drives"].as_array().expect("drives") {
        let of = |key: &str| drive[key].as_f64().expect("a number");
        assert!((of("measured") - of("ilon")).abs() < 1e-3, "{drive}");
        // Nothing hops: 0.05 to 0.2 mm where contacts push apart as they slide.
        assert!(of("travel_mm") < 0.01, "{drive}");
    }
}

/// Geometry of the files: 0.34 m between the wheels; 0.45 m from the axle to the steered wheel.
#[test]
fn controllers_get_the_geometry_of_the_tyres() {
    let folder = Folder::new();
    let yaml = |name: &str| {
        printed(
            &folder,
            &["inspect", &robot(name), "--ros2-controllers", "c.yaml"],
        );
        std::fs::read_to_string(folder.path("c.yaml")).expect("YAML")
    };
    for (name, lines) in [
        (
            "differential.urdf",
            &[
                "diff_drive_controller/DiffDriveController",
                "wheel_separation: 0.340000",
                "wheel_radius: 0.060000",
            ][..],
        ),
        (
            "skid4.urdf",
            &[
                "wheel_separation: 0.400000",
                "wheel_separation_multiplier",
                "[\"front_left\", \"rear_left\"]",
            ],
        ),
        (
            "tricycle.urdf",
            &[
                "tricycle_controller/TricycleController",
                "wheelbase: 0.450000",
                "traction_joint_name: \"drive\"",
                "steering_joint_name: \"steer\"",
                "max_position: 1.300000",
                "(-0.200000, 0.000000) m",
            ],
        ),
    ] {
        let text = yaml(name);
        for line in lines {
            assert!(text.contains(line), "{name}: {line}\n{text}");
        }
    }
    let output = folder.ilon(&[
        "inspect",
        &robot("swerve4.urdf"),
        "--ros2-controllers",
        "c.yaml",
    ]);
    ended_with(2, &output);
}

/// A car: two steered wheels ahead, two driven behind; with one of each it is a bicycle.
#[test_case(&[("fl", 0.3, 0.2, true), ("fr", 0.3, -0.2, true), ("rl", -0.1, 0.2, false), ("rr", -0.1, -0.2, false)],
    &["ackermann_steering_controller/AckermannSteeringController", "traction_joints_names: [\"rr\", \"rl\"]",
      "steering_joints_names: [\"fr_steer\", \"fl_steer\"]", "wheelbase: 0.400000", "traction_track_width: 0.400000"]; "a car")]
#[test_case(&[("f", 0.3, 0.0, true), ("rl", -0.1, 0.2, false), ("rr", -0.1, -0.2, false)],
    &["tricycle_steering_controller/TricycleSteeringController", "traction_wheels_radius: 0.050000"]; "a tricycle driven behind")]
#[test_case(&[("f", 0.3, 0.0, true), ("r", -0.1, 0.0, false)],
    &["bicycle_steering_controller/BicycleSteeringController", "traction_wheel_radius: 0.050000"]; "a bicycle")]
fn steering_controllers_are_chosen_by_the_wheels(
    wheels: &[(&str, f64, f64, bool)],
    lines: &[&str],
) {
    let folder = Folder::new();
    let mut text = "name = \"car\"\n[chassis]\nshape.box.size_m = [0.5, 0.3, 0.1]\nmass_kg = 10\ncenter_m = [0.1, 0, 0.2]\n\
                    [tyres]\nradius_m = 0.05\nwidth_m = 0.03\nmass_kg = 0.5\nmotor_effort_n_m = 5\nmotor_velocity_rad_s = 30\n\
                    [steering]\nfork_mass_kg = 0.5\neffort_n_m = 5\nvelocity_rad_s = 5\nlimit_deg = 45\n"
        .to_owned();
    for (name, x, y, steered) in wheels {
        text += &format!(
            "[[wheels]]\nname = \"{name}\"\nposition_m = [{x}, {y}]\nsteered = {steered}\ndriven = {}\n",
            !steered
        );
    }
    if wheels.len() == 2 {
        text += "[[casters]]\nname = \"side\"\nposition_m = [0.1, 0.2]\nradius_m = 0.03\nwidth_m = 0.02\nmass_kg = 0.1\nfork_mass_kg = 0.1\ntrail_m = 0.02\n";
    }
    folder.write("car.toml", &text);
    printed(
        &folder,
        &["inspect", "car.toml", "--ros2-controllers", "c.yaml"],
    );
    let yaml = std::fs::read_to_string(folder.path("c.yaml")).expect("YAML");
    for line in lines {
        assert!(yaml.contains(line), "{line}\n{yaml}");
    }
}

/// The modules stand at (+-0.25, +-0.2) m, and roll at 0.05 m x 30 rad/s.
#[test]
fn pathplanner_gets_the_modules_of_a_swerve_robot() {
    let folder = Folder::new();
    printed(
        &folder,
        &["inspect", &robot("swerve4.urdf"), "--pathplanner", "s.json"],
    );
    let text = std::fs::read_to_string(folder.path("s.json")).expect("settings");
    let settings: Value = serde_json::from_str(&text).expect("JSON");
    for (key, expected) in [
        ("flModuleX", 0.25),
        ("flModuleY", 0.2),
        ("brModuleX", -0.25),
        ("maxDriveSpeed", 1.5),
        ("robotMass", 26.0),
    ] {
        let found = settings[key].as_f64().expect(key);
        assert!((found - expected).abs() < 1e-9, "{key}: {found}");
    }
    // 0.9 of the friction 0.6, in units of the planner's gravity.
    let friction = settings["wheelCOF"].as_f64().expect("friction");
    assert!(
        (friction - 0.9 * 0.6 * 9.81 / 9.8).abs() < 1e-9,
        "{friction}"
    );
    let output = folder.ilon(&["inspect", &robot("tricycle.urdf"), "--choreo", "s.chor"]);
    ended_with(2, &output);
}

/// Steering axes at (+-0.25, +-0.19) m stand still, wheels 45 mm further out do not: they roll at
/// 0.09 m x 20 rad/s that much further from the middle.
#[test]
fn pathplanner_gets_the_steering_axes_of_offset_modules() {
    let folder = Folder::new();
    let offset4 = robot("offset4.urdf");
    printed(&folder, &["inspect", &offset4, "--pathplanner", "s.json"]);
    let text = std::fs::read_to_string(folder.path("s.json")).expect("settings");
    let settings: Value = serde_json::from_str(&text).expect("JSON");
    let top_rad_s = 1.8 / (0.25_f64.hypot(0.19) + 0.045);
    for (key, expected) in [
        ("flModuleX", 0.25),
        ("flModuleY", 0.19),
        ("brModuleY", -0.19),
        ("defaultMaxAngVel", top_rad_s.to_degrees()),
    ] {
        let found = settings[key].as_f64().expect(key);
        assert!((found - expected).abs() < 1e-9, "{key}: {found}");
    }
}
