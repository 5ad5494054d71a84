//! Bounds on signals over time.

use ilon_trace::{Header, Rows, Trace};

use super::verdict::Verdict;
use crate::Error;
use crate::scenario::{Bound, Must, SignalBound, TIME_SLACK_S, nearest};

/// Signals derived from recorded ones: distance from the desired position, and magnitude of the
/// heading error.
const DERIVED: [&str; 2] = ["position_error_m", "heading_error_rad"];

/// The part of a signal's name that stands for every wheel.
const EVERY_WHEEL: &str = "wheel*_";

/// Checks that a run records all these signals.
///
/// # Errors
/// [`Error::Invalid`] with the most similar recorded name, never that of another wheel.
pub fn check_names<'a>(
    names: impl IntoIterator<Item = &'a str>,
    header: &Header,
) -> Result<(), Error> {
    let recorded = header.signal_names();
    for name in names {
        let is_every = name.starts_with(EVERY_WHEEL);
        let first = match is_every {
            true => name.replace(EVERY_WHEEL, "wheel0_"),
            false => header.recorded_name(name),
        };
        if recorded.contains(&first) || DERIVED.contains(&name) {
            continue;
        }
        let number = first
            .strip_prefix("wheel")
            .and_then(|rest| rest.split_once('_'));
        let same_wheel = |known: &&str| match number {
            Some((number, _)) if number.parse::<usize>().is_ok() => {
                known.starts_with(&format!("wheel{number}_"))
            }
            _ => !known.starts_with("wheel"),
        };
        let known = recorded.iter().map(String::as_str).chain(DERIVED);
        let near = nearest(&first, known.filter(same_wheel));
        return Err(Error::invalid(
            format!("there is no signal `{name}` in a trace of this run"),
            match near {
                Some(near) if is_every => {
                    format!("did you mean `{}`?", near.replace("wheel0_", EVERY_WHEEL))
                }
                Some(near) => format!("did you mean `{near}`?"),
                None => of_wheels(header),
            },
        ));
    }
    Ok(())
}

/// Describes how signals are named.
fn of_wheels(header: &Header) -> String {
    let names = header.wheels.iter().enumerate();
    let names: Vec<String> = names
        .map(|(index, wheel)| format!("wheel{index} is {}", wheel.name))
        .collect();
    let first = header.wheels.first().map_or("wheel0", |wheel| &wheel.name);
    format!(
        "signals are the columns of trace.parquet; those of wheels may be called by their joints, `{first}_torque_n_m`: {}",
        names.join(", ")
    )
}

/// Compares a run with bounds; a bound on every wheel is judged by the worst wheel.
pub(super) fn judge<R: Rows>(bounds: &[SignalBound], rows: &R) -> Result<Vec<Verdict>, R::Error> {
    if bounds.is_empty() {
        return Ok(Vec::new());
    }
    let header = rows.header();
    let mut watches: Vec<Vec<Watch>> = bounds
        .iter()
        .map(|bound| Watch::of_each_signal(bound, header))
        .collect();
    rows.each_batch(&mut |chunk| {
        for watch in watches.iter_mut().flatten() {
            watch.add(chunk);
        }
    })?;
    let verdicts = bounds.iter().zip(watches).map(|(bound, watches)| {
        let verdicts = watches.into_iter().map(Watch::verdict);
        verdicts
            .max_by(|(_, a), (_, b)| a.total_cmp(b))
            .map(|(verdict, _)| verdict)
            .unwrap_or_else(|| verdict_of(bound, &bound.signal, None, false))
    });
    Ok(verdicts.collect())
}

/// A bound on one signal, and the decisive instant among those seen so far.
struct Watch<'b> {
    bound: &'b SignalBound,
    limits: Bound,
    name: String,
    /// Whether a row lies in the window, with a value or without.
    is_inside: bool,
    /// The decisive time in seconds, and the value there.
    counts: Option<(f64, f64)>,
}

impl<'b> Watch<'b> {
    /// One watch on the signal that the bound names, or one for each wheel.
    fn of_each_signal(bound: &'b SignalBound, header: &Header) -> Vec<Self> {
        let on = |name: String| Self {
            bound,
            limits: bound.bound(),
            name,
            is_inside: false,
            counts: None,
        };
        if !bound.signal.contains(EVERY_WHEEL) {
            return vec![on(header.recorded_name(&bound.signal))];
        }
        let of_wheel = |wheel| bound.signal.replace(EVERY_WHEEL, &format!("wheel{wheel}_"));
        (0..header.wheels.len())
            .map(|wheel| on(of_wheel(wheel)))
            .collect()
    }

    /// Takes in further rows.
    fn add(&mut self, chunk: &Trace) {
        let times_s = chunk.records().iter().map(|record| record.t_s);
        for (t_s, value) in times_s.zip(values(chunk, &self.name)) {
            if !self.is_in_window(t_s) {
                continue;
            }
            self.is_inside = true;
            if let Some(value) = value
                && self.outweighs(value)
            {
                self.counts = Some((t_s, value));
            }
        }
    }

    fn is_in_window(&self, t_s: f64) -> bool {
        let SignalBound {
            must,
            from_s,
            until_s,
            ..
        } = *self.bound;
        match (must, until_s) {
            (Must::Always | Must::Eventually, until_s) => {
                let until_s = until_s.unwrap_or(f64::INFINITY);
                t_s >= from_s - TIME_SLACK_S && t_s <= until_s + TIME_SLACK_S
            }
            (Must::Settle, Some(until_s)) => t_s >= until_s - TIME_SLACK_S,
            (Must::Settle, None) => true,
        }
    }

    /// Whether a value is more decisive than those before it. Among equal ones the first counts.
    fn outweighs(&self, value: f64) -> bool {
        let Some((_, before)) = self.counts else {
            return true;
        };
        let breach = self.limits.breach(value);
        let order = breach.total_cmp(&self.limits.breach(before));
        match (self.bound.must, self.bound.until_s) {
            // Without a settling time the last value decides.
            (Must::Settle, None) => true,
            (Must::Always | Must::Settle, _) => order.is_gt(),
            (Must::Eventually, _) => order.is_lt(),
        }
    }

    /// The verdict, and the breach at the decisive instant.
    fn verdict(self) -> (Verdict, f64) {
        let breach = match self.counts {
            Some((_, value)) => self.limits.breach(value),
            None => f64::INFINITY,
        };
        // A wheel called by its joint keeps that name.
        let name = match self.bound.signal.contains(EVERY_WHEEL) {
            true => &self.name,
            false => &self.bound.signal,
        };
        let mut verdict = verdict_of(self.bound, name, self.counts, breach <= 0.0);
        verdict.is_outside = !self.is_inside;
        (verdict, breach)
    }
}

fn verdict_of(bound: &SignalBound, name: &str, row: Option<(f64, f64)>, held: bool) -> Verdict {
    let limits: Bound = bound.bound();
    let window = match (bound.must, bound.until_s) {
        (Must::Settle, Some(until_s)) => format!("from {until_s} s on"),
        (Must::Settle, None) => "at the end".to_owned(),
        (must, until_s) => {
            let when = if must == Must::Always {
                "at all times"
            } else {
                "at some time"
            };
            let from = match bound.from_s {
                0.0 => String::new(),
                from_s => format!(" from {from_s} s"),
            };
            let until = until_s.map_or(String::new(), |until_s| format!(" until {until_s} s"));
            format!("{when}{from}{until}")
        }
    };
    Verdict {
        quantity: name.to_owned(),
        bound: format!("{limits} {window}"),
        measured: row.map(|(_, value)| value),
        at_s: row.map(|(t_s, _)| t_s),
        share_beyond: row.and_then(|(_, value)| limits.share_beyond(value)),
        is_short: row.is_some_and(|(_, value)| limits.is_above(value)),
        is_outside: false,
        held,
    }
}

/// The values of a signal, recorded or derived; `None` in rows without a value.
fn values(trace: &Trace, name: &str) -> Vec<Option<f64>> {
    let derived = |of: fn((f64, f64)) -> f64| {
        let errors = trace.records().iter();
        errors
            .map(|record| trace.header.tracking_error(record).map(of))
            .collect()
    };
    match name {
        "position_error_m" => derived(|(off_m, _)| off_m),
        "heading_error_rad" => derived(|(_, off_rad)| off_rad),
        name => trace.signal(name).unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use ilon_trace::{Record, WheelHeader, WheelSample};

    use super::*;

    /// Ten records a tenth of a second apart: x falls from 9 to 0, wheel 1 turns twice as fast as
    /// wheel 0.
    fn falling() -> Trace {
        let header = Header {
            wheels: vec![WheelHeader::default(); 2],
            control_dt_s: 0.1,
            ..Header::default()
        };
        let mut trace = Trace::with_capacity(header, 10);
        for step in 0..10 {
            let mut record = Record {
                t_s: 0.1 * f64::from(step),
                ..Record::default()
            };
            record.truth.pose.x_m = f64::from(9 - step);
            let wheel = |rate_rad_s| {
                WheelSample {
                    rate_rad_s,
                    ..WheelSample::default()
                }
                .steady()
            };
            trace.push(record, &[wheel(1.0), wheel(2.0)]);
        }
        trace
    }

    fn verdict(toml: &str) -> Verdict {
        let bound: SignalBound = toml::from_str(toml).expect("a bound");
        let Ok(mut verdicts) = judge(&[bound], &falling());
        verdicts.remove(0)
    }

    #[test]
    fn a_wheel_may_be_called_by_its_joint_and_no_hint_leads_to_another() {
        let wheel = |name: &str| WheelHeader {
            name: name.to_owned(),
            ..WheelHeader::default()
        };
        let header = Header {
            wheels: vec![wheel("left"), wheel("left_rear")],
            ..Header::default()
        };
        assert_eq!(header.recorded_name("left_rate_rad_s"), "wheel0_rate_rad_s");
        assert_eq!(
            header.recorded_name("left_rear_rate_rad_s"),
            "wheel1_rate_rad_s"
        );
        assert_eq!(header.recorded_name("truth_x_m"), "truth_x_m");
        assert!(check_names(["left_rear_rate_rad_s"], &header).is_ok());
        let said = |name: &str| {
            let fault = check_names([name], &header).expect_err("no such signal");
            format!("{fault:?}")
        };
        assert!(said("left_rear_rate_rad").contains("wheel1_rate_rad_s"));
        let unknown = said("wheel_left_zzz");
        assert!(!unknown.contains("did you mean"), "{unknown}");
        assert!(
            unknown.contains("wheel0 is left, wheel1 is left_rear"),
            "{unknown}"
        );
    }

    #[test]
    fn always_is_broken_by_one_instant_and_tells_the_worst() {
        assert!(verdict("signal = 'truth_x_m'\nmax = 9").held);
        let broken = verdict("signal = 'truth_x_m'\nmax = 5");
        assert!(!broken.held);
        assert_eq!((broken.measured, broken.at_s), (Some(9.0), Some(0.0)));
        assert!(verdict("signal = 'truth_x_m'\nmax = 5\nfrom_s = 0.4").held);
        assert!(!verdict("signal = 'truth_x_m'\nmax = 5\nfrom_s = 0.3").held);
    }

    #[test]
    fn eventually_asks_for_one_instant_within_its_window() {
        let text = "signal = 'truth_x_m'\nmust = 'eventually'\nequal = 4\n";
        assert!(verdict(text).held);
        let missed = verdict(&format!("{text}until_s = 0.4"));
        assert!(!missed.held);
        // The nearest approach: 5 at 0.4 s.
        assert_eq!((missed.measured, missed.at_s), (Some(5.0), Some(0.4)));
        assert!(verdict(&format!("{text}until_s = 0.5")).held);
    }

    /// Nothing is recorded in the window, or at all: no bound holds by that, and which of both it
    /// was is said.
    #[test]
    fn a_bound_on_what_was_never_seen_is_broken() {
        for (text, why) in [
            ("signal = 'truth_x_m'\nmax = 9\nfrom_s = 5", "in its window"),
            (
                "signal = 'position_error_m'\nmax = 9\nmust = 'settle'\nuntil_s = 5",
                "in its window",
            ),
            ("signal = 'position_error_m'\nmax = 9", "no path to follow"),
        ] {
            let verdict = verdict(text);
            assert_eq!((verdict.held, verdict.measured), (false, None), "{text}");
            assert!(verdict.to_string().contains(why), "{verdict}");
        }
    }

    #[test]
    fn a_verdict_names_a_wheel_as_the_bound_does() {
        for signal in ["rear_rate_rad_s", "wheel1_rate_rad_s"] {
            let mut trace = falling();
            trace.header.wheels[1].name = "rear".to_owned();
            let bound = format!("signal = '{signal}'\nmax = 1.5");
            let bound: SignalBound = toml::from_str(&bound).expect("a bound");
            let Ok(verdicts) = judge(&[bound], &trace);
            assert_eq!(
                (&*verdicts[0].quantity, verdicts[0].measured),
                (signal, Some(2.0))
            );
        }
    }

    #[test]
    fn settled_means_from_then_on_to_the_end() {
        let text = "signal = 'truth_x_m'\nmust = 'settle'\nmax = 3\n";
        assert!(verdict(&format!("{text}until_s = 0.6")).held);
        assert!(!verdict(&format!("{text}until_s = 0.5")).held);
        assert!(verdict(text).held);
    }

    #[test]
    fn a_bound_on_every_wheel_tells_the_worst_wheel() {
        let broken = verdict("signal = 'wheel*_rate_rad_s'\nmax = 1.5");
        assert!(!broken.held);
        assert_eq!(broken.quantity, "wheel1_rate_rad_s");
        assert_eq!(
            broken.to_string(),
            "wheel1_rate_rad_s <= 1.5 at all times failed: measured 2 rad/s at 0 s (33 % beyond)"
        );
    }

    #[test]
    fn what_misses_a_lower_bound_is_short_of_it() {
        let broken = verdict("signal = 'wheel*_rate_rad_s'\nmin = 4").to_string();
        assert!(broken.ends_with(" % short)"), "{broken}");
        let above = verdict("signal = 'wheel*_rate_rad_s'\nmin = 0\nmax = 1.5").to_string();
        assert!(above.ends_with(" % beyond)"), "{above}");
    }

    #[test]
    fn a_signal_that_does_not_exist_is_refused_with_the_nearest() {
        let header = falling().header;
        assert!(
            check_names(
                ["truth_x_m", "wheel*_rate_rad_s", "position_error_m"],
                &header
            )
            .is_ok()
        );
        let refused = check_names(["wheel*_rat_rad_s"], &header);
        match refused {
            Err(Error::Invalid { message, help }) => {
                assert_eq!(
                    message,
                    "there is no signal `wheel*_rat_rad_s` in a trace of this run"
                );
                assert_eq!(help, "did you mean `wheel*_rate_rad_s`?");
            }
            other => panic!("{other:?}"),
        }
    }
}
