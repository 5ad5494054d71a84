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

/// Shares, in [0, 1].
const SHARES: [&str; 5] = [
    "saturated_share",
    "airborne_share",
    "chassis_load_share",
    "rate_conflict_share",
    "friction_used_max",
];

/// Losses.
const LOSSES: [&str; 6] = [
    "slip_energy_j",
    "wheel_slip_energy_j",
    "energy.slip_j",
    "energy.spin_up_j",
    "energy.bearing_j",
    "energy.impact_j",
];

/// How figures begin that not every run has: those of a path, a pose sensor, dead reckoning over
/// some distance, a mean motion, redundant wheels, tasks, and a chassis that stands on the ground.
const NOT_OF_EVERY_RUN: [&str; 8] = [
    "position_",
    "heading_",
    "seen_",
    "odometry_",
    "twist_ripple.",
    "rate_conflict_share",
    "saturated_share",
    "chassis_load_share",
];

/// Distances, sizes, times, and sums that only grow. `position_error_m` and `heading_error_rad` are
/// signals.
const SIZES: [&str; 34] = [
    "duration_s",
    "steps",
    "physics_dt_s",
    "control_dt_s",
    "sim_seconds_per_cpu_second",
    "position_error_m",
    "position_error_rms_m",
    "position_error_max_m",
    "position_error_max_at_s",
    "position_error_final_m",
    "heading_error_rad",
    "heading_error_rms_rad",
    "heading_error_max_rad",
    "heading_error_max_at_s",
    "heading_error_final_rad",
    "position_converged_s",
    "heading_converged_s",
    "seen_position_error_rms_m",
    "seen_heading_error_rms_rad",
    "wheel_rate_command_max_rad_s",
    "wheel_rate_error_rms_rad_s",
    "wheel_torque_max_n_m",
    "hub_ripple_m",
    "slip_speed_rms_m_s",
    "slip_speed_max_m_s",
    "contact_residual_max_m_s",
    "energy.motor_positive_j",
    "energy.outside_positive_j",
    "energy.fall_j",
    "energy.put_in_j",
    "travelled_m",
    "turned_rad",
    "odometry_drift_m_per_m",
    "odometry_joints_m",
];

/// The possible range of a figure, or of one of the two signals above; `None` if it can have either
/// sign.
pub fn limits(key: &str) -> Option<Limits> {
    let ends = |ends: &[&str]| ends.iter().any(|end| key.ends_with(end));
    let in_group = by_key(key).is_some()
        && (key.starts_with("twist_ripple.")
            || (key.starts_with("ledger.") && ends(&[".path_m", ".turned_rad"]))
            || (key.starts_with("odometry_") && ends(&[".final_m", ".worst_m", ".m_per_m"])));
    let is_share = SHARES.contains(&key);
    let may_be_absent =
        by_key(key).is_some() && NOT_OF_EVERY_RUN.iter().any(|start| key.starts_with(start));
    let is_loss = LOSSES.contains(&key);
    (is_share || is_loss || in_group || SIZES.contains(&key)).then_some(Limits {
        least: 0.0,
        most: if is_share { 1.0 } else { f64::INFINITY },
        is_certain: !(is_loss || may_be_absent),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_with_limits_exists_and_signed_ones_have_none() {
        const SIGNALS: [&str; 2] = ["position_error_m", "heading_error_rad"];
        for key in SHARES.iter().chain(&LOSSES).chain(&SIZES) {
            assert!(by_key(key).is_some() || SIGNALS.contains(key), "{key}");
            assert_eq!(limits(key).map(|of| of.least), Some(0.0), "{key}");
        }
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
