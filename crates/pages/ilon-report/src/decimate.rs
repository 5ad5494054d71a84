//! Reduces curves for plots: a screen shows two thousand points, a trace has many more.

/// Largest number of points of a plotted curve.
pub const MAX_POINTS: usize = 2000;

/// Returns the envelope of a curve with at most `max_points` points: the smallest and the largest
/// value of each interval, in their order, and the first and the last point.
pub fn envelope(curve: &[(f64, f64)], max_points: usize) -> Vec<(f64, f64)> {
    let mut outline = Envelope::new(curve.len(), max_points);
    for point in curve {
        outline.add(*point);
    }
    outline.kept
}

/// The envelope of a curve whose points arrive one by one and whose number is known beforehand, as
/// computed by [`envelope`].
pub struct Envelope {
    /// Number of expected points, and of points so far.
    count: usize,
    seen: usize,
    /// Number of intervals between the first and the last point; `None` if all points are kept.
    intervals: Option<usize>,
    interval: usize,
    low: Option<(usize, (f64, f64))>,
    high: Option<(usize, (f64, f64))>,
    kept: Vec<(f64, f64)>,
}

impl Envelope {
    pub fn new(count: usize, max_points: usize) -> Self {
        let max_points = max_points.max(4);
        Self {
            count,
            seen: 0,
            intervals: (count > max_points).then_some((max_points - 2) / 2),
            interval: 0,
            low: None,
            high: None,
            kept: Vec::with_capacity(count.min(max_points)),
        }
    }

    /// Adds the next point.
    pub fn add(&mut self, point: (f64, f64)) {
        let index = self.seen;
        self.seen += 1;
        let Some(intervals) = self.intervals else {
            self.kept.push(point);
            return;
        };
        if index == 0 || index + 1 >= self.count {
            self.keep_extremes();
            self.kept.push(point);
            return;
        }
        let inner = self.count - 2;
        if index > (self.interval + 1) * inner / intervals {
            self.keep_extremes();
            self.interval += 1;
        }
        let order = |kept: &(usize, (f64, f64))| point.1.total_cmp(&kept.1.1);
        if self.low.as_ref().is_none_or(|low| order(low).is_lt()) {
            self.low = Some((index, point));
        }
        if self.high.as_ref().is_none_or(|high| order(high).is_ge()) {
            self.high = Some((index, point));
        }
    }

    fn keep_extremes(&mut self) {
        if let (Some(low), Some(high)) = (self.low.take(), self.high.take()) {
            let (first, second) = if low.0 < high.0 {
                (low, high)
            } else {
                (high, low)
            };
            self.kept.push(first.1);
            if first.0 != second.0 {
                self.kept.push(second.1);
            }
        }
    }

    /// Returns the kept points. If the curve ended early, the last interval is left out.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        self.kept.iter().copied()
    }
}

/// Evenly spaced items of a sequence whose items arrive one by one and whose length is known
/// beforehand, chosen by [`evenly`].
pub struct Evenly<T> {
    indices: Vec<usize>,
    seen: usize,
    kept: Vec<T>,
}

impl<T> Evenly<T> {
    pub fn new(count: usize, max_points: usize) -> Self {
        let indices = evenly(count, max_points);
        Self {
            kept: Vec::with_capacity(indices.len()),
            indices,
            seen: 0,
        }
    }

    /// Adds the next item.
    pub fn add(&mut self, thing: T) {
        if self.indices.get(self.kept.len()) == Some(&self.seen) {
            self.kept.push(thing);
        }
        self.seen += 1;
    }

    pub fn kept(&self) -> &[T] {
        &self.kept
    }
}

/// Returns at most `max_points` indices below `len`, evenly spaced, including the first and the
/// last.
pub fn evenly(len: usize, max_points: usize) -> Vec<usize> {
    let max_points = max_points.max(2);
    if len <= max_points {
        return (0..len).collect();
    }
    (0..max_points)
        .map(|k| k * (len - 1) / (max_points - 1))
        .collect()
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

    /// Returns the first and the last point and, for each interval between them, the smallest and
    /// the largest.
    fn extremes_of_intervals(curve: &[(f64, f64)], max_points: usize) -> Vec<(f64, f64)> {
        let max_points = max_points.max(4);
        if curve.len() <= max_points {
            return curve.to_vec();
        }
        let inner = &curve[1..curve.len() - 1];
        let intervals = (max_points - 2) / 2;
        let by_value = |a: &(usize, &(f64, f64)), b: &(usize, &(f64, f64))| a.1.1.total_cmp(&b.1.1);
        let mut kept = vec![curve[0]];
        for k in 0..intervals {
            let from = k * inner.len() / intervals;
            let interval = &inner[from..(k + 1) * inner.len() / intervals];
            let values = || interval.iter().enumerate();
            let (Some(low), Some(high)) = (values().min_by(by_value), values().max_by(by_value))
            else {
                continue;
            };
            kept.push(interval[low.0.min(high.0)]);
            if low.0 != high.0 {
                kept.push(interval[low.0.max(high.0)]);
            }
        }
        kept.push(curve[curve.len() - 1]);
        kept
    }

    #[test]
    fn points_that_come_one_by_one_are_thinned_like_a_whole_curve() {
        for (count, max) in [
            (0, 9),
            (1, 9),
            (9, 9),
            (10, 9),
            (50, 9),
            (50, 8),
            (1003, 100),
        ] {
            // Rough, with equal and missing values.
            let value = |k: usize| match k % 11 {
                7 => f64::NAN,
                rest => (k * 37 % 19) as f64 + rest as f64,
            };
            let curve: Vec<_> = (0..count).map(|k| (k as f64, value(k))).collect();
            let mut outline = Envelope::new(count, max);
            let mut spread = Evenly::new(count, max);
            for point in &curve {
                outline.add(*point);
                spread.add(point.0 as usize);
            }
            let times = |points: Vec<(f64, f64)>| points.iter().map(|p| p.0).collect::<Vec<_>>();
            assert_eq!(
                times(outline.points().collect()),
                times(extremes_of_intervals(&curve, max)),
                "{count} {max}"
            );
            assert_eq!(spread.kept(), evenly(count, max));
        }
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
}
