//! A robot as it was read, and how it is read.

use std::path::Path;
use std::sync::Arc;

use crate::error::RobotError;
use crate::model::{LinkTree, Robot, VisualMeshes};
use crate::options::{LoadOptions, WheelOptions};
use crate::prepare::{self, prepare};
use crate::urdf::{self, Meshes, Read, UrdfText, WheelOutline};

/// Most rounds of repair: what one round leaves, the next may show.
const MOST_ROUNDS: usize = 8;

/// A robot as it was read, and how well its file models it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Loaded {
    /// The robot.
    pub robot: Robot,
    /// The outline of each wheel as the file models it; of wheels that were given rollers there is none.
    pub outlines: Vec<WheelOutline>,
    /// The rollers that wheels without any were given because of what the file says of them.
    pub inferred: Option<WheelOptions>,
    /// The URDF that was read: the file's own text, or what it was expanded or converted to, with everything repaired.
    pub urdf: Arc<str>,
    /// Where it was read from, and with which options: meshes are found from there.
    read_from: (String, LoadOptions),
}

impl Loaded {
    /// The links of its URDF, and what they show.
    pub fn links(&self) -> Option<LinkTree> {
        urdf::link_tree(&self.urdf)
    }

    /// The meshes by which the robot is seen. Reads their files, which may take a second; what cannot be read is remarked.
    pub fn visual_meshes(&self) -> VisualMeshes {
        let (file, options) = &self.read_from;
        let rollers = self.robot.wheels.iter().flat_map(|wheel| &wheel.rollers);
        let rollers = rollers.map(|roller| roller.name.as_str()).collect();
        urdf::read_looks(&self.urdf, &Meshes::beside(file, options), &rollers)
    }
}

/// Reads a robot from a file as the options say.
pub(crate) fn read_file(path: &Path, options: &LoadOptions) -> Result<Loaded, RobotError> {
    let file = path.display().to_string();
    let text = prepare::read_text(path, &file, options)?;
    read_text(&text, &file, options)
}

/// Reads a robot from the text of a file as the options say, repaired round by round where they ask for that.
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
