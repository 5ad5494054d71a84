//! The impulses of a step: what the ground and dry bearings do to a robot, solved to the end.
//!
//! A sweep through a robot's degrees of freedom is dear and converges slowly, because a roller is light across its axis
//! (it spins) and heavy along it (it carries the robot). Here the problem is written down between the impulses alone,
//! where a direct solution costs next to nothing:
//!
//! u = u_free + W p, with u the velocities where the impulses p act and W the Delassus matrix, what a unit impulse at one
//! place does to the velocity at another, and a law for each of them:
//!
//! - *contact*, Signorini: p_n >= 0, u_n + b + c p_n >= 0, one of them 0 (b is the gap's, c the compliance of the
//!   contact);
//! - *contact*, Coulomb: |p_t| <= mu p_n; it sticks, or p_t is as large as it may be and opposes the sliding u_t;
//! - *joint*: least <= p <= most; it sticks, or p is as large as it may be and opposes the turning;
//! - *disc*: |p| <= most, over two rows; it sticks, or p is as large as it may be and opposes the motion;
//! - *slide*, between two stops: least <= u <= most, and p = 0 but at a stop, from which it pushes;
//! - *curve*: (u, p) lies on a curve of straight pieces along which velocity grows: a motor at its bounds with its gear.
//!
//! `kinds` has the laws, `system` the numbers that they hold between, `residual` what is missing from them, `solver` what finds the impulses.

mod anisotropy;
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
