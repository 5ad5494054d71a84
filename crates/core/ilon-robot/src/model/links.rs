//! The links of a robot's file as **viewers** need them: where each hangs, and what it shows. The model of the robot has none of this, for
//! it moves bodies and not links, and nothing touches what is only seen.

use nalgebra::Isometry3;

use super::collision::CollisionShape;

/// The links of a robot's file, with all joints at zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LinkTree {
    /// All links, each after its parent; the first is the root, whose frame is the body frame.
    pub links: Vec<Link>,
    /// The joints between them, in the order of the file.
    pub joints: Vec<LinkJoint>,
}

/// A link.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Link {
    /// Its name.
    pub name: String,
    /// The joint that it hangs by, by its place among [`LinkTree::joints`]; `None` of the root.
    pub above: Option<usize>,
    /// Its pose in the body frame.
    pub body_from_link: Isometry3<f64>,
    /// What it shows.
    pub visuals: Vec<Visual>,
}

/// A joint between two links.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkJoint {
    /// Its name.
    pub name: String,
    /// The link that carries it, by its place among [`LinkTree::links`].
    pub parent: usize,
    /// The link that hangs by it.
    pub child: usize,
    /// The child's pose in its parent.
    pub parent_from_child: Isometry3<f64>,
}

/// A shape that a link shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Visual {
    /// Its pose in the link's frame.
    pub link_from_visual: Isometry3<f64>,
    /// Its shape.
    pub shape: VisualShape,
    /// Red, green, blue and opacity, each from 0 to 1; `None` where the file says none.
    pub color: Option<[f64; 4]>,
}

/// The form of what a link shows, around its own origin.
#[derive(Clone, Debug, PartialEq)]
pub enum VisualShape {
    /// A solid; never a hull.
    Solid(CollisionShape),
    /// A mesh; see [`VisualMeshes::mesh`](super::VisualMeshes::mesh).
    Mesh {
        /// What the file calls it.
        name: String,
        /// By what its coordinates count along its axes.
        scale: [f64; 3],
    },
}

/// A robot's URDF as viewers need it, with a link for each wheel and roller, and its links.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RobotDescription {
    /// The text.
    pub urdf: String,
    /// The links of the text.
    pub links: LinkTree,
}

impl LinkTree {
    /// The joint of a name.
    pub fn joint(&self, name: &str) -> Option<&LinkJoint> {
        self.joints.iter().find(|joint| joint.name == name)
    }
}
