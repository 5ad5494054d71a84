//! URDF with explicit rollers, written from a short description.
//!
//! Frames: the body's origin is on the ground. A wheel's link has its origin at the wheel's centre, y along the hub axis
//! and z up at wheel angle zero; its joint turns about y. A roller's link has its origin at the roller's centre, x
//! outward from the hub axis and z along its own axis, **n**_gamma = **k** x **u**_gamma for the roller that points down;
//! its joint turns about z.
//!
//! A roller collides as a short stack of spheres along its axis, each with the exact radius of the
//! barrel there, the outermost at its two ends: tools that know only URDF roll on it, and a reader
//! recovers the barrel from it. Rollers that are made otherwise have the spheres of their own
//! barrel, or a stack of cylinders; their reader makes them from `<ilon_rollers>`, which gives
//! their radius.

mod description;
pub(crate) mod elements;
mod on_tyres;
mod ros2_control;
pub(crate) mod suspension;

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;

use nalgebra::{Matrix3, Rotation3, Vector3};

use self::elements::{
    Place, SPHERES_PER_ROLLER, attribute, comment_text, cylinder, num, nums, spheres_of,
    write_chassis, write_dynamics, write_geometry, write_inertial, write_joint,
};
use self::suspension::{Carrier, carriers, write_carrier};
use crate::described_wheel;
use crate::error::RobotError;
use crate::model::{
    Barrel, DriveTrain, Roller, RollerForm, RollerSurface, RollersAsMade, SolidOfRevolution, Wheel,
};
use crate::spec::{Described, RollerSpec, Spec, check};
use ilon_robot::roll_pitch_yaw;

pub use description::describe;
pub use on_tyres::generate_on_tyres;
pub use ros2_control::with_ros2_control;

/// Solids that stand for a roller: place along its axis, in metres, and geometry.
fn solids_of(wheel: &Wheel, roller: &Roller) -> Vec<(f64, String)> {
    match &roller.form {
        RollerForm::Turned(turned) => slices_of(turned)
            .map(|[t_m, length_m, radius_m]| (t_m, cylinder(radius_m, length_m)))
            .collect(),
        _ => solids_of_barrel(&wheel.barrel(roller)),
    }
}

fn solids_of_barrel(barrel: &Barrel) -> Vec<(f64, String)> {
    spheres_of(barrel)
        .map(|[t_m, radius_m]| (t_m, format!("<sphere radius=\"{}\"/>", num(radius_m))))
        .collect()
}

/// Cylinders that stand for a turned roller: middle, length and radius, in metres.
fn slices_of(turned: &SolidOfRevolution) -> impl Iterator<Item = [f64; 3]> {
    let (first_m, last_m) = turned.span_m();
    let length_m = (last_m - first_m) / SPHERES_PER_ROLLER as f64;
    (0..SPHERES_PER_ROLLER).map(move |i| {
        let t_m = first_m + length_m * (i as f64 + 0.5);
        [t_m, length_m, turned.surface_radius_m(t_m)]
    })
}

/// Writes the URDF of a described robot.
///
/// # Errors
/// A value out of its range, and rollers too slender to reach their neighbours. The errors name the key, but no place
/// in a file.
pub fn generate(spec: &Spec) -> Result<String, RobotError> {
    let wheels = spec.described();
    check(spec, &wheels)?;
    let made = wheels
        .iter()
        .map(|wheel| match is_made(&wheel.rollers) {
            true => described_wheel::wheel(spec, wheel).map(Some),
            false => Ok(None),
        })
        .collect::<Result<Vec<Option<Wheel>>, _>>()?;
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_robot(&mut out, spec, &wheels, &made);
    Ok(out)
}

/// Whether rollers are others than barrels that hand over. A seed alone changes none.
fn is_made(rollers: &RollerSpec) -> bool {
    let made = RollersAsMade {
        radius_seed: 0,
        ..rollers.made()
    };
    !made.is_ideal() || rollers.length_factor < 1.0
}

fn write_robot(
    out: &mut String,
    spec: &Spec,
    wheels: &[Described],
    made: &[Option<Wheel>],
) -> std::fmt::Result {
    let (w, r) = (&spec.wheel, &spec.rollers);
    writeln!(out, "<?xml version=\"1.0\" encoding=\"utf-8\"?>")?;
    writeln!(
        out,
        "<!-- Generated: change the description it was written from, not this file.\n     \
         {} wheels of radius {} m; hubs of {} kg; motors of {} N m and {} rad/s at the wheel.\n     \
         {} row(s) of {} rollers a wheel; rollers of radius {} m and {} kg; bearing damping {} N m s/rad.\n     \
         Frame: origin of the chassis on the ground, x forward, y left, z up. A roller is the stack of spheres whose\n     \
         envelope makes the outline of the wheel a circle; its length {}.{}",
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
        match r.length_factor {
            1.0 => "lets neighbours hand over without gap or overlap".to_owned(),
            factor if factor > 1.0 => {
                format!("is {} times that without gap or overlap", num(factor))
            }
            _ => "lets neighbours hand over without gap or overlap".to_owned(),
        },
        if is_made(r) {
            "\n     They are made otherwise, as the elements <ilon_rollers> say: the solids of their links are those of rollers as made."
        } else {
            ""
        },
    )?;
    for wheel in wheels {
        let placed = &wheel.placed;
        write!(
            out,
            "     {}: b = ({}, {}) m, hub axis at {} deg, gamma = {} deg.",
            comment_text(&placed.name),
            num(placed.position_m[0]),
            num(placed.position_m[1]),
            num(placed.axis_deg),
            num(placed.gamma_deg)
        )?;
        if wheel.is_overridden {
            write!(
                out,
                " Radius {} m; {} rollers of radius {} m, {} deg on.",
                num(wheel.wheel.radius_m),
                wheel.roller_count(),
                num(wheel.rollers.radius_m),
                num(wheel.phase_rad.to_degrees())
            )?;
        }
        writeln!(out)?;
    }
    writeln!(out, "-->\n<robot name=\"{}\">", attribute(&spec.name))?;
    write_chassis(out, &spec.chassis)?;
    let carriers = carriers(spec, wheels);
    for carrier in &carriers {
        write_carrier(out, carrier)?;
    }
    for (wheel, made) in wheels.iter().zip(made) {
        let carrier = carriers.iter().find(|of| of.carries(&wheel.placed.name));
        write_wheel(out, wheel, made.as_ref(), carrier)?;
    }
    writeln!(out, "</robot>")
}

fn write_wheel(
    out: &mut String,
    wheel: &Described,
    made: Option<&Wheel>,
    carrier: Option<&Carrier>,
) -> std::fmt::Result {
    let (placed, w) = (&wheel.placed, &wheel.wheel);
    let name = attribute(&placed.name);
    // The link's y axis is the hub axis, a quarter turn ahead of its x axis.
    let yaw_rad = (placed.axis_deg - 90.0).to_radians();
    let parent = carrier.map_or("base_link".to_owned(), |of| {
        format!("{}_link", attribute(&of.joint))
    });
    let [x_m, y_m] = placed.position_m;
    let [cx_m, cy_m, cz_m] = carrier.map_or([0.0; 3], |of| of.place_m);
    let at_m = [x_m - cx_m, y_m - cy_m, wheel.axle_height_m - cz_m];
    let place = (Place::turned(at_m, yaw_rad), "0 1 0");
    let child = format!("{name}_link");
    write_joint(out, (&name, "continuous"), [&parent, &child], place)?;
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
    let moments = w.hub().moments_kg_m2(w.hub_mass_kg);
    write_inertial(out, &origin, w.hub_mass_kg, &moments)?;
    write_geometry(
        out,
        &origin,
        &cylinder(w.hub_radius_m, w.hub_width_m),
        "hub",
        "0.75 0.75 0.78 1",
    )?;
    writeln!(out, "  </link>")?;
    write_drive(out, wheel)?;
    write_surface(out, wheel)?;
    let barrel = wheel.barrel_at_least_handing_over();
    let moments = barrel.solid_moments_kg_m2(wheel.rollers.mass_kg);
    for index in 0..wheel.roller_count() {
        let name = wheel.roller_name(index);
        let as_made = made.and_then(|of| Some((of, of.rollers.iter().find(|r| r.name == name)?)));
        let (moments, solids) = match as_made {
            Some((of, roller)) => {
                let moments = (roller.axial_inertia_kg_m2, roller.transverse_inertia_kg_m2);
                (moments, solids_of(of, roller))
            }
            None => (moments, solids_of_barrel(&barrel)),
        };
        write_roller(out, wheel, index, moments, &solids)?;
    }
    Ok(())
}

/// URDF has no word for what lies between a motor and its wheel but a gear's ratio.
fn write_drive(out: &mut String, wheel: &Described) -> std::fmt::Result {
    let drive = wheel.wheel.drive();
    if drive == DriveTrain::default() {
        return Ok(());
    }
    writeln!(
        out,
        "  <ilon_drive joint=\"{}\" gear_ratio=\"{}\" rotor_inertia=\"{}\" gear_efficiency=\"{}\" gear_friction=\"{}\"/>",
        attribute(&wheel.placed.name),
        num(drive.gear_ratio),
        num(drive.rotor_inertia_kg_m2),
        num(drive.gear_efficiency),
        num(drive.gear_friction_n_m)
    )
}

/// URDF has no word for what rollers are covered with either.
fn write_surface(out: &mut String, wheel: &Described) -> std::fmt::Result {
    let surface = wheel.rollers.surface();
    let (made, factor) = (wheel.rollers.made(), wheel.rollers.length_factor);
    let material = wheel.rollers.material.as_deref();
    let is_plain = surface == RollerSurface::default() && material.is_none();
    if is_plain && made.is_ideal() && factor >= 1.0 {
        return Ok(());
    }
    write!(
        out,
        "  <ilon_rollers joint=\"{}\" rolling_resistance=\"{}\"",
        attribute(&wheel.placed.name),
        num(surface.rolling_resistance)
    )?;
    if let Some(material) = material {
        write!(out, " material=\"{}\"", attribute(material))?;
    }
    if let Some(tread) = &surface.tread {
        let said = [
            ("tread_stiffness", Some(tread.stiffness_n_m)),
            ("tread_damping", tread.damping_n_s_m),
            ("tread_shear_stiffness", tread.shear_stiffness_n_m),
            ("tread_shear_damping", tread.shear_damping_n_s_m),
            ("tread_relaxation_length", tread.relaxation_length_m),
        ];
        for (name, value) in said {
            if let Some(value) = value {
                write!(out, " {name}=\"{}\"", num(value))?;
            }
        }
    }
    for (name, value) in [
        ("axial_play", surface.axial_play_m),
        ("axle_friction", surface.axle_friction),
        ("axle_radius", surface.axle_radius_m),
    ] {
        if value != 0.0 {
            write!(out, " {name}=\"{}\"", num(value))?;
        }
    }
    if is_made(&wheel.rollers) {
        write!(out, " radius=\"{}\"", num(wheel.rollers.radius_m))?;
    }
    if is_made(&wheel.rollers) && factor != 1.0 && made.profile_m.is_none() {
        write!(out, " length_factor=\"{}\"", num(factor))?;
    }
    if made.crown != 1.0 {
        write!(out, " crown=\"{}\"", num(made.crown))?;
    }
    if let Some(points_m) = &made.profile_m {
        write!(out, " profile=\"{}\"", nums(points_m.as_flattened()))?;
    }
    for (name, value_m) in [
        ("edge_radius", made.edge_radius_m),
        ("radius_spread", made.radius_spread_m),
    ] {
        if value_m != 0.0 {
            write!(out, " {name}=\"{}\"", num(value_m))?;
        }
    }
    if made.radius_seed != 0 {
        write!(out, " radius_seed=\"{}\"", made.radius_seed)?;
    }
    let of_wheel = |name: &&String| wheel.has_roller(name);
    if !made.radius_offsets_m.keys().any(|name| of_wheel(&name)) {
        return writeln!(out, "/>");
    }
    writeln!(out, ">")?;
    for (name, offset_m) in made
        .radius_offsets_m
        .iter()
        .filter(|(name, _)| of_wheel(name))
    {
        let (name, offset) = (attribute(name), num(*offset_m));
        writeln!(
            out,
            "    <roller joint=\"{name}\" radius_offset=\"{offset}\"/>"
        )?;
    }
    writeln!(out, "  </ilon_rollers>")
}

fn write_roller(
    out: &mut String,
    wheel: &Described,
    index: usize,
    (axial, across): (f64, f64),
    solids: &[(f64, String)],
) -> std::fmt::Result {
    let r = &wheel.rollers;
    let gamma_rad = wheel.placed.gamma_deg.to_radians();
    let name = format!("{}_roller_{}", attribute(&wheel.placed.name), index + 1);

    let (place_rad, row_offset_m) = wheel.roller_place(index);
    // The roller that points down, in the link's frame: hub axis y, u_gamma = y turned by gamma
    // about z, and the roller's axis n_gamma = k x u_gamma.
    let n_gamma = Vector3::new(-libm::cos(gamma_rad), -libm::sin(gamma_rad), 0.0);
    let down = -Vector3::z();
    let link_from_down = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[
        down,
        n_gamma.cross(&down),
        n_gamma,
    ]));
    let around = Rotation3::from_axis_angle(&Vector3::y_axis(), place_rad);
    let link_from_roller = around * link_from_down;
    let center_m =
        around * (down * (wheel.wheel.radius_m - r.radius_m)) + Vector3::y() * row_offset_m;
    let place = Place {
        at_m: center_m.into(),
        rpy_rad: roll_pitch_yaw(&link_from_roller),
    };
    let parent = format!("{}_link", attribute(&wheel.placed.name));
    let (joint, links) = (
        (&name[..], "continuous"),
        [&parent, &format!("{name}_link")[..]],
    );
    write_joint(out, joint, links, (place, "0 0 1"))?;
    // A passive joint: nothing drives it, and no roller ever spins as fast as this.
    writeln!(out, "    <limit effort=\"0\" velocity=\"1000\"/>")?;
    write_dynamics(out, r.damping_n_m_s, r.friction_n_m)?;
    writeln!(out, "  </joint>\n  <link name=\"{name}_link\">")?;
    write_inertial(
        out,
        "<origin xyz=\"0 0 0\" rpy=\"0 0 0\"/>",
        r.mass_kg,
        &Vector3::new(across, across, axial),
    )?;
    for (t_m, geometry) in solids {
        write_geometry(
            out,
            &format!("<origin xyz=\"0 0 {}\" rpy=\"0 0 0\"/>", num(*t_m)),
            geometry,
            "roller",
            "0.12 0.12 0.12 1",
        )?;
    }
    writeln!(out, "  </link>")
}
