//! Evaluation of texts and attributes.

use std::rc::Rc;

use super::names::{Substitutions, View};
use super::{Around, Expander, LEVELS_OF_ELEMENT, Result};
use crate::ExpandError;
use crate::dom::Element;
use crate::python::{Error, Value, brief, evaluate, text};
use crate::scope::Scope;
use crate::substitution;
use crate::text::{Piece, joined, pieces, truth};

impl Expander<'_> {
    /// Returns the value of a text with expressions.
    pub(super) fn text(&self, whole: &str, scope: &Rc<Scope>) -> std::result::Result<Value, Error> {
        self.budget.spend_bytes(whole.len())?;
        if !whole.contains('$') {
            return Ok(Value::text(whole));
        }
        let _level = self.budget.enter(LEVELS_OF_ELEMENT)?;
        let mut values = Vec::new();
        for piece in pieces(whole)? {
            values.push(match piece {
                Piece::Plain(plain) => Value::text(plain),
                Piece::Expression(inner) => {
                    let view = View {
                        expander: self,
                        scope,
                    };
                    let evaluated = self
                        .text(inner, scope)
                        .and_then(|inner| evaluate(&text(&inner, &self.budget)?, &view));
                    evaluated.map_err(|e| e.within(format!("`${{{inner}}}`")))?
                }
                Piece::Substitution(inner) => {
                    let folder = self.folder();
                    let answers = Substitutions {
                        expander: self,
                        folder: &folder,
                    };
                    let inner = text(&self.text(inner, scope)?, &self.budget)?;
                    let resolved = substitution::resolve(&inner, &answers)?;
                    self.budget.spend_bytes(resolved.len())?;
                    Value::text(resolved)
                }
            });
        }
        let value = joined(values, &self.budget)?;
        // The caller will store it.
        if let Value::Text(text) = &value {
            self.budget.spend_bytes(text.len())?;
        }
        Ok(value)
    }

    /// Returns a value as text, for an element.
    pub(super) fn words(&self, value: &Value, element: &Element) -> Result<String> {
        text(value, &self.budget).map_err(self.spent(&element.origin))
    }

    /// The value of an attribute of an element.
    pub(super) fn attribute(
        &self,
        element: &Element,
        name: &str,
        around: &Around,
    ) -> Result<Option<Value>> {
        match element.attribute(name) {
            None => Ok(None),
            Some(value) => match self.text(value, &around.scope) {
                Ok(value) => Ok(Some(value)),
                Err(e) => Err(self.error(&element.origin_of(name), &e)),
            },
        }
    }

    pub(super) fn required(&self, element: &Element, name: &str, around: &Around) -> Result<Value> {
        self.attribute(element, name, around)?
            .ok_or_else(|| self.missing_attribute(element, name))
    }

    /// Returns an attribute as written.
    pub(super) fn written<'e>(&self, element: &'e Element, name: &str) -> Result<&'e str> {
        let written = element.attribute(name);
        written.ok_or_else(|| self.missing_attribute(element, name))
    }

    fn missing_attribute(&self, element: &Element, name: &str) -> Box<ExpandError> {
        self.fault(
            &element.origin,
            format!("`<{}>`: the attribute `{name}` is missing", element.name),
        )
    }

    pub(super) fn yes_or_no(
        &self,
        element: &Element,
        name: &str,
        default: bool,
        around: &Around,
    ) -> Result<bool> {
        let Some(value) = self.attribute(element, name, around)? else {
            return Ok(default);
        };
        truth(&value).ok_or_else(|| {
            self.fault(
                &element.origin_of(name),
                format!(
                    "the condition `{}` is `{}`, which is neither true nor false",
                    element.attribute(name).unwrap_or_default(),
                    brief(&value)
                ),
            )
        })
    }
}
