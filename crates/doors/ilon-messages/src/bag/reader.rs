//! Sequential reading of bags from any writer.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use ilon_files::{FileAccess, ReadError};
use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::{CdrError, Message};

/// The longest record held in memory, and the largest unpacked size of a chunk, in bytes.
const RECORD_BYTES: usize = 256 << 20;

/// Largest number of topics listed.
const MOST_TOPICS: usize = 1000;

/// The encoding of messages in ROS 2 bags.
const CDR: &str = "cdr";

/// A message of a bag.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ReadMessage<'a> {
    /// Its topic.
    pub topic: &'a str,
    /// Its type, such as `geometry_msgs/msg/Twist`.
    pub type_name: &'a str,
    /// Recording time, in nanoseconds.
    pub log_time_ns: u64,
    /// Its content, as CDR.
    pub cdr: &'a [u8],
}

impl ReadMessage<'_> {
    /// Decodes it as a message of a type.
    ///
    /// # Errors
    /// If it has another type, or its content does not match the type.
    pub fn decode<M: Message>(&self) -> Result<M, MessageFault> {
        if self.type_name != M::TYPE_NAME {
            return Err(MessageFault::OtherType {
                topic: self.topic.to_owned(),
                type_name: self.type_name.to_owned(),
            });
        }
        M::decode(self.cdr).map_err(|reason| MessageFault::Damaged {
            topic: self.topic.to_owned(),
            type_name: M::TYPE_NAME,
            reason,
        })
    }
}

/// Reasons why a message is not the expected one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MessageFault {
    /// Another type.
    #[error("`{topic}` is of the type {type_name}")]
    OtherType {
        /// Its topic.
        topic: String,
        /// Its type.
        type_name: String,
    },
    /// Its content does not match its type.
    #[error("a message of `{topic}` is no {type_name}: {reason}")]
    Damaged {
        /// Its topic.
        topic: String,
        /// Its type.
        type_name: &'static str,
        /// The reason.
        reason: CdrError,
    },
}

impl MessageFault {
    /// Returns a remedy; `choose` returns the accepted types.
    pub fn help(&self, choose: impl FnOnce() -> String) -> String {
        match self {
            Self::OtherType { .. } => choose(),
            Self::Damaged { .. } => {
                "the recording is damaged, or its type has other fields than that of ROS 2"
                    .to_owned()
            }
        }
    }
}

/// The topics of a bag read so far, with their types, and the time since the first message.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    first_ns: Option<u64>,
    topics: BTreeMap<String, String>,
}

impl Seen {
    /// Records a message's topic, up to a thousand topics. Returns the seconds since the first
    /// message: seconds since 1970 leave no digits for times within a period.
    pub fn note(&mut self, message: &ReadMessage) -> f64 {
        if !self.topics.contains_key(message.topic) && self.topics.len() < MOST_TOPICS {
            let (topic, kind) = (message.topic.to_owned(), message.type_name.to_owned());
            self.topics.insert(topic, kind);
        }
        let first_ns = *self.first_ns.get_or_insert(message.log_time_ns);
        (i128::from(message.log_time_ns) - i128::from(first_ns)) as f64 * 1e-9
    }

    /// The topics, each with its type.
    pub fn topics(&self) -> &BTreeMap<String, String> {
        &self.topics
    }

    /// Returns the topics as text.
    pub fn listed(&self) -> String {
        let topics = self.topics.iter();
        let listed = topics.map(|(topic, kind)| format!("`{topic}` ({kind})"));
        listed.collect::<Vec<_>>().join(", ")
    }
}

/// Reasons why a bag cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BagReadError {
    /// A file is unreadable or inaccessible.
    #[error("cannot read {path}: {reason}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: ReadError,
    },
    /// A file that is not MCAP, or a folder without MCAP files.
    #[error("{path} {what}")]
    NotABag {
        /// The file or folder.
        path: PathBuf,
        /// What it is instead.
        what: &'static str,
    },
    /// A file is damaged.
    #[error("{path} is damaged: {reason}")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The place and the damage.
        reason: String,
    },
}

/// Topic and type of a file's channel.
struct Channel {
    topic: String,
    schema: u16,
    is_cdr: bool,
}

/// Passes the messages of a bag (a rosbag2 folder or one MCAP file) in stored order to `see`, until
/// it returns `false`. Chunks may be compressed by lz4 or zstd. A truncated file, as from a killed
/// recorder, is read as far as possible; messages in another encoding than CDR are skipped. At most
/// one chunk is in memory at a time. Returns whether the files that were read to their ends are
/// whole.
///
/// # Errors
/// A path that is no bag, unreadable or damaged, or a bag without a message.
pub fn read(
    path: &Path,
    files: &FileAccess,
    see: &mut dyn FnMut(&ReadMessage) -> bool,
) -> Result<bool, BagReadError> {
    let (mut is_empty, mut is_whole) = (true, true);
    let see = &mut |message: &ReadMessage| {
        is_empty = false;
        see(message)
    };
    for file in parts(path, files)? {
        let opened = files.open(&file).map_err(|reason| BagReadError::Read {
            path: file.clone(),
            reason,
        })?;
        if !read_file(&file, opened, see, &mut is_whole)? {
            break;
        }
    }
    match is_empty {
        false => Ok(is_whole),
        true => Err(BagReadError::NotABag {
            path: path.to_owned(),
            what: "holds no message in CDR: it was cut short before the first, nothing was recorded, or only other encodings",
        }),
    }
}

/// Largest number of files visited in a bag's folder.
const MOST_FILES: usize = 100_000;

/// Returns the MCAP files of a bag, in order.
fn parts(path: &Path, access: &FileAccess) -> Result<Vec<PathBuf>, BagReadError> {
    let not_a_bag = |what| BagReadError::NotABag {
        path: path.to_owned(),
        what,
    };
    // An inaccessible folder is opened like a file, which is rejected.
    if !access.is_folder(path) {
        return Ok(vec![path.to_owned()]);
    }
    let names = access.names_in(path, MOST_FILES).into_iter();
    let mut files: Vec<PathBuf> = names.map(|name| path.join(name)).collect();
    let has = |ending: &str| {
        files
            .iter()
            .any(|file| file.extension().is_some_and(|e| e == ending))
    };
    if !has("mcap") {
        return Err(not_a_bag(if has("db3") {
            "is a bag in SQLite, and not in MCAP: `ros2 bag convert` makes one of it"
        } else if has("ilon-partial") {
            "was cut short: its run ended before the bag was whole. Rename its file without `.ilon-partial` to read what it holds"
        } else {
            "is a folder without an MCAP file"
        }));
    }
    files.retain(|file| file.extension().is_some_and(|e| e == "mcap"));
    // bag_10 comes after bag_9.
    files.sort_by_key(|file| {
        let name = file
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let digits = name.len() - name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let (stem, number) = name.split_at(name.len() - digits);
        (stem.to_owned(), number.parse::<u64>().unwrap_or(0))
    });
    Ok(files)
}

/// Returns whether to continue with the next file. A file without its footer is not whole.
fn read_file(
    path: &Path,
    mut file: File,
    see: &mut dyn FnMut(&ReadMessage) -> bool,
    is_whole: &mut bool,
) -> Result<bool, BagReadError> {
    let damaged = |reason: String| BagReadError::Damaged {
        path: path.to_owned(),
        reason,
    };
    let io_fault = |error: io::Error| BagReadError::Read {
        path: path.to_owned(),
        reason: error.into(),
    };
    let options = LinearReaderOptions::default()
        .with_emit_chunks(true)
        .with_skip_end_magic(true)
        .with_record_length_limit(RECORD_BYTES);
    let mut reader = LinearReader::new_with_options(options);
    let mut known = Channels::default();
    let mut has_footer = false;
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(bytes)) => {
                let read = file
                    .read(reader.insert(bytes.min(RECORD_BYTES)))
                    .map_err(io_fault)?;
                reader.notify_read(read);
            }
            Ok(LinearReadEvent::Record { data, opcode }) => {
                has_footer |= opcode == op::FOOTER;
                if !known.record(opcode, data, see).map_err(damaged)? {
                    return Ok(false);
                }
            }
            // The file is truncated.
            Err(McapError::UnexpectedEof) => break,
            Err(McapError::BadMagic) => {
                return Err(BagReadError::NotABag {
                    path: path.to_owned(),
                    what: "is no MCAP file",
                });
            }
            Err(error) => return Err(damaged(error.to_string())),
        }
    }
    *is_whole &= has_footer;
    Ok(true)
}

/// Takes the next record off a chunk: its opcode, and its bytes; `None` if it is cut short.
fn next_record<'b>(left: &mut &'b [u8]) -> Option<(u8, &'b [u8])> {
    let (opcode, rest) = left.split_first()?;
    let (length, rest) = rest.split_first_chunk()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    let (data, rest) = rest.split_at_checked(length)?;
    *left = rest;
    Some((*opcode, data))
}

/// Returns a record, and `None` for one that no message needs. Its texts have to end within it, for
/// the reader of records sets aside as much memory as their lengths say.
fn parsed(opcode: u8, data: &[u8]) -> Result<Option<Record<'_>>, String> {
    if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK) {
        return Ok(None);
    }
    check_texts(opcode, data).ok_or("a text is longer than its record")?;
    let record = mcap::parse_record(opcode, data);
    record.map(Some).map_err(|error| error.to_string())
}

/// Returns `None` if a text of a record does not end within it.
fn check_texts(opcode: u8, data: &[u8]) -> Option<()> {
    let after_text = |data: &[u8]| {
        let (length, rest) = data.split_first_chunk()?;
        let length = u32::from_le_bytes(*length) as usize;
        (length <= rest.len()).then_some(4 + length)
    };
    // What is before the texts, and their number.
    let (before, count) = match opcode {
        op::SCHEMA => (2, 2),
        op::CHANNEL => (4, 2),
        op::CHUNK => (28, 1),
        _ => return Some(()),
    };
    let mut rest = data.get(before..)?;
    for _ in 0..count {
        rest = &rest[after_text(rest)?..];
    }
    if opcode == op::CHANNEL {
        // A list of pairs of texts, after its length in bytes. Later versions may append more.
        let (length, list) = rest.split_first_chunk()?;
        rest = list.get(..u32::from_le_bytes(*length) as usize)?;
        while !rest.is_empty() {
            rest = &rest[after_text(rest)?..];
        }
    }
    Some(())
}

/// The channels of a file read so far.
#[derive(Default)]
struct Channels {
    schemas: HashMap<u16, String>,
    channels: HashMap<u16, Channel>,
}

impl Channels {
    /// Processes a record; returns whether to continue.
    fn record(
        &mut self,
        opcode: u8,
        data: &[u8],
        see: &mut dyn FnMut(&ReadMessage) -> bool,
    ) -> Result<bool, String> {
        let (header, data) = match parsed(opcode, data)? {
            Some(Record::Chunk { header, data }) => (header, data),
            Some(record) => return self.take(record, see),
            None => return Ok(true),
        };
        let unpacked = unpacked(&header.compression, header.uncompressed_size, &data)?;
        let mut left = unpacked.as_deref().unwrap_or(&data);
        while !left.is_empty() {
            let (opcode, data) = next_record(&mut left).ok_or("a chunk is cut short")?;
            if let Some(record) = parsed(opcode, data)?
                && !self.take(record, see)?
            {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Processes a record without inner records.
    fn take(
        &mut self,
        record: Record<'_>,
        see: &mut dyn FnMut(&ReadMessage) -> bool,
    ) -> Result<bool, String> {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let known = Channel {
                    topic: channel.topic,
                    schema: channel.schema_id,
                    is_cdr: channel.message_encoding == CDR,
                };
                self.channels.insert(channel.id, known);
            }
            Record::Message { header, data } => {
                let id = header.channel_id;
                let channel = self.channels.get(&id);
                let channel =
                    channel.ok_or_else(|| format!("a message of the unknown channel {id}"))?;
                let schema = self.schemas.get(&channel.schema);
                if let Some(type_name) = schema.filter(|_| channel.is_cdr) {
                    return Ok(see(&ReadMessage {
                        topic: &channel.topic,
                        type_name,
                        log_time_ns: header.log_time,
                        cdr: &data,
                    }));
                }
            }
            _ => {}
        }
        Ok(true)
    }
}

/// Returns the records of a compressed chunk; `None` if it is not compressed.
fn unpacked(compression: &str, bytes: u64, data: &[u8]) -> Result<Option<Vec<u8>>, String> {
    if compression.is_empty() {
        return Ok(None);
    }
    if bytes > RECORD_BYTES as u64 {
        return Err(format!(
            "a chunk of {bytes} bytes, where at most {RECORD_BYTES} are taken"
        ));
    }
    let mut whole = Vec::new();
    let read = match compression {
        "lz4" => lz4_flex::frame::FrameDecoder::new(data)
            .take(bytes)
            .read_to_end(&mut whole),
        "zstd" => {
            let decoder =
                ruzstd::decoding::StreamingDecoder::new(data).map_err(|error| error.to_string())?;
            decoder.take(bytes).read_to_end(&mut whole)
        }
        other => {
            return Err(format!(
                "its chunks are packed by \"{}\", which is not known here",
                one_line(other)
            ));
        }
    };
    read.map_err(|error| format!("a chunk cannot be unpacked: {error}"))?;
    if whole.len() as u64 != bytes {
        return Err(format!(
            "a chunk unpacks to {} bytes in place of {bytes}",
            whole.len()
        ));
    }
    Ok(Some(whole))
}

/// Returns a short text without line breaks.
fn one_line(text: &str) -> String {
    text.chars()
        .filter(|letter| !letter.is_control())
        .take(40)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A text as records have it, and how long it is said to be.
    fn text(said: u32, bytes: &[u8]) -> Vec<u8> {
        [&said.to_le_bytes()[..], bytes].concat()
    }

    /// No memory is set aside for what a length says and the record does not hold: neither in what
    /// a record begins with, nor in a pair at its end, nor in a record that is not needed.
    #[test]
    fn a_text_that_is_longer_than_its_record_is_refused() {
        let channel = |topic: u32, value: u32| {
            let pair = [text(1, b"k"), text(value, b"v")].concat();
            let before = [&[7, 0, 0, 0][..], &text(topic, b"/a"), &text(3, b"cdr")].concat();
            [before, text(pair.len() as u32, &pair)].concat()
        };
        let read = |data: &[u8]| parsed(op::CHANNEL, data).map(|record| record.is_some());
        assert_eq!(read(&channel(2, 1)), Ok(true));
        // What a later version appends is ignored.
        assert_eq!(read(&[channel(2, 1), vec![9; 4]].concat()), Ok(true));
        for damaged in [channel(u32::MAX, 1), channel(2, u32::MAX)] {
            let error = read(&damaged).expect_err("longer than the record");
            assert!(error.contains("longer than its record"), "{error}");
        }
        assert!(parsed(op::SCHEMA, &[1, 0, 255, 255, 255, 255]).is_err());
        assert!(parsed(op::CHUNK, &[255; 32]).is_err());
        let header = text(u32::MAX, b"ros2");
        let read = parsed(op::HEADER, &header).expect("nothing is read of it");
        assert!(read.is_none());
    }
}
