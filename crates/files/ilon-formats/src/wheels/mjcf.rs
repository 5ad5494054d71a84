//! A robot as MJCF.

use std::fmt::Write;

use nalgebra::{Isometry3, Vector3};

use super::fit::FittedRobot;
use super::frame::{Ground, STEP_S, about_comment};
use super::parts::{Part, PartJoint, Role, Shape};

use crate::generate::elements::{attribute, num, nums};
use crate::model::{CollisionShape, Coupling, JointKind, JointRole, MassProperties, Robot};

/// Time constant of contacts of rollers: two steps, the shortest that MuJoCo takes.
const SETTLES_S: f64 = 2.0 * STEP_S;
/// Of those of tyres: a tyre slides across its way in turns, and a contact that settles in two steps
/// then opens and closes, so that its friction is not Coulomb's.
const TYRE_SETTLES_S: f64 = 10.0 * STEP_S;
const TYRE_IMPEDANCE: f64 = 0.98;
/// How deep a roller sinks, over the wheel's radius: as far as native shapes raise and lower hubs.
/// Where contacts are much harder, wheels leave the ground at each hand-over.
const SAG: f64 = 4e-4;
/// How much harder friction is than the normal of a contact.
const IMPRATIO: &str = "10";

/// Stiffness of a roller's contact in the MJCF, in N/m.
pub fn contact_stiffness_n_m(robot: &Robot) -> f64 {
    const GRAVITY_M_S2: f64 = 9.81;
    let carried_kg = robot.mass_kg() / robot.wheels.len() as f64;
    carried_kg * GRAVITY_M_S2 / (SAG * robot.mean_wheel_radius_m())
}

/// The impedance d by which contacts have that stiffness k. MuJoCo's contact at rest has
/// k = 1 / ((1 - d) a t^2), with its time constant t and the inverse mass a at the roller's centre.
fn impedance(robot: &Robot, parts: &[Part]) -> f64 {
    let stiffness_n_m = contact_stiffness_n_m(robot);
    let yields = stiffness_n_m * mean_inverse_mass_per_kg(parts) * SETTLES_S * SETTLES_S;
    (1.0 - 1.0 / yields).clamp(0.5, 0.99)
}

/// Inverse mass at a roller's centre, the mean over directions and rollers: of the robot as one
/// body, on whose wheels nothing acts.
fn mean_inverse_mass_per_kg(parts: &[Part]) -> f64 {
    let in_body = |part: &Part| part.mass.moved(&part.body_from_part);
    let bodies: Vec<MassProperties> = parts.iter().map(in_body).collect();
    let inverse = MassProperties::merged(&bodies).and_then(|whole| {
        let turning = whole.inertia_kg_m2.try_inverse()?;
        Some((whole, turning))
    });
    let Some((whole, turning)) = inverse else {
        return 0.0;
    };
    let on_axle = |part: &Part| {
        let carrier = part.parent?;
        matches!(part.joint.as_ref()?.role, Role::Roller).then_some(carrier)
    };
    let spun = |wheel: usize| {
        let wheel_from_body = parts[wheel].body_from_part.inverse();
        let turns = parts.iter().enumerate();
        let turns = turns.filter(|(at, part)| *at == wheel || on_axle(part) == Some(wheel));
        let about_axle = |(at, _): (usize, &Part)| {
            bodies[at]
                .moved(&wheel_from_body)
                .inertia_about(&Vector3::zeros())
                .m33
        };
        let armature = parts[wheel]
            .joint
            .as_ref()
            .map_or(0.0, |joint| joint.armature);
        armature + turns.map(about_axle).sum::<f64>()
    };
    let of_roller = |part: &Part| {
        let wheel = on_axle(part)?;
        let lever =
            (part.body_from_part.translation.vector - whole.center_of_mass_m).cross_matrix();
        let ring_m = part.parent_from_part(parts).translation.vector.xy().norm();
        let turned = (lever.transpose() * turning * lever).trace();
        Some((3.0 / whole.mass_kg + turned + ring_m * ring_m / spun(wheel)) / 3.0)
    };
    let each: Vec<f64> = parts.iter().filter_map(of_roller).collect();
    each.iter().sum::<f64>() / each.len() as f64
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
    let (settles_s, impedance) = match robot.has_tyres() {
        true => (TYRE_SETTLES_S, TYRE_IMPEDANCE),
        false => (SETTLES_S, impedance(robot, parts)),
    };
    let mut hulls = String::new();
    let mut bodies = String::new();
    body(&mut bodies, &mut hulls, parts, 0, fitted.ride_height_m);
    let mut out = about_comment(about);
    let _ = writeln!(
        out,
        "<mujoco model=\"{}\">\n  <compiler angle=\"radian\" balanceinertia=\"true\"/>\n  \
         <option timestep=\"{}\" integrator=\"implicitfast\" cone=\"elliptic\" impratio=\"{IMPRATIO}\" gravity=\"0 0 {}\"/>\n  \
         <size memory=\"64M\"/>\n  <default>\n    <default class=\"roller\">\n      \
         <geom contype=\"1\" conaffinity=\"0\" condim=\"3\" priority=\"1\" friction=\"{} 0.005 0.0001\" solref=\"{} 1\" solimp=\"{impedance:.4} {impedance:.4} 0.001 0.5 2\" rgba=\"0.15 0.15 0.15 1\"/>\n    \
         </default>\n    <default class=\"body\">\n      <geom contype=\"1\" conaffinity=\"0\" friction=\"{} 0.005 0.0001\" rgba=\"0.35 0.4 0.45 1\"/>\n    \
         </default>\n  </default>",
        attribute(&robot.name),
        num(STEP_S),
        num(-ground.gravity_m_s2),
        num(ground.friction),
        num(settles_s),
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
