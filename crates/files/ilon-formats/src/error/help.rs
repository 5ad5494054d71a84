//! Help with faults, in words that depend on what is at fault.

use super::named::Proposed;
use crate::xml;

/// Help without a CAD program.
pub(super) const BOX: &str = "for a solid box of mass m, ixx = m (y^2 + z^2) / 12";
/// Help with a description in TOML.
pub(super) const DESCRIPTIONS: &str = "every key is described in docs/format-robot.md, of robots on tyres in docs/format-robot-on-tyres.md; whole descriptions are in assets/robots";
/// What counts as a wheel with rollers.
pub(super) const WHEELS: &str = "a wheel is a continuous joint on a level axis, with three or more continuous roller joints below it on a \
     ring; or name the joints of wheels that are modelled without rollers; a robot whose file has no wheels is described in TOML, see docs/format-robot.md";
/// What counts as a wheel on tyres.
pub(super) const WHEELS_ON_TYRES: &str = "a wheel is a continuous joint on a level axis whose shape stands on the floor; or name the joints of all wheels";
/// Help with rollers that are not all there.
pub(super) const ROLLERS_APART: &str = "model each roller as a link on a turning joint of its own: what is part of the hub's mesh does not turn";
/// Help with rollers that leave gaps.
pub(super) const LONGER_ROLLERS: &str =
    "make the rollers longer: neighbours hand over at L = 2 a tan(pi/n) / cos(gamma)";

/// Start of the reason if a xacro file needs an unset environment variable.
pub(crate) const NOT_SET: &str = "the environment variable `";

/// Whether an attribute sets a shape's size to zero, as for links that are only frames.
pub(crate) fn is_zero_size(key: &str, value: &str) -> bool {
    ["size", "radius", "length"].contains(&key)
        && xml::numbers(value).is_some_and(|n| n.iter().all(|x| *x >= 0.0) && n.contains(&0.0))
}

/// Whether an argument only sets names.
pub(super) fn is_of_names(argument: &str) -> bool {
    let lower = argument.to_lowercase();
    lower.ends_with("name") || lower.ends_with("namespace") || lower.ends_with("prefix")
}

/// Help with an element that is missing.
pub(super) fn of_element(child: &str) -> String {
    match child {
        "inertia" => format!(
            "add `<inertia ixx=\"...\" ixy=\"0\" ixz=\"0\" iyy=\"...\" iyz=\"0\" izz=\"...\"/>`; {BOX}"
        ),
        child => format!("add `<{child}>` to the element"),
    }
}

/// Help with a file that cannot be read.
pub(super) fn of_reading(reason: &str) -> &'static str {
    match reason.contains("UTF-8") {
        true => "save it as UTF-8",
        false => "give the path of a file that exists and may be read",
    }
}

/// Help with XML that is not read.
pub(super) fn of_xml(reason: &str) -> &'static str {
    const HELP: [(&str, &str); 3] = [
        (
            "XML declaration",
            "an XML declaration, `<?xml ...?>`, stands at the very beginning of a file or nowhere: put it before all else, comments and empty \
             lines too, or leave it out",
        ),
        (
            "DTD",
            "leave out `<!DOCTYPE ...>`: it can name other files, and none of a robot's formats needs it",
        ),
        (
            "not a robot file",
            "name a URDF, xacro, SDF or MJCF file, or a description in TOML",
        ),
    ];
    let help = HELP.into_iter().find(|(word, _)| reason.contains(word));
    help.map_or(
        "close every element and quote every attribute",
        |(_, help)| help,
    )
}

/// Help with a xacro file that cannot be expanded.
pub(super) fn of_xacro(reason: &str) -> &'static str {
    match reason.contains(NOT_SET) {
        true => {
            "set the environment variable before the file is read, as a shell does by `NAME=VALUE` before a command"
        }
        false => {
            "repair the place that is named; a file that you trust can be expanded by the xacro of ROS, which runs what stands in it"
        }
    }
}

/// Help with wheels without rollers, by what the file suggests and why.
pub(super) fn of_rollers(rollers: &Proposed, why: Option<&str>) -> String {
    const WHICH: &str = "say which rollers they carry";
    const NOTHING: &str = "nothing in the file says that these are Swedish wheels";
    const ELSE_TYRES: &str = "if they are, say which rollers they carry, and they are put in; else let them roll on tyres";
    match (rollers, why) {
        (Proposed::Contradiction, Some(why)) => {
            format!("{why}; {WHICH} and on which joints, and they are put in")
        }
        (Proposed::Contradiction, None) => format!(
            "they are called mecanum wheels, whose hubs are parallel, and theirs are not: turn the joints so that they are, \
             for gamma is the angle of the rollers and not of the hubs; or {WHICH}, and they are put in"
        ),
        (Proposed::NothingSaid, None) => format!("{NOTHING}; {ELSE_TYRES}"),
        (Proposed::NothingSaid, Some(hint)) => format!("{NOTHING}: {hint}; {ELSE_TYRES}"),
        (Proposed::Rollers(_), Some(why)) => format!("{WHICH}, and they are put in; {why}"),
        (Proposed::Rollers(_), None) => format!("{WHICH}, and they are put in"),
    }
}
