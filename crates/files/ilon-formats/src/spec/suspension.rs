//! Suspensions of wheels.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A suspension: bodies on joints between the chassis and some wheels. At zero the axles are as
/// high as the wheels' radius.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SuspensionSpec {
    /// Its wheels: two of a rocker, any number otherwise, each with a body.
    pub wheels: Vec<String>,
    /// Mass of each of its bodies, in kg.
    pub mass_kg: f64,
    /// What moves, and what acts on it.
    pub law: SuspensionLaw,
}

/// What moves in a suspension, and what acts on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum SuspensionLaw {
    /// `law.rocker = { limit_deg = 5 }`: a bar between two wheels that turns freely about its
    /// middle; between a front and a rear wheel a bogie. Its joint has the suspension's name.
    Rocker {
        /// Travel to its stops, either way, in degrees.
        limit_deg: f64,
        /// Viscous damping, in N m s/rad.
        #[serde(default)]
        damping_n_m_s_rad: f64,
        /// Dry friction, in N m.
        #[serde(default)]
        friction_n_m: f64,
    },
    /// `law.sprung = { stiffness_n_m = 4000, travel_m = 0.02 }`: each wheel slides up and down on a
    /// spring; joints `WHEEL_spring`.
    Sprung {
        /// Stiffness of the spring, in N/m.
        stiffness_n_m: f64,
        /// Viscous damping, in N s/m.
        #[serde(default)]
        damping_n_s_m: f64,
        /// Dry friction, in N.
        #[serde(default)]
        friction_n: f64,
        /// Force of the spring at zero, downwards, in N; with the wheel's load it does not sag.
        #[serde(default)]
        preload_n: f64,
        /// Travel to its stops, either way, in metres.
        travel_m: f64,
    },
    /// `law.trailing_arm = { length_m = 0.1, stiffness_n_m_rad = 40, travel_deg = 15 }`: each wheel
    /// on an arm with a torsion spring, pivot ahead of it (behind, if the length is negative);
    /// joints `WHEEL_arm`.
    TrailingArm {
        /// From the wheel's axle ahead to the pivot, in metres, at the same height.
        length_m: f64,
        /// Stiffness of the spring, in N m/rad.
        stiffness_n_m_rad: f64,
        /// Viscous damping, in N m s/rad.
        #[serde(default)]
        damping_n_m_s_rad: f64,
        /// Dry friction, in N m.
        #[serde(default)]
        friction_n_m: f64,
        /// Torque of the spring at zero, downwards, in N m.
        #[serde(default)]
        preload_n_m: f64,
        /// Travel to its stops, either way, in degrees.
        travel_deg: f64,
    },
}
