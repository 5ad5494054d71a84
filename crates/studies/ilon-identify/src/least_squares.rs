//! Nonlinear least squares within bounds: Gauss-Newton steps with Levenberg-Marquardt damping, and
//! derivatives by finite differences.
//!
//! The published crate for it depends on another release of nalgebra, which would be built and
//! linked in addition.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use ilon_sim::Error;

/// Settings of a search.
#[derive(Clone, Debug)]
pub struct Search {
    /// Step of each value for its derivative.
    pub differences: Vec<f64>,
    /// The smallest and the largest of each value.
    pub bounds: Vec<(f64, f64)>,
    /// Largest number of steps.
    pub steps: u32,
    /// A step that moves each value by less than this share of its difference ends the search.
    pub tolerance: f64,
    /// Initial damping, over the diagonal of the normal equations.
    pub damping: f64,
    /// How often a step is tried with ten times the damping before the search ends: residuals that
    /// are not smooth, as those of a simulation, do not improve with more.
    pub tries: u32,
}

/// Returns the residuals at some values; `None` if they cannot be computed.
pub type Residuals<'r> = dyn Fn(&[f64]) -> Result<Option<Vec<f64>>, Error> + Sync + 'r;

/// The result of a search.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The final values.
    pub values: Vec<f64>,
    /// The residuals, one row per equation.
    pub residuals: DVector<f64>,
    /// Derivative of each residual by each value.
    pub jacobian: DMatrix<f64>,
    /// Whether the search converged before its steps were used up.
    pub has_converged: bool,
    /// Number of evaluations of the residuals.
    pub evaluations: u32,
}

/// Returns values with the smallest sum of squared residuals. `residuals` returns `None` if they
/// cannot be computed, which counts as worse than any.
///
/// # Errors
/// Those of `residuals`, and a start without residuals.
pub fn least_squares(
    residuals: &Residuals<'_>,
    start: &[f64],
    search: &Search,
) -> Result<Minimum, Error> {
    let clamp = |values: &mut [f64]| {
        for (value, (low, high)) in values.iter_mut().zip(&search.bounds) {
            *value = value.clamp(*low, *high);
        }
    };
    let mut values = start.to_vec();
    clamp(&mut values);
    let mut evaluations = 1;
    let Some(at_start) = residuals(&values)? else {
        return Err(Error::invalid(
            "the robot cannot be simulated with the initial values of the search",
            "choose bounds within which the robot can be simulated",
        ));
    };
    let mut left = DVector::from_vec(at_start);
    let mut jacobian = derivatives(residuals, &values, &left, search)?;
    evaluations += 2 * values.len() as u32;
    let mut damping = search.damping;
    let mut has_converged = values.is_empty();
    for _ in 0..search.steps {
        if has_converged {
            break;
        }
        let scaled =
            &jacobian * DMatrix::from_diagonal(&DVector::from_vec(search.differences.clone()));
        let normal = scaled.transpose() * &scaled;
        let slope = scaled.transpose() * &left;
        let largest = normal.diagonal().max().max(f64::MIN_POSITIVE);
        let mut is_better = false;
        for _ in 0..search.tries {
            let mut damped = normal.clone();
            for axis in 0..values.len() {
                damped[(axis, axis)] += damping * normal[(axis, axis)].max(1e-9 * largest);
            }
            let Some(step) = damped.cholesky().map(|factor| factor.solve(&slope)) else {
                damping *= 10.0;
                continue;
            };
            let mut tried: Vec<f64> = values
                .iter()
                .zip(step.iter().zip(&search.differences))
                .map(|(value, (step, difference))| value - step * difference)
                .collect();
            clamp(&mut tried);
            let moved = tried
                .iter()
                .zip(&values)
                .zip(&search.differences)
                .map(|((a, b), difference)| ((a - b) / difference).abs())
                .fold(0.0, f64::max);
            evaluations += 1;
            let found = residuals(&tried)?.map(DVector::from_vec);
            match found {
                Some(found) if found.norm_squared() <= left.norm_squared() => {
                    has_converged = moved <= search.tolerance;
                    values = tried;
                    left = found;
                    damping = (damping * 0.1).max(1e-12);
                    is_better = true;
                    break;
                }
                _ if moved <= search.tolerance => {
                    has_converged = true;
                    break;
                }
                _ => damping *= 10.0,
            }
        }
        if is_better {
            jacobian = derivatives(residuals, &values, &left, search)?;
            evaluations += 2 * values.len() as u32;
        } else {
            has_converged = true;
        }
    }
    Ok(Minimum {
        values,
        residuals: left,
        jacobian,
        has_converged,
        evaluations,
    })
}

/// Returns the derivative of each residual by each value, by central differences, or one-sided ones
/// at a bound; one value per core.
fn derivatives(
    residuals: &Residuals<'_>,
    values: &[f64],
    here: &DVector<f64>,
    search: &Search,
) -> Result<DMatrix<f64>, Error> {
    let column = |axis: usize| -> Result<DVector<f64>, Error> {
        let (low, high) = search.bounds[axis];
        let by = search.differences[axis];
        type Side = (f64, Option<DVector<f64>>);
        let side = |to: f64| -> Result<Side, Error> {
            let mut moved = values.to_vec();
            moved[axis] = to.clamp(low, high);
            if moved[axis] == values[axis] {
                return Ok((values[axis], Some(here.clone())));
            }
            Ok((moved[axis], residuals(&moved)?.map(DVector::from_vec)))
        };
        let (below, above) = rayon::join(|| side(values[axis] - by), || side(values[axis] + by));
        let ((from, below), (to, above)) = (below?, above?);
        // A side on which nothing can be computed is left out.
        let (from, below) = below.map_or((values[axis], here.clone()), |found| (from, found));
        let (to, above) = above.map_or((values[axis], here.clone()), |found| (to, found));
        if to <= from {
            return Ok(DVector::zeros(here.len()));
        }
        Ok((above - below) / (to - from))
    };
    let columns: Vec<DVector<f64>> = (0..values.len())
        .into_par_iter()
        .map(column)
        .collect::<Result<_, _>>()?;
    Ok(match columns.is_empty() {
        true => DMatrix::zeros(here.len(), 0),
        false => DMatrix::from_columns(&columns),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn search(count: usize) -> Search {
        Search {
            differences: vec![1e-4; count],
            bounds: vec![(f64::NEG_INFINITY, f64::INFINITY); count],
            steps: 200,
            tolerance: 1e-6,
            damping: 1e-4,
            tries: 12,
        }
    }

    #[test]
    fn rosenbrocks_valley_is_followed_to_its_end() {
        // Its minimum, 0, is at (1, 1).
        let valley = |x: &[f64]| Ok(Some(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]));
        let found = least_squares(&valley, &[-1.2, 1.0], &search(2)).unwrap();
        assert!(found.has_converged);
        assert!(
            (found.values[0] - 1.0).abs() < 1e-6 && (found.values[1] - 1.0).abs() < 1e-6,
            "{found:?}"
        );
    }

    #[test]
    fn a_bound_is_kept_and_places_without_residuals_are_avoided() {
        let line = |x: &[f64]| Ok((x[0] < 2.5).then(|| vec![x[0] - 3.0, 0.1 * x[1]]));
        let found = least_squares(&line, &[0.0, 5.0], &search(2)).unwrap();
        assert!(found.values[0] < 2.5 && found.values[0] > 2.0, "{found:?}");
        let mut bounded = search(2);
        bounded.bounds[0] = (0.0, 2.0);
        let found = least_squares(&line, &[0.0, 5.0], &bounded).unwrap();
        assert!(
            (found.values[0] - 2.0).abs() < 1e-9 && found.values[1].abs() < 1e-6,
            "{found:?}"
        );
    }
}
