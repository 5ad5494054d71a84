//! The robot as rapier's multibody: the chassis, the hubs, and every roller as a body on its hub.

use ilon_robot::{MassProperties as RobotMass, Robot, RollerForm, Wheel};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use super::barrel_shape::BarrelShape;
use super::dispatcher::RollerDispatcher;
use super::engine::Engine;
use crate::engine::{convert, groups};
use crate::ground::{self, Ground};
use crate::robot::articulated::Articulated;
use crate::robot::roller::{ARMATURE, RollerState};
use crate::robot::shared_robot::SharedRobot;
use crate::robot::state::State;
use crate::{MotorTorque, Settings};

/// A robot in a rapier world of its own.
#[derive(Clone)]
pub(crate) struct Reference {
    pub(super) rapier: Engine,
    pub(super) chassis: RigidBodyHandle,
    multibody: MultibodyIndex,
    pub(super) hubs: Vec<Hub>,
    /// Corrections of the joint angles; zeros for the chassis.
    displacement: Vec<Real>,
    /// By rapier's degree of freedom.
    pub(super) rates: Vec<f64>,
}

/// The hub of a wheel with its rollers.
#[derive(Clone, Debug)]
pub(super) struct Hub {
    pub body: RigidBodyHandle,
    /// Its link in the multibody.
    link: usize,
    /// The wheel's axis among the multibody's degrees of freedom.
    pub dof: usize,
    /// In the order of the wheel's rollers.
    pub rollers: Vec<RollerBody>,
}

/// The body of a roller.
#[derive(Clone, Copy, Debug)]
pub(super) struct RollerBody {
    body: RigidBodyHandle,
    pub collider: ColliderHandle,
    /// Its spin among the multibody's degrees of freedom.
    pub dof: usize,
    /// Its spin when the step began, in rad/s.
    pub spin_before_rad_s: f64,
}

/// Place of a hinge's angle among rapier's six joint coordinates.
const HINGE: usize = 3;

impl Reference {
    /// A robot in its current state, on the ground.
    pub fn new(robot: &Articulated, ground: &Ground, settings: &Settings) -> Self {
        let gravity = convert::vector(&ground.gravity_in_floor(settings.gravity_m_s2));
        let narrow_phase = NarrowPhase::with_query_dispatcher(RollerDispatcher);
        let mut rapier = Engine::new(gravity, settings, narrow_phase);
        ground::insert_into(ground, &mut rapier.colliders);
        let (chassis, multibody, hubs) = assemble(&mut rapier, robot);
        let mut reference = Self {
            rapier,
            chassis,
            multibody,
            hubs,
            displacement: Vec::new(),
            rates: Vec::new(),
        };
        reference.set_in_motion(robot);
        reference
    }

    /// Sets the robot's angles and rates, and the joints' damping and friction.
    ///
    /// All velocities come from the state, so that a rebuilt robot loses no momentum.
    fn set_in_motion(&mut self, robot: &Articulated) {
        let Articulated {
            robot: shared,
            state,
            wheels,
            ..
        } = robot;
        self.set_joints(shared, wheels.iter().map(|wheel| wheel.rollers.as_slice()));
        let ndofs = self.rapier.multibody_joints[self.multibody].ndofs();
        self.displacement = vec![0.0; ndofs];
        self.rates = vec![0.0; ndofs];
        self.set_wheel_angles(state.wheel_angles_rad());
        self.set_velocities(state);
        self.set_spins(robot);
        let Engine {
            bodies,
            multibody_joints,
            ..
        } = &mut self.rapier;
        let multibody = link_owner(multibody_joints, self.multibody);
        multibody.forward_kinematics(bodies, false);
        multibody.update_rigid_bodies(bodies, true);
    }

    /// Places the robot in rapier in its state of the step's middle, with the rates of its
    /// beginning.
    pub(super) fn place(&mut self, robot: &Articulated) {
        let middle = &robot.step.middle;
        let chassis = &mut self.rapier.bodies[self.chassis];
        chassis.set_position(convert::pose(middle.floor_from_chassis()), false);
        self.set_wheel_angles(middle.wheel_angles_rad());
        self.set_velocities(middle);
        let hubs = self.hubs.iter().zip(&robot.wheels);
        for ((hub, wheel), pose) in hubs.zip(middle.hubs()) {
            // rapier moves the bodies, but not the colliders on them.
            let rotation = UnitQuaternion::from_matrix(&pose.rotation);
            let floor_from_hub = Isometry3::from_parts(pose.center_m.into(), rotation);
            let pose = convert::pose(&floor_from_hub);
            self.rapier.bodies[hub.body].set_position(pose, false);
            for (part, roller) in hub.rollers.iter().zip(&wheel.rollers) {
                let angle_rad = ilon_robot::wrap_angle(roller.angle_rad);
                let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_rad);
                let pose = convert::pose(&(floor_from_hub * roller.hub_from_roller * turned));
                self.rapier.bodies[part.body].set_position(pose, false);
            }
        }
    }

    /// Reads rapier's rates.
    pub(super) fn read_rates(&mut self) {
        let in_rapier = self.rapier.multibody_joints[self.multibody].generalized_velocity();
        for (rate, in_rapier) in self.rates.iter_mut().zip(in_rapier.iter()) {
            *rate = *in_rapier;
        }
    }

    /// Energy in the armatures of the rollers' joints, in J.
    pub fn armatures_j(&self, robot: &Articulated) -> f64 {
        let of_wheel = |index: usize| {
            let hub_rate_in_hub = robot.state.hub_rate_in_hub(index);
            let rollers = robot.wheels[index].rollers.iter();
            let spins = rollers.map(|roller| roller.spin_up_j(roller.spin_rad_s(&hub_rate_in_hub)));
            ARMATURE * spins.sum::<f64>()
        };
        (0..robot.wheels.len()).map(of_wheel).sum()
    }

    /// Sets rapier's wheel angles, kept within one turn.
    fn set_wheel_angles(&mut self, angles_rad: &[f64]) {
        let multibody = link_owner(&mut self.rapier.multibody_joints, self.multibody);
        for (hub, angle_rad) in self.hubs.iter().zip(angles_rad) {
            let link = multibody
                .link(hub.link)
                .expect("links are indexed when built");
            let in_rapier = link.joint().coords()[HINGE];
            let correction = ilon_robot::wrap_angle(*angle_rad) - in_rapier;
            self.displacement[hub.dof] = correction;
        }
        multibody.apply_displacements(&self.displacement);
    }

    /// Sets the droop of each wheel's motor, in N m s/rad, in addition to its bearing's damping.
    pub(super) fn set_droops(&mut self, robot: &Robot, motors: &[MotorTorque]) {
        let multibody = link_owner(&mut self.rapier.multibody_joints, self.multibody);
        for ((hub, wheel), motor) in self.hubs.iter().zip(&robot.wheels).zip(motors) {
            let damping_n_m_s = wheel.joint.damping_n_m_s + motor.droop_n_m_s;
            multibody.damping_mut()[hub.dof] = damping_n_m_s;
        }
    }

    /// Sets the spins of the rollers.
    fn set_spins(&mut self, robot: &Articulated) {
        let multibody = link_owner(&mut self.rapier.multibody_joints, self.multibody);
        let mut rates = multibody.generalized_velocity_mut();
        for (index, (hub, wheel)) in self.hubs.iter().zip(&robot.wheels).enumerate() {
            let hub_rate_in_hub = robot.state.hub_rate_in_hub(index);
            for (part, roller) in hub.rollers.iter().zip(&wheel.rollers) {
                rates[part.dof] = roller.spin_rad_s(&hub_rate_in_hub);
            }
        }
    }

    /// Sets rapier's rates.
    fn set_velocities(&mut self, state: &State) {
        let multibody = link_owner(&mut self.rapier.multibody_joints, self.multibody);
        let mut rates = multibody.generalized_velocity_mut();
        let root = state.velocity_m_s.iter().chain(state.angular_rad_s.iter());
        for (dof, value) in root.enumerate() {
            rates[dof] = *value;
        }
        for (hub, rate_rad_s) in self.hubs.iter().zip(state.wheel_rates_rad_s()) {
            rates[hub.dof] = *rate_rad_s;
        }
    }

    /// The damping, dry friction and inertia of the joints; rapier's default would damp every free
    /// axis by 0.1.
    fn set_joints<'a>(
        &mut self,
        robot: &SharedRobot,
        rollers: impl Iterator<Item = &'a [RollerState]>,
    ) {
        let multibody = link_owner(&mut self.rapier.multibody_joints, self.multibody);
        multibody.damping_mut().fill(0.0);
        for ((hub, wheel), states) in self.hubs.iter().zip(&robot.wheels).zip(rollers) {
            multibody.damping_mut()[hub.dof] = wheel.joint.damping_n_m_s;
            // The rotor acts on the wheel's rotation relative to the chassis. Its small effect on a
            // chassis that rotates about the wheel's axis is left out.
            multibody.armature_mut()[hub.dof] = wheel.drive.reflected_inertia_kg_m2();
            multibody.frictions_mut()[hub.dof] = wheel.dry_friction_n_m();
            let rollers = wheel.rollers.iter().zip(states);
            for (part, (roller, state)) in hub.rollers.iter().zip(rollers) {
                multibody.damping_mut()[part.dof] = roller.joint.damping_n_m_s;
                multibody.frictions_mut()[part.dof] = roller.joint.friction_n_m;
                multibody.armature_mut()[part.dof] = state.armature_kg_m2();
            }
        }
    }
}

/// Builds a robot in a rapier world in its current state: its chassis, its multibody and its hubs.
fn assemble(
    rapier: &mut Engine,
    robot: &Articulated,
) -> (RigidBodyHandle, MultibodyIndex, Vec<Hub>) {
    let Articulated {
        robot: shared,
        chassis_mass,
        state,
        wheels,
        ..
    } = robot;
    let chassis = rapier.bodies.insert(
        RigidBodyBuilder::dynamic()
            .pose(convert::pose(state.floor_from_chassis()))
            .can_sleep(false)
            .additional_mass_properties(mass_properties(&RobotMass {
                center_of_mass_m: Vector3::zeros(),
                ..chassis_mass.clone()
            })),
    );
    let chassis_from_body = Isometry3::from(-chassis_mass.center_of_mass_m);
    // Robots with joints between bodies are refused if rapier moves them.
    for of in shared.shapes() {
        let collider = ColliderBuilder::new(of.shape.clone())
            .position(convert::pose(&(chassis_from_body * of.carrier_from_shape)))
            .density(0.0)
            .collision_groups(groups::CHASSIS)
            .active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS);
        rapier.insert_collider(collider, chassis);
    }
    let parts = shared.wheels.iter().zip(wheels);
    let hubs = parts.map(|(wheel, body)| {
        let chassis_from_hub = chassis_from_body * wheel.body_from_hub;
        insert_wheel(rapier, wheel, (chassis, &chassis_from_hub), &body.rollers)
    });
    let mut hubs = hubs.collect::<Vec<_>>();
    let multibody = index_links(rapier, &mut hubs);
    (chassis, multibody, hubs)
}

fn link_owner(joints: &mut MultibodyJointSet, index: MultibodyIndex) -> &mut Multibody {
    joints
        .get_multibody_mut(index)
        .expect("the robot's multibody lives as long as its bodies")
}

fn mass_properties(mass: &RobotMass) -> MassProperties {
    MassProperties::with_inertia_matrix(
        convert::vector(&mass.center_of_mass_m),
        mass.mass_kg,
        convert::matrix(&mass.inertia_kg_m2),
    )
}

/// Rapier joints turn about their frame's x axis, ours about z: the rotation that takes x to z.
fn x_to_z() -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -std::f64::consts::FRAC_PI_2)
}

/// A joint about the z axis of the child's frame, which stands at `parent_from_child` while its
/// angle is zero.
fn joint_about_z(parent_from_child: &Isometry3<f64>) -> GenericJoint {
    let child_from_joint = Isometry3::from_parts(Default::default(), x_to_z());
    let mut joint = GenericJoint::new(JointAxesMask::LOCKED_REVOLUTE_AXES);
    joint
        .set_local_frame1(convert::pose(&(parent_from_child * child_from_joint)))
        .set_local_frame2(convert::pose(&child_from_joint))
        .set_contacts_enabled(false);
    joint
}

/// Adds a wheel: the hub on the chassis, and its rollers on the hub.
fn insert_wheel(
    rapier: &mut Engine,
    wheel: &Wheel,
    (chassis, chassis_from_hub): (RigidBodyHandle, &Isometry3<f64>),
    rollers: &[RollerState],
) -> Hub {
    let world_from_hub = rapier.bodies[chassis].position() * convert::pose(chassis_from_hub);
    let hub = rapier.bodies.insert(
        RigidBodyBuilder::dynamic()
            .pose(world_from_hub)
            .can_sleep(false)
            .additional_mass_properties(mass_properties(&wheel.hub)),
    );
    rapier.insert_multibody_joint(chassis, hub, joint_about_z(chassis_from_hub));
    let indices = 0..rollers.len();
    Hub {
        body: hub,
        link: 0,
        dof: 0,
        rollers: indices
            .map(|index| insert_roller(rapier, wheel, (hub, world_from_hub), (index, rollers)))
            .collect(),
    }
}

/// Adds a roller as a body on its hub.
fn insert_roller(
    rapier: &mut Engine,
    wheel: &Wheel,
    (hub, world_from_hub): (RigidBodyHandle, Pose),
    (index, states): (usize, &[RollerState]),
) -> RollerBody {
    let (roller, state) = (&wheel.rollers[index], &states[index]);
    let across = roller.transverse_inertia_kg_m2;
    let mass = MassProperties::new(
        Vector::ZERO,
        roller.mass_kg,
        Vector::new(across, across, roller.axial_inertia_kg_m2),
    );
    let body = rapier.bodies.insert(
        RigidBodyBuilder::dynamic()
            .pose(world_from_hub * convert::pose(&state.hub_from_roller))
            .can_sleep(false)
            .additional_mass_properties(mass),
    );
    rapier.insert_multibody_joint(hub, body, joint_about_z(&state.hub_from_roller));
    let shape = match (&roller.form, &state.barrel) {
        (RollerForm::AsModelled(_), _) => state.shape.clone(),
        (_, Some(barrel)) => Some(SharedShape::new(BarrelShape(*barrel))),
        (_, None) => None,
    };
    let shape = shape.expect("the shapes are checked before the robot is built");
    let collider = rapier.insert_collider(
        ColliderBuilder::new(shape)
            .density(0.0)
            .restitution(0.0)
            .active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS)
            .collision_groups(groups::ROLLER),
        body,
    );
    RollerBody {
        body,
        collider,
        dof: 0,
        spin_before_rad_s: 0.0,
    }
}

/// Looks up, once, where each hub stands in the robot's multibody.
fn index_links(rapier: &mut Engine, hubs: &mut [Hub]) -> MultibodyIndex {
    let Engine {
        bodies,
        multibody_joints,
        ..
    } = rapier;
    let find = |joints: &MultibodyJointSet, body: RigidBodyHandle| {
        *joints
            .rigid_body_link(body)
            .expect("every hub is inserted as a link")
    };
    let index = find(multibody_joints, hubs[0].body).multibody;
    // Only now does rapier see that the chassis is free, and puts the root's six axes before all
    // others.
    link_owner(multibody_joints, index).forward_kinematics(bodies, true);
    let place = |body: RigidBodyHandle| {
        let id = find(multibody_joints, body).id;
        let link = multibody_joints[index]
            .link(id)
            .expect("the link of an id exists");
        (id, link.assembly_id())
    };
    for hub in hubs {
        (hub.link, hub.dof) = place(hub.body);
        for roller in &mut hub.rollers {
            (_, roller.dof) = place(roller.body);
        }
    }
    index
}
