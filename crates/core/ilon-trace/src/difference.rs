//! Compares a whole trace with an earlier one (its baseline), signal by signal.

use std::collections::BTreeMap;

use crate::{Rows, number, significant, to_microseconds};

/// A signal that differs from its baseline.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Difference {
    /// Column name of the signal.
    pub signal: String,
    /// Time of the first difference beyond the tolerance, in seconds.
    pub first_s: f64,
    /// Baseline value there; `None` if it is absent.
    pub baseline: Option<f64>,
    /// Value of the run there; `None` if it is absent.
    pub run: Option<f64>,
    /// Largest difference at any time; infinite if only one side has a value.
    pub worst: f64,
    /// That difference relative to the largest magnitude of the signal in the baseline; infinite if
    /// only one side has a value.
    pub share: f64,
    /// The tolerance.
    pub tolerance: f64,
}

impl Difference {
    /// Whether the signal is the number of the roller that touches: it differs as soon as a
    /// hand-over shifts by a row.
    pub fn is_roller_index(&self) -> bool {
        self.signal.ends_with("_roller")
    }
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Four digits, or all where four are equal.
        let short = |x: f64| significant(x, 4);
        let is_close = self.run.map(short) == self.baseline.map(short);
        let shown = |x: f64| number(if is_close { x } else { short(x) });
        let value = |value: Option<f64>| value.map_or("nothing".to_owned(), shown);
        write!(
            f,
            "{} leaves its baseline at {} s: {}, was {}; ",
            self.signal,
            to_microseconds(self.first_s),
            value(self.run),
            value(self.baseline)
        )?;
        match self.worst.is_finite() {
            true => write!(
                f,
                "at worst {} off, where {} is allowed",
                number(short(self.worst)),
                number(self.tolerance)
            ),
            false => f.write_str("in some rows only one of them is a number"),
        }
    }
}

/// The signals of a run that differ from its baseline, the earliest difference first. A signal
/// without a tolerance must be equal to the bit, or is left out if `only_tolerated`; runs of
/// different length differ in the time signal. One signal at a time is in memory.
///
/// # Errors
/// If the rows cannot be read.
pub fn differences<R: Rows>(
    run: &R,
    baseline: &R,
    tolerances: &BTreeMap<String, f64>,
    only_tolerated: bool,
) -> Result<Vec<Difference>, R::Error> {
    let recorded =
        |(name, tolerance): (&String, &f64)| (run.header().recorded_name(name), *tolerance);
    let tolerances: BTreeMap<String, f64> = tolerances.iter().map(recorded).collect();
    let mut names = run.header().signal_names();
    let more = baseline.header().signal_names();
    let more: Vec<_> = more
        .into_iter()
        .filter(|name| !names.contains(name))
        .collect();
    names.extend(more);
    let mut found = Vec::new();
    let times_s = (run.values("t_s")?, baseline.values("t_s")?);
    for name in names {
        let tolerance = match tolerance_of(&name, &tolerances) {
            None if only_tolerated => continue,
            tolerance => tolerance.unwrap_or(0.0),
        };
        let (ours, theirs) = (run.values(&name)?, baseline.values(&name)?);
        found.extend(difference(&ours, &theirs, &times_s, name, tolerance));
    }
    found.sort_by(|a, b| a.first_s.total_cmp(&b.first_s));
    Ok(found)
}

fn difference(
    ours: &[Option<f64>],
    theirs: &[Option<f64>],
    times_s: &(Vec<Option<f64>>, Vec<Option<f64>>),
    signal: String,
    tolerance: f64,
) -> Option<Difference> {
    let rows = ours.len().max(theirs.len());
    let at = |values: &[Option<f64>], row: usize| values.get(row).copied().flatten();
    let off = |row: usize| match (at(ours, row), at(theirs, row)) {
        (Some(a), Some(b)) if a.is_nan() && b.is_nan() => 0.0,
        (Some(a), Some(b)) if a == b => 0.0,
        (Some(a), Some(b)) if a.is_finite() && b.is_finite() => (a - b).abs(),
        (None, None) => 0.0,
        _ => f64::INFINITY,
    };
    let first = (0..rows).find(|row| off(*row) > tolerance)?;
    let worst = (0..rows).map(off).fold(0.0, f64::max);
    // In SI units: values below a tenth of a millimetre, or of a millinewton, count as zero.
    // Chosen.
    const LEAST_SIZE: f64 = 1e-4;
    let sizes = theirs.iter().flatten().filter(|value| value.is_finite());
    let size = sizes.map(|value| value.abs()).fold(LEAST_SIZE, f64::max);
    Some(Difference {
        first_s: at(&times_s.0, first)
            .or(at(&times_s.1, first))
            .unwrap_or(0.0),
        baseline: at(theirs, first),
        run: at(ours, first),
        worst,
        share: worst / size,
        tolerance,
        signal,
    })
}

/// The tolerance of a signal: its own, or that for every wheel.
fn tolerance_of(name: &str, tolerances: &BTreeMap<String, f64>) -> Option<f64> {
    let of_every_wheel = || {
        let (wheel, rest) = name.strip_prefix("wheel")?.split_once('_')?;
        let is_number = wheel.chars().all(|digit| digit.is_ascii_digit());
        is_number.then(|| tolerances.get(&format!("wheel*_{rest}")))?
    };
    tolerances.get(name).or_else(of_every_wheel).copied()
}

#[cfg(test)]
mod tests {
    use crate::{Header, Record, Trace, WheelHeader, WheelSample};

    use super::*;

    fn found(run: &Trace, baseline: &Trace, tolerances: &BTreeMap<String, f64>) -> Vec<Difference> {
        let Ok(found) = differences(run, baseline, tolerances, false);
        found
    }

    fn trace(spoil: impl Fn(u32, &mut Record, &mut WheelSample)) -> Trace {
        let header = Header {
            wheels: vec![WheelHeader::default()],
            control_dt_s: 0.5,
            ..Header::default()
        };
        let mut trace = Trace::with_capacity(header, 4);
        for step in 0..4 {
            let mut record = Record {
                t_s: 0.5 * f64::from(step),
                ..Record::default()
            };
            let mut wheel = WheelSample::default();
            spoil(step, &mut record, &mut wheel);
            trace.push(record, &[wheel]);
        }
        trace
    }

    #[test]
    fn equal_traces_do_not_differ_and_a_last_bit_does() {
        let baseline = trace(|_, record, _| record.truth.pose.x_m = 1.0);
        assert!(found(&baseline, &baseline, &BTreeMap::new()).is_empty());
        let run = trace(|step, record, _| {
            record.truth.pose.x_m = if step < 2 { 1.0 } else { 1.0 + f64::EPSILON };
        });
        let found = found(&run, &baseline, &BTreeMap::new());
        assert_eq!(found.len(), 1);
        assert_eq!(
            (found[0].signal.as_str(), found[0].first_s),
            ("truth_x_m", 1.0)
        );
    }

    #[test]
    fn a_tolerance_lets_a_signal_be_off_by_as_much_and_no_more() {
        let baseline = trace(|_, _, _| ());
        let run = trace(|step, _, wheel| wheel.torque_n_m = 0.1 * f64::from(step));
        let allow = |tolerance| BTreeMap::from([("wheel*_torque_n_m".to_owned(), tolerance)]);
        // 0.1 * 3 is a rounding above 0.3.
        assert!(found(&run, &baseline, &allow(0.3 + 1e-15)).is_empty());
        let found = found(&run, &baseline, &allow(0.15));
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].first_s, found[0].run), (1.0, Some(0.2)));
    }

    /// `wheelbase_m` begins like the signal of a wheel, but is none.
    #[test]
    fn a_tolerance_of_every_wheel_is_of_numbered_wheels_alone() {
        let allow = BTreeMap::from([("wheel*_m".to_owned(), 0.5)]);
        assert_eq!(tolerance_of("wheel12_m", &allow), Some(0.5));
        assert_eq!(tolerance_of("wheelbase_m", &allow), None);
    }

    #[test]
    fn a_shorter_run_differs_where_it_ends() {
        let baseline = trace(|_, _, _| ());
        let mut run = Trace::with_capacity(baseline.header.clone(), 2);
        for step in 0..2 {
            run.push(baseline.records()[step], baseline.wheels_at(step));
        }
        let found = found(&run, &baseline, &BTreeMap::new());
        assert!(
            found
                .iter()
                .all(|one| one.first_s == 1.0 && one.worst.is_infinite())
        );
        assert!(!found.is_empty());
    }

    #[test]
    fn the_worst_of_a_signal_may_be_its_first_row() {
        let ours = trace(|step, record, _| {
            record.truth.pose.x_m = if step == 0 { 3.0 } else { 1.0 };
        });
        let theirs = trace(|_, _, _| {});
        let found = found(&ours, &theirs, &BTreeMap::new());
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].first_s, found[0].worst), (0.0, 3.0));
        // Nothing in the baseline: a tenth of a millimetre is its size.
        assert_eq!(found[0].share, 3.0 / 1e-4);
    }
}
