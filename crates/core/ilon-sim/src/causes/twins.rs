//! The twins of a run, which run in parallel with it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use ilon_robot::Robot;
use ilon_trace::{Cause, Change, Header, Twin};
use rayon::prelude::*;

use super::Causes;
use super::null::{self, Null};
use super::path::Path;
use super::remedies;
use super::twin::{Limits, TwinOutcome, twin};
use crate::scenario::{Scenario, Step};
use crate::simulate::Resolved;

/// The largest number of causes that a run removes one by one without being asked. Chosen.
const MOST_NAMED: usize = 8;
/// A run tries remedies without being asked if all its twins together test no more surfaces than
/// this, which takes 0.2 to 0.5 s of CPU in a release build. The cost is counted, not timed, so
/// that every machine makes the same twins.
const MOST_UNASKED: u64 = 800_000;

/// A run's twins.
pub(crate) struct Twins {
    resolved: Resolved,
    robot: Robot,
    changes: Vec<(Change, Null)>,
    tries: Tries,
}

/// Whether remedies are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tries {
    No,
    /// Only in runs so short that the remedies cost little.
    IfShort,
    Yes,
}

/// The outcomes of the twins of a run.
#[must_use]
#[derive(Default)]
pub(crate) struct TwinOutcomes {
    came: Vec<TwinOutcome>,
    /// Whether remedies were left out because they would have taken too long.
    pub is_untried: bool,
}

impl TwinOutcomes {
    /// The outcomes as a trace stores them, compared with the run's path.
    pub fn beside(self, run: &Path) -> Vec<Twin> {
        self.came.into_iter().map(|came| came.beside(run)).collect()
    }
}

impl Twins {
    /// The twins of a resolved scenario: those without one cause each and, if the scenario asks for
    /// it, those at half its step. `header` is that of the run's trace; `stands` holds the joint
    /// positions at the start, in rad or m.
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
        let left_out = match causes {
            Causes::None => Vec::new(),
            Causes::Named => with_the_rest_together(null::named(run)),
            Causes::All => null::all(run),
        };
        let tries = match causes {
            Causes::None => Tries::No,
            Causes::Named => Tries::IfShort,
            Causes::All => Tries::Yes,
        };
        let converges = scenario.run.converge;
        if tries == Tries::No && !converges {
            return None;
        }
        let mut changes = vec![(Change::HalfStep, half_step(resolved.physics_dt_s()))];
        if converges && scenario.world.solver.split_dt_s.is_some() {
            changes.push((Change::HalfSplit, half_split()));
        }
        if !left_out.is_empty() && is_noisy(scenario) {
            changes.push((Change::OtherSeed, other_seed()));
        }
        if !left_out.is_empty() {
            changes.extend(starts_beside());
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
            tries,
        })
    }

    /// Runs the twins in parallel with `work`, which stays in its thread, and returns both results.
    /// If `work` fails, the twins are stopped.
    ///
    /// On a thread of a rayon pool, which has other runs to do, the twins run after `work`, one
    /// after another. The results are the same to the bit.
    ///
    /// # Errors
    /// Those of `work`.
    pub fn beside<T, E>(
        &self,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<(T, TwinOutcomes), E> {
        let stop = AtomicBool::new(false);
        let limits = Limits {
            stop: &stop,
            effort: self.most_effort(),
        };
        let mut twins: Vec<Option<TwinOutcome>> = self.changes.iter().map(|_| None).collect();
        let places = self.changes.iter().zip(&mut twins);
        let alone = rayon::current_thread_index().is_some();
        let worked = if alone {
            let worked = work()?;
            places.for_each(|(change, twin)| *twin = self.twin(change, limits));
            worked
        } else {
            rayon::in_place_scope(|scope| {
                for (change, twin) in places {
                    scope.spawn(move |_| *twin = self.twin(change, limits));
                }
                let worked = work();
                stop.store(worked.is_err(), Ordering::Relaxed);
                worked
            })?
        };
        let came: Vec<TwinOutcome> = twins.into_iter().flatten().collect();
        let all_came = came.len() == self.changes.len();
        Ok((worked, self.with_remedies(came, all_came, alone)))
    }

    /// The outcomes of the twins, and of the remedies that the run at half the step suggests, if
    /// remedies are to be tried.
    fn with_remedies(
        &self,
        mut came: Vec<TwinOutcome>,
        all_came: bool,
        alone: bool,
    ) -> TwinOutcomes {
        if self.tries == Tries::No {
            return TwinOutcomes {
                came,
                is_untried: false,
            };
        }
        let half = came.first().and_then(|half| half.ran.as_ref().ok());
        let remedies = half.map_or_else(Vec::new, |(summary, _)| {
            remedies::of(self.resolved.scenario(), summary)
        });
        // A remedy costs as much as the run, and the run half as much as the twin at half the step.
        let each = came.first().map_or(0, |half| half.effort / 2);
        let effort: u64 = came.iter().map(|twin| twin.effort).sum();
        let is_short = all_came && effort + each * remedies.len() as u64 <= MOST_UNASKED;
        let is_untried = self.tries == Tries::IfShort && !is_short;
        if !is_untried {
            let of = |(remedy, change): (Cause, Null)| (Change::With(remedy), change);
            let remedies: Vec<(Change, Null)> = remedies.into_iter().map(of).collect();
            let run = |change| self.twin(change, Limits::none());
            let tried: Vec<TwinOutcome> = match alone {
                true => remedies.iter().filter_map(run).collect(),
                false => remedies.par_iter().filter_map(run).collect(),
            };
            came.extend(tried);
        }
        TwinOutcomes { came, is_untried }
    }

    /// The limit of each twin's cost. A twin at half the step that exists only for the remedies
    /// stops where these would not be tried.
    fn most_effort(&self) -> u64 {
        let is_for_remedies = self.changes.len() == 1 && !self.resolved.scenario().run.converge;
        match self.tries {
            Tries::IfShort if is_for_remedies => MOST_UNASKED,
            _ => u64::MAX,
        }
    }

    /// Runs a twin to its end; `None` if it reached its limits.
    fn twin(&self, (change, null): &(Change, Null), limits: Limits<'_>) -> Option<TwinOutcome> {
        twin(&self.resolved, &self.robot, change.clone(), null, limits)
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

/// Another noise seed.
fn other_seed() -> Null {
    Box::new(|scenario, _| scenario.sensors.seed = scenario.sensors.seed.wrapping_add(1))
}

/// Two starts beside that of the run, by shares of a wheel's radius that no floor and no robot is
/// known to (chosen). Where they end apart, so may a run without a cause, whatever it is.
fn starts_beside() -> [(Change, Null); 2] {
    [(0, 1e-8), (1, -3e-8)].map(|(count, share)| {
        let beside = move |scenario: &mut Scenario, robot: &mut Robot| {
            let by_m = share * robot.mean_wheel_radius_m();
            scenario.robot.x_m += by_m;
            scenario.robot.y_m += by_m;
        };
        (Change::StartBeside(count), Box::new(beside) as Null)
    })
}

/// Removes all causes that the scenario names. The last comes first, so that the indices of the
/// remaining ones stay valid.
fn without_all(nulls: Vec<Arc<Null>>) -> Null {
    Box::new(move |scenario, robot| {
        let nulls = nulls.iter().rev();
        nulls.for_each(|null| null(scenario, robot));
    })
}

/// At most [`MOST_NAMED`] causes: of more, the last are one.
fn with_the_rest_together(mut causes: Vec<(Cause, Null)>) -> Vec<(Cause, Null)> {
    if causes.len() > MOST_NAMED {
        let rest = causes.split_off(MOST_NAMED - 1).into_iter();
        let (words, nulls): (Vec<String>, Vec<Arc<Null>>) =
            rest.map(|(cause, null)| (cause.words, null.into())).unzip();
        let cause = Cause {
            key: "others".to_owned(),
            words: format!("the {} others ({})", words.len(), words.join(", ")),
        };
        causes.push((cause, without_all(nulls)));
    }
    causes
}

/// Whether the noise seed has an effect.
fn is_noisy(scenario: &Scenario) -> bool {
    let sensors = &scenario.sensors;
    let pose = &sensors.pose;
    pose.position_noise_m > 0.0
        || pose.heading_noise_deg > 0.0
        || sensors.encoders.rate_noise_rad_s > 0.0
        || sensors.imu.is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn causes(count: usize) -> Vec<(Cause, Null)> {
        let cause = |k: usize| Cause {
            key: format!("key {k}"),
            words: format!("cause {k}"),
        };
        let null = || -> Null { Box::new(|scenario, _| scenario.sensors.seed += 1) };
        (0..count).map(|k| (cause(k), null())).collect()
    }

    /// As many causes as are named stand alone; of one more, the last two are one, which removes
    /// both.
    #[test]
    fn the_rest_of_many_causes_is_one() {
        let alone = with_the_rest_together(causes(MOST_NAMED));
        assert_eq!(alone.last().map(|it| it.0.key.as_str()), Some("key 7"));
        let together = with_the_rest_together(causes(MOST_NAMED + 1));
        assert_eq!(together.len(), MOST_NAMED);
        let (cause, null) = together.last().expect("eight");
        assert_eq!(cause.words, "the 2 others (cause 7, cause 8)");
        let (mut scenario, mut robot) = of("");
        null(&mut scenario, &mut robot);
        assert_eq!(scenario.sensors.seed, 2);
    }

    /// Half the parts are tried where that is asked for, and there they are half as long.
    #[test]
    fn the_parts_of_steps_are_halved_where_that_is_asked_for() {
        let split = "world.solver.split_dt_s = 1e-3";
        let has_half = |lines: &str| {
            let (scenario, robot) = of(lines);
            let resolved = crate::simulate::resolve(&scenario, &robot).expect("it can be driven");
            let header = Header::default();
            let twins = Twins::of(&resolved, &robot, &header, &[], Causes::All).expect("twins");
            twins
                .changes
                .iter()
                .any(|(change, _)| *change == Change::HalfSplit)
        };
        assert!(!has_half(split));
        assert!(has_half(&format!("{split}\nrun.converge = true")));
        let (mut scenario, mut robot) = of(split);
        half_split()(&mut scenario, &mut robot);
        assert_eq!(scenario.world.solver.split_dt_s, Some(5e-4));
    }

    #[test]
    fn the_seed_matters_where_a_sensor_is_noisy() {
        let draws = |lines: &str| is_noisy(&of(lines).0);
        assert!(!draws("sensors.pose.latency_s = 0.1"));
        for noisy in [
            "sensors.pose.position_noise_m = 0.1",
            "sensors.pose.heading_noise_deg = 0.1",
            "sensors.encoders.rate_noise_rad_s = 0.1",
            "sensors.imu = {}",
        ] {
            assert!(draws(noisy), "{noisy}");
        }
    }

    fn of(lines: &str) -> (Scenario, Robot) {
        use ilon_formats::LoadRobot;
        let text = format!("robot.file = \"\"\ntwist.vx_m_s = 0.1\nrun.duration_s = 1\n{lines}");
        let scenario = Scenario::from_toml(&text, "test", "").expect("a scenario");
        let robot = Robot::load("../../../assets/robots/mecanum4.toml").expect("a shipped robot");
        (scenario, robot)
    }
}
