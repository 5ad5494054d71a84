//! The subset of Python for xacro's expressions: `${2*pi/n if n > 3 else 0}`.
//!
//! xacro passes the text between the braces to Python's `eval`. This module supports the useful
//! part of the language: numbers, text, lists, dictionaries, operators with Python's precedence,
//! conditionals, comprehensions, lambdas, slices, and the functions that xacro allows. Integers
//! stay integers, and numbers are printed as in Python.

mod builtins;
mod eval;
mod format;
mod lex;
mod math;
mod methods;
mod numbers;
mod operators;
mod parse;
mod surroundings;
mod syntax;
mod value;

pub(super) use eval::evaluate;
pub(super) use format::{brief, repr, text};
pub(super) use surroundings::{Arguments, Surroundings};
pub(super) use value::{Dict, Error, Value, XacroFunction, check_nesting, literal};

/// Returns a value, or its text, as a number.
pub(super) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Text(text) => value::parse_float(text),
        other => other.as_float(),
    }
}

/// Returns a text as an integer.
pub(super) fn whole(text: &str) -> Option<i128> {
    value::parse_int(text)
}

/// Whether a name has a value without a definition in a file.
pub(super) fn is_global(name: &str) -> bool {
    builtins::global(name).is_some()
}
