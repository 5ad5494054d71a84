//! What can be read of a world: the truth, in f64 and in the project's frames.

use ilon_robot::{Pose as PlanarPose, Twist, roll_pitch_yaw};
use nalgebra::{Translation3, UnitQuaternion};

use super::World;
use crate::contact::wheel_contact::WheelContact;
use crate::robot::energy::Energy;

/// The chassis as seen from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
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
        let robot = self.robot();
        let (state, center_m) = (&robot.state, robot.chassis_mass.center_of_mass_m);
        let floor_from_body = state.floor_from_chassis() * Translation3::from(-center_m);
        let position = floor_from_body.translation.vector;
        let rotation = floor_from_body.rotation.to_rotation_matrix();
        let [roll_rad, pitch_rad, heading_rad] = roll_pitch_yaw(&rotation);
        let body_from_floor = self.rates_from().inverse();
        let angular_in_body = body_from_floor * state.angular_rad_s;
        let velocity_in_body =
            body_from_floor * state.velocity_m_s - angular_in_body.cross(&center_m);
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

    /// How the chassis was turned where its rates hold: as it is now, or, after a step that did not see rollers pass, as in the
    /// middle of that step. At its end such rates would seem to drift sideways, by v omega dt / 2.
    fn rates_from(&self) -> UnitQuaternion<f64> {
        let robot = self.robot();
        let state = if robot.sees_rollers_pass {
            &robot.state
        } else {
            &robot.middle
        };
        state.floor_from_chassis().rotation
    }

    /// Angles of the wheels about their hub axes since the start, in rad, not wrapped.
    pub fn wheel_angles_rad(&self) -> &[f64] {
        self.robot().state.wheel_angles_rad()
    }

    /// Rates of the wheels about their hub axes, in rad/s.
    pub fn wheel_rates_rad_s(&self) -> &[f64] {
        &self.robot().state.wheel_rates_rad_s
    }

    /// Torques that the motors put on the wheels during the last step, in N m.
    pub fn motor_torques_n_m(&self) -> &[f64] {
        &self.robot().acted_n_m
    }

    /// Height of a wheel's centre above the floor's plane, level or not, in metres.
    ///
    /// # Panics
    /// Where the robot has no such wheel.
    pub fn hub_height_m(&self, wheel: usize) -> f64 {
        self.robot().state.hubs()[wheel].center_m.z
    }

    /// Where each roller of a wheel is on its axle, along its axis from the middle of its play, in metres; 0 without play.
    ///
    /// # Panics
    /// Where the robot has no such wheel.
    pub fn roller_places_m(&self, wheel: usize) -> impl Iterator<Item = f64> {
        let rollers = &self.robot().assembly.wheels[wheel].rollers;
        rollers.iter().map(|roller| roller.place_m())
    }

    /// How deep the deepest place of all barrels lies below the surface of the ground now, in metres; 0 where all are clear of
    /// it. Contacts give way by what loads them over [`Settings::contact_stiffness_n_m`](crate::Settings::contact_stiffness_n_m), and a landing is caught within a
    /// step; anything more would be an error of the simulation. Rollers with shapes of their file do not count.
    pub fn penetration_m(&self) -> f64 {
        let mut pieces = Vec::new();
        let mut deepest_m = 0.0;
        let robot = self.robot();
        let hubs = robot.state.hubs().iter();
        for (body, hub) in robot.assembly.wheels.iter().zip(hubs) {
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
        &self.robot().contacts
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
        let potential_j = self.potential_j() + (self.energies.springs_j + self.energies.treads_j);
        Energy {
            kinetic_j: self.kinetic_j(),
            potential_j,
        }
    }

    pub(super) fn kinetic_j(&self) -> f64 {
        let bodies = self.bodies.iter();
        bodies
            .map(|body| body.kinetic_j(self.settings.contacts))
            .sum()
    }

    fn potential_j(&self) -> f64 {
        let gravity = self.ground.gravity_in_floor(self.settings.gravity_m_s2);
        let bodies = self.bodies.iter();
        bodies.map(|body| body.potential_j(&gravity)).sum()
    }

    /// Spins of all rollers of a wheel about their own axes against the hub, in rad/s, in the robot's order.
    ///
    /// # Panics
    /// Where the robot has no such wheel.
    pub fn roller_spins_rad_s(&self, wheel: usize) -> Vec<f64> {
        let robot = self.robot();
        let hub_rate_in_hub = robot.state.hub_rate_in_hub(wheel);
        let rollers = robot.assembly.wheels[wheel].rollers.iter();
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
        let rollers = self.robot().assembly.wheels[wheel].rollers.iter();
        rollers.map(|roller| roller.angle_rad)
    }
}
