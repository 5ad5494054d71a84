//! `$(arg name)`, `$(find package)`, `$(env NAME)`, `$(optenv NAME default)`, `$(dirname)`,
//! `$(cwd)`, `$(eval expression)`.

use std::any::Any;
use std::path::Path;
use std::rc::Rc;

use super::budget::Budget;
use super::packages::absolute;
use super::python::{Arguments, Error, Surroundings, Value, XacroFunction, evaluate, text};

/// Steps charged for finding a package.
const FIND: u64 = 400;

/// Lookups of a substitution.
pub(super) trait Answers {
    /// Returns the value of an argument.
    fn argument(&self, name: &str) -> Option<String>;
    /// Returns the folder of a package.
    fn package(&self, name: &str) -> Option<String>;
    /// Returns an environment variable, if accessible.
    fn environment(&self, name: &str) -> Result<Option<String>, Error>;
    /// Returns the working folder of this process, if accessible.
    fn working_folder(&self) -> Result<String, Error>;
    /// The folder of the file being read.
    fn folder(&self) -> &Path;
    /// The remaining limits.
    fn budget(&self) -> &Budget;
}

/// Returns the replacement of `$(inner)`.
pub(super) fn resolve(inner: &str, answers: &dyn Answers) -> Result<String, Error> {
    if inner == "cwd" {
        return answers.working_folder();
    }
    if let Some(expression) = inner.strip_prefix("eval ") {
        if expression.contains("__") {
            return Err(Error::new("$(eval ...) may not contain double underscores"));
        }
        let value = evaluate(expression, &OfEval { answers })?;
        return Ok(text(&value, answers.budget())?);
    }
    let resolved = command(inner, answers)?;
    // The value of an argument may itself name a package.
    let nested = resolved.strip_prefix("$(find ").and_then(|rest| {
        let (package, path) = rest.split_once(')')?;
        Some((package.trim().to_owned(), path.to_owned()))
    });
    match nested {
        Some((package, path)) => Ok(find(&package, answers)? + &path),
        None => Ok(resolved),
    }
}

fn command(inner: &str, answers: &dyn Answers) -> Result<String, Error> {
    let mut words = inner.split(' ').filter(|word| !word.is_empty());
    let command = words.next().unwrap_or_default();
    let words: Vec<&str> = words.collect();
    match (command, words.as_slice()) {
        ("arg", [name]) => answers
            .argument(name)
            .ok_or_else(|| Error::Argument((*name).to_owned())),
        ("find", [package]) => find(package, answers),
        ("env", [name]) => answers
            .environment(name)?
            .ok_or_else(|| Error::new(format!("the environment variable `{name}` is not set"))),
        ("optenv", [name, default @ ..]) => Ok(answers
            .environment(name)?
            .unwrap_or_else(|| default.join(" "))),
        ("dirname", []) => Ok(absolute(answers.folder()).display().to_string()),
        // An empty word is no substitution.
        ("", []) => Ok(format!("$({inner})")),
        ("arg" | "find" | "env" | "optenv" | "dirname", _) => Err(Error::new(format!(
            "$({inner}) has too many or too few words"
        ))),
        _ => Err(Error::new(format!(
            "$({inner}) is none of $(arg), $(find), $(env), $(optenv), $(dirname) and $(eval)"
        ))),
    }
}

fn find(package: &str, answers: &dyn Answers) -> Result<String, Error> {
    // Folders are searched.
    answers.budget().spend(FIND)?;
    answers
        .package(package)
        .ok_or_else(|| Error::Package(package.to_owned()))
}

/// The environment of an expression in `$(eval ...)`: the arguments, as numbers and truth values if
/// possible.
struct OfEval<'a> {
    answers: &'a dyn Answers,
}

impl Surroundings for OfEval<'_> {
    fn look_up(&self, name: &str) -> Result<Option<Value>, Error> {
        Ok(match name {
            "true" => Some(Value::Bool(true)),
            "false" => Some(Value::Bool(false)),
            _ => self.answers.argument(name).map(|value| automatic(&value)),
        })
    }

    fn look_up_in(&self, _: &Rc<dyn Any>, _: &str) -> Result<Option<Value>, Error> {
        Ok(None)
    }

    fn budget(&self) -> &Budget {
        self.answers.budget()
    }

    fn call(&self, _: XacroFunction, _: Arguments) -> Result<Value, Error> {
        Err(Error::new("$(eval ...) knows no functions of xacro"))
    }
}

/// Returns the value of an argument in `$(eval ...)`.
fn automatic(value: &str) -> Value {
    let number = if value.contains('.') {
        super::python::number(&Value::text(value)).map(Value::Float)
    } else {
        super::python::whole(value).map(Value::Int)
    };
    number.unwrap_or_else(|| match value.to_lowercase().as_str() {
        "true" => Value::Bool(true),
        "false" => Value::Bool(false),
        _ => Value::text(value),
    })
}
