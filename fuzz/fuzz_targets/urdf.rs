//! A damaged robot file loads or is refused with a message; one that loads can be inspected and
//! placed in a world.
#![no_main]

use ilon_formats::LoadRobot;
use ilon_robot::Robot;
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    ilon_fuzz::mutate(data, size, max_size, seed, b'<')
});

fuzz_target!(|text: &str| {
    for options in ilon_fuzz::ways() {
        match Robot::from_urdf_str_with(text, "robot.urdf", &options) {
            Ok(loaded) => return ilon_fuzz::use_robot(&loaded.robot),
            Err(error) => assert!(!error.to_string().is_empty() && !error.help().is_empty()),
        }
    }
});
