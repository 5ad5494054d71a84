//! The rate gain of a wheel under a torque that falls as the rate grows: a loop that is faster than
//! the step, or a motor with back-EMF.

/// Returns theta: the mean over a time of a wheel's rate gain, as a part of the whole gain, if the
/// wheel approaches its rate as exp(-z t / dt), with z = D dt / J, the droop D, the time dt and the
/// wheel's inertia J. One half for a short time, 1 for an endless one.
///
/// From the integral of 1 - exp(-z s) over s from 0 to 1, over its end 1 - exp(-z): theta = 1 /
/// (1 - exp(-z)) - 1 / z.
pub fn mean_of_gain(z: f64) -> f64 {
    // Below this value the difference cancels; the series is 1/2 + z/12 - z^3/720.
    const SMALL: f64 = 0.05;
    if !z.is_finite() {
        1.0
    } else if z < SMALL {
        0.5 + z / 12.0
    } else {
        1.0 / (1.0 - libm::exp(-z)) - 1.0 / z
    }
}
