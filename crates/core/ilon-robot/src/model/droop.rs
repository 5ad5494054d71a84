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
        let at = share - 0.5 * z * share * (1.0 - share);
        let gain = 0.5 - z * (0.25 - share / 3.0);
        return [at, share * share * gain];
    }
    if !z.is_finite() {
        return [share.floor(), share.floor()];
    }
    let all = 1.0 - libm::exp(-z);
    let at = (-libm::log1p(-share * all) / z).min(1.0);
    [at, at / all - share / z]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both are smooth over z, and at the end they are the whole time and theta. The series has an
    /// error of z^3 / 720 there, and of z^2 / 12 at most before: 2e-4 at z = 0.05.
    #[test]
    fn a_share_of_the_gain_has_its_time_at_any_z() {
        for z in [0.0, 1e-6, 0.04999, 0.05, 1.0, 50.0, 1e4, f64::INFINITY] {
            let [at, gain] = time_and_gain_until(z, 1.0);
            assert!((at - 1.0).abs() < 1e-12, "{z}: {at}");
            assert!((gain - mean_of_gain(z)).abs() < 1e-6, "{z}: {gain}");
            assert_eq!(time_and_gain_until(z, 0.0), [0.0, 0.0]);
        }
        for share in [0.1, 0.5, 0.9] {
            let [below, above] = [0.05 - 1e-9, 0.05].map(|z| time_and_gain_until(z, share));
            assert!((below[0] - above[0]).abs() < 2e-4, "{below:?} {above:?}");
            assert!((below[1] - above[1]).abs() < 2e-4, "{below:?} {above:?}");
        }
        assert!(!time_and_gain_until(f64::NAN, 0.5)[1].is_nan());
    }
}
