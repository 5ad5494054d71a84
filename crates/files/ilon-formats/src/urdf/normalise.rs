//! Writes the text for urdf-rs: only what is used, in the order and form that it accepts.
//!
//! urdf-rs rejects files that ROS tools accept: scattered visuals, a second limit, inertias without
//! products. The file was checked against the form of URDF before, so everything here is valid;
//! errors still refer to the file.

use std::collections::{HashMap, HashSet};
use std::fmt::Write;

use roxmltree::Node;

use super::schema::GEOMETRIES;
use super::source::{Source, child};
use crate::generate::elements::attribute as escaped;
use crate::model::Remark;
use crate::xml::numbers;

/// The attributes of `<origin>`.
const PLACE: [&str; 3] = ["xyz", "rpy", "quat_xyzw"];

/// The parts left out of an incomplete file: joints of missing links, and everything then
/// disconnected.
#[derive(Debug, Default)]
pub(super) struct LeftOut {
    links: HashSet<String>,
    joints: HashSet<String>,
}

/// Finds what is disconnected when joints of missing links are left out. The tree of the first link
/// with the most links below it is the robot.
pub(super) fn without_missing(source: &Source) -> (LeftOut, Vec<Remark>) {
    let end = |joint: Node, tag| {
        let link = child(joint, tag).and_then(|n| n.attribute("link"));
        link.unwrap_or_default().to_owned()
    };
    let links: Vec<&str> = source
        .all("link")
        .filter_map(|n| n.attribute("name"))
        .collect();
    let known: HashSet<&str> = links.iter().copied().collect();
    let mut left_out = LeftOut::default();
    let mut remarks = Vec::new();
    let mut below: HashMap<String, Vec<(String, String)>> = HashMap::new();
    let mut hanging: HashSet<String> = HashSet::new();
    for joint in source.all("joint") {
        let name = joint.attribute("name").unwrap_or_default().to_owned();
        let (parent, child) = (end(joint, "parent"), end(joint, "child"));
        let missing = [&parent, &child]
            .into_iter()
            .find(|l| !known.contains(l.as_str()));
        if let Some(missing) = missing {
            let mut remark = Remark::new(
                format!("joint `{name}`"),
                format!("left out, for there is no link `{missing}`"),
            );
            source.place_at(&mut remark, joint);
            remarks.push(remark);
            left_out.joints.insert(name);
            continue;
        }
        hanging.insert(child.clone());
        below.entry(parent).or_default().push((name, child));
    }
    let tree_of = |root: &str| {
        let mut tree = HashSet::from([root.to_owned()]);
        let mut waiting = vec![root.to_owned()];
        while let Some(link) = waiting.pop() {
            for (_, child) in below.get(&link).into_iter().flatten() {
                if tree.insert(child.clone()) {
                    waiting.push(child.clone());
                }
            }
        }
        tree
    };
    let roots = links.iter().filter(|link| !hanging.contains(**link));
    let trees: Vec<(&str, HashSet<String>)> = roots.map(|root| (*root, tree_of(root))).collect();
    let largest = trees.iter().map(|(_, tree)| tree.len()).max().unwrap_or(0);
    let mut kept = false;
    for (root, tree) in trees {
        if !kept && tree.len() == largest {
            kept = true;
            continue;
        }
        let more = match tree.len() {
            1 => String::new(),
            count => format!(", and {} links below it", count - 1),
        };
        remarks.push(Remark::new(
            format!("link `{root}`"),
            format!("left out{more}: it hangs by nothing that is there"),
        ));
        for link in tree {
            for (joint, _) in below.get(&link).into_iter().flatten() {
                left_out.joints.insert(joint.clone());
            }
            left_out.links.insert(link);
        }
    }
    (left_out, remarks)
}

/// Returns the text for urdf-rs.
pub(super) fn normalised(source: &Source, left_out: &LeftOut) -> String {
    let mut out = String::new();
    let robot = source.robot();
    let version = robot.attribute("version");
    out.push_str("<robot");
    attribute(
        &mut out,
        "name",
        robot.attribute("name").unwrap_or_default(),
    );
    if let Some(version) = version {
        attribute(&mut out, "version", version);
    }
    out.push('>');
    for link in source.all("link") {
        if !left_out
            .links
            .contains(link.attribute("name").unwrap_or_default())
        {
            write_link(&mut out, link);
        }
    }
    for joint in source.all("joint") {
        if !left_out
            .joints
            .contains(joint.attribute("name").unwrap_or_default())
        {
            write_joint(&mut out, joint, limits_may_miss(version));
        }
    }
    out.push_str("</robot>");
    out
}

fn write_link(out: &mut String, link: Node) {
    out.push_str("<link");
    attribute(out, "name", link.attribute("name").unwrap_or_default());
    out.push('>');
    if let Some(inertial) = child(link, "inertial") {
        out.push_str("<inertial>");
        copy(out, child(inertial, "origin"), &PLACE);
        copy(out, child(inertial, "mass"), &["value"]);
        out.push_str("<inertia");
        for moment in ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"] {
            let value = child(inertial, "inertia").and_then(|n| n.attribute(moment));
            attribute(out, moment, value.unwrap_or("0"));
        }
        out.push_str("/></inertial>");
    }
    for tag in ["visual", "collision"] {
        for shape in link.children().filter(|n| n.has_tag_name(tag)) {
            write_shape(out, tag, shape);
        }
    }
    out.push_str("</link>");
}

/// Writes a shape; an invalid visual is no fault, and left out.
fn write_shape(out: &mut String, tag: &str, shape: Node) {
    let kind = child(shape, "geometry").and_then(|g| g.children().find(Node::is_element));
    let origin = child(shape, "origin");
    let Some(kind) = kind.filter(|kind| tag == "collision" || is_good(*kind, origin)) else {
        return;
    };
    let _ = write!(out, "<{tag}>");
    copy(out, origin, &PLACE);
    out.push_str("<geometry>");
    copy(
        out,
        Some(kind),
        &["size", "radius", "length", "filename", "scale"],
    );
    let _ = write!(out, "</geometry></{tag}>");
}

/// Whether a visual has a supported geometry with valid numbers.
fn is_good(kind: Node, origin: Option<Node>) -> bool {
    let numbers = |node: Node, attribute: &str, count: usize| {
        let numbers = node.attribute(attribute).and_then(numbers);
        numbers.filter(|n| n.len() == count && n.iter().all(|x| x.abs() < 1e9))
    };
    let positive = |attribute: &str, count: usize| {
        numbers(kind, attribute, count).is_some_and(|n| n.iter().all(|x| *x > 0.0))
    };
    let placed = origin.is_none_or(|origin| {
        ["xyz", "rpy"]
            .into_iter()
            .all(|a| origin.attribute(a).is_none() || numbers(origin, a, 3).is_some())
    });
    let name = kind.tag_name().name();
    placed
        && GEOMETRIES.contains(&name)
        && match name {
            "box" => positive("size", 3),
            "sphere" => positive("radius", 1),
            "mesh" => {
                kind.attribute("filename").is_some()
                    && (kind.attribute("scale").is_none() || numbers(kind, "scale", 3).is_some())
            }
            _ => positive("radius", 1) && positive("length", 1),
        }
}

/// Whether a missing limit means none: from URDF 1.2 on.
fn limits_may_miss(version: Option<&str>) -> bool {
    let numbers = version.and_then(|version| {
        let (major, minor) = version.trim().split_once('.')?;
        Some((major.parse::<u32>().ok()?, minor.parse::<u32>().ok()?))
    });
    numbers.is_some_and(|numbers| numbers >= (1, 2))
}

fn write_joint(out: &mut String, joint: Node, limits_may_miss: bool) {
    let joint_type = joint.attribute("type").unwrap_or_default();
    out.push_str("<joint");
    attribute(out, "name", joint.attribute("name").unwrap_or_default());
    attribute(out, "type", joint_type);
    out.push('>');
    copy(out, child(joint, "origin"), &PLACE);
    copy(out, child(joint, "parent"), &["link"]);
    copy(out, child(joint, "child"), &["link"]);
    // Nothing else of a fixed joint was checked. Its axis is not part of URDF, but shows how its
    // wheel would turn.
    if joint_type == "fixed" {
        copy(out, stated_axis(joint), &["xyz"]);
    } else {
        copy(out, child(joint, "axis"), &["xyz"]);
        if let Some(limit) = child(joint, "limit") {
            out.push_str("<limit");
            for bound in ["lower", "upper", "effort", "velocity"] {
                let left_out = (bound == "velocity" && !limits_may_miss).then_some("0");
                if let Some(value) = limit.attribute(bound).or(left_out) {
                    attribute(out, bound, value);
                }
            }
            out.push_str("/>");
        }
        copy(out, child(joint, "dynamics"), &["damping", "friction"]);
    }
    if let Some(mimic) = child(joint, "mimic") {
        out.push_str("<mimic");
        for name in ["joint", "multiplier", "offset"] {
            if let Some(value) = mimic.attribute(name).or((name == "joint").then_some("")) {
                attribute(out, name, value);
            }
        }
        out.push_str("/>");
    }
    out.push_str("</joint>");
}

/// Returns the axis of a joint, if stated and not zero.
pub(super) fn stated_axis<'a, 'i>(joint: Node<'a, 'i>) -> Option<Node<'a, 'i>> {
    let axis = child(joint, "axis")?;
    let xyz = numbers(axis.attribute("xyz")?)?;
    let length: f64 = xyz.iter().map(|x| x.abs()).sum();
    (xyz.len() == 3 && length > 1e-6 && length < 1e9).then_some(axis)
}

/// Writes an element with its used attributes.
fn copy(out: &mut String, node: Option<Node>, attributes: &[&str]) {
    let Some(node) = node else { return };
    out.push('<');
    out.push_str(node.tag_name().name());
    for name in attributes {
        if let Some(value) = node.attribute(*name) {
            attribute(out, name, value);
        }
    }
    out.push_str("/>");
}

fn attribute(out: &mut String, name: &str, value: &str) {
    let _ = write!(out, " {name}=\"{}\"", escaped(value));
}
