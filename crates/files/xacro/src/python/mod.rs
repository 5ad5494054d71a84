//! The little Python in which xacro's expressions are written: `${2*pi/n if n > 3 else 0}`.
//!
//! xacro hands what stands between the braces to Python's `eval`. This is that part of the language which has a meaning there:
//! numbers, text, lists, dictionaries, operators with Python's precedence, conditionals, comprehensions, lambdas, slices,
//! and the functions that xacro lets through. Whole numbers stay whole, and numbers are printed as Python prints them.

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

/// The number that a value is or that its text says.
pub(super) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Text(text) => value::parse_float(text),
        other => other.as_float(),
    }
}

/// The whole number that a text says.
pub(super) fn whole(text: &str) -> Option<i128> {
    value::parse_int(text)
}

/// Whether a name has a value that no file gives it.
pub(super) fn is_global(name: &str) -> bool {
    builtins::global(name).is_some()
}
