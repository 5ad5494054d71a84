//! Reads the robot of a scenario.

use ilon_formats::LoadRobot;
use ilon_formats::Loaded;
use ilon_robot::Robot;

use crate::Error;
use crate::robot::remedy;
use crate::scenario::Scenario;

/// Reads the robot of a scenario, with the scenario's motors and roller surfaces.
///
/// # Errors
/// [`Error::Robot`], with all faults of the file and the keys that would repair them.
pub fn load_robot(scenario: &Scenario) -> Result<Robot, Error> {
    load(scenario).map(|loaded| loaded.robot)
}

/// Like [`load_robot`], but keeps the text that the robot was read from.
///
/// # Errors
/// Like [`load_robot`].
pub fn load(scenario: &Scenario) -> Result<Loaded, Error> {
    let mut loaded = load_file(scenario).map_err(|error| scenario.source.placed(error))?;
    scenario.motors.apply(&mut loaded.robot);
    scenario.rollers.apply(&mut loaded.robot)?;
    Ok(loaded)
}

/// Reads the robot of a scenario from its file and the scenario's `[robot]`.
///
/// # Errors
/// If the file cannot be read, or is not a robot that ilon can drive.
pub fn load_file(scenario: &Scenario) -> Result<Loaded, Error> {
    let options = scenario
        .robot
        .load_options(&scenario.folder, &scenario.files);
    let path = scenario.resolve(&scenario.robot.file);
    match Robot::load_with(&path, &options) {
        Ok(loaded) => Ok(loaded),
        Err(fault) => Err(remedy::diagnosed(fault, &path, &options, &remedy::Keys)),
    }
}
