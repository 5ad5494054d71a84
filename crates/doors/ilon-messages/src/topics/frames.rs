//! The frames of a robot: which link hangs on which, and how wheels and rollers turn them.

use std::collections::{HashMap, HashSet};

use ilon_robot::{BodyJoint, JointKind, Robot};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

/// A frame in its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct Fixed {
    /// The parent.
    pub parent: String,
    /// The frame.
    pub child: String,
    /// Its pose in the parent.
    pub parent_from_child: Isometry3<f64>,
}

/// A frame that turns in its parent, or slides.
#[derive(Clone, Debug, PartialEq)]
pub struct Turning {
    /// The parent.
    pub parent: String,
    /// The frame.
    pub child: String,
    /// Pose in the parent of the frame about whose z axis it turns.
    parent_from_axis: Isometry3<f64>,
    /// Pose of the child in that frame at angle zero.
    axis_from_child: Isometry3<f64>,
    /// Whether it slides along that axis.
    slides: bool,
}

impl Turning {
    /// The child's pose in the parent at an angle in radians, or at a place in metres of one that slides.
    pub fn at(&self, angle_rad: f64) -> Isometry3<f64> {
        if self.slides {
            let along = Translation3::new(0.0, 0.0, angle_rad);
            return self.parent_from_axis * along * self.axis_from_child;
        }
        let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_rad);
        self.parent_from_axis * turned * self.axis_from_child
    }
}

/// The tree of a robot's links. Every link hangs in it once.
#[derive(Clone, Debug, PartialEq)]
pub struct Frames {
    /// The link that carries all others: the body frame.
    pub base: String,
    /// Links that do not move against their parents.
    pub fixed: Vec<Fixed>,
    /// The link of each joint between bodies, in the robot's order.
    pub joints: Vec<Turning>,
    /// The link of each wheel, in the robot's order.
    pub wheels: Vec<Turning>,
    /// The link of each roller, wheel by wheel.
    pub rollers: Vec<Turning>,
}

impl Frames {
    /// The frames of a robot whose URDF has a joint for each of its wheels and rollers, as that of
    /// [`robot_description`](super::robot_description) has. `None` of any other text.
    pub fn of(robot: &Robot, urdf: &str) -> Option<Self> {
        let document = Document::parse(urdf).ok()?;
        let tree = Tree::of(&document)?;
        let turning = |joint: &str, body_from_axis: Isometry3<f64>| {
            let joint = tree.joints.iter().find(|known| known.name == joint)?;
            let body_from_parent = tree.placed.get(joint.parent)?;
            let body_from_child = tree.placed.get(joint.child)?;
            Some(Turning {
                parent: joint.parent.to_owned(),
                child: joint.child.to_owned(),
                parent_from_axis: body_from_parent.inverse() * body_from_axis,
                axis_from_child: body_from_axis.inverse() * body_from_child,
                slides: false,
            })
        };
        let joint = |joint: &BodyJoint| {
            Some(Turning {
                slides: joint.kind == JointKind::Slides,
                ..turning(&joint.name, joint.body_from_joint)?
            })
        };
        // A description that was made of the robot's wheels alone has none of them.
        let joints: Option<Vec<Turning>> = robot.joints.iter().map(joint).collect();
        let joints = joints.unwrap_or_default();
        let mut wheels = Vec::with_capacity(robot.wheels.len());
        let mut rollers = Vec::new();
        for wheel in &robot.wheels {
            wheels.push(turning(&wheel.name, wheel.body_from_hub)?);
            for roller in &wheel.rollers {
                let body_from_roller = wheel.body_from_hub * roller.hub_from_roller();
                rollers.push(turning(&roller.name, body_from_roller)?);
            }
        }
        let moving: HashSet<&str> = wheels
            .iter()
            .chain(&rollers)
            .chain(&joints)
            .map(|frame| frame.child.as_str())
            .collect();
        // A joint that the simulation does not move stays at zero.
        let fixed = tree
            .joints
            .iter()
            .filter(|joint| !moving.contains(joint.child))
            .map(|joint| Fixed {
                parent: joint.parent.to_owned(),
                child: joint.child.to_owned(),
                parent_from_child: joint.parent_from_child,
            })
            .collect();
        Some(Self {
            base: tree.root.to_owned(),
            fixed,
            joints,
            wheels,
            rollers,
        })
    }

    /// A name near this one that no link bears.
    pub fn free_name(&self, wanted: &str) -> String {
        let links = self.wheels.iter().chain(&self.rollers).chain(&self.joints);
        let taken: HashSet<&str> = links
            .map(|frame| frame.child.as_str())
            .chain(self.fixed.iter().map(|frame| frame.child.as_str()))
            .chain([self.base.as_str()])
            .collect();
        let mut name = wanted.to_owned();
        while taken.contains(name.as_str()) {
            name.push('_');
        }
        name
    }
}

/// A joint of a file, at zero.
pub(super) struct Joint<'a> {
    pub name: &'a str,
    pub parent: &'a str,
    pub child: &'a str,
    parent_from_child: Isometry3<f64>,
}

/// The links of a file, placed with all joints at zero.
pub(super) struct Tree<'a> {
    pub root: &'a str,
    pub joints: Vec<Joint<'a>>,
    /// Pose of each link in the root's frame.
    pub placed: HashMap<&'a str, Isometry3<f64>>,
}

impl<'a> Tree<'a> {
    /// The tree of a URDF; `None` of what is no tree.
    pub fn of(document: &'a Document<'_>) -> Option<Self> {
        let robot = document.root_element();
        let joints: Vec<Joint> = robot
            .children()
            .filter(|node| node.has_tag_name("joint"))
            .filter_map(|node| {
                let end = |tag| child(node, tag)?.attribute("link");
                Some(Joint {
                    name: node.attribute("name")?,
                    parent: end("parent")?,
                    child: end("child")?,
                    parent_from_child: origin(node),
                })
            })
            .collect();
        let children: HashSet<&str> = joints.iter().map(|joint| joint.child).collect();
        let links = robot.children().filter(|node| node.has_tag_name("link"));
        let root = links
            .filter_map(|node| node.attribute("name"))
            .find(|link| !children.contains(link))?;
        let mut below: HashMap<&str, Vec<&Joint>> = HashMap::new();
        for joint in &joints {
            below.entry(joint.parent).or_default().push(joint);
        }
        let mut placed = HashMap::from([(root, Isometry3::identity())]);
        let mut waiting = vec![root];
        while let Some(link) = waiting.pop() {
            let body_from_link = placed[link];
            for joint in below.get(link).into_iter().flatten() {
                if placed.contains_key(joint.child) {
                    return None;
                }
                placed.insert(joint.child, body_from_link * joint.parent_from_child);
                waiting.push(joint.child);
            }
        }
        Some(Self {
            root,
            joints,
            placed,
        })
    }
}

/// The first child element of a name.
pub(super) fn child<'a, 'input>(node: Node<'a, 'input>, tag: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|inner| inner.has_tag_name(tag))
}

/// Where an element's `<origin>` puts it.
fn origin(node: Node<'_, '_>) -> Isometry3<f64> {
    let three = |name| -> Vector3<f64> {
        let text = child(node, "origin").and_then(|origin| origin.attribute(name));
        let numbers = text.unwrap_or_default().split_whitespace();
        let numbers: Vec<f64> = numbers.filter_map(|number| number.parse().ok()).collect();
        match numbers[..] {
            [x, y, z] => Vector3::new(x, y, z),
            _ => Vector3::zeros(),
        }
    };
    let (xyz, rpy) = (three("xyz"), three("rpy"));
    Isometry3::from_parts(
        Translation3::from(xyz),
        UnitQuaternion::from_euler_angles(rpy.x, rpy.y, rpy.z),
    )
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    /// `rpy` turns about x, then y, then z of the parent: a yaw of a quarter turn takes x to y, a pitch x to -z, a roll y to z.
    #[test]
    fn an_origin_turns_by_its_roll_pitch_and_yaw() {
        let placed = |rpy: &str| {
            let text = format!("<joint><origin xyz=\"1 2 3\" rpy=\"{rpy}\"/></joint>");
            let document = Document::parse(&text).expect("XML");
            origin(document.root_element())
        };
        let quarter = FRAC_PI_2;
        for (rpy, from, to) in [
            (format!("0 0 {quarter}"), Vector3::x(), Vector3::y()),
            (format!("0 {quarter} 0"), Vector3::x(), -Vector3::z()),
            (format!("{quarter} 0 0"), Vector3::y(), Vector3::z()),
            // Roll first: y goes to z, and by the yaw stays there; x goes to y by the yaw alone.
            (format!("{quarter} 0 {quarter}"), Vector3::y(), Vector3::z()),
            (format!("{quarter} 0 {quarter}"), Vector3::x(), Vector3::y()),
        ] {
            let parent_from_child = placed(&rpy);
            assert!(
                (parent_from_child.rotation * from - to).norm() < 1e-15,
                "{rpy}"
            );
            assert_eq!(
                parent_from_child.translation.vector,
                Vector3::new(1.0, 2.0, 3.0)
            );
        }
    }
}
