//! `[materials]`: what rollers of one material do on a floor of another.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::objection::Objection;
use super::{Scenario, Sliding};

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

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

/// A key beside `material`, and whether it stands.
type Beside = (&'static str, bool);

impl Scenario {
    /// Refuses floors of which a material and a key of their own say the same thing, patches of which neither says how they grip, and
    /// directions of what does not grip at all.
    pub(super) fn object_to_materials(&self) -> Result<(), Objection> {
        let floor = &self.world.floor;
        let keys = [
            ("friction", floor.friction.is_some()),
            ("rolling_resistance", floor.rolling_resistance.is_some()),
            ("radius_exponent", floor.radius_exponent.is_some()),
            ("creep", floor.creep.is_some()),
            ("sliding", floor.sliding.is_some()),
            ("across", floor.across.is_some()),
            ("against", floor.against.is_some()),
        ];
        object_to_both("world.floor", floor.material.as_deref(), &keys)?;
        let own = floor.friction();
        object_to_no_grip("world.floor", own, floor.across)?;
        for (index, patch) in floor.patches.iter().enumerate() {
            let key = format!("world.floor.patches.{index}");
            let keys = [
                ("friction", patch.friction.is_some()),
                ("rolling_resistance", patch.rolling_resistance.is_some()),
                ("radius_exponent", patch.radius_exponent.is_some()),
                ("creep", patch.creep.is_some()),
                ("sliding", patch.sliding.is_some()),
                ("across", patch.across.is_some()),
                ("against", patch.against.is_some()),
            ];
            object_to_both(&key, patch.material.as_deref(), &keys)?;
            match (patch.friction, &patch.material) {
                (None, None) => {
                    return Err(Objection::to(
                        key.clone(),
                        format!("the key `{key}.friction` is missing"),
                        format!(
                            "add `{key}.friction`, Coulomb's coefficient of friction there, or `{key}.material`"
                        ),
                    ));
                }
                (friction, _) => object_to_no_grip(&key, friction.unwrap_or(1.0), patch.across)?,
            }
        }
        for (rollers, floors) in &self.materials {
            for (on, pair) in floors {
                let key = format!("materials.{rollers}.{on}");
                object_to_no_grip(&key, pair.friction, pair.across)?;
            }
        }
        let named = self.rollers.material.is_some() || !self.rollers.wheel_materials.is_empty();
        if named && !floor.is_of_material() {
            return Err(Objection::to(
                "rollers.material",
                "the rollers are of a material, but neither the floor nor a patch is",
                "write `world.floor.material`, or leave the rollers' material out",
            ));
        }
        Ok(())
    }
}

/// Refuses a material together with a key that says what its pairs say.
fn object_to_both(place: &str, material: Option<&str>, keys: &[Beside]) -> Result<(), Objection> {
    let Some(material) = material else {
        return Ok(());
    };
    match keys.iter().find(|(_, stands)| *stands) {
        None => Ok(()),
        Some((key, _)) => Err(Objection::to(
            format!("{place}.{key}"),
            format!(
                "`{place}.{key}` and `{place}.material` = \"{material}\" do not go together: the pair of materials says it"
            ),
            format!(
                "leave one of them out, or change the pair: `materials.ROLLERS.{material}.{key}`, with the rollers' material for ROLLERS"
            ),
        )),
    }
}

/// Refuses a friction across a nap along which there is none: no ellipse is as thin.
fn object_to_no_grip(place: &str, friction: f64, across: Option<Across>) -> Result<(), Objection> {
    let says = across.is_some_and(|across| across.friction.is_some());
    if friction > 0.0 || !says {
        return Ok(());
    }
    Err(Objection::to(
        format!("{place}.across.friction"),
        format!("`{place}.across.friction` stands beside a friction of 0 along the nap"),
        "give both a friction above 0, or leave the one across out",
    ))
}
