//! The recorded signals by the names of the file's columns.

use crate::columns::{Signal, signals};
use crate::header::Header;
use crate::trace::Trace;

impl Header {
    /// All signals that a trace with this header records, in the order of the file's columns.
    pub fn signals(&self) -> Vec<Signal> {
        signals(self)
    }

    /// The recorded name of a signal: a wheel's signal may be named by the wheel's joint,
    /// `front_left_torque_n_m` for `wheel0_torque_n_m`.
    pub fn recorded_name(&self, name: &str) -> String {
        let of_wheel = |(index, wheel): (usize, &crate::WheelHeader)| {
            let rest = name.strip_prefix(&wheel.name)?.strip_prefix('_')?;
            Some((wheel.name.len(), format!("wheel{index}_{rest}")))
        };
        let found = self.wheels.iter().enumerate().filter_map(of_wheel);
        // If one wheel's name is a prefix of another's, the longer one counts.
        let longest = found.max_by_key(|(length, _)| *length);
        longest.map_or_else(|| name.to_owned(), |(_, name)| name)
    }

    /// The names of all signals that a trace with this header records, in the order of the file's
    /// columns.
    pub fn signal_names(&self) -> Vec<String> {
        signals(self)
            .into_iter()
            .map(|signal| signal.name)
            .collect()
    }
}

impl Trace {
    /// A signal over the run by its column's name, such as `truth_x_m` or `wheel0_rate_rad_s`: one
    /// value per record, `None` if it is absent; `None` altogether for an unknown signal.
    pub fn signal(&self, name: &str) -> Option<Vec<Option<f64>>> {
        let signals = signals(&self.header);
        let signal = signals.iter().find(|signal| signal.name == name)?;
        let steps = 0..self.records().len();
        Some(steps.map(|step| signal.get(self, step)).collect())
    }
}

#[cfg(test)]
mod tests {
    use crate::sample::made_up_trace;

    #[test]
    fn a_signal_is_found_by_its_name_and_holds_what_was_recorded() {
        let trace = made_up_trace(3, 4, true);
        let rates = trace.signal("wheel2_rate_rad_s").expect("it is recorded");
        let recorded: Vec<_> = trace.wheel(2).map(|wheel| Some(wheel.rate_rad_s)).collect();
        assert_eq!(rates, recorded);
        assert!(trace.signal("wheel3_rate_rad_s").is_none());
    }

    #[test]
    fn what_does_not_apply_to_a_run_is_a_signal_without_values() {
        let trace = made_up_trace(3, 2, false);
        assert_eq!(trace.signal("desired_x_m"), Some(vec![None, None]));
    }
}
