//! A robot in SDF or MJCF is the same as in URDF: it is written in all three formats, each with its
//! own way of placing elements, and read back. The file is as long as three formats need.

use crate::common;

use std::fmt::Write;

use common::{SPEC, small};
use ilon_formats::{Fault, LoadOptions, LoadRobot, RobotError, Spec, generate};
use ilon_robot::{MassProperties, Robot, Wheel};
use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};
use test_case::test_case;

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|n| n.has_tag_name(tag))
}

fn text<'a>(node: Node<'a, '_>, tag: &str, attribute: &str) -> &'a str {
    child(node, tag)
        .and_then(|n| n.attribute(attribute))
        .unwrap_or_default()
}

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace()
        .map(|x| x.parse().unwrap())
        .collect()
}

/// The pose of a URDF's `<origin>`.
fn origin(node: Node) -> Isometry3<f64> {
    let read = |attribute| {
        let values = numbers(text(node, "origin", attribute));
        Vector3::from_iterator(values.into_iter().chain([0.0; 3]))
    };
    let (xyz, rpy) = (read("xyz"), read("rpy"));
    Isometry3::from_parts(
        Translation3::from(xyz),
        UnitQuaternion::from_euler_angles(rpy.x, rpy.y, rpy.z),
    )
}

/// Joints and links of a URDF, with the data that each format needs.
struct Parts<'a, 'i> {
    links: Vec<Node<'a, 'i>>,
    joints: Vec<Node<'a, 'i>>,
}

impl<'a, 'i> Parts<'a, 'i> {
    fn of(document: &'a Document<'i>) -> Self {
        let all = |tag: &'static str| {
            let children = document.root_element().children();
            children.filter(|n| n.has_tag_name(tag)).collect()
        };
        Self {
            links: all("link"),
            joints: all("joint"),
        }
    }

    /// The joint above a link.
    fn above(&self, link: &str) -> Option<Node<'a, 'i>> {
        let mut joints = self.joints.iter().copied();
        joints.find(|joint| text(*joint, "child", "link") == link)
    }

    fn body_from_link(&self, link: &str) -> Isometry3<f64> {
        match self.above(link) {
            Some(joint) => self.body_from_link(text(joint, "parent", "link")) * origin(joint),
            None => Isometry3::identity(),
        }
    }
}

// --- SDF.

/// Yaw is computed first and removed, so that no accuracy is lost when the frame is vertical.
fn roll_pitch_yaw(pose: &Isometry3<f64>) -> [f64; 3] {
    let m = pose.rotation.to_rotation_matrix().into_inner();
    let yaw = m[(1, 0)].atan2(m[(0, 0)]);
    let (s, c) = yaw.sin_cos();
    let pitch = (-m[(2, 0)]).atan2(c * m[(0, 0)] + s * m[(1, 0)]);
    let roll = (s * m[(0, 2)] - c * m[(1, 2)]).atan2(c * m[(1, 1)] - s * m[(0, 1)]);
    [roll, pitch, yaw]
}

fn sdf_pose(pose: &Isometry3<f64>) -> String {
    let p = pose.translation.vector;
    let [roll, pitch, yaw] = roll_pitch_yaw(pose);
    format!("<pose>{} {} {} {roll} {pitch} {yaw}</pose>", p.x, p.y, p.z)
}

/// The inertial and the collisions of a link. Their poses are relative to the link in both formats.
fn sdf_link(link: Node) -> String {
    let mut out = String::new();
    if let Some(inertial) = child(link, "inertial") {
        write!(out, "<inertial>{}", sdf_pose(&origin(inertial))).unwrap();
        write!(
            out,
            "<mass>{}</mass><inertia>",
            text(inertial, "mass", "value")
        )
        .unwrap();
        for name in ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"] {
            write!(out, "<{name}>{}</{name}>", text(inertial, "inertia", name)).unwrap();
        }
        out += "</inertia></inertial>";
    }
    let collisions = link.children().filter(|n| n.has_tag_name("collision"));
    for (i, collision) in collisions.enumerate() {
        let pose = sdf_pose(&origin(collision));
        let shape = child(collision, "geometry")
            .unwrap()
            .first_element_child()
            .unwrap();
        let tag = shape.tag_name().name();
        let sizes: String = shape
            .attributes()
            .map(|a| format!("<{0}>{1}</{0}>", a.name(), a.value()))
            .collect();
        write!(
            out,
            "<collision name=\"c{i}\">{pose}<geometry><{tag}>{sizes}</{tag}></geometry></collision>"
        )
        .unwrap();
    }
    out
}

/// How an SDF places links and defines axes.
#[derive(Clone, Copy, PartialEq)]
enum Style {
    /// Links in the model's frame, axes in the joint's.
    Modern,
    /// Links relative to the links above them, axes expressed in the model's frame by name.
    Relative,
    /// As before SDF 1.5: axes in the model's frame by default.
    Old,
}

fn sdf(urdf: &str, style: Style) -> String {
    let document = Document::parse(urdf).unwrap();
    let parts = Parts::of(&document);
    let version = if style == Style::Old { "1.4" } else { "1.9" };
    let mut out = format!(
        "<?xml version=\"1.0\"?>\n<sdf version=\"{version}\"><world name=\"w\">\n<model name=\"ground\"><link name=\"l\"/></model>\n<model name=\"small\">\n"
    );
    for link in &parts.links {
        let name = link.attribute("name").unwrap();
        let above = parts.above(name);
        let pose = match above.filter(|_| style == Style::Relative) {
            Some(joint) => {
                let parent = text(joint, "parent", "link");
                sdf_pose(&origin(joint))
                    .replace("<pose>", &format!("<pose relative_to=\"{parent}\">"))
            }
            None => sdf_pose(&parts.body_from_link(name)),
        };
        writeln!(
            out,
            "<link name=\"{name}\">{pose}{}</link>",
            sdf_link(*link)
        )
        .unwrap();
    }
    for joint in &parts.joints {
        let link = text(*joint, "child", "link");
        let axis = Vector3::from_iterator(numbers(text(*joint, "axis", "xyz")));
        let in_model = parts.body_from_link(link) * axis;
        let (axis, frame) = match style {
            Style::Modern => (axis, ""),
            Style::Relative => (in_model, " expressed_in=\"__model__\""),
            Style::Old => (in_model, ""),
        };
        writeln!(
            out,
            "<joint name=\"{}\" type=\"revolute\"><parent>{}</parent><child>{link}</child><axis><xyz{frame}>{} {} {}</xyz>{}\
             <dynamics><damping>{}</damping><friction>{}</friction></dynamics></axis></joint>",
            joint.attribute("name").unwrap(),
            text(*joint, "parent", "link"),
            axis.x,
            axis.y,
            axis.z,
            match child(*joint, "limit") {
                Some(limit) => format!(
                    "<limit><lower>-1e16</lower><upper>1e16</upper><effort>{}</effort><velocity>{}</velocity></limit>",
                    limit.attribute("effort").unwrap(),
                    limit.attribute("velocity").unwrap()
                ),
                None => String::new(),
            },
            zero_or(text(*joint, "dynamics", "damping")),
            zero_or(text(*joint, "dynamics", "friction")),
        )
        .unwrap();
    }
    out + "</model></world></sdf>\n"
}

fn zero_or(text: &str) -> &str {
    if text.is_empty() { "0" } else { text }
}

// --- MJCF.

fn mjcf_pose(pose: &Isometry3<f64>) -> String {
    let (p, q) = (pose.translation.vector, pose.rotation);
    format!(
        "pos=\"{} {} {}\" quat=\"{} {} {} {}\"",
        p.x, p.y, p.z, q.w, q.i, q.j, q.k
    )
}

/// A body with everything below it.
fn mjcf_body(parts: &Parts, link: Node, out: &mut String) {
    let name = link.attribute("name").unwrap();
    let above = parts.above(name);
    let pose = above.map_or_else(Isometry3::identity, origin);
    writeln!(out, "<body name=\"{name}\" {}>", mjcf_pose(&pose)).unwrap();
    match above {
        None => out.push_str("<freejoint/>\n"),
        Some(joint) => writeln!(
            out,
            "<joint name=\"{}\" type=\"hinge\" axis=\"{}\" damping=\"{}\" frictionloss=\"{}\"/>",
            joint.attribute("name").unwrap(),
            text(joint, "axis", "xyz"),
            zero_or(text(joint, "dynamics", "damping")),
            zero_or(text(joint, "dynamics", "friction")),
        )
        .unwrap(),
    }
    if let Some(inertial) = child(link, "inertial") {
        let i = |name| text(inertial, "inertia", name).parse::<f64>().unwrap();
        let own = Matrix3::new(
            i("ixx"),
            i("ixy"),
            i("ixz"),
            i("ixy"),
            i("iyy"),
            i("iyz"),
            i("ixz"),
            i("iyz"),
            i("izz"),
        );
        // `fullinertia` is along the body's axes.
        let pose = origin(inertial);
        let turn = pose.rotation.to_rotation_matrix();
        let m = turn.matrix() * own * turn.matrix().transpose();
        let p = pose.translation.vector;
        let mass = text(inertial, "mass", "value");
        writeln!(
            out,
            "<inertial pos=\"{} {} {}\" mass=\"{mass}\" fullinertia=\"{} {} {} {} {} {}\"/>",
            p.x, p.y, p.z, m.m11, m.m22, m.m33, m.m12, m.m13, m.m23,
        )
        .unwrap();
    }
    for collision in link.children().filter(|n| n.has_tag_name("collision")) {
        let shape = child(collision, "geometry")
            .unwrap()
            .first_element_child()
            .unwrap();
        let of = |name| numbers(shape.attribute(name).unwrap());
        let (kind, size) = match shape.tag_name().name() {
            "sphere" => ("sphere", of("radius")),
            "cylinder" => ("cylinder", vec![of("radius")[0], 0.5 * of("length")[0]]),
            "box" => ("box", of("size").into_iter().map(|x| 0.5 * x).collect()),
            other => panic!("{other}"),
        };
        let size: Vec<String> = size.iter().map(f64::to_string).collect();
        let pose = mjcf_pose(&origin(collision));
        writeln!(
            out,
            "<geom type=\"{kind}\" size=\"{}\" {pose}/>",
            size.join(" ")
        )
        .unwrap();
    }
    for below in &parts.joints {
        if text(*below, "parent", "link") == name {
            let link = text(*below, "child", "link");
            let mut links = parts.links.iter();
            let link = links.find(|n| n.attribute("name") == Some(link)).unwrap();
            mjcf_body(parts, *link, out);
        }
    }
    out.push_str("</body>\n");
}

fn mjcf(urdf: &str) -> String {
    let document = Document::parse(urdf).unwrap();
    let parts = Parts::of(&document);
    let mut out = "<mujoco model=\"small\">\n<compiler angle=\"radian\"/>\n<worldbody>\n<geom type=\"plane\" size=\"1 1 1\"/>\n".to_owned();
    mjcf_body(&parts, parts.links[0], &mut out);
    out += "</worldbody>\n<actuator>\n";
    for joint in &parts.joints {
        if let Some(limit) = child(*joint, "limit") {
            let name = joint.attribute("name").unwrap();
            let effort: f64 = limit.attribute("effort").unwrap().parse().unwrap();
            // A gear of two doubles the motor's torque.
            let range = 0.5 * effort;
            writeln!(
                out,
                "<motor joint=\"{name}\" gear=\"2\" ctrlrange=\"-{range} {range}\"/>"
            )
            .unwrap();
        }
    }
    out + "</actuator>\n</mujoco>\n"
}

// --- Comparison.

/// Written with all digits and converted to angles and back: several rounding errors of numbers of
/// at most a few units.
const TOLERANCE: f64 = 1e-11;

fn same_mass(p: &MassProperties, q: &MassProperties) {
    assert!((p.mass_kg - q.mass_kg).abs() < TOLERANCE);
    assert!((p.center_of_mass_m - q.center_of_mass_m).norm() < TOLERANCE);
    // Moments of small parts are far below one, so the comparison is relative.
    let off = (p.inertia_kg_m2 - q.inertia_kg_m2).norm();
    assert!(off < 1e-10 * q.inertia_kg_m2.norm(), "{off}");
}

fn same_wheel(p: &Wheel, q: &Wheel) {
    assert_eq!(p.name, q.name);
    let off_m = (p.position_m() - q.position_m()).norm();
    assert!(off_m < TOLERANCE, "{}: {off_m}", p.name);
    let off_m = (p.radius_m - q.radius_m).abs();
    assert!(off_m < TOLERANCE, "{}: {off_m}", p.name);
    assert!((p.gamma_rad - q.gamma_rad).abs() < TOLERANCE);
    assert!((p.joint.damping_n_m_s - q.joint.damping_n_m_s).abs() < TOLERANCE);
    assert!((p.joint.friction_n_m - q.joint.friction_n_m).abs() < TOLERANCE);
    assert!((p.motor.effort_n_m - q.motor.effort_n_m).abs() < TOLERANCE);
    same_mass(&p.hub, &q.hub);
    assert_eq!(p.rollers.len(), q.rollers.len());
    for a in &p.rollers {
        let b = q.rollers.iter().find(|b| b.name == a.name).unwrap();
        assert!((a.center_in_hub_m - b.center_in_hub_m).norm() < TOLERANCE);
        assert!((a.axis_in_hub.into_inner() - b.axis_in_hub.into_inner()).norm() < TOLERANCE);
        assert!((a.radius_m - b.radius_m).abs() < TOLERANCE);
        assert!((a.length_m - b.length_m).abs() < TOLERANCE);
        same_mass(&a.mass_in_hub(), &b.mass_in_hub());
    }
}

fn same(p: &Robot, q: &Robot) {
    assert_eq!(p.name, q.name);
    same_mass(&p.chassis.mass, &q.chassis.mass);
    assert_eq!(p.wheels.len(), q.wheels.len());
    for (p, q) in p.wheels.iter().zip(&q.wheels) {
        same_wheel(p, q);
    }
}

/// The small robot with losses everywhere, and a different wheel.
fn described() -> String {
    let text = SPEC
        .replace("[rollers]", "damping_n_m_s = 0.01\nfriction_n_m = 0.02\n[rollers]\ndamping_n_m_s = 1e-5\nfriction_n_m = 1e-4")
        .replace("gamma_deg = 0.0", "gamma_deg = 30.0\nfirst_deg = 17.0")
        + "[overrides.wheel_2]\nphase_deg = 11\n";
    generate(&Spec::from_toml_str(&text, "r.toml").unwrap()).unwrap()
}

fn load(text: &str, file: &str) -> Robot {
    Robot::from_urdf_str(text, file).unwrap_or_else(|e| panic!("{e}"))
}

#[test_case(Style::Modern; "modern")]
#[test_case(Style::Relative; "relative")]
#[test_case(Style::Old; "old")]
fn an_sdf_is_the_robot_of_its_urdf(style: Style) {
    for urdf in [small(), described()] {
        let robot = load(&sdf(&urdf, style), "small.sdf");
        let of_urdf = load(&urdf, "small.urdf");
        same(&robot, &of_urdf);
        let rate = |robot: &Robot| robot.wheels[0].motor.velocity_rad_s;
        assert_eq!(rate(&robot), rate(&of_urdf));
        // Of the two models of the world it is the one with joints.
        assert!(
            robot
                .remarks
                .iter()
                .any(|r| r.text.contains("the robot of 2 models"))
        );
    }
}

#[test]
fn an_mjcf_is_the_robot_of_its_urdf() {
    for urdf in [small(), described()] {
        same(&load(&mjcf(&urdf), "small.xml"), &load(&urdf, "small.urdf"));
    }
}

#[test]
fn what_an_mjcf_says_in_its_own_way_is_read() {
    let plain = mjcf(&small());
    let same_as_plain = |text: &str| same(&load(text, "small.xml"), &load(&plain, "small.xml"));
    // Defaults by class, and attributes at the joint, which override them.
    let damped = plain.replace(" damping=\"0\"", "");
    let with_default = damped.replace(
        "<worldbody>",
        "<default><joint damping=\"0\"/></default><worldbody>",
    );
    same_as_plain(&with_default);
    // Shapes without contact are ignored; masses still come from `<inertial>`.
    let ghost = plain
        .replace("</worldbody>", "")
        .replacen(
            "<freejoint/>",
            "<freejoint/><geom type=\"sphere\" size=\"9\" contype=\"0\" conaffinity=\"0\"/>",
            1,
        )
        .replace("<actuator>", "</worldbody><actuator>");
    same_as_plain(&ghost);
    // Degrees and Euler angles: a zero rotation of the robot's frame.
    let turned = plain
        .replacen("quat=\"1 0 0 0\"", "euler=\"0 0 0\"", 1)
        .replace("angle=\"radian\"", "angle=\"degree\"");
    same_as_plain(&turned);
    // The armature is a rotor without a gear.
    let armed = plain.replace(
        "name=\"wheel_1\" type",
        "armature=\"0.003\" name=\"wheel_1\" type",
    );
    let drive = load(&armed, "small.xml").wheels[0].drive;
    assert_eq!((drive.gear_ratio, drive.rotor_inertia_kg_m2), (1.0, 0.003));
}

#[test]
fn a_part_of_an_mjcf_may_stand_in_another_file() {
    let folder = tempfile::tempdir().unwrap();
    let plain = mjcf(&small());
    let (start, end) = (
        plain.find("<actuator>").unwrap(),
        plain.find("</mujoco>").unwrap(),
    );
    let part = format!("<mujocoinclude>{}</mujocoinclude>", &plain[start..end]);
    std::fs::write(folder.path().join("motors.xml"), part).unwrap();
    let whole = format!("{}<include file=\"motors.xml\"/></mujoco>", &plain[..start]);
    let path = folder.path().join("small.xml");
    std::fs::write(&path, &whole).unwrap();
    same(&Robot::load(&path).unwrap(), &load(&plain, "small.xml"));
    std::fs::write(&path, whole.replace("motors.xml", "small.xml")).unwrap();
    let endless = Robot::load(&path).unwrap_err();
    assert!(
        matches!(endless.fault(), Fault::Format { reason } if reason.contains("files are included")),
        "{endless}"
    );
}

/// SDF gives a link without `<inertial>` 1 kg; its shapes say how it is spread.
#[test]
fn a_link_of_an_sdf_without_inertial_weighs_a_kilogram() {
    let whole = sdf(&small(), Style::Modern);
    let weighs = load(&whole, "small.sdf").mass_kg();
    let (before, link) = whole.split_once("<inertial>").unwrap();
    let (inertial, rest) = link.split_once("</inertial>").unwrap();
    let (_, mass) = inertial.split_once("<mass>").unwrap();
    let (mass, _) = mass.split_once("</mass>").unwrap();
    let bare = format!("{before}{rest}");
    assert!(rest.find("<collision") < rest.find("</link>"));
    let refused = Robot::from_urdf_str(&bare, "small.sdf").unwrap_err();
    assert!(
        refused.to_string().contains("`<inertia>` is missing"),
        "{refused}"
    );
    let mut options = ilon_formats::LoadOptions::default();
    options.repair = true;
    let robot = Robot::from_urdf_str_with(&bare, "small.sdf", &options)
        .unwrap()
        .robot;
    let lost: f64 = mass.trim().parse().unwrap();
    assert!((robot.mass_kg() - (weighs - lost + 1.0)).abs() < 1e-9);
}

/// A part alone points to the whole, and a joint that is locked by its damping is read as locked.
#[test]
fn parts_of_an_mjcf_are_named_and_joints_may_be_locked_by_damping() {
    let plain = mjcf(&small());
    let part = plain
        .replacen("<mujoco", "<mujocoinclude", 1)
        .replace("</mujoco>", "</mujocoinclude>");
    let refused = Robot::from_urdf_str(&part, "part.xml").unwrap_err();
    assert!(
        refused.help().contains("the file that includes it"),
        "{refused}"
    );
    let (before, wheel) = plain.split_once("name=\"wheel_1\" type").unwrap();
    let (own, rest) = wheel.split_once("damping=\"").unwrap();
    let (_, rest) = rest.split_once('"').unwrap();
    let locked = format!("{before}name=\"wheel_1\" type{own}damping=\"1e11\"{rest}");
    let damping_n_m_s = load(&locked, "small.xml").wheels[0].joint.damping_n_m_s;
    assert!(damping_n_m_s >= 1e8, "{damping_n_m_s}");
}

/// Models with each part in its own file have more than fifty files.
#[test]
fn an_mjcf_may_stand_in_many_files() {
    const PARTS: usize = 120;
    let folder = tempfile::tempdir().unwrap();
    let plain = mjcf(&small());
    let end = plain.find("</mujoco>").unwrap();
    let mut whole = plain[..end].to_owned();
    for i in 0..PARTS {
        let name = format!("part{i}.xml");
        let part = format!(
            "<mujocoinclude><custom><text name=\"t{i}\" data=\"part\"/></custom></mujocoinclude>"
        );
        std::fs::write(folder.path().join(&name), part).unwrap();
        whole += &format!("<include file=\"{name}\"/>");
    }
    let path = folder.path().join("small.xml");
    std::fs::write(&path, whole + "</mujoco>").unwrap();
    same(&Robot::load(&path).unwrap(), &load(&plain, "small.xml"));
}

/// Each file is parsed once: a part takes no longer at the end of a chain of includes. When each
/// level parsed what it includes again, it took 150 times as long.
#[test]
fn what_an_mjcf_includes_takes_no_longer_from_deep_within() {
    const LEVELS: usize = 300;
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).unwrap();
    let texts: String = (0..20_000)
        .map(|i| format!("<text name=\"t{i}\" data=\"part\"/>"))
        .collect();
    write(
        "0.xml",
        format!("<mujocoinclude><custom>{texts}</custom></mujocoinclude>"),
    );
    for level in 0..LEVELS {
        let next = format!("<mujocoinclude><include file=\"{level}.xml\"/></mujocoinclude>");
        write(&format!("{}.xml", level + 1), next);
    }
    let plain = mjcf(&small());
    let takes_s = |part: usize| {
        let include = format!("<include file=\"{part}.xml\"/></mujoco>");
        write("small.xml", plain.replace("</mujoco>", &include));
        let begun = std::time::Instant::now();
        same(
            &Robot::load(folder.path().join("small.xml")).unwrap(),
            &load(&plain, "small.xml"),
        );
        begun.elapsed().as_secs_f64()
    };
    let (near_s, far_s) = (takes_s(0), takes_s(LEVELS));
    assert!(far_s < 20.0 * near_s, "{far_s} s, {near_s} s from near");
}

/// All included files together may not exceed the limit for one: 16 MiB.
#[test]
fn what_an_mjcf_includes_is_bounded_in_all() {
    let folder = tempfile::tempdir().unwrap();
    let mut whole = "<mujoco>".to_owned();
    for i in 0..3 {
        let part = format!(
            "<mujocoinclude><!--{}--></mujocoinclude>",
            " ".repeat(6 << 20)
        );
        std::fs::write(folder.path().join(format!("{i}.xml")), part).unwrap();
        whole += &format!("<include file=\"{i}.xml\"/>");
    }
    let path = folder.path().join("whole.xml");
    std::fs::write(&path, whole + "</mujoco>").unwrap();
    let said = Robot::load(&path).unwrap_err().to_string();
    assert!(
        said.contains("files of more than 16777216 bytes are included"),
        "{said}"
    );
}

fn refused(text: &str) -> RobotError {
    Robot::from_urdf_str(text, "robot.xml").unwrap_err()
}

#[test_case(
    "<sdf version=\"1.9\"><world name=\"w\"/></sdf>",
    "no `<model>` with links";
    "no model"
)]
#[test_case(
    "<sdf version=\"1.9\"><model name=\"m\"><link name=\"l\"/><include><uri>x</uri></include></model></sdf>",
    "1 file that it names cannot be found: `x` at";
    "nested"
)]
#[test_case(
    "<sdf version=\"1.9\"><model name=\"m\"><link name=\"l\"/><joint name=\"j\" type=\"revolute\"><parent>l</parent><child>x</child></joint></model></sdf>",
    "`x`, which is no link";
    "no link"
)]
#[test_case(
    "<sdf version=\"1.9\"><model name=\"m\"><link name=\"a\"><pose relative_to=\"b\"/></link><link name=\"b\"><pose relative_to=\"a\"/></link></model></sdf>",
    "more than 100 frames, each relative to the next, or a circle of them";
    "circle"
)]
#[test_case(
    "<sdf version=\"1.9\"><model name=\"m\"><link name=\"a\"><pose>1 2</pose></link></model></sdf>",
    "a pose is a place, followed by three angles or a quaternion";
    "short pose"
)]
#[test_case(
    "<sdf version=\"1.9\"><model name=\"m\"><link name=\"a\"/><link name=\"b\"/><joint name=\"j\" type=\"gearbox\"><parent>a</parent><child>b</child></joint></model></sdf>",
    "`gearbox` has no counterpart";
    "gearbox"
)]
#[test_case("<mujoco><worldbody/></mujoco>", "it holds no body"; "no body")]
#[test_case(
    "<mujoco><include file=\"none.xml\"/></mujoco>",
    "`none.xml` cannot be included: there is no such file";
    "no file"
)]
#[test_case(
    "<mujoco><worldbody><body name=\"a\"><body name=\"b\"><freejoint/></body></body></worldbody></mujoco>",
    "is free within the robot";
    "free within"
)]
fn what_has_no_counterpart_is_refused(text: &str, words: &str) {
    let error = refused(text);
    assert!(error.to_string().contains(words), "{error}");
    assert!(!error.help().is_empty());
}

/// A geom given by its ends equals one given by position, rotation and half length: in its mass by
/// volume, and in its contacts.
#[test_case("capsule", "0.02 0.15")]
#[test_case("cylinder", "0.02 0.15")]
#[test_case("box", "0.02 0.02 0.15")]
#[test_case("ellipsoid", "0.02 0.02 0.15")]
fn a_geom_of_an_mjcf_may_be_said_by_its_ends(kind: &str, size: &str) {
    let plain = mjcf(&small());
    let with = |geom: &str| {
        let body = format!(
            "<freejoint/><body name=\"mast\"><geom type=\"{kind}\" density=\"800\" {geom}/></body>"
        );
        load(&plain.replacen("<freejoint/>", &body, 1), "small.xml")
    };
    // The file's angles are in radians.
    let placed = with(&format!(
        "size=\"{size}\" pos=\"0.1 0.15 0.1\" euler=\"-1.5707963267948966 0 0\""
    ));
    let ends = with("size=\"0.02\" fromto=\"0.1 0 0.1 0.1 0.3 0.1\"");
    same(&ends, &placed);
    same_mass(&ends.chassis.mass, &placed.chassis.mass);
    let without = load(&plain, "small.xml");
    let collisions = |robot: &Robot| robot.chassis.collisions.len();
    assert!(collisions(&ends) > collisions(&without));
    assert_eq!(collisions(&ends), collisions(&placed));
    for (one, other) in ends
        .chassis
        .collisions
        .iter()
        .zip(&placed.chassis.collisions)
    {
        let (one, other) = (one.body_from_shape, other.body_from_shape);
        assert!((one.translation.vector - other.translation.vector).norm() < 1e-12);
    }
    assert!(ends.mass_kg() > without.mass_kg() + 0.1);
}

/// Three omni wheels of twelve rollers around a disc; `wheels(rollers)` is the content of the
/// chassis.
fn omni_mjcf(wheels: &str, motors: &str) -> String {
    format!(
        "<mujoco model=\"small\"><compiler angle=\"degree\"/><worldbody><body name=\"base\" pos=\"0 0 0.05\"><freejoint/>\
         <inertial pos=\"0 0 0\" mass=\"3\" diaginertia=\"0.02 0.02 0.03\"/>\
         <geom type=\"cylinder\" size=\"0.12 0.02\"/>{wheels}</body></worldbody><actuator>{motors}</actuator></mujoco>"
    )
}

/// A wheel whose axle is x, with its content.
fn omni_wheel(end: &str, rollers: &str) -> String {
    format!(
        "<body name=\"wheel{end}\" pos=\"0.15 0 0\"><joint name=\"drive{end}\" axis=\"1 0 0\"/>\
         <inertial pos=\"0 0 0\" mass=\"0.3\" diaginertia=\"4e-4 2e-4 2e-4\"/>{rollers}</body>"
    )
}

/// A roller at the top of its wheel, whose axle is y.
fn omni_roller(end: &str) -> String {
    format!(
        "<body name=\"roller{end}\" pos=\"0 0 0.042\"><joint name=\"spin{end}\" axis=\"0 1 0\"/>\
         <inertial pos=\"0 0 0\" mass=\"0.01\" diaginertia=\"5e-7 4e-7 5e-7\"/>\
         <geom type=\"capsule\" size=\"0.008 0.0115\" euler=\"90 0 0\"/></body>"
    )
}

/// MuJoCo's own way of writing wheels with rollers, nested `<replicate>` elements: the robot is
/// that of a file with each body written out, at angles by sine and cosine, with MuJoCo's names; a
/// single motor drives each of its copies.
#[test]
fn what_an_mjcf_replicates_is_written_out() {
    let turned = |axis: Vector3<f64>, angle: f64, inside: &str| {
        let turn = UnitQuaternion::from_scaled_axis(axis * angle.to_radians());
        let pose = mjcf_pose(&Isometry3::from_parts(Translation3::identity(), turn));
        format!("<frame {pose}>{inside}</frame>")
    };
    let by_hand: String = (0..3)
        .map(|w| {
            let rollers: String = (0..12)
                .map(|r| {
                    turned(
                        Vector3::x(),
                        30.0 * r as f64,
                        &omni_roller(&format!("-{r:02}{w}")),
                    )
                })
                .collect();
            turned(
                Vector3::z(),
                120.0 * w as f64,
                &omni_wheel(&w.to_string(), &rollers),
            )
        })
        .collect();
    let motor = |w: &str| {
        format!("<velocity joint=\"drive{w}\" forcerange=\"-2 2\" ctrlrange=\"-30 30\"/>")
    };
    let motors: String = ["0", "1", "2"].map(motor).concat();
    let by_hand = load(&omni_mjcf(&by_hand, &motors), "small.xml");

    let rollers = format!(
        "<replicate count=\"12\" euler=\"30 0 0\" sep=\"-\">{}</replicate>",
        omni_roller("")
    );
    let replicated = format!(
        "<replicate count=\"3\" euler=\"0 0 120\">{}</replicate>",
        omni_wheel("", &rollers)
    );
    let replicated = omni_mjcf(&replicated, &motor(""));
    same(&load(&replicated, "small.xml"), &by_hand);
    assert_eq!(by_hand.wheels.len(), 3);
    assert_eq!(by_hand.wheels[2].motor.velocity_rad_s, 30.0);

    // Radians, and another sequence for the same rotation.
    let in_radians = replicated
        .replace("angle=\"degree\"", "angle=\"radian\" eulerseq=\"ZYX\"")
        .replace(
            "euler=\"30 0 0\"",
            &format!("euler=\"0 0 {}\"", 30f64.to_radians()),
        )
        .replace(
            "euler=\"0 0 120\"",
            &format!("euler=\"{} 0 0\"", 120f64.to_radians()),
        )
        .replace(
            "euler=\"90 0 0\"",
            &format!("euler=\"0 0 {}\"", 90f64.to_radians()),
        );
    same(&load(&in_radians, "small.xml"), &by_hand);
}

#[test_case("<replicate><geom/></replicate>", "a whole number `count`"; "no count")]
#[test_case("<replicate count=\"1e9\"><geom/></replicate>", "a whole number `count`"; "too many")]
#[test_case("<replicate count=\"2\" offset=\"1 x 0\"><geom/></replicate>", "is not three numbers"; "no offset")]
#[test_case(
    "<replicate count=\"9999\"><replicate count=\"9999\"><geom/></replicate></replicate>",
    "would write out more than 8 MB";
    "copies of copies"
)]
fn what_cannot_be_replicated_is_refused(wheels: &str, words: &str) {
    let error = Robot::from_urdf_str(&omni_mjcf(wheels, ""), "small.xml").unwrap_err();
    assert!(error.to_string().contains(words), "{error}");
}

/// What lies in many `<replicate>` elements is read once for each level of them, and not once for
/// each element: 64 MB in all may be read. Ninety beside each other around a megabyte are one
/// level, eighty within each other are not.
#[test]
fn levels_of_replicates_are_bounded_and_not_their_number() {
    let bodies = "<body><geom size=\"1\"/></body>".repeat(36_000);
    let around = |inside: &str| format!("<replicate count=\"1\">{inside}</replicate>");
    let refused = |bodies: &str| {
        let text = omni_mjcf(bodies, "");
        let error = Robot::from_urdf_str(&text, "small.xml").unwrap_err();
        error.to_string()
    };
    let beside = refused(&(around(&bodies) + &around("<site/>").repeat(89)));
    assert!(!beside.contains("<replicate>"), "{beside}");
    let within = refused(&(0..80).fold(bodies, |inside, _| around(&inside)));
    assert!(
        within.contains("`<replicate>` within one another write out more than 64 MB"),
        "{within}"
    );
}

/// A wheel of four, with an ellipsoid as visual, in its own file beside the robot's, or within it.
/// Its frame is the model's.
fn sdf_wheel() -> String {
    r#"<link name="hub"><inertial><mass>0.5</mass><inertia><ixx>0.0004</ixx><iyy>0.0006</iyy><izz>0.0004</izz></inertia></inertial>
<collision name="c"><pose>0 0 0 1.5707963267948966 0 0</pose><geometry><cylinder><radius>0.05</radius><length>0.04</length></cylinder></geometry></collision></link>"#
        .to_owned()
}

/// A base with four wheels, each its own model; `wheel` writes one with a name and a pose.
fn sdf_of_models(wheel: impl Fn(&str, &str) -> String, link: impl Fn(&str) -> String) -> String {
    let places = [
        ("fl", 0.2, 0.18),
        ("fr", 0.2, -0.18),
        ("rl", -0.2, 0.18),
        ("rr", -0.2, -0.18),
    ];
    let wheels = places.map(|(name, x, y)| {
        format!(
            "{}\n<joint name=\"mecanum_{name}\" type=\"revolute\"><parent>base</parent><child>{}</child><axis><xyz>0 1 0</xyz></axis></joint>",
            wheel(&format!("wheel_{name}"), &format!("{x} {y} 0 0 0 0")),
            link(name)
        )
    });
    format!(
        r#"<sdf version="1.9"><model name="rover"><link name="base"><pose>0 0 0.05 0 0 0</pose><inertial><mass>10</mass><inertia><ixx>0.1</ixx><iyy>0.2</iyy><izz>0.3</izz></inertia></inertial></link>
{}</model></sdf>"#,
        wheels.join("\n")
    )
}

/// Positions of the wheels, and their angles.
fn stand(robot: &Robot) -> Vec<(String, [f64; 3], f64)> {
    let round = |x: f64| (1e9 * x).round() / 1e9 + 0.0;
    let of = |w: &ilon_robot::Wheel| {
        let place = w.position_m();
        (
            w.name.clone(),
            [place.x, place.y, place.z].map(round),
            round(w.gamma_rad),
        )
    };
    robot.wheels.iter().map(of).collect()
}

#[test]
fn models_within_a_model_included_and_merged_ones_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("wheel")).unwrap();
    std::fs::write(
        at("wheel/model.sdf"),
        format!(
            "<sdf version=\"1.9\"><model name=\"wheel\">{}</model></sdf>",
            sdf_wheel()
        ),
    )
    .unwrap();
    let plain = sdf_of_models(
        |name, pose| {
            sdf_wheel().replace(
                "name=\"hub\">",
                &format!("name=\"{name}\"><pose>{pose}</pose>"),
            )
        },
        |name| format!("wheel_{name}"),
    );
    let within = sdf_of_models(
        |name, pose| {
            format!(
                "<model name=\"{name}\"><pose>{pose}</pose>{}</model>",
                sdf_wheel()
            )
        },
        |name| format!("wheel_{name}::hub"),
    );
    // As the model editor of Gazebo writes them: each pose has a `frame`, most of them empty.
    let [of_no_frame, of_a_frame] = [("", 0.0), ("post", 0.1)].map(|(frame, above_m)| {
        let own = format!("name=\"hub\"><pose frame='{frame}'>0 0 {above_m} 0 0 0</pose>");
        let post = "<frame name='post'><pose relative_to=''>0 0 -0.1 0 0 0</pose></frame>";
        let wheel = sdf_wheel().replace("name=\"hub\">", &own) + post;
        sdf_of_models(
            |name, pose| {
                format!("<model name='{name}'>{wheel}<pose frame=''>{pose}</pose></model>")
            },
            |name| format!("wheel_{name}::hub"),
        )
    });
    let included = sdf_of_models(
        |name, pose| {
            format!(
                "<include><uri>model://wheel</uri><name>{name}</name><pose>{pose}</pose></include>"
            )
        },
        |name| format!("wheel_{name}::hub"),
    );
    // If merged, the links keep their names, so that each wheel is its own file.
    let merged = sdf_of_models(
        |name, pose| {
            std::fs::create_dir_all(at(name)).unwrap();
            let own = sdf_wheel().replace("name=\"hub\"", &format!("name=\"{name}_hub\""));
            let model = format!("<sdf version=\"1.9\"><model name=\"{name}\">{own}</model></sdf>");
            std::fs::write(at(name).join("model.sdf"), model).unwrap();
            format!(
                "<include merge=\"true\"><uri>model://{name}</uri><pose>{pose}</pose></include>"
            )
        },
        |name| format!("wheel_{name}_hub"),
    );
    let world = "<sdf version=\"1.9\"><world name=\"w\"><include><uri>model://sun</uri></include><include><uri>model://rover</uri></include></world></sdf>";
    std::fs::create_dir(at("rover")).unwrap();
    std::fs::write(at("rover/model.sdf"), &included).unwrap();
    let mut found = Vec::new();
    for (name, text) in [
        ("plain", &plain[..]),
        ("within", &within),
        ("of_no_frame", &of_no_frame),
        ("of_a_frame", &of_a_frame),
        ("included", &included),
        ("merged", &merged),
        ("world", world),
    ] {
        let path = at(&format!("{name}.sdf"));
        std::fs::write(&path, text).unwrap();
        let loaded = Robot::load(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
        found.push(stand(&loaded));
    }
    assert!(
        found.windows(2).all(|pair| pair[0] == pair[1]),
        "{found:#?}"
    );
    // Its frame is the model's, not that of the base, 50 mm up.
    assert_eq!(found[0][0].1, [0.2, 0.18, 0.0]);
    // A fault in an included file is shown there.
    std::fs::write(at("wheel/model.sdf"), "<sdf version=\"1.9\">\n<model name=\"w\">\n<link name=\"hub\"><pose>1 2</pose></link></model></sdf>").unwrap();
    let error = Robot::load(at("included.sdf")).unwrap_err();
    assert!(
        error.file().ends_with("model.sdf") && error.line() == Some(3),
        "{error}"
    );
    // A missing file is named, and left out if requested.
    std::fs::remove_file(at("wheel/model.sdf")).unwrap();
    let error = Robot::load(at("included.sdf")).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("4 files that it names cannot be found: `model://wheel`"),
        "{error}"
    );
    // A sensor whose model is missing is left out with the joint that holds it, and the robot is
    // the same; without the option the joint is refused.
    let sensor = "<include><uri>model://laser</uri></include><joint name=\"holds\" type=\"fixed\"><parent>base</parent>\
        <child>laser::link</child></joint></model>";
    let with_sensor = plain.replacen("</model>", sensor, 1);
    std::fs::write(at("sensor.sdf"), &with_sensor).unwrap();
    let mut options = LoadOptions::default();
    options.leave_out_missing = true;
    let loaded = Robot::load_with(at("sensor.sdf"), &options).unwrap().robot;
    assert_eq!(stand(&loaded), found[0]);
    let says = |remark: &ilon_robot::Remark| {
        remark.subject == "joint `holds`"
            && remark.text.contains("left out, for it names `laser::link`")
    };
    assert!(loaded.remarks.iter().any(says), "{:?}", loaded.remarks);
}

/// A solid of revolution about its longest axis is approximated by balls: at its middle it is as
/// thick as its half axis.
#[test]
fn ellipsoids_of_sdf_are_read() {
    let text = sdf_of_models(
        |name, pose| {
            sdf_wheel()
                .replace(
                    "name=\"hub\">",
                    &format!("name=\"{name}\"><pose>{pose}</pose>"),
                )
                .replace(
                    "<cylinder><radius>0.05</radius><length>0.04</length></cylinder>",
                    "<ellipsoid><radii>0.05 0.05 0.05</radii></ellipsoid>",
                )
        },
        |name| format!("wheel_{name}"),
    );
    let robot = load(&text, "r.sdf");
    assert!(
        robot
            .wheels
            .iter()
            .all(|wheel| (wheel.radius_m - 0.05).abs() < 1e-9)
    );
}

/// Line numbers of an included file are its own.
#[test]
fn lines_of_included_mjcf_are_those_of_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let padding = "<!-- -->\n".repeat(40);
    std::fs::write(
        at("parts.xml"),
        format!("<mujocoinclude>\n{padding}<default/>\n</mujocoinclude>\n"),
    )
    .unwrap();
    let wheel = |name: &str, x: f64, y: f64| {
        format!(
            "<body name=\"{name}\" pos=\"{x} {y} 0\"><inertial pos=\"0 0 0\" mass=\"0.5\" diaginertia=\"0.001 0.001 0.001\"/><joint name=\"w_{name}\" type=\"hinge\" axis=\"0 1 0\"/></body>\n"
        )
    };
    let wheels = [
        wheel("fl", 0.2, 0.18),
        wheel("fr", 0.2, -0.18),
        wheel("rl", -0.2, 0.18),
        wheel("rr", -0.2, -0.18),
    ]
    .concat();
    let base =
        "<body name=\"base\"><inertial pos=\"0 0 0\" mass=\"9\" diaginertia=\"0.1 0.1 0.1\"/>\n";
    std::fs::write(at("r.xml"), format!("<mujoco>\n<include file=\"parts.xml\"/>\n<worldbody>\n{base}{wheels}</body></worldbody></mujoco>\n")).unwrap();
    let error = Robot::load(at("r.xml")).unwrap_err();
    assert_eq!(error.line(), Some(5), "{error}");
    // The same with the wheels in the included file.
    std::fs::write(
        at("wheels.xml"),
        format!("<mujocoinclude>\n{padding}{wheels}</mujocoinclude>\n"),
    )
    .unwrap();
    std::fs::write(at("q.xml"), format!("<mujoco>\n<worldbody>\n{base}<include file=\"wheels.xml\"/></body></worldbody></mujoco>\n")).unwrap();
    let error = Robot::load(at("q.xml")).unwrap_err();
    assert!(
        error.file().ends_with("wheels.xml") && error.line() == Some(42),
        "{error}"
    );
}
