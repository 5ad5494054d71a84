//! The main loop of a live run, with its pace.

use std::ops::RangeInclusive;
use std::time::{Duration, Instant};

use crate::LiveError;
use crate::control::{self, Change};
use crate::mailbox::{Mailbox, Steps};
use crate::observer::{Observer, Status};
use crate::session::Session;

use smart_default::SmartDefault;

/// A larger lag of the simulation is dropped, so that it does not catch up afterwards.
const MOST_BEHIND: Duration = Duration::from_millis(200);
/// Sleep time while time stands and no command arrives.
const STANDING: Duration = Duration::from_millis(20);

/// Initial pace of a live run.
#[derive(Clone, Copy, Debug, SmartDefault, PartialEq)]
pub struct Pace {
    /// Simulated seconds per second, until changed.
    #[default = 1.0]
    pub speed: f64,
    /// Whether time stands at first.
    pub paused: bool,
}

impl Pace {
    /// Allowed speeds of a live run.
    pub const SPEEDS: RangeInclusive<f64> = control::SPEEDS;
}

/// Runs the session with the commands of the mailbox, and updates the observers, until `go_on`
/// returns false. A recording that is still on is then written.
///
/// # Errors
/// If the simulation cannot continue.
pub fn run(
    session: &mut Session,
    desk: &Mailbox,
    watchers: &mut [&mut dyn Observer],
    pace: Pace,
    go_on: impl FnMut() -> bool,
) -> Result<(), LiveError> {
    let said = desk.change(&Change {
        speed: Some(pace.speed),
        paused: Some(pace.paused),
        ..Change::default()
    });
    if let Some(note) = said {
        desk.say(note);
    }
    let ended = simulate(session, desk, watchers, go_on);
    session.end_recording();
    for note in session.take_notes() {
        watchers.iter_mut().for_each(|watcher| watcher.say(&note));
    }
    ended
}

fn simulate(
    session: &mut Session,
    desk: &Mailbox,
    watchers: &mut [&mut dyn Observer],
    mut go_on: impl FnMut() -> bool,
) -> Result<(), LiveError> {
    let mut due = Instant::now();
    // Simulated and elapsed time of the last second.
    let (mut simulated_s, mut since) = (0.0, Instant::now());
    let mut real_time_factor = 0.0;
    let mut restarts = session.restarts();
    let mut steps: Option<Steps> = None;
    while go_on() {
        let controls = desk.controls();
        steps = steps.or_else(|| desk.next_steps());
        session.go_back(&controls)?;
        notice_restart(session, &mut restarts, watchers);
        let is_stepped = controls.paused && steps.as_ref().is_some_and(|steps| steps.left > 0);
        if is_stepped || !controls.paused {
            match session.advance(&controls) {
                Ok(()) => simulated_s += session.control_dt_s(),
                Err(LiveError::Simulation(error)) => desk.say(format!("{error}; it starts again")),
                Err(other) => return Err(other),
            }
            notice_restart(session, &mut restarts, watchers);
            if let Some(row) = session.row() {
                watchers.iter_mut().for_each(|watcher| watcher.row(row));
            }
            session.take_notes().for_each(|note| desk.say(note));
            due += Duration::from_secs_f64(session.control_dt_s() / controls.speed);
        }
        if let Some(mut asked) = steps.take() {
            asked.left = asked.left.saturating_sub(u64::from(is_stepped));
            if !controls.paused {
                (asked.done)(Err("time went on meanwhile".to_owned()));
            } else if asked.left == 0 {
                (asked.done)(Ok(()));
            } else {
                steps = Some(asked);
            }
        }
        let now = Instant::now();
        if since.elapsed() > Duration::from_secs(1) {
            real_time_factor = simulated_s / since.elapsed().as_secs_f64();
            (simulated_s, since) = (0.0, now);
        }
        let status = Status {
            controls: &controls,
            real_time_factor,
        };
        let notes = desk.take_notes();
        for watcher in watchers.iter_mut() {
            notes.iter().for_each(|note| watcher.say(note));
            watcher.look(session, status);
        }
        if controls.paused {
            due = now;
            if steps.is_none() {
                desk.wait(STANDING);
            }
        } else if due > now {
            std::thread::sleep(due - now);
        } else if now - due > MOST_BEHIND {
            due = now;
        }
    }
    Ok(())
}

/// Notifies the observers when the robot is back at its start.
fn notice_restart(session: &Session, restarts: &mut u64, watchers: &mut [&mut dyn Observer]) {
    if session.restarts() != *restarts {
        *restarts = session.restarts();
        watchers
            .iter_mut()
            .for_each(|watcher| watcher.restarted(session));
    }
}
