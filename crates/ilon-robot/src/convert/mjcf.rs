//! MJCF, the format of MuJoCo: the body of a file with the most hinges below it.
//!
//! mjcf-rs reads it, with its defaults, classes and angles; what it includes is put in first, through the door through which all
//! files are read. A body's frame becomes that of its joint; a body of several joints becomes a chain of links.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::path::Path;

use mjcf_rs::compiler::InertiaFromGeom;
use mjcf_rs::{body as mj, extras};
use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use super::writer::{JointOf, ShapeOf, Writer};
use crate::error::{Fault, RobotError};
use crate::model::{DriveTrain, MassProperties, Remark};
use crate::options::LoadOptions;
use crate::urdf::Prepared;
use crate::xml;

/// Most files that one may include, and those include.
const MOST_INCLUDES: usize = 50;
/// Longest file that is included, in bytes.
const MAX_BYTES: u64 = 16 << 20;
/// Balls that stand for an ellipsoid, of which they are the envelope.
const BALLS: usize = 15;
/// Density of a geom that says none, in kg/m^3: MuJoCo's own.
const DENSITY_KG_M3: f64 = 1000.0;

/// The URDF of the robot in an MJCF text.
pub(super) fn converted(
    file: &str,
    text: &str,
    options: &LoadOptions,
) -> Result<Prepared, RobotError> {
    let mut left = MOST_INCLUDES;
    let folder = Path::new(file).parent().unwrap_or(Path::new(""));
    let whole = with_includes(file, text, folder, options, &mut left)?;
    let document = xml::parse(&whole).map_err(|fault| of_xml(file, &whole, fault))?;
    refuse_what_is_not_read(file, &whole, &document)?;
    let model = mjcf_rs::Model::from_str(&whole, folder).map_err(|e| {
        let reason = e.to_string();
        RobotError::new(file, Fault::Format { reason })
    })?;
    Robot::find(&model, &document, file)?.write(&whole)
}

fn of_xml(file: &str, text: &str, fault: xml::Fault) -> RobotError {
    match fault {
        xml::Fault::Malformed(reason, bytes) => {
            RobotError::new(file, Fault::Xml { reason }).at(&text.into(), bytes)
        }
        xml::Fault::TooMuch(what, most, _) => RobotError::new(file, Fault::TooLarge { what, most }),
    }
}

/// The text with what it includes in the place of each include.
fn with_includes(
    file: &str,
    text: &str,
    folder: &Path,
    options: &LoadOptions,
    left: &mut usize,
) -> Result<String, RobotError> {
    let document = xml::parse(text).map_err(|fault| of_xml(file, text, fault))?;
    let mut whole = String::new();
    let mut done = 0;
    for node in document.descendants().filter(|n| n.has_tag_name("include")) {
        let fault = |reason: String| {
            let bytes = xml::opening_tag(text, node);
            Err(RobotError::new(file, Fault::Format { reason }).at(&text.into(), bytes))
        };
        let Some(name) = node.attribute("file") else {
            return fault("an `<include>` names no file".to_owned());
        };
        if *left == 0 {
            return fault(format!("more than {MOST_INCLUDES} files are included"));
        }
        *left -= 1;
        let path = folder.join(name);
        let included = match options.files.read_text(&path, MAX_BYTES) {
            Ok(included) => included,
            Err(reason) => return fault(format!("`{name}` cannot be included: {reason}")),
        };
        // Files that are included start from the folder of the first, as in MuJoCo.
        let name = path.display().to_string();
        let included = with_includes(&name, &included, folder, options, left)?;
        let inner = xml::parse(&included).map_err(|fault| of_xml(&name, &included, fault))?;
        whole.push_str(&text[done..node.range().start]);
        whole.push_str(inside(&included, inner.root_element()));
        done = node.range().end;
    }
    whole.push_str(&text[done..]);
    Ok(whole)
}

/// What stands between an element's tags.
fn inside<'t>(text: &'t str, node: Node) -> &'t str {
    let children = || node.children();
    match (children().next(), children().next_back()) {
        (Some(first), Some(last)) => &text[first.range().start..last.range().end],
        _ => "",
    }
}

/// Refuses elements that would make bodies which nothing here knows of.
fn refuse_what_is_not_read(file: &str, text: &str, document: &Document) -> Result<(), RobotError> {
    let tags = ["replicate", "composite", "flexcomp", "attach", "model"];
    let unread = document
        .descendants()
        .find(|n| tags.contains(&n.tag_name().name()) && n.is_element());
    match unread {
        None => Ok(()),
        Some(node) => {
            let reason = format!(
                "`<{}>` is not read: save the model from MuJoCo (`mj_saveLastXML`), which writes it out",
                node.tag_name().name()
            );
            let bytes = xml::opening_tag(text, node);
            Err(RobotError::new(file, Fault::Format { reason }).at(&text.into(), bytes))
        }
    }
}

/// The robot of a model: a body below the world.
struct Robot<'a, 'i> {
    model: &'a mjcf_rs::Model,
    file: &'a str,
    /// Where the bodies stand in the text, by their names.
    nodes: HashMap<&'a str, Node<'a, 'i>>,
    root_node: Node<'a, 'i>,
    root: usize,
    below: Vec<Vec<usize>>,
}

impl<'a, 'i> Robot<'a, 'i> {
    fn find(
        model: &'a mjcf_rs::Model,
        document: &'a Document<'i>,
        file: &'a str,
    ) -> Result<Self, RobotError> {
        let root_node = document.root_element();
        let nodes = root_node
            .descendants()
            .filter(|n| n.has_tag_name("body"))
            .filter_map(|n| Some((n.attribute("name")?, n)))
            .collect();
        let mut below = vec![Vec::new(); model.bodies.len()];
        for (id, entry) in model.bodies.iter().enumerate().skip(1) {
            if let Some(parent) = entry.parent.filter(|parent| *parent < id) {
                below[parent].push(id);
            }
        }
        // Parents stand before their children.
        let hinge = |joint: &&mj::Joint| joint.type_ == mj::JointType::Hinge;
        let mut hinges: Vec<usize> = model
            .bodies
            .iter()
            .map(|entry| entry.body.joints.iter().filter(hinge).count())
            .collect();
        for id in (1..model.bodies.len()).rev() {
            if let Some(parent) = model.bodies[id].parent.filter(|parent| *parent < id) {
                hinges[parent] += hinges[id];
            }
        }
        let candidates = below.first().cloned().unwrap_or_default();
        let Some(root) = candidates.into_iter().rev().max_by_key(|id| hinges[*id]) else {
            let reason = "it holds no body".to_owned();
            return Err(RobotError::new(file, Fault::Format { reason }));
        };
        Ok(Self {
            model,
            file,
            nodes,
            root_node,
            root,
            below,
        })
    }

    fn name(&self, id: usize) -> String {
        let name = self.model.bodies[id].body.name.clone();
        name.unwrap_or_else(|| format!("body_{id}"))
    }

    fn node(&self, id: usize) -> Node<'a, 'i> {
        let name = self.model.bodies[id].body.name.as_deref();
        let node = name.and_then(|name| self.nodes.get(name));
        node.copied().unwrap_or(self.root_node)
    }

    fn write(&self, text: &str) -> Result<Prepared, RobotError> {
        let name = self.model.name.as_deref().unwrap_or("mujoco");
        let mut writer = Writer::new(self.file, text, name, self.root_node);
        let mut prepared = Prepared::as_it_is(self.file, "");
        let mut waiting = vec![(self.root, None)];
        while let Some((id, above)) = waiting.pop() {
            let frame = self.write_body(&mut writer, id, above, &mut prepared)?;
            waiting.extend(
                self.below[id]
                    .iter()
                    .rev()
                    .map(|child| (*child, Some((id, frame)))),
            );
        }
        let (urdf, origins) = writer.finish();
        prepared.text = urdf.into();
        prepared.origins = origins;
        Ok(prepared)
    }

    /// Writes a body with its joints; returns the body's frame in that of its link.
    fn write_body(
        &self,
        writer: &mut Writer,
        id: usize,
        above: Option<(usize, Isometry3<f64>)>,
        prepared: &mut Prepared,
    ) -> Result<Isometry3<f64>, RobotError> {
        let body = &self.model.bodies[id].body;
        let (name, node) = (self.name(id), self.node(id));
        // The link's frame is that of the body's last joint.
        let mut body_from_link = Isometry3::identity();
        match above {
            // How the robot hangs in the world is not its own.
            None if !body.joints.is_empty() => prepared.remarks.push(Remark::new(
                format!("link `{name}`"),
                "its joints to the world are not read: it stands on its wheels",
            )),
            None => {}
            Some((parent, link_from_parent)) => {
                let mut parent_name = self.name(parent);
                let mut parent_from_body = link_from_parent * pose(&body.pose);
                let count = body.joints.len();
                for (i, joint) in body.joints.iter().enumerate() {
                    let place = Isometry3::from(Translation3::from(joint.pos));
                    let link = if i + 1 == count {
                        name.clone()
                    } else {
                        // Between two joints of one body there is nothing.
                        let between = format!("{name}_{}", i + 1);
                        writer.begin_link(&between, node);
                        writer.end_link();
                        between
                    };
                    let here = parent_from_body * place;
                    self.write_joint(
                        writer,
                        node,
                        joint,
                        (&parent_name, &link),
                        here,
                        (id, i),
                        prepared,
                    )?;
                    body_from_link = place;
                    parent_from_body = place.inverse();
                    parent_name = link;
                }
                if count == 0 {
                    writer.joint(node, &fixed(&name, &parent_name, parent_from_body));
                }
            }
        }
        writer.begin_link(&name, node);
        self.write_inside(writer, id, &body_from_link.inverse(), prepared);
        writer.end_link();
        Ok(body_from_link.inverse())
    }

    #[allow(clippy::too_many_arguments)] // One joint, and everything between its two links.
    fn write_joint(
        &self,
        writer: &mut Writer,
        node: Node,
        joint: &mj::Joint,
        (parent, child): (&str, &str),
        parent_from_joint: Isometry3<f64>,
        (body, index): (usize, usize),
        prepared: &mut Prepared,
    ) -> Result<(), RobotError> {
        let name = joint.name.clone().unwrap_or_else(|| match index {
            0 => format!("{}_joint", self.name(body)),
            _ => format!("{}_joint_{}", self.name(body), index + 1),
        });
        let limited = joint
            .limited
            .resolve(self.model.compiler.autolimits, joint.range.is_some());
        let range = joint.range.filter(|_| limited);
        let turns = range.is_none_or(|[lower, upper]| upper - lower >= TAU);
        let kind = match joint.type_ {
            mj::JointType::Hinge if turns => "continuous",
            mj::JointType::Hinge => "revolute",
            mj::JointType::Slide => "prismatic",
            mj::JointType::Ball => "spherical",
            mj::JointType::Free => {
                let reason = format!("the body `{}` is free within the robot", self.name(body));
                return Err(RobotError::new(self.file, Fault::Format { reason }));
            }
        };
        if joint.armature > 0.0 {
            // MuJoCo adds the armature at the joint: a rotor without a gear.
            let drive = DriveTrain {
                rotor_inertia_kg_m2: joint.armature,
                ..DriveTrain::default()
            };
            prepared.drives.insert(name.clone(), drive);
        }
        let (effort, velocity) = self.limits(joint.name.as_deref());
        writer.joint(
            node,
            &JointOf {
                name: &name,
                kind,
                parent,
                child,
                parent_from_joint,
                axis: Vector3::from(joint.axis),
                range: range.filter(|_| kind != "continuous"),
                effort,
                velocity,
                damping: joint.damping.max(0.0),
                friction: joint.frictionloss.max(0.0),
            },
        );
        Ok(())
    }

    /// The largest torque and rate that the actuators of a joint give it.
    fn limits(&self, joint: Option<&str>) -> (Option<f64>, Option<f64>) {
        let of_joint =
            |actuator: &&extras::Actuator| joint.is_some() && actuator.joint.as_deref() == joint;
        let Some(actuator) = self.model.actuators.iter().find(of_joint) else {
            return (None, None);
        };
        let gear = actuator.gear[0].abs();
        let largest = |range: Option<[f64; 2]>| {
            let [lower, upper] = range?;
            Some(lower.abs().max(upper.abs())).filter(|x| x.is_finite() && *x > 0.0)
        };
        let force = largest(actuator.force_range).map(|force| force * gear);
        let control = largest(actuator.ctrl_range);
        let positive = |x: Option<f64>| x.filter(|x| x.is_finite() && *x > 0.0);
        match actuator.kind {
            extras::ActuatorKind::Motor => (positive(force.or(control.map(|c| c * gear))), None),
            extras::ActuatorKind::Velocity => {
                (positive(force), positive(control.map(|c| c / gear)))
            }
            _ => (positive(force), None),
        }
    }

    /// Mass and shapes of a body.
    fn write_inside(
        &self,
        writer: &mut Writer,
        id: usize,
        link_from_body: &Isometry3<f64>,
        prepared: &mut Prepared,
    ) {
        let (body, node) = (&self.model.bodies[id].body, self.node(id));
        let of_geoms = self.model.compiler.inertia_from_geom;
        let said = body
            .inertial
            .as_ref()
            .filter(|_| of_geoms != InertiaFromGeom::True);
        if let Some(inertial) = said {
            let place = link_from_body * pose(&inertial.pose);
            writer.inertial(
                node,
                &place,
                inertial.mass,
                Some(&tensor(&inertial.inertia)),
            );
        } else if of_geoms != InertiaFromGeom::False
            && let Some(mass) = mass_of(&body.geoms)
        {
            let center = Isometry3::from(Translation3::from(mass.center_of_mass_m));
            let inertia = mass.inertia_kg_m2;
            writer.inertial(
                node,
                &(link_from_body * center),
                mass.mass_kg,
                Some(&inertia),
            );
        }
        for geom in &body.geoms {
            let tag = if geom.contype == 0 && geom.conaffinity == 0 {
                "visual"
            } else {
                "collision"
            };
            let place = link_from_body * pose(&geom.pose);
            for (offset, shape) in self.shapes(geom, id, prepared) {
                writer.shape(tag, node, &(place * offset), &shape);
            }
        }
    }

    /// The shapes that stand for a geom, placed in its frame.
    fn shapes(
        &self,
        geom: &mj::Geom,
        id: usize,
        prepared: &mut Prepared,
    ) -> Vec<(Isometry3<f64>, ShapeOf)> {
        let [x, y, z] = geom.size;
        let here = |shape| vec![(Isometry3::identity(), shape)];
        let positive = |sizes: &[f64]| sizes.iter().all(|s| s.is_finite() && *s > 0.0);
        match geom.type_ {
            mj::GeomType::Sphere if positive(&[x]) => here(ShapeOf::Sphere(x)),
            mj::GeomType::Box if positive(&[x, y, z]) => {
                here(ShapeOf::Box(Vector3::new(x, y, z) * 2.0))
            }
            mj::GeomType::Cylinder if positive(&[x, y]) => here(ShapeOf::Cylinder {
                radius: x,
                length: 2.0 * y,
            }),
            mj::GeomType::Capsule if positive(&[x, y]) => here(ShapeOf::Capsule {
                radius: x,
                length: 2.0 * y,
            }),
            mj::GeomType::Ellipsoid if positive(&[x, y, z]) => ellipsoid(x, y, z),
            mj::GeomType::Mesh => match self.mesh(geom) {
                Some(shape) => here(shape),
                None => {
                    prepared.remarks.push(Remark::new(
                        format!("link `{}`", self.name(id)),
                        "a mesh without a file is not read",
                    ));
                    Vec::new()
                }
            },
            _ => Vec::new(),
        }
    }

    fn mesh(&self, geom: &mj::Geom) -> Option<ShapeOf> {
        let name = geom.mesh.as_deref()?;
        let called = |mesh: &&mjcf_rs::assets::Mesh| {
            let stem = mesh
                .file
                .as_deref()
                .and_then(|f| Path::new(f).file_stem()?.to_str());
            mesh.name.as_deref().or(stem) == Some(name)
        };
        let mesh = self.model.assets.meshes.iter().find(called)?;
        let compiler = &self.model.compiler;
        let folder = compiler.mesh_dir.as_ref().or(compiler.asset_dir.as_ref());
        let file = mesh.file.as_deref()?;
        let file = folder.map_or(file.into(), |folder| Path::new(folder).join(file));
        Some(ShapeOf::Mesh {
            file: file.display().to_string(),
            scale: Vector3::from(mesh.scale),
        })
    }
}

fn fixed<'n>(child: &'n str, parent: &'n str, parent_from_joint: Isometry3<f64>) -> JointOf<'n> {
    JointOf {
        // A joint may be called as its link is.
        name: child,
        kind: "fixed",
        parent,
        child,
        parent_from_joint,
        axis: Vector3::x(),
        range: None,
        effort: None,
        velocity: None,
        damping: 0.0,
        friction: 0.0,
    }
}

/// Balls whose envelope an ellipsoid of revolution is; one that is none is left out of what can be said with balls.
///
/// Of an ellipsoid with the half axes a across and c > a along, the ball at t along the axis that touches it from inside has the
/// radius a sqrt(1 - t^2 / (c^2 - a^2)), as long as it touches at all: |t| <= c - a^2 / c.
fn ellipsoid(x: f64, y: f64, z: f64) -> Vec<(Isometry3<f64>, ShapeOf)> {
    let halves = [x, y, z];
    let along = (0..3)
        .find(|&i| {
            let (p, q) = (halves[(i + 1) % 3], halves[(i + 2) % 3]);
            (p - q).abs() < 1e-6 * p.max(q) && halves[i] >= p
        })
        .unwrap_or(2);
    let (a, c) = (halves[(along + 1) % 3], halves[along]);
    if c <= a * (1.0 + 1e-9) {
        return vec![(Isometry3::identity(), ShapeOf::Sphere(a))];
    }
    let farthest = c - a * a / c;
    (0..BALLS)
        .map(|i| {
            let t = farthest * (2.0 * i as f64 / (BALLS - 1) as f64 - 1.0);
            let radius = a * (1.0 - t * t / (c * c - a * a)).sqrt();
            let place = Translation3::from(Vector3::ith(along, t));
            (Isometry3::from(place), ShapeOf::Sphere(radius))
        })
        .collect()
}

/// What a body's geoms weigh together, as MuJoCo has it: meshes, whose volume is not known here, left out.
fn mass_of(geoms: &[mj::Geom]) -> Option<MassProperties> {
    let parts: Vec<MassProperties> = geoms
        .iter()
        .filter_map(|geom| {
            let (volume_m3, unit) = solid(geom)?;
            let density = geom.density.unwrap_or(DENSITY_KG_M3);
            let mass_kg = geom.mass.unwrap_or(density * volume_m3);
            let own = MassProperties {
                mass_kg,
                center_of_mass_m: Vector3::zeros(),
                inertia_kg_m2: Matrix3::from_diagonal(&(unit * mass_kg)),
            };
            (mass_kg > 0.0).then(|| own.moved(&pose(&geom.pose)))
        })
        .collect();
    MassProperties::merged(&parts)
}

/// Volume of a geom, and its moments of inertia for a mass of 1 kg.
fn solid(geom: &mj::Geom) -> Option<(f64, Vector3<f64>)> {
    use std::f64::consts::PI;
    let [x, y, z] = geom.size;
    let ball = 4.0 / 3.0 * PI;
    Some(match geom.type_ {
        mj::GeomType::Sphere => (ball * x.powi(3), Vector3::repeat(0.4 * x * x)),
        mj::GeomType::Box => (
            8.0 * x * y * z,
            Vector3::new(y * y + z * z, x * x + z * z, x * x + y * y) / 3.0,
        ),
        mj::GeomType::Ellipsoid => (
            ball * x * y * z,
            Vector3::new(y * y + z * z, x * x + z * z, x * x + y * y) / 5.0,
        ),
        mj::GeomType::Cylinder => {
            let across = x * x / 4.0 + y * y / 3.0;
            (
                2.0 * PI * x * x * y,
                Vector3::new(across, across, x * x / 2.0),
            )
        }
        mj::GeomType::Capsule => {
            // A cylinder and the two halves of a ball, whose centres of mass are 3/8 of the radius beyond its ends.
            let (rod, caps) = (2.0 * PI * x * x * y, ball * x.powi(3));
            let whole = rod + caps;
            let across =
                rod * (x * x / 4.0 + y * y / 3.0) + caps * (0.4 * x * x + y * y + 0.75 * x * y);
            let axial = rod * x * x / 2.0 + caps * 0.4 * x * x;
            (whole, Vector3::new(across, across, axial) / whole)
        }
        _ => return None,
    })
}

fn tensor(inertia: &mj::InertiaSpec) -> Matrix3<f64> {
    match inertia {
        mj::InertiaSpec::Diagonal(moments) => Matrix3::from_diagonal(&Vector3::from(*moments)),
        mj::InertiaSpec::Full([xx, yy, zz, xy, xz, yz]) => {
            Matrix3::new(*xx, *xy, *xz, *xy, *yy, *yz, *xz, *yz, *zz)
        }
    }
}

fn pose(pose: &mjcf_rs::Pose) -> Isometry3<f64> {
    let (p, q) = (pose.translation, pose.rotation);
    Isometry3::from_parts(
        Translation3::from(Point3::new(p.x, p.y, p.z).coords),
        UnitQuaternion::from_quaternion(Quaternion::new(q.w, q.x, q.y, q.z)),
    )
}
