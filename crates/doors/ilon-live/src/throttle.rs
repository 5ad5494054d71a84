//! Throttles notes about a stream of messages.

use std::time::{Duration, Instant};

/// Time between two notes of one kind. A faulty publisher repeats its fault at its rate, often a
/// hundred times per second.
const BETWEEN_NOTES: Duration = Duration::from_secs(10);
/// How long a kind of note is remembered.
const REMEMBERED: Duration = Duration::from_secs(60);
/// Largest number of kinds of notes; more within a minute are dropped.
const MOST_KINDS: usize = 32;

/// Recent notes about commands.
#[derive(Debug, Default)]
pub(crate) struct Throttle(Vec<NoteKind>);

/// Notes that only differ by their numbers.
#[derive(Debug)]
struct NoteKind {
    words: String,
    said: Instant,
    /// Notes suppressed since the last one.
    kept: u64,
}

impl Throttle {
    /// Returns a note if it is due now, with the number of suppressed notes of its kind; `None`
    /// shortly after the last one.
    pub fn pass(&mut self, note: String, now: Instant) -> Option<String> {
        let since = |said| now.saturating_duration_since(said);
        self.0.retain(|kind| since(kind.said) < REMEMBERED);
        let words: String = note.chars().filter(|c| !c.is_ascii_digit()).collect();
        let Some(kind) = self.0.iter_mut().find(|kind| kind.words == words) else {
            if self.0.len() >= MOST_KINDS {
                return None;
            }
            self.0.push(NoteKind {
                words,
                said: now,
                kept: 0,
            });
            return Some(note);
        };
        if since(kind.said) < BETWEEN_NOTES {
            kind.kept += 1;
            return None;
        }
        kind.said = now;
        Some(match std::mem::take(&mut kind.kept) {
            0 => note,
            kept => format!("{note} ({kept} more such messages since it was last said)"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_stream_of_bad_commands_one_in_ten_seconds_is_spoken_of() {
        let begin = Instant::now();
        let mut throttle = Throttle::default();
        // At 100 Hz for 25 s.
        let said: Vec<String> = (0..2500_u64)
            .filter_map(|index| {
                let now = begin + Duration::from_millis(10 * index);
                throttle.pass(format!("command {index} is not taken"), now)
            })
            .collect();
        assert_eq!(
            said,
            [
                "command 0 is not taken",
                "command 1000 is not taken (999 more such messages since it was last said)",
                "command 2000 is not taken (999 more such messages since it was last said)",
            ]
        );
    }

    #[test]
    fn one_fault_does_not_hide_another_and_there_is_an_end_to_them() {
        let now = Instant::now();
        let mut throttle = Throttle::default();
        assert!(throttle.pass("its stamp is old".to_owned(), now).is_some());
        assert!(throttle.pass("vx is too large".to_owned(), now).is_some());
        let kinds = (0..1000).map(|index| "x".repeat(index + 1));
        let said = kinds.filter_map(|note| throttle.pass(note, now)).count();
        assert_eq!(said, MOST_KINDS - 2);
    }
}
