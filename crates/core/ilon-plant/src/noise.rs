//! Noise of sensors.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A normally distributed number of mean zero; zero, and nothing drawn, for a deviation of zero.
pub(crate) fn noise(rng: &mut ChaCha8Rng, standard_deviation: f64) -> f64 {
    if standard_deviation == 0.0 {
        return 0.0;
    }
    let unit: f64 = StandardNormal.sample(rng);
    standard_deviation * unit
}
