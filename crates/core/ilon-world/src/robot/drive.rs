//! The torque of a motor on its wheel through its gear, as a curve over the wheel's rate.
//!
//! **The motor** gives its torque within its limits, falling with the rate ([`MotorTorque`]); at
//! its rate limit it stops driving.
//!
//! **The rotor.** Part of the torque accelerates the rotor: with its inertia J at the wheel and the
//! rate u gained over dt, the gear receives g = motor - J (u - u_0) / dt.
//!
//! **The gear** loses by friction in its mesh, which grows with the torque w that it passes to the
//! wheel: a torque of (1 / eta - 1) |w| against the motion. If the motor drives (g along the rate),
//! w = eta g. If the load drives, the same mesh friction helps the motor to brake: w = g / (2 - 1 /
//! eta), the textbook's efficiency 2 - 1 / eta from wheel to motor. At eta of one half and below
//! that vanishes: no load turns the motor, the gear is self-locking. The wheel then turns only as
//! far as its motor drives it, and if the motor gives nothing or brakes, it stands. For a load that
//! drives a turning wheel the same line, g = w (2 - 1 / eta), then has a g along the motion: the
//! motor must push. That branch has two answers for each torque of the motor, so the step is solved
//! with the wheel at the rate to which the motor turns, and g is counted as the motor's torque.
//!
//! **Dry friction** of bearing and gear is added, against the motion.
//!
//! Each of these falls as the rate grows, and so does the sum: because everything else in a step is
//! linear in the rates, the solution is unique.

use ilon_robot::Wheel;

use crate::MotorTorque;
use crate::contact::law::Curve;

/// The drive of a wheel in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WheelDrive {
    motor: MotorTorque,
    /// The wheel's rate at the beginning of the step, in rad/s.
    before_rad_s: f64,
    /// The rotor's inertia at the wheel over the length of the step, in N m s/rad.
    rotor_n_m_s: f64,
    efficiency: f64,
    friction_n_m: f64,
}

/// The largest number of rates at which the curve may bend.
const BENDS: usize = 20;

/// Bends nearer than this count as one, in rad/s. Chosen.
const APART_RAD_S: f64 = 1e-10;

impl WheelDrive {
    /// For a motor over a step of a length in s, its wheel, and the rate at the beginning of the
    /// step, in rad/s.
    pub fn new(motor: &MotorTorque, wheel: &Wheel, before_rad_s: f64, dt_s: f64) -> Self {
        Self {
            motor: *motor,
            before_rad_s,
            rotor_n_m_s: wheel.drive.reflected_inertia_kg_m2() / dt_s,
            efficiency: wheel.drive.gear_efficiency,
            friction_n_m: wheel.dry_friction_n_m(),
        }
    }

    /// Writes the impulses of a step of a length in s over the possible rates of the wheel at its
    /// end, in N m s: the drive without the rotor's inertia and without the straight line of the
    /// motor, with which the step is solved.
    pub fn fill_curve(&self, straight: &MotorTorque, dt_s: f64, curve: &mut Curve) {
        let points = &mut curve.points;
        points.clear();
        let locks_back = self.mirrored().go_forward(points);
        points.reverse();
        for [rate_rad_s, torque_n_m] in points.iter_mut() {
            (*rate_rad_s, *torque_n_m) = (-*rate_rad_s, -*torque_n_m);
        }
        let locks = self.go_forward(points);
        if points.is_empty() {
            points.push([0.0, 0.0]);
        }
        for [rate_rad_s, torque_n_m] in points.iter_mut() {
            let gained_rad_s = *rate_rad_s - self.before_rad_s;
            let solved_n_m =
                straight.torque_n_m - (straight.droop_n_m_s + self.rotor_n_m_s) * gained_rad_s;
            *torque_n_m = dt_s * (*torque_n_m - solved_n_m);
        }
        let along = |from: usize| {
            let ([u_0, p_0], [u_1, p_1]) = (points[from], points[from + 1]);
            [u_1 - u_0, p_1 - p_0]
        };
        let held = [0.0, -1.0];
        curve.ends = [
            if locks_back { held } else { along(0) },
            if locks { held } else { along(points.len() - 2) },
        ];
    }

    /// The motor's own torque, in N m, for a wheel that ended the step at a rate, in rad/s, with
    /// this torque of the drive on it without the rotor's inertia, in N m.
    pub fn motor_n_m(&self, rate_rad_s: f64, on_wheel_n_m: f64) -> f64 {
        /// The solver's tolerance of a rate. Chosen.
        const ROUNDED_RAD_S: f64 = 1e-7;
        let gained_rad_s = rate_rad_s - self.before_rad_s;
        let free_n_m = self.motor.at_gain(gained_rad_s);
        let way = rate_rad_s.signum();
        let rotor_n_m = self.rotor_n_m_s * gained_rad_s;
        let passed_n_m = way * (on_wheel_n_m - rotor_n_m) + self.friction_n_m;
        let needed_n_m = way * self.needed_n_m(passed_n_m) + rotor_n_m;
        let drives = free_n_m * rate_rad_s > 0.0;
        if drives && rate_rad_s.abs() >= self.motor.rate_limit_rad_s - ROUNDED_RAD_S {
            // At its rate limit it gives the torque needed to stay there.
            way * (way * needed_n_m).clamp(0.0, free_n_m.abs())
        } else if self.locks() && passed_n_m < 0.0 && rate_rad_s.abs() > ROUNDED_RAD_S {
            // The load pushes into a self-locking gear: the motor turns it on.
            let most_n_m = self.motor.bounds.limit_n_m;
            needed_n_m.clamp(-most_n_m, most_n_m)
        } else {
            free_n_m
        }
    }

    /// Whether the gear is self-locking.
    fn locks(&self) -> bool {
        2.0 * self.efficiency <= 1.0
    }

    /// The torque that the gear needs along the motion, in N m, to pass this torque to the wheel.
    fn needed_n_m(&self, passed_n_m: f64) -> f64 {
        if passed_n_m > 0.0 {
            passed_n_m / self.efficiency
        } else {
            passed_n_m * (2.0 - 1.0 / self.efficiency)
        }
    }

    /// The same drive for a wheel that turns the other way.
    fn mirrored(&self) -> Self {
        Self {
            motor: self.motor.mirrored(),
            before_rad_s: -self.before_rad_s,
            ..*self
        }
    }

    /// Adds the torque of the drive on the wheel at rates from 0 on, in N m, without the rotor's
    /// inertia: at each rate in rad/s at which it bends, and one beyond. Returns whether the gear
    /// locks the wheel at the last of them, or at 0 if there is none.
    fn go_forward(&self, points: &mut Vec<[f64; 2]>) -> bool {
        let locks = self.locks();
        let limit_rad_s = self.motor.rate_limit_rad_s;
        let bends = self.bends_rad_s();
        let is_apart = |index: usize| {
            let [before, now] = [bends[index.saturating_sub(1)], bends[index]];
            index == 0 || now - before > APART_RAD_S
        };
        let bends = || {
            let apart = (0..BENDS).filter(|index| is_apart(*index));
            apart
                .map(|index| bends[index])
                .take_while(|rate| rate.is_finite())
        };
        let last_rad_s = bends().last().unwrap_or(0.0);
        let beyond_rad_s = 2.0 * last_rad_s + 1.0;
        let mut before = None;
        for rate_rad_s in [0.0].into_iter().chain(bends()).chain([beyond_rad_s]) {
            let gained_rad_s = rate_rad_s - self.before_rad_s;
            let free_n_m = self.motor.at_gain(gained_rad_s);
            let limited_n_m = free_n_m.min(0.0);
            // At the rate limit the torque falls to one that does not drive.
            let torques = if rate_rad_s < limit_rad_s - APART_RAD_S {
                [Some(free_n_m), None]
            } else if rate_rad_s <= limit_rad_s + APART_RAD_S {
                [Some(free_n_m), Some(limited_n_m)]
            } else {
                [Some(limited_n_m), None]
            };
            for motor_n_m in torques.into_iter().flatten() {
                let geared_n_m = motor_n_m - self.rotor_n_m_s * gained_rad_s;
                let drives_n_m = motor_n_m.min(geared_n_m);
                if locks && drives_n_m <= 0.0 {
                    if let Some((from_rad_s, drove_n_m)) = before {
                        let share: f64 = drove_n_m / (drove_n_m - drives_n_m);
                        let locked_rad_s: f64 = from_rad_s + share * (rate_rad_s - from_rad_s);
                        let [_, last_n_m] = points[points.len() - 1];
                        let passed_n_m = self.passed_n_m(geared_n_m.max(0.0)) - self.friction_n_m;
                        points.push([locked_rad_s, passed_n_m.min(last_n_m)]);
                    }
                    return true;
                }
                points.push([rate_rad_s, self.passed_n_m(geared_n_m) - self.friction_n_m]);
                before = Some((rate_rad_s, drives_n_m));
            }
        }
        false
    }

    /// The torque that the gear passes to a wheel that turns forwards, in N m, for a given input.
    fn passed_n_m(&self, geared_n_m: f64) -> f64 {
        if geared_n_m >= 0.0 {
            self.efficiency * geared_n_m
        } else {
            geared_n_m / (2.0 - 1.0 / self.efficiency)
        }
    }

    /// The rates above 0 at which the drive may bend, in rad/s, in order; infinite ones fill the
    /// array.
    fn bends_rad_s(&self) -> [f64; BENDS] {
        let (torque_n_m, droop) = (self.motor.torque_n_m, self.motor.droop_n_m_s);
        let bounds = &self.motor.bounds;
        let (least_n_m, most_n_m) = (bounds.least_n_m, bounds.most_n_m);
        let (fall, limit_n_m, rotor) = (bounds.fall_n_m_s, bounds.limit_n_m, self.rotor_n_m_s);
        let gains = [
            // The torque reaches the lines, and the limits.
            (torque_n_m - most_n_m) / (droop - fall),
            (torque_n_m - least_n_m) / (droop - fall),
            (torque_n_m - limit_n_m) / droop,
            (torque_n_m + limit_n_m) / droop,
            // The lines reach the limits.
            (most_n_m - limit_n_m) / fall,
            (most_n_m + limit_n_m) / fall,
            (least_n_m - limit_n_m) / fall,
            (least_n_m + limit_n_m) / fall,
            // The motor's torque vanishes, and then the gear's input.
            torque_n_m / droop,
            most_n_m / fall,
            least_n_m / fall,
            torque_n_m / (droop + rotor),
            most_n_m / (fall + rotor),
            least_n_m / (fall + rotor),
            limit_n_m / rotor,
            -limit_n_m / rotor,
            0.0,
        ];
        let mut rates = [f64::INFINITY; BENDS];
        for (rate, gain) in rates.iter_mut().zip(gains) {
            let bend_rad_s = self.before_rad_s + gain;
            if bend_rad_s.is_finite() && bend_rad_s > 0.0 {
                *rate = bend_rad_s;
            }
        }
        rates[gains.len()] = self.motor.rate_limit_rad_s;
        rates.sort_by(f64::total_cmp);
        rates
    }
}

#[cfg(test)]
mod tests;
