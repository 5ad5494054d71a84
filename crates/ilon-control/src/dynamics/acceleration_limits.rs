//! How hard a robot may be driven: the accelerations at which no wheel slides and no motor lacks torque.
//!
//! An acceleration of the body needs a force and a moment of the ground, which the wheels share: push f_h along each roller's axis. Wheel h
//! bears it while |f_h| <= mu N_h, with the load N_h that the acceleration itself shifts, and while its motor has the torque for the push,
//! its own inertia and its resistance. How the push is shared is open for N > 3, and the wheels' loops decide it:
//!
//! - **Loops of equal gains** ([`PushSharing::EqualLoops`]). While the wheels roll, their rate errors are those of a motion of the body,
//!   e = R e_nu, so that the torques are tau = R x for some x: among all torques that give the force, R^T tau = F, that is the shortest,
//!   tau = R (R^T R)^-1 F. A wheel that the acceleration relieves is asked for as much as the others and slides first.
//! - **By grip** ([`PushSharing::ByGrip`]), as [`PrioritisedTorque`](crate::PrioritisedTorque) does: whatever the set of forces has room for.

use ilon_robot::{Robot, Twist};
use nalgebra::{Cholesky, Const, Matrix3, Vector2, Vector3};

use super::capacity::{Capacity, Moment};
use crate::error::{finite, positive};
use crate::{ControlError, Motor, TorqueRange};

/// How wheels share what the body needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PushSharing {
    /// One rate loop a wheel, all of the same gains: [`WheelLoop`](crate::WheelLoop).
    EqualLoops,
    /// With the least worst use of grip: [`PrioritisedTorque`](crate::PrioritisedTorque).
    ByGrip,
}

/// What the accelerations of a robot are limited by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitSettings {
    /// Coulomb's coefficient of friction between rollers and ground.
    pub friction: f64,
    /// Gravity in m/s^2.
    pub gravity_m_s2: f64,
    /// Slope of the ground in radians, below a right angle; 0 where it is level.
    pub slope_rad: f64,
    /// Direction in which it falls, in the body frame, in radians from the x axis.
    pub downhill_rad: f64,
    /// How the wheels share what the body needs.
    pub sharing: PushSharing,
}

/// What holds an acceleration where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitCause {
    /// The wheel would slide.
    Grip,
    /// Its motor has no more torque.
    Motor,
}

/// The largest acceleration along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationLimit {
    /// It, in the direction's units: m/s^2 for a direction (cos, sin, 0), rad/s^2 for (0, 0, 1). Zero where even standing, or going on
    /// as it goes, takes more than there is.
    pub largest: f64,
    /// The wheel that holds it there, by its place in the robot.
    pub wheel: usize,
    /// Why.
    pub cause: LimitCause,
}

/// The accelerations of a robot that its motors and its grip allow.
#[derive(Clone, Debug)]
pub struct AccelerationLimits {
    capacity: Capacity,
    sharing: PushSharing,
    /// R^T R.
    squared: Cholesky<f64, Const<3>>,
    // One a wheel each.
    rates: Vec<f64>,
    towards: Vec<f64>,
    limits: Vec<TorqueRange>,
    pushes_n: Vec<f64>,
}

/// Largest acceleration that is looked for, in gravities.
const MOST_GRAVITIES: f64 = 1e3;

impl AccelerationLimits {
    /// The limits of a robot.
    ///
    /// # Errors
    /// Those of [`DynamicModel::new`](crate::DynamicModel::new); [`ControlError::NotPositive`] and [`ControlError::NotFinite`] for settings,
    /// the first also for a slope of a right angle or more.
    pub fn new(robot: &Robot, settings: &LimitSettings) -> Result<Self, ControlError> {
        positive("the friction coefficient", settings.friction)?;
        positive("gravity in m/s^2", settings.gravity_m_s2)?;
        let slope_rad = finite("the slope in rad", settings.slope_rad)?;
        let downhill_rad = finite("the direction downhill in rad", settings.downhill_rad)?;
        let across = libm::cos(slope_rad);
        positive("the cosine of the slope", across)?;
        let along_m_s2 = settings.gravity_m_s2 * libm::sin(slope_rad);
        let downhill = Vector2::new(libm::cos(downhill_rad), libm::sin(downhill_rad));
        let capacity = Capacity::new(robot, settings.friction, settings.gravity_m_s2 * across)?
            .downhill(along_m_s2 * downhill);
        let kinematics = capacity.model.kinematics();
        let r = kinematics.rate_matrix();
        let squared: Matrix3<f64> = (r.transpose() * r).fixed_view::<3, 3>(0, 0).into();
        let squared = squared
            .cholesky()
            .ok_or_else(|| ControlError::NotPositive {
                what: "the smallest singular value of M".to_owned(),
                value: 0.0,
            })?;
        let n = kinematics.wheel_count();
        Ok(Self {
            capacity,
            sharing: settings.sharing,
            squared,
            rates: vec![0.0; n],
            towards: vec![0.0; n],
            limits: vec![TorqueRange::UNLIMITED; n],
            pushes_n: vec![0.0; n],
        })
    }

    /// The largest acceleration along `direction`, a rate of change of the twist (d/dt of its components in the body frame), while the
    /// robot moves with `twist`, by motors as many as wheels. Dry friction acts against the wheels' rates, and at rest against where they
    /// are about to turn.
    ///
    /// # Errors
    /// [`ControlError::LengthMismatch`]; [`ControlError::NotFinite`] and, for a direction of no length, [`ControlError::NotPositive`].
    pub fn along(
        &mut self,
        direction: Twist,
        twist: Twist,
        motors: &[Motor],
    ) -> Result<AccelerationLimit, ControlError> {
        let n = self.rates.len();
        if motors.len() != n {
            return Err(ControlError::LengthMismatch {
                left: "motors",
                left_count: motors.len(),
                right: "wheels",
                right_count: n,
            });
        }
        let vector = |what: &str, t: Twist| {
            let components = [t.vx_m_s, t.vy_m_s, t.omega_rad_s];
            components
                .iter()
                .try_for_each(|x| finite(what, *x).map(drop))?;
            Ok(Vector3::from(components))
        };
        vector("a component of the twist", twist)?;
        let along = vector("a component of the direction", direction)?;
        positive("the direction's length", along.norm())?;
        let kinematics = self.capacity.model.kinematics();
        kinematics.wheel_rates(direction, &mut self.towards);
        kinematics.wheel_rates(twist, &mut self.rates);
        for h in 0..n {
            if self.rates[h] != 0.0 {
                self.towards[h] = self.rates[h];
            }
            self.limits[h] = motors[h].range(self.rates[h]);
        }
        Ok(self.search(along, twist))
    }

    /// What can be given is convex and holds zero, or nothing along this direction: the largest is found by doubling and halving.
    fn search(&mut self, along: Vector3<f64>, nu: Twist) -> AccelerationLimit {
        let (rates, towards) = (
            std::mem::take(&mut self.rates),
            std::mem::take(&mut self.towards),
        );
        let limits = std::mem::take(&mut self.limits);
        let moment = Moment {
            rates: &rates,
            towards: &towards,
            limits: &limits,
            nu,
        };
        self.capacity.begin(&moment);
        let most = MOST_GRAVITIES * 9.81 / along.norm();
        let (mut low, mut high) = (0.0, 1e-3 * most);
        if self.worst(&moment, Vector3::zeros()).0 <= 1.0 {
            while high < most && self.worst(&moment, high * along).0 <= 1.0 {
                (low, high) = (high, 2.0 * high);
            }
            // Fifty halvings leave 1e-15 of it.
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if self.worst(&moment, middle * along).0 <= 1.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
        } else {
            high = 0.0;
        }
        let (_, wheel, cause) = self.worst(&moment, high * along);
        (self.rates, self.towards, self.limits) = (rates, towards, limits);
        AccelerationLimit {
            largest: low,
            wheel,
            cause,
        }
    }

    /// The worst use of grip or motor that an acceleration takes (above 1 where it cannot be had), of which wheel, and of which of the two.
    fn worst(&mut self, moment: &Moment<'_>, nu_rate: Vector3<f64>) -> (f64, usize, LimitCause) {
        let force = self.capacity.weigh(moment, nu_rate);
        let capacity = &self.capacity;
        match self.sharing {
            PushSharing::EqualLoops => {
                let kinematics = capacity.model.kinematics();
                let r = kinematics.rate_matrix();
                let mut whole = force;
                for (row, own) in r.row_iter().zip(&capacity.own_n_m) {
                    whole += row.transpose() * *own;
                }
                let x = self.squared.solve(&whole);
                for (h, push_n) in self.pushes_n.iter_mut().enumerate() {
                    let torque_n_m = r.row(h).transpose().dot(&x);
                    *push_n = (torque_n_m - capacity.own_n_m[h]) / kinematics.lever_m()[h];
                }
            }
            PushSharing::ByGrip => {
                let (motor, grips_n) = (&capacity.motor, &capacity.grips_n);
                capacity
                    .set
                    .distribute(&force, motor, grips_n, &mut self.pushes_n);
                // Out of reach the pushes are those at the edge: their wheels name the cause.
                let reached = self.capacity.within(moment, nu_rate);
                let (use_of, wheel, cause) = self.largest_use();
                let use_of = if reached {
                    use_of.min(1.0)
                } else {
                    f64::INFINITY
                };
                return (use_of, wheel, cause);
            }
        }
        self.largest_use()
    }

    /// The largest use of what a wheel has, over all pushes.
    fn largest_use(&self) -> (f64, usize, LimitCause) {
        let capacity = &self.capacity;
        let mut worst = (0.0, 0, LimitCause::Grip);
        for (h, push_n) in self.pushes_n.iter().enumerate() {
            let motor = capacity.motor[h];
            let bound_n = if *push_n >= 0.0 {
                motor.max_n
            } else {
                -motor.min_n
            };
            for (bound_n, cause) in [
                (capacity.grips_n[h], LimitCause::Grip),
                (bound_n, LimitCause::Motor),
            ] {
                let use_of = share_of(push_n.abs(), bound_n);
                if use_of > worst.0 {
                    worst = (use_of, h, cause);
                }
            }
        }
        worst
    }
}

/// A push as a share of its bound; infinite where there is none to be had.
fn share_of(push_n: f64, bound_n: f64) -> f64 {
    match push_n {
        0.0 if bound_n >= 0.0 => 0.0,
        _ if bound_n <= 0.0 => f64::INFINITY,
        _ => push_n / bound_n,
    }
}

#[cfg(test)]
mod tests;
