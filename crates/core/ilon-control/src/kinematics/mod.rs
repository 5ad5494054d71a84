//! How wheel rates and the robot's motion belong together: Indiveri 2009, eqs. (2)-(10), with one constant roller angle a
//! wheel, and the same constraint taken at the roller that touches.

pub(crate) mod analysis;
pub(crate) mod contact;
pub(crate) mod handedness;
pub(crate) mod ideal;
pub(crate) mod matrix;
pub(crate) mod singularity;
