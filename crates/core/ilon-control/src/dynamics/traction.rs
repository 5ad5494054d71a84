//! The set of forces with which the wheels can push the robot within motor torque and friction, and
//! the smallest worst use of friction for a force in the set.
//!
//! **Forces.** Without slip a wheel pushes the body along its roller's axis only; across it the
//! roller spins. Wheel h gives the generalised force (f_x, f_y, moment) = a_h f_h, with a_h = row h
//! of M transposed and f_h, in N, positive where a positive torque pushes: by virtual work M^T f is
//! the force of torques rho cos(gamma) f. The reachable forces are {sum a_h f_h : lo_h <= f_h <=
//! hi_h}, a zonotope. For N > 3 many f give the same force; they differ in how they strain the
//! floor.
//!
//! **Membership.** A convex set is the intersection of its supporting half-spaces. The facets of a
//! zonotope in space are spanned by two of its generators, so their normals are among the y = a_i x
//! a_j. Hence F is reachable exactly when for all of these normals, of either sign,
//!
//!   y . F <= sum over h of max(lo_h a_h . y, hi_h a_h . y).
//!
//! That is N (N - 1) scalar checks, exact, without a solver.
//!
//! **Smallest worst use of friction.** With grips g_h (friction coefficient times load), bisection
//! finds the smallest t for which F is reachable with |f_h| <= t g_h, within the motors' limits. At
//! this t F lies on the boundary, on the facet of the tightest y: every wheel with a_h . y != 0
//! must sit at its bound, and the few in the facet's plane follow from F. So this check also yields
//! the distribution.

use ilon_robot::bisected;
use nalgebra::{Vector2, Vector3};

use crate::Kinematics;
use crate::actuation::motor::TorqueRange;

/// The geometry of the reachable forces of a robot.
#[derive(Clone, Debug)]
pub(crate) struct TractionSet {
    /// a_h, its moment divided by the robot's size, so that all components are in newtons.
    pushes: Vec<Vector3<f64>>,
    size_m: f64,
    /// The candidate normals, each with its products a_h . y.
    normals: Vec<(Vector3<f64>, Vec<f64>)>,
}

/// Bounds of one wheel's push, in N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PushRange {
    pub min_n: f64,
    pub max_n: f64,
}

impl PushRange {
    /// Returns the intersection of two ranges; empty if the result's minimum is above its maximum.
    pub fn within(self, other: Self) -> Self {
        Self {
            min_n: self.min_n.max(other.min_n),
            max_n: self.max_n.min(other.max_n),
        }
    }

    /// Returns the pushes that a motor's torques leave, at a wheel's lever in metres, after the
    /// torque in N m that the wheel needs for itself.
    pub fn beside(own_n_m: f64, limit: &TorqueRange, lever_m: f64) -> Self {
        Self {
            min_n: (limit.min_n_m - own_n_m) / lever_m,
            max_n: (limit.max_n_m - own_n_m) / lever_m,
        }
    }

    /// The pushes that the floor's grip allows, of either sign.
    pub fn of_grip(grip_n: f64) -> Self {
        Self {
            min_n: -grip_n,
            max_n: grip_n,
        }
    }

    fn middle_n(self) -> f64 {
        0.5 * (self.min_n + self.max_n)
    }

    fn half_n(self) -> f64 {
        0.5 * (self.max_n - self.min_n)
    }
}

impl TractionSet {
    pub fn new(kinematics: &Kinematics) -> Self {
        let c = kinematics.reference_point_m();
        let far = |w: &ilon_robot::Wheel| (w.position_m().xy() - c).norm();
        let size_m = kinematics.wheels().iter().map(far).fold(0.0, f64::max);
        let push =
            |row: nalgebra::MatrixView1x3<f64, _, _>| Vector3::new(row[0], row[1], row[2] / size_m);
        let pushes: Vec<_> = kinematics.m().row_iter().map(push).collect();
        let mut normals = Vec::new();
        for (i, a) in pushes.iter().enumerate() {
            for b in &pushes[i + 1..] {
                let y = a.cross(b);
                // Parallel pushes span no facet.
                if y.norm() > 1e-9 * a.norm() * b.norm() {
                    let y = y.normalize();
                    normals.push((y, pushes.iter().map(|a| a.dot(&y)).collect()));
                }
            }
        }
        Self {
            pushes,
            size_m,
            normals,
        }
    }

    /// A generalised force (N, N, N m) in the set's own units.
    fn scaled(&self, force: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(force.x, force.y, force.z / self.size_m)
    }

    /// Returns by how much the force exceeds the half-space of `y` (or of -y, whichever is worse),
    /// in N, and the worse sign.
    fn excess(
        force: &Vector3<f64>,
        (y, products): &(Vector3<f64>, Vec<f64>),
        ranges: impl Iterator<Item = PushRange> + Clone,
    ) -> (f64, f64) {
        let along = y.dot(force);
        let (up, down) = reach_n(products, ranges);
        if along - up >= down - along {
            (along - up, 1.0)
        } else {
            (down - along, -1.0)
        }
    }

    /// Whether a generalised force (N, N, N m) is reachable within the ranges, up to `slack_n`.
    pub fn reaches(
        &self,
        force: &Vector3<f64>,
        ranges: impl Iterator<Item = PushRange> + Clone,
        slack_n: f64,
    ) -> bool {
        if ranges.clone().any(|range| range.min_n > range.max_n) {
            return false;
        }
        let force = self.scaled(force);
        self.normals
            .iter()
            .all(|normal| Self::excess(&force, normal, ranges.clone()).0 <= slack_n)
    }

    /// Returns by how much a generalised force (N, N, N m) lies outside the ranges' set, in N;
    /// below zero inside.
    pub fn outside_n(
        &self,
        force: &Vector3<f64>,
        ranges: impl Iterator<Item = PushRange> + Clone,
    ) -> f64 {
        let crossed = ranges.clone().map(|range| range.min_n - range.max_n);
        let crossed = crossed.fold(f64::NEG_INFINITY, f64::max);
        if crossed > 0.0 {
            return crossed;
        }
        let force = self.scaled(force);
        let excesses = self.normals.iter();
        excesses
            .map(|normal| Self::excess(&force, normal, ranges.clone()).0)
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Computes the pushes that give a force within `motor` with the smallest worst use t of the
    /// grips: fills `out` in N and returns t, at most 1. The force must be reachable at t = 1.
    pub fn distribute(
        &self,
        force: &Vector3<f64>,
        motor: &[PushRange],
        grips_n: &[f64],
        out: &mut [f64],
    ) -> f64 {
        let at = |t: f64| {
            motor.iter().zip(grips_n).map(move |(motor, grip_n)| {
                motor.within(PushRange {
                    min_n: -t * grip_n,
                    max_n: t * grip_n,
                })
            })
        };
        // Bisects until the bounds differ by less than 1e-12 of the grips: forty steps.
        let (t, _) = bisected((1.0, 0.0), 40, |t| self.reaches(force, at(t), 0.0));
        self.fill(force, at(t), out);
        t
    }

    /// Returns the largest part in [0, 1] of a task's force that is reachable in addition to the
    /// given force, within the ranges: each half-space bounds the task, as eq. (30) does for one
    /// bound. If the given force lies outside, returns zero for a task that leads further out.
    pub fn share(
        &self,
        given: &Vector3<f64>,
        task: &Vector3<f64>,
        ranges: impl Iterator<Item = PushRange> + Clone,
    ) -> f64 {
        let (given, task) = (self.scaled(given), self.scaled(task));
        let mut share = 1.0_f64;
        for (y, products) in &self.normals {
            let (up, down) = reach_n(products, ranges.clone());
            let (along, step) = (y.dot(&given), y.dot(&task));
            let room = if step > 0.0 { up - along } else { along - down };
            if step.abs() > room {
                share = share.min(room.max(0.0) / step.abs());
            }
        }
        share
    }

    /// Computes the pushes that give a force with the smallest maximum of push over load, ignoring
    /// motor limits: fills `out` in N and returns that maximum. On the boundary of the set of
    /// pushes up to t times the loads, t is the largest y . F / (sum over h of N_h |a_h . y|).
    /// `None` if the loaded wheels cannot give the force.
    pub fn share_by_load(
        &self,
        force: &Vector3<f64>,
        loads_n: &[f64],
        out: &mut [f64],
    ) -> Option<f64> {
        let scaled = self.scaled(force);
        let mut least = 0.0_f64;
        for (y, products) in &self.normals {
            let reach: f64 = products.iter().zip(loads_n).map(|(p, n)| p.abs() * n).sum();
            let along = y.dot(&scaled).abs();
            if along > 1e-12 * scaled.norm() {
                least = least.max(along / reach);
            }
        }
        if !least.is_finite() {
            return None;
        }
        let ranges = loads_n.iter().map(|load_n| PushRange {
            min_n: -least * load_n,
            max_n: least * load_n,
        });
        self.fill(force, ranges, out);
        Some(least)
    }

    /// Computes the pushes that give a force on the boundary of the ranges' set.
    fn fill(
        &self,
        force: &Vector3<f64>,
        ranges: impl Iterator<Item = PushRange> + Clone,
        out: &mut [f64],
    ) {
        let scaled = self.scaled(force);
        let tightest = self
            .normals
            .iter()
            .map(|normal| (Self::excess(&scaled, normal, ranges.clone()), normal))
            .max_by(|a, b| a.0.0.total_cmp(&b.0.0));
        let Some(((_, sign), (y, products))) = tightest else {
            return;
        };
        let mut rest = scaled;
        for (h, range) in ranges.clone().enumerate() {
            let product = sign * products[h];
            out[h] = if product.abs() <= IN_PLANE {
                0.0
            } else if product > 0.0 {
                range.max_n
            } else {
                range.min_n
            };
            rest -= self.pushes[h] * out[h];
        }
        self.fill_plane(y, products, rest, ranges, out);
    }

    /// Shares the rest of the force among the wheels in the plane of a facet, so that none moves
    /// further from the middle of its range than necessary: the same argument one dimension down.
    /// With f_h = middle_h + s_h half_h, the smallest bound on |s_h| is the largest |y' . d| / sum
    /// of half_h |a_h . y'| over the y' across one of the pushes.
    fn fill_plane(
        &self,
        y: &Vector3<f64>,
        products: &[f64],
        rest: Vector3<f64>,
        ranges: impl Iterator<Item = PushRange> + Clone,
        out: &mut [f64],
    ) {
        // Two axes across y.
        let pick = if y.x.abs() < 0.6 {
            Vector3::x()
        } else {
            Vector3::y()
        };
        let e = y.cross(&pick).normalize();
        let g = y.cross(&e);
        let flat = |h: usize| Vector2::new(self.pushes[h].dot(&e), self.pushes[h].dot(&g));
        let in_plane = || {
            let wheels = ranges.clone().enumerate();
            wheels.filter(|(h, _)| products[*h].abs() <= IN_PLANE)
        };

        let mut d = Vector2::new(rest.dot(&e), rest.dot(&g));
        for (h, range) in in_plane() {
            out[h] = range.middle_n();
            d -= flat(h) * out[h];
        }
        let mut tightest: Option<(f64, Vector2<f64>)> = None;
        for (i, _) in in_plane() {
            let a = flat(i).normalize();
            let across = Vector2::new(-a.y, a.x);
            let reach: f64 = in_plane()
                .map(|(h, range)| range.half_n() * flat(h).dot(&across).abs())
                .sum();
            // If no wheel reaches across this push, d has no component across it either; otherwise
            // F would be out of reach.
            let s = if reach > IN_PLANE {
                across.dot(&d) / reach
            } else {
                0.0
            };
            if tightest.is_none_or(|(before, _)| s.abs() > before.abs()) {
                tightest = Some((s, a));
            }
        }
        let Some((s, a)) = tightest else {
            return;
        };
        let across = Vector2::new(-a.y, a.x);
        let mut along_reach = 0.0;
        for (h, range) in in_plane() {
            let product = flat(h).dot(&across);
            if product.abs() <= IN_PLANE {
                along_reach += range.half_n() * flat(h).dot(&a).abs();
            } else {
                let given = s * product.signum() * range.half_n();
                d -= flat(h) * given;
                out[h] += given;
            }
        }
        // The last dimension: the wheels that push along `a` share the rest.
        let s = if along_reach > IN_PLANE {
            d.dot(&a) / along_reach
        } else {
            0.0
        };
        for (h, range) in in_plane() {
            if flat(h).dot(&across).abs() <= IN_PLANE {
                out[h] += s * flat(h).dot(&a).signum() * range.half_n();
            }
        }
    }
}

/// Products a_h . y below this count as zero: the wheel lies in the facet's plane. Pushes have size
/// 1 to 2, normals size 1.
const IN_PLANE: f64 = 1e-9;

/// How far pushes within ranges reach along and against a normal, by its products with each.
fn reach_n(products: &[f64], ranges: impl Iterator<Item = PushRange>) -> (f64, f64) {
    let (mut up, mut down) = (0.0, 0.0);
    for (product, range) in products.iter().zip(ranges) {
        let (a, b) = (product * range.min_n, product * range.max_n);
        up += a.max(b);
        down += a.min(b);
    }
    (up, down)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::robots::{WheelSpec, mecanum4, robot, six_wheels, volksbot};

    /// Pseudo-random numbers in [-1, 1), always the same.
    fn noise(seed: &mut u64) -> f64 {
        *seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn kinematics() -> Vec<Kinematics> {
        let mut seed = 7;
        let specs: Vec<_> = (0..7)
            .map(|_| {
                let mut r = || noise(&mut seed);
                WheelSpec::new(0.4 * r(), 0.4 * r(), 3.0 * r(), r(), 8)
            })
            .collect();
        [mecanum4(), volksbot(), six_wheels(), robot(9.0, &specs)]
            .iter()
            .map(|robot| Kinematics::new(robot).unwrap())
            .collect()
    }

    fn force_of(k: &Kinematics, pushes: &[f64]) -> Vector3<f64> {
        let rows = k.m().row_iter().zip(pushes);
        rows.map(|(row, f)| row.transpose() * *f).sum()
    }

    #[test]
    fn forces_made_of_pushes_in_range_are_reached_and_those_beyond_the_support_are_not() {
        let mut seed = 1;
        for k in kinematics() {
            let (set, n) = (TractionSet::new(&k), k.wheel_count());
            for _ in 0..300 {
                let ranges: Vec<_> = (0..n)
                    .map(|_| PushRange {
                        min_n: -3.0 * (1.1 + noise(&mut seed)),
                        max_n: 3.0 * (1.1 + noise(&mut seed)),
                    })
                    .collect();
                let inside: Vec<_> = ranges
                    .iter()
                    .map(|r| r.min_n + (r.max_n - r.min_n) * 0.5 * (1.0 + noise(&mut seed)))
                    .collect();
                assert!(set.reaches(&force_of(&k, &inside), ranges.iter().copied(), 1e-9));
                // The furthest force along a direction, and one slightly beyond.
                let y = Vector3::new(noise(&mut seed), noise(&mut seed), noise(&mut seed));
                let corner: Vec<_> = k
                    .m()
                    .row_iter()
                    .zip(&ranges)
                    .map(|(row, r)| {
                        if row.transpose().dot(&y) > 0.0 {
                            r.max_n
                        } else {
                            r.min_n
                        }
                    })
                    .collect();
                let furthest = force_of(&k, &corner);
                assert!(set.reaches(&furthest, ranges.iter().copied(), 1e-9));
                let beyond = furthest + 1e-3 * y;
                assert!(!set.reaches(&beyond, ranges.iter().copied(), 1e-9));
            }
        }
    }

    #[test]
    fn distribution_gives_the_force_with_the_least_worst_use_of_grip() {
        let mut seed = 2;
        for k in kinematics() {
            let (set, n) = (TractionSet::new(&k), k.wheel_count());
            let open = vec![
                PushRange {
                    min_n: -1e6,
                    max_n: 1e6
                };
                n
            ];
            // The directions in which pushes change no force.
            let svd = (k.m() * k.m().transpose()).symmetric_eigen();
            for _ in 0..300 {
                let grips: Vec<_> = (0..n).map(|_| 5.0 * (1.2 + noise(&mut seed))).collect();
                let some: Vec<_> = grips.iter().map(|g| 0.9 * g * noise(&mut seed)).collect();
                let force = force_of(&k, &some);
                let mut pushes = vec![0.0; n];
                let t = set.distribute(&force, &open, &grips, &mut pushes);
                assert!(
                    (force_of(&k, &pushes) - force).norm() < 1e-8,
                    "{n} {pushes:?}"
                );
                let use_of = |pushes: &[f64]| {
                    pushes
                        .iter()
                        .zip(&grips)
                        .map(|(f, g)| (f / g).abs())
                        .fold(0.0, f64::max)
                };
                assert!(
                    (use_of(&pushes) - t).abs() < 1e-8,
                    "{} {t}",
                    use_of(&pushes)
                );
                assert!(t <= use_of(&some) + 1e-9);
                // No change of the pushes that keeps the force uses less grip.
                for (value, direction) in svd.eigenvalues.iter().zip(svd.eigenvectors.column_iter())
                {
                    if *value > 1e-9 {
                        continue;
                    }
                    for step in [-1.0, -0.1, -0.01, 0.01, 0.1, 1.0] {
                        let other: Vec<_> = pushes
                            .iter()
                            .zip(direction.iter())
                            .map(|(f, z)| f + step * z)
                            .collect();
                        assert!(use_of(&other) >= t - 1e-8);
                    }
                }
            }
        }
    }

    #[test]
    fn straight_ahead_a_mecanum_robots_wheels_share_alike() {
        let k = Kinematics::new(&mecanum4()).unwrap();
        let set = TractionSet::new(&k);
        let open = [PushRange {
            min_n: -1e6,
            max_n: 1e6,
        }; 4];
        let mut pushes = [0.0; 4];
        // 4 f / sqrt 2 = 20 N.
        let t = set.distribute(
            &Vector3::new(20.0, 0.0, 0.0),
            &open,
            &[10.0; 4],
            &mut pushes,
        );
        let expected = 20.0 * 2.0_f64.sqrt() / 4.0;
        assert!((t - expected / 10.0).abs() < 1e-9);
        assert!(
            pushes.iter().all(|f| (f - expected).abs() < 1e-8),
            "{pushes:?}"
        );
    }

    #[test]
    fn a_wheel_with_little_grip_is_relieved() {
        let k = Kinematics::new(&mecanum4()).unwrap();
        let set = TractionSet::new(&k);
        let open = [PushRange {
            min_n: -1e6,
            max_n: 1e6,
        }; 4];
        let (mut alike, mut relieved) = ([0.0; 4], [0.0; 4]);
        let force = Vector3::new(10.0, 0.0, 0.0);
        set.distribute(&force, &open, &[10.0; 4], &mut alike);
        set.distribute(&force, &open, &[3.0, 10.0, 10.0, 10.0], &mut relieved);
        assert!(relieved[0].abs() < alike[0].abs());
        assert!((force_of(&k, &relieved) - force).norm() < 1e-8);
    }

    /// Two wheels that push along x stand left and right, two that push along y in front and
    /// behind. A force along an axis is shared by its two wheels; the others, which could only turn
    /// the robot, get none.
    #[test]
    fn a_force_along_an_axis_is_shared_by_the_two_wheels_that_push_along_it() {
        use std::f64::consts::FRAC_PI_2;
        let specs = [
            WheelSpec::new(0.0, 0.2, FRAC_PI_2, 0.0, 8),
            WheelSpec::new(0.0, -0.2, FRAC_PI_2, 0.0, 8),
            WheelSpec::new(0.2, 0.0, 0.0, 0.0, 8),
            WheelSpec::new(-0.2, 0.0, 0.0, 0.0, 8),
        ];
        let k = Kinematics::new(&robot(9.0, &specs)).unwrap();
        let set = TractionSet::new(&k);
        let open = [PushRange {
            min_n: -1e6,
            max_n: 1e6,
        }; 4];
        for (force, pushing) in [
            (Vector3::new(16.0, 0.0, 0.0), [true, true, false, false]),
            (Vector3::new(0.0, -16.0, 0.0), [false, false, true, true]),
        ] {
            let mut pushes = [f64::NAN; 4];
            let t = set.distribute(&force, &open, &[20.0; 4], &mut pushes);
            // 8 of 20 N each.
            assert!((t - 0.4).abs() < 1e-9, "{t}");
            assert!((force_of(&k, &pushes) - force).norm() < 1e-8);
            for (push, pushes_it) in pushes.iter().zip(pushing) {
                let expected = if pushes_it { 8.0 } else { 0.0 };
                assert!((push.abs() - expected).abs() < 1e-8, "{pushes:?}");
            }
        }
    }
}
