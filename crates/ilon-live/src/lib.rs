//! Who listens in, and who drives: a robot that is simulated in real time, seen and driven from outside.
//!
//! A [`Session`] is the robot: a plant of `ilon-sim` that follows a person's commands or the scenario's reference. A [`Server`] shows it
//! on a page of the browser, in three dimensions, and takes commands from there:
//!
//! ```no_run
//! use ilon_live::{Pace, Server, Session};
//!
//! let scenario = ilon_sim::Scenario::load("assets/scenarios/mecanum4_circle.toml")?;
//! let mut session = Session::new(&scenario)?;
//! let server = Server::start(8765, &session)?;
//! println!("{}", server.url());
//! ilon_live::run(&mut session, &server, Pace::default(), || true)?;
//! # Ok::<(), ilon_live::LiveError>(())
//! ```
//!
//! The server is bound to the loopback interface. It takes requests for its own address alone, and WebSockets from pages of its own
//! alone, so that no other page of the browser can drive the robot. The simulation waits for nobody: who reads too slowly misses
//! frames, and after a while is sent away.
//!
//! | module | answers |
//! |---|---|
//! | [`control`] | what a page may say, and within which limits it counts |
//! | [`session`] | how the robot moves meanwhile |
//! | [`server`] | who is let in |
//! | [`pace`] | how fast time goes |

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

pub mod control;
pub mod pace;
mod page;
pub mod server;
pub mod session;

pub use control::{Controls, Mode};
pub use pace::{Pace, run};
pub use server::Server;
pub use session::Session;

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
