//! Figures of docs/measured.md that are not transients: wheel loads, heat of sliding in a fast
//! turn, energy lost at hand-overs.

use crate::oracle::case::Case;
use crate::oracle::cases::{COASTS_FROM_S, coasting, steady, twist};
use crate::oracle::course::{Course, Row};
use crate::oracle::engines::{Springs, in_ilon, on_springs};

const STIFFNESSES_N_M: [f64; 5] = [2e5, 2e6, 2e7, 8e7, 3.2e8];
const ILON_STEPS_S: [f64; 4] = [2.5e-3, 1e-3, 5e-4, 2.5e-4];

/// Both engines on a case, each with several settings.
fn all(case: &Case) -> Vec<(String, Course)> {
    let springs = STIFFNESSES_N_M.map(|k| {
        (
            format!("oracle, {k:.1e} N/m"),
            on_springs(case, Springs::of(k)),
        )
    });
    let steps = ILON_STEPS_S.map(|h| (format!("ilon, {} ms", 1e3 * h), in_ilon(case, h, None)));
    springs.into_iter().chain(steps).collect()
}

/// Mean and standard deviation over rows and wheels, lowest and highest of any wheel's load over
/// the last three seconds.
fn loads_of(course: &Course) -> [f64; 4] {
    let end_s = course.end().t_s;
    let held = course.rows.iter().filter(|row| row.t_s > end_s - 3.0);
    let loads: Vec<f64> = held.flat_map(|row| row.loads_n.iter().copied()).collect();
    let mean = loads.iter().sum::<f64>() / loads.len() as f64;
    let square = loads.iter().map(|load| (load - mean).powi(2)).sum::<f64>() / loads.len() as f64;
    let low = loads.iter().copied().fold(f64::INFINITY, f64::min);
    let high = loads.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    [mean, square.sqrt(), low, high]
}

#[test]
#[ignore = "prints the wheel loads of docs/measured.md; a minute with --release"]
fn wheel_loads_in_steady_drives() {
    println!("\n| drive | engine | mean N | standard deviation N | lowest and highest N |");
    println!("|---|---|---|---|---|");
    for (name, robot, end) in [
        ("D1 ahead 0.3 m/s", "mecanum4", twist(0.3, 0.0, 0.0)),
        ("D2 sideways 0.3 m/s", "mecanum4", twist(0.0, 0.3, 0.0)),
        ("D3 yaw 1 rad/s", "mecanum4", twist(0.0, 0.0, 1.0)),
        ("D1 volksbot", "volksbot", twist(0.3, 0.0, 0.0)),
        ("D3 volksbot", "volksbot", twist(0.0, 0.0, 1.0)),
    ] {
        for (engine, course) in all(&steady(name, robot, end)) {
            let [mean, deviation, low, high] = loads_of(&course);
            println!("| {name} | {engine} | {mean:.2} | {deviation:.3} | {low:.2} to {high:.2} |");
        }
    }
}

#[test]
#[ignore = "prints the fast turn of docs/measured.md; a minute with --release"]
fn heat_in_a_fast_turn() {
    let case = steady("1 m/s with 3 rad/s", "mecanum4", twist(1.0, 0.0, 3.0));
    println!("\n| engine | sliding J | other J | sliding, last 3 s | other, last 3 s | drives J |");
    println!("|---|---|---|---|---|---|");
    for (engine, course) in all(&case) {
        let (end, held) = (course.end().sums, course.at(2.5).sums);
        println!(
            "| {engine} | {:.4} | {:.4} | {:.4} | {:.4} | {:.3} |",
            end.slip_j,
            end.other_j,
            end.slip_j - held.slip_j,
            end.other_j - held.other_j,
            end.drives_j,
        );
    }
}

/// Number of hand-overs of all wheels between two rows.
fn hand_overs(case: &Case, from: &Row, to: &Row) -> f64 {
    let wheels = case
        .robot
        .wheels
        .iter()
        .zip(from.wheels_rad.iter().zip(&to.wheels_rad));
    wheels
        .map(|(wheel, (from, to))| {
            (to - from).abs() * wheel.rollers.len() as f64 / std::f64::consts::TAU
        })
        .sum()
}

#[test]
#[ignore = "prints the hand-overs of docs/measured.md; a minute with --release"]
fn energy_lost_while_coasting() {
    println!("\n| coasting | engine | kinetic mJ | sliding mJ | other mJ | hand-overs | mJ each |");
    println!("|---|---|---|---|---|---|---|");
    for (name, from) in [
        ("ahead 0.5 m/s", twist(0.5, 0.0, 0.0)),
        ("sideways 0.5 m/s", twist(0.0, 0.5, 0.0)),
        ("yaw 3 rad/s", twist(0.0, 0.0, 3.0)),
    ] {
        let case = coasting(name, from);
        for (engine, course) in all(&case) {
            let (from, to) = (course.at(COASTS_FROM_S), course.end());
            let slip_mj = 1e3 * (to.sums.slip_j - from.sums.slip_j);
            let other_mj = 1e3 * (to.sums.other_j - from.sums.other_j);
            let count = hand_overs(&case, from, to);
            println!(
                "| {name} | {engine} | {:.1} to {:.1} | {slip_mj:.2} | {other_mj:.2} | {count:.0} | {:.4} |",
                1e3 * from.sums.kinetic_j,
                1e3 * to.sums.kinetic_j,
                (slip_mj + other_mj) / count,
            );
        }
    }
}
