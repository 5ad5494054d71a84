//! A wheel on a tyre that is steered, and has turned to a twist.
//!
//! It lies at r = t u + d n from its steering axis, which moves with p. Where the module stands
//! still on the robot, the wheel rolls along u if n . (p + omega k x r) = n . p + omega t = 0, at
//! u . p - omega d: u lies off p by the angle whose sine is -omega t / |p|, or the other way round.
//! A wheel beside its axis (t = 0) rolls at |p| less or more omega d: the hub comes round with its
//! module, nearer to the middle of the turn or farther from it.

use ilon_robot::Wheel;
use nalgebra::{Vector2, Vector3};

/// A steered tyre as it stands, about a reference point.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Module {
    /// The steering axis, from the reference point, in metres.
    axis_m: Vector2<f64>,
    /// From there to the hub, along the way that the wheel rolls and to the left of it, in metres.
    along_m: f64,
    across_m: f64,
    /// The way that it rolls.
    u: Vector2<f64>,
}

impl Module {
    /// A wheel and its steering axis, which stand at places in the body frame, in metres.
    pub(crate) fn of(wheel: &Wheel, axis_m: Vector2<f64>, reference_point_m: Vector2<f64>) -> Self {
        let (n, r) = (wheel.axis(), wheel.position_m().xy() - axis_m);
        let u = Vector2::new(n.y, -n.x);
        Self {
            axis_m: axis_m - reference_point_m,
            along_m: u.dot(&r),
            across_m: n.dot(&r),
            u,
        }
    }

    /// The velocity p of the steering axis, in m/s, as rows of (v_x, v_y, omega).
    pub(crate) fn rows(&self) -> [Vector3<f64>; 2] {
        let b = self.axis_m;
        [Vector3::new(1.0, 0.0, -b.y), Vector3::new(0.0, 1.0, b.x)]
    }

    fn axis_velocity_m_s(&self, twist: &Vector3<f64>) -> Vector2<f64> {
        let [x, y] = self.rows().map(|row| row.dot(twist));
        Vector2::new(x, y)
    }

    /// The way that the wheel rolls in a twist, in radians from x, and its speed along it in m/s:
    /// nearer to how the module stands, and the other way round. `None` if it rolls at no angle,
    /// because it trails by more than the way to the middle of the turn.
    pub(crate) fn rolling(&self, twist: &Vector3<f64>) -> Option<[(f64, f64); 2]> {
        let p = self.axis_velocity_m_s(twist);
        let aside_m_s = -twist.z * self.along_m;
        let square = p.norm_squared() - aside_m_s * aside_m_s;
        let nearer = (self.u.dot(&p) - twist.z * self.across_m).signum();
        let way = |sign: f64| {
            let ahead_m_s = sign * square.sqrt();
            let way_rad = libm::atan2(p.y, p.x) - libm::atan2(aside_m_s, ahead_m_s);
            (way_rad, ahead_m_s - twist.z * self.across_m)
        };
        (square >= 0.0).then(|| [way(nearer), way(-nearer)])
    }

    /// The speed in m/s at which the wheel rolls in a twist; if it rolls at no angle the amount of
    /// its hub's velocity as the module stands.
    pub(crate) fn speed_m_s(&self, twist: &Vector3<f64>) -> f64 {
        if let Some([(_, speed_m_s), _]) = self.rolling(twist) {
            return speed_m_s.abs();
        }
        let n = Vector2::new(-self.u.y, self.u.x);
        let turning = self.along_m * n - self.across_m * self.u;
        (self.axis_velocity_m_s(twist) + twist.z * turning).norm()
    }

    /// The speed in m/s that its steering axis can have at a yaw rate whichever way round the module
    /// stands, if the wheel rolls at no more than a speed; 0 if it cannot turn so fast.
    pub(crate) fn axis_top_m_s(&self, top_m_s: f64, omega_rad_s: f64) -> f64 {
        let left_m_s = top_m_s - (omega_rad_s * self.across_m).abs();
        match left_m_s > 0.0 {
            true => libm::hypot(left_m_s, omega_rad_s * self.along_m),
            false => 0.0,
        }
    }
}
