//! The logs of a study as they are fitted: without faults that a log shows by itself, on one clock, cut into stretches, without outliers.

use ilon_sim::Error;

use crate::delay::{self, Delay};
use crate::kinematic_fit::{Evidence, Noise, take_noise};
use crate::log::{AnomalyKind, Delayed, Log, anomalies, wiring};
use crate::motion::{Window, windows};
use crate::outcome::RunDoubt;
use crate::read_logs::{delays, read, refuse};
use crate::study::Study;

/// Fewer stretches of a run than this say nothing.
const FEWEST_WINDOWS: usize = 4;

/// The logs of a study, and what is to be fitted of them.
pub(crate) struct CheckedLogs {
    /// The logs, their poses at the times of the wheels.
    pub logs: Vec<Log>,
    /// Their stretches.
    pub evidence: Evidence,
    /// By how much poses come later than wheels, for each series.
    pub delays: Vec<(String, Delay)>,
    /// How far poses scatter.
    pub noise: Noise,
    /// How many stretches were left out as outliers.
    pub left_out: usize,
    /// What is odd in the logs, and no reason to refuse them.
    pub doubts: Vec<RunDoubt>,
}

impl CheckedLogs {
    /// Reads and checks the logs of a study.
    ///
    /// # Errors
    /// Where a log cannot be read, is not what it is stated to be, or does not say enough.
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
                "nothing is left to fit: all stretches were outliers",
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

/// Whether the times by which poses come later than wheels are fitted.
pub(crate) fn fits_delays(study: &Study) -> bool {
    matches!(study.file.log.delay_s, Some(Delayed::Fitted(_)))
}

/// What is odd in the rows of a log.
fn doubts_of_rows(study: &Study, run: usize, log: &Log) -> Result<Vec<RunDoubt>, Error> {
    let mut doubts = Vec::new();
    for doubt in anomalies::of_rows(log, &study.robot) {
        refuse(study, run, &doubt)?;
        doubts.push(RunDoubt {
            file: study.file.runs[run].file.display().to_string(),
            doubt,
        });
    }
    Ok(doubts)
}

/// The stretches of a run in which wheels turn.
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

/// Refuses logs in which wheels are exchanged or turned round. A single run may not move enough ways for that; runs of a series are wired
/// alike.
fn check_wiring(study: &Study, logs: &[Log], evidence: &Evidence) -> Result<(), Error> {
    for series in evidence.series_of(&evidence.all()) {
        let of_series = evidence.of_series(&series);
        let (Some(first), Some(doubt)) = (
            of_series.first(),
            wiring::of_motion(&of_series, &study.robot),
        ) else {
            continue;
        };
        let doubt = match doubt.kind {
            // Neither wheels nor the tracker's hand: one of its axes alone may be otherwise, which displacements do not show.
            AnomalyKind::Unexplained | AnomalyKind::Wiring => {
                let runs: Vec<&Log> = logs
                    .iter()
                    .zip(&evidence.series)
                    .filter(|(_, of)| **of == series)
                    .map(|(log, _)| log)
                    .collect();
                let axis = wiring::of_axes(&runs, &study.robot, study.file.window_s);
                axis.unwrap_or(doubt)
            }
            _ => doubt,
        };
        refuse(study, first.run, &doubt)?;
    }
    Ok(())
}

/// Takes the delays of poses out of the logs where the study asks for it; else what is said of those that show.
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
                    "two clocks, or a tracker that takes its time: `delay_s = \"fit\"` in `[log]` takes it out",
                ),
            }),
            _ => {}
        }
    }
    doubts
}
