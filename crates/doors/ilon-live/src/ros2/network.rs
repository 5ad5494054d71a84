//! The DDS domain and networks, from ROS 2's environment variables.

use std::net::{IpAddr, Ipv4Addr};

/// The domain and networks of a node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Network {
    /// `ROS_DOMAIN_ID`; by default 0.
    pub domain: u16,
    /// Whether only this machine is used instead of all its networks.
    pub only_this_machine: bool,
    /// Ignored environment settings, as text.
    pub remarks: Vec<String>,
}

/// An invalid environment variable.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{variable} is `{value}`, but can only be {range}")]
pub struct BadVariable {
    /// Its name.
    pub variable: &'static str,
    /// Its value.
    pub value: String,
    /// The allowed range.
    pub range: &'static str,
}

/// The largest domain for which there are ports: RTPS 2.5, section 9.6.2.
const MOST_DOMAIN: u16 = 232;

impl Network {
    /// Reads the variables through `get`. Without `ROS_AUTOMATIC_DISCOVERY_RANGE` and
    /// `ROS_LOCALHOST_ONLY` only this machine is used: driving a robot from other machines needs an
    /// explicit setting.
    ///
    /// # Errors
    /// [`BadVariable`].
    pub fn from_variables(get: impl Fn(&str) -> Option<String>) -> Result<Self, BadVariable> {
        let given = |name: &str| {
            get(name)
                .map(|text| text.trim().to_owned())
                .filter(|text| !text.is_empty())
        };
        let mut remarks = Vec::new();
        let domain = match given("ROS_DOMAIN_ID") {
            None => 0,
            Some(value) => value
                .parse()
                .ok()
                .filter(|domain| *domain <= MOST_DOMAIN)
                .ok_or(BadVariable {
                    variable: "ROS_DOMAIN_ID",
                    value,
                    range: "a whole number from 0 to 232",
                })?,
        };
        let only = match given("ROS_LOCALHOST_ONLY").as_deref() {
            None => None,
            Some("0") => Some(false),
            Some("1") => Some(true),
            Some(other) => {
                return Err(BadVariable {
                    variable: "ROS_LOCALHOST_ONLY",
                    value: other.to_owned(),
                    range: "0 or 1",
                });
            }
        };
        let range = given("ROS_AUTOMATIC_DISCOVERY_RANGE");
        let of_range = match range.as_deref().map(str::to_ascii_uppercase).as_deref() {
            None => None,
            Some("LOCALHOST") => Some(true),
            Some("SUBNET" | "SYSTEM_DEFAULT") => Some(false),
            Some(_) => {
                return Err(BadVariable {
                    variable: "ROS_AUTOMATIC_DISCOVERY_RANGE",
                    value: range.unwrap_or_default(),
                    range: "LOCALHOST, SUBNET or SYSTEM_DEFAULT for a node that is to be found",
                });
            }
        };
        // As in rmw: ROS_LOCALHOST_ONLY=1 takes precedence.
        let only_this_machine = match (only, of_range) {
            (Some(true), _) => true,
            (_, Some(of_range)) => of_range,
            (Some(false), None) => false,
            (None, None) => true,
        };
        if let Some(peers) = given("ROS_STATIC_PEERS") {
            remarks.push(format!("ROS_STATIC_PEERS ({peers}) is not followed: peers are found by multicast, and on this machine"));
        }
        if let Some(name) = given("RMW_IMPLEMENTATION").filter(|name| name.contains("zenoh")) {
            remarks.push(format!("RMW_IMPLEMENTATION is {name}, but this node speaks DDS: nodes over zenoh do not see it"));
        }
        Ok(Self {
            domain,
            only_this_machine,
            remarks,
        })
    }

    /// The used interfaces; `None` for all.
    pub(super) fn only(&self) -> Option<[IpAddr; 1]> {
        self.only_this_machine
            .then_some([IpAddr::V4(Ipv4Addr::LOCALHOST)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn network(variables: &[(&str, &str)]) -> Result<Network, BadVariable> {
        Network::from_variables(|name| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn only_this_machine_unless_more_is_asked_for() {
        let cases: [(&[(&str, &str)], bool); 7] = [
            (&[], true),
            (&[("ROS_LOCALHOST_ONLY", "1")], true),
            (&[("ROS_LOCALHOST_ONLY", "0")], false),
            (&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")], false),
            (&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "localhost")], true),
            (
                &[
                    ("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"),
                    ("ROS_LOCALHOST_ONLY", "1"),
                ],
                true,
            ),
            (
                &[
                    ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"),
                    ("ROS_LOCALHOST_ONLY", "0"),
                ],
                true,
            ),
        ];
        for (variables, expected) in cases {
            let network = network(variables).expect("a network");
            assert_eq!(network.only_this_machine, expected, "{variables:?}");
            assert_eq!(network.domain, 0);
        }
    }

    #[test]
    fn what_makes_no_sense_is_said() {
        for (variable, value) in [
            ("ROS_DOMAIN_ID", "233"),
            ("ROS_DOMAIN_ID", "-1"),
            ("ROS_DOMAIN_ID", "three"),
            ("ROS_LOCALHOST_ONLY", "yes"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"),
        ] {
            let error = network(&[(variable, value)])
                .expect_err("refused")
                .to_string();
            assert!(error.contains(variable) && error.contains(value), "{error}");
        }
        assert_eq!(
            network(&[("ROS_DOMAIN_ID", " 42 ")])
                .expect("a network")
                .domain,
            42
        );
        let remarks = network(&[
            ("ROS_STATIC_PEERS", "10.0.0.1"),
            ("RMW_IMPLEMENTATION", "rmw_zenoh_cpp"),
        ]);
        assert_eq!(remarks.expect("a network").remarks.len(), 2);
    }
}
