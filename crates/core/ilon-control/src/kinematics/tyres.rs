//! What wheels with tyres add to the kinematics: they do not move sideways.
//!
//! A tyre rolls along **u** as a Swedish wheel of gamma = 0 does, so that its row of eq. (7) is the
//! same: u . v_h = rho q'. It has no rollers, and holds its hub along the hub axis besides: n . v_h
//! = 0. These rows have no motor. Twists that they exclude cannot be driven (nonholonomic); with
//! the driven rows they determine the twist of given wheel rates (odometry).
//!
//! **Skid steering.** Tyres on parallel axles that do not lie on one line contradict each other in
//! every turn: some of them slide. The rows of parallel axles are therefore taken together as their
//! mean, the row of a wheel in their middle: a robot of two axles is expected to turn about the
//! middle of both. By how much less it turns, its contacts decide.

use ilon_robot::Wheel;
use nalgebra::{RowVector3, Vector2};

/// Axes count as parallel within this sine of the angle between them: files hold rounded angles.
const PARALLEL: f64 = 1e-3;

/// Returns the rows n . v_h = 0 of the tyres about a reference point, one for each direction of
/// axles, as functions of (v_x, v_y, omega); none for a robot on rollers.
pub(crate) fn held_rows<'w>(
    wheels: impl Iterator<Item = &'w Wheel>,
    reference_point_m: Vector2<f64>,
) -> Vec<RowVector3<f64>> {
    let mut groups: Vec<(Vector2<f64>, Vec<Vector2<f64>>)> = Vec::new();
    for wheel in wheels.filter(|wheel| wheel.has_tyre()) {
        let (n, b) = (wheel.axis(), wheel.position_m().xy() - reference_point_m);
        let parallel = |axis: &Vector2<f64>| axis.perp(&n).abs() < PARALLEL;
        match groups.iter_mut().find(|(axis, _)| parallel(axis)) {
            Some((_, places_m)) => places_m.push(b),
            None => groups.push((n, vec![b])),
        }
    }
    let row = |(n, places_m): &(Vector2<f64>, Vec<Vector2<f64>>)| {
        let sum: Vector2<f64> = places_m.iter().sum();
        let b = sum / places_m.len() as f64;
        RowVector3::new(n.x, n.y, b.perp(n))
    };
    groups.iter().map(row).collect()
}
