//! The project's studies of published logs: the figures of docs/measured.md.

use crate::support;

use ilon_identify::{Identified, Study, identify};
use support::assets;

fn found(study: &str) -> Identified {
    let study = Study::load(assets().join("identify").join(study)).unwrap();
    identify(&study, &|_| ()).unwrap()
}

/// Root mean square over directions of measured less fitted; `of` selects by the index of the
/// direction among 24.
fn left(found: &Identified, of: impl Fn(i64) -> bool) -> f64 {
    let left: Vec<f64> = found
        .residual
        .iter()
        .filter(|one| of((one.direction_deg / 15.0).round() as i64 % 24))
        .map(|one| (one.measured - one.fitted).powi(2))
        .collect();
    assert!(left.len() >= 11, "{}", left.len());
    (left.iter().sum::<f64>() / left.len() as f64).sqrt()
}

#[test]
fn the_mecanum_robot_falls_short_sideways_as_published_and_predicts_its_season() {
    let found = found("optiodom_mecanum.toml");
    assert_eq!(found.model, "gains by direction");
    let ratio = &found.derived["sideways_over_ahead"];
    // Published: 0.956 in September, +-0.001 within a series.
    assert!((ratio.value - 0.956).abs() < 0.002, "{ratio:?}");
    let of = |name: &str| {
        let series = found
            .series
            .iter()
            .find(|series| series.name == name)
            .unwrap();
        series.gains["sideways_over_ahead"].value
    };
    assert!(
        (of("squares") - ratio.value).abs() < 0.003,
        "squares {}",
        of("squares")
    );
    // Published: 0.952 in December.
    assert!((of("dec") - 0.952).abs() < 0.002, "dec {}", of("dec"));
    assert!(found.held_out.over_noise < found.nominal.over_noise / 1.5);
}

#[test]
fn the_omni_robot_gains_the_same_ahead_and_sideways_and_ends_nearer_once_calibrated() {
    let found = found("optiodom_omni3.toml");
    let gains = &found.series[0].gains;
    // Published: 1.001.
    assert!(
        (gains["sideways_over_ahead"].value - 1.001).abs() < 0.004,
        "{gains:?}"
    );
    let end = |model: &str| {
        let model = found
            .models
            .iter()
            .find(|known| known.name == model)
            .unwrap();
        model.held_out.end_position_rms_m
    };
    // Dead reckoning with the authors' published parameters for the set of 12 squares that these
    // four belong to ends 0.050 m off. Their criterion, positions along the whole run, ends 0.061 m
    // off on the run left out, fitted to the other three of these.
    let own = end("each wheel's radius and lever");
    assert!(own < 0.050, "{own}");
    assert!((found.nominal.end_position_rms_m - 0.175).abs() < 0.001);
}

#[test]
fn the_robotino_makes_the_same_way_in_all_directions_on_a_table() {
    let found = found("robotino_table.toml");
    let ratios: Vec<f64> = found.residual.iter().map(|one| one.measured).collect();
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    let squares: f64 = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum();
    let deviation = (squares / (ratios.len() - 1) as f64).sqrt();
    // Published: 0.927 +- 0.005.
    assert!(
        (mean - 0.927).abs() < 0.002 && (deviation - 0.005).abs() < 0.001,
        "{mean} {deviation}"
    );
}

#[test]
fn half_of_the_directions_predict_the_others_on_mats() {
    for (study, published, within) in [
        ("robotino_brown.toml", 0.953, 0.015),
        ("robotino_gray.toml", 0.797, 0.03),
    ] {
        let found = found(study);
        let mean = found.residual.iter().map(|one| one.measured).sum::<f64>()
            / found.residual.len() as f64;
        assert!((mean - published).abs() < 0.006, "{study}: {mean}");
        // Directions are at multiples of 15 degrees, the odd ones held out; slip turns some by a
        // few degrees.
        let missed = left(&found, |place| place % 2 == 1);
        assert!(missed < within, "{study}: {missed}");
    }
}

/// A study may have no free parameters at all, neither of the robot nor of the tracker.
#[test]
fn a_model_without_anything_free_is_judged_as_it_is() {
    let text = std::fs::read_to_string(assets().join("identify/optiodom_omni3.toml")).unwrap();
    let text = text.replace("\"../", &format!("\"{}/", assets().display()));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bare.toml");
    let bare = format!("tracker = []\n{text}\n[[models]]\nname = \"as it is\"\nfree = []\n");
    std::fs::write(&path, bare).unwrap();
    let found = identify(&Study::load(&path).unwrap(), &|_| ()).unwrap();
    assert_eq!(found.model, "as it is");
    assert!(found.parameters.is_empty(), "{:?}", found.parameters);
    assert!((found.fit.over_noise - found.nominal.over_noise).abs() < 1e-9);
}

/// Three minutes on one core: creep and drag of the soft mat, from paths, heading and currents at
/// once.
#[test]
#[ignore = "minutes, with --release: the floor of docs/measured.md"]
fn the_gray_mat_is_known_by_ways_heading_and_currents_from_one_set() {
    let found = found("robotino_gray_floor.toml");
    let simulation = found.simulation.as_ref().unwrap();
    let (kept_back, coulomb) = (&simulation.held_out, &simulation.beside[0].held_out);
    // The figures of docs/measured.md, and that friction alone explains none of it.
    assert!(kept_back.ratio.unwrap() < 0.03 && coulomb.ratio.unwrap() > 0.19);
    assert!(kept_back.drift_rad_per_m.unwrap() < 0.5 * coulomb.drift_rad_per_m.unwrap());
    assert!(kept_back.torque_n_m.unwrap() < 0.2 * coulomb.torque_n_m.unwrap());
    let creep = &found.parameters["world.floor.creep"];
    assert!(
        creep.ci95[0].unwrap() > 0.4 && creep.ci95[1].unwrap() < 0.6,
        "{creep:?}"
    );
}

/// By the published values the wheel has 32.5 mm and stands 150 mm before the axle. The circles show
/// that its steering stands beside its zero, which no value of both explains, and the squares, which
/// were not fitted, end within 2 % of their 5.9 m in place of 16 %.
#[test]
fn the_tricycle_ends_nearer_by_the_zero_of_its_steering() {
    let found = found("optiodom_tricycle.toml");
    assert_eq!(found.model, "radius, lever and steering angles");
    let of = |name: &str| {
        let model = found.models.iter().find(|model| model.name == name);
        model.unwrap().held_out.end_position_rms_m
    };
    let [known, lengths, all] = ["nominal values", "radius and lever", &found.model].map(of);
    assert!(known > 0.9 && lengths > 0.8, "{known} {lengths}");
    assert!(all < 0.02 * 5.9, "{all}");
    let zero = &found.parameters["steering_deg.drive"];
    assert!((zero.value + 1.2).abs() < 0.1, "{zero:?}");
}
