//! Decoding allocates memory in proportion to the input bytes, whatever lengths they claim. A test
//! program of its own, as it counts the allocations of the whole process.

#[path = "suite/common/mod.rs"]
mod common;

use std::alloc::System;

use common::witness;
use ilon_messages::Message;
use ilon_messages::diagnostic_msgs::DiagnosticArray;
use ilon_messages::nav_msgs::Path;
use ilon_messages::sensor_msgs::JointState;
use ilon_messages::std_msgs::Float64MultiArray;
use ilon_messages::tf2_msgs::TFMessage;
use ilon_messages::visualization_msgs::MarkerArray;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Allocated bytes per byte of a message. A status takes 104 bytes in memory and at least 17 in a
/// message, a string or a pair of strings six times as many. At most two such lists of nested
/// sequences are allocated before one fails, and then strings are copied.
const FACTOR: usize = 14;

/// Decodes, and returns the bytes allocated meanwhile.
type Decoder = fn(&[u8]) -> usize;

fn allocated<M: Message>(bytes: &[u8]) -> usize {
    let region = Region::new(ALLOCATOR);
    let _ = M::decode(bytes);
    region.change().bytes_allocated
}

#[test]
fn memory_follows_from_the_bytes_given() {
    let decoders: [(&str, Decoder); 6] = [
        (
            "diagnostic_msgs/msg/DiagnosticArray",
            allocated::<DiagnosticArray>,
        ),
        ("nav_msgs/msg/Path", allocated::<Path>),
        ("sensor_msgs/msg/JointState", allocated::<JointState>),
        (
            "std_msgs/msg/Float64MultiArray",
            allocated::<Float64MultiArray>,
        ),
        ("tf2_msgs/msg/TFMessage", allocated::<TFMessage>),
        (
            "visualization_msgs/msg/MarkerArray",
            allocated::<MarkerArray>,
        ),
    ];
    let said = witness();
    let mut most: f64 = 0.0;
    for (name, allocated) in decoders {
        let samples: Vec<_> = said
            .samples
            .iter()
            .filter(|sample| sample.r#type == *name)
            .collect();
        assert!(!samples.is_empty());
        for sample in samples {
            // Any four bytes may be a length: as large as possible, or just as large as might fit.
            let longer = [sample.little.as_slice(), &[0; 4000]].concat();
            for at in (4..sample.little.len() - 3).step_by(4) {
                for length in [u32::MAX, u32::MAX / 8, 4000, 1000, 500, 230, 50] {
                    let mut bytes = longer.clone();
                    bytes[at..at + 4].copy_from_slice(&length.to_le_bytes());
                    let memory = allocated(&bytes);
                    most = most.max(memory as f64 / bytes.len() as f64);
                    assert!(
                        memory <= FACTOR * bytes.len(),
                        "{name}: {memory} bytes for {} with {length} at {at}",
                        bytes.len()
                    );
                }
            }
        }
    }
    println!("at most {most:.1} bytes of memory for each byte of a message");
    // Checks that the test allocates at all.
    assert!(most > 1.0, "at most {most} bytes of memory for each byte");
}
