//! Profile likelihood: the residuals of drives along the whole range of one key, and the values of
//! it that the drives do not reject.
//!
//! An interval from equations linearised at the best fit says nothing about values far from it. If
//! a distance rises with a key and falls again, two values explain it, and chance decides which of
//! them a search finds. So each key is moved along its range, with the others adapted by their
//! derivatives at the best fit. A value v is rejected in favour of another, v', if the residuals
//! correlate with the difference d = f(v') - f(v) more than by chance: r(v) . d, whose mean is 0 if
//! v is true, is compared with its standard error. This comes from the scatter of runs about the
//! best fit, or from the wheel angles' effect at v if that is larger, plus the error of f(v) from
//! few sets of angles. If f is linear, the remaining values are those of the usual interval.

use nalgebra::{DMatrix, DVector};

/// Number of parts of a range; each end is simulated.
pub(super) const PARTS: u32 = 12;
/// Subdivisions of each part, by linear interpolation.
const FINER: u32 = 8;
/// Number of bisections between an accepted and a rejected value.
const HALVED: i32 = 6;
/// A column whose independent part is below this share depends on those before it.
const OWN: f64 = 1e-4;

/// Half of the 95 % interval of a normal distribution, over its standard deviation.
pub(super) const NORMAL: f64 = 1.96;

/// The equations of one drive of a log, in order.
pub(super) struct Share {
    pub run: usize,
    /// Index of the simulated drive.
    pub drive: usize,
    pub rows: usize,
}

/// The residuals at one value.
pub(super) struct Point {
    pub value: f64,
    /// One row per equation, over its error.
    pub left: DVector<f64>,
    /// Deviations of each set of wheel angles from their mean, one column per set, over the error
    /// too.
    pub deviations: DMatrix<f64>,
    /// Whether the value before can be simulated too: values between are then interpolated.
    pub follows: bool,
}

/// Scatter of runs about the best fit.
pub(super) struct Scattered {
    /// The residuals there, by [`Scatter::adjusted`](crate::scatter::Scatter::adjusted) of each
    /// run.
    pub left: DVector<f64>,
    /// Largest deviation by chance, in standard errors.
    pub furthest: f64,
}

/// Residuals along the range of one key, by increasing values, without the part that the other
/// values can compensate.
pub(super) struct LikelihoodProfile {
    points: Vec<Point>,
}

/// The values that are not rejected.
pub(super) struct AcceptedValues {
    /// The smallest and the largest.
    pub ends: [f64; 2],
    /// The best value in another minimum.
    pub elsewhere: Option<f64>,
}

impl LikelihoodProfile {
    /// Removes the part that the other values can compensate: `others` is the derivative of the
    /// residuals, one column per value.
    pub fn new(mut points: Vec<Point>, others: &DMatrix<f64>) -> Self {
        let made_up = basis(others);
        for point in &mut points {
            take_off(&mut point.left, &made_up);
        }
        let finer = points.iter().zip(points.iter().skip(1));
        let mut all: Vec<Point> = Vec::with_capacity(points.len() * FINER as usize);
        for (before, after) in finer {
            if after.follows {
                let between =
                    |part: u32| between(before, after, f64::from(part) / f64::from(FINER));
                all.extend((1..FINER).map(between));
            }
        }
        all.extend(points);
        all.sort_by(|a, b| a.value.total_cmp(&b.value));
        Self { points: all }
    }

    /// Returns the value with the smallest residual, and the sum of squares there.
    pub fn least(&self) -> Option<[f64; 2]> {
        let squares = self
            .points
            .iter()
            .map(|point| [point.value, point.left.norm_squared()]);
        squares.min_by(|a, b| a[1].total_cmp(&b[1]))
    }

    /// Returns the values that drives do not reject; the one found is always among them.
    pub fn held(
        &self,
        found: f64,
        shares: &[Share],
        scattered: &Scattered,
    ) -> Option<AcceptedValues> {
        let is_held = |point: &Point| {
            let leans = |other: &Point| leans(point, other, shares, scattered);
            point.value == found || !self.points.iter().any(leans)
        };
        let held: Vec<bool> = self.points.iter().map(is_held).collect();
        let first = held.iter().position(|held| *held)?;
        let last = held.iter().rposition(|held| *held)?;
        // The end lies between an accepted and a rejected value.
        let end = |held: usize, refused: Option<&Point>| {
            let (from, mut share) = (&self.points[held], 0.0);
            for part in 1..=HALVED {
                let further = share + 0.5_f64.powi(part);
                let tried = refused.map(|refused| between(from, refused, further));
                if tried.is_some_and(|tried| is_held(&tried)) {
                    share = further;
                }
            }
            refused.map_or(from.value, |refused| {
                from.value + share * (refused.value - from.value)
            })
        };
        let before = first.checked_sub(1).filter(|_| self.points[first].follows);
        let before = before.map(|before| &self.points[before]);
        let after = self.points.get(last + 1).filter(|after| after.follows);
        let ends = [end(first, before), end(last, after)];
        let [low, high] = self.valley(found);
        let other = self.points.iter().zip(&held);
        let elsewhere = other
            .filter(|(point, held)| **held && (point.value < low || point.value > high))
            .map(|(point, _)| point)
            .min_by(|a, b| a.left.norm_squared().total_cmp(&b.left.norm_squared()))
            .map(|point| point.value);
        Some(AcceptedValues { ends, elsewhere })
    }

    /// Returns the range around `value` in which the residual rises monotonically with the distance
    /// from it.
    fn valley(&self, value: f64) -> [f64; 2] {
        let squares: Vec<f64> = self
            .points
            .iter()
            .map(|point| point.left.norm_squared())
            .collect();
        let here = self.points.partition_point(|point| point.value < value);
        let (mut low, mut high) = (here, here);
        while low > 0 && squares[low - 1] >= squares[low] {
            low -= 1;
        }
        while high + 1 < squares.len() && squares[high + 1] >= squares[high] {
            high += 1;
        }
        [self.points[low].value, self.points[high].value]
    }
}

/// Whether the residuals at a value favour another by more than chance.
fn leans(point: &Point, other: &Point, shares: &[Share], scattered: &Scattered) -> bool {
    let towards = &point.left - &other.left;
    let sum = point.left.dot(&towards);
    if sum <= 0.0 {
        return false;
    }
    let sets = point.deviations.ncols();
    let runs = shares.iter().map(|share| share.run + 1).max().unwrap_or(0);
    let drives = shares.iter().map(|share| share.drive + 1).max();
    let mut of_run = DVector::<f64>::zeros(runs);
    let mut of_drive = vec![DVector::<f64>::zeros(sets); drives.unwrap_or(0)];
    let mut by_angles = 0.0;
    let mut row = 0;
    for share in shares {
        let towards = towards.rows(row, share.rows);
        of_run[share.run] += scattered.left.rows(row, share.rows).dot(&towards);
        let of_sets = point.deviations.rows(row, share.rows).tr_mul(&towards);
        by_angles += variance(&of_sets);
        of_drive[share.drive] += of_sets;
        row += share.rows;
    }
    let by_few: f64 = of_drive.iter().map(variance).sum::<f64>() / sets.max(1) as f64;
    let by_runs = scattered.furthest * of_run.norm();
    let by_angles = NORMAL * by_angles.sqrt();
    sum > libm::hypot(by_runs.max(by_angles), NORMAL * by_few.sqrt())
}

/// Returns the variance of numbers whose mean is 0; 0 for fewer than two.
fn variance(of_sets: &DVector<f64>) -> f64 {
    of_sets.norm_squared() / of_sets.len().saturating_sub(1).max(1) as f64
}

/// Interpolates the residuals between two points.
fn between(before: &Point, after: &Point, place: f64) -> Point {
    Point {
        value: before.value + place * (after.value - before.value),
        left: before.left.lerp(&after.left, place),
        deviations: &before.deviations * (1.0 - place) + &after.deviations * place,
        follows: true,
    }
}

/// Removes the projection on the span of unit vectors from a vector.
fn take_off(left: &mut DVector<f64>, spanned: &[DVector<f64>]) {
    for own in spanned {
        left.axpy(-own.dot(left), own, 1.0);
    }
}

/// Returns an orthonormal basis of the span of columns.
fn basis(columns: &DMatrix<f64>) -> Vec<DVector<f64>> {
    let mut found: Vec<DVector<f64>> = Vec::with_capacity(columns.ncols());
    for column in columns.column_iter() {
        let mut own = column.clone_owned();
        let size = own.norm();
        // Twice, because a small remainder is not orthogonal after the first pass.
        take_off(&mut own, &found);
        take_off(&mut own, &found);
        let left = own.norm();
        if left > OWN * size {
            found.push(own / left);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::scatter::{Cluster, Scatter};

    const RUNS: usize = 8;
    /// Standard deviation of the noise of an equation.
    const NOISE: f64 = 0.1;

    /// Result of a run's one equation as a function of a key from 0 to 1.
    type Ways<'a> = &'a dyn Fn(f64) -> f64;

    /// Scatter of eight runs of one equation each about the best fit.
    fn scattered(way: Ways<'_>, seen: &[f64], found: f64) -> Scattered {
        let slope = (way(found + 1e-6) - way(found - 1e-6)) / 2e-6;
        let row = |seen: &f64| {
            let jacobian = DMatrix::from_element(1, 1, -slope);
            (jacobian, DVector::from_element(1, seen - way(found)))
        };
        let rows: Vec<_> = seen.iter().map(row).collect();
        let cluster = |(jacobian, left): &(DMatrix<f64>, DVector<f64>)| {
            let mut cluster = Cluster::empty(1);
            cluster.add(jacobian.clone(), left.clone());
            cluster
        };
        let clusters: Vec<Cluster> = rows.iter().map(cluster).collect();
        let scatter = Scatter::new(&clusters).unwrap();
        let left = rows.iter().enumerate();
        let left = left.map(|(run, (jacobian, left))| scatter.adjusted(run, jacobian, left)[0]);
        Scattered {
            left: DVector::from_iterator(RUNS, left),
            furthest: Scatter::furthest(scatter.error_of(0).unwrap()[1]),
        }
    }

    /// Eight runs of one drive, one equation each. With sets, each drive starts at random angles
    /// that matter as much as v.
    fn along(way: Ways<'_>, seen: &[f64], sets: &[f64]) -> (LikelihoodProfile, Vec<Share>) {
        let point = |part: u32| {
            let value = f64::from(part) / f64::from(PARTS);
            Point {
                value,
                left: DVector::from_iterator(RUNS, seen.iter().map(|seen| seen - way(value))),
                deviations: DMatrix::from_fn(RUNS, sets.len(), |_, set| value * sets[set]),
                follows: part > 0,
            }
        };
        let shares = (0..RUNS).map(|run| Share {
            run,
            drive: 0,
            rows: 1,
        });
        let none = DMatrix::zeros(RUNS, 0);
        (
            LikelihoodProfile::new((0..=PARTS).map(point).collect(), &none),
            shares.collect(),
        )
    }

    fn noise(rng: &mut ChaCha8Rng) -> f64 {
        let own: f64 = StandardNormal.sample(rng);
        NOISE * own
    }

    fn seen(way: Ways<'_>, truth: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
        (0..RUNS).map(|_| way(truth) + noise(rng)).collect()
    }

    /// For a linear function the accepted values are those of Student's interval, to the resolution
    /// of the range.
    #[test]
    fn of_a_line_the_interval_is_that_of_the_mean() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let line = |value: f64| value;
        for _ in 0..50 {
            let seen = seen(&line, 0.5, &mut rng);
            let (along, shares) = along(&line, &seen, &[]);
            let mean = seen.iter().sum::<f64>() / RUNS as f64;
            let squares: f64 = seen.iter().map(|own| (own - mean).powi(2)).sum();
            let half = 2.3646 * (squares / (RUNS * (RUNS - 1)) as f64).sqrt();
            let [value, _] = along.least().unwrap();
            let held = along
                .held(value, &shares, &scattered(&line, &seen, mean))
                .unwrap();
            let part = 1.0 / f64::from(PARTS * FINER);
            assert!(
                (held.ends[0] - (mean - half)).abs() < part,
                "{:?} {mean} {half}",
                held.ends
            );
            assert!(
                (held.ends[1] - (mean + half)).abs() < part,
                "{:?} {mean} {half}",
                held.ends
            );
            assert_eq!(held.elsewhere, None);
        }
    }

    /// A function that rises and falls has the same result at two values: whichever is true, the
    /// interval holds it in 95 of 100 draws, and the other is reported.
    #[test]
    fn of_a_way_that_rises_and_falls_both_values_are_held() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let hump = |value: f64| 4.0 * value * (1.0 - value);
        let (mut held, mut named) = (0, 0);
        for draw in 0..1000 {
            let truth = if draw % 2 == 0 { 0.15 } else { 0.85 };
            let seen = seen(&hump, truth, &mut rng);
            let (along, shares) = along(&hump, &seen, &[]);
            let best = along.least().unwrap()[0];
            let found = along
                .held(best, &shares, &scattered(&hump, &seen, best))
                .unwrap();
            held += u32::from(found.ends[0] <= truth && truth <= found.ends[1]);
            named += u32::from(
                found
                    .elsewhere
                    .is_some_and(|other| (other - truth).abs() < 0.1),
            );
        }
        // Two standard deviations of a binomial about 950; the search ends at the truth in half of
        // the draws, at the other value in the rest.
        assert!((936..=990).contains(&held), "{held}");
        assert!((400..=600).contains(&named), "{named}");
    }

    /// If few sets of wheel angles represent all, and runs start at random ones, the interval still
    /// holds the truth as often.
    #[test]
    fn wheel_angles_and_how_few_sets_there_are_is_counted() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut held = 0;
        for _ in 0..1000 {
            let sets: Vec<f64> = (0..8).map(|_| 3.0 * noise(&mut rng)).collect();
            let mean = sets.iter().sum::<f64>() / 8.0;
            let about: Vec<f64> = sets.iter().map(|set| set - mean).collect();
            // The simulated result is the mean over the sets, which differs from that over all
            // angles.
            let simulated = |value: f64| value * (1.0 + mean);
            let truth = 0.5;
            let of_run = |_| truth * (1.0 + 3.0 * noise(&mut rng)) + noise(&mut rng);
            let seen: Vec<f64> = (0..RUNS).map(of_run).collect();
            let (along, shares) = along(&simulated, &seen, &about);
            let best = along.least().unwrap()[0];
            let found = along
                .held(best, &shares, &scattered(&simulated, &seen, best))
                .unwrap();
            held += u32::from(found.ends[0] <= truth && truth <= found.ends[1]);
        }
        assert!((936..=990).contains(&held), "{held}");
    }

    /// An effect that another value can compensate says nothing about the first: for two keys with
    /// the same effect the whole range is accepted.
    #[test]
    fn what_another_value_makes_up_for_refuses_nothing() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let line = |value: f64| value;
        let seen = seen(&line, 0.5, &mut rng);
        let (alone, shares) = along(&line, &seen, &[]);
        let of_other = DMatrix::repeat(RUNS, 1, -0.3);
        let points = alone.points.into_iter().step_by(FINER as usize).collect();
        let both = LikelihoodProfile::new(points, &of_other);
        let scattered = scattered(&line, &seen, 0.5);
        assert_eq!(
            both.held(0.5, &shares, &scattered).unwrap().ends,
            [0.0, 1.0]
        );
    }

    /// A quarter of the way between two points all quantities are a quarter further.
    #[test]
    fn between_two_points_all_goes_along_straight_lines() {
        let point = |value: f64, left: [f64; 2], deviation: f64| Point {
            value,
            left: DVector::from_row_slice(&left),
            deviations: DMatrix::from_element(2, 1, deviation),
            follows: false,
        };
        let (before, after) = (point(1.0, [0.0, 4.0], 8.0), point(3.0, [2.0, 0.0], 4.0));
        let found = between(&before, &after, 0.25);
        assert_eq!(found.value, 1.5);
        assert_eq!(found.left, DVector::from_row_slice(&[0.5, 3.0]));
        assert_eq!(found.deviations, DMatrix::from_element(2, 1, 7.0));
        assert!(found.follows);
    }
}
