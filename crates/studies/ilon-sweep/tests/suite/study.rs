//! Studies: the same rows for any number of workers and interruptions, and error messages.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::support;

use ilon_sim::{Error, Scenario};
use ilon_sweep::{Options, Question, Status, Store, Study, figure_index, sweep, write_results};
use support::{Folder, SCENARIO, message, run};

const GRID: &str =
    "[axes]\nworld.floor.friction = [0.02, 0.6]\nrobot.spec.rollers.per_row = [8, 9, 12]\n";

#[test]
fn a_grid_has_every_combination_and_each_row_is_the_run_that_it_says() {
    let folder = Folder::new();
    let study = folder.study(GRID).unwrap();
    assert!(matches!(study.question(), Question::Table { runs: 6 }));
    let store = Store::in_memory();
    run(&study, &store);
    let rows = store.rows();
    let points: BTreeSet<String> = rows.iter().map(|row| format!("{:?}", row.values)).collect();
    assert_eq!((rows.len(), points.len()), (6, 6));
    for row in &rows {
        assert_eq!(row.status, Status::Done, "{row:?}");
        // The equivalent run with `--set`.
        let task = study.task(row.run);
        let scenario =
            Scenario::load_with(folder.path("base.toml"), &study.settings(&task)).unwrap();
        let alone = ilon_sim::run(&scenario).unwrap();
        assert_eq!(
            row.trace_hash.as_deref(),
            Some(alone.summary.trace_hash.as_str())
        );
        assert_eq!(
            row.figure(figure_index("slip_energy_j").unwrap()),
            alone.summary.slip_energy_j
        );
    }
    let keys: BTreeSet<&str> = rows.iter().map(|row| row.key.as_str()).collect();
    assert_eq!(keys.len(), 6, "each has a key of its own");
}

#[test]
fn rows_depend_on_index_and_seed_alone() {
    let folder = Folder::new();
    let text = "method = \"latin_hypercube\"\npoints = 6\nseed = 3\n[axes]\nworld.floor.friction = { from = 0.1, to = 0.8 }\n";
    let study = folder.study(text).unwrap();
    let store = Store::in_memory();
    sweep(&study, &store, &Options::new(Some(2), None), &|_| ()).unwrap();
    let backwards: Vec<u64> = (0..6).rev().collect();
    let again = study
        .run_parts(&backwards, &Options::new(Some(1), None), None)
        .unwrap();
    assert_eq!(store.rows(), again);
    let other = folder.rows(&text.replace("seed = 3", "seed = 4"));
    assert_ne!(other[0].values, again[0].values);
}

#[test]
fn repetitions_differ_by_their_noise_which_is_the_same_at_every_point() {
    let folder = Folder::new();
    let rows = folder.rows(
        "repetitions = 2\n[set]\nsensors.encoders.rate_noise_rad_s = 0.5\n[axes]\nworld.floor.friction = [0.5, 0.6]\n",
    );
    let seed = |run: usize| rows[run].values[1].clone();
    assert!(seed(0) != seed(1) && seed(0) == seed(2) && seed(1) == seed(3));
    assert_ne!(rows[0].trace_hash, rows[1].trace_hash);
}

#[test]
fn a_run_that_cannot_be_is_a_row_with_its_reason_and_the_others_go_on() {
    let folder = Folder::new();
    let study = folder
        .study("[axes]\nrobot.spec.rollers.radius_m = [0.012, 0.001]\nworld.floor.friction = [0.6, -1]\n")
        .unwrap();
    let store = Store::in_memory();
    let findings = run(&study, &store);
    let rows = store.rows();
    let failed: Vec<bool> = rows
        .iter()
        .map(|row| row.status == Status::Failed)
        .collect();
    assert_eq!(failed, [false, true, true, true]);
    let error = |run: usize| rows[run].error.as_deref().unwrap_or_default();
    assert!(
        error(1).contains("`world.floor.friction` is -1"),
        "{}",
        error(1)
    );
    assert!(
        error(2).contains("taper to nothing before they reach their neighbours"),
        "{}",
        error(2)
    );
    assert_eq!((findings.failed, findings.failures[0].count), (3, 2));
}

#[test]
fn several_scenarios_are_run_at_each_point_under_their_names() {
    let folder = Folder::new();
    folder.write("other.toml", &SCENARIO.replace("vy_m_s", "vx_m_s"));
    let study = folder.write(
        "s.toml",
        "scenario = [\"base.toml\", \"other.toml\"]\naxes.world.floor.friction = [0.5, 0.6]\n",
    );
    let study = Study::load(study).unwrap();
    let store = Store::in_memory();
    run(&study, &store);
    let names: Vec<String> = store.rows().into_iter().map(|row| row.scenario).collect();
    assert_eq!(names, ["base", "base", "other", "other"]);
}

#[test]
fn a_study_that_was_stopped_runs_only_what_is_missing_and_gives_the_same_rows() {
    let folder = Folder::new();
    let study = folder.study(GRID).unwrap();
    let whole = Store::in_memory();
    run(&study, &whole);
    let out = folder.path("out");
    let store = Store::open(&out, &study, None).unwrap();
    for row in study.run_parts(&[1, 4], &Options::default(), None).unwrap() {
        store.put(row).unwrap();
    }
    // The state after a process was killed in the middle of a row.
    drop(store);
    let mut log = std::fs::read(out.join("rows.log")).unwrap();
    let half = log[..100].to_vec();
    log.extend(half);
    std::fs::write(out.join("rows.log"), log).unwrap();
    let store = Store::open(&out, &study, None).unwrap();
    let made = AtomicU64::new(0);
    sweep(&study, &store, &Options::default(), &|progress| {
        made.fetch_max(progress.done - progress.found, Ordering::Relaxed);
    })
    .unwrap();
    assert_eq!((made.into_inner(), store.rows()), (4, whole.rows()));
}

#[test]
fn shards_make_all_rows_between_them_and_the_same_bytes_as_one_study() {
    let folder = Folder::new();
    let study = folder.study(GRID).unwrap();
    let (whole, parts) = (folder.path("whole"), folder.path("parts"));
    let store = Store::open(&whole, &study, None).unwrap();
    let findings = run(&study, &store);
    write_results(&study, &store, &findings).unwrap();
    for shard in ["1/3", "2/3"] {
        let shard = Some(shard.parse().unwrap());
        let store = Store::open(&parts, &study, shard).unwrap();
        sweep(&study, &store, &Options::new(None, shard), &|_| ()).unwrap();
    }
    let merge = || Store::merge(std::slice::from_ref(&parts), &parts);
    let (missing, _) = message(merge().map(drop));
    assert!(
        missing.starts_with("2 of 6 runs are missing, the first of them run 2"),
        "{missing}"
    );
    let shard = Some("3/3".parse().unwrap());
    sweep(
        &study,
        &Store::open(&parts, &study, shard).unwrap(),
        &Options::new(None, shard),
        &|_| (),
    )
    .unwrap();
    // A merge needs none of the study's files.
    std::fs::remove_file(folder.path("study.toml")).unwrap();
    std::fs::remove_file(folder.path("base.toml")).unwrap();
    let (merged, store) = merge().unwrap();
    let findings = ilon_sweep::findings(&merged, &store);
    write_results(&merged, &store, &findings).unwrap();
    for name in ["runs.parquet", "findings.json"] {
        let of = |folder: &Path| std::fs::read(folder.join(name)).unwrap();
        assert_eq!(of(&whole), of(&parts), "{name}");
    }
}

#[test]
fn a_folder_of_another_study_or_of_none_is_refused_and_not_touched() {
    let folder = Folder::new();
    let out = folder.path("out");
    let study = folder.study(GRID).unwrap();
    drop(Store::open(&out, &study, None).unwrap());
    let before = std::fs::read(out.join("study.json")).unwrap();
    let refused = |text: &str| message(Store::open(&out, &folder.study(text).unwrap(), None)).0;
    let changed = refused(&GRID.replace("0.02", "0.03"));
    assert!(
        changed.ends_with(
            "holds the results of `study` before it, its scenarios or its robots were changed"
        ),
        "{changed}"
    );
    // Looking at rows does not change them.
    let looked =
        format!("quantities = [\"slip_energy_j\"]\nexpect.slip_energy_j = {{ max = 1 }}\n{GRID}");
    assert!(Store::open(&out, &folder.study(&looked).unwrap(), None).is_ok());
    let robot = std::fs::read_to_string(folder.path("mecanum4.toml")).unwrap();
    folder.write(
        "mecanum4.toml",
        &robot.replace("mass_kg = 10.0", "mass_kg = 11.0"),
    );
    assert!(refused(GRID).contains("were changed"));
    let other = Study::load(folder.write(
        "other.toml",
        "scenario = \"base.toml\"\naxes.world.floor.friction = [1]\n",
    ))
    .unwrap();
    let (another, _) = message(Store::open(&out, &other, None));
    assert!(
        another.ends_with("holds the results of another study, `study`"),
        "{another}"
    );
    let json = String::from_utf8(before.clone()).unwrap();
    let older = json.replacen(
        &format!("\"ilon\": \"{}\"", env!("CARGO_PKG_VERSION")),
        "\"ilon\": \"0.0.9\"",
        1,
    );
    std::fs::write(out.join("study.json"), &older).unwrap();
    assert!(refused(GRID).contains("holds rows of ilon 0.0.9"));
    assert_eq!(
        std::fs::read_to_string(out.join("study.json")).unwrap(),
        older
    );
    let foreign = folder.path("foreign");
    std::fs::create_dir(&foreign).unwrap();
    std::fs::write(foreign.join("report.html"), "mine").unwrap();
    let (message, _) = message(Store::open(&foreign, &other, None));
    assert!(message.contains("was not written by a study"), "{message}");
}

#[test_case::test_case(
    "axes.world.floor.frction = [1]",
    "unknown key `world.floor.frction`, which `axes` varies",
    "did you mean `friction`?";
    "unknown key"
)]
#[test_case::test_case(
    "set.wrld.gravity = 1\naxes.world.floor.friction = [1]",
    "unknown key `wrld`",
    "did you mean `world`?";
    "unknown set"
)]
#[test_case::test_case(
    "axs.world.floor.friction = [1]",
    "unknown key `axs`",
    "did you mean `axes`?";
    "unknown word"
)]
#[test_case::test_case(
    "axes.world.floor.friction = [\"ice\"]",
    "`world.floor.friction` is a text, but must be a number, which `axes` varies",
    "write a number, without quotes";
    "wrong kind"
)]
#[test_case::test_case(
    "axes.world.floor.friction = []",
    "`axes.world.floor.friction` is an empty list, so there is no run",
    "write a list";
    "empty axis"
)]
#[test_case::test_case(
    "method = \"random\"\npoints = 0\naxes.world.floor.friction = [1]",
    "`points` is 0: there would be no run",
    "draw at least one";
    "no runs"
)]
#[test_case::test_case("", "the study varies nothing", "add an axis"; "nothing varied")]
#[test_case::test_case(
    "quantities = [\"slip_enrgy_j\"]\naxes.world.floor.friction = [1]",
    "there is no quantity `slip_enrgy_j`",
    "did you mean `slip_energy_j`?";
    "no quantity"
)]
#[test_case::test_case(
    "expect.slip_energy_j = {}\naxes.world.floor.friction = [1]",
    "`expect.slip_energy_j` bounds nothing",
    "give it `min`, `max` or both";
    "expects nothing"
)]
#[test_case::test_case(
    "expect.twist_ratio_ideal.vz = { max = 1 }\naxes.world.floor.friction = [1]",
    "there is no quantity `twist_ratio_ideal.vz`",
    "did you mean `twist_ratio_ideal.v";
    "expects unknown"
)]
#[test_case::test_case(
    "axes.world.floor.friction = { from = 0.1, to = 1 }",
    "`axes.world.floor.friction` has no number of values, which a grid needs",
    "give it `steps`";
    "grid of a range"
)]
#[test_case::test_case(
    "points = 3\naxes.world.floor.friction = [1]",
    "the points of a grid follow from its axes",
    "leave `points` out";
    "points of a grid"
)]
#[test_case::test_case(
    "method = \"sobol\"\naxes.world.floor.friction = [1]",
    "`method = \"sobol\"` needs a number of points",
    "add `points = 100`";
    "no points"
)]
#[test_case::test_case(
    "method = \"latin\"\naxes.world.floor.friction = [1]",
    "`method` cannot be \"latin\"",
    "did you mean \"latin_hypercube\"?";
    "unknown method"
)]
#[test_case::test_case(
    "axes.world.floor.friction = [1]\naxes.\"world.floor\" = [1]",
    "`axes.world.floor` and `axes.world.floor.friction` set the same key",
    "leave one";
    "twice"
)]
#[test_case::test_case(
    "axes.expect.slip_energy_j.max = [1]",
    "`expect` cannot be varied",
    "write what the runs shall keep";
    "expectation varied"
)]
#[test_case::test_case(
    "axes.world.floor.friction = { from = 0.1, to = 1, steps = 1000000 }\nrepetitions = 1000",
    "the study has 1000000000 runs",
    "take fewer";
    "too many"
)]
#[test_case::test_case(
    "keep = \"some\"\naxes.world.floor.friction = [1]",
    "`keep` cannot be \"some\"",
    "";
    "keep"
)]
#[test_case::test_case(
    "axes.world.floor.friction = [1]\nfind = { key = \"world.floor.friction\", from = 0.1, to = 1, quantity = \"slip_energy_j\", crosses = 1, tolerance = 0.1 }",
    "`world.floor.friction` is searched over, and an axis too",
    "leave the axis out";
    "find and axis"
)]
#[test_case::test_case(
    "find = { key = \"world.floor.fricton\", from = 0.1, to = 1, quantity = \"slip_energy_j\", crosses = 1, tolerance = 0.1 }",
    "unknown key `world.floor.fricton`, which `find` varies",
    "did you mean `friction`?";
    "find unknown"
)]
#[test_case::test_case(
    "axes.world.floor.friction = [1, 2]\nminimise = { quantity = \"slip_energy_j\" }",
    "`[minimise]` searches ranges, but `axes.world.floor.friction` is not a range",
    "write it as";
    "minimise of a list"
)]
fn a_bad_study_is_refused_with_what_is_wrong_and_how_to_repair_it(
    text: &str,
    expected: &str,
    remedy: &str,
) {
    let folder = Folder::new();
    let path = folder.write(
        "bad.toml",
        &format!("{}\n", ["scenario = \"base.toml\"", text].join("\n")),
    );
    let (message, help) = message(Study::load(path));
    assert!(message.contains(expected), "{message}");
    assert!(help.starts_with(remedy) || help.contains(remedy), "{help}");
}

#[test]
fn a_fault_points_at_its_place_in_the_study() {
    let folder = Folder::new();
    let text = "scenario = \"base.toml\"\n[axes]\nrobot.spec.rollers.per_row = [8]\nworld.floor.frction = [0.1]\n";
    match Study::load(folder.write("bad.toml", text)) {
        Err(Error::Scenario(fault)) => {
            assert!(
                text[fault.span.offset()..].starts_with("frction"),
                "{:?}",
                fault.span
            );
            assert!(fault.source_code.name().ends_with("bad.toml"));
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_crossing_is_found_on_the_robot_and_found_again_without_a_run() {
    let folder = Folder::new();
    // At 3 m/s^2 sideways a robot slides if the friction mu is too small: its losses fall with the
    // friction.
    let text = "[find]\nkey = \"world.floor.friction\"\nfrom = 0.01\nto = 0.8\nscale = \"log\"\nquantity = \"slip_energy_j\"\n\
                crosses = 0.1\ntolerance = 0.02\nscan = 5\n";
    let study = folder.study(text).unwrap();
    let out = folder.path("out");
    let store = Store::open(&out, &study, None).unwrap();
    let findings = run(&study, &store);
    let found = &findings.found[0].found;
    assert!(!found.crossings.is_empty(), "{found:?}");
    for crossing in &found.crossings {
        assert!(
            crossing.is_narrow && crossing.key_above - crossing.key_below <= 0.02,
            "{crossing:?}"
        );
        let slip_j = |friction: f64| {
            let setting = format!("world.floor.friction={friction}").parse().unwrap();
            let scenario = Scenario::load_with(folder.path("base.toml"), &[setting]).unwrap();
            ilon_sim::run(&scenario)
                .unwrap()
                .summary
                .slip_energy_j
                .unwrap()
        };
        let (low, high) = (slip_j(crossing.key_below), slip_j(crossing.key_above));
        assert!((low > 0.1) != (high > 0.1), "{low} {high}");
    }
    drop(store);
    let store = Store::open(&out, &study, None).unwrap();
    let made = AtomicU64::new(0);
    let again = sweep(&study, &store, &Options::default(), &|progress| {
        made.fetch_max(progress.done - progress.found, Ordering::Relaxed);
    });
    assert_eq!((made.into_inner(), again.unwrap()), (0, findings));
}

#[test]
fn a_minimum_is_found_on_the_robot_within_its_bound() {
    let folder = Folder::new();
    // The largest torque grows with the ramp's steepness: the least error of the wheel rates within
    // a bound on torque.
    let text = "[axes]\nwheel_loop.bandwidth_rad_s = { from = 5, to = 200, scale = \"log\" }\n[minimise]\n\
                quantity = \"wheel_rate_error_rms_rad_s\"\nstarts = 2\nevaluations = 12\ntolerance = 0.01\n\
                subject_to = { wheel_torque_max_n_m = { max = 1.5 } }\n";
    let store = Store::in_memory();
    let findings = run(&folder.study(text).unwrap(), &store);
    let minimum = findings.minimum.unwrap();
    let quantity = figure_index("wheel_rate_error_rms_rad_s").unwrap();
    let least = store
        .rows()
        .iter()
        .filter_map(|row| row.figure(quantity))
        .fold(f64::INFINITY, f64::min);
    assert_eq!(
        minimum.minimum.value,
        Some(least),
        "the best of all that was tried"
    );
    // The bounded figure and the notes are those of the best run.
    let rows = store.rows();
    let best = rows.iter().find(|row| Some(row.run) == minimum.run);
    let best = best.expect("the best run has a row");
    let torque = figure_index("wheel_torque_max_n_m").and_then(|index| best.figure(index));
    let bounded = minimum.subject_to.get("wheel_torque_max_n_m").copied();
    assert!(torque.is_some_and(|n_m| n_m <= 1.5));
    assert_eq!((bounded, &minimum.notes), (torque, &best.notes));
    // Faster loops follow better: the minimum is in the upper part of the range.
    assert!(minimum.minimum.place[0] > 0.5, "{minimum:?}");
}

#[test]
fn expectations_count_the_share_of_runs_and_failed_runs_break_them() {
    let folder = Folder::new();
    let text = |share: f64| {
        format!(
            "[expect]\nslip_energy_j = {{ max = 1000, share = {share} }}\n[axes]\nworld.floor.friction = [0.5, 0.6, 0.7, -1]\n"
        )
    };
    let held = |share: f64| {
        run(&folder.study(&text(share)).unwrap(), &Store::in_memory()).expectations[0].clone()
    };
    let (kept, broken) = (held(0.75), held(0.76));
    assert!(kept.held && !broken.held);
    assert_eq!((kept.kept, kept.runs, kept.worst_run), (3, 4, Some(3)));
}

#[test]
fn traces_are_kept_of_the_worst_and_the_failed_alone() {
    let folder = Folder::new();
    for (keep, expected) in [
        ("worst 2", vec!["run_000000", "run_000001"]),
        ("failed", vec!["run_000003"]),
        ("all", vec!["run_000000", "run_000001", "run_000002"]),
        ("none", vec![]),
    ] {
        let text = format!(
            "keep = \"{keep}\"\nquantities = [\"slip_energy_j\"]\naxes.world.floor.friction = [0.01, 0.02, 0.6, -1]\n"
        );
        let study = folder.study(&text).unwrap();
        let out = folder.path(&keep.replace(' ', "_"));
        run(&study, &Store::open(&out, &study, None).unwrap());
        let mut names: Vec<String> = std::fs::read_dir(out.join("kept"))
            .into_iter()
            .flatten()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        // An unreadable scenario leaves no trace to keep.
        let expected: Vec<&str> = expected.into_iter().filter(|_| keep != "failed").collect();
        assert_eq!(names, expected, "{keep}");
        for name in names {
            let trace = ilon_sim::trace::Trace::read_parquet(
                &out.join("kept").join(name).join("trace.parquet"),
            );
            assert!(trace.is_ok());
        }
    }
}

/// Designs without simulation: wheels on a ring with rollers at gamma are limited by the fastest
/// one, at rho q'max cos(gamma) in the direction along its roller's axis, for any number of wheels;
/// and on the spot by |b| cos(gamma) / cos(gamma).
#[test]
fn a_study_without_physics_says_what_designs_can_do() {
    let folder = Folder::new();
    let text = "physics = false\nquantities = [\"design.speed_least_m_s\", \"design.rank\"]\n\
                [axes]\nrobot.spec.wheels.ring.count = [3, 4, 6]\nrobot.spec.wheels.ring.gamma_deg = [0.0, 20.0, 45.0]\n";
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots/volksbot.toml");
    let text = format!(
        "{text}[set]\nrobot.file = {:?}\n",
        robot.display().to_string()
    );
    let rows = folder.rows(&text);
    assert_eq!(rows.len(), 9);
    for row in &rows {
        assert_eq!(
            (row.status, &row.trace_hash),
            (Status::Done, &None),
            "{row:?}"
        );
        let figure = |name: &str| row.figure(figure_index(name).unwrap());
        assert_eq!(figure("design.rank"), Some(3.0));
        assert_eq!(figure("slip_energy_j"), None);
        let gamma_rad = row.values[1].as_float().unwrap().to_radians();
        // 0.05 m at 91.6 rad/s.
        let least_m_s = 0.05 * 91.6 * gamma_rad.cos();
        let found_m_s = figure("design.speed_least_m_s").unwrap();
        assert!(
            (found_m_s / least_m_s - 1.0).abs() < 1e-9,
            "{found_m_s} {least_m_s}"
        );
        assert!(
            (figure("design.yaw_rate_rad_s").unwrap() / (0.05 * 91.6 / 0.25) - 1.0).abs() < 1e-9
        );
        let least_m_s2 = figure("design.acceleration_least_m_s2").unwrap();
        assert!(least_m_s2 > 0.0 && least_m_s2 <= figure("design.acceleration_most_m_s2").unwrap());
    }
    // Repeated, the same; and quantities of runs are refused.
    assert_eq!(folder.rows(&text), rows);
    let axes = "[axes]\nworld.floor.friction = [0.2, 0.6]\n";
    for (text, said) in [
        (
            "physics = false\nquantities = [\"slip_energy_j\"]\n",
            "needs runs",
        ),
        ("quantities = [\"design.condition\"]\n", "physics = false"),
        ("physics = false\nrepetitions = 2\n", "repetitions"),
        ("physics = false\nkeep = \"all\"\n", "keep"),
    ] {
        let (words, help) = message(folder.study(&format!("{text}{axes}")));
        assert!(
            format!("{words} {help}").contains(said),
            "{text}: {words} ({help})"
        );
    }
}
