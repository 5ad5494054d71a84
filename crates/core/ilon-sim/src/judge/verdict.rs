//! The verdict on one expectation, as text.

use ilon_trace::{number, quantities, significant, to_microseconds};

/// The verdict on one expectation.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Verdict {
    /// The quantity's dotted name.
    pub quantity: String,
    /// The bound as text, such as `<= 0.01`.
    pub bound: String,
    /// The measured value, of a signal at its worst; `None` if it does not apply to this run.
    pub measured: Option<f64>,
    /// Time of the worst value of a signal, in seconds; `None` for a quantity of the whole run.
    pub at_s: Option<f64>,
    /// Breach as a share of the broken limit; `None` if the bound held, or the limit is zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_beyond: Option<f64>,
    /// Whether the value is below the bound, of which it may also be above.
    #[serde(skip)]
    pub is_short: bool,
    /// Whether no row of the run lies in the window of a signal's bound.
    #[serde(skip)]
    pub is_outside: bool,
    /// Whether the bound held.
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
            is_short,
            is_outside,
            held,
        } = self;
        let verb = if *held { "held" } else { "failed" };
        write!(f, "{quantity} {bound} {verb}: ")?;
        let Some(measured) = measured else {
            const OUTSIDE: &str = "no row of the run lies in its window; move the window, or let `run.duration_s` be longer";
            let why = is_outside.then_some(OUTSIDE);
            let why = why.or_else(|| quantities::needs(quantity));
            let why = why.map_or_else(String::new, |why| format!(": {why}"));
            return write!(f, "it does not apply to this run{why}");
        };
        write!(f, "measured {}", readable(*measured, bound))?;
        match quantities::si_unit(quantity) {
            "" => {}
            unit => write!(f, " {unit}")?,
        }
        if let Some(at_s) = at_s {
            write!(f, " at {} s", number(to_microseconds(*at_s)))?;
        }
        let way = if *is_short { "short" } else { "beyond" };
        match share_beyond.map(|share| 100.0 * share) {
            Some(percent) if percent >= 1000.0 => {
                write!(f, " ({way} by more than ten times the bound)")
            }
            Some(percent) if percent >= 10.0 => write!(f, " ({percent:.0} % {way})"),
            Some(percent) if percent >= 0.01 => write!(f, " ({percent:.2} % {way})"),
            Some(_) => write!(f, " (less than 0.01 % {way})"),
            None => Ok(()),
        }
    }
}

/// A value with four digits; with six, or all, where fewer would look equal to a number of the
/// bound, or be on its other side.
pub(super) fn readable(value: f64, bound: &str) -> String {
    let bounds = || {
        bound
            .split_whitespace()
            .filter_map(|word| word.parse::<f64>().ok())
    };
    let mut rounded = [4, 6].map(|digits| significant(value, digits)).into_iter();
    let differs = rounded.find(|rounded| {
        bounds().all(|bound| rounded.partial_cmp(&bound) == value.partial_cmp(&bound))
    });
    number(differs.unwrap_or(value))
}
