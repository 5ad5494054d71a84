//! Which rollers wheels without rollers are meant to have, where the file says so.
//!
//! Most published bases model their wheels as plain discs and leave the rollers to a plug-in of a simulator. What such files say
//! of them is taken, in this order: a joint that turns in place of rollers, directions of friction, rollers that the wheels' meshes show, a plug-in that drives mecanum wheels,
//! axes on which plain wheels could not roll at all, and what they call them. That a plug-in moves the base in all directions says
//! nothing: steered wheels do so as well. How many rollers there are only meshes show: else that is a guess, and remarked.

mod axes;
mod called;

use super::candidates::{Survey, WheelLike};
use super::from_options;
use super::hub::hub_frame;
use super::loading::Loading;
use super::mesh_rollers::{self, MeshRollers};
use super::names::{self, is_mecanum, is_omni};
use super::source::Source;
use super::tree::{Motion, Tree};
use crate::error::{CandidateJoint, Proposed};
use crate::options::{Handedness, WheelOptions};
use axes::{
    are_aligned, are_parallel, by_friction, by_joints, by_turning_friction, stand_in_x,
    turning_friction,
};
use called::{
    Kind, are_of_two_kinds, called, free_name, heading, hint, is_called_omni, is_driven_as_plain,
    kind, mover, plugin, robot_called, speaks_of_mecanum,
};

/// Rollers that are put on a wheel of which nobody says how many it has: mecanum wheels carry nine to fifteen.
pub(super) const ROLLERS: usize = 12;

/// The usual angle of mecanum wheels, in degrees.
const MECANUM_DEG: f64 = 45.0;

/// What the axes of wheels say, where something speaks of a robot that moves in all directions.
const BY_AXES: &str =
    "and by their axes: on parallel ones only mecanum rollers let a robot move sideways";

/// What speaks for rollers where one joint below each wheel turns in their place.
const ONE_JOINT: &str = "the joint below each of them that turns in place of rollers";

/// Fewest wheels that hold all three freedoms of the plane.
const LEAST_WHEELS: usize = 3;

/// Rollers, and what speaks for them.
#[derive(Clone, Debug)]
pub(super) struct Inferred {
    pub(super) rollers: WheelOptions,
    pub(super) why: String,
    /// Whether meshes show how many there are.
    pub(super) are_drawn: bool,
}

/// What a file says of its wheels' rollers.
pub(super) fn infer(loading: &Loading, survey: &Survey) -> Option<Inferred> {
    let (source, tree) = (loading.source, loading.tree);
    let wheels = wheels(survey)?;
    // A wheel whose size is not known could only be given rollers by a guess at that too.
    if wheels.iter().any(|wheel| wheel.disc.is_none()) {
        return None;
    }
    let drawn = drawn(loading, &wheels);
    let named = |gamma: Handedness, why: String| {
        Some(Inferred {
            rollers: rollers(tree, &wheels, &drawn, gamma),
            why,
            are_drawn: drawn.is_some(),
        })
    };
    if let Some(gammas_deg) = by_joints(tree, &wheels) {
        return named(Handedness::EachDeg(gammas_deg), ONE_JOINT.to_owned());
    }
    if let Some(gammas_deg) = by_friction(source, tree, &wheels) {
        return named(
            Handedness::EachDeg(gammas_deg),
            "the directions of friction that the file gives them".to_owned(),
        );
    }
    if let Some((gamma, why)) = drawn.as_ref().and_then(|drawn| by_drawing(drawn, &wheels)) {
        return named(gamma, why);
    }
    let are_mixed = are_of_two_kinds(source, tree, &wheels);
    if let Some(plugin) = plugin(source).filter(|_| stand_in_x(&wheels) && !are_mixed) {
        return named(
            Handedness::XDeg(MECANUM_DEG),
            format!("the plug-in `{plugin}` that drives them"),
        );
    }
    if are_mixed {
        return named(
            by_groups(source, tree, &wheels)?,
            "what the file calls each of them".to_owned(),
        );
    }
    if !are_parallel(&wheels) {
        return named(
            by_groups(source, tree, &wheels)?,
            "their axes, on which plain wheels could not roll".to_owned(),
        );
    }
    if !stand_in_x(&wheels) {
        return None;
    }
    let called = called(source, tree, &wheels)?;
    named(
        Handedness::XDeg(MECANUM_DEG),
        format!("what the file calls them: `{called}`"),
    )
}

/// Rollers that would fit how the wheels stand and what the file says of them, for a person to confirm; and what speaks for them, in words. Parallel
/// wheels of which nothing says that they are Swedish ones are plain wheels to all appearance, and are given none; and that a robot of
/// steered wheels is called omnidirectional says nothing of rollers. `left_out` are joints that are no wheels beside these, and why.
pub(super) fn fitting(
    loading: &Loading,
    wheels: &[&WheelLike],
    are_steered: bool,
    left_out: &[CandidateJoint],
) -> (Proposed, Option<String>) {
    let (source, tree) = (loading.source, loading.tree);
    let wheels: Vec<WheelLike> = wheels.iter().map(|w| (*w).clone()).collect();
    let drawn = drawn(loading, &wheels);
    let by_drawing = drawn.as_ref().and_then(|drawn| by_drawing(drawn, &wheels));
    let in_x = || Some(Handedness::XDeg(MECANUM_DEG));
    let (gamma, why) = if let Some(gammas_deg) = by_joints(tree, &wheels) {
        (Some(Handedness::EachDeg(gammas_deg)), ONE_JOINT.to_owned())
    } else if let Some((gamma, why)) = by_drawing {
        (Some(gamma), why)
    } else if let Some((gammas_deg, why)) = by_turning_friction(source, tree, &wheels) {
        (Some(Handedness::EachDeg(gammas_deg)), why)
    } else if !are_parallel(&wheels) || are_of_two_kinds(source, tree, &wheels) {
        let why = "their axes and what the file calls them".to_owned();
        (by_groups(source, tree, &wheels), why)
    } else if let Some(what) = speaks_of_mecanum(source, tree, &wheels) {
        if !stand_in_x(&wheels) {
            return (Proposed::Contradiction, Some(out_of_x(&what, left_out)));
        }
        (in_x(), what)
    } else if let Some(words) = heading(source, tree, &wheels)
        .filter(|_| !are_steered && stand_in_x(&wheels) && !is_driven_as_plain(source))
    {
        (in_x(), format!("the comment `{words}`"))
    } else if let Some(name) = free_name(source, tree, &wheels)
        .filter(|_| !are_steered && stand_in_x(&wheels) && !is_driven_as_plain(source))
    {
        // Four parallel wheels that are not steered move sideways by mecanum rollers alone, whatever they are called.
        (in_x(), format!("the name `{name}`, {BY_AXES}"))
    } else if let Some(mover) =
        mover(source).filter(|_| !are_steered && stand_in_x(&wheels) && are_turning(tree, &wheels))
    {
        (in_x(), format!("{mover}, {BY_AXES}"))
    } else {
        let why = turning_friction(source, tree, &wheels).or_else(|| hint(source));
        return (Proposed::NothingSaid, why);
    };
    let Some(gamma) = gamma else {
        return (Proposed::Contradiction, None);
    };
    let rollers = rollers(tree, &wheels, &drawn, gamma);
    let count = match drawn {
        Some(_) => String::new(),
        None => format!(
            "; that they are {} on a wheel is assumed, for nothing shows how many there are",
            rollers.rollers
        ),
    };
    let why = format!("those of the proposal are taken by {why}{count}");
    (Proposed::Rollers(Box::new(rollers)), Some(why))
}

/// Why mecanum wheels cannot stand as these do, in words, with the joints that may be missing among them.
fn out_of_x(what: &str, left_out: &[CandidateJoint]) -> String {
    let beside = left_out.iter().filter(|of| of.is_too_high);
    let beside: Vec<String> = beside
        .map(|of| format!("; `{}` {}", of.joint, of.reason))
        .collect();
    format!(
        "{what} speaks of mecanum wheels, which stand on both sides of the middle, ahead of it and behind, as these do not{}",
        beside.concat()
    )
}

/// Whether the file itself lets wheels turn.
fn are_turning(tree: &Tree, wheels: &[WheelLike]) -> bool {
    let mut joints = wheels.iter().map(|wheel| &tree.joints[wheel.joint]);
    joints.all(|joint| joint.motion == Motion::Turning)
}

/// Rollers at an angle, as many and as thick as meshes show, or else a guess.
fn rollers(
    tree: &Tree,
    wheels: &[WheelLike],
    drawn: &Option<Vec<MeshRollers>>,
    gamma: Handedness,
) -> WheelOptions {
    let joints = wheels.iter().map(|w| tree.joints[w.joint].name.clone());
    let drawn = drawn.as_ref().map(|drawn| drawn[0]);
    let count = drawn.map_or(ROLLERS, |drawn| drawn.count);
    let mut rollers = WheelOptions::new(count, gamma).on(joints.collect());
    rollers.roller_radius_m = drawn.filter(MeshRollers::hands_over).map(|drawn| {
        // What touches may be of another size than what is shown.
        let disc_m = wheels[0].disc.map(|disc| disc.radius_m);
        let scale = disc_m.map_or(1.0, |disc_m| disc_m / drawn.wheel_radius_m);
        (1e4 * scale * drawn.roller_radius_m).round() / 1e4
    });
    rollers
}

/// The rollers that the meshes of all wheels show; `None` where one shows none, or others than the first does.
fn drawn(loading: &Loading, wheels: &[WheelLike]) -> Option<Vec<MeshRollers>> {
    let tree = loading.tree;
    let of_wheel = |like: &WheelLike| {
        let body = tree.lone_body(tree.joints[like.joint].child);
        let frame = hub_frame(&like.origin, &like.axis);
        mesh_rollers::of_wheel(&body, &frame, &loading.meshes)
    };
    let drawn: Vec<MeshRollers> = wheels.iter().map(of_wheel).collect::<Option<_>>()?;
    let are_equal = drawn.windows(2).all(|pair| pair[0].is_like(&pair[1]));
    are_equal.then_some(drawn)
}

/// gamma as the wheels' meshes show it, with what is said of that. Where wheels stand in an X they are handed by that: many files draw one mesh on all
/// of them, with which they could not drive. `None` of rollers with which wheels that stand so could not drive at all.
fn by_drawing(drawn: &[MeshRollers], wheels: &[WheelLike]) -> Option<(Handedness, String)> {
    let mean_rad = drawn.iter().map(|of| of.gamma_rad.abs()).sum::<f64>() / drawn.len() as f64;
    let shown_deg = (10.0 * mean_rad.to_degrees()).round() / 10.0;
    let mean_deg = usual_deg(shown_deg, drawn.iter().all(|of| of.are_round))?;
    let but = match mean_deg == shown_deg {
        true => String::new(),
        false => format!(", for which {mean_deg} deg are taken"),
    };
    let why = format!(
        "their meshes, which show {} rollers of radius {:.1} mm at {shown_deg} deg on each{but}",
        drawn[0].count,
        1e3 * drawn[0].roller_radius_m
    );
    if mean_deg == 0.0 {
        return (!are_parallel(wheels)).then_some((Handedness::AllDeg(0.0), why));
    }
    if !stand_in_x(wheels) {
        let handed = drawn.iter().map(|of| mean_deg.copysign(of.gamma_rad));
        return (!are_parallel(wheels)).then(|| (Handedness::EachDeg(handed.collect()), why));
    }
    let in_x = from_options::in_x_deg(wheels, mean_deg).ok()?;
    let is_so = in_x
        .iter()
        .zip(drawn)
        .all(|(deg, of)| deg * of.gamma_rad > 0.0);
    let but = match is_so {
        true => "",
        false => " (handed otherwise than in the usual X, in which they stand)",
    };
    Some((Handedness::XDeg(mean_deg), format!("{why}{but}")))
}

/// The angle that is meant by one that meshes show, in degrees: a usual one where that is near, for meshes have facets; and where their rollers
/// are not round, for then they were stretched, if it is near enough for that, else none.
fn usual_deg(shown_deg: f64, are_round: bool) -> Option<f64> {
    /// By this much meshes lie beside what they show, in degrees, and stretched ones by this.
    const FACETS_DEG: f64 = 1.0;
    const STRETCHED_DEG: f64 = 10.0;
    let near_deg = if are_round { FACETS_DEG } else { STRETCHED_DEG };
    let is_near = |usual: &f64| (shown_deg - usual).abs() < near_deg;
    let usual = [0.0, MECANUM_DEG].into_iter().find(is_near);
    usual.or_else(|| are_round.then_some(shown_deg))
}

/// gamma of wheels of which not all are parallel, by groups that are: those that stand in the X of mecanum wheels, and are not called
/// otherwise, are such; the others are omni wheels. `None` where wheels are called mecanum wheels and do not stand as such, and where
/// the robot is called so, none of its wheels stand as such and none are called omni wheels.
fn by_groups(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> Option<Handedness> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    // Beside wheels that are called mecanum wheels, those that are called omni wheels are a group of their own.
    let are_mixed = are_of_two_kinds(source, tree, wheels);
    let is_apart = |wheel: &WheelLike| are_mixed && kind(source, tree, wheel) == Some(Kind::Omni);
    for (i, wheel) in wheels.iter().enumerate() {
        let with = |group: &&mut Vec<usize>| {
            let first = &wheels[group[0]];
            are_aligned(&first.axis, &wheel.axis) && is_apart(first) == is_apart(wheel)
        };
        match groups.iter_mut().find(with) {
            Some(group) => group.push(i),
            None => groups.push(vec![i]),
        }
    }
    let mut gammas_deg = vec![0.0; wheels.len()];
    for group in groups {
        let likes: Vec<WheelLike> = group.iter().map(|&i| wheels[i].clone()).collect();
        let called = |is: fn(&str) -> bool| {
            let mut joints = likes.iter().map(|like| like.joint);
            joints.any(|j| names::of_wheel(source, tree, j).iter().any(|name| is(name)))
        };
        let mecanum = called(is_mecanum) && !is_apart(&likes[0]);
        let omni = called(is_omni);
        if stand_in_x(&likes) && (mecanum || !omni) {
            let in_x = from_options::in_x_deg(&likes, MECANUM_DEG).ok()?;
            for (i, gamma_deg) in group.into_iter().zip(in_x) {
                gammas_deg[i] = gamma_deg;
            }
        } else if mecanum {
            return None;
        }
    }
    if gammas_deg.iter().any(|gamma_deg| *gamma_deg != 0.0) {
        return Some(Handedness::EachDeg(gammas_deg));
    }
    let are_omni = wheels
        .iter()
        .any(|wheel| is_called_omni(source, tree, wheel));
    let is_called_mecanum = plugin(source).is_some() || robot_called(source).is_some();
    (are_omni || !is_called_mecanum).then_some(Handedness::AllDeg(0.0))
}

/// The wheels in question: those that turn, or else all that could be.
fn wheels(survey: &Survey) -> Option<Vec<WheelLike>> {
    if survey.turning.len() >= LEAST_WHEELS {
        return Some(survey.turning.clone());
    }
    let likely: Vec<WheelLike> = survey.likely().into_iter().cloned().collect();
    (likely.len() >= LEAST_WHEELS).then_some(likely)
}
