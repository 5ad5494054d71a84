//! A live run as topics: those of a bag, except names that a live run uses for commands.

use ilon_formats::{describe, with_ros2_control};
use ilon_messages::topics::RunTopics;

use crate::session::Session;

/// Returns the topics of a session. Stamps and `/clock` never go back: they continue over every
/// return to the start. With the user's own controllers the frame `odom -> base_link`, which these
/// publish, is omitted, and the robot's URDF has the block by which the controller manager finds the
/// wheels.
pub(crate) fn live_topics(session: &Session, beside_controllers: bool) -> RunTopics {
    let robot = session.robot();
    let mut described = describe(robot, &session.header().urdf);
    if beside_controllers && let Some(whole) = with_ros2_control(robot, &described.urdf) {
        described.urdf = whole;
    }
    // A bag's command topics are a live run's inputs.
    let topics = RunTopics::new(robot, described, session.header())
        .with_command_topics(["/ilon/cmd_vel", "/ilon/wheel_commands"]);
    match beside_controllers {
        true => topics.without_odometry_frame(),
        false => topics,
    }
}
