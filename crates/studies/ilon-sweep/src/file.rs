//! The study file, written by the user.

use std::collections::BTreeMap;
use std::path::PathBuf;

use ilon_files::defaults::{number, thousandths, yes};
use schemars::JsonSchema;
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer, Serialize};
use toml::{Table, Value};

use ilon_sim::scenario::Bound;

/// The key of the noise seed.
pub(crate) const SEED: &str = "sensors.seed";

/// Largest number of runs of a study.
pub(crate) const MOST_RUNS: u64 = 10_000_000;

/// A study as it stands in its file. Paths are relative to the file.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Study")]
pub struct StudyFile {
    /// The scenario that is varied, or several: each is run at every point.
    pub scenario: OneOrMany,
    /// Keys of the scenario for all runs of the study.
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: Table,
    /// What is varied: keys of the scenario, each with a list of values, a range or a distribution.
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub axes: Table,
    /// Simulate the runs. Without, only the `design` quantities are computed: rank and condition of
    /// M, top speeds, accelerations without slip.
    #[serde(default = "yes", skip_serializing_if = "is_yes")]
    pub physics: bool,
    /// How points are chosen on the axes.
    #[serde(default)]
    pub method: Method,
    /// Number of points; none for `"grid"`. For `"sobol_indices"` and `"morris"` base points and
    /// trajectories, each of several runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<u64>,
    /// How often each point is run, each time with another `sensors.seed`.
    #[serde(default = "number::<1, u32>")]
    #[schemars(range(min = 1))]
    pub repetitions: u32,
    /// The seed of all that is drawn: the same seed gives the same study.
    #[serde(default)]
    pub seed: u32,
    /// Runs whose traces are kept: `"none"`, `"failed"`, `"worst 5"` or `"all"`.
    #[serde(default)]
    pub keep: Keep,
    /// The quantities of the summary that the study looks at, the most important first.
    #[serde(default)]
    pub quantities: Vec<String>,
    /// Where on a further axis a quantity crosses a value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub find: Option<Find>,
    /// At which point on the axes a quantity is least.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub minimise: Option<Minimise>,
    /// Bounds that the runs must keep, by the name of the quantity; held by `ilon check`.
    #[serde(
        default,
        skip_serializing_if = "BTreeMap::is_empty",
        deserialize_with = "bounds"
    )]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub expect: BTreeMap<String, ShareBound>,
}

impl StudyFile {
    /// The JSON Schema of the file.
    pub fn json_schema() -> serde_json::Value {
        schemars::schema_for!(Self).to_value()
    }
}

fn is_yes(value: &bool) -> bool {
    *value
}

/// One path, or several.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum OneOrMany {
    /// One.
    One(PathBuf),
    /// Several.
    Many(Vec<PathBuf>),
}

impl OneOrMany {
    /// All of them.
    pub fn paths(&self) -> &[PathBuf] {
        match self {
            Self::One(path) => std::slice::from_ref(path),
            Self::Many(paths) => paths,
        }
    }
}

/// How points are chosen on the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Every combination of the axes' values, the last axis fastest.
    #[default]
    Grid,
    /// Independent draws: Monte Carlo.
    Random,
    /// Latin hypercube: each axis is divided into as many parts of equal probability as there are
    /// points, each of which has one point.
    LatinHypercube,
    /// The Sobol sequence, scrambled after Owen: fills space evenly.
    Sobol,
    /// Which share of the variance each axis causes: Sobol indices by the design of Saltelli;
    /// `points * (axes + 2)` runs.
    SobolIndices,
    /// Which axes matter at all: elementary effects after Morris; `points * (axes + 1)` runs.
    Morris,
}

impl Method {
    /// The method's name in a study.
    pub fn word(self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::Random => "random",
            Self::LatinHypercube => "latin_hypercube",
            Self::Sobol => "sobol",
            Self::SobolIndices => "sobol_indices",
            Self::Morris => "morris",
        }
    }

    /// Whether the points are a sample of distributions, so that findings extend to the whole
    /// population.
    pub fn is_sample(self) -> bool {
        matches!(self, Self::Random | Self::LatinHypercube | Self::Sobol)
    }
}

/// Runs whose traces are kept: `"none"`, `"failed"`, `"worst 5"` or `"all"`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Keep {
    /// Of none.
    #[default]
    None,
    /// Of those that could not be finished, or broke a bound of the study's `[expect]`.
    Failed,
    /// Of so many in which the study's first quantity is largest.
    Worst(usize),
    /// Of all.
    All,
}

impl TryFrom<String> for Keep {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        match text.trim() {
            "none" => Ok(Self::None),
            "failed" => Ok(Self::Failed),
            "all" => Ok(Self::All),
            other => {
                let count = other.strip_prefix("worst").map(str::trim);
                let count = count.and_then(|count| count.parse().ok());
                count.filter(|count| *count > 0).map(Self::Worst).ok_or_else(|| {
                    format!("`keep` cannot be \"{other}\": write \"none\", \"failed\", \"worst 5\" or \"all\"")
                })
            }
        }
    }
}

impl From<Keep> for String {
    fn from(keep: Keep) -> Self {
        match keep {
            Keep::None => "none".to_owned(),
            Keep::Failed => "failed".to_owned(),
            Keep::Worst(count) => format!("worst {count}"),
            Keep::All => "all".to_owned(),
        }
    }
}

impl JsonSchema for Keep {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Keep".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "pattern": "^(none|failed|all|worst [1-9][0-9]*)$" })
    }
}

/// Where on an axis a quantity crosses a value.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Find {
    /// The key of the scenario that is searched over.
    pub key: String,
    /// The least value of it.
    pub from: f64,
    /// The largest value of it.
    pub to: f64,
    /// Whether the values are spaced by their logarithm.
    #[serde(default)]
    pub scale: Scale,
    /// The quantity of the summary.
    pub quantity: String,
    /// The value that it crosses.
    pub crosses: f64,
    /// Width of the final bracket, in the unit of the key.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub tolerance: f64,
    /// Values tried first, evenly over the range, to see several crossings.
    #[serde(default = "number::<9, u32>")]
    #[schemars(range(min = 2, max = 1000))]
    pub scan: u32,
}

/// At which point a quantity is least.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Minimise {
    /// The quantity of the summary; of repetitions their mean counts.
    pub quantity: String,
    /// Places from which the search starts, the first in the middle of all axes.
    #[serde(default = "number::<4, u32>")]
    #[schemars(range(min = 1, max = 1000))]
    pub starts: u32,
    /// Most points that are tried from each start.
    #[serde(default = "number::<60, u32>")]
    #[schemars(range(min = 4, max = 100_000))]
    pub evaluations: u32,
    /// How narrowly the place is searched, as a share of each axis.
    #[serde(default = "thousandths::<1>")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub tolerance: f64,
    /// Bounds that other quantities must keep there.
    #[serde(
        default,
        skip_serializing_if = "BTreeMap::is_empty",
        deserialize_with = "bounds"
    )]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub subject_to: BTreeMap<String, OneBound>,
}

/// A bound on a quantity.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OneBound {
    /// At least this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// At most this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}

/// A bound that a share of the runs must keep.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShareBound {
    /// At least this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// At most this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// The share of all runs that must keep it, above 0; a run that could not be finished does not.
    #[serde(default = "number::<1, f64>")]
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0))]
    pub share: f64,
}

impl ShareBound {
    /// The bound with its share.
    pub fn bound(&self) -> Bound {
        bound(self.min, self.max)
    }
}

impl OneBound {
    /// The bound alone.
    pub fn bound(&self) -> Bound {
        bound(self.min, self.max)
    }
}

fn bound(min: Option<f64>, max: Option<f64>) -> Bound {
    Bound {
        min,
        max,
        ..Bound::default()
    }
}

/// How values lie between two ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// Evenly by their logarithm.
    Log,
}

/// Reads bounds by the dotted names of their quantities, which may also be nested tables.
fn bounds<'de, D, T>(deserializer: D) -> Result<BTreeMap<String, T>, D::Error>
where
    D: Deserializer<'de>,
    T: DeserializeOwned,
{
    let mut bounds = BTreeMap::new();
    gather(Table::deserialize(deserializer)?, "", &mut bounds).map_err(D::Error::custom)?;
    Ok(bounds)
}

fn gather<T: DeserializeOwned>(
    table: Table,
    above: &str,
    bounds: &mut BTreeMap<String, T>,
) -> Result<(), String> {
    for (key, value) in table {
        let name = format!("{above}{key}");
        match value {
            Value::Table(inner) if !inner.is_empty() && inner.values().all(Value::is_table) => {
                gather(inner, &format!("{name}."), bounds)?;
            }
            value => {
                let bound = value.try_into();
                let bound = bound.map_err(|e: toml::de::Error| {
                    format!("the bound on `{name}`: {}", e.message())
                })?;
                if bounds.contains_key(&name) {
                    return Err(format!("the bound on `{name}` stands twice"));
                }
                bounds.insert(name, bound);
            }
        }
    }
    Ok(())
}
