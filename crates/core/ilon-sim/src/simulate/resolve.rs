//! From a scenario as a person wrote it to one that leaves nothing open.

use std::sync::Arc;

use ilon_control::{ContactKinematics, DynamicModel, Kinematics, Reference};
use ilon_robot::{Pose, Robot};
use ilon_trace::{Announced, GroundRelief};
use nalgebra::Vector2;

use super::belief::{self, believed};
use super::joint_targets::JointTargets;
use super::pilot::{Controller, Idle, Pilot};
use super::playback::{self, Log, Played};
use super::stability::Stability;
use super::{defaults, floor, limits, loop_stability, reference, warnings, wheel_loop};
use crate::Error;
use crate::bearing_drag;
use crate::inspect;
use crate::scenario::{Contacts, Drives, RollerBodies, Rollers, Scenario, Step};
use crate::wheels_to_spare;

/// A scenario that leaves nothing open: every default and everything chosen by the program is spelled out in it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Resolved {
    scenario: Scenario,
    physics_dt_s: f64,
    wheel_rate_limit_rad_s: f64,
    reference: Option<Reference>,
    played: Played,
    joint_targets: JointTargets,
    /// What the controller takes the robot for, where it does not know it.
    believed: Option<Arc<Robot>>,
    uneven: Option<Arc<GroundRelief>>,
    reference_point_m: Vector2<f64>,
    announced: Option<Announced>,
    stability: Option<Stability>,
    has_unstable_loops: bool,
    /// Whether a log asks for wheel rates that contradict each other, which is remarked already.
    is_contradictory: bool,
    warnings: Vec<String>,
}

/// Who decides what the wheels shall do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Driver {
    /// The scenario's `[reference]` under its `[guidance]`, or its `[twist]`.
    Guidance,
    /// A controller of one's own, of which nothing is known beforehand: an automatic step then serves whatever rates the wheels
    /// can reach.
    Own,
}

/// Makes every choice that a scenario leaves to the program but one: a path as fast as grip allows takes the share of grip that the scenario gives, and
/// where it gives none all that the path may take.
///
/// # Errors
/// Like [`resolve`](super::resolve).
pub(super) fn resolve_as_given(
    scenario: &Scenario,
    robot: &Robot,
    driver: Driver,
) -> Result<Resolved, Error> {
    scenario.validate()?;
    let mut scenario = scenario.clone();
    scenario.world.floor.fill();
    let (uneven, of_ground) = floor::uneven(&scenario, robot)?;
    let played = playback::read(&scenario, robot, scenario.robot.start())?;
    let joint_targets = JointTargets::new(&scenario, &played, robot)?;
    let standing = joint_targets.standing(robot);
    let kinematics = Kinematics::new(&standing)?;
    let belief = believed(&scenario, robot)?.map(Arc::new);
    let known = belief.as_deref().unwrap_or(robot);

    let wheel_rate_limit_rad_s = choose_wheel_rate_limit(&mut scenario, robot);
    if let Some(playback) = &mut scenario.playback
        && playback.drives == Drives::WheelAngles
    {
        playback.angle_gain_per_s = Some(playback.angle_gain_per_s());
    }
    wheel_loop::choose_springs(&mut scenario, &standing)?;
    let log = played.log.clone();
    if scenario.run.is_open() {
        scenario.run.duration_s = played.end_s;
        scenario.validate()?;
    }
    let path = log.as_ref().and_then(|log| log.reference()).transpose()?;
    let mut reference = reference::reference_of(&scenario)?.or(path);
    let section = scenario.reference.as_mut();
    let section = section.filter(|section| section.timing.is_some());
    let shares = section.map(|section| {
        let share = section.share_of_limits();
        [*section.share_of_grip.get_or_insert(share), share]
    });
    if let (Some(shares), Some(path)) = (shares, &reference) {
        let of_robot = (robot, &joint_targets);
        reference = Some(limits::fastest(&scenario, of_robot, path, shares)?);
    }
    // What it would decide says how fast the wheels are asked to turn.
    let pilot = Pilot::new(
        &scenario,
        (reference.clone(), log),
        kinematics_of(&joint_targets.standing(known))?,
        known,
        match driver {
            Driver::Guidance => None,
            Driver::Own => Some(Box::new(Idle)),
        },
    )?;

    let model = wheel_loop::dynamic_model(&standing)?;
    let physics_dt_s = choose_step(&mut scenario, robot, (&model, &pilot))?;
    choose_contacts(&mut scenario, robot);
    let of_contacts = scenario.check_contacts(robot)?;
    let loop_period_s = wheel_loop::choose_gains(&mut scenario.wheel_loop, &model, physics_dt_s)?;

    let of_file = robot.remarks.iter().filter(|remark| !remark.is_aside);
    let mut warnings: Vec<String> = of_file.map(ToString::to_string).collect();
    warnings.extend(of_scenario(&scenario, robot, of_ground));
    let unstable_loops = loop_stability::remark(&scenario, &model, physics_dt_s)?;
    warnings.extend(unstable_loops.clone());
    warnings.extend(of_contacts);
    warnings.extend(joint_targets.beyond_rate_limits(robot));
    let beyond = match driver {
        Driver::Guidance => limits::beyond(&scenario, (robot, &joint_targets), &pilot),
        Driver::Own => None,
    };
    warnings.extend(beyond.as_ref().map(|beyond| beyond.remark(robot)));
    let contradiction = pilot.contradiction(&kinematics, scenario.run.duration_s);
    let played_back = contradiction.remark(&kinematics, robot, "the wheel rates of the log");
    let is_contradictory = played_back.is_some();
    warnings.extend(played_back);
    let mut stability = None;
    match pilot.feasibility(scenario.run.duration_s) {
        Some(feasibility) => {
            warnings.extend(warnings::of_feasibility(&feasibility, robot));
            stability = Stability::of(&scenario, &model, loop_period_s);
            if let Some(stability) = &stability {
                warnings.extend(stability.remark(&scenario)?);
            }
        }
        None => {
            let asked_rad_s = pilot.fastest_rate_asked_rad_s(&scenario).unwrap_or(0.0);
            let playback = scenario.playback.as_ref();
            let is_twist = playback.is_none_or(|playback| {
                !matches!(playback.drives, Drives::WheelRates | Drives::WheelAngles)
            });
            warnings.extend(warnings::of_twist(
                asked_rad_s,
                wheel_rate_limit_rad_s,
                is_twist.then_some(scenario.guidance.saturation),
                pilot.held_to_limits(),
            ));
            if matches!(driver, Driver::Guidance) {
                warnings.extend(warnings::of_guidance_in_open_loop(&scenario));
            }
        }
    }
    Ok(Resolved {
        scenario,
        physics_dt_s,
        wheel_rate_limit_rad_s,
        reference,
        played,
        joint_targets,
        believed: belief,
        uneven: uneven.map(Arc::new),
        reference_point_m: pilot.reference_point_m(),
        announced: beyond.map(|beyond| beyond.announced),
        stability,
        has_unstable_loops: unstable_loops.is_some(),
        is_contradictory,
        warnings,
    })
}

fn kinematics_of(robot: &Robot) -> Result<(Kinematics, ContactKinematics), Error> {
    Ok((Kinematics::new(robot)?, ContactKinematics::new(robot)?))
}

/// The wheel rate limit that the scenario or the robot gives, in rad/s; infinite for none. Of wheels with limits of their own the fastest
/// counts, which says how long steps may be.
fn choose_wheel_rate_limit(scenario: &mut Scenario, robot: &Robot) -> f64 {
    let guidance = &mut scenario.guidance;
    let of_wheels = guidance.wheel_rate_limits_rad_s.iter().copied();
    let limit_rad_s = of_wheels
        .reduce(f64::max)
        .or(guidance.wheel_rate_limit_rad_s)
        .unwrap_or_else(|| robot.wheel_rate_limit_rad_s());
    guidance.wheel_rate_limit_rad_s = limit_rad_s.is_finite().then_some(limit_rad_s);
    limit_rad_s
}

/// The step of physics, in seconds, and the parts into which an automatic one is split.
fn choose_step(
    scenario: &mut Scenario,
    robot: &Robot,
    (model, pilot): (&DynamicModel, &Pilot),
) -> Result<f64, Error> {
    let radius_m = defaults::scale_of(scenario, robot).length_m;
    let physics_dt_s = match scenario.run.physics_dt_s {
        Step::Seconds(dt_s) => dt_s,
        Step::Auto(_) => {
            let split_dt_s = defaults::split_dt_s(scenario, robot);
            let solver = &mut scenario.world.solver;
            solver.split_dt_s = solver.split_dt_s.or(split_dt_s);
            let asked_rad_s = pilot.fastest_rate_asked_rad_s(scenario);
            let dt_s = defaults::physics_dt_s(scenario, robot, model, asked_rad_s)?;
            match scenario.longest_step_of_bodies(radius_m) {
                Some((_, longest_s)) if dt_s > longest_s => {
                    let control_dt_s = scenario.run.control_dt_s;
                    control_dt_s / (control_dt_s / longest_s).ceil()
                }
                _ => dt_s,
            }
        }
    };
    scenario.run.physics_dt_s = Step::Seconds(physics_dt_s);
    scenario.check_step(physics_dt_s)?;
    scenario.check_bodies(physics_dt_s, radius_m)?;
    Ok(physics_dt_s)
}

/// How stiff contacts are and how soon they come to rest, where ilon solves them.
fn choose_contacts(scenario: &mut Scenario, robot: &Robot) {
    let scale = defaults::scale_of(scenario, robot);
    let solver = &mut scenario.world.solver;
    if solver.contacts == Contacts::Ilon {
        solver
            .contact_stiffness_n_m
            .get_or_insert_with(|| ilon_world::contact_stiffness_n_m(&scale));
        solver
            .contact_relaxation_s
            .get_or_insert_with(|| ilon_world::contact_relaxation_s(&scale));
    }
}

/// What the scenario alone gives reason to remark, with what its ground has given already.
fn of_scenario(scenario: &Scenario, robot: &Robot, of_ground: Vec<String>) -> Vec<String> {
    let world = &scenario.world;
    let mut remarks = Vec::new();
    if !world.floor.is_of_material() {
        let (friction, gravity_m_s2) = (world.floor.friction(), world.gravity_m_s2);
        remarks.extend(bearing_drag::remarks(robot, friction, gravity_m_s2));
    }
    let barrels = scenario.robot.rollers == Rollers::Barrel;
    if barrels && world.floor.is_plane() && world.solver.contacts == Contacts::Ilon {
        let stiffness_n_m = world.solver.contact_stiffness_n_m;
        remarks.extend(wheels_to_spare::remark(
            robot,
            stiffness_n_m,
            world.gravity_m_s2,
        ));
    }
    remarks.extend(inspect::wrong_hands(robot));
    remarks.extend(of_ground);
    remarks.extend(warnings::of_friction(scenario));
    remarks.extend(warnings::of_what_comes_too_late(scenario));
    remarks.extend(warnings::of_heading(scenario));
    remarks
}

impl Resolved {
    /// The scenario with every default and everything chosen spelled out.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// The same run, and its robot, with something changed. All that was chosen stays, such as gains and the path in time; keys of robot and motion,
    /// which choices were made by, have no effect.
    ///
    /// # Errors
    /// Where the scenario asks for something that cannot be then.
    pub(crate) fn with(
        &self,
        robot: &Robot,
        change: impl FnOnce(&mut Scenario, &mut Robot),
    ) -> Result<(Self, Robot), Error> {
        let (mut changed, of) = (self.clone(), robot);
        let mut robot = of.clone();
        change(&mut changed.scenario, &mut robot);
        let changed_joints = robot.joints.len() != of.joints.len();
        changed.scenario.validate()?;
        changed.believed = believed(&changed.scenario, &robot)?.map(Arc::new);
        if let Step::Seconds(dt_s) = changed.scenario.run.physics_dt_s {
            changed.physics_dt_s = dt_s;
        }
        if changed_joints {
            let played = &mut changed.played;
            played.joints.retain_mut(|(joint, _)| {
                let name = &of.joints[*joint].name;
                let place = robot.joints.iter().position(|one| one.name == *name);
                *joint = place.unwrap_or(*joint);
                place.is_some()
            });
            changed.joint_targets = JointTargets::new(&changed.scenario, played, &robot)?;
        }
        let section = &mut changed.scenario.wheel_loop;
        if section.law != self.scenario.wheel_loop.law {
            let model = wheel_loop::dynamic_model(&changed.joint_targets.standing(&robot))?;
            wheel_loop::choose_gains(section, &model, changed.physics_dt_s)?;
        }
        let floor = &changed.scenario.world.floor;
        if floor.rough.is_none() && floor.height_map.is_none() {
            changed.uneven = None;
        }
        Ok((changed, robot))
    }

    /// The step of physics, in seconds.
    pub fn physics_dt_s(&self) -> f64 {
        self.physics_dt_s
    }

    /// The period of the control, in seconds: a whole number of physics steps.
    pub fn control_dt_s(&self) -> f64 {
        self.scenario.run.control_dt_s
    }

    /// The rate that wheels are held to, in rad/s; infinite where there is no limit.
    pub fn wheel_rate_limit_rad_s(&self) -> f64 {
        self.wheel_rate_limit_rad_s
    }

    /// The path in time that is desired, where the scenario has a `[reference]`, or a log's path.
    pub fn reference(&self) -> Option<&Reference> {
        self.reference.as_ref()
    }

    /// What a log says, where the scenario has a `[playback]`.
    pub(super) fn log(&self) -> Option<Arc<Log>> {
        self.played.log.clone()
    }

    /// What decides the wheel rates: a controller of the caller's, or where there is none the scenario's guidance.
    ///
    /// # Errors
    /// Where this robot cannot be guided so.
    pub(super) fn pilot(
        &self,
        robot: &Robot,
        controller: Option<Box<dyn Controller>>,
    ) -> Result<Pilot, Error> {
        let known = self.believed(robot);
        let tracked = (self.reference.clone(), self.log());
        let kinematics = self.kinematics(known)?;
        Pilot::new(&self.scenario, tracked, kinematics, known, controller)
    }

    /// What the controller takes the robot for: the robot itself, unless the scenario says otherwise.
    pub(super) fn believed<'a>(&'a self, robot: &'a Robot) -> &'a Robot {
        self.believed.as_deref().unwrap_or(robot)
    }

    /// The same in words; `None` where it knows its robot.
    pub(super) fn belief_in_words(&self, robot: &Robot) -> Option<String> {
        let believed = self.believed.as_deref()?;
        Some(belief::in_words(robot, believed))
    }

    /// The kinematics of a robot as its servos start it.
    pub(super) fn kinematics(
        &self,
        robot: &Robot,
    ) -> Result<(Kinematics, ContactKinematics), Error> {
        kinematics_of(&self.joint_targets.standing(robot))
    }

    /// Adds what a person should know, before all else.
    pub(super) fn remark_first(&mut self, remark: String) {
        self.warnings.insert(0, remark);
    }

    /// Where the servos of joints between bodies are sent.
    pub(super) fn joint_targets(&self) -> &JointTargets {
        &self.joint_targets
    }

    /// What is in place of the ground's plane, if something is.
    pub(super) fn uneven(&self) -> Option<&GroundRelief> {
        self.uneven.as_deref()
    }

    /// Where its motion asks for more than grip or motors give, as far as that is known beforehand.
    pub fn announced(&self) -> Option<&Announced> {
        self.announced.as_ref()
    }

    /// What the guidance's gains can be, where it follows a reference and that is known.
    pub(super) fn stability(&self) -> Option<&Stability> {
        self.stability.as_ref()
    }

    /// Whether the wheel loops cannot settle at the physics step, see [`super::loop_stability`].
    pub(super) fn has_unstable_loops(&self) -> bool {
        self.has_unstable_loops
    }

    /// Whether a log asks for wheel rates that contradict each other, which is remarked already.
    pub(super) fn is_contradictory(&self) -> bool {
        self.is_contradictory
    }

    /// The point of the body frame that follows the reference, in metres.
    pub fn reference_point_m(&self) -> Vector2<f64> {
        self.reference_point_m
    }

    /// Where the robot starts.
    pub fn start(&self) -> Pose {
        self.scenario.robot.start()
    }

    /// What a person should know about the input, although it can be run.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Whether the robot is driven without feedback of the pose.
    pub(super) fn is_open_loop(&self) -> bool {
        self.reference.is_none()
    }

    /// The settings of the world.
    pub(super) fn world_settings(&self) -> ilon_world::Settings {
        let world = &self.scenario.world;
        let solver = &world.solver;
        ilon_world::Settings {
            dt_s: self.physics_dt_s,
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
