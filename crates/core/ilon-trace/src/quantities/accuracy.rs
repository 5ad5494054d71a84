//! The stated accuracy of figures at the automatic step (`docs/measured.md`).

use super::quantity::{Accuracy, Measure, Quantity};
use super::{all, by_key, si_unit};
use crate::header::Header;
use crate::metrics::Summary;

/// The stated accuracy of a figure by its key; `None` if there is none.
pub fn accuracy(key: &str) -> Option<Accuracy> {
    by_key(key)?.accuracy
}

/// The quantities with a stated accuracy, in the order of [`all`].
pub fn stated() -> impl Iterator<Item = (&'static Quantity, Accuracy)> {
    all().filter_map(|quantity| Some((quantity, quantity.accuracy?)))
}

/// The quantities that are compared between a run and its twins, in the order of [`all`].
pub fn compared() -> impl Iterator<Item = &'static Quantity> {
    all().filter(|quantity| quantity.is_compared)
}

/// The references of a run's accuracies.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales {
    way_m: f64,
    arm_m: f64,
    /// Energy turned over by motors, pushes and losses, in J.
    turned_over_j: f64,
    /// The robot's weight times the radius of its largest wheel, in N m.
    weight_n_m: f64,
    /// Speed of a fall from that wheel's radius, in m/s.
    fall_m_s: f64,
}

/// Relative to the robot's scales: smaller differences are rounding, or meaningless. Chosen.
const LEAST: f64 = 1e-4;
/// Relative to the energy turned over: the accuracy of the energy balance. Chosen.
const LEAST_OF_ENERGY: f64 = 1e-3;
/// For shares and ratios, and relative to a wheel's fall. Chosen.
const LEAST_SHARE: f64 = 1e-3;
/// Gravity on earth, in m/s^2.
const GRAVITY_M_S2: f64 = 9.81;

impl Scales {
    /// The scales of a run.
    pub fn of(summary: &Summary, header: &Header) -> Self {
        let radii = header.wheels.iter().map(|wheel| wheel.radius_m);
        let radius_m = radii.fold(0.0, f64::max);
        let arm_m = header.arm_m();
        let energy = &summary.energy;
        let joules = |part: Option<f64>| part.unwrap_or(0.0);
        let lost_j = [
            energy.slip_j,
            energy.spin_up_j,
            energy.bearing_j,
            energy.impact_j,
        ];
        let lost_j: f64 = lost_j.map(joules).iter().sum();
        let given_j = joules(energy.motor_j) + joules(energy.outside_j);
        Self {
            way_m: (summary.travelled_m.max(arm_m * summary.turned_rad)).max(arm_m),
            arm_m,
            turned_over_j: given_j.max(lost_j),
            weight_n_m: header.mass_kg * GRAVITY_M_S2 * radius_m,
            fall_m_s: (GRAVITY_M_S2 * radius_m).sqrt(),
        }
    }

    /// The reference of a figure with this value, in its SI unit.
    pub fn measure(&self, of: Measure, value: f64) -> f64 {
        match of {
            Measure::Itself => value.abs(),
            Measure::Way => self.way_m,
            Measure::Turn => self.way_m / self.arm_m.max(f64::MIN_POSITIVE),
        }
    }

    /// The resolution of a figure, in its SI unit: smaller changes do not count.
    pub fn floor(&self, quantity: &Quantity) -> f64 {
        match si_unit(quantity.key) {
            "m" => LEAST * self.arm_m,
            "rad" => LEAST,
            "N m" => LEAST * self.weight_n_m,
            "J" => (LEAST * self.weight_n_m).max(LEAST_OF_ENERGY * self.turned_over_j),
            "m/s" => LEAST_SHARE * self.fall_m_s,
            _ => LEAST_SHARE,
        }
    }
}

/// How far a figure with this value is known, in its SI unit: its stated accuracy, and at least its
/// resolution.
pub fn known_to(quantity: &Quantity, value: f64, summary: &Summary, header: &Header) -> f64 {
    let scales = Scales::of(summary, header);
    let stated = (quantity.accuracy).map(|it| it.share * scales.measure(it.of, value));
    stated.unwrap_or(0.0).max(scales.floor(quantity))
}

/// The smallest change of a quantity that is one: ten of its last shown digit, in SI units; 0 of
/// one that counts. A smaller margin makes a bound brittle.
pub fn least_change(quantity: &Quantity) -> f64 {
    let digits = i32::try_from(quantity.decimals).unwrap_or(0);
    if digits == 0 {
        return 0.0;
    }
    10f64.powi(1 - digits) / quantity.unit.per_si
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::header::WheelHeader;

    /// Among robots alike but in size speeds grow as the root of lengths, as those of falls do: the
    /// scale is the root of a radius times g.
    #[test]
    fn a_speed_is_resolved_to_a_share_of_that_of_a_fall() {
        let speed = by_key("slip_speed_rms_m_s").expect("a speed");
        let floor_of = |radius_m: f64| {
            let wheel = WheelHeader {
                radius_m,
                ..WheelHeader::default()
            };
            let header = Header {
                wheels: vec![wheel],
                ..Header::default()
            };
            Scales::of(&Summary::default(), &header).floor(speed)
        };
        // Rounding.
        assert!((floor_of(0.4) / floor_of(0.1) - 2.0).abs() < 1e-14);
        assert!((floor_of(0.1) / LEAST_SHARE - (0.1 * GRAVITY_M_S2).sqrt()).abs() < 1e-14);
    }

    #[test]
    fn what_an_accuracy_is_stated_of_fits_its_unit() {
        for (Quantity { key, .. }, accuracy) in stated() {
            match accuracy.of {
                Measure::Way => assert_eq!(si_unit(key), "m", "{key}"),
                Measure::Turn => assert_eq!(si_unit(key), "rad", "{key}"),
                Measure::Itself => {}
            }
        }
        // Guards against a comparison that is empty.
        assert!(stated().count() > 20 && all().count() > stated().count());
        assert!(stated().all(|(quantity, _)| quantity.is_compared));
    }
}
