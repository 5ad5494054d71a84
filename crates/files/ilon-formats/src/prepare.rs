//! Converts the text of a robot's file to URDF: expands xacro, converts other formats.

use std::collections::{BTreeMap, HashMap};
use std::io::ErrorKind;
use std::path::Path;

use crate::error::{Fault, MissingFile, NOT_SET, RobotError};
use crate::files::ReadError;
use crate::model::Remark;
use crate::options::LoadOptions;
use crate::spec::{Spec, SpecOnTyres, is_on_tyres};
use crate::urdf::{LFS_POINTER, Origin, UrdfText, is_lfs_pointer, is_wheel_size};
use crate::{convert, generate, xml};

/// Returns the URDF text of a robot's file without checks or repairs: its own text, its xacro
/// expansion, or its conversion from another format.
///
/// # Errors
/// A file that cannot be read, expanded or converted: with everything that is missing at once.
pub fn urdf_text(path: impl AsRef<Path>, options: &LoadOptions) -> Result<String, RobotError> {
    let path = path.as_ref();
    let file = path.display().to_string();
    let text = read_text(path, &file, options)?;
    Ok(prepare(&text, &file, options)?.text.to_string())
}

/// Reads the text of a robot's file.
pub(crate) fn read_text(
    path: &Path,
    file: &str,
    options: &LoadOptions,
) -> Result<String, RobotError> {
    if let Some(format) = unread_format(path) {
        let reason =
            format!("{format} is not read; URDF, xacro, SDF, MJCF and descriptions in TOML are");
        return Err(RobotError::new(file, Fault::Format { reason }));
    }
    let text = options.files.read_text(path, xml::MAX_BYTES);
    if text
        .as_ref()
        .is_ok_and(|text| is_lfs_pointer(text.as_bytes()))
    {
        return Err(RobotError::new(file, Fault::unreadable(LFS_POINTER)));
    }
    text.map_err(|fault| {
        let fault = match fault {
            ReadError::TooLarge(most) => Fault::TooLarge {
                what: format!("more than {} MB of text", most >> 20),
                most: format!("{} MB", most >> 20),
            },
            ReadError::Io(error) if error.kind() == ErrorKind::NotFound => {
                let near = near(path, options);
                Fault::unreadable(format!("{}{near}", ReadError::Io(error)))
            }
            other => Fault::unreadable(other),
        };
        RobotError::new(file, fault)
    })
}

/// Returns the format of a file by its name, if it is an unsupported robot format.
fn unread_format(path: &Path) -> Option<&'static str> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    match ending.as_str() {
        "proto" => Some("a PROTO of Webots"),
        "usd" | "usda" | "usdc" | "usdz" => Some("USD"),
        _ => None,
    }
}

/// Returns a message about a similar file next to a missing one; empty if there is none.
fn near(path: &Path, options: &LoadOptions) -> String {
    /// Largest number of names read in the folder.
    const MOST_NAMES: usize = 1000;
    /// Smallest Jaro-Winkler similarity of two names of which one was meant for the other.
    const ALIKE: f64 = 0.8;
    let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else {
        return String::new();
    };
    let name = name.to_string_lossy();
    let folder = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    let names = options.files.names_in(folder, MOST_NAMES);
    if names.iter().any(|other| *other == name) {
        return "; its name is that of a link to a file that does not exist".to_owned();
    }
    let alike = names
        .into_iter()
        .map(|other| (strsim::jaro_winkler(&name, &other), other));
    let best = alike.max_by(|a, b| a.0.total_cmp(&b.0));
    best.filter(|(likeness, _)| *likeness > ALIKE)
        .map_or_else(String::new, |(_, other)| {
            format!("; did you mean `{other}`?")
        })
}

/// Converts a file's text to URDF.
pub(crate) fn prepare(
    text: &str,
    file: &str,
    options: &LoadOptions,
) -> Result<UrdfText, RobotError> {
    // A byte order mark is not part of the text.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if Path::new(file).extension().is_some_and(|e| e == "toml") {
        if is_on_tyres(text) {
            let spec = SpecOnTyres::from_toml_str_with(text, file, &options.spec)?;
            return Ok(UrdfText::as_it_is(
                file,
                &generate::generate_on_tyres(&spec),
            ));
        }
        let spec = Spec::from_toml_str_with(text, file, &options.spec)?;
        return Ok(UrdfText::as_it_is(file, &generate::generate(&spec)?));
    }
    if !options.spec.is_empty() {
        let keys = options.spec.keys().cloned().collect();
        return Err(RobotError::new(file, Fault::NotADescription { keys }));
    }
    let prepared = declared(UrdfText::as_it_is(file, text));
    let tag = root_tag_range(&prepared.text).map(|(start, end)| &prepared.text[start..end]);
    if let Some(converted) =
        tag.and_then(|tag| convert::converted(tag, file, &prepared.text, options))
    {
        return converted;
    }
    let is_called_xacro = Path::new(file).extension().is_some_and(|e| e == "xacro");
    let mut prepared = match is_called_xacro || is_xacro(&prepared.text) {
        true => expanded(&prepared, options)?,
        false => prepared,
    };
    prepared.settings = settings(&prepared, options);
    Ok(prepared)
}

/// Returns the keys and values of the YAML files that plug-ins name as their `<parameters>`, line
/// by line, ignoring nesting.
fn settings(prepared: &UrdfText, options: &LoadOptions) -> Vec<(String, String)> {
    /// Largest file, in bytes, and largest number of files.
    const MOST_BYTES: u64 = 1 << 20;
    const MOST_FILES: usize = 8;
    /// Longest value, in bytes: the name of a controller, or a number.
    const MOST_VALUE: usize = 200;
    const NAMES: &str = "parameters";
    // Most files have none.
    if !prepared.text.contains(NAMES) {
        return Vec::new();
    }
    let Ok(document) = xml::parse(&prepared.text) else {
        return Vec::new();
    };
    let named = document.descendants().filter(|n| n.has_tag_name(NAMES));
    let folder = Path::new(&prepared.file).parent().unwrap_or(Path::new(""));
    let texts = named.take(MOST_FILES).filter_map(|n| {
        let path = folder.join(n.text()?.trim());
        options.files.read_text(&path, MOST_BYTES).ok()
    });
    let of_line = |line: &str| {
        let (line, _) = line.split_once('#').unwrap_or((line, ""));
        let (key, value) = line.split_once(':')?;
        let bare = |text: &str| text.trim().trim_matches(['"', '\'']).to_owned();
        Some((bare(key), bare(value)))
    };
    let lines = texts.flat_map(|text| text.lines().filter_map(of_line).collect::<Vec<_>>());
    let is_short = |value: &str| !value.is_empty() && value.len() <= MOST_VALUE;
    lines.filter(|(_, value)| is_short(value)).collect()
}

/// Returns where the tag of a text's root element stands: its first that is neither declaration nor
/// comment. Its attributes may start at the end.
fn root_tag_range(text: &str) -> Option<(usize, usize)> {
    let mut rest = text;
    loop {
        rest = &rest[rest.find('<')? + 1..];
        let skipped = [("!--", "-->"), ("?", "?>"), ("!", ">")];
        match skipped.iter().find(|(begin, _)| rest.starts_with(begin)) {
            Some((_, end)) => rest = &rest[rest.find(end)? + end.len()..],
            None => break,
        }
    }
    let end = rest.find(|c: char| c.is_whitespace() || c == '>' || c == '/')?;
    let start = text.len() - rest.len();
    Some((start, start + end))
}

/// Adds missing declarations of XML namespaces, and leaves out a malformed one of XML, such as
/// `<?xml version=1.0?>`: programs that read neither accept such files.
fn declared(mut prepared: UrdfText) -> UrdfText {
    /// Largest number of declared prefixes.
    const MOST: usize = 16;
    let end = prepared.text.find("?>").map_or(0, |at| at + 2);
    let declaration = &prepared.text[..end];
    if declaration.starts_with("<?xml ") && xml::parse(&format!("{declaration}<r/>")).is_err() {
        let lines = "\n".repeat(declaration.matches('\n').count());
        prepared = prepared.edited(vec![(0..end, lines)]);
    }
    for _ in 0..MOST {
        let Err(xml::Fault::Malformed(reason, _)) = xml::parse(&prepared.text) else {
            break;
        };
        let prefix = reason
            .strip_prefix("an unknown namespace prefix '")
            .and_then(|rest| rest.strip_suffix('\''));
        let root = root_tag_range(&prepared.text).map(|(_, end)| end);
        let (Some(prefix), Some(root)) = (prefix, root) else {
            break;
        };
        let declaration = format!(" xmlns:{prefix}=\"http://example.org/{prefix}\"");
        prepared = prepared.edited(vec![(root..root, declaration)]);
    }
    prepared
}

/// Whether a text is the xacro source of a URDF: with xacro elements, or with expressions in place
/// of numbers and names.
fn is_xacro(text: &str) -> bool {
    // Most files hold none of these, and need no parsing here.
    if !["xacro", "${", "$("].iter().any(|mark| text.contains(mark)) {
        return false;
    }
    let Ok(document) = xml::parse(text) else {
        return text.contains("<xacro:");
    };
    let root = document.root_element();
    let of_xacro = |n: roxmltree::Node| {
        let namespace = n.tag_name().namespace().unwrap_or_default();
        namespace.contains("xacro") || text[n.range()].starts_with("<xacro:")
    };
    if root.tag_name().name() != "robot" {
        return false;
    }
    let declares = || root.namespaces().any(|n| n.uri().contains("xacro"));
    let substitutes = || text.contains("${") || text.contains("$(");
    if root.descendants().any(of_xacro) || (declares() && substitutes()) {
        return true;
    }
    let of_robot = root
        .children()
        .filter(|n| n.has_tag_name("link") || n.has_tag_name("joint"));
    of_robot.flat_map(|n| n.descendants()).any(|n| {
        n.attributes()
            .any(|a| a.value().contains("${") || a.value().contains("$(arg"))
    })
}

/// Expands a xacro file.
fn expanded(prepared: &UrdfText, options: &LoadOptions) -> Result<UrdfText, RobotError> {
    let file = prepared.file.as_str();
    let path = Path::new(file);
    let settings = xacro_expand::Settings {
        arguments: options.arguments.clone(),
        leave_out_missing: options.leave_out_missing,
        before_2014: options.repair,
        watch: Some(&|name| is_wheel_size(name).is_some()),
    };
    let machine = options.machine();
    let expanded = xacro_expand::expand(path, &prepared.text, &settings, &machine)
        .map_err(|failure| of_failure(file, *failure, options))?;
    let left = (!options.repair).then(|| left_over(&expanded)).flatten();
    if let Some((tag, place)) = left {
        let fault = Fault::OldXacro { tag };
        return Err(RobotError::new(&place.file, fault).at(&place.text, place.bytes.clone()));
    }
    let mut lines = Lines::default();
    let mut remarks = vec![Remark::new("xacro", of_arguments(&expanded.arguments))];
    for note in &expanded.notes {
        let mut remark = Remark::new(note.subject.clone(), note.words.clone());
        remark.line = Some(lines.of(&note.place));
        remark.file = Some(note.place.file.to_string()).filter(|of| of != file);
        remarks.push(remark);
    }
    for name in options.arguments.keys() {
        if !expanded.arguments.contains_key(name) {
            let subject = format!("argument `{name}`");
            let words =
                format!("the file declares no such argument: only `$(arg {name})` takes it");
            remarks.push(Remark::new(subject, words));
        }
    }
    let origins = expanded.origins.into_iter().map(|(at, place)| {
        let origin = Origin {
            line: lines.of(&place),
            file: place.file,
            text: place.text,
            bytes: place.bytes,
        };
        (at, origin)
    });
    let origins = origins.collect();
    let callers = if expanded.text.contains("<link") {
        Vec::new()
    } else {
        callers(path, options)
    };
    Ok(UrdfText {
        text: expanded.text.into(),
        origins,
        remarks,
        uncalled_macros: expanded.uncalled,
        callers,
        sizes: expanded.watched,
        choices: expanded.choices,
        ..UrdfText::as_it_is(file, "")
    })
}

/// Returns an element of xacro that remains in an expansion because it lacks its prefix: its result
/// is missing.
fn left_over(expanded: &xacro_expand::Expanded) -> Option<(String, &xacro_expand::Place)> {
    let starts = |tag| [" ", "/", ">"].map(|end| (tag, format!("<{tag}{end}")));
    let tags = expanded.unprefixed.iter().map(String::as_str);
    let left: Vec<(&str, String)> = tags.flat_map(starts).collect();
    let text = &expanded.text;
    let (mut at, mut found) = (0, None);
    while found.is_none() && at < text.len() {
        // What stands in a plugin is the plugin's.
        let end = text[at..]
            .find("<gazebo")
            .map_or(text.len(), |more| at + more);
        found = left.iter().find_map(|(tag, start)| {
            let more = text[at..end].find(start)?;
            Some((at + more, *tag))
        });
        // An empty element is closed at once.
        let tag_ends = text[end..].find('>').map_or(text.len(), |more| end + more);
        at = match text[..tag_ends].ends_with('/') {
            true => tag_ends,
            false => text[end..]
                .find("</gazebo>")
                .map_or(text.len(), |more| end + more + 1),
        };
    }
    let (at, tag) = found?;
    let after = expanded.origins.partition_point(|(start, _)| *start <= at);
    let (_, place) = expanded.origins.get(after.checked_sub(1)?)?;
    Some((tag.to_owned(), place))
}

/// Line numbers of places in files.
#[derive(Default)]
struct Lines {
    breaks: HashMap<*const u8, Vec<usize>>,
}

impl Lines {
    /// Returns the line of a place, from 1.
    fn of(&mut self, place: &xacro_expand::Place) -> usize {
        let text = &place.text;
        let breaks = self
            .breaks
            .entry(text.as_ptr())
            .or_insert_with(|| text.match_indices('\n').map(|(at, _)| at).collect());
        1 + breaks.partition_point(|line_break| *line_break < place.bytes.start)
    }
}

/// Returns the remark on the values of a xacro file's arguments.
fn of_arguments(arguments: &BTreeMap<String, String>) -> String {
    if arguments.is_empty() {
        return "expanded".to_owned();
    }
    let shown: Vec<String> = arguments
        .iter()
        .take(20)
        .map(|(name, value)| format!("{name} = {value}"))
        .collect();
    format!("expanded with {}", shown.join(", "))
}

/// Returns files that include a xacro file by name, next to it or in folders next to its own.
fn callers(path: &Path, options: &LoadOptions) -> Vec<String> {
    /// Largest number of files of a folder that are searched, and of folders.
    const MOST: usize = 200;
    let path = &std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else {
        return Vec::new();
    };
    let name = name.to_string_lossy();
    let above = folder.parent().unwrap_or(folder);
    let beside = options.files.names_in(above, MOST).into_iter();
    let beside = beside
        .map(|other| above.join(other))
        .filter(|other| other != folder);
    let all = std::iter::once(folder.to_owned()).chain(beside);
    all.flat_map(|folder| {
        let names = options.files.names_in(&folder, MOST);
        names.into_iter().map(move |name| folder.join(name))
    })
    .filter(|other| {
        let is_robot = |ending: &std::ffi::OsStr| ending == "xacro" || ending == "urdf";
        other != path && other.extension().is_some_and(is_robot)
    })
    .filter(|other| {
        let text = options.files.read_text(other, 1 << 20);
        text.is_ok_and(|text| {
            text.contains(&format!("/{name}\"")) || text.contains(&format!("\"{name}\""))
        })
    })
    .map(|other| other.display().to_string())
    .take(3)
    .collect()
}

/// Returns the texts with which a file compares an unset variable, as a message; empty for other
/// failures.
fn compared_with(reason: &xacro_expand::Reason, text: &str) -> String {
    /// Largest number of texts listed, and their largest length in bytes.
    const MOST: usize = 8;
    const LONGEST: usize = 40;
    if !reason.to_string().contains(NOT_SET) {
        return String::new();
    }
    let mut values: Vec<String> = Vec::new();
    for after in text.split("==").skip(1) {
        let after = after.trim_start();
        let quoted = after
            .strip_prefix('\'')
            .and_then(|rest| rest.split_once('\''));
        let Some((value, _)) = quoted else { continue };
        let is_short = value.len() <= LONGEST && !value.contains(char::is_control);
        let value = format!("`{value}`");
        if is_short && !values.contains(&value) && values.len() < MOST {
            values.push(value);
        }
    }
    match values.len() {
        0 => String::new(),
        _ => format!("; the file compares with {}", values.join(", ")),
    }
}

/// Returns the missing files, for packages with the folder that contains them.
fn missing_files(
    file: &str,
    missing: Vec<xacro_expand::Missing>,
    options: &LoadOptions,
) -> Vec<MissingFile> {
    let machine = options.machine();
    let folder_of = |package: &str| {
        let prefix = format!("$(find {package})/");
        let of_package = missing
            .iter()
            .filter(|m| m.package.as_deref() == Some(package));
        let paths: Vec<&str> = of_package
            .filter_map(|m| m.what.strip_prefix(&prefix))
            .collect();
        let from = Path::new(file).parent().unwrap_or(Path::new(""));
        xacro_expand::folder_that_holds(&machine, from, &paths)
    };
    let found = missing.iter().map(|m| MissingFile {
        what: m.what.clone(),
        package: m.package.clone(),
        folder: m.package.as_deref().and_then(folder_of),
        reason: Some(m.reason.clone()).filter(|reason| !reason.is_empty()),
        at: m.at.clone(),
    });
    found.collect()
}

/// Returns the error of a failed xacro expansion.
fn of_failure(file: &str, failure: xacro_expand::ExpandError, options: &LoadOptions) -> RobotError {
    let xacro_expand::ExpandError {
        reason,
        place,
        trail,
        missing,
        of_before_2014,
        ..
    } = failure;
    let fault = match reason {
        xacro_expand::Reason::Missing => Fault::MissingFiles {
            files: missing_files(file, missing, options),
        },
        xacro_expand::Reason::Argument(name) => Fault::MissingArgument {
            name,
            any_does: false,
        },
        xacro_expand::Reason::Xml(reason) => Fault::Xml { reason },
        xacro_expand::Reason::TooMuch(what, most) => Fault::TooLarge { what, most },
        other => {
            let text = place.as_ref().map(|place| &*place.text);
            let values = text.map_or_else(String::new, |text| compared_with(&other, text));
            Fault::Xacro {
                reason: format!("{other}{values}"),
                before_2014: of_before_2014,
            }
        }
    };
    let error = match place {
        Some(place) => RobotError::new(&place.file, fault).at(&place.text, place.bytes),
        None => RobotError::new(file, fault),
    };
    error.by(trail)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// Its name is in the folder, so no other was meant.
    #[test]
    fn a_link_to_nothing_is_said_to_be_one() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("robots.urdf"), "<robot/>").unwrap();
        std::os::unix::fs::symlink(at("gone.urdf"), at("robot.urdf")).unwrap();
        let said = |name: &str| {
            let error = urdf_text(at(name), &LoadOptions::default()).unwrap_err();
            error.to_string()
        };
        let of_link = said("robot.urdf");
        assert!(
            of_link.ends_with("that of a link to a file that does not exist"),
            "{of_link}"
        );
        let of_none = said("robos.urdf");
        assert!(
            of_none.ends_with("; did you mean `robots.urdf`?"),
            "{of_none}"
        );
    }
}
