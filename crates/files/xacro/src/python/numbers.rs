//! Python's functions on numbers.

use super::brief;
use super::operators::{binary, float_divmod, too_large};
use super::surroundings::Surroundings;
use super::value::{Error, Value, parse_float, parse_int};

pub(super) fn to_float(value: &Value) -> Result<Value, Error> {
    let float = match value {
        Value::Text(text) => parse_float(text),
        other => other.as_float(),
    };
    float
        .map(Value::Float)
        .ok_or_else(|| Error::new(format!("could not convert to float: {}", brief(value))))
}

pub(super) fn to_int(value: &Value) -> Result<Value, Error> {
    let int = match value {
        Value::Text(text) => parse_int(text),
        Value::Float(x) if x.is_finite() => {
            if x.abs() > 1e38 {
                return Err(too_large());
            }
            Some(x.trunc() as i128)
        }
        other => other.as_int(),
    };
    int.map(Value::Int)
        .ok_or_else(|| Error::new(format!("invalid literal for int(): {}", brief(value))))
}

/// Rounds halves to even, by the binary value and not by the written digits.
pub(super) fn round(value: &Value, digits: Option<&Value>) -> Result<Value, Error> {
    let digits = match digits {
        None | Some(Value::None) => None,
        Some(digits) => Some(
            digits
                .as_int()
                .ok_or_else(|| Error::new("round() takes a whole number of digits"))?,
        ),
    };
    match (value.as_int(), value.as_float(), digits) {
        (Some(i), _, None) => Ok(Value::Int(i)),
        (Some(i), _, Some(digits)) if digits >= 0 => Ok(Value::Int(i)),
        (Some(i), _, Some(digits)) => {
            let unit = u32::try_from(-digits)
                .ok()
                .and_then(|places| 10i128.checked_pow(places));
            Ok(Value::Int(unit.map_or(0, |unit| round_to(i, unit))))
        }
        (None, Some(x), None) => {
            if !x.is_finite() {
                return Err(Error::new("cannot round what is not finite to an integer"));
            }
            to_int(&Value::Float(x.round_ties_even()))
        }
        (None, Some(x), Some(digits)) => {
            if !x.is_finite() || digits > 400 {
                return Ok(Value::Float(x));
            }
            let rounded = if digits >= 0 {
                format!("{x:.*}", digits as usize).parse().unwrap_or(x)
            } else {
                let unit = 10f64.powi(i32::try_from(-digits).unwrap_or(400));
                if unit.is_finite() {
                    (x / unit).round_ties_even() * unit
                } else {
                    0f64.copysign(x)
                }
            };
            Ok(Value::Float(rounded))
        }
        (None, None, _) => Err(Error::new(format!(
            "type {} doesn't define __round__ method",
            value.kind()
        ))),
    }
}

fn round_to(i: i128, unit: i128) -> i128 {
    let below = i.div_euclid(unit);
    let rest = i.rem_euclid(unit);
    let up = match (2 * rest).cmp(&unit) {
        std::cmp::Ordering::Less => false,
        std::cmp::Ordering::Greater => true,
        std::cmp::Ordering::Equal => below % 2 != 0,
    };
    (below + i128::from(up)).saturating_mul(unit)
}

pub(super) fn divmod(p: &Value, q: &Value, around: &dyn Surroundings) -> Result<Value, Error> {
    let (quotient, remainder) = match (p.as_int(), q.as_int(), p.as_float(), q.as_float()) {
        (Some(_), Some(_), ..) => (binary("//", p, q, around)?, binary("%", p, q, around)?),
        (.., Some(x), Some(y)) if y != 0.0 => {
            let (quotient, remainder) = float_divmod(x, y);
            (Value::Float(quotient), Value::Float(remainder))
        }
        _ => return Err(Error::new("unsupported operand type(s) for divmod()")),
    };
    Ok(Value::tuple(vec![quotient, remainder]))
}
