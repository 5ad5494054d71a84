//! Robots as files of several programs draw them: frames, meshes and joints that are not those of
//! a URDF of our own.

use std::fmt::Write;

use crate::common::options;
use ilon_formats::{Diagnosis, Fault, LoadOptions, LoadRobot, Loaded, RobotError, TyreOptions};
use ilon_robot::{JointRole, Robot};
use tempfile::TempDir;
use test_case::test_case;

/// The wheels of four by name and place.
const PLACES: [(&str, f64, f64); 4] = [
    ("fl", 0.2, 0.18),
    ("fr", 0.2, -0.18),
    ("rl", -0.2, 0.18),
    ("rr", -0.2, -0.18),
];

fn written(name: &str, text: &str) -> (TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

fn read(name: &str, text: &str, options: &LoadOptions) -> Result<Loaded, RobotError> {
    let (_folder, path) = written(name, text);
    Robot::load_with(&path, options)
}

fn diagnosed(name: &str, text: &str) -> Diagnosis {
    let (_folder, path) = written(name, text);
    Robot::diagnose(&path, &LoadOptions::default(), |_| true)
}

fn remarks(loaded: &Loaded) -> Vec<String> {
    let remarks = loaded.robot.remarks.iter();
    remarks
        .map(|r| format!("{}: {}", r.subject, r.text))
        .collect()
}

/// Places and angles of the wheels, to a nanometre and a nanoradian.
fn stand(robot: &Robot) -> Vec<(String, [f64; 4])> {
    let round = |x: f64| (1e9 * x).round() / 1e9 + 0.0;
    let of = |w: &ilon_robot::Wheel| {
        let at = w.position_m();
        (w.name.clone(), [at.x, at.y, at.z, w.gamma_rad].map(round))
    };
    robot.wheels.iter().map(of).collect()
}

// --- SDF.

/// Four mecanum wheels below a base with this pose in the model.
fn sdf(pose: &str, of_wheel: impl Fn(f64) -> String) -> String {
    let inertial = "<inertial><mass>1</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>";
    let mut text = format!(
        "<sdf version=\"1.9\"><model name=\"r\"><link name=\"base\"><pose>{pose}</pose>{}</link>",
        inertial.replace("<mass>1<", "<mass>10<")
    );
    for (name, x, y) in PLACES {
        let surface = of_wheel((x * y).signum());
        write!(
            text,
            r#"<link name="{name}"><pose>{x} {y} 0.05 0 0 0</pose>{inertial}<collision name="c"><pose>0 0 0 1.5707963267948966 0 0</pose>
            <geometry><cylinder><radius>0.05</radius><length>0.04</length></cylinder></geometry>{surface}</collision></link>
            <joint name="mecanum_{name}" type="revolute"><parent>base</parent><child>{name}</child><axis><xyz>0 1 0</xyz></axis></joint>"#
        )
        .unwrap();
    }
    text + "</model></sdf>"
}

/// SDF places links in the model's frame, whose x is ahead and whose z is up; how the root link is
/// turned in it is a matter of its mesh.
#[test_case("0 0 0 0 0 -1.57"; "turned")]
#[test_case("-0.4 0 0.4 0 -0.522 0"; "leaning")]
fn the_frame_of_an_sdf_is_its_models(pose: &str) {
    let plain = |_| String::new();
    let level = read("r.sdf", &sdf("0 0 0 0 0 0", plain), &LoadOptions::default()).unwrap();
    let posed = read("r.sdf", &sdf(pose, plain), &LoadOptions::default()).unwrap();
    assert_eq!(stand(&posed.robot), stand(&level.robot));
    let base = read(
        "r.sdf",
        &sdf("0.1 0 0.3 0 0 2", plain),
        &LoadOptions::default(),
    )
    .unwrap();
    let center_m = base.robot.chassis.mass.center_of_mass_m;
    assert!(
        (center_m - nalgebra::Vector3::new(0.1, 0.0, 0.3)).norm() < 1e-12,
        "{center_m}"
    );
}

/// A direction of friction is said in a frame of the SDF: that of a link which is turned, or the
/// model's. At the front left of the X the roller on the floor lies along (1, -1).
#[test_case("base", "0 0 0 0 0 1.5707963267948966", |s| [-s, -1.0], "ode"; "of a turned link")]
#[test_case("__model__", "0 0 0 0 0 1", |s| [1.0, -s], "ode"; "of the model")]
#[test_case("base", "0 0 0 0 0 0", |s| [1.0, -s], "bullet"; "for another engine")]
fn directions_of_friction_are_said_in_frames(
    frame: &str,
    pose: &str,
    of: fn(f64) -> [f64; 2],
    engine: &str,
) {
    let [mu, mu2] = if engine == "ode" {
        ["mu", "mu2"]
    } else {
        ["friction", "friction2"]
    };
    let surface = |side: f64| {
        let [x, y] = of(side);
        format!(
            "<surface><friction><{engine}><{mu}>1</{mu}><{mu2}>0</{mu2}><fdir1 expressed_in=\"{frame}\">{x} {y} 0</fdir1></{engine}></friction></surface>"
        )
    };
    let text = sdf(pose, surface).replace("mecanum_", "plain_");
    let loaded = read("r.sdf", &text, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let gammas: Vec<f64> = loaded
        .robot
        .wheels
        .iter()
        .map(|w| w.gamma_rad.to_degrees())
        .collect();
    for (is, should) in gammas.iter().zip([-45.0, 45.0, 45.0, -45.0]) {
        assert!((is - should).abs() < 1e-9, "{gammas:?}");
    }
}

/// What cannot be read of an SDF's friction is named as the file calls it, with its own line.
#[test_case("ode", ["1 2", "0", "1 0 0"], "the `mu` on line A is not a number, but `1 2`"; "mu")]
#[test_case("ode", ["1", "x", "1 0 0"], "the `mu2` on line B is not a number, but `x`"; "mu2")]
#[test_case("bullet", ["1", "x", "1 0 0"], "the `friction2` on line B is not a number, but `x`"; "friction2")]
#[test_case("ode", ["1", "0", "1 0"], "on line C is not three numbers, but `1 0`"; "fdir1")]
fn friction_of_sdf_that_cannot_be_read_is_named_with_its_line(
    engine: &str,
    [first, second, direction]: [&str; 3],
    why: &str,
) {
    let [mu, mu2] = match engine {
        "ode" => ["mu", "mu2"],
        _ => ["friction", "friction2"],
    };
    let surface = |_: f64| {
        format!(
            "<surface><friction><{engine}><{mu}>{first}</{mu}>\n<{mu2}>{second}</{mu2}>\n<fdir1 expressed_in=\"base\">{direction}</fdir1></{engine}></friction></surface>"
        )
    };
    let text = sdf("0 0 0 0 0 0", surface).replace("mecanum_", "plain_");
    let line = 1 + text[..text.find(&format!("<{mu}>")).unwrap()]
        .matches('\n')
        .count();
    let why = why
        .replace("line A", &format!("line {line}"))
        .replace("line B", &format!("line {}", line + 1))
        .replace("line C", &format!("line {}", line + 2));
    let help = read("r.sdf", &text, &LoadOptions::default())
        .unwrap_err()
        .help();
    assert!(
        help.contains("the `<fdir1>` of `fl` ") && help.contains(&why),
        "{help}"
    );
}

/// A joint of two axes steers by the first, which is the parent's, and turns its wheel by the second.
#[test]
fn wheels_on_joints_of_two_axes_are_steered() {
    let text = sdf("0 0 0 0 0 0", |_| String::new()).replace("mecanum_", "plain_");
    let turn = "type=\"revolute\"><parent>base</parent><child>f";
    let axis = "<axis><xyz>0 1 0</xyz></axis>";
    let both = "<axis><xyz>0 0 1</xyz><limit><lower>-0.6</lower><upper>0.5</upper></limit></axis><axis2><xyz>0 1 0</xyz></axis2>";
    let steered: String = text
        .split_inclusive("</joint>")
        .map(|part| match part.contains(turn) {
            true => part
                .replace("type=\"revolute\"", "type=\"universal\"")
                .replace(axis, both),
            false => part.to_owned(),
        })
        .collect();
    let loaded = read("r.sdf", &steered, &LoadOptions::default());
    let robot = loaded.unwrap_or_else(|e| panic!("{e}")).robot;
    let mut names: Vec<&str> = robot.wheels.iter().map(|w| w.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["plain_fl", "plain_fr", "plain_rl", "plain_rr"]);
    assert!(
        (robot.mass_kg() - 14.0).abs() < 1e-12,
        "{}",
        robot.mass_kg()
    );
    for wheel in &robot.wheels {
        let steering = robot.steering_of(wheel).map(|joint| &robot.joints[joint]);
        assert_eq!(
            steering.is_some(),
            wheel.name.contains("_f"),
            "{}",
            wheel.name
        );
        if let Some(joint) = steering {
            assert_eq!(joint.name, format!("{}::axis", wheel.name));
            let [lower, upper] = joint.limits;
            assert!((lower + 0.6).abs() < 1e-12 && (upper - 0.5).abs() < 1e-12);
        }
        let at = wheel.position_m();
        assert!((at.z - 0.05).abs() < 1e-12 && (wheel.radius_m - 0.05).abs() < 1e-12);
    }
}

/// Of a joint of two axes each spring acts about its own axis, also where it hangs the other way.
#[test_case("base", "mast", ""; "from above")]
#[test_case(
    "mast",
    "post",
    r#"<joint name="p" type="fixed"><parent>base</parent><child>post</child></joint>"#;
    "from below"
)]
fn springs_of_joints_of_two_axes_stay_on_their_axes(parent: &str, child: &str, post: &str) {
    let axis = |tag: &str, xyz: &str, stiffness: f64| {
        format!(
            "<{tag}><xyz>{xyz}</xyz><dynamics><spring_stiffness>{stiffness}</spring_stiffness></dynamics></{tag}>"
        )
    };
    let axes = axis("axis", "1 0 0", 50.0) + &axis("axis2", "0 1 0", 70.0);
    let links = ["mast", "post"].map(|name| {
        format!(
            "<link name=\"{name}\"><pose>0 0 0.3 0 0 0</pose><inertial><mass>1</mass><inertia><ixx>0.01</ixx>\
             <iyy>0.01</iyy><izz>0.01</izz></inertia></inertial></link>"
        )
    });
    let links = if post.is_empty() {
        links[0].clone()
    } else {
        links.concat()
    };
    let joint = format!(
        "{links}{post}<joint name=\"u\" type=\"universal\"><parent>{parent}</parent><child>{child}</child>{axes}</joint></model>"
    );
    let text = sdf("0 0 0 0 0 0", |_| String::new()).replace("</model>", &joint);
    let loaded = read("r.sdf", &text, &LoadOptions::default());
    let robot = loaded.unwrap_or_else(|e| panic!("{e}")).robot;
    for (name, stiffness) in [("u::axis", 50.0), ("u", 70.0)] {
        let joint = robot.joints.iter().find(|joint| joint.name == name);
        match joint.map(|joint| joint.role) {
            Some(JointRole::Sprung(spring)) => assert_eq!(spring.stiffness, stiffness, "{name}"),
            other => panic!("{name}: {other:?}"),
        }
    }
}

/// An SDF may hang a link by two joints, as a rack by both of what it joins: only a loop is no
/// tree, of which a repair leaves out the joint that closes it.
#[test]
fn joints_of_sdf_hang_from_either_side() {
    let inertial = "<inertial><mass>0.5</mass><inertia><ixx>0.001</ixx><iyy>0.001</iyy><izz>0.001</izz></inertia></inertial>";
    let fixed = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name=\"{name}\" type=\"fixed\"><parent>{parent}</parent><child>{child}</child></joint>"
        )
    };
    let with = |joints: &str| {
        let links = ["rack", "camera"].map(|name| {
            format!("<link name=\"{name}\"><pose>0.1 0 0.3 0 0 0</pose>{inertial}</link>")
        });
        let text = sdf("0 0 0 0 0 0", |_| String::new());
        text.replace("</model>", &format!("{}{joints}</model>", links.concat()))
    };
    let (below, above) = (fixed("b", "base", "rack"), fixed("c", "rack", "camera"));
    let across = fixed("c", "camera", "rack");
    let closing = fixed("d", "camera", "base");
    let plain = |text: &str| read("r.sdf", text, &LoadOptions::default());
    let mass = |robot: &Robot| robot.chassis.mass.clone();
    let tree = plain(&with(&format!("{below}{above}"))).unwrap();
    // Also in an order in which the camera holds the rack first.
    for joints in [format!("{below}{across}"), format!("{across}{below}")] {
        let graph = plain(&with(&joints)).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(mass(&graph.robot), mass(&tree.robot));
    }
    let loop_of = with(&format!("{below}{above}{closing}"));
    assert!(plain(&loop_of).is_err());
    let mut repaired = LoadOptions::default();
    repaired.repair = true;
    let repaired = read("r.sdf", &loop_of, &repaired).unwrap();
    assert_eq!(mass(&repaired.robot), mass(&tree.robot));
    let said = remarks(&repaired).concat();
    assert!(
        said.contains("joint `d`: left out: it closes a loop"),
        "{said}"
    );
}

/// A link that nothing joins leaves the frame to the root that carries the robot.
#[test]
fn a_stray_link_of_sdf_moves_no_wheel() {
    let stray = "<link name=\"sticker\"><pose>1 0 0 0 0 0</pose></link></model>";
    let mut trimmed = LoadOptions::default();
    trimmed.leave_out_missing = true;
    let plain = sdf("0 0 0 0 0 -1.57", |_| String::new());
    let [alone, with] = [plain.clone(), plain.replace("</model>", stray)]
        .map(|text| read("r.sdf", &text, &trimmed).unwrap_or_else(|e| panic!("{e}")));
    assert_eq!(stand(&with.robot), stand(&alone.robot));
}

/// A slide goes as far as its spring lets it on a side without a stop: URDF would take it for one
/// that cannot move.
#[test_case("", |l| l[0] < -10.0 && l[1] > 10.0; "without stops")]
#[test_case("<limit><lower>-0.02</lower></limit>", |l| l[0] == -0.02 && l[1] > 10.0; "with a lower one")]
#[test_case("<limit><upper>0.03</upper></limit>", |l| l[0] < -10.0 && l[1] == 0.03; "with an upper one")]
fn a_slide_of_sdf_moves_where_no_stop_is(limit: &str, holds: fn([f64; 2]) -> bool) {
    let inertial = "<inertial><mass>1</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>";
    let hung = format!(
        "<link name=\"hung\">{inertial}</link><joint name=\"slide\" type=\"prismatic\"><parent>base</parent><child>hung</child>\
         <axis><xyz>0 0 1</xyz><dynamics><damping>5</damping><spring_stiffness>400</spring_stiffness></dynamics>{limit}</axis></joint></model>"
    );
    let text = sdf("0 0 0 0 0 0", |_| String::new()).replace("</model>", &hung);
    let loaded = read("r.sdf", &text, &LoadOptions::default()).unwrap();
    let joint = loaded
        .robot
        .joints
        .iter()
        .find(|of| of.name == "slide")
        .expect("it moves");
    assert!(matches!(joint.role, JointRole::Sprung(_)));
    assert!(holds(joint.limits), "{:?}", joint.limits);
}

// --- MJCF.

/// A base of this root body's attributes and geom, and wheels that `at` places and turns.
fn mjcf(root: &str, asset: &str, base: &str, at: impl Fn(f64, f64) -> String) -> String {
    let wheels = PLACES.map(|(name, x, y)| {
        format!("<body name=\"{name}\" {}><joint name=\"mecanum_{name}\" axis=\"0 0 1\"/><geom type=\"cylinder\" size=\".05 .02\" mass=\".5\"/></body>", at(x, y))
    });
    format!(
        "<mujoco>{asset}<worldbody><body name=\"base\" {root}><freejoint/>{base}{}</body></worldbody></mujoco>",
        wheels.concat()
    )
}

/// Programs whose y is up turn the root body upright; in the world its wheels then stand on the
/// floor.
#[test]
fn a_root_body_of_mjcf_stands_as_in_the_world() {
    let base = |size: &str| format!("<geom type=\"box\" size=\"{size}\" mass=\"8\"/>");
    let up = mjcf("pos=\"0 0 .05\"", "", &base(".15 .1 .02"), |x, y| {
        format!("pos=\"{x} {y} 0\" euler=\"-90 0 0\"")
    });
    // Turned by 90 degrees about x, its y points up and its z backwards to the right.
    let drawn = mjcf(
        "pos=\"0 0 .05\" euler=\"90 0 0\"",
        "",
        &base(".15 .02 .1"),
        |x, y| format!("pos=\"{x} 0 {}\" euler=\"180 0 0\"", -y),
    );
    let [up, drawn] = [up, drawn].map(|text| {
        read("r.xml", &text, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
    });
    assert_eq!(stand(&drawn.robot), stand(&up.robot));
}

/// Where a robot starts to is not which way it faces: a root body that leans by rounding keeps its
/// own x ahead.
#[test_case("0 0 180"; "upright")]
#[test_case("0 0.001 180"; "leaning by rounding")]
fn a_root_body_of_mjcf_keeps_its_heading(euler: &str) {
    let at = |x: f64, y: f64| format!("pos=\"{x} {y} 0\" euler=\"-90 0 0\"");
    let base = "<geom type=\"box\" size=\".15 .1 .02\" mass=\"8\"/>";
    let root = format!("pos=\"0 0 .05\" euler=\"{euler}\"");
    let [ahead, turned] = ["", &root].map(|root| {
        let text = mjcf(root, "", base, at);
        let loaded = read("r.xml", &text, &LoadOptions::default());
        stand(&loaded.unwrap_or_else(|e| panic!("{e}")).robot)
    });
    for ((name, is), (_, should)) in turned.iter().zip(&ahead) {
        // A lever of 0.3 m times the lean of 2e-5 rad.
        let off = is.iter().zip(should).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-5, "{name}: {is:?} {should:?}");
    }
}

/// What of a typed mesh cannot be read weighs nothing in secret: the message says what it is.
#[test_case(
    "vertex=\"0 0 0 1 0 0 0 1 0 0 0 1 5\"",
    "the `vertex` of mesh `m` is not in threes"
)]
#[test_case(
    "vertex=\"0 0 0 1 0 0 0 1 0 0 0 1\" face=\"0 2 1 0\"",
    "the `face` of mesh `m` is not in threes"
)]
#[test_case(
    "vertex=\"0 0 0 1 0 0 0 1 0 0 0 1\" face=\"0 2 4\"",
    "the `face` of mesh `m` names a vertex that it lacks"
)]
#[test_case("vertex=\"0 0 0 1 0 0 2 0 0\"", "the mesh `m` encloses nothing")]
#[test_case(
    "vertex=\"0 0 0 1 0 0 0 1 0 0 0 1\" refpos=\"1 0 0\"",
    "`refpos` and `refquat` of the mesh `m` are not read"
)]
fn a_mesh_of_mjcf_that_is_not_read_is_named(typed: &str, why: &str) {
    let at = |x: f64, y: f64| format!("pos=\"{x} {y} 0\" euler=\"-90 0 0\"");
    let asset = format!("<asset><mesh name=\"m\" {typed}/></asset>");
    let text = mjcf("", &asset, "<geom type=\"mesh\" mesh=\"m\"/>", at);
    let said = match read("r.xml", &text, &LoadOptions::default()) {
        Ok(loaded) => remarks(&loaded).concat(),
        Err(error) => error.to_string(),
    };
    assert!(said.contains(why), "{said}");
}

/// A mesh of points without faces is their hull, with faces what these enclose: a box either way.
#[test_case(""; "hull")]
#[test_case("face=\"0 2 3 0 3 1 4 5 7 4 7 6 0 1 5 0 5 4 2 6 7 2 7 3 0 4 6 0 6 2 1 3 7 1 7 5\""; "faces")]
fn a_mesh_typed_into_an_mjcf_is_weighed(face: &str) {
    let at = |x: f64, y: f64| format!("pos=\"{x} {y} 0\" euler=\"-90 0 0\"");
    let corners: Vec<String> = (0..8)
        .map(|i| {
            let sign = |bit: i32| if i & bit == 0 { -1 } else { 1 };
            format!("{} {} {}", sign(1), sign(2), sign(4))
        })
        .collect();
    let asset = format!(
        "<asset><mesh name=\"m\" scale=\".1 .2 .04\" vertex=\"{}\" {face}/></asset>",
        corners.join("  ")
    );
    let typed = mjcf("", &asset, "<geom type=\"mesh\" mesh=\"m\"/>", at);
    let solid = mjcf("", "", "<geom type=\"box\" size=\".1 .2 .04\"/>", at);
    let [typed, solid] = [typed, solid].map(|text| {
        let loaded =
            read("r.xml", &text, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        loaded.robot.chassis.mass
    });
    // MuJoCo's default density of 1000 kg/m^3.
    assert!((solid.mass_kg - 6.4).abs() < 1e-12);
    assert!((typed.mass_kg - solid.mass_kg).abs() < 1e-9);
    assert!((typed.inertia_kg_m2 - solid.inertia_kg_m2).norm() < 1e-9);
}

// --- URDF and xacro.

const INERTIAL: &str = r#"<inertial><mass value="0.5"/><inertia ixx="0.0006" ixy="0" ixz="0" iyy="0.0006" iyz="0" izz="0.0006"/></inertial>"#;
const BASE: &str = r#"<link name="base"><inertial><mass value="8"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>"#;
const DISC: &str = r#"<collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.04"/></geometry></collision>"#;

/// Four wheels of this content, with further elements.
fn urdf(wheel: &str, more: impl Fn(&str, f64) -> String, rest: &str) -> String {
    let wheels = PLACES.map(|(name, x, y)| {
        format!(
            "<link name=\"{name}\">{wheel}</link>\n<joint name=\"{name}_j\" type=\"continuous\"><parent link=\"base\"/><child link=\"{name}\"/><origin xyz=\"{x} {y} 0\"/><axis xyz=\"0 1 0\"/></joint>\n{}",
            more(name, (x * y).signum())
        )
    });
    format!(
        "<robot name=\"r\">\n{BASE}\n{}{rest}</robot>\n",
        wheels.concat()
    )
}

fn bare(_: &str, _: f64) -> String {
    String::new()
}

/// Friction is written as text or as `value`, in one block or several; otherwise the refusal says
/// why the directions are not used.
#[test_case("<mu1 value=\"1\"/><mu2 value=\"0\"/><fdir1 value=\"1 S 0\" expressed_in=\"base\"/>", None; "as values")]
#[test_case("<mu1>1</mu1><mu2>0</mu2></gazebo><gazebo reference=\"N\"><fdir1 expressed_in=\"base\">1 S 0</fdir1>", None; "in two blocks")]
#[test_case("<fdir1 expressed_in=\"base\">1 S 0</fdir1><mu2>0.01</mu2><mu1>0.5</mu1>", None; "in another order")]
#[test_case("<mu1>1</mu1><mu2>0.5</mu2><fdir1 expressed_in=\"base\">1 S 0</fdir1>", Some("`mu` 1 and `mu2` 0.5: rollers need"); "alike")]
#[test_case("<mu1>1</mu1><fdir1 expressed_in=\"base\">1 S 0</fdir1>", Some("`mu` 1 and `mu2` 1: rollers need"); "without mu2")]
#[test_case("<mu1>1</mu1><mu2>0</mu2><fdir1 expressed_in=\"nowhere\">1 S 0</fdir1>", Some("names the frame `nowhere`, which is no link"); "in no frame")]
#[test_case("<mu1>1</mu1><mu2>0</mu2><fdir1 expressed_in=\"base\">1 S</fdir1>", Some("is not three numbers"); "of two numbers")]
#[test_case("<mu1>1</mu1><mu2>0</mu2><fdir1 expressed_in=\"base\">0 1 0</fdir1>", Some("grips along the axle, as plain wheels do"); "along the axle")]
fn friction_that_is_not_used_is_told(settings: &str, why: Option<&str>) {
    let block = |name: &str, side: f64| {
        let settings = settings
            .replace('S', &(-side).to_string())
            .replace('N', name);
        format!("<gazebo reference=\"{name}\">{settings}</gazebo>\n")
    };
    let text = urdf(&format!("{INERTIAL}{DISC}"), block, "");
    let found = read("r.urdf", &text, &LoadOptions::default());
    match (found, why) {
        (Ok(loaded), None) => {
            let gammas = loaded
                .robot
                .wheels
                .iter()
                .map(|w| w.gamma_rad.to_degrees().round());
            assert_eq!(gammas.collect::<Vec<_>>(), [-45.0, 45.0, 45.0, -45.0]);
        }
        (Err(error), Some(why)) => {
            let help = error.help();
            assert!(
                help.contains(&format!("the `<fdir1>` of `fl` {why}")) || help.contains(why),
                "{help}"
            );
        }
        (found, _) => panic!("{:?}", found.map(|loaded| loaded.robot.wheels.len())),
    }
}

/// `<mass/>` and a missing `<inertia>` are two faults of one element, which one change repairs.
#[test]
fn one_change_that_repairs_two_faults_is_remarked_once() {
    let text = urdf(&format!("<inertial><mass/></inertial>{DISC}"), bare, "");
    let options = options(|options| {
        options.repair = true;
        options.tyres = Some(TyreOptions::default());
    });
    let loaded = read("r.urdf", &text, &options).unwrap_or_else(|e| panic!("{e}"));
    let repaired: Vec<String> = remarks(&loaded)
        .into_iter()
        .filter(|r| r.contains("repaired"))
        .collect();
    assert_eq!(repaired.len(), 4, "{repaired:#?}");
}

/// A turning joint between the world and the base, below slides or above, steers nothing.
#[test_case([("x", "prismatic", "1 0 0"), ("y", "prismatic", "0 1 0"), ("yaw", "continuous", "0 0 1")]; "slides first")]
#[test_case([("yaw", "revolute", "0 0 1"), ("x", "prismatic", "1 0 0"), ("y", "prismatic", "0 1 0")]; "turn first")]
fn a_joint_to_the_world_steers_no_tyres(joints: [(&str, &str, &str); 3]) {
    let links = ["world", "one", "two", "base"];
    let mut above =
        String::from("<link name=\"world\"/><link name=\"one\"/><link name=\"two\"/>\n");
    for (i, (name, kind, axis)) in joints.iter().enumerate() {
        writeln!(above, "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{}\"/><child link=\"{}\"/><axis xyz=\"{axis}\"/><limit lower=\"-9\" upper=\"9\" effort=\"0\" velocity=\"1\"/></joint>", links[i], links[i + 1]).unwrap();
    }
    let text = urdf(&format!("{INERTIAL}{DISC}"), bare, &above);
    let options = options(|options| options.tyres = Some(TyreOptions::default()));
    let loaded = read("r.urdf", &text, &options).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(loaded.robot.wheels.len(), 4);
    assert!(loaded.robot.joints.is_empty());
    let said = remarks(&loaded);
    assert!(
        said.iter()
            .any(|r| r.contains("joint `yaw`: it carries the whole robot")),
        "{said:#?}"
    );
}

/// Eight springs in a row, of which six may move: what mimics the last one is held with it, and so is
/// what mimics that, in whichever order they stand.
#[test]
fn what_follows_a_joint_that_is_held_is_held_too() {
    let joint = |name: &str, parent: &str, more: &str| {
        let limits = "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>";
        format!(
            "<link name=\"of_{name}\">{INERTIAL}</link><joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"of_{name}\"/>\
             <origin xyz=\"0.01 0 0.2\"/><axis xyz=\"0 0 1\"/>{limits}{more}</joint>"
        )
    };
    let mimic = |of: &str| format!("<mimic joint=\"{of}\"/>");
    let followers = [("c", "b"), ("b", "a"), ("a", "s7"), ("d", "s0")];
    let mut rest: String = followers
        .map(|(name, of)| joint(name, "base", &mimic(of)))
        .concat();
    for i in 0..8 {
        let parent = if i == 0 {
            "base".to_owned()
        } else {
            format!("of_s{}", i - 1)
        };
        rest += &joint(&format!("s{i}"), &parent, "");
        rest += &format!("<ilon_spring joint=\"s{i}\" stiffness=\"40\"/>");
    }
    let text = urdf(&format!("{INERTIAL}{DISC}"), bare, &rest).replace("_j\"", "_mecanum\"");
    let loaded = read("r.urdf", &text, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let moves: Vec<&str> = loaded.robot.joints.iter().map(|of| &of.name[..]).collect();
    let said = remarks(&loaded);
    assert!(moves.contains(&"d") && moves.contains(&"s5"), "{moves:?}");
    for (name, of) in [("a", "s7"), ("b", "a"), ("c", "b")] {
        assert!(!moves.contains(&name), "{moves:?}");
        let words = format!("joint `{name}`: held, as `{of}`, which it follows, is");
        assert!(said.contains(&words), "{said:#?}");
    }
}

/// What stands without the prefix `xacro:` in a macro is left in the expansion, and what it holds
/// is lost: a repair reads it.
#[test_case("<if value=\"1\">", "</if>", "if")]
#[test_case("<unless value=\"0\">", "</unless>", "unless")]
#[test_case("<gazebo reference=\"base\"/><if value=\"1\">", "</if>", "if"; "behind an empty element of gazebo")]
fn xacro_that_is_left_over_is_refused(open: &str, close: &str, tag: &str) {
    let text = format!(
        "<robot name=\"r\" xmlns:xacro=\"http://ros.org/wiki/xacro\">\n{BASE}<xacro:macro name=\"wheel\" params=\"name x y\">{open}<link name=\"${{name}}\">{INERTIAL}{DISC}</link>{close}\
         <joint name=\"mecanum_${{name}}\" type=\"continuous\"><parent link=\"base\"/><child link=\"${{name}}\"/><origin xyz=\"${{x}} ${{y}} 0\"/><axis xyz=\"0 1 0\"/></joint></xacro:macro>\n{}</robot>",
        PLACES
            .map(|(name, x, y)| format!("<xacro:wheel name=\"{name}\" x=\"{x}\" y=\"{y}\"/>\n"))
            .concat()
    );
    let diagnosis = diagnosed("r.xacro", &text);
    assert!(
        matches!(diagnosis.faults[0].fault(), Fault::OldXacro { tag: of } if of == tag),
        "{}",
        diagnosis.faults[0]
    );
    assert!(diagnosis.proposal.is_some_and(|options| options.repair));
    assert_eq!(diagnosis.loaded.expect("it loads").robot.wheels.len(), 4);
}

/// A macro that is called without the prefix is left in the expansion too; an element of URDF of
/// that name is no call.
#[test]
fn macros_that_are_called_without_the_prefix_are_read_by_a_repair() {
    let wheel = |call: &str| {
        format!(
            "<robot name=\"r\" xmlns:xacro=\"http://ros.org/wiki/xacro\">\n{BASE}<xacro:macro name=\"wheel\" params=\"name x y\"><link name=\"${{name}}\">{INERTIAL}{DISC}</link>\
             <joint name=\"mecanum_${{name}}\" type=\"continuous\"><parent link=\"base\"/><child link=\"${{name}}\"/><origin xyz=\"${{x}} ${{y}} 0\"/><axis xyz=\"0 1 0\"/></joint></xacro:macro>\n\
             <xacro:macro name=\"material\" params=\"name\"/><material name=\"grey\"/>{}</robot>",
            PLACES
                .map(|(name, x, y)| format!("<{call} name=\"{name}\" x=\"{x}\" y=\"{y}\"/>\n"))
                .concat()
        )
    };
    let diagnosis = diagnosed("r.xacro", &wheel("wheel"));
    assert!(
        matches!(diagnosis.faults[0].fault(), Fault::OldXacro { tag } if tag == "wheel"),
        "{}",
        diagnosis.faults[0]
    );
    assert!(diagnosis.proposal.is_some_and(|options| options.repair));
    assert_eq!(diagnosis.loaded.expect("it loads").robot.wheels.len(), 4);
    assert!(
        diagnosed("r.xacro", &wheel("xacro:wheel"))
            .faults
            .iter()
            .all(|of| { !matches!(of.fault(), Fault::OldXacro { .. }) })
    );
}

/// All wheels show one mesh, which is missing: that is one complaint, with the lines of all.
#[test]
fn a_mesh_that_all_wheels_lack_is_complained_of_once() {
    let mesh = "<visual><geometry><mesh filename=\"wheel.stl\"/></geometry></visual>";
    let text = urdf(&format!("{INERTIAL}{mesh}"), bare, "");
    let faults = RobotError::by_place(diagnosed("r.urdf", &text).faults);
    let unsized_ = faults
        .iter()
        .filter(|of| matches!(of.fault(), Fault::WheelSizeUnknown { .. }));
    let words: Vec<String> = unsized_.map(ToString::to_string).collect();
    assert_eq!(words.len(), 1, "{words:#?}");
    assert!(
        words[0].contains("link `fl`, link `fr` (line 5), link `rl` (line 7), link `rr` (line 9)"),
        "{words:#?}"
    );
}

#[test]
fn one_mesh_is_told_in_the_singular() {
    let base = BASE.replace(
        "</link>",
        "<collision><geometry><mesh filename=\"a.stl\"/></geometry></collision></link>",
    );
    let text = urdf(&format!("{INERTIAL}{DISC}"), bare, "")
        .replace(BASE, &base)
        .replace("_j\"", "_mecanum\"");
    let said =
        remarks(&read("r.urdf", &text, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}")));
    assert!(said.iter().any(|r| r == "link `base`: a collision mesh of the chassis is not read: it touches nothing there"), "{said:#?}");
}
