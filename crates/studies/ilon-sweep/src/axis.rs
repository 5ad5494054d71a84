//! One axis of a study: a key of the scenario, and the values that it takes.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};
use toml::Value;

use crate::file::Scale;

/// What is varied.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Axis {
    /// The key of the scenario, with dots.
    pub key: String,
    /// The values that it takes.
    pub values: Values,
}

/// The values of an axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Values {
    /// One of these, each as probable as the others.
    List(Vec<Value>),
    /// Numbers from one end to the other.
    Range {
        /// The first.
        from: f64,
        /// The last.
        to: f64,
        /// How many, both ends among them; without it, all between.
        steps: Option<u64>,
        /// How they are spaced.
        scale: Scale,
        /// Whether they are whole numbers.
        whole: bool,
    },
    /// A normal distribution, cut off at `min` and `max`.
    Normal {
        /// Its mean, before it is cut off.
        mean: f64,
        /// Its standard deviation, before it is cut off.
        sd: f64,
        /// Where it begins.
        min: f64,
        /// Where it ends.
        max: f64,
    },
}

/// Draws of a distribution that goes on for ever keep off its ends by this share, 8.2 standard deviations of a normal one: at the ends
/// it is infinite.
const TAIL: f64 = 1.0 / (1u64 << 53) as f64;

impl Axis {
    /// How many values it has; `None` of one that has all between its ends.
    pub fn count(&self) -> Option<u64> {
        match &self.values {
            Values::List(values) => Some(values.len() as u64),
            Values::Range { steps, .. } => *steps,
            Values::Normal { .. } => None,
        }
    }

    /// One of its values, of an axis that has a number of them.
    pub fn nth(&self, index: u64) -> Value {
        match &self.values {
            Values::List(values) => values[index as usize % values.len()].clone(),
            Values::Range {
                steps: Some(steps), ..
            } if *steps > 1 => self.between(index as f64 / (*steps - 1) as f64),
            _ => self.between(0.0),
        }
    }

    /// The value at a share of its distribution, in [0, 1].
    pub fn at(&self, share: f64) -> Value {
        match self.count() {
            Some(count) => {
                let index = (share * count as f64).floor().max(0.0) as u64;
                self.nth(index.min(count.saturating_sub(1)))
            }
            None => self.between(share),
        }
    }

    /// The number at a share of the way, or of the distribution.
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
                // Each whole number has the way up to the next, the last one too.
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

/// A value as a text: one that is a text by itself, all others as TOML.
pub fn text_of(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// A value that is a number.
pub fn number_of(value: &Value) -> Option<f64> {
    match value {
        Value::Float(number) => Some(*number),
        Value::Integer(number) => Some(*number as f64),
        _ => None,
    }
}

/// A place between two ends.
pub(crate) fn along(from: f64, to: f64, scale: Scale, share: f64) -> f64 {
    match scale {
        Scale::Linear => from + share * (to - from),
        Scale::Log => from * libm::pow(to / from, share),
    }
}

/// A number without the noise of its last digits, so that it reads well where it is copied.
pub(crate) fn rounded(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}

/// How many points a grid over some axes has.
pub(crate) fn grid_points(axes: &[Axis]) -> u64 {
    axes.iter()
        .map(|axis| axis.count().unwrap_or(1))
        .fold(1, u64::saturating_mul)
}
