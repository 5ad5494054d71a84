//! What is said of a text that is no XML, or too much of it.

use crate::error::{Fault, RobotError};
use crate::xml;

/// The error of a text that cannot be parsed.
pub(super) fn of_xml(file: &str, text: &str, fault: xml::Fault) -> RobotError {
    match fault {
        xml::Fault::Malformed(reason, bytes) => {
            RobotError::new(file, Fault::Xml { reason }).at(&text.into(), bytes)
        }
        xml::Fault::TooMuch(what, most, _) => RobotError::new(file, Fault::TooLarge { what, most }),
    }
}
