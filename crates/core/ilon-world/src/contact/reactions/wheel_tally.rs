//! Sums and extremes of a wheel over time.

use nalgebra::Vector2;
use smart_default::SmartDefault;

use crate::contact::reactions::wheel_contact::WheelContact;

/// Sums and extremes of a wheel, its motor and its contact over a physics step, or over several.
///
/// Means are impulses over time, so that the forces of all wheels add up to the robot's
/// acceleration. Extremes of load, torque and height are over whole physics steps; those of sliding
/// and grip also over the parts of a split step, because rollers stick and slide within it.
#[derive(Clone, Copy, Debug, SmartDefault, PartialEq)]
pub struct WheelTally {
    /// The total time, in seconds.
    time_s: f64,
    /// The part of it in which any roller touched, in seconds.
    touching_s: f64,
    torque_n_m_s: f64,
    normal_n_s: f64,
    force_n_s: Vector2<f64>,
    /// Places, weighted by the normal impulse.
    place_n_m_s: Vector2<f64>,
    /// The first friction coefficient, and the differences of others from it weighted by the normal
    /// impulse: if it is constant, the mean equals it to the last bit.
    friction: f64,
    friction_off_n_s: f64,
    slid_m: Vector2<f64>,
    slid_m2_s: f64,
    /// Smallest and largest motor torque, in N m.
    #[default(NONE)]
    pub torque_n_m: [f64; 2],
    /// Smallest and largest normal force, in N.
    #[default(NONE)]
    pub normal_force_n: [f64; 2],
    /// Smallest and largest height of the wheel's centre above the floor's plane, in metres.
    #[default(NONE)]
    pub hub_height_m: [f64; 2],
    /// Largest sliding speed, in m/s.
    pub sliding_max_m_s: f64,
    /// Largest utilisation of the friction limit: tangential force over mu N, 1 on the edge of the
    /// friction cone.
    pub friction_used_max: f64,
}

/// No values: the minimum is above and the maximum below all numbers.
const NONE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// The union of two ranges.
fn around([low, high]: [f64; 2], [other_low, other_high]: [f64; 2]) -> [f64; 2] {
    [low.min(other_low), high.max(other_high)]
}

impl WheelTally {
    /// Adds a part of a step: the contact in it, and the motor's torque in N m.
    pub(crate) fn add_part(&mut self, contact: &WheelContact, torque_n_m: f64, dt_s: f64) {
        self.time_s += dt_s;
        self.torque_n_m_s += torque_n_m * dt_s;
        if !contact.touching {
            return;
        }
        let normal_n_s = contact.normal_force_n * dt_s;
        let sliding_m_s = contact.sliding_in_body_m_s;
        self.count_friction(contact.friction, 0.0, normal_n_s);
        self.touching_s += dt_s;
        self.normal_n_s += normal_n_s;
        self.force_n_s += contact.force_in_body_n * dt_s;
        self.place_n_m_s += contact.place_in_body_m.xy() * normal_n_s;
        self.slid_m += sliding_m_s * dt_s;
        self.slid_m2_s += sliding_m_s.norm_squared() * dt_s;
        self.sliding_max_m_s = self.sliding_max_m_s.max(sliding_m_s.norm());
        let limit_n = contact.friction * contact.normal_force_n;
        if limit_n > 0.0 {
            let used = contact.force_in_body_n.norm() / limit_n;
            self.friction_used_max = self.friction_used_max.max(used);
        }
    }

    /// Counts a friction coefficient, and the known difference from it, under a normal impulse,
    /// before that impulse itself is counted.
    fn count_friction(&mut self, friction: f64, off_n_s: f64, normal_n_s: f64) {
        if self.normal_n_s <= 0.0 {
            self.friction = friction;
        }
        self.friction_off_n_s += off_n_s + (friction - self.friction) * normal_n_s;
    }

    /// Ends a step whose parts were added, with the height of the wheel's centre at its end, in
    /// metres.
    pub(crate) fn end_step(&mut self, hub_height_m: f64) {
        self.torque_n_m = [self.torque_mean_n_m(); 2];
        self.normal_force_n = [self.normal_force_mean_n(); 2];
        self.hub_height_m = [hub_height_m; 2];
    }

    /// Writes the means over a step of several parts into its contact.
    pub(crate) fn put_means_into(&self, contact: &mut WheelContact) {
        let place_m = self.place_mean_in_body_m();
        (contact.place_in_body_m.x, contact.place_in_body_m.y) = (place_m.x, place_m.y);
        contact.normal_force_n = self.normal_force_mean_n();
        contact.force_in_body_n = self.force_mean_in_body_n();
        contact.sliding_in_body_m_s = self.sliding_mean_in_body_m_s();
    }

    /// Adds a later tally.
    pub fn add(&mut self, after: &Self) {
        self.count_friction(after.friction, after.friction_off_n_s, after.normal_n_s);
        self.time_s += after.time_s;
        self.touching_s += after.touching_s;
        self.torque_n_m_s += after.torque_n_m_s;
        self.normal_n_s += after.normal_n_s;
        self.force_n_s += after.force_n_s;
        self.place_n_m_s += after.place_n_m_s;
        self.slid_m += after.slid_m;
        self.slid_m2_s += after.slid_m2_s;
        self.torque_n_m = around(self.torque_n_m, after.torque_n_m);
        self.normal_force_n = around(self.normal_force_n, after.normal_force_n);
        self.hub_height_m = around(self.hub_height_m, after.hub_height_m);
        self.sliding_max_m_s = self.sliding_max_m_s.max(after.sliding_max_m_s);
        self.friction_used_max = self.friction_used_max.max(after.friction_used_max);
    }

    /// The total time, in seconds.
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// The share of the time in which any roller touched, in [0, 1]; 0 without time.
    pub fn touching_share(&self) -> f64 {
        over(self.touching_s, self.time_s)
    }

    /// Mean torque of the motor on the wheel, in N m.
    pub fn torque_mean_n_m(&self) -> f64 {
        over(self.torque_n_m_s, self.time_s)
    }

    /// Mean normal force of the ground on the wheel over the whole time, in N.
    pub fn normal_force_mean_n(&self) -> f64 {
        over(self.normal_n_s, self.time_s)
    }

    /// Mean tangential force of the ground on the wheel over the whole time, in the body frame's x
    /// and y, in N.
    pub fn force_mean_in_body_n(&self) -> Vector2<f64> {
        self.force_n_s.map(|n_s| over(n_s, self.time_s))
    }

    /// Contact point in the body frame's x and y, in metres: the mean weighted by the normal force.
    pub fn place_mean_in_body_m(&self) -> Vector2<f64> {
        self.place_n_m_s.map(|n_m_s| over(n_m_s, self.normal_n_s))
    }

    /// Coulomb friction coefficient: the mean weighted by the normal force.
    pub fn friction_mean(&self) -> f64 {
        self.friction + over(self.friction_off_n_s, self.normal_n_s)
    }

    /// Mean sliding velocity of the rollers' surface over the ground in contact, in the body
    /// frame's x and y, in m/s.
    pub fn sliding_mean_in_body_m_s(&self) -> Vector2<f64> {
        self.slid_m.map(|m| over(m, self.touching_s))
    }

    /// Root mean square of the sliding speed in contact, in m/s.
    pub fn sliding_rms_m_s(&self) -> f64 {
        over(self.slid_m2_s, self.touching_s).sqrt()
    }
}

/// A quotient; 0 for zero over zero.
fn over(sum: f64, weight: f64) -> f64 {
    if weight > 0.0 { sum / weight } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn contact(normal_force_n: f64, force_n: f64, sliding_m_s: f64) -> WheelContact {
        WheelContact {
            touching: normal_force_n > 0.0,
            normal_force_n,
            force_in_body_n: Vector2::new(0.0, force_n),
            place_in_body_m: Vector3::new(0.01 * normal_force_n, 0.2, 0.0),
            sliding_in_body_m_s: Vector2::new(sliding_m_s, 0.0),
            friction: 0.5,
            ..WheelContact::default()
        }
    }

    /// Two steps: one of two parts, 10 and 30 N, and one in the air. By hand.
    #[test]
    fn means_are_over_time_and_extremes_over_steps() {
        let mut first = WheelTally::default();
        first.add_part(&contact(10.0, 2.0, 0.0), 1.0, 0.25);
        first.add_part(&contact(30.0, 15.0, 0.5), 3.0, 0.25);
        first.end_step(0.05);
        let mut second = WheelTally::default();
        second.add_part(&contact(0.0, 0.0, 0.0), -1.0, 0.5);
        second.end_step(0.0625);
        let mut sum = WheelTally::default();
        sum.add(&first);
        sum.add(&second);
        assert_eq!((sum.time_s(), sum.touching_share()), (1.0, 0.5));
        assert_eq!(sum.torque_mean_n_m(), 0.5);
        assert_eq!(sum.torque_n_m, [-1.0, 2.0]);
        assert_eq!(sum.normal_force_mean_n(), 10.0);
        assert_eq!(sum.normal_force_n, [0.0, 20.0]);
        assert_eq!(sum.hub_height_m, [0.05, 0.0625]);
        assert_eq!(sum.force_mean_in_body_n(), Vector2::new(0.0, 4.25));
        // 10 N at 0.1 m and 30 N at 0.3 m.
        assert_eq!(sum.place_mean_in_body_m(), Vector2::new(0.25, 0.2));
        assert_eq!(sum.friction_mean(), 0.5);
        assert_eq!(sum.sliding_mean_in_body_m_s(), Vector2::new(0.25, 0.0));
        assert_eq!(sum.sliding_rms_m_s(), 0.125_f64.sqrt());
        assert_eq!((sum.sliding_max_m_s, sum.friction_used_max), (0.5, 1.0));
    }

    /// 10 N on a friction of 0.25 and 30 N on one of 0.75: 0.625, in one step or in two.
    #[test]
    fn the_mean_friction_is_weighted_by_load() {
        let [mut one, mut first, mut second] = [WheelTally::default(); 3];
        for (tally, friction, normal_n) in [(&mut first, 0.25, 10.0), (&mut second, 0.75, 30.0)] {
            let contact = WheelContact {
                friction,
                ..contact(normal_n, 0.0, 0.0)
            };
            one.add_part(&contact, 0.0, 0.25);
            tally.add_part(&contact, 0.0, 0.25);
        }
        first.add(&second);
        assert_eq!([one.friction_mean(), first.friction_mean()], [0.625; 2]);
    }

    #[test]
    fn of_no_time_all_is_zero() {
        let none = WheelTally::default();
        assert_eq!((none.touching_share(), none.torque_mean_n_m()), (0.0, 0.0));
        assert_eq!(none.place_mean_in_body_m(), Vector2::zeros());
        assert_eq!(none.sliding_rms_m_s(), 0.0);
    }
}
