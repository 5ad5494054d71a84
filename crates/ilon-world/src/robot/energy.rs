//! Energy of the simulated robot, counted part by part.

use ilon_robot::Robot;
use nalgebra::Vector3;

use crate::robot::state::State;
use crate::robot::wheel::WheelBody;

/// Kinetic and potential energy, in J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Of all parts in the world, the rollers' spin included.
    pub kinetic_j: f64,
    /// Above the world's origin.
    pub potential_j: f64,
}

/// Energy of a robot in a state.
///
/// `gravity` is the acceleration of gravity in the floor's frame, in m/s^2; `wheels` know how their rollers turn.
pub(crate) fn energy(
    robot: &Robot,
    state: &State,
    gravity: &Vector3<f64>,
    wheels: &[WheelBody],
) -> Energy {
    let mut sum = Energy::default();
    let mut add_mass = |mass_kg: f64, at_m: &Vector3<f64>, velocity_m_s: &Vector3<f64>| {
        sum.kinetic_j += 0.5 * mass_kg * velocity_m_s.norm_squared();
        sum.potential_j -= mass_kg * gravity.dot(at_m);
    };
    let center_m = state.floor_from_chassis.translation.vector;
    let velocity_at = |at_m: &Vector3<f64>, angular: &Vector3<f64>, pivot_m: &Vector3<f64>| {
        let of_pivot = state.velocity_m_s + state.angular_rad_s.cross(&(pivot_m - center_m));
        of_pivot + angular.cross(&(at_m - pivot_m))
    };
    let chassis = &robot.chassis.mass;
    add_mass(chassis.mass_kg, &center_m, &state.velocity_m_s);
    let in_body = state.floor_from_chassis.rotation.inverse() * state.angular_rad_s;
    let mut turning_j = 0.5 * in_body.dot(&(chassis.inertia_kg_m2 * in_body));

    for (index, wheel) in robot.wheels.iter().enumerate() {
        let floor_from_hub = state.floor_from_hub(index);
        let pivot_m = floor_from_hub.translation.vector;
        let in_hub = state.hub_rate_in_hub(index);
        let angular = floor_from_hub.rotation * in_hub;
        let mut add = |mass_kg: f64, in_hub_m: &Vector3<f64>| {
            let at_m = pivot_m + floor_from_hub.rotation * in_hub_m;
            add_mass(mass_kg, &at_m, &velocity_at(&at_m, &angular, &pivot_m));
        };
        add(wheel.hub.mass_kg, &wheel.hub.center_of_mass_m);
        turning_j += 0.5 * in_hub.dot(&(wheel.hub.inertia_kg_m2 * in_hub));
        for (roller, turning) in wheel.rollers.iter().zip(&wheels[index].rollers) {
            let spin = turning.spin_rad_s(&in_hub);
            add(roller.mass_kg, &roller.center_in_hub_m);
            let carried = in_hub.dot(&roller.axis_in_hub);
            let across = in_hub.norm_squared() - carried * carried;
            turning_j += 0.5 * roller.transverse_inertia_kg_m2 * across;
            turning_j += 0.5 * roller.axial_inertia_kg_m2 * (carried + spin).powi(2);
        }
    }
    sum.kinetic_j += turning_j;
    sum
}
