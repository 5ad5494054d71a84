//! The robot as a tree of bodies: chassis, bodies on joints, hubs on either, rollers on the hubs.
//!
//! The body that carries a wheel or a joint is a *carrier*: number 0 is the chassis, and i + 1 the
//! body of joint i.

use ilon_robot::{
    BodyJoint, Coupling, Joint, JointKind, JointRole, Robot, Roller, RollerForm, Wheel,
};
use nalgebra::{Matrix3, Vector3};

use crate::OracleError;
use crate::outline::{Outline, Shape};
use crate::play::Play;

/// Mass, centre and inertia of a body, in the frame that it is fixed to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inertia {
    pub mass: f64,
    pub center: Vector3<f64>,
    /// About the centre, along the frame's axes.
    pub about_center: Matrix3<f64>,
}

impl From<&ilon_robot::MassProperties> for Inertia {
    fn from(of: &ilon_robot::MassProperties) -> Self {
        Self {
            mass: of.mass_kg,
            center: of.center_of_mass_m,
            about_center: of.inertia_kg_m2,
        }
    }
}

impl Inertia {
    /// The same body after a rotation and a translation.
    pub fn moved(&self, turn: &Matrix3<f64>, by: &Vector3<f64>) -> Self {
        Self {
            mass: self.mass,
            center: turn * self.center + by,
            about_center: turn * self.about_center * turn.transpose(),
        }
    }
}

/// A roller, or a ring of a tyre, in the frame of its hub.
#[derive(Clone, Debug)]
pub(crate) struct RollerPart {
    pub center_in_hub: Vector3<f64>,
    pub axis_in_hub: Vector3<f64>,
    pub mass: f64,
    pub axial_inertia: f64,
    pub transverse_inertia: f64,
    pub shape: Shape,
    /// Whether it is a ring of a tyre: without mass, and it turns with its hub.
    pub is_tyre: bool,
    pub bearing: Joint,
    /// Friction torque on its axle per newton of load, in N m.
    pub held_per_load: f64,
    pub play: Play,
}

/// A hub, in the body frame with all joints at zero.
#[derive(Clone, Debug)]
pub(crate) struct WheelPart {
    pub carrier: usize,
    pub origin_in_body: Vector3<f64>,
    /// At wheel angle zero.
    pub body_from_hub: Matrix3<f64>,
    pub hub: Inertia,
    pub bearing: Joint,
    /// Its rollers, as a range of [`Tree::rollers`].
    pub rollers: std::ops::Range<usize>,
}

/// A body on a joint, in the body frame with all joints at zero.
#[derive(Clone, Debug)]
pub(crate) struct JointPart {
    /// The carrier of the joint; it precedes this one.
    pub parent: usize,
    pub slides: bool,
    pub pivot_in_body: Vector3<f64>,
    pub axis_in_body: Vector3<f64>,
    pub body: Inertia,
    pub law: BodyJoint,
}

/// The tree: joints and wheels in the robot's order, the rollers wheel by wheel.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub chassis: Inertia,
    pub joints: Vec<JointPart>,
    pub couplings: Vec<Coupling>,
    pub wheels: Vec<WheelPart>,
    pub rollers: Vec<RollerPart>,
}

impl Tree {
    pub fn new(robot: &Robot) -> Result<Self, OracleError> {
        let joints = robot.joints.iter().enumerate();
        let joints = joints.map(|(index, joint)| joint_part(index, joint));
        let joints: Vec<JointPart> = joints.collect::<Result<_, _>>()?;
        let mut rollers = Vec::new();
        let mut wheels = Vec::new();
        for wheel in &robot.wheels {
            let first = rollers.len();
            for roller in &wheel.rollers {
                match &roller.form {
                    RollerForm::Tyre(turned) => {
                        rollers.extend(rings(wheel, turned.edge_radius_m()));
                    }
                    _ => rollers.push(roller_part(wheel, roller)?),
                }
            }
            wheels.push(wheel_part(wheel, joints.len(), first..rollers.len())?);
        }
        Ok(Self {
            chassis: (&robot.chassis.mass).into(),
            joints,
            couplings: robot.couplings.clone(),
            wheels,
            rollers,
        })
    }

    /// Mass of all bodies, in kg.
    pub fn mass_kg(&self) -> f64 {
        let joints: f64 = self.joints.iter().map(|j| j.body.mass).sum();
        let hubs: f64 = self.wheels.iter().map(|w| w.hub.mass).sum();
        let rollers: f64 = self.rollers.iter().map(|r| r.mass).sum();
        self.chassis.mass + joints + hubs + rollers
    }

    /// Number of carriers: the chassis and the bodies on joints.
    pub fn carriers(&self) -> usize {
        1 + self.joints.len()
    }
}

/// The carrier of a part on this joint, of which there are `below`.
fn carrier_of(part: &str, joint: Option<usize>, below: usize) -> Result<usize, OracleError> {
    match joint {
        None => Ok(0),
        Some(joint) if joint < below => Ok(joint + 1),
        Some(_) => {
            let part = part.to_owned();
            Err(OracleError::NoCarrier { part })
        }
    }
}

fn joint_part(index: usize, joint: &BodyJoint) -> Result<JointPart, OracleError> {
    if !matches!(joint.role, JointRole::Free | JointRole::Sprung(_)) {
        let joint = joint.name.clone();
        return Err(OracleError::Role { joint });
    }
    let turn = joint.body_from_joint.rotation.to_rotation_matrix();
    let pivot = joint.body_from_joint.translation.vector;
    Ok(JointPart {
        parent: carrier_of(&joint.name, joint.parent, index)?,
        slides: joint.kind == JointKind::Slides,
        pivot_in_body: pivot,
        axis_in_body: turn * Vector3::z(),
        body: Inertia::from(&joint.body.mass).moved(turn.matrix(), &pivot),
        law: joint.clone(),
    })
}

fn wheel_part(
    wheel: &Wheel,
    joints: usize,
    rollers: std::ops::Range<usize>,
) -> Result<WheelPart, OracleError> {
    let body_from_hub = wheel.body_from_hub.rotation.to_rotation_matrix();
    let hub = Inertia::from(&wheel.hub);
    if hub.about_center[(2, 2)] <= 0.0 {
        let part = wheel.name.clone();
        return Err(OracleError::NoInertia { part });
    }
    Ok(WheelPart {
        carrier: carrier_of(&wheel.name, wheel.carrier, joints)?,
        origin_in_body: wheel.body_from_hub.translation.vector,
        body_from_hub: body_from_hub.into_inner(),
        hub,
        bearing: wheel.joint,
        rollers,
    })
}

fn roller_part(wheel: &Wheel, roller: &Roller) -> Result<RollerPart, OracleError> {
    if !matches!(roller.form, RollerForm::Barrel | RollerForm::Made(_)) {
        let roller = roller.name.clone();
        return Err(OracleError::NoBarrel { roller });
    }
    if roller.axial_inertia_kg_m2 <= 0.0 {
        let part = roller.name.clone();
        return Err(OracleError::NoInertia { part });
    }
    Ok(RollerPart {
        center_in_hub: roller.center_in_hub_m,
        axis_in_hub: roller.axis_in_hub.into_inner(),
        mass: roller.mass_kg,
        axial_inertia: roller.axial_inertia_kg_m2,
        transverse_inertia: roller.transverse_inertia_kg_m2,
        shape: Shape::Barrel(Outline::new(&wheel.barrel(roller))),
        is_tyre: false,
        bearing: roller.joint,
        held_per_load: wheel.surface.axle_friction * wheel.surface.axle_radius_m,
        play: Play {
            half_m: 0.5 * wheel.surface.axial_play_m,
            mass_kg: roller.mass_kg,
            ..Play::default()
        },
    })
}

/// A tyre: rings in its middle and where its shoulders, of this radius, begin.
fn rings(wheel: &Wheel, ball_m: f64) -> impl Iterator<Item = RollerPart> + '_ {
    let width_m: f64 = wheel.rollers.iter().map(|tyre| tyre.length_m).sum();
    let aside_m = 0.5 * width_m - ball_m;
    [-aside_m, 0.0, aside_m]
        .into_iter()
        .map(move |at_m| RollerPart {
            center_in_hub: at_m * Vector3::z(),
            axis_in_hub: Vector3::z(),
            mass: 0.0,
            axial_inertia: 0.0,
            transverse_inertia: 0.0,
            shape: Shape::Ring {
                ring_m: wheel.radius_m - ball_m,
                ball_m,
            },
            is_tyre: true,
            bearing: Joint::default(),
            held_per_load: 0.0,
            play: Play::default(),
        })
}
