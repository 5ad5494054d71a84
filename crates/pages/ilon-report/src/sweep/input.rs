//! What the page of a study shows.

use ilon_trace::number;

use crate::page::{Answer, Table};
use crate::short;

/// A study as it is shown.
#[derive(Clone, Debug, Default)]
pub struct StudyInput {
    /// Its name.
    pub name: String,
    /// What it was, as plain text: its scenarios, how points were chosen, how many.
    pub facts: Vec<String>,
    /// What was found, the most important first.
    pub answers: Vec<Answer>,
    /// What was varied.
    pub varied: Vec<Varied>,
    /// The quantities that it looks at, the most important first.
    pub quantities: Vec<Quantity>,
    /// Its runs, in the order of their numbers.
    pub runs: Vec<Run>,
    /// What each axis does to each quantity, where the study asks that.
    pub sensitivity: Vec<Sensitivity>,
    /// Tables of figures, such as quantiles.
    pub tables: Vec<Table>,
    /// Whether the points are drawn, so that they are shown as a cloud and not as curves.
    pub is_sample: bool,
}

/// A key that differs between runs.
#[derive(Clone, Debug)]
pub struct Varied {
    /// The key, with dots.
    pub key: String,
    /// The words that it takes, of one whose values are not all numbers: values are places in this list.
    pub words: Vec<String>,
    /// Whether it is spaced by its logarithm.
    pub is_log: bool,
}

/// A quantity of the summary.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Its name in `summary.json`.
    pub name: String,
    /// A value that it is held against: a bound of the study, or the one whose crossing is sought.
    pub bound: Option<f64>,
}

/// One run.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its number.
    pub run: u64,
    /// Which of several scenarios it is of; 0 where there is one.
    pub scenario: usize,
    /// The value of each varied key, of words their place in [`Varied::words`].
    pub values: Vec<f64>,
    /// Each of the quantities; `None` where it failed or they do not apply.
    pub figures: Vec<Option<f64>>,
    /// Whether it failed.
    pub has_failed: bool,
}

/// What each axis does to one quantity.
#[derive(Clone, Debug)]
pub struct Sensitivity {
    /// The quantity, and what the bars are.
    pub title: String,
    /// What is to be read from it, as plain text.
    pub caption: String,
    /// What the two bars of each axis are.
    pub names: [String; 2],
    /// Each axis with its two bars, and where each lies with 95 % where that is known.
    pub bars: Vec<(String, [Bar; 2])>,
}

/// A bar, and where its end lies with 95 %.
pub type Bar = (f64, Option<(f64, f64)>);

/// A number for reading, of four digits.
pub fn figure(x: f64) -> String {
    number(short(x, 4))
}

impl StudyInput {
    /// The value of a key as it is read.
    pub(super) fn value(&self, key: usize, value: f64) -> String {
        match self.varied[key].words.get(value as usize) {
            Some(word) => word.clone(),
            None => figure(value),
        }
    }
}
