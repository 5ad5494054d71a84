//! The storage function of a robot under a passive wheel law, and its supply.
//!
//! With the spring K e / D in the targets, w the law's wrench, w_g its part against gravity, v the
//! true twist and nu_d the reference's:
//!
//! - S = kinetic + potential + e^T K e / 2 + springs between the wheels,
//! - dS/dt <= outside + w_g . v + (D nu_d + K e) . nu_d + (f . L q' - w . v),
//!
//! where the last bracket is the power of the law on wheels that slide: zero while they roll. The
//! integral of the right-hand side is the supply; outside are pushes, payloads, tilting ground, and
//! the servos of joints. The difference of both sides is dampers, friction, and the energy error of
//! a spring that is held over a control period, which dampers exceed.

use ilon_control::{Desired, PassiveEffort};
use ilon_robot::{Pose, wrap_angle};
use ilon_trace::Storage;
use ilon_world::World;
use nalgebra::{Vector2, Vector3};

/// The account of a run.
#[derive(Clone)]
pub(crate) struct StorageAccount {
    stiffness: Vector3<f64>,
    reference_point_m: Vector2<f64>,
    supplied_j: f64,
    /// Storage minus supply: the minimum over all steps so far, and the largest rise from there.
    least_j: f64,
    rise_j: f64,
    // At the beginning of the step.
    motor_j: f64,
    pose: Pose,
    rates_rad_s: Vec<f64>,
    desired: Option<Pose>,
}

impl StorageAccount {
    /// For springs with the stiffness along x, along y and in rotation, on a point of the body.
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

    /// Observes the world before a step, after the law has decided.
    pub fn before(&mut self, world: &World, effort: &PassiveEffort<'_>, desired: Option<&Desired>) {
        let now = self.now(world, effort, desired);
        // The world includes the energy of the contacts' springs under the weight only from the
        // first step on.
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

    /// Counts the supply by the law in a step.
    pub fn after(
        &mut self,
        world: &World,
        effort: &PassiveEffort<'_>,
        desired: Option<&Desired>,
        dt_s: f64,
    ) {
        let robot = world.robot();
        let moved = self.pose.displacement_to(&robot.state().pose);
        let moved = moved.at(self.reference_point_m);
        let moved = Vector3::new(moved.vx_m_s, moved.vy_m_s, moved.omega_rad_s);
        let rates = self.rates_rad_s.iter().zip(robot.wheel_rates_rad_s());
        let between_j: f64 = (effort.between_n_m.iter().zip(rates))
            .map(|(between, (before, after))| between * 0.5 * (before + after) * dt_s)
            .sum();
        // Work of the wheels' motors and of servos.
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
            // Targets without a pose move the equilibrium with the robot.
            _ => moved,
        };
        self.supplied_j += motors_j - between_j - effort.wrench.dot(&moved)
            + effort.against_gravity.dot(&moved)
            + effort.pull.dot(&led);
    }

    /// The current storage, and the total supply, after the law has decided.
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
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use ilon_robot::Twist;
    use ilon_world::{Floor, Settings};

    use super::*;

    /// A robot with its heading to the left has the point (0.1, 0.05) of its body at (-0.05, 0.1)
    /// from its origin. Springs of K = (600, 400) N/m and 20 N m/rad there store (K_x e_x^2 + K_y
    /// e_y^2 + K_phi e_phi^2) / 2 relative to a pose, and nothing at the desired pose.
    #[test]
    fn the_spring_is_stretched_from_the_point_that_it_holds() {
        const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
        let text = "robot.file = \"mecanum4.urdf\"\ntwist.vx_m_s = 0.1\nrun.duration_s = 1\n";
        let scenario =
            ilon_scenario::Scenario::from_toml(text, "storage", ROBOTS).expect("a scenario");
        let robot = ilon_scenario::robot::load_robot(&scenario).expect("a shipped robot");
        let start = Pose {
            x_m: 2.0,
            y_m: -1.0,
            heading_rad: FRAC_PI_2,
        };
        let world = World::new(&robot, &Floor::default(), start, &Settings::default());
        let world = world.expect("it stands on a plane");
        let stiffness = Vector3::new(600.0, 400.0, 20.0);
        let account = StorageAccount::new(stiffness, Vector2::new(0.1, 0.05), 4);
        let stored_j = |desired: Option<Pose>| {
            let desired = desired.map(|pose| Desired {
                pose,
                velocity_in_world: Twist::default(),
            });
            let storage = account.now(&world, &PassiveEffort::default(), desired.as_ref());
            storage.stored_j
        };
        let held = |x_m: f64, y_m: f64, turn_rad: f64| {
            let desired = Pose {
                x_m: start.x_m - 0.05 + x_m,
                y_m: start.y_m + 0.1 + y_m,
                heading_rad: start.heading_rad + turn_rad,
            };
            stored_j(Some(desired)) - stored_j(None)
        };
        for (x_m, y_m, turn_rad, expected_j) in [
            (0.0, 0.0, 0.0, 0.0),
            (0.2, 0.0, 0.0, 12.0),
            (0.0, -0.3, 0.0, 18.0),
            (0.2, -0.3, 0.4, 12.0 + 18.0 + 1.6),
        ] {
            // Rounding of the weight's energy, some joules, in f64.
            let found_j = held(x_m, y_m, turn_rad);
            assert!((found_j - expected_j).abs() < 1e-9, "{found_j} J");
        }
    }
}
