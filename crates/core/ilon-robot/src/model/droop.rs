//! The rate gain of a wheel under a torque that falls as the rate grows: a loop that is faster than
//! the step, or a motor with back-EMF.

/// Below this z differences cancel; the series of theta is 1/2 + z/12 - z^3/720.
const SMALL: f64 = 0.05;

/// Returns theta: the mean over a time of a wheel's rate gain, as a part of the whole gain, if the
/// wheel approaches its rate as exp(-z t / dt), with z = D dt / J, the droop D, the time dt and the
/// wheel's inertia J. One half for a short time, 1 for an endless one.
///
/// From the integral of 1 - exp(-z s) over s from 0 to 1, over its end 1 - exp(-z): theta = 1 /
/// (1 - exp(-z)) - 1 / z.
pub fn mean_of_gain(z: f64) -> f64 {
    if !z.is_finite() {
        1.0
    } else if z < SMALL {
        0.5 + z / 12.0
    } else {
        1.0 / (1.0 - libm::exp(-z)) - 1.0 / z
    }
}

/// Returns when such a wheel has a share of its gain, as a share of the time, and the integral of
/// the gain until then, as a share of the whole gain and time: `mean_of_gain` at the end.
///
/// With E = 1 - exp(-z) the share g is reached at s = -ln(1 - g E) / z, and the integral is s / E -
/// g / z.
pub fn time_and_gain_until(z: f64, share: f64) -> [f64; 2] {
    if z < SMALL {
        return [share, 0.5 * share * share];
    }
    let all = 1.0 - libm::exp(-z);
    let at = (-libm::log1p(-share * all) / z).min(1.0);
    [at, at / all - share / z]
}
