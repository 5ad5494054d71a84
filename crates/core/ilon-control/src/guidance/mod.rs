//! References, and the guidance law that follows them within the wheels' limits: Indiveri 2009,
//! eqs. (13)-(50).

pub(crate) mod fastest;
pub(crate) mod law;
pub(crate) mod pace;
pub(crate) mod priority;
pub(crate) mod reference;
pub(crate) mod spline;
pub(crate) mod tracking;
