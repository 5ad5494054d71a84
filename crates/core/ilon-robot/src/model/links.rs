//! The links of a robot's file, with poses and visual shapes, for **viewers**. The model of the
//! robot itself moves bodies, not links, and visual shapes do not collide.

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
    /// The joint to its parent, by its index in [`LinkTree::joints`]; `None` for the root.
    pub above: Option<usize>,
    /// Its pose in the body frame.
    pub body_from_link: Isometry3<f64>,
    /// Its visual shapes.
    pub visuals: Vec<Visual>,
}

/// A joint between two links.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkJoint {
    /// Its name.
    pub name: String,
    /// The parent link, by its index in [`LinkTree::links`].
    pub parent: usize,
    /// The child link, by its index there.
    pub child: usize,
    /// The child's pose in its parent.
    pub parent_from_child: Isometry3<f64>,
}

/// A visual shape of a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Visual {
    /// Its pose in the link's frame.
    pub link_from_visual: Isometry3<f64>,
    /// Its shape.
    pub shape: VisualShape,
    /// Red, green, blue and opacity, each from 0 to 1; `None` if the file gives none.
    pub color: Option<[f64; 4]>,
}

/// The form of a visual shape, around its own origin.
#[derive(Clone, Debug, PartialEq)]
pub enum VisualShape {
    /// A solid; never a hull.
    Solid(CollisionShape),
    /// A mesh; see [`VisualMeshes::mesh`](super::VisualMeshes::mesh).
    Mesh {
        /// Its name in the file.
        name: String,
        /// Scale of its coordinates along its axes.
        scale: [f64; 3],
    },
}

/// A robot's URDF for viewers, with a link for each wheel and roller, and its links.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RobotDescription {
    /// The text.
    pub urdf: String,
    /// The links of the text.
    pub links: LinkTree,
}

impl LinkTree {
    /// Returns the joint with a name.
    pub fn joint(&self, name: &str) -> Option<&LinkJoint> {
        self.joints.iter().find(|joint| joint.name == name)
    }
}
