//! Robots that can be simulated and can hardly be meant.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Point3};

use super::sides;
use crate::model::{Remark, Robot, Wheel};

/// Says what of a robot can hardly be meant.
pub(super) fn remark(robot: &Robot, remarks: &mut Vec<Remark>) {
    remark_small_gamma(robot, remarks);
    sides::remark(&robot.wheels, remarks);
    remark_overlap(robot, remarks);
}

/// Says that an angle gamma looks like one in radians where degrees belong.
fn remark_small_gamma(robot: &Robot, remarks: &mut Vec<Remark>) {
    /// Below it an omni wheel is meant, whose rollers are not quite straight.
    const LEAST_DEG: f64 = 0.1;
    /// A quarter of a turn, had it been given in radians.
    const MOST_DEG: f64 = 1.58;
    let is_odd =
        |wheel: &&Wheel| (LEAST_DEG..MOST_DEG).contains(&wheel.gamma_rad.to_degrees().abs());
    if let Some(wheel) = robot.wheels.iter().find(is_odd) {
        let gamma_deg = wheel.gamma_rad.to_degrees();
        remarks.push(Remark::new(
            format!("wheel `{}`", wheel.name),
            format!(
                "its rollers stand {gamma_deg:.3} deg from those of an omni wheel, which is next to nothing: was an angle of \
                 {:.0} deg given in radians?",
                gamma_deg.to_degrees()
            ),
        ));
    }
}

/// Says that two wheels are in each other's way.
fn remark_overlap(robot: &Robot, remarks: &mut Vec<Remark>) {
    let wheels = &robot.wheels;
    let pairs = (0..wheels.len()).flat_map(|a| (0..wheels.len()).map(move |b| (a, b)));
    let meets = |&(a, b): &(usize, usize)| a != b && reaches_into(&wheels[a], &wheels[b]);
    if let Some((a, b)) = pairs.into_iter().find(meets) {
        remarks.push(Remark::new(
            format!("wheel `{}`", wheels[a].name),
            format!(
                "it reaches into wheel `{}`: nothing keeps wheels of one robot apart, so they pass through each other",
                wheels[b].name
            ),
        ));
    }
}

/// Half of a wheel's width as its rollers take it up, in metres.
fn half_width_m(wheel: &Wheel) -> f64 {
    let of_roller = wheel.rollers.iter().map(|roller| {
        let along = roller.axis_in_hub.z.abs();
        roller.row_offset_m().abs() + (0.5 * roller.length_m * along).max(roller.radius_m)
    });
    of_roller.fold(0.0, f64::max)
}

/// Whether a wheel reaches into another, seen as discs.
fn reaches_into(wheel: &Wheel, other: &Wheel) -> bool {
    /// Places around a circle.
    const PLACES: u32 = 72;
    /// Circles, as shares of the radius: rims of wheels alike may meet in points of both.
    const CIRCLES: [f64; 3] = [1.0, 0.75, 0.5];
    /// What wheels side by side may share by rounding.
    const MARGIN_M: f64 = 1e-6;
    let between_m = (wheel.position_m() - other.position_m()).norm();
    let (own_m, other_m) = (half_width_m(wheel), half_width_m(other));
    if between_m > wheel.radius_m.hypot(own_m) + other.radius_m.hypot(other_m) {
        return false;
    }
    let other_from_wheel: Isometry3<f64> = other.body_from_hub.inverse() * wheel.body_from_hub;
    (0..PLACES).any(|place| {
        let (sin, cos) = libm::sincos(TAU * f64::from(place) / f64::from(PLACES));
        let places = CIRCLES.iter().flat_map(|share| {
            let radius_m = share * wheel.radius_m;
            [-own_m, 0.0, own_m].map(|along_m| Point3::new(radius_m * cos, radius_m * sin, along_m))
        });
        places.map(|place| other_from_wheel * place).any(|seen| {
            seen.z.abs() < other_m - MARGIN_M && seen.coords.xy().norm() < other.radius_m - MARGIN_M
        })
    })
}
