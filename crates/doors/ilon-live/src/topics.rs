//! A live run as topics: those of a bag, except names that a live run uses for commands.

use ilon_formats::{describe, with_ros2_control};
use ilon_messages::topics::{Outlet, RunTopics};
use ilon_messages::{Message, bag::Qos};

use crate::session::{Row, Session};

/// A bag's command topics are a live run's inputs: the resulting commands get other names.
const RENAMED: [(&str, &str); 2] = [
    ("/cmd_vel", "/ilon/cmd_vel"),
    ("/robot_joint_commands", "/ilon/wheel_commands"),
];

/// The topics of a session. Stamps and `/clock` never go back: they continue over every return to
/// the start.
#[derive(Clone, Debug)]
pub(crate) struct LiveTopics {
    topics: RunTopics,
}

impl LiveTopics {
    /// Returns the topics of a session. With the user's own controllers the frame `odom ->
    /// base_link`, which these publish, is omitted, and the robot's URDF has the block by which the
    /// controller manager finds the wheels.
    pub fn of(session: &Session, beside_controllers: bool) -> Self {
        let robot = session.robot();
        let mut described = describe(robot, &session.header().urdf);
        if beside_controllers && let Some(whole) = with_ros2_control(robot, &described.urdf) {
            described.urdf = whole;
        }
        let topics = RunTopics::new(robot, described, session.header());
        Self {
            topics: match beside_controllers {
                true => topics.without_odometry_frame(),
                false => topics,
            },
        }
    }

    /// Declares all topics.
    pub fn declare<O: Outlet>(&self, outlet: &mut O) -> Result<(), O::Error> {
        self.topics.declare(&mut Renamed(outlet))
    }

    /// Sends the latched messages.
    pub fn latched<O: Outlet>(&self, outlet: &mut O, t_s: f64) -> Result<(), O::Error> {
        self.topics.latched(&mut Renamed(outlet), t_s)
    }

    /// Sends a row.
    pub fn row<O: Outlet>(&mut self, row: Row<'_>, outlet: &mut O) -> Result<(), O::Error> {
        let outlet = &mut Renamed(outlet);
        self.topics
            .row(row.record, row.wheels, row.rollers_rad, outlet)
    }
}

/// An outlet with the names of a live run.
struct Renamed<'a, O>(&'a mut O);

fn renamed(topic: &str) -> &str {
    let known = RENAMED.iter().find(|(from, _)| *from == topic);
    known.map_or(topic, |(_, to)| to)
}

impl<O: Outlet> Outlet for Renamed<'_, O> {
    type Error = O::Error;

    fn declare<M: Message>(&mut self, topic: &str, qos: Qos) -> Result<(), O::Error> {
        self.0.declare::<M>(renamed(topic), qos)
    }

    fn send<M: Message>(&mut self, topic: &str, message: &M, time_ns: u64) -> Result<(), O::Error> {
        self.0.send(renamed(topic), message, time_ns)
    }
}
