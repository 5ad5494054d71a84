//! What tyres add to an inspection: the rows that hold the robot sideways, and what they leave.

use ilon_control::{Arrangement, HeldRow, Turn};
use ilon_robot::{RollerForm, Wheel};
use nalgebra::Vector2;
use serde::Serialize;

/// A tyre of a wheel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TyreInspection {
    /// Width, in metres.
    pub width_m: f64,
    /// Radius of its shoulders, in metres.
    pub shoulder_radius_m: f64,
}

impl TyreInspection {
    pub(super) fn of(wheel: &Wheel) -> Option<Self> {
        wheel.rollers.iter().find_map(|roller| match &roller.form {
            RollerForm::Tyre(solid) => Some(Self {
                width_m: roller.length_m,
                shoulder_radius_m: solid.edge_radius_m(),
            }),
            _ => None,
        })
    }
}

/// What the tyres of a robot hold.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TyresInspection {
    /// The rows that tyres add: no motion of the hub along its axle.
    pub rows: Vec<HeldInspection>,
    /// Dimension of the twists that the robot can drive, once steered wheels have turned to them.
    pub reachable_twists: usize,
    /// The twists that unsteered tyres exclude, in words; `None` if they exclude none.
    pub excluded: Option<String>,
    /// Radius of the sharpest turn of the middle of the unsteered tyres, in metres: 0 on the spot.
    /// `None` where they do not leave one direction.
    pub turning_radius_m: Option<f64>,
}

/// A row that tyres add below M.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct HeldInspection {
    /// The wheels of these tyres.
    pub wheels: Vec<String>,
    /// The row, as of M: the last column in metres.
    pub row: [f64; 3],
    /// Whether it turns with a steering joint.
    pub is_steered: bool,
    /// Largest distance between two of the axles, in metres: above 0 the tyres scrub in a turn.
    pub axles_apart_m: f64,
}

impl TyresInspection {
    /// `None` for a robot on rollers.
    pub(super) fn of(arrangement: &Arrangement, turn: Option<Turn>) -> Option<Self> {
        let rows = arrangement.held.iter().map(|held| HeldInspection {
            wheels: held.wheels.clone(),
            row: [held.row.x, held.row.y, held.row.z],
            is_steered: held.is_steered,
            axles_apart_m: held.axles_apart_m,
        });
        (!arrangement.held.is_empty()).then(|| Self {
            rows: rows.collect(),
            reachable_twists: arrangement.reachable,
            excluded: excluded(arrangement),
            turning_radius_m: turn.map(|turn| turn.radius_m),
        })
    }

    /// Whether unsteered tyres exclude twists.
    pub fn is_held(&self) -> bool {
        self.excluded.is_some()
    }

    /// The largest distance between two axles of unsteered tyres that are parallel, in metres.
    pub fn axles_apart_m(&self) -> f64 {
        let apart = self.rows.iter().map(|row| row.axles_apart_m);
        apart.fold(0.0, f64::max)
    }
}

/// What unsteered tyres exclude, in words.
fn excluded(arrangement: &Arrangement) -> Option<String> {
    let fixed = arrangement.held.iter().filter(|held| !held.is_steered);
    let fixed: Vec<&HeldRow> = fixed.collect();
    match (&fixed[..], arrangement.reachable) {
        ([], _) => None,
        (_, 0) => Some("every twist: the axles of the tyres have no common point".to_owned()),
        ([one], _) => {
            let (n, at) = (upwards(Vector2::new(one.row.x, one.row.y)), foot(one));
            Some(format!(
                "sideways, along {:.1} deg; it turns about points of the line through {} along {:.1} deg",
                libm::atan2(n.y, n.x).to_degrees(),
                place(at),
                libm::atan2(n.y, n.x).to_degrees(),
            ))
        }
        ([one, other, ..], _) => Some(match meeting(one, other) {
            Some(point) => format!("all but the turn about {}", place(point)),
            None => "all but one".to_owned(),
        }),
    }
}

/// The same direction with its angle in (-90, 90] deg.
fn upwards(n: Vector2<f64>) -> Vector2<f64> {
    match n.x < -1e-9 || (n.x <= 1e-9 && n.y < 0.0) {
        true => -n,
        false => n,
    }
}

/// The point of an axle that is nearest to the origin: n . v + m omega = 0 in m u with u = n x k.
fn foot(held: &HeldRow) -> Vector2<f64> {
    held.row.z * Vector2::new(held.row.y, -held.row.x)
}

/// Where two axles meet: the point c whose rows are zero in a turn about it, k x c . n = m.
fn meeting(one: &HeldRow, other: &HeldRow) -> Option<Vector2<f64>> {
    let across = |held: &HeldRow| Vector2::new(held.row.y, -held.row.x).transpose();
    let rows = nalgebra::Matrix2::from_rows(&[across(one), across(other)]);
    Some(rows.try_inverse()? * Vector2::new(one.row.z, other.row.z))
}

/// A place as text. Adding zero turns a negative zero into a positive one.
fn place(point_m: Vector2<f64>) -> String {
    let [x, y] = [point_m.x, point_m.y].map(|x_m| (x_m * 1e4).round() / 1e4 + 0.0);
    format!("({x:.4}, {y:.4}) m")
}

#[cfg(test)]
mod tests {
    use nalgebra::RowVector3;

    use super::*;

    /// A tyre at p whose axle points along u holds n = u: u . (v + omega k x p) = 0, that is
    /// m = u . (k x p). Axles through the point (0.3, -0.7) m turn about it.
    #[test]
    fn two_axles_meet_where_both_point() {
        let about = Vector2::new(0.3, -0.7);
        let held = |angle_rad: f64, away_m: f64| {
            let axle = Vector2::new(libm::cos(angle_rad), libm::sin(angle_rad));
            let at = about + away_m * axle;
            HeldRow {
                row: RowVector3::new(axle.x, axle.y, axle.dot(&Vector2::new(-at.y, at.x))),
                wheels: Vec::new(),
                is_steered: false,
                axles_apart_m: 0.0,
            }
        };
        let [one, other] = [held(0.4, 1.0), held(2.0, -0.5)];
        let found = meeting(&one, &other).expect("they are not parallel");
        assert!((found - about).norm() < 1e-12, "{found}");
        // The nearest point of the first axle lies square to it, and on it.
        let (nearest, axle) = (foot(&one), Vector2::new(libm::cos(0.4), libm::sin(0.4)));
        assert!(nearest.dot(&axle).abs() < 1e-12, "{nearest}");
        assert!((about - nearest).perp(&axle).abs() < 1e-12, "{nearest}");
        assert!(meeting(&one, &held(0.4, 2.0)).is_none_or(|far| far.norm() > 1e9));
    }
}
