//! The contact properties of a scenario's floor and patches for the rollers of its robot, by keys
//! of the floor or by pairs of materials.

use ilon_robot::Robot;
use ilon_world::{ContactSurface, FloorSurface, Nap, Patch, Stribeck};
use nalgebra::Vector2;

use crate::timed::Timed;
use ilon_scenario::Error;
use ilon_scenario::scenario::{self, FloorPatch, MaterialPair, Scenario, Sliding};

/// The contact properties of the ground for each kind of rollers.
pub(crate) struct ContactSurfaces<'s> {
    scenario: &'s Scenario,
    /// The materials of the robot's rollers, the first wheel's first; a single `None` if the ground
    /// has no material.
    rollers: Vec<Option<String>>,
    /// The floor's properties for each of them, along its nap.
    floor: Vec<MaterialPair>,
}

impl<'s> ContactSurfaces<'s> {
    /// # Errors
    /// [`Error::Invalid`] if the ground has a material and rollers have none, or a pair is
    /// undefined.
    pub fn new(scenario: &'s Scenario, robot: &Robot) -> Result<Self, Error> {
        let section = &scenario.world.floor;
        let mut rollers: Vec<Option<String>> = Vec::new();
        if section.is_of_material() {
            for wheel in &robot.wheels {
                let Some(material) = &wheel.material else {
                    return Err(of_no_material(scenario, &wheel.name));
                };
                let known = |other: &Option<String>| other.as_ref() == Some(material);
                if !rollers.iter().any(known) {
                    rollers.push(Some(material.clone()));
                }
            }
        }
        if rollers.is_empty() {
            rollers.push(None);
        }
        let floor = rollers.iter().map(|rollers| {
            match section.material.as_deref().zip(rollers.as_deref()) {
                Some((on, rollers)) => pair(scenario, rollers, on, "world.floor.material"),
                None => Ok(of_floor(section)),
            }
        });
        Ok(Self {
            floor: floor.collect::<Result<_, Error>>()?,
            scenario,
            rollers,
        })
    }

    /// The floor's properties for each kind of rollers; at least one.
    pub fn floor(&self) -> Vec<ContactSurface> {
        let nap_deg = self.scenario.world.floor.nap_deg.unwrap_or(0.0);
        let floor = self.floor.iter();
        floor.map(|under| footing(under, nap_deg)).collect()
    }

    /// The materials of rollers for which the ground can differ; empty if all rollers are alike.
    pub fn materials(&self) -> Vec<String> {
        let materials = self.rollers.iter().flatten().cloned();
        self.each_of(materials.collect())
    }

    /// The properties of some ground for each of these materials.
    pub fn each_of<T>(&self, of_rollers: Vec<T>) -> Vec<T> {
        match self.rollers.len() > 1 {
            true => of_rollers,
            false => Vec::new(),
        }
    }

    /// All patches of the scenario.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a pair is undefined.
    pub fn patches(&self) -> Result<Vec<Timed<Patch>>, Error> {
        let patches = self.scenario.world.floor.patches.iter().enumerate();
        patches
            .map(|(index, patch)| self.patch(index, patch))
            .collect()
    }

    fn patch(&self, index: usize, patch: &FloorPatch) -> Result<Timed<Patch>, Error> {
        let section = &self.scenario.world.floor;
        let nap_deg = patch.nap_deg.or(section.nap_deg).unwrap_or(0.0);
        let footings = self
            .rollers
            .iter()
            .zip(&self.floor)
            .map(|(rollers, floor)| {
                let under = match patch.material.as_deref().zip(rollers.as_deref()) {
                    Some((on, rollers)) => {
                        let key = format!("world.floor.patches.{index}.material");
                        pair(self.scenario, rollers, on, &key)?
                    }
                    None => on_patch(floor, patch),
                };
                Ok(footing(&under, nap_deg))
            });
        let footings = footings.collect::<Result<Vec<_>, Error>>()?;
        let ContactSurface { friction, surface } = footings[0];
        Ok(Timed {
            of: Patch {
                center_m: Vector2::new(patch.x_m, patch.y_m),
                half_sides_m: 0.5 * Vector2::new(patch.length_x_m, patch.length_y_m),
                friction,
                surface,
                footings: self.each_of(footings),
            },
            from_s: patch.from_s,
            until_s: patch.until_s,
        })
    }
}

/// The properties of a floor without material.
fn of_floor(floor: &scenario::Floor) -> MaterialPair {
    MaterialPair {
        friction: floor.friction(),
        rolling_resistance: floor.rolling_resistance.unwrap_or(0.0),
        radius_exponent: floor.radius_exponent.unwrap_or(0.0),
        creep: floor.creep.unwrap_or(0.0),
        sliding: floor.sliding,
        across: floor.across,
        against: floor.against,
    }
}

/// The properties of a patch without material; missing ones are the floor's.
fn on_patch(floor: &MaterialPair, patch: &FloorPatch) -> MaterialPair {
    MaterialPair {
        friction: patch.friction.unwrap_or(floor.friction),
        rolling_resistance: patch.rolling_resistance.unwrap_or(floor.rolling_resistance),
        radius_exponent: patch.radius_exponent.unwrap_or(floor.radius_exponent),
        creep: patch.creep.unwrap_or(floor.creep),
        sliding: patch.sliding.or(floor.sliding),
        across: patch.across.or(floor.across),
        against: patch.against.or(floor.against),
    }
}

/// The properties of ground for rollers, given those along its nap.
fn footing(along: &MaterialPair, nap_deg: f64) -> ContactSurface {
    let across = along.across.unwrap_or_default();
    let against = along.against.unwrap_or_default();
    let nap = Nap {
        angle_rad: nap_deg.to_radians(),
        friction_ratio: match across.friction {
            Some(friction) if along.friction > 0.0 => friction / along.friction,
            _ => 1.0,
        },
        creep_across: across.creep.unwrap_or(along.creep),
        resistance_across: across
            .rolling_resistance
            .unwrap_or(along.rolling_resistance),
        resistance_against: against
            .rolling_resistance
            .unwrap_or(along.rolling_resistance),
    };
    let is_alike = nap.friction_ratio == 1.0
        && nap.creep_across == along.creep
        && nap.resistance_across == along.rolling_resistance
        && nap.resistance_against == along.rolling_resistance;
    let stribeck = |sliding: Sliding| Stribeck {
        friction: sliding.friction,
        speed_m_s: sliding.speed_m_s,
    };
    ContactSurface {
        friction: along.friction,
        surface: FloorSurface {
            rolling_resistance: along.rolling_resistance,
            radius_exponent: along.radius_exponent,
            creep: along.creep,
            sliding: along.sliding.map(stribeck),
            nap: (!is_alike).then_some(nap),
        },
    }
}

/// The pair of two materials.
fn pair(scenario: &Scenario, rollers: &str, on: &str, key: &str) -> Result<MaterialPair, Error> {
    let materials = &scenario.materials;
    if let Some(pair) = materials.get(rollers).and_then(|floors| floors.get(on)) {
        return Ok(*pair);
    }
    let named: Vec<String> = materials
        .iter()
        .flat_map(|(rollers, floors)| floors.keys().map(move |on| format!("{rollers} on {on}")))
        .collect();
    let message = format!(
        "`{key}` is \"{on}\" under rollers of \"{rollers}\", but `[materials]` has no such pair"
    );
    let floors = materials.get(rollers).into_iter().flat_map(|f| f.keys());
    let near_floor = scenario::nearest(on, floors.map(String::as_str));
    let of_floor = materials
        .iter()
        .filter(|(_, floors)| floors.contains_key(on));
    let near_rollers = scenario::nearest(rollers, of_floor.map(|(name, _)| name.as_str()));
    let meant = match (near_floor, near_rollers) {
        (Some(name), _) => format!("; did you mean the floor \"{name}\"?"),
        (None, Some(name)) => format!("; did you mean rollers of \"{name}\"?"),
        (None, None) => String::new(),
    };
    let known = match named.is_empty() {
        true => "there is no pair yet".to_owned(),
        false => format!("the pairs are {}", named.join(", ")),
    };
    Err(Error::invalid(
        message,
        format!("write `[materials.{rollers}.{on}]` with its `friction`; {known}{meant}"),
    ))
}

/// The error for rollers without material on ground with one.
fn of_no_material(scenario: &Scenario, wheel: &str) -> Error {
    let rollers: Vec<String> = scenario
        .materials
        .keys()
        .map(|name| format!("\"{name}\""))
        .collect();
    let known = match rollers.is_empty() {
        true => "`[materials]` names no material of rollers yet".to_owned(),
        false => format!("`[materials]` names {}", rollers.join(", ")),
    };
    let floor = &scenario.world.floor;
    let patch = floor
        .patches
        .iter()
        .position(|patch| patch.material.is_some());
    let key = match patch.filter(|_| floor.material.is_none()) {
        Some(patch) => format!("world.floor.patches.{patch}.material"),
        None => "world.floor.material".to_owned(),
    };
    Error::invalid(
        format!(
            "the ground has a material, `{key}`, but the rollers of the wheel `{wheel}` have none"
        ),
        format!("write `rollers.material` in the scenario, or in the robot's description; {known}"),
    )
}
