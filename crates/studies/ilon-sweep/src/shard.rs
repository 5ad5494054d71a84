//! Shards of a study, run separately, and the folders of their rows.

use std::fs;
use std::path::{Path, PathBuf};

use ilon_sim::Error;

/// One of several parts of a study, run separately, such as the jobs of an array on a cluster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Its index, from 1.
    index: u64,
    /// Number of shards.
    count: u64,
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(index, count)| {
            let number = |text: &str| text.trim().parse::<u64>().ok();
            Some((number(index)?, number(count)?))
        });
        match numbers {
            Some((index, count)) if index >= 1 && index <= count => Ok(Self { index, count }),
            _ => Err("write I/N with I from 1 to N, such as 3/8".to_owned()),
        }
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl Shard {
    /// Whether a run belongs to this shard. Neighbouring runs go to different shards, which evens
    /// out their durations.
    pub fn holds(&self, run: u64) -> bool {
        run % self.count == self.index - 1
    }

    /// Returns the folder of its rows, inside that of the study.
    pub(crate) fn folder(&self) -> String {
        format!("{PART}{}-of-{}", self.index, self.count)
    }
}

/// Prefix of the folders of shards.
const PART: &str = "shard-";

/// Returns the folders of shards in a folder, in the order of their names.
pub(crate) fn folders_in(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(Error::io("read", folder))?,
    };
    let mut parts = Vec::new();
    for entry in entries {
        let entry = entry.map_err(Error::io("read", folder))?;
        if entry.file_name().to_string_lossy().starts_with(PART) && entry.path().is_dir() {
            parts.push(entry.path());
        }
    }
    parts.sort();
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_divide_the_runs_among_them() {
        let shards: Vec<Shard> = (1..=3).map(|i| format!("{i}/3").parse().unwrap()).collect();
        for run in 0..20 {
            assert_eq!(shards.iter().filter(|shard| shard.holds(run)).count(), 1);
        }
        for wrong in ["0/3", "4/3", "1", "a/b", "1/0", ""] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
