//! A run in progress.

use std::convert::Infallible;

use ilon_formats::Loaded;
use ilon_robot::{Robot, Twist};
use ilon_trace::{Recorded, Recording, Rows, Sink, Summary, Trace, TraceError, Twin};
use ilon_world::World;

use super::remarks;
use crate::Error;
use crate::causes::{Causes, Path, TwinOutcomes, Twins, has_remedies};
use crate::judge;
use crate::scenario::{self, Scenario};
use crate::simulate::run::{Progress, Run};
use ilon_plant::clock::CpuTime;
use ilon_plant::pilot::Controller;
use ilon_plant::plant::Plant;
use ilon_plant::record::header::Appearance;
use ilon_plant::record::run_loop::RunLoop;
use ilon_plant::resolve::{Driver, resolve, resolve_for};
use ilon_scenario::Resolved;
use ilon_scenario::robot::load;

/// Runs a scenario.
///
/// # Errors
/// If the robot cannot be read, or the scenario is impossible.
pub fn run(scenario: &Scenario) -> Result<Run, Error> {
    Ok(Simulation::new(scenario)?.run())
}

/// Why a run under a caller's controller has no figures at half its step.
const NOT_REPEATED: &str = "`run.converge` has no effect with an external controller, which cannot be started again from the beginning";

/// A run in progress, advanced step by step.
pub struct Simulation {
    run: RunLoop,
    /// The same run with one thing changed each, run in parallel.
    twins: Option<Twins>,
    /// Whether remedies were left out because the run is too long.
    is_untried: bool,
    /// Whether a caller's controller drives it.
    is_foreign: bool,
    warnings: Vec<String>,
}

impl Simulation {
    /// Places the scenario's robot in its world, at rest.
    ///
    /// # Errors
    /// Like [`run`].
    pub fn new(scenario: &Scenario) -> Result<Self, Error> {
        let loaded = load(scenario)?;
        let seen = Appearance::of(&loaded);
        Self::of(
            &resolve(scenario, &loaded.robot)?,
            &loaded.robot,
            seen,
            None,
        )
    }

    /// Places `robot` in the scenario's world, regardless of the file that the scenario names.
    ///
    /// # Errors
    /// If the scenario is impossible.
    pub fn with_robot(scenario: &Scenario, robot: &Robot) -> Result<Self, Error> {
        let resolved = resolve(scenario, robot)?;
        Self::of(&resolved, robot, Appearance::default(), None)
    }

    /// Places a robot that [`load_file`](super::load_file) read before, for this scenario or a
    /// similar one, in the scenario's world.
    ///
    /// # Errors
    /// If the scenario is impossible.
    pub fn with_loaded(scenario: &Scenario, loaded: &Loaded) -> Result<Self, Error> {
        let mut robot = loaded.robot.clone();
        scenario.motors.apply(&mut robot);
        scenario.rollers.apply(&mut robot)?;
        // One of many runs is not drawn, so visual meshes are not read.
        let (resolved, seen) = (resolve(scenario, &robot)?, Appearance::by(&loaded.urdf));
        Self::of(&resolved, &robot, seen, None)
    }

    /// Places the scenario's robot in its world under the caller's controller instead of the
    /// guidance. The scenario's `[reference]` gives that controller the desired motion, and the
    /// summary the motion to measure against.
    ///
    /// # Errors
    /// Like [`run`].
    pub fn with_controller(
        scenario: &Scenario,
        controller: impl Controller + 'static,
    ) -> Result<Self, Error> {
        let loaded = load(scenario)?;
        let resolved = resolve_for(scenario, &loaded.robot, Driver::Own)?;
        let seen = Appearance::of(&loaded);
        Self::of(&resolved, &loaded.robot, seen, Some(Box::new(controller)))
    }

    /// Places `robot` in the scenario's world under the caller's controller, regardless of the file
    /// that the scenario names.
    ///
    /// # Errors
    /// If the scenario is impossible.
    pub fn with_robot_and_controller(
        scenario: &Scenario,
        robot: &Robot,
        controller: impl Controller + 'static,
    ) -> Result<Self, Error> {
        let resolved = resolve_for(scenario, robot, Driver::Own)?;
        let seen = Appearance::default();
        Self::of(&resolved, robot, seen, Some(Box::new(controller)))
    }

    /// Places the scenario's robot in its world, at rest, for a person to [`steer`](Self::steer).
    /// The scenario's motion and expectations are ignored.
    ///
    /// # Errors
    /// Like [`run`].
    pub fn steered(scenario: &Scenario) -> Result<Self, Error> {
        let scenario = Scenario {
            reference: None,
            playback: scenario
                .playback
                .clone()
                .filter(|playback| playback.drives == scenario::Drives::Joints),
            twist: Some(scenario::Twist::default()),
            expect: scenario::Expect::default(),
            // A steered run cannot be repeated.
            run: scenario::Run {
                converge: false,
                ..scenario.run.clone()
            },
            ..scenario.clone()
        };
        let loaded = load(&scenario)?;
        let seen = Appearance::of(&loaded);
        // The wheel rates that will be commanded are unknown.
        let resolved = resolve_for(&scenario, &loaded.robot, Driver::Own)?;
        let mut steered = Self::of(&resolved, &loaded.robot, seen, None)?;
        steered.steer(Twist::default());
        Ok(steered)
    }

    /// Commands a twist of a [`steered`](Self::steered) robot: of its body's origin, in the body
    /// frame, from the next control period on. It is converted to wheel rates like a `[twist]`.
    pub fn steer(&mut self, twist_in_body: Twist) {
        self.run.pilot.steer(twist_in_body);
    }

    /// Combines a plant, its driver and its recorder.
    fn of(
        resolved: &Resolved,
        robot: &Robot,
        seen: Appearance,
        controller: Option<Box<dyn Controller>>,
    ) -> Result<Self, Error> {
        let scenario = resolved.scenario();
        let mut warnings = resolved.warnings().to_vec();
        let is_foreign = controller.is_some();
        if is_foreign && scenario.run.converge {
            warnings.push(NOT_REPEATED.to_owned());
        }
        let run = RunLoop::new(resolved, robot, seen, controller)
            .map_err(|error| scenario.source.placed(error))?;
        let expect = &scenario.expect;
        let expected = expect.signals.iter().map(|bound| bound.signal.as_str());
        let tolerated = expect.tolerances.keys().map(String::as_str);
        judge::check_names(expected.chain(tolerated), &run.recorder.trace().header)
            .map_err(|error| scenario.source.placed(error))?;
        let stands = run.plant.world().robot().joint_positions();
        warnings.extend(remarks::of_joints(run.plant.robot(), stands));
        let simulation = Self {
            run,
            twins: None,
            is_untried: false,
            is_foreign,
            warnings,
        };
        Ok(simulation.explaining(Causes::None))
    }

    /// Removes causes from the run, one at a time, in twins that run in parallel. The effects are
    /// in the summary's `effects` and in the trace's header. A run under a caller's controller has
    /// no twins, because that controller cannot be restarted.
    pub fn explaining(mut self, causes: Causes) -> Self {
        if !self.is_foreign {
            let (resolved, robot) = (self.run.plant.resolved(), self.run.plant.robot());
            let stands = self.run.joint_positions();
            self.twins = Twins::of(resolved, robot, &self.trace().header, stands, causes);
        }
        self
    }

    /// Advances the run by one physics step, or by a part of one where something begins or ends within it.
    pub fn step(&mut self) {
        self.run.step();
    }

    /// Whether the run has reached its end.
    pub fn is_done(&self) -> bool {
        self.run.plant.clock().is_over()
    }

    /// The progress of the run.
    pub fn progress(&self) -> Progress {
        Progress {
            time_s: self.run.plant.clock().time_s(),
            duration_s: self.run.plant.clock().duration_s(),
        }
    }

    /// The trace so far, if the run keeps it in memory.
    pub fn trace(&self) -> &Trace {
        self.run.recorder.trace()
    }

    /// The scenario of the run, with every default and every choice of the program written out.
    pub fn scenario(&self) -> &Scenario {
        self.run.plant.resolved().scenario()
    }

    /// The simulated plant, without its driver.
    pub fn plant(&self) -> &Plant {
        &self.run.plant
    }

    /// The current state of the world.
    pub fn world(&self) -> &World {
        self.run.plant.world()
    }

    /// Warnings about the input, although it can be run.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Runs to the end.
    pub fn run(self) -> Run {
        self.run_observed(|_| ())
    }

    /// Runs to the end and reports progress once a control period.
    pub fn run_observed(self, mut observe: impl FnMut(Progress)) -> Run {
        let watched = self.run_watched(|simulation| {
            observe(simulation.progress());
            Ok::<(), Infallible>(())
        });
        match watched {
            Ok(run) => run,
            Err(never) => match never {},
        }
    }

    /// Runs to the end and passes itself to `watch` once a control period; an error of `watch` ends
    /// the run.
    ///
    /// # Errors
    /// The first error of `watch`.
    pub fn run_watched<E>(
        mut self,
        mut watch: impl FnMut(&Self) -> Result<(), E>,
    ) -> Result<Run, E> {
        let (cpu_s, twins) = self.drive_beside_twins(|simulation| watch(simulation))?;
        let mut trace = self.run.recorder.take_trace();
        trace.header.twins = twins;
        let summary = Summary::of(&trace, &ilon_trace::Settings::default());
        Ok(self.finish(trace, summary, cpu_s))
    }

    /// Runs to the end into a recording, so that memory does not grow with the length of the run.
    /// Passes itself and the recording to `watch` once a control period; an error of `watch` ends
    /// the run.
    ///
    /// # Errors
    /// The first error of `watch`, and [`TraceError`] if the recording cannot be written.
    pub fn run_recorded<E: From<TraceError>>(
        self,
        recording: Recording,
        watch: impl FnMut(&Self, &mut Recording) -> Result<(), E>,
    ) -> Result<Run<Recorded>, E> {
        self.run_recorded_beside(recording, &mut [], watch)
    }

    /// Like [`Simulation::run_recorded`]; the rows also go to other sinks.
    ///
    /// # Errors
    /// Like [`Simulation::run_recorded`], and those of a sink.
    pub fn run_recorded_beside<E: From<TraceError>>(
        mut self,
        mut recording: Recording,
        sinks: &mut [&mut dyn Sink],
        mut watch: impl FnMut(&Self, &mut Recording) -> Result<(), E>,
    ) -> Result<Run<Recorded>, E> {
        sinks.begin(&self.trace().header)?;
        let (cpu_s, twins) = self.drive_beside_twins(|simulation| {
            let rows = simulation.run.recorder.trace_mut();
            sinks.take(rows)?;
            recording.take(rows)?;
            watch(simulation, &mut recording)
        })?;
        sinks.finish()?;
        recording.add_twins(twins);
        let recorded = recording.finish()?;
        let summary = Summary::of_rows(&recorded, &ilon_trace::Settings::default())?;
        Ok(self.finish(recorded, summary, cpu_s))
    }

    /// Steps until the run is done, in parallel with its twins if it has any; returns the twins'
    /// outcomes too.
    fn drive_beside_twins<E>(
        &mut self,
        watch: impl FnMut(&mut Self) -> Result<(), E>,
    ) -> Result<(Option<f64>, Vec<Twin>), E> {
        let mut path = Path::of(self.scenario().run.control_periods(), 1);
        let twins = self.twins.take();
        let drive = || self.drive_to_the_end(&mut path, watch);
        let (cpu_s, came) = match twins {
            Some(twins) => twins.beside(drive)?,
            None => (drive()?, TwinOutcomes::default()),
        };
        self.is_untried = came.is_untried;
        Ok((cpu_s, came.beside(&path)))
    }

    /// Steps until the run is done; returns its CPU time in seconds, if the system reports it.
    fn drive_to_the_end<E>(
        &mut self,
        path: &mut Path,
        mut watch: impl FnMut(&mut Self) -> Result<(), E>,
    ) -> Result<Option<f64>, E> {
        let cpu = CpuTime::now();
        loop {
            if self.run.control_is_due() {
                path.look(&self.run);
                watch(self)?;
            }
            if self.is_done() {
                return Ok(cpu.elapsed_s());
            }
            self.step();
        }
    }

    fn finish<T: Rows>(mut self, trace: T, mut summary: Summary, cpu_s: Option<f64>) -> Run<T> {
        let resolved = self.run.plant.resolved();
        let remarks = remarks::of_summary(&summary, resolved.choices().has_unstable_loops);
        self.warnings.extend(remarks);
        if !resolved.choices().is_contradictory {
            let remark = self
                .run
                .recorder
                .contradiction_remark(self.run.plant.robot());
            self.warnings.extend(remark);
        }
        self.warnings.extend(remarks::of_bodies(
            self.run.plant.robot(),
            self.run.plant.world(),
        ));
        // Rows that cannot be read are reported where they are needed.
        let missed = remarks::of_missed_patches(&trace).ok().flatten();
        let untouched = remarks::of_untouched_bodies(&trace).ok().flatten();
        self.warnings.extend(missed.into_iter().chain(untouched));
        let twins = &trace.header().twins;
        if self.is_untried && has_remedies(self.scenario(), &summary) {
            self.warnings.push(
                "to save time no advice was tried; help: `ilon explain` with this scenario tries it"
                    .to_owned(),
            );
        }
        let was_asked = self.scenario().run.converge;
        let remarks = remarks::of_convergence(&summary.converge, twins, was_asked);
        self.warnings.extend(remarks);
        summary.sim_seconds_per_cpu_second = cpu_s
            .filter(|cpu_s| *cpu_s > 0.0)
            .map(|cpu_s| summary.duration_s / cpu_s);
        Run {
            scenario: self.run.plant.resolved().scenario().clone(),
            trace,
            summary,
            warnings: self.warnings,
        }
    }
}
