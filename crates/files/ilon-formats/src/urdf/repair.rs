//! Repairs the text of a URDF where it is safe, and reports the changes.
//!
//! Each change responds to an error of the text, and replaces or inserts within a line, so that
//! line numbers stay the same.

use std::collections::{HashMap, HashSet};
use std::f64::consts::PI;
use std::ops::Range;

use nalgebra::{Isometry3, Point3, Vector3};
use roxmltree::Node;

use super::geometry::primitive;
use super::inertia_from_shapes;
use super::source::{Source, child, describe};
use super::tree::{Motion, Tree};
use super::urdf_text::{Edit, UrdfText};
use super::{normalise, recognise};
use crate::error::{Fault, RobotError, is_zero_size};
use crate::generate::elements::{attribute as escaped, inertia};
use crate::model::{Collision, MassProperties, Remark, Robot};
use crate::options::LoadOptions;
use crate::solid::Solid;

/// Wheels whose lowest points differ by at most this are levelled, in metres; larger differences
/// are intended.
const LEVELLED_M: f64 = 0.005;
/// Wheels whose lowest points differ by less than this are level.
const LEVEL_M: f64 = 1e-6;
/// A part of at most this share of the robot's mass is light.
const LIGHT_SHARE: f64 = 0.05;

/// Returns the text with the inertias of light parts repaired, if an error contains nothing else;
/// `None` otherwise. The mass distribution of a light part of the chassis hardly matters, so the
/// robot need not be rejected.
pub(crate) fn with_light_parts_repaired(
    prepared: &UrdfText,
    error: &RobotError,
    options: &LoadOptions,
) -> Option<UrdfText> {
    let source = Source::parse(prepared).ok()?;
    let mass_kg = |link: Node| {
        let mass = child(child(link, "inertial")?, "mass")?;
        mass.attribute("value")?.trim().parse::<f64>().ok()
    };
    let robot_kg: f64 = source.all("link").filter_map(mass_kg).sum();
    let end = |joint: Node, tag: &str| child(joint, tag)?.attribute("link").map(str::to_owned);
    let joints = source.all("joint");
    let above: HashMap<String, Node> = joints
        .filter_map(|joint| Some((end(joint, "child")?, joint)))
        .collect();
    // If nothing that turns endlessly is in between: no part of a wheel or roller. Each link is
    // looked at once; the first that is no part of the chassis ends it all.
    let mut seen = HashSet::new();
    let mut is_of_chassis = |link: Node| {
        let mut name = link.attribute("name").map(str::to_owned);
        while let Some(link) = name.filter(|name| seen.insert(name.clone())) {
            let Some(joint) = above.get(&link) else {
                return true;
            };
            if joint.attribute("type") == Some("continuous") {
                return false;
            }
            name = end(*joint, "parent");
        }
        true
    };
    let mut all = std::iter::once(error).chain(error.others());
    let are_light = all.all(|error| {
        let is_spread = match error.fault() {
            Fault::MissingElement { child } => *child == "inertia",
            Fault::InertiaNotPositive { .. } | Fault::InertiaImpossible { .. } => true,
            _ => false,
        };
        let link = source
            .node_of(error)
            .and_then(|node| node.ancestors().find(|n| n.has_tag_name("link")));
        let mut is_light = |link: Node| {
            mass_kg(link).is_some_and(|kg| kg > 0.0 && kg <= LIGHT_SHARE * robot_kg)
                && is_of_chassis(link)
        };
        is_spread && link.is_some_and(&mut is_light)
    });
    are_light
        .then(|| repaired(prepared, error, options))
        .flatten()
}

/// Returns the text with all possible repairs for an error; `None` if there are none.
pub(crate) fn repaired(
    prepared: &UrdfText,
    error: &RobotError,
    options: &LoadOptions,
) -> Option<UrdfText> {
    let source = Source::parse(prepared).ok()?;
    let mut edits: Vec<Edit> = Vec::new();
    let mut remarks = Vec::new();
    for error in std::iter::once(error).chain(error.others()) {
        let Some(node) = source.node_of(error) else {
            continue;
        };
        if let Some((edit, said)) = repair(&source, node, error.fault(), options) {
            // One change may repair several faults of an element.
            let end = |range: &Range<usize>| range.end.max(range.start + 1);
            let is_changed = |(new, _): &Edit| {
                let known = |(old, _): &Edit| old.start < end(new) && new.start < end(old);
                edits.iter().any(known)
            };
            if edit.iter().any(is_changed) {
                continue;
            }
            let mut remark = Remark::new(describe(node), format!("repaired: {said}"));
            source.place_at(&mut remark, node);
            edits.extend(edit);
            remarks.push(remark);
        }
    }
    if edits.is_empty() {
        return None;
    }
    let mut repaired = prepared.edited(edits);
    repaired.remarks.extend(remarks);
    Some(repaired)
}

/// Returns the changes that repair an element's fault, with a description.
fn repair(
    source: &Source,
    node: Node,
    fault: &Fault,
    options: &LoadOptions,
) -> Option<(Vec<Edit>, String)> {
    match fault {
        Fault::DuplicateName { tag, .. } => rename(source, node, tag),
        Fault::HubDoesNotTurn { .. } => turn_hub(source, node),
        Fault::RollersDoNotTurn { .. } => turn_rollers(source),
        Fault::NoAxis => state_axis(source, node),
        Fault::ChassisBelowFloor { deep_mm, .. } => leave_out_lowest(source, 1e-3 * deep_mm),
        Fault::MissingAttribute { .. } if number_in(node).is_some() => move_number(source, node),
        Fault::OutOfRange { key, value, .. } if is_zero_size(key, value) => {
            let shape = node.ancestors().find(|n| n.has_tag_name("collision"))?;
            let lines = lines_of(&source.text()[shape.range()]);
            let said = format!("left out: it has no size (`{key}=\"{value}\"`)");
            Some((vec![(shape.range(), lines)], said))
        }
        // An intentional error, such as a mass below 0, is not guessed.
        Fault::OutOfRange { value, .. } if value != "0" => None,
        Fault::NoMass
        | Fault::MissingElement { .. }
        | Fault::MissingAttribute { .. }
        | Fault::OutOfRange { .. }
        | Fault::InertiaNotPositive { .. }
        | Fault::InertiaImpossible { .. }
        | Fault::InertiaTooLarge { .. }
        | Fault::InertiaTooSmall { .. }
        | Fault::InertiaExchanged
        | Fault::InertiaThinAboutAxle { .. } => {
            let link = node.ancestors().find(|n| n.has_tag_name("link"))?;
            let inertial = child(link, "inertial");
            let of_inertia = ["link", "inertial", "mass", "inertia"];
            if !of_inertia.contains(&node.tag_name().name()) {
                return None;
            }
            weigh(source, link, inertial, options)
        }
        _ => None,
    }
}

/// Returns the number that a `<mass>` contains instead of an attribute.
fn number_in(node: Node) -> Option<f64> {
    let text = node.text().filter(|_| node.has_tag_name("mass"))?;
    let number = text.trim().parse::<f64>().ok();
    number.filter(|kg| kg.is_finite() && *kg > 0.0)
}

/// Interprets `<mass>2.5</mass>` as intended.
fn move_number(source: &Source, node: Node) -> Option<(Vec<Edit>, String)> {
    let kg = number_in(node)?;
    let lines = lines_of(&source.text()[node.range()]);
    let edit = (node.range(), format!("<mass value=\"{kg}\"/>{lines}"));
    let said = format!("its mass of {kg} kg stands as text, and is read as `value`");
    Some((vec![edit], said))
}

/// Gives a link a mass and an inertia of a body with its shapes.
fn weigh(
    source: &Source,
    link: Node,
    inertial: Option<Node>,
    options: &LoadOptions,
) -> Option<(Vec<Edit>, String)> {
    let density = options.density();
    let said_kg = inertial
        .and_then(|i| child(i, "mass"))
        .and_then(|m| m.attribute("value")?.trim().parse::<f64>().ok())
        .filter(|kg| kg.is_finite() && *kg > 0.0);
    let solid = inertia_from_shapes::of_link(link);
    if let (Some(inertial), None, None) = (inertial, said_kg, &solid) {
        let lines = lines_of(&source.text()[inertial.range()]);
        let said = "its `<inertial>` is left out: it has neither mass nor shapes".to_owned();
        return Some((vec![(inertial.range(), lines)], said));
    }
    let mass_kg = said_kg.or_else(|| Some(solid.as_ref()?.mass_kg * density))?;
    let (mass, shape) = match &solid {
        Some(solid) => (solid.weighing(mass_kg), "a solid of its shapes".to_owned()),
        None => (
            ball_of(mass_kg / density).weighing(mass_kg),
            format!("a ball with a density of {density} kg/m^3"),
        ),
    };
    let said = match said_kg {
        Some(_) => format!("its inertia is taken as that of {shape} that weighs {mass_kg} kg"),
        None => format!(
            "its mass and inertia are taken as those of {shape} with a density of {density} kg/m^3: {mass_kg:.4} kg"
        ),
    };
    let Some(inertial) = inertial else {
        let text = inertial_text(&mass);
        return Some((vec![insert_into(source, link, text)], said));
    };
    if said_kg.is_none() {
        let lines = lines_of(&source.text()[inertial.range()]);
        let text = inertial_text(&mass) + &lines;
        return Some((vec![(inertial.range(), text)], said));
    }
    // The file's centre of mass and axes stay.
    let frame =
        child(inertial, "origin").map_or_else(Isometry3::identity, inertia_from_shapes::origin);
    let inertia = inertia_text(&mass, &frame);
    let edit = match child(inertial, "inertia") {
        Some(old) => (
            old.range(),
            inertia + &lines_of(&source.text()[old.range()]),
        ),
        None => {
            let after = child(inertial, "mass")?.range().end;
            (after..after, inertia)
        }
    };
    Some((vec![edit], said))
}

fn ball_of(volume_m3: f64) -> Solid {
    Solid::ball(libm::cbrt(3.0 * volume_m3 / (4.0 * PI)))
}

fn inertial_text(mass: &MassProperties) -> String {
    let c = mass.center_of_mass_m;
    let origin = if c != Vector3::zeros() {
        format!("<origin xyz=\"{} {} {}\" rpy=\"0 0 0\"/>", c.x, c.y, c.z)
    } else {
        String::new()
    };
    format!(
        "<inertial>{origin}<mass value=\"{}\"/>{}</inertial>",
        mass.mass_kg,
        inertia_text(mass, &Isometry3::identity())
    )
}

/// Returns the inertia along the axes of a frame of the link.
fn inertia_text(mass: &MassProperties, frame: &Isometry3<f64>) -> String {
    let i = mass.moved(&frame.inverse()).inertia_kg_m2;
    // Products caused by rounding become zero.
    let least = 1e-12 * i.trace();
    inertia(
        &i.map_with_location(|row, column, x| match row != column && x.abs() < least {
            true => 0.0,
            false => x,
        }),
    )
}

/// Inserts a text at the start of an element.
fn insert_into(source: &Source, node: Node, text: String) -> Edit {
    let tag = crate::xml::opening_tag(source.text(), node);
    let written = &source.text()[tag.clone()];
    match written.strip_suffix("/>") {
        Some(open) => (
            tag,
            format!("{}>{text}</{}>", open.trim_end(), node.tag_name().name()),
        ),
        None => (tag.end..tag.end, text),
    }
}

/// Gives the joint above a link the axis of its cylinder, to the left if it points there.
fn state_axis(source: &Source, link: Node) -> Option<(Vec<Edit>, String)> {
    let holds = |joint: &Node| {
        let below = child(*joint, "child").and_then(|of| of.attribute("link"));
        below == link.attribute("name") && child(*joint, "axis").is_none()
    };
    let joint = source.all("joint").find(holds)?;
    let cylinder = link.descendants().find(|n| n.has_tag_name("cylinder"))?;
    let shape = cylinder.ancestors().nth(2)?;
    let place =
        child(shape, "origin").map_or_else(Isometry3::identity, inertia_from_shapes::origin);
    let axis = place * Vector3::z();
    let [x, y, z] = (axis * axis.y.signum())
        .map(|x| (1e6 * x).round() / 1e6 + 0.0)
        .into();
    let text = format!("<axis xyz=\"{x} {y} {z}\"/>");
    let said = format!("its joint states no `<axis>`: {x} {y} {z}, along its cylinder");
    Some((vec![insert_into(source, joint, text)], said))
}

/// Renames the second element of a name, and the references after it; or removes it if equal to the
/// first.
fn rename(source: &Source, node: Node, tag: &'static str) -> Option<(Vec<Edit>, String)> {
    let name = node.attribute("name")?;
    let first = source.named(tag, name)?;
    let text = |n: Node| -> String {
        let raw = &source.text()[n.range()];
        raw.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    // Equal links are different if two joints have them as children.
    let hung: HashSet<String> = source
        .all("joint")
        .filter(|_| tag == "link")
        .filter(|joint| child(*joint, "child").and_then(|n| n.attribute("link")) == Some(name))
        .map(text)
        .collect();
    if text(first) == text(node) && hung.len() < 2 {
        let lines = lines_of(&source.text()[node.range()]);
        let said = format!(
            "left out, for it says the same as the first of its name, on line {}",
            source.line_of(first)
        );
        return Some((vec![(node.range(), lines)], said));
    }
    let taken = |candidate: &str| {
        source
            .all(tag)
            .any(|n| n.attribute("name") == Some(candidate))
    };
    let mut number = 2;
    while taken(&format!("{name}_{number}")) {
        number += 1;
    }
    let new = format!("{name}_{number}");
    let value = |n: Node, attribute: &str| {
        let a = n.attribute_node(attribute)?;
        Some((a.range_value(), escaped(&new)))
    };
    let mut edits = vec![value(node, "name")?];
    if tag == "link" {
        // Joints after it refer to it, not to the first; if none after it has it as a child, the
        // second joint with such a child does.
        let ends: Vec<Node> = source
            .all("joint")
            .flat_map(|joint| [child(joint, "parent"), child(joint, "child")])
            .flatten()
            .filter(|end| end.attribute("link") == Some(name))
            .collect();
        let is_child = |end: &&Node| end.has_tag_name("child");
        let behind = |end: &&Node| end.range().start > node.range().start;
        let hung = ends.iter().filter(is_child).find(|end| behind(end));
        let hung = hung.or_else(|| ends.iter().filter(is_child).nth(1));
        edits.extend(hung.and_then(|end| value(*end, "link")));
        let below = ends
            .iter()
            .filter(|end| end.has_tag_name("parent"))
            .filter(behind);
        edits.extend(below.filter_map(|end| value(*end, "link")));
    }
    Some((edits, format!("called `{new}`, for its name is taken")))
}

/// Lets a joint with rollers turn, about the axis of their ring.
fn turn_hub(source: &Source, joint: Node) -> Option<(Vec<Edit>, String)> {
    let tree = tree(source)?;
    let name = joint.attribute("name")?;
    let hub = tree.joints.iter().position(|j| j.name == name)?;
    let axis_in_body = recognise::ring_axis(&tree, hub)?;
    let link = &tree.links[tree.joints[hub].child];
    let axis = link.body_from_link.rotation.inverse() * axis_in_body;
    let written = format!("<axis xyz=\"{} {} {}\"/>", axis.x, axis.y, axis.z);
    let mut edits = vec![(
        joint.attribute_node("type")?.range_value(),
        "continuous".to_owned(),
    )];
    edits.push(match child(joint, "axis") {
        Some(old) => (
            old.range(),
            written + &lines_of(&source.text()[old.range()]),
        ),
        None => insert_into(source, joint, written),
    });
    // A limit of a fixed joint has no meaning.
    if let Some(limit) = child(joint, "limit") {
        edits.push((limit.range(), lines_of(&source.text()[limit.range()])));
    }
    Some((
        edits,
        "it carries rollers and is made to turn about the axis of their ring".to_owned(),
    ))
}

/// Lets rollers turn that are fixed to wheels.
fn turn_rollers(source: &Source) -> Option<(Vec<Edit>, String)> {
    let tree = tree(source)?;
    let rollers = recognise::fixed_rollers(&tree).into_iter();
    let rollers: Vec<usize> = rollers.flat_map(|of| of.rollers).collect();
    let edits = rollers.iter().map(|&j| {
        let joint = source.named("joint", &tree.joints[j].name)?;
        let range = joint.attribute_node("type")?.range_value();
        Some((range, "continuous".to_owned()))
    });
    let said = format!("{} rollers that were fixed are made to turn", rollers.len());
    Some((edits.collect::<Option<Vec<Edit>>>()?, said))
}

/// Removes the collision geometry that reaches the floor, from everything that does not turn: the
/// lowest shape, and all that reach below the lowest point less its depth below the floor.
fn leave_out_lowest(source: &Source, deep_m: f64) -> Option<(Vec<Edit>, String)> {
    /// A smaller clearance counts as touching, in metres.
    const NEAR_M: f64 = 1e-4;
    let tree = tree(source)?;
    let mut reaches: Vec<(f64, usize, usize)> = Vec::new();
    let mut waiting = vec![tree.root];
    while let Some(link) = waiting.pop() {
        for (i, shape) in tree.links[link].shapes.iter().enumerate() {
            let Some(primitive) = primitive(&shape.geometry) else {
                continue;
            };
            let collision = Collision {
                friction: None,
                body_from_shape: shape.body_from_shape,
                shape: primitive,
            };
            reaches.push((collision.reach_m(&-Vector3::z()), link, i));
        }
        let below = tree.links[link].joints_below.iter();
        let still = below.filter(|&&j| tree.joints[j].motion != Motion::Turning);
        waiting.extend(still.map(|&j| tree.joints[j].child));
    }
    let lowest_m = reaches.iter().map(|of| of.0).reduce(f64::max)?;
    let floor_m = lowest_m - deep_m.max(0.0) - NEAR_M;
    let mut edits = Vec::new();
    let mut names = Vec::new();
    let (mut shapes_of, mut shapes) = (None, Vec::new());
    for (_, link, i) in reaches.into_iter().filter(|of| of.0 > floor_m) {
        let name = &tree.links[link].name;
        let node = source.named("link", name)?;
        if shapes_of != Some(link) {
            let children = node.children();
            shapes = children.filter(|n| n.has_tag_name("collision")).collect();
            shapes_of = Some(link);
        }
        let shape = *shapes.get(i)?;
        edits.push((shape.range(), lines_of(&source.text()[shape.range()])));
        let line = source.line_of(shape);
        names.push(format!("collision {} of `{name}` on line {line}", i + 1));
    }
    let rest = match names.len() {
        0..=4 => String::new(),
        count => format!(" and {} more", count - 4),
    };
    names.truncate(4);
    let said = format!(
        "{}{rest} left out, down to the floor on which the wheels stand, or below it",
        names.join(", ")
    );
    Some((edits, said))
}

/// Returns the tree of a text, if readable.
pub(super) fn tree(source: &Source) -> Option<Tree> {
    let left_out = normalise::LeftOut::default();
    let urdf = urdf_rs::read_from_string(&normalise::normalised(source, &left_out)).ok()?;
    Tree::build(source, urdf).ok()
}

/// Returns the text with wheels moved to one height if they differ by some millimetres; `None` if
/// there are none.
pub(crate) fn levelled(prepared: &UrdfText, robot: &Robot) -> Option<UrdfText> {
    let bottoms_m: Vec<f64> = robot
        .wheels
        .iter()
        .map(|w| w.position_m().z - w.reach_at_rest_m())
        .collect();
    let mut sorted = bottoms_m.clone();
    sorted.sort_by(f64::total_cmp);
    let most = *sorted.get(sorted.len() / 2)?;
    let off: Vec<(usize, f64)> = bottoms_m
        .iter()
        .map(|bottom_m| most - bottom_m)
        .enumerate()
        .filter(|(_, up_m)| up_m.abs() > LEVEL_M)
        .collect();
    if off.is_empty() || off.iter().any(|(_, up_m)| up_m.abs() > LEVELLED_M) {
        return None;
    }
    let source = Source::parse(prepared).ok()?;
    let tree = tree(&source)?;
    let mut edits = Vec::new();
    let mut remarks = Vec::new();
    for (wheel, up_m) in off {
        let name = &robot.wheels[wheel].name;
        let joint = tree.joints.iter().find(|j| j.name == *name)?;
        let node = source.named("joint", name)?;
        let parent = &tree.links[joint.parent].body_from_link;
        let raised = joint.origin + Vector3::z() * up_m;
        let place: Point3<f64> = parent.inverse() * raised;
        let xyz = format!("{} {} {}", place.x, place.y, place.z);
        edits.push(match child(node, "origin") {
            Some(origin) => match origin.attribute_node("xyz") {
                Some(a) => (a.range_value(), xyz),
                None => {
                    let at = origin.range().start + "<origin".len();
                    (at..at, format!(" xyz=\"{xyz}\""))
                }
            },
            None => insert_into(&source, node, format!("<origin xyz=\"{xyz}\"/>")),
        });
        let mut remark = Remark::new(
            format!("wheel `{name}`"),
            format!(
                "repaired: {} by {:.3} mm, to the height of the others",
                if up_m > 0.0 { "raised" } else { "lowered" },
                1e3 * up_m.abs()
            ),
        );
        source.place_at(&mut remark, node);
        remarks.push(remark);
    }
    let mut levelled = prepared.edited(edits);
    levelled.remarks.extend(remarks);
    Some(levelled)
}

/// Returns the line breaks of a text, which keep the numbers of the lines that follow.
fn lines_of(text: &str) -> String {
    "\n".repeat(text.matches('\n').count())
}
