//! Ground of a roughness class: ISO 8608, "Mechanical vibration - Road surface profiles - Reporting
//! of measured data".
//!
//! | symbol | meaning |
//! |---|---|
//! | n | spatial frequency along a line, in cycles/m; n_0 = 0.1 |
//! | nu | the same of a wave on the ground, in any direction |
//! | G_d(n) | one-sided spectral density of the heights along a line, in m^3: G_d(n_0) (n / n_0)^-2 |
//! | S(nu) | two-sided spectral density of the heights on the ground, in m^4 |
//!
//! The standard describes one track. Isotropic ground on which every line has the density G_d is
//! the field with
//!
//!   S(nu) = G_d(n_0) n_0^2 / (4 nu^3),
//!
//! because the integral of S over the waves across a line, of (n^2 + y^2)^(-3/2), is 2 / n^2. Its
//! waves are between the side of the square and two cells long. White noise on a grid with a power
//! of two of cells per side gets that density wave by wave. All is computed in a fixed order with
//! `libm`, so that a seed gives the same ground on every machine.

use std::f64::consts::TAU;

use nalgebra::Complex;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::noise::noise;

/// n_0, in cycles/m.
const REFERENCE_PER_M: f64 = 0.1;

/// Heights in metres about a mean of 0, on a square of `points` points per side, a cell apart;
/// `density_m3` is G_d(n_0).
pub(crate) fn heights_m(points: usize, cell_m: f64, density_m3: f64, seed: u64) -> Vec<Vec<f64>> {
    let n = points.next_power_of_two().max(2);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut field: Vec<Vec<Complex<f64>>> = (0..n)
        .map(|_| (0..n).map(|_| noise(&mut rng, 1.0).into()).collect())
        .collect();
    transform_both_ways(&mut field, -1.0);
    let side_m = n as f64 * cell_m;
    // The waves of index i and n - i run in opposite directions, and have the same length.
    let per_m = |i: usize| i.min(n - i) as f64 / side_m;
    let (shortest_per_m, n_0) = (0.5 / cell_m, REFERENCE_PER_M);
    for (row, waves) in field.iter_mut().enumerate() {
        for (column, wave) in waves.iter_mut().enumerate() {
            let nu = libm::hypot(per_m(row), per_m(column));
            let density_m4 = if nu > 0.0 && nu <= shortest_per_m {
                density_m3 * n_0 * n_0 / (4.0 * nu * nu * nu)
            } else {
                0.0
            };
            // White noise of variance 1 has the density cell^2; the inverse transform divides by
            // n^2.
            *wave *= density_m4.sqrt() / cell_m / (n * n) as f64;
        }
    }
    transform_both_ways(&mut field, 1.0);
    field.truncate(points);
    let of_row = |row: Vec<Complex<f64>>| row.into_iter().take(points).map(|h| h.re).collect();
    field.into_iter().map(of_row).collect()
}

/// The discrete Fourier transform of a square along its rows and columns, with exp(sign j 2 pi
/// ...), and without a factor.
fn transform_both_ways(field: &mut [Vec<Complex<f64>>], sign: f64) {
    for _ in 0..2 {
        field.iter_mut().for_each(|row| transform(row, sign));
        for i in 0..field.len() {
            let (above, below) = field.split_at_mut(i + 1);
            for (j, row) in below.iter_mut().enumerate() {
                std::mem::swap(&mut above[i][i + 1 + j], &mut row[i]);
            }
        }
    }
}

/// The discrete Fourier transform of a power of two of numbers (Cooley and Tukey 1965).
fn transform(numbers: &mut [Complex<f64>], sign: f64) {
    let n = numbers.len();
    let bits = n.trailing_zeros();
    for i in 0..n {
        let j = i.reverse_bits() >> (usize::BITS - bits);
        if i < j {
            numbers.swap(i, j);
        }
    }
    let mut half = 1;
    while half < n {
        let turns: Vec<Complex<f64>> = (0..half)
            .map(|k| {
                let (sin, cos) = libm::sincos(sign * 0.5 * TAU * k as f64 / half as f64);
                Complex::new(cos, sin)
            })
            .collect();
        for block in numbers.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for ((a, b), turn) in low.iter_mut().zip(high).zip(&turns) {
                let turned = *b * *turn;
                (*a, *b) = (*a + turned, *a - turned);
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ilon_scenario::scenario::RoughnessClass;

    #[test]
    fn the_transform_is_its_sum() {
        let mut numbers: Vec<_> = (0..16_u32)
            .map(|i| Complex::new(f64::from(i * i % 7), f64::from(i % 3)))
            .collect();
        let before = numbers.clone();
        transform(&mut numbers, -1.0);
        for (k, found) in numbers.iter().enumerate() {
            let term = |(i, x): (usize, &Complex<f64>)| {
                x * Complex::from_polar(1.0, -TAU * (i * k) as f64 / 16.0)
            };
            let sum: Complex<f64> = before.iter().enumerate().map(term).sum();
            assert!((found - sum).norm() < 1e-12, "{k}: {found} {sum}");
        }
    }

    /// Periodograms along both axes, relative to the class's line: for each wave number k the mean
    /// over all lines is a sum over the waves across with weights (1 + (y / k)^2)^(-3/2), whose
    /// relative deviation is sqrt(3 pi / 32 / k). The part beyond the shortest wave is missing: 1 -
    /// Y / hypot(n, Y), up to 5 % at a third of it.
    #[test]
    fn lines_along_both_axes_have_the_density_of_the_class() {
        let (points, cell_m) = (256, 0.02);
        let side_m = 256.0 * cell_m;
        let (from, to) = (8, 40);
        let density_m3 = RoughnessClass::C.density_m3();
        let variance: f64 = (from..=to)
            .map(|k| 3.0 * std::f64::consts::PI / 32.0 / f64::from(k))
            .sum();
        let count = f64::from(to - from + 1);
        for seed in 1..=3 {
            let heights = heights_m(points, cell_m, density_m3, seed);
            let columns: Vec<Vec<f64>> = (0..points)
                .map(|column| heights.iter().map(|row| row[column]).collect())
                .collect();
            for (axis, lines) in [("x", &heights), ("y", &columns)] {
                let mut ratio = 0.0;
                for line in lines {
                    let mut waves: Vec<_> = line.iter().map(|&z| Complex::from(z)).collect();
                    transform(&mut waves, -1.0);
                    for k in from..=to {
                        // One-sided: both signs of k.
                        let one = waves[k as usize].norm_sqr();
                        let found_m3 = 2.0 * one * cell_m / points as f64;
                        let n = f64::from(k) / side_m;
                        let class_m3 = density_m3 * (REFERENCE_PER_M / n).powi(2);
                        ratio += found_m3 / class_m3 / (count * points as f64);
                    }
                }
                let missing: f64 = (from..=to)
                    .map(|k| 1.0 - 128.0 / f64::hypot(128.0, f64::from(k)))
                    .sum::<f64>()
                    / count;
                let sure = 4.0 * variance.sqrt() / count;
                assert!(
                    (ratio - (1.0 - missing)).abs() < sure,
                    "seed {seed} along {axis}: {ratio}, {sure}"
                );
            }
        }
    }

    /// Root mean square of a field between its longest and shortest waves: integral of 2 pi nu S is
    /// pi G n_0^2 / 2 (1 / nu_1 - 1 / nu_2).
    #[test]
    fn each_class_is_twice_as_high_as_the_one_before() {
        use RoughnessClass::{A, B, C, H};
        let of = |class: RoughnessClass| heights_m(40, 0.05, class.density_m3(), 7);
        let (b, c) = (of(B), of(C));
        for (b, c) in b.iter().flatten().zip(c.iter().flatten()) {
            assert!((c - 2.0 * b).abs() < 1e-12, "{b} {c}");
        }
        assert_eq!((b.len(), b[0].len()), (40, 40));
        assert_eq!(b, of(B));
        assert_eq!(A.density_m3(), 16e-6);
        // Table C.1: 262144e-6 m^3.
        assert!((H.density_m3() - 262_144e-6).abs() < 1e-12);
    }
}
