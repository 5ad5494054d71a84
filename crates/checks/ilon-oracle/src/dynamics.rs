//! Kane's equations of the tree, with every hub and every roller as a body.
//!
//! Generalised speeds: omega and v, the chassis's angular velocity and the velocity of the body
//! frame's origin O; the rate of each joint between bodies; q', the rate of each wheel about its
//! hub axis; phi', the rate of each roller about its own axis *relative to its hub*. All vectors
//! are in the body frame. A carrier (the chassis or a body on a joint) has the angular velocity
//! omega_c, and its material point at O the velocity v_c; those of the chassis are omega and v, and
//! `posture.rs` has the others.
//!
//! | symbol | meaning |
//! |---|---|
//! | **o**, **e** | a wheel's middle and its hub axis |
//! | **r**, **s** | a body's centre of mass, from O and from its wheel's middle: **r** = **o** + **s** |
//! | **a** | a roller's axis; its centre lies on it |
//! | m, I | a body's mass and its inertia about its centre |
//! | **z**, **p** | a joint's axis and a point on it |
//! | u | the generalised speeds together |
//!
//! Velocities: a hub turns with omega_h = omega_c + q' **e**, a roller with
//! omega_r = omega_h + phi' **a**; a centre moves with v_c + omega_c x **r** + q' **e** x **s**.
//! Their factors of u are the partial velocities. Accelerations, where a dot on a component is its
//! own derivative, alpha_c is the carrier's angular acceleration, and a_c the acceleration of its
//! point at O:
//!
//! - angular: alpha_c + q'' **e** + omega_c x q' **e** for a hub, plus phi'' **a** + omega_h x phi'
//!   **a** for a roller;
//! - of a centre: a_c + alpha_c x **o** + omega_c x (omega_c x **o**) + alpha_h x **s** + omega_h x
//!   (omega_h x **s**).
//!
//! Kane: the sum over the bodies of (partial velocity) . (m acceleration) + (partial angular
//! velocity) . (I alpha + omega_i x I omega_i) equals the generalised force. That is M u. + h = Q,
//! with h the bias at u. = 0. A roller's column of M couples only with its own wheel and the
//! angular part of its carrier, a wheel's column only with its carrier, and a joint's with the
//! carriers on its way to the chassis: M is an arrow within an arrow. Rollers are eliminated into
//! their wheel and carrier, wheels into their carrier, and the bodies on joints, the last first,
//! into their parent carrier: with the carrier's own six equations A x = b and the joint's
//! S = (**z**, **p** x **z**), or (0, **z**) for a prismatic joint, the parent gets A - A S S^T
//! A / (S^T A S). At last six equations are left.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use crate::forces::{Forces, Prescribed};
use crate::generalised::Generalised;
use crate::posture::{Carried, Posture};
use crate::tree::{Inertia, Tree};

/// The row of M and of Q - h of a joint, a wheel or a roller.
#[derive(Clone, Copy, Debug, Default)]
struct WheelRow {
    carrier: Vector6<f64>,
    own: f64,
    right: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct RollerRow {
    turning: Vector3<f64>,
    wheel: f64,
    own: f64,
    right: f64,
}

/// A carrier's six equations.
#[derive(Clone, Copy, Debug, Default)]
struct CarrierRows {
    m: Matrix6<f64>,
    right: Vector6<f64>,
    /// For a body on a joint: the joint's partial velocities S, and its row.
    partial: Vector6<f64>,
    joint: WheelRow,
}

/// M and Q - h, and the elimination. Kept between steps to reuse its memory.
#[derive(Clone, Debug)]
pub(crate) struct ArrowSystem {
    carriers: Vec<CarrierRows>,
    wheels: Vec<WheelRow>,
    rollers: Vec<RollerRow>,
    carried: Vec<Carried>,
}

/// The sums over bodies for a carrier's rows.
struct Sums {
    turning: Matrix3<f64>,
    cross: Matrix3<f64>,
    mass: f64,
    moment: Vector3<f64>,
    force: Vector3<f64>,
}

impl Sums {
    fn add(&mut self, m: f64, i: &Matrix3<f64>, r: &Vector3<f64>) {
        self.turning +=
            i + (Matrix3::from_diagonal_element(r.norm_squared()) - r * r.transpose()) * m;
        self.cross += r.cross_matrix() * m;
        self.mass += m;
    }

    /// Subtracts m a0 and I alpha0 + omega_i x I omega_i of a body at u. = 0 from the right-hand
    /// side.
    fn subtract(&mut self, force: &Vector3<f64>, torque: &Vector3<f64>, r: &Vector3<f64>) {
        self.force -= force;
        self.moment -= torque + r.cross(force);
    }
}

pub(crate) fn roller_inertia(axial: f64, transverse: f64, a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_diagonal_element(transverse) + a * a.transpose() * (axial - transverse)
}

impl Sums {
    fn rows(&self) -> CarrierRows {
        let mut rows = CarrierRows::default();
        let mut set = |i: usize, j: usize, part: &Matrix3<f64>| {
            rows.m.fixed_view_mut::<3, 3>(i, j).copy_from(part);
        };
        set(0, 0, &self.turning);
        set(0, 3, &self.cross);
        set(3, 0, &self.cross.transpose());
        set(3, 3, &Matrix3::from_diagonal_element(self.mass));
        rows.right.fixed_rows_mut::<3>(0).copy_from(&self.moment);
        rows.right.fixed_rows_mut::<3>(3).copy_from(&self.force);
        rows
    }
}

fn six(turning: &Vector3<f64>, moving: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(
        turning.x, turning.y, turning.z, moving.x, moving.y, moving.z,
    )
}

impl ArrowSystem {
    pub fn new(tree: &Tree) -> Self {
        Self {
            carriers: vec![CarrierRows::default(); tree.carriers()],
            wheels: vec![WheelRow::default(); tree.wheels.len()],
            rollers: vec![RollerRow::default(); tree.rollers.len()],
            carried: vec![Carried::REST; tree.carriers()],
        }
    }

    /// Assembles M and Q - h for this posture, these speeds u and these forces Q.
    pub fn assemble(
        &mut self,
        tree: &Tree,
        posture: &Posture,
        speeds: &Generalised,
        forces: &Forces,
    ) {
        posture.carry(tree, speeds, &mut self.carried);
        for c in 0..tree.carriers() {
            let mut sums = self.carrier_alone(posture, forces, c);
            for (w, wheel) in tree.wheels.iter().enumerate() {
                if wheel.carrier == c {
                    self.add_wheel(tree, posture, (speeds, forces), w, &mut sums);
                }
            }
            self.carriers[c] = sums.rows();
        }
        for (i, joint) in tree.joints.iter().enumerate() {
            let (p, z) = (
                &posture.carriers[i + 1].pivot,
                &posture.carriers[i + 1].axis,
            );
            let rows = &mut self.carriers[i + 1];
            rows.partial = if joint.slides {
                six(&Vector3::zeros(), z)
            } else {
                six(z, &p.cross(z))
            };
            rows.joint.right = forces.joints[i];
        }
    }

    fn carrier_alone(&self, posture: &Posture, forces: &Forces, c: usize) -> Sums {
        let carried = &self.carried[c];
        let (omega, alpha0) = (&carried.angular, &carried.angular_left);
        let (moment, force) = forces.carriers[c];
        let mut sums = Sums {
            turning: Matrix3::zeros(),
            cross: Matrix3::zeros(),
            mass: 0.0,
            moment,
            force,
        };
        let Inertia {
            mass: m,
            center: r,
            about_center: i,
        } = &posture.carriers[c].inertia;
        sums.add(*m, i, r);
        let torque = i * alpha0 + omega.cross(&(i * omega));
        sums.subtract(&(carried.left(r) * *m), &torque, r);
        sums
    }

    /// Adds hub and rollers of a wheel to their carrier's sums, and writes their rows.
    fn add_wheel(
        &mut self,
        tree: &Tree,
        posture: &Posture,
        (speeds, forces): (&Generalised, &Forces),
        w: usize,
        sums: &mut Sums,
    ) {
        let (wheel, hub) = (&tree.wheels[w], &posture.hubs[w]);
        let (o, e) = (&hub.middle, &hub.axis);
        let carried = &self.carried[wheel.carrier];
        let spin = e * speeds.wheels[w];
        let omega_h = carried.angular + spin;
        let alpha_h0 = carried.angular_left + carried.angular.cross(&spin);
        let a_o0 = carried.left(o);
        let a0 = |s: &Vector3<f64>| a_o0 + alpha_h0.cross(s) + omega_h.cross(&omega_h.cross(s));
        let mut row = WheelRow {
            right: forces.wheels[w],
            ..WheelRow::default()
        };
        let mut add = |m: f64, i: &Matrix3<f64>, s: &Vector3<f64>, torque: &Vector3<f64>| {
            let r = o + s;
            sums.add(m, i, &r);
            let force = a0(s) * m;
            sums.subtract(&force, torque, &r);
            let (partial_rate, partial_velocity) = (i * e, e.cross(s) * m);
            row.carrier += six(
                &(partial_rate + r.cross(&partial_velocity)),
                &partial_velocity,
            );
            row.own += e.dot(&partial_rate) + e.cross(s).dot(&partial_velocity);
            row.right -= e.dot(&(torque + s.cross(&force)));
        };
        let (s, i) = (&hub.center, &hub.about_center);
        let torque = i * alpha_h0 + omega_h.cross(&(i * omega_h));
        add(wheel.hub.mass, i, s, &torque);

        for j in wheel.rollers.clone() {
            let (roller, a) = (&tree.rollers[j], &posture.axes[j]);
            let s = posture.centers[j] - o;
            let i = roller_inertia(roller.axial_inertia, roller.transverse_inertia, a);
            let roll = a * speeds.rollers[j];
            let omega_r = omega_h + roll;
            let alpha0 = alpha_h0 + omega_h.cross(&roll);
            let torque = i * alpha0 + omega_r.cross(&(i * omega_r));
            add(roller.mass, &i, &s, &torque);
            let turning = i * a;
            self.rollers[j] = RollerRow {
                turning,
                wheel: e.dot(&turning),
                own: a.dot(&turning),
                right: forces.rollers[j] - a.dot(&torque),
            };
        }
        self.wheels[w] = row;
    }

    /// Solves the assembled system for u.; returns whether M was positive definite. For a joint
    /// with a prescribed acceleration, its entry in `reactions` gets the torque needed for it.
    pub fn solve(
        &mut self,
        tree: &Tree,
        prescribed: &Prescribed,
        accelerations: &mut Generalised,
        reactions: &mut Forces,
    ) -> bool {
        for w in 0..tree.wheels.len() {
            self.eliminate_wheel(tree, prescribed, w);
        }
        for (i, joint) in tree.joints.iter().enumerate().rev() {
            let mut rows = self.carriers[i + 1];
            rows.joint.carrier = rows.m * rows.partial;
            rows.joint.own = rows.partial.dot(&rows.joint.carrier);
            rows.joint.right += rows.partial.dot(&rows.right);
            let WheelRow {
                carrier,
                own,
                right,
            } = rows.joint;
            if own <= 0.0 {
                return false;
            }
            self.carriers[i + 1] = rows;
            let to = &mut self.carriers[joint.parent];
            to.m += rows.m - carrier * carrier.transpose() / own;
            to.right += rows.right - carrier * (right / own);
        }
        let Some(cholesky) = self.carriers[0].m.cholesky() else {
            return false;
        };
        // From here on `right` is a carrier's acceleration without its bias at u. = 0.
        let x = cholesky.solve(&self.carriers[0].right);
        self.carriers[0].right = x;
        accelerations.angular = x.fixed_rows::<3>(0).into();
        accelerations.linear = x.fixed_rows::<3>(3).into();
        for (i, joint) in tree.joints.iter().enumerate() {
            let on = self.carriers[joint.parent].right;
            let rows = &mut self.carriers[i + 1];
            let own = (rows.joint.right - rows.joint.carrier.dot(&on)) / rows.joint.own;
            accelerations.joints[i] = own;
            rows.right = on + rows.partial * own;
        }
        for w in 0..tree.wheels.len() {
            self.finish_wheel(tree, prescribed, w, (accelerations, reactions));
        }
        true
    }

    /// Eliminates rollers into their wheel and carrier, and the wheel into the carrier.
    fn eliminate_wheel(&mut self, tree: &Tree, prescribed: &Prescribed, w: usize) {
        let wheel = &tree.wheels[w];
        let CarrierRows { m, right, .. } = &mut self.carriers[wheel.carrier];
        for j in wheel.rollers.clone() {
            let row = self.rollers[j];
            let mut turning = m.fixed_view_mut::<3, 3>(0, 0);
            let to = &mut self.wheels[w];
            let alone = match prescribed.rollers[j] {
                Some(phi) => phi,
                None => {
                    turning -= row.turning * row.turning.transpose() / row.own;
                    let mut meets = to.carrier.fixed_rows_mut::<3>(0);
                    meets -= row.turning * (row.wheel / row.own);
                    to.own -= row.wheel * row.wheel / row.own;
                    row.right / row.own
                }
            };
            let mut moment = right.fixed_rows_mut::<3>(0);
            moment -= row.turning * alone;
            to.right -= row.wheel * alone;
        }
        let row = self.wheels[w];
        let alone = match prescribed.wheels[w] {
            Some(q) => q,
            None => {
                *m -= row.carrier * row.carrier.transpose() / row.own;
                row.right / row.own
            }
        };
        *right -= row.carrier * alone;
    }

    fn finish_wheel(
        &self,
        tree: &Tree,
        prescribed: &Prescribed,
        w: usize,
        (accelerations, reactions): (&mut Generalised, &mut Forces),
    ) {
        let wheel = &tree.wheels[w];
        let x = &self.carriers[wheel.carrier].right;
        let turning: Vector3<f64> = x.fixed_rows::<3>(0).into();
        let row = &self.wheels[w];
        let left = row.right - row.carrier.dot(x);
        (accelerations.wheels[w], reactions.wheels[w]) = match prescribed.wheels[w] {
            Some(q) => (q, row.own * q - left),
            None => (left / row.own, 0.0),
        };
        for j in wheel.rollers.clone() {
            let row = &self.rollers[j];
            let left = row.right - row.turning.dot(&turning) - row.wheel * accelerations.wheels[w];
            (accelerations.rollers[j], reactions.rollers[j]) = match prescribed.rollers[j] {
                Some(phi) => (phi, row.own * phi - left),
                None => (left / row.own, 0.0),
            };
        }
    }
}
