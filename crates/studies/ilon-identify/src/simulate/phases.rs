//! Initial roller angles of the simulated wheels.

use std::f64::consts::TAU;

use ilon_robot::Robot;
use nalgebra::Rotation3;

use super::config::Simulate;

/// Offset between the sets of one drive and of the next in the same sequence, so that drives do not
/// share the effects of a set.
const SETS_OF_A_DRIVE: u32 = 97;

/// Initial wheel angles of the simulated drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Starts {
    /// Those of the robot's file.
    File,
    /// Those of the log.
    Log,
    /// This many sets that fill all combinations evenly.
    Sets(u32),
}

impl Starts {
    /// The number of simulations per drive.
    pub fn count(self) -> u32 {
        match self {
            Self::File | Self::Log => 1,
            Self::Sets(count) => count,
        }
    }
}

/// Returns the angle of each wheel's rollers ahead of the robot's file at the start of a drive, in
/// radians, for one of many sets. Wheels that are in phase by the study start alike. Other seeds
/// give other sets, which fill all combinations equally evenly.
pub(super) fn set(
    section: &Simulate,
    robot: &Robot,
    seed: u32,
    drive: usize,
    index: u32,
) -> Vec<f64> {
    let together = section.ripple.iter().flat_map(|ripple| &ripple.together);
    let groups: Vec<&Vec<String>> = together.collect();
    let group_of = |wheel: usize| {
        let name = &robot.wheels[wheel].name;
        let group = groups.iter().position(|names| names.contains(name));
        group.unwrap_or(groups.len() + wheel)
    };
    // The first element of the sequence has all wheels in phase, which is not random.
    let place = f64::from(1 + index) + drive as f64 * f64::from(SETS_OF_A_DRIVE);
    (0..robot.wheels.len())
        .map(|wheel| {
            // Steps by roots of primes fill the phases of all wheels evenly.
            const PRIMES: [f64; 12] = [
                2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0,
            ];
            let prime = PRIMES[group_of(wheel) % PRIMES.len()];
            let root = prime.sqrt();
            let begun = (f64::from(seed) * libm::cbrt(prime)).fract();
            let rollers = robot.wheels[wheel].rollers.len().max(1) as f64;
            // Evenly within a roller, and on any of them: rollers may differ, and those of two rows
            // do.
            let within = (place * root + begun).fract();
            let roller = ((place * root.sqrt() + begun).fract() * rollers).floor();
            (within + roller) * TAU / rollers
        })
        .collect()
}

/// Returns the robot with each wheel's rollers turned about its hub, in radians.
pub(super) fn turned(mut robot: Robot, by_rad: &[f64]) -> Robot {
    for (wheel, by_rad) in robot.wheels.iter_mut().zip(by_rad) {
        let turn = Rotation3::from_axis_angle(&nalgebra::Vector3::z_axis(), *by_rad);
        for roller in &mut wheel.rollers {
            roller.center_in_hub_m = turn * roller.center_in_hub_m;
            roller.axis_in_hub = turn * roller.axis_in_hub;
        }
    }
    robot
}
