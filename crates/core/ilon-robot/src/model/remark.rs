//! Remarks for the user about how a file was read.

use std::fmt;

/// A remark for the user about how their file was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// The element it is about, such as ``joint `arm` ``.
    pub subject: String,
    /// The file of that element, if it is an included one.
    pub file: Option<String>,
    /// The line of that element in the file, from 1, if known.
    pub line: Option<usize>,
    /// What was ignored, assumed, repaired or doubted.
    pub text: String,
    /// Whether it concerns parts of the file that cannot affect the motion: shown when reading a
    /// file, not before a run.
    pub is_aside: bool,
}

impl Remark {
    /// A remark about an element, without file and line.
    pub fn new(subject: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            subject: subject.into(),
            file: None,
            line: None,
            text: text.into(),
            is_aside: false,
        }
    }

    /// A remark about a part of the file that cannot matter to the motion.
    pub fn aside(subject: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            is_aside: true,
            ..Self::new(subject, text)
        }
    }
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            subject,
            file,
            line,
            text,
            is_aside: _,
        } = self;
        match (file, line) {
            (Some(file), Some(line)) => write!(f, "{subject} ({file}:{line}): {text}"),
            (_, Some(line)) => write!(f, "{subject} (line {line}): {text}"),
            (_, None) => write!(f, "{subject}: {text}"),
        }
    }
}
