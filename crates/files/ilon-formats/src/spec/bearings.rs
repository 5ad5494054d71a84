//! Classes of roller bearings, with their friction.
//!
//! Wheels are sold without data on the friction of their rollers. The numbers are from bearing
//! makers' tables, each with its source; measured ones are better.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the rollers of a wheel turn on their axles: a class of wheels, from which friction and
/// radius of the axles follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RollerBearings {
    /// Rollers that slide on a pin, or on a tube around it, without lubricant: kits for schools and
    /// contests.
    Bushings,
    /// Rollers on open or shielded ball bearings.
    Ball,
    /// Rollers on needle or tapered roller bearings about a thick axle: wheels for heavy vehicles.
    Industrial,
}

impl RollerBearings {
    /// Coefficient of the friction between roller and axle.
    ///
    /// - Bushings 0.2: the upper end of what SKF gives for dry bushings of acetal (POM), 0.02 to 0.20, and within that of PTFE, 0.03 to 0.25;
    ///   light loads are at the upper end.
    /// - Ball 0.0015: SKF's constant coefficient of deep groove ball bearings without contact seals, at the radius of the bore.
    /// - Industrial 0.0020: the same table, needle roller bearings with a cage; tapered ones have 0.0018.
    pub fn axle_friction(self) -> f64 {
        match self {
            Self::Bushings => 0.2,
            Self::Ball => 0.0015,
            Self::Industrial => 0.0020,
        }
    }

    /// Radius of the axles of rollers with this largest radius, in metres: 0.15 of it, as
    /// AndyMark's 8 inch mecanum wheel has it (a screw of 0.190 in through rollers of 1.25 in);
    /// twice that for industrial wheels, of which no maker gives it.
    pub fn axle_radius_m(self, roller_radius_m: f64) -> f64 {
        let share = match self {
            Self::Bushings | Self::Ball => 0.15,
            Self::Industrial => 0.3,
        };
        share * roller_radius_m
    }
}
