//! Builds the robot of a description directly, without URDF text.
//!
//! It builds what is read back from the output of [`generate`](crate::generate), frame by frame; a
//! test compares both. Studies that inspect a thousand designs per second need it.

use std::f64::consts::TAU;
use std::path::Path;

use nalgebra::{
    Isometry3, Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3,
};

use crate::error::{Fault, RobotError};
use crate::generate::elements::{box_moments, cylinder_moments};
use crate::generate::suspension::{Carrier, carriers};
use crate::model::{
    Barrel, Body, BodyJoint, Chassis, Collision, CollisionShape, Joint, JointKind, JointRole,
    JointSpring, MassProperties, MotorLimits, Robot, Roller, RollerForm, RollersAsMade, Wheel,
};
use crate::options::LoadOptions;
use crate::prepare::read_text;
use crate::spec::{ChassisShape, ChassisSpec, Described, Spec, check, is_on_tyres};
use crate::urdf::{hub_frame, joint_frame};

/// Returns the robot of a TOML description with the options' changed keys, and the changed
/// description; `None` for another kind of file, for a robot on tyres, and for options other than changed keys. Except
/// for rounding it is the robot as loaded, without remarks.
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
    let mass = MassProperties {
        mass_kg: of.mass_kg,
        center_of_mass_m: Vector3::zeros(),
        inertia_kg_m2: Matrix3::from_diagonal(&box_moments(of.mass_kg, of.sides_m)),
    };
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
    let (shape, moments) = match said.shape {
        ChassisShape::Box { size_m } => (
            CollisionShape::Box {
                half_extents_m: 0.5 * Vector3::from(size_m),
            },
            box_moments(said.mass_kg, size_m),
        ),
        ChassisShape::Cylinder { radius_m, height_m } => (
            CollisionShape::Cylinder {
                radius_m,
                length_m: height_m,
            },
            cylinder_moments(said.mass_kg, radius_m, height_m),
        ),
    };
    let center_m = Vector3::from(said.center_m);
    Chassis {
        name: "base_link".to_owned(),
        mass: MassProperties {
            mass_kg: said.mass_kg,
            center_of_mass_m: center_m,
            inertia_kg_m2: Matrix3::from_diagonal(&moments),
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

/// Returns the wheel of a description.
pub(crate) fn wheel(spec: &Spec, described: &Described) -> Result<Wheel, RobotError> {
    let (placed, said, rollers) = (&described.placed, &described.wheel, &described.rollers);
    let [x_m, y_m] = placed.position_m;
    let (sin, cos) = libm::sincos(placed.axis_deg.to_radians());
    let axis = Unit::new_normalize(Vector3::new(cos, sin, 0.0));
    let barrel = described.barrel_at_least_handing_over();
    let roller_moments = barrel.solid_moments_kg_m2(rollers.mass_kg);
    let mut made: Vec<Roller> = (0..described.roller_count())
        .map(|index| roller(described, &barrel, roller_moments, index))
        .collect();
    made.sort_by(|p, q| p.place_rad().total_cmp(&q.place_rad()));
    // Those of a cylinder along z, the hub's axis.
    let moments = cylinder_moments(said.hub_mass_kg, said.hub_radius_m, said.hub_width_m);
    let mut wheel = Wheel {
        name: placed.name.clone(),
        carrier: None,
        body_from_hub: hub_frame(&Point3::new(x_m, y_m, described.axle_height_m), &axis),
        hub: MassProperties {
            mass_kg: said.hub_mass_kg,
            center_of_mass_m: Vector3::zeros(),
            inertia_kg_m2: Matrix3::from_diagonal(&moments),
        },
        radius_m: said.radius_m,
        gamma_rad: placed.gamma_deg.to_radians(),
        rollers: made,
        motor: MotorLimits {
            effort_n_m: said.motor_effort_n_m,
            velocity_rad_s: said.motor_velocity_rad_s,
        },
        joint: Joint {
            damping_n_m_s: said.damping_n_m_s,
            friction_n_m: said.friction_n_m,
        },
        drive: said.drive(),
        surface: rollers.surface(),
        material: rollers.material.clone(),
        made: RollersAsMade::default(),
    };
    let (as_made, factor) = (rollers.made(), rollers.length_factor);
    if !as_made.is_ideal() || factor < 1.0 {
        let of_wheel = |name: &String| described.has_roller(name);
        let mut as_made = as_made;
        as_made.radius_offsets_m.retain(|name, _| of_wheel(name));
        let shorter = (factor < 1.0).then_some(factor);
        wheel.make_rollers(as_made, shorter).map_err(|e| {
            let reason = e.to_string();
            RobotError::new(&spec.name, Fault::RollersNotMade { reason })
        })?;
    }
    Ok(wheel)
}

/// Returns one roller, in the hub's frame: z along the hub's axis and x down.
fn roller(
    described: &Described,
    barrel: &Barrel,
    (axial_kg_m2, across_kg_m2): (f64, f64),
    index: usize,
) -> Roller {
    let said = &described.rollers;
    let (sin, cos) = libm::sincos(described.placed.gamma_deg.to_radians());
    let place_rad = TAU * index as f64 / described.roller_count() as f64 + described.phase_rad;
    let across_m = match said.rows {
        2 if index.is_multiple_of(2) => -0.5 * said.row_spacing_m,
        2 => 0.5 * said.row_spacing_m,
        _ => 0.0,
    };
    // For the roller that points down: n_gamma = k x u_gamma, u_gamma the hub's axis turned by
    // gamma.
    let around = Rotation3::from_axis_angle(&Vector3::z_axis(), place_rad);
    let axis = around * Vector3::new(0.0, cos, -sin);
    Roller {
        name: described.roller_name(index),
        center_in_hub_m: around * Vector3::new(barrel.ring_radius_m, 0.0, across_m),
        axis_in_hub: Unit::new_normalize(axis),
        radius_m: barrel.wheel_radius_m - barrel.ring_radius_m,
        length_m: 2.0 * barrel.half_length_m,
        mass_kg: said.mass_kg,
        axial_inertia_kg_m2: axial_kg_m2,
        transverse_inertia_kg_m2: across_kg_m2,
        joint: Joint {
            damping_n_m_s: said.damping_n_m_s,
            friction_n_m: said.friction_n_m,
        },
        form: RollerForm::Barrel,
    }
}
