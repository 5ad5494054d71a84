//! The robot of a live run.

use ilon_control::{
    Gain, Guidance, GuidanceSettings, Kinematics, Priority, Reference, Saturation, Task,
};
use ilon_robot::{Pose, Robot, Twist};
use ilon_scene::{Contact, Description, Frame, WheelFrame};
use ilon_sim::Scenario;
use ilon_sim::simulate::{Driver, Plant, WheelCommand, load_robot, resolve_for};
use serde::Serialize;

use crate::LiveError;
use crate::control::{self, Controls, Mode};

/// A robot that is driven while it is simulated.
pub struct Session {
    name: String,
    plant: Plant,
    guidance: Guidance,
    settings: GuidanceSettings,
    kinematics: Kinematics,
    reference: Option<Reference>,
    priority: Priority,
    friction: f64,
    control_dt_s: f64,
    start: Pose,
    seed: u64,
    resets: u64,
    /// Simulated time of all drives together, in seconds.
    t_s: f64,
    rates_rad_s: Vec<f64>,
    asked: Twist,
    odometry: Pose,
    last_angles_rad: Vec<f64>,
}

/// What a page shows in figures.
#[derive(Clone, Copy, Debug, Serialize)]
#[non_exhaustive]
pub struct Figures {
    /// Simulated time, in seconds.
    pub t_s: f64,
    /// The twist asked for: vx, vy in m/s, omega in rad/s.
    pub asked: [f64; 3],
    /// The real twist.
    pub real: [f64; 3],
    /// The fastest that any contact slides, in m/s.
    pub slip_m_s: f64,
    /// The largest share of its friction limit that any wheel uses.
    pub friction_used: f64,
    /// How far dead reckoning is off, in metres.
    pub odometry_error_m: f64,
    /// How far the robot is from its reference, in metres; none where it follows none.
    pub reference_error_m: Option<f64>,
}

impl Session {
    /// Puts the scenario's robot into its world.
    ///
    /// # Errors
    /// Where the scenario asks for something that cannot be.
    pub fn new(scenario: &Scenario) -> Result<Self, LiveError> {
        let robot = load_robot(scenario)?;
        let resolved = resolve_for(scenario, &robot, Driver::Own)?;
        let scenario = resolved.scenario();
        let section = &scenario.guidance;
        let priority: Priority = section.priority.into();
        let settings = GuidanceSettings {
            position_gain: Gain::Scalar(section.position_gain_per_s),
            heading_gain: section.heading_gain_per_s,
            wheel_rate_limit_rad_s: resolved.wheel_rate_limit_rad_s(),
            saturation: Saturation::Prioritised(priority),
        };
        let kinematics = Kinematics::new(&robot)?;
        let wheel_count = robot.wheels.len();
        Ok(Self {
            name: scenario.name.clone(),
            plant: Plant::new(&resolved, &robot)?,
            guidance: Guidance::new(kinematics.about(resolved.reference_point_m())?, &settings)?,
            settings,
            kinematics,
            reference: resolved.reference().cloned(),
            priority,
            friction: scenario.world.floor.friction,
            control_dt_s: resolved.control_dt_s(),
            start: resolved.start(),
            seed: scenario.sensors.seed,
            resets: 0,
            t_s: 0.0,
            rates_rad_s: vec![0.0; wheel_count],
            asked: Twist::default(),
            odometry: resolved.start(),
            last_angles_rad: vec![0.0; wheel_count],
        })
    }

    /// The robot.
    pub fn robot(&self) -> &Robot {
        self.plant.robot()
    }

    /// The scenario's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether there is a reference to follow.
    pub fn has_reference(&self) -> bool {
        self.reference.is_some()
    }

    /// The friction of the floor now.
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// What a scene shows of robot and floor.
    pub fn description(&self) -> Description {
        let mut description = Description::of_robot(self.robot(), None);
        description.floor.friction = self.friction as f32;
        description
    }

    /// The control period, in seconds.
    pub fn control_dt_s(&self) -> f64 {
        self.control_dt_s
    }

    /// Goes on by one control period under these controls.
    ///
    /// # Errors
    /// Where the robot's motion is no number any more; it stands at its start then.
    pub fn advance(&mut self, controls: &Controls) -> Result<(), LiveError> {
        if controls.resets != self.resets {
            self.resets = controls.resets;
            self.reset()?;
        }
        self.adopt(controls)?;
        let seen = self.plant.observe();
        let turned: Vec<f64> = seen
            .wheel_angles_rad
            .iter()
            .zip(&self.last_angles_rad)
            .map(|(now, last)| now - last)
            .collect();
        self.odometry = self.odometry.moved(self.kinematics.twist(&turned));
        self.last_angles_rad.copy_from_slice(&seen.wheel_angles_rad);
        let pose = seen.pose;
        let desired = self
            .reference
            .as_ref()
            .filter(|_| controls.mode == Mode::Reference);
        let command = match desired.map(|reference| reference.at(self.plant.time_s())) {
            Some(desired) => self.guidance.update(&pose, &desired),
            None => self.guidance.command(&[Task {
                name: "twist",
                twist_in_body: controls.twist(),
            }]),
        };
        self.rates_rad_s.copy_from_slice(&command.wheel_rates_rad_s);
        self.asked = command.twist_in_body;
        let advanced = self
            .plant
            .advance(WheelCommand::Rates(&self.rates_rad_s), self.control_dt_s);
        if let Err(error) = advanced.map(|_| ()) {
            self.reset()?;
            return Err(error.into());
        }
        self.t_s += self.control_dt_s;
        Ok(())
    }

    /// Takes over what was changed.
    fn adopt(&mut self, controls: &Controls) -> Result<(), LiveError> {
        let wanted = match controls.priority {
            Some(control::Priority::Position) => Priority::Position,
            Some(control::Priority::Heading) => Priority::Heading,
            None => self.priority,
        };
        if wanted != self.priority {
            self.priority = wanted;
            self.settings.saturation = Saturation::Prioritised(wanted);
            let kinematics = self.guidance.kinematics().clone();
            self.guidance = Guidance::new(kinematics, &self.settings)?;
        }
        if let Some(friction) = controls
            .friction
            .filter(|friction| *friction != self.friction)
        {
            self.friction = friction;
            self.plant.set_friction(friction);
        }
        Ok(())
    }

    fn reset(&mut self) -> Result<(), LiveError> {
        self.plant.reset(self.seed, self.start)?;
        self.plant.set_friction(self.friction);
        self.odometry = self.start;
        self.last_angles_rad.fill(0.0);
        Ok(())
    }

    /// The robot now, for a scene.
    pub fn frame(&self) -> Frame {
        let truth = self.plant.truth();
        let world = self.plant.world();
        let wheels = world.contacts().iter().enumerate().map(|(wheel, contact)| {
            let place = contact.place_in_body_m;
            WheelFrame {
                angle_rad: world.wheel_angles_rad()[wheel],
                contact: contact.touching.then_some(Contact {
                    place_m: [place.x, place.y],
                    normal_force_n: contact.normal_force_n,
                    force_n: [contact.force_in_body_n.x, contact.force_in_body_n.y],
                    slip_m_s: [contact.sliding_in_body_m_s.x, contact.sliding_in_body_m_s.y],
                    friction: contact.friction,
                }),
                roller: contact.roller,
                roller_angles_rad: world.roller_angles_rad(wheel).collect(),
            }
        });
        Frame {
            t_s: self.t_s,
            pose: truth.pose,
            height_m: truth.height_m,
            roll_rad: truth.roll_rad,
            pitch_rad: truth.pitch_rad,
            ghost: Some(self.odometry),
            wanted: self
                .reference
                .as_ref()
                .map(|reference| reference.at(self.plant.time_s()).pose),
            wheels: wheels.collect(),
        }
    }

    /// The robot now, in figures.
    pub fn figures(&self, controls: &Controls) -> Figures {
        let truth = self.plant.truth();
        let real = truth.twist_in_body;
        let contacts = || {
            self.plant
                .world()
                .contacts()
                .iter()
                .filter(|contact| contact.touching)
        };
        let used = |contact: &ilon_sim::simulate::WheelContact| {
            let limit_n = contact.friction * contact.normal_force_n;
            if limit_n > 0.0 {
                contact.force_in_body_n.norm() / limit_n
            } else {
                0.0
            }
        };
        let reference = self
            .reference
            .as_ref()
            .filter(|_| controls.mode == Mode::Reference);
        Figures {
            t_s: self.t_s,
            asked: [self.asked.vx_m_s, self.asked.vy_m_s, self.asked.omega_rad_s],
            real: [real.vx_m_s, real.vy_m_s, real.omega_rad_s],
            slip_m_s: contacts()
                .map(|contact| contact.sliding_in_body_m_s.norm())
                .fold(0.0, f64::max),
            friction_used: contacts().map(used).fold(0.0, f64::max),
            odometry_error_m: (self.odometry.position_m() - truth.pose.position_m()).norm(),
            reference_error_m: reference.map(|reference| {
                let desired = reference.at(self.plant.time_s()).pose;
                (desired.position_m() - truth.pose.position_m()).norm()
            }),
        }
    }
}
