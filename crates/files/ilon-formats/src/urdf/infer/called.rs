//! Names of a robot and its wheels, and of what drives it: plug-ins, controllers, comments.

use roxmltree::Node;

use crate::urdf::candidates::WheelLike;
use crate::urdf::names::{self, is_mec, is_mecanum, is_omni};
use crate::urdf::source::Source;
use crate::urdf::tree::Tree;

/// Returns the evidence for mecanum wheels, as text: a name or a plug-in.
pub(super) fn speaks_of_mecanum(
    source: &Source,
    tree: &Tree,
    wheels: &[WheelLike],
) -> Option<String> {
    let in_short = || in_short(source, tree, wheels);
    let is_plain = is_driven_as_plain(source);
    let name = called(source, tree, wheels).or_else(|| in_short().filter(|_| !is_plain));
    let name = name.map(|name| format!("the name `{name}`"));
    name.or_else(|| plugin(source).map(|plugin| format!("the plug-in `{plugin}`")))
}

/// Returns a name of the robot or of its wheels that abbreviates mecanum.
fn in_short(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> Option<String> {
    let own = names_of_robot(source).into_iter();
    let of_wheels = wheels
        .iter()
        .flat_map(|wheel| names::of_wheel(source, tree, wheel.joint));
    own.chain(of_wheels).find(|name| is_mec(name))
}

/// Whether a name of the robot or of its wheels abbreviates mecanum.
pub(super) fn is_called_in_short(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> bool {
    in_short(source, tree, wheels).is_some()
}

/// Returns a comment that names mecanum wheels in the form of a heading, without its decoration:
/// enough to propose them, not enough to assume them. Longer comments often describe the past or
/// future.
pub(super) fn heading(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> Option<String> {
    /// Longest heading, in bytes.
    const LONGEST: usize = 60;
    let comments = names::comments_beside(source, &tree.joints[wheels.first()?.joint].name);
    let mut headings = comments.into_iter().filter_map(|text| {
        let words = text.trim_matches(|c: char| !c.is_alphanumeric());
        let is_heading = words.len() <= LONGEST && !text.contains('<') && !words.contains('\n');
        is_heading.then(|| words.to_owned())
    });
    headings.find(|words| is_mecanum(words))
}

/// Returns a plug-in that moves the base in all directions, if a weak name supports it: its own, or
/// one that starts like mecanum.
pub(super) fn mover(source: &Source) -> Option<String> {
    let plugin = planar_mover(source)?;
    let own = plugin.attribute("name").unwrap_or_default();
    let robot = names_of_robot(source);
    let mut names = robot.iter().map(String::as_str).chain([own]);
    let name = names.find(|name| names::is_free(name) || name.to_lowercase().contains("meca"))?;
    let file = plugin.attribute("filename").unwrap_or_default();
    Some(format!(
        "the plug-in `{file}` that moves the base in all directions, the name `{name}`"
    ))
}

/// Returns the plug-in that moves a base in all directions, on any kind of wheel.
fn planar_mover<'a, 'i>(source: &'a Source<'i>) -> Option<Node<'a, 'i>> {
    let moves = |n: &Node| {
        let named = [n.attribute("filename"), n.attribute("name")];
        named
            .into_iter()
            .flatten()
            .any(|name| name.to_lowercase().contains("planar_move"))
    };
    plugin_elements(source).find(moves)
}

/// Returns hints at a robot that moves in all directions, which are not enough to propose rollers,
/// as text.
pub(super) fn hint(source: &Source) -> Option<String> {
    let mover = planar_mover(source)?;
    let named = [mover.attribute("filename"), mover.attribute("name")];
    let plugin = named.into_iter().flatten().next()?;
    Some(format!(
        "the plug-in `{plugin}` moves the base in all directions, whatever its wheels are"
    ))
}

/// The kind of wheel by its own name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Mecanum,
    Omni,
}

pub(super) fn kind(source: &Source, tree: &Tree, wheel: &WheelLike) -> Option<Kind> {
    let names = names::of_wheel_itself(source, tree, wheel.joint);
    if names.iter().any(|name| is_mecanum(name)) {
        return Some(Kind::Mecanum);
    }
    let is_omni = names.iter().any(|name| is_omni(name));
    is_omni.then_some(Kind::Omni)
}

/// Whether some of the wheels are named mecanum wheels, and others omni wheels.
pub(super) fn are_of_two_kinds(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> bool {
    let mut kinds = wheels.iter().filter_map(|like| kind(source, tree, like));
    let first = kinds.next();
    kinds.any(|kind| Some(kind) != first)
}

/// Returns a name that implies motion in all directions: of each wheel, if all are named omni
/// wheels; or of the robot, of its file or of a mesh's package.
pub(super) fn free_name(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> Option<String> {
    let of_wheel = |wheel: &WheelLike| {
        let names = names::of_wheel_itself(source, tree, wheel.joint);
        names.into_iter().find(|name| is_omni(name))
    };
    let of_wheels: Option<Vec<String>> = wheels.iter().map(of_wheel).collect();
    if let Some(name) = of_wheels.and_then(|names| names.into_iter().next()) {
        return Some(name);
    }
    let shapes = tree.links.iter().flat_map(|link| {
        let shapes = link.visuals.iter().chain(&link.shapes);
        shapes.filter_map(|shape| match &shape.geometry {
            urdf_rs::Geometry::Mesh { filename, .. } => names::in_package(filename),
            _ => None,
        })
    });
    let packages = shapes.map(|(package, _)| package.to_owned());
    let mut own = names_of_robot(source).into_iter().chain(packages);
    own.find(|name| names::is_free(name))
}

/// Whether a plug-in or a controller drives the robot with plain wheels.
pub(super) fn is_driven_as_plain(source: &Source) -> bool {
    const PLAIN: [&str; 4] = ["diff_drive", "diffdrive", "skid_steer", "ackermann"];
    let is_plain = |name: &str| {
        let lower = name.to_lowercase().replace('-', "_");
        PLAIN.iter().any(|word| lower.contains(word))
    };
    let settings = source.prepared.settings.iter();
    let mut types = settings.filter(|(key, _)| key == "type");
    types.any(|(_, kind)| is_plain(kind)) || plugins(source).any(is_plain)
}

/// Whether a wheel itself is named an omni wheel.
pub(super) fn is_called_omni(source: &Source, tree: &Tree, wheel: &WheelLike) -> bool {
    let names = names::of_wheel_itself(source, tree, wheel.joint);
    names.iter().any(|name| is_omni(name))
}

/// Returns what drives mecanum wheels: a plug-in, by its name or file, or a controller in its
/// settings.
pub(super) fn plugin(source: &Source) -> Option<String> {
    let types = source.prepared.settings.iter();
    let mut types = types.filter(|(key, _)| key == "type").map(|(_, kind)| kind);
    let controller = match types.clone().any(|kind| kind.contains("diff_drive")) {
        true => None,
        false => types.find(|kind| is_mecanum(kind)),
    };
    if let Some(controller) = controller {
        return Some(controller.clone());
    }
    plugins(source)
        .find(|name| is_mecanum(name))
        .map(str::to_owned)
}

/// Returns the files and the names of a simulator's plug-ins.
fn plugins<'a>(source: &'a Source) -> impl Iterator<Item = &'a str> {
    plugin_elements(source)
        .flat_map(|n| [n.attribute("filename"), n.attribute("name")])
        .flatten()
}

/// Returns the elements of a simulator's plug-ins.
fn plugin_elements<'a, 'i>(source: &'a Source<'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    let gazebo = source
        .robot()
        .children()
        .filter(|n| n.has_tag_name("gazebo"));
    let elements = gazebo.flat_map(|n| n.children());
    elements.filter(|n| n.has_tag_name("plugin"))
}

/// Returns where the file names the wheels mecanum wheels: in their joints, links or meshes, in
/// their macro or its file, in the robot's name or the file's own.
pub(super) fn called(source: &Source, tree: &Tree, wheels: &[WheelLike]) -> Option<String> {
    let of_wheel = |wheel: &WheelLike| {
        let names = names::of_wheel(source, tree, wheel.joint);
        names.into_iter().find(|name| is_mecanum(name))
    };
    wheels
        .iter()
        .find_map(of_wheel)
        .or_else(|| robot_called(source))
}

/// Returns the name of the robot, or else of its file, if it names mecanum wheels.
pub(super) fn robot_called(source: &Source) -> Option<String> {
    names_of_robot(source)
        .into_iter()
        .find(|name| is_mecanum(name))
}

/// Returns the name of the robot, and that of its file.
fn names_of_robot(source: &Source) -> Vec<String> {
    let robot = source.robot().attribute("name").map(str::to_owned);
    let file = std::path::Path::new(&source.prepared.file)
        .file_name()
        .map(|name| name.to_string_lossy().into_owned());
    [robot, file].into_iter().flatten().collect()
}
