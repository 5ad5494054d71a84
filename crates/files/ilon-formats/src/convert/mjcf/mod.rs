//! MJCF, the format of MuJoCo: the body of a file in which most wheels are seen.
//!
//! mjcf-rs reads it, with its defaults, classes and angles; what it includes is put in first,
//! through the door through which all files are read, and what it replicates is written out. A
//! body's frame becomes that of its joint; a body of several joints becomes a chain of links.

mod bodies;
mod geoms;
mod includes;
mod mesh_weight;
mod model;
mod replicate;

use std::path::Path;
use std::rc::Rc;

use super::choice::with_most_wheels;
use super::malformed::of_xml;
use crate::error::{Fault, RobotError};
use crate::model::Remark;
use crate::options::LoadOptions;
use crate::urdf::{Meshes, UrdfText};
use crate::xml;
use model::Robot;

/// The URDF of the robot in an MJCF text.
pub(super) fn converted(
    file: &str,
    text: &str,
    options: &LoadOptions,
) -> Result<UrdfText, RobotError> {
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    let whole = includes::put_in(file, text, folder, options)?;
    let whole = replicate::written_out(file, whole)?;
    let whole = Rc::new(whole);
    let text = &whole.text;
    let document = xml::parse(text).map_err(|fault| of_xml(file, text, fault))?;
    includes::refuse_what_is_not_read(file, &whole, &document)?;
    let mut model = mjcf_rs::Model::from_str(text, folder).map_err(|e| {
        let reason = e.to_string();
        RobotError::new(file, Fault::Format { reason })
    })?;
    let bodies = model.bodies.iter_mut();
    bodies.for_each(|entry| {
        entry
            .body
            .geoms
            .iter_mut()
            .for_each(geoms::put_between_ends)
    });
    let roots = Robot::all(&model, &document, file);
    let count = roots.len();
    let meshes = Meshes::beside(file, options);
    let written = roots
        .iter()
        .map(|root| bodies::written(root, &whole, &meshes));
    let Some(robot) = with_most_wheels(written) else {
        let reason = "it holds no body".to_owned();
        return Err(RobotError::new(file, Fault::Format { reason }));
    };
    let mut robot = robot?;
    if count > 1 {
        let words = format!(
            "the robot is that of {count} bodies below the world in which most wheels are seen"
        );
        robot.remarks.push(Remark::new("bodies", words));
    }
    Ok(robot)
}
