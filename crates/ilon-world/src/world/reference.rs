//! The reference mode: rapier alone. Every roller is a body on a joint of its own, and rapier's own solver sweeps over contacts
//! and dry bearings, as it does for anybody who builds such a robot with it.
//!
//! rapier solves contacts in the poses with which a step begins, and moves on with the rates after it. State, contacts and energies are
//! read from it into the same figures as in ilon's own mode: positions are summed in f64 here too, for in f32 a robot would lose
//! its small increments.

use nalgebra::Vector3;
use rapier3d::prelude::*;

use super::World;
use crate::Settings;
use crate::contact::candidates::{along_frame, frame};
use crate::contact::reaction::{Member, Part, Partner, Reaction};
use crate::engine::convert;
use crate::engine::copy::Engine;
use crate::ground::{Anchor, Grip};
use crate::robot::articulated::Articulated;
use crate::robot::state::State;

/// Natural frequency of a contact's spring, in Hz, and its damping ratio. rapier's default of 30 Hz lets light rollers sink in.
const CONTACT_HZ: Real = 1000.0;
const CONTACT_DAMPING_RATIO: Real = 1.0;

/// Sweeps over the contacts of a step.
const SWEEPS: usize = 32;

/// rapier's solver as it has to be set for light rollers under a heavy robot.
pub(super) fn integration_parameters(settings: &Settings) -> IntegrationParameters {
    let softness = SpringCoefficients::new(CONTACT_HZ, CONTACT_DAMPING_RATIO);
    IntegrationParameters {
        dt: settings.dt_s as Real,
        contact_softness: softness,
        static_contact_softness: softness,
        num_solver_iterations: 1,
        // With stabilisation rapier solves friction after it has moved the bodies: large steps then lose up to 40 %.
        num_internal_stabilization_iterations: 0,
        num_internal_pgs_iterations: SWEEPS,
        contact_clustering: false,
        // A recycled contact keeps its old lever arm, but a roller's contact wanders along it all the time.
        contact_recycling: false,
        friction_model: FrictionModel::Coulomb,
        max_ccd_substeps: 0,
        ..IntegrationParameters::default()
    }
}

impl World {
    /// Advances the world by a time, with contacts that rapier solves.
    pub(super) fn advance_in_rapier(&mut self, dt_s: f64) {
        let mut found = Vec::new();
        for (index, body) in self.bodies.iter_mut().enumerate() {
            body.before.copy_from(&body.state);
            body.middle.copy_from(&body.state);
            body.rapier.integration_parameters.dt = dt_s as Real;
            body.set_poses_in_rapier(&self.ground);
            body.set_motors_in_rapier();
            body.begin_pushes();
            let grip = Grip {
                ground: &self.ground,
                anchor: &body.anchor,
            };
            body.rapier.step(&grip);
            body.read_rates(dt_s);
            body.read_reactions(index, &mut found);
        }
        self.reactions.take(found);
        self.count_motors(dt_s);
        self.read_contacts(dt_s);
        for body in &mut self.bodies {
            self.energies.bearing_j += body.joints_lost_j(dt_s);
            body.end_pushes(dt_s, &mut self.energies);
        }
    }
}

impl Articulated {
    /// Gives rapier the motors' torques.
    fn set_motors_in_rapier(&mut self) {
        let mut reaction = Vector3::zeros();
        for (index, motor) in self.motors.iter_mut().enumerate() {
            let wheel = &self.assembly.wheels[index];
            let rate_rad_s = self.middle.wheel_rates_rad_s[index];
            // rapier knows no motor that has a rate limit: beyond it the motor does not drive for a step.
            let drives = motor.torque_n_m * rate_rad_s > 0.0;
            if drives && rate_rad_s.abs() >= motor.rate_limit_rad_s {
                motor.torque_n_m = 0.0;
            }
            // rapier's damping takes droop x rate off; only droop x (rate - rate now) shall go.
            let undamped_n_m = motor.droop_n_m_s * rate_rad_s;
            let axis = self.middle.hubs()[index].axis();
            let torque = axis * (motor.torque_n_m + undamped_n_m);
            let hub = &mut self.rapier.bodies[wheel.hub];
            hub.reset_torques(false);
            hub.add_torque(convert::vector(&torque), false);
            reaction -= torque;
        }
        let chassis = &mut self.rapier.bodies[self.assembly.chassis];
        chassis.reset_torques(false);
        chassis.add_torque(convert::vector(&reaction), false);
        self.assembly
            .set_droops(&mut self.rapier, &self.robot, &self.motors);
    }

    /// Takes rapier's rates over, and sums the poses with them.
    fn read_rates(&mut self, dt_s: f64) {
        let in_rapier = self.assembly.rates_in_rapier(&self.rapier);
        for (rate, in_rapier) in self.rates_free.iter_mut().zip(in_rapier) {
            *rate = f64::from(*in_rapier);
        }
        self.assembly.set_rates(&self.rates_free, &mut self.state);
        // Where rapier solved, with the rates that it came to.
        self.ahead.copy_from(&self.state);
        self.state.advance(dt_s);
        let mean = |before: &Vector3<f64>, after: &Vector3<f64>| 0.5 * (before + after);
        self.middle.velocity_m_s = mean(&self.before.velocity_m_s, &self.state.velocity_m_s);
        self.middle.angular_rad_s = mean(&self.before.angular_rad_s, &self.state.angular_rad_s);
        let rates = self.middle.wheel_rates_rad_s.iter_mut();
        for (mean, after) in rates.zip(&self.state.wheel_rates_rad_s) {
            *mean = 0.5 * (*mean + after);
        }
        for (index, wheel) in self.assembly.wheels.iter_mut().enumerate() {
            let before = self.before.hub_rate_in_hub(index);
            let after = self.state.hub_rate_in_hub(index);
            for part in &mut wheel.bodies {
                let roller = &mut wheel.rollers[part.roller];
                part.spin_before_rad_s = roller.spin_rad_s(&before);
                let spin_rad_s = self.rates_free[part.dof];
                roller.set_spin(spin_rad_s, &after);
                roller.angle_rad += spin_rad_s * dt_s;
            }
        }
    }

    /// Reads what rapier's contacts did to this body of the world.
    fn read_reactions(&self, index: usize, found: &mut Vec<(Reaction, f64)>) {
        let (before, after) = (&self.before, &self.ahead);
        let on = |part| Member { body: index, part };
        let chassis = &self.rapier.bodies[self.assembly.chassis];
        for collider in chassis.colliders() {
            for touch in touches(&self.rapier, &self.anchor, *collider) {
                let velocity = |state: &State| state.chassis_velocity_m_s(&touch.at_m);
                let axes = frame(touch.normal, Vector3::x());
                let velocities = (velocity(before), velocity(after));
                found.push(touch.reaction(on(Part::Chassis), &axes, velocities, &Vector3::zeros()));
            }
        }
        for (index, wheel) in self.assembly.wheels.iter().enumerate() {
            let hub = &before.hubs()[index];
            for part in &wheel.bodies {
                let roller = &wheel.rollers[part.roller];
                let axis = hub.rotation * roller.axis_in_hub;
                let center_m = roller.center_m(hub);
                let spins_rad_s = (part.spin_before_rad_s, self.rates_free[part.dof]);
                for touch in touches(&self.rapier, &self.anchor, part.collider) {
                    let per_spin = axis.cross(&(touch.at_m - center_m));
                    let velocity = |state: &State, spin_rad_s: f64| {
                        state.hub_velocity_m_s(index, &touch.at_m) + spin_rad_s * per_spin
                    };
                    let velocities = (
                        velocity(before, spins_rad_s.0),
                        velocity(after, spins_rad_s.1),
                    );
                    let axes = frame(touch.normal, axis);
                    let part = on(Part::Roller(index, part.roller));
                    found.push(touch.reaction(part, &axes, velocities, &per_spin));
                }
            }
        }
    }

    /// What damping and dry friction took in all joints, in J. The torque of damping is that of the rate after the step, with
    /// which rapier solves it; work goes with the mean rate.
    fn joints_lost_j(&self, dt_s: f64) -> f64 {
        let power_w = |damping_n_m_s: f64, friction_n_m: f64, (before, after): (f64, f64)| {
            let mean_rad_s = 0.5 * (before + after);
            damping_n_m_s * after * mean_rad_s + friction_n_m * mean_rad_s.abs()
        };
        let mut lost_w = 0.0;
        let wheels = self.assembly.wheels.iter().zip(&self.robot.wheels);
        for (index, (body, wheel)) in wheels.enumerate() {
            let rates = (
                self.before.wheel_rates_rad_s[index],
                self.state.wheel_rates_rad_s[index],
            );
            lost_w += power_w(wheel.joint.damping_n_m_s, wheel.dry_friction_n_m(), rates);
            for (part, roller) in body.bodies.iter().zip(&wheel.rollers) {
                let spins = (part.spin_before_rad_s, self.rates_free[part.dof]);
                let joint = &roller.joint;
                lost_w += power_w(joint.damping_n_m_s, joint.friction_n_m, spins);
            }
        }
        lost_w * dt_s
    }
}

/// A place where rapier found a part of the robot to press on the ground.
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

/// The places where a collider presses on the ground, in the floor's frame.
fn touches(
    rapier: &Engine,
    anchor: &Anchor,
    collider: ColliderHandle,
) -> impl Iterator<Item = Touch> {
    let pairs = rapier.narrow_phase.contact_pairs_with(collider);
    pairs.flat_map(move |pair| {
        let is_first = pair.collider1 == collider;
        // Impulses are given on the first collider of a pair, and the normal points from it.
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
                let in_rapier_m = convert::to_f64(rapier_from_ground * on_ground);
                Touch {
                    at_m: anchor.origin_m() + in_rapier_m,
                    normal: -sign * convert::to_f64(manifold.data.normal),
                    normal_n_s: f64::from(point.data.impulse),
                    rubbed_n_s: sign * convert::to_f64(point.data.warmstart_tangent_world),
                    friction: f64::from(manifold.data.friction),
                }
            })
        })
    })
}

impl Touch {
    /// The reaction that it is, given the robot's surface's velocities before and after the step and what a unit of spin adds to them;
    /// and by how much it breaks the laws of contact, in m/s: moving across the ground while it presses, or sliding although
    /// friction is within its limit.
    fn reaction(
        &self,
        a: Member,
        axes: &[Vector3<f64>; 3],
        (before, after): (Vector3<f64>, Vector3<f64>),
        per_spin: &Vector3<f64>,
    ) -> (Reaction, f64) {
        /// rapier's impulses are rounded.
        const ROUNDED: f64 = 1e-3;
        let rubbed = along_frame(axes, &self.rubbed_n_s);
        let impulse = Vector3::new(self.normal_n_s, rubbed.y, rubbed.z);
        let (before, after) = (along_frame(axes, &before), along_frame(axes, &after));
        let limit_n_s = (1.0 - ROUNDED) * self.friction * self.normal_n_s;
        let sticks = rubbed.yz().norm() < limit_n_s;
        let slides_m_s = if sticks { after.yz().norm() } else { 0.0 };
        let reaction = Reaction {
            a,
            b: Partner::Ground,
            at_m: self.at_m,
            frame: *axes,
            friction: self.friction,
            nap: None,
            impulse,
            velocity_before: before,
            velocity_after: after,
            taken_j: -0.5 * impulse.component_mul(&(before + after)),
            came_down: false,
            rolling_radius_m: along_frame(axes, per_spin).z,
            gives: None,
        };
        (reaction, after.x.abs().max(slides_m_s))
    }
}
