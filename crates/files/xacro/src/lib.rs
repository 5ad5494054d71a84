//! Expands xacro, the macro language of URDF, without a ROS installation and without Python.
//!
//! The result equals that of ROS's xacro (the cases in `tests/cases` compare with xacro 2.1.1), on
//! every machine. No part of a file is ever executed as code: unsupported syntax is rejected with a
//! message, and no other interpreter is used. Work, depth and memory are limited, so that a file
//! that never ends is rejected too.
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
//! The stages: parse a file's elements with their places (`dom`); walk the tree once (`expand`),
//! evaluating texts (`text`, `substitution`) with expressions in a subset of Python (`python`),
//! with properties in scopes (`scope`) and macros in theirs (`macros`); write the result. Access to
//! the machine goes through a [`Host`].

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

use std::path::Path;
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

/// Largest file that is read, including included ones, in bytes.
pub const MAX_FILE_BYTES: u64 = 16 << 20;

/// Expands the text of a file. `path` is the file's place, used for relative includes and in
/// messages.
///
/// # Errors
/// The reason why a file cannot be expanded, with the place and the macro calls that lead there.
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
    // Macros can nest thousands of levels deep, which exceeds the caller's stack. The thread is
    // joined, and the limits end it.
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
