//! Fits the free keys so that simulated drives match those of the logs, with uncertainties.
//!
//! A drive starts at roller angles phi that no log contains. Its result is y = f(v, phi) + e for
//! the values v, so its mean over phi is compared, and the variance over phi is an error of the
//! drive in addition to e: both are estimated by simulating drives from several sets of angles. The
//! variance depends on v; it is held during a search and updated at the result, because a search
//! could otherwise gain by increasing it.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

use ilon_sim::Error;
use nalgebra::{DMatrix, DVector, Matrix3xX};
use rayon::prelude::*;

use super::drive::{self, Ready, Task, made};
use super::drive_result::{DriveResult, MeanOverPhases};
use super::parameters::Free;
use super::phases::Starts;
use super::profile_likelihood::{LikelihoodProfile, NORMAL, PARTS, Point, Scattered, Share};
use super::residuals::Scales;
use super::steady_drives::{Course, Leg};
use crate::least_squares::{Minimum, Search, least_squares};
use crate::scatter::{Cluster, Interval, Scatter};
use crate::study::{Simulate, Study};

/// Largest number of updates of the variance over wheel angles.
const ROUNDS: usize = 2;
/// Updates end when values move by less than this many standard errors.
const SETTLED: f64 = 0.2;
/// Largest number of restarts of a search with a smaller residual along the range of a key.
const RESTARTS: usize = 2;
/// A restart needs a residual below this share.
const LESS: f64 = 0.95;
/// Number of sets of wheel angles used to test whether they matter.
const TRIED: u32 = 2;
/// They matter if they move a value by this share of its standard error: a 95 % interval that is
/// off by as much holds the truth in 94 %.
const MATTERS: f64 = 0.3;

/// The setup for simulating drives.
pub(super) struct Rig<'a> {
    pub study: &'a Study,
    pub section: &'a Simulate,
    pub courses: &'a [Course],
    pub nominal: &'a Matrix3xX<f64>,
    pub count: &'a (dyn Fn(u32) + Sync),
    pub simulated: AtomicU32,
}

impl Rig<'_> {
    /// Returns the results of some drives of a robot; `None` if it diverges.
    pub fn drives(
        &self,
        ready: &Ready,
        which: &[usize],
        starts: Starts,
    ) -> Result<Vec<Option<MeanOverPhases>>, Error> {
        let sets = starts.count();
        let tasks: Vec<Task> = which
            .iter()
            .flat_map(|drive| (0..sets).map(|set| (*drive, set)))
            .map(|(drive, set)| Task {
                drive,
                seed: self.study.file.seed,
                starts,
                set,
            })
            .collect();
        let one = |task: &Task| {
            let course = &self.courses[task.drive];
            let made = made(self.section, ready, course, *task, self.nominal);
            (self.count)(self.simulated.fetch_add(1, Ordering::Relaxed) + 1);
            made
        };
        let all: Result<Vec<Option<DriveResult>>, Error> = tasks.par_iter().map(one).collect();
        let all = all?;
        Ok(all.chunks(sets as usize).map(MeanOverPhases::new).collect())
    }
}

/// The problem to fit. In the search, values are those of the free keys, followed by the scale of
/// each series.
pub(super) struct Problem<'a> {
    pub rig: &'a Rig<'a>,
    pub free: &'a [Free],
    pub scales: &'a Scales,
    pub fitted: &'a [&'a Leg],
    /// Indices of the simulated drives that are needed, in order.
    pub wanted: &'a [usize],
    pub starts: Starts,
    /// Cache of simulations: scales and errors do not affect the motion.
    kept: Mutex<Vec<Simulated>>,
}

/// Results of drives at some values of the keys.
type Simulated = (Vec<f64>, Vec<Option<MeanOverPhases>>);

/// Fitted values and derived quantities.
pub(super) struct Fitted {
    pub found: Minimum,
    pub intervals: Vec<Interval>,
    /// For each free key, a second value, in another minimum, that the drives do not reject.
    pub elsewhere: Vec<Option<f64>>,
}

/// Scatter of runs about the fit.
struct Runs {
    scatter: Scatter,
    /// Residual of each equation, by [`Scatter::adjusted`].
    adjusted: DVector<f64>,
}

impl<'a> Problem<'a> {
    pub fn new(
        rig: &'a Rig<'a>,
        free: &'a [Free],
        scales: &'a Scales,
        (fitted, wanted): (&'a [&'a Leg], &'a [usize]),
        starts: Starts,
    ) -> Self {
        Self {
            rig,
            free,
            scales,
            fitted,
            wanted,
            starts,
            kept: Mutex::new(Vec::new()),
        }
    }

    /// Returns the results of the drives at some values; `None` if one of them fails.
    fn made(&self, seen: &[f64]) -> Result<Option<Vec<MeanOverPhases>>, Error> {
        let own = &seen[..self.free.len()];
        let known = {
            let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            let known = kept.iter().find(|(values, _)| *values == own);
            known.map(|(_, made)| made.clone())
        };
        let made = match known {
            Some(made) => made,
            None => {
                // Each key alone can take any value of its range; some combinations give an
                // impossible robot.
                let Ok(ready) = self.ready(own) else {
                    return Ok(None);
                };
                let made = self.rig.drives(&ready, self.wanted, self.starts)?;
                let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
                kept.push((own.to_vec(), made.clone()));
                made
            }
        };
        Ok(made.into_iter().collect())
    }

    /// Returns the robot at some values of the keys.
    fn ready(&self, own: &[f64]) -> Result<Ready, Error> {
        let keys = drive::keys(self.rig.study, self.free, &shown(self.free, own), &[]);
        Ready::new(self.rig.study, &keys)
    }

    /// Returns differences of measured and simulated values with the errors of the log, one row per
    /// equation; `of` selects the result of each drive.
    fn rows(
        &self,
        seen: &[f64],
        made: &[MeanOverPhases],
        of: impl Fn(&MeanOverPhases) -> &DriveResult,
    ) -> Vec<[f64; 2]> {
        let scales = &seen[self.free.len()..];
        let mut rows = Vec::new();
        for leg in self.fitted {
            if let Ok(place) = self.wanted.binary_search(&leg.drive) {
                rows.extend(leg.differences(of(&made[place]), self.scales.of(leg, scales)));
            }
        }
        rows
    }

    /// Returns the deviation of each equation from its mean for each set of wheel angles; empty for
    /// one set.
    fn deviations(&self, seen: &[f64], made: &[MeanOverPhases]) -> Vec<Vec<f64>> {
        let sets = self.starts.count() as usize;
        if sets < 2 {
            return Vec::new();
        }
        let of_set: Vec<Vec<[f64; 2]>> = (0..sets)
            .map(|set| self.rows(seen, made, |together| &together.each[set]))
            .collect();
        let one = |row: usize| {
            let own: Vec<f64> = of_set.iter().map(|rows| rows[row][0]).collect();
            let mean = own.iter().sum::<f64>() / sets as f64;
            own.iter().map(|value| value - mean).collect()
        };
        (0..of_set[0].len()).map(one).collect()
    }

    /// Returns the error of each equation: that of the log, plus the scatter over wheel angles.
    fn errors(&self, seen: &[f64]) -> Result<Option<Vec<f64>>, Error> {
        let Some(made) = self.made(seen)? else {
            return Ok(None);
        };
        let deviations = self.deviations(seen, &made);
        let rows = self.rows(seen, &made, |together| &together.mean);
        let one = |(row, [_, own]): (usize, &[f64; 2])| match deviations.get(row) {
            Some(deviations) => libm::hypot(*own, variance(deviations).sqrt()),
            None => *own,
        };
        Ok(Some(rows.iter().enumerate().map(one).collect()))
    }

    /// Fits values with equations weighted by their errors, and searches the range of each key for
    /// better or equally good values.
    pub fn fit(&self, start: &[f64], search: &Search) -> Result<Fitted, Error> {
        let (mut found, mut errors) = self.settled(start, search)?;
        let mut all = self.along(&found, &errors, search)?;
        for _ in 0..RESTARTS {
            let Some(better) = better(&found, &all, search) else {
                break;
            };
            let (other, of_other) = self.settled(&better, search)?;
            // With the same errors: otherwise the residuals of two sets of values cannot be
            // compared.
            let left = self.left(&other.values, &errors)?;
            if left.is_none_or(|left| left.norm_squared() >= found.residuals.norm_squared()) {
                break;
            }
            (found, errors) = (other, of_other);
            all = self.along(&found, &errors, search)?;
        }
        let runs = self.runs(&found);
        let local = self.intervals(&found, &errors, runs.as_ref())?;
        let (intervals, elsewhere) = self.whole(&found, &all, local, runs.as_ref());
        Ok(Fitted {
            found,
            intervals,
            elsewhere,
        })
    }

    /// Returns the end of a search, and the errors that weighted the equations.
    fn settled(&self, start: &[f64], search: &Search) -> Result<(Minimum, Vec<f64>), Error> {
        let mut values = start.to_vec();
        let mut round = 0;
        loop {
            // The search itself reports a start that cannot be simulated.
            let errors = self.errors(&values)?.unwrap_or_default();
            let residuals = |seen: &[f64]| -> Result<Option<Vec<f64>>, Error> {
                Ok(self
                    .left(seen, &errors)?
                    .map(|left| left.iter().copied().collect()))
            };
            let found = least_squares(&residuals, &values, search)?;
            round += 1;
            let moved = standard_errors(&found.jacobian).is_none_or(|known| {
                let by = found.values.iter().zip(&values).zip(&known);
                by.map(|((to, from), known)| (to - from).abs() / known)
                    .any(|by| by > SETTLED)
            });
            values.clone_from(&found.values);
            if self.starts.count() < 2 || round == ROUNDS || !moved {
                return Ok((found, errors));
            }
        }
    }

    /// Returns the residuals at some values, over the errors of the equations; by default over
    /// those of the log.
    fn left(&self, seen: &[f64], errors: &[f64]) -> Result<Option<DVector<f64>>, Error> {
        Ok(self.made(seen)?.map(|made| {
            let rows = self.rows(seen, &made, |together| &together.mean);
            let over =
                |(row, [left, own]): (usize, &[f64; 2])| left / errors.get(row).unwrap_or(own);
            DVector::from_iterator(rows.len(), rows.iter().enumerate().map(over))
        }))
    }

    /// Returns the residuals along the range of each key.
    fn along(
        &self,
        found: &Minimum,
        errors: &[f64],
        search: &Search,
    ) -> Result<Vec<LikelihoodProfile>, Error> {
        let one = |axis: usize| -> Result<LikelihoodProfile, Error> {
            let here = found.values[axis];
            let (low, high) = search.bounds[axis];
            let part = |part: u32| low + (high - low) * f64::from(part) / f64::from(PARTS);
            let mut values: Vec<f64> = (0..=PARTS).map(part).collect();
            let by = search.differences[axis];
            // The values used for derivatives are already simulated.
            values.extend([here - by, here, here + by].map(|value| value.clamp(low, high)));
            values.sort_by(f64::total_cmp);
            values.dedup();
            let at = |value: &f64| -> Result<Option<Point>, Error> {
                let mut seen = found.values.clone();
                seen[axis] = *value;
                self.point(*value, &seen, errors)
            };
            let points: Result<Vec<Option<Point>>, Error> = values.par_iter().map(at).collect();
            let mut follows = false;
            let points = points?.into_iter().filter_map(|point| {
                let own = follows;
                follows = point.is_some();
                Some(Point {
                    follows: own,
                    ..point?
                })
            });
            let others = found.jacobian.clone().remove_column(axis);
            Ok(LikelihoodProfile::new(points.collect(), &others))
        };
        (0..self.free.len()).into_par_iter().map(one).collect()
    }

    fn point(&self, value: f64, seen: &[f64], errors: &[f64]) -> Result<Option<Point>, Error> {
        let Some(left) = self.left(seen, errors)? else {
            return Ok(None);
        };
        let Some(made) = self.made(seen)? else {
            return Ok(None);
        };
        let deviations = self.deviations(seen, &made);
        let sets = deviations.first().map_or(0, Vec::len);
        let over = |row: usize, set: usize| deviations[row][set] / errors[row];
        Ok(Some(Point {
            value,
            deviations: DMatrix::from_fn(left.len(), sets, over),
            left,
            follows: false,
        }))
    }

    /// Returns intervals with all values that drives do not reject, and those that lie in another
    /// minimum.
    fn whole(
        &self,
        found: &Minimum,
        all: &[LikelihoodProfile],
        mut intervals: Vec<Interval>,
        runs: Option<&Runs>,
    ) -> (Vec<Interval>, Vec<Option<f64>>) {
        let one = |leg: &&Leg| Share {
            run: leg.run,
            drive: self.wanted.binary_search(&leg.drive).unwrap_or(0),
            rows: leg.equations(),
        };
        let shares: Vec<Share> = self.fitted.iter().map(one).collect();
        let mut elsewhere = vec![None; all.len()];
        for (axis, along) in all.iter().enumerate() {
            let interval = &mut intervals[axis];
            // If the scatter of runs is unknown, the interval stays NaN.
            let Some((runs, [_, freedoms])) =
                runs.and_then(|runs| Some((runs, runs.scatter.error_of(axis)?)))
            else {
                continue;
            };
            let scattered = Scattered {
                left: runs.adjusted.clone(),
                furthest: Scatter::furthest(freedoms),
            };
            if let Some(held) = along.held(found.values[axis], &shares, &scattered) {
                let is_far = |value: &f64| *value < interval.low || *value > interval.high;
                elsewhere[axis] = held.elsewhere.filter(is_far);
                interval.low = interval.low.min(held.ends[0]);
                interval.high = interval.high.max(held.ends[1]);
            }
        }
        (intervals, elsewhere)
    }

    /// Fits the problem with known initial wheel angles; `None` if they matter at the start or the
    /// end of the search, or if values far from there are not rejected.
    pub fn fit_unless_angles_matter(
        &self,
        start: &[f64],
        search: &Search,
    ) -> Result<Option<Fitted>, Error> {
        let residuals = |seen: &[f64]| -> Result<Option<Vec<f64>>, Error> {
            Ok(self.left(seen, &[])?.map(|left| left.as_slice().to_vec()))
        };
        let at_start = Search {
            steps: 0,
            ..search.clone()
        };
        let at_start = least_squares(&residuals, start, &at_start)?;
        if self.matter(&at_start, None)? {
            return Ok(None);
        }
        let fit = self.fit(start, search)?;
        // They may matter at other values that are not rejected.
        let do_matter = fit.elsewhere.iter().any(Option::is_some)
            || self.matter(&fit.found, Some(&fit.intervals))?;
        Ok((!do_matter).then_some(fit))
    }

    /// Returns the scatter of runs about the result; `None` for one run.
    fn runs(&self, found: &Minimum) -> Option<Runs> {
        let mut of_run: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut row = 0;
        for leg in self.fitted {
            of_run
                .entry(leg.run)
                .or_default()
                .extend(row..row + leg.equations());
            row += leg.equations();
        }
        let rows: Vec<(DMatrix<f64>, DVector<f64>)> = of_run
            .values()
            .map(|rows| {
                (
                    found.jacobian.select_rows(rows),
                    found.residuals.select_rows(rows),
                )
            })
            .collect();
        let cluster = |(jacobian, left): &(DMatrix<f64>, DVector<f64>)| {
            let mut cluster = Cluster::empty(found.values.len());
            cluster.add(jacobian.clone(), left.clone());
            cluster
        };
        let clusters: Vec<Cluster> = rows.iter().map(cluster).collect();
        let scatter = Scatter::new(&clusters)?;
        let mut adjusted = found.residuals.clone();
        for (run, (own, (jacobian, left))) in of_run.values().zip(&rows).enumerate() {
            let of_run = scatter.adjusted(run, jacobian, left);
            own.iter()
                .zip(&of_run)
                .for_each(|(row, left)| adjusted[*row] = *left);
        }
        Some(Runs { scatter, adjusted })
    }

    /// Returns 95 % intervals of the values: from the scatter of runs, or from the wheel angles
    /// alone if that is larger, plus the error of the mean over few sets of angles. NaN for values
    /// that only one run determines.
    fn intervals(
        &self,
        found: &Minimum,
        errors: &[f64],
        runs: Option<&Runs>,
    ) -> Result<Vec<Interval>, Error> {
        let of_angles = match runs {
            Some(_) => self.of_angles(found, errors)?,
            None => None,
        };
        let one = |(axis, value): (usize, &f64)| {
            let Some([error, freedoms]) = runs.and_then(|runs| runs.scatter.error_of(axis)) else {
                return Interval::default();
            };
            let by_runs = Scatter::furthest(freedoms) * error;
            let half = match &of_angles {
                Some([of_runs, of_mean]) => libm::hypot(
                    by_runs.max(NORMAL * of_runs[axis].sqrt()),
                    NORMAL * of_mean[axis].sqrt(),
                ),
                None => by_runs,
            };
            Interval::around(*value, half)
        };
        Ok(found.values.iter().enumerate().map(one).collect())
    }

    /// Returns the variance of each value due to the unknown initial wheel angles of the log's
    /// drives, and to the small number of simulated sets.
    fn of_angles(
        &self,
        found: &Minimum,
        errors: &[f64],
    ) -> Result<Option<[DVector<f64>; 2]>, Error> {
        let Some(made) = self.made(&found.values)? else {
            return Ok(None);
        };
        let deviations = self.deviations(&found.values, &made);
        let Some(inverse) = inverse(&found.jacobian) else {
            return Ok(None);
        };
        if deviations.is_empty() {
            return Ok(None);
        }
        let sets = self.starts.count() as usize;
        let count = found.values.len();
        let mut of_runs = DVector::zeros(count);
        let mut of_drive = vec![DMatrix::zeros(count, sets); self.wanted.len()];
        let mut row = 0;
        for leg in self.fitted {
            let rows = leg.equations();
            let over = DMatrix::from_fn(rows, sets, |at, set| {
                deviations[row + at][set] / errors[row + at]
            });
            let moves = &inverse * found.jacobian.rows(row, rows).transpose() * over;
            of_runs += variances(&moves);
            if let Ok(place) = self.wanted.binary_search(&leg.drive) {
                of_drive[place] += moves;
            }
            row += rows;
        }
        let of_mean: DVector<f64> = of_drive.iter().map(variances).sum();
        Ok(Some([of_runs, of_mean / sets as f64]))
    }

    /// Whether initial wheel angles matter, for a problem that assumes known ones: whether other
    /// angles move some value by more than a small part of its uncertainty. `intervals` are those
    /// found, if known.
    fn matter(&self, found: &Minimum, intervals: Option<&[Interval]>) -> Result<bool, Error> {
        let Some(here) = self.made(&found.values)? else {
            return Ok(true);
        };
        let own = &found.values[..self.free.len()];
        let there = self
            .rig
            .drives(&self.ready(own)?, self.wanted, Starts::Sets(TRIED))?;
        let Some(there) = there.into_iter().collect::<Option<Vec<MeanOverPhases>>>() else {
            return Ok(true);
        };
        let inverse = inverse(&found.jacobian);
        let here = self.rows(&found.values, &here, |together| &together.mean);
        for set in 0..TRIED as usize {
            let there = self.rows(&found.values, &there, |together| &together.each[set]);
            let apart = here.iter().zip(&there);
            let apart = DVector::from_iterator(
                here.len(),
                apart.map(|([here, error], [there, _])| (there - here) / error),
            );
            // If values are not determined, every change matters.
            let Some(inverse) = &inverse else {
                if apart.norm() > MATTERS {
                    return Ok(true);
                }
                continue;
            };
            let moved = inverse * found.jacobian.transpose() * apart;
            for axis in 0..self.free.len() {
                let drawn = intervals.map(|all| 0.5 * (all[axis].high - all[axis].low) / NORMAL);
                let known = inverse[(axis, axis)].sqrt();
                let known = drawn.map_or(known, |drawn| known.min(drawn));
                if moved[axis].abs() > MATTERS * known {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }
}

/// Returns values with a clearly smaller residual than the end of a search, along the range of one
/// key with the others adapted; `None` if there are none.
fn better(found: &Minimum, all: &[LikelihoodProfile], search: &Search) -> Option<Vec<f64>> {
    let least = all.iter().enumerate();
    let least = least.filter_map(|(axis, along)| Some((axis, along.least()?)));
    let (axis, [value, squares]) = least.min_by(|(_, a), (_, b)| a[1].total_cmp(&b[1]))?;
    let is_far = (value - found.values[axis]).abs() > search.differences[axis];
    (is_far && squares < LESS * found.residuals.norm_squared()).then(|| {
        // The search adapts the others.
        let mut values = found.values.clone();
        values[axis] = value;
        values
    })
}

/// Returns values of keys in the scenario's units.
pub(super) fn shown(free: &[Free], seen: &[f64]) -> Vec<f64> {
    let one = |(free, value): (&Free, &f64)| match free.is_log {
        true => libm::exp(*value),
        false => *value,
    };
    free.iter().zip(seen).map(one).collect()
}

/// Returns the variance of deviations about their mean.
fn variance(deviations: &[f64]) -> f64 {
    deviations.iter().map(|by| by * by).sum::<f64>() / (deviations.len() - 1).max(1) as f64
}

/// Returns the variance of each row, whose mean is 0.
fn variances(rows: &DMatrix<f64>) -> DVector<f64> {
    let count = (rows.ncols() - 1).max(1) as f64;
    DVector::from_iterator(
        rows.nrows(),
        rows.row_iter().map(|row| row.norm_squared() / count),
    )
}

/// Returns the inverse of the normal equations; `None` if they do not determine all values.
fn inverse(jacobian: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let inverse = (jacobian.transpose() * jacobian).cholesky()?.inverse();
    inverse
        .iter()
        .all(|entry| entry.is_finite())
        .then_some(inverse)
}

/// Returns the standard error of each value by the errors of its equations.
fn standard_errors(jacobian: &DMatrix<f64>) -> Option<Vec<f64>> {
    let inverse = inverse(jacobian)?;
    Some(inverse.diagonal().iter().map(|own| own.sqrt()).collect())
}
