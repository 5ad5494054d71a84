//! The report in a real browser: every figure is drawn, and the console shows no fault.
//!
//! Needs Chromium, named by `ILON_CHROMIUM` or found as `chromium`; without one the test says that it was skipped.

use std::path::Path;
use std::process::Command;

use ilon::bench::{Bench, Kind, Options};
use ilon::compare::{Compared, Comparison};
use ilon::{Run, Scenario};

fn browser() -> Option<String> {
    let named = std::env::var("ILON_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    let answers = Command::new(&named)
        .arg("--version")
        .output()
        .is_ok_and(|o| o.status.success());
    answers.then_some(named)
}

/// A shipped scenario, run for a while.
fn run(name: &str, duration_s: f64) -> Run {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/scenarios");
    let mut scenario = Scenario::load(format!("{folder}/{name}.toml")).expect("a shipped scenario");
    scenario.run.duration_s = duration_s;
    ilon::run(&scenario).expect("a shipped scenario runs")
}

/// Opens a page: every figure must be drawn, and the console show no fault. `folder` is for the browser's own files.
fn assert_all_is_drawn(browser: &str, page: &Path, folder: &Path, least_figures: usize) {
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
        ])
        .args([
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
        ])
        .args([
            "--enable-logging=stderr",
            "--virtual-time-budget=20000",
            "--dump-dom",
        ])
        .arg(format!(
            "--user-data-dir={}",
            folder.join("profile").display()
        ))
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("Chromium starts");
    let said = String::from_utf8_lossy(&output.stderr);
    // Chromium logs every console message at one level; faults name themselves.
    let faults: Vec<&str> = said
        .lines()
        .filter(|line| line.contains(":CONSOLE"))
        .filter(|line| {
            ["Uncaught", "ERROR", "Error", "Failed"]
                .iter()
                .any(|f| line.contains(f))
        })
        .collect();
    assert!(faults.is_empty(), "the console says: {faults:#?}");

    let page = String::from_utf8_lossy(&output.stdout);
    let figures = page.matches("data-figure=").count();
    let drawn = page.matches("data-drawn=").count();
    assert!(figures >= least_figures, "the page has {figures} figures");
    assert_eq!(drawn, figures, "not every figure is drawn");
}

#[test]
fn every_figure_of_a_report_is_drawn_and_the_console_shows_no_fault() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium; install it or name it in ILON_CHROMIUM");
        return;
    };
    let run = run("volksbot_position_first", 3.0);
    let folder = tempfile::tempdir().expect("a folder to write to");
    let report = folder.path().join("report.html");
    ilon::report::write(&report, &run.trace, &run.summary).expect("the report is written");
    assert_all_is_drawn(&browser, &report, folder.path(), 20);
}

#[test]
fn every_figure_of_a_comparison_is_drawn_and_the_console_shows_no_fault() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium; install it or name it in ILON_CHROMIUM");
        return;
    };
    // Robots with three and with four wheels, with and without a reference: nothing need be alike.
    let runs = [
        run("volksbot_heading_first", 2.0),
        run("mecanum4_hard_start", 1.5),
    ];
    let comparison = Comparison::of(
        runs.map(|run| Compared::new(run.scenario.name, run.trace, run.summary))
            .into(),
        &[],
    )
    .expect("two runs");
    let folder = tempfile::tempdir().expect("a folder to write to");
    let page = folder.path().join("compare.html");
    ilon::report::compare::write(&page, &comparison).expect("the page is written");
    assert_all_is_drawn(&browser, &page, folder.path(), 14);
}

#[test]
fn every_figure_of_a_bench_is_drawn_and_the_console_shows_no_fault() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium; install it or name it in ILON_CHROMIUM");
        return;
    };
    let options = Options {
        configurations: vec![(Kind::Near, 40.0), (Kind::Near, 20.0)],
        headings_deg: vec![0.0],
        rounds: 1,
        fleets: vec![1],
        ..Options::quick().expect("the built-in robots")
    };
    let bench = Bench::measure(&options, |_| ()).expect("they drive");
    let folder = tempfile::tempdir().expect("a folder to write to");
    let page = folder.path().join("bench.html");
    ilon::pages::bench::write(&page, &bench).expect("the page is written");
    assert_all_is_drawn(&browser, &page, folder.path(), 2);
}
