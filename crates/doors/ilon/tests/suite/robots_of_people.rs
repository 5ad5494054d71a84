//! Robot files as users write them, one trait per file, in `ilon inspect`: each drives, or is
//! refused with a message and a command that works; the test runs that command.

use std::fmt::Write;
use std::path::Path;
use std::process::{Command, Output};

use test_case::test_case;

const CHASSIS: &str = r#"<link name="base_link">
  <inertial><origin xyz="0 0 0.05"/><mass value="8"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.15"/></inertial>
  <collision><origin xyz="0 0 0.05"/><geometry><box size="0.4 0.2 0.06"/></geometry></collision>
</link>
"#;
const DISC: &str = r#"<collision><origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.05" length="0.04"/></geometry></collision>"#;
const INERTIA: &str = r#"<inertia ixx="4e-4" ixy="0" ixz="0" iyy="6e-4" iyz="0" izz="4e-4"/>"#;
const PLACES: [(&str, f64, f64); 4] = [
    ("fl", 0.15, 0.13),
    ("fr", 0.15, -0.13),
    ("rl", -0.15, 0.13),
    ("rr", -0.15, -0.13),
];

/// A wheel without rollers on a continuous joint: a disc of 50 mm radius.
fn wheel(name: &str, x: f64, y: f64) -> String {
    format!(
        r#"<link name="{name}_link">
  <inertial><mass value="0.5"/>{INERTIA}</inertial>{DISC}
</link>
<joint name="{name}" type="continuous">
  <parent link="base_link"/><child link="{name}_link"/><origin xyz="{x} {y} 0"/><axis xyz="0 1 0"/>
</joint>
"#
    )
}

/// A base with four wheels, each changed, and additional content.
fn base_with(change: impl Fn(&str, String) -> String, more: &str) -> String {
    let mut text = format!("<robot name=\"base\">\n{CHASSIS}");
    for (name, x, y) in PLACES {
        text += &change(name, wheel(name, x, y));
    }
    text + more + "</robot>\n"
}

fn base() -> String {
    base_with(|_, wheel| wheel, "")
}

/// A base with a piece of each wheel replaced.
fn replaced(from: &str, to: &str) -> String {
    base_with(
        |name, wheel| {
            assert!(wheel.contains(from), "{from}");
            wheel.replace(from, &to.replace("NAME", name))
        },
        "",
    )
}

/// The same robot, called a mecanum robot.
fn called_mecanum(text: String) -> String {
    text.replacen("name=\"base\"", "name=\"mecanum_base\"", 1)
}

/// The same for one wheel.
fn one_replaced(of: &str, from: &str, to: &str) -> String {
    base_with(
        |name, wheel| {
            if name == of {
                wheel.replace(from, to)
            } else {
                wheel
            }
        },
        "",
    )
}

/// Wheels on a ring that face outward, which need rollers at 0 degrees.
fn ring() -> String {
    let mut text = format!("<robot name=\"base\">\n{CHASSIS}");
    for i in 0..3 {
        let angle = std::f64::consts::TAU * f64::from(i) / 3.0;
        let (s, c) = angle.sin_cos();
        let place = format!("xyz=\"{} {} 0\"", 0.15 * c, 0.15 * s);
        let turned = format!(
            "{place} rpy=\"0 0 {}\"",
            angle - std::f64::consts::FRAC_PI_2
        );
        text += &wheel(&format!("wheel_{i}"), 0.15 * c, 0.15 * s).replace(&place, &turned);
    }
    text + "</robot>\n"
}

/// An arm of six joints, the first of which is vertical.
fn arm() -> String {
    let mut text = format!("<robot name=\"arm\">\n{CHASSIS}");
    let axes = ["0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0"];
    let mut parent = "base_link".to_owned();
    for (i, axis) in axes.iter().enumerate() {
        let child = format!("part_{i}");
        write!(
            text,
            r#"<link name="{child}"><inertial><mass value="1"/>{INERTIA}</inertial>{DISC}</link>
<joint name="joint_{i}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="0 0 0.2"/><axis xyz="{axis}"/>
  <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
"#
        )
        .unwrap();
        parent = child;
    }
    text + "</robot>\n"
}

/// A robot with a part on its chassis that turns like a wheel, high above the floor.
fn with_mimic_arm() -> String {
    let arm = wheel("finger", 0.0, 0.0)
        .replace("xyz=\"0 0 0\"", "xyz=\"0 0 0.3\"")
        .replace(
            "<axis xyz=\"0 1 0\"/>",
            "<axis xyz=\"0 1 0\"/><mimic joint=\"fl\"/>",
        );
    base_with(|_, wheel| wheel, &arm)
}

/// Each wheel is on a vertical joint that steers it.
fn steered() -> String {
    base_with(
        |name, wheel| {
            let fork = format!(
                r#"<link name="{name}_fork"><inertial><mass value="0.1"/>{INERTIA}</inertial></link>
<joint name="{name}_steer" type="continuous"><parent link="base_link"/><child link="{name}_fork"/>"#
            );
            let place = wheel.find("<origin xyz").unwrap();
            let end = place + wheel[place..].find("/>").unwrap() + 2;
            let origin = wheel[place..end].to_owned();
            let below = wheel
                .replace(
                    "<parent link=\"base_link\"/>",
                    &format!("<parent link=\"{name}_fork\"/>"),
                )
                .replace(&origin, "<origin xyz=\"0 0 0\"/>");
            format!("{fork}{origin}<axis xyz=\"0 0 1\"/></joint>\n{below}")
        },
        "",
    )
}

fn xacro(inside: &str) -> String {
    let start = "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" ";
    base()
        .replacen("<robot ", start, 1)
        .replace("</robot>", &format!("{inside}</robot>"))
}

/// The outcome for a file.
#[derive(Debug)]
enum Becomes {
    /// A robot, with a remark.
    Robot(&'static str),
    /// Refused with this message and a working command, whose robot has this remark.
    Proposal(&'static str, &'static str),
    /// Refused with this message, which asks for the rollers of plain wheels. Once they are given,
    /// and a proposed command is followed, the robot has this remark.
    Asks(&'static str, &'static str),
    /// Refused with this message, which asks for information that only the user has.
    Refused(&'static str),
}
use Becomes::{Asks, Proposal, Refused, Robot};

const BARE: &str = "4 wheels without rollers: `fl`, `fr`, `rl`, `rr`";

#[test_case(base(), Asks(BARE, "given 12 rollers"); "plain wheels")]
#[test_case(
    replaced("continuous", "fixed"),
    Asks(BARE, "its joint does not turn in the file");
    "fixed wheels"
)]
#[test_case(
    replaced("<axis", "<limit lower=\"0\" upper=\"6.28\" effort=\"3\" velocity=\"20\"/><axis").replace("continuous", "revolute"),
    Asks(BARE, "given 12 rollers");
    "wheels within a turn"
)]
#[test_case(
    replaced("<axis", "<limit lower=\"-1e16\" upper=\"1e16\" effort=\"3\" velocity=\"20\"/><axis").replace("continuous", "revolute"),
    Asks(BARE, "given 12 rollers");
    "wheels within huge limits"
)]
#[test_case(
    replaced("<axis", "<mimic joint=\"fl\"/><axis"),
    Asks(BARE, "its joint follows another joint in the file");
    "wheels that mimic"
)]
#[test_case(
    with_mimic_arm(),
    Asks(BARE, "no wheel: stands 300 mm above the floor");
    "an arm that mimics"
)]
#[test_case(
    steered(),
    Robot("so they are given tyres: some of them are steered");
    "steered wheels"
)]
#[test_case(
    replaced(
        "<cylinder radius=\"0.05\" length=\"0.04\"/>",
        "<sphere radius=\"0.05\"/>"
    ),
    Asks(BARE, "given 12 rollers");
    "spheres"
)]
#[test_case(
    replaced("collision", "visual"),
    Asks(BARE, "its size is taken from what is shown of it");
    "what is only shown"
)]
#[test_case(
    replaced("<inertial>", "<visual><geometry><sphere radius=\"0.1\"/></geometry></visual><inertial>")
        .replace("</link>", "<visual><geometry><sphere radius=\"0.1\"/></geometry></visual></link>"),
    Asks(BARE, "given 12 rollers");
    "visuals apart"
)]
#[test_case(
    replaced(
        "<axis",
        "<limit effort=\"3\" velocity=\"20\"/><limit effort=\"9\" velocity=\"9\"/><axis"
    ),
    Asks(BARE, "stands here a second time: the first is read");
    "two limits"
)]
#[test_case(ring(), Robot("at gamma = 0.0 deg"); "a ring of omni wheels")]
#[test_case(
    one_replaced("fl", " 0\"/><axis", " 0.001\"/><axis"),
    Asks(BARE, "its wheels do not reach equally low");
    "a wheel a millimetre high"
)]
#[test_case(
    base().replace("xyz=\"0 0 0.05\"", "xyz=\"1 0 0.05\"").replace("xyz=\"0.15", "xyz=\"1.15").replace("xyz=\"-0.15", "xyz=\"0.85"),
    Asks(BARE, "the robot's frame lies 1000 mm from the middle of its wheels and outside them");
    "a frame beside the wheels"
)]
#[test_case(
    replaced(INERTIA, ""),
    Asks("the element `<inertia>` is missing", "repaired: its inertia");
    "no inertia"
)]
#[test_case(
    replaced(&format!("<inertial><mass value=\"0.5\"/>{INERTIA}</inertial>"), ""),
    Asks(BARE, "repaired: its mass and inertia");
    "no inertial"
)]
#[test_case(
    replaced("iyy=\"6e-4\"", "iyy=\"6e-2\""),
    Asks("no body has the principal moments", "repaired: its inertia");
    "impossible inertia"
)]
#[test_case(
    replaced(&format!("<mass value=\"0.5\"/>{INERTIA}"), r#"<mass value="1e-5"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>"#),
    Asks(BARE, "repaired: its inertia");
    "inertia beyond its size"
)]
#[test_case(
    base().replacen(&format!("<mass value=\"8\"/>{}", r#"<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.15"/>"#), r#"<mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>"#, 1),
    Asks(BARE, "repaired: its mass and inertia");
    "a chassis that weighs nothing"
)]
#[test_case(
    called_mecanum(base().replace(CHASSIS, "<link name=\"base_link\"/>\n")),
    Refused("neither it nor anything fixed to it has mass");
    "a chassis of nothing"
)]
#[test_case(
    base_with(|_, wheel| wheel, &wheel("fl", 0.0, 0.13)),
    Asks("the name is taken by the link on line", "called `fl_2`, for its name is taken");
    "a wheel twice"
)]
#[test_case(
    base().replace("</robot>", &format!("{CHASSIS}</robot>")),
    Asks("the name is taken by the link on line", "left out, for it says the same as the first of its name");
    "the same link twice"
)]
#[test_case(
    called_mecanum(replaced(
        DISC,
        "<collision><geometry><mesh filename=\"wheel.stl\"/></geometry></collision>"
    )),
    Refused("no two kinds of clues agree on one: its inertia about its axis, as that of a solid disc (49 mm)");
    "a mesh that is not there"
)]
#[test_case(
    called_mecanum(replaced(DISC, &format!("{}<collision><geometry><mesh filename=\"wheel.stl\"/></geometry></collision>", DISC.replace("0.05", "0.0279")))),
    Refused("what can be read of its shapes (27.9 mm), its inertia about its axis, as that of a solid disc (49 mm)");
    "one of two shapes that is not there"
)]
#[test_case(
    called_mecanum(replaced(
        DISC,
        "<collision><geometry><mesh filename=\"package://absent/wheel.stl\"/></geometry></collision>"
    )),
    Refused("--package absent=FOLDER`; fill in the wheels' radius in METRES: `ilon inspect robot.urdf --rollers 12 --gamma-x-deg 45 --wheels");
    "a mesh of an absent package"
)]
#[test_case(
    called_mecanum(replaced(
        DISC,
        "<collision><geometry><mesh filename=\"wheel_98mm.stl\"/></geometry></collision>"
    )),
    Proposal(
        "49 mm is what two or more clues agree on: the name `wheel_98mm.stl` (49 or 98 mm), its inertia",
        "49.0 mm as given; for it speak the name `wheel_98mm.stl`"
    );
    "a mesh that is not there and says its size"
)]
#[test_case(
    replaced(DISC, "<collision><geometry><mesh filename=\"wheel.stl\"/></geometry></collision>"),
    Asks(
        "their ANGLE (45 of usual mecanum wheels, 0 of omni wheels) and the wheels' radius in METRES",
        "50.0 mm as given"
    );
    "meshes that are not there, of wheels of no kind"
)]
#[test_case(
    one_replaced("fl", DISC, "<collision><geometry><mesh filename=\"wheel_98mm.stl\"/></geometry></collision>")
        .replace(DISC, "<collision><geometry><mesh filename=\"wheel.stl\"/></geometry></collision>"),
    Asks("their ANGLE (45 of usual mecanum wheels, 0 of omni wheels):", "49.0 mm as given");
    "meshes that are not there, one of which says its size"
)]
#[test_case(
    called_mecanum(replaced("<axis xyz=\"0 1 0\"/>", "")),
    Proposal(
        "its joint states no `<axis>`, so that it turns about x, across which its cylinder lies",
        "its joint states no `<axis>`: 0 1 0, along its cylinder"
    );
    "joints without an axis"
)]
#[test_case(
    xacro("<xacro:include filename=\"arm.xacro\"/>"),
    Asks(
        "1 file that it names cannot be found: `arm.xacro` at robot.urdf:30 help: put the files there, or go without them;",
        "left out"
    );
    "an include that is not there"
)]
#[test_case(
    xacro("<xacro:include filename=\"$(find absent)/arm.xacro\"/>"),
    Asks(
        "1 file that it names cannot be found: `$(find absent)/arm.xacro` at robot.urdf:30 (no folder of the package `absent` is known) \
         help: say where the packages lie, or go without them; say `--package absent=FOLDER`;",
        "left out, for the folder of the package `absent` is not known"
    );
    "an include of an absent package"
)]
#[test_case(
    base().replace("base_link", "chassis").replace("<robot name=\"base\">", &format!(
        "<robot name=\"base\"><link name=\"base_link\"/><joint name=\"base_joint\" type=\"fixed\"><parent link=\"base_link\"/><child link=\"chassis\"/></joint>\
         <link name=\"turret\"><inertial><mass value=\"1\"/>{INERTIA}</inertial></link>\
         <joint name=\"yaw\" type=\"continuous\"><parent link=\"chassis\"/><child link=\"turret\"/><origin xyz=\"0 0 0.2\"/><axis xyz=\"0 0 1\"/></joint>"
    )),
    Asks(BARE, "given 12 rollers");
    "a turret beside the wheels of a chassis that is fixed"
)]
#[test_case(arm(), Refused("no wheels with passive rollers"); "an arm of six joints")]
#[test_case(
    format!("<robot name=\"base\">{CHASSIS}</robot>"),
    Refused("no wheels with passive rollers, but moving freely in the plane takes three");
    "no wheels"
)]
#[test_case(
    xacro(
        "<xacro:include filename=\"$(find sensors)/a.xacro\"/><xacro:include filename=\"$(find cameras)/b.xacro\"/><xacro:lidar/>"
    ),
    Asks(
        "`--package sensors=FOLDER`, `--package cameras=FOLDER`",
        "left out, for nothing that could be read defines this macro"
    );
    "includes of absent packages"
)]
#[test_case(
    xacro("<xacro:arg name=\"kind\"/><link name=\"$(arg kind)\"/>"),
    Refused("fill in VALUE, the NUMBER of rollers on a wheel and their ANGLE");
    "an argument without a value"
)]
#[test_case(
    "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:macro name=\"w\" params=\"n\"><link name=\"${n}\"/></xacro:macro></robot>".to_owned(),
    Refused("it defines macros and makes no link: `w`");
    "macros alone"
)]
#[test_case(
    "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" name=\"b\"><xacro:include filename=\"$(find absent)/b.xacro\"/><xacro:arg name=\"sim\"/><xacro:base sim=\"$(arg sim)\"/></robot>".to_owned(),
    Refused("help: say where the packages lie, or go without them; say `--package absent=FOLDER`");
    "an absent package and an argument without a value"
)]
#[test_case(
    called_mecanum(xacro("").replacen(&wheel("fl", 0.15, 0.13), &format!(
        "<xacro:macro name=\"wheel\" params=\"name\">{}</xacro:macro><wheel name=\"fl\"/>",
        wheel("${name}", 0.15, 0.13)
    ), 1)),
    Proposal(
        "a xacro file of before 2014: `<wheel>` stands without the prefix `xacro:`",
        "elements without the prefix `xacro:` are read as until 2014"
    );
    "a macro that is called without the prefix"
)]
#[test_case(
    xacro("").replacen(&wheel("fl", 0.15, 0.13), &format!(
        "<xacro:macro name=\"mecanum_wheel\" params=\"name\">{}</xacro:macro><xacro:mecanum_wheel name=\"fl\"/>",
        wheel("${name}", 0.15, 0.13)
    ), 1),
    Robot("`mecanum_wheel`");
    "wheels by a macro that names their kind"
)]
#[test_case(
    xacro("").replacen(&wheel("fl", 0.15, 0.13), &format!(
        "<xacro:macro name=\"mecanum_sensor\" params=\"name\"><link name=\"${{name}}\"/></xacro:macro>\
         <xacro:macro name=\"wheel\" params=\"name\">{}</xacro:macro><xacro:wheel name=\"fl\"/>",
        wheel("${name}", 0.15, 0.13)
    ), 1),
    Asks(BARE, "given 12 rollers");
    "wheels by a macro of no kind"
)]
#[test_case(
    format!("<robot name=\"old\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><include filename=\"wheels.xacro\"/>{CHASSIS}</robot>"),
    Refused("a xacro file of before 2014: `<include>` stands without the prefix `xacro:`");
    "xacro without prefixes"
)]
fn a_robot_drives_or_is_refused_with_a_command_that_works(text: String, becomes: Becomes) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("robot.urdf");
    std::fs::write(&path, text).unwrap();
    let first = shell(folder.path(), "ilon inspect robot.urdf");
    match becomes {
        Robot(remark) => drives(&first, remark),
        Proposal(words, remark) => {
            let refusal = refused(&first, words);
            let proposal =
                proposed(&refusal).unwrap_or_else(|| panic!("nothing proposed: {refusal}"));
            drives(&shell(folder.path(), proposal), remark);
            // It also works in a scenario, as keys.
            let scenario =
                "[robot]\nfile = \"robot.urdf\"\n[twist]\nvy_m_s = 0.1\n[run]\nduration_s = 0.2\n";
            std::fs::write(folder.path().join("s.toml"), scenario).unwrap();
            let refusal = refused(&shell(folder.path(), "ilon run s.toml"), "");
            let keys = proposed_keys(&refusal);
            assert!(!keys.is_empty(), "{refusal}");
            let keys = format!("[robot]\n{}\n", keys.join("\n"));
            std::fs::write(
                folder.path().join("s.toml"),
                scenario.replacen("[robot]\n", &keys, 1),
            )
            .unwrap();
            let ran = shell(folder.path(), "ilon run s.toml --out out");
            assert!(ran.status.success(), "{keys}\n{}", err(&ran));
        }
        Asks(words, remark) => {
            let refusal = refused(&first, words);
            assert_eq!(proposed(&refusal), None, "{refusal}");
            // One round: the requested information, filled in, gives a working command; and so does
            // that for tyres, which asks for no more than the radius.
            let refusal = in_one_line(&refusal);
            let (rollers, tyres) = refusal.split_once("; on tyres: `").unzip();
            let asked = filled(rollers.unwrap_or(&refusal));
            let [command] = &asked[..] else {
                panic!("{asked:?}")
            };
            if let Some((command, _)) = tyres.and_then(|tyres| tyres.split_once('`')) {
                drives(&shell(folder.path(), &answered(command)), "tyre");
            }
            let output = shell(folder.path(), command);
            drives(&output, remark);
            // A scenario asks for the same as keys.
            let scenario =
                "[robot]\nfile = \"robot.urdf\"\n[twist]\nvy_m_s = 0.1\n[run]\nduration_s = 0.2\n";
            let path = folder.path().join("s.toml");
            std::fs::write(&path, scenario).unwrap();
            let refusal = in_one_line(&refused(&shell(folder.path(), "ilon run s.toml"), ""));
            let rollers = refusal
                .split_once("; on tyres: `")
                .map(|(rollers, _)| rollers);
            let asked = filled(rollers.unwrap_or(&refusal));
            let keys = format!("[robot]\n{}\n", asked.join("\n"));
            let scenario = scenario.replacen("[robot]\n", &keys, 1);
            std::fs::write(&path, &scenario).unwrap();
            let ran = shell(folder.path(), "ilon run s.toml --out out");
            assert!(ran.status.success(), "{keys}\n{}", err(&ran));
        }
        Refused(words) => {
            let refusal = refused(&first, words);
            assert_eq!(proposed(&refusal), None, "{refusal}");
        }
    }
}

/// Runs a command line in a shell.
fn shell(folder: &Path, command: &str) -> Output {
    let ilon = Path::new(env!("CARGO_BIN_EXE_ilon")).parent().unwrap();
    let path = std::env::var("PATH").unwrap_or_default();
    Command::new("sh")
        .args(["-c", command])
        .current_dir(folder)
        .env("PATH", format!("{}:{path}", ilon.display()))
        .output()
        .unwrap()
}

fn err(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The text without the breaks of folded lines.
fn in_one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn drives(output: &Output, remark: &str) {
    assert!(output.status.success(), "{}", err(output));
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(in_one_line(&said).contains(remark), "{said}");
}

fn refused(output: &Output, words: &str) -> String {
    let said = err(output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(output.stdout.is_empty());
    assert!(in_one_line(&said).contains(words), "{said}");
    said
}

fn proposed(refusal: &str) -> Option<&str> {
    Some(refusal.split_once("this works: `")?.1.split_once('`')?.0)
}

/// The commands, or the keys, that a refusal asks to complete, with twelve rollers at 45 degrees
/// on wheels of 50 mm filled in.
fn filled(refusal: &str) -> Vec<String> {
    let (_, blanks) = refusal
        .split_once("fill in ")
        .unwrap_or_else(|| panic!("nothing asked: {refusal}"));
    let (_, asked) = blanks.split_once(": `").unwrap();
    let asked = asked.lines().next().unwrap_or_default();
    let each = format!("`{asked}");
    let each = each.split('`').skip(1).step_by(2);
    each.map(answered).collect()
}

fn answered(asked: &str) -> String {
    let answers = [("NUMBER", "12"), ("ANGLE", "45"), ("METRES", "0.05")];
    let fill = |text: String, (blank, value): (&str, &str)| text.replace(blank, value);
    answers.into_iter().fold(asked.to_owned(), fill)
}

fn proposed_keys(refusal: &str) -> Vec<&str> {
    let Some((_, keys)) = refusal.split_once("this works, in `[robot]`: ") else {
        return Vec::new();
    };
    let keys = keys.lines().next().unwrap_or_default();
    keys.split('`').skip(1).step_by(2).collect()
}

#[test]
fn a_file_that_is_called_xacro_is_expanded_whatever_stands_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = "<visual><geometry><mesh filename=\"file://$(find absent)/wheel.stl\"/></geometry></visual>";
    let text = replaced("<inertial>", &format!("{mesh}<inertial>"));
    for (name, is_expanded) in [("robot.xacro", true), ("robot.urdf", false)] {
        std::fs::write(folder.path().join(name), &text).unwrap();
        let command = format!("ilon inspect {name} --rollers 12 --gamma-x-deg 45");
        let output = shell(folder.path(), &command);
        drives(&output, "given 12 rollers");
        // Only xacro evaluates `$(find ...)`; in a URDF it is a part of a name.
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        let remark = "the folder of the package `absent` is not known";
        assert_eq!(said.contains(remark), is_expanded, "{name}: {said}");
    }
}
