//! `[materials]`: contact properties of pairs of roller and floor materials.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Pairs of materials: of the rollers, and below it of the floor.
pub type Materials = BTreeMap<String, BTreeMap<String, MaterialPair>>;

/// What rollers of one material do on a floor of another.
#[serde_with::skip_serializing_none]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialPair {
    /// Friction coefficient.
    #[schemars(range(min = 0.0))]
    pub friction: f64,
    /// Rolling resistance: drag per load on level ground. Added to `rollers.rolling_resistance`.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub rolling_resistance: f64,
    /// Growth of rolling resistance on small radii: (wheel radius / the roller's radius of
    /// curvature)^this.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub radius_exponent: f64,
    /// Creep: slip per rolled distance, for each share of its load that a roller pulls with.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub creep: f64,
    /// Friction that falls with sliding speed [default: it does not].
    pub sliding: Option<Sliding>,
    /// Values across the floor's nap (`nap_deg`) [default: as along it].
    pub across: Option<Across>,
    /// Values against the floor's nap [default: as with it].
    pub against: Option<Against>,
}

/// Values across a nap or weave. Default: as along it.
#[serde_with::skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Across {
    /// Friction coefficient.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub friction: Option<f64>,
    /// Rolling resistance.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub rolling_resistance: Option<f64>,
    /// Creep.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub creep: Option<f64>,
}

/// Values against a nap. Default: as with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Against {
    /// Rolling resistance.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub rolling_resistance: Option<f64>,
}

/// Friction that falls with sliding speed (Stribeck), from the floor's `friction` at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sliding {
    /// Friction coefficient at speed.
    #[schemars(range(min = 0.0))]
    pub friction: f64,
    /// Speed over which it falls, in m/s, as exp(-(v / speed)^2).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub speed_m_s: f64,
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}
