//! What one row of a trace holds.
//!
//! A row stands at an instant `t_s`, the start of a control period, after the controller has decided and before the bodies move. The last row
//! stands at the end of the run, where nothing is decided any more, so that what happened in the last period has a row too.
//! Body frame means the robot's own: x forward, y left, z up. Each quantity is one of four kinds, and its documentation says which:
//!
//! - **State**, at the instant: poses, velocities, wheel angles and rates, stored energies, which roller carries.
//! - **Decision**, from the instant on: what was asked, granted and targeted. It holds until the next control period; at the end the last one stands.
//! - **Period**, from the row before to this one: forces, torques and slip as means over all physics steps (impulse over time, so that
//!   the sum of all forces is mass times the change of velocity over the time), and beside them the least and the largest of them. They do
//!   not depend on how often rows are written, and are zero in the first row.
//! - **Sum**, since the start of the run: energies lost or put in, and the error budget.

use ilon_robot::{Pose, Twist};
use nalgebra::Vector3;

use crate::ledger::Ledger;

/// The most tasks that one guidance law runs: feedforward and feedback of position and of heading, Indiveri 2009,
/// eqs. (38)-(41).
pub const MAX_TASKS: usize = 6;

/// The most joints between bodies that a trace records: those that stand first in the robot.
pub const MAX_JOINTS: usize = 12;

/// One joint between bodies at one control step: a rocker, a sprung wheel, a swing arm. Numbers are in rad and N m of a joint that turns, in m
/// and N of one that slides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointSample {
    /// How far it has moved from zero: state.
    pub position: f64,
    /// The least position over the period.
    pub position_min: f64,
    /// The largest position over the period.
    pub position_max: f64,
    /// Its rate, in rad/s or m/s: state.
    pub rate: f64,
    /// What its spring, damper, friction, servo and stops put on its body: the mean over the period.
    pub force: f64,
    /// The least of that over the period: the most in the negative direction.
    pub force_min: f64,
    /// The largest of that over the period.
    pub force_max: f64,
}

/// The most free bodies that a trace records: those that stand first in the scenario.
pub const MAX_BODIES: usize = 12;

/// One free body at one control step, in the world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodySample {
    /// Its middle, in metres.
    pub place_m: [f64; 3],
    /// Roll, in radians.
    pub roll_rad: f64,
    /// Pitch, in radians.
    pub pitch_rad: f64,
    /// Heading, in radians.
    pub heading_rad: f64,
    /// Velocity of its middle, in m/s.
    pub velocity_m_s: [f64; 3],
    /// The size of the force of all robots on it, in N: the mean over the period.
    pub push_n: f64,
    /// The largest of that over the period, in N.
    pub push_max_n: f64,
    /// Work that robots have done on it since the start, in J.
    pub work_j: f64,
}

/// The signals of one control step, apart from those of each wheel (see [`WheelSample`]).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Record {
    /// Time since the start of the run, in seconds.
    pub t_s: f64,
    /// Where the robot is and how it moves.
    pub truth: Truth,
    /// The twist in the body frame that Indiveri 2009, eq. (7), gives for the real wheel rates at the instant.
    pub twist_ideal: Twist,
    /// The twist in the body frame that the contact kinematics gives for the real wheel rates at the instant: eq. (5) with the
    /// rolling direction and the place of the roller that touches.
    pub twist_contact: Twist,
    /// The pose that the robot sees, noise and delay included.
    pub seen_pose: Pose,
    /// Dead reckoning by `twist_ideal`, from the true pose at the start.
    pub odometry_ideal: Pose,
    /// Dead reckoning by `twist_contact`, from the true pose at the start.
    pub odometry_contact: Pose,
    /// Dead reckoning by eq. (7) with the wheels where their joints have them, from the true pose at the start: how far it is from `odometry_ideal` is
    /// what hub motion costs; `None` of a robot without joints between bodies.
    pub odometry_posed: Option<Pose>,
    /// What the reference wants; `None` in an open-loop run.
    pub desired: Option<Desired>,
    /// Where a log says that the real robot was at the time, in the world frame; `None` of a run that has no such log, and where
    /// the log says nothing.
    pub measured: Option<Pose>,
    /// The twist in the body frame asked for, before any saturation.
    pub command_twist_in_body: Twist,
    /// The twist in the body frame that is left of it after saturation, by the kinematic model with which the
    /// command made the wheel targets.
    pub granted_twist_in_body: Twist,
    /// The twist in the body frame that eq. (7) gives for the wheel targets. The same as granted, unless the command
    /// uses another kinematic model than (7).
    pub twist_target_ideal: Twist,
    /// The share of the control instants after the row before and up to this one at which a limit on wheel rates took anything of the command, in [0, 1].
    pub saturated_share: f64,
    /// The guidance law's tasks, highest priority first; as many as [`crate::Header::task_names`] has are in use,
    /// the rest is zero.
    pub tasks: [TaskShare; MAX_TASKS],
    /// The joints between bodies; as many as [`crate::Header::joints`] has are in use, the rest is zero.
    pub joints: [JointSample; MAX_JOINTS],
    /// The free bodies; as many as [`crate::Header::bodies`] has are in use, the rest is zero.
    pub bodies: [BodySample; MAX_BODIES],
    /// How much of the acceleration asked of the reference point the torques give, in [0, 1]; 1 where the wheel loops
    /// weigh no tasks.
    pub torque_weight_position: f64,
    /// How much of the angular acceleration asked for the torques give, in [0, 1]; 1 where the wheel loops weigh no
    /// tasks.
    pub torque_weight_heading: f64,
    /// The error budget since the start: where the motion asked for went, counted over all physics steps. Of two rows, the difference is
    /// the budget of the time between them.
    pub ledger: Ledger,
    /// Energy lost to sliding in all contacts since the start, in J; it never falls.
    pub slip_energy_j: f64,
    /// Energy that it took to bring rollers which came down up to their spin since the start, in J; it never falls.
    pub spin_up_energy_j: f64,
    /// Work done by all motors since the start, in J.
    pub motor_energy_j: f64,
    /// The positive part of that work since the start, in J: what motors put in while they drove, without what they took out while
    /// they braked. It never falls. 0 in traces that were recorded before it was counted.
    pub motor_positive_energy_j: f64,
    /// Energy lost in the bearings of wheels and rollers and in the gears since the start, in J.
    pub bearing_energy_j: f64,
    /// Energy that hits have taken since the start, in J: what the contacts took besides sliding, less what their springs
    /// gave back.
    pub impact_energy_j: f64,
    /// Energy that pushes and payloads have brought from outside since the start, in J.
    pub outside_energy_j: f64,
    /// Kinetic energy of all bodies now, in J.
    pub kinetic_energy_j: f64,
    /// Potential energy of all bodies above the world's origin, and of the contacts' springs, in J.
    pub potential_energy_j: f64,
    /// By how much the laws of contact and of dry friction were broken since the last row, in m/s or rad/s: the speed at
    /// which something moved that should not, at the worst place and step.
    pub contact_residual_m_s: f64,
    /// How much of the wheels' real rates q' belongs to no one motion: |r| over |q'| with r = q' - M M^+ q', root mean squares over the period, in
    /// [0, 1]; 0 where the wheels stand.
    pub rate_conflict_share: f64,
    /// What carried the robot, and what stood in its way; `None` where a trace does not say.
    pub support: Option<Support>,
    /// What dead reckoning by Indiveri 2009, eq. (7), says beside `odometry_ideal`; `None` where nobody worked it out. It goes with messages, and is
    /// no column of a file.
    pub reckoned: Option<Reckoned>,
    /// What an inertial measurement unit said last; `None` without one.
    pub imu: Option<ImuSample>,
    /// What a passive wheel law stored and was supplied with; `None` under any other.
    pub storage: Option<Storage>,
}

/// What dead reckoning says of the twist, and how sure it is: covariances of x, y and heading, row by row, in m, m/s, rad and rad/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reckoned {
    /// The twist by the rates that the encoders said, in the body frame.
    pub twist: Twist,
    /// Of the pose, in the world frame.
    pub pose_covariance: [[f64; 3]; 3],
    /// Of the twist, in the body frame, for one who takes the errors of every row for independent.
    pub twist_covariance: [[f64; 3]; 3],
}

/// What an inertial measurement unit on the chassis says, in the body frame as the robot takes its axes to lie.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuSample {
    /// The rate of turn, in rad/s.
    pub rate_rad_s: Vector3<f64>,
    /// The specific force, in m/s^2: acceleration less gravity, upwards at rest.
    pub specific_force_m_s2: Vector3<f64>,
    /// Roll against gravity, as the robot's filter has it, in radians.
    pub roll_rad: f64,
    /// Pitch against gravity, as the robot's filter has it, in radians.
    pub pitch_rad: f64,
    /// How sure it is; `None` where that is not known. It goes with messages, and is no column of a file.
    pub variances: Option<ImuVariances>,
}

/// How sure an inertial measurement unit is on each of its axes, noise and biases together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuVariances {
    /// Of a rate of turn, in rad^2/s^2.
    pub rate_rad2_s2: f64,
    /// Of the specific force along an axis, in m^2/s^4.
    pub specific_force_m2_s4: f64,
    /// Of roll and of pitch by the robot's filter, while the robot itself does not accelerate, in rad^2.
    pub tilt_rad2: f64,
}

/// The storage function of a robot under a passive wheel law. Its rise is never more than what it was supplied with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Storage {
    /// Kinetic and potential energy, the spring to the reference at the true pose, and the springs between the wheels, in J.
    pub stored_j: f64,
    /// Supplied since the start, in J: by pushes, payloads, servos and ground that leans; by the law's term against gravity; by a reference
    /// that moves; and by what the law pushes wheels with while they slide over the ground.
    pub supplied_j: f64,
    /// The most that the one has risen beyond the other, from any physics step up to now to a later one, in J.
    pub rise_j: f64,
}

/// What the ground did to a robot as a whole: means over the period, in N; zero in the first row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Support {
    /// What the wheels carry: the ground's force on them along the floor's normal.
    pub wheels_n: f64,
    /// What the chassis carries: the same of what of it lies on the ground.
    pub chassis_n: f64,
    /// How walls, kerbs and bumps push the robot: the part of all normal forces that lies in the floor's plane, along the robot's
    /// heading.
    pub obstacles_x_n: f64,
    /// The same to the left of its heading.
    pub obstacles_y_n: f64,
}

impl Support {
    /// The share that the wheels carry of what is carried; `None` in the air.
    pub fn wheels_share(&self) -> Option<f64> {
        let sum_n = self.wheels_n + self.chassis_n;
        (sum_n > 0.0).then(|| self.wheels_n / sum_n)
    }
}

/// The robot's true state, in the world frame: its origin lies in the floor's plane, and z is the floor's normal, on a slope
/// too.
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

/// What the reference wants.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Desired {
    /// Desired pose in the world frame: **r**_d and phi_d of Indiveri 2009, eqs. (13), (17).
    pub pose: Pose,
    /// Its rate, in the world frame.
    pub velocity_in_world: Twist,
    /// The largest distance of the reference point from where it should be, at all control instants after the row before and up to this
    /// one, in metres.
    pub position_error_max_m: f64,
    /// The largest size of the heading's error at these instants, in radians.
    pub heading_error_max_rad: f64,
}

/// One task of the prioritised saturation, Indiveri 2009, eqs. (32)-(34).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TaskShare {
    /// What the task asks for: the infinity norm of its wheel rates, in rad/s.
    pub asked_rad_s: f64,
    /// Its capacity c_h, in rad/s.
    pub capacity_rad_s: f64,
    /// Its weight sigma(asked, capacity), in [0, 1]: below 1 the task gives way.
    pub weight: f64,
    /// The twist in the body frame that the task asks for, before its weight.
    pub asked_twist_in_body: Twist,
}

/// The signals of one wheel in one row.
///
/// Where several rollers of the wheel touch, forces are sums, and slip and contact place are weighted by the normal
/// forces. Of a wheel that was in the air for the whole period `touching_share` and all quantities of the contact are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelSample {
    /// The commanded wheel rate, in rad/s: decision.
    pub target_rad_s: f64,
    /// The largest size of the commanded rates after the row before and up to this one, in rad/s.
    pub target_peak_rad_s: f64,
    /// The real wheel rate, in rad/s: state.
    pub rate_rad_s: f64,
    /// The wheel's angle since the start, unwrapped, in radians: state.
    pub angle_rad: f64,
    /// The torque that the motor put on the wheel, in N m: the mean over the period.
    pub torque_n_m: f64,
    /// The least of that over the period, in N m: the most backwards.
    pub torque_min_n_m: f64,
    /// The largest of that over the period, in N m.
    pub torque_max_n_m: f64,
    /// Height of the wheel's centre above the floor's plane, level or not, in metres: state.
    pub hub_height_m: f64,
    /// The least of that over the period, in metres.
    pub hub_height_min_m: f64,
    /// The largest of that over the period, in metres.
    pub hub_height_max_m: f64,
    /// The roller that carries most of the load: its index; 0 where none touches. State, with the four that follow.
    pub roller: u32,
    /// Whether any roller touches.
    pub touching: bool,
    /// The part of the wheel's normal force that `roller` carries, in [0, 1]; below 1 a neighbour carries the rest.
    pub load_share: f64,
    /// Spin of `roller` about its axis, in rad/s.
    pub roller_spin_rad_s: f64,
    /// The spin with which `roller` would not slide across its axis, in rad/s.
    pub roller_spin_ideal_rad_s: f64,
    /// The part of the period in which any roller touched, in [0, 1].
    pub touching_share: f64,
    /// Place of the contact in the body frame, x, in metres: where the rollers pressed on the ground, the mean over the period weighted by
    /// the normal force.
    pub contact_x_m: f64,
    /// The same, y, in metres.
    pub contact_y_m: f64,
    /// Normal force on the wheel, in N: the mean over the period.
    pub normal_force_n: f64,
    /// The least of that over the period, in N.
    pub normal_force_min_n: f64,
    /// The largest of that over the period, in N.
    pub normal_force_max_n: f64,
    /// Tangential force of the ground on the wheel, x in the body frame, in N: the mean over the period.
    pub force_x_n: f64,
    /// The same, y in the body frame, in N.
    pub force_y_n: f64,
    /// Friction coefficient of the contact: the mean over the period weighted by the normal force.
    pub friction: f64,
    /// The largest share of the friction limit in use over the period: tangential force over mu N, 1 on the edge of the friction cone. 0 where
    /// nothing pressed and where there is no friction.
    pub friction_used_max: f64,
    /// Velocity of the roller's material point over the ground at the contact, x in the body frame, in m/s: the mean over the time of the
    /// period in which it touched.
    pub slip_x_m_s: f64,
    /// The same, y in the body frame, in m/s.
    pub slip_y_m_s: f64,
    /// Root mean square of the sliding speed over the time of the period in which the wheel touched, in m/s.
    pub slip_speed_rms_m_s: f64,
    /// The largest sliding speed over the period, in m/s.
    pub slip_speed_max_m_s: f64,
    /// Energy lost to sliding in this wheel's contacts since the start, in J: sum.
    pub slip_energy_j: f64,
    /// Energy that it took to bring this wheel's rollers up to their spin since the start, in J: sum.
    pub spin_up_energy_j: f64,
}

impl Record {
    /// Whether the row has contacts to speak of: at the start no step has been taken yet, and they are all zero.
    pub(crate) fn has_contacts(&self) -> bool {
        self.t_s > 0.0
    }
}

impl WheelSample {
    /// The sample of a wheel that did over the whole period what the means say: the extremes are the means, and the grip used follows from
    /// force, load and friction.
    #[must_use]
    pub fn steady(self) -> Self {
        let speed_m_s = self.slip_speed_m_s();
        let limit_n = self.friction * self.normal_force_n;
        Self {
            target_peak_rad_s: self.target_rad_s.abs(),
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

    /// Size of the mean sliding velocity while it touched, in m/s.
    pub fn slip_speed_m_s(&self) -> f64 {
        libm::hypot(self.slip_x_m_s, self.slip_y_m_s)
    }

    /// Size of the mean tangential force of the ground, in N.
    pub fn tangential_force_n(&self) -> f64 {
        libm::hypot(self.force_x_n, self.force_y_n)
    }

    /// [`WheelSample::friction_used_max`]; `None` where nothing pressed or the contact has no friction.
    pub fn friction_used(&self) -> Option<f64> {
        (self.friction * self.normal_force_n > 0.0).then_some(self.friction_used_max)
    }

    /// The largest size of the motor's torque over the period, in N m.
    pub fn torque_peak_n_m(&self) -> f64 {
        self.torque_max_n_m.max(-self.torque_min_n_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wheels_share_is_of_what_wheels_and_chassis_carry_together() {
        let carried = |wheels_n: f64, chassis_n: f64| Support {
            wheels_n,
            chassis_n,
            ..Support::default()
        };
        assert_eq!(carried(30.0, 10.0).wheels_share(), Some(0.75));
        assert_eq!(carried(0.0, 10.0).wheels_share(), Some(0.0));
        assert_eq!(carried(0.0, 0.0).wheels_share(), None);
    }
}
