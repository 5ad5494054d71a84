//! What a wheel is called: by its joint, link and meshes, and by the macro and the file that make it.

use super::source::Source;
use super::tree::{Motion, Tree};

/// All names of a wheel, and of the file that it stands in.
pub(super) fn of_wheel(source: &Source, tree: &Tree, joint: usize) -> Vec<String> {
    let (macros, file) = makers(source, &tree.joints[joint].name);
    own_and_held(tree, joint)
        .into_iter()
        .chain(macros)
        .chain(file)
        .collect()
}

/// The names of a wheel itself.
pub(super) fn of_wheel_itself(source: &Source, tree: &Tree, joint: usize) -> Vec<String> {
    let (macros, _) = makers(source, &tree.joints[joint].name);
    own_and_held(tree, joint)
        .into_iter()
        .chain(macros)
        .collect()
}

/// What a wheel's joint, link and meshes are called.
pub(super) fn own(tree: &Tree, joint: usize) -> Vec<String> {
    let joint = &tree.joints[joint];
    let name = std::iter::once(joint.name.clone());
    name.chain(of_link(tree, joint.child)).collect()
}

/// The same, and what the links are called that hang fixed on its link: a hub may hold the wheel proper.
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

/// What a link and its meshes are called.
fn of_link(tree: &Tree, link: usize) -> impl Iterator<Item = String> {
    let link = &tree.links[link];
    let shapes = link.shapes.iter().chain(&link.visuals);
    let meshes = shapes.filter_map(|shape| match &shape.geometry {
        urdf_rs::Geometry::Mesh { filename, .. } => Some(own_name(filename)),
        _ => None,
    });
    std::iter::once(link.name.clone()).chain(meshes)
}

/// Whether a name speaks of mecanum wheels, spelt as people do.
pub(super) fn is_mecanum(name: &str) -> bool {
    const SPELT: [&str; 7] = [
        "mecanum", "mechanum", "mecanuum", "macanum", "meccanum", "mecnum", "mcnamu",
    ];
    let lower = name.to_lowercase();
    SPELT.iter().any(|word| lower.contains(word))
}

/// Whether a name speaks of mecanum wheels in short, by the word `mec`: enough to propose them, and too little to take them.
pub(super) fn is_mec(name: &str) -> bool {
    let lower = name.to_lowercase();
    let mut words = lower.split(|c: char| !c.is_alphanumeric());
    words.any(|word| word == "mec")
}

/// Whether a name speaks of a wheel.
pub(super) fn is_of_wheel(name: &str) -> bool {
    name.to_lowercase().contains("wheel") || is_mecanum(name) || is_omni(name)
}

/// Whether a name speaks of omni wheels. The package in which a mesh lies is called after the robot and not after its wheels: robots whose
/// wheels are steered are called omnidirectional too.
pub(super) fn is_omni(name: &str) -> bool {
    let within = in_package(name).map_or(name, |(_, path)| path);
    within.to_lowercase().contains("omni")
}

/// Whether a name speaks of a robot that moves in all directions.
pub(super) fn is_free(name: &str) -> bool {
    let lower = name.to_lowercase();
    lower.contains("omni") || (lower.contains("holonomic") && !lower.contains("nonholonomic"))
}

/// The package that a mesh's path names, and the path in it.
pub(super) fn in_package(name: &str) -> Option<(&str, &str)> {
    let path = name.strip_prefix("package://");
    let path = path.or_else(|| name.strip_prefix("model://"))?;
    path.split_once('/')
}

/// The macros in which a joint is written, and the file, where an expansion knows them.
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

/// The comments of the file in which a joint is written, and of what it was expanded to.
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

/// What a mesh is called in the file: in a package, its path; otherwise its last part, for folders are called as they like.
fn own_name(mesh: &str) -> String {
    if mesh.starts_with("package://") || mesh.starts_with("model://") {
        return mesh.to_owned();
    }
    mesh.rsplit(['/', '\\'])
        .next()
        .unwrap_or_default()
        .to_owned()
}
