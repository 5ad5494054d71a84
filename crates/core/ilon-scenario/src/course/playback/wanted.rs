//! What is looked for in a log.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::Path;

use ilon_robot::JointKind;

use super::series::Series;
use crate::Error;
use crate::scenario::Playback;

/// What is looked for in a log.
pub(super) struct Wanted<'a> {
    pub section: &'a Playback,
    pub wheels: &'a [&'a str],
    /// The joints between bodies that it may drive.
    pub joints: &'a [(&'a str, JointKind)],
    pub path: &'a Path,
    /// What was looked for.
    pub asked: RefCell<BTreeSet<String>>,
}

/// What a log says, in times of its own.
pub(super) struct LogContents {
    /// What drives wheels or body.
    pub driving: Series,
    /// Where the real robot was: x, y and heading.
    pub measured: Option<Series>,
    /// What it says of each of the joints that it may drive, rows of [`QUANTITIES`](super::joint_log::QUANTITIES); without rows where the log does not say.
    pub joints: Vec<Series>,
}

impl Wanted<'_> {
    /// What the log calls something.
    pub fn name<'s>(&'s self, ours: &'s str) -> &'s str {
        if !self.asked.borrow().contains(ours) {
            self.asked.borrow_mut().insert(ours.to_owned());
        }
        self.section.names.get(ours).map_or(ours, String::as_str)
    }

    /// Refuses a name of something that was not looked for: it would be ignored.
    pub fn refuse_unused_names(&self) -> Result<(), Error> {
        let asked = self.asked.borrow();
        let mut names = self.section.names.keys();
        let Some(unused) = names.find(|name| !asked.contains(*name)) else {
            return Ok(());
        };
        let near = crate::scenario::nearest(unused, asked.iter().map(String::as_str));
        let help = match near {
            Some(near) => format!("did you mean `{near}`?"),
            None => {
                let asked: Vec<String> = asked.iter().map(|name| format!("`{name}`")).collect();
                match asked.len() {
                    0 => "leave it out: nothing of this log has a name to look for".to_owned(),
                    _ => format!("looked for are {}", asked.join(", ")),
                }
            }
        };
        Err(self.fault(
            format!("`playback.names.{unused}` names nothing that is looked for in it"),
            help,
        ))
    }

    pub fn fault(&self, message: impl Into<String>, help: impl Into<String>) -> Error {
        Error::contents(self.path, message, help)
    }
}
