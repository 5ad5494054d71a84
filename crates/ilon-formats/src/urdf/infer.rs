//! Which rollers wheels without rollers are meant to have, where the file says so.
//!
//! Most published bases model their wheels as plain discs and leave the rollers to a plug-in of a simulator. What such files say
//! of them is taken, in this order: a joint that turns in place of rollers, directions of friction, rollers that the wheels' meshes show, a plug-in that drives mecanum wheels,
//! axes on which plain wheels could not roll at all, and what they call them. That a plug-in moves the base in all directions says
//! nothing: steered wheels do so as well. How many rollers there are only meshes show: else that is a guess, and remarked.

use nalgebra::{Unit, Vector3};
use roxmltree::Node;

use super::candidates::{Survey, WheelLike, in_place_of_rollers};
use super::drawn_rollers::{self, Drawn};
use super::from_options;
use super::hub::hub_frame;
use super::loading::Loading;
use super::names::{self, is_mec, is_mecanum, is_omni};
use super::source::{Source, child};
use super::tree::{Motion, Tree};
use crate::error::{Looked, Proposed};
use crate::options::{Handedness, WheelOptions};

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
    left_out: &[Looked],
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
        return (Proposed::NothingSaid, hint(source));
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

/// What speaks of mecanum wheels, in words: a name or a plug-in.
fn speaks_of_mecanum(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> Option<String> {
    let in_short = || {
        let own = names_of_robot(source).into_iter();
        let of_wheels = wheels
            .iter()
            .flat_map(|wheel| names::of_wheel(source, tree, wheel.joint));
        own.chain(of_wheels).find(|name| is_mec(name))
    };
    let is_plain = is_driven_as_plain(source);
    let name = called(source, tree, wheels).or_else(|| in_short().filter(|_| !is_plain));
    let name = name.map(|name| format!("the name `{name}`"));
    name.or_else(|| plugin(source).map(|plugin| format!("the plug-in `{plugin}`")))
}

/// A comment that speaks of mecanum wheels as a heading does, without the lines that are drawn around it: enough to propose them, and too little to
/// take them. Longer ones tell what the robot was or may become.
fn heading(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> Option<String> {
    /// Longest heading, in bytes.
    const LONGEST: usize = 60;
    let comments = names::comments_beside(source, &tree.joints[wheels.first()?.joint].name);
    let mut headings = comments.into_iter().filter_map(|text| {
        let words = text.trim_matches(|c: char| !c.is_alphanumeric());
        let is_heading = words.len() <= LONGEST && !text.contains('<') && !words.contains('\n');
        is_heading.then(|| words.to_owned())
    });
    headings.find(|words| is_mecanum(words))
}

/// Why mecanum wheels cannot stand as these do, in words, with the joints that may be missing among them.
fn out_of_x(what: &str, left_out: &[Looked]) -> String {
    let beside = left_out.iter().filter(|of| of.is_too_high);
    let beside: Vec<String> = beside
        .map(|of| format!("; `{}` {}", of.joint, of.reason))
        .collect();
    format!(
        "{what} speaks of mecanum wheels, which stand on both sides of the middle, ahead of it and behind, as these do not{}",
        beside.concat()
    )
}

/// A plug-in that moves the base in all directions, where a name that is too little alone speaks for it as well: its own, or one that begins
/// as mecanum does.
fn mover(source: &Source) -> Option<String> {
    let plugin = planar_mover(source)?;
    let own = plugin.attribute("name").unwrap_or_default();
    let robot = names_of_robot(source);
    let mut names = robot.iter().map(String::as_str).chain([own]);
    let name = names.find(|name| names::is_free(name) || name.to_lowercase().contains("meca"))?;
    let file = plugin.attribute("filename").unwrap_or_default();
    Some(format!(
        "the plug-in `{file}` that moves the base in all directions, the name `{name}`"
    ))
}

/// The plug-in that moves a base in all directions, whatever carries it.
fn planar_mover<'a, 'i>(source: &'a Source<'i>) -> Option<Node<'a, 'i>> {
    let moves = |n: &Node| {
        let named = [n.attribute("filename"), n.attribute("name")];
        named
            .into_iter()
            .flatten()
            .any(|name| name.to_lowercase().contains("planar_move"))
    };
    plugin_elements(source).find(moves)
}

/// Whether the file itself lets wheels turn.
fn are_turning(tree: &Tree, wheels: &[WheelLike]) -> bool {
    let mut joints = wheels.iter().map(|wheel| &tree.joints[wheel.joint]);
    joints.all(|joint| joint.motion == Motion::Turning)
}

/// What hints at a robot that moves in all directions, but is not enough to propose rollers by, in words.
fn hint(source: &Source) -> Option<String> {
    let mover = planar_mover(source)?;
    let named = [mover.attribute("filename"), mover.attribute("name")];
    let plugin = named.into_iter().flatten().next()?;
    Some(format!(
        "the plug-in `{plugin}` moves the base in all directions, whatever its wheels are"
    ))
}

/// Rollers at an angle, as many and as thick as meshes show, or else a guess.
fn rollers(
    tree: &Tree,
    wheels: &[WheelLike],
    drawn: &Option<Vec<Drawn>>,
    gamma: Handedness,
) -> WheelOptions {
    let joints = wheels.iter().map(|w| tree.joints[w.joint].name.clone());
    let drawn = drawn.as_ref().map(|drawn| drawn[0]);
    let count = drawn.map_or(ROLLERS, |drawn| drawn.count);
    let mut rollers = WheelOptions::new(count, gamma).on(joints.collect());
    rollers.roller_radius_m = drawn.filter(Drawn::hands_over).map(|drawn| {
        // What touches may be of another size than what is shown.
        let disc_m = wheels[0].disc.map(|disc| disc.radius_m);
        let scale = disc_m.map_or(1.0, |disc_m| disc_m / drawn.wheel_radius_m);
        (1e4 * scale * drawn.roller_radius_m).round() / 1e4
    });
    rollers
}

/// The rollers that the meshes of all wheels show; `None` where one shows none, or others than the first does.
fn drawn(loading: &Loading, wheels: &[WheelLike]) -> Option<Vec<Drawn>> {
    let tree = loading.tree;
    let of_wheel = |like: &WheelLike| {
        let body = tree.lone_body(tree.joints[like.joint].child);
        let frame = hub_frame(&like.origin, &like.axis);
        drawn_rollers::of_wheel(&body, &frame, &loading.meshes)
    };
    let drawn: Vec<Drawn> = wheels.iter().map(of_wheel).collect::<Option<_>>()?;
    let are_equal = drawn.windows(2).all(|pair| pair[0].is_like(&pair[1]));
    are_equal.then_some(drawn)
}

/// gamma as the wheels' meshes show it, with what is said of that. Where wheels stand in an X they are handed by that: many files draw one mesh on all
/// of them, with which they could not drive. `None` of rollers with which wheels that stand so could not drive at all.
fn by_drawing(drawn: &[Drawn], wheels: &[WheelLike]) -> Option<(Handedness, String)> {
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

/// What a wheel itself is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Mecanum,
    Omni,
}

fn kind(source: &Source, tree: &Tree, wheel: &WheelLike) -> Option<Kind> {
    let names = names::of_wheel_itself(source, tree, wheel.joint);
    if names.iter().any(|name| is_mecanum(name)) {
        return Some(Kind::Mecanum);
    }
    let is_omni = names.iter().any(|name| is_omni(name));
    is_omni.then_some(Kind::Omni)
}

/// Whether some of the wheels are called mecanum wheels, and others omni wheels.
fn are_of_two_kinds(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> bool {
    let mut kinds = wheels.iter().filter_map(|like| kind(source, tree, like));
    let first = kinds.next();
    kinds.any(|kind| Some(kind) != first)
}

/// A name that speaks of moving in all directions: one of each wheel, where all are called omni wheels; or that of the robot, of its file or of the
/// package of a mesh.
fn free_name(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> Option<String> {
    let of_wheel = |wheel: &WheelLike| {
        let names = names::of_wheel_itself(source, tree, wheel.joint);
        names.into_iter().find(|name| is_omni(name))
    };
    let of_wheels: Option<Vec<String>> = wheels.iter().map(of_wheel).collect();
    if let Some(name) = of_wheels.and_then(|names| names.into_iter().next()) {
        return Some(name);
    }
    let shapes = tree.links.iter().flat_map(|link| {
        let shapes = link.visuals.iter().chain(&link.shapes);
        shapes.filter_map(|shape| match &shape.geometry {
            urdf_rs::Geometry::Mesh { filename, .. } => names::in_package(filename),
            _ => None,
        })
    });
    let packages = shapes.map(|(package, _)| package.to_owned());
    let mut own = names_of_robot(source).into_iter().chain(packages);
    own.find(|name| names::is_free(name))
}

/// Whether a plug-in or a controller drives the robot as one of plain wheels.
fn is_driven_as_plain(source: &Source) -> bool {
    const PLAIN: [&str; 4] = ["diff_drive", "diffdrive", "skid_steer", "ackermann"];
    let is_plain = |name: &str| {
        let lower = name.to_lowercase().replace('-', "_");
        PLAIN.iter().any(|word| lower.contains(word))
    };
    let settings = source.prepared.settings.iter();
    let mut types = settings.filter(|(key, _)| key == "type");
    types.any(|(_, kind)| is_plain(kind)) || plugins(source).any(is_plain)
}

/// Whether a wheel itself is called an omni wheel.
fn is_called_omni(source: &Source, tree: &Tree, wheel: &WheelLike) -> bool {
    let names = names::of_wheel_itself(source, tree, wheel.joint);
    names.iter().any(|name| is_omni(name))
}

/// The wheels in question: those that turn, or else all that could be.
fn wheels(survey: &Survey) -> Option<Vec<WheelLike>> {
    if survey.turning.len() >= LEAST_WHEELS {
        return Some(survey.turning.clone());
    }
    let likely: Vec<WheelLike> = survey.likely().into_iter().cloned().collect();
    (likely.len() >= LEAST_WHEELS).then_some(likely)
}

/// Whether all axes are parallel, within a few degrees.
fn are_parallel(wheels: &[WheelLike]) -> bool {
    wheels
        .windows(2)
        .all(|pair| are_aligned(&pair[0].axis, &pair[1].axis))
}

fn are_aligned(p: &Unit<Vector3<f64>>, q: &Unit<Vector3<f64>>) -> bool {
    p.dot(q).abs() > 0.99
}

/// Whether parallel wheels stand on both sides of the middle, and ahead of it and behind.
fn stand_in_x(wheels: &[WheelLike]) -> bool {
    let Some(first) = wheels.first().filter(|_| are_parallel(wheels)) else {
        return false;
    };
    let middle: Vector3<f64> =
        wheels.iter().map(|w| w.origin.coords).sum::<Vector3<f64>>() / wheels.len() as f64;
    let left = first.axis.into_inner();
    let ahead = left.cross(&Vector3::z());
    let both = |direction: &Vector3<f64>| {
        let places = || {
            wheels
                .iter()
                .map(|w| (w.origin.coords - middle).dot(direction))
        };
        places().any(|place| place > 1e-3) && places().any(|place| place < -1e-3)
    };
    wheels.len() >= 4 && both(&left) && both(&ahead)
}

/// gamma of each wheel in degrees, where below each one joint turns in place of its rollers, about the axis of the one on the ground.
fn by_joints(tree: &Tree, wheels: &[WheelLike]) -> Option<Vec<f64>> {
    let of_wheel = |wheel: &WheelLike| {
        let roller = in_place_of_rollers(tree, wheel.joint)?;
        gamma_deg(&wheel.axis, &tree.joints[roller].axis)
    };
    let each = wheels.iter().map(of_wheel).collect::<Option<Vec<f64>>>()?;
    // To a tenth: joints are placed by hand.
    Some(each.iter().map(|deg| (10.0 * deg).round() / 10.0).collect())
}

/// gamma of each wheel in degrees, where the file gives each a direction in which it grips and one in which it does not: that
/// direction is the axis of the roller on the ground.
fn by_friction(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> Option<Vec<f64>> {
    wheels
        .iter()
        .map(|wheel| {
            let body = tree.lone_body(tree.joints[wheel.joint].child);
            let link = &tree.links[body.link].name;
            let grip = friction_direction(source, tree, link)?;
            gamma_deg(&wheel.axis, &grip)
        })
        .collect()
}

/// The direction in which a link grips, in the body frame.
fn friction_direction(source: &Source, tree: &Tree, link: &str) -> Option<Vector3<f64>> {
    let settings = source
        .robot()
        .children()
        .filter(|n| n.has_tag_name("gazebo") && n.attribute("reference") == Some(link));
    let ode = settings
        .flat_map(|n| n.descendants())
        .find(|n| child(*n, "fdir1").is_some())?;
    let number = |tag: &str| child(ode, tag)?.text()?.trim().parse::<f64>().ok();
    let along = number("mu").or_else(|| number("mu1")).unwrap_or(1.0);
    let across = number("mu2")?;
    if across > 0.1 * along {
        return None;
    }
    let fdir1 = child(ode, "fdir1")?;
    // In the wheel's own frame, which turns with it, the direction would mean nothing.
    let frame = fdir1
        .attributes()
        .find(|a| a.name() == "expressed_in")?
        .value();
    let numbers: Vec<f64> = fdir1
        .text()?
        .split_whitespace()
        .filter_map(|word| word.parse().ok())
        .collect();
    let [x, y, z] = numbers[..] else { return None };
    let frame = tree.links.iter().find(|l| l.name == frame)?;
    Some(frame.body_from_link.rotation * Vector3::new(x, y, z))
}

/// gamma of a wheel whose roller on the ground has its axis along `grip`: the rolling direction is across it, and gamma the angle
/// to it from the hub axis.
fn gamma_deg(hub: &Unit<Vector3<f64>>, grip: &Vector3<f64>) -> Option<f64> {
    let rolling = grip.xy();
    let rolling = nalgebra::Vector2::new(rolling.y, -rolling.x).try_normalize(1e-6)?;
    let n = hub.xy().try_normalize(1e-6)?;
    let (sin, cos) = (n.perp(&rolling), n.dot(&rolling));
    // A direction and its opposite are one.
    let gamma_rad = if cos < 0.0 {
        libm::atan2(-sin, -cos)
    } else {
        libm::atan2(sin, cos)
    };
    let gamma_deg = gamma_rad.to_degrees();
    // Nearer to 90 degrees the roller would turn with the hub: that is a plain wheel's direction.
    (gamma_deg.abs() < 80.0).then_some(gamma_deg)
}

/// What drives mecanum wheels: a plug-in, by its name or file, or a controller that the settings of one name.
fn plugin(source: &Source) -> Option<String> {
    let types = source.prepared.settings.iter();
    let mut types = types.filter(|(key, _)| key == "type").map(|(_, kind)| kind);
    let controller = match types.clone().any(|kind| kind.contains("diff_drive")) {
        true => None,
        false => types.find(|kind| is_mecanum(kind)),
    };
    if let Some(controller) = controller {
        return Some(controller.clone());
    }
    plugins(source)
        .find(|name| is_mecanum(name))
        .map(str::to_owned)
}

/// The files and the names of a simulator's plug-ins.
fn plugins<'a>(source: &'a Source) -> impl Iterator<Item = &'a str> {
    plugin_elements(source)
        .flat_map(|n| [n.attribute("filename"), n.attribute("name")])
        .flatten()
}

/// The elements of a simulator's plug-ins.
fn plugin_elements<'a, 'i>(source: &'a Source<'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    let gazebo = source
        .robot()
        .children()
        .filter(|n| n.has_tag_name("gazebo"));
    let elements = gazebo.flat_map(|n| n.children());
    elements.filter(|n| n.has_tag_name("plugin"))
}

/// Where the file calls the wheels mecanum wheels: by their joints, links or meshes, by the macro that makes them or the file that
/// they come from, by the robot's name or the file's own.
fn called(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> Option<String> {
    let of_wheel = |wheel: &WheelLike| {
        let names = names::of_wheel(source, tree, wheel.joint);
        names.into_iter().find(|name| is_mecanum(name))
    };
    wheels
        .iter()
        .find_map(of_wheel)
        .or_else(|| robot_called(source))
}

/// The name of the robot, or else of its file, where it speaks of mecanum wheels.
fn robot_called(source: &Source) -> Option<String> {
    names_of_robot(source)
        .into_iter()
        .find(|name| is_mecanum(name))
}

/// The name of the robot, and that of its file.
fn names_of_robot(source: &Source) -> Vec<String> {
    let robot = source.robot().attribute("name").map(str::to_owned);
    let file = std::path::Path::new(&source.prepared.file)
        .file_name()
        .map(|name| name.to_string_lossy().into_owned());
    [robot, file].into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_of_the_roller_on_the_ground_gives_gamma() {
        // At the front left of the usual X the roller on the ground lies along (1, -1): gamma = -45 deg (see `from_options`).
        let left = Vector3::y_axis();
        for (grip, gamma) in [
            ([1.0, -1.0], Some(-45.0)),
            ([-1.0, 1.0], Some(-45.0)),
            ([1.0, 1.0], Some(45.0)),
            // A wheel that grips where it drives and slides sideways is an omni wheel.
            ([1.0, 0.0], Some(0.0)),
            // One that grips along its axis is none at all.
            ([0.0, 1.0], None),
        ] {
            let found = gamma_deg(&left, &Vector3::new(grip[0], grip[1], 0.0));
            match (found, gamma) {
                (Some(found), Some(gamma)) => {
                    let found: f64 = found;
                    assert!((found - gamma).abs() < 1e-12, "{found}");
                }
                (found, gamma) => assert_eq!(found, gamma),
            }
        }
    }
}
