//! Output files: never over inputs, never by two processes at once, never partial, and checked
//! before the work begins.

use crate::support;

use std::fs;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use support::{FAILS, Folder, HOLDS, ended_with};

/// A run that takes longer than any test waits.
const ENDLESS: [&str; 4] = [
    "--set",
    "run.duration_s=100000",
    "--set",
    "run.record_every=10",
];

/// Begins an endless run into a folder, and waits until it has reserved the folder.
fn begun(folder: &Folder, out: &str) -> Child {
    let run = ["run", "good.toml", "--out", out];
    let command = [&run[..], &ENDLESS[..]].concat();
    begun_until(folder, &command, &format!("{out}/trace.partial"))
}

/// Begins a command, and waits until a file is there.
fn begun_until(folder: &Folder, command: &[&str], file: &str) -> Child {
    let child = folder
        .command(command)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command runs");
    let start = Instant::now();
    while !folder.path(file).exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "it never began");
        std::thread::sleep(Duration::from_millis(10));
    }
    child
}

/// Ends a command by a signal; gives what it said, once it ended with this code.
#[cfg(unix)]
fn interrupted(child: Child, signal: &str, code: i32) -> String {
    let kill = std::process::Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status();
    assert!(kill.expect("kill is there").success());
    let output = child.wait_with_output().expect("it ends");
    let told = support::stderr(&output);
    // It ends by the signal, which a shell reports as 128 more.
    let ended_by = std::os::unix::process::ExitStatusExt::signal(&output.status);
    assert_eq!(ended_by, Some(code - 128), "{told}");
    told
}

/// Whether these tests run under `nohup`, which commands that they begin inherit.
#[cfg(target_os = "linux")]
fn ignores_hangups() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").expect("it is there");
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = u64::from_str_radix(mask.expect("a mask").trim(), 16);
    mask.expect("a number") & 1 == 1
}

#[test]
#[cfg(unix)]
fn an_interrupted_run_leaves_whole_files_and_no_lock() {
    let folder = Folder::new();
    let mut signals = vec![("-INT", 130, "a"), ("-TERM", 143, "b")];
    // The terminal is closed; a run under `nohup` goes on, as the next test has it.
    #[cfg(target_os = "linux")]
    if !ignores_hangups() {
        signals.push(("-HUP", 129, "h"));
    }
    for (signal, code, out) in signals {
        let run = ["run", "good.toml", "--out", out];
        let every = ["--set", "run.duration_s=100000"];
        let growing = format!("{out}/trace.partial");
        let part = format!("{growing}/0000002.parquet");
        let child = begun_until(&folder, &[&run[..], &every[..]].concat(), &part);
        let told = interrupted(child, signal, code);
        assert!(
            told.contains(&format!("the trace until then is in {growing}")),
            "{told}"
        );
        assert_eq!(folder.names(out), ["scenario.toml", "trace.partial"]);
        let parts = folder.names(&growing);
        assert!(
            parts
                .iter()
                .all(|name| name.ends_with(".parquet") && !name.starts_with('.')),
            "{parts:?}"
        );
        for part in parts {
            let part = folder.path(&growing).join(part);
            ilon::trace::Trace::read_parquet(&part).expect("a whole part");
        }
    }
    // During the first part: the folder is left, and named, only if that part is whole.
    for out in ["c", "d", "e"] {
        let growing = format!("{out}/trace.partial");
        let child = begun(&folder, out);
        let is_written = |name: &String| name.starts_with(".0000000");
        let start = Instant::now();
        while !folder.names(&growing).iter().any(is_written) {
            assert!(start.elapsed() < Duration::from_secs(60), "no part began");
        }
        let told = interrupted(child, "-INT", 130);
        let left = folder.names(out).contains(&"trace.partial".to_owned());
        assert_eq!(told.contains(&growing), left, "{told}");
        assert!(
            !left
                || folder
                    .names(&growing)
                    .iter()
                    .all(|name| name.ends_with(".parquet"))
        );
        assert!(!left || !folder.names(&growing).is_empty());
    }
    // The next run takes the folder, and is whole.
    ended_with(0, &folder.ilon(&["run", "good.toml", "--out", "a"]));
    assert_eq!(folder.names("a").len(), 4, "{:?}", folder.names("a"));
}

/// `nohup` has the signal of a closed terminal ignored, and so it stays.
#[test]
#[cfg(target_os = "linux")]
fn a_run_under_nohup_outlives_its_terminal() {
    let folder = Folder::new();
    let run = ["run", "good.toml", "--out", "n"];
    let mut child = std::process::Command::new("nohup")
        .arg(env!("CARGO_BIN_EXE_ilon"))
        .args([&run[..], &ENDLESS[..]].concat())
        .current_dir(folder.path("."))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("nohup is there");
    let start = Instant::now();
    while !folder.path("n/trace.partial").exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "it never began");
        std::thread::sleep(Duration::from_millis(10));
    }
    let kill = std::process::Command::new("kill")
        .args(["-HUP", &child.id().to_string()])
        .status();
    assert!(kill.expect("kill is there").success());
    // Ten times the time in which a signal is obeyed.
    std::thread::sleep(Duration::from_millis(200));
    assert!(child.try_wait().expect("a child").is_none(), "it ended");
    interrupted(child, "-INT", 130);
}

/// An explained run leaves the same, and names it.
#[test]
#[cfg(unix)]
fn an_interrupted_explanation_names_the_trace_that_it_leaves() {
    let folder = Folder::new();
    let explain = ["explain", "good.toml", "--out", "why"];
    let part = "why/trace.partial/0000001.parquet";
    let child = begun_until(&folder, &[&explain[..], &ENDLESS[..]].concat(), part);
    let told = interrupted(child, "-INT", 130);
    assert!(
        told.contains("the trace until then is in why/trace.partial"),
        "{told}"
    );
    assert_eq!(folder.names("why"), ["scenario.toml", "trace.partial"]);
    let parts = folder.names("why/trace.partial");
    assert!(
        parts.iter().all(|name| name.ends_with(".parquet")),
        "{parts:?}"
    );
}

#[test]
#[cfg(unix)]
fn an_interrupted_check_leaves_nothing_and_an_interrupted_sweep_its_rows() {
    let folder = Folder::new();
    folder.write(
        "study.toml",
        "scenario = \"good.toml\"\n[axes]\nworld.floor.friction = { from = 0.02, to = 0.8, steps = 4000 }\n",
    );
    let before = folder.names(".");
    for (signal, code) in [("-INT", 130), ("-TERM", 143)] {
        let check = [
            "check",
            "good.toml",
            "--save",
            "saved",
            "--keep",
            "kept",
            "--junit",
            "j.xml",
        ];
        let check = [&check[..], &ENDLESS[..]].concat();
        let child = begun_until(&folder, &check, "kept/.ilon-lock");
        interrupted(child, signal, code);
        for place in ["saved", "kept"] {
            assert!(folder.names(place).is_empty(), "{:?}", folder.names(place));
        }
        let mut names = folder.names(".");
        names.retain(|name| !["saved", "kept", "swept"].contains(&name.as_str()));
        assert_eq!(names, before);

        let _ = fs::remove_dir_all(folder.path("swept"));
        let sweep = ["sweep", "study.toml", "--out", "swept"];
        let child = begun_until(&folder, &sweep, "swept/rows.log");
        std::thread::sleep(Duration::from_millis(500));
        let told = interrupted(child, signal, code);
        assert!(told.contains("the same command continues"), "{told}");
        assert_eq!(folder.names("swept"), ["rows.log", "study.json"]);
    }
}

/// A disk that fills up, here a limit on the size of each file: the command names the file and the
/// reason, and each file is whole or has the name of an unfinished one.
#[test]
#[cfg(unix)]
fn where_a_disk_is_full_the_file_and_the_reason_are_named() {
    let folder = Folder::new();
    folder.write(
        "study.toml",
        "scenario = \"good.toml\"\n[axes]\nworld.floor.friction = [0.2, 0.4]\n",
    );
    // What is written bit by bit may be left: a bag that is not finished, and rows of a sweep.
    let bag = "bag/bag/bag_0.mcap.ilon-partial";
    let growing = [bag, "swept/rows.log"];
    // In blocks of 512 bytes: more than the first file has, less than the last.
    for (command, blocks, file) in [
        ("run good.toml --out out", 8, "out/trace.parquet"),
        ("run good.toml --no-report --mcap --out bag", 40, bag),
        ("sweep study.toml --out swept", 2, "swept/rows.log"),
        ("check good.toml --save saved", 8, "saved/good.parquet"),
        (
            "compare good.toml good.toml --out page.html",
            8,
            "page.html",
        ),
        (
            "export --mjcf robot.urdf --out exported",
            4,
            "exported/robot.xml",
        ),
    ] {
        // Without its signal, the limit is an error like a full disk.
        let limited = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\"");
        let output = std::process::Command::new("sh")
            .args(["-c", &limited, "sh", env!("CARGO_BIN_EXE_ilon")])
            .args(command.split(' '))
            .current_dir(folder.path("."))
            .output()
            .expect("a shell is there");
        let told = ended_with(2, &output);
        let fault = format!("cannot write `{file}`: File too large");
        assert!(told.contains(&fault), "{command}: {told}");
        assert!(
            told.contains("make room, or choose another place"),
            "{told}"
        );
        assert!(growing.contains(&file) || !folder.path(file).exists());
        let mut left = Vec::new();
        names_below(&folder.path("."), &mut left);
        left.retain(|name| name.contains("partial") || name.contains("lock"));
        left.retain(|name| !bag.ends_with(name));
        assert!(left.is_empty(), "{command}: {left:?}");
    }
}

/// The names of all files and empty folders below a folder.
#[cfg(unix)]
fn names_below(folder: &std::path::Path, names: &mut Vec<String>) {
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let before = names.len();
        if entry.path().is_dir() {
            names_below(&entry.path(), names);
        }
        if names.len() == before {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
}

/// Of two commands that are started at the same moment one has the folder and the other is refused;
/// or one begins after the other has ended. The results are always whole.
#[test]
fn of_two_runs_that_start_together_the_results_are_whole() {
    let folder = Folder::new();
    let run = ["run", "good.toml", "--out", "out", "--no-report"];
    let short = ["--set", "run.duration_s=0.1"];
    let run = [&run[..], &short[..]].concat();
    let mut refused = 0;
    for round in 0..50 {
        if round % 2 == 0 {
            let _ = fs::remove_dir_all(folder.path("out"));
        }
        let start = || {
            let mut command = folder.command(&run);
            let piped = command.stdout(Stdio::null()).stderr(Stdio::piped());
            piped.spawn().expect("the command runs")
        };
        let both = [start(), start()].map(|child| child.wait_with_output().expect("it ends"));
        let done = both.iter().filter(|output| output.status.success()).count();
        assert!(done > 0, "{both:?}");
        for output in both.iter().filter(|output| !output.status.success()) {
            let told = support::stderr(output);
            assert_eq!(output.status.code(), Some(2), "{told}");
            assert!(
                told.contains("`out` is being written to by another run"),
                "{told}"
            );
            refused += 1;
        }
        assert_eq!(
            folder.names("out"),
            ["scenario.toml", "summary.json", "trace.parquet"]
        );
        let trace = ilon::trace::Trace::read_parquet(&folder.path("out/trace.parquet"));
        let hash = ilon::trace::trace_hash(&trace.expect("a whole trace"));
        let summary = folder.read("out/summary.json");
        assert!(summary.contains(&hash), "{hash} {summary}");
    }
    assert!(refused > 0, "they never met");
}

#[test]
fn two_runs_into_one_folder_do_not_meet_and_a_killed_one_locks_nobody_out() {
    let folder = Folder::new();
    let mut first = begun(&folder, "out");
    let told = ended_with(2, &folder.ilon(&["run", "good.toml", "--out", "out"]));
    assert!(
        told.contains("`out` is being written to by another run"),
        "{told}"
    );
    assert!(told.contains(&format!("process {}", first.id())), "{told}");
    assert!(told.contains("with --out"), "{told}");
    // Another folder is free.
    ended_with(0, &folder.ilon(&["run", "good.toml", "--out", "elsewhere"]));
    first.kill().expect("it still runs");
    first.wait().expect("it ends");
    ended_with(0, &folder.ilon(&["run", "good.toml", "--out", "out"]));
    assert_eq!(folder.names("out").len(), 4, "{:?}", folder.names("out"));
}

#[test]
fn every_output_of_every_command_is_locked() {
    let folder = Folder::new();
    folder.scenario("fails.toml", FAILS);
    let mut first = begun(&folder, "taken");
    let taken: [&[&str]; 3] = [
        &["check", "good.toml", "--save", "taken"],
        &["check", "good.toml", "--keep", "taken"],
        &["check", "good.toml", "--against", "x", "--save", "taken"],
    ];
    for arguments in taken {
        let told = ended_with(2, &folder.ilon(arguments));
        assert!(
            told.contains("is being written to by another run"),
            "{told}"
        );
    }
    first.kill().expect("it still runs");
    first.wait().expect("it ends");
    // A comparison of two endless runs reserves its file from the beginning.
    folder.scenario("endless.toml", "");
    let text = folder
        .read("endless.toml")
        .replace("duration_s = 0.5", "duration_s = 50000");
    folder.write("endless.toml", &text);
    let compare = ["compare", "endless.toml", "good.toml", "--out", "page.html"];
    let mut first = folder
        .command(&compare)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command runs");
    let start = Instant::now();
    while !folder.path(".page.html.ilon-lock").exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "it never began");
        std::thread::sleep(Duration::from_millis(10));
    }
    let told = ended_with(2, &folder.ilon(&compare));
    assert!(
        told.contains("`page.html` is being written to by another run"),
        "{told}"
    );
    first.kill().expect("it still runs");
    first.wait().expect("it ends");
}

#[test]
fn what_a_killed_writer_left_is_gone_after_the_next() {
    let folder = Folder::new();
    let dead = ".summary.json.dead.ilon-partial";
    for place in ["out", "kept", "saved"] {
        folder.write(&format!("{place}/{dead}"), "half");
    }
    for file in ["j.xml", "r.svg", "good.toml"] {
        folder.write(&format!(".{file}.dead.ilon-partial"), "half");
    }
    ended_with(0, &folder.ilon(&["run", "good.toml", "--out", "out"]));
    let check = [
        "check",
        "good.toml",
        "--keep",
        "kept",
        "--save",
        "saved",
        "--junit",
        "j.xml",
        "--update",
    ];
    ended_with(0, &folder.ilon(&check));
    ended_with(
        0,
        &folder.ilon(&["inspect", "robot.urdf", "--svg", "r.svg"]),
    );
    for place in ["out", "kept", "saved", "."] {
        let names = folder.names(place);
        assert!(
            !names.iter().any(|name| name.contains("ilon")),
            "{place}: {names:?}"
        );
    }
}

#[test]
fn no_output_replaces_an_input_by_whatever_name() {
    let folder = Folder::new();
    let spec = "name = \"x\"\n";
    folder.write("spec.toml", spec);
    folder.scenario("in/scenario.toml", "# mine\n");
    ended_with(0, &folder.ilon(&["run", "good.toml", "--out", "run"]));
    let untouched = ["good.toml", "robot.urdf", "spec.toml", "in/scenario.toml"];
    let before = untouched.map(|name| folder.read(name));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path("in"), folder.path("link")).expect("a link");
        fs::hard_link(folder.path("robot.urdf"), folder.path("hard.svg")).expect("a link");
        std::os::unix::fs::symlink("robot.urdf", folder.path("soft.svg")).expect("a link");
        let by_link: [&[&str]; 3] = [
            &["run", "in/scenario.toml", "--out", "link"],
            &["inspect", "robot.urdf", "--svg", "hard.svg"],
            &["inspect", "soft.svg", "--svg", "robot.urdf"],
        ];
        for arguments in by_link {
            let told = ended_with(2, &folder.ilon(arguments));
            assert!(
                told.contains("would be written over"),
                "{arguments:?}: {told}"
            );
        }
    }
    let refused: [&[&str]; 7] = [
        &["run", "in/scenario.toml", "--out", "in"],
        &["run", "in/scenario.toml", "--out", "in/../in/."],
        &["inspect", "robot.urdf", "--svg", "./robot.urdf"],
        &["check", "good.toml", "--junit", "good.toml"],
        &[
            "check",
            ".",
            "--junit",
            "in/scenario.toml",
            "--filter",
            "scenario",
        ],
        &["compare", "run", "good.toml", "--out", "good.toml"],
        &["compare", "run", "run", "--out", "run/trace.parquet"],
    ];
    for arguments in refused {
        let told = ended_with(2, &folder.ilon(arguments));
        assert!(
            told.contains("would be written over"),
            "{arguments:?}: {told}"
        );
    }
    assert_eq!(untouched.map(|name| folder.read(name)), before);
    assert!(ilon::trace::file::is_trace(
        &folder.path("run/trace.parquet")
    ));
}

#[test]
fn a_description_is_not_replaced_by_the_robot_that_it_makes() {
    let folder = Folder::new();
    folder.write("spec.toml", SPEC);
    let told = ended_with(
        2,
        &folder.ilon(&["generate", "spec.toml", "--out", "spec.toml"]),
    );
    assert!(told.contains("would be written over"), "{told}");
    assert_eq!(folder.read("spec.toml"), SPEC);
    ended_with(
        0,
        &folder.ilon(&["generate", "spec.toml", "--out", "made.urdf"]),
    );
    // The robot again, over the older one.
    ended_with(
        0,
        &folder.ilon(&["generate", "spec.toml", "--out", "made.urdf"]),
    );
}

const SPEC: &str = "\
name = \"trike\"
[chassis]
shape.cylinder = { radius_m = 0.2, height_m = 0.1 }
mass_kg = 6.0
center_m = [0.0, 0.0, 0.06]
[wheel]
radius_m = 0.05
hub_mass_kg = 0.25
hub_radius_m = 0.03
hub_width_m = 0.04
motor_effort_n_m = 1.0
motor_velocity_rad_s = 20.0
[rollers]
per_row = 8
radius_m = 0.012
mass_kg = 0.01
[wheels.ring]
count = 3
distance_m = 0.2
gamma_deg = 0.0
";

#[test]
fn what_is_generated_can_be_run() {
    let folder = Folder::new();
    for (good, bad) in [
        ("mass_kg = 0.01", "mass_kg = 1e-12"),
        ("[0.0, 0.0, 0.06]", "[0.0, 0.0, -1.0]"),
        ("radius_m = 0.05", "radius_m = 5.0"),
    ] {
        folder.write("spec.toml", &SPEC.replacen(good, bad, 1));
        ended_with(
            2,
            &folder.ilon(&["generate", "spec.toml", "--out", "made.urdf"]),
        );
        assert!(!folder.path("made.urdf").exists());
    }
}

#[test]
fn results_replace_those_of_an_earlier_run_and_nothing_of_other_origin() {
    let folder = Folder::new();
    for _ in 0..2 {
        ended_with(0, &folder.ilon(&["run", "good.toml", "--out", "out"]));
    }
    for name in [
        "report.html",
        "summary.json",
        "trace.parquet",
        "scenario.toml",
    ] {
        let place = format!("mine/{name}");
        folder.write(&place, "{ \"mine\": true }");
        let told = ended_with(2, &folder.ilon(&["run", "good.toml", "--out", "mine"]));
        assert!(told.contains("was not written by a run"), "{told}");
        assert_eq!(folder.read(&place), "{ \"mine\": true }");
        fs::remove_file(folder.path(&place)).expect("it is there");
    }
    folder.write("mine/trace.partial/notes.txt", "mine");
    let told = ended_with(2, &folder.ilon(&["run", "good.toml", "--out", "mine"]));
    assert!(told.contains("no run has written it"), "{told}");
    assert_eq!(folder.read("mine/trace.partial/notes.txt"), "mine");
    // Nor below --keep.
    folder.scenario("fails.toml", FAILS);
    folder.write("kept/fails/report.html", "mine");
    let told = ended_with(2, &folder.ilon(&["check", "fails.toml", "--keep", "kept"]));
    assert!(told.contains("was not written by a run"), "{told}");
}

#[test]
fn where_nothing_can_be_written_is_told_before_anything_is_simulated() {
    let folder = Folder::new();
    folder.write("file", "");
    // An hour of computation, if it began.
    let outputs: [&[&str]; 5] = [
        &["--junit", "nowhere/results.xml"],
        &["--junit", "."],
        &["--save", "file"],
        &["--keep", "file/kept"],
        &["--against", "nowhere"],
    ];
    for output in outputs {
        let arguments = [&["check", "good.toml"], output, &ENDLESS[..]].concat();
        ended_with(2, &folder.ilon(&arguments));
    }
    let compare = [
        "compare",
        "good.toml",
        "good.toml",
        "--out",
        "file/page.html",
    ];
    ended_with(2, &folder.ilon(&compare));
}

#[test]
fn a_baseline_is_not_replaced_by_the_run_that_leaves_it() {
    let folder = Folder::new();
    ended_with(0, &folder.ilon(&["check", "good.toml", "--save", "base"]));
    let before = fs::read(folder.path("base/good.parquet")).expect("a baseline");
    let other = ["--set", "robot.heading_deg=20"];
    for save in ["base", "./base", "x/../base"] {
        folder.write("x/y", "");
        let both = ["check", "good.toml", "--against", "base", "--save", save];
        let told = ended_with(2, &folder.ilon(&[&both[..], &other[..]].concat()));
        assert!(told.contains("the same folder"), "{told}");
    }
    assert_eq!(
        fs::read(folder.path("base/good.parquet")).expect("a baseline"),
        before
    );
    let both = ["check", "good.toml", "--against", "base", "--save", "next"];
    ended_with(0, &folder.ilon(&both));
}

#[test]
fn a_damaged_baseline_is_refused_and_not_taken_for_a_difference() {
    let folder = Folder::new();
    ended_with(0, &folder.ilon(&["check", "good.toml", "--save", "base"]));
    let path = folder.path("base/good.parquet");
    let whole = fs::read(&path).expect("a baseline");
    for at in [
        5,
        60,
        whole.len() / 3,
        whole.len() / 2,
        whole.len() - 200,
        whole.len() - 3,
    ] {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x10;
        fs::write(&path, damaged).expect("it can be written");
        let told = ended_with(
            2,
            &folder.ilon(&["check", "good.toml", "--against", "base"]),
        );
        assert!(told.contains("good.parquet"), "{at}: {told}");
    }
    fs::write(&path, &whole).expect("it can be written");
    ended_with(
        0,
        &folder.ilon(&["check", "good.toml", "--against", "base"]),
    );
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_written_to_and_not_replaced() {
    let folder = Folder::new();
    let device = folder.path("null");
    std::os::unix::fs::symlink("/dev/null", &device).expect("a link");
    ended_with(0, &folder.ilon(&["check", "good.toml", "--junit", "null"]));
    ended_with(0, &folder.ilon(&["inspect", "robot.urdf", "--svg", "null"]));
    assert!(
        fs::symlink_metadata(&device)
            .expect("it stays")
            .is_symlink()
    );
    let printed = ended_with(
        0,
        &folder.ilon(&["check", "good.toml", "--junit", "/dev/stdout"]),
    );
    assert!(printed.contains("<testcase name=\"good\""), "{printed}");
}

#[cfg(unix)]
#[test]
fn updating_bounds_through_a_link_keeps_link_and_rights() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let file = folder.path("good.toml");
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).expect("it is ours");
    std::os::unix::fs::symlink("good.toml", folder.path("link.toml")).expect("a link");
    let kept = folder.read("good.toml");
    ended_with(0, &folder.ilon(&["check", "link.toml", "--update", "0.05"]));
    assert_eq!(folder.read("good.toml"), kept, "bounds that hold stay");
    fs::write(&file, kept.replace("max = 1.1 }", "max = 0.95 }")).expect("it is ours");
    folder.ilon(&["check", "link.toml", "--update", "0.05"]);
    assert!(
        !folder.read("good.toml").contains("max = 0.95 }"),
        "the bound moved"
    );
    assert!(
        fs::symlink_metadata(folder.path("link.toml"))
            .expect("it stays")
            .is_symlink()
    );
    let mode = fs::metadata(&file).expect("it stays").permissions().mode();
    assert_eq!(mode & 0o777, 0o640);
}

#[test]
fn scenarios_of_one_name_have_files_of_their_own_or_are_refused() {
    let folder = Folder::new();
    folder.scenario("all/a/x.toml", HOLDS);
    folder.scenario("all/b/x.toml", FAILS);
    folder.scenario("all/x.toml", HOLDS);
    // Below one folder they are distinguished by their paths.
    ended_with(
        1,
        &folder.ilon(&["check", "all", "--save", "base", "--keep", "kept"]),
    );
    assert_eq!(folder.names("base"), ["a", "b", "x.parquet"]);
    assert_eq!(folder.names("base/a"), ["x.parquet"]);
    assert_eq!(folder.names("kept"), ["b"]);
    assert_eq!(folder.names("kept/b/x").len(), 4);
    let against = ["check", "all", "--against", "base", "--filter", "x"];
    let told = ended_with(1, &folder.ilon(&against));
    assert!(!told.contains("leaves its baseline"), "{told}");
    // Named one by one they are not.
    for option in ["--save", "--keep", "--against"] {
        let told = ended_with(
            2,
            &folder.ilon(&["check", "all/a", "all/b", option, "base"]),
        );
        assert!(told.contains("are both called `x`"), "{told}");
    }
    let told = ended_with(
        1,
        &folder.ilon(&["check", "all/a", "all/b", "--junit", "j.xml"]),
    );
    assert!(
        told.contains("held   all/a/x.toml") && told.contains("FAILED all/b/x.toml"),
        "{told}"
    );
    let junit = folder.read("j.xml");
    assert!(
        junit.contains("name=\"all/a/x.toml\"") && junit.contains("name=\"all/b/x.toml\""),
        "{junit}"
    );
}

/// A page is made from a run's folder: each other path is named as what it is, with what to do.
#[test]
fn a_report_of_a_trace_names_the_folder_or_what_is_missing() {
    let folder = Folder::new();
    ended_with(
        0,
        &folder.ilon(&["run", "good.toml", "--out", "run", "--no-report"]),
    );
    fs::create_dir(folder.path("alone")).expect("a folder");
    let copied = fs::copy(
        folder.path("run/trace.parquet"),
        folder.path("alone/trace.parquet"),
    );
    copied.expect("a copy");
    for (path, words) in [
        ("run/trace.parquet", "`ilon report run`"),
        ("run/summary.json", "`ilon report run`"),
        (
            "alone/trace.parquet",
            "is a trace without the scenario.toml of its run",
        ),
        ("alone", "`alone` holds no finished run"),
        (
            "good.toml",
            "`good.toml` is a file, not the folder of a run",
        ),
        ("nowhere", "`nowhere` holds no finished run"),
    ] {
        let told = ended_with(2, &folder.ilon(&["report", path]));
        assert!(told.contains(words), "{path}: {told}");
    }
}
