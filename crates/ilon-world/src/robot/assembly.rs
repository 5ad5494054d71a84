//! Building the robot's multibody: the chassis and the hubs, with colliders for the rollers that can touch the world.

use ilon_robot::{Collision, MassProperties as RobotMass, Robot};
use nalgebra::Isometry3;
use rapier3d::prelude::*;

use crate::engine::shapes::shape_of;
use crate::engine::{convert, groups};
use crate::robot::state::State;
use crate::robot::wheel::{self, RollerState, WheelBody};

/// The robot's parts in rapier.
#[derive(Clone, Debug)]
pub(crate) struct Assembly {
    pub chassis: RigidBodyHandle,
    pub multibody: MultibodyIndex,
    pub wheels: Vec<WheelBody>,
    /// Zeros but for one entry while a joint's angle is set.
    displacement: Vec<Real>,
}

/// Place of a hinge's angle among rapier's six joint coordinates.
const HINGE: usize = 3;

impl Assembly {
    /// Builds the robot in a given state.
    ///
    /// `windows` names, for each wheel, the rollers that get a collider. Every velocity is the state's own, so that a
    /// robot which is taken apart and built again loses no momentum.
    pub fn build(
        rapier: &mut PhysicsWorld,
        robot: &Robot,
        state: &State,
        rollers: &[Vec<RollerState>],
        windows: &[Vec<usize>],
    ) -> Self {
        let chassis = rapier.bodies.insert(
            RigidBodyBuilder::dynamic()
                .pose(convert::pose(&state.floor_from_chassis))
                .can_sleep(false)
                .additional_mass_properties(chassis_mass_properties(&robot.chassis.mass)),
        );
        let chassis_from_body = Isometry3::from(-robot.chassis.mass.center_of_mass_m);
        for collision in &robot.chassis.collisions {
            if let Some(collider) = chassis_collider(&chassis_from_body, collision) {
                rapier.insert_collider(collider, Some(chassis));
            }
        }
        let mut wheels: Vec<WheelBody> = (0..robot.wheels.len())
            .map(|i| {
                wheel::insert(
                    rapier,
                    &robot.wheels[i],
                    (chassis, chassis_from_body * robot.wheels[i].body_from_hub),
                    (&rollers[i], &windows[i]),
                )
            })
            .collect();
        let multibody = index_links(rapier, &mut wheels);
        set_damping(rapier, multibody, robot, &wheels);
        let ndofs = rapier.multibody_joints[multibody].ndofs();
        let mut assembly = Self {
            chassis,
            multibody,
            wheels,
            displacement: vec![0.0; ndofs],
        };
        assembly.set_wheel_angles(rapier, &state.wheel_angles_rad);
        assembly.set_velocities(rapier, state);
        let PhysicsWorld {
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
    pub fn remove(&self, rapier: &mut PhysicsWorld) {
        let hubs = self.wheels.iter().map(|wheel| wheel.hub);
        for body in hubs.chain([self.chassis]) {
            rapier.remove_body(body);
        }
    }

    /// The robot's multibody.
    pub fn multibody_mut<'a>(&self, rapier: &'a mut PhysicsWorld) -> &'a mut Multibody {
        link_owner(&mut rapier.multibody_joints, self.multibody)
    }

    /// Rate along one degree of freedom: m/s or rad/s.
    pub fn rate(&self, rapier: &PhysicsWorld, dof: usize) -> f64 {
        f64::from(rapier.multibody_joints[self.multibody].generalized_velocity()[dof])
    }

    /// Sets rapier's wheel angles, kept within one turn where f32 is fine enough.
    pub fn set_wheel_angles(&mut self, rapier: &mut PhysicsWorld, angles_rad: &[f64]) {
        let multibody = link_owner(&mut rapier.multibody_joints, self.multibody);
        for (wheel, angle_rad) in self.wheels.iter().zip(angles_rad) {
            let link = multibody
                .link(wheel.hub_link)
                .expect("links are indexed when built");
            let in_rapier = f64::from(link.joint().coords()[HINGE]);
            let correction = (ilon_robot::wrap_angle(*angle_rad) - in_rapier) as Real;
            if correction != 0.0 {
                self.displacement[wheel.hub_dof] = correction;
                multibody.apply_displacements(&self.displacement);
                self.displacement[wheel.hub_dof] = 0.0;
            }
        }
    }

    /// Sets how much torque each wheel's motor loses per rate gained, in N m s/rad, on top of its bearing's damping.
    pub fn set_droops(&self, rapier: &mut PhysicsWorld, robot: &Robot, droops_n_m_s: &[f64]) {
        let multibody = link_owner(&mut rapier.multibody_joints, self.multibody);
        for ((body, wheel), droop) in self.wheels.iter().zip(&robot.wheels).zip(droops_n_m_s) {
            multibody.damping_mut()[body.hub_dof] = (wheel.joint.damping_n_m_s + droop) as Real;
        }
    }

    fn set_velocities(&self, rapier: &mut PhysicsWorld, state: &State) {
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
) -> Option<ColliderBuilder> {
    let (body_from_shape, shape) = shape_of(collision)?;
    let collider = ColliderBuilder::new(shape)
        .position(convert::pose(&(chassis_from_body * body_from_shape)))
        .density(0.0)
        .collision_groups(groups::CHASSIS)
        .solver_groups(InteractionGroups::none());
    Some(collider)
}

/// Looks up, once, where each hub stands in the robot's multibody.
fn index_links(rapier: &mut PhysicsWorld, wheels: &mut [WheelBody]) -> MultibodyIndex {
    let PhysicsWorld {
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
    }
    index
}

/// The damping of the wheels' bearings; rapier's own default damps every free axis by 0.1. Dry friction is among the
/// reactions.
fn set_damping(
    rapier: &mut PhysicsWorld,
    multibody: MultibodyIndex,
    robot: &Robot,
    wheels: &[WheelBody],
) {
    let multibody = link_owner(&mut rapier.multibody_joints, multibody);
    multibody.damping_mut().fill(0.0);
    for (body, wheel) in wheels.iter().zip(&robot.wheels) {
        multibody.damping_mut()[body.hub_dof] = wheel.joint.damping_n_m_s as Real;
    }
}
