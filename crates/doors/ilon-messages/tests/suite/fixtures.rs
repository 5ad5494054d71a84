//! Messages as `rosbags` and `rclpy` write them, in `fixtures/messages.json`.

use crate::common;

use std::fmt::Write;

use common::{codecs, witness};
use ilon_messages::{Description, FieldType, Shape, ValueType, messages};
use sha2::{Digest, Sha256};

/// Every message type of ilon is in the fixtures, alone or within another.
#[test]
fn definitions_and_hashes_are_those_of_the_witness() {
    let said = witness();
    let ours: Vec<_> = messages().map(|message| message.type_name).collect();
    assert!(said.types.keys().all(|name| ours.contains(&name.as_str())));
    for message in messages() {
        let expected = &said.types[message.type_name];
        assert_eq!(message.definition(), expected.definition);
        assert_eq!(message.type_hash, expected.hash, "{}", message.type_name);
    }
}

#[test]
fn bytes_are_those_of_the_witness() {
    let codecs = codecs();
    for (number, sample) in witness().samples.into_iter().enumerate() {
        let name = &sample.r#type;
        let codec = &codecs[name.as_str()];
        assert_eq!(
            (codec.encode)(sample.value.clone()),
            sample.little,
            "{name}, sample {number}"
        );
        for bytes in [&sample.little, &sample.big] {
            // As text, in which 0 and -0 differ.
            assert_eq!(
                (codec.decode)(bytes).unwrap().to_string(),
                sample.value.to_string(),
                "{name}, sample {number}"
            );
        }
    }
}

/// rclpy leaves padding unset, and extra bytes at the end.
#[test]
fn what_rclpy_writes_is_read() {
    let codecs = codecs();
    let mut left_over = 0;
    let samples = witness().samples.into_iter().filter_map(|sample| {
        sample
            .rclpy
            .map(|bytes| (sample.r#type, sample.value, bytes))
    });
    for (name, value, bytes) in samples {
        let codec = &codecs[name.as_str()];
        let bytes = hex::decode(bytes).unwrap();
        assert_eq!((codec.decode)(&bytes).unwrap(), value, "{name}");
        left_over += usize::from(bytes.len() > (codec.encode)(value).len() + 3);
    }
    assert!(
        left_over > 0,
        "the fixtures do not show what rclpy leaves over"
    );
}

/// Other middleware serializes ilon's messages through serde: the bytes are the same.
#[test]
fn serde_describes_the_same_messages() {
    let codecs = codecs();
    for sample in witness().samples {
        let codec = &codecs[sample.r#type.as_str()];
        assert_eq!(
            (codec.encode_by_serde)(sample.value.clone(), false),
            sample.little
        );
        assert_eq!((codec.encode_by_serde)(sample.value, true), sample.big);
    }
}

/// REP-2016: SHA-256 of the description as JSON, in one line, with nested types in the order of
/// their names.
#[test]
fn hashes_follow_from_the_fields() {
    for message in messages() {
        let mut within = message.messages_within();
        within.sort_by_key(|message| message.type_name);
        let within: Vec<_> = within.into_iter().map(described).collect();
        let described = format!(
            "{{\"type_description\": {}, \"referenced_type_descriptions\": [{}]}}",
            described(message),
            within.join(", ")
        );
        let hash = Sha256::digest(described.as_bytes()).iter().fold(
            String::from("RIHS01_"),
            |mut text, byte| {
                write!(text, "{byte:02x}").unwrap();
                text
            },
        );
        assert_eq!(message.type_hash, hash, "{}", message.type_name);
    }
}

fn described(message: &Description) -> String {
    let fields: Vec<_> = message
        .fields
        .iter()
        .map(|field| {
            let FieldType { kind, shape } = field.field_type;
            let (kind, nested) = match kind {
                ValueType::Message(message) => (1, message.type_name),
                ValueType::U8 => (3, ""),
                ValueType::I32 => (6, ""),
                ValueType::U32 => (7, ""),
                ValueType::F32 => (10, ""),
                ValueType::F64 => (11, ""),
                ValueType::Bool => (15, ""),
                ValueType::Byte => (16, ""),
                ValueType::String => (17, ""),
                other => panic!("{other:?} has no number here"),
            };
            let (several, capacity) = match shape {
                Shape::One => (0, 0),
                Shape::Array(count) => (48, count),
                Shape::Sequence => (144, 0),
            };
            format!(
                "{{\"name\": \"{}\", \"type\": {{\"type_id\": {}, \"capacity\": {capacity}, \"string_capacity\": 0, \
                 \"nested_type_name\": \"{nested}\"}}}}",
                field.name,
                kind + several
            )
        })
        .collect();
    format!(
        "{{\"type_name\": \"{}\", \"fields\": [{}]}}",
        message.type_name,
        fields.join(", ")
    )
}
