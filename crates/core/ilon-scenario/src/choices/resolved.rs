//! A scenario with nothing left open, and the choices made for it.

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
use crate::scenario::{Scenario, Step};

/// A scenario with nothing left open: every default and every choice of the program is written out.
#[derive(Clone, Debug)]
pub struct Resolved {
    scenario: Scenario,
    choices: Choices,
}

/// The choices of the program for a scenario, and what it read and predicted for it.
#[derive(Clone, Debug)]
pub struct Choices {
    /// Physics step, in seconds.
    pub physics_dt_s: f64,
    /// Whether the program chose it.
    pub chose_step: bool,
    /// Limit of the wheel rates, in rad/s; infinite without one.
    pub wheel_rate_limit_rad_s: f64,
    /// The desired path in time, if there is one.
    pub reference: Option<Reference>,
    /// The data of a log.
    pub played: Played,
    /// The targets of the servos of joints between bodies.
    pub joint_targets: JointTargets,
    /// The robot that the controller believes in, if it differs from the real one.
    pub believed: Option<Arc<Robot>>,
    /// Uneven ground instead of the plane.
    pub uneven: Option<Arc<GroundRelief>>,
    /// The point of the body frame that follows the reference, in metres.
    pub reference_point_m: Vector2<f64>,
    /// The predicted excess of the motion over grip or motors, if there is one.
    pub announced: Option<Announced>,
    /// The limits of the guidance's gains, if it follows a reference and they are known.
    pub stability: Option<Stability>,
    /// Whether the wheel loops are unstable at the physics step, see [`super::loop_stability`].
    pub has_unstable_loops: bool,
    /// Whether a log commands inconsistent wheel rates; that has been remarked already.
    pub is_contradictory: bool,
    /// Warnings about the input, although it can be run.
    pub warnings: Vec<String>,
}

/// The kinematics of a robot at its joints' zero positions.
///
/// # Errors
/// If the robot cannot be controlled.
pub fn kinematics_of(robot: &Robot) -> Result<(Kinematics, ContactKinematics), Error> {
    Ok((Kinematics::new(robot)?, ContactKinematics::new(robot)?))
}

impl Resolved {
    /// Combines a scenario and the choices for it.
    pub fn new(scenario: Scenario, choices: Choices) -> Self {
        Self { scenario, choices }
    }

    /// The scenario with every default and every choice written out.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// The choices for it.
    pub fn choices(&self) -> &Choices {
        &self.choices
    }

    /// The same run and robot with a change. All choices, such as gains and the path in time, stay
    /// as they are; changed keys of robot and motion on which choices depend have no effect. A changed
    /// law of the wheel loops has its own period, gains and step.
    ///
    /// # Errors
    /// If the changed scenario is impossible.
    pub fn with(
        &self,
        robot: &Robot,
        change: impl FnOnce(&mut Scenario, &mut Robot),
    ) -> Result<(Self, Robot), Error> {
        let (mut changed, of) = (self.clone(), robot);
        let mut robot = of.clone();
        change(&mut changed.scenario, &mut robot);
        let changed_joints = robot.joints.len() != of.joints.len()
            || changed.scenario.robot.joints != self.scenario.robot.joints;
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
        if changed.scenario.wheel_loop.law != self.scenario.wheel_loop.law {
            if changed.choices.chose_step {
                changed.scenario.run.physics_dt_s = Step::default();
            }
            wheel_loop::choose_timing(&mut changed.scenario);
            if changed.choices.chose_step {
                // As the changed scenario would choose it: the step divides the period of a torque law.
                let dt_s = &mut changed.choices.physics_dt_s;
                if let Some(period_s) = changed.scenario.wheel_loop.period_s {
                    *dt_s = period_s / (period_s / *dt_s - 1e-9).ceil().max(1.0);
                }
                changed.scenario.run.physics_dt_s = Step::Seconds(*dt_s);
            }
            let model = wheel_loop::dynamic_model(&changed.choices.joint_targets.standing(&robot))?;
            wheel_loop::choose_gains(&mut changed.scenario, &model, changed.choices.physics_dt_s)?;
        }
        let floor = &changed.scenario.world.floor;
        if floor.rough.is_none() && floor.height_map.is_none() {
            changed.choices.uneven = None;
        }
        Ok((changed, robot))
    }

    /// Physics step, in seconds.
    pub fn physics_dt_s(&self) -> f64 {
        self.choices.physics_dt_s
    }

    /// Control period, in seconds: a whole number of physics steps.
    pub fn control_dt_s(&self) -> f64 {
        self.scenario.run.control_dt_s
    }

    /// Limit of the wheel rates, in rad/s; infinite without one.
    pub fn wheel_rate_limit_rad_s(&self) -> f64 {
        self.choices.wheel_rate_limit_rad_s
    }

    /// The desired path in time, if the scenario has a `[reference]` or a log's path.
    pub fn reference(&self) -> Option<&Reference> {
        self.choices.reference.as_ref()
    }

    /// The robot that the controller believes in: the real one, unless the scenario says otherwise.
    pub fn believed<'a>(&'a self, robot: &'a Robot) -> &'a Robot {
        self.choices.believed.as_deref().unwrap_or(robot)
    }

    /// The same in words; `None` if the controller knows the real robot.
    pub fn belief_in_words(&self, robot: &Robot) -> Option<String> {
        let believed = self.choices.believed.as_deref()?;
        let section = self.scenario.controller.robot.as_ref()?;
        Some(belief::in_words(section, robot, believed))
    }

    /// The kinematics of a robot with its servos at their start.
    pub fn kinematics(&self, robot: &Robot) -> Result<(Kinematics, ContactKinematics), Error> {
        kinematics_of(&self.choices.joint_targets.standing(robot))
    }

    /// Adds a warning before all others.
    pub fn remark_first(&mut self, remark: String) {
        self.choices.warnings.insert(0, remark);
    }

    /// The predicted excess of the motion over grip or motors, if there is one.
    pub fn announced(&self) -> Option<&Announced> {
        self.choices.announced.as_ref()
    }

    /// The point of the body frame that follows the reference, in metres.
    pub fn reference_point_m(&self) -> Vector2<f64> {
        self.choices.reference_point_m
    }

    /// The robot's start pose.
    pub fn start(&self) -> Pose {
        self.scenario.robot.start()
    }

    /// Warnings about the input, although it can be run.
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
            contacts: solver.contacts,
            roller_bodies: self.scenario.robot.roller_bodies,
            contact_stiffness_n_m: solver.contact_stiffness_n_m,
            contact_relaxation_s: solver.contact_relaxation_s,
            gravity_m_s2: world.gravity_m_s2,
        }
    }
}
