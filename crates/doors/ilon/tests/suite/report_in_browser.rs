//! The report in a real browser: every figure is drawn, and the console shows no error.
//!
//! Needs Chromium, named by `ILON_CHROMIUM` or found as `chromium`; without it the test reports
//! that it was skipped.

use std::path::Path;
use std::process::Command;

use ilon::compare::{ComparedRun, Comparison};
use ilon::{Run, Scenario};

fn browser() -> Option<String> {
    let named = std::env::var("ILON_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    let answers = Command::new(&named)
        .arg("--version")
        .output()
        .is_ok_and(|o| o.status.success());
    answers.then_some(named)
}

/// A shortened run of a shipped scenario.
fn run(name: &str, duration_s: f64) -> Run {
    ilon::run(&scenario(name, duration_s)).expect("a shipped scenario runs")
}

fn scenario(name: &str, duration_s: f64) -> Scenario {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/scenarios");
    let mut scenario = Scenario::load(format!("{folder}/{name}.toml")).expect("a shipped scenario");
    scenario.run.duration_s = duration_s;
    scenario
}

/// A page after several seconds, with its console output. `folder` is for the browser's own files.
fn opened(browser: &str, page: &Path, folder: &Path) -> (String, String) {
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-quic",
            "--no-first-run",
            "--window-size=1440,1000",
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
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let dom = String::from_utf8_lossy(&output.stdout).into_owned();
    (dom, said)
}

/// The errors in a console output. Chromium logs every message at one level; errors are named as
/// such.
fn faults(said: &str) -> Vec<&str> {
    said.lines()
        .filter(|line| line.contains(":CONSOLE"))
        .filter(|line| {
            ["Uncaught", "ERROR", "Error", "Failed"]
                .iter()
                .any(|f| line.contains(f))
        })
        .collect()
}

/// Opens a page with all its folded content: every figure must be drawn, and the console show no
/// error.
fn assert_all_is_drawn(browser: &str, page: &Path, folder: &Path, least_figures: usize) {
    let text = std::fs::read_to_string(page).expect("the page");
    let unfolded = folder.join("unfolded.html");
    let text = text.replace(
        "<details class=\"topic\">",
        "<details class=\"topic\" open>",
    );
    std::fs::write(&unfolded, text).expect("a copy");
    let (dom, said) = opened(browser, &unfolded, folder);
    let faults = faults(&said);
    assert!(faults.is_empty(), "the console says: {faults:#?}");
    let figures = dom.matches("data-figure=").count();
    let drawn = dom.matches("data-drawn=").count();
    assert!(figures >= least_figures, "the page has {figures} figures");
    assert_eq!(drawn, figures, "not every figure is drawn");
}

/// Notes where each text of a figure is drawn, before the page's own scripts.
const NOTE_TEXTS: &str = r#"<script>
window.texts = new Map();
const pen = CanvasRenderingContext2D.prototype;
const { clearRect, fillText } = pen;
pen.clearRect = function (...box) { texts.set(this.canvas, []); return clearRect.apply(this, box); };
pen.fillText = function (text, x, y) {
  const width = this.measureText(text).width;
  const left = x - (this.textAlign === 'right' ? width : this.textAlign === 'center' ? width / 2 : 0);
  const top = y - (this.textBaseline === 'middle' ? 5 : this.textBaseline === 'top' ? 0 : 10);
  if (texts.has(this.canvas)) texts.get(this.canvas).push({ text, left, top, right: left + width });
  return fillText.call(this, text, x, y);
};
</script>"#;

/// The texts of figures that lie over each other, by 1 px and more of 10 px high digits, and those
/// that mark a peak.
const READ_TEXTS: &str = r#"<script>
setTimeout(() => {
  const [over, peaks] = [[], []];
  for (const [canvas, drawn] of texts) {
    if (!canvas.isConnected) continue;
    drawn.forEach((a, k) => {
      if (/ at .* s$/.test(a.text)) peaks.push(a.text);
      for (const b of drawn.slice(0, k)) {
        const apart = Math.max(a.left, b.left) + 1 > Math.min(a.right, b.right) || Math.abs(a.top - b.top) > 9;
        if (!apart) over.push(a.text + ' over ' + b.text);
      }
    });
  }
  document.documentElement.dataset.over = over.join(', ');
  document.documentElement.dataset.peaks = peaks.join(', ');
}, 2500);
</script>"#;

/// On a straight path y spans next to nothing, but the axis far more; and a threshold far above an
/// error is no peak of it.
#[test]
fn numbers_of_an_axis_do_not_lie_over_each_other_and_a_threshold_is_no_peak() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium; install it or name it in ILON_CHROMIUM");
        return;
    };
    for name in ["mecanum4_forward", "mecanum4_line"] {
        let run = run(name, 3.0);
        let folder = tempfile::tempdir().expect("a folder to write to");
        let page = folder.path().join("texts.html");
        let html = ilon::report::html(&run.trace, &run.summary);
        let html = html.replacen("<head>", &format!("<head>{NOTE_TEXTS}"), 1);
        std::fs::write(
            &page,
            html.replace("</body>", &format!("{READ_TEXTS}</body>")),
        )
        .expect("a page");
        let (dom, said) = opened(&browser, &page, folder.path());
        assert!(faults(&said).is_empty(), "{said}");
        let of = |data: &str| {
            let at = dom.find(data).unwrap_or_else(|| panic!("no {data}")) + data.len();
            dom[at..].split('"').next().unwrap_or_default().to_owned()
        };
        assert_eq!(of("data-over=\""), "", "{name}");
        let peaks = of("data-peaks=\"");
        assert!(
            !peaks.contains("3.00 at") && !peaks.contains("0.0500 at"),
            "{name}: {peaks}"
        );
    }
}

/// A sequence of user actions on the page, with the results as one line of text.
const USE: &str = r#"<script>
setTimeout(() => {
  const [clock, scene] = [window.ilonClock, window.ilonRunScene];
  const canvas = document.querySelector('#run-view canvas');
  const figure = window.ilonFigures.find((f) => f.div.id === 'position-error');
  const said = [];
  const picture = () => { scene.draw(); return canvas.toDataURL(); };
  const key = (name) => document.body.dispatchEvent(new KeyboardEvent('keydown', { key: name, bubbles: true }));
  said.push(clock.now === 0 ? 'starts-at-0' : 'starts-at-' + clock.now);
  figure.draw();
  const [still, cursor] = [picture(), figure.mark.style.transform];
  clock.seek(1.5);
  figure.seek(clock.now);
  said.push(picture() !== still ? 'scene-moves' : 'scene-stands');
  said.push(figure.mark.style.transform !== cursor ? 'cursor-moves' : 'cursor-stands');
  key('ArrowRight');
  said.push(clock.now > 1.5 ? 'arrow-steps' : 'arrow-does-nothing');
  const box = figure.canvas.getBoundingClientRect();
  const middle = (figure.view.left + figure.view.right) / 2;
  for (const name of ['pointerdown', 'pointerup']) {
    figure.stage.dispatchEvent(new PointerEvent(name, { clientX: box.left + middle, clientY: box.top + 80, pointerType: 'mouse' }));
  }
  said.push(Math.abs(clock.now - 1.5) < 0.02 ? 'click-seeks' : 'click-leads-to-' + clock.now);
  clock.seek(0);
  key('n');
  said.push(clock.now > 0 ? 'next-event' : 'no-event');
  document.documentElement.dataset.used = said.join(' ');
}, 2500);
</script>"#;

#[test]
fn one_time_moves_the_scene_and_the_cursors() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium; install it or name it in ILON_CHROMIUM");
        return;
    };
    let run = run("volksbot_position_first", 3.0);
    let folder = tempfile::tempdir().expect("a folder to write to");
    let page = folder.path().join("used.html");
    let html = ilon::report::html(&run.trace, &run.summary);
    std::fs::write(&page, html.replace("</body>", &format!("{USE}</body>"))).expect("a page");
    let (dom, said) = opened(&browser, &page, folder.path());
    assert!(faults(&said).is_empty(), "{:#?}", faults(&said));
    let used = dom
        .split("data-used=\"")
        .nth(1)
        .and_then(|rest| rest.split('"').next());
    assert_eq!(
        used,
        Some("starts-at-0 scene-moves cursor-moves arrow-steps click-seeks next-event")
    );
}

/// The page of a run of 12 s stays below two million bytes, and its answer names the largest error,
/// the fault that caused it, and the error without it.
#[test]
fn the_wet_floor_is_named_and_the_page_is_light() {
    let scenario = scenario("mecanum4_wet_floor", 12.0);
    let simulation = ilon::simulate::Simulation::new(&scenario).expect("it stands");
    let run = simulation.explaining(ilon::Causes::Named).run();
    let page = ilon::report::html(&run.trace, &run.summary);
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
    let story = page.split("<div class=\"story\">").nth(1).expect("a story");
    let story = story.split("</div>").next().expect("an answer");
    let largest_mm = 1e3 * run.summary.position_error_max_m.expect("a reference");
    let named = "Without the floor&#39;s change of friction to 0.02 from 4.00 to 7.00 s the largest position error would have been";
    // As many digits as half the step confirms.
    for words in [&format!("<b>{largest_mm:.1} mm</b>"), named] {
        assert!(story.contains(words), "{words}: {story}");
    }
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
    // Robots with three and with four wheels, with and without a reference: runs may differ in
    // everything.
    let runs = [
        run("volksbot_heading_first", 2.0),
        run("mecanum4_hard_start", 1.5),
    ];
    let comparison = Comparison::of(
        runs.map(|run| ComparedRun::new(run.scenario.name, run.trace, run.summary))
            .into(),
        &[],
    )
    .expect("two runs");
    let folder = tempfile::tempdir().expect("a folder to write to");
    let page = folder.path().join("compare.html");
    std::fs::write(&page, ilon::report::compare::html(&comparison)).expect("the page is written");
    assert_all_is_drawn(&browser, &page, folder.path(), 14);
}
