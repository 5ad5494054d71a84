//! How soon the page of a run of 40 s can be used: until its first picture in three dimensions
//! stands, and until nothing more has to run before it answers. In headless Chromium, which draws
//! by the processor; time counts from where the page is asked for.
//!
//! `cargo bench --bench page_loading`

#[path = "../tests/suite/support/browser.rs"]
mod browser;

use std::process::ExitCode;

use browser::Browser;
use ilon::Scenario;
use serde_json::json;

/// How often it is loaded, each time anew.
const TIMES: usize = 9;

/// Remembers when the first body of the scene is drawn, and when the page rests for the first time
/// after it is loaded.
const WATCH: &str = "
const draw = WebGL2RenderingContext.prototype.drawElementsInstanced;
WebGL2RenderingContext.prototype.drawElementsInstanced = function (...a) {
  const drawn = draw.apply(this, a);
  if (window.firstPicture === undefined) {
    window.firstPicture = null;
    requestAnimationFrame(() => { window.firstPicture = performance.now(); });
  }
  return drawn;
};
addEventListener('load', () => requestIdleCallback(() => { window.restedAt = performance.now(); }));
";

/// Both times, once they are there.
const TIMES_MS: &str = "new Promise((done) => {
  const look = () => (window.firstPicture && window.restedAt && window.ilonClock
    ? done([window.firstPicture, window.restedAt]) : setTimeout(look, 10));
  look();
})";

fn main() -> ExitCode {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/scenarios");
    let scenario = Scenario::load(format!("{folder}/volksbot_position_first.toml"));
    let mut scenario = scenario.expect("a shipped scenario");
    scenario.run.duration_s = 40.0;
    let run = ilon::run(&scenario).expect("it runs");
    let place = std::env::temp_dir().join(format!("ilon-page-{}.html", std::process::id()));
    ilon::report::write(&place, &run.trace, &run.summary).expect("the page is written");
    let bytes = std::fs::metadata(&place).map_or(0, |file| file.len());

    let Some(mut browser) = Browser::start() else {
        return ExitCode::FAILURE;
    };
    browser.size(1440, 900);
    browser.call(
        "Page.addScriptToEvaluateOnNewDocument",
        json!({ "source": WATCH }),
    );
    browser.call("Network.setCacheDisabled", json!({ "cacheDisabled": true }));
    let mut times_ms: Vec<[f64; 2]> = Vec::new();
    // The first time the browser itself is still starting.
    for _ in 0..=TIMES {
        browser.open(&place);
        let found = browser.eval(TIMES_MS);
        times_ms.push([0, 1].map(|k| found[k].as_f64().unwrap_or(f64::NAN)));
    }
    let _ = std::fs::remove_file(&place);
    let median_ms = |which: usize| {
        let mut times: Vec<f64> = times_ms[1..].iter().map(|times| times[which]).collect();
        times.sort_by(f64::total_cmp);
        (times[0], times[TIMES / 2], times[TIMES - 1])
    };
    println!(
        "page of 40 s of volksbot_position_first: {:.2} MB",
        bytes as f64 / 1e6
    );
    for (which, what) in ["first picture in three dimensions", "loaded, and at rest"]
        .iter()
        .enumerate()
    {
        let (least, median, most) = median_ms(which);
        println!("{what}: {median:.0} ms in the middle of {TIMES} loads ({least:.0} to {most:.0})");
    }
    ExitCode::SUCCESS
}
