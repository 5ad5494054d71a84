//! The world: a robot on a floor, stepped by rapier.

mod advance;
mod check;
mod disturbance;
mod reference;
mod standing;
#[cfg(test)]
mod tests;
mod truth;

use ilon_robot::{MassProperties as RobotMass, Pose as PlanarPose, Robot, Wheel};
use nalgebra::Vector3;
use rapier3d::prelude::*;

use crate::contact::reactions::Reactions;
use crate::contact::wheel_contact::{Taken, WheelContact};
use crate::engine::convert;
use crate::engine::copy::Engine;
use crate::engine::dispatcher::RollerDispatcher;
use crate::ground::Ground;
use crate::robot::assembly::Assembly;
use crate::robot::shared::SharedRobot;
use crate::robot::state::State;
use crate::robot::wheel::RollerState;
use crate::{ContactSolver, Floor, MotorTorque, Settings, WorldError};
use disturbance::ActingPush;
pub use disturbance::{Payload, Push};
pub use truth::BodyState;
/// A robot in a rapier world.
///
/// One step is: [`World::apply`] the wheel torques, then [`World::step`]. What can be read afterwards is the truth, in
/// f64 and in the project's frames; what a robot's sensors make of it is not this crate's business.
///
/// rapier computes in f32. Positions and wheel angles that only ever grow would lose their small increments there, so
/// the world sums them in f64 and hands rapier the rounded sum before every step. A copy goes on to the bit as the original does.
#[derive(Clone)]
pub struct World {
    rapier: Engine,
    ground: Ground,
    robot: SharedRobot,
    settings: Settings,
    assembly: Assembly,
    state: State,
    /// The state when the last step began.
    before: State,
    /// The poses in the middle of the last step; before its reactions with the rates of its beginning, after them with the
    /// mean of the rates, with which it moved on and all work goes.
    middle: State,
    /// Where the rates of the last step's beginning would have taken it by its end.
    ahead: State,
    /// Whether the last step was short enough to see rollers pass.
    sees_rollers_pass: bool,
    contacts: Vec<WheelContact>,
    /// What the motors do in the coming step.
    motors: Vec<MotorTorque>,
    /// What the motors put on the wheels in the last step.
    acted_n_m: Vec<f64>,
    /// Rates by degree of freedom when the step began, and at its end without reactions.
    rates_before: Vec<f64>,
    rates_free: Vec<f64>,
    /// The torque of each wheel's motor that its gear takes a share of, in N m.
    geared_n_m: Vec<f64>,
    /// What each wheel's motor and bearing lose of their impulse in a step per rate that it gains, in N m s per rad/s.
    held_n_m_s2: Vec<f64>,
    energies: Energies,
    /// The chassis with what it carries.
    chassis_mass: RobotMass,
    payloads: Vec<Payload>,
    /// What pushes during the coming step.
    pushes: Vec<ActingPush>,
    reactions: Reactions,
    /// What the motors were asked for when the step began, and the wheels' rates then, in rad/s.
    asked: Vec<MotorTorque>,
    rates_asked_rad_s: Vec<f64>,
    /// What each wheel did over the step.
    counts: Vec<WheelCounts>,
    /// By how much the laws of contact were broken in the step.
    residual_m_s: f64,
    /// The inertia that a wheel feels on the ground: its own and its share of the robot's mass, in kg m^2.
    wheel_inertia_kg_m2: f64,
    steps: u64,
}

/// What a wheel did over a step.
#[derive(Clone, Copy, Debug, Default)]
struct WheelCounts {
    /// Angular impulse of the motor, in N m s.
    torque_n_m_s: f64,
    taken: Taken,
}

/// What has gone where since the start, in J.
#[derive(Clone, Copy, Debug, Default)]
struct Energies {
    slip_j: f64,
    spin_up_j: f64,
    impact_j: f64,
    motor_j: f64,
    bearing_j: f64,
    outside_j: f64,
    /// In the springs of rigid contacts now.
    springs_j: f64,
    /// In the treads of rollers now.
    treads_j: f64,
}

impl World {
    /// Builds a robot standing on a floor with its body frame at `start`, at rest, its wheels just touching. Many worlds of one
    /// robot share it where they are given a [`SharedRobot`].
    ///
    /// On a slope `start` counts in the slope's own plane. On boxes and bumps the robot is lowered upright until the first of
    /// its wheels touches; the others fall the rest of the way in the first steps.
    ///
    /// # Errors
    /// [`WorldError`] where a setting or the floor makes no sense, a roller has no shape, or the robot would lie on its chassis
    /// or leave a wheel hanging by more than its radius where it starts.
    pub fn new(
        robot: impl Into<SharedRobot>,
        floor: &Floor,
        start: PlanarPose,
        settings: &Settings,
    ) -> Result<Self, WorldError> {
        Self::build(robot.into(), floor, start, settings)
    }

    fn build(
        robot: SharedRobot,
        floor: &Floor,
        start: PlanarPose,
        settings: &Settings,
    ) -> Result<Self, WorldError> {
        check::check(&robot, floor, settings)?;
        let mut rapier = PhysicsWorld {
            integration_parameters: integration_parameters(settings),
            narrow_phase: match settings.contacts {
                ContactSolver::Ilon => NarrowPhase::new(),
                ContactSolver::Rapier => NarrowPhase::with_query_dispatcher(RollerDispatcher),
            },
            ..PhysicsWorld::default()
        };
        let mut ground = floor.insert(&mut rapier.colliders, settings.contacts);

        let start_m = Vector3::new(start.x_m, start.y_m, 0.0);
        ground.follow(&start_m, &mut rapier.colliders);
        let state = State::at_rest(&robot, &standing::standing(&robot, floor, &ground, start)?);
        rapier.gravity = convert::vector(&ground.gravity_in_floor(settings.gravity_m_s2));
        let chassis_mass = robot.chassis.mass.clone();
        let assembly = Assembly::build(
            &mut rapier,
            (&robot, &chassis_mass),
            &state.seen_from(&ground),
            &robot.rollers_at_rest(),
            settings.contacts,
        );
        let dofs = assembly.dofs(&rapier);
        Ok(Self {
            ground,
            before: state.clone(),
            middle: state.clone(),
            ahead: state.clone(),
            sees_rollers_pass: true,
            state,
            contacts: vec![WheelContact::default(); robot.wheels.len()],
            motors: vec![MotorTorque::constant(0.0); robot.wheels.len()],
            acted_n_m: vec![0.0; robot.wheels.len()],
            rates_before: vec![0.0; dofs],
            rates_free: vec![0.0; dofs],
            geared_n_m: vec![0.0; robot.wheels.len()],
            held_n_m_s2: vec![0.0; robot.wheels.len()],
            energies: Energies::default(),
            chassis_mass,
            payloads: Vec::new(),
            pushes: Vec::new(),
            reactions: Reactions::default(),
            asked: vec![MotorTorque::constant(0.0); robot.wheels.len()],
            rates_asked_rad_s: vec![0.0; robot.wheels.len()],
            counts: vec![WheelCounts::default(); robot.wheels.len()],
            residual_m_s: 0.0,
            wheel_inertia_kg_m2: wheel_inertia_kg_m2(&robot),
            steps: 0,
            robot,
            settings: settings.clone(),
            assembly,
            rapier: Engine(rapier),
        })
    }

    /// Sets the torques that the motors put on the wheels during the next step, in N m, one a wheel; the chassis takes
    /// the opposite. They hold for one step.
    ///
    /// # Panics
    /// Where there are more or fewer torques than wheels.
    pub fn apply(&mut self, torques_n_m: &[f64]) {
        assert_eq!(torques_n_m.len(), self.motors.len(), "one torque a wheel");
        for (motor, torque_n_m) in self.motors.iter_mut().zip(torques_n_m) {
            *motor = MotorTorque::constant(*torque_n_m);
        }
    }

    /// As [`World::apply`], with torques that depend on the rates of the wheels within the step.
    ///
    /// # Panics
    /// Where there are more or fewer torques than wheels.
    pub fn drive(&mut self, motors: &[MotorTorque]) {
        self.motors.copy_from_slice(motors);
    }

    /// Advances the world by one physics step; in parts, where [`Settings::split_dt_s`] says so.
    pub fn step(&mut self) {
        self.asked.copy_from_slice(&self.motors);
        self.rates_asked_rad_s
            .copy_from_slice(&self.state.wheel_rates_rad_s);
        self.counts.fill(WheelCounts::default());
        self.residual_m_s = 0.0;
        let parts = self.parts();
        let part_s = self.settings.dt_s / f64::from(parts);
        for _ in 0..parts {
            self.advance(part_s);
        }
        self.steps += 1;
        let dt_s = self.settings.dt_s;
        for (index, counts) in self.counts.iter().enumerate() {
            self.acted_n_m[index] = counts.torque_n_m_s / dt_s;
            let contact = &mut self.contacts[index];
            contact.slip_power_w = counts.taken.slip_j / dt_s;
            contact.spin_up_power_w = counts.taken.spin_up_j / dt_s;
            contact.impact_power_w = counts.taken.impact_j / dt_s;
        }
        self.pushes.clear();
        self.motors.fill(MotorTorque::constant(0.0));
    }

    /// In how many parts the coming step is taken.
    fn parts(&self) -> u32 {
        match self.settings.split_dt_s {
            Some(part_s) if self.reactions.about_to_slide() => {
                (self.settings.dt_s / part_s).ceil().max(1.0) as u32
            }
            _ => 1,
        }
    }

    /// Builds the robot again, in the state in which it is.
    fn rebuild(&mut self) {
        let rollers: Vec<Vec<RollerState>> = self
            .assembly
            .wheels
            .iter()
            .map(|wheel| wheel.rollers.clone())
            .collect();
        self.assembly.remove(&mut self.rapier);
        self.assembly = Assembly::build(
            &mut self.rapier,
            (&self.robot, &self.chassis_mass),
            &self.state.seen_from(&self.ground),
            &rollers,
            self.settings.contacts,
        );
    }
}

/// The inertia that a wheel of a robot feels on the ground, in kg m^2: its hub's and its rollers' about its axis, and its share
/// of the robot's mass at its rim. The mean of the wheels.
fn wheel_inertia_kg_m2(robot: &Robot) -> f64 {
    let count = robot.wheels.len() as f64;
    let of = |wheel: &Wheel| {
        let rollers = wheel.rollers.iter();
        let at_ring = rollers.map(|roller| {
            roller.mass_kg * roller.center_in_hub_m.xy().norm_squared()
                + roller.transverse_inertia_kg_m2
        });
        wheel.hub.inertia_kg_m2[(2, 2)]
            + wheel.drive.reflected_inertia_kg_m2()
            + at_ring.sum::<f64>()
            + robot.mass_kg() / count * wheel.radius_m * wheel.radius_m
    };
    robot.wheels.iter().map(of).sum::<f64>() / count
}

/// rapier as it has to be set where its own solver has no contact to solve: it finds contacts and moves bodies.
fn integration_parameters(settings: &Settings) -> IntegrationParameters {
    if settings.contacts == ContactSolver::Rapier {
        return reference::integration_parameters(settings);
    }
    IntegrationParameters {
        dt: settings.dt_s as Real,
        num_solver_iterations: 1,
        // It has no contact to solve, and so none to stabilise.
        num_internal_stabilization_iterations: 0,
        num_internal_pgs_iterations: 1,
        normalized_prediction_distance: settings.prediction_m as Real,
        // One exact contact a roller and piece of ground: nothing to merge, and every force stays where it acts.
        contact_clustering: false,
        // A recycled contact keeps its old lever arm, but a roller's contact wanders along it all the time.
        contact_recycling: false,
        friction_model: FrictionModel::Coulomb,
        max_ccd_substeps: 0,
        ..IntegrationParameters::default()
    }
}
