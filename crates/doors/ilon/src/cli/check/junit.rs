//! The results of `ilon check` as JUnit XML.

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use super::outcome::{Checked, Count, Ended, NOTHING_EXPECTED};
use crate::cli::escape::one_line;
use crate::cli::failure::Failure;
use crate::cli::fault;

/// One test case per scenario: failures are expectations that did not hold, errors are scenarios
/// that could not run. A scenario without expectations is skipped: it is no test.
pub(super) fn xml(checked: &[Checked], settings: &str) -> Result<String, Failure> {
    let mut suite = TestSuite::new("ilon check");
    for one in checked {
        let mut case = TestCase::new(one.label.as_str(), status(one, settings));
        case.set_classname(one_line(&one.path.display().to_string()));
        case.set_time(one.took);
        suite.add_test_case(case);
    }
    let mut report = Report::new("ilon");
    report.add_test_suite(suite);
    let xml = report
        .to_string()
        .map_err(|error| Failure::encode("the results", &error))?;
    // Jenkins's schema allows `skipped` on a suite, but not on the root, which comes first.
    let is_skipped =
        |one: &&Checked| matches!(one.count(), Count::Skipped | Count::NothingExpected);
    let skipped = checked.iter().filter(is_skipped).count();
    Ok(xml.replacen(&format!(" skipped=\"{skipped}\""), "", 1))
}

fn status(one: &Checked, settings: &str) -> TestCaseStatus {
    let non_success = |kind, message: &str| {
        let mut status = TestCaseStatus::non_success(kind);
        status.set_message(one_line(message));
        status
    };
    match &one.result {
        Ended::Skipped => TestCaseStatus::skipped(),
        Ended::Refused(error) => {
            let mut status = non_success(NonSuccessKind::Error, &error.to_string());
            // With file, line and repair, as printed on a terminal.
            status.set_description(fault::plain(error, "--set"));
            status
        }
        Ended::Judged(_) if one.count() == Count::NothingExpected => {
            let mut status = TestCaseStatus::skipped();
            status.set_message(NOTHING_EXPECTED);
            status
        }
        Ended::Judged(judged) => match judged.failures() {
            failures if failures.is_empty() => TestCaseStatus::success(),
            failures => {
                let count = failures.len();
                let message = match count {
                    1 => failures[0].clone(),
                    _ => format!("{}; and {} more", failures[0], count - 1),
                };
                let mut status = non_success(NonSuccessKind::Failure, &message);
                // One line per bound: viewers show the body unchanged.
                let lines = judged.moved.iter().chain(&failures).cloned();
                let lines = lines.chain(one.what_next(settings));
                status.set_description(lines.collect::<Vec<_>>().join("\n"));
                status
            }
        },
    }
}
