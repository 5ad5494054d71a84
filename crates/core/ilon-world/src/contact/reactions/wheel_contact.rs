//! The contact of a wheel's rollers with the ground.

use nalgebra::{Translation3, Vector2, Vector3};

use crate::contact::reactions::reaction::{Part, Reaction};
use crate::loss::Owed;
use crate::robot::state::State;
use crate::robot::wheel::WheelBody;

/// The contact of one wheel with the ground during the last step: the sum over its touching
/// rollers.
///
/// Forces are means over the step, at their places in the middle of the step. Velocities are those
/// at its end. For a split step, forces, sliding and place are means over its parts, and all else
/// is that of the last part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct WheelContact {
    /// Whether any roller pressed on the ground.
    pub touching: bool,
    /// Index of the roller that pressed hardest, among the wheel's rollers; 0 if none touches.
    pub roller: usize,
    /// Contact point on the ground in the body frame, in metres: the mean over the touching rollers
    /// weighted by their normal force.
    pub place_in_body_m: Vector3<f64>,
    /// Normal force of the ground on the wheel, in N.
    pub normal_force_n: f64,
    /// Tangential force of the ground on the wheel, in the body frame's x and y, in N.
    pub force_in_body_n: Vector2<f64>,
    /// Sliding velocity of the rollers' surface over the ground, in the body frame's x and y, in
    /// m/s: the mean over the touching rollers weighted by their normal force.
    pub sliding_in_body_m_s: Vector2<f64>,
    /// Coulomb friction coefficient: the mean over the touching places weighted by their normal
    /// force, so that the force never exceeds it times the load.
    pub friction: f64,
    /// Power that sliding dissipates, in W: the mean over the step, never negative, without
    /// [`WheelContact::spin_up_power_w`].
    pub slip_power_w: f64,
    /// Power needed to bring rollers that have just come down to their spin, in W: the sliding of
    /// an entering roller across its axis, which ends when it rolls.
    pub spin_up_power_w: f64,
    /// Power taken by the normal forces, in W: inelastic impacts and compressed treads, less what
    /// the contacts' springs and the pushing out of rollers return.
    pub impact_power_w: f64,
    /// Number of rollers that press on the ground.
    pub touching_rollers: usize,
    /// The share of the normal force on the roller that pressed hardest: below 1 while several
    /// share the load.
    pub load_share: f64,
    /// Spin of that roller about its axis relative to the hub, in rad/s.
    pub roller_spin_rad_s: f64,
    /// The spin at which that roller would roll without sliding across its axis, in rad/s.
    pub roller_spin_ideal_rad_s: f64,
}

/// Energy taken by a contact in a step, in J, by kind.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Taken {
    pub slip_j: f64,
    pub spin_up_j: f64,
    pub impact_j: f64,
}

impl Taken {
    /// Adds the energy of another contact.
    pub fn add(&mut self, other: &Self) {
        self.slip_j += other.slip_j;
        self.spin_up_j += other.spin_up_j;
        self.impact_j += other.impact_j;
    }

    /// Splits the energy taken by a contact. For a roller that came down without rolling,
    /// `spin_up_left_j` is the energy needed to bring it to its spin, and is used up. `owed` is the
    /// debt of the same body's friction.
    ///
    /// If an impact reverses sliding, only the sum of the impact and its friction is certain, and
    /// is counted as the impact's.
    pub fn of(reaction: &Reaction, spin_up_left_j: &mut f64, owed: &mut Owed) -> Self {
        let [normal_j, along_j, across_j] = reaction.taken_j.into();
        let rubbed_j = along_j + across_j;
        let hit_j = (-rubbed_j).clamp(0.0, normal_j.max(0.0));
        let lost_j = owed.lost_j(rubbed_j + hit_j);
        let spin_up_j = across_j.clamp(0.0, lost_j).min(*spin_up_left_j);
        *spin_up_left_j -= spin_up_j;
        Self {
            slip_j: lost_j - spin_up_j,
            spin_up_j,
            impact_j: normal_j - hit_j,
        }
    }
}

impl WheelContact {
    /// Summarises the effect of the reactions of a step on a wheel of its robot, except for the
    /// powers. The chassis's centre of mass is given in the body frame; `middle` has the poses at
    /// which they acted, `after` is the state at the end of the step.
    pub(crate) fn read<'a>(
        reactions: impl Iterator<Item = &'a Reaction>,
        (index, body): (usize, &WheelBody),
        (center_m, middle, after): (Vector3<f64>, &State, &State),
        dt_s: f64,
    ) -> Self {
        let hub_rate_in_hub = after.hub_rate_in_hub(index);
        // A state refers to the chassis's centre of mass, the body frame to its own origin.
        let body_from_floor = Translation3::from(center_m) * middle.floor_from_chassis().inverse();
        let mut contact = Self::default();
        let mut pressed = None;
        let mut hardest_n = 0.0;
        // Differences of other friction coefficients from the first, times their normal force.
        let mut friction_off_n = 0.0;
        let mut force = Vector3::zeros();
        let mut sliding = Vector3::zeros();
        let mut place = Vector3::zeros();
        for reaction in reactions {
            let roller = match reaction.a.part {
                Part::Roller(wheel, roller) if wheel == index => roller,
                _ => continue,
            };
            let normal_n = reaction.impulse.x / dt_s;
            if normal_n <= 0.0 {
                continue;
            }
            // One roller may press in several places: its reactions are consecutive.
            let last = pressed.replace(roller);
            contact.touching_rollers += usize::from(last != Some(roller));
            if !contact.touching {
                contact.friction = reaction.friction;
            }
            friction_off_n += normal_n * (reaction.friction - contact.friction);
            contact.touching = true;
            contact.normal_force_n += normal_n;
            force += reaction.friction_impulse_n_s() / dt_s;
            sliding += normal_n * reaction.sliding_m_s();
            place += normal_n * reaction.at_m;
            if normal_n > hardest_n {
                hardest_n = normal_n;
                contact.roller = roller;
                let spin_rad_s = body.rollers[roller].spin_rad_s(&hub_rate_in_hub);
                contact.roller_spin_rad_s = spin_rad_s;
                // Across the axis the surface slides by the radius for every rad/s of excess spin.
                let radius_m = reaction.rolling_radius_m;
                contact.roller_spin_ideal_rad_s = if radius_m == 0.0 {
                    spin_rad_s
                } else {
                    spin_rad_s - reaction.velocity_after.z / radius_m
                };
            }
        }
        if contact.touching {
            let total_n = contact.normal_force_n;
            contact.friction += friction_off_n / total_n;
            contact.place_in_body_m =
                (body_from_floor * nalgebra::Point3::from(place / total_n)).coords;
            contact.force_in_body_n = (body_from_floor.rotation * force).xy();
            contact.load_share = hardest_n / total_n;
            contact.sliding_in_body_m_s = (body_from_floor.rotation * sliding / total_n).xy();
        }
        contact
    }
}
