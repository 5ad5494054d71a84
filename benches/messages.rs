//! Cost of encoding, decoding and recording the frames of a robot with 36 rollers.

use divan::Bencher;
use divan::counter::BytesCount;
use ilon_messages::Message;
use ilon_messages::bag::{BagWriter, Qos};
use ilon_messages::geometry_msgs::TransformStamped;
use ilon_messages::nav_msgs::Odometry;
use ilon_messages::tf2_msgs::TFMessage;

fn main() {
    divan::main();
}

/// A chassis and four wheels with nine rollers each.
fn frames() -> TFMessage {
    let frame = |number| {
        let mut frame = TransformStamped {
            child_frame_id: format!("wheel_roller_{number}"),
            ..Default::default()
        };
        frame.header.frame_id = "wheel_front_left".into();
        frame
    };
    TFMessage {
        transforms: (0..41).map(frame).collect(),
    }
}

#[divan::bench]
fn encode_frames(bencher: Bencher) {
    let (frames, mut bytes) = (frames(), Vec::new());
    let size = BytesCount::new(frames.encode().unwrap().len());
    bencher
        .counter(size)
        .bench_local(|| frames.encode_into(&mut bytes));
}

#[divan::bench]
fn decode_frames(bencher: Bencher) {
    let bytes = frames().encode().unwrap();
    bencher
        .counter(BytesCount::new(bytes.len()))
        .bench(|| TFMessage::decode(&bytes));
}

#[divan::bench]
fn encode_odometry(bencher: Bencher) {
    let (odometry, mut bytes) = (Odometry::default(), Vec::new());
    bencher.bench_local(|| odometry.encode_into(&mut bytes));
}

/// One second of frames at 60 Hz, from creating the bag to its end on disk.
#[divan::bench(sample_count = 20)]
fn record_one_second(bencher: Bencher) {
    let (frames, folder) = (frames(), tempfile::tempdir().unwrap());
    bencher.bench_local(|| {
        let mut bag = BagWriter::create(folder.path()).unwrap();
        bag.declare::<TFMessage>("/tf", Qos::reliable(100)).unwrap();
        for time_ns in (1..=60).map(|frame| frame * 16_666_667) {
            bag.write("/tf", &frames, time_ns).unwrap();
        }
        bag.finish().unwrap();
    });
}
