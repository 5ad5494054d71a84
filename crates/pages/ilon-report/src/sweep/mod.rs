//! The page of a study: the findings first, then each quantity over the varied keys.
//!
//! A page of ten thousand runs stays below two megabytes: figures are drawn here, from as many
//! points as are distinguishable.

mod chart;
mod input;
mod shape;

use std::fmt::Write;

pub use self::input::{Bar, Quantity, Run, Sensitivity, StudyInput, Varied, figure};
use crate::html_table::{self, cell, heads};
use crate::page::{self, Head, Section, answers, escape, side_by_side, table};

/// Largest number of runs in the table, so that the page stays small.
const MOST_LISTED: usize = 400;

/// Number of quantities with figures.
const DRAWN: usize = 6;

/// Returns the page. `command` returns the command that repeats a run.
pub fn html(shown: &StudyInput, command: &dyn Fn(u64) -> String) -> String {
    let head = Head {
        kind: "study",
        title: shown.name.clone(),
        facts: shown.facts.iter().map(|fact| escape(fact)).collect(),
        lead: match shape::trade(shown) {
            Some(trade) => format!(
                "<div class=\"beside\">{}{}</div>\n",
                answers(&shown.answers),
                // It stands before all sections.
                chart::card(&trade, leads(shown)).replace("h3>", "h2>")
            ),
            None => answers(&shown.answers),
        },
    };
    let mut sections = Vec::new();
    let figures = shape::figures(shown, DRAWN);
    if !figures.is_empty() {
        sections.push(Section {
            id: "curves",
            title: "Effects",
            lead: "Each quantity over what was varied. A ring marks the least, a dashed line the bound.".to_owned(),
            body: side_by_side(&figures.iter().map(|one| chart::card(one, leads(shown))).collect::<String>()),
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
    if !shown.tables.is_empty() {
        sections.push(Section {
            id: "figures",
            title: "Figures",
            lead: String::new(),
            body: shown.tables.iter().map(table).collect(),
        });
    }
    if !shown.runs.is_empty() {
        sections.push(Section {
            id: "runs",
            title: "The runs",
            lead: runs_lead(shown),
            body: runs(shown, command),
        });
    }
    let footer = "<p>All runs are in <code>runs.parquet</code>, one row each, which pandas, polars and DuckDB read; what was found \
                  is in <code>findings.json</code>.</p>";
    page::page(&head, &sections, footer, &page::Parts::default())
}

/// The runs of the table: all, or the failed ones and those at both ends of the first quantity.
fn listed(shown: &StudyInput) -> Vec<&Run> {
    let mut ranked: Vec<&Run> = shown.runs.iter().collect();
    if ranked.len() <= MOST_LISTED {
        return ranked;
    }
    let key = |run: &Run| {
        run.figures
            .first()
            .copied()
            .flatten()
            .unwrap_or(f64::NEG_INFINITY)
    };
    ranked.sort_by(|a, b| key(a).total_cmp(&key(b)));
    ranked.drain(MOST_LISTED / 2..ranked.len() - MOST_LISTED / 2);
    ranked
}

/// Whether points lead to the rows of their runs: not where some runs have no row.
fn leads(shown: &StudyInput) -> bool {
    shown.runs.len() <= MOST_LISTED
}

fn runs_lead(shown: &StudyInput) -> String {
    let which = match leads(shown) {
        true => "A click on a point of a curve or a field above leads to its run. ".to_owned(),
        false => {
            format!("The {MOST_LISTED} runs at both ends of the first quantity, and failed ones. ")
        }
    };
    format!(
        "{which}The command of a row simulates its run again and writes its report. A click on a heading sorts. The least and \
         the largest of a column are bold."
    )
}

/// The table of the runs, each with its command.
fn runs(shown: &StudyInput, command: &dyn Fn(u64) -> String) -> String {
    let quantities = &shown.quantities[..shown.quantities.len().min(DRAWN)];
    let listed = listed(shown);
    let ends: Vec<(f64, f64)> = (0..quantities.len())
        .map(|index| {
            let values = listed.iter().filter_map(|run| run.figures[index]);
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, largest), x| {
                (least.min(x), largest.max(x))
            })
        })
        .collect();
    let mut rows = String::new();
    for run in listed {
        let values = run.values.iter().enumerate();
        let values = values.map(|(key, value)| cell(Some(escape(&shown.value(key, *value)))));
        let figures = ends.iter().zip(&run.figures).map(|((least, largest), x)| {
            cell(x.map(
                |x| match least < largest && (x == *least || x == *largest) {
                    true => format!("<b>{}</b>", figure(x)),
                    false => figure(x),
                },
            ))
        });
        // Writing to a string cannot fail.
        let _ = write!(
            rows,
            "<tr id=\"run-{number}\"><td>{number}{failed}</td>{cells}<td class=\"words command\"><code>{command}</code></td></tr>",
            number = run.run,
            failed = if run.has_failed { " failed" } else { "" },
            cells = values.chain(figures).collect::<String>(),
            command = escape(&command(run.run)),
        );
    }
    let keys = shown.varied.iter().map(|varied| &varied.key);
    let names = keys.chain(quantities.iter().map(|quantity| &quantity.name));
    let heads = heads(
        ["run".to_owned()]
            .into_iter()
            .chain(names.map(|name| escape(name))),
    );
    let command = "<th scope=\"col\" class=\"words\">command</th>";
    html_table::sortable(&(heads + command), &rows)
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
        assert!(page.contains("The runs"), "{page}");
    }
}
