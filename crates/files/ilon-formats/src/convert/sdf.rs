//! SDF, the format of Gazebo: the model of a file in which most wheels are seen.
//!
//! SDF gives every link a pose of its own, of the model or of whatever frame `relative_to` names,
//! and every joint one of its child link. A URDF hangs links by their joints: here a link's frame
//! is that of the joint above it, and that of the only root that holds others the model's, whose x is
//! ahead.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::f64::consts::TAU;
use std::rc::Rc;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use roxmltree::Node;

use super::assembled::Assembled;
use super::choice::with_most_wheels;
use super::ellipsoid::{Placed, ellipsoid};
use super::malformed::of_xml;
use super::nested;
use super::writer::{FAR_M, JointOf, ShapeOf, Writer};
use crate::error::RobotError;
use crate::generate::elements::attribute as escaped;
use crate::model::{JointSpring, Remark};
use crate::options::LoadOptions;
use crate::urdf::{UrdfText, child, text_of};
use crate::xml::{self, numbers};

/// Deepest chain of frames that are each relative to another.
const MOST_FRAMES: usize = 100;
/// Most models of a file that are looked at.
const MOST_MODELS: usize = 20;
/// Limits beyond this are none.
const NO_LIMIT: f64 = 1e12;

/// The URDF of the robot in an SDF text.
pub(super) fn converted(
    file: &str,
    text: &str,
    options: &LoadOptions,
) -> Result<UrdfText, RobotError> {
    let mut remarks = Vec::new();
    let whole = Rc::new(nested::flattened(file, text, options, &mut remarks)?);
    let text = &whole.text;
    let document = xml::parse(text).map_err(|fault| of_xml(file, text, fault))?;
    let root = document.root_element();
    let mut models: Vec<Node> = root
        .descendants()
        .filter(|n| n.has_tag_name("model") && child(*n, "link").is_some())
        .collect();
    let joints_of = |model: &Node| model.children().filter(|n| n.has_tag_name("joint")).count();
    models.sort_by_key(|model| std::cmp::Reverse(joints_of(model)));
    models.truncate(MOST_MODELS);
    let fault =
        |node: Node, reason: String| whole.error(file, xml::opening_tag(text, node), reason);
    let version = root.attribute("version").unwrap_or_default();
    let written = models.iter().map(|model| {
        let reader = Model {
            model: *model,
            frames: frames_by_name(*model),
            old_axes: version_before(version, (1, 5)),
            leaves_out: options.leave_out_missing,
            repairs: options.repair,
            fault: &fault,
        };
        let mut prepared = UrdfText::as_it_is(file, "");
        prepared.remarks.clone_from(&remarks);
        let (urdf, origins) = reader.write(&whole, &mut prepared.remarks)?;
        prepared.springs = reader.springs()?;
        prepared.text = urdf.into();
        prepared.origins = origins;
        if models.len() > 1 {
            let name = model.attribute("name").unwrap_or_default();
            let words = format!(
                "the robot of {} models in the file: the one in which most wheels are seen",
                models.len()
            );
            let subject = format!("model `{name}`");
            prepared.remarks.push(Remark::new(subject, words));
        }
        Ok(prepared)
    });
    with_most_wheels(written).unwrap_or_else(|| {
        let reason = "it holds no `<model>` with links of its own".to_owned();
        Err(fault(root, reason))
    })
}

fn version_before(version: &str, limit: (u32, u32)) -> bool {
    let numbers = version.split_once('.').and_then(|(major, minor)| {
        Some((
            major.trim().parse::<u32>().ok()?,
            minor.trim().parse::<u32>().ok()?,
        ))
    });
    numbers.is_some_and(|numbers| numbers < limit)
}

fn number_of(node: Node, tag: &str) -> Option<f64> {
    text_of(node, tag)?
        .parse()
        .ok()
        .filter(|x: &f64| x.is_finite())
}

fn vector_of(node: Node, tag: &str) -> Option<Vector3<f64>> {
    let values = numbers(text_of(node, tag)?)?;
    Some(Vector3::from(<[f64; 3]>::try_from(values).ok()?))
}

struct Model<'a, 'i, 'f> {
    model: Node<'a, 'i>,
    /// The links, joints and frames by their names; of a name, the link is the first.
    frames: HashMap<&'a str, Node<'a, 'i>>,
    /// Whether axes are given in the model's frame, as they were before SDF 1.5.
    old_axes: bool,
    /// Whether joints to links of absent models are left out.
    leaves_out: bool,
    /// Whether joints that close loops are left out.
    repairs: bool,
    fault: &'f dyn Fn(Node, String) -> RobotError,
}

fn frames_by_name<'a, 'i>(model: Node<'a, 'i>) -> HashMap<&'a str, Node<'a, 'i>> {
    let mut frames = HashMap::new();
    for tag in ["link", "joint", "frame"] {
        for node in model.children().filter(|n| n.has_tag_name(tag)) {
            if let Some(name) = node.attribute("name") {
                frames.entry(name).or_insert(node);
            }
        }
    }
    frames
}

/// A joint with its two links.
struct Hinge<'a, 'i> {
    node: Node<'a, 'i>,
    parent: String,
    child: String,
    /// Whether the two are exchanged: SDF may hang a link by several joints, as long as they close
    /// no loop.
    is_reversed: bool,
}

impl Hinge<'_, '_> {
    fn name(&self) -> &str {
        self.node.attribute("name").unwrap_or_default()
    }

    /// Whether it turns about two axes.
    fn is_double(&self) -> bool {
        let kind = self.node.attribute("type").unwrap_or_default();
        ["universal", "revolute2"].contains(&kind)
    }

    /// The link between its two axes.
    fn between(&self) -> String {
        format!("{}::between", self.name())
    }

    /// The link that the file calls the child, in whose frame the joint stands.
    fn said_child(&self) -> &str {
        match self.is_reversed {
            true => &self.parent,
            false => &self.child,
        }
    }
}

/// The link that stands for all that are joined to a link; `groups` has one nearer to it for each.
fn group(groups: &HashMap<String, String>, link: &str) -> String {
    let mut link = link;
    while let Some(nearer) = groups.get(link) {
        link = nearer;
    }
    link.to_owned()
}

/// The joints to exchange the links of, so that none hangs by two: they lead away from the link
/// that holds most by the file's own directions. None, if none hangs by two. For joints without
/// loops.
fn reversed(hinges: &[Hinge]) -> Vec<usize> {
    let mut hung = HashSet::new();
    if hinges.iter().all(|hinge| hung.insert(hinge.child.as_str())) {
        return Vec::new();
    }
    let mut ends: HashMap<&str, Vec<(usize, &str, bool)>> = HashMap::new();
    for (index, hinge) in hinges.iter().enumerate() {
        let (parent, child) = (hinge.parent.as_str(), hinge.child.as_str());
        ends.entry(parent).or_default().push((index, child, false));
        ends.entry(child).or_default().push((index, parent, true));
    }
    // The joints that lead upwards to a link not seen yet, from one link on.
    let from = |root, goes_up: bool, seen: &mut HashSet<_>| {
        let (mut upwards, mut next) = (Vec::new(), vec![root]);
        while let Some(link) = next.pop() {
            seen.insert(link);
            for (index, other, is_up) in &ends[link] {
                if (goes_up || !is_up) && !seen.contains(other) {
                    upwards.extend(is_up.then_some(*index));
                    next.push(*other);
                }
            }
        }
        upwards
    };
    let mut roots: Vec<&str> = hinges.iter().map(|hinge| hinge.parent.as_str()).collect();
    roots.retain(|link| !hung.contains(link));
    roots.sort_by_cached_key(|link| {
        let mut seen = HashSet::new();
        from(*link, false, &mut seen);
        std::cmp::Reverse(seen.len())
    });
    let mut seen = HashSet::new();
    roots
        .into_iter()
        .flat_map(|root| from(root, true, &mut seen))
        .collect()
}

/// A URDF, with where its elements came from.
type Written = (String, Vec<(usize, crate::urdf::Origin)>);

impl<'a, 'i> Model<'a, 'i, '_> {
    fn write(
        &self,
        whole: &Rc<Assembled>,
        remarks: &mut Vec<Remark>,
    ) -> Result<Written, RobotError> {
        let name = self.model.attribute("name").unwrap_or("model");
        let mut writer = Writer::new(whole, name, self.model);
        let links: Vec<Node> = self.all("link").collect();
        let hinges = self.hinges(remarks)?;
        let above: HashMap<&str, &Hinge> = hinges.iter().map(|h| (h.child.as_str(), h)).collect();
        // The frame of each link in the model: that of the joint above it; of the only root that
        // holds others, or of the only link, the model's, and of one of several its own.
        let is_root = |name: &&str| !above.contains_key(name);
        let holds: HashSet<&str> = hinges
            .iter()
            .map(|h| h.parent.as_str())
            .filter(is_root)
            .collect();
        let is_model = |name: &str| match holds.len() {
            0 => links.len() == 1,
            roots => roots == 1 && holds.contains(name),
        };
        let mut frames: HashMap<&str, Isometry3<f64>> = HashMap::new();
        for link in &links {
            let name = link.attribute("name").unwrap_or_default();
            let frame = match above.get(name) {
                Some(hinge) => self.pose_of(hinge.node, hinge.said_child(), 0)?,
                None if is_model(name) => Isometry3::identity(),
                None => self.pose_of(*link, "__model__", 0)?,
            };
            frames.insert(name, frame);
        }
        for link in &links {
            let name = link.attribute("name").unwrap_or_default();
            let double = above.get(name).filter(|hinge| hinge.is_double());
            self.write_link(&mut writer, *link, (&frames[name], double), remarks)?;
        }
        for hinge in &hinges {
            self.write_joint(&mut writer, hinge, &frames, remarks)?;
        }
        self.write_settings(&mut writer, &links, &frames, remarks)?;
        Ok(writer.finish())
    }

    fn all(&self, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
        self.model.children().filter(move |n| n.has_tag_name(tag))
    }

    /// The joints between links; what hangs by the world is a root.
    fn hinges(&self, remarks: &mut Vec<Remark>) -> Result<Vec<Hinge<'a, 'i>>, RobotError> {
        let links: HashSet<&str> = self
            .all("link")
            .filter_map(|n| n.attribute("name"))
            .collect();
        let mut hinges = Vec::new();
        for node in self.all("joint") {
            let end = |tag: &str| text_of(node, tag).unwrap_or_default().to_owned();
            let (parent, child) = (end("parent"), end("child"));
            if parent == "world" || child == "world" {
                let name = node.attribute("name").unwrap_or_default();
                remarks.push(Remark::new(
                    format!("joint `{name}`"),
                    "it ties the robot to the world, and is not read",
                ));
                continue;
            }
            let is_missing = |link: &&String| !links.contains(link.as_str());
            if let Some(link) = [&parent, &child].into_iter().find(is_missing) {
                let names = format!("names `{link}`, which is no link");
                if !self.leaves_out {
                    return Err((self.fault)(node, format!("the joint {names}")));
                }
                let subject = format!("joint `{}`", node.attribute("name").unwrap_or_default());
                remarks.push(Remark::new(subject, format!("left out, for it {names}")));
                continue;
            }
            hinges.push(Hinge {
                node,
                parent,
                child,
                is_reversed: false,
            });
        }
        Ok(self.as_tree(hinges, remarks))
    }

    /// The joints without those that a repair leaves out, each away from the link that holds most.
    fn as_tree(&self, hinges: Vec<Hinge<'a, 'i>>, remarks: &mut Vec<Remark>) -> Vec<Hinge<'a, 'i>> {
        let (mut tree, mut groups, mut has_loop) = (Vec::new(), HashMap::new(), false);
        for hinge in hinges {
            let [parent, child] = [&hinge.parent, &hinge.child].map(|link| group(&groups, link));
            let closes = parent == child;
            if closes && self.repairs {
                let words = "left out: it closes a loop of joints, which a robot here cannot have; without it what it holds moves freely";
                remarks.push(Remark::new(format!("joint `{}`", hinge.name()), words));
                continue;
            }
            has_loop |= closes;
            if !closes {
                groups.insert(child, parent);
            }
            tree.push(hinge);
        }
        let reversed = if has_loop {
            Vec::new()
        } else {
            reversed(&tree)
        };
        for index in reversed {
            let hinge = &mut tree[index];
            std::mem::swap(&mut hinge.parent, &mut hinge.child);
            hinge.is_reversed = true;
        }
        tree
    }

    /// The pose of an element in the model's frame; `default` is the frame that it is in where it
    /// names none.
    fn pose_of(
        &self,
        node: Node,
        default: &str,
        depth: usize,
    ) -> Result<Isometry3<f64>, RobotError> {
        let (own, named) = self.own_pose(node)?;
        let frame = named.unwrap_or_else(|| default.to_owned());
        if frame.is_empty() || frame == "__model__" || node == self.model {
            return Ok(own);
        }
        if depth > MOST_FRAMES {
            return Err((self.fault)(
                node,
                format!(
                    "its pose follows more than {MOST_FRAMES} frames, each relative to the next, \
                     or a circle of them"
                ),
            ));
        }
        let of = self.frame_named(&frame, node)?;
        let default = match of.tag_name().name() {
            "joint" => text_of(of, "child").unwrap_or_default().to_owned(),
            "frame" => of
                .attribute("attached_to")
                .unwrap_or("__model__")
                .to_owned(),
            _ => "__model__".to_owned(),
        };
        Ok(self.pose_of(of, &default, depth + 1)? * own)
    }

    /// The link, joint or frame of a name, which stands at a place.
    fn frame_named(&self, name: &str, at: Node) -> Result<Node<'a, 'i>, RobotError> {
        let found = self.frames.get(name).copied();
        found.ok_or_else(|| (self.fault)(at, format!("there is no frame `{name}`")))
    }

    /// The pose that an element says, and the frame that it names.
    fn own_pose(&self, node: Node) -> Result<(Isometry3<f64>, Option<String>), RobotError> {
        let Some(pose) = child(node, "pose") else {
            return Ok((Isometry3::identity(), None));
        };
        let wrong = || {
            (self.fault)(
                pose,
                "a pose is a place, followed by three angles or a quaternion: six or seven numbers"
                    .to_owned(),
            )
        };
        let text = pose.text().unwrap_or_default();
        let values = if text.trim().is_empty() {
            vec![0.0; 6]
        } else {
            numbers(text).ok_or_else(wrong)?
        };
        let degrees = pose.attribute("degrees") == Some("true");
        let angle = |x: f64| if degrees { x.to_radians() } else { x };
        let (p, rotation) = match values[..] {
            [x, y, z, roll, pitch, yaw] => (
                [x, y, z],
                UnitQuaternion::from_euler_angles(angle(roll), angle(pitch), angle(yaw)),
            ),
            [x, y, z, qx, qy, qz, qw] => (
                [x, y, z],
                UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(qw, qx, qy, qz)),
            ),
            // What is not said of a pose is zero in SDF.
            [x, y, z] => ([x, y, z], UnitQuaternion::identity()),
            _ => return Err(wrong()),
        };
        let named = pose
            .attribute("relative_to")
            .or_else(|| pose.attribute("frame"));
        let named = named.filter(|frame| !frame.is_empty()).map(str::to_owned);
        Ok((
            Isometry3::from_parts(Translation3::from(p), rotation),
            named,
        ))
    }

    fn write_link(
        &self,
        writer: &mut Writer,
        link: Node,
        (model_from_frame, double): (&Isometry3<f64>, Option<&&Hinge>),
        remarks: &mut Vec<Remark>,
    ) -> Result<(), RobotError> {
        /// The share of a link that moves by the first axis of its joint alone: nothing does, but a
        /// body needs mass. Chosen.
        const BETWEEN: f64 = 0.01;
        let name = link.attribute("name").unwrap_or_default();
        type Weight<'a, 'i> = (Node<'a, 'i>, Isometry3<f64>, f64, Option<Matrix3<f64>>);
        let weigh = |writer: &mut Writer, share: f64, whole: &Option<Weight>| {
            if let Some((node, place, mass_kg, inertia)) = whole {
                let inertia = inertia.map(|inertia| share * inertia);
                writer.inertial(*node, place, share * mass_kg, inertia.as_ref());
            }
        };
        let mut whole = None;
        let frame_from_link = model_from_frame.inverse() * self.pose_of(link, "__model__", 0)?;
        writer.begin_link(name, link);
        if let Some(inertial) = child(link, "inertial") {
            let place = frame_from_link * self.own_pose(inertial)?.0;
            let mass_kg = number_of(inertial, "mass").unwrap_or(1.0);
            let inertia = child(inertial, "inertia").map(|node| {
                let i = |tag: &str, default: f64| number_of(node, tag).unwrap_or(default);
                let (ixy, ixz, iyz) = (i("ixy", 0.0), i("ixz", 0.0), i("iyz", 0.0));
                Matrix3::new(
                    i("ixx", 1.0),
                    ixy,
                    ixz,
                    ixy,
                    i("iyy", 1.0),
                    iyz,
                    ixz,
                    iyz,
                    i("izz", 1.0),
                )
            });
            whole = Some((inertial, place, mass_kg, inertia));
        } else if child(link, "collision").is_some() {
            // SDF's default; its inertia of 1 kg m^2 suits no shape.
            whole = Some((link, frame_from_link, 1.0, None));
            let text = "it has no `<inertial>`: it weighs 1 kg, as SDF says";
            remarks.push(Remark::new(format!("link `{name}`"), text));
        }
        weigh(
            writer,
            if double.is_some() { 1.0 - BETWEEN } else { 1.0 },
            &whole,
        );
        for tag in ["collision", "visual"] {
            for node in link.children().filter(|n| n.has_tag_name(tag)) {
                let Some(geometry) = child(node, "geometry") else {
                    continue;
                };
                let place = frame_from_link * self.own_pose(node)?.0;
                match shapes(geometry) {
                    Ok(shapes) => {
                        for (offset, shape) in shapes {
                            writer.shape(tag, node, &(place * offset), &shape);
                        }
                    }
                    Err(kind) if tag == "collision" => {
                        let words = format!("a collision is not read: `<{kind}>`");
                        remarks.push(Remark::new(format!("link `{name}`"), words));
                    }
                    Err(_) => {}
                }
            }
        }
        writer.end_link();
        if let Some(hinge) = double {
            writer.begin_link(&hinge.between(), hinge.node);
            weigh(writer, BETWEEN, &whole);
            writer.end_link();
            if whole.is_some() {
                let words = format!(
                    "of its two axes the first moves a hundredth of link `{name}` alone: a body without mass is not simulated"
                );
                remarks.push(Remark::new(format!("joint `{}`", hinge.name()), words));
            }
        }
        Ok(())
    }

    fn write_joint(
        &self,
        writer: &mut Writer,
        hinge: &Hinge,
        frames: &HashMap<&str, Isometry3<f64>>,
        remarks: &mut Vec<Remark>,
    ) -> Result<(), RobotError> {
        let (node, name) = (hinge.node, hinge.name());
        let model_from_joint = frames[hinge.child.as_str()];
        let is_double = hinge.is_double();
        let sdf_type = match is_double {
            true => "revolute",
            false => node.attribute("type").unwrap_or_default(),
        };
        let mut parent_from_joint = frames[hinge.parent.as_str()].inverse() * model_from_joint;
        let mut parent = hinge.parent.as_str();
        // Of a joint of two axes the first is the parent's: a link between has both.
        let (upper, between) = (format!("{name}::axis"), hinge.between());
        let axes: &[(&str, &'static str)] = match (is_double, hinge.is_reversed) {
            (true, false) => &[(&upper, "axis"), (name, "axis2")],
            (true, true) => &[(name, "axis2"), (&upper, "axis")],
            (false, _) => &[(name, "axis")],
        };
        for (place, (name, tag)) in axes.iter().enumerate() {
            let axis = child(node, tag);
            let limit = axis.and_then(|axis| child(axis, "limit"));
            let within = |tag: &str| {
                let value = limit.and_then(|limit| number_of(limit, tag));
                value.filter(|x| x.abs() < NO_LIMIT)
            };
            let range = match [within("lower"), within("upper")] {
                [Some(lower), Some(upper)] => Some([lower, upper]),
                // A slide with one stop moves freely on the other side.
                [Some(lower), None] if sdf_type == "prismatic" => Some([lower, lower.max(FAR_M)]),
                [None, Some(upper)] if sdf_type == "prismatic" => Some([upper.min(-FAR_M), upper]),
                _ => None,
            };
            let turns = range.is_none_or(|[lower, upper]| upper - lower >= TAU);
            let kind = match sdf_type {
                "revolute" if turns => "continuous",
                "revolute" => "revolute",
                "continuous" => "continuous",
                "fixed" => "fixed",
                "prismatic" => "prismatic",
                "ball" => "spherical",
                "screw" => {
                    let words = "a screw is not simulated: it is held at zero";
                    remarks.push(Remark::new(format!("joint `{name}`"), words));
                    "fixed"
                }
                other => {
                    return Err((self.fault)(
                        node,
                        format!("a joint of the type `{other}` has no counterpart in URDF"),
                    ));
                }
            };
            let dynamics = axis.and_then(|axis| child(axis, "dynamics"));
            let loss = |tag: &str| {
                let value = dynamics.and_then(|dynamics| number_of(dynamics, tag));
                value.filter(|x| *x >= 0.0).unwrap_or(0.0)
            };
            let positive = |tag: &str| within(tag).filter(|x| *x > 0.0);
            let is_last = place + 1 == axes.len();
            let direction = self.axis(axis, &model_from_joint)?;
            writer.joint(
                node,
                &JointOf {
                    name,
                    kind,
                    parent,
                    child: if is_last { &hinge.child } else { &between },
                    parent_from_joint,
                    axis: if hinge.is_reversed {
                        -direction
                    } else {
                        direction
                    },
                    range: range.filter(|_| kind != "continuous"),
                    effort: positive("effort"),
                    velocity: positive("velocity"),
                    damping: loss("damping"),
                    friction: loss("friction"),
                    mimic: None,
                },
            );
            parent = &between;
            parent_from_joint = Isometry3::identity();
        }
        Ok(())
    }

    /// The springs in its joints: on the body they act with -stiffness (q - reference).
    fn springs(&self) -> Result<BTreeMap<String, JointSpring>, RobotError> {
        let mut springs = BTreeMap::new();
        let joints = self.all("joint");
        let moving = joints.filter(|node| node.attribute("type") != Some("ball"));
        let axes = moving.flat_map(|node| {
            let name = node.attribute("name").unwrap_or_default();
            // Of two axes, the first is a joint of its own above the other's.
            match node.attribute("type") {
                Some("universal" | "revolute2") => vec![
                    (child(node, "axis"), format!("{name}::axis")),
                    (child(node, "axis2"), name.to_owned()),
                ],
                _ => vec![(child(node, "axis"), name.to_owned())],
            }
        });
        for (axis, name) in axes {
            let Some(dynamics) = axis.and_then(|axis| child(axis, "dynamics")) else {
                continue;
            };
            let stiffness = self.of_spring(dynamics, "spring_stiffness", &name)?;
            let rest = self.of_spring(dynamics, "spring_reference", &name)?;
            if stiffness < 0.0 {
                let said = child(dynamics, "spring_stiffness").unwrap_or(dynamics);
                let words = format!(
                    "`spring_stiffness` of joint `{name}` is {stiffness}, but must be 0 or above: the spring would push away from its reference"
                );
                return Err((self.fault)(said, words));
            }
            if stiffness > 0.0 {
                let spring = JointSpring {
                    stiffness,
                    rest,
                    preload: 0.0,
                };
                springs.insert(name, spring);
            }
        }
        Ok(springs)
    }

    /// A number of a joint's spring; 0 where none is said.
    fn of_spring(&self, dynamics: Node, tag: &str, joint: &str) -> Result<f64, RobotError> {
        let Some(said) = child(dynamics, tag) else {
            return Ok(0.0);
        };
        number_of(dynamics, tag).ok_or_else(|| {
            let words = format!(
                "`{tag}` of joint `{joint}` is no finite number: write one, or leave it out"
            );
            (self.fault)(said, words)
        })
    }

    /// The axis in the joint's frame.
    fn axis(
        &self,
        axis: Option<Node>,
        model_from_joint: &Isometry3<f64>,
    ) -> Result<Vector3<f64>, RobotError> {
        let Some(axis) = axis else {
            return Ok(Vector3::z());
        };
        let Some(xyz) = child(axis, "xyz") else {
            return Ok(Vector3::z());
        };
        let values = numbers(xyz.text().unwrap_or_default());
        let Some([x, y, z]) = values.and_then(|v| <[f64; 3]>::try_from(v).ok()) else {
            return Err((self.fault)(xyz, "an axis is three numbers".to_owned()));
        };
        let given = Vector3::new(x, y, z);
        let in_model = text_of(axis, "use_parent_model_frame")
            .map_or(self.old_axes, |value| value == "1" || value == "true");
        let rotation = match xyz.attribute("expressed_in").filter(|f| !f.is_empty()) {
            Some("__model__") => UnitQuaternion::identity(),
            Some(frame) => {
                let of = self.frame_named(frame, xyz)?;
                self.pose_of(of, "__model__", 0)?.rotation
            }
            None if in_model => UnitQuaternion::identity(),
            None => return Ok(given),
        };
        Ok(model_from_joint.rotation.inverse() * (rotation * given))
    }

    /// What speaks of the wheels' rollers: directions of friction, and the plug-ins' names.
    fn write_settings(
        &self,
        writer: &mut Writer,
        links: &[Node],
        frames: &HashMap<&str, Isometry3<f64>>,
        remarks: &mut Vec<Remark>,
    ) -> Result<(), RobotError> {
        for link in links {
            let called = link.attribute("name").unwrap_or_default();
            let found = link.descendants().find_map(|n| {
                let names = match n.tag_name().name() {
                    "ode" => ["mu", "mu2"],
                    "bullet" => ["friction", "friction2"],
                    _ => return None,
                };
                Some((n, child(n, "fdir1")?, names))
            });
            let Some((engine, fdir1, names)) = found else {
                continue;
            };
            let frame = fdir1.attributes().find(|a| a.name() == "expressed_in");
            let mut frame = frame.map_or("", |frame| frame.value());
            let mut direction = fdir1.text().unwrap_or_default().to_owned();
            // A frame that stands is said by the root's, which is the model's here.
            let root = links.iter().find_map(|n| {
                let name = n.attribute("name")?;
                (frames[name] == Isometry3::identity()).then_some(name)
            });
            let turn = match frame {
                "" => None,
                "__model__" => Some(UnitQuaternion::identity()),
                _ if frame == called => None,
                _ => {
                    let of = self.frames.get(frame).copied();
                    let pose = of.map(|of| self.pose_of(of, "__model__", 0)).transpose()?;
                    pose.map(|pose| pose.rotation)
                }
            };
            let xyz = numbers(&direction).and_then(|v| <[f64; 3]>::try_from(v).ok());
            if let (Some(turn), Some(xyz), Some(root)) = (turn, xyz, root) {
                let turned = turn * Vector3::from(xyz);
                direction = format!("{} {} {}", turned.x, turned.y, turned.z);
                frame = root;
            }
            writer.raw(
                fdir1,
                "gazebo",
                &format!(" reference=\"{}\">", escaped(called)),
            );
            for (tag, node) in names.map(|tag| (tag, child(engine, tag))) {
                let text = |node: Node| escaped(node.text().unwrap_or_default());
                if let Some(node) = node {
                    writer.raw(node, tag, &format!(">{}</{tag}>", text(node)));
                }
            }
            let [frame, direction] = [frame, &direction].map(escaped);
            let rest = format!(" expressed_in=\"{frame}\">{direction}</fdir1></gazebo>");
            writer.raw(fdir1, "fdir1", &rest);
        }
        let friction = self
            .model
            .descendants()
            .filter(|n| n.has_tag_name("friction"));
        if friction
            .flat_map(|n| n.descendants())
            .any(|n| n.has_tag_name("mu"))
        {
            let words = "that of the file's surfaces is not read, but for its directions: what counts is the floor's, `world.floor.friction`";
            remarks.push(Remark::new("friction", words));
        }
        for plugin in self.all("plugin") {
            let attribute = |name| escaped(plugin.attribute(name).unwrap_or_default());
            let (file, name) = (attribute("filename"), attribute("name"));
            writer.raw(
                plugin,
                "gazebo",
                &format!("><plugin filename=\"{file}\" name=\"{name}\"/></gazebo>"),
            );
        }
        Ok(())
    }
}

/// The shapes that stand for a geometry, placed in its frame; the name of one that is not read.
fn shapes(geometry: Node) -> Result<Placed, String> {
    let Some(kind) = geometry.children().find(Node::is_element) else {
        return Err("geometry".to_owned());
    };
    let found = match kind.tag_name().name() {
        "ellipsoid" => vector_of(kind, "radii")
            .filter(|radii| radii.min() > 0.0)
            .and_then(|radii| ellipsoid(radii.into())),
        _ => shape(kind).map(|shape| vec![(Isometry3::identity(), shape)]),
    };
    found.ok_or_else(|| kind.tag_name().name().to_owned())
}

fn shape(kind: Node) -> Option<ShapeOf> {
    let number = |tag: &str| number_of(kind, tag).filter(|x| *x > 0.0);
    Some(match kind.tag_name().name() {
        "box" => ShapeOf::Box(vector_of(kind, "size")?),
        "cylinder" => ShapeOf::Cylinder {
            radius: number("radius")?,
            length: number("length")?,
        },
        "capsule" => ShapeOf::Capsule {
            radius: number("radius")?,
            length: number("length")?,
        },
        "sphere" => ShapeOf::Sphere(number("radius")?),
        "mesh" => ShapeOf::Mesh {
            file: text_of(kind, "uri")?.to_owned(),
            scale: vector_of(kind, "scale").unwrap_or(Vector3::repeat(1.0)),
        },
        _ => return None,
    })
}
