//! Allowed numbers of each URDF element, and elements that may occur only once.

use roxmltree::Node;

use super::faults::Faults;
use super::source::{Source, describe};
use crate::error::{Fault, RobotError};
use crate::model::Remark;

/// Range of an attribute's numbers.
#[derive(Clone, Copy, PartialEq)]
enum Range {
    Any,
    NotNegative,
    Positive,
    /// Above 0 and at most 1.
    Share,
}

use Range::{Any, NotNegative, Positive, Share};

/// The numeric attributes of URDF: element, attributes, count, whether required, range.
const NUMBERS: [(&str, &str, usize, bool, Range); 26] = [
    ("origin", "xyz rpy", 3, false, Any),
    ("origin", "quat_xyzw", 4, false, Any),
    ("mass", "value", 1, true, NotNegative),
    ("inertia", "ixx iyy izz", 1, true, Any),
    ("inertia", "ixy ixz iyz", 1, false, Any),
    ("box", "size", 3, true, Positive),
    ("sphere", "radius", 1, true, Positive),
    ("cylinder", "radius length", 1, true, Positive),
    ("capsule", "radius length", 1, true, Positive),
    ("mesh", "scale", 3, false, Any),
    ("axis", "xyz", 3, true, Any),
    ("limit", "lower upper", 1, false, Any),
    ("limit", "effort velocity", 1, false, NotNegative),
    ("mimic", "multiplier offset", 1, false, Any),
    ("dynamics", "damping friction", 1, false, NotNegative),
    ("ilon_spring", "stiffness", 1, true, Positive),
    ("ilon_spring", "rest preload", 1, false, Any),
    ("ilon_drive", "gear_ratio", 1, false, Positive),
    ("ilon_drive", "gear_efficiency", 1, false, Share),
    ("ilon_drive", DRIVE, 1, false, NotNegative),
    ("ilon_rollers", FORM, 1, false, Positive),
    ("ilon_rollers", LOSSES, 1, false, NotNegative),
    ("ilon_rollers", SPREAD, 1, false, NotNegative),
    ("ilon_tyres", "width", 1, false, Positive),
    ("ilon_tyres", "shoulder_radius", 1, false, NotNegative),
    ("roller", "radius_offset", 1, true, Any),
];
const DRIVE: &str = "rotor_inertia gear_friction";
const FORM: &str =
    "tread_stiffness tread_shear_stiffness tread_relaxation_length radius length_factor crown";
const LOSSES: &str =
    "rolling_resistance tread_damping tread_shear_damping axial_play axle_friction axle_radius";
const SPREAD: &str = "edge_radius radius_spread radius_seed";

/// Children that an element may have only once. The first of several is used, as in ROS tools.
const SINGLE: [(&str, &[&str]); 4] = [
    ("link", &["inertial"]),
    ("inertial", &["origin", "mass", "inertia"]),
    (
        "joint",
        &["origin", "parent", "child", "axis", "limit", "dynamics"],
    ),
    ("collision", &["origin", "geometry"]),
];

/// Largest number except limits: beyond it products of numbers overflow.
const LARGEST: f64 = 1e9;

/// Adds remarks on repeated elements.
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

/// Collects the faults of an element's numbers; returns whether there are none.
pub(super) fn check_numbers(source: &Source, node: Node, faults: &mut Faults) -> bool {
    let tag = node.tag_name().name();
    let rows = NUMBERS.iter().filter(|row| row.0 == tag);
    let mut good = true;
    for (_, attributes, count, required, range) in rows {
        for attribute in attributes.split(' ') {
            let checked = check_number(source, node, attribute, (*count, *required, *range));
            good &= faults.keep(checked).is_some();
        }
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
            return Err(source.error(node, Fault::missing_attribute(attribute)));
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
    // Huge limits mean no limit; lengths, masses and inertias must not be huge.
    if tag != "limit" && numbers.iter().any(|n| n.abs() > LARGEST) {
        return fail(Fault::OutOfRange {
            key: name,
            value: text,
            range: "below a thousand million",
        });
    }
    let range = match range {
        Any => return Ok(()),
        NotNegative if numbers.iter().all(|&n| n >= 0.0) => return Ok(()),
        Positive if numbers.iter().all(|&n| n > 0.0) => return Ok(()),
        Share if numbers.iter().all(|&n| n > 0.0 && n <= 1.0) => return Ok(()),
        NotNegative if tag == "mass" => "above 0",
        NotNegative => "0 or above",
        Share => "above 0 and at most 1",
        Positive => "above 0",
    };
    fail(Fault::OutOfRange {
        key: name,
        value: text,
        range,
    })
}

/// Returns the number of a checked attribute; 0 if absent.
pub(super) fn number(node: Node, attribute: &str) -> f64 {
    let text = node.attribute(attribute).unwrap_or_default();
    text.trim().parse().unwrap_or_default()
}
