//! The content of one row of a trace.
//!
//! A row belongs to an instant `t_s`, the start of a control period, after the controller has
//! decided and before the bodies move. The last row is at the end of the run, where nothing is
//! decided any more, so that the last period has a row too. The body frame is the robot's own: x
//! forward, y left, z up. Each quantity is one of four kinds, named in its documentation:
//!
//! - **State**, at the instant: poses, velocities, wheel angles and rates, stored energies, the
//!   roller that carries most.
//! - **Decision**, from the instant on: commanded and granted twists, wheel targets. It holds until
//!   the next control period; the last row repeats the last decision.
//! - **Period**, from the previous row to this one: forces, torques and slip as means over all
//!   physics steps (impulse over time, so that the sum of all forces is mass times the change of
//!   velocity over the time), and their smallest and largest values. They do not depend on how
//!   often rows are written, and are zero in the first row.
//! - **Sum**, since the start of the run: energies lost or put in, and the error budget.

use ilon_robot::{Pose, Twist};
use nalgebra::Vector3;

use crate::ledger::Ledger;

/// The most tasks of one guidance law: feedforward and feedback of position and of heading,
/// Indiveri 2009, eqs. (38)-(41), facing a point, and a constant twist.
pub const MAX_TASKS: usize = 6;

/// The most joints between bodies that a trace records: the first ones of the robot.
pub const MAX_JOINTS: usize = 12;

/// One joint between bodies at one control step: a rocker, a sprung wheel, a swing arm. Numbers are
/// in rad and N m for a revolute joint, in m and N for a prismatic one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointSample {
    /// Position: state.
    pub position: f64,
    /// Smallest position over the period.
    pub position_min: f64,
    /// Largest position over the period.
    pub position_max: f64,
    /// Its rate, in rad/s or m/s: state.
    pub rate: f64,
    /// Torque or force of its spring, damper, friction, servo and stops on its body: the mean over
    /// the period.
    pub force: f64,
    /// Smallest value over the period: the most negative.
    pub force_min: f64,
    /// Largest value over the period.
    pub force_max: f64,
}

/// The most free bodies that a trace records: the first ones of the scenario.
pub const MAX_BODIES: usize = 12;

/// One free body at one control step, in the world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodySample {
    /// Its centre, in metres.
    pub place_m: [f64; 3],
    /// Roll, in radians.
    pub roll_rad: f64,
    /// Pitch, in radians.
    pub pitch_rad: f64,
    /// Heading, in radians.
    pub heading_rad: f64,
    /// Velocity of its centre, in m/s.
    pub velocity_m_s: [f64; 3],
    /// Magnitude of the force of all robots on it, in N: the mean over the period.
    pub push_n: f64,
    /// Largest value of that over the period, in N.
    pub push_max_n: f64,
    /// Work that robots have done on it since the start, in J.
    pub work_j: f64,
}

/// The signals of one control step, apart from those of each wheel (see [`WheelSample`]).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Record {
    /// Time since the start of the run, in seconds.
    pub t_s: f64,
    /// Pose and motion of the robot.
    pub truth: Truth,
    /// The twist in the body frame that Indiveri 2009, eq. (7), gives for the real wheel rates at
    /// the instant.
    pub twist_ideal: Twist,
    /// The twist in the body frame that the contact kinematics gives for the real wheel rates at
    /// the instant: eq. (5) with the rolling direction and the place of the roller that touches.
    pub twist_contact: Twist,
    /// The pose that the robot sees, noise and delay included.
    pub seen_pose: Pose,
    /// Dead reckoning by `twist_ideal`, from the true pose at the start.
    pub odometry_ideal: Pose,
    /// Dead reckoning by `twist_contact`, from the true pose at the start.
    pub odometry_contact: Pose,
    /// Dead reckoning by eq. (7) with the wheels at their places under their joints, from the true
    /// pose at the start; its distance from `odometry_ideal` is the cost of hub motion. `None`
    /// without joints between bodies.
    pub odometry_posed: Option<Pose>,
    /// The reference; `None` in an open-loop run.
    pub desired: Option<Desired>,
    /// The real robot's pose from a log, in the world frame; `None` without such a log, or where it
    /// has no pose.
    pub measured: Option<Pose>,
    /// The commanded twist in the body frame, before saturation.
    pub command_twist_in_body: Twist,
    /// The twist in the body frame after saturation, by the kinematic model that made the wheel
    /// targets.
    pub granted_twist_in_body: Twist,
    /// The twist in the body frame that eq. (7) gives for the wheel targets. Equal to the granted
    /// twist, unless the command uses another kinematic model than (7).
    pub twist_target_ideal: Twist,
    /// The share of the control instants after the row before and up to this one at which a limit
    /// on wheel rates took anything of the command, in [0, 1].
    pub saturated_share: f64,
    /// The guidance law's tasks, highest priority first. As many as [`crate::Header::task_names`]
    /// has are in use; the rest is zero.
    pub tasks: [TaskShare; MAX_TASKS],
    /// The joints between bodies. As many as [`crate::Header::joints`] has are in use; the rest is
    /// zero.
    pub joints: [JointSample; MAX_JOINTS],
    /// The free bodies. As many as [`crate::Header::bodies`] has are in use; the rest is zero.
    pub bodies: [BodySample; MAX_BODIES],
    /// Share of the commanded acceleration of the reference point that the torques give, in [0, 1];
    /// 1 if the wheel loops do not weigh tasks.
    pub torque_weight_position: f64,
    /// Share of the commanded angular acceleration that the torques give, in [0, 1]; 1 if the wheel
    /// loops do not weigh tasks.
    pub torque_weight_heading: f64,
    /// The error budget since the start, counted over all physics steps. The difference of two rows
    /// is the budget of the time between them.
    pub ledger: Ledger,
    /// Energy lost to sliding in all contacts since the start, in J; it never falls.
    pub slip_energy_j: f64,
    /// Energy lost in bringing rollers that touched down to their spin since the start, in J; it
    /// never falls.
    pub spin_up_energy_j: f64,
    /// Work done by all motors since the start, in J.
    pub motor_energy_j: f64,
    /// The positive part of that work since the start, in J: the work of the motors while they
    /// drove, without subtracting braking. It never falls. 0 in traces recorded before it existed.
    pub motor_positive_energy_j: f64,
    /// Energy lost in the bearings of wheels and rollers and in the gears since the start, in J.
    pub bearing_energy_j: f64,
    /// Energy lost in impacts since the start, in J: what the contacts dissipated besides sliding,
    /// less what their springs returned.
    pub impact_energy_j: f64,
    /// Work of pushes and payloads since the start, in J.
    pub outside_energy_j: f64,
    /// Kinetic energy of all bodies, in J.
    pub kinetic_energy_j: f64,
    /// Potential energy of all bodies above the world's origin, and of the contacts' springs, in J.
    pub potential_energy_j: f64,
    /// Largest residual of the contact and dry friction laws since the last row, in m/s or rad/s:
    /// the speed of a motion that the laws forbid, at the worst place and step.
    pub contact_residual_m_s: f64,
    /// Inconsistent share of the wheels' real rates q': |r| over |q'| with r = q' - M M^+ q', root
    /// mean squares over the period, in [0, 1]; 0 if the wheels stand.
    pub rate_conflict_share: f64,
    /// The ground's forces on the robot as a whole; `None` if the trace does not have them.
    pub support: Option<Support>,
    /// Twist and covariances of dead reckoning by Indiveri 2009, eq. (7), besides `odometry_ideal`;
    /// `None` if they were not computed. Used in messages, not a column of a file.
    pub reckoned: Option<Reckoned>,
    /// The last sample of an inertial measurement unit; `None` without one.
    pub imu: Option<ImuSample>,
    /// Storage and supply of a passive wheel law; `None` under other laws.
    pub storage: Option<Storage>,
}

/// Twist and uncertainty of dead reckoning: covariances of x, y and heading, row by row, in m, m/s,
/// rad and rad/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reckoned {
    /// The twist by the encoders' rates, in the body frame.
    pub twist: Twist,
    /// Covariance of the pose, in the world frame.
    pub pose_covariance: [[f64; 3]; 3],
    /// Covariance of the twist, in the body frame, valid if the errors of all rows are taken as
    /// independent.
    pub twist_covariance: [[f64; 3]; 3],
}

/// A sample of an inertial measurement unit on the chassis, in the body frame, with its axes as the
/// robot assumes them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuSample {
    /// Angular rate, in rad/s.
    pub rate_rad_s: Vector3<f64>,
    /// Specific force, in m/s^2: acceleration minus gravity, upwards at rest.
    pub specific_force_m_s2: Vector3<f64>,
    /// Roll against gravity by the robot's filter, in radians.
    pub roll_rad: f64,
    /// Pitch against gravity by the robot's filter, in radians.
    pub pitch_rad: f64,
    /// Its variances; `None` if unknown. Used in messages, not a column of a file.
    pub variances: Option<ImuVariances>,
}

/// Variances of an inertial measurement unit on each of its axes, noise and biases together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuVariances {
    /// Of an angular rate, in rad^2/s^2.
    pub rate_rad2_s2: f64,
    /// Of the specific force along an axis, in m^2/s^4.
    pub specific_force_m2_s4: f64,
    /// Of roll and of pitch by the robot's filter, while the robot does not accelerate, in rad^2.
    pub tilt_rad2: f64,
}

/// The storage function of a robot under a passive wheel law. It never rises by more than its
/// supply.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Storage {
    /// Kinetic and potential energy, the spring to the reference at the true pose, and the springs
    /// between the wheels, in J.
    pub stored_j: f64,
    /// Supplied since the start, in J: by pushes, payloads, servos and tilting ground; by the law's
    /// gravity compensation; by a moving reference; and by the law's torques on wheels that slide
    /// over the ground.
    pub supplied_j: f64,
    /// Largest rise of the storage beyond its supply, from any physics step up to now to a later
    /// one, in J.
    pub rise_j: f64,
}

/// The ground's forces on the robot as a whole: means over the period, in N; zero in the first row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Support {
    /// Load on the wheels: the ground's force along the floor's normal.
    pub wheels_n: f64,
    /// Load on the chassis: the same for its parts that touch the ground.
    pub chassis_n: f64,
    /// Force of walls, kerbs and bumps on the robot: the part of all normal forces in the floor's
    /// plane, along the robot's heading.
    pub obstacles_x_n: f64,
    /// The same to the left of its heading.
    pub obstacles_y_n: f64,
}

/// The robot's true state in the world frame: its origin is in the floor's plane and z is the
/// floor's normal, also on a slope.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Pose of the body frame in the world frame.
    pub pose: Pose,
    /// Height of the body frame's origin above the floor's plane, in metres.
    pub height_m: f64,
    /// Roll against the floor's plane, in radians.
    pub roll_rad: f64,
    /// Pitch against the floor's plane, in radians.
    pub pitch_rad: f64,
    /// Velocity of the body frame's origin, and yaw rate, in the body frame.
    pub twist_in_body: Twist,
}

/// The reference of a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Desired {
    /// Desired pose in the world frame: **r**_d and phi_d of Indiveri 2009, eqs. (13), (17).
    pub pose: Pose,
    /// Its rate, in the world frame.
    pub velocity_in_world: Twist,
    /// Largest distance between the reference point and its target, over the control instants since
    /// the previous row up to this one, in metres.
    pub position_error_max_m: f64,
    /// Largest magnitude of the heading error at these instants, in radians.
    pub heading_error_max_rad: f64,
}

/// One task of the prioritised saturation, Indiveri 2009, eqs. (32)-(34).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TaskShare {
    /// Demand of the task: the infinity norm of its wheel rates, in rad/s.
    pub asked_rad_s: f64,
    /// Its capacity c_h, in rad/s.
    pub capacity_rad_s: f64,
    /// Its weight sigma(asked, capacity), in [0, 1]; below 1 the task is saturated.
    pub weight: f64,
    /// The twist in the body frame that the task commands, before its weight.
    pub asked_twist_in_body: Twist,
}

/// The signals of one wheel in one row.
///
/// If several rollers of the wheel touch, forces are sums, and slip and contact point are weighted
/// by the normal forces. For a wheel that was in the air for the whole period, `touching_share` and
/// all contact quantities are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelSample {
    /// The commanded wheel rate, in rad/s: decision.
    pub target_rad_s: f64,
    /// Largest magnitude of the commanded rates since the previous row, in rad/s.
    pub target_peak_rad_s: f64,
    /// The real wheel rate, in rad/s: state.
    pub rate_rad_s: f64,
    /// Root mean square over the period of the difference between the commanded rate in force and
    /// the real one, in rad/s.
    pub rate_error_rms_rad_s: f64,
    /// The wheel's angle since the start, unwrapped, in radians: state.
    pub angle_rad: f64,
    /// Torque of the motor on the wheel, in N m: the mean over the period.
    pub torque_n_m: f64,
    /// Smallest value over the period, in N m: the most negative.
    pub torque_min_n_m: f64,
    /// Largest value over the period, in N m.
    pub torque_max_n_m: f64,
    /// Height of the wheel's centre above the floor's plane, level or not, in metres: state.
    pub hub_height_m: f64,
    /// Smallest value over the period, in metres.
    pub hub_height_min_m: f64,
    /// Largest value over the period, in metres.
    pub hub_height_max_m: f64,
    /// Index of the roller that carries most of the load; 0 if none touches. State, like the four
    /// that follow.
    pub roller: u32,
    /// Whether any roller touches.
    pub touching: bool,
    /// The share of the wheel's normal force that `roller` carries, in [0, 1]; below 1 a neighbour
    /// carries the rest.
    pub load_share: f64,
    /// Spin of `roller` about its axis, in rad/s.
    pub roller_spin_rad_s: f64,
    /// The spin at which `roller` would not slide across its axis, in rad/s.
    pub roller_spin_ideal_rad_s: f64,
    /// The share of the period in which any roller touched, in [0, 1].
    pub touching_share: f64,
    /// Contact point in the body frame, x, in metres: the mean over the period weighted by the
    /// normal force.
    pub contact_x_m: f64,
    /// The same, y, in metres.
    pub contact_y_m: f64,
    /// Normal force on the wheel, in N: the mean over the period.
    pub normal_force_n: f64,
    /// Smallest value over the period, in N.
    pub normal_force_min_n: f64,
    /// Largest value over the period, in N.
    pub normal_force_max_n: f64,
    /// Tangential force of the ground on the wheel, x in the body frame, in N: the mean over the
    /// period.
    pub force_x_n: f64,
    /// The same, y in the body frame, in N.
    pub force_y_n: f64,
    /// Friction coefficient of the contact: the mean over the period weighted by the normal force.
    pub friction: f64,
    /// Largest utilisation of the friction limit over the period: tangential force over mu N, 1 on
    /// the edge of the friction cone. 0 without load or without friction.
    pub friction_used_max: f64,
    /// Velocity of the roller's material point relative to the ground at the contact, x in the body
    /// frame, in m/s: the mean over the time in contact.
    pub slip_x_m_s: f64,
    /// The same, y in the body frame, in m/s.
    pub slip_y_m_s: f64,
    /// Root mean square of the sliding speed over the time in contact, in m/s.
    pub slip_speed_rms_m_s: f64,
    /// The largest sliding speed over the period, in m/s.
    pub slip_speed_max_m_s: f64,
    /// Energy lost to sliding in this wheel's contacts since the start, in J: sum.
    pub slip_energy_j: f64,
    /// Energy lost in bringing this wheel's rollers to their spin since the start, in J: sum.
    pub spin_up_energy_j: f64,
}

impl Record {
    /// Whether the row has contact data: at the start no step has been taken yet, and they are all
    /// zero.
    pub(crate) fn has_contacts(&self) -> bool {
        self.t_s > 0.0
    }
}

impl WheelSample {
    /// The place of the contact in the world, x and y in metres, of a robot in this pose.
    pub fn contact_m(&self, pose: Pose) -> [f64; 2] {
        let (sin, cos) = pose.heading_rad.sin_cos();
        let (x_m, y_m) = (self.contact_x_m, self.contact_y_m);
        [
            pose.x_m + cos * x_m - sin * y_m,
            pose.y_m + sin * x_m + cos * y_m,
        ]
    }

    /// The sample of a wheel that was steady over the whole period: the extremes equal the means,
    /// and the grip utilisation follows from force, load and friction.
    #[must_use]
    pub fn steady(self) -> Self {
        let speed_m_s = self.slip_speed_m_s();
        let limit_n = self.friction * self.normal_force_n;
        Self {
            target_peak_rad_s: self.target_rad_s.abs(),
            rate_error_rms_rad_s: (self.target_rad_s - self.rate_rad_s).abs(),
            torque_min_n_m: self.torque_n_m,
            torque_max_n_m: self.torque_n_m,
            hub_height_min_m: self.hub_height_m,
            hub_height_max_m: self.hub_height_m,
            touching_share: f64::from(u8::from(self.touching)),
            normal_force_min_n: self.normal_force_n,
            normal_force_max_n: self.normal_force_n,
            friction_used_max: if limit_n > 0.0 {
                self.tangential_force_n() / limit_n
            } else {
                0.0
            },
            slip_speed_rms_m_s: speed_m_s,
            slip_speed_max_m_s: speed_m_s,
            ..self
        }
    }

    /// Whether the wheel touched the ground at any time in the period.
    pub fn touched(&self) -> bool {
        self.touching_share > 0.0
    }

    /// Magnitude of the mean sliding velocity in contact, in m/s.
    pub fn slip_speed_m_s(&self) -> f64 {
        libm::hypot(self.slip_x_m_s, self.slip_y_m_s)
    }

    /// Magnitude of the mean tangential force of the ground, in N.
    pub fn tangential_force_n(&self) -> f64 {
        libm::hypot(self.force_x_n, self.force_y_n)
    }

    /// [`WheelSample::friction_used_max`]; `None` without load or without friction.
    pub fn friction_used(&self) -> Option<f64> {
        (self.friction * self.normal_force_n > 0.0).then_some(self.friction_used_max)
    }

    /// Largest magnitude of the motor's torque over the period, in N m.
    pub fn torque_peak_n_m(&self) -> f64 {
        self.torque_max_n_m.max(-self.torque_min_n_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3 N of at most 0.5 * 10 N.
    #[test]
    fn a_steady_wheel_uses_the_share_of_its_grip_that_its_force_takes() {
        let sample = WheelSample {
            friction: 0.5,
            normal_force_n: 10.0,
            force_x_n: 3.0,
            ..WheelSample::default()
        };
        assert!((sample.steady().friction_used_max - 0.6).abs() < 1e-15);
    }
}
