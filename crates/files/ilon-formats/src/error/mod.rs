//! What can be wrong with a robot's file: where, what, and how to repair it.
//!
//! An error says what is wrong and which [`Remedy`] applies. How a remedy is asked for, a front end words: as a flag, a key of a
//! scenario, or an argument of a function.

mod clue;
mod fault;
mod help;
mod lists;
mod named;
mod remedy;

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

pub use clue::{Clue, ClueKind, Clues};
pub use fault::{Fault, Proposed};
pub(crate) use help::{NOT_SET, is_zero_size};
pub use named::{CandidateJoint, MissingFile};
pub use remedy::Remedy;

/// Where in a text a fault sits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextPlace {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The bytes of the text that are at fault.
    pub bytes: Range<usize>,
}

impl TextPlace {
    /// The place of a range of bytes in `text`.
    pub fn of_bytes(text: &str, bytes: Range<usize>) -> Self {
        let start = (0..=bytes.start.min(text.len()))
            .rev()
            .find(|&i| text.is_char_boundary(i))
            .unwrap_or(0);
        let before = &text[..start];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Self {
            line: before.bytes().filter(|&b| b == b'\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            bytes: start..bytes.end.clamp(start, text.len()),
        }
    }
}

/// A robot's file that cannot be used: the fault, where it is, and how to repair it.
///
/// Its `Display` is one line, ``robot.urdf:12: joint `arm`: ...``; [`RobotError::help`] says how to repair it,
/// [`RobotError::remedies`] which options would do, and the other accessors serve printers that show the line itself. Where a
/// file has more than one fault, the others are in [`RobotError::others`].
#[derive(Clone, Debug)]
pub struct RobotError(Box<Inner>);

#[derive(Clone, Debug)]
struct Inner {
    fault: Fault,
    file: String,
    text: Option<Arc<str>>,
    place: Option<TextPlace>,
    element: Option<String>,
    trail: Vec<String>,
    others: Vec<RobotError>,
    /// Other elements that were made of the same place and have the same fault.
    alike: usize,
    /// The first byte of the element at fault in the text that was read, which may have been made from the file's.
    loaded: Option<usize>,
}

impl RobotError {
    /// A fault in `file`, not yet placed.
    pub(crate) fn new(file: &str, fault: Fault) -> Self {
        Self(Box::new(Inner {
            fault,
            file: file.to_owned(),
            text: None,
            place: None,
            element: None,
            trail: Vec::new(),
            others: Vec::new(),
            alike: 0,
            loaded: None,
        }))
    }

    /// The same, at a range of bytes of the file's text.
    pub(crate) fn at(mut self, text: &Arc<str>, bytes: Range<usize>) -> Self {
        self.0.place = Some(TextPlace::of_bytes(text, bytes));
        self.0.text = Some(Arc::clone(text));
        self
    }

    /// The same, about an element such as ``joint `arm` ``.
    pub(crate) fn about(mut self, element: impl Into<String>) -> Self {
        self.0.element = Some(element.into());
        self
    }

    /// The same, with what led there.
    pub(crate) fn by(mut self, trail: Vec<String>) -> Self {
        self.0.trail = trail;
        self
    }

    /// The same, with the first byte of the element in the text that was read.
    pub(crate) fn loaded_at(mut self, byte: usize) -> Self {
        self.0.loaded = Some(byte);
        self
    }

    /// The first byte of the element at fault in the text that was read.
    pub(crate) fn loaded(&self) -> Option<usize> {
        self.0.loaded
    }

    /// The first of some errors with the others behind it; `None` without any.
    pub(crate) fn of_all(errors: impl IntoIterator<Item = Self>) -> Option<Self> {
        let mut errors = errors.into_iter();
        let mut first = errors.next()?;
        for mut error in errors {
            let inner = std::mem::take(&mut error.0.others);
            first.0.others.push(error);
            first.0.others.extend(inner);
        }
        Some(first)
    }

    /// One error for all that say the same of one place: a line of a macro is at fault once, however often it is called.
    pub fn by_place(errors: impl IntoIterator<Item = Self>) -> Vec<Self> {
        let mut found: Vec<Self> = Vec::new();
        for error in errors {
            let is_alike = |known: &&mut Self| {
                let (p, q) = (&known.0, &error.0);
                p.place.is_some() && p.place == q.place && p.file == q.file && p.fault == q.fault
            };
            match found.iter_mut().find(is_alike) {
                Some(known) => known.0.alike += 1,
                None => found.push(error),
            }
        }
        found
    }

    /// What is wrong.
    pub fn fault(&self) -> &Fault {
        &self.0.fault
    }

    /// Says of an argument without a value that any does.
    pub(crate) fn say_that_any_value_does(&mut self) {
        if let Fault::MissingArgument { any_does, .. } = &mut self.0.fault {
            *any_does = true;
        }
    }

    /// The file, as it was named when it was asked for; of a fault in an included file, that file.
    pub fn file(&self) -> &str {
        &self.0.file
    }

    /// The whole text of the file, where the fault has a place in it.
    pub fn text(&self) -> Option<&str> {
        self.0.text.as_deref()
    }

    /// Line, column and bytes, where they are known.
    pub fn place(&self) -> Option<&TextPlace> {
        self.0.place.as_ref()
    }

    /// The line, from 1, where it is known.
    pub fn line(&self) -> Option<usize> {
        self.0.place.as_ref().map(|p| p.line)
    }

    /// The element at fault, such as ``joint `arm` ``, where there is one.
    pub fn element(&self) -> Option<&str> {
        self.0.element.as_deref()
    }

    /// The macro calls and includes that led to the place, the innermost first; none of a file without macros.
    pub fn trail(&self) -> &[String] {
        &self.0.trail
    }

    /// The other faults that were found with this one.
    pub fn others(&self) -> &[Self] {
        &self.0.others
    }

    /// How to repair it.
    pub fn help(&self) -> String {
        self.0.fault.help()
    }

    /// The options of reading that would do, the best first; none where the file itself must change.
    pub fn remedies(&self) -> Vec<Remedy> {
        self.0.fault.remedies()
    }
}

impl fmt::Display for RobotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.file)?;
        if let Some(place) = &self.0.place {
            write!(f, ":{}", place.line)?;
        }
        if let Some(element) = &self.0.element {
            write!(f, ": {element}")?;
            match self.0.alike {
                0 => {}
                1 => f.write_str(" and another of the same place")?,
                count => write!(f, " and {count} others of the same place")?,
            }
        }
        write!(f, ": {}", self.0.fault)?;
        for step in &self.0.trail {
            write!(f, ", {step}")?;
        }
        Ok(())
    }
}

impl std::error::Error for RobotError {}
