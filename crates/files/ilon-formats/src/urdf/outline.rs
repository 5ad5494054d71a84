//! The outline of a wheel's collision geometry, on which simulators without barrels roll.
//!
//! The wheel rolls on the convex hull of its rollers: the hub's height is the hull's support h(phi)
//! in the direction phi that points down. Between two rollers the hull is a straight bridge, over
//! which the wheel tips from one to the next; only there the outline leaves the rollers.

use std::f64::consts::TAU;

use nalgebra::{Unit, Vector3};
use serde::Serialize;

use crate::model::{Profile, Remark};
use crate::options::RollerForms;

/// Directions in which the hull is sampled: a tenth of a degree apart.
const SAMPLES: usize = 3600;
/// A wheel's outline by its collision geometry on flat ground, compared with the fitted barrels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WheelOutline {
    /// The wheel's joint.
    pub wheel: String,
    /// The radius rho of the fitted wheel, in metres.
    pub fitted_radius_m: f64,
    /// The mean height of the hub over the ground in a turn, in metres: 2 pi times it is the
    /// perimeter of the convex hull, the distance of a turn.
    pub rolling_radius_m: f64,
    /// The greatest height of the hub over the ground, in metres.
    pub peak_radius_m: f64,
    /// The largest deviation of the hub's height from the fitted radius, in metres.
    pub outline_error_m: f64,
    /// Peak-to-peak motion of the hub in a turn, in metres.
    pub ripple_m: f64,
}

impl WheelOutline {
    /// Adds a remark if the geometry rolls differently from the fitted wheel by more than one
    /// percent.
    pub(super) fn remark_rolling(&self, form: RollerForms, remarks: &mut Vec<Remark>) {
        let off_m = (self.rolling_radius_m - self.fitted_radius_m).abs();
        if off_m.max(self.ripple_m) > 0.01 * self.fitted_radius_m {
            let taken = match form {
                RollerForms::Barrel => "it is taken as a wheel with barrels for rollers of",
                RollerForms::AsModelled => "it rolls so, and the control takes it for a wheel of",
            };
            remarks.push(Remark::new(
                format!("wheel `{}`", self.wheel),
                format!(
                    "its collision geometry rolls on a radius of {:.2} mm and rises and falls by {:.2} mm a turn; {taken} \
                     {:.2} mm",
                    1e3 * self.rolling_radius_m,
                    1e3 * self.ripple_m,
                    1e3 * self.fitted_radius_m
                ),
            ));
        }
    }
}

/// A roller of a wheel, in the hub frame.
pub(super) struct Modelled {
    pub(super) foot_in_hub_m: Vector3<f64>,
    pub(super) axis_in_hub: Unit<Vector3<f64>>,
    pub(super) profile: Profile,
}

impl Modelled {
    /// Returns the reach from the hub's centre in a unit direction, in metres.
    fn reach_m(&self, outward: &Vector3<f64>) -> f64 {
        let w = self.axis_in_hub.dot(outward);
        self.foot_in_hub_m.dot(outward) + self.profile.support_m(w)
    }
}

/// Returns a unit direction across the hub axis.
fn outward(angle_rad: f64) -> Vector3<f64> {
    let (s, c) = libm::sincos(angle_rad);
    Vector3::new(c, s, 0.0)
}

/// Returns the outline of a wheel from its rollers.
pub(super) fn outline(wheel: &str, fitted_radius_m: f64, rollers: &[Modelled]) -> WheelOutline {
    let step_rad = TAU / SAMPLES as f64;
    // In each direction the ground touches the furthest roller.
    let height_m = |i: usize| {
        let down = outward(step_rad * i as f64);
        let reaches_m = rollers.iter().map(|roller| roller.reach_m(&down));
        reaches_m.fold(f64::NEG_INFINITY, f64::max)
    };
    let heights_m: Vec<f64> = (0..SAMPLES).map(height_m).collect();
    let peak_radius_m = heights_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least_m = heights_m.iter().copied().fold(f64::INFINITY, f64::min);
    WheelOutline {
        wheel: wheel.to_owned(),
        fitted_radius_m,
        rolling_radius_m: heights_m.iter().sum::<f64>() / SAMPLES as f64,
        peak_radius_m,
        outline_error_m: heights_m
            .iter()
            .map(|height_m| (height_m - fitted_radius_m).abs())
            .fold(0.0, f64::max),
        ripple_m: peak_radius_m - least_m,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::model::ProfilePart;

    /// `count` spheres of a radius on a ring.
    fn spheres(count: usize, ring_m: f64, radius_m: f64) -> Vec<Modelled> {
        let sphere = |i: usize| Modelled {
            foot_in_hub_m: outward(TAU * i as f64 / count as f64) * ring_m,
            axis_in_hub: Vector3::z_axis(),
            profile: Profile::new(vec![ProfilePart {
                t_m: 0.0,
                ring_m: 0.0,
                ball_m: radius_m,
            }])
            .unwrap(),
        };
        (0..count).map(sphere).collect()
    }

    #[test]
    fn six_spheres_roll_on_their_hull() {
        let (n, a, r) = (6, 0.04, 0.01);
        let seen = outline("w", a + r, &spheres(n, a, r));
        // The hull of n circles on a ring: n straight bridges of 2 a sin(pi/n) and n arcs that make
        // one circle of r.
        let perimeter = n as f64 * 2.0 * a * (PI / n as f64).sin() + TAU * r;
        // The sum over 3600 samples of a smooth function with n corners is accurate to the square
        // of a step.
        assert!((seen.rolling_radius_m - perimeter / TAU).abs() < 1e-8);
        assert!((seen.peak_radius_m - (a + r)).abs() < 1e-12);
        // Between two spheres the hub is at a cos(pi/n) + r.
        let dip = a * (1.0 - (PI / n as f64).cos());
        assert!((seen.ripple_m - dip).abs() < 1e-9, "{}", seen.ripple_m);
        assert!((seen.outline_error_m - dip).abs() < 1e-9);
    }
}
