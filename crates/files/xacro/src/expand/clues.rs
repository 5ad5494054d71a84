//! What is met on the way of what a file says beside what it expands to.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use crate::Settings;

/// Most of anything that is kept.
pub(super) const MOST: usize = 500;
/// Longest text that is kept, in bytes.
const LONGEST: usize = 400;

/// What was met on the way.
#[derive(Default)]
pub(super) struct Clues {
    /// Numbers given to macros' parameters that are watched.
    pub(super) parameters: RefCell<BTreeMap<String, f64>>,
    /// The texts of conditions.
    pub(super) conditions: RefCell<BTreeSet<String>>,
    /// Properties and parameters that are given an argument's value, and those arguments.
    pub(super) aliases: RefCell<BTreeMap<String, BTreeSet<String>>>,
}

impl Clues {
    pub(super) fn condition(&self, text: &str) {
        let mut conditions = self.conditions.borrow_mut();
        if conditions.len() < MOST && text.len() < LONGEST && !conditions.contains(text) {
            conditions.insert(text.to_owned());
        }
    }

    /// A name was given a text.
    pub(super) fn named(&self, name: &str, text: &str) {
        let mut aliases = self.aliases.borrow_mut();
        if text.len() > LONGEST || aliases.len() >= MOST {
            return;
        }
        for (_, rest) in text
            .match_indices("$(arg ")
            .map(|(at, found)| text.split_at(at + found.len()))
        {
            if let Some((argument, _)) = rest.split_once(')') {
                let of_name = aliases.entry(name.to_owned()).or_default();
                of_name.insert(argument.trim().to_owned());
            }
        }
    }

    /// A macro's parameter was given a value.
    pub(super) fn parameter(&self, settings: &Settings, of: &str, name: &str, value: Option<f64>) {
        let mut known = self.parameters.borrow_mut();
        // A wheel's own `radius` is a wheel's radius.
        let called = format!("{of} {name}");
        if let Some(value) = value
            && known.len() < MOST
            && is_watched(settings, &called)
        {
            known.insert(called, value);
        }
    }
}

pub(super) fn is_watched(settings: &Settings, name: &str) -> bool {
    settings.watch.is_some_and(|watch| watch(name))
}
