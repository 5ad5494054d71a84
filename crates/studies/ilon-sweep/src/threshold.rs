//! Finds where a quantity crosses a value along one key.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::axis::{along, rounded};
use crate::file::{Find, Scale};

/// Reversals below this share of the quantity's range are ignored.
const STILL: f64 = 1e-3;

/// Result of a search along a key, at one point of the axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SearchOutcome {
    /// The crossings, by increasing value of the key.
    pub crossings: Vec<Crossing>,
    /// Whether the quantity only rises, or only falls, over the scan.
    pub is_monotonic: bool,
    /// Its smallest value over the scan; `None` if all runs failed.
    pub least: Option<f64>,
    /// Its largest value over the scan.
    pub largest: Option<f64>,
    /// Number of these runs that failed or lacked the quantity.
    pub failed: usize,
}

/// A crossing of the value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Crossing {
    /// The largest tried value of the key below it.
    pub key_below: f64,
    /// The smallest tried value of the key above it.
    pub key_above: f64,
    /// The crossing between them, by linear interpolation.
    pub at: f64,
    /// Whether the quantity rises with the key there.
    pub is_rising: bool,
    /// Whether the bracket has the requested width; a failed run in the bracket ends the search.
    pub is_narrow: bool,
}

impl Find {
    /// Returns the values of the scan.
    pub(crate) fn scanned(&self) -> Vec<f64> {
        let last = f64::from(self.scan.max(2) - 1);
        let at = |index: u32| {
            rounded(along(
                self.from,
                self.to,
                self.scale,
                f64::from(index) / last,
            ))
        };
        (0..self.scan.max(2)).map(at).collect()
    }

    /// Returns the largest number of bisections between two of them.
    pub(crate) fn most_halvings(&self) -> u64 {
        let scanned = self.scanned();
        let widths = scanned.windows(2).map(|pair| pair[1] - pair[0]);
        let widest = widths.fold(0.0, f64::max);
        // On a logarithmic scale the upper half is the wider one.
        let spare = if self.scale == Scale::Log { 4.0 } else { 1.0 };
        (widest / self.tolerance).log2().ceil().max(0.0) as u64 + spare as u64
    }

    /// Returns the number of trials if the quantity crosses its value once.
    pub(crate) fn likely_trials(&self) -> u64 {
        u64::from(self.scan.max(2)) + self.most_halvings()
    }

    /// Returns the largest number of trials.
    pub(crate) fn most_trials(&self) -> u64 {
        let scan = u64::from(self.scan.max(2));
        scan + (scan - 1) * self.most_halvings()
    }

    /// Searches. `quantity` returns the result of a numbered trial at a value of the key; `None` if
    /// it failed. `spare` receives the difference to [`Self::likely_trials`] once that
    /// is known.
    pub(crate) fn search<E: Send>(
        &self,
        spare: &(dyn Fn(i64) + Sync),
        quantity: impl Fn(u64, f64) -> Result<Option<f64>, E> + Sync,
    ) -> Result<SearchOutcome, E> {
        let keys = self.scanned();
        let values: Vec<Option<f64>> = keys
            .par_iter()
            .enumerate()
            .map(|(index, key)| quantity(index as u64, *key))
            .collect::<Result<_, E>>()?;
        let brackets: Vec<usize> = (0..keys.len() - 1)
            .filter(|at| match (values[*at], values[at + 1]) {
                (Some(a), Some(b)) => {
                    // At an end of the range, reaching the value counts as crossing it.
                    let is_reached_first = *at == 0 && a == self.crosses && b != a;
                    let is_reached_last = at + 2 == keys.len() && b == self.crosses && b != a;
                    self.is_beyond(a) != self.is_beyond(b) || is_reached_first || is_reached_last
                }
                _ => false,
            })
            .collect();
        spare((1 - brackets.len() as i64) * self.most_halvings() as i64);
        let crossings = brackets
            .par_iter()
            .filter_map(|&at| {
                let low = (keys[at], values[at]?);
                let high = (keys[at + 1], values[at + 1]?);
                let first = keys.len() as u64 + at as u64 * self.most_halvings();
                Some(self.narrow(low, high, first, spare, &quantity))
            })
            .collect::<Result<_, E>>()?;
        let known: Vec<f64> = values.iter().flatten().copied().collect();
        let least = known.iter().copied().reduce(f64::min);
        let largest = known.iter().copied().reduce(f64::max);
        let range = largest.zip(least).map_or(0.0, |(most, least)| most - least);
        let moves = |sign: f64| {
            let by = |pair: &[f64]| sign * (pair[1] - pair[0]);
            known.windows(2).any(|pair| by(pair) > STILL * range)
        };
        Ok(SearchOutcome {
            crossings,
            is_monotonic: !(moves(1.0) && moves(-1.0)),
            least,
            largest,
            failed: values.len() - known.len(),
        })
    }

    fn is_beyond(&self, quantity: f64) -> bool {
        quantity > self.crosses
    }

    fn narrow<E>(
        &self,
        mut low: (f64, f64),
        mut high: (f64, f64),
        first: u64,
        spare: &(dyn Fn(i64) + Sync),
        quantity: &impl Fn(u64, f64) -> Result<Option<f64>, E>,
    ) -> Result<Crossing, E> {
        let mut halvings = 0;
        for halving in 0..self.most_halvings() {
            if high.0 - low.0 <= self.tolerance {
                break;
            }
            let middle = rounded(along(low.0, high.0, self.scale, 0.5));
            if middle <= low.0 || middle >= high.0 {
                break;
            }
            halvings += 1;
            let Some(value) = quantity(first + halving, middle)? else {
                break;
            };
            // If the value is reached exactly at the lower end, the upper end determines the side.
            let is_low = match low.1 == self.crosses {
                true => self.is_beyond(value) != self.is_beyond(high.1),
                false => self.is_beyond(value) == self.is_beyond(low.1),
            };
            if is_low {
                low = (middle, value);
            } else {
                high = (middle, value);
            }
        }
        spare((self.most_halvings() - halvings) as i64);
        let share = (self.crosses - low.1) / (high.1 - low.1);
        Ok(Crossing {
            key_below: low.0,
            key_above: high.0,
            at: rounded(low.0 + share.clamp(0.0, 1.0) * (high.0 - low.0)),
            is_rising: high.1 > low.1,
            is_narrow: high.0 - low.0 <= self.tolerance,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicI64, Ordering};

    use super::*;

    fn find(from: f64, to: f64, scale: Scale, tolerance: f64) -> Find {
        Find {
            key: "k".to_owned(),
            from,
            to,
            scale,
            quantity: "q".to_owned(),
            crosses: 2.0,
            tolerance,
            scan: 9,
        }
    }

    fn search(find: &Find, f: impl Fn(f64) -> Option<f64> + Sync) -> SearchOutcome {
        let numbers = Mutex::new(Vec::new());
        let spared = AtomicI64::new(0);
        let spare = |trials| {
            spared.fetch_add(trials, Ordering::Relaxed);
        };
        let found = find.search(&spare, |number, x| {
            numbers.lock().unwrap().push(number);
            Ok::<_, Infallible>(f(x))
        });
        let mut numbers = numbers.into_inner().unwrap();
        numbers.sort_unstable();
        let count = numbers.len();
        numbers.dedup();
        assert_eq!(numbers.len(), count, "each trial has a number of its own");
        // The number is known at the end.
        assert_eq!(
            count as i64 + spared.into_inner(),
            find.likely_trials() as i64
        );
        assert!(
            numbers
                .last()
                .is_some_and(|last| *last < find.most_trials())
        );
        found.unwrap()
    }

    #[test_case::test_case(Scale::Linear, 1e-6)]
    #[test_case::test_case(Scale::Log, 1e-6)]
    #[test_case::test_case(Scale::Linear, 10.0)]
    fn a_crossing_is_bracketed_as_narrowly_as_was_asked(scale: Scale, tolerance: f64) {
        // x^2 = 2 at the root of 2.
        let found = search(&find(0.1, 10.0, scale, tolerance), |x| Some(x * x));
        assert!(found.is_monotonic);
        let [crossing] = found.crossings[..] else {
            panic!("{found:?}");
        };
        let root = std::f64::consts::SQRT_2;
        assert!(
            crossing.key_below <= root && root <= crossing.key_above,
            "{crossing:?}"
        );
        assert!(crossing.key_above - crossing.key_below <= tolerance && crossing.is_narrow);
        assert!(crossing.key_below <= crossing.at && crossing.at <= crossing.key_above);
        assert!(crossing.is_rising);
    }

    #[test]
    fn all_crossings_of_a_curve_that_turns_are_found_and_it_is_said() {
        // 4 sin(x) over [0, 3]: beyond 2 between pi/6 and 5 pi/6.
        let found = search(&find(0.0, 3.0, Scale::Linear, 1e-4), |x| {
            Some(4.0 * x.sin())
        });
        assert!(!found.is_monotonic);
        let at: Vec<f64> = found.crossings.iter().map(|crossing| crossing.at).collect();
        let pi = std::f64::consts::PI;
        assert!(
            (at[0] - pi / 6.0).abs() < 1e-4 && (at[1] - 5.0 * pi / 6.0).abs() < 1e-4,
            "{at:?}"
        );
        assert!(found.crossings[0].is_rising && !found.crossings[1].is_rising);
    }

    #[test_case::test_case(|x| x, 2.0; "rising to the last")]
    #[test_case::test_case(|x| 4.0 - x, 2.0; "falling to the last")]
    #[test_case::test_case(|x| 2.0 + x, 0.0; "rising from the first")]
    #[test_case::test_case(|x| 2.0 - x, 0.0; "falling from the first")]
    fn a_value_that_is_reached_at_an_end_is_found_there(f: fn(f64) -> f64, at: f64) {
        let found = search(&find(0.0, 2.0, Scale::Linear, 1e-4), |x| Some(f(x)));
        let [crossing] = found.crossings[..] else {
            panic!("{found:?}");
        };
        assert!(
            (crossing.at - at).abs() <= 1e-4 && crossing.is_narrow,
            "{crossing:?}"
        );
        assert_eq!(crossing.is_rising, f(1.0) > f(0.5));
    }

    #[test]
    fn a_value_that_is_touched_within_the_range_is_not_crossed() {
        let found = search(&find(0.0, 2.0, Scale::Linear, 1e-4), |x| {
            Some(2.0 - (x - 1.0).abs())
        });
        assert_eq!(found.crossings, []);
    }

    #[test]
    fn where_nothing_is_crossed_the_range_of_the_quantity_is_given() {
        let found = search(&find(0.0, 1.0, Scale::Linear, 0.1), Some);
        assert_eq!(
            (found.crossings.len(), found.least, found.largest),
            (0, Some(0.0), Some(1.0))
        );
    }

    #[test]
    fn a_failed_run_is_no_side_of_a_crossing() {
        let f = |x: f64| (x < 3.0).then_some(x);
        let found = search(&find(0.0, 8.0, Scale::Linear, 1e-3), f);
        assert_eq!(found.failed, 6);
        assert!(found.crossings.is_empty());
        // It fails within the bracket: the known part is returned.
        let f = |x: f64| (!(1.4..1.6).contains(&x)).then_some(2.0 * x - 0.5);
        let found = search(&find(0.0, 8.0, Scale::Linear, 1e-3), f);
        assert!(!found.crossings[0].is_narrow);
    }
}
