//! `[expect]`: bounds on the results of a run.

use std::collections::BTreeMap;

use ilon_trace::number;
use ilon_trace::quantities::{self, GROUPS};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::checks::objection::{Objection, object_if, objection};
use super::run::{Run, TIME_SLACK_S};
use crate::Error;

/// Bounds on quantities of the summary, by name; a dot steps into a quantity of several components,
/// as in `twist_ratio_contact.vy = { min = 0.995, max = 1.005 }`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Table", into = "Table")]
pub struct Expect {
    /// The bounds, by the quantity's dotted name.
    pub bounds: BTreeMap<String, Bound>,
    /// Allowed changes against a baseline, by the quantity's dotted name: `"+10 %"`.
    pub changes: BTreeMap<String, String>,
    /// Bounds on signals over time: `[[expect.signals]]`.
    pub signals: Vec<SignalBound>,
    /// Tolerance of each signal against a baseline, by column (`wheel*_` for every wheel); others
    /// must be equal.
    pub tolerances: BTreeMap<String, f64>,
}

/// Bounds of a recorded signal over time.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SignalBound {
    /// A column of the trace such as `truth_x_m` (`wheel*_`: every wheel), or `position_error_m` or
    /// `heading_error_rad`.
    pub signal: String,
    /// When the bound must hold.
    #[serde(default)]
    pub must: Must,
    /// Start of the window, in seconds.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub from_s: f64,
    /// End of the window, or the time by which the signal must have settled, in seconds [default:
    /// the end].
    #[schemars(range(min = 0.0))]
    pub until_s: Option<f64>,
    /// At least this.
    pub min: Option<f64>,
    /// At most this.
    pub max: Option<f64>,
    /// Equal to this, up to `within`.
    pub equal: Option<f64>,
    /// Largest distance from `equal`.
    #[schemars(range(min = 0.0))]
    pub within: Option<f64>,
}

/// When a bound on a signal must hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Must {
    /// At every instant of the window.
    #[default]
    Always,
    /// At some instant of the window.
    Eventually,
    /// From the end of the window at the latest, and from then on to the end of the run.
    Settle,
}

impl SignalBound {
    /// The bound without its window.
    pub fn bound(&self) -> Bound {
        Bound {
            min: self.min,
            max: self.max,
            equal: self.equal,
            within: self.within,
        }
    }
}

/// Bounds of one quantity; all given ones must hold. A quantity that does not exist for the run
/// fails. In their place a text bounds the change against the baseline of `ilon check --against`:
/// `"+10 %"`, `"-10 %"`, or `"+-10 %"` for both ways. Changes within the figure's accuracy hold.
#[serde_with::skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(extend("type" = ["object", "string"]))]
pub struct Bound {
    /// At least this.
    pub min: Option<f64>,
    /// At most this.
    pub max: Option<f64>,
    /// Equal to this, up to `within`.
    pub equal: Option<f64>,
    /// Largest distance from `equal`.
    #[schemars(range(min = 0.0))]
    pub within: Option<f64>,
}

impl Bound {
    /// The bound of an allowed change from a baseline's value: `"+10 %"` allows a tenth more,
    /// `"-10 %"` a tenth less, `"+-10 %"` both; a change of `least` is always allowed. `None` for
    /// another text.
    pub fn of_change(change: &str, baseline: f64, least: f64) -> Option<Self> {
        let percent = change.trim().strip_suffix('%')?.trim_end();
        let (digits, rises, falls) = match percent.strip_prefix("+-") {
            Some(digits) => (digits, true, true),
            None => match percent.split_at_checked(1)? {
                ("+", digits) => (digits, true, false),
                ("-", digits) => (digits, false, true),
                _ => return None,
            },
        };
        // One sign is enough.
        let digits = digits.trim();
        let is_number = digits.starts_with(|c: char| c.is_ascii_digit());
        let share = 1e-2 * digits.parse::<f64>().ok().filter(|_| is_number)?;
        let room = f64::max(share * baseline.abs(), least);
        (share.is_finite() && share >= 0.0).then(|| Self {
            min: falls.then_some(baseline - room),
            max: rises.then_some(baseline + room),
            ..Self::default()
        })
    }

    /// Whether a value satisfies the bound. NaN never does.
    pub fn holds(&self, value: f64) -> bool {
        self.breach(value) <= 0.0
    }

    /// The breach of a value as a share of the broken limit; `None` if it holds, or the limit is
    /// zero.
    pub fn share_beyond(&self, value: f64) -> Option<f64> {
        let breach = self.breach(value);
        let limit = match (self.min, self.max, self.equal) {
            (Some(min), ..) if value < min => min,
            (_, Some(max), _) if value > max => max,
            (.., equal) => equal?,
        };
        (breach > 0.0 && breach.is_finite() && limit != 0.0).then(|| breach / limit.abs())
    }

    /// Whether a value is below its lower end.
    pub fn is_above(&self, value: f64) -> bool {
        self.min.is_some_and(|min| value < min)
    }

    /// The distance of a value beyond the bound; zero or less if it holds, infinite for NaN.
    pub fn breach(&self, value: f64) -> f64 {
        let Self {
            min,
            max,
            equal,
            within,
        } = *self;
        if !value.is_finite() {
            return f64::INFINITY;
        }
        let parts = [
            min.map(|min| min - value),
            max.map(|max| value - max),
            equal.map(|equal| (value - equal).abs() - within.unwrap_or(0.0)),
        ];
        parts
            .into_iter()
            .flatten()
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

impl std::fmt::Display for Bound {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let parts = [
            self.min.map(|min| format!(">= {}", number(min))),
            self.max.map(|max| format!("<= {}", number(max))),
            self.equal.map(|equal| match self.within {
                Some(within) => format!("= {} +- {}", number(equal), number(within)),
                None => format!("= {}", number(equal)),
            }),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        f.write_str(&parts.join(" and "))
    }
}

impl Expect {
    /// Whether nothing is expected.
    pub fn is_empty(&self) -> bool {
        self.bounds.is_empty()
            && self.changes.is_empty()
            && self.signals.is_empty()
            && self.tolerances.is_empty()
    }

    /// Refuses meaningless expectations: bounds that can never be broken, and bounds that can never
    /// be met.
    pub(super) fn object(&self) -> Result<(), Objection> {
        for name in self.bounds.keys().chain(self.changes.keys()) {
            object_if!(
                name.starts_with("design."),
                "expect.{name}",
                "`expect.{name}` can never hold: only studies have it, a single run does not",
                "bound it in `[expect]` of a study, or leave it out",
            );
        }
        for (name, bound) in &self.bounds {
            object_to_bound(bound, name, &format!("expect.{name}"))?;
        }
        for (name, change) in &self.changes {
            if Bound::of_change(change, 1.0, 0.0).is_none() {
                return Err(objection!(
                    "expect.{name}",
                    "`expect.{name}` is \"{change}\", which is no change against a baseline",
                    "write \"+10 %\" for at most 10 % more, \"-10 %\" for at most 10 % less, \"+-10 %\" for both; or a bound, `{{ max = 1.5 }}`",
                ));
            }
        }
        for (index, signal) in self.signals.iter().enumerate() {
            object_to_signal(signal, &format!("expect.signals.{index}"))?;
        }
        Ok(())
    }

    /// Refuses bounds on the tracking of a reference in an open-loop run, which has none.
    pub(super) fn object_to_tracking(&self) -> Result<(), Objection> {
        let of_tracking =
            |name: &&String| name.starts_with("position_") || name.starts_with("heading_");
        match (self.bounds.keys().chain(self.changes.keys())).find(of_tracking) {
            None => Ok(()),
            Some(name) => Err(objection!(
                "expect.{name}",
                "`expect.{name}` can never hold: a run with `[twist]` follows no reference",
                "bound `end_x_m`, `end_y_m`, `end_heading_rad` or `twist_ratio_asked`, or write a `[reference]`",
            )),
        }
    }

    /// Checks that every expectation on a signal covers a row of the run; without rows it tests
    /// nothing.
    ///
    /// A run that was shortened for a quick look may ignore this, so it is checked only if a
    /// scenario is a test.
    ///
    /// # Errors
    /// [`Error::Invalid`], with the expectation at fault.
    pub fn check_windows(&self, run: &Run) -> Result<(), Error> {
        let last_row_s = run.last_row_s();
        for (index, expected) in self.signals.iter().enumerate() {
            let SignalBound {
                ref signal,
                must,
                from_s,
                until_s,
                ..
            } = *expected;
            let object = |what: String, help: &str| {
                let message = format!("`expect.signals.{index}` on `{signal}` {what}");
                Err(Error::invalid(message, help))
            };
            const LONGER: &str = "lengthen the run, `run.duration_s`, or move the window into it";
            let end_s = match until_s {
                Some(until_s) if until_s > run.duration_s + TIME_SLACK_S => {
                    let end_s = run.duration_s;
                    return object(
                        format!("looks until {until_s} s, beyond the end of the run at {end_s} s"),
                        LONGER,
                    );
                }
                until_s => until_s.unwrap_or(f64::INFINITY),
            };
            // A signal that must have settled by a time is checked from then on.
            let (from_s, end_s) = match must {
                Must::Settle => (until_s.unwrap_or(0.0), f64::INFINITY),
                Must::Always | Must::Eventually => (from_s, end_s),
            };
            if from_s > last_row_s + TIME_SLACK_S {
                return object(
                    format!(
                        "looks from {from_s} s on, but the last row of the run is at {last_row_s} s"
                    ),
                    LONGER,
                );
            }
            let first_row = ((from_s - TIME_SLACK_S) / run.row_s()).ceil().max(0.0);
            if last_row_s.min(first_row * run.row_s()) > end_s + TIME_SLACK_S {
                return object(
                    format!(
                        "looks from {from_s} to {end_s} s, between two rows, which are {} s apart",
                        run.row_s()
                    ),
                    "widen the window, or record more often: `run.control_dt_s`, `run.record_every`",
                );
            }
        }
        Ok(())
    }
}

/// Refuses a bound that can never be broken, and one that can never be met.
fn object_to_bound(bound: &Bound, quantity: &str, key: &str) -> Result<(), Objection> {
    let Bound {
        min,
        max,
        equal,
        within,
    } = *bound;
    object_if!(
        equal.is_none() && within.is_some(),
        "{key}.within",
        "`{key}` has `within` but no `equal`",
        "add `equal`, the value around which it may lie",
    );
    object_if!(
        min.is_none() && max.is_none() && equal.is_none(),
        "{key}",
        "`{key}` has no bound, so it always holds",
        "give it `min`, `max`, or `equal` with `within`, or leave it out",
    );
    let within = within.unwrap_or(0.0);
    let least = [min, equal.map(|equal| equal - within)];
    let most = [max, equal.map(|equal| equal + within)];
    let least = least
        .into_iter()
        .flatten()
        .fold(f64::NEG_INFINITY, f64::max);
    let most = most.into_iter().flatten().fold(f64::INFINITY, f64::min);
    object_if!(
        least > most,
        "{key}",
        "`{key}` can never hold: nothing is both {least} or more and {most} or less",
        "exchange or correct its bounds",
    );
    let Some(can_be) = quantities::limits(quantity) else {
        return Ok(());
    };
    let range = match can_be.most.is_finite() {
        true => format!("it is always from {} to {}", can_be.least, can_be.most),
        false => "it is never negative".to_owned(),
    };
    object_if!(
        most < can_be.least || least > can_be.most,
        "{key}",
        "`{key}` can never hold: {range}",
        "correct its bounds; they are in the unit of the name, and a share of 10 % is 0.1",
    );
    object_if!(
        can_be.is_certain && least <= can_be.least && most >= can_be.most,
        "{key}",
        "`{key}` always holds: {range}",
        "give it a bound that a run can break, or leave it out",
    );
    Ok(())
}

fn object_to_signal(expected: &SignalBound, key: &str) -> Result<(), Objection> {
    object_to_bound(&expected.bound(), &expected.signal, key)?;
    object_if!(
        expected.must == Must::Settle && expected.from_s != 0.0,
        "{key}.from_s",
        "`{key}.from_s` has no effect on a signal that must settle: only `until_s` counts",
        "leave it out, and write the time by which it must have settled as `until_s`",
    );
    let from_s = expected.from_s;
    let until_s = expected.until_s.unwrap_or(f64::INFINITY);
    object_if!(
        from_s > until_s,
        "{key}.until_s",
        "`{key}` has an empty window: it begins at {from_s} s and ends at {until_s} s",
        "exchange `from_s` and `until_s`",
    );
    Ok(())
}

impl TryFrom<Table> for Expect {
    type Error = toml::de::Error;

    fn try_from(mut table: Table) -> Result<Self, Self::Error> {
        let signals = match table.remove("signals") {
            Some(signals) => signals.try_into()?,
            None => Vec::new(),
        };
        let tolerances = match table.remove("tolerances") {
            Some(tolerances) => tolerances.try_into()?,
            None => BTreeMap::new(),
        };
        let mut expect = Self {
            signals,
            tolerances,
            ..Self::default()
        };
        expect.collect(table, "")?;
        Ok(expect)
    }
}

impl Expect {
    /// Collects the bounds of a table and its sub-tables under their dotted names.
    fn collect(&mut self, table: Table, prefix: &str) -> Result<(), toml::de::Error> {
        for (key, value) in table {
            let name = format!("{prefix}{key}");
            match value {
                Value::Table(inner) if quantities::by_key(&name).is_none() => {
                    self.collect(inner, &format!("{name}."))?;
                }
                _ if self.bounds.contains_key(&name) || self.changes.contains_key(&name) => {
                    let message = format!("the bound on `{name}` stands twice");
                    return Err(serde::de::Error::custom(message));
                }
                Value::String(change) => {
                    self.changes.insert(name, change);
                }
                value => {
                    self.bounds.insert(name, value.try_into()?);
                }
            }
        }
        Ok(())
    }
}

impl From<Expect> for Table {
    fn from(expect: Expect) -> Self {
        let mut root = Table::new();
        let bounds = expect.bounds.into_iter();
        let bounds = bounds.filter_map(|(name, bound)| Some((name, Value::try_from(bound).ok()?)));
        let changes = expect.changes.into_iter();
        let changes = changes.map(|(name, change)| (name, Value::String(change)));
        for (name, value) in bounds.chain(changes) {
            let (path, leaf) = name.rsplit_once('.').unwrap_or(("", &name));
            let mut table = &mut root;
            for part in path.split('.').filter(|part| !part.is_empty()) {
                let inner = table
                    .entry(part)
                    .or_insert_with(|| Value::Table(Table::new()));
                match inner.as_table_mut() {
                    Some(inner) => table = inner,
                    None => return root,
                }
            }
            table.insert(leaf.to_owned(), value);
        }
        if let Ok(tolerances) = Value::try_from(&expect.tolerances)
            && !expect.tolerances.is_empty()
        {
            root.insert("tolerances".to_owned(), tolerances);
        }
        if let Ok(signals) = Value::try_from(&expect.signals)
            && !expect.signals.is_empty()
        {
            root.insert("signals".to_owned(), signals);
        }
        root
    }
}

impl JsonSchema for Expect {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "ExpectSection".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let bound = generator.subschema_for::<Bound>().to_value();
        let mut root = serde_json::json!({
            "description": "Bounds on quantities of summary.json, by name.",
            "type": "object", "properties": {}, "additionalProperties": false,
        });
        let of_group =
            |group: &'static quantities::Group| group.quantities.iter().map(move |q| (group, q));
        for (group, quantity) in GROUPS.iter().flat_map(of_group) {
            let mut node = &mut root;
            for part in quantity.key.split('.') {
                let object = &mut node["properties"][part];
                if object.is_null() {
                    *object = serde_json::json!({
                        "type": "object", "properties": {}, "additionalProperties": false,
                    });
                }
                node = object;
            }
            *node = bound.clone();
            let unit = match quantities::si_unit(quantity.key) {
                "" => String::new(),
                unit => format!(", in {unit}"),
            };
            node["description"] = format!("{}: {}{unit}", group.heading, quantity.label).into();
        }
        let signals = generator.subschema_for::<Vec<SignalBound>>().to_value();
        root["properties"]["signals"] = signals;
        root["properties"]["tolerances"] = serde_json::json!({
            "description": "Tolerance of each signal against a baseline, by column (`wheel*_` for every wheel); others must be \
                            equal.",
            "type": "object",
            "additionalProperties": { "type": "number", "minimum": 0.0 },
        });
        Schema::try_from(root).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::Scenario;
    use super::*;

    #[test]
    fn a_bound_holds_on_its_edge_and_not_beyond() {
        let bound = Bound {
            min: Some(1.0),
            max: Some(2.0),
            ..Bound::default()
        };
        assert!(bound.holds(1.0) && bound.holds(2.0));
        assert!(!bound.holds(0.999) && !bound.holds(2.001) && !bound.holds(f64::NAN));
        assert_eq!(bound.to_string(), ">= 1 and <= 2");
        // 0.5 of 1, 1 of 2.
        assert_eq!(bound.share_beyond(0.5), Some(0.5));
        assert_eq!(bound.share_beyond(3.0), Some(0.5));
        assert_eq!(bound.share_beyond(1.5), None);
    }

    /// A tenth of 5 is 0.5, and of -5 too.
    #[test]
    fn a_change_against_a_baseline_is_a_share_of_its_size() {
        let of = |change: &str, baseline: f64| {
            Bound::of_change(change, baseline, 0.1).map(|bound| (bound.min, bound.max))
        };
        assert_eq!(of("+10 %", 5.0), Some((None, Some(5.5))));
        assert_eq!(of("-10%", 5.0), Some((Some(4.5), None)));
        // A change of 0.1 is none.
        assert_eq!(of("+10 %", 0.0), Some((None, Some(0.1))));
        assert_eq!(of(" +- 10 %", -5.0), Some((Some(-5.5), Some(-4.5))));
        for wrong in ["10 %", "+10", "+ten %", "", "%", "+-5", "+-1 % %", "++5 %"] {
            assert_eq!(of(wrong, 5.0), None, "{wrong}");
        }
        let text = "[expect]\nslip_energy_j = \"+10 %\"\nodometry_ideal.final_m = \"-5 %\"\n";
        let scenario = scenario(text).expect("changes");
        assert_eq!(scenario.expect.changes.len(), 2);
        let again = Scenario::from_toml(&scenario.to_toml().expect("text"), "test", "");
        assert_eq!(again.expect("the same").expect, scenario.expect);
        let (message, place) = told("[expect]\nslip_energy_j = \"10 %\"\n");
        assert!(
            message.contains("no change against a baseline"),
            "{message}"
        );
        assert!(
            place.contains("10 %") || place == "slip_energy_j",
            "{place}"
        );
    }

    const RUN: &str = "robot.file = \"r.urdf\"\ntwist = {}\n[run]\nduration_s = 1.0\n";

    /// The objection to a scenario, and the text that it points at.
    fn told(further: &str) -> (String, String) {
        let text = format!("{RUN}{further}");
        match Scenario::from_toml(&text, "test", "") {
            Err(Error::Scenario(fault)) => {
                let span = fault.span.offset()..fault.span.offset() + fault.span.len();
                (fault.message.clone(), text[span].to_owned())
            }
            other => panic!("{other:?}"),
        }
    }

    fn scenario(further: &str) -> Result<Scenario, Error> {
        Scenario::from_toml(&format!("{RUN}{further}"), "test", "")
    }

    #[test_case::test_case("hub_ripple_m = {}", "has no bound", "hub_ripple_m"; "empty")]
    #[test_case::test_case("hub_ripple_m = { within = 1e-9 }", "no `equal`", "1e-9"; "no equal")]
    #[test_case::test_case("hub_ripple_m = { max = 1, within = 1e-9 }", "no `equal`", "1e-9"; "not even max")]
    #[test_case::test_case("twist_mean.vx_m_s = {}", "has no bound", "vx_m_s"; "in a group")]
    #[test_case::test_case(
        "slip_energy_j = { min = 2, max = 1 }",
        "both 2 or more and 1 or less",
        "slip_energy_j";
        "crossed"
    )]
    #[test_case::test_case(
        "slip_energy_j = { equal = 5, within = 1, max = 3 }",
        "both 4 or more and 3 or less",
        "slip_energy_j";
        "apart"
    )]
    #[test_case::test_case(
        "slip_energy_j = { equal = 5, min = 5.1 }",
        "both 5.1 or more and 5 or less",
        "slip_energy_j";
        "apart below"
    )]
    fn a_bound_that_nothing_can_break_or_meet_is_refused_where_it_stands(
        bound: &str,
        message: &str,
        place: &str,
    ) {
        let (told, at) = told(&format!("[expect]\n{bound}\n"));
        assert!(told.contains(message), "{told}");
        assert_eq!(at, place);
    }

    #[test_case::test_case(
        "hub_ripple_m = { max = -1 }",
        Some("can never hold: it is never negative")
    )]
    #[test_case::test_case("hub_ripple_m = { min = 0 }", Some("always holds"))]
    #[test_case::test_case("hub_ripple_m = { equal = -1, within = 0.5 }", Some("can never hold"))]
    #[test_case::test_case("hub_ripple_m = { min = 0, max = 1 }", None)]
    #[test_case::test_case("odometry_drift_m_per_m = { min = 0 }", None; "a figure that not every run has")]
    #[test_case::test_case("hub_ripple_m = { max = 0 }", None)]
    #[test_case::test_case("airborne_share = { max = 10 }", Some("always from 0 to 1"))]
    #[test_case::test_case("friction_used_max = { max = 1 }", Some("always holds"))]
    #[test_case::test_case("friction_used_max = { min = 1 }", None)]
    #[test_case::test_case("friction_used_max = { min = 10 }", Some("can never hold"))]
    #[test_case::test_case("chassis_load_share = { min = 0.5, max = 1 }", None)]
    #[test_case::test_case("slip_energy_j = { max = -1 }", Some("can never hold"))]
    #[test_case::test_case("slip_energy_j = { min = 0 }", None; "a loss may come out negative")]
    #[test_case::test_case("end_x_m = { max = -1 }", None)]
    #[test_case::test_case("energy.unexplained_share = { min = -1 }", None)]
    #[test_case::test_case("twist_ratio_ideal.vx = { max = 1.5 }", None)]
    fn a_bound_is_held_against_what_its_figure_can_be(bound: &str, message: Option<&str>) {
        let text = format!("[expect]\n{bound}\n");
        match message {
            None => assert!(scenario(&text).is_ok()),
            Some(message) => assert!(told(&text).0.contains(message), "{:?}", told(&text)),
        }
    }

    #[test]
    fn a_run_in_open_loop_has_no_tracking_to_bound() {
        let text = "robot.file = 'x.urdf'\ntwist.vx_m_s = 0.3\nrun.duration_s = 1\n";
        let told =
            |bound: &str| Scenario::from_toml(&format!("{text}expect.{bound}"), "t", ".").err();
        let refused = told("position_error_max_m = { max = 0.1 }").map(|error| error.to_string());
        assert!(refused.is_some_and(|text| text.contains("follows no reference")));
        assert!(told("saturated_share = { max = 0.1 }").is_none());
        let refused = told("design.rank = { min = 3 }").map(|error| error.to_string());
        assert!(refused.is_some_and(|text| text.contains("only studies have it")));
        assert!(told("end_x_m = { max = 0.1 }").is_none());
    }

    #[test_case::test_case("", "has no bound"; "empty")]
    #[test_case::test_case("within = 0.1", "no `equal`"; "no equal")]
    #[test_case::test_case("min = 1\nmax = -1", "can never hold"; "crossed")]
    #[test_case::test_case("max = 1\nfrom_s = 0.5\nuntil_s = 0.4", "has an empty window"; "reversed")]
    #[test_case::test_case("max = 1\nmust = 'settle'\nfrom_s = 0.5", "has no effect"; "settles")]
    fn a_bound_on_a_signal_that_says_nothing_is_refused(bound: &str, message: &str) {
        let good = "[[expect.signals]]\nsignal = 'truth_x_m'\nmax = 1\n";
        let bad = format!("{good}[[expect.signals]]\nsignal = 'truth_y_m'\n{bound}\n");
        let (told, _) = told(&bad);
        assert!(told.contains(message), "{told}");
        assert!(told.contains("`expect.signals.1"), "{told}");
        assert!(scenario(good).is_ok());
    }

    // A row every 10 ms for 1 s: the last at 1 s.
    #[test_case::test_case("max = 1", None)]
    #[test_case::test_case("max = 1\nfrom_s = 1.0", None)]
    #[test_case::test_case("max = 1\nuntil_s = 1.0", None)]
    #[test_case::test_case("max = 1\nfrom_s = 0.3\nuntil_s = 0.3", None)]
    #[test_case::test_case("max = 1\nmust = 'settle'\nuntil_s = 1.0", None)]
    #[test_case::test_case(
        "max = 1\nuntil_s = 1.1",
        Some("looks until 1.1 s, beyond the end of the run at 1 s")
    )]
    #[test_case::test_case(
        "max = 1\nfrom_s = 1.005",
        Some("looks from 1.005 s on, but the last row of the run is at 1 s")
    )]
    #[test_case::test_case("max = 1\nfrom_s = 5", Some("looks from 5 s on"))]
    #[test_case::test_case("max = 1\nmust = 'eventually'\nuntil_s = 2", Some("looks until 2 s"))]
    #[test_case::test_case(
        "max = 1\nfrom_s = 0.301\nuntil_s = 0.309",
        Some("between two rows, which are 0.01 s apart")
    )]
    fn a_window_is_refused_where_it_holds_no_row(bound: &str, message: Option<&str>) {
        let scenario = scenario(&format!(
            "[[expect.signals]]\nsignal = 'truth_x_m'\n{bound}\n"
        ));
        let found = scenario
            .map(|s| s.expect.check_windows(&s.run))
            .expect("the run itself is good");
        match message {
            None => assert!(found.is_ok(), "{found:?}"),
            Some(message) => {
                let told = found.unwrap_err().to_string();
                assert!(told.contains(message), "{told}");
            }
        }
    }
}
