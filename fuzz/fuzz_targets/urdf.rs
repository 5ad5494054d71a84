//! A damaged robot file loads or is refused with a message; one that loads can be inspected and
//! placed in a world.
#![no_main]

use std::sync::LazyLock;

use ilon::Scenario;
use ilon::inspect::Inspection;
use ilon::simulate::{Driver, Plant, resolve_for};
use ilon_formats::{Handedness, LoadOptions, LoadRobot, WheelOptions};
use ilon_robot::Robot;
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

/// More rollers than this are slow to simulate, which is known.
const MOST_ROLLERS_SIMULATED: usize = 40;

static SIDEWAYS: LazyLock<Scenario> = LazyLock::new(|| {
    let text = "[robot]\nfile = \"robot.urdf\"\nroller_bodies = \"near\"\n[twist]\nvy_m_s = 0.1\n[run]\nduration_s = 1";
    Scenario::from_toml(text, "sideways", ".").expect("the scenario is a good one")
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    ilon_fuzz::mutate(data, size, max_size, seed, b'<')
});

fuzz_target!(|text: &str| {
    let plain = LoadOptions::default();
    let mended = options(|o| {
        o.repair = true;
    });
    let given = options(|o| {
        o.repair = true;
        o.wheels = Some(WheelOptions::new(5, Handedness::AllDeg(45.0)));
    });
    for options in [plain, mended, given] {
        match Robot::from_urdf_str_with(text, "robot.urdf", &options) {
            Ok(loaded) => {
                use_it(&loaded.robot);
                return;
            }
            Err(error) => assert!(!error.to_string().is_empty() && !error.help().is_empty()),
        }
    }
});

fn options(change: impl FnOnce(&mut LoadOptions)) -> LoadOptions {
    let mut options = LoadOptions::default();
    change(&mut options);
    options
}

fn use_it(robot: &Robot) {
    if let Ok(inspection) = Inspection::of(robot) {
        assert!(inspection.wheels.iter().all(|wheel| wheel.radius_m > 0.0));
    }
    let rollers: usize = robot.wheels.iter().map(|wheel| wheel.rollers.len()).sum();
    if rollers > MOST_ROLLERS_SIMULATED {
        return;
    }
    let resolved = resolve_for(&SIDEWAYS, robot, Driver::Guidance);
    if let Ok(mut plant) = resolved.and_then(|resolved| Plant::new(&resolved, robot)) {
        ilon_fuzz::drive(&mut plant);
    }
}
