//! `[materials]`: what rollers of one material do on a floor of another.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Pairs of materials: of the rollers, and below it of the floor.
pub type Materials = BTreeMap<String, BTreeMap<String, MaterialPair>>;

/// What rollers of one material do on a floor of another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialPair {
    /// Coulomb's coefficient of friction of the pair.
    #[schemars(range(min = 0.0))]
    pub friction: f64,
    /// Rolling resistance of the pair: drag per load on level ground, dimensionless. What `rollers.rolling_resistance` says comes on top.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub rolling_resistance: f64,
    /// How the pair's rolling resistance grows on small radii: as (wheel radius / the roller's radius of curvature) to this power.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub radius_exponent: f64,
    /// Creep of the pair: how far a roller slips per way rolled, for each share of its load that it pulls with; dimensionless.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub creep: f64,
    /// How friction falls as a roller slides; left out, it does not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sliding: Option<Sliding>,
    /// What is otherwise across the floor's nap, which `nap_deg` of floor and patches turns; left out, nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub across: Option<Across>,
    /// What is otherwise against the floor's nap; left out, nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub against: Option<Against>,
}

/// What is otherwise across a nap or weave than along it; what is left out is as along it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Across {
    /// Coulomb's coefficient of friction across the nap.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub friction: Option<f64>,
    /// Rolling resistance across the nap.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub rolling_resistance: Option<f64>,
    /// Creep across the nap.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub creep: Option<f64>,
}

/// What is otherwise against a nap than with it; what is left out is as with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Against {
    /// Rolling resistance against the nap.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub rolling_resistance: Option<f64>,
}

/// Friction that falls with the speed of sliding (Stribeck): `friction` of the floor at rest, this one at speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sliding {
    /// Coefficient of friction at speed.
    #[schemars(range(min = 0.0))]
    pub friction: f64,
    /// The speed over which it falls, in m/s: with exp(-(v / speed)^2).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub speed_m_s: f64,
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}
