//! Analysis of a wheel arrangement: rank, condition and decoupling.

use ilon_robot::{Robot, Wheel};
use nalgebra::{Matrix2, MatrixXx3, Vector2};

use crate::kinematics::singularity::{
    RANK_TOLERANCE, all_rows, scaled, singular_values, singularity_of,
};
use crate::kinematics::tyres::{HeldRow, Mount, held_rows, mounts, named_rows};
use crate::{ControlError, Kinematics, Singularity};

/// Properties of any robot's M of eq. (8), singular or not. Rank, condition and singular values
/// count the rows that tyres hold as rows of M.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrangement {
    /// M of eq. (8) about the origin of the body frame.
    pub m: MatrixXx3<f64>,
    /// Its singular values, falling. The last column is in metres and the others have no unit, so
    /// they depend on the unit of length; for comparisons take [`Self::condition`].
    pub singular_values: [f64; 3],
    /// The ratio of the largest to the smallest singular value of M with its last column divided by
    /// the distance of the furthest wheel from the wheels' middle, taken about that middle: free of
    /// units and of the choice of frame. Infinite where the rank is below 3.
    pub condition: f64,
    /// The rank of M: 3 by condition c.2 of Lemma 1, or less. A singular value below 1e-4 of the
    /// largest counts as zero.
    pub rank: usize,
    /// The rows that tyres add; none on rollers.
    pub held: Vec<HeldRow>,
    /// The dimension of the twists that the wheels can drive, once steered ones have turned to
    /// them: 3 less the rank of the rows of unsteered tyres.
    pub reachable: usize,
    /// The cause of a rank below 3.
    pub singularity: Option<Singularity>,
}

impl Arrangement {
    /// The arrangement of a robot's wheels.
    ///
    /// # Errors
    /// [`ControlError::TooFewWheels`].
    pub fn of(robot: &Robot) -> Result<Self, ControlError> {
        let wheels = &robot.wheels;
        let count = wheels.len();
        let mounts = mounts(robot);
        let all = all_rows((wheels, &mounts), Vector2::zeros());
        if all.nrows() < 3 {
            return Err(ControlError::TooFewWheels { count });
        }
        let m = MatrixXx3::from(all.rows(0, count));
        let sum: Vector2<f64> = wheels.iter().map(|w| w.position_m().xy()).sum();
        let mean_m = sum / count as f64;
        let (about_mean, _) = scaled(&all_rows((wheels, &mounts), mean_m), wheels, mean_m);
        let s = singular_values(&about_mean).map(|(s, _)| s);
        let rank = rank_of(&about_mean);
        let each = wheels.iter().zip(mounts.iter().copied());
        let excluded = held_rows(each.filter(|(_, mount)| *mount == Mount::Fixed), mean_m);
        let lost = match &excluded[..] {
            [] => 0,
            rows => rank_of(&scaled(&MatrixXx3::from_rows(rows), wheels, mean_m).0),
        };
        Ok(Self {
            held: named_rows(robot),
            reachable: rank.saturating_sub(lost),
            singular_values: singular_values(&all).map(|(s, _)| s),
            condition: if rank == 3 {
                s[0] / s[2]
            } else {
                f64::INFINITY
            },
            rank,
            singularity: singularity_of(wheels, &mounts),
            m,
        })
    }
}

/// The number of singular values above the tolerance.
fn rank_of(m: &MatrixXx3<f64>) -> usize {
    // The decomposition needs three rows: zeros add nothing.
    let rows = m.nrows().max(3);
    let s = singular_values(&m.clone().resize_vertically(rows, 0.0)).map(|(s, _)| s);
    let counts = |value: &&f64| **value > RANK_TOLERANCE * s[0];
    s.iter().filter(counts).count()
}

impl Kinematics {
    /// Returns the reference point for a robot on tyres, which hold it about another point.
    /// Otherwise returns the point d of the body about which M_a is orthogonal to span(M_l), in the
    /// body frame, in metres. It exists and is unique for every robot that meets Lemma 1.
    ///
    /// About d a row of M_a is -(b - d) . u_g. M_l^T M_a = sum n_g ((b - d) . u_g) = 0 means (sum
    /// n_g u_g^T) d = sum n_g (b . u_g). Since u_g = n_g x k is n_g turned by a quarter, the matrix
    /// is (sum n_g n_g^T) times a rotation: regular exactly if the roller axes are not all
    /// parallel.
    ///
    /// The paper derives from this orthogonality that linear and angular commands do not disturb
    /// each other, but that holds about any point (rank 3 is enough). What d adds is that they do
    /// not compete in a least-squares sense: rates that no motion fits, from slip or clipping,
    /// split into both without crosstalk.
    pub fn decoupling_point_m(&self) -> Vector2<f64> {
        if !self.held_rows().is_empty() {
            return self.reference_point_m();
        }
        let (mut left, mut right) = (Matrix2::zeros(), Vector2::zeros());
        for w in self.wheels() {
            let (n_g, u_g) = (w.roller_axis(), w.roller_rolling_direction());
            left += n_g * u_g.transpose();
            right += n_g * w.position_m().xy().dot(&u_g);
        }
        // Regular, because Lemma 1 was checked: parallel axes are rejected.
        left.try_inverse()
            .map_or(self.reference_point_m(), |inverse| inverse * right)
    }

    /// Whether M_a is orthogonal to span(M_l) about the reference point of this kinematics: the
    /// paper's assumption. A reference point within 1e-4 of the robot's size from
    /// [`Self::decoupling_point_m`] counts, because files hold rounded numbers.
    pub fn is_decoupled(&self) -> bool {
        let d = self.decoupling_point_m();
        let far = |w: &Wheel| (w.position_m().xy() - d).norm();
        let size_m = self.wheels().iter().map(far).fold(0.0, f64::max);
        (self.reference_point_m() - d).norm() <= RANK_TOLERANCE * size_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    use crate::tests::robots::{mecanum4, mecanum4_specs, robot, six_wheels, volksbot};

    #[test]
    fn the_decoupling_point_decouples_and_no_other_does() {
        let mut specs = mecanum4_specs(-1.0);
        specs.truncate(3);
        for kinematics in [
            Kinematics::new(&six_wheels()).unwrap(),
            Kinematics::new(&robot(10.0, &specs)).unwrap(),
        ] {
            let d = kinematics.decoupling_point_m();
            let crosstalk = |about: Vector2<f64>| {
                let there = kinematics.about(about).unwrap();
                let m = there.m();
                (m.columns(0, 2).transpose() * m.column(2)).norm()
            };
            assert!(crosstalk(d) < 1e-14);
            assert!(kinematics.about(d).unwrap().is_decoupled());
            for off in [Vector2::new(0.01, 0.0), Vector2::new(0.0, 0.01)] {
                assert!(crosstalk(d + off) > 1e-3);
                assert!(!kinematics.about(d + off).unwrap().is_decoupled());
            }
        }
    }

    #[test]
    fn the_symmetric_robots_are_decoupled_about_their_middle() {
        for robot in [mecanum4(), volksbot()] {
            let kinematics = Kinematics::new(&robot).unwrap();
            assert!(kinematics.decoupling_point_m().norm() < 1e-14);
            assert!(kinematics.is_decoupled());
        }
    }

    #[test]
    fn condition_is_free_of_units_and_frame() {
        let here = Arrangement::of(&six_wheels()).unwrap();
        let mut larger = six_wheels();
        for wheel in &mut larger.wheels {
            let at = &mut wheel.body_from_hub.translation.vector;
            *at = *at * 7.0 + Vector3::new(3.0, -1.0, 0.0);
        }
        let there = Arrangement::of(&larger).unwrap();
        assert_eq!((here.rank, there.rank), (3, 3));
        assert!((here.condition / there.condition - 1.0).abs() < 1e-10);
        assert!(there.singularity.is_none());
    }

    #[test]
    fn singular_arrangements_are_described_as_well() {
        let mut specs = mecanum4_specs(1.0);
        for spec in &mut specs {
            (spec.x_m, spec.y_m) = (0.2 * spec.x_m.signum(), 0.2 * spec.y_m.signum());
        }
        let found = Arrangement::of(&robot(10.0, &specs)).unwrap();
        assert_eq!(found.rank, 2);
        assert_eq!(found.condition, f64::INFINITY);
        assert!(found.singularity.is_some() && found.singular_values[2] < 1e-15);
    }

    /// The rows are (1, +-1, +-(a + b)) times the same number, with rotation counted in the hubs'
    /// distance hypot(a, b) from the middle: the columns are orthogonal, and the condition is the
    /// ratio of their lengths.
    #[test]
    fn the_condition_of_a_mecanum_robot_is_known_in_closed_form() {
        let robot = mecanum4();
        let at = robot.wheels[0].position_m();
        let (a, b) = (at.x.abs(), at.y.abs());
        let found = Arrangement::of(&robot).unwrap();
        let expected = (a + b) / a.hypot(b);
        assert!(
            (found.condition - expected).abs() < 1e-12,
            "{}",
            found.condition
        );
    }
}
