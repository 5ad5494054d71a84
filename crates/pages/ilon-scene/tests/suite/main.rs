//! The tests of `ilon-scene` from outside, one module for each subject, in one program.

mod in_browser;
mod meshes;
mod robots;
mod run;
