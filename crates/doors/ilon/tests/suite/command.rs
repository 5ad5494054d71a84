//! Guarantees for scripts: files, streams, exit codes, and runs that repeat bit for bit.
//!
//! A list of guarantees, as long as there are some.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

const SCENARIO: &str = "\
[robot]
file = \"ROBOT\"

[twist]
vx_m_s = 0.2
rest_s = 0.1
ramp_s = 0.1
settle_s = 0.1

[run]
duration_s = 0.6

[expect]
twist_ratio_contact.vx = { min = 0.98, max = 1.02 }

[[expect.signals]]
signal = \"wheel*_target_rad_s\"
max = 4.62 # 0.2 m/s over 0.05 m, at 30 deg from the wheel's own direction: 3.46
min = -4.62
";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder to work in"));
        folder.write("good.toml", SCENARIO);
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        let robot =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots/volksbot.urdf");
        let text = text.replace("ROBOT", &robot.display().to_string());
        std::fs::write(self.path(name), text).expect("a file of the folder");
    }

    fn ilon(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_ilon"))
            .current_dir(self.0.path())
            .args(arguments)
            .output()
            .expect("the command runs")
    }

    fn json(&self, name: &str) -> Value {
        let text = std::fs::read_to_string(self.path(name)).expect("it was written");
        serde_json::from_str(&text).expect("it is JSON")
    }
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn assert_code(output: &Output, code: i32) {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(
        output.status.code(),
        Some(code),
        "{}{stderr}",
        stdout(output)
    );
}

#[test]
fn a_run_writes_its_four_files_and_nothing_else() {
    let folder = Folder::new();
    assert_code(&folder.ilon(&["run", "good.toml", "--out", "a/b"]), 0);
    let mut names: Vec<String> = std::fs::read_dir(folder.path("a/b"))
        .expect("the folder of results")
        .map(|entry| {
            entry
                .expect("a file")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    assert_eq!(
        names,
        [
            "report.html",
            "scenario.toml",
            "summary.json",
            "trace.parquet"
        ]
    );
}

#[test]
fn with_json_the_summary_is_all_that_stands_on_standard_output() {
    let folder = Folder::new();
    let output = folder.ilon(&["run", "good.toml", "--out", "a", "--json"]);
    assert_code(&output, 0);
    let printed: Value = serde_json::from_str(&stdout(&output)).expect("JSON and nothing else");
    assert_eq!(printed, folder.json("a/summary.json"));
    assert_eq!(printed["scenario"], "good");
    assert!(printed["position_error_final_m"].is_null());
}

#[test]
fn the_same_scenario_gives_the_same_trace_and_the_resolved_one_gives_it_again() {
    let folder = Folder::new();
    assert_code(&folder.ilon(&["run", "good.toml", "--out", "a"]), 0);
    assert_code(&folder.ilon(&["run", "good.toml", "--out", "b"]), 0);
    assert_code(&folder.ilon(&["run", "a/scenario.toml", "--out", "c"]), 0);
    let hash = |name: &str| folder.json(name)["trace_hash"].clone();
    assert_eq!(hash("a/summary.json"), hash("b/summary.json"));
    assert_eq!(hash("a/summary.json"), hash("c/summary.json"));
    let other = [
        "run",
        "good.toml",
        "--out",
        "d",
        "--set",
        "robot.heading_deg=20",
    ];
    assert_code(&folder.ilon(&other), 0);
    assert_ne!(hash("a/summary.json"), hash("d/summary.json"));
}

#[test]
fn noise_is_the_same_for_the_same_seed_and_another_for_another() {
    let folder = Folder::new();
    let run = |out: &str, seed: &str| {
        let noise = "sensors.encoders.rate_noise_rad_s=0.1";
        let seed = format!("sensors.seed={seed}");
        let arguments = [
            "run",
            "good.toml",
            "--out",
            out,
            "--set",
            noise,
            "--set",
            &seed,
        ];
        assert_code(&folder.ilon(&arguments), 0);
        folder.json(&format!("{out}/summary.json"))["trace_hash"].clone()
    };
    let first = run("a", "1");
    assert_eq!(first, run("b", "1"));
    assert_ne!(first, run("c", "2"));
}

#[test]
fn check_ends_with_1_where_an_expectation_fails_and_tells_what_when_and_how_to_see_it() {
    let folder = Folder::new();
    let held = folder.ilon(&["check", "good.toml"]);
    assert_code(&held, 0);
    assert!(
        stdout(&held).starts_with("held   good ("),
        "{}",
        stdout(&held)
    );

    let failed = folder.ilon(&[
        "check",
        "good.toml",
        "--set",
        "twist.vx_m_s=0.3",
        "--keep",
        "kept",
    ]);
    assert_code(&failed, 1);
    let text = stdout(&failed);
    // 0.3 m/s over 0.05 m times cos 30 deg: 5.196 rad/s.
    assert!(
        text.contains("_target_rad_s >= -4.62 and <= 4.62 at all times failed: measured"),
        "{text}"
    );
    assert!(
        text.contains("to see it: ilon run good.toml --set twist.vx_m_s=0.3\n"),
        "{text}"
    );
    assert!(folder.path("kept/good/report.html").exists());
}

#[test]
fn check_ends_with_2_where_a_scenario_cannot_run_and_still_runs_the_others() {
    let folder = Folder::new();
    folder.write("bad.toml", &SCENARIO.replace("duration_s", "duraton_s"));
    let output = folder.ilon(&["check", ".", "--junit", "junit.xml"]);
    assert_code(&output, 2);
    assert!(
        stdout(&output).contains("held   good ("),
        "{}",
        stdout(&output)
    );
    let junit = std::fs::read_to_string(folder.path("junit.xml")).expect("it was written");
    assert!(junit.contains("tests=\"2\""), "{junit}");
    // Jenkins's schema forbids it there.
    assert!(
        !junit.contains("<testsuites name=\"ilon\" tests=\"2\" skipped"),
        "{junit}"
    );
    assert!(
        junit.contains("<error message=\"unknown key `run.duraton_s`\""),
        "{junit}"
    );
    assert_code(&folder.ilon(&["check", ".", "--filter", "good"]), 0);
    let nothing = folder.ilon(&["check", "good.toml", "--against", "nowhere"]);
    assert_code(&nothing, 2);
    assert!(
        stdout(&nothing).contains("there is no baseline `nowhere/good.parquet`"),
        "{}",
        stdout(&nothing)
    );
}

#[test]
fn a_baseline_holds_the_same_run_and_locates_where_another_leaves_it() {
    let folder = Folder::new();
    assert_code(&folder.ilon(&["check", "good.toml", "--save", "base"]), 0);
    assert_code(
        &folder.ilon(&["check", "good.toml", "--against", "base"]),
        0,
    );
    // The motion begins at 0.1 s: one control period later the first rates differ.
    let slower = [
        "check",
        "good.toml",
        "--against",
        "base",
        "--set",
        "twist.vx_m_s=0.199",
        "--keep",
        "kept",
    ];
    let output = folder.ilon(&slower);
    assert_code(&output, 1);
    let text = stdout(&output);
    assert!(
        text.contains("the first of all is apart at 0.11 s"),
        "{text}"
    );
    assert!(
        text.contains("drawn in kept/good/difference.html"),
        "{text}"
    );
    let page = std::fs::read_to_string(folder.path("kept/good/difference.html"));
    assert!(
        page.expect("it was drawn")
            .contains("leaves its baseline at 0.11 s")
    );
}

#[test]
fn neither_threads_nor_scenarios_beside_it_change_a_trace() {
    let folder = Folder::new();
    let slow = SCENARIO
        .replace("vx_m_s = 0.2", "vy_m_s = 0.1")
        .replace("contact.vx", "contact.vy");
    folder.write("slow.toml", &slow);
    let check = |threads: &str, arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_ilon"))
            .current_dir(folder.0.path())
            .env("RAYON_NUM_THREADS", threads)
            .arg("check")
            .args(arguments)
            .output()
            .expect("the command runs")
    };
    assert_code(&check("1", &["good.toml", "--save", "base"]), 0);
    assert_code(&check("1", &["slow.toml", "--save", "base"]), 0);
    assert_code(
        &check("4", &["good.toml", "slow.toml", "--against", "base"]),
        0,
    );
}

/// Without fused multiply-add, as on older processors, the C library's sine and cosine have other
/// last bits. They must not reach a trace.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn the_c_library_of_another_processor_changes_no_trace() {
    let folder = Folder::new();
    folder.write(
        "circle.toml",
        "[robot]\nfile = \"ROBOT\"\nheading_deg = 17\nroller_bodies = \"near\"\n\
         [reference.circle]\nradius_m = 1.0\nspeed_m_s = 0.2\n\
         [sensors.pose]\nposition_noise_m = 0.01\nheading_noise_deg = 1.0\n[run]\nduration_s = 2\n",
    );
    let hash = |out: &str, tunables: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_ilon"))
            .current_dir(folder.0.path())
            .env("GLIBC_TUNABLES", tunables)
            .args(["run", "circle.toml", "--out", out])
            .output()
            .expect("the command runs");
        assert_code(&output, 0);
        folder.json(&format!("{out}/summary.json"))["trace_hash"].clone()
    };
    let without = hash("a", "glibc.cpu.hwcaps=-FMA,-AVX2,-FMA4");
    assert_eq!(without, hash("b", ""));
}

#[cfg(unix)]
#[test]
fn a_run_killed_on_its_way_leaves_its_trace_up_to_then_and_nothing_that_looks_complete() {
    let folder = Folder::new();
    // An earlier run's results must not be taken for those of the killed run.
    assert_code(&folder.ilon(&["run", "good.toml", "--out", "a"]), 0);
    let mut child = Command::new(env!("CARGO_BIN_EXE_ilon"))
        .current_dir(folder.0.path())
        .args(["run", "good.toml", "--out", "a"])
        // A thousand simulated seconds take longer than this test on any machine.
        .args(["--set", "run.duration_s=1000"])
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("the command runs");
    let third = folder.path("a/trace.partial/0000002.parquet");
    for _ in 0..600 {
        if third.exists() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    assert_eq!(child.try_wait().expect("it can be asked"), None);
    // SIGKILL: no code of the process runs any more.
    child.kill().expect("it is still running");
    child.wait().expect("it ends");

    let mut left: Vec<_> = std::fs::read_dir(folder.path("a"))
        .expect("the folder of results")
        .map(|entry| entry.expect("a file").file_name())
        .collect();
    left.sort();
    // The lock of the hidden file is released too.
    assert_eq!(left, [".ilon-lock", "scenario.toml", "trace.partial"]);

    // The rows are those of an undisturbed run, without a gap.
    let read = |name: &str| ilon::trace::Trace::read_parquet(&folder.path(name)).expect("a trace");
    let partial = read("a/trace.partial");
    assert!(partial.duration_s() >= 3.0, "{} s", partial.duration_s());
    let undisturbed = ["run", "a/scenario.toml", "--out", "b", "--set"];
    let duration = format!("run.duration_s={}", partial.duration_s() + 1.0);
    assert_code(&folder.ilon(&[&undisturbed[..], &[&duration]].concat()), 0);
    let whole = read("b/trace.parquet");
    for name in partial.header.signal_names() {
        let until_then = partial.signal(&name).expect("a recorded signal");
        let mut all = whole.signal(&name).expect("the same signals");
        all.truncate(until_then.len());
        assert_eq!(until_then, all, "{name}");
    }

    // The next run into the folder ends normally.
    assert_code(&folder.ilon(&["run", "good.toml", "--out", "a"]), 0);
    assert_eq!(
        std::fs::read_dir(folder.path("a")).map_or(0, Iterator::count),
        4
    );
}

#[test]
fn updated_bounds_hold_the_run_that_they_were_taken_from() {
    let folder = Folder::new();
    folder.write(
        "good.toml",
        &SCENARIO.replace("min = 0.98, max = 1.02", "min = 1.5, max = 2.0"),
    );
    assert_code(&folder.ilon(&["check", "good.toml"]), 1);
    let updating = folder.ilon(&["check", "good.toml", "--update", "0.01"]);
    let said = stdout(&updating);
    assert_code(&updating, 0);
    assert!(
        said.contains("twist_ratio_contact.vx.min: 1.5 -> 0.9"),
        "{said}"
    );
    // It reports what it did, not a failed expectation that now holds.
    assert!(
        said.starts_with("UPDATED good") && !said.contains("FAILED"),
        "{said}"
    );
    assert_code(&folder.ilon(&["check", "good.toml"]), 0);
}

#[test]
fn what_cannot_be_updated_still_fails() {
    let folder = Folder::new();
    folder.write("good.toml", &SCENARIO.replace("max = 4.62", "max = 0.1"));
    let updating = folder.ilon(&["check", "good.toml", "--update", "0.01"]);
    assert_code(&updating, 1);
    assert!(
        stdout(&updating).starts_with("FAILED good"),
        "{}",
        stdout(&updating)
    );
}

#[test]
fn a_thinned_record_keeps_every_so_many_rows_of_the_same_run() {
    let folder = Folder::new();
    assert_code(&folder.ilon(&["run", "good.toml", "--out", "a"]), 0);
    let thin = [
        "run",
        "good.toml",
        "--out",
        "b",
        "--set",
        "run.record_every=5",
    ];
    assert_code(&folder.ilon(&thin), 0);
    let trace =
        |name: &str| ilon::trace::Trace::read_parquet(&folder.path(name)).expect("it was written");
    let (all, thinned) = (trace("a/trace.parquet"), trace("b/trace.parquet"));
    let last = all.records().len() - 1;
    let kept: Vec<_> = all
        .records()
        .iter()
        .enumerate()
        .filter(|(row, _)| row % 5 == 0 || *row == last)
        .map(|(_, record)| record.odometry_ideal)
        .collect();
    let rows: Vec<_> = thinned
        .records()
        .iter()
        .map(|record| record.odometry_ideal)
        .collect();
    assert_eq!(kept, rows);
    for figure in [
        "steps",
        "duration_s",
        "control_dt_s",
        "position_error_final_m",
    ] {
        let of = |run: &str| folder.json(&format!("{run}/summary.json"))[figure].clone();
        assert_eq!(of("a"), of("b"), "{figure}");
    }
}

#[test]
fn inspect_tells_scripts_of_wheels_and_m() {
    let folder = Folder::new();
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots/mecanum4.urdf");
    let output = folder.ilon(&["inspect", &robot.display().to_string(), "--json"]);
    assert_code(&output, 0);
    let robot: Value = serde_json::from_str(&stdout(&output)).expect("JSON and nothing else");
    assert_eq!(robot["rank"], 3);
    assert_eq!(robot["decoupled"], true);
    assert_eq!(robot["wheels"].as_array().map(Vec::len), Some(4));
    assert_eq!(robot["wheels"][0]["rollers"], 9);
    // Robot A: rows such as (1, -1, -0.31)/sqrt 2; the file rounds to twelve digits or more.
    for row in robot["M"].as_array().expect("rows") {
        let size = |column: usize| row[column].as_f64().expect("a number").abs();
        let r = 0.5_f64.sqrt();
        for (got, want) in [(size(0), r), (size(1), r), (size(2), 0.31 * r)] {
            assert!((got - want).abs() < 1e-9);
        }
    }
}

#[test]
fn the_schema_is_json_and_knows_every_section() {
    let folder = Folder::new();
    let schema: Value = serde_json::from_str(&stdout(&folder.ilon(&["schema"]))).expect("JSON");
    for section in [
        "robot",
        "world",
        "reference",
        "twist",
        "guidance",
        "wheel_loop",
        "motors",
        "sensors",
        "run",
        "expect",
    ] {
        assert!(schema["properties"][section].is_object(), "{section}");
    }
}

#[test]
fn each_file_that_a_person_writes_has_a_schema() {
    let folder = Folder::new();
    for (kind, required) in [
        ("scenario", "robot"),
        ("robot", "chassis"),
        ("study", "scenario"),
    ] {
        let said = stdout(&folder.ilon(&["schema", kind]));
        let schema: Value = serde_json::from_str(&said).expect("JSON");
        let names = schema["required"].as_array().expect("a list");
        assert!(
            names.iter().any(|name| name == required),
            "{kind}: {names:?}"
        );
    }
}

#[test]
fn shells_and_manuals_are_served_with_every_command() {
    let folder = Folder::new();
    let script = stdout(&folder.ilon(&["completions", "bash"]));
    let page = stdout(&folder.ilon(&["man"]));
    for command in ["run", "inspect", "sweep", "check"] {
        assert!(
            script.contains(&format!("ilon__subcmd__{command}"))
                || script.contains(&format!("ilon__{command}"))
        );
        assert!(page.contains(&format!("ilon\\-{command}(1)")), "{page}");
        let own = stdout(&folder.ilon(&["man", command]));
        assert!(own.contains(&format!("ilon\\-{command}")), "{own}");
    }
    let unknown = folder.ilon(&["man", "walk"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("one of demo, run"));
}

/// Whatever is said, notes and answers too: what is longer is folded between words.
#[test]
fn no_line_of_what_a_run_says_is_longer_than_240() {
    let folder = Folder::new();
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../assets/scenarios/mecanum4_flat_rollers_forward.toml");
    let scenario = scenario.display().to_string();
    let ran = folder.ilon(&[
        "run",
        &scenario,
        "--set",
        "run.duration_s=0.2",
        "--out",
        "a",
    ]);
    let said = stdout(&ran) + &String::from_utf8_lossy(&ran.stderr);
    let longest = said.lines().map(|line| line.chars().count()).max();
    assert!(longest.is_some_and(|most| most <= 240), "{said}");
    // Folded, not cut.
    let words: Vec<&str> = said.split_whitespace().collect();
    assert!(
        words
            .join(" ")
            .contains("Which ones touch decides slip and heading"),
        "{said}"
    );
}
