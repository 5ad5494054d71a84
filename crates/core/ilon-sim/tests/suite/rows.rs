//! A row is its period: what happened between two rows is in the second of them, however far apart they are.

use std::path::Path;

use ilon_sim::trace::{Record, Rows, Settings, Summary, Trace};
use ilon_sim::{Scenario, Simulation};

fn run(text: &str) -> (Trace, Summary) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = format!("robot.file = 'mecanum4.urdf'\n{text}");
    let scenario = Scenario::from_toml(&text, "rows", folder).expect("a scenario");
    let run = Simulation::new(&scenario).expect("it can be run").run();
    let summary = Summary::of(&run.trace, &Settings::default());
    (run.trace, summary)
}

/// Ahead with 1 m/s^2 up to 1.2 m/s on a floor of friction 0.2, as a staircase of wheel targets that changes every `stair_ms`, decided and
/// recorded every `period_ms`; all with physics steps of 1 ms. The last 0.4 s are steady.
fn stairs(stair_ms: u32, period_ms: u32) -> (Trace, Summary) {
    let stairs = 1200 / stair_ms;
    let schedule: Vec<String> = (1..=stairs)
        .map(|stair| {
            let t_s = f64::from(stair * stair_ms) * 1e-3;
            // As many digits as milliseconds have: a sum of binary fractions would be late by a control period.
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

/// The force is a pulse that decays within each stair. Rows of the last instants of their periods missed three quarters of it at 50 ms.
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
        // The same physics to the bit, and so the same extremes but for the rounding of sums.
        near(|summary| summary.friction_used_max, 1e-9);
        near(|summary| summary.slip_speed_max_m_s, 1e-9);
        near(|summary| summary.wheel_torque_max_n_m, 1e-9);
        near(|summary| summary.slip_speed_rms_m_s, 1e-9);
        let way_m = fine.travelled_m;
        for ((name, fine), (_, coarse)) in fine.ledger.named().iter().zip(coarse.ledger.named()) {
            // What slips does so in the first milliseconds of each stair, and spans of the budget are 5 ms.
            let apart_m = (fine.path_m - coarse.path_m).abs();
            assert!(apart_m < 1e-3 * way_m, "{stair_ms} ms, {name}: {apart_m} m");
        }
    }
    let (_, far) = stairs(50, 50);
    assert!(far.friction_used_max.expect("contacts") > 0.999);
    assert!(far.slip_speed_max_m_s.expect("contacts") > 0.02);
}

/// Newton: the forces of all wheels, each a mean over its row's period, accelerate the robot's mass.
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
            // The frame's origin also pitches by micrometres on its springy contacts: 1e-6 of 13 N s.
            assert!(
                (pushed_n_s - gained_n_s).abs() < 1e-4 * (1.0 + gained_n_s.abs()),
                "{period_ms} ms, {} s: {pushed_n_s} {gained_n_s}",
                now.t_s
            );
        }
        assert!(pushed_n_s > 13.0, "{pushed_n_s} N s");
    }
}

/// Rows that are left out take nothing with them: extremes, budget and saturation are those of all control periods.
#[test]
fn fewer_rows_say_the_same() {
    let circle = |every: u32| {
        run(&format!(
            "[reference.circle]\nradius_m = 0.5\nspeed_m_s = 0.6\nheading = {{ constant_deg = 0 }}\n\
             [guidance]\nwheel_rate_limit_rad_s = 13\n\
             [world.floor]\nfriction = 0.3\n\
             [run]\nduration_s = 3\nrecord_every = {every}\n"
        ))
    };
    let (_, all) = circle(1);
    let (_, few) = circle(20);
    for (what, a, b) in [
        ("grip", all.friction_used_max, few.friction_used_max),
        ("slip", all.slip_speed_max_m_s, few.slip_speed_max_m_s),
        ("torque", all.wheel_torque_max_n_m, few.wheel_torque_max_n_m),
        ("error", all.position_error_max_m, few.position_error_max_m),
        (
            "command",
            all.wheel_rate_command_max_rad_s,
            few.wheel_rate_command_max_rad_s,
        ),
    ] {
        assert_eq!(a, b, "{what}");
    }
    assert_eq!(all.ledger, few.ledger);
    let near = |a: Option<f64>, b: Option<f64>| (a.expect("a figure") - b.expect("a figure")).abs();
    // Means of the same numbers, added up in another order.
    assert!(near(all.saturated_share, few.saturated_share) < 1e-12);
    assert!(near(all.slip_speed_rms_m_s, few.slip_speed_rms_m_s) < 1e-12);
    assert!(near(all.airborne_share, few.airborne_share) < 1e-12);
}

/// A limit takes of the command wherever the ideal kinematics asks more of a wheel than it is given, in whatever way; of a reference and of a twist.
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
            // Of four wheels in the X one turns with every pair of signs: |vx| + |vy| + 0.31 m |w| over 50 mm.
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

/// Until the last physics step targets rise and wheels slide. Whatever the period and however few rows are written, rows add up to what the run
/// came to: the momentum of the forces, all energies and the error budget.
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
