//! Where properties live: scopes within scopes, each looked through from the inside out.

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
    /// Whether it is that of `<xacro:include ns="...">`, and no macro's own.
    pub(super) is_namespace: bool,
    /// The properties that are being evaluated, to find those that need themselves.
    pub(super) resolving: RefCell<Vec<String>>,
}

/// What a name stands for.
#[derive(Clone, Debug)]
pub(super) enum Entry {
    Value(Value),
    /// A text that is evaluated when it is first needed, in the scope that holds it.
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

    /// Sets a name. Text that is no literal is evaluated when it is needed, if `lazy`, and stays as it is otherwise.
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

    /// Sets a name to what it is given.
    pub(super) fn put(&self, name: impl Into<String>, entry: Entry) {
        self.entries.borrow_mut().insert(name.into(), entry);
    }

    /// Takes a name out of this scope and of all around it.
    pub(super) fn remove(&self, name: &str) {
        self.entries.borrow_mut().remove(name);
        if let Some(parent) = &self.parent {
            parent.remove(name);
        }
    }

    /// Takes everything out, so that scopes that know each other let each other go.
    pub(super) fn clear(&self) {
        self.entries.borrow_mut().clear();
    }

    /// What a name stands for in this scope alone.
    pub(super) fn own(&self, name: &str) -> Option<Entry> {
        self.entries.borrow().get(name).cloned()
    }

    /// What a name stands for, and the scope that holds it.
    pub(super) fn find(self: &Rc<Self>, name: &str) -> Option<(Rc<Scope>, Entry)> {
        let mut scope = self;
        loop {
            if let Some(entry) = scope.own(name) {
                return Some((Rc::clone(scope), entry));
            }
            scope = scope.parent.as_ref()?;
        }
    }

    /// The names that it holds itself, in order.
    pub(super) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = self.entries.borrow().keys().cloned().collect();
        names.sort();
        names
    }

    /// How many scopes lie around this one.
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
