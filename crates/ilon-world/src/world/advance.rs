//! One step: the robot as rapier has it in the step's middle, the reactions of ground and bearings, and what each took.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use super::World;
use crate::ContactSolver;
use crate::contact::reaction::{Part, Reaction};
use crate::contact::scene::Scene;
use crate::contact::wheel_contact::{Taken, WheelContact};
use crate::engine::convert;

/// What a contact may be in the ground beyond its start at the end of a step that moves on with the mean of the rates, in
/// metres. Where one would be deeper, it has landed, and the step moves on with the rates after it.
const SINKS_M: f64 = 5e-6;

impl World {
    /// Advances the world by a time.
    ///
    /// The poses move on by half of it with the rates of its beginning; rapier finds contacts and accelerations there,
    /// and the reactions follow; with the mean of the rates before and after the poses move on to its end. That is of
    /// second order in the time where nothing lands.
    pub(super) fn advance(&mut self, dt_s: f64) {
        let half_s = 0.5 * dt_s;
        for (index, motor) in self.motors.iter_mut().enumerate() {
            let gained_rad_s = self.state.wheel_rates_rad_s[index] - self.rates_asked_rad_s[index];
            *motor = self.asked[index]
                .after_gaining(gained_rad_s)
                .over(dt_s, self.wheel_inertia_kg_m2);
        }
        if self.settings.contacts == ContactSolver::Rapier {
            return self.advance_in_rapier(dt_s);
        }
        self.before.copy_from(&self.state);
        self.middle.copy_from(&self.state);
        self.middle.advance(half_s);
        self.sees_rollers_pass = self.rollers_pass_in_steps(dt_s);
        self.ahead.copy_from(&self.middle);
        self.ahead.advance(half_s);
        self.rapier.integration_parameters.dt = dt_s as Real;
        self.set_poses_in_rapier();
        self.set_torques_in_rapier(dt_s);
        self.begin_pushes();
        self.rapier.step();
        self.react(dt_s);
        self.move_on(dt_s);
        self.count_motors(dt_s);
        self.read_contacts(dt_s);
        self.run_bearings(dt_s);
        self.end_pushes(dt_s);
    }

    /// Puts the robot into rapier as it is in the middle of the step, with the rates of its beginning: the f64 sums, counted
    /// from rapier's own origin and rounded.
    pub(super) fn set_poses_in_rapier(&mut self) {
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
            if !wheel.colliders.is_empty() || !wheel.bodies.is_empty() {
                let rotation = UnitQuaternion::from_matrix(&hub.rotation);
                let floor_from_hub = Isometry3::from_parts(hub.center_m.into(), rotation);
                let rapier_from_hub = rapier_from_floor * floor_from_hub;
                let pose = convert::pose(&rapier_from_hub);
                self.rapier.bodies[wheel.hub].set_position(pose, false);
                wheel.place_bodies(&mut self.rapier, &rapier_from_hub);
                wheel.turn_rollers(&mut self.rapier);
            }
        }
    }

    /// Gives rapier the motors' torques, and what the rollers put on the hubs.
    fn set_torques_in_rapier(&mut self, dt_s: f64) {
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
        for (index, geared_n_m) in self.geared_n_m.iter_mut().enumerate() {
            // Of a motor whose torque falls within the step only what it gave in the last one is known.
            let motor = &self.motors[index];
            *geared_n_m = if motor.is_constant_from(self.before.wheel_rates_rad_s[index]) {
                motor.torque_n_m
            } else {
                self.acted_n_m[index]
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
    pub(super) fn count_motors(&mut self, dt_s: f64) {
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
    pub(super) fn read_contacts(&mut self, dt_s: f64) {
        self.residual_m_s = self.residual_m_s.max(self.reactions.error());
        let springs_j = match self.settings.contacts {
            ContactSolver::Ilon => self.reactions.spring_energy_j(&self.settings, dt_s),
            // What rapier's soft contacts store goes with the hits.
            ContactSolver::Rapier => 0.0,
        };
        self.energies.impact_j -= springs_j - self.energies.springs_j;
        self.energies.springs_j = springs_j;
        self.energies.treads_j = self.reactions.treads_j();
        self.energies.impact_j += self.reactions.released_j();
        let wheels = &mut self.assembly.wheels;
        for reaction in self.reactions.all() {
            let taken = match reaction.part {
                Part::Hub(_) | Part::Axle(..) | Part::Rolling(..) | Part::RateLimit(_) => continue,
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
        let is_bearing =
            |r: &&Reaction| matches!(r.part, Part::Hub(_) | Part::Axle(..) | Part::Rolling(..));
        let bearings = self.reactions.all().iter().filter(is_bearing);
        lost_j += bearings.map(|reaction| reaction.taken_j.x).sum::<f64>();
        self.energies.bearing_j += lost_j;
    }
}
