//! Results of checked scenarios as text.

use std::path::PathBuf;
use std::time::Duration;

use ilon_trace::{Convergence, Header, Summary, quantities, to_microseconds};

use super::update::Update;
use crate::cli::converge;
use crate::cli::escape::{folded, one_line, path_in_line};
use crate::cli::failure::Failure;
use crate::cli::flags::shell;
use crate::cli::json::pretty;
use crate::cli::table::Table;
use crate::judge::{Difference, Verdict};

/// The result of one scenario.
pub(super) struct Checked {
    /// Its name in the output.
    pub label: String,
    pub path: PathBuf,
    pub took: Duration,
    pub result: Ended,
}

/// How one scenario ended.
pub(super) enum Ended {
    /// It ran.
    Judged(Judged),
    /// It could not run.
    Refused(Failure),
    /// It was not begun, because another had failed.
    Skipped,
}

/// The result of a scenario that ran.
#[derive(Default)]
pub(super) struct Judged {
    pub verdicts: Vec<Verdict>,
    /// The hash of all signals of the run; `None` for a study of many runs.
    pub trace_hash: Option<String>,
    /// How far its figures move at half the step; empty if it was not repeated.
    pub converge: Convergence,
    /// Differences from its baseline; `None` without a baseline.
    pub differences: Option<Vec<Difference>>,
    /// Headline figures that differ from the baseline's, one line each, in per cent.
    pub moved: Vec<String>,
    /// The page of the differences, if there are any.
    pub drawn: Option<PathBuf>,
    /// The changes that `--update` makes in the file.
    pub update: Option<Update>,
    /// Whether it is a study of many runs.
    pub is_study: bool,
}

/// The category of a scenario's result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Count {
    Held,
    Failed,
    /// Failed bounds were rewritten, and nothing else failed.
    Updated,
    /// It ran without expectations.
    NothingExpected,
    Refused,
    Skipped,
}

/// Categories with their names.
const WORDS: [(Count, &str); 6] = [
    (Count::Held, "held"),
    (Count::Failed, "failed"),
    (Count::Updated, "updated"),
    (Count::NothingExpected, "nothing expected"),
    (Count::Refused, "could not run"),
    (Count::Skipped, "skipped"),
];

/// The remark about a scenario without expectations.
pub(super) const NOTHING_EXPECTED: &str = "nothing is expected of it: it can only fail to run";

impl Judged {
    /// The changes of `--update`, and the failed bounds that it leaves, one line each.
    fn changes(&self) -> String {
        let update = self.update.as_ref();
        update.map_or_else(String::new, |update| {
            format!("{}{}", update.changes, update.left)
        })
    }

    /// Whether all failed bounds are rewritten.
    fn is_updated(&self) -> bool {
        let update = self.update.as_ref();
        update.is_some_and(|update| !update.changes.is_empty() && update.left.is_empty())
            && self.differences.as_ref().is_none_or(Vec::is_empty)
    }

    /// The failures, one line each. Of many differences from a baseline the largest are listed, as
    /// shares of their signals' sizes, without those at rounding level; numbers of rollers come
    /// last.
    pub fn failures(&self) -> Vec<String> {
        const DIFFERENCES_SHOWN: usize = 3;
        /// Relative to the largest difference.
        const ROUNDING: f64 = 1e-6;
        let failed = self.verdicts.iter().filter(|verdict| !verdict.held);
        let mut lines: Vec<String> = failed
            .map(|verdict| one_line(&verdict.to_string()).into_owned())
            .collect();
        let differences = self.differences.as_deref().unwrap_or_default();
        let mut by_size: Vec<&Difference> = differences.iter().collect();
        by_size.sort_by(|a, b| {
            let is_index = a.is_roller_index().cmp(&b.is_roller_index());
            is_index.then(b.share.total_cmp(&a.share))
        });
        let most = by_size.first().map_or(0.0, |one| one.share);
        by_size.retain(|one| one.share > ROUNDING * most.min(1.0));
        by_size.truncate(DIFFERENCES_SHOWN);
        lines.extend(
            by_size
                .iter()
                .map(|one| one_line(&one.to_string()).into_owned()),
        );
        match differences.len() - by_size.len() {
            0 => {}
            more => {
                let times_s = differences.iter().map(|one| one.first_s);
                let first_s = to_microseconds(times_s.fold(f64::INFINITY, f64::min));
                let what = match more {
                    1 => "1 more signal leaves its baseline".to_owned(),
                    more => format!("{more} more signals leave their baseline"),
                };
                lines.push(format!("{what}; the first of all is apart at {first_s} s"));
            }
        }
        if let Some(drawn) = &self.drawn {
            lines.push(format!("drawn in {}", path_in_line(drawn)));
        }
        lines
    }
}

impl Checked {
    pub fn count(&self) -> Count {
        match &self.result {
            Ended::Refused(_) => Count::Refused,
            Ended::Skipped => Count::Skipped,
            Ended::Judged(judged) if judged.is_updated() => Count::Updated,
            Ended::Judged(judged) if !judged.failures().is_empty() => Count::Failed,
            Ended::Judged(judged) if judged.verdicts.is_empty() && judged.differences.is_none() => {
                Count::NothingExpected
            }
            Ended::Judged(_) => Count::Held,
        }
    }

    /// Whether no other scenario should begin after it, if one failure is enough.
    pub fn has_failed(&self) -> bool {
        matches!(self.count(), Count::Failed | Count::Refused)
    }

    /// Its result and its bounds; `error` if it could not run.
    fn json(&self) -> serde_json::Value {
        let count = self.count();
        let outcome = WORDS.iter().find(|(known, _)| *known == count);
        let (judged, error) = match &self.result {
            Ended::Judged(judged) => (judged, None),
            Ended::Refused(error) => (&Judged::default(), Some(error.to_string())),
            Ended::Skipped => (&Judged::default(), None),
        };
        serde_json::json!({
            "scenario": self.label,
            "file": self.path,
            "outcome": outcome.map(|(_, word)| word),
            "took_s": self.took.as_secs_f64(),
            "trace_hash": judged.trace_hash,
            "converge": judged.converge,
            "bounds": judged.verdicts,
            "failures": judged.failures(),
            "moved": judged.moved,
            "error": error,
        })
    }

    /// Writes the changes of `--update`; if that fails, the scenario fails.
    pub fn write_update(&mut self) {
        if let Ended::Judged(Judged {
            update: Some(update),
            ..
        }) = &self.result
            && let Err(error) = update.write()
        {
            self.result = Ended::Refused(error);
        }
    }

    /// Its result as text, with the `settings` that reproduce it.
    pub fn lines(&self, settings: &str) -> String {
        self.result_lines(settings) + &self.convergence_lines()
    }

    /// The commands that show what failed, and why; for a study there are no causes to try.
    pub fn what_next(&self, settings: &str) -> Vec<String> {
        let path = shell(&self.path.display().to_string());
        let command = |verb: &str| format!("ilon {verb} {path}{settings}");
        let commands = match &self.result {
            Ended::Judged(judged) if judged.is_study => vec![("to see it", command("sweep"))],
            _ => vec![("to see it", command("run")), ("why", command("explain"))],
        };
        let said = |(what, command): (&str, String)| format!("{what}: {}", one_line(&command));
        commands.into_iter().map(said).collect()
    }

    /// The figures that move at half the step, below the line of its result.
    fn convergence_lines(&self) -> String {
        let table = match &self.result {
            Ended::Judged(judged) => converge::table(&judged.converge),
            _ => None,
        };
        let text = table.map_or_else(String::new, |table| table.to_string());
        text.lines()
            .map(|line| format!("         {line}\n"))
            .collect()
    }

    fn result_lines(&self, settings: &str) -> String {
        let took_s = self.took.as_secs_f64();
        let label = &self.label;
        let judged = match &self.result {
            Ended::Skipped => return format!("skip   {label}\n"),
            Ended::Refused(error) => {
                return format!("ERROR  {label}: {}\n", one_line(&error.to_string()));
            }
            Ended::Judged(judged) => judged,
        };
        match self.count() {
            Count::NothingExpected => {
                format!("EMPTY  {label} ({took_s:.1} s): {NOTHING_EXPECTED}\n")
            }
            Count::Updated => {
                let changes = judged.changes();
                let bounds = bounds(changes.lines().count());
                format!(
                    "UPDATED {label} ({took_s:.1} s): {bounds} written around what was measured\n{changes}"
                )
            }
            Count::Failed => {
                let mut text = format!("FAILED {label} ({took_s:.1} s)\n");
                for line in judged.moved.iter().chain(&judged.failures()) {
                    let line = folded(line).replace('\n', "\n             ");
                    text.push_str(&format!("         {line}\n"));
                }
                for line in self.what_next(settings) {
                    text.push_str(&format!("         {line}\n"));
                }
                text.push_str(&judged.changes());
                text
            }
            _ => {
                let expected = match judged.verdicts.len() {
                    0 => "its baseline".to_owned(),
                    count => bounds(count),
                };
                let changes = judged.changes();
                format!("held   {label} ({took_s:.1} s, {expected})\n{changes}")
            }
        }
    }
}

/// The result of each scenario, for `ilon check --json`.
pub(super) fn json(checked: &[Checked]) -> Result<String, Failure> {
    let scenarios: Vec<_> = checked.iter().map(Checked::json).collect();
    pretty(
        "the results",
        &serde_json::json!({ "scenarios": scenarios }),
    )
}

/// The number of scenarios per category.
pub(super) fn totals(checked: &[Checked]) -> Table {
    let mut table = Table::new();
    table.heading("all scenarios");
    for (count, name) in WORDS {
        let of_kind = checked.iter().filter(|one| one.count() == count).count();
        if of_kind > 0 {
            table.row(name, Some(of_kind as f64), 0, "");
        }
    }
    let rewritten = |one: &&Checked| {
        let judged = match &one.result {
            Ended::Judged(judged) => judged,
            _ => return false,
        };
        one.count() == Count::Failed
            && judged
                .update
                .as_ref()
                .is_some_and(|update| !update.changes.is_empty())
    };
    let also = checked.iter().filter(rewritten).count();
    if also > 0 {
        table.row(
            "of the failed, with bounds updated",
            Some(also as f64),
            0,
            "",
        );
    }
    table
}

/// The result of each scenario as Markdown for the summary of a job: failures and moved figures
/// below their scenario.
pub(super) fn markdown(checked: &[Checked], settings: &str) -> String {
    let mut text = "| scenario | result |\n|---|---|\n".to_owned();
    for one in checked {
        let count = one.count();
        let word = WORDS.iter().find(|(known, _)| *known == count);
        let mut cells = vec![word.map_or("", |(_, word)| word).to_owned()];
        match &one.result {
            Ended::Judged(judged) => {
                cells.extend(judged.moved.iter().cloned());
                cells.extend(judged.failures());
                if count == Count::Failed {
                    cells.extend(one.what_next(settings));
                }
            }
            Ended::Refused(error) => cells.push(one_line(&error.to_string()).into_owned()),
            Ended::Skipped => {}
        }
        let cells: Vec<String> = cells.iter().map(|cell| in_cell(cell)).collect();
        text.push_str(&format!(
            "| {} | {} |\n",
            in_cell(&one.label),
            cells.join("<br>")
        ));
    }
    text
}

/// Escapes a text for a cell of a Markdown table.
fn in_cell(text: &str) -> String {
    let mut cell = String::new();
    for c in text.chars() {
        match c {
            '&' => cell.push_str("&amp;"),
            '<' => cell.push_str("&lt;"),
            '>' => cell.push_str("&gt;"),
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '#' | '~' | '!' => cell.extend(['\\', c]),
            _ => cell.push(c),
        }
    }
    cell
}

/// The headline figures of a run that differ from its baseline's, in per cent; first the runs'
/// durations, if they differ. A change below the last shown digit, or below 0.05 %, is not listed.
pub(super) fn moved(summary: &Summary, (baseline, header): (&Summary, &Header)) -> Vec<String> {
    let figures = quantities::headlines(summary).into_iter();
    let lines = figures.filter_map(|quantity| {
        let (now, before) = (quantity.shown(summary)?, quantity.shown(baseline)?);
        let change = (now - before).abs();
        let digit = 10f64.powi(-i32::try_from(quantity.decimals).unwrap_or(0));
        let percent = 100.0 * (now - before) / before.abs();
        if !(change >= digit && percent.abs() >= 0.05) {
            return None;
        }
        // As many digits as give the change two.
        let digits = quantity.decimals + usize::from(change < 10.0 * digit);
        let [new, old] = [now, before].map(|value| format!("{value:.digits$}"));
        // Of next to nothing a change is no share.
        let share = match before.abs() < 10.0 * digit {
            true => String::new(),
            false => format!(" ({percent:+.1} %)"),
        };
        let known = quantity.value(baseline).map_or(0.0, |value| {
            quantities::known_to(quantity, value, baseline, header)
        });
        let counts = match change <= known * quantity.unit.per_si {
            true => ", within its accuracy",
            false => "",
        };
        let (words, unit) = (quantity.words(), quantity.unit.symbol);
        Some(format!(
            "{words}: {new} {unit}, was {old} {unit}{share}{counts}"
        ))
    });
    let [lasts_s, lasted_s] = [summary, baseline].map(|of| to_microseconds(of.duration_s));
    let length = (lasts_s != lasted_s)
        .then(|| format!("the run takes {lasts_s} s, its baseline {lasted_s} s"));
    length.into_iter().chain(lines).collect()
}

fn bounds(count: usize) -> String {
    format!("{count} bound{}", if count == 1 { "" } else { "s" })
}
