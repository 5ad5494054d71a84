//! Loads on a chassis, and pushes.

use ilon_robot::MassProperties;
use nalgebra::Vector3;

use crate::WorldError;
use crate::error::{FINITE, POSITIVE, check_numbers};

/// A point mass fixed to the chassis; a large load is described by several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Payload {
    pub(crate) mass_kg: f64,
    pub(crate) place_in_body_m: Vector3<f64>,
}

impl Payload {
    /// A payload of a mass in kg at a point in the body frame, in metres.
    ///
    /// # Errors
    /// [`WorldError::Setting`] for a mass that is not above 0, or a point that is not finite.
    pub fn new(mass_kg: f64, place_in_body_m: Vector3<f64>) -> Result<Self, WorldError> {
        let place = place_in_body_m.iter();
        let place = place.map(|at_m| ("place_in_body_m", *at_m, FINITE));
        check_numbers([("mass_kg", mass_kg, POSITIVE)].into_iter().chain(place))?;
        Ok(Self {
            mass_kg,
            place_in_body_m,
        })
    }
}

/// A push at the beginning of the step in which it acts, in the floor's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ActingPush {
    pub force_n: Vector3<f64>,
    /// From the chassis's centre of mass to the point of application.
    pub lever_m: Vector3<f64>,
    /// A moment in addition to the force's.
    pub moment_n_m: Vector3<f64>,
}

/// A chassis and its load as one rigid body.
pub(crate) fn loaded(bare: &MassProperties, payloads: &[Payload]) -> MassProperties {
    let carried = payloads.iter();
    let carried = carried.map(|load| MassProperties::point(load.mass_kg, load.place_in_body_m));
    let parts: Vec<MassProperties> = [bare.clone()].into_iter().chain(carried).collect();
    MassProperties::merged(&parts).unwrap_or_else(|| bare.clone())
}
