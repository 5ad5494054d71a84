//! Energy of the simulated robot, summed over its parts.

use ilon_robot::{MassProperties, Robot};
use nalgebra::Vector3;

use crate::robot::state::State;
use crate::robot::wheel::WheelBody;

/// Kinetic and potential energy, in J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Energy {
    /// Of all parts in the world, including the rollers' spin.
    pub kinetic_j: f64,
    /// Of all parts above the world's origin, and of the springs of the contacts.
    pub potential_j: f64,
}

/// Kinetic energy of a robot with a loaded chassis in a state, in J; `wheels` has the rates of
/// their rollers.
pub(crate) fn kinetic_j(
    (robot, chassis): (&Robot, &MassProperties),
    state: &State,
    wheels: &[WheelBody],
) -> f64 {
    let moving_j =
        |mass_kg: f64, velocity_m_s: Vector3<f64>| 0.5 * mass_kg * velocity_m_s.norm_squared();
    let in_body = state.floor_from_chassis().rotation.inverse() * state.angular_rad_s;
    let mut sum_j = moving_j(chassis.mass_kg, state.velocity_m_s)
        + 0.5 * in_body.dot(&(chassis.inertia_kg_m2 * in_body));
    for (index, (joint, link)) in robot.joints.iter().zip(state.links()).enumerate() {
        let mass = &joint.body.mass;
        let place_m = link.place_m(&mass.center_of_mass_m);
        let in_link = link.rotation.tr_mul(&state.link_rate(index));
        sum_j += moving_j(mass.mass_kg, state.link_velocity_m_s(index, &place_m))
            + 0.5 * in_link.dot(&(mass.inertia_kg_m2 * in_link));
    }
    for (index, (wheel, hub)) in robot.wheels.iter().zip(state.hubs()).enumerate() {
        let in_hub = state.hub_rate_in_hub(index);
        let carried_j = |mass_kg: f64, in_hub_m: &Vector3<f64>| {
            moving_j(
                mass_kg,
                state.hub_velocity_m_s(index, &hub.place_m(in_hub_m)),
            )
        };
        let rotor_kg_m2 = wheel.drive.reflected_inertia_kg_m2();
        sum_j += 0.5 * rotor_kg_m2 * state.wheel_rates_rad_s()[index].powi(2);
        sum_j += carried_j(wheel.hub.mass_kg, &wheel.hub.center_of_mass_m)
            + 0.5 * in_hub.dot(&(wheel.hub.inertia_kg_m2 * in_hub));
        for (roller, turning) in wheel.rollers.iter().zip(&wheels[index].rollers) {
            let spin = turning.spin_rad_s(&in_hub);
            let carried = in_hub.dot(&roller.axis_in_hub);
            let across = in_hub.norm_squared() - carried * carried;
            sum_j += carried_j(roller.mass_kg, &roller.center_in_hub_m)
                + 0.5 * roller.transverse_inertia_kg_m2 * across
                + 0.5 * roller.axial_inertia_kg_m2 * (carried + spin).powi(2);
            if let Some(slide) = &turning.slide {
                sum_j += slide.kinetic_j();
            }
        }
    }
    sum_j
}

/// Potential energy of a robot with a loaded chassis in a state above the origin of the floor's
/// frame and in the springs of its joints, in J; `gravity` is the acceleration of gravity in the
/// floor's frame, in m/s^2.
pub(crate) fn potential_j(
    (robot, chassis): (&Robot, &MassProperties),
    state: &State,
    gravity: &Vector3<f64>,
) -> f64 {
    let of = |mass_kg: f64, at_m: Vector3<f64>| -mass_kg * gravity.dot(&at_m);
    let mut sum_j = of(chassis.mass_kg, state.center_m());
    for (index, (joint, link)) in robot.joints.iter().zip(state.links()).enumerate() {
        let mass = &joint.body.mass;
        sum_j += of(mass.mass_kg, link.place_m(&mass.center_of_mass_m))
            + joint.stored_j(state.joint_positions()[index]);
    }
    for (wheel, hub) in robot.wheels.iter().zip(state.hubs()) {
        sum_j += of(wheel.hub.mass_kg, hub.place_m(&wheel.hub.center_of_mass_m));
        for roller in &wheel.rollers {
            sum_j += of(roller.mass_kg, hub.place_m(&roller.center_in_hub_m));
        }
    }
    sum_j
}
