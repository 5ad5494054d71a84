//! Robots that runs have in common, read once.

use std::sync::{Arc, Mutex, PoisonError};

use ilon_formats::Loaded;
use ilon_robot::Robot;
use ilon_sim::Error;
use ilon_sim::scenario::Scenario;
use ilon_sim::simulate::load_file;

use crate::hash::Hash;

/// Robots that are kept for further runs.
const ROBOTS_KEPT: usize = 32;

/// Robots that were read, the last used last, each under what it was read from.
#[derive(Debug, Default)]
pub(crate) struct Robots(Mutex<Vec<(String, Arc<LoadedRobot>)>>);

/// A robot that was read, and the hash of what it was read from.
#[derive(Debug)]
pub(crate) struct LoadedRobot {
    pub loaded: Loaded,
    pub urdf_hash: String,
}

/// A robot that is looked at without a run, with the motors and the rollers' surfaces that the scenario gives it, and the hash of what it was
/// read from. One that is described in a few keys is made of them at once, which takes a twentieth of the time of reading its URDF.
///
/// # Errors
/// Where it cannot be read, or made.
pub(crate) fn design(robots: &Robots, scenario: &Scenario) -> Result<(Robot, String), Error> {
    let options = scenario
        .robot
        .load_options(&scenario.folder, &scenario.files);
    let path = scenario.resolve(&scenario.robot.file);
    let described = ilon_formats::described(&path, &options).unwrap_or_default();
    let (mut robot, hash) = match described {
        Some((robot, spec)) => {
            let hash = Hash::of(&[&format!("{spec:?}")]);
            (robot, hash)
        }
        // What is wrong with it, reading says.
        None => {
            let known = robots.of(scenario)?;
            (known.loaded.robot.clone(), known.urdf_hash.clone())
        }
    };
    scenario.motors.apply(&mut robot);
    scenario.rollers.apply(&mut robot)?;
    Ok((robot, hash))
}

impl Robots {
    /// The robot of a scenario, which is read unless one of the last runs had the same.
    pub fn of(&self, scenario: &Scenario) -> Result<Arc<LoadedRobot>, Error> {
        let options = scenario
            .robot
            .load_options(&scenario.folder, &scenario.files);
        let source = format!("{:?} {options:?}", scenario.resolve(&scenario.robot.file));
        let find = || {
            let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let at = kept.iter().position(|(known, _)| *known == source)?;
            let found = kept.remove(at);
            let robot = Arc::clone(&found.1);
            kept.push(found);
            Some(robot)
        };
        if let Some(robot) = find() {
            return Ok(robot);
        }
        let loaded = load_file(scenario)?;
        let urdf_hash = Hash::of(&[&loaded.urdf]);
        let robot = Arc::new(LoadedRobot { loaded, urdf_hash });
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.push((source, Arc::clone(&robot)));
        if kept.len() > ROBOTS_KEPT {
            kept.remove(0);
        }
        Ok(robot)
    }
}
