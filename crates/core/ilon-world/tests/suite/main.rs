//! The tests of `ilon-world` from outside, one module for each subject, in one program.

mod axles;
mod bodies;
mod chassis_on_relief;
mod disturbances;
mod fast;
mod free;
mod free_world;
mod in_turn;
mod joints;
mod laws;
mod losses;
mod motors;
mod nap;
mod on_the_brink;
mod play;
mod reach;
mod reference;
mod rollers_as_made;
mod rolling;
mod servos;
mod start;
mod support;
mod tread;
mod user_bodies;
mod validation;
mod window;
