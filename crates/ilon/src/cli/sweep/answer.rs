//! What a study found, as a person reads it on a terminal.

use ilon_report::sweep::figure as number;
use ilon_sim::judge::Verdict;
use ilon_sweep::findings::Expectation;
use ilon_sweep::{Findings, Study};

use crate::answers::sweep::{answers, tables};
use crate::cli::table::Table;

/// What was found, in words and tables.
pub(in crate::cli) fn words(study: &Study, findings: &Findings) -> String {
    let failed = match findings.failed {
        0 => String::new(),
        count => format!(", {count} of them failed"),
    };
    let mut text = format!("{}: {} runs{failed}\n", study.name(), findings.runs);
    for answer in answers(study, findings) {
        text += &format!("\n{}\n", answer.text);
    }
    let mut table = Table::new();
    for one in &tables(study, findings) {
        table.of(one);
    }
    format!("{text}\n{table}")
}

/// The expectations of a study as verdicts, as `ilon check` shows those of a scenario.
pub(in crate::cli) fn verdicts(findings: &Findings) -> Vec<Verdict> {
    let verdict = |one: &Expectation| Verdict {
        quantity: format!(
            "share of {} runs with {} {}",
            one.runs, one.quantity, one.bound
        ),
        bound: format!(">= {}", number(one.share_expected)),
        measured: Some(one.share),
        at_s: None,
        held: one.held,
    };
    findings.expectations.iter().map(verdict).collect()
}
