//! Where everything is and how it moves, in f64, in the floor's frame: z stands on the plane, x and y lie in it.

use ilon_robot::Robot;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::ground::Ground;

/// The state of a robot but for its rollers.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// Pose of the chassis's centre of mass, along the body's axes. rapier's multibody wants a root whose origin is
    /// its centre of mass.
    pub floor_from_chassis: Isometry3<f64>,
    /// Velocity of the chassis's centre of mass, in the floor's frame, m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Angular velocity of the chassis, in the floor's frame, rad/s.
    pub angular_rad_s: Vector3<f64>,
    /// Angles of the wheels, in rad, not wrapped.
    pub wheel_angles_rad: Vec<f64>,
    /// Rates of the wheels, in rad/s.
    pub wheel_rates_rad_s: Vec<f64>,
    /// Poses of the hub frames in the chassis frame at wheel angle zero.
    chassis_from_hub: Vec<Isometry3<f64>>,
}

impl State {
    /// A robot at rest with its body frame at a pose.
    pub fn at_rest(robot: &Robot, floor_from_body: &Isometry3<f64>) -> Self {
        let body_from_chassis = Isometry3::from(robot.chassis.mass.center_of_mass_m);
        let chassis_from_body = body_from_chassis.inverse();
        Self {
            floor_from_chassis: floor_from_body * body_from_chassis,
            velocity_m_s: Vector3::zeros(),
            angular_rad_s: Vector3::zeros(),
            wheel_angles_rad: vec![0.0; robot.wheels.len()],
            wheel_rates_rad_s: vec![0.0; robot.wheels.len()],
            chassis_from_hub: robot
                .wheels
                .iter()
                .map(|wheel| chassis_from_body * wheel.body_from_hub)
                .collect(),
        }
    }

    /// Pose of a hub's frame, turned with the wheel.
    pub fn floor_from_hub(&self, wheel: usize) -> Isometry3<f64> {
        let turned =
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.wheel_angles_rad[wheel]);
        self.floor_from_chassis * self.chassis_from_hub[wheel] * turned
    }

    /// Angular velocity of a hub in its own frame, in rad/s.
    pub fn hub_rate_in_hub(&self, wheel: usize) -> Vector3<f64> {
        self.hub_rate_at(wheel, self)
    }

    /// Angular velocity of a hub, in the frame that it had in another state, in rad/s.
    pub fn hub_rate_at(&self, wheel: usize, place: &Self) -> Vector3<f64> {
        let hub_from_floor = place.floor_from_hub(wheel).rotation.inverse();
        hub_from_floor * self.angular_rad_s + Vector3::z() * self.wheel_rates_rad_s[wheel]
    }

    /// Counts the state of the chassis at another point of it, further by `moved_m` in the body's axes: where its centre
    /// of mass is now.
    pub fn recenter(&mut self, moved_m: Vector3<f64>) {
        let lever_m = self.floor_from_chassis.rotation * moved_m;
        self.floor_from_chassis.translation.vector += lever_m;
        self.velocity_m_s += self.angular_rad_s.cross(&lever_m);
        for chassis_from_hub in &mut self.chassis_from_hub {
            chassis_from_hub.translation.vector -= moved_m;
        }
    }

    /// The same state as rapier counts it, from its own origin.
    pub fn seen_from(&self, ground: &Ground) -> Self {
        let mut seen = self.clone();
        seen.floor_from_chassis = ground.rapier_from_floor() * self.floor_from_chassis;
        seen
    }

    /// Copies another state of the same robot without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.floor_from_chassis = other.floor_from_chassis;
        self.velocity_m_s = other.velocity_m_s;
        self.angular_rad_s = other.angular_rad_s;
        self.wheel_angles_rad
            .copy_from_slice(&other.wheel_angles_rad);
        self.wheel_rates_rad_s
            .copy_from_slice(&other.wheel_rates_rad_s);
    }
}
