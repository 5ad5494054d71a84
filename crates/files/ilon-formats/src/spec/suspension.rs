//! What wheels hang on.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What some wheels hang on: bodies on joints between the chassis and the wheels, which begin at zero with the axles as high as the wheels' radius.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SuspensionSpec {
    /// The wheels that hang on it, by name: two of a rocker, any number of the others, each of which then has a body of its own.
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
    /// `law.rocker = { limit_deg = 5 }`: a bar between two wheels that turns freely about its middle, across itself: about the robot's long axis between a left
    /// and a right wheel, and as a bogie between one ahead and one behind. Its joint has the suspension's name.
    Rocker {
        /// How far it turns either way until its stops, in degrees.
        limit_deg: f64,
        /// Viscous damping, in N m s/rad.
        #[serde(default)]
        damping_n_m_s_rad: f64,
        /// Dry friction, in N m.
        #[serde(default)]
        friction_n_m: f64,
    },
    /// `law.sprung = { stiffness_n_m = 4000, travel_m = 0.02 }`: each wheel slides up and down on a spring; joints `WHEEL_spring`.
    Sprung {
        /// Stiffness of the spring, in N/m.
        stiffness_n_m: f64,
        /// Viscous damping, in N s/m.
        #[serde(default)]
        damping_n_s_m: f64,
        /// Dry friction, in N.
        #[serde(default)]
        friction_n: f64,
        /// What the spring pushes the wheel down with at zero, in N: with the load that the wheel bears it does not sag.
        #[serde(default)]
        preload_n: f64,
        /// How far the wheel moves either way until its stops, in metres.
        travel_m: f64,
    },
    /// `law.trailing_arm = { length_m = 0.1, stiffness_n_m_rad = 40, travel_deg = 15 }`: each wheel is at the end of an arm that turns about a pivot ahead of it
    /// (behind it where the length is below 0), on a torsion spring; joints `WHEEL_arm`.
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
        /// What the spring turns the wheel down with at zero, in N m.
        #[serde(default)]
        preload_n_m: f64,
        /// How far the arm turns either way until its stops, in degrees.
        travel_deg: f64,
    },
}
