//! Information collected during an expansion, in addition to the result.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use crate::Settings;

/// Largest number of items of each kind.
pub(super) const MOST: usize = 500;
/// Longest text, in bytes.
const LONGEST: usize = 400;

/// The collected information.
#[derive(Default)]
pub(super) struct Clues {
    /// Numbers passed to watched macro parameters.
    pub(super) parameters: RefCell<BTreeMap<String, f64>>,
    /// The texts of conditions.
    pub(super) conditions: RefCell<BTreeSet<String>>,
    /// Properties and parameters that receive an argument's value, with these arguments.
    pub(super) aliases: RefCell<BTreeMap<String, BTreeSet<String>>>,
}

impl Clues {
    pub(super) fn condition(&self, text: &str) {
        let mut conditions = self.conditions.borrow_mut();
        if conditions.len() < MOST && text.len() < LONGEST && !conditions.contains(text) {
            conditions.insert(text.to_owned());
        }
    }

    /// Records that a name was set to a text.
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

    /// Records that a macro's parameter was set.
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
