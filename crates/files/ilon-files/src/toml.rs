//! Decodes TOML into Rust types, and encodes Rust types as TOML.
//!
//! Each type is compiled once for reading and once for writing. The deserializer and serializer of
//! the `toml` crate instantiate a type three and eight times; for a scenario that was half of the
//! code of its crate.

use std::fmt;
use std::ops::Range;

use ::toml::de::{DeString, DeTable, DeValue};
use ::toml::{Spanned, Table, Value};
use erased_serde::Serialize;
use serde::de::value::{CowStrDeserializer, UnitDeserializer};
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error, MapAccess, SeqAccess, VariantAccess, Visitor,
};
use serde::{Deserialize, forward_to_deserialize_any};

/// Why a document does not fit the type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct DecodeError {
    /// The message.
    pub message: String,
    /// The keys that lead to the wrong value, or to the table in which a key is missing.
    pub path: Vec<String>,
    /// Its place in the text, in bytes; `None` if invalid TOML ends too early.
    pub span: Option<Range<usize>>,
}

/// Decodes a document.
///
/// # Errors
/// If a value has another type than `T` requires, a key is missing or unknown to `T`, or a value is
/// a date.
pub fn decode<'de, T: Deserialize<'de>>(document: Spanned<DeTable<'de>>) -> Result<T, DecodeError> {
    let span = document.span();
    let value = DeValue::Table(document.into_inner());
    T::deserialize(Node(Spanned::new(span, value)))
}

/// The longest text that is parsed, in bytes: some ten seconds of it. Chosen.
const LONGEST: usize = 8_000_000;

/// Parses a text.
///
/// # Errors
/// If it is not valid TOML, or longer than 8 MB.
pub fn parse(text: &str) -> Result<Spanned<DeTable<'_>>, DecodeError> {
    if text.len() > LONGEST {
        return Err(DecodeError::custom(format!(
            "the text has {} MB, and TOML of at most 8 MB is read",
            text.len() / 1_000_000
        )));
    }
    DeTable::parse(text).map_err(|error| DecodeError {
        message: error.message().to_owned(),
        path: Vec::new(),
        span: error.span(),
    })
}

/// Decodes a text.
///
/// # Errors
/// Those of [`parse`] and [`decode`].
pub fn decode_text<'de, T: Deserialize<'de>>(text: &'de str) -> Result<T, DecodeError> {
    decode(parse(text)?)
}

/// Encodes a value as text.
///
/// # Errors
/// If TOML cannot represent it: a null in a list, or a key that is not text.
pub fn encode(value: &dyn Serialize) -> Result<String, ::toml::ser::Error> {
    ::toml::to_string(value)
}

/// The values of a table by their dotted keys. What is no table is a value, and so is an empty one.
pub fn flat(table: &Table) -> Vec<(String, Value)> {
    flattened(table, false)
}

/// Like [`flat`], with the entries of a list by their indices.
pub fn leaves(table: &Table) -> Vec<(String, Value)> {
    flattened(table, true)
}

fn flattened(table: &Table, with_lists: bool) -> Vec<(String, Value)> {
    fn gather(key: &str, value: &Value, with_lists: bool, found: &mut Vec<(String, Value)>) {
        let mut below = |name: &dyn fmt::Display, value| {
            gather(&format!("{key}.{name}"), value, with_lists, found);
        };
        match value {
            Value::Table(inner) if !inner.is_empty() => {
                inner.iter().for_each(|(name, value)| below(name, value));
            }
            Value::Array(items) if with_lists && !items.is_empty() => {
                let items = items.iter().enumerate();
                items.for_each(|(index, value)| below(&index, value));
            }
            value => found.push((key.to_owned(), value.clone())),
        }
    }
    let mut found = Vec::new();
    for (key, value) in table {
        gather(key, value, with_lists, &mut found);
    }
    found
}

impl DecodeError {
    /// Adds the place, unless there is one.
    fn at(mut self, span: &Range<usize>) -> Self {
        self.span.get_or_insert_with(|| span.clone());
        self
    }

    /// Adds a key to the path.
    fn below(mut self, key: &str) -> Self {
        self.path.insert(0, key.to_owned());
        self
    }
}

impl Error for DecodeError {
    fn custom<M: fmt::Display>(message: M) -> Self {
        Self {
            message: message.to_string(),
            path: Vec::new(),
            span: None,
        }
    }
}

/// A value of a document.
struct Node<'de>(Spanned<DeValue<'de>>);

/// A value by its type.
enum Plain<'de> {
    Text(DeString<'de>),
    Boolean(bool),
    Signed(i64),
    Unsigned(u64),
    Real(f64),
    List(Items<'de>),
    Table(Entries<'de>),
}

impl<'de> Plain<'de> {
    fn of(value: DeValue<'de>) -> Result<Self, DecodeError> {
        Ok(match value {
            DeValue::String(text) => Self::Text(text),
            DeValue::Boolean(value) => Self::Boolean(value),
            DeValue::Integer(digits) => {
                let (text, radix) = (digits.as_str(), digits.radix());
                match i64::from_str_radix(text, radix) {
                    Ok(number) => Self::Signed(number),
                    Err(_) => u64::from_str_radix(text, radix)
                        .map(Self::Unsigned)
                        .map_err(|_| DecodeError::custom("integer number overflowed"))?,
                }
            }
            DeValue::Float(digits) => {
                let number: f64 = digits.as_str().parse().map_err(DecodeError::custom)?;
                if number.is_infinite() && !digits.as_str().ends_with("inf") {
                    return Err(DecodeError::custom("floating-point number overflowed"));
                }
                Self::Real(number)
            }
            DeValue::Array(items) => Self::List(Items {
                rest: items.into_iter().enumerate(),
            }),
            DeValue::Table(table) => Self::Table(Entries {
                rest: table.into_iter(),
                next: None,
            }),
            DeValue::Datetime(date) => {
                let message = format!("{date} is a date, which no key takes");
                return Err(DecodeError::custom(message));
            }
        })
    }
}

impl<'de> Deserializer<'de> for Node<'de> {
    type Error = DecodeError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        let span = self.0.span();
        let read = match Plain::of(self.0.into_inner()) {
            Ok(Plain::Text(DeString::Borrowed(text))) => visitor.visit_borrowed_str(text),
            Ok(Plain::Text(DeString::Owned(text))) => visitor.visit_string(text),
            Ok(Plain::Boolean(value)) => visitor.visit_bool(value),
            Ok(Plain::Signed(number)) => visitor.visit_i64(number),
            Ok(Plain::Unsigned(number)) => visitor.visit_u64(number),
            Ok(Plain::Real(number)) => visitor.visit_f64(number),
            Ok(Plain::List(items)) => visitor.visit_seq(items),
            Ok(Plain::Table(entries)) => visitor.visit_map(entries),
            Err(error) => Err(error),
        };
        read.map_err(|error| error.at(&span))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, DecodeError> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DecodeError> {
        let span = self.0.span();
        let read = match Choice::of(self.0.into_inner()) {
            Ok(choice) => visitor.visit_enum(choice),
            Err(error) => Err(error),
        };
        read.map_err(|error| error.at(&span))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple tuple_struct map struct
        identifier ignored_any
    }
}

/// Deserializes the values of a list.
struct Items<'de> {
    rest: std::iter::Enumerate<std::vec::IntoIter<Spanned<DeValue<'de>>>>,
}

impl<'de> SeqAccess<'de> for Items<'de> {
    type Error = DecodeError;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, DecodeError> {
        let Some((index, value)) = self.rest.next() else {
            return Ok(None);
        };
        let read = seed.deserialize(Node(value)).map(Some);
        read.map_err(|error| error.below(&index.to_string()))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

/// Deserializes the keys and values of a table.
struct Entries<'de> {
    rest: ::toml::map::IntoIter<Spanned<DeString<'de>>, Spanned<DeValue<'de>>>,
    /// The value of the last key.
    next: Option<(DeString<'de>, Spanned<DeValue<'de>>)>,
}

/// Deserializer of a key.
type Key<'de> = CowStrDeserializer<'de, DecodeError>;

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = DecodeError;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, DecodeError> {
        let Some((key, value)) = self.rest.next() else {
            return Ok(None);
        };
        let span = key.span();
        let key = key.into_inner();
        self.next = Some((key.clone(), value));
        let read = seed.deserialize(Key::new(key)).map(Some);
        read.map_err(|error| error.at(&span))
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<T::Value, DecodeError> {
        let Some((key, value)) = self.next.take() else {
            return Err(DecodeError::custom("a value without a key"));
        };
        seed.deserialize(Node(value))
            .map_err(|error| error.below(&key))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

/// Deserializes an enum: its variant's name, or a table with the variant as its only key.
struct Choice<'de> {
    name: DeString<'de>,
    value: Option<Spanned<DeValue<'de>>>,
}

impl<'de> Choice<'de> {
    fn of(value: DeValue<'de>) -> Result<Self, DecodeError> {
        match value {
            DeValue::String(name) => Ok(Self { name, value: None }),
            DeValue::Table(table) => {
                let mut entries = table.into_iter();
                match (entries.next(), entries.next()) {
                    (Some((name, value)), None) => Ok(Self {
                        name: name.into_inner(),
                        value: Some(value),
                    }),
                    (None, _) => Err(DecodeError::custom(
                        "the table is empty; one key of it says which",
                    )),
                    _ => Err(DecodeError::custom(
                        "the table has several keys; one alone says which",
                    )),
                }
            }
            _ => Err(DecodeError::custom("expected a text or a table of one key")),
        }
    }
}

impl<'de> EnumAccess<'de> for Choice<'de> {
    type Error = DecodeError;
    type Variant = Form<'de>;

    fn variant_seed<T: DeserializeSeed<'de>>(
        self,
        seed: T,
    ) -> Result<(T::Value, Form<'de>), DecodeError> {
        let form = Form {
            name: self.name.clone(),
            value: self.value,
        };
        Ok((seed.deserialize(Key::new(self.name))?, form))
    }
}

/// Deserializes the content of the variant.
struct Form<'de> {
    name: DeString<'de>,
    value: Option<Spanned<DeValue<'de>>>,
}

impl<'de> VariantAccess<'de> for Form<'de> {
    type Error = DecodeError;

    fn unit_variant(self) -> Result<(), DecodeError> {
        match self.value {
            None => Ok(()),
            Some(value) if is_empty(value.get_ref()) => Ok(()),
            Some(value) => {
                let error = DecodeError::custom("expected an empty table");
                Err(error.at(&value.span()).below(&self.name))
            }
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(
        self,
        seed: T,
    ) -> Result<T::Value, DecodeError> {
        match self.value {
            None => seed.deserialize(UnitDeserializer::new()),
            Some(value) => (seed.deserialize(Node(value))).map_err(|error| error.below(&self.name)),
        }
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, DecodeError> {
        match self.value {
            None => UnitDeserializer::new().deserialize_any(visitor),
            Some(value) => {
                (Node(value).deserialize_any(visitor)).map_err(|error| error.below(&self.name))
            }
        }
    }

    /// Unknown keys are refused even if the type allows them, as they may belong to another
    /// variant.
    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DecodeError> {
        let Some(value) = self.value else {
            return UnitDeserializer::new().deserialize_any(visitor);
        };
        let read = match unknown_key(value.get_ref(), fields) {
            Some(error) => Err(error),
            None => Node(value).deserialize_any(visitor),
        };
        read.map_err(|error| error.below(&self.name))
    }
}

/// The error for the first key that is not among the fields.
fn unknown_key(value: &DeValue<'_>, fields: &'static [&'static str]) -> Option<DecodeError> {
    let mut keys = value.as_table()?.keys();
    let key = keys.find(|key| !fields.contains(&key.get_ref().as_ref()))?;
    Some(DecodeError::unknown_field(key.get_ref(), fields).at(&key.span()))
}

fn is_empty(value: &DeValue<'_>) -> bool {
    match value {
        DeValue::Table(table) => table.is_empty(),
        DeValue::Array(items) => items.is_empty(),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde::Serialize;
    use test_case::test_case;

    use super::*;

    /// A type with all kinds of content.
    #[derive(Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    struct All {
        name: String,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        mass_kg: Option<f64>,
        #[serde(default)]
        count: u64,
        #[serde(default)]
        on: bool,
        #[serde(default)]
        pair: (i32, f64),
        #[serde(default)]
        any: Option<OneOrMany>,
        #[serde(default)]
        path: Path,
        #[serde(default)]
        more: BTreeMap<String, Inner>,
        #[serde(default)]
        list: Vec<Inner>,
    }

    #[derive(Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    struct Inner {
        length_m: Length,
    }

    #[derive(Debug, PartialEq, Deserialize, Serialize)]
    struct Length(f64);

    #[derive(Debug, PartialEq, Deserialize, Serialize)]
    #[serde(untagged)]
    enum OneOrMany {
        One(f64),
        Many(Vec<f64>),
    }

    #[derive(Debug, Default, PartialEq, Deserialize, Serialize)]
    #[serde(rename_all = "snake_case")]
    enum Path {
        #[default]
        Line,
        Circle {
            radius_m: f64,
        },
        Scaled(f64),
        Points(f64, f64),
    }

    /// The result, or a refusal, is that of the `toml` crate.
    #[test_case("name = 'a'"; "a text")]
    #[test_case("name = \"a\\nb\""; "a text that is not as it stands")]
    #[test_case("name = 'a'\nmass_kg = 2\ncount = 0xff\non = true"; "numbers")]
    #[test_case("name = 'a'\nmass_kg = inf"; "an infinite number")]
    #[test_case("name = 'a'\nmass_kg = 1e999"; "a number that is too large")]
    #[test_case("name = 'a'\ncount = 18446744073709551615"; "the largest number")]
    #[test_case("name = 'a'\ncount = 18446744073709551616"; "a whole number that is too large")]
    #[test_case("name = 'a'\ncount = 0xffff_ffff_ffff_ffff"; "the largest number by sixteens")]
    #[test_case("name = 'a'\ncount = -1"; "a negative count")]
    #[test_case("name = 'a'\ncount = 1.5"; "a fraction for a count")]
    #[test_case("name = 'a'\nmass_kg = '2'"; "a text for a number")]
    #[test_case("name = 'a'\npair = [1, 2.5]"; "a pair")]
    #[test_case("name = 'a'\npair = [1]"; "half a pair")]
    #[test_case("name = 'a'\nany = 1.5"; "one")]
    #[test_case("name = 'a'\nany = [1.5, 2.5]"; "many")]
    #[test_case("name = 'a'\nany = 'x'"; "neither one nor many")]
    #[test_case("name = 'a'\npath = 'line'"; "a form by its name")]
    #[test_case("name = 'a'\npath = 'round'"; "a form that is none")]
    #[test_case("name = 'a'\npath = { circle = { radius_m = 1 } }"; "a form with keys")]
    #[test_case("name = 'a'\npath = { circle = { radius_m = 1, sides = 3 } }"; "a form with a key too many")]
    #[test_case("name = 'a'\npath = { circle = { radius_m = 1 }, line = {} }"; "two forms")]
    #[test_case("name = 'a'\npath = { scaled = 2 }"; "a form of one value")]
    #[test_case("name = 'a'\npath = { points = [1, 2] }"; "a form of two values")]
    #[test_case("name = 'a'\npath = { line = {} }"; "a form without keys as a table")]
    #[test_case("name = 'a'\npath = { line = { length_m = 1 } }"; "a form without keys that has one")]
    #[test_case("name = 'a'\npath = 'scaled'"; "a form of one value without it")]
    #[test_case("name = 'a'\npath = 'circle'"; "a form with keys without them")]
    #[test_case("name = 'a'\npath = {}"; "no form")]
    #[test_case("name = 'a'\npath = 3"; "a number for a form")]
    #[test_case("name = 'a'\n[more.b]\nlength_m = 1\n[[list]]\nlength_m = 2\n[[list]]\nlength_m = 3"; "tables and lists")]
    #[test_case("name = 'a'\n[[list]]\nlength_m = 2\n[[list]]\nlength = 3"; "an unknown key in a list")]
    #[test_case("mass_kg = 2"; "a missing key")]
    #[test_case("name = 2020-01-01"; "a date")]
    fn reads_as_the_reader_of_toml_does(text: &str) {
        let read: Result<All, _> = decode_text(text);
        let reference: Result<All, _> = ::toml::from_str(text);
        assert_eq!(read.ok(), reference.ok());
    }

    /// An error has the keys that lead to the value, and the value's place, as in the `toml` crate.
    #[test_case("name = 'a'\nmass_kg = '2'", "mass_kg"; "a value")]
    #[test_case("name = 'a'\n[[list]]\nlength_m = 2\n[[list]]\nlength_m = 'x'", "list.1.length_m"; "a value in a list")]
    #[test_case("name = 'a'\n[more]\nb = {}", "more.b"; "the table in which a key is missing")]
    #[test_case("name = 'a'\nmass = 2", ""; "a key that is unknown")]
    #[test_case("name = 'a'\npath = { circle = { radius_m = false } }", "path.circle.radius_m"; "a value in a form")]
    #[test_case("name = 'a'\npath = { circle = { radius_m = 1, sides = 3 } }", "path.circle"; "a key that a form has not")]
    fn a_fault_says_where(text: &str, path: &str) {
        let fault = decode_text::<All>(text).expect_err("refused");
        assert_eq!(fault.path.join("."), path);
        let reference = ::toml::from_str::<All>(text).expect_err("refused");
        assert_eq!(fault.span, reference.span());
    }

    /// The text is that of the `toml` crate, and decodes to the same value.
    #[test]
    fn writes_as_the_writer_of_toml_does() {
        let all = All {
            name: "a".to_owned(),
            mass_kg: Some(f64::INFINITY),
            count: 3,
            on: true,
            pair: (-1, 0.5),
            any: Some(OneOrMany::Many(vec![1.0, 2.0])),
            path: Path::Circle { radius_m: 2.0 },
            more: BTreeMap::from([(
                "b c".to_owned(),
                Inner {
                    length_m: Length(1.0),
                },
            )]),
            list: vec![Inner {
                length_m: Length(2.0),
            }],
        };
        let text = encode(&all).expect("written");
        assert_eq!(text, ::toml::to_string(&all).expect("written"));
        assert_eq!(decode_text::<All>(&text), Ok(all));
    }

    /// Keys of tables are joined by dots, those of lists only where lists are asked for; what is
    /// empty is a value.
    #[test]
    fn values_have_dotted_keys() {
        let table = "a.b = 1\na.c = {}\nd = [{ e = 2 }, 3]\nf = []"
            .parse()
            .expect("TOML");
        let keys = |found: Vec<(String, Value)>| found.into_iter().map(|(key, _)| key);
        let [flat, leaves] = [flat(&table), leaves(&table)].map(keys);
        assert_eq!(flat.collect::<Vec<_>>(), ["a.b", "a.c", "d", "f"]);
        let leaves: Vec<_> = leaves.collect();
        assert_eq!(leaves, ["a.b", "a.c", "d.0.e", "d.1", "f"]);
    }

    /// A text of 9 MB is refused before it is parsed.
    #[test]
    fn a_text_that_takes_minutes_is_refused() {
        let text = "#".repeat(9_000_000);
        let refused = parse(&text).expect_err("too long");
        assert!(refused.message.contains("9 MB"), "{refused:?}");
        assert!(parse(&text[..8_000_000]).is_ok());
    }
}
