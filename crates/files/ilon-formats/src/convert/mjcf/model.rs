//! A robot of a model: one of the bodies below its world, with what hangs on it.

use std::collections::HashMap;

use mjcf_rs::body as mj;
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};
use roxmltree::{Document, Node};

/// The robot of a model: a body below the world.
pub(super) struct Robot<'a, 'i> {
    pub(super) model: &'a mjcf_rs::Model,
    pub(super) file: &'a str,
    /// Where the bodies stand in the text, by their names.
    nodes: HashMap<&'a str, Node<'a, 'i>>,
    pub(super) root_node: Node<'a, 'i>,
    pub(super) root: usize,
    pub(super) below: Vec<Vec<usize>>,
}

impl<'a, 'i> Robot<'a, 'i> {
    /// All that a file may mean, those with the most hinges first.
    pub(super) fn all(
        model: &'a mjcf_rs::Model,
        document: &'a Document<'i>,
        file: &'a str,
    ) -> Vec<Self> {
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

    pub(super) fn name(&self, id: usize) -> String {
        let name = self.model.bodies[id].body.name.clone();
        name.unwrap_or_else(|| format!("body_{id}"))
    }

    pub(super) fn node(&self, id: usize) -> Node<'a, 'i> {
        let name = self.model.bodies[id].body.name.as_deref();
        let node = name.and_then(|name| self.nodes.get(name));
        node.copied().unwrap_or(self.root_node)
    }
}

/// A pose in MuJoCo's words.
pub(super) fn pose(pose: &mjcf_rs::Pose) -> Isometry3<f64> {
    let (p, q) = (pose.translation, pose.rotation);
    Isometry3::from_parts(
        Translation3::from(Point3::new(p.x, p.y, p.z).coords),
        UnitQuaternion::from_quaternion(Quaternion::new(q.w, q.x, q.y, q.z)),
    )
}
