//! What a robot under a passive wheel law stores, and what it was supplied with.
//!
//! With the spring K e / D in the targets, w the law's wrench, w_g its part against gravity, v the true twist and nu_d the reference's:
//!
//!   S = kinetic + potential + e^T K e / 2 + springs between the wheels,
//!   dS/dt <= outside + w_g . v + (D nu_d + K e) . nu_d + (f . L q' - w . v),
//!
//! where the last bracket is what the law pushes wheels with while they slide: nothing while they roll. The right-hand side, summed, is the
//! supply; outside are pushes, payloads, ground that leans, and the servos of joints. What is left on the left is dampers, friction, and what a
//! spring that is held over a control period leaks, which dampers outdo.

use ilon_control::{Desired, PassiveEffort};
use ilon_robot::{Pose, Twist, wrap_angle};
use ilon_trace::Storage;
use ilon_world::World;
use nalgebra::{Vector2, Vector3};

/// The account of a run.
#[derive(Clone)]
pub(super) struct StorageAccount {
    stiffness: Vector3<f64>,
    reference_point_m: Vector2<f64>,
    supplied_j: f64,
    /// What was stored less what was supplied: the least of all steps so far, and the most that it rose from there.
    least_j: f64,
    rise_j: f64,
    // At the beginning of the step.
    motor_j: f64,
    pose: Pose,
    rates_rad_s: Vec<f64>,
    desired: Option<Pose>,
}

impl StorageAccount {
    /// Of springs with the stiffness along, along and about, on a point of the body.
    pub fn new(stiffness: Vector3<f64>, reference_point_m: Vector2<f64>, wheels: usize) -> Self {
        Self {
            stiffness,
            reference_point_m,
            supplied_j: 0.0,
            least_j: f64::INFINITY,
            rise_j: 0.0,
            motor_j: 0.0,
            pose: Pose::default(),
            rates_rad_s: vec![0.0; wheels],
            desired: None,
        }
    }

    /// Looks at the world before a step, once the law has decided.
    pub fn before(&mut self, world: &World, effort: &PassiveEffort<'_>, desired: Option<&Desired>) {
        let now = self.now(world, effort, desired);
        // The world counts what the weight has stored in the contacts' springs from the first step on.
        if world.time_s() > 0.0 {
            self.least_j = self.least_j.min(now.stored_j - now.supplied_j);
        }
        self.rise_j = now.rise_j;
        self.motor_j = world.motor_energy_j();
        self.pose = world.robot().state().pose;
        self.desired = desired.map(|desired| desired.pose);
        self.rates_rad_s
            .copy_from_slice(world.robot().wheel_rates_rad_s());
    }

    /// Counts what the law supplied in a step.
    pub fn after(
        &mut self,
        world: &World,
        effort: &PassiveEffort<'_>,
        desired: Option<&Desired>,
        dt_s: f64,
    ) {
        let robot = world.robot();
        let moved = self.of_point(self.pose.displacement_to(&robot.state().pose));
        let rates = self.rates_rad_s.iter().zip(robot.wheel_rates_rad_s());
        let between_j: f64 = (effort.between_n_m.iter().zip(rates))
            .map(|(between, (before, after))| between * 0.5 * (before + after) * dt_s)
            .sum();
        // Of the wheels' motors and of servos.
        let motors_j = world.motor_energy_j() - self.motor_j;
        let led = match (self.desired, desired) {
            (Some(before), Some(after)) => {
                let step = after.pose.position_m() - before.position_m();
                let (sin, cos) = libm::sincos(self.pose.heading_rad);
                Vector3::new(
                    cos * step.x + sin * step.y,
                    cos * step.y - sin * step.x,
                    wrap_angle(after.pose.heading_rad - before.heading_rad),
                )
            }
            // Targets without a pose push the robot along.
            _ => moved,
        };
        self.supplied_j += motors_j - between_j - effort.wrench.dot(&moved)
            + effort.against_gravity.dot(&moved)
            + effort.pull.dot(&led);
    }

    /// What is stored now, beside all that was supplied, once the law has decided.
    pub fn now(
        &self,
        world: &World,
        effort: &PassiveEffort<'_>,
        desired: Option<&Desired>,
    ) -> Storage {
        let energy = world.energy();
        let spring_j = desired.map_or(0.0, |desired| {
            let pose = world.robot().state().pose;
            let (sin, cos) = libm::sincos(pose.heading_rad);
            let c = self.reference_point_m;
            let arm = Vector2::new(cos * c.x - sin * c.y, sin * c.x + cos * c.y);
            let e = desired.pose.position_m() - pose.position_m() - arm;
            let e_phi = wrap_angle(desired.pose.heading_rad - pose.heading_rad);
            let e = Vector3::new(e.x, e.y, e_phi);
            0.5 * e.component_mul(&self.stiffness).dot(&e)
        });
        let stored_j = energy.kinetic_j + energy.potential_j + spring_j + effort.stored_j;
        let supplied_j = self.supplied_j + world.outside_energy_j();
        Storage {
            stored_j,
            supplied_j,
            rise_j: self.rise_j.max(stored_j - supplied_j - self.least_j),
        }
    }

    /// A displacement of the origin, at the point that the spring holds.
    fn of_point(&self, moved: Twist) -> Vector3<f64> {
        let (c, turn) = (self.reference_point_m, moved.omega_rad_s);
        Vector3::new(moved.vx_m_s - turn * c.y, moved.vy_m_s + turn * c.x, turn)
    }
}
