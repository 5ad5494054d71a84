//! Scopes of properties, nested and searched from the inside out.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use super::dom::Element;
use super::python::{Value, literal};

/// A scope of properties.
#[derive(Debug)]
pub(super) struct Scope {
    entries: RefCell<HashMap<String, Entry>>,
    pub(super) parent: Option<Rc<Scope>>,
    depth: u64,
    /// Whether it belongs to `<xacro:include ns="...">` and not to a macro.
    pub(super) is_namespace: bool,
    /// The properties being evaluated, to detect cycles.
    pub(super) resolving: RefCell<Vec<String>>,
}

/// The meaning of a name.
#[derive(Clone, Debug)]
pub(super) enum Entry {
    Value(Value),
    /// A text that is evaluated at its first use, in the scope that holds it.
    Lazy(Rc<str>),
    /// Elements to insert: those of a block parameter, or of a property without a value.
    Block(Rc<Element>),
}

impl Scope {
    pub(super) fn new(parent: Option<Rc<Scope>>, is_namespace: bool) -> Rc<Self> {
        Rc::new(Self {
            entries: RefCell::default(),
            depth: parent.as_ref().map_or(0, |parent| 1 + parent.depth),
            parent,
            is_namespace,
            resolving: RefCell::default(),
        })
    }

    /// Sets a name. Text that is no literal is evaluated at its first use, if `lazy`, and otherwise
    /// stays unchanged.
    pub(super) fn set(&self, name: impl Into<String>, value: Value, lazy: bool) {
        let entry = match value {
            Value::Text(text) => match literal(&text) {
                Value::Text(text) if lazy => Entry::Lazy(text),
                value => Entry::Value(value),
            },
            value => Entry::Value(value),
        };
        self.put(name, entry);
    }

    /// Sets a name to an entry.
    pub(super) fn put(&self, name: impl Into<String>, entry: Entry) {
        self.entries.borrow_mut().insert(name.into(), entry);
    }

    /// Removes a name from this scope and all surrounding ones.
    pub(super) fn remove(&self, name: &str) {
        self.entries.borrow_mut().remove(name);
        if let Some(parent) = &self.parent {
            parent.remove(name);
        }
    }

    /// Removes all entries, which breaks reference cycles between scopes.
    pub(super) fn clear(&self) {
        self.entries.borrow_mut().clear();
    }

    /// Returns the entry of a name in this scope alone.
    pub(super) fn own(&self, name: &str) -> Option<Entry> {
        self.entries.borrow().get(name).cloned()
    }

    /// Returns the entry of a name, and the scope that holds it.
    pub(super) fn find(self: &Rc<Self>, name: &str) -> Option<(Rc<Scope>, Entry)> {
        let mut scope = self;
        loop {
            if let Some(entry) = scope.own(name) {
                return Some((Rc::clone(scope), entry));
            }
            scope = scope.parent.as_ref()?;
        }
    }

    /// Returns its own names, in order.
    pub(super) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = self.entries.borrow().keys().cloned().collect();
        names.sort();
        names
    }

    /// The number of surrounding scopes.
    pub(super) fn depth(&self) -> u64 {
        self.depth
    }

    /// The outermost scope.
    pub(super) fn top(self: &Rc<Self>) -> Rc<Scope> {
        let mut scope = self;
        while let Some(parent) = &scope.parent {
            scope = parent;
        }
        Rc::clone(scope)
    }
}
