//! One step.
//!
//! A step of length h moves positions by h/2 with the old speeds, evaluates all forces there, solves for the new speeds, and
//! moves positions by h/2 with them (drift, kick, drift). Forces of position are second order in h and symplectic; damping,
//! friction and drives see the old speeds and are first order; gyroscopic forces see speeds carried on by h/2 with the last
//! acceleration and are second order.

use nalgebra::{UnitQuaternion, Vector3};

use crate::play::Stops;
use crate::settings::Contact;
use crate::solution::Solution;
use crate::{Engine, OracleError};

impl Engine {
    /// Makes one step.
    ///
    /// # Errors
    ///
    /// Where the motion is no longer finite.
    pub fn step(&mut self) -> Result<(), OracleError> {
        let h = self.settings.step_s;
        self.drift(0.5 * h);
        self.posture.update(&self.tree, &self.wheel_angles);
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

    /// Moves positions with the present speeds.
    fn drift(&mut self, h: f64) {
        let turned = |by: f64| UnitQuaternion::from_scaled_axis(self.speeds.angular * by);
        let halfway = self.rotation * turned(0.5 * h);
        self.origin += halfway * self.speeds.linear * h;
        self.rotation *= turned(h);
        self.rotation.renormalize_fast();
        for (angle, rate) in self.wheel_angles.iter_mut().zip(&self.speeds.wheels) {
            *angle += rate * h;
        }
    }

    fn add_gravity_and_push(&mut self) {
        let body_from_world = self.rotation.inverse().to_rotation_matrix();
        let gravity = body_from_world * self.settings.gravity_m_s2;
        let forces = &mut self.solution.forces;
        let chassis = &self.tree.chassis;
        forces.act_on_chassis(&chassis.center, &(gravity * chassis.mass));
        if let Some(push) = &self.push {
            let force = body_from_world * push.force_in_world_n;
            forces.act_on_chassis(&push.point_in_body_m, &force);
        }
        for (w, wheel) in self.tree.wheels.iter().enumerate() {
            let (o, e) = (&wheel.origin_in_body, &wheel.axis_in_body);
            let hub_center = o + self.posture.hubs[w].0;
            forces.act_on_wheel(w, o, e, &hub_center, &(gravity * wheel.hub.mass));
            for j in wheel.rollers.clone() {
                // A roller's weight has no moment about its axis.
                let weight = gravity * self.tree.rollers[j].mass;
                forces.act_on_wheel(w, o, e, &self.posture.centers[j], &weight);
            }
        }
    }

    /// Drives and bearings, and the accelerations that stop what is locked within this step.
    fn add_joints(&mut self, h: f64) {
        let solution = &mut self.solution;
        for (w, rate) in self.speeds.wheels.iter().enumerate() {
            let drive = self.drives[w].torque_n_m(*rate);
            solution.prescribed.wheels[w] = drive.is_none().then_some(-rate / h);
            let bearing = self.wheel_bearings[w].torque_n_m(*rate);
            solution.drive_torques[w] = drive.unwrap_or(0.0);
            solution.wheel_bearing_torques[w] = bearing;
            solution.forces.wheels[w] += solution.drive_torques[w] + bearing;
        }
        for (j, rate) in self.speeds.rollers.iter().enumerate() {
            solution.prescribed.rollers[j] = self.seized[j].then_some(-rate / h);
            let bearing = self.roller_bearings[j].torque_n_m(*rate);
            solution.roller_bearing_torques[j] = bearing;
            solution.forces.rollers[j] += bearing;
        }
    }

    fn add_contacts(&mut self, h: f64) {
        let world_from_body = self.rotation.to_rotation_matrix();
        let up = world_from_body.inverse() * Vector3::z();
        let law = self.settings.contact;
        let stops = Stops {
            stiffness_n_m: law.normal_stiffness_n_m,
            relaxes_s: law.normal_damping_n_s_m / law.normal_stiffness_n_m,
        };
        self.contacts.clear();
        for (w, wheel) in self.tree.wheels.iter().enumerate() {
            let (o, e) = (&wheel.origin_in_body, &wheel.axis_in_body);
            for j in wheel.rollers.clone() {
                let (point, depth) = self.lowest_of(&self.posture, j, &up);
                let bristle = &mut self.bristles[j];
                let play = &mut self.plays[j];
                if depth <= 0.0 {
                    if play.half_m > 0.0 {
                        let a = world_from_body * self.posture.axes[j];
                        let gravity = a.dot(&self.settings.gravity_m_s2);
                        self.energy.roller_bearings_j -= play.go(&stops, h, gravity, |_| 0.0);
                    }
                    // A bristle without mass straightens at once; what it held is lost.
                    self.energy.bristles_j +=
                        0.5 * law.bristle_stiffness_n_m * bristle.norm_squared();
                    bristle.fill(0.0);
                    continue;
                }
                let (c, a) = (&self.posture.centers[j], &self.posture.axes[j]);
                let held = world_from_body
                    * (self.speeds.linear
                        + self.speeds.angular.cross(&point)
                        + e.cross(&(point - o)) * self.speeds.wheels[w]
                        + a.cross(&(point - c)) * self.speeds.rollers[j]);
                let velocity = if play.half_m > 0.0 {
                    let axis = world_from_body * a;
                    let gravity = axis.dot(&self.settings.gravity_m_s2);
                    let work_j = play.go(&stops, h, gravity, |rate| {
                        let velocity = held + rate * axis;
                        let normal = law.normal_n(depth, -velocity.z);
                        let friction = law.bend(&mut bristle.clone(), velocity.xy(), normal, h);
                        axis.xy().dot(&friction.force) + axis.z * normal
                    });
                    self.energy.roller_bearings_j -= work_j;
                    held + play.rate_m_s * axis
                } else {
                    held
                };
                let normal = law.normal_n(depth, -velocity.z);
                let friction = law.bend(bristle, velocity.xy(), normal, h);
                let damper = normal - law.normal_stiffness_n_m * depth;
                self.energy.normals_j += damper * -velocity.z * h;
                self.energy.slip_j += friction.slip_j;
                self.energy.bristles_j += friction.damping_j;

                let in_world = Vector3::new(friction.force.x, friction.force.y, normal);
                let force = world_from_body.inverse() * in_world;
                let forces = &mut self.solution.forces;
                forces.act_on_wheel(w, o, e, &point, &force);
                forces.rollers[j] += a.dot(&(point - c).cross(&force));
                self.contacts.push(Contact {
                    wheel: w,
                    roller: j,
                    point_in_body_m: point,
                    normal_n: normal,
                    friction_n: friction.force,
                    velocity_m_s: velocity.xy(),
                    slides: friction.slides,
                });
            }
        }
    }

    /// Counts the work of joints and push: force times the mean of the speeds before and after.
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
        if let Some(push) = &self.push {
            let linear = 0.5 * (before.linear + after.linear);
            let angular = 0.5 * (before.angular + after.angular);
            let velocity = self.rotation * (linear + angular.cross(&push.point_in_body_m));
            energy.push_j += push.force_in_world_n.dot(&velocity) * h;
        }
    }
}
