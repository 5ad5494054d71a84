//! Minimises a quantity with COBYLA, from several starts.

use std::cell::RefCell;

use cobyla::{RhoBeg, StopTols};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::file::Minimise;
use crate::sample::generator;

/// Result of a trial: the quantity, and each bounded quantity; `None` if it failed.
pub(crate) type Trial = Option<(f64, Vec<f64>)>;

/// The minimum of a quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Minimum {
    /// Number of the best trial that keeps the bounds; `None` if there is none.
    pub trial: Option<u64>,
    /// The minimum.
    pub value: Option<f64>,
    /// Its position, as a share of each axis.
    pub place: Vec<f64>,
    /// The best value from each start; `None` if no trial kept the bounds.
    pub by_start: Vec<Option<f64>>,
    /// Number of trials.
    pub trials: u64,
    /// The least and the largest value of each bounded quantity over the trials that ran; empty if
    /// none ran.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bounded: Vec<[f64; 2]>,
}

/// Distance of the first trials from a start, as a share of each axis.
const FIRST_STEP: f64 = 0.25;

/// The margin of a bound at a point, as required by COBYLA.
type Margin<'a> = dyn Fn(&[f64], &mut ()) -> f64 + 'a;

/// Result of one start.
struct Descent {
    tried: Vec<(u64, Vec<f64>, Trial)>,
}

impl Minimise {
    /// Searches over `axes` axes. `trial` returns the result of a numbered trial at a point, given
    /// as a share of each axis. `spare` receives the number of unused trials of
    /// [`Self::most_trials`], once that is known.
    pub(crate) fn search<E: Send>(
        &self,
        axes: usize,
        seed: u32,
        spare: &(dyn Fn(i64) + Sync),
        trial: impl Fn(u64, &[f64]) -> Result<Trial, E> + Sync,
    ) -> Result<Minimum, E> {
        let descents: Vec<Descent> = (0..u64::from(self.starts))
            .into_par_iter()
            .map(|start| self.descend(start, &start_of(start, axes, seed), spare, &trial))
            .collect::<Result<_, E>>()?;
        let best_of = |descent: &Descent| {
            let kept = descent.tried.iter().filter_map(|(number, place, trial)| {
                let (value, bounded) = trial.as_ref()?;
                self.keeps(bounded)
                    .then(|| (*value, *number, place.clone()))
            });
            kept.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
        };
        let bests: Vec<_> = descents.iter().map(best_of).collect();
        let trials = descents
            .iter()
            .map(|descent| descent.tried.len() as u64)
            .sum();
        let ran = descents.iter().flat_map(|descent| &descent.tried);
        let ran: Vec<_> = ran.filter_map(|(_, _, trial)| trial.as_ref()).collect();
        let ranges = (0..self.subject_to.len()).map(|index| {
            let values = ran.iter().map(|(_, bounded)| bounded[index]);
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| {
                [least.min(x), most.max(x)]
            })
        });
        let bounded = match ran.is_empty() {
            true => Vec::new(),
            false => ranges.collect(),
        };
        let by_start = bests
            .iter()
            .map(|best| best.as_ref().map(|best| best.0))
            .collect();
        let best = bests.into_iter().flatten();
        let best = best.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (value, trial, place) = match best {
            Some((value, number, place)) => (Some(value), Some(number), place),
            None => (None, None, Vec::new()),
        };
        Ok(Minimum {
            trial,
            value,
            place,
            by_start,
            trials,
            bounded,
        })
    }

    /// Makes the trials of one start, as [`Self::search`] does for each.
    pub(crate) fn search_from<E: Send>(
        &self,
        start: u64,
        axes: usize,
        seed: u32,
        spare: &(dyn Fn(i64) + Sync),
        trial: impl Fn(u64, &[f64]) -> Result<Trial, E> + Sync,
    ) -> Result<(), E> {
        self.descend(start, &start_of(start, axes, seed), spare, &trial)
            .map(drop)
    }

    /// The largest number of trials.
    pub(crate) fn most_trials(&self) -> u64 {
        u64::from(self.starts) * u64::from(self.evaluations)
    }

    fn keeps(&self, bounded: &[f64]) -> bool {
        let bounds = self.subject_to.values();
        bounds
            .zip(bounded)
            .all(|(bound, value)| bound.bound().holds(*value))
    }

    fn descend<E>(
        &self,
        start: u64,
        from: &[f64],
        spare: &(dyn Fn(i64) + Sync),
        trial: &impl Fn(u64, &[f64]) -> Result<Trial, E>,
    ) -> Result<Descent, E> {
        let first = start * u64::from(self.evaluations);
        let tried: RefCell<Vec<(u64, Vec<f64>, Trial)>> = RefCell::default();
        let stopped: RefCell<Option<E>> = RefCell::default();
        // COBYLA evaluates the objective and each bound one by one, at the same points.
        let at = |place: &[f64]| -> Trial {
            let place: Vec<f64> = place.iter().map(|x| x.clamp(0.0, 1.0)).collect();
            let known = tried
                .borrow()
                .iter()
                .find(|(_, known, _)| *known == place)
                .map(|known| known.2.clone());
            if let Some(known) = known {
                return known;
            }
            let count = tried.borrow().len() as u64;
            if stopped.borrow().is_some() || count >= u64::from(self.evaluations) {
                return None;
            }
            match trial(first + count, &place) {
                Ok(result) => {
                    tried
                        .borrow_mut()
                        .push((first + count, place, result.clone()));
                    result
                }
                Err(error) => {
                    *stopped.borrow_mut() = Some(error);
                    None
                }
            }
        };
        // A failed point is worse than all others.
        let worst = || {
            let tried = tried.borrow();
            let values = tried
                .iter()
                .filter_map(|(_, _, trial)| trial.as_ref().map(|trial| trial.0));
            let (least, largest) =
                values.fold((0.0_f64, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
            2.0 * largest - least + 1.0
        };
        let objective = |place: &[f64], _: &mut ()| at(place).map_or_else(&worst, |trial| trial.0);
        let mut kept: Vec<Box<Margin<'_>>> = Vec::new();
        for (index, bound) in self.subject_to.values().enumerate() {
            let value = move |place: &[f64]| at(place).map(|trial| trial.1[index]);
            if let Some(max) = bound.max {
                kept.push(Box::new(move |place, _| {
                    value(place).map_or(-1.0, |value| scaled(max - value, max))
                }));
            }
            if let Some(min) = bound.min {
                kept.push(Box::new(move |place, _| {
                    value(place).map_or(-1.0, |value| scaled(value - min, min))
                }));
            }
        }
        let kept: Vec<&Margin<'_>> = kept.iter().map(|kept| &**kept as _).collect();
        let tolerances = StopTols {
            xtol_abs: vec![self.tolerance; from.len()],
            ..StopTols::default()
        };
        let bounds = vec![(0.0, 1.0); from.len()];
        let most = self.evaluations as usize;
        // The result is taken from the trials.
        let _ = cobyla::minimize(
            objective,
            from,
            &bounds,
            &kept,
            (),
            most,
            RhoBeg::All(FIRST_STEP),
            Some(tolerances),
        );
        drop(kept);
        spare(i64::from(self.evaluations) - tried.borrow().len() as i64);
        match stopped.take() {
            Some(error) => Err(error),
            None => Ok(Descent {
                tried: tried.take(),
            }),
        }
    }
}

/// Returns the margin of a bound, as a share of it.
fn scaled(margin: f64, bound: f64) -> f64 {
    margin / bound.abs().max(f64::MIN_POSITIVE.sqrt())
}

/// Returns the start of a search: the first in the middle of all axes, the others spread over them.
fn start_of(start: u64, axes: usize, seed: u32) -> Vec<f64> {
    if start == 0 {
        return vec![0.5; axes];
    }
    let mut rng = generator(seed, 5, start);
    (0..axes)
        .map(|axis| match axis {
            0..256 => f64::from(sobol_burley::sample(start as u32 - 1, axis as u32, seed)),
            _ => crate::sample::unit(&mut rng),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::convert::Infallible;
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicI64, Ordering};

    use super::*;
    use crate::file::OneBound;

    fn minimise(bound: Option<OneBound>) -> Minimise {
        Minimise {
            quantity: "q".to_owned(),
            starts: 4,
            evaluations: 120,
            tolerance: 1e-4,
            subject_to: bound
                .map(|bound| ("b".to_owned(), bound))
                .into_iter()
                .collect::<BTreeMap<_, _>>(),
        }
    }

    fn search(minimise: &Minimise, f: impl Fn(&[f64]) -> Trial + Sync) -> Minimum {
        let numbers = Mutex::new(Vec::new());
        let spared = AtomicI64::new(0);
        let spare = |trials| {
            spared.fetch_add(trials, Ordering::Relaxed);
        };
        let found = minimise.search(2, 1, &spare, |number, place| {
            numbers.lock().unwrap().push(number);
            Ok::<_, Infallible>(f(place))
        });
        let mut numbers = numbers.into_inner().unwrap();
        numbers.sort_unstable();
        let count = numbers.len();
        numbers.dedup();
        assert_eq!(numbers.len(), count, "each trial has a number of its own");
        assert_eq!(
            count as i64 + spared.into_inner(),
            minimise.most_trials() as i64
        );
        assert!(
            numbers
                .last()
                .is_some_and(|last| *last < minimise.most_trials())
        );
        found.unwrap()
    }

    #[test]
    fn the_bottom_of_a_bowl_is_found_from_every_start() {
        let bowl = |x: &[f64]| {
            Some((
                (x[0] - 0.3).powi(2) + 4.0 * (x[1] - 0.8).powi(2) + 1.0,
                Vec::new(),
            ))
        };
        let found = search(&minimise(None), bowl);
        // An error d in the position is an error d^2 in the value.
        assert!((found.value.unwrap() - 1.0).abs() < 1e-6, "{found:?}");
        assert!((found.place[0] - 0.3).abs() < 1e-3 && (found.place[1] - 0.8).abs() < 1e-3);
        assert!(
            found
                .by_start
                .iter()
                .all(|best| best.is_some_and(|best| best < 1.001))
        );
    }

    #[test]
    fn a_bound_moves_the_minimum_onto_its_edge() {
        // The minimum of x + y with x y >= 0.25 is at x = y = 1/2.
        let bound = OneBound {
            min: Some(0.25),
            max: None,
        };
        let found = search(&minimise(Some(bound)), |x| {
            Some((x[0] + x[1], vec![x[0] * x[1]]))
        });
        assert!((found.value.unwrap() - 1.0).abs() < 0.01, "{found:?}");
        assert!(found.place[0] * found.place[1] >= 0.25);
    }

    #[test]
    fn places_that_fail_are_avoided_and_bounds_that_nothing_keeps_give_no_minimum() {
        let found = search(&minimise(None), |x| {
            (x[0] > 0.2).then(|| (x[0], Vec::new()))
        });
        assert!(
            found.value.is_some_and(|value| value > 0.2 && value < 0.35),
            "{found:?}"
        );
        let never = OneBound {
            min: Some(2.0),
            max: None,
        };
        let found = search(&minimise(Some(never)), |x| Some((x[0], vec![x[1]])));
        assert_eq!((found.trial, found.value), (None, None));
        let [[least, most]] = found.bounded[..] else {
            panic!("all points ran: {found:?}");
        };
        assert!(0.0 <= least && least < most && most <= 1.0, "{found:?}");
        let found = search(&minimise(Some(never)), |_| None);
        assert_eq!(found.bounded, [[0.0; 2]; 0], "no point ran");
    }

    #[test]
    fn an_error_ends_the_search() {
        let found = minimise(None).search(2, 1, &|_| (), |number, _| {
            if number > 3 { Err("full") } else { Ok(None) }
        });
        assert_eq!(found, Err("full"));
    }
}
