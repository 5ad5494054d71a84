//! The scene in a real browser: what is drawn, how it reacts, and that the console stays silent.
//!
//! Needs Chromium, named by `ILON_CHROMIUM` or found as `chromium`; without it the tests report
//! that they were skipped.

use std::path::Path;
use std::process::Command;

use ilon_formats::{LoadRobot, link_tree};
use ilon_robot::{Robot, VisualMeshes};
use ilon_scene::{Contact, Description, Frame, Frames, Relief, Scene, WheelFrame, embed};
use serde_json::Value;

use crate::page;

fn browser() -> Option<String> {
    let named = std::env::var("ILON_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    let answers = Command::new(&named)
        .arg("--version")
        .output()
        .is_ok_and(|o| o.status.success());
    if !answers {
        eprintln!("skipped: no Chromium; install it or name it in ILON_CHROMIUM");
    }
    answers.then_some(named)
}

fn robot(name: &str) -> (Robot, String) {
    let path = format!(
        "{}/../../../assets/robots/{name}.urdf",
        env!("CARGO_MANIFEST_DIR")
    );
    let urdf = std::fs::read_to_string(&path).expect("a shipped robot");
    let robot = Robot::from_urdf_str(&urdf, &path).expect("a shipped robot is read");
    (robot, urdf)
}

/// Two seconds along a curve, each wheel with its share of the weight and a tenth of its friction
/// limit.
fn drive(robot: &Robot) -> Frames {
    let share_n = robot.mass_kg() * 9.81 / robot.wheels.len() as f64;
    let frames = (0..=120).map(|k| {
        let t_s = f64::from(k) / 60.0;
        let mut frame = Frame::at_rest(robot);
        frame.t_s = t_s;
        frame.pose.x_m = 0.5 * t_s;
        frame.pose.heading_rad = 0.6 * t_s;
        frame.ghost = Some(ilon_robot::Pose {
            y_m: 0.1 * t_s,
            ..frame.pose
        });
        frame.wanted = Some(ilon_robot::Pose {
            y_m: 0.02,
            ..frame.pose
        });
        for (state, wheel) in frame.wheels.iter_mut().zip(&robot.wheels) {
            let at = wheel.position_m();
            *state = WheelFrame {
                angle_rad: 10.0 * t_s,
                contact: Some(Contact {
                    place_m: [at.x, at.y],
                    normal_force_n: share_n,
                    force_n: [0.06 * share_n, 0.0],
                    slip_m_s: [0.0, 0.02],
                    friction: 0.6,
                }),
                roller: k as usize / 10 % wheel.rollers.len(),
                roller_angles_rad: vec![20.0 * t_s; wheel.rollers.len()],
            };
        }
        frame
    });
    Frames::of(robot, frames)
}

/// With virtual time, a browser runs no animation frames by itself.
const FRAMES_BY_CLOCK: &str = "window.requestAnimationFrame = (call) => setTimeout(() => call(performance.now()), 16); \
     window.cancelAnimationFrame = clearTimeout;";

/// The results of the checks in a page with a scene. The console must be silent.
fn found(browser: &str, scene: &Scene, arguments: &[&str]) -> Value {
    let folder = tempfile::tempdir().expect("a folder to write to");
    let page = folder.path().join("page.html");
    let html = format!(
        "<!doctype html><html lang='en'><meta charset='utf-8'><title>scene</title><link rel='icon' href='data:,'>\
         <style>{}</style><div style='position: relative; width: 640px; height: 400px'><canvas></canvas></div>\
         <script type='application/json' id='data'>{}</script><script>{FRAMES_BY_CLOCK}</script><script>{}</script>\
         <script>{}</script></html>",
        embed::STYLE,
        embed::data(scene).expect("a scene is JSON"),
        embed::script(),
        include_str!("../checks.js"),
    );
    std::fs::write(&page, html).expect("the page is written");
    let (dom, console) = opened(browser, &page, folder.path(), arguments);
    assert!(console.is_empty(), "the console says: {console:#?}");
    let json = dom
        .split("<pre id=\"found\">FOUND")
        .nth(1)
        .and_then(|rest| rest.split("END").next());
    let json = json.unwrap_or_else(|| panic!("the checks did not end: {dom}"));
    let json = json
        .replace("&amp;", "&")
        .replace("&lt;", "<")
        .replace("&gt;", ">");
    serde_json::from_str(&json).expect("what is found is JSON")
}

/// The page's elements after a while and the console's messages, except the browser's own about
/// software rendering and reading pixels.
fn opened(browser: &str, page: &Path, folder: &Path, arguments: &[&str]) -> (String, Vec<String>) {
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
        .args(["--enable-unsafe-swiftshader", "--window-size=1000,700"])
        .args([
            "--enable-logging=stderr",
            "--virtual-time-budget=20000",
            "--dump-dom",
        ])
        .args(arguments)
        .arg(format!(
            "--user-data-dir={}",
            folder.join("profile").display()
        ))
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("Chromium starts");
    let said = String::from_utf8_lossy(&output.stderr);
    let console = said
        .lines()
        .filter(|line| line.contains(":CONSOLE"))
        .filter(|line| !line.contains("GL Driver Message") && !line.contains("software WebGL"))
        .map(str::to_owned);
    (
        String::from_utf8_lossy(&output.stdout).into_owned(),
        console.collect(),
    )
}

fn number(found: &Value, name: &str) -> f64 {
    found[name]
        .as_f64()
        .unwrap_or_else(|| panic!("no {name} in {found:#}"))
}

/// Share of changed pixels above which two pictures differ: thousands of pixels; chosen.
const ANOTHER: f64 = 0.01;

/// Asserts on the checks what every scene must do.
fn assert_it_works(found: &Value, robot: &Robot) {
    assert_eq!(found["error"], Value::Null, "{found:#}");
    let above =
        |name: &str, least: f64| assert!(number(found, name) > least, "{name} in {found:#}");
    let same = |name: &str| assert_eq!(number(found, name), 0.0, "{name} in {found:#}");
    assert_eq!(found["supported"], true);
    above("middle_covered", 0.95);
    same("corner_covered");
    above("followed", 0.95);
    above("changed_by_time", ANOTHER);
    same("same_time_same_picture");
    // Halfway through two seconds, between two frames or on one, in f32.
    assert!((number(found, "time") - 1.0).abs() < 1e-6);
    assert_eq!(found["end"][0], found["end"][1]);
    assert_eq!(found["touching"], robot.wheels.len());
    // Forces have a resolution of one part in 65534.
    let weight_n = robot.mass_kg() * 9.81;
    assert!((number(found, "load_n") / weight_n - 1.0).abs() < 1e-4);
    // f32 and 1/65534 of the height: micrometres.
    assert!(number(found, "highest_contact_m") < 1e-5, "{found:#}");

    same("drawn_idle");
    assert_eq!(found["drawn_for_ten_seeks"], 1);

    above("closeup_changes", 5.0 * ANOTHER);
    let note = found["note"].as_str().unwrap_or_default();
    assert!(note.starts_with(&robot.wheels[1].name), "{note}");
    assert_eq!(
        (&found["note_hidden"], &found["note_hidden_again"]),
        (&Value::Bool(false), &Value::Bool(true))
    );
    same("back");
    assert_eq!(found["picked"].as_array().map(Vec::len), Some(1));
    assert_eq!(
        found["selected"].as_array().and_then(|s| s.last()),
        Some(&found["picked"][0])
    );
    assert_eq!(found["selected_nonsense"], Value::Null);

    above("turned", ANOTHER);
    above("nearer", ANOTHER);
    same("home");
    above("whole", ANOTHER);
    above("top", ANOTHER);
    above("dark", 0.5);
    same("light_again");
    assert_eq!(found["width"][0], found["width"][1]);
    same("restored");

    assert_eq!(found["live_before"], 0);
    // Of a thousand frames at 0.01 s the last hundred, or at least half of them; 0.999 m in f32.
    let live = |i: usize| found["live"][i].as_f64().unwrap_or(f64::NAN);
    assert!(live(0) >= 8.98 && live(0) <= 9.5, "{found:#}");
    assert!(
        (live(1) - 9.99).abs() < 1e-6 && (live(2) - 0.999).abs() < 1e-6,
        "{found:#}"
    );
    assert_eq!(found["live_replaced"][0], found["live"][0]);
    assert_eq!(found["live_replaced"][1], 7);
    assert_eq!(found["live_begun_again"], serde_json::json!([0.5, 0.5]));
    assert_eq!(found["timeless"], "a frame has no time");
    assert!(
        found["refused"]
            .as_str()
            .is_some_and(|said| said.contains("not"))
    );
    same("left_after_dispose");
    assert_eq!(found["without_webgl"][0], false);
    assert!(
        found["without_webgl"][1]
            .as_str()
            .is_some_and(|s| s.contains("WebGL 2"))
    );
}

#[test]
fn a_mecanum_robot_is_drawn_answers_and_the_console_stays_silent() {
    let Some(browser) = browser() else { return };
    let (robot, urdf) = robot("mecanum4");
    let scene = Scene::new(
        Description::of_robot(&robot, link_tree(&urdf).as_ref(), &VisualMeshes::default()),
        drive(&robot),
    );
    let found = found(&browser, &scene, &["--force-prefers-reduced-motion"]);
    assert_it_works(&found, &robot);
}

#[test]
fn a_robot_whose_chassis_is_a_mesh_is_drawn() {
    let Some(browser) = browser() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    // The box of the shipped robot with its faces wound the wrong way, as in many users' meshes.
    let corners = (0..8).map(|k| {
        let side = |bit: usize, half: f64| if k >> bit & 1 == 1 { half } else { -half };
        format!("v {} {} {}\n", side(0, 0.2), side(1, 0.12), side(2, 0.05))
    });
    let faces = "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";
    let obj = corners.collect::<String>() + faces;
    std::fs::write(folder.path().join("box.obj"), obj).expect("a file");
    let (_, urdf) = robot("mecanum4");
    let shown = "<box size=\"0.4 0.24 0.1\"/></geometry><material";
    let mesh = "<mesh filename=\"box.obj\"/></geometry><material";
    assert!(urdf.contains(shown));
    let file = folder.path().join("robot.urdf").display().to_string();
    let options = ilon_formats::LoadOptions::default();
    let loaded = Robot::from_urdf_str_with(&urdf.replace(shown, mesh), &file, &options);
    let loaded = loaded.expect("it is read");
    let description = Description::of_robot(
        &loaded.robot,
        loaded.links().as_ref(),
        &loaded.visual_meshes(),
    );
    assert_eq!(description.robot.meshes.len(), 1);
    let scene = Scene::new(description, drive(&loaded.robot));
    let found = found(&browser, &scene, &["--force-prefers-reduced-motion"]);
    assert_it_works(&found, &loaded.robot);
}

#[test]
fn a_robot_on_a_slope_with_bumps_patches_boxes_and_pushes_is_drawn() {
    let Some(browser) = browser() else { return };
    let (robot, _) = robot("volksbot");
    let mut description = Description::of_robot(&robot, None, &VisualMeshes::default());
    let heights = (0..31).map(|j| {
        (0..41)
            .map(|i| 0.0005 * f64::from((i * 7 + j * 3) % 5))
            .collect()
    });
    description.relief = Relief::new(0.05, [0.3, -0.2], &heights.collect::<Vec<Vec<f64>>>());
    assert!(description.relief.is_some());
    let ground = r#"{ "friction": 0.6, "slope_rad": 0.2,
        "patches": [{ "center_m": [0.5, 0.5], "sides_m": [0.4, 0.4], "friction": 0.02, "from_s": 0 }],
        "boxes": [{ "center_m": [0.8, 0], "sides_m": [0.2, 1, 0.1], "heading_rad": 0.3 }],
        "ramps": [{ "center_m": [-0.8, 0, 0.05], "sides_m": [0.2, 1, 0.1], "heading_rad": 0.3, "pitch_rad": -0.1 }] }"#;
    description.ground = serde_json::from_str(ground).expect("a ground");
    let faults = r#"[{ "from_s": 0.5, "until_s": 1.5, "kind": { "friction_changed": { "friction": 0.1 } } },
        { "from_s": 0.4, "kind": "pose_lost" },
        { "from_s": 0.9, "until_s": 1, "kind": { "push": { "impulse_n_s": [0, -8, 0], "in_body": false, "place_m": [0.2, 0.1, 0.06] } } }]"#;
    description.faults = serde_json::from_str(faults).expect("faults");
    description.reference = vec![[0.0, 0.0], [1.0, 1.0]];
    let found = found(&browser, &Scene::new(description, drive(&robot)), &[]);
    assert_it_works(&found, &robot);
}

#[test]
fn the_page_of_the_example_shows_a_time_that_its_address_names_and_its_console_stays_silent() {
    let Some(browser) = browser() else { return };
    let (robot, urdf) = robot("mecanum6");
    let scene = Scene::new(
        Description::of_robot(&robot, link_tree(&urdf).as_ref(), &VisualMeshes::default()),
        drive(&robot),
    );
    let folder = tempfile::tempdir().expect("a folder to write to");
    let page = folder.path().join("page.html");
    let html = page::html("a <run> & more", &scene).expect("the page is made");
    std::fs::write(&page, html).expect("the page is written");
    let address = format!("{}#t=1.25&wheel=3&view=whole&theme=dark", page.display());
    let (dom, console) = opened(&browser, Path::new(&address), folder.path(), &[]);
    assert!(console.is_empty(), "the console says: {console:#?}");
    assert!(dom.contains("<h1>a &lt;run&gt; &amp; more</h1>"));
    assert!(dom.contains("1.25 s</output>"), "no clock");
    assert!(dom.contains("data-theme=\"dark\""));
}
