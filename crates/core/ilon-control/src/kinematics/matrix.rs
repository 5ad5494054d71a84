//! The rows of the matrix M, Indiveri 2009, eq. (8).

use crate::kinematics::tyres::Mount;
use ilon_robot::{Twist, Wheel};
use nalgebra::{MatrixXx3, RowVector3, Vector2, Vector3};

/// Row of M for a wheel about a reference point, eq. (8): -(n_gx, n_gy, b . u_g).
pub(crate) fn row_of_m(wheel: &Wheel, reference_point_m: Vector2<f64>) -> RowVector3<f64> {
    let b = wheel.position_m().xy() - reference_point_m;
    let (n_g, u_g) = (wheel.roller_axis(), wheel.roller_rolling_direction());
    -RowVector3::new(n_g.x, n_g.y, b.dot(&u_g))
}

/// The rows of M of wheels about a reference point. A caster's wheel says nothing of the motion:
/// its row is zero.
pub(crate) fn rows_of_m(
    wheels: &[Wheel],
    mounts: &[Mount],
    reference_point_m: Vector2<f64>,
) -> Vec<RowVector3<f64>> {
    let row = |(wheel, mount): (&Wheel, &Mount)| match mount {
        Mount::Swivels => RowVector3::zeros(),
        _ => row_of_m(wheel, reference_point_m),
    };
    wheels.iter().zip(mounts).map(row).collect()
}

/// out = matrix * twist, row by row.
pub(crate) fn multiply(matrix: &MatrixXx3<f64>, twist: Twist, out: &mut [f64]) {
    for (row, out) in matrix.row_iter().zip(out) {
        *out = row[0] * twist.vx_m_s + row[1] * twist.vy_m_s + row[2] * twist.omega_rad_s;
    }
}

/// The components (v_x, v_y, omega) of a twist.
pub(crate) fn vector_of(twist: Twist) -> Vector3<f64> {
    Vector3::new(twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s)
}

/// The twist of components (v_x, v_y, omega).
pub(crate) fn twist_of(vector: Vector3<f64>) -> Twist {
    Twist::new(vector.x, vector.y, vector.z)
}
