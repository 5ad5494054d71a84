//! Intervals by resampling runs: the bootstrap over clusters, on the equations as they are at the best fit.

use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The normal equations of what is drawn as one: a run, or a stretch of one.
#[derive(Clone, Debug)]
pub struct Cluster {
    /// J^T J.
    normal: DMatrix<f64>,
    /// J^T r.
    slope: DVector<f64>,
    /// How many equations it holds.
    pub rows: usize,
}

/// Where a value lies with 95 %; no numbers where that is not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// From here.
    pub low: f64,
    /// To here.
    pub high: f64,
}

impl Default for Interval {
    fn default() -> Self {
        Self {
            low: f64::NAN,
            high: f64::NAN,
        }
    }
}

impl Cluster {
    /// One without equations, of so many values.
    pub fn empty(values: usize) -> Self {
        Self {
            normal: DMatrix::zeros(values, values),
            slope: DVector::zeros(values),
            rows: 0,
        }
    }

    /// Adds rows of the Jacobian with their residuals.
    pub fn add(&mut self, jacobian: DMatrix<f64>, residuals: DVector<f64>) {
        self.normal += jacobian.transpose() * &jacobian;
        self.slope += jacobian.transpose() * &residuals;
        self.rows += residuals.len();
    }
}

/// The step from the best fit of all to the best fit of a draw, which holds each cluster so many times.
fn step(clusters: &[Cluster], times: &[f64]) -> Option<DVector<f64>> {
    let count = clusters.first()?.slope.len();
    let (mut normal, mut slope) = (DMatrix::zeros(count, count), DVector::zeros(count));
    for (cluster, times) in clusters.iter().zip(times) {
        normal += &cluster.normal * *times;
        slope += &cluster.slope * *times;
    }
    let sizes: Vec<f64> = normal
        .diagonal()
        .iter()
        .map(|size: &f64| size.sqrt())
        .collect();
    if sizes.iter().any(|size| !size.is_finite() || *size <= 0.0) {
        return None;
    }
    let alike = DMatrix::from_fn(count, count, |i, j| normal[(i, j)] / (sizes[i] * sizes[j]));
    let scaled = DVector::from_fn(count, |i, _| slope[i] / sizes[i]);
    let factor = alike.cholesky()?;
    // What is left of a row after those before it: nothing where a draw has lost what tells two values apart.
    let left = factor.l_dirty().diagonal().min();
    if left < 1e-4 {
        return None;
    }
    let solved = factor.solve(&scaled);
    Some(DVector::from_fn(count, |i, _| -solved[i] / sizes[i]))
}

/// Whether all values are still determined without any one of the clusters.
pub fn survives(clusters: &[Cluster]) -> bool {
    (0..clusters.len()).all(|left_out| {
        let times: Vec<f64> = (0..clusters.len())
            .map(|cluster| if cluster == left_out { 0.0 } else { 1.0 })
            .collect();
        step(clusters, &times).is_some()
    })
}

/// What fits to resamples give beside the fit to all.
#[derive(Clone, Debug, Default)]
pub struct Draws {
    steps: Vec<DVector<f64>>,
    /// How many clusters were drawn from.
    pub clusters: usize,
    is_enough: bool,
}

impl Draws {
    /// So many resamples: each holds as many clusters as there are, each as often as chance has it.
    pub fn new(clusters: &[Cluster], count: u32, seed: u32) -> Self {
        let n = clusters.len();
        let mut steps: Vec<DVector<f64>> = Vec::with_capacity(count as usize);
        if n >= 2 {
            let mut rng = ChaCha8Rng::seed_from_u64(u64::from(seed));
            // A draw that has lost what a value needs is drawn again.
            for _ in 0..2 * count {
                if steps.len() == count as usize {
                    break;
                }
                let mut times = vec![0.0; n];
                for _ in 0..n {
                    times[(rng.next_u64() % n as u64) as usize] += 1.0;
                }
                steps.extend(step(clusters, &times));
            }
        }
        Self {
            is_enough: n >= 2 && steps.len() == count as usize,
            steps,
            clusters: n,
        }
    }

    /// The 95 % interval of something that follows from the values; `of` gives it for a step away from them. The spread over draws is
    /// that of the estimate; few clusters make it too small by sqrt((n - 1) / n), and their own scatter uncertain, which Student's t
    /// counts in.
    pub fn interval(&self, value: f64, of: impl Fn(&DVector<f64>) -> f64) -> Interval {
        if !self.is_enough {
            return Interval::default();
        }
        let drawn: Vec<f64> = self.steps.iter().map(of).collect();
        let mean = drawn.iter().sum::<f64>() / drawn.len() as f64;
        let squares: f64 = drawn.iter().map(|drawn| (drawn - mean).powi(2)).sum();
        let deviation = (squares / (drawn.len() - 1) as f64).sqrt();
        let n = self.clusters as f64;
        let t = StudentsT::new(0.0, 1.0, n - 1.0).map_or(1.96, |t| t.inverse_cdf(0.975));
        let half = t * (n / (n - 1.0)).sqrt() * deviation;
        Interval {
            low: value - half,
            high: value + half,
        }
    }

    /// The 95 % interval of each value.
    pub fn intervals(&self, values: &[f64]) -> Vec<Interval> {
        let one = |(axis, value): (usize, &f64)| self.interval(*value, |step| step[axis]);
        values.iter().enumerate().map(one).collect()
    }
}
