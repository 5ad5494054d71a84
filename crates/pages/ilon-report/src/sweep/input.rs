//! The content of a study's page.

use ilon_trace::number;

use crate::page::{Answer, Table};
use ilon_trace::significant;

/// A study for display.
#[derive(Clone, Debug, Default)]
pub struct StudyInput {
    /// Its name.
    pub name: String,
    /// Facts, as plain text: its scenarios, the choice of points, their number.
    pub facts: Vec<String>,
    /// Findings, the most important first.
    pub answers: Vec<Answer>,
    /// The varied keys.
    pub varied: Vec<Varied>,
    /// The quantities of interest, the most important first.
    pub quantities: Vec<Quantity>,
    /// Its runs, in the order of their numbers.
    pub runs: Vec<Run>,
    /// Effects of each axis on each quantity, if computed.
    pub sensitivity: Vec<Sensitivity>,
    /// Tables of figures, such as quantiles.
    pub tables: Vec<Table>,
    /// Two quantities that pull apart along a key: their indices, the key's, and its value that is
    /// a compromise.
    pub trade: Option<([usize; 2], usize, f64)>,
    /// Whether the points are random draws, which are shown as a cloud instead of curves.
    pub is_sample: bool,
}

/// A key that differs between runs.
#[derive(Clone, Debug)]
pub struct Varied {
    /// The key, with dots.
    pub key: String,
    /// The texts of a key whose values are not all numbers; values are indices in this list.
    pub words: Vec<String>,
    /// Whether its scale is logarithmic.
    pub is_log: bool,
}

/// A quantity of the summary.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Its name in `summary.json`.
    pub name: String,
    /// A reference value: a bound of the study, or the value of a crossing.
    pub bound: Option<f64>,
}

/// One run.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its number.
    pub run: u64,
    /// Index of its scenario; 0 if there is one.
    pub scenario: usize,
    /// The value of each varied key; for texts the index in [`Varied::words`].
    pub values: Vec<f64>,
    /// Each of the quantities; `None` if it failed or they do not apply.
    pub figures: Vec<Option<f64>>,
    /// Whether it failed.
    pub has_failed: bool,
}

/// Effects of each axis on one quantity.
#[derive(Clone, Debug)]
pub struct Sensitivity {
    /// The quantity and the kind of bars.
    pub title: String,
    /// Reading instructions, as plain text.
    pub caption: String,
    /// Names of the two bars of each axis.
    pub names: [String; 2],
    /// Each axis with its two bars, with 95 % intervals if known.
    pub bars: Vec<(String, [Bar; 2])>,
}

/// A bar with the 95 % interval of its end.
pub type Bar = (f64, Option<(f64, f64)>);

/// Returns a number with four digits as text.
pub fn figure(x: f64) -> String {
    number(significant(x, 4))
}

impl StudyInput {
    /// Returns the value of a key as text.
    pub(super) fn value(&self, key: usize, value: f64) -> String {
        match self.varied[key].words.get(value as usize) {
            Some(word) => word.clone(),
            None => figure(value),
        }
    }
}
