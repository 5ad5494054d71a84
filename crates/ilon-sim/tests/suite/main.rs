//! The tests of `ilon-sim` from outside, one module for each subject, in one program.

mod attached;
mod contest;
mod converge;
mod drives;
mod extending;
mod ground;
mod jams;
mod joint_logs;
mod joints;
mod limits;
mod losses;
mod materials;
mod passive;
mod plant;
mod playback;
mod playback_bag;
mod record;
mod ridgeback;
mod rows;
mod similarity;
mod spheres;
mod spin;
mod stability;
mod support;
mod suspensions;
mod wheels_to_spare;
