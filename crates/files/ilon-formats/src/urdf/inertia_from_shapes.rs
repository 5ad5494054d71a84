//! Solids of a link's shapes, for mass and inertia missing in the file.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use roxmltree::Node;

use super::numbers::number;
use super::source::child;
use crate::model::MassProperties;
use crate::solid::Solid;
use crate::xml;

/// Returns the solid of a link's collision shapes, or else of its visual shapes, with a density of
/// 1 kg/m^3; `None` if there are only meshes.
pub(super) fn of_link(link: Node) -> Option<MassProperties> {
    let of = |tag: &'static str| {
        let shapes = link.children().filter(move |n| n.has_tag_name(tag));
        let solids: Vec<MassProperties> = shapes.filter_map(of_shape).collect();
        MassProperties::merged(&solids)
    };
    of("collision").or_else(|| of("visual"))
}

fn of_shape(shape: Node) -> Option<MassProperties> {
    let geometry = child(shape, "geometry")?
        .children()
        .find(Node::is_element)?;
    let positive = |name: &str| Some(number(geometry, name)).filter(|x| x.is_finite() && *x > 0.0);
    let solid = match geometry.tag_name().name() {
        "box" => Solid::Box {
            size_m: Vector3::from(
                numbers(geometry, "size").filter(|s| s.iter().all(|x| *x > 0.0))?,
            ),
        },
        "sphere" => Solid::ball(positive("radius")?),
        "cylinder" => Solid::Cylinder {
            radius_m: positive("radius")?,
            length_m: positive("length")?,
        },
        "capsule" => Solid::Capsule {
            radius_m: positive("radius")?,
            length_m: positive("length")?,
        },
        _ => return None,
    };
    let place = child(shape, "origin").map_or_else(Isometry3::identity, origin);
    Some(solid.weighing(solid.volume_m3()).moved(&place))
}

/// Returns the pose of an `<origin>`.
pub(super) fn origin(node: Node) -> Isometry3<f64> {
    let [roll, pitch, yaw] = numbers(node, "rpy").unwrap_or_default();
    Isometry3::from_parts(
        Translation3::from(Vector3::from(numbers(node, "xyz").unwrap_or_default())),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

fn numbers(node: Node, attribute: &str) -> Option<[f64; 3]> {
    xml::numbers(node.attribute(attribute)?)?.try_into().ok()
}
