//! What may be said of all from a sample.

use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, Binomial, ContinuousCDF, DiscreteCDF};

/// The confidence of all intervals.
pub const CONFIDENCE: f64 = 0.95;

/// A quantile of a quantity, with the interval in which it lies with [`CONFIDENCE`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quantile {
    /// Which, in (0, 1).
    pub share: f64,
    /// Its estimate: between the two values of the sample around it.
    pub value: f64,
    /// Where the interval begins; `None` where the sample is too small to say.
    pub low: Option<f64>,
    /// Where the interval ends; `None` where the sample is too small to say.
    pub high: Option<f64>,
}

/// A quantile of a sample in ascending order, which is not empty.
///
/// The interval is between two values of the sample, whichever the distribution: how many of `n` values lie below the
/// quantile is binomial.
pub fn quantile(sorted: &[f64], share: f64) -> Quantile {
    let last = sorted.len() - 1;
    let place = share * last as f64;
    let (at, part) = (place.floor() as usize, place.fract());
    let value = sorted[at] + part * (sorted[(at + 1).min(last)] - sorted[at]);
    let (mut low, mut high) = (None, None);
    if let Ok(below) = Binomial::new(share, sorted.len() as u64) {
        let tail = (1.0 - CONFIDENCE) / 2.0;
        let (lower, upper) = (below.inverse_cdf(tail), below.inverse_cdf(1.0 - tail) + 1);
        // The value of rank r, from 1, is not above the quantile with the probability that at least r lie below it.
        low = lower
            .checked_sub(1)
            .and_then(|at| sorted.get(at as usize))
            .copied();
        high = sorted.get(upper as usize - 1).copied();
    }
    Quantile {
        share,
        value,
        low,
        high,
    }
}

/// The interval in which a share lies with [`CONFIDENCE`], of which `kept` of `count` draws are: after Clopper and Pearson.
pub fn share_interval(kept: u64, count: u64) -> (f64, f64) {
    let tail = (1.0 - CONFIDENCE) / 2.0;
    let (k, n) = (kept as f64, count as f64);
    let quantile = |a: f64, b: f64, share: f64| Beta::new(a, b).map(|beta| beta.inverse_cdf(share));
    let low = if kept == 0 {
        0.0
    } else {
        quantile(k, n - k + 1.0, tail).unwrap_or(0.0)
    };
    let high = if kept == count {
        1.0
    } else {
        quantile(k + 1.0, n - k, 1.0 - tail).unwrap_or(1.0)
    };
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_median_is_between_the_ranks_of_tables() {
        // Of 100 values, ranks 40 and 61 hold the median with at least 95 %.
        let sorted: Vec<f64> = (1..=100).map(f64::from).collect();
        let median = quantile(&sorted, 0.5);
        assert_eq!((median.low, median.high), (Some(40.0), Some(61.0)));
        assert_eq!(median.value, 50.5);
    }

    #[test]
    fn a_sample_too_small_for_a_quantile_says_so() {
        let sorted: Vec<f64> = (0..100).map(f64::from).collect();
        // With 100 draws all lie below the quantile of 99 % with a probability of 0.99^100 = 37 %.
        assert_eq!(quantile(&sorted, 0.99).high, None);
        assert_eq!(quantile(&[7.0], 0.5).value, 7.0);
    }

    #[test]
    fn a_share_at_the_end_of_its_interval_has_the_draws_with_the_probability_of_the_tail() {
        for (kept, count) in [(495, 500), (3, 10), (999, 1000)] {
            let (low, high) = share_interval(kept, count);
            let at_least = 1.0 - Binomial::new(low, count).unwrap().cdf(kept - 1);
            let at_most = Binomial::new(high, count).unwrap().cdf(kept);
            assert!((at_least - 0.025).abs() < 1e-6, "{at_least}");
            assert!((at_most - 0.025).abs() < 1e-6, "{at_most}");
        }
        // Of n draws that are all kept, the share is above 0.025^(1/n).
        let (low, high) = share_interval(50, 50);
        assert!((low - 0.025_f64.powf(1.0 / 50.0)).abs() < 1e-6);
        assert_eq!((high, share_interval(0, 50).0), (1.0, 0.0));
    }
}
