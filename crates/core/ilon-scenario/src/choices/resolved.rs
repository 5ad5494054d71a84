//! A scenario that leaves nothing open, and what was chosen for it.

use std::sync::Arc;

use ilon_control::{ContactKinematics, Kinematics, Reference};
use ilon_robot::{Pose, Robot};
use ilon_trace::{Announced, GroundRelief};
use nalgebra::Vector2;

use super::stability::Stability;
use super::wheel_loop;
use crate::Error;
use crate::course::joint_targets::JointTargets;
use crate::course::playback::Played;
use crate::robot::belief::{self, believed};
use crate::scenario::{Contacts, RollerBodies, Scenario, Step};

/// A scenario that leaves nothing open: every default and everything chosen by the program is spelled out in it.
#[derive(Clone, Debug)]
pub struct Resolved {
    scenario: Scenario,
    choices: Choices,
}

/// What the program chose for a scenario, and what it read and foresaw for it.
#[derive(Clone, Debug)]
pub struct Choices {
    /// The step of physics, in seconds.
    pub physics_dt_s: f64,
    /// The rate that wheels are held to, in rad/s; infinite where there is no limit.
    pub wheel_rate_limit_rad_s: f64,
    /// The path in time that is desired, where there is one.
    pub reference: Option<Reference>,
    /// What a log says.
    pub played: Played,
    /// Where the servos of joints between bodies are sent.
    pub joint_targets: JointTargets,
    /// What the controller takes the robot for, where it does not know it.
    pub believed: Option<Arc<Robot>>,
    /// What is in place of the ground's plane, if something is.
    pub uneven: Option<Arc<GroundRelief>>,
    /// The point of the body frame that follows the reference, in metres.
    pub reference_point_m: Vector2<f64>,
    /// Where its motion asks for more than grip or motors give, as far as that is known beforehand.
    pub announced: Option<Announced>,
    /// What the guidance's gains can be, where it follows a reference and that is known.
    pub stability: Option<Stability>,
    /// Whether the wheel loops cannot settle at the physics step, see [`super::loop_stability`].
    pub has_unstable_loops: bool,
    /// Whether a log asks for wheel rates that contradict each other, which is remarked already.
    pub is_contradictory: bool,
    /// What a person should know about the input, although it can be run.
    pub warnings: Vec<String>,
}

/// The kinematics of a robot as it stands.
///
/// # Errors
/// Where the robot cannot be controlled.
pub fn kinematics_of(robot: &Robot) -> Result<(Kinematics, ContactKinematics), Error> {
    Ok((Kinematics::new(robot)?, ContactKinematics::new(robot)?))
}

impl Resolved {
    /// A scenario and what was chosen for it.
    pub fn new(scenario: Scenario, choices: Choices) -> Self {
        Self { scenario, choices }
    }

    /// The scenario with every default and everything chosen spelled out.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// What was chosen for it.
    pub fn choices(&self) -> &Choices {
        &self.choices
    }

    /// The same run, and its robot, with something changed. All that was chosen stays, such as gains and the path in time; keys of robot and motion,
    /// which choices were made by, have no effect.
    ///
    /// # Errors
    /// Where the scenario asks for something that cannot be then.
    pub fn with(
        &self,
        robot: &Robot,
        change: impl FnOnce(&mut Scenario, &mut Robot),
    ) -> Result<(Self, Robot), Error> {
        let (mut changed, of) = (self.clone(), robot);
        let mut robot = of.clone();
        change(&mut changed.scenario, &mut robot);
        let changed_joints = robot.joints.len() != of.joints.len();
        changed.scenario.validate()?;
        changed.choices.believed = believed(&changed.scenario, &robot)?.map(Arc::new);
        if let Step::Seconds(dt_s) = changed.scenario.run.physics_dt_s {
            changed.choices.physics_dt_s = dt_s;
        }
        if changed_joints {
            let played = &mut changed.choices.played;
            played.joints.retain_mut(|(joint, _)| {
                let name = &of.joints[*joint].name;
                let place = robot.joints.iter().position(|one| one.name == *name);
                *joint = place.unwrap_or(*joint);
                place.is_some()
            });
            changed.choices.joint_targets = JointTargets::new(&changed.scenario, played, &robot)?;
        }
        let section = &mut changed.scenario.wheel_loop;
        if section.law != self.scenario.wheel_loop.law {
            let model = wheel_loop::dynamic_model(&changed.choices.joint_targets.standing(&robot))?;
            wheel_loop::choose_gains(section, &model, changed.choices.physics_dt_s)?;
        }
        let floor = &changed.scenario.world.floor;
        if floor.rough.is_none() && floor.height_map.is_none() {
            changed.choices.uneven = None;
        }
        Ok((changed, robot))
    }

    /// The step of physics, in seconds.
    pub fn physics_dt_s(&self) -> f64 {
        self.choices.physics_dt_s
    }

    /// The period of the control, in seconds: a whole number of physics steps.
    pub fn control_dt_s(&self) -> f64 {
        self.scenario.run.control_dt_s
    }

    /// The rate that wheels are held to, in rad/s; infinite where there is no limit.
    pub fn wheel_rate_limit_rad_s(&self) -> f64 {
        self.choices.wheel_rate_limit_rad_s
    }

    /// The path in time that is desired, where the scenario has a `[reference]`, or a log's path.
    pub fn reference(&self) -> Option<&Reference> {
        self.choices.reference.as_ref()
    }

    /// What the controller takes the robot for: the robot itself, unless the scenario says otherwise.
    pub fn believed<'a>(&'a self, robot: &'a Robot) -> &'a Robot {
        self.choices.believed.as_deref().unwrap_or(robot)
    }

    /// The same in words; `None` where it knows its robot.
    pub fn belief_in_words(&self, robot: &Robot) -> Option<String> {
        let believed = self.choices.believed.as_deref()?;
        let section = self.scenario.controller.robot.as_ref()?;
        Some(belief::in_words(section, robot, believed))
    }

    /// The kinematics of a robot as its servos start it.
    pub fn kinematics(&self, robot: &Robot) -> Result<(Kinematics, ContactKinematics), Error> {
        kinematics_of(&self.choices.joint_targets.standing(robot))
    }

    /// Adds what a person should know, before all else.
    pub fn remark_first(&mut self, remark: String) {
        self.choices.warnings.insert(0, remark);
    }

    /// Where its motion asks for more than grip or motors give, as far as that is known beforehand.
    pub fn announced(&self) -> Option<&Announced> {
        self.choices.announced.as_ref()
    }

    /// The point of the body frame that follows the reference, in metres.
    pub fn reference_point_m(&self) -> Vector2<f64> {
        self.choices.reference_point_m
    }

    /// Where the robot starts.
    pub fn start(&self) -> Pose {
        self.scenario.robot.start()
    }

    /// What a person should know about the input, although it can be run.
    pub fn warnings(&self) -> &[String] {
        &self.choices.warnings
    }

    /// The settings of the world.
    pub fn world_settings(&self) -> ilon_world::Settings {
        let world = &self.scenario.world;
        let solver = &world.solver;
        ilon_world::Settings {
            dt_s: self.choices.physics_dt_s,
            split_dt_s: solver.split_dt_s,
            contacts: match solver.contacts {
                Contacts::Ilon => ilon_world::ContactSolver::Ilon,
                Contacts::Rapier => ilon_world::ContactSolver::Rapier,
            },
            roller_bodies: match self.scenario.robot.roller_bodies {
                RollerBodies::All => ilon_world::RollerBodies::All,
                RollerBodies::Near => ilon_world::RollerBodies::Near,
            },
            contact_stiffness_n_m: solver.contact_stiffness_n_m,
            contact_relaxation_s: solver.contact_relaxation_s,
            gravity_m_s2: world.gravity_m_s2,
        }
    }
}
