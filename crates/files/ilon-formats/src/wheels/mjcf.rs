//! A robot as MJCF.

use std::fmt::Write;

use nalgebra::Isometry3;

use super::fit::FittedRobot;
use super::frame::{Ground, STEP_S, about_comment};
use super::parts::{Part, PartJoint, Role, Shape};

use crate::generate::elements::{attribute, num, nums};
use crate::model::{CollisionShape, Coupling, JointKind, JointRole, Robot, Wheel};

/// Of contacts of rollers: the time constant, two steps, which stops what comes down within a step.
const SETTLES_S: f64 = 2.0 * STEP_S;
/// Of those of tyres: a tyre slides across its way in turns, and a contact that settles in two steps then opens and closes, so that its
/// friction is not Coulomb's.
const TYRE_SETTLES_S: f64 = 10.0 * STEP_S;
/// Their impedance, at all depths: a harder contact opens again in the step after each hand-over, a softer one creeps.
const IMPEDANCE: f64 = 0.98;
/// How much harder friction is than the normal of a contact.
const IMPRATIO: &str = "10";

/// Stiffness of the contact that carries a mass, in N/m. MuJoCo's constraint at rest: r = (1 - d) g t^2, with r how deep it is.
pub fn contact_stiffness_n_m(carried_kg: f64) -> f64 {
    carried_kg / ((1.0 - IMPEDANCE) * SETTLES_S * SETTLES_S)
}

/// The model. `meshes` names a file for each mesh of a roller.
pub(super) fn write(
    fitted: &FittedRobot,
    parts: &[Part],
    meshes: &[String],
    ground: &Ground,
    about: &str,
) -> String {
    let robot = &fitted.robot;
    let mut hulls = String::new();
    let mut bodies = String::new();
    body(&mut bodies, &mut hulls, parts, 0, fitted.ride_height_m);
    let mut out = about_comment(about);
    let _ = writeln!(
        out,
        "<mujoco model=\"{}\">\n  <compiler angle=\"radian\" balanceinertia=\"true\"/>\n  \
         <option timestep=\"{}\" integrator=\"implicitfast\" cone=\"elliptic\" impratio=\"{IMPRATIO}\" gravity=\"0 0 {}\"/>\n  \
         <size memory=\"64M\"/>\n  <default>\n    <default class=\"roller\">\n      \
         <geom contype=\"1\" conaffinity=\"0\" condim=\"3\" priority=\"1\" friction=\"{} 0.005 0.0001\" solref=\"{} 1\" solimp=\"{IMPEDANCE} {IMPEDANCE} 0.001 0.5 2\" rgba=\"0.15 0.15 0.15 1\"/>\n    \
         </default>\n    <default class=\"body\">\n      <geom contype=\"1\" conaffinity=\"0\" friction=\"{} 0.005 0.0001\" rgba=\"0.35 0.4 0.45 1\"/>\n    \
         </default>\n  </default>",
        attribute(&robot.name),
        num(STEP_S),
        num(-ground.gravity_m_s2),
        num(ground.friction),
        num(match robot.wheels.iter().any(Wheel::has_tyre) {
            true => TYRE_SETTLES_S,
            false => SETTLES_S,
        }),
        num(ground.friction),
    );
    let _ = writeln!(out, "  <asset>");
    for (index, file) in meshes.iter().enumerate() {
        let _ = writeln!(
            out,
            "    <mesh name=\"roller_{index}\" file=\"{}\"/>",
            attribute(file)
        );
    }
    let _ = writeln!(
        out,
        "{hulls}  </asset>\n  <worldbody>\n{bodies}  </worldbody>"
    );
    couplings(&mut out, robot);
    let _ = writeln!(out, "  <actuator>");
    for joint in parts.iter().filter_map(|part| part.joint.as_ref()) {
        actuator(&mut out, joint);
    }
    let _ = writeln!(
        out,
        "  </actuator>\n  <sensor>\n    <framepos name=\"base_position\" objtype=\"site\" objname=\"base\"/>\n    \
         <framequat name=\"base_orientation\" objtype=\"site\" objname=\"base\"/>\n    <velocimeter name=\"base_velocity\" site=\"base\"/>\n    \
         <gyro name=\"base_gyro\" site=\"base\"/>\n    <accelerometer name=\"base_accelerometer\" site=\"base\"/>"
    );
    for wheel in &robot.wheels {
        let name = attribute(&wheel.name);
        let _ = writeln!(
            out,
            "    <jointpos name=\"{name}_angle\" joint=\"{name}\"/>\n    <jointvel name=\"{name}_rate\" joint=\"{name}\"/>"
        );
    }
    out + "  </sensor>\n</mujoco>\n"
}

/// A level floor to start on, around the model in a file of this name.
pub(super) fn scene(file: &str, ground: &Ground) -> String {
    format!(
        "<mujoco model=\"scene\">\n  <include file=\"{}\"/>\n  <visual><headlight ambient=\"0.3 0.3 0.3\"/></visual>\n  <asset>\n    \
         <texture name=\"grid\" type=\"2d\" builtin=\"checker\" rgb1=\"0.8 0.8 0.8\" rgb2=\"0.7 0.7 0.7\" width=\"256\" height=\"256\"/>\n    \
         <material name=\"grid\" texture=\"grid\" texrepeat=\"2 2\" texuniform=\"true\"/>\n  </asset>\n  <worldbody>\n    \
         <light pos=\"0 0 3\" dir=\"0 0 -1\" directional=\"true\"/>\n    \
         <geom name=\"floor\" type=\"plane\" size=\"0 0 1\" material=\"grid\" friction=\"{} 0.005 0.0001\"/>\n  </worldbody>\n</mujoco>\n",
        attribute(file),
        num(ground.friction)
    )
}

fn place(pose: &Isometry3<f64>) -> String {
    let q = pose.rotation;
    format!(
        "pos=\"{}\" quat=\"{}\"",
        nums(pose.translation.vector.as_slice()),
        nums(&[q.w, q.i, q.j, q.k])
    )
}

fn body(out: &mut String, hulls: &mut String, parts: &[Part], index: usize, height_m: f64) {
    let part = &parts[index];
    let mut pose = part.parent_from_part(parts);
    if part.parent.is_none() {
        pose.translation.z += height_m;
    }
    let _ = writeln!(
        out,
        "    <body name=\"{}\" {}>",
        attribute(&part.name),
        place(&pose)
    );
    let class = match &part.joint {
        None => {
            let _ = writeln!(out, "      <freejoint/>\n      <site name=\"base\"/>");
            "body"
        }
        Some(joint) => {
            write_joint(out, joint);
            match joint.role {
                Role::Roller | Role::Wheel { .. } => "roller",
                Role::Body(_) => "body",
            }
        }
    };
    let (mass, i) = (&part.mass, &part.mass.inertia_kg_m2);
    // A body that moves must weigh something.
    let (least_kg, least) = (1e-6, 1e-9);
    let _ = writeln!(
        out,
        "      <inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{}\"/>",
        nums(mass.center_of_mass_m.as_slice()),
        num(mass.mass_kg.max(least_kg)),
        nums(&[
            i.m11.max(least),
            i.m22.max(least),
            i.m33.max(least),
            i.m12,
            i.m13,
            i.m23
        ])
    );
    for (at, shape) in &part.shapes {
        let shape = match shape {
            Shape::Ellipsoid([a, c]) => {
                format!("type=\"ellipsoid\" size=\"{}\"", nums(&[*a, *a, *c]))
            }
            Shape::Mesh(mesh) => format!("type=\"mesh\" mesh=\"roller_{mesh}\""),
            Shape::Solid(solid) => geom(&solid.shape, hulls) + &friction(solid.friction),
        };
        let mut at = *at;
        if class == "body" && shape.contains("cylinder") {
            // MuJoCo finds a cylinder deep in a plane to which its axis is normal but for rounding.
            at.rotation *= nalgebra::UnitQuaternion::from_euler_angles(1e-4, 0.0, 0.0);
        }
        let _ = writeln!(
            out,
            "      <geom class=\"{class}\" {shape} {}/>",
            place(&at)
        );
    }
    if let Some([radius_m, half_m]) = part.hub_m {
        let _ = writeln!(
            out,
            "      <geom type=\"cylinder\" size=\"{}\" contype=\"0\" conaffinity=\"0\" group=\"1\" mass=\"0\" rgba=\"0.75 0.75 0.78 1\"/>",
            nums(&[radius_m, half_m])
        );
    }
    for (child, _) in parts
        .iter()
        .enumerate()
        .filter(|(_, of)| of.parent == Some(index))
    {
        body(out, hulls, parts, child, height_m);
    }
    let _ = writeln!(out, "    </body>");
}

/// The friction of a shape that has its own, such as of a ball: without priority the floor's, if greater, would hold.
fn friction(of_shape: Option<f64>) -> String {
    of_shape.map_or(String::new(), |friction| {
        format!(
            " priority=\"1\" friction=\"{} 0.005 0.0001\"",
            num(friction)
        )
    })
}

fn geom(solid: &CollisionShape, hulls: &mut String) -> String {
    let (kind, sizes) = match solid {
        CollisionShape::Box { half_extents_m: h } => ("box", vec![h.x, h.y, h.z]),
        CollisionShape::Cylinder { radius_m, length_m } => {
            ("cylinder", vec![*radius_m, 0.5 * length_m])
        }
        CollisionShape::Capsule { radius_m, length_m } => {
            ("capsule", vec![*radius_m, 0.5 * length_m])
        }
        CollisionShape::Sphere { radius_m } => ("sphere", vec![*radius_m]),
        CollisionShape::ConvexHull { points_m } => {
            let name = format!("hull_{}", hulls.lines().count());
            let points: Vec<String> = points_m.iter().map(|p| nums(p.coords.as_slice())).collect();
            let _ = writeln!(
                hulls,
                "    <mesh name=\"{name}\" vertex=\"{}\"/>",
                points.join(" ")
            );
            return format!("type=\"mesh\" mesh=\"{name}\"");
        }
    };
    format!("type=\"{kind}\" size=\"{}\"", nums(&sizes))
}

fn write_joint(out: &mut String, joint: &PartJoint) {
    let kind = match joint.kind {
        JointKind::Turns => "hinge",
        JointKind::Slides => "slide",
    };
    let _ = write!(
        out,
        "      <joint name=\"{}\" type=\"{kind}\" axis=\"0 0 1\" damping=\"{}\" frictionloss=\"{}\" armature=\"{}\"",
        attribute(joint.name),
        num(joint.bearing.damping_n_m_s),
        num(joint.bearing.friction_n_m),
        num(joint.armature)
    );
    if joint.limits.iter().all(|limit| limit.is_finite()) {
        let _ = write!(out, " limited=\"true\" range=\"{}\"", nums(&joint.limits));
    }
    if let Role::Body(JointRole::Sprung(spring)) = joint.role {
        let rest = spring.rest + spring.preload / spring.stiffness;
        let _ = write!(
            out,
            " stiffness=\"{}\" springref=\"{}\"",
            num(spring.stiffness),
            num(rest)
        );
    }
    let _ = writeln!(out, "/>");
}

fn actuator(out: &mut String, joint: &PartJoint) {
    let name = attribute(joint.name);
    let both = |word: &str, most: f64| match most.is_finite() {
        true => format!(" {word}=\"{}\"", nums(&[-most, most])),
        false => String::new(),
    };
    let _ = match &joint.role {
        // Nothing drives a wheel that only rolls along.
        Role::Wheel { effort, .. } if *effort == 0.0 => Ok(()),
        Role::Wheel { effort, rate, gain } => writeln!(
            out,
            "    <velocity name=\"{name}\" joint=\"{name}\" kv=\"{}\"{}{}/>",
            num(*gain),
            both("ctrlrange", *rate),
            both("forcerange", *effort)
        ),
        Role::Body(JointRole::Driven(servo)) => writeln!(
            out,
            "    <position name=\"{name}\" joint=\"{name}\" kp=\"{}\" kv=\"{}\"{}/>",
            num(servo.stiffness),
            num(servo.damping),
            both("forcerange", servo.effort)
        ),
        Role::Body(_) | Role::Roller => Ok(()),
    };
}

fn couplings(out: &mut String, robot: &Robot) {
    if robot.couplings.is_empty() {
        return;
    }
    let _ = writeln!(out, "  <equality>");
    for Coupling {
        joint,
        follows,
        factor,
        offset,
    } in &robot.couplings
    {
        let [joint, follows] = [*joint, *follows].map(|at| attribute(&robot.joints[at].name));
        let _ = writeln!(
            out,
            "    <joint joint1=\"{joint}\" joint2=\"{follows}\" polycoef=\"{} 0 0 0\"/>",
            nums(&[*offset, *factor])
        );
    }
    let _ = writeln!(out, "  </equality>");
}
