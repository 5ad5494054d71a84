//! The ranges of a description's numbers.

use ilon_files::toml::leaves;
use serde::Serialize;
use toml::{Table, Value};

use crate::error::Fault;

/// Whether a range has a number.
type Holds = fn(f64) -> bool;

/// Each range in words, with the keys that have it: the last part of a key, or the first and the last.
const RANGES: [(Holds, &str, &str); 7] = [
    (
        |number| number > 0.0,
        "a finite number above 0",
        "mass_kg hub_mass_kg roller_mass_kg fork_mass_kg size_m height_m radius_m roller_radius_m hub_radius_m \
         hub_width_m width_m casters.trail_m length_factor motor_effort_n_m motor_velocity_rad_s effort_n_m \
         velocity_rad_s gear_ratio gear_efficiency limit_deg travel_deg travel_m stiffness_n_m shear_stiffness_n_m \
         stiffness_n_m_rad relaxation_length_m",
    ),
    (
        |number| number >= 0.0,
        "a finite number, 0 or above",
        "damping_n_m_s damping_n_s_m damping_n_m_s_rad shear_damping_n_s_m friction_n friction_n_m gear_friction_n_m \
         preload_n preload_n_m rotor_inertia_kg_m2 rolling_resistance row_spacing_m axial_play_m axle_friction \
         axle_radius_m",
    ),
    // Millimetres written as metres are a thousand times too large.
    (
        |length_m| length_m < 5.0,
        "a length in metres, below 5: 50 mm are 0.05",
        "wheel.radius_m rollers.radius_m tyres.radius_m wheels.radius_m casters.radius_m overrides.radius_m \
         roller_radius_m hub_radius_m hub_width_m width_m casters.trail_m",
    ),
    // An arm behind its wheel has a negative length.
    (
        |length_m| length_m != 0.0,
        "a finite number other than 0",
        "suspension.length_m",
    ),
    (
        |angle_deg| angle_deg < 90.0,
        "above 0 and below 90 degrees",
        "suspension.limit_deg suspension.travel_deg",
    ),
    (
        |share| share <= 1.0,
        "above 0 and at most 1",
        "gear_efficiency",
    ),
    (f64::is_finite, "a finite number", ANY),
];

/// All keys.
const ANY: &str = "";

pub(super) fn out_of_range(key: &str, value: impl ToString, range: &'static str) -> Fault {
    Fault::OutOfRange {
        key: key.to_owned(),
        value: value.to_string(),
        range,
    }
}

/// The numbers of a description that are out of their ranges, by their keys.
pub(super) fn faults(spec: &impl Serialize) -> Vec<Fault> {
    // TOML holds all but counts of rollers beyond 2^63, which have a rule of their own.
    let table = Table::try_from(spec).unwrap_or_default();
    let values = leaves(&table).into_iter();
    values
        .filter_map(|(key, value)| fault(&key, &value))
        .collect()
}

fn fault(key: &str, value: &Value) -> Option<Fault> {
    let number = value.as_float()?;
    let is_name = |part: &&str| part.parse::<usize>().is_err();
    let (first, last) = (key.split('.').next()?, key.rsplit('.').find(is_name)?);
    let both = format!("{first}.{last}");
    let is_meant =
        |keys: &str| keys == ANY || keys.split(' ').any(|known| known == last || known == both);
    let mut ranges = RANGES.iter();
    let broken = ranges.find(|(holds, _, keys)| is_meant(keys) && !holds(number));
    broken.map(|(_, range, _)| out_of_range(key, number, range))
}

#[cfg(test)]
mod tests {
    use super::super::{Spec, SpecOnTyres};
    use super::*;

    /// A range of a key that no description has would hold nothing.
    #[test]
    fn each_range_is_that_of_a_key_of_descriptions() {
        let schemas = [Spec::json_schema(), SpecOnTyres::json_schema()].map(|of| of.to_string());
        for (_, _, keys) in RANGES.iter().filter(|(_, _, keys)| *keys != ANY) {
            for part in keys.split([' ', '.']) {
                let property = format!("\"{part}\":{{");
                let is_there = schemas.iter().any(|schema| schema.contains(&property));
                assert!(is_there, "{part}");
            }
        }
    }

    /// Specs that are built in code may have numbers that no file can have.
    #[test]
    fn what_is_no_finite_number_is_refused_whatever_the_key() {
        let mut table = Table::new();
        let places = vec![Value::Float(0.0), Value::Float(f64::NAN)];
        table.insert("axles_m".to_owned(), Value::Array(places));
        table.insert("mass_kg".to_owned(), Value::Float(f64::NAN));
        table.insert("friction_n".to_owned(), Value::Float(f64::INFINITY));
        let keys = faults(&table).into_iter();
        let keys: Vec<_> = keys
            .filter_map(|fault| fault.key().map(str::to_owned))
            .collect();
        assert_eq!(keys, ["axles_m.1", "friction_n", "mass_kg"]);
    }
}
