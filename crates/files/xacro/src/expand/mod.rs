//! Expands a file in one pass over its elements: removes properties and macros, inserts includes,
//! blocks and called macros, and evaluates everything else.

mod calls;
mod clues;
mod elements;
mod faults;
mod includes;
mod names;
mod properties;
mod reported;
mod values;

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;

use super::budget::Budget;
use super::dom::{Node, Origin, Parsed, SourceFile, parse, write};
use super::macros::Macros;
use super::scope::Scope;
use super::{ExpandError, Expanded, Host, Missing, Note, Reason, Settings};
use crate::xml;

type Result<T> = std::result::Result<T, Box<ExpandError>>;

/// Largest number of files matched by an include's pattern.
const MOST_FILES: usize = 1000;
/// Largest number of attributes set by `<xacro:attribute>` on one element.
const MOST_ATTRIBUTES: usize = 200;
/// Largest number of XML namespaces.
const MOST_NAMESPACES: usize = 100;
/// Levels charged for an element; an expression takes one.
const LEVELS_OF_ELEMENT: usize = 3;

/// Expands a file.
pub(super) fn expand(
    file: &Rc<SourceFile>,
    settings: &Settings,
    host: &dyn Host,
) -> Result<Expanded> {
    let expander = Expander {
        settings,
        host,
        budget: Budget::new(),
        arguments: RefCell::new(settings.arguments.clone()),
        declared: RefCell::default(),
        reading: RefCell::new(vec![Rc::clone(file)]),
        calls: RefCell::default(),
        missing: RefCell::default(),
        notes: RefCell::default(),
        namespaces: RefCell::default(),
        scopes: RefCell::default(),
        defined: RefCell::default(),
        called: RefCell::default(),
        unprefixed: RefCell::default(),
        texts: RefCell::default(),
        clues: clues::Clues::default(),
        old: RefCell::default(),
    };
    let result = expander.run(file);
    for scope in expander.scopes.borrow().iter() {
        scope.clear();
    }
    result
}

/// A file's name in messages, and its text.
type NameAndText = (Arc<str>, Arc<str>);

struct Expander<'a> {
    settings: &'a Settings<'a>,
    host: &'a dyn Host,
    budget: Budget,
    arguments: RefCell<BTreeMap<String, String>>,
    /// The arguments declared by the file.
    declared: RefCell<BTreeSet<String>>,
    /// The files being read, the innermost last.
    reading: RefCell<Vec<Rc<SourceFile>>>,
    /// The macro calls being expanded, the innermost last.
    calls: RefCell<Vec<(String, Origin)>>,
    missing: RefCell<Vec<Missing>>,
    notes: RefCell<Vec<Note>>,
    /// Prefixes and addresses of XML namespaces, for all files.
    namespaces: RefCell<Vec<(String, String)>>,
    /// Scopes with references to each other.
    scopes: RefCell<Vec<Rc<Scope>>>,
    defined: RefCell<BTreeSet<String>>,
    called: RefCell<BTreeSet<String>>,
    /// What stands in the expansion because it lacks the prefix.
    unprefixed: RefCell<BTreeSet<String>>,
    /// The text of each file, shared by all places in it.
    texts: RefCell<BTreeMap<String, NameAndText>>,
    clues: clues::Clues,
    /// The first element without the prefix required since 2014.
    old: RefCell<Option<(String, Origin)>>,
}

/// The scopes for lookups.
#[derive(Clone)]
struct Around {
    scope: Rc<Scope>,
    macros: Rc<Macros>,
}

/// The evaluated content of an element.
#[derive(Default)]
struct Inside {
    nodes: Vec<Node>,
    /// Attributes set by `<xacro:attribute>` on the surrounding element.
    attributes: Vec<(String, String)>,
}

impl Expander<'_> {
    fn run(&self, file: &Rc<SourceFile>) -> Result<Expanded> {
        let Parsed { root, namespaces } = self.parse(file)?;
        self.add_namespaces(namespaces);
        let around = Around {
            scope: Scope::new(None, false),
            macros: Macros::new(None),
        };
        self.scopes.borrow_mut().push(Rc::clone(&around.scope));
        let expanded = self.element(&root, &around);
        let missing = self.missing.borrow().clone();
        let kept = missing.is_empty() || self.settings.leave_out_missing;
        let root = match expanded {
            Ok(root) if kept => root,
            result => {
                let mut failure = match result {
                    Err(failure) if kept || !matches!(failure.reason, Reason::Other(_)) => failure,
                    // All missing things are reported at once, before possible consequences.
                    _ => self.failure(Reason::Missing, None),
                };
                failure.missing = missing;
                failure.of_before_2014 = self.old.borrow().is_some();
                return Err(failure);
            }
        };
        let watched = self.watched(&around.scope);
        let choices = self.choices();
        let (text, origins) = write(&root, &self.namespaces.borrow());
        let declared = self.declared.borrow();
        let arguments = self.arguments.borrow();
        let value = |name: &String| Some((name.clone(), arguments.get(name)?.clone()));
        let called = self.called.borrow();
        Ok(Expanded {
            text,
            origins: origins
                .into_iter()
                .map(|(at, origin)| (at, self.place(&origin)))
                .collect(),
            notes: self.notes.borrow().clone(),
            arguments: declared.iter().filter_map(value).collect(),
            watched,
            choices,
            uncalled: self.defined.borrow().difference(&called).cloned().collect(),
            unprefixed: self.unprefixed.borrow().iter().cloned().collect(),
        })
    }

    fn parse(&self, file: &Rc<SourceFile>) -> Result<Parsed> {
        let at = |bytes| Origin {
            file: Rc::clone(file),
            bytes,
        };
        let whole = at(0..0);
        self.budget
            .spend_bytes(file.text.len())
            .map_err(self.spent(&whole))?;
        parse(file).map_err(|fault| match fault {
            xml::Fault::Malformed(reason, bytes) => {
                self.failure(Reason::Xml(reason), Some(&at(bytes)))
            }
            xml::Fault::TooMuch(what, most, bytes) => {
                self.failure(Reason::TooMuch(what, most), Some(&at(bytes)))
            }
        })
    }

    fn add_namespaces(&self, found: Vec<(String, String)>) {
        let mut known = self.namespaces.borrow_mut();
        for (prefix, address) in found {
            let is_new = known.len() < MOST_NAMESPACES && !known.iter().any(|(p, _)| *p == prefix);
            if prefix != "xacro" && is_new {
                known.push((prefix, address));
            }
        }
    }

    /// The base folder of the file being read.
    fn folder(&self) -> std::path::PathBuf {
        let reading = self.reading.borrow();
        reading.last().map(|f| f.folder.clone()).unwrap_or_default()
    }

    fn find_package(&self, name: &str) -> Option<String> {
        let folder = self.host.package(name, &self.folder())?;
        Some(folder.display().to_string())
    }
}
