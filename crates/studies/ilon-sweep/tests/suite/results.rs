//! The files of a study, its findings from few draws, and refusals before any run.

use crate::support;

use std::path::Path;

use ilon_sim::Error;
use ilon_sweep::{Options, Store, findings, keep_traces, sweep};
use support::{Folder, message, run};

/// The names in a folder of kept traces.
fn kept(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder.join("kept"));
    let entries = entries.into_iter().flatten().flatten();
    let mut names: Vec<String> = entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// A start of 3 m/s^2 is fifteen times what a friction of 0.02 allows, and about what 0.3 allows:
/// in run 0 wheels slide fastest.
const THREE: &str =
    "quantities = [\"slip_speed_rms_m_s\"]\naxes.world.floor.friction = [0.02, 0.3, 0.6]\n";

#[test]
fn what_is_kept_follows_the_study_although_its_runs_are_there() {
    let folder = Folder::new();
    let out = folder.path("out");
    for (keep, expected) in [
        ("none", &[][..]),
        ("worst 1", &["run_000000"]),
        ("all", &["run_000000", "run_000001", "run_000002"]),
    ] {
        let study = folder
            .study(&format!("keep = \"{keep}\"\n{THREE}"))
            .unwrap();
        let store = Store::open(&out, &study, None).unwrap();
        run(&study, &store);
        assert_eq!(kept(&out), expected, "{keep}");
    }
}

#[test]
fn the_worst_run_of_all_shards_is_kept_once_they_are_merged() {
    let folder = Folder::new();
    let out = folder.path("out");
    let study = folder
        .study(&format!("keep = \"worst 1\"\n{THREE}"))
        .unwrap();
    for shard in ["1/2", "2/2"] {
        let shard = shard.parse().unwrap();
        let store = Store::open(&out, &study, Some(shard)).unwrap();
        sweep(&study, &store, &Options::new(None, Some(shard)), &|_| ()).unwrap();
        assert!(kept(store.folder().unwrap()).is_empty());
    }
    let (study, store) = Store::merge(std::slice::from_ref(&out), &out).unwrap();
    keep_traces(&study, &store, &Options::default()).unwrap();
    assert_eq!(kept(&out), ["run_000000"]);
}

#[test]
fn a_trace_is_not_kept_of_another_robot_than_that_of_its_row() {
    let folder = Folder::new();
    let out = folder.path("out");
    let study = folder.study(THREE).unwrap();
    let store = Store::open(&out, &study, None).unwrap();
    run(&study, &store);
    let robot = std::fs::read_to_string(folder.path("mecanum4.toml")).unwrap();
    let other = robot.replacen("mass_kg = 10.0", "mass_kg = 20.0", 1);
    assert_ne!(robot, other);
    // The study that was read before does not contain the change, as a merged one does not.
    let keeping = folder
        .study(&format!("keep = \"worst 1\"\n{THREE}"))
        .unwrap();
    folder.write("mecanum4.toml", &other);
    let (refused, _) = message(keep_traces(&keeping, &store, &Options::default()));
    assert!(
        refused.contains("run 0 does not give the results of its row again"),
        "{refused}"
    );
    assert!(kept(&out).is_empty());
}

#[test]
fn rows_of_somebody_else_are_refused_and_not_touched() {
    let folder = Folder::new();
    let study = folder.study(THREE).unwrap();
    let mine = "my precious data\nand an unfinished line";
    for (place, shard) in [("out", None), ("part/shard-1-of-2", Some("1/2"))] {
        std::fs::create_dir_all(folder.path(place)).unwrap();
        let log = folder.write(&format!("{place}/rows.log"), mine);
        let out = folder.path(place.split('/').next().unwrap());
        let shard = shard.map(|shard| shard.parse().unwrap());
        let (refused, _) = message(Store::open(&out, &study, shard));
        assert!(refused.contains("was not written by a study"), "{refused}");
        assert_eq!(std::fs::read_to_string(log).unwrap(), mine);
        assert!(!folder.path(place).join("study.json").exists());
    }
}

#[test]
fn a_search_cannot_be_merged_and_leaves_nothing_behind() {
    let folder = Folder::new();
    let study = folder
        .study(
            "[find]\nkey = \"world.floor.friction\"\nfrom = 0.1\nto = 0.8\nquantity = \"slip_energy_j\"\ncrosses = 0.1\n\
             tolerance = 0.3\nscan = 2\n",
        )
        .unwrap();
    let found = folder.path("found");
    let store = Store::open(&found, &study, None).unwrap();
    run(&study, &store);
    drop(store);
    let out = folder.path("merged");
    let (refused, _) = message(Store::merge(std::slice::from_ref(&found), &out).map(drop));
    assert!(refused.contains("is a study that searches"), "{refused}");
    assert!(!out.exists());
}

#[test]
fn rows_under_another_log_are_not_taken_for_those_of_this_one() {
    let folder = Folder::new();
    folder.write(
        "base.toml",
        "robot.file = \"mecanum4.toml\"\n[playback]\nfile = \"log.csv\"\ndrives = \"twist\"\n[run]\nduration_s = 0.1\n",
    );
    let log = |vx_m_s: f64| {
        let rows = format!("t_s,vx_m_s,vy_m_s,omega_rad_s\n0,{vx_m_s},0,0\n1,{vx_m_s},0,0\n");
        folder.write("log.csv", &rows);
    };
    log(0.1);
    let axis = "axes.world.floor.friction = [0.6]\n";
    let before = folder.study(axis).unwrap();
    drop(Store::open(&folder.path("out"), &before, None).unwrap());
    log(0.2);
    let after = folder.study(axis).unwrap();
    let (refused, _) = message(Store::open(&folder.path("out"), &after, None));
    assert!(refused.contains("were changed"), "{refused}");
}

/// A robot's file includes others and names meshes: rows made with another version of an included
/// file or mesh are not reused.
#[test]
fn rows_of_a_robot_whose_parts_were_changed_are_not_taken_for_those_of_this_one() {
    let folder = Folder::new();
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let urdf = std::fs::read_to_string(robots.join("mecanum4.urdf")).unwrap();
    // A round shape inside the first roller.
    let (first, rest) = urdf
        .split_once("<link name=\"front_left_roller_1_link\">")
        .unwrap();
    let collision = "<collision><geometry><mesh filename=\"core.obj\"/></geometry></collision>";
    let with_mesh = format!("{first}<link name=\"front_left_roller_1_link\">{collision}{rest}");
    let core = |radius_m: f64| {
        let corners = |at: u32| {
            let (sin, cos) = (f64::from(at) * std::f64::consts::FRAC_PI_8).sin_cos();
            let (x_m, y_m) = (radius_m * cos, radius_m * sin);
            format!("v {x_m} {y_m} -0.005\nv {x_m} {y_m} 0.005\n")
        };
        let face = |at: u32| format!("f {at} {} {}\n", at + 1, at + 2);
        let corners: String = (0..16).map(corners).collect();
        let faces: String = (1..=30).map(face).collect();
        folder.write("core.obj", &(corners + &faces));
    };
    folder.write(
        "robot.xacro",
        "<robot name=\"mecanum4\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n<xacro:include filename=\"parts.xacro\"/>\n</robot>\n",
    );
    folder.write("parts.xacro", &with_mesh);
    folder.write(
        "base.toml",
        "robot.file = \"robot.xacro\"\nrobot.rollers = \"as_modelled\"\n[twist]\nvx_m_s = 0.1\n[run]\nduration_s = 0.1\n",
    );
    core(0.004);
    let base = ilon_sim::Scenario::load(folder.path("base.toml")).unwrap();
    ilon_sim::load_robot(&base).expect("a robot");
    let fingerprint = |axes: &str| folder.study(axes).unwrap().fingerprint().to_owned();
    let by_friction = || fingerprint("axes.world.floor.friction = [0.6]\n");
    let by_robot = || fingerprint("axes.robot.file = [\"mecanum4.toml\", \"robot.xacro\"]\n");
    let before = [by_friction(), by_robot()];
    assert_eq!([by_friction(), by_robot()], before);
    let differ = || {
        let after = [by_friction(), by_robot()];
        assert!(after[0] != before[0] && after[1] != before[1]);
    };
    core(0.005);
    differ();
    core(0.004);
    folder.write(
        "parts.xacro",
        &with_mesh.replace("mass value=\"10\"", "mass value=\"11\""),
    );
    differ();
    folder.write("parts.xacro", &with_mesh);
    assert_eq!([by_friction(), by_robot()], before);
    // An unreadable file gives failed rows; the study itself is valid.
    folder.write("parts.xacro", "<robot");
    differ();
}

#[test]
fn repetitions_are_no_further_draws_of_what_is_varied() {
    let folder = Folder::new();
    let study = |repetitions: u32| {
        let text = format!(
            "method = \"random\"\npoints = 5\nrepetitions = {repetitions}\nquantities = [\"slip_energy_j\"]\n\
             expect.slip_energy_j = {{ max = 1e3 }}\naxes.world.floor.friction = {{ from = 0.2, to = 0.8 }}\n"
        );
        let study = folder.study(&text).unwrap();
        let store = Store::in_memory();
        run(&study, &store);
        findings(&study, &store)
    };
    // Without noise all repetitions of a point are equal.
    let (once, often) = (study(1), study(4));
    let (few, many) = (&once.distributions[0], &often.distributions[0]);
    assert_eq!(
        (few.count, few.draws, many.count, many.draws),
        (5, 5, 20, 5)
    );
    for (few, many) in few.quantiles.iter().zip(&many.quantiles) {
        assert_eq!((few.low, few.high), (many.low, many.high), "{}", few.share);
    }
    let interval = |found: &ilon_sweep::Findings| found.expectations[0].interval;
    assert_eq!(interval(&once), interval(&often));
}

#[test_case::test_case(
    "axes.world.floor.friction = [0.2, inf]",
    "`axes.world.floor.friction` holds inf, which is not finite";
    "infinite"
)]
#[test_case::test_case(
    "method = \"morris\"\npoints = 4\naxes.world.floor.friction = { mean = 0.6, sd = 0.05 }",
    "`axes.world.floor.friction` has no ends";
    "endless morris"
)]
#[test_case::test_case(
    "repetitions = 3\nset.sensors.seed = 3\naxes.world.floor.friction = [0.2]",
    "`repetitions` would all be the same run";
    "seeded repetitions"
)]
#[test_case::test_case(
    "repetitions = 3\naxes.sensors.seed = [1, 2]",
    "`repetitions` would all be the same run";
    "seed axis"
)]
#[test_case::test_case(
    "set.world.floor.friction = 0.3\naxes.world.floor.friction = [0.2]",
    "`axes.world.floor.friction` replaces `set.world.floor.friction` in every run";
    "set and varied"
)]
#[test_case::test_case(
    "axes.world.floor.friction = [0.2]\nexpect.slip_energy_j = { max = 1e-30, share = -1 }",
    "`expect.slip_energy_j` has the share -1";
    "negative share"
)]
#[test_case::test_case(
    "axes.world.floor.friction = [0.2]\nexpect.slip_energy_j = { max = 1, share = 1.5 }",
    "`expect.slip_energy_j` has the share 1.5";
    "large share"
)]
#[test_case::test_case(
    "axes.world.floor.friction = [0.2]\nexpect.slip_energy_j = { max = 1, share = nan }",
    "`expect.slip_energy_j` has the share NaN";
    "no share"
)]
#[test_case::test_case(
    "axes.world.floor.friction = [0.2]\nexpect.slip_energy_j = { max = nan }",
    "`expect.slip_energy_j` is not finite";
    "no bound"
)]
#[test_case::test_case(
    "axes.world.floor.friction = [0.2]\nexpect.twist_ratio_ideal.vx = { min = 0.5 }\nexpect.\"twist_ratio_ideal.vx\" = { min = 0.9 }",
    "the bound on `twist_ratio_ideal.vx` stands twice";
    "bound twice"
)]
#[test_case::test_case(
    "axes.world.floor.friction = { from = 0.2, to = 0.8 }\n\
     minimise = { quantity = \"slip_energy_j\", subject_to = { slip_speed_max_m_s = { min = 2, max = 1 } } }",
    "`minimise.subject_to.slip_speed_max_m_s` can never hold";
    "crossed constraint"
)]
#[test_case::test_case(
    "find = { key = \"world.floor.friction\", from = 0.1, to = 9.5, quantity = \"slip_energy_j\", crosses = 1, tolerance = 1e-12 }",
    "is finer than the digits with which values are tried";
    "too fine"
)]
#[test_case::test_case(
    "axes.world.floor.boxes = [[{ x_m = 1, y_mm = 0 }], []]",
    "unknown key `world.floor.boxes.0.y_mm`, which `axes` varies";
    "a key in the first value"
)]
#[test_case::test_case(
    "axes.world.floor.friction = [0.1, 0.2, true]",
    "`world.floor.friction` is true or false, but must be a number, which `axes` varies";
    "a type in the last value"
)]
fn what_would_be_ignored_or_never_end_well_is_refused(text: &str, expected: &str) {
    let folder = Folder::new();
    let (message, _) = message(folder.study(&format!("{text}\n")));
    assert!(message.contains(expected), "{message}");
}

#[test]
fn a_list_may_be_set_whose_elements_vary() {
    let folder = Folder::new();
    let text = "set.faults = [{ payload = { mass_kg = 1 } }]\naxes.\"faults.0.payload.mass_kg\" = [2, 3]\n";
    let study: Result<_, Error> = folder.study(text);
    let rows = folder.rows(text);
    assert!(
        study.is_ok() && rows.iter().all(|row| row.error.is_none()),
        "{rows:?}"
    );
}
