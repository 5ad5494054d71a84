//! One step.
//!
//! A step of length h moves positions by h/2 with the old speeds, evaluates all forces there,
//! solves for the new speeds, and moves positions by h/2 with them (drift, kick, drift).
//! Position-dependent forces are second order in h and symplectic. Damping, friction and drives use
//! the old speeds, friction on axles the old loads, and are first order. Gyroscopic forces use
//! speeds extrapolated by h/2 with the last acceleration and are second order.

use nalgebra::UnitQuaternion;

use crate::solution::Solution;
use crate::{Engine, OracleError};

impl Engine {
    /// Takes one step.
    ///
    /// # Errors
    ///
    /// If the motion is no longer finite.
    pub fn step(&mut self) -> Result<(), OracleError> {
        let h = self.settings.step_s;
        self.drift(0.5 * h);
        self.posture
            .update(&self.tree, &self.joints, &self.wheel_angles);
        self.posture
            .carry(&self.tree, &self.speeds, &mut self.solution.carried);
        self.solution.forces.clear();
        self.add_gravity_and_push();
        self.add_joints(h);
        self.add_contacts(h);

        let Solution {
            system,
            forces,
            prescribed,
            accelerations,
            reactions,
            predicted,
            before,
            ..
        } = &mut self.solution;
        predicted.set_sum(&self.speeds, 0.5 * h, accelerations);
        system.assemble(&self.tree, &self.posture, predicted, forces);
        if !system.solve(&self.tree, prescribed, accelerations, reactions) {
            let time_s = self.time_s();
            return Err(OracleError::Diverged { time_s });
        }
        std::mem::swap(before, &mut self.speeds);
        self.speeds.set_sum(before, h, accelerations);

        self.count_work(h);
        self.drift(0.5 * h);
        self.steps += 1;
        Ok(())
    }

    /// Moves positions with the current speeds.
    fn drift(&mut self, h: f64) {
        let turned = |by: f64| UnitQuaternion::from_scaled_axis(self.speeds.angular * by);
        let halfway = self.rotation * turned(0.5 * h);
        self.origin += halfway * self.speeds.linear * h;
        self.rotation *= turned(h);
        self.rotation.renormalize_fast();
        for (position, rate) in self.joints.iter_mut().zip(&self.speeds.joints) {
            *position += rate * h;
        }
        for (angle, rate) in self.wheel_angles.iter_mut().zip(&self.speeds.wheels) {
            *angle += rate * h;
        }
    }

    fn add_gravity_and_push(&mut self) {
        let body_from_world = self.rotation.inverse().to_rotation_matrix();
        let gravity = body_from_world * self.settings.gravity_m_s2;
        let forces = &mut self.solution.forces;
        for (c, carrier) in self.posture.carriers.iter().enumerate() {
            let body = &carrier.inertia;
            forces.act_on(c, &body.center, &(gravity * body.mass));
        }
        if let Some(push) = &self.push {
            let force = body_from_world * push.force_in_world_n;
            forces.act_on(0, &push.point_in_body_m, &force);
        }
        for (w, wheel) in self.tree.wheels.iter().enumerate() {
            let hub = &self.posture.hubs[w];
            let mut act = |point, mass| {
                let weight = gravity * mass;
                forces.act_on_wheel(&self.tree, &self.posture, w, point, &weight);
            };
            let hub_center = hub.middle + hub.center;
            act(&hub_center, wheel.hub.mass);
            for j in wheel.rollers.clone() {
                // A roller's weight has no moment about its axis.
                act(&self.posture.centers[j], self.tree.rollers[j].mass);
            }
        }
    }

    /// Adds drives and bearings, and prescribes accelerations that stop locked parts within this
    /// step.
    fn add_joints(&mut self, h: f64) {
        let solution = &mut self.solution;
        for (w, rate) in self.speeds.wheels.iter().enumerate() {
            let drive = self.drives[w].torque_n_m(*rate);
            solution.prescribed.wheels[w] = drive.is_none().then_some(-rate / h);
            let bearing = self.wheel_bearings[w].torque_n_m(*rate, 0.0);
            solution.drive_torques[w] = drive.unwrap_or(0.0);
            solution.wheel_bearing_torques[w] = bearing;
            solution.forces.wheels[w] += solution.drive_torques[w] + bearing;
        }
        solution.roller_loads_n.fill(0.0);
        for contact in &self.contacts {
            solution.roller_loads_n[contact.roller] += contact.normal_n;
        }
        for (j, rate) in self.speeds.rollers.iter().enumerate() {
            solution.prescribed.rollers[j] = self.seized[j].then_some(-rate / h);
            let bearing = self.roller_bearings[j].torque_n_m(*rate, solution.roller_loads_n[j]);
            solution.roller_bearing_torques[j] = bearing;
            solution.forces.rollers[j] += bearing;
        }
        let state = (&self.joints[..], &self.speeds.joints[..]);
        let acts = (
            &mut solution.forces.joints[..],
            &mut solution.joint_losses[..],
        );
        self.energy.joints_j += self.linkage.act(&self.tree, state, h, acts);
    }

    /// Adds up the work of joints and push: force times the mean of the speeds before and after.
    fn count_work(&mut self, h: f64) {
        let solution = &mut self.solution;
        let (before, after, energy) = (&solution.before, &self.speeds, &mut self.energy);
        for w in 0..after.wheels.len() {
            let mean = 0.5 * (before.wheels[w] + after.wheels[w]);
            energy.drives_j += solution.drive_torques[w] * mean * h;
            energy.wheel_bearings_j -= solution.wheel_bearing_torques[w] * mean * h;
            if solution.prescribed.wheels[w].is_some() {
                energy.locking_j -= solution.reactions.wheels[w] * mean * h;
                solution.drive_torques[w] = solution.reactions.wheels[w];
            }
        }
        for j in 0..after.rollers.len() {
            let mean = 0.5 * (before.rollers[j] + after.rollers[j]);
            energy.roller_bearings_j -= solution.roller_bearing_torques[j] * mean * h;
            if solution.prescribed.rollers[j].is_some() {
                energy.locking_j -= solution.reactions.rollers[j] * mean * h;
            }
        }
        for (i, lost) in solution.joint_losses.iter().enumerate() {
            energy.joints_j -= lost * 0.5 * (before.joints[i] + after.joints[i]) * h;
        }
        if let Some(push) = &self.push {
            let linear = 0.5 * (before.linear + after.linear);
            let angular = 0.5 * (before.angular + after.angular);
            let velocity = self.rotation * (linear + angular.cross(&push.point_in_body_m));
            energy.push_j += push.force_in_world_n.dot(&velocity) * h;
        }
    }
}
