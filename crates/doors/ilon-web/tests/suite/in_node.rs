//! The simulator as WebAssembly, in Node: the same bits as natively, in bounded memory.
//!
//! Needs `node`, and a playground named by `ILON_WEB`.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::support::{hashes, playground, scenarios};

/// The script's output for these scenarios; `None` without a playground or Node.
fn in_node(arguments: &[&str]) -> Option<Value> {
    let folder = playground()?;
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/node.mjs");
    let output = Command::new("node")
        .arg(script)
        .arg(folder)
        .args(arguments)
        .output();
    let Ok(output) = output else {
        eprintln!("skipped: there is no node");
        return None;
    };
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    Some(serde_json::from_slice(&output.stdout).expect("JSON"))
}

#[test]
fn every_shipped_scenario_gives_the_same_trace_hash_as_here() {
    let names = scenarios();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let Some(said) = in_node(&[&["hashes"], names.as_slice()].concat()) else {
        return;
    };
    let here = hashes();
    assert!(here.len() > 50, "{here:#?}");
    for (name, hash) in here {
        assert_eq!(said[name], hash.as_str(), "{name}");
    }
}

/// The first half of the runs shows how much memory is needed; a leak would show as growth in the
/// second. Sixty runs, or as many as `ILON_WEB_RUNS` states.
#[test]
fn many_runs_and_drives_in_a_row_take_no_more_memory_than_half_of_them() {
    let runs = std::env::var("ILON_WEB_RUNS").unwrap_or_else(|_| "60".to_owned());
    let Some(said) = in_node(&["memory", "mecanum4_lateral", &runs]) else {
        return;
    };
    let pages: Vec<u64> = said
        .as_array()
        .expect("sizes")
        .iter()
        .filter_map(Value::as_u64)
        .collect();
    assert_eq!(pages.len().to_string(), runs);
    let later = &pages[pages.len() / 2..];
    assert!(later.windows(2).all(|pair| pair[0] == pair[1]), "{pages:?}");
    // A sixteenth of the simulator's limit.
    assert!(later[0] <= 64 << 20, "{} bytes", later[0]);
}
