//! The visuals of a robot's file, sorted by body. The robot's model does not contain them, as they
//! have no contact.

use std::collections::{HashMap, HashSet};

use ilon_robot::{CollisionShape, LinkTree, Robot, Visual, VisualMeshes, VisualShape};
use nalgebra::{Isometry3, Translation3, Vector3};

use crate::description::{Geometry, PlacedMesh, Shape, pose};

/// The visuals of a robot's bodies.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Visuals {
    /// In the body frame.
    pub(crate) chassis: Vec<Shape>,
    /// Of the body on each joint, in the body frame with all joints at zero.
    pub(crate) bodies: Vec<Vec<Shape>>,
    /// Of each wheel, in its hub frame.
    pub(crate) hubs: Vec<Vec<Shape>>,
    /// The number of meshes of chassis and hubs that are left out.
    pub(crate) meshes: usize,
}

/// The part of the robot that a link belongs to.
#[derive(Clone, Copy)]
enum Of {
    Chassis,
    /// The body on a joint.
    Body(usize),
    Wheel(usize),
    /// A roller, which is drawn by its exact outline.
    Roller,
}

/// Sorts the visuals of a file's links by body.
pub(crate) fn of_links(tree: &LinkTree, robot: &Robot, looks: &VisualMeshes) -> Visuals {
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
    // Of each link; parents come first.
    let mut parts: Vec<Of> = Vec::with_capacity(tree.links.len());
    for link in &tree.links {
        let above = link.above.map(|joint| &tree.joints[joint]);
        let of = above.map_or(Of::Chassis, |above| {
            let name = above.name.as_str();
            match (parts[above.parent], wheels.get(name), joints.get(name)) {
                (Of::Roller, ..) => Of::Roller,
                _ if rollers.contains(name) => Of::Roller,
                (Of::Wheel(wheel), ..) => Of::Wheel(wheel),
                (_, Some(wheel), _) => Of::Wheel(*wheel),
                (_, None, Some(joint)) => Of::Body(*joint),
                (of, None, None) => of,
            }
        });
        parts.push(of);
        let (carrier_from_link, shown) = match of {
            Of::Roller => continue,
            Of::Chassis => (link.body_from_link, &mut visuals.chassis),
            Of::Body(joint) => (link.body_from_link, &mut visuals.bodies[joint]),
            Of::Wheel(wheel) => {
                let hub_from_body = robot.wheels[wheel].body_from_hub.inverse();
                (
                    hub_from_body * link.body_from_link,
                    &mut visuals.hubs[wheel],
                )
            }
        };
        for visual in &link.visuals {
            let at = carrier_from_link * visual.link_from_visual;
            match shapes(visual, &at, looks) {
                Some(shapes) => shown.extend(shapes),
                None => visuals.meshes += 1,
            }
        }
    }
    visuals
}

/// A visual as drawn shapes, in the frame of its pose; `None` for a mesh that could not be read.
fn shapes(visual: &Visual, at: &Isometry3<f64>, looks: &VisualMeshes) -> Option<Vec<Shape>> {
    let color = visual.color.map(|rgba| rgba.map(|x| x as f32));
    let mut shapes = match &visual.shape {
        VisualShape::Solid(solid) => of_solid(solid, at, color),
        VisualShape::Mesh { name, scale } => {
            let (index, _) = looks.mesh(name)?;
            let scale = scale.map(|s| s as f32);
            vec![Shape {
                pose: pose(at),
                form: Geometry::Mesh(PlacedMesh { index, scale }),
                color,
            }]
        }
    };
    shapes.retain(|shape| shape.pose.iter().all(|x| x.is_finite()));
    Some(shapes)
}

/// A placed solid as drawn shapes: a hull as the box around it.
pub(crate) fn of_solid(
    solid: &CollisionShape,
    at: &Isometry3<f64>,
    color: Option<[f32; 4]>,
) -> Vec<Shape> {
    let shape = |solid_from_part: Isometry3<f64>, form: Geometry| Shape {
        pose: pose(&(at * solid_from_part)),
        form,
        color,
    };
    let of_box = |h: &Vector3<f64>| Geometry::Box([h.x as f32, h.y as f32, h.z as f32]);
    let here = Isometry3::identity();
    match solid {
        CollisionShape::Box { half_extents_m } => vec![shape(here, of_box(half_extents_m))],
        CollisionShape::Cylinder { radius_m, length_m } => {
            let form = Geometry::Cylinder([*radius_m as f32, *length_m as f32]);
            vec![shape(here, form)]
        }
        CollisionShape::Capsule { radius_m, length_m } => {
            let end = |sign: f64| {
                let up = Translation3::new(0.0, 0.0, sign * 0.5 * length_m);
                shape(up.into(), Geometry::Sphere([*radius_m as f32]))
            };
            let middle = Geometry::Cylinder([*radius_m as f32, *length_m as f32]);
            vec![shape(here, middle), end(-1.0), end(1.0)]
        }
        CollisionShape::Sphere { radius_m } => {
            vec![shape(here, Geometry::Sphere([*radius_m as f32]))]
        }
        CollisionShape::ConvexHull { points_m } => {
            let Some(first) = points_m.first() else {
                return Vec::new();
            };
            let (low, high) = points_m
                .iter()
                .fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
            let middle = Translation3::from(nalgebra::center(&low, &high).coords);
            vec![shape(middle.into(), of_box(&((high - low) * 0.5)))]
        }
    }
}
