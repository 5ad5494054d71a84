//! Reads a robot from URDF.
//!
//! In this order: the text is held against the form of URDF ([`source`], [`form`]), urdf-rs reads it, its links and joints
//! become a tree placed in the body frame ([`tree`]), wheels and rollers are recognised and measured ([`wheels`],
//! [`roller`]), and the whole is checked ([`whole`]). Faults are errors; what is ignored, assumed or doubted is remarked.

mod form;
mod roller;
mod source;
mod tree;
mod wheels;
mod whole;

use std::collections::HashSet;
use std::path::Path;

use crate::error::{Fault, RobotError};
use crate::model::{Remark, Robot};
use source::Source;
use tree::Tree;

impl Robot {
    /// Reads a robot from a URDF file.
    ///
    /// # Errors
    /// A file that cannot be read, that is not URDF, or whose robot is not an omnidirectional one that can be simulated:
    /// every [`Fault`], with its place in the file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, RobotError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|e| {
            let reason = e.to_string();
            RobotError::new(&file, Fault::Unreadable { reason })
        })?;
        let text = String::from_utf8(bytes).map_err(|e| {
            let reason = format!("it is not text: {e}");
            RobotError::new(&file, Fault::Xml { reason })
        })?;
        Self::from_urdf_str(&text, &file)
    }

    /// Reads a robot from the text of a URDF file; `file` is what errors call it.
    ///
    /// # Errors
    /// As [`Robot::load`], but for reading the file.
    pub fn from_urdf_str(text: &str, file: &str) -> Result<Self, RobotError> {
        let source = Source::parse(text, file)?;
        form::check(&source)?;
        let urdf = urdf_rs::read_from_string(text).map_err(|e| {
            let reason = e.to_string();
            RobotError::new(file, Fault::Urdf { reason })
        })?;

        let name = urdf.name.clone();
        let mut remarks = Vec::new();
        let tree = Tree::build(&source, urdf, &mut remarks)?;
        let candidates = wheels::find(&tree);
        whole::check_wheel_count(&source, &tree, &candidates)?;

        let moving: HashSet<usize> = candidates
            .iter()
            .flat_map(|c| c.rollers.iter().copied().chain([c.hub]))
            .collect();
        let rigid_body = |link| tree.rigid_body(link, |j| moving.contains(&j));
        let chassis_body = rigid_body(tree.root);
        whole::remark_held(&tree, &chassis_body, "the chassis", &mut remarks);
        let mut wheels = Vec::with_capacity(candidates.len());
        for candidate in &candidates {
            let joint = &tree.joints[candidate.hub];
            let hub_body = rigid_body(joint.child);
            whole::remark_held(
                &tree,
                &hub_body,
                &format!("wheel `{}`", joint.name),
                &mut remarks,
            );
            wheels.push(wheels::measure(
                &source,
                &tree,
                candidate,
                &hub_body,
                &mut remarks,
            )?);
        }
        let chassis = whole::chassis(&source, &tree, chassis_body, &mut remarks)?;
        remarks.extend(source.ignored_elements());
        let robot = Self {
            name,
            chassis,
            wheels,
            remarks,
        };
        whole::check(&source, robot)
    }
}

/// A remark about an element.
fn remark(subject: impl Into<String>, text: impl Into<String>) -> Remark {
    Remark {
        subject: subject.into(),
        text: text.into(),
    }
}
