//! Which joints beside wheels and rollers move, and the bodies that they move.
//!
//! A joint is *free* where it carries wheels that balance on either side of its axis and nothing drives it, as a rocker; *sprung* where a person
//! says so; and else *held* at zero, a part of what carries it.

use std::collections::HashSet;

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::check;
use super::from_options::Given;
use super::loading::Loading;
use super::recognise::Candidate;
use super::transmission;
use super::tree::{Motion, Tree};
use crate::error::{Fault, RobotError};
use crate::options::{JointOptions, RoleOption};
use ilon_robot::{Body, BodyJoint, Coupling, JointKind, JointRole, JointSpring, Remark, Wheel};

/// Joints that may follow one another from the chassis to a wheel's own.
const DEEPEST: usize = 3;

/// The joints of the file that move bodies, parents before their children.
#[derive(Debug, Default)]
pub(super) struct Linkage {
    joints: Vec<(usize, Role)>,
}

#[derive(Clone, Debug)]
struct Role {
    role: JointRole,
    damping: f64,
    friction: f64,
    /// Why it moves, in words.
    why: String,
}

impl Linkage {
    /// The joints, by their numbers in the tree.
    pub(super) fn joints(&self) -> impl Iterator<Item = usize> {
        self.joints.iter().map(|(joint, _)| *joint)
    }

    fn place_of(&self, joint: usize) -> Option<usize> {
        self.joints().position(|other| other == joint)
    }
}

/// Decides which joints move.
pub(super) fn decide(
    loading: &Loading,
    candidates: &[Candidate],
    given: &[Given],
) -> Result<Linkage, RobotError> {
    let tree = loading.tree;
    let wheels_and_rollers = moving(candidates, given);
    refuse_strangers(loading, &wheels_and_rollers)?;
    let hubs: Vec<usize> = candidates
        .iter()
        .map(|candidate| candidate.hub)
        .chain(given.iter().map(|given| given.like.joint))
        .collect();
    let driven: HashSet<usize> = transmission::drives(loading.source, tree)
        .keys()
        .filter_map(|name| tree.joints.iter().position(|joint| joint.name == *name))
        .collect();
    let mut linkage = Linkage::default();
    for (joint, above) in from_the_top(tree) {
        let is_wheel = wheels_and_rollers.contains(&joint);
        let in_wheel = above.iter().any(|at| wheels_and_rollers.contains(at));
        if is_wheel || in_wheel || tree.joints[joint].motion == Motion::Fixed {
            continue;
        }
        let carried: Vec<usize> = hubs
            .iter()
            .copied()
            .filter(|hub| joints_above(tree, *hub).contains(&joint))
            .collect();
        let options = loading.options.joints.get(&tree.joints[joint].name);
        let role = match options {
            Some(options) => asked(loading, joint, options)?,
            None => default_role(tree, joint, &carried, &driven),
        };
        let Some(role) = role else { continue };
        check_joint(loading, joint)?;
        let deep = above.iter().filter(|at| linkage.place_of(**at).is_some());
        if deep.count() >= DEEPEST {
            return Err(refused(
                loading,
                joint,
                format!(
                    "it would be the {}th joint that moves on the way from the chassis; at most {DEEPEST} may follow one another: hold \
                     one of them",
                    DEEPEST + 1
                ),
            ));
        }
        linkage.joints.push((joint, role));
    }
    Ok(linkage)
}

/// The joints that move: wheels and rollers.
pub(super) fn moving(candidates: &[Candidate], given: &[Given]) -> HashSet<usize> {
    candidates
        .iter()
        .flat_map(|c| c.rollers.iter().copied().chain([c.hub]))
        .chain(given.iter().map(|g| g.like.joint))
        .collect()
}

/// The bodies and what couples their joints, and on which of them each wheel hangs.
pub(super) fn assemble(
    loading: &mut Loading,
    linkage: &Linkage,
    moving: &HashSet<usize>,
    wheels: &mut [Wheel],
) -> Result<(Vec<BodyJoint>, Vec<Coupling>), RobotError> {
    let tree = loading.tree;
    let mut joints = Vec::with_capacity(linkage.joints.len());
    for (joint, role) in &linkage.joints {
        let of = &tree.joints[*joint];
        let body = tree.rigid_body(of.child, |j| moving.contains(&j));
        body.remark_held(
            tree,
            &format!("joint `{}`", of.name),
            &[],
            &mut loading.remarks,
        );
        if body.mass.is_none() {
            let words = format!(
                "it moves link `{}`, which has no mass: give it an `<inertial>`, or hold the joint",
                tree.links[of.child].name
            );
            return Err(refused(loading, *joint, words));
        }
        let collisions = check::chassis(loading, body)?;
        let body_from_joint = frame(of.origin.coords, &of.axis);
        let above = joints_above(tree, *joint);
        joints.push(BodyJoint {
            name: of.name.clone(),
            parent: above.iter().find_map(|at| linkage.place_of(*at)),
            kind: if of.slides {
                JointKind::Slides
            } else {
                JointKind::Turns
            },
            body_from_joint,
            body: Body {
                name: collisions.name,
                mass: collisions.mass.moved(&body_from_joint.inverse()),
                collisions: collisions.collisions,
            },
            role: role.role,
            limits: of.travel,
            damping: role.damping,
            friction: role.friction,
        });
        let subject = format!("joint `{}`", of.name);
        loading.remarks.push(Remark::new(subject, role.why.clone()));
    }
    for wheel in wheels {
        let hub = tree
            .joints
            .iter()
            .position(|joint| joint.name == wheel.name);
        let above = hub.map(|hub| joints_above(tree, hub)).unwrap_or_default();
        wheel.carrier = above.iter().find_map(|at| linkage.place_of(*at));
    }
    Ok((joints, couplings(tree, linkage)))
}

/// Mimic joints of which both move.
fn couplings(tree: &Tree, linkage: &Linkage) -> Vec<Coupling> {
    let coupling = |(place, (joint, _)): (usize, &(usize, Role))| {
        let mimic = tree.joints[*joint].mimic.as_ref()?;
        let master = tree.joints.iter().position(|of| of.name == mimic.joint)?;
        Some(Coupling {
            joint: place,
            follows: linkage.place_of(master).filter(|other| *other != place)?,
            factor: mimic.multiplier,
            offset: mimic.offset,
        })
    };
    let joints = linkage.joints.iter().enumerate();
    joints.filter_map(coupling).collect()
}

/// A joint's frame: its z along the axis.
fn frame(origin_m: Vector3<f64>, axis: &Vector3<f64>) -> Isometry3<f64> {
    // The axis of the body frame that is least along it.
    let helper = Vector3::ith(axis.iamin(), 1.0);
    let x = helper.cross(axis).normalize();
    let rotation = Matrix3::from_columns(&[x, axis.cross(&x), *axis]);
    let rotation = Rotation3::from_matrix_unchecked(rotation);
    Isometry3::from_parts(
        Translation3::from(origin_m),
        UnitQuaternion::from_rotation_matrix(&rotation),
    )
}

/// All joints, those above before those below, each with the joints above it, the nearest first.
fn from_the_top(tree: &Tree) -> Vec<(usize, Vec<usize>)> {
    let mut found = Vec::with_capacity(tree.joints.len());
    let mut waiting: Vec<(usize, Vec<usize>)> = vec![(tree.root, Vec::new())];
    while let Some((link, above)) = waiting.pop() {
        for &joint in &tree.links[link].joints_below {
            let below = [joint].into_iter().chain(above.iter().copied()).collect();
            waiting.push((tree.joints[joint].child, below));
            found.push((joint, above.clone()));
        }
    }
    // Breadth and depth aside, a parent's place is always found before its children's.
    found
}

/// The joints above one, the nearest first.
fn joints_above(tree: &Tree, joint: usize) -> Vec<usize> {
    let above = |joint: &usize| {
        let parent = tree.joints[*joint].parent;
        tree.joints.iter().position(|other| other.child == parent)
    };
    std::iter::successors(above(&joint), above).collect()
}

/// What a joint does of which nobody says anything; `None` where it is held.
fn default_role(
    tree: &Tree,
    joint: usize,
    carried: &[usize],
    driven: &HashSet<usize>,
) -> Option<Role> {
    let of = &tree.joints[joint];
    let is_driven = of.effort > 0.0 || driven.contains(&joint) || of.mimics;
    if of.motion != Motion::Swinging || is_driven || of.travel[0] >= of.travel[1] {
        return None;
    }
    // A load on a wheel turns the joint one way or the other.
    let turns = |hub: &usize| {
        let lever_m = tree.joints[*hub].origin - of.origin;
        lever_m.cross(&Vector3::z()).dot(&of.axis)
    };
    let least = carried.iter().map(turns).fold(f64::INFINITY, f64::min);
    let most = carried.iter().map(turns).fold(f64::NEG_INFINITY, f64::max);
    let balance = least < -1e-6 && most > 1e-6;
    let has_mass = tree.links[of.child].mass.is_some();
    (balance && has_mass).then(|| Role {
        role: JointRole::Free,
        damping: of.losses.damping_n_m_s,
        friction: of.losses.friction_n_m,
        why: format!(
            "free: nothing drives it (effort 0), and it carries wheels on both sides of its axis ({}), between {:.4} and {:.4} rad",
            named(tree, carried),
            of.travel[0],
            of.travel[1]
        ),
    })
}

fn named(tree: &Tree, joints: &[usize]) -> String {
    let names: Vec<String> = joints
        .iter()
        .map(|joint| format!("`{}`", tree.joints[*joint].name))
        .collect();
    names.join(", ")
}

/// What a person asks of a joint; `None` where it shall be held.
fn asked(
    loading: &Loading,
    joint: usize,
    options: &JointOptions,
) -> Result<Option<Role>, RobotError> {
    let of = &loading.tree.joints[joint];
    let fail = |words: String| Err(refused(loading, joint, words));
    if of.motion == Motion::Other && !of.slides {
        return fail(
            "it floats or moves in a plane; give it a role where it turns or slides along one axis"
                .to_owned(),
        );
    }
    let [stiffness, damping, rest, preload, friction] = match options.numbers(of.slides) {
        Ok(numbers) => numbers,
        Err(words) => return fail(words),
    };
    let unit = if of.slides { "n_m" } else { "n_m_rad" };
    let role = match (options.role, stiffness) {
        (Some(RoleOption::Held), None) if damping.or(rest).or(preload).or(friction).is_none() => {
            return Ok(None);
        }
        (Some(RoleOption::Held), _) => {
            return fail("it is held, and what it is given else says how it moves: leave that out, or make it `sprung`".to_owned());
        }
        (Some(RoleOption::Sprung), None) => {
            return fail(format!(
                "it is sprung without a stiffness: gravity would run it to its stop; give it `stiffness_{unit}`"
            ));
        }
        (Some(RoleOption::Free), None) if rest.or(preload).is_none() => JointRole::Free,
        (Some(RoleOption::Free), _) => {
            return fail(
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
            return fail(format!(
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
        why: format!("{says}: as it was asked for"),
    }))
}

/// Refuses what is asked of joints that are not there, or that are wheels and rollers.
fn refuse_strangers(loading: &Loading, wheels: &HashSet<usize>) -> Result<(), RobotError> {
    let tree = loading.tree;
    for name in loading.options.joints.keys() {
        let Some(joint) = tree.joints.iter().position(|joint| joint.name == *name) else {
            let joint = name.clone();
            return Err(loading.source.robot_error(Fault::UnknownJoint { joint }));
        };
        if wheels.contains(&joint) {
            let words =
                "it is a wheel's or a roller's own, which turns: a role is for what carries wheels";
            return Err(refused(loading, joint, words.to_owned()));
        }
        if tree.joints[joint].motion == Motion::Fixed {
            let words = "it is fixed in the file: make it `revolute` or `prismatic` there, with an axis and limits";
            return Err(refused(loading, joint, words.to_owned()));
        }
    }
    Ok(())
}

/// Refuses stops the wrong way round.
fn check_joint(loading: &Loading, joint: usize) -> Result<(), RobotError> {
    let of = &loading.tree.joints[joint];
    let [lower, upper] = of.travel;
    if lower < upper {
        return Ok(());
    }
    let words = format!(
        "its lower limit of {lower} is not below its upper one of {upper}: exchange them, or hold the joint"
    );
    Err(refused(loading, joint, words))
}

fn refused(loading: &Loading, joint: usize, reason: String) -> RobotError {
    let name = &loading.tree.joints[joint].name;
    loading
        .source
        .joint_error(name, Fault::JointRole { reason })
}
