//! Where everything is and how it moves, in f64, in the floor's frame: z stands on the plane, x and y lie in it.

use std::sync::Arc;

use ilon_robot::Robot;
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use crate::ground::Anchor;

/// The state of a robot but for its rollers.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// Pose of the chassis's centre of mass, along the body's axes. rapier's multibody wants a root whose origin is
    /// its centre of mass.
    floor_from_chassis: Isometry3<f64>,
    /// Velocity of the chassis's centre of mass, in the floor's frame, m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Angular velocity of the chassis, in the floor's frame, rad/s.
    pub angular_rad_s: Vector3<f64>,
    /// Angles of the wheels, in rad, not wrapped.
    wheel_angles_rad: Vec<f64>,
    /// Rates of the wheels, in rad/s.
    pub wheel_rates_rad_s: Vec<f64>,
    /// Poses of the hub frames in the chassis frame at wheel angle zero; copies of a state share them.
    chassis_from_hub: Arc<[Isometry3<f64>]>,
    /// Where the hubs are: follows from the poses above.
    hubs: Vec<HubPose>,
}

/// Pose of a hub's frame, turned with the wheel, in the floor's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HubPose {
    /// The hub's middle, in metres.
    pub center_m: Vector3<f64>,
    /// The rotation from the hub frame.
    pub rotation: Matrix3<f64>,
}

impl HubPose {
    /// The hub's axis.
    pub fn axis(&self) -> Vector3<f64> {
        self.rotation.column(2).into_owned()
    }

    /// A place of the hub frame in the floor's frame, in metres.
    pub fn place_m(&self, in_hub_m: &Vector3<f64>) -> Vector3<f64> {
        self.center_m + self.rotation * in_hub_m
    }
}

impl State {
    /// A robot at rest with its body frame at a pose.
    pub fn at_rest(robot: &Robot, floor_from_body: &Isometry3<f64>) -> Self {
        let body_from_chassis = Isometry3::from(robot.chassis.mass.center_of_mass_m);
        let chassis_from_body = body_from_chassis.inverse();
        let nowhere = HubPose {
            center_m: Vector3::zeros(),
            rotation: Matrix3::identity(),
        };
        let mut state = Self {
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

    /// Where the hubs are.
    pub fn hubs(&self) -> &[HubPose] {
        &self.hubs
    }

    /// Puts the chassis somewhere else.
    pub fn place(&mut self, floor_from_chassis: Isometry3<f64>) {
        self.floor_from_chassis = floor_from_chassis;
        self.place_hubs();
    }

    /// Puts everything where it is in another state of the same robot; the rates stay.
    pub fn take_poses(&mut self, other: &Self) {
        self.floor_from_chassis = other.floor_from_chassis;
        self.wheel_angles_rad
            .copy_from_slice(&other.wheel_angles_rad);
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
        let placed = self.hubs.iter_mut().zip(&*self.chassis_from_hub);
        for ((hub, chassis_from_hub), angle_rad) in placed.zip(&self.wheel_angles_rad) {
            let floor_from_hub = self.floor_from_chassis * chassis_from_hub;
            let at_zero = floor_from_hub.rotation.to_rotation_matrix().into_inner();
            let (sin, cos) = (libm::sin(*angle_rad), libm::cos(*angle_rad));
            let (x, y) = (at_zero.column(0), at_zero.column(1));
            *hub = HubPose {
                center_m: floor_from_hub.translation.vector,
                rotation: Matrix3::from_columns(&[
                    cos * x + sin * y,
                    cos * y - sin * x,
                    at_zero.column(2).into_owned(),
                ]),
            };
        }
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

    /// Counts the state of the chassis at another point of it, further by `moved_m` in the body's axes: where its centre
    /// of mass is now.
    pub fn recenter(&mut self, moved_m: Vector3<f64>) {
        let lever_m = self.floor_from_chassis.rotation * moved_m;
        self.floor_from_chassis.translation.vector += lever_m;
        self.velocity_m_s += self.angular_rad_s.cross(&lever_m);
        for chassis_from_hub in Arc::make_mut(&mut self.chassis_from_hub) {
            chassis_from_hub.translation.vector -= moved_m;
        }
        self.place_hubs();
    }

    /// The same state as rapier counts it, from its own origin.
    pub fn seen_from(&self, anchor: &Anchor) -> Self {
        let mut seen = self.clone();
        seen.place(anchor.rapier_from_floor() * self.floor_from_chassis);
        seen
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
