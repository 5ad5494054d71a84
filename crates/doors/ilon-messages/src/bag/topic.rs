//! Topics: their names, and what has been written to them.

use crate::Description;

use super::Qos;

/// The most characters of a topic's name in ROS 2.
pub(super) const MAX_LENGTH: usize = 247;

/// A topic of a bag.
#[derive(Debug)]
pub(super) struct Topic {
    /// The number of its channel in the file.
    pub channel: u16,
    /// What its messages are.
    pub description: &'static Description,
    pub qos: Qos,
    /// How many messages have been written.
    pub count: u64,
}

/// Whether ROS 2 takes it for the full name of a topic. What it takes needs no escape in YAML.
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
