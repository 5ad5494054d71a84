//! A row of a run as topics: components, signs and frames of what is said of it.

use ilon_formats::LoadRobot;
use ilon_messages::bag::Qos;
use ilon_messages::geometry_msgs::{Vector3Stamped, WrenchStamped};
use ilon_messages::nav_msgs::Odometry;
use ilon_messages::topics::{Outlet, RunTopics};
use ilon_messages::visualization_msgs::MarkerArray;
use ilon_messages::{CdrError, Message};
use ilon_robot::{Pose, Robot, Twist};
use ilon_trace::{Header, Record, Truth, WheelSample};

const MECANUM4: &str = include_str!("../../../../assets/robots/mecanum4.urdf");

/// Keeps what is sent, as bytes under its topic.
#[derive(Default)]
struct Kept(Vec<(String, Vec<u8>)>);

impl Outlet for Kept {
    type Error = CdrError;

    fn declare<M: Message>(&mut self, _: &str, _: Qos) -> Result<(), CdrError> {
        Ok(())
    }

    fn send<M: Message>(&mut self, topic: &str, message: &M, _: u64) -> Result<(), CdrError> {
        self.0.push((topic.to_owned(), message.encode()?));
        Ok(())
    }
}

impl Kept {
    fn one<M: Message>(&self, topic: &str) -> M {
        let sent = self.0.iter().find(|(kept, _)| kept == topic);
        M::decode(&sent.expect("it was sent").1).expect("a message")
    }
}

/// A row of the robot that looks along y, with one force, one sliding velocity, and three twists that differ.
fn sent() -> Kept {
    let robot = Robot::from_urdf_str(MECANUM4, "mecanum4").expect("it loads");
    let run = Header {
        urdf: MECANUM4.to_owned(),
        ..Header::of_robot(&robot)
    };
    let record = Record {
        truth: Truth {
            pose: Pose {
                x_m: 1.0,
                y_m: 2.0,
                heading_rad: std::f64::consts::FRAC_PI_2,
            },
            ..Truth::default()
        },
        twist_ideal: Twist::new(0.1, 0.2, 0.3),
        twist_contact: Twist::new(0.4, 0.5, 0.6),
        ..Record::default()
    };
    let sample = WheelSample {
        touching: true,
        contact_x_m: 0.3,
        contact_y_m: 0.1,
        force_x_n: 3.0,
        force_y_n: -4.0,
        normal_force_n: 20.0,
        friction: 0.6,
        slip_x_m_s: 0.05,
        slip_y_m_s: 0.02,
        ..WheelSample::default()
    };
    let mut kept = Kept::default();
    let wheels = vec![sample; robot.wheels.len()];
    let mut topics = RunTopics::new(&robot, &run);
    topics.row(&record, &wheels, &[], &mut kept).expect("sent");
    kept
}

/// Forces and sliding velocities come along the body's axes, as they were recorded, each component under its own sign.
#[test]
fn forces_and_slip_of_a_wheel_are_along_the_bodys_axes() {
    let kept = sent();
    let names: Vec<&String> = kept.0.iter().map(|(topic, _)| topic).collect();
    let topic = |end: &str| {
        let found = names.iter().find(|name| name.ends_with(end));
        (*found.expect("a topic of a wheel")).clone()
    };
    let force: WrenchStamped = kept.one(&topic("/force"));
    let force = force.wrench.force;
    assert_eq!((force.x, force.y, force.z), (3.0, -4.0, 20.0));
    let slip: Vector3Stamped = kept.one(&topic("/slip"));
    assert_eq!((slip.vector.x, slip.vector.y), (0.05, 0.02));
}

/// Markers stand in the world: looking along y, ahead is y and left is -x.
#[test]
fn arrows_of_contacts_are_turned_with_the_robot() {
    let kept = sent();
    let markers: MarkerArray = kept.one("/contacts");
    let arrow = |ns: &str| {
        let marker = markers.markers.iter().find(|marker| marker.ns == ns);
        let points = &marker.expect("one of each wheel").points;
        let [from, to] = points[..] else {
            panic!("an arrow has two ends")
        };
        (from, [to.x - from.x, to.y - from.y, to.z - from.z])
    };
    let (foot, [x, y, z]) = arrow("force");
    // 0.3 ahead and 0.1 to the left of (1, 2).
    assert!((foot.x - 0.9).abs() < 1e-12 && (foot.y - 2.3).abs() < 1e-12);
    // (3, -4, 20) N in the body is (4, 3, 20) N in the world, in whatever length a newton has.
    let scale = z / 20.0;
    assert!(scale > 0.0);
    assert!((x - 4.0 * scale).abs() < 1e-12 && (y - 3.0 * scale).abs() < 1e-12);
    let (_, [x, y, _]) = arrow("slip");
    assert!((x + 0.02).abs() < 1e-12 && (y - 0.05).abs() < 1e-12);
}

/// What a robot reckons is the ideal kinematics' twist; the contact kinematics knows what no driver knows.
#[test]
fn odometry_reports_the_twist_of_the_ideal_kinematics() {
    let odom: Odometry = sent().one("/odom");
    let twist = odom.twist.twist;
    let twist = [twist.linear.x, twist.linear.y, twist.angular.z];
    assert_eq!(twist, [0.1, 0.2, 0.3]);
}
