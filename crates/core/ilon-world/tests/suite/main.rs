//! The integration tests of `ilon-world`, one module per subject, in one binary.

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
