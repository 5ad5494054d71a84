//! Reads links and joints from the elements of a text: only what is used. The form of URDF was
//! checked before, so that errors are rare here.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use roxmltree::Node;

use super::schema::GEOMETRIES;
use super::source::{Source, child};
use super::tree::{
    Geometry, JointPart, LinkPart, Mimic, Motion, Parts, PlacedShape, TreeJoint, TreeLink,
};
use crate::model::{Joint, MassProperties, MotorLimits, Remark};

/// A limited joint whose range is at least this is meant to turn endlessly: some files have 6.28.
const NEARLY_A_TURN_RAD: f64 = TAU - 0.01;

/// The parts left out of an incomplete file: joints of missing links, and everything then
/// disconnected.
#[derive(Debug, Default)]
pub(super) struct LeftOut {
    links: HashSet<String>,
    joints: HashSet<String>,
}

/// Finds what is disconnected when joints of missing links are left out. The tree of the first link
/// with the most links below it is the robot.
pub(super) fn without_missing(source: &Source) -> (LeftOut, Vec<Remark>) {
    let end = |joint: Node, tag| {
        let link = child(joint, tag).and_then(|n| n.attribute("link"));
        link.unwrap_or_default().to_owned()
    };
    let links: Vec<&str> = source
        .all("link")
        .filter_map(|n| n.attribute("name"))
        .collect();
    let known: HashSet<&str> = links.iter().copied().collect();
    let mut left_out = LeftOut::default();
    let mut remarks = Vec::new();
    let mut below: HashMap<String, Vec<(String, String)>> = HashMap::new();
    let mut hanging: HashSet<String> = HashSet::new();
    for joint in source.all("joint") {
        let name = joint.attribute("name").unwrap_or_default().to_owned();
        let (parent, child) = (end(joint, "parent"), end(joint, "child"));
        let missing = [&parent, &child]
            .into_iter()
            .find(|l| !known.contains(l.as_str()));
        if let Some(missing) = missing {
            let mut remark = Remark::new(
                format!("joint `{name}`"),
                format!("left out, for there is no link `{missing}`"),
            );
            source.place_at(&mut remark, joint);
            remarks.push(remark);
            left_out.joints.insert(name);
            continue;
        }
        hanging.insert(child.clone());
        below.entry(parent).or_default().push((name, child));
    }
    let tree_of = |root: &str| {
        let mut tree = HashSet::from([root.to_owned()]);
        let mut waiting = vec![root.to_owned()];
        while let Some(link) = waiting.pop() {
            for (_, child) in below.get(&link).into_iter().flatten() {
                if tree.insert(child.clone()) {
                    waiting.push(child.clone());
                }
            }
        }
        tree
    };
    let roots = links.iter().filter(|link| !hanging.contains(**link));
    let trees: Vec<(&str, HashSet<String>)> = roots.map(|root| (*root, tree_of(root))).collect();
    let largest = trees.iter().map(|(_, tree)| tree.len()).max().unwrap_or(0);
    let mut kept = false;
    for (root, tree) in trees {
        if !kept && tree.len() == largest {
            kept = true;
            continue;
        }
        let more = match tree.len() {
            1 => String::new(),
            count => format!(", and {} links below it", count - 1),
        };
        remarks.push(Remark::new(
            format!("link `{root}`"),
            format!("left out{more}: it hangs by nothing that is there"),
        ));
        for link in tree {
            for (joint, _) in below.get(&link).into_iter().flatten() {
                left_out.joints.insert(joint.clone());
            }
            left_out.links.insert(link);
        }
    }
    (left_out, remarks)
}

/// Reads the links and joints of a text, but for those that are left out of it.
///
/// # Errors
/// In words, what the checks of the form of URDF let pass.
pub(super) fn parts(source: &Source, left_out: &LeftOut) -> Result<Parts, String> {
    let version = version(source.robot());
    let links = source.all("link");
    let links = links.filter(|link| !left_out.links.contains(&name(*link)));
    let joints = source.all("joint");
    let joints = joints.filter(|joint| !left_out.joints.contains(&name(*joint)));
    let links: Result<Vec<LinkPart>, _> = links.map(|node| link(node, version)).collect();
    let joints: Result<Vec<JointPart>, _> = joints.map(|node| joint(node, version)).collect();
    Ok((links?, joints?))
}

fn name(node: Node) -> String {
    node.attribute("name").unwrap_or_default().to_owned()
}

/// The version of URDF, major and minor; 1.0 if it is not stated.
fn version(robot: Node) -> (u32, u32) {
    let stated = robot.attribute("version").and_then(|version| {
        let (major, minor) = version.trim().split_once('.')?;
        Some((major.parse().ok()?, minor.parse().ok()?))
    });
    stated.unwrap_or((1, 0))
}

fn link(node: Node, version: (u32, u32)) -> Result<LinkPart, String> {
    let mut part = LinkPart {
        link: TreeLink::new(name(node)),
        mass: None,
    };
    if let Some(stated) = child(node, "inertial") {
        let mass = required(stated, "mass", child(stated, "mass"))?;
        let moment = |name| match child(stated, "inertia") {
            Some(inertia) => Ok(number(inertia, name)?.unwrap_or(0.0)),
            None => Ok::<f64, String>(0.0),
        };
        let [xx, xy, xz] = [moment("ixx")?, moment("ixy")?, moment("ixz")?];
        let [yy, yz, zz] = [moment("iyy")?, moment("iyz")?, moment("izz")?];
        let mass = MassProperties {
            mass_kg: required(mass, "value", number(mass, "value")?)?,
            center_of_mass_m: Vector3::zeros(),
            inertia_kg_m2: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
        };
        let link_from_mass = pose(child(stated, "origin"), version)?;
        part.mass = (mass.mass_kg > 0.0).then_some((mass, link_from_mass));
    }
    for shape in node.children() {
        let kind = child(shape, "geometry").and_then(|g| g.children().find(Node::is_element));
        let origin = child(shape, "origin");
        let placed = match (shape.tag_name().name(), kind) {
            ("collision", Some(_)) => &mut part.link.shapes,
            // An invalid visual is no fault, and left out.
            ("visual", Some(kind)) if is_good(kind, origin) => &mut part.link.visuals,
            _ => continue,
        };
        placed.push(PlacedShape {
            body_from_shape: pose(origin, version)?,
            geometry: geometry(required(shape, "geometry", kind)?)?,
        });
    }
    Ok(part)
}

/// The pose that an `<origin>` states: rotation by roll, pitch and yaw about the fixed x, y and z
/// axes, in this order, then translation. Identity where there is none.
fn pose(origin: Option<Node>, version: (u32, u32)) -> Result<Isometry3<f64>, String> {
    let Some(origin) = origin else {
        return Ok(Isometry3::identity());
    };
    let [roll, pitch, yaw] = numbers(origin, "rpy")?.unwrap_or_default();
    let mut rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    if version >= (1, 1)
        && let Some(xyzw) = numbers::<4>(origin, "quat_xyzw")?
    {
        if origin.has_attribute("rpy") {
            return Err("`<origin>` states its rotation twice, by `rpy` and by `quat_xyzw`".into());
        }
        rotation = UnitQuaternion::try_new(xyzw.into(), 0.0).unwrap_or_default();
    }
    let xyz: [f64; 3] = numbers(origin, "xyz")?.unwrap_or_default();
    Ok(Isometry3::from_parts(
        Translation3::from(Vector3::from(xyz)),
        rotation,
    ))
}

fn geometry(kind: Node) -> Result<Geometry, String> {
    let length = |name| required(kind, name, number(kind, name)?);
    Ok(match kind.tag_name().name() {
        "box" => Geometry::Box {
            size: required(kind, "size", numbers(kind, "size")?)?,
        },
        "sphere" => Geometry::Sphere {
            radius: length("radius")?,
        },
        "cylinder" => Geometry::Cylinder {
            radius: length("radius")?,
            length: length("length")?,
        },
        "capsule" => Geometry::Capsule {
            radius: length("radius")?,
            length: length("length")?,
        },
        "mesh" => Geometry::Mesh {
            filename: required(kind, "filename", kind.attribute("filename"))?.to_owned(),
            scale: numbers(kind, "scale")?,
        },
        other => return Err(format!("`<{other}>` is no geometry")),
    })
}

/// Whether a visual has a supported geometry with valid numbers.
fn is_good(kind: Node, origin: Option<Node>) -> bool {
    let numbers = |node: Node, attribute: &str, count: usize| {
        let text = node.attribute(attribute);
        let numbers: Option<Vec<f64>> = text.map(|text| {
            text.split_whitespace()
                .filter_map(|s| s.parse().ok())
                .collect()
        });
        numbers.filter(|n| n.len() == count && n.iter().all(|x| x.is_finite() && x.abs() < 1e9))
    };
    let positive = |attribute: &str, count: usize| {
        numbers(kind, attribute, count).is_some_and(|n| n.iter().all(|x| *x > 0.0))
    };
    let placed = origin.is_none_or(|origin| {
        ["xyz", "rpy"]
            .into_iter()
            .all(|a| origin.attribute(a).is_none() || numbers(origin, a, 3).is_some())
    });
    let name = kind.tag_name().name();
    placed
        && GEOMETRIES.contains(&name)
        && match name {
            "box" => positive("size", 3),
            "sphere" => positive("radius", 1),
            "mesh" => {
                kind.attribute("filename").is_some()
                    && (kind.attribute("scale").is_none() || numbers(kind, "scale", 3).is_some())
            }
            _ => positive("radius", 1) && positive("length", 1),
        }
}

fn joint(node: Node, version: (u32, u32)) -> Result<JointPart, String> {
    let kind = node.attribute("type").unwrap_or_default();
    // Nothing else of a fixed joint was checked. Its axis is not part of URDF, but shows how its
    // wheel would turn.
    let checked = |tag| child(node, tag).filter(|_| kind != "fixed");
    let stated = stated_axis(node);
    let axis = match checked("axis").or(stated) {
        Some(axis) => required(axis, "xyz", numbers(axis, "xyz")?)?,
        None => [1.0, 0.0, 0.0],
    };
    let [lower, upper, effort, velocity] = limits(checked("limit"), version)?;
    let motion = match kind {
        "fixed" => Motion::Fixed,
        "continuous" => Motion::Turning,
        // Some tools have no continuous joints and write revolute ones of many turns, or of one.
        "revolute" if upper - lower >= NEARLY_A_TURN_RAD => Motion::Turning,
        "revolute" => Motion::Swinging,
        "prismatic" | "floating" | "planar" | "spherical" => Motion::Other,
        other => return Err(format!("`{other}` is no type of a joint")),
    };
    let slides = kind == "prismatic";
    // URDF writes 0 for a missing limit.
    let or_none = |limit: f64| if limit > 0.0 { limit } else { f64::INFINITY };
    let loss = |name| match checked("dynamics") {
        Some(dynamics) => Ok(number(dynamics, name)?.unwrap_or(0.0)),
        None => Ok::<f64, String>(0.0),
    };
    let mimic = child(node, "mimic").map(|mimic| {
        Ok::<Mimic, String>(Mimic {
            joint: mimic.attribute("joint").unwrap_or_default().to_owned(),
            multiplier: number(mimic, "multiplier")?.unwrap_or(1.0),
            offset: number(mimic, "offset")?.unwrap_or(0.0),
        })
    });
    let mimic = mimic.transpose()?;
    let end = |tag| {
        let link = child(node, tag).and_then(|end| end.attribute("link"));
        required(node, tag, link).map(str::to_owned)
    };
    Ok(JointPart {
        joint: TreeJoint {
            name: name(node),
            motion,
            parent: 0,
            child: 0,
            origin: Point3::origin(),
            axis: Vector3::x_axis(),
            states_axis: stated.is_some(),
            limits: MotorLimits {
                effort_n_m: or_none(effort),
                velocity_rad_s: or_none(velocity),
            },
            losses: Joint {
                damping_n_m_s: loss("damping")?,
                friction_n_m: loss("friction")?,
            },
            mimics: mimic.is_some(),
            mimic,
            slides,
            travel: match slides || kind == "revolute" {
                true => [lower, upper],
                false => [f64::NEG_INFINITY, f64::INFINITY],
            },
            effort,
        },
        parent: end("parent")?,
        child: end("child")?,
        parent_from_joint: pose(child(node, "origin"), version)?,
        axis: axis.into(),
    })
}

/// The limits of a joint: lower, upper, effort and velocity, 0 where none is stated. From URDF 1.2
/// on, one that `<limit>` leaves out means none.
fn limits(stated: Option<Node>, version: (u32, u32)) -> Result<[f64; 4], String> {
    const NONE: [(&str, f64); 4] = [
        ("lower", f64::NEG_INFINITY),
        ("upper", f64::INFINITY),
        ("effort", f64::INFINITY),
        ("velocity", f64::INFINITY),
    ];
    let mut limits = [0.0; 4];
    let Some(stated) = stated else {
        return Ok(limits);
    };
    let is_new = version >= (1, 2);
    for (limit, (name, none)) in limits.iter_mut().zip(NONE) {
        *limit = number(stated, name)?.unwrap_or(if is_new { none } else { 0.0 });
    }
    let [lower, upper, ..] = limits;
    match is_new && upper < lower {
        true => Err(format!(
            "`<limit>`: its upper limit {upper} lies below its lower limit {lower}"
        )),
        false => Ok(limits),
    }
}

/// Returns the axis of a joint, if stated and not zero.
pub(super) fn stated_axis<'a, 'i>(joint: Node<'a, 'i>) -> Option<Node<'a, 'i>> {
    let axis = child(joint, "axis")?;
    let text = axis.attribute("xyz")?;
    let numbers = text.split_whitespace().map(str::parse::<f64>);
    let numbers = numbers.collect::<Result<Vec<f64>, _>>().ok()?;
    let length: f64 = numbers.iter().map(|x| x.abs()).sum();
    (numbers.len() == 3 && length > 1e-6 && length < 1e9).then_some(axis)
}

/// Reads as many numbers; `None` where the attribute is missing.
fn numbers<const N: usize>(node: Node, attribute: &str) -> Result<Option<[f64; N]>, String> {
    let Some(text) = node.attribute(attribute) else {
        return Ok(None);
    };
    let read = text.split_whitespace().filter_map(|s| s.parse().ok());
    let read: Vec<f64> = read.collect();
    let wrong = |read: Vec<f64>| {
        let tag = node.tag_name().name();
        let count = read.len();
        format!("`{attribute}` of `<{tag}>` has {count} numbers where {N} are read: `{text}`")
    };
    read.try_into().map(Some).map_err(wrong)
}

fn number(node: Node, attribute: &str) -> Result<Option<f64>, String> {
    Ok(numbers(node, attribute)?.map(|[number]| number))
}

fn required<T>(node: Node, part: &str, found: Option<T>) -> Result<T, String> {
    found.ok_or_else(|| format!("`<{}>` lacks `{part}`", node.tag_name().name()))
}
