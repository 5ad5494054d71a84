//! `ilon compare`: runs of any kind side by side, and bad input.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

struct Folder(tempfile::TempDir);

impl Folder {
    /// A folder with two scenarios that differ in their floor, and a run of each.
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder to work in"));
        let robot =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots/volksbot.urdf");
        for (name, friction) in [("slick", 0.2), ("grippy", 0.8)] {
            let text = format!(
                "[robot]\nfile = \"{}\"\nroller_bodies = \"near\"\n[world.floor]\nfriction = {friction}\n\
                 [twist]\nvx_m_s = 0.2\nrest_s = 0.1\nramp_s = 0.1\nsettle_s = 0.1\n[run]\nduration_s = 0.5\n",
                robot.display()
            );
            std::fs::write(folder.path(&format!("{name}.toml")), text).expect("a scenario");
            let output = folder.ilon(&[
                "run",
                &format!("{name}.toml"),
                "--out",
                &format!("runs/{name}"),
            ]);
            assert_eq!(output.status.code(), Some(0));
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn ilon(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_ilon"))
            .current_dir(self.0.path())
            .args(arguments)
            .output()
            .expect("the command runs")
    }
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn folders_traces_and_scenarios_can_stand_beside_each_other() {
    let folder = Folder::new();
    let output = folder.ilon(&[
        "compare",
        "runs/slick",
        "runs/grippy/trace.parquet",
        "grippy.toml",
        "--out",
        "pages/all.html",
        "--json",
    ]);
    assert_eq!(output.status.code(), Some(0));
    let all: Value = serde_json::from_str(&stdout(&output)).expect("JSON and nothing else");
    let hash = |run: usize| all["runs"][run]["summary"]["trace_hash"].clone();
    // A trace alone and its scenario, simulated again, are the same run.
    assert_eq!(hash(1), hash(2));
    assert_ne!(hash(0), hash(1));
    let written =
        std::fs::read_to_string(folder.path("runs/slick/summary.json")).expect("a summary");
    let written: Value = serde_json::from_str(&written).expect("JSON");
    assert_eq!(all["runs"][0]["summary"], written);
    let friction = &all["differences"][0];
    assert_eq!(friction["key"], "world.floor.friction");
    assert_eq!(friction["values"], serde_json::json!(["0.2", "0.8", "0.8"]));
    let page = std::fs::read_to_string(folder.path("pages/all.html")).expect("a page");
    // Two runs of one scenario are named by their files, and then all three are.
    for name in ["slick", "trace", "grippy"] {
        assert_eq!(
            all["runs"]
                .as_array()
                .expect("runs")
                .iter()
                .filter(|r| r["name"] == name)
                .count(),
            1
        );
        assert!(page.contains(&format!("<b>{name}</b>")));
    }
}

#[test]
fn the_table_has_a_column_a_run_and_tells_what_was_set_differently() {
    let folder = Folder::new();
    let output = folder.ilon(&["compare", "runs/slick", "runs/grippy"]);
    assert_eq!(output.status.code(), Some(0));
    let text = stdout(&output);
    let cells = |row: &str| -> Vec<String> {
        let line = text.lines().find(|line| line.trim_start().starts_with(row));
        let line = line.unwrap_or_else(|| panic!("no row {row} in\n{text}"));
        line.trim_start()[row.len()..]
            .split_whitespace()
            .map(str::to_owned)
            .collect()
    };
    assert_eq!(cells("world.floor.friction"), ["0.2", "0.8"]);
    assert_eq!(cells("vx").len(), 3, "two values and a unit");
    assert!(folder.path("out/compare.html").is_file());
}

/// A folder's `summary.json` that is not one is an error, not a run without it; without one, and
/// with that of another run, the figures are those of the trace.
#[test]
fn a_bad_summary_is_refused_and_a_missing_one_is_computed() {
    let folder = Folder::new();
    let file = folder.path("runs/slick/summary.json");
    let good = std::fs::read_to_string(&file).expect("a summary");
    let of_another = std::fs::read_to_string(folder.path("runs/grippy/summary.json"));
    let compare = || folder.ilon(&["compare", "runs/slick", "runs/grippy", "--json"]);
    let first = |output: &std::process::Output| -> Value {
        let all: Value = serde_json::from_str(&stdout(output)).expect("JSON");
        all["runs"][0]["summary"]["slip_energy_j"].clone()
    };
    let of_good = first(&compare());
    let wrong_type = good.replacen("\"steps\": ", "\"steps\": -", 1);
    assert_ne!(wrong_type, good);
    for bad in [
        "",
        &good[..good.len() / 2],
        "not JSON",
        "[]",
        "{\"name\": \"another program's\"}",
        &wrong_type,
    ] {
        std::fs::write(&file, bad).expect("a spoilt summary");
        let output = compare();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{bad}: {stderr}");
        let what = "`runs/slick/summary.json` is not the summary of a run: ";
        assert!(stderr.contains(what), "{stderr}");
        assert!(stderr.contains("delete it"), "{stderr}");
        assert!(!stdout(&output).contains("runs"));
    }
    std::fs::write(&file, of_another.expect("a summary")).expect("a summary");
    assert_eq!(first(&compare()), of_good);
    std::fs::remove_file(&file).expect("no summary");
    assert_eq!(first(&compare()), of_good);
}

#[test]
fn what_is_no_run_is_refused_with_what_to_name_instead() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("empty")).expect("a folder");
    for (arguments, what) in [
        (vec!["runs/slick"], "2 values required"),
        (
            vec!["runs/slick", "nowhere"],
            "there is no such file or folder",
        ),
        (
            vec!["runs/slick", "empty"],
            "there is no trace.parquet in it",
        ),
        (
            vec!["runs/slick", "runs/slick/summary.json"],
            "cannot be read as Parquet",
        ),
    ] {
        let mut all = vec!["compare"];
        all.extend(arguments);
        let output = folder.ilon(&all);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(stderr.contains(what), "{stderr}");
        assert!(!folder.path("out/compare.html").exists());
    }
}
