//! Where all who drive put what they say.

use std::collections::VecDeque;
use std::fmt;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::control::{Change, Controls};

/// The most notes that wait to be passed on; what comes beyond is dropped.
const MOST_NOTES: usize = 16;
/// The most requests for steps that wait.
const MOST_REQUESTS: usize = 64;

/// What all who drive share: a page, a node of ROS 2, a viewer. A clone is the same desk.
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

/// Control periods to go on by while time stands, and whom to tell then.
pub(crate) struct Steps {
    pub left: u64,
    pub done: Box<dyn FnOnce(Result<(), String>) + Send>,
}

impl fmt::Debug for Steps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} steps", self.left)
    }
}

/// What a lock holds, also after a thread broke down with it.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Mailbox {
    fn state(&self) -> MutexGuard<'_, State> {
        // A thread that broke down while it held it has left something whole, for nothing is changed by parts.
        locked(&self.0.state)
    }

    /// What was said last.
    pub fn controls(&self) -> Controls {
        self.state().controls.clone()
    }

    /// Makes a change; gives what there is to say about it.
    pub fn change(&self, change: &Change) -> Option<String> {
        let said = self.state().controls.change(change);
        self.0.called.notify_all();
        said
    }

    /// Takes a message, as [`Controls::take`] does.
    pub fn take(&self, text: &str) -> Option<String> {
        let said = self.state().controls.take(text);
        self.0.called.notify_all();
        said
    }

    /// Goes on by some control periods while time stands, and tells of it when that is done, or why it cannot be.
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

    /// The next request for steps, if there is one.
    pub(crate) fn next_steps(&self) -> Option<Steps> {
        self.state().steps.pop_front()
    }

    /// Says something to all who look on.
    pub fn say(&self, note: impl Into<String>) {
        let (mut state, note) = (self.state(), note.into());
        if state.notes.len() < MOST_NOTES && !state.notes.contains(&note) {
            state.notes.push_back(note);
        }
    }

    /// What was said since the last time.
    pub(crate) fn take_notes(&self) -> VecDeque<String> {
        std::mem::take(&mut self.state().notes)
    }

    /// Waits until somebody says something, at most for a time.
    pub(crate) fn wait(&self, at_most: Duration) {
        let state = self.state();
        if state.steps.is_empty() {
            drop(self.0.called.wait_timeout(state, at_most));
        }
    }
}
