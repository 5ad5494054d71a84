//! The loop: a robot under its guidance and wheel loops, in the world, recorded.

mod clock;
mod disturbances;
mod drive;
mod faults;
mod floor;
mod fusion;
mod pilot;
mod recorder;
mod remarks;
mod sensors;
mod tuning;
mod waypoints;

use std::collections::BTreeMap;
use std::convert::Infallible;

use ilon_control::{ContactKinematics, Kinematics};
use ilon_robot::{Pose, Robot};
use ilon_trace::{Header, Recorded, Recording, Summary, Trace, TraceError};
use ilon_world::{MotorTorque, World};

pub use pilot::{Controller, TwistProfile, WheelCommand};
pub use sensors::Seen;

pub use clock::CpuTime;

use crate::remedy;
use crate::scenario::{Motion, RollerBodies, Scenario, Step};
use crate::{Error, judge};
use clock::Clock;
use disturbances::Disturbances;
use drive::Drive;
use faults::Faults;
use pilot::Pilot;
use recorder::Recorder;
use sensors::Sensors;

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

/// A run under way: what is simulated, step by step.
pub struct Simulation {
    scenario: Scenario,
    clock: Clock,
    world: World,
    sensors: Sensors,
    pilot: Pilot,
    drive: Drive,
    faults: Faults,
    disturbances: Disturbances,
    motors: Vec<MotorTorque>,
    recorder: Recorder,
    warnings: Vec<String>,
}

/// Where the scenario puts its robot.
fn start_pose(scenario: &Scenario) -> Pose {
    Pose {
        x_m: scenario.robot.x_m,
        y_m: scenario.robot.y_m,
        heading_rad: scenario.robot.heading_deg.to_radians(),
    }
}

impl Simulation {
    /// Puts the scenario's robot into its world, at rest.
    ///
    /// # Errors
    /// Like [`run`].
    pub fn new(scenario: &Scenario) -> Result<Self, Error> {
        Self::assemble(scenario, &load_robot(scenario)?, None)
    }

    /// Puts a robot into the scenario's world, whatever file the scenario names.
    ///
    /// # Errors
    /// Where the scenario asks for something that cannot be.
    pub fn with_robot(scenario: &Scenario, robot: &Robot) -> Result<Self, Error> {
        Self::assemble(scenario, robot, None)
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
        Self::assemble(scenario, &load_robot(scenario)?, Some(Box::new(controller)))
    }

    fn assemble(
        scenario: &Scenario,
        robot: &Robot,
        controller: Option<Box<dyn Controller>>,
    ) -> Result<Self, Error> {
        scenario.validate()?;
        let mut scenario = scenario.clone();
        let kinematics = Kinematics::new(robot)?;
        let contact_kinematics = ContactKinematics::new(robot)?;

        let limit_rad_s = match scenario.guidance.wheel_rate_limit_rad_s {
            Some(limit_rad_s) => limit_rad_s,
            None => robot.wheel_rate_limit_rad_s(),
        };
        scenario.guidance.wheel_rate_limit_rad_s = limit_rad_s.is_finite().then_some(limit_rad_s);
        let pilot = Pilot::new(
            &scenario,
            kinematics.clone(),
            contact_kinematics.clone(),
            limit_rad_s,
            controller,
        )?;

        let model = drive::dynamic_model(robot)?;
        let physics_dt_s = match scenario.run.physics_dt_s {
            Step::Seconds(dt_s) => dt_s,
            Step::Auto(_) => {
                let split_dt_s = tuning::split_dt_s(&scenario);
                let solver = &mut scenario.world.solver;
                solver.split_dt_s = solver.split_dt_s.or(split_dt_s);
                let asked_rad_s = pilot.fastest_rate_asked_rad_s(&scenario);
                tuning::physics_dt_s(&scenario, robot, &model, asked_rad_s)?
            }
        };
        scenario.run.physics_dt_s = Step::Seconds(physics_dt_s);
        scenario.check_step(physics_dt_s)?;
        let clock = Clock::new(&scenario.run, physics_dt_s);

        let start = start_pose(&scenario);
        let floor = floor::floor(&scenario.world.floor)?;
        let settings = world_settings(&mut scenario, physics_dt_s);
        let world = World::new(robot, &floor, start, &settings)?;

        let drive = Drive::new(
            &mut scenario,
            robot,
            model,
            pilot.reference_point_m(),
            physics_dt_s,
        )?;
        let sensors = Sensors::new(&scenario.sensors, start, &kinematics, &scenario.run)?;

        let mut warnings: Vec<String> = robot.remarks.iter().map(ToString::to_string).collect();
        warnings.extend(remarks::of_friction(&scenario));
        match pilot.feasibility(scenario.run.duration_s) {
            Some(feasibility) => warnings.extend(remarks::of_feasibility(&feasibility)),
            None => {
                let asked_rad_s = pilot.fastest_rate_asked_rad_s(&scenario).unwrap_or(0.0);
                warnings.extend(remarks::of_twist(asked_rad_s, limit_rad_s));
            }
        }

        let header = header(&scenario, robot, &pilot, physics_dt_s, limit_rad_s)?;
        let expect = &scenario.expect;
        let expected = expect.signals.iter().map(|bound| bound.signal.as_str());
        let tolerated = expect.tolerances.keys().map(String::as_str);
        judge::check_names(expected.chain(tolerated), &header)?;
        let recorder = Recorder::new(
            header,
            robot,
            kinematics,
            contact_kinematics,
            start,
            clock.rows(),
        );
        let faults = scenario.faults.clone();
        let disturbances = Disturbances::new(&faults, &scenario.world.floor, robot)?;
        Ok(Self {
            scenario,
            clock,
            world,
            sensors,
            pilot,
            drive,
            faults: Faults::new(&faults, robot)?,
            disturbances,
            motors: vec![MotorTorque::constant(0.0); robot.wheels.len()],
            recorder,
            warnings,
        })
    }

    /// Advances the run by one physics step.
    pub fn step(&mut self) {
        let t_s = self.clock.time_s();
        let control_is_due = self.clock.control_is_due();

        self.sensors
            .sense(t_s, control_is_due, &self.world, &self.faults);
        let seen = self.sensors.seen();
        if control_is_due {
            self.pilot.decide(t_s, seen);
        }
        let torques = self.drive.torques(
            self.pilot.targets(),
            &seen.wheel_rates_rad_s,
            self.faults.supply_share(t_s),
            self.clock.physics_dt_s(),
        );
        self.motors.copy_from_slice(torques);
        for (wheel, motor) in self.motors.iter_mut().enumerate() {
            // A lost motor has no loop either.
            if self.faults.motor_is_lost(t_s, wheel) {
                *motor = MotorTorque::constant(0.0);
            }
        }
        if control_is_due {
            self.recorder.reckon(&seen.wheel_angles_rad);
        }
        if self.clock.record_is_due() {
            let shares = self.drive.shares();
            self.recorder
                .record(t_s, &self.world, seen, &self.pilot, shares);
        }
        self.disturbances
            .act(t_s, self.clock.physics_dt_s(), &mut self.world);
        self.world.drive(&self.motors);
        self.world.step();
        self.recorder.count(&self.world, self.clock.physics_dt_s());
        self.clock.tick();
    }

    /// Whether the run has reached its end.
    pub fn is_done(&self) -> bool {
        self.clock.is_over()
    }

    /// How far the run is.
    pub fn progress(&self) -> Progress {
        Progress {
            time_s: self.clock.time_s(),
            duration_s: self.clock.duration_s(),
        }
    }

    /// What was recorded so far, of a run that keeps it in memory.
    pub fn trace(&self) -> &Trace {
        self.recorder.trace()
    }

    /// The scenario as it is run: every default and everything chosen by the program spelled out.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// The world as it is now.
    pub fn world(&self) -> &World {
        &self.world
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
        mut self,
        mut recording: Recording,
        mut watch: impl FnMut(&Self, &mut Recording) -> Result<(), E>,
    ) -> Result<Run<Recorded>, E> {
        let cpu_s = self.drive_to_the_end(|simulation| {
            recording.take(simulation.recorder.trace_mut())?;
            watch(simulation, &mut recording)
        })?;
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
            if self.clock.control_is_due() {
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
            scenario: self.scenario,
            trace,
            summary,
            warnings: self.warnings,
        }
    }
}

fn load_robot(scenario: &Scenario) -> Result<Robot, Error> {
    let options = scenario
        .robot
        .load_options(&scenario.folder, &scenario.files);
    let path = scenario.resolve(&scenario.robot.file);
    match Robot::load_with(&path, &options) {
        Ok(mut loaded) => {
            scenario.motors.apply(&mut loaded.robot);
            Ok(loaded.robot)
        }
        Err(fault) => Err(remedy::diagnosed(fault, &path, &options, &remedy::Keys)),
    }
}

/// The solver of a scenario, with its defaults written into the scenario.
fn world_settings(scenario: &mut Scenario, physics_dt_s: f64) -> ilon_world::Settings {
    let world = &mut scenario.world;
    let defaults = ilon_world::Settings::default();
    let solver = &mut world.solver;
    let roller_bodies = match scenario.robot.roller_bodies {
        RollerBodies::All => ilon_world::RollerBodies::All,
        RollerBodies::Near => ilon_world::RollerBodies::Near,
    };
    ilon_world::Settings {
        dt_s: physics_dt_s,
        split_dt_s: solver.split_dt_s,
        roller_bodies,
        contact_stiffness_n_m: *solver
            .contact_stiffness_n_m
            .get_or_insert(defaults.contact_stiffness_n_m),
        contact_relaxation_s: *solver
            .contact_relaxation_s
            .get_or_insert(defaults.contact_relaxation_s),
        gravity_m_s2: world.gravity_m_s2,
        ..defaults
    }
}

fn header(
    scenario: &Scenario,
    robot: &Robot,
    pilot: &Pilot,
    physics_dt_s: f64,
    limit_rad_s: f64,
) -> Result<Header, Error> {
    let open_loop = matches!(scenario.motion(), Some(Motion::OpenLoop(_)));
    Ok(Header {
        scenario_name: scenario.name.clone(),
        scenario_toml: scenario.to_toml()?,
        reference_point_m: pilot.reference_point_m().into(),
        task_names: pilot.task_names().iter().map(ToString::to_string).collect(),
        physics_dt_s,
        // Of a trace this is the time between its rows.
        control_dt_s: scenario.run.control_dt_s * f64::from(scenario.run.record_every),
        measure_from_s: pilot.measure_from_s(),
        measure_to_s: scenario.run.duration_s,
        wheel_rate_limit_rad_s: limit_rad_s.is_finite().then_some(limit_rad_s),
        open_loop,
        versions: BTreeMap::from([("ilon".to_owned(), env!("CARGO_PKG_VERSION").to_owned())]),
        ..Header::of_robot(robot)
    })
}
