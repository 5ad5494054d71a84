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

/// Most files that one may include, and those include: models that are kept in a file for each part
/// have dozens.
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
    let mut putting = Putting {
        folder,
        options,
        whole: Assembled::default(),
        files: MOST_INCLUDES,
        bytes: MAX_BYTES,
    };
    putting.put(file, text, |_| 0..text.len())?;
    Ok(putting.whole)
}

/// Puts files together. Each is parsed once, however deep the includes are.
struct Putting<'p> {
    folder: &'p Path,
    options: &'p LoadOptions,
    whole: Assembled,
    /// Files and bytes that may still be included.
    files: usize,
    bytes: u64,
}

impl Putting<'_> {
    /// Adds the part of a file that its root element gives, with the content of other files in
    /// place of each include.
    fn put(
        &mut self,
        file: &str,
        text: &str,
        part: impl FnOnce(Node) -> Range<usize>,
    ) -> Result<(), RobotError> {
        let own = Assembled::of_file(file, text);
        let document = xml::parse(text).map_err(|fault| of_xml(file, text, fault))?;
        let part = part(document.root_element());
        let mut done = part.start;
        for node in document.descendants().filter(|n| n.has_tag_name("include")) {
            let (name, included) = self.read(file, node).map_err(|reason| {
                let bytes = xml::opening_tag(text, node);
                RobotError::new(file, Fault::Format { reason }).at(&text.into(), bytes)
            })?;
            self.whole.append(&own, done..node.range().start);
            self.put(&name, &included, inside)?;
            done = node.range().end;
        }
        self.whole.append(&own, done..part.end);
        Ok(())
    }

    /// The path and the text of the file that an element of `file` includes.
    fn read(&mut self, file: &str, include: Node) -> Result<(String, String), String> {
        let name = include.attribute("file");
        let name = name.ok_or("an `<include>` names no file")?;
        if self.files == 0 {
            return Err(format!("more than {MOST_INCLUDES} files are included"));
        }
        self.files -= 1;
        let path = included_path(file, self.folder, name, self.options);
        let read = self.options.files.read_text(&path, self.bytes);
        let included = read.map_err(|reason| match reason {
            ReadError::TooLarge(_) => format!("files of more than {MAX_BYTES} bytes are included"),
            reason => format!("`{name}` cannot be included: {reason}"),
        })?;
        self.bytes = self.bytes.saturating_sub(included.len() as u64);
        Ok((path.display().to_string(), included))
    }
}

/// Where a file lies that another includes: beside the first of all, or beside the one that
/// includes it, as in MuJoCo.
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
