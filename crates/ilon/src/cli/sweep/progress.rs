//! Progress of a study on standard error: a bar on a terminal, plain lines elsewhere.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use ilon_sim::sweep::Progress;
use indicatif::{ProgressBar, ProgressStyle};

use crate::cli::escape::one_line;
use crate::cli::say;

/// Time between plain lines.
const BETWEEN_LINES: Duration = Duration::from_secs(5);

/// Shows how far a study is; called from several threads.
pub(super) struct Bar {
    name: String,
    bar: Option<ProgressBar>,
    begun: Instant,
    /// When the last plain line was written.
    told: Mutex<Option<Instant>>,
}

impl Bar {
    pub fn new(name: &str) -> Self {
        let name = one_line(name).into_owned();
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{prefix} [{bar:32}] {msg}, {eta} left");
            let bar = ProgressBar::no_length();
            if let Ok(style) = style {
                bar.set_style(style);
            }
            bar.set_prefix(name.clone());
            bar
        });
        Self {
            name,
            bar,
            begun: Instant::now(),
            told: Mutex::new(None),
        }
    }

    pub fn show(&self, progress: Progress) {
        let Progress {
            done,
            found,
            failed,
            most,
            is_search,
            ..
        } = progress;
        let of = if is_search { "of at most" } else { "of" };
        let failed = if failed > 0 {
            format!(", {failed} failed")
        } else {
            String::new()
        };
        let words = format!("{done} {of} {most} runs{failed}");
        if let Some(bar) = &self.bar {
            // What was there before took no time: it does not count for the estimate.
            bar.set_length(most.saturating_sub(found));
            bar.set_position(done.saturating_sub(found));
            bar.set_message(words);
            return;
        }
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        if told.is_some_and(|told| told.elapsed() < BETWEEN_LINES) {
            return;
        }
        *told = Some(Instant::now());
        let made = done.saturating_sub(found);
        let left = match made {
            0 => String::new(),
            made => {
                let left_s = self.begun.elapsed().as_secs_f64() / made as f64
                    * most.saturating_sub(done) as f64;
                format!(
                    ", {left_s:.0} s left{}",
                    if is_search { " at most" } else { "" }
                )
            }
        };
        say::note(&format!("{}: {words}{left}", self.name));
    }

    pub fn done(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
