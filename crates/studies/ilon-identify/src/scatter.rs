//! Uncertainty of values from the scatter of runs: cluster-robust errors, with the equations
//! linearised at the best fit.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The normal equations of one cluster: a run, or a window of one.
#[derive(Clone, Debug)]
pub struct Cluster {
    /// J^T J.
    normal: DMatrix<f64>,
    /// J^T r.
    slope: DVector<f64>,
    /// Number of equations.
    pub rows: usize,
}

/// A 95 % interval; NaN if unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
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

impl Interval {
    /// The interval symmetric about a value.
    pub fn around(value: f64, half: f64) -> Self {
        Self {
            low: value - half,
            high: value + half,
        }
    }
}

impl Cluster {
    /// A cluster without equations, for a number of values.
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

/// Covariance of values from the residuals of clusters. The driven motion counts as fixed: a
/// bootstrap over runs ahead and runs sideways would draw some samples without sideways runs, in
/// which the parameters that only these determine are arbitrary.
///
/// With J_i and r_i the rows of cluster i, M = (J^T J)^-1 and H_i = J_i M J_i^T, the value of c . v
/// has the variance sum_i (c . M J_i^T A_i r_i)^2, A_i = (I - H_i)^(-1/2), which is unbiased if the
/// errors are as assumed. The degrees of freedom of Student's t follow from how the clusters share
/// the information: (sum_i l_i)^2 / sum_i l_i^2, l_i the eigenvalues of that quadratic form (Bell
/// and McCaffrey 2002, Pustejovsky and Tipton 2018). For n equally informative clusters this is the
/// interval of a mean, with n - 1.
#[derive(Clone, Debug)]
pub struct Scatter {
    /// L with M = L L^T.
    factor: DMatrix<f64>,
    clusters: Vec<Part>,
    /// Projector on the values that only one cluster determines; their scatter is unknown.
    alone: DMatrix<f64>,
}

/// One cluster, in coordinates in which the sum of all normal matrices is the identity.
#[derive(Clone, Debug)]
struct Part {
    /// L^T J_i^T A_i r_i.
    missed: DVector<f64>,
    /// X_i^T A_i^2 X_i and X_i^T A_i X_i with X_i = J_i L.
    squared: DMatrix<f64>,
    simple: DMatrix<f64>,
    /// A_i r_i = r_i + X_i S X_i^T r_i.
    adjusts: DMatrix<f64>,
}

/// Values that only one cluster determines have an eigenvalue of H_i closer to 1 than this.
const ALONE: f64 = 1e-6;

impl Scatter {
    /// Returns `None` for fewer than two clusters, and if they do not determine all values.
    pub fn new(clusters: &[Cluster]) -> Option<Self> {
        let count = clusters.first().filter(|_| clusters.len() > 1)?.slope.len();
        let mut normal = DMatrix::zeros(count, count);
        if count == 0 {
            return Some(Self {
                factor: normal.clone(),
                clusters: Vec::new(),
                alone: normal,
            });
        }
        clusters.iter().for_each(|own| normal += &own.normal);
        let sizes = normal.diagonal().map(f64::sqrt);
        if sizes.iter().any(|size| !size.is_finite() || *size <= 0.0) {
            return None;
        }
        let alike = DMatrix::from_fn(count, count, |i, j| normal[(i, j)] / (sizes[i] * sizes[j]));
        let alike = SymmetricEigen::new(alike);
        if alike.eigenvalues.min() < 1e-8 {
            return None;
        }
        let mut factor = alike.eigenvectors;
        for (mut column, value) in factor.column_iter_mut().zip(&alike.eigenvalues) {
            column.component_div_assign(&sizes);
            column /= value.sqrt();
        }
        let mut alone = DMatrix::zeros(count, count);
        let part = |own: &Cluster| {
            let missed = factor.tr_mul(&own.slope);
            let normal = factor.tr_mul(&own.normal) * &factor;
            let shares = SymmetricEigen::new(normal.clone());
            let by = |of: &dyn Fn(f64) -> f64| {
                // The fit meets a value that only this cluster determines: no residual is left.
                let values = shares.eigenvalues.map(|share| match share {
                    share if share > 1.0 - ALONE => 0.0,
                    share => of(share.max(0.0)),
                });
                &shares.eigenvectors
                    * DMatrix::from_diagonal(&values)
                    * shares.eigenvectors.transpose()
            };
            for (value, own) in shares
                .eigenvalues
                .iter()
                .zip(shares.eigenvectors.column_iter())
            {
                if *value > 1.0 - ALONE {
                    alone += own * own.transpose();
                }
            }
            Part {
                missed: by(&|share| 1.0 / (1.0 - share).sqrt()) * missed,
                squared: by(&|share| share / (1.0 - share)),
                simple: by(&|share| share / (1.0 - share).sqrt()),
                // (1 / sqrt(1 - share) - 1) / share without cancellation.
                adjusts: by(&|share| {
                    let root = (1.0 - share).sqrt();
                    1.0 / (root * (1.0 + root))
                }),
            }
        };
        let clusters = clusters.iter().map(part).collect();
        Some(Self {
            factor,
            clusters,
            alone,
        })
    }

    /// The number of clusters.
    pub fn count(&self) -> usize {
        self.clusters.len()
    }

    /// Whether some value is determined by one cluster alone.
    pub fn has_alone(&self) -> bool {
        self.alone.norm() > 0.0
    }

    /// Returns the standard error of a quantity with this `gradient` by the values, and its degrees
    /// of freedom; `None` if only one cluster determines it.
    pub fn error(&self, gradient: &DVector<f64>) -> Option<[f64; 2]> {
        let own = self.factor.tr_mul(gradient);
        if (&self.alone * &own).norm() > ALONE.sqrt() * own.norm() {
            return None;
        }
        let mut variance = 0.0;
        let (mut trace, mut squares) = (0.0, 0.0);
        let mut both = DMatrix::zeros(own.len(), own.len());
        for part in &self.clusters {
            variance += own.dot(&part.missed).powi(2);
            let simple = &part.simple * &own;
            let squared = own.dot(&(&part.squared * &own));
            trace += squared - simple.norm_squared();
            // Sum of the squared entries of the form: for each i those of (i, i), less those
            // subtracted from all.
            squares += squared * (squared - 2.0 * simple.norm_squared());
            both.ger(1.0, &simple, &simple, 1.0);
        }
        let freedoms = trace * trace / (squares + both.norm_squared());
        freedoms.is_finite().then(|| [variance.sqrt(), freedoms])
    }

    /// Like [`Self::error`], for one value.
    pub fn error_of(&self, axis: usize) -> Option<[f64; 2]> {
        let count = self.factor.nrows();
        self.error(&DVector::from_fn(count, |row, _| {
            f64::from(u8::from(row == axis))
        }))
    }

    /// Returns the 95 % interval of a function of the values; `of` returns it for a step away from
    /// them. NaN if only one cluster determines it.
    pub fn interval(&self, of: impl Fn(&DVector<f64>) -> f64) -> Interval {
        let count = self.factor.nrows();
        let gradient = DVector::from_fn(count, |axis, _| {
            // A step in proportion to the value's uncertainty, far below the scale of the
            // curvature.
            let by = 1e-3 * self.factor.row(axis).norm();
            let mut step = DVector::zeros(count);
            step[axis] = by;
            (of(&step) - of(&-step)) / (2.0 * by)
        });
        let value = of(&DVector::zeros(count));
        self.error(&gradient)
            .map_or_else(Interval::default, |[error, freedoms]| {
                Interval::around(value, Self::furthest(freedoms) * error)
            })
    }

    /// The 95 % interval of each value.
    pub fn intervals(&self, values: &[f64]) -> Vec<Interval> {
        let one = |(axis, value): (usize, &f64)| self.interval(|step| value + step[axis]);
        values.iter().enumerate().map(one).collect()
    }

    /// Returns the 95 % two-sided quantile of Student's t for a number of degrees of freedom.
    pub fn furthest(freedoms: f64) -> f64 {
        StudentsT::new(0.0, 1.0, freedoms).map_or(1.96, |t| t.inverse_cdf(0.975))
    }

    /// Returns A_i r_i of a cluster, from its rows.
    pub fn adjusted(
        &self,
        cluster: usize,
        jacobian: &DMatrix<f64>,
        residuals: &DVector<f64>,
    ) -> DVector<f64> {
        let rows = jacobian * &self.factor;
        residuals + &rows * (&self.clusters[cluster].adjusts * rows.tr_mul(residuals))
    }
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// Runs of one equation each with the given sensitivity to a value, `noise` off.
    fn runs(tell: &[f64], noise: &mut dyn FnMut() -> f64) -> (Vec<Cluster>, f64) {
        let seen: Vec<f64> = tell.iter().map(|_| noise()).collect();
        let told: f64 = tell.iter().map(|own| own * own).sum();
        // The truth is 0: seen = tell * value + noise.
        let found = tell
            .iter()
            .zip(&seen)
            .map(|(own, seen)| own * seen)
            .sum::<f64>()
            / told;
        let cluster = |(own, seen): (&f64, &f64)| {
            let mut cluster = Cluster::empty(1);
            cluster.add(
                DMatrix::from_element(1, 1, -own),
                DVector::from_element(1, seen - own * found),
            );
            cluster
        };
        (tell.iter().zip(&seen).map(cluster).collect(), found)
    }

    fn normal(seed: u64) -> impl FnMut() -> f64 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        move || StandardNormal.sample(&mut rng)
    }

    /// Equally informative runs: s / sqrt(n) with n - 1 degrees of freedom.
    #[test]
    fn of_runs_that_say_the_same_the_error_is_that_of_the_mean() {
        let mut noise = normal(1);
        let mut seen = Vec::new();
        let (clusters, mean) = runs(&[1.0; 7], &mut || {
            seen.push(noise());
            seen[seen.len() - 1]
        });
        let squares: f64 = seen.iter().map(|own| (own - mean).powi(2)).sum();
        let [error, freedoms] = Scatter::new(&clusters).unwrap().error_of(0).unwrap();
        assert!((error - (squares / 42.0).sqrt()).abs() < 1e-12);
        assert!((freedoms - 6.0).abs() < 1e-9);
    }

    /// A few runs of many determine a value: the interval accounts for how few they are, and holds
    /// the truth in 95 of 100 draws. A bootstrap with samples that lack these runs would make it a
    /// thousand times as wide.
    #[test]
    fn where_few_runs_tell_a_value_the_interval_holds_it_as_often() {
        let mut noise = normal(2);
        // Mean width of Student's interval for the number of informative runs: t sqrt(1 / n).
        for (tell, width) in [
            ([1.0, 1e-3, 1.0, 1e-3, 1e-3, 1e-3], 12.706 * 0.5_f64.sqrt()),
            ([1.0, 1e-3, 1.0, 1e-3, 1.0, 1.0], 3.182 * 0.25_f64.sqrt()),
        ] {
            let (mut held, mut halves) = (0, 0.0);
            for _ in 0..2000 {
                let (clusters, found) = runs(&tell, &mut noise);
                let [error, freedoms] = Scatter::new(&clusters).unwrap().error_of(0).unwrap();
                let half = Scatter::furthest(freedoms) * error;
                held += u32::from(found.abs() <= half);
                halves += half / 2000.0;
            }
            // Three standard deviations of a binomial about 1900.
            assert!((1870..=1930).contains(&held), "{tell:?}: {held}");
            assert!(halves < width, "{tell:?}: {halves}");
        }
    }

    /// The fit meets a value that one run alone determines, so its scatter is unknown; that of the
    /// others is known.
    #[test]
    fn of_what_one_run_tells_no_scatter_is_known() {
        let mut noise = normal(3);
        let rows = [[1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 0.0]];
        let clusters = rows.map(|row| {
            let mut cluster = Cluster::empty(2);
            // The row that determines both is met exactly.
            let left = if row[1] == 1.0 { 0.0 } else { noise() };
            cluster.add(
                DMatrix::from_row_slice(1, 2, &row),
                DVector::from_element(1, left),
            );
            cluster
        });
        let scatter = Scatter::new(&clusters).unwrap();
        assert_eq!(scatter.error_of(1), None);
        let [error, freedoms] = scatter.error_of(0).unwrap();
        assert!(error > 0.0 && (freedoms - 2.0).abs() < 1e-9, "{freedoms}");
    }

    /// Rows that share an error of their run are adjusted together: c . v varies by the sum of
    /// their products with J.
    #[test]
    fn adjusted_rows_make_the_same_of_a_value() {
        let mut noise = normal(4);
        let rows: Vec<(DMatrix<f64>, DVector<f64>)> = (0..5)
            .map(|_| {
                let jacobian = DMatrix::from_fn(3, 2, |_, _| noise());
                (jacobian, DVector::from_fn(3, |_, _| noise()))
            })
            .collect();
        let (mut normal, mut slope) = (DMatrix::zeros(2, 2), DVector::zeros(2));
        for (jacobian, seen) in &rows {
            normal += jacobian.tr_mul(jacobian);
            slope += jacobian.tr_mul(seen);
        }
        let inverse = normal.try_inverse().unwrap();
        let found = &inverse * slope;
        let left: Vec<DVector<f64>> = rows.iter().map(|(j, seen)| seen - j * &found).collect();
        let clusters: Vec<Cluster> = rows
            .iter()
            .zip(&left)
            .map(|((jacobian, _), left)| {
                let mut cluster = Cluster::empty(2);
                cluster.add(jacobian.clone(), left.clone());
                cluster
            })
            .collect();
        let scatter = Scatter::new(&clusters).unwrap();
        let variance: f64 = rows
            .iter()
            .zip(&left)
            .enumerate()
            .map(|(run, ((jacobian, _), left))| {
                // A_i by its definition, from the rows themselves.
                let own = DMatrix::identity(3, 3) - jacobian * &inverse * jacobian.transpose();
                let own = SymmetricEigen::new(own);
                let root = &own.eigenvectors
                    * DMatrix::from_diagonal(&own.eigenvalues.map(|value| 1.0 / value.sqrt()))
                    * own.eigenvectors.transpose();
                let adjusted = scatter.adjusted(run, jacobian, left);
                assert!((&adjusted - root * left).norm() < 1e-9);
                (&inverse * jacobian.tr_mul(&adjusted))[1].powi(2)
            })
            .sum();
        let [error, freedoms] = scatter.error_of(1).unwrap();
        assert!((error - variance.sqrt()).abs() < 1e-12);
        assert!(freedoms > 1.0 && freedoms < 4.0 + 1e-9, "{freedoms}");
    }
}
