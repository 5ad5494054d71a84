//! The form of URDF, element by element: what must be there, once, and which numbers it may hold.

use std::collections::HashSet;

use nalgebra::Matrix3;
use roxmltree::Node;

use super::source::{Source, child, unique_names};
use crate::error::{Fault, RobotError};
use crate::model::mass::principal_moments;

/// What the numbers of an attribute may be.
#[derive(Clone, Copy, PartialEq)]
enum Range {
    Any,
    NotNegative,
    Positive,
}

/// The numeric attributes of URDF: element, attribute, how many numbers, whether it must be there, range.
const NUMBERS: [(&str, &str, usize, bool, Range); 29] = [
    ("origin", "xyz", 3, false, Range::Any),
    ("origin", "rpy", 3, false, Range::Any),
    ("mass", "value", 1, true, Range::NotNegative),
    ("inertia", "ixx", 1, true, Range::Any),
    ("inertia", "ixy", 1, true, Range::Any),
    ("inertia", "ixz", 1, true, Range::Any),
    ("inertia", "iyy", 1, true, Range::Any),
    ("inertia", "iyz", 1, true, Range::Any),
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
    ("limit", "velocity", 1, true, Range::NotNegative),
    ("dynamics", "damping", 1, false, Range::NotNegative),
    ("dynamics", "friction", 1, false, Range::NotNegative),
    ("mimic", "multiplier", 1, false, Range::Any),
    ("mimic", "offset", 1, false, Range::Any),
    ("safety_controller", "k_velocity", 1, true, Range::Any),
    ("safety_controller", "k_position", 1, false, Range::Any),
    (
        "safety_controller",
        "soft_lower_limit",
        1,
        false,
        Range::Any,
    ),
    (
        "safety_controller",
        "soft_upper_limit",
        1,
        false,
        Range::Any,
    ),
];

/// Children that an element may have only once.
pub(super) const SINGLE: [(&str, &[&str]); 4] = [
    ("link", &["inertial"]),
    ("inertial", &["origin", "mass", "inertia"]),
    (
        "joint",
        &[
            "origin",
            "parent",
            "child",
            "axis",
            "limit",
            "dynamics",
            "mimic",
            "calibration",
            "safety_controller",
        ],
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

/// Holds every link and joint of the file against the form of URDF.
pub(super) fn check(source: &Source) -> Result<(), RobotError> {
    if source.all("link").next().is_none() {
        return Err(source.robot_error(Fault::MissingElement { child: "link" }));
    }
    unique_names(source, "link")?;
    unique_names(source, "joint")?;
    for outer in source.all("link").chain(source.all("joint")) {
        for node in outer.descendants().filter(Node::is_element) {
            check_expanded(source, node)?;
            check_single(source, node)?;
            check_numbers(source, node)?;
        }
    }
    for link in source.all("link") {
        if let Some(inertial) = child(link, "inertial") {
            check_inertial(source, inertial)?;
        }
        for shape in link.children().filter(|n| n.has_tag_name("collision")) {
            check_geometry(source, shape)?;
        }
    }
    let links: HashSet<&str> = source
        .all("link")
        .filter_map(|n| n.attribute("name"))
        .collect();
    source
        .all("joint")
        .try_for_each(|joint| check_joint(source, joint, &links))
}

fn check_expanded(source: &Source, node: Node) -> Result<(), RobotError> {
    let unexpanded = node
        .attributes()
        .find(|a| a.value().contains("${") || a.value().contains("$("));
    match unexpanded {
        Some(a) => {
            let what = format!("`{}=\"{}\"`", a.name(), a.value());
            Err(source.attribute_error(node, a.name(), Fault::Unexpanded { what, tried: None }))
        }
        None => Ok(()),
    }
}

fn check_single(source: &Source, node: Node) -> Result<(), RobotError> {
    let tag = node.tag_name().name();
    let Some((_, singles)) = SINGLE.iter().find(|(outer, _)| *outer == tag) else {
        return Ok(());
    };
    for single in *singles {
        if let Some(second) = node.children().filter(|n| n.has_tag_name(*single)).nth(1) {
            let fault = Fault::Repeated {
                child: (*single).to_owned(),
            };
            return Err(source.error(second, fault));
        }
    }
    Ok(())
}

pub(super) fn check_numbers(source: &Source, node: Node) -> Result<(), RobotError> {
    let tag = node.tag_name().name();
    for (_, attribute, count, required, range) in NUMBERS.iter().filter(|row| row.0 == tag) {
        let attribute = *attribute;
        let Some(value) = node.attribute(attribute) else {
            if *required {
                let attribute = attribute.to_owned();
                return Err(source.error(node, Fault::MissingAttribute { attribute }));
            }
            continue;
        };
        let fail = |fault| Err(source.attribute_error(node, attribute, fault));
        let (name, text) = (attribute.to_owned(), value.to_owned());
        let numbers: Result<Vec<f64>, _> = value.split_whitespace().map(str::parse).collect();
        let Some(numbers) = numbers.ok().filter(|n| n.len() == *count) else {
            return fail(Fault::NotNumbers {
                attribute: name,
                value: text,
                count: *count,
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
            Range::Any => continue,
            Range::NotNegative if numbers.iter().all(|&n| n >= 0.0) => continue,
            Range::Positive if numbers.iter().all(|&n| n > 0.0) => continue,
            Range::NotNegative if tag == "mass" => "above 0",
            Range::NotNegative => "0 or above",
            Range::Positive => "above 0",
        };
        return fail(Fault::OutOfRange {
            key: name,
            value: text,
            range,
        });
    }
    Ok(())
}

pub(super) fn check_inertial(source: &Source, inertial: Node) -> Result<(), RobotError> {
    let required = |tag| {
        child(inertial, tag)
            .ok_or_else(|| source.error(inertial, Fault::MissingElement { child: tag }))
    };
    let mass = required("mass")?;
    let inertia = required("inertia")?;
    let number = |node: Node, attribute| -> f64 {
        let text = node.attribute(attribute).unwrap_or_default();
        text.trim().parse().unwrap_or_default()
    };
    let i = |attribute| number(inertia, attribute);
    let tensor = Matrix3::new(
        i("ixx"),
        i("ixy"),
        i("ixz"),
        i("ixy"),
        i("iyy"),
        i("iyz"),
        i("ixz"),
        i("iyz"),
        i("izz"),
    );
    let massless = number(mass, "value") == 0.0;
    if massless && tensor == Matrix3::zeros() {
        // A placeholder without substance; that it stands for nothing is said where bodies are merged.
        return Ok(());
    }
    if massless {
        let fault = Fault::OutOfRange {
            key: "value".to_owned(),
            value: "0".to_owned(),
            range: "above 0",
        };
        return Err(source.attribute_error(mass, "value", fault));
    }
    let [least, middle, most] = principal_moments(tensor);
    if least <= 0.0 {
        return Err(source.error(inertia, Fault::InertiaNotPositive { least }));
    }
    // A mass per mille of slack lets through numbers that were rounded to three digits.
    if least + middle < most * (1.0 - 1e-3) {
        let fault = Fault::InertiaImpossible {
            least,
            middle,
            most,
        };
        return Err(source.error(inertia, fault));
    }
    Ok(())
}

fn check_geometry(source: &Source, shape: Node) -> Result<(), RobotError> {
    const KINDS: [&str; 5] = ["box", "cylinder", "capsule", "sphere", "mesh"];
    let Some(geometry) = child(shape, "geometry") else {
        return Err(source.error(shape, Fault::MissingElement { child: "geometry" }));
    };
    match geometry.children().find(Node::is_element) {
        Some(kind) if KINDS.contains(&kind.tag_name().name()) => Ok(()),
        _ => Err(source.error(geometry, Fault::UnknownGeometry)),
    }
}

fn check_joint(source: &Source, joint: Node, links: &HashSet<&str>) -> Result<(), RobotError> {
    let joint_type = joint.attribute("type").ok_or_else(|| {
        let attribute = "type".to_owned();
        source.error(joint, Fault::MissingAttribute { attribute })
    })?;
    if !JOINT_TYPES.contains(&joint_type) {
        let joint_type = joint_type.to_owned();
        return Err(source.attribute_error(joint, "type", Fault::UnknownJointType { joint_type }));
    }
    for tag in ["parent", "child"] {
        let end = child(joint, tag)
            .ok_or_else(|| source.error(joint, Fault::MissingElement { child: tag }))?;
        let link = end.attribute("link").ok_or_else(|| {
            let attribute = "link".to_owned();
            source.error(end, Fault::MissingAttribute { attribute })
        })?;
        if !links.contains(link) {
            let link = link.to_owned();
            return Err(source.attribute_error(end, "link", Fault::UnknownLink { link }));
        }
    }
    let turns = ["continuous", "revolute", "prismatic", "planar"].contains(&joint_type);
    if let Some(axis) = child(joint, "axis").filter(|_| turns) {
        let xyz = axis.attribute("xyz").unwrap_or_default();
        let length_squared: f64 = xyz
            .split_whitespace()
            .filter_map(|s| s.parse::<f64>().ok())
            .map(|x| x * x)
            .sum();
        if length_squared < 1e-12 {
            return Err(source.attribute_error(axis, "xyz", Fault::ZeroAxis));
        }
    }
    Ok(())
}
