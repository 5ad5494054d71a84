//! What a person should know beside the model.

use std::fmt;

/// Something a person should know about how their file was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// The element it is about, such as ``joint `arm` ``.
    pub subject: String,
    /// The line in the file where that element stands, from 1, where it is one.
    pub line: Option<usize>,
    /// What was ignored, assumed or doubted.
    pub text: String,
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            subject,
            line,
            text,
        } = self;
        match line {
            Some(line) => write!(f, "{subject} (line {line}): {text}"),
            None => write!(f, "{subject}: {text}"),
        }
    }
}
