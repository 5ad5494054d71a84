//! Options for a robot's file: packages, repairs, and rollers for wheels without them.

use std::path::PathBuf;
use std::process::{Command, Output};

/// A base with four plain wheels, as mobile bases are usually published: the wheels' size in a mesh
/// of a package, and an impossible inertia.
const BASE: &str = r#"<robot name="base">
  <link name="base_link">
    <inertial><mass value="8"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.15"/></inertial>
    <collision><origin xyz="0 0 0.05"/><geometry><box size="0.4 0.2 0.06"/></geometry></collision>
  </link>
  WHEELS
</robot>
"#;

fn wheel(name: &str, x: f64, y: f64, geometry: &str) -> String {
    format!(
        r#"<link name="{name}_link">
    <inertial><mass value="0.5"/><inertia ixx="4e-4" ixy="0" ixz="0" iyy="6e-4" iyz="0" izz="4e-4"/></inertial>
    <collision><origin rpy="1.5707963267948966 0 0"/><geometry>{geometry}</geometry></collision>
  </link>
  <joint name="{name}" type="continuous">
    <parent link="base_link"/><child link="{name}_link"/><origin xyz="{x} {y} 0"/><axis xyz="0 1 0"/>
    <limit effort="3" velocity="20"/>
  </joint>
"#
    )
}

fn base(geometry: &str) -> String {
    let wheels: String = [
        ("fl", 0.15, 0.13),
        ("fr", 0.15, -0.13),
        ("rl", -0.15, 0.13),
        ("rr", -0.15, -0.13),
    ]
    .iter()
    .map(|(name, x, y)| wheel(name, *x, *y, geometry))
    .collect();
    BASE.replace("WHEELS", &wheels)
}

/// A disc of radius 50 mm about z as an OBJ mesh, in millimetres.
fn disc() -> String {
    let mut obj = String::from("v 0 0 0\n");
    for k in 0..36 {
        let (s, c) = (std::f64::consts::TAU * f64::from(k) / 36.0).sin_cos();
        obj.push_str(&format!("v {} {} {}\n", 50.0 * c, 50.0 * s, 0.0));
    }
    for k in 0..36 {
        obj.push_str(&format!("f 1 {} {}\n", 2 + k, 2 + (k + 1) % 36));
    }
    obj
}

struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    fn ilon(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_ilon"))
            .args(arguments)
            .current_dir(self.folder.path())
            .output()
            .unwrap()
    }
}

fn out(output: &Output) -> String {
    assert!(output.status.success(), "{}", err(output));
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn err(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_str(&out(output)).unwrap()
}

const CYLINDER: &str = r#"<cylinder radius="0.05" length="0.04"/>"#;
const MESH: &str = r#"<mesh filename="package://parts/disc.obj" scale="0.001 0.001 0.001"/>"#;

/// Sideways on mecanum wheels in X arrangement, which plain wheels could not do at all.
const SIDEWAYS: &str = "\
[robot]
file = \"../robots/base.urdf\"
packages = { parts = \"../meshes\" }

[robot.wheels]
rollers = 9
gamma.x_deg = 45

[twist]
vx_m_s = 0.0
vy_m_s = 0.1

[run]
duration_s = 4
";

#[test]
fn a_scenario_puts_rollers_into_plain_wheels_and_drives_sideways() {
    let bench = Bench::new();
    bench.write("robots/base.urdf", &base(MESH));
    bench.write("meshes/disc.obj", &disc());
    bench.write("scenarios/sideways.toml", SIDEWAYS);
    let ran = bench.ilon(&["run", "scenarios/sideways.toml", "--out", "out", "--json"]);
    let summary = json(&ran);
    // The robot moves by its contact kinematics, except for the creep of a light load: within one
    // per cent. Equation (7) takes the contact to be below the wheel's centre, while it moves along
    // each roller by up to half of its length.
    let ratio = |of: &str| summary[of]["vy"].as_f64().unwrap();
    let (contact, ideal) = (ratio("twist_ratio_contact"), ratio("twist_ratio_ideal"));
    assert!((contact - 1.0).abs() < 0.01, "{contact}");
    assert!((ideal - 1.0).abs() < 0.1, "{ideal}");
    assert!(err(&ran).contains("given 9 rollers"), "{}", err(&ran));

    // The scenario in the results folder names the same files from there.
    let again = bench.ilon(&["run", "out/scenario.toml", "--out", "again", "--json"]);
    assert_eq!(
        json(&again)["twist_ratio_ideal"],
        summary["twist_ratio_ideal"]
    );
}

#[test]
fn inspect_puts_rollers_into_plain_wheels_and_draws_them() {
    let bench = Bench::new();
    bench.write("base.urdf", &base(CYLINDER));
    let x = bench.ilon(&[
        "inspect",
        "base.urdf",
        "--mend",
        "--rollers",
        "9",
        "--gamma-x-deg",
        "45",
        "--svg",
        "base.svg",
        "--json",
    ]);
    let wheels = json(&x)["wheels"].clone();
    let gammas_deg = |wheels: &serde_json::Value| -> Vec<i64> {
        let each = wheels.as_array().unwrap().iter();
        each.map(|w| w["gamma_rad"].as_f64().unwrap().to_degrees().round() as i64)
            .collect()
    };
    assert_eq!(gammas_deg(&wheels), [-45, 45, 45, -45]);
    assert_eq!(wheels[0]["rollers"], 9);
    let svg = std::fs::read_to_string(bench.path("base.svg")).unwrap();
    let picture = roxmltree::Document::parse(&svg).unwrap();
    let texts: Vec<&str> = picture
        .descendants()
        .filter_map(|n| n.text())
        .map(str::trim)
        .collect();
    for text in ["fl", "rr", "b\u{2084}", "\u{3b3} -45.0\u{b0}"] {
        assert!(texts.contains(&text), "{text}: {texts:?}");
    }

    let each = bench.ilon(&[
        "inspect",
        "base.urdf",
        "--mend",
        "--rollers",
        "7",
        "--wheels",
        "fl,fr,rl,rr",
        "--gamma-deg",
        "-30,30,30,-45",
        "--json",
    ]);
    assert_eq!(gammas_deg(&json(&each)["wheels"]), [-30, 30, 30, -45]);

    // A wheel that is left out is a part of the chassis, and drags over the floor.
    let three = [
        "inspect",
        "base.urdf",
        "--mend",
        "--rollers",
        "7",
        "--wheels",
        "fl,fr,rr",
        "--gamma-deg",
        "-30,30,45",
    ];
    let refused = bench.ilon(&three);
    assert!(
        err(&refused).contains("touches the floor"),
        "{}",
        err(&refused)
    );

    // Rollers need an angle, and an angle needs rollers.
    for lone in [
        ["--rollers", "9"],
        ["--gamma-x-deg", "45"],
        ["--wheels", "fl"],
    ] {
        let refused = bench.ilon(&["inspect", "base.urdf", lone[0], lone[1]]);
        assert_eq!(refused.status.code(), Some(2), "{lone:?}");
    }
}

#[test]
fn the_scenario_schema_refuses_what_rollers_cannot_be() {
    let bench = Bench::new();
    bench.write("robots/base.urdf", &base(CYLINDER));
    for (wrong, told) in [
        ("robot.wheels.rollers=2", "`robot.wheels.rollers` is 2"),
        (
            "robot.wheels.gama.x_deg=45",
            "unknown key `robot.wheels.gama`",
        ),
        (
            "robot.wheels.gamma.y_deg=45",
            "unknown key `robot.wheels.gamma.y_deg`",
        ),
        ("robot.repair=perhaps", "`robot.repair` is a text"),
        ("robot.rollers=round", "`robot.rollers` cannot be \"round\""),
    ] {
        bench.write("scenarios/sideways.toml", SIDEWAYS);
        let refused = bench.ilon(&["run", "scenarios/sideways.toml", "--set", wrong]);
        assert_eq!(refused.status.code(), Some(2), "{wrong}");
        assert!(err(&refused).contains(told), "{wrong}: {}", err(&refused));
    }
}

#[test]
fn what_was_repaired_for_a_scenario_is_said() {
    let bench = Bench::new();
    let impossible = base(CYLINDER).replace("izz=\"0.15\"", "izz=\"15\"");
    bench.write("robots/base.urdf", &impossible);
    bench.write("scenarios/sideways.toml", SIDEWAYS);
    let run = |extra: &[&str]| {
        let mut arguments = vec!["run", "scenarios/sideways.toml", "--out", "out"];
        arguments.extend(extra);
        bench.ilon(&arguments)
    };
    assert_eq!(run(&[]).status.code(), Some(2));
    let repaired = run(&["--set", "robot.repair=true"]);
    assert!(repaired.status.success(), "{}", err(&repaired));
    assert!(err(&repaired).contains("repaired"), "{}", err(&repaired));
}

/// A command that a refusal proposes for twelve wheels with long names is folded into lines within
/// 240 characters; copied into a shell with its line breaks, it reads the robot. Tyres that the
/// robot cannot stand on are not proposed: the reason is given instead.
#[test]
#[cfg(unix)]
fn a_long_command_can_be_copied_into_a_shell() {
    let one = |i: usize| {
        let (name, x) = (
            format!("drive_wheel_joint_of_the_base_number_{i}"),
            (i / 2) as f64,
        );
        wheel(&name, 0.15 - 0.06 * x, [0.13, -0.13][i % 2], CYLINDER)
    };
    let robot = BASE.replace("WHEELS", &(0..12).map(one).collect::<String>());
    let bench = Bench::new();
    bench.write("robot.urdf", &robot);
    let refusal = err(&bench.ilon(&["inspect", "robot.urdf"]));
    let longest = refusal.lines().map(|line| line.chars().count()).max();
    assert!(longest <= Some(240), "{refusal}");
    let command = refusal
        .split("on tyres: `")
        .nth(1)
        .or_else(|| refusal.split("on tyres:\n").nth(1));
    let command = command
        .expect("tyres are proposed")
        .trim_start()
        .trim_start_matches('`');
    let command = command.split('`').next().expect("a command");
    assert!(command.contains(" \\\n"), "{command}");
    let folder = std::path::Path::new(env!("CARGO_BIN_EXE_ilon"))
        .parent()
        .expect("a folder");
    let path = format!(
        "{}:{}",
        folder.display(),
        std::env::var("PATH").unwrap_or_default()
    );
    let mut shell = Command::new("sh");
    shell.args(["-c", command]).env("PATH", path);
    let printed = out(&shell.current_dir(bench.folder.path()).output().unwrap());
    assert_eq!(printed.matches("  50.0   tyre").count(), 12, "{printed}");
    let longest = printed.lines().map(|line| line.chars().count()).max();
    assert!(longest <= Some(240), "{printed}");
    // Three wheels on one side of the centre of mass do not carry it.
    let wheels = [
        ("fr", 0.15, -0.13),
        ("rr", -0.15, -0.13),
        ("rl", -0.15, 0.13),
    ];
    let wheels: String = wheels
        .iter()
        .map(|(name, x, y)| wheel(name, *x, *y, CYLINDER))
        .collect();
    let heavy = BASE.replacen(
        "<inertial>",
        "<inertial><origin xyz=\"0.08 0.08 0.05\"/>",
        1,
    );
    bench.write("robot.urdf", &heavy.replace("WHEELS", &wheels));
    let refusal = err(&bench.ilon(&["inspect", "robot.urdf"]));
    assert!(
        refusal.contains("on tyres it cannot drive either: "),
        "{refusal}"
    );
    assert!(
        !refusal.contains("on tyres: `") && !refusal.contains("on tyres:\n"),
        "{refusal}"
    );
}
