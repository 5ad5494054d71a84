//! An expanded file, and what is said of it.

use std::collections::BTreeMap;

use crate::Place;

/// An expanded file.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Expanded {
    /// The text of the URDF.
    pub text: String,
    /// Where its elements came from, by their first bytes, in order.
    pub origins: Vec<(usize, Place)>,
    /// What was left out, and what the file itself says while it is expanded.
    pub notes: Vec<Note>,
    /// The arguments that the file declares, with the value that each has.
    pub arguments: BTreeMap<String, String>,
    /// Names that were asked for in [`Settings::watch`](crate::Settings::watch), with their numbers.
    pub watched: Vec<(String, f64)>,
    /// Of arguments that conditions look at, the values that they could have instead.
    pub choices: Vec<(String, Vec<String>)>,
    /// Macros that are defined and never called.
    pub uncalled: Vec<String>,
}

/// Something to say about an element.
#[derive(Clone, Debug)]
pub struct Note {
    /// The element, such as ``include `wheel.xacro` ``.
    pub subject: String,
    /// Where it stands.
    pub place: Place,
    /// What is to be said.
    pub words: String,
}
