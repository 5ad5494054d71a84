//! ilon simulates omnidirectional robots down to the rollers of their wheels.
//!
//! A [`Scenario`] names a robot, the motion asked of it and the world it stands in; [`run`] simulates it and gives back
//! the trace and its summary:
//!
//! ```no_run
//! let scenario = ilon::Scenario::load("assets/scenarios/volksbot_position_first.toml")?;
//! let run = ilon::run(&scenario)?;
//! println!("{:?} m off at the end", run.summary.position_error_final_m);
//! # Ok::<(), ilon::Error>(())
//! ```
//!
//! This crate is the command line, and a facade: what simulates is [`ilon_sim`], what draws is [`ilon_report`], and a
//! program that wants but one of them depends on that alone.
//!
//! | module | answers |
//! |---|---|
//! | [`scenario`] | what a person writes down about a run |
//! | [`simulate`] | the loop: sensors, reference, guidance, wheel loops, motors, world, trace |
//! | [`judge`] | whether a run met its `[expect]` |
//! | [`inspect`] | a robot as it is understood |
//! | [`drawing`] | a robot as a picture from above |
//! | [`mod@bench`] | how accurate and how fast the simulation is |
//! | [`report`] | the run as one page to look at |
//! | [`compare`] | several runs beside each other |
//! | [`ros2_control`] | parameters for the controllers of ros2_controllers |
//! | [`pages`] | pages that show more than a trace: measurements, robots, designs |
//! | [`cli`] | the `ilon` command |

// What is printed goes through `cli::say`, which bears closed and full streams; the macros of std panic there.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

mod answers;
pub mod bench;
pub mod cli;
pub mod pages;
pub mod ros2_control;

pub use ilon_control as control;
pub use ilon_identify as identify;
pub use ilon_messages as messages;
pub use ilon_report as report;
pub use ilon_robot as robot;
pub use ilon_sim as sim;
pub use ilon_trace as trace;
pub use ilon_world as world;

pub use ilon_report::{compare, drawing};
pub use ilon_sim::{Error, RobotFault, Run, Scenario, ScenarioFault, run};
pub use ilon_sim::{inspect, judge, scenario, simulate};
