//! The machine, date and versions of a measurement.

use std::time::SystemTime;

use super::figures::Machine;
use chrono::{DateTime, SecondsFormat, Utc};

/// This machine, at this moment.
pub(super) fn this_machine() -> Machine {
    let now: DateTime<Utc> = SystemTime::now().into();
    let versions = [("ilon", env!("CARGO_PKG_VERSION")), ENGINE];
    Machine {
        processor: processor(),
        cores: std::thread::available_parallelism()
            .ok()
            .map(std::num::NonZero::get),
        system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        versions: versions
            .map(|(name, version)| (name.to_owned(), version.to_owned()))
            .to_vec(),
        optimised: !cfg!(debug_assertions),
        date: now.to_rfc3339_opts(SecondsFormat::Secs, true),
    }
}

/// The physics engine, in the version that `Cargo.toml` requires.
const ENGINE: (&str, &str) = ("rapier3d-f64", "0.36");

/// The processor's name, where the system provides it in a file.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_engine_is_the_one_that_is_built() {
        let manifest: toml::Table =
            toml::from_str(include_str!("../../../../../Cargo.toml")).expect("a manifest");
        let asked = &manifest["workspace"]["dependencies"]["rapier3d"];
        let word = |key: &str| asked[key].as_str();
        assert_eq!(
            (word("package"), word("version")),
            (Some(ENGINE.0), Some(ENGINE.1))
        );
    }
}
