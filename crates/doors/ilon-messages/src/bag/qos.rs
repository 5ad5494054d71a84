//! Quality of service of a topic, which players of the bag use again.

/// Quality of service of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Qos {
    /// Whether lost messages are sent again.
    pub reliability: Reliability,
    /// Whether late subscribers get earlier messages.
    pub durability: Durability,
    /// Number of messages kept.
    pub depth: usize,
}

/// Whether lost messages are sent again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reliability {
    /// Lost messages are sent again.
    Reliable,
    /// Lost messages are not sent again.
    BestEffort,
}

/// Whether late subscribers get earlier messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Durability {
    /// Late subscribers get the kept messages: for one-time topics such as `/tf_static` and
    /// `/robot_description`.
    TransientLocal,
    /// Late subscribers get no earlier messages.
    Volatile,
}

impl Qos {
    /// Lost messages are sent again; late subscribers get no earlier ones.
    pub const fn reliable(depth: usize) -> Self {
        Self {
            reliability: Reliability::Reliable,
            durability: Durability::Volatile,
            depth,
        }
    }

    /// Lost messages are not sent again; late subscribers get no earlier ones.
    pub const fn best_effort(depth: usize) -> Self {
        Self {
            reliability: Reliability::BestEffort,
            durability: Durability::Volatile,
            depth,
        }
    }

    /// Lets late subscribers get the kept messages.
    pub const fn transient_local(self) -> Self {
        Self {
            durability: Durability::TransientLocal,
            ..self
        }
    }

    /// Returns the form in bags: YAML with the numbers of rmw, as before version 9 of the metadata.
    pub(super) fn to_yaml(self) -> String {
        const KEEP_LAST: u8 = 1;
        const AUTOMATIC: u8 = 1;
        // The longest duration of ROS 2, 2^63 - 1 ns: no limit.
        const UNLIMITED: &str = "\n    sec: 9223372036\n    nsec: 854775807";
        let Self {
            reliability,
            durability,
            depth,
        } = self;
        let reliability = match reliability {
            Reliability::Reliable => 1,
            Reliability::BestEffort => 2,
        };
        let durability = match durability {
            Durability::TransientLocal => 1,
            Durability::Volatile => 2,
        };
        format!(
            "- history: {KEEP_LAST}\n  depth: {depth}\n  reliability: {reliability}\n  durability: {durability}\n  \
             deadline:{UNLIMITED}\n  lifespan:{UNLIMITED}\n  liveliness: {AUTOMATIC}\n  \
             liveliness_lease_duration:{UNLIMITED}\n  avoid_ros_namespace_conventions: false"
        )
    }
}
