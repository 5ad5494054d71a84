//! Studies made in parts, as by the workers of a cluster, and studies stopped from outside.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use ilon_sim::Error;
use ilon_sweep::{Options, Status, Stop, Store, Study, sweep};

/// A study of a scenario of this duration in seconds, in its own folder.
fn study(duration_s: f64, text: &str) -> (tempfile::TempDir, Study) {
    let folder = tempfile::tempdir().unwrap();
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    std::fs::copy(
        robots.join("mecanum4.toml"),
        folder.path().join("mecanum4.toml"),
    )
    .unwrap();
    let scenario = format!(
        "robot.file = \"mecanum4.toml\"\n[twist]\nvy_m_s = 0.3\nrest_s = 0.1\nramp_s = 0.1\nsettle_s = 0.1\n[run]\nduration_s = {duration_s}\n"
    );
    std::fs::write(folder.path().join("base.toml"), scenario).unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, format!("scenario = \"base.toml\"\n{text}")).unwrap();
    let study = Study::load(path).unwrap();
    (folder, study)
}

const GRID: &str = "[axes]\nworld.floor.friction = [0.02, 0.1, 0.6]\n";
const FIND: &str = "[axes]\ntwist.vy_m_s = [0.2, 0.3]\n[find]\nkey = \"world.floor.friction\"\nfrom = 0.01\nto = 0.8\n\
                    scale = \"log\"\nquantity = \"slip_energy_j\"\ncrosses = 0.05\ntolerance = 0.05\nscan = 4\n";
const MINIMISE: &str = "[axes]\nwheel_loop.bandwidth_rad_s = { from = 5, to = 200, scale = \"log\" }\n[minimise]\n\
                        quantity = \"wheel_rate_error_rms_rad_s\"\nstarts = 3\nevaluations = 6\n";

#[test_case::test_case(GRID, 3; "table")]
#[test_case::test_case(FIND, 2; "find")]
#[test_case::test_case(MINIMISE, 3; "minimise")]
fn a_study_of_which_all_parts_were_made_elsewhere_needs_no_run(text: &str, parts: u64) {
    let (_folder, study) = study(0.5, text);
    assert_eq!(study.parts(), parts);
    let whole = Store::in_memory();
    let expected = sweep(&study, &whole, &Options::default(), &|_| ()).unwrap();
    let gathered = Store::in_memory();
    for part in (0..parts).rev() {
        assert_eq!(
            study.missing_parts(&gathered, None),
            (0..=part).collect::<Vec<_>>()
        );
        for row in study
            .run_parts(&[part], &Options::new(Some(1), None), None)
            .unwrap()
        {
            assert!(!gathered.holds(row.run), "no run belongs to two parts");
            gathered.put(row).unwrap();
        }
    }
    assert!(study.missing_parts(&gathered, None).is_empty());
    assert_eq!(gathered.rows(), whole.rows());
    let made = AtomicU64::new(0);
    let findings = sweep(&study, &gathered, &Options::default(), &|progress| {
        made.fetch_max(progress.done - progress.found, Ordering::Relaxed);
    });
    assert_eq!(made.into_inner(), 0);
    let json = |findings| serde_json::to_string(findings).unwrap();
    assert_eq!(json(&findings.unwrap()), json(&expected));
}

#[test]
fn a_part_that_there_is_not_is_refused() {
    let (_folder, study) = study(0.5, GRID);
    let error = study
        .run_parts(&[0, 3], &Options::default(), None)
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "there is no part 3: the study has 3 parts, counted from 0"
    );
}

#[test]
fn a_study_that_is_stopped_ends_in_the_middle_of_its_runs_and_no_row_is_of_them() {
    // Hours of simulation.
    let (_folder, study) = study(1e5, GRID);
    let store = Store::in_memory();
    let stop = Stop::default();
    let options = Options::new(Some(2), None).stopped_by(stop.clone());
    let ended = std::thread::scope(|scope| {
        let swept = scope.spawn(|| sweep(&study, &store, &options, &|_| ()));
        std::thread::sleep(Duration::from_millis(300));
        stop.ask();
        swept.join().unwrap()
    });
    assert!(matches!(ended, Err(Error::Stopped)), "{ended:?}");
    assert!(store.is_empty());
    let ended = study.run_parts(&[0], &options, None);
    assert!(matches!(ended, Err(Error::Stopped)), "{ended:?}");
}

/// The runs whose traces are kept in a folder.
fn kept(out: &Path) -> Vec<PathBuf> {
    let traces = std::fs::read_dir(out.join("kept")).into_iter().flatten();
    let traces = traces.map(|folder| folder.unwrap().path().join("trace.parquet"));
    let mut traces: Vec<PathBuf> = traces.filter(|trace| trace.exists()).collect();
    traces.sort();
    traces
}

#[test]
fn traces_that_are_all_kept_are_written_by_workers_that_see_the_folder_and_made_again_where_none_did()
 {
    let (folder, study) = study(0.5, &format!("keep = \"all\"\n{GRID}"));
    let options = Options::default();
    let out = folder.path().join("seen");
    let store = Store::open(&out, &study, None).unwrap();
    let rows = study.run_parts(&[0, 1, 2], &options, Some(&out)).unwrap();
    assert!(rows.iter().all(|row| row.status == Status::Done));
    assert_eq!(kept(&out).len(), 3);
    drop(store);

    let unseen = folder.path().join("unseen");
    let rows = study
        .run_parts(&[0, 1, 2], &options, Some(&unseen))
        .unwrap();
    assert!(
        !unseen.exists(),
        "a folder that is not of this study is left alone"
    );
    let store = Store::open(&unseen, &study, None).unwrap();
    for row in rows {
        store.put(row).unwrap();
    }
    sweep(&study, &store, &options, &|_| ()).unwrap();
    let bytes = |out: &Path| -> Vec<Vec<u8>> {
        let traces = kept(out);
        traces
            .iter()
            .map(|trace| std::fs::read(trace).unwrap())
            .collect()
    };
    assert_eq!(bytes(&unseen), bytes(&out));
    assert_eq!(bytes(&unseen).len(), 3);
}
