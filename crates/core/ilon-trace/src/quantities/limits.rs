//! The possible range of each figure, so that bounds that can never fail are reported before a run.

use super::by_key;
use super::quantity::Limits;

/// The possible range of a figure, or of one of the signals `position_error_m` and
/// `heading_error_rad`; `None` if it can have either sign.
pub fn limits(key: &str) -> Option<Limits> {
    match key {
        "position_error_m" | "heading_error_rad" => Some(Limits::SIZE),
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
