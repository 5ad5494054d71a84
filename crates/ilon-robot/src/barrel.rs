//! The exact roller: the barrel that makes a wheel's outline a perfect circle.
//!
//! Symbols: rho the wheel's radius, r the roller's largest radius, a = rho - r the distance between hub axis and
//! roller axis, delta = 90 deg - |gamma| the angle between them, n the number of rollers in a row, L the roller's
//! length, t a place along the roller's axis from its middle.
//!
//! The barrel is the envelope of spheres centred on the roller's axis at t in [-L/2, L/2], each touching the wheel's
//! outline from inside: s(t) = rho - sqrt(a^2 + t^2 sin^2 delta).

use std::f64::consts::PI;

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
    /// The barrel for a wheel of radius rho with `roller_count` rollers in a row of largest radius
    /// `roller_radius_m`, its length such that neighbours hand over with neither gap nor overlap:
    /// L = 2 a tan(pi/n) / sin delta.
    pub fn handing_over(
        wheel_radius_m: f64,
        roller_radius_m: f64,
        gamma_rad: f64,
        roller_count: usize,
    ) -> Self {
        let ring_radius_m = wheel_radius_m - roller_radius_m;
        let sin_delta = gamma_rad.cos();
        let half_length_m = ring_radius_m * (PI / roller_count as f64).tan() / sin_delta;
        Self {
            wheel_radius_m,
            ring_radius_m,
            sin_delta,
            half_length_m,
        }
    }

    /// Radius s(t) of the sphere centred `t_m` along the axis, in metres.
    pub fn sphere_radius_m(&self, t_m: f64) -> f64 {
        self.wheel_radius_m - self.ring_radius_m.hypot(t_m * self.sin_delta)
    }

    /// The place t* of the sphere that reaches furthest along a unit direction **w** with component `w_axial` along
    /// the barrel's axis, in metres. The support point is t* along the axis plus s(t*) **w**.
    ///
    /// From d/dt (t w_x + s(t)) = 0 with k = sin delta: t* = w_x a / (k sqrt(k^2 - w_x^2)), held to [-L/2, L/2];
    /// where |w_x| >= k the end sphere reaches furthest.
    pub fn support_place_m(&self, w_axial: f64) -> f64 {
        let k = self.sin_delta;
        let under_root = k * k - w_axial * w_axial;
        if under_root <= 0.0 {
            return self.half_length_m.copysign(w_axial);
        }
        let t_m = w_axial * self.ring_radius_m / (k * under_root.sqrt());
        t_m.clamp(-self.half_length_m, self.half_length_m)
    }
}
