//! The interface of message sinks.

use crate::Message;
use crate::bag::{BagError, BagWriter, Qos};

/// A sink for the messages of topics: a bag, a middleware, a socket.
pub trait Outlet {
    /// The sink's error.
    type Error;

    /// Declares a topic with messages of type `M`.
    ///
    /// # Errors
    /// If the topic is not possible.
    fn declare<M: Message>(&mut self, topic: &str, qos: Qos) -> Result<(), Self::Error>;

    /// Sends a message of a declared topic, at a time in nanoseconds.
    ///
    /// # Errors
    /// If it cannot be delivered.
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
