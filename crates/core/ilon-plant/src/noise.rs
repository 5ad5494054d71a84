//! Sensor noise.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A normally distributed number with mean zero; zero without drawing if the deviation is zero.
pub(crate) fn noise(rng: &mut ChaCha8Rng, standard_deviation: f64) -> f64 {
    if standard_deviation == 0.0 {
        return 0.0;
    }
    let unit: f64 = StandardNormal.sample(rng);
    standard_deviation * unit
}
