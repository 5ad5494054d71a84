//! The quantities of a run by name: one table with key, label, unit and digits of each figure of
//! `summary.json`, for terminal, comparison, report, expectations and schema.
//!
//! Stored values are in SI units; [`Quantity::shown`] is the value for display.

use crate::metrics::Summary;

mod accuracy;
mod limits;
mod needs;
mod quantity;
mod table;

pub(crate) use accuracy::Scales;
pub use accuracy::{accuracy, compared, known_to, least_change, stated};
pub use limits::limits;
pub use needs::needs;
pub use quantity::{Accuracy, Group, Limits, Measure, Quantity, Unit};
pub use table::GROUPS;

impl Quantity {
    /// A description that needs no heading: the label, with the heading added if the label is not
    /// unique.
    pub fn words(&self) -> String {
        let alike = all().filter(|other| other.label == self.label);
        let mut groups = GROUPS.iter();
        let group = groups.find(|group| group.quantities.iter().any(|one| one.key == self.key));
        match group {
            Some(group) if alike.count() > 1 => format!("{}: {}", group.heading, self.label),
            _ => self.label.to_owned(),
        }
    }
}

/// All quantities, in the order of [`GROUPS`].
pub fn all() -> impl Iterator<Item = &'static Quantity> {
    GROUPS.iter().flat_map(|group| group.quantities)
}

/// The most important figures of a run, in order of importance: the first ten of the list below
/// that apply. For a robot that tracks a path, those of [`Group::open_loop_only`] are left out.
pub fn headlines(summary: &Summary) -> Vec<&'static Quantity> {
    const MOST: usize = 10;
    // In open loop a limit that takes nothing is no news.
    let tracks = summary.position_error_final_m.is_some();
    let value = |key: &str| by_key(key).and_then(|quantity| quantity.value(summary));
    // Nor is a share of the contact kinematics where these are the ideal ones, as on tyres, or a
    // ripple that the ground made.
    let is_news = |key: &&&str| match **key {
        "saturated_share" => tracks || summary.saturated_share > Some(0.0),
        "hub_ripple_m" => summary.hub_ripple_m < Some(0.01),
        key => key.strip_prefix("twist_ratio_contact").is_none_or(|axis| {
            let [contact, ideal] = [value(key), value(&format!("twist_ratio_ideal{axis}"))];
            contact.zip(ideal).is_none_or(|(a, b)| (a - b).abs() > 1e-4)
        }),
    };
    let known = HEADLINES
        .iter()
        .filter(is_news)
        .filter_map(|key| by_key(key));
    let applies = |quantity: &&Quantity| {
        says_something(quantity.key, summary) && quantity.value(summary).is_some()
    };
    known.filter(applies).take(MOST).collect()
}

/// Whether a figure is meaningful for a run: for a robot that tracks a path, those of
/// [`Group::open_loop_only`] are not.
pub(crate) fn says_something(key: &str, summary: &Summary) -> bool {
    let tracks = summary.position_error_final_m.is_some();
    let mut open_loop = GROUPS.iter().filter(|group| group.open_loop_only);
    !(tracks && open_loop.any(|group| group.quantities.iter().any(|one| one.key == key)))
}

/// The keys of [`headlines`]: first the motion, then its cost.
const HEADLINES: [&str; 18] = [
    "twist_ratio_ideal.vx",
    "twist_ratio_ideal.vy",
    "twist_ratio_ideal.omega",
    "twist_ratio_contact.vx",
    "twist_ratio_contact.vy",
    "twist_ratio_contact.omega",
    "position_error_rms_m",
    "position_error_max_m",
    "position_error_final_m",
    "heading_error_max_rad",
    "heading_error_final_rad",
    "saturated_share",
    "slip_energy_j",
    "friction_used_max",
    "wheel_torque_max_n_m",
    "odometry_drift_m_per_m",
    "slip_speed_max_m_s",
    "hub_ripple_m",
];

/// Whether a figure is better the smaller it is, by its key; false of places, times of an event and
/// ratios.
pub fn is_cost(key: &str) -> bool {
    const PARTS: [&str; 11] = [
        "error",
        "converged_s",
        "torque_max",
        "conflict",
        "saturated",
        "ripple",
        "slip",
        "friction_used",
        "odometry",
        "energy",
        "ledger.total",
    ];
    !key.ends_with("_at_s") && PARTS.iter().any(|part| key.contains(part))
}

/// The quantity with a key such as `position_error_rms_m`.
pub fn by_key(key: &str) -> Option<&'static Quantity> {
    all().find(|quantity| quantity.key == key)
}

/// The SI unit of a recorded signal or figure, from the end of its name: `rad/s` for
/// `wheel0_rate_rad_s`; empty for a pure number.
pub fn si_unit(name: &str) -> &'static str {
    without_unit(name.rsplit('.').next().unwrap_or(name)).1
}

/// A name without its unit, and the symbol of that unit: `position_gain` and `1/s` for
/// `position_gain_per_s`.
pub fn without_unit(name: &str) -> (&str, &'static str) {
    let stripped = UNITS.iter().find_map(|(end, symbol)| {
        let before = name.strip_suffix(end)?;
        let is_whole = before.is_empty() || before.ends_with('_');
        is_whole.then(|| (before.trim_end_matches('_'), *symbol))
    });
    stripped.unwrap_or((name, ""))
}

/// Longer endings come first.
const UNITS: [(&str, &str); 17] = [
    ("m_per_m", "m/m"),
    ("rad_per_m", "rad/m"),
    ("rad_per_turn", "rad/turn"),
    ("per_s", "1/s"),
    ("deg_s", "deg/s"),
    ("deg", "deg"),
    ("n_m", "N m"),
    ("m_s2", "m/s^2"),
    ("rad_s", "rad/s"),
    ("m_s", "m/s"),
    ("rad", "rad"),
    ("m", "m"),
    ("n", "N"),
    ("j", "J"),
    ("hz", "Hz"),
    ("kg", "kg"),
    ("s", "s"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Settings;
    use crate::sample::made_up_trace;
    use serde_json::Value;

    /// The dotted keys of the numbers, also null, in a complete summary.
    fn keys_in(value: &Value, at: &str, keys: &mut Vec<String>) {
        match value {
            Value::Number(_) | Value::Null => keys.push(at.to_owned()),
            Value::Object(members) => {
                for (key, member) in members {
                    let dot = if at.is_empty() { "" } else { "." };
                    keys_in(member, &format!("{at}{dot}{key}"), keys);
                }
            }
            _ => {}
        }
    }

    /// The figures of a run in which everything applies.
    fn whole_summary() -> Summary {
        let mut trace = made_up_trace(3, 40, true);
        trace.header.open_loop = true;
        trace.header.measure_to_s = f64::INFINITY;
        let mut summary = Summary::of(&trace, &Settings::default());
        summary.sim_seconds_per_cpu_second = Some(7.0);
        summary.design.rank = Some(3.0);
        summary.ledger.belief.x_m = 1e-3;
        summary
    }

    #[test]
    fn every_number_of_a_summary_is_a_quantity_and_the_other_way_round() {
        let mut of_summary = Vec::new();
        keys_in(&serde_json::json!(whole_summary()), "", &mut of_summary);
        let mut of_table: Vec<_> = all().map(|quantity| quantity.key.to_owned()).collect();
        of_summary.sort();
        of_table.sort();
        assert_eq!(of_table, of_summary);
    }

    #[test]
    fn a_quantity_is_what_the_summary_holds_under_its_key() {
        let summary = whole_summary();
        let json = serde_json::json!(summary);
        let mut present = 0;
        for quantity in all() {
            let pointer = format!("/{}", quantity.key.replace('.', "/"));
            let held = json.pointer(&pointer).and_then(Value::as_f64);
            assert_eq!(quantity.value(&summary), held, "{}", quantity.key);
            present += usize::from(held.is_some());
        }
        // Guards against a comparison that is empty.
        assert!(present > 60, "{present} of {} are there", all().count());
    }

    #[test]
    fn the_headlines_are_quantities_that_apply_and_ten_at_most() {
        for key in HEADLINES {
            assert!(by_key(key).is_some(), "{key}");
        }
        let summary = whole_summary();
        let keys = |summary: &Summary| headlines(summary).iter().map(|q| q.key).collect::<Vec<_>>();
        // It tracks a path: the tracking figures come first, and no ratio of mean twists.
        assert_eq!(keys(&summary), HEADLINES[6..16]);
        let open_loop = Summary {
            position_error_final_m: None,
            ..summary
        };
        let first: Vec<_> = keys(&open_loop).into_iter().take(6).collect();
        assert_eq!(first, HEADLINES[..6]);
    }

    #[test]
    fn the_unit_shown_measures_what_the_unit_of_the_key_measures() {
        let degrees = 1f64.to_degrees();
        let fitting = [
            ("m", "m", 1.0),
            ("m", "mm", 1e3),
            ("m/s", "m/s", 1.0),
            ("m/s", "mm/s", 1e3),
            ("m/m", "mm per m", 1e3),
            ("rad", "deg", degrees),
            ("rad/m", "deg per m", degrees),
            ("rad/turn", "deg per turn", degrees),
            ("rad/s", "rad/s", 1.0),
            ("m/s^2", "m/s^2", 1.0),
            ("s", "s", 1.0),
            ("s", "ms", 1e3),
            ("J", "J", 1.0),
            ("N m", "N m", 1.0),
            // Shares and ratios, counts, multiples.
            ("", "%", 1e2),
            ("", "", 1.0),
            ("", "times real time, one core", 1.0),
        ];
        for quantity in all() {
            let Unit { symbol, per_si } = quantity.unit;
            let pair = (si_unit(quantity.key), symbol, per_si);
            assert!(fitting.contains(&pair), "{} has {pair:?}", quantity.key);
        }
    }

    #[test]
    fn a_quantity_is_shown_in_its_unit() {
        let summary = Summary {
            position_error_rms_m: Some(0.012),
            ..Summary::default()
        };
        let quantity = by_key("position_error_rms_m").expect("it exists");
        assert_eq!(quantity.shown(&summary), Some(12.0));
        assert_eq!(quantity.unit.symbol, "mm");
        assert!(by_key("position_error").is_none());
    }

    #[test]
    fn the_unit_of_a_signal_follows_from_the_end_of_its_name() {
        assert_eq!(si_unit("wheel0_rate_rad_s"), "rad/s");
        assert_eq!(si_unit("wheel0_torque_n_m"), "N m");
        assert_eq!(si_unit("truth_x_m"), "m");
        assert_eq!(si_unit("t_s"), "s");
        assert_eq!(si_unit("wheel0_load_share"), "");
        assert_eq!(si_unit("wheel0_normal_force_n"), "N");
    }

    /// Labels are short, because they are under headings. Without the heading, the same label would
    /// name two figures.
    #[test]
    fn words_that_need_no_heading_name_one_quantity_each() {
        let mut words: Vec<_> = all().map(|quantity| quantity.words()).collect();
        let count = words.len();
        words.sort();
        words.dedup();
        assert_eq!(words.len(), count);
        // A unique label needs no heading.
        let lone = all().filter(|one| all().filter(|other| other.label == one.label).count() == 1);
        for quantity in lone {
            assert_eq!(quantity.words(), quantity.label);
        }
    }
}
