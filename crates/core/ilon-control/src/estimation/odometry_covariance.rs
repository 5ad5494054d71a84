//! The covariance of dead reckoning, from rollers, slip and encoders.
//!
//! The rolled distance of a wheel has two kinds of error. A systematic share is always the same:
//! radii, the mean of the rollers' geometry, creep; it grows with the distance. The random rest is
//! new at every roller: ripple, and slip that comes and goes; it grows with the root of the
//! distance. With R the heading's rotation, t_h the body's displacement per distance of wheel h
//! (column h of M^+), s_h its distance and F the derivative of a later pose by an earlier one,
//!
//!   a_h <- F a_h + R t_h ds_h,       Q <- F Q F^T + sum over h of sigma^2 |ds_h| R t_h t_h^T R^T,
//!   P = Q + scale^2 sum of a_h a_h^T + (the encoders' resolution).
//!
//! **Covariance of a twist.** A filter that takes a twist once a period T and assumes independent
//! errors needs a covariance that makes P grow as above. For the random errors it is walk^2 |v_h| /
//! T. Systematic errors persist as long as the robot keeps its direction; independent errors of
//! scale^2 (|v_h| / T) l lead to the same P after a metre if l = 1 m, to more before and less after
//! it on a straight line. On winding paths the errors turn with the robot: over 24 random paths of
//! mecanum4 the heading's error grows with the root of the distance from half a metre on, and
//! across the robot it is 1.5 % of a distance of 0.2 m and 1.1 % of one of 2 m. The rates' noise is
//! added.

use ilon_robot::{Pose, Robot, Twist};
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::error::not_negative;
use crate::{ContactKinematics, ControlError, Kinematics};

/// Errors of the wheels' rolled distances, as standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WayErrors {
    /// Systematic share of a wheel's distance.
    pub scale: f64,
    /// Random error after a metre, in metres; it grows with the root of the distance.
    pub walk_m: f64,
    /// The step of the encoders, in rad; 0 for none.
    pub resolution_rad: f64,
    /// Noise of the encoders' rates, in rad/s; their counted angles are without it.
    pub rate_noise_rad_s: f64,
}

impl WayErrors {
    /// Returns the errors of eq. (7), which assumes that every roller points straight down: the
    /// deviation of the touching rollers' kinematics over a pitch, along x, along y and about z,
    /// plus a share of slip, which counts both as systematic error and as random error over a
    /// pitch.
    ///
    /// # Errors
    /// Those of [`Kinematics::new`] and [`ContactKinematics::new`]; [`ControlError::Negative`] for
    /// a share.
    pub fn of_rollers(robot: &Robot, slip_share: f64) -> Result<Self, ControlError> {
        not_negative("the share of the way that slips", slip_share)?;
        let ideal = Kinematics::new(robot)?;
        let mut contact = ContactKinematics::new(robot)?;
        let n = robot.wheels.len();
        let (mut asked, mut needed) = (vec![0.0; n], vec![0.0; n]);
        let (mut scale, mut ripple) = (0.0_f64, 0.0_f64);
        let mut pitch_m = 0.0_f64;
        for wheel in &robot.wheels {
            let pitch_rad = std::f64::consts::TAU / wheel.rollers.len().max(1) as f64;
            pitch_m = pitch_m.max(pitch_rad * wheel.radius_m);
        }
        for twist in [
            Twist::new(1.0, 0.0, 0.0),
            Twist::new(0.0, 1.0, 0.0),
            Twist::new(0.0, 0.0, 1.0),
        ] {
            ideal.wheel_rates(twist, &mut asked);
            for h in 0..n {
                let pitch_rad = std::f64::consts::TAU / robot.wheels[h].rollers.len().max(1) as f64;
                let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
                for k in 0..LOOKS {
                    let angles_rad = vec![pitch_rad * f64::from(k) / f64::from(LOOKS); n];
                    contact.wheel_rates(&angles_rad, twist, &mut needed);
                    if asked[h].abs() > 1e-9 {
                        let off = needed[h] / asked[h] - 1.0;
                        (sum, squares, count) = (sum + off, squares + off * off, count + 1.0);
                    }
                }
                if count > 0.0 {
                    let mean: f64 = sum / count;
                    scale = scale.max(mean.abs());
                    ripple = ripple.max(f64::sqrt((squares / count - mean * mean).max(0.0)));
                }
            }
        }
        Ok(Self {
            scale: scale.hypot(slip_share),
            walk_m: ripple.hypot(slip_share) * pitch_m.sqrt(),
            resolution_rad: 0.0,
            rate_noise_rad_s: 0.0,
        })
    }
}

/// The distance at which independent errors of twists and systematic errors give the same
/// covariance, in metres.
const SAME_WAY_M: f64 = 1.0;
/// Number of wheel angles sampled over a roller pitch.
const LOOKS: u32 = 90;

/// The covariance of dead reckoning by eq. (7), which grows with the distance. After construction
/// nothing is allocated.
#[derive(Clone, Debug)]
pub struct OdometryCovariance {
    kinematics: Kinematics,
    errors: WayErrors,
    /// a_h.
    always: Vec<Vector3<f64>>,
    /// Q.
    anew: Matrix3<f64>,
}

impl OdometryCovariance {
    /// Starts from an exactly known pose.
    ///
    /// # Errors
    /// [`ControlError::Negative`] for errors.
    pub fn new(kinematics: Kinematics, errors: WayErrors) -> Result<Self, ControlError> {
        not_negative("the scale error of a way", errors.scale)?;
        not_negative("the walk of a way in m", errors.walk_m)?;
        not_negative("the encoders' step in rad", errors.resolution_rad)?;
        not_negative(
            "the noise of wheels' rates in rad/s",
            errors.rate_noise_rad_s,
        )?;
        Ok(Self {
            always: vec![Vector3::zeros(); kinematics.wheel_count()],
            anew: Matrix3::zeros(),
            kinematics,
            errors,
        })
    }

    /// Updates the wheels' places for a robot whose joints move them. The number of wheels stays.
    pub fn stand(&mut self, kinematics: &Kinematics) {
        self.kinematics.clone_from(kinematics);
    }

    /// Adds the angles in rad by which the wheels rolled since the last call; `before` is the
    /// estimated pose at the start of this interval.
    pub fn count(&mut self, before: &Pose, turned_rad: &[f64]) {
        let displacement = self.kinematics.twist(turned_rad);
        let moved = before.moved(displacement).position_m() - before.position_m();
        #[rustfmt::skip]
        let f = Matrix3::new(
            1.0, 0.0, -moved.y,
            0.0, 1.0, moved.x,
            0.0, 0.0, 1.0,
        );
        let middle_rad = before.heading_rad + 0.5 * displacement.omega_rad_s;
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), middle_rad);
        self.anew = f * self.anew * f.transpose();
        let per_rad = self.kinematics.twist_matrix();
        for (h, turned_rad) in turned_rad.iter().enumerate().take(self.always.len()) {
            let column = turn * per_rad.column(h);
            self.always[h] = f * self.always[h] + column * *turned_rad;
            let lever_m = self.kinematics.lever_m()[h];
            let along = column / lever_m;
            let way_m = (lever_m * turned_rad).abs();
            let variance = self.errors.walk_m * self.errors.walk_m * way_m;
            self.anew += along * along.transpose() * variance;
        }
    }

    /// Returns the covariance of the twist computed from rates in rad/s, in the body frame:
    /// m^2/s^2, m rad/s^2, rad^2/s^2. It suits a filter that takes a twist every `period_s` seconds
    /// and assumes independent errors, and is never less than that of a single twist.
    pub fn twist_covariance(&self, rates_rad_s: &[f64], period_s: f64) -> Matrix3<f64> {
        let errors = &self.errors;
        let scale = errors.scale * errors.scale;
        let levers = self.kinematics.lever_m().iter();
        let columns = self.kinematics.twist_matrix().column_iter().zip(levers);
        let of_wheels = columns.zip(rates_rad_s);
        let of_wheels = of_wheels.map(|((column, lever_m), rate_rad_s)| {
            let speed_m_s = (lever_m * rate_rad_s).abs();
            let way_m = speed_m_s * period_s;
            let always = scale * way_m * way_m.max(SAME_WAY_M);
            let anew = errors.walk_m * errors.walk_m * way_m;
            let variance = (always + anew) / (lever_m * period_s).powi(2)
                + errors.rate_noise_rad_s * errors.rate_noise_rad_s;
            column * column.transpose() * variance
        });
        of_wheels.sum()
    }

    /// Returns the covariance of x and y in the world frame and of the heading: m^2, m rad, rad^2.
    pub fn covariance(&self, heading_rad: f64) -> Matrix3<f64> {
        let scale = self.errors.scale * self.errors.scale;
        // Uniform within an encoder step, at the start and now.
        let step = self.errors.resolution_rad * self.errors.resolution_rad / 6.0;
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), heading_rad);
        let of_wheels = self.always.iter().map(|a| a * a.transpose() * scale);
        let columns = self.kinematics.twist_matrix().column_iter();
        let of_steps = columns.map(|column| {
            let column = turn * column;
            column * column.transpose() * step
        });
        self.anew + of_wheels.sum::<Matrix3<f64>>() + of_steps.sum::<Matrix3<f64>>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::robots::{mecanum4, six_wheels, volksbot};
    use ilon_robot::wrap_angle;

    /// Pseudo-random numbers of a normal distribution, always the same: the sum of twelve uniform
    /// ones.
    fn normal(seed: &mut u64) -> f64 {
        let mut even = || {
            *seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (*seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| even()).sum::<f64>() - 6.0
    }

    /// Robots whose wheels have the stated errors drive a curve: the squared error over the
    /// covariance has the mean 3, one per degree of freedom.
    #[test]
    fn errors_are_as_large_as_the_covariance_says() {
        let errors = WayErrors {
            scale: 0.004,
            walk_m: 0.003,
            resolution_rad: 0.0,
            rate_noise_rad_s: 0.0,
        };
        for robot in [mecanum4(), volksbot(), six_wheels()] {
            let kinematics = Kinematics::new(&robot).unwrap();
            let n = robot.wheels.len();
            let (mut seed, mut sum, runs) = (7, 0.0, 2000);
            for _ in 0..runs {
                let mut account = OdometryCovariance::new(kinematics.clone(), errors).unwrap();
                let scales: Vec<f64> = (0..n).map(|_| errors.scale * normal(&mut seed)).collect();
                let (mut truth, mut reckoned) = (Pose::default(), Pose::default());
                let mut rates = vec![0.0; n];
                for k in 0..150 {
                    let t = 0.02 * f64::from(k);
                    let step = Twist::new(0.02, 0.01 * t.sin(), 0.015 * t.cos());
                    kinematics.wheel_rates(step, &mut rates);
                    account.count(&reckoned, &rates);
                    reckoned = reckoned.moved(kinematics.twist(&rates));
                    for h in 0..n {
                        let lever_m = kinematics.lever_m()[h];
                        let way_m = lever_m * rates[h];
                        let off_m = scales[h] * way_m
                            + errors.walk_m * way_m.abs().sqrt() * normal(&mut seed);
                        rates[h] += off_m / lever_m;
                    }
                    truth = truth.moved(kinematics.twist(&rates));
                }
                let e = Vector3::new(
                    truth.x_m - reckoned.x_m,
                    truth.y_m - reckoned.y_m,
                    wrap_angle(truth.heading_rad - reckoned.heading_rad),
                );
                let p = account.covariance(reckoned.heading_rad);
                sum += e.dot(&(p.try_inverse().unwrap() * e));
            }
            let mean = sum / f64::from(runs);
            println!("mean squared error over covariance: {mean:.3}");
            // 2000 runs of variance 6: three deviations are 0.16.
            assert!((mean - 3.0).abs() < 0.17, "{mean}");
        }
    }

    /// A filter that adds up twists with independent errors reaches the covariance of the distance
    /// after a metre straight ahead, whatever its period; the rates' noise adds its own.
    #[test]
    fn independent_errors_of_twists_add_up_to_the_error_of_a_metre() {
        let robot = mecanum4();
        let kinematics = Kinematics::new(&robot).unwrap();
        let mut rates = vec![0.0; 4];
        // Every wheel rolls 0.4 m along its roller's axis in a second.
        let twist = Twist::new(0.4 / robot.wheels[0].gamma_rad.cos(), 0.0, 0.0);
        kinematics.wheel_rates(twist, &mut rates);
        for (lever_m, rate_rad_s) in kinematics.lever_m().iter().zip(&rates) {
            assert!((lever_m * rate_rad_s.abs() - 0.4).abs() < 1e-12);
        }
        for (period_s, noise) in [(0.01, 0.0), (0.05, 0.0), (0.01, 0.2)] {
            let errors = WayErrors {
                scale: 0.004,
                walk_m: 0.003,
                resolution_rad: 0.0,
                rate_noise_rad_s: noise,
            };
            let mut account = OdometryCovariance::new(kinematics.clone(), errors).unwrap();
            let (mut pose, mut sum) = (Pose::default(), Matrix3::zeros());
            let turned: Vec<f64> = rates.iter().map(|rate| rate * period_s).collect();
            for _ in 0..(2.5 / period_s).round() as u32 {
                account.count(&pose, &turned);
                pose = pose.moved(twist.scaled(period_s));
                // As a filter does: with the lever of the remaining heading error.
                let moved_m = twist.vx_m_s * period_s;
                #[rustfmt::skip]
                let f = Matrix3::new(1.0, 0.0, 0.0,  0.0, 1.0, moved_m,  0.0, 0.0, 1.0);
                let of_twist = account.twist_covariance(&rates, period_s);
                sum = f * sum * f.transpose() + of_twist * (period_s * period_s);
            }
            // White noise of the rates per step, in x and in the heading.
            let columns = kinematics.twist_matrix();
            let squared = |axis: usize| columns.row(axis).norm_squared();
            let of_noise = |axis: usize| noise * noise * squared(axis) * period_s * 2.5;
            let known = account.covariance(0.0);
            for axis in [0, 2] {
                let expected = known[(axis, axis)] + of_noise(axis);
                assert!((sum[(axis, axis)] / expected - 1.0).abs() < 1e-9, "{axis}");
            }
        }
    }

    /// Half of a turn with the original wheel places, half with levers twice as long. The heading
    /// error per metre of wheel distance then halves, and a turn takes twice the distance. Random
    /// errors contribute w^2 |s| (dphi/ds)^2, so half the variance of the first half is added;
    /// systematic errors contribute scale s dphi/ds, as much as before: in sum twice the deviation.
    #[test]
    fn errors_of_a_turn_follow_wheels_that_move_outward() {
        let near = mecanum4();
        let mut far = near.clone();
        for wheel in &mut far.wheels {
            wheel.body_from_hub.translation.vector *= 2.0;
        }
        let [near, far] = [near, far].map(|robot| Kinematics::new(&robot).unwrap());
        for (scale, walk_m, grows) in [(0.0, 0.003, 1.5), (0.004, 0.0, 4.0)] {
            let errors = WayErrors {
                scale,
                walk_m,
                resolution_rad: 0.0,
                rate_noise_rad_s: 0.0,
            };
            let mut account = OdometryCovariance::new(near.clone(), errors).unwrap();
            let mut turned = [&near, &far].into_iter().map(|kinematics| {
                let mut rates = vec![0.0; 4];
                kinematics.wheel_rates(Twist::new(0.0, 0.0, 0.5), &mut rates);
                account.stand(kinematics);
                account.count(&Pose::default(), &rates);
                account.covariance(0.0)[(2, 2)]
            });
            let (half, whole) = (turned.next().unwrap(), turned.next().unwrap());
            assert!((whole / half - grows).abs() < 1e-9, "{}", whole / half);
        }
    }

    /// With nine rollers per wheel, eq. (7) is off by 2 % for a mecanum robot that drives sideways;
    /// the covariance includes this.
    #[test]
    fn the_rollers_geometry_is_in_it() {
        let errors = WayErrors::of_rollers(&mecanum4(), 0.0).unwrap();
        assert!((0.015..0.05).contains(&errors.scale), "{errors:?}");
        assert!(errors.walk_m > 1e-4 && errors.walk_m < 0.02, "{errors:?}");
    }
}
