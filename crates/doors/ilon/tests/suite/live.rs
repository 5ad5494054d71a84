//! `ilon live`: the speed of simulated time, its end, and refusals.

#![cfg(feature = "live")]

use crate::support;

use std::io::{BufRead, BufReader};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use support::{Folder, ended_with};
use tungstenite::{Message, WebSocket};

/// A live run, with a connection to its page.
struct Live(Child, WebSocket<TcpStream>);

impl Live {
    fn start(folder: &Folder, further: &[&str]) -> Self {
        let arguments = [&["live", "good.toml", "--port", "0"], further].concat();
        let mut child = folder
            .command(&arguments)
            .stdout(Stdio::piped())
            .spawn()
            .expect("it starts");
        let mut lines = BufReader::new(child.stdout.take().expect("it is piped")).lines();
        let line = lines.find_map(|line| {
            let line = line.expect("text");
            let place = line.split_once("http://")?.1.split_once('/')?.0;
            Some(place.to_owned())
        });
        let place = line.expect("it says where the page is");
        let stream = TcpStream::connect(&place).expect("it listens");
        let patience = Some(Duration::from_secs(60));
        stream.set_read_timeout(patience).expect("a socket");
        let (socket, _) = tungstenite::client(format!("ws://{place}/live"), stream)
            .expect("it speaks with a page of this machine");
        Self(child, socket)
    }

    /// The simulated time of the next frame, in seconds.
    fn time_s(&mut self) -> f32 {
        loop {
            if let Message::Binary(frame) = self.1.read().expect("a frame in time") {
                return f32::from_le_bytes([frame[0], frame[1], frame[2], frame[3]]);
            }
        }
    }

    fn say(&mut self, text: &str) {
        self.1.send(Message::text(text)).expect("it listens");
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

#[test]
fn time_goes_no_faster_than_asked() {
    let folder = Folder::new();
    let mut live = Live::start(&folder, &["--speed", "0.05"]);
    let (first_s, begun) = (live.time_s(), Instant::now());
    let mut last_s = first_s;
    while begun.elapsed() < Duration::from_secs(2) || last_s <= first_s {
        last_s = live.time_s();
    }
    // A step of 10 ms lasts 0.2 s here, and one may be due at either end.
    let most_s = 0.05 * begun.elapsed().as_secs_f32() + 0.02;
    assert!(last_s - first_s <= most_s, "{first_s} to {last_s} s");
}

#[test]
fn time_stands_until_somebody_lets_it_go_on() {
    let folder = Folder::new();
    let mut live = Live::start(&folder, &["--paused"]);
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_millis(500) {
        assert_eq!(live.time_s(), 0.0);
    }
    live.say(r#"{"paused": false}"#);
    while live.time_s() < 0.1 {}
}

#[test]
fn it_ends_when_its_time_is_up() {
    let folder = Folder::new();
    let begun = Instant::now();
    let output = folder.ilon(&["live", "good.toml", "--port", "0", "--seconds", "0.5"]);
    ended_with(0, &output);
    assert!(begun.elapsed() >= Duration::from_millis(500));
}

/// A recording that is still on at the end, by time or by Ctrl-C, is written like one that was
/// stopped, and its scenario runs.
#[cfg(unix)]
#[test]
fn a_recording_outlives_the_end_of_the_command() {
    let folder = Folder::new();
    let mut live = Live::start(&folder, &[]);
    live.say(r#"{"record": true}"#);
    let begun_s = live.time_s();
    while live.time_s() < begun_s + 0.3 {}
    let number = live.0.id().to_string();
    let sent = Command::new("kill").args(["-INT", &number]).status();
    assert!(sent.expect("a signal").success());
    live.0.wait().expect("it ends");
    let driven = "good_1_driven.toml";
    assert!(folder.path(driven).exists());
    ended_with(0, &folder.ilon(&["run", driven, "--out", "again"]));
}

#[test]
fn what_cannot_be_is_refused_before_it_starts() {
    let folder = Folder::new();
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("its number").port().to_string();
    for (option, value, said) in [
        ("--port", port.as_str(), "choose another port with --port"),
        ("--speed", "0", "give a number from 0.05 to 20"),
        ("--speed", "-1", "give a number from 0.05 to 20"),
        ("--speed", "100", "give a number from 0.05 to 20"),
        ("--speed", "nan", "give a number from 0.05 to 20"),
        ("--seconds", "0", "give a number above 0"),
        ("--seconds", "-3", "give a number above 0"),
    ] {
        let said_all = ended_with(2, &folder.ilon(&["live", "good.toml", option, value]));
        assert!(said_all.contains(said), "{option} {value}: {said_all}");
    }
}

#[cfg(feature = "foxglove")]
#[test]
fn viewers_of_foxglove_are_served_beside_the_page() {
    let folder = Folder::new();
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("its number").port();
    let viewers = format!("--foxglove={port}");
    let arguments = ["live", "good.toml", "--port", "0", &viewers];
    let said = ended_with(2, &folder.ilon(&arguments));
    assert!(
        said.contains("choose another port with --foxglove=PORT"),
        "{said}"
    );
    let output = folder.ilon(&[
        "live",
        "good.toml",
        "--port",
        "0",
        "--foxglove=0",
        "--seconds",
        "0.2",
    ]);
    let said = ended_with(0, &output);
    assert!(
        said.contains("open the connection ws://127.0.0.1:"),
        "{said}"
    );
}
