//! Values of the free keys at which simulated drives are nearest to those of the logs, and how sure they are.
//!
//! A drive begins at angles phi of its rollers that no log says. What it makes is y = f(v, phi) + e of the values v, so that its mean over phi
//! is what is compared, and the variance over phi is an error of the drive beside e: both are taken from drives that are simulated from several
//! sets of angles. The variance follows v; it is held while values are searched and taken anew where they were found, as a search that could
//! make it larger would.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

use ilon_sim::Error;
use nalgebra::{DMatrix, DVector, Matrix3xX};
use rayon::prelude::*;

use super::compared::Scales;
use super::drive::{self, Made, Ready, Task, Together, made};
use super::free::Free;
use super::legs::{Course, Leg};
use super::starts::Starts;
use crate::least_squares::{Found, Search, least_squares};
use crate::resample::{Cluster, Draws, Interval};
use crate::study::{Simulate, Study};

/// How often the variance over wheel angles is taken anew at most.
const ROUNDS: usize = 2;
/// Values that move by less than this many standard errors end that.
const SETTLED: f64 = 0.2;
/// From so many sets of wheel angles it is tried whether they matter.
const TRIED: u32 = 2;
/// They do where they move a value by this share of its standard error: an interval of 95 % that is off by as much holds the truth in 94 %.
const MATTERS: f64 = 0.3;

/// What drives are simulated with.
pub(super) struct Rig<'a> {
    pub study: &'a Study,
    pub section: &'a Simulate,
    pub courses: &'a [Course],
    pub nominal: &'a Matrix3xX<f64>,
    pub count: &'a (dyn Fn(u32) + Sync),
    pub simulated: AtomicU32,
}

impl Rig<'_> {
    /// What some drives make of a robot; `None` of one that leaves all numbers.
    pub fn drives(
        &self,
        ready: &Ready,
        which: &[usize],
        starts: Starts,
    ) -> Result<Vec<Option<Together>>, Error> {
        let sets = starts.count();
        let tasks: Vec<Task> = which
            .iter()
            .flat_map(|drive| (0..sets).map(|set| (*drive, set)))
            .map(|(drive, set)| Task { drive, starts, set })
            .collect();
        let one = |task: &Task| {
            let course = &self.courses[task.drive];
            let made = made(self.section, ready, course, *task, self.nominal);
            (self.count)(self.simulated.fetch_add(1, Ordering::Relaxed) + 1);
            made
        };
        let all: Result<Vec<Option<Made>>, Error> = tasks.par_iter().map(one).collect();
        let all = all?;
        Ok(all.chunks(sets as usize).map(Together::new).collect())
    }
}

/// What is fitted: values as the search sees them are those of the free keys, and the scale of each series last.
pub(super) struct Problem<'a> {
    pub rig: &'a Rig<'a>,
    pub free: &'a [Free],
    pub scales: &'a Scales,
    pub fitted: &'a [&'a Leg],
    /// The drives that stand for them, in order.
    pub wanted: &'a [usize],
    pub starts: Starts,
    /// What was simulated is kept: where only a scale or an error changes, nothing moves otherwise.
    kept: Mutex<Vec<Simulated>>,
}

/// What drives made at some values of the keys.
type Simulated = (Vec<f64>, Vec<Option<Together>>);

/// Values that were found, and what follows from them.
pub(super) struct Fitted {
    pub found: Found,
    pub intervals: Vec<Interval>,
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

    /// What the drives make at some values; `None` where one of them cannot be.
    fn made(&self, seen: &[f64]) -> Result<Option<Vec<Together>>, Error> {
        let own = &seen[..self.free.len()];
        let known = {
            let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            let known = kept.iter().find(|(values, _)| *values == own);
            known.map(|(_, made)| made.clone())
        };
        let made = match known {
            Some(made) => made,
            None => {
                // Each key by itself can have what its range holds; together they may ask for a robot that cannot be.
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

    /// The robot at some values of the keys.
    fn ready(&self, own: &[f64]) -> Result<Ready, Error> {
        let keys = drive::keys(self.rig.study, self.free, &shown(self.free, own), &[]);
        Ready::new(self.rig.study, &keys)
    }

    /// Differences of measured and simulated with the errors of the log, a row an equation, by what `of` takes of each drive.
    fn rows(
        &self,
        seen: &[f64],
        made: &[Together],
        of: impl Fn(&Together) -> &Made,
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

    /// By how much each equation is off from its mean in each of the sets of wheel angles; none of one set.
    fn deviations(&self, seen: &[f64], made: &[Together]) -> Vec<Vec<f64>> {
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

    /// The error of each equation: that of the log, and what it scatters by over wheel angles.
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

    /// Searches values, weighing equations by their errors.
    pub fn fit(&self, start: &[f64], search: &Search) -> Result<Fitted, Error> {
        let mut values = start.to_vec();
        let mut round = 0;
        loop {
            // A start that cannot be simulated is named by the search.
            let errors = self.errors(&values)?.unwrap_or_default();
            let residuals = |seen: &[f64]| -> Result<Option<Vec<f64>>, Error> {
                Ok(self.made(seen)?.map(|made| {
                    let rows = self.rows(seen, &made, |together| &together.mean);
                    let over = |([left, own], error): ([f64; 2], Option<&f64>)| {
                        left / error.copied().unwrap_or(own)
                    };
                    let places = (0..rows.len()).map(|row| errors.get(row));
                    rows.iter().copied().zip(places).map(over).collect()
                }))
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
                let intervals = self.intervals(&found, &errors)?;
                return Ok(Fitted { found, intervals });
            }
        }
    }

    /// The fit of a problem in which wheels begin at known angles; `None` where it matters at which, where the search begins or where it ends.
    pub fn fit_unless_angles_matter(
        &self,
        start: &[f64],
        search: &Search,
    ) -> Result<Option<Fitted>, Error> {
        let residuals = |seen: &[f64]| -> Result<Option<Vec<f64>>, Error> {
            Ok(self.made(seen)?.map(|made| {
                let rows = self.rows(seen, &made, |together| &together.mean);
                rows.iter().map(|[left, error]| left / error).collect()
            }))
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
        let do_matter = self.matter(&fit.found, Some(&fit.intervals))?;
        Ok((!do_matter).then_some(fit))
    }

    /// Where values lie with 95 %: by how runs scatter, or by what wheel angles alone make of it where that is more, and by what so few sets of
    /// angles leave of the mean.
    fn intervals(&self, found: &Found, errors: &[f64]) -> Result<Vec<Interval>, Error> {
        let runs = self.fitted.iter().map(|leg| leg.run + 1).max().unwrap_or(0);
        let mut clusters = vec![Cluster::empty(found.values.len()); runs];
        let mut row = 0;
        for leg in self.fitted {
            let rows = leg.equations();
            clusters[leg.run].add(
                found.jacobian.rows(row, rows).clone_owned(),
                found.residuals.rows(row, rows).clone_owned(),
            );
            row += rows;
        }
        clusters.retain(|cluster| cluster.rows > 0);
        let file = &self.rig.study.file;
        let draws = Draws::new(&clusters, file.resamples, file.seed);
        let mut intervals = draws.intervals(&found.values);
        let Some([of_runs, of_mean]) = self.of_angles(found, errors)? else {
            return Ok(intervals);
        };
        for (axis, interval) in intervals.iter_mut().enumerate() {
            let value = found.values[axis];
            let drawn = interval.high - value;
            // No number stays none.
            if drawn.is_finite() {
                let own = NORMAL * of_runs[axis].sqrt();
                let half = libm::hypot(drawn.max(own), NORMAL * of_mean[axis].sqrt());
                (interval.low, interval.high) = (value - half, value + half);
            }
        }
        Ok(intervals)
    }

    /// The variance of each value by the wheel angles at which the log's drives began, and by how few sets of them were simulated.
    fn of_angles(&self, found: &Found, errors: &[f64]) -> Result<Option<[DVector<f64>; 2]>, Error> {
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

    /// Whether it matters for some value at which angles wheels begin, of a problem in which they begin at known ones: whether drives from other
    /// angles move it by more than a small part of what it is known to. `intervals` are those found, where they are.
    fn matter(&self, found: &Found, intervals: Option<&[Interval]>) -> Result<bool, Error> {
        let Some(here) = self.made(&found.values)? else {
            return Ok(true);
        };
        let own = &found.values[..self.free.len()];
        let there = self
            .rig
            .drives(&self.ready(own)?, self.wanted, Starts::Sets(TRIED))?;
        let Some(there) = there.into_iter().collect::<Option<Vec<Together>>>() else {
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
            // Where values are not determined, all that changes matters.
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

/// Half of the interval of 95 % of a normal distribution, over its standard deviation.
const NORMAL: f64 = 1.96;

/// Values of keys as a scenario has them.
pub(super) fn shown(free: &[Free], seen: &[f64]) -> Vec<f64> {
    let one = |(free, value): (&Free, &f64)| match free.is_log {
        true => libm::exp(*value),
        false => *value,
    };
    free.iter().zip(seen).map(one).collect()
}

/// The variance of deviations from their mean.
fn variance(deviations: &[f64]) -> f64 {
    deviations.iter().map(|by| by * by).sum::<f64>() / (deviations.len() - 1).max(1) as f64
}

/// The variance of each row, whose mean is 0.
fn variances(rows: &DMatrix<f64>) -> DVector<f64> {
    let count = (rows.ncols() - 1).max(1) as f64;
    DVector::from_iterator(
        rows.nrows(),
        rows.row_iter().map(|row| row.norm_squared() / count),
    )
}

/// The inverse of the normal equations; `None` where they do not determine all values.
fn inverse(jacobian: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let inverse = (jacobian.transpose() * jacobian).cholesky()?.inverse();
    inverse
        .iter()
        .all(|entry| entry.is_finite())
        .then_some(inverse)
}

/// The standard error of each value by the errors of its equations.
fn standard_errors(jacobian: &DMatrix<f64>) -> Option<Vec<f64>> {
    let inverse = inverse(jacobian)?;
    Some(inverse.diagonal().iter().map(|own| own.sqrt()).collect())
}
