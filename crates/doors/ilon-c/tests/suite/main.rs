//! The C border: what a program of C gets is what the plant gives, to the bit, and whatever it does wrong is a code.

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
