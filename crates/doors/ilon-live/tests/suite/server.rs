//! The live server: which clients are admitted, which messages are accepted, and that no client can
//! stop the robot. An independent client talks to it (`client.py`).

use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use ilon_live::{Controls, Mailbox, Mode, Observer, Pace, Server, Session};
use ilon_robot::Pose;
use ilon_sim::Scenario;

fn session(further: &[&str]) -> Session {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/scenarios/mecanum4_circle.toml"
    );
    // Only the rollers near the ground, which leaves CPU time for the clients.
    let settings = [&["robot.roller_bodies=near"], further].concat();
    let settings: Vec<_> = settings
        .iter()
        .map(|text| text.parse().expect("a setting"))
        .collect();
    let scenario = Scenario::load_with(path, &settings).expect("a scenario");
    Session::new(&scenario).expect("a session")
}

/// A Python with `websockets`: that of `ILON_PYTHON`, or `python3`.
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

/// Serves a session in real time while a script drives it, and returns the script's output.
fn served(script: &str, further: &[&str]) -> Option<String> {
    let python = python()?;
    let mut session = session(&["robot.x_m=0", "robot.heading_deg=0"]);
    let floats = session.frame().values().len().to_string();
    let desk = Mailbox::default();
    let mut server = Server::start(0, &session, &desk).expect("a server");
    let port = port(&server).to_string();
    let ended = AtomicBool::new(false);
    let output = std::thread::scope(|scope| {
        let client = scope.spawn(|| {
            let script = format!("{}/tests/{script}", env!("CARGO_MANIFEST_DIR"));
            let own = if further.is_empty() {
                &[floats.as_str()]
            } else {
                further
            };
            let output = Command::new(python)
                .args([&script, &port])
                .args(own)
                .output();
            ended.store(true, Ordering::Relaxed);
            output.expect("Python runs")
        });
        let begun = Instant::now();
        let go_on = || !ended.load(Ordering::Relaxed) && begun.elapsed() < Duration::from_secs(300);
        let watchers: &mut [&mut dyn Observer] = &mut [&mut server];
        ilon_live::run(&mut session, &desk, watchers, Pace::default(), go_on).expect("a run");
        client.join().expect("the client ends")
    });
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    print!("{printed}");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    Some(printed)
}

fn port(server: &Server) -> u16 {
    let url = server.url();
    let port = url.trim_end_matches('/').rsplit(':').next();
    port.and_then(|port| port.parse().ok()).expect("a port")
}

#[test]
fn a_client_of_others_drives_and_none_does_harm() {
    served("client.py", &[]);
}

#[test]
fn keys_and_sticks_drive_in_a_browser() {
    let named = std::env::var("ILON_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    let found = Command::new(&named).arg("--version").output();
    if !found.is_ok_and(|output| output.status.success()) {
        println!("skipped: no Chromium; install it or name it in ILON_CHROMIUM");
        return;
    }
    served("browser.py", &[&named]);
}

#[test]
fn a_command_stops_the_robot_when_it_is_old_by_both_clocks() {
    let mut session = session(&[]);
    let mut controls = Controls::default();
    controls.take(r#"{"twist": [0.5, 0, 0]}"#);
    let asked = |session: &mut Session, controls: &Controls, steps: usize| {
        (0..steps).for_each(|_| session.advance(controls).expect("a step"));
        session.figures(controls).asked[0]
    };
    // Long by the simulated clock only: simulation faster than real time.
    let steps = (2.0 / session.control_dt_s()) as usize;
    assert_eq!(asked(&mut session, &controls, steps), 0.5);
    // By both clocks: it stops, and that is reported once.
    std::thread::sleep(ilon_live::control::WATCHDOG);
    assert_eq!(asked(&mut session, &controls, 20), 0.0);
    let notes: Vec<String> = session.take_notes().collect();
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(notes[0].contains("no command for 0.5 s"), "{notes:?}");
    // By the wall clock only: the simulation is paused, and continues step by step.
    controls.take(r#"{"twist": [0.5, 0, 0]}"#);
    assert_eq!(asked(&mut session, &controls, 1), 0.5);
    std::thread::sleep(ilon_live::control::WATCHDOG);
    assert_eq!(asked(&mut session, &controls, 1), 0.5);
}

#[test]
fn wheels_turn_as_commanded_within_their_limit() {
    let mut session = session(&["guidance.wheel_rate_limit_rad_s=5"]);
    let mut controls = Controls::default();
    let rates = |session: &Session| -> Vec<f64> {
        let row = session.row().expect("a row");
        row.wheels.iter().map(|wheel| wheel.target_rad_s).collect()
    };
    controls.take(r#"{"wheels": [1, 2, -3, 100]}"#);
    session.advance(&controls).expect("a step");
    assert_eq!(rates(&session), [1.0, 2.0, -3.0, 5.0]);
    assert!(
        session
            .take_notes()
            .any(|note| note.contains("100.000 rad/s"))
    );
    // A robot of four wheels cannot follow three rates.
    controls.take(r#"{"wheels": [1, 2, 3]}"#);
    session.advance(&controls).expect("a step");
    assert_eq!(rates(&session), [0.0; 4]);
    assert!(
        session
            .take_notes()
            .any(|note| note.contains("3 wheel rates"))
    );
}

#[test]
fn a_payload_loads_the_wheels_and_stays_over_a_reset() {
    let mut session = session(&[]);
    let mut controls = Controls::default();
    let carried_n = |session: &mut Session, controls: &Controls| {
        for _ in 0..50 {
            session.advance(controls).expect("a step");
        }
        let row = session.row().expect("a row");
        row.wheels
            .iter()
            .map(|wheel| wheel.normal_force_n)
            .sum::<f64>()
    };
    let bare_n = carried_n(&mut session, &controls);
    controls.take(r#"{"payload_kg": 10}"#);
    let loaded_n = carried_n(&mut session, &controls);
    // 10 kg weigh 98.07 N on a level floor; the remaining settling is far below 1 N.
    assert!(
        (loaded_n - bare_n - 98.07).abs() < 1.0,
        "{bare_n} N, then {loaded_n} N"
    );
    controls.take(r#"{"reset": true}"#);
    assert!((carried_n(&mut session, &controls) - loaded_n).abs() < 1.0);
    controls.take(r#"{"payload_kg": 0}"#);
    assert!((carried_n(&mut session, &controls) - bare_n).abs() < 1.0);
}

#[test]
fn time_that_stands_goes_on_step_by_step() {
    let mut session = session(&[]);
    let desk = Mailbox::default();
    struct Rows(Vec<f64>);
    impl Observer for Rows {
        fn row(&mut self, row: ilon_live::Row<'_>) {
            self.0.push(row.record.t_s);
        }
    }
    let (sender, done) = std::sync::mpsc::channel();
    let pace = Pace {
        paused: true,
        ..Pace::default()
    };
    let mut rows = Rows(Vec::new());
    let asks = {
        let desk = desk.clone();
        std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(200));
            for count in [1, 0, 7] {
                let sender = sender.clone();
                desk.step(count, move |result| drop(sender.send(result)));
                done.recv_timeout(Duration::from_secs(20))
                    .expect("an answer")
                    .expect("done");
            }
            desk.take(r#"{"paused": false}"#);
            let (sender, done) = std::sync::mpsc::channel();
            desk.step(1, move |result| drop(sender.send(result)));
            let refused = done
                .recv_timeout(Duration::from_secs(20))
                .expect("an answer");
            assert!(refused.is_err(), "time goes on, and yet a step was taken");
        })
    };
    let mut counted = None;
    let mut watchers: [&mut dyn Observer; 1] = [&mut rows];
    ilon_live::run(&mut session, &desk, &mut watchers, pace, || {
        counted = counted.or_else(|| (!desk.controls().paused && asks.is_finished()).then_some(()));
        counted.is_none()
    })
    .expect("a run");
    asks.join().expect("all held");
    // One and seven steps, and then real time for a moment; each a control period after the last.
    assert!(rows.0.len() >= 8, "{:?}", rows.0);
    let dt_s = session.control_dt_s();
    for (step, t_s) in rows.0.iter().enumerate() {
        assert!((t_s - step as f64 * dt_s).abs() < 1e-9, "{:?}", rows.0);
    }
}

/// Records time and pose at each return to the start.
#[derive(Default)]
struct SeesReturns(Vec<(f64, f64, Pose)>);

impl Observer for SeesReturns {
    fn restarted(&mut self, session: &Session) {
        let pose = session.frame().pose;
        self.0
            .push((session.time_s(), session.drive_time_s(), pose));
    }
}

#[test]
fn the_robot_goes_back_to_its_start_while_time_stands() {
    let mut session = session(&[]);
    let start = session.frame().pose;
    let mut controls = Controls::default();
    controls.take(r#"{"twist": [0.4, 0, 0]}"#);
    for _ in 0..20 {
        session.advance(&controls).expect("a period");
    }
    let went_s = session.time_s();
    let away_m = session.frame().pose.position_m() - start.position_m();
    assert!(went_s > 0.0 && away_m.norm() > 1e-3);
    let (desk, mut sees) = (Mailbox::default(), SeesReturns::default());
    desk.take(r#"{"reset": true}"#);
    let pace = Pace {
        paused: true,
        ..Pace::default()
    };
    let mut rounds = 0..3;
    let go_on = || rounds.next().is_some();
    ilon_live::run(&mut session, &desk, &mut [&mut sees], pace, go_on).expect("a run");
    assert_eq!(
        sees.0,
        [(went_s, 0.0, start)],
        "once, where it began, and no time passes"
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
        // It starts 1.5 m off, and with heading first it turns by 120 degrees before it drives
        // there.
        assert!(off_m(&session) > 1.0);
        let steps = (20.0 / session.control_dt_s()) as usize;
        (0..steps).for_each(|_| session.advance(&controls).expect("a step"));
        assert!(off_m(&session) < 0.05, "{first}: {} m off", off_m(&session));
    }
}

/// Only position tasks: the robot moves onto the circle, and only its rollers' slip turns it.
#[test]
fn the_guidance_has_the_tasks_of_the_scenario() {
    let tasks = "guidance.tasks=[\"position_feedforward\", \"position_feedback\"]";
    let mut session = session(&[tasks]);
    let mut controls = Controls::default();
    assert_eq!(controls.take("{\"mode\": \"reference\"}"), None);
    let start_rad = session.frame().pose.heading_rad;
    let steps = (20.0 / session.control_dt_s()) as usize;
    (0..steps).for_each(|_| session.advance(&controls).expect("a step"));
    let error_m = session.figures(&controls).reference_error_m;
    assert!(error_m.expect("a reference") < 0.05, "{error_m:?}");
    let turned_rad = (session.frame().pose.heading_rad - start_rad).abs();
    assert!(turned_rad < 0.2, "turned by {turned_rad} rad");
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
    // In half a second ice allows at most mu g t^2 / 2 = 25 mm.
    assert!(
        ice_m < 0.026 && floor_m > 0.2,
        "{ice_m} m on ice, {floor_m} m on the floor"
    );
    assert!(
        (way_m(&mut session, 0.02) - ice_m).abs() < 1e-9,
        "not the same from the start again"
    );
}

/// A recording begins at the start, and `ilon run` repeats it: the same commands in the same world
/// end in the same pose, to the last bit.
#[test]
fn a_recorded_drive_is_repeated_by_its_scenario() {
    let folder = std::env::temp_dir().join(format!("ilon_drive_{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let mut session = session(&[]);
    session.record_into(&folder);
    let mut controls = Controls::default();
    let mut drive = |controls: &mut Controls, message: &str, periods: usize| {
        for _ in 0..periods {
            controls.take(message);
            session.advance(controls).expect("a step");
        }
        session.frame().pose
    };
    drive(&mut controls, r#"{"twist": [0.3, 0, 0]}"#, 30);
    drive(
        &mut controls,
        r#"{"record": true, "twist": [0.1, 0.3, 0]}"#,
        50,
    );
    // Back at the start the recording begins anew: the turn alone is in it.
    drive(&mut controls, r#"{"reset": true}"#, 1);
    let end = drive(&mut controls, r#"{"twist": [0, 0, 0.8]}"#, 50);
    drive(&mut controls, r#"{"record": false}"#, 1);
    let notes: Vec<String> = session.take_notes().collect();
    let path = folder.join("mecanum4_circle_1_driven.toml");
    assert!(
        notes.concat().contains("mecanum4_circle_1_driven.toml"),
        "{notes:?}"
    );
    let scenario = Scenario::load(&path).expect("a scenario");
    let run = ilon_sim::simulate::Simulation::new(&scenario)
        .expect("a run")
        .run();
    let last = run.trace.records().last().expect("rows").truth.pose;
    std::fs::remove_dir_all(&folder).expect("it is removed");
    assert_eq!(run.summary.duration_s, 0.51);
    assert_eq!(last, end);
}

/// A push of F for t gives a robot on ice at most F t / m, and most of it where friction is small:
/// 50 N for 0.1 s on 11.36 kg are 0.44 m/s. It ends when it is not repeated.
#[test]
fn a_push_moves_the_robot_and_ends() {
    let mut session = session(&["world.floor.friction=0.01"]);
    let mut controls = Controls::default();
    controls.take(r#"{"push_n": [0, 50]}"#);
    let speed = |session: &Session, controls: &Controls| {
        let [vx, vy, _] = session.figures(controls).real;
        vx.hypot(vy)
    };
    for _ in 0..10 {
        session.advance(&controls).expect("a step");
    }
    let pushed_m_s = speed(&session, &controls);
    assert!((0.3..0.45).contains(&pushed_m_s), "{pushed_m_s}");
    std::thread::sleep(Duration::from_millis(250));
    assert_eq!(controls.push_n(), None);
    session.advance(&controls).expect("a step");
    assert!(speed(&session, &controls) <= pushed_m_s + 1e-3);
    let said = controls
        .take(r#"{"push_n": [1e9, 0]}"#)
        .expect("it is limited");
    assert!(said.contains("push_n"), "{said}");
}

#[test]
fn a_port_that_is_taken_is_said() {
    let session = session(&[]);
    let desk = Mailbox::default();
    let first = Server::start(0, &session, &desk).expect("a server");
    let port = port(&first);
    let second = Server::start(port, &session, &desk)
        .map(|_| ())
        .expect_err("it is taken");
    assert!(second.to_string().contains(&port.to_string()), "{second}");
}

/// A refused client reads the whole answer and then the end, not a reset connection: the bytes of
/// its request were taken before the server closed.
#[test]
fn a_refusal_arrives_whole() {
    let session = session(&[]);
    let server = Server::start(0, &session, &Mailbox::default()).expect("a server");
    let port = port(&server);
    for (request, status) in [
        (
            format!("GET /nowhere HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n"),
            "404",
        ),
        (
            "GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n".to_owned(),
            "403",
        ),
        (
            "GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n".to_owned(),
            "400",
        ),
    ] {
        for _ in 0..20 {
            let mut stream = TcpStream::connect(("127.0.0.1", port)).expect("a connection");
            stream.write_all(request.as_bytes()).expect("a request");
            let mut answer = String::new();
            stream
                .read_to_string(&mut answer)
                .expect("an answer and its end");
            assert!(
                answer.starts_with(&format!("HTTP/1.1 {status}")),
                "{answer}"
            );
        }
    }
}
