//! The conditions of a run, from its resolved scenario.

use ilon_trace::{FaultKind, Header};

use crate::page::escape;
use crate::provenance::Provenance;
use crate::text::angle;

/// The gravity of scenarios that give none, in m/s^2.
const STANDARD_GRAVITY_M_S2: f64 = 9.81;

/// Returns the gravity of a run, in m/s^2.
pub(crate) fn gravity_m_s2(header: &Header) -> f64 {
    let given = resolved(header, "world", "gravity_m_s2").and_then(|value| value.as_float());
    given.unwrap_or(STANDARD_GRAVITY_M_S2)
}

/// Returns the value of a key of the resolved scenario, if it has one.
fn resolved(header: &Header, section: &str, key: &str) -> Option<toml::Value> {
    let scenario: toml::Table = header.scenario_toml.parse().ok()?;
    scenario.get(section)?.get(key).cloned()
}

/// Returns conditions other than the defaults, as HTML: slope, gravity, wheel law, tilting floor,
/// and keys set in addition to the scenario.
pub(crate) fn conditions(header: &Header, provenance: &Provenance) -> String {
    let gravity_m_s2 = gravity_m_s2(header);
    let slope_rad = header
        .ground
        .as_ref()
        .map_or(0.0, |ground| ground.slope_rad);
    let law = resolved(header, "wheel_loop", "law");
    let tilts = header.faults.iter().flatten();
    let tilts = tilts.filter(|fault| matches!(fault.kind, FaultKind::Tilt { .. }));
    let found = [
        (slope_rad != 0.0).then(|| format!("slope {}", angle(slope_rad))),
        (gravity_m_s2 != STANDARD_GRAVITY_M_S2).then(|| format!("gravity {gravity_m_s2} m/s²")),
        law.as_ref()
            .and_then(toml::Value::as_str)
            .filter(|law| *law != "pid")
            .map(|law| format!("wheel law {}", escape(&law.replace('_', " ")))),
        (tilts.count() > 0).then(|| "a floor that tilts".to_owned()),
    ];
    let set = provenance.changed.iter();
    let set = set.map(|value| format!("set: {}", escape(value)));
    let all: Vec<String> = found.into_iter().flatten().chain(set).collect();
    match all.is_empty() {
        true => String::new(),
        false => format!("<b>{}</b>", all.join("; ")),
    }
}

#[cfg(test)]
mod tests {
    use ilon_trace::Ground;

    use super::*;

    #[test]
    fn a_slope_is_a_condition_and_a_level_floor_is_none() {
        let said = |slope_rad: f64| {
            let ground = Ground {
                slope_rad,
                ..Ground::default()
            };
            let header = Header {
                ground: Some(ground),
                ..Header::default()
            };
            conditions(&header, &Provenance::default())
        };
        assert!(said(0.1).contains("slope 5.7"), "{}", said(0.1));
        assert!(!said(0.0).contains("slope"), "{}", said(0.0));
    }
}
