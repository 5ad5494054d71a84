//! Mass, centre of mass and inertia.

use nalgebra::{Matrix3, Vector3};

/// Mass, centre and inertia of one rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct MassProperties {
    /// Mass in kg, > 0.
    pub mass_kg: f64,
    /// Centre of mass in the body's own frame, in metres.
    pub center_of_mass_m: Vector3<f64>,
    /// Inertia about the centre of mass, along the axes of the body's own frame, in kg m^2.
    pub inertia_kg_m2: Matrix3<f64>,
}
