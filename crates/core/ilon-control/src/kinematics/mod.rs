//! The relation between wheel rates and the robot's motion: Indiveri 2009, eqs. (2)-(10), with one
//! constant roller angle per wheel, and the same constraint at the roller that touches.

pub(crate) mod analysis;
pub(crate) mod contact;
pub(crate) mod handedness;
pub(crate) mod ideal;
pub(crate) mod matrix;
pub(crate) mod module;
pub(crate) mod singularity;
pub(crate) mod speeds;
pub(crate) mod turning;
pub(crate) mod tyres;
