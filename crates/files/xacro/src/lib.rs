//! Expands xacro, the macro language in which URDF is written at source, without a ROS installation and without Python.
//!
//! What it makes of a file is what the xacro of ROS makes of it (the cases in `tests/cases` hold it against xacro 2.1.1), and the
//! same on every machine. Nothing of a file is ever run as code: what this language does not know is refused in words, and no other
//! interpreter is asked. Work, depth and memory are limited, so that a file that never ends is refused too.
//!
//! ```
//! use std::path::Path;
//! use xacro_expand::{LocalHost, Settings, expand};
//!
//! let text = r#"
//!     <robot name="cart" xmlns:xacro="http://www.ros.org/wiki/xacro">
//!       <xacro:arg name="wheels" default="2"/>
//!       <xacro:macro name="wheel" params="side"><link name="wheel_${side}"/></xacro:macro>
//!       <xacro:wheel side="left"/>
//!       <xacro:if value="${xacro.arg('wheels') == '2'}"><xacro:wheel side="right"/></xacro:if>
//!     </robot>"#;
//! let expanded = expand(Path::new("cart.xacro"), text, &Settings::default(), &LocalHost::default())?;
//! assert!(expanded.text.contains(r#"<link name="wheel_left"/>"#));
//! assert!(expanded.text.contains(r#"<link name="wheel_right"/>"#));
//! assert_eq!(expanded.arguments["wheels"], "2");
//! // Each element knows the place that it came from.
//! assert!(expanded.origins.iter().all(|(_, place)| &*place.file == "cart.xacro"));
//!
//! // What cannot be expanded is refused with its place.
//! let wrong = text.replace("'wheels'", "'wheel'");
//! let error = expand(Path::new("cart.xacro"), &wrong, &Settings::default(), &LocalHost::default()).unwrap_err();
//! assert_eq!(error.place.as_ref().map(|place| place.line()), Some(6));
//! assert!(error.hint().is_some());
//! # Ok::<(), Box<xacro_expand::ExpandError>>(())
//! ```
//!
//! It works in this order: a file's elements are read with their places (`dom`); the tree is gone through once (`expand`), evaluating
//! texts (`text`, `substitution`) whose expressions are a little Python (`python`), looking properties up in scopes (`scope`) and
//! macros in theirs (`macros`); the result is written. What it may see of the machine it asks of a [`Host`].

// A library prints nothing.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

mod budget;
mod dom;
mod error;
mod expand;
mod expanded;
mod files;
mod host;
mod macros;
mod packages;
mod python;
mod scope;
mod settings;
mod spent;
mod substitution;
mod text;
pub mod xml;
mod yaml;

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::thread;

use budget::STACK_BYTES;
use dom::SourceFile;

pub use error::{ExpandError, Missing, Place, Reason};
pub use expanded::{Expanded, Note};
pub use files::{Files, Unread};
pub use host::{Host, LocalHost};
pub use packages::{find_package, folder_that_holds};
pub use settings::Settings;

/// Longest file that is read, included ones too, in bytes.
pub const MAX_FILE_BYTES: u64 = 16 << 20;

/// Expands the text of a file. `path` is where the file lies, from which its includes start; messages call it so too.
///
/// # Errors
/// A file that cannot be expanded: why, where, and by which calls of macros it came there.
pub fn expand(
    path: &Path,
    text: &str,
    settings: &Settings,
    host: &dyn Host,
) -> Result<Expanded, Box<ExpandError>> {
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let work = || {
        let file = Rc::new(SourceFile {
            name: path.display().to_string(),
            folder: folder.clone(),
            text: text.into(),
        });
        expand::expand(&file, settings, host)
    };
    // Macros call each other thousands of levels deep, for which the stack of the caller is not made. The thread is waited
    // for, and the limits end it.
    thread::scope(|scope| {
        let thread = thread::Builder::new()
            .stack_size(STACK_BYTES)
            .spawn_scoped(scope, work);
        let failure = |reason: &str| Box::new(ExpandError::new(Reason::Other(reason.to_owned())));
        match thread {
            Ok(thread) => thread
                .join()
                .unwrap_or_else(|_| Err(failure("the expansion broke down"))),
            Err(e) => Err(failure(&format!("no thread can be started: {e}"))),
        }
    })
}

/// A path as it is written, from a folder.
fn from_folder(folder: &Path, written: &str) -> PathBuf {
    folder.join(written)
}
