//! MJCF, the format of MuJoCo: the body of a file in which most wheels are seen.
//!
//! mjcf-rs reads it, with its defaults, classes and angles; what it includes is put in first, through the door through which all
//! files are read, and what it replicates is written out. A body's frame becomes that of its joint; a body of several joints becomes a chain of links.

mod bodies;
mod geoms;
mod includes;
mod replicate;

use std::collections::HashMap;
use std::path::Path;

use mjcf_rs::body as mj;
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};
use roxmltree::{Document, Node};

use crate::error::{Fault, RobotError};
use crate::model::Remark;
use crate::options::LoadOptions;
use crate::urdf::Prepared;
use crate::xml;

/// The URDF of the robot in an MJCF text.
pub(super) fn converted(
    file: &str,
    text: &str,
    options: &LoadOptions,
) -> Result<Prepared, RobotError> {
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    let whole = includes::put_in(file, text, folder, options)?;
    let whole = replicate::written_out(file, whole)?;
    let document = xml::parse(&whole).map_err(|fault| of_xml(file, &whole, fault))?;
    includes::refuse_what_is_not_read(file, &whole, &document)?;
    let model = mjcf_rs::Model::from_str(&whole, folder).map_err(|e| {
        let reason = e.to_string();
        RobotError::new(file, Fault::Format { reason })
    })?;
    let roots = Robot::all(&model, &document, file);
    let count = roots.len();
    let written = roots.iter().map(|root| bodies::written(root, &whole));
    let Some(robot) = super::with_most_wheels(written) else {
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

fn of_xml(file: &str, text: &str, fault: xml::Fault) -> RobotError {
    match fault {
        xml::Fault::Malformed(reason, bytes) => {
            RobotError::new(file, Fault::Xml { reason }).at(&text.into(), bytes)
        }
        xml::Fault::TooMuch(what, most, _) => RobotError::new(file, Fault::TooLarge { what, most }),
    }
}

/// The robot of a model: a body below the world.
struct Robot<'a, 'i> {
    model: &'a mjcf_rs::Model,
    file: &'a str,
    /// Where the bodies stand in the text, by their names.
    nodes: HashMap<&'a str, Node<'a, 'i>>,
    root_node: Node<'a, 'i>,
    root: usize,
    below: Vec<Vec<usize>>,
}

impl<'a, 'i> Robot<'a, 'i> {
    /// All that a file may mean, those with the most hinges first.
    fn all(model: &'a mjcf_rs::Model, document: &'a Document<'i>, file: &'a str) -> Vec<Self> {
        /// Most that are looked at.
        const MOST: usize = 20;
        let root_node = document.root_element();
        let nodes: HashMap<&str, Node> = root_node
            .descendants()
            .filter(|n| n.has_tag_name("body"))
            .filter_map(|n| Some((n.attribute("name")?, n)))
            .collect();
        let mut below = vec![Vec::new(); model.bodies.len()];
        for (id, entry) in model.bodies.iter().enumerate().skip(1) {
            if let Some(parent) = entry.parent.filter(|parent| *parent < id) {
                below[parent].push(id);
            }
        }
        // Parents stand before their children.
        let hinge = |joint: &&mj::Joint| joint.type_ == mj::JointType::Hinge;
        let mut hinges: Vec<usize> = model
            .bodies
            .iter()
            .map(|entry| entry.body.joints.iter().filter(hinge).count())
            .collect();
        for id in (1..model.bodies.len()).rev() {
            if let Some(parent) = model.bodies[id].parent.filter(|parent| *parent < id) {
                hinges[parent] += hinges[id];
            }
        }
        let mut roots = below.first().cloned().unwrap_or_default();
        roots.sort_by_key(|id| std::cmp::Reverse(hinges[*id]));
        let robot = |root| Self {
            model,
            file,
            nodes: nodes.clone(),
            root_node,
            root,
            below: below.clone(),
        };
        roots.into_iter().take(MOST).map(robot).collect()
    }

    fn name(&self, id: usize) -> String {
        let name = self.model.bodies[id].body.name.clone();
        name.unwrap_or_else(|| format!("body_{id}"))
    }

    fn node(&self, id: usize) -> Node<'a, 'i> {
        let name = self.model.bodies[id].body.name.as_deref();
        let node = name.and_then(|name| self.nodes.get(name));
        node.copied().unwrap_or(self.root_node)
    }
}

/// A pose in MuJoCo's words.
fn pose(pose: &mjcf_rs::Pose) -> Isometry3<f64> {
    let (p, q) = (pose.translation, pose.rotation);
    Isometry3::from_parts(
        Translation3::from(Point3::new(p.x, p.y, p.z).coords),
        UnitQuaternion::from_quaternion(Quaternion::new(q.w, q.x, q.y, q.z)),
    )
}
