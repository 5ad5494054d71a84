//! Solids of a link's shapes, for mass and inertia missing in the file.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use roxmltree::Node;

use super::numbers::number;
use super::source::child;
use crate::model::MassProperties;
use crate::xml;

/// A solid of uniform density.
#[derive(Clone, Debug)]
pub(super) struct Solid {
    pub(super) volume_m3: f64,
    /// Its mass properties with a density of 1 kg/m^3.
    unit: MassProperties,
}

impl Solid {
    /// A ball with a volume.
    pub(super) fn ball(volume_m3: f64) -> Self {
        let radius_m = libm::cbrt(3.0 * volume_m3 / (4.0 * PI));
        let moment = 0.4 * volume_m3 * radius_m * radius_m;
        Self::new(volume_m3, Vector3::repeat(moment))
    }

    fn new(volume_m3: f64, moments: Vector3<f64>) -> Self {
        Self {
            volume_m3,
            unit: MassProperties {
                mass_kg: volume_m3,
                center_of_mass_m: Vector3::zeros(),
                inertia_kg_m2: Matrix3::from_diagonal(&moments),
            },
        }
    }

    /// Returns its mass properties for a given mass.
    pub(super) fn weighing(&self, mass_kg: f64) -> MassProperties {
        MassProperties {
            mass_kg,
            center_of_mass_m: self.unit.center_of_mass_m,
            inertia_kg_m2: self.unit.inertia_kg_m2 * (mass_kg / self.volume_m3),
        }
    }
}

/// Returns the solid of a link's collision shapes, or else of its visual shapes; `None` if there
/// are only meshes.
pub(super) fn of_link(link: Node) -> Option<Solid> {
    let of = |tag: &'static str| {
        let shapes = link.children().filter(move |n| n.has_tag_name(tag));
        let solids: Vec<MassProperties> = shapes.filter_map(of_shape).map(|s| s.unit).collect();
        let unit = MassProperties::merged(&solids)?;
        Some(Solid {
            volume_m3: unit.mass_kg,
            unit,
        })
    };
    of("collision").or_else(|| of("visual"))
}

fn of_shape(shape: Node) -> Option<Solid> {
    let geometry = child(shape, "geometry")?
        .children()
        .find(Node::is_element)?;
    let positive = |name: &str| Some(number(geometry, name)).filter(|x| x.is_finite() && *x > 0.0);
    let solid = match geometry.tag_name().name() {
        "box" => {
            let size = numbers(geometry, "size").filter(|s| s.iter().all(|x| *x > 0.0))?;
            let [x, y, z] = size;
            let volume = x * y * z;
            let moments = Vector3::new(y * y + z * z, x * x + z * z, x * x + y * y);
            Solid::new(volume, moments * (volume / 12.0))
        }
        "sphere" => Solid::ball(4.0 / 3.0 * PI * positive("radius")?.powi(3)),
        // A capsule counts as the cylinder of its whole length.
        kind @ ("cylinder" | "capsule") => {
            let r = positive("radius")?;
            let ends = if kind == "capsule" { 2.0 * r } else { 0.0 };
            let length = positive("length")? + ends;
            let volume = PI * r * r * length;
            let across = volume * (3.0 * r * r + length * length) / 12.0;
            Solid::new(volume, Vector3::new(across, across, 0.5 * volume * r * r))
        }
        _ => return None,
    };
    let place = child(shape, "origin").map_or_else(Isometry3::identity, origin);
    Some(Solid {
        unit: solid.unit.moved(&place),
        ..solid
    })
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
