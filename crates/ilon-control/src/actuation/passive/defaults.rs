//! Settings that follow from a robot.

use ilon_robot::Robot;
use nalgebra::Vector2;

use super::settings::{PassiveTorqueSettings, mean_lever_m};
use super::stability;
use crate::error::{not_negative, positive};
use crate::{ControlError, DynamicModel, Priority};

impl PassiveTorqueSettings {
    /// Settings that follow from a robot's mass and the control's timing: the damper stops the robot within ten times the pose's period and
    /// delay, unless a wheel in the air allows less; the spring's damping ratio is 0.7. Between the wheels damping is the same as towards the ground,
    /// and stiffness four times as much; they give way at what a wheel pushes with a friction of 1. Priority is the position's.
    ///
    /// # Errors
    /// Those of [`DynamicModel::new`]; [`ControlError::NotPositive`], [`ControlError::Negative`] for times.
    pub fn for_robot(
        robot: &Robot,
        gravity_m_s2: f64,
        dt_s: f64,
        pose_period_s: f64,
        pose_delay_s: f64,
    ) -> Result<Self, ControlError> {
        positive("gravity in m/s^2", gravity_m_s2)?;
        positive("the torque law's period in s", dt_s)?;
        positive("the pose's period in s", pose_period_s)?;
        not_negative("the pose's delay in s", pose_delay_s)?;
        let model = DynamicModel::new(robot)?;
        let levers = model.kinematics().lever_m();
        let lever_m = mean_lever_m(levers);
        let (mass_kg, inertia_kg_m2) = stability::masses(&model, model.kinematics());
        let stops_s = 10.0 * (pose_period_s + pose_delay_s);
        let mut this = Self {
            stiffness_n_m: 0.0,
            damping_n_s_m: mass_kg / stops_s,
            heading_stiffness_n_m_rad: 0.0,
            heading_damping_n_m_s_rad: inertia_kg_m2 / stops_s,
            wheel_stiffness_n_m_rad: 0.0,
            wheel_damping_n_m_s_rad: mass_kg / stops_s * lever_m * lever_m,
            wheel_limit_n_m: lever_m * robot.mass_kg() * gravity_m_s2 / levers.len() as f64,
            priority: Priority::Position,
            reference_point_m: Vector2::zeros(),
            friction: f64::INFINITY,
            gravity_m_s2,
            dt_s,
            pose_period_s,
            pose_delay_s,
            tilt: None,
        };
        // A quarter of what swings a wheel in the air from step to step.
        let swings = stability::air_swing(&model, model.kinematics(), &this);
        let held = (0.5 / swings).min(1.0);
        this.damping_n_s_m *= held;
        this.heading_damping_n_m_s_rad *= held;
        this.wheel_damping_n_m_s_rad *= held;
        let spring = |damping: f64, inertia: f64| damping * damping / (4.0 * 0.49 * inertia);
        this.stiffness_n_m = spring(this.damping_n_s_m, mass_kg);
        this.heading_stiffness_n_m_rad = spring(this.heading_damping_n_m_s_rad, inertia_kg_m2);
        this.wheel_stiffness_n_m_rad = 4.0 * this.stiffness_n_m * lever_m * lever_m;
        Ok(this)
    }
}
