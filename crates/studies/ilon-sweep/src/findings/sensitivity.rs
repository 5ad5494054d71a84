//! Variance-based and elementary-effect sensitivity analysis.

use serde::{Deserialize, Serialize};

use crate::sample::{below, generator};

/// Number of bootstrap samples of the base points, for the intervals.
const RESAMPLES: u64 = 500;

/// Sobol indices of one axis: shares of a quantity's variance, each with its 95 % interval.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Indices {
    /// The key of the axis.
    pub key: String,
    /// First-order index: the axis alone.
    pub first: Interval,
    /// Total index: the axis alone and with others.
    pub total: Interval,
}

/// An estimate with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// Elementary effects of one axis: the change of a quantity over the whole axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Effects {
    /// The key of the axis.
    pub key: String,
    /// Number of effects: moves of the axis without failed ends.
    pub moves: u64,
    /// Mean absolute effect, Morris' mu*: how much the axis matters; `None` without effects.
    pub mean_magnitude: Option<f64>,
    /// Mean effect: whether the quantity rises with the axis; `None` without effects.
    pub mean: Option<f64>,
    /// Standard deviation of the effects: interaction with other axes, or curvature; `None` for
    /// fewer than two.
    pub deviation: Option<f64>,
}

/// Returns the Sobol indices of each axis from complete base points: the quantity at A, at B, and
/// at A with one coordinate of B, for each axis. `None` if the quantity does not vary, or for fewer
/// than two base points.
///
/// First order after Saltelli et al., Computer Physics Communications 181 (2010), Table 2 (b);
/// total after Jansen, (f) there.
pub fn sobol_indices(keys: &[String], base: &[Vec<f64>], seed: u32) -> Option<Vec<Indices>> {
    let estimate = |rows: &[&Vec<f64>]| -> Option<Vec<(f64, f64)>> {
        let n = rows.len() as f64;
        let both = rows.iter().flat_map(|row| [row[0], row[1]]);
        let mean = both.clone().sum::<f64>() / (2.0 * n);
        let variance = both.map(|f| (f - mean) * (f - mean)).sum::<f64>() / (2.0 * n);
        if variance.is_nan() || variance <= 1e-24 * mean * mean {
            return None;
        }
        let of_axis = |axis: usize| {
            let first = rows
                .iter()
                .map(|row| (row[1] - mean) * (row[2 + axis] - row[0]));
            let total = rows
                .iter()
                .map(|row| (row[0] - row[2 + axis]) * (row[0] - row[2 + axis]));
            (
                first.sum::<f64>() / n / variance,
                total.sum::<f64>() / (2.0 * n) / variance,
            )
        };
        Some((0..keys.len()).map(of_axis).collect())
    };
    if base.len() < 2 {
        return None;
    }
    let all: Vec<&Vec<f64>> = base.iter().collect();
    let estimated = estimate(&all)?;
    let mut drawn: Vec<Vec<(f64, f64)>> = Vec::new();
    for resample in 0..RESAMPLES {
        let mut rng = generator(seed, 6, resample);
        let rows: Vec<&Vec<f64>> = (0..base.len())
            .map(|_| &base[below(&mut rng, base.len() as u64) as usize])
            .collect();
        drawn.extend(estimate(&rows));
    }
    let interval = |axis: usize, of: fn(&(f64, f64)) -> f64| {
        let mut values: Vec<f64> = drawn.iter().map(|indices| of(&indices[axis])).collect();
        values.sort_by(f64::total_cmp);
        let at =
            |share: f64| values.get((share * (values.len().max(1) - 1) as f64).round() as usize);
        let value = of(&estimated[axis]);
        Interval {
            value,
            low: at(0.025).copied().unwrap_or(value),
            high: at(0.975).copied().unwrap_or(value),
        }
    };
    let of_axis = |(axis, key): (usize, &String)| Indices {
        key: key.clone(),
        first: interval(axis, |indices| indices.0),
        total: interval(axis, |indices| indices.1),
    };
    Some(keys.iter().enumerate().map(of_axis).collect())
}

/// Returns the effects of each axis from moves of one axis each: its index, the share of the axis,
/// and the change of the quantity. Campolongo et al., Environmental Modelling and Software 22
/// (2007), for the absolute effects.
pub fn morris_effects(keys: &[String], moves: &[(usize, f64, f64)]) -> Vec<Effects> {
    let of_axis = |(axis, key): (usize, &String)| {
        let effects = moves
            .iter()
            .filter(|moved| moved.0 == axis)
            .map(|(_, by, change)| change / by);
        let effects: Vec<f64> = effects.collect();
        let n = effects.len() as f64;
        let mean = effects.iter().sum::<f64>() / n;
        let spread = effects
            .iter()
            .map(|effect| (effect - mean) * (effect - mean))
            .sum::<f64>();
        let magnitudes = effects.iter().map(|effect| effect.abs()).sum::<f64>();
        let of_at_least = |count: usize, figure: f64| (effects.len() >= count).then_some(figure);
        Effects {
            key: key.clone(),
            moves: effects.len() as u64,
            mean_magnitude: of_at_least(1, magnitudes / n),
            mean: of_at_least(1, mean),
            deviation: of_at_least(2, (spread / (n - 1.0)).sqrt()),
        }
    };
    keys.iter().enumerate().map(of_axis).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::file::Method;
    use crate::sample::Sample;

    const A: f64 = 7.0;
    const B: f64 = 0.1;

    /// The function of Ishigami and Homma (1990), over [-pi, pi]^3, by shares of that.
    fn ishigami(place: &[f64]) -> f64 {
        let x: Vec<f64> = place.iter().map(|share| PI * (2.0 * share - 1.0)).collect();
        x[0].sin() + A * x[1].sin().powi(2) + B * x[2].powi(4) * x[0].sin()
    }

    fn keys() -> Vec<String> {
        ["x1", "x2", "x3"].map(str::to_owned).to_vec()
    }

    fn base(points: u64, f: impl Fn(&[f64]) -> f64) -> Vec<Vec<f64>> {
        let sample = Sample::new(Method::SobolIndices, 1, points, 3);
        let values: Vec<f64> = (0..sample.len())
            .map(|point| f(&sample.at(point)))
            .collect();
        values.chunks(5).map(<[f64]>::to_vec).collect()
    }

    #[test]
    fn the_indices_of_ishigami_are_those_of_its_integrals() {
        // By integration: V1 = (1 + b pi^4 / 5)^2 / 2, V2 = a^2 / 8, V13 = 8 b^2 pi^8 / 225,
        // V3 = 0.
        let v1 = (1.0 + B * PI.powi(4) / 5.0).powi(2) / 2.0;
        let v2 = A * A / 8.0;
        let v13 = 8.0 * B * B * PI.powi(8) / 225.0;
        let v = v1 + v2 + v13;
        let expected = [(v1 / v, (v1 + v13) / v), (v2 / v, v2 / v), (0.0, v13 / v)];
        let found = sobol_indices(&keys(), &base(8192, ishigami), 1).unwrap();
        for (found, (first, total)) in found.iter().zip(expected) {
            // 8192 points of a Sobol sequence: the error is well below that of as many random ones,
            // 1 / sqrt(8192) = 0.011.
            assert!(
                (found.first.value - first).abs() < 0.01,
                "{found:?} {first}"
            );
            assert!(
                (found.total.value - total).abs() < 0.01,
                "{found:?} {total}"
            );
            assert!(
                found.first.low <= first && first <= found.first.high,
                "{found:?} {first}"
            );
            assert!(
                found.total.low <= total && total <= found.total.high,
                "{found:?} {total}"
            );
        }
    }

    #[test]
    fn what_does_not_vary_has_no_indices() {
        assert_eq!(sobol_indices(&keys(), &base(64, |_| 3.0), 1), None);
        assert_eq!(sobol_indices(&keys(), &base(1, ishigami), 1), None);
    }

    #[test]
    fn the_effects_of_a_plane_are_its_slopes_and_a_product_bends() {
        let sample = Sample::new(Method::Morris, 3, 40, 3);
        let effects = |f: fn(&[f64]) -> f64| {
            let mut moves = Vec::new();
            for trajectory in 0..40 {
                for moved in 0..3 {
                    let (axis, by) = sample.morris_move(trajectory, moved);
                    let at = |moved| f(&sample.at(4 * trajectory + moved));
                    moves.push((axis, by, at(moved + 1) - at(moved)));
                }
            }
            morris_effects(&keys(), &moves)
        };
        let plane = effects(|x| 2.0 * x[0] - 5.0 * x[1]);
        for (effect, slope) in plane.iter().zip([2.0, -5.0, 0.0_f64]) {
            assert!(
                (effect.mean.unwrap() - slope).abs() < 1e-12
                    && (effect.mean_magnitude.unwrap() - slope.abs()).abs() < 1e-12
            );
            assert!(effect.deviation.unwrap() < 1e-12);
        }
        let product = effects(|x| x[0] * x[1]);
        assert!(product[0].deviation.unwrap() > 0.1 && product[2].mean_magnitude == Some(0.0));
        // In Ishigami's function the third axis has no effect of its own, and a large one with the
        // first.
        let ishigami = effects(ishigami);
        assert!(ishigami[2].deviation.unwrap() > ishigami[2].mean.unwrap().abs());
    }

    #[test]
    fn an_axis_of_which_all_moves_failed_has_no_effect_that_is_known() {
        let of = |moves: &[(usize, f64, f64)]| morris_effects(&keys(), moves).remove(0);
        let none = of(&[]);
        assert_eq!(
            (none.moves, none.mean_magnitude, none.mean),
            (0, None, None)
        );
        let one = of(&[(0, 0.5, 1.0)]);
        assert_eq!((one.moves, one.mean, one.deviation), (1, Some(2.0), None));
    }
}
