//! What came of one expectation, in words.

use ilon_trace::{number, quantities, to_microseconds};

/// What came of one expectation.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Verdict {
    /// The quantity's dotted name.
    pub quantity: String,
    /// The bound in words, such as `<= 0.01`.
    pub bound: String,
    /// What was measured, of a signal where it was worst; `None` where it does not apply to this run.
    pub measured: Option<f64>,
    /// When a signal was worst, in seconds; `None` of a quantity of the whole run.
    pub at_s: Option<f64>,
    /// How far it was beyond the limit that it broke, as a share of that limit; `None` where it held, and of a limit of zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_beyond: Option<f64>,
    /// Whether it held.
    pub held: bool,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            quantity,
            bound,
            measured,
            at_s,
            share_beyond,
            held,
        } = self;
        let verb = if *held { "held" } else { "failed" };
        write!(f, "{quantity} {bound} {verb}: ")?;
        let Some(measured) = measured else {
            return write!(f, "it does not apply to this run");
        };
        write!(f, "measured {}", readable(*measured, bound))?;
        match quantities::si_unit(quantity) {
            "" => {}
            unit => write!(f, " {unit}")?,
        }
        if let Some(at_s) = at_s {
            write!(f, " at {} s", number(to_microseconds(*at_s)))?;
        }
        match share_beyond.map(|share| 100.0 * share) {
            Some(percent) if percent >= 1000.0 => {
                write!(f, " (beyond by more than ten times the bound)")
            }
            Some(percent) if percent >= 10.0 => write!(f, " ({percent:.0} % beyond)"),
            Some(percent) if percent >= 0.01 => write!(f, " ({percent:.2} % beyond)"),
            Some(_) => write!(f, " (less than 0.01 % beyond)"),
            None => Ok(()),
        }
    }
}

/// A value with six digits; with all of them, where so few would be those of its bound.
fn readable(value: f64, bound: &str) -> String {
    let rounded = format!("{value:.5e}").parse().map_or(value, |x: f64| x);
    let rounded = number(rounded);
    match bound.contains(&rounded) {
        true => number(value),
        false => rounded,
    }
}
