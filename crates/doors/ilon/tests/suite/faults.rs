//! Faults in a scenario: their effects are the derived ones, and the trace shows them.

use std::path::Path;

use ilon::scenario::Scenario;
use ilon::simulate::Run;

/// Runs a scenario in the folder of the robots.
fn run_text(text: &str) -> Run {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let scenario = Scenario::from_toml(text, "fault", folder).expect("a scenario");
    ilon::run(&scenario).expect("it runs")
}

/// Robot A at rest for a second, with further lines of TOML.
fn run(further: &str) -> Run {
    run_text(&format!(
        "[robot]\nfile = 'mecanum4.urdf'\nroller_bodies = 'near'\n[twist]\nvx_m_s = 0\n[run]\nduration_s = 1\n{further}"
    ))
}

fn at(run: &Run, signal: &str, t_s: f64) -> f64 {
    let values = run.trace.signal(signal).expect("it is recorded");
    let times = run.trace.records().iter().map(|record| record.t_s);
    let row = times
        .zip(values)
        .find(|(row_s, _)| (row_s - t_s).abs() < 1e-6);
    row.and_then(|(_, value)| value)
        .expect("a value at that time")
}

/// 11.36 kg: 10 kg of chassis, four hubs of 0.25 kg and 36 rollers of 10 g.
const MASS_KG: f64 = 11.36;

/// On ice without friction m v = J, exactly, whatever the alignment of push and steps; its
/// direction is in the world's frame or in the robot's.
#[test]
fn a_push_brings_its_whole_impulse_whatever_the_step() {
    for (dt_s, lasts_s) in [
        (0.002, 0.05),
        (0.002, 0.0333),
        (0.0025, 0.0333),
        (0.01, 0.001),
    ] {
        let run = run(&format!(
            "physics_dt_s = {dt_s}\n[world.floor]\nfriction = 0\n[[faults]]\n\
             push = {{ impulse_x_n_s = 2.272, from_s = 0.3, lasts_s = {lasts_s} }}"
        ));
        let v = at(&run, "truth_vx_m_s", 0.9);
        // f32 sums of a hundred steps.
        assert!(
            (v - 2.272 / MASS_KG).abs() < 1e-5,
            "{v} m/s with steps of {dt_s} s"
        );
        assert!(
            at(&run, "truth_vx_m_s", 0.3).abs() < 1e-6,
            "nothing pushes before"
        );
    }
    // Robot A faces +y: its own +x is the world's +y, and the twist is in its own axes.
    for (frame, along, across) in [
        ("body", "truth_vx_m_s", "truth_vy_m_s"),
        ("world", "truth_vy_m_s", "truth_vx_m_s"),
    ] {
        let run = run_text(&format!(
            "[robot]\nfile = 'mecanum4.urdf'\nroller_bodies = 'near'\nheading_deg = 90\n[twist]\nvx_m_s = 0\n[run]\nduration_s = 1\n\
             [world.floor]\nfriction = 0\n[[faults]]\n\
             push = {{ impulse_x_n_s = 2.272, from_s = 0.3, frame = '{frame}' }}"
        ));
        assert!((at(&run, along, 0.9).abs() - 0.2).abs() < 1e-5, "{frame}");
        assert!(at(&run, across, 0.9).abs() < 1e-5, "{frame}");
    }
}

/// The energy of a push on a good floor ends as heat and as motion.
#[test]
fn a_push_on_a_good_floor_closes_the_energy_balance() {
    let run = run("[[faults]]\npush = { impulse_y_n_s = 6, from_s = 0.3 }");
    let energy = run.summary.energy;
    let (outside_j, rest_j) = (
        energy.outside_j.expect("it is counted"),
        energy.unexplained_j.expect("it is counted"),
    );
    // Friction resists the push while it lasts, so that its work is less than J^2 / 2 m = 1.58 J.
    assert!(outside_j > 0.3 && outside_j < 1.58, "{outside_j} J");
    // Heat is counted at each step's end: up to half a step's deceleration is missed, a per cent or
    // two.
    assert!(
        rest_j.abs() < 0.05 * outside_j,
        "{rest_j} J of {outside_j} J"
    );
}

/// Four symmetric wheels carry the added weight together, until it is removed.
#[test]
fn a_payload_weighs_while_it_is_there() {
    let run = run("[[faults]]\npayload = { mass_kg = 4, from_s = 0.3, until_s = 0.7 }");
    let weight_n = |t_s| -> f64 {
        (0..4)
            .map(|wheel| at(&run, &format!("wheel{wheel}_normal_force_n"), t_s))
            .sum()
    };
    for (t_s, mass_kg) in [(0.29, MASS_KG), (0.6, MASS_KG + 4.0), (0.95, MASS_KG)] {
        // Contacts that have come to rest again: a thousandth.
        assert!(
            (weight_n(t_s) / (9.81 * mass_kg) - 1.0).abs() < 1e-3,
            "{} N",
            weight_n(t_s)
        );
    }
    assert!(at(&run, "outside_energy_j", 0.95).abs() < 0.01);
}

/// The whole floor by time, a patch by place and time: every row has the friction under its wheels.
#[test]
fn friction_changes_when_and_where_it_is_asked_to() {
    let run = run(
        "[[faults]]\nfriction_changed = { friction = 0.2, from_s = 0.3, until_s = 0.6 }\n\
         [[world.floor.patches]]\nx_m = 0.15\ny_m = 0.16\nlength_x_m = 0.1\nlength_y_m = 0.1\nfriction = 0.1\n\
         from_s = 0.5\nuntil_s = 0.8",
    );
    let friction = |wheel: usize, t_s| at(&run, &format!("wheel{wheel}_friction"), t_s);
    // A row shows the step before it. The patch lies under the front left wheel, wheel 0.
    for (t_s, under_0, under_3) in [
        (0.3, 0.6, 0.6),
        (0.31, 0.2, 0.2),
        (0.5, 0.2, 0.2),
        (0.51, 0.1, 0.2),
        (0.6, 0.1, 0.2),
        (0.61, 0.1, 0.6),
        (0.8, 0.1, 0.6),
        (0.81, 0.6, 0.6),
    ] {
        // Friction values pass through f32.
        assert!((friction(0, t_s) - under_0).abs() < 1e-7, "{t_s} s");
        assert!((friction(3, t_s) - under_3).abs() < 1e-7, "{t_s} s");
    }
}

/// An encoder that counts half makes its wheel turn twice as fast, and dead reckoning uses the
/// counts.
#[test]
fn an_encoder_that_counts_wrong_misleads_the_wheel_loop_and_the_odometry() {
    let text = "[[faults]]\nencoder_scaled = { wheel = 'WHEEL', factor = 0.5 }\n";
    let every: String = ["front_left", "front_right", "rear_left", "rear_right"]
        .iter()
        .map(|wheel| text.replace("WHEEL", wheel))
        .collect();
    let run = run_text(&format!(
        "[robot]\nfile = 'mecanum4.urdf'\nroller_bodies = 'near'\n[twist]\nvx_m_s = 0.1\nrest_s = 0\nramp_s = 0.2\n\
         [run]\nduration_s = 1.5\n{every}"
    ));
    let rate = at(&run, "wheel0_rate_rad_s", 1.4);
    // 0.1 m/s over 0.05 m, twice: 4 rad/s, within the error of the wheel loop.
    assert!((rate - 4.0).abs() < 0.02, "{rate} rad/s");
    let (truth_m, believed_m) = (
        at(&run, "truth_x_m", 1.4),
        at(&run, "odometry_ideal_x_m", 1.4),
    );
    assert!(
        (believed_m / truth_m - 0.5).abs() < 0.01,
        "{believed_m} m of {truth_m} m"
    );
}

/// At half of its supply a DC motor with the line 1.5 N m (1 - w / 8) gives 1.5 N m (0.5 - w / 8).
/// Against a bearing of 0.001 N m s that ends at w = 0.75 / (0.1875 + 0.001) = 3.98 rad/s, short of
/// the commanded 6 rad/s.
#[test]
fn a_sagging_battery_takes_the_motors_no_load_rate_down() {
    let run = run_text(
        "[robot]\nfile = 'mecanum4.urdf'\nroller_bodies = 'near'\n[twist]\nvx_m_s = 0.3\nrest_s = 0\nramp_s = 0.3\n\
         [motors.dc]\nstall_torque_n_m = 1.5\nno_load_rate_rad_s = 8\n[run]\nduration_s = 3\n\
         [[faults]]\nbattery_sag = { share = 0.5, until_s = 1.5 }",
    );
    let (sagged, recovered) = (
        at(&run, "wheel0_rate_rad_s", 1.4),
        at(&run, "wheel0_rate_rad_s", 2.9),
    );
    // Roller bearings, and the remaining acceleration.
    assert!((sagged - 3.98).abs() < 0.01, "{sagged} rad/s");
    assert!((recovered - 6.0).abs() < 0.05, "{recovered} rad/s");
}
