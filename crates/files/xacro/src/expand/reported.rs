//! Reports of an expansion: numbers of watched names, and the alternative values of arguments in
//! conditions.

use std::collections::BTreeSet;
use std::rc::Rc;

use super::Expander;
use super::clues::{MOST, is_watched};
use crate::python::number;
use crate::scope::Scope;

impl Expander<'_> {
    /// Returns the numbers of all watched parameters, properties of the outermost scope, and
    /// arguments.
    pub(super) fn watched(&self, scope: &Rc<Scope>) -> Vec<(String, f64)> {
        let mut found = self.clues.parameters.borrow().clone();
        for name in scope.names() {
            if is_watched(self.settings, &name)
                && found.len() < MOST
                && let Ok(Some(value)) = self.resolve(scope, &name)
                && let Some(value) = number(&value)
            {
                found.insert(name, value);
            }
        }
        for (name, value) in self.arguments.borrow().iter() {
            if let (true, Ok(value)) = (is_watched(self.settings, name), value.parse()) {
                found.insert(name.clone(), value);
            }
        }
        found.into_iter().collect()
    }

    /// Returns the alternative values of each argument used in conditions: the opposite truth
    /// value, and the texts and numbers that it is compared with.
    pub(super) fn choices(&self) -> Vec<(String, Vec<String>)> {
        let arguments = self.arguments.borrow();
        let aliases = self.clues.aliases.borrow();
        let mut choices: Vec<(String, Vec<String>)> = Vec::new();
        for (name, value) in arguments.iter() {
            let stands_for = |word: &str| {
                word == name || aliases.get(word).is_some_and(|known| known.contains(name))
            };
            let mut others: Vec<String> = Vec::new();
            for condition in self.clues.conditions.borrow().iter() {
                let mut words = condition.split(|c: char| !c.is_alphanumeric() && c != '_');
                if !words.any(stands_for) {
                    continue;
                }
                others.extend(opposite(value));
                others.extend(quoted(condition));
                others.extend(numbers(condition));
            }
            others.retain(|other| other != value && !other.is_empty());
            let mut seen = BTreeSet::new();
            others.retain(|other| seen.insert(other.clone()));
            if !others.is_empty() {
                choices.push((name.clone(), others));
            }
        }
        choices
    }
}

fn opposite(value: &str) -> Option<String> {
    const PAIRS: [[&str; 2]; 3] = [["true", "false"], ["True", "False"], ["1", "0"]];
    let other = |[p, q]: [&str; 2]| match value {
        v if v == p => Some(q.to_owned()),
        v if v == q => Some(p.to_owned()),
        _ => None,
    };
    PAIRS.into_iter().find_map(other)
}

/// Returns the numbers in a condition, except truth values.
fn numbers(condition: &str) -> Vec<String> {
    let words = condition.split(|c: char| !c.is_alphanumeric() && !matches!(c, '_' | '.'));
    words
        .filter(|word| word.starts_with(|c: char| c.is_ascii_digit()))
        .filter(|word| word.parse::<f64>().is_ok() && !matches!(*word, "0" | "1"))
        .map(str::to_owned)
        .collect()
}

/// Returns the quoted texts, except names of arguments.
fn quoted(condition: &str) -> Vec<String> {
    let mut found = Vec::new();
    for quote in ['\'', '"'] {
        let parts: Vec<&str> = condition.split(quote).collect();
        // Every other part is between two quotes; an unclosed one does not count.
        for at in (1..parts.len().saturating_sub(1)).step_by(2) {
            if !parts[at].contains("$(") && !parts[at - 1].ends_with("arg(") {
                found.push(parts[at].to_owned());
            }
        }
    }
    found
}
