//! Receivers of rows during a run.

use crate::error::TraceError;
use crate::header::Header;
use crate::rows::Rows;
use crate::trace::Trace;

/// A receiver of rows: memory, a file of another format, a socket.
///
/// A run passes its rows once a control period. An error ends the run.
pub trait Sink {
    /// Receives the header, before any row.
    ///
    /// # Errors
    /// If the rows cannot be taken; [`TraceError::sink`] for other errors of the sink.
    fn begin(&mut self, header: &Header) -> Result<(), TraceError>;

    /// Receives the rows since the last call, one or more, in order.
    ///
    /// # Errors
    /// Like [`Sink::begin`].
    fn take(&mut self, rows: &Trace) -> Result<(), TraceError>;

    /// Called after the last row.
    ///
    /// # Errors
    /// Like [`Sink::begin`].
    fn finish(&mut self) -> Result<(), TraceError>;
}

/// In memory: the trace becomes that of the run.
impl Sink for Trace {
    fn begin(&mut self, header: &Header) -> Result<(), TraceError> {
        *self = Self::with_capacity(header.clone(), 0);
        Ok(())
    }

    fn take(&mut self, rows: &Trace) -> Result<(), TraceError> {
        self.append(rows);
        Ok(())
    }

    fn finish(&mut self) -> Result<(), TraceError> {
        Ok(())
    }
}

/// Several sinks, each of which receives all rows.
impl Sink for [&mut dyn Sink] {
    fn begin(&mut self, header: &Header) -> Result<(), TraceError> {
        self.iter_mut().try_for_each(|sink| sink.begin(header))
    }

    fn take(&mut self, rows: &Trace) -> Result<(), TraceError> {
        if rows.row_count() == 0 {
            return Ok(());
        }
        self.iter_mut().try_for_each(|sink| sink.take(rows))
    }

    fn finish(&mut self) -> Result<(), TraceError> {
        self.iter_mut().try_for_each(|sink| sink.finish())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::made_up_trace;

    #[test]
    fn memory_holds_what_it_was_handed_whatever_it_held_before() {
        let whole = made_up_trace(3, 10, true);
        let (mut one, mut other) = (made_up_trace(1, 4, false), made_up_trace(2, 2, true));
        let sinks: &mut [&mut dyn Sink] = &mut [&mut one, &mut other];
        sinks.begin(&whole.header).unwrap();
        for rows in [0..3, 3..3, 3..10] {
            sinks.take(&whole.rows(rows)).unwrap();
        }
        sinks.finish().unwrap();
        assert_eq!((&one, &other), (&whole, &whole));
    }
}
