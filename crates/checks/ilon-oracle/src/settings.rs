//! Settings of a simulation, plates, and contact results.

use nalgebra::{Vector2, Vector3};

use crate::ContactLaw;

/// Settings of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Length of a step, in seconds.
    pub step_s: f64,
    /// The contact of rollers with the floor.
    pub contact: ContactLaw,
    /// Gravity in the world frame, in m/s^2. The floor is z = 0; on a slope gravity is tilted.
    pub gravity_m_s2: Vector3<f64>,
}

/// Standard gravity as the project uses it, on a level floor.
pub const LEVEL_GRAVITY_M_S2: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// A solid plate on the floor, its sides along the world's x and y: a kerb, or a bar across the
/// way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    /// Its smallest x and y, in metres.
    pub from_m: Vector2<f64>,
    /// Its largest x and y, in metres.
    pub to_m: Vector2<f64>,
    /// Height of its top above the floor, in metres; lower than the rollers' axes.
    pub height_m: f64,
}

/// A roller in contact with the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Its wheel, in the robot's order.
    pub wheel: usize,
    /// The roller, counted over all wheels.
    pub roller: usize,
    /// Its deepest point in the ground, in the body frame, in metres.
    pub point_in_body_m: Vector3<f64>,
    /// Out of the ground, in the world frame: up, except at the edges and sides of plates.
    pub normal_in_world: Vector3<f64>,
    /// Normal force, in N.
    pub normal_n: f64,
    /// Friction on the roller, in N, along the world's x and y after the smallest rotation from the
    /// floor's normal to the ground's.
    pub friction_n: Vector2<f64>,
    /// Velocity of the roller's material at the point, along the same two, in m/s.
    pub velocity_m_s: Vector2<f64>,
    /// Whether it slides, that is, friction is at its limit.
    pub slides: bool,
}
