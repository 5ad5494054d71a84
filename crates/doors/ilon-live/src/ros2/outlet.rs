//! Topics over DDS.

use std::collections::HashMap;

use ilon_messages::bag::{self, Durability, Reliability};
use ilon_messages::topics::Outlet;
use ilon_messages::{CdrError, Message};
use ros2_client::qos::{self, History, QosProfile, WhenFull};
use ros2_client::ros2::LogLevel;
use ros2_client::{Context, MessageTypeName, Node, Publisher, WriteError};
use serde::ser::{Serialize, SerializeTuple, Serializer};

use super::Ros2Error;

/// A message as in a bag: CDR without its header, which the middleware writes itself.
struct Encoded(Vec<u8>);

impl Serialize for Encoded {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // As a tuple, whose elements have no count before them.
        let mut bytes = serializer.serialize_tuple(self.0.len())?;
        self.0
            .iter()
            .try_for_each(|byte| bytes.serialize_element(byte))?;
        bytes.end()
    }
}

/// Size of the CDR header in bytes.
const HEADER: usize = 4;

/// `joint_state_topic_hardware_interface` reads joint states under this name, in addition to or
/// instead of `/joint_states`, which may belong to a broadcaster.
const STATES: (&str, &str) = ("/joint_states", "/robot_joint_states");

/// Publishers by topic.
pub(super) struct Topics {
    context: Context,
    node: Node,
    /// Before all names, such as `/robot1`.
    pub namespace: String,
    publishers: HashMap<String, Publisher<Encoded>>,
    /// Number of dropped messages: a reliable reader does not keep up.
    pub lost: u64,
    bytes: Vec<u8>,
    /// Topics published by others.
    left_to_others: &'static [&'static str],
}

impl Topics {
    pub fn new(
        context: Context,
        node: Node,
        namespace: &str,
        left_to_others: &'static [&'static str],
    ) -> Self {
        Self {
            context,
            node,
            namespace: namespace.to_owned(),
            publishers: HashMap::new(),
            lost: 0,
            bytes: Vec::new(),
            left_to_others,
        }
    }

    pub fn node(&mut self) -> &mut Node {
        &mut self.node
    }

    /// Publishes a message on `/rosout`.
    pub fn say(&self, note: &str) {
        ros2_client::rosout!(self.node, LogLevel::Warn, "{note}");
    }

    /// Creates a topic for messages of a type, under its DDS name in ROS 2.
    pub fn topic<M: Message>(
        &self,
        name: &str,
        qos: &QosProfile,
    ) -> Result<ros2_client::dds::rustdds::Topic, Ros2Error> {
        let type_name = MessageTypeName::new(M::DESCRIPTION.package, M::DESCRIPTION.name);
        self.context
            .create_topic(format!("rt{}{name}", self.namespace), type_name, qos)
            .map_err(|reason| Ros2Error::topic(name, reason))
    }
}

/// Converts the quality of service of a bag's topic. Without room a message is dropped instead of
/// delayed.
pub(super) fn profile(of: bag::Qos) -> QosProfile {
    let reliability = match of.reliability {
        Reliability::Reliable => qos::Reliability::Reliable {
            when_full: WhenFull::Fail,
        },
        Reliability::BestEffort => qos::Reliability::BestEffort,
    };
    let durability = match of.durability {
        Durability::TransientLocal => qos::Durability::TransientLocal,
        Durability::Volatile => qos::Durability::Volatile,
    };
    QosProfile::subscription_default()
        .reliability(reliability)
        .durability(durability)
        .history(History::KeepLast { depth: of.depth })
}

impl Outlet for Topics {
    type Error = Ros2Error;

    fn declare<M: Message>(&mut self, topic: &str, qos: bag::Qos) -> Result<(), Ros2Error> {
        if topic == STATES.0 {
            self.declare::<M>(STATES.1, qos)?;
        }
        if self.left_to_others.contains(&topic) {
            return Ok(());
        }
        let profile = profile(qos);
        let dds_topic = self.topic::<M>(topic, &profile)?;
        let publisher = self
            .node
            .create_publisher(&dds_topic, Some(profile))
            .map_err(|reason| Ros2Error::topic(topic, reason))?;
        self.publishers.insert(topic.to_owned(), publisher);
        Ok(())
    }

    fn send<M: Message>(
        &mut self,
        topic: &str,
        message: &M,
        time_ns: u64,
    ) -> Result<(), Ros2Error> {
        if topic == STATES.0 {
            self.send(STATES.1, message, time_ns)?;
        }
        let Some(publisher) = self.publishers.get(topic) else {
            return Ok(());
        };
        message
            .encode_into(&mut self.bytes)
            .map_err(|reason: CdrError| Ros2Error::topic(topic, reason))?;
        match publisher.publish(Encoded(self.bytes[HEADER..].to_vec())) {
            Ok(()) => Ok(()),
            Err(WriteError::WouldBlock { .. }) => {
                self.lost += 1;
                Ok(())
            }
            Err(other) => Err(Ros2Error::topic(topic, other)),
        }
    }
}
