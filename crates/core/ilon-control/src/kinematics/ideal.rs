//! The ideal kinematics of section II: eqs. (2)-(10), one constant roller angle per wheel.
//!
//! All vectors are resolved in the body frame, as in the paper ("a common body-fixed frame").
//!
//! **Different wheels.** The paper assumes identical wheels, so that rho cos(gamma) is one number.
//! Eq. (5) is derived for a single wheel and holds with that wheel's own rho_h and gamma_h.
//! Multiplying it by cos(gamma_h) gives row h of (7) with rho_h cos(gamma_h) on its right-hand
//! side: M (v_c, omega)^T = diag(rho_h cos gamma_h) q'. For identical wheels this is (7). M itself
//! needs only the roller directions.

use std::sync::Arc;

use ilon_robot::{Robot, Twist, Wheel};
use nalgebra::{Isometry3, Matrix2, Matrix3, Matrix3xX, MatrixXx3, Vector2, Vector3};

use crate::ControlError;
use crate::error::finite;
use crate::kinematics::matrix::{multiply, rows_of_m, vector_of};
use crate::kinematics::module::Module;
use crate::kinematics::singularity::{
    RANK_TOLERANCE, reach_m, scaled, singular_values, singularity_of,
};
use crate::kinematics::tyres::{Mount, ROUNDED, held_rows, mounts, toe};

/// The map between wheel rates and the motion of the robot's reference point, eqs. (7)-(10).
#[derive(Clone, Debug)]
pub struct Kinematics {
    wheels: Arc<[Wheel]>,
    reference_point_m: Vector2<f64>,
    /// M of eq. (8).
    m: MatrixXx3<f64>,
    /// rho_h cos(gamma_h) of each wheel, in metres.
    lever_m: Vec<f64>,
    /// Eq. (9): rates = rate_matrix * twist.
    rate_matrix: MatrixXx3<f64>,
    /// Least squares of eq. (7): twist = twist_matrix * rates.
    twist_matrix: Matrix3xX<f64>,
    /// Twists that tyres allow give zero in each of these rows (see `kinematics/tyres.rs`).
    held: Vec<Vector3<f64>>,
    /// How each wheel stands, and the rows of tyres that nothing turns.
    mounts: Vec<Mount>,
    excluded: Vec<Vector3<f64>>,
    /// By how much axles of the latter are off their mean, as a sine.
    toe: f64,
}

impl Kinematics {
    /// The kinematics of a robot about its body frame's origin.
    ///
    /// # Errors
    /// The conditions of Lemma 1: [`ControlError::TooFewWheels`],
    /// [`ControlError::NoControlAuthority`] (c.1), [`ControlError::Uncontrollable`] (c.2).
    pub fn new(robot: &Robot) -> Result<Self, ControlError> {
        let wheels = robot.wheels.iter().cloned().collect();
        Self::assemble((wheels, mounts(robot)), Vector2::zeros())
    }

    /// Returns the kinematics of the same robot about another reference point c, given in the body
    /// frame in metres: twists then hold the velocity of that point, and b in eq. (2) is counted
    /// from it.
    ///
    /// # Errors
    /// [`ControlError::NotFinite`] for a point that is not finite.
    pub fn about(&self, point_m: Vector2<f64>) -> Result<Self, ControlError> {
        finite("x of the reference point", point_m.x)?;
        finite("y of the reference point", point_m.y)?;
        if point_m == self.reference_point_m {
            return Ok(self.clone());
        }
        Self::assemble((Arc::clone(&self.wheels), self.mounts.clone()), point_m)
    }

    /// Returns the kinematics of the same robot with its hubs at these poses in the body frame,
    /// after joints have moved them.
    ///
    /// # Errors
    /// Like [`Self::new`].
    pub fn moved(&self, body_from_hubs: &[Isometry3<f64>]) -> Result<Self, ControlError> {
        let to = |(wheel, to): (&Wheel, &Isometry3<f64>)| Wheel {
            body_from_hub: *to,
            ..wheel.clone()
        };
        let wheels = self.wheels.iter().zip(body_from_hubs).map(to).collect();
        Self::assemble((wheels, self.mounts.clone()), self.reference_point_m)
    }

    fn assemble(
        (wheels, mounts): (Arc<[Wheel]>, Vec<Mount>),
        reference_point_m: Vector2<f64>,
    ) -> Result<Self, ControlError> {
        let count = wheels.len();
        let each = || wheels.iter().zip(mounts.iter().copied());
        let held = held_rows(each(), reference_point_m);
        let fixed = || each().filter(|(_, mount)| *mount == Mount::Fixed);
        let excluded = held_rows(fixed(), reference_point_m);
        let toe = toe(fixed());
        if count + held.len() < 3 {
            return Err(ControlError::TooFewWheels { count });
        }
        let powerless: Vec<_> = wheels
            .iter()
            .filter(|w| libm::cos(w.gamma_rad).abs() <= RANK_TOLERANCE)
            .map(|w| w.name.clone())
            .collect();
        if !powerless.is_empty() {
            return Err(ControlError::NoControlAuthority { wheels: powerless });
        }
        if let Some(singularity) = singularity_of(&wheels, &mounts) {
            return Err(ControlError::Uncontrollable { singularity });
        }

        let mut rows = rows_of_m(&wheels, &mounts, reference_point_m);
        let m = MatrixXx3::from_rows(&rows);
        let lever_m: Vec<f64> = wheels
            .iter()
            .map(|w| w.radius_m * libm::cos(w.gamma_rad))
            .collect();
        let mut rate_matrix = m.clone();
        for (mut row, lever_m) in rate_matrix.row_iter_mut().zip(&lever_m) {
            row /= *lever_m;
        }

        // M^+ = V S^-2 V^T M^T with the last column scaled to the robot's size, which changes no
        // least-squares solution of a full-rank system but keeps it well conditioned. S has no
        // zero: rank M = 3 was checked. Rows that tyres hold stand below those of M.
        rows.extend(&held);
        let all = MatrixXx3::from_rows(&rows);
        let (m_scaled, length_m) = scaled(&all, &wheels, reference_point_m);
        let mut twist_matrix = Matrix3xX::zeros(count);
        for (s, v) in singular_values(&m_scaled) {
            let u = &m_scaled * v / s;
            twist_matrix += v / s * u.rows(0, count).transpose();
        }
        twist_matrix.row_mut(2).scale_mut(1.0 / length_m);
        for (mut column, lever_m) in twist_matrix.column_iter_mut().zip(&lever_m) {
            column *= *lever_m;
        }

        Ok(Self {
            wheels,
            reference_point_m,
            m,
            lever_m,
            rate_matrix,
            twist_matrix,
            held: held.iter().map(|row| row.transpose()).collect(),
            excluded: excluded.iter().map(|row| row.transpose()).collect(),
            mounts,
            toe,
        })
    }

    /// The number N of wheels.
    pub fn wheel_count(&self) -> usize {
        self.wheels.len()
    }

    /// The wheels, in the robot's order.
    pub fn wheels(&self) -> &[Wheel] {
        &self.wheels
    }

    /// The reference point c in the body frame, in metres; twists hold its velocity.
    pub fn reference_point_m(&self) -> Vector2<f64> {
        self.reference_point_m
    }

    /// Whether its wheels can roll every twist, once those that are steered have turned to it.
    /// Tyres that are not steered cannot.
    pub fn is_omnidirectional(&self) -> bool {
        self.excluded.is_empty()
    }

    /// The module of the wheel at this index, if it rolls on a tyre that is steered, which turns to
    /// each twist.
    pub(crate) fn module(&self, wheel: usize) -> Option<Module> {
        let (of, mount) = (self.wheels.get(wheel)?, self.mounts.get(wheel)?);
        match mount {
            Mount::Steered(axis_m) if of.has_tyre() => {
                Some(Module::of(of, *axis_m, self.reference_point_m))
            }
            _ => None,
        }
    }

    /// The wheels, and how each stands.
    pub(crate) fn mounted(&self) -> impl Iterator<Item = (&Wheel, Mount)> {
        self.wheels.iter().zip(self.mounts.iter().copied())
    }

    /// The rows that tyres hold at zero as they stand, as functions of (v_x, v_y, omega).
    pub(crate) fn held_rows(&self) -> &[Vector3<f64>] {
        &self.held
    }

    /// Those of the tyres that are not steered.
    pub(crate) fn excluded_rows(&self) -> &[Vector3<f64>] {
        &self.excluded
    }

    /// The largest sine of the angle between the axle of an unsteered tyre and the mean of those that
    /// count as parallel with it: they scrub as they roll.
    pub fn toe(&self) -> f64 {
        self.toe
    }

    /// A motion this much beside what unsteered tyres allow is allowed, over its size: tyres with toe
    /// do not agree on more, and files hold rounded angles.
    pub fn allowed_aside(&self) -> f64 {
        self.toe.max(ROUNDED)
    }

    /// Returns how fast a twist in the body frame drags tyres sideways that are not steered, in
    /// m/s: the largest over the directions of their axles, each in the middle of its tyres. 0 for
    /// twists that can be rolled.
    pub fn sideways_m_s(&self, twist_in_body: Twist) -> f64 {
        let twist = vector_of(twist_in_body);
        let rows = self.excluded.iter().map(|row| row.dot(&twist).abs());
        rows.fold(0.0, f64::max)
    }

    /// Returns the twist with the same yaw rate that unsteered tyres allow, nearest to a twist in
    /// the body frame: of a robot whose axle lies off the reference point, the velocity of that
    /// point in a turn about the axle. The same twist where no tyre excludes any.
    pub fn reachable(&self, twist_in_body: Twist) -> Twist {
        // v' nearest to v with n . v' + m omega = 0 in all rows: for one direction of axles its
        // projection, for several the velocity that they leave.
        let twist = vector_of(twist_in_body);
        let (mut ata, mut aty) = (Matrix2::zeros(), Vector2::zeros());
        for row in &self.excluded {
            let n = row.xy();
            ata += n * n.transpose();
            aty += n * row.dot(&twist);
        }
        let off_m_s = match &self.excluded[..] {
            [] => return twist_in_body,
            [row] => row.xy() * row.dot(&twist),
            _ => ata.try_inverse().map_or(aty, |inverse| inverse * aty),
        };
        Twist::new(twist.x - off_m_s.x, twist.y - off_m_s.y, twist.z)
    }

    /// M of eq. (8), N x 3: columns 1 and 2 are M_l (without unit), column 3 is M_a (metres).
    pub fn m(&self) -> &MatrixXx3<f64> {
        &self.m
    }

    /// rho_h cos(gamma_h) of each wheel, in metres: the right-hand side of eq. (7) per rad/s.
    pub fn lever_m(&self) -> &[f64] {
        &self.lever_m
    }

    /// The matrix of eq. (9), N x 3: row h is row h of M over rho_h cos(gamma_h); rad/s per m/s and
    /// rad/s per rad/s.
    pub fn rate_matrix(&self) -> &MatrixXx3<f64> {
        &self.rate_matrix
    }

    /// The left inverse of [`Self::rate_matrix`], 3 x N: M^+ diag(rho_h cos gamma_h), which solves
    /// eq. (7) by least squares.
    pub fn twist_matrix(&self) -> &Matrix3xX<f64> {
        &self.twist_matrix
    }

    /// Computes the wheel rates of a twist of the reference point in the body frame, in rad/s: eq.
    /// (9).
    ///
    /// `out` holds one rate per wheel; wheels beyond its length are left out.
    pub fn wheel_rates(&self, twist_in_body: Twist, out: &mut [f64]) {
        multiply(&self.rate_matrix, twist_in_body, out);
    }

    /// Returns the twist of the reference point in the body frame that fits wheel rates in rad/s
    /// best: least squares of eq. (7), with the residual in m/s along the roller axes. Exact if the
    /// rates can be rolled.
    pub fn twist(&self, rates_rad_s: &[f64]) -> Twist {
        let sum: Vector3<f64> = self
            .twist_matrix
            .column_iter()
            .zip(rates_rad_s)
            .map(|(column, rate_rad_s)| column * *rate_rad_s)
            .sum();
        Twist::new(sum.x, sum.y, sum.z)
    }

    /// Replaces the rates of wheels without a motor, in rad/s, by those at which they roll along with
    /// the motion that the driven wheels determine; leaves them if these determine none.
    pub fn roll_idle(&self, rates_rad_s: &mut [f64]) {
        let is_driven = |of: &Wheel| of.motor.effort_n_m > 0.0;
        if self.wheels.iter().all(is_driven) {
            return;
        }
        // Least squares of eq. (7) as in `twist`, without the rows of the other wheels.
        let (mut ata, mut aty) = (Matrix3::zeros(), Vector3::zeros());
        self.held
            .iter()
            .for_each(|row| ata += row * row.transpose());
        for wheel in (0..self.wheels.len()).filter(|wheel| is_driven(&self.wheels[*wheel])) {
            let row = self.m.row(wheel).transpose();
            ata += row * row.transpose();
            aty += row * (self.lever_m[wheel] * rates_rad_s[wheel]);
        }
        // Turning over the robot's size, as in `assemble`: what is left of a motion that they do not
        // determine is rounding.
        let length_m = reach_m(&self.wheels, self.reference_point_m);
        let size = Vector3::new(1.0, 1.0, 1.0 / length_m);
        let even = Matrix3::from_diagonal(&size) * ata * Matrix3::from_diagonal(&size);
        let known = even.cholesky().filter(|root| {
            let pivots = root.l_dirty().diagonal();
            pivots.min() > RANK_TOLERANCE * pivots.max()
        });
        let Some(known) = known else {
            return;
        };
        let x = known.solve(&aty.component_mul(&size)).component_mul(&size);
        for (wheel, of) in self.wheels.iter().enumerate() {
            if !is_driven(of) {
                rates_rad_s[wheel] = (self.rate_matrix.row(wheel) * x).x;
            }
        }
    }

    /// Returns how the body moves, in the body frame, if joints move the hubs of standing wheels on
    /// it by `along_m` along their axles, in metres: tyres keep their hubs in place there.
    pub fn carried_along_axles(&self, along_m: &[f64]) -> Twist {
        let rows = self.m.row_iter().map(|row| row.transpose());
        let (mut ata, mut aty) = (Matrix3::zeros(), Vector3::zeros());
        (rows.chain(self.held.iter().copied())).for_each(|row| ata += row * row.transpose());
        for (wheel, along_m) in self.wheels.iter().zip(along_m) {
            let (n, b) = (
                wheel.axis(),
                wheel.position_m().xy() - self.reference_point_m,
            );
            aty -= Vector3::new(n.x, n.y, b.perp(&n)) * *along_m;
        }
        let x = ata
            .cholesky()
            .map_or(Vector3::zeros(), |ata| ata.solve(&aty));
        Twist::new(x.x, x.y, x.z)
    }

    /// Computes the part of wheel rates that belongs to no motion, r = q' - M M^+ q' in rad/s: zero
    /// if some twist turns the wheels at these rates by eq. (9), hence always for three wheels, and
    /// for casters.
    pub fn contradiction(&self, rates_rad_s: &[f64], out: &mut [f64]) {
        multiply(&self.rate_matrix, self.twist(rates_rad_s), out);
        for (wheel, (out, rate_rad_s)) in out.iter_mut().zip(rates_rad_s).enumerate() {
            *out = match self.swivels(wheel) {
                true => 0.0,
                false => rate_rad_s - *out,
            };
        }
    }

    /// Whether a wheel is a caster's, whose rate no twist decides: its row in M is zero.
    pub fn swivels(&self, wheel: usize) -> bool {
        self.mounts[wheel] == Mount::Swivels
    }

    /// Computes the residual of eq. (5) for each wheel, in m/s: its left-hand side for
    /// `twist_in_body` less rho q'. Zero is perfect rolling; the velocity at which the wheel slides
    /// along its roller's axis is cos(gamma) times this.
    pub fn residuals(&self, twist_in_body: Twist, rates_rad_s: &[f64], out: &mut [f64]) {
        multiply(&self.rate_matrix, twist_in_body, out);
        for (index, (out, rate_rad_s)) in out.iter_mut().zip(rates_rad_s).enumerate() {
            *out = match self.swivels(index) {
                true => 0.0,
                false => self.wheels[index].radius_m * (*out - rate_rad_s),
            };
        }
    }

    /// Returns the velocity of a wheel's hub in the body frame, in m/s: eq. (2), v_h = v_c + omega
    /// k x b_h.
    pub fn hub_velocity_m_s(&self, wheel: usize, twist_in_body: Twist) -> Option<Vector2<f64>> {
        let b = self.wheels.get(wheel)?.position_m().xy() - self.reference_point_m;
        Some(twist_in_body.linear_m_s() + twist_in_body.omega_rad_s * Vector2::new(-b.y, b.x))
    }

    /// Splits a wheel's hub velocity into the parts of its roller and of its motor, in m/s: (alpha,
    /// beta) of eq. (3), v = alpha u_gamma + beta u. Without slip beta = rho q', eq. (4).
    pub fn rolling_split_m_s(&self, wheel: usize, twist_in_body: Twist) -> Option<(f64, f64)> {
        let v = self.hub_velocity_m_s(wheel, twist_in_body)?;
        let w = self.wheels.get(wheel)?;
        let (n, n_g, u_g) = (w.axis(), w.roller_axis(), w.roller_rolling_direction());
        let u = Vector2::new(n.y, -n.x);
        Some((n.dot(&v) / n.dot(&u_g), n_g.dot(&v) / n_g.dot(&u)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::singularity::SingularityKind;
    use crate::tests::robots::{WheelSpec, mecanum4, mecanum4_specs, robot, six_wheels, volksbot};
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, TAU};

    #[test]
    fn eq_08_the_mecanum_robot_has_the_textbook_matrix() {
        // Rows (1, -+1, -+0.31)/sqrt 2: the arm is 0.15 + 0.16, the textbook l_x + l_y.
        let expected = MatrixXx3::from_row_slice(&[
            1.0, -1.0, -0.31, //
            1.0, 1.0, 0.31, //
            1.0, 1.0, -0.31, //
            1.0, -1.0, 0.31,
        ]) * FRAC_1_SQRT_2;
        let kinematics = Kinematics::new(&mecanum4()).unwrap();
        assert!((kinematics.m() - expected).norm() < 1e-15);
    }

    #[test]
    fn eq_09_the_mecanum_robot_has_the_textbook_rates() {
        // Front left: (vx - vy - 0.31 omega) / rho and similar rows, from any textbook.
        let kinematics = Kinematics::new(&mecanum4()).unwrap();
        let mut rates = [0.0; 4];
        kinematics.wheel_rates(Twist::new(0.3, 0.1, 0.5), &mut rates);
        for (rate, expected) in rates.iter().zip([0.045, 0.555, 0.245, 0.355]) {
            assert!((rate - expected / 0.05).abs() < 1e-13, "{rates:?}");
        }
    }

    #[test]
    fn eq_07_least_squares_gives_back_the_twist_that_made_the_rates() {
        for robot in [mecanum4(), volksbot(), six_wheels()] {
            let kinematics = Kinematics::new(&robot).unwrap();
            let twist = Twist::new(0.3, -0.2, 0.7);
            let mut rates = vec![0.0; kinematics.wheel_count()];
            kinematics.wheel_rates(twist, &mut rates);
            let off = kinematics.twist(&rates) - twist;
            assert!(off.linear_m_s().norm() < 1e-14 && off.omega_rad_s.abs() < 1e-14);
        }
    }

    #[test]
    fn another_reference_point_gives_the_same_rates_for_the_same_motion() {
        let kinematics = Kinematics::new(&six_wheels()).unwrap();
        let p = Vector2::new(0.2, -0.1);
        let there = kinematics.about(p).unwrap();
        let omega = 0.9;
        let (mut here_rates, mut there_rates) = ([0.0; 6], [0.0; 6]);
        kinematics.wheel_rates(Twist::new(0.3, -0.2, omega), &mut here_rates);
        // The velocity of p: v + omega k x p.
        let at_p = Twist::new(0.3 - omega * p.y, -0.2 + omega * p.x, omega);
        there.wheel_rates(at_p, &mut there_rates);
        for (here, there) in here_rates.iter().zip(there_rates) {
            assert!((here - there).abs() < 1e-13);
        }
        let off = there.twist(&there_rates) - at_p;
        assert!(off.linear_m_s().norm() < 1e-14 && off.omega_rad_s.abs() < 1e-14);
        assert!(kinematics.about(Vector2::new(f64::NAN, 0.0)).is_err());
    }

    #[test]
    fn lemma_1_condition_1_names_the_wheels_whose_rollers_roll_the_wrong_way() {
        let mut specs = mecanum4_specs(1.0);
        specs[2].gamma_rad = FRAC_PI_2;
        let error = Kinematics::new(&robot(10.0, &specs)).unwrap_err();
        assert_eq!(
            error,
            ControlError::NoControlAuthority {
                wheels: vec!["wheel_2".to_owned()]
            }
        );
        assert!(error.to_string().starts_with(
            "loss of control authority: the rollers of `wheel_2` roll the way the wheel drives"
        ));
    }

    /// The singularity that construction reports.
    fn singularity(specs: &[WheelSpec]) -> crate::Singularity {
        match Kinematics::new(&robot(10.0, specs)) {
            Err(ControlError::Uncontrollable { singularity }) => singularity,
            other => panic!("expected a singularity, got {other:?}"),
        }
    }

    #[test]
    fn lemma_1_condition_2_finds_the_point_where_a_square_mecanum_robots_wrong_axes_meet() {
        // A square with the roller axes of its diagonals through the middle: every axis passes
        // (0.05, 0).
        let mut specs = mecanum4_specs(1.0);
        for spec in &mut specs {
            spec.x_m = 0.05 + 0.2 * spec.x_m.signum();
            spec.y_m = 0.2 * spec.y_m.signum();
        }
        let found = singularity(&specs);
        let SingularityKind::Meet { point_m } = found.kind else {
            panic!("{found:?}");
        };
        assert!((point_m - Vector2::new(0.05, 0.0)).norm() < 1e-9);
        assert_eq!(found.wheels.len(), 4);
        assert!(found.repaired_by_reversing_all);
        assert_eq!(
            ControlError::Uncontrollable { singularity: found }.to_string(),
            "loss of controllability: all roller axes meet at (0.0500, 0.0000) m: the robot cannot control its \
             rotation about it; wheels `wheel_0`, `wheel_1`, `wheel_2`, `wheel_3`; the wheels are probably on the \
             wrong sides: reversing the handedness of all of them mends it (Lemma 1, condition c.2: rank M < 3)"
        );
    }

    #[test]
    fn lemma_1_condition_2_tells_parallel_axes_and_one_line_apart() {
        let parallel: Vec<_> = [(0.2, 0.1), (0.0, -0.2), (-0.2, 0.15)]
            .iter()
            .map(|&(x, y)| WheelSpec::new(x, y, 0.3, 0.4, 8))
            .collect();
        let found = singularity(&parallel);
        let SingularityKind::Parallel { direction } = found.kind else {
            panic!("{found:?}");
        };
        // The roller axis stands at axis + gamma + 90 deg.
        let angle = 0.7 + FRAC_PI_2;
        assert!((direction - Vector2::new(angle.cos(), angle.sin())).norm() < 1e-12);
        assert_eq!(found.repaired_by_reversing.len(), 3);

        // gamma = 0 and hub axes along y: the roller axes lie along x, all through y = 0.
        let line: Vec<_> = [0.2, 0.0, -0.2]
            .iter()
            .map(|&x| WheelSpec::new(x, 0.0, FRAC_PI_2, 0.0, 8))
            .collect();
        assert!(matches!(
            singularity(&line).kind,
            SingularityKind::OneLine { .. }
        ));
    }

    #[test]
    fn fewer_than_three_wheels_are_refused() {
        let specs = mecanum4_specs(1.0);
        let error = Kinematics::new(&robot(10.0, &specs[..2])).unwrap_err();
        assert_eq!(error, ControlError::TooFewWheels { count: 2 });
    }

    #[test]
    fn the_volksbots_hub_axes_may_point_any_way() {
        // Turning a hub axis by half a turn, and gamma's line with it, only reverses the wheel's
        // rate.
        let specs: Vec<_> = (0..3)
            .map(|i| {
                let a = TAU * f64::from(i) / 3.0;
                WheelSpec::new(0.25 * a.cos(), 0.25 * a.sin(), a + TAU / 2.0, 0.0, 8)
            })
            .collect();
        let (out, inwards) = (
            Kinematics::new(&volksbot()).unwrap(),
            Kinematics::new(&robot(8.0, &specs)).unwrap(),
        );
        assert!((out.rate_matrix() + inwards.rate_matrix()).norm() < 1e-13);
    }
}
