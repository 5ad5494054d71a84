//! Progress on standard error: a bar on a terminal, plain lines elsewhere, and the time left.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::console;
use super::escape::{one_line, sentence};
use crate::simulate::Progress;

/// Time before the first plain line, and between them; chosen.
const BETWEEN_LINES: Duration = Duration::from_secs(5);

/// Ticks of a bar.
const TICKS: u64 = 1000;

/// Shows progress; may be called from several threads.
pub(super) struct Bar {
    name: String,
    output: Output,
    begun: Instant,
    state: Mutex<State>,
}

enum Output {
    Nowhere,
    Lines,
    Terminal(ProgressBar),
}

#[derive(Default)]
struct State {
    /// When the last plain line was written.
    said: Option<Instant>,
    left: TimeLeft,
}

impl Bar {
    /// A bar with that name; it shows nothing if the command is quiet.
    pub fn new(name: &str) -> Self {
        Self::drawn_as("{prefix} [{bar:32}] {msg}", name)
    }

    /// A bar for work of unknown length.
    pub fn without_end(name: &str) -> Self {
        let bar = Self::drawn_as("{spinner} {prefix}: {msg}", name);
        if let Output::Terminal(bar) = &bar.output {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        bar
    }

    fn drawn_as(template: &str, name: &str) -> Self {
        let name = one_line(name).into_owned();
        let output = match std::io::stderr().is_terminal() {
            _ if console::is_quiet() => Output::Nowhere,
            false => Output::Lines,
            true => {
                let bar = ProgressBar::new(TICKS);
                if let Ok(style) = ProgressStyle::with_template(template) {
                    bar.set_style(style);
                }
                bar.set_prefix(name.clone());
                Output::Terminal(bar)
            }
        };
        Self {
            name,
            output,
            begun: Instant::now(),
            state: Mutex::default(),
        }
    }

    /// Shows that `done` of `all` is done, described by `words`; `all` is 0 for work of unknown
    /// length.
    pub fn show(&self, done: f64, all: f64, words: impl FnOnce() -> String) {
        if matches!(self.output, Output::Nowhere) {
            return;
        }
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let left_s = state
            .left
            .update(self.begun.elapsed().as_secs_f64(), done, all);
        let left = || left_s.map_or(String::new(), |left_s| format!(", {} left", span(left_s)));
        match &self.output {
            Output::Terminal(bar) => {
                let share = if all > 0.0 { done / all } else { 0.0 };
                bar.set_position((share * TICKS as f64) as u64);
                bar.set_message(one_line(&format!("{}{}", words(), left())).into_owned());
            }
            _ if state.said.unwrap_or(self.begun).elapsed() < BETWEEN_LINES => {}
            _ => {
                state.said = Some(Instant::now());
                console::note(&format!("{}: {}{}", self.name, one_line(&words()), left()));
            }
        }
    }

    /// Shows the simulated share of a run.
    pub fn simulated(&self, progress: Progress) {
        let (now_s, end_s) = (progress.time_s, progress.duration_s);
        let words = || format!("{now_s:.1} of {end_s:.1} s simulated");
        self.show(now_s, end_s, words);
    }

    /// Prints a line beside the bar.
    pub fn note(&self, text: &str) {
        let note = || console::note(&sentence(text));
        match &self.output {
            Output::Terminal(bar) => bar.suspend(note),
            Output::Nowhere | Output::Lines => note(),
        }
    }

    /// Removes the bar.
    pub fn done(&self) {
        if let Output::Terminal(bar) = &self.output {
            bar.finish_and_clear();
        }
    }
}

/// A time as text: `40 s`, `12 min`.
fn span(time_s: f64) -> String {
    match time_s {
        _ if time_s < 120.0 => format!("{time_s:.0} s"),
        _ if time_s < 7200.0 => format!("{:.0} min", time_s / 60.0),
        _ => format!("{:.1} h", time_s / 3600.0),
    }
}

/// Estimates the time left from the mean pace.
///
/// The shown time does not rise with every slow piece: if the pace falls, it stands still until the
/// estimate has caught up. It rises only if the estimate is several times as long. Nothing is shown
/// before a twentieth is done, so that a few quick pieces at the start do not decide it.
#[derive(Debug, Default)]
struct TimeLeft {
    /// Time in seconds and amount done at the first call; what was done before it does not count
    /// for the pace.
    first: Option<(f64, f64)>,
    said_s: Option<f64>,
}

/// The share before which no time is shown; chosen.
const FIRST_SHARE: f64 = 0.05;
/// An estimate this many times the shown time replaces it; chosen.
const LONGER: f64 = 3.0;

impl TimeLeft {
    /// The time left, in seconds, at `now_s` seconds with `done` of `all` done; `None` if unknown.
    fn update(&mut self, now_s: f64, done: f64, all: f64) -> Option<f64> {
        let (since_s, before) = *self.first.get_or_insert((now_s, done));
        let made = done - before;
        let share = made / (all - before);
        // Also for 0 of 0, which is NaN.
        if !share.is_finite() || share < FIRST_SHARE {
            return None;
        }
        let left_s = (now_s - since_s) * (all - done) / made;
        let said_s = match self.said_s {
            Some(before_s) if left_s < LONGER * before_s => before_s.min(left_s),
            _ => left_s,
        };
        self.said_s = Some(said_s);
        Some(said_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pieces take longer, or the total shrinks: each shown time is at most the one before. At 80
    /// pieces that take 1 to 2 s, the mean pace falls to two thirds.
    #[test]
    fn the_time_left_falls_and_ends_at_none() {
        for (slows, shrinks) in [
            (0.0, 0.0),
            (0.0125, 0.0),
            (0.0, 3.0),
            (0.0125, 3.0),
            (-0.009, 0.0),
        ] {
            let mut left = TimeLeft::default();
            let (mut now_s, mut before_s) = (3.0, f64::INFINITY);
            let mut all = 100.0_f64;
            let mut done = 20.0_f64;
            left.update(now_s, done, all);
            while done < all {
                done += 1.0;
                now_s += 1.0 + slows * (done - 20.0);
                all = (all - shrinks).max(done);
                if let Some(left_s) = left.update(now_s, done, all) {
                    assert!(left_s <= before_s, "{left_s} s after {before_s} s");
                    before_s = left_s;
                }
            }
            assert_eq!(before_s, 0.0);
        }
    }

    /// The first half takes half a second, and the next forty pieces take forty seconds: the shown
    /// 0.5 s is then 4 s below the estimate of 4.5 s.
    #[test]
    fn a_time_that_was_far_too_short_is_corrected() {
        let mut left = TimeLeft::default();
        left.update(0.0, 0.0, 100.0);
        assert_eq!(left.update(0.5, 50.0, 100.0), Some(0.5));
        assert_eq!(left.update(1.0, 50.0, 100.0), Some(0.5), "not yet");
        let said_s = left.update(40.5, 90.0, 100.0);
        assert_eq!(said_s, Some(40.5 * 10.0 / 90.0));
    }

    /// At an even pace the first shown time is right, whatever was done before.
    #[test]
    fn at_an_even_pace_the_time_left_is_that_of_what_is_left() {
        let mut left = TimeLeft::default();
        assert_eq!(left.update(1.0, 50.0, 150.0), None);
        assert_eq!(left.update(5.0, 52.0, 150.0), None, "2 of 100");
        // 10 in 20 s: 90 more take 180 s.
        assert_eq!(left.update(21.0, 60.0, 150.0), Some(180.0));
        assert_eq!(left.update(121.0, 110.0, 150.0), Some(80.0));
        assert_eq!(TimeLeft::default().update(1.0, 0.0, 0.0), None);
    }
}
