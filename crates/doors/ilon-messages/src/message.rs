//! What every message can do.

use crate::cdr::{CdrError, CdrReader, CdrWriter};
use crate::description::Description;
use crate::field::Field;

/// A message of ROS 2.
pub trait Message: Field {
    /// What it consists of.
    const DESCRIPTION: &'static Description;
    /// Its name, as in `geometry_msgs/msg/Twist`.
    const TYPE_NAME: &'static str = Self::DESCRIPTION.type_name;
    /// The hash of its fields and those of the messages within them (REP-2016), as in `RIHS01_9c45...`. Constants and default
    /// values do not count, so that it is the same in every distribution.
    const TYPE_HASH: &'static str = Self::DESCRIPTION.type_hash;

    /// The text of its definition, and those of the messages within it, as bags hold it (`ros2msg`).
    fn definition() -> String {
        Self::DESCRIPTION.definition()
    }

    /// Encodes it as little-endian CDR behind the header of four bytes.
    ///
    /// # Errors
    ///
    /// A string holds a NUL, or a string or sequence has 2^32 elements or more.
    fn encode(&self) -> Result<Vec<u8>, CdrError> {
        let mut bytes = Vec::new();
        self.encode_into(&mut bytes)?;
        Ok(bytes)
    }

    /// As [`Message::encode`], in place of what `bytes` held, so that one buffer serves many messages.
    ///
    /// # Errors
    ///
    /// As [`Message::encode`]; `bytes` then holds a part of the message.
    fn encode_into(&self, bytes: &mut Vec<u8>) -> Result<(), CdrError> {
        self.write(&mut CdrWriter::begin(bytes))
    }

    /// Decodes CDR of either byte order behind its header of four bytes. A few bytes may follow, as some writers leave them over.
    ///
    /// # Errors
    ///
    /// The bytes are not such a message, for which [`CdrError`] names the place. Whatever they are, the memory taken stays within a
    /// small multiple of their number.
    fn decode(bytes: &[u8]) -> Result<Self, CdrError> {
        let mut reader = CdrReader::begin(bytes)?;
        let message = Self::read(&mut reader)?;
        reader.end()?;
        Ok(message)
    }
}
