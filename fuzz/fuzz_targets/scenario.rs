//! A damaged scenario is refused with a message; or its encoded form loads to the same scenario,
//! and its first steps can be taken, with its own guidance and from outside.
#![no_main]

use std::sync::LazyLock;

use ilon::Scenario;
use ilon::simulate::{Driver, Plant, Simulation, resolve_for};
use ilon_formats::LoadRobot;
use ilon_robot::Robot;
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

static ROBOT: LazyLock<Robot> = LazyLock::new(|| {
    let urdf = include_str!("../../assets/robots/volksbot.urdf");
    Robot::from_urdf_str(urdf, "volksbot.urdf").expect("the robot is a good one")
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    ilon_fuzz::mutate(data, size, max_size, seed, b'\n')
});

fuzz_target!(|text: &str| {
    let scenario = match Scenario::from_toml(text, "fuzzed", "../assets/scenarios") {
        Ok(scenario) => scenario,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    let once = scenario.to_toml().expect("what was read can be written");
    let again =
        Scenario::from_toml(&once, "fuzzed", "../assets/scenarios").expect("and read again");
    assert_eq!(once, again.to_toml().expect("and written again"));
    if let Ok(mut simulation) = Simulation::with_robot(&scenario, &ROBOT) {
        for _ in 0..3 {
            simulation.step();
        }
    }
    let resolved = resolve_for(&scenario, &ROBOT, Driver::Own);
    if let Ok(mut plant) = resolved.and_then(|resolved| Plant::new(&resolved, &ROBOT)) {
        ilon_fuzz::drive(&mut plant);
    }
});
