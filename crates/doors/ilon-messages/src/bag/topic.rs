//! Topics of a bag: their names and message counts.

use crate::Description;

use super::Qos;

/// Longest name of a topic in ROS 2, in characters.
pub(super) const MAX_LENGTH: usize = 247;

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

/// Whether ROS 2 accepts it as the full name of a topic. Such names need no escapes in YAML.
pub(super) fn is_name(name: &str) -> bool {
    let is_part = |part: &str| {
        part.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
            && part
                .chars()
                .all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
    };
    name.len() <= MAX_LENGTH
        && name
            .strip_prefix('/')
            .is_some_and(|parts| parts.split('/').all(is_part))
}

#[cfg(test)]
mod tests {
    use super::{MAX_LENGTH, is_name};

    #[test]
    fn names_are_those_of_ros() {
        for name in [
            "/tf",
            "/ground_truth/odom",
            "/_hidden",
            "/wheels/front_left2/slip",
        ] {
            assert!(is_name(name), "{name}");
        }
        for name in [
            "",
            "/",
            "tf",
            "/tf/",
            "//tf",
            "/2tf",
            "/front left",
            "/a:b",
            "/ä",
            "/a\nb",
            "~/tf",
        ] {
            assert!(!is_name(name), "{name}");
        }
        assert!(is_name(&format!("/{}", "a".repeat(MAX_LENGTH - 1))));
        assert!(!is_name(&format!("/{}", "a".repeat(MAX_LENGTH))));
    }
}
