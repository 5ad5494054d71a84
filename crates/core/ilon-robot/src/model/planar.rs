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

    /// Returns the pose after a displacement in the body frame, a constant twist times its duration
    /// (metres and radians): the end of the arc of the body's origin. The heading is wrapped.
    pub fn moved(&self, displacement_in_body: Twist) -> Self {
        let turn_rad = displacement_in_body.omega_rad_s;
        let chord = displacement_in_body
            .scaled(chord_of_arc(turn_rad))
            .rotated(self.heading_rad + 0.5 * turn_rad);
        Self {
            x_m: self.x_m + chord.vx_m_s,
            y_m: self.y_m + chord.vy_m_s,
            heading_rad: wrap_angle(self.heading_rad + turn_rad),
        }
    }

    /// Returns the displacement in the body frame from this pose to another, in metres and radians,
    /// by the shorter way round: the inverse of [`Pose::moved`].
    pub fn displacement_to(&self, other: &Self) -> Twist {
        let turn_rad = wrap_angle(other.heading_rad - self.heading_rad);
        let along = Twist::new(other.x_m - self.x_m, other.y_m - self.y_m, 0.0)
            .rotated(-self.heading_rad - 0.5 * turn_rad)
            .scaled(1.0 / chord_of_arc(turn_rad));
        Twist {
            omega_rad_s: turn_rad,
            ..along
        }
    }
}

/// Returns the chord of an arc over its length: sin(t/2)/(t/2) for a turn by t, which lies within
/// [-pi, pi] or slightly beyond.
fn chord_of_arc(turn_rad: f64) -> f64 {
    let half_rad = 0.5 * turn_rad;
    // Below, the next term of the series, half^4 / 120, is less than a rounding of 1.
    if half_rad.abs() < 1e-4 {
        1.0 - half_rad * half_rad / 6.0
    } else {
        libm::sin(half_rad) / half_rad
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
    pub const fn new(vx_m_s: f64, vy_m_s: f64, omega_rad_s: f64) -> Self {
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

    /// Returns the same motion with its linear part turned counter-clockwise by `angle_rad`: the
    /// heading takes a twist from the body frame to the world frame, minus the heading takes it
    /// back.
    pub fn rotated(&self, angle_rad: f64) -> Self {
        let (s, c) = libm::sincos(angle_rad);
        Self {
            vx_m_s: c * self.vx_m_s - s * self.vy_m_s,
            vy_m_s: s * self.vx_m_s + c * self.vy_m_s,
            omega_rad_s: self.omega_rad_s,
        }
    }

    /// The twist of a point of the same body that lies `offset_m` from this one, in the frame of the
    /// twist: eq. (2) of Indiveri 2009.
    pub fn at(&self, offset_m: Vector2<f64>) -> Self {
        let omega = self.omega_rad_s;
        Self {
            vx_m_s: self.vx_m_s - omega * offset_m.y,
            vy_m_s: self.vy_m_s + omega * offset_m.x,
            omega_rad_s: omega,
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

/// Returns the same angle in [-pi, pi), in radians.
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

    #[test]
    fn a_constant_twist_runs_along_an_arc() {
        // Half a circle of radius 2 to the left, at once and in a thousand parts.
        let half = Twist::new(2.0 * PI, 0.0, PI);
        let there = Pose::default().moved(half);
        assert!(there.x_m.abs() < 1e-15 && (there.y_m - 4.0).abs() < 1e-15);
        assert_eq!(there.heading_rad, -PI);
        let parts = (0..1000).fold(Pose::default(), |pose, _| pose.moved(half.scaled(1e-3)));
        // A thousand roundings of numbers below 4.
        assert!((parts.position_m() - there.position_m()).norm() < 1e-12);
    }

    #[test]
    fn a_displacement_between_poses_takes_the_one_to_the_other_also_across_the_cut() {
        let pose = |x_m, y_m, heading_rad| Pose {
            x_m,
            y_m,
            heading_rad,
        };
        for (from, to) in [
            (pose(1.0, -2.0, 3.0), pose(0.5, 0.7, -3.0)),
            (pose(0.0, 0.0, 0.1), pose(0.3, 0.0, 0.1)),
        ] {
            let there = from.moved(from.displacement_to(&to));
            // Rotations by an angle and back: some roundings of numbers of a few units.
            let off = (there.position_m() - to.position_m()).norm();
            assert!(off < 1e-14 && wrap_angle(there.heading_rad - to.heading_rad).abs() < 1e-14);
        }
    }
}
