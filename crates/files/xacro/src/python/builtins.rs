//! The Python functions that xacro allows.

use super::math::{self, int};
use super::numbers::{divmod, round, to_float, to_int};
use super::operators::{binary, order, too_large};
use super::surroundings::{Arguments, Caller};
use super::value::{Dict, Error, Module, Value, XacroFunction};
use super::{brief, repr, text};

/// Functions available without a namespace.
const GLOBAL: &str = "list dict map len str float int bool min max round sorted range";

/// Further functions available as `python.name`.
const PYTHON: &str =
    "abs all any divmod enumerate filter isinstance ord repr reversed set sum tuple zip frozenset";

/// Functions available as `xacro.name`; the flag says whether also without it.
const XACRO: [(&str, XacroFunction, bool); 10] = [
    ("load_yaml", XacroFunction::LoadYaml, true),
    ("abs_filename", XacroFunction::AbsFilename, true),
    ("dotify", XacroFunction::Dotify, true),
    ("arg", XacroFunction::Arg, false),
    ("tokenize", XacroFunction::Tokenize, false),
    ("message", XacroFunction::Message, false),
    ("warning", XacroFunction::Warning, false),
    ("error", XacroFunction::Error, false),
    ("fatal", XacroFunction::Fatal, false),
    ("print_location", XacroFunction::PrintLocation, false),
];

/// Returns the value of a name that the file does not define.
pub(super) fn global(name: &str) -> Option<Value> {
    let function = GLOBAL.split(' ').find(|known| *known == name);
    let of_xacro = || {
        let found = XACRO.iter().find(|known| known.0 == name && known.2);
        found.map(|known| Value::Xacro(known.1))
    };
    function
        .map(Value::Function)
        .or_else(|| module(name).map(Value::Module))
        .or_else(of_xacro)
        .or_else(|| math::value(name))
}

/// Returns the value of a name in a namespace.
pub(super) fn of_module(module: Module, name: &str) -> Option<Value> {
    match module {
        Module::Math => math::value(name),
        Module::Python => {
            let mut known = GLOBAL.split(' ').chain(PYTHON.split(' '));
            known.find(|known| *known == name).map(Value::Function)
        }
        Module::Xacro => {
            let known = XACRO.iter().find(|known| known.0 == name)?;
            Some(Value::Xacro(known.1))
        }
    }
}

/// Calls a function by its name.
pub(super) fn call(
    evaluator: &mut dyn Caller,
    name: &'static str,
    mut arguments: Arguments,
) -> Result<Value, Error> {
    if let Some(value) = math::call(name, &arguments.items, evaluator.around())? {
        return Ok(value);
    }
    // Known named arguments are removed first; any left is an error.
    let key = arguments.take("key");
    let reverse = arguments.take("reverse").is_some_and(|v| v.truth());
    let default = arguments.take("default");
    let start = arguments.take("start");
    let ndigits = arguments.take("ndigits");
    if name != "dict" {
        arguments.refuse_named(name)?;
    }
    let Arguments { items, named } = arguments;
    let wrong_count = || Err(Error::new(format!("{name}() takes other arguments")));
    match (name, items.as_slice()) {
        ("list", []) => Ok(Value::list(Vec::new())),
        ("list", [value]) => Ok(Value::list(evaluator.elements(value)?)),
        ("tuple", []) => Ok(Value::tuple(Vec::new())),
        ("tuple", [value]) => Ok(Value::tuple(evaluator.elements(value)?)),
        ("set" | "frozenset", []) => Ok(Value::list(Vec::new())),
        ("set" | "frozenset", [value]) => distinct(evaluator, value),
        ("dict", items) if items.len() <= 1 => dict(evaluator, items.first(), named),
        ("map", [function, sources @ ..]) if !sources.is_empty() => {
            let rows = zip(evaluator, sources)?;
            let mapped = rows
                .into_iter()
                .map(|row| call_with(evaluator, function, row));
            Ok(Value::list(mapped.collect::<Result<_, _>>()?))
        }
        ("filter", [function, source]) => {
            let mut kept = Vec::new();
            for item in evaluator.elements(source)? {
                let holds = match function {
                    Value::None => item.truth(),
                    function => call_with(evaluator, function, vec![item.clone()])?.truth(),
                };
                if holds {
                    kept.push(item);
                }
            }
            Ok(Value::list(kept))
        }
        ("zip", sources) => {
            let rows = zip(evaluator, sources)?;
            Ok(Value::list(rows.into_iter().map(Value::tuple).collect()))
        }
        ("enumerate", [source, from @ ..]) if from.len() <= 1 => {
            let start = from.first().cloned().or(start);
            let start = start.and_then(|s| s.as_int()).unwrap_or(0);
            let items = evaluator.elements(source)?;
            let numbered = items
                .into_iter()
                .enumerate()
                .map(|(i, item)| Value::tuple(vec![Value::Int(start + i as i128), item]));
            Ok(Value::list(numbered.collect()))
        }
        ("reversed", [source]) => {
            let mut items = evaluator.elements(source)?;
            items.reverse();
            Ok(Value::list(items))
        }
        ("sorted", [source]) => {
            let items = evaluator.elements(source)?;
            sorted(evaluator, items, key.as_ref(), reverse).map(Value::list)
        }
        ("len", [value]) => length(evaluator, value),
        ("str", []) => Ok(Value::text("")),
        ("str", [value]) => Ok(Value::text(text(value, evaluator.around().budget())?)),
        ("repr", [value]) => Ok(Value::text(repr(value, evaluator.around().budget())?)),
        ("float", []) => Ok(Value::Float(0.0)),
        ("float", [value]) => {
            evaluator.around().budget().spend_on(value)?;
            to_float(value)
        }
        ("int", []) => Ok(Value::Int(0)),
        ("int", [value]) => {
            evaluator.around().budget().spend_on(value)?;
            to_int(value)
        }
        ("int", [Value::Text(digits), base]) => {
            evaluator.around().budget().spend_bytes(digits.len())?;
            let base = base.as_int().and_then(|base| u32::try_from(base).ok());
            let value = base
                .filter(|base| (2..=36).contains(base))
                .and_then(|base| i128::from_str_radix(digits.trim(), base).ok());
            value.map(Value::Int).ok_or_else(|| {
                Error::new(format!("invalid literal for int(): {}", brief(&items[0])))
            })
        }
        ("bool", []) => Ok(Value::Bool(false)),
        ("bool", [value]) => Ok(Value::Bool(value.truth())),
        ("min" | "max", items) => extreme(evaluator, name, items, key.as_ref(), default),
        ("round", [value]) => round(value, ndigits.as_ref()),
        ("round", [value, digits]) => round(value, Some(digits)),
        ("range", bounds) => range(evaluator, bounds),
        ("abs", [value]) => match value.as_int() {
            Some(i) => i.checked_abs().map(Value::Int).ok_or_else(too_large),
            None => value
                .as_float()
                .map(|x| Value::Float(x.abs()))
                .ok_or_else(|| {
                    Error::new(format!("bad operand type for abs(): '{}'", value.kind()))
                }),
        },
        ("all", [source]) => {
            let items = evaluator.elements(source)?;
            Ok(Value::Bool(items.iter().all(Value::truth)))
        }
        ("any", [source]) => {
            let items = evaluator.elements(source)?;
            Ok(Value::Bool(items.iter().any(Value::truth)))
        }
        ("sum", [source, from @ ..]) if from.len() <= 1 => {
            let mut sum = from.first().cloned().or(start).unwrap_or(Value::Int(0));
            for item in evaluator.elements(source)? {
                sum = binary("+", &sum, &item, evaluator.around())?;
            }
            Ok(sum)
        }
        ("divmod", [p, q]) => divmod(p, q, evaluator.around()),
        ("ord", [Value::Text(text)]) => {
            let mut chars = text.chars();
            match (chars.next(), chars.next()) {
                (Some(c), None) => Ok(Value::Int(i128::from(u32::from(c)))),
                _ => Err(Error::new("ord() takes one character")),
            }
        }
        ("isinstance", [value, class]) => is_instance(value, class),
        _ => wrong_count(),
    }
}

/// Returns the value by which an item is ranked: that of the key's function, or the item itself.
fn ranked_by(
    evaluator: &mut dyn Caller,
    key: Option<&Value>,
    item: &Value,
) -> Result<Value, Error> {
    match key {
        Some(function) => call_with(evaluator, function, vec![item.clone()]),
        None => Ok(item.clone()),
    }
}

fn call_with(
    evaluator: &mut dyn Caller,
    function: &Value,
    items: Vec<Value>,
) -> Result<Value, Error> {
    let named = Vec::new();
    evaluator.call(function, Arguments { items, named })
}

fn zip(evaluator: &dyn Caller, sources: &[Value]) -> Result<Vec<Vec<Value>>, Error> {
    let sources: Vec<Vec<Value>> = sources
        .iter()
        .map(|source| evaluator.elements(source))
        .collect::<Result<_, _>>()?;
    let shortest = sources.iter().map(Vec::len).min().unwrap_or(0);
    let row = |i: usize| sources.iter().map(|source| source[i].clone()).collect();
    Ok((0..shortest).map(row).collect())
}

/// Returns the elements of a set, in order of insertion.
fn distinct(evaluator: &dyn Caller, source: &Value) -> Result<Value, Error> {
    let mut seen = Dict::default();
    evaluator.around().budget().spend_on(source)?;
    for item in evaluator.elements(source)? {
        seen.insert(item, Value::None)?;
    }
    let items = seen.entries().iter().map(|(key, _)| key.clone());
    Ok(Value::list(items.collect()))
}

fn dict(
    evaluator: &dyn Caller,
    source: Option<&Value>,
    named: Vec<(std::rc::Rc<str>, Value)>,
) -> Result<Value, Error> {
    let mut dict = Dict::default();
    match source {
        Some(Value::Dict(other)) => {
            evaluator
                .around()
                .budget()
                .spend(other.entries().len() as u64)?;
            dict = (**other).clone();
        }
        Some(pairs) => {
            for pair in evaluator.elements(pairs)? {
                match evaluator.elements(&pair)?.as_slice() {
                    [key, value] => {
                        evaluator.around().budget().spend_on(key)?;
                        dict.insert(key.clone(), value.clone())?;
                    }
                    _ => return Err(Error::new("dict() takes pairs of key and value")),
                }
            }
        }
        None => {}
    }
    for (name, value) in named {
        dict.insert(Value::Text(name), value)?;
    }
    Ok(Value::Dict(dict.into()))
}

fn length(evaluator: &dyn Caller, value: &Value) -> Result<Value, Error> {
    let length = match value {
        Value::Text(text) => {
            evaluator.around().budget().spend_bytes(text.len())?;
            text.chars().count()
        }
        Value::List(items) | Value::Tuple(items) => items.len(),
        Value::Dict(dict) => dict.entries().len(),
        other => {
            return Err(Error::new(format!(
                "object of type '{}' has no len()",
                other.kind()
            )));
        }
    };
    Ok(Value::Int(length as i128))
}

/// Merge sort, which only needs "less" and is stable.
fn sorted(
    evaluator: &mut dyn Caller,
    items: Vec<Value>,
    key: Option<&Value>,
    reverse: bool,
) -> Result<Vec<Value>, Error> {
    let mut keyed = Vec::with_capacity(items.len());
    for item in items {
        let by = ranked_by(evaluator, key, &item)?;
        keyed.push((by, item));
    }
    evaluator.around().budget().spend(16 * keyed.len() as u64)?;
    for (by, _) in &keyed {
        // Each element is compared once per level of merging.
        let compared = by.size().bytes.saturating_mul(16);
        evaluator.around().budget().spend_bytes(compared)?;
    }
    let mut fault = None;
    keyed.sort_by(|p, q| {
        let found = order(&p.0, &q.0).unwrap_or_else(|()| {
            fault = Some(Error::new(format!(
                "'<' not supported between instances of '{}' and '{}'",
                p.0.kind(),
                q.0.kind()
            )));
            None
        });
        let found = found.unwrap_or(std::cmp::Ordering::Equal);
        if reverse { found.reverse() } else { found }
    });
    match fault {
        Some(fault) => Err(fault),
        None => Ok(keyed.into_iter().map(|(_, item)| item).collect()),
    }
}

fn extreme(
    evaluator: &mut dyn Caller,
    name: &str,
    items: &[Value],
    key: Option<&Value>,
    default: Option<Value>,
) -> Result<Value, Error> {
    let items = match items {
        [] => return Err(Error::new(format!("{name} expected at least 1 argument"))),
        [source] => evaluator.elements(source)?,
        several => several.to_vec(),
    };
    let mut best: Option<(Value, Value)> = None;
    for item in items {
        let by = ranked_by(evaluator, key, &item)?;
        let operator = if name == "min" { "<" } else { ">" };
        let better = match &best {
            None => true,
            Some((other, _)) => {
                super::operators::compare(operator, &by, other, evaluator.around())?
            }
        };
        if better {
            best = Some((by, item));
        }
    }
    best.map(|(_, item)| item)
        .or(default)
        .ok_or_else(|| Error::new(format!("{name}() arg is an empty sequence")))
}

fn range(evaluator: &dyn Caller, bounds: &[Value]) -> Result<Value, Error> {
    let (start, stop, step) = match bounds {
        [stop] => (0, int(stop)?, 1),
        [start, stop] => (int(start)?, int(stop)?, 1),
        [start, stop, step] => (int(start)?, int(stop)?, int(step)?),
        _ => return Err(Error::new("range expected 1 to 3 arguments")),
    };
    if step == 0 {
        return Err(Error::new("range() arg 3 must not be zero"));
    }
    let span = if step > 0 {
        stop.saturating_sub(start)
    } else {
        start.saturating_sub(stop)
    };
    let count = (span.max(0) as u128).div_ceil(step.unsigned_abs());
    let count = u64::try_from(count).unwrap_or(u64::MAX);
    evaluator.around().budget().spend(count)?;
    let numbers = (0..count).map(|i| Value::Int(start + i128::from(i) * step));
    Ok(Value::list(numbers.collect()))
}

fn is_instance(value: &Value, class: &Value) -> Result<Value, Error> {
    let is = |class: &Value| match class {
        Value::Function(name) => {
            Ok(value.kind() == *name || (*name == "int" && value.kind() == "bool"))
        }
        _ => Err(Error::new(
            "isinstance() arg 2 must be a type or a tuple of types",
        )),
    };
    Ok(Value::Bool(match class {
        Value::Tuple(classes) => {
            let mut any = false;
            for class in classes.iter() {
                any = any || is(class)?;
            }
            any
        }
        class => is(class)?,
    }))
}

/// Returns the namespace with a name.
fn module(name: &str) -> Option<Module> {
    match name {
        "math" => Some(Module::Math),
        "python" => Some(Module::Python),
        "xacro" => Some(Module::Xacro),
        _ => None,
    }
}
