//! A run's twin: the same resolved scenario, robot and seeds, with one thing changed.

use std::sync::atomic::{AtomicBool, Ordering};

use ilon_robot::{Robot, Roller, RollerForm};
use ilon_trace::{Change, Figures, Recording, Settings, Summary, Twin};

use super::path::Path;
use crate::Error;
use crate::scenario::Scenario;
use crate::simulate::{Resolved, RunLoop};

/// The outcome of a twin.
pub(super) struct TwinOutcome {
    change: Change,
    /// Its figures and its path, or the reason why it could not be run.
    pub ran: Result<(Summary, Path), String>,
    /// Its cost, in surfaces tested for contact; 0 if it could not be run.
    pub effort: u64,
}

impl TwinOutcome {
    /// The outcome as a trace stores it, compared with the run's path.
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

/// When a twin stops early.
#[derive(Clone, Copy)]
pub(super) struct Limits<'a> {
    /// As soon as this flag is set.
    pub stop: &'a AtomicBool,
    /// When it has tested more surfaces than this.
    pub effort: u64,
}

impl Limits<'_> {
    /// No limits.
    pub fn none() -> Self {
        static NEVER: AtomicBool = AtomicBool::new(false);
        Self {
            stop: &NEVER,
            effort: u64::MAX,
        }
    }
}

/// Runs a resolved scenario with a change of scenario or robot to its end. Returns `None` if it
/// reached its limits.
pub(super) fn twin(
    resolved: &Resolved,
    robot: &Robot,
    change: Change,
    apply: impl FnOnce(&mut Scenario, &mut Robot),
    limits: Limits<'_>,
) -> Option<TwinOutcome> {
    let mut effort = 0;
    let ran = run(resolved, robot, apply, limits, &mut effort);
    let ran = ran.map_err(|error| error.to_string()).transpose()?;
    Some(TwinOutcome {
        change,
        ran,
        effort,
    })
}

/// Of its rows only the figures are kept. There is one at each control instant of the run, however
/// often the twin decides: what is sampled is sampled as often as in the run.
fn run(
    resolved: &Resolved,
    robot: &Robot,
    apply: impl FnOnce(&mut Scenario, &mut Robot),
    limits: Limits<'_>,
    effort: &mut u64,
) -> Result<Option<(Summary, Path)>, Error> {
    let of_run = resolved.scenario().run.clone();
    let mut parts = 1;
    let (resolved, robot) = resolved.with(robot, |scenario, robot| {
        apply(scenario, robot);
        parts = (of_run.control_dt_s / scenario.run.control_dt_s).round() as u32;
        scenario.run.record_every = parts;
    })?;
    let mut run = RunLoop::of_guidance(&resolved, &robot)?;
    let mut figures = Figures::new(&run.rows_mut().header, &Settings::default());
    let mut recording = Recording::temporary(run.rows_mut().header.clone());
    let mut path = Path::of(of_run.control_periods(), u64::from(parts));
    let surfaces = surfaces(&robot);
    loop {
        if run.control_is_due() {
            if limits.stop.load(Ordering::Relaxed) || *effort > limits.effort {
                return Ok(None);
            }
            path.look(&run);
            let rows = run.rows_mut();
            for (record, samples) in rows.steps() {
                figures.add(&rows.header, record, samples);
            }
            recording.take(rows)?;
        }
        if run.is_done() {
            break;
        }
        run.step();
        *effort += surfaces * u64::from(run.searches());
    }
    Ok(Some((figures.finish(&run.rows_mut().header), path)))
}

/// The number of surfaces tested in one contact search: the rollers, or all shapes of modelled
/// rollers.
fn surfaces(robot: &Robot) -> u64 {
    let rollers = robot.wheels.iter().flat_map(|wheel| &wheel.rollers);
    let of_roller = |roller: &Roller| match &roller.form {
        RollerForm::AsModelled(modelled) => modelled.shapes.len() as u64,
        _ => 1,
    };
    rollers.map(of_roller).sum()
}
