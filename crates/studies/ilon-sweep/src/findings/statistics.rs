//! Inference from a sample to the population.

use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, Binomial, ContinuousCDF, DiscreteCDF};

/// The confidence of all intervals.
pub const CONFIDENCE: f64 = 0.95;

/// A quantile of a quantity with its interval of confidence [`CONFIDENCE`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quantile {
    /// Its probability, in (0, 1).
    pub share: f64,
    /// Its estimate, interpolated between two values of the sample.
    pub value: f64,
    /// Lower end of the interval; `None` if the sample is too small.
    pub low: Option<f64>,
    /// Upper end of the interval; `None` if the sample is too small.
    pub high: Option<f64>,
}

/// Returns a quantile of a non-empty sample in ascending order, from `draws` independent draws;
/// each of them has equally many values, which may all be equal.
///
/// The interval is between two values of the sample, for any distribution: the number of `n` draws
/// below the quantile is binomial. It holds for any correlation of the values in one draw, and is
/// wider the lower the correlation.
pub fn quantile(sorted: &[f64], share: f64, draws: u64) -> Quantile {
    let last = sorted.len() - 1;
    let place = share * last as f64;
    let (at, part) = (place.floor() as usize, place.fract());
    let value = sorted[at] + part * (sorted[(at + 1).min(last)] - sorted[at]);
    let (mut low, mut high) = (None, None);
    if let Ok(below) = Binomial::new(share, draws) {
        let tail = (1.0 - CONFIDENCE) / 2.0;
        let (lower, upper) = (below.inverse_cdf(tail), below.inverse_cdf(1.0 - tail) + 1);
        let values_a_draw = sorted.len() as f64 / draws as f64;
        let values = |draws: u64| draws as f64 * values_a_draw;
        // The value of rank r, from 1, is at most the quantile with the probability that at least r
        // lie below it.
        low = lower
            .checked_sub(1)
            .and_then(|before| sorted.get(values(before).floor() as usize))
            .copied();
        high = sorted.get(values(upper).ceil() as usize - 1).copied();
    }
    Quantile {
        share,
        value,
        low,
        high,
    }
}

/// Returns the interval of confidence [`CONFIDENCE`] of a share from `draws` independent draws,
/// after Clopper and Pearson. A share between two counts of draws, from draws with several values
/// each, has the interval around both.
pub fn share_interval(share: f64, draws: u64) -> (f64, f64) {
    let tail = (1.0 - CONFIDENCE) / 2.0;
    let n = draws as f64;
    // Draws are counted, whatever the rounding of their share.
    let (fewest, most) = ((share * n + 1e-9).floor(), (share * n - 1e-9).ceil());
    let quantile = |a: f64, b: f64, share: f64| Beta::new(a, b).map(|beta| beta.inverse_cdf(share));
    let low = if fewest == 0.0 {
        0.0
    } else {
        quantile(fewest, n - fewest + 1.0, tail).unwrap_or(0.0)
    };
    let high = if most == n {
        1.0
    } else {
        quantile(most + 1.0, n - most, 1.0 - tail).unwrap_or(1.0)
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
        let median = quantile(&sorted, 0.5, 100);
        assert_eq!((median.low, median.high), (Some(40.0), Some(61.0)));
        assert_eq!(median.value, 50.5);
    }

    #[test]
    fn a_sample_too_small_for_a_quantile_says_so() {
        let sorted: Vec<f64> = (0..100).map(f64::from).collect();
        // With 100 draws all lie below the quantile of 99 % with a probability of 0.99^100 = 37 %.
        assert_eq!(quantile(&sorted, 0.99, 100).high, None);
        assert_eq!(quantile(&[7.0], 0.5, 1).value, 7.0);
    }

    #[test]
    fn equal_values_of_one_draw_say_no_more_than_one() {
        let once: Vec<f64> = (1..=100).map(f64::from).collect();
        let often: Vec<f64> = once.iter().flat_map(|value| [*value; 7]).collect();
        for share in [0.05, 0.5, 0.95] {
            let (few, many) = (quantile(&once, share, 100), quantile(&often, share, 100));
            assert_eq!((few.low, few.high), (many.low, many.high), "{share}");
        }
        // With five draws even the median is unknown, however often each was repeated.
        let five: Vec<f64> = (0..250).map(|value| f64::from(value / 50)).collect();
        let median = quantile(&five, 0.5, 5);
        assert_eq!((median.low, median.high), (None, None));
    }

    #[test]
    fn a_share_at_the_end_of_its_interval_has_the_draws_with_the_probability_of_the_tail() {
        for (kept, count) in [(495, 500), (3, 10), (999, 1000)] {
            let (low, high) = share_interval(kept as f64 / count as f64, count);
            let at_least = 1.0 - Binomial::new(low, count).unwrap().cdf(kept - 1);
            let at_most = Binomial::new(high, count).unwrap().cdf(kept);
            assert!((at_least - 0.025).abs() < 1e-6, "{at_least}");
            assert!((at_most - 0.025).abs() < 1e-6, "{at_most}");
        }
        // If all of n draws keep the bound, the share is above 0.025^(1/n).
        let (low, high) = share_interval(1.0, 50);
        assert!((low - 0.025_f64.powf(1.0 / 50.0)).abs() < 1e-6);
        assert_eq!((high, share_interval(0.0, 50).0), (1.0, 0.0));
        // 2.5 of 10 draws: from the lower end of 2 to the upper one of 3.
        let between = share_interval(0.25, 10);
        assert_eq!(
            between,
            (share_interval(0.2, 10).0, share_interval(0.3, 10).1)
        );
    }
}
