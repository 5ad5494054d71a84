//! Expansion errors with place and remedy.

use std::ops::Range;
use std::sync::Arc;

/// A place in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The file's name in messages.
    pub file: Arc<str>,
    /// The whole text of the file.
    pub text: Arc<str>,
    /// Its bytes in the text.
    pub bytes: Range<usize>,
}

impl Place {
    /// The line, from 1.
    pub fn line(&self) -> usize {
        1 + self.before().matches('\n').count()
    }

    /// The column in characters, from 1.
    pub fn column(&self) -> usize {
        let before = self.before();
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        1 + before[line_start..].chars().count()
    }

    fn before(&self) -> &str {
        self.text.get(..self.bytes.start).unwrap_or_default()
    }
}

/// The reason why a file cannot be expanded.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{}", self.text())]
pub struct ExpandError {
    /// The reason.
    pub reason: Reason,
    /// The place, if known.
    pub place: Option<Place>,
    /// The macro calls and includes that lead there, the innermost first.
    pub trail: Vec<String>,
    /// Everything that was not found so far.
    pub missing: Vec<Missing>,
    /// Whether it may be a consequence of what was not found: an undefined name.
    pub of_missing: bool,
    /// Whether elements lack the prefix `xacro:`, as until 2014, which
    /// [`Settings::before_2014`](crate::Settings::before_2014) accepts.
    pub of_before_2014: bool,
}

/// Kinds of expansion errors.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Reason {
    /// Files or packages are missing: those in [`ExpandError::missing`].
    #[error("files that it names cannot be found")]
    Missing,
    /// An argument has neither value nor default.
    #[error("the argument `{0}` has neither value nor default")]
    Argument(String),
    /// XML that is not well formed, with the parser's message.
    #[error("not well-formed XML: {0}")]
    Xml(String),
    /// A size beyond its limit: what, and the limit.
    #[error("too large to be read: {0}, where at most {1} are read")]
    TooMuch(String, String),
    /// Anything else.
    #[error("{0}")]
    Other(String),
}

/// Something that was not found.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    /// The file, as written.
    pub what: String,
    /// The package, if its folder is unknown.
    pub package: Option<String>,
    /// The reason, if the file exists but cannot be read.
    pub reason: String,
    /// The place that names it.
    pub at: String,
}

impl ExpandError {
    /// An error without a place.
    pub(crate) fn new(reason: Reason) -> Self {
        Self {
            reason,
            place: None,
            trail: Vec::new(),
            missing: Vec::new(),
            of_missing: false,
            of_before_2014: false,
        }
    }

    /// Returns the place, the reason, what is missing, and the way that leads there.
    fn text(&self) -> String {
        let place = self.place.as_ref();
        let place = place.map(|at| format!("{}:{}:{}: ", at.file, at.line(), at.column()));
        let missing = self.missing.iter();
        let missing = missing.map(|one| format!(", `{}` at {}", one.what, one.at));
        let trail = self.trail.iter().map(|step| format!(", {step}"));
        let rest: String = missing.chain(trail).collect();
        format!("{}{}{rest}", place.unwrap_or_default(), self.reason)
    }

    /// Returns a remedy, if known.
    pub fn hint(&self) -> Option<String> {
        Some(match &self.reason {
            Reason::Missing if self.missing.iter().any(|m| m.package.is_some()) => {
                "name the folders of the packages, or go without them".to_owned()
            }
            Reason::Missing => "put the files there, or go without them".to_owned(),
            Reason::Argument(name) => {
                format!("give `{name}` a value, or a default where it is declared")
            }
            Reason::Xml(_) => "close every element and quote every attribute".to_owned(),
            Reason::TooMuch(..) => "give a smaller file".to_owned(),
            Reason::Other(_) => return None,
        })
    }
}
