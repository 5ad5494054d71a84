//! A wheel of a description, with its rollers.

use nalgebra::{Point3, Rotation3, Unit, Vector3};

use crate::error::{Fault, RobotError};
use crate::model::{Barrel, Joint, MotorLimits, Roller, RollerForm, RollersAsMade, Wheel};
use crate::spec::{Described, Spec};
use crate::urdf::hub_frame;

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
    let mut wheel = Wheel {
        name: placed.name.clone(),
        carrier: None,
        body_from_hub: hub_frame(&Point3::new(x_m, y_m, described.axle_height_m), &axis),
        hub: said.hub().weighing(said.hub_mass_kg),
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
    let (place_rad, across_m) = described.roller_place(index);
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
