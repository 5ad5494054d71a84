//! A row of a run as topics: components, signs and frames of the messages.

use ilon_formats::{
    Handedness, JointOptions, LoadOptions, LoadRobot, RoleOption, WheelOptions, describe,
};
use ilon_messages::bag::Qos;
use ilon_messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use ilon_messages::geometry_msgs::{Vector3Stamped, WrenchStamped};
use ilon_messages::nav_msgs::Odometry;
use ilon_messages::sensor_msgs::JointState;
use ilon_messages::tf2_msgs::TFMessage;
use ilon_messages::topics::{Outlet, RunTopics};
use ilon_messages::visualization_msgs::{Marker, MarkerArray};
use ilon_messages::{CdrError, Message};
use ilon_robot::{Pose, Robot, Twist};
use ilon_trace::ledger::Chain;
use ilon_trace::{Header, Record, Truth, WheelSample};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

const MECANUM4: &str = include_str!("../../../../../assets/robots/mecanum4.urdf");

/// Keeps the sent messages, as bytes by topic, and the declared topics.
#[derive(Default)]
struct Kept(Vec<(String, Vec<u8>)>, Vec<(String, Qos)>);

impl Outlet for Kept {
    type Error = CdrError;

    fn declare<M: Message>(&mut self, topic: &str, qos: Qos) -> Result<(), CdrError> {
        self.1.push((topic.to_owned(), qos));
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

/// A row of a robot that looks along y, with one force, one sliding velocity, and three different
/// twists.
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
    }
    .steady();
    let mut kept = Kept::default();
    let wheels = vec![sample; robot.wheels.len()];
    let mut topics = RunTopics::new(&robot, describe(&robot, &run.urdf), &run);
    topics.row(&record, &wheels, &[], &mut kept).expect("sent");
    kept
}

/// Forces and sliding velocities are along the body's axes, as recorded, each component with its
/// sign.
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

/// Markers are in the world frame: looking along y, ahead is y and left is -x.
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
    // (3, -4, 20) N in the body is (4, 3, 20) N in the world, at any length per newton.
    let scale = z / 20.0;
    assert!(scale > 0.0);
    assert!((x - 4.0 * scale).abs() < 1e-12 && (y - 3.0 * scale).abs() < 1e-12);
    let (_, [x, y, _]) = arrow("slip");
    assert!((x + 0.02).abs() < 1e-12 && (y - 0.05).abs() < 1e-12);
}

/// Odometry uses the twist of the ideal kinematics; a real robot does not know that of the contact
/// kinematics.
#[test]
fn odometry_reports_the_twist_of_the_ideal_kinematics() {
    let odom: Odometry = sent().one("/odom");
    let twist = odom.twist.twist;
    let twist = [twist.linear.x, twist.linear.y, twist.angular.z];
    assert_eq!(twist, [0.1, 0.2, 0.3]);
}

/// The markers of one wheel of a robot that looks along x.
fn markers_of(sample: WheelSample) -> (Robot, Vec<Marker>) {
    let robot = Robot::from_urdf_str(MECANUM4, "mecanum4").expect("it loads");
    let run = Header::of_robot(&robot);
    let mut kept = Kept::default();
    let wheels = vec![sample; robot.wheels.len()];
    let mut topics = RunTopics::new(&robot, describe(&robot, &run.urdf), &run);
    topics
        .row(&Record::default(), &wheels, &[], &mut kept)
        .expect("sent");
    let all: MarkerArray = kept.one("/contacts");
    assert_eq!(all.markers.len(), 3 * robot.wheels.len());
    let of_first = all.markers.into_iter().filter(|marker| marker.id == 0);
    (robot, of_first.collect())
}

/// A wheel with its share of the weight has an arrow of 2.5 of its radii; its cone has the same
/// height, is mu times as wide, and is closed.
#[test]
fn a_wheels_load_and_cone_are_drawn_in_its_radii() {
    let robot = Robot::from_urdf_str(MECANUM4, "mecanum4").expect("it loads");
    let radius_m = robot.wheels[0].radius_m;
    let load_n = robot.mass_kg() * 9.81 / robot.wheels.len() as f64;
    let (_, markers) = markers_of(
        WheelSample {
            touching: true,
            normal_force_n: load_n,
            force_x_n: 0.3 * load_n,
            friction: 0.6,
            // On a kerb of 1 cm.
            hub_height_m: radius_m + 0.01,
            ..WheelSample::default()
        }
        .steady(),
    );
    let [force, cone, _] = &markers[..] else {
        panic!("three of each wheel")
    };
    let height_m = 2.5 * radius_m;
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    assert!(near(force.points[0].z, 0.01), "{:?}", force.points[0]);
    assert!(near(force.points[1].z, 0.01 + height_m));
    assert!(near(force.points[1].x, 0.3 * height_m));
    assert!(near(force.scale.x, 0.1 * radius_m) && near(force.scale.y, 0.2 * radius_m));
    // Half of the friction limit: not the colour of sliding, which is redder than blue.
    assert!(force.color.b > force.color.r);

    // A line list: pairs of points. The rim's lines form a closed loop; four lines rise from the
    // tip.
    let flanks = cone.points.len() - 8;
    let (rim, flanks) = cone.points.split_at(flanks);
    for (index, line) in rim.chunks(2).enumerate() {
        for point in line {
            assert!(near(point.z, 0.01 + height_m));
            let radius = (point.x * point.x + point.y * point.y).sqrt();
            assert!(near(radius, 0.6 * height_m), "{radius}");
        }
        let next = rim[(2 * index + 2) % rim.len()];
        assert!(near(line[1].x, next.x) && near(line[1].y, next.y));
        // Each is a chord of a sixteenth of the circle.
        let chord = ((line[1].x - line[0].x).powi(2) + (line[1].y - line[0].y).powi(2)).sqrt();
        let sixteenth = 2.0 * 0.6 * height_m * (std::f64::consts::PI / 16.0).sin();
        assert!(near(chord, sixteenth), "{chord} {sixteenth}");
    }
    for line in flanks.chunks(2) {
        assert!(near(line[0].x, 0.0) && near(line[0].y, 0.0) && near(line[0].z, 0.01));
        assert!(near(line[1].z, 0.01 + height_m));
    }
}

/// Sliding contacts are red; for a wheel in the air nothing is drawn, and earlier markers are
/// deleted.
#[test]
fn contacts_that_slide_are_red_and_those_that_end_are_taken_away() {
    let pressed = WheelSample {
        touching: true,
        normal_force_n: 10.0,
        force_y_n: 6.0,
        friction: 0.6,
        ..WheelSample::default()
    }
    .steady();
    let (_, sliding) = markers_of(pressed);
    assert!(sliding[0].color.r > sliding[0].color.b);
    assert!(sliding.iter().all(|marker| marker.action == Marker::ADD));
    let (_, lifted) = markers_of(
        WheelSample {
            touching: false,
            ..pressed
        }
        .steady(),
    );
    assert!(
        lifted
            .iter()
            .all(|marker| marker.action == Marker::DELETE && marker.points.is_empty())
    );
}

/// Equal except for the six decimals that a status shows.
fn assert_relative(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-6, "{found} {expected}");
}

/// The value of a key of a status.
fn value(status: &DiagnosticStatus, key: &str) -> f64 {
    let found = status.values.iter().find(|value| value.key == key);
    let found = found.unwrap_or_else(|| panic!("{key} is not among {:?}", status.values));
    found.value.parse().expect("a number")
}

/// Two rows: means are over both, extremes are the larger, shares of time are halves; the final
/// summary is reported once.
#[test]
fn diagnostics_report_means_extremes_and_shares_of_the_rows_since_the_last() {
    let robot = Robot::from_urdf_str(MECANUM4, "mecanum4").expect("it loads");
    let run = Header {
        task_names: vec!["heading".to_owned(), "position".to_owned()],
        ..Header::of_robot(&robot)
    };
    let mut topics = RunTopics::new(&robot, describe(&robot, &run.urdf), &run);
    let mut kept = Kept::default();
    // 1 m/s ahead commanded; servo lag takes 0.1 m/s, rollers 0.2 m/s to the side, slip 0.3 m/s.
    let ahead = |vx: f64, vy: f64| Twist::new(vx, vy, 0.0);
    let mut record = Record {
        t_s: 0.25,
        command_twist_in_body: ahead(1.0, 0.0),
        granted_twist_in_body: ahead(1.0, 0.0),
        twist_target_ideal: ahead(1.0, 0.0),
        twist_ideal: ahead(0.9, 0.0),
        twist_contact: ahead(0.9, 0.2),
        contact_residual_m_s: 2e-3,
        odometry_ideal: Pose {
            x_m: 0.3,
            y_m: 0.4,
            heading_rad: 0.1,
        },
        ..Record::default()
    };
    record.truth.twist_in_body = ahead(0.6, 0.2);
    record.tasks[0].weight = 1.0;
    record.tasks[1].weight = 0.5;
    let mut sample = WheelSample {
        touching: true,
        normal_force_n: 20.0,
        force_x_n: 12.0,
        friction: 0.6,
        slip_x_m_s: 0.3,
        slip_y_m_s: 0.4,
        torque_n_m: -0.7,
        ..WheelSample::default()
    }
    .steady();
    let wheels = vec![sample; robot.wheels.len()];
    topics.row(&record, &wheels, &[], &mut kept).expect("sent");
    record.t_s = 0.5;
    record.contact_residual_m_s = 1e-3;
    record.tasks[1].weight = 1.0;
    sample.normal_force_n = 40.0;
    (sample.slip_x_m_s, sample.slip_y_m_s) = (0.0, 0.0);
    sample.torque_n_m = 0.2;
    sample = sample.steady();
    // Until here the shortfall is that of the end.
    let chain = Chain::held(&record, 0.25);
    record.ledger.count(&chain, [0.0; 2]);
    let wheels = vec![sample; robot.wheels.len()];
    topics.row(&record, &wheels, &[], &mut kept).expect("sent");
    assert!(kept.0.iter().all(|(topic, _)| topic != "/diagnostics"));
    topics.end(0.5, &mut kept).expect("sent");
    let report: DiagnosticArray = kept.one("/diagnostics");
    let status = |name: &str| {
        let found = report.status.iter().find(|status| status.name == name);
        found.unwrap_or_else(|| panic!("no {name}"))
    };

    let budget = status("ilon/error budget");
    assert_relative(value(budget, "servo vx, m/s"), 0.1);
    assert_relative(value(budget, "geometry vy, m/s"), -0.2);
    assert_relative(value(budget, "slip vx, m/s"), 0.3);
    assert_relative(value(budget, "total vx, m/s"), 0.4);
    assert_eq!(value(budget, "contact residual, m/s"), 2e-3);
    assert!(
        budget
            .message
            .ends_with("the largest part is slip, 300.0 mm/s"),
        "{}",
        budget.message
    );
    let odometry = status("ilon/odometry");
    assert_eq!(value(odometry, "dead reckoning position error, m"), 0.5);
    assert_eq!(value(odometry, "dead reckoning heading error, rad"), 0.1);

    let guidance = status("ilon/guidance");
    assert_eq!(guidance.level, DiagnosticStatus::WARN);
    assert_eq!(
        guidance.message,
        "the position task was saturated for 50 % of the time"
    );

    let name = format!("ilon/wheels/{}", robot.wheels[0].name);
    let wheel = status(&name);
    assert_eq!(value(wheel, "load, N"), 30.0);
    // Of 0.5 m/s and none.
    assert_eq!(value(wheel, "sliding speed rms, m/s"), 0.353553);
    assert_eq!(value(wheel, "friction used, largest share"), 1.0);
    assert_eq!(value(wheel, "torque, largest, N m"), 0.7);
    assert_eq!(value(wheel, "in the air, share of time"), 0.0);
    assert_eq!(value(wheel, "at its grip limit, share of time"), 0.5);
    assert_eq!(wheel.message, "at its grip limit for 50 % of the time");
    assert_eq!(wheel.level, DiagnosticStatus::WARN);
}

/// The frames of a row with wheels and rollers at an angle, with rollers sampled in every row or in
/// none.
fn frames_at(angle_rad: f64, rollers_are_taken: bool) -> (RunTopics, Kept) {
    let robot = Robot::from_urdf_str(MECANUM4, "mecanum4").expect("it loads");
    let run = Header {
        roller_angles: true,
        ..Header::of_robot(&robot)
    };
    let sample = WheelSample {
        angle_rad,
        ..WheelSample::default()
    }
    .steady();
    let wheels = vec![sample; robot.wheels.len()];
    let count = robot.wheels.iter().map(|wheel| wheel.rollers.len()).sum();
    let rollers_rad = vec![rollers_are_taken.then_some(angle_rad); count];
    let mut kept = Kept::default();
    let mut topics = RunTopics::new(&robot, describe(&robot, &run.urdf), &run);
    topics
        .row(&Record::default(), &wheels, &rollers_rad, &mut kept)
        .expect("sent");
    (topics, kept)
}

/// The rotation of a frame in its parent.
fn turned(frames: &TFMessage, child: &str) -> UnitQuaternion<f64> {
    let mut all = frames.transforms.iter();
    let found = all.find(|frame| frame.child_frame_id == child);
    let q = found.expect("it has a frame").transform.rotation;
    UnitQuaternion::from_quaternion(Quaternion::new(q.w, q.x, q.y, q.z))
}

/// A wheel with a positive angle has rolled ahead: its top has moved along x. A roller has turned
/// by its own angle about the axis of its frame.
#[test]
fn frames_of_wheels_and_rollers_turn_by_their_angles() {
    let (topics, kept) = frames_at(0.3, true);
    let (_, at_rest) = frames_at(0.0, true);
    let (now, before): (TFMessage, TFMessage) = (kept.one("/tf"), at_rest.one("/tf"));
    for wheel in &topics.frames().wheels {
        let turn = turned(&now, &wheel.child) * turned(&before, &wheel.child).inverse();
        let top = turn * Vector3::z();
        assert!((top.x - 0.3_f64.sin()).abs() < 1e-9, "{top}");
        assert!((top.z - 0.3_f64.cos()).abs() < 1e-9, "{top}");
    }
    let rollers = &topics.frames().rollers;
    // Every frame once: dead reckoning, truth, wheels, rollers.
    let wheels = topics.frames().wheels.len();
    assert_eq!(now.transforms.len(), 2 + wheels + rollers.len());
    for roller in rollers {
        let turn = turned(&before, &roller.child).inverse() * turned(&now, &roller.child);
        let about = turn.scaled_axis();
        assert!(
            (about - Vector3::new(0.0, 0.0, 0.3)).norm() < 1e-9,
            "{about}"
        );
    }
}

/// Rollers are sampled in fewer rows than all else: a row without them has only the other frames.
/// If dead reckoning is published elsewhere, it is left out.
#[test]
fn a_row_without_rollers_has_the_other_frames_alone() {
    let (topics, kept) = frames_at(0.3, false);
    let frames: TFMessage = kept.one("/tf");
    let children: Vec<&str> = frames
        .transforms
        .iter()
        .map(|frame| frame.child_frame_id.as_str())
        .collect();
    let wheels = topics.frames().wheels.iter();
    let wheels: Vec<String> = wheels.map(|wheel| wheel.child.clone()).collect();
    assert_eq!(children[0], topics.frames().base);
    assert_eq!(children[2..], wheels[..]);

    let mut kept = Kept::default();
    let sample = WheelSample {
        angle_rad: 0.3,
        ..WheelSample::default()
    }
    .steady();
    topics
        .without_odometry_frame()
        .row(
            &Record::default(),
            &vec![sample; wheels.len()],
            &[],
            &mut kept,
        )
        .expect("sent");
    let without: TFMessage = kept.one("/tf");
    assert_eq!(without.transforms, frames.transforms[1..]);
}

/// Without roller angles, their frames are static in `/tf_static`; moving links are not there too.
#[test]
fn a_frame_is_either_latched_or_sent_with_the_rows() {
    let robot = Robot::from_urdf_str(MECANUM4, "mecanum4").expect("it loads");
    let children = |roller_angles: bool| {
        let run = Header {
            roller_angles,
            ..Header::of_robot(&robot)
        };
        let mut topics = RunTopics::new(&robot, describe(&robot, &run.urdf), &run);
        let mut kept = Kept::default();
        topics.latched(&mut kept, 0.0).expect("sent");
        let wheels = vec![WheelSample::default(); robot.wheels.len()];
        let count = robot.wheels.iter().map(|wheel| wheel.rollers.len()).sum();
        let rollers_rad = vec![roller_angles.then_some(0.0); count];
        topics
            .row(&Record::default(), &wheels, &rollers_rad, &mut kept)
            .expect("sent");
        let mut children: Vec<String> = ["/tf_static", "/tf"]
            .iter()
            .flat_map(|topic| kept.one::<TFMessage>(topic).transforms)
            .map(|frame| frame.child_frame_id)
            .collect();
        children.sort();
        children
    };
    let (followed, latched) = (children(true), children(false));
    assert_eq!(followed, latched);
    let mut once = followed.clone();
    once.dedup();
    assert_eq!(once, followed);
}

/// Messages sent once are latched for late subscribers, one per topic; messages of every row are
/// not.
#[test]
fn topics_are_declared_before_they_are_sent_and_latched_where_they_are_said_once() {
    let robot = Robot::from_urdf_str(MECANUM4, "mecanum4").expect("it loads");
    let mut topics = RunTopics::new(&robot, describe(&robot, ""), &Header::of_robot(&robot));
    let mut kept = Kept::default();
    topics.declare(&mut kept).expect("declared");
    topics.latched(&mut kept, 0.0).expect("sent");
    let once: Vec<String> = kept.0.iter().map(|(topic, _)| topic.clone()).collect();
    assert_eq!(once, ["/robot_description", "/tf_static"]);
    let wheels = vec![WheelSample::default(); robot.wheels.len()];
    topics
        .row(&Record::default(), &wheels, &[], &mut kept)
        .expect("sent");
    for (topic, _) in &kept.0 {
        let declared = kept.1.iter().find(|(declared, _)| declared == topic);
        let (_, qos) = declared.unwrap_or_else(|| panic!("{topic} was not declared"));
        assert_eq!(
            *qos == Qos::reliable(1).transient_local(),
            once.contains(topic),
            "{topic} {qos:?}"
        );
    }
}

/// A joint between bodies moves its link on `/tf` and is in `/joint_states`, after the wheels.
#[test]
fn a_joint_between_bodies_is_in_tf_and_joint_states() {
    let text = include_str!("../../../../../assets/robots/mecanum4_arm.urdf");
    let mut options = LoadOptions::default();
    options.wheels = Some(WheelOptions::new(9, Handedness::XDeg(45.0)));
    for name in ["arm", "lift"] {
        let driven = JointOptions {
            role: Some(RoleOption::Driven),
            ..JointOptions::default()
        };
        options.joints.insert(name.to_owned(), driven);
    }
    let loaded = Robot::from_urdf_str_with(text, "arm", &options).expect("it loads");
    let robot = loaded.robot;
    let run = Header {
        urdf: text.to_owned(),
        ..Header::of_robot(&robot)
    };
    let mut record = Record::default();
    for (joint, position) in record.joints.iter_mut().zip([0.3, 0.5]) {
        (joint.position, joint.rate, joint.force) = (position, 2.0, 7.0);
    }
    let mut kept = Kept::default();
    let mut topics = RunTopics::new(&robot, describe(&robot, &run.urdf), &run);
    let wheels = vec![WheelSample::default(); robot.wheels.len()];
    topics.row(&record, &wheels, &[], &mut kept).expect("sent");
    let tf: TFMessage = kept.one("/tf");
    let of = |child: &str| {
        let mut all = tf.transforms.iter();
        let found = all.find(|frame| frame.child_frame_id == child);
        let found = found.expect(child);
        (found.header.frame_id.as_str(), &found.transform)
    };
    let (parent, at) = of("carriage");
    assert_eq!((parent, at.translation.z), ("base_link", 0.15 + 0.3));
    let (parent, at) = of("arm_link");
    assert_eq!(parent, "carriage");
    assert!((at.translation.z - 0.06).abs() < 1e-12);
    assert!((2.0 * at.rotation.z.asin() - 0.5).abs() < 1e-12, "{at:?}");
    let states: JointState = kept.one("/joint_states");
    assert_eq!(states.name[4..], ["lift", "arm"]);
    assert_eq!(states.position[4..], [0.3, 0.5]);
    assert_eq!((states.velocity[5], states.effort[5]), (2.0, 7.0));
    // Only wheels have commands.
    let commands: JointState = kept.one("/robot_joint_commands");
    assert_eq!(commands.name.len(), 4);
}
