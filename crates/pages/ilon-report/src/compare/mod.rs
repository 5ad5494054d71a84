//! Comparison of several runs: their settings and results.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use ilon_files::FileAccess;
use ilon_files::toml::leaves;
use ilon_trace::quantities::GROUPS;
use ilon_trace::{Header, Quantity, Settings, Summary, Trace, TraceError, number};
use serde::Serialize;
use thiserror::Error;
use toml::{Table, Value};

mod figures;
mod page;
mod ranking;

pub(crate) use page::settings_row;
pub use page::{answers, html};
pub use ranking::{Named, change, verdicts};

/// One of the compared runs.
#[derive(Clone, Debug)]
pub struct ComparedRun {
    /// Its name in the comparison.
    pub name: String,
    /// What was recorded.
    pub trace: Trace,
    /// Its figures.
    pub summary: Summary,
}

/// Reasons why runs cannot be compared.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CompareError {
    /// The file or folder of a run is inaccessible.
    #[error("cannot read `{}`: {source}", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A folder without a run.
    #[error("`{}` holds no run: there is no trace.parquet in it", path.display())]
    NoRun {
        /// The folder.
        path: PathBuf,
    },
    /// The trace cannot be read.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// The folder's summary is not one.
    #[error("`{}` is not the summary of a run: {reason}", path.display())]
    Summary {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Fewer than two runs.
    #[error("a comparison takes two runs or more")]
    TooFew,
}

/// Compared runs, in the order given.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The runs, with unique names.
    pub runs: Vec<ComparedRun>,
    /// Differences in settings: the keys of the scenarios that not all runs share.
    pub differences: Vec<SettingRow>,
}

/// A key of the scenario with different values in the runs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SettingRow {
    /// The dotted key, such as `world.floor.friction`.
    pub key: String,
    /// Its value in each run, as TOML; `None` where the run has no such key.
    pub values: Vec<Option<String>>,
}

impl ComparedRun {
    /// Reads a run from the folder of `ilon run`, or from a trace file alone. The figures are read
    /// from the folder's `summary.json` if it belongs to that trace, otherwise computed from the
    /// trace.
    ///
    /// # Errors
    /// If there is no readable trace, or the folder's `summary.json` is not a summary.
    pub fn load(path: &Path) -> Result<Self, CompareError> {
        let is_folder = std::fs::metadata(path)
            .map_err(|source| CompareError::Read {
                path: path.to_owned(),
                source,
            })?
            .is_dir();
        let trace_path = if is_folder {
            path.join("trace.parquet")
        } else {
            path.to_owned()
        };
        if is_folder && !trace_path.exists() {
            return Err(CompareError::NoRun {
                path: path.to_owned(),
            });
        }
        let trace = Trace::read_parquet(&trace_path)?;
        let mut summary = Summary::of(&trace, &Settings::default());
        if is_folder && let Some(written) = written(&path.join("summary.json"))? {
            // One of another trace says nothing of this one.
            if written.trace_hash == summary.trace_hash {
                summary = written;
            }
        }
        Ok(Self {
            name: trace.header.scenario_name.clone(),
            trace,
            summary,
        })
    }

    /// A run from memory.
    pub fn new(name: String, trace: Trace, summary: Summary) -> Self {
        Self {
            name,
            trace,
            summary,
        }
    }
}

impl Comparison {
    /// Compares runs. `paths` are their sources, used for unique names.
    ///
    /// # Errors
    /// Fewer than two runs.
    pub fn of(runs: Vec<ComparedRun>, paths: &[PathBuf]) -> Result<Self, CompareError> {
        if runs.len() < 2 {
            return Err(CompareError::TooFew);
        }
        let mut runs = runs;
        let names = names(&runs, paths);
        for (run, name) in runs.iter_mut().zip(names) {
            run.name = name;
        }
        let differences = differences(&runs);
        Ok(Self { runs, differences })
    }

    /// The name and the summary of each run, as JSON.
    pub fn summaries(&self) -> Vec<serde_json::Value> {
        let of =
            |run: &ComparedRun| serde_json::json!({ "name": run.name, "summary": run.summary });
        self.runs.iter().map(of).collect()
    }

    /// Returns the main figures that apply to at least one of the runs, in groups with headings;
    /// figures for open-loop runs only if all are open-loop.
    pub fn groups(&self) -> Vec<(&'static str, Vec<&'static Quantity>)> {
        let open_loop = self.runs.iter().all(|run| run.trace.header.open_loop);
        let applies = |quantity: &&Quantity| {
            let mut values = self.runs.iter().map(|run| quantity.value(&run.summary));
            quantity.is_main && values.any(|value| value.is_some())
        };
        let groups = GROUPS
            .iter()
            .filter(|group| open_loop || !group.open_loop_only)
            .map(|group| {
                let quantities = group.quantities.iter().filter(applies);
                (group.heading, quantities.collect::<Vec<_>>())
            });
        groups
            .filter(|(_, quantities)| !quantities.is_empty())
            .collect()
    }
}

/// Returns unique names: the scenarios' if they differ, else those of the files or folders, else
/// the whole paths, else numbered ones.
fn names(runs: &[ComparedRun], paths: &[PathBuf]) -> Vec<String> {
    let of_scenarios = runs.iter().map(|run| run.name.clone()).collect();
    let last = |path: &PathBuf| {
        let name = path.file_stem().unwrap_or(path.as_os_str());
        name.to_string_lossy().into_owned()
    };
    let of_files = paths.iter().map(last).collect();
    let of_paths = paths.iter().map(|p| p.display().to_string()).collect();
    let candidates: [Vec<String>; 3] = [of_scenarios, of_files, of_paths];
    let differ = |names: &Vec<String>| {
        names.len() == runs.len() && names.iter().collect::<BTreeSet<_>>().len() == names.len()
    };
    match candidates.iter().find(|names| differ(names)) {
        Some(names) => names.clone(),
        None => {
            let numbered = runs.iter().enumerate();
            numbered
                .map(|(k, run)| format!("{} ({})", run.name, k + 1))
                .collect()
        }
    }
}

fn differences(runs: &[ComparedRun]) -> Vec<SettingRow> {
    let texts = runs
        .iter()
        .map(|run| run.trace.header.scenario_toml.as_str());
    let settings = settings_that_differ(&texts.collect::<Vec<_>>());
    let (derived, set): (Vec<_>, Vec<_>) = settings
        .into_iter()
        .partition(|row| DERIVED.contains(&row.key.as_str()));
    let robots: Vec<_> = runs.iter().map(|run| robot(&run.trace.header)).collect();
    let mut rows = set;
    rows.extend(rows_that_differ(&robots));
    rows.extend(derived);
    rows
}

/// Keys whose defaults follow from the robot.
const DERIVED: [&str; 3] = [
    "wheel_loop.proportional_n_m_s",
    "wheel_loop.integral_n_m",
    "world.solver.contact_stiffness_n_m",
];

/// What a trace says of its robot, whose file the scenario only names.
fn robot(header: &Header) -> BTreeMap<String, String> {
    // Rounded, as places in the body frame carry the rounding of the frames between.
    let shown = |value: f64, unit: &str| format!("{} {unit}", number((value * 1e9).round() / 1e9));
    let mut found = BTreeMap::from([("robot: mass".to_owned(), shown(header.mass_kg, "kg"))]);
    for wheel in &header.wheels {
        let [x_m, y_m] = wheel.position_m;
        let [torque, rate] = [
            (wheel.torque_limit_n_m, "N m"),
            (wheel.rate_limit_rad_s, "rad/s"),
        ]
        .map(|(limit, unit)| limit.map_or_else(|| "none".to_owned(), |limit| shown(limit, unit)));
        let of_wheel = [
            ("radius", shown(wheel.radius_m, "m")),
            ("x", shown(x_m, "m")),
            ("y", shown(y_m, "m")),
            ("torque limit", torque),
            ("rate limit", rate),
        ];
        let rolls = match wheel.has_tyre() {
            true => vec![("tyre width", shown(wheel.width_m, "m"))],
            false => vec![
                ("gamma", shown(wheel.gamma_rad.to_degrees(), "deg")),
                ("rollers", wheel.roller_count.to_string()),
            ],
        };
        for (what, value) in of_wheel.into_iter().chain(rolls) {
            found.insert(format!("robot: {} {what}", wheel.name), value);
        }
    }
    found
}

/// Returns the keys in which resolved scenarios differ, except their expectations, which do not
/// change a run.
pub(crate) fn settings_that_differ(scenarios: &[&str]) -> Vec<SettingRow> {
    let keys: Vec<_> = scenarios.iter().map(|text| values_by_key(text)).collect();
    rows_that_differ(&keys)
}

/// The entries that not all of the lists share, in the order of their keys.
fn rows_that_differ(keys: &[BTreeMap<String, String>]) -> Vec<SettingRow> {
    let all: BTreeSet<&String> = keys.iter().flat_map(BTreeMap::keys).collect();
    all.into_iter()
        .filter(|key| *key != "expect" && !key.starts_with("expect."))
        .filter_map(|key| {
            let values: Vec<_> = keys.iter().map(|of| of.get(key).cloned()).collect();
            let differ = |values: &[Option<String>]| values.iter().any(|value| value != &values[0]);
            let short = |value: &Option<String>| match value.as_ref()?.parse::<f64>() {
                Ok(number) => Some(ilon_trace::number(ilon_trace::significant(number, 4))),
                Err(_) => value.clone(),
            };
            let shorter: Vec<_> = values.iter().map(short).collect();
            differ(&values).then(|| SettingRow {
                key: key.clone(),
                values: if differ(&shorter) { shorter } else { values },
            })
        })
        .collect()
}

/// Returns the values of a TOML document by their dotted keys. For a path only the file name
/// counts, because the same robot has different paths from different folders.
fn values_by_key(text: &str) -> BTreeMap<String, String> {
    let shown = |(key, value): (String, Value)| {
        let text = match value {
            // An empty list.
            Value::Array(_) | Value::Table(_) => return None,
            Value::String(path) if key.ends_with("file") => {
                let name = Path::new(&path).file_name().unwrap_or_default();
                name.to_string_lossy().into_owned()
            }
            Value::String(text) => text,
            value => value.to_string(),
        };
        Some((key, text))
    };
    let table: Table = text.parse().unwrap_or_default();
    leaves(&table).into_iter().filter_map(shown).collect()
}

/// The summary in a file; `None` if there is none.
fn written(path: &Path) -> Result<Option<Summary>, CompareError> {
    let bad = |reason| CompareError::Summary {
        path: path.to_owned(),
        reason,
    };
    match FileAccess::anywhere().read(path, SUMMARY_BYTES) {
        Ok(json) => {
            let summary = serde_json::from_slice(&json).map_err(|e| bad(e.to_string()));
            summary.map(Some)
        }
        Err(_) if !path.is_symlink() && !path.exists() => Ok(None),
        Err(reason) => Err(bad(reason.to_string())),
    }
}

/// Largest size of a summary, in bytes.
const SUMMARY_BYTES: u64 = 64 << 20;

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_trace::WheelHeader;

    fn run(name: &str, scenario_toml: &str) -> ComparedRun {
        let header = Header {
            scenario_name: name.to_owned(),
            scenario_toml: scenario_toml.to_owned(),
            ..Header::default()
        };
        let trace = Trace::with_capacity(header, 0);
        ComparedRun {
            name: name.to_owned(),
            summary: Summary::of(&trace, &Settings::default()),
            trace,
        }
    }

    #[test]
    fn only_the_keys_that_differ_are_told() {
        let grippy = "[robot]\nfile = \"../a/r.urdf\"\n[world.floor]\nfriction = 0.8\nslope_deg = 0\n[expect]\nx = 1\n";
        let slick = "[robot]\nfile = \"b/r.urdf\"\n[world.floor]\nfriction = 0.2\nslope_deg = 0\n\
                     [[world.floor.patches]]\nfriction = 0.02\n";
        let runs = vec![run("grippy", grippy), run("slick", slick)];
        let comparison = Comparison::of(runs, &[]).expect("two runs");
        let row = |key: &str, values: [Option<&str>; 2]| SettingRow {
            key: key.to_owned(),
            values: values.map(|value| value.map(str::to_owned)).to_vec(),
        };
        assert_eq!(
            comparison.differences,
            [
                row("world.floor.friction", [Some("0.8"), Some("0.2")]),
                row("world.floor.patches.0.friction", [None, Some("0.02")]),
            ]
        );
    }

    #[test]
    fn robots_are_held_beside_each_other_and_what_follows_from_them_comes_last() {
        let of = |name: &str, radius_m: f64, further: &str| {
            let mut run = run(name, further);
            run.trace.header.wheels.push(WheelHeader {
                name: "front_left".to_owned(),
                radius_m,
                ..WheelHeader::default()
            });
            run
        };
        let runs = vec![
            of("a", 0.0762, "wheel_loop.integral_n_m = 1.0\nzeta = 1"),
            of("b", 0.1, "wheel_loop.integral_n_m = 2.0\nzeta = 2"),
        ];
        let comparison = Comparison::of(runs, &[]).expect("two runs");
        let keys = comparison.differences.iter().map(|row| row.key.as_str());
        assert_eq!(
            keys.collect::<Vec<_>>(),
            [
                "zeta",
                "robot: front_left radius",
                "wheel_loop.integral_n_m"
            ]
        );
        let radii = &comparison.differences[1].values;
        assert_eq!(
            radii,
            &["0.0762 m", "0.1 m"].map(|radius| Some(radius.to_owned()))
        );
    }

    #[test]
    fn runs_of_one_scenario_are_told_apart_by_their_folders() {
        let named = |names: [&str; 2], paths: [&str; 2]| -> Vec<String> {
            let runs = names.map(|name| run(name, "")).to_vec();
            let paths = paths.map(PathBuf::from);
            let comparison = Comparison::of(runs, &paths).expect("two runs");
            comparison.runs.into_iter().map(|run| run.name).collect()
        };
        assert_eq!(named(["a", "b"], ["out/x", "out/y"]), ["a", "b"]);
        assert_eq!(named(["a", "a"], ["out/x", "out/y"]), ["x", "y"]);
        assert_eq!(named(["a", "a"], ["x/run", "y/run"]), ["x/run", "y/run"]);
        assert_eq!(named(["a", "a"], ["run", "run"]), ["a (1)", "a (2)"]);
    }

    #[test]
    fn one_run_is_nothing_to_compare() {
        assert!(Comparison::of(vec![run("a", "")], &[]).is_err());
    }

    #[test]
    fn a_folder_without_a_run_is_said_to_hold_none() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let empty = ComparedRun::load(&folder);
        assert!(
            matches!(empty, Err(CompareError::NoRun { .. })),
            "{empty:?}"
        );
        let missing = ComparedRun::load(&folder.join("trace.parquet"));
        assert!(
            matches!(missing, Err(CompareError::Read { .. })),
            "{missing:?}"
        );
    }
}
