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

impl Key {
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
