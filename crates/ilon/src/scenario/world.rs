//! `[world]`: gravity and floor.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The world that the robot stands in.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "WorldSection")]
pub struct World {
    /// The acceleration of gravity, downwards, in m/s^2.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub gravity_m_s2: f64,
    /// The ground.
    pub floor: Floor,
    /// How the physics is solved; what is left out takes the program's measured defaults.
    pub solver: Solver,
}

/// Even ground without end.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "FloorSection")]
pub struct Floor {
    /// Coulomb's coefficient of friction between rollers and floor.
    #[schemars(range(min = 0.0))]
    pub friction: f64,
    /// The angle by which the floor falls towards +x, in degrees; 0 is level.
    #[schemars(range(min = -60.0, max = 60.0))]
    pub slope_deg: f64,
}

/// How the physics is solved: for those who measure the solver itself.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "SolverSection")]
pub struct Solver {
    /// Natural frequency of a contact's spring, in Hz: how fast penetration is pushed out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub contact_frequency_hz: Option<f64>,
    /// Damping ratio of a contact's spring, dimensionless.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub contact_damping_ratio: Option<f64>,
    /// Sweeps over the contacts in one step.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub sweeps: Option<u32>,
    /// Inertia added to every roller's spin, as a multiple of its own about its axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub roller_armature_ratio: Option<f64>,
}

impl Default for World {
    fn default() -> Self {
        Self {
            gravity_m_s2: 9.81,
            floor: Floor::default(),
            solver: Solver::default(),
        }
    }
}

impl Default for Floor {
    fn default() -> Self {
        Self {
            friction: 0.6,
            slope_deg: 0.0,
        }
    }
}
