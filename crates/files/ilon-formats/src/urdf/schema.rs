//! The form of URDF, element by element: required parts and allowed numbers.
//!
//! urdf-rs reports hardly any places of errors, and stops at the first. So everything used is
//! checked here first, with its place; unused parts are not checked.

use std::collections::{HashMap, HashSet};

use roxmltree::Node;

use super::faults::Faults;
use super::inertial::check_inertial;
use super::numbers::{check_numbers, remark_repeated};
use super::source::{Source, child, describe};
use crate::error::{Fault, RobotError};
use crate::model::Remark;
use crate::xml::numbers;

const JOINT_TYPES: &str = "fixed continuous revolute prismatic floating planar spherical";

/// Supported geometries.
pub(super) const GEOMETRIES: [&str; 5] = ["box", "cylinder", "capsule", "sphere", "mesh"];

/// Checks every link and joint of the file against the form of URDF; returns remarks on those that
/// pass. If links may be missing, joints of missing ones pass too.
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

/// Checks the drives, rollers and springs in the elements that [`crate::generate`] writes.
fn check_additions(source: &Source, faults: &mut Faults) {
    let joints: HashSet<&str> = source
        .all("joint")
        .filter_map(|n| n.attribute("name"))
        .collect();
    let added = source
        .robot()
        .children()
        .filter(|n| ["ilon_drive", "ilon_rollers", "ilon_spring"].contains(&n.tag_name().name()));
    for addition in added {
        let rollers = addition.children().filter(|n| n.has_tag_name("roller"));
        for said in [addition].into_iter().chain(rollers) {
            check_numbers(source, said, faults);
            faults.keep(names_a_joint(source, said, &joints));
        }
    }
}

/// Checks an element that refers to a joint.
fn names_a_joint(source: &Source, node: Node, joints: &HashSet<&str>) -> Result<(), RobotError> {
    match node.attribute("joint") {
        Some(joint) if joints.contains(joint) => Ok(()),
        Some(joint) => {
            let fault = Fault::unknown_joint(joint, joints.iter().copied());
            Err(source.attribute_error(node, "joint", fault))
        }
        None => Err(source.error(node, Fault::missing_attribute("joint"))),
    }
}

/// Returns the error of a xacro file with elements without prefix, which would be ignored.
pub(super) fn of_old_xacro(source: &Source) -> Option<RobotError> {
    let mut children = source.robot().children();
    let node =
        children.find(|n| ["include", "property", "macro"].contains(&n.tag_name().name()))?;
    let tag = node.tag_name().name().to_owned();
    Some(source.error(node, Fault::OldXacro { tag }))
}

/// Returns the error of a file without a link.
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

/// Rejects missing and repeated names among the elements of one tag.
fn unique_names(source: &Source, tag: &'static str, faults: &mut Faults) {
    let mut first: HashMap<&str, Node> = HashMap::new();
    for node in source.all(tag) {
        let Some(name) = node.attribute("name").filter(|n| !n.trim().is_empty()) else {
            faults.push(source.error(node, Fault::missing_attribute("name")));
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

fn check_geometry(source: &Source, shape: Node, faults: &mut Faults) {
    let Some(geometry) = child(shape, "geometry") else {
        faults.push(source.error(shape, Fault::MissingElement { child: "geometry" }));
        return;
    };
    match geometry.children().find(Node::is_element) {
        Some(kind) if GEOMETRIES.contains(&kind.tag_name().name()) => {
            if kind.has_tag_name("mesh") && kind.attribute("filename").is_none() {
                faults.push(source.error(kind, Fault::missing_attribute("filename")));
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
        faults.push(source.error(joint, Fault::missing_attribute("type")));
        return;
    };
    if !JOINT_TYPES.split(' ').any(|known| known == joint_type) {
        let joint_type = joint_type.to_owned();
        faults.push(source.attribute_error(joint, "type", Fault::UnknownJointType { joint_type }));
    }
    if let Some(origin) = child(joint, "origin") {
        check_numbers(source, origin, faults);
    }
    // Nothing else of a fixed joint is used.
    if joint_type == "fixed" {
        return;
    }
    for tag in ["limit", "dynamics", "mimic"] {
        if let Some(node) = child(joint, tag) {
            check_numbers(source, node, faults);
        }
    }
    if let Some(axis) = child(joint, "axis")
        && check_numbers(source, axis, faults)
        && ["continuous", "revolute", "prismatic", "planar"].contains(&joint_type)
    {
        let xyz = axis.attribute("xyz").unwrap_or_default();
        let xyz = numbers(xyz).unwrap_or_default();
        if xyz.iter().map(|x| x * x).sum::<f64>() < 1e-12 {
            faults.push(source.attribute_error(axis, "xyz", Fault::ZeroAxis));
        }
    }
}

/// Checks that a joint's parent and child are named and exist.
fn check_ends(source: &Source, joint: Node, links: &HashSet<&str>, faults: &mut Faults) {
    for tag in ["parent", "child"] {
        let Some(end) = child(joint, tag) else {
            faults.push(source.error(joint, Fault::MissingElement { child: tag }));
            continue;
        };
        match end.attribute("link") {
            None => {
                faults.push(source.error(end, Fault::missing_attribute("link")));
            }
            Some(link) if !links.contains(link) => {
                let link = link.to_owned();
                faults.push(source.attribute_error(end, "link", Fault::UnknownLink { link }));
            }
            Some(_) => {}
        }
    }
}
