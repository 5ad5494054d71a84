//! Stiffness and damping settings of the passive law, and their checks.

use ilon_robot::Robot;
use nalgebra::{Vector2, Vector3};

use super::stability::{Loop, TiltLoop, air_swing, masses, mean_lever_m, unstable};
use crate::error::{not_negative, positive};
use crate::{ControlError, DynamicModel, Kinematics, Priority};

/// Stiffness and damping of a robot about its reference, and the timing of its control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassiveTorqueSettings {
    /// Stiffness K of the reference point's position, in N/m. The guidance provides it: see
    /// [`Self::position_gain_per_s`].
    pub stiffness_n_m: f64,
    /// Damping D of the reference point's velocity, in N s/m.
    pub damping_n_s_m: f64,
    /// Stiffness of the heading, in N m/rad. The guidance provides it: see
    /// [`Self::heading_gain_per_s`].
    pub heading_stiffness_n_m_rad: f64,
    /// Damping of the yaw rate, in N m s/rad.
    pub heading_damping_n_m_s_rad: f64,
    /// Stiffness K_n between the wheels, in N m per rad of slide; 0 for none.
    pub wheel_stiffness_n_m_rad: f64,
    /// Damping D_n between the wheels, in N m s/rad; 0 for none.
    pub wheel_damping_n_m_s_rad: f64,
    /// Torque at which a spring between the wheels yields, in N m.
    pub wheel_limit_n_m: f64,
    /// The task that keeps its force if motors or grip cannot give both.
    pub priority: Priority,
    /// The point of the body that the spring holds, in the body frame, in metres: the guidance's
    /// reference point.
    pub reference_point_m: Vector2<f64>,
    /// Assumed friction coefficient; infinite if unknown.
    pub friction: f64,
    /// Gravity in m/s^2.
    pub gravity_m_s2: f64,
    /// The longest update period, in seconds.
    pub dt_s: f64,
    /// The period at which the targets, and with them the spring, are updated, in seconds.
    pub pose_period_s: f64,
    /// Age of the pose from which the targets are computed, in seconds.
    pub pose_delay_s: f64,
    /// The tilt filter, if there is one.
    pub tilt: Option<TiltLoop>,
}

impl PassiveTorqueSettings {
    /// Returns settings derived from a robot's mass and the control's timing. The damper stops the
    /// robot within ten times the pose's period and delay, unless a wheel in the air allows less;
    /// the spring's damping ratio is 0.7. Between the wheels the damping is the same as towards the
    /// ground and the stiffness four times as much; these springs yield at the push of a wheel with
    /// a friction of 1. The position has priority.
    ///
    /// # Errors
    /// Those of [`DynamicModel::new`]; [`ControlError::NotPositive`], [`ControlError::Negative`]
    /// for times.
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
        let (mass_kg, inertia_kg_m2) = masses(&model, model.kinematics());
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
        // A quarter of the gain at which a wheel in the air oscillates from step to step.
        let swings = this.air_swing(&model, model.kinematics());
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

    /// Returns the guidance gain K_r that makes the targets act as the spring: stiffness over
    /// damping, in 1/s.
    pub fn position_gain_per_s(&self) -> f64 {
        self.stiffness_n_m / self.damping_n_s_m
    }

    /// Returns the guidance gain K_phi: heading stiffness over heading damping, in 1/s.
    pub fn heading_gain_per_s(&self) -> f64 {
        self.heading_stiffness_n_m_rad / self.heading_damping_n_m_s_rad
    }

    /// Rejects numbers out of range.
    pub(super) fn check_numbers(&self) -> Result<(), ControlError> {
        positive("the stiffness in N/m", self.stiffness_n_m)?;
        positive("the damping in N s/m", self.damping_n_s_m)?;
        positive(
            "the heading's stiffness in N m/rad",
            self.heading_stiffness_n_m_rad,
        )?;
        positive(
            "the heading's damping in N m s/rad",
            self.heading_damping_n_m_s_rad,
        )?;
        not_negative(
            "the stiffness between wheels in N m/rad",
            self.wheel_stiffness_n_m_rad,
        )?;
        not_negative(
            "the damping between wheels in N m s/rad",
            self.wheel_damping_n_m_s_rad,
        )?;
        positive(
            "the torque limit between wheels in N m",
            self.wheel_limit_n_m,
        )?;
        positive("gravity in m/s^2", self.gravity_m_s2)?;
        positive("the torque law's period in s", self.dt_s)?;
        positive("the pose's period in s", self.pose_period_s)?;
        not_negative("the pose's delay in s", self.pose_delay_s)?;
        if self.friction != f64::INFINITY {
            positive("the friction coefficient", self.friction)?;
        }
        Ok(())
    }

    /// The damping D about the reference point.
    pub(super) fn damping(&self) -> Vector3<f64> {
        let along = self.damping_n_s_m;
        Vector3::new(along, along, self.heading_damping_n_m_s_rad)
    }

    /// Rejects unstable gains.
    pub(super) fn check_stability(
        &self,
        model: &DynamicModel,
        about: &Kinematics,
    ) -> Result<(), ControlError> {
        let swing = self.air_swing(model, about);
        if swing >= 2.0 {
            return Err(unstable(
                "the damping of wheels in the air, times the torque law's period, over their inertia",
                swing,
                2.0,
                format!("at a period of {} s", self.dt_s),
            ));
        }
        let most = 2.0 * self.wheel_damping_n_m_s_rad / self.dt_s;
        // With three wheels there are no springs between wheels.
        if about.wheel_count() > 3 && self.wheel_stiffness_n_m_rad > most {
            return Err(unstable(
                "the stiffness between wheels in N m/rad",
                self.wheel_stiffness_n_m_rad,
                most,
                format!(
                    "with a damping of {} N m s/rad held over {} s",
                    self.wheel_damping_n_m_s_rad, self.dt_s
                ),
            ));
        }
        if let Some(tilt) = self.tilt {
            positive("the tilt filter's time constant in s", tilt.time_constant_s)?;
            not_negative("the IMU's delay in s", tilt.delay_s)?;
        }
        let (mass_kg, inertia_kg_m2) = masses(model, about);
        let delay_s = self.pose_delay_s + self.pose_period_s;
        let said = format!(
            "with a pose that is {} s old and held over {} s",
            self.pose_delay_s, self.pose_period_s
        );
        let along = Loop {
            inertia: mass_kg,
            damping: self.damping_n_s_m,
            delay_s,
            tilt: self.tilt,
        };
        along.check("the stiffness in N/m", self.stiffness_n_m, &said)?;
        let turning = Loop {
            inertia: inertia_kg_m2,
            damping: self.heading_damping_n_m_s_rad,
            delay_s,
            tilt: None,
        };
        let stiffness = self.heading_stiffness_n_m_rad;
        turning.check("the heading's stiffness in N m/rad", stiffness, &said)
    }

    fn air_swing(&self, model: &DynamicModel, about: &Kinematics) -> f64 {
        let dampings = (self.damping(), self.wheel_damping_n_m_s_rad);
        air_swing(model, about, dampings, self.dt_s)
    }
}
