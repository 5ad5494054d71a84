//! The twins of a run, which go on beside it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use ilon_robot::Robot;
use ilon_trace::{Cause, Change, Header, Twin};
use rayon::prelude::*;

use super::Causes;
use super::null::{self, Null};
use super::path::Path;
use super::remedies;
use super::twin::{Came, twin};
use crate::scenario::{Scenario, Step};
use crate::simulate::Resolved;

/// A plain run leaves out at most so many causes.
const MOST_NAMED: usize = 8;

/// A run's twins.
pub(crate) struct Twins {
    resolved: Resolved,
    robot: Robot,
    changes: Vec<(Change, Null)>,
    /// Whether remedies are tried.
    tries: bool,
}

/// What the twins of a run came to.
#[must_use]
pub(crate) struct CameToo(Vec<Came>);

impl CameToo {
    /// None at all.
    pub fn none() -> Self {
        Self(Vec::new())
    }

    /// As a trace keeps them, beside the path of the run.
    pub fn beside(self, run: &Path) -> Vec<Twin> {
        self.0.into_iter().map(|came| came.beside(run)).collect()
    }
}

impl Twins {
    /// Of a scenario that was resolved for a robot: those that leave causes out, and where the scenario says so those at half its step. The header is
    /// that of its trace; `stands` is where the robot's joints stand as the run begins, in rad or m.
    pub fn of(
        resolved: &Resolved,
        robot: &Robot,
        header: &Header,
        stands: &[f64],
        causes: Causes,
    ) -> Option<Self> {
        let scenario = resolved.scenario();
        let run = null::Run {
            scenario,
            robot,
            header,
            stands,
            physics_dt_s: resolved.physics_dt_s(),
        };
        let mut left_out = match causes {
            Causes::None => Vec::new(),
            Causes::Named => null::named(run),
            Causes::All => null::all(run),
        };
        if causes == Causes::Named {
            left_out.truncate(MOST_NAMED);
        }
        let explains = causes != Causes::None;
        let converges = scenario.run.converge;
        if !explains && !converges {
            return None;
        }
        let mut changes = Vec::new();
        if explains || converges {
            changes.push((Change::HalfStep, half_step(resolved.physics_dt_s())));
        }
        if converges && scenario.world.solver.split_dt_s.is_some() {
            changes.push((Change::HalfSplit, half_split()));
        }
        if explains && is_noisy(scenario) {
            changes.push((Change::OtherSeed, other_seed()));
        }
        let nulls = left_out.into_iter();
        let nulls: Vec<(Cause, Arc<Null>)> =
            nulls.map(|(cause, null)| (cause, null.into())).collect();
        if nulls.len() > 1 && causes == Causes::Named {
            let all: Vec<Arc<Null>> = nulls.iter().map(|(_, null)| Arc::clone(null)).collect();
            changes.push((Change::WithoutAll, without_all(all)));
        }
        changes.extend(nulls.into_iter().map(|(cause, null)| {
            let apply = move |scenario: &mut Scenario, robot: &mut Robot| null(scenario, robot);
            (Change::Without(cause), Box::new(apply) as Null)
        }));
        Some(Self {
            resolved: resolved.clone(),
            robot: robot.clone(),
            changes,
            tries: explains,
        })
    }

    /// Runs the twins beside `work`, which stays in its thread; gives what both came to. Where `work` fails they are stopped.
    ///
    /// A thread of rayon's has other runs to share the processors with: it runs them after `work`, one after another. Which it is changes no
    /// bit.
    ///
    /// # Errors
    /// What `work` gives.
    pub fn beside<T, E>(&self, work: impl FnOnce() -> Result<T, E>) -> Result<(T, CameToo), E> {
        let stop = AtomicBool::new(false);
        let mut twins: Vec<Option<Came>> = self.changes.iter().map(|_| None).collect();
        let places = self.changes.iter().zip(&mut twins);
        let alone = rayon::current_thread_index().is_some();
        let worked = if alone {
            let worked = work()?;
            places.for_each(|(change, twin)| *twin = self.twin(change, &stop));
            worked
        } else {
            rayon::in_place_scope(|scope| {
                for (change, twin) in places {
                    let stop = &stop;
                    scope.spawn(move |_| *twin = self.twin(change, stop));
                }
                let worked = work();
                stop.store(worked.is_err(), Ordering::Relaxed);
                worked
            })?
        };
        let mut came: Vec<Came> = twins.into_iter().flatten().collect();
        came.extend(self.tried(&came, alone));
        Ok((worked, CameToo(came)))
    }

    /// The remedies that the run at half the step gives reason for, tried.
    fn tried(&self, came: &[Came], alone: bool) -> Vec<Came> {
        let half = came.first().and_then(|half| half.ran.as_ref().ok());
        let Some((summary, _)) = half.filter(|_| self.tries) else {
            return Vec::new();
        };
        let remedies: Vec<(Change, Null)> = remedies::of(self.resolved.scenario(), summary)
            .into_iter()
            .map(|(remedy, change): (Cause, Null)| (Change::With(remedy), change))
            .collect();
        let never = AtomicBool::new(false);
        let run = |change| self.twin(change, &never);
        match alone {
            true => remedies.iter().filter_map(run).collect(),
            false => remedies.par_iter().filter_map(run).collect(),
        }
    }

    /// A twin to its end; `None` where it was told to stop.
    fn twin(&self, (change, null): &(Change, Null), stop: &AtomicBool) -> Option<Came> {
        twin(&self.resolved, &self.robot, change.clone(), null, stop)
    }
}

/// Half the step; wheel loops keep their period.
fn half_step(dt_s: f64) -> Null {
    Box::new(move |scenario, _| scenario.run.physics_dt_s = Step::Seconds(0.5 * dt_s))
}

/// Half the parts into which steps are split.
fn half_split() -> Null {
    Box::new(|scenario, _| {
        let split_dt_s = &mut scenario.world.solver.split_dt_s;
        *split_dt_s = split_dt_s.map(|dt_s| 0.5 * dt_s);
    })
}

/// Other noise.
fn other_seed() -> Null {
    Box::new(|scenario, _| scenario.sensors.seed = scenario.sensors.seed.wrapping_add(1))
}

/// All that the scenario names left out, the last first: what is left of a list keeps its places.
fn without_all(nulls: Vec<Arc<Null>>) -> Null {
    Box::new(move |scenario, robot| {
        let nulls = nulls.iter().rev();
        nulls.for_each(|null| null(scenario, robot));
    })
}

/// Whether a seed makes a difference.
fn is_noisy(scenario: &Scenario) -> bool {
    let sensors = &scenario.sensors;
    let pose = &sensors.pose;
    pose.position_noise_m > 0.0
        || pose.heading_noise_deg > 0.0
        || sensors.encoders.rate_noise_rad_s > 0.0
        || sensors.imu.is_some()
}
