//! Fits models of the kinematics to the displacements of runs, with the uncertainty of each
//! parameter.

use ilon_sim::Error;
use nalgebra::{DMatrix, DVector, Matrix3xX, SymmetricEigen};

use crate::least_squares::{Search, least_squares};
use crate::log::middle;
use crate::model::{Model, Parameter, is_held};
use crate::motion::{Tracker, Window};
use crate::scatter::{Cluster, Interval, Scatter};

/// Measurement noise of displacements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of a displacement along one axis, in metres.
    pub position_m: f64,
    /// Standard deviation of a change of heading, in radians.
    pub heading_rad: f64,
}

/// The runs of a study as input of a fit.
#[derive(Clone, Debug, Default)]
pub struct Evidence {
    /// All windows of all runs.
    pub windows: Vec<Window>,
    /// The series of each run.
    pub series: Vec<String>,
    /// Whether each run is held out.
    pub held_out: Vec<bool>,
}

impl Evidence {
    /// Takes the windows of runs of one series, none of which is held out.
    pub fn of(runs: impl IntoIterator<Item = Vec<Window>>) -> Self {
        let mut evidence = Self::default();
        for windows in runs {
            evidence.windows.extend(windows);
            evidence.series.push(String::new());
            evidence.held_out.push(false);
        }
        evidence
    }

    /// Returns the names of the series of windows, each once.
    pub fn series_of(&self, windows: &[&Window]) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for window in windows {
            let series = &self.series[window.run];
            if !names.contains(series) {
                names.push(series.clone());
            }
        }
        names
    }

    /// Returns all windows.
    pub fn all(&self) -> Vec<&Window> {
        self.windows.iter().collect()
    }

    /// Returns the windows of a series.
    pub fn of_series(&self, series: &str) -> Vec<&Window> {
        self.some(|window| self.series[window.run] == series)
    }

    /// Returns the windows that satisfy a predicate.
    pub fn some(&self, of: impl Fn(&Window) -> bool) -> Vec<&Window> {
        self.windows.iter().filter(|window| of(window)).collect()
    }

    /// Returns the windows to which models are fitted.
    pub fn fitted(&self) -> Vec<&Window> {
        self.some(|window| !self.held_out[window.run])
    }

    /// Returns the held-out windows.
    pub fn kept_back(&self) -> Vec<&Window> {
        self.some(|window| self.held_out[window.run])
    }
}

/// A fitted model.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The model, with the parameters that could be determined.
    pub model: Model,
    /// The value of each of its parameters.
    pub values: Vec<f64>,
    /// Scatter of runs, or of windows, about it; `None` if unknown.
    pub scatter: Option<Scatter>,
    /// Parameters that the log could not determine and that were held, each with a sentence on the
    /// reason and a remedy.
    pub held: Vec<(Parameter, String)>,
    /// Whether the scatter is that of whole runs instead of windows.
    pub over_runs: bool,
}

impl Fitted {
    /// Returns the 95 % interval of each value; NaN if unknown.
    pub fn intervals(&self) -> Vec<Interval> {
        match &self.scatter {
            Some(scatter) => scatter.intervals(&self.values),
            None => vec![Interval::default(); self.values.len()],
        }
    }
}

/// A window that misses the most general linear model by this many standard deviations is an
/// outlier.
const OUTLIER: f64 = 8.0;

/// Estimates the noise as the deviation of all windows from the best fit of three free rows, which
/// is independent of the robot. Removes windows that deviate much more and returns their number.
pub fn take_noise(evidence: &mut Evidence) -> (Noise, usize) {
    let before = evidence.windows.len();
    let mut noise = Noise {
        position_m: 1e-3,
        heading_rad: 1e-3,
    };
    for _ in 0..4 {
        let left = free_residuals(evidence);
        let mut along: Vec<f64> = left.iter().flat_map(|r| [r[0].abs(), r[1].abs()]).collect();
        let mut turn: Vec<f64> = left.iter().map(|r| r[2].abs()).collect();
        // 1.4826 times the median of absolute values is the standard deviation of normal noise.
        noise = Noise {
            position_m: (1.4826 * middle(&mut along)).max(1e-7),
            heading_rad: (1.4826 * middle(&mut turn)).max(1e-7),
        };
        let is_near = |r: [f64; 3]| {
            r[0].abs().max(r[1].abs()) <= OUTLIER * noise.position_m.max(1e-6)
                && r[2].abs() <= OUTLIER * noise.heading_rad.max(1e-6)
        };
        let usual = usual_of_runs(evidence, &left);
        let is_kept = |(window, r): (&Window, &[f64; 3])| {
            let usual = usual[window.run];
            is_near(*r) || is_near(std::array::from_fn(|axis| r[axis] - usual[axis]))
        };
        let kept: Vec<bool> = evidence.windows.iter().zip(&left).map(is_kept).collect();
        let mut kept = kept.into_iter();
        let count = evidence.windows.len();
        evidence.windows.retain(|_| kept.next().unwrap_or(true));
        if evidence.windows.len() == count {
            break;
        }
    }
    (noise, before - evidence.windows.len())
}

/// Returns the median residual of the windows of each run: a residual common to a whole run is not
/// the fault of single windows, but of the map, as on a floor with creep.
fn usual_of_runs(evidence: &Evidence, left: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let runs = evidence.windows.iter().map(|window| window.run + 1).max();
    (0..runs.unwrap_or(0))
        .map(|run| {
            let of_run = evidence.windows.iter().zip(left);
            let of_run: Vec<&[f64; 3]> = of_run
                .filter(|(window, _)| window.run == run)
                .map(|(_, missed)| missed)
                .collect();
            std::array::from_fn(|axis| {
                let mut missed: Vec<f64> = of_run.iter().map(|r| r[axis]).collect();
                middle(&mut missed)
            })
        })
        .collect()
}

/// Returns the residual of each window from the best map from wheel steps to displacements, with
/// all entries of the map free and a separate tracked point for each series.
fn free_residuals(evidence: &Evidence) -> Vec<[f64; 3]> {
    let windows = &evidence.windows;
    let wheels = windows.first().map_or(0, |window| window.turned_rad.len());
    let series = evidence.series_of(&evidence.all());
    let of = |run: usize| series.iter().position(|name| *name == evidence.series[run]);
    let width = 2 * wheels + 2 * series.len();
    let mut planar = DMatrix::zeros(2 * windows.len(), width);
    let mut planar_seen = DVector::zeros(2 * windows.len());
    let mut turn = DMatrix::zeros(windows.len(), wheels);
    let mut turn_seen = DVector::zeros(windows.len());
    for (row, window) in windows.iter().enumerate() {
        for wheel in 0..wheels {
            let (cos, sin) = (window.cos_rad[wheel], window.sin_rad[wheel]);
            planar[(2 * row, wheel)] = cos;
            planar[(2 * row, wheels + wheel)] = -sin;
            planar[(2 * row + 1, wheel)] = sin;
            planar[(2 * row + 1, wheels + wheel)] = cos;
            turn[(row, wheel)] = window.turned_rad[wheel];
        }
        let lever = 2.0 * libm::sin(0.5 * window.seen[2]);
        let place = 2 * wheels + 2 * of(window.run).unwrap_or(0);
        planar[(2 * row, place + 1)] = -lever;
        planar[(2 * row + 1, place)] = lever;
        planar_seen[2 * row] = window.seen[0];
        planar_seen[2 * row + 1] = window.seen[1];
        turn_seen[row] = window.seen[2];
    }
    let planar_left = &planar_seen - &planar * solve(&planar, &planar_seen);
    let turn_left = &turn_seen - &turn * solve(&turn, &turn_seen);
    (0..windows.len())
        .map(|row| {
            [
                planar_left[2 * row],
                planar_left[2 * row + 1],
                turn_left[row],
            ]
        })
        .collect()
}

/// Solves by least squares; the shortest of several solutions.
pub(crate) fn solve(matrix: &DMatrix<f64>, seen: &DVector<f64>) -> DVector<f64> {
    let normal = SymmetricEigen::new(matrix.transpose() * matrix);
    let slope = matrix.transpose() * seen;
    let largest = normal.eigenvalues.amax().max(f64::MIN_POSITIVE);
    let mut solution = DVector::zeros(matrix.ncols());
    for (value, vector) in normal
        .eigenvalues
        .iter()
        .zip(normal.eigenvectors.column_iter())
    {
        if *value > 1e-12 * largest {
            solution += vector * (vector.dot(&slope) / value);
        }
    }
    solution
}

/// Returns the residuals of windows from a model, over the noise, equally many rows per window:
/// three of the pose, and of a robot with steered wheels by what its wheels contradict each other,
/// which shows a module that stands otherwise than its neighbours.
pub fn residuals(
    model: &Model,
    values: &[f64],
    windows: &[&Window],
    evidence: &Evidence,
    noise: Noise,
) -> Option<Vec<f64>> {
    let matrix = model.twist_matrix(values)?;
    let trackers: Vec<Tracker> = evidence
        .series
        .iter()
        .map(|series| model.tracker(values, series))
        .collect();
    let left = misses(&matrix, &trackers, windows, noise);
    let Some(apart) = model.contradiction(values) else {
        return Some(left);
    };
    let poses = left.chunks_exact(3).zip(windows);
    let with_wheels = poses.flat_map(|(pose, window)| {
        let turned = DVector::from_column_slice(&window.turned_rad);
        let apart = (&apart * turned) / noise.position_m;
        pose.iter().copied().chain(apart.data.as_vec().clone())
    });
    Some(with_wheels.collect())
}

/// Returns the residuals of windows from a map from wheel rates to twists, over the noise, three
/// rows per window; `trackers` has one entry per run.
pub fn misses(
    matrix: &Matrix3xX<f64>,
    trackers: &[Tracker],
    windows: &[&Window],
    noise: Noise,
) -> Vec<f64> {
    let mut left = Vec::with_capacity(3 * windows.len());
    for window in windows {
        let predicted = window.predicted(matrix, &trackers[window.run]);
        left.push((window.seen[0] - predicted[0]) / noise.position_m);
        left.push((window.seen[1] - predicted[1]) / noise.position_m);
        left.push((window.seen[2] - predicted[2]) / noise.heading_rad);
    }
    left
}

/// Fits a model to some runs. Parameters that these runs do not determine are held at the robot's
/// own value.
///
/// # Errors
/// A robot that no values make movable.
pub fn fit(
    model: &Model,
    evidence: &Evidence,
    windows: &[&Window],
    noise: Noise,
) -> Result<Fitted, Error> {
    let (model, held) = determined(model, windows, evidence, noise)?;
    let search = search_of(&model);
    let f = |values: &[f64]| Ok(residuals(&model, values, windows, evidence, noise));
    let found = least_squares(&f, &model.nominal(), &search)?;
    let (scatter, over_runs) = scatter(windows, &found.jacobian, &found.residuals);
    Ok(Fitted {
        values: found.values,
        model,
        scatter,
        held,
        over_runs,
    })
}

/// Returns a model with the robot of another fit, and its tracker's parameters fitted to runs of
/// series outside that fit.
///
/// # Errors
/// Like [`fit`].
pub fn see_with(
    fitted: &Fitted,
    of_tracker: &[String],
    evidence: &Evidence,
    windows: &[&Window],
    noise: Noise,
) -> Result<Vec<Tracker>, Error> {
    let matrix = fitted.model.twist_matrix(&fitted.values);
    let Some(matrix) = matrix else {
        return Err(Error::invalid("the fitted robot cannot be moved", ""));
    };
    let known: Vec<&String> = fitted
        .model
        .parameters
        .iter()
        .filter_map(|parameter| match parameter {
            Parameter::TrackerX(name)
            | Parameter::TrackerY(name)
            | Parameter::TrackerHeading(name) => Some(name),
            _ => None,
        })
        .collect();
    let mut trackers: Vec<Tracker> = evidence
        .series
        .iter()
        .map(|series| fitted.model.tracker(&fitted.values, series))
        .collect();
    for series in evidence.series_of(windows) {
        if known.contains(&&series) || of_tracker.is_empty() {
            continue;
        }
        let here = windows.iter().copied();
        let windows: Vec<&Window> = here
            .filter(|window| evidence.series[window.run] == series)
            .collect();
        let bare = fitted.model.without(&fitted.model.parameters);
        let model = bare.with_tracker(of_tracker, std::slice::from_ref(&series));
        let (model, _) = determined(&model, &windows, evidence, noise)?;
        let f = |values: &[f64]| {
            let trackers = vec![model.tracker(values, &series); evidence.series.len()];
            Ok(Some(misses(&matrix, &trackers, &windows, noise)))
        };
        let found = least_squares(&f, &model.nominal(), &search_of(&model))?;
        for (run, tracker) in trackers.iter_mut().enumerate() {
            if evidence.series[run] == series {
                *tracker = model.tracker(&found.values, &series);
            }
        }
    }
    Ok(trackers)
}

pub(crate) fn search_of(model: &Model) -> Search {
    Search {
        differences: model.scales().iter().map(|scale| 1e-3 * scale).collect(),
        bounds: vec![(f64::NEG_INFINITY, f64::INFINITY); model.parameters.len()],
        steps: 60,
        tolerance: 1e-4,
        damping: 1e-4,
        tries: 12,
    }
}

/// Returns the scatter of runs, or of windows of the runs if there are too few runs.
fn scatter(
    windows: &[&Window],
    jacobian: &DMatrix<f64>,
    residuals: &DVector<f64>,
) -> (Option<Scatter>, bool) {
    let runs = windows
        .iter()
        .map(|window| window.run)
        .max()
        .map_or(0, |most| most + 1);
    let counts: Vec<usize> = (0..runs)
        .map(|run| windows.iter().filter(|window| window.run == run).count())
        .collect();
    let used = counts.iter().filter(|count| **count > 0).count();
    let each = residuals.len() / windows.len().max(1);
    let gather = |parts: usize| -> Option<Scatter> {
        let mut clusters = vec![Cluster::empty(jacobian.ncols()); runs * parts];
        let mut place = vec![0_usize; runs];
        for (index, window) in windows.iter().enumerate() {
            let run = window.run;
            let part = place[run] * parts / counts[run];
            place[run] += 1;
            let rows = jacobian.rows(each * index, each);
            clusters[run * parts + part].add(
                rows.clone_owned(),
                residuals.rows(each * index, each).clone_owned(),
            );
        }
        clusters.retain(|cluster| cluster.rows > 0);
        Scatter::new(&clusters)
    };
    // Each value must be determined without any single run.
    let by_run = gather(1).filter(|by_run| used >= FEWEST_RUNS && !by_run.has_alone());
    if by_run.is_some() {
        return (by_run, true);
    }
    let parts = FEWEST_STRETCHES.div_ceil(used.max(1));
    (gather(parts), false)
}

/// With fewer runs than this the scatter of windows is used.
const FEWEST_RUNS: usize = 6;
/// Smallest number of these windows.
const FEWEST_STRETCHES: usize = 24;

/// A combination of parameters with a singular value below this share of the largest has no visible
/// effect.
const INDISTINCT: f64 = 2e-3;
/// A parameter with a standard error above this share of its expected deviation is not determined.
const UNKNOWN: f64 = 1.0;

/// Returns the model with the parameters that a log determines, and the others with the reason.
fn determined(
    model: &Model,
    windows: &[&Window],
    evidence: &Evidence,
    noise: Noise,
) -> Result<(Model, Vec<(Parameter, String)>), Error> {
    let mut model = model.clone();
    let mut held: Vec<(Parameter, String)> = Vec::new();
    loop {
        let search = search_of(&model);
        let f = |values: &[f64]| Ok(residuals(&model, values, windows, evidence, noise));
        let at_nominal = least_squares(&f, &model.nominal(), &Search { steps: 0, ..search })?;
        let names = model.names();
        if names.is_empty() {
            break;
        }
        let scales = DMatrix::from_diagonal(&DVector::from_vec(model.scales()));
        let scaled = at_nominal.jacobian * scales;
        let normal = scaled.transpose() * scaled;
        let sizes: Vec<f64> = normal
            .diagonal()
            .iter()
            .map(|size| size.max(0.0).sqrt())
            .collect();
        let remedy = remedy(windows, &model);
        // A parameter whose whole expected deviation changes less than the noise.
        let unseen = (0..names.len()).find(|axis| sizes[*axis] * UNKNOWN < 1.0);
        if let Some(axis) = unseen {
            held.push((
                model.parameters[axis].clone(),
                format!("`{}` changes nothing in this log; {remedy}", names[axis]),
            ));
            model = model.without(&[model.parameters[axis].clone()]);
            continue;
        }
        let count = names.len();
        let alike = DMatrix::from_fn(count, count, |i, j| normal[(i, j)] / (sizes[i] * sizes[j]));
        let eigen = SymmetricEigen::new(alike);
        let least =
            (0..count).min_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        let Some(least) = least else {
            break;
        };
        if eigen.eigenvalues[least].max(0.0).sqrt() > INDISTINCT * eigen.eigenvalues.amax().sqrt() {
            break;
        }
        let vector = eigen.eigenvectors.column(least);
        let involved: Vec<usize> = (0..count)
            .filter(|axis| vector[*axis].abs() > 0.2)
            .collect();
        let listed: Vec<String> = involved
            .iter()
            .map(|axis| format!("`{}`", names[*axis]))
            .collect();
        let Some(last) = involved.last() else {
            break;
        };
        held.push((
            model.parameters[*last].clone(),
            format!(
                "{} cannot be separated by this log; {remedy}",
                listed.join(" and ")
            ),
        ));
        model = model.without(&[model.parameters[*last].clone()]);
    }
    Ok((model, held))
}

/// Returns what a log would have to contain in addition.
fn remedy(windows: &[&Window], model: &Model) -> String {
    let bare = model.without(&model.parameters);
    let Some(matrix) = bare.twist_matrix(&[]) else {
        return "drive in more directions".to_owned();
    };
    let lever_m = Parameter::Lever.nominal(&bare.robot(&[]));
    let mut went = [0.0; 3];
    for window in windows {
        let moved = window.of_wheels(&matrix);
        went[0] += moved[0].abs();
        went[1] += moved[1].abs();
        went[2] += lever_m * moved[2].abs();
    }
    let all: f64 = went.iter().sum();
    let is_held = is_held(&bare.robot(&[]));
    let lacks: Vec<&str> = ["drive ahead", "drive sideways", "turn"]
        .into_iter()
        .zip(went)
        .enumerate()
        .filter(|(axis, (_, way))| *way < 0.05 * all && !(is_held && *axis == 1))
        .map(|(_, of)| of)
        .map(|(words, _)| words)
        .collect();
    match lacks.is_empty() {
        false => format!("{} too", lacks.join(" and ")),
        true => "measure one of them by hand, and hold it".to_owned(),
    }
}
