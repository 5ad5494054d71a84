//! What wheels hang on, in URDF: links on joints between the chassis and the wheels.

use std::fmt::Write;

use super::elements::{
    attribute, box_moments, num, nums, write_dynamics, write_inertial, write_visual,
};
use crate::spec::{Described, Spec, SuspensionLaw, SuspensionSpec};

/// A body between the chassis and wheels, on its joint.
pub(super) struct Carrier {
    pub joint: String,
    /// Where the joint is, in the body frame, in metres.
    pub place_m: [f64; 3],
    wheels: Vec<String>,
    slides: bool,
    axis: [f64; 3],
    travel: f64,
    /// Stiffness, preload, damping, dry friction; without a stiffness it is free.
    stiffness: Option<f64>,
    preload: f64,
    damping: f64,
    friction: f64,
    mass_kg: f64,
    /// Its box: sides and middle in the joint's frame, and its heading, in metres and radians.
    sides_m: [f64; 3],
    middle_m: [f64; 3],
    heading_rad: f64,
}

impl Carrier {
    /// Whether a wheel hangs on it.
    pub fn carries(&self, wheel: &str) -> bool {
        self.wheels.iter().any(|of| of == wheel)
    }
}

/// The bodies between chassis and wheels that a description asks for, which was checked.
pub(super) fn carriers(spec: &Spec, wheels: &[Described]) -> Vec<Carrier> {
    let of = |(name, of): (&String, &SuspensionSpec)| {
        let hung = of
            .wheels
            .iter()
            .filter_map(|name| wheels.iter().find(|wheel| wheel.placed.name == *name));
        let hung: Vec<&Described> = hung.collect();
        match &of.law {
            SuspensionLaw::Rocker { .. } => vec![rocker(name, of, &hung)],
            _ => hung.iter().map(|wheel| own(of, wheel)).collect(),
        }
    };
    spec.suspension.iter().flat_map(of).collect()
}

/// How thick these bodies are, over the radius of a wheel.
const THICKNESS: f64 = 0.3;

/// A bar between two wheels, which turns about its middle, across itself.
fn rocker(name: &str, of: &SuspensionSpec, hung: &[&Described]) -> Carrier {
    let [a, b] = [0, 1].map(|at| hung[at].placed.position_m);
    let way_m = [b[0] - a[0], b[1] - a[1]];
    let long_m = way_m[0].hypot(way_m[1]);
    // Across the bar, ahead or to the left.
    let [x, y] = [way_m[1] / long_m, -way_m[0] / long_m];
    let sign = if x < -1e-9 || x.abs() <= 1e-9 && y < 0.0 {
        -1.0
    } else {
        1.0
    };
    let thick_m = THICKNESS * hung[0].wheel.radius_m;
    let SuspensionLaw::Rocker {
        limit_deg,
        damping_n_m_s_rad,
        friction_n_m,
    } = of.law
    else {
        unreachable!("it is called for rockers alone");
    };
    Carrier {
        joint: name.to_owned(),
        place_m: [
            0.5 * (a[0] + b[0]),
            0.5 * (a[1] + b[1]),
            0.5 * (hung[0].axle_height_m + hung[1].axle_height_m),
        ],
        wheels: of.wheels.clone(),
        slides: false,
        axis: [sign * x, sign * y, 0.0],
        travel: limit_deg.to_radians(),
        stiffness: None,
        preload: 0.0,
        damping: damping_n_m_s_rad,
        friction: friction_n_m,
        mass_kg: of.mass_kg,
        sides_m: [long_m, thick_m, thick_m],
        middle_m: [0.0; 3],
        heading_rad: libm::atan2(way_m[1], way_m[0]),
    }
}

/// A slide, or an arm, of one wheel.
fn own(of: &SuspensionSpec, wheel: &Described) -> Carrier {
    let thick_m = THICKNESS * wheel.wheel.radius_m;
    let [x_m, y_m] = wheel.placed.position_m;
    let name = &wheel.placed.name;
    let common = |joint: String| Carrier {
        joint,
        place_m: [x_m, y_m, wheel.axle_height_m],
        wheels: vec![name.clone()],
        slides: true,
        axis: [0.0, 0.0, 1.0],
        travel: 0.0,
        stiffness: None,
        preload: 0.0,
        damping: 0.0,
        friction: 0.0,
        mass_kg: of.mass_kg,
        sides_m: [thick_m; 3],
        middle_m: [0.0; 3],
        heading_rad: 0.0,
    };
    match of.law {
        SuspensionLaw::Sprung {
            stiffness_n_m,
            damping_n_s_m,
            friction_n,
            preload_n,
            travel_m,
        } => Carrier {
            travel: travel_m,
            stiffness: Some(stiffness_n_m),
            // On the wheel: down.
            preload: -preload_n,
            damping: damping_n_s_m,
            friction: friction_n,
            ..common(format!("{name}_spring"))
        },
        SuspensionLaw::TrailingArm {
            length_m,
            stiffness_n_m_rad,
            damping_n_m_s_rad,
            friction_n_m,
            preload_n_m,
            travel_deg,
        } => Carrier {
            place_m: [x_m + length_m, y_m, wheel.axle_height_m],
            slides: false,
            // A load on a wheel behind its pivot turns the arm about the left, and about the right where the wheel is ahead.
            axis: [0.0, 1.0_f64.copysign(length_m), 0.0],
            travel: travel_deg.to_radians(),
            stiffness: Some(stiffness_n_m_rad),
            preload: -preload_n_m,
            damping: damping_n_m_s_rad,
            friction: friction_n_m,
            sides_m: [length_m.abs(), thick_m, thick_m],
            middle_m: [-0.5 * length_m, 0.0, 0.0],
            ..common(format!("{name}_arm"))
        },
        SuspensionLaw::Rocker { .. } => unreachable!("a rocker carries two wheels"),
    }
}

/// Writes a body between chassis and wheels. It is seen and has mass, and touches nothing.
pub(super) fn write_carrier(out: &mut String, of: &Carrier) -> std::fmt::Result {
    let name = attribute(&of.joint);
    let kind = if of.slides { "prismatic" } else { "revolute" };
    writeln!(out, "  <joint name=\"{name}\" type=\"{kind}\">")?;
    writeln!(
        out,
        "    <parent link=\"base_link\"/>\n    <child link=\"{name}_link\"/>"
    )?;
    writeln!(
        out,
        "    <origin xyz=\"{}\" rpy=\"0 0 0\"/>",
        nums(&of.place_m)
    )?;
    writeln!(out, "    <axis xyz=\"{}\"/>", nums(&of.axis))?;
    // Nothing drives it.
    writeln!(
        out,
        "    <limit lower=\"{}\" upper=\"{}\" effort=\"0\" velocity=\"100\"/>",
        num(-of.travel),
        num(of.travel)
    )?;
    write_dynamics(out, of.damping, of.friction)?;
    writeln!(out, "  </joint>\n  <link name=\"{name}_link\">")?;
    let origin = format!(
        "<origin xyz=\"{}\" rpy=\"0 0 {}\"/>",
        nums(&of.middle_m),
        num(of.heading_rad)
    );
    write_inertial(
        out,
        &origin,
        of.mass_kg,
        &box_moments(of.mass_kg, of.sides_m),
    )?;
    let geometry = format!("<box size=\"{}\"/>", nums(&of.sides_m));
    write_visual(out, &origin, &geometry, "carrier", "0.55 0.55 0.58 1")?;
    writeln!(out, "  </link>")?;
    // URDF has no word for a spring.
    match of.stiffness {
        Some(stiffness) => writeln!(
            out,
            "  <ilon_spring joint=\"{name}\" stiffness=\"{}\" rest=\"0\" preload=\"{}\"/>",
            num(stiffness),
            num(of.preload)
        ),
        None => Ok(()),
    }
}
