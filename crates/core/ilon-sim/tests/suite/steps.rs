//! The automatic step, compared with fixed steps of 0.1 ms.

use std::path::Path;

use ilon_sim::{Scenario, run};
use test_case::test_case;

/// Where a robot ends by the automatic step and by one of 0.1 ms, as their distance in mm, and the
/// sliding of the first over that of the second.
fn apart(robot: &str, text: &str) -> (f64, f64) {
    let end = |step: &str| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
        let text = format!(
            "robot = {{ file = \"{robot}\", roller_bodies = \"near\" }}\nrun.physics_dt_s = {step}\n{text}"
        );
        let scenario = Scenario::from_toml(&text, "steps", folder).unwrap();
        let summary = run(&scenario).unwrap().summary;
        let [x_m, y_m] = [summary.end_x_m, summary.end_y_m].map(Option::unwrap);
        (x_m, y_m, summary.slip_energy_j.unwrap())
    };
    let (auto, short) = (end("\"auto\""), end("1e-4"));
    let apart_m = (auto.0 - short.0).hypot(auto.1 - short.1);
    (1e3 * apart_m, auto.2 / short.2)
}

/// In a curve the wheels pull the robot inwards, and their rates jump at each hand-over. A loop
/// that misses the jumps lets a robot sag sideways less at longer steps, with an integral or
/// without: by 0.6 to 1 mm in 2.5 m. What remains is of hand-overs that are known to half a step,
/// which scatters: 0.01 % of the way, as a mean of four drives.
#[test_case(1.0, 0.4, ""; "ahead")]
#[test_case(1.0, 0.4, "wheel_loop.integral_n_m = 0.0\n"; "without integral")]
#[test_case(0.8, 0.8, ""; "in a narrow curve")]
fn a_curve_ends_where_short_steps_end_it(vx_m_s: f64, omega_rad_s: f64, further: &str) {
    let drive = |share: f64| {
        let vx_m_s = share * vx_m_s;
        let text = format!(
            "world.floor.friction = 0.8\ntwist = {{ vx_m_s = {vx_m_s}, omega_rad_s = {omega_rad_s} }}\nrun.duration_s = 3.0\n{further}"
        );
        apart("mecanum4.urdf", &text).0
    };
    let apart_mm = [1.0, 1.012, 1.024, 1.036].map(drive);
    let mean_mm = apart_mm.iter().sum::<f64>() / 4.0;
    assert!(mean_mm < 0.3, "{apart_mm:?} mm");
}

/// A roller that takes over while its wheel slides spins up within 0.6 ms, and pushes along its
/// axle less until then.
#[test]
fn a_robot_that_slides_ends_where_short_steps_end_it() {
    let drive = |vx_m_s: f64| {
        apart(
            "mecanum4.urdf",
            &format!(
                "world.floor.friction = 0.25\ntwist = {{ vx_m_s = {vx_m_s}, vy_m_s = 0.3, omega_rad_s = 0.4, rest_s = 0.2, ramp_s = 0.2 }}\n\
                 run.duration_s = 1.0\n"
            ),
        )
    };
    for vx_m_s in [1.0, 1.01, 1.02] {
        let (apart_mm, slip) = drive(vx_m_s);
        assert!(apart_mm < 0.1, "{vx_m_s}: {apart_mm} mm");
        assert!((slip - 1.0).abs() < 1e-3, "{vx_m_s}: {slip}");
    }
}

/// Wheels that land on a kerb lose energy in landings, of first order in the step: at 2 ms a tenth
/// to nine tenths of the sliding too much. The automatic step is short enough for a seventh.
#[test_case("mecanum6.urdf", 0.005; "on rollers")]
#[test_case("swerve4.urdf", 0.01; "on tyres")]
fn a_kerb_takes_what_it_takes_in_short_steps(robot: &str, height_m: f64) {
    let text = format!(
        "twist.vx_m_s = 0.3\nrun.duration_s = 4.5\n[[world.floor.boxes]]\nx_m = 0.8\ny_m = 0.2\nlength_x_m = 0.3\nlength_y_m = 0.41\nheight_m = {height_m}\n"
    );
    let (apart_mm, slip) = apart(robot, &text);
    assert!(apart_mm < 1.0, "{apart_mm} mm");
    assert!((slip - 1.0).abs() < 1.0 / 7.0, "{slip}");
}

/// What begins or ends within a physics step acts from there on. A robot that was pushed to 1 m/s and
/// slides comes onto ice: a step that brakes too long takes up to mu g dt / 2 = 10 mm/s of its speed,
/// which over the second left are 6 mm. A payload and a push of their own times likewise;
/// what remains of the push is how far a wheel creeps before it slides.
#[test_case(0.2, "{ push = { impulse_x_n_s = 10, from_s = 0.5, lasts_s = 0.05 } }, { friction_changed = { friction = 0, from_s = 0.5717 } }"; "ice")]
#[test_case(0.2, "{ push = { impulse_x_n_s = 10, from_s = 0.5013, lasts_s = 0.0487 } }, { payload = { mass_kg = 20, from_s = 0.5717 } }"; "a payload")]
#[test_case(0.3, "{ push = { impulse_y_n_s = 10, from_s = 0.50123, lasts_s = 0.0237 } }"; "a push")]
fn what_begins_within_a_step_acts_from_there_on(most_mm: f64, faults: &str) {
    let text = format!(
        "twist = {{ vx_m_s = 0 }}\nrun.duration_s = 1.5\nworld.floor.friction = 0.6\nfaults = [{faults}]\n"
    );
    let (apart_mm, slip) = apart("mecanum4.urdf", &text);
    assert!(apart_mm < most_mm, "{apart_mm} mm");
    assert!((slip - 1.0).abs() < 0.005, "{slip}");
}
