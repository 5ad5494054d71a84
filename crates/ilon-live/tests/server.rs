//! The live server: who is let in, what is heard, and that nothing a client does stops the robot. An independent client speaks with it
//! (`client.py`).

use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use ilon_live::{Controls, Mode, Pace, Server, Session};
use ilon_sim::Scenario;

fn session(further: &[&str]) -> Session {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../assets/scenarios/mecanum4_circle.toml"
    );
    // Only the rollers within reach, which leaves the machine time for the clients.
    let settings = [&["robot.roller_bodies=near"], further].concat();
    let settings: Vec<_> = settings
        .iter()
        .map(|text| text.parse().expect("a setting"))
        .collect();
    let scenario = Scenario::load_with(path, &settings).expect("a scenario");
    Session::new(&scenario).expect("a session")
}

/// A Python with `websockets`: that under `ILON_PYTHON`, or `python3`.
fn python() -> Option<String> {
    let named = std::env::var("ILON_PYTHON").ok();
    let python = named.clone().unwrap_or("python3".into());
    let tried = Command::new(&python)
        .args(["-c", "import websockets"])
        .output();
    if tried.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    assert!(
        named.is_none(),
        "{python}, named by ILON_PYTHON, lacks what tests/requirements.txt lists"
    );
    println!("skipped: {python} lacks what tests/requirements.txt lists");
    None
}

#[test]
fn a_client_of_others_drives_and_none_does_harm() {
    let Some(python) = python() else { return };
    let mut session = session(&["robot.x_m=0", "robot.heading_deg=0"]);
    let floats = session.frame().values().len().to_string();
    let server = Server::start(0, &session).expect("a server");
    let port = server
        .url()
        .trim_end_matches('/')
        .rsplit(':')
        .next()
        .expect("a port")
        .to_owned();
    let ended = AtomicBool::new(false);
    let output = std::thread::scope(|scope| {
        let client = scope.spawn(|| {
            let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/client.py");
            let output = Command::new(python).args([script, &port, &floats]).output();
            ended.store(true, Ordering::Relaxed);
            output.expect("Python runs")
        });
        let begun = Instant::now();
        let go_on = || !ended.load(Ordering::Relaxed) && begun.elapsed() < Duration::from_secs(300);
        ilon_live::run(&mut session, &server, Pace::default(), go_on).expect("a run");
        client.join().expect("the client ends")
    });
    print!("{}", String::from_utf8_lossy(&output.stdout));
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn the_guidance_follows_the_reference_whatever_comes_first() {
    for first in ["position", "heading"] {
        let mut session = session(&[]);
        let mut controls = Controls::default();
        assert_eq!(
            controls.take(&format!(
                "{{\"mode\": \"reference\", \"priority\": \"{first}\"}}"
            )),
            None
        );
        assert_eq!(controls.mode, Mode::Reference);
        let off_m = |session: &Session| {
            let figures = session.figures(&controls);
            figures.reference_error_m.expect("a reference")
        };
        // It starts 1.5 m off, and turns by 120 degrees before it hurries there where heading comes first.
        assert!(off_m(&session) > 1.0);
        let steps = (20.0 / session.control_dt_s()) as usize;
        (0..steps).for_each(|_| session.advance(&controls).expect("a step"));
        assert!(off_m(&session) < 0.05, "{first}: {} m off", off_m(&session));
    }
}

#[test]
fn ice_takes_the_grip_and_the_start_is_where_it_was() {
    let mut session = session(&[]);
    let start = session.frame().pose;
    let mut controls = Controls::default();
    let mut way_m = |session: &mut Session, friction: f64| {
        controls.take("{\"reset\": true}");
        for _ in 0..50 {
            controls.take(&format!(
                "{{\"twist\": [1.0, 0, 0], \"friction\": {friction}}}"
            ));
            session.advance(&controls).expect("a step");
        }
        (session.frame().pose.position_m() - start.position_m()).norm()
    };
    let (ice_m, floor_m) = (way_m(&mut session, 0.02), way_m(&mut session, 0.8));
    // In half a second ice gives at most mu g t^2 / 2 = 25 mm.
    assert!(
        ice_m < 0.026 && floor_m > 0.2,
        "{ice_m} m on ice, {floor_m} m on the floor"
    );
    assert!(
        (way_m(&mut session, 0.02) - ice_m).abs() < 1e-9,
        "not the same from the start again"
    );
}

#[test]
fn a_port_that_is_taken_is_said() {
    let session = session(&[]);
    let first = Server::start(0, &session).expect("a server");
    let port: u16 = first
        .url()
        .trim_end_matches('/')
        .rsplit(':')
        .next()
        .and_then(|port| port.parse().ok())
        .expect("a port");
    let second = Server::start(port, &session)
        .map(|_| ())
        .expect_err("it is taken");
    assert!(second.to_string().contains(&port.to_string()), "{second}");
}
