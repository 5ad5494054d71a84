//! One wheel in the world: its hub as a body, and its rollers as flywheels on it.
//!
//! A roller is round, and its middle and axis are fixed to the hub. So its motion is the hub's but for one number: its rate
//! about its own axis. Its mass and its inertia across the axis move with the hub and belong to the hub's body; what is left
//! is a flywheel, whose axial momentum I w nothing changes but its bearing and the ground. That is exact, and it costs a
//! roller one number instead of a body, a joint and a row of the mass matrix.

use std::ops::Deref;
use std::sync::Arc;

use ilon_robot::{
    Barrel, MassProperties as RobotMass, Roller, RollerForm, RollerSurface, Tread, Turned, Wheel,
};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use crate::ContactSolver;
use crate::contact::nearest::PlacedBarrel;
use crate::contact::tread::{Spring, TreadLaw};
use crate::contact::turned::PlacedTurned;
use crate::engine::barrel_shape::BarrelShape;
use crate::engine::convert;
use crate::engine::shapes::shape_of_roller;
use crate::robot::state::HubPose;

/// The hub of a wheel and its rollers.
#[derive(Clone, Debug)]
pub(crate) struct WheelBody {
    /// The hub's body.
    pub hub: RigidBodyHandle,
    /// The hub's link in the robot's multibody.
    pub hub_link: usize,
    /// The wheel's axis among the multibody's degrees of freedom.
    pub hub_dof: usize,
    /// The colliders of the rollers that have the shapes of their file; barrels have none.
    pub colliders: Vec<RollerCollider>,
    /// The bodies of the rollers where rapier solves the contacts; none otherwise.
    pub bodies: Vec<RollerBody>,
    /// No part of the wheel's rollers is further from the hub's middle than this, in metres.
    pub reach_m: f64,
    /// What the rollers touch the ground with.
    pub surface: Surface,
    /// Whether its rollers make a circle of its outline.
    pub is_round: bool,
    /// The rollers.
    pub rollers: Vec<RollerState>,
    /// What the bearings of the rollers put on the hub in the last step beyond what was expected, in its frame, in N m: it
    /// gets that in the next.
    pub owed_in_hub_n_m: Vector3<f64>,
}

/// What the rollers of a wheel touch the ground with, under the load of their robot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// The tread of rollers that give.
    pub tread: Option<TreadLaw>,
    /// Drag per load.
    pub rolling_resistance: f64,
    /// The mass that stands on a wheel, in kg.
    pub load_kg: f64,
}

impl Surface {
    fn under(surface: &RollerSurface, load_kg: f64) -> Self {
        let law = |tread: &Tread| TreadLaw {
            normal: Spring {
                stiffness_n_m: tread.stiffness_n_m,
                damping_n_s_m: tread.damping_under_n_s_m(load_kg),
            },
            shear: Spring {
                stiffness_n_m: tread.shear_n_m(),
                damping_n_s_m: tread.shear_damping_under_n_s_m(load_kg),
            },
            renewal_1_m: tread
                .relaxation_length_m
                .map_or(0.0, |lambda_m| 1.0 / lambda_m),
            load_kg,
        };
        Self {
            tread: surface.tread.as_ref().map(law),
            rolling_resistance: surface.rolling_resistance,
            load_kg,
        }
    }
}

/// What a bearing did in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BearingStep {
    /// Energy that the bearing took, in J.
    pub lost_j: f64,
    /// By how much its torque on the hub about the roller's axis was more than what was expected, in N m.
    pub owed_n_m: f64,
}

/// The collider of a roller that has the shapes of its file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RollerCollider {
    pub collider: ColliderHandle,
    pub roller: usize,
}

/// The body of a roller where rapier solves the contacts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RollerBody {
    pub body: RigidBodyHandle,
    pub collider: ColliderHandle,
    pub roller: usize,
    /// Its spin among the multibody's degrees of freedom.
    pub dof: usize,
    /// Its spin when the step began, in rad/s.
    pub spin_before_rad_s: f64,
}

/// Inertia that a roller's joint gets where rapier solves the contacts, as a multiple of the roller's own about its axis: the
/// least that keeps rollers which should stick below 1 mm/s at 1000 steps a second. Without any they slide at 10 mm/s.
pub(crate) const ARMATURE: f64 = 3.0;

/// The armature of a roller that has seized, in kg m^2: 0.1 N m, more than a contact puts on a roller, takes 1000 s to give it
/// 0.1 rad/s.
const SEIZED_KG_M2: f64 = 1e3;

/// What of a roller stays as it is: its place on its wheel, its shape, its inertia and its bearing. All copies of a robot share
/// it.
#[derive(Debug)]
pub(crate) struct FixedRoller {
    /// Pose of the roller frame in the hub frame.
    pub hub_from_roller: Isometry3<f64>,
    /// The roller's axis in the hub frame.
    pub axis_in_hub: Vector3<f64>,
    /// The exact barrel; `None` where the roller is none.
    pub barrel: Option<Barrel>,
    /// The profile by numbers of a roller that is turned to one.
    pub turned: Option<Turned>,
    /// Radius of a ball around its middle that holds it whole, in metres.
    pub bounding_radius_m: f64,
    /// Inertia about its axis, in kg m^2.
    axial_inertia_kg_m2: f64,
    /// Bearing damping, in N m s/rad.
    damping_n_m_s: f64,
    /// Bearing dry friction, in N m.
    pub friction_n_m: f64,
}

/// A roller and its motion about its axis.
#[derive(Clone, Debug)]
pub(crate) struct RollerState {
    fixed: Arc<FixedRoller>,
    /// Rate about its own axis in space, in rad/s: its spin against the hub plus the hub's own rate about that axis. It
    /// stays while nothing but its bearing touches it, however the hub turns.
    pub axial_rate_rad_s: f64,
    /// The mean of that rate over the last step, if the ground touched it, in rad/s.
    pub mean_rate_rad_s: f64,
    /// The hub's own rate about that axis when the step began, in rad/s.
    hub_carries_rad_s: f64,
    /// What its bearing was expected to put on the hub in the step, in N m.
    expected_n_m: f64,
    /// Whether the ground touched it in the last step.
    pub touched: bool,
    /// Whether the ground pressed on it in the last step.
    pub pressed: bool,
    /// What it still takes to bring it up to its spin since it came down, in J.
    pub spin_up_left_j: f64,
    /// Angle about its axis since the start, in radians, for rollers whose shape is not round.
    pub angle_rad: f64,
    /// What damping leaves of its spin in a step in the air, and how long that step is, in seconds.
    damping_leaves: (f64, f64),
    /// Whether the roller has seized on its axle.
    pub seized: bool,
}

/// What stays as it is can be read of a roller as of itself.
impl Deref for RollerState {
    type Target = FixedRoller;

    fn deref(&self) -> &FixedRoller {
        &self.fixed
    }
}

impl FixedRoller {
    /// A roller of a wheel.
    pub fn new(wheel: &Wheel, roller: &Roller) -> Self {
        let (barrel, turned) = match &roller.form {
            RollerForm::AsModelled(_) => (None, None),
            RollerForm::Turned(turned) => (None, Some(turned.clone())),
            _ => (Some(wheel.barrel(roller)), None),
        };
        let bounding_radius_m = match (&barrel, &turned) {
            (Some(barrel), _) => PlacedBarrel::bounding_radius_m(barrel),
            (None, Some(turned)) => turned.bounding_radius_m(),
            (None, None) => 0.5 * roller.length_m + roller.radius_m,
        };
        Self {
            hub_from_roller: roller.hub_from_roller(),
            axis_in_hub: roller.hub_from_roller().rotation * Vector3::z(),
            bounding_radius_m,
            barrel,
            turned,
            axial_inertia_kg_m2: roller.axial_inertia_kg_m2,
            damping_n_m_s: roller.joint.damping_n_m_s,
            friction_n_m: roller.joint.friction_n_m,
        }
    }
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
    /// A roller at rest.
    pub fn at_rest(fixed: Arc<FixedRoller>) -> Self {
        Self {
            fixed,
            axial_rate_rad_s: 0.0,
            mean_rate_rad_s: 0.0,
            hub_carries_rad_s: 0.0,
            expected_n_m: 0.0,
            touched: false,
            pressed: false,
            spin_up_left_j: 0.0,
            angle_rad: 0.0,
            damping_leaves: (1.0, 0.0),
            seized: false,
        }
    }

    /// The roller's middle on a hub, in the floor's frame, in metres.
    pub fn center_m(&self, hub: &HubPose) -> Vector3<f64> {
        hub.place_m(&self.hub_from_roller.translation.vector)
    }

    /// Its barrel as it is placed by a hub, in the floor's frame; `None` where it has the shapes of its file.
    pub fn placed_barrel(&self, hub: &HubPose) -> Option<PlacedBarrel<'_>> {
        let barrel = self.barrel.as_ref()?;
        Some(PlacedBarrel {
            barrel,
            center_m: self.center_m(hub),
            axis: hub.rotation * self.axis_in_hub,
        })
    }

    /// Its profile by numbers as it is placed by a hub, in the floor's frame; `None` where it has none.
    pub fn placed_turned(&self, hub: &HubPose) -> Option<PlacedTurned<'_>> {
        let turned = self.turned.as_ref()?;
        Some(PlacedTurned {
            turned,
            center_m: self.center_m(hub),
            axis: hub.rotation * self.axis_in_hub,
        })
    }

    /// The largest radius of a roller with an exact shape, in metres; 0 of one that has the shapes of its file.
    pub fn rolling_radius_m(&self) -> f64 {
        match (&self.barrel, &self.turned) {
            (Some(barrel), _) => barrel.sphere_radius_m(0.0),
            (None, Some(turned)) => turned.largest_radius_m(),
            (None, None) => 0.0,
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

    /// Takes over a spin against the hub, in rad/s.
    pub fn set_spin(&mut self, spin_rad_s: f64, hub_rate_in_hub_rad_s: &Vector3<f64>) {
        self.axial_rate_rad_s = spin_rad_s + self.carried_rad_s(hub_rate_in_hub_rad_s);
    }

    /// The armature of the roller's joint where rapier solves the contacts, in kg m^2.
    pub fn armature_kg_m2(&self) -> f64 {
        if self.seized {
            SEIZED_KG_M2
        } else {
            ARMATURE * self.axial_inertia_kg_m2
        }
    }

    /// Energy that it takes to bring the roller up to another spin, in J: half of its inertia times the square of what is
    /// missing.
    pub fn spin_up_j(&self, missing_rad_s: f64) -> f64 {
        0.5 * self.axial_inertia_kg_m2 * missing_rad_s * missing_rad_s
    }

    /// The roller's angular momentum about its axis, in the hub frame, in kg m^2/s. That of a seized roller is its hub's.
    pub fn momentum_in_hub(&self) -> Vector3<f64> {
        if self.seized {
            return Vector3::zeros();
        }
        self.axial_inertia_kg_m2 * self.axial_rate_rad_s * self.axis_in_hub
    }

    /// Begins a step on a hub of this angular velocity in its own frame. Gives the torque that the bearing is about to put on
    /// the hub about the roller's axis, in N m: what it does if the roller keeps its spin where the ground turns it, and
    /// what slows it otherwise.
    pub fn begin_step(&mut self, hub_rate_in_hub_rad_s: &Vector3<f64>, dt_s: f64) -> f64 {
        self.hub_carries_rad_s = self.carried_rad_s(hub_rate_in_hub_rad_s);
        self.expected_n_m = if self.seized {
            0.0
        } else if self.touched {
            self.damping_n_m_s * (self.axial_rate_rad_s - self.hub_carries_rad_s)
        } else {
            self.coasting_torque_n_m(dt_s)
        };
        self.expected_n_m
    }

    /// The rate about its axis that the roller would have after a step without the ground, in rad/s, for
    /// [`RollerState::response`].
    pub fn free_rate_rad_s(&self, dt_s: f64) -> f64 {
        let momentum = self.axial_inertia_kg_m2 * self.axial_rate_rad_s;
        (momentum + self.damping_n_m_s * dt_s * self.hub_carries_rad_s) * self.response(dt_s)
    }

    /// What an angular impulse of 1 N m s about its axis does to the roller's rate in a step, in rad/s: its bearing's damping
    /// acts with the rate after the step.
    pub fn response(&self, dt_s: f64) -> f64 {
        1.0 / (self.axial_inertia_kg_m2 + self.damping_n_m_s * dt_s)
    }

    /// Ends a step: lets the bearing slow a roller that the ground did not touch. The work of the bearing goes with the mean
    /// spin, for which the hub's mean rate is given; dry friction of a roller that the ground touched is among the
    /// reactions.
    pub fn end_step(&mut self, hub_mean_in_hub_rad_s: &Vector3<f64>, dt_s: f64) -> BearingStep {
        if self.seized {
            return BearingStep::default();
        }
        let (torque_n_m, mean_rad_s) = if self.touched {
            let torque_n_m = self.damping_n_m_s * (self.axial_rate_rad_s - self.hub_carries_rad_s);
            (torque_n_m, self.mean_rate_rad_s)
        } else {
            let torque_n_m = self.coasting_torque_n_m(dt_s);
            let before_rad_s = self.axial_rate_rad_s;
            self.axial_rate_rad_s -= torque_n_m * dt_s / self.axial_inertia_kg_m2;
            (torque_n_m, 0.5 * (before_rad_s + self.axial_rate_rad_s))
        };
        let spin_rad_s = mean_rad_s - self.carried_rad_s(hub_mean_in_hub_rad_s);
        self.angle_rad += spin_rad_s * dt_s;
        BearingStep {
            lost_j: torque_n_m * spin_rad_s * dt_s,
            owed_n_m: torque_n_m - self.expected_n_m,
        }
    }

    /// The mean torque that slows a roller in the air over a step: I d(spin)/dt = -damping spin - friction sign(spin), solved
    /// exactly for the damping; dry friction never reverses the spin.
    fn coasting_torque_n_m(&mut self, dt_s: f64) -> f64 {
        let inertia = self.axial_inertia_kg_m2;
        let spin = self.axial_rate_rad_s - self.hub_carries_rad_s;
        if self.damping_leaves.1 != dt_s {
            self.damping_leaves = (libm::exp(-self.damping_n_m_s / inertia * dt_s), dt_s);
        }
        let damped = spin * self.damping_leaves.0;
        let stopping = self.friction_n_m / inertia * dt_s;
        let slowed = damped.signum() * (damped.abs() - stopping).max(0.0);
        inertia * (spin - slowed) / dt_s
    }
}

/// Mass properties of the hub body in its frame: the hub, and of each roller what moves with it, its mass and its inertia
/// across its axis; of a seized one all.
fn hub_mass_properties(wheel: &Wheel, states: &[RollerState]) -> MassProperties {
    let rollers = wheel.rollers.iter().zip(states);
    let carried = rollers.map(|(roller, state)| {
        let d = roller.axis_in_hub.into_inner();
        let along = d * d.transpose();
        let mut inertia_kg_m2 = roller.transverse_inertia_kg_m2 * (Matrix3::identity() - along);
        if state.seized {
            inertia_kg_m2 += roller.axial_inertia_kg_m2 * along;
        }
        RobotMass {
            inertia_kg_m2,
            ..RobotMass::point(roller.mass_kg, roller.center_in_hub_m)
        }
    });
    let parts: Vec<RobotMass> = [wheel.hub.clone()].into_iter().chain(carried).collect();
    let whole = RobotMass::merged(&parts).unwrap_or_else(|| wheel.hub.clone());
    mass_properties(&whole)
}

fn mass_properties(mass: &RobotMass) -> MassProperties {
    MassProperties::with_inertia_matrix(
        convert::vector(&mass.center_of_mass_m),
        mass.mass_kg as Real,
        convert::matrix(&mass.inertia_kg_m2),
    )
}

/// Adds a roller to the robot's multibody as a body on its hub.
fn insert_roller(
    rapier: &mut PhysicsWorld,
    wheel: &Wheel,
    (hub, world_from_hub): (RigidBodyHandle, Pose),
    (index, states): (usize, &[RollerState]),
) -> RollerBody {
    let (roller, state) = (&wheel.rollers[index], &states[index]);
    let across = roller.transverse_inertia_kg_m2 as Real;
    let mass = MassProperties::new(
        Vector::ZERO,
        roller.mass_kg as Real,
        Vector::new(across, across, roller.axial_inertia_kg_m2 as Real),
    );
    let body = rapier.bodies.insert(
        RigidBodyBuilder::dynamic()
            .pose(world_from_hub * convert::pose(&state.hub_from_roller))
            .can_sleep(false)
            .additional_mass_properties(mass),
    );
    rapier.insert_multibody_joint(hub, body, joint_about_z(&state.hub_from_roller));
    let shape = match (&roller.form, &state.barrel) {
        (RollerForm::AsModelled(modelled), _) => shape_of_roller(modelled),
        (_, Some(barrel)) => Some(SharedShape::new(BarrelShape::new(barrel))),
        (_, None) => None,
    };
    let shape = shape.expect("the shapes are checked before the robot is built");
    let collider = rapier.insert_collider(
        ColliderBuilder::new(shape)
            .density(0.0)
            .restitution(0.0)
            .active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS)
            .collision_groups(crate::engine::groups::ROLLER),
        Some(body),
    );
    RollerBody {
        body,
        collider,
        roller: index,
        dof: 0,
        spin_before_rad_s: 0.0,
    }
}

/// Adds a wheel to the robot's multibody: the hub on the chassis, and a collider on the hub for each roller that has the
/// shapes of its file. Where rapier solves the contacts, each roller is a body on the hub. `load_kg` is the mass that stands on
/// the wheel.
pub(crate) fn insert(
    rapier: &mut PhysicsWorld,
    (wheel, load_kg): (&Wheel, f64),
    (chassis, chassis_from_hub): (RigidBodyHandle, Isometry3<f64>),
    rollers: &[RollerState],
    solver: ContactSolver,
) -> WheelBody {
    let world_from_hub = rapier.bodies[chassis].position() * convert::pose(&chassis_from_hub);
    let hub = rapier.bodies.insert(
        RigidBodyBuilder::dynamic()
            .pose(world_from_hub)
            .can_sleep(false)
            .additional_mass_properties(match solver {
                ContactSolver::Ilon => hub_mass_properties(wheel, rollers),
                ContactSolver::Rapier => mass_properties(&wheel.hub),
            }),
    );
    rapier.insert_multibody_joint(chassis, hub, joint_about_z(&chassis_from_hub));
    let bodies: Vec<RollerBody> = match solver {
        ContactSolver::Ilon => Vec::new(),
        ContactSolver::Rapier => (0..rollers.len())
            .map(|roller| insert_roller(rapier, wheel, (hub, world_from_hub), (roller, rollers)))
            .collect(),
    };
    let mut colliders = Vec::new();
    for (roller, state) in rollers.iter().enumerate() {
        let RollerForm::AsModelled(modelled) = &wheel.rollers[roller].form else {
            continue;
        };
        if solver == ContactSolver::Rapier {
            continue;
        }
        let shape =
            shape_of_roller(modelled).expect("the shapes are checked before the robot is built");
        let collider = ColliderBuilder::new(shape)
            .position(convert::pose(&state.hub_from_roller))
            .density(0.0)
            .collision_groups(crate::engine::groups::ROLLER)
            .solver_groups(InteractionGroups::none());
        let collider = rapier.insert_collider(collider, Some(hub));
        colliders.push(RollerCollider { collider, roller });
    }
    let reach_m = |roller: &RollerState| {
        roller.hub_from_roller.translation.vector.norm() + roller.bounding_radius_m
    };
    WheelBody {
        hub,
        hub_link: 0,
        hub_dof: 0,
        colliders,
        bodies,
        reach_m: rollers.iter().map(reach_m).fold(0.0, f64::max),
        surface: Surface::under(&wheel.surface, load_kg),
        is_round: wheel.is_round(),
        rollers: rollers.to_vec(),
        owed_in_hub_n_m: Vector3::zeros(),
    }
}

impl WheelBody {
    /// Begins a step of `dt_s` for the rollers. Gives what they put on the hub, in its frame, in N m: their bearings' torques,
    /// and what it takes to turn the axes of flywheels along with it, -W x (I w d), which takes no work.
    pub fn begin_step(&mut self, hub_rate_in_hub_rad_s: &Vector3<f64>, dt_s: f64) -> Vector3<f64> {
        let mut bearings = self.owed_in_hub_n_m;
        let mut momentum = Vector3::zeros();
        for roller in &mut self.rollers {
            momentum += roller.momentum_in_hub();
            bearings += roller.begin_step(hub_rate_in_hub_rad_s, dt_s) * roller.axis_in_hub;
        }
        bearings - hub_rate_in_hub_rad_s.cross(&momentum)
    }

    /// Ends it, with the hub's mean rate. Gives the energy that the bearings took, in J.
    pub fn end_step(&mut self, hub_mean_in_hub_rad_s: &Vector3<f64>, dt_s: f64) -> f64 {
        self.owed_in_hub_n_m = Vector3::zeros();
        let mut lost_j = 0.0;
        for roller in &mut self.rollers {
            let borne = roller.end_step(hub_mean_in_hub_rad_s, dt_s);
            lost_j += borne.lost_j;
            self.owed_in_hub_n_m += borne.owed_n_m * roller.axis_in_hub;
        }
        lost_j
    }

    /// Places the bodies of rollers on a hub.
    pub fn place_bodies(&self, rapier: &mut PhysicsWorld, rapier_from_hub: &Isometry3<f64>) {
        for part in &self.bodies {
            let roller = &self.rollers[part.roller];
            let angle_rad = ilon_robot::wrap_angle(roller.angle_rad);
            let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_rad);
            let pose = convert::pose(&(rapier_from_hub * roller.hub_from_roller * turned));
            rapier.bodies[part.body].set_position(pose, false);
        }
    }

    /// Turns the colliders of rollers with the shapes of their file to where the rollers are.
    pub fn turn_rollers(&self, rapier: &mut PhysicsWorld) {
        for RollerCollider { collider, roller } in &self.colliders {
            let roller = &self.rollers[*roller];
            let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), roller.angle_rad);
            let pose = convert::pose(&(roller.hub_from_roller * turned));
            rapier.colliders[*collider].set_position_wrt_parent(pose);
        }
    }
}
