//! A row covers its period: everything between two rows is in the second of them, whatever their
//! distance.

use std::path::Path;

use ilon_sim::trace::rows::thinned;
use ilon_sim::trace::{Record, Rows, Settings, Summary, Trace};
use ilon_sim::{Scenario, Simulation};

/// Rates of the wheels in rad/s that change within a second.
const LOG: &str = "t_s,front_left_rate_rad_s,front_right_rate_rad_s,rear_left_rate_rad_s,rear_right_rate_rad_s\n\
                   0,0,0,0,0\n0.7,6,5,4,7\n1.3,-2,3,4,-5\n2.5,0,0,0,0\n";

fn run(text: &str) -> (Trace, Summary) {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::copy(robots.join("mecanum4.urdf"), at("mecanum4.urdf")).expect("a robot");
    std::fs::write(at("log.csv"), LOG).expect("a log");
    let text = format!("robot.file = 'mecanum4.urdf'\n{text}");
    let scenario =
        Scenario::from_toml(&text, "rows", folder.path().to_owned()).expect("a scenario");
    let run = Simulation::new(&scenario).expect("it can be run").run();
    let summary = Summary::of(&run.trace, &Settings::default());
    (run.trace, summary)
}

/// Ahead with 1 m/s^2 up to 1.2 m/s on a floor of friction 0.2, as a staircase of wheel targets
/// that changes every `stair_ms`, decided and recorded every `period_ms`; all with physics steps of
/// 1 ms. The last 0.4 s are steady.
fn stairs(stair_ms: u32, period_ms: u32) -> (Trace, Summary) {
    let stairs = 1200 / stair_ms;
    let schedule: Vec<String> = (1..=stairs)
        .map(|stair| {
            let t_s = f64::from(stair * stair_ms) * 1e-3;
            // Digits to the millisecond: a sum of binary fractions would be late by a control
            // period.
            format!("{{ from_s = {:.3}, vx_m_s = {t_s} }}", 0.2 + t_s)
        })
        .collect();
    run(&format!(
        "[twist]\nvx_m_s = 0\nrest_s = 0.2\nramp_s = 0.0\nschedule = [{}]\n\
         [world.floor]\nfriction = 0.2\n\
         [run]\nduration_s = 1.8\ncontrol_dt_s = {}\nphysics_dt_s = 0.001\n",
        schedule.join(", "),
        f64::from(period_ms) * 1e-3,
    ))
}

/// The force is a pulse that decays within each stair. Rows of the last instants of their periods
/// missed three quarters of it at 50 ms.
#[test]
fn extremes_and_budget_do_not_depend_on_how_often_rows_are_written() {
    for stair_ms in [10, 20, 50] {
        let (_, fine) = stairs(stair_ms, 1);
        let (_, coarse) = stairs(stair_ms, stair_ms);
        let near = |what: fn(&Summary) -> Option<f64>, share: f64| {
            let (a, b) = (
                what(&fine).expect("a figure"),
                what(&coarse).expect("a figure"),
            );
            assert!((a - b).abs() <= share * a.abs(), "{stair_ms} ms: {a} {b}");
        };
        // The same physics to the bit, and so the same extremes except for the rounding of sums.
        near(|summary| summary.friction_used_max, 1e-9);
        near(|summary| summary.slip_speed_max_m_s, 1e-9);
        near(|summary| summary.wheel_torque_max_n_m, 1e-9);
        near(|summary| summary.slip_speed_rms_m_s, 1e-9);
        near(|summary| summary.wheel_rate_error_rms_rad_s, 1e-9);
        let way_m = fine.travelled_m;
        for ((name, fine), (_, coarse)) in fine.ledger.named().iter().zip(coarse.ledger.named()) {
            // Slip occurs in the first milliseconds of each stair, and spans of the budget are 5
            // ms.
            let apart_m = (fine.path_m - coarse.path_m).abs();
            assert!(apart_m < 1e-3 * way_m, "{stair_ms} ms, {name}: {apart_m} m");
        }
    }
    let (_, far) = stairs(50, 50);
    assert!(far.friction_used_max.expect("contacts") > 0.999);
    assert!(far.slip_speed_max_m_s.expect("contacts") > 0.02);
}

/// Newton: the forces of all wheels, each a mean over its row's period, accelerate the robot's
/// mass.
#[test]
fn the_forces_of_a_row_are_mass_times_acceleration() {
    for period_ms in [1, 10, 20, 50] {
        let (trace, _) = stairs(50, period_ms);
        let mass_kg = trace.header.mass_kg;
        let mut pushed_n_s = 0.0;
        for row in 1..trace.records().len() {
            let (before, now) = (&trace.records()[row - 1], &trace.records()[row]);
            let force_n: f64 = trace
                .wheels_at(row)
                .iter()
                .map(|wheel| wheel.force_x_n)
                .sum();
            pushed_n_s += force_n * (now.t_s - before.t_s);
            let gained_n_s = mass_kg * now.truth.twist_in_body.vx_m_s;
            // The frame's origin also pitches by micrometres on its springy contacts: 1e-6 of 13 N
            // s.
            assert!(
                (pushed_n_s - gained_n_s).abs() < 1e-4 * (1.0 + gained_n_s.abs()),
                "{period_ms} ms, {} s: {pushed_n_s} {gained_n_s}",
                now.t_s
            );
        }
        assert!(pushed_n_s > 13.0, "{pushed_n_s} N s");
    }
}

/// Rows that are left out take nothing with them: the figures of a run are those of all its control
/// periods, in the run and from its trace, and its rows are those of all control periods joined.
#[test_case::test_case(
    "[reference.circle]\nradius_m = 0.5\nspeed_m_s = 0.6\nheading = { constant_deg = 0 }\n\
     [guidance]\nwheel_rate_limit_rad_s = 13\n[world.floor]\nfriction = 0.3\n\
     [sensors.pose]\nposition_noise_m = 0.02\nrate_hz = 50\n"; "guidance"
)]
#[test_case::test_case(
    "[twist]\nvy_m_s = 0.5\nomega_rad_s = 0.4\nrest_s = 0.1\nsettle_s = 0.2\n[world.floor]\nfriction = 0.4\n"; "twist"
)]
#[test_case::test_case(
    "[playback]\nfile = 'log.csv'\ndrives = 'wheel_rates'\n"; "playback"
)]
#[test_case::test_case(
    "[twist]\nvx_m_s = 0.4\nrest_s = 0.1\nschedule = [{ from_s = 1.1, vx_m_s = -0.4 }]\n\
     [world.floor]\nslope_deg = 8\n[wheel_loop]\nlaw = 'computed_torque'\n"; "slope"
)]
#[test_case::test_case(
    "[twist]\nvx_m_s = 0.4\nrest_s = 0.1\n\
     [[world.floor.boxes]]\nx_m = 0.5\ny_m = 0.2\nlength_x_m = 0.1\nlength_y_m = 0.3\nheight_m = 0.01\n\
     [[world.bodies]]\nname = 'box'\nx_m = 0.45\ny_m = -0.1\nmass_kg = 1\nbox = { size_m = [0.1, 0.1, 0.1] }\n\
     [[faults]]\npush = { from_s = 0.5, lasts_s = 0.13, impulse_x_n_s = -2, impulse_y_n_s = 3 }\n\
     [[faults]]\npayload = { from_s = 1.0, mass_kg = 3 }\n"; "faults"
)]
fn fewer_rows_say_the_same(text: &str) {
    let every = |every: u32| {
        run(&format!(
            "{text}[run]\nduration_s = 2\nrecord_every = {every}\n"
        ))
    };
    let (trace, all) = every(1);
    for every_other in [3, 7, 20] {
        let (of_few, few) = every(every_other);
        let mut expected = all.clone();
        expected.trace_hash.clone_from(&few.trace_hash);
        assert_eq!(few, expected, "each {every_other}");
        let Ok(thinned) = thinned(&trace, every_other as usize);
        assert_eq!(of_few.row_count(), thinned.row_count());
        for (row, (ours, theirs)) in of_few.steps().zip(thinned.steps()).enumerate() {
            // How sure messages are of a twist is for rows as far apart as they are.
            let [ours, theirs] = [ours, theirs].map(|(record, wheels)| {
                let record = Record {
                    reckoned: None,
                    ..*record
                };
                (record, wheels)
            });
            assert!(ours == theirs, "each {every_other}, row {row}");
        }
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("trace.parquet");
        of_few.write_parquet(&path).expect("it is written");
        let read = Trace::read_parquet(&path).expect("it is read");
        assert_eq!(Summary::of(&read, &Settings::default()), few);
    }
}

/// A limit takes of the command wherever the ideal kinematics asks more of a wheel than it is
/// given, in whatever way; of a reference and of a twist.
#[test]
fn the_saturated_share_is_of_the_time_in_which_a_limit_takes_anything() {
    for saturation in ["clip", "scale", "prioritised", "none"] {
        for motion in [
            "[reference.circle]\nradius_m = 0.5\nspeed_m_s = 0.5\n",
            "[twist]\nvx_m_s = 0.7\nvy_m_s = 0.2\nrest_s = 0.2\nramp_s = 1.0\n",
        ] {
            // Tasks by priority are limited one by one, whatever their sum is.
            if saturation == "prioritised" && motion.starts_with("[reference") {
                continue;
            }
            let (trace, of_run) = run(&format!(
                "{motion}[guidance]\nwheel_rate_limit_rad_s = 12\nsaturation = \"{saturation}\"\n[run]\nduration_s = 2\n"
            ));
            let rows = trace.records();
            // Of four wheels in the X one turns with every pair of signs: |vx| + |vy| + 0.31 m |w|
            // over 50 mm.
            let is_limited = |row: &&Record| {
                let asked = row.command_twist_in_body;
                let rim_m_s =
                    asked.vx_m_s.abs() + asked.vy_m_s.abs() + 0.31 * asked.omega_rad_s.abs();
                rim_m_s / 0.05 > 12.0 * (1.0 + 1e-9)
            };
            let expected = match saturation {
                "none" => 0.0,
                _ => rows.iter().filter(is_limited).count() as f64 / rows.len() as f64,
            };
            let share = of_run.saturated_share.expect("a share");
            assert!(saturation == "none" || expected > 0.2, "{motion}");
            // One row at the start is of no period.
            assert!(
                (share - expected).abs() < 0.02,
                "{saturation} {motion}: {share} {expected}"
            );
        }
    }
}

/// Targets rise and wheels slide until the last physics step. Whatever the period and however few
/// rows are written, rows add up to the totals of the run: the momentum of the forces, all energies
/// and the error budget.
#[test]
fn rows_add_up_to_the_run() {
    for period_ms in [1, 10, 20, 50] {
        let run = |every: u32| {
            run(&format!(
                "[twist]\nvx_m_s = 1.2\nrest_s = 0.2\nramp_s = 1.2\n[world.floor]\nfriction = 0.2\n\
                 [run]\nduration_s = 1.4\ncontrol_dt_s = {}\nphysics_dt_s = 0.001\nrecord_every = {every}\n",
                f64::from(period_ms) * 1e-3
            ))
        };
        let (all, of_all) = run(1);
        assert_eq!(all.row_count() as u32, 1400 / period_ms + 1);
        for every in [1, 3, 7, 20] {
            let what = format!("{period_ms} ms, each {every}");
            let (few, of_few) = run(every);
            let (end, last) = (all.records().last(), few.records().last());
            let (end, last) = (end.expect("rows"), last.expect("rows"));
            assert!((last.t_s - 1.4).abs() < 1e-12, "{what}: {} s", last.t_s);
            assert_eq!((last.truth, last.ledger), (end.truth, end.ledger), "{what}");
            let sums = |of: &Summary| {
                let energy = &of.energy;
                [
                    energy.motor_j,
                    energy.slip_j,
                    energy.spin_up_j,
                    energy.bearing_j,
                    energy.impact_j,
                ]
            };
            assert_eq!(sums(&of_few), sums(&of_all), "{what}");
            assert_eq!(of_few.ledger, of_all.ledger, "{what}");
            assert_eq!(of_few.friction_used_max, of_all.friction_used_max, "{what}");
            let (mut pushed_n_s, mut lasted_s) = (0.0, 0.0);
            for (before, row) in few.records().iter().zip(1..few.row_count()) {
                let span_s = few.records()[row].t_s - before.t_s;
                let forces = few.wheels_at(row).iter().map(|wheel| wheel.force_x_n);
                pushed_n_s += forces.sum::<f64>() * span_s;
                lasted_s += few.header.row_span_s(few.records()[row].t_s);
            }
            // The frame's origin pitches by micrometres on its springy contacts: 1e-6 of 13 N s.
            let gained_n_s = few.header.mass_kg * last.truth.twist_in_body.vx_m_s;
            assert!(
                (pushed_n_s - gained_n_s).abs() < 1e-4 * gained_n_s,
                "{what}: {pushed_n_s} {gained_n_s}"
            );
            // Spans of all rows are the whole run, to rounding.
            assert!((lasted_s - 1.4).abs() < 1e-9, "{what}: {lasted_s} s");
        }
    }
}
