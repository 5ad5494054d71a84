//! Nonlinear wheel drives: motors at their limits, and gears with an efficiency.

use super::ReactionSolver;
use crate::MotorTorque;
use crate::contact::law::Law;
use crate::contact::reactions::reaction::Part;
use crate::contact::scene::{Scene, Scenes};
use crate::dynamics::ROOT_DOFS;
use crate::robot::drive::WheelDrive;

impl ReactionSolver {
    /// Whether a wheel's drive is nonlinear in this step, as far as that is known.
    pub(super) fn needs_drive(&self, scene: &Scene<'_>, wheel: usize) -> bool {
        let gear_loses = scene.robot.wheels[wheel].drive.gear_efficiency < 1.0;
        gear_loses
            || self
                .driven
                .contains(&(scene.index, scene.wheels[wheel].joint))
    }

    /// Adds the law of a wheel's drive.
    pub(super) fn hold_drive(&mut self, scene: &Scene<'_>, wheel: usize) {
        let dof = scene.body.dof_of(wheel);
        let drive = WheelDrive::new(
            &scene.step.motor_laws[wheel],
            &scene.robot.wheels[wheel],
            scene.step.rates_before[dof],
            scene.dt_s,
        );
        drive.fill_curve(&scene.step.motors[wheel], scene.dt_s, &mut self.curve);
        let place = self.problem.add_curve(&self.curve);
        let side = scene.of_hub(wheel);
        self.hold_joint(scene, Part::Drive(wheel), side, Law::Curve { place }, 0.0);
    }

    /// Finds the motors and servos that left the straight line on which the step was solved.
    /// Returns whether there are any.
    pub(super) fn find_bounded_motors(&mut self, scenes: Scenes<'_>) -> bool {
        let known = self.driven.len();
        for scene in scenes.each() {
            for (wheel, law) in scene.step.motor_laws.iter().enumerate() {
                if !self.needs_drive(&scene, wheel) {
                    let joint = scene.wheels[wheel].joint;
                    self.find_bounded(&scene, joint, (law, &scene.step.motors[wheel]));
                }
            }
            for (joint, servo) in scene.body.servos.iter().enumerate() {
                if !self.driven.contains(&(scene.index, joint)) {
                    self.find_bounded(&scene, joint, (&servo.law, &servo.straight));
                }
            }
        }
        self.driven.len() > known
    }

    /// Records a joint of the tree whose drive was solved on a straight line, and is off it in the
    /// solution.
    fn find_bounded(
        &mut self,
        scene: &Scene<'_>,
        joint: usize,
        (law, straight): (&MotorTorque, &MotorTorque),
    ) {
        /// Rounding of a torque, as a share of it. Chosen.
        const ROUNDED: f64 = 1e-6;
        let dof = ROOT_DOFS + joint;
        let free_rad_s = scene.step.rates_free[dof] - scene.step.rates_before[dof];
        let gained_rad_s = free_rad_s + self.change(scene.index)[dof];
        let line_n_m = straight.torque_n_m - straight.droop_n_m_s * gained_rad_s;
        let size_n_m = straight.torque_n_m.abs() + line_n_m.abs();
        if (law.at_gain(gained_rad_s) - line_n_m).abs() > ROUNDED * size_n_m {
            self.driven.push((scene.index, joint));
        }
    }
}
