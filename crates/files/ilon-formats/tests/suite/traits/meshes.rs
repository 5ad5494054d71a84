//! Meshes, packages and xacro.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use super::{load, remarked, with_roller_collision};
use crate::traits::common::{options, small};
use ilon_formats::{Fault, LoadOptions, LoadRobot, Package, Remedy};
use ilon_robot::{CollisionShape, Robot};
use test_case::test_case;

/// A separate folder for each test, below the build's.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder to write to");
    folder
}

/// Vertices of the barrel of the small robot in millimetres, turned about z: rings of 24 points at
/// 41 places. The surface that touches the ground at wheel angle phi is at rho sin(phi) along the
/// axis, rho cos(phi) - a from it.
fn barrel_rings_mm() -> Vec<Vec<[f64; 3]>> {
    (-20..=20)
        .map(|i| {
            let phi = PI / 8.0 * f64::from(i) / 20.0;
            let (z, r) = (50.0 * phi.sin(), 50.0 * phi.cos() - 38.0);
            (0..24)
                .map(|j| {
                    let (s, c) = (2.0 * PI * f64::from(j) / 24.0).sin_cos();
                    [r * c, r * s, z]
                })
                .collect()
        })
        .collect()
}

fn triangles(rings: &[Vec<[f64; 3]>]) -> Vec<[[f64; 3]; 3]> {
    let mut all = Vec::new();
    for pair in rings.windows(2) {
        for j in 0..24 {
            let next = (j + 1) % 24;
            all.push([pair[0][j], pair[0][next], pair[1][j]]);
            all.push([pair[0][next], pair[1][next], pair[1][j]]);
        }
    }
    all
}

fn binary_stl(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![0u8; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0u8; 12]);
        for x in triangle.iter().flatten() {
            bytes.extend((*x as f32).to_le_bytes());
        }
        bytes.extend([0u8; 2]);
    }
    bytes
}

fn text_stl(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut text = String::from("solid roller\n");
    for triangle in triangles {
        text += "facet normal 0 0 1\nouter loop\n";
        for [x, y, z] in triangle {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid roller\n").into_bytes()
}

fn obj(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut text = String::new();
    for [x, y, z] in triangles.iter().flatten() {
        text += &format!("v {x} {y} {z}\n");
    }
    for i in 0..triangles.len() {
        text += &format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
    }
    text.into_bytes()
}

/// In inches, shifted and rotated by a quarter turn about x, which the scene reverses.
fn dae(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let inch = 25.4;
    let mut numbers = String::new();
    for [x, y, z] in triangles.iter().flatten() {
        // Rotated by +90 deg about x, (x, y, z) is (x, -z, y); then shifted by one along x.
        numbers += &format!("{} {} {} ", x / inch + 1.0, -z / inch, y / inch);
    }
    // With a unit of 25.4 the URDF's scale gives millimetres.
    format!(
        r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
        <asset><unit name="inch" meter="{inch}"/><up_axis>Y_UP</up_axis></asset>
        <library_geometries><geometry id="g"><mesh>
        <source id="p"><float_array id="a" count="0">{numbers}</float_array></source>
        <vertices id="v"><input semantic="POSITION" source="#p"/></vertices></mesh></geometry></library_geometries>
        <library_visual_scenes><visual_scene id="s"><node><rotate>1 0 0 -90</rotate>
        <node><matrix>1 0 0 -1 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#g"/></node></node>
        </visual_scene></library_visual_scenes></COLLADA>"##
    )
    .into_bytes()
}

fn with_mesh(mesh: &str) -> String {
    with_roller_collision(
        &small(),
        &format!(
            "<collision><geometry><mesh filename=\"{mesh}\" scale=\"0.001 0.001 0.001\"/></geometry></collision>"
        ),
    )
}

#[test_case("roller.stl", binary_stl; "binary stl")]
#[test_case("roller_text.STL", text_stl; "text stl")]
#[test_case("roller.obj", obj; "obj")]
#[test_case("roller.dae", dae; "dae")]
fn the_barrel_of_a_mesh_is_fitted(file: &str, write: fn(&[[[f64; 3]; 3]]) -> Vec<u8>) {
    let folder = folder("meshes");
    std::fs::write(folder.join(file), write(&triangles(&barrel_rings_mm()))).expect("writable");
    std::fs::write(folder.join(format!("{file}.urdf")), with_mesh(file)).expect("writable");
    let loaded = Robot::load_with(folder.join(format!("{file}.urdf")), &LoadOptions::default())
        .unwrap_or_else(|e| panic!("{e}"));
    let wheel = &loaded.robot.wheels[0];
    // Between rings 22.5 / 20 deg apart the hull's chord lies rho (1 - cos(0.56 deg)) = 2.4 um
    // below the circle, and its mean two thirds of that.
    assert!((wheel.radius_m - 0.05).abs() < 3e-6, "{}", wheel.radius_m);
    for roller in &wheel.rollers {
        assert!((roller.radius_m - 0.012).abs() < 3e-6);
        // The last ring is where neighbours hand over; 3 um of rho move the end by rho tan / a of
        // that at most.
        assert!(
            (roller.length_m - 2.0 * 0.038 * (PI / 8.0).tan()).abs() < 2e-5,
            "{}",
            roller.length_m
        );
    }
    assert!(
        loaded.outlines[0].ripple_m < 5e-6,
        "{:?}",
        loaded.outlines[0]
    );
}

/// One of three equal wheels has other facets, and its mesh is half a per cent smaller: the robot
/// still stands level.
#[test]
fn equal_wheels_of_meshes_of_other_facets_have_one_radius() {
    let folder = folder("facets");
    let rings = barrel_rings_mm();
    let smaller = |rings: &[Vec<[f64; 3]>], by_mm: f64| -> Vec<Vec<[f64; 3]>> {
        let thinner = |p: &[f64; 3]| {
            let r = p[0].hypot(p[1]);
            [p[0] * (r - by_mm) / r, p[1] * (r - by_mm) / r, p[2]]
        };
        rings
            .iter()
            .map(|ring| ring.iter().map(thinner).collect())
            .collect()
    };
    let write = |name: &str, rings: &[Vec<[f64; 3]>]| {
        std::fs::write(folder.join(name), binary_stl(&triangles(rings))).expect("writable");
    };
    write("a.stl", &rings);
    for (by_mm, level) in [(0.25, true), (1.5, false)] {
        write("b.stl", &smaller(&rings, by_mm));
        let mut in_first = false;
        let mut text = String::new();
        for line in with_mesh("a.stl").lines() {
            if line.contains("<link name=") {
                in_first = line.contains("wheel_1_");
            }
            text += &if in_first {
                line.replace("a.stl", "b.stl")
            } else {
                line.to_owned()
            };
            text.push('\n');
        }
        std::fs::write(folder.join("robot.urdf"), text).expect("writable");
        let robot = Robot::load(folder.join("robot.urdf")).expect("a robot");
        let radii_m: Vec<f64> = robot.wheels.iter().map(|wheel| wheel.radius_m).collect();
        let apart_m = (radii_m[0] - radii_m[1]).abs();
        // One that is 3 % smaller is another wheel.
        assert_eq!(apart_m == 0.0, level, "{radii_m:?}");
        assert_eq!(
            remarked(&robot, "wheel `wheel_1`", "the facets explain it"),
            level
        );
        let roller = &robot.wheels[0].rollers[0];
        let reach_m = roller.ring_radius_m() + roller.radius_m;
        assert!((reach_m - robot.wheels[0].radius_m).abs() < 1e-9);
    }
}

/// The small robot as xacro: its first wheel's place is computed, and its roller links come from a
/// macro in another file.
fn as_xacro(include: &str) -> (String, String) {
    let text = small()
        .replacen(
            "<robot name",
            "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" name",
            1,
        )
        .replacen(
            "xyz=\"0.2 0 0.05\"",
            "xyz=\"${arm + 0.1} 0 ${2 * half_m}\"",
            1,
        );
    assert!(
        text.contains("${arm"),
        "the first wheel stands at 0.2 0 0.05"
    );
    let start = text
        .find("<link name=\"wheel_1_roller_1_link\">")
        .expect("a roller");
    let end = start + text[start..].find("</link>").expect("its end") + "</link>".len();
    let link = text[start..end].replace("wheel_1_roller_1_link", "${name}_link");
    let library = format!(
        "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n<xacro:property name=\"half_m\" value=\"0.025\"/>\n\
         <xacro:macro name=\"roller\" params=\"name\">{link}</xacro:macro>\n</robot>"
    );
    let main = format!(
        "{}<xacro:roller name=\"wheel_1_roller_1\"/>{}",
        &text[..start],
        &text[end..]
    );
    let first_link = main.find("<link").expect("a link");
    let main = format!(
        "{}<xacro:include filename=\"{include}\"/>\n<xacro:arg name=\"arm\" default=\"0.1\"/>\n\
         <xacro:property name=\"arm\" value=\"$(arg arm)\"/>\n{}",
        &main[..first_link],
        &main[first_link..]
    );
    (main, library)
}

#[test]
fn xacro_is_expanded_without_ros() {
    let folder = folder("xacro");
    let (main, library) = as_xacro("$(find parts)/urdf/roller.xacro");
    std::fs::create_dir_all(folder.join("elsewhere/urdf")).expect("a folder");
    std::fs::write(folder.join("elsewhere/urdf/roller.xacro"), library).expect("written");
    let file = folder.join("robot.urdf.xacro");
    std::fs::write(&file, main).expect("written");

    // A package under another name than its folder is proposed by its content.
    let error = Robot::load(&file).expect_err("no such package");
    let package = "parts".to_owned();
    let Fault::MissingFiles { files } = error.fault() else {
        panic!("{error}")
    };
    assert_eq!(files[0].package, Some(package.clone()));
    assert_eq!(
        error.remedies()[0],
        Remedy::Package {
            name: package,
            folder: Some(folder.join("elsewhere"))
        }
    );

    let options = options(|o| {
        o.packages = vec![Package {
            name: "parts".to_owned(),
            folder: folder.join("elsewhere"),
        }];
    });
    let robot = Robot::load_with(&file, &options).expect("expanded").robot;
    assert!(remarked(&robot, "xacro", "expanded with arm = 0.1"));
    let plain = load(&small());
    assert_eq!(robot.wheels.len(), plain.wheels.len());
    for (p, q) in robot.wheels.iter().zip(&plain.wheels) {
        // Sums of a few decimal numbers.
        assert!((p.position_m() - q.position_m()).norm() < 1e-15);
        assert_eq!(p.rollers.len(), q.rollers.len());
        assert!((p.radius_m - q.radius_m).abs() < 1e-12);
    }
}

/// A folder given relative to the working directory, not to the including file.
#[cfg(unix)]
#[test]
fn the_folder_of_a_package_may_be_given_from_here() {
    let folder = folder("from_here");
    let (main, library) = as_xacro("$(find parts)/urdf/roller.xacro");
    for part in ["robot", "elsewhere/urdf"] {
        std::fs::create_dir_all(folder.join(part)).expect("a folder");
    }
    std::fs::write(folder.join("elsewhere/urdf/roller.xacro"), library).expect("written");
    let file = folder.join("robot/robot.urdf.xacro");
    std::fs::write(&file, main).expect("written");
    let here = std::env::current_dir().expect("a folder");
    let up: PathBuf = here.components().skip(1).map(|_| "..").collect();
    let folder = folder.canonicalize().expect("a folder");
    let package = Package {
        name: "parts".to_owned(),
        folder: up
            .join(folder.strip_prefix("/").expect("it is absolute"))
            .join("elsewhere"),
    };
    let options = options(|o| o.packages = vec![package]);
    Robot::load_with(&file, &options).expect("expanded");
}

/// An environment variable that the file's result depends on: the values it is compared with are
/// reported.
#[test]
fn what_a_variable_that_is_not_set_is_compared_with_is_said() {
    // Long or multi-line text is no name of a machine.
    let long = "x".repeat(1000);
    let text = r#"<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
        <xacro:property name="machine" value="$(env ILON_NO_SUCH_MACHINE)"/>
        <xacro:if value="${machine == 'LONG' or machine == 'a\nb'}"/>
        <xacro:if value="${machine == 'with_four'}"><link name="a"/></xacro:if>
        <xacro:if value="${machine=='with_three' or machine == 'with_four'}"><link name="b"/></xacro:if></robot>"#;
    let text = text.replace("LONG", &long).replace("\\n", "\n");
    let error = Robot::from_urdf_str(&text, "r.urdf.xacro").expect_err("no such variable");
    let (words, help) = (error.to_string(), error.help());
    assert!(
        words.contains("`ILON_NO_SUCH_MACHINE` is not set")
            && words.ends_with("the file compares with `with_four`, `with_three`"),
        "{words}"
    );
    assert!(help.contains("set the environment variable"), "{help}");
}

#[test]
fn packages_are_found_by_option_and_beside_the_file() {
    let folder = folder("packages");
    let package = folder.join("my_robot");
    std::fs::create_dir_all(package.join("meshes")).expect("writable");
    std::fs::create_dir_all(package.join("urdf")).expect("writable");
    let stl = binary_stl(&triangles(&barrel_rings_mm()));
    std::fs::write(package.join("meshes/roller.stl"), stl).expect("writable");
    let inside = package.join("urdf/robot.urdf");
    std::fs::write(&inside, with_mesh("package://my_robot/meshes/roller.stl")).expect("writable");
    assert!(
        Robot::load(&inside).is_ok(),
        "a package around the file is found"
    );

    let text = with_mesh("package://elsewhere/meshes/roller.stl");
    let options = options(|o| {
        o.packages = vec![Package {
            name: "elsewhere".to_owned(),
            folder: package,
        }];
    });
    assert!(Robot::from_urdf_str_with(&text, "robot.urdf", &options).is_ok());
    let error = Robot::from_urdf_str(&text, "robot.urdf").expect_err("not known");
    let name = "elsewhere".to_owned();
    assert_eq!(error.remedies()[0], Remedy::Package { name, folder: None });
}

#[test_case("none.stl", None, "there is no such file"; "missing")]
#[test_case("cut.stl", Some(&binary_stl(&triangles(&barrel_rings_mm()))[..1000]), "it is cut short: fewer triangles than it says"; "cut short")]
#[test_case("roller.step", Some(&b"ISO-10303-21;"[..]), "meshes of the kind `.step` are not read, but `.stl`, `.obj` and `.dae` are"; "other kind")]
#[test_case("empty.obj", Some(&b""[..]), "it holds no vertices"; "empty")]
#[test_case("zero.obj", Some(&b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n"[..]), "a face names a point that is not there"; "counted from zero")]
#[test_case("behind.obj", Some(&b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//-2 2//1 3//1\n"[..]), "a face names a point that is not there"; "further back than the first")]
#[test_case("two.obj", Some(&b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2\n"[..]), "on line 5, a face has fewer than three points"; "a face of two points")]
#[test_case("huge.obj", Some(&b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n"[..]), "on line 4, `99999999999999999999` is no index of a point"; "an index beyond all numbers")]
#[test_case("wide.obj", Some(&b"\xff\xfev\0 \x000\0\n\0"[..]), "it is not UTF-8 text"; "utf 16")]
fn a_mesh_that_cannot_be_read_is_told(file: &str, bytes: Option<&[u8]>, expected: &str) {
    let folder = folder("bad_meshes");
    if let Some(bytes) = bytes {
        std::fs::write(folder.join(file), bytes).expect("writable");
    }
    let urdf = folder.join("robot.urdf");
    let error = Robot::from_urdf_str(&with_mesh(file), &urdf.display().to_string())
        .expect_err("unreadable");
    let Fault::WheelSizeUnknown {
        reason: Some(reason),
        ..
    } = error.fault()
    else {
        panic!("{error}")
    };
    assert!(reason.ends_with(expected), "{reason}");
    assert!(error.line().is_some());
}

/// The chassis of a robot that rests on it, with 20,000 corners, becomes a hull of at most 2,000, which reaches as far in every
/// direction within 0.3 % of its half size; sharp corners beside it stay exactly. (The search
/// for touches reads all corners in each step: 57,600 triangles made five short runs take 17 s.)
#[test]
fn the_hull_of_a_fine_mesh_has_few_corners_and_the_same_reach() {
    let folder = folder("fine_chassis");
    let half = [0.2, 0.15, 0.05];
    let ellipsoid = |i: usize, j: usize| {
        let (s, c) = (PI * i as f64 / 100.0).sin_cos();
        let (t, d) = (2.0 * PI * j as f64 / 200.0).sin_cos();
        // Far from the mesh's origin, as in coordinates of an assembly.
        [4.0 + half[0] * s * d, half[1] * s * t, half[2] * c]
    };
    let mut fine = Vec::new();
    for (i, j) in (0..100).flat_map(|i| (0..200).map(move |j| (i, j))) {
        let [a, b] = [ellipsoid(i, j), ellipsoid(i, j + 1)];
        let [c, d] = [ellipsoid(i + 1, j), ellipsoid(i + 1, j + 1)];
        fine.extend([[a, c, b], [b, c, d]]);
    }
    let corners = [[4.3, 0.1, 0.04], [3.7, 0.1, -0.04], [4.3, -0.1, -0.04]];
    fine.push(corners);
    std::fs::write(folder.join("chassis.stl"), binary_stl(&fine)).expect("a mesh");
    let text = include_str!("../../../../../../assets/robots/differential.urdf");
    let end = text.find("</link>").expect("a chassis");
    let mesh = r#"<collision><geometry><mesh filename="chassis.stl"/></geometry></collision>"#;
    let text = format!("{}{mesh}{}", &text[..end], &text[end..]);
    let file = folder.join("fine.urdf");
    let name = file.to_str().expect("a name");
    let robot = Robot::from_urdf_str(&text, name).unwrap_or_else(|e| panic!("{e}"));
    let hull = robot.chassis.collisions.last().expect("a shape");
    let CollisionShape::ConvexHull { points_m } = &hull.shape else {
        panic!("a hull");
    };
    assert!(points_m.len() <= 2000, "{}", points_m.len());
    for corner in corners {
        let near = |p: &&nalgebra::Point3<f64>| (0..3).all(|k| (p[k] - corner[k]).abs() < 1e-6);
        assert!(points_m.iter().any(|p| near(&p)), "{corner:?}");
    }
    for k in 0..2000 {
        let (z, turn) = (f64::from(2 * k + 1) / 2000.0 - 1.0, 0.7 * f64::from(k));
        let level = (1.0 - z * z).sqrt();
        let u = nalgebra::Vector3::new(level * turn.cos(), level * turn.sin(), z);
        let reach = |p: &[f64; 3]| p[0] * u.x + p[1] * u.y + p[2] * u.z;
        let exact_m = fine
            .iter()
            .flatten()
            .map(reach)
            .fold(f64::NEG_INFINITY, f64::max);
        let missing_m = exact_m - hull.reach_m(&u);
        // Half its size in this direction, as of the ellipsoid in its box.
        let half_m = nalgebra::vector![0.3, 0.15, 0.05].component_mul(&u).norm();
        assert!(
            (-1e-6..3e-3 * half_m).contains(&missing_m),
            "{u}: {missing_m}"
        );
    }
}
