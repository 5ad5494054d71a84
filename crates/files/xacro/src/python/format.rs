//! Values as text: Python's `str`, `repr` and `%`.

use super::super::budget::Budget;
use super::super::spent::Spent;
use super::surroundings::Surroundings;
use super::value::{Error, Value};

/// Formats a value like `str`, after charging for it.
pub(in super::super) fn text(value: &Value, budget: &Budget) -> Result<String, Spent> {
    match value {
        Value::Text(text) => {
            budget.spend_bytes(text.len())?;
            Ok(text.to_string())
        }
        other => repr(other, budget),
    }
}

/// Formats a value like `repr`, after charging for it.
pub(in super::super) fn repr(value: &Value, budget: &Budget) -> Result<String, Spent> {
    budget.spend_on(value)?;
    let mut out = String::new();
    write(value, &mut out, usize::MAX);
    Ok(out)
}

/// Returns the start of a value in the format of `repr`, for a message.
pub(in super::super) fn brief(value: &Value) -> String {
    const MOST_CHARS: usize = 60;
    let mut out = String::new();
    write(value, &mut out, 4 * MOST_CHARS);
    match out.char_indices().nth(MOST_CHARS) {
        Some((end, _)) => format!("{}...", &out[..end]),
        None => out,
    }
}

/// Writes a value until there are `most` bytes, or one value more.
fn write(value: &Value, out: &mut String, most: usize) {
    if out.len() > most {
        return;
    }
    match value {
        Value::None => out.push_str("None"),
        Value::Bool(true) => out.push_str("True"),
        Value::Bool(false) => out.push_str("False"),
        Value::Int(i) => out.push_str(&i.to_string()),
        Value::Float(x) => out.push_str(&float_text(*x)),
        Value::Text(text) => write_quoted(text, out, most),
        Value::List(items) => write_row("[", items, "]", out, most),
        Value::Tuple(items) if items.len() == 1 => write_row("(", items, ",)", out, most),
        Value::Tuple(items) => write_row("(", items, ")", out, most),
        Value::Dict(dict) => {
            out.push('{');
            for (i, (key, value)) in dict.entries().iter().enumerate() {
                if out.len() > most {
                    break;
                }
                out.push_str(if i > 0 { ", " } else { "" });
                write(key, out, most);
                out.push_str(": ");
                write(value, out, most);
            }
            out.push('}');
        }
        other => out.push_str(&format!("<{}>", other.kind())),
    }
}

fn write_row(open: &str, items: &[Value], close: &str, out: &mut String, most: usize) {
    out.push_str(open);
    for (i, item) in items.iter().enumerate() {
        if out.len() > most {
            break;
        }
        out.push_str(if i > 0 { ", " } else { "" });
        write(item, out, most);
    }
    out.push_str(close);
}

fn write_quoted(text: &str, out: &mut String, most: usize) {
    let quote = if text.contains('\'') && !text.contains('"') {
        '"'
    } else {
        '\''
    };
    out.push(quote);
    for c in text.chars() {
        if out.len() > most {
            break;
        }
        match c {
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\t' => out.push_str("\\t"),
            '\r' => out.push_str("\\r"),
            c if c == quote => {
                out.push('\\');
                out.push(c);
            }
            c if (c as u32) < 0x20 || c as u32 == 0x7f => {
                out.push_str(&format!("\\x{:02x}", c as u32));
            }
            c => out.push(c),
        }
    }
    out.push(quote);
}

/// Formats a number like Python: the fewest digits that read back as the same value, with an
/// exponent from 1e16 on and below 1e-4.
pub(in super::super) fn float_text(x: f64) -> String {
    if x.is_nan() {
        return "nan".to_owned();
    }
    if x.is_infinite() {
        return if x > 0.0 { "inf" } else { "-inf" }.to_owned();
    }
    let scientific = format!("{x:e}");
    let (_, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..16).contains(&exponent) {
        let plain = format!("{x}");
        return if plain.contains('.') {
            plain
        } else {
            plain + ".0"
        };
    }
    python_exponent(&scientific)
}

/// `template % values`.
pub(super) fn percent(
    template: &str,
    values: &Value,
    around: &dyn Surroundings,
) -> Result<Value, Error> {
    around.budget().spend_bytes(template.len())?;
    // Lists and dictionaries count as used, even if nothing of them is written.
    let container = matches!(values, Value::List(_) | Value::Dict(_));
    let values: Vec<Value> = match values {
        Value::Tuple(items) => {
            around.budget().spend(items.len() as u64)?;
            items.to_vec()
        }
        single => vec![single.clone()],
    };
    let mut values = values.into_iter();
    let mut out = String::new();
    let mut rest = template;
    while let Some(at) = rest.find('%') {
        out.push_str(&rest[..at]);
        let (field, length) = Field::read(&rest[at + 1..])?;
        rest = &rest[at + 1 + length..];
        if field.kind == '%' {
            out.push('%');
            continue;
        }
        let value = values
            .next()
            .ok_or_else(|| Error::new("not enough arguments for format string"))?;
        around
            .budget()
            .spend_bytes(field.width.max(field.places()))?;
        out.push_str(&field.write(&value, around.budget())?);
    }
    if values.next().is_some() && !container {
        return Err(Error::new(
            "not all arguments converted during string formatting",
        ));
    }
    out.push_str(rest);
    Ok(Value::text(out))
}

/// A conversion such as `%05.2f`.
struct Field {
    left: bool,
    zeros: bool,
    plus: bool,
    space: bool,
    width: usize,
    precision: Option<usize>,
    kind: char,
}

impl Field {
    /// Parses the text after the `%`; returns the field and its size in bytes.
    fn read(text: &str) -> Result<(Self, usize), Error> {
        let incomplete = || Error::new("incomplete or unknown format after %");
        let flags_end = text.find(|c| !"-+ 0#".contains(c)).ok_or_else(incomplete)?;
        let flags = &text[..flags_end];
        let number = |from: usize| -> (Option<usize>, usize) {
            let digits = text[from..].bytes().take_while(u8::is_ascii_digit).count();
            (text[from..from + digits].parse().ok(), from + digits)
        };
        let (width, mut at) = number(flags_end);
        let mut precision = None;
        if text[at..].starts_with('.') {
            let (places, end) = number(at + 1);
            precision = Some(places.unwrap_or(0));
            at = end;
        }
        let kind = text[at..].chars().next().ok_or_else(incomplete)?;
        if !"diusrfFeEgGxXoc%".contains(kind) {
            return Err(incomplete());
        }
        let field = Self {
            left: flags.contains('-'),
            zeros: flags.contains('0'),
            plus: flags.contains('+'),
            space: flags.contains(' '),
            width: width.unwrap_or(0),
            precision,
            kind,
        };
        // No number has more digits than this, and none is worth the memory.
        if field.width > 10_000 || field.places() > 1_000 {
            return Err(Error::new("a format is wider than 10000 characters"));
        }
        Ok((field, at + kind.len_utf8()))
    }

    fn places(&self) -> usize {
        self.precision.unwrap_or(6)
    }

    fn write(&self, value: &Value, budget: &Budget) -> Result<String, Error> {
        let number_wanted = || {
            Error::new(format!(
                "%{} format: a number is required, not {}",
                self.kind,
                value.kind()
            ))
        };
        let whole = || value.as_int().ok_or_else(number_wanted);
        let int = || match value {
            Value::Float(x) if x.is_finite() => Ok(x.trunc() as i128),
            _ => whole(),
        };
        let float = || value.as_float().ok_or_else(number_wanted);
        let (negative, body) = match self.kind {
            'd' | 'i' | 'u' => (int()? < 0, int()?.unsigned_abs().to_string()),
            'x' => (whole()? < 0, format!("{:x}", whole()?.unsigned_abs())),
            'X' => (whole()? < 0, format!("{:X}", whole()?.unsigned_abs())),
            'o' => (whole()? < 0, format!("{:o}", whole()?.unsigned_abs())),
            'f' | 'F' | 'e' | 'E' | 'g' | 'G' => {
                let x = float()?;
                let negative = x.is_sign_negative() && !x.is_nan();
                (negative, self.float_body(x.abs()))
            }
            'c' => match value {
                Value::Text(_) => (false, text(value, budget)?),
                _ => {
                    let code = u32::try_from(int()?).ok().and_then(char::from_u32);
                    (false, code.ok_or_else(number_wanted)?.to_string())
                }
            },
            _ => {
                let whole = if self.kind == 'r' {
                    repr(value, budget)?
                } else {
                    text(value, budget)?
                };
                let cut = match self.precision {
                    Some(most) => whole.chars().take(most).collect(),
                    None => whole,
                };
                return Ok(self.padded("", &cut, false));
            }
        };
        let sign = match (negative, self.plus, self.space) {
            (true, ..) => "-",
            (false, true, _) => "+",
            (false, false, true) => " ",
            _ => "",
        };
        Ok(self.padded(sign, &body, self.zeros && self.kind != 'c'))
    }

    fn float_body(&self, x: f64) -> String {
        if !x.is_finite() {
            return float_text(x);
        }
        let places = self.places();
        let body = match self.kind.to_ascii_lowercase() {
            'f' => format!("{x:.places$}"),
            'e' => exponential(x, places),
            _ => general(x, places.max(1)),
        };
        if self.kind.is_ascii_uppercase() {
            body.to_uppercase()
        } else {
            body
        }
    }

    fn padded(&self, sign: &str, body: &str, zeros: bool) -> String {
        let length = sign.len() + body.chars().count();
        let fill = self.width.saturating_sub(length);
        match (self.left, zeros) {
            (true, _) => format!("{sign}{body}{}", " ".repeat(fill)),
            (false, true) => format!("{sign}{}{body}", "0".repeat(fill)),
            (false, false) => format!("{}{sign}{body}", " ".repeat(fill)),
        }
    }
}

/// `%e`: an exponent of two digits or more.
fn exponential(x: f64, places: usize) -> String {
    python_exponent(&format!("{x:.places$e}"))
}

/// Returns `1.5e7` as `1.5e+07`.
fn python_exponent(scientific: &str) -> String {
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{mantissa}e{sign}{:02}", exponent.abs())
}

/// `%g`: a number of significant digits, without trailing zeros.
fn general(x: f64, digits: usize) -> String {
    let scientific = exponential(x, digits - 1);
    let exponent: i32 = scientific
        .split_once('e')
        .and_then(|(_, exponent)| exponent.parse().ok())
        .unwrap_or(0);
    let without_zeros = |text: &str| {
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text.to_owned()
        }
    };
    if exponent < -4 || exponent >= digits as i32 {
        let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "+00"));
        return format!("{}e{exponent}", without_zeros(mantissa));
    }
    let places = (digits as i32 - 1 - exponent).max(0) as usize;
    without_zeros(&format!("{x:.places$}"))
}
