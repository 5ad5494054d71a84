//! Converts a run to messages, row by row.

use std::collections::HashSet;

use ilon_robot::{Pose, Robot, RobotDescription, Twist};
use ilon_trace::{Header as RunHeader, ImuSample, ImuVariances, JointSample, Record, WheelSample};
use nalgebra::{Isometry3, UnitQuaternion};

use super::contacts::{Contacts, MARKER_RATE_HZ};
use super::convert::{isometry, pose, stamp, time_ns, transform, twist};
use super::diagnostics::Window;
use super::frames::Frames;
use super::outlet::Outlet;
use crate::bag::Qos;
use crate::builtin_interfaces::Time;
use crate::diagnostic_msgs::DiagnosticArray;
use crate::geometry_msgs::{
    Covariance, PoseStamped, TransformStamped, TwistStamped, Vector3, Vector3Stamped, WrenchStamped,
};
use crate::nav_msgs::Odometry;
use crate::rosgraph_msgs::Clock;
use crate::sensor_msgs::{Imu, JointState};
use crate::std_msgs::{Header, String as Text};
use crate::tf2_msgs::TFMessage;
use crate::visualization_msgs::MarkerArray;

/// Period of diagnostics, in seconds of simulated time.
const DIAGNOSTICS_EVERY_S: f64 = 1.0;

/// The variance of an unknown quantity, in m^2 or rad^2.
const UNKNOWN: f64 = 1e6;
/// Variances of x, y, z, roll, pitch and yaw, in m^2 and rad^2, published for dead reckoning if a
/// row has no covariance; z, roll and pitch are unknown. They have the magnitude published by
/// drivers of such robots.
const RECKONED: [f64; 6] = [1e-3, 1e-3, UNKNOWN, UNKNOWN, UNKNOWN, 1e-2];
/// Smallest published variance of odometry and IMU: filters do not accept zero.
const LEAST: f64 = 1e-8;
/// Published variances of the true pose. Filters do not accept zero.
const TRUE: [f64; 6] = [1e-12; 6];

/// A run as topics; see the [module](super).
#[derive(Clone, Debug)]
pub struct RunTopics {
    description: String,
    frames: Frames,
    world: String,
    odom: String,
    truth: String,
    /// Whether rollers turn.
    rollers: bool,
    /// The topics of the commands in effect: of the twist, and of the wheels' rates.
    command_topics: [&'static str; 2],
    /// Whether `odom -> base_link` is on `/tf`.
    has_odometry_frame: bool,
    /// Height, roll and pitch of the body frame at rest.
    rest: [f64; 3],
    wheels: Vec<WheelTopics>,
    contacts: Contacts,
    window: Window,
    has_reference: bool,
    has_imu: bool,
    /// Next times of contacts and diagnostics, in seconds.
    contacts_due_s: f64,
    diagnostics_due_s: f64,
    /// The messages of a row, reused with their names.
    tf: TFMessage,
    joints: JointState,
    commands: JointState,
}

/// The topics of one wheel.
#[derive(Clone, Debug)]
struct WheelTopics {
    slip: String,
    force: String,
}

impl RunTopics {
    /// The topics of a run of this robot with this description.
    pub fn new(robot: &Robot, described: RobotDescription, run: &RunHeader) -> Self {
        let frames = Frames::of(robot, &described.links).unwrap_or_else(|| Frames {
            base: robot.chassis.name.clone(),
            fixed: Vec::new(),
            joints: Vec::new(),
            wheels: Vec::new(),
            rollers: Vec::new(),
        });
        let posed = robot.posed(&robot.start_positions());
        let standing = posed.standing_pose();
        let rest = standing.map_or([posed.ride_height_m(), 0.0, 0.0], |standing| {
            [standing.height_m, standing.roll_rad, standing.pitch_rad]
        });
        let world = frames.free_name("map");
        let odom = frames.free_name("odom");
        let truth = frames.free_name(&format!("ground_truth/{}", frames.base));
        let names: Vec<String> = robot.wheels.iter().map(|w| w.name.clone()).collect();
        let commands = JointState {
            name: names.clone(),
            ..JointState::default()
        };
        let between = robot.joints.iter().map(|joint| joint.name.clone());
        let joints = JointState {
            name: names.iter().cloned().chain(between).collect(),
            ..JointState::default()
        };
        let mut tf = vec![
            frame(&odom, &frames.base, &Isometry3::identity()),
            frame(&world, &truth, &Isometry3::identity()),
        ];
        let rollers = run.roller_angles.then_some(&frames.rollers);
        let bodies = frames.joints.iter().chain(&frames.wheels);
        for turning in bodies.chain(rollers.into_iter().flatten()) {
            tf.push(frame(&turning.parent, &turning.child, &turning.at(0.0)));
        }
        Self {
            contacts: Contacts::of(robot, &world),
            window: Window::of(run),
            wheels: wheel_topics(&names),
            has_reference: !run.open_loop,
            has_imu: run.imu,
            contacts_due_s: 0.0,
            diagnostics_due_s: DIAGNOSTICS_EVERY_S,
            rollers: run.roller_angles,
            command_topics: ["/cmd_vel", "/robot_joint_commands"],
            has_odometry_frame: true,
            tf: TFMessage { transforms: tf },
            commands,
            joints,
            description: described.urdf,
            frames,
            world,
            odom,
            truth,
            rest,
        }
    }

    /// Removes the frame `odom -> base_link`, for another publisher of it.
    pub fn without_odometry_frame(mut self) -> Self {
        if std::mem::take(&mut self.has_odometry_frame) {
            self.tf.transforms.remove(0);
        }
        self
    }

    /// Renames the topics of the commands in effect, of the twist and of the wheels' rates, where
    /// their names are those of inputs.
    pub fn with_command_topics(mut self, topics: [&'static str; 2]) -> Self {
        self.command_topics = topics;
        self
    }

    /// The robot's URDF on `/robot_description`.
    pub fn robot_description(&self) -> &str {
        &self.description
    }

    /// The frames of its links.
    pub fn frames(&self) -> &Frames {
        &self.frames
    }

    /// Declares all topics.
    ///
    /// # Errors
    /// Those of the outlet.
    pub fn declare<O: Outlet>(&self, outlet: &mut O) -> Result<(), O::Error> {
        outlet.declare::<Clock>("/clock", Qos::best_effort(1))?;
        outlet.declare::<Text>("/robot_description", Qos::reliable(1).transient_local())?;
        outlet.declare::<TFMessage>("/tf_static", Qos::reliable(1).transient_local())?;
        outlet.declare::<TFMessage>("/tf", Qos::reliable(100))?;
        outlet.declare::<JointState>("/joint_states", Qos::reliable(10))?;
        let [twist, rates] = self.command_topics;
        outlet.declare::<JointState>(rates, Qos::reliable(10))?;
        outlet.declare::<TwistStamped>(twist, Qos::reliable(10))?;
        outlet.declare::<Odometry>("/odom", Qos::reliable(10))?;
        outlet.declare::<Odometry>("/ground_truth/odom", Qos::reliable(10))?;
        outlet.declare::<PoseStamped>("/pose", Qos::reliable(10))?;
        if self.has_reference {
            outlet.declare::<PoseStamped>("/reference", Qos::reliable(10))?;
        }
        if self.has_imu {
            outlet.declare::<Imu>("/imu", Qos::best_effort(10))?;
        }
        for wheel in &self.wheels {
            outlet.declare::<Vector3Stamped>(&wheel.slip, Qos::reliable(10))?;
            outlet.declare::<WrenchStamped>(&wheel.force, Qos::reliable(10))?;
        }
        outlet.declare::<MarkerArray>("/contacts", Qos::reliable(10))?;
        outlet.declare::<DiagnosticArray>("/diagnostics", Qos::reliable(10))
    }

    /// Sends the latched messages: the robot, and the fixed links.
    ///
    /// # Errors
    /// Those of the outlet.
    pub fn latched<O: Outlet>(&self, outlet: &mut O, t_s: f64) -> Result<(), O::Error> {
        let time_ns = time_ns(t_s);
        let mut transforms = vec![frame(&self.world, &self.odom, &Isometry3::identity())];
        for fixed in &self.frames.fixed {
            let at = &fixed.parent_from_child;
            transforms.push(frame(&fixed.parent, &fixed.child, at));
        }
        if !self.rollers {
            for roller in &self.frames.rollers {
                transforms.push(frame(&roller.parent, &roller.child, &roller.at(0.0)));
            }
        }
        for transform in &mut transforms {
            transform.header.stamp = stamp(time_ns);
        }
        let data = self.description.clone();
        outlet.send("/robot_description", &Text { data }, time_ns)?;
        outlet.send("/tf_static", &TFMessage { transforms }, time_ns)
    }

    /// Sends a row: `rollers_rad` are the angles of all rollers, wheel by wheel, if recorded.
    ///
    /// # Errors
    /// Those of the outlet.
    pub fn row<O: Outlet>(
        &mut self,
        record: &Record,
        wheels: &[WheelSample],
        rollers_rad: &[Option<f64>],
        outlet: &mut O,
    ) -> Result<(), O::Error> {
        let time_ns = time_ns(record.t_s);
        let now = stamp(time_ns);
        outlet.send("/clock", &Clock { clock: now }, time_ns)?;
        let [height_m, roll_rad, pitch_rad] = self.rest;
        let reckoned = isometry(record.odometry_ideal, height_m, roll_rad, pitch_rad);
        let truth = &record.truth;
        let real = isometry(truth.pose, truth.height_m, truth.roll_rad, truth.pitch_rad);

        let taken = rollers_rad.iter().filter(|angle| angle.is_some()).count();
        let turned = (&record.joints[..], wheels);
        let moving = self.with_transforms(now, [&reckoned, &real], turned, rollers_rad, taken > 0);
        // Rollers have a lower rate than the rest: their transforms stay at the end until they are
        // due.
        let waiting = self.tf.transforms.split_off(moving);
        outlet.send("/tf", &self.tf, time_ns)?;
        self.tf.transforms.extend(waiting);

        self.send_joints(now, time_ns, (&record.joints, wheels), outlet)?;
        let base = self.frames.base.clone();
        let command = TwistStamped {
            header: header(now, &base),
            twist: twist(record.command_twist_in_body),
        };
        outlet.send(self.command_topics[0], &command, time_ns)?;
        let frames = [&self.odom, &base].map(String::as_str);
        let mut odom = odometry(now, frames, &reckoned, record.twist_ideal, RECKONED);
        if let Some(said) = &record.reckoned {
            odom.twist.twist = twist(said.twist);
            put_planar(&mut odom.pose.covariance, &said.pose_covariance);
            put_planar(&mut odom.twist.covariance, &said.twist_covariance);
        }
        outlet.send("/odom", &odom, time_ns)?;
        let real_twist = truth.twist_in_body;
        let odom = odometry(now, [&self.world, &self.truth], &real, real_twist, TRUE);
        outlet.send("/ground_truth/odom", &odom, time_ns)?;
        let at = |place: Pose| PoseStamped {
            header: header(now, &self.world),
            pose: pose(&isometry(place, height_m, roll_rad, pitch_rad)),
        };
        outlet.send("/pose", &at(record.seen_pose), time_ns)?;
        if let Some(desired) = record.desired.filter(|_| self.has_reference) {
            outlet.send("/reference", &at(desired.pose), time_ns)?;
        }
        if let Some(sample) = record.imu.filter(|_| self.has_imu) {
            outlet.send("/imu", &imu(header(now, &base), &sample), time_ns)?;
        }
        for (topics, sample) in self.wheels.iter().zip(wheels) {
            let along = |x: f64, y: f64, z: f64| Vector3 { x, y, z };
            let slip = Vector3Stamped {
                header: header(now, &base),
                vector: along(sample.slip_x_m_s, sample.slip_y_m_s, 0.0),
            };
            outlet.send(&topics.slip, &slip, time_ns)?;
            let mut force = WrenchStamped {
                header: header(now, &base),
                ..WrenchStamped::default()
            };
            force.wrench.force = along(sample.force_x_n, sample.force_y_n, sample.normal_force_n);
            outlet.send(&topics.force, &force, time_ns)?;
        }

        // Half a microsecond tolerates the rounding of times that are sums of periods.
        let t_s = record.t_s + 5e-7;
        if t_s >= self.contacts_due_s {
            self.contacts_due_s = next(self.contacts_due_s, t_s, 1.0 / MARKER_RATE_HZ);
            let markers = self.contacts.message(now, record, wheels);
            outlet.send("/contacts", &markers, time_ns)?;
        }
        if t_s >= self.diagnostics_due_s {
            self.diagnostics_due_s = next(self.diagnostics_due_s, t_s, DIAGNOSTICS_EVERY_S);
            self.send_diagnostics(record.t_s, outlet)?;
        }
        self.window.add(record, wheels);
        Ok(())
    }

    /// Sends the remaining messages of a run that ends at a time in seconds.
    ///
    /// # Errors
    /// Those of the outlet.
    pub fn end<O: Outlet>(&mut self, t_s: f64, outlet: &mut O) -> Result<(), O::Error> {
        self.send_diagnostics(t_s, outlet)
    }

    fn send_diagnostics<O: Outlet>(&mut self, t_s: f64, outlet: &mut O) -> Result<(), O::Error> {
        if self.window.is_empty() {
            return Ok(());
        }
        let time_ns = time_ns(t_s);
        let mut report = self.window.report();
        report.header.stamp = stamp(time_ns);
        outlet.send("/diagnostics", &report, time_ns)
    }

    /// Writes a row's poses to the message of frames; returns how many of them belong to this row.
    fn with_transforms(
        &mut self,
        now: Time,
        bodies: [&Isometry3<f64>; 2],
        (joints, wheels): (&[JointSample], &[WheelSample]),
        rollers_rad: &[Option<f64>],
        with_rollers: bool,
    ) -> usize {
        let mut poses = self.tf.transforms.iter_mut();
        let mut put = |at: &Isometry3<f64>| {
            if let Some(frame) = poses.next() {
                frame.header.stamp = now;
                frame.transform = transform(at);
            }
        };
        let bodies = &bodies[usize::from(!self.has_odometry_frame)..];
        bodies.iter().for_each(|at| put(at));
        for (index, joint) in self.frames.joints.iter().enumerate() {
            put(&joint.at(joints.get(index).map_or(0.0, |of| of.position)));
        }
        for (turning, sample) in self.frames.wheels.iter().zip(wheels) {
            put(&turning.at(sample.angle_rad));
        }
        let bodies_and_wheels = bodies.len() + self.frames.joints.len() + self.frames.wheels.len();
        if !(self.rollers && with_rollers) {
            return bodies_and_wheels;
        }
        for (turning, angle_rad) in self.frames.rollers.iter().zip(rollers_rad) {
            put(&turning.at(angle_rad.unwrap_or_default()));
        }
        self.tf.transforms.len()
    }

    fn send_joints<O: Outlet>(
        &mut self,
        now: Time,
        time_ns: u64,
        (joints, wheels): (&[JointSample], &[WheelSample]),
        outlet: &mut O,
    ) -> Result<(), O::Error> {
        let fill = |values: &mut Vec<f64>, of: fn(&WheelSample) -> f64| {
            values.clear();
            values.extend(wheels.iter().map(of));
        };
        self.joints.header.stamp = now;
        fill(&mut self.joints.position, |wheel| wheel.angle_rad);
        fill(&mut self.joints.velocity, |wheel| wheel.rate_rad_s);
        fill(&mut self.joints.effort, |wheel| wheel.torque_n_m);
        // Joints between bodies come after the wheels', as far as recorded.
        for joint in 0..self.joints.name.len().saturating_sub(wheels.len()) {
            let of = joints.get(joint).copied().unwrap_or_default();
            self.joints.position.push(of.position);
            self.joints.velocity.push(of.rate);
            self.joints.effort.push(of.force);
        }
        outlet.send("/joint_states", &self.joints, time_ns)?;
        self.commands.header.stamp = now;
        fill(&mut self.commands.velocity, |wheel| wheel.target_rad_s);
        outlet.send(self.command_topics[1], &self.commands, time_ns)
    }
}

/// Returns the next due time after now of a period `every_s`, on the same grid.
fn next(due_s: f64, t_s: f64, every_s: f64) -> f64 {
    due_s + every_s * (((t_s - due_s) / every_s).floor() + 1.0)
}

fn header(stamp: Time, frame: &str) -> Header {
    Header {
        stamp,
        frame_id: frame.to_owned(),
    }
}

fn frame(parent: &str, child: &str, parent_from_child: &Isometry3<f64>) -> TransformStamped {
    TransformStamped {
        header: header(Time::default(), parent),
        child_frame_id: child.to_owned(),
        transform: transform(parent_from_child),
    }
}

fn odometry(
    now: Time,
    [parent, child]: [&str; 2],
    at: &Isometry3<f64>,
    moving: Twist,
    variances: [f64; 6],
) -> Odometry {
    let mut covariance: Covariance = [[0.0; 6]; 6];
    for (axis, variance) in variances.into_iter().enumerate() {
        covariance[axis][axis] = variance;
    }
    let mut odometry = Odometry {
        header: header(now, parent),
        child_frame_id: child.to_owned(),
        ..Odometry::default()
    };
    odometry.pose.pose = pose(at);
    odometry.pose.covariance = covariance;
    odometry.twist.twist = twist(moving);
    odometry.twist.covariance = covariance;
    odometry
}

/// Inserts the covariance of x, y and heading into that of six degrees of freedom.
fn put_planar(whole: &mut Covariance, planar: &[[f64; 3]; 3]) {
    let places = [0, 1, 5];
    for (row, from_row) in places.into_iter().zip(planar) {
        for (column, from) in places.into_iter().zip(from_row) {
            let least = if row == column { LEAST } else { 0.0 };
            whole[row][column] = from + least;
        }
    }
}

/// Returns the IMU message, with roll and pitch by the robot's filter; the heading is not measured.
/// Unknown covariances are zero, as the message defines.
fn imu(header: Header, sample: &ImuSample) -> Imu {
    let vector = |v: &nalgebra::Vector3<f64>| Vector3 {
        x: v.x,
        y: v.y,
        z: v.z,
    };
    let level = UnitQuaternion::from_euler_angles(sample.roll_rad, sample.pitch_rad, 0.0);
    let diagonal = |[x, y, z]: [f64; 3]| [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
    let alike = |variance: f64| diagonal([variance + LEAST; 3]);
    let (said, none) = (sample.variances, diagonal([0.0; 3]));
    let tilt = |of: ImuVariances| {
        let tilt_rad2 = of.tilt_rad2 + LEAST;
        diagonal([tilt_rad2, tilt_rad2, UNKNOWN])
    };
    Imu {
        header,
        orientation: pose(&Isometry3::from_parts(Default::default(), level)).orientation,
        angular_velocity: vector(&sample.rate_rad_s),
        linear_acceleration: vector(&sample.specific_force_m_s2),
        orientation_covariance: said.map_or(none, tilt),
        angular_velocity_covariance: said.map_or(none, |of| alike(of.rate_rad2_s2)),
        linear_acceleration_covariance: said.map_or(none, |of| alike(of.specific_force_m2_s4)),
    }
}

/// Returns the topics of wheels: their names, with invalid characters replaced, all distinct.
fn wheel_topics(names: &[String]) -> Vec<WheelTopics> {
    let mut taken = HashSet::new();
    let topics = names.iter().map(|name| {
        let letter = |letter: char| match letter {
            'a'..='z' | 'A'..='Z' | '0'..='9' | '_' => letter,
            _ => '_',
        };
        // ROS 2 allows at most 247 characters in all.
        let mut part: String = name.chars().map(letter).take(200).collect();
        if !part.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_') {
            part.insert(0, '_');
        }
        while !taken.insert(part.clone()) {
            part.push('_');
        }
        WheelTopics {
            slip: format!("/wheels/{part}/slip"),
            force: format!("/wheels/{part}/force"),
        }
    });
    topics.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_wheel_has_topics_that_ros_takes() {
        let names = ["front left", "front/left", "1st", "", "front_left", "räd"];
        let long = wheel_topics(&["a".repeat(300)]);
        assert!(long[0].force.len() <= 247, "{}", long[0].force);
        let topics = wheel_topics(&names.map(str::to_owned));
        let slips: Vec<&str> = topics.iter().map(|topic| topic.slip.as_str()).collect();
        assert_eq!(
            slips,
            [
                "/wheels/front_left/slip",
                "/wheels/front_left_/slip",
                "/wheels/_1st/slip",
                "/wheels/_/slip",
                "/wheels/front_left__/slip",
                "/wheels/r_d/slip",
            ]
        );
    }

    #[test]
    fn what_is_due_stays_on_its_grid() {
        // Rows 20 ms apart, due every 1/30 s: at 0, 40, 80, 100 ms.
        let mut due_s = 0.0;
        let mut sent = Vec::new();
        for row in 0..6 {
            let t_s = 0.02 * f64::from(row) + 5e-7;
            if t_s >= due_s {
                due_s = next(due_s, t_s, 1.0 / 30.0);
                sent.push(row);
            }
        }
        assert_eq!(sent, [0, 2, 4, 5]);
    }
}
