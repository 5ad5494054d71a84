//! The guidance law of section III: from pose errors to wheel rates within their limit, eqs.
//! (26)-(50).
//!
//! **Frames.** The reference and the errors (16), (17) live in the world frame, and so does K_r. M
//! acts on vectors resolved in the body frame (the paper: "on a common body-fixed frame"). So
//! wherever the paper writes M_l r_d' or M_l K_r e_r, the vector is first rotated into the body
//! frame, by minus the heading.

use ilon_robot::{Pose, Twist, wrap_angle};
use nalgebra::{Matrix2, Vector2};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::{finite, positive};
use crate::guidance::priority::{Priority, Task, TaskShare, share_capacity, sigma};
use crate::{ContactKinematics, ControlError, Desired, Kinematics};

/// Treatment of wheel rates beyond the limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saturation {
    /// The paper's law, eqs. (33), (34): tasks of lower priority are reduced first.
    Prioritised(Priority),
    /// Each wheel is clipped separately, which bends the motion, as in drives that are unaware of
    /// the limit.
    Clip,
    /// All wheels are scaled down together, which keeps the direction of the motion but lets a
    /// low-priority task slow down a high one: the "quick and dirty way out" of section III-D.
    Scale,
    /// No limit: the plain law (26).
    None,
}

/// A task of the guidance.
// For `Guidance::with_tasks`; the comments of the variants are those of the scenario's schema.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum GuidanceTask {
    /// The desired velocity, equation (38).
    PositionFeedforward,
    /// Back to the desired position, equation (39).
    PositionFeedback,
    /// The desired heading rate, equation (40).
    HeadingFeedforward,
    /// Back to the desired heading, equation (41).
    HeadingFeedback,
    /// To look at a point of the world.
    Face {
        /// x of the point, in metres.
        x_m: f64,
        /// y of the point, in metres.
        y_m: f64,
        /// Gain on the angle to it, in 1/s.
        #[serde(default = "GuidanceTask::usual_gain_per_s")]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        gain_per_s: f64,
    },
    /// A constant motion of the reference point in the body frame.
    Twist {
        /// Ahead, in m/s.
        #[serde(default)]
        vx_m_s: f64,
        /// To the left, in m/s.
        #[serde(default)]
        vy_m_s: f64,
        /// Counter-clockwise, in rad/s.
        #[serde(default)]
        omega_rad_s: f64,
    },
}

impl GuidanceTask {
    fn usual_gain_per_s() -> f64 {
        1.0
    }

    /// The task's name in commands and traces.
    pub fn name(&self) -> &'static str {
        match self {
            Self::PositionFeedforward => "position feedforward",
            Self::PositionFeedback => "position feedback",
            Self::HeadingFeedforward => "heading feedforward",
            Self::HeadingFeedback => "heading feedback",
            Self::Face { .. } => "face",
            Self::Twist { .. } => "twist",
        }
    }

    /// The tasks (38)-(41) or (47)-(50).
    fn usual(saturation: Saturation) -> Vec<Self> {
        let position = [Self::PositionFeedforward, Self::PositionFeedback];
        let heading = [Self::HeadingFeedforward, Self::HeadingFeedback];
        match saturation {
            Saturation::Prioritised(Priority::Heading) => [heading, position].concat(),
            _ => [position, heading].concat(),
        }
    }
}

/// The position gain K_r of eq. (23), in 1/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gain {
    /// The same in every direction.
    Scalar(f64),
    /// A symmetric positive definite matrix in the world frame.
    Matrix(Matrix2<f64>),
}

/// Gains and limits of the guidance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuidanceSettings {
    /// K_r of eq. (23), in 1/s.
    pub position_gain: Gain,
    /// K_phi of eq. (24), in 1/s.
    pub heading_gain: f64,
    /// q'_max of eq. (29), the smallest limit of all wheels, in rad/s; infinite for none.
    pub wheel_rate_limit_rad_s: f64,
    /// Treatment of wheel rates beyond the limit.
    pub saturation: Saturation,
}

/// The commanded wheel rates, with the share of each task.
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// q'_d: the wheel rates, in rad/s.
    pub wheel_rates_rad_s: Vec<f64>,
    /// The requested motion of the reference point, all tasks together, in the body frame, before
    /// any limit: (v_c, omega) of eqs. (23), (24).
    pub twist_in_body: Twist,
    /// The motion of the commanded rates, in the body frame: eqs. (42), (43). If the wheels were
    /// clipped separately, the motion that fits the rates best.
    pub saturated_twist_in_body: Twist,
    /// Each task in the order of its priority: its request, capacity and weight. With wheels
    /// clipped separately, or without a limit, the weights are 1.
    pub tasks: Vec<TaskShare>,
    /// Whether a limit on wheel rates took anything of the request.
    pub is_limited: bool,
}

/// The feasibility conditions (36) and (37).
///
/// The paper calls them necessary. They are sufficient: each keeps its feedforward below half of
/// the limit, so that both together fit. A feedforward of 0.6 and one of 0.1 of the limit fit as
/// well, yet break (36).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feasibility {
    /// Left-hand side of (36), in rad/s: the largest wheel rate that the reference velocity may
    /// need, over all headings of the robot.
    pub position_rad_s: f64,
    /// Left-hand side of (37), in rad/s: the largest wheel rate that the reference heading rate
    /// needs.
    pub heading_rad_s: f64,
    /// q'_max, in rad/s: each of the above must stay below half of it.
    pub limit_rad_s: f64,
}

impl Feasibility {
    /// Whether both conditions hold.
    pub fn holds(&self) -> bool {
        let half_rad_s = 0.5 * self.limit_rad_s;
        self.position_rad_s < half_rad_s && self.heading_rad_s < half_rad_s
    }
}

/// The wheel that a reference drives closest to its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelRateAsked {
    /// Its index.
    pub wheel: usize,
    /// Its rate, in rad/s.
    pub rate_rad_s: f64,
    /// Its part of the capacity c_1, in rad/s.
    pub limit_rad_s: f64,
}

impl WheelRateAsked {
    /// Returns the rate over its limit; 0 without a limit.
    pub fn share(&self) -> f64 {
        self.rate_rad_s.abs() / self.limit_rad_s
    }
}

/// The guidance law: trajectory tracking and pose regulation under wheel rate limits.
#[derive(Clone, Debug)]
pub struct Guidance {
    kinematics: Kinematics,
    k_r: Matrix2<f64>,
    k_phi: f64,
    limit_rad_s: f64,
    /// c_1 of eq. (34), in rad/s.
    capacity_rad_s: f64,
    /// Weight of each wheel's rate in the norm of a task: q'_max over the wheel's own limit; 1 if
    /// all limits are equal.
    weights: Vec<f64>,
    saturation: Saturation,
    /// The tasks, highest priority first.
    order: Vec<GuidanceTask>,
    /// Buffer for these tasks.
    tasks: Vec<Task>,
    command: Command,
    /// Wheel rates of all tasks in turn, N numbers per task.
    task_rates: Vec<f64>,
}

impl Guidance {
    /// Builds the law for a robot. The reference point of `kinematics` is the point that follows
    /// the reference.
    ///
    /// # Errors
    /// [`ControlError::PositionGain`], [`ControlError::NotPositive`], [`ControlError::NotFinite`].
    pub fn new(kinematics: Kinematics, settings: &GuidanceSettings) -> Result<Self, ControlError> {
        let k_r = match settings.position_gain {
            Gain::Scalar(gain) => Matrix2::identity() * positive("the position gain in 1/s", gain)?,
            Gain::Matrix(gain) => checked_gain(gain)?,
        };
        let limit_rad_s = match settings.wheel_rate_limit_rad_s {
            f64::INFINITY => f64::INFINITY,
            limit => positive("the wheel rate limit in rad/s", limit)?,
        };
        let count = kinematics.wheel_count();
        Ok(Self {
            kinematics,
            k_r,
            k_phi: positive("the heading gain in 1/s", settings.heading_gain)?,
            limit_rad_s,
            capacity_rad_s: limit_rad_s,
            weights: vec![1.0; count],
            saturation: settings.saturation,
            order: GuidanceTask::usual(settings.saturation),
            tasks: Vec::with_capacity(4),
            command: Command {
                wheel_rates_rad_s: vec![0.0; count],
                twist_in_body: Twist::default(),
                saturated_twist_in_body: Twist::default(),
                tasks: Vec::with_capacity(4),
                is_limited: false,
            },
            task_rates: Vec::with_capacity(4 * count),
        })
    }

    /// Returns the law with a separate limit for each wheel, in rad/s, instead of the common one:
    /// the norm of a task is then that of q'_j / q'max_j, in units of the smallest limit, so that
    /// eqs. (33) to (35) hold for each wheel by its own limit.
    ///
    /// # Errors
    /// [`ControlError::LengthMismatch`], [`ControlError::NotPositive`].
    pub fn with_wheel_limits(mut self, limits_rad_s: &[f64]) -> Result<Self, ControlError> {
        let count = self.kinematics.wheel_count();
        if limits_rad_s.len() != count {
            return Err(ControlError::LengthMismatch {
                left: "limits of wheel rates",
                left_count: limits_rad_s.len(),
                right: "wheels",
                right_count: count,
            });
        }
        for limit_rad_s in limits_rad_s {
            positive("a wheel's rate limit in rad/s", *limit_rad_s)?;
        }
        self.limit_rad_s = limits_rad_s.iter().copied().fold(f64::INFINITY, f64::min);
        let of_least = |limit_rad_s: &f64| self.limit_rad_s / limit_rad_s;
        self.weights = limits_rad_s.iter().map(of_least).collect();
        self.capacity_rad_s = self.limit_rad_s;
        Ok(self)
    }

    /// Returns the law with a smaller capacity to share among the tasks than the wheels' limit: c_1
    /// of eq. (34), in rad/s. The rest is for other commands of the wheels. It only affects
    /// [`Saturation::Prioritised`].
    ///
    /// # Errors
    /// [`ControlError::NotPositive`]; [`ControlError::TooLarge`] beyond the limit.
    pub fn with_capacity(mut self, capacity_rad_s: f64) -> Result<Self, ControlError> {
        let what = "the capacity of the tasks in rad/s";
        let value = positive(what, capacity_rad_s)?;
        if value > self.limit_rad_s {
            return Err(ControlError::TooLarge {
                what: what.to_owned(),
                value,
                most: self.limit_rad_s,
            });
        }
        self.capacity_rad_s = value;
        Ok(self)
    }

    /// Returns the law with any tasks, each once, in the order of their priority, instead of the
    /// four of [`GuidanceSettings::saturation`]: eqs. (32) to (34). Tasks left out are not served.
    ///
    /// # Errors
    /// [`ControlError::NoTasks`]; [`ControlError::TwiceATask`] with the name of a repeated task;
    /// [`ControlError::NotPositive`] and [`ControlError::NotFinite`] for the tasks' values.
    pub fn with_tasks(mut self, tasks: &[GuidanceTask]) -> Result<Self, ControlError> {
        if tasks.is_empty() {
            return Err(ControlError::NoTasks);
        }
        for (place, task) in tasks.iter().enumerate() {
            let name = task.name();
            if tasks[..place].iter().any(|before| before.name() == name) {
                return Err(ControlError::TwiceATask { task: name });
            }
            match task {
                GuidanceTask::Face {
                    x_m,
                    y_m,
                    gain_per_s,
                } => {
                    finite("x of the point to face, in m", *x_m)?;
                    finite("y of the point to face, in m", *y_m)?;
                    positive("the gain on the angle to a point, in 1/s", *gain_per_s)?;
                }
                GuidanceTask::Twist {
                    vx_m_s,
                    vy_m_s,
                    omega_rad_s,
                } => {
                    finite("vx of a task, in m/s", *vx_m_s)?;
                    finite("vy of a task, in m/s", *vy_m_s)?;
                    finite("the yaw rate of a task, in rad/s", *omega_rad_s)?;
                }
                _ => {}
            }
        }
        self.order = tasks.to_vec();
        self.tasks = Vec::with_capacity(tasks.len());
        Ok(self)
    }

    /// The kinematics in use.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Continues with other kinematics: those of the same robot after its wheels moved on the body.
    /// The point that follows the reference stays.
    ///
    /// # Errors
    /// [`ControlError::LengthMismatch`] for a different number of wheels.
    pub fn stand(&mut self, kinematics: &Kinematics) -> Result<(), ControlError> {
        let (count, given) = (self.kinematics.wheel_count(), kinematics.wheel_count());
        if given != count {
            return Err(ControlError::LengthMismatch {
                left: "wheels of the kinematics",
                left_count: given,
                right: "wheels",
                right_count: count,
            });
        }
        self.kinematics = kinematics.about(self.kinematics.reference_point_m())?;
        Ok(())
    }

    /// Returns wheel rates for the estimated pose of the body frame and the desired motion of the
    /// reference point.
    pub fn update(&mut self, seen: &Pose, desired: &Desired) -> &Command {
        self.update_by(seen, desired, None)
    }

    /// Like [`Self::update`], with the wheel rates computed for the touching rollers at the wheel
    /// angles of the last [`ContactKinematics::update`], which cancels the ripple of few rollers.
    /// The limit still holds.
    pub fn update_on_contact(
        &mut self,
        seen: &Pose,
        desired: &Desired,
        contact: &ContactKinematics,
    ) -> &Command {
        self.update_by(seen, desired, Some(contact))
    }

    fn update_by(
        &mut self,
        seen: &Pose,
        desired: &Desired,
        contact: Option<&ContactKinematics>,
    ) -> &Command {
        let mut tasks = std::mem::take(&mut self.tasks);
        tasks.clear();
        tasks.extend(self.order.iter().map(|task| Task {
            name: task.name(),
            twist_in_body: self.asked(task, seen, desired),
        }));
        self.combine(&tasks, contact);
        self.tasks = tasks;
        &self.command
    }

    /// Returns wheel rates for any tasks in the order of their priority: eqs. (32)-(34) for n
    /// tasks. It allocates once if there are more tasks than ever before.
    pub fn command(&mut self, tasks: &[Task]) -> &Command {
        self.combine(tasks, None)
    }

    /// Like [`Self::command`], with the wheel rates of [`Self::update_on_contact`].
    pub fn command_on_contact(&mut self, tasks: &[Task], contact: &ContactKinematics) -> &Command {
        self.combine(tasks, Some(contact))
    }

    /// Returns the left-hand sides of (36) and (37) for a reference speed in m/s and heading rate
    /// in rad/s.
    ///
    /// M_l acts in the body frame, so the wheel rates of a reference velocity depend on the robot's
    /// heading. The result is the largest over all headings: |row h of M_l| is 1, hence
    /// |r_d'| / (rho_h |cos gamma_h|).
    pub fn feasibility(&self, speed_m_s: f64, heading_rate_rad_s: f64) -> Feasibility {
        let rates = self.kinematics.rate_matrix();
        let worst = |of: &dyn Fn(f64, f64, f64) -> f64| {
            rates
                .row_iter()
                .zip(&self.weights)
                .map(|(row, weight)| weight * of(row[0], row[1], row[2]))
                .fold(0.0, f64::max)
        };
        Feasibility {
            position_rad_s: worst(&|x, y, _| libm::hypot(x, y)) * speed_m_s.abs(),
            heading_rad_s: worst(&|_, _, a| a.abs()) * heading_rate_rad_s.abs(),
            limit_rad_s: self.capacity_rad_s,
        }
    }

    /// Returns the wheel closest to its limit when the robot follows the reference without error,
    /// || M_l r_d' + M_a phi_d' ||. (36) and (37) are sufficient for its share to stay below 1,
    /// which is their purpose.
    pub fn feedforward(&self, desired: &Desired) -> WheelRateAsked {
        let twist = desired.velocity_in_world.rotated(-desired.pose.heading_rad);
        let rows = self.kinematics.rate_matrix().row_iter().zip(&self.weights);
        let each = rows
            .enumerate()
            .map(|(wheel, (row, weight))| WheelRateAsked {
                wheel,
                rate_rad_s: row[0] * twist.vx_m_s
                    + row[1] * twist.vy_m_s
                    + row[2] * twist.omega_rad_s,
                limit_rad_s: self.capacity_rad_s / weight,
            });
        let none = WheelRateAsked {
            wheel: 0,
            rate_rad_s: 0.0,
            limit_rad_s: f64::INFINITY,
        };
        each.fold(none, |most, asked| {
            if asked.share() > most.share() {
                asked
            } else {
                most
            }
        })
    }

    /// The names of the tasks of a reference, highest priority first.
    pub fn task_names(&self) -> impl ExactSizeIterator<Item = &'static str> {
        self.order.iter().map(GuidanceTask::name)
    }

    /// Returns the request of a task, (38)-(41) or (47)-(50), as a twist of the reference point in
    /// the body frame.
    fn asked(&self, task: &GuidanceTask, seen: &Pose, desired: &Desired) -> Twist {
        let phi = seen.heading_rad;
        // r_c: the reference point in the world frame.
        let r_c = || {
            let arm = self.kinematics.reference_point_m();
            let (s, c) = libm::sincos(phi);
            seen.position_m() + Vector2::new(c * arm.x - s * arm.y, s * arm.x + c * arm.y)
        };
        let linear_in_body = |v: Vector2<f64>| Twist::new(v.x, v.y, 0.0).rotated(-phi);
        // Heading errors are wrapped to the shorter way round.
        match task {
            GuidanceTask::PositionFeedforward => {
                linear_in_body(desired.velocity_in_world.linear_m_s())
            }
            GuidanceTask::PositionFeedback => {
                // Eq. (16).
                let e_r = desired.pose.position_m() - r_c();
                linear_in_body(self.k_r * e_r)
            }
            GuidanceTask::HeadingFeedforward => {
                Twist::new(0.0, 0.0, desired.velocity_in_world.omega_rad_s)
            }
            GuidanceTask::HeadingFeedback => {
                // Eq. (17).
                let e_phi = wrap_angle(desired.pose.heading_rad - phi);
                Twist::new(0.0, 0.0, self.k_phi * e_phi)
            }
            GuidanceTask::Face {
                x_m,
                y_m,
                gain_per_s,
            } => {
                let to = Vector2::new(*x_m, *y_m) - r_c();
                // At the point itself there is no direction to face.
                let angle = match to.norm() > 0.0 {
                    true => wrap_angle(libm::atan2(to.y, to.x) - phi),
                    false => 0.0,
                };
                Twist::new(0.0, 0.0, gain_per_s * angle)
            }
            GuidanceTask::Twist {
                vx_m_s,
                vy_m_s,
                omega_rad_s,
            } => Twist::new(*vx_m_s, *vy_m_s, *omega_rad_s),
        }
    }

    /// Combines the wheel rates of the tasks by eq. (33), or by one of its alternatives.
    fn combine(&mut self, tasks: &[Task], contact: Option<&ContactKinematics>) -> &Command {
        let count = self.kinematics.wheel_count();
        let (q_max, weights) = (self.limit_rad_s, &self.weights);
        let command = &mut self.command;
        self.task_rates.resize(tasks.len() * count, 0.0);
        command.tasks.clear();
        command.twist_in_body = Twist::default();
        let map = RateMap {
            kinematics: &self.kinematics,
            contact,
        };

        // q'_h of each task, eqs. (38)-(41) or (47)-(50), and its infinity norm.
        for (task, rates) in tasks.iter().zip(self.task_rates.chunks_mut(count)) {
            map.wheel_rates(task.twist_in_body, rates);
            command.twist_in_body = command.twist_in_body + task.twist_in_body;
            command.tasks.push(TaskShare {
                name: task.name,
                twist_in_body: task.twist_in_body,
                asked_rad_s: infinity_norm(rates, weights),
                capacity_rad_s: self.capacity_rad_s,
                weight: 1.0,
            });
        }

        match self.saturation {
            Saturation::Prioritised(_) => {
                share_capacity(self.capacity_rad_s, &mut command.tasks);
            }
            Saturation::Scale => {
                map.wheel_rates(command.twist_in_body, &mut command.wheel_rates_rad_s);
                let asked_rad_s = infinity_norm(&command.wheel_rates_rad_s, weights);
                // A task without a request is not held back: weight 1, unlike sigma(0, c).
                let weight = if asked_rad_s == 0.0 {
                    1.0
                } else {
                    sigma(asked_rad_s, q_max)
                };
                for share in &mut command.tasks {
                    share.weight = weight;
                }
            }
            Saturation::Clip | Saturation::None => {}
        }

        command.is_limited = command.tasks.iter().any(TaskShare::is_saturated);

        // Eq. (33). A task that is not finite (from a pose with NaN) is left out.
        command.wheel_rates_rad_s.fill(0.0);
        command.saturated_twist_in_body = Twist::default();
        let shares = command.tasks.iter_mut();
        for ((share, task), rates) in shares.zip(tasks).zip(self.task_rates.chunks(count)) {
            if !share.asked_rad_s.is_finite() {
                share.weight = 0.0;
                continue;
            }
            // Of steered wheels that stand across a motion none turns: nothing limits it.
            let granted = match share.asked_rad_s {
                0.0 => 1.0,
                _ => share.weight,
            };
            let weighted = task.twist_in_body.scaled(granted);
            command.saturated_twist_in_body = command.saturated_twist_in_body + weighted;
            for (sum, rate) in command.wheel_rates_rad_s.iter_mut().zip(rates) {
                *sum += share.weight * rate;
            }
        }
        if self.saturation != Saturation::None {
            // For Clip this is the law. For the others (35) holds already, and this only removes
            // the last rounding.
            let before = infinity_norm(&command.wheel_rates_rad_s, weights);
            for (rate, weight) in command.wheel_rates_rad_s.iter_mut().zip(weights) {
                let limit_rad_s = q_max / weight;
                *rate = rate.clamp(-limit_rad_s, limit_rad_s);
            }
            if self.saturation == Saturation::Clip && before > q_max {
                command.is_limited = true;
                command.saturated_twist_in_body = map.twist(&command.wheel_rates_rad_s);
            }
        }
        command
    }
}

/// How a twist of the guidance's reference point maps to wheel rates.
struct RateMap<'a> {
    kinematics: &'a Kinematics,
    contact: Option<&'a ContactKinematics>,
}

impl RateMap<'_> {
    /// From the guidance's reference point to the one of the contact kinematics, in the body frame.
    fn offset_m(&self, contact: &ContactKinematics) -> Vector2<f64> {
        contact.reference_point_m() - self.kinematics.reference_point_m()
    }

    fn wheel_rates(&self, twist_in_body: Twist, out: &mut [f64]) {
        match self.contact {
            None => self.kinematics.wheel_rates(twist_in_body, out),
            Some(contact) => {
                let there = twist_in_body.at(self.offset_m(contact));
                contact.wheel_rates_here(there, out);
            }
        }
    }

    fn twist(&self, rates_rad_s: &[f64]) -> Twist {
        match self.contact {
            None => self.kinematics.twist(rates_rad_s),
            Some(contact) => contact.twist_here(rates_rad_s).at(-self.offset_m(contact)),
        }
    }
}

/// Returns the largest weighted amount; not finite if any of them is not.
fn infinity_norm(rates: &[f64], weights: &[f64]) -> f64 {
    let weighted = rates
        .iter()
        .zip(weights)
        .map(|(rate, weight)| rate * weight);
    weighted.fold(0.0, |norm: f64, rate| {
        // f64::max would drop a NaN.
        if rate.is_nan() {
            f64::NAN
        } else if norm.is_nan() {
            norm
        } else {
            norm.max(rate.abs())
        }
    })
}

/// Returns K_r if it is symmetric positive definite, as eq. (21) needs.
fn checked_gain(gain: Matrix2<f64>) -> Result<Matrix2<f64>, ControlError> {
    for value in gain.iter() {
        finite("an entry of the position gain in 1/s", *value)?;
    }
    let symmetric = (gain.m12 - gain.m21).abs() <= 1e-9 * gain.norm();
    if symmetric && gain.m11 > 0.0 && gain.determinant() > 0.0 {
        return Ok(gain);
    }
    Err(ControlError::PositionGain {
        xx: gain.m11,
        xy: gain.m12,
        yx: gain.m21,
        yy: gain.m22,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::robots::{mecanum4, six_wheels, volksbot};

    fn settings(saturation: Saturation, wheel_rate_limit_rad_s: f64) -> GuidanceSettings {
        GuidanceSettings {
            position_gain: Gain::Scalar(1.0),
            heading_gain: 1.0,
            wheel_rate_limit_rad_s,
            saturation,
        }
    }

    #[test]
    fn on_contact_the_limit_holds_and_the_touching_rollers_roll_the_weighted_twist() {
        let seen = Pose {
            x_m: 0.2,
            y_m: -0.4,
            heading_rad: 0.7,
        };
        let desired = Desired {
            pose: Pose {
                x_m: 1.0,
                y_m: 0.6,
                heading_rad: -1.0,
            },
            velocity_in_world: Twist::new(0.1, 0.05, 0.2),
        };
        for robot in [mecanum4(), six_wheels(), volksbot()] {
            // The guidance has its own reference point, the contact kinematics the body frame's
            // origin.
            let point = Vector2::new(0.1, 0.05);
            let kinematics = Kinematics::new(&robot).unwrap().about(point).unwrap();
            let first = Saturation::Prioritised(Priority::Position);
            let mut guidance = Guidance::new(kinematics, &settings(first, 8.7)).unwrap();
            let mut contact = ContactKinematics::new(&robot).unwrap();
            let n = robot.wheels.len();
            for k in 0..300 {
                let angles: Vec<f64> = (0..n).map(|h| 0.031 * (k * (h + 2)) as f64).collect();
                contact.update(&angles);
                let command = guidance.update_on_contact(&seen, &desired, &contact);
                let rates = &command.wheel_rates_rad_s;
                assert!(rates.iter().all(|rate| rate.abs() <= 8.7));
                let of_point = contact.twist_here(rates).at(point);
                let off = of_point - command.saturated_twist_in_body;
                assert!(off.linear_m_s().norm() < 1e-12 && off.omega_rad_s.abs() < 1e-11);
                assert!(command.tasks.iter().any(TaskShare::is_saturated));
            }
        }
    }

    /// With unequal limits none is exceeded, the binding one is fully used, and a wheel with a
    /// higher limit turns faster.
    #[test]
    fn eq_35_holds_for_each_wheel_by_its_own_limit() {
        let first = Saturation::Prioritised(Priority::Position);
        let kinematics = Kinematics::new(&volksbot()).unwrap();
        let limits = [4.0, 9.0, 6.0];
        let law = Guidance::new(kinematics, &settings(first, 5.0)).unwrap();
        let mut law = law.with_wheel_limits(&limits).unwrap();
        let (mut used_up, mut beyond_least) = (0, 0);
        for k in 0..500 {
            let x = |i: u32| 4.0 * (((k * i) as f64 * 0.754_877_666).fract() - 0.5);
            let task = |name, twist_in_body| Task {
                name,
                twist_in_body,
            };
            let tasks = [
                task("first", Twist::new(0.2 * x(1), 0.2 * x(2), 0.0)),
                task("second", Twist::new(0.0, 0.0, 3.0 * x(3))),
            ];
            let command = law.command(&tasks);
            let rates = &command.wheel_rates_rad_s;
            for (rate, limit) in rates.iter().zip(limits) {
                assert!(rate.abs() <= limit);
                beyond_least += usize::from(rate.abs() > 4.0);
            }
            let asked: f64 = command.tasks[0].asked_rad_s;
            let share = rates
                .iter()
                .zip(limits)
                .map(|(rate, limit)| rate.abs() / limit);
            used_up += usize::from(share.fold(0.0, f64::max) > 1.0 - 1e-12);
            // The first task comes first by the same norm.
            assert_eq!(command.tasks[0].weight, sigma(asked, 4.0));
        }
        assert!(used_up > 5 && beyond_least > 50, "{used_up} {beyond_least}");
    }

    /// c_1 below the limit is the capacity for all tasks together.
    #[test]
    fn eq_34_a_capacity_below_the_limit_leaves_the_rest() {
        let first = Saturation::Prioritised(Priority::Position);
        let kinematics = Kinematics::new(&mecanum4()).unwrap();
        let law = Guidance::new(kinematics, &settings(first, 10.0)).unwrap();
        let mut part = law.clone().with_capacity(6.0).unwrap();
        let tasks = [Task {
            name: "only",
            twist_in_body: Twist::new(3.0, 1.0, 2.0),
        }];
        let command = part.command(&tasks);
        let most = command
            .wheel_rates_rad_s
            .iter()
            .fold(0.0, |most: f64, q| most.max(q.abs()));
        assert!((most - 6.0).abs() < 1e-12, "{most}");
        assert_eq!(command.tasks[0].capacity_rad_s, 6.0);
        assert!(law.clone().with_capacity(10.1).is_err());
        assert!(law.with_capacity(0.0).is_err());
    }

    #[test]
    fn settings_that_make_no_law_are_refused_by_name() {
        let kinematics = Kinematics::new(&volksbot()).unwrap();
        let message = |settings: &GuidanceSettings| {
            Guidance::new(kinematics.clone(), settings)
                .unwrap_err()
                .to_string()
        };
        let good = settings(Saturation::Scale, 8.7);
        assert_eq!(
            message(&GuidanceSettings {
                wheel_rate_limit_rad_s: 0.0,
                ..good
            }),
            "the wheel rate limit in rad/s is 0; it must be finite and above zero"
        );
        assert_eq!(
            message(&GuidanceSettings {
                heading_gain: -1.0,
                ..good
            }),
            "the heading gain in 1/s is -1; it must be finite and above zero"
        );
        assert_eq!(
            message(&GuidanceSettings {
                position_gain: Gain::Matrix(Matrix2::new(1.0, 2.0, 2.0, 1.0)),
                ..good
            }),
            "the position gain [[1, 2], [2, 1]] must be symmetric and positive definite"
        );
    }

    /// The velocity of a point of the body equals the difference quotient of its position x +
    /// R(theta) offset.
    #[test]
    fn eq_2_a_point_of_the_body_moves_with_its_rotation() {
        let (twist, offset_m) = (Twist::new(0.3, -0.2, 1.5), Vector2::new(0.1, 0.05));
        let place = |t_s: f64| {
            let turn = nalgebra::Rotation2::new(twist.omega_rad_s * t_s);
            Vector2::new(twist.vx_m_s, twist.vy_m_s) * t_s + turn * offset_m
        };
        let dt_s = 1e-5;
        let velocity = (place(dt_s) - place(-dt_s)) / (2.0 * dt_s);
        let there = twist.at(offset_m);
        // The central difference has an error of omega^3 |offset| dt^2 / 6, some 1e-11.
        assert!((there.vx_m_s - velocity.x).abs() < 1e-9);
        assert!((there.vy_m_s - velocity.y).abs() < 1e-9);
        assert_eq!(there.omega_rad_s, 1.5);
    }
}
