//! Messages by their names, as JSON, and files of samples.
#![allow(dead_code, reason = "each test takes its part")]

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use byteorder::{BigEndian, LittleEndian};
use ilon_messages::{CdrError, Description, Message, messages};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::Value;

/// Functions for messages of one type. Values are JSON.
pub struct Codec {
    pub description: &'static Description,
    pub decode: fn(&[u8]) -> Result<Value, CdrError>,
    pub encode: fn(Value) -> Vec<u8>,
    /// Encodes with another implementation of CDR, through serde: little-endian or big-endian,
    /// after its header.
    pub encode_by_serde: fn(Value, bool) -> Vec<u8>,
    /// Decodes, and encodes the result.
    pub again: fn(&[u8]) -> Result<Vec<u8>, CdrError>,
    pub default: fn() -> Value,
}

fn codec<M: Message + Default + Serialize + DeserializeOwned>() -> Codec {
    Codec {
        description: M::DESCRIPTION,
        decode: |bytes| M::decode(bytes).map(|message| serde_json::to_value(message).unwrap()),
        encode: |value| {
            serde_json::from_value::<M>(value)
                .unwrap()
                .encode()
                .unwrap()
        },
        encode_by_serde: |value, big_endian| {
            let message: M = serde_json::from_value(value).unwrap();
            if big_endian {
                [
                    vec![0, 0, 0, 0],
                    cdr_encoding::to_vec::<M, BigEndian>(&message).unwrap(),
                ]
                .concat()
            } else {
                [
                    vec![0, 1, 0, 0],
                    cdr_encoding::to_vec::<M, LittleEndian>(&message).unwrap(),
                ]
                .concat()
            }
        },
        again: |bytes| M::decode(bytes)?.encode(),
        default: || serde_json::to_value(M::default()).unwrap(),
    }
}

/// Every message type of the crate, by its name.
pub fn codecs() -> BTreeMap<&'static str, Codec> {
    macro_rules! all {
        ($($package:ident: $($name:ident)*;)*) => { [$($( codec::<ilon_messages::$package::$name>() ),*),*] };
    }
    let all = all! {
        builtin_interfaces: Time Duration;
        diagnostic_msgs: KeyValue DiagnosticStatus DiagnosticArray;
        geometry_msgs: Point Vector3 Quaternion Pose PoseStamped PoseWithCovariance Twist TwistStamped TwistWithCovariance
            Transform TransformStamped Vector3Stamped Wrench WrenchStamped;
        nav_msgs: Odometry Path;
        rosgraph_msgs: Clock;
        sensor_msgs: Imu JointState CompressedImage;
        std_msgs: Header String ColorRGBA MultiArrayDimension MultiArrayLayout Float64MultiArray;
        tf2_msgs: TFMessage;
        trajectory_msgs: JointTrajectory JointTrajectoryPoint;
        visualization_msgs: UVCoordinate MeshFile Marker MarkerArray;
    };
    let codecs: BTreeMap<_, _> = all
        .into_iter()
        .map(|codec| (codec.description.type_name, codec))
        .collect();
    assert!(
        messages().all(|message| codecs.contains_key(message.type_name)),
        "a message is missing here"
    );
    codecs
}

/// A file of messages; `witness.py` writes and reads the same format.
#[derive(Serialize, Deserialize)]
pub struct Said {
    pub types: BTreeMap<String, SaidType>,
    pub samples: Vec<Sample>,
}

#[derive(Serialize, Deserialize)]
pub struct SaidType {
    pub definition: String,
    pub hash: String,
}

#[derive(Serialize, Deserialize)]
pub struct Sample {
    pub r#type: String,
    pub value: Value,
    #[serde(with = "hex")]
    pub little: Vec<u8>,
    #[serde(with = "hex")]
    pub big: Vec<u8>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rclpy: Option<String>,
}

/// The messages of `rosbags` and `rclpy`, as recorded by `witness.py write`.
pub fn witness() -> Said {
    serde_json::from_str(include_str!("../../fixtures/messages.json")).unwrap()
}

/// A Python with the packages of `witness.py` (`requirements.txt`): that of `ILON_PYTHON`, or
/// `python3`. Without one it prints that the test is skipped.
pub fn python() -> Option<String> {
    let named = std::env::var("ILON_PYTHON").ok();
    let python = named.clone().unwrap_or("python3".into());
    let tried = Command::new(&python)
        .args(["-c", "import rosbags, mcap_ros2"])
        .output();
    if tried.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    assert!(
        named.is_none(),
        "{python}, named by ILON_PYTHON, lacks what tests/requirements.txt lists"
    );
    println!("skipped: {python} lacks what tests/requirements.txt lists");
    None
}

/// Runs `witness.py`, which must agree.
pub fn run_witness(python: &str, command: &str, file: &Path) {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/witness.py");
    let output = Command::new(python)
        .args([script, command])
        .arg(file)
        .output()
        .unwrap();
    print!("{}", String::from_utf8_lossy(&output.stdout));
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}
