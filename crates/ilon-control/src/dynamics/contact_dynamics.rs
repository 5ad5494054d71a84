//! The dynamics of a robot in the plane on the rollers that touch, under loops on its wheels.
//!
//! [`AccelerationLimits`](crate::AccelerationLimits) takes rollers at the middles of their wheels, where a motion asks for forces that do not depend on
//! how far the wheels have turned. Where rollers really touch wanders by some of their lengths. Three things follow, all of one size:
//!
//! - loads are those of statics at these places;
//! - wheels that turn as eq. (9) says do not roll there as any twist does: the body takes a ripple, and more than three wheels strain one another, by
//!   what their loops answer to rates that they cannot have;
//! - where the robot turns, a roller that comes down lies further out or in than the one before, and moves at once as it must only if grip lasts.
//!
//! **Equations.** With the row r_h and the lever l_h of [`ContactKinematics`], the push f_h along the touching roller's axis, the body's own inertia B, its
//! remaining forces w (those of turning frames, drag, the slope), the loop's torque tau_h and the wheel's own inertia J_h and resistance,
//!
//!   B nu' = sum of r_h^T f_h - w,  J_h q''_h = tau_h - own_h - l_h f_h,  tau_h = k_p e_h + k_i integral(e_h),  e_h = target - q'_h,
//!
//! and r_h nu = l_h q'_h, or the push at the edge of the grip and against r_h nu - l_h q'_h: f_h within what mu N_h leaves beside what turns the roller.
//! Each step is implicit in loops and pushes, which are found by projected Gauss-Seidel; the loads N_h = a + b x_h + c y_h follow from weight and pushes
//! by turns with them. Bounces of loads, the spinning up of rollers that come down and two rollers at once are left out.
//!
//! A target that is held while it is due to rise makes a torque that falls by w T over the period T of a loop of bandwidth w: steps that are some to a
//! period show what is left at its end.

use ilon_robot::{Robot, Twist};
use nalgebra::{DMatrix, Matrix3, Vector2, Vector3};

use super::acceleration_limits::{LimitSettings, mismatch};
use super::capacity::{Capacity, Moment};
use super::loads::{inverse, share};
use super::wheel_force::{Moving, Touch, share_of};
use crate::error::{finite, positive};
use crate::{ContactKinematics, ControlError, Motor, TorqueRange, WheelGains};

/// A robot that rolls on its touching rollers, step by step, on a plane.
///
/// It starts at rest with its wheels at angle zero. Nothing is allocated once it is built.
#[derive(Clone, Debug)]
pub struct ContactDynamics {
    capacity: Capacity,
    contact: ContactKinematics,
    touches: Vec<Touch>,
    gains: WheelGains,
    friction: f64,
    along_slope_m_s2: f64,
    /// Direction in which the ground falls, in the body frame.
    downhill_rad: f64,
    /// B, inverted.
    inverse: Matrix3<f64>,
    mass_kg: f64,
    center_of_mass_m: Vector2<f64>,
    height_m: f64,
    nu: Vector3<f64>,
    wheels: Vec<WheelState>,
    /// What an impulse on one wheel's contact changes at another's, in (m/s)/(N s).
    response: DMatrix<f64>,
    // One number a wheel each.
    ideal_rad_s: Vec<f64>,
    ideal_rad_s2: Vec<f64>,
    middles_rad: Vec<f64>,
    limits: Vec<TorqueRange>,
    loads_n: Vec<f64>,
    places_m: Vec<Vector2<f64>>,
    used: Vec<f64>,
    slid_j: f64,
    given_j: f64,
    taken_j: f64,
}

#[derive(Clone, Debug, Default)]
struct WheelState {
    rate_rad_s: f64,
    angle_rad: f64,
    integral_n_m: f64,
    /// Along the roller's axis, of the last step.
    push_n: f64,
    /// Of the step: the wheel's inertia with what its loop holds against it, and its rate where nothing pushes.
    inertia_kg_m2: f64,
    free_rad_s: f64,
    /// How fast the contact would slide along the roller's axis where no wheel pushes.
    free_m_s: f64,
    /// For how long it has been at its grip, in seconds, and which share each wheel used when that began.
    at_grip_s: f64,
    used_then: Vec<f64>,
}

/// A wheel that has been at its grip for some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtGrip<'a> {
    /// The wheel's index.
    pub wheel: usize,
    /// For how long, up to the end of the last step, in seconds.
    pub for_s: f64,
    /// The share of its grip that each wheel used when that began.
    pub used: &'a [f64],
}

/// Of its grip: what a wheel uses from which on it counts as at its grip.
const AT_GRIP: f64 = 0.99;
/// How often loads and pushes are found by turns in a step, and pushes swept through each time; the share of a push's bound that is exact enough.
const TURNS: usize = 2;
const SWEEPS: usize = 200;
const EXACT: f64 = 1e-5;

impl ContactDynamics {
    /// The dynamics of a robot without joints between its bodies, under loops of these gains (whose derivative is left out), on the ground of these
    /// settings; pushes are shared as the loops do, and all of the grip is there.
    ///
    /// # Errors
    /// Those of [`AccelerationLimits::new`](crate::AccelerationLimits::new) and [`ContactKinematics::new`].
    pub fn new(
        robot: &Robot,
        settings: &LimitSettings,
        gains: WheelGains,
    ) -> Result<Self, ControlError> {
        let friction = positive("the friction coefficient", settings.friction)?;
        let gravity_m_s2 = positive("gravity in m/s^2", settings.gravity_m_s2)?;
        let slope_rad = finite("the slope in rad", settings.slope_rad)?;
        let across = positive("the cosine of the slope", libm::cos(slope_rad))?;
        let capacity = Capacity::new(robot, friction, gravity_m_s2 * across)?;
        let inverse = capacity.body.try_inverse();
        let inverse = inverse.ok_or_else(|| ControlError::NotPositive {
            what: "the smallest eigenvalue of the robot's inertia".to_owned(),
            value: 0.0,
        })?;
        let kinematics = capacity.model.kinematics();
        let levers_m = kinematics.lever_m().iter();
        let touches = robot.wheels.iter().zip(levers_m);
        let touches: Result<_, _> = touches.map(|(wheel, m)| Touch::new(wheel, *m)).collect();
        let n = kinematics.wheel_count();
        let center_m = robot.center_of_mass_m();
        let wheel = WheelState {
            used_then: vec![0.0; n],
            ..WheelState::default()
        };
        Ok(Self {
            contact: ContactKinematics::new(robot)?,
            touches: touches?,
            gains,
            friction,
            along_slope_m_s2: gravity_m_s2 * libm::sin(slope_rad),
            downhill_rad: finite("the direction downhill in rad", settings.downhill_rad)?,
            inverse,
            mass_kg: robot.mass_kg(),
            center_of_mass_m: center_m.xy(),
            height_m: center_m.z + robot.ride_height_m(),
            nu: Vector3::zeros(),
            wheels: vec![wheel; n],
            response: DMatrix::zeros(n, n),
            ideal_rad_s: vec![0.0; n],
            ideal_rad_s2: vec![0.0; n],
            middles_rad: vec![0.0; n],
            limits: vec![TorqueRange::UNLIMITED; n],
            loads_n: vec![0.0; n],
            places_m: vec![Vector2::zeros(); n],
            used: vec![0.0; n],
            slid_j: 0.0,
            given_j: 0.0,
            taken_j: 0.0,
            capacity,
        })
    }

    /// Lets it move with a twist at wheel angles in radians, one a wheel, its wheels at the rates of eq. (9).
    pub fn set_moving(&mut self, twist: Twist, angles_rad: &[f64]) {
        self.nu = Vector3::new(twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s);
        let kinematics = self.capacity.model.kinematics();
        kinematics.wheel_rates(twist, &mut self.ideal_rad_s);
        let rates = self.ideal_rad_s.iter().zip(angles_rad);
        for (wheel, (rate_rad_s, angle_rad)) in self.wheels.iter_mut().zip(rates) {
            (wheel.rate_rad_s, wheel.angle_rad) = (*rate_rad_s, *angle_rad);
        }
    }

    /// Takes a step of `dt_s` seconds, in which the loops' targets are the wheel rates of `target`, a twist in the body frame; `twist_rate` is how the
    /// twist changes in the mean, as components in the body frame, for what turns the rollers. There are as many motors as wheels.
    ///
    /// # Errors
    /// [`ControlError::LengthMismatch`]; [`ControlError::NotPositive`] for the step.
    pub fn step(
        &mut self,
        target: Twist,
        twist_rate: Twist,
        motors: &[Motor],
        dt_s: f64,
    ) -> Result<(), ControlError> {
        let n = self.wheels.len();
        if motors.len() != n {
            return Err(mismatch("motors", motors.len(), n));
        }
        positive("the step in s", dt_s)?;
        self.begin(target, motors, dt_s);
        let kinematics = self.capacity.model.kinematics();
        kinematics.wheel_rates(twist_rate, &mut self.ideal_rad_s2);
        let nu_rate = Vector3::new(twist_rate.vx_m_s, twist_rate.vy_m_s, twist_rate.omega_rad_s);
        let moving = Moving {
            nu: self.nu,
            towards: Vector3::new(target.vx_m_s, target.vy_m_s, target.omega_rad_s),
        };
        for _ in 0..TURNS {
            self.weigh();
            self.push(&moving, nu_rate, dt_s);
        }
        self.end(dt_s);
        Ok(())
    }

    /// The wheel that has been at its grip for longest, if for `for_s` seconds on end.
    pub fn at_grip(&self, for_s: f64) -> Option<AtGrip<'_>> {
        let wheels = self.wheels.iter().enumerate();
        let (wheel, longest) =
            wheels.max_by(|(_, a), (_, b)| a.at_grip_s.total_cmp(&b.at_grip_s))?;
        // Steps add up to it but for rounding.
        (longest.at_grip_s > (1.0 - 1e-9) * for_s).then_some(AtGrip {
            wheel,
            for_s: longest.at_grip_s,
            used: &longest.used_then,
        })
    }

    /// The share of its grip that each wheel used in the last step.
    pub fn grip_used(&self) -> &[f64] {
        &self.used
    }

    /// Energy that sliding along the rollers' axes has taken since it was built, in J.
    pub fn slid_energy_j(&self) -> f64 {
        self.slid_j
    }

    /// Energy that the motors have given where they drove since it was built, in J.
    pub fn given_energy_j(&self) -> f64 {
        self.given_j
    }

    /// Energy that the motors have taken where they braked since it was built, in J.
    pub fn taken_energy_j(&self) -> f64 {
        self.taken_j
    }

    /// The load of each wheel in the last step, in N.
    pub fn loads_n(&self) -> &[f64] {
        &self.loads_n
    }

    /// The twist in the body frame at the end of the last step.
    pub fn twist(&self) -> Twist {
        Twist::new(self.nu.x, self.nu.y, self.nu.z)
    }

    /// Takes in where rollers touch, and how all would move without pushes.
    fn begin(&mut self, target: Twist, motors: &[Motor], dt_s: f64) {
        for (middle_rad, wheel) in self.middles_rad.iter_mut().zip(&self.wheels) {
            *middle_rad = wheel.angle_rad + 0.5 * dt_s * wheel.rate_rad_s;
        }
        self.contact.update(&self.middles_rad);
        let (sin, cos) = libm::sincos(self.downhill_rad);
        self.capacity
            .pull_downhill(self.along_slope_m_s2 * Vector2::new(cos, sin));
        let kinematics = self.capacity.model.kinematics();
        let now = Twist::new(self.nu.x, self.nu.y, self.nu.z);
        kinematics.wheel_rates(now, &mut self.ideal_rad_s2);
        kinematics.wheel_rates(target, &mut self.ideal_rad_s);
        let moment = Moment {
            rates: &self.ideal_rad_s2,
            towards: &self.ideal_rad_s,
            limits: &self.limits,
            nu: now,
        };
        self.capacity.begin(&moment);
        let rest = self.capacity.weigh(&moment, Vector3::zeros());
        let free = self.nu - dt_s * (self.inverse * rest);

        let gain_n_m_s = self.gains.proportional_n_m_s + dt_s * self.gains.integral_n_m;
        for (h, wheel) in self.wheels.iter_mut().enumerate() {
            let (target, own_n_m) = (self.ideal_rad_s[h], self.capacity.own_n_m[h]);
            let inertia = self.capacity.model.wheel_inertias_kg_m2()[h];
            let asked = gain_n_m_s * (target - wheel.rate_rad_s) + wheel.integral_n_m;
            let range = self.touches[h].geared(motors[h].range(wheel.rate_rad_s), target);
            // A torque at the motor's limit stays as the wheel gains rate; below it the loop holds against that.
            let given = asked.clamp(range.min_n_m, range.max_n_m);
            wheel.inertia_kg_m2 = match given == asked {
                true => inertia + dt_s * gain_n_m_s,
                false => inertia,
            };
            wheel.free_rad_s = wheel.rate_rad_s + dt_s * (given - own_n_m) / wheel.inertia_kg_m2;
            let (row, lever_m) = (self.contact.rows().row(h), self.contact.lever_m()[h]);
            wheel.free_m_s = (row * free)[0] - lever_m * wheel.free_rad_s;
            let answer = self.inverse * row.transpose();
            for k in 0..motors.len() {
                self.response[(k, h)] = (self.contact.rows().row(k) * answer)[0];
            }
            self.response[(h, h)] += lever_m * lever_m / wheel.inertia_kg_m2;
        }
        self.nu = free;
    }

    /// Loads by weight and pushes, at the places where rollers touch.
    fn weigh(&mut self) {
        let rows = self.contact.rows().row_iter();
        let pushes = rows.zip(&self.wheels);
        let pushed = pushes
            .map(|(row, wheel)| row.transpose() * wheel.push_n)
            .sum::<Vector3<f64>>();
        let weight_n = self.mass_kg * self.capacity.gravity_m_s2();
        let moment = weight_n * self.center_of_mass_m - self.height_m * pushed.xy();
        let carried = Vector3::new(weight_n, moment.x, moment.y);
        let mut sum = Matrix3::zeros();
        for (place_m, contact) in self.places_m.iter_mut().zip(self.contact.contacts()) {
            *place_m = contact.point_in_body_m.xy();
            let at = Vector3::new(1.0, place_m.x, place_m.y);
            sum += at * at.transpose();
        }
        share(carried, &inverse(&sum), &self.places_m, &mut self.loads_n);
    }

    /// Pushes that let all roll, or slide at the edge of their grip.
    fn push(&mut self, moving: &Moving, nu_rate: Vector3<f64>, dt_s: f64) {
        let n = self.wheels.len();
        for _ in 0..SWEEPS {
            let mut most = 0.0_f64;
            for h in 0..n {
                let slides = (0..n).fold(self.wheels[h].free_m_s, |slides, k| {
                    slides + dt_s * self.response[(h, k)] * self.wheels[k].push_n
                });
                let wheel = &mut self.wheels[h];
                let [beside_n, across_n] = self.touches[h].beside_push(
                    moving,
                    nu_rate,
                    self.ideal_rad_s2[h],
                    self.loads_n[h],
                );
                let grip_n = self.friction * self.loads_n[h];
                let along_n = libm::sqrt((grip_n * grip_n - across_n * across_n).max(0.0));
                let wanted_n = wheel.push_n - slides / (dt_s * self.response[(h, h)]);
                // Not `clamp`, which panics where numbers have grown beyond all bounds.
                let push_n = wanted_n.max(-along_n - beside_n).min(along_n - beside_n);
                most = most.max((push_n - wheel.push_n).abs() / grip_n.max(f64::MIN_POSITIVE));
                wheel.push_n = push_n;
                self.used[h] = share_of(libm::hypot(push_n + beside_n, across_n), grip_n);
            }
            if most < EXACT {
                break;
            }
        }
    }

    /// Moves on under the pushes.
    fn end(&mut self, dt_s: f64) {
        for (row, wheel) in self.contact.rows().row_iter().zip(&self.wheels) {
            self.nu += dt_s * wheel.push_n * (self.inverse * row.transpose());
        }
        for h in 0..self.wheels.len() {
            let (row, lever_m) = (self.contact.rows().row(h), self.contact.lever_m()[h]);
            let inertia = self.capacity.model.wheel_inertias_kg_m2()[h];
            let wheel = &mut self.wheels[h];
            let slowed = dt_s * lever_m * wheel.push_n;
            let rate_rad_s = wheel.free_rad_s - slowed / wheel.inertia_kg_m2;
            let gained_rad_s = rate_rad_s - wheel.rate_rad_s;
            let given_n_m =
                inertia * gained_rad_s / dt_s + self.capacity.own_n_m[h] + lever_m * wheel.push_n;
            let given_w = given_n_m * (wheel.rate_rad_s + 0.5 * gained_rad_s);
            self.given_j += dt_s * given_w.max(0.0);
            self.taken_j += dt_s * (-given_w).max(0.0);
            let slides_m_s = (row * self.nu)[0] - lever_m * rate_rad_s;
            self.slid_j -= dt_s * wheel.push_n * slides_m_s;
            if wheel.inertia_kg_m2 > inertia {
                wheel.integral_n_m +=
                    dt_s * self.gains.integral_n_m * (self.ideal_rad_s[h] - rate_rad_s);
            }
            wheel.rate_rad_s = rate_rad_s;
            wheel.angle_rad += dt_s * rate_rad_s;
            if self.used[h] > AT_GRIP {
                if wheel.at_grip_s == 0.0 {
                    wheel.used_then.copy_from_slice(&self.used);
                }
                wheel.at_grip_s += dt_s;
            } else {
                wheel.at_grip_s = 0.0;
            }
        }
        self.downhill_rad -= dt_s * self.nu.z;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::mecanum4;
    use crate::{AccelerationLimits, DynamicModel, LoopTiming, MotorCurve, PushSharing};

    const STEP_S: f64 = 1e-3;

    fn on_ground(robot: &Robot, friction: f64, slope_rad: f64) -> (LimitSettings, ContactDynamics) {
        let settings = LimitSettings {
            friction,
            gravity_m_s2: 9.81,
            slope_rad,
            downhill_rad: 0.0,
            sharing: PushSharing::EqualLoops,
            share: 1.0,
        };
        let model = DynamicModel::new(robot).unwrap();
        let gains = WheelGains::for_robot(&model, LoopTiming::Continuous, STEP_S, 60.0).unwrap();
        let dynamics = ContactDynamics::new(robot, &settings, gains).unwrap();
        (settings, dynamics)
    }

    fn motors(robot: &Robot) -> Vec<Motor> {
        let wheels = robot.wheels.iter();
        wheels
            .map(|wheel| Motor::new(&wheel.motor, MotorCurve::Flat).unwrap())
            .collect()
    }

    /// Robot A on 5 deg, its rollers at the middles of its wheels: what its loops hold it with, and what its wheels bear, is what statics say; the loops'
    /// poles at 30 /s leave 1e-12 after a second, and it has gone down by less than a hundredth of a roller.
    #[test]
    fn a_robot_that_is_held_on_a_slope_takes_what_statics_say() {
        let mut robot = mecanum4();
        for wheel in &mut robot.wheels {
            wheel.motor.effort_n_m = 100.0;
        }
        let (settings, mut dynamics) = on_ground(&robot, 0.6, 5.0_f64.to_radians());
        let (rest, motors) = (Twist::default(), motors(&robot));
        for _ in 0..1000 {
            dynamics.step(rest, rest, &motors, STEP_S).unwrap();
        }
        let mut limits = AccelerationLimits::new(&robot, &settings).unwrap();
        let mut used = [0.0; 4];
        limits.grip_used(rest, rest, &motors, &mut used).unwrap();
        let loads_n = limits.loads_n(rest, &motors).unwrap();
        for h in 0..4 {
            let [used, load] = [
                dynamics.grip_used()[h] / used[h],
                dynamics.loads_n()[h] / loads_n[h],
            ];
            // Rollers touch up to a millimetre off, of 150 mm.
            assert!(
                (used - 1.0).abs() < 0.01 && (load - 1.0).abs() < 0.01,
                "{used} {load}"
            );
        }
        assert_eq!(dynamics.at_grip(0.02), None);
    }

    /// Four mecanum wheels that are asked for far more than there is slide: each pushes with mu N along its roller, at 45 deg, so that the robot gains
    /// mu g / sqrt 2 m / (m + rollers), whatever its loads; and all are at their grip from the first step on.
    #[test]
    fn wheels_that_slide_push_with_their_grip() {
        let mut robot = mecanum4();
        for wheel in &mut robot.wheels {
            wheel.motor.effort_n_m = 100.0;
        }
        let (_, mut dynamics) = on_ground(&robot, 0.2, 0.0);
        let (fast, motors) = (Twist::new(5.0, 0.0, 0.0), motors(&robot));
        for _ in 0..100 {
            dynamics
                .step(fast, Twist::default(), &motors, STEP_S)
                .unwrap();
        }
        // Axes of rollers that have turned by up to 20 deg lie up to 1.7 deg nearer to the hub's, and rollers that are to be spun weigh some thousandths.
        let expected = 0.1 * 0.2 * 9.81 / 2.0_f64.sqrt();
        let gained = dynamics.twist().vx_m_s / expected;
        assert!((gained - 1.0).abs() < 0.04, "{gained}");
        let found = dynamics.at_grip(0.1).expect("all slide");
        assert!((found.for_s - 0.1).abs() < 1e-9, "{found:?}");
        assert!(found.used.iter().all(|used| *used > AT_GRIP), "{found:?}");
    }

    /// What motors give is in what moves, or was lost to sliding: without drag, on level ground, a robot that is asked for half more than its grip
    /// holds, in steps that take a hundredth of what they gain. One that rolls loses nothing.
    #[test]
    fn what_motors_give_moves_the_robot_or_is_lost_to_sliding() {
        let mut robot = mecanum4();
        for wheel in &mut robot.wheels {
            wheel.motor.effort_n_m = 100.0;
            wheel.joint.damping_n_m_s = 0.0;
            for roller in &mut wheel.rollers {
                roller.joint.damping_n_m_s = 0.0;
            }
        }
        let motors = motors(&robot);
        // Along rollers at 45 deg: the limit is mu g / sqrt 2, but for the rollers' own inertia.
        let limit_m_s2 = 0.2 * 9.81 / 2.0_f64.sqrt();
        for (share, slides) in [(0.5, false), (1.5, true)] {
            let (_, mut dynamics) = on_ground(&robot, 0.2, 0.0);
            let rate = Twist::new(share * limit_m_s2, 0.0, 0.0);
            let steps = 5000;
            for step in 1..=steps {
                let target = rate.scaled(0.2 * STEP_S * f64::from(step));
                dynamics
                    .step(target, rate, &motors, 0.2 * STEP_S)
                    .expect("a step");
            }
            let body = dynamics.inverse.try_inverse().expect("its inertia");
            let wheels = dynamics.wheels.iter();
            let inertias = dynamics.capacity.model.wheel_inertias_kg_m2();
            let spins_j: f64 = wheels
                .zip(inertias)
                .map(|(wheel, inertia)| 0.5 * inertia * wheel.rate_rad_s.powi(2))
                .sum();
            let moves_j = 0.5 * dynamics.nu.dot(&(body * dynamics.nu)) + spins_j;
            let slid_j = dynamics.slid_energy_j();
            let given_j = dynamics.given_energy_j() - dynamics.taken_energy_j();
            let missing = (given_j - moves_j - slid_j) / given_j;
            assert!(missing.abs() < 0.01, "{share}: {missing}");
            let lost = slid_j / given_j;
            // It gains two thirds of what it is asked for at most, and the wheels turn for all of it.
            assert!(
                if slides {
                    lost > 0.1
                } else {
                    lost.abs() < 1e-3
                },
                "{share}: {lost}"
            );
        }
    }

    /// What a roller's bearing takes across the roller's axis counts against the same grip as the hub's push along it: a wheel that slides uses all of its grip and
    /// no more. A dry torque of 30 mN m on rollers of 12 mm is 2.5 N across, of a grip of 0.2 times 29 N.
    #[test]
    fn wheels_that_slide_on_stiff_rollers_use_no_more_than_their_grip() {
        let mut robot = mecanum4();
        for wheel in &mut robot.wheels {
            wheel.motor.effort_n_m = 100.0;
            for roller in &mut wheel.rollers {
                roller.joint.friction_n_m = 0.03;
            }
        }
        let (_, mut dynamics) = on_ground(&robot, 0.2, 0.0);
        let (aside, motors) = (Twist::new(0.0, 5.0, 0.0), motors(&robot));
        for _ in 0..50 {
            dynamics
                .step(aside, Twist::default(), &motors, STEP_S)
                .unwrap();
        }
        // Sweeps leave pushes exact to 1e-5 of the grip, and at it.
        for used in dynamics.grip_used() {
            assert!((used - 1.0).abs() < 1e-6, "{used}");
        }
    }

    /// A step counts its contacts where rollers touch in its middle: wheels that pass an angle then touch where those of a robot do that rests at it, at any
    /// length of the step.
    #[test]
    fn in_a_step_rollers_touch_where_they_do_in_its_middle() {
        let robot = mecanum4();
        let motors = motors(&robot);
        let twist = Twist::new(0.4, 0.3, 0.5);
        let mut rates = [0.0; 4];
        let kinematics = crate::Kinematics::new(&robot).unwrap();
        kinematics.wheel_rates(twist, &mut rates);
        // A third of the way from a roller to the next.
        let middles = [0.23; 4];
        let touching = |moves: Twist, angles: [f64; 4], dt_s: f64| {
            let (_, mut dynamics) = on_ground(&robot, 0.6, 0.0);
            dynamics.set_moving(moves, &angles);
            dynamics
                .step(moves, Twist::default(), &motors, dt_s)
                .unwrap();
            dynamics.places_m.clone()
        };
        let resting = touching(Twist::default(), middles, STEP_S);
        for dt_s in [STEP_S, 5e-3] {
            let before = [0, 1, 2, 3].map(|h| middles[h] - 0.5 * dt_s * rates[h]);
            let passing = touching(twist, before, dt_s);
            for (passing, resting) in passing.iter().zip(&resting) {
                assert!((passing - resting).norm() < 1e-12, "{passing} {resting}");
            }
        }
    }

    /// On level ground, from rest, slowly: it follows, to within the lag of its loops. A ramp of a m/s^2 is followed by a loop of poles -w / 2 twice with
    /// an error that vanishes, so that after a second the speed is a t.
    #[test]
    fn a_robot_that_rolls_follows_its_loops() {
        let robot = mecanum4();
        let (_, mut dynamics) = on_ground(&robot, 0.6, 0.0);
        let (rate, motors) = (Twist::new(0.5, 0.0, 0.0), motors(&robot));
        for step in 1..=1000 {
            let target = rate.scaled(STEP_S * f64::from(step));
            dynamics.step(target, rate, &motors, STEP_S).unwrap();
        }
        // Straight ahead rollers do not ripple.
        let speed = dynamics.twist().vx_m_s;
        assert!((speed / 0.5 - 1.0).abs() < 1e-3, "{speed}");
        assert_eq!(dynamics.at_grip(STEP_S), None);
    }
}
