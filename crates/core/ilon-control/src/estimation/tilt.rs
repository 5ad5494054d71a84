//! Tilt from an IMU by a complementary filter for the vertical.
//!
//! The gyroscope rotates the estimate, the accelerometer pulls it slowly towards the measured
//! vertical, and a persistent pull is attributed to the gyroscope's bias: R. Mahony, T. Hamel,
//! J.-M. Pflimlin, "Nonlinear Complementary Filters on the Special Orthogonal Group", IEEE
//! Transactions on Automatic Control 53(5), 2008, on the direction of gravity alone. With the
//! measured direction m, the estimate u and the error e = m x u,
//!
//!   u' = -(omega - b + k_p e) x u,   b' = -k_i e,   k_p = 2 / T, k_i = 1 / T^2,
//!
//! which puts both poles at -1 / T: an acceleration passes as tilt through (k_p s + k_i) / (s^2 +
//! k_p s + k_i), and a constant bias leaves no error.

use nalgebra::{UnitQuaternion, Vector3};

use crate::ControlError;
use crate::error::positive;

/// Errors of an inertial sensor on each of its axes: standard deviations in the sensor's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InertialErrors {
    /// Noise of a sample.
    pub noise: f64,
    /// Bias at the start.
    pub bias: f64,
    /// Random walk of the bias after a second; it grows with the root of the time.
    pub bias_walk: f64,
}

impl InertialErrors {
    /// Returns the variance of a sample taken `since_s` seconds after the start.
    pub fn variance(&self, since_s: f64) -> f64 {
        self.noise * self.noise + self.bias_variance(since_s)
    }

    fn bias_variance(&self, since_s: f64) -> f64 {
        self.bias * self.bias + self.bias_walk * self.bias_walk * since_s
    }
}

/// Estimates the downward direction from an IMU's gyroscope and accelerometer.
///
/// The first sample's specific force is the initial upward direction. Samples that are not finite
/// are ignored. Nothing is allocated.
///
/// ```
/// use ilon_control::TiltFilter;
/// use nalgebra::Vector3;
///
/// let mut tilt = TiltFilter::new(1.0)?;
/// // At rest on a slope that falls ahead by 5 deg: the accelerometer sees what holds the robot.
/// let slope = 5_f64.to_radians();
/// let force = 9.81 * Vector3::new(-slope.sin(), 0.0, slope.cos());
/// tilt.update(&Vector3::zeros(), &force, 0.01);
/// let gravity = 9.81 * tilt.down_in_body();
/// assert!((gravity.x - 9.81 * slope.sin()).abs() < 1e-12);
/// # Ok::<(), ilon_control::ControlError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TiltFilter {
    time_constant_s: f64,
    /// `None` before the first sample.
    up: Option<Vector3<f64>>,
    bias_rad_s: Vector3<f64>,
}

impl TiltFilter {
    /// A filter with the time constant T in seconds: a shorter one follows the accelerometer,
    /// including the robot's own accelerations, a longer one the gyroscope.
    ///
    /// # Errors
    /// [`ControlError::NotPositive`].
    pub fn new(time_constant_s: f64) -> Result<Self, ControlError> {
        Ok(Self {
            time_constant_s: positive("the tilt filter's time constant in s", time_constant_s)?,
            up: None,
            bias_rad_s: Vector3::zeros(),
        })
    }

    /// Takes a sample: the angular velocity in rad/s and the specific force in m/s^2, both in the
    /// body frame, over the last `dt_s` seconds. A robot at rest on level ground measures a
    /// specific force of (0, 0, 9.81).
    pub fn update(
        &mut self,
        turn_rad_s: &Vector3<f64>,
        specific_force_m_s2: &Vector3<f64>,
        dt_s: f64,
    ) {
        let finite = |v: &Vector3<f64>| v.iter().all(|x| x.is_finite());
        if !(finite(turn_rad_s) && finite(specific_force_m_s2) && dt_s > 0.0) {
            return;
        }
        let measured = specific_force_m_s2.try_normalize(1e-6);
        let Some(up) = self.up else {
            self.up = measured;
            return;
        };
        let (k_p, k_i) = (
            2.0 / self.time_constant_s,
            1.0 / (self.time_constant_s * self.time_constant_s),
        );
        // Free fall gives no direction.
        let e = measured.map_or(Vector3::zeros(), |m| m.cross(&up));
        // A step longer than the time constant moves to the measured direction, not beyond.
        let pull = k_p.min(1.0 / dt_s);
        let turn = turn_rad_s - self.bias_rad_s + pull * e;
        let turned = UnitQuaternion::from_scaled_axis(-dt_s * turn) * up;
        self.up = Some(turned.normalize());
        self.bias_rad_s -= k_i.min(0.25 * pull * pull) * dt_s * e;
    }

    /// Returns the variance of roll, and of pitch, in rad^2, for a robot that does not accelerate:
    /// with gyroscope errors in rad/s, accelerometer errors in m/s^2, a sample every `period_s`
    /// seconds, `since_s` seconds after the first.
    ///
    /// White noise of a sample's variance n^2 passes a filter G as n^2 dt times the integral of
    /// |G|^2 over frequency: with both poles at -1/T that is 5 / (4 T) for the accelerometer, whose
    /// noise passes as tilt, T / 4 for the gyroscope, and T^3 / 4 for the walk of the gyroscope's
    /// bias. The gyroscope's initial bias is learned, b t exp(-t / T); the first sample's noise is
    /// forgotten, (1 - t / T) exp(-t / T); the accelerometer's bias stays.
    pub fn variance_rad2(
        &self,
        gyroscope: &InertialErrors,
        accelerometer: &InertialErrors,
        gravity_m_s2: f64,
        (period_s, since_s): (f64, f64),
    ) -> f64 {
        let t = self.time_constant_s;
        let square = |x: f64| x * x;
        let forgets = libm::exp(-since_s / t);
        let first = square((1.0 - since_s / t) * forgets);
        let of_accelerometer = square(accelerometer.noise) * (first + 1.25 * period_s / t)
            + accelerometer.bias_variance(since_s);
        let of_gyroscope = square(gyroscope.noise) * period_s * 0.25 * t
            + square(gyroscope.bias_walk) * 0.25 * t * t * t
            + square(gyroscope.bias * since_s * forgets);
        of_accelerometer / square(gravity_m_s2) + of_gyroscope
    }

    /// The downward unit vector in the body frame; -z before the first sample.
    pub fn down_in_body(&self) -> Vector3<f64> {
        self.up.map_or(-Vector3::z(), |up| -up)
    }

    /// The estimated gyroscope bias across the vertical, in rad/s in the body frame.
    pub fn bias_rad_s(&self) -> Vector3<f64> {
        self.bias_rad_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ground rolls about x by 0.1 sin(3 t) rad.
    fn rolling(t_s: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (angle, rate) = (0.1 * (3.0 * t_s).sin(), 0.3 * (3.0 * t_s).cos());
        let force = 9.81 * Vector3::new(0.0, angle.sin(), angle.cos());
        (Vector3::new(rate, 0.0, 0.0), force)
    }

    #[test]
    fn a_turning_body_is_followed_and_a_constant_bias_leaves_no_error() {
        let bias = Vector3::new(0.03, -0.02, 0.0);
        let mut tilt = TiltFilter::new(0.5).unwrap();
        let dt_s = 1e-3;
        let mut worst = 0.0_f64;
        for k in 0..20_000 {
            // Samples from the middle of each step: the remaining error is of second order.
            let t_s = dt_s * f64::from(k);
            let (turn, _) = rolling(t_s + 0.5 * dt_s);
            let (_, force) = rolling(t_s + dt_s);
            tilt.update(&(turn + bias), &force, dt_s);
            if t_s > 15.0 {
                worst = worst.max((tilt.down_in_body() + force / 9.81).norm());
            }
        }
        // exp(-15 / 0.5) of 0.03 rad/s is negligible. A bias along the vertical is observed only as
        // far as the body leans: 0.02 rad/s * 0.1 stays in the estimate, and a tenth of that turns
        // the vertical by 2e-4 / k_p and some more as it rocks. Without the estimate it is 0.036 /
        // k_p = 9e-3.
        assert!(worst < 1e-3, "{worst}");
        assert!((tilt.bias_rad_s() - bias).norm() < 5e-3);
    }

    /// A sideways acceleration a for a short time t looks like a tilt of a / g, of which k_p t
    /// passes.
    #[test]
    fn a_short_acceleration_passes_as_tilt_by_the_filters_share() {
        let mut tilt = TiltFilter::new(2.0).unwrap();
        let still = Vector3::new(0.0, 0.0, 9.81);
        tilt.update(&Vector3::zeros(), &still, 1e-3);
        for _ in 0..20 {
            tilt.update(&Vector3::zeros(), &(still + 0.5 * Vector3::x()), 1e-3);
        }
        let share = 0.5 / 9.81 * (2.0 / 2.0) * 0.02;
        // Second order in t / T, plus the angle's own curvature: a hundredth.
        assert!((-tilt.down_in_body().x / share - 1.0).abs() < 0.02);
    }

    /// Robots at rest whose IMUs have the stated errors: pitch has the computed variance at the
    /// start, while a bias is learned, and in the long run.
    #[test]
    fn tilt_errs_as_its_variance_says() {
        let mut seed = 11_u64;
        let mut normal = move || {
            let mut even = || {
                seed = seed
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (seed >> 11) as f64 / (1_u64 << 53) as f64
            };
            (0..12).map(|_| even()).sum::<f64>() - 6.0
        };
        let none = InertialErrors::default();
        let of = |noise, bias, bias_walk| InertialErrors {
            noise,
            bias,
            bias_walk,
        };
        let dt_s = 0.01;
        for (gyroscope, accelerometer) in [
            (none, of(0.2, 0.0, 0.0)),
            (none, of(0.0, 0.1, 0.02)),
            (of(0.02, 0.0, 0.0), none),
            (of(0.0, 0.02, 0.0), none),
            (of(0.0, 0.0, 0.01), none),
            (of(0.01, 0.01, 0.003), of(0.1, 0.05, 0.01)),
        ] {
            let filter = TiltFilter::new(0.5).unwrap();
            let (runs, looks) = (1200, [0_usize, 30, 60, 400]);
            let mut squares = [0.0; 4];
            for _ in 0..runs {
                let mut filter = filter.clone();
                let mut b_g = gyroscope.bias * normal();
                let mut b_a = accelerometer.bias * normal();
                for k in 0..=400 {
                    let turn = b_g + gyroscope.noise * normal();
                    let ahead = b_a + accelerometer.noise * normal();
                    let force = Vector3::new(ahead, 0.0, 9.81);
                    filter.update(&Vector3::new(0.0, turn, 0.0), &force, dt_s);
                    b_g += gyroscope.bias_walk * dt_s.sqrt() * normal();
                    b_a += accelerometer.bias_walk * dt_s.sqrt() * normal();
                    if let Some(look) = looks.iter().position(|look| *look == k) {
                        squares[look] += filter.down_in_body().x.asin().powi(2);
                    }
                }
            }
            for (look, square) in looks.iter().zip(squares) {
                let since_s = dt_s * *look as f64;
                let said = filter.variance_rad2(&gyroscope, &accelerometer, 9.81, (dt_s, since_s));
                let ratio = (square / f64::from(runs)) / said;
                println!("{gyroscope:?} {accelerometer:?} {since_s}: {ratio:.3} of {said:.2e}");
                // The filter passes the accelerometer's walk with a lag of half its memory; it
                // follows the gyroscope's only after some time constants.
                let walked = match since_s < 4.0 {
                    true => {
                        accelerometer.bias_walk.powi(2) / 9.81_f64.powi(2)
                            + 0.25 * gyroscope.bias_walk.powi(2) * 0.25
                    }
                    false => 0.25 * accelerometer.bias_walk.powi(2) / 9.81_f64.powi(2),
                };
                // 1200 runs: a variance to 4 % in one deviation. The filter in steps of 0.02 T is 2
                // % off the continuous one. The first sample has no gyroscope error.
                let least = 0.85 - if look > &0 { walked / said } else { 0.0 };
                let is_held = (least..1.15).contains(&ratio) || look == &0 && square == 0.0;
                assert!(said < 1e-18 || is_held, "{ratio}");
            }
        }
    }

    #[test]
    fn what_is_no_sample_changes_nothing() {
        let mut tilt = TiltFilter::new(1.0).unwrap();
        let up = Vector3::new(0.0, 0.0, 9.81);
        tilt.update(&Vector3::zeros(), &up, 0.01);
        let before = tilt.clone();
        tilt.update(&Vector3::new(f64::NAN, 0.0, 0.0), &up, 0.01);
        tilt.update(
            &Vector3::zeros(),
            &Vector3::new(0.0, f64::INFINITY, 0.0),
            0.01,
        );
        tilt.update(&Vector3::zeros(), &up, -1.0);
        assert_eq!(tilt, before);
        assert!(TiltFilter::new(0.0).is_err());
    }
}
