//! One step of rapier: its inputs, and the conversion of its results to the quantities of ilon's
//! own mode.
//!
//! rapier solves contacts in the poses at the beginning of a step, and advances with the rates
//! after it.

use nalgebra::Vector3;
use rapier3d::prelude::*;

use super::engine::Engine;
use super::multibody::Reference;
use crate::MotorTorque;
use crate::contact::frame::{along_frame, frame};
use crate::contact::reactions::reaction::{Member, Part, Partner, Reaction};
use crate::engine::convert;
use crate::ground::{Grip, Ground};
use crate::robot::articulated::{Articulated, BodyStep};
use crate::robot::state::State;

impl Reference {
    /// Takes a step of a robot in rapier, and takes over the results.
    pub fn step(&mut self, robot: &mut Articulated, ground: &Ground, dt_s: f64) {
        robot.step.before.copy_from(&robot.state);
        robot.step.middle.copy_from(&robot.state);
        self.rapier.integration_parameters.dt = dt_s;
        self.place(robot);
        for (index, motor) in robot.step.motors.iter_mut().enumerate() {
            hold_below_limit(motor, robot.step.middle.wheel_rates_rad_s()[index]);
        }
        self.load(robot);
        self.rapier.step(&Grip { ground });
        self.read_rates();
        self.move_on(robot, dt_s);
    }

    /// Gives rapier the motors' torques and the pushes of the step.
    fn load(&mut self, robot: &Articulated) {
        let (force_n, mut on_chassis_n_m) = robot.pushed();
        for (index, motor) in robot.step.motors.iter().enumerate() {
            // rapier's damping subtracts droop x rate, but only droop x (rate - current rate) must
            // be subtracted.
            let undamped_n_m = motor.droop_n_m_s * robot.step.middle.wheel_rates_rad_s()[index];
            let axis = robot.step.middle.hubs()[index].axis();
            let torque = axis * (motor.torque_n_m + undamped_n_m);
            let hub = &mut self.rapier.bodies[self.hubs[index].body];
            hub.reset_torques(false);
            hub.add_torque(convert::vector(&torque), false);
            on_chassis_n_m -= torque;
        }
        let chassis = &mut self.rapier.bodies[self.chassis];
        chassis.reset_forces(false);
        chassis.reset_torques(false);
        chassis.add_force(convert::vector(&force_n), false);
        chassis.add_torque(convert::vector(&on_chassis_n_m), false);
        self.set_droops(&robot.robot, &robot.step.motors);
    }

    /// Takes over rapier's rates, and integrates the poses with them.
    fn move_on(&mut self, robot: &mut Articulated, dt_s: f64) {
        let Articulated {
            step,
            state,
            wheels,
            ..
        } = robot;
        let BodyStep {
            before,
            middle,
            ahead,
            ..
        } = step;
        state.velocity_m_s = Vector3::from_column_slice(&self.rates[..3]);
        state.angular_rad_s = Vector3::from_column_slice(&self.rates[3..6]);
        for (hub, rate_rad_s) in self.hubs.iter().zip(state.wheel_rates_mut()) {
            *rate_rad_s = self.rates[hub.dof];
        }
        // The pose in which rapier solved, with the rates after its step.
        ahead.copy_from(state);
        state.advance(dt_s);
        let mean = |before: &Vector3<f64>, after: &Vector3<f64>| 0.5 * (before + after);
        middle.velocity_m_s = mean(&before.velocity_m_s, &state.velocity_m_s);
        middle.angular_rad_s = mean(&before.angular_rad_s, &state.angular_rad_s);
        let rates = middle.wheel_rates_mut().iter_mut();
        for (mean, after) in rates.zip(state.wheel_rates_rad_s()) {
            *mean = 0.5 * (*mean + after);
        }
        for (index, (hub, wheel)) in self.hubs.iter_mut().zip(wheels).enumerate() {
            let before = before.hub_rate_in_hub(index);
            let after = state.hub_rate_in_hub(index);
            for (part, roller) in hub.rollers.iter_mut().zip(&mut wheel.rollers) {
                part.spin_before_rad_s = roller.spin_rad_s(&before);
                let spin_rad_s = self.rates[part.dof];
                roller.set_spin(spin_rad_s, &after);
                roller.angle_rad += spin_rad_s * dt_s;
            }
        }
    }

    /// The effect of rapier's contacts on a robot, the first body of its world, and each contact's
    /// violation of the laws of contact, in m/s.
    pub fn reactions(&self, robot: &Articulated) -> Vec<(Reaction, f64)> {
        let mut found = Vec::new();
        let (before, after) = (&robot.step.before, &robot.step.ahead);
        let on = |part| Member { body: 0, part };
        let chassis = &self.rapier.bodies[self.chassis];
        for collider in chassis.colliders() {
            for touch in touches(&self.rapier, *collider) {
                let velocity = |state: &State| state.chassis_velocity_m_s(&touch.at_m);
                let axes = frame(touch.normal, Vector3::x());
                let velocities = (velocity(before), velocity(after));
                found.push(touch.reaction(on(Part::Chassis), &axes, velocities, &Vector3::zeros()));
            }
        }
        for (index, (hub_in_rapier, wheel)) in self.hubs.iter().zip(&robot.wheels).enumerate() {
            let hub = &before.hubs()[index];
            let parts = hub_in_rapier.rollers.iter().zip(&wheel.rollers);
            for (place, (part, roller)) in parts.enumerate() {
                let axis = hub.rotation * roller.axis_in_hub;
                let center_m = roller.center_m(hub);
                let spins_rad_s = (part.spin_before_rad_s, self.rates[part.dof]);
                for touch in touches(&self.rapier, part.collider) {
                    let per_spin = axis.cross(&(touch.at_m - center_m));
                    let velocity = |state: &State, spin_rad_s: f64| {
                        state.hub_velocity_m_s(index, &touch.at_m) + spin_rad_s * per_spin
                    };
                    let velocities = (
                        velocity(before, spins_rad_s.0),
                        velocity(after, spins_rad_s.1),
                    );
                    let axes = frame(touch.normal, axis);
                    let part = on(Part::Roller(index, place));
                    found.push(touch.reaction(part, &axes, velocities, &per_spin));
                }
            }
        }
        found
    }

    /// Energy taken by damping and dry friction in all joints of a robot, in J. The torque of
    /// damping is that of the rate after the step, with which rapier solves it; work uses the mean
    /// rate.
    pub fn joints_lost_j(&self, robot: &Articulated, dt_s: f64) -> f64 {
        let power_w = |damping_n_m_s: f64, friction_n_m: f64, (before, after): (f64, f64)| {
            let mean_rad_s = 0.5 * (before + after);
            damping_n_m_s * after * mean_rad_s + friction_n_m * mean_rad_s.abs()
        };
        let mut lost_w = 0.0;
        for (index, (hub, wheel)) in self.hubs.iter().zip(&robot.robot.wheels).enumerate() {
            let rates = (
                robot.step.before.wheel_rates_rad_s()[index],
                robot.state.wheel_rates_rad_s()[index],
            );
            lost_w += power_w(wheel.joint.damping_n_m_s, wheel.dry_friction_n_m(), rates);
            for (part, roller) in hub.rollers.iter().zip(&wheel.rollers) {
                let spins = (part.spin_before_rad_s, self.rates[part.dof]);
                let joint = &roller.joint;
                lost_w += power_w(joint.damping_n_m_s, joint.friction_n_m, spins);
            }
        }
        lost_w * dt_s
    }
}

/// rapier has no motors with a rate limit: beyond it the motor does not drive for a step.
fn hold_below_limit(motor: &mut MotorTorque, rate_rad_s: f64) {
    let drives = motor.torque_n_m * rate_rad_s > 0.0;
    if drives && rate_rad_s.abs() >= motor.rate_limit_rad_s {
        motor.torque_n_m = 0.0;
    }
}

/// A point where rapier found a part of the robot pressing on the ground.
#[derive(Clone, Copy, Debug)]
struct Touch {
    at_m: Vector3<f64>,
    /// Out of the ground.
    normal: Vector3<f64>,
    /// On the robot, in N s: along the normal, and across it.
    normal_n_s: f64,
    rubbed_n_s: Vector3<f64>,
    friction: f64,
}

/// The points where a collider presses on the ground, in the floor's frame.
fn touches(rapier: &Engine, collider: ColliderHandle) -> impl Iterator<Item = Touch> {
    let pairs = rapier.narrow_phase.contact_pairs_with(collider);
    pairs.flat_map(move |pair| {
        let is_first = pair.collider1 == collider;
        // Impulses act on the first collider of a pair, and the normal points from it.
        let sign = if is_first { 1.0 } else { -1.0 };
        let other = if is_first {
            pair.collider2
        } else {
            pair.collider1
        };
        let rapier_from_ground = *rapier.colliders[other].position();
        let manifolds = pair.manifolds().iter();
        manifolds.flat_map(move |manifold| {
            let points = manifold.points.iter();
            let pressing = points.filter(|point| point.data.impulse > 0.0);
            pressing.map(move |point| {
                let on_ground = if is_first {
                    point.local_p2
                } else {
                    point.local_p1
                };
                Touch {
                    at_m: convert::to_vector(rapier_from_ground * on_ground),
                    normal: -sign * convert::to_vector(manifold.data.normal),
                    normal_n_s: point.data.impulse,
                    rubbed_n_s: sign * convert::to_vector(point.data.warmstart_tangent_world),
                    friction: manifold.data.friction,
                }
            })
        })
    })
}

impl Touch {
    /// Converts it to a reaction, given the velocities of the robot's surface before and after the
    /// step and their derivative by the spin; also returns its violation of the laws of contact, in
    /// m/s: motion across the ground under load, or sliding with friction below its limit.
    fn reaction(
        &self,
        a: Member,
        axes: &[Vector3<f64>; 3],
        (before, after): (Vector3<f64>, Vector3<f64>),
        per_spin: &Vector3<f64>,
    ) -> (Reaction, f64) {
        /// rapier's impulses are rounded. Chosen.
        const ROUNDED: f64 = 1e-3;
        let rubbed = along_frame(axes, &self.rubbed_n_s);
        let impulse = Vector3::new(self.normal_n_s, rubbed.y, rubbed.z);
        let (before, after) = (along_frame(axes, &before), along_frame(axes, &after));
        let limit_n_s = (1.0 - ROUNDED) * self.friction * self.normal_n_s;
        let sticks = rubbed.yz().norm() < limit_n_s;
        let slides_m_s = if sticks { after.yz().norm() } else { 0.0 };
        let reaction = Reaction {
            b: Partner::Ground,
            at_m: self.at_m,
            frame: *axes,
            friction: self.friction,
            impulse,
            velocity_after: after,
            taken_j: -0.5 * impulse.component_mul(&(before + after)),
            rolling_radius_m: along_frame(axes, per_spin).z,
            ..Reaction::within(a, before)
        };
        (reaction, after.x.abs().max(slides_m_s))
    }
}
