//! Overrides for single wheels of a description apply to those wheels only; and drives of a
//! description.

use crate::common;

use std::f64::consts::TAU;

use common::{SPEC, small};
use ilon_formats::{Fault, LoadRobot, RobotError, Spec, generate};
use ilon_robot::{DriveTrain, Robot, Wheel, wrap_angle};
use test_case::test_case;

fn robot(more: &str) -> Result<Robot, RobotError> {
    let spec = Spec::from_toml_str(&format!("{SPEC}\n{more}"), "r.toml")?;
    Robot::from_urdf_str(&generate(&spec)?, "r.urdf")
}

fn place_rad(wheel: &Wheel, roller: usize) -> f64 {
    let center = wheel.rollers[roller].center_in_hub_m;
    center.y.atan2(center.x)
}

/// The rollers' phase about the hub axis, in shares of a pitch.
fn phase(wheel: &Wheel) -> f64 {
    let pitch_rad = TAU / wheel.rollers.len() as f64;
    (place_rad(wheel, 0) / pitch_rad).rem_euclid(1.0)
}

#[test]
fn the_rollers_of_one_wheel_stand_further_on() {
    // Eight rollers: a pitch is 45 degrees, and 15 degrees are a third of it.
    let robot = robot("[overrides.wheel_2]\nphase_deg = 15").unwrap();
    for wheel in &robot.wheels {
        let share = if wheel.name == "wheel_2" {
            1.0 / 3.0
        } else {
            0.0
        };
        let off = (phase(wheel) - share).abs();
        assert!(
            off.min(1.0 - off) < 1e-9,
            "{}: {}",
            wheel.name,
            phase(wheel)
        );
    }
}

#[test]
fn a_phase_turns_the_way_that_a_positive_rate_turns_the_wheel() {
    let robot = robot("[overrides.wheel_1]\nphase_deg = 10").unwrap();
    let first = robot.wheels.iter().find(|w| w.name == "wheel_1").unwrap();
    // Positions count about the hub axis from straight down.
    let nearest = (0..8)
        .map(|i| place_rad(first, i))
        .min_by(|p, q| p.abs().total_cmp(&q.abs()));
    assert!(wrap_angle(nearest.unwrap() - 10f64.to_radians()).abs() < 1e-9);
}

#[test]
fn a_worn_wheel_is_smaller_on_an_axle_of_the_same_height() {
    let robot = robot("[overrides.wheel_3]\nradius_m = 0.049\nroller_radius_m = 0.011").unwrap();
    for wheel in &robot.wheels {
        let (radius_m, roller_m) = if wheel.name == "wheel_3" {
            (0.049, 0.011)
        } else {
            (0.05, 0.012)
        };
        assert!((wheel.radius_m - radius_m).abs() < 1e-12);
        assert!((wheel.rollers[0].radius_m - roller_m).abs() < 1e-12);
        assert!((wheel.rollers[0].ring_radius_m() - 0.038).abs() < 1e-12);
        assert!((wheel.position_m().z - 0.05).abs() < 1e-12);
    }
    // 1 mm over the 0.3 m from the other two.
    let pose = robot.standing_pose().unwrap();
    assert!((pose.tilt_rad() - 1e-3 / 0.3).abs() < 1e-5);
    assert!(robot.wheels.iter().all(|w| pose.gap_m(w).abs() < 1e-12));
}

#[test]
fn a_wheel_may_have_other_rollers_and_another_handedness() {
    let robot = robot(
        "[overrides.wheel_1]\nper_row = 10\ngamma_deg = -45\nroller_mass_kg = 0.02\nhub_mass_kg = 0.3",
    )
    .unwrap();
    let (other, plain) = (&robot.wheels[0], &robot.wheels[1]);
    assert_eq!((other.rollers.len(), plain.rollers.len()), (10, 8));
    assert!((other.gamma_rad.to_degrees() + 45.0).abs() < 1e-9);
    assert!(plain.gamma_rad.abs() < 1e-9);
    assert!((other.rollers[0].mass_kg - 0.02).abs() < 1e-12);
    assert!((other.hub.mass_kg - 0.3).abs() < 1e-12);
}

#[test]
fn the_drive_of_a_description_is_that_of_each_wheel() {
    let text = SPEC.replace(
        "[rollers]",
        "gear_ratio = 30\nrotor_inertia_kg_m2 = 2e-6\ngear_efficiency = 0.8\ngear_friction_n_m = 0.02\n[rollers]",
    );
    let spec = Spec::from_toml_str(&text, "r.toml").unwrap();
    let robot = Robot::from_urdf_str(&generate(&spec).unwrap(), "r.urdf").unwrap();
    for wheel in &robot.wheels {
        assert_eq!(wheel.drive, spec.wheel.drive());
        // 900 times 2e-6 kg m^2.
        assert!((wheel.drive.reflected_inertia_kg_m2() - 1.8e-3).abs() < 1e-15);
    }
}

#[test]
fn a_description_without_a_drive_writes_none() {
    assert!(!small().contains("ilon_drive"));
    let robot = Robot::from_urdf_str(&small(), "r.urdf").unwrap();
    assert!(
        robot
            .wheels
            .iter()
            .all(|w| w.drive == DriveTrain::default())
    );
}

#[test]
fn the_ratio_of_a_transmission_is_read() {
    let transmission = "<transmission name=\"t\"><joint name=\"wheel_2\"/><actuator name=\"m\">\
                        <mechanicalReduction>-19.2</mechanicalReduction></actuator></transmission></robot>";
    let robot = Robot::from_urdf_str(&small().replace("</robot>", transmission), "r.urdf").unwrap();
    let ratios: Vec<f64> = robot.wheels.iter().map(|w| w.drive.gear_ratio).collect();
    // The sign is the motor's direction, which is internal to the wheel.
    assert_eq!(ratios, [1.0, 19.2, 1.0]);
}

#[test_case("gear_efficiency=\"1.5\"", "at most 1"; "efficiency")]
#[test_case("gear_ratio=\"0\"", "above 0"; "ratio")]
#[test_case("rotor_inertia=\"much\"", "number"; "words")]
#[test_case("gear_friction=\"NaN\"", ""; "nan")]
fn a_bad_figure_of_a_drive_is_refused(attribute: &str, said: &str) {
    let drive = format!("<ilon_drive joint=\"wheel_1\" {attribute}/></robot>");
    let error = Robot::from_urdf_str(&small().replace("</robot>", &drive), "r.urdf").unwrap_err();
    assert!(error.to_string().contains(said), "{error}");
}

#[test]
fn a_drive_of_no_joint_is_refused() {
    let text = small().replace("</robot>", "<ilon_drive joint=\"wheel_9\"/></robot>");
    let error = Robot::from_urdf_str(&text, "r.urdf").unwrap_err();
    assert!(matches!(error.fault(), Fault::UnknownJoint { joint, .. } if joint == "wheel_9"));
    // A name that is like none gets the list.
    let text = small().replace("</robot>", "<ilon_drive joint=\"nope\"/></robot>");
    let help = Robot::from_urdf_str(&text, "r.urdf").unwrap_err().help();
    assert!(
        help.starts_with("the file has the joints ") && help.contains("`wheel_1`"),
        "{help}"
    );
}

#[test_case(
    "[overrides.wheel_9]\nradius_m = 0.05",
    "there is no wheel `wheel_9`; there are `wheel_1`";
    "unknown"
)]
#[test_case("[overrides.wheel_1]\nradius_m = 0", "overrides.wheel_1.radius_m"; "nothing")]
#[test_case("[overrides.wheel_1]\ngamma_deg = 90", "overrides.wheel_1.gamma_deg"; "steep")]
#[test_case(
    "[overrides.wheel_1]\nroller_radius_m = 0.06",
    "overrides.wheel_1.roller_radius_m";
    "thick"
)]
#[test_case("[overrides.wheel_1]\nper_row = 2", "overrides.wheel_1.per_row"; "few")]
#[test_case("[overrides.wheel_1]\nphase_deg = inf", "overrides.wheel_1.phase_deg"; "endless")]
#[test_case(
    "[overrides.wheel_1]\nroller_radius_m = 0.002",
    "wheel `wheel_1`: rollers of 2.00 mm";
    "slender"
)]
#[test_case("[overrides.wheel_1]\nphase = 3", "phase"; "misspelt")]
fn an_override_that_does_not_fit_is_refused(more: &str, said: &str) {
    let error = robot(more).unwrap_err().to_string();
    assert!(error.contains(said), "{error}");
}

#[test]
fn a_place_has_as_many_numbers_as_it_has_axes() {
    let place = "center_m = [0.0, 0.0, 0.06]";
    assert!(SPEC.contains(place));
    for (other, count) in [("[0, 0, 0.06, 1]", 4), ("[0, 0]", 2)] {
        let text = SPEC.replace(place, &format!("center_m = {other}"));
        let said = Spec::from_toml_str(&text, "r.toml")
            .unwrap_err()
            .to_string();
        let wanted = format!("`chassis.center_m` has {count} entries, but must have 3");
        assert!(said.contains(&wanted), "{said}");
    }
    let text = SPEC.replace(
        "[wheels.ring]",
        "profile_m = [[-0.01, 0.01], [0.01, 0.01, 0.02]]\n[wheels.ring]",
    );
    let said = Spec::from_toml_str(&text, "r.toml")
        .unwrap_err()
        .to_string();
    assert!(
        said.contains("`rollers.profile_m.1` has 3 entries, but must have 2"),
        "{said}"
    );
}
