//! A robot as SDF and as URDF, which share most of their elements.

use std::fmt::Write;

use ilon_robot::roll_pitch_yaw;
use nalgebra::Isometry3;

use super::fit::FittedRobot;
use super::frame::{Ground, about_comment};
use super::parts::{Part, PartJoint, Role, Shape};

use crate::generate::elements::{attribute, num, nums};
use crate::model::{CollisionShape, Coupling, JointKind, JointRole, MassProperties, Robot};

/// The step of SDF's world, in seconds.
const SDF_STEP_S: f64 = 0.001;

fn six(pose: &Isometry3<f64>) -> ([f64; 3], [f64; 3]) {
    let turned = roll_pitch_yaw(&pose.rotation.to_rotation_matrix());
    (pose.translation.vector.into(), turned)
}

/// The model in SDF, alone or on a level floor.
pub(super) fn sdf(
    fitted: &FittedRobot,
    parts: &[Part],
    meshes: &[String],
    ground: &Ground,
    about: &str,
    is_world: bool,
) -> String {
    let robot = &fitted.robot;
    let mut out = format!(
        "<?xml version=\"1.0\"?>\n{}<sdf version=\"1.11\">\n",
        about_comment(about)
    );
    let surface = |friction: f64| {
        format!(
            "<surface><friction><ode><mu>{0}</mu><mu2>{0}</mu2></ode></friction></surface>",
            num(friction)
        )
    };
    let friction = surface(ground.friction);
    if is_world {
        let _ = writeln!(
            out,
            "<world name=\"level\">\n<physics name=\"step\" type=\"ignored\"><max_step_size>{}</max_step_size><real_time_factor>1</real_time_factor><real_time_update_rate>{}</real_time_update_rate></physics>\n\
             <plugin filename=\"gz-sim-physics-system\" name=\"gz::sim::systems::Physics\"/>\n\
             <plugin filename=\"gz-sim-user-commands-system\" name=\"gz::sim::systems::UserCommands\"/>\n\
             <plugin filename=\"gz-sim-scene-broadcaster-system\" name=\"gz::sim::systems::SceneBroadcaster\"/>\n\
             <gravity>0 0 {}</gravity><magnetic_field>5.5645e-6 22.8758e-6 -42.3884e-6</magnetic_field><atmosphere type=\"adiabatic\"/>\n\
             <scene><ambient>0.4 0.4 0.4 1</ambient><background>0.7 0.7 0.7 1</background><shadows>true</shadows></scene>\n<light name=\"sun\" type=\"directional\"><pose>0 0 10 0 0 0</pose><direction>-0.3 0.2 -0.9</direction></light>\n\
             <model name=\"floor\"><static>true</static><link name=\"floor\"><collision name=\"floor\"><geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>{friction}</collision>\
             <visual name=\"floor\"><geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry></visual></link></model>",
            num(SDF_STEP_S),
            num(1.0 / SDF_STEP_S),
            num(-ground.gravity_m_s2)
        );
    }
    let _ = writeln!(
        out,
        "<model name=\"{}\">\n<pose>0 0 {} 0 0 0</pose>\n<self_collide>false</self_collide>",
        attribute(&robot.name),
        num(fitted.ride_height_m)
    );
    let pose = |pose: &Isometry3<f64>| {
        let (at, turned) = six(pose);
        format!("<pose>{} {}</pose>", nums(&at), nums(&turned))
    };
    for part in parts {
        let mass = &part.mass;
        let _ = writeln!(
            out,
            "<link name=\"{}\">{}\n<inertial><pose>{} 0 0 0</pose><mass>{}</mass><inertia>{}</inertia></inertial>",
            attribute(&part.name),
            pose(&part.body_from_part),
            nums(mass.center_of_mass_m.as_slice()),
            num(mass.mass_kg.max(1e-6)),
            moments(mass)
                .map(|(name, value)| format!("<{name}>{value}</{name}>"))
                .concat()
        );
        for (number, (at, shape)) in part.shapes.iter().enumerate() {
            let (at, geometry) = sdf_geometry(at, shape, meshes);
            let own = match shape {
                Shape::Solid(solid) => solid.friction,
                _ => None,
            };
            let friction = own.map_or_else(|| friction.clone(), surface);
            let _ = writeln!(
                out,
                "<collision name=\"collision_{number}\">{0}<geometry>{geometry}</geometry>{friction}</collision><visual name=\"visual_{number}\">{0}<geometry>{geometry}</geometry></visual>",
                pose(&at)
            );
        }
        let _ = writeln!(out, "</link>");
    }
    let mut plugins = String::new();
    for part in parts {
        let (Some(joint), Some(parent)) = (&part.joint, part.parent) else {
            continue;
        };
        let turns = joint.kind == JointKind::Turns;
        let kind = if turns { "revolute" } else { "prismatic" };
        let (effort, rate) = limits(joint);
        let [rest, stiffness] = match joint.role {
            Role::Body(JointRole::Sprung(spring)) => [
                spring.rest + spring.preload / spring.stiffness,
                spring.stiffness,
            ],
            _ => [0.0; 2],
        };
        let dynamics = format!(
            "<dynamics><damping>{}</damping><friction>{}</friction><spring_reference>{}</spring_reference><spring_stiffness>{}</spring_stiffness></dynamics>",
            num(joint.bearing.damping_n_m_s),
            num(joint.bearing.friction_n_m),
            num(rest),
            num(stiffness)
        );
        // SDF's own words for no limit.
        let [lower, upper] = joint.limits.map(|x| x.clamp(-1e16, 1e16));
        let said = |tag: &str, x: Option<f64>| {
            x.map_or(String::new(), |x| format!("<{tag}>{}</{tag}>", num(x)))
        };
        let _ = writeln!(
            out,
            "<joint name=\"{}\" type=\"{kind}\"><parent>{}</parent><child>{}</child><axis><xyz>0 0 1</xyz><limit><lower>{lower:e}</lower><upper>{upper:e}</upper>{}{}</limit>{dynamics}{}</axis></joint>",
            attribute(joint.name),
            attribute(&parts[parent].name),
            attribute(&part.name),
            said("effort", effort),
            said("velocity", rate),
            follows(robot, joint).map_or(String::new(), |(name, by)| format!(
                "<mimic joint=\"{name}\"><multiplier>{}</multiplier><offset>{}</offset><reference>0</reference></mimic>",
                num(by.factor),
                num(by.offset)
            ))
        );
        if let Role::Body(JointRole::Driven(servo)) = joint.role {
            let most = servo.effort.min(1e16);
            let _ = writeln!(
                plugins,
                "<plugin filename=\"gz-sim-joint-position-controller-system\" name=\"gz::sim::systems::JointPositionController\"><joint_name>{}</joint_name>\
                 <p_gain>{}</p_gain><i_gain>0</i_gain><d_gain>{}</d_gain><cmd_max>{most:e}</cmd_max><cmd_min>-{most:e}</cmd_min></plugin>",
                attribute(joint.name),
                num(servo.stiffness),
                num(servo.damping)
            );
        }
    }
    for wheel in robot.wheels.iter().filter(|of| of.motor.effort_n_m > 0.0) {
        let _ = writeln!(
            out,
            "<plugin filename=\"gz-sim-joint-controller-system\" name=\"gz::sim::systems::JointController\"><joint_name>{}</joint_name></plugin>",
            attribute(&wheel.name)
        );
    }
    out += &plugins;
    out += "</model>\n";
    out + if is_world {
        "</world>\n</sdf>\n"
    } else {
        "</sdf>\n"
    }
}

fn sdf_geometry(at: &Isometry3<f64>, shape: &Shape, meshes: &[String]) -> (Isometry3<f64>, String) {
    let text = match shape {
        Shape::Ellipsoid([a, c]) => format!(
            "<ellipsoid><radii>{}</radii></ellipsoid>",
            nums(&[*a, *a, *c])
        ),
        Shape::Mesh(mesh) => format!("<mesh><uri>{}</uri></mesh>", attribute(&meshes[*mesh])),
        Shape::Solid(solid) => match &solid.shape {
            CollisionShape::Cylinder { radius_m, length_m } => format!(
                "<cylinder><radius>{}</radius><length>{}</length></cylinder>",
                num(*radius_m),
                num(*length_m)
            ),
            CollisionShape::Capsule { radius_m, length_m } => format!(
                "<capsule><radius>{}</radius><length>{}</length></capsule>",
                num(*radius_m),
                num(*length_m)
            ),
            CollisionShape::Sphere { radius_m } => {
                format!("<sphere><radius>{}</radius></sphere>", num(*radius_m))
            }
            CollisionShape::Box { .. } | CollisionShape::ConvexHull { .. } => {
                let (at, size) = boxed(at, &solid.shape);
                return (at, format!("<box><size>{}</size></box>", nums(&size)));
            }
        },
    };
    (*at, text)
}

/// The box around a solid, in the axes of its frame, and its sides in metres.
fn boxed(at: &Isometry3<f64>, solid: &CollisionShape) -> (Isometry3<f64>, [f64; 3]) {
    let collision = crate::model::Collision {
        friction: None,
        body_from_shape: Isometry3::identity(),
        shape: solid.clone(),
    };
    let reach = |axis: usize, sign: f64| collision.reach_m(&(nalgebra::Vector3::ith(axis, sign)));
    let middle = [0, 1, 2].map(|axis| 0.5 * (reach(axis, 1.0) - reach(axis, -1.0)));
    let size = [0, 1, 2].map(|axis| reach(axis, 1.0) + reach(axis, -1.0));
    let [x, y, z] = middle;
    (at * Isometry3::translation(x, y, z), size)
}

/// The joint that another follows, by its name, and how.
fn follows<'a>(robot: &'a Robot, joint: &PartJoint) -> Option<(String, &'a Coupling)> {
    let is_it = |at: usize| robot.joints[at].name == joint.name;
    let by = robot.couplings.iter().find(|by| is_it(by.joint))?;
    Some((attribute(&robot.joints[by.follows].name), by))
}

/// Largest effort and rate of a joint's drive, of one that has them.
fn limits(joint: &PartJoint) -> (Option<f64>, Option<f64>) {
    let finite = |x: f64| x.is_finite().then_some(x);
    match &joint.role {
        Role::Wheel { effort, rate, .. } => (finite(*effort), finite(*rate)),
        Role::Body(JointRole::Driven(servo)) => (finite(servo.effort), finite(servo.rate_limit)),
        Role::Roller | Role::Body(_) => (None, None),
    }
}

/// The moments and products of inertia, in kg m^2, under the names that both formats have.
fn moments(mass: &MassProperties) -> [(&'static str, String); 6] {
    let i = &mass.inertia_kg_m2;
    [
        ("ixx", i.m11),
        ("ixy", i.m12),
        ("ixz", i.m13),
        ("iyy", i.m22),
        ("iyz", i.m23),
        ("izz", i.m33),
    ]
    .map(|(name, value)| (name, num(value)))
}

/// The model in URDF.
pub(super) fn urdf(robot: &Robot, parts: &[Part], meshes: &[String], about: &str) -> String {
    let mut out = format!(
        "<?xml version=\"1.0\"?>\n{}<robot name=\"{}\">\n",
        about_comment(about),
        attribute(&robot.name)
    );
    let origin = |pose: &Isometry3<f64>| {
        let (at, turned) = six(pose);
        format!("<origin xyz=\"{}\" rpy=\"{}\"/>", nums(&at), nums(&turned))
    };
    for part in parts {
        let mass = &part.mass;
        let _ = writeln!(
            out,
            "  <link name=\"{}\">\n    <inertial><origin xyz=\"{}\"/><mass value=\"{}\"/><inertia{}/></inertial>",
            attribute(&part.name),
            nums(mass.center_of_mass_m.as_slice()),
            num(mass.mass_kg),
            moments(mass)
                .map(|(name, value)| format!(" {name}=\"{value}\""))
                .concat()
        );
        for (at, shape) in &part.shapes {
            for (at, geometry) in urdf_geometries(at, shape, meshes) {
                let at = origin(&at);
                for tag in ["visual", "collision"] {
                    let _ = writeln!(
                        out,
                        "    <{tag}>{at}<geometry>{geometry}</geometry></{tag}>"
                    );
                }
            }
        }
        let _ = writeln!(out, "  </link>");
    }
    for part in parts {
        let (Some(joint), Some(parent)) = (&part.joint, part.parent) else {
            continue;
        };
        let is_limited = joint.limits.iter().all(|x| x.is_finite());
        let kind = match (joint.kind, is_limited) {
            (JointKind::Slides, _) => "prismatic",
            (JointKind::Turns, true) => "revolute",
            (JointKind::Turns, false) => "continuous",
        };
        let mut limit = String::new();
        if kind != "continuous" {
            let [lower, upper] = joint.limits.map(|x| x.clamp(-1e3, 1e3));
            let _ = write!(limit, " lower=\"{}\" upper=\"{}\"", num(lower), num(upper));
        }
        // A roller has no drive: tools that put a motor into each joint give it no torque.
        let (effort, rate) = match joint.role {
            Role::Roller => (0.0, 1000.0),
            _ => {
                let (effort, rate) = limits(joint);
                (effort.unwrap_or(1e6), rate.unwrap_or(1e6))
            }
        };
        let _ = writeln!(
            out,
            "  <joint name=\"{}\" type=\"{kind}\">\n    <parent link=\"{}\"/>\n    <child link=\"{}\"/>\n    {}\n    <axis xyz=\"0 0 1\"/>\n    \
             <limit effort=\"{}\" velocity=\"{}\"{limit}/>\n    <dynamics damping=\"{}\" friction=\"{}\"/>\n{}  </joint>",
            attribute(joint.name),
            attribute(&parts[parent].name),
            attribute(&part.name),
            origin(&part.parent_from_part(parts)),
            num(effort),
            num(rate),
            num(joint.bearing.damping_n_m_s),
            num(joint.bearing.friction_n_m),
            follows(robot, joint).map_or(String::new(), |(name, by)| format!(
                "    <mimic joint=\"{name}\" multiplier=\"{}\" offset=\"{}\"/>\n",
                num(by.factor),
                num(by.offset)
            ))
        );
    }
    out += &super::tyres::element(robot);
    out + "</robot>\n"
}

fn urdf_geometries(
    at: &Isometry3<f64>,
    shape: &Shape,
    meshes: &[String],
) -> Vec<(Isometry3<f64>, String)> {
    let cylinder = |radius_m: f64, length_m: f64| {
        format!(
            "<cylinder radius=\"{}\" length=\"{}\"/>",
            num(radius_m),
            num(length_m)
        )
    };
    let sphere = |radius_m: f64| format!("<sphere radius=\"{}\"/>", num(radius_m));
    let solid = match shape {
        Shape::Mesh(mesh) => {
            return vec![(
                *at,
                format!("<mesh filename=\"{}\"/>", attribute(&meshes[*mesh])),
            )];
        }
        // Never asked of URDF, which has none.
        Shape::Ellipsoid([a, _]) => return vec![(*at, sphere(*a))],
        Shape::Solid(solid) => &solid.shape,
    };
    match solid {
        CollisionShape::Cylinder { radius_m, length_m } => {
            vec![(*at, cylinder(*radius_m, *length_m))]
        }
        CollisionShape::Sphere { radius_m } => vec![(*at, sphere(*radius_m))],
        CollisionShape::Capsule { radius_m, length_m } => {
            let end = |z: f64| (at * Isometry3::translation(0.0, 0.0, z), sphere(*radius_m));
            let (up, down) = (end(0.5 * length_m), end(-0.5 * length_m));
            vec![(*at, cylinder(*radius_m, *length_m)), up, down]
        }
        CollisionShape::Box { .. } | CollisionShape::ConvexHull { .. } => {
            let (at, size) = boxed(at, solid);
            vec![(at, format!("<box size=\"{}\"/>", nums(&size)))]
        }
    }
}
