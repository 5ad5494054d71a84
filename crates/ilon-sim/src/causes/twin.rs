//! A run's twin: the same resolved scenario, the same robot, the same seeds, with one thing changed.

use std::sync::atomic::{AtomicBool, Ordering};

use ilon_robot::Robot;
use ilon_trace::{Recording, Settings, Summary};

use crate::Error;
use crate::scenario::Scenario;
use crate::simulate::{Resolved, RunLoop};

/// Runs a scenario that was resolved for a robot with some of its keys changed, to its end. Of its rows only the figures are kept. Gives `None`
/// where it was told to `stop`.
///
/// # Errors
/// Where the changed scenario cannot be run, and [`ilon_trace::TraceError::Diverged`].
pub(super) fn twin(
    resolved: &Resolved,
    robot: &Robot,
    change: impl FnOnce(&mut Scenario),
    stop: &AtomicBool,
) -> Result<Option<Summary>, Error> {
    let mut run = RunLoop::of_guidance(&resolved.with(change)?, robot)?;
    let mut recording = Recording::temporary(run.rows_mut().header.clone());
    while !run.is_done() {
        if run.control_is_due() {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            recording.take(run.rows_mut())?;
        }
        run.step();
    }
    recording.take(run.rows_mut())?;
    let recorded = recording.finish()?;
    Ok(Some(Summary::of_rows(&recorded, &Settings::default())?))
}
