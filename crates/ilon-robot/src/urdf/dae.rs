//! The vertices of a COLLADA mesh: positions of its geometries, placed by the nodes of its scene, in metres.
//!
//! The up axis that a file declares is left aside, as the tools of ROS do: the link's frame says which way is up.

use std::collections::HashMap;

use nalgebra::{Matrix4, Point3, Rotation3, Unit, Vector3};
use roxmltree::Node;

use super::source::child;
use crate::xml;

/// Most points of all instances together: a mesh that is placed a thousand times over multiplies.
const MOST_POINTS: usize = 20_000_000;

/// Reads the vertices of a COLLADA text.
pub(super) fn vertices(text: &str) -> Result<Vec<Point3<f64>>, String> {
    let document = xml::parse(text).map_err(|fault| match fault {
        xml::Fault::Malformed(reason, _) => reason,
        xml::Fault::TooMuch(what, most, _) => format!("{what}, where at most {most} are read"),
    })?;
    let root = document.root_element();
    let by_id: HashMap<&str, Node> = root
        .descendants()
        .filter_map(|n| Some((n.attribute("id")?, n)))
        .collect();
    let meter = named(root, "asset")
        .and_then(|asset| named(asset, "unit"))
        .and_then(|unit| unit.attribute("meter")?.trim().parse().ok())
        .unwrap_or(1.0);

    let mut points = Vec::new();
    let mut add = |geometry: Node, world: &Matrix4<f64>| -> Result<(), String> {
        for point in positions(geometry, &by_id)? {
            points.push(world.transform_point(&point) * meter);
        }
        if points.len() > MOST_POINTS {
            return Err(format!("it places more than {MOST_POINTS} points"));
        }
        Ok(())
    };
    let scenes: Vec<Node> = root
        .descendants()
        .filter(|n| n.tag_name().name() == "visual_scene")
        .collect();
    if scenes.is_empty() {
        // A file without a scene holds its geometries where they are.
        let all = || {
            root.descendants()
                .filter(|n| n.tag_name().name() == "geometry")
        };
        all().try_for_each(|geometry| add(geometry, &Matrix4::identity()))?;
        return Ok(points);
    }
    let mut waiting: Vec<(Node, Matrix4<f64>)> = scenes
        .into_iter()
        .map(|scene| (scene, Matrix4::identity()))
        .collect();
    while let Some((node, above)) = waiting.pop() {
        let world = above * transform(node)?;
        for inner in node.children().filter(Node::is_element) {
            match inner.tag_name().name() {
                "node" => waiting.push((inner, world)),
                "instance_geometry" => {
                    if let Some(&geometry) = referred(inner, "url").and_then(|id| by_id.get(id)) {
                        add(geometry, &world)?;
                    }
                }
                _ => {}
            }
        }
    }
    Ok(points)
}

/// The transform of a node: its matrices, shifts, turns and scales, in the order in which they stand.
fn transform(node: Node) -> Result<Matrix4<f64>, String> {
    let mut all = Matrix4::identity();
    for step in node.children().filter(Node::is_element) {
        let tag = step.tag_name().name();
        if !["matrix", "translate", "rotate", "scale"].contains(&tag) {
            continue;
        }
        all *= match (tag, &numbers(step)?[..]) {
            ("matrix", m) if m.len() == 16 => Matrix4::from_row_slice(m),
            ("translate", &[x, y, z]) => Matrix4::new_translation(&Vector3::new(x, y, z)),
            ("scale", &[x, y, z]) => Matrix4::new_nonuniform_scaling(&Vector3::new(x, y, z)),
            ("rotate", &[x, y, z, angle_deg]) => match Unit::try_new(Vector3::new(x, y, z), 1e-9) {
                Some(axis) => {
                    Rotation3::from_axis_angle(&axis, angle_deg.to_radians()).to_homogeneous()
                }
                None => Matrix4::identity(),
            },
            (tag, wrong) => return Err(format!("a `<{tag}>` holds {} numbers", wrong.len())),
        };
    }
    Ok(all)
}

/// The positions of a geometry: vertices -> input POSITION -> source -> float_array.
fn positions(geometry: Node, by_id: &HashMap<&str, Node>) -> Result<Vec<Point3<f64>>, String> {
    let array = named(geometry, "mesh")
        .and_then(|mesh| named(mesh, "vertices"))
        .and_then(|vertices| {
            vertices
                .children()
                .find(|n| n.attribute("semantic") == Some("POSITION"))
        })
        .and_then(|input| by_id.get(referred(input, "source")?))
        .and_then(|source| named(*source, "float_array"));
    match array {
        Some(array) => Ok(numbers(array)?
            .chunks_exact(3)
            .map(|p| Point3::new(p[0], p[1], p[2]))
            .collect()),
        // Splines and the like have no mesh.
        None => Ok(Vec::new()),
    }
}

fn numbers(node: Node) -> Result<Vec<f64>, String> {
    let text = node.text().unwrap_or_default();
    text.split_whitespace()
        .map(|word| {
            word.parse()
                .map_err(|_| format!("`{word}` is not a number"))
        })
        .collect()
}

/// The first child of that tag, whatever its namespace.
fn named<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    child(node, tag).or_else(|| node.children().find(|n| n.tag_name().name() == tag))
}

/// The id that an attribute refers to, `#id`.
fn referred<'a>(node: Node<'a, '_>, attribute: &str) -> Option<&'a str> {
    node.attribute(attribute)?.strip_prefix('#')
}
