//! The pose of a standing robot, on wheels of any height and size, against closed forms.

use crate::common;

use std::sync::LazyLock;

use common::{options, small};
use ilon_formats::{Fault, LoadRobot, RollerForms, Spec, generate};
use ilon_robot::{Robot, StandingPose};
use proptest::prelude::*;

/// Distance of the wheels of the small robot from its middle, in metres: one is ahead and two at
/// 120 degrees to both sides.
const RING_M: f64 = 0.2;

fn trike() -> Robot {
    Robot::from_urdf_str(&small(), "small.urdf").unwrap()
}

/// Four mecanum wheels at (+-0.2, +-0.15).
fn mecanum() -> Robot {
    let spec = common::SPEC
        .replace(
            "count = 3\ndistance_m = 0.2\ngamma_deg = 0.0",
            "axles_m = [0.2, -0.2]\nhalf_width_m = 0.15\ngamma_deg = 45.0",
        )
        .replace("[wheels.ring]", "[wheels.mecanum]");
    let spec = Spec::from_toml_str(&spec, "mecanum.toml").unwrap();
    Robot::from_urdf_str(&generate(&spec).unwrap(), "mecanum.urdf").unwrap()
}

fn raise(robot: &mut Robot, wheel: usize, by_m: f64) {
    robot.wheels[wheel].body_from_hub.translation.z += by_m;
}

/// Moves the robot's centre of mass, by that of its chassis.
fn balance(robot: &mut Robot, x_m: f64, y_m: f64) {
    let now = robot.center_of_mass_m();
    let share = robot.mass_kg() / robot.chassis.mass.mass_kg;
    robot.chassis.mass.center_of_mass_m.x += share * (x_m - now.x);
    robot.chassis.mass.center_of_mass_m.y += share * (y_m - now.y);
}

fn standing(robot: &Robot) -> StandingPose {
    robot.standing_pose().expect("it stands")
}

/// The wheel in the quadrant with these signs of x and y.
fn at(robot: &Robot, x: f64, y: f64) -> usize {
    let place = |i: &usize| {
        let p = robot.wheels[*i].position_m();
        p.x * x > 0.0 && p.y * y > 0.0
    };
    (0..robot.wheels.len()).find(place).expect("a wheel there")
}

#[test]
fn a_level_robot_stands_level_to_the_last_bit() {
    for robot in [trike(), mecanum()] {
        let pose = standing(&robot);
        assert_eq!((pose.roll_rad, pose.pitch_rad), (0.0, 0.0));
        assert_eq!(pose.height_m, robot.ride_height_m());
        assert_eq!(pose.tilt_rad(), 0.0);
    }
}

/// The wheel ahead is raised by h, or smaller by h. With the nose down by p, and the hub's axis
/// along x, the ring of rollers reaches (rho - b) cos p + b down from its hub; from the hubs
/// behind, whose axes are turned by 120 degrees, (rho - b) sqrt(1 - sin^2 p / 4) + b. All three
/// end on the plane where 1.5 R sin p = h cos p + (rho - b) sqrt(1 - sin^2 p / 4) - (rho_0 - b_0)
/// cos p - (b_0 - b).
#[test]
fn three_wheels_of_unequal_height_carry_the_robot_all() {
    for (h, smaller) in [
        (0.004, false),
        (-0.01, false),
        (0.02, false),
        (0.005, true),
        (-0.007, true),
    ] {
        let mut robot = trike();
        let rho = robot.wheels[0].radius_m;
        let b = robot.wheels[0].rollers[0].radius_m;
        assert!(
            (robot.wheels[0].position_m().x - RING_M).abs() < 1e-9,
            "the first stands ahead"
        );
        if smaller {
            robot.wheels[0].radius_m -= h;
        } else {
            raise(&mut robot, 0, h);
        }
        let rho_0 = robot.wheels[0].radius_m;
        let h = if smaller { 0.0 } else { h };
        let pose = standing(&robot);
        let p = pose.pitch_rad;
        let left = 1.5 * RING_M * p.sin();
        let right =
            h * p.cos() + (rho - b) * (1.0 - p.sin().powi(2) / 4.0).sqrt() - (rho_0 - b) * p.cos();
        // The hubs of the URDF are rounded to slightly fewer digits than double precision.
        assert!((left - right).abs() < 1e-12, "{left} {right}");
        assert!(pose.roll_rad.abs() < 1e-9);
        let mut supporting = pose.supporting;
        supporting.sort_unstable();
        assert_eq!(supporting, [0, 1, 2]);
        // The height of the body above the plane, from the wheel ahead: its lowest point is that of
        // a ring.
        let hub = robot.wheels[0].position_m();
        let height = hub.x * p.sin() - hub.z * p.cos() + (rho_0 - b) * p.cos() + b;
        assert!((pose.height_m - height).abs() < 1e-12);
        for wheel in &robot.wheels {
            assert!(pose.gap_m(wheel).abs() < 1e-12, "{}", pose.gap_m(wheel));
        }
    }
}

/// A raised wheel hangs at that height, while the robot's weight is on the other three.
#[test]
fn four_wheels_of_which_one_is_too_high_stand_level_on_the_others() {
    let mut robot = mecanum();
    let short = at(&robot, 1.0, 1.0);
    raise(&mut robot, short, 0.006);
    balance(&mut robot, -0.05, -0.02);
    let pose = standing(&robot);
    assert_eq!((pose.roll_rad, pose.pitch_rad), (0.0, 0.0));
    assert!(!pose.supporting.contains(&short));
    assert!((pose.gap_m(&robot.wheels[short]) - 0.006).abs() < 1e-12);
}

/// With its weight ahead on the left, where the wheel is short, the robot stands on that wheel and
/// its neighbours: the opposite corner of the rectangle is lifted by as much as the short one is
/// short.
#[test]
fn four_wheels_with_the_weight_on_the_short_one_lean_on_it() {
    let d = 0.006;
    let mut robot = mecanum();
    let (short, across) = (at(&robot, 1.0, 1.0), at(&robot, -1.0, -1.0));
    raise(&mut robot, short, d);
    balance(&mut robot, 0.05, 0.02);
    let pose = standing(&robot);
    assert!(!pose.supporting.contains(&across));
    assert!(pose.supporting.contains(&short));
    // The lowest points move with the square of the tilt, d^2 / 0.15 m = 2.4e-4 m at the very most.
    assert!((pose.gap_m(&robot.wheels[across]) - d).abs() < 1e-4);
    // The diagonal of the neighbours stays; the plane falls by d over the rest: slopes d/0.8 along
    // x and d/0.6 along y, of which both end at the short wheel: 0.2 d/0.4 + 0.15 d/0.3 = d.
    assert!((pose.pitch_rad - d / 0.4).abs() < 1e-3 * d / 0.4 + 1e-4);
    assert!((pose.roll_rad + d / 0.3).abs() < 1e-3 * d / 0.3 + 1e-4);
}

#[test]
fn a_robot_whose_weight_is_outside_its_wheels_does_not_stand() {
    let mut robot = mecanum();
    balance(&mut robot, 0.21, 0.0);
    assert_eq!(robot.standing_pose(), None);
    balance(&mut robot, 0.19, 0.0);
    assert!(robot.standing_pose().is_some());
}

#[test]
fn wheels_in_one_line_carry_nothing() {
    let mut robot = trike();
    for wheel in &mut robot.wheels {
        wheel.body_from_hub.translation.y = 0.0;
    }
    assert_eq!(robot.standing_pose(), None);
}

/// The pose rotates the body so that the plane's normal is its own up.
#[test]
fn the_rotation_of_a_pose_carries_up_to_the_vertical() {
    let mut robot = trike();
    raise(&mut robot, 1, 0.012);
    let pose = standing(&robot);
    let up = pose.rotation() * pose.up_in_body().into_inner();
    assert!((up - nalgebra::Vector3::z()).norm() < 1e-12);
    assert!(pose.roll_rad.abs() > 1e-3 && pose.pitch_rad.abs() > 1e-3);
}

/// Rollers as modelled, such as spheres, end at their shapes, not on a ring.
#[test]
fn wheels_as_modelled_stand_on_their_shapes() {
    let text = small();
    let modelled = options(|o| o.rollers = RollerForms::AsModelled);
    let mut robot = Robot::from_urdf_str_with(&text, "small.urdf", &modelled)
        .unwrap()
        .robot;
    raise(&mut robot, 0, 0.01);
    let pose = standing(&robot);
    for wheel in &robot.wheels {
        assert!(pose.gap_m(wheel).abs() < 1e-9, "{}", pose.gap_m(wheel));
    }
    assert!(pose.pitch_rad > 0.02);
}

proptest! {
    /// Nothing reaches below the plane, three wheels reach it, and the centre of mass is over their
    /// triangle.
    #[test]
    fn no_wheel_is_below_the_plane_and_three_are_on_it(
        raised in prop::collection::vec(-0.01..0.01f64, 4),
        x in -0.1..0.1f64,
        y in -0.1..0.1f64,
    ) {
        static ROBOT: LazyLock<Robot> = LazyLock::new(mecanum);
        let mut robot = ROBOT.clone();
        for (i, by) in raised.iter().enumerate() {
            raise(&mut robot, i, *by);
        }
        balance(&mut robot, x, y);
        let pose = standing(&robot);
        for (i, wheel) in robot.wheels.iter().enumerate() {
            let gap = pose.gap_m(wheel);
            prop_assert!(gap > -1e-9, "wheel {i}: {gap}");
            if pose.supporting.contains(&i) {
                prop_assert!(gap < 1e-9, "wheel {i}: {gap}");
            }
        }
        let up = pose.up_in_body();
        let level = pose.rotation();
        let center = (level * robot.center_of_mass_m()).xy();
        let corners = pose.supporting.map(|i| (level * robot.wheels[i].lowest_point_m(&up)).xy());
        let turn = |i: usize| (corners[(i + 1) % 3] - corners[i]).perp(&(center - corners[i]));
        let turns = [turn(0), turn(1), turn(2)];
        let inside = turns.iter().all(|t| *t > -1e-9) || turns.iter().all(|t| *t < 1e-9);
        prop_assert!(inside, "{turns:?}");
    }
}

/// The small robot with the wheel ahead raised, and a chassis so small that it clears the floor.
fn with_wheel_raised(by_m: f64) -> String {
    let robot = trike();
    let z = robot.wheels[0].position_m().z;
    let text = small().replace("0.3 0.3 0.1", "0.05 0.05 0.05");
    let written = format!("{:?}", z);
    let at = text.find(r#"type="continuous""#).expect("a wheel");
    let origin = at + text[at..].find("xyz=\"").expect("its place") + 5;
    let end = origin + text[origin..].find('"').expect("its end");
    let mut place: Vec<String> = text[origin..end].split(' ').map(str::to_owned).collect();
    assert_eq!(place[2].parse::<f64>().unwrap(), z, "{written}");
    place[2] = format!("{}", z + by_m);
    format!("{}{}{}", &text[..origin], place.join(" "), &text[end..])
}

#[test]
fn a_robot_that_leans_a_little_is_read_with_a_remark() {
    let robot = Robot::from_urdf_str(&with_wheel_raised(0.005), "a.urdf").unwrap();
    assert!((standing(&robot).pitch_rad - 0.005 / 0.3).abs() < 1e-4);
    let said = robot
        .remarks
        .iter()
        .find(|r| r.text.contains("equally low"));
    let said = said.expect("a remark").text.clone();
    // 0.005 m over 0.3 m are 0.955 degrees; the ring of the wheels behind, which are tilted across,
    // adds 4e-6 m.
    assert!(said.contains("0.96 deg"), "{said}");
}

#[test]
fn a_robot_that_leans_by_more_than_five_degrees_is_refused() {
    // 5 degrees over 0.3 m are 26 mm.
    Robot::from_urdf_str(&with_wheel_raised(0.025), "a.urdf").unwrap();
    let error = Robot::from_urdf_str(&with_wheel_raised(0.028), "a.urdf").unwrap_err();
    assert!(
        matches!(error.fault(), Fault::UnevenWheels { .. }),
        "{error}"
    );
}
