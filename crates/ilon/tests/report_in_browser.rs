//! The report in a real browser: every figure is drawn, and the console shows no fault.
//!
//! Needs Chromium, named by `ILON_CHROMIUM` or found as `chromium`; without one the test says that it was skipped.

use std::process::Command;

use ilon::Scenario;

fn browser() -> Option<String> {
    let named = std::env::var("ILON_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    let answers = Command::new(&named)
        .arg("--version")
        .output()
        .is_ok_and(|o| o.status.success());
    answers.then_some(named)
}

#[test]
fn every_figure_is_drawn_and_the_console_shows_no_fault() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium; install it or name it in ILON_CHROMIUM");
        return;
    };
    let scenario = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../assets/scenarios/volksbot_position_first.toml"
    );
    let mut scenario = Scenario::load(scenario).expect("a shipped scenario");
    scenario.run.duration_s = 3.0;
    let run = ilon::run(&scenario).expect("a shipped scenario runs");
    let folder = tempfile::tempdir().expect("a folder to write to");
    let report = folder.path().join("report.html");
    ilon::report::write(&report, &run.trace, &run.summary).expect("the report is written");

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
            folder.path().join("profile").display()
        ))
        .arg(format!("file://{}", report.display()))
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
    let drawn = page.matches("class=\"plot-container").count();
    assert!(figures >= 10, "the page has {figures} figures");
    assert_eq!(drawn, figures, "not every figure is drawn");
}
