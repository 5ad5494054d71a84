//! Checks the joints between bodies.

use std::f64::consts::TAU;

use ilon_robot::{BodyJoint, Coupling, JointKind, JointSpring, Robot};

use crate::dynamics::DEEPEST;
use crate::{Settings, WorldError};

/// Refuses joints that do not form a tree, that no step can follow, or with invalid numbers.
pub(super) fn check_joints(robot: &Robot, settings: &Settings) -> Result<(), WorldError> {
    for (index, joint) in robot.joints.iter().enumerate() {
        check_numbers(joint)?;
        holds(
            joint.parent.is_none_or(|parent| parent < index),
            &joint.name,
            "its parent is itself or a later joint: list parents before their children",
        )?;
    }
    for wheel in &robot.wheels {
        holds(
            wheel.carrier.is_none_or(|at| at < robot.joints.len()),
            &wheel.name,
            "its wheel is on a joint that the robot does not have: name one of its joints",
        )?;
    }
    // From here on every path ends at the chassis.
    for (index, joint) in robot.joints.iter().enumerate() {
        let way = std::iter::successors(Some(index), |at| robot.joints[*at].parent);
        let carries_a_wheel = robot
            .wheels
            .iter()
            .any(|wheel| wheel.carrier == Some(index));
        // A wheel's own joint is one more.
        let deep = way.count() + usize::from(carries_a_wheel);
        let words = format!(
            "with it {deep} joints follow one another from the chassis on, a wheel's own among them, of which at most {DEEPEST} may: hold \
             one of them"
        );
        holds(deep <= DEEPEST, &joint.name, words)?;
    }
    for coupling in &robot.couplings {
        check_coupling(robot, coupling)?;
    }
    // A joint also moves the joints coupled to it.
    let mut joints = 0..robot.joints.len();
    joints.try_for_each(|index| check_spring(robot, index, settings))
}

/// Refuses a joint of which something does not hold.
fn holds(holds: bool, joint: &str, reason: impl Into<String>) -> Result<(), WorldError> {
    match holds {
        true => Ok(()),
        false => Err(WorldError::Joint {
            joint: joint.to_owned(),
            reason: reason.into(),
        }),
    }
}

fn check_numbers(joint: &BodyJoint) -> Result<(), WorldError> {
    let mass = &joint.body.mass;
    let is_body =
        is_positive(mass.mass_kg) && mass.principal_moments_kg_m2().iter().all(|i| *i >= 0.0);
    holds(
        is_body,
        &joint.name,
        "it moves a body without mass: give that a mass and an inertia, or hold the joint",
    )?;
    // NaN is not below anything.
    let [lower, upper] = joint.limits;
    let words = format!(
        "its lower limit of {lower} is not below its upper one of {upper}: exchange them, or hold the joint"
    );
    holds(lower < upper, &joint.name, words)?;
    holds(
        not_negative(joint.damping) && not_negative(joint.friction),
        &joint.name,
        "its damping and friction must be finite and not below 0",
    )?;
    check_servo(joint)?;
    let is_spring = |spring: &JointSpring| {
        is_positive(spring.stiffness) && spring.rest.is_finite() && spring.preload.is_finite()
    };
    holds(
        joint.spring().is_none_or(is_spring),
        &joint.name,
        "its spring must have a stiffness above 0, and a rest and a preload that are finite",
    )
}

fn is_positive(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

fn not_negative(value: f64) -> bool {
    value.is_finite() && value >= 0.0
}

/// Refuses an invalid servo, or one whose target its limits exclude.
fn check_servo(joint: &BodyJoint) -> Result<(), WorldError> {
    let Some(servo) = joint.servo() else {
        return Ok(());
    };
    holds(
        is_positive(servo.stiffness),
        &joint.name,
        "its servo must have a stiffness that is finite and above 0",
    )?;
    holds(
        not_negative(servo.damping),
        &joint.name,
        "its servo's damping must be finite and not below 0",
    )?;
    // NaN is not above anything.
    holds(
        servo.effort > 0.0 && servo.rate_limit > 0.0,
        &joint.name,
        "its servo's effort and rate limit must be above 0: a joint that nothing drives is free, sprung or held",
    )?;
    let ([lower, upper], target) = (joint.limits, servo.target);
    let words = format!(
        "its servo's target of {target} is not between its limits of {lower} and {upper}: move it between them"
    );
    let is_within = target.is_finite() && (lower..=upper).contains(&target);
    holds(is_within, &joint.name, words)
}

/// The smallest number of steps per period of a spring: with 1.2 for a joint on another joint, a
/// driving robot becomes unstable, with 1.35 it does not. Chosen.
const STEPS_A_SWING: f64 = 1.5;

/// The longest step in which the springs and servos of a robot's joints can be simulated, in
/// seconds, and the index of the joint that requires it; `None` if no joint has one.
/// [`World::new`](crate::World::new) refuses longer ones: [`WorldError::Joint`].
pub fn longest_step_of_springs_s(robot: &Robot) -> Option<(f64, usize)> {
    let joints = robot.joints.iter().enumerate();
    let springs = joints.filter_map(|(index, joint)| Some((index, joint.gives_by()?)));
    let steps = springs.map(|(index, spring)| {
        let swings_s = swing_s(robot.inertia_on_joint(index), spring.stiffness);
        (swings_s / STEPS_A_SWING, index)
    });
    steps.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The period of a spring with an inertia, in seconds.
fn swing_s(inertia: f64, stiffness: f64) -> f64 {
    TAU * (inertia / stiffness).sqrt()
}

/// Refuses a spring or a servo with too few steps per period.
fn check_spring(robot: &Robot, index: usize, settings: &Settings) -> Result<(), WorldError> {
    let joint = &robot.joints[index];
    let Some(spring) = joint.gives_by() else {
        return Ok(());
    };
    let inertia = robot.inertia_on_joint(index);
    let swings_s = swing_s(inertia, spring.stiffness);
    let least_s = STEPS_A_SWING * settings.dt_s;
    let softest = inertia * (TAU / least_s).powi(2);
    let unit = match joint.kind {
        JointKind::Turns => ("N m/rad", "kg m^2"),
        JointKind::Slides => ("N/m", "kg"),
    };
    holds(
        swings_s >= least_s,
        &joint.name,
        format!(
            "its {} of {} {} swings the {inertia:.3e} {} that it moves once in {:.3} ms, within {STEPS_A_SWING} steps of {:.3} ms: give it less \
             than {softest:.3e}, or hold the joint, or take shorter steps",
            if joint.servo().is_some() {
                "servo"
            } else {
                "spring"
            },
            spring.stiffness,
            unit.0,
            unit.1,
            1e3 * swings_s,
            1e3 * settings.dt_s
        ),
    )
}

fn check_coupling(robot: &Robot, coupling: &Coupling) -> Result<(), WorldError> {
    let Some(joint) = robot.joints.get(coupling.joint) else {
        return Err(WorldError::Joint {
            joint: coupling.joint.to_string(),
            reason: "a coupling names a joint that the robot does not have".to_owned(),
        });
    };
    let by_finite = coupling.factor.is_finite() && coupling.offset.is_finite();
    let of_another = coupling.follows < robot.joints.len() && coupling.follows != coupling.joint;
    holds(
        of_another && by_finite,
        &joint.name,
        "its coupling must follow another joint of the robot, by a finite factor and offset",
    )?;
    let follows = |joint: usize| robot.couplings.iter().find(|of| of.joint == joint);
    let masters = std::iter::successors(Some(coupling), |of| follows(of.follows));
    holds(
        masters.take(robot.couplings.len() + 1).count() <= robot.couplings.len(),
        &joint.name,
        "it follows itself through other couplings: remove one of them",
    )?;
    let of_this = |of: &&Coupling| of.joint == coupling.joint;
    holds(
        robot.couplings.iter().filter(of_this).count() == 1,
        &joint.name,
        "it follows two joints: remove one of the couplings",
    )
}
