//! One wheel in the world: its hub as a body, and its rollers as flywheels on it.
//!
//! The mass of a roller and its inertia across its axis move with the hub and belong to the hub's body; what is left is a
//! flywheel with a rate of its own (`roller`).

use ilon_robot::{MassProperties as RobotMass, RollerForm, RollerSurface, Tread, Wheel};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use crate::ContactSolver;
use crate::contact::tread::{Spring, TreadLaw};
use crate::engine::barrel_shape::BarrelShape;
use crate::engine::convert;
use crate::engine::copy::Engine;
use crate::engine::shapes::shape_of_roller;
use crate::robot::roller::RollerState;

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
    /// Whether its rollers make a circle of its outline, wherever they are on their axles.
    pub is_round: bool,
    /// Whether its rollers can slide along their axles.
    pub has_play: bool,
    /// The rollers.
    pub rollers: Vec<RollerState>,
    /// What the bearings of the rollers put on the hub in the last step beyond what was expected, in its frame, in N m: it
    /// gets that in the next.
    pub owed_in_hub_n_m: Vector3<f64>,
}

/// What the rollers of a wheel touch the ground with, under the load of their robot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// The tread of rollers that give, or that have play.
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
            tread: surface.touching_tread(load_kg).as_ref().map(law),
            rolling_resistance: surface.rolling_resistance,
            load_kg,
        }
    }
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
    rapier: &mut Engine,
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
        body,
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
    rapier: &mut Engine,
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
        let collider = rapier.insert_collider(collider, hub);
        colliders.push(RollerCollider { collider, roller });
    }
    let play_m = wheel.surface.axial_play_m;
    let reach_m = |roller: &RollerState| {
        let center_m = roller.hub_from_roller.translation.vector.norm();
        center_m + roller.bounding_radius_m + 0.5 * play_m
    };
    WheelBody {
        hub,
        hub_link: 0,
        hub_dof: 0,
        colliders,
        bodies,
        reach_m: rollers.iter().map(reach_m).fold(0.0, f64::max),
        surface: Surface::under(&wheel.surface, load_kg),
        is_round: wheel.is_round() && play_m == 0.0,
        has_play: play_m > 0.0,
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

    /// Moves rollers with play along their axles to the end of a step, with gravity in the hub's frame, in m/s^2. Gives the energy that
    /// is lost as they leave the ground, in J.
    pub fn slide_rollers(&mut self, gravity_in_hub: &Vector3<f64>, dt_s: f64) -> f64 {
        let mut lost_j = 0.0;
        for roller in &mut self.rollers {
            let along = gravity_in_hub.dot(&roller.axis_in_hub);
            lost_j += roller.end_slide(along, dt_s);
        }
        lost_j
    }

    /// Places the bodies of rollers on a hub.
    pub fn place_bodies(&self, rapier: &mut Engine, rapier_from_hub: &Isometry3<f64>) {
        for part in &self.bodies {
            let roller = &self.rollers[part.roller];
            let angle_rad = ilon_robot::wrap_angle(roller.angle_rad);
            let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_rad);
            let pose = convert::pose(&(rapier_from_hub * roller.hub_from_roller * turned));
            rapier.bodies[part.body].set_position(pose, false);
        }
    }

    /// Turns the colliders of rollers with the shapes of their file to where the rollers are.
    pub fn turn_rollers(&self, rapier: &mut Engine) {
        for RollerCollider { collider, roller } in &self.colliders {
            let roller = &self.rollers[*roller];
            let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), roller.angle_rad);
            let pose = convert::pose(&(roller.hub_from_roller * turned));
            rapier.colliders[*collider].set_position_wrt_parent(pose);
        }
    }
}
