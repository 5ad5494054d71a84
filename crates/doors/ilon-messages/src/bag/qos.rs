//! How a topic is delivered, which whoever plays the bag offers again.

/// How a topic is delivered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Qos {
    /// Whether lost messages are sent again.
    pub reliability: Reliability,
    /// Whether those who come late get earlier messages.
    pub durability: Durability,
    /// How many messages are kept.
    pub depth: usize,
}

/// Whether lost messages are sent again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reliability {
    /// They are.
    Reliable,
    /// They are not.
    BestEffort,
}

/// Whether those who come late get earlier messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Durability {
    /// They get those that are kept: for what is said once, such as `/tf_static` and `/robot_description`.
    TransientLocal,
    /// They do not.
    Volatile,
}

impl Qos {
    /// Lost messages are sent again; those who come late get none of before.
    pub const fn reliable(depth: usize) -> Self {
        Self {
            reliability: Reliability::Reliable,
            durability: Durability::Volatile,
            depth,
        }
    }

    /// Lost messages are lost; those who come late get none of before.
    pub const fn best_effort(depth: usize) -> Self {
        Self {
            reliability: Reliability::BestEffort,
            durability: Durability::Volatile,
            depth,
        }
    }

    /// Those who come late get the messages that are kept.
    pub const fn transient_local(self) -> Self {
        Self {
            durability: Durability::TransientLocal,
            ..self
        }
    }

    /// As bags hold it: YAML with the numbers of rmw, as they were before version 9 of the metadata.
    pub(super) fn to_yaml(self) -> String {
        const KEEP_LAST: u8 = 1;
        const AUTOMATIC: u8 = 1;
        // The longest time that ROS 2 knows, 2^63 - 1 ns: none is asked for.
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
