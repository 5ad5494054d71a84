//! ArduPilot's side of its JSON interface, as its readme describes it, played by a small client: frames out, JSON in.

use std::net::UdpSocket;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use ilon_live::ardupilot::{ArduPilot, Vehicle};
use ilon_sim::Scenario;
use serde_json::Value;

/// The factors of throttle, steering and lateral by which ArduPilot's Rover mixes, of its motors in their order.
const OMNI_X: &[[f64; 3]] = &[
    [1.0, -1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, 1.0, 1.0],
];
const OMNI_3: &[[f64; 3]] = &[[1.0, -1.0, -1.0], [0.0, -1.0, 1.0], [1.0, 1.0, 1.0]];

const RATE_HZ: u16 = 200;

fn scenario(robot: &str) -> Scenario {
    let text = format!(
        "robot.file = \"{robot}\"\ntwist = {{}}\nguidance.wheel_rate_limit_rad_s = 10\n[run]\nduration_s = 1\nphysics_dt_s = 0.0025"
    );
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    Scenario::from_toml(&text, "rover", robots).unwrap()
}

/// SITL as far as the physics sees it, and the server that it talks to.
struct Sitl {
    socket: UdpSocket,
    frame: u32,
    ended: Arc<AtomicBool>,
    said: Arc<Mutex<Vec<String>>>,
    server: Option<std::thread::JoinHandle<()>>,
}

impl Sitl {
    fn start(robot: &str) -> Self {
        let mut vehicle = Vehicle::new(&scenario(robot)).unwrap();
        let server = ArduPilot::start(0).unwrap();
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.connect(("127.0.0.1", server.port())).unwrap();
        socket
            .set_read_timeout(Some(Duration::from_secs(20)))
            .unwrap();
        let ended = Arc::new(AtomicBool::new(false));
        let said = Arc::new(Mutex::new(Vec::new()));
        let (ends, says) = (Arc::clone(&ended), Arc::clone(&said));
        let server = std::thread::spawn(move || {
            let go_on = || !ends.load(Ordering::Relaxed);
            let say = |note: &str| says.lock().unwrap().push(note.to_owned());
            server.serve(&mut vehicle, go_on, say).unwrap();
        });
        Self {
            socket,
            frame: 0,
            ended,
            said,
            server: Some(server),
        }
    }

    fn send(&self, magic: u16, frame: u32, pwm_us: &[u16]) {
        let mut bytes = magic.to_le_bytes().to_vec();
        bytes.extend(RATE_HZ.to_le_bytes());
        bytes.extend(frame.to_le_bytes());
        bytes.extend(pwm_us.iter().flat_map(|pulse| pulse.to_le_bytes()));
        self.socket.send(&bytes).unwrap();
    }

    fn receive(&self) -> Value {
        let mut bytes = [0; 2048];
        let length = self.socket.recv(&mut bytes).expect("an answer");
        let text = std::str::from_utf8(&bytes[..length]).unwrap();
        // ArduPilot takes what stands between two ends of lines.
        let line = text
            .strip_prefix('\n')
            .and_then(|text| text.strip_suffix('\n'));
        serde_json::from_str(line.expect("a line")).unwrap()
    }

    /// A frame of ArduPilot's mix, from -1 to 1, and its answer.
    fn drive(&mut self, factors: &[[f64; 3]], way: [f64; 3]) -> Value {
        let mix = |motor: &[f64; 3]| motor.iter().zip(way).map(|(f, w)| f * w).sum::<f64>();
        let mut pwm_us = [1500_u16; 16];
        for (pulse, motor) in pwm_us.iter_mut().zip(factors) {
            *pulse = (1500.0 + 400.0 * mix(motor)).round() as u16;
        }
        self.frame += 1;
        self.send(18458, self.frame, &pwm_us);
        self.receive()
    }
}

impl Drop for Sitl {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(server) = self.server.take() {
            let ended = server.join();
            assert!(ended.is_ok() || std::thread::panicking());
        }
    }
}

fn triple(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|axis| value[axis].as_f64().unwrap())
}

#[test]
fn a_robot_at_rest_feels_gravity_and_time_goes_on_in_lock_step() {
    let mut sitl = Sitl::start("mecanum4.urdf");
    for frame in 1..=20 {
        let state = sitl.drive(OMNI_X, [0.0; 3]);
        let time_s = state["timestamp"].as_f64().unwrap();
        assert!(
            (time_s - f64::from(frame) / f64::from(RATE_HZ)).abs() < 1e-9,
            "{time_s}"
        );
        let feels = triple(&state["imu"]["accel_body"]);
        // Down is positive: who stands on the ground is pushed up. It settles on its springy contacts by micrometres at first.
        assert!(
            (feels[2] + 9.81).abs() < 0.5 && feels[0].abs() < 0.1,
            "{feels:?}"
        );
        for name in ["position", "velocity", "attitude"] {
            let numbers = triple(&state[name]);
            assert!(
                numbers.iter().all(|number| number.abs() < 1e-3),
                "{name} {numbers:?}"
            );
        }
    }
}

/// In ArduPilot's frames: throttle goes north, lateral east, steering turns from north to east.
#[test]
fn each_way_of_the_mix_goes_where_ardupilot_means() {
    for (robot, factors) in [("mecanum4.urdf", OMNI_X), ("robotino.toml", OMNI_3)] {
        for (way, axis) in [
            ([0.3, 0.0, 0.0], 0),
            ([0.0, 0.0, 0.3], 1),
            ([0.0, 0.3, 0.0], 2),
        ] {
            let mut sitl = Sitl::start(robot);
            let mut state = Value::Null;
            (0..150).for_each(|_| state = sitl.drive(factors, way));
            let [north, east, _] = triple(&state["position"]);
            let yaw = triple(&state["attitude"])[2];
            let went = [north, east, yaw];
            assert!(went[axis] > 0.05, "{robot} by {way:?}: {went:?}");
            // Three wheels at 120 deg need twice as much of the back one for lateral alone: ArduPilot's mix turns them too.
            if factors == OMNI_3 && axis == 1 {
                continue;
            }
            // Less than a fifth goes elsewhere by slip.
            for other in (0..3).filter(|other| *other != axis) {
                let is_small = went[other].abs() < 0.2 * went[axis];
                assert!(is_small, "{robot} by {way:?}: {went:?}");
            }
            let gyro = triple(&state["imu"]["gyro"]);
            let turns = gyro[2] > 0.05;
            assert_eq!(turns, axis == 2, "{robot} by {way:?}: {gyro:?}");
        }
    }
}

/// What an inertial navigation makes of the IMU is the velocity that is sent beside it: attitude, specific force and gravity agree.
#[test]
fn imu_attitude_and_velocity_agree() {
    let mut sitl = Sitl::start("mecanum4.urdf");
    let mut reckoned: Option<[f64; 3]> = None;
    let mut worst_m_s: f64 = 0.0;
    for frame in 0..200 {
        let way = if frame < 100 {
            [0.4, 0.2, 0.0]
        } else {
            [0.0, -0.2, 0.4]
        };
        let state = sitl.drive(OMNI_X, way);
        let velocity = triple(&state["velocity"]);
        let Some(reckoned) = &mut reckoned else {
            reckoned = Some(velocity);
            continue;
        };
        let [roll, pitch, yaw] = triple(&state["attitude"]);
        let f = triple(&state["imu"]["accel_body"]);
        let (sr, cr, sp, cp) = (roll.sin(), roll.cos(), pitch.sin(), pitch.cos());
        // From forward, right, down to north, east, down: roll, then pitch, then yaw.
        let level = [
            cp * f[0] + sp * sr * f[1] + sp * cr * f[2],
            cr * f[1] - sr * f[2],
            -sp * f[0] + cp * sr * f[1] + cp * cr * f[2],
        ];
        let (sy, cy) = (yaw.sin(), yaw.cos());
        let ned = [
            cy * level[0] - sy * level[1],
            sy * level[0] + cy * level[1],
            level[2] + 9.81,
        ];
        for axis in 0..3 {
            reckoned[axis] += ned[axis] / f64::from(RATE_HZ);
            worst_m_s = worst_m_s.max((reckoned[axis] - velocity[axis]).abs());
        }
    }
    // Nine digits after the point, 200 times, and the scenario's gravity, which is 9.81.
    assert!(worst_m_s < 1e-6, "{worst_m_s} m/s off");
}

#[test]
fn a_frame_that_comes_twice_is_answered_alike_and_a_restart_begins_anew() {
    let mut sitl = Sitl::start("mecanum4.urdf");
    let first = sitl.drive(OMNI_X, [0.5, 0.0, 0.0]);
    let mut moved = Value::Null;
    (0..50).for_each(|_| moved = sitl.drive(OMNI_X, [0.5, 0.0, 0.0]));
    sitl.frame -= 1;
    assert_eq!(sitl.drive(OMNI_X, [0.5, 0.0, 0.0]), moved, "the same frame");
    // Frames that were lost are no reason to start again.
    sitl.frame += 10;
    let on = sitl.drive(OMNI_X, [0.5, 0.0, 0.0]);
    assert!(on["timestamp"].as_f64() > moved["timestamp"].as_f64());
    sitl.frame = 0;
    assert_eq!(
        sitl.drive(OMNI_X, [0.5, 0.0, 0.0]),
        first,
        "to the bit as the first time"
    );
    assert!(
        sitl.said
            .lock()
            .unwrap()
            .iter()
            .any(|said| said.contains("started again"))
    );
}

#[test]
fn what_is_no_frame_is_left_alone_and_32_outputs_are_taken() {
    let mut sitl = Sitl::start("mecanum4.urdf");
    for _ in 0..3 {
        sitl.socket.send(b"hello").unwrap();
        sitl.socket.send(&[]).unwrap();
        sitl.send(18459, 1, &[1500; 16]);
        sitl.send(18458, 1, &[1500; 15]);
    }
    sitl.send(29569, 1, &[1500; 32]);
    let answer = sitl.receive();
    assert_eq!(answer["timestamp"].as_f64(), Some(1.0 / f64::from(RATE_HZ)));
    assert_eq!(sitl.said.lock().unwrap().len(), 1, "said once");
    sitl.frame = 1;
    // Pulses of nothing and beyond all bounds: it stands, and then turns as fast as it may.
    sitl.send(18458, 2, &[0; 16]);
    assert!(
        triple(&sitl.receive()["velocity"])
            .iter()
            .all(|v| v.abs() < 1e-3)
    );
    sitl.send(18458, 3, &[u16::MAX; 16]);
    sitl.receive();
}

#[test]
fn a_robot_that_no_frame_fits_is_refused_in_words() {
    let refused = |scenario: &Scenario| Vehicle::new(scenario).map(|_| ()).unwrap_err().to_string();
    assert!(refused(&scenario("mecanum6.urdf")).contains("6 wheels"));
    let vehicle = Vehicle::new(&scenario("mecanum4.urdf")).unwrap();
    let wheels: Vec<&str> = vehicle.wheels().collect();
    // ArduPilot's OmniX counts front right, rear right, rear left, front left.
    assert_eq!(
        wheels,
        ["front_right", "rear_right", "rear_left", "front_left"]
    );
    assert_eq!(vehicle.mixer().frame.frame_type, 2);
}
