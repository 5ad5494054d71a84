//! Ranks differences by their share of the signal's span in the baseline.

use ilon_trace::{Difference, Rows, number};

use crate::text::{angle, energy, length, percent, speed};
use ilon_trace::significant;

/// A differing signal with its weight.
pub(super) struct Ranked<'a> {
    pub one: &'a Difference,
    /// The largest difference over the signal's span in the baseline.
    pub share: f64,
}

/// Smallest spans, by the end of the signal's name: a signal with a smaller span only jitters, and
/// differences are relative to this span.
const LEAST_SPANS: [(&str, f64); 8] = [
    ("_rad_s", 1e-2),
    ("_m_s", 1e-2),
    ("_n_m", 1e-2),
    ("_rad", 1e-2),
    ("_m", 1e-2),
    ("_n", 1.0),
    ("_j", 1e-2),
    ("_w", 1e-1),
];

/// Weight of discrete signals, such as the touching roller, which change with every hand-over, one
/// row sooner or later.
const OF_WHAT_ONLY_COUNTS: f64 = 0.01;

/// Returns the differing signals, the most important first.
///
/// # Errors
/// If the rows cannot be read.
pub(super) fn ranked<'a, R: Rows>(
    found: &'a [Difference],
    baseline: &R,
) -> Result<Vec<Ranked<'a>>, R::Error> {
    let mut all: Vec<Ranked> = Vec::with_capacity(found.len());
    for one in found {
        // A signal that only the run has gives no value of the baseline.
        let values = baseline.values(&one.signal)?;
        let finite = values.into_iter().flatten().filter(|x| x.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        all.push(Ranked {
            one,
            share: share(&one.signal, one.worst, (high - low).max(0.0)),
        });
    }
    all.sort_by(|a, b| {
        let is_index = a.one.is_roller_index().cmp(&b.one.is_roller_index());
        is_index.then(b.share.total_cmp(&a.share))
    });
    Ok(all)
}

fn share(signal: &str, worst: f64, span: f64) -> f64 {
    let least = LEAST_SPANS
        .iter()
        .find(|(end, _)| signal.ends_with(end))
        .map(|(_, least)| *least);
    let share = match worst.is_finite() {
        true => worst / span.max(least.unwrap_or(1.0)),
        // Only one of them has a value somewhere.
        false => 1.0,
    };
    match least {
        Some(_) => share,
        None => share * OF_WHAT_ONLY_COUNTS,
    }
}

/// Returns a value of a signal with its unit, as text.
pub(super) fn value(signal: &str, x: f64) -> String {
    if !x.is_finite() {
        return "no value in one of them".to_owned();
    }
    let with = |unit: &str| format!("{} {unit}", plain(x));
    let ends = |end: &str| signal.ends_with(end);
    // Very small values are written out: a difference in the last bits is one too.
    let small = x != 0.0 && x.abs() < 1e-6;
    match () {
        () if ends("_rad_s") => with("rad/s"),
        () if ends("_m_s") && !small => speed(x),
        () if ends("_m_s") => with("m/s"),
        () if ends("_n_m") => with("N m"),
        () if ends("_rad") && !small => angle(x),
        () if ends("_rad") => with("rad"),
        () if ends("_m") && !small => length(x),
        () if ends("_m") => with("m"),
        () if ends("_n") => with("N"),
        () if ends("_j") && !small => energy(x),
        () if ends("_j") => with("J"),
        () if ends("_w") => with("W"),
        () if ends("_s") => with("s"),
        () => plain(x),
    }
}

/// Returns a share of the span of a signal as text.
pub(super) fn of_its_span(share: f64) -> String {
    match share < 2.0 {
        true => format!("{} of its span", percent(share)),
        false => format!("{share:.0} times its span"),
    }
}

/// Returns the tolerance of a signal as text.
pub(super) fn allowed(signal: &str, tolerance: f64) -> String {
    match tolerance > 0.0 {
        true => format!("{} is allowed", value(signal, tolerance)),
        false => "it should be equal to the bit".to_owned(),
    }
}

fn plain(x: f64) -> String {
    number(significant(x, 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_weighs_by_its_part_of_what_the_signal_does() {
        // 1 mm of a metre, and 1 mm of a signal that only jitters by a micrometre.
        assert!((share("truth_x_m", 1e-3, 1.0) - 1e-3).abs() < 1e-15);
        assert!((share("truth_z_m", 1e-3, 1e-6) - 0.1).abs() < 1e-15);
        // Nanoradians of a level robot are negligible, and another touching roller nearly so.
        assert!(share("truth_roll_rad", 1e-9, 1e-9) < 1e-6);
        assert!(share("wheel0_roller", 8.0, 8.0) < share("wheel0_torque_n_m", 0.1, 2.0));
        assert!((share("desired_x_m", f64::INFINITY, 0.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn values_are_read_with_their_units() {
        assert_eq!(value("truth_x_m", 0.0012), "1.20 mm");
        assert_eq!(value("truth_x_m", 3.14e-9), "3.14e-9 m");
        assert_eq!(value("wheel0_torque_n_m", 0.012_345), "0.0123 N m");
        assert_eq!(value("wheel0_roller", 8.0), "8");
    }
}
