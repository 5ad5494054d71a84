//! Finds the joints that may be wheels without rollers, and the reasons why the others are not.
//!
//! A candidate turns about a level axis, or its geometry is round about one; nothing that turns is
//! below it, and no steering above; and it stands on the same floor as the others.

use std::collections::HashSet;

use nalgebra::{Point3, Unit, Vector3};

use super::casters;
use super::disc::{self, Disc, NoDisc};
use super::hub::hub_frame;
use super::mesh::Meshes;
use super::names;
use super::recognise::{Candidate, LEAST_ROLLERS};
use super::tree::{Motion, PlacedShape, Tree};
use crate::error::CandidateJoint;

/// A wheel is on the floor of the others if its lowest point is no higher above it than this share
/// of its radius.
const ON_THE_FLOOR: f64 = 0.3;
/// The same for the axes of wheels of unknown size, in metres.
const SAME_HEIGHT_M: f64 = 0.01;

/// A joint that may be a wheel.
#[derive(Clone, Debug)]
pub(super) struct WheelLike {
    pub(super) joint: usize,
    /// The axis in the body frame: the joint's own, or that of its geometry.
    pub(super) axis: Unit<Vector3<f64>>,
    /// A point of the axis, in the body frame.
    pub(super) origin: Point3<f64>,
    /// The wheel's geometry.
    pub(super) disc: Option<Disc>,
}

/// The result of the search.
#[derive(Clone, Debug, Default)]
pub(super) struct Survey {
    /// Wheels by default: joints that turn.
    pub(super) turning: Vec<WheelLike>,
    /// Wheels only if named: joints that are fixed, limited or follow others.
    pub(super) others: Vec<WheelLike>,
    /// Joints below upright ones, which would be wheels without them.
    pub(super) steered: Vec<WheelLike>,
    /// Why the other joints are no wheels.
    pub(super) looked: Vec<CandidateJoint>,
}

/// Searches all joints except wheels with rollers, and their rollers.
pub(super) fn survey(tree: &Tree, candidates: &[Candidate], meshes: &Meshes) -> Survey {
    let mut survey = Survey::default();
    let taken = |j: usize| {
        candidates
            .iter()
            .any(|c| c.hub == j || c.rollers.contains(&j))
    };
    for j in (0..tree.joints.len()).filter(|&j| !taken(j)) {
        let joint = &tree.joints[j];
        match look(tree, j, meshes) {
            Ok(like) if steering_above(tree, j).is_some() => survey.steered.push(like),
            Ok(like) if joint.motion == Motion::Turning && !joint.mimics => {
                survey.turning.push(like);
            }
            // An arm's joints have limits too, and its segments are round.
            Ok(_) if joint.motion == Motion::Swinging && !is_called_wheel(tree, j) => {
                survey.looked.push(CandidateJoint {
                    joint: joint.name.clone(),
                    reason: "turns within limits, and is not called a wheel".to_owned(),
                    is_too_high: false,
                });
            }
            Ok(like) => survey.others.push(like),
            // A joint that does not move is rarely meant as a wheel, but an unreadable one may be.
            Err(reason) if joint.motion == Motion::Fixed && !reason.contains("mesh `") => {}
            Err(reason) => survey.looked.push(CandidateJoint {
                joint: joint.name.clone(),
                reason,
                is_too_high: false,
            }),
        }
    }
    survey.keep_on_the_floor(tree, candidates);
    survey.leave_out_parts(tree, candidates);
    survey.take_still_pair(tree, candidates);
    survey.leave_out_casters(tree);
    survey
}

/// Returns a named joint as a wheel, or why it cannot be one.
pub(super) fn named(tree: &Tree, j: usize, meshes: &Meshes) -> Result<WheelLike, String> {
    let joint = &tree.joints[j];
    if let Some(below) = carried(tree, j) {
        return Err(format!(
            "the joint `{}` turns below it",
            tree.joints[below].name
        ));
    }
    // A turning joint is accepted whatever its geometry.
    if joint.motion == Motion::Turning {
        return Ok(on_own_axis(tree, j, meshes));
    }
    // One that does not turn uses its stated axis if its geometry shows none.
    look(tree, j, meshes).or_else(|why| {
        if joint.motion == Motion::Fixed && joint.states_axis && tree.is_level(j) {
            return Ok(on_own_axis(tree, j, meshes));
        }
        Err(if joint.motion == Motion::Fixed {
            format!("{why}; an `<axis>` in the joint would say about which axis it turns")
        } else {
            why
        })
    })
}

/// Returns the joint that turns in place of a wheel's rollers: one that crosses the wheel's own and
/// turns a ball. It is a common model of a mecanum wheel without single rollers: the ball turns
/// about the axis of the roller that touches the ground.
pub(super) fn in_place_of_rollers(tree: &Tree, hub: usize) -> Option<usize> {
    let &[crossing] = &parts_of_wheel(tree, hub)[..] else {
        return None;
    };
    let shapes = &tree.links[tree.joints[crossing].child].shapes;
    let is_ball = |shape: &PlacedShape| matches!(shape.geometry, urdf_rs::Geometry::Sphere { .. });
    let is_in_hub = (tree.joints[crossing].origin - tree.joints[hub].origin).norm() < SAME_PLACE_M;
    let turns_level = tree.is_level(crossing);
    (is_in_hub && turns_level && shapes.iter().any(is_ball)).then_some(crossing)
}

/// Points closer than this coincide, in metres.
const SAME_PLACE_M: f64 = 5e-3;

/// Returns the joints that turn below a level one within its wheel, across its axis, and too few
/// for a ring of rollers: one that represents them, or some for display. Empty if anything else
/// turns below it or above it.
fn parts_of_wheel(tree: &Tree, hub: usize) -> Vec<usize> {
    /// The cosine of the least angle between the axes, of 10 degrees.
    const APART: f64 = 0.985;
    /// Anything further out than the wheel's own shapes, by this share, is no part of it.
    const MARGIN: f64 = 0.05;
    let wheel = &tree.joints[hub];
    let is_wheel = wheel.motion == Motion::Turning && tree.is_level(hub);
    if !is_wheel || tree.turning_below(hub).is_none() || steering_above(tree, hub).is_some() {
        return Vec::new();
    }
    let reach_m = tree.lone_body(wheel.child).reach_m(&wheel.origin.coords);
    let within_m = SAME_PLACE_M.max((1.0 + MARGIN) * reach_m);
    let turning = tree.moving(Motion::Turning);
    let below: Vec<usize> = turning
        .filter(|&j| j != hub && tree.turning_above(j) == Some(hub))
        .collect();
    let is_part = |&j: &usize| {
        let part = &tree.joints[j];
        (part.origin - wheel.origin).norm() < within_m
            && part.axis.dot(&wheel.axis).abs() < APART
            && tree.turning_below(j).is_none()
    };
    match below.len() < LEAST_ROLLERS && below.iter().all(is_part) {
        true => below,
        false => Vec::new(),
    }
}

/// Returns a joint that turns below one, except parts of a wheel.
fn carried(tree: &Tree, j: usize) -> Option<usize> {
    let below = tree.turning_below(j)?;
    parts_of_wheel(tree, j).is_empty().then_some(below)
}

fn look(tree: &Tree, j: usize, meshes: &Meshes) -> Result<WheelLike, String> {
    let joint = &tree.joints[j];
    let above = tree.turning_above(j);
    if let Some(hub) = above.filter(|&hub| parts_of_wheel(tree, hub).contains(&j)) {
        return Err(format!(
            "turns across `{}` as a part of its wheel",
            tree.joints[hub].name
        ));
    }
    if let Some(below) = carried(tree, j) {
        return Err(format!(
            "carries the turning joint `{}`",
            tree.joints[below].name
        ));
    }
    match joint.motion {
        Motion::Turning if tree.is_level(j) => Ok(on_own_axis(tree, j, meshes)),
        Motion::Turning => Err(format!(
            "turns about an axis that leans {:.0} deg out of the ground plane",
            libm::asin(joint.axis.z.abs().min(1.0)).to_degrees()
        )),
        Motion::Other => Err("slides or floats".to_owned()),
        Motion::Fixed | Motion::Swinging => {
            let body = if joint.motion == Motion::Fixed {
                tree.lone_body(joint.child)
            } else {
                tree.rigid_body(joint.child, |k| tree.joints[k].motion == Motion::Turning)
            };
            // A joint with a level axis and round geometry about it carries a wheel, whether it
            // turns or not.
            if joint.states_axis && tree.is_level(j) {
                let own = on_own_axis(tree, j, meshes);
                if own.disc.is_some() {
                    return Ok(own);
                }
            }
            let kind = if joint.motion == Motion::Fixed {
                "does not turn"
            } else {
                "turns within limits"
            };
            let (origin, axis) = match disc::level_axis(&body, meshes) {
                Ok(found) => found,
                // Unreadable or transverse geometry counts as a wheel if it is named like one and
                // its joint states a level axis.
                Err(NoDisc::Unreadable(_) | NoDisc::NotRound(_))
                    if joint.states_axis && tree.is_level(j) && is_called_wheel(tree, j) =>
                {
                    return Ok(on_own_axis(tree, j, meshes));
                }
                Err(why) => return Err(format!("{kind}, and {}", why.words())),
            };
            let disc = disc::about(&body, &hub_frame(&origin, &axis), meshes).ok();
            Ok(WheelLike {
                joint: j,
                axis,
                origin,
                disc,
            })
        }
    }
}

/// Whether a joint, its link or a mesh of it is named like a wheel.
pub(super) fn is_called_wheel(tree: &Tree, j: usize) -> bool {
    names::own(tree, j)
        .iter()
        .any(|name| names::is_of_wheel(name))
}

/// Whether it is a ball, or called a caster.
fn is_caster(tree: &Tree, like: &WheelLike) -> bool {
    names::is_called_caster(tree, like.joint) || casters::is_ball(tree, like.joint)
}

fn on_own_axis(tree: &Tree, j: usize, meshes: &Meshes) -> WheelLike {
    let joint = &tree.joints[j];
    let parts = parts_of_wheel(tree, j);
    let body = tree.rigid_body(joint.child, |k| {
        tree.joints[k].motion == Motion::Turning && !parts.contains(&k)
    });
    let disc = if tree.is_level(j) {
        disc::about(&body, &hub_frame(&joint.origin, &joint.axis), meshes).ok()
    } else {
        None
    };
    WheelLike {
        joint: j,
        axis: joint.axis,
        origin: joint.origin,
        disc,
    }
}

/// Returns the joint that steers a wheel: the next turning one above it, or one that turns within
/// limits about an upright axis, unless it carries the whole robot, as in a planar base.
fn steering_above(tree: &Tree, j: usize) -> Option<usize> {
    if let Some(above) = tree.turning_above(j) {
        return (!carries_robot(tree, j, above, |k| tree.turning_above(k))).then_some(above);
    }
    // Arms swivel too, and carry round parts that do not turn.
    let may_roll = match tree.joints[j].motion {
        Motion::Turning => true,
        Motion::Fixed => is_called_wheel(tree, j),
        Motion::Swinging | Motion::Other => false,
    };
    let above = tree.swivel_above(j).filter(|_| may_roll)?;
    (!carries_robot(tree, j, above, |k| tree.swivel_above(k))).then_some(above)
}

/// Whether a joint above another carries a whole robot: three wheels, or if the other does not
/// turn, three and all of those named like wheels.
fn carries_robot(
    tree: &Tree,
    j: usize,
    above: usize,
    next_above: impl Fn(usize) -> Option<usize>,
) -> bool {
    /// Smallest number of wheels of a robot.
    const ROBOT: usize = 3;
    let is_below = |k: &usize| next_above(*k) == Some(above);
    let level = |motion| tree.moving(motion).filter(|&k| tree.is_level(k));
    let turning = level(Motion::Turning).filter(is_below).count();
    let does_turn = tree.joints[j].motion != Motion::Fixed;
    let called = || level(Motion::Fixed).filter(|&k| is_called_wheel(tree, k));
    turning >= ROBOT || !does_turn && called().count() >= ROBOT && called().all(|k| is_below(&k))
}

impl WheelLike {
    /// Returns the wheel's position in the body frame: the middle of its geometry on the axis. The
    /// joint's origin may be anywhere on the axis, even across the robot's middle; it is used only
    /// if no geometry shows a wheel.
    pub(super) fn middle(&self) -> Point3<f64> {
        let along_m = self.disc.map_or(0.0, |disc| disc.middle_m);
        self.origin + along_m * self.axis.into_inner()
    }

    /// Returns the height of its lowest point in the body frame; `None` for an unknown size.
    fn bottom_m(&self) -> Option<f64> {
        Some(self.origin.z - self.disc?.radius_m)
    }

    /// Returns its height above a floor, in metres, if too large for a wheel.
    fn too_high_m(&self, floor: &CommonFloor) -> Option<f64> {
        let (above_m, most_m) = match (self.bottom_m(), self.disc) {
            (Some(bottom_m), Some(disc)) => {
                (bottom_m - floor.bottom_m?, ON_THE_FLOOR * disc.radius_m)
            }
            _ => (
                self.origin.z - floor.axis_m?,
                SAME_HEIGHT_M.max(ON_THE_FLOOR * floor.radius_m),
            ),
        };
        (above_m > most_m).then_some(above_m)
    }
}

/// The floor on which the lowest wheels stand.
#[derive(Clone, Copy, Debug, Default)]
struct CommonFloor {
    /// Its height in the body frame, if a wheel's size is known.
    bottom_m: Option<f64>,
    /// The height of the lowest axis.
    axis_m: Option<f64>,
    radius_m: f64,
}

impl CommonFloor {
    fn under(likes: &[WheelLike]) -> Self {
        let lowest = |heights: &mut dyn Iterator<Item = f64>| heights.reduce(f64::min);
        Self {
            bottom_m: lowest(&mut likes.iter().filter_map(WheelLike::bottom_m)),
            axis_m: lowest(&mut likes.iter().map(|like| like.origin.z)),
            radius_m: likes
                .iter()
                .filter_map(|like| Some(like.disc?.radius_m))
                .fold(0.0, f64::max),
        }
    }
}

impl Survey {
    /// Removes candidates above the floor of the others: arms, lidars, casings.
    fn keep_on_the_floor(&mut self, tree: &Tree, candidates: &[Candidate]) {
        let mut floor = CommonFloor::under(&self.turning);
        // If there are wheels with rollers, or turning ones, a fixed part is no wheel unless it
        // reaches as low.
        if candidates.is_empty() && self.turning.is_empty() {
            floor = CommonFloor::under(&self.others);
        }
        // A part higher than the lowest of the wheels, steered or not, is no wheel.
        let mut lowest = self.steered.clone();
        lowest.extend(self.turning.iter().cloned());
        let lowest = CommonFloor::under(&lowest);
        self.steered
            .retain(|like| like.too_high_m(&lowest).is_none());
        let looked = &mut self.looked;
        for likes in [&mut self.turning, &mut self.others] {
            likes.retain(|like| match like.too_high_m(&floor) {
                None => true,
                Some(above_m) => {
                    let joint = &tree.joints[like.joint];
                    if joint.motion != Motion::Fixed {
                        looked.push(CandidateJoint {
                            joint: joint.name.clone(),
                            reason: format!(
                                "stands {:.0} mm above the floor that the lowest of them reach",
                                1e3 * above_m
                            ),
                            is_too_high: true,
                        });
                    }
                    false
                }
            });
        }
    }

    /// Removes casters that do not swivel, if two other wheels turn: balls, and what is called a
    /// caster. They roll in every direction, whatever their joint says.
    fn leave_out_casters(&mut self, tree: &Tree) {
        let is_caster = |like: &WheelLike| is_caster(tree, like);
        let wheels = self.turning.iter().filter(|like| !is_caster(like));
        if wheels.count() < 2 {
            return;
        }
        let casters = self.turning.extract_if(.., |like| is_caster(like));
        self.looked.extend(casters.map(|like| CandidateJoint {
            joint: tree.joints[like.joint].name.clone(),
            reason: "is a caster".to_owned(),
            is_too_high: false,
        }));
        self.others.retain(|like| !is_caster(like));
    }

    /// Takes two wheels that do not turn in a file for viewers as wheels, if nothing else turns but
    /// casters.
    fn take_still_pair(&mut self, tree: &Tree, candidates: &[Candidate]) {
        let is_one = |like: &WheelLike| is_called_wheel(tree, like.joint) && !is_caster(tree, like);
        let mut steered = self.steered.iter();
        let turns = !candidates.is_empty()
            || self.turning.iter().any(|like| !is_caster(tree, like))
            || steered.any(|like| !casters::is_caster(tree, like.joint));
        if !turns && self.others.iter().filter(|like| is_one(like)).count() == 2 {
            let pair = self.others.extract_if(.., |like| is_one(like));
            self.turning.extend(pair);
        }
    }

    /// Removes fixed parts of wheels or of their mounts: rollers and brackets that are round too.
    fn leave_out_parts(&mut self, tree: &Tree, candidates: &[Candidate]) {
        /// Wheels of one robot differ by less than this factor.
        const SMALLER: f64 = 0.5;
        /// A part this close to a wheel's middle, as a share of its radius, is no separate wheel.
        const INSIDE: f64 = 0.5;
        let radius_m = |like: &WheelLike| like.disc.map_or(0.0, |disc| disc.radius_m);
        let turning: Vec<WheelLike> = self.turning.clone();
        let others = self.others.clone();
        let largest_m = turning
            .iter()
            .chain(&others)
            .map(radius_m)
            .fold(0.0, f64::max);
        let hubs: HashSet<usize> = candidates.iter().map(|candidate| candidate.hub).collect();
        let called: HashSet<usize> = (turning.iter().chain(&others))
            .map(|like| like.joint)
            .filter(|&j| is_called_wheel(tree, j))
            .collect();
        let is_part = |like: &WheelLike| {
            let own_m = radius_m(like);
            let within = |other: &WheelLike| {
                let apart_m = (other.origin - like.origin).norm();
                let is_larger = radius_m(other) > own_m
                    || (radius_m(other) == own_m && other.joint < like.joint);
                other.joint != like.joint && is_larger && apart_m < INSIDE * radius_m(other)
            };
            let in_hub = hubs.contains(&like.joint)
                || tree.joints_above(like.joint).any(|j| hubs.contains(&j));
            let is_small = own_m > 0.0 && own_m < SMALLER * largest_m;
            let is_on_wheel = tree.joints_above(like.joint).any(|j| called.contains(&j));
            in_hub || is_on_wheel || is_small || turning.iter().chain(&others).any(within)
        };
        self.others.retain(|like| !is_part(like));
    }

    /// Returns joints that are named like wheels, or turn like wheels, and are not among these,
    /// with reasons.
    pub(super) fn left_out(&self, tree: &Tree, wheels: &[&WheelLike]) -> Vec<CandidateJoint> {
        let is_in = |j: usize| wheels.iter().any(|wheel| wheel.joint == j);
        let like = |like: &WheelLike, reason: &str| {
            (!is_in(like.joint)).then(|| CandidateJoint {
                joint: tree.joints[like.joint].name.clone(),
                reason: reason.to_owned(),
                is_too_high: false,
            })
        };
        let steered = self.steered.iter();
        let steered = steered.filter_map(|of| like(of, "hangs by an upright joint that steers it"));
        let turning = self.turning.iter();
        let turning = turning.filter_map(|of| like(of, "hangs by no upright joint"));
        let others = self.others.iter();
        let others = others.filter(|of| is_called_wheel(tree, of.joint));
        let others = others.filter_map(|of| like(of, "does not turn freely"));
        let is_called = |looked: &&CandidateJoint| {
            let mut joints = 0..tree.joints.len();
            let of = joints.find(|&j| tree.joints[j].name == looked.joint);
            of.is_some_and(|j| !is_in(j) && is_called_wheel(tree, j))
        };
        let looked = self.looked.iter().filter(is_called).cloned();
        steered.chain(turning).chain(others).chain(looked).collect()
    }

    /// Returns all possible wheels, named or not.
    pub(super) fn likely(&self) -> Vec<&WheelLike> {
        self.turning.iter().chain(&self.others).collect()
    }
}
