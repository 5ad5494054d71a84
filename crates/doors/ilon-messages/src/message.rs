//! The interface of all messages.

use crate::cdr::{CdrError, CdrReader, CdrWriter};
use crate::description::Description;
use crate::field::Field;

/// A message of ROS 2.
pub trait Message: Field {
    /// Its name, constants and fields.
    const DESCRIPTION: &'static Description;
    /// Its name, such as `geometry_msgs/msg/Twist`.
    const TYPE_NAME: &'static str = Self::DESCRIPTION.type_name;
    /// The hash of its fields and those of nested messages (REP-2016), such as `RIHS01_9c45...`.
    /// Constants and default values do not count, so it is the same in every distribution.
    const TYPE_HASH: &'static str = Self::DESCRIPTION.type_hash;

    /// Returns the text of its definition, and those of nested messages, in the format of bags
    /// (`ros2msg`).
    fn definition() -> String {
        Self::DESCRIPTION.definition()
    }

    /// Encodes it as little-endian CDR after the header of four bytes.
    ///
    /// # Errors
    ///
    /// A string contains a NUL, or a string or sequence has 2^32 elements or more.
    fn encode(&self) -> Result<Vec<u8>, CdrError> {
        let mut bytes = Vec::new();
        self.encode_into(&mut bytes)?;
        Ok(bytes)
    }

    /// Like [`Message::encode`], replacing the content of `bytes`, so that one buffer serves many
    /// messages.
    ///
    /// # Errors
    ///
    /// Those of [`Message::encode`]; `bytes` then contains a part of the message.
    fn encode_into(&self, bytes: &mut Vec<u8>) -> Result<(), CdrError> {
        self.write(&mut CdrWriter::begin(bytes))
    }

    /// Decodes CDR of either byte order after its header of four bytes. A few bytes of padding may
    /// follow.
    ///
    /// # Errors
    ///
    /// The bytes are not such a message; [`CdrError`] has the position. For any input the memory
    /// used stays within a small multiple of its size.
    fn decode(bytes: &[u8]) -> Result<Self, CdrError> {
        let mut reader = CdrReader::begin(bytes)?;
        let message = Self::read(&mut reader)?;
        reader.end()?;
        Ok(message)
    }
}
