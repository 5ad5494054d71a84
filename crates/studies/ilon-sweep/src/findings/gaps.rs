//! Missing findings of a study, with the reason and a remedy.

use serde::{Deserialize, Serialize};

use ilon_trace::quantities::needs;

use crate::row::{Row, Status};

/// A quantity whose findings are incomplete.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Gap {
    /// The quantity.
    pub quantity: String,
    /// The scenario.
    pub scenario: String,
    /// Number of finished runs without it.
    pub absent: u64,
    /// Number of finished runs.
    pub runs: u64,
    /// The reason, and a remedy.
    pub why: String,
}

/// Returns the gap of a quantity that some runs lack; `None` if all have it, or if no run finished,
/// which is reported separately.
pub(super) fn absent(
    quantity: &str,
    scenario: &str,
    rows: &[&Row],
    figure: impl Fn(&Row) -> Option<f64>,
) -> Option<Gap> {
    let done = || rows.iter().filter(|row| row.status == Status::Done);
    let absent = done().filter(|row| figure(row).is_none()).count() as u64;
    (absent > 0).then(|| {
        let why = needs(quantity);
        let why = why.unwrap_or("it does not apply to these runs; name another quantity");
        Gap {
            absent,
            ..Gap::of(quantity, scenario, done().count() as u64, why.to_owned())
        }
    })
}

impl Gap {
    /// A gap of a quantity that no run lacks.
    fn of(quantity: &str, scenario: &str, runs: u64, why: String) -> Self {
        Self {
            quantity: quantity.to_owned(),
            scenario: scenario.to_owned(),
            absent: 0,
            runs,
            why,
        }
    }
}

/// Returns the gap of a quantity that no axis changes, so that there are no shares.
pub(super) fn constant(quantity: &str, scenario: &str, runs: u64, value: f64) -> Gap {
    let why = format!(
        "it is {} in all runs, so no axis has an effect; vary a key that changes it",
        ilon_trace::number(value)
    );
    Gap::of(quantity, scenario, runs, why)
}

/// Returns the gap of a quantity with too few complete base points, or moves.
pub(super) fn broken(quantity: &str, scenario: &str, runs: u64, whole: u64, each: usize) -> Gap {
    let why = format!(
        "of {whole} points alone all {each} runs came to their end and have it, where two are needed; see why the others failed, or \
         take more `points`"
    );
    Gap::of(quantity, scenario, runs, why)
}

#[cfg(test)]
mod tests {
    use ilon_trace::Summary;
    use ilon_trace::quantities;

    use super::*;

    /// Every quantity that may be absent has an explanation; quantities that every finished run has
    /// need none.
    #[test]
    fn of_every_quantity_that_may_be_absent_it_is_said_what_it_takes() {
        let empty = Summary::default();
        let of_every_run = [
            "wheel_rate_",
            "wheel_torque_",
            "slip_energy",
            "wheel_slip_energy",
            "airborne",
            "contact_residual",
            "end_",
            "energy.",
            "sim_seconds",
        ];
        for quantity in quantities::all().filter(|quantity| quantity.value(&empty).is_none()) {
            let is_of_every_run = of_every_run
                .iter()
                .any(|beginning| quantity.key.starts_with(beginning));
            assert!(
                needs(quantity.key).is_some() || is_of_every_run,
                "{}",
                quantity.key
            );
        }
        assert_ne!(
            needs("twist_ratio_ideal.vy"),
            needs("twist_mean.vy_m_s"),
            "the longer beginning comes first"
        );
    }
}
