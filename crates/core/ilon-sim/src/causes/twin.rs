//! A run's twin: the same resolved scenario, the same robot, the same seeds, with one thing changed.

use std::sync::atomic::{AtomicBool, Ordering};

use ilon_robot::Robot;
use ilon_trace::{Change, Recording, Settings, Summary, Twin};

use super::path::Path;
use crate::Error;
use crate::scenario::Scenario;
use crate::simulate::{Resolved, RunLoop};

/// What a twin came to.
pub(super) struct Came {
    change: Change,
    /// Its figures and its path, or why it has none.
    pub ran: Result<(Summary, Path), String>,
}

impl Came {
    /// As a trace keeps it, beside the path of the run.
    pub fn beside(self, run: &Path) -> Twin {
        let poses = match (&self.change, &self.ran) {
            (Change::Without(_), Ok((_, path))) => path.drawn(),
            _ => Vec::new(),
        };
        let ran = self.ran.map(|(summary, path)| {
            let apart = run.apart(&path);
            (summary, Some(apart))
        });
        Twin {
            poses,
            ..Twin::new(self.change, ran)
        }
    }
}

/// Runs a scenario that was resolved for a robot with something of both changed, to its end. Gives `None` where it was told to `stop`.
pub(super) fn twin(
    resolved: &Resolved,
    robot: &Robot,
    change: Change,
    apply: impl FnOnce(&mut Scenario, &mut Robot),
    stop: &AtomicBool,
) -> Option<Came> {
    let ran = run(resolved, robot, apply, stop);
    let ran = ran.map_err(|error| error.to_string()).transpose()?;
    Some(Came { change, ran })
}

/// Of its rows only the figures are kept.
fn run(
    resolved: &Resolved,
    robot: &Robot,
    apply: impl FnOnce(&mut Scenario, &mut Robot),
    stop: &AtomicBool,
) -> Result<Option<(Summary, Path)>, Error> {
    let of_run = resolved.scenario().run.clone();
    let (resolved, robot) = resolved.with(robot, apply)?;
    let mut run = RunLoop::of_guidance(&resolved, &robot)?;
    let mut recording = Recording::temporary(run.rows_mut().header.clone());
    let parts = of_run.control_dt_s / resolved.scenario().run.control_dt_s;
    let mut path = Path::of(of_run.control_periods(), parts.round() as u64);
    while !run.is_done() {
        if run.control_is_due() {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            path.look(&run);
            recording.take(run.rows_mut())?;
        }
        run.step();
    }
    recording.take(run.rows_mut())?;
    let recorded = recording.finish()?;
    let summary = Summary::of_rows(&recorded, &Settings::default())?;
    Ok(Some((summary, path)))
}
