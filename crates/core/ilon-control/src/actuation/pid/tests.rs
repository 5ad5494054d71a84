use super::*;
const LIMIT: TorqueRange = TorqueRange {
    min_n_m: -1.0,
    max_n_m: 1.0,
};

/// Simulates a wheel of inertia `j` under its loop, with the torque held over each step; returns
/// the rate after each step.
fn run(gains: WheelGains, j: f64, damping: f64, dt_s: f64, steps: usize) -> Vec<f64> {
    let mut wheel_loop = WheelLoop::new(1, WheelLoopSettings::new(gains)).unwrap();
    let mut rate = 0.0;
    (0..steps)
        .map(|_| {
            let torque = wheel_loop.update(&Demand::new(
                &[5.0],
                &[rate],
                &[TorqueRange::UNLIMITED],
                dt_s,
            ))[0];
            rate += dt_s / j * (torque - damping * rate);
            rate
        })
        .collect()
}

/// The loop bandwidth that gains give a wheel of this inertia, in rad/s: k_p / J.
fn bandwidth_rad_s(gains: &WheelGains, inertia_kg_m2: f64) -> f64 {
    gains.proportional_n_m_s / inertia_kg_m2
}

/// Whether a wheel of this inertia under these gains (without derivative) and this period is
/// stable: a > 0, b >= 0 and 2 a + b < 4 of the module's derivation.
fn is_stable(gains: &WheelGains, inertia_kg_m2: f64, dt_s: f64) -> bool {
    let a = gains.proportional_n_m_s * dt_s / inertia_kg_m2;
    let b = gains.integral_n_m * dt_s * dt_s / inertia_kg_m2;
    a > 0.0 && b >= 0.0 && 2.0 * a + b < 4.0
}

#[test]
fn proposed_gains_reach_the_target_in_about_one_over_the_bandwidth() {
    let gains = WheelGains::propose(7e-3, 2.4e-4, (1e-3, 0.0), 30.0).unwrap();
    assert!((bandwidth_rad_s(&gains, 7e-3) - 30.0).abs() < 1e-12);
    let rates = run(gains, 7e-3, 1e-3, 1e-3, 1000);
    // Critically damped with both poles at 15 rad/s and a zero at 7.5: e(t) = (1 - 15 t) exp(-15 t)
    // plus the response of the zero; within 15 % after 4/15 s, within 0.1 % after 1 s, damping
    // included.
    assert!((rates[266] / 5.0 - 1.0).abs() < 0.15, "{}", rates[266]);
    assert!((rates[999] / 5.0 - 1.0).abs() < 1e-3, "{}", rates[999]);
}

#[test]
fn proposed_gains_hold_a_wheel_in_the_air_without_swinging() {
    for dt_s in [1.0 / 1000.0, 1.0 / 240.0, 1.0 / 60.0] {
        let gains = WheelGains::propose(7e-3, 2.4e-4, (dt_s, 0.0), 50.0).unwrap();
        assert!(is_stable(&gains, 2.4e-4, dt_s) && is_stable(&gains, 7e-3, dt_s));
        let rates = run(gains, 2.4e-4, 0.0, dt_s, 2000);
        // The integral overshoots by a few percent; an oscillation from step to step would exceed
        // that.
        assert!(rates.iter().all(|r| *r > 0.0 && *r < 5.0 * 1.2));
        assert!((rates[1999] / 5.0 - 1.0).abs() < 0.02);
    }
}

#[test]
fn the_stability_limit_is_where_the_simulated_loop_starts_to_grow() {
    let (j, dt_s) = (2e-4, 1e-3);
    for (integral, share) in [(0.0, 0.99), (0.0, 1.01), (20.0, 0.99), (20.0, 1.01)] {
        // 2 a + b = 4 share.
        let b = integral * dt_s * dt_s / j;
        let a = (4.0 * share - b) / 2.0;
        let gains = WheelGains {
            proportional_n_m_s: a * j / dt_s,
            integral_n_m: integral,
            derivative_n_m_s2: 0.0,
        };
        let rates = run(gains, j, 0.0, dt_s, 4000);
        let off = (rates[3999] - 5.0).abs();
        assert_eq!(is_stable(&gains, j, dt_s), share < 1.0);
        assert_eq!(off < 5.0, share < 1.0, "{integral} {share}: {off}");
    }
}

/// The same wheel under a continuous loop: J x = dt (tau - theta D x) for the rate x gained.
fn run_continuous(settings: WheelLoopSettings, j: f64, dt_s: f64, steps: usize) -> Vec<f64> {
    let mut wheel_loop = WheelLoop::new(1, settings).unwrap();
    let theta = mean_of_gain(settings.gains.proportional_n_m_s * dt_s / settings.inertia_kg_m2);
    let mut rate = 0.0;
    (0..steps)
        .map(|_| {
            wheel_loop.update(&Demand::new(
                &[5.0],
                &[rate],
                &[TorqueRange::UNLIMITED],
                dt_s,
            ));
            let falling = wheel_loop.falling()[0];
            rate += dt_s * falling.torque_n_m / (j + dt_s * theta * falling.droop_n_m_s);
            rate
        })
        .collect()
}

#[test]
fn a_continuous_loop_is_stable_at_any_step_and_ends_where_a_finely_sampled_one_does() {
    let (j_ground, j_air) = (7e-3, 2.4e-4);
    let gains = WheelGains::propose_continuous(j_ground, 60.0).unwrap();
    for derivative in [0.0, 1e-3] {
        let settings = WheelLoopSettings {
            gains: WheelGains {
                derivative_n_m_s2: derivative,
                ..gains
            },
            timing: LoopTiming::Continuous,
            inertia_kg_m2: j_ground,
            derivative_filter_s: 0.01,
            ..WheelLoopSettings::new(gains)
        };
        for dt_s in [1e-3, 1e-2, 0.1] {
            // A sampled loop with these gains is already unstable at 1 ms: 60 J_ground / J_air
            // dt > 1.
            let rates = run_continuous(settings, j_air, dt_s, 2000);
            // Approach to the target of 5 rad/s. A wheel in the air, for which theta is too small,
            // overshoots by at most (1 - theta) / theta of the remaining error, plus the integral's
            // overshoot.
            let theta = mean_of_gain(60.0 * dt_s);
            let over = 1.2 + (1.0 - theta) / theta;
            let lies_within = |r: &f64| *r > 5.0 * (2.0 - over) && *r < 5.0 * over;
            assert!(rates[1..].iter().all(lies_within), "{dt_s}");
            assert!((rates[1999] / 5.0 - 1.0).abs() < 1e-6, "{dt_s}");
        }
    }
    // On the ground, 0.05 s after the start, against the exact answer of J e'' + k_p e' + k_i e = 0
    // with e(0) = 5 and e'(0) = -60 e(0), both poles on 30 rad/s: e(t) = 5 (1 - 30 t) exp(-30 t).
    // Of second order: a quarter as much for half the step.
    let settings = WheelLoopSettings {
        timing: LoopTiming::Continuous,
        inertia_kg_m2: j_ground,
        ..WheelLoopSettings::new(gains)
    };
    let exact = 5.0 - 5.0 * (1.0 - 30.0 * 0.05) * (-30.0f64 * 0.05).exp();
    let off = |dt_s: f64| {
        let steps = (0.05 / dt_s).round() as usize;
        run_continuous(settings, j_ground, dt_s, steps)[steps - 1] - exact
    };
    let (coarse, fine) = (off(1e-3), off(5e-4));
    assert!(coarse.abs() < 1e-3, "{coarse}");
    assert!((coarse / fine - 4.0).abs() < 0.2, "{coarse} {fine}");
}

/// A wheel that jumps by 1 rad/s at the beginning of a step turns with its new rate throughout: the
/// integral of its error is k_i dt (5 - 1), and not with half of the gain, k_i dt (5 - 1/2). In the
/// next step the mean of the error's integral is k_i dt (5 - 1) / 2 more. Without k_p theta is 1/2.
#[test]
fn the_integral_counts_the_angle_by_which_a_wheel_turned() {
    let gains = WheelGains {
        proportional_n_m_s: 0.0,
        integral_n_m: 20.0,
        derivative_n_m_s2: 0.0,
    };
    let settings = WheelLoopSettings {
        timing: LoopTiming::Continuous,
        inertia_kg_m2: 7e-3,
        ..WheelLoopSettings::new(gains)
    };
    let dt_s = 0.01;
    let second_n_m = |angles: [&[f64]; 2]| {
        let mut wheel_loop = WheelLoop::new(1, settings).unwrap();
        let mut update = |angles_rad, rate| {
            wheel_loop.sense(&BodySense {
                angles_rad,
                gravity_in_body_m_s2: None,
            });
            let limits = [TorqueRange::UNLIMITED];
            wheel_loop.update(&Demand::new(&[5.0], &[rate], &limits, dt_s))[0]
        };
        update(angles[0], 0.0);
        update(angles[1], 1.0)
    };
    let of_error = 20.0 * dt_s;
    for (turned_rad, mean_rad_s) in [(dt_s, 1.0), (0.5 * dt_s, 0.5)] {
        let expected_n_m = of_error * (5.0 - mean_rad_s) + of_error * 4.0 / 2.0;
        let given_n_m = second_n_m([&[3.0], &[3.0 + turned_rad]]);
        assert!((given_n_m - expected_n_m).abs() < 1e-12, "{given_n_m}");
    }
    // Without angles the rate counts as one that changed steadily.
    let steadily_n_m = second_n_m([&[], &[]]);
    assert!((steadily_n_m - of_error * (4.5 + 2.0)).abs() < 1e-12);
}

/// The motor of 1 N m cannot follow a jump of the target, and the integral stands until the torque
/// leaves the limit, somewhere within a step. So the rate 0.2 s after the jump is of second order
/// in the step, whatever the target: on average a quarter as far from the limit of short steps for
/// half the step. (An integral that stands for whole steps is of first order: a half.)
#[test]
fn a_continuous_loops_integral_stands_just_while_the_motor_is_at_its_limit() {
    let j = 7e-3;
    let gains = WheelGains::propose_continuous(j, 60.0).unwrap();
    let settings = WheelLoopSettings {
        timing: LoopTiming::Continuous,
        inertia_kg_m2: j,
        ..WheelLoopSettings::new(gains)
    };
    let rate_after = |target: f64, dt_s: f64| {
        let mut wheel_loop = WheelLoop::new(1, settings).unwrap();
        let theta = mean_of_gain(gains.proportional_n_m_s * dt_s / j);
        let mut rate = 0.0;
        for _ in 0..(0.2 / dt_s).round() as usize {
            wheel_loop.update(&Demand::new(&[target], &[rate], &[LIMIT], dt_s));
            let falling = wheel_loop.falling()[0];
            // The mean torque over the step stays within the limit.
            let free = falling.torque_n_m / (j + dt_s * theta * falling.droop_n_m_s);
            rate += dt_s * free.clamp(-1.0 / j, 1.0 / j);
        }
        rate
    };
    let targets = (0..40).map(|k| 10.0 + 0.25 * f64::from(k));
    let off = |dt_s: f64| -> f64 {
        let off = |target| (rate_after(target, dt_s) - rate_after(target, 2e-5)).abs();
        targets.clone().map(off).sum()
    };
    let (coarse, fine) = (off(8e-3), off(4e-3));
    assert!(coarse / fine > 3.0, "{coarse} {fine}");
}

#[test]
fn what_a_continuous_loop_asks_for_at_the_motors_limit_falls_as_it_does_within() {
    let gains = WheelGains::propose_continuous(7e-3, 60.0).unwrap();
    let settings = WheelLoopSettings {
        timing: LoopTiming::Continuous,
        ..WheelLoopSettings::new(gains)
    };
    let asked = |limit: TorqueRange| {
        let mut wheel_loop = WheelLoop::new(1, settings).unwrap();
        let torque_n_m = wheel_loop.update(&Demand::new(&[5.0], &[0.0], &[limit], 0.01))[0];
        (torque_n_m, wheel_loop.falling()[0])
    };
    let (limited_n_m, limited) = asked(LIMIT);
    let (free_n_m, free) = asked(TorqueRange::UNLIMITED);
    assert_eq!((limited_n_m, limited), (1.0, free));
    assert_eq!(free_n_m, free.torque_n_m);
    assert!(free_n_m > 2.0 && free.droop_n_m_s > 0.4, "{free:?}");
}

#[test]
fn the_integral_does_not_wind_up_while_the_motor_is_at_its_limit() {
    let gains = WheelGains {
        proportional_n_m_s: 0.1,
        integral_n_m: 1.0,
        derivative_n_m_s2: 0.0,
    };
    let mut wheel_loop = WheelLoop::new(1, WheelLoopSettings::new(gains)).unwrap();
    // Stalled for 100 s at an error of 50 rad/s: without the limit the integral would hold 5000 N
    // m.
    for _ in 0..10_000 {
        let torque = wheel_loop.update(&Demand::new(&[50.0], &[0.0], &[LIMIT], 0.01))[0];
        assert_eq!(torque, 1.0);
    }
    // Released and slightly beyond the target: the torque leaves the limit at once.
    let torque = wheel_loop.update(&Demand::new(&[50.0], &[50.1], &[LIMIT], 0.01))[0];
    assert!(torque < 1.0, "{torque}");
}

#[test]
fn the_derivative_acts_on_the_rate_and_is_filtered() {
    let gains = WheelGains {
        proportional_n_m_s: 0.0,
        integral_n_m: 0.0,
        derivative_n_m_s2: 0.5,
    };
    let mut settings = WheelLoopSettings::new(gains);
    settings.derivative_filter_s = 0.03;
    let mut wheel_loop = WheelLoop::new(1, settings).unwrap();
    let open = [TorqueRange::UNLIMITED];
    assert_eq!(
        wheel_loop.update(&Demand::new(&[0.0], &[0.0], &open, 0.01))[0],
        0.0
    );
    // A step of the target alone gives no torque.
    assert_eq!(
        wheel_loop.update(&Demand::new(&[9.0], &[0.0], &open, 0.01))[0],
        0.0
    );
    // The rate rises by 10 rad/s^2: a quarter of it passes the filter in the first step, dt / (T +
    // dt).
    let first = wheel_loop.update(&Demand::new(&[9.0], &[0.1], &open, 0.01))[0];
    assert!((first + 0.5 * 10.0 * 0.25).abs() < 1e-12, "{first}");
}

#[test]
fn feedforward_makes_up_for_damping_and_dry_friction() {
    let gains = WheelGains {
        proportional_n_m_s: 0.0,
        integral_n_m: 0.0,
        derivative_n_m_s2: 0.0,
    };
    let settings = WheelLoopSettings {
        feedforward_damping_n_m_s: 0.02,
        feedforward_friction_n_m: 0.3,
        ..WheelLoopSettings::new(gains)
    };
    let mut wheel_loop = WheelLoop::new(3, settings).unwrap();
    let torques = wheel_loop.update(&Demand::new(
        &[5.0, -5.0, 0.0],
        &[0.0; 3],
        &[LIMIT; 3],
        0.01,
    ));
    for (torque, expected) in torques.iter().zip([0.4, -0.4, 0.0]) {
        assert!((torque - expected).abs() < 1e-15);
    }
}

#[test]
fn settings_that_are_negative_or_not_numbers_are_refused() {
    let mut settings =
        WheelLoopSettings::new(WheelGains::propose(1e-2, 1e-3, (1e-3, 0.0), 10.0).unwrap());
    settings.derivative_filter_s = -1.0;
    assert_eq!(
        WheelLoop::new(3, settings).unwrap_err().to_string(),
        "the derivative filter's time constant in s is -1; it must be finite and not below zero"
    );
    assert!(WheelGains::propose(1e-2, 1e-3, (f64::NAN, 0.0), 10.0).is_err());
}

/// With a filtered derivative the loop is J x' = k_p e + k_i integral(e) - k_d a, T a' = x' - a.
/// The step converges to that as it gets shorter: the difference from a Runge-Kutta solution at
/// least halves with the step.
#[test]
fn a_continuous_loop_with_a_derivative_comes_to_the_equation_it_stands_for() {
    let (j, filter_s, k_d) = (7e-3, 0.01, 3e-3);
    let gains = WheelGains {
        derivative_n_m_s2: k_d,
        ..WheelGains::propose_continuous(j, 60.0).unwrap()
    };
    let settings = WheelLoopSettings {
        timing: LoopTiming::Continuous,
        inertia_kg_m2: j,
        derivative_filter_s: filter_s,
        ..WheelLoopSettings::new(gains)
    };
    // Rate, integral of the error, filtered acceleration.
    let change = |[x, sum, a]: [f64; 3]| {
        let e = 5.0 - x;
        let rate = (gains.proportional_n_m_s * e + gains.integral_n_m * sum - k_d * a) / j;
        [rate, e, (rate - a) / filter_s]
    };
    let add = |state: [f64; 3], by: [f64; 3], h: f64| [0, 1, 2].map(|i| state[i] + h * by[i]);
    let mut state = [0.0; 3];
    for _ in 0..5000 {
        let h = 1e-5;
        let k_1 = change(state);
        let k_2 = change(add(state, k_1, 0.5 * h));
        let k_3 = change(add(state, k_2, 0.5 * h));
        let k_4 = change(add(state, k_3, h));
        let mean = [0, 1, 2].map(|i| (k_1[i] + 2.0 * (k_2[i] + k_3[i]) + k_4[i]) / 6.0);
        state = add(state, mean, h);
    }
    let off = |dt_s: f64| {
        let steps = (0.05 / dt_s).round() as usize;
        run_continuous(settings, j, dt_s, steps)[steps - 1] - state[0]
    };
    let (coarse, fine) = (off(2.5e-4), off(1.25e-4));
    assert!(coarse.abs() < 0.02, "{coarse}");
    assert!(coarse / fine > 1.8, "{coarse} {fine}");
}

/// An integral that crosses its limit of 1 N m in a step ends at it within that step: from -1, with
/// 50 N m/rad and an error of 5 rad/s over 0.02 s, it would be 4 N m and is 1, beside 0.1 x 5 N m.
#[test]
fn an_integral_reaches_its_limit_in_the_step_that_takes_it_there() {
    let gains = WheelGains {
        proportional_n_m_s: 0.1,
        integral_n_m: 50.0,
        derivative_n_m_s2: 0.0,
    };
    for timing in [LoopTiming::Sampled, LoopTiming::Continuous] {
        let mut wheel_loop = WheelLoop::new(
            1,
            WheelLoopSettings {
                timing,
                inertia_kg_m2: 1e3,
                integral_limit_n_m: 1.0,
                ..WheelLoopSettings::new(gains)
            },
        )
        .unwrap();
        let limits = [TorqueRange::UNLIMITED];
        let mut give = |target: f64| {
            wheel_loop.step(&Demand::new(&[target], &[0.0], &limits, 0.02));
            wheel_loop.torques_n_m()[0]
        };
        assert!((give(-5.0) + 1.5).abs() < 1e-12);
        assert!((give(5.0) - 1.5).abs() < 1e-12, "{timing:?}");
    }
}
