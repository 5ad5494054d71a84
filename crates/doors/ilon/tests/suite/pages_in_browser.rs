//! The pages in a real browser: on a large screen, on a phone and on paper; for users of screen
//! readers or keyboards; without console messages; and moving.

use crate::support;
use crate::support::browser;

use std::path::Path;

use browser::Browser;
use serde_json::Value;
use support::Folder;

/// Checks of a page's layout.
const LOOKED_AT: &str = r#"(() => {
  const root = document.documentElement;
  const shown = (e) => e.getClientRects().length > 0 && getComputedStyle(e).visibility !== 'hidden';
  const name = (e) => `${e.tagName.toLowerCase()}.${e.className} ${e.textContent.trim().slice(0, 40)}`;
  const scrolls = (e) => {
    for (let at = e; at && at !== document.body; at = at.parentElement) {
      const { overflowX } = getComputedStyle(at);
      if (overflowX === 'auto' || overflowX === 'scroll' || overflowX === 'hidden') return true;
    }
    return false;
  };
  const words = Array.from(document.querySelectorAll('p, li, dt, dd, td, th, h1, h2, h3, summary, button, figcaption, label'));
  return {
    width: root.clientWidth,
    scrollWidth: root.scrollWidth,
    // What reaches beyond the page's edge, and is not in a part that scrolls by itself.
    beyond: Array.from(document.body.querySelectorAll('*')).filter((e) => shown(e) && !scrolls(e) && !e.closest('svg') &&
      !e.classList.contains('skip') && e.getBoundingClientRect().right > root.clientWidth + 1).map(name).slice(0, 5),
    // Words that are too small to be read.
    small: words.filter((e) => shown(e) && e.textContent.trim() && parseFloat(getComputedStyle(e).fontSize) < 11).map(name).slice(0, 5),
    // Tiles whose words do not fit.
    cut: Array.from(document.querySelectorAll('.tile, .tile dd, .tile dt')).filter((e) => e.scrollWidth > e.clientWidth + 1).map(name).slice(0, 5),
    tiles: document.querySelectorAll('.tile').length,
    // What is wide must scroll by itself and be reached by the keyboard.
    unreached: Array.from(document.querySelectorAll('.scroll, pre, nav ul')).filter((e) => shown(e) && e.scrollWidth > e.clientWidth + 1 &&
      e.tabIndex < 0 && !e.querySelector('a, button, input')).map(name).slice(0, 5),
  };
})()"#;

/// Checks during printing.
const PRINTED: &str = r#"window.addEventListener('beforeprint', () => {
  const shown = (e) => e.getClientRects().length > 0;
  const root = document.documentElement;
  window.printed = {
    cut: Array.from(document.querySelectorAll('main *, header *')).filter((e) => shown(e) && !e.closest('svg') &&
      e.getBoundingClientRect().right > root.clientWidth + 1).map((e) => `${e.tagName} ${e.className} ${e.textContent.trim().slice(0, 40)}`).slice(0, 5),
    hidden: Array.from(document.querySelectorAll('main .scroll, main pre')).filter((e) => shown(e) && e.scrollWidth > e.clientWidth + 1)
      .map((e) => e.textContent.trim().slice(0, 60)).slice(0, 5),
    undrawn: (window.ilonFigures || []).filter((f) => !f.drawn && shown(f.div)).map((f) => f.div.id),
  };
}); null"#;

/// Pixels of the first scene at two times, as numbers that differ where the pictures do.
const MOVES: &str = r#"(async () => {
  const canvas = document.querySelector('canvas[data-scene]');
  const slider = document.getElementById('time');
  const rest = () => new Promise((done) => setTimeout(done, 400));
  const picture = async (part) => {
    slider.value = Number(slider.min) + part * (Number(slider.max) - Number(slider.min));
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    await rest();
    const scene = window.ilonRunScene || (window.ilonRunScenes || [])[0];
    if (scene) scene.draw();
    const small = document.createElement('canvas');
    [small.width, small.height] = [160, 100];
    const pen = small.getContext('2d');
    pen.drawImage(canvas, 0, 0, 160, 100);
    return Array.from(pen.getImageData(0, 0, 160, 100).data);
  };
  const [a, b, c] = [await picture(0.2), await picture(0.6), await picture(0.2)];
  const differ = (p, q) => p.filter((x, k) => Math.abs(x - q[k]) > 12).length / p.length;
  return { changed: differ(a, b), same: differ(a, c), drawn: new Set(a).size };
})()"#;

fn none_of(found: &Value, what: &str, page: &str) {
    let list = found[what]
        .as_array()
        .unwrap_or_else(|| panic!("no {what} in {found:#}"));
    assert!(list.is_empty(), "{page}, {what}: {list:#?}");
}

/// Checks a page against all requirements.
fn assert_good(page: &Path, least_tiles: u64, moves: bool) {
    let Some(mut browser) = Browser::start() else {
        return;
    };
    let name = page
        .file_name()
        .expect("a file")
        .to_string_lossy()
        .into_owned();
    for (width, height) in [(1440, 900), (390, 844)] {
        browser.size(width, height);
        browser.open(page);
        // Everything is opened, as folded content must be as good as the rest.
        browser.eval("document.querySelectorAll('details').forEach((d) => { d.open = true; }); new Promise((done) => setTimeout(done, 1500))");
        let found = browser.eval(LOOKED_AT);
        let at = format!("{name} at {width} px");
        assert_eq!(
            found["scrollWidth"], found["width"],
            "{at} scrolls sideways: {found:#}"
        );
        for what in ["beyond", "small", "cut", "unreached"] {
            none_of(&found, what, &at);
        }
        assert!(
            found["tiles"].as_u64() >= Some(least_tiles),
            "{at}: {found:#}"
        );
        for theme in ["light", "dark"] {
            assert_eq!(
                browser.eval("document.documentElement.dataset.theme"),
                theme
            );
            if let Some(faults) = browser.axe() {
                assert!(faults.is_empty(), "{at}, {theme}: {faults:#?}");
            }
            browser.eval("document.querySelector('.theme').click()");
        }
        if moves {
            let moved = browser.eval(MOVES);
            let share = |what: &str| moved[what].as_f64().unwrap_or(f64::NAN);
            // A hundredth of the pixels' channels: a robot that turns by an angle or moves several
            // centimetres changes more.
            assert!(
                share("changed") > 0.01 && share("same") < 0.001,
                "{at}: {moved}"
            );
        }
    }
    // An A4 sheet within the margins of the style sheet is 182 mm wide.
    browser.size(688, 1000);
    browser.open(page);
    browser.media("print");
    browser.eval(PRINTED);
    let bytes = browser.print().len();
    assert!(bytes > 20_000, "{name}: {bytes} bytes of PDF");
    let printed = browser.eval("window.printed");
    for what in ["cut", "hidden", "undrawn"] {
        none_of(&printed, what, &format!("{name} on paper"));
    }
    assert!(
        browser.console.is_empty(),
        "{name}: the console says {:#?}",
        browser.console
    );
}

fn shipped(name: &str) -> String {
    format!("{}/../../../assets/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// Runs a shortened shipped scenario into its own folder.
fn ran(folder: &Folder, scenario: &str, out: &str, more: &[&str]) {
    let scenario = shipped(&format!("scenarios/{scenario}.toml"));
    let arguments = [
        &["run", &scenario, "--out", out, "--set", "run.duration_s=4"],
        more,
    ]
    .concat();
    support::ended_with(0, &folder.ilon(&arguments));
}

#[test]
fn the_report_of_a_run() {
    let folder = Folder::new();
    ran(&folder, "mecanum4_wet_floor", "a", &[]);
    assert_good(&folder.path("a/report.html"), 4, true);
}

/// Many faults, with a bound that fails for each kind of quantity.
const MANY_FAULTS: &str = r#"
robot.file = "mecanum6.urdf"
run.duration_s = 8
twist = { vx_m_s = 0.3, vy_m_s = 0.1, omega_rad_s = 0.2 }
[[faults]]
payload = { mass_kg = 3, x_m = 0.1, y_m = 0.05, z_m = 0.2, from_s = 2 }
[[faults]]
friction_changed = { friction = 0.05, from_s = 3, until_s = 4 }
[[faults]]
encoder_scaled = { wheel = "front_left", factor = 0.97 }
[[faults]]
push = { impulse_y_n_s = 5, from_s = 5, lasts_s = 0.5 }
[[faults]]
motor_lost = { wheel = "rear_left", from_s = 6 }
[expect]
slip_energy_j = { max = 0.001 }
travelled_m = { max = 1 }
turned_rad = { max = 1 }
energy.spin_up_j = { max = 0.001 }
wheel_torque_max_n_m = { max = 0.001 }
"#;

/// The error budget is on paper, in at most three pages with their pictures, whatever the run: at
/// rest, on tyres, long, with a fault, with many faults and failed bounds.
#[test]
fn an_ordinary_report_is_three_pages_on_paper() {
    let folder = Folder::new();
    folder.write("many.toml", MANY_FAULTS);
    std::fs::copy(
        shipped("robots/mecanum6.urdf"),
        folder.path("mecanum6.urdf"),
    )
    .expect("a copy");
    let many = folder.path("many.toml").display().to_string();
    let named = |name: &str| shipped(&format!("scenarios/{name}.toml"));
    for (scenario, duration_s) in [
        (named("mecanum4_rest"), 2),
        (named("swerve4_circle"), 6),
        (named("mecanum4_lateral"), 40),
        (named("mecanum4_wet_floor"), 8),
        (many, 8),
    ] {
        let duration = format!("run.duration_s={duration_s}");
        let arguments = ["run", &scenario, "--out", "out", "--set", &duration];
        support::ended_with(0, &folder.ilon(&arguments));
        let Some(mut browser) = Browser::start() else {
            return;
        };
        browser.size(1366, 900);
        browser.open(&folder.path("out/report.html"));
        browser.media("print");
        // A robot that was never off has no chart of what moved it off.
        if !scenario.contains("swerve4_circle") {
            let budget = browser.eval(
                "document.querySelector('section:has(> #budget-section) > .grid').getClientRects().length",
            );
            assert_eq!(budget, 1, "{scenario}: no error budget");
        }
        let pdf = browser.print();
        let pages = pdf.windows(12).filter(|at| *at == b"/Type /Page\n").count();
        assert!((1..=3).contains(&pages), "{scenario}: {pages} pages");
        let pictures = pdf
            .windows(14)
            .filter(|at| *at == b"/Subtype /Imag")
            .count();
        assert!(pictures >= 1, "{scenario}: no picture of the robot");
    }
}

/// A figure of eight on the floor of its file, and on a slippery one.
fn ran_with_and_without_ice(folder: &Folder, floor: &str, ice: &str) {
    let slippery = ["--set", "world.floor.friction=0.05"];
    ran(folder, "mecanum4_figure_eight", floor, &[]);
    ran(folder, "mecanum4_figure_eight", ice, &slippery);
}

#[test]
fn a_comparison() {
    let folder = Folder::new();
    ran_with_and_without_ice(&folder, "a", "b");
    support::ended_with(
        0,
        &folder.ilon(&["compare", "a", "b", "--out", "compare.html"]),
    );
    assert_good(&folder.path("compare.html"), 0, true);
}

#[test]
fn a_run_against_its_baseline() {
    let folder = Folder::new();
    ran_with_and_without_ice(&folder, "baseline", "run");
    let read = |name: &str| ilon_trace::Trace::read_parquet(&folder.path(name)).expect("a trace");
    let (run, baseline) = (read("run/trace.parquet"), read("baseline/trace.parquet"));
    let Ok(found) = ilon_trace::differences(&run, &baseline, &Default::default(), false);
    let page = folder.path("difference.html");
    let Ok(html) = ilon::report::difference::html(&run, &baseline, &found);
    std::fs::write(&page, html).expect("the page is written");
    assert_good(&page, 0, true);
}

#[test]
fn a_robot_alone() {
    let folder = Folder::new();
    let robot = shipped("robots/mecanum4.urdf");
    support::ended_with(
        0,
        &folder.ilon(&["inspect", &robot, "--html", "robot.html"]),
    );
    assert_good(&folder.path("robot.html"), 0, true);
}

#[test]
fn a_study() {
    let folder = Folder::new();
    let scenario = shipped("scenarios/mecanum4_lateral.toml");
    let study = format!(
        "scenario = \"{scenario}\"\nquantities = [\"twist_ratio_ideal.vy\", \"slip_speed_rms_m_s\"]\n[set]\nrun.duration_s = 3\n[axes]\nworld.floor.friction = [0.05, 0.2, 0.6]\nrobot.heading_deg = [0, 30]\n"
    );
    folder.write("study.toml", &study);
    support::ended_with(0, &folder.ilon(&["sweep", "study.toml", "--out", "study"]));
    assert_good(&folder.path("study/report.html"), 0, false);
}

/// The table of values on the page of an identification equals the results in the file.
fn assert_says_what_was_found(folder: &Folder, out: &str) {
    let Some(mut browser) = Browser::start() else {
        return;
    };
    browser.size(1440, 900);
    browser.open(&folder.path(&format!("{out}/report.html")));
    let rows = browser.eval(
        "Array.from(Array.from(document.querySelectorAll('table')).find((table) => table.caption.textContent === 'Parameters').tBodies[0].rows) \
         .map((row) => Array.from(row.children).map((cell) => cell.textContent))",
    );
    let rows = rows.as_array().expect("a table of values");
    let text = folder.read(&format!("{out}/identified.json"));
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let parameters = json["parameters"].as_object().expect("values by name");
    assert!(!parameters.is_empty());
    for (name, parameter) in parameters {
        let row = rows.iter().find(|row| row[0] == name.as_str());
        let row = row.unwrap_or_else(|| panic!("{name} is not in {rows:#?}"));
        let shown = |cell: usize| -> f64 {
            let text = row[cell].as_str().expect("text").replace('\u{2212}', "-");
            text.parse().unwrap_or_else(|_| panic!("{name}: {text}"))
        };
        let value = parameter["value"].as_f64().expect("a number");
        // Five digits.
        assert!(
            (shown(1) - value).abs() <= 1e-4 * value.abs() + 1e-9,
            "{row}"
        );
        for (cell, end) in [(2, 0), (3, 1)] {
            if let Some(end) = parameter["ci95"][end].as_f64() {
                assert!(
                    (shown(cell) - end).abs() <= 0.01 * end.abs() + 1e-9,
                    "{row}"
                );
            }
        }
    }
}

/// The robot of four mecanum wheels as published.
#[test]
fn an_identification() {
    let folder = Folder::new();
    let study = shipped("identify/optiodom_mecanum.toml");
    support::ended_with(0, &folder.ilon(&["identify", &study, "--out", "found"]));
    let page = folder.path("found/report.html");
    assert_good(&page, 0, false);
    assert_says_what_was_found(&folder, "found");
}
