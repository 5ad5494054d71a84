//! The playground in a real browser: served and from disk, wide and narrow, by keyboard alone, with
//! valid and invalid files.
//!
//! Needs Chromium, and a playground named by `ILON_WEB`; accessibility needs axe-core, named by
//! `ILON_AXE`.

use std::time::{Duration, Instant};

use ilon_sim::Scenario;
use serde_json::{Value, json};

use crate::browser::Browser;
use crate::support::{assets, hashes, playground, scenarios, serve, shipped};

/// Timeout for a run, with a build on the same machine; chosen.
const PATIENCE: Duration = Duration::from_secs(180);

/// Waits until an expression is true.
fn until(browser: &mut Browser, expression: &str) {
    let end = Instant::now() + PATIENCE;
    while browser.eval(expression) != true {
        if Instant::now() > end {
            let said = browser.eval("document.body.innerText.slice(0, 3000)");
            panic!("never: {expression}\n{said}\n{:#?}", browser.console);
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Opens a playground and waits until its first scenario has run.
fn open(browser: &mut Browser, url: &str) {
    browser.call("Page.navigate", json!({ "url": "about:blank" }));
    browser.call("Page.navigate", json!({ "url": url }));
    until(
        browser,
        "document.documentElement?.dataset.ready === 'yes' && document.documentElement.dataset.runs === '1'",
    );
    // A page opened from disk has no access to its frame.
    if !url.starts_with("file:") {
        until(browser, ANSWERED);
    }
}

/// Whether the report is in its frame.
const ANSWERED: &str =
    "Boolean(document.getElementById('report').contentDocument?.querySelector('.story p'))";

fn hash(browser: &mut Browser) -> String {
    let hash = browser.eval("document.getElementById('hash').textContent");
    hash.as_str().expect("a hash").to_owned()
}

/// Presses Run and waits for the result.
fn run(browser: &mut Browser) {
    let runs = browser.eval("document.documentElement.dataset.runs");
    browser.eval("document.getElementById('run').click()");
    until(
        browser,
        &format!("document.documentElement.dataset.runs !== {runs}"),
    );
    until(browser, ANSWERED);
}

/// The trace hash of the first scenario, computed here.
fn expected() -> String {
    let path = assets().join("scenarios/mecanum4_lateral.toml");
    let scenario = Scenario::load(path).unwrap();
    ilon_sim::run(&scenario).unwrap().summary.trace_hash
}

fn key(browser: &mut Browser, key: &str, code: u32) {
    for kind in ["rawKeyDown", "keyUp"] {
        browser.call(
            "Input.dispatchKeyEvent",
            json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code }),
        );
    }
}

fn assert_fits(browser: &mut Browser, at: &str) {
    let widths = browser
        .eval("[document.documentElement.scrollWidth, document.documentElement.clientWidth]");
    assert_eq!(widths[0], widths[1], "{at} scrolls sideways");
    for theme in 0..2 {
        if let Some(faults) = browser.axe() {
            assert!(faults.is_empty(), "{at}, theme {theme}: {faults:#?}");
        }
        browser.eval("document.querySelector('.theme').click()");
    }
}

fn assert_silent(browser: &Browser) {
    assert!(browser.console.is_empty(), "{:#?}", browser.console);
}

/// Drops a robot file on the page.
fn drop_robot(browser: &mut Browser, name: &str, text: &str) {
    browser.eval(&format!(
        "(() => {{ const data = new DataTransfer(); data.items.add(new File([{}], {}));
           dispatchEvent(new DragEvent('drop', {{ dataTransfer: data, bubbles: true }})); }})()",
        Value::from(text),
        Value::from(name)
    ));
}

#[test]
fn it_is_served_run_and_read_at_every_width() {
    let Some((folder, mut browser)) = playground().zip(Browser::start()) else {
        return;
    };
    let url = serve(folder);
    for (width, height) in [(1366, 768), (390, 844)] {
        browser.size(width, height);
        open(&mut browser, &url);
        assert_eq!(hash(&mut browser), expected());
        assert_fits(&mut browser, &format!("at {width} px"));
    }
    assert_silent(&browser);
}

#[test]
fn it_is_of_use_before_the_simulator_is_there() {
    let Some((folder, mut browser)) = playground().zip(Browser::start()) else {
        return;
    };
    browser.call("Network.enable", json!({}));
    let blocked = json!({ "urls": ["*ilon.wasm"] });
    browser.call("Network.setBlockedURLs", blocked);
    browser.call("Page.navigate", json!({ "url": serve(folder) }));
    until(
        &mut browser,
        "document.documentElement?.dataset.ready === 'yes'",
    );
    let found = browser.eval(
        "[document.querySelectorAll('.slider').length > 5, document.getElementById('scenario').options.length > 50,
          !document.getElementById('run').disabled, !document.getElementById('drive').disabled,
          document.getElementById('broken').options.length > 3, document.querySelector('#live canvas').width > 300,
          document.getElementById('state').textContent]",
    );
    let expected = json!([
        true,
        true,
        true,
        true,
        true,
        true,
        "The simulator could not be loaded."
    ]);
    assert_eq!(found, expected);
}

#[test]
fn a_link_that_a_person_wrote_is_run() {
    let Some((folder, mut browser)) = playground().zip(Browser::start()) else {
        return;
    };
    let settings = ["run.duration_s=1", "world.floor.friction=0.2"];
    let link = format!(
        "{}#scenario=mecanum4_forward&set={}",
        serve(folder),
        settings.join("&set=")
    );
    open(&mut browser, &link);
    let settings: Vec<_> = settings.iter().map(|text| text.parse().unwrap()).collect();
    let path = assets().join("scenarios/mecanum4_forward.toml");
    let here = ilon_sim::run(&Scenario::load_with(path, &settings).unwrap()).unwrap();
    assert_eq!(hash(&mut browser), here.summary.trace_hash);
    assert_silent(&browser);
}

#[test]
fn it_opens_from_a_disk() {
    let Some((folder, mut browser)) = playground().zip(Browser::start()) else {
        return;
    };
    let page = folder.join("index.html").canonicalize().unwrap();
    open(&mut browser, &format!("file://{}", page.display()));
    assert_eq!(hash(&mut browser), expected());
    assert_silent(&browser);
}

#[test]
fn a_robot_is_dropped_a_slider_moved_and_the_run_shared() {
    let Some((folder, mut browser)) = playground().zip(Browser::start()) else {
        return;
    };
    let url = serve(folder);
    browser.size(1366, 768);
    open(&mut browser, &url);
    drop_robot(&mut browser, "mine.urdf", &shipped("robots/volksbot.urdf"));
    until(
        &mut browser,
        "document.getElementById('says').textContent.startsWith('A robot of one')",
    );
    until(
        &mut browser,
        "document.getElementById('state').textContent.startsWith('Changed')",
    );
    // The slider by keyboard.
    browser.eval("document.getElementById('key-world-floor-friction').focus()");
    key(&mut browser, "ArrowLeft", 37);
    until(
        &mut browser,
        "document.getElementById('set_keys').children.length === 1",
    );
    let set = browser.eval("document.querySelector('#set_keys code').textContent");
    let set = set.as_str().unwrap().replace(" = ", "=");
    run(&mut browser);
    let found = hash(&mut browser);
    // The same, computed here from the dropped file.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("mine.urdf"),
        shipped("robots/volksbot.urdf"),
    )
    .unwrap();
    let text = browser.eval("document.getElementById('text').value");
    std::fs::write(folder.path().join("drive.toml"), text.as_str().unwrap()).unwrap();
    let scenario = Scenario::load_with(folder.path().join("drive.toml"), &[set.parse().unwrap()]);
    let here = ilon_sim::run(&scenario.unwrap()).unwrap();
    assert_eq!(found, here.summary.trace_hash);
    let answer = browser.eval(
        "document.getElementById('report').contentDocument.querySelector('.story').innerText",
    );
    assert!(answer.as_str().unwrap().len() > 40, "{answer}");

    browser.eval("document.getElementById('share').click()");
    until(&mut browser, "location.hash.startsWith('#run=')");
    let link = browser.eval("location.href");
    let mut other = Browser::start().expect("another browser");
    open(&mut other, link.as_str().unwrap());
    assert_eq!(hash(&mut other), found);
    assert_silent(&browser);
    assert_silent(&other);
}

#[test]
fn keys_alone_reach_everything_and_run() {
    let Some((folder, mut browser)) = playground().zip(Browser::start()) else {
        return;
    };
    browser.size(1366, 768);
    open(&mut browser, &serve(folder));
    browser.eval("document.querySelectorAll('form details').forEach((d) => { d.open = true; })");
    let mut met = Vec::new();
    for _ in 0..80 {
        key(&mut browser, "Tab", 9);
        let at = browser.eval("document.activeElement.id");
        met.push(at.as_str().unwrap_or_default().to_owned());
    }
    for wanted in [
        "scenario",
        "robot",
        "files",
        "run",
        "key-world-floor-friction",
        "broken",
        "key",
        "text",
        "share",
        "keep",
    ] {
        assert!(
            met.iter().any(|id| id == wanted),
            "{wanted} is not among {met:#?}"
        );
    }
    browser.eval("document.getElementById('run').focus()");
    browser.call(
        "Input.dispatchKeyEvent",
        json!({ "type": "keyDown", "key": "Enter", "code": "Enter", "windowsVirtualKeyCode": 13, "text": "\r" }),
    );
    until(
        &mut browser,
        "document.documentElement.dataset.runs === '2'",
    );
}

#[test]
fn a_bad_file_is_told_in_the_words_of_the_command_and_the_page_goes_on() {
    let Some((folder, mut browser)) = playground().zip(Browser::start()) else {
        return;
    };
    open(&mut browser, &serve(folder));
    let good = hash(&mut browser);
    for (name, text) in [
        ("empty.urdf", ""),
        ("broken.urdf", "<robot name='a'><link"),
        ("wheelless.urdf", "<robot name='a'><link name='b'/></robot>"),
        ("deep.xacro", &format!("<robot>{}", "<a>".repeat(100_000))),
        ("own.toml", "[robot]\nfile = 3\n"),
    ] {
        drop_robot(&mut browser, name, text);
        until(&mut browser, "!document.getElementById('fault').hidden");
        let shown = browser.eval("document.getElementById('fault').textContent");
        assert!(shown.as_str().unwrap().contains('×'), "{name}: {shown}");
        browser.eval(
            "(() => { const s = document.getElementById('scenario'); s.value = '/scenarios/mecanum4_lateral.toml'; s.dispatchEvent(new Event('change')); })()",
        );
        until(&mut browser, "document.getElementById('fault').hidden");
    }
    run(&mut browser);
    assert_eq!(hash(&mut browser), good);
    assert_silent(&browser);
}

#[test]
fn a_simulator_that_breaks_down_is_started_again() {
    let Some((folder, mut browser)) = playground().zip(Browser::start()) else {
        return;
    };
    // An engine throws from the call into the instance when memory runs out or a panic occurs.
    let spoil = "const Old = Worker; window.Worker = class extends Old { constructor(url) { super(url); window.lastWorker = this; } };";
    browser.call(
        "Page.addScriptToEvaluateOnNewDocument",
        json!({ "source": spoil }),
    );
    open(&mut browser, &serve(folder));
    let good = hash(&mut browser);
    browser.eval("window.lastWorker.onerror({ message: 'RuntimeError: unreachable' }); document.getElementById('run').click()");
    until(
        &mut browser,
        "document.documentElement.dataset.runs === '2'",
    );
    assert_eq!(hash(&mut browser), good);
}

#[test]
fn every_shipped_scenario_gives_the_same_trace_hash_in_the_browser() {
    let Some((folder, mut browser)) = playground().zip(Browser::start()) else {
        return;
    };
    open(&mut browser, &serve(folder));
    for name in scenarios() {
        let choose = format!(
            "(() => {{ const s = document.getElementById('scenario'); s.value = '/scenarios/{name}.toml'; s.dispatchEvent(new Event('change')); }})()"
        );
        browser.eval(&choose);
        run(&mut browser);
        assert_eq!(hash(&mut browser), hashes()[&name], "{name}");
    }
}

/// A letter key, down or up.
fn press(browser: &mut Browser, kind: &str, letter: &str) {
    let code = format!("Key{}", letter.to_uppercase());
    browser.call(
        "Input.dispatchKeyEvent",
        json!({ "type": kind, "key": letter, "code": code, "text": if kind == "keyDown" { letter } else { "" } }),
    );
}

/// Waits until the page shows a motion with the signs `sign` of ahead, left and turning, where they
/// are not zero.
fn until_it_moves(browser: &mut Browser, sign: [i32; 3]) {
    until(
        browser,
        &format!(
            "(() => {{ const [tile] = [...document.querySelectorAll('#figures div')].filter((t) => t.textContent.startsWith('Real'));
              const real = tile ? tile.textContent.match(/-?[\\d.]+/g).map(Number) : [];
              return {sign:?}.every((sign, index) => sign === 0 || real[index] * sign > [0.1, 0.1, 10][index]); }})()"
        ),
    );
}

#[test]
fn a_robot_is_driven_by_keys_and_sticks_and_what_it_did_is_a_scenario() {
    let Some((folder, mut browser)) = playground().zip(Browser::start()) else {
        return;
    };
    let url = serve(folder);
    browser.size(390, 844);
    open(&mut browser, &url);
    browser.eval("document.getElementById('drive').click()");
    until(
        &mut browser,
        "document.documentElement.dataset.driving === 'yes'",
    );
    for (letter, sign) in [("w", [1, 0, 0]), ("d", [0, -1, 0]), ("q", [0, 0, 1])] {
        press(&mut browser, "keyDown", letter);
        until_it_moves(&mut browser, sign);
        press(&mut browser, "keyUp", letter);
    }
    // A joystick pushed to the left.
    let at = browser.eval(
        "(() => { const { x, y, width, height } = document.querySelector('.ilon-stick-move').getBoundingClientRect(); return [x + width / 2, y + height / 2, width]; })()",
    );
    let [x, y, width] = [0, 1, 2].map(|index| at[index].as_f64().expect("a place"));
    for (kind, x) in [("mousePressed", x), ("mouseMoved", x - width / 2.0)] {
        browser.call(
            "Input.dispatchMouseEvent",
            json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1 }),
        );
    }
    until_it_moves(&mut browser, [0, 1, 0]);
    assert_fits(&mut browser, "a drive at 390 px");
    let wheels = browser.eval("document.querySelector('#wheels table').innerText");
    assert_eq!(
        wheels.as_str().unwrap().matches("mm/s").count(),
        4,
        "{wheels}"
    );

    browser.eval("document.getElementById('end_drive').click()");
    until(
        &mut browser,
        "document.documentElement.dataset.runs === '2'",
    );
    until(&mut browser, ANSWERED);
    let found = hash(&mut browser);
    // The same, computed here from the downloaded files.
    let here = tempfile::tempdir().unwrap();
    for below in ["robots", "scenarios"] {
        std::fs::create_dir(here.path().join(below)).unwrap();
    }
    let put = |name: &str, text: &str| std::fs::write(here.path().join(name), text).unwrap();
    put("robots/mecanum4.urdf", &shipped("robots/mecanum4.urdf"));
    let text = browser.eval("document.getElementById('text').value");
    put(
        "scenarios/mecanum4_lateral_driven.toml",
        text.as_str().unwrap(),
    );
    let log = browser.eval(
        "(() => { const old = URL.createObjectURL; let taken; URL.createObjectURL = (blob) => { taken = blob; return old(blob); };
           document.getElementById('log').click(); URL.createObjectURL = old; return taken.text(); })()",
    );
    put(
        "scenarios/mecanum4_lateral_driven.csv",
        log.as_str().unwrap(),
    );
    let scenario = Scenario::load(here.path().join("scenarios/mecanum4_lateral_driven.toml"));
    let again = ilon_sim::run(&scenario.unwrap()).unwrap();
    assert_eq!(found, again.summary.trace_hash);

    browser.eval("document.getElementById('share').click()");
    until(&mut browser, "location.hash.startsWith('#run=')");
    let link = browser.eval("location.href");
    let mut other = Browser::start().expect("another browser");
    open(&mut other, link.as_str().unwrap());
    assert_eq!(hash(&mut other), found);
    assert_silent(&browser);
    assert_silent(&other);
}
