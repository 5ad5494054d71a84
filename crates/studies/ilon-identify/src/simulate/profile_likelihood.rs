//! What drives leave along the whole range of one key, and which values of it they do not refuse.
//!
//! An interval out of the equations as they are at the best fit says nothing of values far from it. Where a way grows with a key and falls again,
//! two values explain it, and which of them a search ends at is chance. So each key is moved along its range, with the others following by their
//! derivatives at the best fit. A value v is refused in favour of another, v', if the drives lean towards what v' makes, d = f(v') - f(v), by more
//! than chance has it: r(v) . d, whose mean is 0 where v is true, is held against what chance makes of it. That comes from how runs scatter about
//! the best fit, or from what wheel angles make of it at v where that is more, and from what so few sets of angles leave of f(v). Where f is a
//! line, the values that are left are those of the usual interval.

use nalgebra::{DMatrix, DVector};

/// Into so many parts a range is cut, each of which is simulated.
pub(super) const PARTS: u32 = 12;
/// Into so many each of these is cut again, between which all is taken to change evenly.
const FINER: u32 = 8;
/// How often what lies between a value that is held and one that is not is halved.
const HALVED: i32 = 6;
/// A column of which less than this share is its own follows from those before it.
const OWN: f64 = 1e-4;

/// Half of the interval of 95 % of a normal distribution, over its standard deviation.
pub(super) const NORMAL: f64 = 1.96;

/// The equations of one drive of a log, in order.
pub(super) struct Share {
    pub run: usize,
    /// Its place among the simulated drives.
    pub drive: usize,
    pub rows: usize,
}

/// What is left at one value.
pub(super) struct Point {
    pub value: f64,
    /// A row an equation, over its error.
    pub left: DVector<f64>,
    /// By how much each of the sets of wheel angles is off from their mean, a column a set, over the error too.
    pub deviations: DMatrix<f64>,
    /// Whether the value before can be simulated too: what lies between is taken to lie between them.
    pub follows: bool,
}

/// How runs scatter about the best fit.
pub(super) struct Scattered {
    /// What is left there, by [`Scatter::adjusted`](crate::scatter::Scatter::adjusted) of each run.
    pub left: DVector<f64>,
    /// So many standard errors off is further than chance has it.
    pub furthest: f64,
}

/// What is left along the range of one key, by rising values, of what the other values cannot make up for.
pub(super) struct LikelihoodProfile {
    points: Vec<Point>,
}

/// The values that are not refused.
pub(super) struct AcceptedValues {
    /// The least and the largest.
    pub ends: [f64; 2],
    /// The best of those in another valley.
    pub elsewhere: Option<f64>,
}

impl LikelihoodProfile {
    /// Takes off what the other values can make up for: `others` is how what is left follows them, a column a value.
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

    /// The value at which least is left, and the sum of squares there.
    pub fn least(&self) -> Option<[f64; 2]> {
        let squares = self
            .points
            .iter()
            .map(|point| [point.value, point.left.norm_squared()]);
        squares.min_by(|a, b| a[1].total_cmp(&b[1]))
    }

    /// The values that drives do not refuse, of which that found is always one.
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
        // Between a value that is held and one that is refused lies the end.
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

    /// From where to where no value is better than one nearer to `value`: the valley in which it lies.
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

/// Whether what is left at a value leans towards another by more than chance has it.
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

/// The variance of numbers whose mean is 0; 0 of less than two.
fn variance(of_sets: &DVector<f64>) -> f64 {
    of_sets.norm_squared() / of_sets.len().saturating_sub(1).max(1) as f64
}

/// What is taken to be left between two points.
fn between(before: &Point, after: &Point, place: f64) -> Point {
    Point {
        value: before.value + place * (after.value - before.value),
        left: before.left.lerp(&after.left, place),
        deviations: &before.deviations * (1.0 - place) + &after.deviations * place,
        follows: true,
    }
}

/// Takes what unit vectors span off a vector.
fn take_off(left: &mut DVector<f64>, spanned: &[DVector<f64>]) {
    for own in spanned {
        left.axpy(-own.dot(left), own, 1.0);
    }
}

/// What columns span, at right angles to one another and of length 1.
fn basis(columns: &DMatrix<f64>) -> Vec<DVector<f64>> {
    let mut found: Vec<DVector<f64>> = Vec::with_capacity(columns.ncols());
    for column in columns.column_iter() {
        let mut own = column.clone_owned();
        let size = own.norm();
        // Twice, as what is small after the first time is not at right angles yet.
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

    /// Of one equation a run, how it follows a key from 0 to 1.
    type Ways<'a> = &'a dyn Fn(f64) -> f64;

    /// How eight runs of one equation each scatter about the best fit of a way.
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

    /// Eight runs of one drive, one equation each. With sets, each drive begins at angles by chance that matter as much as v does.
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

    /// LikelihoodProfile a line the values held are those of Student's interval, to the part into which a range is cut.
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

    /// A way that rises and falls is as long at two values: whichever is the truth, the interval holds it in 95 of 100 draws, and the other is named.
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
        // Two standard deviations of a binomial about 950; where the search ended is the truth in half of the draws, the other in the rest.
        assert!((936..=990).contains(&held), "{held}");
        assert!((400..=600).contains(&named), "{named}");
    }

    /// Where few sets of wheel angles stand for all, and runs begin at any, the interval holds the truth as often.
    #[test]
    fn wheel_angles_and_how_few_sets_there_are_is_counted() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut held = 0;
        for _ in 0..1000 {
            let sets: Vec<f64> = (0..8).map(|_| 3.0 * noise(&mut rng)).collect();
            let mean = sets.iter().sum::<f64>() / 8.0;
            let about: Vec<f64> = sets.iter().map(|set| set - mean).collect();
            // What is simulated is the mean over the sets, which is off from that of all.
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

    /// What another value can make up for says nothing of the first: of two keys that do the same, all of the range is held.
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

    /// A quarter of the way from one point to the next all of it is a quarter further.
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
