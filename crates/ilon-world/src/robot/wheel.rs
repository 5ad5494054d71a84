//! One wheel in the world: its hub as a body, and its rollers as flywheels on it.
//!
//! A roller is round, and its middle and axis are fixed to the hub. So its motion is the hub's but for one number: its rate
//! about its own axis. Its mass and its inertia across the axis move with the hub and belong to the hub's body; what is left
//! is a flywheel, whose axial momentum I w nothing changes but its bearing and the ground. That is exact, and it costs a
//! roller one number instead of a body, a joint and a row of the mass matrix.

use ilon_robot::{Roller, RollerForm, Wheel};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use crate::engine::convert;
use crate::engine::shapes::shape_of_roller;

/// The hub of a wheel and its rollers.
#[derive(Clone, Debug)]
pub(crate) struct WheelBody {
    /// The hub's body.
    pub hub: RigidBodyHandle,
    /// The hub's link in the robot's multibody.
    pub hub_link: usize,
    /// The wheel's axis among the multibody's degrees of freedom.
    pub hub_dof: usize,
    /// The colliders through which rollers touch the world.
    pub slots: Vec<Slot>,
    /// The rollers.
    pub rollers: Vec<RollerState>,
    /// What the bearings of the rollers put on the hub now, in its frame, in N m.
    pub bearing_torque_in_hub_n_m: Vector3<f64>,
}

/// What a bearing did in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Borne {
    /// Energy that the bearing took, in J.
    pub lost_j: f64,
    /// Torque of the bearing on the hub about the roller's axis, in N m.
    pub torque_on_hub_n_m: f64,
}

/// A collider on the hub that stands for one roller at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slot {
    /// The exact barrel, or the shapes of the roller's file.
    pub collider: ColliderHandle,
    /// The roller it stands for now.
    pub roller: usize,
}

/// A roller's place on its wheel and its motion about its axis.
#[derive(Clone, Debug)]
pub(crate) struct RollerState {
    /// Pose of the roller frame in the hub frame.
    pub hub_from_roller: Isometry3<f64>,
    /// The roller's axis in the hub frame.
    pub axis_in_hub: Vector3<f64>,
    /// Angle of its centre about the hub axis, from the hub frame's x axis, in radians.
    pub place_rad: f64,
    /// Rate about its own axis in space, in rad/s: its spin against the hub plus the hub's own rate about that axis. It
    /// stays while nothing but its bearing touches it, however the hub turns.
    pub axial_rate_rad_s: f64,
    /// Spin against the hub when the step began, in rad/s.
    pub spin_before_rad_s: f64,
    /// Whether the ground touched it in the last step.
    pub touched: bool,
    /// Angle about its axis since the start, in radians, for rollers whose shape is not round.
    pub angle_rad: f64,
    /// Whether the shape that touches the world is the exact barrel, which looks the same at any angle.
    pub round: bool,
    /// Inertia about its axis, in kg m^2.
    axial_inertia_kg_m2: f64,
    /// Bearing damping, in N m s/rad.
    damping_n_m_s: f64,
    /// Bearing dry friction, in N m.
    pub friction_n_m: f64,
    /// What an angular impulse of 1 N m s about its axis does to the roller's rate in a step, in rad/s: its bearing's
    /// damping acts with the rate after the step.
    pub response: f64,
    /// What damping leaves of its spin in a step in the air.
    damping_leaves: f64,
    /// Whether the roller has seized on its axle.
    pub seized: bool,
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
        .set_local_frame1(convert::pose(&(parent_from_child * child_from_joint)))
        .set_local_frame2(convert::pose(&child_from_joint))
        .set_contacts_enabled(false);
    joint
}

impl RollerState {
    /// A roller at rest, for steps of `dt_s`.
    pub fn new(roller: &Roller, dt_s: f64) -> Self {
        let (inertia, damping) = (roller.axial_inertia_kg_m2, roller.joint.damping_n_m_s);
        Self {
            hub_from_roller: roller.hub_from_roller(),
            axis_in_hub: roller.hub_from_roller().rotation * Vector3::z(),
            place_rad: roller.place_rad(),
            axial_rate_rad_s: 0.0,
            spin_before_rad_s: 0.0,
            touched: false,
            angle_rad: 0.0,
            round: !matches!(roller.form, RollerForm::AsModelled(_)),
            axial_inertia_kg_m2: inertia,
            damping_n_m_s: damping,
            friction_n_m: roller.joint.friction_n_m,
            response: 1.0 / (inertia + damping * dt_s),
            damping_leaves: libm::exp(-damping / inertia * dt_s),
            seized: false,
        }
    }

    /// Lets the roller seize on its axle, or frees it; either way it stands still against its hub at that moment.
    pub fn seize(&mut self, seized: bool, hub_rate_in_hub_rad_s: &Vector3<f64>) {
        self.seized = seized;
        self.axial_rate_rad_s = self.carried_rad_s(hub_rate_in_hub_rad_s);
    }

    /// The rate about the roller's axis of a hub with this angular velocity in its own frame, in rad/s.
    fn carried_rad_s(&self, hub_rate_in_hub_rad_s: &Vector3<f64>) -> f64 {
        hub_rate_in_hub_rad_s.dot(&self.axis_in_hub)
    }

    /// The roller's spin against its hub, whose angular velocity in the hub frame is given, in rad/s.
    pub fn spin_rad_s(&self, hub_rate_in_hub_rad_s: &Vector3<f64>) -> f64 {
        if self.seized {
            return 0.0;
        }
        self.axial_rate_rad_s - self.carried_rad_s(hub_rate_in_hub_rad_s)
    }

    /// The roller's angular momentum about its axis, in the hub frame, in kg m^2/s. That of a seized roller is its hub's.
    pub fn momentum_in_hub(&self) -> Vector3<f64> {
        if self.seized {
            return Vector3::zeros();
        }
        self.axial_inertia_kg_m2 * self.axial_rate_rad_s * self.axis_in_hub
    }

    /// The rate about its axis that the roller would have after a step without the ground, in rad/s, for
    /// [`RollerState::response`].
    pub fn free_rate_rad_s(&self, hub_rate_in_hub_rad_s: &Vector3<f64>, dt_s: f64) -> f64 {
        let carried = self.carried_rad_s(hub_rate_in_hub_rad_s);
        let momentum = self.axial_inertia_kg_m2 * self.axial_rate_rad_s;
        (momentum + self.damping_n_m_s * dt_s * carried) * self.response
    }

    /// What damping did to a roller that the ground has just turned: as [`RollerState::free_rate_rad_s`] has it. Its work
    /// goes with the mean spin. Dry friction is among the reactions then.
    pub fn bear(&self, hub_rate_in_hub_rad_s: &Vector3<f64>, dt_s: f64) -> Borne {
        let spin = self.spin_rad_s(hub_rate_in_hub_rad_s);
        let torque_n_m = self.damping_n_m_s * spin;
        Borne {
            lost_j: torque_n_m * 0.5 * (self.spin_before_rad_s + spin) * dt_s,
            torque_on_hub_n_m: torque_n_m,
        }
    }

    /// Lets a roller that touches nothing spin on for `dt_s`: only its bearing acts,
    /// I d(spin)/dt = -damping spin - friction sign(spin), solved exactly for the damping; dry friction never reverses
    /// the spin.
    ///
    /// What the bearing takes from the roller it gives to the hub.
    pub fn coast(&mut self, hub_rate_in_hub_rad_s: &Vector3<f64>, dt_s: f64) -> Borne {
        let inertia = self.axial_inertia_kg_m2;
        let spin = self.spin_rad_s(hub_rate_in_hub_rad_s);
        let damped = spin * self.damping_leaves;
        let stopping = self.friction_n_m / inertia * dt_s;
        let slowed = damped.signum() * (damped.abs() - stopping).max(0.0);
        self.axial_rate_rad_s = slowed + self.carried_rad_s(hub_rate_in_hub_rad_s);
        Borne {
            lost_j: 0.5 * inertia * (spin * spin - slowed * slowed),
            torque_on_hub_n_m: inertia * (spin - slowed) / dt_s,
        }
    }
}

/// Mass properties of the hub body in its frame: the hub, and of each roller what moves with it, its mass and its inertia
/// across its axis; of a seized one all.
fn hub_mass_properties(wheel: &Wheel, states: &[RollerState]) -> MassProperties {
    let mut mass_kg = wheel.hub.mass_kg;
    let mut first_moment = wheel.hub.mass_kg * wheel.hub.center_of_mass_m;
    for roller in &wheel.rollers {
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
    for (roller, state) in wheel.rollers.iter().zip(states) {
        let d = roller.axis_in_hub.into_inner();
        let along = d * d.transpose();
        inertia += about_center(roller.mass_kg, &roller.center_in_hub_m)
            + roller.transverse_inertia_kg_m2 * (Matrix3::identity() - along);
        if state.seized {
            inertia += roller.axial_inertia_kg_m2 * along;
        }
    }
    MassProperties::with_inertia_matrix(
        convert::vector(&center_m),
        mass_kg as Real,
        convert::matrix(&inertia),
    )
}

/// Adds a wheel to the robot's multibody: the hub on the chassis, and a collider on the hub for each roller of its window.
pub(crate) fn insert(
    rapier: &mut PhysicsWorld,
    wheel: &Wheel,
    (chassis, chassis_from_hub): (RigidBodyHandle, Isometry3<f64>),
    (rollers, window): (&[RollerState], &[usize]),
) -> WheelBody {
    let world_from_hub = rapier.bodies[chassis].position() * convert::pose(&chassis_from_hub);
    let hub = rapier.bodies.insert(
        RigidBodyBuilder::dynamic()
            .pose(world_from_hub)
            .can_sleep(false)
            .additional_mass_properties(hub_mass_properties(wheel, rollers)),
    );
    rapier.insert_multibody_joint(chassis, hub, joint_about_z(&chassis_from_hub));
    let mut body = WheelBody {
        hub,
        slots: Vec::with_capacity(rollers.len()),
        hub_link: 0,
        hub_dof: 0,
        rollers: rollers.to_vec(),
        bearing_torque_in_hub_n_m: Vector3::zeros(),
    };
    body.set_window(rapier, wheel, window);
    body
}

impl WheelBody {
    /// Lets a collider stand for each of the rollers named, and for no other.
    pub fn set_window(&mut self, rapier: &mut PhysicsWorld, wheel: &Wheel, window: &[usize]) {
        for slot in self.slots.drain(window.len().min(self.slots.len())..) {
            rapier.remove_collider(slot.collider);
        }
        for (place, &roller) in window.iter().enumerate() {
            let hub_from_roller = convert::pose(&self.rollers[roller].hub_from_roller);
            if let Some(slot) = self.slots.get_mut(place) {
                if slot.roller != roller {
                    slot.roller = roller;
                    rapier.colliders[slot.collider].set_position_wrt_parent(hub_from_roller);
                }
                continue;
            }
            let shape = shape_of_roller(wheel, &wheel.rollers[roller])
                .expect("the shapes are checked before the robot is built");
            let collider = ColliderBuilder::new(shape)
                .position(hub_from_roller)
                .density(0.0)
                .collision_groups(crate::engine::groups::ROLLER)
                .solver_groups(InteractionGroups::none());
            let collider = rapier.insert_collider(collider, Some(self.hub));
            self.slots.push(Slot { collider, roller });
        }
    }

    /// What the rollers put on the hub, in its frame, in N m: their bearings' torques, and what it takes to turn the axes
    /// of flywheels along with it, -W x (I w d), which takes no work.
    pub fn torque_of_rollers_in_hub(&self, hub_rate_in_hub_rad_s: &Vector3<f64>) -> Vector3<f64> {
        let momentum: Vector3<f64> = self.rollers.iter().map(RollerState::momentum_in_hub).sum();
        self.bearing_torque_in_hub_n_m - hub_rate_in_hub_rad_s.cross(&momentum)
    }

    /// Turns the colliders of rollers that are not round to where the rollers are.
    pub fn turn_rollers(&self, rapier: &mut PhysicsWorld) {
        for slot in &self.slots {
            let roller = &self.rollers[slot.roller];
            if !roller.round {
                let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), roller.angle_rad);
                let pose = convert::pose(&(roller.hub_from_roller * turned));
                rapier.colliders[slot.collider].set_position_wrt_parent(pose);
            }
        }
    }
}
