//! Losses are never negative, the unexplained energy is a share of the energy turned over, and
//! unstable loops are reported.

use std::path::Path;

use ilon_sim::trace::metrics::Energy;
use ilon_sim::{Error, Run, Scenario};

/// Mecanum4 on a diagonal, with further keys.
fn scenario_of(keys: &str) -> Scenario {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = format!(
        "robot.file = 'mecanum4.urdf'\ntwist = {{ vx_m_s = 0.2, vy_m_s = 0.2, rest_s = 0.2, ramp_s = 0.2, settle_s = 0.2 }}\n\
         run.duration_s = 1.5\n{keys}"
    );
    Scenario::from_toml(&text, "losses", folder).expect("a scenario")
}

fn run(keys: &str) -> Run {
    ilon_sim::run(&scenario_of(keys)).expect("it runs")
}

/// Every loss is positive, to a thousandth of the motors' positive work, and sliding took no more
/// energy than there was.
fn only_lost(name: &str, energy: &Energy) {
    let known = |joules: Option<f64>| joules.expect("it is counted");
    let drove_j = known(energy.motor_positive_j);
    let rounding_j = 1e-3 * drove_j;
    for lost_j in [
        energy.slip_j,
        energy.spin_up_j,
        energy.bearing_j,
        energy.impact_j,
    ] {
        assert!(known(lost_j) > -rounding_j, "{name}: {energy:?}");
    }
    let there_j = known(energy.motor_j) + known(energy.outside_j) - known(energy.stored_j);
    assert!(
        known(energy.slip_j) < there_j + rounding_j,
        "{name}: {energy:?}"
    );
    assert!(drove_j >= known(energy.motor_j), "{name}: {energy:?}");
}

/// Digital wheel loops that oscillate from step to step drive their wheels to and fro: the friction
/// of single steps then adds energy, their sum does not. Each is reported before the run, with a
/// gain under which there is no warning.
#[test]
fn loops_that_swing_lose_and_are_named_with_a_gain_that_does() {
    for (gains, swings) in [
        ("proportional_n_m_s = 5", true),
        ("proportional_n_m_s = 50", true),
        ("integral_n_m = 5000", true),
        ("derivative_n_m_s2 = 0.002", true),
        ("derivative_n_m_s2 = 0.1", true),
        ("derivative_n_m_s2 = 0.0", false),
    ] {
        let keys = format!("wheel_loop.timing = 'sampled'\nwheel_loop.{gains}");
        let done = run(&keys);
        only_lost(gains, &done.summary.energy);
        let share = done.summary.energy.unexplained_share.expect("it moved");
        assert!(share.abs() < 2e-3, "{gains}: {share}");
        let unstable = done
            .warnings
            .iter()
            .find(|text| text.contains("loops are unstable"));
        let swung = done
            .warnings
            .iter()
            .any(|text| text.contains("loops swung"));
        assert_eq!(
            (unstable.is_some(), swung),
            (swings, swings),
            "{gains}: {:?}",
            done.warnings
        );
        let Some(text) = unstable else { continue };
        let (_, remedy) = text.split_once("lower `wheel_loop.").expect("a remedy");
        let (key, value) = remedy.split_once("` to ").expect("a gain");
        let value = value.split(',').next().expect("a number");
        let lowered = format!("wheel_loop.timing = 'sampled'\nwheel_loop.{key} = {value}");
        let lowered = run(&lowered);
        let still = lowered
            .warnings
            .iter()
            .find(|text| text.contains("unstable"));
        assert_eq!(still, None, "{gains}");
    }
}

/// A continuous loop reaches its target within a step from a bandwidth of some periods on. Beyond
/// 2000 of them its torques lose their digits, and it is refused with the largest value.
#[test]
fn loops_faster_than_can_be_computed_with_are_refused_with_a_figure_that_does() {
    for key in [
        "bandwidth_rad_s",
        "proportional_n_m_s",
        "integral_n_m",
        "derivative_n_m_s2",
    ] {
        let of = |value: &str| ilon_sim::run(&scenario_of(&format!("wheel_loop.{key} = {value}")));
        let Err(Error::Scenario(fault)) = of("1e9") else {
            panic!("{key}: it is refused, with its place");
        };
        let (message, help) = (&fault.message, &fault.help);
        assert!(message.contains(key), "{message}");
        let most = help.strip_prefix("give no more than ").expect("a figure");
        let done = of(most).expect("it runs");
        only_lost(key, &done.summary.energy);
        let gave = done
            .warnings
            .iter()
            .find(|text| text.contains("gave energy"));
        assert_eq!(gave, None, "{key}");
    }
}

/// A robot that drives and stops again has hardly any net work of its motors. The unexplained
/// energy is still small relative to their positive work, and there is no warning.
#[test]
fn a_drive_and_a_stop_close() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let text = "robot.file = 'mecanum4.urdf'\ntwist = { vx_m_s = 1.5, rest_s = 0.5, ramp_s = 1, schedule = [ { from_s = 4, vx_m_s = 0 } ] }\n\
                run.duration_s = 6";
    let scenario = Scenario::from_toml(text, "stop", folder).expect("a scenario");
    let done = ilon_sim::run(&scenario).expect("it runs");
    let energy = &done.summary.energy;
    only_lost("stop", energy);
    let [motor_j, drove_j] = [energy.motor_j, energy.motor_positive_j].map(|j| j.expect("counted"));
    // m v^2 / 2 of some 11 kg at 1.5 m/s is driven and braked.
    assert!(drove_j > 12.0 && motor_j < 0.5 * drove_j, "{energy:?}");
    assert!(
        energy.unexplained_share.expect("it moved").abs() < 5e-4,
        "{energy:?}"
    );
    assert!(
        done.warnings.iter().all(|text| !text.contains("energies")),
        "{:?}",
        done.warnings
    );
}
