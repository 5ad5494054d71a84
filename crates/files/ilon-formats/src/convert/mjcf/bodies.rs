//! Bodies and their joints, written as links and joints.

use std::f64::consts::{PI, TAU};
use std::rc::Rc;

use mjcf_rs::compiler::InertiaFromGeom;
use mjcf_rs::equality::Equality;
use mjcf_rs::{body as mj, extras};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::geoms::{shapes_of, tensor, weight_of};
use super::model::{Robot, pose};
use crate::convert::assembled::Assembled;
use crate::convert::writer::{JointOf, Writer};
use crate::error::{Fault, RobotError};
use crate::model::{DriveTrain, JointSpring, Remark};
use crate::urdf::{Meshes, UrdfText};

/// The URDF of a robot that stands in a text.
pub(super) fn written(
    robot: &Robot,
    text: &Rc<Assembled>,
    meshes: &Meshes,
) -> Result<UrdfText, RobotError> {
    let name = robot.model.name.as_deref().unwrap_or("mujoco");
    let mut bodies = Bodies {
        robot,
        meshes,
        writer: Writer::new(text, name, robot.root_node),
        prepared: UrdfText::as_it_is(robot.file, ""),
    };
    let mut waiting = vec![(robot.root, None)];
    while let Some((id, above)) = waiting.pop() {
        let link_from_body = bodies.body(id, above)?;
        let children = robot.below[id].iter().rev();
        waiting.extend(children.map(|child| (*child, Some((id, link_from_body)))));
    }
    let (urdf, origins) = bodies.writer.finish();
    Ok(UrdfText {
        text: urdf.into(),
        origins,
        ..bodies.prepared
    })
}

/// What is written of a robot's bodies.
struct Bodies<'r, 'a, 'i> {
    robot: &'r Robot<'a, 'i>,
    meshes: &'r Meshes,
    writer: Writer,
    prepared: UrdfText,
}

/// Where a joint stands.
struct Between<'n> {
    name: String,
    parent: &'n str,
    child: &'n str,
    parent_from_joint: Isometry3<f64>,
}

impl<'a, 'i> Bodies<'_, 'a, 'i> {
    /// Writes a body with its joints; returns the body's frame in that of its link.
    ///
    /// `above` is the body that holds it, with that one's frame in the frame of its link.
    fn body(
        &mut self,
        id: usize,
        above: Option<(usize, Isometry3<f64>)>,
    ) -> Result<Isometry3<f64>, RobotError> {
        let body = &self.robot.model.bodies[id].body;
        let link_from_body = match above {
            Some((parent, link_from_parent)) => {
                let parent_from_body = link_from_parent * pose(&body.pose);
                self.joints(id, self.robot.name(parent), parent_from_body)?
            }
            None => {
                if !body.joints.is_empty() {
                    self.remark(id, "its joints to the world are not read");
                }
                // The robot stands in the world as drawn: a body that leans there, as drawn by
                // programs whose y is up, has not its own z for upright. Its heading is where it
                // starts, not which way is ahead.
                let turn = pose(&body.pose).rotation;
                let up = turn.inverse() * Vector3::z();
                let lean = UnitQuaternion::rotation_between(&up, &Vector3::z());
                let over = || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
                Isometry3::from_parts(Translation3::identity(), lean.unwrap_or_else(over))
            }
        };
        let name = self.robot.name(id);
        self.writer.begin_link(&name, self.robot.node(id));
        self.mass(id, &link_from_body)?;
        self.shapes(id, &link_from_body);
        self.writer.end_link();
        Ok(link_from_body)
    }

    /// Writes the chain of joints that holds a body; returns the body's frame in that of the last,
    /// which is its link's.
    fn joints(
        &mut self,
        id: usize,
        mut parent: String,
        mut parent_from_body: Isometry3<f64>,
    ) -> Result<Isometry3<f64>, RobotError> {
        let body = &self.robot.model.bodies[id].body;
        let (name, node) = (self.robot.name(id), self.robot.node(id));
        let mut link_from_body = Isometry3::identity();
        for (i, joint) in body.joints.iter().enumerate() {
            let body_from_joint = Isometry3::from(Translation3::from(joint.pos));
            let child = if i + 1 == body.joints.len() {
                name.clone()
            } else {
                // Between two joints of one body there is nothing.
                let between = format!("{name}_{}", i + 1);
                self.writer.begin_link(&between, node);
                self.writer.end_link();
                between
            };
            let otherwise = match i {
                0 => format!("{name}_joint"),
                _ => format!("{name}_joint_{}", i + 1),
            };
            self.joint(
                id,
                joint,
                Between {
                    name: joint.name.clone().unwrap_or(otherwise),
                    parent: &parent,
                    child: &child,
                    parent_from_joint: parent_from_body * body_from_joint,
                },
            )?;
            link_from_body = body_from_joint.inverse();
            parent_from_body = link_from_body;
            parent = child;
        }
        if body.joints.is_empty() {
            self.writer
                .joint(node, &fixed(&name, &parent, parent_from_body));
        }
        Ok(link_from_body)
    }

    fn joint(&mut self, id: usize, joint: &mj::Joint, between: Between) -> Result<(), RobotError> {
        let limited = joint
            .limited
            .resolve(self.robot.model.compiler.autolimits, joint.range.is_some());
        let range = joint.range.filter(|_| limited);
        let turns = range.is_none_or(|[lower, upper]| upper - lower >= TAU);
        let kind = match joint.type_ {
            mj::JointType::Hinge if turns => "continuous",
            mj::JointType::Hinge => "revolute",
            mj::JointType::Slide => "prismatic",
            mj::JointType::Ball => "spherical",
            mj::JointType::Free => {
                let name = self.robot.name(id);
                return Err(self.fault(format!("the body `{name}` is free within the robot")));
            }
        };
        if joint.armature > 0.0 {
            // MuJoCo adds the armature at the joint: a rotor without a gear.
            let drive = DriveTrain {
                rotor_inertia_kg_m2: joint.armature,
                ..DriveTrain::default()
            };
            self.prepared.drives.insert(between.name.clone(), drive);
        }
        self.spring(joint, &between.name);
        let (effort, velocity) = self.limits(joint.name.as_deref());
        let mimic = joint.name.as_deref().filter(|_| kind != "continuous");
        let mimic = mimic.and_then(|name| self.follows(name));
        let written = JointOf {
            name: &between.name,
            kind,
            parent: between.parent,
            child: between.child,
            parent_from_joint: between.parent_from_joint,
            axis: Vector3::from(joint.axis),
            // At `ref` the body stands as drawn; a joint here then stands at zero.
            range: range
                .filter(|_| kind != "continuous")
                .map(|range| range.map(|stop| stop - joint.ref_)),
            effort,
            velocity,
            // Some models lock a joint by a damping beyond what is read; this one locks it as well.
            damping: joint.damping.clamp(0.0, 1e8),
            friction: joint.frictionloss.max(0.0),
            mimic,
        };
        self.writer.joint(self.robot.node(id), &written);
        Ok(())
    }

    /// Keeps the spring of a joint: MuJoCo acts with -stiffness (q - springref), where the body
    /// stands as drawn at q = `ref`.
    fn spring(&mut self, joint: &mj::Joint, name: &str) {
        /// No joint comes near such a rest, in rad or m, and its force would leave no step short
        /// enough.
        const FARTHEST_REST: f64 = 1e4;
        if joint
            .springdamper
            .is_some_and(|of| of.iter().all(|of| *of > 0.0))
        {
            let subject = format!("joint `{name}`");
            let words = "its `springdamper`, a spring by its time constant, is not read: write `stiffness` and `damping`";
            self.prepared.remarks.push(Remark::new(subject, words));
        }
        let moves = matches!(joint.type_, mj::JointType::Hinge | mj::JointType::Slide);
        if moves && (joint.stiffness < 0.0 || !joint.stiffness.is_finite()) {
            let subject = format!("joint `{name}`");
            let words = format!(
                "its stiffness of {} is no spring's, and not simulated: write a number above 0, or leave it out",
                joint.stiffness
            );
            self.prepared.remarks.push(Remark::new(subject, words));
        }
        if moves && joint.stiffness > 0.0 && joint.stiffness.is_finite() {
            let rest = joint.springref - joint.ref_;
            if rest.is_nan() || rest.abs() > FARTHEST_REST {
                let words = format!(
                    "its spring rests at {rest}, which no joint reaches, and is not simulated: correct `springref`"
                );
                let subject = format!("joint `{name}`");
                self.prepared.remarks.push(Remark::new(subject, words));
                return;
            }
            let spring = JointSpring {
                stiffness: joint.stiffness,
                rest,
                preload: 0.0,
            };
            self.prepared.springs.insert(name.to_owned(), spring);
        }
    }

    /// What a joint follows by an equality of the file: the other joint, factor and offset. MuJoCo
    /// counts both from `ref`, as joints here count.
    fn follows(&mut self, joint: &str) -> Option<(&'a str, f64, f64)> {
        let model = self.robot.model;
        let equality = model.equality.iter().find_map(|equality| match equality {
            Equality::Joint(of) if of.common.active && of.joint1 == joint => Some(of),
            _ => None,
        })?;
        let [offset, factor, higher @ ..] = equality.polycoef;
        let master = equality.joint2.as_deref();
        if master.is_none() || higher != [0.0; 3] {
            let words = match master {
                None => "an `<equality>` fixes it, which is not read: give it the role `held`",
                Some(_) => {
                    "an `<equality>` bends what it follows by, which is not read: only the first two of its `polycoef` may differ from 0"
                }
            };
            let remark = Remark::new(format!("joint `{joint}`"), words);
            self.prepared.remarks.push(remark);
            return None;
        }
        Some((master?, factor, offset))
    }

    /// The largest torque and rate that the actuators of a joint give it.
    fn limits(&self, joint: Option<&str>) -> (Option<f64>, Option<f64>) {
        let of_joint =
            |actuator: &&extras::Actuator| joint.is_some() && actuator.joint.as_deref() == joint;
        let Some(actuator) = self.robot.model.actuators.iter().find(of_joint) else {
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

    /// Writes what a body weighs: what its file says, or else what its geoms weigh.
    fn mass(&mut self, id: usize, link_from_body: &Isometry3<f64>) -> Result<(), RobotError> {
        let (body, node) = (&self.robot.model.bodies[id].body, self.robot.node(id));
        let of_geoms = self.robot.model.compiler.inertia_from_geom;
        let said = body
            .inertial
            .as_ref()
            .filter(|_| of_geoms != InertiaFromGeom::True);
        if let Some(inertial) = said {
            let place = link_from_body * pose(&inertial.pose);
            let inertia = tensor(&inertial.inertia);
            self.writer
                .inertial(node, &place, inertial.mass, Some(&inertia));
        } else if of_geoms != InertiaFromGeom::False {
            match weight_of(&body.geoms, self.robot, self.meshes) {
                Ok(None) => {}
                Ok(Some(mass)) => {
                    let center = Isometry3::from(Translation3::from(mass.center_of_mass_m));
                    let (place, inertia) = (link_from_body * center, mass.inertia_kg_m2);
                    self.writer
                        .inertial(node, &place, mass.mass_kg, Some(&inertia));
                }
                Err(why) => {
                    let name = self.robot.name(id);
                    return Err(self.fault(format!(
                        "the body `{name}` weighs what its meshes weigh, which is not known: {why}; put the mesh there, or write the body's `<inertial>`"
                    )));
                }
            }
        }
        Ok(())
    }

    fn shapes(&mut self, id: usize, link_from_body: &Isometry3<f64>) {
        /// What a geom has that says none.
        const DEFAULT_FRICTION: f64 = 1.0;
        for geom in &self.robot.model.bodies[id].body.geoms {
            if (geom.friction[0] - DEFAULT_FRICTION).abs() > 1e-9 {
                let said = self.prepared.remarks.iter();
                if !said.into_iter().any(|known| known.subject == "friction") {
                    let words = format!(
                        "that of geoms, such as {}, is not read: what counts is the floor's, `world.floor.friction`",
                        geom.friction[0]
                    );
                    self.prepared.remarks.push(Remark::new("friction", words));
                }
            }
            let tag = if geom.contype == 0 && geom.conaffinity == 0 {
                "visual"
            } else {
                "collision"
            };
            let place = link_from_body * pose(&geom.pose);
            match shapes_of(geom, self.robot.model) {
                Ok(shapes) => {
                    for (offset, shape) in shapes {
                        let node = self.robot.node(id);
                        self.writer.shape(tag, node, &(place * offset), &shape);
                    }
                }
                Err(words) => self.remark(id, words),
            }
        }
    }

    fn remark(&mut self, id: usize, words: &str) {
        let subject = format!("link `{}`", self.robot.name(id));
        self.prepared.remarks.push(Remark::new(subject, words));
    }

    fn fault(&self, reason: String) -> RobotError {
        RobotError::new(self.robot.file, Fault::Format { reason })
    }
}

fn fixed<'n>(child: &'n str, parent: &'n str, parent_from_joint: Isometry3<f64>) -> JointOf<'n> {
    JointOf {
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
        mimic: None,
    }
}
