//! The largest accelerations at which no wheel slides and no motor lacks torque.
//!
//! An acceleration of the body needs a force and a moment from the ground, which the wheels share.
//! For N > 3 the shares are not unique; the wheels' loops decide them:
//!
//! - **Loops of equal gains** ([`PushSharing::EqualLoops`]). While the wheels roll, their rate
//!   errors are those of a motion of the body, e = R e_nu, so that the torques are tau = R x for
//!   some x: the shortest of all torques with the force R^T tau = F, tau = R (R^T R)^-1 F. A wheel
//!   that the acceleration unloads gets as much torque as the others and slides first.
//! - **By grip** ([`PushSharing::ByGrip`]), as [`PrioritisedTorque`](crate::PrioritisedTorque)
//!   does: anything within the set of reachable forces.
//!
//! **At the ground.** A wheel holds while the force on it is within mu N, with the load N that the
//! acceleration itself shifts. Across the roller's axis the ground turns the roller, with g = -(J_r
//! s' + b) / r along u_gamma: s is the roller's spin in space and b the drag of its bearing. Along
//! the axis it pushes with f; the wheel's balance about its hub axis n, with the torque tau and the
//! torque `own` that the wheel needs for itself, is
//!
//!   tau - own = -rho cos(gamma) f + rho (n . n_gamma) g + J_r s' (n . n_gamma).
//!
//! All of this, and the motors' bounds, is linear in the acceleration while no wheel lifts: the
//! limits along a line of accelerations are roots. If a wheel lifts, or pushes are shared by grip,
//! bisection finds the limits, because the feasible set is convex.

mod answers;
mod polytope;
mod search;

use ilon_robot::{Robot, Twist};
use nalgebra::{Cholesky, Const, Matrix3, RowVector3, Vector2, Vector3};

use super::capacity::{Capacity, Moment};
use super::traction::PushRange;
use super::wheel_force::{Moving, SLACK_N, Touch, WheelForce, share_of};
use crate::error::{finite, positive};
use crate::kinematics::matrix::{twist_of, vector_of};
use crate::{ControlError, Motor, TorqueRange};

pub use answers::{
    AccelerationLimit, AccelerationRange, AccelerationUse, LimitCause, LimitSettings, LimitedBy,
    PushSharing,
};
pub use polytope::AccelerationPolytope;

/// Computes the accelerations that a robot's motors and grip allow.
///
/// The touching rollers are taken at their middles, below the hubs; rolling resistance, treads and
/// creep are neglected. After construction nothing is allocated.
#[derive(Clone, Debug)]
pub struct AccelerationLimits {
    capacity: Capacity,
    sharing: PushSharing,
    share: f64,
    /// Gravity along the slope in m/s^2.
    along_slope_m_s2: f64,
    /// R^T R.
    squared: Cholesky<f64, Const<3>>,
    touches: Vec<Touch>,
    // Buffers of one number per wheel.
    rates: Vec<f64>,
    towards: Vec<f64>,
    limits: Vec<TorqueRange>,
    forces: Vec<WheelForce>,
    before: Vec<WheelForce>,
    pushes_n: Vec<f64>,
}

/// A line of accelerations in the body frame.
#[derive(Clone, Copy, Debug)]
struct Course {
    base: Vector3<f64>,
    along: Vector3<f64>,
}

impl Course {
    fn at(&self, scale: f64) -> Vector3<f64> {
        self.base + scale * self.along
    }
}

/// Placeholder where no wheel limits.
const NOTHING: LimitedBy = LimitedBy {
    wheel: 0,
    cause: LimitCause::Grip,
};

impl AccelerationLimits {
    /// Builds the limits of a robot.
    ///
    /// # Errors
    /// Those of [`DynamicModel::new`](crate::DynamicModel::new); [`ControlError::NotPositive`] and
    /// [`ControlError::NotFinite`] for settings; the first also for a slope of 90 degrees or more
    /// and for a share above 1.
    pub fn new(robot: &Robot, settings: &LimitSettings) -> Result<Self, ControlError> {
        positive("the friction coefficient", settings.friction)?;
        positive("gravity in m/s^2", settings.gravity_m_s2)?;
        let share = positive("the share of the limits", settings.share)?;
        positive("what the share of the limits leaves of 2", 2.0 - share)?;
        let slope_rad = finite("the slope in rad", settings.slope_rad)?;
        let across = libm::cos(slope_rad);
        positive("the cosine of the slope", across)?;
        let capacity = Capacity::new(
            robot,
            settings.friction * share,
            settings.gravity_m_s2 * across,
        )?;
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
        let levers_m = kinematics.lever_m().iter();
        let touches = robot.wheels.iter().zip(levers_m);
        let touches: Result<_, _> = touches.map(|(wheel, m)| Touch::new(wheel, *m)).collect();
        let mut limits = Self {
            touches: touches?,
            capacity,
            sharing: settings.sharing,
            share,
            along_slope_m_s2: settings.gravity_m_s2 * libm::sin(slope_rad),
            squared,
            rates: vec![0.0; n],
            towards: vec![0.0; n],
            limits: vec![TorqueRange::UNLIMITED; n],
            forces: vec![WheelForce::default(); n],
            before: vec![WheelForce::default(); n],
            pushes_n: vec![0.0; n],
        };
        limits.turn_slope(settings.downhill_rad)?;
        Ok(limits)
    }

    /// Sets the downhill direction in the body frame, in radians from the x axis.
    ///
    /// # Errors
    /// [`ControlError::NotFinite`].
    pub fn turn_slope(&mut self, downhill_rad: f64) -> Result<(), ControlError> {
        let (sin, cos) = libm::sincos(finite("the direction downhill in rad", downhill_rad)?);
        self.capacity
            .pull_downhill(self.along_slope_m_s2 * Vector2::new(cos, sin));
        Ok(())
    }

    /// Returns the largest acceleration along `direction`, a rate of change of the twist (d/dt of
    /// its components in the body frame), while the robot moves with `twist`. `motors` has one
    /// motor per wheel. Dry friction acts against the wheels' rates; at rest against the rates to
    /// which the acceleration leads.
    ///
    /// # Errors
    /// [`ControlError::LengthMismatch`]; [`ControlError::NotFinite`] and, for a direction of length
    /// zero, [`ControlError::NotPositive`].
    pub fn along(
        &mut self,
        direction: Twist,
        twist: Twist,
        motors: &[Motor],
    ) -> Result<AccelerationLimit, ControlError> {
        let range = self.range(Twist::default(), direction, twist, motors)?;
        let stands = self.tipping_margin_m(Twist::default()) > 0.0;
        let range = range.filter(|range| stands && range.least <= 0.0 && range.largest >= 0.0);
        if let Some(range) = range {
            // Below 1e-9 N, or 1e-7 of gravity, the limit counts as zero.
            let all = direction.vx_m_s.abs()
                + direction.vy_m_s.abs()
                + self.arm_m() * direction.omega_rad_s.abs();
            let is_rounding = range.largest * all < 1e-7 * self.capacity.gravity_m_s2();
            return Ok(AccelerationLimit {
                largest: if is_rounding { 0.0 } else { range.largest },
                wheel: range.largest_by.wheel,
                cause: range.largest_by.cause,
            });
        }
        let (moving, course) = self.begin(Twist::default(), direction, twist, motors)?;
        let by = self.lacking(&moving, course.at(0.0));
        Ok(AccelerationLimit {
            largest: 0.0,
            wheel: by.wheel,
            cause: by.cause,
        })
    }

    /// Returns the interval of a for which the acceleration `base` + a `along` is possible, both
    /// rates of change of the twist as in [`Self::along`]; `None` if there is none. The interval
    /// may exclude zero: a robot on a slope that is too steep to stand on can still accelerate
    /// downhill.
    ///
    /// # Errors
    /// Those of [`Self::along`].
    pub fn range(
        &mut self,
        base: Twist,
        along: Twist,
        twist: Twist,
        motors: &[Motor],
    ) -> Result<Option<AccelerationRange>, ControlError> {
        let (moving, course) = self.begin(base, along, twist, motors)?;
        let found = match self.sharing {
            PushSharing::EqualLoops => match self.by_roots(&moving, &course) {
                Some(interval) => (!interval.is_empty()).then_some(interval),
                None => self.by_halving(&moving, &course),
            },
            PushSharing::ByGrip => self.by_halving(&moving, &course),
        };
        Ok(found.map(|found| AccelerationRange {
            least: found.low,
            largest: found.high,
            least_by: found.holds_low,
            largest_by: found.holds_high,
        }))
    }

    /// Writes to `out` the share of its grip that each wheel uses at an acceleration, a rate of
    /// change of the twist as in [`Self::along`]: 1 where it is about to slide, infinite for a
    /// wheel in the air that has to push.
    ///
    /// # Errors
    /// Those of [`Self::along`]; an acceleration of zero is fine.
    pub fn grip_used(
        &mut self,
        twist_rate: Twist,
        twist: Twist,
        motors: &[Motor],
        out: &mut [f64],
    ) -> Result<(), ControlError> {
        let n = self.rates.len();
        if out.len() != n {
            return Err(mismatch("shares", out.len(), n));
        }
        let (moving, nu_rate) = self.begin_at(twist_rate, twist, motors)?;
        self.fill_asked(&moving, nu_rate);
        for (out, force) in out.iter_mut().zip(&self.forces) {
            let [f, g] = force.at_ground_n;
            *out = share_of(libm::hypot(f, g), force.grip_n / self.share);
        }
        Ok(())
    }

    /// Returns the share of grip and motor torque that an acceleration needs, a rate of change of
    /// the twist as in [`Self::along`].
    ///
    /// # Errors
    /// Those of [`Self::along`]; an acceleration of zero is fine.
    pub fn used(
        &mut self,
        twist_rate: Twist,
        twist: Twist,
        motors: &[Motor],
    ) -> Result<AccelerationUse, ControlError> {
        let (moving, nu_rate) = self.begin_at(twist_rate, twist, motors)?;
        let force = self.fill_asked(&moving, nu_rate);
        let used = self.largest_use();
        let ranges = self.forces.iter().map(WheelForce::range);
        let is_reached = self.capacity.set.outside_n(&force, ranges) <= SLACK_N;
        if self.sharing == PushSharing::EqualLoops || is_reached {
            return Ok(used);
        }
        // Upper bound of the grip's scale, without motors: finds the smallest worst use beyond the
        // available grip.
        const MORE: f64 = 1e3;
        let open = PushRange {
            min_n: f64::NEG_INFINITY,
            max_n: f64::INFINITY,
        };
        let capacity = &mut self.capacity;
        capacity.motor.fill(open);
        capacity
            .grips_n
            .iter_mut()
            .for_each(|grip_n| *grip_n *= MORE);
        let grip = MORE
            * capacity.set.distribute(
                &force,
                &capacity.motor,
                &capacity.grips_n,
                &mut self.pushes_n,
            );
        let share = if grip > 1.0 { grip } else { f64::INFINITY };
        let cause = if grip > 1.0 {
            LimitCause::Grip
        } else {
            used.by.cause
        };
        Ok(AccelerationUse {
            share: share * self.share,
            by: LimitedBy { cause, ..used.by },
        })
    }

    /// Returns the load of each wheel at an acceleration from rest, in N.
    ///
    /// # Errors
    /// Those of [`Self::grip_used`].
    pub fn loads_n(
        &mut self,
        twist_rate: Twist,
        motors: &[Motor],
    ) -> Result<Vec<f64>, ControlError> {
        let (moving, nu_rate) = self.begin_at(twist_rate, Twist::default(), motors)?;
        self.weigh(&moving, nu_rate);
        Ok(self.capacity.loads_n.clone())
    }

    /// Returns the distance from the point where weight and inertia meet the ground to the edge of
    /// the wheels' polygon, at an acceleration without rotation, in metres; below zero the robot
    /// tips over.
    pub fn tipping_margin_m(&self, twist_rate: Twist) -> f64 {
        let rate = Vector2::new(twist_rate.vx_m_s, twist_rate.vy_m_s);
        self.capacity.margin_m(rate)
    }

    /// Returns the distance of the outermost wheel from the body's origin, in metres.
    pub(crate) fn arm_m(&self) -> f64 {
        let wheels = self.capacity.model.kinematics().wheels().iter();
        let far = wheels.map(|wheel| wheel.position_m().xy().norm());
        far.fold(0.0, f64::max)
    }

    /// Returns the fastest wheel rate at a twist, in rad/s.
    pub(crate) fn fastest_rate_rad_s(&self, twist: Twist) -> f64 {
        let nu = vector_of(twist);
        let rows = self.capacity.model.kinematics().rate_matrix().row_iter();
        let rate = rows.map(|row| (row[0] * nu.x + row[1] * nu.y + row[2] * nu.z).abs());
        rate.fold(0.0, f64::max)
    }

    /// Stores the robot's motion and an acceleration, which may be zero.
    fn begin_at(
        &mut self,
        twist_rate: Twist,
        twist: Twist,
        motors: &[Motor],
    ) -> Result<(Moving, Vector3<f64>), ControlError> {
        let still = Twist::default();
        let (base, along) = match twist_rate == still {
            true => (still, Twist::new(1.0, 0.0, 0.0)),
            false => (twist_rate, twist_rate),
        };
        let (moving, course) = self.begin(base, along, twist, motors)?;
        Ok((moving, course.base))
    }

    /// Stores the robot's motion and a line of accelerations.
    fn begin(
        &mut self,
        base: Twist,
        along: Twist,
        twist: Twist,
        motors: &[Motor],
    ) -> Result<(Moving, Course), ControlError> {
        let n = self.rates.len();
        if motors.len() != n {
            return Err(mismatch("motors", motors.len(), n));
        }
        let vector = |what: &str, t: Twist| {
            let components = [t.vx_m_s, t.vy_m_s, t.omega_rad_s];
            components
                .iter()
                .try_for_each(|x| finite(what, *x).map(drop))?;
            Ok(Vector3::from(components))
        };
        let nu = vector("a component of the twist", twist)?;
        let base = vector("a component of the acceleration", base)?;
        let along = vector("a component of the direction", along)?;
        let length = positive("the direction's length", along.norm())?;
        // A wheel (nearly) at rest is about to turn as the acceleration moves it.
        let towards = match nu.norm() {
            0.0 => along,
            speed => nu + 1e-6 * speed / length * along,
        };
        let kinematics = self.capacity.model.kinematics();
        kinematics.wheel_rates(twist, &mut self.rates);
        let there = twist_of(towards);
        kinematics.wheel_rates(there, &mut self.towards);
        for (h, limit) in self.limits.iter_mut().enumerate() {
            let range = motors[h].range(self.rates[h]);
            *limit = self.touches[h].geared(range, self.towards[h]);
            limit.min_n_m *= self.share;
            limit.max_n_m *= self.share;
        }
        let moving = Moving { nu, towards };
        self.with_moment(&moving, |capacity, moment| capacity.begin(moment));
        Ok((moving, Course { base, along }))
    }

    fn with_moment<T>(
        &mut self,
        moving: &Moving,
        act: impl FnOnce(&mut Capacity, &Moment<'_>) -> T,
    ) -> T {
        let moment = Moment {
            rates: &self.rates,
            towards: &self.towards,
            limits: &self.limits,
            nu: twist_of(moving.nu),
        };
        act(&mut self.capacity, &moment)
    }

    /// Computes the force of each wheel at an acceleration for pushes shared by equal loops;
    /// returns the force that the body needs.
    fn weigh(&mut self, moving: &Moving, nu_rate: Vector3<f64>) -> Vector3<f64> {
        let force = self.with_moment(moving, |capacity, moment| capacity.weigh(moment, nu_rate));
        let capacity = &self.capacity;
        let r = capacity.model.kinematics().rate_matrix();
        let mut whole = force;
        for (row, own) in r.row_iter().zip(&capacity.own_n_m) {
            whole += row.transpose() * *own;
        }
        let x = self.squared.solve(&whole);
        for (h, touch) in self.touches.iter().enumerate() {
            let row: RowVector3<f64> = r.fixed_view::<1, 3>(h, 0).into();
            let push_n = ((row * x)[0] - capacity.own_n_m[h]) / touch.lever_m;
            let load_n = capacity.loads_n[h];
            let [beside_n, across_n] =
                touch.beside_push(moving, nu_rate, (row * nu_rate)[0], load_n);
            self.forces[h] = WheelForce {
                push_n,
                at_ground_n: [push_n + beside_n, across_n],
                grip_n: capacity.grips_n[h],
                motor: capacity.motor[h],
                load_n,
            };
        }
        force
    }

    /// Returns the limit that an acceleration exceeds most.
    fn lacking(&mut self, moving: &Moving, nu_rate: Vector3<f64>) -> LimitedBy {
        self.fill_asked(moving, nu_rate);
        self.worst().1
    }

    /// Computes the force of each wheel with pushes shared as the wheels do; returns the force that
    /// the body needs.
    fn fill_asked(&mut self, moving: &Moving, nu_rate: Vector3<f64>) -> Vector3<f64> {
        let force = self.weigh(moving, nu_rate);
        if self.sharing == PushSharing::ByGrip {
            let capacity = &self.capacity;
            let (motor, grips_n) = (&capacity.motor, &capacity.grips_n);
            // If the force is out of reach, the pushes at the boundary name the cause.
            capacity
                .set
                .distribute(&force, motor, grips_n, &mut self.pushes_n);
            for (force, push_n) in self.forces.iter_mut().zip(&self.pushes_n) {
                force.at_ground_n[0] += push_n - force.push_n;
                force.push_n = *push_n;
            }
        }
        force
    }

    /// Returns the largest share of its limits that any wheel uses.
    fn largest_use(&self) -> AccelerationUse {
        let mut worst = AccelerationUse {
            share: 0.0,
            by: NOTHING,
        };
        for (wheel, force) in self.forces.iter().enumerate() {
            let [f, g] = force.at_ground_n;
            let has_n = match force.push_n >= 0.0 {
                true => force.motor.max_n,
                false => -force.motor.min_n,
            };
            for (asked_n, has_n, cause) in [
                (libm::hypot(f, g), force.grip_n, LimitCause::Grip),
                (force.push_n.abs(), has_n, LimitCause::Motor),
            ] {
                let share = self.share * share_of(asked_n, has_n);
                if share > worst.share {
                    let by = LimitedBy { wheel, cause };
                    worst = AccelerationUse { share, by };
                }
            }
        }
        worst
    }

    /// Returns the wheel that exceeds its limits most, and by how much, in N.
    fn worst(&self) -> (f64, LimitedBy) {
        let mut worst = (f64::NEG_INFINITY, NOTHING);
        for (wheel, force) in self.forces.iter().enumerate() {
            let [f, g] = force.at_ground_n;
            let motor = force.motor;
            let lacking_n = (force.push_n - motor.max_n).max(motor.min_n - force.push_n);
            for (lacks_n, cause) in [
                (libm::hypot(f, g) - force.grip_n, LimitCause::Grip),
                (lacking_n, LimitCause::Motor),
            ] {
                if lacks_n > worst.0 {
                    worst = (lacks_n, LimitedBy { wheel, cause });
                }
            }
        }
        worst
    }
}

pub(super) fn mismatch(left: &'static str, left_count: usize, wheels: usize) -> ControlError {
    ControlError::LengthMismatch {
        left,
        left_count,
        right: "wheels",
        right_count: wheels,
    }
}

#[cfg(test)]
mod tests;
