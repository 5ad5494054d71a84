//! Physics backend for ArduPilot's SITL: Rover with the frames Omni3, OmniX (four mecanum or omni
//! wheels) and Omni3Mecanum, through the JSON interface over UDP.
//!
//! Both run in lock step. Each frame of servo outputs is answered with the robot's state after one
//! more step; without frames time stands. A repeated frame, because SITL missed the answer, gets
//! the same answer; a frame counter that restarts, because SITL was restarted, puts the robot back
//! to its start.
//!
//! ArduPilot's frames are north, east, down and forward, right, down. The world's x axis is north.

mod mixer;
mod packet;

use std::fmt::Write;
use std::io::ErrorKind;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use ilon_sim::simulate::WheelCommand;
use ilon_sim::{Error, Plant, Scenario};

use crate::LiveError;
pub use mixer::{Frame, Mixer};
pub use packet::Packet;

/// The pulse of a wheel at rest, and the additional pulse at full rate, in microseconds:
/// ArduPilot's SERVO_TRIM, and SERVO_MAX less SERVO_TRIM.
const PULSE_US: (f64, f64) = (1500.0, 400.0);

/// ArduPilot's function code of the first motor's output, `k_motor1`.
const FIRST_MOTOR: f64 = 33.0;

/// A client keeps control until this long after its last frame.
const KEEPS: Duration = Duration::from_secs(2);

/// The longest single step, in seconds, a limit of ArduPilot.
const MOST_S: f64 = 0.05;

/// Time to wait for a frame before checking whether to continue.
const LOOK: Duration = Duration::from_millis(100);

/// A robot driven by ArduPilot.
pub struct Vehicle {
    plant: Plant,
    mixer: Mixer,
    /// Wheel rate of a full pulse, in rad/s.
    most_rad_s: f64,
    start_height_m: f64,
    rates_rad_s: Vec<f64>,
    /// The last frame number and its answer.
    last: Option<(u32, String)>,
}

impl Vehicle {
    /// Places the scenario's robot in its world.
    ///
    /// # Errors
    /// If the scenario is invalid, no frame of ArduPilot fits the robot, or nothing limits its
    /// wheel rates.
    pub fn new(scenario: &Scenario) -> Result<Self, LiveError> {
        let plant = Plant::of_scenario(scenario)?;
        let (robot, wheels) = (&plant.robot().name, plant.robot().wheels.len());
        let mixer = Mixer::of(plant.kinematics()).ok_or_else(|| {
            Error::invalid(
                format!("no frame of ArduPilot's Rover fits the {wheels} wheels of `{robot}`"),
                "take a robot of four wheels as mecanum wheels stand, or of three omni wheels of which one is at the back",
            )
        })?;
        let most_rad_s = plant.resolved().wheel_rate_limit_rad_s();
        if !most_rad_s.is_finite() {
            return Err(Error::invalid(
                format!("nothing limits how fast the wheels of `{robot}` turn, and a full pulse means that rate"),
                "set `guidance.wheel_rate_limit_rad_s`, or give the motors of the robot's file a velocity limit",
            )
            .into());
        }
        Ok(Self {
            start_height_m: plant.truth().height_m,
            rates_rad_s: vec![0.0; wheels],
            plant,
            mixer,
            most_rad_s,
            last: None,
        })
    }

    /// The frame type, and the assignment of wheels to motors.
    pub fn mixer(&self) -> &Mixer {
        &self.mixer
    }

    /// The names of the wheels in the order of ArduPilot's motors.
    pub fn wheels(&self) -> impl Iterator<Item = &str> {
        let wheels = &self.plant.robot().wheels;
        let order = self.mixer.wheels.iter();
        order.map(|(wheel, _)| wheels[*wheel].name.as_str())
    }

    /// Returns the parameters for ArduPilot's Rover, as a file for `--add-param-file`.
    ///
    /// Rover assigns its first and third output to steering and throttle by default, and then no
    /// motor to them; and its SITL's own parameters change their pulses. So function and pulses of
    /// each output are set.
    pub fn parameters(&self) -> String {
        let frame = self.mixer.frame;
        let mut text = format!(
            "# Parameters of ArduPilot's Rover for {}, {}.\nFRAME_TYPE {}\n",
            self.plant.robot().name,
            frame.name,
            frame.frame_type
        );
        let (trim_us, span_us) = PULSE_US;
        for (output, wheel) in (1_u8..).zip(self.wheels()) {
            let _ = writeln!(text, "# {wheel}");
            for (key, value) in [
                ("FUNCTION", FIRST_MOTOR + f64::from(output) - 1.0),
                ("MIN", trim_us - span_us),
                ("TRIM", trim_us),
                ("MAX", trim_us + span_us),
                ("REVERSED", 0.0),
            ] {
                let _ = writeln!(text, "SERVO{output}_{key} {value}");
            }
        }
        text
    }

    /// Advances by a frame; returns the answer.
    ///
    /// # Errors
    /// If the robot's motion becomes NaN; the robot is then at its start.
    pub fn answer(&mut self, packet: &Packet) -> Result<&str, LiveError> {
        match &self.last {
            Some((frame, _)) if *frame == packet.frame => {}
            last => {
                if last
                    .as_ref()
                    .is_some_and(|(frame, _)| packet.frame < *frame)
                {
                    self.reset()?;
                }
                if let Err(error) = self.step(packet) {
                    self.reset()?;
                    return Err(error);
                }
                self.last = Some((packet.frame, self.state()));
            }
        }
        Ok(self.last.as_ref().map_or("", |(_, answer)| answer))
    }

    fn reset(&mut self) -> Result<(), LiveError> {
        let resolved = self.plant.resolved();
        let (seed, start) = (resolved.scenario().sensors.seed, resolved.start());
        self.plant.reset(seed, start)?;
        self.last = None;
        Ok(())
    }

    fn step(&mut self, packet: &Packet) -> Result<(), LiveError> {
        for ((wheel, sign), pulse_us) in self.mixer.wheels.iter().zip(&packet.pwm_us) {
            let share = match *pulse_us {
                0 => 0.0,
                pulse_us => (f64::from(pulse_us) - PULSE_US.0) / PULSE_US.1,
            };
            self.rates_rad_s[*wheel] = sign * share.clamp(-1.0, 1.0) * self.most_rad_s;
        }
        let resolved = self.plant.resolved();
        let wanted_s = match packet.rate_hz {
            0 => resolved.control_dt_s(),
            rate_hz => 1.0 / f64::from(rate_hz),
        };
        let wanted_s = wanted_s.min(MOST_S);
        let step_s = match resolved.scenario().wheel_loop.takes_whole_steps() {
            // Such loops take whole steps: at least one, so that time advances with every frame.
            true => {
                let dt_s = resolved.physics_dt_s();
                (wanted_s / dt_s).round().max(1.0) * dt_s
            }
            false => wanted_s,
        };
        self.plant
            .advance(WheelCommand::Rates(&self.rates_rad_s), step_s)?;
        Ok(())
    }

    /// Returns the state in ArduPilot's format: one JSON object between two line ends.
    fn state(&self) -> String {
        let (world, resolved) = (self.plant.world(), self.plant.resolved());
        let body = world.robot().state();
        let (from, pose) = (resolved.start(), body.pose);
        // From axes of the body or the world with x forward or north, y left or west, z up.
        let turned = |[x, y, z]: [f64; 3]| [x, -y, -z];
        let velocity_m_s = body.world_from_body * body.velocity_in_body_m_s;
        // Specific force: the acceleration less gravity.
        let mut feels = -world.gravity_in_world_m_s2();
        let acceleration_m_s2 = self.plant.outcome().acceleration_in_world_m_s2;
        feels
            .iter_mut()
            .zip(acceleration_m_s2)
            .for_each(|(feels, of)| *feels += of);
        let feels_in_body = body.world_from_body.inverse() * feels;
        let position_m = [
            pose.x_m - from.x_m,
            pose.y_m - from.y_m,
            body.height_m - self.start_height_m,
        ];
        let mut json = format!("\n{{\"timestamp\":{:.9}", self.plant.time_s());
        let mut triple = |name: &str, numbers: [f64; 3], end: &str| {
            let [x, y, z] = turned(numbers);
            // Fixed digits, because the reader accepts no exponent; writing to a string cannot
            // fail.
            let _ = write!(json, ",{name}:[{x:.9},{y:.9},{z:.9}]{end}");
        };
        triple("\"imu\":{\"gyro\"", body.angular_in_body_rad_s.into(), "");
        triple("\"accel_body\"", feels_in_body.into(), "}");
        triple("\"position\"", position_m, "");
        triple(
            "\"attitude\"",
            [body.roll_rad, body.pitch_rad, pose.heading_rad],
            "",
        );
        triple("\"velocity\"", velocity_m_s.into(), "");
        json.push_str("}\n");
        json
    }
}

/// A UDP server for ArduPilot, only on this machine.
#[derive(Debug)]
pub struct ArduPilot {
    socket: UdpSocket,
    port: u16,
}

impl ArduPilot {
    /// SITL's default port of the physics backend.
    pub const PORT: u16 = 9002;

    /// Listens on a port of the loopback interface, 0 for any that is free.
    ///
    /// # Errors
    /// [`LiveError::Listen`].
    pub fn start(port: u16) -> Result<Self, LiveError> {
        let fault = |reason| LiveError::Listen { port, reason };
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, port)).map_err(fault)?;
        socket.set_read_timeout(Some(LOOK)).map_err(fault)?;
        let port = socket.local_addr().map_err(fault)?.port();
        Ok(Self { socket, port })
    }

    /// Its port.
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Answers frames until `go_on` returns false; `say` receives messages for the user. The first
    /// sender has exclusive control, until it has been silent for two seconds.
    ///
    /// # Errors
    /// If the network fails, or the simulation cannot continue.
    pub fn serve(
        &self,
        vehicle: &mut Vehicle,
        mut go_on: impl FnMut() -> bool,
        mut say: impl FnMut(&str),
    ) -> Result<(), LiveError> {
        let mut bytes = [0; 256];
        let (mut strange, mut second) = (false, false);
        let mut driver: Option<(SocketAddr, Instant)> = None;
        while go_on() {
            let (length, from) = match self.socket.recv_from(&mut bytes) {
                Ok(received) => received,
                // Nothing received; or an earlier answer was not delivered, as after the end of
                // SITL.
                Err(error) if is_passing(error.kind()) => continue,
                Err(reason) => {
                    return Err(LiveError::Listen {
                        port: self.port,
                        reason,
                    });
                }
            };
            let Some(packet) = Packet::read(&bytes[..length]) else {
                if !std::mem::replace(&mut strange, true) {
                    say(&format!(
                        "{from} sends what is no frame of ArduPilot's: it is left alone"
                    ));
                }
                continue;
            };
            let drives = driver.filter(|(_, heard)| heard.elapsed() < KEEPS);
            if drives.is_some_and(|(who, _)| who != from) {
                if !std::mem::replace(&mut second, true) {
                    say(&format!(
                        "{from} sends frames too, and another drives: it is left alone"
                    ));
                }
                continue;
            }
            if driver.is_some_and(|(who, _)| who != from) {
                vehicle.reset()?;
                say("another ArduPilot drives: the robot is back at its start");
            }
            driver = Some((from, Instant::now()));
            let time_s = vehicle.plant.time_s();
            match vehicle.answer(&packet).map(str::to_owned) {
                Ok(answer) => {
                    if vehicle.plant.time_s() < time_s {
                        say("ArduPilot has started again: the robot is back at its start");
                    }
                    let _ = self.socket.send_to(answer.as_bytes(), from);
                }
                Err(LiveError::Simulation(error @ Error::Diverged { .. })) => {
                    say(&format!("{error}; it starts again"));
                }
                Err(other) => return Err(other),
            }
        }
        Ok(())
    }
}

fn is_passing(kind: ErrorKind) -> bool {
    use ErrorKind::{ConnectionRefused, ConnectionReset, Interrupted, TimedOut, WouldBlock};
    matches!(
        kind,
        ConnectionRefused | ConnectionReset | Interrupted | TimedOut | WouldBlock
    )
}
