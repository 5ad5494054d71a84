//! The elements of URDF as they are written.

use std::fmt::Write;

use ilon_robot::roll_pitch_yaw;
use nalgebra::{Isometry3, Matrix3, Vector3};

use crate::model::Barrel;
use crate::spec::{ChassisShape, ChassisSpec};

pub(super) fn cylinder(radius_m: f64, length_m: f64) -> String {
    format!(
        "<cylinder radius=\"{}\" length=\"{}\"/>",
        num(radius_m),
        num(length_m)
    )
}

/// Where something is, with all digits.
pub(crate) fn origin(pose: &Isometry3<f64>) -> String {
    let [x, y, z]: [f64; 3] = pose.translation.vector.into();
    let [roll, pitch, yaw] = roll_pitch_yaw(&pose.rotation.to_rotation_matrix());
    format!("<origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>")
}

/// An inertia, with all digits.
pub(crate) fn inertia(i: &Matrix3<f64>) -> String {
    format!(
        "<inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/>",
        i.m11, i.m12, i.m13, i.m22, i.m23, i.m33
    )
}

pub(super) fn write_inertial(
    out: &mut String,
    origin: &str,
    mass_kg: f64,
    moments: &Vector3<f64>,
) -> std::fmt::Result {
    writeln!(
        out,
        "    <inertial>{origin}<mass value=\"{}\"/>\
         <inertia ixx=\"{}\" ixy=\"0\" ixz=\"0\" iyy=\"{}\" iyz=\"0\" izz=\"{}\"/></inertial>",
        num(mass_kg),
        num(moments.x),
        num(moments.y),
        num(moments.z)
    )
}

pub(super) fn write_geometry(
    out: &mut String,
    origin: &str,
    geometry: &str,
    material: &str,
    rgba: &str,
) -> std::fmt::Result {
    write_visual(out, origin, geometry, material, rgba)?;
    writeln!(
        out,
        "    <collision>{origin}<geometry>{geometry}</geometry></collision>"
    )
}

pub(super) fn write_visual(
    out: &mut String,
    origin: &str,
    geometry: &str,
    material: &str,
    rgba: &str,
) -> std::fmt::Result {
    writeln!(
        out,
        "    <visual>{origin}<geometry>{geometry}</geometry>\
         <material name=\"{material}\"><color rgba=\"{rgba}\"/></material></visual>"
    )
}

/// Where a joint is in its parent: its place in metres, roll, pitch and yaw in radians.
pub(super) struct Place {
    pub at_m: [f64; 3],
    pub rpy_rad: [f64; 3],
}

impl Place {
    /// Turned about the vertical axis alone.
    pub fn turned(at_m: [f64; 3], yaw_rad: f64) -> Self {
        let rpy_rad = [0.0, 0.0, yaw_rad];
        Self { at_m, rpy_rad }
    }
}

/// The head of a joint, without its limits; names are attributes already.
pub(super) fn write_joint(
    out: &mut String,
    (name, kind): (&str, &str),
    [parent, child]: [&str; 2],
    (place, axis): (Place, &str),
) -> std::fmt::Result {
    let (xyz, rpy) = (nums(&place.at_m), nums(&place.rpy_rad));
    writeln!(
        out,
        "  <joint name=\"{name}\" type=\"{kind}\">\n    <parent link=\"{parent}\"/>\n    <child link=\"{child}\"/>\n    \
         <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/>\n    <axis xyz=\"{axis}\"/>"
    )
}

pub(super) fn write_dynamics(
    out: &mut String,
    damping_n_m_s: f64,
    friction_n_m: f64,
) -> std::fmt::Result {
    writeln!(
        out,
        "    <dynamics damping=\"{}\" friction=\"{}\"/>",
        num(damping_n_m_s),
        num(friction_n_m)
    )
}

/// A number with fifteen significant digits: all that a double holds but for the noise of its last
/// place.
pub(crate) fn num(value: f64) -> String {
    if value.abs() < 1e-15 {
        return "0".to_owned();
    }
    let rounded: f64 = format!("{value:.14e}").parse().unwrap_or(value);
    if rounded.abs() < 1e-4 {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}

pub(crate) fn nums(values: &[f64]) -> String {
    values.iter().map(|&v| num(v)).collect::<Vec<_>>().join(" ")
}

/// A text as the value of an XML attribute.
pub(crate) fn attribute(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// A text inside an XML comment, which must not hold two hyphens in a row.
pub(crate) fn comment_text(text: &str) -> String {
    // Each second hyphen of a run too.
    text.replace("--", "- -").replace("--", "- -")
}

/// Spheres that stand for one roller in collision and visual.
pub(super) const SPHERES_PER_ROLLER: usize = 7;

/// The spheres that stand for a barrel: place along its axis and radius, in metres.
pub(crate) fn spheres_of(barrel: &Barrel) -> impl Iterator<Item = [f64; 2]> {
    (0..SPHERES_PER_ROLLER).map(|i| {
        // From -1 to 1 along the half length.
        let along = 2.0 * i as f64 / (SPHERES_PER_ROLLER - 1) as f64 - 1.0;
        let t_m = along * barrel.half_length_m;
        [t_m, barrel.sphere_radius_m(t_m)]
    })
}

/// The chassis as the root link.
pub(super) fn write_chassis(out: &mut String, c: &ChassisSpec) -> std::fmt::Result {
    let geometry = match c.shape {
        ChassisShape::Box { size_m } => format!("<box size=\"{}\"/>", nums(&size_m)),
        ChassisShape::Cylinder { radius_m, height_m } => cylinder(radius_m, height_m),
    };
    let moments = c.shape.solid().moments_kg_m2(c.mass_kg);
    let origin = format!("<origin xyz=\"{}\" rpy=\"0 0 0\"/>", nums(&c.center_m));
    writeln!(out, "  <link name=\"base_link\">")?;
    write_inertial(out, &origin, c.mass_kg, &moments)?;
    write_geometry(out, &origin, &geometry, "chassis", "0.35 0.40 0.45 1")?;
    writeln!(out, "  </link>")
}

/// The element that names the wheels on tyres, each with whether a motor drives it, and the width
/// and shoulder radius in metres that all tyres share.
pub(crate) fn tyres_element<'a>(
    all: Option<(f64, Option<f64>)>,
    wheels: impl Iterator<Item = (&'a str, bool)>,
) -> String {
    let (width_m, shoulder_m) = all.unzip();
    let sizes = [
        ("width", width_m),
        ("shoulder_radius", shoulder_m.flatten()),
    ];
    let size = |(name, m): (&str, Option<f64>)| Some(format!(" {name}=\"{}\"", num(m?)));
    let sizes: String = sizes.into_iter().filter_map(size).collect();
    let wheel = |(name, driven)| {
        let name = attribute(name);
        format!("    <wheel joint=\"{name}\" driven=\"{driven}\"/>\n")
    };
    let wheels: String = wheels.map(wheel).collect();
    format!("  <ilon_tyres{sizes}>\n{wheels}  </ilon_tyres>\n")
}
