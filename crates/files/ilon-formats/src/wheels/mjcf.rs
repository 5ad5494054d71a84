//! A robot as MJCF.

use std::fmt::Write;

use nalgebra::{Isometry3, Point3, Vector3};

use super::fit::FittedRobot;
use super::frame::{Ground, STEP_S, about_comment, filled};
use super::parts::{Part, PartJoint, Role, Shape};

use crate::generate::elements::{attribute, num, nums};
use crate::model::{
    CollisionShape, Coupling, JointKind, JointRole, MassProperties, Robot, Roller, Wheel,
};

/// Time constant of contacts of rollers: two steps, the shortest that MuJoCo takes.
const SETTLES_S: f64 = 2.0 * STEP_S;
/// Settings of tyres' contacts, which slide in turns. Where MuJoCo's contacts slide at v they push
/// apart by friction times the damping of friction times v, as an acceleration: what slides faster
/// carries more, and beyond (1 - d) / d of gravity it hops. So friction is damped little, which
/// needs a pair of geoms, and impratio makes up for that; less, and a wheel that spins at a hard
/// start slides for longer. In MuJoCo's form d^2 k and d b, of k = 4e5 /s^2, b = 833 /s, and 70 /s
/// of friction.
const TYRE: (&str, f64, &str) = ("-36000 -250", 0.3, "1000");
const TYRE_FRICTION: &str = "0 -21";
/// How deep a roller sinks, over the wheel's radius: as far as native shapes raise and lower hubs.
/// Where contacts are much harder, wheels leave the ground at each hand-over.
const SAG: f64 = 4e-4;

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
    let yields = stiffness_n_m * mean_inverse_mass_per_kg(robot, parts) * SETTLES_S * SETTLES_S;
    (1.0 - 1.0 / yields).clamp(0.5, 0.99)
}

/// Inverse mass at a roller's centre, the mean over directions and rollers: of the robot as one
/// body, on whose wheels nothing acts.
fn mean_inverse_mass_per_kg(robot: &Robot, parts: &[Part]) -> f64 {
    let in_body = |part: &Part| part.mass.moved(&part.body_from_part);
    let bodies: Vec<MassProperties> = parts.iter().map(in_body).collect();
    let Some(whole) = MassProperties::merged(&bodies) else {
        return 0.0;
    };
    let Some(turning) = whole.inertia_kg_m2.try_inverse() else {
        return 0.0;
    };
    let on_axle = |of: &MassProperties| of.inertia_about(&Vector3::zeros()).m33;
    let of_roller = |(wheel, roller): (&Wheel, &Roller)| {
        let rollers = wheel.rollers.iter();
        let rollers: f64 = rollers.map(|roller| on_axle(&roller.mass_in_hub())).sum();
        let spun = wheel.drive.reflected_inertia_kg_m2() + on_axle(&wheel.hub) + rollers;
        let middle_m = roller.center_in_hub_m;
        let place_m = (wheel.body_from_hub * Point3::from(middle_m)).coords;
        let lever = (place_m - whole.center_of_mass_m).cross_matrix();
        let turned = (lever.transpose() * turning * lever).trace();
        (3.0 / whole.mass_kg + turned + middle_m.xy().norm_squared() / spun) / 3.0
    };
    let all = robot.wheels.iter();
    let all = all.flat_map(|wheel| wheel.rollers.iter().map(move |roller| (wheel, roller)));
    let each: Vec<f64> = all.map(of_roller).collect();
    each.iter().sum::<f64>() / each.len() as f64
}

/// The model.
pub(super) fn write(fitted: &FittedRobot, parts: &[Part], ground: &Ground, about: &str) -> String {
    let robot = &fitted.robot;
    let friction = num(ground.friction);
    let (solref, impedance, impratio) = match robot.has_tyres() {
        true => TYRE,
        false => (
            &*format!("{} 1", num(SETTLES_S)),
            impedance(robot, parts),
            "10",
        ),
    };
    let settings =
        format!("solref=\"{solref}\" solimp=\"{impedance:.4} {impedance:.4} 0.001 0.5 2\"");
    let pair = match robot.has_tyres() {
        true => format!(
            "      <pair condim=\"3\" friction=\"{friction} {friction} 0.005 0.0001 0.0001\" {settings} solreffriction=\"{TYRE_FRICTION}\"/>\n"
        ),
        false => String::new(),
    };
    let (mut hulls, mut bodies) = (String::new(), String::new());
    body(&mut bodies, &mut hulls, parts, 0, fitted.ride_height_m);
    let joints = parts.iter().filter_map(|part| part.joint.as_ref());
    let sensors = robot.wheels.iter().map(|wheel| {
        let name = attribute(&wheel.name);
        format!(
            "    <jointpos name=\"{name}_angle\" joint=\"{name}\"/>\n    <jointvel name=\"{name}_rate\" joint=\"{name}\"/>\n"
        )
    });
    let values = [
        ("name", &attribute(&robot.name)[..]),
        ("step", &num(STEP_S)),
        ("gravity", &num(ground.gravity_m_s2)),
        ("friction", &friction),
        ("impratio", impratio),
        ("settings", &settings),
        ("pair", &pair),
        ("hulls", &hulls),
        ("bodies", &bodies),
        ("couplings", &couplings(robot)),
        ("actuators", &joints.map(actuator).collect::<String>()),
        ("sensors", &sensors.collect::<String>()),
    ];
    about_comment(about) + &filled(include_str!("model.xml"), &values)
}

/// A level floor to start on, around the model in a file of this name.
pub(super) fn scene(file: &str, parts: &[Part], ground: &Ground) -> String {
    let (file, friction) = (attribute(file), num(ground.friction));
    let pair = |(place, part): (usize, &Part)| {
        let name = tyre_name(part, place)?;
        Some(format!(
            "    <pair class=\"roller\" geom1=\"{name}\" geom2=\"floor\"/>\n"
        ))
    };
    let tyres = parts
        .iter()
        .flat_map(|part| (0..part.shapes.len()).map(move |at| (at, part)));
    let pairs: String = tyres.filter_map(pair).collect();
    let pairs = match pairs.is_empty() {
        true => pairs,
        false => format!("  <contact>\n{pairs}  </contact>\n"),
    };
    let values = [
        ("file", &file[..]),
        ("friction", &friction),
        ("pairs", &pairs),
    ];
    filled(include_str!("scene.xml"), &values)
}

/// The name of a shape of a tyre, by which a scene pairs it with its floor.
fn tyre_name(part: &Part, place: usize) -> Option<String> {
    let joint = part.joint.as_ref()?;
    let is_wheel = matches!(joint.role, Role::Wheel { .. });
    is_wheel.then(|| format!("{}_tyre_{place}", attribute(joint.name)))
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
    let [kg, at] = [
        num(mass.mass_kg.max(1e-6)),
        nums(mass.center_of_mass_m.as_slice()),
    ];
    let [xx, yy, zz] = [i.m11, i.m22, i.m33].map(|moment| moment.max(1e-9));
    let moments = nums(&[xx, yy, zz, i.m12, i.m13, i.m23]);
    let _ = writeln!(
        out,
        "      <inertial pos=\"{at}\" mass=\"{kg}\" fullinertia=\"{moments}\"/>"
    );
    for (number, (at, shape)) in part.shapes.iter().enumerate() {
        let shape = match shape {
            Shape::Ellipsoid([a, c]) => {
                format!("type=\"ellipsoid\" size=\"{}\"", nums(&[*a, *a, *c]))
            }
            Shape::Solid(solid) => geom(&solid.shape, hulls) + &friction(solid.friction),
        };
        let mut at = *at;
        if class == "body" && shape.contains("cylinder") {
            // MuJoCo finds a cylinder deep in a plane to which its axis is normal but for rounding.
            at.rotation *= nalgebra::UnitQuaternion::from_euler_angles(1e-4, 0.0, 0.0);
        }
        let name = tyre_name(part, number).map(|name| format!("name=\"{name}\" "));
        let _ = writeln!(
            out,
            "      <geom {}class=\"{class}\" {shape} {}/>",
            name.unwrap_or_default(),
            place(&at)
        );
    }
    if let Some(size) = part.hub_m {
        let _ = writeln!(
            out,
            "      <geom type=\"cylinder\" size=\"{}\" contype=\"0\" conaffinity=\"0\" group=\"1\" mass=\"0\" rgba=\"0.75 0.75 0.78 1\"/>",
            nums(&size)
        );
    }
    for child in (0..parts.len()).filter(|at| parts[*at].parent == Some(index)) {
        body(out, hulls, parts, child, height_m);
    }
    let _ = writeln!(out, "    </body>");
}

/// The friction of a shape that has its own, such as of a ball: without priority the floor's, if
/// greater, would hold.
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
    if let Some([rest, stiffness]) = joint.spring().map(|of| of.map(num)) {
        let _ = write!(out, " stiffness=\"{stiffness}\" springref=\"{rest}\"");
    }
    let _ = writeln!(out, "/>");
}

fn actuator(joint: &PartJoint) -> String {
    let name = attribute(joint.name);
    let both = |word: &str, most: f64| match most.is_finite() {
        true => format!(" {word}=\"{}\"", nums(&[-most, most])),
        false => String::new(),
    };
    let (kind, gains) = match &joint.role {
        // Nothing drives a wheel that only rolls along.
        Role::Wheel { effort, rate, gain } if *effort != 0.0 => {
            let limits = both("ctrlrange", *rate) + &both("forcerange", *effort);
            ("velocity", format!("kv=\"{}\"{limits}", num(*gain)))
        }
        Role::Body(JointRole::Driven(servo)) => {
            let [kp, kv] = [servo.stiffness, servo.damping].map(num);
            let limit = both("forcerange", servo.effort);
            ("position", format!("kp=\"{kp}\" kv=\"{kv}\"{limit}"))
        }
        _ => return String::new(),
    };
    format!("    <{kind} name=\"{name}\" joint=\"{name}\" {gains}/>\n")
}

fn couplings(robot: &Robot) -> String {
    let coupling = |by: &Coupling| {
        let [joint, follows] = [by.joint, by.follows].map(|at| attribute(&robot.joints[at].name));
        let factors = nums(&[by.offset, by.factor]);
        format!(
            "    <joint joint1=\"{joint}\" joint2=\"{follows}\" polycoef=\"{factors} 0 0 0\"/>\n"
        )
    };
    let all: String = robot.couplings.iter().map(coupling).collect();
    match all.is_empty() {
        true => all,
        false => format!("  <equality>\n{all}  </equality>\n"),
    }
}
