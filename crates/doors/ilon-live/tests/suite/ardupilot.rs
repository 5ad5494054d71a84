//! A small client plays ArduPilot's side of its JSON interface, as its readme describes it: frames
//! out, JSON in.

use std::net::UdpSocket;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use ilon_live::ardupilot::{ArduPilot, Vehicle};
use ilon_sim::Scenario;
use serde_json::Value;

/// The factors of throttle, steering and lateral in ArduPilot Rover's mixer, for its motors in
/// order.
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

/// A stand-in for SITL, with the server that it talks to.
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
        // ArduPilot takes the text between two line ends.
        let line = text
            .strip_prefix('\n')
            .and_then(|text| text.strip_suffix('\n'));
        serde_json::from_str(line.expect("a line")).unwrap()
    }

    /// Sends a frame of ArduPilot's mixer, from -1 to 1, and returns the reply.
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
        // Down is positive: the ground pushes a standing robot up. At first it settles on its
        // elastic contacts by micrometres.
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
            // Three wheels at 120 deg need twice as much from the back one for lateral alone:
            // ArduPilot's mixer turns them too.
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

/// Inertial navigation with the IMU gives the velocity that is sent with it: attitude, specific
/// force and gravity agree.
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
    // Nine decimals, 200 times, and the scenario's gravity, which is 9.81.
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
    // Lost frames do not restart the simulation.
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
    // Pulses of zero and beyond all bounds: it stands, and then turns at its largest rate.
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
    let refused = |robot: &str| match Vehicle::new(&scenario(robot)) {
        Ok(vehicle) => panic!("{robot} is taken as {:?}", vehicle.mixer()),
        Err(error) => error.to_string(),
    };
    assert!(refused("mecanum6.urdf").contains("6 wheels"));
    // As many wheels as a frame has motors; but tyres and swivelling wheels do not follow lateral,
    // and of the last one no wheel points ahead or back: throttle would move it 30 degrees off.
    for (robot, wheels) in [
        ("skid4.urdf", 4),
        ("swerve4.urdf", 4),
        ("omni4_steered.urdf", 4),
        ("tricycle.urdf", 3),
        ("volksbot.urdf", 3),
    ] {
        let words = refused(robot);
        assert!(
            words.contains(&format!("{wheels} wheels")),
            "{robot}: {words}"
        );
    }
    let vehicle = Vehicle::new(&scenario("mecanum4.urdf")).unwrap();
    let wheels: Vec<&str> = vehicle.wheels().collect();
    // ArduPilot's OmniX numbers front right, rear right, rear left, front left.
    assert_eq!(
        wheels,
        ["front_right", "rear_right", "rear_left", "front_left"]
    );
    assert_eq!(vehicle.mixer().frame.frame_type, 2);
}

/// Outputs as in `AP_MotorsUGV`. Rover begins with steering on output 1 and throttle on 3. A motor
/// without an output gets the output of its number, if that has no function.
struct Outputs {
    /// For each output: function, and the smallest, middle and largest pulse in microseconds.
    channels: [[f64; 4]; 16],
}

impl Outputs {
    /// With the defaults of Rover and its SITL, and a file of parameters.
    fn of(parameters: &str) -> Self {
        let mut channels = [[0.0, 1100.0, 1500.0, 1900.0]; 16];
        (channels[0], channels[2]) = (
            [26.0, 1000.0, 1500.0, 2000.0],
            [70.0, 1000.0, 1500.0, 2000.0],
        );
        for line in parameters.lines().filter(|line| line.starts_with("SERVO")) {
            let (key, value) = line.split_once(' ').expect("a key and a value");
            let (number, of) = key["SERVO".len()..].split_once('_').expect("an output");
            let channel = &mut channels[number.parse::<usize>().unwrap() - 1];
            let place = ["FUNCTION", "MIN", "TRIM", "MAX"]
                .iter()
                .position(|it| *it == of);
            let value = value.parse().unwrap();
            match place {
                Some(place) => channel[place] = value,
                None => assert_eq!((of, value), ("REVERSED", 0.0)),
            }
        }
        for motor in 0..4 {
            let function = 33.0 + motor as f64;
            let is_there = channels.iter().any(|channel| channel[0] == function);
            if !is_there && channels[motor][0] == 0.0 {
                channels[motor][0] = function;
            }
        }
        Self { channels }
    }

    /// The pulses for motor commands from -1 to 1, with a throttle and no steering.
    fn pulses(&self, motors: &[f64], throttle: f64) -> [u16; 16] {
        self.channels.map(|[function, least, middle, most]| {
            let motor = (function - 33.0).max(-1.0) as isize;
            let share = match usize::try_from(motor).ok().and_then(|it| motors.get(it)) {
                Some(share) if function >= 33.0 => *share,
                _ if function == 70.0 => throttle,
                _ => 0.0,
            };
            let span = if share < 0.0 {
                middle - least
            } else {
                most - middle
            };
            (middle + share * span).round() as u16
        })
    }
}

/// Three seconds of a quarter of throttle: with the file of parameters the robot goes straight
/// ahead at a quarter of 10 rad/s on 50 mm; with Rover's own parameters two of its motors have no
/// output.
#[test]
fn the_parameters_make_rover_drive_straight() {
    let drive = |parameters: &str| {
        let sitl = Sitl::start("mecanum4.urdf");
        let outputs = Outputs::of(parameters);
        let mut state = Value::Null;
        for frame in 1..=3 * u32::from(RATE_HZ) {
            let pulses = outputs.pulses(&[0.25; 4], 0.25);
            sitl.send(18458, frame, &pulses);
            state = sitl.receive();
        }
        (triple(&state["position"]), triple(&state["attitude"])[2])
    };
    let parameters = Vehicle::new(&scenario("mecanum4.urdf"))
        .unwrap()
        .parameters();
    assert!(parameters.contains("FRAME_TYPE 2\n"), "{parameters}");
    let ([north_m, east_m, _], yaw_rad) = drive(&parameters);
    // 2.5 rad/s on 50 mm for 3 s, less several hundredths for the start.
    assert!((north_m - 0.375).abs() < 0.01, "{north_m}");
    assert!(
        east_m.abs() < 1e-3 && yaw_rad.abs() < 1e-3,
        "{east_m} {yaw_rad}"
    );
    let ([north_m, ..], yaw_rad) = drive("");
    assert!(north_m < 0.3 || yaw_rad.abs() > 0.1, "{north_m} {yaw_rad}");
}

/// Packets of another process during a drive have no effect.
#[test]
fn who_drives_is_not_disturbed_by_another() {
    let mut sitl = Sitl::start("mecanum4.urdf");
    for _ in 0..5 {
        sitl.drive(OMNI_X, [0.2, 0.0, 0.0]);
    }
    let other = UdpSocket::bind("127.0.0.1:0").unwrap();
    let mut bytes = 18458_u16.to_le_bytes().to_vec();
    bytes.extend(RATE_HZ.to_le_bytes());
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend([1500_u16; 16].iter().flat_map(|pulse| pulse.to_le_bytes()));
    let server = sitl.socket.peer_addr().unwrap();
    other.send_to(&bytes, server).unwrap();
    let state = sitl.drive(OMNI_X, [0.2, 0.0, 0.0]);
    let expected_s = 6.0 / f64::from(RATE_HZ);
    assert!(
        (state["timestamp"].as_f64().unwrap() - expected_s).abs() < 1e-9,
        "{state}"
    );
    let said = sitl.said.lock().unwrap();
    assert!(
        said.iter().any(|note| note.contains("another drives")),
        "{said:?}"
    );
}
