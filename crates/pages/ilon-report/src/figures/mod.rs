//! The figures of the report, by what they answer.

pub(super) mod balance;
pub(super) mod causes;
pub(super) mod contacts;
pub(super) mod motion;
pub(super) mod rollers;
pub(super) mod wheels;
