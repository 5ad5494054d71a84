//! Reads links and joints from the elements of a text, as the types of urdf-rs: only what is used.
//!
//! The reader of urdf-rs itself rejects files that ROS tools accept: scattered visuals, a second
//! limit, inertias without products. It also takes most of the time of a load, for it parses and
//! writes the text anew. The form of URDF was checked before, so that errors are rare here.

use std::collections::{HashMap, HashSet};

use nalgebra::UnitQuaternion;
use roxmltree::Node;
use urdf_rs::{
    Axis, Collision, Dynamics, Geometry, Inertia, Inertial, Joint, JointLimit, JointType, Link,
    LinkName, Mass, Mimic, Pose, Robot, Vec3, Visual,
};

use super::schema::GEOMETRIES;
use super::source::{Source, child};
use crate::model::Remark;

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

/// Reads the robot of a text, but for what is left out of it.
///
/// # Errors
/// In words, what the checks of the form of URDF let pass.
pub(super) fn robot(source: &Source, left_out: &LeftOut) -> Result<Robot, String> {
    let version = version(source.robot());
    let name = |node: &Node| node.attribute("name").unwrap_or_default().to_owned();
    let links = source.all("link");
    let links = links.filter(|link| !left_out.links.contains(&name(link)));
    let joints = source.all("joint");
    let joints = joints.filter(|joint| !left_out.joints.contains(&name(joint)));
    Ok(Robot {
        name: name(&source.robot()),
        version: None,
        links: links
            .map(|node| link(node, version))
            .collect::<Result<_, _>>()?,
        joints: joints
            .map(|node| joint(node, version))
            .collect::<Result<_, _>>()?,
        materials: Vec::new(),
    })
}

/// The version of URDF, major and minor; 1.0 if it is not stated.
fn version(robot: Node) -> (u32, u32) {
    let stated = robot.attribute("version").and_then(|version| {
        let (major, minor) = version.trim().split_once('.')?;
        Some((major.parse().ok()?, minor.parse().ok()?))
    });
    stated.unwrap_or((1, 0))
}

fn link(node: Node, version: (u32, u32)) -> Result<Link, String> {
    let mut link = Link {
        name: node.attribute("name").unwrap_or_default().to_owned(),
        inertial: Inertial::default(),
        visual: Vec::new(),
        collision: Vec::new(),
    };
    if let Some(stated) = child(node, "inertial") {
        let mass = child(stated, "mass").ok_or("`<inertial>` lacks `<mass>`")?;
        let moment = |name| match child(stated, "inertia") {
            Some(inertia) => Ok(number(inertia, name)?.unwrap_or(0.0)),
            None => Ok::<f64, String>(0.0),
        };
        link.inertial = Inertial {
            origin: pose(child(stated, "origin"), version)?,
            mass: Mass {
                value: required(mass, "value", number(mass, "value")?)?,
            },
            inertia: Inertia {
                ixx: moment("ixx")?,
                ixy: moment("ixy")?,
                ixz: moment("ixz")?,
                iyy: moment("iyy")?,
                iyz: moment("iyz")?,
                izz: moment("izz")?,
            },
        };
    }
    for shape in node.children() {
        let kind = child(shape, "geometry").and_then(|g| g.children().find(Node::is_element));
        let at = child(shape, "origin");
        match (shape.tag_name().name(), kind) {
            ("collision", Some(kind)) => link.collision.push(Collision {
                name: None,
                origin: pose(at, version)?,
                geometry: geometry(kind)?,
            }),
            // An invalid visual is no fault, and left out.
            ("visual", Some(kind)) if is_good(kind, at) => link.visual.push(Visual {
                name: None,
                origin: pose(at, version)?,
                geometry: geometry(kind)?,
                material: None,
            }),
            _ => {}
        }
    }
    Ok(link)
}

/// The place that an `<origin>` states; the frame's own where there is none.
fn pose(origin: Option<Node>, version: (u32, u32)) -> Result<Pose, String> {
    let Some(origin) = origin else {
        return Ok(Pose::default());
    };
    let mut pose = Pose {
        xyz: vector(origin, "xyz")?.unwrap_or_default(),
        rpy: vector(origin, "rpy")?.unwrap_or_default(),
    };
    if version >= (1, 1)
        && let Some(xyzw) = numbers::<4>(origin, "quat_xyzw")?
    {
        if origin.has_attribute("rpy") {
            return Err("`<origin>` states its rotation twice, by `rpy` and by `quat_xyzw`".into());
        }
        let rotation = UnitQuaternion::try_new(xyzw.into(), 0.0);
        let rotation = rotation.unwrap_or_default().to_rotation_matrix();
        pose.rpy = Vec3(ilon_robot::roll_pitch_yaw(&rotation));
    }
    Ok(pose)
}

fn geometry(kind: Node) -> Result<Geometry, String> {
    let length = |name| required(kind, name, number(kind, name)?);
    Ok(match kind.tag_name().name() {
        "box" => Geometry::Box {
            size: required(kind, "size", vector(kind, "size")?)?,
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
            scale: vector(kind, "scale")?,
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

fn joint(node: Node, version: (u32, u32)) -> Result<Joint, String> {
    let joint_type = match node.attribute("type").unwrap_or_default() {
        "revolute" => JointType::Revolute,
        "continuous" => JointType::Continuous,
        "prismatic" => JointType::Prismatic,
        "fixed" => JointType::Fixed,
        "floating" => JointType::Floating,
        "planar" => JointType::Planar,
        "spherical" => JointType::Spherical,
        other => return Err(format!("`{other}` is no type of a joint")),
    };
    let end = |tag| {
        let link = child(node, tag).and_then(|end| end.attribute("link"));
        let link = required(node, tag, link)?.to_owned();
        Ok::<LinkName, String>(LinkName { link })
    };
    // Nothing else of a fixed joint was checked. Its axis is not part of URDF, but shows how its
    // wheel would turn.
    let is_fixed = joint_type == JointType::Fixed;
    let checked = |tag| child(node, tag).filter(|_| !is_fixed);
    let axis = if is_fixed {
        stated_axis(node)
    } else {
        child(node, "axis")
    };
    let axis = axis.map(|axis| required(axis, "xyz", vector(axis, "xyz")?));
    let limit = checked("limit").map(|stated| limit(stated, version));
    let dynamics = checked("dynamics").map(|stated| {
        Ok::<Dynamics, String>(Dynamics {
            damping: number(stated, "damping")?.unwrap_or(0.0),
            friction: number(stated, "friction")?.unwrap_or(0.0),
        })
    });
    let mimic = child(node, "mimic").map(|stated| {
        Ok::<Mimic, String>(Mimic {
            joint: stated.attribute("joint").unwrap_or_default().to_owned(),
            multiplier: number(stated, "multiplier")?,
            offset: number(stated, "offset")?,
        })
    });
    Ok(Joint {
        name: node.attribute("name").unwrap_or_default().to_owned(),
        joint_type,
        origin: pose(child(node, "origin"), version)?,
        parent: end("parent")?,
        child: end("child")?,
        axis: axis
            .transpose()?
            .map_or_else(Axis::default, |xyz| Axis { xyz }),
        limit: limit.transpose()?.unwrap_or_default(),
        calibration: None,
        dynamics: dynamics.transpose()?,
        mimic: mimic.transpose()?,
        safety_controller: None,
    })
}

/// The limits of a joint. From URDF 1.2 on, a missing one means none.
fn limit(stated: Node, version: (u32, u32)) -> Result<JointLimit, String> {
    let is_none_meant = version >= (1, 2);
    let or = |name, none| {
        let missing = if is_none_meant { none } else { 0.0 };
        Ok::<f64, String>(number(stated, name)?.unwrap_or(missing))
    };
    let [lower, upper] = [or("lower", f64::NEG_INFINITY)?, or("upper", f64::INFINITY)?];
    if is_none_meant && upper < lower {
        return Err(format!(
            "`<limit>`: its upper limit {upper} lies below its lower limit {lower}"
        ));
    }
    Ok(JointLimit {
        lower,
        upper,
        effort: or("effort", f64::INFINITY)?,
        velocity: or("velocity", f64::INFINITY)?,
        ..JointLimit::default()
    })
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

fn vector(node: Node, attribute: &str) -> Result<Option<Vec3>, String> {
    Ok(numbers(node, attribute)?.map(Vec3))
}

fn required<T>(node: Node, part: &str, found: Option<T>) -> Result<T, String> {
    found.ok_or_else(|| format!("`<{}>` lacks `{part}`", node.tag_name().name()))
}
