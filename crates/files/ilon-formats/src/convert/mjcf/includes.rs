//! What a file includes, and what is refused of it.

use std::ops::Range;
use std::path::{Path, PathBuf};

use roxmltree::{Document, Node};

use crate::convert::assembled::Assembled;
use crate::convert::malformed::of_xml;
use crate::error::{Fault, RobotError};
use crate::files::ReadError;
use crate::options::LoadOptions;
use crate::xml;

/// Most files that one may include, and those include: models that are kept in a file for each part have dozens.
const MOST_INCLUDES: usize = 500;
/// Most bytes that all files that are included have.
const MAX_BYTES: u64 = 16 << 20;

/// A file's text with what it includes in the place of each include.
pub(super) fn put_in(
    file: &str,
    text: &str,
    folder: &Path,
    options: &LoadOptions,
) -> Result<Assembled, RobotError> {
    let mut left = Left {
        files: MOST_INCLUDES,
        bytes: MAX_BYTES,
    };
    with_includes(file, text, folder, options, &mut left)
}

/// What may still be included.
struct Left {
    files: usize,
    bytes: u64,
}

/// The text with what it includes in the place of each include.
fn with_includes(
    file: &str,
    text: &str,
    folder: &Path,
    options: &LoadOptions,
    left: &mut Left,
) -> Result<Assembled, RobotError> {
    let own = Assembled::of_file(file, text);
    let document = xml::parse(text).map_err(|fault| of_xml(file, text, fault))?;
    let mut whole = Assembled::default();
    let mut done = 0;
    for node in document.descendants().filter(|n| n.has_tag_name("include")) {
        let fault = |reason: String| {
            let bytes = xml::opening_tag(text, node);
            Err(RobotError::new(file, Fault::Format { reason }).at(&text.into(), bytes))
        };
        let Some(name) = node.attribute("file") else {
            return fault("an `<include>` names no file".to_owned());
        };
        if left.files == 0 {
            return fault(format!("more than {MOST_INCLUDES} files are included"));
        }
        left.files -= 1;
        let path = included_path(file, folder, name, options);
        let included = match options.files.read_text(&path, left.bytes) {
            Ok(included) => included,
            Err(ReadError::TooLarge(_)) => {
                return fault(format!("files of more than {MAX_BYTES} bytes are included"));
            }
            Err(reason) => return fault(format!("`{name}` cannot be included: {reason}")),
        };
        left.bytes = left.bytes.saturating_sub(included.len() as u64);
        let name = path.display().to_string();
        let included = with_includes(&name, &included, folder, options, left)?;
        let inner =
            xml::parse(&included.text).map_err(|fault| of_xml(&name, &included.text, fault))?;
        whole.append(&own, done..node.range().start);
        whole.append(&included, inside(inner.root_element()));
        done = node.range().end;
    }
    whole.append(&own, done..text.len());
    Ok(whole)
}

/// Where a file lies that another includes: beside the first of all, or beside the one that includes it, as in MuJoCo.
fn included_path(file: &str, folder: &Path, name: &str, options: &LoadOptions) -> PathBuf {
    let beside_first = folder.join(name);
    let own = Path::new(file).parent().unwrap_or(Path::new(""));
    let beside_own = own.join(name);
    let is_only_there = !options.files.is_file(&beside_first) && options.files.is_file(&beside_own);
    if is_only_there {
        beside_own
    } else {
        beside_first
    }
}

/// What stands between an element's tags.
fn inside(node: Node) -> Range<usize> {
    let children = || node.children();
    match (children().next(), children().next_back()) {
        (Some(first), Some(last)) => first.range().start..last.range().end,
        _ => 0..0,
    }
}

/// Refuses elements that would make bodies which nothing here knows of.
pub(super) fn refuse_what_is_not_read(
    file: &str,
    whole: &Assembled,
    document: &Document,
) -> Result<(), RobotError> {
    let tags = ["composite", "flexcomp", "attach", "model"];
    let unread = document
        .descendants()
        .find(|n| tags.contains(&n.tag_name().name()) && n.is_element());
    match unread {
        None => Ok(()),
        Some(node) => {
            let reason = format!(
                "`<{}>` is not read: save the model from MuJoCo (`mj_saveLastXML`), which writes it out",
                node.tag_name().name()
            );
            Err(whole.error(file, xml::opening_tag(&whole.text, node), reason))
        }
    }
}
