//! The environment of an expression, and the callbacks for functions.

use std::any::Any;
use std::rc::Rc;

use super::super::budget::Budget;
use super::value::{Error, Value, XacroFunction};

/// The environment of an expression.
pub(in super::super) trait Surroundings {
    /// Returns the value of a name that is not built in.
    fn look_up(&self, name: &str) -> Result<Option<Value>, Error>;

    /// Returns the value of a name in a namespace of properties.
    fn look_up_in(&self, namespace: &Rc<dyn Any>, name: &str) -> Result<Option<Value>, Error>;

    /// The remaining limits.
    fn budget(&self) -> &Budget;

    /// Calls a function added by xacro.
    fn call(&self, function: XacroFunction, arguments: Arguments) -> Result<Value, Error>;
}

/// The arguments of a call.
#[derive(Debug, Default)]
pub(in super::super) struct Arguments {
    pub(in super::super) items: Vec<Value>,
    pub(in super::super) named: Vec<(Rc<str>, Value)>,
}

impl Arguments {
    /// Removes and returns a named argument.
    pub(in super::super) fn take(&mut self, name: &str) -> Option<Value> {
        let at = self.named.iter().position(|(n, _)| &**n == name)?;
        Some(self.named.remove(at).1)
    }

    /// Refuses named arguments that a function does not take.
    pub(super) fn refuse_named(&self, function: &str) -> Result<(), Error> {
        match self.named.first() {
            None => Ok(()),
            Some((name, _)) => Err(Error::new(format!(
                "{function}() got an unexpected keyword argument '{name}'"
            ))),
        }
    }
}

/// The evaluator, for functions that call functions passed to them.
pub(super) trait Caller {
    /// The environment of the expression.
    fn around(&self) -> &dyn Surroundings;

    /// Calls a value.
    fn call(&mut self, function: &Value, arguments: Arguments) -> Result<Value, Error>;

    /// Returns the elements of an iterable.
    fn elements(&self, value: &Value) -> Result<Vec<Value>, Error> {
        elements(value, self.around())
    }
}

/// Returns the elements of an iterable.
pub(super) fn elements(value: &Value, around: &dyn Surroundings) -> Result<Vec<Value>, Error> {
    let pay = |count: usize| around.budget().spend(count as u64);
    Ok(match value {
        Value::List(items) | Value::Tuple(items) => {
            pay(items.len())?;
            items.to_vec()
        }
        Value::Text(text) => {
            // At most as many characters as bytes.
            pay(text.len())?;
            text.chars().map(|c| Value::text(c.to_string())).collect()
        }
        Value::Dict(dict) => {
            pay(dict.entries().len())?;
            dict.entries().iter().map(|(key, _)| key.clone()).collect()
        }
        other => return Err(Error::is_not(other, "iterable")),
    })
}
