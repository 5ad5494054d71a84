//! All runs of a study as parallel coordinates.

use super::chart::Placement;
use super::input::{Run, StudyInput};
use super::shape::varying;
use crate::page::json_in_script;
use ilon_trace::significant;

/// The script that draws the parallel coordinates.
pub(super) const SCRIPT: &str = include_str!("parallel.js");

/// Number of steps of the values for the browser.
const STEPS: f64 = 4095.0;
/// Largest number of values for the browser, which keeps the page below two megabytes.
const MOST_NUMBERS: usize = 200_000;

/// All runs as parallel coordinates: the drawing's element and its data.
pub(super) fn parallel(shown: &StudyInput) -> String {
    let keys = varying(shown);
    let quantities: Vec<usize> = (0..shown.quantities.len())
        .filter(|quantity| {
            shown
                .runs
                .iter()
                .any(|run| run.figures[*quantity].is_some())
        })
        .collect();
    let columns = keys.len() + quantities.len();
    let done: Vec<&Run> = shown.runs.iter().filter(|run| !run.has_failed).collect();
    let every = (done.len() * columns).div_ceil(MOST_NUMBERS).max(1);
    let runs: Vec<&Run> = done.into_iter().step_by(every).collect();
    let column = |name: &str, is_log: bool, words: &[String], of: &dyn Fn(&Run) -> Option<f64>| {
        let values: Vec<Option<f64>> = runs.iter().map(|run| of(run)).collect();
        let place = Placement::of(values.iter().flatten().copied(), is_log, 0.0, STEPS, 0.0);
        // -1 for a missing value.
        let steps: Vec<i64> = values
            .iter()
            .map(|x| x.map_or(-1, |x| place.at(x).round() as i64))
            .collect();
        let (low, high) = if is_log {
            (10_f64.powf(place.low), 10_f64.powf(place.high))
        } else {
            (place.low, place.high)
        };
        serde_json::json!({
            "name": name, "low": significant(low, 4), "high": significant(high, 4), "log": is_log, "words": words, "at": steps,
        })
    };
    let mut all: Vec<serde_json::Value> = Vec::new();
    for key in &keys {
        let varied = &shown.varied[*key];
        all.push(column(&varied.key, varied.is_log, &varied.words, &|run| {
            run.values.get(*key).copied()
        }));
    }
    for quantity in &quantities {
        all.push(column(
            &shown.quantities[*quantity].name,
            false,
            &[],
            &|run| run.figures[*quantity],
        ));
    }
    let thinned = match every {
        1 => String::new(),
        every => format!("<p>One of {every} runs is shown.</p>"),
    };
    let numbers: Vec<u64> = runs.iter().map(|run| run.run).collect();
    let data = serde_json::json!({ "runs": numbers, "columns": all, "colour": keys.len() });
    format!(
        "<figure class=\"whole\">{thinned}<canvas id=\"parallel\" style=\"width:100%;height:380px;touch-action:none\" \
         role=\"img\" aria-label=\"All runs as parallel coordinates\"></canvas>\
         <p id=\"parallel-words\" aria-live=\"polite\"></p>\
         <script type=\"application/json\" id=\"parallel-data\">{}</script></figure>\n",
        json_in_script(&data.to_string())
    )
}
