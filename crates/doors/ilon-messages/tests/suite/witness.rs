//! Random messages of ilon, judged by `witness.py`: its `rosbags` and `rclpy` must read the same
//! values, and write the same bytes.

use crate::common;

use std::path::Path;

use common::{Codec, Said, SaidType, Sample, codecs, python, run_witness};
use ilon_messages::{Description, FieldType, Message, Shape, ValueType, messages};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use serde_json::{Map, Value, json};

const SAMPLES_OF_EACH: usize = 8;

#[test]
fn the_witness_agrees_with_what_ilon_says() {
    let Some(python) = python() else { return };
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("said_by_ilon.json");
    std::fs::write(&path, serde_json::to_vec(&said_by_ilon()).unwrap()).unwrap();
    run_witness(&python, "check", &path);
}

fn said_by_ilon() -> Said {
    let mut runner = TestRunner::deterministic();
    let samples = codecs()
        .values()
        .flat_map(|codec| samples(codec, &mut runner))
        .collect();
    let types = messages().map(|message| {
        let said = SaidType {
            definition: message.definition(),
            hash: message.type_hash.into(),
        };
        (message.type_name.into(), said)
    });
    Said {
        types: types.collect(),
        samples,
    }
}

fn samples(codec: &Codec, runner: &mut TestRunner) -> Vec<Sample> {
    let random = (0..SAMPLES_OF_EACH)
        .map(|_| message(codec.description, runner))
        .collect::<Vec<_>>();
    let values = std::iter::once((codec.default)()).chain(random);
    let sample = |value: Value| {
        let little = (codec.encode)(value.clone());
        // ilon writes only little-endian; the other order comes through serde.
        let big = (codec.encode_by_serde)(value.clone(), true);
        // The value after rounding by JSON and 32-bit numbers.
        let value = (codec.decode)(&little).unwrap();
        Sample {
            r#type: codec.description.type_name.into(),
            value,
            little,
            big,
            rclpy: None,
        }
    };
    values.map(sample).collect()
}

fn message(description: &Description, runner: &mut TestRunner) -> Value {
    let fields = description
        .fields
        .iter()
        .map(|field| (field.name.into(), field_value(field.field_type, runner)));
    Value::Object(fields.collect::<Map<_, _>>())
}

fn field_value(FieldType { kind, shape }: FieldType, runner: &mut TestRunner) -> Value {
    match shape {
        Shape::One => single(kind, runner),
        // Arrays of these sizes are covariances, in rows.
        Shape::Array(count @ (9 | 36)) => {
            let side = count.isqrt();
            let row = |runner: &mut TestRunner| (0..side).map(|_| single(kind, runner)).collect();
            Value::Array((0..side).map(|_| Value::Array(row(runner))).collect())
        }
        Shape::Array(other) => panic!("no message has an array of {other}"),
        Shape::Sequence => Value::Array(
            (0..draw(0_usize..4, runner))
                .map(|_| single(kind, runner))
                .collect(),
        ),
    }
}

fn single(kind: ValueType, runner: &mut TestRunner) -> Value {
    match kind {
        ValueType::Bool => json!(draw(any::<bool>(), runner)),
        // rosbags treats a byte as signed.
        ValueType::Byte => json!(draw(0_u8..128, runner)),
        ValueType::U8 => json!(draw(any::<u8>(), runner)),
        ValueType::I32 => json!(draw(any::<i32>(), runner)),
        ValueType::U32 => json!(draw(any::<u32>(), runner)),
        ValueType::F32 => json!(draw(
            prop::num::f32::NORMAL | prop::num::f32::ZERO | prop::num::f32::SUBNORMAL,
            runner
        )),
        ValueType::F64 => json!(draw(
            prop::num::f64::NORMAL | prop::num::f64::ZERO | prop::num::f64::SUBNORMAL,
            runner
        )),
        ValueType::String => json!(
            draw(
                prop::collection::vec(prop::char::range('\u{1}', char::MAX), 0..20),
                runner
            )
            .iter()
            .collect::<String>()
        ),
        ValueType::Message(description) => message(description, runner),
        other => panic!("{other:?} is not drawn here"),
    }
}

fn draw<S: Strategy>(strategy: S, runner: &mut TestRunner) -> S::Value {
    strategy.new_tree(runner).unwrap().current()
}

/// The same by name and by type.
#[test]
fn names_and_hashes_are_constants() {
    use ilon_messages::nav_msgs::Odometry;
    assert_eq!(Odometry::TYPE_NAME, "nav_msgs/msg/Odometry");
    assert_eq!(
        Odometry::TYPE_HASH,
        "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"
    );
    assert_eq!(Odometry::definition(), Odometry::DESCRIPTION.definition());
}
