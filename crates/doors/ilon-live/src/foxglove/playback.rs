//! The viewer's controls of time: play, pause, how fast, and back to the start.
//!
//! The protocol means them for a recording, which has a beginning and an end and can be shown from any moment. A simulation lies ahead: its
//! timeline is the scenario's, from its start over its duration, and the one moment to which it goes back is the start.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use foxglove::websocket::{PlaybackCommand, PlaybackControlRequest, PlaybackState, PlaybackStatus};

use crate::control::{Change, Controls};
use crate::mailbox::{Mailbox, locked};

/// A seek to a moment that is no later than this in a drive is one to its start, as far as a person can point at it.
const START_NS: u64 = 500_000_000;

/// Where a live run stands in its timeline, and what its viewers were told of that.
#[derive(Debug)]
pub(super) struct Playback {
    desk: Mailbox,
    /// Time in this drive.
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

    /// Sets the time in this drive, in seconds; gives it in nanoseconds.
    pub fn set_time(&self, t_s: f64) -> u64 {
        let now_ns = (t_s * 1e9) as u64;
        self.now_ns.store(now_ns, Ordering::Relaxed);
        now_ns
    }

    /// The robot is back at its start.
    pub fn restarted(&self) {
        self.now_ns.store(0, Ordering::Relaxed);
        self.is_back.store(true, Ordering::Relaxed);
    }

    /// Somebody comes who knows nothing yet.
    pub fn forget_told(&self) {
        *locked(&self.told) = None;
    }

    /// What the viewers are to be told, where that has changed.
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

    /// Does what a viewer asks for; gives the state after it, and what there is to say about it.
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

/// The number whose shortest decimal this is: 0.1 of single precision is meant as 0.1.
fn as_written(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::NAN)
}
