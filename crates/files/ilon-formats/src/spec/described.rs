//! The wheels of a description one by one, with their overrides.

use std::f64::consts::TAU;

use super::{PlacedWheel, RollerSpec, Spec, WheelOverride, WheelSpec};
use crate::model::Barrel;

/// One wheel with all its values.
#[derive(Clone, Debug)]
pub(crate) struct Described {
    pub(crate) placed: PlacedWheel,
    pub(crate) wheel: WheelSpec,
    pub(crate) rollers: RollerSpec,
    /// Rotation of the rollers about the hub axis at wheel angle zero, in radians.
    pub(crate) phase_rad: f64,
    /// Height of the axle above the floor on which the other wheels stand, in metres.
    pub(crate) axle_height_m: f64,
    /// Whether any value is overridden.
    pub(crate) is_overridden: bool,
}

impl Spec {
    /// Returns the wheels in the order in which they are written.
    pub(crate) fn described(&self) -> Vec<Described> {
        let one = |placed: PlacedWheel| {
            let over = self.overrides.get(&placed.name);
            self.with(placed, over)
        };
        self.wheels.placed().into_iter().map(one).collect()
    }

    fn with(&self, mut placed: PlacedWheel, over: Option<&WheelOverride>) -> Described {
        let (mut wheel, mut rollers) = (self.wheel.clone(), self.rollers.clone());
        let mut phase_rad = 0.0;
        if let Some(over) = over {
            let set = |value: &mut f64, said: Option<f64>| *value = said.unwrap_or(*value);
            set(&mut wheel.radius_m, over.radius_m);
            set(&mut wheel.hub_mass_kg, over.hub_mass_kg);
            set(&mut rollers.radius_m, over.roller_radius_m);
            set(&mut rollers.mass_kg, over.roller_mass_kg);
            set(&mut placed.gamma_deg, over.gamma_deg);
            if over.roller_material.is_some() {
                rollers.material.clone_from(&over.roller_material);
            }
            rollers.per_row = over.per_row.unwrap_or(rollers.per_row);
            phase_rad = over.phase_deg.unwrap_or_default().to_radians();
        }
        Described {
            placed,
            wheel,
            rollers,
            phase_rad,
            axle_height_m: self.wheel.radius_m,
            is_overridden: over.is_some(),
        }
    }
}

impl Described {
    /// Returns the barrel of its rollers: those of both rows alternate, and all share the turn
    /// equally.
    pub(crate) fn barrel(&self) -> Barrel {
        let handing_over = Barrel::handing_over(
            self.wheel.radius_m,
            self.rollers.radius_m,
            self.placed.gamma_deg.to_radians(),
            self.roller_count(),
        );
        Barrel {
            half_length_m: self.rollers.length_factor * handing_over.half_length_m,
            ..handing_over
        }
    }

    /// Like [`Self::barrel`], but at least long enough to hand over.
    pub(crate) fn barrel_at_least_handing_over(&self) -> Barrel {
        let mut longer = self.clone();
        longer.rollers.length_factor = self.rollers.length_factor.max(1.0);
        longer.barrel()
    }

    /// Returns the name of a roller's joint, by its index.
    pub(crate) fn roller_name(&self, index: usize) -> String {
        format!("{}_roller_{}", self.placed.name, index + 1)
    }

    /// Whether one of its rollers has this name.
    pub(crate) fn has_roller(&self, name: &str) -> bool {
        (0..self.roller_count()).any(|index| self.roller_name(index) == name)
    }

    /// Returns how far around the rim a roller is from straight down, in radians, and how far beside
    /// the wheel's middle, in metres: those of two rows take turns, half a pitch of one row apart.
    pub(crate) fn roller_place(&self, index: usize) -> (f64, f64) {
        let place_rad = TAU * index as f64 / self.roller_count() as f64 + self.phase_rad;
        let beside_m = match self.rollers.rows {
            2 if index.is_multiple_of(2) => -0.5 * self.rollers.row_spacing_m,
            2 => 0.5 * self.rollers.row_spacing_m,
            _ => 0.0,
        };
        (place_rad, beside_m)
    }

    /// The number of its rollers, in all rows.
    pub(crate) fn roller_count(&self) -> usize {
        self.rollers.per_row * self.rollers.rows
    }
}
