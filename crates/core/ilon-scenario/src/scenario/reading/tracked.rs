//! Reading of `[reference]`: one key names a path, and keys beside it define its timing.

use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeSeed, Error, IntoDeserializer, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

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
                    let (key, map) = (Some(key), &mut map);
                    let entry = MapAccessDeserializer::new(Entry { key, map });
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

/// A table of one entry, of which the key has been read.
struct Entry<'m, A> {
    key: Option<String>,
    map: &'m mut A,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Entry<'_, A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, A::Error> {
        let key = self.key.take().map(String::into_deserializer);
        key.map(|key| seed.deserialize(key)).transpose()
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.map.next_value_seed(seed)
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
