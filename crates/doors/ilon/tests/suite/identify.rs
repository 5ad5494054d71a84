//! `ilon identify`: from a proposed course over a bag to the identified robot; invalid logs,
//! Ctrl-C, and the written files.

use crate::support;

use ilon_formats::LoadRobot;
use ilon_robot::Robot;

use std::f64::consts::PI;
use std::process::{Command, Stdio};
use std::time::Duration;

use support::{Folder, ended_with, stdout};

/// The folder's copy of a robot on three omni wheels, as in its description.
fn volksbot(folder: &Folder) {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
    let text = std::fs::read_to_string(format!("{root}/volksbot.toml")).expect("a shipped robot");
    folder.write("known.toml", &text);
    // The true robot: smaller wheels, longer arms.
    let truth = text.replace("radius_m = 0.05\n", "radius_m = 0.0492\n");
    let truth = truth.replace("distance_m = 0.25", "distance_m = 0.26");
    assert_ne!(truth, text);
    folder.write("truth.toml", &truth);
}

/// A log of ideal omni wheels of 49.2 mm at 0.26 m, driven ahead, to the left and turning, as a
/// text table.
fn table() -> String {
    table_of(1.0, 500)
}

/// The same for a robot that moves only a share of its path sideways, with this many rows in each
/// drive except the turning one.
fn table_of(sideways: f64, rows: u32) -> String {
    let (radius_m, lever_m) = (0.0492, 0.26);
    let mut text = "t,x,y,heading,w1,w2,w3\n".to_owned();
    let (mut x, mut y, mut heading, mut wheels) = (0.0, 0.0, 0.0_f64, [0.0; 3]);
    let row_s = 0.02;
    for row in 0..2 * rows + 500 {
        // Tracker noise of 0.1 mm, in a pattern with a long period.
        let noise = |salt: f64| 1e-4 * (f64::from(row) * salt).sin();
        text += &format!(
            "{:.3},{:.6},{:.6},{:.6},{:.5},{:.5},{:.5}\n",
            f64::from(row) * row_s,
            x + noise(91.7),
            y + noise(53.3),
            heading + noise(17.9),
            wheels[0],
            wheels[1],
            wheels[2]
        );
        let [vx, vy, omega] =
            [[0.2, 0.0, 0.0], [0.0, 0.2, 0.1], [0.0, 0.0, 0.6]][(row / rows).min(2) as usize];
        // Wheels at 0, 120 and 240 degrees, the first straight ahead of the middle: each drives
        // along its tangent.
        for (wheel, angle) in wheels.iter_mut().enumerate() {
            let place = wheel as f64 * 2.0 * PI / 3.0;
            let tangent = vy * place.cos() - vx * place.sin() + lever_m * omega;
            *angle -= tangent / radius_m * row_s;
        }
        let vy = sideways * vy;
        let middle = heading + 0.5 * omega * row_s;
        x += (middle.cos() * vx - middle.sin() * vy) * row_s;
        y += (middle.sin() * vx + middle.cos() * vy) * row_s;
        heading += omega * row_s;
    }
    text
}

const STUDY: &str = "\
robot = \"known.toml\"

[log]
time = { column = \"t\", unit = \"s\" }
x = { column = \"x\", unit = \"m\" }
y = { column = \"y\", unit = \"m\" }
heading = { column = \"heading\", unit = \"rad\" }

[log.wheels]
wheel_1 = { column = \"w1\", unit = \"rad\" }
wheel_2 = { column = \"w2\", unit = \"rad\" }
wheel_3 = { column = \"w3\", unit = \"rad\" }

[[runs]]
file = \"log.csv\"
";

fn value(json: &serde_json::Value, name: &str) -> f64 {
    let value = &json["parameters"][name]["value"];
    value.as_f64().unwrap_or_else(|| panic!("{name} in {json}"))
}

/// A course is proposed, the true robot drives it, a bag records it, and the robot is identified
/// from the bag.
#[test]
fn a_proposed_course_recorded_as_a_bag_makes_the_robot_known() {
    let folder = Folder::new();
    volksbot(&folder);
    let planned = folder.ilon(&[
        "identify",
        "--plan",
        "known.toml",
        "--free",
        "radius_m,lever_m",
        "--out",
        "course",
    ]);
    let said = ended_with(0, &planned);
    assert!(said.contains("standard error that it leaves"), "{said}");
    assert_eq!(
        folder.names("course"),
        ["course.json", "waypoints.csv", "wheel_rates.csv"]
    );
    let course: serde_json::Value =
        serde_json::from_str(&folder.read("course/course.json")).expect("JSON");
    assert!(
        course["errors"].is_object() || course["errors"].is_array(),
        "{course}"
    );
    let rows = folder.read("course/wheel_rates.csv");
    let last = rows.lines().last().expect("rows");
    let until_s: f64 = last
        .split(',')
        .next()
        .and_then(|t| t.parse().ok())
        .expect("a time");
    folder.write(
        "drive.toml",
        &format!(
            "[robot]\nfile = \"truth.toml\"\n\n[playback]\nfile = \"course/wheel_rates.csv\"\ndrives = \"wheel_rates\"\n\n\
             [run]\nduration_s = {}\n",
            until_s + 1.0
        ),
    );
    ended_with(
        0,
        &folder.ilon(&[
            "run",
            "drive.toml",
            "--mcap",
            "--no-report",
            "--out",
            "driven",
        ]),
    );
    folder.write(
        "study.toml",
        "robot = \"known.toml\"\n\n[log.bag]\njoints = \"/joint_states\"\npose = \"/ground_truth/odom\"\n\n[[runs]]\nfile = \"driven/bag\"\n\n\
         [[models]]\nname = \"radius and lever\"\nfree = [\"radius_m\", \"lever_m\"]\n",
    );
    let found = folder.ilon(&["identify", "study.toml", "--out", "found", "--json"]);
    let said_of_whole = ended_with(0, &found);
    let json: serde_json::Value = serde_json::from_str(&stdout(&found)).expect("nothing but JSON");
    // Rows of the bag are simultaneous, so that only hand-overs remain: far below a thousandth. Two
    // rows of rollers at 0 mm distance do not change the arm.
    assert!(
        (value(&json, "radius_m") / 0.0492 - 1.0).abs() < 1e-3,
        "{json}"
    );
    assert!(
        (value(&json, "lever_m") / 0.26 - 1.0).abs() < 2e-3,
        "{json}"
    );
    // Its output is a robot and a scenario that run.
    ended_with(
        0,
        &folder.ilon(&[
            "run",
            "found/scenario.toml",
            "--no-report",
            "--out",
            "again",
        ]),
    );
    // A recorder that is killed leaves no footer: the fit says so, as a run of the bag does.
    let bag = folder.path("driven/bag/bag_0.mcap");
    let whole = std::fs::read(&bag).expect("a bag");
    std::fs::write(&bag, &whole[..whole.len() - 20]).expect("a place");
    let cut = ended_with(0, &folder.ilon(&["identify", "study.toml", "--out", "cut"]));
    for (said, is_said) in [(said_of_whole, false), (cut, true)] {
        assert_eq!(said.contains("was cut short"), is_said, "{said}");
    }
}

#[test]
fn a_table_of_text_makes_the_robot_known_and_all_results_are_written() {
    let folder = Folder::new();
    volksbot(&folder);
    folder.write("log.csv", &table());
    folder.write("study.toml", STUDY);
    let output = folder.ilon(&["identify", "study.toml", "--out", "found"]);
    let said = ended_with(0, &output);
    assert!(said.contains("radius_m"), "{said}");
    let json: serde_json::Value =
        serde_json::from_str(&folder.read("found/identified.json")).expect("JSON");
    let lever_m = value(&json, "lever_m");
    // Displacements of 0.2 m per stretch are measured to 0.14 mm, over 30 stretches.
    assert!((lever_m / 0.26 - 1.0).abs() < 2e-3, "{lever_m}");
    let names = folder.names("found");
    for name in [
        "drive.csv",
        "identified.json",
        "report.html",
        "robot.toml",
        "scenario.toml",
    ] {
        assert!(names.iter().any(|known| known == name), "{names:?}");
    }
    // Again, and with another folder name: the same bytes.
    ended_with(
        0,
        &folder.ilon(&["identify", "study.toml", "--out", "again"]),
    );
    assert_eq!(
        folder.read("found/identified.json"),
        folder.read("again/identified.json")
    );
}

/// The sentences of the page and the terminal, which report the same findings: each line except the
/// last one of a suggestion is one.
fn sentences(folder: &Folder, out: &str, printed: &str) -> Vec<String> {
    let page = folder.read(&format!("{out}/report.html"));
    let lead = page.split("<div class=\"story\">").nth(1).expect("a lead");
    let lead = lead.split("</div>").next().unwrap_or_default();
    let plain = |line: &str| {
        let line = line
            .replace("<b>✓</b> ", "")
            .replace("<b class=\"failed\">✗</b> ", "");
        let line = line
            .replace("<p>", "")
            .replace("<code>", "`")
            .replace("</code>", "`")
            .replace("&quot;", "\"")
            .replace("&#39;", "'");
        line.replace("&lt;", "<")
            .replace("&gt;", ">")
            .replace("&amp;", "&")
    };
    let lines: Vec<String> = lead
        .split("</p>")
        .map(plain)
        .filter(|line| !line.is_empty())
        .collect();
    for line in &lines {
        assert!(
            printed.contains(line.as_str()),
            "`{line}` is not in {printed}"
        );
    }
    lines
}

/// The numbers in a sentence.
fn numbers(sentence: &str) -> Vec<f64> {
    let parts = sentence.split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'));
    parts
        .filter_map(|part| part.trim_end_matches('.').parse().ok())
        .collect()
}

fn starting<'l>(lines: &'l [String], with: &str) -> &'l str {
    let line = lines.iter().find(|line| line.starts_with(with));
    line.unwrap_or_else(|| panic!("no line starts with `{with}`: {lines:#?}"))
}

/// A robot with wheels of 49.2 mm instead of 50 at 260 mm instead of 250, which moves 0.96 of its
/// path sideways: the reported behaviour and settings follow in closed form.
#[test]
fn what_the_robot_does_and_what_to_set_is_said_first_with_the_numbers_of_the_truth() {
    let folder = Folder::new();
    volksbot(&folder);
    folder.write("log.csv", &table_of(0.96, 500));
    folder.write("study.toml", STUDY);
    let output = folder.ilon(&["identify", "study.toml", "--out", "found"]);
    ended_with(0, &output);
    let printed = stdout(&output);
    let lines = sentences(&folder, "found", &printed);
    let near = |value: f64, truth: f64, within: f64| {
        assert!(
            (value - truth).abs() <= within,
            "{value} for {truth}: {lines:#?}"
        );
    };
    // 4 % less than ahead, with noise of 0.1 mm on 0.2 m per stretch, over tens of stretches: to a
    // twentieth of a per cent.
    let sideways = numbers(starting(&lines, "Sideways it goes"));
    near(sideways[0], 4.0, 0.1);
    assert!(
        sideways[1] <= sideways[0] && sideways[0] <= sideways[2],
        "{lines:#?}"
    );
    let sideways_line = starting(&lines, "Sideways it goes");
    assert!(
        sideways_line.contains("% less far than ahead ("),
        "{sideways_line}"
    );
    assert!(
        sideways_line.contains("rigid rollers explain nothing of it"),
        "{sideways_line}"
    );
    near(numbers(starting(&lines, "Ahead it goes"))[0], 1.6, 0.1);
    // 1 - (49.2 / 50) (250 / 260).
    near(numbers(starting(&lines, "It turns"))[0], 5.38, 0.1);
    let set = starting(
        &lines,
        "In omni_wheel_drive_controller set the wheel radius rho, `wheel_radius`, to ",
    );
    let [radius, _, _, before, lever, ..] = numbers(set)[..] else {
        panic!("{set}");
    };
    near(radius, 49.2, 0.05);
    near(before, 50.0, 0.0);
    assert!(set.contains("`robot_radius`"), "{set}");
    near(lever, 260.0, 0.5);
    let factor = numbers(starting(&lines, "Multiply vy, the speed sideways, by "));
    near(factor[0], 1.0 / 0.96, 0.001);
    // One run: the scatter of others is not known.
    assert!(
        starting(&lines, "To know more, ").contains("six runs or more"),
        "{lines:#?}"
    );
    // The answer is before the values, and all other tables only on request.
    let place = |text: &str| printed.find(text);
    assert!(place("Sideways it goes") < place("Parameters"), "{printed}");
    assert_eq!(place("Ends of runs"), None, "{printed}");
    let full = folder.ilon(&["identify", "study.toml", "--out", "found", "--table"]);
    assert!(stdout(&full).contains("Ends of runs"), "{}", stdout(&full));
    let quiet = folder.ilon(&["identify", "study.toml", "--out", "found", "-q"]);
    assert_eq!(ended_with(0, &quiet), "");
}

/// For a log without sideways motion, sideways results are replaced by a suggestion for a drive.
#[test]
fn what_a_log_does_not_hold_is_what_is_to_be_driven() {
    let folder = Folder::new();
    volksbot(&folder);
    let rows: Vec<String> = table().lines().take(501).map(str::to_owned).collect();
    folder.write("log.csv", &(rows.join("\n") + "\n"));
    folder.write("study.toml", STUDY);
    let output = folder.ilon(&["identify", "study.toml", "--out", "found"]);
    ended_with(0, &output);
    let lines = sentences(&folder, "found", &stdout(&output));
    assert!(
        !lines.iter().any(|line| line.starts_with("Sideways")),
        "{lines:#?}"
    );
    assert!(!lines.iter().any(|line| line.contains("vy")), "{lines:#?}");
    let wish = starting(&lines, "To know more, drive sideways");
    assert!(wish.contains("turns on the spot"), "{wish}");
    let json: serde_json::Value =
        serde_json::from_str(&folder.read("found/identified.json")).expect("JSON");
    assert!(json["gains"]["sideways"].is_null() && json["controller"]["sideways_factor"].is_null());
}

#[test]
fn bad_studies_and_logs_end_with_code_2_their_place_and_nothing_written() {
    let folder = Folder::new();
    volksbot(&folder);
    folder.write("log.csv", &table());
    let refused = |study: &str, words: &str| {
        folder.write("study.toml", study);
        let output = folder.ilon(&["identify", "study.toml", "--out", "found"]);
        let said = ended_with(2, &output);
        assert!(said.contains(words), "`{words}` is not in {said}");
        let written = folder.path("found/identified.json").exists();
        assert!(!written, "{said}");
    };
    refused(&STUDY.replace("log.csv", "missing.csv"), "missing.csv");
    refused(&STUDY.replace("\"w2\"", "\"w9\""), "w9");
    refused(&STUDY.replace("known.toml", "nobody.toml"), "nobody.toml");
    refused(
        &STUDY.replace("unit = \"m\" }\ny", "unit = \"ell\" }\ny"),
        "ell",
    );
    refused(
        &format!("{STUDY}\n[simulate]\nphases = 0\n[simulate.free]\n"),
        "phases",
    );
    refused(
        &format!(
            "{STUDY}\n[simulate]\ndrive_s = 1.0\nripple = {{ stretch_s = 3.0 }}\n[simulate.free]\n"
        ),
        "stretch_s",
    );
    refused(
        &format!(
            "{STUDY}\n[simulate]\nripple = {{ together = [[\"wheel_7\"]] }}\n[simulate.free]\n"
        ),
        "wheel_7",
    );
    refused(
        &format!(
            "{STUDY}\n[simulate]\n[simulate.free]\nworld.floor.creep = {{ from = 2.0, to = 1.0 }}\n"
        ),
        "world.floor.creep",
    );
    let simulated = "[simulate.free]\nworld.floor.creep = { from = 0.1, to = 1.0 }\n";
    let motors = "[simulate.currents]\ntorque_constant_n_m_a = 0.05\n";
    refused(
        &format!("{STUDY}\n[simulate]\n{motors}{simulated}"),
        "[log.currents]",
    );
    let own = STUDY.replace(
        "[[runs]]",
        "[log.currents]\nwheel_1 = { column = \"w1\", unit = \"A\" }\nwheel_2 = { column = \"w2\", unit = \"A\" }\nwheel_3 = { column = \"w3\", unit = \"A\" }\n\n[[runs]]",
    );
    for (bad, said) in [
        ("torque_constant_n_m_a = 0.0", "torque_constant_n_m_a"),
        (
            "torque_constant_n_m_a = 0.05\ngear_ratio = -3",
            "gear_ratio",
        ),
        (
            "torque_constant_n_m_a = 0.05\nfriction_n_m = -1",
            "friction_n_m",
        ),
    ] {
        let study = format!("{own}\n[simulate]\n[simulate.currents]\n{bad}\n{simulated}");
        refused(&study, said);
    }
    refused(
        &format!("{STUDY}\n[simulate]\nheading = {{ least_error_rad_per_m = 0 }}\n{simulated}"),
        "least_error_rad_per_m",
    );
    let twice = "[[simulate.beside]]\nname = \"same\"\nset = {}\n";
    refused(
        &format!("{STUDY}\n[simulate]\n{simulated}{twice}{twice}"),
        "simulate.beside",
    );
    let unknown = "[[simulate.beside]]\nname = \"ice\"\nset = { world.flor.friction = 0.1 }\n";
    refused(
        &format!("{STUDY}\n[simulate]\ndrive_s = 0.5\n{simulated}{unknown}"),
        "world.flor",
    );
    // Counted twice, a log would narrow the intervals, and held out it would judge itself.
    let parts = |first: &str, second: &str| {
        format!("{STUDY}{first}\n[[runs]]\nfile = \"./log.csv\"\n{second}\n")
    };
    let same = "runs 1 and 2 hold the same part of `";
    refused(&parts("", "held_out = true"), same);
    refused(&parts("to_s = 10.1", "from_s = 10"), same);
    folder.write("study.toml", &parts("from_s = 10", "to_s = 10"));
    ended_with(
        0,
        &folder.ilon(&["identify", "study.toml", "--out", "parts"]),
    );
    // A clock that was set back, in the middle.
    let mut rows: Vec<String> = table().lines().map(str::to_owned).collect();
    rows.swap(700, 760);
    folder.write("log.csv", &(rows.join("\n") + "\n"));
    refused(STUDY, "times do not increase");
    // Two wheels swapped.
    let swapped = table().replace("w1,w2,w3", "w2,w1,w3");
    folder.write("log.csv", &swapped);
    refused(STUDY, "wheel_");
    let plan = folder.ilon(&["identify", "--plan", "nobody.toml"]);
    assert!(ended_with(2, &plan).contains("nobody.toml"));
    let both = folder.ilon(&["identify", "study.toml", "--plan", "known.toml"]);
    ended_with(2, &both);
    // Results never replace their inputs.
    folder.write("log.csv", &table());
    folder.write("robot.toml", &folder.read("known.toml"));
    let study = STUDY.replace("known.toml", "robot.toml");
    folder.write("study.toml", &study);
    let output = folder.ilon(&["identify", "study.toml", "--out", "."]);
    assert!(ended_with(2, &output).contains("robot.toml"));
}

#[cfg(unix)]
#[test]
fn ended_in_the_middle_it_leaves_no_half_of_anything_and_begins_again() {
    let folder = Folder::new();
    volksbot(&folder);
    folder.write("log.csv", &table());
    // Minutes of simulation.
    folder.write(
        "study.toml",
        &format!(
            "{STUDY}\n[simulate]\ndrive_s = 500.0\n[simulate.free]\nworld.floor.friction = {{ from = 0.3, to = 0.9 }}\n"
        ),
    );
    let mut child = folder
        .command(&["identify", "study.toml", "--out", "found"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command runs");
    std::thread::sleep(Duration::from_millis(1500));
    assert!(
        child.try_wait().expect("a child").is_none(),
        "it was over before"
    );
    // A shell that runs tests in the background makes them ignore SIGINT, which Ctrl-C sends; this
    // signal has otherwise the same effect.
    let killed = Command::new("kill")
        .args(["-TERM", &child.id().to_string()])
        .status();
    assert!(killed.expect("kill").success());
    let status = child.wait().expect("a child");
    assert!(!status.success());
    let left = match folder.path("found").exists() {
        true => folder.names("found"),
        false => Vec::new(),
    };
    let is_result = |name: &String| {
        ["json", "html", "toml", "csv"]
            .iter()
            .any(|end| name.ends_with(end))
    };
    assert!(!left.iter().any(is_result), "{left:?}");
    folder.write("study.toml", STUDY);
    ended_with(
        0,
        &folder.ilon(&["identify", "study.toml", "--out", "found"]),
    );
}

/// Runs whose ends were measured by tape: 1.968 m of 2 m commanded give 49.2 mm of 50, and turns
/// would determine the lever.
#[test]
fn runs_that_a_tape_measured_are_fitted_and_further_ones_named() {
    let folder = Folder::new();
    volksbot(&folder);
    let run = |row: &str| {
        folder.write(
            "tape.toml",
            &format!("robot = \"known.toml\"\nmeasured = [ {{ {row} }} ]\n"),
        );
        folder.ilon(&["identify", "tape.toml", "--out", "out"])
    };
    let found = run("drive = { vx_m_s = 0.4, for_s = 5 }, x_m = 1.968");
    ended_with(0, &found);
    let said = stdout(&found);
    for words in [
        "`wheel_radius`, to 49.2 mm",
        "`lever_m` stays at 0.25",
        "3 turns on the spot",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let json: serde_json::Value =
        serde_json::from_str(&folder.read("out/identified.json")).expect("JSON");
    let radius_m = json["parameters"]["radius_m"]["value"]
        .as_f64()
        .expect("a number");
    assert!((radius_m - 0.0492).abs() < 1e-6, "{json}");
    for (row, words) in [
        ("x_m = 1.968", "give either `wheels"),
        (
            "drive = { vx_m_s = 0.4, for_s = 5 }",
            "give `x_m`, `y_m` or `heading_deg`",
        ),
        ("wheels = { nobody = 3 }, x_m = 1", "is missing"),
    ] {
        let said = ended_with(2, &run(row));
        assert!(said.contains(words), "{said}");
    }
}

/// A real robot on two tyres, fitted on circles: the written robot is read again with the radii and
/// the track that were found, its twin drives as the real one did, and unseen squares end nearer.
#[test]
fn a_real_robot_on_tyres_is_fitted_and_its_twin_drives_alike() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets");
    let folder = Folder::new();
    let study = format!("{root}/identify/optiodom_differential.toml");
    let said = stdout(&folder.ilon(&["identify", &study, "--out", "found", "--json"]));
    let found: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    let value = |name: &str| found["parameters"][name]["value"].as_f64().expect(name);
    let robot = Robot::load(folder.path("found/robot.toml")).expect("a robot");
    for wheel in &robot.wheels {
        let radius_m = value(&format!("radius_m.{}", wheel.name));
        assert!((wheel.radius_m - radius_m).abs() < 1e-9, "{}", wheel.name);
        assert!((wheel.position_m().y.abs() - value("lever_m")).abs() < 1e-9);
    }
    // The keys of `diff_drive_controller`: the whole track, and a factor on each side's radius.
    let said = stdout(&folder.ilon(&["identify", &study, "--out", "found"]));
    let track_mm = 2e3 * value("lever_m");
    let track = format!("`wheel_separation`, to {track_mm:.1} mm");
    assert!(said.contains(&track), "{track}: {said}");
    let share = value("radius_m.left")
        / found["controller"]["radius_m"]["value"]
            .as_f64()
            .expect("m");
    let left = format!("`right_wheel_radius_multiplier`: left to {share:.4}");
    assert!(said.contains(&left), "{left}: {said}");
    // A robot that cannot move sideways is not asked to.
    assert!(!said.contains("sideways"), "{said}");
    // It drove only ahead and back: there are no directions to draw.
    assert!(!folder.read("found/report.html").contains("Sideways error"));
    let nominal_m = found["nominal"]["end_position_rms_m"].as_f64().expect("m");
    let fitted_m = found["held_out"]["end_position_rms_m"].as_f64().expect("m");
    assert!(fitted_m < 0.7 * nominal_m, "{fitted_m} m, {nominal_m} m");
    let played = stdout(&folder.ilon(&["run", "found/scenario.toml", "--no-report"]));
    let lines: Vec<String> = played.lines().map(str::to_owned).collect();
    let answer = starting(&lines, "The simulated robot is up to");
    let end = answer
        .split("at the end ")
        .nth(1)
        .and_then(|end| end.split(' ').next());
    let end_mm: f64 = end.and_then(|end| end.parse().ok()).expect(answer);
    // After 9.4 m and two turns.
    assert!(end_mm < 30.0, "{answer}");
}

/// A real tricycle: the written robot has the wheel's radius and place that were found, its drive the
/// steering angles with their zero, and the sentences the keys of `tricycle_controller`.
#[test]
fn a_real_tricycle_is_fitted_by_its_steering_angles() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets");
    let folder = Folder::new();
    let study = format!("{root}/identify/optiodom_tricycle.toml");
    let said = stdout(&folder.ilon(&["identify", &study, "--out", "found", "--json"]));
    let found: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    let value = |name: &str| found["parameters"][name]["value"].as_f64().expect(name);
    let robot = Robot::load(folder.path("found/robot.toml")).expect("a robot");
    assert!((robot.wheels[0].radius_m - value("radius_m")).abs() < 1e-9);
    // The axle stands at the body's origin.
    assert!((robot.wheels[0].position_m().x - value("lever_m")).abs() < 1e-9);
    let drive = folder.read("found/drive.csv");
    let mut rows = drive.lines();
    assert!(
        rows.next()
            .expect("a header")
            .starts_with("t_s,drive_angle_rad,drive_steer_position_rad,measured_x_m")
    );
    // The log begins at a reading of 0; written to a microradian.
    let cells: Vec<&str> = rows.next().expect("a row").split(',').collect();
    let begun_rad: f64 = cells[2].parse().expect("a number");
    assert!((begun_rad - value("steering_deg.drive").to_radians()).abs() < 1e-6);
    let said = stdout(&folder.ilon(&["identify", &study, "--out", "found"]));
    let wheelbase = format!(
        "the wheelbase, `wheelbase`, to {:.1} mm",
        1e3 * value("lever_m")
    );
    assert!(
        said.contains(&wheelbase) && said.contains("In tricycle_controller"),
        "{said}"
    );
    assert!(
        said.contains("Add that to what the steering reads."),
        "{said}"
    );
    assert!(!said.contains("sideways"), "{said}");
    assert!(
        folder
            .ilon(&["run", "found/scenario.toml", "--no-report"])
            .status
            .success()
    );
}
