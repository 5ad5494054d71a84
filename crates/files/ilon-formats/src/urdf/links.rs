//! The links of a URDF for viewers: [`link_tree`] is the single reader for the scene, for frames
//! and for visual meshes.

use std::collections::{HashMap, HashSet};

use nalgebra::{Isometry3, Vector3};
use roxmltree::{Document, Node};

use super::inertia_from_shapes::origin;
use super::source::child;
use crate::model::{CollisionShape, Link, LinkJoint, LinkTree, Visual, VisualShape};
use crate::xml::numbers;

/// Returns the links of a URDF; `None` if they do not form one tree.
pub fn link_tree(urdf: &str) -> Option<LinkTree> {
    let document = Document::parse(urdf).ok()?;
    let robot = document.root_element();
    let named = |tag: &'static str| {
        let elements = robot.children().filter(move |node| node.has_tag_name(tag));
        elements.filter_map(|node| Some((node.attribute("name")?, node)))
    };
    let colors: HashMap<&str, [f64; 4]> = named("material")
        .filter_map(|(name, material)| Some((name, color(material)?)))
        .collect();
    let elements: HashMap<&str, Node> = named("link").collect();
    let mut below: HashMap<&str, Vec<usize>> = HashMap::new();
    let mut ends = Vec::new();
    let mut joints = Vec::new();
    for (name, joint) in named("joint") {
        let end = |tag| child(joint, tag)?.attribute("link");
        let (parent, child) = (end("parent")?, end("child")?);
        below.entry(parent).or_default().push(joints.len());
        ends.push(child);
        joints.push(LinkJoint {
            name: name.to_owned(),
            parent: 0,
            child: 0,
            parent_from_child: placed(joint),
        });
    }
    let children: HashSet<&str> = ends.iter().copied().collect();
    let root = named("link").find(|(link, _)| !children.contains(link))?.0;
    let mut links: Vec<Link> = Vec::with_capacity(elements.len());
    let mut waiting = vec![(root, None, Isometry3::identity())];
    while let Some((name, above, body_from_link)) = waiting.pop() {
        let place = links.len();
        if let Some(above) = above {
            let above: &mut LinkJoint = &mut joints[above];
            above.child = place;
        }
        for &joint in below.get(name).into_iter().flatten() {
            joints[joint].parent = place;
            let body_from_child = body_from_link * joints[joint].parent_from_child;
            waiting.push((ends[joint], Some(joint), body_from_child));
        }
        links.push(Link {
            name: name.to_owned(),
            above,
            body_from_link,
            visuals: visuals(*elements.get(name)?, &colors),
        });
        // A link with two parents, or a loop, is visited more often than there are links.
        if links.len() > elements.len() {
            return None;
        }
    }
    (links.len() == elements.len() && children.len() == joints.len())
        .then_some(LinkTree { links, joints })
}

/// Returns a link's visual shapes. A shape with a missing number is omitted.
fn visuals(link: Node, colors: &HashMap<&str, [f64; 4]>) -> Vec<Visual> {
    let mut shown = Vec::new();
    for visual in link.children().filter(|node| node.has_tag_name("visual")) {
        let material = child(visual, "material");
        let of_name = || colors.get(material?.attribute("name")?).copied();
        let color = material.and_then(color).or_else(of_name);
        let geometry = child(visual, "geometry");
        let shapes = geometry
            .into_iter()
            .flat_map(|geometry| geometry.children());
        shown.extend(shapes.filter_map(shape).map(|shape| Visual {
            link_from_visual: placed(visual),
            shape,
            color,
        }));
    }
    shown
}

fn shape(element: Node) -> Option<VisualShape> {
    let one = |name| numbers(element.attribute(name)?)?.first().copied();
    let solid = match element.tag_name().name() {
        "box" => {
            let sides_m: [f64; 3] = numbers(element.attribute("size")?)?.try_into().ok()?;
            CollisionShape::Box {
                half_extents_m: 0.5 * Vector3::from(sides_m),
            }
        }
        "sphere" => CollisionShape::Sphere {
            radius_m: one("radius")?,
        },
        "cylinder" => CollisionShape::Cylinder {
            radius_m: one("radius")?,
            length_m: one("length")?,
        },
        "capsule" => CollisionShape::Capsule {
            radius_m: one("radius")?,
            length_m: one("length")?,
        },
        "mesh" => {
            let scale = element.attribute("scale").and_then(numbers);
            let scale = scale.and_then(|scale| scale.try_into().ok());
            return Some(VisualShape::Mesh {
                name: element.attribute("filename")?.to_owned(),
                scale: scale.unwrap_or([1.0; 3]),
            });
        }
        _ => return None,
    };
    Some(VisualShape::Solid(solid))
}

/// Returns the pose of an element's `<origin>`.
fn placed(node: Node) -> Isometry3<f64> {
    child(node, "origin").map_or_else(Isometry3::identity, origin)
}

/// Returns the colour of a `<material>` itself.
fn color(material: Node) -> Option<[f64; 4]> {
    let rgba: [f64; 4] = numbers(child(material, "color")?.attribute("rgba")?)?
        .try_into()
        .ok()?;
    Some(rgba.map(|x| x.clamp(0.0, 1.0)))
}
