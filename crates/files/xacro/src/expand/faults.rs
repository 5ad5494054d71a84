//! Faults and notes of an expansion.

use super::Expander;
use super::Result;
use crate::dom::Origin;
use crate::python::Error;
use crate::spent::Spent;
use crate::{ExpandError, Missing, Note, Place, Reason};
use std::sync::Arc;

/// Most missing files, and most notes, that are listed.
pub(super) const MOST_LISTED: usize = 200;

impl Expander<'_> {
    pub(super) fn place(&self, origin: &Origin) -> Place {
        let mut texts = self.texts.borrow_mut();
        let file = &origin.file;
        let (name, text) = texts
            .entry(file.name.clone())
            .or_insert_with(|| (Arc::from(file.name.as_str()), Arc::from(&*file.text)));
        Place {
            file: Arc::clone(name),
            text: Arc::clone(text),
            bytes: origin.bytes.clone(),
        }
    }

    pub(super) fn failure(&self, reason: Reason, origin: Option<&Origin>) -> Box<ExpandError> {
        let calls = self.calls.borrow();
        let trail = calls
            .iter()
            .rev()
            .map(|(name, origin)| format!("called as `{name}` at {}", self.line(origin)));
        Box::new(ExpandError {
            reason,
            place: origin.map(|origin| self.place(origin)),
            // The outermost calls show the start, the innermost the end; hundreds between them are
            // not useful.
            trail: trail.take(8).collect(),
            missing: Vec::new(),
            of_missing: false,
            of_before_2014: false,
        })
    }

    pub(super) fn fault(&self, origin: &Origin, words: impl Into<String>) -> Box<ExpandError> {
        self.failure(Reason::Other(words.into()), Some(origin))
    }

    pub(super) fn spent(&self, origin: &Origin) -> impl Fn(Spent) -> Box<ExpandError> {
        move |spent| self.fault(origin, spent.to_string())
    }

    pub(super) fn error(&self, origin: &Origin, error: &Error) -> Box<ExpandError> {
        let reason = match error.cause() {
            Error::Argument(name) => Reason::Argument(name.clone()),
            Error::Package(name) => {
                self.miss(Missing {
                    what: format!("$(find {name})"),
                    package: Some(name.clone()),
                    reason: String::new(),
                    at: self.line(origin),
                });
                Reason::Missing
            }
            Error::File(name, reason) => {
                self.miss(Missing {
                    what: name.clone(),
                    package: None,
                    reason: reason.clone(),
                    at: self.line(origin),
                });
                Reason::Missing
            }
            _ => Reason::Other(error.to_string()),
        };
        let mut failure = self.failure(reason, Some(origin));
        failure.of_missing = matches!(
            error.cause(),
            Error::Name(_) | Error::Package(_) | Error::File(..)
        );
        failure
    }

    /// Ignores an error caused by something missing, if allowed.
    pub(super) fn or_without(
        &self,
        origin: &Origin,
        subject: &str,
        expanded: Result<()>,
        (calls, reading): (usize, usize),
    ) -> Result<()> {
        match expanded {
            Err(failure)
                if failure.of_missing
                    && self.settings.leave_out_missing
                    && !self.missing.borrow().is_empty() =>
            {
                self.calls.borrow_mut().truncate(calls);
                self.reading.borrow_mut().truncate(reading);
                let why = match &failure.reason {
                    Reason::Other(words) => words.clone(),
                    _ => "it needs what is missing".to_owned(),
                };
                self.note(origin, subject, format!("left out: {why}"));
                Ok(())
            }
            other => other,
        }
    }

    /// Returns the depth of the expansion in calls and in files.
    pub(super) fn depths(&self) -> (usize, usize) {
        (self.calls.borrow().len(), self.reading.borrow().len())
    }

    /// `file:line`.
    pub(super) fn line(&self, origin: &Origin) -> String {
        let before = &origin.file.text[..origin.bytes.start];
        format!("{}:{}", origin.file.name, 1 + before.matches('\n').count())
    }

    pub(super) fn note(&self, origin: &Origin, subject: &str, words: String) {
        let mut notes = self.notes.borrow_mut();
        // A macro that is called a thousand times repeats its note a thousand times.
        let known = notes
            .iter()
            .any(|note| note.words == words && note.subject == subject);
        if !known && notes.len() < MOST_LISTED {
            notes.push(Note {
                subject: subject.to_owned(),
                place: self.place(origin),
                words,
            });
        }
    }

    pub(super) fn miss(&self, missing: Missing) {
        let mut all = self.missing.borrow_mut();
        if all.len() < MOST_LISTED && !all.iter().any(|known| known.what == missing.what) {
            all.push(missing);
        }
    }
}
