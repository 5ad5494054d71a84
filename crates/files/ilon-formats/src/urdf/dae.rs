//! Vertices and triangles of a COLLADA mesh: its geometries, placed by the nodes of its scene, in
//! metres.
//!
//! The declared up axis is ignored, as in ROS tools: the link's frame determines it.

use std::collections::HashMap;

use nalgebra::{Matrix4, Point3, Rotation3, Unit, Vector3};
use roxmltree::Node;

use super::source::child;
use crate::xml;

/// Largest number of points of all instances: a mesh placed a thousand times multiplies.
const MOST_POINTS: usize = 20_000_000;

/// Largest text that is read, in bytes, counted again at each place where it stands: twice the
/// largest file.
const MOST_READ: usize = 512 << 20;

/// Reads the vertices of a COLLADA text.
pub(super) fn vertices(text: &str) -> Result<Vec<Point3<f64>>, String> {
    let mut points = Vec::new();
    each_placed(text, &mut |geometry, by_id, metres_from_geometry| {
        for point in positions(geometry, by_id)? {
            points.push(metres_from_geometry.transform_point(&point));
        }
        within_bounds(points.len())
    })?;
    Ok(points)
}

/// Reads the triangles of a COLLADA text; polygons are split into fans.
pub(super) fn triangles(text: &str) -> Result<Vec<[Point3<f64>; 3]>, String> {
    let mut triangles = Vec::new();
    each_placed(text, &mut |geometry, by_id, metres_from_geometry| {
        let points: Vec<Point3<f64>> = positions(geometry, by_id)?
            .iter()
            .map(|point| metres_from_geometry.transform_point(point))
            .collect();
        let mesh = named(geometry, "mesh");
        for polygon in polygons(mesh.into_iter().flat_map(|mesh| mesh.children()))? {
            let corner = |at: usize| {
                let point = polygon.get(at).and_then(|index| points.get(*index));
                point
                    .copied()
                    .ok_or("a polygon names a point that is not there")
            };
            for second in 1..polygon.len().saturating_sub(1) {
                triangles.push([corner(0)?, corner(second)?, corner(second + 1)?]);
            }
            within_bounds(3 * triangles.len())?;
        }
        Ok(())
    })?;
    Ok(triangles)
}

/// Counts the text of a geometry and of its points, which is read at each place where it stands.
fn read_again(read: &mut usize, geometry: Node, by_id: &HashMap<&str, Node>) -> Result<(), String> {
    let points = array(geometry, by_id).map_or(0, |array| array.range().len());
    *read += geometry.range().len() + points;
    match *read > MOST_READ {
        true => Err(format!(
            "its geometries stand in so many places that more than {} MB are read",
            MOST_READ >> 20
        )),
        false => Ok(()),
    }
}

fn within_bounds(points: usize) -> Result<(), String> {
    if points > MOST_POINTS {
        return Err(format!("it places more than {MOST_POINTS} points"));
    }
    Ok(())
}

/// A callback with a geometry, the elements of its file by id, and the transform that places it, in
/// metres.
type Visit<'v> = dyn FnMut(Node, &HashMap<&str, Node>, &Matrix4<f64>) -> Result<(), String> + 'v;

/// Visits all geometries of a COLLADA text as placed by its scene.
fn each_placed(text: &str, visit: &mut Visit) -> Result<(), String> {
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
    let in_metres = Matrix4::new_scaling(meter);
    let scenes: Vec<Node> = root
        .descendants()
        .filter(|n| n.tag_name().name() == "visual_scene")
        .collect();
    let mut read = 0;
    if scenes.is_empty() {
        // Without a scene the geometries are not transformed.
        let mut all = root
            .descendants()
            .filter(|n| n.tag_name().name() == "geometry");
        return all.try_for_each(|geometry| {
            read_again(&mut read, geometry, &by_id)?;
            visit(geometry, &by_id, &in_metres)
        });
    }
    let mut waiting: Vec<(Node, Matrix4<f64>)> =
        scenes.into_iter().map(|scene| (scene, in_metres)).collect();
    while let Some((node, above)) = waiting.pop() {
        let world = above * transform(node)?;
        for inner in node.children().filter(Node::is_element) {
            match inner.tag_name().name() {
                "node" => waiting.push((inner, world)),
                "instance_geometry" => {
                    if let Some(&geometry) = referred(inner, "url").and_then(|id| by_id.get(id)) {
                        read_again(&mut read, geometry, &by_id)?;
                        visit(geometry, &by_id, &world)?;
                    }
                }
                _ => {}
            }
        }
    }
    Ok(())
}

/// Returns the polygons of a mesh's primitives, each as the indices of its points.
fn polygons<'a, 'i: 'a>(
    primitives: impl Iterator<Item = Node<'a, 'i>>,
) -> Result<Vec<Vec<usize>>, String> {
    let (mut polygons, mut seen) = (Vec::new(), 0);
    for primitive in primitives.filter(Node::is_element) {
        let kind = primitive.tag_name().name();
        if !["triangles", "polylist", "polygons"].contains(&kind) {
            continue;
        }
        let children = |tag: &'static str| {
            let elements = primitive.children().filter(Node::is_element);
            elements.filter(move |n| n.tag_name().name() == tag)
        };
        let offset = |input: Node| -> usize {
            let text = input.attribute("offset").unwrap_or_default();
            text.trim().parse().unwrap_or(0)
        };
        // A polygon's corner has one index per input: point, normal, texture coordinate.
        let stride = children("input").map(offset).max().unwrap_or(0);
        let stride = stride.saturating_add(1);
        let of_points = children("input")
            .find(|n| n.attribute("semantic") == Some("VERTEX"))
            .map_or(0, offset);
        let counts = match kind {
            "polylist" => children("vcount")
                .map(whole_numbers)
                .collect::<Result<Vec<_>, _>>()?,
            _ => Vec::new(),
        };
        let counts = counts.concat();
        for list in children("p") {
            let indices: Vec<usize> = whole_numbers(list)?;
            let corners: Vec<usize> = indices
                .chunks_exact(stride)
                .filter_map(|corner| corner.get(of_points).copied())
                .collect();
            match kind {
                "triangles" => polygons.extend(corners.chunks_exact(3).map(<[usize]>::to_vec)),
                "polygons" => polygons.push(corners),
                _ => {
                    let mut rest = &corners[..];
                    for &count in &counts {
                        // Those without corners count too.
                        seen += 1;
                        within_bounds(seen)?;
                        let Some((polygon, others)) = rest.split_at_checked(count) else {
                            return Err(
                                "a `<polylist>` holds fewer corners than it counts".to_owned()
                            );
                        };
                        polygons.push(polygon.to_vec());
                        rest = others;
                    }
                }
            }
        }
    }
    Ok(polygons)
}

/// Returns the transform of a node: its matrices, translations, rotations and scales, in their
/// order.
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

/// Returns the numbers of a geometry's positions: vertices -> input POSITION -> source ->
/// float_array.
fn array<'a, 'i>(
    geometry: Node<'a, 'i>,
    by_id: &HashMap<&str, Node<'a, 'i>>,
) -> Option<Node<'a, 'i>> {
    named(geometry, "mesh")
        .and_then(|mesh| named(mesh, "vertices"))
        .and_then(|vertices| {
            vertices
                .children()
                .find(|n| n.attribute("semantic") == Some("POSITION"))
        })
        .and_then(|input| by_id.get(referred(input, "source")?))
        .and_then(|source| named(*source, "float_array"))
}

/// Returns the positions of a geometry.
fn positions(geometry: Node, by_id: &HashMap<&str, Node>) -> Result<Vec<Point3<f64>>, String> {
    match array(geometry, by_id) {
        Some(array) => Ok(numbers(array)?
            .chunks_exact(3)
            .map(|p| Point3::new(p[0], p[1], p[2]))
            .collect()),
        // Splines and the like have no mesh.
        None => Ok(Vec::new()),
    }
}

fn numbers(node: Node) -> Result<Vec<f64>, String> {
    words(node)
}

fn whole_numbers(node: Node) -> Result<Vec<usize>, String> {
    words(node)
}

/// Parses the words of an element as numbers.
fn words<T: std::str::FromStr>(node: Node) -> Result<Vec<T>, String> {
    let text = node.text().unwrap_or_default();
    text.split_whitespace()
        .map(|word| {
            word.parse()
                .map_err(|_| format!("`{word}` is not a number"))
        })
        .collect()
}

/// Returns the first child with that tag, in any namespace.
fn named<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    child(node, tag).or_else(|| node.children().find(|n| n.tag_name().name() == tag))
}

/// Returns the id to which an attribute refers, `#id`.
fn referred<'a>(node: Node<'a, '_>, attribute: &str) -> Option<&'a str> {
    node.attribute(attribute)?.strip_prefix('#')
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A COLLADA text of one geometry with this text of points and these primitives, placed so many
    /// times.
    fn placed(points: &str, primitives: &str, times: usize) -> String {
        let places = "<instance_geometry url=\"#g\"/>".repeat(times);
        format!(
            "<COLLADA><library_geometries><geometry id=\"g\"><mesh>\
             <source id=\"s\"><float_array>{points}</float_array></source>\
             <vertices id=\"v\"><input semantic=\"POSITION\" source=\"#s\"/></vertices>\
             {primitives}</mesh></geometry></library_geometries>\
             <library_visual_scenes><visual_scene><node>{places}</node></visual_scene>\
             </library_visual_scenes></COLLADA>"
        )
    }

    /// A megabyte of points that are none, at a thousand places: a gigabyte to be read.
    #[test]
    fn a_long_text_at_many_places_is_refused() {
        let text = placed(&" ".repeat(1 << 20), "", 1000);
        for refused in [vertices(&text).err(), triangles(&text).err()] {
            let words = refused.expect("it is refused");
            assert!(words.contains("more than 512 MB are read"), "{words}");
        }
        assert_eq!(
            vertices(&placed("0 0 0 1 2 3", "", 1000)).map(|all| all.len()),
            Ok(2000)
        );
    }

    /// Ten thousand polygons without corners, counted again by each of ten thousand lists.
    #[test]
    fn polygons_without_corners_count_too() {
        let list = format!(
            "<polylist><vcount>{}</vcount>{}</polylist>",
            "0 ".repeat(10_000),
            "<p/>".repeat(10_000)
        );
        let words = triangles(&placed("0 0 0", &list, 1)).expect_err("they are too many");
        assert!(words.contains("more than 20000000"), "{words}");
    }
}
