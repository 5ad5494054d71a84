//! What others send to a live run changes it or is refused with a message: messages of the page,
//! frames of ArduPilot, messages of ROS 2, and any bytes to the server.
#![no_main]

use std::cell::RefCell;
use std::fmt::Debug;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::Duration;

use ilon::Scenario;
use ilon_live::ardupilot::{Packet, Vehicle};
use ilon_live::{Controls, Mailbox, Server, Session};
use ilon_messages::{Message, geometry_msgs, nav_msgs, sensor_msgs, std_msgs, trajectory_msgs};
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

/// A live run, a robot driven by ArduPilot, and a server.
struct Sockets {
    session: Session,
    vehicle: Vehicle,
    server: Server,
    controls: Controls,
}

thread_local! {
    static SOCKETS: RefCell<Sockets> = RefCell::new(Sockets::new());
}

impl Sockets {
    fn new() -> Self {
        let text = "robot.file = \"../fuzz/seeds/urdf/omni.urdf\"\ntwist.vx_m_s = 0.1\nrun.duration_s = 1\nguidance.wheel_rate_limit_rad_s = 20\n";
        let scenario = Scenario::from_toml(
            text,
            "live",
            concat!(env!("CARGO_MANIFEST_DIR"), "/../assets"),
        )
        .expect("the scenario is a good one");
        let session = Session::new(&scenario).expect("the scenario is a good one");
        let server = Server::start(0, &session, &Mailbox::default()).expect("a port is free");
        Self {
            vehicle: Vehicle::new(&scenario).expect("ArduPilot knows such a robot"),
            session,
            server,
            controls: Controls::default(),
        }
    }
}

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    ilon_fuzz::mutate(data, size, max_size, seed, b'\n')
});

fuzz_target!(|bytes: &[u8]| {
    SOCKETS.with_borrow_mut(|sockets| match bytes {
        [0x1a, 0x48, ..] | [0x81, 0x73, ..] => frames(&mut sockets.vehicle, bytes),
        [0, 0 | 1, ..] => messages(bytes),
        [b'G', b'E', b'T', ..] => request(&sockets.server, bytes),
        _ => commands(sockets, &String::from_utf8_lossy(bytes)),
    });
});

/// Each line is a message of a page; after it the run goes on.
fn commands(sockets: &mut Sockets, text: &str) {
    for line in text.lines().take(8) {
        if let Some(note) = sockets.controls.take(line) {
            assert!(!note.is_empty());
        }
        if let Err(error) = sockets.session.advance(&sockets.controls) {
            assert!(!error.to_string().is_empty());
        }
        assert!(
            sockets
                .session
                .figures(&sockets.controls)
                .real
                .iter()
                .all(|part| part.is_finite())
        );
    }
}

/// Frames of ArduPilot, one after the other: the answers have only finite numbers.
fn frames(vehicle: &mut Vehicle, bytes: &[u8]) {
    let length = if bytes[0] == 0x1a { 40 } else { 72 };
    for datagram in bytes.chunks(length).take(8) {
        let Some(packet) = Packet::read(datagram) else {
            continue;
        };
        match vehicle.answer(&packet) {
            Ok(answer) => assert!(!answer.contains("NaN") && !answer.contains("inf")),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}

/// A message of ROS 2 as each type that is read: what is decoded can be encoded and read again.
fn messages(bytes: &[u8]) {
    fn read<M: Message + Debug>(bytes: &[u8]) {
        match M::decode(bytes) {
            Ok(message) => {
                let encoded = message
                    .encode()
                    .expect("a string without NUL can be written");
                let again = M::decode(&encoded).expect("what was written can be read");
                // As text: NaN is unequal to itself.
                assert_eq!(format!("{message:?}"), format!("{again:?}"));
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
    read::<geometry_msgs::Twist>(bytes);
    read::<geometry_msgs::TwistStamped>(bytes);
    read::<geometry_msgs::PoseStamped>(bytes);
    read::<nav_msgs::Odometry>(bytes);
    read::<nav_msgs::Path>(bytes);
    read::<sensor_msgs::JointState>(bytes);
    read::<std_msgs::Float64MultiArray>(bytes);
    read::<trajectory_msgs::JointTrajectory>(bytes);
}

/// Any bytes to the server; it goes on to answer others.
fn request(server: &Server, bytes: &[u8]) {
    let address = server.url().replace("http://", "").replace('/', "");
    let text = String::from_utf8_lossy(bytes).replace("HOST", &address);
    let exchange = |bytes: &[u8], wait_ms: u64| -> std::io::Result<Vec<u8>> {
        let mut stream = TcpStream::connect(&address)?;
        stream.set_read_timeout(Some(Duration::from_millis(wait_ms)))?;
        stream.write_all(bytes)?;
        stream.shutdown(Shutdown::Write)?;
        let mut answer = vec![0; 16];
        let read = stream.read(&mut answer)?;
        answer.truncate(read);
        Ok(answer)
    };
    // A reset connection is a valid response.
    let _ = exchange(text.as_bytes(), 20);
    let page = format!("GET / HTTP/1.1\r\nHost: {address}\r\n\r\n");
    // On a busy machine the server's threads wait for their turn.
    let is_served =
        || exchange(page.as_bytes(), 1000).is_ok_and(|answer| answer.starts_with(b"HTTP/1.1 200"));
    assert!((0..60).any(|_| is_served()), "nobody is served any more");
}
