//! A damaged log, bag or list of waypoints drives a robot and is fitted to, or is refused with a
//! message.
#![no_main]

use std::path::Path;
use std::sync::LazyLock;

use ilon::Scenario;
use ilon_files::FileAccess;
use ilon_fuzz::{FOLDER, SMALL};
use ilon_identify::{Study, identify};
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

/// What of a log may drive the robot.
const DRIVES: [&str; 6] = [
    "wheel_rates",
    "wheel_angles",
    "wheel_torques",
    "twist",
    "path",
    "joints",
];

/// A study of the robot's radius and lever from a table, and one from a bag.
static STUDIES: LazyLock<[Study; 2]> = LazyLock::new(|| {
    let urdf = include_str!("../seeds/urdf/omni.urdf");
    std::fs::write(FOLDER.join("robot.urdf"), urdf).expect("the folder can be written to");
    let columns: String = [0, 1, 2]
        .map(|k| {
            format!("wheels.wheel{k} = {{ column = \"wheel{k}_angle_rad\", unit = \"rad\" }}\n")
        })
        .concat();
    let table = format!(
        "[log]\ntime = {{ column = \"t_s\", unit = \"s\" }}\nx = {{ column = \"measured_x_m\", unit = \"m\" }}\n\
         y = {{ column = \"measured_y_m\", unit = \"m\" }}\nheading = {{ column = \"measured_heading_rad\", unit = \"rad\" }}\n{columns}"
    );
    let bag = "[log.bag]\npose = \"/odom\"\n".to_owned();
    [("csv", table), ("mcap", bag)].map(|(kind, log)| {
        let path = FOLDER.join(format!("{kind}.toml"));
        let text = format!(
            "robot = \"robot.urdf\"\nwindow_s = 0.1\n{log}[[runs]]\nfile = \"log.{kind}\"\n"
        );
        std::fs::write(&path, text).expect("the folder can be written to");
        Study::load(&path).expect("the study is a good one")
    })
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let piece = if seed.is_multiple_of(3) { b',' } else { b'\n' };
    ilon_fuzz::mutate(data, size, max_size, seed, piece)
});

fuzz_target!(|bytes: &[u8]| {
    let studies = &*STUDIES;
    let is_bag = bytes.starts_with(b"\x89MCAP");
    let kind = if is_bag { "mcap" } else { "csv" };
    let log = FOLDER.join(format!("log.{kind}"));
    std::fs::write(&log, bytes).expect("the folder can be written to");
    let uses = DRIVES.map(Some).into_iter().chain([None, None]);
    let Some(drives) = ilon_fuzz::pick(uses, bytes) else {
        return fit(&studies[usize::from(is_bag)], kind, bytes);
    };
    let beside = match drives {
        "joints" => "twist.vx_m_s = 0.1\n",
        _ => "",
    };
    play(&format!(
        "{beside}playback = {{ file = \"log.{kind}\", drives = \"{drives}\" }}\n"
    ));
});

/// Fits to the log, or, every other time, drives along the waypoints of a table.
fn fit(study: &Study, kind: &str, bytes: &[u8]) {
    if kind == "csv" && bytes.len().is_multiple_of(2) {
        return play("reference.waypoints = { file = \"log.csv\" }\nrun.duration_s = 1\n");
    }
    match identify(study, &|_| ()) {
        Ok(found) => assert!(found.parameters.values().all(|p| p.value.is_finite())),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Takes the first steps of a scenario.
fn play(motion: &str) {
    let text = format!("robot.file = \"robot.urdf\"\n{motion}");
    let path: &Path = &FOLDER.join("play.toml");
    let scenario = Scenario::from_text(&text, path, &[], &FileAccess::anywhere())
        .expect("the scenario is a good one");
    ilon_fuzz::use_scenario(&scenario, &SMALL);
}
