//! Expands xacro, the macro language in which URDF is written at source, without a ROS installation.
//!
//! What it makes of a file is what the xacro of ROS makes of it (docs/robots.md says what is covered and held by tests), and the
//! same on every machine. It works in this order: a file's elements are read with their places ([`dom`]); the tree is gone through
//! once ([`expand`]), evaluating texts ([`text`], [`substitution`]) whose expressions are a little Python ([`python`]), looking
//! properties up in scopes ([`scope`]) and macros in theirs ([`macros`]); the result is written, and each of its elements keeps
//! the place that it came from. [`budget`] ends what has no end. Nothing of a
//! file is ever run as code: what this language does not know is refused, and no other interpreter is asked.

mod budget;
mod dom;
mod expand;
mod macros;
mod python;
mod scope;
mod substitution;
mod text;
mod yaml;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::thread;

use budget::STACK_BYTES;
use dom::SourceFile;

use crate::files::FileAccess;
use crate::packages::{Package, Packages};

/// Longest file that is read, included ones too, in bytes.
pub(crate) const MAX_BYTES: u64 = 16 << 20;

/// What is said beside the file.
#[derive(Clone, Debug)]
pub(crate) struct Settings<'a> {
    pub(crate) arguments: &'a BTreeMap<String, String>,
    pub(crate) packages: &'a [Package],
    pub(crate) files: &'a FileAccess,
    /// Whether files that cannot be found are left out, with what they would define.
    pub(crate) leave_out_missing: bool,
}

/// An expanded file.
#[derive(Clone, Debug)]
pub(crate) struct Expanded {
    /// The text of the URDF.
    pub(crate) text: String,
    /// Where its elements came from, by their first bytes, in order.
    pub(crate) origins: Vec<(usize, Place)>,
    /// What was left out, and what the file itself says while it is expanded.
    pub(crate) notes: Vec<Note>,
    /// The arguments that the file declares, with the value that each has.
    pub(crate) arguments: BTreeMap<String, String>,
    /// What is called a size of a wheel, with its value.
    pub(crate) sizes: Vec<(String, f64)>,
    /// Of arguments that conditions look at, the values that they could have instead.
    pub(crate) choices: Vec<(String, Vec<String>)>,
    /// Macros that are defined and never called.
    pub(crate) uncalled: Vec<String>,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Place {
    /// What messages call the file.
    pub(crate) file: Arc<str>,
    pub(crate) text: Arc<str>,
    pub(crate) bytes: Range<usize>,
}

/// Something to say about an element.
#[derive(Clone, Debug)]
pub(crate) struct Note {
    pub(crate) subject: String,
    pub(crate) place: Place,
    pub(crate) words: String,
}

/// Why a file cannot be expanded.
#[derive(Clone, Debug)]
pub(crate) struct Failure {
    pub(crate) reason: Reason,
    pub(crate) place: Option<Place>,
    /// The macro calls and includes that led there, the innermost first.
    pub(crate) trail: Vec<String>,
    /// Everything that was looked for and not found, on the way.
    pub(crate) missing: Vec<Missing>,
    /// Whether it may come of what was not found: a name that nothing defines.
    pub(crate) of_missing: bool,
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Reason {
    /// Files or packages are not there: those of [`Failure::missing`].
    Missing,
    /// An argument has neither value nor default.
    Argument(String),
    /// XML that is not well formed.
    Xml(String),
    /// More than is read: what, and how much.
    TooMuch(String, String),
    /// Anything else.
    Other(String),
}

/// Something that was looked for and not found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Missing {
    /// The file, as it is written.
    pub(crate) what: String,
    /// The package, where its folder is not known.
    pub(crate) package: Option<String>,
    /// Why not, where the file is there but is not read.
    pub(crate) reason: String,
    /// Where it is named.
    pub(crate) at: String,
}

/// Expands a file.
pub(crate) fn expand(
    path: &Path,
    name: &str,
    text: &str,
    settings: &Settings,
) -> Result<Expanded, Box<Failure>> {
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let work = || {
        let file = Rc::new(SourceFile {
            name: name.to_owned(),
            folder: folder.clone(),
            text: text.into(),
        });
        expand::expand(&file, settings)
    };
    // Macros call each other thousands of levels deep, for which the stack of the caller is not made. The thread is waited
    // for, and the limits end it.
    thread::scope(|scope| {
        let thread = thread::Builder::new()
            .stack_size(STACK_BYTES)
            .spawn_scoped(scope, work);
        let failure = |reason: &str| {
            Box::new(Failure {
                reason: Reason::Other(reason.to_owned()),
                place: None,
                trail: Vec::new(),
                missing: Vec::new(),
                of_missing: false,
            })
        };
        match thread {
            Ok(thread) => thread
                .join()
                .unwrap_or_else(|_| Err(failure("the expansion broke down"))),
            Err(e) => Err(failure(&format!("no thread can be started: {e}"))),
        }
    })
}

/// The packages that a file in `folder` can name.
fn packages(folder: &Path, settings: &Settings) -> Packages {
    Packages::around(folder, settings.packages, settings.files)
}

/// A path as it is written, from a folder.
fn from_folder(folder: &Path, written: &str) -> PathBuf {
    folder.join(written)
}
