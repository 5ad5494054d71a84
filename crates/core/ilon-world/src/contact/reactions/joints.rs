//! The laws of joints between bodies: stops, dry friction, and couplings of one joint to another.

use ilon_robot::{BodyJoint, Coupling};
use nalgebra::Vector3;

use super::ReactionSolver;
use crate::contact::law::Law;
use crate::contact::reactions::potential::Axle;
use crate::contact::reactions::reaction::{Part, Reaction};
use crate::contact::reactions::row::Row;
use crate::contact::scene::Scene;
use crate::dynamics::ROOT_DOFS;

/// A joint nearer to its stop than this, in its unit, may reach it by the ground's forces in the
/// step. Chosen.
const NEAR_STOP: f64 = 0.02;

/// A joint beyond its stop, or off its coupling, returns at this speed, in its unit per unit of
/// time: too slowly to bounce. Chosen.
const COMES_BACK: f64 = 7.1e-3;

impl ReactionSolver {
    /// Adds the laws of the joints between a robot's bodies.
    pub(super) fn hold_joints(&mut self, scene: &Scene<'_>) {
        for (index, joint) in scene.robot.joints.iter().enumerate() {
            if joint.friction > 0.0 {
                let side = scene.of_joint(index, 1.0);
                self.hold_bearing(scene, Part::Friction(index), side, joint.friction);
            }
            if self.driven.contains(&(scene.index, index)) {
                self.bound_servo(scene, index);
            }
            self.stop_joint(scene, index, joint);
        }
        for (index, coupling) in scene.robot.couplings.iter().enumerate() {
            self.couple_joints(scene, index, coupling);
        }
    }

    /// Keeps a servo within its effort.
    fn bound_servo(&mut self, scene: &Scene<'_>, index: usize) {
        let rate = scene.step.before.joint_rates()[index];
        let servo = &scene.body.servos[index];
        servo.fill_curve(rate, scene.dt_s, &mut self.curve);
        let place = self.problem.add_curve(&self.curve);
        let side = scene.of_joint(index, 1.0);
        self.hold_joint(scene, Part::Servo(index), side, Law::Curve { place }, 0.0);
    }

    /// Keeps a joint between its stops: in the step it may come no further than to the stop.
    fn stop_joint(&mut self, scene: &Scene<'_>, index: usize, joint: &BodyJoint) {
        let position = scene.step.before.joint_positions()[index];
        let dof = ROOT_DOFS + index;
        let rates = scene.step.rates_before[dof].abs() + scene.step.rates_free[dof].abs();
        let unit = scene.body.unit_of(joint);
        let near = 2.0 * scene.dt_s * rates + NEAR_STOP * unit;
        let [behind, ahead] = [position - joint.limits[0], joint.limits[1] - position];
        let back = COMES_BACK * unit / scene.scale.time_s();
        for (room, way) in [(behind, 1.0), (ahead, -1.0)] {
            if room > near {
                continue;
            }
            let least = (-room / scene.dt_s).min(back);
            let law = if way > 0.0 {
                Law::Joint {
                    least_n_m_s: 0.0,
                    most_n_m_s: f64::INFINITY,
                }
            } else {
                Law::Joint {
                    least_n_m_s: f64::NEG_INFINITY,
                    most_n_m_s: 0.0,
                }
            };
            let part = Part::Stop(index, way < 0.0);
            self.hold_joint(scene, part, scene.of_joint(index, 1.0), law, way * least);
        }
    }

    /// Couples a joint to the one that it follows.
    fn couple_joints(&mut self, scene: &Scene<'_>, index: usize, coupling: &Coupling) {
        let positions = scene.step.before.joint_positions();
        let stands = coupling.factor * positions[coupling.follows] + coupling.offset;
        let off = positions[coupling.joint] - stands;
        let unit = scene.body.unit_of(&scene.robot.joints[coupling.joint]);
        let back = COMES_BACK * unit / scene.scale.time_s();
        let comes_back = (-off / scene.dt_s).clamp(-back, back);
        let row = Row {
            a: scene.of_joint(coupling.joint, 1.0),
            b: Some(scene.of_joint(coupling.follows, -coupling.factor)),
        };
        let sum = |rates: &[f64], of_axle: fn(&Axle) -> (f64, f64)| {
            let sides = row.sides().map(|side| self.rate(side, rates, of_axle));
            sides.sum::<f64>() - comes_back
        };
        let before = sum(&scene.step.rates_before, Axle::before);
        let free = sum(&scene.step.rates_free, Axle::now);
        let law = Law::Joint {
            least_n_m_s: f64::NEG_INFINITY,
            most_n_m_s: f64::INFINITY,
        };
        let member = scene.member(Part::Coupling(index));
        let reaction = Reaction::within(member, Vector3::new(before, 0.0, 0.0));
        self.push(law, reaction, &[row], &[free]);
    }
}
