//! Untrusted scenarios and robots: which files they may read, which content is shown, and the
//! effect of their names in a log.

use crate::support;

use std::fs;

use support::{FAILS, Folder, HOLDS, ended_with};

/// The content of a secret file of the machine, in a form that no robot, scenario or path has.
const SECRET: &str = "root:x:0:0:SECRET:/root:/bin/bash\nTOKEN=SECRET\n";

const CIRCLE: &str = "\n[reference.waypoints]\nfile = \"FILE\"\nspeed_m_s = 0.1\n";

/// A folder with a readable part, `in`, which holds a valid scenario and its robot, and a secret
/// beside it.
fn confined() -> Folder {
    let folder = Folder::new();
    folder.write("in/robot.urdf", &folder.read("robot.urdf"));
    folder.write("secret", SECRET);
    scenario(&folder, "robot.urdf", "", HOLDS);
    folder
}

/// Writes `in/s.toml`, with its robot, further keys of that section, and further text.
fn scenario(folder: &Folder, robot: &str, of_robot: &str, further: &str) {
    let text = format!(
        "[robot]\nfile = \"{robot}\"\n{of_robot}\n[twist]\nvx_m_s = 0.2\nrest_s = 0.1\nramp_s = 0.1\nsettle_s = 0.1\n\
         [run]\nduration_s = 0.5\n{further}"
    );
    folder.write("in/s.toml", &text);
}

/// Writes `in/i.toml`: a study that takes a file for a log.
fn study(folder: &Folder, file: &str) {
    let wheels: String = (1..=3)
        .map(|wheel| format!("wheel_{wheel} = {{ column = \"w{wheel}\", unit = \"rad\" }}\n"))
        .collect();
    let text = format!(
        "robot = \"robot.urdf\"\n[log]\ntime = {{ column = \"root\", unit = \"s\" }}\nx = {{ column = \"x\", unit = \"m\" }}\n\
         y = {{ column = \"y\", unit = \"m\" }}\nheading = {{ column = \"h\", unit = \"rad\" }}\n[log.bag]\npose = \"/pose\"\n\
         [log.wheels]\n{wheels}[[runs]]\nfile = \"{file}\"\n"
    );
    folder.write("in/i.toml", &text);
}

fn waypoints(folder: &Folder, file: &str) {
    let text = format!(
        "[robot]\nfile = \"robot.urdf\"\n{}\n[run]\nduration_s = 0.5\n",
        CIRCLE.replace("FILE", file)
    );
    folder.write("in/s.toml", &text);
}

#[test]
fn in_a_sandbox_what_lies_inside_runs() {
    let folder = confined();
    ended_with(0, &folder.ilon(&["run", "in/s.toml", "--sandbox", "in"]));
    ended_with(0, &folder.ilon(&["check", "in", "--sandbox", "in"]));
    ended_with(
        0,
        &folder.ilon(&["inspect", "in/robot.urdf", "--sandbox", "in"]),
    );
    ended_with(
        0,
        &folder.ilon(&["compare", "in/s.toml", "in/s.toml", "--sandbox", "in"]),
    );
    // Several folders, and one above.
    scenario(&folder, "../robot.urdf", "", HOLDS);
    ended_with(0, &folder.ilon(&["check", "in", "--sandbox", "."]));
    folder.write("robots/robot.urdf", &folder.read("robot.urdf"));
    scenario(&folder, "../robots/robot.urdf", "", HOLDS);
    ended_with(
        0,
        &folder.ilon(&["check", "in", "--sandbox", "in", "--sandbox", "robots"]),
    );
    let told = ended_with(2, &folder.ilon(&["check", "in", "--sandbox", "nowhere"]));
    assert!(
        told.contains("--sandbox cannot be the folder `nowhere`"),
        "{told}"
    );
}

#[test]
fn nothing_that_a_scenario_names_is_read_outside_of_its_sandbox() {
    let folder = confined();
    let sandbox = ["check", "in", "--sandbox", "in", "--junit", "j.xml"];
    let refused = |what: &str| {
        let told = ended_with(2, &folder.ilon(&sandbox));
        assert!(
            told.contains("it lies outside of what may be read here"),
            "{what}: {told}"
        );
        for shown in [told, folder.read("j.xml")] {
            assert!(!shown.contains("SECRET"), "{what}: {shown}");
        }
    };
    let absolute = folder.path("robot.urdf").display().to_string();
    for robot in [
        "../robot.urdf",
        "../secret",
        "../in/../secret",
        "/proc/self/environ",
        &absolute,
    ] {
        scenario(&folder, robot, "", HOLDS);
        refused(robot);
    }
    for file in ["../secret", "/proc/self/environ", "/etc/passwd"] {
        waypoints(&folder, file);
        refused(file);
    }
    #[cfg(unix)]
    {
        let link = folder.path("in/link.urdf");
        std::os::unix::fs::symlink(folder.path("robot.urdf"), link).expect("a link");
        scenario(&folder, "link.urdf", "", HOLDS);
        refused("a link");
    }
    // Meshes, by every way that a robot can name one.
    let meshes = folder.path("secret").display().to_string();
    let mesh = format!("file://{meshes}.stl");
    folder.write("secret.stl", "solid a\nendsolid a\n");
    for (mesh, of_robot) in [
        ("../secret.stl", ""),
        (mesh.as_str(), ""),
        ("package://p/secret.stl", "packages = { p = \"..\" }"),
    ] {
        let urdf = folder.read("robot.urdf");
        let start = urdf.find("<sphere").expect("rollers are stacks of spheres");
        let end = start + urdf[start..].find("/>").expect("it is closed") + 2;
        let with_mesh = urdf.replace(&urdf[start..end], &format!("<mesh filename=\"{mesh}\"/>"));
        folder.write("in/mesh.urdf", &with_mesh);
        scenario(&folder, "mesh.urdf", of_robot, HOLDS);
        refused(mesh);
    }
}

#[test]
fn of_files_of_another_kind_nothing_is_shown() {
    let folder = confined();
    let secrets = |arguments: &[&str]| {
        let output = folder.command(arguments).env("TOKEN", "SECRET").output();
        let told = ended_with(2, &output.expect("the command runs"));
        assert!(!told.contains("SECRET"), "{arguments:?}: {told}");
        if folder.path("j.xml").exists() {
            assert!(!folder.read("j.xml").contains("SECRET"));
        }
    };
    let check = ["check", "in/s.toml", "--junit", "j.xml"];
    let settings = "<?xml version=\"1.0\"?>\n<servers>\n<password>SECRET</password>\n</servers>\n";
    folder.write("settings.xml", settings);
    folder.write("credentials.toml", "[registry]\ntoken = \"SECRET\"\n");
    let foreign = [
        "../secret",
        "../settings.xml",
        "../credentials.toml",
        "/proc/self/environ",
    ];
    for file in foreign {
        scenario(&folder, file, "", HOLDS);
        secrets(&check);
        secrets(&["run", "in/s.toml"]);
        waypoints(&folder, file);
        secrets(&check);
    }
    folder.write(
        "secret.csv",
        "root,SECRET,x,y,h\nSECRET,two,three,four,five\n",
    );
    for file in foreign.into_iter().chain(["../secret.csv"]) {
        study(&folder, file);
        secrets(&["identify", "in/i.toml"]);
    }
    // As a scenario itself, through a link.
    for file in [
        "secret",
        "settings.xml",
        "credentials.toml",
        "/proc/self/environ",
    ] {
        let link = folder.path("link.toml");
        let _ = fs::remove_file(&link);
        #[cfg(unix)]
        std::os::unix::fs::symlink(folder.path(file), &link).expect("a link");
        secrets(&["check", "link.toml", "--junit", "j.xml"]);
        secrets(&["generate", "link.toml"]);
    }
}

#[cfg(unix)]
#[test]
fn a_link_that_leads_out_of_a_folder_of_scenarios_is_told_and_not_followed() {
    let folder = Folder::new();
    folder.scenario("in/a.toml", HOLDS);
    folder.scenario("out/b.toml", FAILS);
    std::os::unix::fs::symlink(folder.path("out/b.toml"), folder.path("in/link.toml"))
        .expect("a link");
    std::os::unix::fs::symlink(folder.path("out"), folder.path("in/folder")).expect("a link");
    std::os::unix::fs::symlink(folder.path("in"), folder.path("in/loop")).expect("a link");
    std::os::unix::fs::symlink(folder.path("in/a.toml"), folder.path("in/z.toml")).expect("a link");
    let told = ended_with(2, &folder.ilon(&["check", "in"]));
    assert!(told.contains("held   a "), "{told}");
    for link in ["link", "folder"] {
        assert!(told.contains(&format!("ERROR  {link}: ")), "{told}");
    }
    // Each file once, however it is found.
    assert!(
        !told.contains("FAILED") && !told.contains("held   z"),
        "{told}"
    );
}

#[test]
fn names_from_files_do_nothing_to_a_terminal_and_forge_no_line_of_a_log() {
    let folder = Folder::new();
    let evil =
        "\\u001b[2J\\n::add-mask::held\\nheld   everything (0.1 s, 9 bounds)\\n##[error]x\\u202e";
    folder.scenario(
        "wheel.toml",
        &format!("[[faults]]\nmotor_lost = {{ wheel = \"{evil}\" }}\n"),
    );
    folder.scenario("key.toml", &format!("[\"{evil}\"]\n"));
    folder.scenario(
        "signal.toml",
        &format!("[[expect.signals]]\nsignal = \"{evil}\"\nmax = 1\n"),
    );
    let robot = folder.read("robot.urdf");
    let joint = "a&#27;[2J&#10;::error::forged&#10;##[error]x";
    let renamed = robot.replacen("name=\"wheel_1\"", &format!("name=\"{joint}\""), 2);
    assert_ne!(renamed, robot, "the robot has such a joint");
    folder.write("evil.urdf", &renamed);
    let file = format!("[robot]\nfile = \"{evil}.urdf\"\n[twist]\n[run]\nduration_s = 1\n");
    folder.write("file.toml", &file);
    let text = folder.read("good.toml").replace("robot.urdf", "evil.urdf");
    folder.write("robot.toml", &text);
    let all: [&[&str]; 10] = [
        &["run", "wheel.toml"],
        &["run", "key.toml"],
        &["run", "signal.toml"],
        &["run", "file.toml"],
        &["run", "robot.toml"],
        &["check", ".", "--junit", "j.xml"],
        &["inspect", "evil.urdf"],
        &["inspect", "evil.urdf", "--as-modelled"],
        &["compare", "robot.toml", "good.toml"],
        &[
            "bench",
            "--robot",
            "evil.urdf",
            "--rates",
            "20",
            "--rounds",
            "1",
            "--headings",
            "0",
        ],
    ];
    for arguments in all {
        let output = folder.ilon(arguments);
        for stream in [&output.stdout, &output.stderr] {
            assert_harmless(&String::from_utf8_lossy(stream), arguments);
        }
    }
    let junit = folder.read("j.xml");
    assert_harmless(&junit, &["j.xml"]);
}

fn assert_harmless(printed: &str, by: &[&str]) {
    let acts = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
    assert!(!printed.contains(acts), "{by:?}: {printed}");
    for line in printed.lines() {
        let line = line.trim_start();
        assert!(
            !line.starts_with("::") && !line.contains("##["),
            "{by:?}: {printed}"
        );
        assert!(!line.starts_with("held   everything"), "{by:?}: {printed}");
    }
}

#[cfg(unix)]
#[test]
fn a_file_name_of_several_lines_stays_in_one() {
    let folder = Folder::new();
    let name = "a\n::error::forged\u{1b}[2J.toml";
    folder.scenario(name, HOLDS);
    folder.scenario(&format!("sub\n::error::b/{name}"), FAILS);
    for arguments in [
        &["run", name][..],
        &["check", name, "--junit", "j.xml"],
        &["check", ".", "--keep", "kept", "--save", "saved"],
        &["run", name, "--out", "x\n::error::y"],
        &["run", "nowhere\n::error::z"],
        &["check", "."],
    ] {
        let output = folder.ilon(arguments);
        for stream in [&output.stdout, &output.stderr] {
            assert_harmless(&String::from_utf8_lossy(stream), arguments);
        }
    }
    assert_harmless(&folder.read("j.xml"), &["j.xml"]);
}

#[test]
fn a_name_that_leads_out_of_a_folder_is_refused() {
    let folder = Folder::new();
    for name in ["...toml", "..toml"] {
        folder.scenario(name, FAILS);
        for arguments in [
            &["run", name][..],
            &["check", name, "--keep", "kept"],
            &["check", name, "--save", "kept"],
        ] {
            let before = folder.names(".");
            let told = ended_with(2, &folder.ilon(arguments));
            assert!(told.contains("which means another folder"), "{told}");
            let mut after = folder.names(".");
            after.retain(|name| name != "kept");
            let before: Vec<_> = before.into_iter().filter(|name| name != "kept").collect();
            assert_eq!(after, before);
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_never_ends_or_is_very_large_is_refused_at_once() {
    let folder = Folder::new();
    let made = std::process::Command::new("mkfifo")
        .args(["pipe.toml", "pipe.urdf", "pipe.csv", "pipe.parquet"].map(|name| folder.path(name)))
        .status();
    assert!(made.expect("mkfifo").success());
    for (name, size) in [
        ("big.toml", 1 << 30),
        ("big.csv", 1 << 30),
        ("big.urdf", 1 << 30),
    ] {
        let file = fs::File::create(folder.path(name)).expect("a file");
        file.set_len(size).expect("a hole");
    }
    let robot = "[robot]\nfile = \"robot.urdf\"\n";
    let run = "[run]\nduration_s = 0.5\n";
    for name in ["big", "pipe"] {
        let waypoints = CIRCLE.replace("FILE", &format!("{name}.csv"));
        folder.write(
            &format!("{name}_way.toml"),
            &format!("{robot}{waypoints}{run}"),
        );
        let text = folder
            .read("good.toml")
            .replace("robot.urdf", &format!("{name}.urdf"));
        folder.write(&format!("{name}_robot.toml"), &text);
    }
    fs::create_dir(folder.path("base")).expect("a folder");
    fs::rename(
        folder.path("pipe.parquet"),
        folder.path("base/good.parquet"),
    )
    .expect("moved");
    for (name, file) in [
        ("kernel", "/proc/kmsg"),
        ("device", "/dev/zero"),
        ("pipe", "../pipe.csv"),
    ] {
        study(&folder, file);
        fs::rename(
            folder.path("in/i.toml"),
            folder.path(&format!("in/{name}.toml")),
        )
        .expect("moved");
    }
    fs::copy(folder.path("robot.urdf"), folder.path("in/robot.urdf")).expect("copied");
    let all: [&[&str]; 17] = [
        &["identify", "in/kernel.toml"],
        &["identify", "in/device.toml"],
        &["identify", "in/pipe.toml"],
        &["run", "/proc/kmsg"],
        &["run", "pipe.toml"],
        &["run", "/dev/zero"],
        &["run", "big.toml"],
        &["check", "pipe.toml"],
        &["generate", "pipe.toml"],
        &["generate", "big.toml"],
        &["inspect", "pipe.urdf"],
        &["run", "pipe_way.toml"],
        &["run", "pipe_robot.toml"],
        &["run", "big_way.toml"],
        &["run", "big_robot.toml"],
        &["check", "good.toml", "--against", "base"],
        &["compare", "base/good.parquet", "good.toml"],
    ];
    for arguments in all {
        let told = ended_with(2, &folder.ilon(arguments));
        assert!(
            ["a pipe", "a device", "MB", "a view into the kernel"]
                .iter()
                .any(|why| told.contains(why)),
            "{arguments:?}: {told}"
        );
    }
}

#[test]
fn one_line_files_of_any_length_are_refused_with_the_place_at_fault() {
    let folder = Folder::new();
    let blanks = " ".repeat(70_000);
    folder.write(
        "line.urdf",
        &format!("<robot name=\"x\">{blanks}<link/></robot>"),
    );
    let told = ended_with(2, &folder.ilon(&["inspect", "line.urdf"]));
    assert!(
        told.contains("[line.urdf:1:70017]") && told.len() < 2000,
        "{told}"
    );
    let robot = folder.read("robot.urdf").replace('\n', " ");
    let last = robot.rfind("<mass value=\"").expect("it has masses") + "<mass value=\"".len();
    let (before, after) = robot.split_at(last);
    folder.write("one.urdf", &format!("{before}-{after}"));
    let told = ended_with(2, &folder.ilon(&["inspect", "one.urdf"]));
    assert!(
        told.contains("but must be above 0") && told.len() < 2000,
        "{told}"
    );
    let steps: String = (0..5000)
        .map(|k| format!("{{ from_s = {} }}, ", 5 * k + 5))
        .collect();
    let text = folder.read("good.toml").replace(
        "[twist]",
        &format!("[twist]\nschedule = [{steps}{{ form_s = 1 }}]"),
    );
    folder.write("line.toml", &text);
    for arguments in [
        &["run", "line.toml"][..],
        &["check", "line.toml", "good.toml", "--junit", "j.xml"],
    ] {
        let told = ended_with(2, &folder.ilon(arguments));
        assert!(
            told.contains("unknown key `twist.schedule.5000.form_s`"),
            "{told}"
        );
        assert!(
            told.contains("did you mean `from_s`?") && told.len() < 3000,
            "{told}"
        );
    }
    let long_key = format!("{}{} = 1\n", folder.read("good.toml"), "k".repeat(1 << 20));
    folder.write("key.toml", &long_key);
    let told = ended_with(2, &folder.ilon(&["run", "key.toml"]));
    assert!(told.len() < 6000, "{} bytes", told.len());
}

/// `compare` and `report` read files of a run only within the sandbox, also through links.
#[cfg(unix)]
#[test]
fn runs_are_read_inside_of_the_sandbox_only() {
    let folder = confined();
    for out in ["in/run", "run"] {
        ended_with(
            0,
            &folder.ilon(&["run", "in/s.toml", "--no-report", "--out", out]),
        );
    }
    std::os::unix::fs::symlink(folder.path("run"), folder.path("in/link")).expect("a link");
    ended_with(
        0,
        &folder.ilon(&["compare", "in/run", "in/run", "--sandbox", "in"]),
    );
    ended_with(0, &folder.ilon(&["report", "in/run", "--sandbox", "in"]));
    for arguments in [
        &["compare", "in/run", "in/link", "--sandbox", "in"][..],
        &["compare", "in/run", "run/trace.parquet", "--sandbox", "in"],
        &["report", "in/link", "--sandbox", "in"],
        &["report", "run", "--sandbox", "in"],
    ] {
        let told = ended_with(2, &folder.ilon(arguments));
        assert!(
            told.contains("lies outside of what may be read"),
            "{arguments:?}: {told}"
        );
    }
}
