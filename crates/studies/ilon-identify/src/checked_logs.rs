//! Reads the logs of a study and prepares them for fits: checks each log for faults, puts poses and
//! wheels on one clock, cuts the logs into windows, and removes outliers.

use ilon_sim::Error;

use crate::delay::{self, Delay};
use crate::kinematic_fit::{Evidence, Noise, take_noise};
use crate::log::{AnomalyKind, Delayed, Log, anomalies, wiring};
use crate::motion::{Window, windows};
use crate::outcome::RunDoubt;
use crate::read_logs::{delays, read, refuse};
use crate::study::Study;

/// Smallest number of windows of a usable run.
const FEWEST_WINDOWS: usize = 4;

/// The checked logs of a study.
pub(crate) struct CheckedLogs {
    /// The logs, with the poses at the times of the wheels.
    pub logs: Vec<Log>,
    /// Their windows.
    pub evidence: Evidence,
    /// Delay of the poses behind the wheels, for each series.
    pub delays: Vec<(String, Delay)>,
    /// Scatter of the poses.
    pub noise: Noise,
    /// Number of windows removed as outliers.
    pub left_out: usize,
    /// Doubts about the logs that are no reason to reject them.
    pub doubts: Vec<RunDoubt>,
}

impl CheckedLogs {
    /// Reads and checks the logs of a study.
    ///
    /// # Errors
    /// If a log cannot be read, differs from its stated format, or does not contain enough motion.
    pub fn read(study: &Study) -> Result<Self, Error> {
        let mut logs = read(study)?;
        let mut evidence = Evidence {
            windows: Vec::new(),
            series: study
                .file
                .runs
                .iter()
                .map(|run| run.series.clone())
                .collect(),
            held_out: study.file.runs.iter().map(|run| run.held_out).collect(),
        };
        let mut doubts = Vec::new();
        for (run, log) in logs.iter().enumerate() {
            doubts.extend(doubts_of_rows(study, run, log)?);
        }
        for (run, log) in logs.iter_mut().enumerate() {
            *log = study.unsteered.log(log, &study.robot);
            evidence.windows.extend(enough_windows(study, run, log)?);
        }
        check_wiring(study, &logs, &evidence)?;
        let delays = delays(study, &logs)?;
        doubts.extend(take_delays(study, &mut logs, &evidence, &delays));
        if fits_delays(study) {
            evidence.windows = logs
                .iter()
                .enumerate()
                .flat_map(|(run, log)| windows(log, run, study.file.window_s))
                .collect();
        }
        let (noise, left_out) = take_noise(&mut evidence);
        if evidence.fitted().is_empty() {
            return Err(Error::invalid(
                "no data is left to fit: all stretches were outliers",
                "look at the logs, and compare longer stretches: `window_s`",
            ));
        }
        Ok(Self {
            logs,
            evidence,
            delays,
            noise,
            left_out,
            doubts,
        })
    }
}

/// Whether the study fits the delays of the poses.
pub(crate) fn fits_delays(study: &Study) -> bool {
    matches!(study.file.log.delay_s, Some(Delayed::Fitted(_)))
}

/// Returns the anomalies in the rows of a log.
fn doubts_of_rows(study: &Study, run: usize, log: &Log) -> Result<Vec<RunDoubt>, Error> {
    let mut doubts = Vec::new();
    for doubt in anomalies::of_rows(log, &study.robot) {
        refuse(study, &[run], &doubt)?;
        doubts.push(RunDoubt {
            file: study.file.runs[run].file.display().to_string(),
            doubt,
        });
    }
    Ok(doubts)
}

/// Returns the windows of a run in which wheels turn.
fn enough_windows(study: &Study, run: usize, log: &Log) -> Result<Vec<Window>, Error> {
    let found = windows(log, run, study.file.window_s);
    if found.len() < FEWEST_WINDOWS {
        return Err(Error::contents(
            &study.resolve(&study.file.runs[run].file),
            format!(
                "it holds {} stretches of {} s in which wheels turn, which is too few",
                found.len(),
                study.file.window_s
            ),
            "drive for longer, or compare shorter stretches: `window_s`",
        ));
    }
    Ok(found)
}

/// Rejects logs in which wheels are swapped or reversed. A single run may not move in enough
/// directions to show this; the runs of a series are wired alike.
fn check_wiring(study: &Study, logs: &[Log], evidence: &Evidence) -> Result<(), Error> {
    for series in evidence.series_of(&evidence.all()) {
        let of_series = evidence.of_series(&series);
        let Some(doubt) = wiring::of_motion(&of_series, &study.unsteered.robot) else {
            continue;
        };
        let doubt = match doubt.kind {
            // Neither the wheels nor the tracker's handedness: one of its axes alone may be wrong,
            // which displacements do not show.
            AnomalyKind::Unexplained | AnomalyKind::Wiring => {
                let runs: Vec<&Log> = logs
                    .iter()
                    .zip(&evidence.series)
                    .filter(|(_, of)| **of == series)
                    .map(|(log, _)| log)
                    .collect();
                let axis = wiring::of_axes(&runs, &study.unsteered.robot, study.file.window_s);
                axis.unwrap_or(doubt)
            }
            _ => doubt,
        };
        let of_series = |run: &usize| evidence.series[*run] == series;
        let runs: Vec<usize> = (0..logs.len()).filter(of_series).collect();
        refuse(study, &runs, &doubt)?;
    }
    Ok(())
}

/// Removes the delays of poses from the logs if the study asks for it; otherwise returns doubts
/// about those that show.
fn take_delays(
    study: &Study,
    logs: &mut [Log],
    evidence: &Evidence,
    delays: &[(String, Delay)],
) -> Vec<RunDoubt> {
    let mut doubts = Vec::new();
    for (series, delay) in delays {
        let of_series = |run: &usize| evidence.series[*run] == *series;
        let runs: Vec<usize> = (0..logs.len()).filter(of_series).collect();
        match (study.file.log.delay_s, runs.first()) {
            (Some(Delayed::Fitted(_)), _) => {
                for run in runs {
                    logs[run] = delay::shifted(&logs[run], delay.value_s);
                }
            }
            (None, Some(first)) if delay.is_shown => doubts.push(RunDoubt {
                file: study.file.runs[*first].file.display().to_string(),
                doubt: anomalies::anomaly(
                    AnomalyKind::Delay,
                    false,
                    format!(
                        "the poses come {} s after the wheels ({} to {} s)",
                        anomalies::shown(delay.value_s),
                        anomalies::shown(delay.interval.low),
                        anomalies::shown(delay.interval.high)
                    ),
                    "two clocks, or a slow tracker: `delay_s = \"fit\"` in `[log]` removes it",
                ),
            }),
            _ => {}
        }
    }
    doubts
}
