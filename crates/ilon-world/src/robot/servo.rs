//! Servos in joints: what drives arms, lifts and turrets.
//!
//! A servo of stiffness K and damping D acts with K (q_t - q) + D (u_t - u), q_t its target and u_t how fast that moves, within its effort. In a
//! step it is taken in the middle, where the joint is at q_0 + dt (u_0 + u_1) / 4: a straight line in what the joint gains, F_0 - S (u_1 - u_0)
//! with S = K dt / 4 + theta D, solved with the masses as a motor's is. theta is 1/2 in short steps and nears 1 in long ones
//! ([`ilon_robot::mean_of_gain`]), so that any damping is stable. Where the effort bounds it within the step, what is missing from the line is a
//! curve among the reactions. Its target follows where it shall be, at its rate limit at most. A servo that is given an effort acts with that alone.

use ilon_robot::{BodyJoint, JointServo, mean_of_gain};

use crate::contact::law::Curve;
use crate::{MotorTorque, TorqueBounds};

/// The servo of a joint, or what there is in its place where a joint has none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Servo {
    /// Where its target shall be, and how fast it moves then: in rad and rad/s, or m and m/s.
    pub aim: [f64; 2],
    /// Where it is, and how fast it moves.
    pub target: [f64; 2],
    /// The same when the last step began.
    began: [f64; 2],
    /// What it acts with in place of going there, in N m or N.
    pub effort: Option<f64>,
    /// What the joint moves by itself, in kg m^2 or kg.
    inertia: f64,
    /// What it does in a step, in N m or N, within its effort.
    pub law: MotorTorque,
    /// The same as far as it is straight, which is solved with the masses.
    pub straight: MotorTorque,
    /// Its impulse over the last step, in N m s or N s.
    pub impulse: f64,
}

impl Servo {
    /// Of a joint that moves an inertia.
    pub fn of(joint: &BodyJoint, inertia: f64) -> Self {
        let at = joint.servo().map_or(0.0, |servo| servo.target);
        Self {
            aim: [at, 0.0],
            target: [at, 0.0],
            began: [at, 0.0],
            effort: None,
            inertia,
            law: MotorTorque::constant(0.0),
            straight: MotorTorque::constant(0.0),
            impulse: 0.0,
        }
    }

    /// Moves the target on for a step, no faster than the servo lets it.
    pub fn follow(&mut self, servo: &JointServo, dt_s: f64) {
        self.began = self.target;
        let by = self.aim[0] - self.target[0];
        let most = servo.rate_limit * dt_s;
        self.target = if by.abs() <= most {
            let most = servo.rate_limit;
            [self.aim[0], self.aim[1].clamp(-most, most)]
        } else {
            [
                self.target[0] + most.copysign(by),
                servo.rate_limit.copysign(by),
            ]
        };
    }

    /// Goes back to where the target was when the last step began, to take the step anew.
    pub fn begin_again(&mut self) {
        self.target = self.began;
    }

    /// Takes what the servo does in a step of a joint at a position with a rate.
    pub fn act(&mut self, servo: &JointServo, (position, rate): (f64, f64), dt_s: f64) {
        if let Some(effort) = self.effort {
            self.law = MotorTorque::constant(effort.clamp(-servo.effort, servo.effort));
            self.straight = self.law.straight();
            return;
        }
        let half = 0.5 * dt_s;
        let theta = mean_of_gain(servo.damping * dt_s / self.inertia);
        let force = servo.stiffness * (self.target[0] - position - half * rate)
            + servo.damping * (self.target[1] - rate);
        let droop = 0.5 * half * servo.stiffness + theta * servo.damping;
        self.take(servo, force, droop);
    }

    /// The same of a joint that does not move yet, at the end of the step: it comes to rest where it stands in equilibrium.
    pub fn act_to_rest(&mut self, servo: &JointServo, position: f64, dt_s: f64) {
        let force = servo.stiffness * (self.target[0] - position);
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

    /// Fills in what its effort leaves of the straight line over a step, of a joint that begins it at a rate.
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

    /// Takes up its impulse over a step in which the joint gained a rate, as far as it is straight.
    pub fn count_straight(&mut self, gained: f64, dt_s: f64) {
        self.impulse = (self.straight.torque_n_m - self.straight.droop_n_m_s * gained) * dt_s;
    }
}
