//! Wheels that are level but for the rounding of their file's numbers.
//!
//! `rpy="1.57 0 0"` in place of a quarter turn lets an axis lean by 0.8 mrad, and CAD exports put one of four axles some micrometres lower than the
//! others. Hard rollers on hard ground give way by a third of a micrometre: so rigid a robot would rock on two of its wheels, and the rounding would
//! decide which of them slip. Any real frame and any real roller give way by more.

use nalgebra::{Unit, Vector3};

use super::hub::hub_frame_towards;
use crate::model::{Remark, Robot, Wheel};

/// Axes that lean by no more than this are level: pi/2 written as 1.57 is off by 0.8 mrad, pi written as 3.14 by 1.6 mrad, and an axis that is turned by
/// both by 2.4 mrad. A camber that somebody means is larger: a quarter of a degree is 4.4 mrad.
const ROUNDED_RAD: f64 = 2.5e-3;
/// Wheels whose lowest points lie within this height of each other reach equally low, in metres: what is written in tenths of a millimetre is off by half
/// of one.
const ROUNDED_M: f64 = 5e-5;
/// The same as a share of a wheel's radius, for small robots.
const ROUNDED_SHARE: f64 = 1e-3;
/// What is off by less is exact, in radians and metres: far below what a contact gives way by.
const EXACT: f64 = 1e-9;

/// How far apart in height the lowest points of wheels may lie that are meant to reach equally low, in metres.
fn rounded_m(wheels: &[Wheel]) -> f64 {
    let radii_m = wheels.iter().map(|wheel| wheel.radius_m);
    ROUNDED_M.min(ROUNDED_SHARE * radii_m.fold(f64::INFINITY, f64::min))
}

/// Turns axes level and brings wheels to one height that are so but for rounding, and says which and by how much. Wheels turn about their middles and take
/// their rollers along.
pub(super) fn level(robot: &mut Robot) -> Option<Remark> {
    let up = common_ground(robot);
    let mut said = Vec::new();
    for wheel in &mut robot.wheels {
        let lean_rad = turn_level(wheel, &up);
        if lean_rad > EXACT {
            said.push(format!(
                "the axis of `{}` leans by {:.4} deg",
                wheel.name,
                lean_rad.to_degrees()
            ));
        }
    }
    for (wheel, above_m) in bring_to_one_height(robot, &up) {
        said.push(format!(
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
                "taken as level, for rounded numbers explain what is off: {}. As rigid as it is simulated, the robot would rock on some of its wheels; no \
                 real frame does",
                said.join(", ")
            ),
        )
    })
}

/// The direction out of the ground on which wheels stand: the body's own z, unless the robot leans as a whole, with its axes.
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

/// How far a hub axis rises out of the ground, in radians.
fn lean_rad(wheel: &Wheel, up: &Unit<Vector3<f64>>) -> f64 {
    let axis = wheel.body_from_hub.rotation * Vector3::z();
    libm::asin(axis.dot(up).clamp(-1.0, 1.0)).abs()
}

fn most_lean_rad(robot: &Robot, up: &Unit<Vector3<f64>>) -> f64 {
    let leans_rad = robot.wheels.iter().map(|wheel| lean_rad(wheel, up));
    leans_rad.fold(0.0, f64::max)
}

/// How high the lowest point of each wheel lies in a frame of the body, in metres, its axis level.
fn bottoms_m(robot: &Robot, up: &Unit<Vector3<f64>>) -> Vec<f64> {
    let wheels = robot.wheels.iter();
    wheels
        .map(|wheel| wheel.position_m().dot(up) - wheel.radius_m)
        .collect()
}

/// The largest of some numbers less the smallest.
fn spread(of: &[f64]) -> f64 {
    let most = of.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most - of.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Turns a wheel level about its middle where it leans by no more than a rounding, and gives by how much, in radians.
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

/// Brings wheels to spare to the height of most of them where their axles are level and differ in height by no more than a rounding, and gives by how
/// much each was above it, in metres. Of wheels that stand on axles of one height and differ in radius, that is meant: they stay.
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
