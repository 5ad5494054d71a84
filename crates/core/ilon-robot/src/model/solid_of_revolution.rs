//! A roller turned to a profile given by numbers: a convex body of revolution about the roller's
//! axis.
//!
//! The profile is a chain of points (t, radius) along the axis, joined by straight lines and closed
//! by a flat face at each end: two points are a cylinder, four a cylinder between two cones. Every
//! edge is rounded with one radius c: the body is a core, the profile shrunk by c all around,
//! thickened by a ball of radius c. Each corner of the core is a circle about the axis of radius q
//! at t, so that the reach in a unit direction with the component w along the axis is
//!
//!   h(w) = max over the corners of t w + q sqrt(1 - w^2) + c.
//!
//! Under the hub w = k sin(phi), with phi the roller's angle from straight down and k = cos(gamma):
//! a cylinder of half length l lifts it to a cos(phi) + (l - c) w + (r - c) sqrt(1 - w^2) + c on
//! its edges.
//!
//! A smooth outline rho(t) given at points Delta t apart is approximated by its chords: the reach
//! is short by at most rho'' (Delta t)^2 / 8, which is of second order.

use std::f64::consts::PI;

use super::{Profile, ProfilePart};
use crate::bisected;

/// A convex body of revolution, given by the corners of its profile.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidOfRevolution {
    /// The corners of its core from one end to the other, each thickened by a ball of one radius.
    profile: Profile,
    /// Radius c of its edges, in metres.
    edge_radius_m: f64,
}

/// Reasons why a profile is rejected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProfileError {
    /// Fewer than two points.
    #[error(
        "it needs two points or more, [place along the axis, radius] in metres, and has {points}"
    )]
    TooFewPoints {
        /// The number of points.
        points: usize,
    },
    /// A point that is not finite, or whose radius is not positive.
    #[error("point {point} needs a finite place and a finite radius above 0")]
    NotAPoint {
        /// Index of the point, from 1.
        point: usize,
    },
    /// Positions that do not increase.
    #[error("point {point} must lie further along the axis than the one before it")]
    NotRising {
        /// Index of the point, from 1.
        point: usize,
    },
    /// A concave profile: ground would touch it at two places at once.
    #[error(
        "it is hollow at point {point}: the radius there is below the straight line between its neighbours"
    )]
    Hollow {
        /// Index of the point, from 1.
        point: usize,
    },
    /// An edge radius that leaves nothing of a part of the profile.
    #[error(
        "its edges cannot be rounded with {edge_radius_mm} mm: nothing would be left between its points or at its ends"
    )]
    EdgeTooRound {
        /// The radius, in millimetres.
        edge_radius_mm: f64,
    },
}

/// Tolerance, over the radius, for a point that lies below the line between its neighbours by
/// rounding.
const STRAIGHT: f64 = 1e-9;

impl SolidOfRevolution {
    /// The body of a profile: `[position along the axis from the roller's middle, radius]`, in
    /// metres, from one end to the other, and the radius of its edges.
    ///
    /// # Errors
    /// [`ProfileError`]: too few points, invalid points, positions that do not increase, a concave
    /// profile, or edges too round.
    pub fn new(points_m: &[[f64; 2]], edge_radius_m: f64) -> Result<Self, ProfileError> {
        if points_m.len() < 2 {
            let points = points_m.len();
            return Err(ProfileError::TooFewPoints { points });
        }
        for (i, [t, r]) in points_m.iter().enumerate() {
            if !(t.is_finite() && r.is_finite() && *r > 0.0) {
                return Err(ProfileError::NotAPoint { point: i + 1 });
            }
        }
        for (i, pair) in points_m.windows(2).enumerate() {
            if pair[1][0] <= pair[0][0] {
                return Err(ProfileError::NotRising { point: i + 2 });
            }
        }
        for (i, three) in points_m.windows(3).enumerate() {
            let [p, q, r] = [three[0], three[1], three[2]];
            let share = (q[0] - p[0]) / (r[0] - p[0]);
            let straight_m = p[1] + share * (r[1] - p[1]);
            if q[1] < straight_m * (1.0 - STRAIGHT) {
                return Err(ProfileError::Hollow { point: i + 2 });
            }
        }
        let too_round = ProfileError::EdgeTooRound {
            edge_radius_mm: 1e3 * edge_radius_m,
        };
        if !(edge_radius_m.is_finite() && edge_radius_m >= 0.0) {
            return Err(too_round);
        }
        // Outward unit normals of face, lines and face: a corner of the core lies c from both lines
        // that meet at its point.
        let lines = points_m.windows(2).map(|pair| {
            let (dt, dr) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
            let length = libm::hypot(dt, dr);
            [-dr / length, dt / length]
        });
        let normals: Vec<[f64; 2]> = [[-1.0, 0.0]]
            .into_iter()
            .chain(lines)
            .chain([[1.0, 0.0]])
            .collect();
        let corner = |i: usize| {
            let ([t, r], [n, m]) = (points_m[i], [normals[i], normals[i + 1]]);
            let inward_m = edge_radius_m / (1.0 + n[0] * m[0] + n[1] * m[1]);
            ProfilePart {
                t_m: t - inward_m * (n[0] + m[0]),
                ring_m: r - inward_m * (n[1] + m[1]),
                ball_m: edge_radius_m,
            }
        };
        let corners: Vec<ProfilePart> = (0..points_m.len()).map(corner).collect();
        let rises = corners.windows(2).all(|pair| pair[0].t_m < pair[1].t_m);
        if !rises || corners.iter().any(|corner| corner.ring_m < 0.0) {
            return Err(too_round);
        }
        let profile = Profile::new(corners).ok_or(too_round)?;
        Ok(Self {
            profile,
            edge_radius_m,
        })
    }

    /// The corners of its core from one end to the other, each thickened by a ball of the edges'
    /// radius.
    pub fn corners(&self) -> &[ProfilePart] {
        self.profile.parts()
    }

    /// The corners as a profile.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Radius of its edges, in metres.
    pub fn edge_radius_m(&self) -> f64 {
        self.edge_radius_m
    }

    /// Its first and last position along the axis, in metres.
    pub fn span_m(&self) -> (f64, f64) {
        let (first, last) = self.profile.span_m();
        (first - self.edge_radius_m, last + self.edge_radius_m)
    }

    /// Its largest radius, in metres.
    pub fn largest_radius_m(&self) -> f64 {
        self.profile.support_m(0.0)
    }

    /// Returns the radius of a ball around the middle that contains the body, in metres.
    pub fn bounding_radius_m(&self) -> f64 {
        let far = |corner: &ProfilePart| libm::hypot(corner.t_m, corner.ring_m) + corner.ball_m;
        self.corners().iter().map(far).fold(0.0, f64::max)
    }

    /// Returns the signed distance of a point from the surface, in metres, negative inside, and its
    /// gradient, along the axis and away from it. The point is given by its position `t_m` along
    /// the axis and its distance `r_m` >= 0 from it.
    pub fn distance_m(&self, t_m: f64, r_m: f64) -> (f64, [f64; 2]) {
        let corners = self.corners();
        // The chain of the core: from the axis up one end, along the corners, and down the other
        // end.
        let chain = |i: usize| match i {
            0 => [corners[0].t_m, 0.0],
            i if i <= corners.len() => [corners[i - 1].t_m, corners[i - 1].ring_m],
            _ => [corners[corners.len() - 1].t_m, 0.0],
        };
        // Inside the core: the distance to the nearest line; outside: to the nearest point of the
        // chain.
        let mut inside = (f64::NEG_INFINITY, [0.0, 1.0]);
        let mut outside = (f64::INFINITY, [0.0, 1.0]);
        for i in 0..=corners.len() {
            let pair = [chain(i), chain(i + 1)];
            let along = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
            let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
            if length == 0.0 {
                continue;
            }
            let along = along.map(|x| x / length);
            let normal = [-along[1], along[0]];
            let off = [t_m - pair[0][0], r_m - pair[0][1]];
            let above_m = normal[0] * off[0] + normal[1] * off[1];
            if above_m > inside.0 {
                inside = (above_m, normal);
            }
            let at_m = (along[0] * off[0] + along[1] * off[1]).clamp(0.0, length);
            let away = [off[0] - at_m * along[0], off[1] - at_m * along[1]];
            let away_m = (away[0] * away[0] + away[1] * away[1]).sqrt();
            if away_m < outside.0 {
                let direction = if away_m > 0.0 {
                    away.map(|x| x / away_m)
                } else {
                    normal
                };
                outside = (away_m, direction);
            }
        }
        let (distance_m, direction) = if inside.0 <= 0.0 { inside } else { outside };
        (distance_m - self.edge_radius_m, direction)
    }

    /// Returns the radius of its surface `t_m` along the axis from its middle, in metres; 0 beyond
    /// its ends.
    pub fn surface_radius_m(&self, t_m: f64) -> f64 {
        let (first_m, last_m) = self.span_m();
        if !(first_m..=last_m).contains(&t_m) {
            return 0.0;
        }
        // Outward from the axis the distance is convex, so bisection finds its zero.
        let is_outside = |radius_m: f64| self.distance_m(t_m, radius_m).0 > 0.0;
        let ends_m = (self.largest_radius_m(), 0.0);
        let (outside_m, inside_m) = bisected(ends_m, 60, is_outside);
        0.5 * (outside_m + inside_m)
    }

    /// Returns the moments of inertia about the roller's middle, with uniform density: about its
    /// axis, and about any axis across it, in kg m^2 (like [`super::Barrel::solid_moments_kg_m2`]).
    pub fn solid_moments_kg_m2(&self, mass_kg: f64) -> (f64, f64) {
        let (first_m, last_m) = self.span_m();
        let slices = (0..SLICES).map(|i| {
            let z = first_m + (last_m - first_m) * (i as f64 + 0.5) / SLICES as f64;
            (z, self.surface_radius_m(z))
        });
        moments_of_slices(slices, mass_kg)
    }

    /// Returns its volume in m^3: the sum of its slices.
    pub fn volume_m3(&self) -> f64 {
        let (first_m, last_m) = self.span_m();
        let width_m = (last_m - first_m) / SLICES as f64;
        let slice = |i: usize| {
            let r = self.surface_radius_m(first_m + width_m * (i as f64 + 0.5));
            PI * r * r * width_m
        };
        (0..SLICES).map(slice).sum()
    }
}

/// Returns the moments of inertia of a body of uniform density, about its axis and across it, in kg
/// m^2, from the middles and radii of its slices. Each is a disc of mass dm: dm r^2 / 2, and dm
/// (r^2 / 4 + z^2).
pub(super) fn moments_of_slices(
    slices: impl Iterator<Item = (f64, f64)>,
    mass_kg: f64,
) -> (f64, f64) {
    let (mut volume, mut axial, mut across) = (0.0, 0.0, 0.0);
    for (z, r) in slices {
        volume += r * r;
        axial += r * r * (0.5 * r * r);
        across += r * r * (0.25 * r * r + z * z);
    }
    (axial * mass_kg / volume, across * mass_kg / volume)
}

/// Number of slices of a body; the error of their sums is of the order of one over its square.
const SLICES: usize = 400;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cylinder_is_met_at_its_edges() {
        let (half, r) = (0.02, 0.01);
        let sharp = SolidOfRevolution::new(&[[-half, r], [half, r]], 0.0).unwrap();
        for i in -10..=10 {
            let w = f64::from(i) / 10.5;
            // The furthest point of |t| <= half, |r| <= r along (w, sqrt(1 - w^2)).
            let reach_m = half * w.abs() + r * (1.0 - w * w).sqrt();
            assert!((sharp.profile().support_m(w) - reach_m).abs() < 1e-16);
        }
        // An edge of radius c: the same corner, c nearer on both sides, and c out again along the
        // direction.
        let c = 0.002;
        let round = SolidOfRevolution::new(&[[-half, r], [half, r]], c).unwrap();
        let w: f64 = 0.6;
        let reach_m = (half - c) * w + (r - c) * 0.8 + c;
        assert!((round.profile().support_m(w) - reach_m).abs() < 1e-16);
        assert!((round.largest_radius_m() - r).abs() < 1e-16);
        // c off and on again: one rounding.
        let (first_m, last_m) = round.span_m();
        assert!((first_m + half).abs() < 1e-17 && (last_m - half).abs() < 1e-17);
    }

    #[test]
    fn distance_from_a_cylinder_is_that_from_its_side_its_face_or_its_edge() {
        let body = SolidOfRevolution::new(&[[-0.02, 0.01], [0.02, 0.01]], 0.002).unwrap();
        // Edge: a quarter circle of radius 2 mm about (18, 8) mm.
        let off_edge_m = libm::hypot(0.005, 0.003) - 0.002;
        for (t, r, expected_m) in [
            (0.0, 0.013, 0.003),
            (0.021, 0.003, 0.001),
            (-0.021, 0.003, 0.001),
            (0.023, 0.011, off_edge_m),
            (0.0, 0.0085, -0.0015),
            (0.0, 0.0, -0.01),
        ] {
            let (distance_m, [along, out]) = body.distance_m(t, r);
            assert!(
                (distance_m - expected_m).abs() < 1e-16,
                "{t} {r}: {distance_m}"
            );
            assert!((libm::hypot(along, out) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn a_cylinder_weighs_as_a_cylinder() {
        let (half, r, mass) = (0.02, 0.01, 0.3);
        let body = SolidOfRevolution::new(&[[-half, r], [half, r]], 0.0).unwrap();
        let (axial, across) = body.solid_moments_kg_m2(mass);
        // Sums over 400 slices: the moment of z^2 is short by a share of 1 / 400^2.
        assert!((axial / (0.5 * mass * r * r) - 1.0).abs() < 1e-12);
        let exact = mass * (3.0 * r * r + 4.0 * half * half) / 12.0;
        assert!((across / exact - 1.0).abs() < 1e-5);
        assert!((body.volume_m3() / (PI * r * r * 2.0 * half) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_convex_profile_is_refused() {
        let refused =
            |points: &[[f64; 2]], edge: f64| SolidOfRevolution::new(points, edge).unwrap_err();
        let one = refused(&[[0.0, 0.01]], 0.0);
        assert_eq!(one, ProfileError::TooFewPoints { points: 1 });
        let flat = refused(&[[-0.01, 0.01], [0.01, 0.0]], 0.0);
        assert_eq!(flat, ProfileError::NotAPoint { point: 2 });
        let back = refused(&[[0.01, 0.01], [-0.01, 0.01]], 0.0);
        assert_eq!(back, ProfileError::NotRising { point: 2 });
        let hollow = refused(&[[-0.01, 0.01], [0.0, 0.009], [0.01, 0.01]], 0.0);
        assert_eq!(hollow, ProfileError::Hollow { point: 2 });
        for edge in [0.011, -1e-3, f64::NAN] {
            let round = refused(&[[-0.02, 0.01], [0.02, 0.01]], edge);
            assert!(matches!(round, ProfileError::EdgeTooRound { .. }));
        }
        // Three points on one line are a cone, not a hollow.
        assert!(SolidOfRevolution::new(&[[-0.01, 0.009], [0.0, 0.01], [0.01, 0.011]], 0.0).is_ok());
    }

    #[test]
    fn a_sampled_barrel_nears_the_barrel_with_the_square_of_the_spacing() {
        let barrel = super::super::Barrel::handing_over(0.05, 0.012, PI / 4.0, 9);
        // A point of the barrel's surface for every sphere: see `ilon_robot::barrel_profile`.
        let surface = |t: f64| {
            let k = barrel.sin_delta;
            let w = k * k * t / libm::hypot(barrel.ring_radius_m, k * t);
            let s = barrel.sphere_radius_m(t);
            [t + s * w, s * (1.0 - w * w).sqrt()]
        };
        let error_m = |count: usize| {
            let at = |i: usize| (2.0 * i as f64 / count as f64 - 1.0) * barrel.half_length_m;
            let points: Vec<[f64; 2]> = (0..=count).map(|i| surface(at(i))).collect();
            let turned = SolidOfRevolution::new(&points, 0.0).unwrap();
            let most = barrel.sin_delta * (PI / 9.0).sin();
            (-200..=200)
                .map(|i| most * f64::from(i) / 200.0)
                .map(|w| {
                    let t = barrel.support_place_m(w);
                    let exact_m = t * w + barrel.sphere_radius_m(t);
                    (exact_m - turned.profile().support_m(w)).abs()
                })
                .fold(0.0, f64::max)
        };
        let [coarse, middle, fine] = [8, 16, 32].map(error_m);
        for ratio in [coarse / middle, middle / fine] {
            // Order 2 means a ratio of 4; 401 directions do not hit each chord's worst.
            assert!(
                (3.6..4.4).contains(&ratio),
                "{coarse:e} {middle:e} {fine:e}"
            );
        }
    }
}
