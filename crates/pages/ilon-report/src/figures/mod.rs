//! The figures of the report, by topic.

pub(super) mod balance;
pub(super) mod causes;
pub(super) mod contacts;
pub(super) mod motion;
pub(super) mod rollers;
pub(super) mod wheels;
