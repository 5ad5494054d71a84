//! A passive compliance law: a spring and a damper between the robot and its reference, and springs
//! between its wheels, without any knowledge of the ground.
//!
//! After S.-H. Hyon, "Compliant Terrain Adaptation for Biped Humanoids Without Measuring Ground
//! Surface and Contact Forces", IEEE Transactions on Robotics 25(1), 2009, transferred from feet to
//! wheels. No contact sensor, no map, no friction coefficient and no integrator.
//!
//! **Law.** With L = diag(rho_h cos gamma_h), M of Indiveri 2009, eq. (8), the wheel angles q and
//! the twist nu^ = M^+ L q' of the wheels' rolling,
//!
//!   w   = D (nu_d - nu^) - m g_t                     the wrench on the body
//!   f   = argmin max_h |f_h| / N_h,  M^T f = w       shared by the static loads N_h
//!   tau = L f - L P (K_n L q + D_n L q') / l^2,  P = I - M M^+
//!
//! - nu_d is the twist of the targets. [`Guidance`](crate::Guidance) with the gains K/D
//!   ([`PassiveTorqueSettings::position_gain_per_s`]) makes it the reference's own twist plus (K/D)
//!   e, so that D nu_d is the spring K e; and it keeps nu_d within the wheels' rate limit by
//!   priority, eqs. (30)-(34), so that the pull and the speed of a robot that is held far from its
//!   reference stay bounded.
//! - g_t is gravity in the wheels' plane, from the tilt of an IMU
//!   ([`TiltFilter`](crate::TiltFilter)); it also shifts the loads. Without an IMU it is zero, and
//!   on a slope the robot has an offset of m g sin(slope) / K.
//! - P L q is how far the wheels have slid against each other: it is no motion of the body. The
//!   springs between the wheels keep a wheel that loses grip from spinning, through the other
//!   wheels. l is the mean lever. Three wheels have no P.
//!
//! **Limits.** The motors' torques serve first the springs between the wheels, then gravity, then
//! the tasks by priority, each with the share that the set of reachable forces leaves, as in eqs.
//! (33), (34). A spring between wheels yields at its limit like dry friction: small errors of radii
//! do not add up to strain, and no energy is gained by yielding.
//!
//! **Passivity.** While the wheels roll and the reference stands, S = kinetic energy + e^T K e /
//! 2 + |P L q|^2 K_n / (2 l^2) + m g h falls by D nu^2 and D_n, and rises only by outside work. A
//! spring that is held over a time T and is late by d leaks at most K (T / 2 + d) nu^2, which the
//! damper must exceed. [`PassiveTorque::new`] rejects unstable gains.

mod settings;
mod stability;

use ilon_robot::Robot;
use nalgebra::{DMatrix, DVector, Vector2, Vector3};

use super::motor::TorqueRange;
use super::torque_law::{BodySense, Demand, PassiveEffort, TorqueLaw, TorqueShares};
use crate::dynamics::loads::WheelLoads;
use crate::dynamics::traction::{PushRange, TractionSet};
use crate::kinematics::matrix::vector_of;
use crate::{ControlError, DynamicModel, Kinematics};
pub use settings::PassiveTorqueSettings;
pub use stability::TiltLoop;
use stability::mean_lever_m;

/// Torques of a robot that is compliant about its reference. It replaces a
/// [`WheelLoop`](crate::WheelLoop), and needs the wheels' angles and gravity through
/// [`TorqueLaw::sense`]; without angles it integrates the rates.
///
/// **Errors** of an update: none. After construction it allocates only when a robot with joints
/// between its bodies takes another pose.
#[derive(Clone, Debug)]
pub struct PassiveTorque {
    settings: PassiveTorqueSettings,
    /// Kinematics about the reference point.
    about: Kinematics,
    set: TractionSet,
    loads: WheelLoads,
    mass_kg: f64,
    /// From the reference point to the centre of mass.
    center_of_mass_m: Vector2<f64>,
    /// P L / l: from wheel angles to slides, in rad of a wheel of the mean lever.
    slides: DMatrix<f64>,
    /// Gravity component in the wheels' plane, in m/s^2.
    gravity: Vector2<f64>,
    pull: Vector3<f64>,
    wrench: Vector3<f64>,
    against_gravity: Vector3<f64>,
    stored_j: f64,
    shares: TorqueShares,
    /// Whether `angles_rad` are current, and `last_angles_rad` those of the last update.
    has_angles: bool,
    is_counting: bool,
    // Buffers of one number per wheel, kept to avoid allocation.
    angles_rad: DVector<f64>,
    last_angles_rad: DVector<f64>,
    rates_rad_s: DVector<f64>,
    slid_rad: DVector<f64>,
    gained_rad: DVector<f64>,
    slide_rates_rad_s: DVector<f64>,
    between_n_m: DVector<f64>,
    motor: Vec<PushRange>,
    loads_n: Vec<f64>,
    pushes_n: Vec<f64>,
    torques_n_m: Vec<f64>,
}

impl PassiveTorque {
    /// Builds the law for a robot.
    ///
    /// # Errors
    /// Those of [`DynamicModel::new`]; [`ControlError::NotPositive`], [`ControlError::Negative`],
    /// [`ControlError::NotFinite`] for settings; [`ControlError::Unstable`] for gains that are
    /// unstable with these periods and delays, with the largest stable value.
    pub fn new(robot: &Robot, settings: &PassiveTorqueSettings) -> Result<Self, ControlError> {
        settings.check_numbers()?;
        let model = DynamicModel::new(robot)?;
        let about = model.kinematics().about(settings.reference_point_m)?;
        settings.check_stability(&model, &about)?;
        let n = about.wheel_count();
        let lever_m = mean_lever_m(about.lever_m());
        let levers = DMatrix::from_diagonal(&DVector::from_column_slice(about.lever_m()));
        Ok(Self {
            settings: *settings,
            set: TractionSet::new(&about),
            loads: WheelLoads::new(robot, settings.gravity_m_s2),
            mass_kg: robot.mass_kg(),
            center_of_mass_m: robot.center_of_mass_m().xy() - settings.reference_point_m,
            // P L = L - M (M^+ L).
            slides: (levers - about.m() * about.twist_matrix()) / lever_m,
            about,
            gravity: Vector2::zeros(),
            pull: Vector3::zeros(),
            wrench: Vector3::zeros(),
            against_gravity: Vector3::zeros(),
            stored_j: 0.0,
            shares: TorqueShares::default(),
            has_angles: false,
            is_counting: false,
            angles_rad: DVector::zeros(n),
            last_angles_rad: DVector::zeros(n),
            rates_rad_s: DVector::zeros(n),
            slid_rad: DVector::zeros(n),
            gained_rad: DVector::zeros(n),
            slide_rates_rad_s: DVector::zeros(n),
            between_n_m: DVector::zeros(n),
            motor: vec![PushRange::default(); n],
            loads_n: vec![0.0; n],
            pushes_n: vec![0.0; n],
            torques_n_m: vec![0.0; n],
        })
    }

    /// The settings of this law.
    pub fn settings(&self) -> &PassiveTorqueSettings {
        &self.settings
    }

    /// Writes the torques of the springs between the wheels, -L P (K_n L q + D_n L q') / l^2, to
    /// `between_n_m`.
    fn pull_wheels_together(&mut self, rates: &[f64], dt_s: f64) {
        self.rates_rad_s.copy_from_slice(rates);
        if !self.has_angles {
            self.angles_rad.copy_from(&self.last_angles_rad);
            self.angles_rad.axpy(dt_s, &self.rates_rad_s, 1.0);
        } else if !self.is_counting {
            self.last_angles_rad.copy_from(&self.angles_rad);
        }
        (self.is_counting, self.has_angles) = (true, false);
        self.gained_rad.copy_from(&self.angles_rad);
        self.gained_rad -= &self.last_angles_rad;
        self.last_angles_rad.copy_from(&self.angles_rad);
        self.slid_rad.gemv(1.0, &self.slides, &self.gained_rad, 1.0);
        self.slide_rates_rad_s
            .gemv(1.0, &self.slides, &self.rates_rad_s, 0.0);

        let k_n = self.settings.wheel_stiffness_n_m_rad;
        let most_n_m = k_n * self.slid_rad.amax();
        if most_n_m > self.settings.wheel_limit_n_m {
            self.slid_rad *= self.settings.wheel_limit_n_m / most_n_m;
        }
        self.stored_j = 0.5 * k_n * self.slid_rad.norm_squared();
        let d_n = self.settings.wheel_damping_n_m_s_rad;
        self.between_n_m.axpy(-k_n, &self.slid_rad, 0.0);
        self.between_n_m.axpy(-d_n, &self.slide_rates_rad_s, 1.0);
        // Slides are P L q / l. P is a projector, so only L / l is left of L P / l.
        let lever_m = mean_lever_m(self.about.lever_m());
        for (torque_n_m, own_m) in self.between_n_m.iter_mut().zip(self.about.lever_m()) {
            *torque_n_m *= own_m / lever_m;
        }
    }

    /// Computes the wrench that motors and grip allow beside the springs between the wheels.
    fn weigh(&mut self, targets: &[f64], limits: &[TorqueRange]) {
        let damping = self.settings.damping();
        let nu = vector_of(self.about.twist(self.rates_rad_s.as_slice()));
        let pull = damping.component_mul(&vector_of(self.about.twist(targets)));
        let held = pull - damping.component_mul(&nu);
        let (g, c) = (self.gravity, self.center_of_mass_m);
        let against = -self.mass_kg * Vector3::new(g.x, g.y, c.x * g.y - c.y * g.x);

        // A tilt shifts the loads as an uphill acceleration does.
        self.loads.fill_n(-g, &mut self.loads_n);
        let friction = self.settings.friction;
        for (h, range) in self.motor.iter_mut().enumerate() {
            let lever_m = self.about.lever_m()[h];
            let beside_n_m = limits[h].clamp(self.between_n_m[h]);
            let motor = PushRange::beside(beside_n_m, &limits[h], lever_m);
            let grip_n = if friction.is_finite() {
                friction * self.loads_n[h]
            } else {
                f64::MAX
            };
            *range = motor.within(PushRange::of_grip(grip_n));
        }
        let ranges = || self.motor.iter().copied();
        let of_gravity = self.set.share(&Vector3::zeros(), &against, ranges());
        let against = of_gravity * against;
        let position = Vector3::new(held.x, held.y, 0.0);
        let heading = Vector3::new(0.0, 0.0, held.z);
        let priority = self.settings.priority;
        let (first, second) = priority.order(position, heading);
        let w_1 = self.set.share(&against, &first, ranges());
        let given = against + w_1 * first;
        let w_2 = self.set.share(&given, &second, ranges());
        (self.shares.position, self.shares.heading) = priority.order(w_1, w_2);
        self.pull = pull;
        self.against_gravity = against;
        self.wrench = given + w_2 * second;
    }

    /// Shares the wrench among the wheels in proportion to their loads or, where a motor cannot
    /// give its share, as evenly as the motors allow.
    fn distribute(&mut self) {
        let wrench = self.wrench;
        let by_load = self
            .set
            .share_by_load(&wrench, &self.loads_n, &mut self.pushes_n);
        let fits = |push: &f64, range: &PushRange| (range.min_n..=range.max_n).contains(push);
        let mut within = self.pushes_n.iter().zip(&self.motor);
        let given = by_load.filter(|_| within.all(|(push, range)| fits(push, range)));
        self.shares.grip = match given {
            Some(use_of_load) => use_of_load / self.settings.friction,
            None => {
                // Loads far above all pushes, so that only the motors limit.
                let most_n = self.loads_n.iter().fold(1.0, |a: f64, b| a.max(*b));
                self.loads_n
                    .iter_mut()
                    .for_each(|n| *n = 1e3 * n.max(1e-3 * most_n));
                let (motor, loads_n) = (&self.motor, &self.loads_n);
                self.set
                    .distribute(&wrench, motor, loads_n, &mut self.pushes_n);
                1.0
            }
        };
        if self.settings.friction.is_infinite() {
            self.shares.grip = f64::NAN;
        }
    }
}

impl TorqueLaw for PassiveTorque {
    fn step(&mut self, demand: &Demand<'_>) {
        let limits = demand.limits;
        self.pull_wheels_together(demand.rates_rad_s, demand.dt_s);
        self.weigh(demand.targets_rad_s, limits);
        self.distribute();
        for (h, torque_n_m) in self.torques_n_m.iter_mut().enumerate() {
            let push_n_m = self.about.lever_m()[h] * self.pushes_n[h];
            *torque_n_m = limits[h].clamp(push_n_m + self.between_n_m[h]);
        }
    }

    fn torques_n_m(&self) -> &[f64] {
        &self.torques_n_m
    }

    /// Takes the wheels' angles, if there is a finite one for each wheel, and gravity.
    fn sense(&mut self, known: &BodySense<'_>) {
        let angles = known.angles_rad;
        if angles.len() == self.angles_rad.len() && angles.iter().all(|angle| angle.is_finite()) {
            self.angles_rad.copy_from_slice(angles);
            self.has_angles = true;
        }
        let gravity = known.gravity_in_body_m_s2.map(|g| g.xy());
        self.gravity = gravity
            .filter(|g| g.x.is_finite() && g.y.is_finite())
            .unwrap_or_default();
    }

    /// Updates loads and masses to the pose. The springs between the wheels keep their state and
    /// stored energy.
    fn stand(&mut self, posed: &Robot) {
        self.loads = WheelLoads::new(posed, self.settings.gravity_m_s2);
        self.center_of_mass_m = posed.center_of_mass_m().xy() - self.settings.reference_point_m;
    }

    fn passive_effort(&self) -> Option<PassiveEffort<'_>> {
        Some(PassiveEffort {
            pull: self.pull,
            wrench: self.wrench,
            against_gravity: self.against_gravity,
            between_n_m: self.between_n_m.as_slice(),
            stored_j: self.stored_j,
        })
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
