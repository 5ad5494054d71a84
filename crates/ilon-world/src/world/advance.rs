//! One step: the robot as rapier has it in the step's middle, the reactions of ground and bearings, and what each took.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use super::{Energies, World};
use crate::ContactSolver;
use crate::contact::reaction::Part;
use crate::contact::reactions::Reactions;
use crate::contact::scene::Scenes;
use crate::contact::wheel_contact::{Taken, WheelContact};
use crate::engine::convert;
use crate::ground::Ground;
use crate::robot::articulated::Articulated;

/// What a contact may be in the ground beyond its start at the end of a step that moves on with the mean of the rates, in
/// metres. Where one would be deeper, it has landed, and the step moves on with the rates after it.
const SINKS_M: f64 = 5e-6;

impl World {
    /// Advances the world by a time.
    ///
    /// The poses move on by half of it with the rates of its beginning; rapier finds contacts and accelerations there,
    /// and the reactions follow; with the mean of the rates before and after the poses move on to its end. That is of
    /// second order in the time where nothing lands and nothing tumbles: of a robot that turns about a level axis rapier takes the
    /// gyroscopic torque with the rates of the step's beginning, which is of first order.
    pub(super) fn advance(&mut self, dt_s: f64) {
        for body in &mut self.bodies {
            body.ask_motors(dt_s);
        }
        if self.settings.contacts == ContactSolver::Rapier {
            return self.advance_in_rapier(dt_s);
        }
        for body in &mut self.bodies {
            body.step_in_rapier(&self.ground, dt_s);
        }
        self.reactions.react(Scenes {
            ground: &self.ground,
            settings: &self.settings,
            dt_s,
            bodies: &self.bodies,
        });
        let gravity = self.ground.gravity_in_floor(self.settings.gravity_m_s2);
        for (index, body) in self.bodies.iter_mut().enumerate() {
            body.take_reactions(index, &self.reactions);
            let sinks = self.reactions.sinks_m(index, dt_s) > SINKS_M;
            body.move_on(sinks, &gravity, dt_s, &mut self.energies);
        }
        self.count_motors(dt_s);
        self.read_contacts(dt_s);
        for (index, body) in self.bodies.iter_mut().enumerate() {
            let lost_j = body.run_bearings(&gravity, dt_s) + self.reactions.bearings_took_j(index);
            self.energies.bearing_j += lost_j;
            body.end_pushes(dt_s, &mut self.energies);
        }
    }

    /// Counts what the motors did.
    pub(super) fn count_motors(&mut self, dt_s: f64) {
        for body in &mut self.bodies {
            for (index, motor) in body.motors.iter().enumerate() {
                let after_rad_s = body.state.wheel_rates_rad_s[index];
                let gained_rad_s = after_rad_s - body.before.wheel_rates_rad_s[index];
                body.acted_n_m[index] = motor.torque_n_m - motor.droop_n_m_s * gained_rad_s;
            }
        }
        for reaction in self.reactions.all() {
            if let Part::RateLimit(wheel) = reaction.a.part {
                self.bodies[reaction.a.body].acted_n_m[wheel] += reaction.impulse.x / dt_s;
            }
        }
        for body in &mut self.bodies {
            for (index, acted_n_m) in body.acted_n_m.iter().enumerate() {
                let impulse_n_m_s = acted_n_m * dt_s;
                self.energies.motor_j += impulse_n_m_s * body.middle.wheel_rates_rad_s[index];
                body.counts[index].torque_n_m_s += impulse_n_m_s;
            }
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
        for reaction in self.reactions.all() {
            let taken = match reaction.a.part {
                Part::Hub(_)
                | Part::Axle(..)
                | Part::Slide(..)
                | Part::Rolling(..)
                | Part::RateLimit(_) => continue,
                Part::Chassis => Taken::of(reaction, &mut 0.0),
                Part::Roller(wheel, roller) => {
                    let body = &mut self.bodies[reaction.a.body];
                    let roller = &mut body.assembly.wheels[wheel].rollers[roller];
                    if !roller.pressed && reaction.impulse.x > 0.0 && !roller.seized {
                        let missing_rad_s = reaction.velocity_before.z / reaction.rolling_radius_m;
                        roller.spin_up_left_j = roller.spin_up_j(missing_rad_s);
                    }
                    let taken = Taken::of(reaction, &mut roller.spin_up_left_j);
                    body.counts[wheel].taken.add(&taken);
                    taken
                }
            };
            self.energies.slip_j += taken.slip_j;
            self.energies.spin_up_j += taken.spin_up_j;
            self.energies.impact_j += taken.impact_j;
        }
        for body in &mut self.bodies {
            let wheels = &mut body.assembly.wheels;
            for roller in wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers) {
                roller.pressed = false;
            }
        }
        for reaction in self.reactions.all() {
            if let (Part::Roller(wheel, roller), true) = (reaction.a.part, reaction.impulse.x > 0.0)
            {
                let wheel = &mut self.bodies[reaction.a.body].assembly.wheels[wheel];
                wheel.rollers[roller].pressed = true;
            }
        }
        for (index, body) in self.bodies.iter_mut().enumerate() {
            for (wheel, contact) in body.contacts.iter_mut().enumerate() {
                let states = (&body.middle, &body.state);
                let wheel = (wheel, &body.assembly.wheels[wheel]);
                *contact = WheelContact::read(self.reactions.of_body(index), wheel, states, dt_s);
            }
        }
    }
}

impl Articulated {
    /// Sets what the motors do in a part of the step, from what they were asked for when it began.
    fn ask_motors(&mut self, dt_s: f64) {
        for (index, motor) in self.motors.iter_mut().enumerate() {
            let gained_rad_s = self.state.wheel_rates_rad_s[index] - self.rates_asked_rad_s[index];
            *motor = self.asked[index]
                .after_gaining(gained_rad_s)
                .over(dt_s, self.wheel_inertia_kg_m2);
        }
    }

    /// Takes the step in rapier, as if nothing touched the body: its contacts and accelerations in the middle of the step.
    fn step_in_rapier(&mut self, ground: &Ground, dt_s: f64) {
        let half_s = 0.5 * dt_s;
        self.before.copy_from(&self.state);
        self.middle.copy_from(&self.state);
        self.middle.advance(half_s);
        self.sees_rollers_pass = self.rollers_pass_in_steps(dt_s);
        self.ahead.copy_from(&self.middle);
        self.ahead.advance(half_s);
        self.rapier.integration_parameters.dt = dt_s as Real;
        self.set_poses_in_rapier(ground);
        self.set_torques_in_rapier(dt_s);
        self.begin_pushes();
        self.rapier.step(&());
        self.read_free_rates(dt_s);
    }

    /// Puts the robot into rapier as it is in the middle of the step, with the rates of its beginning: the f64 sums, counted
    /// from rapier's own origin and rounded.
    pub(super) fn set_poses_in_rapier(&mut self, ground: &Ground) {
        let place_m = self.middle.center_m();
        self.anchor
            .follow(&place_m, ground, &mut self.rapier.colliders);
        let rapier_from_floor = self.anchor.rapier_from_floor();
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

    /// Reads the rates that rapier came to without reactions, and what the motors lose as the wheels gain rate.
    ///
    /// rapier's rates are rounded; what they gained in the step is added to the f64 ones.
    fn read_free_rates(&mut self, dt_s: f64) {
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
    }

    /// Corrects the rates by the reactions of the step.
    fn take_reactions(&mut self, index: usize, reactions: &Reactions) {
        for (rate, change) in self.rates_free.iter_mut().zip(reactions.change(index)) {
            *rate += change;
        }
        self.assembly.set_rates(&self.rates_free, &mut self.state);
        // From here on the rates before are those that the mean over the step starts from.
        let starts = self
            .rates_before
            .iter_mut()
            .zip(reactions.start_change(index));
        for ((start, change), after) in starts.zip(&self.rates_free) {
            *start = 0.5 * (*start + change + after);
        }
        self.assembly
            .set_rates(&self.rates_before, &mut self.middle);
        let wheels = &mut self.assembly.wheels;
        for roller in wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers) {
            roller.touched = false;
        }
        for touched in reactions.touched(index) {
            let roller = &mut wheels[touched.wheel].rollers[touched.roller];
            roller.axial_rate_rad_s = touched.rate_rad_s;
            roller.mean_rate_rad_s = touched.mean_rad_s;
            roller.touched = true;
            if let Some(slide) = &mut roller.slide {
                slide.solved(touched.slide_m_s);
            }
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
    fn move_on(&mut self, sinks: bool, gravity: &Vector3<f64>, dt_s: f64, energies: &mut Energies) {
        self.state.advance_with(&self.middle, dt_s);
        if !self.sees_rollers_pass || sinks {
            let with_mean_j = self.potential_j(gravity);
            self.state.take_poses(&self.before);
            self.state.advance(dt_s);
            // The height that the mean would have lost is no energy that anything has got.
            energies.impact_j += with_mean_j - self.potential_j(gravity);
        }
    }

    /// Lets the bearings act on rollers that nothing touched, and gives what damping and dry friction took out of all of
    /// them, in J, but for what is among the reactions. All work goes with the mean rates.
    ///
    /// Rollers with play move along their axles, under gravity in the floor's frame where they are in the air.
    fn run_bearings(&mut self, gravity: &Vector3<f64>, dt_s: f64) -> f64 {
        let mut lost_j = 0.0;
        let wheels = self.assembly.wheels.iter_mut().zip(&self.robot.wheels);
        for (index, (body, wheel)) in wheels.enumerate() {
            lost_j += body.end_step(&self.middle.hub_rate_in_hub(index), dt_s);
            if body.has_play {
                let in_hub = self.state.hubs()[index].rotation.tr_mul(gravity);
                lost_j += body.slide_rollers(&in_hub, dt_s);
            }
            let damping_n_m = wheel.joint.damping_n_m_s * self.state.wheel_rates_rad_s[index];
            lost_j += damping_n_m * self.middle.wheel_rates_rad_s[index] * dt_s;
        }
        lost_j
    }
}
