//! A loaded robot, and how it is loaded.

use std::path::Path;
use std::sync::Arc;

use crate::error::RobotError;
use crate::model::{LinkTree, Robot, VisualMeshes};
use crate::options::{LoadOptions, WheelOptions};
use crate::prepare::{self, prepare};
use crate::urdf::{self, Meshes, Read, UrdfText, WheelOutline};

/// Largest number of repair rounds: each round may reveal new faults.
const MOST_ROUNDS: usize = 8;

/// A loaded robot, with the quality of its model.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Loaded {
    /// The robot.
    pub robot: Robot,
    /// The outline of each wheel as modelled in the file; empty for wheels that were given rollers.
    pub outlines: Vec<WheelOutline>,
    /// The rollers that were inferred from the file for wheels without any.
    pub inferred: Option<WheelOptions>,
    /// The URDF that was read: the file's own text, or its expansion or conversion, including
    /// repairs.
    pub urdf: Arc<str>,
    /// Its path and options, used to find meshes.
    read_from: (String, LoadOptions),
}

impl Loaded {
    /// Returns the links of its URDF, with their visual shapes.
    pub fn links(&self) -> Option<LinkTree> {
        urdf::link_tree(&self.urdf)
    }

    /// Returns the visual meshes of the robot. It reads their files, which may take a second;
    /// unreadable ones give remarks.
    pub fn visual_meshes(&self) -> VisualMeshes {
        let (file, options) = &self.read_from;
        let rollers = self.robot.wheels.iter().flat_map(|wheel| &wheel.rollers);
        let rollers = rollers.map(|roller| roller.name.as_str()).collect();
        urdf::read_looks(&self.urdf, &Meshes::beside(file, options), &rollers)
    }
}

/// Reads a robot from a file with options.
pub(crate) fn read_file(path: &Path, options: &LoadOptions) -> Result<Loaded, RobotError> {
    let file = path.display().to_string();
    let text = prepare::read_text(path, &file, options)?;
    read_text(&text, &file, options)
}

/// Reads a robot from the text of a file with options, repaired round by round if requested.
pub(crate) fn read_text(
    text: &str,
    file: &str,
    options: &LoadOptions,
) -> Result<Loaded, RobotError> {
    let mut prepared = prepare(text, file, options)?;
    let mut rounds = 0;
    loop {
        rounds += 1;
        let may_repair = options.repair && rounds <= MOST_ROUNDS;
        let repair = if options.repair {
            urdf::repaired
        } else {
            urdf::with_light_parts_repaired
        };
        let repaired = match urdf::read(&prepared, options) {
            Ok(read) => {
                let level = may_repair.then(|| urdf::levelled(&prepared, &read.robot));
                match level.flatten() {
                    Some(level) => level,
                    None => return Ok(loaded(read, &prepared, options)),
                }
            }
            Err(error) => {
                let repaired = (rounds <= MOST_ROUNDS).then(|| repair(&prepared, &error, options));
                repaired.flatten().ok_or(error)?
            }
        };
        prepared = repaired;
    }
}

fn loaded(read: Read, prepared: &UrdfText, options: &LoadOptions) -> Loaded {
    let Read {
        robot,
        outlines,
        inferred,
    } = read;
    Loaded {
        robot,
        outlines,
        inferred,
        urdf: Arc::clone(&prepared.text),
        read_from: (prepared.file.clone(), options.clone()),
    }
}
