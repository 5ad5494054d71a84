//! Each term of the error budget has its own cause: losses to hopping, inconsistent rates and
//! springs are neither slip nor lag.

use std::path::Path;

use ilon_sim::{Run, Scenario, run};

fn driven(text: &str) -> Run {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = format!("robot = {{ file = \"mecanum4.toml\", roller_bodies = \"near\" }}\n{text}");
    let scenario = Scenario::from_toml(&text, "terms", folder).expect("a scenario");
    run(&scenario).expect("it runs")
}

/// Cylinders for rollers let the wheels hop. The motion lost in the air is lift-off.
#[test]
fn what_wheels_in_the_air_take_is_not_slip() {
    let found = driven(
        "rollers.profile_m = [[-0.0196, 0.012], [0.0196, 0.012]]\ntwist = { vx_m_s = 1.2, rest_s = 0.0, ramp_s = 1.0 }\nrun.duration_s = 3.0\n",
    );
    let ledger = &found.summary.ledger;
    assert!(found.summary.airborne_share.unwrap_or(0.0) > 0.3);
    // The robot moves along x.
    let (lift_off_m, slip_m) = (ledger.lift_off.x_m, ledger.slip.x_m.abs());
    assert!(
        lift_off_m > 0.1 && lift_off_m > 3.0 * slip_m,
        "{lift_off_m} {slip_m}"
    );
}

/// The front left wheel turns the wrong way: by r = w - M M^+ w each of four wheels is 3 of 6 rad/s
/// off the nearest motion, half of all.
#[test]
fn what_rates_take_that_contradict_each_other_is_not_slip() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = folder.path().join("rates.csv");
    let head = "t_s,front_left_rate_rad_s,front_right_rate_rad_s,rear_left_rate_rad_s,rear_right_rate_rad_s";
    std::fs::write(&log, format!("{head}\n0,0,0,0,0\n1,-6,6,6,6\n3,-6,6,6,6\n")).expect("a log");
    let file = log.display();
    let found = driven(&format!(
        "playback = {{ file = \"{file}\", drives = \"wheel_rates\" }}\nrun.duration_s = 3.0\n"
    ));
    let share = found.summary.rate_conflict_share.expect("four wheels");
    assert!((share - 0.5).abs() < 0.01, "{share}");
    let ledger = &found.summary.ledger;
    let (conflict_m, slip_m) = (ledger.conflict.path_m, ledger.slip.path_m);
    assert!(
        conflict_m > 0.1 && conflict_m > 5.0 * slip_m,
        "{conflict_m} {slip_m}"
    );
    let remarked = found
        .warnings
        .iter()
        .any(|remark| remark.contains("reversing `front_left`"));
    assert!(remarked, "{:?}", found.warnings);
}

/// With a law without rate targets no wheel lags.
#[test]
fn a_law_without_rate_targets_has_no_servo_term() {
    let found = driven(
        "reference.hold_pose = { x_m = 0, y_m = 0, heading_deg = 0 }\nwheel_loop.law = \"passive\"\nworld.floor.slope_deg = 5\n\
         run = { duration_s = 1.0, physics_dt_s = 0.001 }\n",
    );
    assert_eq!(found.summary.ledger.servo.path_m, 0.0);
    // It has a deflection.
    assert!(found.summary.position_error_final_m.unwrap_or(0.0) > 1e-3);
}

/// Encoders that count 3 % too little let the wheels turn 1 / 0.97 - 1 = 3.1 % too far: the
/// controller believes what they say, and no wheel loop errs.
#[test]
fn what_scaled_encoders_take_is_belief() {
    let names = ["front_left", "front_right", "rear_left", "rear_right"];
    let faults = names.map(|wheel| {
        format!("[[faults]]\nencoder_scaled = {{ wheel = \"{wheel}\", factor = 0.97 }}\n")
    });
    let found = driven(&format!(
        "twist = {{ vx_m_s = 0.3, rest_s = 0.0, ramp_s = 0.5 }}\nrun.duration_s = 4.0\n{}",
        faults.concat()
    ));
    let ledger = found.summary.ledger;
    let share = ledger.belief.x_m / found.summary.travelled_m;
    // Of the real way 3 % is not counted.
    assert!((share + 0.03).abs() < 1e-4, "{share}");
    // The ramp ends where the loops still owe a little.
    let [servo_m, belief_m] = [ledger.servo.x_m, ledger.belief.x_m];
    assert!(servo_m.abs() < 0.02 * belief_m.abs(), "{ledger:?}");
    assert!(!found.trace.header.knows_its_robot());
}

/// Up a ramp of 10 degrees the robot does not slide: what its way on a map lacks is the incline,
/// 1 - cos 10 degrees of the way along the ramp.
#[test]
fn what_the_way_up_a_ramp_takes_is_not_slip() {
    let angle_rad = 10_f64.to_radians();
    let rise_m = 3.0 * angle_rad.tan();
    let found = driven(&format!(
        "twist = {{ vx_m_s = 0.3 }}\nrun.duration_s = 6\n\
         [[world.floor.ramps]]\nx_m = 0.6\ny_m = 0\nlength_m = 3\nwidth_m = 1.5\nrise_m = {rise_m}\n"
    ));
    assert!(found.summary.slip_energy_j.expect("a figure") < 1e-3);
    // From 4 s on all wheels are on the ramp.
    let on_ramp: Vec<_> = (found.trace.records().iter())
        .filter(|row| row.t_s > 4.0)
        .collect();
    let (first, last) = (&on_ramp[0], &on_ramp[on_ramp.len() - 1]);
    let map_m = last.truth.pose.x_m - first.truth.pose.x_m;
    let taken = last.ledger.since(&first.ledger);
    let expected_m = map_m / angle_rad.cos() * (1.0 - angle_rad.cos());
    // Contacts give by micrometres, differently at both axles: 1e-5 of the wheelbase in the tilt,
    // 3e-6 of the way by tan 10 degrees; and those that hold the robot on the ramp creep as much.
    let near_m = 1e-5 * map_m;
    let off_m = taken.incline.x_m - expected_m;
    assert!(off_m.abs() < near_m, "{off_m} {expected_m}");
    assert!(taken.slip.path_m < near_m, "{taken:?}");
    assert!(map_m > 0.5 && expected_m > 7e-3);
    // At the foot, where the axles stand on two planes, wheels contradict each other instead.
    assert!(found.summary.ledger.slip.path_m < 1e-3);
}
