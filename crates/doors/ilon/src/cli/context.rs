//! What a report shows besides the trace: provenance, time, inputs and expectations.

use std::collections::BTreeMap;
use std::time::SystemTime;

use chrono::{DateTime, SecondsFormat, Utc};
use ilon_robot::Robot;
use ilon_trace::{Rows, number, quantities};

use super::flags;
use crate::judge::Verdict;
use crate::report::{Context, Expectation, Provenance};
use crate::simulate::{self, Run};

/// The context of a run's report; `command` is the command line that made the run. Without a robot,
/// as when its file no longer exists, the report draws what the trace contains.
pub(super) fn of<'a, R: Rows>(
    run: &Run<R>,
    robot: Option<&'a Robot>,
    verdicts: &[Verdict],
    command: &str,
) -> Context<'a> {
    let relief = run
        .trace
        .header()
        .ground
        .as_ref()
        .and_then(|g| g.relief.as_ref());
    Context {
        robot,
        relief_m: relief.map(simulate::relief_heights_m),
        expectations: verdicts.iter().map(expectation).collect(),
        provenance: Provenance {
            files: BTreeMap::from([("trace".to_owned(), run.summary.trace_hash.clone())]),
            remarks: run.warnings.clone(),
            ..now(command)
        },
    }
}

/// The command line of this process.
pub(super) fn command_line() -> String {
    let words = std::env::args_os()
        .skip(1)
        .map(|word| flags::shell(&word.to_string_lossy()));
    let words = std::iter::once("ilon".to_owned()).chain(words);
    words.collect::<Vec<_>>().join(" ")
}

/// The command line and the time.
fn now(command: &str) -> Provenance {
    let now = || DateTime::<Utc>::from(SystemTime::now());
    // WebAssembly without a system interface has no clock, and reading it panics.
    let has_clock = !cfg!(all(target_family = "wasm", target_os = "unknown"));
    Provenance {
        changed: changed_by(command),
        command: Some(command.to_owned()),
        date: has_clock.then(|| now().to_rfc3339_opts(SecondsFormat::Secs, true)),
        ..Provenance::default()
    }
}

/// The scenario keys that a command line sets.
fn changed_by(command: &str) -> Vec<String> {
    let mut words = command.split_whitespace().peekable();
    let mut changed = Vec::new();
    while let Some(word) = words.next() {
        match word.strip_prefix("--set=") {
            Some(value) => changed.push(value.to_owned()),
            None if word == "--set" => {
                changed.extend(words.peek().map(|value| (*value).to_owned()))
            }
            None => {}
        }
    }
    changed
}

fn expectation(verdict: &Verdict) -> Expectation {
    let unit = quantities::si_unit(&verdict.quantity);
    let space = if unit.is_empty() { "" } else { " " };
    let measured = match (verdict.measured, verdict.at_s) {
        (Some(x), Some(at_s)) => format!(
            "measured {}{space}{unit} at {at_s} s",
            number(ilon_trace::significant(x, 4))
        ),
        (Some(x), None) => format!(
            "measured {}{space}{unit}",
            number(ilon_trace::significant(x, 4))
        ),
        (None, _) => "it does not apply to this run".to_owned(),
    };
    Expectation {
        quantity: verdict.quantity.clone(),
        bound: format!("{}{space}{unit}", verdict.bound),
        measured,
        held: verdict.held,
    }
}
