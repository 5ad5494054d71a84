//! `ilon explain`: the causes in a scenario, each by a run without it, and the effects of common
//! suspects on a robot; `ilon run` of a robot alone.

use crate::support;

use support::{Folder, ended_with};

fn summary(folder: &Folder, of: &str) -> serde_json::Value {
    serde_json::from_str(&folder.read(&format!("{of}/summary.json"))).expect("JSON")
}

/// The reported effect of a fault is the difference from the same command's run without it.
#[test]
fn a_cause_is_told_by_the_run_without_it() {
    let folder = Folder::new();
    let push = "[[faults]]\npush = { impulse_y_n_s = 10, from_s = 0.4 }\n";
    folder.scenario("pushed.toml", push);
    folder.scenario("alone.toml", "");
    let json = |arguments: &[&str]| -> serde_json::Value {
        let output = folder.ilon(arguments);
        ended_with(0, &output);
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    let found = json(&["explain", "pushed.toml", "--json", "--out", "explained"]);
    let alone = json(&[
        "run",
        "alone.toml",
        "--json",
        "--no-twins",
        "--out",
        "alone",
    ]);
    let causes = found["causes"].as_array().expect("a list");
    let push = causes.iter().find(|cause| cause["cause"] == "faults.0");
    let push = push.expect("the push is a cause");
    assert_eq!(push["words"], "the push of 10 N s at 0.40 s");
    assert_eq!(push["differs"], true);
    let effects = push["effects"].as_array().expect("a list");
    let place = effects.iter().find(|effect| effect["key"] == "end_y_m");
    assert_eq!(place.expect("a place")["without"], alone["end_y_m"]);
    // The largest first.
    let apart = |cause: &serde_json::Value| cause["apart"]["most_m"].as_f64().expect("a length");
    assert!(
        causes
            .windows(2)
            .all(|two| apart(&two[0]) >= apart(&two[1]))
    );
    // The page and the summary agree.
    let summary = summary(&folder, "explained");
    let told = summary["effects"].as_array().expect("a list");
    assert!(told.iter().any(|effect| effect["cause"] == "sliding"));
    assert!(
        folder
            .read("explained/report.html")
            .contains("id=\"causes\"")
    );
}

/// A wheel of four that rolls 1 % less turns an omnidirectional robot by a known amount: its row of
/// the inverse of M is a quarter of each motion.
#[test]
fn what_is_seen_of_a_robot_is_laid_at_a_wheel() {
    let folder = Folder::new();
    let robot = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/mecanum4.urdf"
    );
    let json = |arguments: &[&str]| -> serde_json::Value {
        let output = folder.ilon(arguments);
        ended_with(0, &output);
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    let found = json(&[
        "explain",
        robot,
        "--json",
        "--seen",
        "back 5 mm/m, left 12.8 mm/m, turn 0.92 deg/m",
    ]);
    let best = &found["suspects"][0];
    // Twice the effect of 1 %; a run with 2 % was made, in which the wheel contributes a quarter of
    // the motion.
    assert_eq!(best["words"], "front_left 2 % smaller than in its file");
    let times = best["times"].as_f64().expect("a number");
    assert!((times - 2.0).abs() < 0.05, "{times}");
    let ahead = best["drifts"][0]["ahead_m"].as_f64().expect("a number");
    // The path bends: the drift to the left times the heading, of the order of 13 mm/m times
    // 0.016 rad.
    assert!((ahead + 0.005).abs() < 5e-4, "{ahead}");
    // The same robot after 3 m on its circle: after one metre half of its turn has moved it to the
    // left too.
    let (way_m, turned) = (3.0, 3.0 * 0.92f64.to_radians());
    let to_the_left = 0.0128 - 0.5 * 0.92f64.to_radians();
    let (along, across) = (turned.sin() / turned, (1.0 - turned.cos()) / turned);
    let ahead_m = way_m * (0.995 * along - to_the_left * across) - way_m;
    let left_m = way_m * (0.995 * across + to_the_left * along);
    let seen = format!(
        "ahead {} mm, left {} mm, turn {} rad over 3 m",
        1e3 * ahead_m,
        1e3 * left_m,
        turned
    );
    let found = json(&["explain", robot, "--json", "--seen", &seen]);
    let best = &found["suspects"][0];
    assert_eq!(best["wheel"], "front_left");
    let (times, share) = (best["times"].as_f64(), best["explains"].as_f64());
    assert!((times.expect("a number") - 2.0).abs() < 0.06, "{times:?}");
    // The start from rest is neglected, and the figures of 1 m have two digits.
    assert!(share.expect("a number") > 0.9, "{share:?}");
}

/// The known loss of a robot with nine rollers, sin(pi / 9) / (pi / 9) of the motion to the left,
/// needs no cause; a larger wheel and a shorter lever are recognised.
#[test]
fn causes_explain_what_is_beyond_the_robot_in_order_and_both_ways() {
    let folder = Folder::new();
    let robot = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/mecanum4.urdf"
    );
    let says = |seen: &str| ended_with(0, &folder.ilon(&["explain", robot, "--seen", seen]));
    let all = says("left: short 20.3 mm/m");
    assert!(all.contains("nothing to explain"), "{all}");
    // The loss is 20.18 mm/m over whole turns of a wheel; the run of some metres ends within one.
    let drifts = all
        .split("drifts by ")
        .nth(1)
        .and_then(|rest| rest.split(" mm/m").next());
    let drifts_mm: f64 = drifts.expect("a drift").parse().expect("a number");
    assert!((drifts_mm - 20.18).abs() < 0.5, "{all}");
    // A creeping floor keeps its creep under the dust.
    let creeping = ["explain", robot, "--set", "world.floor.creep=0.1"];
    let all = ended_with(0, &folder.ilon(&creeping));
    // What rounds to zero is too small to tell.
    let zeros = ["+0.0", "-0.0", "+0.00", "-0.00"];
    assert!(
        !all.split_whitespace().any(|word| zeros.contains(&word)),
        "{all}"
    );
    assert!(
        all.contains("dust under front_left") && !all.contains("refused"),
        "{all}"
    );
    let all = says("ahead 50 mm/m");
    assert!(
        all.contains("all wheels 5 % larger than the controller takes them for"),
        "{all}"
    );
    // Motors far below their limits show no weakness.
    let unseen = all.split("not ruled out").nth(1);
    let is_weak = |text: &str| text.contains("the motor of a wheel 10 % weaker");
    assert!(unseen.is_some_and(is_weak), "{all}");
    let all = says("turn: turn -36 deg/turn");
    assert!(
        all.contains("a lever that the controller takes for 9.1 % too short"),
        "{all}"
    );
}

/// A steered wheel that stands 2 degrees to the left of where it is taken to stand turns a tricycle
/// with its axle l = 0.45 m behind by tan(2 deg) / l per metre, less what its servo gives way to
/// the scrub of its tyre: up to 0.005 rad, a seventh. Motions that tyres exclude have no column.
#[test]
fn a_steered_wheel_off_its_zero_is_a_suspect() {
    let folder = Folder::new();
    let robot = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/tricycle.urdf"
    );
    let printed = ended_with(0, &folder.ilon(&["explain", robot]));
    let excluded = ["diagonal", "refused"];
    assert!(
        !excluded.iter().any(|word| printed.contains(word)),
        "{printed}"
    );
    let output = folder.ilon(&["explain", robot, "--json"]);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let suspects = found["suspects"].as_array().expect("suspects");
    let words = "drive turned by 2° more to the left than the controller takes it for";
    let suspect = suspects
        .iter()
        .find(|one| one["words"] == words)
        .expect("it is one");
    let turned_rad = suspect["drifts"][0]["turned_rad"]
        .as_f64()
        .expect("a number");
    let share = turned_rad / (2_f64.to_radians().tan() / 0.45);
    assert!((0.85..1.0).contains(&share), "{share}");
}

#[test]
fn what_cannot_be_seen_is_refused() {
    let folder = Folder::new();
    let robot = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/mecanum4.urdf"
    );
    let twice = [
        "explain",
        robot,
        "--seen",
        "left 3 mm/m",
        "--seen",
        "turn 1 deg/m",
    ];
    let printed = ended_with(2, &folder.ilon(&twice));
    assert!(printed.contains("`ahead` was given twice"), "{printed}");
    for (arguments, said) in [
        (["explain", robot, "--seen", "up 3 mm/m"], "is no drift"),
        (
            ["explain", robot, "--seen", "turn 4 deg/turn"],
            "is no drift",
        ),
        (
            ["explain", "good.toml", "--seen", "left 3 mm/m"],
            "this is a scenario",
        ),
    ] {
        let printed = ended_with(2, &folder.ilon(&arguments));
        assert!(printed.contains(said), "{printed}");
    }
}

/// A robot alone is driven in five motions; the written scenarios can be run again, and are not
/// overwritten once changed.
#[test]
fn a_robot_alone_is_driven_in_five_motions() {
    let folder = Folder::new();
    let printed = ended_with(0, &folder.ilon(&["run", "robot.urdf", "--no-report"]));
    for motion in ["ahead", "left", "diagonal", "arc", "turn"] {
        assert!(printed.contains(motion), "{printed}");
        let summary = folder.read(&format!("out/robot/{motion}/summary.json"));
        assert!(summary.contains("twist_ratio_asked"));
    }
    ended_with(
        0,
        &folder.ilon(&["run", "out/robot/left.toml", "--no-report", "--no-twins"]),
    );
    folder.write("out/robot/left.toml", "# mine\n");
    let refused = ended_with(2, &folder.ilon(&["run", "robot.urdf", "--no-report"]));
    assert!(
        refused.contains("was not written by this command"),
        "{refused}"
    );
    let refused = ended_with(2, &folder.ilon(&["run", "good.toml", "robot.urdf"]));
    assert!(refused.contains("is a robot, not a scenario"), "{refused}");
}

/// A note on one of the motions stands under its name, a note on all of them once without a name.
#[test]
fn notes_of_a_robot_alone_say_which_motion_they_are_of() {
    let folder = Folder::new();
    let ice = ["--set", "world.floor.friction=0.02"];
    // Hubs rise and fall where rollers are too short to meet: a note on the robot.
    let short = ["--set", "rollers.length_factor=0.8"];
    let robot = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/mecanum4.urdf"
    );
    let command = ["run", robot, "--no-report", "--no-twins"];
    let printed = ended_with(0, &folder.ilon(&[&command[..], &ice, &short].concat()));
    let notes = printed
        .lines()
        .filter_map(|line| line.strip_prefix("note: "));
    let notes: Vec<&str> = notes.collect();
    let motions = ["ahead", "left", "diagonal", "arc", "turn"];
    let is_named = |note: &&&str| {
        motions
            .iter()
            .any(|name| note.starts_with(&format!("`{name}`: ")))
    };
    let too_fast = notes
        .iter()
        .filter(|note| note.contains("the motion is too fast"));
    assert!(too_fast.clone().count() > 1, "{printed}");
    assert!(too_fast.clone().all(|note| is_named(&note)), "{printed}");
    let of_all: Vec<_> = notes.iter().filter(|note| !is_named(note)).collect();
    assert!(!of_all.is_empty(), "{printed}");
    for note in &of_all {
        let twice = notes.iter().filter(|other| other.ends_with(**note));
        assert_eq!(twice.count(), 1, "{printed}");
    }
}

/// What is set beside a robot is written into its scenarios: run again they give the same run, to
/// the last digit of every figure.
#[test]
fn the_scenarios_of_a_robot_alone_hold_what_was_set() {
    let folder = Folder::new();
    let set = [
        "--set",
        "world.floor.friction=0.2",
        "--set",
        "run.duration_s=1.5",
    ];
    let run = ["run", "robot.urdf", "--no-report", "--no-twins"];
    ended_with(0, &folder.ilon(&[&run[..], &set].concat()));
    let text = folder.read("out/robot/left.toml");
    assert!(
        text.contains("friction = 0.2") && text.contains("duration_s = 1.5"),
        "{text}"
    );
    // Without how fast this machine was.
    let figures = |path: &str| {
        let text = folder.read(path);
        let mut summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let timing = summary.as_object_mut().expect("figures");
        timing
            .remove("sim_seconds_per_cpu_second")
            .expect("it is timed");
        summary
    };
    let first = figures("out/robot/left/summary.json");
    let again = [
        "run",
        "out/robot/left.toml",
        "--no-report",
        "--no-twins",
        "--out",
        "again",
    ];
    ended_with(0, &folder.ilon(&again));
    assert_eq!(first, figures("again/summary.json"));
}

/// A path that is typed starts from the folder of the person who types it, wherever the scenarios
/// are written: each of them, run again from another folder, finds the file and gives the same run.
#[test]
fn paths_set_beside_a_robot_alone_start_from_the_current_folder() {
    let folder = Folder::new();
    let square = "v -20 -20 0\nv 20 -20 0\nv 20 20 0\nv -20 20 0\nf 1 2 3\nf 1 3 4\n";
    folder.write("maps/flat.obj", square);
    let map = "world.floor.height_map={ file = \"maps/flat.obj\", cell_m = 1 }";
    let set = ["--set", map, "--set", "run.duration_s=0.2"];
    let run = ["run", "robot.urdf", "--no-report", "--no-twins"];
    ended_with(0, &folder.ilon(&[&run[..], &set].concat()));
    let mut again = folder.command(&["run", "left.toml", "--no-report", "--no-twins"]);
    again.args(["--out", "again"]);
    again.current_dir(folder.path("out/robot"));
    ended_with(0, &again.output().expect("it starts"));
    let hash = |of: &str| summary(&folder, of)["trace_hash"].clone();
    assert!(hash("out/robot/left").is_string());
    assert_eq!(hash("out/robot/left"), hash("out/robot/again"));
}

/// Settings are checked with the motions that they are for, of several seconds each.
#[test]
fn a_robot_alone_takes_what_lasts_longer_than_a_second() {
    let folder = Folder::new();
    let late = ["--set", "sensors.pose.latency_s=1.5"];
    let run = ["run", "robot.urdf", "--no-report", "--no-twins"];
    ended_with(0, &folder.ilon(&[&run[..], &late].concat()));
}

/// A setting that only the world can refuse leaves no scenario behind.
#[test]
fn a_robot_alone_with_a_refused_setting_writes_nothing() {
    let folder = Folder::new();
    for (set, named) in [
        (
            "world.floor.height_map={ file = \"none.png\", cell_m = 1, height_m = 1 }",
            "none.png",
        ),
        ("motors.wheels.nobody.forwards=0.9", "`nobody`"),
    ] {
        let refused = ended_with(2, &folder.ilon(&["run", "robot.urdf", "--set", set]));
        assert!(refused.contains(named), "{refused}");
        assert!(!folder.path("out").exists());
    }
}
