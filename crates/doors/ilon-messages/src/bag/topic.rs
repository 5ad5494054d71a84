//! Topics of a bag: their names and message counts.

use crate::Description;

use super::Qos;

/// A topic of a bag.
#[derive(Debug)]
pub(super) struct Topic {
    /// Number of its channel in the file.
    pub channel: u16,
    /// Description of its message type.
    pub description: &'static Description,
    pub qos: Qos,
    /// Number of messages written.
    pub count: u64,
}
