//! Contradictions between materials and keys of floor and patches.

use super::objection::{Objection, given, object_if, objection};
use crate::scenario::Scenario;
use crate::scenario::materials::Across;

/// A key beside `material`, and whether it is present.
type Beside = (&'static str, bool);

/// The keys beside `material`, of the floor or a patch.
macro_rules! beside {
    ($of:expr) => {
        given!(
            $of,
            friction,
            rolling_resistance,
            radius_exponent,
            creep,
            sliding,
            across,
            against
        )
    };
}

impl Scenario {
    /// Refuses floors on which a material and a key specify the same thing, patches without
    /// material and friction, and directional values of a frictionless ground.
    pub(super) fn object_to_materials(&self) -> Result<(), Objection> {
        let floor = &self.world.floor;
        object_to_both("world.floor", floor.material.as_deref(), &beside!(floor))?;
        let own = floor.friction();
        object_to_no_grip("world.floor", own, floor.across)?;
        for (index, patch) in floor.patches.iter().enumerate() {
            let key = format!("world.floor.patches.{index}");
            object_to_both(&key, patch.material.as_deref(), &beside!(patch))?;
            match (patch.friction, &patch.material) {
                (None, None) => {
                    return Err(objection!(
                        "{key}",
                        "the key `{key}.friction` is missing",
                        "add `{key}.friction`, Coulomb's coefficient of friction there, or `{key}.material`",
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
        object_if!(
            named && !floor.is_of_material(),
            "rollers.material",
            "the rollers have a material, but neither the floor nor a patch has one",
            "write `world.floor.material`, or leave the rollers' material out",
        );
        Ok(())
    }
}

/// Refuses a material together with a key that its pairs specify.
fn object_to_both(place: &str, material: Option<&str>, keys: &[Beside]) -> Result<(), Objection> {
    let Some(material) = material else {
        return Ok(());
    };
    match keys.iter().find(|(_, stands)| *stands) {
        None => Ok(()),
        Some((key, _)) => Err(objection!(
            "{place}.{key}",
            "`{place}.{key}` and `{place}.material` = \"{material}\" do not go together: the pair of materials defines this value",
            "leave one of them out, or change the pair: `materials.ROLLERS.{material}.{key}`, with the rollers' material for ROLLERS",
        )),
    }
}

/// Refuses a friction across a nap without friction along it: an ellipse cannot be that thin.
fn object_to_no_grip(place: &str, friction: f64, across: Option<Across>) -> Result<(), Objection> {
    let says = across.is_some_and(|across| across.friction.is_some());
    if friction > 0.0 || !says {
        return Ok(());
    }
    Err(objection!(
        "{place}.across.friction",
        "`{place}.across.friction` is given, but the friction along the nap is 0",
        "give both a friction above 0, or leave `across` out",
    ))
}
