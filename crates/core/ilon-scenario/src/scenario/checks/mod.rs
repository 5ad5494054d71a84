//! Checks across a scenario's keys: within its text
//! ([`Scenario::validate`](super::Scenario::validate)), and for its robot and step.

mod material_check;
pub(super) mod objection;
mod resolvable;
mod validate;
