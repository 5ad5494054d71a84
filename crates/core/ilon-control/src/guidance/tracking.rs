//! Tracking a path with a robot whose tyres hold it sideways.
//!
//! Such a robot cannot correct an error to its side at once: it has to turn, drive and turn back.
//! The law is that of Y. Kanayama, Y. Kimura, F. Miyazaki and T. Noguchi, "A stable tracking
//! control method for an autonomous mobile robot", IEEE International Conference on Robotics and
//! Automation 1990, eq. (8): with the error (e_x, e_y, e_theta) of the tracked point in the robot's
//! frame, ahead and to the left,
//!
//!   v     = v_r cos(e_theta) + K_x e_x,
//!   omega = omega_r + v_r (K_y e_y + K_theta sin(e_theta)).
//!
//! The gains across the path are lengths: K_y = 1 / L^2 and K_theta = 2 / L make the error to the
//! side fall along the path without overshoot, by e in the way L (their section 4, critical
//! damping).
//!
//! Theirs drives ahead. Backwards, v_r < 0, K_theta takes |v_r|: then V = (e_x^2 + e_y^2) / 2 + (1 -
//! cos(e_theta)) / K_y falls as there, by V' = -K_x e_x^2 - |v_r| K_theta / K_y sin(e_theta)^2.

use ilon_robot::{Pose, Twist, wrap_angle};
use nalgebra::Vector2;

use crate::{ControlError, Kinematics};

/// L over the distance of the furthest wheel from the tracked point (chosen).
const LENGTHS: f64 = 1.0;

/// How a path goes at a moment: where, which way, how fast, and how fast it turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// In the world frame, in metres.
    pub position_m: Vector2<f64>,
    /// Direction of the way, or against it where it is driven backwards, counter-clockwise from the
    /// world's x axis, in radians.
    pub direction_rad: f64,
    /// Speed along that, in m/s; negative backwards.
    pub speed_m_s: f64,
    /// Turning of that direction, in rad/s.
    pub turning_rad_s: f64,
}

/// The tracking law of a robot with one unsteered direction of axles.
#[derive(Clone, Debug)]
pub struct PathTracking {
    /// The middle of its unsteered tyres, in the body frame, in metres.
    point_m: Vector2<f64>,
    /// The direction in which they roll, in the body frame, in radians.
    ahead_rad: f64,
    /// K_x, in 1/s.
    gain_per_s: f64,
    /// L, in metres.
    length_m: f64,
}

impl PathTracking {
    /// The law for a robot; `gain_per_s` is K_x. `None` for a robot that moves in all directions,
    /// and for one whose unsteered axles have several directions, which only turns about a point.
    ///
    /// # Errors
    /// [`ControlError::NotPositive`] for a gain that is not positive.
    pub fn new(kinematics: &Kinematics, gain_per_s: f64) -> Result<Option<Self>, ControlError> {
        let gain_per_s = crate::error::positive("the gain along the path", gain_per_s)?;
        let [row] = kinematics.excluded_rows() else {
            return Ok(None);
        };
        // n . v + m omega = 0 in the point that is m ahead along u = n x k.
        let u = Vector2::new(row.y, -row.x);
        let point_m = kinematics.reference_point_m() + row.z * u;
        let far = |w: &ilon_robot::Wheel| (w.position_m().xy() - point_m).norm();
        let size_m = kinematics.wheels().iter().map(far).fold(0.0, f64::max);
        // Hub axes may point to either side: ahead is nearer to the body's x axis.
        let sign = if u.x < -1e-9 || (u.x.abs() <= 1e-9 && u.y < 0.0) {
            -1.0
        } else {
            1.0
        };
        Ok(Some(Self {
            point_m,
            ahead_rad: libm::atan2(sign * u.y, sign * u.x),
            gain_per_s,
            length_m: LENGTHS * size_m,
        }))
    }

    /// The point that follows the path, in the body frame, in metres: the middle of the unsteered
    /// tyres.
    pub fn point_m(&self) -> Vector2<f64> {
        self.point_m
    }

    /// Returns the error (e_x, e_y, e_theta) of that point in the robot's frame, ahead and to the
    /// left in metres, and in radians, for the body's pose and the path now.
    pub fn error(&self, body: &Pose, path: &PathPoint) -> [f64; 3] {
        let (sin, cos) = libm::sincos(body.heading_rad);
        let p = self.point_m;
        let at_m = body.position_m() + Vector2::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y);
        let theta_rad = body.heading_rad + self.ahead_rad;
        let off_m = path.position_m - at_m;
        let (sin, cos) = libm::sincos(theta_rad);
        let e_x = cos * off_m.x + sin * off_m.y;
        let e_y = cos * off_m.y - sin * off_m.x;
        [e_x, e_y, wrap_angle(path.direction_rad - theta_rad)]
    }

    /// Returns the twist of that point in the body frame, for the body's pose and the path now.
    pub fn twist(&self, body: &Pose, path: &PathPoint) -> Twist {
        let [e_x, e_y, e_theta] = self.error(body, path);
        let [k_y, k_theta] = [self.length_m.powi(-2), 2.0 / self.length_m];
        let v = path.speed_m_s * libm::cos(e_theta) + self.gain_per_s * e_x;
        let back = k_theta.copysign(path.speed_m_s) * libm::sin(e_theta);
        let omega = path.turning_rad_s + path.speed_m_s * (k_y * e_y + back);
        let (sin, cos) = libm::sincos(self.ahead_rad);
        Twist::new(v * cos, v * sin, omega)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::robots::mecanum4;
    use crate::tests::tyres::on_tyres;

    fn law(places_m: &[[f64; 2]]) -> PathTracking {
        let kinematics = Kinematics::new(&on_tyres(places_m)).expect("it drives");
        PathTracking::new(&kinematics, 1.0)
            .expect("a gain")
            .expect("on tyres")
    }

    #[test]
    fn the_middle_of_the_unsteered_axle_follows() {
        let law = law(&[[-0.2, 0.2], [-0.2, -0.2]]);
        assert!((law.point_m() - Vector2::new(-0.2, 0.0)).norm() < 1e-12);
        assert!(law.ahead_rad.abs() < 1e-12);
        let all_ways = Kinematics::new(&mecanum4()).expect("it drives");
        assert!(PathTracking::new(&all_ways, 1.0).expect("a gain").is_none());
        assert!(PathTracking::new(&all_ways, 0.0).is_err());
    }

    /// A robot that has no error drives as the path goes.
    #[test]
    fn on_the_path_it_drives_as_the_path_goes() {
        let path = PathPoint {
            position_m: Vector2::new(1.0, 2.0),
            direction_rad: 0.7,
            speed_m_s: 0.4,
            turning_rad_s: -0.3,
        };
        let body = Pose {
            x_m: 1.0 + 0.2 * f64::cos(0.7),
            y_m: 2.0 + 0.2 * f64::sin(0.7),
            heading_rad: 0.7,
        };
        let twist = law(&[[-0.2, 0.2], [-0.2, -0.2]]).twist(&body, &path);
        let off = twist - Twist::new(0.4, 0.0, -0.3);
        assert!(
            off.linear_m_s().norm() + off.omega_rad_s.abs() < 1e-12,
            "{twist:?}"
        );
    }

    /// Small errors beside a straight path fall as (1 + x / L) e^(-x / L) does along it: both roots
    /// of s^2 + (2 / L) s + 1 / L^2 are -1 / L; backwards likewise.
    #[test]
    fn an_error_to_the_side_falls_along_the_path_without_overshoot() {
        [0.5, -0.5].into_iter().for_each(an_error_falls);
    }

    fn an_error_falls(speed_m_s: f64) {
        let law = law(&[[0.0, 0.2], [0.0, -0.2]]);
        let dt_s = 1e-4;
        let mut pose = Pose {
            x_m: 0.0,
            y_m: 1e-3,
            heading_rad: 0.0,
        };
        for step in 0..80_000 {
            let x_m = speed_m_s * dt_s * f64::from(step);
            let path = PathPoint {
                position_m: Vector2::new(x_m, 0.0),
                direction_rad: 0.0,
                speed_m_s,
                turning_rad_s: 0.0,
            };
            let lengths = x_m.abs() / law.length_m;
            let expected_m = 1e-3 * (1.0 + lengths) * f64::exp(-lengths);
            // Of the first order in the step, and of the third in the error.
            assert!((pose.y_m - expected_m).abs() < 2e-6, "{x_m}: {}", pose.y_m);
            pose = pose.moved(law.twist(&pose, &path).scaled(dt_s));
        }
    }

    /// Axles of two directions leave only turns about the point where they meet.
    #[test]
    fn axles_of_two_directions_track_nothing() {
        let mut crossed = on_tyres(&[[0.2, 0.0], [-0.2, 0.0], [0.0, 0.2]]);
        crossed.wheels[2].body_from_hub.rotation = nalgebra::UnitQuaternion::from_axis_angle(
            &nalgebra::Vector3::z_axis(),
            std::f64::consts::FRAC_PI_2,
        ) * crossed.wheels[2].body_from_hub.rotation;
        let kinematics = Kinematics::new(&crossed).expect("it turns");
        assert!(
            PathTracking::new(&kinematics, 1.0)
                .expect("a gain")
                .is_none()
        );
    }
}
