//! A robot as one articulated body of a world.

use ilon_robot::{MassProperties as RobotMass, Robot, Wheel};
use nalgebra::{Isometry3, Vector3};
use rapier3d::prelude::*;

use crate::contact::wheel_contact::{Taken, WheelContact};
use crate::engine::convert;
use crate::engine::copy::Engine;
use crate::engine::dispatcher::RollerDispatcher;
use crate::ground::{Anchor, Ground};
use crate::robot::assembly::Assembly;
use crate::robot::energy::{kinetic_j, potential_j};
use crate::robot::roller::{ARMATURE, RollerState};
use crate::robot::shared::SharedRobot;
use crate::robot::state::State;
use crate::world::disturbance::{ActingPush, Payload};
use crate::world::integration_parameters;
use crate::{ContactSolver, MotorTorque, Settings};

/// A robot as one articulated body of a world: chassis, wheels and rollers, in f64 and in a rapier world of its own.
///
/// Each body counts in f32 from an anchor near itself, so that bodies far apart are as exact as one. rapier moves each as if no
/// other were there; what they do to each other and to the ground is solved for all at once, by
/// [`Reactions`](crate::contact::reactions::Reactions).
#[derive(Clone)]
pub(crate) struct Articulated {
    pub rapier: Engine,
    /// The ground as its rapier world has it, and where that counts from.
    pub anchor: Anchor,
    pub robot: SharedRobot,
    pub assembly: Assembly,
    pub state: State,
    /// The state when the last step began.
    pub before: State,
    /// The poses in the middle of the last step; before its reactions with the rates of its beginning, after them with the
    /// mean of the rates, with which it moved on and all work goes.
    pub middle: State,
    /// Where the rates of the last step's beginning would have taken it by its end.
    pub ahead: State,
    /// Whether the last step was short enough to see rollers pass.
    pub sees_rollers_pass: bool,
    pub contacts: Vec<WheelContact>,
    /// What the motors do in the coming step.
    pub motors: Vec<MotorTorque>,
    /// What the motors put on the wheels in the last step.
    pub acted_n_m: Vec<f64>,
    /// Rates by degree of freedom when the step began, and at its end without reactions.
    pub rates_before: Vec<f64>,
    pub rates_free: Vec<f64>,
    /// The torque of each wheel's motor that its gear takes a share of, in N m.
    pub geared_n_m: Vec<f64>,
    /// What each wheel's motor and bearing lose of their impulse in a step per rate that it gains, in N m s per rad/s.
    pub held_n_m_s2: Vec<f64>,
    /// The chassis with what it carries.
    pub chassis_mass: RobotMass,
    pub payloads: Vec<Payload>,
    /// What pushes during the coming step.
    pub pushes: Vec<ActingPush>,
    /// What the motors were asked for when the step began, and the wheels' rates then, in rad/s.
    pub asked: Vec<MotorTorque>,
    pub rates_asked_rad_s: Vec<f64>,
    /// What each wheel did over the step.
    pub counts: Vec<WheelCounts>,
    /// The inertia that a wheel feels on the ground: its own and its share of the robot's mass, in kg m^2.
    pub wheel_inertia_kg_m2: f64,
}

/// What a wheel did over a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WheelCounts {
    /// Angular impulse of the motor, in N m s.
    pub torque_n_m_s: f64,
    pub taken: Taken,
}

impl Articulated {
    /// The ground in a rapier world of its own, before the robot is there.
    pub fn empty_engine(ground: &Ground, settings: &Settings) -> (Engine, Anchor) {
        let narrow_phase = match settings.contacts {
            ContactSolver::Ilon => NarrowPhase::new(),
            ContactSolver::Rapier => NarrowPhase::with_query_dispatcher(RollerDispatcher),
        };
        let gravity = convert::vector(&ground.gravity_in_floor(settings.gravity_m_s2));
        let mut rapier = Engine::new(gravity, integration_parameters(settings), narrow_phase);
        let anchor = Anchor::insert(ground, &mut rapier.colliders, settings.contacts);
        (rapier, anchor)
    }

    /// Puts a robot at rest into a rapier world that has the ground, with its body frame at a pose.
    pub fn build(
        robot: SharedRobot,
        (mut rapier, anchor): (Engine, Anchor),
        floor_from_body: &Isometry3<f64>,
        settings: &Settings,
    ) -> Self {
        let state = State::at_rest(&robot, floor_from_body);
        let chassis_mass = robot.chassis.mass.clone();
        let assembly = Assembly::build(
            &mut rapier,
            (&robot, &chassis_mass),
            &state.seen_from(&anchor),
            &robot.rollers_at_rest(),
            settings.contacts,
        );
        let (dofs, wheels) = (assembly.dofs(&rapier), robot.wheels.len());
        Self {
            before: state.clone(),
            middle: state.clone(),
            ahead: state.clone(),
            sees_rollers_pass: true,
            state,
            contacts: vec![WheelContact::default(); wheels],
            motors: vec![MotorTorque::constant(0.0); wheels],
            acted_n_m: vec![0.0; wheels],
            rates_before: vec![0.0; dofs],
            rates_free: vec![0.0; dofs],
            geared_n_m: vec![0.0; wheels],
            held_n_m_s2: vec![0.0; wheels],
            chassis_mass,
            payloads: Vec::new(),
            pushes: Vec::new(),
            asked: vec![MotorTorque::constant(0.0); wheels],
            rates_asked_rad_s: vec![0.0; wheels],
            counts: vec![WheelCounts::default(); wheels],
            wheel_inertia_kg_m2: wheel_inertia_kg_m2(&robot, 0.0),
            robot,
            assembly,
            rapier,
            anchor,
        }
    }

    /// Builds the robot again, in the state in which it is.
    pub fn rebuild(&mut self, solver: ContactSolver) {
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
            &self.state.seen_from(&self.anchor),
            &rollers,
            solver,
        );
    }
}

impl Articulated {
    /// Its kinetic energy, in J.
    pub fn kinetic_j(&self, solver: ContactSolver) -> f64 {
        let robot = (&*self.robot, &self.chassis_mass);
        let robot_j = kinetic_j(robot, &self.state, &self.assembly.wheels);
        match solver {
            ContactSolver::Ilon => robot_j,
            ContactSolver::Rapier => robot_j + self.armatures_j(),
        }
    }

    /// Its potential energy above the origin of the floor's frame, in J, in a gravity given there, in m/s^2.
    pub fn potential_j(&self, gravity: &Vector3<f64>) -> f64 {
        let robot = (&*self.robot, &self.chassis_mass);
        potential_j(robot, &self.state, gravity)
    }

    /// Energy in the armatures of rollers that are bodies, in J.
    fn armatures_j(&self) -> f64 {
        let wheels = self.assembly.wheels.iter().enumerate();
        let of_wheels = wheels.map(|(index, wheel)| {
            let hub_rate_in_hub = self.state.hub_rate_in_hub(index);
            let rollers = wheel.bodies.iter().map(|part| &wheel.rollers[part.roller]);
            let spins = rollers.map(|roller| roller.spin_up_j(roller.spin_rad_s(&hub_rate_in_hub)));
            ARMATURE * spins.sum::<f64>()
        });
        of_wheels.sum()
    }
}

/// The inertia that a wheel of a robot feels on the ground, in kg m^2: its hub's and its rollers' about its axis, and its share
/// of the robot's mass, with what it carries in kg, at its rim. The mean of the wheels.
pub(crate) fn wheel_inertia_kg_m2(robot: &Robot, carried_kg: f64) -> f64 {
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
            + (robot.mass_kg() + carried_kg) / count * wheel.radius_m * wheel.radius_m
    };
    robot.wheels.iter().map(of).sum::<f64>() / count
}
