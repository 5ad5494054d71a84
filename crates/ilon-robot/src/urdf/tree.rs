//! The kinematic tree with every joint at zero, and the rigid bodies that fixed joints make of its links.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use urdf_rs::{Geometry, JointLimit, JointType};

use super::remark;
use super::source::Source;
use crate::error::{Fault, RobotError};
use crate::model::{Joint, MassProperties, MotorLimits, Remark};

/// All links and joints of a robot, placed in the body frame, which is the frame of the root link.
pub(super) struct Tree {
    pub(super) links: Vec<TreeLink>,
    pub(super) joints: Vec<TreeJoint>,
    pub(super) root: usize,
    /// Of each joint the nearest turning joint above it.
    turning_above: Vec<Option<usize>>,
}

/// A link, placed.
pub(super) struct TreeLink {
    pub(super) name: String,
    /// Mass properties in the body frame; `None` for a link without mass.
    mass: Option<MassProperties>,
    /// Collision geometry with its pose in the body frame.
    shapes: Vec<PlacedShape>,
    /// The joints below, in the order of the file.
    pub(super) joints_below: Vec<usize>,
}

/// A joint, placed.
pub(super) struct TreeJoint {
    pub(super) name: String,
    pub(super) motion: Motion,
    pub(super) parent: usize,
    pub(super) child: usize,
    /// Where it turns, in the body frame.
    pub(super) origin: Point3<f64>,
    /// The axis in the body frame.
    pub(super) axis: Unit<Vector3<f64>>,
    pub(super) limits: MotorLimits,
    pub(super) losses: Joint,
}

/// How a joint moves, as far as it matters here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    /// It does not.
    Fixed,
    /// It turns without end.
    Turning,
    /// It moves in another way, which wheels and rollers do not.
    Other,
}

/// A collision geometry and its pose in the body frame.
#[derive(Clone)]
pub(super) struct PlacedShape {
    pub(super) body_from_shape: Isometry3<f64>,
    pub(super) geometry: Geometry,
}

/// Links that move as one.
pub(super) struct RigidBody {
    /// The link it hangs by.
    pub(super) link: usize,
    /// Mass properties in the body frame; `None` where no link of it has mass.
    pub(super) mass: Option<MassProperties>,
    /// Collision geometry in the body frame.
    pub(super) shapes: Vec<PlacedShape>,
    /// Movable joints inside it that are held at zero.
    pub(super) held: Vec<usize>,
}

impl Tree {
    /// Builds the tree, refusing links with two parents, several roots and loops.
    pub(super) fn build(
        source: &Source,
        robot: urdf_rs::Robot,
        remarks: &mut Vec<Remark>,
    ) -> Result<Self, RobotError> {
        // Destructured whole: what is not read shows as `_`.
        let urdf_rs::Robot {
            name: _,
            version: _,
            links: urdf_links,
            joints: urdf_joints,
            materials: _,
        } = robot;
        let index: HashMap<String, usize> = urdf_links
            .iter()
            .enumerate()
            .map(|(i, link)| (link.name.clone(), i))
            .collect();

        let mut above: Vec<Option<usize>> = vec![None; urdf_links.len()];
        let mut below: Vec<Vec<usize>> = vec![Vec::new(); urdf_links.len()];
        for (j, joint) in urdf_joints.iter().enumerate() {
            let end = |link: &String| {
                index.get(link).copied().ok_or_else(|| {
                    let link = link.clone();
                    source.joint_error(&joint.name, Fault::UnknownLink { link })
                })
            };
            let (parent, child) = (end(&joint.parent.link)?, end(&joint.child.link)?);
            if let Some(first) = above[child] {
                let fault = Fault::TwoParents {
                    link: joint.child.link.clone(),
                    first_joint: urdf_joints[first].name.clone(),
                };
                return Err(source.joint_error(&joint.name, fault));
            }
            above[child] = Some(j);
            below[parent].push(j);
        }
        let roots: Vec<usize> = (0..above.len()).filter(|&l| above[l].is_none()).collect();
        let root = match roots[..] {
            [root] => root,
            [] => return Err(source.robot_error(Fault::Loop)),
            [_, second, ..] => {
                let names = roots.iter().map(|&l| urdf_links[l].name.clone()).collect();
                return Err(source.link_error(
                    &urdf_links[second].name,
                    Fault::SeveralRoots { links: names },
                ));
            }
        };

        // Place the links from the root down; what is not reached hangs in a loop.
        let mut placed: Vec<Option<Isometry3<f64>>> = vec![None; urdf_links.len()];
        placed[root] = Some(Isometry3::identity());
        let mut waiting = vec![root];
        let mut from_the_top = Vec::with_capacity(urdf_joints.len());
        while let Some(link) = waiting.pop() {
            let Some(body_from_parent) = placed[link] else {
                continue;
            };
            for &j in &below[link] {
                if let Some(&child) = index.get(&urdf_joints[j].child.link) {
                    placed[child] = Some(body_from_parent * isometry(&urdf_joints[j].origin));
                    waiting.push(child);
                    from_the_top.push(j);
                }
            }
        }
        if let Some(lost) = placed.iter().position(Option::is_none) {
            return Err(source.link_error(&urdf_links[lost].name, Fault::Loop));
        }
        let placed: Vec<Isometry3<f64>> = placed.into_iter().flatten().collect();

        let mut joints = Vec::with_capacity(urdf_joints.len());
        for joint in urdf_joints {
            let ends = (&joint.parent.link, &joint.child.link);
            let (Some(&parent), Some(&child)) = (index.get(ends.0), index.get(ends.1)) else {
                continue;
            };
            joints.push(tree_joint(source, joint, parent, child, &placed, remarks)?);
        }
        let mut turning_above: Vec<Option<usize>> = vec![None; joints.len()];
        for j in from_the_top {
            turning_above[j] = match above[joints[j].parent] {
                Some(next) if joints[next].motion == Motion::Turning => Some(next),
                Some(next) => turning_above[next],
                None => None,
            };
        }
        let links = urdf_links
            .into_iter()
            .enumerate()
            .map(|(i, link)| tree_link(link, placed[i], std::mem::take(&mut below[i])))
            .collect();
        Ok(Self {
            links,
            joints,
            root,
            turning_above,
        })
    }

    /// The nearest turning joint above a joint.
    pub(super) fn turning_above(&self, joint: usize) -> Option<usize> {
        self.turning_above[joint]
    }

    /// Turning joints with nothing turning below them.
    fn turning_ends(&self) -> Vec<usize> {
        let turning =
            || (0..self.joints.len()).filter(|&j| self.joints[j].motion == Motion::Turning);
        let above: HashSet<usize> = turning().filter_map(|j| self.turning_above(j)).collect();
        turning().filter(|j| !above.contains(j)).collect()
    }

    fn level(&self, joint: usize) -> bool {
        self.joints[joint].axis.z.abs() < 0.1
    }

    /// Turning joints on a level axis with nothing turning above or below them.
    pub(super) fn plain_wheels(&self) -> Vec<usize> {
        let mut ends = self.turning_ends();
        ends.retain(|&j| self.level(j) && self.turning_above(j).is_none());
        ends
    }

    /// A joint that does not turn but carries rollers: three or more turning joints of nothing else, some of them on axes
    /// that are not level, as on a ring around a level axis some are. With it, how many there are.
    pub(super) fn fixed_hub(&self) -> Option<(usize, usize)> {
        let mut on_link: HashMap<usize, (usize, bool)> = HashMap::new();
        for j in self.turning_ends() {
            if self.turning_above(j).is_none() {
                let (count, leaning) = on_link.entry(self.joints[j].parent).or_default();
                *count += 1;
                *leaning |= !self.level(j);
            }
        }
        (0..self.joints.len()).find_map(|hub| {
            let joint = &self.joints[hub];
            let &(count, leaning) = on_link.get(&joint.child)?;
            (joint.motion != Motion::Turning && leaning && count >= 3).then_some((hub, count))
        })
    }

    /// Turning joints on a level axis that hang by an upright one, with nothing turning below them.
    pub(super) fn steered_wheels(&self) -> Vec<usize> {
        let mut ends = self.turning_ends();
        ends.retain(|&j| self.level(j) && self.turning_above(j).is_some_and(|a| !self.level(a)));
        ends
    }

    /// Everything that moves as one with `link` and hangs below it, when the joints that `splits` picks move and all
    /// others are held at zero.
    pub(super) fn rigid_body(&self, link: usize, splits: impl Fn(usize) -> bool) -> RigidBody {
        let mut body = RigidBody {
            link,
            mass: None,
            shapes: Vec::new(),
            held: Vec::new(),
        };
        let mut parts = Vec::new();
        let mut waiting = vec![link];
        while let Some(link) = waiting.pop() {
            let TreeLink {
                mass,
                shapes,
                joints_below,
                ..
            } = &self.links[link];
            parts.extend(mass.clone());
            body.shapes.extend(shapes.iter().cloned());
            // Reversed, so that what stands first in the file is merged first.
            for &j in joints_below.iter().rev().filter(|&&j| !splits(j)) {
                if self.joints[j].motion != Motion::Fixed {
                    body.held.push(j);
                }
                waiting.push(self.joints[j].child);
            }
        }
        body.mass = MassProperties::merged(&parts);
        body
    }
}

fn tree_link(
    link: urdf_rs::Link,
    body_from_link: Isometry3<f64>,
    joints_below: Vec<usize>,
) -> TreeLink {
    let urdf_rs::Link {
        name,
        inertial,
        visual: _,
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
    let shapes = collision
        .into_iter()
        .map(
            |urdf_rs::Collision {
                 name: _,
                 origin,
                 geometry,
             }| PlacedShape {
                body_from_shape: body_from_link * isometry(&origin),
                geometry,
            },
        )
        .collect();
    TreeLink {
        name,
        mass,
        shapes,
        joints_below,
    }
}

fn tree_joint(
    source: &Source,
    joint: urdf_rs::Joint,
    parent: usize,
    child: usize,
    body_from_link: &[Isometry3<f64>],
    remarks: &mut Vec<Remark>,
) -> Result<TreeJoint, RobotError> {
    let urdf_rs::Joint {
        name,
        joint_type,
        origin: _,
        parent: _,
        child: _,
        axis,
        limit,
        calibration,
        dynamics,
        mimic,
        safety_controller,
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
    for (ignored, what) in [
        (calibration.is_some(), "`<calibration>`"),
        (mimic.is_some(), "`<mimic>`"),
        (safety_controller.is_some(), "`<safety_controller>`"),
    ] {
        if ignored {
            remarks.push(remark(
                format!("joint `{name}`"),
                format!("{what} is not read"),
            ));
        }
    }
    let motion = match joint_type {
        JointType::Fixed => Motion::Fixed,
        JointType::Continuous => Motion::Turning,
        // Some tools know no continuous joints and write revolute ones of many turns.
        JointType::Revolute if upper - lower >= TAU => Motion::Turning,
        JointType::Revolute
        | JointType::Prismatic
        | JointType::Floating
        | JointType::Planar
        | JointType::Spherical => Motion::Other,
    };
    let axis_in_link = Vector3::from(*axis.xyz);
    // Only a fixed joint can still have a zero axis here, and there it means nothing.
    let axis = match Unit::try_new(body_from_link[child] * axis_in_link, 1e-9) {
        Some(axis) => axis,
        None if motion == Motion::Turning => {
            return Err(source.joint_error(&name, Fault::ZeroAxis));
        }
        None => Vector3::x_axis(),
    };
    // URDF writes 0 for a limit that is left out.
    let or_none = |limit: f64| if limit > 0.0 { limit } else { f64::INFINITY };
    let dynamics = dynamics.unwrap_or_default();
    Ok(TreeJoint {
        name,
        motion,
        parent,
        child,
        origin: Point3::from(body_from_link[child].translation.vector),
        axis,
        limits: MotorLimits {
            effort_n_m: or_none(effort),
            velocity_rad_s: or_none(velocity),
        },
        losses: Joint {
            damping_n_m_s: dynamics.damping,
            friction_n_m: dynamics.friction,
        },
    })
}

/// A URDF pose: turned by roll, pitch and yaw about the fixed x, y and z axes, in this order, then shifted.
fn isometry(pose: &urdf_rs::Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = *pose.rpy;
    Isometry3::from_parts(
        Translation3::from(Vector3::from(*pose.xyz)),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}
