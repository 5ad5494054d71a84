//! Servos in joints: they drive arms, lifts and turrets.
//!
//! A servo of stiffness K and damping D acts with K (q_t - q) + D (u_t - u), q_t its target and u_t
//! the target's rate, within its effort. In a step this is evaluated in the middle, where the joint
//! is at q_0 + dt (u_0 + u_1) / 4: linear in the rate gained, the force is F_0 - S (u_1 - u_0), S =
//! K dt / 4 + theta D, solved with the masses like a motor. theta is 1/2 in short steps and
//! approaches 1 in long ones ([`ilon_robot::mean_of_gain`]), so that any damping is stable. If the
//! effort limits it within the step, the difference from the line is a curve among the reactions. A
//! servo with a commanded effort acts with that alone.
//!
//! **The target.** A servo is aimed once a step, through a position in the step's middle with a rate
//! and an acceleration. The target follows that curve, no faster than the rate limit, and each part
//! of a step uses the target in the middle of that part: a step taken in parts ends at the same
//! target as a whole one.

use ilon_robot::{BodyJoint, JointServo, TorqueBounds, mean_of_gain};

use crate::MotorTorque;
use crate::contact::law::Curve;

/// The servo of a joint, or a placeholder for a joint without one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Servo {
    /// The aim of its target in the middle of a step, the aim's rate and its acceleration: in rad,
    /// rad/s and rad/s^2, or m, m/s and m/s^2.
    pub aim: [f64; 3],
    /// Its target after the last step, in rad or m.
    pub target: f64,
    /// Whether its rate limit keeps the target behind the aim.
    is_late: bool,
    /// Both at the beginning of the last part of a step.
    began: (f64, bool),
    /// A commanded effort instead of a target, in N m or N.
    pub effort: Option<f64>,
    /// The joint's own inertia, in kg m^2 or kg.
    inertia: f64,
    /// Its action in a step, in N m or N, within its effort.
    pub law: MotorTorque,
    /// The linear part of it, which is solved with the masses.
    pub straight: MotorTorque,
    /// Its impulse over the last step, in N m s or N s.
    pub impulse: f64,
}

impl Servo {
    /// For a joint with an inertia.
    pub fn of(joint: &BodyJoint, inertia: f64) -> Self {
        let at = joint.servo().map_or(0.0, |servo| servo.target);
        Self {
            aim: [at, 0.0, 0.0],
            target: at,
            is_late: false,
            began: (at, false),
            effort: None,
            inertia,
            law: MotorTorque::constant(0.0),
            straight: MotorTorque::constant(0.0),
            impulse: 0.0,
        }
    }

    /// Advances the target over a part of a step, whose middle is at a time from the step's middle
    /// in seconds, within the servo's rate limit. Returns the target in the middle of the part, and
    /// its rate.
    pub fn follow(&mut self, servo: &JointServo, (middle_s, dt_s): (f64, f64)) -> [f64; 2] {
        self.began = (self.target, self.is_late);
        let (end, limit) = (self.aim_at(middle_s + 0.5 * dt_s), servo.rate_limit);
        let (by, most) = (end - self.target, limit * dt_s);
        let was_late = std::mem::replace(&mut self.is_late, by.abs() > most);
        if was_late || self.is_late {
            // It lags until then, also in a part that ends where it reaches the aim.
            let by = by.clamp(-most, most);
            let middle = self.target + 0.5 * by;
            self.target += by;
            return [middle, by / dt_s];
        }
        self.target = end;
        let rate = self.aim_rate_at(middle_s).clamp(-limit, limit);
        [self.aim_at(middle_s), rate]
    }

    /// Returns the target to the beginning of the last part of a step, to repeat it.
    pub fn begin_again(&mut self) {
        (self.target, self.is_late) = self.began;
    }

    /// The aim at a time from the step's middle, in seconds.
    fn aim_at(&self, from_middle_s: f64) -> f64 {
        let [position, rate, acceleration] = self.aim;
        position + (rate + 0.5 * acceleration * from_middle_s) * from_middle_s
    }

    fn aim_rate_at(&self, from_middle_s: f64) -> f64 {
        self.aim[1] + self.aim[2] * from_middle_s
    }

    /// The time in seconds, from a time relative to the step's middle, until a target delayed by
    /// its rate limit reaches its aim.
    pub fn catches_up_s(&self, servo: &JointServo, from_middle_s: f64) -> Option<f64> {
        let behind = self.aim_at(from_middle_s) - self.target;
        let closes = servo.rate_limit - self.aim_rate_at(from_middle_s) * behind.signum();
        (self.is_late && closes > 0.0).then(|| behind.abs() / closes)
    }

    /// Computes the servo's action in a part of a step, given the target's position and rate, and
    /// the joint's at its beginning.
    pub fn act(
        &mut self,
        servo: &JointServo,
        target: [f64; 2],
        (position, rate): (f64, f64),
        dt_s: f64,
    ) {
        if let Some(effort) = self.effort {
            self.law = MotorTorque::constant(effort.clamp(-servo.effort, servo.effort));
            self.straight = self.law.straight();
            return;
        }
        let half = 0.5 * dt_s;
        let theta = mean_of_gain(servo.damping * dt_s / self.inertia);
        let force = servo.stiffness * (target[0] - position - half * rate)
            + servo.damping * (target[1] - rate);
        let droop = 0.5 * half * servo.stiffness + theta * servo.damping;
        self.take(servo, force, droop);
    }

    /// The same for a joint at rest, at the end of the step: it comes to rest at its equilibrium.
    pub fn act_to_rest(&mut self, servo: &JointServo, position: f64, dt_s: f64) {
        let force = servo.stiffness * (self.target - position);
        self.take(servo, force, servo.stiffness * dt_s);
    }

    fn take(&mut self, servo: &JointServo, force: f64, droop: f64) {
        self.law = MotorTorque {
            bounds: TorqueBounds {
                limit_n_m: servo.effort,
                ..TorqueBounds::NONE
            },
            ..MotorTorque::with_droop(force, droop)
        };
        self.straight = self.law.straight();
    }

    /// Writes the difference between its effort limit and the straight line over a step, for a
    /// joint with a rate at its beginning.
    pub fn fill_curve(&self, rate: f64, dt_s: f64, curve: &mut Curve) {
        let (line, straight) = (&self.law, &self.straight);
        let limit = line.bounds.limit_n_m;
        let missing = |gained: f64| {
            let solved = straight.torque_n_m - straight.droop_n_m_s * gained;
            dt_s * (line.at_gain(gained) - solved)
        };
        curve.points.clear();
        for bound in [limit, -limit] {
            let gained = (line.torque_n_m - bound) / line.droop_n_m_s;
            curve.points.push([rate + gained, missing(gained)]);
        }
        // At its effort it does not fall.
        curve.ends = [[1.0, dt_s * straight.droop_n_m_s]; 2];
    }

    /// Sets its impulse over a step in which the joint gained a rate, for the linear part.
    pub fn count_straight(&mut self, gained: f64, dt_s: f64) {
        self.impulse = (self.straight.torque_n_m - self.straight.droop_n_m_s * gained) * dt_s;
    }
}
