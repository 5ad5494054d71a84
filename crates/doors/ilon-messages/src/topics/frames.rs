//! The frames of a robot: its tree of links, with the joints of wheels and rollers.

use std::collections::HashSet;

use ilon_robot::{BodyJoint, JointKind, LinkTree, Robot};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// A fixed frame in its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct Fixed {
    /// The parent.
    pub parent: String,
    /// The child frame.
    pub child: String,
    /// Its pose in the parent.
    pub parent_from_child: Isometry3<f64>,
}

/// A frame that turns in its parent, or slides.
#[derive(Clone, Debug, PartialEq)]
pub struct Turning {
    /// The parent.
    pub parent: String,
    /// The child frame.
    pub child: String,
    /// Pose in the parent of the frame whose z axis is the joint's axis.
    parent_from_axis: Isometry3<f64>,
    /// Pose of the child in that frame at position zero.
    axis_from_child: Isometry3<f64>,
    /// Whether it slides along that axis.
    slides: bool,
}

impl Turning {
    /// Returns the child's pose in the parent at an angle in radians, or at a position in metres
    /// for a sliding frame.
    pub fn at(&self, angle_rad: f64) -> Isometry3<f64> {
        if self.slides {
            let along = Translation3::new(0.0, 0.0, angle_rad);
            return self.parent_from_axis * along * self.axis_from_child;
        }
        let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_rad);
        self.parent_from_axis * turned * self.axis_from_child
    }
}

/// The tree of a robot's links, each once.
#[derive(Clone, Debug, PartialEq)]
pub struct Frames {
    /// The root link: the body frame.
    pub base: String,
    /// Links that are fixed to their parents.
    pub fixed: Vec<Fixed>,
    /// The link of each joint between bodies, in the robot's order.
    pub joints: Vec<Turning>,
    /// The link of each wheel, in the robot's order.
    pub wheels: Vec<Turning>,
    /// The link of each roller, wheel by wheel.
    pub rollers: Vec<Turning>,
}

impl Frames {
    /// Returns the frames of a robot whose wheels and rollers each have a link, as in a
    /// [`RobotDescription`](ilon_robot::RobotDescription); otherwise `None`.
    pub fn of(robot: &Robot, tree: &LinkTree) -> Option<Self> {
        let name = |link: usize| tree.links[link].name.clone();
        let turning = |joint: &str, body_from_axis: Isometry3<f64>| {
            let joint = tree.joint(joint)?;
            let body_from_parent = tree.links[joint.parent].body_from_link;
            let body_from_child = tree.links[joint.child].body_from_link;
            Some(Turning {
                parent: name(joint.parent),
                child: name(joint.child),
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
        // A description made only from the robot's wheels has none of them.
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
        // A joint that is not simulated stays at zero.
        let fixed = tree
            .joints
            .iter()
            .filter(|joint| !moving.contains(tree.links[joint.child].name.as_str()))
            .map(|joint| Fixed {
                parent: name(joint.parent),
                child: name(joint.child),
                parent_from_child: joint.parent_from_child,
            })
            .collect();
        Some(Self {
            base: tree.links.first()?.name.clone(),
            fixed,
            joints,
            wheels,
            rollers,
        })
    }

    /// Returns an unused name similar to this one.
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
