//! Corrects wheels that are level except for rounded numbers in their file.
//!
//! `rpy="1.57 0 0"` instead of a quarter turn tilts an axis by 0.8 mrad, and CAD exports put one of
//! four axles some micrometres lower than the others. Hard rollers on hard ground deflect by a
//! third of a micrometre: so rigid a robot would rock on two of its wheels, and the rounding would
//! decide which of them slip. Any real frame and any real roller deflect by more.

use nalgebra::{Unit, Vector3};

use super::hub::hub_frame_towards;
use crate::error::and_more;
use crate::model::{Remark, Robot, Wheel};

/// Axes within this angle count as level: pi/2 written as 1.57 is off by 0.8 mrad, pi written as
/// 3.14 by 1.6 mrad, and an axis rotated by both by 2.4 mrad. An intended camber is larger: a
/// quarter of a degree is 4.4 mrad.
const ROUNDED_RAD: f64 = 2.5e-3;
/// Wheels whose lowest points differ in height by at most this count as equally low, in metres:
/// numbers in tenths of a millimetre are off by half of one.
const ROUNDED_M: f64 = 5e-5;
/// The same as a share of a wheel's radius, for small robots.
const ROUNDED_SHARE: f64 = 1e-3;
/// Most deviations that the remark names.
const MOST_SAID: usize = 3;
/// Smaller deviations count as exact, in radians and metres: far below a contact's deflection.
const EXACT: f64 = 1e-9;

/// Returns the largest height difference of the lowest points of wheels meant to be equally low, in
/// metres.
fn rounded_m(wheels: &[Wheel]) -> f64 {
    let radii_m = wheels.iter().map(|wheel| wheel.radius_m);
    ROUNDED_M.min(ROUNDED_SHARE * radii_m.fold(f64::INFINITY, f64::min))
}

/// Makes axes level and wheels equally high if they deviate only by rounding, and returns a remark
/// with the amounts. Wheels turn about their middles and take their rollers along.
pub(super) fn level(robot: &mut Robot) -> Option<Remark> {
    let up = common_ground(robot);
    let (mut said, mut more) = (Vec::new(), 0);
    let mut say = |words: String| match said.len() {
        ..MOST_SAID => said.push(words),
        _ => more += 1,
    };
    for wheel in &mut robot.wheels {
        let lean_rad = turn_level(wheel, &up);
        if lean_rad > EXACT {
            say(format!(
                "the axis of `{}` leans by {:.4} deg",
                wheel.name,
                lean_rad.to_degrees()
            ));
        }
    }
    for (wheel, above_m) in bring_to_one_height(robot, &up) {
        say(format!(
            "`{}` ends {:.4} mm {} than most",
            robot.wheels[wheel].name,
            1e3 * above_m.abs(),
            if above_m > 0.0 { "higher" } else { "lower" }
        ));
    }
    (!said.is_empty()).then(|| {
        Remark::new(
            "the wheels",
            format!(
                "taken as level, because rounding explains what is off: {}{}. Otherwise the simulated robot, which is rigid, would rock on some of its wheels; \
                 no real frame does",
                said.join(", "),
                and_more(said.len() + more, MOST_SAID, ",")
            ),
        )
    })
}

/// Returns the normal of the wheels' ground: the body's own z, unless the whole robot leans, with
/// its axes.
fn common_ground(robot: &Robot) -> Unit<Vector3<f64>> {
    let z = Vector3::z_axis();
    if spread(&bottoms_m(robot, &z)) <= rounded_m(&robot.wheels) {
        return z;
    }
    let Some(pose) = robot.standing_pose() else {
        return z;
    };
    let up = pose.up_in_body();
    if most_lean_rad(robot, &up) < most_lean_rad(robot, &z) {
        up
    } else {
        z
    }
}

/// Returns the angle of a hub axis from the ground, in radians.
fn lean_rad(wheel: &Wheel, up: &Unit<Vector3<f64>>) -> f64 {
    let axis = wheel.body_from_hub.rotation * Vector3::z();
    libm::asin(axis.dot(up).clamp(-1.0, 1.0)).abs()
}

fn most_lean_rad(robot: &Robot, up: &Unit<Vector3<f64>>) -> f64 {
    let leans_rad = robot.wheels.iter().map(|wheel| lean_rad(wheel, up));
    leans_rad.fold(0.0, f64::max)
}

/// Returns the height of the lowest point of each wheel in the body's frame, in metres, with its
/// axis level.
fn bottoms_m(robot: &Robot, up: &Unit<Vector3<f64>>) -> Vec<f64> {
    let wheels = robot.wheels.iter();
    wheels
        .map(|wheel| wheel.position_m().dot(up) - wheel.radius_m)
        .collect()
}

/// Returns the range of some numbers.
fn spread(of: &[f64]) -> f64 {
    let most = of.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most - of.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Makes a wheel level about its middle if it leans only by rounding; returns the angle, in
/// radians.
fn turn_level(wheel: &mut Wheel, up: &Unit<Vector3<f64>>) -> f64 {
    let lean_rad = lean_rad(wheel, up);
    if !(EXACT..=ROUNDED_RAD).contains(&lean_rad) {
        return 0.0;
    }
    let [down, axis] = [Vector3::x(), Vector3::z()].map(|of| wheel.body_from_hub.rotation * of);
    let level = Unit::new_normalize(axis - axis.dot(up) * up.into_inner());
    wheel.body_from_hub = hub_frame_towards(&wheel.position_m(), &level, &down);
    lean_rad
}

/// Moves redundant wheels to the height of most of them if their axles are level and differ in
/// height only by rounding; returns the moves, in metres. Wheels of different radius on axles of
/// equal height are intended: they stay.
fn bring_to_one_height(robot: &mut Robot, up: &Unit<Vector3<f64>>) -> Vec<(usize, f64)> {
    let bottoms_m = bottoms_m(robot, up);
    let axles_m = robot.wheels.iter().map(|wheel| wheel.position_m().dot(up));
    let are_apart = spread(&axles_m.collect::<Vec<f64>>()) > EXACT;
    let is_rounding = spread(&bottoms_m) <= rounded_m(&robot.wheels);
    let are_level = most_lean_rad(robot, up) < EXACT;
    if !(robot.has_wheels_to_spare() && are_level && are_apart && is_rounding) {
        return Vec::new();
    }
    let mut sorted_m = bottoms_m.clone();
    sorted_m.sort_by(f64::total_cmp);
    let most_m = sorted_m[sorted_m.len() / 2];
    let mut moved = Vec::new();
    for (index, (wheel, bottom_m)) in robot.wheels.iter_mut().zip(bottoms_m).enumerate() {
        let above_m = bottom_m - most_m;
        if above_m.abs() > EXACT {
            wheel.body_from_hub.translation.vector -= above_m * up.into_inner();
            moved.push((index, above_m));
        }
    }
    moved
}
