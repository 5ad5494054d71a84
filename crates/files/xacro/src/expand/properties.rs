//! Properties and arguments: setting and lookup.

use std::rc::Rc;

use super::calls::outer;
use super::{Around, Expander, Result};
use crate::dom::Element;
use crate::python::{Error, Value, is_global, literal};
use crate::scope::{Entry, Scope};

impl Expander<'_> {
    pub(super) fn property(&self, element: &Rc<Element>, around: &Around) -> Result<()> {
        let scope = &around.scope;
        self.budget
            .spend(1 + scope.depth() / 16)
            .map_err(self.spent(&element.origin))?;
        let name = self.words(&self.required(element, "name", around)?, element)?;
        if !is_name(&name) {
            return Err(self.fault(
                &element.origin_of("name"),
                format!("`{name}` is no name of a property: letters, digits and _ make one"),
            ));
        }
        let remove = self.yes_or_no(element, "remove", false, around)?;
        let value = element.attribute("value");
        let default = element.attribute("default");
        let said = usize::from(value.is_some()) + usize::from(default.is_some());
        if said + usize::from(remove) > 1 {
            return Err(self.fault(
                &element.origin,
                format!("the property `{name}` has more than one of value, default and remove"),
            ));
        }
        if remove && scope.find(&name).is_some() {
            scope.remove(&name);
            return Ok(());
        }
        if default.is_some() && (scope.find(&name).is_some() || is_global(&name)) {
            return Ok(());
        }
        let mut lazy = self.yes_or_no(element, "lazy_eval", true, around)?;
        let target = match element.attribute("scope") {
            Some("global") => {
                lazy = false;
                scope.top()
            }
            Some("parent") => {
                lazy = false;
                match outer(scope) {
                    Some(outer) => outer,
                    None => {
                        let words =
                            "a property of the outermost scope has no scope around it: left out";
                        let subject = format!("property `{name}`");
                        self.note(&element.origin, &subject, words.to_owned());
                        return Ok(());
                    }
                }
            }
            _ => Rc::clone(scope),
        };
        let Some(value) = value.or(default) else {
            target.put(format!("**{name}"), Entry::Block(Rc::clone(element)));
            return Ok(());
        };
        self.clues.named(&name, value);
        if lazy {
            target.set(name, Value::text(value), true);
            return Ok(());
        }
        let evaluated = self.text(value, scope).map_err(|e| {
            let at = if element.attribute("value").is_some() {
                "value"
            } else {
                "default"
            };
            self.error(&element.origin_of(at), &e)
        })?;
        target.set(name, evaluated, false);
        Ok(())
    }

    pub(super) fn declare_argument(&self, element: &Element, around: &Around) -> Result<()> {
        let name = self.written(element, "name")?;
        self.declared.borrow_mut().insert(name.to_owned());
        let known = self.arguments.borrow().contains_key(name);
        if known {
            return Ok(());
        }
        if let Some(default) = element.attribute("default") {
            // A file of an unknown package matters only when it is read.
            let origin = element.origin_of("default");
            let default = self.kept_text(default, &around.scope, &origin)?;
            let mut arguments = self.arguments.borrow_mut();
            arguments.insert(name.to_owned(), default);
        }
        Ok(())
    }

    /// Returns the value of a name, after evaluating it if necessary.
    pub(super) fn resolve(
        &self,
        scope: &Rc<Scope>,
        name: &str,
    ) -> std::result::Result<Option<Value>, Error> {
        self.budget.spend(1 + scope.depth() / 16)?;
        let Some((holder, entry)) = scope.find(name) else {
            return Ok(None);
        };
        let lazy = match entry {
            Entry::Value(value) => return Ok(Some(value)),
            Entry::Block(_) => return Ok(None),
            Entry::Lazy(lazy) => lazy,
        };
        if holder.resolving.borrow().iter().any(|other| other == name) {
            let mut chain = holder.resolving.borrow().clone();
            chain.push(name.to_owned());
            return Err(Error::new(format!(
                "a property needs itself: {}",
                chain.join(" -> ")
            )));
        }
        holder.resolving.borrow_mut().push(name.to_owned());
        let value = self.text(&lazy, &holder);
        holder.resolving.borrow_mut().pop();
        let value = match value.map_err(|e| e.within(format!("the property `{name}`")))? {
            Value::Text(text) => literal(&text),
            value => value,
        };
        holder.put(name, Entry::Value(value.clone()));
        Ok(Some(value))
    }
}

/// Whether a text can be a property's name: a Python identifier.
fn is_name(name: &str) -> bool {
    const TAKEN: [&str; 35] = [
        "False", "None", "True", "and", "as", "assert", "async", "await", "break", "class",
        "continue", "def", "del", "elif", "else", "except", "finally", "for", "from", "global",
        "if", "import", "in", "is", "lambda", "nonlocal", "not", "or", "pass", "raise", "return",
        "try", "while", "with", "yield",
    ];
    let mut chars = name.chars();
    let starts_well = chars.next().is_some_and(|c| c.is_alphabetic() || c == '_');
    starts_well
        && chars.all(|c| c.is_alphanumeric() || c == '_')
        && !name.starts_with("__")
        && !TAKEN.contains(&name)
}
