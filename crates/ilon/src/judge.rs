//! Holds a run's summary against the scenario's `[expect]`.

use serde_json::Value;

use crate::scenario::{Bound, Expect};

/// The quantities of `summary.json` that an expectation can name.
pub const QUANTITIES: &[&str] = &[
    "sim_seconds_per_cpu_second",
    "position_error_rms_m",
    "position_error_final_m",
    "heading_error_rms_rad",
    "heading_error_final_rad",
    "position_converged_s",
    "heading_converged_s",
    "wheel_rate_command_max_rad_s",
    "wheel_torque_max_n_m",
    "twist_mean.vx_m_s",
    "twist_mean.vy_m_s",
    "twist_mean.omega_rad_s",
    "twist_ideal_mean.vx_m_s",
    "twist_ideal_mean.vy_m_s",
    "twist_ideal_mean.omega_rad_s",
    "twist_contact_mean.vx_m_s",
    "twist_contact_mean.vy_m_s",
    "twist_contact_mean.omega_rad_s",
    "twist_ratio_ideal.vx",
    "twist_ratio_ideal.vy",
    "twist_ratio_ideal.omega",
    "twist_ratio_contact.vx",
    "twist_ratio_contact.vy",
    "twist_ratio_contact.omega",
    "slip_speed_rms_m_s",
    "slip_speed_max_m_s",
    "slip_energy_j",
    "odometry_drift_m_per_m",
    "odometry_drift_rad_per_m",
    "hub_ripple_m",
];

/// What came of one expectation.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The quantity's dotted name.
    pub quantity: String,
    /// The bound in words, such as `<= 0.01`.
    pub bound: String,
    /// What was measured; `None` where the quantity does not apply to this run.
    pub measured: Option<f64>,
    /// Whether it held.
    pub held: bool,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            quantity,
            bound,
            measured,
            held,
        } = self;
        let verb = if *held { "held" } else { "failed" };
        match measured {
            Some(measured) => write!(f, "{quantity} {bound} {verb}: measured {measured}"),
            None => write!(
                f,
                "{quantity} {bound} {verb}: it does not apply to this run"
            ),
        }
    }
}

/// Holds a summary, as the JSON of `summary.json`, against expectations, in the order of their names.
pub fn judge(expect: &Expect, summary: &Value) -> Vec<Verdict> {
    expect
        .bounds
        .iter()
        .map(|(quantity, bound)| {
            let pointer = format!("/{}", quantity.replace('.', "/"));
            let measured = summary.pointer(&pointer).and_then(Value::as_f64);
            Verdict {
                quantity: quantity.clone(),
                bound: bound.to_string(),
                measured,
                held: measured.is_some_and(|measured| bound.holds(measured)),
            }
        })
        .collect()
}

impl Bound {
    /// Whether a value keeps to the bound. NaN never does.
    pub fn holds(&self, value: f64) -> bool {
        let Self {
            min,
            max,
            equal,
            within,
        } = *self;
        value.is_finite()
            && min.is_none_or(|min| value >= min)
            && max.is_none_or(|max| value <= max)
            && equal.is_none_or(|equal| (value - equal).abs() <= within.unwrap_or(0.0))
    }
}

impl std::fmt::Display for Bound {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let parts = [
            self.min.map(|min| format!(">= {min}")),
            self.max.map(|max| format!("<= {max}")),
            self.equal.map(|equal| match self.within {
                Some(within) => format!("= {equal} +- {within}"),
                None => format!("= {equal}"),
            }),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        f.write_str(&parts.join(" and "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_holds_on_its_edge_and_not_beyond() {
        let bound = Bound {
            min: Some(1.0),
            max: Some(2.0),
            ..Bound::default()
        };
        assert!(bound.holds(1.0) && bound.holds(2.0));
        assert!(!bound.holds(0.999) && !bound.holds(2.001) && !bound.holds(f64::NAN));
        assert_eq!(bound.to_string(), ">= 1 and <= 2");
    }

    #[test]
    fn a_quantity_that_does_not_apply_fails_its_bound() {
        let expect: Expect = toml::from_str("position_error_final_m = { max = 0.01 }").unwrap();
        let summary = serde_json::json!({ "position_error_final_m": null });
        let verdicts = judge(&expect, &summary);
        assert!(!verdicts[0].held);
        assert_eq!(
            verdicts[0].to_string(),
            "position_error_final_m <= 0.01 failed: it does not apply to this run"
        );
    }
}
