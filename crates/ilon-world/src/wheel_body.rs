//! One wheel in the world: its hub, and the slots through which its rollers are bodies.

use ilon_robot::{Roller, Wheel};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use crate::{RollerBodies, RollerShape, convert};

/// The hub of a wheel and its rollers.
#[derive(Clone, Debug)]
pub(crate) struct WheelBody {
    /// The hub's body.
    pub hub: RigidBodyHandle,
    /// The hub's link in the robot's multibody.
    pub hub_link: usize,
    /// The wheel's axis among the multibody's degrees of freedom.
    pub hub_dof: usize,
    /// The bodies through which rollers touch the world.
    pub slots: Vec<Slot>,
    /// What every roller carries along, in or out of a slot.
    pub rollers: Vec<RollerState>,
}

/// A body that stands for one roller at a time.
#[derive(Clone, Debug)]
pub(crate) struct Slot {
    /// The body.
    pub body: RigidBodyHandle,
    /// Its collider, the exact barrel.
    pub collider: ColliderHandle,
    /// Its link in the robot's multibody.
    pub link: usize,
    /// Its spin among the multibody's degrees of freedom.
    pub dof: usize,
    /// The roller it stands for now.
    pub roller: usize,
}

/// A roller's place on its wheel and, while no body carries it, its spin.
#[derive(Clone, Debug)]
pub(crate) struct RollerState {
    /// Pose of the roller frame in the hub frame.
    pub hub_from_roller: Isometry3<f64>,
    /// Angle of its centre about the hub axis, from the hub frame's x axis, in radians.
    pub place_rad: f64,
    /// The roller's whole angular velocity along its own axis, in rad/s: while nothing but its bearing touches it,
    /// this is what stays, however the hub turns.
    pub axial_rate_rad_s: f64,
    /// Inertia about its axis, in kg m^2.
    pub axial_inertia_kg_m2: f64,
    /// Bearing damping, in N m s/rad.
    pub damping_n_m_s: f64,
    /// Bearing dry friction, in N m.
    pub friction_n_m: f64,
}

/// Rapier joints turn about their frame's x axis, ours about z: the rotation that takes x to z.
fn x_to_z() -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -std::f64::consts::FRAC_PI_2)
}

/// A joint about the z axis of the child's frame, which stands at `parent_from_child` while its angle is zero.
pub(crate) fn joint_about_z(parent_from_child: &Isometry3<f64>) -> GenericJoint {
    let child_from_joint = Isometry3::from_parts(Default::default(), x_to_z());
    let mut joint = GenericJoint::new(JointAxesMask::LOCKED_REVOLUTE_AXES);
    joint
        .set_local_frame1(joint_frame(parent_from_child))
        .set_local_frame2(convert::pose(&child_from_joint))
        .set_contacts_enabled(false);
    joint
}

/// The joint's frame in its parent, for [`joint_about_z`].
pub(crate) fn joint_frame(parent_from_child: &Isometry3<f64>) -> Pose {
    let child_from_joint = Isometry3::from_parts(Default::default(), x_to_z());
    convert::pose(&(parent_from_child * child_from_joint))
}

/// The pose of a roller's frame in the hub frame: z along its axis.
pub(crate) fn hub_from_roller(roller: &Roller) -> Isometry3<f64> {
    let z = Vector3::z();
    let rotation = UnitQuaternion::rotation_between(&z, &roller.axis_in_hub).unwrap_or_else(|| {
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
    });
    Isometry3::from_parts(roller.center_in_hub_m.into(), rotation)
}

impl RollerState {
    fn new(roller: &Roller) -> Self {
        Self {
            hub_from_roller: hub_from_roller(roller),
            place_rad: roller.place_rad(),
            axial_rate_rad_s: 0.0,
            axial_inertia_kg_m2: roller.axial_inertia_kg_m2,
            damping_n_m_s: roller.joint.damping_n_m_s,
            friction_n_m: roller.joint.friction_n_m,
        }
    }

    /// The roller's axis in the hub frame.
    pub fn axis_in_hub(&self) -> Vector3<f64> {
        self.hub_from_roller.rotation * Vector3::z()
    }

    /// Lets a roller that touches nothing coast for `dt_s` on a hub that turns with `hub_rate_in_hub_rad_s`: only its
    /// bearing acts, I d(rate)/dt = -damping (rate - hub) - friction sign(rate - hub), which is solved exactly for
    /// the damping and never lets friction reverse the spin.
    pub fn coast(&mut self, hub_rate_in_hub_rad_s: &Vector3<f64>, dt_s: f64) {
        let carried = hub_rate_in_hub_rad_s.dot(&self.axis_in_hub());
        let relative = self.axial_rate_rad_s - carried;
        let damped = relative * (-self.damping_n_m_s / self.axial_inertia_kg_m2 * dt_s).exp();
        let stopping = self.friction_n_m / self.axial_inertia_kg_m2 * dt_s;
        let slowed = damped.signum() * (damped.abs() - stopping).max(0.0);
        self.axial_rate_rad_s = carried + slowed;
    }
}

/// Mass properties of the hub body in its frame: the hub alone, or with what its rollers bring while their bodies do
/// not carry their mass.
///
/// In the contact window a roller's mass and its inertia across its axis belong to the hub for good, and only its
/// spin inertia to the slot, so that moving a slot from one roller to the next moves no momentum. rapier cannot invert
/// an inertia about one axis alone, so a slot is round and the hub gives up the mean of what it has too much: about
/// the hub axis, where wheels turn fast, that is exact because all rollers stand at the same angle to it.
fn hub_mass_properties(wheel: &Wheel, roller_bodies: RollerBodies) -> MassProperties {
    let parts: &[Roller] = match roller_bodies {
        RollerBodies::All => &[],
        RollerBodies::Near => &wheel.rollers,
    };
    let mut mass_kg = wheel.hub.mass_kg;
    let mut first_moment = wheel.hub.mass_kg * wheel.hub.center_of_mass_m;
    for roller in parts {
        mass_kg += roller.mass_kg;
        first_moment += roller.mass_kg * roller.center_in_hub_m;
    }
    let center_m = first_moment / mass_kg;
    let about_center = |mass_kg: f64, at: &Vector3<f64>| {
        let r = at - center_m;
        mass_kg * (Matrix3::identity() * r.norm_squared() - r * r.transpose())
    };
    let mut inertia =
        wheel.hub.inertia_kg_m2 + about_center(wheel.hub.mass_kg, &wheel.hub.center_of_mass_m);
    let slots = slot_count(wheel, roller_bodies) as f64;
    for roller in parts {
        let d = roller.axis_in_hub.into_inner();
        let in_slots = slots / parts.len() as f64 * roller.axial_inertia_kg_m2;
        inertia += about_center(roller.mass_kg, &roller.center_in_hub_m)
            + (roller.transverse_inertia_kg_m2 - in_slots)
                * (Matrix3::identity() - d * d.transpose());
    }
    MassProperties::with_inertia_matrix(
        convert::vector(&center_m),
        mass_kg as Real,
        convert::matrix(&inertia),
    )
}

/// Mass properties of a roller's body in its own frame.
fn slot_mass_properties(roller: &Roller, roller_bodies: RollerBodies) -> MassProperties {
    let (mass_kg, transverse) = match roller_bodies {
        RollerBodies::All => (roller.mass_kg, roller.transverse_inertia_kg_m2),
        RollerBodies::Near => (0.0, roller.axial_inertia_kg_m2),
    };
    MassProperties::new(
        Vector::ZERO,
        mass_kg as Real,
        Vector::new(
            transverse as Real,
            transverse as Real,
            roller.axial_inertia_kg_m2 as Real,
        ),
    )
}

/// How many slots a wheel has.
fn slot_count(wheel: &Wheel, roller_bodies: RollerBodies) -> usize {
    match roller_bodies {
        RollerBodies::All => wheel.rollers.len(),
        // On open flat floor one roller of a wheel touches at a time; two do at the instant of the hand-over.
        RollerBodies::Near => 1,
    }
}

/// Adds a wheel to the robot's multibody: the hub on the chassis, the slots on the hub.
pub(crate) fn insert(
    bodies: &mut RigidBodySet,
    colliders: &mut ColliderSet,
    joints: &mut MultibodyJointSet,
    chassis: RigidBodyHandle,
    chassis_from_body: &Isometry3<f64>,
    wheel: &Wheel,
    settings: &crate::Settings,
    friction: f64,
) -> WheelBody {
    let chassis_from_hub = chassis_from_body * wheel.body_from_hub;
    let world_from_chassis = *bodies[chassis].position();
    let world_from_hub = world_from_chassis * convert::pose(&chassis_from_hub);
    let hub = bodies.insert(
        RigidBodyBuilder::dynamic()
            .pose(world_from_hub)
            .can_sleep(false)
            .additional_mass_properties(hub_mass_properties(wheel, settings.roller_bodies)),
    );
    joints.insert(chassis, hub, joint_about_z(&chassis_from_hub), true);

    let rollers: Vec<RollerState> = wheel.rollers.iter().map(RollerState::new).collect();
    let slots = (0..slot_count(wheel, settings.roller_bodies))
        .map(|roller| {
            let state = &rollers[roller];
            let body = bodies.insert(
                RigidBodyBuilder::dynamic()
                    .pose(world_from_hub * convert::pose(&state.hub_from_roller))
                    .can_sleep(false)
                    .additional_mass_properties(slot_mass_properties(
                        &wheel.rollers[roller],
                        settings.roller_bodies,
                    )),
            );
            joints.insert(hub, body, joint_about_z(&state.hub_from_roller), true);
            let shape = RollerShape::new(&wheel.barrel(&wheel.rollers[roller]));
            let collider = colliders.insert_with_parent(
                ColliderBuilder::new(SharedShape::new(shape))
                    .density(0.0)
                    .friction(friction as Real)
                    .friction_combine_rule(CoefficientCombineRule::Min)
                    .restitution(0.0)
                    .collision_groups(crate::groups::ROLLER),
                body,
                bodies,
            );
            Slot {
                body,
                collider,
                link: 0,
                dof: 0,
                roller,
            }
        })
        .collect();
    WheelBody {
        hub,
        hub_link: 0,
        hub_dof: 0,
        slots,
        rollers,
    }
}
