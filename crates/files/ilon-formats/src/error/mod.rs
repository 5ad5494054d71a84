//! Errors of robot files: place, fault and remedy.
//!
//! An error has its applicable [`Remedy`]s. Front ends express a remedy in their own way: as a
//! flag, a key of a scenario, or an argument of a function.

mod clue;
mod fault;
mod help;
mod lists;
mod mend;
mod named;
mod remedy;

use std::fmt;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

pub use clue::{Clue, ClueKind, Clues};
pub use fault::Fault;
pub(crate) use help::{NOT_SET, is_zero_size};
pub(crate) use lists::and_more;
pub use named::{CandidateJoint, MissingFile, Proposed};
pub use remedy::Remedy;

/// The place of a fault in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextPlace {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The faulty bytes of the text.
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

/// An unusable robot file: the fault, its place, and remedies.
///
/// Its `Display` is one line, ``robot.urdf:12: joint `arm`: ...``; [`RobotError::help`] tells how
/// to repair it, [`RobotError::remedies`] which options repair it, and the other accessors are for
/// printers that show the line itself. If a file has more than one fault, the others are in
/// [`RobotError::others`].
#[derive(Clone, Debug)]
pub struct RobotError(Box<Inner>);

#[derive(Clone, Debug)]
struct Inner {
    fault: Fault,
    file: String,
    /// The text of the file, and the faulty bytes of it.
    at: Option<(Arc<str>, Range<usize>)>,
    /// Found when it is asked for, which takes time with the length of the text: of thousands of
    /// faults only the first are shown.
    place: OnceLock<TextPlace>,
    element: Option<String>,
    trail: Vec<String>,
    others: Vec<RobotError>,
    /// Number of other elements from the same place with the same fault.
    alike: usize,
    /// Other elements with the same fault, by their lines.
    also: Vec<String>,
    /// The first byte of the faulty element in the text that was read, which may be derived from
    /// the file's.
    loaded: Option<usize>,
}

impl RobotError {
    /// A fault in `file`, without a place.
    pub(crate) fn new(file: &str, fault: Fault) -> Self {
        Self(Box::new(Inner {
            fault,
            file: file.to_owned(),
            at: None,
            place: OnceLock::new(),
            element: None,
            trail: Vec::new(),
            others: Vec::new(),
            alike: 0,
            also: Vec::new(),
            loaded: None,
        }))
    }

    /// Adds a range of bytes of the file's text.
    pub(crate) fn at(mut self, text: &Arc<str>, bytes: Range<usize>) -> Self {
        self.0.at = Some((Arc::clone(text), bytes));
        self
    }

    /// Adds an element such as ``joint `arm` ``.
    pub(crate) fn about(mut self, element: impl Into<String>) -> Self {
        self.0.element = Some(element.into());
        self
    }

    /// Adds the macro calls and includes.
    pub(crate) fn by(mut self, trail: Vec<String>) -> Self {
        self.0.trail = trail;
        self
    }

    /// Adds the first byte of the element in the text that was read.
    pub(crate) fn loaded_at(mut self, byte: usize) -> Self {
        self.0.loaded = Some(byte);
        self
    }

    /// The first byte of the faulty element in the text that was read.
    pub(crate) fn loaded(&self) -> Option<usize> {
        self.0.loaded
    }

    /// Returns the first of some errors with the others attached; `None` without any.
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

    /// Changes this error and each of the others.
    pub(crate) fn each(mut self, change: impl Fn(Self) -> Self) -> Self {
        let others = std::mem::take(&mut self.0.others);
        let mut first = change(self);
        first.0.others = others.into_iter().map(change).collect();
        first
    }

    /// Adds the file's name.
    pub(crate) fn of_file(mut self, file: &str) -> Self {
        file.clone_into(&mut self.0.file);
        self
    }

    /// Merges equal errors of one place: a line of a macro is reported once, however often it is
    /// called. So are wheels of unknown size whose geometry tells nothing for the same reason, such
    /// as a mesh that all of them show.
    pub fn by_place(errors: impl IntoIterator<Item = Self>) -> Vec<Self> {
        let mut found: Vec<Self> = Vec::new();
        for error in errors {
            let is_alike = |known: &&mut Self| {
                let (p, q) = (&known.0, &error.0);
                p.at.is_some() && p.file == q.file && p.fault == q.fault && p.at == q.at
            };
            let reason = |of: &Self| match &of.0.fault {
                Fault::WheelSizeUnknown { reason, .. } => reason.clone(),
                _ => None,
            };
            if let Some(known) = found.iter_mut().find(is_alike) {
                known.0.alike += 1;
            } else if let Some(known) = (found.iter_mut()).find(|known| {
                known.0.file == error.0.file
                    && reason(known).is_some()
                    && reason(known) == reason(&error)
            }) && let (Some(element), Some(line)) = (&error.0.element, error.line())
            {
                known.0.also.push(format!("{element} (line {line})"));
            } else {
                found.push(error);
            }
        }
        found
    }

    /// The fault.
    pub fn fault(&self) -> &Fault {
        &self.0.fault
    }

    /// Marks an argument without a value as one for which any value works.
    pub(crate) fn say_that_any_value_does(&mut self) {
        if let Fault::MissingArgument { any_does, .. } = &mut self.0.fault {
            *any_does = true;
        }
    }

    /// The file's name as passed by the caller; for a fault in an included file, that file.
    pub fn file(&self) -> &str {
        &self.0.file
    }

    /// The whole text of the file, if the fault has a place in it.
    pub fn text(&self) -> Option<&str> {
        self.0.at.as_ref().map(|(text, _)| text.as_ref())
    }

    /// Line, column and bytes, if known.
    pub fn place(&self) -> Option<&TextPlace> {
        let (text, bytes) = self.0.at.as_ref()?;
        let found = || TextPlace::of_bytes(text, bytes.clone());
        Some(self.0.place.get_or_init(found))
    }

    /// The line, from 1, if known.
    pub fn line(&self) -> Option<usize> {
        self.place().map(|place| place.line)
    }

    /// The faulty element, such as ``joint `arm` ``, if there is one.
    pub fn element(&self) -> Option<&str> {
        self.0.element.as_deref()
    }

    /// The macro calls and includes that lead to the place, the innermost first; empty for a file
    /// without macros.
    pub fn trail(&self) -> &[String] {
        &self.0.trail
    }

    /// The other faults found together with this one.
    pub fn others(&self) -> &[Self] {
        &self.0.others
    }

    /// How to repair it.
    pub fn help(&self) -> String {
        let help = miette::Diagnostic::help(&self.0.fault);
        help.map_or_else(String::new, |help| help.to_string())
    }

    /// Returns the options of reading that repair it, the best first; empty if the file itself must
    /// be changed.
    pub fn remedies(&self) -> Vec<Remedy> {
        // Only from an SDF does a repair leave out joints.
        let in_sdf = || {
            [".sdf", ".world"]
                .iter()
                .any(|end| self.0.file.ends_with(end))
        };
        match self.0.fault {
            Fault::TwoParents { .. } | Fault::Loop if !in_sdf() => Vec::new(),
            _ => self.0.fault.remedies(),
        }
    }
}

impl fmt::Display for RobotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.file)?;
        if let Some(line) = self.line() {
            write!(f, ":{line}")?;
        }
        if let Some(element) = &self.0.element {
            write!(f, ": {element}")?;
            match self.0.alike {
                0 => {}
                1 => f.write_str(" and another of the same place")?,
                count => write!(f, " and {count} others of the same place")?,
            }
            for other in &self.0.also {
                write!(f, ", {other}")?;
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
