//! A robot as SDF and as URDF, which share most of their elements.

use std::fmt::Write as _;

use ilon_robot::roll_pitch_yaw;
use nalgebra::{Isometry3, Vector3};

use super::fit::FittedRobot;
use super::frame::{Ground, about_comment, filled};
use super::parts::{Part, PartJoint, Role, Shape};

use crate::generate::elements::{attribute, num, nums};
use crate::model::{Collision, CollisionShape, JointKind, JointRole, MassProperties};

/// Which of the two is written: SDF nests what URDF has as attributes.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Dialect {
    Sdf,
    Urdf,
}

/// Values of an element, by name.
type Values<'a> = Vec<(&'a str, String)>;

/// A robot with all that its file says.
pub(super) struct Tags<'a> {
    pub(super) dialect: Dialect,
    pub(super) fitted: &'a FittedRobot,
    pub(super) parts: &'a [Part<'a>],
    pub(super) ground: &'a Ground,
    pub(super) about: &'a str,
}

impl Tags<'_> {
    /// The model in URDF, or in SDF alone or on a level floor.
    pub(super) fn file(&self, is_world: bool) -> String {
        let head = format!("<?xml version=\"1.0\"?>\n{}", about_comment(self.about));
        let robot = &self.fitted.robot;
        let name = attribute(&robot.name);
        let links: String = self.parts.iter().map(|part| self.link(part)).collect();
        let joints = self.parts.iter().filter_map(|part| self.joint(part));
        let model = links + &joints.collect::<String>();
        if self.dialect == Dialect::Urdf {
            let tyres = super::tyres::element(robot);
            return format!("{head}<robot name=\"{name}\">\n{model}{tyres}</robot>\n");
        }
        let (plugins, height) = (self.plugins(), num(self.fitted.ride_height_m));
        let model = format!(
            "<model name=\"{name}\">\n<pose>0 0 {height} 0 0 0</pose>\n<self_collide>false</self_collide>\n{model}{plugins}</model>\n"
        );
        let content = match is_world {
            true => format!("{}{model}</world>\n", self.world()),
            false => model,
        };
        format!("{head}<sdf version=\"1.11\">\n{content}</sdf>\n")
    }

    fn world(&self) -> String {
        let gravity = num(self.ground.gravity_m_s2);
        let surface = surface(self.ground.friction);
        let values = [("gravity", &gravity[..]), ("surface", &surface)];
        filled(include_str!("world.sdf"), &values)
    }

    fn element(&self, tag: &str, values: &[(&str, String)]) -> String {
        let mut inner = String::new();
        for (name, value) in values {
            let _ = match self.dialect {
                Dialect::Sdf => write!(inner, "<{name}>{value}</{name}>"),
                Dialect::Urdf => write!(inner, " {name}=\"{value}\""),
            };
        }
        match self.dialect {
            Dialect::Sdf => format!("<{tag}>{inner}</{tag}>"),
            Dialect::Urdf => format!("<{tag}{inner}/>"),
        }
    }

    /// An element of one value, which has a name in URDF alone.
    fn value(&self, tag: &str, name: &str, value: &str) -> String {
        match self.dialect {
            Dialect::Sdf => format!("<{tag}>{value}</{tag}>"),
            Dialect::Urdf => format!("<{tag} {name}=\"{value}\"/>"),
        }
    }

    fn place(&self, pose: &Isometry3<f64>) -> String {
        let turned = nums(&roll_pitch_yaw(&pose.rotation.to_rotation_matrix()));
        let at = nums(pose.translation.vector.as_slice());
        match self.dialect {
            Dialect::Sdf => format!("<pose>{at} {turned}</pose>"),
            Dialect::Urdf => format!("<origin xyz=\"{at}\" rpy=\"{turned}\"/>"),
        }
    }

    fn link(&self, part: &Part) -> String {
        let (pose, least_kg) = match self.dialect {
            Dialect::Sdf => (self.place(&part.body_from_part), 1e-6),
            Dialect::Urdf => (String::new(), 0.0),
        };
        let mass = &part.mass;
        let [x, y, z] = mass.center_of_mass_m.into();
        let middle = self.place(&Isometry3::translation(x, y, z));
        let weight = self.value("mass", "value", &num(mass.mass_kg.max(least_kg)));
        let moments = self.element("inertia", &moments(mass));
        let mut out = format!(
            "<link name=\"{}\">{pose}\n<inertial>{middle}{weight}{moments}</inertial>\n",
            attribute(&part.name)
        );
        let mut number = 0;
        for (at, shape) in &part.shapes {
            let own = match shape {
                Shape::Solid(solid) => solid.friction,
                _ => None,
            };
            let friction = surface(own.unwrap_or(self.ground.friction));
            for (at, geometry) in self.geometries(at, shape) {
                let seen = format!("{}<geometry>{geometry}</geometry>", self.place(&at));
                let _ = match self.dialect {
                    Dialect::Sdf => writeln!(
                        out,
                        "<collision name=\"collision_{number}\">{seen}{friction}</collision><visual name=\"visual_{number}\">{seen}</visual>"
                    ),
                    Dialect::Urdf => writeln!(
                        out,
                        "<visual>{seen}</visual>\n<collision>{seen}</collision>"
                    ),
                };
                number += 1;
            }
        }
        out + "</link>\n"
    }

    /// The elements of a shape, with their places. URDF has no capsules.
    fn geometries(&self, at: &Isometry3<f64>, shape: &Shape) -> Vec<(Isometry3<f64>, String)> {
        let solid = match shape {
            Shape::Ellipsoid([a, c]) => {
                let radii = nums(&[*a, *a, *c]);
                return vec![(*at, self.element("ellipsoid", &[("radii", radii)]))];
            }
            Shape::Solid(solid) => &solid.shape,
        };
        let sphere = |radius_m: f64| self.element("sphere", &[("radius", num(radius_m))]);
        let long = |tag, radius_m: f64, length_m: f64| {
            let values = [("radius", num(radius_m)), ("length", num(length_m))];
            self.element(tag, &values)
        };
        match solid {
            CollisionShape::Cylinder { radius_m, length_m } => {
                vec![(*at, long("cylinder", *radius_m, *length_m))]
            }
            CollisionShape::Capsule { radius_m, length_m } if self.dialect == Dialect::Sdf => {
                vec![(*at, long("capsule", *radius_m, *length_m))]
            }
            CollisionShape::Capsule { radius_m, length_m } => {
                let end = |z| (at * Isometry3::translation(0.0, 0.0, z), sphere(*radius_m));
                let middle = (*at, long("cylinder", *radius_m, *length_m));
                vec![middle, end(0.5 * length_m), end(-0.5 * length_m)]
            }
            CollisionShape::Sphere { radius_m } => vec![(*at, sphere(*radius_m))],
            CollisionShape::Box { .. } | CollisionShape::ConvexHull { .. } => {
                let (at, size) = boxed(at, solid);
                vec![(at, self.element("box", &[("size", nums(&size))]))]
            }
        }
    }

    fn joint(&self, part: &Part) -> Option<String> {
        let (joint, parent) = (part.joint.as_ref()?, &self.parts[part.parent?]);
        let is_sdf = self.dialect == Dialect::Sdf;
        let is_limited = joint.limits.iter().all(|x| x.is_finite());
        let kind = match (joint.kind, is_sdf || is_limited) {
            (JointKind::Slides, _) => "prismatic",
            (JointKind::Turns, true) => "revolute",
            (JointKind::Turns, false) => "continuous",
        };
        let mut limit = Values::new();
        if kind != "continuous" {
            // SDF's own words for no limit; URDF has none.
            let most = if is_sdf { 1e16 } else { 1e3 };
            let [lower, upper] = joint.limits.map(|x| num(x.clamp(-most, most)));
            limit.extend([("lower", lower), ("upper", upper)]);
        }
        let drive = limits(joint).map(|x| x.is_finite().then_some(x));
        let drive = match (is_sdf, &joint.role) {
            (true, _) => drive,
            // A roller has no drive: tools that put a motor into each joint give it no torque.
            (false, Role::Roller) => [Some(0.0), Some(1000.0)],
            (false, _) => drive.map(|x| x.or(Some(1e6))),
        };
        let drive = ["effort", "velocity"].into_iter().zip(drive);
        limit.extend(drive.filter_map(|(name, x)| Some((name, num(x?)))));
        let mut dynamics = vec![
            ("damping", num(joint.bearing.damping_n_m_s)),
            ("friction", num(joint.bearing.friction_n_m)),
        ];
        if is_sdf {
            let [rest, stiffness] = joint.spring().unwrap_or_default().map(num);
            dynamics.extend([("spring_reference", rest), ("spring_stiffness", stiffness)]);
        }
        let limit = self.element("limit", &limit);
        let dynamics = self.element("dynamics", &dynamics);
        let moves = format!("{limit}{dynamics}{}", self.mimic(joint));
        let moves = match self.dialect {
            Dialect::Sdf => format!("<axis><xyz>0 0 1</xyz>{moves}</axis>"),
            Dialect::Urdf => {
                let place = self.place(&part.parent_from_part(self.parts));
                format!("{place}<axis xyz=\"0 0 1\"/>{moves}")
            }
        };
        let parent = self.value("parent", "link", &attribute(&parent.name));
        let child = self.value("child", "link", &attribute(&part.name));
        let name = attribute(joint.name);
        Some(format!(
            "<joint name=\"{name}\" type=\"{kind}\">{parent}{child}{moves}</joint>\n"
        ))
    }

    /// The joint that another follows, and how.
    fn mimic(&self, joint: &PartJoint) -> String {
        let robot = &self.fitted.robot;
        let is_it = |at: usize| robot.joints[at].name == joint.name;
        let Some(by) = robot.couplings.iter().find(|by| is_it(by.joint)) else {
            return String::new();
        };
        let name = attribute(&robot.joints[by.follows].name);
        let (factor, offset) = (num(by.factor), num(by.offset));
        match self.dialect {
            Dialect::Sdf => format!(
                "<mimic joint=\"{name}\"><multiplier>{factor}</multiplier><offset>{offset}</offset><reference>0</reference></mimic>"
            ),
            Dialect::Urdf => {
                format!("<mimic joint=\"{name}\" multiplier=\"{factor}\" offset=\"{offset}\"/>")
            }
        }
    }

    /// Gazebo's controllers of wheels and servos.
    fn plugins(&self) -> String {
        let mut out = String::new();
        for joint in self.parts.iter().filter_map(|part| part.joint.as_ref()) {
            let (plugin, class, gains) = match &joint.role {
                Role::Wheel { effort, .. } if *effort > 0.0 => {
                    ("joint-controller", "JointController", String::new())
                }
                Role::Body(JointRole::Driven(servo)) => {
                    let [p, d] = [servo.stiffness, servo.damping].map(num);
                    let most = num(servo.effort.min(1e16));
                    let gains = format!(
                        "<p_gain>{p}</p_gain><i_gain>0</i_gain><d_gain>{d}</d_gain><cmd_max>{most}</cmd_max><cmd_min>-{most}</cmd_min>"
                    );
                    (
                        "joint-position-controller",
                        "JointPositionController",
                        gains,
                    )
                }
                _ => continue,
            };
            let name = attribute(joint.name);
            let _ = writeln!(
                out,
                "<plugin filename=\"gz-sim-{plugin}-system\" name=\"gz::sim::systems::{class}\"><joint_name>{name}</joint_name>{gains}</plugin>"
            );
        }
        out
    }
}

fn surface(friction: f64) -> String {
    let mu = num(friction);
    format!("<surface><friction><ode><mu>{mu}</mu><mu2>{mu}</mu2></ode></friction></surface>")
}

/// The box around a solid, in the axes of its frame, and its sides in metres.
fn boxed(at: &Isometry3<f64>, solid: &CollisionShape) -> (Isometry3<f64>, [f64; 3]) {
    let collision = Collision {
        friction: None,
        body_from_shape: Isometry3::identity(),
        shape: solid.clone(),
    };
    let reach = |axis: usize, sign: f64| collision.reach_m(&(Vector3::ith(axis, sign)));
    let [x, y, z] = [0, 1, 2].map(|axis| 0.5 * (reach(axis, 1.0) - reach(axis, -1.0)));
    let size = [0, 1, 2].map(|axis| reach(axis, 1.0) + reach(axis, -1.0));
    (at * Isometry3::translation(x, y, z), size)
}

/// Largest effort and rate of a joint's drive; infinite without one.
fn limits(joint: &PartJoint) -> [f64; 2] {
    match &joint.role {
        Role::Wheel { effort, rate, .. } => [*effort, *rate],
        Role::Body(JointRole::Driven(servo)) => [servo.effort, servo.rate_limit],
        Role::Roller | Role::Body(_) => [f64::INFINITY; 2],
    }
}

/// The moments and products of inertia, in kg m^2, under the names that both formats have.
fn moments(mass: &MassProperties) -> Values<'static> {
    let i = &mass.inertia_kg_m2;
    let names = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
    let moments = [i.m11, i.m12, i.m13, i.m22, i.m23, i.m33].map(num);
    names.into_iter().zip(moments).collect()
}
