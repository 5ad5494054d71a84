//! Errors of models on fitted and on held-out data, and the choice of a model.

use ilon_sim::Error;
use nalgebra::Matrix3xX;
use rayon::prelude::*;

use crate::kinematic_fit::{Evidence, Fitted, Noise, fit, misses, see_with};
use crate::log::Log;
use crate::model::Model;
use crate::motion::{Tracker, Window, reckoned};
use crate::outcome::{Errors, JudgedBy};
use crate::study::{ModelFile, Study};

/// A model with more parameters is chosen only if it is better by this share of the best held-out
/// error.
const WORTH: f64 = 0.01;

pub(crate) fn judged_by(evidence: &Evidence, kept_back: &[&Window]) -> JudgedBy {
    let runs = evidence
        .held_out
        .iter()
        .filter(|held_out| !**held_out)
        .count();
    match (kept_back.is_empty(), runs) {
        (false, _) => JudgedBy::Runs,
        (true, 3..) => JudgedBy::EachRun,
        _ => JudgedBy::EachStretch,
    }
}

/// Fits a model, and computes its errors on fitted and on held-out data.
pub(crate) fn judge(
    study: &Study,
    file: &ModelFile,
    evidence: &Evidence,
    noise: Noise,
    logs: &[Log],
    judged_by: JudgedBy,
) -> Result<(Fitted, Errors, Errors), Error> {
    let fitted_windows = evidence.fitted();
    let bare = Model::new(&study.unsteered.robot, &file.free)?;
    let with_tracker = |windows: &[&Window]| {
        bare.clone()
            .with_tracker(&study.file.tracker, &evidence.series_of(windows))
    };
    let fitted = fit(
        &with_tracker(&fitted_windows),
        evidence,
        &fitted_windows,
        noise,
    )?;
    let on = |fitted: &Fitted, windows: &[&Window], all: &[&Window]| -> Result<Vec<f64>, Error> {
        let trackers = see_with(fitted, &study.file.tracker, evidence, all, noise)?;
        Ok(misses(&matrix_of(fitted)?, &trackers, windows, noise))
    };
    let is_fitted = |run: usize| !evidence.held_out[run];
    let trackers = trackers_of(study, &fitted, evidence, noise)?;
    let matrix = matrix_of(&fitted)?;
    let ends = |of: &dyn Fn(usize) -> bool| end_rms(logs, &matrix, &trackers, of);
    let fit_errors = errors(
        &on(&fitted, &fitted_windows, &fitted_windows)?,
        noise,
        ends(&is_fitted),
    );
    let held_out = match judged_by {
        JudgedBy::Runs => {
            let kept_back = evidence.kept_back();
            let left = on(&fitted, &kept_back, &kept_back)?;
            errors(&left, noise, ends(&|run| evidence.held_out[run]))
        }
        JudgedBy::EachRun | JudgedBy::EachStretch => {
            let part = |window: &Window| match judged_by {
                JudgedBy::EachRun => window.run,
                _ => (window.at_s * 8.0 / logs[window.run].duration_s().max(1e-9)) as usize,
            };
            let mut parts: Vec<usize> = fitted_windows.iter().map(|window| part(window)).collect();
            parts.sort_unstable();
            parts.dedup();
            let left_out = |out: &usize| -> Result<Vec<f64>, Error> {
                let (outside, inside): (Vec<&Window>, Vec<&Window>) = fitted_windows
                    .iter()
                    .copied()
                    .partition(|window| part(window) == *out);
                let fold = fit(&with_tracker(&inside), evidence, &inside, noise)?;
                on(&fold, &outside, &outside)
            };
            let left: Vec<Vec<f64>> = parts.par_iter().map(left_out).collect::<Result<_, _>>()?;
            errors(&left.concat(), noise, ends(&is_fitted))
        }
    };
    Ok((fitted, fit_errors, held_out))
}

/// Returns the model with the smallest held-out error; among equally good ones, the one with the
/// fewest parameters.
pub(crate) fn choose(tried: &[(Fitted, Errors, Errors)]) -> usize {
    let error = |index: usize| tried[index].2.over_noise;
    let least = (0..tried.len()).map(error).fold(f64::INFINITY, f64::min);
    let good = (0..tried.len()).filter(|index| error(*index) <= (1.0 + WORTH) * least);
    good.min_by_key(|index| tried[*index].0.values.len())
        .unwrap_or(0)
}

pub(crate) fn matrix_of(fitted: &Fitted) -> Result<Matrix3xX<f64>, Error> {
    fitted.model.twist_matrix(&fitted.values).ok_or_else(|| {
        Error::invalid(
            "the values that fit the log best make a robot with a singular kinematics",
            "leave fewer parameters free",
        )
    })
}

pub(crate) fn trackers_of(
    study: &Study,
    fitted: &Fitted,
    evidence: &Evidence,
    noise: Noise,
) -> Result<Vec<Tracker>, Error> {
    see_with(
        fitted,
        &study.file.tracker,
        evidence,
        &evidence.some(|_| true),
        noise,
    )
}

pub(crate) fn errors(left: &[f64], noise: Noise, end_position_rms_m: f64) -> Errors {
    let rms = |sum: f64, count: usize| (sum / count.max(1) as f64).sqrt();
    let stretches = left.len() / 3;
    let (mut position, mut heading) = (0.0, 0.0);
    for row in left.chunks_exact(3) {
        position += row[0] * row[0] + row[1] * row[1];
        heading += row[2] * row[2];
    }
    Errors {
        stretches,
        position_rms_m: noise.position_m * rms(position, stretches),
        heading_rms_rad: noise.heading_rad * rms(heading, stretches),
        over_noise: rms(position + heading, left.len()),
        end_position_rms_m,
    }
}

pub(crate) fn end_rms(
    logs: &[Log],
    matrix: &Matrix3xX<f64>,
    trackers: &[Tracker],
    of: &dyn Fn(usize) -> bool,
) -> f64 {
    let squares: Vec<f64> = (0..logs.len())
        .filter(|run| of(*run))
        .map(|run| end(&logs[run], matrix, &trackers[run]).0.powi(2))
        .collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

/// Returns the final error of dead reckoning, in metres and in radians.
pub(crate) fn end(log: &Log, matrix: &Matrix3xX<f64>, tracker: &Tracker) -> (f64, f64) {
    let reckoned = reckoned(log, matrix, tracker);
    match (reckoned.last(), log.poses.last()) {
        (Some(own), Some(seen)) => (
            libm::hypot(own[0] - seen[0], own[1] - seen[1]),
            own[2] - seen[2],
        ),
        _ => (0.0, 0.0),
    }
}
