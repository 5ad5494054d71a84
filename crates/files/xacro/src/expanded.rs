//! The result of an expansion.

use std::collections::BTreeMap;

use crate::Place;

/// An expanded file.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Expanded {
    /// The text of the URDF.
    pub text: String,
    /// Origins of its elements, by their first bytes, in order.
    pub origins: Vec<(usize, Place)>,
    /// What was left out, and messages of the file itself.
    pub notes: Vec<Note>,
    /// The arguments declared by the file, with their values.
    pub arguments: BTreeMap<String, String>,
    /// Names watched by [`Settings::watch`](crate::Settings::watch), with their numbers.
    pub watched: Vec<(String, f64)>,
    /// Alternative values of arguments used in conditions.
    pub choices: Vec<(String, Vec<String>)>,
    /// Macros that are defined and never called.
    pub uncalled: Vec<String>,
    /// Tags of elements that are left in the text because they lack the prefix `xacro:`, as until
    /// 2014.
    pub unprefixed: Vec<String>,
}

/// A note about an element.
#[derive(Clone, Debug)]
pub struct Note {
    /// The element, such as ``include `wheel.xacro` ``.
    pub subject: String,
    /// Its place.
    pub place: Place,
    /// The message.
    pub words: String,
}
