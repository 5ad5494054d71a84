//! The drives of wheels in a URDF: `<transmission>` has only the gear's ratio; the elements of
//! [`crate::generate`] have all values. Also the surfaces of rollers, which URDF does not know.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::numbers::number;
use super::source::{Source, child};
use super::tree::Tree;
use crate::error::{Fault, RobotError};
use crate::model::{
    DriveTrain, JointSpring, Roller, RollerForm, RollerSurface, RollersAsMade, Tread, Wheel,
};

/// Returns the drives of the joints that have one in the file.
pub(super) fn drives(source: &Source, tree: &Tree) -> BTreeMap<String, DriveTrain> {
    let mut drives = BTreeMap::new();
    let known = |name: &str| tree.joints.iter().any(|joint| joint.name == name);
    let of_robot = |tag| {
        source
            .robot()
            .children()
            .filter(move |n: &Node| n.has_tag_name(tag))
    };
    for transmission in of_robot("transmission") {
        let ratio = transmission
            .descendants()
            .find(|n| n.has_tag_name("mechanicalReduction"))
            .and_then(|n| n.text()?.trim().parse::<f64>().ok())
            .map(f64::abs)
            .filter(|ratio| ratio.is_finite() && *ratio > 0.0);
        let joint = child(transmission, "joint").and_then(|n| n.attribute("name"));
        if let (Some(gear_ratio), Some(joint)) = (ratio, joint.filter(|name| known(name))) {
            let drive = DriveTrain {
                gear_ratio,
                ..DriveTrain::default()
            };
            drives.insert(joint.to_owned(), drive);
        }
    }
    // Its numbers were checked with all others.
    for node in of_robot("ilon_drive") {
        let Some(joint) = node.attribute("joint").filter(|name| known(name)) else {
            continue;
        };
        let said = |name: &str, default: f64| match node.attribute(name) {
            Some(_) => number(node, name),
            None => default,
        };
        let default = DriveTrain::default();
        let drive = DriveTrain {
            gear_ratio: said("gear_ratio", default.gear_ratio),
            rotor_inertia_kg_m2: said("rotor_inertia", default.rotor_inertia_kg_m2),
            gear_efficiency: said("gear_efficiency", default.gear_efficiency),
            gear_friction_n_m: said("gear_friction", default.gear_friction_n_m),
        };
        drives.insert(joint.to_owned(), drive);
    }
    drives
}

/// Returns the springs in joints, by the joints' names: those of the original file, and those in
/// this text.
pub(super) fn springs(source: &Source) -> BTreeMap<String, JointSpring> {
    let mut springs = source.prepared.springs.clone();
    let elements = source.robot().children();
    // Joints and numbers were checked with all others.
    for node in elements.filter(|n| n.has_tag_name("ilon_spring")) {
        let said = |name: &str| node.attribute(name).map(|_| number(node, name));
        if let (Some(joint), Some(stiffness)) = (node.attribute("joint"), said("stiffness")) {
            let spring = JointSpring {
                stiffness,
                rest: said("rest").unwrap_or(0.0),
                preload: said("preload").unwrap_or(0.0),
            };
            springs.insert(joint.to_owned(), spring);
        }
    }
    springs
}

/// Returns the given surfaces of rollers, by the wheels' joints.
pub(super) fn surfaces(source: &Source) -> BTreeMap<String, RollerSurface> {
    let elements = source.robot().children();
    let said = elements.filter(|n| n.has_tag_name("ilon_rollers"));
    // Joints and numbers were checked with all others.
    said.filter_map(|node| {
        let said = |name: &str| node.attribute(name).map(|_| number(node, name));
        let tread = said("tread_stiffness").map(|stiffness_n_m| Tread {
            stiffness_n_m,
            damping_n_s_m: said("tread_damping"),
            shear_stiffness_n_m: said("tread_shear_stiffness"),
            shear_damping_n_s_m: said("tread_shear_damping"),
            relaxation_length_m: said("tread_relaxation_length"),
        });
        let surface = RollerSurface {
            tread,
            rolling_resistance: said("rolling_resistance").unwrap_or(0.0),
            axial_play_m: said("axial_play").unwrap_or(0.0),
            axle_friction: said("axle_friction").unwrap_or(0.0),
            axle_radius_m: said("axle_radius").unwrap_or(0.0),
        };
        Some((node.attribute("joint")?.to_owned(), surface))
    })
    .collect()
}

/// Returns the given materials of rollers, by the wheels' joints.
pub(super) fn materials(source: &Source) -> BTreeMap<String, String> {
    let elements = source.robot().children();
    let said = elements.filter(|n| n.has_tag_name("ilon_rollers"));
    said.filter_map(|node| {
        let material = node.attribute("material")?.trim();
        let joint = node.attribute("joint")?;
        (!material.is_empty()).then(|| (joint.to_owned(), material.to_owned()))
    })
    .collect()
}

/// Returns the element on the rollers of a wheel.
fn rollers_element<'a>(source: &'a Source<'a>, wheel: &str) -> Option<Node<'a, 'a>> {
    let mut elements = source.robot().children();
    elements.find(|n| n.has_tag_name("ilon_rollers") && n.attribute("joint") == Some(wheel))
}

/// Returns the radius of a wheel's rollers at their middle, in metres, if the file gives it: then
/// their links have the shapes as made.
pub(super) fn given_radius_m(source: &Source, wheel: &str) -> Option<f64> {
    let node = rollers_element(source, wheel)?;
    node.attribute("radius").map(|_| number(node, "radius"))
}

/// Makes the rollers of a wheel as the file specifies, if it does.
pub(super) fn make_rollers(source: &Source, wheel: &mut Wheel) -> Result<(), RobotError> {
    let Some(node) = rollers_element(source, &wheel.name) else {
        return Ok(());
    };
    let is_modelled = |of: &Roller| matches!(of.form, RollerForm::AsModelled(_));
    if node.attribute("radius").is_some() && wheel.rollers.iter().any(is_modelled) {
        return Ok(());
    }
    // Joints and numbers were checked with all others, except the profile, which may have any
    // length.
    let said = |name: &str| node.attribute(name).map(|_| number(node, name));
    let profile_m = node.attribute("profile").map(|text| {
        let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
        let (pairs, rest) = numbers.as_deref().unwrap_or(&[f64::NAN]).as_chunks::<2>();
        if rest.is_empty() {
            return Ok(pairs.to_vec());
        }
        let reason = "`profile` needs pairs of numbers: place along the axis and radius, in metres";
        let reason = reason.to_owned();
        Err(source.attribute_error(node, "profile", Fault::RollersNotMade { reason }))
    });
    let offsets = node.children().filter(|n| n.has_tag_name("roller"));
    let default = RollersAsMade::default();
    let made = RollersAsMade {
        crown: said("crown").unwrap_or(default.crown),
        profile_m: profile_m.transpose()?,
        edge_radius_m: said("edge_radius").unwrap_or(default.edge_radius_m),
        radius_spread_m: said("radius_spread").unwrap_or(default.radius_spread_m),
        // The file's number is finite and not negative; a seed ignores its decimals.
        radius_seed: said("radius_seed").map_or(default.radius_seed, |seed| seed as u64),
        radius_offsets_m: offsets
            .filter_map(|n| Some((n.attribute("joint")?.to_owned(), number(n, "radius_offset"))))
            .collect(),
    };
    let length_factor = said("length_factor");
    if made.is_ideal() && length_factor.is_none() {
        return Ok(());
    }
    let read = wheel.rollers.clone();
    wheel.make_rollers(made, length_factor).map_err(|e| {
        let reason = e.to_string();
        source.error(node, Fault::RollersNotMade { reason })
    })?;
    if node.attribute("radius").is_some() {
        // The moments of the file are those of the rollers as made.
        for (roller, read) in wheel.rollers.iter_mut().zip(&read) {
            roller.axial_inertia_kg_m2 = read.axial_inertia_kg_m2;
            roller.transverse_inertia_kg_m2 = read.transverse_inertia_kg_m2;
        }
    }
    Ok(())
}
