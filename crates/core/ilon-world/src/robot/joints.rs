//! Springs and dampers in the joints between a robot's bodies, integrated over a step so that they
//! are stable for any length of it.
//!
//! **In a step** a spring of stiffness k and a damper c act with the position and rate in its
//! middle. With q_0 and u_0 the joint's position and rate at the beginning of the step, and u_1 the
//! rate at its end, the middle is at q_0 + dt (u_0 + u_1) / 4, and the force is linear in the rate
//! gained, like a motor's: F_0 - D (u_1 - u_0), with F_0 the force without gain and D = k dt / 4 +
//! c / 2. The joint advances by dt (u_0 + u_1) / 2, so that the work of the force is to the last
//! digit the energy returned by the spring and taken by the damper.

use ilon_robot::{BodyJoint, JointKind};

use crate::dynamics::ROOT_DOFS;
use crate::robot::articulated::Articulated;

/// The force in a joint over a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JointForce {
    /// Without gain of rate, in N m or N.
    pub force: f64,
    /// Decrease per rate gained, in N m s/rad or N s/m.
    pub droop: f64,
}

/// A joint beyond its stop by this share of its unit within a step has hit it. Chosen.
const BEYOND: f64 = 1e-6;

impl JointForce {
    /// For a joint at a position with a rate, over a time in seconds.
    pub fn over(joint: &BodyJoint, (position, rate): (f64, f64), dt_s: f64) -> Self {
        let half = 0.5 * dt_s;
        let stiffness = joint.spring().map_or(0.0, |spring| spring.stiffness);
        let spring = (joint.spring()).map_or(0.0, |spring| spring.force_at(position + half * rate));
        Self {
            force: spring - joint.damping * rate,
            droop: 0.5 * (half * stiffness + joint.damping),
        }
    }

    /// For a joint at rest, evaluated at the end of the step: it comes to rest at its equilibrium.
    pub fn to_rest(joint: &BodyJoint, position: f64, dt_s: f64) -> Self {
        Self {
            force: (joint.spring()).map_or(0.0, |spring| spring.force_at(position)),
            droop: joint.spring().map_or(0.0, |spring| spring.stiffness) * dt_s,
        }
    }
}

impl Articulated {
    /// Sets the target of a joint's servo in the middle of the coming step, its rate and its
    /// acceleration; returns whether the joint has a servo.
    pub fn aim(&mut self, joint: usize, aim: [f64; 3]) -> bool {
        let is_driven = self.robot.joints[joint].servo().is_some();
        if is_driven {
            self.servos[joint].aim = aim;
            self.servos[joint].effort = None;
        }
        is_driven
    }

    /// Sets the effort of a joint's servo, in N m or N, instead of a target; returns whether the
    /// joint has a servo. Its target stays at the joint's position.
    pub fn load_joint(&mut self, joint: usize, effort: f64) -> bool {
        let is_driven = self.robot.joints[joint].servo().is_some();
        if is_driven {
            let at = self.state.joint_positions()[joint];
            let servo = &mut self.servos[joint];
            (servo.aim, servo.target, servo.effort) = ([at, 0.0, 0.0], at, Some(effort));
        }
        is_driven
    }

    /// The time in seconds until the first of the lagging targets reaches its aim; infinite if none
    /// lags.
    pub fn catches_up_s(&self) -> f64 {
        let joints = self.robot.joints.iter().zip(&self.servos);
        let servos = joints.filter_map(|(joint, own)| Some((joint.servo()?, own)));
        let times_s =
            servos.filter_map(|(of, own)| own.catches_up_s(of, self.command.from_middle_s));
        times_s.fold(f64::INFINITY, f64::min)
    }

    /// Computes the servos' actions in a part of a step.
    pub fn run_servos(&mut self, dt_s: f64) {
        let middle_s = self.command.from_middle_s + 0.5 * dt_s;
        for (index, joint) in self.robot.joints.iter().enumerate() {
            let Some(servo) = joint.servo() else {
                continue;
            };
            let position = self.step.before.joint_positions()[index];
            let rate = self.step.before.joint_rates()[index];
            let own = &mut self.servos[index];
            if self.is_settling {
                own.act_to_rest(servo, position, dt_s);
            } else {
                let target = own.follow(servo, (middle_s, dt_s));
                own.act(servo, target, (position, rate), dt_s);
            }
        }
    }

    /// Sets the forces of springs, dampers and servos in the step, and their decrease as their
    /// joints gain rate.
    pub fn load_joints(&mut self, dt_s: f64) {
        self.run_servos(dt_s);
        for (index, joint) in self.robot.joints.iter().enumerate() {
            let position = self.step.before.joint_positions()[index];
            let acts = if self.is_settling {
                JointForce::to_rest(joint, position, dt_s)
            } else {
                JointForce::over(
                    joint,
                    (position, self.step.before.joint_rates()[index]),
                    dt_s,
                )
            };
            let servo = &self.servos[index].straight;
            self.step.loads.in_joints[index] = acts.force + servo.torque_n_m;
            self.step.held_n_m_s2[index] = (acts.droop + servo.droop_n_m_s) * dt_s;
        }
    }

    /// Counts the impulses of springs, dampers and servos in a step, for servos the linear part.
    pub fn count_springs(&mut self, dt_s: f64) {
        let rates = self.step.before.joint_rates().iter();
        let rates = rates.zip(self.state.joint_rates());
        for (index, (before, after)) in rates.enumerate() {
            // With the loads of the solved step.
            let lost = self.step.held_n_m_s2[index] * (after - before);
            self.done.joint_forces[index] += self.step.loads.in_joints[index] * dt_s - lost;
            self.servos[index].count_straight(after - before, dt_s);
        }
    }

    /// Energy taken by the dampers of the joints in a step, in J.
    pub fn dampers_took_j(&self, dt_s: f64) -> f64 {
        let rates = self.step.before.joint_rates().iter();
        let rates = rates.zip(self.state.joint_rates());
        let joints = self.robot.joints.iter().zip(rates);
        let means = self.step.middle.joint_rates();
        joints
            .zip(means)
            .map(|((joint, (before, after)), mean)| {
                0.5 * joint.damping * (before + after) * mean * dt_s
            })
            .sum()
    }

    /// Whether these mean rates of a step, by degree of freedom, would move a joint beyond its
    /// stop: it was stopped there within the step.
    pub fn passes_stops(&self, mean: impl Fn(usize) -> f64, dt_s: f64) -> bool {
        let places = self.step.before.joint_positions().iter();
        let joints = self.robot.joints.iter().zip(places);
        joints.enumerate().any(|(index, (joint, from))| {
            let to = from + dt_s * mean(ROOT_DOFS + index);
            let beyond = (joint.limits[0] - to).max(to - joint.limits[1]);
            beyond > BEYOND * self.unit_of(joint)
        })
    }

    /// The unit of a joint's positions: a radian, or a wheel's radius in metres.
    pub fn unit_of(&self, joint: &BodyJoint) -> f64 {
        match joint.kind {
            JointKind::Turns => 1.0,
            JointKind::Slides => self.scale.length_m,
        }
    }
}
