//! Where the robot should be, and which wheel rates bring it there within their limits: Indiveri 2009, eqs. (13)-(50).

pub(crate) mod fastest;
pub(crate) mod law;
pub(crate) mod pace;
pub(crate) mod priority;
pub(crate) mod reference;
pub(crate) mod spline;
