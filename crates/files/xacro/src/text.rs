//! Text with expressions: `wheel_${n}`, `$(arg name)`, and `$${` as an escape.

use std::rc::Rc;

use super::budget::Budget;
use super::python::{Error, Value, text};
use super::spent::Spent;

/// A piece of a text.
#[derive(Debug, PartialEq)]
pub(super) enum Piece<'a> {
    /// Literal text.
    Plain(&'a str),
    /// The content of `${...}`.
    Expression(&'a str),
    /// The content of `$(...)`.
    Substitution(&'a str),
}

/// Splits a text. An expression ends at its first `}`, a substitution at its first `)`, whatever is
/// inside.
pub(super) fn pieces(whole: &str) -> Result<Vec<Piece<'_>>, Error> {
    let mut pieces = Vec::new();
    let mut rest = whole;
    while !rest.is_empty() {
        let dollars = rest.bytes().take_while(|b| *b == b'$').count();
        let opens = rest[dollars..].chars().next();
        let (piece, length) = match (dollars, opens) {
            (0, _) => {
                let length = rest.find('$').unwrap_or(rest.len());
                (Piece::Plain(&rest[..length]), length)
            }
            // One of several dollars is removed; the rest after the bracket is literal text again.
            (2.., Some('{' | '(')) => (Piece::Plain(&rest[1..=dollars]), dollars + 1),
            (1, Some('{')) => match rest.find('}') {
                Some(end) => (Piece::Expression(&rest[2..end]), end + 1),
                None => return Err(unclosed(rest)),
            },
            (1, Some('(')) => match rest.find(')') {
                Some(end) => (Piece::Substitution(&rest[2..end]), end + 1),
                None => return Err(unclosed(rest)),
            },
            (1, None) => (Piece::Plain(rest), rest.len()),
            (1, Some(_)) => {
                // The dollar, and the text up to the next dollar or bracket.
                let length = rest[1..]
                    .find(['{', '(', '$'])
                    .map_or(rest.len(), |at| at + 1);
                (Piece::Plain(&rest[..length]), length)
            }
            _ => return Err(unclosed(rest)),
        };
        pieces.push(piece);
        rest = &rest[length..];
    }
    Ok(pieces)
}

fn unclosed(rest: &str) -> Error {
    let shown: String = rest.chars().take(60).collect();
    Error::new(format!("invalid expression: {shown}"))
}

/// Returns the value of evaluated pieces: a single one keeps its type, several are joined to text.
pub(super) fn joined(mut values: Vec<Value>, budget: &Budget) -> Result<Value, Spent> {
    if values.len() == 1 {
        return Ok(values.remove(0));
    }
    let texts = values.iter().map(|value| text(value, budget));
    Ok(Value::Text(Rc::from(texts.collect::<Result<String, _>>()?)))
}

/// Returns the truth value of a condition: `true`, `false` and integers as text, or any value of an
/// expression.
pub(super) fn truth(value: &Value) -> Option<bool> {
    match value {
        Value::Text(text) => match &**text {
            "true" | "True" => Some(true),
            "false" | "False" => Some(false),
            other => super::python::whole(other).map(|i| i != 0),
        },
        other => Some(other.truth()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_split_at_dollars() {
        use Piece::{Expression, Plain, Substitution};
        for (whole, expected) in [
            ("plain", vec![Plain("plain")]),
            (
                "a_${n + 1}_b",
                vec![Plain("a_"), Expression("n + 1"), Plain("_b")],
            ),
            ("$(arg x)", vec![Substitution("arg x")]),
            ("$${x}", vec![Plain("${"), Plain("x}")]),
            ("$$$(x)", vec![Plain("$$("), Plain("x)")]),
            ("5 $", vec![Plain("5 "), Plain("$")]),
            ("a$b$c", vec![Plain("a"), Plain("$b"), Plain("$c")]),
        ] {
            assert_eq!(pieces(whole).unwrap(), expected, "{whole}");
        }
    }

    #[test]
    fn what_is_not_closed_is_refused() {
        for whole in ["${x", "a $(b", "$$"] {
            assert!(pieces(whole).is_err(), "{whole}");
        }
    }
}
