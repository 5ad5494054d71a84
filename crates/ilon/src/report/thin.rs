//! Fewer points for plots: a screen shows two thousand, a trace has many more.

/// The most points of one plotted curve.
pub(super) const MAX_POINTS: usize = 2000;

/// A curve of at most `max_points` points that keeps its outline: of each interval of the input the smallest and the
/// largest value stay, in their order, and so do the first and the last point.
pub(super) fn envelope(curve: &[(f64, f64)], max_points: usize) -> Vec<(f64, f64)> {
    if curve.len() <= max_points.max(4) {
        return curve.to_vec();
    }
    let inner = &curve[1..curve.len() - 1];
    // Two points an interval, beside the first and the last.
    let intervals = (max_points.max(4) - 2) / 2;
    let mut kept = vec![curve[0]];
    for k in 0..intervals {
        let from = k * inner.len() / intervals;
        let to = (k + 1) * inner.len() / intervals;
        let Some((low, high)) = extremes(&inner[from..to]) else {
            continue;
        };
        kept.push(inner[from + low.min(high)]);
        if low != high {
            kept.push(inner[from + low.max(high)]);
        }
    }
    kept.push(curve[curve.len() - 1]);
    kept
}

/// At most `max_points` indices below `len`, evenly spread, the first and the last among them.
pub(super) fn evenly(len: usize, max_points: usize) -> Vec<usize> {
    let max_points = max_points.max(2);
    if len <= max_points {
        return (0..len).collect();
    }
    (0..max_points)
        .map(|k| k * (len - 1) / (max_points - 1))
        .collect()
}

/// Rounded to `digits` significant decimal digits, so that it is short in a file.
pub(super) fn short(x: f64, digits: usize) -> f64 {
    if !x.is_finite() || x == 0.0 {
        return x;
    }
    // Decimal scientific notation of a finite number always parses.
    format!("{x:.*e}", digits.saturating_sub(1))
        .parse()
        .unwrap_or(x)
}

/// Where the smallest and the largest value stand; `None` of nothing.
fn extremes(curve: &[(f64, f64)]) -> Option<(usize, usize)> {
    let by_value = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
    let values = || curve.iter().map(|p| p.1).enumerate();
    Some((values().min_by(by_value)?.0, values().max_by(by_value)?.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_ends_peaks_and_order() {
        let mut curve: Vec<_> = (0..100_000)
            .map(|k| (f64::from(k), (0.01 * f64::from(k)).sin()))
            .collect();
        curve[31_337].1 = 9.0;
        curve[77_777].1 = -9.0;
        let thin = envelope(&curve, 2000);
        assert!(thin.len() <= 2000, "{}", thin.len());
        assert_eq!((thin[0], thin[thin.len() - 1]), (curve[0], curve[99_999]));
        assert!(thin.contains(&(31_337.0, 9.0)) && thin.contains(&(77_777.0, -9.0)));
        assert!(thin.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    #[test]
    fn short_curves_stay_as_they_are() {
        let curve = [(0.0, 1.0), (1.0, f64::NAN), (2.0, 3.0)];
        assert_eq!(envelope(&curve, 2000).len(), 3);
        assert!(envelope(&[], 2000).is_empty());
    }

    #[test]
    fn even_thinning_has_both_ends_and_never_too_many() {
        for (len, max) in [(0, 5), (1, 5), (5, 5), (6, 5), (1000, 7), (1001, 1000)] {
            let indices = evenly(len, max);
            assert!(indices.len() <= max && indices.iter().all(|&i| i < len));
            assert!(indices.windows(2).all(|pair| pair[0] < pair[1]));
            if len > 0 {
                assert_eq!(
                    (indices.first(), indices.last()),
                    (Some(&0), Some(&(len - 1)))
                );
            }
        }
    }

    #[test]
    fn numbers_are_shortened_to_their_significant_digits() {
        assert_eq!(short(0.123_456_789, 4), 0.1235);
        assert_eq!(short(-98_765.0, 2), -99_000.0);
        assert_eq!(short(0.0, 4), 0.0);
        assert!(short(f64::NAN, 4).is_nan());
    }
}
