//! YAML files of properties, read like xacro: by the rules of YAML 1.1, in which `yes` is true and
//! `1e3` is text, and with xacro's units, such as `!degrees 90`.

use std::collections::HashMap;
use std::f64::consts::PI;

use saphyr_parser::{Event, Parser, ScalarStyle, Tag};

use super::python::{Dict, Error, Surroundings, Value, check_nesting, evaluate};

/// Deepest nesting.
const DEEPEST: usize = 64;

/// Returns the value of a YAML file.
pub(super) fn load(text: &str, around: &dyn Surroundings) -> Result<Value, Error> {
    around.budget().spend_bytes(text.len())?;
    let mut reader = Reader {
        around,
        anchors: HashMap::new(),
        open: Vec::new(),
        root: None,
    };
    let mut documents = 0;
    for event in Parser::new_from_str(text) {
        let (event, span) =
            event.map_err(|e| Error::new(format!("line {}: {}", e.marker().line(), e.info())))?;
        around.budget().spend(1)?;
        if matches!(event, Event::DocumentStart(_)) {
            documents += 1;
            if documents > 1 {
                return Err(Error::new("it holds more than one document"));
            }
        }
        reader
            .event(event)
            .map_err(|e| e.within(format!("line {}", span.start.line())))?;
    }
    Ok(reader.root.unwrap_or(Value::None))
}

/// An unclosed list or dictionary, with its anchor.
enum Open {
    List(usize, Vec<Value>),
    /// The entries so far, separately those of merged dictionaries, and a key without value yet.
    Dict(usize, Vec<(Value, Value)>, Dict, Option<Value>),
}

struct Reader<'a> {
    around: &'a dyn Surroundings,
    anchors: HashMap<usize, Value>,
    open: Vec<Open>,
    root: Option<Value>,
}

impl Reader<'_> {
    fn event(&mut self, event: Event) -> Result<(), Error> {
        match event {
            Event::Scalar(text, style, anchor, tag) => {
                self.around.budget().spend_bytes(text.len())?;
                let value = self.scalar(&text, style, tag.as_deref())?;
                self.add(anchor, value)
            }
            Event::Alias(anchor) => {
                let value = self.anchors.get(&anchor).cloned();
                let value = value.ok_or_else(|| Error::new("an alias refers to itself"))?;
                self.add(0, value)
            }
            Event::SequenceStart(anchor, _) => self.begin(Open::List(anchor, Vec::new())),
            Event::MappingStart(anchor, _) => {
                self.begin(Open::Dict(anchor, Vec::new(), Dict::default(), None))
            }
            Event::SequenceEnd | Event::MappingEnd => match self.open.pop() {
                Some(Open::List(anchor, items)) => self.add(anchor, Value::list(items)),
                Some(Open::Dict(anchor, entries, mut dict, _)) => {
                    for (key, value) in entries {
                        self.around.budget().spend_on(&key)?;
                        dict.insert(key, value)?;
                    }
                    self.add(anchor, Value::Dict(dict.into()))
                }
                None => Ok(()),
            },
            _ => Ok(()),
        }
    }

    fn begin(&mut self, open: Open) -> Result<(), Error> {
        if self.open.len() >= DEEPEST {
            return Err(Error::new(format!(
                "it nests more than {DEEPEST} levels deep"
            )));
        }
        self.open.push(open);
        Ok(())
    }

    fn add(&mut self, anchor: usize, value: Value) -> Result<(), Error> {
        // Aliases can nest deeper than brackets.
        check_nesting(&value)?;
        if anchor != 0 {
            self.anchors.insert(anchor, value.clone());
        }
        match self.open.last_mut() {
            None => self.root = Some(value),
            Some(Open::List(_, items)) => items.push(value),
            Some(Open::Dict(_, _, _, key @ None)) => *key = Some(value),
            Some(Open::Dict(_, entries, merged, waiting)) => {
                let key = waiting.take().unwrap_or(Value::None);
                match (&key, &value) {
                    (Value::Text(text), Value::Dict(other)) if &**text == "<<" => {
                        self.around.budget().spend(other.entries().len() as u64)?;
                        for (key, value) in other.entries() {
                            merged.insert(key.clone(), value.clone())?;
                        }
                    }
                    _ => entries.push((key, value)),
                }
            }
        }
        Ok(())
    }

    fn scalar(&self, text: &str, style: ScalarStyle, tag: Option<&Tag>) -> Result<Value, Error> {
        if let Some(tag) = tag {
            let unit = match (tag.handle.as_str(), tag.suffix.as_str()) {
                ("!", "radians" | "meters") => Some(1.0),
                ("!", "degrees") => Some(PI / 180.0),
                ("!", "millimeters") => Some(0.001),
                ("!", "foot") => Some(0.3048),
                ("!", "inches") => Some(0.0254),
                ("!", other) => {
                    return Err(Error::new(format!("the tag !{other} is not known")));
                }
                (_, "str") => return Ok(Value::text(text)),
                _ => None,
            };
            if let Some(unit) = unit {
                let value = evaluate(text, self.around)?;
                let number = super::python::number(&value)
                    .ok_or_else(|| Error::new(format!("`{text}` is not a number")))?;
                return Ok(Value::Float(number * unit));
            }
        }
        Ok(match style {
            ScalarStyle::Plain => plain(text),
            _ => Value::text(text),
        })
    }
}

/// Returns the value of an unquoted text.
fn plain(text: &str) -> Value {
    match text {
        "" | "~" | "null" | "Null" | "NULL" => return Value::None,
        "yes" | "Yes" | "YES" | "true" | "True" | "TRUE" | "on" | "On" | "ON" => {
            return Value::Bool(true);
        }
        "no" | "No" | "NO" | "false" | "False" | "FALSE" | "off" | "Off" | "OFF" => {
            return Value::Bool(false);
        }
        ".nan" | ".NaN" | ".NAN" => return Value::Float(f64::NAN),
        _ => {}
    }
    let bare = text.strip_prefix(['+', '-']).unwrap_or(text);
    let negative = text.starts_with('-');
    if matches!(bare, ".inf" | ".Inf" | ".INF") {
        return Value::Float(if negative {
            f64::NEG_INFINITY
        } else {
            f64::INFINITY
        });
    }
    if let Some(int) = int(bare) {
        return Value::Int(if negative { -int } else { int });
    }
    match float(bare, bare.len() != text.len()) {
        Some(float) => Value::Float(if negative { -float } else { float }),
        None => Value::text(text),
    }
}

fn int(text: &str) -> Option<i128> {
    let radix = |digits: &str, radix: u32| {
        let plain = digits.replace('_', "");
        let all = plain.bytes().all(|b| char::from(b).is_digit(radix));
        (all && !plain.is_empty()).then(|| i128::from_str_radix(&plain, radix).ok())?
    };
    if let Some(digits) = text.strip_prefix("0b") {
        return radix(digits, 2);
    }
    if let Some(digits) = text.strip_prefix("0x") {
        return radix(digits, 16);
    }
    if text == "0" {
        return Some(0);
    }
    if let Some(digits) = text.strip_prefix('0') {
        return radix(digits, 8);
    }
    if text.contains(':') {
        return sexagesimal(text).map(|x| x as i128);
    }
    text.starts_with(|c: char| c.is_ascii_digit())
        .then(|| radix(text, 10))?
}

/// `1:30` is ninety.
fn sexagesimal(text: &str) -> Option<f64> {
    let mut parts = text.split(':');
    let first = parts.next()?.replace('_', "");
    if first.is_empty() || !first.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let mut sum: f64 = first.parse().ok()?;
    for part in parts {
        let two_digits = (1..=2).contains(&part.len()) && part.bytes().all(|b| b.is_ascii_digit());
        let digit: f64 = part.parse().ok().filter(|_| two_digits)?;
        if digit >= 60.0 {
            return None;
        }
        sum = sum * 60.0 + digit;
    }
    Some(sum)
}

/// Parses a number with a point; an exponent must have its sign.
fn float(text: &str, signed: bool) -> Option<f64> {
    let (mantissa, exponent) = match text.find(['e', 'E']) {
        Some(at) => (&text[..at], Some(&text[at + 1..])),
        None => (text, None),
    };
    let (whole, fraction) = mantissa.split_once('.')?;
    let digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit() || b == b'_');
    let exponent_is_good = exponent.is_none_or(|exponent| {
        exponent
            .strip_prefix(['+', '-'])
            .is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()))
    });
    let starts_well = if whole.is_empty() {
        !signed && fraction.starts_with(|c: char| c.is_ascii_digit())
    } else {
        whole.starts_with(|c: char| c.is_ascii_digit())
    };
    let well_formed = digits(whole) && digits(fraction) && exponent_is_good && starts_well;
    well_formed
        .then(|| text.replace('_', "").parse().ok())
        .flatten()
}

#[cfg(test)]
mod tests {
    use super::super::python::brief;
    use super::plain;

    #[test]
    fn plain_scalars_follow_yaml_1_1() {
        for (text, value) in [
            ("yes", "True"),
            ("off", "False"),
            ("~", "None"),
            ("12", "12"),
            ("-0x1F", "-31"),
            ("010", "8"),
            ("1_000", "1000"),
            ("1:30", "90"),
            ("1.5", "1.5"),
            ("1.", "1.0"),
            (".5", "0.5"),
            // Without a sign in the exponent, or without a digit before the point, it is no number
            // in YAML 1.1.
            ("-.5", "'-.5'"),
            ("1e3", "'1e3'"),
            ("1.0e3", "'1.0e3'"),
            ("1.0e+3", "1000.0"),
            ("-.inf", "-inf"),
            ("09", "'09'"),
            ("wheel", "'wheel'"),
        ] {
            assert_eq!(brief(&plain(text)), value, "{text}");
        }
    }
}
