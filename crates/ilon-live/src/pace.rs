//! How fast time goes.

use std::time::{Duration, Instant};

use crate::LiveError;
use crate::server::Server;
use crate::session::Session;

/// Frames for each second that passes, whatever the pace of the simulation: as many as a screen shows.
const FRAMES: Duration = Duration::from_nanos(16_666_667);
/// Figures come less often, so that a person can read them.
const FIGURES: Duration = Duration::from_millis(100);
/// What the simulation falls behind further is left out, so that it does not hurry afterwards.
const MOST_BEHIND: Duration = Duration::from_millis(200);
/// How long to sleep while time stands.
const STANDING: Duration = Duration::from_millis(20);

/// How fast a live run goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Simulated seconds a second, where the page says nothing else.
    pub speed: f64,
}

impl Default for Pace {
    /// Real time.
    fn default() -> Self {
        Self { speed: 1.0 }
    }
}

/// Drives the session by what comes from the server, and shows it there, until `go_on` says otherwise.
///
/// # Errors
/// Where the simulation cannot go on at all.
pub fn run(
    session: &mut Session,
    server: &Server,
    pace: Pace,
    mut go_on: impl FnMut() -> bool,
) -> Result<(), LiveError> {
    server.set_speed(pace.speed);
    let mut due = Instant::now();
    let (mut frame_due, mut figures_due) = (due, due);
    // Of the last second: simulated, and passed.
    let (mut simulated_s, mut since) = (0.0, Instant::now());
    let mut real_time_factor = 0.0;
    while go_on() {
        let controls = server.controls();
        if controls.paused {
            due = Instant::now();
            std::thread::sleep(STANDING);
        } else {
            match session.advance(&controls) {
                Ok(()) => simulated_s += session.control_dt_s(),
                Err(LiveError::Simulation(error)) => {
                    server.say(&format!("{error}; it starts again"))
                }
                Err(other) => return Err(other),
            }
            due += Duration::from_secs_f64(session.control_dt_s() / controls.speed);
        }
        let now = Instant::now();
        if now >= frame_due && server.has_clients() {
            frame_due = now + FRAMES;
            server.show(session.frame().bytes());
        }
        if now >= figures_due {
            figures_due = now + FIGURES;
            if since.elapsed() > Duration::from_secs(1) {
                real_time_factor = simulated_s / since.elapsed().as_secs_f64();
                (simulated_s, since) = (0.0, now);
            }
            server.report(&session.figures(&controls), real_time_factor);
        }
        if due > now {
            std::thread::sleep(due - now);
        } else if now - due > MOST_BEHIND {
            due = now;
        }
    }
    Ok(())
}
