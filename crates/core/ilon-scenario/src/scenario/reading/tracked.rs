//! Reading of `[reference]`: one key names a path, and keys beside it define its timing.

use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{
    DeserializeSeed, EnumAccess, Error, IntoDeserializer, MapAccess, VariantAccess, Visitor,
};
use serde::{Deserialize, Deserializer, forward_to_deserialize_any};

use crate::scenario::motion::{Reference, Timing, Tracked};

impl<'de> Deserialize<'de> for Tracked {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_map(Keys)
    }
}

struct Keys;

impl<'de> Visitor<'de> for Keys {
    type Value = Tracked;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table with a path, such as `circle`")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Tracked, A::Error> {
        let (mut path, mut timing) = (None, None);
        let (mut share_of_limits, mut share_of_grip) = (None, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "timing" => timing = Some(map.next_value()?),
                "share_of_limits" => share_of_limits = Some(map.next_value()?),
                "share_of_grip" => share_of_grip = Some(map.next_value()?),
                _ if path.is_some() => {
                    return Err(Error::custom(format!(
                        "`{key}` is a second path; a reference follows exactly one"
                    )));
                }
                _ => {
                    let entry = Entry { key, map: &mut map };
                    path = Some(Reference::deserialize(entry)?);
                }
            }
        }
        let path = path.ok_or_else(|| Error::custom("there is no path, such as `circle`"))?;
        Ok(Tracked {
            timing,
            share_of_limits,
            share_of_grip,
            path,
        })
    }
}

/// An entry of a table as an enum: its key is the variant.
struct Entry<'m, A> {
    key: String,
    map: &'m mut A,
}

impl<'de, A: MapAccess<'de>> Deserializer<'de> for Entry<'_, A> {
    type Error = A::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, A::Error> {
        visitor.visit_enum(self)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct seq tuple
        tuple_struct map struct enum identifier ignored_any
    }
}

impl<'de, A: MapAccess<'de>> EnumAccess<'de> for Entry<'_, A> {
    type Error = A::Error;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), A::Error> {
        let variant = seed.deserialize(self.key.as_str().into_deserializer())?;
        Ok((variant, self))
    }
}

impl<'de, A: MapAccess<'de>> VariantAccess<'de> for Entry<'_, A> {
    type Error = A::Error;

    fn unit_variant(self) -> Result<(), A::Error> {
        self.map.next_value()
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, A::Error> {
        self.map.next_value_seed(seed)
    }

    fn tuple_variant<V: Visitor<'de>>(self, len: usize, visitor: V) -> Result<V::Value, A::Error> {
        let _ = len;
        self.map.next_value_seed(Fields(&[], visitor))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, A::Error> {
        self.map.next_value_seed(Fields(fields, visitor))
    }
}

struct Fields<V>(&'static [&'static str], V);

impl<'de, V: Visitor<'de>> DeserializeSeed<'de> for Fields<V> {
    type Value = V::Value;

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<V::Value, D::Error> {
        from.deserialize_struct("", self.0, self.1)
    }
}

impl JsonSchema for Tracked {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "ReferenceSection".into()
    }

    /// The path's schema, with the keys beside it added to each kind.
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let timing = generator.subschema_for::<Timing>().to_value();
        let mut schema = Reference::json_schema(generator);
        let variants = schema.get_mut("oneOf").and_then(|all| all.as_array_mut());
        for variant in variants.into_iter().flatten() {
            let Some(properties) = variant.get_mut("properties") else {
                continue;
            };
            properties["timing"] = serde_json::json!({
                "description": "When the robot is where on its path; left out, as the path's own speeds and times say.",
                "anyOf": [timing],
            });
            for (key, description) in [
                (
                    "share_of_limits",
                    "With `timing`: largest share of grip, torques and wheel rates; 0.9 unless given.",
                ),
                (
                    "share_of_grip",
                    "With `timing`: share of grip and torques used [default: the largest, up to `share_of_limits`, at which the simulated robot loses at most 0.5 % of its motors' work to sliding].",
                ),
            ] {
                properties[key] = serde_json::json!({
                    "description": description,
                    "type": "number",
                    "exclusiveMinimum": 0.0,
                    "maximum": 1.0,
                });
            }
        }
        schema
    }
}
