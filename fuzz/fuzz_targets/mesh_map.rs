//! A damaged mesh or picture is read, as the shape of a robot's part and as the ground, or refused
//! with a message.
#![no_main]

use std::path::Path;

use ilon::Scenario;
use ilon_files::FileAccess;
use ilon_formats::{LoadOptions, LoadRobot};
use ilon_fuzz::SMALL;
use ilon_robot::Robot;
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    // Moves whole elements of COLLADA, or whole lines of the others.
    let piece = if seed.is_multiple_of(2) { b'<' } else { b'\n' };
    ilon_fuzz::mutate(data, size, max_size, seed, piece)
});

fuzz_target!(|bytes: &[u8]| {
    let kind = kind(bytes);
    if kind != "png" {
        part(kind, bytes);
    }
    ground(kind, bytes);
});

/// The kind of file that it resembles most.
fn kind(bytes: &[u8]) -> &'static str {
    let has = |word: &[u8]| bytes.windows(word.len()).any(|at| at == word);
    if bytes.starts_with(b"\x89PNG") {
        "png"
    } else if has(b"COLLADA") {
        "dae"
    } else if bytes.starts_with(b"solid") || bytes.contains(&0) {
        "stl"
    } else {
        "obj"
    }
}

/// Loads a robot with a part of this shape, and what is shown of it.
fn part(kind: &str, bytes: &[u8]) {
    let mesh = format!("mesh.{kind}");
    let urdf = include_str!("../seeds/urdf/omni.urdf").replacen(
        "</link>",
        &format!(
            "<collision><origin xyz=\"0 0 0.3\"/><geometry><mesh filename=\"{mesh}\"/></geometry></collision>\
             <visual><geometry><mesh filename=\"{mesh}\" scale=\"1 2 1\"/></geometry></visual></link>"
        ),
        1,
    );
    let mut options = LoadOptions::default();
    options.repair = ilon_fuzz::pick([false, true], bytes);
    options.files = FileAccess::of_memory([(mesh.into(), bytes.to_vec())]);
    match Robot::from_urdf_str_with(&urdf, "robot.urdf", &options) {
        Ok(loaded) => {
            let _ = loaded.visual_meshes();
            ilon_fuzz::use_robot(&loaded.robot);
        }
        Err(error) => assert!(!error.to_string().is_empty() && !error.help().is_empty()),
    }
}

/// Places a robot on this ground and drives it.
fn ground(kind: &str, bytes: &[u8]) {
    let map = format!("map.{kind}");
    let height = if kind == "png" {
        ", height_m = 0.05"
    } else {
        ""
    };
    let text = format!(
        "robot.file = \"robot.urdf\"\ntwist.vx_m_s = 0.1\nrun.duration_s = 1\nworld.floor.height_map = {{ file = \"{map}\", cell_m = 0.1{height} }}\n"
    );
    let files = FileAccess::of_memory([(map.into(), bytes.to_vec())]);
    let scenario = Scenario::from_text(&text, Path::new("ground.toml"), &[], &files)
        .expect("the scenario is a good one");
    ilon_fuzz::use_scenario(&scenario, &SMALL);
}
