//! The tests of `ilon-sim` from outside, one module for each subject, in one program.

mod attached;
mod contest;
mod drives;
mod extending;
mod ground;
mod jams;
mod joint_logs;
mod joints;
mod limits;
mod materials;
mod passive;
mod plant;
mod playback;
mod playback_bag;
mod record;
mod ridgeback;
mod similarity;
mod spheres;
mod spin;
mod stability;
mod support;
mod suspensions;
