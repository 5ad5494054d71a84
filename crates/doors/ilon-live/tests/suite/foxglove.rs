//! The server for Foxglove: an independent client subscribes, drives, changes parameters and sends
//! invalid messages (`foxglove.py`).

#![cfg(feature = "foxglove")]

use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use ilon_live::foxglove::Foxglove;
use ilon_live::{Mailbox, Observer, Pace, Session};
use ilon_sim::Scenario;

fn session() -> Session {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/scenarios/mecanum4_circle.toml"
    );
    let settings = [
        "robot.roller_bodies=near",
        "robot.x_m=0",
        "robot.heading_deg=0",
    ];
    let settings: Vec<_> = settings
        .iter()
        .map(|text| text.parse().expect("a setting"))
        .collect();
    let scenario = Scenario::load_with(path, &settings).expect("a scenario");
    Session::new(&scenario).expect("a session")
}

#[test]
fn a_viewer_of_others_looks_on_drives_and_does_no_harm() {
    let named = std::env::var("ILON_PYTHON").ok();
    let python = named.clone().unwrap_or("python3".into());
    let needs = "import websockets, mcap_ros2, rosbags";
    let tried = Command::new(&python).args(["-c", needs]).output();
    if !tried.is_ok_and(|output| output.status.success()) {
        assert!(
            named.is_none(),
            "{python}, named by ILON_PYTHON, lacks what tests/requirements.txt lists"
        );
        println!("skipped: {python} lacks what tests/requirements.txt lists");
        return;
    }
    let mut session = session();
    let desk = Mailbox::default();
    let mut server = Foxglove::start(0, &session, &desk).expect("a server");
    let url = server.url();
    let ended = AtomicBool::new(false);
    let output = std::thread::scope(|scope| {
        let client = scope.spawn(|| {
            let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/foxglove.py");
            let output = Command::new(python).args([script, &url]).output();
            ended.store(true, Ordering::Relaxed);
            output.expect("Python runs")
        });
        let begun = Instant::now();
        let go_on = || !ended.load(Ordering::Relaxed) && begun.elapsed() < Duration::from_secs(500);
        let watchers: &mut [&mut dyn Observer] = &mut [&mut server];
        ilon_live::run(&mut session, &desk, watchers, Pace::default(), go_on).expect("a run");
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
fn a_port_that_is_taken_is_said() {
    let (session, desk) = (session(), Mailbox::default());
    let first = Foxglove::start(0, &session, &desk).expect("a server");
    let port: u16 = first
        .url()
        .rsplit(':')
        .next()
        .and_then(|port| port.parse().ok())
        .expect("a port");
    let second = Foxglove::start(port, &session, &desk).map(|_| ());
    let said = second.expect_err("it is taken").to_string();
    assert!(said.contains(&port.to_string()), "{said}");
}
