//! Decides which joints besides wheels and rollers move, and builds their bodies.
//!
//! A joint is *free* if it carries wheels that balance on either side of its axis and nothing
//! drives it, like a rocker; *sprung* if the file or the user says so; *driven* if the user says
//! so; otherwise *held* at zero, as a part of its carrier. A joint that mimics a moving one is free
//! and follows it.

use std::collections::{HashMap, HashSet};

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::asked_joint::{Role, asked, refused};
use super::casters;
use super::check;
use super::from_options::BareWheel;
use super::loading::Loading;
use super::names;
use super::recognise::Candidate;
use super::transmission;
use super::tree::{Motion, Tree};
use crate::error::{Fault, RobotError};
use crate::options::{JointOptions, RoleOption};
use ilon_robot::{
    Body, BodyJoint, Coupling, JointKind, JointRole, JointServo, JointSpring, MassProperties,
    Remark, Robot, Scale, Wheel,
};

/// Longest chain of moving joints from the chassis to a wheel's own.
const DEEPEST: usize = 6;

/// The joints of the file that move bodies, parents before their children.
#[derive(Debug, Default)]
pub(super) struct Linkage {
    joints: Vec<(usize, Role)>,
}

impl Linkage {
    /// The joints, by their indices in the tree.
    pub(super) fn joints(&self) -> impl Iterator<Item = usize> {
        self.joints.iter().map(|(joint, _)| *joint)
    }

    /// Sets the gains of a robot's servos. Missing ones give the largest inertia on the joint, with
    /// all others held, the natural frequency [`JointServo::FREQUENCY_HZ`] with critical damping.
    pub(super) fn set_gains(&self, robot: &mut Robot) -> Vec<Remark> {
        let mut remarks = Vec::new();
        for (index, (_, role)) in self.joints.iter().enumerate() {
            let inertia = robot.most_inertia_on_joint(index);
            let scrub_n_m = scrub_n_m(robot, index);
            let joint = &mut robot.joints[index];
            let JointRole::Driven(servo) = &mut joint.role else {
                continue;
            };
            let [stiffness, damping] = role.gains;
            let for_scrub = scrub_n_m / SCRUBBED_RAD;
            let chosen = JointServo::stiffness_for(inertia).max(for_scrub);
            servo.stiffness = stiffness.unwrap_or(chosen);
            servo.damping = damping.unwrap_or(JointServo::damping_for(inertia, servo.stiffness));
            let [n, rad, of] = match joint.kind {
                JointKind::Turns => ["N m", "rad", "kg m^2"],
                JointKind::Slides => ["N", "m", "kg"],
            };
            let chosen = match role.gains {
                [None, None] if servo.stiffness == for_scrub => format!(
                    " (what turns tyres on the spot at friction 1, {scrub_n_m:.3} {n}, turns it by {SCRUBBED_RAD} {rad}; critically damped)"
                ),
                [None, None] => format!(
                    " ({} Hz, critically damped, for the largest inertia, {inertia:.4} {of})",
                    JointServo::FREQUENCY_HZ
                ),
                [Some(_), None] => " (critical)".to_owned(),
                _ => String::new(),
            };
            let most = |value: f64, unit: &str| {
                if value.is_finite() {
                    format!("{value} {unit}")
                } else {
                    "no limit".to_owned()
                }
            };
            let words = format!(
                "driven: a servo of {:.3} {n}/{rad} and {:.3} {n} s/{rad}{chosen}; effort: {}, rate: {}",
                servo.stiffness,
                servo.damping,
                most(servo.effort, n),
                most(servo.rate_limit, &format!("{rad}/s")),
            );
            remarks.push(Remark::aside(format!("joint `{}`", joint.name), words));
        }
        remarks
    }

    fn place_of(&self, joint: usize) -> Option<usize> {
        self.joints().position(|other| other == joint)
    }
}

/// By how much the moment that turns a steered tyre on the spot turns its servo, in rad: the circle
/// of a wheel that stands at s is larger by twice this over sin(2 s), a thousandth at 45 degrees
/// (chosen).
const SCRUBBED_RAD: f64 = 0.0005;

/// Returns the moment that turns the tyres which a joint steers on the spot at friction 1, with an
/// even share of the weight on each wheel, in N m; 0 for any other joint.
fn scrub_n_m(robot: &Robot, joint: usize) -> f64 {
    let steered = |wheel: &&Wheel| wheel.has_tyre() && robot.steering_of(wheel) == Some(joint);
    let load_n = Scale::of(robot, 9.81).load_kg * 9.81;
    let moments = robot.wheels.iter().filter(steered).map(|wheel| {
        let widths_m = wheel.rollers.iter().map(|tyre| tyre.length_m);
        0.25 * load_n * widths_m.sum::<f64>()
    });
    moments.sum()
}

/// Decides which joints move.
pub(super) fn decide(
    loading: &mut Loading,
    candidates: &[Candidate],
    given: &[BareWheel],
) -> Result<Linkage, RobotError> {
    let tree = loading.tree;
    let wheels_and_rollers = moving(candidates, given);
    refuse_strangers(loading, &wheels_and_rollers)?;
    let hubs = candidates
        .iter()
        .map(|candidate| candidate.hub)
        .chain(given.iter().map(|given| given.like.joint));
    let hubs: Vec<(usize, HashSet<usize>)> = hubs
        .map(|hub| (hub, tree.joints_above(hub).collect()))
        .collect();
    let axles_m = hubs.iter().map(|(hub, _)| tree.joints[*hub].origin.z);
    let axles_m = axles_m.fold(f64::INFINITY, f64::min);
    let driven: HashSet<usize> = transmission::drives(loading.source, tree)
        .keys()
        .filter_map(|name| tree.joints.iter().position(|joint| joint.name == *name))
        .collect();
    let springs = transmission::springs(loading.source);
    let order = from_the_top(tree);
    let mut roles: Vec<Option<Role>> = vec![None; tree.joints.len()];
    // Joints without a given role, and the wheels that they carry.
    let mut open: Vec<(usize, Vec<usize>)> = Vec::new();
    // For each joint whether it is a wheel's or below one. Chains may be long: each joint is
    // visited once.
    let mut of_wheel = vec![false; tree.joints.len()];
    for &joint in &order {
        let is_wheel = wheels_and_rollers.contains(&joint);
        let above = tree.joints_above(joint).next();
        let in_wheel = above.is_some_and(|above| of_wheel[above]);
        of_wheel[joint] = is_wheel || in_wheel;
        if is_wheel && springs.contains_key(&tree.joints[joint].name) {
            let subject = format!("joint `{}`", tree.joints[joint].name);
            let words =
                "the file's spring in it is not simulated: it is a wheel's or a roller's own joint";
            loading.remarks.push(Remark::new(subject, words));
        }
        if is_wheel || in_wheel || tree.joints[joint].motion == Motion::Fixed {
            continue;
        }
        let carried_by = |joint: usize| -> Vec<usize> {
            let below = hubs.iter().filter(|(_, above)| above.contains(&joint));
            below.map(|(hub, _)| *hub).collect()
        };
        let carried = carried_by(joint);
        // Both rockers of a differential bar are free, one following the other.
        let follows_rocker = || {
            master(tree, joint).is_some_and(|master| {
                let asked = loading.options.joints.get(&tree.joints[master].name);
                let alone = !tree.joints[master].mimics && asked.is_none();
                let carried = carried_by(master);
                alone && default_role(tree, (master, false), &carried, &driven).is_some()
            })
        };
        let options = loading.options.joints.get(&tree.joints[joint].name);
        let role = match options {
            Some(options) => asked(loading, joint, options)?,
            None => match springs.get(&tree.joints[joint].name) {
                Some(spring) => sprung(loading, joint, spring),
                None if steers(tree, joint, &carried, given) => {
                    let servo = JointOptions {
                        role: Some(RoleOption::Driven),
                        ..JointOptions::default()
                    };
                    asked(loading, joint, &servo)?
                }
                None if is_free_caster(tree, joint, given, axles_m) => {
                    let free = JointOptions {
                        role: Some(RoleOption::Free),
                        ..JointOptions::default()
                    };
                    let role = asked(loading, joint, &free)?;
                    role.map(|role| Role {
                        why: "free: a caster".to_owned(),
                        ..role
                    })
                }
                None => {
                    let bound = tree.joints[joint].mimics && !follows_rocker();
                    default_role(tree, (joint, bound), &carried, &driven)
                }
            },
        };
        // A joint to the world, below which all that weighs hangs, is held.
        let carries_robot = || tree.rigid_body(tree.root, |j| j == joint).mass.is_none();
        roles[joint] = role.filter(|_| options.is_some() || !carries_robot());
        if options.is_none() && roles[joint].is_none() {
            open.push((joint, carried));
        }
    }
    follow(tree, &open, &mut roles);
    for (joint, carried) in &open {
        let why = || why_it_does_not_follow(tree, *joint, &roles);
        if roles[*joint].is_none()
            && let Some(words) = why().or_else(|| why_no_rocker(tree, *joint, carried))
        {
            let subject = format!("joint `{}`", tree.joints[*joint].name);
            loading.remarks.push(Remark::new(subject, words));
        }
    }
    in_order(loading, &order, roles)
}

/// Returns the moving joints, parents before their children. In a longer chain those are held that
/// nobody gave a role.
fn in_order(
    loading: &mut Loading,
    order: &[usize],
    mut roles: Vec<Option<Role>>,
) -> Result<Linkage, RobotError> {
    let tree = loading.tree;
    let mut linkage = Linkage::default();
    // The number of moving joints from the chassis to each.
    let mut movers = vec![0; tree.joints.len()];
    let above = |movers: &[usize], joint| {
        let above = tree.joints_above(joint).next();
        above.map_or(0, |above| movers[above])
    };
    for &joint in order {
        movers[joint] = above(&movers, joint) + usize::from(roles[joint].is_some());
    }
    // What is too far from the chassis is held below; what follows it is held too.
    let options = loading.options;
    let is_open = |joint: usize| !options.joints.contains_key(&tree.joints[joint].name);
    let open = order.iter().copied().filter(|joint| is_open(*joint));
    let followers = followers(tree, open);
    let mut held: Vec<usize> = order.to_vec();
    held.retain(|joint| movers[*joint] > DEEPEST);
    while let Some(master) = held.pop() {
        for &joint in followers.get(&master).into_iter().flatten() {
            if movers[joint] <= DEEPEST && roles[joint].take().is_some() {
                let words = format!(
                    "held, as `{}`, which it follows, is",
                    tree.joints[master].name
                );
                let subject = format!("joint `{}`", tree.joints[joint].name);
                loading.remarks.push(Remark::new(subject, words));
                held.push(joint);
            }
        }
    }
    for &joint in order {
        movers[joint] = above(&movers, joint);
        let Some(role) = roles[joint].take() else {
            continue;
        };
        check_joint(loading, joint)?;
        if movers[joint] >= DEEPEST {
            let name = &tree.joints[joint].name;
            if loading.options.joints.contains_key(name) {
                let words = format!(
                    "it would be the {}th joint that moves on the way from the chassis; at most {DEEPEST} may follow one another: hold \
                     one of them",
                    DEEPEST + 1
                );
                return Err(refused(loading, joint, words));
            }
            let words = format!(
                "held: {DEEPEST} joints that move precede it on the way from the chassis, and no more may; hold one of them in [robot.joints.NAME] to let it move"
            );
            let subject = format!("joint `{name}`");
            loading.remarks.push(Remark::new(subject, words));
            continue;
        }
        movers[joint] += 1;
        linkage.joints.push((joint, role));
    }
    Ok(linkage)
}

/// The joints that follow each joint, of these.
fn followers(tree: &Tree, joints: impl Iterator<Item = usize>) -> HashMap<usize, Vec<usize>> {
    let names = tree.joints.iter().enumerate();
    let at: HashMap<&str, usize> = names.map(|(at, joint)| (&joint.name[..], at)).collect();
    let mut followers: HashMap<usize, Vec<usize>> = HashMap::new();
    for joint in joints {
        let mimic = tree.joints[joint].mimic.as_ref();
        let master = mimic.and_then(|mimic| at.get(&mimic.joint[..]));
        if let Some(master) = master.filter(|master| **master != joint) {
            followers.entry(*master).or_default().push(joint);
        }
    }
    followers
}

/// Lets joints without a given role follow those that they mimic, if these move.
fn follow(tree: &Tree, open: &[(usize, Vec<usize>)], roles: &mut [Option<Role>]) {
    let mut followers = followers(tree, open.iter().map(|(joint, _)| *joint));
    let moves = |joint: &usize| roles[*joint].is_some();
    let mut waiting: Vec<usize> = followers.keys().copied().filter(moves).collect();
    while let Some(master) = waiting.pop() {
        for joint in followers.remove(&master).unwrap_or_default() {
            if why_it_does_not_follow(tree, joint, roles).is_none() {
                roles[joint] = follower(tree, joint);
                waiting.push(joint);
            }
        }
    }
}

/// Returns the role of a joint that mimics a moving one.
fn follower(tree: &Tree, joint: usize) -> Option<Role> {
    let of = &tree.joints[joint];
    let mimic = of.mimic.as_ref()?;
    Some(Role {
        role: JointRole::Free,
        damping: of.losses.damping_n_m_s,
        friction: of.losses.friction_n_m,
        gains: [None; 2],
        why: format!(
            "free: it follows `{}`, which moves, by {}",
            mimic.joint, mimic.multiplier
        ),
    })
}

/// Returns why a joint that mimics a moving one is held anyway; `None` for others.
fn why_it_does_not_follow(tree: &Tree, joint: usize, roles: &[Option<Role>]) -> Option<String> {
    let of = &tree.joints[joint];
    let master = master(tree, joint).filter(|master| roles[*master].is_some())?;
    let [lower, upper] = of.travel;
    let why = if of.motion == Motion::Other && !of.slides {
        "it floats or moves in a plane".to_owned()
    } else if !weighs(tree, joint) {
        let link = &tree.links[of.child].name;
        format!("it moves link `{link}`, which has no mass; give it an `<inertial>`")
    } else if lower >= upper {
        no_way(lower, upper).join("; ")
    } else {
        return None;
    };
    let master = &tree.joints[master].name;
    Some(format!(
        "held, though it mimics `{master}`, which moves: {why}"
    ))
}

/// Returns the moving joints: wheels and rollers.
pub(super) fn moving(candidates: &[Candidate], given: &[BareWheel]) -> HashSet<usize> {
    candidates
        .iter()
        .flat_map(|c| c.rollers.iter().copied().chain([c.hub]))
        .chain(given.iter().map(|g| g.like.joint))
        .collect()
}

/// Builds the bodies and couplings, and the carrier of each wheel.
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
        let mut body = tree.rigid_body(of.child, |j| moving.contains(&j));
        casters::of_meshed_wheel(tree, *joint, &mut body, &loading.meshes);
        let rounded = casters::of_rounded_wheel(tree, *joint, &mut body, wheels);
        loading.remarks.extend(rounded);
        body.remark_held(
            tree,
            &format!("joint `{}`", of.name),
            &[],
            &mut loading.remarks,
        );
        if body.mass.is_none()
            && let Some(share) = share_of_load(tree, *joint)
        {
            let words = format!(
                "its link `{}` has no mass: it takes {:.0} % of what it carries, {:.3} g",
                tree.links[of.child].name,
                100.0 * LIGHT_SHARE,
                1e3 * share.mass_kg
            );
            let subject = format!("joint `{}`", of.name);
            loading.remarks.push(Remark::new(subject, words));
            body.mass = Some(share);
        }
        if body.mass.is_none() {
            let words = format!(
                "it moves link `{}`, which has no mass: give it an `<inertial>`, or hold the joint",
                tree.links[of.child].name
            );
            return Err(refused(loading, *joint, words));
        }
        let collisions = check::chassis(loading, body, false)?;
        let body_from_joint = frame(of.origin.coords, &of.axis);
        let mut above = tree.joints_above(*joint);
        joints.push(BodyJoint {
            name: of.name.clone(),
            parent: above.find_map(|at| linkage.place_of(at)),
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
        if !role.why.is_empty() {
            let subject = format!("joint `{}`", of.name);
            loading
                .remarks
                .push(Remark::aside(subject, role.why.clone()));
        }
    }
    for wheel in wheels {
        let hub = tree
            .joints
            .iter()
            .position(|joint| joint.name == wheel.name);
        let mut above = hub.into_iter().flat_map(|hub| tree.joints_above(hub));
        wheel.carrier = above.find_map(|at| linkage.place_of(at));
    }
    Ok((joints, couplings(tree, linkage)))
}

/// The share of what it carries that a moving link without mass takes: enough for the numbers, and
/// too little to see. Chosen.
const LIGHT_SHARE: f64 = 0.01;

/// The mass of a moving link that has none: a share of all that hangs on it by other joints, where
/// that is; `None` if nothing there weighs.
fn share_of_load(tree: &Tree, joint: usize) -> Option<MassProperties> {
    let load = tree.rigid_body(tree.joints[joint].child, |_| false).mass?;
    Some(MassProperties {
        mass_kg: LIGHT_SHARE * load.mass_kg,
        inertia_kg_m2: LIGHT_SHARE * load.inertia_kg_m2,
        ..load
    })
}

/// Whether a joint moves anything that weighs.
fn weighs(tree: &Tree, joint: usize) -> bool {
    let child = tree.joints[joint].child;
    tree.links[child].mass.is_some() || share_of_load(tree, joint).is_some()
}

/// Returns the joint that a joint of the tree mimics, if it exists.
fn master(tree: &Tree, joint: usize) -> Option<usize> {
    let mimic = tree.joints[joint].mimic.as_ref()?;
    let master = tree.joints.iter().position(|of| of.name == mimic.joint)?;
    (master != joint).then_some(master)
}

/// Returns the couplings of mimic joints that both move.
fn couplings(tree: &Tree, linkage: &Linkage) -> Vec<Coupling> {
    let coupling = |(place, (joint, _)): (usize, &(usize, Role))| {
        let mimic = tree.joints[*joint].mimic.as_ref()?;
        Some(Coupling {
            joint: place,
            follows: linkage
                .place_of(master(tree, *joint)?)
                .filter(|other| *other != place)?,
            factor: mimic.multiplier,
            offset: mimic.offset,
        })
    };
    let joints = linkage.joints.iter().enumerate();
    joints.filter_map(coupling).collect()
}

/// Returns a joint's frame, with its z along the axis.
pub(crate) fn frame(origin_m: Vector3<f64>, axis: &Vector3<f64>) -> Isometry3<f64> {
    // The axis of the body frame with the smallest component along it.
    let helper = Vector3::ith(axis.iamin(), 1.0);
    let x = helper.cross(axis).normalize();
    let rotation = Matrix3::from_columns(&[x, axis.cross(&x), *axis]);
    let rotation = Rotation3::from_matrix_unchecked(rotation);
    Isometry3::from_parts(
        Translation3::from(origin_m),
        UnitQuaternion::from_rotation_matrix(&rotation),
    )
}

/// Returns all joints, parents before their children.
fn from_the_top(tree: &Tree) -> Vec<usize> {
    let mut found = Vec::with_capacity(tree.joints.len());
    let mut waiting = vec![tree.root];
    while let Some(link) = waiting.pop() {
        for &joint in &tree.links[link].joints_below {
            waiting.push(tree.joints[joint].child);
            found.push(joint);
        }
    }
    found
}

/// Returns the default role of a joint; `None` if it is held.
fn default_role(
    tree: &Tree,
    (joint, bound): (usize, bool),
    carried: &[usize],
    driven: &HashSet<usize>,
) -> Option<Role> {
    let of = &tree.joints[joint];
    let is_driven = of.effort > 0.0 || driven.contains(&joint) || bound;
    if of.motion != Motion::Swinging || is_driven || of.travel[0] >= of.travel[1] {
        return None;
    }
    (balance(tree, joint, carried) && weighs(tree, joint)).then(|| Role {
        role: JointRole::Free,
        damping: of.losses.damping_n_m_s,
        friction: of.losses.friction_n_m,
        gains: [None; 2],
        why: format!(
            "free: nothing drives it (effort 0), and it carries wheels on both sides of its axis ({}), between {:.4} and {:.4} rad{}",
            named(tree, carried),
            of.travel[0],
            of.travel[1],
            of.mimic.as_ref().map_or_else(String::new, |mimic| format!(
                "; it follows `{}` by {}, as on a differential bar",
                mimic.joint, mimic.multiplier
            ))
        ),
    })
}

/// Whether a joint belongs to a caster that swivels, and turns freely. On rollers a caster is one
/// that is called so, or shows a disc: a joint of an arm may trail another.
fn is_free_caster(tree: &Tree, joint: usize, given: &[BareWheel], axles_m: f64) -> bool {
    let of = &tree.joints[joint];
    of.motion == Motion::Turning
        && (given.iter().any(BareWheel::has_tyre)
            || names::is_called_caster(tree, joint)
            || casters::carries_disc(tree, joint, axles_m))
        && casters::swivels_freely(tree, joint)
        && weighs(tree, joint)
}

/// Whether a joint steers wheels on tyres: it turns about an upright axis, and carries nothing else
/// that drives. A caster's whose tyre nothing drives swivels freely.
fn steers(tree: &Tree, joint: usize, carried: &[usize], given: &[BareWheel]) -> bool {
    /// Cosine of the largest lean of an upright axis.
    const UPRIGHT: f64 = 0.99;
    let of = &tree.joints[joint];
    let turns = matches!(of.motion, Motion::Turning | Motion::Swinging);
    let all = |is: fn(&BareWheel) -> bool| {
        let is_one = |hub| given.iter().any(|of| of.like.joint == hub && is(of));
        carried.iter().copied().all(is_one)
    };
    let swivels = casters::swivels_freely(tree, joint) && all(BareWheel::rolls_along);
    let is_upright = turns && of.axis.z.abs() > UPRIGHT;
    is_upright && !carried.is_empty() && all(BareWheel::has_tyre) && !swivels
}

/// Whether loads on the wheels of a joint turn it in both directions, against each other.
fn balance(tree: &Tree, joint: usize, carried: &[usize]) -> bool {
    let of = &tree.joints[joint];
    let turns = |hub: &usize| {
        let lever_m = tree.joints[*hub].origin - of.origin;
        lever_m.cross(&Vector3::z()).dot(&of.axis)
    };
    let least = carried.iter().map(turns).fold(f64::INFINITY, f64::min);
    let most = carried.iter().map(turns).fold(f64::NEG_INFINITY, f64::max);
    least < -1e-6 && most > 1e-6
}

/// Returns why a joint that carries wheels like a rocker is held anyway; `None` for others.
fn why_no_rocker(tree: &Tree, joint: usize, carried: &[usize]) -> Option<String> {
    let of = &tree.joints[joint];
    if of.motion != Motion::Swinging || of.effort > 0.0 || !balance(tree, joint, carried) {
        return None;
    }
    if let Some(mimic) = &of.mimic {
        let known = tree.joints.iter().any(|other| other.name == mimic.joint);
        return Some(match (known, mimic.joint == of.name) {
            (_, true) => {
                "held: it mimics itself; leave its `<mimic>` out, and it is free as a rocker is"
                    .to_owned()
            }
            (false, _) => format!(
                "held: it mimics `{}`, which is no joint of the file; name another, or leave its `<mimic>` out, and it is free as a rocker is",
                mimic.joint
            ),
            (true, false) => format!(
                "held: it mimics `{}`; give that one a role in [robot.joints.NAME], and it follows",
                mimic.joint
            ),
        });
    }
    let [lower, upper] = of.travel;
    if lower >= upper {
        let [what, repair] = no_way(lower, upper);
        return Some(format!(
            "held: {what}; {repair}, and it is free as a rocker is"
        ));
    }
    let child = &tree.links[of.child];
    (!weighs(tree, joint)).then(|| {
        format!(
            "held: it moves link `{}`, which has no mass; give it an `<inertial>`, and it is free as a rocker is",
            child.name
        )
    })
}

/// Returns the role of a joint with a spring in the file; `None`, with a remark, if nothing can
/// move on it.
fn sprung(loading: &mut Loading, joint: usize, spring: &JointSpring) -> Option<Role> {
    let tree = loading.tree;
    let of = &tree.joints[joint];
    let [n, rad] = if of.slides {
        ["N", "m"]
    } else {
        ["N m", "rad"]
    };
    let has_mass = weighs(tree, joint);
    if !has_mass || of.travel[0] >= of.travel[1] {
        let why = if has_mass {
            "its limits leave it no way"
        } else {
            "it moves a link without mass"
        };
        let words = format!(
            "the file's spring of {} {n}/{rad} does nothing: {why}",
            spring.stiffness
        );
        let subject = format!("joint `{}`", of.name);
        loading.remarks.push(Remark::new(subject, words));
        return None;
    }
    Some(Role {
        role: JointRole::Sprung(*spring),
        damping: of.losses.damping_n_m_s,
        friction: of.losses.friction_n_m,
        gains: [None; 2],
        why: format!(
            "sprung, {} {n}/{rad} about {} {rad}, with {} {n} s/{rad} of damping: as the file says",
            spring.stiffness, spring.rest, of.losses.damping_n_m_s
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

/// Rejects options for joints that are missing, or that are wheels and rollers.
fn refuse_strangers(loading: &Loading, wheels: &HashSet<usize>) -> Result<(), RobotError> {
    let tree = loading.tree;
    for name in loading.options.joints.keys() {
        let Some(joint) = tree.joints.iter().position(|joint| joint.name == *name) else {
            // Wheels and rollers have no role.
            let places = (0..tree.joints.len()).filter(|joint| !wheels.contains(joint));
            let others = places.map(|joint| tree.joints[joint].name.as_str());
            return Err(loading
                .source
                .robot_error(Fault::unknown_joint(name, others)));
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

/// Says that limits leave a joint no way, and the repair.
fn no_way(lower: f64, upper: f64) -> [String; 2] {
    if lower == upper {
        let what = format!("both of its limits are {lower}, so that it cannot move");
        return [what, "set them apart".to_owned()];
    }
    let what = format!("its lower limit of {lower} is not below its upper one of {upper}");
    [what, "exchange them".to_owned()]
}

/// Rejects stops in the wrong order.
fn check_joint(loading: &Loading, joint: usize) -> Result<(), RobotError> {
    let of = &loading.tree.joints[joint];
    let [lower, upper] = of.travel;
    if lower < upper {
        return Ok(());
    }
    let [what, repair] = no_way(lower, upper);
    let words = format!("{what}: {repair}, or hold the joint");
    Err(refused(loading, joint, words))
}
