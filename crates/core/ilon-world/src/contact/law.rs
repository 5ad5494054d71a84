//! The impulses of a step: those of the ground and of dry bearings on a robot, solved to a
//! tolerance.
//!
//! Sweeps over a robot's degrees of freedom are expensive and converge slowly, because a roller is
//! light across its axis (it spins) and heavy along it (it carries the robot). Here the problem is
//! formulated in the impulses alone, which makes a direct solution cheap:
//!
//! u = u_free + W p, with u the velocities at the impulses p, and W the Delassus matrix: the
//! velocity change at one place per unit impulse at another. Each impulse obeys a law:
//!
//! - *contact*, Signorini: p_n >= 0, u_n + b + c p_n >= 0, one of them 0 (b from the gap, c the
//!   compliance of the contact);
//! - *contact*, Coulomb: |p_t| <= mu p_n; it sticks, or p_t is at its limit and opposes the sliding
//!   u_t;
//! - *joint*: least <= p <= most; it sticks, or p is at its limit and opposes the rotation;
//! - *disc*: |p| <= most, over two rows; it sticks, or p is at its limit and opposes the motion;
//! - *slide*, between two stops: least <= u <= most, and p = 0 except at a stop, from which it
//!   pushes;
//! - *curve*: (u, p) lies on a piecewise linear curve along which the velocity grows: a motor at
//!   its limits with its gear.
//!
//! `kinds` has the laws, `system` the quantities that they relate, `residual` the violation of the
//! laws, `solver` the solution.

mod anisotropy;
mod compliant;
mod curve;
mod kinds;
mod newton;
mod residual;
mod solver;
mod splitting;
mod system;
#[cfg(test)]
mod tests;
pub(crate) mod tread;

pub(crate) use curve::Curve;
pub(crate) use kinds::Law;
pub(crate) use solver::{Solver, SolverEffort};
pub(crate) use system::ImpulseProblem;
