//! Options of the command line, each with its effect.

use crate::support;

use serde_json::Value;
use support::{FAILS, Folder, ended_with, stdout};

/// A base with four plain wheels of 50 mm; `NAME` is the prefix of a wheel joint's name, before its
/// place.
fn base(name: &str, geometry: &str, inertia: &str) -> String {
    let wheel = |place: &str, x: f64, y: f64| {
        format!(
            "<link name=\"{place}_link\"><inertial><mass value=\"0.5\"/>{inertia}</inertial><collision>\
             <origin rpy=\"1.5707963267948966 0 0\"/><geometry>{geometry}</geometry></collision></link>\
             <joint name=\"{name}{place}\" type=\"continuous\"><parent link=\"base_link\"/><child link=\"{place}_link\"/>\
             <origin xyz=\"{x} {y} 0\"/><axis xyz=\"0 1 0\"/><limit effort=\"3\" velocity=\"20\"/></joint>\n"
        )
    };
    let places = [
        ("fl", 0.15, 0.13),
        ("fr", 0.15, -0.13),
        ("rl", -0.15, 0.13),
        ("rr", -0.15, -0.13),
    ];
    let wheels: String = places
        .iter()
        .map(|(place, x, y)| wheel(place, *x, *y))
        .collect();
    format!(
        "<robot name=\"base\"><link name=\"base_link\"><inertial><mass value=\"8\"/>\
         <inertia ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.15\"/></inertial>\
         <collision><origin xyz=\"0 0 0.05\"/><geometry><box size=\"0.4 0.2 0.06\"/></geometry></collision></link>\n{wheels}</robot>"
    )
}

const DISC: &str = "<cylinder radius=\"0.05\" length=\"0.04\"/>";
const INERTIA: &str =
    "<inertia ixx=\"4e-4\" ixy=\"0\" ixz=\"0\" iyy=\"6e-4\" iyz=\"0\" izz=\"4e-4\"/>";

/// The output of `ilon inspect --json` for a file with options.
fn inspected(folder: &Folder, arguments: &[&str]) -> Value {
    let output = folder.ilon(&[&["inspect"], arguments, &["--json"]].concat());
    ended_with(0, &output);
    serde_json::from_str(&stdout(&output)).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

const X: [&str; 4] = ["--rollers", "10", "--gamma-x-deg", "45"];

#[test]
fn rollers_that_are_given_have_the_radius_and_the_mass_that_are_asked_for() {
    let folder = Folder::new();
    folder.write("base.urdf", &base("", DISC, INERTIA));
    let plain = inspected(&folder, &[&["base.urdf"], &X[..]].concat());
    let more = ["--roller-radius-m", "0.014", "--roller-mass-kg", "0.03"];
    let other = inspected(&folder, &[&["base.urdf"], &X[..], &more[..]].concat());
    let radius_m = |robot: &Value| number(&robot["wheels"][0]["roller_radius_m"]);
    assert!((radius_m(&plain) - 0.014).abs() > 1e-3);
    assert!((radius_m(&other) - 0.014).abs() < 1e-12);
    // The rollers' mass is taken from the wheel's: the total is that of the file.
    assert!((number(&other["mass_kg"]) - 10.0).abs() < 1e-9);
    folder.ilon(
        &[
            &["inspect", "base.urdf", "--urdf", "given.urdf"],
            &X[..],
            &more[..],
        ]
        .concat(),
    );
}

#[test]
fn a_radius_that_the_file_does_not_show_can_be_given() {
    let folder = Folder::new();
    let mesh = "<mesh filename=\"nowhere.stl\"/>";
    folder.write("base.urdf", &base("", mesh, INERTIA));
    let arguments = [&["inspect", "base.urdf"], &X[..]].concat();
    ended_with(2, &folder.ilon(&arguments));
    let robot = inspected(
        &folder,
        &[&["base.urdf", "--wheel-radius-m", "0.06"], &X[..]].concat(),
    );
    assert!((number(&robot["wheels"][0]["radius_m"]) - 0.06).abs() < 1e-12);
}

#[test]
fn rollers_that_names_promise_are_given_unless_none_are_to_be() {
    let folder = Folder::new();
    folder.write("base.urdf", &base("mecanum_wheel_", DISC, INERTIA));
    let robot = inspected(&folder, &["base.urdf"]);
    assert!(number(&robot["wheels"][0]["rollers"]) > 0.0);
    let refused = folder.ilon(&["inspect", "base.urdf", "--no-inferred-rollers"]);
    let said = ended_with(2, &refused);
    assert!(said.contains("wheels without rollers"), "{said}");
}

/// A user who gives `run` a robot alone has no scenario to write keys into: the refusal names a
/// command, and that command the one that drives.
#[test]
fn a_lone_robot_without_rollers_is_driven_by_the_printed_commands() {
    let folder = Folder::new();
    folder.write("base.urdf", &base("", DISC, INERTIA));
    let said = ended_with(2, &folder.ilon(&["run", "base.urdf"]));
    let joined = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        joined.contains("`ilon inspect base.urdf --rollers NUMBER"),
        "{said}"
    );
    let given = folder.ilon(&[&["inspect", "base.urdf"], &X[..]].concat());
    let said = ended_with(0, &given);
    assert!(
        said.contains("next: drive it, `ilon run base.urdf --set"),
        "{said}"
    );
}

#[test]
fn a_repair_is_made_when_it_is_asked_for_with_the_density_that_is_given() {
    let folder = Folder::new();
    folder.write("base.urdf", &base("", DISC, ""));
    let arguments = [&["inspect", "base.urdf"], &X[..]].concat();
    ended_with(2, &folder.ilon(&arguments));
    let written = |density: &[&str]| {
        let to = [
            "inspect",
            "base.urdf",
            "--repair",
            "--urdf",
            "repaired.urdf",
        ];
        ended_with(0, &folder.ilon(&[&to[..], &X[..], density].concat()));
        folder.read("repaired.urdf")
    };
    let repaired = written(&[]);
    // The written file is read without a repair.
    ended_with(
        0,
        &folder.ilon(&[&["inspect", "repaired.urdf"], &X[..]].concat()),
    );
    // A wheel's mass and size are known here: the density has no effect.
    assert_eq!(repaired, written(&["--density-kg-m3", "700"]));
    // For a wheel without a mass, the density determines it: pi 0.05^2 0.04 m^3.
    let massless = base("", DISC, "").replace("<mass value=\"0.5\"/>", "");
    folder.write("base.urdf", &massless.replace("<inertial></inertial>", ""));
    let weighs = |density: &[&str]| {
        let robot = inspected(
            &folder,
            &[&["base.urdf", "--repair"], &X[..], density].concat(),
        );
        (number(&robot["mass_kg"]) - 8.0) / 4.0
    };
    let volume_m3 = std::f64::consts::PI * 0.05 * 0.05 * 0.04;
    let (usual_kg, light_kg) = (weighs(&[]), weighs(&["--density-kg-m3", "700"]));
    assert!((usual_kg - 1500.0 * volume_m3).abs() < 1e-6, "{usual_kg}");
    assert!((light_kg - 700.0 * volume_m3).abs() < 1e-6, "{light_kg}");
}

#[test]
fn what_is_missing_is_left_out_when_it_is_asked_for() {
    let folder = Folder::new();
    let include = "<xacro:include filename=\"no_lidar.xacro\"/>";
    let robot = folder.read("robot.urdf");
    let at = robot.find("<link").expect("a link");
    let xacro = format!("{}{include}{}", &robot[..at], &robot[at..]);
    let xacro = xacro.replacen(
        "<robot ",
        "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" ",
        1,
    );
    folder.write("robot.urdf.xacro", &xacro);
    let said = ended_with(2, &folder.ilon(&["inspect", "robot.urdf.xacro"]));
    assert!(said.contains("no_lidar.xacro"), "{said}");
    let said = ended_with(
        0,
        &folder.ilon(&["inspect", "robot.urdf.xacro", "--leave-out-missing"]),
    );
    assert!(
        said.contains("no_lidar.xacro"),
        "what is left out is said: {said}"
    );
}

#[test]
fn inspect_writes_the_urdf_that_it_read_and_what_ros2_control_needs() {
    let folder = Folder::new();
    let more = [
        "--urdf",
        "read.urdf",
        "--ros2-controllers",
        "controllers.yaml",
        "--ros2-control",
        "control.urdf",
    ];
    ended_with(
        0,
        &folder.ilon(&[&["inspect", "robot.urdf"], &more[..]].concat()),
    );
    let of_file = inspected(&folder, &["robot.urdf"]);
    for written in ["read.urdf", "control.urdf"] {
        assert_eq!(
            of_file["wheels"],
            inspected(&folder, &[written])["wheels"],
            "{written}"
        );
    }
    assert!(
        folder
            .read("controllers.yaml")
            .contains("omni_wheel_drive_controller")
    );
    assert!(folder.read("control.urdf").contains("<ros2_control"));
    assert!(!folder.read("read.urdf").contains("<ros2_control"));
}

#[test]
fn a_run_leaves_out_its_report_and_its_words_when_asked() {
    let folder = Folder::new();
    let output = folder.ilon(&["run", "good.toml", "--out", "out", "--no-report", "--quiet"]);
    assert_eq!(ended_with(0, &output), "");
    assert_eq!(
        folder.names("out"),
        ["scenario.toml", "summary.json", "trace.parquet"]
    );
    // Requested output is printed even if quiet.
    let output = folder.ilon(&["run", "good.toml", "--out", "out", "-q", "--json"]);
    ended_with(0, &output);
    let summary: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    assert!(summary["trace_hash"].is_string());
    assert!(folder.path("out/report.html").exists());
}

/// A custom opener, first on the path, records what it is asked to open.
#[cfg(target_os = "linux")]
#[test]
fn a_page_is_opened_once_it_is_written() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    folder.write(
        "bin/xdg-open",
        "#!/bin/sh\necho \"$1\" > opened.part && mv opened.part opened\n",
    );
    let opener = folder.path("bin/xdg-open");
    std::fs::set_permissions(&opener, std::fs::Permissions::from_mode(0o755)).expect("a file");
    let path = format!(
        "{}:{}",
        folder.path("bin").display(),
        std::env::var("PATH").unwrap_or_default()
    );
    folder.write(
        "study.toml",
        "scenario = \"good.toml\"\naxes.world.floor.friction = [0.2]\n",
    );
    for (arguments, out) in [
        (vec!["run", "good.toml", "--out", "out", "--open"], "out"),
        (vec!["report", "out", "--open"], "out"),
        (vec!["sweep", "study.toml", "--open"], "out/study"),
    ] {
        let _ = std::fs::remove_file(folder.path("opened"));
        let output = folder
            .command(&arguments)
            .env("PATH", &path)
            .output()
            .expect("it runs");
        ended_with(0, &output);
        // The command does not wait for the opener.
        let until = std::time::Instant::now() + std::time::Duration::from_secs(60);
        while !folder.path("opened").exists() {
            assert!(
                std::time::Instant::now() < until,
                "{arguments:?}: nothing was opened"
            );
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        let page = folder
            .path(&format!("{out}/report.html"))
            .canonicalize()
            .expect("it is written");
        assert_eq!(folder.read("opened").trim(), page.display().to_string());
    }
    // Without an opener the run still succeeds, and the page's path is printed.
    let output = folder
        .command(&["report", "out", "--open"])
        .env("PATH", "")
        .output();
    let said = ended_with(0, &output.expect("it runs"));
    assert!(
        said.contains("open ") && said.contains("report.html in a browser"),
        "{said}"
    );
}

#[test]
fn a_course_is_as_fast_as_asked_and_makes_known_what_is_asked() {
    let folder = Folder::new();
    let planned = |more: &[&str]| {
        let output =
            folder.ilon(&[&["identify", "--plan", "robot.urdf", "--out", "plan"], more].concat());
        let said = ended_with(0, &output);
        (said, folder.read("plan/wheel_rates.csv"))
    };
    let (slow, slow_rates) = planned(&["--speed", "0.1"]);
    let (fast, fast_rates) = planned(&["--speed", "0.4"]);
    assert!(slow.contains("lever_m") && fast.contains("lever_m"));
    // Three wheels of 50 mm at even angles: the mean of their rates turns the robot, and the
    // squares of the rest add up to 3/2 (v / rho)^2 in any direction.
    let speed_m_s = |csv: &str| {
        let row = |line: &str| {
            let rates = line
                .split(',')
                .skip(1)
                .filter_map(|x| x.parse::<f64>().ok());
            let rates: Vec<f64> = rates.collect();
            let mean = rates.iter().sum::<f64>() / 3.0;
            let squares = rates.iter().map(|rate| (rate - mean).powi(2));
            0.05 * (squares.sum::<f64>() / 1.5).sqrt()
        };
        csv.lines().skip(1).map(row).fold(0.0, f64::max)
    };
    // Rates are written to five decimals.
    assert!((speed_m_s(&slow_rates) - 0.1).abs() < 1e-6, "{slow_rates}");
    assert!((speed_m_s(&fast_rates) - 0.4).abs() < 1e-6, "{fast_rates}");
    let (gains, _) = planned(&["--free", "gain.ahead,gain.turn"]);
    assert!(
        gains.contains("gain.ahead") && !gains.contains("lever_m"),
        "{gains}"
    );
    let refused = folder.ilon(&["identify", "--plan", "robot.urdf", "--free", "colour"]);
    assert!(ended_with(2, &refused).contains("`colour` is not a parameter"));
}

#[test]
fn a_bench_drives_its_wheels_with_the_bandwidth_that_is_asked_for() {
    let folder = Folder::new();
    let measured = |more: &[&str]| {
        let quick = [
            "bench",
            "--robot",
            "robot.urdf",
            "--rates",
            "60",
            "--rollers",
            "near",
            "--rounds",
            "1",
        ];
        let rest = ["--headings", "0", "--json"];
        let output = folder.ilon(&[&quick[..], &rest[..], more].concat());
        ended_with(0, &output);
        let bench: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
        let robot = bench["robots"]
            .as_object()
            .and_then(|robots| robots.values().next());
        number(&robot.expect("a robot")["worst_error_pct"])
    };
    // The drives are slow; the difference is how far the wheels lag while they start, and with it
    // the angles of the rollers.
    assert!(measured(&[]) != measured(&["--bandwidth", "5"]));
}

/// A quiet command prints no messages for the user, but keeps its exit code, its data and failed
/// expectations.
#[test]
fn every_command_knows_to_be_quiet() {
    let folder = Folder::new();
    folder.scenario("failing.toml", FAILS);
    let silent: [&[&str]; 8] = [
        &["run", "good.toml", "--out", "out", "--no-report"],
        &["check", "good.toml"],
        &["inspect", "robot.urdf"],
        &["inspect", "robot.urdf", "--html", "robot.html"],
        &["run", "good.toml", "--out", "other"],
        &["compare", "out", "other", "--out", "compare.html"],
        &["report", "other"],
        &["demo", "shown"],
    ];
    for arguments in silent {
        // Before the command and after it.
        for arguments in [
            [&["-q"], arguments].concat(),
            [arguments, &["--quiet"]].concat(),
        ] {
            let output = folder.ilon(&arguments);
            assert_eq!(ended_with(0, &output), "", "{arguments:?}");
            assert_eq!(stdout(&output), "", "{arguments:?}");
        }
    }
    let output = folder.ilon(&["check", "-q", "good.toml", "failing.toml"]);
    ended_with(1, &output);
    let said = stdout(&output);
    assert!(said.starts_with("FAILED failing "), "{said}");
    assert!(!said.contains("good"), "{said}");
    let output = folder.ilon(&["inspect", "-q", "nowhere.urdf"]);
    assert!(ended_with(2, &output).contains("nowhere.urdf"));
}

#[test]
fn a_check_as_json_names_each_scenario_its_outcome_and_its_bounds() {
    let folder = Folder::new();
    folder.scenario("failing.toml", FAILS);
    folder.write("bad.toml", "robot = 1");
    let output = folder.ilon(&["check", "--json", "failing.toml", "bad.toml"]);
    ended_with(2, &output);
    let all: Value = serde_json::from_str(&stdout(&output)).expect("JSON alone");
    let [failing, bad] = all["scenarios"].as_array().expect("a list").as_slice() else {
        panic!("{all}");
    };
    assert_eq!(failing["outcome"], "failed");
    assert_eq!(failing["bounds"][0]["quantity"], "twist_ratio_contact.vx");
    assert_eq!(failing["bounds"][0]["held"], false);
    // It drives ahead without sliding, as the contact kinematics predicts.
    let measured = failing["bounds"][0]["measured"].as_f64().expect("a number");
    assert!((measured - 1.0).abs() < 0.01, "{measured}");
    assert_eq!(bad["outcome"], "could not run");
    assert!(bad["error"].is_string());
}

/// The answer comes first, then ten figures at most; all of them are printed on request.
#[test]
fn a_run_answers_before_it_lists_figures() {
    let folder = Folder::new();
    let printed = |more: &[&str]| {
        let arguments = [&["run", "good.toml", "--out", "out", "--no-report"], more].concat();
        let output = folder.ilon(&arguments);
        ended_with(0, &output);
        stdout(&output).replace("\n    ", " ")
    };
    let short = printed(&[]);
    let rows = |text: &str| text.lines().filter(|line| line.starts_with("  ")).count();
    assert!((1..=10).contains(&rows(&short)), "{short}");
    let answer = short.lines().next().expect("a line");
    assert!(
        answer.ends_with('.') && answer.contains("it reached"),
        "{short}"
    );
    let long = printed(&["--table"]);
    assert!(rows(&long) > rows(&short), "{long}");
    assert!(long.starts_with(answer), "{long}");
}

/// An option that the command would not read is refused: who gives it expects it to act.
#[test]
fn options_that_would_have_no_effect_are_refused() {
    let folder = Folder::new();
    folder.write("study.toml", "");
    let refused = |arguments: &[&str], words: &str| {
        let said = ended_with(2, &folder.ilon(arguments));
        assert!(said.contains(words), "{arguments:?}: {said}");
    };
    let of_robots = "options of a robot's file are given, and `good.toml` is a scenario";
    for reading in [&["--repair"][..], &X, &["--wheel-radius-m", "0.1"]] {
        refused(&[&["explain", "good.toml"], reading].concat(), of_robots);
        refused(
            &[&["export", "--mjcf", "--scenario", "good.toml"], reading].concat(),
            of_robots,
        );
        refused(
            &[&["export", "--fmu", "good.toml"], reading].concat(),
            of_robots,
        );
    }
    for of_scenarios in [&["--out", "why"][..], &["--open"]] {
        refused(
            &[&["explain", "robot.urdf"], of_scenarios].concat(),
            "--out and --open are about a scenario",
        );
    }
    for of_plans in [["--free", "radius_m"], ["--speed", "0.3"]] {
        refused(
            &[&["identify", "study.toml"][..], &of_plans].concat(),
            "cannot be used with",
        );
    }
}
