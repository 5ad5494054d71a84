//! Priorities under torque limits and limited grip, which section V leaves to future research.
//!
//! The guidance shares wheel *rates* by priority. If a motor then lacks torque, or a wheel grip,
//! plain clipping bends the acceleration against the priorities. Here the same idea is applied one
//! level down.
//!
//! **Tasks.** Computed torque, eq. (12), requests the body acceleration nu' = nu'_d + k_p e + k_i
//! integral(e), with the twist error e = nu_d - nu that corresponds to the rate errors. It splits
//! into a linear and an angular task. The torques (C + F) q' that keep the motion come before both.
//!
//! **Capacity.** The paper measures a task by its infinity norm, which a single wheel decides.
//! Torque limits differ by wheel, by direction and by rate, and for N > 3 the wheels can replace
//! each other. So a task's weight is computed from the set of forces that motors and friction can
//! give (see [`crate::dynamics::traction`]): the largest w in [0, 1] for which the tasks above it
//! plus w times this one are within the set. As in eqs. (33), (34), a task changes nothing above it
//! and gets what they leave. The set contains what the infinity norm would allow, so weights are
//! never smaller.
//!
//! **Redundancy.** N - 3 torques are free. They are chosen to minimise the worst use of grip, push
//! over friction times load.

use ilon_robot::Robot;
use nalgebra::{Vector2, Vector3};

use super::derivative::{FilteredDerivative, weight};
use super::{Demand, TorqueLaw, TorqueShares};
use crate::dynamics::capacity::{Capacity, Moment};
use crate::error::{not_negative, positive};
use crate::kinematics::matrix::{twist_of, vector_of};
use crate::{ControlError, Kinematics, Priority};

/// Settings of the prioritised torque law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrioritisedTorqueSettings {
    /// Requested bandwidth of the twist loop, in rad/s; limited by what wheels in the air allow, as
    /// for [`ComputedTorque`](crate::ComputedTorque).
    pub bandwidth_rad_s: f64,
    /// Time constant of the low-pass filter on the targets' derivative, in seconds; 0 for none.
    pub target_filter_s: f64,
    /// The longest update period, in seconds.
    pub dt_s: f64,
    /// The task that keeps its acceleration if motors or grip cannot give both.
    pub priority: Priority,
    /// The point of the body that the linear task accelerates, in the body frame, in metres: the
    /// guidance's reference point.
    pub reference_point_m: Vector2<f64>,
    /// Assumed friction coefficient; infinite to leave grip out of the weights (only loads then
    /// decide the distribution).
    pub friction: f64,
    /// Gravity in m/s^2.
    pub gravity_m_s2: f64,
}

/// Computed torque under torque and friction limits, by priority. It replaces a
/// [`WheelLoop`](crate::WheelLoop): same inputs, same output.
#[derive(Clone, Debug)]
pub struct PrioritisedTorque {
    capacity: Capacity,
    /// Kinematics about the reference point; those of the model are about the body's origin.
    about: Kinematics,
    settings: PrioritisedTorqueSettings,
    k_p: f64,
    integral: Vector3<f64>,
    target_rate: FilteredDerivative<Vector3<f64>>,
    shares: TorqueShares,
    // Buffers of one number per wheel, kept to avoid allocation.
    pushes_n: Vec<f64>,
    rates_back_rad_s: Vec<f64>,
    torques_n_m: Vec<f64>,
}

impl PrioritisedTorque {
    /// Builds the law for a robot.
    ///
    /// # Errors
    /// Those of [`DynamicModel::new`](crate::DynamicModel::new); [`ControlError::NotPositive`],
    /// [`ControlError::Negative`], [`ControlError::NotFinite`] for settings.
    pub fn new(robot: &Robot, settings: &PrioritisedTorqueSettings) -> Result<Self, ControlError> {
        let w_b = positive(
            "the torque law's bandwidth in rad/s",
            settings.bandwidth_rad_s,
        )?;
        let dt_s = positive("the torque law's period in s", settings.dt_s)?;
        not_negative(
            "the target filter's time constant in s",
            settings.target_filter_s,
        )?;
        positive("gravity in m/s^2", settings.gravity_m_s2)?;
        if settings.friction != f64::INFINITY {
            positive("the friction coefficient", settings.friction)?;
        }
        let capacity = Capacity::new(robot, settings.friction, settings.gravity_m_s2)?;
        let model = &capacity.model;
        let about = model.kinematics().about(settings.reference_point_m)?;
        let n = model.kinematics().wheel_count();
        Ok(Self {
            k_p: model.bandwidth_rad_s(w_b, dt_s),
            settings: *settings,
            integral: Vector3::zeros(),
            target_rate: FilteredDerivative::default(),
            shares: TorqueShares::default(),
            pushes_n: vec![0.0; n],
            rates_back_rad_s: vec![0.0; n],
            torques_n_m: vec![0.0; n],
            about,
            capacity,
        })
    }
}

impl TorqueLaw for PrioritisedTorque {
    fn step(&mut self, demand: &Demand<'_>) {
        let Demand {
            targets_rad_s: targets,
            rates_rad_s: rates,
            limits,
            dt_s,
        } = *demand;
        let nu = self.capacity.model.kinematics().twist(rates);
        // Errors and tasks are about the reference point c, in body-frame components.
        let nu_d = vector_of(self.about.twist(targets));
        let e = nu_d - vector_of(self.about.twist(rates));
        let k_i = 0.25 * self.k_p * self.k_p;

        let weight = weight(self.settings.target_filter_s, dt_s);
        self.target_rate.update(nu_d, weight, dt_s);
        let grown = self.integral + k_i * dt_s * e;
        let y = self.target_rate.value + self.k_p * e + grown;

        let position = Vector3::new(y.x, y.y, 0.0);
        // A rotation about c alone moves the origin by omega k x (-c).
        let c = self.settings.reference_point_m;
        let heading = y.z * Vector3::new(c.y, -c.x, 1.0);
        let moment = Moment {
            rates,
            towards: targets,
            limits,
            nu,
        };
        self.capacity.begin(&moment);
        let (first, second) = self.settings.priority.order(position, heading);
        let w_1 = self.capacity.weight(&moment, Vector3::zeros(), first);
        let w_2 = self.capacity.weight(&moment, w_1 * first, second);
        let nu_rate = w_1 * first + w_2 * second;
        let shares = self.settings.priority.order(w_1, w_2);
        (self.shares.position, self.shares.heading) = shares;

        // The integral of a saturated task is frozen.
        if shares.0 >= 1.0 {
            (self.integral.x, self.integral.y) = (grown.x, grown.y);
        }
        if shares.1 >= 1.0 {
            self.integral.z = grown.z;
        }

        let capacity = &mut self.capacity;
        let force = capacity.weigh(&moment, nu_rate);
        self.shares.grip = capacity.set.distribute(
            &force,
            &capacity.motor,
            &capacity.grips_n,
            &mut self.pushes_n,
        );
        if self.settings.friction.is_infinite() {
            self.shares.grip = f64::NAN;
        }

        // The part of the rate errors that is no motion of the body is damped by each wheel's own
        // inertia: a wheel in the air feels nothing else.
        self.about
            .wheel_rates(twist_of(e), &mut self.rates_back_rad_s);
        let levers = self.capacity.model.kinematics().lever_m();
        let inertias = self.capacity.model.wheel_inertias_kg_m2();
        for (h, torque_n_m) in self.torques_n_m.iter_mut().enumerate() {
            let astray = targets[h] - rates[h] - self.rates_back_rad_s[h];
            let wanted = levers[h] * self.pushes_n[h]
                + self.capacity.own_n_m[h]
                + self.k_p * inertias[h] * astray;
            *torque_n_m = limits[h].clamp(wanted);
        }
    }

    fn torques_n_m(&self) -> &[f64] {
        &self.torques_n_m
    }

    fn stand(&mut self, posed: &Robot) {
        if let Ok(capacity) = self.capacity.posed(posed)
            && let Ok(about) = (capacity.model.kinematics()).about(self.settings.reference_point_m)
        {
            (self.capacity, self.about) = (capacity, about);
        }
    }

    fn shares(&self) -> Option<TorqueShares> {
        Some(self.shares)
    }

    fn boxed(&self) -> Box<dyn TorqueLaw> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests;
