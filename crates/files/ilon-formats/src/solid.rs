//! Solids of uniform density: volume and moments of inertia.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use crate::model::MassProperties;

/// A solid of uniform density, with its middle at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Solid {
    /// A box with sides along the axes.
    Box {
        /// Its sides, in metres.
        size_m: Vector3<f64>,
    },
    /// A cylinder along z.
    Cylinder {
        /// Radius in metres.
        radius_m: f64,
        /// Length along z, in metres.
        length_m: f64,
    },
    /// A capsule along z.
    Capsule {
        /// Radius in metres.
        radius_m: f64,
        /// Length of the cylindrical part along z, in metres.
        length_m: f64,
    },
    /// An ellipsoid with its axes along those of the frame.
    Ellipsoid {
        /// Half of each axis, in metres.
        half_axes_m: Vector3<f64>,
    },
}

impl Solid {
    /// A ball of a radius in metres.
    pub(crate) fn ball(radius_m: f64) -> Self {
        Self::Ellipsoid {
            half_axes_m: Vector3::repeat(radius_m),
        }
    }

    /// Returns its volume, in m^3.
    pub(crate) fn volume_m3(&self) -> f64 {
        match *self {
            Self::Box { size_m } => size_m.product(),
            Self::Cylinder { radius_m, length_m } => PI * radius_m * radius_m * length_m,
            Self::Capsule { radius_m, length_m } => {
                let [rod, ball] = parts_of_capsule(radius_m, length_m);
                rod.volume_m3() + ball.volume_m3()
            }
            Self::Ellipsoid { half_axes_m } => 4.0 / 3.0 * PI * half_axes_m.product(),
        }
    }

    /// Returns its moments of inertia about the axes of its frame for a mass in kg, in kg m^2.
    pub(crate) fn moments_kg_m2(&self, mass_kg: f64) -> Vector3<f64> {
        let across = |s: Vector3<f64>| {
            Vector3::new(
                s.y * s.y + s.z * s.z,
                s.x * s.x + s.z * s.z,
                s.x * s.x + s.y * s.y,
            )
        };
        match *self {
            Self::Box { size_m } => across(size_m) * (mass_kg / 12.0),
            Self::Cylinder { radius_m, length_m } => {
                let across = mass_kg * (3.0 * radius_m * radius_m + length_m * length_m) / 12.0;
                Vector3::new(across, across, 0.5 * mass_kg * radius_m * radius_m)
            }
            Self::Capsule { radius_m, length_m } => {
                let [rod, ball] = parts_of_capsule(radius_m, length_m);
                let ball_kg = mass_kg * ball.volume_m3() / self.volume_m3();
                // A half of a ball has its centre of mass 3/8 of the radius from its flat side.
                let beyond = ball_kg * length_m * (length_m / 4.0 + 0.375 * radius_m);
                rod.moments_kg_m2(mass_kg - ball_kg)
                    + ball.moments_kg_m2(ball_kg)
                    + Vector3::new(beyond, beyond, 0.0)
            }
            Self::Ellipsoid { half_axes_m } => across(half_axes_m) * (mass_kg / 5.0),
        }
    }

    /// Returns its mass properties for a mass in kg.
    pub(crate) fn weighing(&self, mass_kg: f64) -> MassProperties {
        MassProperties {
            mass_kg,
            center_of_mass_m: Vector3::zeros(),
            inertia_kg_m2: Matrix3::from_diagonal(&self.moments_kg_m2(mass_kg)),
        }
    }
}

/// The cylinder between a capsule's ends, and the ball that both ends make together.
fn parts_of_capsule(radius_m: f64, length_m: f64) -> [Solid; 2] {
    [
        Solid::Cylinder { radius_m, length_m },
        Solid::ball(radius_m),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume and moments of a body of revolution about z by slices: a disc of radius r has the
    /// area pi r^2, and of its second moments pi r^4 / 4 across and pi r^4 / 2 along. Simpson's
    /// rule is exact for these polynomials of degree 5 at most, on each side of the middle and of a
    /// capsule's seams: degree 3 exactly, and of degree 4 with 2000 slices an error of 1e-13.
    fn by_slices(radius_at_m: impl Fn(f64) -> f64, ends_m: &[f64]) -> (f64, Vector3<f64>) {
        const SLICES: usize = 2000;
        let mut sums = [0.0; 3];
        for part in ends_m.windows(2) {
            let step_m = (part[1] - part[0]) / SLICES as f64;
            for i in 0..=SLICES {
                let z_m = part[0] + step_m * i as f64;
                let weight = match i {
                    0 | SLICES => 1.0,
                    i if i % 2 == 1 => 4.0,
                    _ => 2.0,
                } * step_m
                    / 3.0;
                let square = radius_at_m(z_m).powi(2);
                sums[0] += weight * PI * square;
                sums[1] += weight * (PI * square * square / 4.0 + PI * square * z_m * z_m);
                sums[2] += weight * PI * square * square / 2.0;
            }
        }
        let [volume_m3, across, along] = sums;
        (volume_m3, Vector3::new(across, across, along))
    }

    #[test]
    fn bodies_of_revolution_weigh_what_their_slices_do() {
        let (r, l) = (0.03_f64, 0.1_f64);
        let cap = |z: f64| (r * r - z * z).max(0.0).sqrt();
        let cylinder = Solid::Cylinder {
            radius_m: r,
            length_m: l,
        };
        let capsule = Solid::Capsule {
            radius_m: r,
            length_m: l,
        };
        let ellipsoid = Solid::Ellipsoid {
            half_axes_m: Vector3::new(r, r, 2.0 * r),
        };
        let h = 0.5 * l;
        let cases = [
            (cylinder, by_slices(|_| r, &[-h, h])),
            (
                capsule,
                by_slices(|z| cap((z.abs() - h).max(0.0)), &[-h - r, -h, h, h + r]),
            ),
            (Solid::ball(r), by_slices(cap, &[-r, r])),
            (ellipsoid, by_slices(|z| cap(0.5 * z), &[-2.0 * r, 2.0 * r])),
        ];
        for (solid, (volume_m3, moments)) in cases {
            // Thousands of sums round.
            assert!(
                (solid.volume_m3() / volume_m3 - 1.0).abs() < 1e-11,
                "{solid:?}"
            );
            // A density of 1 kg/m^3.
            let own = solid.moments_kg_m2(volume_m3);
            assert!(
                (own - moments).norm() < 1e-11 * moments.norm(),
                "{solid:?} {own} {moments}"
            );
        }
    }

    #[test]
    fn a_box_has_a_twelfth_of_the_squares_of_its_sides_across() {
        let size_m = Vector3::new(0.2, 0.3, 0.6);
        let solid = Solid::Box { size_m };
        assert!((solid.volume_m3() - 0.036).abs() < 1e-16);
        let expected = Vector3::new(0.09 + 0.36, 0.04 + 0.36, 0.04 + 0.09) / 4.0;
        assert!((solid.weighing(3.0).inertia_kg_m2.diagonal() - expected).norm() < 1e-15);
    }
}
