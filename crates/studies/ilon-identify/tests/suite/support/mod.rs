//! Drives of known robots, as logs with noise and encoder counts.
#![allow(dead_code)]

use std::f64::consts::TAU;
use std::path::PathBuf;

use ilon_control::Kinematics;
use ilon_formats::{LoadOptions, LoadRobot};
use ilon_identify::Log;
use ilon_identify::model::Model;
use ilon_robot::{Pose, Robot, Twist};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};

/// A robot of the project.
pub fn robot(name: &str) -> Robot {
    Robot::load_with(assets().join("robots").join(name), &LoadOptions::default())
        .unwrap()
        .robot
}

/// The project's folder of robots, logs and studies.
pub fn assets() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../assets")
}

/// A drive and its measurement.
pub struct Drive {
    /// Commanded twists for the nominal robot, of equal duration: m/s and rad/s.
    pub directions: Vec<[f64; 3]>,
    pub for_s: f64,
    pub row_s: f64,
    /// The tracked point in the body frame, in metres, and the tracker's heading offset, in
    /// radians.
    pub tracker: [f64; 3],
    pub position_noise_m: f64,
    pub heading_noise_rad: f64,
    pub counts_per_turn: f64,
    pub seed: u64,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            directions: vec![
                [0.2, 0.0, 0.0],
                [0.0, 0.2, 0.0],
                [0.14, -0.14, 0.0],
                [0.0, 0.0, 0.6],
                [-0.2, 0.0, 0.2],
                [0.0, -0.2, -0.3],
            ],
            for_s: 60.0,
            row_s: 0.02,
            tracker: [0.03, -0.02, 0.0],
            position_noise_m: 3e-4,
            heading_noise_rad: 5e-4,
            counts_per_turn: 4096.0,
            seed: 0,
        }
    }
}

/// The log of a robot of a model with these values: its wheels turn as commanded for the nominal
/// robot of the model.
pub fn drive(model: &Model, values: &[f64], drive: &Drive) -> Log {
    let truth = model.twist_matrix(values).unwrap();
    let nominal = Kinematics::new(&model.robot(&model.nominal())).unwrap();
    let wheels = truth.ncols();
    let mut rng = ChaCha8Rng::seed_from_u64(0x5eed + drive.seed);
    let (place, turn) = (
        Normal::new(0.0, drive.position_noise_m).unwrap(),
        Normal::new(0.0, drive.heading_noise_rad).unwrap(),
    );
    let rows = (drive.for_s / drive.row_s).round() as usize;
    let mut angles = vec![0.0; wheels];
    let mut rates = vec![0.0; wheels];
    let mut body = Pose::default();
    let mut log = Log::default();
    const FINE: usize = 10;
    for row in 0..=rows {
        let count = |angle: &f64| {
            (angle / TAU * drive.counts_per_turn).floor() * TAU / drive.counts_per_turn
        };
        let (s, c) = libm::sincos(body.heading_rad);
        let [o_x, o_y, ahead] = drive.tracker;
        log.times_s.push(row as f64 * drive.row_s);
        log.angles_rad.push(angles.iter().map(count).collect());
        log.poses.push([
            body.x_m + c * o_x - s * o_y + place.sample(&mut rng),
            body.y_m + s * o_x + c * o_y + place.sample(&mut rng),
            body.heading_rad + ahead + turn.sample(&mut rng),
        ]);
        log.unseen.push(false);
        let which = row * drive.directions.len() / (rows + 1);
        let [vx, vy, omega] = drive.directions[which];
        nominal.wheel_rates(Twist::new(vx, vy, omega), &mut rates);
        for _ in 0..FINE {
            let mut step = [0.0; 3];
            for (wheel, column) in truth.column_iter().enumerate() {
                let turned = rates[wheel] * drive.row_s / FINE as f64;
                angles[wheel] += turned;
                (0..3).for_each(|axis| step[axis] += column[axis] * turned);
            }
            let heading = body.heading_rad + step[2];
            body = body.moved(Twist::new(step[0], step[1], step[2]));
            body.heading_rad = heading;
        }
    }
    log
}

/// A log as a text table, with the names that the studies of these tests use.
pub fn csv(log: &Log, robot: &Robot) -> String {
    let names: Vec<&str> = robot
        .wheels
        .iter()
        .map(|wheel| wheel.name.as_str())
        .collect();
    let mut text = format!("t,x,y,heading,{}\n", names.join(","));
    for row in 0..log.len() {
        let [x, y, heading] = log.poses[row];
        let angles: Vec<String> = log.angles_rad[row]
            .iter()
            .map(|angle| format!("{angle:.6}"))
            .collect();
        text += &format!(
            "{:.4},{x:.6},{y:.6},{heading:.6},{}\n",
            log.times_s[row],
            angles.join(",")
        );
    }
    text
}

/// A study of one log.
pub fn study(robot: &Robot, robot_file: &str, log: &str, more: &str) -> String {
    let wheels: String = robot
        .wheels
        .iter()
        .map(|wheel| format!("{0} = {{ column = \"{0}\", unit = \"rad\" }}\n", wheel.name))
        .collect();
    format!(
        "robot = {:?}\n{more}\n[log]\ntime = {{ column = \"t\", unit = \"s\" }}\nx = {{ column = \"x\", unit = \"m\" }}\ny = {{ column = \"y\", \
         unit = \"m\" }}\nheading = {{ column = \"heading\", unit = \"rad\" }}\n[log.wheels]\n{wheels}\n[[runs]]\nfile = {log:?}\n",
        assets()
            .join("robots")
            .join(robot_file)
            .display()
            .to_string()
    )
}
