//! Low-pass filtered derivative of a sampled signal.

use std::ops::{Add, Div, Mul, Sub};

/// The derivative of a sampled signal through a first-order low-pass, by implicit Euler: stable for
/// any time constant. The signal is a number or a vector.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FilteredDerivative<T> {
    /// The derivative, in the signal's unit per second.
    pub value: T,
    previous: Option<T>,
}

impl<T> FilteredDerivative<T>
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T> + Div<f64, Output = T>,
{
    /// Adds a sample taken `dt_s` after the last one. Returns the change of the signal since then;
    /// nothing for the first sample. `weight` weighs the newest change, see [`weight`].
    pub fn update(&mut self, sample: T, weight: f64, dt_s: f64) -> T {
        let change = sample - self.previous.replace(sample).unwrap_or(sample);
        self.value = self.value + (change / dt_s - self.value) * weight;
        change
    }
}

/// Returns the weight of the newest change, dt / (T + dt) in (0, 1], for a time constant and a
/// period in seconds.
pub(crate) fn weight(time_constant_s: f64, dt_s: f64) -> f64 {
    dt_s / (time_constant_s + dt_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp of slope a: y_k = y_(k-1) + w (a - y_(k-1)) from y_1 = 0, hence a (1 - (1 -
    /// w)^(k-1)).
    #[test]
    fn the_derivative_of_a_ramp_is_neared_as_by_a_first_order_lag() {
        let (slope, dt_s) = (3.0, 0.01);
        let weight = weight(0.03, dt_s);
        assert!((weight - 0.25).abs() < 1e-15);
        let mut derivative = FilteredDerivative::default();
        for k in 0..20 {
            derivative.update(1.0 + slope * dt_s * f64::from(k), weight, dt_s);
            let expected = slope * (1.0 - 0.75_f64.powi(k));
            // Samples of about 1 are rounded at 1e-16, and divided by 0.01 s.
            assert!((derivative.value - expected).abs() < 1e-13, "sample {k}");
        }
    }

    #[test]
    fn without_a_time_constant_it_is_the_difference_quotient() {
        let mut derivative = FilteredDerivative::default();
        derivative.update(1.0, weight(0.0, 0.5), 0.5);
        assert_eq!(derivative.value, 0.0);
        assert_eq!(derivative.update(3.0, weight(0.0, 0.5), 0.5), 2.0);
        assert_eq!(derivative.value, 4.0);
    }
}
