//! The wheel as the file models it: the outline of its collision geometry, as simulators that know no barrels roll on it.

use std::f64::consts::TAU;

use nalgebra::{Unit, Vector3};
use serde::Serialize;

use super::handover::Handover;
use super::profile::Profile;
use super::remark;
use crate::model::Remark;

/// Angles at which the outline is sampled: a tenth of a degree.
const SAMPLES: usize = 3600;

/// A wheel's outline as its collision geometry makes it on flat ground, beside the barrels that were fitted to it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WheelOutline {
    /// The wheel's joint.
    pub wheel: String,
    /// The radius rho of the fitted wheel, in metres.
    pub fitted_radius_m: f64,
    /// The mean height of the hub over the ground in a turn, which is the rolling radius of the geometry: 2 pi times it is
    /// the perimeter of its convex hull. In metres.
    pub rolling_radius_m: f64,
    /// The greatest height of the hub over the ground, in metres.
    pub peak_radius_m: f64,
    /// Rise and fall of the hub in a turn, in metres.
    pub ripple_m: f64,
    /// Share of a turn without a fitted roller on the ground, in [0, 1].
    pub gap_share: f64,
    /// Share of a turn with two fitted rollers on the ground, in [0, 1].
    pub overlap_share: f64,
}

impl WheelOutline {
    /// Says where the geometry rolls otherwise than the wheel that was fitted to it, by more than one per cent.
    pub(super) fn remark(&self, remarks: &mut Vec<Remark>) {
        let off_m = (self.rolling_radius_m - self.fitted_radius_m).abs();
        if off_m.max(self.ripple_m) > 0.01 * self.fitted_radius_m {
            remarks.push(remark(
                format!("wheel `{}`", self.wheel),
                format!(
                    "its collision geometry rolls on a radius of {:.2} mm and rises and falls by {:.2} mm a turn; it is \
                     taken as a wheel of {:.2} mm with barrels for rollers",
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
    /// The reach from the hub axis in the direction at `angle_rad` about it from x, in metres.
    fn reach_m(&self, angle_rad: f64) -> f64 {
        let (s, c) = angle_rad.sin_cos();
        let outward = Vector3::new(c, s, 0.0);
        let w = self.axis_in_hub.dot(&outward);
        self.foot_in_hub_m.dot(&outward) + self.profile.support_m(w)
    }
}

/// The outline of a wheel.
pub(super) fn outline(
    wheel: &str,
    fitted_radius_m: f64,
    rollers: &[Modelled],
    handover: &Handover,
) -> WheelOutline {
    let (mut sum, mut least, mut most) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for i in 0..SAMPLES {
        let angle_rad = TAU * i as f64 / SAMPLES as f64;
        // The ground meets the roller that reaches furthest down.
        let height_m = rollers
            .iter()
            .map(|r| r.reach_m(angle_rad))
            .fold(f64::NEG_INFINITY, f64::max);
        sum += height_m;
        least = least.min(height_m);
        most = most.max(height_m);
    }
    WheelOutline {
        wheel: wheel.to_owned(),
        fitted_radius_m,
        rolling_radius_m: sum / SAMPLES as f64,
        peak_radius_m: most,
        ripple_m: most - least,
        gap_share: handover.gaps_rad / TAU,
        overlap_share: handover.overlaps_rad / TAU,
    }
}
