//! A robot prepared for worlds.

use std::ops::Deref;
use std::sync::Arc;

use ilon_robot::{BodyJoint, Chassis, Collision, JointKind, MassProperties, Robot, Wheel};
use nalgebra::{Isometry3, Vector3};
use parry3d::shape::SharedShape;

use crate::dynamics::{Joint, Motion, Tree};
use crate::engine::shapes::shape_of;
use crate::robot::roller::{FixedRoller, RollerState};

/// A robot prepared for worlds: all worlds built from it share its constant parts, so that a
/// thousand of them need only the memory of their states.
///
/// ```no_run
/// # use ilon_robot::{Pose, Robot};
/// # use ilon_world::{Floor, Settings, SharedRobot, World};
/// use ilon_formats::LoadRobot;
///
/// let robot = SharedRobot::from(&Robot::load("robot.urdf")?);
/// let place = |index: i32| Pose { y_m: f64::from(index), ..Pose::default() };
/// let fleet: Result<Vec<World>, _> = (0..1000)
///     .map(|index| World::new(&robot, &Floor::default(), place(index), &Settings::default()))
///     .collect();
/// # fleet?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SharedRobot(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    robot: Robot,
    /// Wheel by wheel.
    rollers: Vec<Vec<Arc<FixedRoller>>>,
    /// Without load on its chassis, and with all rollers free to turn.
    tree: Arc<Tree>,
    /// The shapes of the chassis and of the bodies on joints.
    shapes: Vec<BodyShape>,
}

/// A shape of a robot that belongs to neither a wheel nor a roller.
#[derive(Debug)]
pub(crate) struct BodyShape {
    /// The joint whose body carries it; `None` for the chassis.
    pub joint: Option<usize>,
    /// Its pose in the frame of that joint, or in the body frame.
    pub carrier_from_shape: Isometry3<f64>,
    pub shape: SharedShape,
    /// Its own friction; `None` if the ground's or the body's applies.
    pub friction: Option<f64>,
}

impl SharedRobot {
    /// A body without joints or wheels, with given shapes.
    pub(crate) fn of_one(chassis: Chassis, shapes: Vec<BodyShape>) -> Self {
        let robot = Robot {
            name: chassis.name.clone(),
            chassis,
            joints: Vec::new(),
            couplings: Vec::new(),
            wheels: Vec::new(),
            remarks: Vec::new(),
        };
        let tree = tree_of(&robot, &robot.chassis.mass, std::iter::empty());
        Self(Arc::new(Shared {
            rollers: Vec::new(),
            tree: Arc::new(tree),
            shapes,
            robot,
        }))
    }

    /// The rollers of all wheels, at rest.
    pub(crate) fn rollers_at_rest(&self) -> Vec<Vec<RollerState>> {
        self.0.rollers.iter().map(|of| at_rest(of)).collect()
    }

    /// The robot as a tree, without load.
    pub(crate) fn tree(&self) -> &Arc<Tree> {
        &self.0.tree
    }

    /// The shapes of the chassis, and then those of the bodies on joints.
    pub(crate) fn shapes(&self) -> &[BodyShape] {
        &self.0.shapes
    }
}

fn shapes_of(robot: &Robot) -> Vec<BodyShape> {
    let of = |collisions: &[Collision], joint: Option<usize>, carrier_from_body: Isometry3<f64>| {
        let shapes = collisions.iter().filter_map(|collision| {
            let (body_from_shape, shape) = shape_of(collision)?;
            Some(BodyShape {
                joint,
                // No change for the chassis, whose frame it is.
                carrier_from_shape: match joint {
                    Some(_) => carrier_from_body * body_from_shape,
                    None => body_from_shape,
                },
                shape,
                friction: collision.friction,
            })
        });
        shapes.collect::<Vec<_>>()
    };
    let mut shapes = of(&robot.chassis.collisions, None, Isometry3::identity());
    for (index, joint) in robot.joints.iter().enumerate() {
        let joint_from_body = joint.body_from_joint.inverse();
        shapes.extend(of(&joint.body.collisions, Some(index), joint_from_body));
    }
    shapes
}

/// Rollers of a wheel at rest.
fn at_rest(rollers: &[Arc<FixedRoller>]) -> Vec<RollerState> {
    let rollers = rollers.iter();
    rollers
        .map(|roller| RollerState::at_rest(Arc::clone(roller)))
        .collect()
}

/// A robot as a tree, for a mass of its chassis and the rollers that turn: its joints first, and
/// then the hubs in the order of the wheels.
pub(crate) fn tree_of<'a>(
    robot: &Robot,
    chassis: &MassProperties,
    rollers: impl Iterator<Item = &'a [RollerState]>,
) -> Tree {
    let chassis_from_body = Isometry3::from(-chassis.center_of_mass_m);
    let root = MassProperties {
        center_of_mass_m: Vector3::zeros(),
        ..chassis.clone()
    };
    let carrier_from_body = |carrier: Option<usize>| match carrier {
        Some(joint) => robot.joints[joint].body_from_joint.inverse(),
        None => chassis_from_body,
    };
    // Joints whose parents come after them are refused before any world is built.
    let above = |carrier: Option<usize>, index: usize| carrier.filter(|at| *at < index);
    let of_body = |(index, joint): (usize, &BodyJoint)| Joint {
        parent: above(joint.parent, index),
        motion: match joint.kind {
            JointKind::Turns => Motion::Turns,
            JointKind::Slides => Motion::Slides,
        },
        parent_from_link: carrier_from_body(above(joint.parent, index)) * joint.body_from_joint,
        mass: joint.body.mass.clone(),
        armature: 0.0,
    };
    let of_wheel = |(wheel, rollers): (&Wheel, &[RollerState])| Joint {
        parent: above(wheel.carrier, robot.joints.len()),
        motion: Motion::Turns,
        parent_from_link: carrier_from_body(above(wheel.carrier, robot.joints.len()))
            * wheel.body_from_hub,
        mass: wheel.carried_mass(|index| rollers[index].seized),
        armature: wheel.drive.reflected_inertia_kg_m2(),
    };
    let hubs = robot.wheels.iter().zip(rollers).map(of_wheel);
    Tree::new(
        root,
        robot
            .joints
            .iter()
            .enumerate()
            .map(of_body)
            .chain(hubs)
            .collect(),
    )
}

impl Deref for SharedRobot {
    type Target = Robot;

    fn deref(&self) -> &Robot {
        &self.0.robot
    }
}

impl From<&Robot> for SharedRobot {
    fn from(robot: &Robot) -> Self {
        let fixed = |wheel| move |roller| Arc::new(FixedRoller::new(wheel, roller));
        let wheels = robot.wheels.iter();
        let rollers: Vec<Vec<_>> = wheels
            .map(|wheel| wheel.rollers.iter().map(fixed(wheel)).collect())
            .collect();
        let turning: Vec<Vec<_>> = rollers.iter().map(|of| at_rest(of)).collect();
        let tree = tree_of(
            robot,
            &robot.chassis.mass,
            turning.iter().map(Vec::as_slice),
        );
        Self(Arc::new(Shared {
            rollers,
            tree: Arc::new(tree),
            shapes: shapes_of(robot),
            robot: robot.clone(),
        }))
    }
}

impl From<&SharedRobot> for SharedRobot {
    fn from(robot: &SharedRobot) -> Self {
        robot.clone()
    }
}
