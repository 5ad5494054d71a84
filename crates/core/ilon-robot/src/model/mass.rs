//! Mass, centre of mass and inertia.

use nalgebra::{Isometry3, Matrix3, Point3, SymmetricEigen, Vector3};

/// Mass, centre and inertia of one rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct MassProperties {
    /// Mass in kg, > 0.
    pub mass_kg: f64,
    /// Centre of mass in the body's own frame, in metres.
    pub center_of_mass_m: Vector3<f64>,
    /// Inertia about the centre of mass, along the axes of the body's own frame, in kg m^2.
    pub inertia_kg_m2: Matrix3<f64>,
}

impl MassProperties {
    /// Merges rigidly joined bodies, all given in one frame, into one; `None` if their total mass
    /// is zero.
    ///
    /// Their inertias are added about the common centre of mass (see [`Self::inertia_about`]).
    pub fn merged(parts: &[Self]) -> Option<Self> {
        let mass_kg: f64 = parts.iter().map(|part| part.mass_kg).sum();
        if mass_kg <= 0.0 {
            return None;
        }
        let first_moment: Vector3<f64> = parts
            .iter()
            .map(|part| part.center_of_mass_m * part.mass_kg)
            .sum();
        let center_of_mass_m = first_moment / mass_kg;
        Some(Self {
            mass_kg,
            center_of_mass_m,
            inertia_kg_m2: parts
                .iter()
                .map(|part| part.inertia_about(&center_of_mass_m))
                .sum(),
        })
    }

    /// A point mass, in kg and metres.
    pub fn point(mass_kg: f64, place_m: Vector3<f64>) -> Self {
        Self {
            mass_kg,
            center_of_mass_m: place_m,
            inertia_kg_m2: Matrix3::zeros(),
        }
    }

    /// Returns a body that weighs another mass in kg, spread in the same way.
    pub fn weighing(&self, mass_kg: f64) -> Self {
        Self {
            mass_kg,
            center_of_mass_m: self.center_of_mass_m,
            inertia_kg_m2: self.inertia_kg_m2 * (mass_kg / self.mass_kg),
        }
    }

    /// Returns the same body in another frame: I' = R I R^T, c' = R c + p.
    pub fn moved(&self, to_from: &Isometry3<f64>) -> Self {
        let r = to_from.rotation.to_rotation_matrix();
        Self {
            mass_kg: self.mass_kg,
            center_of_mass_m: to_from * Point3::from(self.center_of_mass_m) - Point3::origin(),
            inertia_kg_m2: r.matrix() * self.inertia_kg_m2 * r.matrix().transpose(),
        }
    }

    /// Returns the inertia about a point of the body's frame, along its axes, in kg m^2, by the
    /// parallel-axis theorem (Huygens and Steiner): I + m (|d|^2 1 - d d^T), with d from the point
    /// to the centre of mass.
    pub fn inertia_about(&self, point_m: &Vector3<f64>) -> Matrix3<f64> {
        self.inertia_kg_m2 + self.inertia_of_place(point_m)
    }

    /// Returns the part of the inertia about a point due to the body's position: that of all its
    /// mass at its centre, in kg m^2.
    pub fn inertia_of_place(&self, point_m: &Vector3<f64>) -> Matrix3<f64> {
        let d = self.center_of_mass_m - point_m;
        (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * self.mass_kg
    }

    /// Returns the radius of gyration about the centre of mass, in metres: sqrt(I / m) of the
    /// largest principal moment.
    pub fn gyration_m(&self) -> f64 {
        let [_, _, most] = self.principal_moments_kg_m2();
        (most / self.mass_kg).sqrt()
    }

    /// Returns the principal moments of inertia about the centre of mass, smallest first, in kg
    /// m^2.
    pub fn principal_moments_kg_m2(&self) -> [f64; 3] {
        principal_moments(self.inertia_kg_m2)
    }
}

/// Returns the eigenvalues of an inertia, smallest first.
pub fn principal_moments(inertia: Matrix3<f64>) -> [f64; 3] {
    let mut moments = SymmetricEigen::new(inertia).eigenvalues;
    moments.as_mut_slice().sort_by(f64::total_cmp);
    moments.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rod(mass_kg: f64, length_m: f64, center_of_mass_m: Vector3<f64>) -> MassProperties {
        let across = mass_kg * length_m * length_m / 12.0;
        MassProperties {
            mass_kg,
            center_of_mass_m,
            inertia_kg_m2: Matrix3::from_diagonal(&Vector3::new(0.0, across, across)),
        }
    }

    #[test]
    fn two_halves_of_a_rod_make_the_rod() {
        let halves = [-0.25, 0.25].map(|x_m| rod(1.0, 0.5, Vector3::new(x_m, 0.0, 0.3)));
        let whole = MassProperties::merged(&halves).unwrap();
        let expected = rod(2.0, 1.0, Vector3::new(0.0, 0.0, 0.3));
        assert_eq!(whole.mass_kg, 2.0);
        assert_eq!(whole.center_of_mass_m, expected.center_of_mass_m);
        // 2 (1/12 0.5^2 + 0.25^2) = 2/12: one rounding each.
        assert!((whole.inertia_kg_m2 - expected.inertia_kg_m2).norm() < 1e-15);
        assert_eq!(MassProperties::merged(&[]), None);
    }

    #[test]
    fn a_rod_about_its_end_has_a_third_of_m_l_squared() {
        let rod = rod(3.0, 0.4, Vector3::zeros());
        let about_end = rod.inertia_about(&Vector3::new(0.2, 0.0, 0.0));
        assert!((about_end.m33 - 3.0 * 0.4 * 0.4 / 3.0).abs() < 1e-15);
        assert_eq!(about_end.m11, 0.0);
        let [least, middle, most] = rod.principal_moments_kg_m2();
        assert_eq!(least, 0.0);
        assert!((middle - 0.04).abs() < 1e-15 && (most - 0.04).abs() < 1e-15);
    }

    #[test]
    fn a_body_that_is_moved_keeps_its_moments() {
        let turn = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, -0.2, 0.9));
        let moved = rod(2.0, 1.0, Vector3::new(0.1, 0.0, 0.0)).moved(&turn);
        let at = turn * Point3::new(0.1, 0.0, 0.0);
        assert!((moved.center_of_mass_m - at.coords).norm() < 1e-15);
        for (moment, expected) in
            moved
                .principal_moments_kg_m2()
                .iter()
                .zip([0.0, 2.0 / 12.0, 2.0 / 12.0])
        {
            assert!((moment - expected).abs() < 1e-15);
        }
    }
}
