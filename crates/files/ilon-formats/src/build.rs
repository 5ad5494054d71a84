//! Builds the robot of a description directly, without URDF text.
//!
//! It builds what is read back from the output of [`generate`](crate::generate), frame by frame; a
//! test compares both. Studies that inspect a thousand designs per second need it.

use std::path::Path;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::described_wheel::wheel;
use crate::error::RobotError;
use crate::generate::suspension::{Carrier, carriers};
use crate::model::{
    Body, BodyJoint, Chassis, Collision, CollisionShape, JointKind, JointRole, JointSpring,
    MassProperties, Robot, Wheel,
};
use crate::options::LoadOptions;
use crate::prepare::read_text;
use crate::spec::{ChassisShape, ChassisSpec, Spec, check, is_on_tyres};
use crate::urdf::joint_frame;

/// Returns the robot of a TOML description with the options' changed keys, and the changed
/// description; `None` for another kind of file, for a robot on tyres, and for options other than
/// changed keys. Except for rounding it is the robot as loaded, without remarks.
///
/// # Errors
/// A file that cannot be read, and an invalid description.
pub fn described(path: &Path, options: &LoadOptions) -> Result<Option<(Robot, Spec)>, RobotError> {
    let plain = LoadOptions {
        spec: options.spec.clone(),
        files: options.files.clone(),
        ..LoadOptions::default()
    };
    if *options != plain || path.extension().is_none_or(|ending| ending != "toml") {
        return Ok(None);
    }
    let file = path.display().to_string();
    let text = read_text(path, &file, options)?;
    if is_on_tyres(&text) {
        return Ok(None);
    }
    let spec = Spec::from_toml_str_with(&text, &file, &options.spec)?;
    Ok(Some((build(&spec)?, spec)))
}

/// Returns the robot of a description.
///
/// # Errors
/// Those of [`generate`](crate::generate), and rollers that cannot be made.
pub fn build(spec: &Spec) -> Result<Robot, RobotError> {
    let described = spec.described();
    check(spec, &described)?;
    let carriers = carriers(spec, &described);
    let mut wheels = Vec::with_capacity(described.len());
    for described in &described {
        let carries = |carrier: &Carrier| carrier.carries(&described.placed.name);
        wheels.push(Wheel {
            carrier: carriers.iter().position(carries),
            ..wheel(spec, described)?
        });
    }
    Ok(Robot {
        name: spec.name.clone(),
        chassis: chassis(&spec.chassis),
        joints: carriers.iter().map(joint).collect(),
        couplings: Vec::new(),
        wheels,
        remarks: Vec::new(),
    })
}

/// The joint that carries wheels; its body does not collide.
fn joint(of: &Carrier) -> BodyJoint {
    let body_from_joint = joint_frame(Vector3::from(of.place_m), &Vector3::from(of.axis));
    let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), of.heading_rad);
    let at_m = Vector3::from(of.place_m) + Vector3::from(of.middle_m);
    let body_from_box = Isometry3::from_parts(Translation3::from(at_m), heading);
    let mass = of.solid().weighing(of.mass_kg);
    let spring = |stiffness| JointSpring {
        stiffness,
        rest: 0.0,
        preload: of.preload,
    };
    BodyJoint {
        name: of.joint.clone(),
        parent: None,
        kind: if of.slides {
            JointKind::Slides
        } else {
            JointKind::Turns
        },
        body_from_joint,
        body: Body {
            name: format!("{}_link", of.joint),
            mass: mass.moved(&(body_from_joint.inverse() * body_from_box)),
            collisions: Vec::new(),
        },
        role: match of.stiffness {
            Some(stiffness) => JointRole::Sprung(spring(stiffness)),
            None => JointRole::Free,
        },
        limits: [-of.travel, of.travel],
        damping: of.damping,
        friction: of.friction,
    }
}

fn chassis(said: &ChassisSpec) -> Chassis {
    let shape = match said.shape {
        ChassisShape::Box { size_m } => CollisionShape::Box {
            half_extents_m: 0.5 * Vector3::from(size_m),
        },
        ChassisShape::Cylinder { radius_m, height_m } => CollisionShape::Cylinder {
            radius_m,
            length_m: height_m,
        },
    };
    let center_m = Vector3::from(said.center_m);
    Chassis {
        name: "base_link".to_owned(),
        mass: MassProperties {
            center_of_mass_m: center_m,
            ..said.shape.solid().weighing(said.mass_kg)
        },
        collisions: vec![Collision {
            friction: None,
            body_from_shape: Isometry3::from_parts(
                Translation3::from(center_m),
                UnitQuaternion::identity(),
            ),
            shape,
        }],
    }
}
