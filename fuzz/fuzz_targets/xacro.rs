//! A damaged xacro file is expanded or refused with a message, within its limits of time, depth and
//! memory.
#![no_main]

use std::sync::LazyLock;

use ilon_files::FileAccess;
use ilon_formats::{LoadOptions, LoadRobot, Package};
use ilon_robot::Robot;
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

/// Only the packages of the xacro test cases may be read.
static OPTIONS: LazyLock<LoadOptions> = LazyLock::new(|| {
    let packages = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../crates/files/xacro/tests/packages"
    );
    let mut options = LoadOptions::default();
    options.files = FileAccess::below([packages]).expect("they are there");
    options.packages.push(Package {
        name: "a_robot".to_owned(),
        folder: format!("{packages}/a_robot").into(),
    });
    options
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    // Moves whole elements, or parts of expressions.
    let piece = if seed.is_multiple_of(3) { b' ' } else { b'<' };
    ilon_fuzz::mutate(data, size, max_size, seed, piece)
});

fuzz_target!(|text: &str| {
    for leave_out_missing in [false, true] {
        let mut options = OPTIONS.clone();
        options.leave_out_missing = leave_out_missing;
        if let Err(error) = Robot::from_urdf_str_with(text, "robot.urdf.xacro", &options) {
            assert!(!error.to_string().is_empty() && !error.help().is_empty());
        }
    }
});
