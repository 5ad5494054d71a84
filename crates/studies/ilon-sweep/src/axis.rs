//! One axis of a study: a key of the scenario and its values.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};
use toml::Value;

use crate::file::Scale;

/// A varied key.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Axis {
    /// Dotted key of the scenario.
    pub key: String,
    /// Its values.
    pub values: Values,
}

/// The values of an axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Values {
    /// A list of equally probable values.
    List(Vec<Value>),
    /// A range of numbers.
    Range {
        /// The first.
        from: f64,
        /// The last.
        to: f64,
        /// Number of values, including both ends; without it, all values between.
        steps: Option<u64>,
        /// Spacing of the values.
        scale: Scale,
        /// Whether they are integers.
        whole: bool,
    },
    /// A normal distribution, truncated at `min` and `max`.
    Normal {
        /// Mean before truncation.
        mean: f64,
        /// Standard deviation before truncation.
        sd: f64,
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
}

/// Draws from an infinite distribution keep this share from its ends, 8.2 standard deviations of a
/// normal one: at the ends it is infinite.
const TAIL: f64 = 1.0 / (1u64 << 53) as f64;

impl Axis {
    /// The number of values; `None` for a continuous axis.
    pub fn count(&self) -> Option<u64> {
        match &self.values {
            Values::List(values) => Some(values.len() as u64),
            Values::Range { steps, .. } => *steps,
            Values::Normal { .. } => None,
        }
    }

    /// Returns one of its values, for an axis with a finite number of them.
    pub fn nth(&self, index: u64) -> Value {
        match &self.values {
            Values::List(values) => values[index as usize % values.len()].clone(),
            Values::Range {
                steps: Some(steps), ..
            } if *steps > 1 => self.between(index as f64 / (*steps - 1) as f64),
            _ => self.between(0.0),
        }
    }

    /// Returns the value at a share of its distribution, in [0, 1].
    pub fn at(&self, share: f64) -> Value {
        match self.count() {
            Some(count) => {
                let index = (share * count as f64).floor().max(0.0) as u64;
                self.nth(index.min(count.saturating_sub(1)))
            }
            None => self.between(share),
        }
    }

    /// Returns the number at a share of the range, or of the distribution.
    fn between(&self, share: f64) -> Value {
        match self.values {
            Values::List(_) => self.at(share),
            Values::Range {
                from,
                to,
                steps: None,
                scale,
                whole: true,
            } => {
                // Each integer has the interval up to the next, including the last.
                let x = along(from, to + 1.0, scale, share).floor();
                Value::Integer(x.clamp(from, to) as i64)
            }
            Values::Range {
                from,
                to,
                scale,
                whole: true,
                ..
            } => Value::Integer(along(from, to, scale, share).round() as i64),
            Values::Range {
                from, to, scale, ..
            } => Value::Float(rounded(along(from, to, scale, share))),
            Values::Normal { mean, sd, min, max } => {
                let Ok(normal) = Normal::new(mean, sd) else {
                    return Value::Float(mean);
                };
                let (least, most) = (normal.cdf(min), normal.cdf(max));
                let below = least + share * (most - least);
                let x = normal.inverse_cdf(below.clamp(TAIL, 1.0 - TAIL));
                Value::Float(rounded(x.clamp(min, max)))
            }
        }
    }

    /// Whether its values are numbers.
    pub fn is_numeric(&self) -> bool {
        match &self.values {
            Values::List(values) => values.iter().all(|value| number_of(value).is_some()),
            _ => true,
        }
    }
}

/// Returns a value as text: strings unquoted, all others as TOML.
pub fn text_of(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// Returns a value as a number, if it is one.
pub fn number_of(value: &Value) -> Option<f64> {
    match value {
        Value::Float(number) => Some(*number),
        Value::Integer(number) => Some(*number as f64),
        _ => None,
    }
}

/// Returns the point at a share between two ends.
pub(crate) fn along(from: f64, to: f64, scale: Scale, share: f64) -> f64 {
    match scale {
        Scale::Linear => from + share * (to - from),
        Scale::Log => from * libm::pow(to / from, share),
    }
}

/// Rounds away the noise in a number's last digits, so that it is readable where it is copied.
pub(crate) fn rounded(x: f64) -> f64 {
    ilon_trace::significant(x, 12)
}

/// Returns the number of points of a grid over axes.
pub(crate) fn grid_points(axes: &[Axis]) -> u64 {
    axes.iter()
        .map(|axis| axis.count().unwrap_or(1))
        .fold(1, u64::saturating_mul)
}
