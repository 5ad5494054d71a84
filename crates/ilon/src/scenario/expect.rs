//! `[expect]`: bounds on what a run must come to.

use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::judge::quantities;

/// Bounds on quantities of the summary, by name; a dot steps into a quantity of several components, as in
/// `twist_ratio_contact.vy = { min = 0.995, max = 1.005 }`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Table", into = "Table")]
pub struct Expect {
    /// The bounds, by the quantity's dotted name.
    pub bounds: BTreeMap<String, Bound>,
    /// Bounds on signals over time: `[[expect.signals]]`.
    pub signals: Vec<SignalBound>,
    /// How far each signal may be from a baseline's, by its name: `[expect.tolerances]`.
    pub tolerances: BTreeMap<String, f64>,
}

/// What a recorded signal must keep to over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SignalBound {
    /// The signal: a column of the trace such as `truth_x_m`, with `wheel*_` in place of `wheel0_` for every wheel;
    /// or `position_error_m` or `heading_error_rad`.
    pub signal: String,
    /// When the bound must hold.
    #[serde(default)]
    pub must: Must,
    /// From when on the signal is looked at, in seconds.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub from_s: f64,
    /// Until when: the end of the window, or the time by which the signal must have settled, in seconds; without it,
    /// the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub until_s: Option<f64>,
    /// At least this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// At most this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// This, up to `within`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub equal: Option<f64>,
    /// How far from `equal` it may be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
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
    /// The bound by itself.
    pub fn bound(&self) -> Bound {
        Bound {
            min: self.min,
            max: self.max,
            equal: self.equal,
            within: self.within,
        }
    }
}

/// What one quantity must keep to. Each part that stands must hold; a quantity that does not apply to the run fails.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Bound {
    /// At least this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// At most this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// This, up to `within`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub equal: Option<f64>,
    /// How far from `equal` it may be.
    #[schemars(range(min = 0.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within: Option<f64>,
}

impl Expect {
    /// Whether nothing is expected.
    pub fn is_empty(&self) -> bool {
        self.bounds.is_empty() && self.signals.is_empty() && self.tolerances.is_empty()
    }
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
        let mut bounds = BTreeMap::new();
        collect(table, "", &mut bounds)?;
        Ok(Self {
            bounds,
            signals,
            tolerances,
        })
    }
}

/// Gathers the bounds of a table and of the tables in it under their dotted names.
fn collect(
    table: Table,
    prefix: &str,
    bounds: &mut BTreeMap<String, Bound>,
) -> Result<(), toml::de::Error> {
    for (key, value) in table {
        let name = format!("{prefix}{key}");
        match value {
            Value::Table(inner) if !quantities().contains(&name) => {
                collect(inner, &format!("{name}."), bounds)?;
            }
            value => {
                bounds.insert(name, value.try_into()?);
            }
        }
    }
    Ok(())
}

impl From<Expect> for Table {
    fn from(expect: Expect) -> Self {
        let mut root = Table::new();
        for (name, bound) in expect.bounds {
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
            if let Ok(value) = Value::try_from(bound) {
                table.insert(leaf.to_owned(), value);
            }
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
        for name in quantities() {
            let mut node = &mut root;
            for part in name.split('.') {
                let object = &mut node["properties"][part];
                if object.is_null() {
                    *object = serde_json::json!({
                        "type": "object", "properties": {}, "additionalProperties": false,
                    });
                }
                node = object;
            }
            *node = bound.clone();
        }
        let signals = generator.subschema_for::<Vec<SignalBound>>().to_value();
        root["properties"]["signals"] = signals;
        root["properties"]["tolerances"] = serde_json::json!({
            "description": "How far each signal may be from a baseline's, by its column's name (`wheel*_` for every \
                            wheel); what is not named must be equal.",
            "type": "object",
            "additionalProperties": { "type": "number", "minimum": 0.0 },
        });
        Schema::try_from(root).unwrap_or_default()
    }
}
