//! Axes and wheels that are level within the rounding of their file's numbers, and those that are
//! tilted intentionally.

use std::fmt::Write;

use ilon_formats::{Handedness, LoadOptions, LoadRobot, WheelOptions};
use ilon_robot::Robot;
use nalgebra::Vector3;

/// A wheel's joint: position in metres, `rpy` of its frame in radians, and axis in it.
struct Placed {
    at_m: [f64; 3],
    rpy: &'static str,
    axis: &'static str,
    radius_m: f64,
}

/// Four wheels of 32.5 mm at (+-67, +-76) mm, their axes along y.
fn exact() -> [Placed; 4] {
    [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]].map(|[x, y]| Placed {
        at_m: [0.067 * x, 0.076 * y, 0.0325],
        rpy: "0 0 0",
        axis: "0 1 0",
        radius_m: 0.0325,
    })
}

/// The file of such a robot, below a base joint of that `rpy`, with ten rollers at 45 degrees
/// added.
fn robot(wheels: &[Placed], base_rpy: &str) -> Robot {
    let mut text = format!(
        "<robot name=\"four\"><link name=\"foot\"/><joint name=\"base\" type=\"fixed\"><origin rpy=\"{base_rpy}\"/><parent link=\"foot\"/>\
         <child link=\"body\"/></joint><link name=\"body\"><inertial><origin xyz=\"0 0 0.01\"/><mass value=\"0.15\"/>\
         <inertia ixx=\"3e-4\" ixy=\"0\" ixz=\"0\" iyy=\"4e-4\" iyz=\"0\" izz=\"6e-4\"/></inertial></link>"
    );
    for (i, wheel) in wheels.iter().enumerate() {
        let ([x, y, z], rpy, axis) = (wheel.at_m, wheel.rpy, wheel.axis);
        write!(
            text,
            "<link name=\"w{i}\"><inertial><mass value=\"0.038\"/><inertia ixx=\"1.2e-5\" ixy=\"0\" ixz=\"0\" iyy=\"1.2e-5\" iyz=\"0\" \
             izz=\"1.2e-5\"/></inertial><collision><geometry><sphere radius=\"{}\"/></geometry></collision></link>\
             <joint name=\"mecanum{i}\" type=\"continuous\"><origin xyz=\"{x} {y} {z}\" rpy=\"{rpy}\"/><parent link=\"body\"/>\
             <child link=\"w{i}\"/><axis xyz=\"{axis}\"/></joint>",
            wheel.radius_m
        )
        .unwrap();
    }
    text.push_str("</robot>");
    let mut options = LoadOptions::default();
    options.wheels = Some(WheelOptions::new(10, Handedness::XDeg(45.0)));
    let loaded = Robot::from_urdf_str_with(&text, "four.urdf", &options);
    loaded.unwrap_or_else(|e| panic!("{e}")).robot
}

/// The remark about levelled parts.
fn said(robot: &Robot) -> Option<&str> {
    let mut remarks = robot.remarks.iter();
    let of_level = remarks.find(|remark| remark.text.starts_with("taken as level"));
    of_level.map(|remark| remark.text.as_str())
}

/// The largest tilt of an axis against the body's plane, in radians, and the largest height
/// difference of lowest points, in metres.
fn off(robot: &Robot) -> (f64, f64) {
    let lean = |of: &ilon_robot::Wheel| (of.body_from_hub.rotation * Vector3::z()).z.abs();
    let wheels = || robot.wheels.iter();
    let bottoms_m = || wheels().map(|of| of.position_m().z - of.radius_m);
    let spread_m =
        bottoms_m().fold(f64::NEG_INFINITY, f64::max) - bottoms_m().fold(f64::INFINITY, f64::min);
    (wheels().map(lean).fold(0.0, f64::max), spread_m)
}

/// Rounding of frames in f64.
const EXACT: f64 = 1e-15;

/// A CAD export: two axes are tilted by 0.04 mrad, one axle is 6 um lower than the others.
#[test]
fn what_an_export_of_cad_rounds_is_level_and_said() {
    assert_eq!(said(&robot(&exact(), "0 0 0")), None);
    let mut wheels = exact();
    wheels[0].axis = "0.00012 1 -4.1e-05";
    wheels[1].axis = "0.00012 1 -4.1e-05";
    wheels[2].at_m[2] -= 6e-6;
    let levelled = robot(&wheels, "0 0 0");
    let (lean_rad, apart_m) = off(&levelled);
    assert!(lean_rad < EXACT && apart_m < EXACT, "{lean_rad} {apart_m}");
    let pose = levelled.standing_pose().unwrap();
    assert_eq!((pose.roll_rad, pose.pitch_rad), (0.0, 0.0));
    // The heading of an axis in the plane is not changed.
    let heading = levelled.wheels[0].axis();
    assert!((heading.x / heading.y - 1.2e-4).abs() < 1e-12);
    let text = said(&levelled).unwrap();
    let figures = [
        "`mecanum0` leans by 0.0023 deg",
        "`mecanum1` leans",
        "`mecanum2` ends 0.0060 mm lower",
    ];
    assert!(figures.iter().all(|of| text.contains(of)), "{text}");
}

/// Half pi with three digits tilts an axis by 0.8 mrad, pi with three by 1.6 mrad; the wheel's
/// middle and the axis's heading are kept.
#[test]
fn axes_of_rounded_turns_are_level() {
    let turns = [
        ("-1.57 0 0", "0 0 1"),
        ("3.14 0 0", "0 -1 0"),
        ("-1.5708 0 0", "0 0 1"),
    ];
    for (rpy, axis) in turns {
        let mut wheels = exact();
        for wheel in &mut wheels {
            (wheel.rpy, wheel.axis) = (rpy, axis);
        }
        let levelled = robot(&wheels, "0 0 0");
        let (lean_rad, apart_m) = off(&levelled);
        assert!(
            lean_rad < EXACT && apart_m < EXACT,
            "{rpy}: {lean_rad} {apart_m}"
        );
        assert!(
            said(&levelled).is_some_and(|text| text.matches("leans by").count() == 3
                && text.contains(", and 1 more. Otherwise")),
            "{rpy}"
        );
        for (wheel, as_meant) in levelled.wheels.iter().zip(&robot(&exact(), "0 0 0").wheels) {
            assert!((wheel.position_m() - as_meant.position_m()).norm() < EXACT);
            assert!((wheel.axis() - as_meant.axis()).norm() < EXACT);
            // The rollers have turned along with their hub.
            let off = wheel
                .body_from_hub
                .rotation
                .angle_to(&as_meant.body_from_hub.rotation);
            assert!(off < 1e-7, "{rpy}: {off}");
        }
    }
}

/// A camber of half a degree, an axle a tenth of a millimetre lower, and a worn wheel on an axle of
/// the same height are no rounding.
#[test]
fn what_is_meant_stays() {
    let mut cambered = exact();
    for (wheel, axis) in cambered
        .iter_mut()
        .zip(["0 1 0.0087", "0 1 -0.0087"].iter().cycle())
    {
        wheel.axis = axis;
    }
    let mut low = exact();
    low[1].at_m[2] -= 1e-4;
    let mut worn = exact();
    worn[3].radius_m -= 2e-5;
    for (wheels, lean_rad, apart_m) in [
        (&cambered, 0.0087, 0.0),
        (&low, 0.0, 1e-4),
        (&worn, 0.0, 2e-5),
    ] {
        let stays = robot(wheels, "0 0 0");
        let (found_rad, found_m) = off(&stays);
        assert!((found_rad - lean_rad).abs() < 1e-6 && (found_m - apart_m).abs() < 1e-12);
        assert_eq!(said(&stays), None);
    }
}

/// An inexact quarter turn in a base joint tilts the whole robot: axes and lowest points stay in
/// one plane.
#[test]
fn a_robot_that_leans_as_a_whole_stays_in_its_plane() {
    let leans_rad = 0.0008_f64;
    let leaning = robot(&exact(), "0.0008 0 0");
    assert_eq!(said(&leaning), None);
    let (lean_rad, apart_m) = off(&leaning);
    assert!((lean_rad - leans_rad.sin()).abs() < 1e-12);
    assert!((apart_m - 2.0 * 0.076 * leans_rad.sin()).abs() < 1e-9);
    // One axle that is 6 um too low in it is moved into that plane.
    let mut wheels = exact();
    wheels[2].at_m[2] -= 6e-6;
    let levelled = robot(&wheels, "0.0008 0 0");
    let pose = levelled.standing_pose().unwrap();
    // The plane is that of three wheels: with the low one among them it is tilted by 6 um over
    // 152 mm, 0.04 mrad.
    assert!(
        (pose.roll_rad.abs() - leans_rad).abs() < 5e-5,
        "{}",
        pose.roll_rad
    );
    let gap_m = levelled
        .wheels
        .iter()
        .map(|of| pose.gap_m(of))
        .fold(0.0, f64::max);
    // Axes tilted by 0.04 mrad against that plane were turned too, a second-order effect on the
    // height.
    assert!(gap_m < 1e-9, "{gap_m}");
}
