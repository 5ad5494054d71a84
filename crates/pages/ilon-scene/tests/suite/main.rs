//! The tests of `ilon-scene` from outside, one module per subject, in one program.

mod in_browser;
mod meshes;
mod page;
mod robots;
mod run;
