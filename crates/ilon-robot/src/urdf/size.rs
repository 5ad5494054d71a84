//! What speaks for a wheel's size where its geometry does not show it.

use nalgebra::{Point3, Unit, Vector3};

use super::body::RigidBody;
use super::disc::NoDisc;
use super::tree::Tree;
use crate::error::Fault;

/// Wheels of robots, in metres: what lies outside is no guess worth making.
const PLAUSIBLE_M: std::ops::Range<f64> = 0.005..2.0;

/// The fault of a wheel whose size is not known, with a guess.
pub(super) fn unknown(
    tree: &Tree,
    origin: &Point3<f64>,
    axis: &Unit<Vector3<f64>>,
    body: &RigidBody,
    why: &NoDisc,
) -> Fault {
    let package = match why {
        NoDisc::Unreadable(Fault::PackageUnknown { package, .. }) => Some(package.clone()),
        _ => None,
    };
    Fault::WheelSizeUnknown {
        reason: Some(why.words()),
        guess: guess(tree, origin, axis, body),
        package,
    }
}

/// A radius that something else in the file speaks for: the height of the axis over the root frame, where that lies on the floor;
/// or the wheel's inertia about its axis, that of a solid disc.
fn guess(
    tree: &Tree,
    origin: &Point3<f64>,
    axis: &Unit<Vector3<f64>>,
    body: &RigidBody,
) -> Option<(f64, String)> {
    let root = &tree.links[tree.root].name;
    let rounded = |radius_m: f64| (1e4 * radius_m).round() / 1e4;
    if PLAUSIBLE_M.contains(&origin.z) {
        let why =
            format!("the height of its axis above the frame `{root}`, if that lies on the floor,");
        return Some((rounded(origin.z), why));
    }
    let mass = body.mass.as_ref()?;
    let axial = axis.dot(&(mass.inertia_kg_m2 * axis.into_inner()));
    let radius_m = (2.0 * axial / mass.mass_kg).sqrt();
    let why = "its inertia about its axis, if it is a solid disc,".to_owned();
    PLAUSIBLE_M
        .contains(&radius_m)
        .then(|| (rounded(radius_m), why))
}
