//! Reads the logs of a study and their anomalies.

use ilon_sim::Error;
use rayon::prelude::*;

use crate::delay::{self, Delay};
use crate::log::{Anomaly, Delayed, Log};
use crate::model::{Model, Parameter};
use crate::study::Study;

pub(crate) fn read(study: &Study) -> Result<Vec<Log>, Error> {
    let runs = 0..study.file.runs.len();
    runs.into_par_iter()
        .map(|run| read_run(study, run))
        .collect()
}

/// Returns the delay of the poses of each series, if the logs show one and it is not stated; for
/// every series if the study fits it.
pub(crate) fn delays(study: &Study, logs: &[Log]) -> Result<Vec<(String, Delay)>, Error> {
    if matches!(study.file.log.delay_s, Some(Delayed::Known(_))) {
        return Ok(Vec::new());
    }
    let model = Model::new(&study.unsteered.robot, &[])?;
    let Some(matrix) = model.twist_matrix(&[]) else {
        return Ok(Vec::new());
    };
    let lever_m = Parameter::Lever.nominal(&study.unsteered.robot);
    let mut names: Vec<&String> = Vec::new();
    for run in &study.file.runs {
        if !names.contains(&&run.series) {
            names.push(&run.series);
        }
    }
    let of_series = |name: &&String| -> Option<Result<(String, Delay), Error>> {
        let runs = study.file.runs.iter().zip(logs);
        let of_it: Vec<&Log> = runs
            .filter(|(run, _)| run.series == **name)
            .map(|(_, log)| log)
            .collect();
        let found = delay::of(&of_it, &matrix, lever_m);
        match (found, study.file.log.delay_s) {
            (Some(delay), _) => Some(Ok(((*name).clone(), delay))),
            (None, Some(_)) => Some(Err(Error::invalid(
                format!(
                    "the logs do not show the delay of the poses behind the wheels{}",
                    match name.as_str() {
                        "" => String::new(),
                        series => format!(" in the series `{series}`"),
                    }
                ),
                "drive with changes of speed and direction, or state it: `log.delay_s` in seconds, within half a second",
            ))),
            (None, None) => None,
        }
    };
    names.par_iter().filter_map(of_series).collect()
}

/// Reads the part of a log that a run of a study uses.
pub(crate) fn read_run(study: &Study, run: usize) -> Result<Log, Error> {
    let run = &study.file.runs[run];
    let path = study.resolve(&run.file);
    let log = Log::read(&path, &study.file.log, &study.robot, &study.files)?;
    let log = match study.file.log.delay_s {
        Some(Delayed::Known(delay_s)) => delay::shifted(&log, delay_s),
        _ => log,
    };
    let to_s = run.to_s.unwrap_or(f64::INFINITY);
    let part = log.part(run.from_s, to_s);
    if part.len() < 10 {
        return Err(Error::contents(
            &path,
            format!(
                "nothing of it lies after {} s and before {to_s} s",
                run.from_s
            ),
            format!(
                "it is {:.3} s long: see `from_s` and `to_s` of the run",
                log.duration_s()
            ),
        ));
    }
    Ok(part)
}

/// Ends an identification because of a log to which nothing can be fitted.
/// `runs` are those that show it.
pub(crate) fn refuse(study: &Study, runs: &[usize], doubt: &Anomaly) -> Result<(), Error> {
    let (file, of) = match runs {
        [run] => (study.resolve(&study.file.runs[*run].file), String::new()),
        _ => (
            study.resolve(&study.file.robot),
            format!("over the {} runs of the study together, ", runs.len()),
        ),
    };
    match doubt.is_fatal {
        true => Err(Error::contents(
            &file,
            format!("{of}{}", doubt.message),
            doubt.help.clone(),
        )),
        false => Ok(()),
    }
}
