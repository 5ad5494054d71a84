//! The lowest point of a roller.
//!
//! A roller is the envelope of spheres with centres on its axis. Symbols: rho the wheel's radius, a
//! the distance between hub axis and roller axis, k the sine of the angle between them, t a place
//! on the roller's axis from its middle, s(t) the radius of the sphere there, L the distance
//! between the outermost centres, **n** the unit normal of the floor, w the component of the
//! roller's axis along **n**.
//!
//! A point of the roller's axis lies sqrt(a^2 + k^2 t^2) from the hub axis, and its sphere touches
//! the wheel's cylinder from inside: s(t) = rho - sqrt(a^2 + k^2 t^2). With k t = a tan(psi) that
//! is s = rho - a / cos(psi).
//!
//! The lowest point of the sphere at t lies h(t) = w t - s(t) above the roller's middle. h is
//! convex, because the root is, and its slope is w + k sin(psi): it is lowest at sin(psi) = -w / k,
//! or at an end if that place lies beyond it.

use ilon_robot::Barrel;

/// The spheres of one roller.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    /// rho, in metres.
    rho: f64,
    /// a, in metres.
    a: f64,
    /// k.
    k: f64,
    /// L / 2, in metres.
    half_length: f64,
}

/// The shape of what touches: a roller, or a ring of a tyre.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Shape {
    /// A roller.
    Barrel(Outline),
    /// A circle of this radius about the axis, thickened by a ball of the other, in metres.
    Ring { ring_m: f64, ball_m: f64 },
}

impl Shape {
    /// As [`Outline::lowest`]. The ring's lowest point lies at ring_m from the axis, straight down
    /// in the ring's plane; the sphere on the axis with that point has its centre where the line
    /// through it along the floor's normal meets the axis.
    pub fn lowest(&self, w: f64) -> Lowest {
        match self {
            Self::Barrel(outline) => outline.lowest(w),
            Self::Ring { ring_m, ball_m } => {
                // A wheel that lies on its side does not touch with its tyre.
                let across = (1.0 - w * w).max(1e-12).sqrt();
                Lowest {
                    place_m: ring_m * w / across,
                    radius_m: ring_m / across + ball_m,
                }
            }
        }
    }

    /// The outline of a roller; `None` for a ring.
    pub fn outline(&self) -> Option<&Outline> {
        match self {
            Self::Barrel(outline) => Some(outline),
            Self::Ring { .. } => None,
        }
    }

    /// As [`Outline::bound_m`].
    pub fn bound_m(&self) -> f64 {
        match self {
            Self::Barrel(outline) => outline.bound_m(),
            Self::Ring { ring_m, ball_m } => ring_m + ball_m,
        }
    }
}

/// The sphere of a roller that reaches lowest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lowest {
    /// Place t of its centre on the roller's axis, in metres.
    pub place_m: f64,
    /// Its radius, in metres.
    pub radius_m: f64,
}

impl Outline {
    /// The spheres of a barrel; only its four lengths are read.
    pub fn new(barrel: &Barrel) -> Self {
        Self {
            rho: barrel.wheel_radius_m,
            a: barrel.ring_radius_m,
            k: barrel.sin_delta,
            half_length: barrel.half_length_m,
        }
    }

    /// s(t), in metres.
    pub fn radius_m(&self, t: f64) -> f64 {
        self.rho - (self.a * self.a + (self.k * t) * (self.k * t)).sqrt()
    }

    /// The sphere that reaches lowest if the roller's axis has the component `w` along the floor's
    /// normal.
    pub fn lowest(&self, w: f64) -> Lowest {
        let sin_psi = -w / self.k;
        let t = if sin_psi.abs() < 1.0 {
            let tan_psi = sin_psi / (1.0 - sin_psi * sin_psi).sqrt();
            (self.a / self.k * tan_psi).clamp(-self.half_length, self.half_length)
        } else {
            self.half_length.copysign(sin_psi)
        };
        Lowest {
            place_m: t,
            radius_m: self.radius_m(t),
        }
    }

    /// L / 2, in metres.
    pub fn half_length_m(&self) -> f64 {
        self.half_length
    }

    /// An upper bound of the distance of the roller's points from its middle, in metres.
    pub fn bound_m(&self) -> f64 {
        self.half_length + self.rho - self.a
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outlines() -> Vec<Outline> {
        [
            (0.05, 0.012, 45.0_f64, 9),
            (0.05, 0.012, 0.0, 8),
            (0.1, 0.02, -60.0, 6),
        ]
        .map(|(rho, r, gamma_deg, n)| {
            Outline::new(&Barrel::handing_over(rho, r, gamma_deg.to_radians(), n))
        })
        .to_vec()
    }

    #[test]
    fn the_lowest_sphere_is_the_lowest_of_many() {
        for outline in outlines() {
            for i in -100..=100 {
                let w = f64::from(i) / 100.0;
                let height = |t: f64| w * t - outline.radius_m(t);
                let found = outline.lowest(w);
                let many =
                    (-4000..=4000).map(|j| height(outline.half_length * f64::from(j) / 4000.0));
                let lowest = many.fold(f64::INFINITY, f64::min);
                let excess = lowest - height(found.place_m);
                // The closed form is never above the best of the sampled places, except for
                // rounding, and below it by at most h'' (spacing / 2)^2 / 2 with
                // h'' <= k^2 / a < 27 / m and a spacing of less than 18 um: 1e-9 m.
                assert!((-1e-16..1e-9).contains(&excess), "{excess} at w = {w}");
            }
        }
    }

    /// Of a tilted circle of 0.1 m, thickened by 0.01 m, no point is lower.
    #[test]
    fn the_lowest_point_of_a_ring_is_the_lowest_of_many() {
        let (ring_m, ball_m) = (0.1, 0.01);
        let ring = Shape::Ring { ring_m, ball_m };
        for i in -90..=90 {
            let w = f64::from(i) / 100.0;
            let across = (1.0 - w * w).sqrt();
            let Lowest { place_m, radius_m } = ring.lowest(w);
            // Heights over the middle: a point of the circle at the angle t from straight down.
            let height = |t: f64| -ring_m * t.cos() * across - ball_m;
            let many = (-3000..=3000).map(|j| height(f64::from(j) / 3000.0));
            let lowest = many.fold(f64::INFINITY, f64::min);
            assert!((w * place_m - radius_m - lowest).abs() < 1e-15, "{w}");
        }
    }

    #[test]
    fn a_turning_wheel_stays_as_high_as_its_radius() {
        // A roller at the angle phi from straight down: middle a cos(phi) below the hub axis, axis
        // tilted by k sin(phi).
        for (outline, n) in outlines().into_iter().zip([9, 8, 6]) {
            for i in -50..=50 {
                let phi = std::f64::consts::PI / f64::from(n) * f64::from(i) / 50.0;
                for sign in [-1.0, 1.0] {
                    let w = sign * outline.k * phi.sin();
                    let Lowest { place_m, radius_m } = outline.lowest(w);
                    let depth_m = outline.a * phi.cos() - w * place_m + radius_m;
                    // Several rounding errors of numbers of 0.1.
                    assert!((depth_m - outline.rho).abs() < 1e-15, "{depth_m}");
                }
            }
        }
    }
}
