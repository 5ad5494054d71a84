//! The tests of `ilon-sim` from outside, one module for each subject, in one program.

mod drives;
mod limits;
mod materials;
mod plant;
mod playback;
mod record;
mod similarity;
mod spin;
mod support;
