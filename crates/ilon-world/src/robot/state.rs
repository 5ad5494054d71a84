//! Where everything is and how it moves, in f64, in the floor's frame: z stands on the plane, x and y lie in it.

use std::sync::Arc;

use ilon_robot::Robot;
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use crate::dynamics::{LinkPose, ROOT_DOFS, Tree};

/// The state of a robot but for its rollers.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// Pose of the chassis's centre of mass, along the body's axes.
    floor_from_chassis: Isometry3<f64>,
    /// Velocity of the chassis's centre of mass, in the floor's frame, m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Angular velocity of the chassis, in the floor's frame, rad/s.
    pub angular_rad_s: Vector3<f64>,
    /// Angles of the wheels, in rad, not wrapped.
    wheel_angles_rad: Vec<f64>,
    /// Rates of the wheels, in rad/s.
    pub wheel_rates_rad_s: Vec<f64>,
    /// What is joined to what; copies of a state share it.
    tree: Arc<Tree>,
    /// Where the chassis and the hubs are: follows from the poses above.
    chassis: LinkPose,
    hubs: Vec<LinkPose>,
}

impl State {
    /// A robot at rest with its body frame at a pose.
    pub fn at_rest(robot: &Robot, tree: &Arc<Tree>, floor_from_body: &Isometry3<f64>) -> Self {
        let body_from_chassis = Isometry3::from(robot.chassis.mass.center_of_mass_m);
        let nowhere = LinkPose {
            center_m: Vector3::zeros(),
            rotation: Matrix3::identity(),
        };
        let mut state = Self {
            floor_from_chassis: floor_from_body * body_from_chassis,
            velocity_m_s: Vector3::zeros(),
            angular_rad_s: Vector3::zeros(),
            wheel_angles_rad: vec![0.0; robot.wheels.len()],
            wheel_rates_rad_s: vec![0.0; robot.wheels.len()],
            tree: Arc::clone(tree),
            chassis: nowhere,
            hubs: vec![nowhere; robot.wheels.len()],
        };
        state.place_hubs();
        state
    }

    /// Pose of the chassis's centre of mass, along the body's axes.
    pub fn floor_from_chassis(&self) -> &Isometry3<f64> {
        &self.floor_from_chassis
    }

    /// The chassis's centre of mass, in metres.
    pub fn center_m(&self) -> Vector3<f64> {
        self.floor_from_chassis.translation.vector
    }

    /// Angles of the wheels, in rad, not wrapped.
    pub fn wheel_angles_rad(&self) -> &[f64] {
        &self.wheel_angles_rad
    }

    /// The chassis's centre of mass and its axes.
    pub fn chassis(&self) -> &LinkPose {
        &self.chassis
    }

    /// Where the hubs are.
    pub fn hubs(&self) -> &[LinkPose] {
        &self.hubs
    }

    /// Puts the chassis somewhere else.
    #[cfg(test)]
    pub fn place(&mut self, floor_from_chassis: Isometry3<f64>) {
        self.floor_from_chassis = floor_from_chassis;
        self.place_hubs();
    }

    /// Puts everything where it is in another state of the same robot; the rates stay.
    pub fn take_poses(&mut self, other: &Self) {
        self.floor_from_chassis = other.floor_from_chassis;
        self.wheel_angles_rad
            .copy_from_slice(&other.wheel_angles_rad);
        self.chassis = other.chassis;
        self.hubs.copy_from_slice(&other.hubs);
    }

    /// Moves the poses on for `dt_s` with the rates as they are.
    pub fn advance(&mut self, dt_s: f64) {
        self.move_chassis(self.velocity_m_s, self.angular_rad_s, dt_s);
        let wheels = self.wheel_angles_rad.iter_mut();
        for (angle_rad, rate_rad_s) in wheels.zip(&self.wheel_rates_rad_s) {
            *angle_rad += dt_s * rate_rad_s;
        }
        self.place_hubs();
    }

    /// Moves the poses on for `dt_s` with the rates of another state of the same robot.
    pub fn advance_with(&mut self, rates: &Self, dt_s: f64) {
        self.move_chassis(rates.velocity_m_s, rates.angular_rad_s, dt_s);
        let wheels = self.wheel_angles_rad.iter_mut();
        for (angle_rad, rate_rad_s) in wheels.zip(&rates.wheel_rates_rad_s) {
            *angle_rad += dt_s * rate_rad_s;
        }
        self.place_hubs();
    }

    fn move_chassis(&mut self, velocity_m_s: Vector3<f64>, angular_rad_s: Vector3<f64>, dt_s: f64) {
        self.floor_from_chassis.translation.vector += dt_s * velocity_m_s;
        self.floor_from_chassis.rotation =
            UnitQuaternion::new(dt_s * angular_rad_s) * self.floor_from_chassis.rotation;
    }

    fn place_hubs(&mut self) {
        let Isometry3 {
            rotation,
            translation,
        } = self.floor_from_chassis;
        self.chassis = LinkPose {
            center_m: translation.vector,
            rotation: rotation.to_rotation_matrix().into_inner(),
        };
        let angles_rad = &self.wheel_angles_rad;
        self.tree.place(&self.chassis, angles_rad, &mut self.hubs);
    }

    /// Writes its rates down by degree of freedom.
    pub fn write_rates(&self, rates: &mut [f64]) {
        rates[..3].copy_from_slice(self.velocity_m_s.as_slice());
        rates[3..ROOT_DOFS].copy_from_slice(self.angular_rad_s.as_slice());
        rates[ROOT_DOFS..].copy_from_slice(&self.wheel_rates_rad_s);
    }

    /// Takes over rates by degree of freedom.
    pub fn take_rates(&mut self, rates: &[f64]) {
        self.velocity_m_s = Vector3::from_column_slice(&rates[..3]);
        self.angular_rad_s = Vector3::from_column_slice(&rates[3..ROOT_DOFS]);
        self.wheel_rates_rad_s.copy_from_slice(&rates[ROOT_DOFS..]);
    }

    /// Angular velocity of a hub, in the floor's frame, in rad/s.
    pub fn hub_rate(&self, wheel: usize) -> Vector3<f64> {
        self.angular_rad_s + self.wheel_rates_rad_s[wheel] * self.hubs[wheel].axis()
    }

    /// Angular velocity of a hub in its own frame, in rad/s.
    pub fn hub_rate_in_hub(&self, wheel: usize) -> Vector3<f64> {
        self.hubs[wheel].rotation.tr_mul(&self.angular_rad_s)
            + Vector3::z() * self.wheel_rates_rad_s[wheel]
    }

    /// Velocity of a place of the chassis, in m/s.
    pub fn chassis_velocity_m_s(&self, place_m: &Vector3<f64>) -> Vector3<f64> {
        self.velocity_m_s + self.angular_rad_s.cross(&(place_m - self.center_m()))
    }

    /// Velocity of a place that turns with a hub, in m/s.
    pub fn hub_velocity_m_s(&self, wheel: usize, place_m: &Vector3<f64>) -> Vector3<f64> {
        let hub_m = self.hubs[wheel].center_m;
        self.chassis_velocity_m_s(&hub_m) + self.hub_rate(wheel).cross(&(place_m - hub_m))
    }

    /// Counts the state of the chassis at another point of it, further by `moved_m` in the body's axes, which is the centre of mass of the
    /// root of another tree.
    pub fn recenter(&mut self, moved_m: Vector3<f64>, tree: &Arc<Tree>) {
        let lever_m = self.floor_from_chassis.rotation * moved_m;
        self.floor_from_chassis.translation.vector += lever_m;
        self.velocity_m_s += self.angular_rad_s.cross(&lever_m);
        self.tree = Arc::clone(tree);
        self.place_hubs();
    }

    /// Copies another state of the same robot without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.take_poses(other);
        self.velocity_m_s = other.velocity_m_s;
        self.angular_rad_s = other.angular_rad_s;
        self.wheel_rates_rad_s
            .copy_from_slice(&other.wheel_rates_rad_s);
    }
}
