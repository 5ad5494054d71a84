//! Checks that all recorded values are finite.

use std::ops::Range;

use crate::columns::{Signal, signals};
use crate::error::TraceError;
use crate::rows::Rows;
use crate::trace::Trace;

/// The largest meaningful value: f32 numbers of the world end at 3.4e38, and their squares overflow
/// long before. Chosen.
const LARGEST: f64 = 1e30;
/// The ending of signals that may be infinite: the capacity of a task has no bound if wheel rates
/// have none.
const UNBOUNDED: &str = "_capacity_rad_s";

impl Trace {
    /// Checks that every recorded value is finite and at most 1e30; after the first one that is
    /// not, the rest is meaningless.
    ///
    /// # Errors
    /// [`TraceError::Diverged`] with the first such value.
    pub fn check_finite(&self) -> Result<(), TraceError> {
        Watched::of(self).check(self, 0..self.row_count())
    }
}

/// The signals of a trace, for repeated checks.
#[derive(Debug)]
pub(crate) struct Watched(Vec<Signal>);

impl Watched {
    pub fn of(trace: &Trace) -> Self {
        Self(signals(&trace.header))
    }

    /// Like [`Trace::check_finite`], for some rows.
    pub fn check(&self, trace: &Trace, rows: Range<usize>) -> Result<(), TraceError> {
        for row in rows {
            for signal in &self.0 {
                let is_wild = |value: &f64| value.is_nan() || value.abs() > LARGEST;
                let Some(value) = signal.get(trace, row).filter(is_wild) else {
                    continue;
                };
                if value.is_nan() || !signal.name.ends_with(UNBOUNDED) {
                    return Err(TraceError::Diverged {
                        signal: signal.name.clone(),
                        t_s: trace
                            .records()
                            .get(row)
                            .map_or(f64::NAN, |record| record.t_s),
                        value,
                    });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::record::{Record, WheelSample};
    use crate::sample::made_up_trace;
    use crate::trace::Trace;

    fn with(spoil: impl Fn(usize, &mut Record, &mut WheelSample)) -> Result<(), String> {
        let good = made_up_trace(3, 5, true);
        let mut trace = Trace::with_capacity(good.header.clone(), 5);
        for (step, (record, wheels)) in good.steps().enumerate() {
            let (mut record, mut wheels) = (*record, wheels.to_vec());
            spoil(step, &mut record, &mut wheels[1]);
            trace.push(record, &wheels);
        }
        trace.check_finite().map_err(|error| error.to_string())
    }

    #[test]
    fn the_first_value_that_is_no_number_is_named_with_its_time() {
        assert_eq!(with(|_, _, _| ()), Ok(()));
        let told = with(|step, record, wheel| {
            record.t_s = 0.5 * step as f64;
            if step > 2 {
                wheel.rate_rad_s = f64::NAN;
            }
        });
        let expected = "the simulation diverged at 1.5 s: `wheel1_rate_rad_s` is NaN";
        assert_eq!(told, Err(expected.to_owned()));
        let told = with(|step, record, _| {
            record.t_s = 0.0;
            if step == 4 {
                record.truth.pose.x_m = f64::NEG_INFINITY;
            }
        });
        let expected = "the simulation diverged at 0 s: `truth_x_m` is -inf";
        assert_eq!(told, Err(expected.to_owned()));
        let wild = |_, _: &mut Record, wheel: &mut WheelSample| wheel.rate_rad_s = -1.1e30;
        assert!(
            with(wild)
                .unwrap_err()
                .ends_with("`wheel1_rate_rad_s` is -1.1e30")
        );
    }

    #[test]
    fn what_a_task_can_be_given_may_have_no_bound() {
        let unbounded = |capacity| {
            with(move |_, record, _| {
                record
                    .tasks
                    .iter_mut()
                    .for_each(|task| task.capacity_rad_s = capacity);
            })
        };
        assert_eq!(unbounded(f64::INFINITY), Ok(()));
        assert!(unbounded(f64::NAN).is_err());
    }
}
