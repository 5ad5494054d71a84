//! The page of a study: the findings first, then each quantity over the varied keys.
//!
//! A page of ten thousand runs stays below two megabytes: figures are drawn here, from as many
//! points as are distinguishable, and interactive data is thinned.

mod chart;
mod input;
mod parallel;
mod shape;

use std::fmt::Write;

pub use self::input::{Bar, Quantity, Run, Sensitivity, StudyInput, Varied, figure};
use crate::page::{self, Head, Section, answers, escape, side_by_side, table};

/// Number of runs listed at each end of a quantity.
const LISTED: usize = 5;

/// Number of quantities with figures.
const DRAWN: usize = 6;

/// Returns the page. `command` returns the command that repeats a run.
pub fn html(shown: &StudyInput, command: &dyn Fn(u64) -> String) -> String {
    let head = Head {
        kind: "study",
        title: shown.name.clone(),
        facts: shown.facts.iter().map(|fact| escape(fact)).collect(),
        lead: answers(&shown.answers),
    };
    let mut sections = Vec::new();
    let figures = shape::figures(shown, DRAWN);
    if !figures.is_empty() {
        sections.push(Section {
            id: "curves",
            title: "Effects",
            lead: "Each quantity over what was varied. A dashed line is its bound.".to_owned(),
            body: side_by_side(&figures.iter().map(chart::card).collect::<String>()),
        });
    }
    if !shown.sensitivity.is_empty() {
        let bars: String = shown.sensitivity.iter().map(chart::bars).collect();
        sections.push(Section {
            id: "sensitivity",
            title: "What matters",
            lead: String::new(),
            body: side_by_side(&bars),
        });
    }
    if shown.varied.len() > 1 && shown.runs.len() > 1 {
        sections.push(Section {
            id: "all-runs",
            title: "All runs",
            lead: "A line is a run. Drag along an axis to keep the runs that pass there; click the axis to let go.".to_owned(),
            body: parallel::parallel(shown),
        });
    }
    if !shown.tables.is_empty() {
        sections.push(Section {
            id: "figures",
            title: "Figures",
            lead: String::new(),
            body: shown.tables.iter().map(table).collect(),
        });
    }
    let listed = listed(shown, command);
    if !listed.is_empty() {
        sections.push(Section {
            id: "runs",
            title: "Best and worst runs",
            lead: "With the command that runs each again, to look at it.".to_owned(),
            body: listed,
        });
    }
    let footer = "<p>All runs are in <code>runs.parquet</code>, one row each, which pandas, polars and DuckDB read; what was found \
                  is in <code>findings.json</code>.</p>";
    let parts = page::Parts {
        after: &[parallel::SCRIPT],
        ..page::Parts::default()
    };
    page::page(&head, &sections, footer, &parts)
}

/// The runs at both ends of each quantity, after failed ones.
fn listed(shown: &StudyInput, command: &dyn Fn(u64) -> String) -> String {
    let mut html = String::new();
    let mut list = |title: String, runs: &[&Run], quantity: Option<usize>| {
        if runs.is_empty() {
            return;
        }
        let mut rows = String::new();
        for run in runs {
            let values: String = (run.values.iter().enumerate())
                .map(|(key, value)| format!("<td>{}</td>", escape(&shown.value(key, *value))))
                .collect();
            let figure = quantity
                .and_then(|quantity| run.figures[quantity])
                .map_or("failed".to_owned(), figure);
            let _ = write!(
                rows,
                "<tr><td>{}</td><td>{figure}</td>{values}<td style=\"text-align:left\"><code>{}</code></td></tr>",
                run.run,
                escape(&command(run.run))
            );
        }
        let keys: String = shown
            .varied
            .iter()
            .map(|varied| format!("<th>{}</th>", escape(&varied.key)))
            .collect();
        let name = quantity.map_or("", |quantity| shown.quantities[quantity].name.as_str());
        let _ = writeln!(
            html,
            "<div class=\"card scroll\" tabindex=\"0\" style=\"margin-top:1rem\"><table><caption>{}</caption><thead><tr><th>run</th>\
             <th>{}</th>{keys}<th>again</th></tr></thead><tbody>{rows}</tbody></table></div>",
            escape(&title),
            escape(name)
        );
    };
    for (index, quantity) in shown.quantities.iter().enumerate().take(DRAWN) {
        let mut ranked: Vec<(&Run, f64)> = shown
            .runs
            .iter()
            .filter_map(|run| Some((run, run.figures[index]?)))
            .collect();
        ranked.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.run.cmp(&b.0.run)));
        let ranked: Vec<&Run> = ranked.into_iter().map(|(run, _)| run).collect();
        let count = LISTED.min(ranked.len().div_ceil(2));
        list(
            format!("{}: least", quantity.name),
            &ranked[..count],
            Some(index),
        );
        let largest: Vec<&Run> = ranked[count..].iter().rev().take(LISTED).copied().collect();
        list(format!("{}: largest", quantity.name), &largest, Some(index));
    }
    let failed: Vec<&Run> = shown
        .runs
        .iter()
        .filter(|run| run.has_failed)
        .take(LISTED)
        .collect();
    list("failed: the first".to_owned(), &failed, None);
    html
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A study without runs has no headings above nothing.
    #[test]
    fn what_a_study_has_none_of_has_no_heading() {
        let headings =
            |study: &StudyInput| html(study, &|run| run.to_string()).matches("<h2").count();
        assert_eq!(headings(&StudyInput::default()), 0);
        let study = StudyInput {
            runs: vec![Run {
                run: 0,
                scenario: 0,
                values: Vec::new(),
                figures: vec![Some(1.0)],
                has_failed: false,
            }],
            quantities: vec![Quantity {
                name: "slip_energy_j".to_owned(),
                bound: None,
            }],
            ..StudyInput::default()
        };
        let page = html(&study, &|run| run.to_string());
        assert!(page.contains("Best and worst runs"), "{page}");
    }
}
