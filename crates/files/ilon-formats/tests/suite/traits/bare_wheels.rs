//! Wheels without rollers, and repairs.

use std::f64::consts::PI;

use super::{fault_of, load, mecanum, remarked};
use crate::traits::common::{SPEC, line_of, options, small};
use ilon_formats::{Fault, Handedness, LoadRobot, Spec, WheelOptions, generate};
use ilon_robot::Robot;
use test_case::test_case;

/// The mecanum robot with plain cylinders for wheels.
fn plain_wheels() -> String {
    let mut out = String::new();
    let mut skipping = false;
    for line in mecanum().lines() {
        let opens = line.starts_with("  <joint") || line.starts_with("  <link");
        if opens {
            skipping = line.contains("_roller_");
        }
        if !skipping || line.starts_with("</robot>") {
            out.push_str(&line.replace(r#"<cylinder radius="0.03""#, r#"<cylinder radius="0.05""#));
            out.push('\n');
        }
    }
    out
}

pub fn rollers() -> WheelOptions {
    let mut rollers = WheelOptions::new(9, Handedness::XDeg(45.0));
    rollers.roller_radius_m = Some(0.012);
    rollers.roller_mass_kg = Some(0.01);
    rollers.damping_n_m_s = 1e-6;
    rollers
}

#[test]
fn wheels_without_rollers_are_told_by_name() {
    let Fault::NoRollers { wheels, .. } = fault_of(&plain_wheels()) else {
        panic!("another fault")
    };
    assert_eq!(
        wheels,
        ["front_left", "front_right", "rear_left", "rear_right"]
    );
}

/// A negative angle is the O: each gamma is that of the X with the opposite sign.
#[test]
fn a_negative_angle_in_the_x_is_the_o() {
    let gammas = |deg: f64| -> Vec<f64> {
        let options = options(|o| {
            o.wheels = Some(WheelOptions::new(9, Handedness::XDeg(deg)));
        });
        let loaded = Robot::from_urdf_str_with(&plain_wheels(), "plain.urdf", &options);
        let wheels = loaded.unwrap_or_else(|e| panic!("{e}")).robot.wheels;
        wheels.iter().map(|wheel| wheel.gamma_rad).collect()
    };
    let turned: Vec<f64> = gammas(45.0).into_iter().map(|gamma| -gamma).collect();
    assert_eq!(gammas(-45.0), turned);
}

#[test]
fn rollers_put_into_bare_wheels_make_the_robot_that_has_them() {
    let options = options(|o| {
        o.wheels = Some(rollers());
    });
    let given = Robot::from_urdf_str_with(&plain_wheels(), "plain.urdf", &options)
        .unwrap_or_else(|e| panic!("{e}"))
        .robot;
    // The same robot described with nine rollers.
    let spec = SPEC
        .split("[wheels.ring]")
        .next()
        .expect("a description")
        .replace("per_row = 8", "per_row = 9")
        + "[wheels.mecanum]\naxles_m = [0.2, -0.2]\nhalf_width_m = 0.25\ngamma_deg = 45.0\n";
    let spec = Spec::from_toml_str(&spec, "mecanum.toml").expect("a good description");
    let described = load(&generate(&spec).expect("in range"));
    for (p, q) in given.wheels.iter().zip(&described.wheels) {
        assert_eq!(p.name, q.name);
        assert!((p.gamma_rad - q.gamma_rad).abs() < 1e-13);
        assert!((p.radius_m - q.radius_m).abs() < 1e-15);
        // The rollers' mass is taken from the wheel's: 0.2 kg less 9 * 0.01 kg.
        assert!((p.hub.mass_kg - 0.11).abs() < 1e-15);
        assert_eq!(p.rollers.len(), q.rollers.len());
        for a in &p.rollers {
            let b = q
                .rollers
                .iter()
                .find(|b| b.name == a.name)
                .expect("the same names");
            assert!((a.length_m - b.length_m).abs() < 1e-13);
            assert!((a.axial_inertia_kg_m2 - b.axial_inertia_kg_m2).abs() < 1e-17);
            assert!((a.center_in_hub_m - b.center_in_hub_m).norm() < 1e-14);
            assert!((a.axis_in_hub.into_inner() - b.axis_in_hub.into_inner()).norm() < 1e-13);
        }
    }
}

/// A robot whose wheels are at (+-0.2, +-0.18) m, each on a joint whose origin is at `joint_y_m` on
/// its own side of the middle; a negative number is on the other side.
fn wheels_on_long_axles(joint_y_m: f64) -> String {
    let mut text = "<robot name='axles'><link name='base_link'><inertial><mass value='10'/>\
        <inertia ixx='0.1' ixy='0' ixz='0' iyy='0.2' iyz='0' izz='0.3'/></inertial></link>"
        .to_owned();
    for (name, x_m, side) in [
        ("fl", 0.2, 1.0),
        ("fr", 0.2, -1.0),
        ("rl", -0.2, 1.0),
        ("rr", -0.2, -1.0),
    ] {
        let (joint_m, axle_m) = (side * joint_y_m, side * (0.18 - joint_y_m));
        text += &format!(
            "<link name='{name}'><inertial><origin xyz='0 {axle_m} 0'/><mass value='0.5'/>\
             <inertia ixx='0.0006' ixy='0' ixz='0' iyy='0.001' iyz='0' izz='0.0006'/></inertial>\
             <collision><origin xyz='0 {axle_m} 0' rpy='1.5707963267948966 0 0'/>\
             <geometry><cylinder radius='0.05' length='0.04'/></geometry></collision></link>\
             <joint name='{name}_joint' type='continuous'><parent link='base_link'/><child link='{name}'/>\
             <origin xyz='{x_m} {joint_m} 0.05'/><axis xyz='0 1 0'/></joint>"
        );
    }
    text + "</robot>"
}

/// The rollers' handedness follows from the wheels' places, not from the places of the joints'
/// origins along their axes: on the wheels' side, on the middle line, or across it.
#[test]
fn an_x_is_made_by_where_the_wheels_stand() {
    for joint_y_m in [0.18, 0.02, 0.0, -0.02] {
        let options = options(|o| {
            o.wheels = Some(rollers());
        });
        let robot =
            Robot::from_urdf_str_with(&wheels_on_long_axles(joint_y_m), "axles.urdf", &options)
                .unwrap_or_else(|e| panic!("{joint_y_m}: {e}"))
                .robot;
        let found: Vec<f64> = robot
            .wheels
            .iter()
            .map(|w| w.gamma_rad.to_degrees().round())
            .collect();
        assert_eq!(found, [-45.0, 45.0, 45.0, -45.0], "{joint_y_m}");
        for wheel in &robot.wheels {
            let y_m = wheel.body_from_hub.translation.y.abs();
            assert!((y_m - 0.18).abs() < 1e-12, "{joint_y_m}: {y_m}");
        }
    }
}

#[test]
fn a_heavy_wheel_keeps_its_mass_and_inertia_when_rollers_are_put_in() {
    let text = plain_wheels().replace(
        r#"ixx="7.16666666666667e-5" ixy="0" ixz="0" iyy="7.16666666666667e-5" iyz="0" izz="9e-5""#,
        r#"ixx="4e-4" ixy="0" ixz="0" iyy="4e-4" iyz="0" izz="6e-4""#,
    );
    assert!(text.contains("6e-4"), "the inertia that is replaced");
    let options = options(|o| {
        o.wheels = Some(rollers());
    });
    let robot = Robot::from_urdf_str_with(&text, "plain.urdf", &options)
        .unwrap_or_else(|e| panic!("{e}"))
        .robot;
    for wheel in &robot.wheels {
        let rollers_kg: f64 = wheel.rollers.iter().map(|r| r.mass_kg).sum();
        assert!((wheel.hub.mass_kg + rollers_kg - 0.2).abs() < 1e-15);
        // About the hub axis a roller adds m a^2, and of its own inertia J cos^2 + K sin^2 with the
        // angle of 45 deg.
        let of_rollers: f64 = wheel
            .rollers
            .iter()
            .map(|r| {
                r.mass_kg * 0.038 * 0.038
                    + 0.5 * (r.axial_inertia_kg_m2 + r.transverse_inertia_kg_m2)
            })
            .sum();
        assert!((wheel.hub.inertia_kg_m2[(2, 2)] + of_rollers - 6e-4).abs() < 1e-15);
    }
}

#[test_case(|o: &mut WheelOptions| o.joints = vec!["none".to_owned()], "there is no joint `none`; wheels could be `front_left`, `front_right`, `rear_left`, `rear_right`"; "unknown joint")]
#[test_case(|o: &mut WheelOptions| o.rollers = 2, "`rollers` is 2, but must be from 3 to 1000"; "too few")]
#[test_case(|o: &mut WheelOptions| o.gamma = Handedness::AllDeg(90.0), "`gamma` is 90, but must be from -85 to 85 degrees"; "right angle")]
#[test_case(|o: &mut WheelOptions| o.gamma = Handedness::EachDeg(vec![0.0]), "`gamma.each_deg` is 1 numbers, but must be as long as the list of wheels"; "short list")]
#[test_case(|o: &mut WheelOptions| o.roller_mass_kg = Some(0.1), "`roller_mass_kg` is 0.1, but must be so light that all rollers weigh less than the wheel"; "heavy")]
#[test_case(|o: &mut WheelOptions| o.roller_radius_m = Some(0.001), "rollers of 1.00 mm radius taper to nothing before they reach their neighbours"; "slender")]
fn rollers_that_do_not_fit_are_refused(change: fn(&mut WheelOptions), expected: &str) {
    let mut wheels = rollers();
    change(&mut wheels);
    let options = options(|o| {
        o.wheels = Some(wheels);
    });
    let error = Robot::from_urdf_str_with(&plain_wheels(), "plain.urdf", &options)
        .expect_err("it does not fit");
    assert_eq!(error.fault().to_string(), expected);
}

#[test]
fn a_repair_says_what_it_changed_and_keeps_the_lines() {
    // No inertia for the chassis, a second limit, and missing outermost spheres.
    let text = small().replacen(
        r#"<limit effort="1" velocity="20"/>"#,
        "<limit effort=\"1\" velocity=\"20\"/><limit effort=\"9\"\n velocity=\"9\"/>",
        1,
    );
    let from = text.find("<inertia ").expect("an inertia");
    let to = from + text[from..].find("/>").expect("its end") + 2;
    let text = format!("{}{}", &text[..from], &text[to..]);
    let text: String = text
        .lines()
        .filter(|l| !(l.contains("<collision>") && l.contains("0.0157401153")))
        .flat_map(|l| [l, "\n"])
        .collect();
    let options = options(|o| {
        o.repair = true;
    });
    assert!(Robot::from_urdf_str(&text, "broken.urdf").is_err());
    let robot = Robot::from_urdf_str_with(&text, "broken.urdf", &options)
        .unwrap_or_else(|e| panic!("{e}"))
        .robot;
    assert!(remarked(
        &robot,
        "link `base_link`, `<inertial>`",
        "repaired: its inertia is taken as that of a solid of its shapes that weighs 5 kg"
    ));
    assert!(remarked(
        &robot,
        "joint `wheel_1`, `<limit>`",
        "stands here a second time: the first is read"
    ));
    assert!(remarked(
        &robot,
        "wheel `wheel_3`",
        "repaired: rollers made longer to close gaps of up to 14.13 deg"
    ));
    assert_eq!(robot.wheels[0].motor.effort_n_m, 1.0);
    for roller in &robot.wheels[0].rollers {
        assert!((roller.length_m - 2.0 * 0.038 * (PI / 8.0).tan()).abs() < 1e-13);
    }
    // A remaining fault is reported with its line in the original file.
    let text = text.replace(r#"<mass value="0.01"/>"#, r#"<mass value="-1"/>"#);
    let error =
        Robot::from_urdf_str_with(&text, "broken.urdf", &options).expect_err("a negative mass");
    assert_eq!(error.line(), Some(line_of(&text, "value=\"-1\"")));
}
