//! The loop: a plant, what drives it, and what records it.

mod clock;
mod disturbances;
mod drive;
mod faults;
mod floor;
mod footings;
mod fusion;
mod pilot;
mod plant;
mod playback;
mod recorder;
mod reference;
mod remarks;
mod resolve;
mod sensors;
mod stability;
mod tuning;
mod twist_profile;
mod waypoints;

use std::collections::BTreeMap;
use std::convert::Infallible;

use ilon_control::{ContactKinematics, Kinematics};
use ilon_robot::{Loaded, Looks, Robot};
use ilon_trace::{Header, MotorLine, Recorded, Recording, Sink, Summary, Trace, TraceError};
pub use ilon_world::WheelContact;
use ilon_world::World;

pub use pilot::{Commanded, Controller, Moment};
pub use plant::{Outcome, Plant, Snapshot, WheelCommand};
pub use recorder::{Decided, Recorder};
pub use resolve::{Driver, Resolved, resolve, resolve_for};
pub use sensors::Seen;
pub use twist_profile::TwistProfile;

pub use clock::CpuTime;
pub use floor::relief_heights_m;

use crate::remedy;
use crate::scenario::{self, Scenario};
use crate::{Error, judge};
use pilot::Pilot;

/// A finished run, with its trace in memory or, of a run of any length, as it was [`Recorded`].
#[derive(Clone, Debug)]
pub struct Run<T = Trace> {
    /// The scenario as it was run: every default and everything chosen by the program spelled out.
    pub scenario: Scenario,
    /// What was recorded.
    pub trace: T,
    /// The figures of the run.
    pub summary: Summary,
    /// What a person should know about the input, although it could be run.
    pub warnings: Vec<String>,
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// Simulated time, in seconds.
    pub time_s: f64,
    /// Simulated time at the end of the run, in seconds.
    pub duration_s: f64,
}

/// Runs a scenario.
///
/// # Errors
/// Where the robot cannot be read, or the scenario asks for something that cannot be.
pub fn run(scenario: &Scenario) -> Result<Run, Error> {
    Ok(Simulation::new(scenario)?.run())
}

impl Plant {
    /// The plant of a scenario, with the robot that the scenario names: [`load_robot`], [`resolve_for`] anybody's commands,
    /// and [`Plant::new`] in one.
    ///
    /// # Errors
    /// Where the robot's file or the scenario makes no sense, or the robot cannot stand where it starts.
    pub fn of_scenario(scenario: &Scenario) -> Result<Self, Error> {
        let robot = load_robot(scenario)?;
        Self::new(&resolve_for(scenario, &robot, Driver::Own)?, &robot)
    }
}

/// By what a robot is seen, for the header of its trace.
#[derive(Default)]
pub(crate) struct Appearance<'a> {
    urdf: &'a str,
    looks: Looks,
}

impl<'a> Appearance<'a> {
    /// By the shapes in its file alone.
    fn by(urdf: &'a str) -> Self {
        Self {
            urdf,
            looks: Looks::default(),
        }
    }

    fn of(loaded: &'a Loaded) -> Self {
        Self {
            urdf: &loaded.urdf,
            looks: loaded.looks(),
        }
    }
}

/// A run under way: what is simulated, step by step.
pub struct Simulation {
    plant: Plant,
    pilot: Pilot,
    recorder: Recorder,
    warnings: Vec<String>,
}

impl Simulation {
    /// Puts the scenario's robot into its world, at rest.
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

    /// Puts a robot into the scenario's world, whatever file the scenario names.
    ///
    /// # Errors
    /// Where the scenario asks for something that cannot be.
    pub fn with_robot(scenario: &Scenario, robot: &Robot) -> Result<Self, Error> {
        Self::of(
            &resolve(scenario, robot)?,
            robot,
            Appearance::default(),
            None,
        )
    }

    /// Puts a robot that [`load_file`] read before, for this scenario or one like it, into the scenario's world.
    ///
    /// # Errors
    /// Where the scenario asks for something that cannot be.
    pub fn with_loaded(scenario: &Scenario, loaded: &Loaded) -> Result<Self, Error> {
        let mut robot = loaded.robot.clone();
        scenario.motors.apply(&mut robot);
        scenario.rollers.apply(&mut robot)?;
        // One of many runs is not looked at: meshes that nobody sees are not read.
        Self::of(
            &resolve(scenario, &robot)?,
            &robot,
            Appearance::by(&loaded.urdf),
            None,
        )
    }

    /// Puts the scenario's robot into its world under a controller of one's own, in place of the guidance. The
    /// scenario's `[reference]` tells that controller what is desired, and the summary what to measure against.
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

    /// A plant, what drives it, and what records it.
    fn of(
        resolved: &Resolved,
        robot: &Robot,
        seen: Appearance,
        controller: Option<Box<dyn Controller>>,
    ) -> Result<Self, Error> {
        let scenario = resolved.scenario();
        let kinematics = Kinematics::new(robot)?;
        let contact_kinematics = ContactKinematics::new(robot)?;
        let pilot = Pilot::new(
            scenario,
            (resolved.reference().cloned(), resolved.log()),
            (kinematics.clone(), contact_kinematics.clone()),
            robot,
            controller,
        )?;
        let plant = Plant::new(resolved, robot)?;
        let header = header(resolved, robot, seen, &pilot)?;
        let expect = &scenario.expect;
        let expected = expect.signals.iter().map(|bound| bound.signal.as_str());
        let tolerated = expect.tolerances.keys().map(String::as_str);
        judge::check_names(expected.chain(tolerated), &header)?;
        let recorder = Recorder::new(
            header,
            robot,
            kinematics,
            contact_kinematics,
            resolved.start(),
            scenario.run.row_count() as usize,
            scenario.run.roller_angles_hz,
        );
        Ok(Self {
            warnings: resolved.warnings().to_vec(),
            plant,
            pilot,
            recorder,
        })
    }

    /// Advances the run by one physics step.
    pub fn step(&mut self) {
        let clock = *self.plant.clock();
        let t_s = clock.time_s();
        if clock.control_is_due() {
            let seen = self.plant.observe();
            self.pilot.decide(t_s, seen);
            self.recorder.reckon(&seen.wheel_angles_rad);
        }
        self.plant.actuate(self.pilot.command());
        if clock.record_is_due() {
            let decided = self.pilot.decided(t_s, self.plant.truth().pose);
            self.recorder.record(t_s, &self.plant, &decided);
        }
        self.plant.step();
        self.recorder
            .count(self.plant.world(), clock.physics_dt_s());
    }

    /// Whether the run has reached its end.
    pub fn is_done(&self) -> bool {
        self.plant.clock().is_over()
    }

    /// How far the run is.
    pub fn progress(&self) -> Progress {
        Progress {
            time_s: self.plant.clock().time_s(),
            duration_s: self.plant.clock().duration_s(),
        }
    }

    /// What was recorded so far, of a run that keeps it in memory.
    pub fn trace(&self) -> &Trace {
        self.recorder.trace()
    }

    /// The scenario as it is run: every default and everything chosen by the program spelled out.
    pub fn scenario(&self) -> &Scenario {
        self.plant.resolved().scenario()
    }

    /// What is simulated, apart from what drives it.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The world as it is now.
    pub fn world(&self) -> &World {
        self.plant.world()
    }

    /// What a person should know about the input, although it can be run.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Runs to the end.
    pub fn run(self) -> Run {
        self.run_observed(|_| ())
    }

    /// Runs to the end and tells of its progress once a control period.
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

    /// Runs to the end and shows itself once a control period; ends early where it is told so.
    ///
    /// # Errors
    /// What `watch` gives, as soon as it does.
    pub fn run_watched<E>(
        mut self,
        mut watch: impl FnMut(&Self) -> Result<(), E>,
    ) -> Result<Run, E> {
        let cpu_s = self.drive_to_the_end(|simulation| watch(simulation))?;
        let trace = self.recorder.take_trace();
        let summary = Summary::of(&trace, &ilon_trace::Settings::default());
        Ok(self.finish(trace, summary, cpu_s))
    }

    /// Runs to the end into a recording, so that memory does not grow with the length of the run; shows itself and the
    /// recording once a control period, and ends early where it is told so.
    ///
    /// # Errors
    /// What `watch` gives, as soon as it does, and [`TraceError`] where the recording cannot be written.
    pub fn run_recorded<E: From<TraceError>>(
        self,
        recording: Recording,
        watch: impl FnMut(&Self, &mut Recording) -> Result<(), E>,
    ) -> Result<Run<Recorded>, E> {
        self.run_recorded_beside(recording, &mut [], watch)
    }

    /// Like [`Simulation::run_recorded`]; the rows go into other sinks too.
    ///
    /// # Errors
    /// Like [`Simulation::run_recorded`], and what a sink gives.
    pub fn run_recorded_beside<E: From<TraceError>>(
        mut self,
        mut recording: Recording,
        sinks: &mut [&mut dyn Sink],
        mut watch: impl FnMut(&Self, &mut Recording) -> Result<(), E>,
    ) -> Result<Run<Recorded>, E> {
        sinks.begin(&self.trace().header)?;
        let cpu_s = self.drive_to_the_end(|simulation| {
            let rows = simulation.recorder.trace_mut();
            sinks.take(rows)?;
            recording.take(rows)?;
            watch(simulation, &mut recording)
        })?;
        sinks.finish()?;
        let recorded = recording.finish()?;
        let summary = Summary::of_rows(&recorded, &ilon_trace::Settings::default())?;
        Ok(self.finish(recorded, summary, cpu_s))
    }

    /// Steps until the run is done; gives the CPU time that it took, in seconds, if the system tells.
    fn drive_to_the_end<E>(
        &mut self,
        mut watch: impl FnMut(&mut Self) -> Result<(), E>,
    ) -> Result<Option<f64>, E> {
        let cpu = CpuTime::now();
        while !self.is_done() {
            if self.plant.clock().control_is_due() {
                watch(self)?;
            }
            self.step();
        }
        watch(self)?;
        Ok(cpu.elapsed_s())
    }

    fn finish<T>(mut self, trace: T, mut summary: Summary, cpu_s: Option<f64>) -> Run<T> {
        self.warnings.extend(remarks::of_summary(&summary));
        summary.sim_seconds_per_cpu_second = cpu_s
            .filter(|cpu_s| *cpu_s > 0.0)
            .map(|cpu_s| summary.duration_s / cpu_s);
        Run {
            scenario: self.plant.resolved().scenario().clone(),
            trace,
            summary,
            warnings: self.warnings,
        }
    }
}

/// Reads the robot of a scenario, with the motors and the rollers' surfaces that the scenario gives it.
///
/// # Errors
/// [`Error::Robot`], with all that is wrong with the file and which keys would do.
pub fn load_robot(scenario: &Scenario) -> Result<Robot, Error> {
    load(scenario).map(|loaded| loaded.robot)
}

/// Like [`load_robot`]; keeps the text that the robot was read from.
///
/// # Errors
/// Like [`load_robot`].
pub fn load(scenario: &Scenario) -> Result<Loaded, Error> {
    let mut loaded = load_file(scenario)?;
    scenario.motors.apply(&mut loaded.robot);
    scenario.rollers.apply(&mut loaded.robot)?;
    Ok(loaded)
}

/// Reads the robot of a scenario as its file, and the scenario's `[robot]`, have it.
///
/// # Errors
/// Where the file cannot be read, or is no robot that ilon can drive.
pub fn load_file(scenario: &Scenario) -> Result<Loaded, Error> {
    let options = scenario
        .robot
        .load_options(&scenario.folder, &scenario.files);
    let path = scenario.resolve(&scenario.robot.file);
    match Robot::load_with(&path, &options) {
        Ok(loaded) => Ok(loaded),
        Err(fault) => Err(remedy::diagnosed(fault, &path, &options, &remedy::Keys)),
    }
}

fn header(
    resolved: &Resolved,
    robot: &Robot,
    seen: Appearance,
    pilot: &Pilot,
) -> Result<Header, Error> {
    let scenario = resolved.scenario();
    let limit_rad_s = resolved.wheel_rate_limit_rad_s();
    Ok(Header {
        scenario_name: scenario.name.clone(),
        scenario_toml: scenario.to_toml()?,
        reference_point_m: pilot.reference_point_m().into(),
        task_names: pilot.task_names().iter().map(ToString::to_string).collect(),
        physics_dt_s: resolved.physics_dt_s(),
        control_dt_s: scenario.run.control_dt_s,
        record_every: scenario.run.record_every,
        control_periods: scenario.run.control_periods(),
        measure_from_s: pilot.measure_from_s(),
        measure_to_s: scenario.run.duration_s,
        wheel_rate_limit_rad_s: limit_rad_s.is_finite().then_some(limit_rad_s),
        open_loop: resolved.is_open_loop(),
        roller_angles: scenario.run.roller_angles_hz.is_some(),
        measured: pilot.is_measured(),
        urdf: seen.urdf.to_owned(),
        looks: seen.looks,
        ground: Some(floor::ground(scenario, robot)?),
        faults: Some(faults::recorded(&scenario.faults, robot)?),
        guidance: pilot
            .follows_reference()
            .then(|| stability::guidance(scenario)),
        motor_line: scenario.motors.dc.map(|dc| MotorLine {
            stall_torque_n_m: dc.stall_torque_n_m,
            no_load_rate_rad_s: dc.no_load_rate_rad_s,
            current_limit_n_m: dc.current_limit_n_m,
        }),
        commands_by_contact: scenario.guidance.kinematics == scenario::Kinematics::Contact,
        versions: BTreeMap::from([("ilon".to_owned(), env!("CARGO_PKG_VERSION").to_owned())]),
        ..Header::of_robot(robot)
    })
}
