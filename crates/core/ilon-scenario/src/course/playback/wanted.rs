//! What is searched for in a log.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::Path;

use ilon_robot::JointKind;

use super::series::Series;
use crate::Error;
use crate::scenario::Playback;

/// What is searched for in a log.
pub(super) struct Wanted<'a> {
    pub section: &'a Playback,
    /// The wheels that it drives, by their places in the robot and their names.
    pub wheels: &'a [(usize, &'a str)],
    /// The names of all wheels of the robot.
    pub all_wheels: Vec<&'a str>,
    /// The joints between bodies that it may drive.
    pub joints: &'a [(&'a str, JointKind)],
    pub path: &'a Path,
    /// The names that were searched for.
    pub asked: RefCell<BTreeSet<String>>,
}

/// The content of a log, in its own times.
pub(super) struct LogContents {
    /// The motion of wheels or body.
    pub driving: Series,
    /// The real robot's poses: x, y and heading.
    pub measured: Option<Series>,
    /// For each joint that the log may drive, rows of [`QUANTITIES`](super::joint_log::QUANTITIES);
    /// empty if the log has none.
    pub joints: Vec<Series>,
    /// Whether the file was recorded to its end.
    pub is_whole: bool,
}

impl Wanted<'_> {
    /// The name of something in the log.
    pub fn name<'s>(&'s self, ours: &'s str) -> &'s str {
        if !self.asked.borrow().contains(ours) {
            self.asked.borrow_mut().insert(ours.to_owned());
        }
        self.section.names.get(ours).map_or(ours, String::as_str)
    }

    /// Refuses a name that was not searched for: it would be ignored.
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
                    0 => "leave it out: this log is not searched by names".to_owned(),
                    _ => format!("looked for are {}", asked.join(", ")),
                }
            }
        };
        Err(self.fault(
            format!("`playback.names.{unused}` is not used: no such name is looked for in it"),
            help,
        ))
    }

    pub fn fault(&self, message: impl Into<String>, help: impl Into<String>) -> Error {
        Error::contents(self.path, message, help)
    }
}
