//! `ilon live`: a robot that is driven while it is simulated, from a page in the browser.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use ilon_live::{LiveError, Pace, Server, Session};

use super::{Outcome, Sandbox, Settings, say};
use crate::Scenario;
use crate::cli::failure::Failure;

/// Arguments of `ilon live`.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario file: robot, world and, to be followed on request, its reference.
    scenario: PathBuf,
    /// Where the page is served, on this machine alone; 0 for any port that is free.
    #[arg(long, default_value_t = 8765)]
    port: u16,
    /// Simulated seconds a second.
    #[arg(long, default_value_t = 1.0, value_name = "X", value_parser = speed)]
    speed: f64,
    /// End after this many seconds; without it, when it is interrupted.
    #[arg(long, value_name = "SECONDS", value_parser = speed)]
    seconds: Option<f64>,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    sandbox: Sandbox,
}

fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number <= 1e6 => Ok(number),
        _ => Err("give a number above 0".to_owned()),
    }
}

/// Simulates until it is interrupted.
pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Failure> {
    let files = arguments.sandbox.files()?;
    let scenario =
        Scenario::load_within(&arguments.scenario, &arguments.settings.settings, &files)?;
    let mut session = Session::new(&scenario).map_err(failure)?;
    let server = Server::start(arguments.port, &session).map_err(failure)?;
    say::lines(&format!("drive at {}  (end with Ctrl-C)\n", server.url()))?;
    let pace = Pace {
        speed: arguments.speed.clamp(0.05, 20.0),
    };
    let end = arguments
        .seconds
        .map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
    ilon_live::run(&mut session, &server, pace, || {
        end.is_none_or(|end| Instant::now() < end)
    })
    .map_err(failure)?;
    Ok(Outcome::Done)
}

fn failure(error: LiveError) -> Failure {
    match error {
        LiveError::Simulation(error) => error.into(),
        LiveError::Listen { .. } => Failure::usage(
            error.to_string(),
            "choose another port with --port, or 0 for any that is free",
        ),
        other => Failure::encode("the page", &other),
    }
}
