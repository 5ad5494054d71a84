//! Other nodes in the domain.

use std::collections::HashSet;

use ros2_client::Context;
use ros2_client::dds::rustdds::RTPSEntity;
use ros2_client::dds::rustdds::policy::Reliability;

use crate::mailbox::Mailbox;

/// Conflicts with other nodes in the domain, each reported once.
#[derive(Default)]
pub(super) struct Others {
    said: HashSet<String>,
}

impl Others {
    pub fn look(&mut self, context: &Context, namespace: &str, unstamped: bool, desk: &Mailbox) {
        let participant = context.domain_participant();
        let own = participant.guid().prefix;
        let twist_type = if unstamped { "Twist" } else { "TwistStamped" };
        for writer in participant.discovered_writers() {
            let data = &writer.publication_topic_data;
            let Some(topic) = data
                .topic_name
                .strip_prefix("rt")
                .and_then(|name| name.strip_prefix(namespace))
                .filter(|_| data.key.prefix != own)
            else {
                continue;
            };
            let type_name = data.type_name.replace("::dds_::", "::").replace("::", "/");
            let type_name = type_name.trim_end_matches('_');
            let wanted = match topic {
                "/cmd_vel" => format!("geometry_msgs/msg/{twist_type}"),
                "/robot_joint_commands" => "sensor_msgs/msg/JointState".to_owned(),
                "/wheel_commands" => "std_msgs/msg/Float64MultiArray".to_owned(),
                "/clock" => {
                    self.say(desk, format!("another node publishes {namespace}/clock: only one simulator can give the time there; in a namespace each has its own"));
                    continue;
                }
                _ => continue,
            };
            if type_name != wanted {
                self.say(desk, format!("{namespace}{topic} is published as {type_name}, which is not heard: it is taken as {wanted}"));
            } else if data.reliability == Some(Reliability::BestEffort) {
                self.say(desk, format!("{namespace}{topic} is published with best effort, which is not heard: publish it as reliable"));
            }
        }
    }

    fn say(&mut self, desk: &Mailbox, note: String) {
        if self.said.insert(note.clone()) {
            desk.say(note);
        }
    }
}
