//! Python's `math`.
//!
//! The functions are correctly rounded, so that an expansion is the same on every machine. The C
//! library used by Python is off by the last bit in one of some hundred to a thousand arguments.

use std::f64::consts::{E, PI, TAU};

use super::operators::too_large;
use super::surroundings::{Surroundings, elements};
use super::value::{Error, Value};

const CONSTANTS: [(&str, f64); 5] = [
    ("pi", PI),
    ("e", E),
    ("tau", TAU),
    ("inf", f64::INFINITY),
    ("nan", f64::NAN),
];

type OfOne = fn(f64) -> f64;

/// Functions of one number that are defined wherever their result is a number.
const OF_ONE: [(&str, OfOne); 28] = [
    ("sin", pxfm::f_sin),
    ("cos", pxfm::f_cos),
    ("tan", pxfm::f_tan),
    ("asin", pxfm::f_asin),
    ("acos", pxfm::f_acos),
    ("atan", pxfm::f_atan),
    ("sinh", pxfm::f_sinh),
    ("cosh", pxfm::f_cosh),
    ("tanh", pxfm::f_tanh),
    ("asinh", pxfm::f_asinh),
    ("acosh", pxfm::f_acosh),
    ("atanh", pxfm::f_atanh),
    ("exp", pxfm::f_exp),
    ("exp2", pxfm::f_exp2),
    ("expm1", pxfm::f_expm1),
    ("log10", pxfm::f_log10),
    ("log2", pxfm::f_log2),
    ("log1p", pxfm::f_log1p),
    ("cbrt", pxfm::f_cbrt),
    ("erf", pxfm::f_erf),
    ("erfc", pxfm::f_erfc),
    ("gamma", pxfm::f_tgamma),
    ("lgamma", pxfm::f_lgamma),
    ("sqrt", f64::sqrt),
    ("fabs", f64::abs),
    ("radians", |x| x * (PI / 180.0)),
    ("degrees", |x| x * (180.0 / PI)),
    ("ulp", ulp),
];

type OfTwo = fn(f64, f64) -> f64;

const OF_TWO: [(&str, OfTwo); 5] = [
    ("atan2", pxfm::f_atan2),
    ("copysign", f64::copysign),
    ("fmod", |x, y| x % y),
    ("pow", pxfm::f_pow),
    ("remainder", libm::remainder),
];

/// All other functions.
const OTHERS: &str = "floor ceil trunc log hypot isnan isinf isfinite isclose gcd lcm factorial comb perm isqrt fsum prod dist modf ldexp";

fn ulp(x: f64) -> f64 {
    x.abs().next_up() - x.abs()
}

/// Returns the value of a name of `math`.
pub(super) fn value(name: &str) -> Option<Value> {
    if let Some((_, constant)) = CONSTANTS.iter().find(|(known, _)| *known == name) {
        return Some(Value::Float(*constant));
    }
    let of_numbers = OF_ONE.iter().map(|(known, _)| *known);
    let of_numbers = of_numbers.chain(OF_TWO.iter().map(|(known, _)| *known));
    let mut functions = of_numbers.chain(OTHERS.split(' '));
    functions.find(|known| *known == name).map(Value::Function)
}

fn float(value: &Value) -> Result<f64, Error> {
    value
        .as_float()
        .ok_or_else(|| Error::new(format!("must be real number, not {}", value.kind())))
}

pub(super) fn int(value: &Value) -> Result<i128, Error> {
    value.as_int().ok_or_else(|| {
        Error::new(format!(
            "'{}' object cannot be interpreted as an integer",
            value.kind()
        ))
    })
}

/// Rejects a NaN result of arguments that are numbers, and an infinite one of finite arguments.
fn defined(result: f64, arguments: &[f64]) -> Result<Value, Error> {
    if result.is_nan() && !arguments.iter().any(|x| x.is_nan()) {
        return Err(Error::new("math domain error"));
    }
    if result.is_infinite() && arguments.iter().all(|x| x.is_finite()) {
        return Err(Error::new("math range error"));
    }
    Ok(Value::Float(result))
}

/// Calls a function of `math`; `None` if it does not exist.
pub(super) fn call(
    name: &str,
    items: &[Value],
    around: &dyn Surroundings,
) -> Result<Option<Value>, Error> {
    if let Some((_, function)) = OF_ONE.iter().find(|(known, _)| *known == name) {
        let [x] = items else {
            return Err(wrong_count(name, 1, items));
        };
        let x = float(x)?;
        return defined(function(x), &[x]).map(Some);
    }
    if let Some((_, function)) = OF_TWO.iter().find(|(known, _)| *known == name) {
        let [x, y] = items else {
            return Err(wrong_count(name, 2, items));
        };
        let (x, y) = (float(x)?, float(y)?);
        return defined(function(x, y), &[x, y]).map(Some);
    }
    if OTHERS.split(' ').any(|known| known == name) {
        return other(name, items, around).map(Some);
    }
    Ok(None)
}

fn wrong_count(name: &str, wanted: usize, items: &[Value]) -> Error {
    Error::new(format!(
        "{name}() takes {wanted} argument(s), {} given",
        items.len()
    ))
}

fn other(name: &str, items: &[Value], around: &dyn Surroundings) -> Result<Value, Error> {
    let floats = |items: &[Value]| items.iter().map(float).collect::<Result<Vec<f64>, _>>();
    match (name, items) {
        ("floor" | "ceil" | "trunc", [value]) => match value.as_int() {
            Some(i) => Ok(Value::Int(i)),
            None => {
                let x = float(value)?;
                let whole = match name {
                    "floor" => x.floor(),
                    "ceil" => x.ceil(),
                    _ => x.trunc(),
                };
                if !whole.is_finite() {
                    return Err(Error::new(format!("cannot {name} what is not finite")));
                }
                if whole.abs() > 1e38 {
                    return Err(too_large());
                }
                Ok(Value::Int(whole as i128))
            }
        },
        ("log", [x]) => {
            let x = float(x)?;
            positive(x)?;
            defined(pxfm::f_log(x), &[x])
        }
        ("log", [x, base]) => {
            let (x, base) = (float(x)?, float(base)?);
            positive(x)?;
            positive(base)?;
            if base == 1.0 {
                return Err(Error::new("float division by zero"));
            }
            defined(pxfm::f_log(x) / pxfm::f_log(base), &[x, base])
        }
        ("hypot", _) => Ok(Value::Float(norm(&floats(items)?))),
        ("dist", [p, q]) => {
            let (p, q) = (
                floats(&elements(p, around)?)?,
                floats(&elements(q, around)?)?,
            );
            if p.len() != q.len() {
                return Err(Error::new(
                    "both points must have the same number of dimensions",
                ));
            }
            let apart: Vec<f64> = p.iter().zip(&q).map(|(p, q)| p - q).collect();
            Ok(Value::Float(norm(&apart)))
        }
        ("isnan", [x]) => Ok(Value::Bool(float(x)?.is_nan())),
        ("isinf", [x]) => Ok(Value::Bool(float(x)?.is_infinite())),
        ("isfinite", [x]) => Ok(Value::Bool(float(x)?.is_finite())),
        ("isclose", [x, y]) => {
            let (x, y) = (float(x)?, float(y)?);
            let finite = x.is_finite() && y.is_finite();
            let close = x == y || (finite && (x - y).abs() <= 1e-9 * x.abs().max(y.abs()));
            Ok(Value::Bool(close))
        }
        ("gcd", _) => {
            let mut all = 0;
            for item in items {
                all = gcd(all, int(item)?);
            }
            Ok(Value::Int(all))
        }
        ("lcm", _) => {
            let mut all: i128 = 1;
            for item in items {
                let i = int(item)?.checked_abs().ok_or_else(too_large)?;
                if i == 0 {
                    return Ok(Value::Int(0));
                }
                all = (all / gcd(all, i)).checked_mul(i).ok_or_else(too_large)?;
            }
            Ok(Value::Int(all))
        }
        ("factorial", [n]) => {
            let n = int(n)?;
            if n < 0 {
                return Err(Error::new("factorial() not defined for negative values"));
            }
            // 34! exceeds the supported range.
            product((1..=n.min(40)).map(Some))
        }
        ("comb" | "perm", [n, k]) => {
            let (n, k) = (int(n)?, int(k)?);
            if n < 0 || k < 0 {
                return Err(Error::new(format!("{name}() takes no negative numbers")));
            }
            if k > n {
                return Ok(Value::Int(0));
            }
            if name == "perm" {
                return product((0..k.min(200)).map(|i| n.checked_sub(i)));
            }
            let mut all: i128 = 1;
            for i in 0..k.min(n - k).min(200) {
                all = all.checked_mul(n - i).ok_or_else(too_large)? / (i + 1);
            }
            Ok(Value::Int(all))
        }
        ("isqrt", [n]) => {
            let n = int(n)?;
            if n < 0 {
                return Err(Error::new("isqrt() argument must be nonnegative"));
            }
            Ok(Value::Int(n.isqrt()))
        }
        ("fsum", [source]) => Ok(Value::Float(exact_sum(&floats(&elements(
            source, around,
        )?)?))),
        ("prod", [source]) => {
            let mut all = Value::Int(1);
            for item in elements(source, around)? {
                all = super::operators::binary("*", &all, &item, around)?;
            }
            Ok(all)
        }
        ("modf", [x]) => {
            let x = float(x)?;
            let whole = x.trunc();
            let fraction = if x.is_infinite() { 0.0 } else { x - whole };
            let parts = [fraction.copysign(x), whole].map(Value::Float);
            Ok(Value::tuple(parts.into()))
        }
        ("ldexp", [x, exponent]) => {
            let x = float(x)?;
            let exponent = int(exponent)?.clamp(-5000, 5000) as i32;
            defined(libm::ldexp(x, exponent), &[x])
        }
        _ => Err(Error::new(format!("{name}() takes other arguments"))),
    }
}

fn positive(x: f64) -> Result<(), Error> {
    if x <= 0.0 {
        return Err(Error::new("math domain error"));
    }
    Ok(())
}

fn gcd(p: i128, q: i128) -> i128 {
    let (mut p, mut q) = (p.saturating_abs(), q.saturating_abs());
    while q != 0 {
        (p, q) = (q, p % q);
    }
    p
}

fn product(factors: impl Iterator<Item = Option<i128>>) -> Result<Value, Error> {
    let mut all: i128 = 1;
    for factor in factors {
        all = factor
            .and_then(|factor| all.checked_mul(factor))
            .ok_or_else(too_large)?;
    }
    Ok(Value::Int(all))
}

/// Returns the length of a vector, scaled by a power of two so that squares neither overflow nor
/// underflow, and summed exactly.
fn norm(parts: &[f64]) -> f64 {
    let largest = parts.iter().fold(0f64, |m, x| m.max(x.abs()));
    if parts.iter().any(|x| x.is_infinite()) {
        return f64::INFINITY;
    }
    if parts.iter().any(|x| x.is_nan()) || largest == 0.0 {
        return parts.iter().fold(largest, |m, x| m + x.abs());
    }
    let (_, exponent) = libm::frexp(largest);
    let scale = libm::ldexp(1.0, -exponent);
    // Each square as an exact sum of two numbers; then their sum, rounded once.
    let mut terms = Vec::with_capacity(2 * parts.len());
    for part in parts {
        let x = part * scale;
        let square = x * x;
        terms.push(square);
        terms.push(libm::fma(x, x, -square));
    }
    let sum = exact_sum(&terms);
    let root = sum.sqrt();
    // One Newton step with the exact remainder, which makes the root correct to its last bit.
    terms.push(-root * root);
    terms.push(-libm::fma(root, root, -root * root));
    let rest = exact_sum(&terms);
    libm::ldexp(root + rest / (2.0 * root), exponent)
}

/// Returns the sum of numbers, rounded once, by non-overlapping partial sums (Shewchuk 1997).
fn exact_sum(numbers: &[f64]) -> f64 {
    let mut partials: Vec<f64> = Vec::new();
    for &number in numbers {
        let mut x = number;
        let mut kept = 0;
        for i in 0..partials.len() {
            let mut y = partials[i];
            if x.abs() < y.abs() {
                std::mem::swap(&mut x, &mut y);
            }
            let high = x + y;
            let low = y - (high - x);
            if low != 0.0 {
                partials[kept] = low;
                kept += 1;
            }
            x = high;
        }
        partials.truncate(kept);
        partials.push(x);
    }
    // The largest partial sums first; if the rest is half of a last place, the smaller ones decide.
    let mut partials = partials.into_iter().rev();
    let mut sum = partials.next().unwrap_or(0.0);
    let mut low = 0.0;
    for x in partials.by_ref() {
        let high = sum + x;
        low = x - (high - sum);
        sum = high;
        if low != 0.0 {
            break;
        }
    }
    if let Some(next) = partials.next()
        && low != 0.0
        && (low < 0.0) == (next < 0.0)
    {
        let twice = low * 2.0;
        let up = sum + twice;
        if up - sum == twice {
            sum = up;
        }
    }
    sum
}
