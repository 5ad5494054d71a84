//! The mailbox for commands from all sources.

use std::collections::VecDeque;
use std::fmt;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::control::{Change, Controls};

/// Largest number of queued notes; further ones are dropped.
const MOST_NOTES: usize = 16;
/// Largest number of queued step requests.
const MOST_REQUESTS: usize = 64;

/// Commands shared by all sources: a page, a ROS 2 node, a viewer. Clones share the same state.
#[derive(Clone, Debug, Default)]
pub struct Mailbox(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    called: Condvar,
}

#[derive(Debug, Default)]
struct State {
    controls: Controls,
    steps: VecDeque<Steps>,
    notes: VecDeque<String>,
}

/// A request for control periods while time stands, with a callback at the end.
pub(crate) struct Steps {
    pub left: u64,
    pub done: Box<dyn FnOnce(Result<(), String>) + Send>,
}

impl fmt::Debug for Steps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} steps", self.left)
    }
}

/// Locks a mutex, even if a thread panicked while it held the lock.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Mailbox {
    fn state(&self) -> MutexGuard<'_, State> {
        // The state is consistent even after a panic, because no change is partial.
        locked(&self.0.state)
    }

    /// The current commands.
    pub fn controls(&self) -> Controls {
        self.state().controls.clone()
    }

    /// Applies a change; returns a note, if any.
    pub fn change(&self, change: &Change) -> Option<String> {
        let said = self.state().controls.change(change);
        self.0.called.notify_all();
        said
    }

    /// Applies a message, like [`Controls::take`].
    pub fn take(&self, text: &str) -> Option<String> {
        let said = self.state().controls.take(text);
        self.0.called.notify_all();
        said
    }

    /// Requests a number of control periods while time stands; `done` receives the result.
    pub fn step(&self, count: u64, done: impl FnOnce(Result<(), String>) + Send + 'static) {
        let mut state = self.state();
        let refused = if !state.controls.paused {
            Some("time goes on: pause it first")
        } else if state.steps.len() >= MOST_REQUESTS {
            Some("too many requests wait")
        } else {
            None
        };
        if let Some(why) = refused {
            drop(state);
            return done(Err(why.to_owned()));
        }
        state.steps.push_back(Steps {
            left: count,
            done: Box::new(done),
        });
        self.0.called.notify_all();
    }

    /// Returns the next request for steps, if any.
    pub(crate) fn next_steps(&self) -> Option<Steps> {
        self.state().steps.pop_front()
    }

    /// Sends a note to all observers.
    pub fn say(&self, note: impl Into<String>) {
        let (mut state, note) = (self.state(), note.into());
        if state.notes.len() < MOST_NOTES && !state.notes.contains(&note) {
            state.notes.push_back(note);
        }
    }

    /// Returns the notes since the last call.
    pub(crate) fn take_notes(&self) -> VecDeque<String> {
        std::mem::take(&mut self.state().notes)
    }

    /// Waits for the next command, at most for a time.
    pub(crate) fn wait(&self, at_most: Duration) {
        let state = self.state();
        if state.steps.is_empty() {
            drop(self.0.called.wait_timeout(state, at_most));
        }
    }
}
