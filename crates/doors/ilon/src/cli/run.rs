//! `ilon run`: simulates scenarios, or a robot alone, and writes the results.

mod one;
mod standard;

use std::collections::BTreeSet;

use super::failure::Failure;
use super::kind::{Kind, kind, wants};
use super::outcome::Outcome;
pub(super) use one::{Arguments, recorded};
use one::{Told, load, one, out_folder, print_json};

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let files = arguments.sandbox.files()?;
    if let [path] = arguments.scenarios.as_slice()
        && kind(path, &files) == Some(Kind::Robot)
    {
        return standard::run(path, arguments, &files);
    }
    // All are read before the first runs: an error in the last costs no simulation time.
    let mut scenarios = Vec::new();
    let mut taken = BTreeSet::new();
    for path in &arguments.scenarios {
        wants(path, &[Kind::Scenario], &files)?;
        let scenario = load(path, arguments, &files)?;
        if !taken.insert(scenario.name.clone()) {
            return Err(Failure::usage(
                format!(
                    "two of the scenarios are named `{}`: their results would share a folder",
                    scenario.name
                ),
                "run them one by one, each with its own --out",
            ));
        }
        scenarios.push((path, scenario));
    }
    let is_alone = scenarios.len() == 1;
    let mut summaries = Vec::new();
    for (path, scenario) in &scenarios {
        let out = out_folder(&arguments.out, &scenario.name, is_alone);
        let (json, _) = one(path, scenario, out, arguments, Told::InFull)?;
        summaries.push(json);
    }
    print_json(arguments, &summaries)?;
    Ok(Outcome::Done)
}
