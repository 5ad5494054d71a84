//! Bags, read back by the MCAP crate, whole and truncated, and judged by `witness.py`.

use crate::common;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use common::{python, run_witness};
use ilon_messages::bag::{BagError, BagWriter, Qos};
use ilon_messages::builtin_interfaces::Time;
use ilon_messages::geometry_msgs::{TransformStamped, TwistStamped, Vector3Stamped};
use ilon_messages::nav_msgs::Odometry;
use ilon_messages::rosgraph_msgs::Clock;
use ilon_messages::sensor_msgs::JointState;
use ilon_messages::std_msgs::{Header, String as Text};
use ilon_messages::tf2_msgs::TFMessage;
use ilon_messages::visualization_msgs::{Marker, MarkerArray};
use ilon_messages::{CdrError, Message};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader};
use mcap::{MessageStream, Summary};
use serde_json::{Value, json};
use tempfile::tempdir;

const PERIOD_NS: u64 = 10_000_000;
const LATCHED: Qos = Qos::reliable(1).transient_local();

fn header(time_ns: u64, frame_id: &str) -> Header {
    Header {
        stamp: Time::from_nanoseconds(time_ns).unwrap(),
        frame_id: frame_id.into(),
    }
}

/// The written messages, for the witness: topic, time, value.
type Written = Vec<(&'static str, u64, Value)>;

fn put<M: Message + serde::Serialize>(
    bag: &mut BagWriter,
    all: &mut Written,
    topic: &'static str,
    message: &M,
    time_ns: u64,
) {
    bag.write(topic, message, time_ns).unwrap();
    all.push((topic, time_ns, serde_json::to_value(message).unwrap()));
}

/// Writes a bag like that of a run, with a number of control periods.
fn write_run(bag: &mut BagWriter, periods: u64) -> Written {
    let mut all = Vec::new();
    bag.declare::<Text>("/robot_description", LATCHED).unwrap();
    bag.declare::<TFMessage>("/tf_static", LATCHED).unwrap();
    bag.declare::<TFMessage>("/tf", Qos::reliable(100)).unwrap();
    bag.declare::<Clock>("/clock", Qos::best_effort(1)).unwrap();
    bag.declare::<JointState>("/joint_states", Qos::reliable(10))
        .unwrap();
    bag.declare::<Odometry>("/odom", Qos::reliable(10)).unwrap();
    bag.declare::<Odometry>("/ground_truth/odom", Qos::reliable(10))
        .unwrap();
    bag.declare::<TwistStamped>("/cmd_vel", Qos::reliable(10))
        .unwrap();
    bag.declare::<Vector3Stamped>("/wheels/front_left/slip", Qos::reliable(10))
        .unwrap();
    bag.declare::<MarkerArray>("/contacts", Qos::reliable(10))
        .unwrap();
    let robot = Text {
        data: format!(
            "<robot name=\"ü\">{}</robot>",
            "<link name=\"roller\"/>".repeat(14_000)
        ),
    };
    put(bag, &mut all, "/robot_description", &robot, PERIOD_NS);
    let transform = |time_ns, child: &str| TransformStamped {
        header: header(time_ns, "base_link"),
        child_frame_id: child.into(),
        ..Default::default()
    };
    let fixed = TFMessage {
        transforms: vec![transform(PERIOD_NS, "lidar")],
    };
    put(bag, &mut all, "/tf_static", &fixed, PERIOD_NS);
    for period in 1..=periods {
        let time_ns = period * PERIOD_NS;
        let seconds = time_ns as f64 * 1e-9;
        let mut odometry = Odometry {
            header: header(time_ns, "odom"),
            child_frame_id: "base_link".into(),
            ..Default::default()
        };
        odometry.pose.pose.position.x = seconds;
        odometry.pose.covariance[5][5] = 0.01;
        let joints = JointState {
            header: header(time_ns, ""),
            name: vec!["front_left".into(), "front_right".into()],
            position: vec![seconds, -seconds],
            effort: vec![0.5, 0.25],
            ..Default::default()
        };
        let marker = Marker {
            header: header(time_ns, "world"),
            r#type: Marker::ARROW,
            ..Default::default()
        };
        put(
            bag,
            &mut all,
            "/clock",
            &Clock {
                clock: Time::from_nanoseconds(time_ns).unwrap(),
            },
            time_ns,
        );
        put(
            bag,
            &mut all,
            "/tf",
            &TFMessage {
                transforms: vec![transform(time_ns, "wheel"), transform(time_ns, "roller")],
            },
            time_ns,
        );
        put(bag, &mut all, "/joint_states", &joints, time_ns);
        put(bag, &mut all, "/odom", &odometry, time_ns);
        put(bag, &mut all, "/ground_truth/odom", &odometry, time_ns);
        put(
            bag,
            &mut all,
            "/cmd_vel",
            &TwistStamped {
                header: header(time_ns, "base_link"),
                ..Default::default()
            },
            time_ns,
        );
        let slip = Vector3Stamped {
            header: header(time_ns, "wheel"),
            ..Default::default()
        };
        put(bag, &mut all, "/wheels/front_left/slip", &slip, time_ns);
        put(
            bag,
            &mut all,
            "/contacts",
            &MarkerArray {
                markers: vec![marker],
            },
            time_ns,
        );
    }
    all
}

fn file(folder: &Path) -> std::path::PathBuf {
    folder.join("bag_0.mcap")
}

fn unfinished(folder: &Path) -> std::path::PathBuf {
    folder.join("bag_0.mcap.ilon-partial")
}

/// Number of messages that a sequential reader gets before the bytes end or become invalid.
fn readable_messages(bytes: &[u8]) -> usize {
    let mut reader = LinearReader::new();
    let (mut rest, mut count) = (bytes, 0);
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let taken = wanted.min(rest.len());
                reader.insert(taken).copy_from_slice(&rest[..taken]);
                reader.notify_read(taken);
                rest = &rest[taken..];
            }
            Ok(LinearReadEvent::Record { opcode, .. }) => {
                count += usize::from(opcode == mcap::records::op::MESSAGE)
            }
            Err(_) => break,
        }
    }
    count
}

/// Whether records, each an opcode and a length before as many bytes, fill the file after its magic
/// to its last byte.
fn ends_with_a_record(bytes: &[u8]) -> bool {
    let mut at = mcap::MAGIC.len();
    while at < bytes.len() {
        let Some(length) = bytes.get(at + 1..at + 9) else {
            return false;
        };
        at = at
            .saturating_add(9)
            .saturating_add(u64::from_le_bytes(length.try_into().unwrap()) as usize);
    }
    at == bytes.len()
}

#[test]
fn a_finished_bag_holds_what_was_written() {
    let folder = tempdir().unwrap();
    let mut bag = BagWriter::create(folder.path()).unwrap();
    let all = write_run(&mut bag, 500);
    bag.finish().unwrap();
    let bytes = fs::read(file(folder.path())).unwrap();
    let read: Vec<_> = MessageStream::new(&bytes)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    assert_eq!(read.len(), all.len());
    for (message, (topic, time_ns, _)) in read.iter().zip(&all) {
        assert_eq!(
            (
                message.channel.topic.as_str(),
                message.log_time,
                message.publish_time
            ),
            (*topic, *time_ns, *time_ns)
        );
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!(schema.encoding, "ros2msg");
        assert_eq!(message.channel.message_encoding, "cdr");
    }
    let odom = read
        .iter()
        .find(|message| message.channel.topic == "/odom")
        .unwrap();
    assert_eq!(
        odom.channel.schema.as_ref().unwrap().data,
        Odometry::definition().as_bytes()
    );
    assert_eq!(
        odom.channel.metadata["topic_type_hash"],
        Odometry::TYPE_HASH
    );
    assert_eq!(
        serde_json::to_value(Odometry::decode(&odom.data).unwrap()).unwrap(),
        all.iter().find(|said| said.0 == "/odom").unwrap().2
    );
    let summary = Summary::read(&bytes).unwrap().unwrap();
    // 5 s of messages, in chunks of 1 s.
    assert!(
        (5..=7).contains(&summary.chunk_indexes.len()),
        "{} chunks",
        summary.chunk_indexes.len()
    );
    assert_eq!(summary.stats.unwrap().message_count, all.len() as u64);
}

/// As after `kill -9`: data in memory is lost, and there is no index.
#[test]
fn what_a_killed_writer_leaves_can_be_read() {
    let folder = tempdir().unwrap();
    let mut bag = BagWriter::create(folder.path()).unwrap();
    let all = write_run(&mut bag, 1000);
    std::mem::forget(bag);
    let bytes = fs::read(unfinished(folder.path())).unwrap();
    assert!(
        ends_with_a_record(&bytes),
        "a record in the middle of which the file ends"
    );
    let count = readable_messages(&bytes);
    // A chunk of 1 s has 100 periods of 8 messages.
    assert!(
        count < all.len() && count >= all.len() - 800,
        "{count} of {}",
        all.len()
    );
    assert!(!folder.path().join("metadata.yaml").exists());
    // As after a power failure while the file grew: never fewer messages than in the complete
    // chunks.
    let mut fewer = usize::MAX;
    for end in (0..bytes.len()).rev().step_by(bytes.len() / 97) {
        let left = readable_messages(&bytes[..end]);
        assert!(left <= fewer.min(count));
        fewer = left;
        assert!(
            left as f64 >= (end as f64 / bytes.len() as f64 - 0.25) * count as f64,
            "{left} messages in {end} bytes"
        );
    }
}

#[test]
fn a_dropped_writer_leaves_a_whole_file() {
    let folder = tempdir().unwrap();
    let mut bag = BagWriter::create(folder.path()).unwrap();
    let all = write_run(&mut bag, 10);
    drop(bag);
    let bytes = fs::read(unfinished(folder.path())).unwrap();
    assert_eq!(
        MessageStream::new(&bytes)
            .unwrap()
            .map(Result::unwrap)
            .count(),
        all.len()
    );
    assert!(!folder.path().join("metadata.yaml").exists());
}

#[test]
fn a_bag_replaces_an_older_one() {
    let folder = tempdir().unwrap();
    let mut older = BagWriter::create(folder.path()).unwrap();
    write_run(&mut older, 300);
    older.finish().unwrap();
    let older = fs::metadata(file(folder.path())).unwrap().len();
    let bag = BagWriter::create(folder.path()).unwrap();
    assert!(
        !folder.path().join("metadata.yaml").exists(),
        "it spoke of the older bag"
    );
    bag.finish().unwrap();
    assert!(fs::metadata(file(folder.path())).unwrap().len() < older / 10);
    let names: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(names.len(), 2, "{names:?}");
}

#[test]
fn what_cannot_be_written_is_refused_and_the_rest_is_kept() {
    let folder = tempdir().unwrap();
    let mut bag = BagWriter::create(folder.path()).unwrap();
    bag.declare::<Text>("/text", LATCHED).unwrap();
    let text = |data: &str| Text { data: data.into() };
    assert!(matches!(
        bag.write("/other", &text("a"), 1),
        Err(BagError::NotDeclared { .. })
    ));
    assert!(matches!(
        bag.write("/text", &Clock::default(), 1),
        Err(BagError::NotDeclared { .. })
    ));
    let error = bag.write("/text", &text("a\0b"), 1).unwrap_err();
    assert!(matches!(
        error,
        BagError::Message {
            source: CdrError::Nul { .. },
            ..
        }
    ));
    bag.write("/text", &text("b"), i64::MAX as u64).unwrap();
    bag.write("/text", &text("a"), 0).unwrap();
    bag.finish().unwrap();
    let bytes = fs::read(file(folder.path())).unwrap();
    let times: Vec<_> = MessageStream::new(&bytes)
        .unwrap()
        .map(|message| message.unwrap().log_time)
        .collect();
    assert_eq!(times, [i64::MAX as u64, 0]);
    let metadata = fs::read_to_string(folder.path().join("metadata.yaml")).unwrap();
    assert!(
        metadata.contains("\n  duration:\n    nanoseconds: 9223372036854775807\n"),
        "{metadata}"
    );
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let folder = tempdir().unwrap();
    let taken = folder.path().join("file");
    fs::write(&taken, "").unwrap();
    let error = BagWriter::create(&taken).unwrap_err().to_string();
    assert!(error.contains(taken.to_str().unwrap()), "{error}");
    fs::create_dir(folder.path().join("bag_0.mcap")).unwrap();
    let error = BagWriter::create(folder.path()).unwrap_err().to_string();
    assert!(error.contains("bag_0.mcap"), "{error}");
}

/// `rosbags` opens the folder, `mcap` the file alone and the file of a killed writer, and both
/// decode by the embedded definitions.
#[test]
fn the_witness_reads_the_bag() {
    let Some(python) = python() else { return };
    let folder = tempdir().unwrap();
    let mut expected = BTreeMap::new();
    for (name, periods) in [("run", 250), ("short", 1)] {
        let mut bag = BagWriter::create(&folder.path().join(name)).unwrap();
        expected.insert(name, write_run(&mut bag, periods));
        bag.finish().unwrap();
    }
    BagWriter::create(&folder.path().join("empty"))
        .unwrap()
        .finish()
        .unwrap();
    expected.insert("empty", Vec::new());
    let mut killed = BagWriter::create(&folder.path().join("killed")).unwrap();
    expected.insert("killed", write_run(&mut killed, 250));
    std::mem::forget(killed);
    let qos: BTreeMap<_, _> = [
        (
            "/robot_description",
            json!(["RELIABLE", "TRANSIENT_LOCAL", 1]),
        ),
        ("/tf_static", json!(["RELIABLE", "TRANSIENT_LOCAL", 1])),
        ("/tf", json!(["RELIABLE", "VOLATILE", 100])),
        ("/clock", json!(["BEST_EFFORT", "VOLATILE", 1])),
    ]
    .into();
    let file = folder.path().join("expected.json");
    fs::write(&file, json!({"bags": expected, "qos": qos}).to_string()).unwrap();
    run_witness(&python, "bags", &file);
}

/// Three messages from 5 to 7.5 s, out of order: the metadata contain their first time, the time
/// between first and last, and their number.
#[test]
fn metadata_say_when_a_bag_begins_how_long_it_is_and_what_it_holds() {
    let folder = tempdir().unwrap();
    let mut bag = BagWriter::create(folder.path()).unwrap();
    bag.declare::<Clock>("/clock", Qos::best_effort(1)).unwrap();
    bag.declare::<Odometry>("/odom", Qos::reliable(10)).unwrap();
    for time_ns in [6_000_000_000, 5_000_000_000, 7_500_000_000] {
        bag.write("/clock", &Clock::default(), time_ns).unwrap();
    }
    bag.finish().unwrap();
    let said = fs::read_to_string(folder.path().join("metadata.yaml")).unwrap();
    let after = |key: &str| -> Vec<&str> {
        let lines = said
            .lines()
            .map(|line| line.trim().trim_start_matches("- "));
        lines.filter_map(|line| line.strip_prefix(key)).collect()
    };
    // Of the bag, and of its one file.
    assert_eq!(after("nanoseconds_since_epoch: "), ["5000000000"; 2]);
    assert_eq!(after("nanoseconds: "), ["2500000000"; 2]);
    // Of the bag, of either topic, and of the file.
    assert_eq!(after("message_count: "), ["3", "3", "0", "3"]);
}

#[test]
fn a_folder_that_is_no_bag_of_mcap_is_refused_with_what_it_is() {
    let folder = tempdir().unwrap();
    let files = ilon_files::FileAccess::anywhere();
    let refused = || {
        let read = ilon_messages::bag::read(folder.path(), &files, &mut |_| true);
        read.expect_err("it is no bag").to_string()
    };
    assert!(refused().contains("without an MCAP file"), "{}", refused());
    fs::write(folder.path().join("notes.txt"), "of the drive").unwrap();
    assert!(refused().contains("without an MCAP file"), "{}", refused());
    fs::write(folder.path().join("drive_0.db3"), "SQLite format 3").unwrap();
    assert!(refused().contains("SQLite"), "{}", refused());

    // A bag with other files beside it is a bag.
    let mut bag = BagWriter::create(&folder.path().join("bag")).unwrap();
    bag.declare::<Clock>("/clock", Qos::best_effort(1)).unwrap();
    bag.write("/clock", &Clock::default(), PERIOD_NS).unwrap();
    bag.finish().unwrap();
    let mut seen = 0;
    let is_whole = ilon_messages::bag::read(&folder.path().join("bag"), &files, &mut |_| {
        seen += 1;
        true
    });
    assert!(is_whole.unwrap());
    assert_eq!(seen, 1);

    // A bag that ends before its first message is refused; the file begins with 8 bytes of magic.
    let whole = fs::read(folder.path().join("bag/bag_0.mcap")).unwrap();
    let cut = folder.path().join("cut.mcap");
    // Without its last 40 bytes it lacks the end of its footer; the message is read, and that it is
    // not whole is said.
    fs::write(&cut, &whole[..whole.len() - 40]).unwrap();
    assert!(!ilon_messages::bag::read(&cut, &files, &mut |_| true).unwrap());
    for length in [8, 20, 60] {
        fs::write(&cut, &whole[..length]).unwrap();
        let refused = ilon_messages::bag::read(&cut, &files, &mut |_| true).unwrap_err();
        assert!(refused.to_string().contains("cut short"), "{refused}");
    }
}
