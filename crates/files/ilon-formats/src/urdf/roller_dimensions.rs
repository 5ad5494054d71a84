//! A roller's size and position from its joint and its collision geometry.
//!
//! Symbols as in [`ilon_robot::barrel_profile`]: a the distance between hub axis and roller axis,
//! k = sin delta = cos gamma, t a position along the roller's axis from the point closest to the
//! hub axis.

use nalgebra::{Point3, Unit, Vector3};

use crate::model::{Profile, ProfilePart as Part};

/// The common perpendicular of hub axis and roller axis, in the hub frame.
pub(super) struct Skew {
    /// The point of the roller's axis closest to the hub axis.
    pub(super) foot: Point3<f64>,
    /// Distance a between the axes, in metres.
    pub(super) ring_radius_m: f64,
    /// The paper's gamma of this roller, signed, in [-pi/2, pi/2].
    pub(super) gamma_rad: f64,
}

/// Returns the position of a roller's axis relative to the hub axis, z of the hub frame. `None` if
/// they are parallel or intersect.
pub(super) fn skew(through: &Point3<f64>, axis: &Unit<Vector3<f64>>) -> Option<Skew> {
    let across_squared = axis.xy().norm_squared();
    if across_squared < 1e-12 {
        return None;
    }
    // Seen along the hub axis the roller's axis is a line; its point closest to the origin is the
    // foot.
    let t = -through.xy().coords.dot(&axis.xy()) / across_squared;
    let foot = through + axis.into_inner() * t;
    let ring_radius_m = foot.xy().coords.norm();
    if ring_radius_m < 1e-9 {
        return None;
    }
    // Turned with the wheel until it points down, the foot is on x of the hub frame (down) and the
    // tangent z x x = y is -u. With u_gamma = n cos gamma + (k x n) sin gamma, the roller's axis k
    // x u_gamma is cos gamma y - sin gamma z; its sense is chosen so that its y component is
    // positive.
    let outward = Vector3::new(foot.x, foot.y, 0.0) / ring_radius_m;
    let tangent = Vector3::z().cross(&outward);
    let along_tangent = axis.dot(&tangent);
    let sense = 1f64.copysign(along_tangent);
    let gamma_rad = libm::atan2(-sense * axis.z, sense * along_tangent);
    Some(Skew {
        foot,
        ring_radius_m,
        gamma_rad,
    })
}

/// Spheres of a roller whose reaches differ from their mean by less than this share of it are meant
/// to form one circle.
const ONE_CIRCLE: f64 = 0.005;

/// A roller's outline by its collision geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DrawnOutline {
    /// The wheel's radius rho implied by this roller, in metres.
    pub(super) wheel_radius_m: f64,
    /// Half of the length L between the outermost spheres of its barrel, in metres; `None` for a
    /// single sphere, which does not show it.
    pub(super) half_length_m: Option<f64>,
    /// Position of its middle along the axis, from the foot, in metres.
    pub(super) middle_m: f64,
    /// The largest deviation of the geometry from the fitted circle of the wheel, in metres.
    pub(super) error_m: f64,
}

/// Fits the barrel of a roller to its profile. `half_pitch_rad` is half of the wheel's turn from
/// roller to roller.
///
/// - A stack of spheres that all reach the same circle is a discretised barrel: each reaches
///   sqrt(a^2 + t^2 k^2) + r from the hub axis, and rho is their mean; L spans their centres.
/// - A single sphere, cylinder, capsule or box gives the roller's thickness: rho = a + r.
/// - Anything else, mainly meshes and ellipsoids, is rolled over its pitch: rho is the mean of its
///   reach, which is the wheel's rolling radius.
pub(super) fn outline(skew: &Skew, profile: &Profile, half_pitch_rad: f64) -> DrawnOutline {
    let a = skew.ring_radius_m;
    let k = libm::cos(skew.gamma_rad);
    let (first, last) = profile.span_m();
    let half_extent_m = 0.5 * (last - first);
    let balls = profile.parts().iter().all(|p| p.ring_m == 0.0);
    let alike = |p: &Part| {
        let q = &profile.parts()[0];
        (p.ring_m - q.ring_m).abs() + (p.ball_m - q.ball_m).abs() < 1e-6 * a
    };
    let of_rho = |wheel_radius_m, half_length_m, error_m| DrawnOutline {
        wheel_radius_m,
        half_length_m,
        middle_m: 0.5 * (first + last),
        error_m,
    };
    let reaches_m = || {
        let parts = profile.parts().iter();
        parts.map(|p| libm::hypot(a, p.t_m * k) + p.ball_m)
    };
    let mean_m = reaches_m().sum::<f64>() / profile.parts().len() as f64;
    let error_m = reaches_m().map(|r| (r - mean_m).abs()).fold(0.0, f64::max);
    match *profile.parts() {
        [ref ball] if balls => of_rho(a + ball.ball_m, None, 0.0),
        [ref end, _] if profile.parts().iter().all(alike) => {
            let rho = a + end.ring_m + end.ball_m;
            let half_length_m = if balls {
                half_extent_m
            } else {
                barrel_half_length_m(a, k, rho, half_extent_m)
            };
            of_rho(rho, Some(half_length_m), 0.0)
        }
        _ if balls && error_m < ONE_CIRCLE * mean_m => of_rho(mean_m, Some(half_extent_m), error_m),
        _ => {
            const SAMPLES: usize = 200;
            let middle_m = 0.5 * (first + last);
            let reach = |i: usize| {
                let phi = half_pitch_rad * (2.0 * i as f64 / SAMPLES as f64 - 1.0);
                let w = k * libm::sin(phi);
                a * libm::cos(phi) + profile.support_m(w) - middle_m * w
            };
            let rho = (0..=SAMPLES).map(reach).sum::<f64>() / (SAMPLES + 1) as f64;
            let error_m = (0..=SAMPLES)
                .map(|i| (reach(i) - rho).abs())
                .fold(0.0, f64::max);
            let half_length_m = match balls {
                true => half_extent_m,
                false => barrel_half_length_m(a, k, rho, half_extent_m),
            };
            of_rho(rho, Some(half_length_m), error_m)
        }
    }
}

/// Returns half of L for a roller that is cut flat `half_extent_m` from its middle: the barrel's
/// outermost sphere is the one that touches the ground at the cut.
///
/// At wheel angle phi the sphere at t = a tan(phi) / k touches, at t + s k sin(phi) along the axis;
/// this grows with phi, so bisection finds the cut.
pub(super) fn barrel_half_length_m(a: f64, k: f64, rho: f64, half_extent_m: f64) -> f64 {
    let touching_place_m =
        |phi: f64| a * libm::tan(phi) / k + (rho - a / libm::cos(phi)) * k * libm::sin(phi);
    // The barrel tapers to nothing where a / cos(phi) = rho.
    let (mut low, mut high) = (0.0, libm::acos((a / rho).clamp(-1.0, 1.0)));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if touching_place_m(middle) < half_extent_m {
            low = middle;
        } else {
            high = middle;
        }
    }
    a * libm::tan(low) / k
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 31 balls within an ellipsoid with the half axes 12 mm across and 30 mm along, on a ring
    /// of 38 mm at 45 deg, nine of them on a wheel: they form no circle, and the wheel rolls on the
    /// mean of a cos(phi) + sqrt(12^2 (1 - w^2) + 30^2 w^2), w = sin(phi) / sqrt(2), over 40 deg.
    #[test]
    fn an_ellipsoid_is_rolled_over_its_pitch() {
        let (a, along, across) = (38.0, 30.0_f64, 12.0_f64);
        let ball = |i: i32| {
            let t = (along - across * across / along) * f64::from(i) / 15.0;
            let of = 1.0 - t * t / (along * along - across * across);
            Part {
                t_m: t,
                ring_m: 0.0,
                ball_m: across * of.sqrt(),
            }
        };
        let profile = Profile::new((-15..=15).map(ball).collect()).unwrap();
        let skew = Skew {
            foot: Point3::new(a, 0.0, 0.0),
            ring_radius_m: a,
            gamma_rad: std::f64::consts::FRAC_PI_4,
        };
        let half_rad = 20f64.to_radians();
        let reach = |i: i32| {
            let phi = half_rad * f64::from(i) / 1000.0;
            let w = phi.sin() * 0.5_f64.sqrt();
            a * phi.cos() + (across * across * (1.0 - w * w) + along * along * w * w).sqrt()
        };
        let rolling = (-1000..=1000).map(reach).sum::<f64>() / 2001.0;
        let found = outline(&skew, &profile, half_rad);
        // Between two balls, which are s = 1.7 mm apart, the envelope is reached but for s^2 a / (8
        // (30^2 - 12^2)), 6 um at most.
        assert!(
            (found.wheel_radius_m - rolling).abs() < 0.006,
            "{found:?} {rolling}"
        );
        assert!((found.wheel_radius_m - 50.0).abs() < 0.5, "{found:?}");
    }
}
