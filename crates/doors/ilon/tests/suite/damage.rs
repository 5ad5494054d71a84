//! Files and packets, damaged at random: each is accepted or refused with a message, within a time
//! limit, and nothing panics. The damage is the same in every run; `ILON_DAMAGE_ROUNDS=100000` runs
//! more of it.

use std::path::Path;
use std::time::{Duration, Instant};

use ilon::files::FileAccess;
use ilon::robot::Robot;
use ilon::simulate::Simulation;
use ilon::{Error, Scenario};
use ilon_formats::{LoadOptions, LoadRobot};

use crate::support::{Folder, ended_with};

/// Number of damaged versions of each file.
fn rounds(usual: usize) -> usize {
    std::env::var("ILON_DAMAGE_ROUNDS").map_or(usual, |r| r.parse().expect("a number of rounds"))
}

/// A linear congruential generator (Knuth's MMIX constants).
struct Dice(u64);

impl Dice {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % end.max(1)
    }

    /// A place to change: half of the time a whole number, so that the damaged file is still a file
    /// of its kind.
    fn place(&mut self, bytes: &[u8]) -> (usize, usize) {
        let is_of_number = |at: usize| {
            bytes
                .get(at)
                .is_some_and(|b| b.is_ascii_digit() || *b == b'.')
        };
        let numbers: Vec<usize> = (0..bytes.len())
            .filter(|&at| is_of_number(at) && (at == 0 || !is_of_number(at - 1)))
            .collect();
        if self.below(2) == 0 && !numbers.is_empty() {
            let from = numbers[self.below(numbers.len())];
            let to = (from..).find(|&at| !is_of_number(at));
            return (from, to.unwrap_or(bytes.len()));
        }
        let from = self.below(bytes.len());
        (from, (from + self.below(12)).min(bytes.len()))
    }

    /// Bytes with one or two places changed: cut out, doubled, or replaced by a number or a word
    /// that often causes errors, or by any byte.
    fn damaged(&mut self, whole: &[u8]) -> Vec<u8> {
        const SPICES: [&[u8]; 14] = [
            b"0",
            b"-1",
            b"1e308",
            b"nan",
            b"inf",
            b"1e-320",
            b"1e9",
            b"<",
            b"\"",
            b"",
            b" ",
            b"\xff\xff\xff\xff",
            b"\0\0\0\x80",
            b"-9223372036854775808",
        ];
        let mut bytes = whole.to_vec();
        for _ in 0..=self.below(2) {
            let (from, to) = self.place(&bytes);
            let spice = match self.below(4) {
                0 => bytes[from..to].repeat(2),
                1 => vec![self.below(256) as u8],
                _ => SPICES[self.below(SPICES.len())].to_vec(),
            };
            bytes.splice(from..to, spice);
        }
        if self.below(20) == 0 {
            bytes.truncate(self.below(bytes.len()));
        }
        bytes
    }
}

/// Damages a file repeatedly and uses the results: refusals have a message, and nothing exceeds the
/// time limit.
fn damage(seed: &[u8], usual: usize, use_it: impl Fn(&[u8]) -> Result<(), String>) {
    let mut dice = Dice(1973);
    let mut taken = usize::from(use_it(seed).is_ok());
    assert_eq!(taken, 1, "{:?}", use_it(seed));
    for _ in 0..rounds(usual) {
        let bytes = dice.damaged(seed);
        let begun = Instant::now();
        match use_it(&bytes) {
            Ok(()) => taken += 1,
            Err(words) => assert!(!words.is_empty()),
        }
        assert!(
            begun.elapsed() < Duration::from_secs(20),
            "{}",
            String::from_utf8_lossy(&bytes)
        );
    }
    assert!(taken > 1, "all damage was refused");
}

/// A box of 0.1 m about the origin, as `v` and `f` of OBJ, and as STL in text.
fn box_of(format: &str) -> String {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 0.05 } else { -0.05 });
    let faces = [
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
    ];
    let line = |of: [f64; 3]| format!("{} {} {}", of[0], of[1], of[2]);
    if format == "obj" {
        let points: String = (0..8).map(|k| format!("v {}\n", line(corner(k)))).collect();
        let faces = faces.map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
        return points + &faces.concat();
    }
    let facets = faces.map(|of| {
        let points: String = of.map(|k| format!("vertex {}\n", line(corner(k)))).concat();
        format!("facet normal 0 0 0\nouter loop\n{points}endloop\nendfacet\n")
    });
    format!("solid box\n{}endsolid box\n", facets.concat())
}

fn said(result: Result<(), Error>) -> Result<(), String> {
    result.map_err(|error| error.to_string())
}

/// Takes several steps of a scenario in a folder.
fn stepped(text: &str, folder: &Path) -> Result<(), Error> {
    let scenario = Scenario::from_toml(text, "damaged", folder)?;
    let mut simulation = Simulation::new(&scenario)?;
    for _ in 0..3 {
        simulation.step();
    }
    Ok(())
}

#[test]
fn meshes_and_maps() {
    let folder = Folder::new();
    for format in ["obj", "stl"] {
        let file = format!("mesh.{format}");
        let urdf = folder.read("robot.urdf");
        let end = "</collision>";
        let mesh = format!(
            "<collision><origin xyz=\"0 0 0.3\"/><geometry><mesh filename=\"{file}\"/></geometry></collision>"
        );
        let at = urdf.find(end).expect("a collision") + end.len();
        folder.write(
            "with.urdf",
            &format!("{}{mesh}{}", &urdf[..at], &urdf[at..]),
        );
        damage(box_of(format).as_bytes(), 40, |bytes| {
            std::fs::write(folder.path(&file), bytes).expect("a file");
            let loaded = Robot::load(folder.path("with.urdf"));
            loaded.map(drop).map_err(|error| error.to_string())
        });
        let map = format!(
            "robot.file = \"robot.urdf\"\ntwist.vx_m_s = 0.1\nrun.duration_s = 1\nworld.floor.height_map = {{ file = \"{file}\", cell_m = 0.02 }}\n"
        );
        let flat = box_of(format).replace("0.05", "2.5");
        damage(flat.as_bytes(), 15, |bytes| {
            std::fs::write(folder.path(&file), bytes).expect("a file");
            said(stepped(&map, folder.path("").as_path()))
        });
    }
}

/// Four cylinders below a box, which the options make mecanum wheels.
fn robot_in(format: &str) -> String {
    let mut wheels = String::new();
    for (name, x, y) in [
        ("fl", 0.15, 0.16),
        ("fr", 0.15, -0.16),
        ("rl", -0.15, 0.16),
        ("rr", -0.15, -0.16),
    ] {
        wheels += &match format {
            "mjcf" => format!(
                "<body name=\"{name}\" pos=\"{x} {y} 0.05\"><joint name=\"{name}_wheel\" type=\"hinge\" axis=\"0 1 0\"/>\
                 <geom type=\"cylinder\" size=\"0.05 0.02\" euler=\"90 0 0\" mass=\"0.5\"/></body>\n"
            ),
            _ => format!(
                "<link name=\"{name}\"><pose>{x} {y} 0.05 0 0 0</pose><inertial><mass>0.5</mass><inertia><ixx>0.0004</ixx><iyy>0.0006</iyy>\
                 <izz>0.0004</izz></inertia></inertial><collision name=\"c\"><pose>0 0 0 1.5707963 0 0</pose><geometry><cylinder><radius>0.05</radius>\
                 <length>0.04</length></cylinder></geometry></collision></link>\n<joint name=\"{name}_wheel\" type=\"revolute\"><parent>base</parent>\
                 <child>{name}</child><axis><xyz>0 1 0</xyz></axis></joint>\n"
            ),
        };
    }
    match format {
        "mjcf" => format!(
            "<mujoco model=\"four\">\n<worldbody>\n<body name=\"base\"><freejoint/>\n<geom type=\"box\" pos=\"0 0 0.1\" size=\"0.2 0.1 0.02\" mass=\"8\"/>\n\
             {wheels}</body>\n</worldbody>\n</mujoco>\n"
        ),
        _ => format!(
            "<sdf version=\"1.9\">\n<model name=\"four\">\n<link name=\"base\"><pose>0 0 0.1 0 0 0</pose><inertial><mass>8</mass><inertia><ixx>0.03</ixx>\
             <iyy>0.1</iyy><izz>0.13</izz></inertia></inertial><collision name=\"c\"><geometry><box><size>0.4 0.2 0.04</size></box></geometry></collision></link>\n\
             {wheels}</model>\n</sdf>\n"
        ),
    }
}

#[test]
fn robots_in_mjcf_and_sdf() {
    let mut options = LoadOptions::default();
    options.wheels = Some(ilon_formats::WheelOptions::new(
        6,
        ilon_formats::Handedness::XDeg(45.0),
    ));
    for (format, name) in [("mjcf", "robot.xml"), ("sdf", "robot.sdf")] {
        damage(robot_in(format).as_bytes(), 60, |bytes| {
            let mut options = options.clone();
            options.files = FileAccess::of_memory([(name.into(), bytes.to_vec())]);
            let loaded = Robot::load_with(name, &options).map_err(|error| error.to_string())?;
            let wheels = &loaded.robot.wheels;
            assert!(
                wheels
                    .iter()
                    .all(|wheel| wheel.radius_m.is_finite() && wheel.radius_m > 0.0)
            );
            Ok(())
        });
    }
}

#[test]
fn bags() {
    let folder = Folder::new();
    ended_with(
        0,
        &folder.ilon(&[
            "run",
            "good.toml",
            "--mcap",
            "--no-report",
            "--out",
            "made",
            "--set",
            "run.duration_s=0.3",
        ]),
    );
    let bag = std::fs::read(folder.path("made/bag/bag_0.mcap")).expect("a bag");
    let text = "robot.file = \"robot.urdf\"\nplayback = { file = \"played.mcap\", drives = \"twist\", topic = \"/cmd_vel\" }\n";
    let play = |bytes: &[u8]| {
        std::fs::write(folder.path("played.mcap"), bytes).expect("a file");
        ilon_messages::bag::read(
            &folder.path("played.mcap"),
            &FileAccess::anywhere(),
            &mut |_| true,
        )
        .map_err(|error| error.to_string())?;
        // Only the log is damaged.
        let _ = stepped(text, folder.path("").as_path());
        Ok(())
    };
    damage(&bag, 60, play);
}

/// Requests, frames and packets; the server answers other clients meanwhile.
#[cfg(feature = "live")]
#[test]
fn sockets() {
    use std::io::{Read, Write};
    use std::net::TcpStream;

    use ilon_live::ardupilot::Packet;
    use ilon_live::{Controls, Mailbox, Server, Session};

    let folder = Folder::new();
    let scenario = Scenario::load(folder.path("good.toml")).expect("a scenario");
    let mut session = Session::new(&scenario).expect("a session");
    let server = Server::start(0, &session, &Mailbox::default()).expect("a server");
    let address = server.url().replace("http://", "").replace('/', "");
    let exchanged = |bytes: &[u8]| -> std::io::Result<Vec<u8>> {
        let mut stream = TcpStream::connect(&address)?;
        stream.set_read_timeout(Some(Duration::from_millis(30)))?;
        stream.write_all(bytes)?;
        stream.shutdown(std::net::Shutdown::Write)?;
        let mut answer = vec![0; 64];
        let read = stream.read(&mut answer)?;
        answer.truncate(read);
        Ok(answer)
    };
    let page = format!("GET / HTTP/1.1\r\nHost: {address}\r\n\r\n");
    let is_served =
        || exchanged(page.as_bytes()).is_ok_and(|answer| answer.starts_with(b"HTTP/1.1 200"));
    let doubled = format!("GET / HTTP/1.1\r\nHost: evil.example\r\nHost: {address}\r\n\r\n");
    let answer = exchanged(doubled.as_bytes()).expect("an answer");
    assert!(
        answer.starts_with(b"HTTP/1.1 400"),
        "{}",
        String::from_utf8_lossy(&answer)
    );
    let shake = format!(
        "GET /live HTTP/1.1\r\nHost: {address}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n\x01\x05hello{{\"twist\": [0.1, 0, 0]}}"
    );
    let mut dice = Dice(1973);
    let mut controls = Controls::default();
    let packet: Vec<u8> = [
        &[0x1a, 0x48, 0x90, 0x01, 4, 3, 2, 1][..],
        &[0xdc, 0x05].repeat(16),
    ]
    .concat();
    for round in 0..rounds(40) {
        let seed = if round % 2 == 0 { &page } else { &shake };
        // A reset connection is a valid response.
        let _ = exchanged(&dice.damaged(seed.as_bytes()));
        let said = dice
            .damaged(b"{\"twist\": [0.1, 0, 0.2], \"friction\": 0.5, \"priority\": \"heading\"}");
        controls.take(&String::from_utf8_lossy(&said));
        session.advance(&controls).expect("the plant goes on");
        let _ = Packet::read(&dice.damaged(&packet));
        if round % 10 == 0 {
            assert!(
                (0..50).any(|_| is_served()),
                "nobody is served after round {round}"
            );
        }
    }
    assert!(is_served());
}
