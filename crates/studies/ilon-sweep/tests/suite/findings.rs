//! Findings of a study about its quantities: the range and the main effects of a grid, and missing
//! findings with the reason.

use crate::support;

use ilon_sweep::findings::grid::MainEffect;
use ilon_sweep::{Findings, Store, findings};
use support::{Folder, run};

fn found(text: &str) -> Findings {
    let folder = Folder::new();
    let study = folder.study(text).unwrap();
    let store = Store::in_memory();
    run(&study, &store);
    // Rows only in memory cannot be damaged.
    assert_eq!(store.damaged(), 0);
    findings(&study, &store)
}

/// The number of steps is the duration over the step, a grid whose effects follow in closed form.
#[test]
fn a_grid_says_where_a_quantity_is_least_and_largest_and_what_each_axis_does_to_it() {
    let found = found(
        "quantities = [\"steps\"]\nset.run.control_dt_s = 0.02\n[axes]\nrun.duration_s = [0.2, 0.4]\nrun.physics_dt_s = [0.001, 0.002]\n",
    );
    let [range] = &found.ranges[..] else {
        panic!("{found:?}");
    };
    // 200 and 400 steps of 1 ms, 100 and 200 of 2 ms.
    assert_eq!((range.runs, range.mean), (4, 225.0));
    assert_eq!((range.least.value, range.least.run), (100.0, 1));
    assert_eq!((range.largest.value, range.largest.run), (400.0, 2));
    assert_eq!(range.largest.values["run.duration_s"].as_float(), Some(0.4));
    assert_eq!(
        range.largest.values["run.physics_dt_s"].as_float(),
        Some(0.001)
    );
    for (axis, means) in range.axes.iter().zip([[150.0, 300.0], [300.0, 150.0]]) {
        let own: Vec<Option<f64>> = axis.levels.iter().map(|level| level.mean).collect();
        assert_eq!(own, means.map(Some), "{}", axis.key);
        // 2 (75^2 + 75^2) of 25^2 + 175^2 + 125^2 + 25^2; the interaction of both has 2500 of
        // 47500.
        let share = axis.share.unwrap();
        assert!((share - 22500.0 / 47500.0).abs() < 1e-12, "{share}");
    }
    assert_eq!(found.gaps, []);
}

/// An axis that a quantity does not depend on has no effect on it; if runs fail the shares are not
/// known, but the rest is.
#[test]
fn an_axis_that_does_nothing_has_no_share_and_failed_runs_leave_none() {
    let text = |frictions: &str| {
        format!(
            "quantities = [\"duration_s\"]\n[axes]\nrun.duration_s = [0.3, 0.5]\nworld.floor.friction = {frictions}\n"
        )
    };
    let shares =
        |axes: &[MainEffect]| -> Vec<Option<f64>> { axes.iter().map(|axis| axis.share).collect() };
    let whole = found(&text("[0.2, 0.6]"));
    assert_eq!(shares(&whole.ranges[0].axes), [Some(1.0), Some(0.0)]);
    let broken = found(&text("[0.2, -1]"));
    assert_eq!((broken.failed, broken.ranges[0].runs), (2, 2));
    assert_eq!(shares(&broken.ranges[0].axes), [None, None]);
    assert_eq!(broken.ranges[0].axes[1].levels[1].mean, None);
}

/// The window of the means begins after the end of these runs.
#[test]
fn a_quantity_that_no_run_has_is_said_to_be_absent_with_what_it_takes() {
    let short = "quantities = [\"twist_mean.vy_m_s\"]\nset.run.duration_s = 0.2\nset.twist = { vx_m_s = 0.2, rest_s = 0.1, ramp_s = 0.1, settle_s = 1.0 }\n";
    for (method, runs) in [
        ("method = \"sobol_indices\"\npoints = 4", 16),
        ("method = \"morris\"\npoints = 3", 9),
        ("method = \"random\"\npoints = 5", 5),
        ("", 4),
    ] {
        let axes = match method {
            "" => "axes.world.floor.friction = [0.2, 0.8]\naxes.robot.heading_deg = [0, 10]",
            _ => {
                "axes.world.floor.friction = { from = 0.2, to = 0.8 }\naxes.robot.heading_deg = { from = 0, to = 10 }"
            }
        };
        let found = found(&format!("{method}\n{short}{axes}\n"));
        let [gap] = &found.gaps[..] else {
            panic!("{method}: {found:?}");
        };
        assert_eq!((gap.absent, gap.runs), (runs, runs), "{method}");
        assert_eq!(gap.quantity, "twist_mean.vy_m_s");
        assert!(gap.why.contains("`run.duration_s`"), "{}", gap.why);
        let said = found.indices.len()
            + found.effects.len()
            + found.distributions.len()
            + found.ranges.len();
        assert_eq!(said, 0, "{method}");
    }
}

#[test]
fn of_what_no_axis_changes_it_is_said_that_there_are_no_shares() {
    let found = found(
        "method = \"sobol_indices\"\npoints = 4\nquantities = [\"duration_s\"]\naxes.world.floor.friction = { from = 0.2, to = 0.8 }\n",
    );
    let [gap] = &found.gaps[..] else {
        panic!("{found:?}");
    };
    assert_eq!((gap.absent, gap.runs), (0, 12));
    assert!(gap.why.starts_with("it is 0.5 in all runs"), "{}", gap.why);
}

/// If every point has a failed run, there are neither shares nor effects.
#[test]
fn of_points_of_which_none_is_whole_it_is_said() {
    for method in ["sobol_indices", "morris"] {
        let found = found(&format!(
            "method = \"{method}\"\npoints = 2\nseed = 3\nquantities = [\"slip_energy_j\"]\naxes.world.floor.friction = {{ from = -0.9, to = 0.01 }}\n"
        ));
        assert!(found.failed > 0, "{found:?}");
        let whys: Vec<&str> = found.gaps.iter().map(|gap| gap.why.as_str()).collect();
        let is_said = whys.iter().any(|why| why.contains("where two are needed"));
        let is_known = !found.indices.is_empty() || !found.effects.is_empty();
        assert!(
            found.failed == found.runs || is_said != is_known,
            "{whys:?}"
        );
    }
}

/// Each trajectory changes the duration once, from any of 0.2, 0.3, 0.4 and 0.5 s: over its whole
/// axis it changes itself by 0.3 s, and the friction has no effect on it.
#[test]
fn morris_books_each_change_under_the_axis_that_was_moved() {
    let found = found(
        "method = \"morris\"\npoints = 4\nquantities = [\"duration_s\"]\n[axes]\nworld.floor.friction = { from = 0.2, to = 0.8 }\n\
         run.duration_s = { from = 0.2, to = 0.5 }\n",
    );
    let [friction, duration] = &found.effects[0].axes[..] else {
        panic!("{found:?}");
    };
    assert_eq!((friction.moves, duration.moves), (4, 4));
    assert_eq!(friction.mean_magnitude, Some(0.0));
    // Rounding of times below 1 s.
    assert!((duration.mean.unwrap() - 0.3).abs() < 1e-12, "{duration:?}");
    assert!(duration.deviation.unwrap() < 1e-12, "{duration:?}");
}

/// Runs of a sample have their own seeds, unless the study varies the seed itself.
#[test]
fn a_sample_has_one_column_of_seeds_whoever_draws_them() {
    for (axes, columns) in [
        (
            "world.floor.friction = { from = 0.2, to = 0.8 }",
            vec!["world.floor.friction", "sensors.seed"],
        ),
        (
            "world.floor.friction = { from = 0.2, to = 0.8 }\nsensors.seed = { from = 1, to = 9, whole = true }",
            vec!["world.floor.friction", "sensors.seed"],
        ),
    ] {
        let folder = Folder::new();
        let study = folder
            .study(&format!(
                "method = \"random\"\npoints = 3\n[axes]\n{axes}\n"
            ))
            .unwrap();
        let keys: Vec<&str> = study.columns().iter().map(|one| one.key.as_str()).collect();
        assert_eq!(keys, columns);
    }
}
