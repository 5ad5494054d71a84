//! The energy balance of a run, and the energy turned over in it.
//!
//! motor + outside = stored + slip + spin-up + bearing + impact + unexplained,
//!
//! each as its gain from the first row to the last. The unexplained part is judged relative to the
//! energy turned over. When a robot drives and brakes again, the energy put in and taken back
//! nearly cancels in the sums above, so energy put in and energy taken out are counted separately:
//!
//! - put in = motors while they drive + pushes and payloads while they do work + the deepest fall,
//! - taken out = motors while they brake + pushes and payloads while they take work + all losses +
//!   the gain of kinetic and potential energy.
//!
//! If the balance closes, the two are equal, except for a rise before a fall. The fall is the
//! largest drop of the potential energy below an earlier value, so that a hub that rises and falls
//! with each roller counts once.

use crate::fold::finite;
use crate::header::Header;
use crate::metrics::Energy;
use crate::record::Record;

/// Below the energy that lifts the robot by this share of its largest wheel's radius, nothing
/// moved: 50 nm of a wheel of 50 mm, the deflection of contacts as a robot settles. Chosen.
const LEAST_LIFT: f64 = 1e-6;

/// The weight of a mass at rest on the ground, in N/kg.
const GRAVITY_M_S2: f64 = 9.81;

/// The balance, accumulated row by row.
#[derive(Default)]
pub(crate) struct Balance {
    first: Option<Record>,
    last: Option<Record>,
    /// Energy from outside, and energy returned, in J, both positive.
    outside_in_j: f64,
    outside_out_j: f64,
    /// The highest potential energy so far, and the largest later drop below it, in J.
    highest_j: f64,
    fall_j: f64,
}

impl Balance {
    /// Adds the next row.
    pub fn add(&mut self, record: &Record) {
        let before = *self.last.get_or_insert(*record);
        if self.first.is_none() {
            self.first = Some(*record);
            self.highest_j = record.potential_energy_j;
        }
        let came_j = record.outside_energy_j - before.outside_energy_j;
        self.outside_in_j += came_j.max(0.0);
        self.outside_out_j += (-came_j).max(0.0);
        self.highest_j = self.highest_j.max(record.potential_energy_j);
        self.fall_j = (self.highest_j - record.potential_energy_j).max(self.fall_j);
        self.last = Some(*record);
    }

    /// The balance between the first and the last row.
    pub fn finish(&self, header: &Header) -> Energy {
        let (Some(first), Some(last)) = (&self.first, &self.last) else {
            return Energy::default();
        };
        let gain = |f: fn(&Record) -> f64| f(last) - f(first);
        let motor_j = gain(|r| r.motor_energy_j);
        // Zero in traces recorded before this sum existed.
        let drove_j = gain(|r| r.motor_positive_energy_j).max(motor_j);
        let outside_j = gain(|r| r.outside_energy_j);
        let stored_j = gain(|r| r.kinetic_energy_j + r.potential_energy_j);
        let slip_j = gain(|r| r.slip_energy_j);
        let spin_up_j = gain(|r| r.spin_up_energy_j);
        let bearing_j = gain(|r| r.bearing_energy_j);
        let impact_j = gain(|r| r.impact_energy_j);
        let losses_j = [slip_j, spin_up_j, bearing_j, impact_j];
        let unexplained_j = motor_j + outside_j - stored_j - losses_j.iter().sum::<f64>();
        let put_in_j = drove_j + self.outside_in_j + self.fall_j;
        let taken_out_j = (drove_j - motor_j)
            + self.outside_out_j
            + losses_j.iter().map(|loss_j| loss_j.abs()).sum::<f64>()
            + stored_j.max(0.0);
        let turned_over_j = put_in_j.max(taken_out_j);
        Energy {
            motor_j: finite(motor_j),
            motor_positive_j: finite(drove_j),
            outside_j: finite(outside_j),
            put_in_j: finite(put_in_j),
            outside_positive_j: finite(self.outside_in_j),
            fall_j: finite(self.fall_j),
            stored_j: finite(stored_j),
            slip_j: finite(slip_j),
            spin_up_j: finite(spin_up_j),
            bearing_j: finite(bearing_j),
            impact_j: finite(impact_j),
            unexplained_j: finite(unexplained_j),
            unexplained_share: finite(unexplained_j / turned_over_j)
                .filter(|_| turned_over_j >= least_turned_over_j(header)),
        }
    }
}

/// The energy turned over from which on the robot counts as moved, in J.
fn least_turned_over_j(header: &Header) -> f64 {
    let radii = header.wheels.iter().map(|wheel| wheel.radius_m);
    LEAST_LIFT * header.mass_kg * GRAVITY_M_S2 * radii.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(rows: &[Record]) -> Energy {
        let mut balance = Balance::default();
        rows.iter().for_each(|row| balance.add(row));
        balance.finish(&Header::default())
    }

    /// A robot slides to rest: its 10 J of motion are lost, and all that is turned over is that.
    #[test]
    fn energy_that_was_stored_and_is_lost_is_turned_over() {
        let moving = Record {
            kinetic_energy_j: 10.0,
            ..Record::default()
        };
        let stands = Record {
            slip_energy_j: 10.0,
            ..Record::default()
        };
        let energy = of(&[moving, stands]);
        assert_eq!(energy.stored_j, Some(-10.0));
        assert_eq!(energy.unexplained_share, Some(0.0));
    }

    /// Heights count from the first row, also below the world's origin.
    #[test]
    fn a_fall_is_from_where_the_robot_was() {
        let at = |potential_energy_j| Record {
            potential_energy_j,
            ..Record::default()
        };
        assert_eq!(of(&[at(-5.0), at(-5.0)]).fall_j, Some(0.0));
        assert_eq!(of(&[at(-5.0), at(-4.0), at(-7.0)]).fall_j, Some(3.0));
    }
}
