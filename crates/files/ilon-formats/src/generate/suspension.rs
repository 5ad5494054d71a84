//! What wheels hang on: links on joints between the chassis and the wheels, and how they are
//! written in URDF.

use std::fmt::Write;

use super::elements::{
    Place, attribute, num, nums, write_dynamics, write_inertial, write_joint, write_visual,
};
use crate::solid::Solid;
use crate::spec::{Described, Spec, SuspensionLaw};

/// A body between the chassis and wheels, on its joint.
pub(crate) struct Carrier {
    pub joint: String,
    /// Where the joint is, in the body frame, in metres.
    pub place_m: [f64; 3],
    pub wheels: Vec<String>,
    pub slides: bool,
    pub axis: [f64; 3],
    pub travel: f64,
    /// Stiffness, preload, damping, dry friction; without a stiffness it is free.
    pub stiffness: Option<f64>,
    pub preload: f64,
    pub damping: f64,
    pub friction: f64,
    pub mass_kg: f64,
    /// Its box: sides and middle in the joint's frame, and its heading, in metres and radians.
    pub sides_m: [f64; 3],
    pub middle_m: [f64; 3],
    pub heading_rad: f64,
}

impl Carrier {
    /// Its box as a solid.
    pub fn solid(&self) -> Solid {
        Solid::Box {
            size_m: self.sides_m.into(),
        }
    }

    /// Whether a wheel hangs on it.
    pub fn carries(&self, wheel: &str) -> bool {
        self.wheels.iter().any(|of| of == wheel)
    }
}

/// The bodies between chassis and wheels that a description asks for, which was checked.
pub(crate) fn carriers(spec: &Spec, wheels: &[Described]) -> Vec<Carrier> {
    let mut carriers = Vec::new();
    for (name, of) in &spec.suspension {
        let hung = of
            .wheels
            .iter()
            .filter_map(|name| wheels.iter().find(|wheel| wheel.placed.name == *name));
        let hung: Vec<&Described> = hung.collect();
        match of.law {
            SuspensionLaw::Rocker {
                limit_deg,
                damping_n_m_s_rad,
                friction_n_m,
            } => {
                if let [a, b] = hung[..] {
                    carriers.push(Carrier {
                        wheels: of.wheels.clone(),
                        travel: limit_deg.to_radians(),
                        damping: damping_n_m_s_rad,
                        friction: friction_n_m,
                        ..bar(name, of.mass_kg, [a, b])
                    });
                }
            }
            SuspensionLaw::Sprung {
                stiffness_n_m,
                damping_n_s_m,
                friction_n,
                preload_n,
                travel_m,
            } => carriers.extend(hung.iter().map(|wheel| Carrier {
                slides: true,
                axis: [0.0, 0.0, 1.0],
                travel: travel_m,
                stiffness: Some(stiffness_n_m),
                // On the wheel: down.
                preload: -preload_n,
                damping: damping_n_s_m,
                friction: friction_n,
                ..at_wheel("spring", of.mass_kg, wheel)
            })),
            SuspensionLaw::TrailingArm {
                length_m,
                stiffness_n_m_rad,
                damping_n_m_s_rad,
                friction_n_m,
                preload_n_m,
                travel_deg,
            } => carriers.extend(hung.iter().map(|wheel| {
                let at_wheel = at_wheel("arm", of.mass_kg, wheel);
                let [x_m, y_m, z_m] = at_wheel.place_m;
                let [_, thick_m, _] = at_wheel.sides_m;
                Carrier {
                    place_m: [x_m + length_m, y_m, z_m],
                    // A load on a wheel behind its pivot turns the arm about the left, and about
                    // the right where the wheel is ahead.
                    axis: [0.0, 1.0_f64.copysign(length_m), 0.0],
                    travel: travel_deg.to_radians(),
                    stiffness: Some(stiffness_n_m_rad),
                    preload: -preload_n_m,
                    damping: damping_n_m_s_rad,
                    friction: friction_n_m,
                    sides_m: [length_m.abs(), thick_m, thick_m],
                    middle_m: [-0.5 * length_m, 0.0, 0.0],
                    ..at_wheel
                }
            })),
        }
    }
    carriers
}

/// How thick these bodies are, over the radius of a wheel.
const THICKNESS: f64 = 0.3;

/// A bar between two wheels, which turns about its middle, across itself.
fn bar(name: &str, mass_kg: f64, [a, b]: [&Described; 2]) -> Carrier {
    let ([ax, ay], [bx, by]) = (a.placed.position_m, b.placed.position_m);
    let way_m = [bx - ax, by - ay];
    let long_m = way_m[0].hypot(way_m[1]);
    // Across the bar, ahead or to the left.
    let [x, y] = [way_m[1] / long_m, -way_m[0] / long_m];
    let sign = if x < -1e-9 || x.abs() <= 1e-9 && y < 0.0 {
        -1.0
    } else {
        1.0
    };
    let thick_m = THICKNESS * a.wheel.radius_m;
    Carrier {
        joint: name.to_owned(),
        place_m: [
            0.5 * (ax + bx),
            0.5 * (ay + by),
            0.5 * (a.axle_height_m + b.axle_height_m),
        ],
        axis: [sign * x, sign * y, 0.0],
        sides_m: [long_m, thick_m, thick_m],
        heading_rad: libm::atan2(way_m[1], way_m[0]),
        ..still(mass_kg)
    }
}

/// A block at a wheel's axle.
fn at_wheel(kind: &str, mass_kg: f64, wheel: &Described) -> Carrier {
    let [x_m, y_m] = wheel.placed.position_m;
    let name = &wheel.placed.name;
    Carrier {
        joint: format!("{name}_{kind}"),
        place_m: [x_m, y_m, wheel.axle_height_m],
        wheels: vec![name.clone()],
        sides_m: [THICKNESS * wheel.wheel.radius_m; 3],
        ..still(mass_kg)
    }
}

/// A body of a mass that nothing is said of.
fn still(mass_kg: f64) -> Carrier {
    Carrier {
        joint: String::new(),
        place_m: [0.0; 3],
        wheels: Vec::new(),
        slides: false,
        axis: [0.0; 3],
        travel: 0.0,
        stiffness: None,
        preload: 0.0,
        damping: 0.0,
        friction: 0.0,
        mass_kg,
        sides_m: [0.0; 3],
        middle_m: [0.0; 3],
        heading_rad: 0.0,
    }
}

/// Writes a body between chassis and wheels. It is seen and has mass, and touches nothing.
pub(super) fn write_carrier(out: &mut String, of: &Carrier) -> std::fmt::Result {
    let name = attribute(&of.joint);
    let kind = if of.slides { "prismatic" } else { "revolute" };
    let child = format!("{name}_link");
    let place = Place::turned(of.place_m, 0.0);
    let links = ["base_link", &child];
    write_joint(out, (&name, kind), links, (place, &nums(&of.axis)))?;
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
    let moments = of.solid().moments_kg_m2(of.mass_kg);
    write_inertial(out, &origin, of.mass_kg, &moments)?;
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
