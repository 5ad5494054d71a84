//! The transformation from the body frame to the page, and shared constants of the drawing.

use ilon_trace::{Header, WheelHeader};
use nalgebra::Vector2;

/// The picture's width and height, in pixels.
pub(super) const SIZE_PX: Vector2<f64> = Vector2::new(900.0, 720.0);
/// The centre of the robot's area, and half its size, in pixels.
pub(super) const MIDDLE_PX: Vector2<f64> = Vector2::new(450.0, 318.0);
pub(super) const HALF_ROOM_PX: Vector2<f64> = Vector2::new(300.0, 190.0);

pub(super) const INK: &str = "#222222";
pub(super) const GREY: &str = "#666666";
pub(super) const CHASSIS: &str = "#e6e6e6";
/// Blue: the vectors b_h.
pub(super) const B_H: &str = "#0072B2";
/// Vermilion: the rollers' axes.
pub(super) const ROLLER: &str = "#D55E00";
/// Bluish green: the decoupling point.
pub(super) const DECOUPLED: &str = "#009E73";

/// The transformation from the body frame to the picture.
pub(super) struct Map {
    pub(super) px_per_m: f64,
    pub(super) middle_m: Vector2<f64>,
}

impl Map {
    /// Returns the largest scale at which the whole robot fits.
    pub(super) fn of(header: &Header, decoupling_point_m: Option<Vector2<f64>>) -> Self {
        let outlines = header.chassis_outlines_m.iter().flatten();
        let points_m = outlines
            .map(|&p| Vector2::from(p))
            .chain(header.wheels.iter().flat_map(corners_m))
            .chain([Vector2::zeros()])
            .chain(decoupling_point_m);
        let (mut low_m, mut high_m) = (Vector2::zeros(), Vector2::zeros());
        for p in points_m {
            low_m = low_m.inf(&p);
            high_m = high_m.sup(&p);
        }
        // A robot without extent still needs a finite scale.
        let half_m = (0.5 * (high_m - low_m)).map(|x: f64| x.max(1e-6));
        Self {
            px_per_m: HALF_ROOM_PX.component_div(&half_m).min(),
            middle_m: 0.5 * (low_m + high_m),
        }
    }

    pub(super) fn px(&self, point_m: Vector2<f64>) -> Vector2<f64> {
        MIDDLE_PX + self.px_per_m * on_page(point_m - self.middle_m)
    }

    /// Returns points in the format of a polygon.
    pub(super) fn points(&self, points_m: impl IntoIterator<Item = Vector2<f64>>) -> String {
        let pairs = points_m.into_iter().map(|point_m| {
            let [x, y] = self.px(point_m).into();
            format!("{x:.1},{y:.1}")
        });
        pairs.collect::<Vec<_>>().join(" ")
    }
}

/// Returns a direction of the body frame on the page, whose y points down.
pub(super) fn on_page(vector: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(vector.x, -vector.y)
}

/// Rounds to a tenth, the precision of the picture.
pub(super) fn tenth(x: f64) -> f64 {
    (10.0 * x).round() / 10.0
}

pub(super) fn at(point: Vector2<f64>) -> (f64, f64) {
    (tenth(point.x), tenth(point.y))
}

/// Removes the control characters that XML does not allow from a name.
pub(super) fn printable(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).collect()
}

/// Returns u = n x k, the direction in which a positive rate drives the hub.
pub(super) fn driving_direction(wheel: &WheelHeader) -> Vector2<f64> {
    Vector2::new(wheel.axis[1], -wheel.axis[0])
}

pub(super) fn corners_m(wheel: &WheelHeader) -> [Vector2<f64>; 4] {
    let b = Vector2::from(wheel.position_m);
    let across = 0.5 * wheel.width_m * Vector2::from(wheel.axis);
    let along = wheel.radius_m * driving_direction(wheel);
    [
        b + along + across,
        b - along + across,
        b - along - across,
        b + along - across,
    ]
}
