//! Finds inertias that are impossible or implausible for the mass and the shapes of their link.
//!
//! A radius of gyration never exceeds the reach from the centre of mass. An inertia beyond that,
//! below a hundredth of a solid's, or with moments of other axes is remarked, and repaired from the
//! shapes if requested.

use nalgebra::{Matrix3, SymmetricEigen, Unit, Vector3};

use super::body::RigidBody;
use super::faults::Faults;
use super::inertia_from_shapes;
use super::loading::Loading;
use crate::error::{Fault, RobotError};
use crate::model::{MassProperties, Remark};

/// Share of a solid's moments below which an inertia is doubted: a body with all mass within a
/// tenth of its size.
const LEAST_SHARE: f64 = 0.01;
/// Relative rounding error of a radius of gyration.
const ROUNDED: f64 = 1e-3;

/// A wheel's axis and radius in metres, if the file models no rollers on it.
pub(super) type AsWheel<'a> = Option<(&'a Unit<Vector3<f64>>, f64)>;

/// Checks the inertias of a body's links. If repairs are requested and a link has shapes for them,
/// a doubt is a fault.
///
/// # Errors
/// Inertias to repair.
pub(super) fn check(
    loading: &mut Loading,
    body: &RigidBody,
    wheel: AsWheel,
) -> Result<(), RobotError> {
    let (source, tree) = (loading.source, loading.tree);
    let mut faults = Faults::default();
    for &link in &body.links {
        let of = &tree.links[link];
        let Some(mass) = &of.mass else { continue };
        let solid = tree.solid_of(link, source);
        let by_shape = solid.as_ref().and_then(|solid| by_shape(mass, solid));
        let wheel = wheel.filter(|_| body.links.len() == 1);
        let Some(fault) = by_shape.or_else(|| as_wheel(mass, wheel?)) else {
            continue;
        };
        if loading.options.repair && solid.is_some() {
            faults.push(source.inertial_error(&of.name, fault));
        } else {
            loading.remarks.push(doubtful(&of.name, &fault));
        }
    }
    faults.into_result()
}

/// Returns the remark on a link with a doubtful inertia.
pub(super) fn doubtful(link: &str, fault: &Fault) -> Remark {
    Remark::new(
        format!("link `{link}`"),
        format!("its inertia is doubtful: {fault}"),
    )
}

/// Returns the fault of an inertia that no solid of the link's shapes can have; everything in the
/// body frame.
fn by_shape(mass: &MassProperties, (solid, reach_m): &(MassProperties, f64)) -> Option<Fault> {
    if let Some(fault) = by_gyration(mass, *reach_m, solid.gyration_m()) {
        return Some(fault);
    }
    are_exchanged(&mass.inertia_kg_m2, &solid.inertia_kg_m2).then_some(Fault::InertiaExchanged)
}

/// Returns the fault of a radius of gyration beyond a factor of the reach, in metres.
pub(super) fn beyond_reach(mass: &MassProperties, reach_m: f64, factor: f64) -> Option<Fault> {
    let gyration_m = mass.gyration_m();
    (gyration_m > factor * reach_m * (1.0 + ROUNDED)).then_some(Fault::InertiaTooLarge {
        mass_kg: mass.mass_kg,
        gyration_m,
        reach_m,
    })
}

/// Returns the fault of a radius of gyration beyond the reach, or far below that of a solid, both in
/// metres.
fn by_gyration(mass: &MassProperties, reach_m: f64, solid_m: f64) -> Option<Fault> {
    let gyration_m = mass.gyration_m();
    let too_small = || {
        (gyration_m * gyration_m < LEAST_SHARE * solid_m * solid_m).then_some(
            Fault::InertiaTooSmall {
                mass_kg: mass.mass_kg,
                gyration_m,
                solid_m,
            },
        )
    };
    beyond_reach(mass, reach_m, 1.0).or_else(too_small)
}

/// Whether moments are those of a solid about other axes, up to a factor.
fn are_exchanged(inertia: &Matrix3<f64>, solid: &Matrix3<f64>) -> bool {
    /// Moments that differ by less than this factor count as equal, by more as different.
    const ALIKE: f64 = 1.15;
    const UNLIKE: f64 = 1.3;
    const ORDERS: [[usize; 3]; 5] = [[0, 2, 1], [1, 0, 2], [2, 1, 0], [1, 2, 0], [2, 0, 1]];
    let eigen = SymmetricEigen::new(*solid);
    let axes = eigen.eigenvectors;
    let own = (axes.transpose() * inertia * axes).diagonal() / inertia.trace();
    let solid = eigen.eigenvalues / solid.trace();
    let off = |order: [usize; 3]| {
        let each = (0..3).map(|i| {
            let ratio = own[order[i]] / solid[i];
            ratio.max(1.0 / ratio)
        });
        each.fold(1.0, f64::max)
    };
    off([0, 1, 2]) > UNLIKE && ORDERS.into_iter().any(|order| off(order) < ALIKE)
}

/// Returns the fault of an inertia that is implausible for any wheel: a disc's moments about
/// another axis, or nearly zero.
fn as_wheel(mass: &MassProperties, (axis, radius_m): (&Unit<Vector3<f64>>, f64)) -> Option<Fault> {
    /// Moments that differ by less than this share are meant to be equal.
    const SAME: f64 = 0.02;
    const OTHER: f64 = 0.1;
    /// Smallest ratio of a wheel's moment about its axle to that across: a solid cylinder three
    /// times as long as its radius.
    const THIN: f64 = 0.5;
    let axial = axis.dot(&(mass.inertia_kg_m2 * axis.into_inner()));
    let [least, middle, most] = mass.principal_moments_kg_m2();
    if let Some(fault) = by_gyration(mass, radius_m, radius_m * 0.5_f64.sqrt()) {
        return Some(fault);
    }
    let is_disc = middle - least < SAME * middle && most - middle > OTHER * most;
    if is_disc && (axial - least).abs() < SAME * least {
        return Some(Fault::InertiaExchanged);
    }
    // A solid cylinder as long as its diameter has 6 / 7 of its transverse moment about its axle.
    let across_kg_m2 = 0.5 * (mass.inertia_kg_m2.trace() - axial);
    (axial < THIN * across_kg_m2).then_some(Fault::InertiaThinAboutAxle {
        axial_kg_m2: axial,
        across_kg_m2,
    })
}

impl super::tree::Tree {
    /// Returns the solid of a link's shapes in the body frame, with its mass, and the shapes'
    /// largest distance from the link's centre of mass, in metres; `None` for a link with meshes or
    /// without shapes.
    fn solid_of(
        &self,
        link: usize,
        source: &super::source::Source,
    ) -> Option<(MassProperties, f64)> {
        let of = &self.links[link];
        let mass = of.mass.as_ref()?;
        let all = || of.shapes.iter().chain(&of.visuals);
        let is_mesh = |shape: &super::tree::PlacedShape| {
            matches!(shape.geometry, urdf_rs::Geometry::Mesh { .. })
        };
        if all().any(is_mesh) {
            return None;
        }
        let solid = inertia_from_shapes::of_link(source.named("link", &of.name)?)?;
        let reach_m = self.lone_body(link).reach_m(&mass.center_of_mass_m);
        let solid = solid.weighing(mass.mass_kg).moved(&of.body_from_link);
        Some((solid, reach_m))
    }
}
