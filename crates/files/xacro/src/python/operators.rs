//! The operators.

use std::cmp::Ordering;

use super::format::percent;
use super::surroundings::Surroundings;
use super::value::{Error, Value};

/// An integer beyond the supported 38 digits.
pub(super) fn too_large() -> Error {
    Error::new("a whole number of more than 38 digits")
}

fn unsupported(sign: &str, p: &Value, q: &Value) -> Error {
    Error::new(format!(
        "unsupported operand type(s) for {sign}: '{}' and '{}'",
        p.kind(),
        q.kind()
    ))
}

/// Applies a binary operator.
pub(super) fn binary(
    sign: &str,
    p: &Value,
    q: &Value,
    around: &dyn Surroundings,
) -> Result<Value, Error> {
    match (sign, p, q) {
        ("+", Value::Text(p), Value::Text(q)) => {
            around.budget().spend_bytes(p.len() + q.len())?;
            Ok(Value::text(format!("{p}{q}")))
        }
        ("+", Value::List(p), Value::List(q)) => {
            around.budget().spend((p.len() + q.len()) as u64)?;
            Ok(Value::list(p.iter().chain(q.iter()).cloned().collect()))
        }
        ("+", Value::Tuple(p), Value::Tuple(q)) => {
            around.budget().spend((p.len() + q.len()) as u64)?;
            Ok(Value::tuple(p.iter().chain(q.iter()).cloned().collect()))
        }
        ("*", Value::Text(_) | Value::List(_) | Value::Tuple(_), _) => repeat(p, q, around),
        ("*", _, Value::Text(_) | Value::List(_) | Value::Tuple(_)) => repeat(q, p, around),
        ("%", Value::Text(template), _) => percent(template, q, around),
        _ => match (p.as_int(), q.as_int()) {
            (Some(i), Some(j)) => of_ints(sign, i, j, p, q),
            _ => match (p.as_float(), q.as_float()) {
                (Some(x), Some(y)) => of_floats(sign, x, y, p, q),
                _ => Err(unsupported(sign, p, q)),
            },
        },
    }
}

fn repeat(sequence: &Value, count: &Value, around: &dyn Surroundings) -> Result<Value, Error> {
    let count = count
        .as_int()
        .ok_or_else(|| unsupported("*", sequence, count))?;
    let count = usize::try_from(count.max(0)).map_err(|_| too_large())?;
    let repeated = |items: &[Value]| -> Result<Vec<Value>, Error> {
        let length = items.len().saturating_mul(count);
        around.budget().spend(length as u64)?;
        Ok(items.iter().cycle().take(length).cloned().collect())
    };
    match sequence {
        Value::Text(text) => {
            around
                .budget()
                .spend_bytes(text.len().saturating_mul(count))?;
            Ok(Value::text(text.repeat(count)))
        }
        Value::List(items) => Ok(Value::list(repeated(items)?)),
        Value::Tuple(items) => Ok(Value::tuple(repeated(items)?)),
        other => Err(unsupported("*", other, &Value::Int(0))),
    }
}

fn of_ints(sign: &str, i: i128, j: i128, p: &Value, q: &Value) -> Result<Value, Error> {
    let kept = |result: Option<i128>| result.map(Value::Int).ok_or_else(too_large);
    let both_bool = matches!((p, q), (Value::Bool(_), Value::Bool(_)));
    let bits = |result: i128| {
        Ok(if both_bool {
            Value::Bool(result != 0)
        } else {
            Value::Int(result)
        })
    };
    match sign {
        "+" => kept(i.checked_add(j)),
        "-" => kept(i.checked_sub(j)),
        "*" => kept(i.checked_mul(j)),
        "/" if j == 0 => Err(Error::new("division by zero")),
        "/" => Ok(Value::Float(i as f64 / j as f64)),
        "//" | "%" if j == 0 => Err(Error::new("integer division or modulo by zero")),
        "//" => kept(floor_div(i, j)),
        "%" => kept(floor_div(i, j).map(|d| i - d * j)),
        "&" => bits(i & j),
        "|" => bits(i | j),
        "^" => bits(i ^ j),
        "<<" | ">>" if j < 0 => Err(Error::new("negative shift count")),
        "<<" => kept(
            u32::try_from(j)
                .ok()
                .filter(|j| *j < 127)
                .and_then(|j| i.checked_mul(1 << j))
                .or((i == 0).then_some(0)),
        ),
        ">>" => Ok(Value::Int(i >> j.min(127))),
        _ => Err(unsupported(sign, p, q)),
    }
}

/// Returns i / j rounded towards minus infinity.
fn floor_div(i: i128, j: i128) -> Option<i128> {
    let quotient = i.checked_div(j)?;
    let inexact = i % j != 0 && (i < 0) != (j < 0);
    Some(quotient - i128::from(inexact))
}

fn of_floats(sign: &str, x: f64, y: f64, p: &Value, q: &Value) -> Result<Value, Error> {
    let float = |x| Ok(Value::Float(x));
    match sign {
        "+" => float(x + y),
        "-" => float(x - y),
        "*" => float(x * y),
        "/" if y == 0.0 => Err(Error::new("float division by zero")),
        "/" => float(x / y),
        "//" if y == 0.0 => Err(Error::new("float floor division by zero")),
        "%" if y == 0.0 => Err(Error::new("float modulo")),
        "//" => float(float_divmod(x, y).0),
        "%" => float(float_divmod(x, y).1),
        _ => Err(unsupported(sign, p, q)),
    }
}

/// Floor division and remainder like Python: the remainder has the divisor's sign.
pub(super) fn float_divmod(x: f64, y: f64) -> (f64, f64) {
    let mut remainder = x % y;
    let mut quotient = (x - remainder) / y;
    if remainder == 0.0 {
        remainder = 0f64.copysign(y);
    } else if (y < 0.0) != (remainder < 0.0) {
        remainder += y;
        quotient -= 1.0;
    }
    let floor = if quotient == 0.0 {
        0f64.copysign(x / y)
    } else {
        let floor = quotient.floor();
        if quotient - floor > 0.5 {
            floor + 1.0
        } else {
            floor
        }
    };
    (floor, remainder)
}

/// p ** q.
pub(super) fn power(p: &Value, q: &Value) -> Result<Value, Error> {
    if let (Some(base), Some(exponent)) = (p.as_int(), q.as_int())
        && exponent >= 0
    {
        let small = match base {
            0 | 1 => Some(if exponent == 0 { 1 } else { base }),
            -1 => Some(if exponent % 2 == 0 { 1 } else { -1 }),
            _ => u32::try_from(exponent)
                .ok()
                .and_then(|exponent| base.checked_pow(exponent)),
        };
        return small.map(Value::Int).ok_or_else(too_large);
    }
    let (Some(x), Some(y)) = (p.as_float(), q.as_float()) else {
        return Err(unsupported("** or pow()", p, q));
    };
    if x == 0.0 && y < 0.0 {
        return Err(Error::new("0.0 cannot be raised to a negative power"));
    }
    if x < 0.0 && x.is_finite() && y.is_finite() && y.fract() != 0.0 {
        return Err(Error::new(
            "a negative number raised to a fraction is complex, which no URDF holds",
        ));
    }
    let z = pxfm::f_pow(x, y);
    if z.is_infinite() && x.is_finite() && y.is_finite() {
        return Err(Error::new("the result of ** is too large"));
    }
    Ok(Value::Float(z))
}

/// Applies a unary operator.
pub(super) fn unary(sign: &str, p: &Value) -> Result<Value, Error> {
    let wrong = || Error::new(format!("bad operand type for unary {sign}: '{}'", p.kind()));
    match (sign, p.as_int()) {
        ("not", _) => Ok(Value::Bool(!p.truth())),
        ("-", Some(i)) => i.checked_neg().map(Value::Int).ok_or_else(too_large),
        ("+", Some(i)) => Ok(Value::Int(i)),
        ("~", Some(i)) => Ok(Value::Int(!i)),
        ("-", None) => p.as_float().map(|x| Value::Float(-x)).ok_or_else(wrong),
        ("+", None) => p.as_float().map(Value::Float).ok_or_else(wrong),
        _ => Err(wrong()),
    }
}

/// Applies a comparison.
pub(super) fn compare(
    operator: &str,
    p: &Value,
    q: &Value,
    around: &dyn Surroundings,
) -> Result<bool, Error> {
    let is_looked_for = operator.ends_with("in");
    let gone_through = match q {
        // A key is found without visiting the others.
        Value::Dict(_) | Value::Namespace(_) if is_looked_for => p,
        container if is_looked_for => container,
        // A comparison ends with the shorter of the two.
        _ if p.size().bytes < q.size().bytes => p,
        _ => q,
    };
    around.budget().spend_on(gone_through)?;
    match operator {
        "==" => Ok(p.equals(q)),
        "!=" => Ok(!p.equals(q)),
        "is" => Ok(is_same(p, q)),
        "is not" => Ok(!is_same(p, q)),
        "in" => contains(q, p, around),
        "not in" => contains(q, p, around).map(|held| !held),
        _ => {
            let order = order(p, q).map_err(|()| {
                Error::new(format!(
                    "'{operator}' not supported between instances of '{}' and '{}'",
                    p.kind(),
                    q.kind()
                ))
            })?;
            Ok(match operator {
                "<" => order == Some(Ordering::Less),
                "<=" => matches!(order, Some(Ordering::Less | Ordering::Equal)),
                ">" => order == Some(Ordering::Greater),
                _ => matches!(order, Some(Ordering::Greater | Ordering::Equal)),
            })
        }
    }
}

fn is_same(p: &Value, q: &Value) -> bool {
    p.kind() == q.kind() && p.equals(q)
}

/// Returns the order of two values: `None` with NaN, an error for values without an order.
pub(super) fn order(p: &Value, q: &Value) -> Result<Option<Ordering>, ()> {
    match (p, q) {
        (Value::Text(p), Value::Text(q)) => Ok(Some(p.cmp(q))),
        (Value::List(p), Value::List(q)) | (Value::Tuple(p), Value::Tuple(q)) => {
            for (p, q) in p.iter().zip(q.iter()) {
                if !p.equals(q) {
                    return order(p, q);
                }
            }
            Ok(Some(p.len().cmp(&q.len())))
        }
        _ => match (p.as_int(), q.as_int()) {
            (Some(i), Some(j)) => Ok(Some(i.cmp(&j))),
            _ => match (p.as_float(), q.as_float()) {
                (Some(x), Some(y)) => Ok(x.partial_cmp(&y)),
                _ => Err(()),
            },
        },
    }
}

fn contains(container: &Value, item: &Value, around: &dyn Surroundings) -> Result<bool, Error> {
    match (container, item) {
        (Value::Text(text), Value::Text(part)) => Ok(text.contains(&**part)),
        (Value::List(items) | Value::Tuple(items), _) => {
            Ok(items.iter().any(|other| other.equals(item)))
        }
        (Value::Dict(dict), _) => Ok(dict.get(item)?.is_some()),
        (Value::Namespace(names), Value::Text(name)) => {
            Ok(around.look_up_in(names, name)?.is_some())
        }
        _ => Err(Error::new(format!(
            "argument of type '{}' is not iterable",
            container.kind()
        ))),
    }
}
