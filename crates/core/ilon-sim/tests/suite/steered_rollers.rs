//! Omni wheels that are steered together are a gear: at an angle phi from the direction of motion
//! a wheel of radius rho turns at v cos(phi) / rho, and four of them need the torque F rho /
//! (4 cos(phi)) each for a force F.

use std::path::Path;

use ilon_sim::{Error, Run, Scenario, run};

const RADIUS_M: f64 = 0.05;

/// The shipped steered robot at an angle of its wheels in degrees.
fn driven(angle_deg: f64, keys: &str) -> Result<Run, Error> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
    let target_rad = (45.0 - angle_deg).to_radians();
    let text = format!(
        "twist = {{ vx_m_s = 0.3 }}\n[robot]\nfile = \"omni4_steered.urdf\"\n\
         wheels = {{ rollers = 10, gamma.all_deg = 0, joints = [\"front_left_drive\", \
         \"front_right_drive\", \"rear_left_drive\", \"rear_right_drive\"] }}\n\
         [robot.joints.front_left_steer]\nrole = \"driven\"\ntarget_rad = {target_rad}\n\
         stiffness_n_m_rad = 2000\n[run]\nduration_s = 3\n{keys}"
    );
    run(&Scenario::from_toml(&text, "steered", folder)?)
}

#[test]
fn wheel_rates_follow_the_cosine_of_the_angle() {
    for angle_deg in [20.0_f64, 45.0, 65.0] {
        let found = driven(angle_deg, "").expect("it drives");
        let end = found.trace.records().last().expect("rows");
        let wheels = found.trace.wheels_at(found.trace.records().len() - 1);
        let v_m_s = end.truth.twist_in_body.vx_m_s;
        let expected = v_m_s * angle_deg.to_radians().cos() / RADIUS_M;
        assert!((v_m_s - 0.3).abs() < 3e-3, "{v_m_s}");
        for wheel in wheels {
            // The servos give by some 1e-4 rad under load.
            let off = wheel.rate_rad_s.abs() / expected - 1.0;
            assert!(off.abs() < 1e-3, "{angle_deg}: {off}");
        }
    }
}

/// On a slope of 5 degrees down towards +x, driven up backwards at a constant speed.
#[test]
fn torques_on_a_slope_follow_the_inverse_cosine() {
    let weight_n = 14.8 * 9.81;
    let force_n = weight_n * 5_f64.to_radians().sin();
    let mut torques = Vec::new();
    for angle_deg in [25.0_f64, 60.0] {
        let keys = "[world.floor]\nslope_deg = 5\n";
        let found = driven(angle_deg, keys).expect("it drives");
        let wheels = found.trace.wheels_at(found.trace.records().len() - 1);
        let held: f64 = wheels.iter().map(|wheel| wheel.torque_n_m.abs()).sum();
        let expected = force_n * RADIUS_M / angle_deg.to_radians().cos();
        // Bearings without friction, no rolling resistance: the loops' last error remains.
        assert!((held / expected - 1.0).abs() < 0.01, "{held} {expected}");
        torques.push(held);
    }
    assert!(torques[1] > 1.7 * torques[0]);
}

/// Lemma 1, c.2: with all roller axes parallel no wheel drives across them.
#[test]
fn wheels_that_all_point_ahead_are_refused_with_the_reason() {
    let error = driven(0.0, "").unwrap_err().to_string();
    assert!(error.contains("all roller axes are parallel"), "{error}");
}
