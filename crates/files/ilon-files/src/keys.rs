//! Checks the keys and values of a document against its JSON Schema, so that each fault is reported
//! with its place and a repair.
//!
//! The schema is the only source of names, types and bounds of the keys; serde reads the same types
//! afterwards.

use std::ops::Range;

use ::toml::Spanned;
use ::toml::de::{DeArray, DeInteger, DeTable, DeValue};
use serde_json::Value as Json;

/// The range of the numbers of a scenario: sums of larger or smaller numbers with those of a
/// robot's size lose their digits. Expectations are not limited. Chosen.
pub const SIZES: std::ops::RangeInclusive<f64> = 1e-12..=1e9;

/// Whether a number is finite and in this range, or zero.
pub fn is_computable(number: f64) -> bool {
    number == 0.0 || SIZES.contains(&number.abs())
}

/// Whether a number that may have either sign is in this range, or practically zero: a script
/// writes cos(90 deg) as 6e-17.
fn is_computable_with_sign(number: f64) -> bool {
    number.abs() <= *SIZES.end()
}

/// Faults of a text beyond these are not reported: each holds the text.
pub const MOST_FAULTS: usize = 20;

/// An invalid key or value.
#[derive(Debug)]
pub struct KeyFault {
    /// The dotted key, split at its dots.
    pub path: Vec<String>,
    /// The bytes of the text that are at fault.
    pub span: Range<usize>,
    /// What is wrong.
    pub message: String,
    /// How to repair it.
    pub help: String,
    /// The kind of fault.
    pub kind: FaultKind,
}

/// The kind of fault of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// The key itself is unknown or missing.
    Key,
    /// The type of its value.
    Type,
    /// The value; another one of the same type would be valid.
    Value,
}

/// All faults of a document, in the order of the text but for missing keys, which follow what is in
/// their table; at most [`MOST_FAULTS`]. `sizes` tells whether numbers must be in [`SIZES`].
pub fn check(document: &Spanned<DeTable<'_>>, schema: &Json, sizes: bool) -> Vec<KeyFault> {
    let mut checker = Checker {
        sizes,
        ..Checker::of(schema)
    };
    let alternatives = checker.alternatives(schema);
    let last = checker.table(document.get_ref(), document.span(), &alternatives);
    checker.faults.extend(last.err());
    checker.faults.truncate(MOST_FAULTS);
    checker.faults
}

/// Whether a key, given from the outermost table in, holds a list and nothing else with keys.
pub fn is_list<'s>(schema: &'s Json, path: &[String]) -> bool {
    let checker = Checker::of(schema);
    let mut alternatives = checker.alternatives(schema);
    for part in path {
        let is_place = part.parse::<usize>().is_ok();
        let within = |schema: &&'s Json| {
            let named = schema.get("properties").and_then(|named| named.get(part));
            let item = || schema.get("items").filter(|_| is_place);
            let other = || schema.get("additionalProperties");
            named.or_else(item).or_else(other)
        };
        let inner: Vec<&Json> = alternatives.iter().filter_map(within).collect();
        alternatives = inner
            .into_iter()
            .flat_map(|schema| checker.alternatives(schema))
            .collect();
    }
    accepts(&alternatives, "array") && !accepts(&alternatives, "object")
}

/// The part of a key that a document has, and the place of its value, or of the heading of a table.
pub fn place_of(document: &DeTable<'_>, key: &str) -> Option<(Vec<String>, Range<usize>)> {
    let mut place = None;
    let mut path = Vec::new();
    let mut inside = Some(document);
    let mut items: &[Spanned<DeValue<'_>>] = &[];
    for part in key.split('.').filter(|part| !part.is_empty()) {
        let in_table = |table: &'_ DeTable<'_>| {
            let entry = table.iter().find(|(key, _)| key.get_ref() == part);
            entry.map(|(key, _)| key.span())
        };
        let value = match inside {
            Some(table) => table.get(part),
            None => part.parse::<usize>().ok().and_then(|at| items.get(at)),
        };
        let Some(value) = value else { break };
        path.push(part.to_owned());
        // For a table the key is more informative than its first bracket.
        let span = match value.get_ref() {
            DeValue::Table(_) => inside.and_then(in_table).unwrap_or(value.span()),
            _ => value.span(),
        };
        place = Some((path.clone(), span));
        inside = value.get_ref().as_table();
        items = value.get_ref().as_array().map_or(&[], |array| array);
    }
    place
}

/// The most similar known name, if it is similar enough to be meant.
pub fn nearest<'a>(unknown: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    /// No name is as long. Chosen.
    const LONGEST: usize = 200;
    if unknown.len() > LONGEST {
        return None;
    }
    // A Jaro-Winkler similarity above 0.75 covers swapped, missing and doubled letters in names of
    // this length, and little else. In short names a single letter counts more: `rn` for `run`.
    let is_slip = |name: &str| unknown.len() > 1 && strsim::osa_distance(unknown, name) == 1;
    let known: Vec<&str> = known.into_iter().collect();
    let ends = |name: &str| {
        name.strip_suffix(unknown)
            .is_some_and(|rest| rest.ends_with('_'))
    };
    // `kg` is meant for `mass_kg`, if no other name ends so.
    let is_alone = known.iter().filter(|name| ends(name)).count() == 1;
    let is_unit = |name: &str| is_alone && ends(name);
    known
        .into_iter()
        .map(|name| (strsim::jaro_winkler(unknown, name), name))
        .filter(|(likeness, name)| *likeness > 0.75 || is_slip(name) || is_unit(name))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// The factor between the units of two keys.
fn of_units(given: &str, meant: &str) -> &'static str {
    match (given.contains("deg"), meant.contains("deg")) {
        _ if given.contains("_mm") && !meant.contains("_mm") => " A millimetre is 0.001 m",
        (true, false) if meant.contains("rad") => " A degree is 0.01745 rad",
        (false, true) if given.contains("rad") => " A radian is 57.3 degrees",
        _ => "",
    }
}

/// The whole key below a table that an unknown key is meant for: `world.floor.friction` by
/// `world.friction`.
fn elsewhere(unknown: &str, within: &[String], root: &Json) -> Option<String> {
    let within: String = within.iter().map(|part| format!(".{part}")).collect();
    let checker = Checker::of(root);
    let mut level = vec![(String::new(), root)];
    // Sections hold tables, which hold keys.
    for _ in 0..3 {
        let inner = level.iter().flat_map(|(above, schema)| {
            let tables = checker.alternatives(schema).into_iter();
            let keys = tables.filter_map(|table| table.get("properties")?.as_object());
            keys.flatten()
                .map(|(key, inner)| (format!("{above}.{key}"), inner))
                .collect::<Vec<_>>()
        });
        level = inner.collect();
        let ending = format!(".{unknown}");
        let mut found = level
            .iter()
            .filter(|(key, _)| key.ends_with(&ending) && key.starts_with(&within));
        if let (Some((key, _)), None) = (found.next(), found.next()) {
            return Some(key.trim_start_matches('.').to_owned());
        }
    }
    None
}

struct Checker<'s> {
    root: &'s Json,
    path: Vec<String>,
    /// What was found so far.
    faults: Vec<KeyFault>,
    /// Whether numbers must be in [`SIZES`].
    sizes: bool,
}

impl<'s> Checker<'s> {
    fn of(root: &'s Json) -> Self {
        Self {
            root,
            path: Vec::new(),
            faults: Vec::new(),
            sizes: true,
        }
    }

    /// The schemas that a value may match: references resolved, choices listed.
    fn alternatives(&self, schema: &'s Json) -> Vec<&'s Json> {
        if let Some(target) = schema.get("$ref").and_then(Json::as_str) {
            let pointer = target.trim_start_matches('#');
            return match self.root.pointer(pointer) {
                Some(schema) => self.alternatives(schema),
                None => Vec::new(),
            };
        }
        for choice in ["anyOf", "oneOf"] {
            if let Some(choices) = schema.get(choice).and_then(Json::as_array) {
                return choices
                    .iter()
                    .flat_map(|schema| self.alternatives(schema))
                    .collect();
            }
        }
        vec![schema]
    }

    fn value(&mut self, value: &Spanned<DeValue<'_>>, schema: &'s Json) -> Result<(), KeyFault> {
        let alternatives = self.alternatives(schema);
        let span = value.span();
        if alternatives.iter().any(|schema| says_nothing(schema)) {
            return Ok(());
        }
        match value.get_ref() {
            DeValue::Table(table) if accepts(&alternatives, "object") => {
                self.table(table, span, &alternatives)
            }
            DeValue::Array(items) if accepts(&alternatives, "array") => {
                self.list(items, span, &alternatives)
            }
            DeValue::String(word) if accepts(&alternatives, "string") => {
                self.word(word, span, &alternatives)
            }
            DeValue::Boolean(_) if accepts(&alternatives, "boolean") => Ok(()),
            DeValue::Integer(number)
                if accepts(&alternatives, "integer") || accepts(&alternatives, "number") =>
            {
                self.whole_number(number, span, &alternatives)
            }
            DeValue::Float(number) if accepts(&alternatives, "number") => {
                let parsed = number.as_str().parse().unwrap_or(f64::NAN);
                self.number(parsed, span, &alternatives)
            }
            DeValue::Table(table)
                if accepts(&alternatives, "array")
                    && !table.is_empty()
                    && table
                        .keys()
                        .all(|key| key.get_ref().parse::<usize>().is_ok()) =>
            {
                let places: Vec<&str> = table.keys().map(|key| key.get_ref().as_ref()).collect();
                Err(self.fault(
                    FaultKind::Key,
                    span,
                    format!(
                        "the list `{}` has no place {} yet",
                        self.key(),
                        places.join(", ")
                    ),
                    "indices count from 0; the index after the last one appends an entry"
                        .to_owned(),
                ))
            }
            other => Err(self.wrong_type(other, span, &alternatives)),
        }
    }

    fn list(
        &mut self,
        items: &DeArray<'_>,
        span: Range<usize>,
        alternatives: &[&'s Json],
    ) -> Result<(), KeyFault> {
        if let Some(wanted) = how_many(alternatives)
            && items.len() != wanted
        {
            // serde would ignore the surplus entries.
            let (key, count) = (self.key(), items.len());
            return Err(self.fault(
                FaultKind::Value,
                span,
                format!("`{key}` has {count} entries, but must have {wanted}"),
                format!("write {wanted} numbers"),
            ));
        }
        let item_schema = alternatives.iter().find_map(|schema| schema.get("items"));
        let Some(item_schema) = item_schema else {
            return Ok(());
        };
        for (index, item) in items.iter().enumerate() {
            // More are not reported, and each costs a search for the keys that were meant.
            if self.faults.len() >= MOST_FAULTS {
                break;
            }
            self.path.push(index.to_string());
            let fault = self.value(item, item_schema).err();
            self.faults.extend(fault);
            self.path.pop();
        }
        Ok(())
    }

    fn whole_number(
        &self,
        number: &DeInteger<'_>,
        span: Range<usize>,
        alternatives: &[&'s Json],
    ) -> Result<(), KeyFault> {
        // Wider than an unsigned 64-bit seed, so that a larger number is reported as a number.
        let parsed = i128::from_str_radix(number.as_str(), number.radix());
        if let Some(most) = most_whole(alternatives)
            && parsed.as_ref().map_or(true, |number| *number > most)
        {
            let (key, number) = (self.key(), number.as_str());
            return Err(self.fault(
                FaultKind::Value,
                span,
                format!("`{key}` is {number}, but must be {most} or less"),
                format!("write a whole number that is {most} or less"),
            ));
        }
        let number = parsed.map_or(f64::INFINITY, |number| number as f64);
        self.number(number, span, alternatives)
    }

    /// The fault of a value whose type the key does not accept.
    fn wrong_type(
        &self,
        value: &DeValue<'_>,
        span: Range<usize>,
        alternatives: &[&'s Json],
    ) -> KeyFault {
        let (key, wanted) = (self.key(), wanted(alternatives));
        let is_table_for_list =
            matches!(value, DeValue::Table(_)) && accepts(alternatives, "array");
        let is_number = wanted == "a number" || wanted == "a whole number";
        let help = match (
            wanted_words(alternatives).as_slice(),
            wanted_keys(alternatives).as_slice(),
        ) {
            ([], []) if is_table_for_list => {
                format!("write it with two brackets, `[[{key}]]`: there may be several")
            }
            ([], []) if is_number => {
                let example = match wanted == "a number" {
                    true => "0.5",
                    false => "2",
                };
                let name = self.last();
                match name.parse::<usize>() {
                    Ok(_) => format!("write {wanted}, without quotes and unit: `{example}`"),
                    Err(_) => {
                        format!("write {wanted}, without quotes and unit: `{name} = {example}`")
                    }
                }
            }
            ([], []) => format!("write {wanted} here"),
            ([], keys) => {
                let text = match accepts(alternatives, "string") {
                    true => "; or a change against a baseline, `\"+10 %\"`",
                    false => "",
                };
                format!(
                    "write a table, `{{ ... }}`, with what you need of its keys: {}{text}",
                    quoted(keys)
                )
            }
            (words, _) => format!("write one of {}", quoted(words)),
        };
        let message = format!("`{key}` is {}, but must be {wanted}", found(value));
        self.fault(FaultKind::Type, span, message, help)
    }

    fn table(
        &mut self,
        table: &DeTable<'_>,
        span: Range<usize>,
        alternatives: &[&'s Json],
    ) -> Result<(), KeyFault> {
        let properties = |schema: &&'s Json| schema.get("properties").and_then(Json::as_object);
        let known: Vec<(&'s str, &'s Json)> = alternatives
            .iter()
            .filter_map(properties)
            .flatten()
            .map(|(name, schema)| (name.as_str(), schema))
            .collect();
        // Keys with any name, if the schema defines their content.
        let any_other = alternatives
            .iter()
            .filter_map(|schema| schema.get("additionalProperties"))
            .find(|schema| schema.is_object() || **schema == Json::Bool(true));
        // In the order of the text, so that the first reported fault is the first in the file.
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        let mut has_unknown = false;
        for (key, value) in entries {
            if self.faults.len() >= MOST_FAULTS {
                break;
            }
            self.path.push(key.get_ref().to_string());
            let schema = known
                .iter()
                .find(|(name, _)| *name == key.get_ref())
                .map(|(_, schema)| *schema);
            let fault = match (schema, any_other) {
                (Some(schema), _) | (None, Some(schema)) => self.value(value, schema).err(),
                (None, None) if has_unknown => None,
                (None, None) => {
                    has_unknown = true;
                    Some(self.unknown_key(key, table, &known))
                }
            };
            self.faults.extend(fault);
            self.path.pop();
        }
        // With several kinds of tables, the required keys depend on the kind: serde reports those.
        let is_table = |schema: &&&'s Json| accepts(&[**schema], "object");
        let of_no_choice = alternatives.iter().filter(is_table).count() == 1;
        let required = alternatives
            .iter()
            .filter(|schema| of_no_choice && is_table(schema))
            .filter_map(|schema| schema.get("required").and_then(Json::as_array))
            .flatten()
            .filter_map(Json::as_str);
        // An unknown key that is meant for a missing one says so.
        let names = || known.iter().map(|(known, _)| *known);
        let keys = || table.keys().map(|key| key.get_ref().as_ref());
        let unknown = keys().filter(|key| !names().any(|known| known == *key));
        let meant = unknown
            .take(MOST_FAULTS)
            .filter_map(|key| nearest(key, names()));
        let meant: Vec<&str> = meant.collect();
        let missing: Vec<&str> = required
            .filter(|name| !meant.contains(name) && !keys().any(|key| key == *name))
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        let mut keys = Vec::new();
        let mut help = Vec::new();
        for name in missing {
            self.path.push(name.to_owned());
            let schema = known.iter().find(|(known, _)| *known == name);
            let doc = schema
                .and_then(|(_, schema)| self.description(schema))
                .unwrap_or_default();
            help.push(format!("`{}`: {}", self.key(), doc.trim_end_matches('.')));
            keys.push(self.key());
            self.path.pop();
        }
        let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
        let message = match keys.as_slice() {
            [key] => format!("the key `{key}` is missing"),
            keys => format!("the keys {} are missing", quoted(keys)),
        };
        let help = format!("add {}", help.join("; "));
        Err(self.fault(FaultKind::Key, span, message, help))
    }

    fn unknown_key(
        &mut self,
        key: &Spanned<std::borrow::Cow<'_, str>>,
        table: &DeTable<'_>,
        known: &[(&'s str, &'s Json)],
    ) -> KeyFault {
        // All of a table at once, in the order of the text.
        let is_known = |name: &str| known.iter().any(|(known, _)| *known == name);
        let unknown = table.keys().filter(|other| !is_known(other.get_ref()));
        let mut unknown: Vec<&Spanned<_>> = unknown.collect();
        unknown.sort_by_key(|other| other.span().start);
        let [_, _, ..] = unknown[..] else {
            let message = format!("unknown key `{}`", self.key());
            let help = self.meant(key.get_ref(), table, known);
            return self.fault(FaultKind::Key, key.span(), message, help);
        };
        let more = unknown.len().saturating_sub(MOST_FAULTS);
        unknown.truncate(MOST_FAULTS);
        let mut keys = Vec::new();
        // What is meant, with the keys of which that is said.
        let mut helps: Vec<(String, Vec<&str>)> = Vec::new();
        for other in unknown {
            let name: &str = other.get_ref();
            self.path.pop();
            self.path.push(name.to_owned());
            keys.push(self.key());
            let meant = self.meant(name, table, known);
            match helps.iter_mut().find(|(known, _)| *known == meant) {
                Some((_, names)) => names.push(name),
                None => helps.push((meant, vec![name])),
            }
        }
        self.path.pop();
        self.path.push(key.get_ref().to_string());
        let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
        let mut message = format!("unknown keys {}", quoted(&keys));
        if more > 0 {
            message += &format!(" and {more} more");
        }
        let helps = helps.iter();
        let helps: Vec<String> = helps
            .map(|(meant, names)| format!("{}: {meant}", quoted(names)))
            .collect();
        let helps = helps.join("; ").replace("?; ", "? ");
        self.fault(FaultKind::Key, key.span(), message, helps)
    }

    /// The last part of the key.
    fn last(&self) -> &str {
        self.path.last().map_or("", String::as_str)
    }

    /// What an unknown key may be meant for.
    fn meant(&self, name: &str, table: &DeTable<'_>, known: &[(&'s str, &'s Json)]) -> String {
        let mut names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        // Several kinds may have the same key.
        names.sort_unstable();
        names.dedup();
        match nearest(name, names.iter().copied()) {
            Some(near) => {
                // `heading_deg` may be meant for `heading.constant_deg`.
                let begins = |known: &&&str| {
                    let rest = name.strip_prefix(**known);
                    **known != near && rest.is_some_and(|rest| rest.starts_with('_'))
                };
                match names.iter().find(begins) {
                    Some(begun) => {
                        format!(
                            "did you mean `{near}`, or a key of `{begun}`{}?",
                            self.first_of(begun, known)
                        )
                    }
                    None => format!("did you mean `{near}`?{}", of_units(name, near)),
                }
            }
            None if names.is_empty() => "nothing can stand here".to_owned(),
            None => {
                let inner = self.within_another(name, table, known);
                let around = &self.path[..self.path.len().saturating_sub(1)];
                let beneath = || elsewhere(name, around, self.root);
                // A key of a whole section may have been meant; deeper down it has its own meaning.
                let anywhere = || match around.len() {
                    0 | 1 => elsewhere(name, &[], self.root),
                    _ => None,
                };
                match inner.or_else(beneath).or_else(anywhere) {
                    Some(meant) if around.is_empty() || names.len() > 8 => {
                        format!("did you mean `{meant}`?")
                    }
                    Some(meant) => {
                        format!(
                            "did you mean `{meant}`? The keys here are {}",
                            quoted(&names)
                        )
                    }
                    None => format!("the keys here are {}", quoted(&names)),
                }
            }
        }
    }

    /// An example of the keys of a table, in words.
    fn first_of(&self, table: &str, known: &[(&'s str, &'s Json)]) -> String {
        let first = self.keys_in(table, known).next();
        first.map_or_else(String::new, |key| format!(", such as `{table}.{key}`"))
    }

    /// The keys that a table of some known ones takes.
    fn keys_in(&self, table: &str, known: &[(&'s str, &'s Json)]) -> impl Iterator<Item = &'s str> {
        let schemas = known.iter().filter(|(name, _)| *name == table);
        let inner: Vec<&'s Json> = schemas
            .flat_map(|(_, schema)| self.alternatives(schema))
            .collect();
        inner
            .into_iter()
            .filter_map(|schema| schema.get("properties").and_then(Json::as_object))
            .flat_map(|keys| keys.keys().map(String::as_str))
    }

    /// The key that may be meant by one that stands beside the table it belongs into:
    /// `payload.from_s` by `from`.
    fn within_another(
        &self,
        unknown: &str,
        table: &DeTable<'_>,
        known: &[(&'s str, &'s Json)],
    ) -> Option<String> {
        table.keys().find_map(|beside| {
            let near = nearest(unknown, self.keys_in(beside.get_ref(), known))?;
            Some(format!("{}.{near}", beside.get_ref()))
        })
    }

    fn word(
        &self,
        word: &str,
        span: Range<usize>,
        alternatives: &[&'s Json],
    ) -> Result<(), KeyFault> {
        let words = wanted_words(alternatives);
        if words.is_empty() || words.contains(&word) {
            return Ok(());
        }
        let help = match nearest(word, words.iter().copied()) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None => format!("write one of {}", quoted(&words)),
        };
        let message = format!("`{}` cannot be \"{word}\"", self.key());
        Err(self.fault(FaultKind::Value, span, message, help))
    }

    fn number(
        &self,
        number: f64,
        span: Range<usize>,
        alternatives: &[&'s Json],
    ) -> Result<(), KeyFault> {
        if !number.is_finite() {
            return Err(self.fault(
                FaultKind::Value,
                span,
                format!("`{}` is not a finite number", self.key()),
                "write a finite number".to_owned(),
            ));
        }
        let whole = |schema: &&Json| schema.get("type").and_then(Json::as_str) == Some("integer");
        let judged = self.path.first().is_some_and(|section| section == "expect");
        let bound = |name| {
            alternatives
                .iter()
                .find_map(|schema| schema.get(name).and_then(Json::as_f64))
        };
        // A key with its own limit is not a length, time or mass: contacts of heavy robots are
        // stiff.
        let says_so = bound("maximum").is_some_and(|most| (1.0..=most).contains(&number));
        let has_sign = bound("minimum").is_none() && bound("exclusiveMinimum").is_none();
        let computable = match has_sign {
            true => is_computable_with_sign(number),
            false => is_computable(number) || says_so,
        };
        if self.sizes && !judged && !alternatives.iter().any(whole) && !computable {
            let (least, most) = (SIZES.start(), SIZES.end());
            return Err(self.fault(
                FaultKind::Value,
                span,
                format!(
                    "`{}` is {number:e}, which is too large or too small to compute with",
                    self.key()
                ),
                format!("write 0 or a number whose size is between {least:e} and {most:e}"),
            ));
        }
        let broken = match (
            bound("minimum"),
            bound("exclusiveMinimum"),
            bound("maximum"),
        ) {
            (Some(least), _, _) if number < least => Some(format!("{least} or more")),
            (_, Some(least), _) if number <= least => Some(format!("greater than {least}")),
            (_, _, Some(most)) if number > most => Some(format!("{most} or less")),
            _ => None,
        };
        match broken {
            Some(rule) => Err(self.fault(
                FaultKind::Value,
                span,
                format!("`{}` is {number}, but must be {rule}", self.key()),
                // What one of several kinds of value is says nothing of the key.
                match alternatives {
                    [only] => self.description(only),
                    _ => None,
                }
                .map_or_else(
                    || format!("write a number that is {rule}"),
                    |said| format!("`{}`: {}", self.last(), said.trim_end_matches('.')),
                ),
            )),
            None => Ok(()),
        }
    }

    /// The first sentence of a key's description.
    fn description(&self, schema: &'s Json) -> Option<String> {
        let own = schema.get("description").and_then(Json::as_str);
        let text = own.or_else(|| {
            let alternatives = self.alternatives(schema);
            let first = alternatives.first()?;
            first.get("description").and_then(Json::as_str)
        })?;
        Some(text.lines().collect::<Vec<_>>().join(" "))
    }

    fn key(&self) -> String {
        self.path.join(".")
    }

    fn fault(
        &self,
        kind: FaultKind,
        span: Range<usize>,
        message: String,
        help: String,
    ) -> KeyFault {
        KeyFault {
            kind,
            path: self.path.clone(),
            span,
            message,
            help,
        }
    }
}

/// The largest whole number of a key that accepts only whole numbers.
fn most_whole(alternatives: &[&Json]) -> Option<i128> {
    let most = |schema: &&Json| match schema.get("format").and_then(Json::as_str)? {
        "uint32" => Some(i128::from(u32::MAX)),
        "uint64" | "uint" => Some(i128::from(u64::MAX)),
        _ => None,
    };
    alternatives.iter().find_map(most)
}

/// Whether a schema accepts any value.
fn says_nothing(schema: &Json) -> bool {
    match schema {
        Json::Bool(anything) => *anything,
        schema => schema.as_object().is_some_and(serde_json::Map::is_empty),
    }
}

fn accepts(alternatives: &[&Json], kind: &str) -> bool {
    alternatives.iter().any(|schema| match schema.get("type") {
        Some(Json::String(one)) => one == kind,
        Some(Json::Array(several)) => several.iter().any(|one| one == kind),
        _ => kind == "string" && (schema.get("const").is_some() || schema.get("enum").is_some()),
    })
}

/// The required number of entries of an array, if it is fixed.
fn how_many(alternatives: &[&Json]) -> Option<usize> {
    let [schema] = alternatives else {
        return None;
    };
    let count = |bound: &str| schema.get(bound).and_then(Json::as_u64);
    let most = count("maxItems")?;
    (count("minItems") == Some(most)).then_some(most as usize)
}

/// The words that a value may be, if it may only be one of them.
fn wanted_words<'s>(alternatives: &[&'s Json]) -> Vec<&'s str> {
    let constant = |schema: &&'s Json| schema.get("const").and_then(Json::as_str);
    let listed = |schema: &&'s Json| schema.get("enum").and_then(Json::as_array);
    let constants = alternatives.iter().filter_map(constant);
    let lists = alternatives.iter().filter_map(listed).flatten();
    constants.chain(lists.filter_map(Json::as_str)).collect()
}

/// The keys of the table that a value must be, if it may be nothing else.
fn wanted_keys<'s>(alternatives: &[&'s Json]) -> Vec<&'s str> {
    if !wanted(alternatives).ends_with("a table") {
        return Vec::new();
    }
    let properties = |schema: &&'s Json| schema.get("properties").and_then(Json::as_object);
    let keys = alternatives.iter().filter_map(properties).flatten();
    keys.map(|(name, _)| name.as_str()).collect()
}

fn wanted(alternatives: &[&Json]) -> String {
    let kinds = [
        ("number", "a number"),
        ("integer", "a whole number"),
        ("string", "a text in quotes"),
        ("boolean", "true or false"),
        ("array", "an array"),
        ("object", "a table"),
    ];
    let wanted: Vec<&str> = kinds
        .iter()
        .filter(|(kind, _)| accepts(alternatives, kind))
        .map(|(_, words)| *words)
        .collect();
    wanted.join(" or ")
}

fn found(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}

fn quoted(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}
