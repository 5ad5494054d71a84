//! Keys changed from outside a scenario's file, and the origin of each key.

use std::ops::Range;

use miette::{NamedSource, SourceSpan};
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// The name of a setting's text in the report of a fault.
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
    /// As written on the command line.
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

    /// The key, with dots.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The setting as a line of TOML. A value that is not TOML is taken as a string, so that a
    /// shell needs no quotes.
    pub(super) fn as_toml(&self) -> String {
        let Self { key, value } = self;
        let as_is = format!("{key} = {value}");
        match DeTable::parse(&as_is) {
            Ok(_) => as_is,
            Err(_) => format!("{key} = {}", toml::Value::from(value.as_str())),
        }
    }
}

/// The origin of each key of the merged document.
pub(super) struct Origins<'t> {
    /// The file's name and text.
    pub file: (&'t str, &'t str),
    /// The key that each setting sets, and its text.
    pub settings: Vec<(Vec<String>, &'t str)>,
}

impl Origins<'_> {
    /// The text that holds a key, and a span in it.
    pub fn of(&self, path: &[String], span: Range<usize>) -> (NamedSource<String>, SourceSpan) {
        // A key at fault may be on the way to the key that was set; it is the file's own if the
        // file has it.
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
        // For a missing key the table around it is shown.
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

/// Merges one table into another, at a key given from the outermost table in; `is_list` tells
/// whether a key holds a list.
///
/// The value of a setting replaces the value that it names; tables on the way are merged. A number
/// in a key is an index into a list: of an existing element, or one after the last, which appends
/// an element. A missing list is created.
pub(super) fn merge<'i>(
    below: &mut DeTable<'i>,
    above: DeTable<'i>,
    at: &mut Vec<String>,
    is_list: &impl Fn(&[String]) -> bool,
) {
    for (key, value) in above {
        at.push(key.get_ref().to_string());
        let existing = below
            .iter_mut()
            .find(|(known, _)| known.get_ref() == key.get_ref());
        match existing {
            Some((_, slot)) => merge_value(slot, value, at, is_list),
            None => {
                below.insert(key, with_lists(value, at, is_list));
            }
        }
        at.pop();
    }
}

fn merge_value<'i>(
    slot: &mut Spanned<DeValue<'i>>,
    value: Spanned<DeValue<'i>>,
    at: &mut Vec<String>,
    is_list: &impl Fn(&[String]) -> bool,
) {
    let span = value.span();
    match (slot.get_mut(), value.into_inner()) {
        (DeValue::Table(slot), DeValue::Table(value)) => merge(slot, value, at, is_list),
        (DeValue::Array(items), DeValue::Table(value)) if are_places(&value, items.len()) => {
            for (place, value) in by_place(value) {
                at.push(place.to_string());
                match items.get_mut(place) {
                    Some(item) => merge_value(item, value, at, is_list),
                    None => items.push(with_lists(value, at, is_list)),
                }
                at.pop();
            }
        }
        (_, value) => *slot = with_lists(Spanned::new(span, value), at, is_list),
    }
}

/// Converts tables whose keys are all indices of a list, from the first on, to lists.
fn with_lists<'i>(
    value: Spanned<DeValue<'i>>,
    at: &mut Vec<String>,
    is_list: &impl Fn(&[String]) -> bool,
) -> Spanned<DeValue<'i>> {
    let span = value.span();
    let table = match value.into_inner() {
        DeValue::Table(table) => table,
        other => return Spanned::new(span, other),
    };
    let made = if is_list(at) && are_places(&table, 0) {
        let mut items = DeArray::new();
        for (place, value) in by_place(table) {
            at.push(place.to_string());
            items.push(with_lists(value, at, is_list));
            at.pop();
        }
        DeValue::Array(items)
    } else {
        let mut inner = DeTable::new();
        merge(&mut inner, table, at, is_list);
        DeValue::Table(inner)
    };
    Spanned::new(span, made)
}

/// Whether the keys of a table are indices of a list with `count` elements, or of elements appended
/// without a gap.
fn are_places(table: &DeTable<'_>, count: usize) -> bool {
    let mut places: Vec<usize> = Vec::new();
    for key in table.keys() {
        match key.get_ref().parse() {
            Ok(place) => places.push(place),
            Err(_) => return false,
        }
    }
    places.sort_unstable();
    let new = places.iter().filter(|place| **place >= count);
    !places.is_empty() && (count..).zip(new).all(|(next, place)| next == *place)
}

/// The values of a table whose keys are list indices, in order.
fn by_place<'i>(table: DeTable<'i>) -> Vec<(usize, Spanned<DeValue<'i>>)> {
    let placed = table
        .into_iter()
        .filter_map(|(key, value)| Some((key.get_ref().parse().ok()?, value)));
    let mut placed: Vec<_> = placed.collect();
    placed.sort_by_key(|(place, _)| *place);
    placed
}
