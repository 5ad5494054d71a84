//! Runs: a plant, its driver and its recorder, from the start to the figures.

mod remarks;
mod run;
mod simulation;

pub use ilon_world::{WheelContact, WheelTally};

pub use crate::design::design;
pub use ilon_plant::clock::CpuTime;
pub use ilon_plant::ground::floor::relief_heights_m;
pub use ilon_plant::limits::{Limit, LimitOutline, LimitRow, Limits, OutlinePoint};
pub use ilon_plant::pilot::{Controller, Followed, Moment, Pilot, TwistProfile, guidance};
pub use ilon_plant::record::recorder::Recorder;
pub(crate) use ilon_plant::record::run_loop::RunLoop;
pub use ilon_plant::resolve::{Driver, resolve, resolve_for};
pub use ilon_plant::sensing::sensors::Measurements;
pub use ilon_plant::{Outcome, Plant, Snapshot};
pub use ilon_scenario::Resolved;
pub use ilon_scenario::course::command::{Commanded, Decided, JointCommand, WheelCommand};
pub use ilon_scenario::robot::{load, load_file, load_robot};
pub use remarks::gathered;
pub use run::{Progress, Run};
pub use simulation::{Simulation, run};
