//! Decoding arbitrary bytes ends in a message or in an error that names the place.

use crate::common;

use common::{codecs, witness};
use ilon_messages::builtin_interfaces::Time;
use ilon_messages::geometry_msgs::Quaternion;
use ilon_messages::sensor_msgs::JointState;
use ilon_messages::std_msgs::{Float64MultiArray, Header, String as Text};
use ilon_messages::visualization_msgs::Marker;
use ilon_messages::{CdrError, Message};
use proptest::prelude::*;

const LITTLE: [u8; 4] = [0, 1, 0, 0];

fn text(bytes: &[u8]) -> Result<Text, CdrError> {
    Text::decode(&[&LITTLE, bytes].concat())
}

#[test]
fn a_message_cut_short_is_refused_at_every_length() {
    let codecs = codecs();
    for sample in witness().samples {
        let codec = &codecs[sample.r#type.as_str()];
        for bytes in [&sample.little, &sample.big] {
            for end in 0..bytes.len() {
                let error = (codec.decode)(&bytes[..end]).unwrap_err();
                assert!(
                    matches!(error, CdrError::Short { .. } | CdrError::Length { .. }),
                    "{}: {error}",
                    sample.r#type
                );
            }
        }
    }
}

/// A message that is read despite a flipped bit is valid: encoded, it is read as the same.
#[test]
fn a_flipped_bit_gives_a_message_or_an_error() {
    let codecs = codecs();
    for sample in witness().samples {
        let codec = &codecs[sample.r#type.as_str()];
        for bit in 0..8 * sample.little.len() {
            let mut bytes = sample.little.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            if let Ok(written) = (codec.again)(&bytes) {
                assert_eq!(
                    (codec.again)(&written).unwrap(),
                    written,
                    "{}, bit {bit}",
                    sample.r#type
                );
            }
        }
    }
}

proptest! {
    #[test]
    fn random_bytes_give_a_message_or_an_error(bytes: Vec<u8>, big_endian: bool) {
        let bytes = [&[0, u8::from(!big_endian), 0, 0], bytes.as_slice()].concat();
        for codec in codecs().values() {
            if let Ok(written) = (codec.again)(&bytes) {
                prop_assert_eq!((codec.again)(&written).unwrap(), written, "{}", codec.description.type_name);
            }
        }
    }
}

#[test]
fn errors_name_what_is_wrong_and_where() {
    assert_eq!(
        Text::decode(&[]),
        Err(CdrError::Short { end: 0, wanted: 4 })
    );
    assert_eq!(text(&[]), Err(CdrError::Short { end: 4, wanted: 4 }));
    // A parameter list, and the newer form of CDR.
    assert_eq!(Text::decode(&[0, 3, 0, 0]), Err(CdrError::Encoding(3)));
    assert_eq!(Text::decode(&[0, 7, 0, 0]), Err(CdrError::Encoding(7)));
    assert_eq!(
        text(&[2, 0, 0, 0, b'a']),
        Err(CdrError::Length {
            at: 4,
            length: 2,
            left: 1
        })
    );
    assert_eq!(text(&[2, 0, 0, 0, 0xff, 0]), Err(CdrError::Utf8 { at: 8 }));
    assert_eq!(
        text(&[2, 0, 0, 0, b'a', b'b']),
        Err(CdrError::Nul { at: 8 })
    );
    assert_eq!(
        text(&[3, 0, 0, 0, b'a', 0, 0]),
        Err(CdrError::Nul { at: 8 })
    );
    assert_eq!(
        text(&[2, 0, 0, 0, b'a', 0, 9, 9, 9, 9]),
        Err(CdrError::Trailing { at: 10, count: 4 })
    );
    let mut marker = Marker::default().encode().unwrap();
    *marker.last_mut().unwrap() = 2;
    assert_eq!(
        Marker::decode(&marker),
        Err(CdrError::Bool {
            at: marker.len() - 1,
            value: 2
        })
    );
}

#[test]
fn what_other_writers_leave_over_is_passed() {
    let expected = Text { data: "a".into() };
    for padding in 0..=3 {
        assert_eq!(
            text(&[&[2, 0, 0, 0, b'a', 0], &[9; 3][..padding]].concat()),
            Ok(expected.clone())
        );
    }
    // Without even its NUL.
    assert_eq!(text(&[0, 0, 0, 0]), Ok(Text::default()));
    // rclpy counts alignment before the numbers of empty sequences.
    let joints = JointState {
        name: vec!["wheel".into()],
        ..Default::default()
    };
    let bytes = [joints.encode().unwrap(), vec![9; 8]].concat();
    assert_eq!(JointState::decode(&bytes), Ok(joints));
}

/// Readers in C would take it for the end.
#[test]
fn a_nul_within_a_string_is_not_written() {
    let header = Header {
        frame_id: "base\0link".into(),
        ..Default::default()
    };
    assert_eq!(header.encode(), Err(CdrError::Nul { at: 12 }));
}

#[test]
fn numbers_come_back_bit_by_bit() {
    let data: Vec<_> = [
        0,
        1,
        u64::MAX,
        f64::NAN.to_bits(),
        0x7ff0_0000_dead_beef,
        f64::NEG_INFINITY.to_bits(),
        (-0.0_f64).to_bits(),
    ]
    .into_iter()
    .map(f64::from_bits)
    .collect();
    let array = Float64MultiArray {
        data,
        ..Default::default()
    };
    let back = Float64MultiArray::decode(&array.encode().unwrap()).unwrap();
    let bits = |array: &Float64MultiArray| {
        array
            .data
            .iter()
            .map(|number| number.to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(bits(&back), bits(&array));
}

#[test]
fn a_buffer_serves_many_messages() {
    let (short, long) = (
        Text { data: "a".into() },
        Text {
            data: "abcdefgh".into(),
        },
    );
    let mut bytes = Vec::new();
    long.encode_into(&mut bytes).unwrap();
    short.encode_into(&mut bytes).unwrap();
    assert_eq!(bytes, short.encode().unwrap());
}

/// As ROS 2 fills a new message.
#[test]
fn by_default_nothing_is_turned() {
    assert_eq!(
        Quaternion::default(),
        Quaternion {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: 1.0
        }
    );
    assert_eq!(Marker::default().pose.orientation.w, 1.0);
}

#[test]
fn moments_are_counted_in_nanoseconds() {
    assert_eq!(
        Time::from_nanoseconds(1_500_000_007),
        Some(Time {
            sec: 1,
            nanosec: 500_000_007
        })
    );
    let last = Time {
        sec: i32::MAX,
        nanosec: 999_999_999,
    };
    assert_eq!(
        Time::from_nanoseconds(last.nanoseconds().unwrap()),
        Some(last)
    );
    assert_eq!(
        Time::from_nanoseconds(last.nanoseconds().unwrap() + 1),
        None
    );
    assert_eq!(
        Time {
            sec: -1,
            nanosec: 0
        }
        .nanoseconds(),
        None
    );
}
