//! Logs that the oracle made, with noise and whole counts: what identification finds in them must be what the robot is, as often as its
//! intervals promise.

use std::f64::consts::TAU;
use std::path::Path;

use ilon_control::{ContactKinematics, Kinematics};
use ilon_identify::Log;
use ilon_identify::fit::{Evidence, Fitted, Noise, fit, take_noise};
use ilon_identify::model::Model;
use ilon_identify::motion::{Window, windows};
use ilon_oracle::{ContactLaw, Drive, Engine, LEVEL_GRAVITY_M_S2};
use ilon_robot::{LoadOptions, Robot, Twist};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use crate::case::GAIN_N_M_S;
use crate::engines::Springs;

/// Rows of a log are this far apart, in seconds.
const ROW_S: f64 = 0.02;
/// Each twist is driven for so long, in seconds, of which the first are a ramp.
const HELD_S: f64 = 2.0;
const RAMP_S: f64 = 0.3;
/// Encoder counts a turn of the wheel, and standard deviations of what the tracker sees.
const COUNTS: f64 = 4096.0;
const NOISE_M: f64 = 3e-4;
const NOISE_RAD: f64 = 5e-4;
/// Soft enough that a pool of drives takes minutes.
const SPRINGS_N_M: f64 = 2e6;

fn robot(file: &str, spec: &str) -> Robot {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/robots");
    let mut options = LoadOptions::default();
    options.spec = toml::from_str(spec).expect("keys of a description");
    let loaded = Robot::load_with(root.join(file), &options);
    loaded.expect("a shipped robot").robot
}

/// A number from 0 to 1.
fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    rng.next_u64() as f64 / u64::MAX as f64
}

/// A normal number of deviation 1, after Box and Muller.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * (1.0 - uniform(rng)).max(1e-300).ln()).sqrt();
    radius * (TAU * uniform(rng)).cos()
}

/// A drive of the true robot in the oracle, as it was: six twists, in an order and from wheel angles of chance, by the rates that the robot
/// as it is known gives them.
fn course(truth: &Robot, known: &Robot, seed: u64) -> Log {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let springs = Springs::of(SPRINGS_N_M);
    let steps = (ROW_S / springs.step_s).ceil();
    let mut engine = Engine::new(
        truth,
        ilon_oracle::Settings {
            step_s: ROW_S / steps,
            contact: ContactLaw::stiff(SPRINGS_N_M, 0.6, truth),
            gravity_m_s2: LEVEL_GRAVITY_M_S2,
        },
    )
    .expect("the oracle takes the robot");
    let start: Vec<f64> = known
        .wheels
        .iter()
        .map(|_| TAU * uniform(&mut rng))
        .collect();
    engine.set_wheel_angles_rad(&start);
    // Each along one axis: of a drive between them the mean is not that of its parts, as wheels that stand keep their rollers.
    let mut twists = [
        [0.2, 0.0, 0.0],
        [0.0, 0.2, 0.0],
        [0.0, 0.0, 0.6],
        [-0.2, 0.0, 0.0],
        [0.0, -0.2, 0.0],
        [0.0, 0.0, -0.6],
    ];
    for place in (1..twists.len()).rev() {
        twists.swap(place, (rng.next_u64() % (place as u64 + 1)) as usize);
    }
    let kinematics = Kinematics::new(known).expect("wheels that drive");
    let mut rates = vec![0.0; start.len()];
    let mut log = Log::default();
    let mut heading_rad = 0.0;
    let rows = (HELD_S * twists.len() as f64 / ROW_S).round() as usize;
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
        let place = ((t_s / HELD_S) as usize).min(twists.len() - 1);
        let before = if place == 0 {
            [0.0; 3]
        } else {
            twists[place - 1]
        };
        let share = ((t_s - place as f64 * HELD_S) / RAMP_S).min(1.0);
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

/// The log of a course: whole counts, and poses under noise.
fn logged(course: &Log, rng: &mut ChaCha8Rng) -> Log {
    let mut log = course.clone();
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

fn evidence(logs: &[Log]) -> Evidence {
    let runs = logs.iter().enumerate();
    Evidence::of(runs.map(|(run, log)| windows(log, run, 1.0)))
}

fn fitted(known: &Robot, free: &[&str], evidence: &Evidence, noise: Noise, seed: u32) -> Fitted {
    let free: Vec<String> = free.iter().map(|name| (*name).to_owned()).collect();
    let tracker = ["x_m", "y_m", "heading_deg"].map(str::to_owned);
    let model = Model::new(known, &free).expect("parameters of the robot");
    let model = model.with_tracker(&tracker, &[String::new()]);
    let all: Vec<&Window> = evidence.windows.iter().collect();
    fit(&model, evidence, &all, noise, Some((400, seed))).expect("a fit")
}

/// What the true robot makes of the rates that the known robot gives a twist, over that twist: the mean over wheel angles of the twist
/// without slip at the rollers that touch.
fn gains(truth: &Robot, known: &Robot) -> [f64; 3] {
    let mut contact = ContactKinematics::new(truth).expect("rollers");
    let kinematics = Kinematics::new(known).expect("wheels that drive");
    let wheels = known.wheels.len();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|unit| {
        let mut rates = vec![0.0; wheels];
        kinematics.wheel_rates(Twist::new(unit[0], unit[1], unit[2]), &mut rates);
        let count = 40_000;
        let sum: f64 = (0..count)
            .map(|_| {
                let angles: Vec<f64> = (0..wheels).map(|_| TAU * uniform(&mut rng)).collect();
                let twist = contact.twist(&angles, &rates);
                twist.vx_m_s * unit[0] + twist.vy_m_s * unit[1] + twist.omega_rad_s * unit[2]
            })
            .sum();
        sum / f64::from(count)
    })
}

/// A robot as its file has it and as it is in truth.
struct Pair {
    file: &'static str,
    spec: &'static str,
}

/// Wheels 1.6 % smaller than the file says, arms 3 to 4 % longer.
const PAIRS: [Pair; 2] = [
    Pair {
        file: "mecanum4.toml",
        spec: "wheel.radius_m = 0.0492\nwheels.mecanum.half_width_m = 0.166",
    },
    Pair {
        file: "volksbot.toml",
        spec: "wheel.radius_m = 0.0492\nwheels.ring.distance_m = 0.26",
    },
];

/// By how much the gains of all drives without noise may differ from those of the contact kinematics, which know no springs: at 2e6 N/m two
/// rollers share each hand-over, by which a steady turn comes 1.4e-3 short (docs/tread.md).
const OF_CONTACT: f64 = 2e-3;

/// In how many of so many logs, each of eight drives out of a pool, each gain lies in its interval. The truth is what the robot did in all
/// drives of the pool: seen without noise, and not counted.
fn inside(pair: &Pair, pool: usize, logs: u32) -> Vec<(&'static str, u32)> {
    let (known, truth) = (robot(pair.file, ""), robot(pair.file, pair.spec));
    let courses: Vec<Log> = (0..pool as u64)
        .into_par_iter()
        .map(|seed| course(&truth, &known, seed))
        .collect();
    let names = ["gain.ahead", "gain.sideways", "gain.turn"];
    let of_contact = gains(&truth, &known);
    // With the weights that noise gives, and without noise.
    let weights = Noise {
        position_m: 2.0_f64.sqrt() * NOISE_M,
        heading_rad: 2.0_f64.sqrt() * NOISE_RAD,
    };
    let seen = fitted(&known, &names, &evidence(&courses), weights, 0);
    let gains: [f64; 3] = std::array::from_fn(|place| seen.values[place]);
    for (gain, of_contact) in gains.iter().zip(of_contact) {
        assert!(
            (gain - of_contact).abs() < OF_CONTACT,
            "{gain} for {of_contact}"
        );
    }
    let mut counts = [0; 3];
    let (mut widths, mut apart) = ([0.0; 3], [0.0; 3]);
    for seed in 0..logs {
        let mut rng = ChaCha8Rng::seed_from_u64(1000 + u64::from(seed));
        let chosen: Vec<Log> = (0..8)
            .map(|_| {
                let course = &courses[(rng.next_u64() % pool as u64) as usize];
                logged(course, &mut rng)
            })
            .collect();
        let mut evidence = evidence(&chosen);
        let (noise, _) = take_noise(&mut evidence);
        let found = fitted(&known, &names, &evidence, noise, seed);
        assert!(found.held.is_empty(), "{:?}", found.held);
        let intervals = found.draws.intervals(&found.values);
        for place in 0..3 {
            let interval = intervals[place];
            counts[place] +=
                u32::from(interval.low <= gains[place] && gains[place] <= interval.high);
            widths[place] += (interval.high - interval.low) / f64::from(logs);
            apart[place] += (found.values[place] - gains[place]) / f64::from(logs);
        }
    }
    println!(
        "{}: truth {gains:.5?}, by contact kinematics {of_contact:.5?}, inside {counts:?} of {logs}, mean width {widths:.5?}, mean error {apart:.5?}",
        pair.file
    );
    names.into_iter().zip(counts).collect()
}

/// Of intervals that hold the truth in 95 of 100, fewer than 19 of 24 hold it once in a thousand; intervals half as wide as they ought to
/// be would hold it in 16.
#[test]
fn gains_of_the_oracles_robot_lie_in_their_intervals() {
    for (name, count) in inside(&PAIRS[0], 8, 24) {
        assert!(
            count >= 19,
            "{name} lies in its interval in {count} of 24 logs"
        );
    }
}

/// Of a true coverage of 95 % a count below 90 has a chance of 1 %, and 100 of 100 one of 0.6 %.
#[test]
#[ignore = "minutes: a hundred logs of two robots"]
fn in_a_hundred_logs_of_the_oracle_intervals_keep_their_promise() {
    for pair in &PAIRS {
        for (name, count) in inside(pair, 64, 100) {
            assert!(
                (90..=99).contains(&count),
                "{}: {name} lies in its interval in {count} of 100 logs",
                pair.file
            );
        }
    }
}
