//! What the rollers of a wheel do to the ground.

use nalgebra::{Vector2, Vector3};

use crate::contact::reaction::{Part, Reaction};
use crate::robot::state::State;
use crate::robot::wheel::WheelBody;

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
    /// Sums up what the reactions of a step did to a wheel.
    ///
    /// They were solved at the poses `before` the step and left the velocities `after` it; both are used here, so that
    /// a contact which was held still reads as still. The work of an impulse is its product with the mean of the
    /// velocities before and after it, which is exact for a body of constant inertia: the powers are such.
    pub(crate) fn read(
        reactions: &[Reaction],
        (index, body): (usize, &WheelBody),
        before: &State,
        after: &State,
        dt_s: f64,
    ) -> Self {
        let floor_from_hub = before.floor_from_hub(index);
        let hub = floor_from_hub.translation.vector;
        let hub_axis = floor_from_hub.rotation * Vector3::z();
        let hub_rate_in_hub = after.hub_rate_at(index, before);
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
        for reaction in reactions {
            let place = match reaction.part {
                Part::Roller(wheel, roller) if wheel == index => roller,
                _ => continue,
            };
            let (pressed, rubbed) = reaction.on_robot_n_s();
            let (normal_n, tangential_n) = (reaction.impulse.x / dt_s, rubbed / dt_s);
            if normal_n <= 0.0 {
                continue;
            }
            let (at, up) = (reaction.at_m, reaction.frame[0]);
            let roller = &body.rollers[place];
            let spin_rad_s = roller.spin_rad_s(&hub_rate_in_hub);
            let roller_axis = floor_from_hub.rotation * roller.axis_in_hub;
            let roller_center =
                floor_from_hub * nalgebra::Point3::from(roller.hub_from_roller.translation.vector);
            let surface = roller_axis.cross(&(at - roller_center.coords));
            let carried_on = carried(after, &at);
            let velocity = carried_on + spin_rad_s * surface;
            let slip = velocity - up * velocity.dot(&up);
            let came = carried(before, &at) + roller.spin_before_rad_s * surface;
            let mean = 0.5 * (came + velocity);

            contact.touching = true;
            contact.normal_force_n += normal_n;
            force += tangential_n;
            sliding += normal_n * slip;
            contact.slip_power_w -= tangential_n.dot(&mean);
            contact.impact_power_w -= pressed.dot(&mean) / dt_s;
            if normal_n > hardest_n {
                hardest_n = normal_n;
                contact.roller = place;
                contact.friction = reaction.friction;
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
        if contact.touching {
            let body_from_floor = before.floor_from_chassis.rotation.inverse();
            contact.force_in_body_n = (body_from_floor * force).xy();
            contact.load_share = hardest_n / contact.normal_force_n;
            contact.sliding_in_body_m_s = (body_from_floor * sliding / contact.normal_force_n).xy();
        }
        contact
    }
}
