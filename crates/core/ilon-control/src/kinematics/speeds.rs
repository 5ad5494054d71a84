//! The speeds that a robot's wheels allow within their rate limits.

use ilon_robot::Twist;
use nalgebra::{Matrix2, Vector2, Vector3};

use crate::Kinematics;
use crate::kinematics::matrix::vector_of;
use crate::kinematics::module::Module;

/// The twists that a robot's wheels can roll within their rate limits: the polytope |row h of eq.
/// (9) . twist| <= q'_max_h in (vx, vy, omega), symmetric about rest. A steered tyre has turned to
/// the twist, the nearer way round from where it stands: rho q'_max_h limits the speed at which it
/// then rolls (see `kinematics/module.rs`).
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedLimits {
    /// Row h of eq. (9) over its wheel's limit: inside the polytope no row exceeds 1 in amount.
    rows: Vec<Vector3<f64>>,
    /// The steered wheels, and rho q'_max_h of each.
    modules: Vec<(Module, f64)>,
    /// The twist of a turn at 1 rad/s that moves the reference point least.
    turn: Vector3<f64>,
    /// Rows that tyres hold at zero which are not steered.
    held: Vec<Vector3<f64>>,
    /// A twist this much beside them, over its size, is allowed.
    aside: f64,
}

impl SpeedLimits {
    /// The limits of a robot whose wheels each have their own rate limit in rad/s, infinite for
    /// none; wheels beyond the length of `limits_rad_s` have none.
    pub fn new(kinematics: &Kinematics, limits_rad_s: &[f64]) -> Self {
        let (mut rows, mut modules) = (Vec::new(), Vec::new());
        let is_limit = |limit_rad_s: f64| limit_rad_s.is_finite() && limit_rad_s > 0.0;
        for (wheel, limit_rad_s) in limits_rad_s.iter().copied().enumerate() {
            let Some(of) = kinematics
                .wheels()
                .get(wheel)
                .filter(|_| is_limit(limit_rad_s))
            else {
                continue;
            };
            match kinematics.module(wheel) {
                Some(module) => modules.push((module, of.radius_m * limit_rad_s)),
                None => rows.push(kinematics.rate_matrix().row(wheel).transpose() / limit_rad_s),
            }
        }
        Self {
            rows,
            modules,
            turn: vector_of(kinematics.reachable(Twist::new(0.0, 0.0, 1.0))),
            held: kinematics.excluded_rows().to_vec(),
            aside: kinematics.allowed_aside(),
        }
    }

    /// The same limit in rad/s on every wheel: the paper's q'_max.
    pub fn uniform(kinematics: &Kinematics, limit_rad_s: f64) -> Self {
        Self::new(kinematics, &vec![limit_rad_s; kinematics.wheel_count()])
    }

    /// Returns the largest share of its limit that any wheel needs for a twist in the body frame: 1
    /// is the boundary of the polytope. Infinite for a twist that tyres exclude by more than their
    /// toe, or the rounding of a file's angles.
    pub fn share(&self, twist_in_body: Twist) -> f64 {
        let twist = Vector3::new(
            twist_in_body.vx_m_s,
            twist_in_body.vy_m_s,
            twist_in_body.omega_rad_s,
        );
        let is_held =
            |row: &Vector3<f64>| row.dot(&twist).abs() > self.aside * row.norm() * twist.norm();
        if self.held.iter().any(is_held) {
            return f64::INFINITY;
        }
        let rows = self.rows.iter().map(|row| row.dot(&twist).abs());
        let modules = self.modules.iter();
        rows.chain(modules.map(|(module, top_m_s)| module.speed_m_s(&twist) / top_m_s))
            .fold(0.0, f64::max)
    }

    /// Returns the top speed in m/s without rotation, in a direction of the body frame given in
    /// radians from x; infinite if no wheel limits it.
    pub fn top_speed_m_s(&self, direction_rad: f64) -> f64 {
        let (s, c) = libm::sincos(direction_rad);
        1.0 / self.share(Twist::new(c, s, 0.0))
    }

    /// Returns the smallest and the largest top speed over all directions, without rotation, in
    /// m/s.
    pub fn top_speed_range_m_s(&self) -> (f64, f64) {
        let modules = self.modules.iter().map(|(_, top_m_s)| 1.0 / top_m_s);
        let rows = self.rows.iter().map(|row| row.xy().norm());
        let steepest = rows.chain(modules).fold(0.0, f64::max);
        let corners = self.at_yaw_rate(0.0);
        let furthest = corners.iter().map(|v| v.norm()).fold(0.0, f64::max);
        (
            if self.held.is_empty() {
                1.0 / steepest
            } else {
                0.0
            },
            if corners.is_empty() {
                f64::INFINITY
            } else {
                furthest
            },
        )
    }

    /// Returns the top yaw rate in rad/s with the reference point at rest, or as slow as unsteered
    /// tyres allow in a turn; infinite if no wheel limits it.
    pub fn top_yaw_rate_rad_s(&self) -> f64 {
        1.0 / self.share(Twist::new(self.turn.x, self.turn.y, self.turn.z))
    }

    /// Returns the possible velocities in m/s at a yaw rate in rad/s: the corners of a convex
    /// polygon in the body frame, counter-clockwise; two where unsteered tyres leave one direction,
    /// one where they leave a turn about a point. The arcs of steered wheels are sides of 4
    /// degrees, and hold whichever way round those stand that lie off their steering axes. Empty if
    /// the yaw rate is out of reach or the velocity is unlimited.
    pub fn at_yaw_rate(&self, omega_rad_s: f64) -> Vec<Vector2<f64>> {
        let stops =
            |(module, top_m_s): &(Module, f64)| module.axis_top_m_s(*top_m_s, omega_rad_s) == 0.0;
        if self.modules.iter().any(stops) {
            return Vec::new();
        }
        match &self.held[..] {
            [] if self.modules.is_empty() => self.polygon(omega_rad_s),
            [] => self.rounded(omega_rad_s),
            [row] => self.along(row, omega_rad_s),
            _ => {
                let v = omega_rad_s * self.turn.xy();
                let can = self.share(Twist::new(v.x, v.y, omega_rad_s)) <= EDGE;
                can.then_some(v).into_iter().collect()
            }
        }
    }

    /// The corners that the rows leave.
    fn polygon(&self, omega_rad_s: f64) -> Vec<Vector2<f64>> {
        let mut corners: Vec<Vector2<f64>> = Vec::new();
        for (i, a) in self.rows.iter().enumerate() {
            for b in &self.rows[i + 1..] {
                let sides = Matrix2::new(a.x, a.y, b.x, b.y);
                // Parallel sides have no corner.
                let size = a.xy().norm() * b.xy().norm();
                if sides.determinant().abs() <= 1e-9 * size {
                    continue;
                }
                let Some(inverse) = sides.try_inverse() else {
                    continue;
                };
                for (sign_a, sign_b) in [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)] {
                    let right =
                        Vector2::new(sign_a - a.z * omega_rad_s, sign_b - b.z * omega_rad_s);
                    let v = inverse * right;
                    if self.share(Twist::new(v.x, v.y, omega_rad_s)) <= EDGE
                        && corners
                            .iter()
                            .all(|c| (c - v).norm() > 1e-9 * (c.norm() + v.norm()))
                    {
                        corners.push(v);
                    }
                }
            }
        }
        let middle = corners.iter().sum::<Vector2<f64>>() / corners.len().max(1) as f64;
        let angle = |v: &Vector2<f64>| libm::atan2(v.y - middle.y, v.x - middle.x);
        corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        corners
    }

    /// Cuts the discs of the steered wheels, and the strips of the others, out of the first disc.
    fn rounded(&self, omega_rad_s: f64) -> Vec<Vector2<f64>> {
        /// Sides of a disc.
        const SIDES: usize = 90;
        let disc = |(module, top_m_s): &(Module, f64)| {
            let radius_m_s = module.axis_top_m_s(*top_m_s, omega_rad_s);
            let middle = -omega_rad_s * Vector2::from(module.rows().map(|row| row.z));
            let corner = move |k: usize| {
                let (sin, cos) = libm::sincos(std::f64::consts::TAU * k as f64 / SIDES as f64);
                middle + radius_m_s * Vector2::new(cos, sin)
            };
            (0..SIDES).map(corner).collect::<Vec<_>>()
        };
        let mut discs = self.modules.iter().map(disc);
        let mut left = discs.next().unwrap_or_default();
        for other in discs {
            for (k, a) in other.iter().enumerate() {
                let side = other[(k + 1) % SIDES] - a;
                let outward = Vector2::new(side.y, -side.x);
                left = clipped(&left, outward, outward.dot(a));
            }
        }
        for row in &self.rows {
            for sign in [1.0, -1.0] {
                left = clipped(&left, sign * row.xy(), 1.0 - sign * row.z * omega_rad_s);
            }
        }
        left
    }

    /// The ends of the velocities along the one direction that unsteered tyres leave: v = v_0 + s u
    /// with n . v + m omega = 0, where |a + b s| <= 1 for every wheel.
    fn along(&self, row: &Vector3<f64>, omega_rad_s: f64) -> Vec<Vector2<f64>> {
        let (u, v_0) = (Vector2::new(row.y, -row.x), omega_rad_s * self.turn.xy());
        let still = Vector3::new(v_0.x, v_0.y, omega_rad_s);
        let part = |row: &Vector3<f64>| (row.dot(&still), row.xy().dot(&u));
        let mut ways: Vec<[(f64, f64); 2]> = Vec::new();
        ways.extend(self.rows.iter().map(|row| [part(row), (0.0, 0.0)]));
        let modules = self.modules.iter().map(|(module, top_m_s)| {
            let top_m_s = module.axis_top_m_s(*top_m_s, omega_rad_s);
            module.rows().map(|row| part(&(row / top_m_s)))
        });
        ways.extend(modules);
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for [(a, b), (c, d)] in ways {
            // (a + b s)^2 + (c + d s)^2 = 1.
            let (square, half, rest) = (b * b + d * d, a * b + c * d, a * a + c * c - 1.0);
            let root = half * half - square * rest;
            if square == 0.0 && rest <= EDGE - 1.0 {
                continue;
            }
            if square == 0.0 || root < 0.0 {
                return Vec::new();
            }
            low = low.max((-half - root.sqrt()) / square);
            high = high.min((-half + root.sqrt()) / square);
        }
        match low <= high && low.is_finite() && high.is_finite() {
            true => vec![v_0 + low * u, v_0 + high * u],
            false => Vec::new(),
        }
    }

    /// Whether unsteered tyres hold it in one direction, so that it drives ahead and turns.
    pub fn is_held(&self) -> bool {
        !self.held.is_empty()
    }
}

/// Cuts off what of a convex polygon lies beyond outward . v = limit.
fn clipped(corners: &[Vector2<f64>], outward: Vector2<f64>, limit: f64) -> Vec<Vector2<f64>> {
    let beyond = |v: &Vector2<f64>| outward.dot(v) - limit;
    let mut left = Vec::new();
    for (k, a) in corners.iter().enumerate() {
        let b = corners[(k + 1) % corners.len()];
        let (at_a, at_b) = (beyond(a), beyond(&b));
        if at_a <= 0.0 {
            left.push(*a);
        }
        if (at_a < 0.0 && at_b > 0.0) || (at_a > 0.0 && at_b < 0.0) {
            left.push(a + at_a / (at_a - at_b) * (b - a));
        }
    }
    left
}

/// The boundary of the polytope, with a margin for the rounding of a solved corner.
const EDGE: f64 = 1.0 + 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::robots::{mecanum4, six_wheels, volksbot};
    use std::f64::consts::{FRAC_PI_6, PI};

    #[test]
    fn section_4_the_volksbots_speeds_at_8_7_rad_per_s() {
        let kinematics = Kinematics::new(&volksbot()).unwrap();
        let limits = SpeedLimits::uniform(&kinematics, 8.7);
        // rho q' / |b| = 0.05 * 8.7 / 0.25 = 1.74 rad/s = 99.7 deg/s, as the paper states.
        assert!((limits.top_yaw_rate_rad_s() - 1.74).abs() < 1e-14);
        assert!((limits.top_yaw_rate_rad_s().to_degrees() - 99.7).abs() < 0.05);
        // rho q' = 0.435 m/s along a wheel's rolling direction; over cos 30 deg = 0.5023 m/s
        // between two.
        let (least, largest) = limits.top_speed_range_m_s();
        assert!((least - 0.435).abs() < 1e-14);
        assert!((largest - 0.435 / FRAC_PI_6.cos()).abs() < 1e-14);
        assert!((limits.top_speed_m_s(0.0) - 0.502_3).abs() < 5e-5);
        assert!((limits.top_speed_m_s(PI / 2.0) - 0.435).abs() < 1e-14);
        // A hexagon without rotation.
        assert_eq!(limits.at_yaw_rate(0.0).len(), 6);
        assert!(limits.at_yaw_rate(1.75).is_empty());
    }

    #[test]
    fn the_mecanum_robot_reaches_the_textbook_speeds() {
        let kinematics = Kinematics::new(&mecanum4()).unwrap();
        let limits = SpeedLimits::uniform(&kinematics, 10.0);
        // |vx| + |vy| + 0.31 |omega| <= rho q'.
        assert!((limits.top_speed_m_s(0.0) - 0.5).abs() < 1e-14);
        assert!((limits.top_speed_m_s(PI / 4.0) - 0.5 / 2.0_f64.sqrt()).abs() < 1e-14);
        assert!((limits.top_yaw_rate_rad_s() - 0.5 / 0.31).abs() < 1e-14);
    }

    #[test]
    fn slices_are_the_edge_of_what_is_allowed() {
        let kinematics = Kinematics::new(&six_wheels()).unwrap();
        let limits = SpeedLimits::new(&kinematics, &[8.0, 9.0, 10.0, 8.0, 9.0, 10.0]);
        let slice = limits.at_yaw_rate(0.5);
        for (i, v) in slice.iter().enumerate() {
            assert!((limits.share(Twist::new(v.x, v.y, 0.5)) - 1.0).abs() < 1e-9);
            // Convex and counter-clockwise.
            let (next, after) = (slice[(i + 1) % slice.len()], slice[(i + 2) % slice.len()]);
            assert!((next - v).perp(&(after - next)) > 0.0);
        }
    }

    #[test]
    fn without_limits_nothing_is_out_of_reach() {
        let kinematics = Kinematics::new(&volksbot()).unwrap();
        let limits = SpeedLimits::uniform(&kinematics, f64::INFINITY);
        assert_eq!(limits.top_speed_range_m_s(), (f64::INFINITY, f64::INFINITY));
        assert_eq!(limits.share(Twist::new(1e6, 0.0, 0.0)), 0.0);
    }

    /// At 1 rad/s rotation takes 0.31 m/s of the 0.5 m/s, and the rest moves the middle in the
    /// diamond |vx| + |vy| <= 0.19 m/s. A point 0.5 m ahead and 0.3 m to the left of it moves in
    /// addition by 0.5 m/s to the left and 0.3 m/s back.
    #[test]
    fn possible_velocities_of_another_point_are_those_of_the_middle_moved() {
        let kinematics = Kinematics::new(&mecanum4()).unwrap();
        let there = kinematics.about(Vector2::new(0.5, 0.3)).unwrap();
        let slice = SpeedLimits::uniform(&there, 10.0).at_yaw_rate(1.0);
        let expected = [(0.0, -0.19), (0.19, 0.0), (0.0, 0.19), (-0.19, 0.0)];
        assert_eq!(slice.len(), expected.len());
        // Counter-clockwise, from any corner.
        let first = (0..4)
            .min_by(|a, b| slice[*a].y.total_cmp(&slice[*b].y))
            .unwrap();
        for (k, (x, y)) in expected.into_iter().enumerate() {
            let corner = slice[(first + k) % 4];
            let off = corner - Vector2::new(x - 0.3, y + 0.5);
            assert!(off.norm() < 1e-12, "{slice:?}");
        }
    }
}
