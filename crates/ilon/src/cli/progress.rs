//! Progress on standard error: a bar on a terminal, plain lines elsewhere.

use std::cell::Cell;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::escape::one_line;
use super::say;
use crate::simulate::Progress;

/// Shows how far a run is.
pub(super) struct Bar {
    name: String,
    bar: Option<ProgressBar>,
    /// When the last plain line was written.
    told: Cell<Instant>,
}

/// Time between plain lines.
const BETWEEN_LINES: Duration = Duration::from_secs(2);

/// Ticks of the bar over a run.
const TICKS: u64 = 1000;

impl Bar {
    pub fn new(name: &str, duration_s: f64) -> Self {
        let on_terminal = std::io::stderr().is_terminal();
        let name = one_line(name);
        if !on_terminal {
            say::note(&format!("{name}: simulating {duration_s} s"));
        }
        let bar = on_terminal.then(|| {
            let style = ProgressStyle::with_template("{prefix} [{bar:32}] {msg}, {eta} left");
            let bar = ProgressBar::new(TICKS);
            if let Ok(style) = style {
                bar.set_style(style);
            }
            bar.set_prefix(name.clone().into_owned());
            bar.set_message(format!("0.0 of {duration_s:.1} s"));
            bar
        });
        Self {
            name: name.into_owned(),
            bar,
            told: Cell::new(Instant::now()),
        }
    }

    /// One that shows nothing.
    pub fn hidden(name: &str) -> Self {
        Self {
            name: one_line(name).into_owned(),
            bar: Some(ProgressBar::hidden()),
            told: Cell::new(Instant::now()),
        }
    }

    pub fn show(&self, progress: Progress) {
        let Progress {
            time_s, duration_s, ..
        } = progress;
        let share = time_s / duration_s;
        if let Some(bar) = &self.bar {
            bar.set_position((share * TICKS as f64) as u64);
            bar.set_message(format!("{time_s:.1} of {duration_s:.1} s"));
            return;
        }
        if self.told.get().elapsed() > BETWEEN_LINES {
            self.told.set(Instant::now());
            say::note(&format!(
                "{}: {time_s:.1} of {duration_s:.1} s simulated",
                self.name
            ));
        }
    }

    /// A line beside the bar.
    pub fn note(&self, text: &str) {
        let note = || say::note(&one_line(text));
        match &self.bar {
            Some(bar) => bar.suspend(note),
            None => note(),
        }
    }

    pub fn done(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
