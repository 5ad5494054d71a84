//! URDF with explicit rollers, written from a short description.
//!
//! Frames: the body's origin is on the ground. A wheel's link has its origin at the wheel's centre, y along the hub axis
//! and z up at wheel angle zero; its joint turns about y. A roller's link has its origin at the roller's centre, x
//! outward from the hub axis and z along its own axis, **n**_gamma = **k** x **u**_gamma for the roller that points down;
//! its joint turns about z.
//!
//! A roller collides as a short stack of spheres along its axis, each with the exact radius of the barrel there, the
//! outermost at its two ends: tools that know only URDF roll on it, and a reader recovers the barrel from it.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write;

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::Barrel;
use crate::error::{Fault, RobotError};
use crate::spec::{ChassisShape, PlacedWheel, Spec};

/// Spheres that stand for one roller in collision and visual.
const SPHERES_PER_ROLLER: usize = 7;

/// Writes the URDF of a described robot.
///
/// # Errors
/// A value out of its range, and rollers too slender to reach their neighbours. The errors name the key, but no place
/// in a file.
pub fn generate(spec: &Spec) -> Result<String, RobotError> {
    let wheels = spec.wheels.placed();
    check(spec, &wheels)?;
    let mut out = String::new();
    write_robot(&mut out, spec, &wheels).map_err(|e| {
        let reason = e.to_string();
        RobotError::new(&spec.name, Fault::Unreadable { reason })
    })?;
    Ok(out)
}

fn write_robot(out: &mut String, spec: &Spec, wheels: &[PlacedWheel]) -> std::fmt::Result {
    let (w, r) = (&spec.wheel, &spec.rollers);
    writeln!(out, "<?xml version=\"1.0\" encoding=\"utf-8\"?>")?;
    writeln!(
        out,
        "<!-- Generated: change the description it was written from, not this file.\n     \
         {} wheels of radius {} m; hubs of {} kg; motors of {} N m and {} rad/s at the wheel.\n     \
         {} row(s) of {} rollers a wheel; rollers of radius {} m and {} kg; bearing damping {} N m s/rad.\n     \
         Frame: origin of the chassis on the ground, x forward, y left, z up. A roller is the stack of spheres whose\n     \
         envelope makes the outline of the wheel a circle; its length lets neighbours hand over without gap or overlap.",
        wheels.len(),
        num(w.radius_m),
        num(w.hub_mass_kg),
        num(w.motor_effort_n_m),
        num(w.motor_velocity_rad_s),
        r.rows,
        r.per_row,
        num(r.radius_m),
        num(r.mass_kg),
        num(r.damping_n_m_s),
    )?;
    for wheel in wheels {
        writeln!(
            out,
            "     {}: b = ({}, {}) m, hub axis at {} deg, gamma = {} deg.",
            comment_text(&wheel.name),
            num(wheel.position_m[0]),
            num(wheel.position_m[1]),
            num(wheel.axis_deg),
            num(wheel.gamma_deg)
        )?;
    }
    writeln!(out, "-->\n<robot name=\"{}\">", attribute(&spec.name))?;
    write_chassis(out, spec)?;
    for wheel in wheels {
        write_wheel(out, spec, wheel)?;
    }
    writeln!(out, "</robot>")
}

fn write_chassis(out: &mut String, spec: &Spec) -> std::fmt::Result {
    let c = &spec.chassis;
    let (geometry, moments) = match c.shape {
        ChassisShape::Box { size_m: [x, y, z] } => (
            format!("<box size=\"{}\"/>", nums(&[x, y, z])),
            Vector3::new(y * y + z * z, x * x + z * z, x * x + y * y) * (c.mass_kg / 12.0),
        ),
        ChassisShape::Cylinder { radius_m, height_m } => (
            cylinder(radius_m, height_m),
            cylinder_moments(c.mass_kg, radius_m, height_m),
        ),
    };
    let origin = format!("<origin xyz=\"{}\" rpy=\"0 0 0\"/>", nums(&c.center_m));
    writeln!(out, "  <link name=\"base_link\">")?;
    write_inertial(out, &origin, c.mass_kg, &moments)?;
    write_geometry(out, &origin, &geometry, "chassis", "0.35 0.40 0.45 1")?;
    writeln!(out, "  </link>")
}

fn write_wheel(out: &mut String, spec: &Spec, wheel: &PlacedWheel) -> std::fmt::Result {
    let w = &spec.wheel;
    let name = attribute(&wheel.name);
    // The link's y axis is the hub axis, a quarter turn ahead of its x axis.
    let yaw_rad = (wheel.axis_deg - 90.0).to_radians();
    writeln!(out, "  <joint name=\"{name}\" type=\"continuous\">")?;
    writeln!(
        out,
        "    <parent link=\"base_link\"/>\n    <child link=\"{name}_link\"/>"
    )?;
    let [x_m, y_m] = wheel.position_m;
    writeln!(
        out,
        "    <origin xyz=\"{}\" rpy=\"0 0 {}\"/>",
        nums(&[x_m, y_m, w.radius_m]),
        num(yaw_rad)
    )?;
    writeln!(out, "    <axis xyz=\"0 1 0\"/>")?;
    writeln!(
        out,
        "    <limit effort=\"{}\" velocity=\"{}\"/>",
        num(w.motor_effort_n_m),
        num(w.motor_velocity_rad_s)
    )?;
    write_dynamics(out, w.damping_n_m_s, w.friction_n_m)?;
    writeln!(out, "  </joint>\n  <link name=\"{name}_link\">")?;
    // A cylinder of URDF lies along z; a quarter turn about x lays it along the hub axis y.
    let origin = format!("<origin xyz=\"0 0 0\" rpy=\"{} 0 0\"/>", num(FRAC_PI_2));
    let moments = cylinder_moments(w.hub_mass_kg, w.hub_radius_m, w.hub_width_m);
    write_inertial(out, &origin, w.hub_mass_kg, &moments)?;
    write_geometry(
        out,
        &origin,
        &cylinder(w.hub_radius_m, w.hub_width_m),
        "hub",
        "0.75 0.75 0.78 1",
    )?;
    writeln!(out, "  </link>")?;
    let barrel = barrel(spec, wheel.gamma_deg.to_radians());
    let (axial, across) = barrel.solid_moments_kg_m2(spec.rollers.mass_kg);
    let moments = Vector3::new(across, across, axial);
    for roller in 0..spec.rollers.per_row * spec.rollers.rows {
        write_roller(out, spec, wheel, &barrel, &moments, roller)?;
    }
    Ok(())
}

fn write_roller(
    out: &mut String,
    spec: &Spec,
    wheel: &PlacedWheel,
    barrel: &Barrel,
    moments: &Vector3<f64>,
    index: usize,
) -> std::fmt::Result {
    let r = &spec.rollers;
    let gamma_rad = wheel.gamma_deg.to_radians();
    let name = format!("{}_roller_{}", attribute(&wheel.name), index + 1);

    // Rollers of two rows take turns around the rim, half a pitch of one row apart.
    let place_rad = TAU * index as f64 / (r.per_row * r.rows) as f64;
    let row_offset_m = if r.rows == 2 {
        r.row_spacing_m * (if index.is_multiple_of(2) { -0.5 } else { 0.5 })
    } else {
        0.0
    };
    // The roller that points down, in the link's frame: hub axis y, u_gamma = y turned by gamma about z, and the
    // roller's axis n_gamma = k x u_gamma.
    let n_gamma = Vector3::new(-libm::cos(gamma_rad), -libm::sin(gamma_rad), 0.0);
    let down = -Vector3::z();
    let link_from_down = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[
        down,
        n_gamma.cross(&down),
        n_gamma,
    ]));
    let around = Rotation3::from_axis_angle(&Vector3::y_axis(), place_rad);
    let link_from_roller = around * link_from_down;
    let center_m = around * (down * barrel.ring_radius_m) + Vector3::y() * row_offset_m;
    let [roll, pitch, yaw] = roll_pitch_yaw(&link_from_roller);

    writeln!(out, "  <joint name=\"{name}\" type=\"continuous\">")?;
    writeln!(
        out,
        "    <parent link=\"{}_link\"/>\n    <child link=\"{name}_link\"/>",
        attribute(&wheel.name)
    )?;
    writeln!(
        out,
        "    <origin xyz=\"{}\" rpy=\"{}\"/>",
        nums(center_m.as_slice()),
        nums(&[roll, pitch, yaw])
    )?;
    writeln!(out, "    <axis xyz=\"0 0 1\"/>")?;
    // A passive joint: nothing drives it, and no roller ever spins as fast as this.
    writeln!(out, "    <limit effort=\"0\" velocity=\"1000\"/>")?;
    write_dynamics(out, r.damping_n_m_s, r.friction_n_m)?;
    writeln!(out, "  </joint>\n  <link name=\"{name}_link\">")?;
    write_inertial(
        out,
        "<origin xyz=\"0 0 0\" rpy=\"0 0 0\"/>",
        r.mass_kg,
        moments,
    )?;
    for i in 0..SPHERES_PER_ROLLER {
        // From -1 to 1 along the half length.
        let along = 2.0 * i as f64 / (SPHERES_PER_ROLLER - 1) as f64 - 1.0;
        let t_m = along * barrel.half_length_m;
        write_geometry(
            out,
            &format!("<origin xyz=\"0 0 {}\" rpy=\"0 0 0\"/>", num(t_m)),
            &format!("<sphere radius=\"{}\"/>", num(barrel.sphere_radius_m(t_m))),
            "roller",
            "0.12 0.12 0.12 1",
        )?;
    }
    writeln!(out, "  </link>")
}

/// Roll, pitch and yaw of R = Rz(yaw) Ry(pitch) Rx(roll). The arc sine of the textbook loses half of the digits near a
/// pitch of 90 degrees, where the roller that points down stands; here yaw is taken first and undone, which loses none.
fn roll_pitch_yaw(rotation: &Rotation3<f64>) -> [f64; 3] {
    let m = rotation.matrix();
    // At a pitch of 90 degrees yaw and roll do the same: then yaw is left at zero.
    let upright = libm::hypot(m[(0, 0)], m[(1, 0)]) < 1e-9;
    let yaw = if upright {
        0.0
    } else {
        libm::atan2(m[(1, 0)], m[(0, 0)])
    };
    let (s, c) = libm::sincos(yaw);
    let pitch = libm::atan2(-m[(2, 0)], c * m[(0, 0)] + s * m[(1, 0)]);
    let roll = libm::atan2(s * m[(0, 2)] - c * m[(1, 2)], c * m[(1, 1)] - s * m[(0, 1)]);
    [roll, pitch, yaw]
}

/// The barrel of a described wheel: rollers of both rows take turns, so that all of them share the turn evenly.
fn barrel(spec: &Spec, gamma_rad: f64) -> Barrel {
    Barrel::handing_over(
        spec.wheel.radius_m,
        spec.rollers.radius_m,
        gamma_rad,
        spec.rollers.per_row * spec.rollers.rows,
    )
}

/// Principal moments of a solid cylinder along z about its centre, in kg m^2.
fn cylinder_moments(mass_kg: f64, radius_m: f64, length_m: f64) -> Vector3<f64> {
    let across = mass_kg * (3.0 * radius_m * radius_m + length_m * length_m) / 12.0;
    Vector3::new(across, across, 0.5 * mass_kg * radius_m * radius_m)
}

fn cylinder(radius_m: f64, length_m: f64) -> String {
    format!(
        "<cylinder radius=\"{}\" length=\"{}\"/>",
        num(radius_m),
        num(length_m)
    )
}

fn write_inertial(
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

fn write_geometry(
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
    )?;
    writeln!(
        out,
        "    <collision>{origin}<geometry>{geometry}</geometry></collision>"
    )
}

fn write_dynamics(out: &mut String, damping_n_m_s: f64, friction_n_m: f64) -> std::fmt::Result {
    writeln!(
        out,
        "    <dynamics damping=\"{}\" friction=\"{}\"/>",
        num(damping_n_m_s),
        num(friction_n_m)
    )
}

/// A number with fifteen significant digits: all that a double holds but for the noise of its last place.
fn num(value: f64) -> String {
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

fn nums(values: &[f64]) -> String {
    values.iter().map(|&v| num(v)).collect::<Vec<_>>().join(" ")
}

/// A text as the value of an XML attribute.
fn attribute(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// A text inside an XML comment, which must not hold two hyphens in a row.
fn comment_text(text: &str) -> String {
    text.replace("--", "- -")
}

fn check(spec: &Spec, wheels: &[PlacedWheel]) -> Result<(), RobotError> {
    const POSITIVE: &str = "a finite number above 0";
    const NOT_NEGATIVE: &str = "a finite number, 0 or above";
    const FINITE: &str = "a finite number";
    let fault = |fault| Err(RobotError::new(&spec.name, fault));
    let out_of_range = |key: &str, value: String, range| {
        let key = key.to_owned();
        fault(Fault::OutOfRange { key, value, range })
    };
    let (c, w, r) = (&spec.chassis, &spec.wheel, &spec.rollers);
    let (shape_key, sides): (&str, &[f64]) = match &c.shape {
        ChassisShape::Box { size_m } => ("chassis.shape.box.size_m", size_m),
        ChassisShape::Cylinder { radius_m, height_m } => {
            ("chassis.shape.cylinder", &[*radius_m, *height_m])
        }
    };
    let positive = sides.iter().map(|&side| (shape_key, side)).chain([
        ("chassis.mass_kg", c.mass_kg),
        ("wheel.radius_m", w.radius_m),
        ("wheel.hub_mass_kg", w.hub_mass_kg),
        ("wheel.hub_radius_m", w.hub_radius_m),
        ("wheel.hub_width_m", w.hub_width_m),
        ("wheel.motor_effort_n_m", w.motor_effort_n_m),
        ("wheel.motor_velocity_rad_s", w.motor_velocity_rad_s),
        ("rollers.radius_m", r.radius_m),
        ("rollers.mass_kg", r.mass_kg),
    ]);
    for (key, value) in positive {
        if !(value.is_finite() && value > 0.0) {
            return out_of_range(key, num(value), POSITIVE);
        }
    }
    for (key, value) in [
        ("wheel.damping_n_m_s", w.damping_n_m_s),
        ("wheel.friction_n_m", w.friction_n_m),
        ("rollers.damping_n_m_s", r.damping_n_m_s),
        ("rollers.friction_n_m", r.friction_n_m),
        ("rollers.row_spacing_m", r.row_spacing_m),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            return out_of_range(key, num(value), NOT_NEGATIVE);
        }
    }
    if let Some(&value) = c.center_m.iter().find(|v| !v.is_finite()) {
        return out_of_range("chassis.center_m", num(value), FINITE);
    }
    if !(1..=2).contains(&r.rows) {
        return out_of_range("rollers.rows", r.rows.to_string(), "1 or 2");
    }
    if !(3..=1000).contains(&r.per_row) {
        return out_of_range("rollers.per_row", r.per_row.to_string(), "from 3 to 1000");
    }
    if !(3..=1000).contains(&wheels.len()) {
        return out_of_range("wheels", wheels.len().to_string(), "from 3 to 1000 wheels");
    }
    for wheel in wheels {
        for value in [wheel.position_m[0], wheel.position_m[1], wheel.axis_deg] {
            if !value.is_finite() {
                return out_of_range("wheels: position and axis", num(value), FINITE);
            }
        }
        // At 90 deg the rollers turn about the hub axis and the wheel cannot drive.
        if wheel.gamma_deg.is_nan() || wheel.gamma_deg.abs() > 85.0 {
            let range = "from -85 to 85 degrees: nearer to 90 the rollers turn with the hub and carry no drive";
            return out_of_range("wheels: gamma_deg", num(wheel.gamma_deg), range);
        }
    }
    if r.radius_m >= w.radius_m {
        let range = "below `wheel.radius_m`";
        return out_of_range("rollers.radius_m", num(r.radius_m), range);
    }
    // The end spheres keep a positive radius where rho > a / cos(pi/n): r_max > rho (1 - cos(pi/n)).
    let half_pitch_rad = PI / (r.per_row * r.rows) as f64;
    let least_radius_m = w.radius_m * (1.0 - libm::cos(half_pitch_rad));
    if r.radius_m <= least_radius_m {
        return fault(Fault::RollersTooSlender {
            roller_radius_mm: 1e3 * r.radius_m,
            least_radius_mm: 1e3 * least_radius_m,
        });
    }
    Ok(())
}
