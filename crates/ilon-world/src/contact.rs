//! What the rollers of a wheel do to the ground.

use nalgebra::{Isometry3, Vector2, Vector3};
use rapier3d::prelude::*;

use crate::convert;
use crate::state::State;
use crate::wheel_body::WheelBody;

/// The contact of one wheel with the ground during the last step: the sum over its touching rollers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelContact {
    /// Whether any roller pressed on the ground.
    pub touching: bool,
    /// The roller that pressed hardest, as an index into the wheel's rollers.
    pub roller: usize,
    /// Normal force of the ground on the wheel, in N.
    pub normal_force_n: f64,
    /// Tangential force of the ground on the wheel, in the body frame's x and y, in N.
    pub force_in_body_n: Vector2<f64>,
    /// Sliding velocity of the rollers' surface over the ground, in the body frame's x and y, in m/s: the mean over
    /// the touching rollers weighted by their normal force.
    pub sliding_in_body_m_s: Vector2<f64>,
    /// Coulomb friction coefficient under the roller that pressed hardest.
    pub friction: f64,
    /// Power that sliding turns into heat, in W: the mean over the step, so that it holds what it takes to bring an
    /// entering roller up to its spin.
    pub slip_power_w: f64,
    /// Power that the normal forces take, in W: hits that do not bounce, less what pushing rollers out of the ground
    /// gives back.
    pub impact_power_w: f64,
    /// The share of the normal force that the roller which pressed hardest carries: below 1 while two rollers hand over.
    pub load_share: f64,
    /// Spin of that roller about its axis against the hub, in rad/s.
    pub roller_spin_rad_s: f64,
    /// The spin at which that roller would roll without sliding across its axis, in rad/s.
    pub roller_spin_ideal_rad_s: f64,
}

impl WheelContact {
    /// Reads a wheel's contacts out of rapier's narrow phase.
    ///
    /// The solver worked at the poses `before` the step and left the velocities `after` it; both are used here, so
    /// that a contact which the solver held still reads as still. The work of an impulse is its product with the mean
    /// of the velocities before and after it, which is exact for a body of constant inertia: the powers are such.
    /// `rate_of` gives the rate of a degree of freedom of the robot's multibody, in rad/s.
    pub(crate) fn read(
        rapier: &PhysicsWorld,
        floor_from_rapier: &Isometry3<f64>,
        (index, body): (usize, &WheelBody),
        before: &State,
        after: &State,
        dt_s: f64,
        rate_of: impl Fn(usize) -> f64,
    ) -> Self {
        let floor_from_hub = before.floor_from_hub(index);
        let hub = floor_from_hub.translation.vector;
        let hub_axis = floor_from_hub.rotation * Vector3::z();
        let center = before.floor_from_chassis.translation.vector;
        // Velocity of a point of the hub as the poses were before the step, with the rates of a state.
        let carried = |state: &State, at: &Vector3<f64>| {
            let angular = state.angular_rad_s + hub_axis * state.wheel_rates_rad_s[index];
            let of_hub = state.velocity_m_s + state.angular_rad_s.cross(&(hub - center));
            of_hub + angular.cross(&(at - hub))
        };

        let mut contact = WheelContact::default();
        let mut hardest_n = 0.0;
        let mut force = Vector3::zeros();
        let mut sliding = Vector3::zeros();
        for slot in &body.slots {
            let roller = &body.rollers[slot.roller];
            let spin_rad_s = rate_of(slot.dof);
            let roller_axis = floor_from_hub.rotation * roller.axis_in_hub();
            let roller_center =
                floor_from_hub * nalgebra::Point3::from(roller.hub_from_roller.translation.vector);
            for pair in rapier.narrow_phase.contact_pairs_with(slot.collider) {
                let slot_is_first = pair.collider1 == slot.collider;
                let ground = if slot_is_first {
                    pair.collider2
                } else {
                    pair.collider1
                };
                let rapier_from_ground = *rapier.colliders[ground].position();
                for manifold in pair.manifolds() {
                    for point in &manifold.points {
                        let normal_n = f64::from(point.data.impulse) / dt_s;
                        if normal_n <= 0.0 {
                            continue;
                        }
                        // Impulses are given on the first collider of the pair; ours is wanted.
                        let sign = if slot_is_first { 1.0 } else { -1.0 };
                        let turned = floor_from_rapier.rotation;
                        let up = turned * (-sign * convert::to_f64(manifold.data.normal));
                        let tangent_impulse = convert::to_f64(point.data.warmstart_tangent_world);
                        let tangential_n = turned * (sign / dt_s * tangent_impulse);
                        let on_ground = if slot_is_first {
                            point.local_p2
                        } else {
                            point.local_p1
                        };
                        let in_rapier = convert::to_f64(rapier_from_ground * on_ground);
                        let at = (floor_from_rapier * nalgebra::Point3::from(in_rapier)).coords;

                        let lever = at - roller_center.coords;
                        let surface = roller_axis.cross(&lever);
                        let carried_on = carried(after, &at);
                        let velocity = carried_on + spin_rad_s * surface;
                        let slip = velocity - up * velocity.dot(&up);
                        let came = carried(before, &at) + slot.spin_before_rad_s * surface;
                        let mean = 0.5 * (came + velocity);

                        contact.touching = true;
                        contact.normal_force_n += normal_n;
                        force += tangential_n;
                        sliding += normal_n * slip;
                        contact.slip_power_w -= tangential_n.dot(&mean);
                        contact.impact_power_w -= normal_n * up.dot(&mean);
                        if normal_n > hardest_n {
                            hardest_n = normal_n;
                            contact.roller = slot.roller;
                            contact.friction = f64::from(manifold.data.friction);
                            contact.roller_spin_rad_s = spin_rad_s;
                            // No sliding along the surface's own direction: (carried + spin surface) . surface = 0.
                            let tangent = surface - up * surface.dot(&up);
                            let reach = tangent.norm_squared();
                            contact.roller_spin_ideal_rad_s = if reach > 0.0 {
                                -carried_on.dot(&tangent) / reach
                            } else {
                                0.0
                            };
                        }
                    }
                }
            }
        }
        if contact.touching {
            let body_from_floor = before.floor_from_chassis.rotation.inverse();
            contact.force_in_body_n = (body_from_floor * force).xy();
            contact.load_share = hardest_n / contact.normal_force_n;
            contact.sliding_in_body_m_s = (body_from_floor * sliding / contact.normal_force_n).xy();
        }
        contact
    }
}
