//! `metadata.yaml`, by which rosbag2 recognises a folder as a bag.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::topic::Topic;

/// The version written by Humble. Every later distribution reads it, and ignores what it does not
/// know here.
const VERSION: u32 = 5;

/// Metadata of the whole bag.
pub(super) struct Metadata<'a> {
    /// The name of its one file.
    pub file: &'a str,
    /// The first and last time of a message, in ns.
    pub span: Option<(u64, u64)>,
    pub topics: &'a BTreeMap<String, Topic>,
}

impl Metadata<'_> {
    /// Returns the metadata in the form inside the MCAP file.
    pub fn to_yaml(&self) -> String {
        let Self { file, span, topics } = self;
        let (start, end) = span.unwrap_or_default();
        let duration = end - start;
        let count: u64 = topics.values().map(|topic| topic.count).sum();
        let mut text = format!(
            "version: {VERSION}\nstorage_identifier: mcap\nduration:\n  nanoseconds: {duration}\n\
             starting_time:\n  nanoseconds_since_epoch: {start}\nmessage_count: {count}\n"
        );
        text += if topics.is_empty() {
            "topics_with_message_count: []\n"
        } else {
            "topics_with_message_count:\n"
        };
        for (
            name,
            Topic {
                description,
                qos,
                count,
                ..
            },
        ) in *topics
        {
            // Rust quotes such a text like YAML.
            let qos = qos.to_yaml();
            let _ = write!(
                text,
                "  - topic_metadata:\n      name: {name}\n      type: {}\n      serialization_format: cdr\n      \
                 offered_qos_profiles: {qos:?}\n      type_description_hash: {}\n    message_count: {count}\n",
                description.type_name, description.type_hash,
            );
        }
        let _ = write!(
            text,
            "compression_format: \"\"\ncompression_mode: \"\"\nrelative_file_paths:\n  - {file}\nfiles:\n  - path: {file}\n    \
             starting_time:\n      nanoseconds_since_epoch: {start}\n    duration:\n      nanoseconds: {duration}\n    \
             message_count: {count}\n"
        );
        text
    }

    /// Returns the content of the file `metadata.yaml`.
    pub fn to_file(&self) -> String {
        let mut text = String::from("rosbag2_bagfile_information:\n");
        for line in self.to_yaml().lines() {
            let _ = writeln!(text, "  {line}");
        }
        text
    }
}
