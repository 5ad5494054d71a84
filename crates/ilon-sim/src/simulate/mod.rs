//! The loop: a plant, what drives it, and what records it.

mod clock;
mod command;
mod defaults;
mod disturbances;
mod drive;
mod faults;
mod floor;
mod fusion;
mod header;
mod imu;
mod load;
mod noise;
mod pilot;
mod plant;
mod playback;
mod recorder;
mod reference;
mod resolve;
mod run;
mod sensors;
mod simulation;
mod stability;
mod storage;
mod surface;
mod tilt;
mod timed_patch;
mod twist_profile;
mod warnings;
mod waypoints;
mod wheel_loop;

pub use ilon_world::WheelContact;

pub use clock::CpuTime;
pub use command::{Commanded, Decided, WheelCommand};
pub use floor::relief_heights_m;
pub use load::{load, load_file, load_robot};
pub use pilot::{Controller, Moment};
pub use plant::{Outcome, Plant, Snapshot};
pub use recorder::Recorder;
pub use resolve::{Driver, Resolved, resolve, resolve_for};
pub use run::{Progress, Run};
pub use sensors::Seen;
pub use simulation::{Simulation, run};
pub use twist_profile::TwistProfile;
