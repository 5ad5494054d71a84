//! Names of a wheel: of its joint, link and meshes, and of its macro and file.

use super::source::Source;
use super::tree::{Motion, Tree};

/// Returns all names of a wheel, and of its file.
pub(super) fn of_wheel(source: &Source, tree: &Tree, joint: usize) -> Vec<String> {
    let (macros, file) = makers(source, &tree.joints[joint].name);
    own_and_held(tree, joint)
        .into_iter()
        .chain(macros)
        .chain(file)
        .collect()
}

/// Returns the names of a wheel itself.
pub(super) fn of_wheel_itself(source: &Source, tree: &Tree, joint: usize) -> Vec<String> {
    let (macros, _) = makers(source, &tree.joints[joint].name);
    own_and_held(tree, joint)
        .into_iter()
        .chain(macros)
        .collect()
}

/// Returns the names of a wheel's joint, link and meshes.
pub(super) fn own(tree: &Tree, joint: usize) -> Vec<String> {
    let joint = &tree.joints[joint];
    let name = std::iter::once(joint.name.clone());
    name.chain(of_link(tree, joint.child)).collect()
}

/// The same, including links fixed to its link: a hub may carry the actual wheel.
fn own_and_held(tree: &Tree, joint: usize) -> Vec<String> {
    let mut found = own(tree, joint);
    let mut waiting = vec![tree.joints[joint].child];
    while let Some(link) = waiting.pop() {
        let held = tree.moving(Motion::Fixed).map(|j| &tree.joints[j]);
        for held in held.filter(|held| held.parent == link) {
            found.extend(of_link(tree, held.child));
            waiting.push(held.child);
        }
    }
    found
}

/// Returns the names of a link and its meshes.
fn of_link(tree: &Tree, link: usize) -> impl Iterator<Item = String> {
    let link = &tree.links[link];
    let shapes = link.shapes.iter().chain(&link.visuals);
    let meshes = shapes.filter_map(|shape| match &shape.geometry {
        urdf_rs::Geometry::Mesh { filename, .. } => Some(own_name(filename)),
        _ => None,
    });
    std::iter::once(link.name.clone()).chain(meshes)
}

/// Whether a name contains mecanum, in common spellings.
pub(super) fn is_mecanum(name: &str) -> bool {
    const SPELT: [&str; 7] = [
        "mecanum", "mechanum", "mecanuum", "macanum", "meccanum", "mecnum", "mcnamu",
    ];
    let lower = name.to_lowercase();
    SPELT.iter().any(|word| lower.contains(word))
}

/// Whether a name contains the word `mec`: enough to propose mecanum wheels, not enough to assume
/// them.
pub(super) fn is_mec(name: &str) -> bool {
    let lower = name.to_lowercase();
    let mut words = lower.split(|c: char| !c.is_alphanumeric());
    words.any(|word| word == "mec")
}

/// Whether a name contains a word for wheel.
pub(super) fn is_of_wheel(name: &str) -> bool {
    name.to_lowercase().contains("wheel") || is_mecanum(name) || is_omni(name)
}

/// Whether a name implies omni wheels. The package of a mesh is named after the robot and not after
/// its wheels: robots with steered wheels are called omnidirectional too.
pub(super) fn is_omni(name: &str) -> bool {
    let within = in_package(name).map_or(name, |(_, path)| path);
    within.to_lowercase().contains("omni")
}

/// Whether a name implies a robot that moves in all directions.
pub(super) fn is_free(name: &str) -> bool {
    let lower = name.to_lowercase();
    lower.contains("omni") || (lower.contains("holonomic") && !lower.contains("nonholonomic"))
}

/// Splits a mesh's path into its package and the path inside.
pub(super) fn in_package(name: &str) -> Option<(&str, &str)> {
    let path = name.strip_prefix("package://");
    let path = path.or_else(|| name.strip_prefix("model://"))?;
    path.split_once('/')
}

/// Returns the macros around a joint, and its file, if known from an expansion.
fn makers(source: &Source, joint: &str) -> (Vec<String>, Option<String>) {
    let origin = source
        .named("joint", joint)
        .and_then(|node| source.prepared.origin(node.range().start));
    let Some(origin) = origin else {
        return (Vec::new(), None);
    };
    let file = std::path::Path::new(&*origin.file).file_name();
    let file = file.map(|name| name.to_string_lossy().into_owned());
    let written = roxmltree::Document::parse(&origin.text).ok();
    let macros = written.iter().flat_map(|document| {
        let at = |node: &roxmltree::Node| node.range().contains(&origin.bytes.start);
        let around = document.descendants().filter(at);
        around
            .filter(|node| node.tag_name().name() == "macro")
            .filter_map(|node| node.attribute("name").map(str::to_owned))
            .collect::<Vec<_>>()
    });
    (macros.collect(), file)
}

/// Returns the comments of a joint's file, and of its expansion.
pub(super) fn comments_beside(source: &Source, joint: &str) -> Vec<String> {
    let of = |node: roxmltree::Node| {
        let comments = node.descendants().filter(roxmltree::Node::is_comment);
        let texts = comments.filter_map(|n| n.text().map(str::to_owned));
        texts.collect::<Vec<_>>()
    };
    let joint = source.named("joint", joint);
    let origin = joint.and_then(|node| source.prepared.origin(node.range().start));
    let written = origin.and_then(|origin| roxmltree::Document::parse(&origin.text).ok());
    let written = written.map_or_else(Vec::new, |document| of(document.root()));
    [of(source.robot()), written].concat()
}

/// Returns the name of a mesh in the file: in a package its path, otherwise its last part, because
/// folders have arbitrary names.
fn own_name(mesh: &str) -> String {
    if mesh.starts_with("package://") || mesh.starts_with("model://") {
        return mesh.to_owned();
    }
    mesh.rsplit(['/', '\\'])
        .next()
        .unwrap_or_default()
        .to_owned()
}

/// Whether a joint, the link that it moves, or one above them is called a caster.
pub(super) fn is_called_caster(tree: &Tree, joint: usize) -> bool {
    let says = |joint: usize| {
        let mut words = own(tree, joint).into_iter().map(|name| name.to_lowercase());
        words.any(|name| name.contains("caster") || name.contains("castor"))
    };
    says(joint) || tree.joints_above(joint).any(says)
}
