//! Error messages: each says what is wrong, where, and how to repair it, ends with exit code 2, and
//! leaves no files. A list of cases, as long as there are kinds of errors.

use crate::support::{Folder, ended_with};

use std::path::{Path, PathBuf};
use std::process::Command;

/// The output of a refused command.
#[derive(Debug, PartialEq)]
struct Told {
    what: String,
    place: Option<String>,
    mend: String,
}

fn told(what: &str, place: impl Into<Option<&'static str>>, mend: &str) -> Told {
    Told {
        what: what.to_owned(),
        place: place.into().map(str::to_owned),
        mend: mend.to_owned(),
    }
}

/// A folder with a valid scenario and a valid robot, to be modified.
struct Bench {
    folder: tempfile::TempDir,
}

const SCENARIO: &str = "\
[robot]
file = \"robot.urdf\"

[reference.circle]
radius_m = 1.0
speed_m_s = 0.2

[run]
duration_s = 1
";

impl Bench {
    fn new() -> Self {
        let bench = Self {
            folder: tempfile::tempdir().expect("a folder to work in"),
        };
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets");
        let robot = std::fs::read_to_string(assets.join("robots/volksbot.urdf"));
        bench.write("robot.urdf", &robot.expect("the Volksbot"));
        bench.write("scenario.toml", SCENARIO);
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).expect("a file of the bench")
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).expect("a file of the bench");
    }

    /// Replaces the first occurrence of a text in a file.
    fn spoil(&self, name: &str, good: &str, bad: &str) -> &Self {
        let text = self.read(name);
        assert!(text.contains(good), "{name} holds no {good}");
        self.write(name, &text.replacen(good, bad, 1));
        self
    }

    fn run(&self, further: &[&str]) -> std::process::Output {
        Command::new(env!("CARGO_BIN_EXE_ilon"))
            .current_dir(self.folder.path())
            .args(["run", "scenario.toml", "--out", "results"])
            .args(further)
            .env_remove("CLICOLOR_FORCE")
            .output()
            .expect("the command runs")
    }

    /// Runs `ilon run` and checks that it is refused: exit code 2, an empty standard output, and no
    /// result files.
    fn refused(&self, further: &[&str]) -> Told {
        let output = self.run(further);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(output.stdout.is_empty());
        if let Ok(mut left) = std::fs::read_dir(self.path("results")) {
            assert!(left.next().is_none(), "results were left half-written");
        }
        let here = self.folder.path().display().to_string();
        let lines_after = |mark: &str| {
            let mut lines = stderr.lines();
            let first = lines.find_map(|line| line.trim_start().strip_prefix(mark))?;
            Some(std::iter::once(first).chain(lines))
        };
        // A long line is folded: its continuation begins with a bar or with spaces.
        let whole = |mark: &str| {
            let folded = lines_after(mark)?.map(|line| line.trim_start().trim_start_matches("│ "));
            let is_more = |line: &&str| {
                !line.is_empty()
                    && !line.starts_with(['╭', '╰', '│'])
                    && !line.starts_with("help: ")
            };
            let lines: Vec<&str> = folded.take_while(is_more).collect();
            Some(lines.join(" ").replace(&here, "FOLDER"))
        };
        let after = |mark: &str| Some(lines_after(mark)?.next()?.replace(&here, "FOLDER"));
        Told {
            what: whole("× ").unwrap_or_else(|| panic!("no message in {stderr}")),
            place: after("╭─[").map(|rest| rest.trim_end_matches(']').to_owned()),
            mend: whole("help: ").unwrap_or_else(|| panic!("no help in {stderr}")),
        }
    }
}

#[test]
fn a_missing_scenario() {
    let bench = Bench::new();
    std::fs::remove_file(bench.path("scenario.toml")).expect("it is there");
    assert_eq!(
        bench.refused(&[]),
        told(
            "cannot read `scenario.toml`: there is no such file or folder",
            None,
            "check the path; it is taken from FOLDER",
        )
    );
}

#[test]
fn a_file_where_the_command_belongs() {
    let bench = Bench::new();
    let output = Command::new(env!("CARGO_BIN_EXE_ilon"))
        .current_dir(bench.folder.path())
        .arg("robot.urdf")
        .output()
        .expect("the command runs");
    assert_eq!(output.status.code(), Some(2));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("such as `ilon run robot.urdf`"), "{stderr}");
}

/// Each kind of file given to a command for another kind: the message says what it is, and the help
/// names a command that reads it.
#[test]
fn a_file_of_another_kind_is_sent_to_its_command() {
    let bench = Bench::new();
    bench.write(
        "study.toml",
        "scenario = \"scenario.toml\"\n[axes]\nrun.duration_s = [1, 2]\n",
    );
    bench.write(
        "logs.toml",
        "robot = \"robot.urdf\"\n[[runs]]\nfile = \"log.csv\"\n",
    );
    for (command, file, is, reads) in [
        (
            "sweep",
            "scenario.toml",
            "is a scenario, not a study of many runs",
            "ilon run scenario.toml",
        ),
        (
            "identify",
            "scenario.toml",
            "is a scenario, not a study of logs",
            "ilon run scenario.toml",
        ),
        (
            "inspect",
            "scenario.toml",
            "is a scenario, not a robot",
            "name its robot, robot.urdf",
        ),
        (
            "run",
            "study.toml",
            "is a study of many runs, not a scenario",
            "ilon sweep study.toml",
        ),
        (
            "explain",
            "study.toml",
            "is a study of many runs, not",
            "ilon sweep study.toml",
        ),
        (
            "live",
            "logs.toml",
            "is a study of logs, not",
            "ilon identify logs.toml",
        ),
        (
            "check",
            "robot.urdf",
            "is a robot, not a scenario",
            "ilon inspect robot.urdf",
        ),
        (
            "generate",
            "robot.urdf",
            "is not a description in TOML",
            "docs/format-robot.md",
        ),
        (
            "run",
            "robbot.urdf",
            "cannot read `robbot.urdf`: there is no such file",
            "taken from",
        ),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_ilon"))
            .current_dir(bench.folder.path())
            .args([command, file])
            .output()
            .expect("the command runs");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{command} {file}: {said}");
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            said.contains(is) && said.contains(reads),
            "{command} {file}: {said}"
        );
    }
}

#[test]
fn a_missing_duration_has_the_head_of_the_file_as_its_place() {
    let bench = Bench::new();
    bench.spoil("scenario.toml", "[run]\nduration_s = 1\n", "");
    let refused = bench.refused(&[]);
    assert_eq!(refused.what, "the key `run.duration_s` is missing");
    assert_eq!(refused.place.as_deref(), Some("scenario.toml:1:1"));
}

#[test]
fn a_key_set_twice_and_a_number_with_its_unit() {
    for (good, bad, repair) in [
        (
            "duration_s = 1",
            "duration_s = 1\nduration_s = 2",
            "it is set above already",
        ),
        (
            "duration_s = 1",
            "duration_s = 5s",
            "a number with a point and without its unit",
        ),
    ] {
        let bench = Bench::new();
        bench.spoil("scenario.toml", good, bad);
        assert!(bench.refused(&[]).mend.contains(repair), "{bad}");
    }
}

#[test]
fn a_missing_robot() {
    let bench = Bench::new();
    bench.spoil("scenario.toml", "robot.urdf", "robbot.urdf");
    assert_eq!(
        bench.refused(&[]),
        told(
            "robbot.urdf: cannot be read: there is no such file; did you mean `robot.urdf`?",
            "scenario.toml:2:8",
            "give the path of a file that exists and may be read",
        )
    );
}

#[test]
fn malformed_xml() {
    let bench = Bench::new();
    bench.spoil("robot.urdf", "</joint>", "</jiont>");
    assert_eq!(
        bench.refused(&[]),
        told(
            "robot.urdf:24: not well-formed XML: expected 'joint' tag, not 'jiont'",
            "robot.urdf:24:3",
            "close every element and quote every attribute",
        )
    );
}

#[test]
fn malformed_toml() {
    let bench = Bench::new();
    bench.spoil("scenario.toml", "radius_m = 1.0", "radius_m = ");
    assert_eq!(
        bench.refused(&[]),
        told(
            "not well-formed TOML: string values must be quoted, expected literal string",
            "scenario.toml:5:12",
            "write a value: text in straight quotes, `\"so\"`; a number with a point and without its unit, `0.5`",
        )
    );
}

#[test]
fn an_unknown_key() {
    let bench = Bench::new();
    bench.spoil("scenario.toml", "radius_m", "raduis_m");
    assert_eq!(
        bench.refused(&[]),
        told(
            "unknown key `reference.circle.raduis_m`",
            "scenario.toml:5:1",
            "did you mean `radius_m`?",
        )
    );
}

#[test]
fn an_unknown_key_set_on_the_command_line() {
    let bench = Bench::new();
    assert_eq!(
        bench.refused(&["--set", "world.floor.frction=0.2"]),
        told(
            "unknown key `world.floor.frction`",
            "--set:1:13",
            "did you mean `friction`?",
        )
    );
}

#[test]
fn a_value_of_the_wrong_type() {
    let bench = Bench::new();
    bench.spoil("scenario.toml", "duration_s = 1", "duration_s = \"long\"");
    assert_eq!(
        bench.refused(&[]),
        told(
            "`run.duration_s` is a text, but must be a number",
            "scenario.toml:9:14",
            "write a number, without quotes and unit: `duration_s = 0.5`",
        )
    );
}

#[test]
fn a_negative_mass() {
    let bench = Bench::new();
    bench.spoil(
        "robot.urdf",
        "<mass value=\"0.25\"/>",
        "<mass value=\"-0.25\"/>",
    );
    assert_eq!(
        bench.refused(&[]),
        told(
            "robot.urdf:26: link `wheel_1_link`, `<mass>`: `value` is -0.25, but must be above 0",
            "robot.urdf:26:68",
            "make `value` above 0",
        )
    );
}

#[test]
fn a_zero_joint_axis() {
    let bench = Bench::new();
    bench.spoil(
        "robot.urdf",
        "<axis xyz=\"0 1 0\"/>",
        "<axis xyz=\"0 0 0\"/>",
    );
    assert_eq!(
        bench.refused(&[]),
        told(
            "robot.urdf:21: joint `wheel_1`, `<axis>`: the axis is zero and has no direction",
            "robot.urdf:21:11",
            "give the axis a direction, such as `<axis xyz=\"0 1 0\"/>`",
        )
    );
}

#[test]
fn a_missing_inertia() {
    let bench = Bench::new();
    let inertia = "<inertia ixx=\"8.95833333333333e-5\" ixy=\"0\" ixz=\"0\" iyy=\"8.95833333333333e-5\" iyz=\"0\" izz=\"0.0001125\"/>";
    bench.spoil("robot.urdf", inertia, "");
    assert_eq!(
        bench.refused(&[]),
        told(
            "robot.urdf:26: link `wheel_1_link`, `<inertial>`: the element `<inertia>` is missing",
            "robot.urdf:26:5",
            "add `<inertia ixx=\"...\" ixy=\"0\" ixz=\"0\" iyy=\"...\" iyz=\"0\" izz=\"...\"/>`; for a solid box of mass m, ixx = m (y^2 + z^2) / 12; this works, in `[robot]`: `repair = true`",
        )
    );
}

#[test]
fn fewer_than_three_wheels() {
    let bench = Bench::new();
    bench.spoil(
        "robot.urdf",
        "<joint name=\"wheel_3\" type=\"continuous\">",
        "<joint name=\"wheel_3\" type=\"fixed\">",
    );
    assert_eq!(
        bench.refused(&[]),
        told(
            "robot.urdf:443: joint `wheel_3`: carries 8 passive rollers, but does not turn; without it the robot has 2 wheel(s), but moving freely in the plane takes three",
            "robot.urdf:443:3",
            "make the joint `continuous`, with the hub's axis; this works, in `[robot]`: `repair = true`",
        )
    );
}

#[test]
fn wheels_that_cannot_control_every_motion() {
    // All three wheels have one hub direction: none drives the robot along it.
    let bench = Bench::new();
    for joint in ["wheel_2", "wheel_3"] {
        let urdf = turned(&bench.read("robot.urdf"), joint, "0 0 -1.5707963267949");
        bench.write("robot.urdf", &urdf);
    }
    assert_eq!(
        bench.refused(&[]),
        told(
            "loss of controllability: all roller axes are parallel, along 90.0 deg: the robot cannot control its motion across them; wheels `wheel_1`, `wheel_2`, `wheel_3`; turn or move a wheel so that its roller axis leaves the others' (Lemma 1, condition c.2: rank M < 3)",
            None,
            "`ilon inspect` shows the robot's wheels and the rows of M as they are understood",
        )
    );
}

#[test]
fn rollers_along_the_hub_axis() {
    let bench = Bench::new();
    for roller in 1..=8 {
        let joint = format!("wheel_1_roller_{roller}");
        let urdf = turned(&bench.read("robot.urdf"), &joint, "1.5707963267949 0 0");
        bench.write("robot.urdf", &urdf);
    }
    assert_eq!(
        bench.refused(&[]),
        told(
            "robot.urdf:30: joint `wheel_1_roller_1`: gamma = 90 deg: the roller turns about the hub axis, and the wheel cannot drive",
            "robot.urdf:30:3",
            "turn the roller's axis away from the hub's: gamma is 45 deg for mecanum wheels and 0 for omni wheels",
        )
    );
}

/// A URDF with another orientation of one joint's frame.
fn turned(urdf: &str, joint: &str, rpy: &str) -> String {
    let joint_at = urdf
        .find(&format!("<joint name=\"{joint}\""))
        .expect("the joint is there");
    let mark = "rpy=\"";
    let start = joint_at + urdf[joint_at..].find(mark).expect("it has an origin") + mark.len();
    let end = start + urdf[start..].find('"').expect("it ends");
    format!("{}{rpy}{}", &urdf[..start], &urdf[end..])
}

#[test]
fn a_wheel_that_lacks_a_roller() {
    let bench = Bench::new();
    bench.write(
        "robot.urdf",
        &without_roller(&bench.read("robot.urdf"), "wheel_2_roller_3"),
    );
    assert_eq!(
        bench.refused(&[]),
        told(
            "robot.urdf:230: joint `wheel_2`: the rollers leave gaps of up to 45.00 deg, 12.5 % of the turn, over which the wheel falls between them: by their places 1 of 8 are missing in the file",
            "robot.urdf:230:3",
            "model each roller as a link on a turning joint of its own: what is part of the hub's mesh does not turn",
        )
    );
}

/// A URDF without one of its rollers: joint and link.
fn without_roller(urdf: &str, name: &str) -> String {
    let cut = |text: &str, from: &str, to: &str| {
        let start = text.find(from).expect("the roller is there");
        let end = start + text[start..].find(to).expect("it ends") + to.len();
        format!("{}{}", &text[..start], &text[end..])
    };
    let text = cut(urdf, &format!("<joint name=\"{name}\""), "</joint>");
    cut(&text, &format!("<link name=\"{name}_link\""), "</link>")
}

#[test]
fn a_number_that_is_not_finite() {
    let bench = Bench::new();
    assert_eq!(
        bench.refused(&["--set", "reference.circle.speed_m_s=nan"]),
        told(
            "`reference.circle.speed_m_s` is not a finite number",
            "--set:1:30",
            "write a finite number",
        )
    );
    assert_eq!(
        bench.refused(&["--set", "robot.x_m=inf"]),
        told(
            "`robot.x_m` is not a finite number",
            "--set:1:13",
            "write a finite number",
        )
    );
    bench.spoil(
        "robot.urdf",
        "<mass value=\"0.25\"/>",
        "<mass value=\"NaN\"/>",
    );
    assert_eq!(
        bench.refused(&[]),
        told(
            "robot.urdf:26: link `wheel_1_link`, `<mass>`: `value=\"NaN\"` is not finite",
            "robot.urdf:26:68",
            "write a finite number; a limit that does not exist is left out",
        )
    );
}

#[test]
fn a_physics_step_that_is_not_positive() {
    let bench = Bench::new();
    assert_eq!(
        bench.refused(&["--set", "run.physics_dt_s=0"]),
        told(
            "`run.physics_dt_s` is 0, but must be greater than 0",
            "--set:1:20",
            "write a number that is greater than 0",
        )
    );
    assert_eq!(
        bench.refused(&["--set", "run.physics_dt_s=-0.001"]),
        told(
            "`run.physics_dt_s` is -0.001, but must be greater than 0",
            "--set:1:20",
            "write a number that is greater than 0",
        )
    );
}

#[test]
fn a_physics_step_that_does_not_divide_the_control_period() {
    let bench = Bench::new();
    assert_eq!(
        bench.refused(&["--set", "run.physics_dt_s=0.003"]),
        told(
            "`run.control_dt_s` = 0.01 is 3.333333 physics steps of `run.physics_dt_s` = 0.003, but must be a whole number of them",
            "--set:1:20",
            "set `run.physics_dt_s` to 0.0025, which divides it",
        )
    );
}

#[test]
fn an_output_folder_that_cannot_be_written() {
    let bench = Bench::new();
    // A file in place of the folder fails for every user, even one who may write anywhere.
    bench.write("results", "");
    let told_of = bench.refused(&[]);
    assert_eq!(
        told_of,
        told(
            "cannot write `results`: a file of that name stands in the way",
            None,
            "choose another place with --out; nothing was left half-written",
        )
    );
}

#[test]
fn a_reference_too_fast_to_track_is_a_warning_with_the_figures() {
    let bench = Bench::new();
    let output = bench.run(&[
        "--set",
        "reference.circle.speed_m_s=0.3",
        "--set",
        "guidance.wheel_rate_limit_rad_s=8.7",
    ]);
    assert_eq!(output.status.code(), Some(0));
    let stderr = String::from_utf8_lossy(&output.stderr);
    // 0.3 m/s over rho cos(gamma) = 0.05 m are 6 rad/s, above half of 8.7 rad/s.
    let note = "note: the reference may be too fast to track: from 0.00 s on its velocity alone takes, in the direction that asks \
                most of the wheels, wheel rates of up to 6.000 rad/s, at 0.00 s (Indiveri 2009, eq. (36)), but half of the limit is 4.350 rad/s; slow it down or raise \
                `guidance.wheel_rate_limit_rad_s`";
    let unfolded = stderr.replace("\n    ", " ");
    assert!(unfolded.lines().any(|line| line == note), "{stderr}");
    assert!(bench.path("results/summary.json").exists());
}

#[test]
fn a_fault_of_a_wheel_that_is_not_there() {
    let bench = Bench::new();
    let fault = "[[faults]]\nroller_stuck = { wheel = \"wheel_4\", roller = 0 }\n";
    bench.write("scenario.toml", &format!("{SCENARIO}\n{fault}"));
    assert_eq!(
        bench.refused(&[]),
        told(
            "a fault is about the wheel `wheel_4`, which the robot does not have",
            "scenario.toml:12:26",
            "did you mean `wheel_3`?",
        )
    );
}

#[test]
fn a_roller_that_is_not_there_cannot_seize() {
    let bench = Bench::new();
    let fault = "[[faults]]\nroller_stuck = { wheel = \"wheel_2\", roller = 8 }\n";
    bench.write("scenario.toml", &format!("{SCENARIO}\n{fault}"));
    assert_eq!(
        bench.refused(&[]),
        told(
            "roller 8 of the wheel `wheel_2` is to seize, but this wheel has 8 rollers",
            "scenario.toml:12:26",
            "they count from 0 to 7",
        )
    );
}

#[test]
fn a_push_of_no_duration_and_a_payload_of_less_than_no_mass() {
    for (fault, what) in [
        (
            "push = { impulse_x_n_s = 1, lasts_s = 0 }",
            "`faults.0.push.lasts_s` is 0, but must be greater than 0",
        ),
        (
            "payload = { mass_kg = -1 }",
            "`faults.0.payload.mass_kg` is -1, but must be 0 or more",
        ),
        (
            "friction_changed = { friction = -0.1 }",
            "`faults.0.friction_changed.friction` is -0.1, but must be 0 or more",
        ),
    ] {
        let bench = Bench::new();
        bench.write(
            "scenario.toml",
            &format!("{SCENARIO}\n[[faults]]\n{fault}\n"),
        );
        assert_eq!(bench.refused(&[]).what, what);
    }
}

#[test]
fn a_filter_that_trusts_odometry_less_than_not_at_all() {
    let bench = Bench::new();
    bench.spoil(
        "scenario.toml",
        "[run]",
        "[sensors.fusion]\nposition_drift_m = -0.01\n\n[run]",
    );
    assert_eq!(
        bench.refused(&[]),
        told(
            "`sensors.fusion.position_drift_m` is -0.01, but must be 0 or more",
            "scenario.toml:9:20",
            "`position_drift_m`: Standard deviation of the odometry's x and y after 1 m, in metres; it grows with the square root of the distance"
        )
    );
    assert_eq!(
        Bench::new()
            .refused(&["--set", "sensors.fusion.drift_m=1"])
            .what,
        "unknown key `sensors.fusion.drift_m`"
    );
}

#[test]
fn a_friction_that_the_wheel_loops_law_has_no_use_for() {
    let bench = Bench::new();
    assert_eq!(
        bench.refused(&["--set", "wheel_loop.friction=0.3"]),
        told(
            "`wheel_loop.friction` has no effect: this `wheel_loop.law` does not use grip",
            "--set:1:23",
            "write law = \"prioritised_torque\" or \"passive\", or leave the friction out",
        )
    );
    let law = "wheel_loop.law=\"prioritised_torque\"";
    assert_eq!(
        bench
            .refused(&["--set", law, "--set", "wheel_loop.friction=0"])
            .what,
        "`wheel_loop.friction` is 0, but must be greater than 0"
    );
}

#[test]
fn a_reference_point_that_is_none() {
    let bench = Bench::new();
    let told = bench.refused(&["--set", "guidance.reference_point=decoupled"]);
    assert_eq!(
        told.what,
        "`guidance.reference_point` cannot be \"decoupled\""
    );
    assert_eq!(told.mend, "did you mean \"decoupling\"?");
}

/// The robot drives 0.1 m from the origin; its wheels stand within 0.5 m of it. One patch lies
/// under all of them, one beside, and one comes too late.
#[test]
fn a_patch_that_no_wheel_meets_and_a_body_out_of_reach_are_remarked() {
    let folder = Folder::new();
    let patch = |x_m: f64, y_m: f64, side_m: f64, from_s: f64| {
        format!(
            "[[world.floor.patches]]\nx_m = {x_m}\ny_m = {y_m}\nlength_x_m = {side_m}\nlength_y_m = {side_m}\nfriction = 0.3\n\
             from_s = {from_s}\n"
        )
    };
    let body =
        "[[world.bodies]]\nname = \"far\"\nmass_kg = 1\nx_m = 3\ny_m = 3\nsphere.radius_m = 0.1\n";
    let text = [
        patch(0.0, 0.0, 2.0, 0.0),
        patch(5.0, 0.0, 0.2, 0.0),
        patch(0.0, 0.0, 2.0, 0.9),
    ];
    folder.scenario("missed.toml", &format!("{}{body}", text.concat()));
    let run = ["run", "missed.toml", "--no-report", "--out", "out"];
    let told = ended_with(0, &folder.ilon(&run));
    assert!(!told.contains("patch 0 of"), "{told}");
    assert!(
        told.contains("no wheel was ever on patch 1 of `world.floor.patches`, at (5, 0) m: ")
            && told.contains(" m from it at "),
        "{told}"
    );
    assert!(
        told.contains("patch 2 of `world.floor.patches`, at (0, 0) m: it is there from 0.9 s on"),
        "{told}"
    );
    assert!(told.contains("the robot never touched `far`"), "{told}");
}
