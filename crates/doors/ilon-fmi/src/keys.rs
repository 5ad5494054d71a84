//! Keys of a scenario as FMI parameters: every number that describes robot, world and sensors.

use ilon_sim::scenario::Setting;
use ilon_sim::{Error, Scenario};
use toml::Value as Toml;

use crate::value::Value;

/// Sections whose numbers are parameters. What moves the robot in the scenario, and its
/// expectations, have no effect in an FMU.
const SECTIONS: [&str; 8] = [
    "robot",
    "world",
    "wheel_loop",
    "motors",
    "rollers",
    "materials",
    "sensors",
    "faults",
];

/// A numeric key of the scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Its dotted path, as in a setting: `faults.0.push.from_s`.
    pub path: String,
    /// The path in FMI's structured naming: `scenario.faults[1].push.from_s`.
    pub name: String,
    /// The value in the scenario.
    pub value: Value,
}

/// The units by the ends of keys, with the longer of two that fit first.
const UNITS: [(&str, &str); 22] = [
    ("stiffness_n_m", "N/m"),
    ("_n_m_s_rad", "N.m.s/rad"),
    ("_n_m_rad", "N.m/rad"),
    ("_n_m_s2", "N.m.s2"),
    ("_n_m_s", "N.m.s"),
    ("_n_s_m", "N.s/m"),
    ("_n_s", "N.s"),
    ("_n_m", "N.m"),
    ("_kg_m2", "kg.m2"),
    ("_kg_m3", "kg/m3"),
    ("_m_s2", "m/s2"),
    ("_rad_s", "rad/s"),
    ("_deg_s", "deg/s"),
    ("_m_s", "m/s"),
    ("_per_s", "Hz"),
    ("_hz", "Hz"),
    ("_rad", "rad"),
    ("_deg", "deg"),
    ("_kg", "kg"),
    ("_n", "N"),
    ("_m", "m"),
    ("_s", "s"),
];

impl Key {
    /// Its unit, by the end of the key; `None` for shares, counts, and whole numbers, to which FMI
    /// gives no unit.
    pub fn unit(&self) -> Option<&'static str> {
        // A list's entries are in the unit of its key.
        let is_place = |part: &&str| part.parse::<usize>().is_ok();
        let key = self.path.rsplit('.').find(|part| !is_place(part))?;
        let found = UNITS.iter().find(|(end, _)| key.ends_with(end));
        (found.filter(|_| matches!(self.value, Value::Real(_)))).map(|(_, unit)| *unit)
    }

    /// The setting that gives it another value.
    pub fn setting(&self, value: Value) -> Setting {
        let value = match value {
            Value::Real(number) => Toml::Float(number),
            Value::Whole(number) => Toml::Integer(number),
            Value::Flag(flag) => Toml::Boolean(flag),
        };
        Setting::new(&*self.path, &value)
    }
}

/// The parameters of a scenario, in the order of its text.
///
/// # Errors
/// [`Error::Encode`] if it cannot be written as text.
pub fn keys(scenario: &Scenario) -> Result<Vec<Key>, Error> {
    let whole = Toml::try_from(scenario).map_err(|fault| Error::encode("the scenario", &fault))?;
    let mut keys = Vec::new();
    for section in SECTIONS {
        if let Some(value) = whole.get(section) {
            gather(
                section.to_owned(),
                format!("scenario.{section}"),
                value,
                &mut keys,
            );
        }
    }
    Ok(keys)
}

fn gather(path: String, name: String, value: &Toml, keys: &mut Vec<Key>) {
    let value = match value {
        Toml::Float(number) if number.is_finite() => Value::Real(*number),
        Toml::Integer(number) => Value::Whole(*number),
        Toml::Table(table) => {
            for (key, value) in table {
                // User-defined names, such as those of materials, may hold characters that a
                // structured name must not.
                if key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
                    gather(
                        format!("{path}.{key}"),
                        format!("{name}.{key}"),
                        value,
                        keys,
                    );
                }
            }
            return;
        }
        Toml::Array(items) => {
            for (place, value) in items.iter().enumerate() {
                let name = format!("{name}[{}]", place + 1);
                gather(format!("{path}.{place}"), name, value, keys);
            }
            return;
        }
        _ => return,
    };
    keys.push(Key { path, name, value });
}
