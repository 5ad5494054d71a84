//! The viewer's playback controls: play, pause, speed, and back to the start.
//!
//! The protocol is made for recordings, which have an end and allow any position. A simulation's
//! timeline is the scenario's, from its start over its duration, and it can only seek to the start.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use foxglove::websocket::{PlaybackCommand, PlaybackControlRequest, PlaybackState, PlaybackStatus};

use crate::control::{Change, Controls};
use crate::mailbox::{Mailbox, locked};

/// A seek to a time up to this in a drive means its start, within the precision of pointing.
const START_NS: u64 = 500_000_000;

/// The position of a live run in its timeline, and the state last sent to viewers.
#[derive(Debug)]
pub(super) struct Playback {
    desk: Mailbox,
    /// Time in this drive, in ns.
    now_ns: AtomicU64,
    told: Mutex<Option<(bool, f64)>>,
    is_back: AtomicBool,
}

impl Playback {
    pub fn new(desk: Mailbox) -> Self {
        Self {
            desk,
            now_ns: AtomicU64::new(0),
            told: Mutex::default(),
            is_back: AtomicBool::new(false),
        }
    }

    /// Sets the time in this drive, in seconds; returns it in nanoseconds.
    pub fn set_time(&self, t_s: f64) -> u64 {
        let now_ns = (t_s * 1e9) as u64;
        self.now_ns.store(now_ns, Ordering::Relaxed);
        now_ns
    }

    /// Records that the robot is back at its start.
    pub fn restarted(&self) {
        self.now_ns.store(0, Ordering::Relaxed);
        self.is_back.store(true, Ordering::Relaxed);
    }

    /// Forgets the sent state, for a new client.
    pub fn forget_told(&self) {
        *locked(&self.told) = None;
    }

    /// Returns the state to send to viewers, if it changed.
    pub fn changed(&self, controls: &Controls) -> Option<PlaybackState> {
        let mut told = locked(&self.told);
        let now = Some((controls.paused, controls.speed));
        let is_back = self.is_back.swap(false, Ordering::Relaxed);
        if *told == now && !is_back {
            return None;
        }
        *told = now;
        Some(self.state(controls, is_back))
    }

    /// Executes a viewer's request; returns the state after it, and a note.
    pub fn take(&self, request: &PlaybackControlRequest) -> (PlaybackState, Option<String>) {
        let mut said = Vec::new();
        let now_ns = self.now_ns.load(Ordering::Relaxed);
        let seek = request.seek_time.filter(|seek_ns| *seek_ns != now_ns);
        let is_back = seek.is_some_and(|seek_ns| seek_ns < now_ns);
        match seek {
            Some(seek_ns) if seek_ns > now_ns => said.push(
                "a simulation cannot leap ahead: raise the speed, or wait until it is there"
                    .to_owned(),
            ),
            Some(seek_ns) if seek_ns > START_NS => said.push(
                "a simulation goes back to no moment but its start: the robot is there now"
                    .to_owned(),
            ),
            _ => {}
        }
        said.extend(self.desk.change(&Change {
            paused: Some(request.playback_command == PlaybackCommand::Pause),
            speed: Some(as_written(request.playback_speed)),
            reset: Some(is_back),
            ..Change::default()
        }));
        if is_back {
            self.now_ns.store(0, Ordering::Relaxed);
        }
        let state = self.state(&self.desk.controls(), is_back);
        (state, (!said.is_empty()).then(|| said.join("; ")))
    }

    fn state(&self, controls: &Controls, did_seek: bool) -> PlaybackState {
        PlaybackState {
            status: if controls.paused {
                PlaybackStatus::Paused
            } else {
                PlaybackStatus::Playing
            },
            current_time: self.now_ns.load(Ordering::Relaxed),
            playback_speed: controls.speed as f32,
            did_seek,
            request_id: None,
        }
    }
}

/// Returns the f64 with the same shortest decimal: 0.1 of single precision means 0.1.
fn as_written(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::NAN)
}
