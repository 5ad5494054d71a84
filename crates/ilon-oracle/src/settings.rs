//! How to simulate, and what is read of a contact.

use nalgebra::{Vector2, Vector3};

use crate::ContactLaw;

/// How to simulate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Length of a step, in seconds.
    pub step_s: f64,
    /// The contact of rollers with the floor.
    pub contact: ContactLaw,
    /// Gravity in the world frame, in m/s^2. The floor is z = 0; on a slope gravity leans.
    pub gravity_m_s2: Vector3<f64>,
}

/// Standard gravity as the project uses it, on a level floor.
pub const LEVEL_GRAVITY_M_S2: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// A roller that touches the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Its wheel, in the robot's order.
    pub wheel: usize,
    /// The roller, counted over all wheels.
    pub roller: usize,
    /// Its lowest point in the body frame, in metres.
    pub point_in_body_m: Vector3<f64>,
    /// Normal force, in N.
    pub normal_n: f64,
    /// Friction on the roller, along the world's x and y, in N.
    pub friction_n: Vector2<f64>,
    /// Velocity of the roller's material at the point, along the world's x and y, in m/s.
    pub velocity_m_s: Vector2<f64>,
    /// Whether it slides: whether friction is at its limit.
    pub slides: bool,
}
