//! Gains of the guidance too high for its control period: refused, reported, and seen in the
//! simulation.

use ilon_sim::{Error, Run, Scenario};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");

/// A robot that holds its pose, with an initial error of 0.1 mm and 0.1 mrad, so that no motor is
/// at its limit.
fn scenario(keys: &str) -> Scenario {
    scenario_of(4.0, keys)
}

/// The same over some seconds.
fn scenario_of(duration_s: f64, keys: &str) -> Scenario {
    let text = format!(
        "robot = {{ file = \"mecanum4.urdf\", y_m = 1e-4, heading_deg = 0.005729578 }}\n\
         reference.hold_pose = {{ x_m = 0, y_m = 0, heading_deg = 0 }}\nrun.duration_s = {duration_s}\n{keys}"
    );
    Scenario::from_toml(&text, "stability", FOLDER).expect("a scenario")
}

/// The remark on a scenario's gains before it is run, or the reason for a refusal.
fn said(keys: &str) -> Result<String, String> {
    let scenario = scenario(keys);
    let robot = ilon_sim::load_robot(&scenario).expect("a shipped robot");
    match ilon_sim::resolve(&scenario, &robot) {
        Ok(resolved) => {
            let mut lines = resolved.warnings().iter();
            let of_guidance = lines.find(|line| line.starts_with("the guidance"));
            Ok(of_guidance.cloned().unwrap_or_default())
        }
        Err(Error::Scenario(fault)) => Err(format!("{}; {}", fault.message, fault.help)),
        Err(other) => panic!("{other:?}"),
    }
}

/// Gains on position and heading, at a period of 0.25 s, for which wheel loops of 60 rad/s are
/// practically instantaneous: 1 part in 500.
fn gains(position_per_s: f64, heading_per_s: f64) -> String {
    format!(
        "run.control_dt_s = 0.25\nguidance.position_gain_per_s = {position_per_s}\nguidance.heading_gain_per_s = {heading_per_s}\n"
    )
}

#[test]
fn a_gain_is_remarked_from_where_it_overshoots_on_and_refused_from_its_bound_on() {
    assert_eq!(said(&gains(3.8, 3.8)).as_deref(), Ok(""));
    for (position, heading, key, from) in
        [(4.0, 1.0, "position", 0.968), (1.0, 4.0, "heading", 0.974)]
    {
        let remark = said(&gains(position, heading)).expect("a remark");
        let expected = format!(
            "the guidance overshoots: `guidance.{key}_gain_per_s` times the period of 0.25 s is 1.000, and from 0."
        );
        assert!(remark.starts_with(&expected), "{remark}");
        // Instantaneous wheels overshoot from 1 on; with the integral of these loops, from a
        // thirtieth less on.
        let swings = format!("from {from} on the robot swings");
        assert!(remark.contains(&swings), "{remark}");
    }
    assert!(said(&gains(7.9, 7.9)).is_ok());
    for (position, heading, key) in [(8.1, 1.0, "position"), (1.0, 10.0, "heading")] {
        let refusal = said(&gains(position, heading)).expect_err("a refusal");
        let expected = format!("the guidance cannot settle: `guidance.{key}_gain_per_s` times");
        assert!(refusal.starts_with(&expected), "{refusal}");
        assert!(refusal.contains("choose a gain below 3.8"), "{refusal}");
    }
}

/// For a matrix the larger eigenvalue counts: that of [[6, 2.3], [2.3, 1]] is 3.5 + 3.4 = 6.9 /s,
/// that with 9 in place of 6 is 5 + 4.6 = 9.6 /s. For tasks, the gains of those that are served.
#[test]
fn matrices_and_tasks_are_judged_by_what_they_feed_back() {
    let matrix = |xx: f64| {
        format!(
            "run.control_dt_s = 0.25\nguidance.position_gain_matrix_per_s = [[{xx}, 2.3], [2.3, 1.0]]\n"
        )
    };
    let remark = said(&matrix(6.0)).expect("a remark");
    assert!(
        remark.contains("overshoots: the largest eigenvalue of"),
        "{remark}"
    );
    assert!(said(&matrix(9.0)).is_err_and(|words| words.contains("the largest eigenvalue of")));
    let tasks = |tasks: &str| format!("{}guidance.tasks = {tasks}\n", gains(10.0, 1.0));
    assert!(said(&tasks("[\"position_feedback\"]")).is_err());
    assert_eq!(said(&tasks("[\"heading_feedback\"]")).as_deref(), Ok(""));
    let face = said(&tasks("[{ face = { x_m = 1, y_m = 0, gain_per_s = 9 } }]"));
    assert!(face.is_err_and(|words| words.contains("`guidance.tasks.0.face.gain_per_s`")));
}

/// A delay of one period halves the bound, and so does a camera with a sample every second period;
/// a filter restores both.
#[test]
fn late_and_rare_poses_lower_the_bound_unless_a_filter_brings_them_up_to_the_present() {
    for late in [
        "sensors.pose.latency_s = 0.25\n",
        "sensors.pose.latency_s = 0.1\n",
        "sensors.pose.rate_hz = 2\n",
    ] {
        let of = |keys: &str| said(&format!("{}{late}{keys}", gains(4.1, 1.0)));
        assert!(of("").is_err(), "{late}");
        assert!(of("sensors.fusion = {}\n").is_ok(), "{late}");
    }
    // Poses alternating between one and two periods are not certain to be unstable.
    let odd = said(&format!("{}sensors.pose.rate_hz = 3\n", gains(7.0, 1.0)));
    assert!(odd.is_ok_and(|words| words.contains("unstable")));
}

/// An open-loop command has no gains.
#[test]
fn gains_that_nothing_uses_are_not_judged() {
    let text = format!(
        "robot.file = \"mecanum4.urdf\"\ntwist.vx_m_s = 0.1\nrun.duration_s = 3\n{}",
        gains(50.0, 50.0)
    );
    let scenario = Scenario::from_toml(&text, "stability", FOLDER).expect("a scenario");
    let robot = ilon_sim::load_robot(&scenario).expect("a shipped robot");
    let resolved = ilon_sim::resolve(&scenario, &robot).expect("it can be run");
    assert!(
        !resolved
            .warnings()
            .iter()
            .any(|line| line.contains("guidance"))
    );
}

/// The largest error of the last fifth of a run over the initial one: of position, and of heading.
fn left(run: &Run) -> [f64; 2] {
    let records = run.trace.records();
    let last = &records[records.len() * 4 / 5..];
    let most = |of: fn(&ilon_sim::trace::Record) -> f64| last.iter().map(of).fold(0.0, f64::max);
    [
        most(|row| row.truth.pose.y_m.abs()) / 1e-4,
        most(|row| row.truth.pose.heading_rad.abs()) / 1e-4,
    ]
}

/// In the simulation an error decays 10 % below the predicted bound, and grows 10 % above it: for
/// slow and fast control, all wheel laws, and late poses. If the loops allow more than
/// instantaneous wheels, it decays beyond 2.
#[test]
fn errors_die_out_below_the_bound_and_grow_above_it() {
    let mut grown = 0;
    for (control_dt_s, keys) in [
        (0.01, ""),
        (0.005, ""),
        (0.02, "sensors.pose.latency_s = 0.02\n"),
        (0.02, "sensors.pose.latency_s = 0.03\n"),
        (0.05, "wheel_loop.law = \"computed_torque\"\n"),
        (0.05, "wheel_loop.bandwidth_rad_s = 20\n"),
        (0.01, "sensors.pose.rate_hz = 50\n"),
        (0.02, "wheel_loop.latency_s = 0.01\n"),
        (
            0.05,
            "wheel_loop = { law = \"computed_torque\", latency_s = 0.01, bandwidth_rad_s = 20 }\n",
        ),
    ] {
        // `None` if it is refused.
        let run = |position_per_s: f64, heading_per_s: f64| {
            // Loops that bear late torques are slow, and so is the growth.
            let periods = if keys.contains("wheel_loop") && keys.contains("latency") {
                1600.0
            } else {
                400.0
            };
            let duration_s = f64::max(periods * control_dt_s, 4.0);
            let scenario = scenario_of(
                duration_s,
                &format!(
                    "run.control_dt_s = {control_dt_s}\nguidance.position_gain_per_s = {position_per_s}\n\
                 guidance.heading_gain_per_s = {heading_per_s}\n{keys}"
                ),
            );
            ilon_sim::run(&scenario).ok()
        };
        let plain = run(1.0, 1.0).expect("low gains settle");
        let guidance = plain.trace.header.guidance.expect("it tracks");
        let bound = |from: Option<f64>| from.expect("a bound") / control_dt_s;
        let (position, heading) = (
            bound(guidance.position_unstable_from),
            bound(guidance.heading_unstable_from),
        );
        for (error, of) in [(0, position), (1, heading)] {
            let at = |share: f64| match error {
                0 => run(share * of, 1.0),
                _ => run(1.0, share * of),
            };
            let left_of = |run: &Run| left(run)[error];
            let below = left_of(&at(0.9).expect("it settles"));
            let above = at(1.1).as_ref().map(left_of);
            println!(
                "T {control_dt_s} {keys:?} error {error}, bound {of:.1} /s: {below:.1e}, {above:.1?}"
            );
            assert!(below < 0.1, "{keys}: {below}");
            assert!(above.is_none_or(|above| above > 1.5), "{keys}: {above:?}");
            grown += usize::from(above.is_some());
        }
    }
    // The others are refused above.
    assert!(grown >= 6, "{grown}");
    let beyond_two = scenario_of(
        10.0,
        "run.control_dt_s = 0.05\nguidance.position_gain_per_s = 48\n",
    );
    assert!(left(&ilon_sim::run(&beyond_two).expect("it settles"))[0] < 0.1);
}

/// No bound of the gains is known for tyres that are not steered, nor where steered ones turn to each
/// twist: the trace holds that nothing is known, and is read back as it was written.
#[test]
fn a_trace_without_a_bound_of_the_gains_is_read_back() {
    let folder = tempfile::tempdir().expect("a folder");
    for robot in ["differential.urdf", "swerve4.urdf", "tricycle.toml"] {
        let text = format!(
            "robot.file = \"{robot}\"\nreference.circle = {{ radius_m = 1, speed_m_s = 0.3 }}\nrun.duration_s = 0.05\n"
        );
        let scenario = Scenario::from_toml(&text, "unbounded", FOLDER).expect("a scenario");
        let trace = ilon_sim::run(&scenario).expect("a run").trace;
        let guidance = trace.header.guidance.expect("it tracks");
        assert_eq!(guidance.position_unstable_from, None, "{robot}");
        let path = folder.path().join("trace.parquet");
        trace.write_parquet(&path).expect("written");
        let read = ilon_trace::Trace::read_parquet(&path).expect("read back");
        assert_eq!(read.header, trace.header, "{robot}");
    }
}
