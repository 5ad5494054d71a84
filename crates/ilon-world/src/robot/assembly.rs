//! Building the robot's multibody: the chassis and the hubs, with colliders for the rollers that can touch the world.

use ilon_robot::{Collision, MassProperties as RobotMass, Robot};
use nalgebra::{Isometry3, Vector3};
use rapier3d::prelude::*;

use crate::engine::copy::Engine;
use crate::engine::shapes::shape_of;
use crate::engine::{convert, groups};
use crate::robot::roller::RollerState;
use crate::robot::state::State;
use crate::robot::wheel::{self, WheelBody};
use crate::{ContactSolver, MotorTorque};

/// The robot's parts in rapier.
#[derive(Clone, Debug)]
pub(crate) struct Assembly {
    pub chassis: RigidBodyHandle,
    pub multibody: MultibodyIndex,
    pub wheels: Vec<WheelBody>,
    /// By how much the joints' angles are corrected; zeros for the chassis.
    displacement: Vec<Real>,
}

/// Place of a hinge's angle among rapier's six joint coordinates.
const HINGE: usize = 3;

impl Assembly {
    /// Builds the robot in a given state, its chassis with what it carries.
    ///
    /// Every velocity is the state's own, so that a robot which is taken apart and built again loses no momentum.
    pub fn build(
        rapier: &mut Engine,
        (robot, chassis_mass): (&Robot, &RobotMass),
        state: &State,
        rollers: &[Vec<RollerState>],
        solver: ContactSolver,
    ) -> Self {
        let chassis = rapier.bodies.insert(
            RigidBodyBuilder::dynamic()
                .pose(convert::pose(state.floor_from_chassis()))
                .can_sleep(false)
                .additional_mass_properties(chassis_mass_properties(chassis_mass)),
        );
        let chassis_from_body = Isometry3::from(-chassis_mass.center_of_mass_m);
        for collision in &robot.chassis.collisions {
            if let Some(collider) = chassis_collider(&chassis_from_body, collision, solver) {
                rapier.insert_collider(collider, chassis);
            }
        }
        let load_kg = robot.mass_kg() / robot.wheels.len() as f64;
        let mut wheels: Vec<WheelBody> = (0..robot.wheels.len())
            .map(|i| {
                wheel::insert(
                    rapier,
                    (&robot.wheels[i], load_kg),
                    (chassis, chassis_from_body * robot.wheels[i].body_from_hub),
                    &rollers[i],
                    solver,
                )
            })
            .collect();
        let multibody = index_links(rapier, &mut wheels);
        set_joints(rapier, multibody, robot, &wheels);
        let ndofs = rapier.multibody_joints[multibody].ndofs();
        let mut assembly = Self {
            chassis,
            multibody,
            wheels,
            displacement: vec![0.0; ndofs],
        };
        assembly.set_wheel_angles(rapier, state.wheel_angles_rad());
        assembly.set_velocities(rapier, state);
        assembly.set_spins(rapier, state);
        let Engine {
            bodies,
            multibody_joints,
            ..
        } = rapier;
        let multibody = link_owner(multibody_joints, multibody);
        multibody.forward_kinematics(bodies, false);
        multibody.update_rigid_bodies(bodies, true);
        assembly
    }

    /// Takes the robot out of the world.
    pub fn remove(&self, rapier: &mut Engine) {
        let wheels = self.wheels.iter();
        let parts = wheels.flat_map(|wheel| wheel.bodies.iter().map(|b| b.body).chain([wheel.hub]));
        for body in parts.chain([self.chassis]) {
            rapier.remove_body(body);
        }
    }

    /// Number of the degrees of freedom of the bodies: six of the chassis and one a wheel.
    pub fn dofs(&self, rapier: &Engine) -> usize {
        rapier.multibody_joints[self.multibody].ndofs()
    }

    /// Rates in rapier by degree of freedom, in m/s and rad/s: those of the chassis's centre of mass, in the floor's frame,
    /// and of the wheels.
    pub fn rates_in_rapier<'a>(&self, rapier: &'a Engine) -> impl Iterator<Item = &'a Real> {
        let multibody = &rapier.multibody_joints[self.multibody];
        multibody.generalized_velocity().into_iter()
    }

    /// Writes down the rates of a state by degree of freedom.
    pub fn rates_of(&self, state: &State, rates: &mut [f64]) {
        rates[..3].copy_from_slice(state.velocity_m_s.as_slice());
        rates[3..6].copy_from_slice(state.angular_rad_s.as_slice());
        for (wheel, rate_rad_s) in self.wheels.iter().zip(&state.wheel_rates_rad_s) {
            rates[wheel.hub_dof] = *rate_rad_s;
        }
    }

    /// Gives a state these rates by degree of freedom.
    pub fn set_rates(&self, rates: &[f64], state: &mut State) {
        state.velocity_m_s = Vector3::from_column_slice(&rates[..3]);
        state.angular_rad_s = Vector3::from_column_slice(&rates[3..6]);
        for (wheel, rate_rad_s) in self.wheels.iter().zip(&mut state.wheel_rates_rad_s) {
            *rate_rad_s = rates[wheel.hub_dof];
        }
    }

    /// Sets rapier's wheel angles, kept within one turn where f32 is fine enough.
    pub fn set_wheel_angles(&mut self, rapier: &mut Engine, angles_rad: &[f64]) {
        let multibody = link_owner(&mut rapier.multibody_joints, self.multibody);
        for (wheel, angle_rad) in self.wheels.iter().zip(angles_rad) {
            let link = multibody
                .link(wheel.hub_link)
                .expect("links are indexed when built");
            let in_rapier = f64::from(link.joint().coords()[HINGE]);
            let correction = ilon_robot::wrap_angle(*angle_rad) - in_rapier;
            self.displacement[wheel.hub_dof] = correction as Real;
        }
        multibody.apply_displacements(&self.displacement);
    }

    /// Sets how much torque each wheel's motor loses per rate gained, in N m s/rad, on top of its bearing's damping.
    pub fn set_droops(&self, rapier: &mut Engine, robot: &Robot, motors: &[MotorTorque]) {
        let multibody = link_owner(&mut rapier.multibody_joints, self.multibody);
        for ((body, wheel), motor) in self.wheels.iter().zip(&robot.wheels).zip(motors) {
            let damping_n_m_s = wheel.joint.damping_n_m_s + motor.droop_n_m_s;
            multibody.damping_mut()[body.hub_dof] = damping_n_m_s as Real;
        }
    }

    /// Sets the spins of rollers that are bodies.
    fn set_spins(&self, rapier: &mut Engine, state: &State) {
        let multibody = link_owner(&mut rapier.multibody_joints, self.multibody);
        let mut rates = multibody.generalized_velocity_mut();
        for (index, wheel) in self.wheels.iter().enumerate() {
            let hub_rate_in_hub = state.hub_rate_in_hub(index);
            for part in &wheel.bodies {
                rates[part.dof] = wheel.rollers[part.roller].spin_rad_s(&hub_rate_in_hub) as Real;
            }
        }
    }

    /// Sets rapier's rates, rounded.
    pub fn set_velocities(&self, rapier: &mut Engine, state: &State) {
        let multibody = link_owner(&mut rapier.multibody_joints, self.multibody);
        let mut rates = multibody.generalized_velocity_mut();
        let root = state.velocity_m_s.iter().chain(state.angular_rad_s.iter());
        for (dof, value) in root.enumerate() {
            rates[dof] = *value as Real;
        }
        for (wheel, rate_rad_s) in self.wheels.iter().zip(&state.wheel_rates_rad_s) {
            rates[wheel.hub_dof] = *rate_rad_s as Real;
        }
    }
}

fn link_owner(joints: &mut MultibodyJointSet, index: MultibodyIndex) -> &mut Multibody {
    joints
        .get_multibody_mut(index)
        .expect("the robot's multibody lives as long as its assembly")
}

fn chassis_mass_properties(mass: &RobotMass) -> MassProperties {
    MassProperties::with_inertia_matrix(
        Vector::ZERO,
        mass.mass_kg as Real,
        convert::matrix(&mass.inertia_kg_m2),
    )
}

fn chassis_collider(
    chassis_from_body: &Isometry3<f64>,
    collision: &Collision,
    solver: ContactSolver,
) -> Option<ColliderBuilder> {
    let (body_from_shape, shape) = shape_of(collision)?;
    let collider = ColliderBuilder::new(shape)
        .position(convert::pose(&(chassis_from_body * body_from_shape)))
        .density(0.0)
        .collision_groups(groups::CHASSIS)
        .active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS)
        .solver_groups(groups::solved(solver));
    Some(collider)
}

/// Looks up, once, where each hub stands in the robot's multibody.
fn index_links(rapier: &mut Engine, wheels: &mut [WheelBody]) -> MultibodyIndex {
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
    let index = find(multibody_joints, wheels[0].hub).multibody;
    // Only now does rapier see that the chassis is free, and give the root its six axes before all others.
    link_owner(multibody_joints, index).forward_kinematics(bodies, true);
    let place = |body: RigidBodyHandle| {
        let id = find(multibody_joints, body).id;
        let link = multibody_joints[index]
            .link(id)
            .expect("the link of an id exists");
        (id, link.assembly_id())
    };
    for wheel in wheels {
        (wheel.hub_link, wheel.hub_dof) = place(wheel.hub);
        for roller in &mut wheel.bodies {
            (_, roller.dof) = place(roller.body);
        }
    }
    index
}

/// The damping of the wheels' bearings; rapier's own default damps every free axis by 0.1. Dry friction is among the
/// reactions.
fn set_joints(rapier: &mut Engine, multibody: MultibodyIndex, robot: &Robot, wheels: &[WheelBody]) {
    let multibody = link_owner(&mut rapier.multibody_joints, multibody);
    multibody.damping_mut().fill(0.0);
    for (body, wheel) in wheels.iter().zip(&robot.wheels) {
        multibody.damping_mut()[body.hub_dof] = wheel.joint.damping_n_m_s as Real;
        // The rotor is felt where the wheel turns against the chassis. What little it adds when the chassis itself turns about
        // the wheel's axis is left out.
        multibody.armature_mut()[body.hub_dof] = wheel.drive.reflected_inertia_kg_m2() as Real;
        if body.bodies.is_empty() {
            continue;
        }
        // Where rollers are bodies, rapier solves dry friction too.
        multibody.frictions_mut()[body.hub_dof] = wheel.dry_friction_n_m() as Real;
        for (part, roller) in body.bodies.iter().zip(&wheel.rollers) {
            multibody.damping_mut()[part.dof] = roller.joint.damping_n_m_s as Real;
            multibody.frictions_mut()[part.dof] = roller.joint.friction_n_m as Real;
            multibody.armature_mut()[part.dof] = body.rollers[part.roller].armature_kg_m2() as Real;
        }
    }
}
