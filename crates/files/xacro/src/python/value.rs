//! The values of the language.

use std::any::Any;
use std::collections::HashMap;
use std::ops::Deref;
use std::rc::Rc;

use super::super::spent::Spent;
use super::syntax::{Expr, Literal};

/// A value.
#[derive(Clone, Debug)]
pub(in super::super) enum Value {
    /// `None`.
    None,
    /// `True` or `False`.
    Bool(bool),
    /// An integer. Python's are unlimited; these end at 38 digits, which gives an error and no
    /// wrong number.
    Int(i128),
    /// A floating-point number.
    Float(f64),
    /// Text.
    Text(Rc<str>),
    /// A list; Python's iterators are lists too.
    List(Rc<Items>),
    /// A tuple.
    Tuple(Rc<Items>),
    /// A dictionary.
    Dict(Rc<Dict>),
    /// A function of the language.
    Function(&'static str),
    /// A function of xacro.
    Xacro(XacroFunction),
    /// A method bound to its value.
    Method(Rc<(Value, &'static str)>),
    /// `lambda x: ...`.
    Lambda(Rc<Lambda>),
    /// `math`, `python` or `xacro`.
    Module(Module),
    /// A namespace of properties: `<xacro:include filename="..." ns="name"/>`.
    Namespace(Rc<dyn Any>),
}

/// An anonymous function with the values of its surrounding names.
#[derive(Clone, Debug)]
pub(in super::super) struct Lambda {
    pub(super) parameters: Rc<[Rc<str>]>,
    pub(super) body: Rc<Expr>,
    pub(super) bound: Vec<(Rc<str>, Value)>,
    /// Nesting depth of the bound values.
    pub(super) depth: usize,
}

/// Deepest nesting of lists and dictionaries.
const DEEPEST_VALUE: usize = 100;

/// Typical largest size of a number or type name as text, in bytes.
const SHORT: usize = 16;

/// The values of a list or a tuple.
#[derive(Debug)]
pub(in super::super) struct Items {
    values: Vec<Value>,
    size: Size,
}

impl Deref for Items {
    type Target = [Value];

    fn deref(&self) -> &[Value] {
        &self.values
    }
}

impl From<Vec<Value>> for Items {
    fn from(values: Vec<Value>) -> Self {
        let mut size = Size::of_lone(2);
        values.iter().for_each(|value| size.hold(value));
        Self { values, size }
    }
}

/// Size of a value when visited completely, for printing or comparing. A shared part, such as the
/// row of `[row] * 1000`, is stored once but counts each time; so the size is known before the
/// visit.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct Size {
    /// Approximate bytes as text.
    pub(in super::super) bytes: usize,
    /// Nesting depth.
    pub(super) depth: usize,
}

impl Size {
    fn of_lone(bytes: usize) -> Self {
        Self { bytes, depth: 0 }
    }

    /// The size of a function with bound values of that depth.
    fn of_function(depth: usize) -> Self {
        Self {
            bytes: SHORT,
            depth: depth + 1,
        }
    }

    /// Adds a contained value.
    fn hold(&mut self, value: &Value) {
        let Self { bytes, depth } = value.size();
        // Including the comma.
        self.bytes = self.bytes.saturating_add(bytes).saturating_add(2);
        self.depth = self.depth.max(depth + 1);
    }
}

/// The functions that xacro adds to Python.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum XacroFunction {
    LoadYaml,
    AbsFilename,
    Arg,
    Dotify,
    Tokenize,
    Message,
    Warning,
    Error,
    Fatal,
    PrintLocation,
}

/// The predefined namespaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Module {
    Math,
    Python,
    Xacro,
}

/// The reason why an expression has no value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(in super::super) enum Error {
    /// An undefined name.
    #[error("the name `{0}` is not defined")]
    Name(String),
    /// An argument, `$(arg NAME)`, that has neither value nor default.
    #[error("the argument `{0}` has neither value nor default")]
    Argument(String),
    /// A package, `$(find NAME)`, whose folder is unknown.
    #[error("the folder of the package `{0}` is not known")]
    Package(String),
    /// A file that cannot be read, with the reason.
    #[error("`{0}` cannot be read: {1}")]
    File(String, String),
    /// Anything else, in words.
    #[error("{0}")]
    Other(String),
    /// A limit was reached: the whole expansion ends.
    #[error("{0}")]
    Spent(#[from] Spent),
    /// An error with its surrounding expression or property.
    #[error("{1}, in {0}")]
    In(String, Box<Error>),
}

impl Error {
    pub(in super::super) fn new(words: impl Into<String>) -> Self {
        Self::Other(words.into())
    }

    /// A value that does not have an ability, such as `callable`.
    pub(super) fn is_not(value: &Value, ability: &str) -> Self {
        Self::new(format!("'{}' object is not {ability}", value.kind()))
    }

    /// Adds a surrounding expression or property.
    pub(in super::super) fn within(self, what: impl Into<String>) -> Self {
        match self {
            Self::Spent(_) => self,
            other => Self::In(what.into(), Box::new(other)),
        }
    }

    /// Returns the innermost error.
    pub(in super::super) fn cause(&self) -> &Self {
        match self {
            Self::In(_, inner) => inner.cause(),
            other => other,
        }
    }
}

/// A dictionary, in order of insertion.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Dict {
    entries: Vec<(Value, Value)>,
    places: HashMap<Key, usize>,
    size: Size,
}

/// A key: equal numbers are one key, as in Python.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Key {
    None,
    Int(i128),
    Float(u64),
    Text(Rc<str>),
    Tuple(Vec<Key>),
}

impl Key {
    fn of(value: &Value) -> Result<Self, Error> {
        Ok(match value {
            Value::None => Self::None,
            Value::Bool(b) => Self::Int(i128::from(*b)),
            Value::Int(i) => Self::Int(*i),
            Value::Float(x) if x.fract() == 0.0 && x.abs() < 1e30 => Self::Int(*x as i128),
            Value::Float(x) => Self::Float(x.to_bits()),
            Value::Text(text) => Self::Text(Rc::clone(text)),
            Value::Tuple(items) => {
                Self::Tuple(items.iter().map(Self::of).collect::<Result<_, _>>()?)
            }
            other => {
                return Err(Error::new(format!("a {} cannot be a key", other.kind())));
            }
        })
    }
}

impl Dict {
    pub(in super::super) fn get(&self, key: &Value) -> Result<Option<&Value>, Error> {
        let place = self.places.get(&Key::of(key)?);
        Ok(place.map(|&i| &self.entries[i].1))
    }

    pub(in super::super) fn get_text(&self, key: &str) -> Option<&Value> {
        self.get(&Value::Text(key.into())).ok().flatten()
    }

    pub(in super::super) fn insert(&mut self, key: Value, value: Value) -> Result<(), Error> {
        let place = Key::of(&key)?;
        // A replaced value stays counted.
        self.size.hold(&key);
        self.size.hold(&value);
        match self.places.get(&place) {
            Some(&i) => self.entries[i].1 = value,
            None => {
                self.places.insert(place, self.entries.len());
                self.entries.push((key, value));
            }
        }
        Ok(())
    }

    pub(in super::super) fn entries(&self) -> &[(Value, Value)] {
        &self.entries
    }
}

impl From<&Literal> for Value {
    fn from(literal: &Literal) -> Self {
        match literal {
            Literal::None => Self::None,
            Literal::Bool(b) => Self::Bool(*b),
            Literal::Int(i) => Self::Int(*i),
            Literal::Float(x) => Self::Float(*x),
            Literal::Text(text) => Self::Text(Rc::clone(text)),
        }
    }
}

impl Value {
    pub(in super::super) fn text(text: impl AsRef<str>) -> Self {
        Self::Text(text.as_ref().into())
    }

    pub(in super::super) fn list(items: Vec<Value>) -> Self {
        Self::List(Rc::new(items.into()))
    }

    pub(in super::super) fn tuple(items: Vec<Value>) -> Self {
        Self::Tuple(Rc::new(items.into()))
    }

    /// The size of a complete visit.
    pub(in super::super) fn size(&self) -> Size {
        match self {
            Self::Text(text) => Size::of_lone(text.len() + 2),
            Self::List(items) | Self::Tuple(items) => items.size,
            Self::Dict(dict) => dict.size,
            // The text of a function is short, whatever it contains.
            Self::Lambda(lambda) => Size::of_function(lambda.depth),
            Self::Method(bound) => Size::of_function(bound.0.size().depth),
            _ => Size::of_lone(SHORT),
        }
    }

    /// Returns its Python type name.
    pub(in super::super) fn kind(&self) -> &'static str {
        match self {
            Self::None => "NoneType",
            Self::Bool(_) => "bool",
            Self::Int(_) => "int",
            Self::Float(_) => "float",
            Self::Text(_) => "str",
            Self::List(_) => "list",
            Self::Tuple(_) => "tuple",
            Self::Dict(_) => "dict",
            Self::Function(_) | Self::Xacro(_) | Self::Lambda(_) => "function",
            Self::Method(_) => "method",
            Self::Module(_) | Self::Namespace(_) => "namespace",
        }
    }

    /// Whether it counts as true.
    pub(in super::super) fn truth(&self) -> bool {
        match self {
            Self::None => false,
            Self::Bool(b) => *b,
            Self::Int(i) => *i != 0,
            Self::Float(x) => *x != 0.0,
            Self::Text(text) => !text.is_empty(),
            Self::List(items) | Self::Tuple(items) => !items.is_empty(),
            Self::Dict(dict) => !dict.entries.is_empty(),
            _ => true,
        }
    }

    /// Returns its number, if it is one.
    pub(super) fn as_float(&self) -> Option<f64> {
        match self {
            Self::Bool(b) => Some(f64::from(u8::from(*b))),
            Self::Int(i) => Some(*i as f64),
            Self::Float(x) => Some(*x),
            _ => None,
        }
    }

    /// Returns its integer, if it is one.
    pub(super) fn as_int(&self) -> Option<i128> {
        match self {
            Self::Bool(b) => Some(i128::from(*b)),
            Self::Int(i) => Some(*i),
            _ => None,
        }
    }

    /// Whether the two are equal, like `==`. It visits both; the caller charges for that.
    pub(super) fn equals(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::None, Self::None) => true,
            (Self::Text(p), Self::Text(q)) => p == q,
            (Self::List(p), Self::List(q)) | (Self::Tuple(p), Self::Tuple(q)) => {
                p.len() == q.len() && p.iter().zip(q.iter()).all(|(p, q)| p.equals(q))
            }
            (Self::Dict(p), Self::Dict(q)) => {
                p.entries.len() == q.entries.len()
                    && p.entries.iter().all(|(key, value)| {
                        let other = q.get(key).ok().flatten();
                        other.is_some_and(|other| value.equals(other))
                    })
            }
            (Self::Function(p), Self::Function(q)) => p == q,
            _ => match (self.as_int(), other.as_int()) {
                (Some(p), Some(q)) => p == q,
                _ => match (self.as_float(), other.as_float()) {
                    (Some(p), Some(q)) => p == q,
                    _ => false,
                },
            },
        }
    }
}

/// Rejects a value that is nested too deep for recursive functions.
pub(in super::super) fn check_nesting(value: &Value) -> Result<(), Error> {
    if value.size().depth > DEEPEST_VALUE {
        let words = format!("lists nested more than {DEEPEST_VALUE} deep");
        return Err(Error::new(words));
    }
    Ok(())
}

/// Returns the value of a text by xacro's rules for properties and parameters: an integer, a
/// number, a truth value, or the text itself. Quotes force text.
pub(in super::super) fn literal(text: &str) -> Value {
    let quoted = text
        .strip_prefix('\'')
        .and_then(|inner| inner.strip_suffix('\''));
    if let Some(inner) = quoted {
        return Value::text(inner);
    }
    // Python accepts 1_000 as a number; xacro leaves such names alone.
    if text.contains('_') {
        return Value::text(text);
    }
    if let Some(int) = parse_int(text) {
        return Value::Int(int);
    }
    if let Some(float) = parse_float(text) {
        return Value::Float(float);
    }
    match text {
        "true" | "True" => Value::Bool(true),
        "false" | "False" => Value::Bool(false),
        _ => Value::text(text),
    }
}

/// Parses an integer like Python's `int`; `None` for other texts and beyond 38 digits.
pub(super) fn parse_int(text: &str) -> Option<i128> {
    let text = text.trim();
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    let plain: String = digits.replace('_', "");
    let well_formed = !plain.is_empty()
        && plain.bytes().all(|b| b.is_ascii_digit())
        && !digits.starts_with('_')
        && !digits.ends_with('_')
        && !digits.contains("__");
    let magnitude: i128 = well_formed.then(|| plain.parse().ok()).flatten()?;
    Some(if text.starts_with('-') {
        -magnitude
    } else {
        magnitude
    })
}

/// Parses a number like Python's `float`.
pub(super) fn parse_float(text: &str) -> Option<f64> {
    let text = text.trim();
    let bare = text.strip_prefix(['+', '-']).unwrap_or(text);
    let sign = if text.starts_with('-') { -1.0 } else { 1.0 };
    let lower = bare.to_ascii_lowercase();
    match lower.as_str() {
        "inf" | "infinity" => return Some(sign * f64::INFINITY),
        "nan" => return Some(f64::NAN),
        _ => {}
    }
    // Rust accepts the same numbers, except for the words above and underscores.
    if !lower.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
        return None;
    }
    lower.replace('_', "").parse::<f64>().ok().map(|x| sign * x)
}
