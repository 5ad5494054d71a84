//! Writing of bags, message by message.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use mcap::records::{MessageHeader, Metadata as McapMetadata};
use mcap::{WriteOptions, Writer};

use crate::Message;

use super::files::{FILE, FILES, METADATA, UNFINISHED_FILE, UNFINISHED_METADATA, remove_if_there};
use super::metadata::Metadata;
use super::topic::Topic;
use super::{BagError, Qos};

/// A chunk ends at this number of bytes, or at this duration, in ns: the largest loss of a killed
/// writer, and the amount a player reads for a single moment.
const CHUNK_BYTES: usize = 1 << 20;
const CHUNK_NANOSECONDS: u64 = 1_000_000_000;

/// The library name in the file.
pub(super) const LIBRARY: &str = concat!("ilon ", env!("CARGO_PKG_VERSION"));

/// Writes a bag message by message: the file grows by whole chunks, each of which stays readable
/// whatever happens later.
///
/// A bag is complete after [`BagWriter::finish`]; until then its file is called
/// `bag_0.mcap.ilon-partial`. A writer dropped before that leaves a complete file with that name,
/// without `metadata.yaml` (`ros2 bag reindex` creates one); a killed process leaves a file without
/// index, which readers must scan from its start.
pub struct BagWriter {
    folder: PathBuf,
    mcap: Writer<BufWriter<File>>,
    topics: BTreeMap<String, Topic>,
    /// The first and last time of a message, in ns.
    span: Option<(u64, u64)>,
    chunk: Option<Chunk>,
    /// Buffer for the current encoded message.
    encoded: Vec<u8>,
}

/// The chunk being filled.
struct Chunk {
    bytes: usize,
    start_ns: u64,
}

impl BagWriter {
    /// Starts a bag in a folder, which is created if missing. An existing bag is replaced. No other
    /// writer may use the folder meanwhile.
    ///
    /// Its messages are in the file `bag_0.mcap`.
    ///
    /// # Errors
    ///
    /// The folder or its files cannot be created.
    pub fn create(folder: &Path) -> Result<Self, BagError> {
        fs::create_dir_all(folder).map_err(BagError::io(folder))?;
        for older in FILES {
            remove_if_there(&folder.join(older))?;
        }
        let path = folder.join(UNFINISHED_FILE);
        let growing = File::create(&path).map_err(BagError::io(&path))?;
        let mcap = WriteOptions::new()
            .profile("ros2")
            .library(LIBRARY)
            .compression(None)
            // Chunks are ended here, and written only when complete.
            .chunk_size(None)
            .disable_seeking(true)
            .create(BufWriter::new(growing))
            .map_err(BagError::mcap(&path))?;
        Ok(Self {
            folder: folder.into(),
            mcap,
            topics: BTreeMap::new(),
            span: None,
            chunk: None,
            encoded: Vec::new(),
        })
    }

    /// Declares a topic with messages of type `M`, once, under a full name that ROS 2 accepts.
    ///
    /// # Errors
    ///
    /// The file cannot be written.
    pub fn declare<M: Message>(&mut self, topic: &str, qos: Qos) -> Result<(), BagError> {
        let metadata = BTreeMap::from([
            ("offered_qos_profiles".into(), qos.to_yaml()),
            ("topic_type_hash".into(), M::TYPE_HASH.into()),
        ]);
        let channel = self
            .mcap
            .add_schema(M::TYPE_NAME, "ros2msg", M::definition().as_bytes())
            .and_then(|schema| self.mcap.add_channel(schema, topic, "cdr", &metadata))
            .map_err(BagError::mcap(&self.path()))?;
        self.topics.insert(
            topic.into(),
            Topic {
                channel,
                description: M::DESCRIPTION,
                qos,
                count: 0,
            },
        );
        Ok(())
    }

    /// Writes a message to a topic, at a time of at most 63 bits. Times may have any order, but
    /// increasing times make files small and quick to read.
    ///
    /// tf2 interprets a stamp of zero as "the latest": start a simulation's clock above it.
    ///
    /// # Errors
    ///
    /// The topic is not declared for such messages, the message cannot be encoded, or the file
    /// cannot be written.
    pub fn write<M: Message>(
        &mut self,
        topic: &str,
        message: &M,
        log_time_ns: u64,
    ) -> Result<(), BagError> {
        let Some(known) = self
            .topics
            .get_mut(topic)
            .filter(|known| known.description.type_name == M::TYPE_NAME)
        else {
            return Err(BagError::NotDeclared {
                topic: topic.into(),
                type_name: M::TYPE_NAME,
            });
        };
        message
            .encode_into(&mut self.encoded)
            .map_err(|source| BagError::Message {
                topic: topic.into(),
                source,
            })?;
        let header = MessageHeader {
            channel_id: known.channel,
            // It wraps around, because the format has 32 bits for it.
            sequence: known.count as u32,
            log_time: log_time_ns,
            publish_time: log_time_ns,
        };
        known.count += 1;
        let written = self.mcap.write_to_known_channel(&header, &self.encoded);
        written.map_err(|error| BagError::mcap(&self.path())(error))?;
        let (first, last) = self.span.unwrap_or((log_time_ns, log_time_ns));
        self.span = Some((first.min(log_time_ns), last.max(log_time_ns)));
        let chunk = self.chunk.get_or_insert(Chunk {
            bytes: 0,
            start_ns: log_time_ns,
        });
        chunk.bytes += self.encoded.len();
        if chunk.bytes >= CHUNK_BYTES || log_time_ns.abs_diff(chunk.start_ns) >= CHUNK_NANOSECONDS {
            self.flush()?;
        }
        Ok(())
    }

    /// Writes all messages so far to the file.
    ///
    /// # Errors
    ///
    /// The file cannot be written.
    pub fn flush(&mut self) -> Result<(), BagError> {
        self.chunk = None;
        self.mcap.flush().map_err(BagError::mcap(&self.path()))
    }

    /// Completes the bag: writes its index and its `metadata.yaml`, and syncs them to the disk.
    ///
    /// # Errors
    ///
    /// The files cannot be written.
    pub fn finish(mut self) -> Result<(), BagError> {
        let path = self.path();
        let about = Metadata {
            file: FILE,
            span: self.span,
            topics: &self.topics,
        };
        let within = McapMetadata {
            name: "rosbag2".into(),
            metadata: BTreeMap::from([("serialized_metadata".into(), about.to_yaml())]),
        };
        self.mcap
            .write_metadata(&within)
            .map_err(BagError::mcap(&path))?;
        self.mcap.finish().map_err(BagError::mcap(&path))?;
        let metadata = about.to_file();
        let file = self
            .mcap
            .into_inner()
            .into_inner()
            .map_err(|error| BagError::io(&path)(error.into_error()))?;
        file.sync_all().map_err(BagError::io(&path))?;
        fs::rename(&path, self.folder.join(FILE)).map_err(BagError::io(&path))?;
        write_metadata(&self.folder, &metadata).map_err(BagError::io(&self.folder.join(METADATA)))
    }

    fn path(&self) -> PathBuf {
        self.folder.join(UNFINISHED_FILE)
    }
}

impl std::fmt::Debug for BagWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("BagWriter")
            .field("path", &self.path())
            .field("topics", &self.topics)
            .finish_non_exhaustive()
    }
}

/// Writes `metadata.yaml` atomically.
fn write_metadata(folder: &Path, text: &str) -> io::Result<()> {
    let unfinished = folder.join(UNFINISHED_METADATA);
    fs::write(&unfinished, text)?;
    File::open(&unfinished)?.sync_all()?;
    fs::rename(&unfinished, folder.join(METADATA))
}
