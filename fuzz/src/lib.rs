//! Mutations that know the structure of text files.
//!
//! Random byte changes rarely leave a file that a parser accepts. Here whole pieces move (XML
//! elements, TOML lines), names are swapped and numbers take values that often cause errors.
//! Accepted results are driven from outside by [`drive`].

use std::path::PathBuf;
use std::sync::LazyLock;

use ilon::Scenario;
use ilon::inspect::Inspection;
use ilon::simulate::{Driver, Plant, Simulation, WheelCommand, resolve_for};
use ilon_formats::{Handedness, LoadOptions, LoadRobot, WheelOptions};
use ilon_robot::Robot;
use libfuzzer_sys::fuzzer_mutate;

/// Numbers that often cause errors.
const NUMBERS: [&str; 24] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "3",
    "0.5",
    "-45",
    "90",
    "1e-300",
    "1e-30",
    "1e-9",
    "1e-3",
    "1e3",
    "1e6",
    "1e9",
    "1e30",
    "1e300",
    "-1e300",
    "1e400",
    "nan",
    "inf",
    "18446744073709551616",
    "3.141592653589793",
];

/// A small random number generator (SplitMix64): the fuzzer provides its seed, so that a run can be
/// repeated.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `end`; 0 if `end` is 0.
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// Changes a text in place and returns its new length. `piece` is the first byte of a piece: `<` in
/// XML, a line break in TOML.
pub fn mutate(data: &mut [u8], size: usize, max_size: usize, seed: u32, piece: u8) -> usize {
    let mut dice = Dice(u64::from(seed));
    let text = &data[..size];
    let changed = match dice.below(8) {
        0 | 1 => return fuzzer_mutate(data, size, max_size),
        2..=4 => number_replaced(text, &mut dice),
        5 => word_swapped(text, &mut dice),
        _ => pieces_moved(text, piece, &mut dice),
    };
    let length = changed.len().min(max_size);
    data[..length].copy_from_slice(&changed[..length]);
    length
}

/// Ranges of bytes that belong together by a rule.
fn runs(text: &[u8], belongs: impl Fn(u8) -> bool) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = None;
    for (i, &byte) in text.iter().chain([&0]).enumerate() {
        match (belongs(byte) && i < text.len(), start) {
            (true, None) => start = Some(i),
            (false, Some(from)) => {
                found.push((from, i));
                start = None;
            }
            _ => {}
        }
    }
    found
}

fn replaced(text: &[u8], (from, to): (usize, usize), by: &[u8]) -> Vec<u8> {
    [&text[..from], by, &text[to..]].concat()
}

fn number_replaced(text: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut numbers = runs(text, |b| b.is_ascii_digit() || b"+-.e".contains(&b));
    numbers.retain(|&(from, to)| text[from..to].iter().any(u8::is_ascii_digit));
    match numbers.get(dice.below(numbers.len())) {
        Some(&range) => replaced(text, range, NUMBERS[dice.below(NUMBERS.len())].as_bytes()),
        None => text.to_vec(),
    }
}

fn word_swapped(text: &[u8], dice: &mut Dice) -> Vec<u8> {
    let words = runs(text, |b| b.is_ascii_alphanumeric() || b == b'_');
    match (
        words.get(dice.below(words.len())),
        words.get(dice.below(words.len())),
    ) {
        (Some(&range), Some(&(from, to))) => replaced(text, range, &text[from..to]),
        _ => text.to_vec(),
    }
}

fn pieces_moved(text: &[u8], piece: u8, dice: &mut Dice) -> Vec<u8> {
    let mut pieces: Vec<&[u8]> = text.split_inclusive(|&b| b == piece).collect();
    let from = dice.below(pieces.len());
    let count = 1 + dice.below(12).min(pieces.len() - from.min(pieces.len()));
    let taken: Vec<&[u8]> = pieces.iter().skip(from).take(count).copied().collect();
    if dice.below(3) > 0 {
        pieces.drain(from..from + taken.len());
    }
    if dice.below(3) > 0 {
        let to = dice.below(pieces.len() + 1);
        pieces.splice(to..to, taken);
    }
    pieces.concat()
}

/// Steps a plant from outside as a program with look-ahead does. From a snapshot it repeats its
/// motion bit for bit, and a motion that is no longer finite is reported.
pub fn drive(plant: &mut Plant) {
    let wheels = plant.robot().wheels.len();
    let step_s = plant.resolved().physics_dt_s();
    let rates_rad_s: Vec<f64> = (0..wheels).map(|wheel| 1.0 - wheel as f64).collect();
    let torques_n_m = vec![0.1; wheels];
    let go = |plant: &mut Plant| {
        plant.observe();
        let rolled = plant
            .advance(WheelCommand::Rates(&rates_rad_s), 2.0 * step_s)
            .cloned();
        let went = match rolled {
            Ok(_) => plant
                .advance(WheelCommand::Torques(&torques_n_m), step_s)
                .cloned(),
            Err(error) => Err(error),
        };
        let pose = plant.truth().pose;
        let numbers = [pose.x_m, pose.y_m, pose.heading_rad].map(f64::to_bits);
        // As text: an undefined result is NaN, which is unequal to itself.
        (went.is_ok(), format!("{went:?}"), numbers)
    };
    let start = plant.snapshot();
    let (is_ok, went, numbers) = go(plant);
    if is_ok {
        assert!(
            numbers
                .map(f64::from_bits)
                .iter()
                .all(|number| number.is_finite())
        );
    }
    plant.restore(&start).expect("it is its own");
    assert_eq!(go(plant), (is_ok, went, numbers));
    let pose = plant.resolved().start();
    plant.reset(1, pose).expect("it has stood there before");
    assert!(
        plant
            .advance(WheelCommand::Rates(&[f64::NAN]), step_s)
            .is_err()
    );
}

/// More rollers than this are slow to simulate, which is known.
const MOST_ROLLERS_SIMULATED: usize = 40;

static SIDEWAYS: LazyLock<Scenario> = LazyLock::new(|| {
    let text = "[robot]\nfile = \"robot.urdf\"\nroller_bodies = \"near\"\n[twist]\nvy_m_s = 0.1\n[run]\nduration_s = 1";
    Scenario::from_toml(text, "sideways", ".").expect("the scenario is a good one")
});

/// A small robot that is loaded and simulated quickly.
pub static SMALL: LazyLock<Robot> = LazyLock::new(|| {
    let urdf = include_str!("../seeds/urdf/omni.urdf");
    Robot::from_urdf_str(urdf, "robot.urdf").expect("the robot is a good one")
});

/// The ways in which a robot's file is read: unchanged, repaired, and with given wheels.
pub fn ways() -> [LoadOptions; 3] {
    let mut repaired = LoadOptions::default();
    repaired.repair = true;
    let mut given = repaired.clone();
    given.wheels = Some(WheelOptions::new(5, Handedness::AllDeg(45.0)));
    [LoadOptions::default(), repaired, given]
}

/// Inspects a robot, places it in a world and drives it.
pub fn use_robot(robot: &Robot) {
    if let Ok(inspection) = Inspection::of(robot) {
        assert!(inspection.wheels.iter().all(|wheel| wheel.radius_m > 0.0));
    }
    let rollers: usize = robot.wheels.iter().map(|wheel| wheel.rollers.len()).sum();
    if rollers > MOST_ROLLERS_SIMULATED {
        return;
    }
    let resolved = resolve_for(&SIDEWAYS, robot, Driver::Guidance);
    if let Ok(mut plant) = resolved.and_then(|resolved| Plant::new(&resolved, robot)) {
        drive(&mut plant);
    }
}

/// Takes the first steps of a scenario with a robot, if it can be simulated. The pose stays finite
/// in every step that succeeds.
pub fn use_scenario(scenario: &Scenario, robot: &Robot) {
    match Simulation::with_robot(scenario, robot) {
        Ok(mut simulation) => {
            for _ in 0..3 {
                simulation.step();
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Picks one of several ways of using an input by its bytes: an input costs one use, not all.
pub fn pick<T>(ways: impl IntoIterator<Item = T>, bytes: &[u8]) -> T {
    let mut ways: Vec<T> = ways.into_iter().collect();
    let sum = bytes.iter().fold(0, |sum: usize, &b| {
        sum.wrapping_mul(31).wrapping_add(b.into())
    });
    ways.swap_remove(sum % ways.len())
}

/// A folder of this process, for files that are read by their paths.
pub static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = std::env::temp_dir().join(format!("ilon-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("the folder for temporary files can be written to");
    folder
});
