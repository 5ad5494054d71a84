//! Requested roles of joints that carry wheels or move an arm or a lift.

use super::loading::Loading;
use super::tree::{Motion, TreeJoint};
use crate::error::{Fault, RobotError};
use crate::options::{JointNumbers, JointOptions, RoleOption};
use ilon_robot::{JointRole, JointServo, JointSpring};

/// The role of a joint that moves.
#[derive(Clone, Debug)]
pub(super) struct Role {
    pub(super) role: JointRole,
    pub(super) damping: f64,
    pub(super) friction: f64,
    /// A servo's stiffness and damping, as far as given.
    pub(super) gains: [Option<f64>; 2],
    /// The reason why it moves, as text.
    pub(super) why: String,
}

/// Returns the requested role of a joint; `None` if it should be locked.
pub(super) fn asked(
    loading: &Loading,
    joint: usize,
    options: &JointOptions,
) -> Result<Option<Role>, RobotError> {
    let of = &loading.tree.joints[joint];
    role_of(of, options).map_err(|words| refused(loading, joint, words))
}

fn role_of(of: &TreeJoint, options: &JointOptions) -> Result<Option<Role>, String> {
    if of.motion == Motion::Other && !of.slides {
        return Err(
            "it floats or moves in a plane; give it a role where it turns or slides along one axis"
                .to_owned(),
        );
    }
    let numbers = options.numbers(of.slides)?;
    let JointNumbers {
        stiffness,
        damping,
        rest,
        preload,
        friction,
        ..
    } = numbers;
    let unit = if of.slides { "n_m" } else { "n_m_rad" };
    refuse_servo_keys(options.role, &numbers, of.slides)?;
    let role = match (options.role, stiffness) {
        (Some(RoleOption::Driven), _) => return driven(of, &numbers).map(Some),
        (Some(RoleOption::Held), None) if damping.or(rest).or(preload).or(friction).is_none() => {
            return Ok(None);
        }
        (Some(RoleOption::Held), _) => {
            return Err("it is held, and what it is given else says how it moves: leave that out, or make it `sprung`".to_owned());
        }
        (Some(RoleOption::Sprung), None) => {
            return Err(format!(
                "it is sprung without a stiffness: gravity would run it to its stop; give it `stiffness_{unit}`"
            ));
        }
        (Some(RoleOption::Free), None) if rest.or(preload).is_none() => JointRole::Free,
        (Some(RoleOption::Free), _) => {
            return Err(
                "it is free, and has a spring: leave the spring out, or make it `sprung`"
                    .to_owned(),
            );
        }
        (Some(RoleOption::Sprung) | None, Some(stiffness)) => JointRole::Sprung(JointSpring {
            stiffness,
            rest: rest.unwrap_or(0.0),
            preload: preload.unwrap_or(0.0),
        }),
        (None, None) => {
            return Err(format!(
                "nobody says what it does: give it a `role`, or `stiffness_{unit}`"
            ));
        }
    };
    let says = if let JointRole::Sprung(spring) = role {
        let unit = if of.slides { "N/m" } else { "N m/rad" };
        format!("sprung, {} {unit}", spring.stiffness)
    } else {
        "free".to_owned()
    };
    Ok(Some(Role {
        role,
        damping: damping.unwrap_or(of.losses.damping_n_m_s),
        friction: friction.unwrap_or(of.losses.friction_n_m),
        gains: [None; 2],
        why: format!("{says}: as set"),
    }))
}

/// Rejects servo keys for a joint without a servo.
fn refuse_servo_keys(
    role: Option<RoleOption>,
    numbers: &JointNumbers,
    slides: bool,
) -> Result<(), String> {
    let [effort, rate, target] = if slides {
        ["effort_n", "rate_limit_m_s", "target_m"]
    } else {
        ["effort_n_m", "rate_limit_rad_s", "target_rad"]
    };
    let given = [
        (effort, numbers.effort),
        (rate, numbers.rate_limit),
        (target, numbers.target),
    ];
    match given.into_iter().find(|(_, value)| value.is_some()) {
        Some((key, _)) if role != Some(RoleOption::Driven) => Err(format!(
            "it has a servo's `{key}` and no servo: write role = \"driven\", or leave `{key}` out"
        )),
        _ => Ok(()),
    }
}

/// Returns the role of a joint driven by a servo; missing gains are chosen later.
fn driven(of: &TreeJoint, numbers: &JointNumbers) -> Result<Role, String> {
    if numbers.rest.or(numbers.preload).is_some() {
        return Err(
            "it is driven, and has the rest or the preload of a spring: a servo goes to its target; leave them out, or make it \
             `sprung`"
                .to_owned(),
        );
    }
    let target = numbers.target.unwrap_or(0.0);
    let [lower, upper] = of.travel;
    if !(lower..=upper).contains(&target) && lower < upper {
        let key = if of.slides { "target_m" } else { "target_rad" };
        return Err(format!(
            "its servo begins at {target}, beyond its limits of {lower} and {upper}: give it a first setpoint, or `{key}`, between them"
        ));
    }
    let velocity = of.limits.velocity_rad_s;
    Ok(Role {
        role: JointRole::Driven(JointServo {
            effort: numbers.effort.unwrap_or(of.limits.effort_n_m),
            rate_limit: numbers.rate_limit.unwrap_or(velocity),
            target,
            // Gains are set once all moving joints are known.
            ..JointServo::for_inertia(0.0)
        }),
        damping: of.losses.damping_n_m_s,
        friction: numbers.friction.unwrap_or(of.losses.friction_n_m),
        gains: [numbers.stiffness, numbers.damping],
        why: String::new(),
    })
}

/// The error of a joint that cannot have its requested role.
pub(super) fn refused(loading: &Loading, joint: usize, reason: String) -> RobotError {
    let name = &loading.tree.joints[joint].name;
    loading
        .source
        .joint_error(name, Fault::JointRole { reason })
}
