//! Cache of robots shared by runs.

use std::sync::{Arc, Mutex, PoisonError};

use ilon_formats::Loaded;
use ilon_robot::Robot;
use ilon_sim::Error;
use ilon_sim::scenario::Scenario;
use ilon_sim::simulate::load_file;

use crate::hash::Hash;

/// Number of cached robots.
const ROBOTS_KEPT: usize = 32;

/// Cached robots, the last used last, each with the key of its source.
#[derive(Debug, Default)]
pub(crate) struct Robots(Mutex<Vec<(String, Arc<LoadedRobot>)>>);

/// A robot with the hash of its source.
#[derive(Debug)]
pub(crate) struct LoadedRobot {
    pub loaded: Loaded,
    pub urdf_hash: String,
}

/// Returns a robot for inspection without a run, with the motors and rollers' surfaces of the
/// scenario, and the hash of its source. A robot described by a few keys is built directly, which
/// takes a twentieth of the time of reading its URDF.
///
/// # Errors
/// If it cannot be read or built.
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
        // Reading it reports the error.
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
    /// Returns the robot of a scenario, from the cache if possible.
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
