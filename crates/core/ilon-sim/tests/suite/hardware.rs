//! Properties of real hardware: motors that differ, encoders with counts, stages with a dead band,
//! integrals that wind up.

use std::path::Path;

use ilon_sim::{Plant, Run, Scenario, WheelCommand, run};
use test_case::test_case;

fn scenario(text: &str) -> Scenario {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = format!(
        "robot = {{ file = \"mecanum4.urdf\", roller_bodies = \"near\" }}\nrun.duration_s = 4\n{text}\n"
    );
    Scenario::from_toml(&text, "hardware", folder).expect("a scenario")
}

fn driven(text: &str) -> Run {
    run(&scenario(text)).expect("it runs")
}

/// Motors on full voltage, k (u w0 - w) with k = 0.1 N m s/rad and w0 = 10 rad/s, the front left
/// one on u = 0.9, and nothing slides.
///
/// With the wheels' rates R xi / rho (rows (1, -+1, -+L) of R, R^T R = diag(4, 4, 4 L^2), L = 0.31
/// m) and bearings of c = 1e-3 N m s/rad the forces R^T tau / rho = (k w0 R^T u - (k + c) R^T R xi
/// / rho) / rho are those of the bend, m omega (-vy, vx, 0). With V = rho w0 k / (k + c) = 0.49505
/// m/s: vx = 0.975 V = 0.4827 m/s; omega = 0.025 V / L = 0.03992 rad/s; vy = 0.025 V - rho^2 / (4
/// (k + c)) m omega vx, of whose first part nine rollers at 45 deg lose 2 %. With m = 11.36 kg that
/// is 0.01213 - 0.00135 = 0.01078 m/s.
#[test]
fn a_weaker_motor_bends_the_way_as_least_squares_have_it() {
    let text = |weak: &str| {
        format!(
            "motors.dc = {{ stall_torque_n_m = 1.0, no_load_rate_rad_s = 10.0 }}\nmotors.wheels = {{ {weak} }}\n\
             guidance.saturation = \"none\"\ntwist = {{ vx_m_s = 1.4, rest_s = 0.0, ramp_s = 0.5, settle_s = 2.0 }}\nwheel_loop.anti_windup = \"none\""
        )
    };
    let of = |weak: &str| driven(&text(weak)).summary.twist_mean.expect("means");
    let even = of("");
    let found = of("front_left.forwards = 0.9");
    // Bearings and rollers take a share of both: 1e-3 N m s/rad beside 0.1, a hundredth.
    assert!((even.vx_m_s / 0.5 - 1.0).abs() < 0.015, "{even:?}");
    let mass_kg = driven(&text("")).trace.header.mass_kg;
    let unit_m_s = even.vx_m_s;
    assert!(
        (found.vx_m_s / unit_m_s - 0.975).abs() < 2e-3,
        "{found:?} {even:?}"
    );
    let paper_m_s = 0.5 * 0.1 / 0.101;
    let bend_n = mass_kg * (0.975 * paper_m_s) * (0.025 * paper_m_s / 0.31);
    let sideways_m_s = 0.98 * 0.025 * paper_m_s - bend_n / (4.0 * 0.101 / (0.05 * 0.05));
    assert!((sideways_m_s - 0.01078).abs() < 1e-5, "{sideways_m_s}");
    // Rollers shift the contacts by up to a quarter of the radius, which bends the lever by
    // percents: 5 % of 0.0108 m/s.
    assert!(
        (found.vy_m_s - sideways_m_s).abs() < 5e-4,
        "{found:?} {sideways_m_s}"
    );
    let turned = found.omega_rad_s / unit_m_s * 0.31;
    assert!((turned - 0.025).abs() < 2e-3, "{found:?} {even:?}");
    // Backwards it is as strong as the others.
    assert_eq!(of("front_left.backwards = 0.9").vx_m_s, even.vx_m_s);
}

/// 20 counts a turn, read every 20 ms: one count is 2 pi / 20 / 0.02 = 15.7 rad/s. Torques of 0.05
/// (2 - w) against bearings of 1e-3 N m s/rad turn a wheel at w = 2 x 0.05 / 0.051 = 1.961 rad/s,
/// and a count comes in w x 0.02 x 20 / 2 pi = 12.48 % of the reads.
#[test]
fn an_encoder_of_twenty_counts_says_one_count_or_none() {
    let text = "twist = {}\nsensors.encoders.counts_per_turn = 20\nrun.control_dt_s = 0.02\nrun.physics_dt_s = 2e-3";
    let mut plant = Plant::of_scenario(&scenario(text)).expect("it stands");
    let count_rad_s = std::f64::consts::TAU / 20.0 / 0.02;
    let (mut some, mut reads, mut turned_rad) = (0, 0, 0.0);
    for period in 0..600 {
        let seen = plant.observe().wheel_rates_rad_s[0];
        if period > 50 {
            reads += 1;
            let is_one = (seen - count_rad_s).abs() < 1e-9;
            assert!(is_one || seen == 0.0, "{seen}");
            some += i32::from(is_one);
        }
        // The ideal motor torques are unknown here: the wheels are controlled by their real rates.
        let real = plant.world().robot().wheel_rates_rad_s().to_vec();
        let torques: Vec<f64> = real.iter().map(|rate| 0.05 * (2.0 - rate)).collect();
        if period > 50 {
            turned_rad += 0.02 * real[0];
        }
        plant
            .advance(WheelCommand::Torques(&torques), 0.02)
            .expect("it goes");
    }
    let share = f64::from(some) / f64::from(reads);
    // For the real rotation of the wheel, a little less than 2 rad/s; one count more or less of
    // seventy.
    let expected = turned_rad / f64::from(reads) * 20.0 / std::f64::consts::TAU;
    // Hand-overs shake the rate by some per mille.
    assert!((expected - 0.1248).abs() < 1e-3, "{expected}");
    assert!(
        (share - expected).abs() < 2.0 / f64::from(reads),
        "{share} {expected}"
    );
}

/// A drive with a dead band of 0.2 N m does not move a wheel for which a P loop demands less: 0.1 N
/// m s/rad times 1.5 rad/s are 0.15 N m.
#[test]
fn a_dead_band_swallows_small_torques() {
    let text = |band: &str| {
        format!(
            "wheel_loop = {{ proportional_n_m_s = 0.1, integral_n_m = 0 }}\nmotors.dead_band_n_m = {band}\n\
             twist = {{ vx_m_s = 0.075, rest_s = 0.0, ramp_s = 0.2, settle_s = 1.0 }}"
        )
    };
    assert!(driven(&text("0.2")).summary.travelled_m < 1e-6);
    assert!(driven(&text("0.02")).summary.travelled_m > 0.1);
}

/// How far a robot goes on after a time in seconds, in metres.
fn goes_on_m(text: &str, from_s: f64) -> f64 {
    let found = driven(text);
    let rows = found.trace.records();
    let then = rows.iter().find(|row| row.t_s > from_s).expect("rows");
    rows.last().expect("rows").truth.pose.x_m - then.truth.pose.x_m
}

/// A sampled PI on a motor that cannot reach its target winds up for 1.5 s, and overruns by its
/// integral unless that is limited.
#[test]
fn an_integral_that_winds_up_overruns_unless_it_is_held() {
    let overrun = |keys: &str| {
        let text = format!(
            "motors.dc = {{ stall_torque_n_m = 1.0, no_load_rate_rad_s = 10.0 }}\nguidance.saturation = \"none\"\nwheel_loop = {{ {keys} }}\n\
             twist = {{ vx_m_s = 1.0, rest_s = 0.0, ramp_s = 0.1, schedule = [{{ from_s = 1.5 }}] }}"
        );
        goes_on_m(&text, 1.65)
    };
    let held = overrun("");
    let limited = overrun("anti_windup = \"none\", integral_limit_n_m = 0.05");
    let wound = overrun("anti_windup = \"none\"");
    assert!(wound > 0.1 && held.abs() < 0.05, "{wound} {held}");
    assert!(limited < 0.5 * wound, "{limited} {wound}");
}

/// A motor at its rate limit of w = 30 rad/s, of which 60 are asked for from 0.1 to 1.5 s: without
/// anti-windup the integral counts 30 rad/s for 1.4 s, 42 rad, and the robot goes on at full speed
/// until its wheels have turned that much after the stop, over 42 rad x 50 mm = 2.1 m. The
/// proportional part ends that a little earlier: 11 N m of 210 N m. A robot that brakes from 1.5 m/s
/// by a grip of 0.8 stops within 0.14 m.
#[test]
fn an_integral_without_anti_windup_counts_what_is_beyond_the_rate_limit() {
    let after_stop_m = |keys: &str| {
        let text = format!(
            "guidance.saturation = \"none\"\nwheel_loop = {{ integral_n_m = 5.0, {keys} }}\n\
             twist = {{ vx_m_s = 3.0, rest_s = 0.0, ramp_s = 0.1, schedule = [{{ from_s = 1.5 }}] }}"
        );
        goes_on_m(&text, 1.5)
    };
    let wound_m = after_stop_m("anti_windup = \"none\"");
    let held_m = after_stop_m("anti_windup = \"conditional\"");
    assert!(held_m < 0.4, "{held_m}");
    assert!(
        wound_m > 3.0 * held_m && wound_m > 1.5,
        "{wound_m} {held_m}"
    );
}

/// A PI of 0.05 N m s/rad and at most 0.15 N m on a target of 4 rad/s, against gears of 0.3 N m and
/// bearings of 1e-3 N m s/rad: 0.05 (4 - w) + 0.15 = 0.3 + 0.001 w, so w = 0.05 / 0.051 = 0.9804
/// rad/s, and all torques end at 0.3 N m. Nine rollers at 45 degrees let rates ripple by 1e-4.
#[test_case("continuous")]
#[test_case("sampled")]
fn an_integral_at_its_limit_gives_no_more_than_that(timing: &str) {
    let found = driven(&format!(
        "motors.gear_friction_n_m = 0.3\ntwist = {{ vx_m_s = 0.2, rest_s = 0.0, ramp_s = 0.2, settle_s = 2.0 }}\n\
         wheel_loop = {{ proportional_n_m_s = 0.05, integral_n_m = 1.0, integral_limit_n_m = 0.15, timing = \"{timing}\" }}"
    ));
    let speed_m_s = found.summary.twist_mean.expect("means").vx_m_s;
    let expected_m_s = 0.05 * 0.05 / 0.051;
    assert!((speed_m_s / expected_m_s - 1.0).abs() < 1e-3, "{speed_m_s}");
}

/// A loop whose torques come d late is critically damped at k d / J = 1 / e, J the inertia of the
/// lightest direction of motion, and swings from pi / 2 on (an integrator with a delay). A latency
/// for which the chosen gain is lowered, to half of what a wheel in the air bears, is remarked with
/// both gains and the gain that drives: a robot with that gain is faster. A robot that follows within
/// 0.1 s needs no remark.
#[test]
fn a_latency_that_lowers_the_gain_is_remarked_with_one_that_drives() {
    let of = |latency_s: f64| {
        let scenario = scenario(&format!(
            "twist.vx_m_s = 0.3\nwheel_loop.latency_s = {latency_s}"
        ));
        let robot = ilon_sim::load_robot(&scenario).expect("a robot");
        let resolved = ilon_sim::resolve(&scenario, &robot).expect("it drives");
        let mut warnings = resolved.warnings().iter();
        let said = warnings
            .find(|said| said.contains("lowers the chosen gain"))
            .cloned();
        (
            said,
            resolved
                .scenario()
                .wheel_loop
                .proportional_n_m_s
                .expect("a gain"),
        )
    };
    assert_eq!([0.0, 0.001].map(|latency_s| of(latency_s).0), [None, None]);
    let plant = Plant::of_scenario(&scenario("twist = {}")).expect("it stands");
    let model = ilon_control::DynamicModel::new(plant.robot()).expect("it drives");
    let r = model.kinematics().rate_matrix();
    let felt = |axis: usize| {
        let rates = r * nalgebra::Vector3::ith(axis, 1.0);
        rates.dot(&(model.inertia() * &rates)) / rates.norm_squared()
    };
    let least_kg_m2 = (0..3).map(felt).fold(f64::INFINITY, f64::min);
    for latency_s in [0.01, 0.05, 0.1, 0.2] {
        let (said, chosen_n_m_s) = of(latency_s);
        let said = said.expect("a remark");
        // Half of pi / 2 for a wheel in the air; a tenth of the latency is the loop's period.
        let air = chosen_n_m_s * latency_s / model.air_inertia_kg_m2();
        assert!(
            (air / std::f64::consts::FRAC_PI_4 - 1.0).abs() < 0.06,
            "{air}"
        );
        let (_, named) = said.split_once("proportional_n_m_s` = ").expect("a gain");
        let gain_n_m_s: f64 = named
            .split(' ')
            .next()
            .expect("one")
            .parse()
            .expect("a number");
        // Rounded down to two digits or more.
        let share = gain_n_m_s * latency_s / least_kg_m2 * std::f64::consts::E;
        assert!(
            (0.9..=1.001).contains(&share),
            "{latency_s}: {share} {said}"
        );
        let speed_m_s = |gain: &str| {
            let found = driven(&format!(
                "twist.vx_m_s = 0.3\nwheel_loop = {{ latency_s = {latency_s}{gain} }}"
            ));
            let rows = found.trace.records();
            let [before, last] = [rows[rows.len() - 20], rows[rows.len() - 1]];
            (last.truth.pose.x_m - before.truth.pose.x_m) / (last.t_s - before.t_s)
        };
        let named_m_s = speed_m_s(&format!(", proportional_n_m_s = {gain_n_m_s}"));
        let off = |speed_m_s: f64| (speed_m_s / 0.3 - 1.0).abs();
        assert!(
            off(named_m_s) < off(speed_m_s("")),
            "{latency_s}: {named_m_s}"
        );
        // At 0.05 s six of its time constants pass, and the bearings, 1e-3 beside 0.0137 N m s/rad,
        // take 7 %.
        assert!(
            latency_s > 0.05 || off(named_m_s) < 0.1,
            "{latency_s}: {named_m_s}"
        );
    }
}

/// P loops on all wheels of a robot without sliding are one integrator in each direction of motion,
/// k / J with J the inertia at a wheel there. Torques that come late by d make them unstable from k
/// d / J = pi / 2 on, whatever the step; if they are held for a period T, from k / J (d + T / 2) =
/// pi / 2 on. The direction with the smallest
/// J is the first, so the robot moves in that. The bearings' damping is negligible: 1e-3 beside
/// 0.25 N m s/rad. A tenth off the margin the oscillation changes as exp(+-0.045 k t / J), some
/// hundred times in 4 s.
#[test]
fn torques_that_come_late_let_the_loop_swing_from_its_phase_margin_on() {
    let gain_n_m_s = 0.25;
    let plant = Plant::of_scenario(&scenario("twist = {}")).expect("it stands");
    let model = ilon_control::DynamicModel::new(plant.robot()).expect("it drives");
    let r = model.kinematics().rate_matrix();
    let felt = |axis: usize| {
        let rates = r * nalgebra::Vector3::ith(axis, 1.0);
        rates.dot(&(model.inertia() * &rates)) / rates.norm_squared()
    };
    let motions = ["vx_m_s = 0.1", "vy_m_s = 0.1", "omega_rad_s = 0.3"];
    let directions = motions
        .into_iter()
        .enumerate()
        .map(|(axis, motion)| (felt(axis), motion));
    let least = directions.min_by(|a, b| a.0.total_cmp(&b.0));
    let (inertia_kg_m2, motion) = least.expect("three");
    let least_s = std::f64::consts::FRAC_PI_2 * inertia_kg_m2 / gain_n_m_s;
    for (dt_s, held_s) in [(1e-3, 0.0), (2.5e-3, 0.0), (1e-3, 0.005)] {
        let period = match held_s > 0.0 {
            true => format!(", period_s = {held_s}"),
            false => String::new(),
        };
        let of = |share: f64| {
            let done = driven(&format!(
                "wheel_loop = {{ proportional_n_m_s = {gain_n_m_s}, integral_n_m = 0, latency_s = {}{period} }}\nrun.physics_dt_s = {dt_s}\n\
                 twist = {{ {motion}, rest_s = 0.0, ramp_s = 0.5, settle_s = 1.0 }}",
                share * (least_s - 0.5 * held_s)
            ));
            let rows = done.trace.steps().filter(|(record, _)| record.t_s > 3.0);
            let off = rows.map(|(_, wheels)| (wheels[0].rate_rad_s - wheels[0].target_rad_s).abs());
            off.fold(0.0, f64::max)
        };
        let (small, large) = (of(0.9), of(1.1));
        assert!(
            large > 20.0 * small,
            "{motion}, steps of {dt_s} s, held for {held_s} s: {small} {large}, {least_s} s"
        );
    }
}

/// What a latency does is the same in steps of 2.5 and of 0.25 ms, although the torques of a step
/// are decided once: held for it they came half a step later.
#[test]
fn torques_are_as_late_as_said_in_long_steps_and_in_short_ones() {
    let end_m = |dt_s: f64| {
        let done = driven(&format!(
            "wheel_loop = {{ latency_s = 0.01, bandwidth_rad_s = 5 }}\nrun.physics_dt_s = {dt_s}\n\
             twist = {{ vx_m_s = 0.2, vy_m_s = -0.1, omega_rad_s = 0.5, rest_s = 0.0, ramp_s = 0.0 }}"
        ));
        [done.summary.end_x_m, done.summary.end_y_m].map(|end_m| end_m.expect("an end"))
    };
    let [long, short] = [2.5e-3, 2.5e-4].map(end_m);
    let off_m = (long[0] - short[0]).hypot(long[1] - short[1]);
    // A tenth of what half a step of 2.5 ms takes of 0.22 m/s: 0.28 mm.
    assert!(off_m < 1e-4, "{off_m} m");
}

/// Default gains allow for the latency: no warning, and 0.1 m/s as commanded. A gain too high for
/// it is reported with a suitable one, and the effect of the latency has its own cause.
#[test]
fn gains_that_are_left_out_bear_the_latency_and_others_are_remarked() {
    let of = |keys: &str| {
        driven(&format!(
            "wheel_loop = {{ latency_s = 0.005{keys} }}\ntwist = {{ vx_m_s = 0.1, rest_s = 0.0, ramp_s = 0.5, settle_s = 3.0 }}"
        ))
    };
    let unstable = |run: &Run| {
        let mut found = run
            .warnings
            .iter()
            .filter(|text| text.contains("loops are unstable"));
        found.next().cloned()
    };
    let chosen = of("");
    assert_eq!(unstable(&chosen), None, "{:?}", chosen.warnings);
    let mean = chosen.summary.twist_mean.expect("means");
    assert!((mean.vx_m_s - 0.1).abs() < 1e-3, "{mean:?}");
    let said = unstable(&of(", proportional_n_m_s = 2")).expect("a note");
    assert!(
        said.contains("0.005 s late") && said.contains("`wheel_loop.latency_s`"),
        "{said}"
    );
    for law in ["computed_torque", "prioritised_torque"] {
        let said = unstable(&of(&format!(", law = \"{law}\", bandwidth_rad_s = 100")));
        assert!(
            said.is_some_and(|said| said.contains("bandwidth_rad_s` to")),
            "{law}"
        );
    }
    let text = "robot.file = \"mecanum4.urdf\"\nrun.duration_s = 1\ntwist = {}\nwheel_loop = { latency_s = 0.02, law = \"passive\" }";
    let refused = Scenario::from_toml(text, "passive", ".");
    assert!(refused.is_err_and(|error| error.to_string().contains("latency_s")));
}

/// (1, 0.8) m/s and 2 rad/s take 48.4 rad/s of a wheel: (1 + 0.8) / 0.05 for the translation and
/// 0.31 x 2 / 0.05 = 12.4 for the rotation, with a limit of 30. Scaled together they keep 30 /
/// 48.4; with the heading first the rotation is kept, and the translation keeps (30 - 12.4) / 36;
/// with the position first the translation keeps 30 / 36 and nothing is left for the rotation. The
/// command is exact except for sums of numbers of about 50.
#[test]
fn a_twist_gives_way_by_its_priority() {
    for (keys, way, turn) in [
        ("", 30.0 / 48.4, 30.0 / 48.4),
        ("guidance.priority = \"heading\"", 17.6 / 36.0, 1.0),
        ("guidance.priority = \"position\"", 30.0 / 36.0, 0.0),
    ] {
        let found = driven(&format!(
            "guidance.wheel_rate_limit_rad_s = 30\n{keys}\ntwist = {{ vx_m_s = 1.0, vy_m_s = 0.8, omega_rad_s = 2.0 }}"
        ));
        let last = found
            .trace
            .records()
            .last()
            .expect("rows")
            .twist_target_ideal;
        let off = [
            last.vx_m_s - way,
            last.vy_m_s - 0.8 * way,
            last.omega_rad_s - 2.0 * turn,
        ];
        assert!(off.iter().all(|off| off.abs() < 1e-12), "{keys}: {last:?}");
    }
}

/// Torques that were on the way, or held, before the wheels were commanded by torques do not arrive
/// after it: until the loops decide, and that arrives, rates that are commanded again do what no
/// torque does.
#[test]
fn no_torque_outlives_a_pause_of_the_wheel_loops() {
    // The loop of the second decides at 0.18 and 0.19 s.
    for (keys, for_s) in [
        ("wheel_loop.latency_s = 0.0205", 0.02),
        (
            "wheel_loop = { timing = \"sampled\", period_s = 0.01 }",
            0.002,
        ),
    ] {
        let text = format!("twist = {{}}\nrun.physics_dt_s = 1e-3\n{keys}");
        let after = |resumes: bool| {
            let mut plant = Plant::of_scenario(&scenario(&text)).expect("it stands");
            for (command, time_s) in [
                (WheelCommand::Rates(&[6.0; 4]), 0.055),
                (WheelCommand::Torques(&[0.0; 4]), 0.133),
            ] {
                plant.advance(command, time_s).expect("it goes");
            }
            let command = match resumes {
                true => WheelCommand::Rates(&[9.0; 4]),
                false => WheelCommand::Torques(&[0.0; 4]),
            };
            plant.advance(command, for_s).expect("it goes");
            plant.world().robot().wheel_rates_rad_s().to_vec()
        };
        assert_eq!(after(true), after(false), "{keys}");
    }
}

/// 20 counts a turn, read every 10 ms: one count is 31.4 rad/s, many times the wheels' 7 to 10
/// rad/s. A loop that acts on a count for a whole control period by the gain of a wheel in the air
/// takes that count back once; one that acted on it at every instant swung between the motors'
/// limits, and lost 89 J to sliding of 142 J. On (0.3, 0.2) m/s the robot gets as far as with exact
/// encoders but for the geometry of its rollers (2 %) and a count of each wheel: 2 pi / 20 x 0.05
/// m = 16 mm.
#[test]
fn loops_on_coarse_encoders_decide_when_these_are_read() {
    let of = |encoders: &str| {
        driven(&format!(
            "twist = {{ vx_m_s = 0.3, vy_m_s = 0.2, rest_s = 0.5, ramp_s = 0.5 }}\n{encoders}"
        ))
    };
    let exact = of("");
    for (encoders, most_slip_j) in [
        ("sensors.encoders.counts_per_turn = 20", 1.5),
        (
            "sensors.encoders = { counts_per_turn = 20, rate_filter_s = 0.02 }",
            0.01,
        ),
        ("sensors.encoders.counts_per_turn = 400", 0.01),
    ] {
        let counted = of(encoders);
        let slip_j = counted.summary.energy.slip_j.expect("it is known");
        assert!(slip_j < most_slip_j, "{encoders}: {slip_j}");
        let [x_m, y_m] = [0, 1].map(|axis| {
            let end = |run: &Run| [run.summary.end_x_m, run.summary.end_y_m][axis].expect("an end");
            end(&counted) - end(&exact)
        });
        assert!(x_m.hypot(y_m) < 0.03, "{encoders}: {x_m} {y_m}");
        let unstable = |text: &String| text.contains("loops are unstable");
        assert!(
            !counted.warnings.iter().any(unstable),
            "{:?}",
            counted.warnings
        );
    }
}

/// Gains that are left out bear the wait for counts too: a loop of 1 ms acts on rates that are up
/// to 10 ms old. With the gains of a loop that reads new ones wheels in the air swing.
#[test]
fn gains_of_fast_loops_bear_the_wait_for_counts() {
    let found = driven(
        "twist = { vx_m_s = 0.3, rest_s = 0.2, ramp_s = 0.5, settle_s = 2.0 }\nrun.physics_dt_s = 1e-3\nwheel_loop.period_s = 1e-3\nsensors.encoders.counts_per_turn = 4000",
    );
    let unstable = |text: &String| text.contains("loops are unstable");
    assert!(!found.warnings.iter().any(unstable), "{:?}", found.warnings);
    // Wheels that swing reach the motors' 1.8 N m. The start takes 11.36 kg x 0.6 m/s^2 x 0.05 m /
    // 4 = 0.085 N m of each, and an overshoot of a critically damped loop a seventh more.
    let most_n_m = found.summary.wheel_torque_max_n_m.expect("torques");
    assert!(most_n_m < 0.2, "{most_n_m}");
}

/// J_air / (J_ground T) bounds the bandwidth of torques held over T = 2 ms, in both kinds of laws.
/// A bandwidth beyond it is reported with what it acts as, and that one, to its three digits, is
/// not; a default is no question.
#[test_case("pid"; "one a wheel")]
#[test_case("computed_torque"; "one for all")]
fn a_bandwidth_that_cannot_act_is_remarked_with_what_it_acts_as(law: &str) {
    let of = |bandwidth: &str| {
        let text = format!(
            "run = {{ physics_dt_s = 0.002, duration_s = 0.1 }}\ntwist = {{}}\nwheel_loop = {{ law = \"{law}\", timing = \"sampled\"{bandwidth} }}"
        );
        let text = format!("robot.file = \"mecanum4.urdf\"\n{text}");
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
        let scenario = Scenario::from_toml(&text, "bandwidth", folder).expect("a scenario");
        let warnings = run(&scenario).expect("it runs").warnings;
        let mut acts = warnings.into_iter().filter_map(|text| {
            let after = text.strip_prefix("`wheel_loop.bandwidth_rad_s` = 150 acts as ")?;
            after.split(':').next()?.parse::<f64>().ok()
        });
        acts.next()
    };
    let most_rad_s = of(", bandwidth_rad_s = 150").expect("a note");
    assert!((10.0..30.0).contains(&most_rad_s), "{most_rad_s}");
    assert_eq!(of(&format!(", bandwidth_rad_s = {most_rad_s}")), None);
    assert_eq!(of(""), None);
}

/// A gain too high for rates that are a period old is reported, with the filter if there is one.
#[test]
fn a_gain_too_high_for_counted_rates_is_remarked() {
    for (filter, said) in [
        ("", "shorten `run.control_dt_s`"),
        (
            "rate_filter_s = 0.05, ",
            "shorten `sensors.encoders.rate_filter_s`",
        ),
    ] {
        let text = format!(
            "twist = {{}}\nwheel_loop.proportional_n_m_s = 2\nsensors.encoders = {{ {filter}counts_per_turn = 4000 }}\nrun.duration_s = 0.5"
        );
        let text = format!("robot.file = \"mecanum4.urdf\"\n{text}");
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
        let scenario = Scenario::from_toml(&text, "counted", folder).expect("a scenario");
        let warnings = run(&scenario).expect("it runs").warnings;
        let found = warnings
            .iter()
            .find(|text| text.contains("loops are unstable"));
        let found = found.expect("a note");
        assert!(
            found.contains(said) && found.contains("once a control period"),
            "{found}"
        );
    }
}
