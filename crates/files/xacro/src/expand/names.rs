//! Lookups for expressions and substitutions.

use std::any::Any;
use std::path::Path;
use std::rc::Rc;

use super::Expander;
use crate::budget::Budget;
use crate::dom::Origin;
use crate::python::{Arguments, Error, Surroundings, Value, XacroFunction, text};
use crate::scope::Scope;
use crate::substitution::Answers;
use crate::{MAX_FILE_BYTES, yaml};

/// The environment of an expression.
pub(super) struct View<'a> {
    pub(super) expander: &'a Expander<'a>,
    pub(super) scope: &'a Rc<Scope>,
}

impl Surroundings for View<'_> {
    fn look_up(&self, name: &str) -> std::result::Result<Option<Value>, Error> {
        self.expander.resolve(self.scope, name)
    }

    fn look_up_in(
        &self,
        namespace: &Rc<dyn Any>,
        name: &str,
    ) -> std::result::Result<Option<Value>, Error> {
        match Rc::clone(namespace).downcast::<Scope>() {
            Ok(scope) => self.expander.resolve(&scope, name),
            Err(_) => Ok(None),
        }
    }

    fn budget(&self) -> &Budget {
        &self.expander.budget
    }

    fn call(
        &self,
        function: XacroFunction,
        arguments: Arguments,
    ) -> std::result::Result<Value, Error> {
        self.expander.call(function, arguments, self)
    }
}

impl Expander<'_> {
    /// The functions that xacro adds to Python.
    fn call(
        &self,
        function: XacroFunction,
        mut arguments: Arguments,
        view: &View,
    ) -> std::result::Result<Value, Error> {
        let separators = arguments.take("sep");
        let skip_empty = arguments.take("skip_empty").is_none_or(|v| v.truth());
        let text = |value: &Value| text(value, &self.budget);
        let words = || {
            let texts = arguments.items.iter().map(text);
            texts
                .collect::<std::result::Result<Vec<_>, _>>()
                .map(|texts| texts.join(" "))
        };
        match (function, arguments.items.as_slice()) {
            (XacroFunction::Arg, [name]) => {
                let name = text(name)?;
                let value = self.arguments.borrow().get(&name).cloned();
                value.map(Value::text).ok_or(Error::Argument(name))
            }
            (XacroFunction::AbsFilename, [name]) => {
                let path = self.folder().join(text(name)?);
                Ok(Value::text(path.display().to_string()))
            }
            (XacroFunction::Dotify, [dict @ Value::Dict(_)]) => Ok(dict.clone()),
            (XacroFunction::LoadYaml, [name]) => {
                let name = text(name)?;
                let path = self.folder().join(&name);
                let read = self.host.read_text(&path, MAX_FILE_BYTES);
                let read = read.map_err(|fault| Error::File(name.clone(), fault.to_string()))?;
                yaml::load(&read, view).map_err(|e| e.within(format!("`{name}`")))
            }
            (XacroFunction::Tokenize, [Value::Text(of), more @ ..]) => {
                let separators = more.first().cloned().or(separators);
                let separators = match &separators {
                    Some(separators) => text(separators)?,
                    None => ",; ".to_owned(),
                };
                self.budget
                    .spend_bytes(of.len().saturating_mul(1 + separators.len()))?;
                let tokens = of
                    .split(|c| separators.contains(c))
                    .filter(|token| !skip_empty || !token.is_empty())
                    .map(|token| self.budget.spend(1).map(|()| Value::text(token)));
                Ok(Value::list(tokens.collect::<std::result::Result<_, _>>()?))
            }
            (XacroFunction::Fatal, _) => Err(Error::new(words()?)),
            (XacroFunction::Message | XacroFunction::Warning | XacroFunction::Error, _) => {
                let words = words()?;
                let reading = self.reading.borrow();
                if let Some(file) = reading.last() {
                    let origin = Origin {
                        file: Rc::clone(file),
                        bytes: 0..0,
                    };
                    self.note(&origin, "the file itself", words);
                }
                Ok(Value::text(""))
            }
            (XacroFunction::PrintLocation, _) => Ok(Value::text("")),
            _ => Err(Error::new("a function of xacro takes other arguments")),
        }
    }
}

/// The environment of a substitution.
pub(super) struct Substitutions<'a> {
    pub(super) expander: &'a Expander<'a>,
    pub(super) folder: &'a Path,
}

impl Answers for Substitutions<'_> {
    fn argument(&self, name: &str) -> Option<String> {
        self.expander.arguments.borrow().get(name).cloned()
    }

    fn package(&self, name: &str) -> Option<String> {
        self.expander.find_package(name)
    }

    fn environment(&self, name: &str) -> Result<Option<String>, Error> {
        self.expander.host.environment(name).map_err(Error::new)
    }

    fn working_folder(&self) -> Result<String, Error> {
        self.expander.host.working_folder().map_err(Error::new)
    }

    fn folder(&self) -> &Path {
        self.folder
    }

    fn budget(&self) -> &Budget {
        &self.expander.budget
    }
}

/// Returns the scope of nested namespaces.
pub(super) fn namespace(
    expander: &Expander,
    scope: &Rc<Scope>,
    path: &[&str],
) -> Option<Rc<Scope>> {
    let mut scope = Rc::clone(scope);
    for name in path {
        match expander.resolve(&scope, name).ok()?? {
            Value::Namespace(inner) => scope = inner.downcast::<Scope>().ok()?,
            _ => return None,
        }
    }
    Some(scope)
}
