//! Remarks on robots that can be simulated but are implausible.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Point3};

use super::sides;
use crate::model::{Remark, Robot, Wheel};

/// Adds remarks on implausible properties of a robot.
pub(super) fn remark(robot: &Robot, remarks: &mut Vec<Remark>) {
    remark_small_gamma(robot, remarks);
    sides::remark(&robot.wheels, remarks);
    remark_overlap(robot, remarks);
}

/// Adds a remark if an angle gamma looks like radians in place of degrees.
fn remark_small_gamma(robot: &Robot, remarks: &mut Vec<Remark>) {
    /// Smaller angles mean an omni wheel whose rollers are not quite straight.
    const LEAST_DEG: f64 = 0.1;
    /// A quarter of a turn in radians.
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

/// Adds a remark if two wheels overlap.
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

/// Returns half of a wheel's width, as occupied by its rollers, in metres.
fn half_width_m(wheel: &Wheel) -> f64 {
    let of_roller = wheel.rollers.iter().map(|roller| {
        let along_m = 0.5 * roller.length_m * roller.axis_in_hub.z.abs();
        let thick_m = if roller.is_tyre() {
            0.0
        } else {
            roller.radius_m
        };
        roller.row_offset_m().abs() + along_m.max(thick_m)
    });
    of_roller.fold(0.0, f64::max)
}

/// Whether a wheel reaches into another, seen as discs.
fn reaches_into(wheel: &Wheel, other: &Wheel) -> bool {
    /// Number of points on a circle.
    const PLACES: u32 = 72;
    /// Circles, as shares of the radius: rims of equal wheels may meet in points of both.
    const CIRCLES: [f64; 3] = [1.0, 0.75, 0.5];
    /// Tolerated overlap of adjacent wheels, due to rounding.
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
