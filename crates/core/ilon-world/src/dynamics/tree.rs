//! The structure of an articulated body: a root, and links on joints.

use ilon_robot::MassProperties;
use nalgebra::{Isometry3, Matrix3, Vector3};

/// Degrees of freedom of a floating root: three of its centre of mass, three of rotation. Joints
/// come after them.
pub(crate) const ROOT_DOFS: usize = 6;

/// The longest chain of joints from the root to a link: a suspension, a rocker, a steered module
/// and its wheel; a lift and an arm of six axes. Chosen.
pub(crate) const DEEPEST: usize = 7;

/// A root and its links.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    /// The root, in a frame whose origin is its centre of mass.
    pub root: MassProperties,
    /// Parents come before their children.
    joints: Vec<Joint>,
    /// Rotation of each joint's link frame in its parent's at joint position zero.
    rotations: Vec<Matrix3<f64>>,
    /// The joints on the way from the root to each joint, one joint after the other.
    ancestors: Vec<u16>,
    /// The first of each joint's entries there, and the end of the last.
    starts: Vec<u32>,
}

/// A joint about or along the z axis of its link's frame, and the link that it moves.
#[derive(Clone, Debug)]
pub(crate) struct Joint {
    /// Index of the carrying link among the joints; `None` for the root.
    pub parent: Option<usize>,
    pub motion: Motion,
    /// The link's frame in its parent's at joint position zero.
    pub parent_from_link: Isometry3<f64>,
    /// The link, in its own frame.
    pub mass: MassProperties,
    /// Inertia that acts only on the joint's rate, such as a motor's rotor behind a gear, in kg m^2
    /// or kg.
    pub armature: f64,
}

/// The motion of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Motion {
    /// Rotation about its axis.
    Turns,
    /// Translation along its axis.
    Slides,
}

/// Pose of a link's frame in the floor's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinkPose {
    /// Its origin, in metres.
    pub center_m: Vector3<f64>,
    /// Rotation from the link's frame to the floor's.
    pub rotation: Matrix3<f64>,
}

impl LinkPose {
    /// The joint's axis.
    pub fn axis(&self) -> Vector3<f64> {
        self.rotation.column(2).into_owned()
    }

    /// A point of the link in the floor's frame, in metres.
    pub fn place_m(&self, in_link_m: &Vector3<f64>) -> Vector3<f64> {
        self.center_m + self.rotation * in_link_m
    }
}

impl Tree {
    /// A tree of joints whose parents come before them; no chain is longer than [`DEEPEST`].
    pub fn new(root: MassProperties, joints: Vec<Joint>) -> Self {
        let (mut ancestors, mut starts) = (Vec::new(), vec![0]);
        for joint in &joints {
            if let Some(parent) = joint.parent {
                let of_parent = starts[parent] as usize..starts[parent + 1] as usize;
                ancestors.extend_from_within(of_parent);
                ancestors.push(parent as u16);
            }
            starts.push(ancestors.len() as u32);
        }
        let rotation = |joint: &Joint| joint.parent_from_link.rotation.to_rotation_matrix();
        Self {
            root,
            rotations: joints
                .iter()
                .map(|joint| rotation(joint).into_inner())
                .collect(),
            joints,
            ancestors,
            starts,
        }
    }

    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Degrees of freedom.
    pub fn dofs(&self) -> usize {
        ROOT_DOFS + self.joints.len()
    }

    /// The joints on the way from the root to a joint, without itself.
    pub fn ancestors(&self, joint: usize) -> &[u16] {
        &self.ancestors[self.entries_of(joint)]
    }

    /// The range of a joint's couplings with its ancestors among those of all joints.
    pub(super) fn entries_of(&self, joint: usize) -> std::ops::Range<usize> {
        self.starts[joint] as usize..self.starts[joint + 1] as usize
    }

    /// The total number of couplings of joints with their ancestors.
    pub(super) fn entries(&self) -> usize {
        self.ancestors.len()
    }

    /// The path from the root to a joint, with a coefficient for each joint on it.
    pub fn path(&self, joint: usize, share: impl Fn(usize) -> f64) -> Path {
        let mut path = Path::NONE;
        let above = self.ancestors(joint).iter().map(|at| usize::from(*at));
        for at in above.chain([joint]) {
            path.joints[path.length] = at as u16;
            path.shares[path.length] = share(at);
            path.length += 1;
        }
        path
    }

    /// Places all links, given the root's pose and the position of each joint, in rad or m.
    pub fn place(&self, root: &LinkPose, moved: &[f64], links: &mut [LinkPose]) {
        let joints = self.joints.iter().zip(&self.rotations).zip(moved);
        for (index, ((joint, at_zero), moved)) in joints.enumerate() {
            let parent = joint.parent.map_or(root, |parent| &links[parent]);
            let center_m = parent.place_m(&joint.parent_from_link.translation.vector);
            let rotation = parent.rotation * at_zero;
            let axis = rotation.column(2).into_owned();
            links[index] = match joint.motion {
                Motion::Turns => {
                    let (sin, cos) = libm::sincos(*moved);
                    let (x, y) = (rotation.column(0), rotation.column(1));
                    let turned = [cos * x + sin * y, cos * y - sin * x, axis];
                    LinkPose {
                        center_m,
                        rotation: Matrix3::from_columns(&turned),
                    }
                }
                Motion::Slides => LinkPose {
                    center_m: center_m + *moved * axis,
                    rotation,
                },
            };
        }
    }
}

/// Coefficients of the joints on the path from the root to a link.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Path {
    joints: [u16; DEEPEST],
    shares: [f64; DEEPEST],
    length: usize,
}

impl Path {
    /// The empty path at the root.
    pub const NONE: Self = Self {
        joints: [0; DEEPEST],
        shares: [0.0; DEEPEST],
        length: 0,
    };

    /// Each joint with its coefficient, starting at the root.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = (usize, f64)> {
        let joints = self.joints.iter().map(|joint| usize::from(*joint));
        joints.zip(self.shares).take(self.length)
    }

    /// The product of the coefficients over all joints that are on both paths.
    #[inline]
    pub fn dot(&self, other: &Self) -> f64 {
        let both = self.length.min(other.length);
        let mut sum = 0.0;
        // Paths that have parted do not meet again.
        for at in 0..both {
            if self.joints[at] != other.joints[at] {
                break;
            }
            sum += self.shares[at] * other.shares[at];
        }
        sum
    }

    /// The same path with coefficients of the opposite sign.
    pub fn reversed(&self) -> Self {
        Self {
            shares: self.shares.map(|share| -share),
            ..*self
        }
    }

    /// Its joints, and their mutable coefficients.
    #[inline]
    pub(super) fn parts_mut(&mut self) -> (&[u16], &mut [f64]) {
        (&self.joints[..self.length], &mut self.shares[..self.length])
    }
}
