//! The ideal roller: the barrel that makes a wheel's outline a perfect circle.
//!
//! Symbols: rho the wheel's radius, r the roller's largest radius, a = rho - r the distance between
//! hub axis and roller axis, delta = 90 deg - |gamma| the angle between them, n the number of
//! rollers in a row, L the roller's length, t a position along the roller's axis from its middle.
//!
//! The barrel is the envelope of spheres centred on the roller's axis at t in [-L/2, L/2], each
//! touching the wheel's outline from inside: s(t) = rho - sqrt(a^2 + t^2 sin^2 delta).

use std::f64::consts::PI;

use super::solid_of_revolution::moments_of_slices;

/// The barrel's profile in its own frame: sphere radius along the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrel {
    /// The wheel's radius rho, in metres.
    pub wheel_radius_m: f64,
    /// Distance a between hub axis and roller axis, in metres.
    pub ring_radius_m: f64,
    /// sin delta = cos gamma, in (0, 1].
    pub sin_delta: f64,
    /// Half of the length L between the centres of the outermost spheres, in metres.
    pub half_length_m: f64,
}

impl Barrel {
    /// Returns the barrel for a wheel of radius rho with `roller_count` rollers in a row of largest
    /// radius `roller_radius_m`. Its length makes neighbours hand over with neither gap nor
    /// overlap: L = 2 a tan(pi/n) / sin delta.
    pub fn handing_over(
        wheel_radius_m: f64,
        roller_radius_m: f64,
        gamma_rad: f64,
        roller_count: usize,
    ) -> Self {
        let ring_radius_m = wheel_radius_m - roller_radius_m;
        let sin_delta = libm::cos(gamma_rad);
        let half_length_m = ring_radius_m * libm::tan(PI / roller_count as f64) / sin_delta;
        Self {
            wheel_radius_m,
            ring_radius_m,
            sin_delta,
            half_length_m,
        }
    }

    /// Returns the radius s(t) of the sphere centred `t_m` along the axis, in metres.
    pub fn sphere_radius_m(&self, t_m: f64) -> f64 {
        self.wheel_radius_m - libm::hypot(self.ring_radius_m, t_m * self.sin_delta)
    }

    /// Returns the radius of curvature of the outline along the barrel, at its middle, in metres:
    /// rho - a + a / k^2. Near the middle s(t) = r - t^2 k^2 / 2a, and the envelope of such spheres
    /// has the radius r + a / k^2.
    pub fn crown_radius_m(&self) -> f64 {
        let k2 = self.sin_delta * self.sin_delta;
        self.wheel_radius_m - self.ring_radius_m + self.ring_radius_m / k2
    }

    /// Returns the position t* along the axis of the sphere that reaches furthest in a unit
    /// direction **w** with component `w_axial` along the barrel's axis, in metres. The support
    /// point is t* along the axis plus s(t*) **w**.
    ///
    /// From d/dt (t w_x + s(t)) = 0 with k = sin delta: t* = w_x a / (k sqrt(k^2 - w_x^2)), clamped
    /// to [-L/2, L/2]; where |w_x| >= k the end sphere reaches furthest.
    pub fn support_place_m(&self, w_axial: f64) -> f64 {
        let k = self.sin_delta;
        let under_root = k * k - w_axial * w_axial;
        if under_root <= 0.0 {
            return self.half_length_m.copysign(w_axial);
        }
        let t_m = w_axial * self.ring_radius_m / (k * under_root.sqrt());
        t_m.clamp(-self.half_length_m, self.half_length_m)
    }

    /// Returns the radius of curvature of the outline along the barrel, in metres, at the support
    /// point of a unit direction with component `w_axial` along the barrel's axis: s(t*) + (1 -
    /// w_x^2) dt*/dw_x, with dt*/dw_x = a k / (k^2 - w_x^2)^(3/2); on the end spheres s alone.
    ///
    /// Tilting by dw_x / sqrt(1 - w_x^2) moves the support, in the centre's frame, to a sphere dt*
    /// further along the axis, of which sqrt(1 - w_x^2) lies along the outline; on a fixed sphere
    /// it moves by s per radian.
    pub fn outline_radius_m(&self, w_axial: f64) -> f64 {
        let (k, t_m) = (self.sin_delta, self.support_place_m(w_axial));
        let on_end = t_m.abs() >= self.half_length_m;
        let under_root = k * k - w_axial * w_axial;
        let slope_m = self.ring_radius_m * k / (under_root * under_root.sqrt());
        let of_place_m = if on_end {
            0.0
        } else {
            (1.0 - w_axial * w_axial) * slope_m
        };
        self.sphere_radius_m(t_m) + of_place_m
    }

    /// Returns the radius of the barrel's surface `z_m` along the axis from its middle, in metres:
    /// the largest circle that any of the spheres cuts there.
    ///
    /// The square of a sphere's circle, s(t)^2 - (z - t)^2 with s(t) = rho - h(t), h = sqrt(a^2 +
    /// k^2 t^2), has the second derivative -2 rho h'' - 2 (1 - k^2) < 0: among evenly spaced
    /// spheres hill climbing finds the largest, from near t (1 + k^2 s / a) = z.
    pub fn surface_radius_m(&self, z_m: f64) -> f64 {
        const PLACES: usize = 400;
        let squared = |i: usize| {
            let t = self.half_length_m * (2.0 * i as f64 / PLACES as f64 - 1.0);
            self.sphere_radius_m(t).powi(2) - (z_m - t).powi(2)
        };
        let steepness =
            self.sin_delta * self.sin_delta * self.sphere_radius_m(0.0) / self.ring_radius_m;
        let near = z_m / (1.0 + steepness) / self.half_length_m;
        let mut i = (0.5 * (near + 1.0) * PLACES as f64).clamp(0.0, PLACES as f64) as usize;
        while i < PLACES && squared(i + 1) > squared(i) {
            i += 1;
        }
        while i > 0 && squared(i - 1) > squared(i) {
            i -= 1;
        }
        squared(i).max(0.0).sqrt()
    }

    /// Returns the volume of the barrel cut flat at +-L/2, in m^3: the sum of its slices.
    pub fn volume_m3(&self) -> f64 {
        let slices: f64 = self.slices().map(|(_, r)| PI * r * r).sum();
        slices * 2.0 * self.half_length_m / SLICES as f64
    }

    /// Returns the moments of inertia about its centre of a barrel of uniform density, cut flat at
    /// +-L/2: about its axis, and about any axis across it, in kg m^2.
    pub fn solid_moments_kg_m2(&self, mass_kg: f64) -> (f64, f64) {
        moments_of_slices(self.slices(), mass_kg)
    }

    /// Returns middle and radius of evenly spaced slices from end to end, in metres.
    fn slices(&self) -> impl Iterator<Item = (f64, f64)> {
        (0..SLICES).map(|i| {
            let z = self.half_length_m * (2.0 * (i as f64 + 0.5) / SLICES as f64 - 1.0);
            (z, self.surface_radius_m(z))
        })
    }
}

/// Number of slices of a barrel; the error of their sums is of the order of one over its square.
const SLICES: usize = 400;

#[cfg(test)]
mod tests {
    use super::*;

    /// Hill climbing finds the largest of all spheres, to the bit: for thick and thin rollers at
    /// any angle, longer and shorter ones, also beyond their ends.
    #[test]
    fn the_largest_sphere_that_is_climbed_to_is_the_largest_of_all() {
        for (thick, gamma_deg, count, longer) in [
            (0.24, 45.0, 9, 1.0),
            (0.1, 0.0, 12, 1.3),
            (0.45, 70.0, 6, 1.1),
            (0.3, -60.0, 16, 0.5),
            (0.2, 5.0, 8, 1.0),
        ] {
            let mut barrel =
                Barrel::handing_over(0.05, 0.05 * thick, f64::to_radians(gamma_deg), count);
            barrel.half_length_m *= longer;
            for k in -60..=60 {
                let z_m = barrel.half_length_m * f64::from(k) / 50.0;
                let squared = |i: i32| {
                    let t = barrel.half_length_m * (2.0 * f64::from(i) / 400.0 - 1.0);
                    barrel.sphere_radius_m(t).powi(2) - (z_m - t).powi(2)
                };
                let largest = (0..=400).map(squared).fold(0.0, f64::max).sqrt();
                assert_eq!(barrel.surface_radius_m(z_m), largest, "{barrel:?} at {z_m}");
            }
        }
    }

    #[test]
    fn the_barrel_touches_the_wheels_circle_at_every_angle() {
        // A wheel of 50 mm with nine rollers at 45 deg. At wheel angle phi the roller's axis has
        // the component k sin(phi) along the downward direction, and its reach is a cos(phi) + t*
        // w + s(t*).
        let barrel = Barrel::handing_over(0.05, 0.012, PI / 4.0, 9);
        for i in -20..=20 {
            let phi = PI / 9.0 * f64::from(i) / 20.0;
            let w = barrel.sin_delta * phi.sin();
            let t = barrel.support_place_m(w);
            let reach_m = barrel.ring_radius_m * phi.cos() + t * w + barrel.sphere_radius_m(t);
            // A few roundings of numbers below 0.1.
            assert!((reach_m - 0.05).abs() < 1e-16, "{reach_m} at {phi}");
        }
    }

    #[test]
    fn the_outline_is_as_curved_as_its_places_move() {
        // Without tilt (k = 1) the outline is the wheel's circle; at the middle of any barrel the
        // radius is the crown's; on the end spheres theirs. In between, turning the direction by d
        // moves the support point by the radius times d along the outline.
        let swedish = Barrel::handing_over(0.05, 0.012, 0.0, 9);
        for w in [0.0, 0.1, -0.3] {
            assert!((swedish.outline_radius_m(w) - 0.05).abs() < 1e-15);
        }
        let barrel = Barrel::handing_over(0.05, 0.012, PI / 4.0, 9);
        assert!((barrel.outline_radius_m(0.0) - barrel.crown_radius_m()).abs() < 1e-15);
        let end_m = barrel.sphere_radius_m(barrel.half_length_m);
        assert!((barrel.outline_radius_m(0.6) - end_m).abs() < 1e-15);
        let place_m = |angle: f64| {
            let (w, across) = angle.sin_cos();
            let t_m = barrel.support_place_m(w);
            let s_m = barrel.sphere_radius_m(t_m);
            (t_m + s_m * w, s_m * across)
        };
        let (angle, step): (f64, f64) = (0.15, 1e-5);
        let ((t0, r0), (t1, r1)) = (place_m(angle - step), place_m(angle + step));
        let moved_m = (t1 - t0).hypot(r1 - r0) / (2.0 * step);
        // A central difference: the step's square.
        assert!((barrel.outline_radius_m(angle.sin()) - moved_m).abs() < 1e-8);
    }

    #[test]
    fn a_short_thick_barrel_weighs_as_a_cylinder() {
        // If a barrel is much shorter than its wheel, its radius hardly changes from end to end: a
        // cylinder of radius r and length L has the volume pi r^2 L and the moments m r^2 / 2 and m
        // (3 r^2 + L^2) / 12.
        let (r, half) = (0.4, 0.01);
        let barrel = Barrel {
            wheel_radius_m: 1.0,
            ring_radius_m: 1.0 - r,
            sin_delta: 1.0,
            half_length_m: half,
        };
        // s falls by t^2 / 2a = 8e-5 at the ends, a relative 2e-4 of r; its fourth power enters.
        let within = 1e-3;
        let length = 2.0 * half;
        assert!((barrel.volume_m3() / (PI * r * r * length) - 1.0).abs() < within);
        let (axial, across) = barrel.solid_moments_kg_m2(2.0);
        assert!((axial / (2.0 * r * r / 2.0) - 1.0).abs() < within);
        let cylinder = 2.0 * (3.0 * r * r + length * length) / 12.0;
        assert!((across / cylinder - 1.0).abs() < within);
    }
}
