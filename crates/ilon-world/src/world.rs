//! The world: a robot on a floor, stepped by rapier.

mod check;
mod disturbance;
mod standing;
#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

use ilon_robot::{
    MassProperties as RobotMass, Pose as PlanarPose, Robot, Twist, Wheel, roll_pitch_yaw,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use crate::contact::reaction::{Part, Reaction};
use crate::contact::readout::{Taken, WheelContact};
use crate::contact::solve::{Reactions, Scene};
use crate::engine::convert;
use crate::engine::copy::Engine;
use crate::ground::Ground;
use crate::robot::assembly::Assembly;
use crate::robot::energy::{Energy, kinetic_j, potential_j};
use crate::robot::state::State;
use crate::robot::wheel::RollerState;
use crate::{Floor, MotorTorque, Settings, WorldError};
use disturbance::ActingPush;
pub use disturbance::{Payload, Push};

/// What a contact may be in the ground beyond its start at the end of a step that moves on with the mean of the rates, in
/// metres. Where one would be deeper, it has landed, and the step moves on with the rates after it.
const SINKS_M: f64 = 5e-6;

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
    robot: Robot,
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
    /// The chassis without what it carries.
    bare_chassis: RobotMass,
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
    /// In the springs of the contacts now.
    springs_j: f64,
}

/// The chassis as seen from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState {
    /// Position of the body frame's origin in the ground plane and heading.
    pub pose: PlanarPose,
    /// Height of the body frame's origin, in metres.
    pub height_m: f64,
    /// Roll about the body's x axis, in radians.
    pub roll_rad: f64,
    /// Pitch about the body's y axis, in radians.
    pub pitch_rad: f64,
    /// Velocity of the body frame's origin and yaw rate, in the body frame.
    pub twist_in_body: Twist,
}

impl World {
    /// Builds a robot standing on a floor with its body frame at `start`, at rest, its wheels just touching.
    ///
    /// On a slope `start` counts in the slope's own plane. On boxes and bumps the robot is lowered upright until the first of
    /// its wheels touches; the others fall the rest of the way in the first steps.
    ///
    /// # Errors
    /// [`WorldError`] where a setting or the floor makes no sense, a roller has no shape, or the robot would lie on its chassis
    /// or leave a wheel hanging by more than its radius where it starts.
    pub fn new(
        robot: &Robot,
        floor: &Floor,
        start: PlanarPose,
        settings: &Settings,
    ) -> Result<Self, WorldError> {
        check::check(robot, floor, settings)?;
        let mut rapier = PhysicsWorld {
            integration_parameters: integration_parameters(settings),
            narrow_phase: NarrowPhase::new(),
            ..PhysicsWorld::default()
        };
        let mut ground = floor.insert(&mut rapier.colliders);

        let start_m = Vector3::new(start.x_m, start.y_m, 0.0);
        ground.follow(&start_m, &mut rapier.colliders);
        let state = State::at_rest(robot, &standing::standing(robot, floor, &ground, start)?);
        rapier.gravity = convert::vector(&ground.gravity_in_floor(settings.gravity_m_s2));
        let rollers: Vec<Vec<RollerState>> = robot
            .wheels
            .iter()
            .map(|wheel| {
                let state_of = |roller| RollerState::new(wheel, roller);
                wheel.rollers.iter().map(state_of).collect()
            })
            .collect();
        let assembly = Assembly::build(&mut rapier, robot, &state.seen_from(&ground), &rollers);
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
            bare_chassis: robot.chassis.mass.clone(),
            payloads: Vec::new(),
            pushes: Vec::new(),
            reactions: Reactions::default(),
            asked: vec![MotorTorque::constant(0.0); robot.wheels.len()],
            rates_asked_rad_s: vec![0.0; robot.wheels.len()],
            counts: vec![WheelCounts::default(); robot.wheels.len()],
            residual_m_s: 0.0,
            wheel_inertia_kg_m2: wheel_inertia_kg_m2(robot),
            steps: 0,
            robot: robot.clone(),
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

    /// Advances the world by a time.
    ///
    /// The poses move on by half of it with the rates of its beginning; rapier finds contacts and accelerations there,
    /// and the reactions follow; with the mean of the rates before and after the poses move on to its end. That is of
    /// second order in the time where nothing lands.
    fn advance(&mut self, dt_s: f64) {
        let half_s = 0.5 * dt_s;
        for (index, motor) in self.motors.iter_mut().enumerate() {
            let gained_rad_s = self.state.wheel_rates_rad_s[index] - self.rates_asked_rad_s[index];
            *motor = self.asked[index]
                .after_gaining(gained_rad_s)
                .over(dt_s, self.wheel_inertia_kg_m2);
        }
        self.before.copy_from(&self.state);
        self.middle.copy_from(&self.state);
        self.middle.advance(half_s);
        self.sees_rollers_pass = self.rollers_pass_in_steps(dt_s);
        self.ahead.copy_from(&self.middle);
        self.ahead.advance(half_s);
        self.rapier.integration_parameters.dt = dt_s as Real;
        self.pose_rapier();
        self.hand_over_torques(dt_s);
        self.begin_pushes();
        self.rapier.step();
        self.react(dt_s);
        self.move_on(dt_s);
        self.count_motors(dt_s);
        self.read_contacts(dt_s);
        self.run_bearings(dt_s);
        self.end_pushes(dt_s);
    }

    /// Simulated time since the start, in seconds.
    pub fn time_s(&self) -> f64 {
        self.steps as f64 * self.settings.dt_s
    }

    /// Length of one step, in seconds.
    pub fn dt_s(&self) -> f64 {
        self.settings.dt_s
    }

    /// Pose and velocity of the body.
    pub fn body(&self) -> BodyState {
        let center_m = self.robot.chassis.mass.center_of_mass_m;
        let floor_from_body = self.state.floor_from_chassis() * Translation3::from(-center_m);
        let position = floor_from_body.translation.vector;
        let rotation = floor_from_body.rotation.to_rotation_matrix();
        let [roll_rad, pitch_rad, heading_rad] = roll_pitch_yaw(&rotation);
        let body_from_floor = floor_from_body.rotation.inverse();
        let angular_in_body = body_from_floor * self.state.angular_rad_s;
        let velocity_in_body =
            body_from_floor * self.state.velocity_m_s - angular_in_body.cross(&center_m);
        BodyState {
            pose: PlanarPose {
                x_m: position.x,
                y_m: position.y,
                heading_rad,
            },
            height_m: position.z,
            roll_rad,
            pitch_rad,
            twist_in_body: Twist::new(velocity_in_body.x, velocity_in_body.y, angular_in_body.z),
        }
    }

    /// Angles of the wheels about their hub axes since the start, in rad, not wrapped.
    pub fn wheel_angles_rad(&self) -> &[f64] {
        self.state.wheel_angles_rad()
    }

    /// Rates of the wheels about their hub axes, in rad/s.
    pub fn wheel_rates_rad_s(&self) -> &[f64] {
        &self.state.wheel_rates_rad_s
    }

    /// Torques that the motors put on the wheels during the last step, in N m.
    pub fn motor_torques_n_m(&self) -> &[f64] {
        &self.acted_n_m
    }

    /// Height of a wheel's centre above the floor's plane, level or not, in metres.
    ///
    /// # Panics
    /// Where the robot has no such wheel.
    pub fn hub_height_m(&self, wheel: usize) -> f64 {
        self.state.hubs()[wheel].center_m.z
    }

    /// How deep the deepest place of all barrels lies below the surface of the ground now, in metres; 0 where all are clear of
    /// it. Contacts give way by what loads them over [`Settings::contact_stiffness_n_m`], and a landing is caught within a
    /// step; anything more would be an error of the simulation. Rollers with shapes of their file do not count.
    pub fn penetration_m(&self) -> f64 {
        let mut pieces = Vec::new();
        let mut deepest_m = 0.0;
        let hubs = self.state.hubs().iter();
        for (body, hub) in self.assembly.wheels.iter().zip(hubs) {
            self.ground
                .pieces_near(&hub.center_m, body.reach_m, &mut pieces);
            let barrels = body.rollers.iter().filter_map(|r| r.placed_barrel(hub));
            for placed in barrels {
                let gaps = pieces.iter().map(|piece| placed.nearest_to(piece).gap_m);
                deepest_m = gaps.fold(deepest_m, |deepest: f64, gap_m| deepest.max(-gap_m));
            }
        }
        deepest_m
    }

    /// What each wheel's rollers did to the ground during the last step.
    pub fn contacts(&self) -> &[WheelContact] {
        &self.contacts
    }

    /// By how much the laws of contact and of dry friction were broken at the worst place in the last step, in m/s or
    /// rad/s: the speed at which something moves that should not.
    pub fn contact_residual_m_s(&self) -> f64 {
        self.residual_m_s
    }

    /// Energy that sliding at the contacts has turned into heat since the start, in J. It never falls.
    pub fn slip_energy_j(&self) -> f64 {
        self.energies.slip_j
    }

    /// Energy that it took to bring rollers which came down up to their spin since the start, in J. It never falls.
    pub fn spin_up_energy_j(&self) -> f64 {
        self.energies.spin_up_j
    }

    /// Energy that the contacts' normal forces have taken since the start, in J: hits that do not bounce, less what
    /// pushing rollers out of the ground gave back.
    pub fn impact_energy_j(&self) -> f64 {
        self.energies.impact_j
    }

    /// Work of the motors on the wheels since the start, in J; negative where they braked.
    pub fn motor_energy_j(&self) -> f64 {
        self.energies.motor_j
    }

    /// Energy that the bearings of wheels and rollers, and the gears, have turned into heat since the start, in J.
    pub fn bearing_energy_j(&self) -> f64 {
        self.energies.bearing_j
    }

    /// Kinetic and potential energy of the robot now.
    pub fn energy(&self) -> Energy {
        let potential_j = self.potential_j() + self.energies.springs_j;
        Energy {
            kinetic_j: self.kinetic_j(),
            potential_j,
        }
    }

    fn kinetic_j(&self) -> f64 {
        kinetic_j(&self.robot, &self.state, &self.assembly.wheels)
    }

    fn potential_j(&self) -> f64 {
        let gravity = self.ground.gravity_in_floor(self.settings.gravity_m_s2);
        potential_j(&self.robot, &self.state, &gravity)
    }

    /// Spins of all rollers of a wheel about their own axes against the hub, in rad/s, in the robot's order.
    ///
    /// # Panics
    /// Where the robot has no such wheel.
    pub fn roller_spins_rad_s(&self, wheel: usize) -> Vec<f64> {
        let hub_rate_in_hub = self.state.hub_rate_in_hub(wheel);
        let rollers = self.assembly.wheels[wheel].rollers.iter();
        rollers
            .map(|roller| roller.spin_rad_s(&hub_rate_in_hub))
            .collect()
    }

    /// Angles of all rollers of a wheel about their own axes against the hub since the start, in rad, not wrapped, in the robot's
    /// order.
    ///
    /// # Panics
    /// Where the robot has no such wheel.
    pub fn roller_angles_rad(&self, wheel: usize) -> impl Iterator<Item = f64> {
        let rollers = self.assembly.wheels[wheel].rollers.iter();
        rollers.map(|roller| roller.angle_rad)
    }

    /// Puts the robot into rapier as it is in the middle of the step, with the rates of its beginning: the f64 sums, counted
    /// from rapier's own origin and rounded.
    fn pose_rapier(&mut self) {
        let place_m = self.middle.center_m();
        self.ground.follow(&place_m, &mut self.rapier.colliders);
        let rapier_from_floor = self.ground.rapier_from_floor();
        let in_rapier = rapier_from_floor * self.middle.floor_from_chassis();
        let chassis = &mut self.rapier.bodies[self.assembly.chassis];
        chassis.set_position(convert::pose(&in_rapier), false);
        self.assembly
            .set_wheel_angles(&mut self.rapier, self.middle.wheel_angles_rad());
        self.assembly.set_velocities(&mut self.rapier, &self.middle);
        for (wheel, hub) in self.assembly.wheels.iter().zip(self.middle.hubs()) {
            // rapier moves the hubs by itself, but not the colliders on them.
            if !wheel.colliders.is_empty() {
                let rotation = UnitQuaternion::from_matrix(&hub.rotation);
                let floor_from_hub = Isometry3::from_parts(hub.center_m.into(), rotation);
                let pose = convert::pose(&(rapier_from_floor * floor_from_hub));
                self.rapier.bodies[wheel.hub].set_position(pose, false);
                wheel.turn_rollers(&mut self.rapier);
            }
        }
    }

    /// Hands rapier the motors' torques, and what the rollers put on the hubs.
    fn hand_over_torques(&mut self, dt_s: f64) {
        let mut reaction = Vector3::zeros();
        for (index, motor) in self.motors.iter().enumerate() {
            let wheel = &mut self.assembly.wheels[index];
            let floor_from_hub = &self.middle.hubs()[index].rotation;
            let hub_rate_in_hub = self.middle.hub_rate_in_hub(index);
            // rapier's damping takes droop x rate off; only droop x (rate - rate now) shall go.
            let undamped_n_m = motor.droop_n_m_s * self.middle.wheel_rates_rad_s[index];
            let torque = floor_from_hub * Vector3::z() * (motor.torque_n_m + undamped_n_m);
            let hub = &mut self.rapier.bodies[wheel.hub];
            hub.reset_torques(false);
            let rollers = floor_from_hub * wheel.begin_step(&hub_rate_in_hub, dt_s);
            hub.add_torque(convert::vector(&(torque + rollers)), false);
            reaction -= torque;
        }
        let chassis = &mut self.rapier.bodies[self.assembly.chassis];
        chassis.reset_torques(false);
        chassis.add_torque(convert::vector(&reaction), false);
        self.assembly
            .set_droops(&mut self.rapier, &self.robot, &self.motors);
    }

    /// Solves for the reactions of the step that rapier has just taken without any, and corrects the rates by them.
    ///
    /// rapier's rates are rounded; what they gained in the step is added to the f64 ones.
    fn react(&mut self, dt_s: f64) {
        self.assembly.rates_of(&self.before, &mut self.rates_before);
        let in_rapier = self.assembly.rates_in_rapier(&self.rapier);
        let rates = self.rates_free.iter_mut().zip(&self.rates_before);
        for ((free, before), after) in rates.zip(in_rapier) {
            *free = before + (f64::from(*after) - f64::from(*before as Real));
        }
        let lost = self.motors.iter().zip(&self.robot.wheels);
        for (held, (motor, wheel)) in self.held_n_m_s2.iter_mut().zip(lost) {
            *held = (motor.droop_n_m_s + wheel.joint.damping_n_m_s) * dt_s;
        }
        let motors = self.motors.iter().zip(&self.acted_n_m);
        for (geared_n_m, (motor, acted_n_m)) in self.geared_n_m.iter_mut().zip(motors) {
            // Of a motor that gives way within the step only what it gave in the last one is known.
            *geared_n_m = if motor.is_constant() {
                motor.torque_n_m
            } else {
                *acted_n_m
            };
        }
        self.reactions.react(&Scene {
            rapier: &self.rapier,
            ground: &self.ground,
            robot: &self.robot,
            assembly: &self.assembly,
            settings: &self.settings,
            dt_s,
            before: &self.before,
            middle: &self.middle,
            ahead: &self.ahead,
            sees_rollers_pass: self.sees_rollers_pass,
            rates_before: &self.rates_before,
            rates_free: &self.rates_free,
            motors: &self.motors,
            geared_n_m: &self.geared_n_m,
            held_n_m_s2: &self.held_n_m_s2,
        });
        for (rate, change) in self.rates_free.iter_mut().zip(self.reactions.change()) {
            *rate += change;
        }
        self.assembly.set_rates(&self.rates_free, &mut self.state);
        // From here on the rates before are those that the mean over the step starts from.
        let starts = self
            .rates_before
            .iter_mut()
            .zip(self.reactions.jump().start_change());
        for ((start, change), after) in starts.zip(&self.rates_free) {
            *start = 0.5 * (*start + change + after);
        }
        self.assembly
            .set_rates(&self.rates_before, &mut self.middle);
        let wheels = &mut self.assembly.wheels;
        for roller in wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers) {
            roller.touched = false;
        }
        for touched in self.reactions.touched() {
            let roller = &mut wheels[touched.wheel].rollers[touched.roller];
            roller.axial_rate_rad_s = touched.rate_rad_s;
            roller.mean_rate_rad_s = touched.mean_rad_s;
            roller.touched = true;
        }
    }

    /// Whether rollers pass over the ground in steps of `dt_s` as the wheels turn now.
    ///
    /// In longer ones a roller would be taken to turn on far beyond where it hands over. The mean motion is better then if
    /// each contact stays as it is in the middle of the step, and the robot moves on as that lets it: of many steps the middles
    /// fall anywhere on the rollers, each place as often as it is passed.
    fn rollers_pass_in_steps(&self, dt_s: f64) -> bool {
        /// Steps that a roller's passage takes at least.
        const STEPS: f64 = 6.0;
        let rates = self.state.wheel_rates_rad_s.iter();
        rates.zip(&self.robot.wheels).all(|(rate_rad_s, wheel)| {
            STEPS * dt_s * rate_rad_s.abs() * wheel.rollers.len() as f64 <= TAU
        })
    }

    /// Moves the poses to the end of the step.
    ///
    /// With the mean of the rates before and after, unless a contact would then end deep in the ground: it was stopped at
    /// the ground within the step, and the mean would carry it on. Then with the rates after it, with which it ends there.
    fn move_on(&mut self, dt_s: f64) {
        self.state.advance_with(&self.middle, dt_s);
        if !self.sees_rollers_pass || self.reactions.sinks_m(dt_s) > SINKS_M {
            let with_mean_j = self.potential_j();
            self.state.take_poses(&self.before);
            self.state.advance(dt_s);
            // The height that the mean would have lost is no energy that anything has got.
            self.energies.impact_j += with_mean_j - self.potential_j();
        }
    }

    /// Counts what the motors did.
    fn count_motors(&mut self, dt_s: f64) {
        for (index, motor) in self.motors.iter().enumerate() {
            let after_rad_s = self.state.wheel_rates_rad_s[index];
            let gained_rad_s = after_rad_s - self.before.wheel_rates_rad_s[index];
            self.acted_n_m[index] = motor.torque_n_m - motor.droop_n_m_s * gained_rad_s;
        }
        for reaction in self.reactions.all() {
            if let Part::RateLimit(wheel) = reaction.part {
                self.acted_n_m[wheel] += reaction.impulse.x / dt_s;
            }
        }
        for (index, acted_n_m) in self.acted_n_m.iter().enumerate() {
            let impulse_n_m_s = acted_n_m * dt_s;
            self.energies.motor_j += impulse_n_m_s * self.middle.wheel_rates_rad_s[index];
            self.counts[index].torque_n_m_s += impulse_n_m_s;
        }
    }

    /// Reads the contacts and counts the energy that they took, the chassis's too where it scrapes along.
    fn read_contacts(&mut self, dt_s: f64) {
        self.residual_m_s = self.residual_m_s.max(self.reactions.error());
        let springs_j = self.reactions.spring_energy_j(&self.settings, dt_s);
        self.energies.impact_j -= springs_j - self.energies.springs_j;
        self.energies.springs_j = springs_j;
        let wheels = &mut self.assembly.wheels;
        for reaction in self.reactions.all() {
            let taken = match reaction.part {
                Part::Hub(_) | Part::Axle(..) | Part::RateLimit(_) => continue,
                Part::Chassis => Taken::of(reaction, &mut 0.0),
                Part::Roller(wheel, roller) => {
                    let roller = &mut wheels[wheel].rollers[roller];
                    if !roller.pressed && reaction.impulse.x > 0.0 && !roller.seized {
                        let missing_rad_s = reaction.velocity_before.z / reaction.rolling_radius_m;
                        roller.spin_up_left_j = roller.spin_up_j(missing_rad_s);
                    }
                    let taken = Taken::of(reaction, &mut roller.spin_up_left_j);
                    self.counts[wheel].taken.add(&taken);
                    taken
                }
            };
            self.energies.slip_j += taken.slip_j;
            self.energies.spin_up_j += taken.spin_up_j;
            self.energies.impact_j += taken.impact_j;
        }
        for roller in wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers) {
            roller.pressed = false;
        }
        for reaction in self.reactions.all() {
            if let (Part::Roller(wheel, roller), true) = (reaction.part, reaction.impulse.x > 0.0) {
                wheels[wheel].rollers[roller].pressed = true;
            }
        }
        for (index, contact) in self.contacts.iter_mut().enumerate() {
            let states = (&self.middle, &self.state);
            let wheel = (index, &self.assembly.wheels[index]);
            *contact = WheelContact::read(self.reactions.all(), wheel, states, dt_s);
        }
    }

    /// Lets the bearings act on rollers that nothing touched, and sums what damping and dry friction took out of all of
    /// them. All work goes with the mean rates.
    fn run_bearings(&mut self, dt_s: f64) {
        let mut lost_j = 0.0;
        let wheels = self.assembly.wheels.iter_mut().zip(&self.robot.wheels);
        for (index, (body, wheel)) in wheels.enumerate() {
            lost_j += body.end_step(&self.middle.hub_rate_in_hub(index), dt_s);
            let damping_n_m = wheel.joint.damping_n_m_s * self.state.wheel_rates_rad_s[index];
            lost_j += damping_n_m * self.middle.wheel_rates_rad_s[index] * dt_s;
        }
        let is_bearing = |r: &&Reaction| matches!(r.part, Part::Hub(_) | Part::Axle(..));
        let bearings = self.reactions.all().iter().filter(is_bearing);
        lost_j += bearings.map(|reaction| reaction.taken_j.x).sum::<f64>();
        self.energies.bearing_j += lost_j;
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
            &self.robot,
            &self.state.seen_from(&self.ground),
            &rollers,
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
