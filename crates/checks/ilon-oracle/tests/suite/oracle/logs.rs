//! Logs of the oracle: the true motion of a robot on its springs, and its measurement by encoders
//! and a tracker.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use ilon_control::Kinematics;
use ilon_formats::{LoadOptions, LoadRobot};
use ilon_identify::Log;
use ilon_oracle::{ContactLaw, Drive, Engine, LEVEL_GRAVITY_M_S2, Settings};
use ilon_robot::{Robot, Twist};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;

use crate::oracle::case::GAIN_N_M_S;
use crate::oracle::engines::Springs;

/// Time between rows of a log, in seconds.
pub const ROW_S: f64 = 0.02;
/// Duration of a ramp between two twists, in seconds.
pub const RAMP_S: f64 = 0.3;
/// Encoder counts per wheel turn, and standard deviations of the tracker.
const COUNTS: f64 = 4096.0;
pub const NOISE_M: f64 = 3e-4;
pub const NOISE_RAD: f64 = 5e-4;
/// Friction of rollers and floor.
pub const FRICTION: f64 = 0.6;

/// A robot of the project.
pub fn robot_file(file: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    root.join(file)
}

/// The same, with changed keys of its description.
pub fn robot(file: &str, spec: &str) -> Robot {
    let mut options = LoadOptions::default();
    options.spec = toml::from_str(spec).expect("keys of a description");
    let loaded = Robot::load_with(robot_file(file), &options);
    loaded.expect("a shipped robot").robot
}

/// A number from 0 to 1.
pub fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    rng.next_u64() as f64 / u64::MAX as f64
}

/// A normally distributed number of deviation 1 (Box and Muller).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * (1.0 - uniform(rng)).max(1e-300).ln()).sqrt();
    radius * (TAU * uniform(rng)).cos()
}

/// Random angles of the wheels, in radians.
pub fn any_angles(robot: &Robot, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let wheels = robot.wheels.iter();
    wheels.map(|_| TAU * uniform(rng)).collect()
}

/// A drive of the true robot in the oracle, with the wheel rates of the assumed robot for each
/// twist.
pub struct Ride<'a> {
    pub truth: &'a Robot,
    pub known: &'a Robot,
    pub springs_n_m: f64,
    pub start_rad: Vec<f64>,
    /// In sequence, in m/s and rad/s.
    pub twists: Vec<[f64; 3]>,
    /// Duration of each, including the ramp, in seconds.
    pub held_s: f64,
}

impl Ride<'_> {
    /// The true motion: no noise, no counts.
    pub fn log(&self) -> Log {
        let springs = Springs::of(self.springs_n_m);
        let steps = (ROW_S / springs.step_s).ceil();
        let mut engine = Engine::new(
            self.truth,
            Settings {
                step_s: ROW_S / steps,
                contact: ContactLaw::stiff(self.springs_n_m, FRICTION, self.truth),
                gravity_m_s2: LEVEL_GRAVITY_M_S2,
            },
        )
        .expect("the oracle takes the robot");
        engine.set_wheel_angles_rad(&self.start_rad);
        let kinematics = Kinematics::new(self.known).expect("wheels that drive");
        let mut rates = vec![0.0; self.start_rad.len()];
        let mut log = Log::default();
        let mut heading_rad = 0.0;
        let twists = &self.twists;
        let rows = (self.held_s * twists.len() as f64 / ROW_S).round() as usize;
        for row in 0..=rows {
            let pose = engine.world_from_body();
            let yaw_rad = pose.rotation.euler_angles().2;
            heading_rad += ilon_robot::wrap_angle(yaw_rad - heading_rad);
            log.times_s.push(row as f64 * ROW_S);
            log.angles_rad.push(engine.wheel_angles_rad().to_vec());
            log.poses
                .push([pose.translation.x, pose.translation.y, heading_rad]);
            log.unseen.push(false);
            let t_s = row as f64 * ROW_S;
            let place = ((t_s / self.held_s) as usize).min(twists.len() - 1);
            let before = if place == 0 {
                [0.0; 3]
            } else {
                twists[place - 1]
            };
            let share = ((t_s - place as f64 * self.held_s) / RAMP_S).min(1.0);
            let of = |axis: usize| before[axis] + share * (twists[place][axis] - before[axis]);
            kinematics.wheel_rates(Twist::new(of(0), of(1), of(2)), &mut rates);
            for (wheel, rate) in rates.iter().enumerate() {
                engine.drive(
                    wheel,
                    Drive::Rate {
                        target_rad_s: *rate,
                        gain_n_m_s: GAIN_N_M_S,
                        limit_n_m: f64::INFINITY,
                    },
                );
            }
            for _ in 0..steps as usize {
                engine.step().expect("the motion stays finite");
            }
        }
        log
    }
}

/// The log of a ride: integer counts, and poses with noise.
pub fn logged(ride: &Log, rng: &mut ChaCha8Rng) -> Log {
    let mut log = ride.clone();
    let first = log.angles_rad[0].clone();
    for angles in &mut log.angles_rad {
        for (angle, first) in angles.iter_mut().zip(&first) {
            let counts = |angle: f64| (angle / TAU * COUNTS).floor();
            *angle = (counts(*angle) - counts(*first)) * TAU / COUNTS;
        }
    }
    for [x_m, y_m, heading_rad] in &mut log.poses {
        *x_m += NOISE_M * normal(rng);
        *y_m += NOISE_M * normal(rng);
        *heading_rad += NOISE_RAD * normal(rng);
    }
    log
}
