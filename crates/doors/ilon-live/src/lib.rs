//! Live runs: a robot simulated in real time, shown and driven from outside.
//!
//! A [`Session`] is the robot: a plant of `ilon-sim` that follows a user's commands or the
//! scenario's reference. A [`Server`] shows it on a browser page, in three dimensions, and accepts
//! commands from there:
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
//! The server is bound to the loopback interface. It accepts only requests for its own address, and
//! WebSockets only from its own pages, so that no other page in the browser can drive the robot.
//! The simulation never waits: slow readers miss frames, and are disconnected after a while.
//!
//! | module | content |
//! |---|---|
//! | [`control`] | commands and their limits |
//! | [`mailbox`] | queue of commands |
//! | [`session`] | the robot's motion |
//! | [`observer`] | interface of displays |
//! | [`server`] | the page, with access control |
//! | `ros2` | a ROS 2 node (feature `ros2`) |
//! | `foxglove` | a Foxglove server (feature `foxglove`) |
//! | [`clock`] | main loop and pace |
//! | [`ardupilot`] | ArduPilot's SITL, in lock step, instead of all of these |

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
mod recording;
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

/// Reasons why a live run cannot start or continue.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LiveError {
    /// An error of the scenario, or of its simulation.
    #[error(transparent)]
    Simulation(#[from] ilon_sim::Error),
    /// The server cannot listen on its port.
    #[error("cannot listen on 127.0.0.1:{port}: {reason}")]
    Listen {
        /// The port.
        port: u16,
        /// The system's error.
        reason: std::io::Error,
    },
    /// The page cannot be built.
    #[error("the page cannot be written as text: {0}")]
    Page(#[from] serde_json::Error),
}

impl From<ilon_control::ControlError> for LiveError {
    fn from(error: ilon_control::ControlError) -> Self {
        Self::Simulation(error.into())
    }
}
