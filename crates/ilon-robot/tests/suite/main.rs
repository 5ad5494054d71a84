//! The tests of `ilon-robot` from outside, one module for each subject, in one program.

mod assets;
mod assets_load;
mod clues;
mod collection;
mod common;
mod described;
mod faults;
mod formats;
mod looks;
mod made;
mod round_trip;
mod standing;
mod strangers;
mod traits;
mod xacro;
