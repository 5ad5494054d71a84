//! Every TOML block of `docs/cookbook.md` runs: added to a minimal scenario of `mecanum4` it is
//! valid input.

use std::path::Path;
use std::process::Command;

use toml::{Table, Value};

const PAGE: &str = include_str!("../../../../../docs/cookbook.md");
const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots/");

/// The TOML blocks of the page.
fn pieces() -> Vec<&'static str> {
    let blocks = PAGE.split("```toml\n").skip(1);
    blocks
        .map(|block| block.split("```").next().unwrap_or_default())
        .collect()
}

/// Merges a block into a scenario, key by key.
fn merge(scenario: &mut Table, piece: Table) {
    for (key, value) in piece {
        match (scenario.get_mut(&key), value) {
            (Some(Value::Table(below)), Value::Table(piece)) => merge(below, piece),
            (_, value) => _ = scenario.insert(key, value),
        }
    }
}

/// A scenario of 0.2 s with a block; a block with bounds over time gets the duration that they
/// need.
fn around(piece: &str) -> Table {
    let piece: Table = piece.parse().expect("the piece is TOML");
    let moves = ["twist", "reference"]
        .iter()
        .any(|key| piece.contains_key(*key));
    let mut scenario: Table = "robot.file = '../robots/mecanum4.urdf'"
        .parse()
        .expect("it is TOML");
    if !moves {
        merge(
            &mut scenario,
            "twist.vx_m_s = 0.3".parse().expect("it is TOML"),
        );
    }
    let duration_s = if piece.contains_key("expect") {
        8.0
    } else {
        0.2
    };
    merge(&mut scenario, piece);
    let run = format!("run.duration_s = {duration_s}");
    merge(&mut scenario, run.parse().expect("it is TOML"));
    scenario
}

#[test]
fn every_piece_of_the_cookbook_is_good_input() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let pieces = pieces();
    assert!(pieces.len() >= 20, "the page has {} pieces", pieces.len());
    for piece in pieces {
        let text = around(piece).to_string().replace("../robots/", ROBOTS);
        let path = folder.path().join("piece.toml");
        std::fs::write(&path, &text).expect("the scenario is written");
        let done = run(&path, folder.path());
        let said = String::from_utf8_lossy(&done.stderr);
        assert!(matches!(done.status.code(), Some(0 | 1)), "{text}\n{said}");
    }
}

fn run(scenario: &Path, folder: &Path) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_ilon"))
        .current_dir(folder)
        .arg("run")
        .arg(scenario)
        .args(["--no-report", "--no-twins", "--out", "out"])
        .output()
        .expect("the command runs")
}
