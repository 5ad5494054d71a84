//! Keys changed from outside a scenario's file, and which text each key came from.

use std::ops::Range;

use miette::{NamedSource, SourceSpan};
use toml::de::{DeArray, DeTable, DeValue};

/// What the text of a setting is called where a fault shows its place.
pub const SETTING: &str = "setting";

/// A key changed from outside the file: `KEY=VALUE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    key: String,
    value: String,
}

impl std::str::FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() && !value.trim().is_empty() => Ok(Self {
                key: key.trim().to_owned(),
                value: value.trim().to_owned(),
            }),
            _ => Err("write KEY=VALUE, such as world.floor.friction=0.2".to_owned()),
        }
    }
}

impl std::fmt::Display for Setting {
    /// As it is written on the command line.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}", self.key, self.value)
    }
}

impl Setting {
    /// A key set to a value.
    pub fn new(key: impl Into<String>, value: &toml::Value) -> Self {
        Self {
            key: key.into(),
            value: value.to_string(),
        }
    }

    /// The setting as a line of TOML. A value that is no TOML is taken as text, so that no quotes are needed in a shell.
    pub(super) fn as_toml(&self) -> String {
        let Self { key, value } = self;
        let as_is = format!("{key} = {value}");
        match DeTable::parse(&as_is) {
            Ok(_) => as_is,
            Err(_) => format!("{key} = {}", toml::Value::from(value.as_str())),
        }
    }
}

/// Where each key of the merged document was written.
pub(super) struct Origins<'t> {
    /// The file's name and text.
    pub file: (&'t str, &'t str),
    /// The key that each setting sets, and its text.
    pub settings: Vec<(Vec<String>, &'t str)>,
}

impl Origins<'_> {
    /// The text that holds a key, and a span in it.
    pub fn of(&self, path: &[String], span: Range<usize>) -> (NamedSource<String>, SourceSpan) {
        // A key at fault may be one on the way to the key that was set; it is the file's own where the file has it.
        let (name, text) = self.file;
        let document = DeTable::parse(text);
        let in_file = |path: &[String]| {
            document
                .as_ref()
                .is_ok_and(|document| holds(document.get_ref(), path))
        };
        let is_set = |path: &[String]| {
            let mut settings = self.settings.iter();
            settings.any(|(keys, _)| path.starts_with(keys) || keys.starts_with(path))
        };
        // Of a key that is missing the table around it is shown.
        let path = match path.split_last() {
            Some((_, around)) if !in_file(path) && !is_set(path) => around,
            _ => path,
        };
        let in_file = in_file(path);
        let setting = self
            .settings
            .iter()
            .rev()
            .find(|(keys, _)| path.starts_with(keys) || (!in_file && keys.starts_with(path)));
        match setting {
            Some((_, line)) => (NamedSource::new(SETTING, (*line).to_owned()), span.into()),
            None => (NamedSource::new(name, text.to_owned()), span.into()),
        }
    }
}

/// Whether a table holds a key, given from the outermost table in.
fn holds(table: &DeTable<'_>, path: &[String]) -> bool {
    let Some((first, rest)) = path.split_first() else {
        return true;
    };
    table
        .iter()
        .find(|(key, _)| key.get_ref() == first)
        .is_some_and(|(_, value)| {
            rest.is_empty()
                || value
                    .get_ref()
                    .as_table()
                    .is_some_and(|inner| holds(inner, rest))
        })
}

/// The keys of a document with a single value, from the outermost table in.
pub(super) fn dotted_keys(table: &DeTable<'_>) -> Vec<String> {
    let mut keys = Vec::new();
    let mut table = Some(table);
    while let Some(inner) = table.take() {
        if inner.len() != 1 {
            break;
        }
        if let Some((key, value)) = inner.iter().next() {
            keys.push(key.get_ref().to_string());
            table = value.get_ref().as_table();
        }
    }
    keys
}

/// Whether a table names elements of a list, by their indices from 0.
fn is_element(items: &DeArray<'_>, table: &DeTable<'_>) -> bool {
    let is_index = |key: &str| key.parse::<usize>().is_ok_and(|at| at < items.len());
    !table.is_empty() && table.keys().all(|key| is_index(key.get_ref()))
}

fn merge_elements<'i>(items: &mut DeArray<'i>, elements: DeTable<'i>) {
    for (key, value) in elements {
        let at = key.get_ref().parse::<usize>().ok();
        let Some(slot) = at.and_then(|at| items.get_mut(at)) else {
            continue;
        };
        match (slot.get_mut(), value.get_ref()) {
            (DeValue::Table(slot), DeValue::Table(_)) => {
                if let DeValue::Table(value) = value.into_inner() {
                    merge(slot, value);
                }
            }
            _ => *slot = value,
        }
    }
}

/// Lays one table over another. The value of a setting replaces the value that it names; tables on the way are merged.
pub(super) fn merge<'i>(below: &mut DeTable<'i>, above: DeTable<'i>) {
    for (key, value) in above {
        let existing = below
            .iter_mut()
            .find(|(known, _)| known.get_ref() == key.get_ref());
        match (existing, value.get_ref()) {
            (Some((_, slot)), DeValue::Table(_)) => match (slot.get_mut(), value.into_inner()) {
                (DeValue::Table(slot), DeValue::Table(value)) => merge(slot, value),
                (DeValue::Array(items), DeValue::Table(value)) if is_element(items, &value) => {
                    merge_elements(items, value);
                }
                (slot, value) => *slot = value,
            },
            (Some((_, slot)), _) => *slot = value,
            (None, _) => {
                below.insert(key, value);
            }
        }
    }
}
