//! Macros: syntax of their parameters, and storage.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use super::dom::Element;

/// A macro.
#[derive(Debug)]
pub(super) struct Macro {
    pub(super) name: String,
    pub(super) body: Rc<Element>,
    pub(super) parameters: Vec<Parameter>,
}

/// A parameter of a macro.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Parameter {
    /// Its name, including the `*` or `**` of a block.
    pub(super) name: String,
    /// Whether `^` takes it from the caller.
    pub(super) forwarded: bool,
    /// Its default.
    pub(super) default: Option<String>,
}

impl Parameter {
    /// Size of its texts in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.name.len() + self.default.as_ref().map_or(0, String::len)
    }
}

/// A set of macros inside another, with further namespaces.
#[derive(Debug)]
pub(super) struct Macros {
    entries: RefCell<HashMap<String, Entry>>,
    parent: Option<Rc<Macros>>,
}

#[derive(Clone, Debug)]
enum Entry {
    Macro(Rc<Macro>),
    Namespace(Rc<Macros>),
}

impl Macros {
    pub(super) fn new(parent: Option<Rc<Macros>>) -> Rc<Self> {
        Rc::new(Self {
            entries: RefCell::default(),
            parent,
        })
    }

    pub(super) fn define(&self, definition: Macro) {
        let name = definition.name.clone();
        self.put(name, Entry::Macro(Rc::new(definition)));
    }

    /// Adds an empty namespace with that name.
    pub(super) fn add_namespace(&self, name: &str) -> Rc<Macros> {
        let namespace = Macros::new(None);
        self.put(name.to_owned(), Entry::Namespace(Rc::clone(&namespace)));
        namespace
    }

    fn put(&self, name: String, known: Entry) {
        self.entries.borrow_mut().insert(name, known);
    }

    fn find(&self, name: &str) -> Option<Entry> {
        let own = self.entries.borrow().get(name).cloned();
        own.or_else(|| self.parent.as_ref()?.find(name))
    }

    /// Returns the macro of a name, possibly with dotted namespaces, with its surrounding macros
    /// and the namespaces passed.
    pub(super) fn resolve<'n>(
        self: &Rc<Self>,
        name: &'n str,
    ) -> Option<(Rc<Macro>, Rc<Macros>, Vec<&'n str>)> {
        if let Some(Entry::Macro(found)) = self.find(name) {
            return Some((found, Rc::clone(self), Vec::new()));
        }
        let mut namespaces: Vec<&str> = name.split('.').collect();
        let last = namespaces.pop()?;
        let mut around = Rc::clone(self);
        for namespace in &namespaces {
            match around.find(namespace)? {
                Entry::Namespace(inner) => around = inner,
                Entry::Macro(_) => return None,
            }
        }
        match around.find(last)? {
            Entry::Macro(found) => Some((found, around, namespaces)),
            Entry::Namespace(_) => None,
        }
    }

    /// Returns the names of all macros, including namespaces, for messages about an unknown one.
    pub(super) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for (name, known) in self.entries.borrow().iter() {
            match known {
                Entry::Macro(_) => names.push(name.clone()),
                Entry::Namespace(inner) => {
                    names.extend(inner.names().iter().map(|n| format!("{name}.{n}")));
                }
            }
        }
        if let Some(parent) = &self.parent {
            names.extend(parent.names());
        }
        names.sort();
        names
    }
}

/// Parses the parameters of a macro from `params`: `name`, `name:=default`, `name:=^`,
/// `name:=^|default`, `*block`.
///
/// A default ends at the next space outside quotes; one that begins with `${` or `$(` ends at the
/// first closing bracket followed by a space.
pub(super) fn parameters(text: &str) -> Vec<Parameter> {
    let mut parameters = Vec::new();
    let mut rest = text;
    while !rest.is_empty() {
        match with_default(rest) {
            Some((parameter, after)) => {
                parameters.push(parameter);
                rest = after;
            }
            None => {
                let trimmed = rest.trim_start();
                let end = trimmed.find(char::is_whitespace).unwrap_or(trimmed.len());
                if trimmed.is_empty() {
                    break;
                }
                parameters.push(Parameter {
                    name: trimmed[..end].to_owned(),
                    forwarded: false,
                    default: None,
                });
                rest = trimmed[end..].trim_start();
            }
        }
    }
    parameters
}

/// Returns the first parameter, if it has a default, and the rest.
fn with_default(text: &str) -> Option<(Parameter, &str)> {
    let trimmed = text.trim_start();
    let name_end = trimmed.find(|c: char| c.is_whitespace() || c == ':' || c == '=')?;
    if name_end == 0 {
        return None;
    }
    let after_name = trimmed[name_end..].trim_start();
    let after_sign = after_name
        .strip_prefix(":=")
        .or_else(|| after_name.strip_prefix('='))?;
    let value = after_sign.trim_start();
    let (forwarded, value) = match value.strip_prefix('^') {
        Some(value) => (true, value.strip_prefix('|').unwrap_or(value)),
        None => (false, value),
    };
    let end = default_end(value)?;
    let default = &value[..end];
    let parameter = Parameter {
        name: trimmed[..name_end].to_owned(),
        forwarded,
        default: (!default.is_empty()).then(|| default.to_owned()),
    };
    Some((parameter, value[end..].trim_start()))
}

/// Returns the end of the default at the start of a text.
fn default_end(text: &str) -> Option<usize> {
    let ends_here = |end: usize| {
        let next = text[end..].chars().next();
        next.is_none_or(char::is_whitespace)
    };
    for (open, close) in [("${", '}'), ("$(", ')')] {
        if text.starts_with(open) {
            let closes = text.match_indices(close).map(|(at, _)| at + 1);
            if let Some(end) = closes.into_iter().find(|end| ends_here(*end)) {
                return Some(end);
            }
        }
    }
    let mut end = 0;
    while let Some(c) = text[end..].chars().next() {
        if c.is_whitespace() {
            break;
        }
        if c == '\'' || c == '"' {
            end += match text[end + 1..].find(c) {
                Some(length) => length + 2,
                // Of three quotes the middle one is the quoted character.
                None if text[..end].ends_with(c) => 1,
                // An unpaired quote is no default.
                None => return None,
            };
        } else {
            end += c.len_utf8();
        }
    }
    Some(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Vec<(String, bool, Option<String>)> {
        parameters(text)
            .into_iter()
            .map(|p| (p.name, p.forwarded, p.default))
            .collect()
    }

    fn plain(name: &str) -> (String, bool, Option<String>) {
        (name.to_owned(), false, None)
    }

    fn with(name: &str, default: &str) -> (String, bool, Option<String>) {
        (name.to_owned(), false, Some(default.to_owned()))
    }

    #[test]
    fn parameters_are_split_at_spaces_outside_quotes_and_expressions() {
        assert_eq!(
            read("a b:=1 c:=${x + 1} d:='two words' *block **blocks"),
            [
                plain("a"),
                with("b", "1"),
                with("c", "${x + 1}"),
                with("d", "'two words'"),
                plain("*block"),
                plain("**blocks")
            ]
        );
    }

    #[test]
    fn of_three_quotes_the_one_between_is_quoted() {
        let three = with("a", "\x27\x27\x27");
        assert_eq!(read("a:=''' b:=2"), [three, with("b", "2")]);
    }

    #[test]
    fn older_files_write_a_lone_equals_sign_and_spaces_around_it() {
        assert_eq!(read(" a=1  b := 2 "), [with("a", "1"), with("b", "2")]);
    }

    #[test]
    fn a_caret_takes_the_value_from_outside() {
        let forwarded =
            |name: &str, default: Option<&str>| (name.to_owned(), true, default.map(str::to_owned));
        assert_eq!(
            read("a:=^ b:=^|3 c"),
            [forwarded("a", None), forwarded("b", Some("3")), plain("c")]
        );
    }

    #[test]
    fn an_unpaired_quote_makes_a_name_and_no_default() {
        assert_eq!(read("a:='x b"), [plain("a:='x"), plain("b")]);
    }
}
