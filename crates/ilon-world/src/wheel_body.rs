//! One wheel in the world: its hub, and the slots through which its rollers are bodies.

use ilon_robot::{Roller, Wheel};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use crate::collision::shape_of_roller;
use crate::{RollerBodies, Settings, convert};

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
    /// What the bearings of the rollers without a body put on the hub now, in its frame, in N m.
    pub coasting_torque_in_hub_n_m: Vector3<f64>,
}

/// What a step of coasting did.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coasted {
    /// Energy that the bearing took, in J.
    pub lost_j: f64,
    /// Torque of the bearing on the hub about the roller's axis, in N m.
    pub torque_on_hub_n_m: f64,
}

/// A body that stands for one roller at a time.
#[derive(Clone, Debug)]
pub(crate) struct Slot {
    /// The body.
    pub body: RigidBodyHandle,
    /// Its collider: the exact barrel, or the shapes of the roller's file.
    pub collider: ColliderHandle,
    /// Its link in the robot's multibody.
    pub link: usize,
    /// Its spin among the multibody's degrees of freedom.
    pub dof: usize,
    /// The roller it stands for now.
    pub roller: usize,
    /// Its spin when the step began, in rad/s.
    pub spin_before_rad_s: f64,
}

/// A roller's place on its wheel and, while no body carries it, its spin.
#[derive(Clone, Debug)]
pub(crate) struct RollerState {
    /// Pose of the roller frame in the hub frame.
    pub hub_from_roller: Isometry3<f64>,
    /// Angle of its centre about the hub axis, from the hub frame's x axis, in radians.
    pub place_rad: f64,
    /// What stays while nothing but its bearing touches it, however the hub turns, in rad/s: its angular momentum about
    /// its axis over its inertia, which is its spin against the hub plus the hub's own rate about that axis.
    steady_rate_rad_s: f64,
    /// Inertia about its axis, in kg m^2.
    spin_inertia_kg_m2: f64,
    /// Bearing damping, in N m s/rad.
    pub damping_n_m_s: f64,
    /// Bearing dry friction, in N m.
    pub friction_n_m: f64,
    /// Whether the roller has seized on its axle.
    seized: bool,
}

/// Inertia that stands for a seized roller's axle, in kg m^2: 0.1 N m, more than a contact puts on a roller, would take 1000 s to give
/// it 0.1 rad/s.
const SEIZED_KG_M2: f64 = 1e3;

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

impl RollerState {
    /// A roller at rest.
    pub fn new(roller: &Roller) -> Self {
        Self {
            hub_from_roller: roller.hub_from_roller(),
            place_rad: roller.place_rad(),
            steady_rate_rad_s: 0.0,
            spin_inertia_kg_m2: roller.axial_inertia_kg_m2,
            damping_n_m_s: roller.joint.damping_n_m_s,
            friction_n_m: roller.joint.friction_n_m,
            seized: false,
        }
    }

    /// Lets the roller seize on its axle, or frees it; either way it stands still against its hub at that moment.
    pub fn seize(&mut self, seized: bool, hub_rate_in_hub_rad_s: &Vector3<f64>) {
        self.seized = seized;
        self.set_spin(0.0, hub_rate_in_hub_rad_s);
    }

    /// Inertia that rapier adds to its spin against the hub, in kg m^2.
    pub fn armature_kg_m2(&self) -> f64 {
        if self.seized { SEIZED_KG_M2 } else { 0.0 }
    }

    /// The roller's axis in the hub frame.
    pub fn axis_in_hub(&self) -> Vector3<f64> {
        self.hub_from_roller.rotation * Vector3::z()
    }

    /// The hub's angular velocity about the roller's axis, with which it carries the roller along.
    fn carried_rad_s(&self, hub_rate_in_hub_rad_s: &Vector3<f64>) -> f64 {
        hub_rate_in_hub_rad_s.dot(&self.axis_in_hub())
    }

    /// The roller's spin against its hub, whose angular velocity in the hub frame is given, in rad/s.
    pub fn spin_rad_s(&self, hub_rate_in_hub_rad_s: &Vector3<f64>) -> f64 {
        if self.seized {
            return 0.0;
        }
        self.steady_rate_rad_s - self.carried_rad_s(hub_rate_in_hub_rad_s)
    }

    /// Takes over a spin against the hub, in rad/s.
    pub fn set_spin(&mut self, spin_rad_s: f64, hub_rate_in_hub_rad_s: &Vector3<f64>) {
        self.steady_rate_rad_s = spin_rad_s + self.carried_rad_s(hub_rate_in_hub_rad_s);
    }

    /// Lets a roller that touches nothing spin on for `dt_s`: only its bearing acts,
    /// I d(spin)/dt = -damping spin - friction sign(spin), solved exactly for the damping; dry friction never reverses
    /// the spin.
    ///
    /// What the bearing takes from the roller it gives to the hub.
    pub fn coast(&mut self, hub_rate_in_hub_rad_s: &Vector3<f64>, dt_s: f64) -> Coasted {
        let spin = self.spin_rad_s(hub_rate_in_hub_rad_s);
        let damped = spin * libm::exp(-self.damping_n_m_s / self.spin_inertia_kg_m2 * dt_s);
        let stopping = self.friction_n_m / self.spin_inertia_kg_m2 * dt_s;
        let slowed = damped.signum() * (damped.abs() - stopping).max(0.0);
        self.set_spin(slowed, hub_rate_in_hub_rad_s);
        let inertia = self.spin_inertia_kg_m2;
        Coasted {
            lost_j: 0.5 * inertia * (spin * spin - slowed * slowed),
            torque_on_hub_n_m: inertia * (spin - slowed) / dt_s,
        }
    }
}

/// Mass properties of the hub body in its frame: the hub alone, or with what its rollers bring while their bodies do
/// not carry their mass.
///
/// In the contact window a roller's mass and its inertia across its axis belong to the hub for good, and only its
/// spin inertia to the slot, so that moving a slot from one roller to the next moves no momentum. rapier cannot invert
/// an inertia about one axis alone, so a slot is round and the hub gives up the mean of what it has too much: about
/// the hub axis, where wheels turn fast, that is exact because all rollers stand at the same angle to it.
///
/// A roller that coasts keeps its axial momentum I (c + s), with c the hub's rate about its axis and s its spin: the hub
/// carries nothing of it.
fn hub_mass_properties(wheel: &Wheel, settings: &Settings, slots: usize) -> MassProperties {
    let parts: &[Roller] = match settings.roller_bodies {
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
    for roller in parts {
        let d = roller.axis_in_hub.into_inner();
        let in_slots = slots as f64 / parts.len() as f64 * roller.axial_inertia_kg_m2;
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

/// Adds a wheel to the robot's multibody: the hub on the chassis, and a slot on the hub for each roller of its window.
pub(crate) fn insert(
    rapier: &mut PhysicsWorld,
    wheel: &Wheel,
    (chassis, chassis_from_hub): (RigidBodyHandle, Isometry3<f64>),
    (rollers, window): (&[RollerState], &[usize]),
    settings: &Settings,
) -> WheelBody {
    let roller_bodies = settings.roller_bodies;
    let world_from_hub = rapier.bodies[chassis].position() * convert::pose(&chassis_from_hub);
    let hub = rapier.bodies.insert(
        RigidBodyBuilder::dynamic()
            .pose(world_from_hub)
            .can_sleep(false)
            .additional_mass_properties(hub_mass_properties(wheel, settings, window.len())),
    );
    rapier.insert_multibody_joint(chassis, hub, joint_about_z(&chassis_from_hub));

    let slots = window.iter().map(|&roller| {
        let hub_from_roller = &rollers[roller].hub_from_roller;
        let mass = slot_mass_properties(&wheel.rollers[roller], roller_bodies);
        let body = rapier.bodies.insert(
            RigidBodyBuilder::dynamic()
                .pose(world_from_hub * convert::pose(hub_from_roller))
                .can_sleep(false)
                .additional_mass_properties(mass),
        );
        rapier.insert_multibody_joint(hub, body, joint_about_z(hub_from_roller));
        let shape = shape_of_roller(wheel, &wheel.rollers[roller])
            .expect("the shapes are checked before the robot is built");
        let collider = rapier.insert_collider(
            ColliderBuilder::new(shape)
                .density(0.0)
                .collision_groups(crate::groups::ROLLER)
                .solver_groups(InteractionGroups::none()),
            Some(body),
        );
        Slot {
            body,
            collider,
            link: 0,
            dof: 0,
            roller,
            spin_before_rad_s: 0.0,
        }
    });
    WheelBody {
        hub,
        slots: slots.collect(),
        hub_link: 0,
        hub_dof: 0,
        rollers: rollers.to_vec(),
        coasting_torque_in_hub_n_m: Vector3::zeros(),
    }
}
