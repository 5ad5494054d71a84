//! The possible range of each figure, so that bounds that can never fail are reported before a run.

use super::by_key;

/// The possible values of a figure, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Limits {
    /// Smallest.
    pub least: f64,
    /// Largest.
    pub most: f64,
    /// Whether every run has the figure, and keeps the limits even if its step is too long: then
    /// losses can come out below zero, and an error may never settle.
    pub is_certain: bool,
}

/// Distances, sizes, times, and sums that only grow.
pub(super) const SIZE: Limits = limits_of(f64::INFINITY, true);
/// Shares.
pub(super) const SHARE: Limits = limits_of(1.0, true);
/// Losses.
pub(super) const LOSS: Limits = limits_of(f64::INFINITY, false);
/// Sizes that not every run has: those of a path, a pose sensor, dead reckoning over some distance,
/// or a mean motion.
pub(super) const SIZE_IF_ANY: Limits = limits_of(f64::INFINITY, false);
/// Shares that not every run has: those of redundant wheels, tasks, and a chassis that stands on
/// the ground.
pub(super) const SHARE_IF_ANY: Limits = limits_of(1.0, false);

const fn limits_of(most: f64, is_certain: bool) -> Limits {
    Limits {
        least: 0.0,
        most,
        is_certain,
    }
}

/// The possible range of a figure, or of one of the signals `position_error_m` and
/// `heading_error_rad`; `None` if it can have either sign.
pub fn limits(key: &str) -> Option<Limits> {
    match key {
        "position_error_m" | "heading_error_rad" => Some(SIZE),
        _ => by_key(key)?.limits,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_one_sign_have_limits_and_signed_ones_none() {
        for signed in [
            "end_x_m",
            "end_heading_rad",
            "odometry_drift_rad_per_m",
            "odometry_ideal.rad_per_turn",
            "energy.unexplained_share",
            "energy.motor_j",
            "ledger.slip.x_m",
            "twist_mean.vx_m_s",
            "twist_ratio_ideal.vx",
        ] {
            assert!(by_key(signed).is_some(), "{signed}");
            assert_eq!(limits(signed), None, "{signed}");
        }
        let most = |key| limits(key).map(|limits| (limits.most, limits.is_certain));
        assert_eq!(most("friction_used_max"), Some((1.0, true)));
        assert_eq!(most("slip_energy_j"), Some((f64::INFINITY, false)));
        assert_eq!(most("ledger.slip.path_m"), Some((f64::INFINITY, true)));
        assert_eq!(most("saturated_share"), Some((1.0, false)));
        assert_eq!(most("heading_converged_s"), Some((f64::INFINITY, false)));
        assert_eq!(most("position_error_m"), Some((f64::INFINITY, true)));
    }
}
