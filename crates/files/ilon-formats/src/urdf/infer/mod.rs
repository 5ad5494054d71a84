//! Infers the rollers of wheels modelled without any, from information in the file.
//!
//! Most published bases model their wheels as plain discs and leave the rollers to a simulator's
//! plug-in. The information in such files is used in this order: a joint that turns in place of
//! rollers, friction directions, rollers in the wheels' meshes, a plug-in that drives mecanum
//! wheels, axes on which plain wheels could not roll at all, and names. A plug-in that moves the
//! base in all directions is no evidence: steered wheels do so as well. Only meshes show the number
//! of rollers; otherwise it is a guess, and remarked.

mod axes;
mod called;

use super::candidates::{Survey, WheelLike, is_called_wheel};
use super::casters;
use super::from_options;
use super::hub::hub_frame;
use super::loading::Loading;
use super::mesh_rollers::{self, MeshRollers};
use super::names::{self, is_mecanum, is_omni};
use super::source::Source;
use super::tree::{Motion, Tree};
use crate::error::{CandidateJoint, Proposed};
use crate::model::{MassProperties, Remark};
use crate::options::{Handedness, TyreOptions, WheelOptions};
use axes::{
    are_aligned, are_parallel, by_friction, by_joints, by_turning_friction, stand_in_x,
    unused_friction,
};
use called::{
    Kind, are_of_two_kinds, called, free_name, heading, hint, is_called_in_short, is_called_omni,
    is_driven_as_plain, kind, mover, plugin, robot_called, speaks_of_mecanum,
};

/// Assumed number of rollers of a wheel: mecanum wheels have nine to fifteen.
pub(super) const ROLLERS: usize = 12;

/// The usual angle of mecanum wheels, in degrees.
const MECANUM_DEG: f64 = 45.0;

/// The evidence of the wheels' axes, if something implies a robot that moves in all directions.
const BY_AXES: &str =
    "and by their axes: on parallel ones only mecanum rollers let a robot move sideways";

/// The evidence of one joint below each wheel that turns in place of rollers.
const ONE_JOINT: &str = "the joint below each of them that turns in place of rollers";

/// Smallest number of wheels that control all three degrees of freedom of the plane.
const LEAST_WHEELS: usize = 3;

/// Rollers with their evidence.
#[derive(Clone, Debug)]
pub(super) struct Inferred {
    pub(super) rollers: WheelOptions,
    pub(super) why: String,
    /// Whether meshes show their number.
    pub(super) are_drawn: bool,
}

/// Returns the rollers that a file implies for its wheels.
pub(super) fn infer(loading: &Loading, survey: &Survey) -> Option<Inferred> {
    let (source, tree) = (loading.source, loading.tree);
    let wheels = wheels(tree, survey)?;
    // For a wheel of unknown size the rollers would need a second guess.
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
        format!("the name `{called}`"),
    )
}

/// Returns tyres for wheels that a plug-in or a controller drives as plain wheels, for a lone pair
/// of parallel wheels, and for steered wheels: none of these can be Swedish wheels. With a remark.
pub(super) fn tyres(loading: &mut Loading, survey: &Survey) -> Option<TyreOptions> {
    let tree = loading.tree;
    let is_steered = steered(tree, survey).next().is_some();
    let wheels = &survey.turning;
    let is_few = wheels.len() < LEAST_WHEELS;
    let likes: Vec<WheelLike> = survey
        .turning
        .iter()
        .chain(&survey.steered)
        .cloned()
        .collect();
    let source = loading.source;
    // Where the size is not known, it is asked for: of wheels, not of segments of arms.
    let may_lack_size = !is_steered || is_driven_as_plain(source);
    let is_wheel = |like: &WheelLike| {
        like.disc.is_some() || may_lack_size && is_called_wheel(tree, like.joint)
    };
    if !likes.iter().all(is_wheel)
        || !stand_below_mass(tree, &likes)
        || speaks_of_mecanum(source, tree, &likes).is_some()
    {
        return None;
    }
    let hints = free_name(source, tree, wheels).or_else(|| heading(source, tree, wheels));
    let is_hinted = hints.is_some() || is_called_in_short(source, tree, wheels);
    let why = if is_steered && is_few && likes.len() >= 2 {
        "some of them are steered"
    } else if is_hinted {
        return None;
    } else if is_driven_as_plain(source) && wheels.len() >= 2 {
        "the file drives them as plain wheels"
    } else if wheels.len() == 2 && are_parallel(wheels) {
        match wheels
            .iter()
            .any(|of| tree.joints[of.joint].motion != Motion::Turning)
        {
            true => {
                "two wheels on parallel axles can only roll and turn; their joints do not turn in the file, and are taken to"
            }
            false => "two wheels on parallel axles can only roll and turn",
        }
    } else {
        return None;
    };
    let words = format!("no rollers in the file, so they are given tyres: {why}");
    loading.remarks.push(Remark::new("the wheels", words));
    Some(on_tyres(tree, survey))
}

/// Whether wheels of known size reach below the robot's centre of mass: those of arms do not.
fn stand_below_mass(tree: &Tree, wheels: &[WheelLike]) -> bool {
    let masses = tree.links.iter().filter_map(|link| link.mass.clone());
    // Files for viewers give no mass, and nothing then speaks against wheels.
    let Some(whole) = MassProperties::merged(&masses.collect::<Vec<_>>()) else {
        return true;
    };
    let bottom_m = |wheel: &WheelLike| Some(wheel.origin.z - wheel.disc?.radius_m);
    let mut bottoms_m = wheels.iter().map(bottom_m);
    bottoms_m.all(|bottom_m| bottom_m.is_none_or(|z_m| z_m < whole.center_of_mass_m.z))
}

/// Returns the joints of steered wheels but for casters; some call all modules of a robot so.
pub(super) fn steered(tree: &Tree, survey: &Survey) -> impl Iterator<Item = usize> {
    let mut others = survey.others.iter();
    let are_beside =
        !survey.turning.is_empty() || others.any(|like| is_called_wheel(tree, like.joint));
    let joints = survey.steered.iter().map(|like| like.joint);
    joints.filter(move |joint| !(are_beside && casters::is_caster(tree, *joint)))
}

/// Returns tyres for all wheels but casters. Where only some of their joints have a limit on the
/// torque, nothing drives the others.
pub(super) fn on_tyres(tree: &Tree, survey: &Survey) -> TyreOptions {
    let mut joints: Vec<usize> = survey.turning.iter().map(|like| like.joint).collect();
    joints.extend(steered(tree, survey));
    joints.sort_unstable();
    let is_driven = |joint: &usize| tree.joints[*joint].effort > 0.0;
    let name = |joint: &usize| tree.joints[*joint].name.clone();
    let mut tyres = TyreOptions::default();
    if joints.iter().any(is_driven) {
        tyres.joints = joints
            .iter()
            .filter(|joint| is_driven(joint))
            .map(name)
            .collect();
        tyres.free = joints
            .iter()
            .filter(|joint| !is_driven(joint))
            .map(name)
            .collect();
    } else {
        tyres.joints = joints.iter().map(name).collect();
    }
    tyres
}

/// Returns rollers that match the wheels' arrangement and the file's information, for the user to
/// confirm, with the evidence as text. Parallel wheels without evidence of Swedish wheels count as
/// plain wheels, and get none; and a robot of steered wheels named omnidirectional is no evidence.
/// `left_out` are joints that are no wheels, with reasons.
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
        // Four parallel unsteered wheels move sideways only with mecanum rollers, whatever their
        // names.
        (in_x(), format!("the name `{name}`, {BY_AXES}"))
    } else if let Some(mover) =
        mover(source).filter(|_| !are_steered && stand_in_x(&wheels) && are_turning(tree, &wheels))
    {
        (in_x(), format!("{mover}, {BY_AXES}"))
    } else {
        let why = unused_friction(source, tree, &wheels).or_else(|| hint(source));
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

/// Returns why mecanum wheels cannot have this arrangement, as text, with the joints that may be
/// missing among them.
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

/// Returns rollers at an angle, with the number and thickness shown by meshes, or else guessed.
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
        // Collision and visual shapes may differ in size.
        let disc_m = wheels[0].disc.map(|disc| disc.radius_m);
        let scale = disc_m.map_or(1.0, |disc_m| disc_m / drawn.wheel_radius_m);
        (1e4 * scale * drawn.roller_radius_m).round() / 1e4
    });
    rollers
}

/// Returns the rollers shown by the meshes of all wheels; `None` if one shows none, or others than
/// the first.
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

/// Returns gamma shown by the wheels' meshes, with the remark. Wheels in an X get the handedness of
/// their place: many files use one mesh for all of them, with which they could not drive. `None`
/// for rollers with which wheels in this arrangement could not drive at all.
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

/// Returns the intended angle for one shown by meshes, in degrees: a usual one if close, because
/// meshes have facets; for rollers that are not round, because they were stretched, a usual one if
/// close enough for that, otherwise none.
fn usual_deg(shown_deg: f64, are_round: bool) -> Option<f64> {
    /// Tolerance of angles shown by meshes, in degrees, and of stretched ones.
    const FACETS_DEG: f64 = 1.0;
    const STRETCHED_DEG: f64 = 10.0;
    let near_deg = if are_round { FACETS_DEG } else { STRETCHED_DEG };
    let is_near = |usual: &f64| (shown_deg - usual).abs() < near_deg;
    let usual = [0.0, MECANUM_DEG].into_iter().find(is_near);
    usual.or_else(|| are_round.then_some(shown_deg))
}

/// Returns gamma of wheels that are not all parallel, by groups of parallel ones: those arranged in
/// the X of mecanum wheels, without another name, are mecanum wheels; the others are omni wheels.
/// `None` if wheels named mecanum wheels are not arranged like them, or if the robot is named so,
/// none of its wheels are arranged so, and none are named omni wheels.
fn by_groups(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> Option<Handedness> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    // Next to wheels named mecanum wheels, those named omni wheels form their own group.
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

/// Returns the wheels in question: those that turn, or else all possible ones. Beside two that turn
/// a round part that does not is one if it is called a wheel.
fn wheels(tree: &Tree, survey: &Survey) -> Option<Vec<WheelLike>> {
    if survey.turning.len() >= LEAST_WHEELS {
        return Some(survey.turning.clone());
    }
    let may_be_round = survey.turning.len() < 2;
    let others = survey.others.iter();
    let others = others.filter(|like| may_be_round || is_called_wheel(tree, like.joint));
    let likely: Vec<WheelLike> = survey.turning.iter().chain(others).cloned().collect();
    (likely.len() >= LEAST_WHEELS).then_some(likely)
}
