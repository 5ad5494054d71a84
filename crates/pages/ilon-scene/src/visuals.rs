//! What a URDF shows of a robot: the boxes, cylinders, spheres and meshes of its `<visual>` elements. The model of the robot has none
//! of them, for nothing touches the world there.

use std::collections::{HashMap, HashSet};

use ilon_robot::{Robot, VisualMeshes};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use crate::description::{Geometry, PlacedMesh, Shape, pose};

/// What is shown of the bodies of a robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Visuals {
    /// In the body frame.
    pub(crate) chassis: Vec<Shape>,
    /// Of the body on each joint, in the body frame while all joints stand at zero.
    pub(crate) bodies: Vec<Vec<Shape>>,
    /// Of each wheel, in its hub frame.
    pub(crate) hubs: Vec<Vec<Shape>>,
    /// How many meshes of chassis and hubs are left out.
    pub(crate) meshes: usize,
}

/// What a link is a part of.
#[derive(Clone, Copy)]
enum Of {
    Chassis,
    /// The body on a joint.
    Body(usize),
    Wheel(usize),
}

/// Reads them from a text that the robot was read from. What is not well formed shows nothing.
pub(crate) fn of_urdf(text: &str, robot: &Robot, looks: &VisualMeshes) -> Visuals {
    let Ok(document) = Document::parse(text) else {
        return Visuals::default();
    };
    File::of(&document, looks).visuals(robot)
}

/// The links of a file and the joints between them.
struct File<'a, 'input> {
    links: HashMap<&'a str, Node<'a, 'input>>,
    /// Of each link the joints below it.
    below: HashMap<&'a str, Vec<Node<'a, 'input>>>,
    children: HashSet<&'a str>,
    colors: HashMap<&'a str, [f32; 4]>,
    looks: &'a VisualMeshes,
}

fn child<'a, 'input>(node: Node<'a, 'input>, tag: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|n| n.has_tag_name(tag))
}

impl<'a, 'input> File<'a, 'input> {
    fn of(document: &'a Document<'input>, looks: &'a VisualMeshes) -> Self {
        let root = document.root_element();
        let named = |tag| {
            let elements = root.children().filter(move |n| n.has_tag_name(tag));
            elements.filter_map(|n| Some((n.attribute("name")?, n)))
        };
        let mut below: HashMap<&str, Vec<Node>> = HashMap::new();
        let mut children = HashSet::new();
        for (_, joint) in named("joint") {
            let end = |tag| child(joint, tag).and_then(|n| n.attribute("link"));
            if let (Some(parent), Some(link)) = (end("parent"), end("child")) {
                below.entry(parent).or_default().push(joint);
                children.insert(link);
            }
        }
        Self {
            links: named("link").collect(),
            below,
            children,
            colors: named("material")
                .filter_map(|(name, n)| Some((name, color(n)?)))
                .collect(),
            looks,
        }
    }

    fn visuals(&self, robot: &Robot) -> Visuals {
        let mut visuals = Visuals {
            bodies: vec![Vec::new(); robot.joints.len()],
            hubs: vec![Vec::new(); robot.wheels.len()],
            ..Visuals::default()
        };
        let wheels = robot.wheels.iter().enumerate();
        let wheels: HashMap<&str, usize> = wheels.map(|(i, w)| (w.name.as_str(), i)).collect();
        let rollers = robot.wheels.iter().flat_map(|w| &w.rollers);
        let rollers: HashSet<&str> = rollers.map(|r| r.name.as_str()).collect();

        let joints = robot.joints.iter().enumerate();
        let joints: HashMap<&str, usize> = joints.map(|(i, j)| (j.name.as_str(), i)).collect();
        // Which body a link belongs to: the chassis, that of a joint, or a wheel.
        let roots = self.links.keys().filter(|l| !self.children.contains(*l));
        let mut waiting: Vec<(&str, Isometry3<f64>, Of)> = roots
            .map(|l| (*l, Isometry3::identity(), Of::Chassis))
            .collect();
        let mut seen = HashSet::new();
        while let Some((link, body_from_link, of)) = waiting.pop() {
            // A loop would never end; no robot is read from a file with one.
            let Some(node) = self.links.get(link).filter(|_| seen.insert(link)) else {
                continue;
            };
            let carrier_from_link = match of {
                Of::Wheel(wheel) => robot.wheels[wheel].body_from_hub.inverse() * body_from_link,
                Of::Chassis | Of::Body(_) => body_from_link,
            };
            let shown = self.shown(*node, &carrier_from_link, &mut visuals.meshes);
            match of {
                Of::Chassis => visuals.chassis.extend(shown),
                Of::Body(joint) => visuals.bodies[joint].extend(shown),
                Of::Wheel(wheel) => visuals.hubs[wheel].extend(shown),
            }
            for joint in self.below.get(link).into_iter().flatten() {
                let name = joint.attribute("name").unwrap_or_default();
                let end = child(*joint, "child").and_then(|n| n.attribute("link"));
                if let Some(end) = end.filter(|_| !rollers.contains(name)) {
                    let below = match (of, wheels.get(name), joints.get(name)) {
                        (Of::Wheel(_), ..) => of,
                        (_, Some(wheel), _) => Of::Wheel(*wheel),
                        (_, None, Some(joint)) => Of::Body(*joint),
                        (_, None, None) => of,
                    };
                    waiting.push((end, body_from_link * origin(*joint), below));
                }
            }
        }
        visuals
    }

    fn shown(
        &self,
        link: Node,
        carrier_from_link: &Isometry3<f64>,
        meshes: &mut usize,
    ) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for visual in link.children().filter(|n| n.has_tag_name("visual")) {
            let Some(geometry) = child(visual, "geometry") else {
                continue;
            };
            let material = child(visual, "material");
            let of_name = || self.colors.get(material?.attribute("name")?).copied();
            let color = material.and_then(color).or_else(of_name);
            let at = carrier_from_link * origin(visual);
            let mut put = |shape_from_part: Isometry3<f64>, form| {
                let pose = pose(&(at * shape_from_part));
                if pose.iter().all(|x| x.is_finite()) {
                    shapes.push(Shape { pose, form, color });
                }
            };
            let size = |tag, name| numbers(child(geometry, tag)?.attribute(name)?);
            let one = |tag, name| size(tag, name)?.first().copied().map(|x| x as f32);
            if let Some([x, y, z]) = size("box", "size").as_deref() {
                put(
                    Isometry3::identity(),
                    Geometry::Box([x, y, z].map(|side| 0.5 * *side as f32)),
                );
            }
            if let Some(radius_m) = one("sphere", "radius") {
                put(Isometry3::identity(), Geometry::Sphere([radius_m]));
            }
            if let Some(mesh) = child(geometry, "mesh") {
                match self.mesh(mesh) {
                    Some(placed) => put(Isometry3::identity(), Geometry::Mesh(placed)),
                    None => *meshes += 1,
                }
            }
            for tag in ["cylinder", "capsule"] {
                let Some((radius_m, length_m)) = one(tag, "radius").zip(one(tag, "length")) else {
                    continue;
                };
                put(
                    Isometry3::identity(),
                    Geometry::Cylinder([radius_m, length_m]),
                );
                if tag == "capsule" {
                    for half in [-0.5, 0.5] {
                        let end = Translation3::new(0.0, 0.0, half * f64::from(length_m));
                        put(end.into(), Geometry::Sphere([radius_m]));
                    }
                }
            }
        }
        shapes
    }
}

impl File<'_, '_> {
    /// A mesh, where its file could be read.
    fn mesh(&self, mesh: Node) -> Option<PlacedMesh> {
        let (index, _) = self.looks.mesh(mesh.attribute("filename")?)?;
        let scale = mesh.attribute("scale").and_then(numbers);
        let scale = match scale.as_deref() {
            Some([x, y, z]) => [*x, *y, *z].map(|s| s as f32),
            _ => [1.0; 3],
        };
        Some(PlacedMesh { index, scale })
    }
}

/// The numbers of an attribute, all of them finite.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let numbers = text.split_whitespace().map(|n| n.parse::<f64>().ok());
    numbers.map(|n| n.filter(|n| n.is_finite())).collect()
}

/// Where an element's `<origin>` puts it.
fn origin(node: Node) -> Isometry3<f64> {
    let three = |name| -> Vector3<f64> {
        let text = child(node, "origin").and_then(|n| n.attribute(name));
        match text.and_then(numbers).as_deref() {
            Some([x, y, z]) => Vector3::new(*x, *y, *z),
            _ => Vector3::zeros(),
        }
    };
    let (xyz, rpy) = (three("xyz"), three("rpy"));
    Isometry3::from_parts(
        Translation3::from(xyz),
        UnitQuaternion::from_euler_angles(rpy.x, rpy.y, rpy.z),
    )
}

/// The colour that a `<material>` gives itself.
fn color(material: Node) -> Option<[f32; 4]> {
    let rgba = numbers(child(material, "color")?.attribute("rgba")?)?;
    let rgba: [f64; 4] = rgba.try_into().ok()?;
    Some(rgba.map(|x| x.clamp(0.0, 1.0) as f32))
}
