//! URDF of a robot on tyres, written from a short description.
//!
//! A wheel's link has its origin at the wheel's centre, y along the hub axis and z up; its joint
//! turns about y. A steered wheel hangs on a fork, which turns about z. What URDF has no word for,
//! the tyre's shoulders and which wheels a motor drives, stands in the element `<ilon_tyres>`.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;

use super::elements::{
    Place, attribute, cylinder, num, tyres_element, write_chassis, write_dynamics, write_geometry,
    write_inertial, write_joint,
};
use crate::solid::Solid;
use crate::spec::{CasterSpec, SpecOnTyres, SteeringSpec, TyredWheel};

/// Writes the URDF of a described robot on tyres.
pub fn generate_on_tyres(spec: &SpecOnTyres) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_robot(&mut out, spec);
    out
}

fn write_robot(out: &mut String, spec: &SpecOnTyres) -> std::fmt::Result {
    writeln!(out, "<?xml version=\"1.0\" encoding=\"utf-8\"?>")?;
    writeln!(
        out,
        "<!-- Generated: change the description it was written from, not this file. -->\n<robot name=\"{}\">",
        attribute(&spec.name)
    )?;
    write_chassis(out, &spec.chassis)?;
    for wheel in &spec.wheels {
        write_wheel(out, spec, wheel)?;
    }
    for caster in &spec.casters {
        write_caster(out, caster)?;
    }
    let t = &spec.tyres;
    let wheels = spec
        .wheels
        .iter()
        .map(|wheel| (&wheel.name[..], wheel.driven));
    let all = Some((t.width_m, t.shoulder_radius_m));
    writeln!(out, "{}</robot>", tyres_element(all, wheels))
}

/// A link that is a solid cylinder about its y axis.
fn write_disc(
    out: &mut String,
    link: &str,
    (mass_kg, radius_m, width_m): (f64, f64, f64),
) -> std::fmt::Result {
    writeln!(out, "  <link name=\"{link}\">")?;
    // A cylinder of URDF lies along z; a quarter turn about x lays it along y.
    let origin = format!("<origin xyz=\"0 0 0\" rpy=\"{} 0 0\"/>", num(FRAC_PI_2));
    let disc = Solid::Cylinder {
        radius_m,
        length_m: width_m,
    };
    let moments = disc.moments_kg_m2(mass_kg);
    write_inertial(out, &origin, mass_kg, &moments)?;
    let shape = cylinder(radius_m, width_m);
    write_geometry(out, &origin, &shape, "tyre", "0.12 0.12 0.12 1")?;
    writeln!(out, "  </link>")
}

/// A link with the moments of a solid cylinder along its z axis, as high as wide.
fn write_fork(out: &mut String, link: &str, mass_kg: f64, radius_m: f64) -> std::fmt::Result {
    writeln!(out, "  <link name=\"{link}\">")?;
    let fork = Solid::Cylinder {
        radius_m,
        length_m: radius_m,
    };
    let moments = fork.moments_kg_m2(mass_kg);
    write_inertial(
        out,
        "<origin xyz=\"0 0 0\" rpy=\"0 0 0\"/>",
        mass_kg,
        &moments,
    )?;
    writeln!(out, "  </link>")
}

fn write_wheel(out: &mut String, spec: &SpecOnTyres, wheel: &TyredWheel) -> std::fmt::Result {
    let t = &spec.tyres;
    let name = attribute(&wheel.name);
    let [x_m, y_m] = wheel.position_m;
    let radius_m = wheel.radius_m.unwrap_or(t.radius_m);
    let yaw_rad = (wheel.axis_deg - 90.0).to_radians();
    let steering = spec.steering.as_ref().filter(|_| wheel.steered);
    let place = match steering {
        None => Place::turned([x_m, y_m, radius_m], yaw_rad),
        Some(steering) => {
            let (sin, cos) = yaw_rad.sin_cos();
            let at_m = [
                x_m + steering.trail_m * cos,
                y_m + steering.trail_m * sin,
                radius_m,
            ];
            write_steering(out, &name, steering, (at_m, yaw_rad, radius_m))?;
            Place::turned([-steering.trail_m, 0.0, 0.0], 0.0)
        }
    };
    let parent = match steering {
        None => "base_link".to_owned(),
        Some(_) => format!("{name}_fork"),
    };
    write_joint(
        out,
        (&name, "continuous"),
        [&parent, &format!("{name}_link")],
        (place, "0 1 0"),
    )?;
    if wheel.driven {
        writeln!(
            out,
            "    <limit effort=\"{}\" velocity=\"{}\"/>",
            num(t.motor_effort_n_m),
            num(t.motor_velocity_rad_s)
        )?;
    }
    write_dynamics(out, t.damping_n_m_s, t.friction_n_m)?;
    writeln!(out, "  </joint>")?;
    write_disc(
        out,
        &format!("{name}_link"),
        (t.mass_kg, radius_m, t.width_m),
    )
}

/// The joint that steers a wheel, and its fork.
fn write_steering(
    out: &mut String,
    wheel: &str,
    steering: &SteeringSpec,
    (at_m, yaw_rad, radius_m): ([f64; 3], f64, f64),
) -> std::fmt::Result {
    let (joint, fork) = (format!("{wheel}_steer"), format!("{wheel}_fork"));
    let kind = match steering.limit_deg {
        Some(_) => "revolute",
        None => "continuous",
    };
    write_joint(
        out,
        (&joint, kind),
        ["base_link", &fork],
        (Place::turned(at_m, yaw_rad), "0 0 1"),
    )?;
    write!(out, "    <limit")?;
    if let Some(limit_deg) = steering.limit_deg {
        let limit = num(limit_deg.to_radians());
        write!(out, " lower=\"-{limit}\" upper=\"{limit}\"")?;
    }
    writeln!(
        out,
        " effort=\"{}\" velocity=\"{}\"/>\n  </joint>",
        num(steering.effort_n_m),
        num(steering.velocity_rad_s)
    )?;
    write_fork(out, &fork, steering.fork_mass_kg, radius_m)
}

fn write_caster(out: &mut String, caster: &CasterSpec) -> std::fmt::Result {
    let name = format!("{}_caster", attribute(&caster.name));
    let (fork, wheel) = (format!("{name}_fork"), format!("{name}_wheel"));
    let [x_m, y_m] = caster.position_m;
    // The fork is as high as the wheel is: half of it above the axle.
    let high_m = 2.0 * caster.radius_m;
    let swivel = (Place::turned([x_m, y_m, high_m], 0.0), "0 0 1");
    let joint = format!("{name}_swivel");
    write_joint(out, (&joint, "continuous"), ["base_link", &fork], swivel)?;
    writeln!(out, "  </joint>")?;
    write_fork(out, &fork, caster.fork_mass_kg, caster.radius_m)?;
    let at_m = [-caster.trail_m, 0.0, -caster.radius_m];
    let roll = (Place::turned(at_m, 0.0), "0 1 0");
    write_joint(
        out,
        (&format!("{name}_roll"), "continuous"),
        [&fork, &wheel],
        roll,
    )?;
    writeln!(out, "  </joint>")?;
    write_disc(
        out,
        &wheel,
        (caster.mass_kg, caster.radius_m, caster.width_m),
    )
}
