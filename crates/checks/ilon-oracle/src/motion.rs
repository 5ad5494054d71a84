//! Momenta and energy of a motion.

use nalgebra::{Matrix3, Vector3};

use crate::dynamics::roller_inertia;
use crate::generalised::Generalised;
use crate::posture::{Carried, Posture};
use crate::tree::Tree;

/// Momenta and kinetic energy, summed body by body, without the mass matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Kinetic energy of all bodies, in J.
    pub kinetic_j: f64,
    /// Linear momentum in the body frame, in kg m/s.
    pub momentum_in_body: Vector3<f64>,
    /// Angular momentum about the centre of mass of all bodies, in the body frame, in kg m^2/s.
    pub spin_in_body: Vector3<f64>,
    /// Centre of mass of all bodies, in the body frame, in metres.
    pub center_in_body_m: Vector3<f64>,
}

impl Motion {
    pub(crate) fn new(tree: &Tree, posture: &Posture, speeds: &Generalised) -> Self {
        let mut carried = vec![Carried::REST; tree.carriers()];
        posture.carry(tree, speeds, &mut carried);
        let (mut energy, mut mass) = (0.0, 0.0);
        let (mut momentum, mut about_origin, mut moment) =
            (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
        let mut add =
            |m: f64, i: &Matrix3<f64>, r: &Vector3<f64>, v: Vector3<f64>, omega: Vector3<f64>| {
                energy += 0.5 * m * v.norm_squared() + 0.5 * omega.dot(&(i * omega));
                mass += m;
                moment += m * r;
                momentum += m * v;
                about_origin += m * r.cross(&v) + i * omega;
            };
        for (of, moves) in posture.carriers.iter().zip(&carried) {
            let c = &of.inertia;
            let v = moves.velocity(&c.center);
            add(c.mass, &c.about_center, &c.center, v, moves.angular);
        }
        for (w, wheel) in tree.wheels.iter().enumerate() {
            let (hub, on) = (&posture.hubs[w], &carried[wheel.carrier]);
            let spin = hub.axis * speeds.wheels[w];
            let omega = on.angular + spin;
            let r = hub.middle + hub.center;
            let v = on.velocity(&r) + spin.cross(&hub.center);
            add(wheel.hub.mass, &hub.about_center, &r, v, omega);
            for j in wheel.rollers.clone() {
                let (roller, a, r) = (&tree.rollers[j], &posture.axes[j], &posture.centers[j]);
                let i = roller_inertia(roller.axial_inertia, roller.transverse_inertia, a);
                let v = on.velocity(r) + spin.cross(&(r - hub.middle));
                add(roller.mass, &i, r, v, omega + a * speeds.rollers[j]);
            }
        }
        let center = moment / mass;
        Self {
            kinetic_j: energy,
            momentum_in_body: momentum,
            spin_in_body: about_origin - center.cross(&momentum),
            center_in_body_m: center,
        }
    }
}
