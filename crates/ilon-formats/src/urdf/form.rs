//! The form of URDF, element by element: what must be there, and which numbers it may hold.
//!
//! urdf-rs says what a file means but hardly where, and stops at the first fault. So all that is read is held against the form
//! here first, with its place; what is not read may be as it likes.

use std::collections::{HashMap, HashSet};

use roxmltree::Node;

use super::faults::Faults;
use super::inertial::check_inertial;
use super::source::{Source, child, describe};
use crate::error::{Fault, RobotError};
use crate::model::Remark;

/// What the numbers of an attribute may be.
#[derive(Clone, Copy, PartialEq)]
enum Range {
    Any,
    NotNegative,
    Positive,
    /// Above 0 and at most 1.
    Share,
}

/// The numeric attributes of URDF: element, attribute, how many numbers, whether it must be there, range.
const NUMBERS: [(&str, &str, usize, bool, Range); 43] = [
    ("origin", "xyz", 3, false, Range::Any),
    ("origin", "rpy", 3, false, Range::Any),
    ("origin", "quat_xyzw", 4, false, Range::Any),
    ("mass", "value", 1, true, Range::NotNegative),
    ("inertia", "ixx", 1, true, Range::Any),
    ("inertia", "ixy", 1, false, Range::Any),
    ("inertia", "ixz", 1, false, Range::Any),
    ("inertia", "iyy", 1, true, Range::Any),
    ("inertia", "iyz", 1, false, Range::Any),
    ("inertia", "izz", 1, true, Range::Any),
    ("box", "size", 3, true, Range::Positive),
    ("sphere", "radius", 1, true, Range::Positive),
    ("cylinder", "radius", 1, true, Range::Positive),
    ("cylinder", "length", 1, true, Range::Positive),
    ("capsule", "radius", 1, true, Range::Positive),
    ("capsule", "length", 1, true, Range::Positive),
    ("mesh", "scale", 3, false, Range::Any),
    ("axis", "xyz", 3, true, Range::Any),
    ("limit", "lower", 1, false, Range::Any),
    ("limit", "upper", 1, false, Range::Any),
    ("limit", "effort", 1, false, Range::NotNegative),
    ("limit", "velocity", 1, false, Range::NotNegative),
    ("mimic", "multiplier", 1, false, Range::Any),
    ("mimic", "offset", 1, false, Range::Any),
    ("dynamics", "damping", 1, false, Range::NotNegative),
    ("dynamics", "friction", 1, false, Range::NotNegative),
    ("ilon_drive", "gear_ratio", 1, false, Range::Positive),
    ("ilon_drive", "rotor_inertia", 1, false, Range::NotNegative),
    ("ilon_drive", "gear_efficiency", 1, false, Range::Share),
    ("ilon_drive", "gear_friction", 1, false, Range::NotNegative),
    (
        "ilon_rollers",
        "rolling_resistance",
        1,
        false,
        Range::NotNegative,
    ),
    ("ilon_rollers", "tread_stiffness", 1, false, Range::Positive),
    (
        "ilon_rollers",
        "tread_damping",
        1,
        false,
        Range::NotNegative,
    ),
    (
        "ilon_rollers",
        "tread_shear_stiffness",
        1,
        false,
        Range::Positive,
    ),
    (
        "ilon_rollers",
        "tread_shear_damping",
        1,
        false,
        Range::NotNegative,
    ),
    (
        "ilon_rollers",
        "tread_relaxation_length",
        1,
        false,
        Range::Positive,
    ),
    ("ilon_rollers", "axial_play", 1, false, Range::NotNegative),
    ("ilon_rollers", "length_factor", 1, false, Range::Positive),
    ("ilon_rollers", "crown", 1, false, Range::Positive),
    ("ilon_rollers", "edge_radius", 1, false, Range::NotNegative),
    (
        "ilon_rollers",
        "radius_spread",
        1,
        false,
        Range::NotNegative,
    ),
    ("ilon_rollers", "radius_seed", 1, false, Range::NotNegative),
    ("roller", "radius_offset", 1, true, Range::Any),
];

/// Children that an element may have only once. Of several, the first is read, as the tools of ROS do.
const SINGLE: [(&str, &[&str]); 4] = [
    ("link", &["inertial"]),
    ("inertial", &["origin", "mass", "inertia"]),
    (
        "joint",
        &["origin", "parent", "child", "axis", "limit", "dynamics"],
    ),
    ("collision", &["origin", "geometry"]),
];

/// Largest number that is read but for limits: beyond it products of numbers are no longer finite.
const LARGEST: f64 = 1e9;

const JOINT_TYPES: [&str; 7] = [
    "fixed",
    "continuous",
    "revolute",
    "prismatic",
    "floating",
    "planar",
    "spherical",
];

/// Geometries that are read.
pub(super) const GEOMETRIES: [&str; 5] = ["box", "cylinder", "capsule", "sphere", "mesh"];

/// Holds every link and joint of the file against the form of URDF; with what is to be said of those that pass. Where links may
/// be missing, joints of missing ones pass too.
pub(super) fn check(source: &Source, links_may_miss: bool) -> Result<Vec<Remark>, RobotError> {
    let mut remarks = Vec::new();
    let mut faults = Faults::default();
    if source.all("link").next().is_none() {
        faults.push(of_no_link(source));
        faults.into_result()?;
        return Ok(remarks);
    }
    for tag in ["link", "joint"] {
        unique_names(source, tag, &mut faults);
    }
    for link in source.all("link") {
        check_link(source, link, &mut remarks, &mut faults);
        if faults.is_full() {
            break;
        }
    }
    let links: HashSet<&str> = source
        .all("link")
        .filter_map(|n| n.attribute("name"))
        .collect();
    for joint in source.all("joint") {
        check_joint(source, joint, &mut remarks, &mut faults);
        if !links_may_miss {
            check_ends(source, joint, &links, &mut faults);
        }
        if faults.is_full() {
            break;
        }
    }
    check_additions(source, &mut faults);
    faults.into_result().map(|()| remarks)
}

/// What the file says of drives and rollers, in the elements that [`crate::generate`] writes.
fn check_additions(source: &Source, faults: &mut Faults) {
    let joints: HashSet<&str> = source
        .all("joint")
        .filter_map(|n| n.attribute("name"))
        .collect();
    let added = source
        .robot()
        .children()
        .filter(|n| n.has_tag_name("ilon_drive") || n.has_tag_name("ilon_rollers"));
    for addition in added {
        let rollers = addition.children().filter(|n| n.has_tag_name("roller"));
        for said in [addition].into_iter().chain(rollers) {
            check_numbers(source, said, faults);
            faults.keep(names_a_joint(source, said, &joints));
        }
    }
}

/// An element that says something of a joint.
fn names_a_joint(source: &Source, node: Node, joints: &HashSet<&str>) -> Result<(), RobotError> {
    match node.attribute("joint") {
        Some(joint) if joints.contains(joint) => Ok(()),
        Some(joint) => {
            let joint = joint.to_owned();
            Err(source.attribute_error(node, "joint", Fault::UnknownJoint { joint }))
        }
        None => {
            let attribute = "joint".to_owned();
            Err(source.error(node, Fault::MissingAttribute { attribute }))
        }
    }
}

/// What is wrong with a xacro file of which elements stand without their prefix: nothing of them is read.
pub(super) fn of_old_xacro(source: &Source) -> Option<RobotError> {
    let mut children = source.robot().children();
    let node =
        children.find(|n| ["include", "property", "macro"].contains(&n.tag_name().name()))?;
    let tag = node.tag_name().name().to_owned();
    Some(source.error(node, Fault::OldXacro { tag }))
}

/// What is wrong with a file that has no link.
fn of_no_link(source: &Source) -> RobotError {
    if let Some(error) = of_old_xacro(source) {
        return error;
    }
    let prepared = source.prepared;
    source.robot_error(if prepared.uncalled_macros.is_empty() {
        Fault::MissingElement { child: "link" }
    } else {
        Fault::MacrosOnly {
            macros: prepared.uncalled_macros.clone(),
            callers: prepared.callers.clone(),
        }
    })
}

/// Refuses names that are missing or given twice among the elements of one tag.
fn unique_names(source: &Source, tag: &'static str, faults: &mut Faults) {
    let mut first: HashMap<&str, Node> = HashMap::new();
    for node in source.all(tag) {
        let Some(name) = node.attribute("name").filter(|n| !n.trim().is_empty()) else {
            let attribute = "name".to_owned();
            faults.push(source.error(node, Fault::MissingAttribute { attribute }));
            continue;
        };
        if let Some(taken) = first.get(name) {
            let first_line = source.line_of(*taken);
            let fault = Fault::DuplicateName { tag, first_line };
            faults.push(source.attribute_error(node, "name", fault));
        } else {
            first.insert(name, node);
        }
    }
}

fn check_link(source: &Source, link: Node, remarks: &mut Vec<Remark>, faults: &mut Faults) {
    remark_repeated(source, link, remarks);
    if let Some(inertial) = child(link, "inertial") {
        check_inertial(source, inertial, remarks, faults);
    }
    for shape in link.children().filter(|n| n.has_tag_name("collision")) {
        remark_repeated(source, shape, remarks);
        if let Some(origin) = child(shape, "origin") {
            check_numbers(source, origin, faults);
        }
        check_geometry(source, shape, faults);
    }
}

/// Says which elements stand a second time.
pub(super) fn remark_repeated(source: &Source, node: Node, remarks: &mut Vec<Remark>) {
    let tag = node.tag_name().name();
    let singles = SINGLE.iter().find(|(outer, _)| *outer == tag);
    for single in singles.map_or(&[][..], |s| s.1) {
        let mut alike = node.children().filter(|n| n.has_tag_name(*single));
        if let (Some(_), Some(second)) = (alike.next(), alike.next()) {
            let mut remark = Remark::new(
                describe(second),
                format!(
                    "`<{single}>` stands here a second time: the first is read, as the tools of ROS do"
                ),
            );
            source.place_at(&mut remark, second);
            remarks.push(remark);
        }
    }
}

/// Adds the faults of an element's numbers; whether there are none.
pub(super) fn check_numbers(source: &Source, node: Node, faults: &mut Faults) -> bool {
    let tag = node.tag_name().name();
    let rows = NUMBERS.iter().filter(|row| row.0 == tag);
    let mut good = true;
    for (_, attribute, count, required, range) in rows {
        let checked = check_number(source, node, attribute, (*count, *required, *range));
        good &= faults.keep(checked).is_some();
    }
    good
}

fn check_number(
    source: &Source,
    node: Node,
    attribute: &str,
    (count, required, range): (usize, bool, Range),
) -> Result<(), RobotError> {
    let tag = node.tag_name().name();
    let Some(value) = node.attribute(attribute) else {
        if required {
            let attribute = attribute.to_owned();
            return Err(source.error(node, Fault::MissingAttribute { attribute }));
        }
        return Ok(());
    };
    let fail = |fault| Err(source.attribute_error(node, attribute, fault));
    let (name, text) = (attribute.to_owned(), value.to_owned());
    let numbers: Result<Vec<f64>, _> = value.split_whitespace().map(str::parse).collect();
    let Some(numbers) = numbers.ok().filter(|n| n.len() == count) else {
        return fail(Fault::NotNumbers {
            attribute: name,
            value: text,
            count,
        });
    };
    if numbers.iter().any(|n| !n.is_finite()) {
        return fail(Fault::NotFinite {
            attribute: name,
            value: text,
        });
    }
    // Limits may be astronomic, which says that there is none; lengths, masses and inertias may not.
    if tag != "limit" && numbers.iter().any(|n| n.abs() > LARGEST) {
        return fail(Fault::OutOfRange {
            key: name,
            value: text,
            range: "below a thousand million",
        });
    }
    let range = match range {
        Range::Any => return Ok(()),
        Range::NotNegative if numbers.iter().all(|&n| n >= 0.0) => return Ok(()),
        Range::Positive if numbers.iter().all(|&n| n > 0.0) => return Ok(()),
        Range::Share if numbers.iter().all(|&n| n > 0.0 && n <= 1.0) => return Ok(()),
        Range::NotNegative if tag == "mass" => "above 0",
        Range::NotNegative => "0 or above",
        Range::Share => "above 0 and at most 1",
        Range::Positive => "above 0",
    };
    fail(Fault::OutOfRange {
        key: name,
        value: text,
        range,
    })
}

/// The number of an attribute that was checked; 0 where it is left out.
pub(super) fn number(node: Node, attribute: &str) -> f64 {
    let text = node.attribute(attribute).unwrap_or_default();
    text.trim().parse().unwrap_or_default()
}

fn check_geometry(source: &Source, shape: Node, faults: &mut Faults) {
    let Some(geometry) = child(shape, "geometry") else {
        faults.push(source.error(shape, Fault::MissingElement { child: "geometry" }));
        return;
    };
    match geometry.children().find(Node::is_element) {
        Some(kind) if GEOMETRIES.contains(&kind.tag_name().name()) => {
            if kind.has_tag_name("mesh") && kind.attribute("filename").is_none() {
                let attribute = "filename".to_owned();
                faults.push(source.error(kind, Fault::MissingAttribute { attribute }));
            }
            check_numbers(source, kind, faults);
        }
        _ => faults.push(source.error(geometry, Fault::UnknownGeometry)),
    }
}

fn check_joint(source: &Source, joint: Node, remarks: &mut Vec<Remark>, faults: &mut Faults) {
    remark_repeated(source, joint, remarks);
    for tag in ["calibration", "safety_controller"] {
        if child(joint, tag).is_some() {
            remarks.push(Remark::new(
                describe(joint),
                format!("`<{tag}>` is not read"),
            ));
        }
    }
    let Some(joint_type) = joint.attribute("type") else {
        let attribute = "type".to_owned();
        faults.push(source.error(joint, Fault::MissingAttribute { attribute }));
        return;
    };
    if !JOINT_TYPES.contains(&joint_type) {
        let joint_type = joint_type.to_owned();
        faults.push(source.attribute_error(joint, "type", Fault::UnknownJointType { joint_type }));
    }
    if let Some(origin) = child(joint, "origin") {
        check_numbers(source, origin, faults);
    }
    // Of a joint that does not move, nothing else is read.
    if joint_type == "fixed" {
        return;
    }
    for tag in ["limit", "dynamics"] {
        if let Some(node) = child(joint, tag) {
            check_numbers(source, node, faults);
        }
    }
    if let Some(axis) = child(joint, "axis")
        && check_numbers(source, axis, faults)
        && ["continuous", "revolute", "prismatic", "planar"].contains(&joint_type)
    {
        let xyz = axis.attribute("xyz").unwrap_or_default();
        let length_squared: f64 = xyz
            .split_whitespace()
            .filter_map(|s| s.parse::<f64>().ok())
            .map(|x| x * x)
            .sum();
        if length_squared < 1e-12 {
            faults.push(source.attribute_error(axis, "xyz", Fault::ZeroAxis));
        }
    }
}

/// A joint's parent and child must be named, and be there.
fn check_ends(source: &Source, joint: Node, links: &HashSet<&str>, faults: &mut Faults) {
    for tag in ["parent", "child"] {
        let Some(end) = child(joint, tag) else {
            faults.push(source.error(joint, Fault::MissingElement { child: tag }));
            continue;
        };
        match end.attribute("link") {
            None => {
                let attribute = "link".to_owned();
                faults.push(source.error(end, Fault::MissingAttribute { attribute }));
            }
            Some(link) if !links.contains(link) => {
                let link = link.to_owned();
                faults.push(source.attribute_error(end, "link", Fault::UnknownLink { link }));
            }
            Some(_) => {}
        }
    }
}
