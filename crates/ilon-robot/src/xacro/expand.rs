//! Goes through a file's elements once, from the top: takes properties and macros out, puts includes, blocks and called macros
//! in, and evaluates everything else.

use std::any::Any;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use super::budget::{Budget, Spent};
use super::dom::{Attribute, Element, Node, Origin, Parsed, SourceFile, parse, write};
use super::macros::{Macro, Macros, parameters};
use super::python::{
    Arguments, Error, Surroundings, Value, XacroFunction, evaluate, is_global, literal, text,
};
use super::scope::{Entry, Scope};
use super::substitution::{self, Answers};
use super::text::{Piece, joined, pieces, truth};
use super::{
    Expanded, Failure, MAX_BYTES, Missing, Note, Place, Reason, Settings, from_folder, packages,
    yaml,
};
use crate::files::FileFault;
use crate::xml;

type Result<T> = std::result::Result<T, Box<Failure>>;

/// Most files that a pattern in an include may name.
const MOST_FILES: usize = 1000;
/// Most attributes that `<xacro:attribute>` may set on one element.
const MOST_ATTRIBUTES: usize = 200;
/// Most XML namespaces that are kept.
const MOST_NAMESPACES: usize = 100;
/// Levels of the limit that an element takes; an expression takes one.
const LEVELS_OF_ELEMENT: usize = 3;

/// Expands a file.
pub(super) fn expand(file: &Rc<SourceFile>, settings: &Settings) -> Result<Expanded> {
    let expander = Expander {
        settings,
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
        texts: RefCell::default(),
    };
    let result = expander.run(file);
    for scope in expander.scopes.borrow().iter() {
        scope.clear();
    }
    result
}

struct Expander<'a> {
    settings: &'a Settings<'a>,
    budget: Budget,
    arguments: RefCell<BTreeMap<String, String>>,
    /// The arguments that the file declares.
    declared: RefCell<BTreeSet<String>>,
    /// The files that are being read, the innermost last.
    reading: RefCell<Vec<Rc<SourceFile>>>,
    /// The macro calls that are being expanded, the innermost last.
    calls: RefCell<Vec<(String, Origin)>>,
    missing: RefCell<Vec<Missing>>,
    notes: RefCell<Vec<Note>>,
    /// Prefixes and addresses of XML namespaces, of all files.
    namespaces: RefCell<Vec<(String, String)>>,
    /// Scopes that know each other.
    scopes: RefCell<Vec<Rc<Scope>>>,
    defined: RefCell<BTreeSet<String>>,
    called: RefCell<BTreeSet<String>>,
    /// The text of each file once, to be shared by the places in it.
    texts: RefCell<BTreeMap<String, (Arc<str>, Arc<str>)>>,
}

/// Where names are looked up.
#[derive(Clone)]
struct Around {
    scope: Rc<Scope>,
    macros: Rc<Macros>,
}

/// What becomes of an element's inside.
#[derive(Default)]
struct Inside {
    nodes: Vec<Node>,
    /// What `<xacro:attribute>` sets on the element that holds it.
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
                    // What is missing is named all at once, and before what may follow from it.
                    _ => self.failure(Reason::Missing, None),
                };
                failure.missing = missing;
                return Err(failure);
            }
        };
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
            uncalled: self.defined.borrow().difference(&called).cloned().collect(),
        })
    }

    // Faults and notes.

    fn place(&self, origin: &Origin) -> Place {
        let mut texts = self.texts.borrow_mut();
        let file = &origin.file;
        let (name, text) = texts
            .entry(file.name.clone())
            .or_insert_with(|| (Arc::from(file.name.as_str()), Arc::from(&*file.text)));
        Place {
            file: Arc::clone(name),
            text: Arc::clone(text),
            bytes: origin.bytes.clone(),
        }
    }

    fn failure(&self, reason: Reason, origin: Option<&Origin>) -> Box<Failure> {
        let calls = self.calls.borrow();
        let trail = calls
            .iter()
            .rev()
            .map(|(name, origin)| format!("called as `{name}` at {}", self.line(origin)));
        Box::new(Failure {
            reason,
            place: origin.map(|origin| self.place(origin)),
            // The outermost calls say where it began, the innermost where it ended; hundreds between them say nothing.
            trail: trail.take(8).collect(),
            missing: Vec::new(),
            of_missing: false,
        })
    }

    fn fault(&self, origin: &Origin, words: impl Into<String>) -> Box<Failure> {
        self.failure(Reason::Other(words.into()), Some(origin))
    }

    fn spent(&self, origin: &Origin) -> impl Fn(Spent) -> Box<Failure> {
        move |spent| self.fault(origin, spent.to_string())
    }

    fn error(&self, origin: &Origin, error: &Error) -> Box<Failure> {
        let reason = match error.cause() {
            Error::Argument(name) => Reason::Argument(name.clone()),
            Error::Package(name) => {
                self.miss(Missing {
                    what: format!("$(find {name})"),
                    package: Some(name.clone()),
                    reason: String::new(),
                    at: self.line(origin),
                });
                Reason::Missing
            }
            Error::File(name, reason) => {
                self.miss(Missing {
                    what: name.clone(),
                    package: None,
                    reason: reason.clone(),
                    at: self.line(origin),
                });
                Reason::Missing
            }
            _ => Reason::Other(error.to_string()),
        };
        let mut failure = self.failure(reason, Some(origin));
        failure.of_missing = matches!(
            error.cause(),
            Error::Name(_) | Error::Package(_) | Error::File(..)
        );
        failure
    }

    /// Goes without what fails for want of what is missing, if that may be.
    fn or_without(
        &self,
        origin: &Origin,
        subject: &str,
        expanded: Result<()>,
        (calls, reading): (usize, usize),
    ) -> Result<()> {
        match expanded {
            Err(failure)
                if failure.of_missing
                    && self.settings.leave_out_missing
                    && !self.missing.borrow().is_empty() =>
            {
                self.calls.borrow_mut().truncate(calls);
                self.reading.borrow_mut().truncate(reading);
                let why = match &failure.reason {
                    Reason::Other(words) => words.clone(),
                    _ => "it needs what is missing".to_owned(),
                };
                self.note(origin, subject, format!("left out: {why}"));
                Ok(())
            }
            other => other,
        }
    }

    /// How deep in calls and in files the expansion is.
    fn depths(&self) -> (usize, usize) {
        (self.calls.borrow().len(), self.reading.borrow().len())
    }

    /// `file:line`.
    fn line(&self, origin: &Origin) -> String {
        let before = &origin.file.text[..origin.bytes.start];
        format!("{}:{}", origin.file.name, 1 + before.matches('\n').count())
    }

    fn note(&self, origin: &Origin, subject: &str, words: String) {
        let mut notes = self.notes.borrow_mut();
        // A macro that is called a thousand times says the same a thousand times.
        let known = notes
            .iter()
            .any(|note| note.words == words && note.subject == subject);
        if !known && notes.len() < 200 {
            notes.push(Note {
                subject: subject.to_owned(),
                place: self.place(origin),
                words,
            });
        }
    }

    fn miss(&self, missing: Missing) {
        let mut all = self.missing.borrow_mut();
        if all.len() < 200 && !all.iter().any(|known| known.what == missing.what) {
            all.push(missing);
        }
    }

    // Reading.

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

    /// The folder from which the file that is read names others.
    fn folder(&self) -> std::path::PathBuf {
        let reading = self.reading.borrow();
        reading.last().map(|f| f.folder.clone()).unwrap_or_default()
    }

    fn find_package(&self, name: &str) -> Option<String> {
        let packages = packages(&self.folder(), self.settings);
        let folder = packages.find(name, |folder| self.settings.files.is_folder(folder))?;
        Some(folder.display().to_string())
    }

    // Texts.

    /// The value of a text with expressions in it.
    fn text(&self, whole: &str, scope: &Rc<Scope>) -> std::result::Result<Value, Error> {
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
                        .and_then(|inner| evaluate(&text(&inner), &view));
                    evaluated.map_err(|e| e.within(format!("`${{{inner}}}`")))?
                }
                Piece::Substitution(inner) => {
                    let folder = self.folder();
                    let answers = Substitutions {
                        expander: self,
                        folder: &folder,
                    };
                    let inner = text(&self.text(inner, scope)?);
                    Value::text(substitution::resolve(&inner, &answers)?)
                }
            });
        }
        let value = joined(values);
        if let Value::Text(text) = &value {
            self.budget.spend_bytes(text.len())?;
        }
        Ok(value)
    }

    /// The value of an attribute of an element.
    fn attribute(&self, element: &Element, name: &str, around: &Around) -> Result<Option<Value>> {
        match element.attribute(name) {
            None => Ok(None),
            Some(value) => match self.text(value, &around.scope) {
                Ok(value) => Ok(Some(value)),
                Err(e) => Err(self.error(&element.origin_of(name), &e)),
            },
        }
    }

    fn required(&self, element: &Element, name: &str, around: &Around) -> Result<Value> {
        self.attribute(element, name, around)?
            .ok_or_else(|| self.missing_attribute(element, name))
    }

    fn missing_attribute(&self, element: &Element, name: &str) -> Box<Failure> {
        self.fault(
            &element.origin,
            format!("`<{}>`: the attribute `{name}` is missing", element.name),
        )
    }

    fn yes_or_no(
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
                    text(&value)
                ),
            )
        })
    }

    // Elements.

    /// An element that stays, evaluated.
    fn element(&self, element: &Element, around: &Around) -> Result<Element> {
        let mut attributes = self.attributes(element, around)?;
        let Inside {
            nodes,
            attributes: set,
        } = self.inside(element, around)?;
        for (name, value) in set {
            attributes.retain(|a| a.name != name);
            attributes.push(Attribute {
                name,
                value,
                bytes: element.origin.bytes.clone(),
            });
        }
        Ok(Element {
            name: element.name.clone(),
            attributes,
            children: nodes,
            origin: element.origin.clone(),
        })
    }

    fn attributes(&self, element: &Element, around: &Around) -> Result<Vec<Attribute>> {
        let mut attributes = Vec::with_capacity(element.attributes.len());
        for a in &element.attributes {
            if a.name.starts_with("xacro:") {
                continue;
            }
            let value = self.kept_text(&a.value, &around.scope, &element.origin_of(&a.name))?;
            attributes.push(Attribute {
                name: a.name.clone(),
                value,
                bytes: a.bytes.clone(),
            });
        }
        Ok(attributes)
    }

    /// A text that stays in the expansion. Where it names a package that is not known, it is left as it is: meshes and settings
    /// of other programs matter only where they are needed.
    fn kept_text(&self, whole: &str, scope: &Rc<Scope>, origin: &Origin) -> Result<String> {
        match self.text(whole, scope) {
            Ok(value) => Ok(text(&value)),
            Err(e) => match e.cause() {
                Error::Package(package) => {
                    let words = format!(
                        "the folder of the package `{package}` is not known: `$(find {package})` is left as it is"
                    );
                    self.note(origin, &format!("package `{package}`"), words);
                    Ok(whole.to_owned())
                }
                _ => Err(self.error(origin, &e)),
            },
        }
    }

    /// What becomes of all that stands inside an element.
    fn inside(&self, element: &Element, around: &Around) -> Result<Inside> {
        let spent = self.spent(&element.origin);
        let _level = self.budget.enter(LEVELS_OF_ELEMENT).map_err(&spent)?;
        let mut inside = Inside::default();
        for node in &element.children {
            self.budget.spend(4).map_err(&spent)?;
            match node {
                Node::Element(child) => self.child(child, around, &mut inside)?,
                Node::Verbatim(_) => inside.nodes.push(node.clone()),
                Node::Text(whole) => {
                    let value = self.kept_text(whole, &around.scope, &element.origin)?;
                    inside.nodes.push(Node::Text(value.into()));
                }
            }
        }
        Ok(inside)
    }

    fn child(&self, child: &Rc<Element>, around: &Around, inside: &mut Inside) -> Result<()> {
        match child.name.strip_prefix("xacro:") {
            None => {
                let element = self.element(child, around)?;
                inside.nodes.push(Node::Element(Rc::new(element)));
            }
            Some("property") => self.property(child, around)?,
            Some("macro") => self.define_macro(child, around)?,
            Some("arg") => self.declare_argument(child, around)?,
            Some("include") => self.include(child, around, inside)?,
            Some("insert_block") => self.insert_block(child, around, inside)?,
            Some("element") => self.named_element(child, around, inside)?,
            Some("attribute") => {
                let name = text(&self.required(child, "name", around)?);
                let value = text(&self.required(child, "value", around)?);
                if !is_xml_name(&name) {
                    let words = format!("`<xacro:attribute>`: `{name}` is no name of an attribute");
                    return Err(self.fault(&child.origin, words));
                }
                inside.attributes.retain(|(other, _)| *other != name);
                inside.attributes.push((name, value));
                if inside.attributes.len() > MOST_ATTRIBUTES {
                    let words =
                        format!("more than {MOST_ATTRIBUTES} attributes are set on one element");
                    return Err(self.fault(&child.origin, words));
                }
            }
            Some(condition @ ("if" | "unless")) => {
                if child.attribute("value").is_none() {
                    return Err(self.missing_attribute(child, "value"));
                }
                let holds = self.yes_or_no(child, "value", false, around)?;
                if holds == (condition == "if") {
                    inside.nodes.extend(self.inside(child, around)?.nodes);
                }
            }
            Some("call") => {
                let name = text(&self.required(child, "macro", around)?);
                if name.is_empty() {
                    return Err(
                        self.fault(&child.origin, "`<xacro:call>`: the macro's name is empty")
                    );
                }
                let mut call = (**child).clone();
                call.attributes.retain(|a| a.name != "macro");
                self.call_macro(&call, &name, around, inside)?;
            }
            Some(name) => self.call_macro(child, name, around, inside)?,
        }
        Ok(())
    }

    /// `<xacro:element xacro:name="...">`: an element whose name is evaluated.
    fn named_element(
        &self,
        child: &Rc<Element>,
        around: &Around,
        inside: &mut Inside,
    ) -> Result<()> {
        let name = text(&self.required(child, "xacro:name", around)?);
        if !is_xml_name(&name) {
            return Err(self.fault(
                &child.origin,
                format!("`<xacro:element>`: `{name}` is no name of an element"),
            ));
        }
        let mut element = (**child).clone();
        element.attributes.retain(|a| a.name != "xacro:name");
        element.name = name;
        let _level = self
            .budget
            .enter(LEVELS_OF_ELEMENT)
            .map_err(self.spent(&child.origin))?;
        self.child(&Rc::new(element), around, inside)
    }

    // Properties and arguments.

    fn property(&self, element: &Rc<Element>, around: &Around) -> Result<()> {
        let scope = &around.scope;
        let name = text(&self.required(element, "name", around)?);
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

    fn declare_argument(&self, element: &Element, around: &Around) -> Result<()> {
        let name = element
            .attribute("name")
            .ok_or_else(|| self.missing_attribute(element, "name"))?;
        self.declared.borrow_mut().insert(name.to_owned());
        let known = self.arguments.borrow().contains_key(name);
        if known {
            return Ok(());
        }
        if let Some(default) = self.attribute(element, "default", around)? {
            let mut arguments = self.arguments.borrow_mut();
            arguments.insert(name.to_owned(), text(&default));
        }
        Ok(())
    }

    /// The value of a name, evaluated now if it was not before.
    fn resolve(&self, scope: &Rc<Scope>, name: &str) -> std::result::Result<Option<Value>, Error> {
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

    // Includes.

    fn include(&self, element: &Element, around: &Around, inside: &mut Inside) -> Result<()> {
        let written = element
            .attribute("filename")
            .ok_or_else(|| self.missing_attribute(element, "filename"))?;
        let optional = self.yes_or_no(element, "optional", false, around)?;
        let within = match self.attribute(element, "ns", around)? {
            None => around.clone(),
            Some(name) => {
                let name = text(&name);
                let scope = Scope::new(Some(Rc::clone(&around.scope)), true);
                self.scopes.borrow_mut().push(Rc::clone(&scope));
                let value: Rc<dyn Any> = Rc::clone(&scope) as Rc<dyn Any>;
                around
                    .scope
                    .set(name.clone(), Value::Namespace(value), false);
                Around {
                    scope,
                    macros: around.macros.add_namespace(&name),
                }
            }
        };
        let origin = element.origin_of("filename");
        let name = match self.text(written, &around.scope) {
            Ok(name) => text(&name),
            Err(e) => match e.cause() {
                Error::Package(package) => {
                    let (what, package) = (written.to_owned(), Some(package.clone()));
                    if !optional {
                        self.miss_include(&origin, what, package, String::new());
                    }
                    return Ok(());
                }
                _ => return Err(self.error(&origin, &e)),
            },
        };
        for path in self.included_files(&name, &origin) {
            match self.settings.files.read_text(&path, MAX_BYTES) {
                Ok(text) => {
                    let depths = self.depths();
                    let included = self.include_file(&path, text, &origin, &within, inside);
                    let subject = format!("include `{name}`");
                    self.or_without(&origin, &subject, included, depths)?;
                }
                Err(_) if optional => {}
                Err(fault) => {
                    let reason = match fault {
                        FileFault::Missing => String::new(),
                        other => other.to_string(),
                    };
                    self.miss_include(&origin, name.clone(), None, reason);
                }
            }
        }
        Ok(())
    }

    fn miss_include(&self, origin: &Origin, what: String, package: Option<String>, reason: String) {
        let words = match (&package, reason.as_str()) {
            (Some(package), _) => {
                format!("left out, for the folder of the package `{package}` is not known")
            }
            (None, "") => "left out, for there is no such file".to_owned(),
            (None, reason) => format!("left out: {reason}"),
        };
        self.note(origin, &format!("include `{what}`"), words);
        self.miss(Missing {
            what,
            package,
            reason,
            at: self.line(origin),
        });
    }

    /// The files that an include names: one, or those that match a pattern in its last part.
    fn included_files(&self, name: &str, origin: &Origin) -> Vec<std::path::PathBuf> {
        let path = from_folder(&self.folder(), name);
        if !name.contains(['*', '?', '[']) {
            return vec![path];
        }
        let (Some(folder), Some(pattern)) = (path.parent(), path.file_name()) else {
            return Vec::new();
        };
        let pattern = pattern.to_string_lossy().into_owned();
        let names = self.settings.files.names_in(folder, MOST_FILES);
        let found: Vec<_> = names
            .iter()
            .filter(|name| matches_pattern(name, &pattern))
            .map(|name| folder.join(name))
            .collect();
        if found.is_empty() {
            let words = "no file matches the pattern".to_owned();
            self.note(origin, &format!("include `{name}`"), words);
        }
        found
    }

    fn include_file(
        &self,
        path: &Path,
        text: String,
        origin: &Origin,
        around: &Around,
        inside: &mut Inside,
    ) -> Result<()> {
        let _level = self
            .budget
            .enter(16 * LEVELS_OF_ELEMENT)
            .map_err(self.spent(origin))?;
        let file = Rc::new(SourceFile {
            name: path.display().to_string(),
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            text: text.into(),
        });
        let Parsed { root, namespaces } = self.parse(&file)?;
        self.add_namespaces(namespaces);
        self.reading.borrow_mut().push(file);
        // Its root's attributes are evaluated, though nothing keeps them.
        let included = self
            .attributes(&root, around)
            .and_then(|_| self.inside(&root, around));
        let included = included.map_err(|mut failure| {
            if failure.trail.len() < 8 {
                failure
                    .trail
                    .push(format!("included at {}", self.line(origin)));
            }
            failure
        })?;
        self.reading.borrow_mut().pop();
        inside.nodes.extend(included.nodes);
        Ok(())
    }

    // Macros and blocks.

    fn define_macro(&self, element: &Rc<Element>, around: &Around) -> Result<()> {
        let name = element
            .attribute("name")
            .ok_or_else(|| self.missing_attribute(element, "name"))?;
        if name == "call" || name.contains('.') {
            return Err(self.fault(
                &element.origin_of("name"),
                format!("`{name}` is no name of a macro: `call` and names with dots are taken"),
            ));
        }
        let name = name.strip_prefix("xacro:").unwrap_or(name);
        self.defined.borrow_mut().insert(name.to_owned());
        around.macros.define(Macro {
            name: name.to_owned(),
            body: Rc::clone(element),
            parameters: parameters(element.attribute("params").unwrap_or_default()),
        });
        Ok(())
    }

    fn call_macro(
        &self,
        call: &Element,
        name: &str,
        around: &Around,
        inside: &mut Inside,
    ) -> Result<()> {
        let depths = self.depths();
        let called = self.expand_call(call, name, around, inside);
        let subject = format!("`<{}>`", call.name);
        self.or_without(&call.origin, &subject, called, depths)
    }

    fn expand_call(
        &self,
        call: &Element,
        name: &str,
        around: &Around,
        inside: &mut Inside,
    ) -> Result<()> {
        let resolved = around
            .macros
            .resolve(name)
            .and_then(|(found, macros, path)| {
                let scope = namespace(self, &around.scope, &path)?;
                Some((found, macros, scope))
            });
        let Some((found, macros, outer_scope)) = resolved else {
            return self.unknown_macro(call, name, around);
        };
        self.called.borrow_mut().insert(found.name.clone());
        let scope = Scope::new(Some(outer_scope), false);
        // Names are looked up through all scopes around.
        self.budget
            .spend(1 + scope.depth() / 4)
            .map_err(self.spent(&call.origin))?;
        let within = Around {
            macros: Macros::new(Some(macros)),
            scope,
        };
        self.calls
            .borrow_mut()
            .push((found.name.clone(), call.origin.clone()));
        let _level = self
            .budget
            .enter(LEVELS_OF_ELEMENT)
            .map_err(self.spent(&call.origin))?;
        self.pass_parameters(call, &found, around, &within.scope)?;
        let body = self.macro_body(&found, &within)?;
        self.calls.borrow_mut().pop();
        inside.nodes.extend(body.nodes);
        Ok(())
    }

    fn macro_body(&self, found: &Macro, within: &Around) -> Result<Inside> {
        // The attributes of the definition are evaluated once more at each call, though nothing keeps them; its parameters
        // hold what is only known inside.
        self.inside(&found.body, within)
    }

    fn unknown_macro(&self, call: &Element, name: &str, around: &Around) -> Result<()> {
        if !self.missing.borrow().is_empty() {
            // It may come from what is not there.
            let words = "left out, for nothing that could be read defines this macro".to_owned();
            self.note(&call.origin, &format!("`<{}>`", call.name), words);
            return Ok(());
        }
        let names = around.macros.names();
        let known = if names.is_empty() {
            "no macro is defined here".to_owned()
        } else {
            let shown: Vec<String> = names.iter().take(12).map(|n| format!("`{n}`")).collect();
            format!("defined are {}", shown.join(", "))
        };
        Err(self.fault(&call.origin, format!("there is no macro `{name}`: {known}")))
    }

    /// Gives a macro's parameters their values: attributes, blocks, forwarded names, defaults.
    fn pass_parameters(
        &self,
        call: &Element,
        found: &Macro,
        around: &Around,
        scope: &Rc<Scope>,
    ) -> Result<()> {
        let mut open = found.parameters.clone();
        for a in &call.attributes {
            let Some(at) = open.iter().position(|p| p.name == a.name) else {
                return Err(self.fault(
                    &call.origin_of(&a.name),
                    format!("the macro `{}` has no parameter `{}`", found.name, a.name),
                ));
            };
            open.remove(at);
            let value = self
                .text(&a.value, &around.scope)
                .map_err(|e| self.error(&call.origin_of(&a.name), &e))?;
            scope.set(a.name.clone(), value, false);
        }
        // Blocks are evaluated where they stand, and once more where they are inserted.
        let inside = self.inside(call, around)?;
        let mut blocks = inside.nodes.into_iter().filter_map(|node| match node {
            Node::Element(element) => Some(element),
            Node::Text(_) | Node::Verbatim(_) => None,
        });
        for parameter in open.iter().filter(|p| p.name.starts_with('*')) {
            let Some(block) = blocks.next() else {
                return Err(self.fault(
                    &call.origin,
                    format!(
                        "the macro `{}` takes a block `{}`, which is not given",
                        found.name, parameter.name
                    ),
                ));
            };
            scope.put(parameter.name.clone(), Entry::Block(block));
        }
        if let Some(block) = blocks.next() {
            return Err(self.fault(
                &block.origin,
                format!(
                    "the macro `{}` takes no block `<{}>`",
                    found.name, block.name
                ),
            ));
        }
        open.retain(|p| !p.name.starts_with('*'));
        let mut undefined = Vec::new();
        for parameter in open {
            let forwarded = if parameter.forwarded {
                self.resolve(&around.scope, &parameter.name)
                    .map_err(|e| self.error(&call.origin, &e))?
            } else {
                None
            };
            let value = match (forwarded, &parameter.default) {
                (Some(value), _) => value,
                (None, Some(default)) => self
                    .text(default, &around.scope)
                    .map_err(|e| self.error(&call.origin, &e))?,
                (None, None) => {
                    undefined.push(format!("`{}`", parameter.name));
                    continue;
                }
            };
            scope.set(parameter.name, value, false);
        }
        if !undefined.is_empty() {
            return Err(self.fault(
                &call.origin,
                format!(
                    "the macro `{}` takes {}, which {} not given",
                    found.name,
                    undefined.join(", "),
                    if undefined.len() == 1 { "is" } else { "are" }
                ),
            ));
        }
        Ok(())
    }

    fn insert_block(&self, element: &Element, around: &Around, inside: &mut Inside) -> Result<()> {
        let name = element
            .attribute("name")
            .ok_or_else(|| self.missing_attribute(element, "name"))?;
        let block = |stars: &str| match around.scope.find(&format!("{stars}{name}")) {
            Some((_, Entry::Block(block))) => Some(block),
            _ => None,
        };
        if let Some(block) = block("**") {
            inside.nodes.extend(self.inside(&block, around)?.nodes);
        } else if let Some(block) = block("*") {
            let inserted = self.element(&block, around)?;
            inside.nodes.push(Node::Element(Rc::new(inserted)));
        } else {
            return Err(self.fault(&element.origin, format!("there is no block `{name}`")));
        }
        Ok(())
    }
}

/// The scope of namespaces within each other.
fn namespace(expander: &Expander, scope: &Rc<Scope>, path: &[&str]) -> Option<Rc<Scope>> {
    let mut scope = Rc::clone(scope);
    for name in path {
        match expander.resolve(&scope, name).ok()?? {
            Value::Namespace(inner) => scope = inner.downcast::<Scope>().ok()?,
            _ => return None,
        }
    }
    Some(scope)
}

/// The scope of whoever called a macro: around it, namespaces left aside.
fn outer(scope: &Rc<Scope>) -> Option<Rc<Scope>> {
    let mut outer = scope.parent.clone()?;
    if !scope.is_namespace {
        while outer.is_namespace {
            outer = outer.parent.clone()?;
        }
    }
    Some(outer)
}

/// Whether a text can be the name of a property: one of Python's.
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

/// Whether a text can be the name of an element or an attribute.
fn is_xml_name(name: &str) -> bool {
    let mut chars = name.chars();
    let starts_well = chars.next().is_some_and(|c| c.is_alphabetic() || c == '_');
    starts_well && chars.all(|c| c.is_alphanumeric() || "_-.:".contains(c))
}

/// Whether a file's name matches a pattern of `*`, `?` and `[...]`. Names that begin with a dot match none that does not.
fn matches_pattern(name: &str, pattern: &str) -> bool {
    if name.starts_with('.') && !pattern.starts_with('.') {
        return false;
    }
    let (name, pattern): (Vec<char>, Vec<char>) =
        (name.chars().collect(), pattern.chars().collect());
    // Where each part of the pattern can end in the name, part by part: no going back, however many stars there are.
    let mut ends = vec![false; name.len() + 1];
    ends[0] = true;
    let mut at = 0;
    while at < pattern.len() {
        let mut next = vec![false; name.len() + 1];
        match pattern[at] {
            '*' => {
                let mut reached = false;
                for (i, end) in ends.iter().enumerate() {
                    reached = reached || *end;
                    next[i] = reached;
                }
                at += 1;
            }
            '[' => {
                let from = at + 2 + usize::from(pattern.get(at + 1) == Some(&'!'));
                let close = (from..pattern.len()).find(|&i| pattern[i] == ']');
                let (set, after) = match close {
                    Some(close) => (&pattern[at + 1..close], close + 1),
                    None => (&pattern[at..=at], at + 1),
                };
                for i in 0..name.len() {
                    next[i + 1] = ends[i] && in_set(name[i], set);
                }
                at = after;
            }
            c => {
                for i in 0..name.len() {
                    next[i + 1] = ends[i] && (c == '?' || c == name[i]);
                }
                at += 1;
            }
        }
        ends = next;
    }
    ends[name.len()]
}

fn in_set(c: char, set: &[char]) -> bool {
    let (negated, set) = match set {
        ['!', set @ ..] => (true, set),
        set => (false, set),
    };
    let mut i = 0;
    let mut found = false;
    while i < set.len() {
        if i + 2 < set.len() && set[i + 1] == '-' {
            found = found || (set[i]..=set[i + 2]).contains(&c);
            i += 3;
        } else {
            found = found || set[i] == c;
            i += 1;
        }
    }
    found != negated
}

/// What an expression finds around it.
struct View<'a> {
    expander: &'a Expander<'a>,
    scope: &'a Rc<Scope>,
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
        let words = || {
            arguments
                .items
                .iter()
                .map(text)
                .collect::<Vec<_>>()
                .join(" ")
        };
        match (function, arguments.items.as_slice()) {
            (XacroFunction::Arg, [name]) => {
                let name = text(name);
                let value = self.arguments.borrow().get(&name).cloned();
                value.map(Value::text).ok_or(Error::Argument(name))
            }
            (XacroFunction::AbsFilename, [name]) => {
                let path = from_folder(&self.folder(), &text(name));
                Ok(Value::text(path.display().to_string()))
            }
            (XacroFunction::Dotify, [dict @ Value::Dict(_)]) => Ok(dict.clone()),
            (XacroFunction::LoadYaml, [name]) => {
                let name = text(name);
                let path = from_folder(&self.folder(), &name);
                let read = self.settings.files.read_text(&path, MAX_BYTES);
                let read = read.map_err(|fault| Error::File(name.clone(), fault.to_string()))?;
                yaml::load(&read, view).map_err(|e| e.within(format!("`{name}`")))
            }
            (XacroFunction::Tokenize, [Value::Text(of), more @ ..]) => {
                let separators = more.first().cloned().or(separators);
                let separators = separators.map_or(",; ".to_owned(), |s| text(&s));
                let tokens: Vec<Value> = of
                    .split(|c| separators.contains(c))
                    .filter(|token| !skip_empty || !token.is_empty())
                    .map(Value::text)
                    .collect();
                self.budget.spend(tokens.len() as u64)?;
                Ok(Value::list(tokens))
            }
            (XacroFunction::Fatal, _) => Err(Error::new(words())),
            (XacroFunction::Message | XacroFunction::Warning | XacroFunction::Error, _) => {
                let reading = self.reading.borrow();
                if let Some(file) = reading.last() {
                    let origin = Origin {
                        file: Rc::clone(file),
                        bytes: 0..0,
                    };
                    self.note(&origin, "the file itself", words());
                }
                Ok(Value::text(""))
            }
            (XacroFunction::PrintLocation, _) => Ok(Value::text("")),
            _ => Err(Error::new("a function of xacro takes other arguments")),
        }
    }
}

/// What a substitution finds around it.
struct Substitutions<'a> {
    expander: &'a Expander<'a>,
    folder: &'a Path,
}

impl Answers for Substitutions<'_> {
    fn argument(&self, name: &str) -> Option<String> {
        self.expander.arguments.borrow().get(name).cloned()
    }

    fn package(&self, name: &str) -> Option<String> {
        self.expander.find_package(name)
    }

    fn environment(&self, name: &str) -> Option<String> {
        self.expander.settings.files.environment(name)
    }

    fn folder(&self) -> &Path {
        self.folder
    }

    fn budget(&self) -> &Budget {
        &self.expander.budget
    }
}
