//! The robot of a live run.

use std::path::PathBuf;
use std::sync::Arc;

use ilon_control::Reference;
use ilon_formats::{Loaded, link_tree};
use ilon_robot::{Pose, Robot, Twist, VisualMeshes, roll_pitch_yaw};
use ilon_scene::{Contact, Description, Frame, WheelFrame, shapes_of_bodies};
use ilon_sim::simulate::{Driver, Followed, Pilot, Plant, Recorder, load, resolve_for};
use ilon_sim::{Scenario, scenario};
use ilon_trace::{Header, Record, WheelSample};
use serde::Serialize;

use crate::LiveError;
use crate::control::{Command, Controls, Mode, Priority, WATCHDOG};
use crate::recording::{self, Drive, MOST_ROWS};

/// A robot that is driven during its simulation.
pub struct Session {
    scenario: Scenario,
    urdf: Arc<str>,
    looks: VisualMeshes,
    plant: Plant,
    recorder: Recorder,
    pilot: Pilot,
    /// Current settings of the guidance.
    section: scenario::Guidance,
    wheel_rate_limit_rad_s: f64,
    reference: Option<Reference>,
    friction: f64,
    payload_kg: f64,
    control_dt_s: f64,
    duration_s: f64,
    start: Pose,
    seed: u64,
    resets: u64,
    restarts: u64,
    /// Simulated time over all drives, in seconds.
    t_s: f64,
    asked: Twist,
    /// Number of commands, and the simulated time of the last one.
    heard: (u64, f64),
    /// Number of joint commands.
    joints_heard: u64,
    watchdog_acts: bool,
    /// The drive since its recording began, if it is recorded.
    drive: Option<Drive>,
    /// Whether a recording was requested last.
    is_recorded: bool,
    /// The folder of recordings.
    records_into: PathBuf,
    notes: Vec<String>,
}

/// The recorded data at the start of a control period. Times continue over every return to the
/// start.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// The robot.
    pub record: &'a Record,
    /// Its wheels, in the robot's order.
    pub wheels: &'a [WheelSample],
    /// The angles of all rollers, wheel by wheel, in radians, if recorded.
    pub rollers_rad: &'a [Option<f64>],
}

/// The figures on the page.
#[derive(Clone, Copy, Debug, Serialize)]
#[non_exhaustive]
pub struct Figures {
    /// Simulated time, in seconds.
    pub t_s: f64,
    /// The commanded twist: vx, vy in m/s, omega in rad/s.
    pub asked: [f64; 3],
    /// The actual twist.
    pub real: [f64; 3],
    /// The largest sliding speed of a contact, in m/s.
    pub slip_m_s: f64,
    /// The largest used share of the friction limit over all wheels.
    pub friction_used: f64,
    /// Position error of dead reckoning, in metres.
    pub odometry_error_m: f64,
    /// Distance from the reference, in metres; `None` without a reference.
    pub reference_error_m: Option<f64>,
}

impl Session {
    /// Places the scenario's robot in its world.
    ///
    /// # Errors
    /// If the scenario is impossible.
    pub fn new(scenario: &Scenario) -> Result<Self, LiveError> {
        let loaded = load(scenario)?;
        let looks = loaded.visual_meshes();
        let Loaded { robot, urdf, .. } = loaded;
        let resolved = resolve_for(scenario, &robot, Driver::Own)?;
        let scenario = resolved.scenario();
        let plant = Plant::new(&resolved, &robot)?;
        let friction = plant.floor_friction();
        Ok(Self {
            scenario: scenario.clone(),
            recorder: Recorder::of_plant(&plant, &urdf)?,
            urdf,
            looks,
            plant,
            pilot: Pilot::of(&resolved, &robot, None)?,
            reference: resolved.reference().cloned(),
            section: scenario.guidance.clone(),
            wheel_rate_limit_rad_s: resolved.wheel_rate_limit_rad_s(),
            friction,
            payload_kg: 0.0,
            control_dt_s: resolved.control_dt_s(),
            duration_s: resolved.scenario().run.duration_s,
            start: resolved.start(),
            seed: scenario.sensors.seed,
            resets: 0,
            restarts: 0,
            t_s: 0.0,
            asked: Twist::default(),
            heard: (0, 0.0),
            joints_heard: 0,
            watchdog_acts: false,
            drive: None,
            is_recorded: false,
            records_into: PathBuf::from("."),
            notes: Vec::new(),
        })
    }

    /// Sets the folder of recordings; the current one unless set.
    pub fn record_into(&mut self, folder: impl Into<PathBuf>) {
        self.records_into = folder.into();
    }

    /// The robot.
    pub fn robot(&self) -> &Robot {
        self.plant.robot()
    }

    /// The scenario's name.
    pub fn name(&self) -> &str {
        &self.scenario.name
    }

    /// Whether there is a reference to follow.
    pub fn has_reference(&self) -> bool {
        self.reference.is_some()
    }

    /// The current friction of the floor.
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// The current priority of the guidance's tasks; `None` where the scenario sets none: a
    /// reference is then followed position first, and a twist by hand is scaled down as a whole.
    pub fn priority(&self) -> Option<Priority> {
        self.section.priority
    }

    /// The current gains of the guidance's feedback: of position and of heading, in 1/s.
    pub fn gains_per_s(&self) -> [f64; 2] {
        let section = &self.section;
        [section.position_gain_per_s, section.heading_gain_per_s]
    }

    /// Simulated time over all drives, in seconds.
    pub fn time_s(&self) -> f64 {
        self.t_s
    }

    /// Simulated time since the robot was last at its start, in seconds.
    pub fn drive_time_s(&self) -> f64 {
        self.plant.time_s()
    }

    /// Duration of the scenario, in seconds. A live run continues beyond it.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// The header of the robot's recording.
    pub fn header(&self) -> &Header {
        &self.recorder.trace().header
    }

    /// Returns the data of the last control period; `None` before the first, and after a return to
    /// the start.
    pub fn row(&self) -> Option<Row<'_>> {
        let trace = self.recorder.trace();
        let (record, wheels) = trace.steps().next()?;
        Some(Row {
            record,
            wheels,
            rollers_rad: trace.roller_angles_at(0),
        })
    }

    /// The number of returns to the start.
    pub fn restarts(&self) -> u64 {
        self.restarts
    }

    /// Returns the notes since the last call.
    pub fn take_notes(&mut self) -> impl Iterator<Item = String> + use<> {
        std::mem::take(&mut self.notes).into_iter()
    }

    /// Returns the scene's robot and floor.
    pub fn description(&self) -> Description {
        let mut description =
            Description::of_robot(self.robot(), link_tree(&self.urdf).as_ref(), &self.looks);
        description.ground.friction = self.friction;
        let gravity_m_s2 = self.scenario.world.gravity_m_s2;
        description.robot.weight_n = (gravity_m_s2 * self.robot().mass_kg()) as f32;
        description.bodies = shapes_of_bodies(self.header());
        description
    }

    /// The control period, in seconds.
    pub fn control_dt_s(&self) -> f64 {
        self.control_dt_s
    }

    /// Puts the robot back to its start, if these controls request it and it is not done yet.
    ///
    /// # Errors
    /// If the robot cannot be placed there.
    pub fn go_back(&mut self, controls: &Controls) -> Result<(), LiveError> {
        if controls.resets != self.resets {
            self.resets = controls.resets;
            self.reset()?;
        }
        Ok(())
    }

    /// Advances by one control period under these controls.
    ///
    /// # Errors
    /// If the robot's motion becomes NaN; the robot is then at its start.
    pub fn advance(&mut self, controls: &Controls) -> Result<(), LiveError> {
        self.go_back(controls)?;
        self.adopt(controls)?;
        self.record(controls)?;
        if let Some([x_n, y_n]) = controls.push_n() {
            self.plant.push([x_n, y_n, 0.0], None, self.control_dt_s)?;
        }
        self.recorder.trace_mut().clear();
        self.follow(controls)?;
        let t_s = self.plant.time_s();
        let seen = self.plant.observe();
        self.recorder.reckon(&seen.wheel_angles_rad);
        self.pilot.decide(t_s, seen);
        self.plant.steer(self.pilot.steering());
        let decided = self.pilot.decided(t_s, self.plant.truth().pose);
        self.asked = decided.command_twist_in_body;
        if let Some(drive) = &mut self.drive {
            drive.push((t_s, self.asked));
        }
        self.recorder.record(self.t_s, &self.plant, &decided);
        let recorder = &mut self.recorder;
        let advanced =
            self.plant
                .advance_watched(self.pilot.command(), self.control_dt_s, |world, dt_s| {
                    recorder.count(world, dt_s)
                });
        if let Err(error) = advanced.map(|_| ()) {
            self.reset()?;
            return Err(error.into());
        }
        self.t_s += self.control_dt_s;
        Ok(())
    }

    /// Begins or ends the recording, if these controls request it. It begins at the start; its end
    /// writes a scenario, with the floor's friction then.
    fn record(&mut self, controls: &Controls) -> Result<(), LiveError> {
        let is_full = |drive: &Drive| drive.len() >= MOST_ROWS;
        let wanted = controls.records && !self.drive.as_ref().is_some_and(is_full);
        match (wanted, self.drive.take()) {
            (true, None) if !self.is_recorded => {
                self.reset()?;
                self.drive = Some(Drive::new());
            }
            (true, drive) => self.drive = drive,
            (false, Some(drive)) => self.write(drive),
            (false, None) => {}
        }
        self.is_recorded = controls.records;
        Ok(())
    }

    /// Ends a recording that nobody stopped, and writes it.
    pub fn end_recording(&mut self) {
        if let Some(drive) = self.drive.take() {
            self.write(drive);
        }
    }

    /// Writes a recorded drive, and notes the command that repeats it.
    fn write(&mut self, mut drive: Drive) {
        if drive.is_empty() {
            return;
        }
        drive.push((self.plant.time_s(), Twist::default()));
        let mut scenario = self.scenario.clone();
        if self.has_friction() {
            let floor = &mut scenario.world.floor;
            (floor.friction, floor.material) = (Some(self.friction), None);
            let rollers = &mut scenario.rollers;
            (rollers.material, rollers.wheel_materials) = Default::default();
        }
        let written = recording::write(&scenario, &drive, &self.records_into);
        self.notes.push(match written {
            Ok(path) => format!(
                "recorded are the commanded twists, not pushes, payloads and commands of joints; repeat them with: ilon run {}",
                path.display()
            ),
            Err(error) => format!("the drive is not recorded: {error}"),
        });
    }

    /// Has the pilot follow what is asked now: the reference, or the last command. A command expires
    /// when it is older than [`WATCHDOG`] both in real and in simulated time, so it holds in slow,
    /// fast and stepped time.
    fn follow(&mut self, controls: &Controls) -> Result<(), LiveError> {
        if controls.mode == Mode::Reference
            && let Some(reference) = &self.reference
        {
            return Ok(self.pilot.follow(Followed::Reference(reference))?);
        }
        if controls.commands != self.heard.0 {
            self.heard = (controls.commands, self.t_s);
        }
        let (command, age) = controls.last_command();
        let simulated_s = self.t_s - self.heard.1;
        let is_old = age.is_none_or(|age| age >= WATCHDOG && simulated_s >= WATCHDOG.as_secs_f64());
        let moves = match command {
            Command::Twist(twist) => *twist != Twist::default(),
            Command::Wheels(rates) => rates.iter().any(|rate| *rate != 0.0),
        };
        if is_old && age.is_some() && moves && !self.watchdog_acts {
            let limit_s = WATCHDOG.as_secs_f64();
            self.notes
                .push(format!("no command for {limit_s} s: the robot stops"));
        }
        self.watchdog_acts = is_old;
        let rates_rad_s;
        let followed = match command {
            Command::Twist(twist) if !is_old => Followed::Twist(*twist),
            Command::Wheels(asked) if !is_old => {
                rates_rad_s = self.within_limit(asked);
                let rates = rates_rad_s.as_deref();
                rates.map_or(Followed::Twist(Twist::default()), Followed::Rates)
            }
            _ => Followed::Twist(Twist::default()),
        };
        Ok(self.pilot.follow(followed)?)
    }

    /// Wheel rates within their limit, in rad/s, with a note of each that was not; `None` if their
    /// number is not that of the wheels.
    fn within_limit(&mut self, rates_rad_s: &[f64]) -> Option<Vec<f64>> {
        let robot = self.plant.robot();
        let (found, wheels) = (rates_rad_s.len(), robot.wheels.len());
        if found != wheels {
            let name = &robot.name;
            self.notes.push(format!(
                "{found} wheel rates came for {name}, which has {wheels} wheels: it stops"
            ));
            return None;
        }
        let most_rad_s = self.wheel_rate_limit_rad_s;
        let taken = |asked: &f64| asked.clamp(-most_rad_s, most_rad_s);
        for (wheel, asked) in robot.wheels.iter().zip(rates_rad_s) {
            let taken = taken(asked);
            if taken != *asked {
                let name = &wheel.name;
                self.notes.push(format!(
                    "{name} is commanded {asked:.3} rad/s, which is out of range: {taken:.3} rad/s is taken"
                ));
            }
        }
        Some(rates_rad_s.iter().map(taken).collect())
    }

    /// Applies changed settings.
    fn adopt(&mut self, controls: &Controls) -> Result<(), LiveError> {
        let section = &mut self.section;
        let (before, gains) = (
            section.priority,
            [section.position_gain_per_s, section.heading_gain_per_s],
        );
        let wanted = controls.priority.or(before);
        let position = controls.position_gain_per_s.unwrap_or(gains[0]);
        let heading = controls.heading_gain_per_s.unwrap_or(gains[1]);
        if (wanted, [position, heading]) != (before, gains) {
            if wanted != before {
                // A new priority is reported, and with it which task yields.
                section.priority = wanted;
                section.saturation = scenario::Saturation::Prioritised;
                section.tasks.clear();
            }
            if position != gains[0] {
                section.position_gain_matrix_per_s = None;
            }
            (section.position_gain_per_s, section.heading_gain_per_s) = (position, heading);
            self.pilot.tune(&self.section)?;
        }
        if controls.payload_kg != self.payload_kg {
            self.payload_kg = controls.payload_kg;
            self.plant.carry(self.payload_kg)?;
        }
        if let Some(friction) = controls
            .friction
            .filter(|friction| *friction != self.friction)
        {
            self.friction = friction;
            self.plant.set_friction(friction)?;
        }
        for told in controls.joints_since(self.joints_heard) {
            if let Err(refused) = self.plant.command_joints(&[told]) {
                self.notes
                    .push(format!("a command is not taken: {refused}"));
            }
        }
        self.joints_heard = controls.joint_commands();
        Ok(())
    }

    /// Whether a friction was set in place of the scenario's floor and its materials.
    fn has_friction(&self) -> bool {
        self.friction != self.plant.floor_friction()
    }

    fn reset(&mut self) -> Result<(), LiveError> {
        self.plant.reset(self.seed, self.start)?;
        if self.has_friction() {
            self.plant.set_friction(self.friction)?;
        }
        self.plant.carry(self.payload_kg)?;
        self.recorder = Recorder::of_plant(&self.plant, &self.urdf)?;
        self.pilot = Pilot::of(self.plant.resolved(), self.plant.robot(), None)?;
        self.pilot.tune(&self.section)?;
        self.restarts += 1;
        // A recorded drive begins at the start.
        self.drive.iter_mut().for_each(Vec::clear);
        Ok(())
    }

    /// Returns the robot's current state for a scene.
    pub fn frame(&self) -> Frame {
        let truth = self.plant.truth();
        let world = self.plant.world();
        let wheels = world
            .robot()
            .contacts()
            .iter()
            .enumerate()
            .map(|(wheel, contact)| {
                let place = contact.place_in_body_m;
                WheelFrame {
                    angle_rad: world.robot().wheel_angles_rad()[wheel],
                    contact: contact.touching.then_some(Contact {
                        place_m: [place.x, place.y],
                        normal_force_n: contact.normal_force_n,
                        force_n: [contact.force_in_body_n.x, contact.force_in_body_n.y],
                        slip_m_s: [contact.sliding_in_body_m_s.x, contact.sliding_in_body_m_s.y],
                        friction: contact.friction,
                    }),
                    roller: contact.roller,
                    roller_angles_rad: world.robot().roller_angles_rad(wheel).collect(),
                }
            });
        let ids = world.free_bodies().iter().copied();
        let bodies = ids.take(self.header().bodies.len()).filter_map(|id| {
            let state = world.free_body(id)?;
            let [x, y, z] = state.place_m.into();
            let [roll, pitch, yaw] = roll_pitch_yaw(&state.rotation.to_rotation_matrix());
            Some([x, y, z, roll, pitch, yaw])
        });
        Frame {
            bodies: bodies.collect(),
            joints: world.robot().joint_positions().to_vec(),
            t_s: self.t_s,
            pose: truth.pose,
            height_m: truth.height_m,
            roll_rad: truth.roll_rad,
            pitch_rad: truth.pitch_rad,
            ghost: Some(self.recorder.odometry()),
            wanted: self
                .reference
                .as_ref()
                .map(|reference| reference.at(self.plant.time_s()).pose),
            wheels: wheels.collect(),
        }
    }

    /// Returns the current figures.
    pub fn figures(&self, controls: &Controls) -> Figures {
        let truth = self.plant.truth();
        let real = truth.twist_in_body;
        let wheels = &self.plant.outcome().wheels;
        let reference = self
            .reference
            .as_ref()
            .filter(|_| controls.mode == Mode::Reference);
        Figures {
            t_s: self.t_s,
            asked: [self.asked.vx_m_s, self.asked.vy_m_s, self.asked.omega_rad_s],
            real: [real.vx_m_s, real.vy_m_s, real.omega_rad_s],
            slip_m_s: wheels
                .iter()
                .map(|wheel| wheel.sliding_max_m_s)
                .fold(0.0, f64::max),
            friction_used: wheels
                .iter()
                .map(|wheel| wheel.friction_used_max)
                .fold(0.0, f64::max),
            odometry_error_m: (self.recorder.odometry().position_m() - truth.pose.position_m())
                .norm(),
            reference_error_m: reference.map(|reference| {
                let desired = reference.at(self.plant.time_s()).pose;
                (desired.position_m() - truth.pose.position_m()).norm()
            }),
        }
    }
}
