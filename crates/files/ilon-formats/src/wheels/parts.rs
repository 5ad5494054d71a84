//! A robot as a tree of bodies on joints, which all formats write.

use nalgebra::{Isometry3, Vector3};

use super::fit::FittedRobot;
use super::shape::RollerShape;
use crate::model::{Collision, Joint, JointKind, JointRole, MassProperties, Roller};

/// A body and the joint on which it moves; all frames are at zero of all joints.
pub(super) struct Part<'a> {
    /// The body's name, which no other part has.
    pub(super) name: String,
    /// The part that carries it.
    pub(super) parent: Option<usize>,
    /// Its frame in the body frame.
    pub(super) body_from_part: Isometry3<f64>,
    /// Its mass properties in its frame.
    pub(super) mass: MassProperties,
    /// Its joint; `None` of the chassis.
    pub(super) joint: Option<PartJoint<'a>>,
    /// What it touches the world with, in its frame.
    pub(super) shapes: Vec<(Isometry3<f64>, Shape<'a>)>,
    /// A hub to look at: radius and width, in metres.
    pub(super) hub_m: Option<[f64; 2]>,
}

/// A joint about, or along, the z axis of its part.
pub(super) struct PartJoint<'a> {
    pub(super) name: &'a str,
    pub(super) kind: JointKind,
    pub(super) limits: [f64; 2],
    pub(super) bearing: Joint,
    pub(super) armature: f64,
    pub(super) role: Role<'a>,
}

pub(super) enum Role<'a> {
    Wheel { effort: f64, rate: f64, gain: f64 },
    Roller,
    Body(&'a JointRole),
}

impl<'a> PartJoint<'a> {
    /// One that turns without limits.
    fn turning(name: &'a str, bearing: Joint, role: Role<'a>) -> Self {
        Self {
            name,
            kind: JointKind::Turns,
            limits: [f64::NEG_INFINITY, f64::INFINITY],
            bearing,
            armature: 0.0,
            role,
        }
    }

    /// Where its spring is at rest, with the preload, and its stiffness; `None` without one.
    pub(super) fn spring(&self) -> Option<[f64; 2]> {
        let Role::Body(JointRole::Sprung(of)) = self.role else {
            return None;
        };
        Some([of.rest + of.preload / of.stiffness, of.stiffness])
    }
}

/// A shape of another format.
pub(super) enum Shape<'a> {
    Solid(&'a Collision),
    Ellipsoid([f64; 2]),
}

/// The robot's parts, parents before their children.
pub(super) fn parts(fitted: &FittedRobot) -> Vec<Part<'_>> {
    /// A wheel's servo of velocity settles in this time, in seconds.
    const SERVO_S: f64 = 0.02;
    let robot = &fitted.robot;
    // MuJoCo's own body.
    let mut names = std::collections::HashSet::from(["world".to_owned()]);
    let mut unique = |name: String| {
        let mut name = name;
        while !names.insert(name.clone()) {
            name.push('_');
        }
        name
    };
    let chassis = &robot.chassis;
    let mut parts = vec![Part {
        name: unique(chassis.name.clone()),
        parent: None,
        body_from_part: Isometry3::identity(),
        mass: chassis.mass.clone(),
        joint: None,
        shapes: chassis.collisions.iter().map(solid).collect(),
        hub_m: None,
    }];
    for joint in &robot.joints {
        let joint_from_body = joint.body_from_joint.inverse();
        let in_joint = |(pose, shape)| (joint_from_body * pose, shape);
        let shapes = joint.body.collisions.iter();
        let bearing = Joint {
            damping_n_m_s: joint.damping,
            friction_n_m: joint.friction,
        };
        parts.push(Part {
            name: unique(joint.body.name.clone()),
            parent: Some(joint.parent.map_or(0, |at| at + 1)),
            body_from_part: joint.body_from_joint,
            mass: joint.body.mass.clone(),
            joint: Some(PartJoint {
                kind: joint.kind,
                limits: joint.limits,
                ..PartJoint::turning(&joint.name, bearing, Role::Body(&joint.role))
            }),
            shapes: shapes.map(solid).map(in_joint).collect(),
            hub_m: None,
        });
    }
    let share_kg = robot.mass_kg() / robot.wheels.len() as f64;
    for (wheel, shapes) in robot.wheels.iter().zip(&fitted.shapes) {
        let name = unique(format!("{}_link", wheel.name));
        let armature = wheel.drive.reflected_inertia_kg_m2();
        let own = wheel.hub.inertia_kg_m2.m33 + armature;
        let carrier = parts.len();
        let most = |of: fn(&Roller) -> f64| wheel.rollers.iter().map(of).fold(0.0, f64::max);
        let (ring_m, thick_m) = (most(Roller::ring_radius_m), most(|roller| roller.radius_m));
        let role = Role::Wheel {
            effort: wheel.motor.effort_n_m,
            rate: wheel.motor.velocity_rad_s,
            gain: (share_kg * wheel.radius_m * wheel.radius_m + own) / SERVO_S,
        };
        let friction_n_m = wheel.dry_friction_n_m();
        let bearing = Joint {
            friction_n_m,
            ..wheel.joint
        };
        parts.push(Part {
            name,
            parent: Some(wheel.carrier.map_or(0, |at| at + 1)),
            body_from_part: wheel.body_from_hub,
            mass: wheel.hub.clone(),
            joint: Some(PartJoint {
                armature,
                ..PartJoint::turning(&wheel.name, bearing, role)
            }),
            // A tyre turns with its hub.
            shapes: match wheel.has_tyre() {
                true => shapes.iter().flat_map(solids).collect(),
                false => Vec::new(),
            },
            hub_m: (!wheel.has_tyre()).then(|| [(ring_m - thick_m).max(0.3 * ring_m), thick_m]),
        });
        let rollers = wheel.rollers.iter().zip(shapes);
        for (roller, shape) in rollers.filter(|_| !wheel.has_tyre()) {
            let across = roller.transverse_inertia_kg_m2;
            let moments = Vector3::new(across, across, roller.axial_inertia_kg_m2);
            let joint = PartJoint::turning(&roller.name, roller.joint, Role::Roller);
            parts.push(Part {
                name: unique(format!("{}_link", roller.name)),
                parent: Some(carrier),
                body_from_part: wheel.body_from_hub * roller.hub_from_roller(),
                mass: MassProperties {
                    mass_kg: roller.mass_kg,
                    center_of_mass_m: Vector3::zeros(),
                    inertia_kg_m2: nalgebra::Matrix3::from_diagonal(&moments),
                },
                joint: Some(joint),
                shapes: solids(shape),
                hub_m: None,
            });
        }
    }
    parts
}

/// The shapes of a roller or a tyre, in its frame.
fn solids(shape: &RollerShape) -> Vec<(Isometry3<f64>, Shape<'_>)> {
    match shape {
        RollerShape::Ellipsoids {
            radius_m,
            half_length_m,
            at_m,
        } => {
            let shape = || Shape::Ellipsoid([*radius_m, *half_length_m]);
            let placed = |t_m: &f64| (Isometry3::translation(0.0, 0.0, *t_m), shape());
            at_m.iter().map(placed).collect()
        }
        RollerShape::Solids(solids) => solids.iter().map(solid).collect(),
    }
}

fn solid(of: &Collision) -> (Isometry3<f64>, Shape<'_>) {
    (of.body_from_shape, Shape::Solid(of))
}

impl Part<'_> {
    /// Its frame in that of the part which carries it.
    pub(super) fn parent_from_part(&self, parts: &[Self]) -> Isometry3<f64> {
        let parent = self.parent.map(|at| parts[at].body_from_part);
        parent.unwrap_or_default().inverse() * self.body_from_part
    }
}
