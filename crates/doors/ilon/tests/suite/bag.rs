//! `ilon run --mcap`: the bag of a run, judged also by other software (`bag_witness.py`).

use crate::support;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use support::{Folder, ended_with, python, stderr};

/// The packages of `bag_witness.py`.
const JUDGES: &str = "rosbags, mcap_ros2, rerun, pyarrow";

fn witness(python: &str, arguments: &[&str]) {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/bag_witness.py");
    let output = Command::new(python)
        .arg(script)
        .args(arguments)
        .output()
        .expect("Python runs");
    print!("{}", String::from_utf8_lossy(&output.stdout));
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

/// All shipped scenarios, in order.
fn shipped() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/scenarios");
    let entries = std::fs::read_dir(folder).expect("the scenarios");
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.expect("a scenario").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    paths.sort();
    paths
}

/// The first half second of every third scenario, half of them with turning rollers; the whole of
/// all scenarios is in the `#[ignore]`d test below.
#[test]
fn others_read_the_bag_of_every_third_scenario_as_its_trace_has_it() {
    let Some(python) = python(JUDGES) else {
        return;
    };
    let folder = Folder::new();
    let mut arguments = Vec::new();
    for (index, path) in shipped().iter().step_by(3).enumerate() {
        let out = folder.path(&path.file_stem().expect("a name").to_string_lossy());
        let out = out.display().to_string();
        let path = path.display().to_string();
        let mut run = vec!["run", &path, "--mcap", "--json", "--out", &out];
        run.extend(["--set", "run.duration_s=0.5"]);
        if index % 2 == 0 {
            run.extend(["--set", "run.roller_angles_hz=25"]);
        }
        let output = folder.ilon(&run);
        // Some describe later events, and are refused for half a second.
        if output.status.success() {
            arguments.push(out);
        } else {
            assert!(
                stderr(&output).contains("0.5"),
                "{path}: {}",
                stderr(&output)
            );
        }
    }
    assert!(
        arguments.len() > 13,
        "only {} run that shortly",
        arguments.len()
    );
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    witness(&python, &arguments);
}

#[test]
#[ignore = "takes many minutes: all scenarios to their ends"]
fn others_read_the_bag_of_every_whole_scenario() {
    let Some(python) = python(JUDGES) else {
        return;
    };
    let folder = Folder::new();
    for path in shipped() {
        let out = folder.path("out").display().to_string();
        let path = path.display().to_string();
        ended_with(
            0,
            &folder.ilon(&["run", &path, "--mcap", "--json", "--out", &out]),
        );
        witness(&python, &[&out]);
    }
}

#[test]
fn a_killed_run_leaves_a_bag_that_can_be_read() {
    let Some(python) = python(JUDGES) else {
        return;
    };
    let folder = Folder::new();
    let mut command = folder.command(&[
        "run",
        "good.toml",
        "--mcap",
        "--out",
        "out",
        "--set",
        "run.duration_s=1000",
    ]);
    let mut running = command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command runs");
    let bag = folder.path("out/bag/bag_0.mcap.ilon-partial");
    let since = Instant::now();
    // Two seconds of the run are in the file.
    while std::fs::metadata(&bag).map_or(0, |file| file.len()) < 400_000 {
        assert!(since.elapsed() < Duration::from_secs(120), "no bag grows");
        std::thread::sleep(Duration::from_millis(20));
    }
    running.kill().expect("it runs still");
    running.wait().expect("it ends");
    let out = folder.path("out").display().to_string();
    witness(&python, &["--cut", &out]);
}

/// A recorder that is killed leaves no footer: what it recorded is played, and that it ends early is
/// said. Of a whole bag nothing is said.
#[test]
fn a_bag_that_was_cut_short_is_played_with_a_note() {
    let folder = Folder::new();
    ended_with(
        0,
        &folder.ilon(&["run", "good.toml", "--mcap", "--out", "out"]),
    );
    let whole = std::fs::read(folder.path("out/bag/bag_0.mcap")).expect("a bag");
    for (name, length, is_said) in [
        ("whole", whole.len(), false),
        // Within the footer, of 37 bytes with the mark after it: the chunk before it is read.
        ("cut", whole.len() - 20, true),
    ] {
        let bag = format!("{name}.mcap");
        std::fs::write(folder.path(&bag), &whole[..length]).expect("a place");
        let text = format!(
            "robot.file = \"robot.urdf\"\nplayback = {{ file = \"{bag}\", drives = \"twist\", topic = \"/odom\" }}\nrun.duration_s = 0.1\n"
        );
        let scenario = format!("{name}.toml");
        folder.write(&scenario, &text);
        let told = ended_with(0, &folder.ilon(&["run", &scenario, "--out", name]));
        assert_eq!(told.contains("was cut short"), is_said, "{told}");
    }
}

#[test]
fn a_bag_comes_and_goes_with_the_results_of_its_run() {
    let folder = Folder::new();
    let run = |further: &[&str]| {
        let arguments = [&["run", "good.toml", "--out", "out"], further].concat();
        folder.ilon(&arguments)
    };
    let said = ended_with(0, &run(&["--mcap"]));
    assert!(said.contains("scenario.toml, bag/"), "{said}");
    assert_eq!(folder.names("out/bag"), ["bag_0.mcap", "metadata.yaml"]);
    let first = std::fs::read(folder.path("out/bag/bag_0.mcap")).expect("a bag");
    ended_with(0, &run(&["--mcap"]));
    let again = std::fs::read(folder.path("out/bag/bag_0.mcap")).expect("a bag");
    assert!(first == again, "the same run made another bag");
    ended_with(0, &run(&[]));
    assert!(
        !folder.path("out/bag").exists(),
        "the bag of an earlier run is taken for this one's"
    );
}

#[test]
fn what_no_run_has_written_is_not_replaced_by_a_bag() {
    let folder = Folder::new();
    folder.write("out/bag/bag_0.mcap", "of somebody else");
    let run =
        |further: &[&str]| folder.ilon(&[&["run", "good.toml", "--out", "out"], further].concat());
    let said = ended_with(2, &run(&["--mcap"]));
    assert!(said.contains("was not written by a run"), "{said}");
    assert_eq!(folder.names("out"), ["bag"], "nothing was begun");
    ended_with(0, &run(&[]));
    assert_eq!(folder.read("out/bag/bag_0.mcap"), "of somebody else");
}

#[test]
fn a_file_where_the_bag_shall_be_is_not_replaced() {
    let folder = Folder::new();
    folder.write("out/bag", "of somebody else");
    let said = ended_with(
        2,
        &folder.ilon(&["run", "good.toml", "--out", "out", "--mcap"]),
    );
    assert!(said.contains("was not written by a run"), "{said}");
    assert_eq!(folder.read("out/bag"), "of somebody else");
}

/// A recording of an arm by `rosbags` moves it: rates to their integral, 0.2 rad; 0.4 N m against
/// friction of 0.1 and damping of 0.05 N m s on 0.1517 kg m^2, on a robot that its floor holds,
/// within 0.9 s to a / c (t - J / c (1 - exp(-c t / J))) = 0.7273 rad.
#[test]
fn a_bag_of_another_program_moves_a_joint_by_rates_or_torques() {
    let Some(python) = python("rosbags") else {
        return;
    };
    let folder = Folder::new();
    let robot = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/mecanum4_arm.urdf"
    );
    for (by, expected) in [("rate", 0.2), ("effort", 0.7273)] {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/joint_bag.py");
        let bag = folder.path(&format!("{by}_bag")).display().to_string();
        let written = Command::new(&python)
            .args([script, &bag, by])
            .output()
            .expect("Python runs");
        assert!(
            written.status.success(),
            "{}",
            String::from_utf8_lossy(&written.stderr)
        );
        let scenario = format!(
            "[robot]\nfile = \"{robot}\"\nwheels = {{ rollers = 9, roller_radius_m = 0.012, roller_mass_kg = 0.01, damping_n_m_s = 1e-6, gamma.x_deg = 45 }}\n\
             [robot.joints.arm]\nrole = \"driven\"\n[playback]\nfile = \"{by}_bag\"\ndrives = \"joints\"\n[twist]\nvx_m_s = 0\n\
             [[expect.signals]]\nsignal = \"joint_arm_position_rad\"\nfrom_s = 0.895\nuntil_s = 0.905\nequal = {expected}\nwithin = {}\n",
            0.01 * expected
        );
        folder.write(&format!("{by}.toml"), &scenario);
        ended_with(0, &folder.ilon(&["check", &format!("{by}.toml")]));
    }
}
