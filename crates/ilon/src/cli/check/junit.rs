//! The results of `ilon check` as JUnit XML.

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use super::{Checked, Ended};
use crate::Error;

/// One test case a scenario: failures are expectations that did not hold, errors are scenarios that could not run.
pub(super) fn xml(checked: &[Checked]) -> Result<String, Error> {
    let mut suite = TestSuite::new("ilon check");
    for one in checked {
        let mut case = TestCase::new(one.name.as_str(), status(one));
        case.set_classname(one.path.display().to_string());
        case.set_time(one.took);
        suite.add_test_case(case);
    }
    let mut report = Report::new("ilon");
    report.add_test_suite(suite);
    let xml = report
        .to_string()
        .map_err(|error| Error::invalid(error.to_string(), ""))?;
    // Jenkins's schema knows `skipped` of a suite, but not of the whole, which comes first.
    let is_skipped = |one: &&Checked| matches!(one.result, Ended::Skipped);
    let skipped = checked.iter().filter(is_skipped).count();
    Ok(xml.replacen(&format!(" skipped=\"{skipped}\""), "", 1))
}

fn status(one: &Checked) -> TestCaseStatus {
    let non_success = |kind, message: String| {
        let mut status = TestCaseStatus::non_success(kind);
        status.set_message(message);
        status
    };
    match &one.result {
        Ended::Skipped => TestCaseStatus::skipped(),
        Ended::Refused(error) => non_success(NonSuccessKind::Error, error.to_string()),
        Ended::Judged(judged) => match judged.failures() {
            failures if failures.is_empty() => TestCaseStatus::success(),
            failures => non_success(NonSuccessKind::Failure, failures.join("; ")),
        },
    }
}
