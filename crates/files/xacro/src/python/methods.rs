//! Methods of values: `"front left".split()`, `list.index(x)`, `dict.get(key, default)`.

use super::surroundings::{Arguments, Surroundings, elements};
use super::text;
use super::value::{Error, Value};

const OF_TEXT: &str = "lower upper title capitalize strip lstrip rstrip split join replace startswith endswith find rfind index count isdigit isalpha isalnum isspace zfill rjust ljust splitlines";

/// Returns the name of a dictionary's method, if it exists.
pub(super) fn of_dict(name: &str) -> Option<&'static str> {
    ["keys", "values", "items", "get", "copy"]
        .into_iter()
        .find(|known| *known == name)
}

/// Returns the name of a value's method, if it exists.
pub(super) fn of(value: &Value, name: &str) -> Option<&'static str> {
    let known = match value {
        Value::Text(_) => OF_TEXT,
        Value::List(_) | Value::Tuple(_) => "index count",
        Value::Float(_) => "is_integer",
        _ => return None,
    };
    known.split(' ').find(|known| *known == name)
}

/// Calls a method.
pub(super) fn call(
    around: &dyn Surroundings,
    value: &Value,
    name: &'static str,
    arguments: Arguments,
) -> Result<Value, Error> {
    let budget = around.budget();
    arguments.refuse_named(name)?;
    match (value, name, arguments.items.as_slice()) {
        (Value::Text(text), _, items) => {
            budget.spend_bytes(text.len())?;
            items.iter().try_for_each(|item| budget.spend_on(item))?;
            of_text(around, text, name, items)
        }
        (Value::Dict(dict), _, items) => {
            budget.spend(dict.entries().len() as u64)?;
            items.iter().try_for_each(|item| budget.spend_on(item))?;
            let entries = dict.entries().iter();
            match (name, items) {
                ("keys", []) => Ok(Value::list(entries.map(|(key, _)| key.clone()).collect())),
                ("values", []) => Ok(Value::list(
                    entries.map(|(_, value)| value.clone()).collect(),
                )),
                ("items", []) => {
                    let pair = |(key, value): &(Value, Value)| {
                        Value::tuple(vec![key.clone(), value.clone()])
                    };
                    Ok(Value::list(entries.map(pair).collect()))
                }
                ("copy", []) => Ok(value.clone()),
                ("get", [key]) => Ok(dict.get(key)?.cloned().unwrap_or(Value::None)),
                ("get", [key, default]) => Ok(dict.get(key)?.cloned().unwrap_or(default.clone())),
                _ => wrong(name),
            }
        }
        (Value::List(items) | Value::Tuple(items), _, [item]) => {
            budget.spend_on(value)?;
            let mut equal = items
                .iter()
                .enumerate()
                .filter(|(_, other)| other.equals(item));
            match name {
                "count" => Ok(Value::Int(equal.count() as i128)),
                _ => match equal.next() {
                    Some((i, _)) => Ok(Value::Int(i as i128)),
                    None => Err(Error::new(format!("{} is not in list", super::brief(item)))),
                },
            }
        }
        (Value::Float(x), "is_integer", []) => Ok(Value::Bool(x.fract() == 0.0)),
        _ => wrong(name),
    }
}

fn wrong(name: &str) -> Result<Value, Error> {
    Err(Error::new(format!("{name}() takes other arguments")))
}

fn of_text(
    around: &dyn Surroundings,
    of: &str,
    name: &str,
    items: &[Value],
) -> Result<Value, Error> {
    let budget = around.budget();
    let made = |made: String| {
        budget.spend_bytes(made.len())?;
        Ok(Value::text(made))
    };
    let place = |place: Option<usize>| {
        let chars = place.map(|at| of[..at].chars().count() as i128);
        Value::Int(chars.unwrap_or(-1))
    };
    let parts = |parts: &mut dyn Iterator<Item = &str>| {
        let paid = parts.map(|part| budget.spend(1).map(|()| Value::text(part)));
        Ok(Value::list(paid.collect::<Result<_, _>>()?))
    };
    if let ("strip" | "lstrip" | "rstrip", [Value::Text(set)]) = (name, items) {
        budget.spend_bytes(of.len().saturating_mul(set.len()))?;
    }
    match (name, items) {
        ("lower", []) => made(of.to_lowercase()),
        ("upper", []) => made(of.to_uppercase()),
        ("capitalize", []) => made(capitalized(of)),
        ("title", []) => {
            let mut out = String::new();
            for word in of.split_inclusive(|c: char| !c.is_alphabetic()) {
                out.push_str(&capitalized(word));
            }
            made(out)
        }
        ("strip", []) => made(of.trim().to_owned()),
        ("lstrip", []) => made(of.trim_start().to_owned()),
        ("rstrip", []) => made(of.trim_end().to_owned()),
        ("strip", [Value::Text(set)]) => made(of.trim_matches(|c| set.contains(c)).to_owned()),
        ("lstrip", [Value::Text(set)]) => {
            made(of.trim_start_matches(|c| set.contains(c)).to_owned())
        }
        ("rstrip", [Value::Text(set)]) => made(of.trim_end_matches(|c| set.contains(c)).to_owned()),
        ("split", []) => parts(&mut of.split_whitespace()),
        ("split", [Value::Text(separator)]) if !separator.is_empty() => {
            parts(&mut of.split(&**separator))
        }
        ("split", [Value::Text(separator), most]) if !separator.is_empty() => {
            let most = most.as_int().filter(|most| *most >= 0);
            let count = most.map_or(usize::MAX, |most| {
                usize::try_from(most)
                    .unwrap_or(usize::MAX)
                    .saturating_add(1)
            });
            parts(&mut of.splitn(count, &**separator))
        }
        ("splitlines", []) => parts(&mut of.lines()),
        ("join", [parts]) => {
            let parts = elements(parts, around)?;
            if let Some(other) = parts.iter().find(|part| !matches!(part, Value::Text(_))) {
                return Err(Error::new(format!(
                    "join() takes texts, not '{}'",
                    other.kind()
                )));
            }
            budget.spend_bytes(of.len().saturating_mul(parts.len()))?;
            let parts = parts.iter().map(|part| text(part, budget));
            Ok(Value::text(parts.collect::<Result<Vec<_>, _>>()?.join(of)))
        }
        ("replace", [Value::Text(from), Value::Text(to)]) => {
            let count = of.matches(&**from).count();
            budget.spend_bytes(of.len() + count.saturating_mul(to.len()))?;
            Ok(Value::text(of.replace(&**from, to)))
        }
        ("startswith", [Value::Text(part)]) => Ok(Value::Bool(of.starts_with(&**part))),
        ("endswith", [Value::Text(part)]) => Ok(Value::Bool(of.ends_with(&**part))),
        ("find", [Value::Text(part)]) => Ok(place(of.find(&**part))),
        ("rfind", [Value::Text(part)]) => Ok(place(of.rfind(&**part))),
        ("index", [Value::Text(part)]) => match of.find(&**part) {
            Some(at) => Ok(place(Some(at))),
            None => Err(Error::new("substring not found")),
        },
        ("count", [Value::Text(part)]) => {
            let count = if part.is_empty() {
                of.chars().count() + 1
            } else {
                of.matches(&**part).count()
            };
            Ok(Value::Int(count as i128))
        }
        ("isdigit", []) => Ok(all_are(of, char::is_numeric)),
        ("isalpha", []) => Ok(all_are(of, char::is_alphabetic)),
        ("isalnum", []) => Ok(all_are(of, char::is_alphanumeric)),
        ("isspace", []) => Ok(all_are(of, char::is_whitespace)),
        ("zfill" | "rjust" | "ljust", [width, fill @ ..]) if fill.len() <= 1 => {
            let width = width
                .as_int()
                .and_then(|width| usize::try_from(width.max(0)).ok());
            let Some(width) = width else {
                return wrong(name);
            };
            let fill = match (name, fill) {
                ("zfill", _) => "0".to_owned(),
                (_, [fill]) => text(fill, budget)?,
                _ => " ".to_owned(),
            };
            if fill.chars().count() != 1 {
                return wrong(name);
            }
            let missing = width.saturating_sub(of.chars().count());
            budget.spend_bytes(missing)?;
            let padding = fill.repeat(missing);
            let signed = name == "zfill" && of.starts_with(['+', '-']);
            Ok(Value::text(match name {
                "ljust" => format!("{of}{padding}"),
                _ if signed => format!("{}{padding}{}", &of[..1], &of[1..]),
                _ => format!("{padding}{of}"),
            }))
        }
        _ => wrong(name),
    }
}

fn capitalized(word: &str) -> String {
    let mut chars = word.chars();
    match chars.next() {
        Some(first) => first
            .to_uppercase()
            .chain(chars.as_str().to_lowercase().chars())
            .collect(),
        None => String::new(),
    }
}

fn all_are(text: &str, kind: fn(char) -> bool) -> Value {
    Value::Bool(!text.is_empty() && text.chars().all(kind))
}
