//! The C interface returns the plant's values bit for bit, and every misuse returns a status code.

#![allow(
    unsafe_code,
    reason = "the functions under test are those that C calls"
)]

mod cost;
mod examples;
#[cfg(target_pointer_width = "64")]
mod fmu;
mod gz;
mod header;
mod misuse;
mod same;
mod support;
