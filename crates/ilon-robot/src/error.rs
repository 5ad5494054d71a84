//! What can be wrong with a robot's file: where, what, and how to mend it.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// Where in a text a fault sits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The bytes of the text that are at fault.
    pub bytes: Range<usize>,
}

impl Place {
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

/// A robot's file that cannot be used: the fault, where it is, and how to mend it.
///
/// Its `Display` is one line, ``robot.urdf:12: joint `arm`: ...``; [`RobotError::help`] says how to mend it, and the
/// other accessors serve printers that show the line itself.
#[derive(Clone, Debug)]
pub struct RobotError(Box<Inner>);

#[derive(Clone, Debug)]
struct Inner {
    fault: Fault,
    file: String,
    text: Option<Arc<str>>,
    place: Option<Place>,
    element: Option<String>,
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
        }))
    }

    /// The same, at a range of bytes of the file's text.
    pub(crate) fn at(mut self, text: &str, bytes: Range<usize>) -> Self {
        self.0.place = Some(Place::of_bytes(text, bytes));
        self.0.text = Some(Arc::from(text));
        self
    }

    /// The same, about an element such as ``joint `arm` ``.
    pub(crate) fn about(mut self, element: impl Into<String>) -> Self {
        self.0.element = Some(element.into());
        self
    }

    /// What is wrong.
    pub fn fault(&self) -> &Fault {
        &self.0.fault
    }

    /// The file, as it was named when it was asked for.
    pub fn file(&self) -> &str {
        &self.0.file
    }

    /// The whole text of the file, where the fault has a place in it.
    pub fn text(&self) -> Option<&str> {
        self.0.text.as_deref()
    }

    /// Line, column and bytes, where they are known.
    pub fn place(&self) -> Option<&Place> {
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

    /// How to mend it.
    pub fn help(&self) -> String {
        self.0.fault.help()
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
        }
        write!(f, ": {}", self.0.fault)
    }
}

impl std::error::Error for RobotError {}

/// What is wrong with a robot's description.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// The file cannot be read.
    #[error("cannot be read: {reason}")]
    Unreadable {
        /// What the operating system said.
        reason: String,
    },
    /// The description is not TOML, or not of the form that [`crate::Spec`] has.
    #[error("{reason}")]
    Toml {
        /// What the parser said.
        reason: String,
    },
    /// A value of the description is out of its range.
    #[error("`{key}` is {value}, but must be {range}")]
    OutOfRange {
        /// The key in the description.
        key: String,
        /// Its value.
        value: String,
        /// The range it must lie in.
        range: &'static str,
    },
    /// The rollers are too slender to reach one another.
    #[error(
        "rollers of {roller_radius_mm:.2} mm radius taper to nothing before they reach their neighbours"
    )]
    RollersTooSlender {
        /// The largest radius of the roller, in millimetres.
        roller_radius_mm: f64,
        /// The least radius with which the end sphere keeps a positive radius, in millimetres.
        least_radius_mm: f64,
    },
}

impl Fault {
    fn help(&self) -> String {
        match self {
            Self::Unreadable { .. } => {
                "give the path of a file that exists and may be read".to_owned()
            }
            Self::Toml { .. } => {
                "compare with the robots in assets/robots, or see the documentation of Spec"
                    .to_owned()
            }
            Self::OutOfRange { key, range, .. } => format!("set `{key}` to {range}"),
            Self::RollersTooSlender {
                least_radius_mm, ..
            } => format!(
                "make the rollers thicker than {least_radius_mm:.2} mm, or use more of them"
            ),
        }
    }
}
