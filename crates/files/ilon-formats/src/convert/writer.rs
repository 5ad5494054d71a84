//! Writes a URDF, and keeps where its elements came from.

use std::fmt::Write;
use std::rc::Rc;

use nalgebra::{Isometry3, Matrix3, Vector3};
use roxmltree::Node;

use super::assembled::Assembled;
use crate::generate::elements::{attribute as escaped, inertia as inertia_element, origin};
use crate::urdf::Origin;
use crate::xml;

/// Where a slide without limits ends, in metres: nothing goes as far. Chosen.
pub(super) const FAR_M: f64 = 100.0;

/// A URDF that is being written.
pub(super) struct Writer {
    source: Rc<Assembled>,
    out: String,
    origins: Vec<(usize, Origin)>,
}

/// A joint of a URDF.
pub(super) struct JointOf<'a> {
    pub(super) name: &'a str,
    pub(super) kind: &'a str,
    pub(super) parent: &'a str,
    pub(super) child: &'a str,
    pub(super) parent_from_joint: Isometry3<f64>,
    pub(super) axis: Vector3<f64>,
    /// Lower and upper.
    pub(super) range: Option<[f64; 2]>,
    pub(super) effort: Option<f64>,
    pub(super) velocity: Option<f64>,
    pub(super) damping: f64,
    pub(super) friction: f64,
    /// The joint that it follows, its movement per movement of that, and where it stands while that
    /// stands at zero.
    pub(super) mimic: Option<(&'a str, f64, f64)>,
}

/// A shape of a URDF.
pub(super) enum ShapeOf {
    Box(Vector3<f64>),
    Cylinder { radius: f64, length: f64 },
    Capsule { radius: f64, length: f64 },
    Sphere(f64),
    Mesh { file: String, scale: Vector3<f64> },
}

impl Writer {
    /// For a robot that stands in a text.
    pub(super) fn new(source: &Rc<Assembled>, robot: &str, root: Node) -> Self {
        let mut writer = Self {
            source: Rc::clone(source),
            out: String::new(),
            origins: Vec::new(),
        };
        writer.begin("robot", root);
        writer.attribute("name", robot);
        writer.out.push_str(">\n");
        writer
    }

    /// The text, and where its elements came from.
    pub(super) fn finish(mut self) -> (String, Vec<(usize, Origin)>) {
        self.out.push_str("</robot>\n");
        (self.out, self.origins)
    }

    fn begin(&mut self, tag: &str, node: Node) {
        let origin = self
            .source
            .origin(xml::opening_tag(&self.source.text, node));
        self.origins
            .extend(origin.map(|origin| (self.out.len(), origin)));
        self.out.push('<');
        self.out.push_str(tag);
    }

    fn attribute(&mut self, name: &str, value: &str) {
        let _ = write!(self.out, " {name}=\"{}\"", escaped(value));
    }

    /// Begins a link, which lasts until the next [`Self::end_link`].
    pub(super) fn begin_link(&mut self, name: &str, node: Node) {
        self.begin("link", node);
        self.attribute("name", name);
        self.out.push_str(">\n");
    }

    pub(super) fn end_link(&mut self) {
        self.out.push_str("</link>\n");
    }

    /// The mass properties of the link, in a frame at its centre of mass.
    pub(super) fn inertial(
        &mut self,
        node: Node,
        link_from_inertial: &Isometry3<f64>,
        mass_kg: f64,
        inertia: Option<&Matrix3<f64>>,
    ) {
        self.begin("inertial", node);
        self.out.push('>');
        self.origin(link_from_inertial);
        let _ = write!(self.out, "<mass value=\"{mass_kg}\"/>");
        if let Some(i) = inertia {
            self.out.push_str(&inertia_element(i));
        }
        self.out.push_str("</inertial>\n");
    }

    /// A shape of the link, `collision` or `visual`.
    pub(super) fn shape(
        &mut self,
        tag: &str,
        node: Node,
        link_from_shape: &Isometry3<f64>,
        shape: &ShapeOf,
    ) {
        self.begin(tag, node);
        self.out.push('>');
        self.origin(link_from_shape);
        self.out.push_str("<geometry>");
        let _ = match shape {
            ShapeOf::Box(s) => write!(self.out, "<box size=\"{} {} {}\"/>", s.x, s.y, s.z),
            ShapeOf::Cylinder { radius, length } => {
                write!(
                    self.out,
                    "<cylinder radius=\"{radius}\" length=\"{length}\"/>"
                )
            }
            ShapeOf::Capsule { radius, length } => {
                write!(
                    self.out,
                    "<capsule radius=\"{radius}\" length=\"{length}\"/>"
                )
            }
            ShapeOf::Sphere(radius) => write!(self.out, "<sphere radius=\"{radius}\"/>"),
            ShapeOf::Mesh { file, scale } => {
                self.out.push_str("<mesh");
                self.attribute("filename", file);
                write!(self.out, " scale=\"{} {} {}\"/>", scale.x, scale.y, scale.z)
            }
        };
        let _ = writeln!(self.out, "</geometry></{tag}>");
    }

    pub(super) fn joint(&mut self, node: Node, joint: &JointOf) {
        self.begin("joint", node);
        self.attribute("name", joint.name);
        self.attribute("type", joint.kind);
        self.out.push('>');
        for (tag, link) in [("parent", joint.parent), ("child", joint.child)] {
            self.out.push('<');
            self.out.push_str(tag);
            self.attribute("link", link);
            self.out.push_str("/>");
        }
        self.origin(&joint.parent_from_joint);
        let a = joint.axis;
        let _ = write!(self.out, "<axis xyz=\"{} {} {}\"/>", a.x, a.y, a.z);
        self.out.push_str("<limit");
        // URDF takes a slide without limits for one that cannot move.
        let endless = (joint.kind == "prismatic").then_some([-FAR_M, FAR_M]);
        if let Some([lower, upper]) = joint.range.or(endless) {
            let _ = write!(self.out, " lower=\"{lower}\" upper=\"{upper}\"");
        }
        for (name, value) in [("effort", joint.effort), ("velocity", joint.velocity)] {
            if let Some(value) = value {
                let _ = write!(self.out, " {name}=\"{value}\"");
            }
        }
        let _ = write!(
            self.out,
            "/><dynamics damping=\"{}\" friction=\"{}\"/>",
            joint.damping, joint.friction
        );
        if let Some((name, multiplier, offset)) = joint.mimic {
            self.out.push_str("<mimic");
            self.attribute("joint", name);
            let _ = write!(
                self.out,
                " multiplier=\"{multiplier}\" offset=\"{offset}\"/>"
            );
        }
        self.out.push_str("</joint>\n");
    }

    /// What another program reads, as it would stand in a URDF.
    pub(super) fn raw(&mut self, node: Node, tag: &str, rest: &str) {
        self.begin(tag, node);
        self.out.push_str(rest);
        self.out.push('\n');
    }

    fn origin(&mut self, pose: &Isometry3<f64>) {
        if *pose == Isometry3::identity() {
            return;
        }
        self.out.push_str(&origin(pose));
    }
}
