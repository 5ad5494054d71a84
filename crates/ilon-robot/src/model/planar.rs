//! Motion in the ground plane: poses, twists and the wrapping of angles.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// Position and heading of the body frame in the world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// x of the body's origin in the world frame, in metres.
    pub x_m: f64,
    /// y of the body's origin in the world frame, in metres.
    pub y_m: f64,
    /// Heading: the angle from the world's x axis to the body's, in radians, counter-clockwise.
    pub heading_rad: f64,
}

impl Pose {
    /// The position in the world frame, in metres.
    pub fn position_m(&self) -> Vector2<f64> {
        Vector2::new(self.x_m, self.y_m)
    }

    /// The pose after a displacement in the body frame (a twist times a time: metres and radians), which is taken with
    /// the heading at its middle; exact to second order in the turn. The heading is wrapped.
    pub fn moved(&self, displacement_in_body: Twist) -> Self {
        let turn_rad = displacement_in_body.omega_rad_s;
        let in_world = displacement_in_body.rotated(self.heading_rad + 0.5 * turn_rad);
        Self {
            x_m: self.x_m + in_world.vx_m_s,
            y_m: self.y_m + in_world.vy_m_s,
            heading_rad: wrap_angle(self.heading_rad + turn_rad),
        }
    }
}

/// Velocity of the robot in the ground plane: the paper's (v_c, omega).
///
/// The frame of the linear part is named where a twist is stored; the rotation is about +z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// Velocity along x, in m/s.
    pub vx_m_s: f64,
    /// Velocity along y, in m/s.
    pub vy_m_s: f64,
    /// Yaw rate, in rad/s, counter-clockwise.
    pub omega_rad_s: f64,
}

impl Twist {
    /// A twist from its three components: m/s, m/s, rad/s.
    pub fn new(vx_m_s: f64, vy_m_s: f64, omega_rad_s: f64) -> Self {
        Self {
            vx_m_s,
            vy_m_s,
            omega_rad_s,
        }
    }

    /// The linear part, in m/s.
    pub fn linear_m_s(&self) -> Vector2<f64> {
        Vector2::new(self.vx_m_s, self.vy_m_s)
    }

    /// The same motion with its linear part turned counter-clockwise by `angle_rad`: with the heading this takes a
    /// twist in the body frame to the world frame, with minus the heading back.
    pub fn rotated(&self, angle_rad: f64) -> Self {
        let (s, c) = libm::sincos(angle_rad);
        Self {
            vx_m_s: c * self.vx_m_s - s * self.vy_m_s,
            vy_m_s: s * self.vx_m_s + c * self.vy_m_s,
            omega_rad_s: self.omega_rad_s,
        }
    }

    /// The twist times a scalar.
    pub fn scaled(&self, factor: f64) -> Self {
        Self::new(
            factor * self.vx_m_s,
            factor * self.vy_m_s,
            factor * self.omega_rad_s,
        )
    }
}

impl std::ops::Sub for Twist {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::new(
            self.vx_m_s - other.vx_m_s,
            self.vy_m_s - other.vy_m_s,
            self.omega_rad_s - other.omega_rad_s,
        )
    }
}

impl std::ops::Add for Twist {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::new(
            self.vx_m_s + other.vx_m_s,
            self.vy_m_s + other.vy_m_s,
            self.omega_rad_s + other.omega_rad_s,
        )
    }
}

/// The same angle in [-pi, pi), in radians.
pub fn wrap_angle(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrapping_keeps_the_angle_modulo_a_turn_and_lands_in_the_half_open_interval() {
        for k in -20..=20 {
            let angle_rad = 0.37 * f64::from(k);
            let wrapped_rad = wrap_angle(angle_rad);
            assert!((-PI..PI).contains(&wrapped_rad));
            // A sum of at most eight roundings of numbers below 8: 1e-14 covers them.
            let turns = (angle_rad - wrapped_rad) / TAU;
            assert!((turns - turns.round()).abs() < 1e-14);
        }
        assert_eq!(wrap_angle(PI), -PI);
    }

    #[test]
    fn rotating_a_twist_by_a_quarter_turn_takes_forward_to_left() {
        let left = Twist::new(1.0, 0.0, 0.5).rotated(std::f64::consts::FRAC_PI_2);
        assert!((left.vx_m_s).abs() < 1e-15 && (left.vy_m_s - 1.0).abs() < 1e-15);
        assert_eq!(left.omega_rad_s, 0.5);
    }
}
