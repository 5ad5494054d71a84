//! How stiff and how damped a robot is about its reference.

use nalgebra::{Matrix3, Vector2, Vector3};

use crate::error::{not_negative, positive};
use crate::{ControlError, DynamicModel, Kinematics, Priority};

/// How stiff and how damped a robot is about its reference, and how its control is timed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassiveTorqueSettings {
    /// Stiffness K of the reference point's position, in N/m. The guidance makes it: see [`Self::position_gain_per_s`].
    pub stiffness_n_m: f64,
    /// Damping D of its velocity, in N s/m.
    pub damping_n_s_m: f64,
    /// Stiffness of the heading, in N m/rad. The guidance makes it: see [`Self::heading_gain_per_s`].
    pub heading_stiffness_n_m_rad: f64,
    /// Damping of the yaw rate, in N m s/rad.
    pub heading_damping_n_m_s_rad: f64,
    /// Stiffness K_n between the wheels, in N m per rad of slide; 0 for none.
    pub wheel_stiffness_n_m_rad: f64,
    /// Damping D_n between the wheels, in N m s/rad; 0 for none.
    pub wheel_damping_n_m_s_rad: f64,
    /// Torque at which a spring between the wheels gives way, in N m.
    pub wheel_limit_n_m: f64,
    /// Which task keeps its force where motors, or grip, cannot give both.
    pub priority: Priority,
    /// The point of the body that the spring holds, in the body frame, in metres: that of the guidance.
    pub reference_point_m: Vector2<f64>,
    /// Friction coefficient to count on; infinite where none is known.
    pub friction: f64,
    /// Gravity in m/s^2.
    pub gravity_m_s2: f64,
    /// The longest period at which the law will be updated, in seconds.
    pub dt_s: f64,
    /// The period at which targets, and with them the spring, are renewed, in seconds.
    pub pose_period_s: f64,
    /// How old the pose is that they are made from, in seconds.
    pub pose_delay_s: f64,
    /// What gives the tilt, where something does.
    pub tilt: Option<TiltLoop>,
}

impl PassiveTorqueSettings {
    /// The guidance's gain K_r with which the targets hold the spring: stiffness over damping, in 1/s.
    pub fn position_gain_per_s(&self) -> f64 {
        self.stiffness_n_m / self.damping_n_s_m
    }

    /// The guidance's gain K_phi: the heading's stiffness over its damping, in 1/s.
    pub fn heading_gain_per_s(&self) -> f64 {
        self.heading_stiffness_n_m_rad / self.heading_damping_n_m_s_rad
    }

    pub(super) fn check(&self) -> Result<(), ControlError> {
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

    /// D about the reference point.
    pub(super) fn damping(&self) -> Vector3<f64> {
        let along = self.damping_n_s_m;
        Vector3::new(along, along, self.heading_damping_n_m_s_rad)
    }
}

/// The filter and the sensor that give the tilt: see [`TiltFilter`](crate::TiltFilter).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiltLoop {
    /// The filter's time constant, in seconds.
    pub time_constant_s: f64,
    /// How old what the IMU says is, in seconds.
    pub delay_s: f64,
}

/// l: the mean size of rho cos gamma.
pub(super) fn mean_lever_m(levers_m: &[f64]) -> f64 {
    levers_m.iter().map(|lever| lever.abs()).sum::<f64>() / levers_m.len() as f64
}

/// The inertia of the body with all that turns with it, R^T I R, about the reference point of `about`.
pub(super) fn body_inertia(model: &DynamicModel, about: &Kinematics) -> Matrix3<f64> {
    let r = about.rate_matrix();
    (r.transpose() * model.inertia() * r)
        .fixed_view::<3, 3>(0, 0)
        .into()
}
