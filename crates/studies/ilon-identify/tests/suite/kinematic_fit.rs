//! A fit's estimates of noise and of outliers, and the residuals of windows.

use ilon_identify::kinematic_fit::{Evidence, Noise, misses, take_noise};
use ilon_identify::motion::{Tracker, Window};
use nalgebra::Matrix3xX;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};

const WHEELS: usize = 4;

/// A map from wheel rates to twists of no real robot.
fn map() -> Matrix3xX<f64> {
    Matrix3xX::from_fn(WHEELS, |axis, wheel| {
        0.01 + 0.01 * libm::sin(3.0 * axis as f64 + 7.0 * wheel as f64)
    })
}

/// Windows of runs seen by trackers at their own points, each with noise.
fn evidence(runs: usize, each: usize, noise: [f64; 3]) -> Evidence {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let unit = Normal::new(0.0, 1.0).unwrap();
    let mut next = move || unit.sample(&mut rng);
    let series = |run: usize| format!("series {}", run % 2);
    let mut windows = Vec::new();
    for run in 0..runs {
        let tracker = tracker(run);
        for at in 0..each {
            let turned_rad: Vec<f64> = (0..WHEELS).map(|_| 5.0 * next()).collect();
            let mut window = Window {
                run,
                at_s: at as f64,
                cos_rad: turned_rad.iter().map(|turned| 0.9 * turned).collect(),
                sin_rad: turned_rad.iter().map(|turned| 0.2 * turned + 0.1).collect(),
                turned_rad,
                seen: [0.0; 3],
            };
            // The lever of the tracked point uses the measured turn.
            window.seen[2] = window.predicted(&map(), &tracker)[2] + noise[2] * next();
            let [x_m, y_m, _] = window.predicted(&map(), &tracker);
            window.seen[0] = x_m + noise[0] * next();
            window.seen[1] = y_m + noise[1] * next();
            windows.push(window);
        }
    }
    Evidence {
        windows,
        series: (0..runs).map(series).collect(),
        held_out: vec![false; runs],
    }
}

/// Each of two series has its own tracked point.
fn tracker(run: usize) -> Tracker {
    Tracker {
        point_m: [[0.1, -0.2], [-0.05, 0.3]][run % 2],
        turned_rad: 0.0,
    }
}

#[test]
fn what_a_map_and_the_trackers_points_explain_is_no_noise() {
    let mut evidence = evidence(4, 40, [0.0; 3]);
    let (noise, left_out) = take_noise(&mut evidence);
    // The least accepted noise.
    assert_eq!((noise.position_m, noise.heading_rad), (1e-7, 1e-7));
    assert_eq!((left_out, evidence.windows.len()), (0, 160));
}

#[test]
fn noise_is_what_scatters_about_the_best_map() {
    let (position_m, heading_rad) = (4e-4, 9e-4);
    let mut evidence = evidence(4, 250, [position_m, position_m, heading_rad]);
    let (noise, left_out) = take_noise(&mut evidence);
    // The median of more than a thousand: 1.17 sigma over the root of their number.
    assert!(
        (noise.position_m / position_m - 1.0).abs() < 0.08,
        "{noise:?}"
    );
    assert!(
        (noise.heading_rad / heading_rad - 1.0).abs() < 0.12,
        "{noise:?}"
    );
    assert_eq!(left_out, 0);
}

#[test]
fn windows_further_off_than_eight_deviations_are_left_out() {
    for (deviations, gone) in [(6.5, 0), (9.5, 3)] {
        let noise = [1e-3, 1e-3, 2e-3];
        let mut evidence = evidence(4, 100, noise);
        evidence.windows[10].seen[0] += deviations * noise[0];
        evidence.windows[150].seen[1] -= deviations * noise[1];
        evidence.windows[350].seen[2] += deviations * noise[2];
        // Their own noise: at most one standard deviation.
        for (window, axis) in [(10, 0), (150, 1), (350, 2)] {
            let of = &mut evidence.windows[window];
            let own = misses(&map(), &[0, 1, 2, 3].map(tracker), &[of], exact())[axis];
            of.seen[axis] -= own - own.signum() * deviations * noise[axis];
        }
        assert_eq!(take_noise(&mut evidence).1, gone, "{deviations}");
        assert_eq!(evidence.windows.len(), 400 - gone);
    }
}

/// On a creeping floor all windows of a run have the same error: that is an error of the map, and
/// no reason to exclude a run.
#[test]
fn what_all_windows_of_a_run_miss_is_kept() {
    let mut evidence = evidence(6, 60, [1e-4, 1e-4, 1e-4]);
    for window in evidence.windows.iter_mut().filter(|window| window.run == 5) {
        window.seen[0] += 0.02;
    }
    assert_eq!(take_noise(&mut evidence).1, 0);
}

fn exact() -> Noise {
    Noise {
        position_m: 1.0,
        heading_rad: 1.0,
    }
}

#[test]
fn what_windows_miss_is_counted_in_deviations_axis_by_axis() {
    let evidence = evidence(2, 3, [0.0; 3]);
    let trackers = [tracker(0), tracker(1)];
    let mut off = evidence.clone();
    for window in &mut off.windows {
        window.seen[0] += 0.02;
        window.seen[1] -= 0.03;
    }
    let noise = Noise {
        position_m: 0.01,
        heading_rad: 0.1,
    };
    let all: Vec<&Window> = off.windows.iter().collect();
    let left = misses(&map(), &trackers, &all, noise);
    for missed in left.chunks(3) {
        let [x, y, turn] = missed else {
            panic!("three rows a window");
        };
        assert!(
            (x - 2.0).abs() < 1e-9 && (y + 3.0).abs() < 1e-9,
            "{missed:?}"
        );
        assert!(turn.abs() < 1e-9);
    }
    // An error in the turn moves the tracked point too.
    let mut turned = evidence.windows[4].clone();
    let before = turned.predicted(&map(), &trackers[1]);
    turned.seen[2] += 0.2;
    let left = misses(&map(), &trackers, &[&turned], noise);
    assert!((left[2] - 2.0).abs() < 1e-9);
    let lever = 2.0 * (libm::sin(0.5 * turned.seen[2]) - libm::sin(0.5 * (turned.seen[2] - 0.2)));
    assert!((left[0] * 0.01 - (before[0] - (before[0] - lever * 0.3))).abs() < 1e-9);
    assert!((left[1] * 0.01 + lever * -0.05).abs() < 1e-9);
}
