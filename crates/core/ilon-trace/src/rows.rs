//! Rows that need not be in memory.

use std::convert::Infallible;

use crate::columns::signals;
use crate::header::Header;
use crate::joined::Joined;
use crate::trace::Trace;

/// The rows of a run, which can be iterated as often as needed: a [`Trace`] in memory, or a
/// [`TraceFile`](crate::file::TraceFile) on disk.
pub trait Rows {
    /// Why rows cannot be read.
    type Error;

    /// The header of the run.
    fn header(&self) -> &Header;

    /// The number of rows.
    fn row_count(&self) -> usize;

    /// Shows all rows in their order to `see`, some at a time.
    ///
    /// # Errors
    /// Where the rows cannot be read.
    fn each_batch(&self, see: &mut dyn FnMut(&Trace)) -> Result<(), Self::Error>;

    /// Passes the values of a signal, named as its column in the file, in order to `see`: `None` if
    /// it is absent. An unknown signal has no values.
    ///
    /// # Errors
    /// If the values cannot be read.
    fn each_value(&self, signal: &str, see: &mut dyn FnMut(Option<f64>))
    -> Result<(), Self::Error>;

    /// All values of a signal; none of an unknown signal.
    ///
    /// # Errors
    /// Like [`Rows::each_value`].
    fn values(&self, signal: &str) -> Result<Vec<Option<f64>>, Self::Error> {
        let mut values = Vec::new();
        self.each_value(signal, &mut |value| values.push(value))?;
        Ok(values)
    }
}

impl Rows for Trace {
    type Error = Infallible;

    fn header(&self) -> &Header {
        &self.header
    }

    fn row_count(&self) -> usize {
        self.records().len()
    }

    fn each_batch(&self, see: &mut dyn FnMut(&Trace)) -> Result<(), Infallible> {
        see(self);
        Ok(())
    }

    fn each_value(&self, signal: &str, see: &mut dyn FnMut(Option<f64>)) -> Result<(), Infallible> {
        let signals = signals(&self.header);
        if let Some(signal) = signals.iter().find(|known| known.name == signal) {
            (0..self.row_count()).for_each(|step| see(signal.get(self, step)));
        }
        Ok(())
    }
}

/// Every `every`-th row from the first on, and the last, as a trace of its own whose rows are as
/// much further apart: each has what happened in those that were left out before it.
///
/// # Errors
/// Like [`Rows::each_batch`].
pub fn thinned<R: Rows>(rows: &R, every: usize) -> Result<Trace, R::Error> {
    let every = every.max(1);
    let mut header = rows.header().clone();
    let apart = u32::try_from(every).unwrap_or(u32::MAX);
    header.record_every = header.record_every.max(1).saturating_mul(apart);
    let row_count = rows.row_count();
    let mut thin = Trace::with_capacity(header, row_count.div_ceil(every) + 1);
    let (mut row, mut joined) = (0, Joined::default());
    rows.each_batch(&mut |chunk| {
        for (place, (record, wheels)) in chunk.steps().enumerate() {
            joined.add(record, wheels);
            if row % every == 0 || row + 1 == row_count {
                let (record, wheels) = joined.take();
                thin.push(*record, wheels);
                thin.put_roller_angles(chunk.roller_angles_at(place).iter().copied());
            }
            row += 1;
        }
    })?;
    Ok(thin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::made_up_trace;

    #[test]
    fn a_thinned_trace_has_every_so_many_rows_as_much_further_apart_and_the_last() {
        let whole = made_up_trace(2, 10, true);
        let Ok(thin) = thinned(&whole, 4);
        assert_eq!(thin.header.row_dt_s(), 4.0 * whole.header.row_dt_s());
        let times = |trace: &Trace| -> Vec<f64> {
            trace.records().iter().map(|record| record.t_s).collect()
        };
        let all = times(&whole);
        assert_eq!(times(&thin), [all[0], all[4], all[8], all[9]]);
        // The largest of the rows that were left out is in the next.
        let peak = |trace: &Trace, rows: std::ops::Range<usize>| {
            let samples = rows.map(|row| trace.wheels_at(row)[1].normal_force_max_n);
            samples.fold(f64::NEG_INFINITY, f64::max)
        };
        assert_eq!(peak(&thin, 1..2), peak(&whole, 1..5));
    }

    #[test]
    fn values_are_those_of_the_signal_and_none_of_an_unknown_one() {
        let trace = made_up_trace(2, 3, false);
        let Ok(rates) = trace.values("wheel1_rate_rad_s");
        assert_eq!(trace.signal("wheel1_rate_rad_s"), Some(rates));
        assert_eq!(trace.values("desired_x_m"), Ok(vec![None; 3]));
        assert_eq!(trace.values("wheel2_rate_rad_s"), Ok(Vec::new()));
    }
}
