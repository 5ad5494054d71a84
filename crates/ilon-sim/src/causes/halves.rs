//! The same run at half its step, and with half the parts into which steps are split: by how much its figures move is how well they are known.

use std::sync::atomic::{AtomicBool, Ordering};

use ilon_robot::Robot;
use ilon_trace::Twin;
use ilon_trace::convergence::Change;

use super::twin::twin;
use crate::scenario::{Scenario, Step};
use crate::simulate::Resolved;

/// A run's twins at half its step.
pub(crate) struct Halves {
    resolved: Resolved,
    robot: Robot,
}

impl Halves {
    /// Of a scenario that was resolved for a robot.
    pub fn of(resolved: &Resolved, robot: &Robot) -> Self {
        Self {
            resolved: resolved.clone(),
            robot: robot.clone(),
        }
    }

    /// Runs the twins beside `work`, which stays in its thread; gives what both came to. Where `work` fails they are stopped.
    ///
    /// A thread of rayon's has other runs to share the processors with: it runs them after `work`, one after another. Which it is changes no
    /// bit.
    ///
    /// # Errors
    /// What `work` gives.
    pub fn beside<T, E>(&self, work: impl FnOnce() -> Result<T, E>) -> Result<(T, Vec<Twin>), E> {
        let stop = AtomicBool::new(false);
        let changes = self.changes();
        let mut twins: Vec<Option<Twin>> = vec![None; changes.len()];
        let places = changes.iter().zip(&mut twins);
        let worked = if rayon::current_thread_index().is_some() {
            let worked = work()?;
            places.for_each(|(change, twin)| *twin = self.twin(*change, &stop));
            worked
        } else {
            rayon::in_place_scope(|scope| {
                for (change, twin) in places {
                    scope.spawn(|_| *twin = self.twin(*change, &stop));
                }
                let worked = work();
                stop.store(worked.is_err(), Ordering::Relaxed);
                worked
            })?
        };
        Ok((worked, twins.into_iter().flatten().collect()))
    }

    /// What is halved, each by itself: the split only where there is one.
    fn changes(&self) -> Vec<Change> {
        let splits = self.resolved.scenario().world.solver.split_dt_s.is_some();
        let all = [(Change::HalfStep, true), (Change::HalfSplit, splits)];
        let there = all.into_iter().filter(|(_, is_there)| *is_there);
        there.map(|(change, _)| change).collect()
    }

    /// A twin to its end; `None` where it was told to stop.
    fn twin(&self, change: Change, stop: &AtomicBool) -> Option<Twin> {
        let dt_s = self.resolved.physics_dt_s();
        let halve = |scenario: &mut Scenario| match change {
            Change::HalfSplit => {
                let split_dt_s = &mut scenario.world.solver.split_dt_s;
                *split_dt_s = split_dt_s.map(|dt_s| 0.5 * dt_s);
            }
            _ => scenario.run.physics_dt_s = Step::Seconds(0.5 * dt_s),
        };
        let came = twin(&self.resolved, &self.robot, halve, stop);
        let came = came.map_err(|error| error.to_string()).transpose()?;
        Some(Twin::new(change, came))
    }
}
