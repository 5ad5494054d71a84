//! Who listens in, and who drives: a robot that is simulated in real time, seen and driven from outside.
//!
//! A [`Session`] is the robot: a plant of `ilon-sim` that follows a person's commands or the scenario's reference. A [`Server`] shows it
//! on a page of the browser, in three dimensions, and takes commands from there:
//!
//! ```no_run
//! use ilon_live::{Mailbox, Pace, Server, Session};
//!
//! let scenario = ilon_sim::Scenario::load("assets/scenarios/mecanum4_circle.toml")?;
//! let mut session = Session::new(&scenario)?;
//! let desk = Mailbox::default();
//! let mut server = Server::start(8765, &session, &desk)?;
//! println!("{}", server.url());
//! ilon_live::run(&mut session, &desk, &mut [&mut server], Pace::default(), || true)?;
//! # Ok::<(), ilon_live::LiveError>(())
//! ```
//!
//! The server is bound to the loopback interface. It takes requests for its own address alone, and WebSockets from pages of its own
//! alone, so that no other page of the browser can drive the robot. The simulation waits for nobody: who reads too slowly misses
//! frames, and after a while is sent away.
//!
//! | module | answers |
//! |---|---|
//! | [`control`] | what those who drive may say, and within which limits it counts |
//! | [`mailbox`] | where they put it |
//! | [`session`] | how the robot moves meanwhile |
//! | [`observer`] | who looks on |
//! | [`server`] | the page: who is let in |
//! | `ros2` | a node of ROS 2 (feature `ros2`) |
//! | `foxglove` | a server for Foxglove (feature `foxglove`) |
//! | [`clock`] | how fast time goes |
//! | [`ardupilot`] | ArduPilot's SITL, in lock step, in place of all of these |

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

pub mod ardupilot;
pub mod clock;
#[cfg(any(feature = "ros2", feature = "foxglove"))]
#[cfg_attr(
    not(feature = "ros2"),
    allow(
        dead_code,
        reason = "viewers send neither joint states nor stamps of the simulated time"
    )
)]
mod commands;
pub mod control;
#[cfg(feature = "foxglove")]
pub mod foxglove;
pub mod mailbox;
pub mod observer;
mod page;
#[cfg(any(feature = "ros2", feature = "foxglove"))]
mod parameters;
#[cfg(feature = "ros2")]
pub mod ros2;
pub mod server;
pub mod session;
#[cfg(any(feature = "ros2", feature = "foxglove"))]
mod throttle;
#[cfg(any(feature = "ros2", feature = "foxglove"))]
mod topics;

pub use clock::{Pace, run};
pub use control::{Change, Controls, Mode};
pub use mailbox::Mailbox;
pub use observer::{Observer, Status};
pub use server::Server;
pub use session::{Row, Session};

/// Why a live run cannot begin or go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LiveError {
    /// The scenario, or the simulation of it.
    #[error(transparent)]
    Simulation(#[from] ilon_sim::Error),
    /// The server cannot listen.
    #[error("cannot listen on 127.0.0.1:{port}: {reason}")]
    Listen {
        /// The port.
        port: u16,
        /// Why, in the system's words.
        reason: std::io::Error,
    },
    /// The page cannot be made.
    #[error("the page cannot be written as text: {0}")]
    Page(#[from] serde_json::Error),
}

impl From<ilon_control::ControlError> for LiveError {
    fn from(error: ilon_control::ControlError) -> Self {
        Self::Simulation(error.into())
    }
}
