//! Lemma 1, condition c.2: the geometry of rank M < 3.
//!
//! A row of M, eq. (8), is -(n_gx, n_gy, b . u_g). The line through the wheel's centre **b** along
//! its roller axis **n_g** has the direction n_g and the moment **b** x **n_g** = b_x n_gy - b_y
//! n_gx = **b** . **u_g** about the reference point (because u_g = n_g x k = (n_gy, -n_gx)). So a
//! row of M is, up to its sign, the pair (direction, moment) of that line: its Pluecker coordinates
//! in the plane.
//!
//! M (v, omega) = 0 for some motion that is not zero means that no wheel resists it. If omega is
//! not zero the motion is a turn about the point c where v + omega k x c = 0. Then n_g . (v + omega
//! k x b) = omega n_g . (k x (b - c)) = 0 says that b - c is along n_g: every line passes through
//! c. If omega = 0, n_g . v = 0 for every wheel says that all lines are parallel. Both arguments
//! run backwards as well. Hence **rank M < 3 exactly when all roller axes, prolonged, meet in one
//! point or are all parallel**, and rank M = 1 when they all lie on one line.

use std::fmt;

use ilon_robot::Wheel;
use nalgebra::{MatrixXx3, Vector2, Vector3};

use crate::kinematics::matrix::rows_of_m;
use crate::kinematics::tyres::{Mount, held_rows};

/// Singular values below this share of the largest count as zero.
///
/// A robot's file often holds angles to four digits (0.7854), which turns an exactly singular
/// arrangement into one with a smallest singular value near 1e-5; and with a condition worse than
/// 1e4 a slip of 0.1 mm/s at a wheel would become 1 m/s of the body. Neither can be driven.
pub(crate) const RANK_TOLERANCE: f64 = 1e-4;

/// The cause of a rank of M below 3.
#[derive(Clone, Debug, PartialEq)]
pub struct Singularity {
    /// The geometry of the roller axes.
    pub kind: SingularityKind,
    /// The wheels whose roller axes have that geometry: all of the robot's.
    pub wheels: Vec<String>,
    /// Single wheels whose reversed handedness (the sign of gamma) gives M the rank 3.
    pub repaired_by_reversing: Vec<String>,
    /// Whether reversing the handedness of every wheel gives M the rank 3: the wheels were mounted
    /// on the wrong sides.
    pub repaired_by_reversing_all: bool,
    /// Whether these wheels roll on tyres: their ways meet, not the axes of rollers.
    pub on_tyres: bool,
}

/// The geometry behind a rank below 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SingularityKind {
    /// All roller axes meet in one point: nothing resists a rotation about it.
    Meet {
        /// The point in the body frame, in metres.
        point_m: Vector2<f64>,
    },
    /// All roller axes are parallel: nothing resists a translation across them.
    Parallel {
        /// Their direction in the body frame, a unit vector.
        direction: Vector2<f64>,
    },
    /// All roller axes lie on one line: nothing resists either motion (rank 1).
    OneLine {
        /// The line's direction in the body frame, a unit vector.
        direction: Vector2<f64>,
    },
}

impl fmt::Display for Singularity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = quoted(&self.wheels);
        if let (SingularityKind::Meet { point_m }, true) = (self.kind, self.on_tyres) {
            return write!(
                f,
                "the ways of all wheels pass through {}: none of them turns the robot about it; wheels {names}; \
                 move a wheel to the side",
                place(point_m)
            );
        }
        match self.kind {
            SingularityKind::Meet { point_m } => write!(
                f,
                "all roller axes meet at {}: the robot cannot control its rotation about it; wheels {names}",
                place(point_m)
            )?,
            SingularityKind::Parallel { direction } => write!(
                f,
                "all roller axes are parallel, along {:.1} deg: the robot cannot control its motion across them; \
                 wheels {names}",
                libm::atan2(direction.y, direction.x).to_degrees()
            )?,
            SingularityKind::OneLine { direction } => write!(
                f,
                "all roller axes lie on one line, along {:.1} deg: the robot controls only its motion along it; \
                 wheels {names}",
                libm::atan2(direction.y, direction.x).to_degrees()
            )?,
        }
        if self.repaired_by_reversing_all {
            write!(
                f,
                "; the wheels are probably on the wrong sides: reversing the handedness of all of them mends it"
            )
        } else if self.repaired_by_reversing.is_empty() {
            write!(
                f,
                "; turn or move a wheel so that its roller axis leaves the others'"
            )
        } else {
            write!(
                f,
                "; reversing the handedness of one of {} mends it",
                quoted(&self.repaired_by_reversing)
            )
        }
    }
}

/// A place as text. Adding zero turns a negative zero into a positive one.
fn place(point_m: Vector2<f64>) -> String {
    let [x, y] = [point_m.x, point_m.y].map(|x_m| (x_m * 1e4).round() / 1e4 + 0.0);
    format!("({x:.4}, {y:.4}) m")
}

/// Returns M with its last column divided by a length typical of the robot, so that its singular
/// values can be compared, and that length in metres: the largest distance of a wheel from the
/// reference point.
pub(crate) fn scaled(
    m: &MatrixXx3<f64>,
    wheels: &[Wheel],
    point_m: Vector2<f64>,
) -> (MatrixXx3<f64>, f64) {
    let length_m = reach_m(wheels, point_m);
    let mut m = m.clone();
    m.column_mut(2).scale_mut(1.0 / length_m);
    (m, length_m)
}

/// The distance of the furthest wheel from a point, in metres; 1 if all stand there: any length
/// works then, the rank is below 3 anyway.
pub(crate) fn reach_m(wheels: &[Wheel], point_m: Vector2<f64>) -> f64 {
    let far = |w: &Wheel| (w.position_m().xy() - point_m).norm();
    let length_m = wheels.iter().map(far).fold(0.0, f64::max);
    if length_m > 0.0 { length_m } else { 1.0 }
}

/// Returns the singular values of a tall matrix of three columns in falling order with their right
/// singular vectors.
pub(crate) fn singular_values(m: &MatrixXx3<f64>) -> [(f64, Vector3<f64>); 3] {
    let svd = m.clone().svd(false, true);
    let mut found = [(0.0, Vector3::zeros()); 3];
    for (i, slot) in found.iter_mut().enumerate().take(svd.singular_values.len()) {
        let v = svd.v_t.as_ref().map(|v_t| v_t.row(i).transpose());
        *slot = (svd.singular_values[i], v.unwrap_or_default());
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found
}

/// Returns the cause of M's singularity, or `None` if it has rank 3 with the rows that tyres hold.
/// Needs three rows or more.
pub(crate) fn singularity_of(wheels: &[Wheel], mounts: &[Mount]) -> Option<Singularity> {
    let kind = kind_of(wheels, mounts)?;
    let reversed = |w: &Wheel| {
        let mut w = w.clone();
        w.gamma_rad = -w.gamma_rad;
        w
    };
    let mended = |i: usize| {
        let mut wheels = wheels.to_vec();
        wheels[i] = reversed(&wheels[i]);
        kind_of(&wheels, mounts).is_none()
    };
    let all: Vec<Wheel> = wheels.iter().map(reversed).collect();
    Some(Singularity {
        kind,
        wheels: wheels.iter().map(|w| w.name.clone()).collect(),
        repaired_by_reversing: (0..wheels.len())
            .filter(|&i| mended(i))
            .map(|i| wheels[i].name.clone())
            .collect(),
        repaired_by_reversing_all: kind_of(&all, mounts).is_none(),
        on_tyres: wheels.iter().all(Wheel::has_tyre),
    })
}

/// Returns the geometry of a rank below 3, or `None`.
fn kind_of(wheels: &[Wheel], mounts: &[Mount]) -> Option<SingularityKind> {
    // About the wheels' mean position, so that the verdict does not depend on where the body frame
    // sits.
    let sum: Vector2<f64> = wheels.iter().map(|w| w.position_m().xy()).sum();
    let mean_m = sum / wheels.len() as f64;
    let (m, length_m) = scaled(&all_rows((wheels, mounts), mean_m), wheels, mean_m);
    // Because s_1^2 s_2^2 <= (tr / 2)^2 of m^T m, (s_3 / s_1)^2 is at least this: clearly regular.
    let squares = m.tr_mul(&m);
    if 4.0 * squares.determinant() > (10.0 * RANK_TOLERANCE).powi(2) * squares.trace().powi(3) {
        return None;
    }
    let [(s_1, _), (s_2, _), (s_3, free)] = singular_values(&m);
    if s_3 > RANK_TOLERANCE * s_1 {
        return None;
    }
    let direction = wheels[0].roller_axis();
    if s_2 <= RANK_TOLERANCE * s_1 {
        return Some(SingularityKind::OneLine { direction });
    }
    // The free motion: M (v, omega) = 0, its last component scaled by the length above. If omega's
    // share is below the tolerance, the point lies beyond 1/tolerance robot sizes: no difference
    // from parallel.
    let (v, omega_length) = (free.xy(), free.z);
    if omega_length.abs() <= RANK_TOLERANCE {
        return Some(SingularityKind::Parallel { direction });
    }
    // v + omega k x c = 0, so c = k x v / omega.
    let omega = omega_length / length_m;
    let point_m = mean_m + Vector2::new(-v.y, v.x) / omega;
    Some(SingularityKind::Meet { point_m })
}

/// Returns M about a point, and below it the rows that tyres hold.
pub(crate) fn all_rows(
    (wheels, mounts): (&[Wheel], &[Mount]),
    about_m: Vector2<f64>,
) -> MatrixXx3<f64> {
    let mut rows = rows_of_m(wheels, mounts, about_m);
    let each = wheels.iter().zip(mounts.iter().copied());
    rows.extend(held_rows(each, about_m));
    MatrixXx3::from_rows(&rows)
}

/// Returns names in backquotes, separated by commas.
pub(crate) fn quoted(names: &[String]) -> String {
    let names: Vec<_> = names.iter().map(|n| format!("`{n}`")).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_that_rounds_to_zero_has_no_sign() {
        let singularity = Singularity {
            kind: SingularityKind::Meet {
                point_m: Vector2::new(-1e-6, -2e-5),
            },
            wheels: vec!["a".to_owned()],
            repaired_by_reversing: Vec::new(),
            repaired_by_reversing_all: false,
            on_tyres: false,
        };
        let words = singularity.to_string();
        assert!(words.contains("meet at (0.0000, 0.0000) m"), "{words}");
    }
}
