//! The kinematic tree with every joint at zero.

use std::collections::HashMap;

use nalgebra::{Isometry3, Point3, Unit, Vector3};

use super::faults::Faults;
use super::source::Source;
use crate::error::{Fault, RobotError};
use crate::model::{Joint, MassProperties, MotorLimits};

/// Smallest vertical component of a steering joint's axis, as a cosine.
const UPRIGHT: f64 = 0.9;

/// The links and joints of a text.
pub(super) type Parts = (Vec<LinkPart>, Vec<JointPart>);

/// A link that is not placed yet: its shapes are in its frame.
pub(super) struct LinkPart {
    pub(super) link: TreeLink,
    /// Its mass properties in the frame of `<inertial>`, and the pose of that in the link's frame.
    pub(super) mass: Option<(MassProperties, Isometry3<f64>)>,
}

/// A joint that is not placed yet.
pub(super) struct JointPart {
    pub(super) joint: TreeJoint,
    /// The links that it joins.
    pub(super) parent: String,
    pub(super) child: String,
    pub(super) parent_from_joint: Isometry3<f64>,
    /// The axis in the joint's frame.
    pub(super) axis: Vector3<f64>,
}

/// All links and joints of a robot, placed in the body frame, which is the frame of the root link.
pub(super) struct Tree {
    pub(super) links: Vec<TreeLink>,
    pub(super) joints: Vec<TreeJoint>,
    pub(super) root: usize,
    /// For each link the joint above it.
    above: Vec<Option<usize>>,
    /// For each joint the nearest turning joint above it.
    turning_above: Vec<Option<usize>>,
    /// For each joint the nearest joint above it that turns within limits about an upright axis.
    swivel_above: Vec<Option<usize>>,
    /// For each joint a turning joint below it.
    turning_below: Vec<Option<usize>>,
}

/// A link with its pose.
pub(super) struct TreeLink {
    pub(super) name: String,
    /// Mass properties in the body frame; `None` for a link without mass.
    pub(super) mass: Option<MassProperties>,
    /// Collision geometry with its pose in the body frame.
    pub(super) shapes: Vec<PlacedShape>,
    /// Visual shapes with their poses in the body frame.
    pub(super) visuals: Vec<PlacedShape>,
    /// Pose of its frame in the body frame.
    pub(super) body_from_link: Isometry3<f64>,
    /// The joints below it, in the order of the file.
    pub(super) joints_below: Vec<usize>,
}

impl TreeLink {
    /// A link without mass and shapes.
    pub(super) fn new(name: String) -> Self {
        Self {
            name,
            mass: None,
            shapes: Vec::new(),
            visuals: Vec::new(),
            body_from_link: Isometry3::identity(),
            joints_below: Vec::new(),
        }
    }
}

impl LinkPart {
    fn placed(self, body_from_link: &Isometry3<f64>, joints_below: Vec<usize>) -> TreeLink {
        let mut link = self.link;
        for shape in link.shapes.iter_mut().chain(&mut link.visuals) {
            shape.body_from_shape = body_from_link * shape.body_from_shape;
        }
        let moved = |(mass, link_from_mass)| {
            MassProperties::moved(&mass, &(body_from_link * link_from_mass))
        };
        TreeLink {
            mass: self.mass.map(moved),
            body_from_link: *body_from_link,
            joints_below,
            ..link
        }
    }
}

/// A joint with its pose.
pub(super) struct TreeJoint {
    pub(super) name: String,
    pub(super) motion: Motion,
    pub(super) parent: usize,
    pub(super) child: usize,
    /// A point of its axis, in the body frame.
    pub(super) origin: Point3<f64>,
    /// The axis in the body frame.
    pub(super) axis: Unit<Vector3<f64>>,
    /// Whether the file states the axis.
    pub(super) states_axis: bool,
    pub(super) limits: MotorLimits,
    pub(super) losses: Joint,
    /// Whether it follows another joint.
    pub(super) mimics: bool,
    /// That joint, with the relation.
    pub(super) mimic: Option<Mimic>,
    /// Whether it slides along its axis.
    pub(super) slides: bool,
    /// Its smallest and largest position, in rad or m; infinite without a stop.
    pub(super) travel: [f64; 2],
    /// Largest effort of its drive, in N m or N; 0 without a drive or without information.
    pub(super) effort: f64,
}

/// The relation to a mimicked joint: multiplier times its position, plus an offset.
#[derive(Clone, Debug)]
pub(super) struct Mimic {
    pub(super) joint: String,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
}

/// The motion of a joint, as far as relevant here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    /// None.
    Fixed,
    /// Endless rotation.
    Turning,
    /// Rotation within limits.
    Swinging,
    /// Another motion, which wheels and rollers do not have.
    Other,
}

/// The shape of a part, lengths in metres.
#[derive(Clone, Debug)]
pub(super) enum Geometry {
    Box {
        size: [f64; 3],
    },
    Cylinder {
        radius: f64,
        length: f64,
    },
    Capsule {
        radius: f64,
        length: f64,
    },
    Sphere {
        radius: f64,
    },
    Mesh {
        filename: String,
        scale: Option<[f64; 3]>,
    },
}

/// A geometry and its pose in the body frame.
#[derive(Clone)]
pub(super) struct PlacedShape {
    pub(super) body_from_shape: Isometry3<f64>,
    pub(super) geometry: Geometry,
}

/// The connections of joints, by indices of links and joints.
struct Hanging {
    /// Parent and child of each joint.
    ends: Vec<(usize, usize)>,
    /// For each link the joint above it.
    above: Vec<Option<usize>>,
    /// For each link the joints below it, in the order of the file.
    below: Vec<Vec<usize>>,
}

impl Tree {
    /// Builds the tree; rejects links with two parents, several roots and loops.
    pub(super) fn build(source: &Source, (links, joints): Parts) -> Result<Self, RobotError> {
        let hanging = hang(source, &links, &joints)?;
        let root = root(source, &links, &hanging)?;
        let (placed, from_the_top) = place(source, &links, &joints, &hanging, root)?;
        let joints: Vec<TreeJoint> = joints
            .into_iter()
            .zip(&hanging.ends)
            .map(|(part, &(parent, child))| TreeJoint {
                parent,
                child,
                origin: Point3::from(placed[child].translation.vector),
                // Only a joint that does not turn can still have a zero axis; it has no effect.
                axis: Unit::try_new(placed[child] * part.axis, 1e-9)
                    .unwrap_or_else(Vector3::x_axis),
                ..part.joint
            })
            .collect();
        let mut turning_above: Vec<Option<usize>> = vec![None; joints.len()];
        for &j in &from_the_top {
            turning_above[j] = match hanging.above[joints[j].parent] {
                Some(next) if joints[next].motion == Motion::Turning => Some(next),
                Some(next) => turning_above[next],
                None => None,
            };
        }
        let mut swivel_above: Vec<Option<usize>> = vec![None; joints.len()];
        for &j in &from_the_top {
            let swivels = |j: &usize| {
                let joint = &joints[*j];
                joint.motion == Motion::Swinging && joint.axis.z.abs() > UPRIGHT
            };
            let next = hanging.above[joints[j].parent];
            swivel_above[j] = next
                .filter(swivels)
                .or_else(|| next.and_then(|next| swivel_above[next]));
        }
        let mut turning_below: Vec<Option<usize>> = vec![None; joints.len()];
        for &j in from_the_top.iter().rev() {
            if let Some(above) = hanging.above[joints[j].parent] {
                let turns = joints[j].motion == Motion::Turning;
                let found = if turns { Some(j) } else { turning_below[j] };
                turning_below[above] = turning_below[above].or(found);
            }
        }
        let links = links
            .into_iter()
            .zip(placed.iter().zip(hanging.below))
            .map(|(part, (body_from_link, joints_below))| part.placed(body_from_link, joints_below))
            .collect();
        Ok(Self {
            links,
            joints,
            root,
            above: hanging.above,
            turning_above,
            swivel_above,
            turning_below,
        })
    }

    /// The joints above one, the nearest first.
    pub(super) fn joints_above(&self, joint: usize) -> impl Iterator<Item = usize> {
        let above = |joint: &usize| self.above[self.joints[*joint].parent];
        std::iter::successors(above(&joint), above)
    }

    /// Returns the nearest turning joint above a joint.
    pub(super) fn turning_above(&self, joint: usize) -> Option<usize> {
        self.turning_above[joint]
    }

    /// Returns the nearest joint above a joint that turns within limits about an upright axis.
    pub(super) fn swivel_above(&self, joint: usize) -> Option<usize> {
        self.swivel_above[joint]
    }

    /// Returns a turning joint below a joint.
    pub(super) fn turning_below(&self, joint: usize) -> Option<usize> {
        self.turning_below[joint]
    }

    /// Returns the joints with a kind of motion.
    pub(super) fn moving(&self, motion: Motion) -> impl Iterator<Item = usize> {
        (0..self.joints.len()).filter(move |&j| self.joints[j].motion == motion)
    }

    /// Whether a joint's axis is level, within the lean of any wheel.
    pub(super) fn is_level(&self, joint: usize) -> bool {
        self.joints[joint].axis.z.abs() < 0.1
    }
}

/// Finds the parent of each joint; rejects links with two parent joints.
fn hang(source: &Source, links: &[LinkPart], joints: &[JointPart]) -> Result<Hanging, RobotError> {
    let index: HashMap<&str, usize> = links
        .iter()
        .enumerate()
        .map(|(i, part)| (part.link.name.as_str(), i))
        .collect();
    let mut faults = Faults::default();
    let mut hanging = Hanging {
        ends: Vec::with_capacity(joints.len()),
        above: vec![None; links.len()],
        below: vec![Vec::new(); links.len()],
    };
    for (j, part) in joints.iter().enumerate() {
        let end = |link: &String| {
            index.get(link.as_str()).copied().ok_or_else(|| {
                let link = link.clone();
                source.joint_error(&part.joint.name, Fault::UnknownLink { link })
            })
        };
        let (parent, child) = (end(&part.parent)?, end(&part.child)?);
        hanging.ends.push((parent, child));
        if let Some(first) = hanging.above[child] {
            let fault = Fault::TwoParents {
                link: part.child.clone(),
                first_joint: joints[first].joint.name.clone(),
            };
            faults.push(source.joint_error(&part.joint.name, fault));
            continue;
        }
        hanging.above[child] = Some(j);
        hanging.below[parent].push(j);
    }
    faults.into_result()?;
    Ok(hanging)
}

/// Returns the only link without a parent.
fn root(source: &Source, links: &[LinkPart], hanging: &Hanging) -> Result<usize, RobotError> {
    let above = &hanging.above;
    let roots: Vec<usize> = (0..above.len()).filter(|&l| above[l].is_none()).collect();
    match roots[..] {
        [root] => Ok(root),
        [] => Err(source.robot_error(Fault::Loop)),
        [_, second, ..] => {
            let names = roots.iter().map(|&l| links[l].link.name.clone()).collect();
            let fault = Fault::SeveralRoots { links: names };
            Err(source.link_error(&links[second].link.name, fault))
        }
    }
}

/// Places the links from the root down, with the joints in that order; unreached links are in a
/// loop.
fn place(
    source: &Source,
    links: &[LinkPart],
    joints: &[JointPart],
    hanging: &Hanging,
    root: usize,
) -> Result<(Vec<Isometry3<f64>>, Vec<usize>), RobotError> {
    let mut placed: Vec<Option<Isometry3<f64>>> = vec![None; links.len()];
    placed[root] = Some(Isometry3::identity());
    let mut waiting = vec![root];
    let mut from_the_top = Vec::with_capacity(joints.len());
    while let Some(link) = waiting.pop() {
        let Some(body_from_parent) = placed[link] else {
            continue;
        };
        for &j in &hanging.below[link] {
            let child = hanging.ends[j].1;
            placed[child] = Some(body_from_parent * joints[j].parent_from_joint);
            waiting.push(child);
            from_the_top.push(j);
        }
    }
    if let Some(lost) = placed.iter().position(Option::is_none) {
        return Err(source.link_error(&links[lost].link.name, Fault::Loop));
    }
    Ok((placed.into_iter().flatten().collect(), from_the_top))
}
