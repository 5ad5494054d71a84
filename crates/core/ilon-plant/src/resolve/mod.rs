//! Converts a scenario as written by a person to one that leaves nothing open.

mod fastest;
mod warnings;

pub use fastest::{resolve, resolve_for};

use std::sync::Arc;

use ilon_control::{DynamicModel, Kinematics, PathTracking, Reference};
use ilon_robot::{Robot, Twist, Wheel};
use ilon_trace::GroundRelief;

use crate::ground::floor;
use crate::limits;
use crate::pilot::{Controller, Idle, Pilot, TwistProfile};
use ilon_scenario::choices::stability::Stability;
use ilon_scenario::choices::{
    bearing_drag, defaults, kinematics_of, loop_stability, odd_wheel, wheel_loop, wheels_to_spare,
    wrong_hands,
};
use ilon_scenario::course::joint_targets::JointTargets;
use ilon_scenario::course::playback::{self, Played};
use ilon_scenario::course::reference;
use ilon_scenario::robot::belief::believed;
use ilon_scenario::scenario::{
    Contacts, Drives, Playback, Reference as Path, Rollers, Scenario, Step,
};
use ilon_scenario::{Choices, Error, Resolved};

/// The source of the commands to the wheels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Driver {
    /// The scenario's `[reference]` under its `[guidance]`, or its `[twist]`.
    Guidance,
    /// A caller's controller, whose demand is unknown: an automatic step then serves all rates that
    /// the wheels can reach.
    Own,
}

/// Makes every choice except the share of grip of a path as fast as grip allows: that is the share
/// that the scenario gives, by default the largest that the path may use.
///
/// # Errors
/// Like [`resolve`](fastest::resolve).
pub(crate) fn resolve_as_given(
    scenario: &Scenario,
    robot: &Robot,
    driver: Driver,
) -> Result<Resolved, Error> {
    scenario.validate()?;
    let mut scenario = scenario.clone();
    scenario.world.floor.fill();
    wheel_loop::choose_timing(&mut scenario);
    let inputs = Inputs::read(&scenario, robot)?;
    let wheel_rate_limit_rad_s = choose_wheel_rate_limit(&mut scenario, robot);
    choose_angle_gain(&mut scenario);
    wheel_loop::choose_springs(&mut scenario, &inputs.standing)?;
    choose_duration(&mut scenario, &inputs.played)?;
    let reference = choose_reference(&mut scenario, robot, &inputs)?;
    if let Driver::Guidance = driver {
        refuse_sideways(&scenario, reference.as_ref(), (robot, &inputs.kinematics))?;
    }
    let pilot = inputs.pilot(&scenario, reference.clone(), robot, driver)?;
    let model = wheel_loop::dynamic_model(&inputs.standing)?;
    let chose_step = matches!(scenario.run.physics_dt_s, Step::Auto(_));
    let physics_dt_s = choose_step(&mut scenario, robot, (&model, &pilot))?;
    choose_contacts(&mut scenario, robot);
    let of_contacts = scenario.check_contacts(robot)?;
    let chooses_gain = scenario.wheel_loop.proportional_n_m_s.is_none();
    let loop_period_s = wheel_loop::choose_gains(&mut scenario, &model, physics_dt_s)?;

    let of_file = robot.remarks.iter().filter(|remark| !remark.is_aside);
    let mut warnings: Vec<String> = of_file.map(ToString::to_string).collect();
    warnings.extend(of_scenario(&scenario, robot, &inputs.of_ground));
    let unstable_loops = loop_stability::remark(&scenario, &model, physics_dt_s)?;
    warnings.extend(unstable_loops.clone());
    let lowered = || loop_stability::lowered(&scenario, &model).filter(|_| chooses_gain);
    let of_bandwidth = || warnings::of_bandwidth(&scenario, &model, loop_period_s, chooses_gain);
    warnings.extend(lowered().or_else(of_bandwidth));
    warnings.extend(of_contacts);
    warnings.extend(inputs.played.warnings());
    warnings.extend(inputs.joint_targets.beyond_rate_limits(robot));
    warnings.extend(warnings::of_toe(robot, &inputs.kinematics));
    warnings.extend(pilot.beyond_steering());
    warnings.extend(pilot.beyond_steering_rates(scenario.run.duration_s));
    warnings.extend(pilot.heading_beside_path(scenario.run.duration_s));
    let beyond = match driver {
        Driver::Guidance => limits::beyond(&scenario, (robot, &inputs.joint_targets), &pilot),
        Driver::Own => None,
    };
    warnings.extend(beyond.as_ref().map(|beyond| beyond.remark(robot)));
    let contradiction = pilot.contradiction(&inputs.kinematics, scenario.run.duration_s);
    let played_back = contradiction.remark(&inputs.kinematics, robot, "the wheel rates of the log");
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
        None => warnings.extend(of_open_loop(
            &scenario,
            &pilot,
            wheel_rate_limit_rad_s,
            driver,
        )),
    }
    let choices = Choices {
        physics_dt_s,
        chose_step,
        wheel_rate_limit_rad_s,
        reference,
        played: inputs.played,
        joint_targets: inputs.joint_targets,
        believed: inputs.believed,
        uneven: inputs.uneven.map(Arc::new),
        reference_point_m: pilot.reference_point_m(),
        announced: beyond.map(|beyond| beyond.announced),
        stability,
        has_unstable_loops: unstable_loops.is_some(),
        is_contradictory,
        warnings,
    };
    Ok(Resolved::new(scenario, choices))
}

/// Refuses motions that tyres exclude which are not steered: a twist sideways, a reference where
/// they only let the robot turn about a point, and a pose to its side.
fn refuse_sideways(
    scenario: &Scenario,
    followed: Option<&Reference>,
    (robot, kinematics): (&Robot, &Kinematics),
) -> Result<(), Error> {
    /// Of a speed, in metres, or in radians: numbers of a file are rounded.
    const ROUNDED: f64 = 1e-3;
    if kinematics.is_omnidirectional() {
        return Ok(());
    }
    let is_fixed = |wheel: &&Wheel| wheel.has_tyre() && robot.steering_of(wheel).is_none();
    let fixed = robot.wheels.iter().filter(is_fixed);
    let names: Vec<String> = fixed.map(|wheel| format!("`{}`", wheel.name)).collect();
    let names = names.join(", ");
    if let Some(reference) = followed {
        // With one direction of axles the path is tracked along it.
        let gain_per_s = scenario.guidance.position_gain_per_s;
        let Some(law) = PathTracking::new(kinematics, gain_per_s)? else {
            return Err(Error::invalid(
                format!(
                    "no reference can be followed: {names} have axles of several directions that nothing steers"
                ),
                "drive it by [twist] or [playback]",
            ));
        };
        if let Some(key) = warnings::unused_by_tracking(&scenario.guidance) {
            return Err(Error::invalid(
                format!(
                    "`guidance.{key}` has no effect: {names} are not steered, and the middle of their axles follows the reference by a law whose one gain is \
                     `guidance.position_gain_per_s`"
                ),
                format!("leave `guidance.{key}` out, or set `guidance.position_gain_per_s`"),
            ));
        }
        let [_, aside_m, off_rad] = law.error(&scenario.robot.start(), &reference.path_at(0.0));
        let of = scenario.reference.as_ref().map(|section| &section.path);
        let is_pose = matches!(of, Some(Path::HoldPose { .. }));
        if is_pose && aside_m.abs().max(off_rad.abs()) > ROUNDED {
            return Err(Error::invalid(
                format!(
                    "`reference.hold_pose` cannot be reached: it is {:.3} m to the side of the robot at its start and {:.1} deg off its heading, and {names} are \
                     not steered: with no path that moves, the robot only drives straight ahead or back",
                    aside_m.abs(),
                    off_rad.to_degrees().abs()
                ),
                "let it start at the pose's heading, with the pose straight ahead or behind, or give a path there: `[reference.waypoints]` with `heading = \
                 \"along_path\"`",
            ));
        }
        return Ok(());
    }
    let Some(section) = &scenario.twist else {
        return Ok(());
    };
    // What a turn about an axle off the origin moves the origin by is no motion sideways.
    let sideways = TwistProfile::new(section).held().find(|twist| {
        let linear = Twist::new(twist.vx_m_s, twist.vy_m_s, 0.0);
        let off_m_s = kinematics.sideways_m_s(linear);
        let is_meant = kinematics.sideways_m_s(*twist) > ROUNDED * off_m_s;
        off_m_s > kinematics.allowed_aside() * linear.linear_m_s().norm() && is_meant
    });
    let Some(twist) = sideways else {
        return Ok(());
    };
    Err(Error::invalid(
        format!(
            "`twist` asks for vx_m_s = {} and vy_m_s = {}, which drags tyres sideways: {names} are not steered",
            twist.vx_m_s, twist.vy_m_s
        ),
        "leave the motion along their axles out",
    ))
}

/// The contents of a scenario's files, and what follows from them and the robot alone.
struct Inputs {
    uneven: Option<GroundRelief>,
    /// Warnings about the ground.
    of_ground: Vec<String>,
    played: Played,
    joint_targets: JointTargets,
    /// The robot with its servos at their start.
    standing: Robot,
    kinematics: Kinematics,
    /// The robot that the controller believes in, if it differs from the real one.
    believed: Option<Arc<Robot>>,
}

impl Inputs {
    fn read(scenario: &Scenario, robot: &Robot) -> Result<Self, Error> {
        let (uneven, of_ground) = floor::uneven(scenario, robot)?;
        let played = playback::read(scenario, robot, scenario.robot.start())?;
        let joint_targets = JointTargets::new(scenario, &played, robot)?;
        let standing = joint_targets.standing(robot);
        Ok(Self {
            uneven,
            of_ground,
            played,
            joint_targets,
            kinematics: Kinematics::new(&standing)?,
            standing,
            believed: believed(scenario, robot)?.map(Arc::new),
        })
    }

    /// The pilot of the run, which predicts the fastest commanded wheel rates.
    fn pilot(
        &self,
        scenario: &Scenario,
        reference: Option<Reference>,
        robot: &Robot,
        driver: Driver,
    ) -> Result<Pilot, Error> {
        let known = self.believed.as_deref().unwrap_or(robot);
        let controller: Option<Box<dyn Controller>> = match driver {
            Driver::Guidance => None,
            Driver::Own => Some(Box::new(Idle)),
        };
        let kinematics = kinematics_of(&self.joint_targets.standing(known))?;
        let tracked = (reference, &self.played);
        Pilot::new(scenario, tracked, kinematics, known, controller)
    }
}

/// Chooses the gain with which wheels follow the angles of a log.
fn choose_angle_gain(scenario: &mut Scenario) {
    if let Some(playback) = &mut scenario.playback
        && playback.drives == Drives::WheelAngles
    {
        playback.angle_gain_per_s = Some(playback.angle_gain_per_s());
    }
}

/// Chooses the duration of the run: by default that of its log.
fn choose_duration(scenario: &mut Scenario, played: &Played) -> Result<(), Error> {
    if scenario.run.is_open() {
        scenario.run.duration_s = played.end_s;
        scenario.validate()?;
    }
    Ok(())
}

/// The desired path in time, of the scenario or of its log; as fast as grip and motors allow, if
/// the scenario asks for that.
fn choose_reference(
    scenario: &mut Scenario,
    robot: &Robot,
    inputs: &Inputs,
) -> Result<Option<Reference>, Error> {
    let log = inputs.played.log.as_ref();
    let path = log.and_then(|log| log.reference()).transpose()?;
    let reference = reference::reference_of(scenario)?.or(path);
    let section = scenario.reference.as_mut();
    let section = section.filter(|section| section.timing.is_some());
    let shares = section.map(|section| {
        let share = section.share_of_limits();
        [*section.share_of_grip.get_or_insert(share), share]
    });
    match (shares, &reference) {
        (Some(shares), Some(path)) => {
            let of_robot = (robot, &inputs.joint_targets);
            limits::fastest(scenario, of_robot, path, shares).map(Some)
        }
        _ => Ok(reference),
    }
}

/// Chooses the wheel rate limit from the scenario or the robot, in rad/s; infinite for none. For
/// wheels with different limits the fastest counts, because it determines the step.
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

/// Chooses the physics step, in seconds, and the parts into which an automatic one is split.
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

/// Chooses stiffness and relaxation of contacts, if ilon solves them.
fn choose_contacts(scenario: &mut Scenario, robot: &Robot) {
    let scale = defaults::scale_of(scenario, robot);
    let solver = &mut scenario.world.solver;
    if solver.contacts == Contacts::Ilon {
        solver
            .contact_stiffness_n_m
            .get_or_insert_with(|| ilon_world::contact_stiffness_of_robot_n_m(robot, &scale));
        solver
            .contact_relaxation_s
            .get_or_insert_with(|| ilon_world::contact_relaxation_s(&scale));
    }
}

/// Warnings from the scenario alone, including those about its ground.
fn of_scenario(scenario: &Scenario, robot: &Robot, of_ground: &[String]) -> Vec<String> {
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
    remarks.extend(wrong_hands(robot));
    // What the controller believes is seen by its effects, and wheels that a log drives are no
    // command of ours.
    let drives_wheels = |of: &Playback| {
        let drives = of.drives;
        matches!(
            drives,
            Drives::WheelRates | Drives::WheelAngles | Drives::WheelTorques
        )
    };
    let is_played = scenario.playback.as_ref().is_some_and(drives_wheels);
    if scenario.controller.robot.is_none() && !is_played {
        remarks.extend(odd_wheel(robot));
    }
    remarks.extend_from_slice(of_ground);
    remarks.extend(warnings::of_friction(scenario));
    remarks.extend(warnings::of_what_comes_too_late(scenario));
    remarks.extend(warnings::of_heading(scenario));
    remarks
}

/// Warnings about an open-loop motion of a scenario.
fn of_open_loop(
    scenario: &Scenario,
    pilot: &Pilot,
    wheel_rate_limit_rad_s: f64,
    driver: Driver,
) -> Vec<String> {
    let asked_rad_s = pilot.fastest_rate_asked_rad_s(scenario).unwrap_or(0.0);
    let playback = scenario.playback.as_ref();
    let is_twist = playback.is_none_or(|playback| {
        !matches!(playback.drives, Drives::WheelRates | Drives::WheelAngles)
    });
    let too_fast = warnings::of_twist(
        asked_rad_s,
        wheel_rate_limit_rad_s,
        is_twist.then_some(scenario.guidance.saturation),
        pilot.held_to_limits(),
    );
    let unused = match driver {
        Driver::Guidance => warnings::of_guidance_in_open_loop(scenario),
        Driver::Own => None,
    };
    too_fast.into_iter().chain(unused).collect()
}

#[cfg(test)]
mod tests {
    use ilon_scenario::robot::load_robot;

    use super::*;

    const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");

    /// A box that reaches 0.25 m with a wheel's 0.05 m must not pass a wheel at 100 m/s: 2.5 ms,
    /// and less than the 3.3 ms of this robot alone.
    #[test]
    fn an_automatic_step_is_as_short_as_fast_bodies_need() {
        let text = "robot.file = \"mecanum4.urdf\"\ntwist.vx_m_s = 0.1\nrun.duration_s = 1\n";
        let body = "[[world.bodies]]\nname = 'b'\nbox.size_m = [0.2, 0.3, 0.4]\nmass_kg = 2\n\
                    x_m = 9\ny_m = 0\nvx_m_s = -60\nvz_m_s = 80\n";
        let step_s = |text: &str| {
            let scenario = Scenario::from_toml(text, "fast", ROBOTS).expect("a scenario");
            let robot = load_robot(&scenario).expect("a shipped robot");
            let resolved = resolve_for(&scenario, &robot, Driver::Guidance);
            resolved.expect("it can be simulated").physics_dt_s()
        };
        assert!(step_s(text) > 0.25 / 100.0);
        assert!(step_s(&format!("{text}{body}")) <= 0.25 / 100.0);
    }
}
