//! ilon simulates omnidirectional robots down to the rollers of their wheels.
//!
//! A [`Scenario`] names a robot, its commanded motion and its world; [`run`] simulates it and
//! returns the trace and its summary:
//!
//! ```no_run
//! let scenario = ilon::Scenario::load("assets/scenarios/volksbot_position_first.toml")?;
//! let run = ilon::run(&scenario)?;
//! println!("{:?} m off at the end", run.summary.position_error_final_m);
//! # Ok::<(), ilon::Error>(())
//! ```
//!
//! This crate is the command line, and a facade of the other crates: [`ilon_sim`] simulates and
//! [`ilon_report`] draws. A program that needs only one of them can depend on it alone.
//!
//! | module | answers |
//! |---|---|
//! | [`scenario`] | the input file of a run |
//! | [`simulate`] | the loop: sensors, reference, guidance, wheel loops, motors, world, trace |
//! | [`judge`] | whether a run met its `[expect]` |
//! | [`inspect`] | a robot as ilon interprets it |
//! | [`drawing`] | a robot as a picture from above |
//! | [`mod@bench`] | how accurate and how fast the simulation is |
//! | [`report`] | the run as one page |
//! | [`compare`] | several runs side by side |
//! | [`exported`] | a robot for other simulators, with the error of its motion there |
//! | [`planar`] | a robot as a planar base for planners and learners, fitted to simulated drives |
//! | [`ros2_control`] | parameters for the controllers of ros2_controllers |
//! | [`planners`] | a robot for PathPlanner, Choreo and Road Runner |
//! | [`pages`] | pages that show more than a trace: measurements, robots |
//! | [`cli`] | the `ilon` command |
//!
//! # A custom controller
//! ```
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../..")).unwrap();
//! use ilon::simulate::{Commanded, Controller, Moment, Simulation};
//! use ilon::{Scenario, robot::Twist};
//!
//! /// Drives ahead and turns left by a quarter turn per second.
//! struct Arc;
//! impl Controller for Arc {
//!     fn command(&mut self, now: &Moment<'_>, wheels: &mut [f64]) -> Commanded {
//!         now.kinematics.wheel_rates(Twist::new(0.3, 0.0, 1.57), wheels);
//!         Commanded::Rates
//!     }
//! }
//!
//! let mut scenario = Scenario::load("assets/scenarios/mecanum4_circle.toml")?;
//! scenario.run.duration_s = 2.0;
//! let run = Simulation::with_controller(&scenario, Arc)?.run();
//! println!("{:.2} m in two seconds", run.summary.travelled_m);
//! # Ok::<(), ilon::Error>(())
//! ```
//!
//! # A robot stepped from outside
//! ```
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../..")).unwrap();
//! use ilon::simulate::{Plant, WheelCommand};
//!
//! let scenario = ilon::Scenario::load("assets/scenarios/mecanum4_lateral.toml")?;
//! let mut plant = Plant::of_scenario(&scenario)?;
//! for _ in 0..50 {
//!     let seen = plant.observe();
//!     let _pose_that_a_controller_would_use = seen.pose;
//!     plant.advance(WheelCommand::Rates(&[-4.0, 4.0, 4.0, -4.0]), 0.02)?;
//! }
//! println!("{:.3} m to the left in a second", plant.truth().pose.y_m);
//! # assert!((0.15..0.2).contains(&plant.truth().pose.y_m));
//! # Ok::<(), ilon::Error>(())
//! ```
//!
//! # A custom ground
//! ```
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../..")).unwrap();
//! use ilon::simulate::{Plant, WheelCommand, load_robot, resolve};
//! use ilon::world::{Floor, Relief};
//!
//! let scenario = ilon::Scenario::load("assets/scenarios/mecanum4_lateral.toml")?;
//! let robot = load_robot(&scenario)?;
//! // Waves of 4 mm, 0.4 m long, on a square of 4 m.
//! let row: Vec<f64> = (0..81).map(|k| 0.002 * (f64::from(k) * 0.785).sin()).collect();
//! let relief = Relief { cell_m: 0.05, center_m: Default::default(), heights_m: vec![row; 81] };
//! let floor = Floor { friction: 0.4, relief: Some(relief), ..Floor::default() };
//! let mut plant = Plant::on_floor(&resolve(&scenario, &robot)?, &robot, floor)?;
//! plant.advance(WheelCommand::Rates(&[6.0; 4]), 2.0)?;
//! println!("{:.2} m ahead over the waves", plant.truth().pose.x_m);
//! # assert!(plant.truth().pose.x_m > 0.4);
//! # Ok::<(), ilon::Error>(())
//! ```
//!
//! # Two robots
//! ```
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../..")).unwrap();
//! use ilon::formats::LoadRobot;
//! use ilon::robot::{Pose, Robot};
//! use ilon::world::{Floor, MotorTorque, Settings, SharedRobot, World};
//!
//! let robot = SharedRobot::from(&Robot::load("assets/robots/mecanum4.urdf")?);
//! let ahead = Pose { x_m: 0.6, ..Pose::default() };
//! let robots = [(robot.clone(), Pose::default()), (robot, ahead)];
//! let mut world = World::of_bodies(robots, &Floor::default(), &Settings::default())?;
//! let [pushes, pushed] = [0, 1].map(|k| world.bodies().nth(k).expect("two"));
//! while world.time_s() < 2.0 {
//!     world.body_mut(pushes).drive(&[MotorTorque::constant(0.3); 4]);
//!     world.step();
//! }
//! println!("pushed to x = {:.2} m", world.body(pushed).state().pose.x_m);
//! # assert!(world.body(pushed).state().pose.x_m > 0.61);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # User bodies
//! ```
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../..")).unwrap();
//! use ilon::simulate::{Plant, WheelCommand};
//! use ilon::world::rapier3d::prelude::*;
//!
//! let scenario = ilon::Scenario::load("assets/scenarios/mecanum4_lateral.toml")?;
//! let mut plant = Plant::of_scenario(&scenario)?;
//! let rapier = plant.rapier_mut()?;
//! let place = |x| RigidBodyBuilder::dynamic().translation(Vector::new(x, 0.0, 0.1));
//! let shape = || ColliderBuilder::cuboid(0.1, 0.1, 0.1).mass(1.0).friction(0.3);
//! let (cart, _) = rapier.insert(place(0.5), shape());
//! let (trailer, _) = rapier.insert(place(0.8), shape());
//! let hitch = SphericalJointBuilder::new().local_anchor1(Vector::X * 0.15).local_anchor2(-Vector::X * 0.15);
//! rapier.insert_impulse_joint(cart, trailer, hitch);
//! plant.advance(WheelCommand::Rates(&[6.0; 4]), 2.0)?;
//! let rapier = plant.world().rapier().expect("it was asked for");
//! println!("the trailer is at x = {:.2} m", rapier.bodies[trailer].translation().x);
//! # assert!(rapier.bodies[trailer].translation().x > 0.85);
//! # Ok::<(), ilon::Error>(())
//! ```
//!
//! # Reading a trace
//! ```
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../..")).unwrap();
//! # let mut scenario = ilon::Scenario::load("assets/scenarios/mecanum4_lateral.toml")?;
//! # scenario.run.duration_s = 1.5;
//! # let folder = std::env::temp_dir().join(format!("ilon-doc-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder)?;
//! # let path = folder.join("trace.parquet");
//! # ilon::run(&scenario)?.trace.write_parquet(&path)?;
//! let trace = ilon::trace::Trace::read_parquet(&path)?;
//! let row_s = trace.header.row_dt_s();
//! for (k, wheel) in trace.header.wheels.iter().enumerate() {
//!     let slid_m: f64 = trace.wheel(k).map(|at| at.slip_speed_m_s() * row_s).sum();
//!     println!("{} slid {:.1} mm", wheel.name, 1e3 * slid_m);
//! }
//! # std::fs::remove_dir_all(&folder)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// Printing goes through `cli::console`, which tolerates closed and full streams; the macros of std
// panic on them.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

#[cfg(feature = "command")]
pub mod bench;
#[cfg_attr(
    not(feature = "command"),
    allow(dead_code, reason = "what only the command says and writes")
)]
pub mod cli;
pub mod exported;
pub mod planar;
pub mod planners;
pub mod ros2_control;

pub use ilon_control as control;
pub use ilon_files as files;
pub use ilon_formats as formats;
pub use ilon_identify as identify;
pub use ilon_messages as messages;
pub use ilon_report as report;
pub use ilon_robot as robot;
pub use ilon_sim as sim;
pub use ilon_sweep as sweep;
pub use ilon_trace as trace;
pub use ilon_world as world;

pub use ilon_report::{compare, drawing, pages};
pub use ilon_sim::{Causes, Error, RobotFault, Run, Scenario, ScenarioFault, run};
pub use ilon_sim::{inspect, judge, scenario, simulate};
