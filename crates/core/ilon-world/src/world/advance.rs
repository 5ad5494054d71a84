//! One step: the robot in the step's middle, the reactions of ground and bearings, and the energy
//! that each took.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::{Energies, World};
use crate::ContactSolver;
use crate::contact::reactions::ReactionSolver;
use crate::contact::reactions::reaction::Part;
use crate::contact::reactions::wheel_contact::{Taken, WheelContact};
use crate::contact::scene::Scenes;
use crate::dynamics::ROOT_DOFS;
use crate::robot::articulated::Articulated;
use crate::robot::drive::WheelDrive;
use crate::robot::servo::Servo;

/// The largest increase of a contact's penetration over a step that advances with the mean rates,
/// in wheel radii. A deeper contact has landed, and the step advances with the rates after it. 5 um
/// for wheels of 50 mm. Chosen.
const SINKS: f64 = 1e-4;

/// A part of a step whose contacts violate their laws by more than this, in m/s or rad/s, is
/// discarded and halved: contacts that jam in a long step can mostly be solved in a shorter one.
/// Chosen.
const UNSOLVED_M_S: f64 = 1e-6;

/// The shortest part that is halved, as a share of the step. Chosen.
const SHORTEST_PART: f64 = 1.0 / 16.0;

impl World {
    /// Advances the world by a time: in one part, or in two if something lands in it or its
    /// contacts cannot be solved.
    ///
    /// The reactions of a part are found before anything has moved, so that discarding a part has
    /// no effect.
    pub(super) fn advance(&mut self, solver: &mut ReactionSolver, dt_s: f64) {
        if self.settings.contacts == ContactSolver::Rapier {
            self.advance_in_rapier(dt_s);
            return self.tally(dt_s);
        }
        self.find_reactions(solver, dt_s);
        let Some(first_s) = self.first_part_s(solver, dt_s) else {
            self.move_on(solver, dt_s);
            return self.tally(dt_s);
        };
        self.give_up();
        self.advance(solver, first_s);
        self.advance(solver, dt_s - first_s);
    }

    /// Advances the world by a time in the reference mode, in which rapier moves everything.
    fn advance_in_rapier(&mut self, dt_s: f64) {
        // Such a world has one robot and no other moving bodies.
        let (Some(reference), [robot]) = (&mut self.reference, &mut self.bodies[..]) else {
            return;
        };
        robot.ask_motors(dt_s);
        reference.step(robot, &self.ground, dt_s);
        let took_j = reference.joints_lost_j(robot, dt_s);
        self.reactions.take(reference.reactions(robot));
        self.count_motors(dt_s);
        self.read_contacts(dt_s);
        self.energies.bearing_j += self.bodies[0].memory.bearings_owe.lost_j(took_j);
        self.energies.outside_j += self.bodies[0].pushes_did_j(dt_s);
    }

    /// The first of the two parts into which a part of a step with known reactions is to be split,
    /// in seconds; `None` if it is well solved as a whole.
    fn first_part_s(&self, solver: &ReactionSolver, dt_s: f64) -> Option<f64> {
        let shortest_s = self.shortest_part_s();
        // Slightly before the landing, so that the load's support until then acts to the end.
        let lands_s = (1.0 - SHORTEST_PART) * solver.lands_after_s(&self.bodies, dt_s);
        if (shortest_s..dt_s).contains(&lands_s) {
            return Some(lands_s);
        }
        let half_s = 0.5 * dt_s;
        let is_solved = solver.error() <= UNSOLVED_M_S || half_s < shortest_s;
        (!is_solved).then_some(half_s)
    }

    /// Discards a part of a step with known reactions, and returns to its beginning.
    pub(super) fn give_up(&mut self) {
        self.solution.halvings += 1;
        self.bodies.iter_mut().for_each(Articulated::begin_again);
    }

    /// No part of a step that is halved is shorter than this, in seconds.
    fn shortest_part_s(&self) -> f64 {
        let shortest_s = SHORTEST_PART * self.settings.dt_s;
        self.settings
            .split_dt_s
            .map_or(shortest_s, |split_s| split_s.min(shortest_s))
    }

    /// Finds the reactions of a part of a step, without moving anything.
    ///
    /// The poses are advanced by half of it with the rates of its beginning; contacts and
    /// accelerations are found there, and the reactions follow.
    pub(super) fn find_reactions(&mut self, solver: &mut ReactionSolver, dt_s: f64) {
        let gravity = self.ground.gravity_in_floor(self.settings.gravity_m_s2);
        for body in &mut self.bodies {
            body.ask_motors(dt_s);
            let gravity = body.pulled_by(&gravity);
            body.move_freely(&gravity, dt_s);
        }
        solver.react(self.scenes(dt_s));
        if self.turn_with_jumps(solver, &gravity, dt_s) {
            solver.react_again(self.scenes(dt_s));
        }
        self.solution.searches += 1;
        self.solution.add(solver.take_effort());
    }

    /// The inputs of the reactions of a part of a step.
    fn scenes(&self, dt_s: f64) -> Scenes<'_> {
        Scenes {
            ground: &self.ground,
            settings: &self.settings,
            dt_s,
            bodies: &self.bodies,
            reactions: &self.reactions,
        }
    }

    /// Advances everything to the end of a part of a step with known reactions, and counts their
    /// effects.
    ///
    /// The poses advance with the mean of the rates before and after. That is of second order in
    /// the time if nothing lands.
    pub(super) fn move_on(&mut self, solver: &mut ReactionSolver, dt_s: f64) {
        let gravity = self.ground.gravity_in_floor(self.settings.gravity_m_s2);
        for (index, body) in self.bodies.iter_mut().enumerate() {
            let lands = body.is_settling || body.lands(index, solver, dt_s);
            body.take_reactions(index, solver, lands, dt_s);
            let gravity = body.pulled_by(&gravity);
            body.move_on(lands, &gravity, dt_s, &mut self.energies);
            body.count_debts(dt_s);
            body.command.from_middle_s += dt_s;
            if let Some(free) = body.free_mut() {
                free.pressed_m = free.pressed_m.max(solver.pressed_m(index));
            }
        }
        solver.keep_in(&mut self.reactions, dt_s);
        self.count_motors(dt_s);
        self.count_joints(dt_s);
        self.count_pushing();
        self.read_contacts(dt_s);
        for (index, body) in self.bodies.iter_mut().enumerate() {
            let took_j = body.run_bearings(&gravity, dt_s) + self.reactions.bearings_took_j(index);
            self.energies.bearing_j += body.memory.bearings_owe.lost_j(took_j);
            // The energy of coupled bodies is not this world's.
            if body.coupled().is_none() {
                self.energies.outside_j += body.pushes_did_j(dt_s) - body.attached_took_j(dt_s);
            }
        }
    }

    /// Updates the forces of rotating frames for bodies with joints that are stopped within the
    /// step, because their rates jump; returns whether there are any.
    fn turn_with_jumps(
        &mut self,
        solver: &ReactionSolver,
        gravity: &Vector3<f64>,
        dt_s: f64,
    ) -> bool {
        let mut any = false;
        for (index, body) in self.bodies.iter_mut().enumerate() {
            let jumps = !body.robot.joints.is_empty() && !body.is_settling;
            if jumps && body.lands(index, solver, dt_s) {
                let gravity = body.pulled_by(gravity);
                body.accelerate_in_jump(solver.change(index), &gravity, dt_s);
                any = true;
            }
        }
        any
    }

    /// Counts the work and torque of the motors.
    fn count_motors(&mut self, dt_s: f64) {
        for body in &mut self.bodies {
            for (index, motor) in body.step.motors.iter().enumerate() {
                let after_rad_s = body.state.wheel_rates_rad_s()[index];
                let gained_rad_s = after_rad_s - body.step.before.wheel_rates_rad_s()[index];
                body.done.acted_n_m[index] = motor.torque_n_m - motor.droop_n_m_s * gained_rad_s;
            }
        }
        for reaction in self.reactions.all() {
            let body = &mut self.bodies[reaction.a.body];
            match reaction.a.part {
                Part::RateLimit(wheel) => body.done.acted_n_m[wheel] += reaction.impulse.x / dt_s,
                Part::Drive(wheel) => {
                    let took_j = body.count_drive(wheel, reaction.impulse.x, dt_s);
                    self.energies.bearing_j += body.memory.bearings_owe.lost_j(took_j);
                }
                _ => {}
            }
        }
        for body in &mut self.bodies {
            for (index, acted_n_m) in body.done.acted_n_m.iter().enumerate() {
                let impulse_n_m_s = acted_n_m * dt_s;
                let turned_rad_s = body.step.middle.wheel_rates_rad_s()[index];
                self.energies.count_motor(impulse_n_m_s * turned_rad_s);
                body.done.counts[index].torque_n_m_s += impulse_n_m_s;
            }
        }
    }

    /// Counts the forces in the joints between bodies.
    fn count_joints(&mut self, dt_s: f64) {
        for body in &mut self.bodies {
            body.count_springs(dt_s);
        }
        for reaction in self.reactions.all() {
            let body = &mut self.bodies[reaction.a.body];
            match reaction.a.part {
                Part::Servo(joint) => {
                    body.servos[joint].impulse += reaction.impulse.x;
                    body.done.joint_forces[joint] += reaction.impulse.x;
                }
                Part::Friction(joint) | Part::Stop(joint, _) => {
                    body.done.joint_forces[joint] += reaction.impulse.x;
                }
                _ => {}
            }
        }
        for body in &self.bodies {
            for (servo, mean) in body.servos.iter().zip(body.step.middle.joint_rates()) {
                self.energies.count_motor(servo.impulse * mean);
            }
        }
    }

    /// Reads the contacts and counts the energy that they took, including that of a scraping
    /// chassis.
    fn read_contacts(&mut self, dt_s: f64) {
        let residual_m_s = &mut self.solution.residual_m_s;
        *residual_m_s = residual_m_s.max(self.reactions.error());
        let springs_j = match self.settings.contacts {
            ContactSolver::Ilon => self.reactions.spring_energy_j(&self.bodies, dt_s),
            // The energy stored in rapier's soft contacts counts as impact loss.
            ContactSolver::Rapier => 0.0,
        };
        self.energies.impact_j -= springs_j - self.energies.springs_j;
        self.energies.springs_j = springs_j;
        self.energies.treads_j = self.reactions.treads_j();
        self.energies.impact_j += self.reactions.released_j();
        for reaction in self.reactions.all() {
            if self.bodies[reaction.a.body].coupled().is_some() {
                continue;
            }
            self.bodies[reaction.a.body].done.support.add(reaction);
            let taken = match reaction.a.part {
                Part::Hub(_)
                | Part::Axle(..)
                | Part::Slide(..)
                | Part::Rolling(..)
                | Part::RateLimit(_)
                | Part::Drive(_)
                | Part::Servo(_)
                | Part::Friction(_)
                | Part::Coupling(_) => continue,
                Part::Stop(joint, _) => {
                    let mean = self.bodies[reaction.a.body].step.middle.joint_rates()[joint];
                    self.energies.impact_j -= reaction.impulse.x * mean;
                    continue;
                }
                Part::Chassis | Part::Link(_) => {
                    let body = &mut self.bodies[reaction.a.body];
                    Taken::of(reaction, &mut 0.0, &mut body.memory.friction_owes)
                }
                Part::Roller(wheel, roller) => {
                    let body = &mut self.bodies[reaction.a.body];
                    let roller = &mut body.wheels[wheel].rollers[roller];
                    if !roller.pressed && reaction.impulse.x > 0.0 && !roller.seized {
                        let missing_rad_s = reaction.velocity_before.z / reaction.rolling_radius_m;
                        roller.spin_up_left_j = roller.spin_up_j(missing_rad_s);
                    }
                    let taken = Taken::of(
                        reaction,
                        &mut roller.spin_up_left_j,
                        &mut body.memory.friction_owes,
                    );
                    body.done.counts[wheel].taken.add(&taken);
                    taken
                }
            };
            self.energies.slip_j += taken.slip_j;
            self.energies.spin_up_j += taken.spin_up_j;
            self.energies.impact_j += taken.impact_j;
        }
        for body in &mut self.bodies {
            let wheels = &mut body.wheels;
            for roller in wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers) {
                roller.pressed = false;
            }
        }
        for reaction in self.reactions.all() {
            if let (Part::Roller(wheel, roller), true) = (reaction.a.part, reaction.impulse.x > 0.0)
            {
                let wheel = &mut self.bodies[reaction.a.body].wheels[wheel];
                wheel.rollers[roller].pressed = true;
            }
        }
        for (index, body) in self.bodies.iter_mut().enumerate() {
            for (wheel, contact) in body.done.contacts.iter_mut().enumerate() {
                let center_m = body.chassis_mass.center_of_mass_m;
                let states = (center_m, &body.step.middle, &body.state);
                let wheel = (wheel, &body.wheels[wheel]);
                *contact = WheelContact::read(self.reactions.of_body(index), wheel, states, dt_s);
            }
        }
    }
}

impl Articulated {
    /// Sets the motors' torques in a part of the step, from the commands at its beginning.
    fn ask_motors(&mut self, dt_s: f64) {
        for (index, law) in self.step.motor_laws.iter_mut().enumerate() {
            let gained_rad_s =
                self.state.wheel_rates_rad_s()[index] - self.command.rates_asked_rad_s[index];
            *law = self.command.motors[index]
                .after_gaining(gained_rad_s)
                .over(dt_s, self.wheel_inertia);
            if law.droop_n_m_s > 0.0 {
                law.torque_n_m += self.memory.motors_owe_n_m_s[index] / self.command.step_s;
            }
            self.step.motors[index] = law.straight();
        }
    }

    /// Counts what the motors paid and owe after a part of the step.
    fn count_debts(&mut self, dt_s: f64) {
        let paid = dt_s / self.command.step_s;
        for (index, owed_n_m_s) in self.memory.motors_owe_n_m_s.iter_mut().enumerate() {
            *owed_n_m_s *= 1.0 - paid;
            let law = &self.step.motor_laws[index];
            if self.step.motors[index] != *law {
                // It acted along a limit.
                continue;
            }
            let [before, mean, after] = [&self.step.before, &self.step.middle, &self.state]
                .map(|state| state.wheel_rates_rad_s()[index]);
            // The law's droop is that for a steady gain, which is lower than that for a jump.
            let steady_n_m_s = law.droop_n_m_s - law.per_acceleration_n_m_s2 / dt_s;
            let lower_n_m_s = self.command.motors[index].droop_n_m_s - steady_n_m_s;
            *owed_n_m_s -= lower_n_m_s * (2.0 * mean - before - after) * dt_s;
        }
    }

    /// Counts the work of the motor of a wheel with a nonlinear drive, given the drive's impulse
    /// besides the motor's straight line, in N m s, and returns the energy taken by gear and
    /// bearing, in J.
    fn count_drive(&mut self, wheel: usize, impulse_n_m_s: f64, dt_s: f64) -> f64 {
        let before_rad_s = self.step.before.wheel_rates_rad_s()[wheel];
        let after_rad_s = self.state.wheel_rates_rad_s()[wheel];
        let law = &self.step.motor_laws[wheel];
        let drive = WheelDrive::new(law, &self.robot.wheels[wheel], before_rad_s, dt_s);
        let on_wheel_n_m = self.done.acted_n_m[wheel] + impulse_n_m_s / dt_s;
        let motor_n_m = drive.motor_n_m(after_rad_s, on_wheel_n_m);
        self.done.acted_n_m[wheel] = motor_n_m;
        (motor_n_m - on_wheel_n_m) * self.step.middle.wheel_rates_rad_s()[wheel] * dt_s
    }

    /// Takes the step as if nothing touched the body, with its accelerations in the middle of the
    /// step.
    fn move_freely(&mut self, gravity: &Vector3<f64>, dt_s: f64) {
        let half_s = 0.5 * dt_s;
        self.step.before.copy_from(&self.state);
        self.step.middle.copy_from(&self.state);
        self.step.middle.advance(half_s);
        self.step.resolves_rollers = self.resolves_rollers(dt_s);
        self.step.ahead.copy_from(&self.step.middle);
        self.step.ahead.advance(half_s);
        self.step.before.write_rates(&mut self.step.rates_before);
        self.hold_joints(dt_s);
        let (root, links) = (self.step.middle.chassis(), self.step.middle.links());
        self.mechanics
            .stand(&self.tree, root, links, &self.step.held_n_m_s2);
        self.load(dt_s);
        self.step
            .rates_free
            .copy_from_slice(&self.step.rates_before);
        if self.memory.is_pressed && !self.robot.joints.is_empty() {
            // The forces of rotating frames on a swing arm are as large as its load: they use the
            // rates of the step's middle, extrapolated from the last step.
            for (rate, gained) in self.step.rates_free.iter_mut().zip(&self.memory.gained) {
                *rate += 0.5 * dt_s * gained;
            }
        }
        self.accelerate(gravity, dt_s);
        if !self.memory.is_pressed {
            // The forces of rotating frames once more with the rates of the middle, so that
            // tumbling is of second order. On the ground most of a body's free gain of rate does
            // not happen, and the rates of the beginning are nearer.
            for (free, before) in self.step.rates_free.iter_mut().zip(&self.step.rates_before) {
                *free = 0.5 * (*free + before);
            }
            self.accelerate(gravity, dt_s);
        }
    }

    /// Returns to the beginning of [`Self::move_freely`], to repeat a part of a step: everything
    /// else that it changed is recomputed.
    fn begin_again(&mut self) {
        self.servos.iter_mut().for_each(Servo::begin_again);
        let rollers = self.wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers);
        rollers
            .filter_map(|roller| roller.slide.as_mut())
            .for_each(|slide| slide.begin_again());
    }

    /// Sets the implicit damping of motors, bearings and springs.
    fn hold_joints(&mut self, dt_s: f64) {
        let lost = self.step.motors.iter().zip(&self.robot.wheels);
        for (body, (motor, wheel)) in self.wheels.iter().zip(lost) {
            let lost_n_m_s = motor.droop_n_m_s + wheel.joint.damping_n_m_s;
            self.step.held_n_m_s2[body.joint] = lost_n_m_s * dt_s;
        }
        self.load_joints(dt_s);
    }

    /// Sets the loads on the body in the step, except those that depend on its hubs' rotation.
    fn load(&mut self, dt_s: f64) {
        let (force_n, torque_n_m) = self.pushed();
        self.step.loads.force_on_root_n = force_n;
        self.step.loads.torque_on_root_n_m = torque_n_m;
        for (index, wheel) in self.wheels.iter_mut().enumerate() {
            wheel.begin_step(&self.step.middle.hub_rate_in_hub(index), dt_s);
            let damping_n_m_s = self.robot.wheels[index].joint.damping_n_m_s;
            let rate_rad_s = self.step.before.wheel_rates_rad_s()[index];
            self.step.loads.in_joints[wheel.joint] =
                self.step.motors[index].torque_n_m - damping_n_m_s * rate_rad_s;
        }
    }

    /// Computes the rates at the end of the step without reactions, given the rates for rotating
    /// frames, which they replace.
    fn accelerate(&mut self, gravity: &Vector3<f64>, dt_s: f64) {
        let rates = std::mem::take(&mut self.step.rates_free);
        self.find_forces(&rates, gravity);
        self.step.rates_free = rates;
        self.mechanics
            .factors()
            .solve(&self.tree, &mut self.step.forces);
        let rates = self.step.rates_free.iter_mut().zip(&self.step.rates_before);
        for ((free, before), gains) in rates.zip(&self.step.forces) {
            *free = before + dt_s * gains;
        }
    }

    /// Repeats this for a body whose rates jump within the step by reactions with the given change,
    /// and which advances with the rates after them.
    ///
    /// With A the rows of its momentum, u_0 and u_1 its rates and q_m = q_0 + dt u_0 / 2 and
    /// q_1 = q_0 + dt u_1 its poses in the middle and at the end, A(q_1) u_1 - A(q_0) u_0 is A(q_m)
    /// (u_1 - u_0) plus, to first order, the forces of rotating frames: dt c, where, because it is
    /// quadratic in the rates, c = 5/4 c(u_1) + 3/4 c(u_0) - c((u_0 + u_1) / 2).
    fn accelerate_in_jump(&mut self, change: &[f64], gravity: &Vector3<f64>, dt_s: f64) {
        let after = self.step.rates_free.iter().zip(change);
        let after: Vec<f64> = after.map(|(free, change)| free + change).collect();
        let mean = self.step.rates_before.iter().zip(&after);
        let mean: Vec<f64> = mean.map(|(before, after)| 0.5 * (before + after)).collect();
        let before = self.step.rates_before.clone();
        self.step.rates_free.copy_from_slice(&before);
        for (share, rates) in [(1.25, &after), (0.75, &before), (-1.0, &mean)] {
            self.find_forces(rates, gravity);
            self.mechanics
                .factors()
                .solve(&self.tree, &mut self.step.forces);
            for (free, gains) in self.step.rates_free.iter_mut().zip(&self.step.forces) {
                *free += share * dt_s * gains;
            }
        }
    }

    /// Computes the generalised forces that remain for accelerations of a body that rotates with
    /// these rates.
    fn find_forces(&mut self, rates: &[f64], gravity: &Vector3<f64>) {
        let angular_rad_s = Vector3::new(rates[3], rates[4], rates[5]);
        for (index, (wheel, hub)) in self.wheels.iter().zip(self.step.middle.hubs()).enumerate() {
            let spins_rad_s = rates[ROOT_DOFS + wheel.joint];
            let of_joints = &rates[ROOT_DOFS..];
            let carrier_rad_s =
                (self.step.middle).carrier_rate_with(index, angular_rad_s, of_joints);
            let in_hub = hub.rotation.tr_mul(&carrier_rad_s) + Vector3::z() * spins_rad_s;
            self.step.loads.torques_on_links_n_m[wheel.joint] =
                hub.rotation * wheel.torque_on_hub_n_m(&in_hub);
        }
        let acting = (&self.step.loads, gravity);
        self.mechanics
            .forces(&self.tree, rates, acting, &mut self.step.forces);
    }

    /// Whether something of the body was stopped within the step, so that it cannot advance with
    /// the mean of the rates before and after: a contact would end deep in the ground, or a joint
    /// beyond its stop.
    fn lands(&self, index: usize, reactions: &ReactionSolver, dt_s: f64) -> bool {
        let change = reactions.change(index);
        let mean = |dof: usize| {
            let start_change = reactions.start_change(index).nth(dof).unwrap_or(0.0);
            let start = self.step.rates_before[dof] + start_change;
            0.5 * (start + (self.step.rates_free[dof] + change[dof]))
        };
        reactions.sinks_m(index, dt_s) > SINKS * self.scale.length_m
            || self.passes_stops(mean, dt_s)
    }

    /// Corrects the rates by the reactions of the step.
    fn take_reactions(&mut self, index: usize, reactions: &ReactionSolver, lands: bool, dt_s: f64) {
        for (rate, change) in self.step.rates_free.iter_mut().zip(reactions.change(index)) {
            *rate += change;
        }
        self.memory.is_pressed = reactions.press_on(index);
        self.state.take_rates(&self.step.rates_free);
        if !self.robot.joints.is_empty() {
            let rates = self.step.rates_free.iter().zip(&self.step.rates_before);
            for (gained, (after, before)) in self.memory.gained.iter_mut().zip(rates) {
                // A jump does not continue.
                *gained = if lands { 0.0 } else { (after - before) / dt_s };
            }
        }
        // From here on the rates before are those at the start of the mean over the step.
        let starts = self
            .step
            .rates_before
            .iter_mut()
            .zip(reactions.start_change(index));
        for ((start, change), after) in starts.zip(&self.step.rates_free) {
            *start = 0.5 * (*start + change + after);
        }
        self.step.middle.take_rates(&self.step.rates_before);
        let wheels = &mut self.wheels;
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

    /// Whether steps of `dt_s` resolve the passage of rollers over the ground at the wheels'
    /// current rates.
    ///
    /// In longer steps a roller would be rotated far beyond its hand-over. The mean motion is then
    /// more accurate if each contact keeps its state of the step's middle, and the robot advances
    /// accordingly: over many steps the middles fall evenly on the rollers.
    fn resolves_rollers(&self, dt_s: f64) -> bool {
        /// The smallest number of steps per passage of a roller. Chosen.
        const STEPS: f64 = 6.0;
        let rates = self.state.wheel_rates_rad_s().iter();
        rates.zip(&self.robot.wheels).all(|(rate_rad_s, wheel)| {
            wheel.has_tyre() || STEPS * dt_s * rate_rad_s.abs() * wheel.rollers.len() as f64 <= TAU
        })
    }

    /// Advances the poses to the end of the step.
    ///
    /// With the mean of the rates before and after, unless a contact would then end deep in the
    /// ground: it was stopped at the ground within the step, and the mean would carry it on. Then
    /// with the rates after it.
    fn move_on(&mut self, lands: bool, gravity: &Vector3<f64>, dt_s: f64, energies: &mut Energies) {
        self.state.advance_with(&self.step.middle, dt_s);
        if !self.step.resolves_rollers || lands {
            let with_mean_j = self.potential_j(gravity);
            self.state.take_poses(&self.step.before);
            self.state.advance(dt_s);
            // The energy of the height that the mean would have lost has gone nowhere.
            energies.impact_j += with_mean_j - self.potential_j(gravity);
        }
    }

    /// Applies the bearings to rollers without contact, and returns the energy taken by damping and
    /// dry friction of all of them, in J, except for what is among the reactions. All work uses the
    /// mean rates.
    ///
    /// Rollers with play move along their axles, in the air under gravity in the floor's frame.
    fn run_bearings(&mut self, gravity: &Vector3<f64>, dt_s: f64) -> f64 {
        let mut lost_j = 0.0;
        let wheels = self.wheels.iter_mut().zip(&self.robot.wheels);
        for (index, (body, wheel)) in wheels.enumerate() {
            lost_j += body.end_step(&self.step.middle.hub_rate_in_hub(index), dt_s);
            if body.has_play {
                let in_hub = self.state.hubs()[index].rotation.tr_mul(gravity);
                lost_j += body.slide_rollers(&in_hub, dt_s);
            }
            let damping_n_m = wheel.joint.damping_n_m_s * self.state.wheel_rates_rad_s()[index];
            lost_j += damping_n_m * self.step.middle.wheel_rates_rad_s()[index] * dt_s;
        }
        lost_j + self.dampers_took_j(dt_s)
    }
}
