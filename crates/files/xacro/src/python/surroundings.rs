//! What an expression finds around it, and what the functions of the language need of whoever calls them.

use std::any::Any;
use std::rc::Rc;

use super::super::budget::Budget;
use super::value::{Error, Value, XacroFunction};

/// What an expression finds around it.
pub(in super::super) trait Surroundings {
    /// The value of a name that is not the language's own.
    fn look_up(&self, name: &str) -> Result<Option<Value>, Error>;

    /// The value of a name in a namespace of properties.
    fn look_up_in(&self, namespace: &Rc<dyn Any>, name: &str) -> Result<Option<Value>, Error>;

    /// What is left of the limits.
    fn budget(&self) -> &Budget;

    /// Calls a function that xacro adds.
    fn call(&self, function: XacroFunction, arguments: Arguments) -> Result<Value, Error>;
}

/// The arguments of a call.
#[derive(Debug, Default)]
pub(in super::super) struct Arguments {
    pub(in super::super) items: Vec<Value>,
    pub(in super::super) named: Vec<(Rc<str>, Value)>,
}

impl Arguments {
    /// Takes an argument that has a name out of those that have one.
    pub(in super::super) fn take(&mut self, name: &str) -> Option<Value> {
        let at = self.named.iter().position(|(n, _)| &**n == name)?;
        Some(self.named.remove(at).1)
    }
}

/// Whoever evaluates: some functions call functions that they are given.
pub(super) trait Caller {
    /// What the expression finds around it.
    fn around(&self) -> &dyn Surroundings;

    /// Calls a value.
    fn call(&mut self, function: &Value, arguments: Arguments) -> Result<Value, Error>;

    /// What a value gives when it is gone through.
    fn elements(&self, value: &Value) -> Result<Vec<Value>, Error> {
        elements(value, self.around())
    }
}

/// What a value gives when it is gone through.
pub(super) fn elements(value: &Value, around: &dyn Surroundings) -> Result<Vec<Value>, Error> {
    let pay = |count: usize| around.budget().spend(count as u64);
    Ok(match value {
        Value::List(items) | Value::Tuple(items) => {
            pay(items.len())?;
            items.to_vec()
        }
        Value::Text(text) => {
            // No more characters than bytes.
            pay(text.len())?;
            text.chars().map(|c| Value::text(c.to_string())).collect()
        }
        Value::Dict(dict) => {
            pay(dict.entries().len())?;
            dict.entries().iter().map(|(key, _)| key.clone()).collect()
        }
        other => {
            return Err(Error::new(format!(
                "'{}' object is not iterable",
                other.kind()
            )));
        }
    })
}
