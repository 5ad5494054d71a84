//! The coupling of a root to bodies that another engine moves: an arm, a box that it pushes.
//!
//! The other engine gives the wrench of its bodies on the root, W = W_0 - A a: W_0 without
//! acceleration, and A, the articulated-body inertia of its bodies at the body frame's origin
//! (Featherstone, Rigid Body Dynamics Algorithms 2008, section 7.1), for an acceleration a of that
//! origin. A is added to the mass matrix, so that contacts and motors move the true inertia, at any
//! mass ratio and without a delay. W_0 is a push.
//!
//! | symbol | meaning |
//! |---|---|
//! | c, o | the root's centre of mass; the body frame's origin |
//! | r | from c to o |
//! | T | twists of c to twists of o: v_o = v_c + w x r |

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// The articulated inertia of bodies that another engine moves.
#[derive(Clone, Debug)]
pub(crate) struct Attached {
    /// A, linear before angular, along the floor's axes, about o.
    inertia: Matrix6<f64>,
    /// r along the body's axes.
    origin_in_body_m: Vector3<f64>,
    /// T^T A T, and r along the floor's axes, in the root's orientation.
    about_center: Matrix6<f64>,
    lever_m: Vector3<f64>,
    /// The last T^T A (w x (w x r), 0).
    asked_n: Vector6<f64>,
}

impl Attached {
    /// An inertia about the origin of the body frame, from which the root's centre of mass is
    /// `center_in_body_m` away.
    pub fn new(inertia: Matrix6<f64>, center_in_body_m: &Vector3<f64>) -> Self {
        Self {
            inertia,
            origin_in_body_m: -center_in_body_m,
            about_center: inertia,
            lever_m: Vector3::zeros(),
            asked_n: Vector6::zeros(),
        }
    }

    /// The same after the root's centre of mass has moved by `moved_m` in the body.
    pub fn recenter(&mut self, moved_m: &Vector3<f64>) {
        self.origin_in_body_m -= moved_m;
    }

    /// Updates the root's orientation.
    pub fn stand(&mut self, floor_from_body: &Matrix3<f64>) {
        self.lever_m = floor_from_body * self.origin_in_body_m;
        let mut origin_from_center = Matrix6::identity();
        let turning = -self.lever_m.cross_matrix();
        origin_from_center
            .fixed_view_mut::<3, 3>(0, 3)
            .copy_from(&turning);
        self.about_center = origin_from_center.tr_mul(&(self.inertia * origin_from_center));
    }

    /// T^T A T: the addition to the mass matrix.
    pub fn about_center(&self) -> &Matrix6<f64> {
        &self.about_center
    }

    /// The mean over all directions of its mass against an acceleration in the plane, in kg.
    pub fn mean_mass_kg(&self) -> f64 {
        0.5 * (self.inertia[(0, 0)] + self.inertia[(1, 1)])
    }

    /// The wrench at the root's centre of mass, in N and N m, that keeps the origin rotating with
    /// it at a rate in rad/s.
    pub fn asks_of_turning(&mut self, w: &Vector3<f64>) -> Vector6<f64> {
        let inwards_m_s2 = w.cross(&w.cross(&self.lever_m));
        let wrench = self.inertia.fixed_view::<6, 3>(0, 0) * inwards_m_s2;
        let force_n = wrench.fixed_rows::<3>(0).into_owned();
        let torque_n_m = wrench.fixed_rows::<3>(3) + self.lever_m.cross(&force_n);
        self.asked_n.fixed_rows_mut::<3>(0).copy_from(&force_n);
        self.asked_n.fixed_rows_mut::<3>(3).copy_from(&torque_n_m);
        self.asked_n
    }

    /// Its energy intake in a step from the rates of the root before to those after, in J: its
    /// force times the mean of both.
    pub fn took_j(&self, before: &Vector6<f64>, after: &Vector6<f64>, dt_s: f64) -> f64 {
        let asked_n_s = self.about_center * (after - before) + dt_s * self.asked_n;
        asked_n_s.dot(&(0.5 * (before + after)))
    }
}
