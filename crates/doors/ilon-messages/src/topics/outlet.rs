//! Where messages go.

use crate::Message;
use crate::bag::{BagError, BagWriter, Qos};

/// What takes the messages of topics: a bag, a middleware, a socket.
pub trait Outlet {
    /// Why it cannot.
    type Error;

    /// Messages of type `M` will come on a topic.
    ///
    /// # Errors
    /// Where there can be no such topic.
    fn declare<M: Message>(&mut self, topic: &str, qos: Qos) -> Result<(), Self::Error>;

    /// A message of a declared topic, at a time in nanoseconds.
    ///
    /// # Errors
    /// Where it cannot be delivered.
    fn send<M: Message>(
        &mut self,
        topic: &str,
        message: &M,
        time_ns: u64,
    ) -> Result<(), Self::Error>;
}

impl Outlet for BagWriter {
    type Error = BagError;

    fn declare<M: Message>(&mut self, topic: &str, qos: Qos) -> Result<(), BagError> {
        Self::declare::<M>(self, topic, qos)
    }

    fn send<M: Message>(&mut self, topic: &str, message: &M, time_ns: u64) -> Result<(), BagError> {
        self.write(topic, message, time_ns)
    }
}
