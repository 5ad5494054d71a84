//! Positions of points on the axes, each in [0, 1], as a function of the point's number and the
//! study's seed.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::file::Method;

/// Largest number of points of a Sobol sequence: its scrambling has 16 bits for the number of a
/// point.
pub(crate) const MOST_SOBOL_POINTS: u64 = 1 << 16;

/// Levels of Morris' grid on each axis.
const LEVELS: u64 = 4;

/// Positions of the points of a study on its axes.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    method: Method,
    seed: u32,
    /// Number of points, base points or trajectories.
    points: u64,
    axes: usize,
    /// For a Latin hypercube: the part of each axis for each point.
    parts: Vec<Vec<u32>>,
}

impl Sample {
    /// A number of points by a method other than the grid.
    pub fn new(method: Method, seed: u32, points: u64, axes: usize) -> Self {
        let parts = match method {
            Method::LatinHypercube => (0..axes)
                .map(|axis| shuffled(points as u32, seed, axis as u64))
                .collect(),
            _ => Vec::new(),
        };
        Self {
            method,
            seed,
            points,
            axes,
            parts,
        }
    }

    /// The number of points to run.
    pub fn len(&self) -> u64 {
        self.points * runs_a_point(self.method, self.axes)
    }

    /// Returns the position of a point on each axis.
    pub fn at(&self, point: u64) -> Vec<f64> {
        match self.method {
            Method::Grid | Method::Random => self.random(point),
            Method::LatinHypercube => {
                let inside = self.random(point);
                let part = |axis: usize| f64::from(self.parts[axis][point as usize]);
                let place = |axis: usize| (part(axis) + inside[axis]) / self.points as f64;
                (0..self.axes).map(place).collect()
            }
            Method::Sobol => (0..self.axes).map(|axis| self.sobol(point, axis)).collect(),
            Method::SobolIndices => {
                let (base, which) = (
                    point / (self.axes as u64 + 2),
                    point % (self.axes as u64 + 2),
                );
                // 0 is the point A, 1 the point B, and from 2 on A with one coordinate of B.
                let of_b = |axis: usize| which == 1 || which == axis as u64 + 2;
                let place =
                    |axis: usize| self.sobol(base, axis + if of_b(axis) { self.axes } else { 0 });
                (0..self.axes).map(place).collect()
            }
            Method::Morris => self.morris(
                point / (self.axes as u64 + 1),
                point % (self.axes as u64 + 1),
            ),
        }
    }

    fn random(&self, point: u64) -> Vec<f64> {
        let mut rng = generator(self.seed, 0, point);
        (0..self.axes).map(|_| unit(&mut rng)).collect()
    }

    fn sobol(&self, point: u64, dimension: usize) -> f64 {
        // In the middle of one of 2^24 parts of its 32-bit float, so that 0 and 1 never occur.
        let sample = sobol_burley::sample(point as u32, dimension as u32, self.seed);
        f64::from(sample) + 0.5 / f64::from(1u32 << 24)
    }

    /// Returns a point of a trajectory: after `moved` of the axes, in the trajectory's own order,
    /// have moved by [`morris_step`].
    fn morris(&self, trajectory: u64, moved: u64) -> Vec<f64> {
        let (mut place, moves) = self.trajectory(trajectory);
        for (axis, by) in moves.into_iter().take(moved as usize) {
            place[axis] += by;
        }
        place
    }

    /// Returns the start of a Morris trajectory, and its moves in order: axis and amount.
    fn trajectory(&self, trajectory: u64) -> (Vec<f64>, Vec<(usize, f64)>) {
        let mut rng = generator(self.seed, 1, trajectory);
        let mut order: Vec<usize> = (0..self.axes).collect();
        shuffle(&mut order, &mut rng);
        let up: Vec<bool> = (0..self.axes).map(|_| below(&mut rng, 2) == 0).collect();
        let start = |up: &bool| {
            let level = below(&mut rng, LEVELS / 2) as f64 / (LEVELS - 1) as f64;
            if *up { level } else { level + morris_step() }
        };
        let start = up.iter().map(start).collect();
        let step = |axis: usize| {
            if up[axis] {
                morris_step()
            } else {
                -morris_step()
            }
        };
        let moves = order.into_iter().map(|axis| (axis, step(axis)));
        (start, moves.collect())
    }

    /// Returns the axis that moves after a point of a trajectory, and by how much.
    pub fn morris_move(&self, trajectory: u64, moved: u64) -> (usize, f64) {
        self.trajectory(trajectory).1[moved as usize]
    }
}

/// Returns the number of runs per point of a method.
pub(crate) fn runs_a_point(method: Method, axes: usize) -> u64 {
    match method {
        Method::SobolIndices => axes as u64 + 2,
        Method::Morris => axes as u64 + 1,
        _ => 1,
    }
}

/// Returns the move of an axis in a Morris trajectory: p / (2 (p - 1)) of it, with p levels.
fn morris_step() -> f64 {
    LEVELS as f64 / (2.0 * (LEVELS - 1) as f64)
}

/// Returns a random generator for one purpose and number.
pub(crate) fn generator(seed: u32, purpose: u32, number: u64) -> ChaCha8Rng {
    let mut key = [0; 32];
    key[..4].copy_from_slice(&seed.to_le_bytes());
    key[4..8].copy_from_slice(&purpose.to_le_bytes());
    key[8..16].copy_from_slice(&number.to_le_bytes());
    ChaCha8Rng::from_seed(key)
}

/// Returns a number in (0, 1).
pub(crate) fn unit(rng: &mut ChaCha8Rng) -> f64 {
    ((rng.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64
}

/// Returns an integer below `count`.
pub(crate) fn below(rng: &mut ChaCha8Rng, count: u64) -> u64 {
    (unit(rng) * count as f64) as u64
}

fn shuffle<T>(items: &mut [T], rng: &mut ChaCha8Rng) {
    for last in (1..items.len()).rev() {
        items.swap(last, below(rng, last as u64 + 1) as usize);
    }
}

fn shuffled(count: u32, seed: u32, axis: u64) -> Vec<u32> {
    let mut numbers: Vec<u32> = (0..count).collect();
    shuffle(&mut numbers, &mut generator(seed, 2, axis));
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    const METHODS: [Method; 5] = [
        Method::Random,
        Method::LatinHypercube,
        Method::Sobol,
        Method::SobolIndices,
        Method::Morris,
    ];

    #[test]
    fn every_place_lies_on_its_axis_and_depends_on_its_number_alone() {
        for method in METHODS {
            let sample = Sample::new(method, 7, 32, 3);
            let again = Sample::new(method, 7, 32, 3);
            let other = Sample::new(method, 8, 32, 3);
            let mut differs = false;
            for point in (0..sample.len()).rev() {
                let place = sample.at(point);
                assert!(
                    place.iter().all(|x| (0.0..=1.0).contains(x)),
                    "{method:?} {place:?}"
                );
                assert_eq!(place, again.at(point), "{method:?}");
                differs |= place != other.at(point);
            }
            assert!(differs, "{method:?} with another seed is another sample");
        }
    }

    #[test]
    fn a_latin_hypercube_has_one_point_in_each_part_of_each_axis() {
        let sample = Sample::new(Method::LatinHypercube, 1, 50, 4);
        for axis in 0..4 {
            let mut parts: Vec<usize> = (0..50)
                .map(|point| (50.0 * sample.at(point)[axis]) as usize)
                .collect();
            parts.sort_unstable();
            assert_eq!(parts, (0..50).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_sobol_sequence_has_one_point_in_each_dyadic_box() {
        // A (0, 2)-sequence, scrambled: of its first 16 points one lies in each box of any dyadic
        // division into 16.
        let sample = Sample::new(Method::Sobol, 3, 16, 2);
        for (x_parts, y_parts) in [(16, 1), (8, 2), (4, 4), (2, 8), (1, 16)] {
            let mut boxes: Vec<usize> = (0..16)
                .map(|point| {
                    let place = sample.at(point);
                    let part = |x: f64, parts: usize| (x * parts as f64) as usize;
                    part(place[0], x_parts) * y_parts + part(place[1], y_parts)
                })
                .collect();
            boxes.sort_unstable();
            assert_eq!(boxes, (0..16).collect::<Vec<_>>(), "{x_parts} x {y_parts}");
        }
    }

    #[test]
    fn the_mean_of_a_random_sample_is_that_of_its_distribution() {
        let sample = Sample::new(Method::Random, 5, 10_000, 1);
        let mean = (0..10_000).map(|point| sample.at(point)[0]).sum::<f64>() / 1e4;
        // The standard error is sqrt(1 / 12 / 10000) = 0.0029: four of them.
        assert!((mean - 0.5).abs() < 0.0116, "{mean}");
    }

    #[test]
    fn a_trajectory_moves_one_axis_at_a_time_by_two_thirds() {
        let sample = Sample::new(Method::Morris, 2, 10, 3);
        for trajectory in 0..10 {
            let mut moved = Vec::new();
            for step in 0..3 {
                let (before, after) = (
                    sample.at(4 * trajectory + step),
                    sample.at(4 * trajectory + step + 1),
                );
                let (axis, by) = sample.morris_move(trajectory, step);
                for other in 0..3 {
                    let expected = if other == axis { by } else { 0.0 };
                    assert!((after[other] - before[other] - expected).abs() < 1e-12);
                }
                assert!((by.abs() - 2.0 / 3.0).abs() < 1e-12);
                moved.push(axis);
            }
            moved.sort_unstable();
            assert_eq!(moved, [0, 1, 2]);
        }
    }
}
