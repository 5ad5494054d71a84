//! The kinematic tree with every joint at zero.

use std::collections::HashMap;
use std::f64::consts::TAU;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use urdf_rs::{Geometry, JointLimit, JointType};

use super::faults::Faults;
use super::normalise::stated_axis;
use super::source::Source;
use crate::error::{Fault, RobotError};
use crate::model::{Joint, MassProperties, MotorLimits};

/// A limited joint whose range is at least this is meant to turn endlessly: some files have 6.28.
const NEARLY_A_TURN_RAD: f64 = TAU - 0.01;

/// Smallest vertical component of a steering joint's axis, as a cosine.
const UPRIGHT: f64 = 0.9;

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
    pub(super) fn build(source: &Source, robot: urdf_rs::Robot) -> Result<Self, RobotError> {
        // Destructured completely: unused fields appear as `_`.
        let urdf_rs::Robot {
            name: _,
            version: _,
            links,
            joints,
            materials: _,
        } = robot;
        let mut hanging = hang(source, &links, &joints)?;
        let root = root(source, &links, &hanging)?;
        let (placed, from_the_top) = place(source, &links, &joints, &hanging, root)?;
        let joints: Vec<TreeJoint> = joints
            .into_iter()
            .zip(&hanging.ends)
            .map(|(joint, ends)| {
                let node = source.named("joint", &joint.name);
                let states_axis = node.and_then(stated_axis).is_some();
                tree_joint(joint, *ends, &placed, states_axis)
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
            .enumerate()
            .map(|(i, link)| tree_link(link, placed[i], std::mem::take(&mut hanging.below[i])))
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
fn hang(
    source: &Source,
    links: &[urdf_rs::Link],
    joints: &[urdf_rs::Joint],
) -> Result<Hanging, RobotError> {
    let index: HashMap<&str, usize> = links
        .iter()
        .enumerate()
        .map(|(i, link)| (link.name.as_str(), i))
        .collect();
    let mut faults = Faults::default();
    let mut hanging = Hanging {
        ends: Vec::with_capacity(joints.len()),
        above: vec![None; links.len()],
        below: vec![Vec::new(); links.len()],
    };
    for (j, joint) in joints.iter().enumerate() {
        let end = |link: &String| {
            index.get(link.as_str()).copied().ok_or_else(|| {
                let link = link.clone();
                source.joint_error(&joint.name, Fault::UnknownLink { link })
            })
        };
        let (parent, child) = (end(&joint.parent.link)?, end(&joint.child.link)?);
        hanging.ends.push((parent, child));
        if let Some(first) = hanging.above[child] {
            let fault = Fault::TwoParents {
                link: joint.child.link.clone(),
                first_joint: joints[first].name.clone(),
            };
            faults.push(source.joint_error(&joint.name, fault));
            continue;
        }
        hanging.above[child] = Some(j);
        hanging.below[parent].push(j);
    }
    faults.into_result()?;
    Ok(hanging)
}

/// Returns the only link without a parent.
fn root(source: &Source, links: &[urdf_rs::Link], hanging: &Hanging) -> Result<usize, RobotError> {
    let above = &hanging.above;
    let roots: Vec<usize> = (0..above.len()).filter(|&l| above[l].is_none()).collect();
    match roots[..] {
        [root] => Ok(root),
        [] => Err(source.robot_error(Fault::Loop)),
        [_, second, ..] => {
            let names = roots.iter().map(|&l| links[l].name.clone()).collect();
            let fault = Fault::SeveralRoots { links: names };
            Err(source.link_error(&links[second].name, fault))
        }
    }
}

/// Places the links from the root down, with the joints in that order; unreached links are in a
/// loop.
fn place(
    source: &Source,
    links: &[urdf_rs::Link],
    joints: &[urdf_rs::Joint],
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
            placed[child] = Some(body_from_parent * isometry(&joints[j].origin));
            waiting.push(child);
            from_the_top.push(j);
        }
    }
    if let Some(lost) = placed.iter().position(Option::is_none) {
        return Err(source.link_error(&links[lost].name, Fault::Loop));
    }
    Ok((placed.into_iter().flatten().collect(), from_the_top))
}

fn tree_link(
    link: urdf_rs::Link,
    body_from_link: Isometry3<f64>,
    joints_below: Vec<usize>,
) -> TreeLink {
    let urdf_rs::Link {
        name,
        inertial,
        visual,
        collision,
    } = link;
    let urdf_rs::Inertial {
        origin,
        mass,
        inertia: i,
    } = inertial;
    let in_inertial_frame = MassProperties {
        mass_kg: mass.value,
        center_of_mass_m: Vector3::zeros(),
        inertia_kg_m2: Matrix3::new(
            i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz,
        ),
    };
    let mass =
        (mass.value > 0.0).then(|| in_inertial_frame.moved(&(body_from_link * isometry(&origin))));
    let placed = |origin: &urdf_rs::Pose, geometry: Geometry| PlacedShape {
        body_from_shape: body_from_link * isometry(origin),
        geometry,
    };
    TreeLink {
        name,
        mass,
        shapes: collision
            .into_iter()
            .map(|shape| placed(&shape.origin, shape.geometry))
            .collect(),
        visuals: visual
            .into_iter()
            .map(|shape| placed(&shape.origin, shape.geometry))
            .collect(),
        body_from_link,
        joints_below,
    }
}

fn tree_joint(
    joint: urdf_rs::Joint,
    (parent, child): (usize, usize),
    body_from_link: &[Isometry3<f64>],
    states_axis: bool,
) -> TreeJoint {
    let urdf_rs::Joint {
        name,
        joint_type,
        origin: _,
        parent: _,
        child: _,
        axis,
        limit,
        calibration: _,
        dynamics,
        mimic,
        safety_controller: _,
    } = joint;
    let JointLimit {
        lower,
        upper,
        effort,
        velocity,
        acceleration: _,
        deceleration: _,
        jerk: _,
    } = limit;
    let slides = joint_type == JointType::Prismatic;
    let is_bounded = slides || joint_type == JointType::Revolute;
    let travel = if is_bounded {
        [lower, upper]
    } else {
        [f64::NEG_INFINITY, f64::INFINITY]
    };
    let motion = match joint_type {
        JointType::Fixed => Motion::Fixed,
        JointType::Continuous => Motion::Turning,
        // Some tools have no continuous joints and write revolute ones of many turns, or of one.
        JointType::Revolute if upper - lower >= NEARLY_A_TURN_RAD => Motion::Turning,
        JointType::Revolute => Motion::Swinging,
        JointType::Prismatic | JointType::Floating | JointType::Planar | JointType::Spherical => {
            Motion::Other
        }
    };
    let axis_in_link = Vector3::from(*axis.xyz);
    // Only a joint that does not turn can still have a zero axis here; it has no effect.
    let axis =
        Unit::try_new(body_from_link[child] * axis_in_link, 1e-9).unwrap_or_else(Vector3::x_axis);
    // URDF writes 0 for a missing limit.
    let or_none = |limit: f64| if limit > 0.0 { limit } else { f64::INFINITY };
    let dynamics = dynamics.unwrap_or_default();
    TreeJoint {
        name,
        motion,
        parent,
        child,
        origin: Point3::from(body_from_link[child].translation.vector),
        axis,
        states_axis,
        limits: MotorLimits {
            effort_n_m: or_none(effort),
            velocity_rad_s: or_none(velocity),
        },
        losses: Joint {
            damping_n_m_s: dynamics.damping,
            friction_n_m: dynamics.friction,
        },
        mimics: mimic.is_some(),
        mimic: mimic.map(|mimic| Mimic {
            joint: mimic.joint,
            multiplier: mimic.multiplier.unwrap_or(1.0),
            offset: mimic.offset.unwrap_or(0.0),
        }),
        slides,
        travel,
        effort,
    }
}

/// Converts a URDF pose: rotation by roll, pitch and yaw about the fixed x, y and z axes, in this
/// order, then translation.
fn isometry(pose: &urdf_rs::Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = *pose.rpy;
    Isometry3::from_parts(
        Translation3::from(Vector3::from(*pose.xyz)),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}
