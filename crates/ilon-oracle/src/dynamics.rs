//! Kane's equations of the tree, every hub and every roller a body.
//!
//! Generalised speeds: omega and v, the chassis's rate of turn and the velocity of the body frame's origin O; q', the rate of
//! each wheel about its hub axis; phi', the rate of each roller about its own axis *against its hub*. All vectors are those of
//! the body frame, in which hub middles **o** and hub axes **e** stand still.
//!
//! | symbol | meaning |
//! |---|---|
//! | **r**, **s** | a body's centre of mass, from O and from its wheel's middle: **r** = **o** + **s** |
//! | **a** | a roller's axis; its centre lies on it |
//! | m, I | a body's mass and its inertia about its centre |
//! | u | the generalised speeds together |
//!
//! Velocities: a hub turns with omega_h = omega + q' **e**, a roller with omega_r = omega_h + phi' **a**; a centre moves with
//! v + omega x **r** + q' **e** x **s**. Their factors of u are the partial velocities. Accelerations, where a dot on a
//! component is its own derivative and the frame's turning is written out:
//!
//! - of turning: omega. + q'' **e** + omega x q' **e** for a hub, and phi'' **a** + omega_h x phi' **a** more for a roller;
//! - of a centre: v. + omega x v + omega. x **o** + omega x (omega x **o**) + alpha_h x **s** + omega_h x (omega_h x **s**).
//!
//! Kane: the sum over the bodies of (partial velocity) . (m acceleration) + (partial rate) . (I alpha + omega_i x I omega_i)
//! equals the generalised force. That is M u. + h = Q, with h what is left where u. = 0. A roller's column of M meets only
//! its own wheel and the turning of the chassis, a wheel's column only the chassis: M is an arrow within an arrow. Rollers are
//! eliminated into their wheel and the chassis, then wheels into the chassis, and six equations are left.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use crate::tree::{Inertia, Tree};

/// One number a generalised speed: speeds, accelerations or forces (moment about O, force, torques).
#[derive(Clone, Debug, PartialEq)]
pub struct Generalised {
    /// Of the chassis's turning, in the body frame.
    pub angular: Vector3<f64>,
    /// Of the body frame's origin, in the body frame.
    pub linear: Vector3<f64>,
    /// Of each wheel about its hub axis.
    pub wheels: Vec<f64>,
    /// Of each roller about its axis against its hub, wheel by wheel.
    pub rollers: Vec<f64>,
}

impl Generalised {
    pub(crate) fn zero(tree: &Tree) -> Self {
        Self {
            angular: Vector3::zeros(),
            linear: Vector3::zeros(),
            wheels: vec![0.0; tree.wheels.len()],
            rollers: vec![0.0; tree.rollers.len()],
        }
    }

    pub(crate) fn clear(&mut self) {
        self.angular = Vector3::zeros();
        self.linear = Vector3::zeros();
        self.wheels.fill(0.0);
        self.rollers.fill(0.0);
    }

    /// `self = x + factor y`.
    pub(crate) fn set_sum(&mut self, x: &Self, factor: f64, y: &Self) {
        self.angular = x.angular + factor * y.angular;
        self.linear = x.linear + factor * y.linear;
        let wheels = x.wheels.iter().zip(&y.wheels);
        for (sum, (x, y)) in self.wheels.iter_mut().zip(wheels) {
            *sum = x + factor * y;
        }
        let rollers = x.rollers.iter().zip(&y.rollers);
        for (sum, (x, y)) in self.rollers.iter_mut().zip(rollers) {
            *sum = x + factor * y;
        }
    }
}

impl Generalised {
    /// Adds a force on the chassis at a point, both in the body frame.
    pub(crate) fn act_on_chassis(&mut self, point: &Vector3<f64>, force: &Vector3<f64>) {
        self.linear += force;
        self.angular += point.cross(force);
    }

    /// Adds a force at a point of the wheel `w` with middle `o` and hub axis `e`, all in the body frame.
    pub(crate) fn act_on_wheel(
        &mut self,
        w: usize,
        o: &Vector3<f64>,
        e: &Vector3<f64>,
        point: &Vector3<f64>,
        force: &Vector3<f64>,
    ) {
        self.act_on_chassis(point, force);
        self.wheels[w] += e.dot(&(point - o).cross(force));
    }
}

/// Where hubs and rollers stand at given wheel angles, in the body frame.
#[derive(Clone, Debug)]
pub(crate) struct Posture {
    /// A hub's centre of mass from the wheel's middle, and its inertia.
    pub hubs: Vec<(Vector3<f64>, Matrix3<f64>)>,
    /// Each roller's middle, from O.
    pub centers: Vec<Vector3<f64>>,
    /// Each roller's axis.
    pub axes: Vec<Vector3<f64>>,
}

impl Posture {
    pub fn new(tree: &Tree) -> Self {
        let mut posture = Self {
            hubs: vec![(Vector3::zeros(), Matrix3::zeros()); tree.wheels.len()],
            centers: vec![Vector3::zeros(); tree.rollers.len()],
            axes: vec![Vector3::zeros(); tree.rollers.len()],
        };
        posture.update(tree, &vec![0.0; tree.wheels.len()]);
        posture
    }

    /// Moves to these wheel angles, in rad.
    pub fn update(&mut self, tree: &Tree, wheel_angles: &[f64]) {
        for (i, wheel) in tree.wheels.iter().enumerate() {
            let (sin, cos) = wheel_angles[i].sin_cos();
            let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
            let body_from_hub = wheel.body_from_hub * turn;
            self.hubs[i] = (
                body_from_hub * wheel.hub.center,
                body_from_hub * wheel.hub.about_center * body_from_hub.transpose(),
            );
            for j in wheel.rollers.clone() {
                let roller = &tree.rollers[j];
                self.centers[j] = wheel.origin_in_body + body_from_hub * roller.center_in_hub;
                self.axes[j] = body_from_hub * roller.axis_in_hub;
            }
        }
    }
}

/// A joint whose acceleration is prescribed instead of its force: wheels and rollers that are locked.
#[derive(Clone, Debug)]
pub(crate) struct Prescribed {
    pub wheels: Vec<Option<f64>>,
    pub rollers: Vec<Option<f64>>,
}

/// A wheel's or a roller's row of M and of Q - h.
#[derive(Clone, Copy, Debug, Default)]
struct WheelRow {
    chassis: Vector6<f64>,
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

/// M and Q - h, and the elimination. Kept between steps for its memory.
#[derive(Clone, Debug)]
pub(crate) struct ArrowSystem {
    chassis: Matrix6<f64>,
    right: Vector6<f64>,
    wheels: Vec<WheelRow>,
    rollers: Vec<RollerRow>,
}

/// What a body adds to the chassis's and its wheel's rows.
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

    /// Takes m a0 and I alpha0 + omega_i x I omega_i of a body with u. = 0 to the right-hand side.
    fn subtract(&mut self, force: &Vector3<f64>, torque: &Vector3<f64>, r: &Vector3<f64>) {
        self.force -= force;
        self.moment -= torque + r.cross(force);
    }
}

fn roller_inertia(axial: f64, transverse: f64, a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_diagonal_element(transverse) + a * a.transpose() * (axial - transverse)
}

impl ArrowSystem {
    pub fn new(tree: &Tree) -> Self {
        Self {
            chassis: Matrix6::zeros(),
            right: Vector6::zeros(),
            wheels: vec![WheelRow::default(); tree.wheels.len()],
            rollers: vec![RollerRow::default(); tree.rollers.len()],
        }
    }

    /// M and Q - h of this posture, these speeds u and these forces Q.
    pub fn assemble(
        &mut self,
        tree: &Tree,
        posture: &Posture,
        speeds: &Generalised,
        forces: &Generalised,
    ) {
        let (omega, v) = (&speeds.angular, &speeds.linear);
        let mut sums = Sums {
            turning: Matrix3::zeros(),
            cross: Matrix3::zeros(),
            mass: 0.0,
            moment: forces.angular,
            force: forces.linear,
        };
        let Inertia {
            mass: m,
            center: r,
            about_center: i,
        } = &tree.chassis;
        sums.add(*m, i, r);
        let a0 = omega.cross(v) + omega.cross(&omega.cross(r));
        sums.subtract(&(a0 * *m), &omega.cross(&(i * omega)), r);

        for (w, wheel) in tree.wheels.iter().enumerate() {
            let (o, e) = (&wheel.origin_in_body, &wheel.axis_in_body);
            let spin = e * speeds.wheels[w];
            let omega_h = omega + spin;
            let alpha_h0 = omega.cross(&spin);
            let a_o0 = omega.cross(v) + omega.cross(&omega.cross(o));
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
                let turning = partial_rate + r.cross(&partial_velocity);
                row.chassis += Vector6::new(
                    turning.x,
                    turning.y,
                    turning.z,
                    partial_velocity.x,
                    partial_velocity.y,
                    partial_velocity.z,
                );
                row.own += e.dot(&partial_rate) + e.cross(s).dot(&partial_velocity);
                row.right -= e.dot(&(torque + s.cross(&force)));
            };
            let (s, i) = &posture.hubs[w];
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

        let mut chassis = Matrix6::zeros();
        chassis
            .fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&sums.turning);
        chassis.fixed_view_mut::<3, 3>(0, 3).copy_from(&sums.cross);
        chassis
            .fixed_view_mut::<3, 3>(3, 0)
            .copy_from(&sums.cross.transpose());
        chassis
            .fixed_view_mut::<3, 3>(3, 3)
            .copy_from(&Matrix3::from_diagonal_element(sums.mass));
        self.chassis = chassis;
        self.right.fixed_rows_mut::<3>(0).copy_from(&sums.moment);
        self.right.fixed_rows_mut::<3>(3).copy_from(&sums.force);
    }

    /// Writes u. of the assembled system; returns whether M was positive definite. Where a joint's acceleration is
    /// prescribed, its place in `reactions` gets the torque that this takes.
    pub fn solve(
        &mut self,
        tree: &Tree,
        prescribed: &Prescribed,
        accelerations: &mut Generalised,
        reactions: &mut Generalised,
    ) -> bool {
        for (w, wheel) in tree.wheels.iter().enumerate() {
            for j in wheel.rollers.clone() {
                let row = self.rollers[j];
                let mut turning = self.chassis.fixed_view_mut::<3, 3>(0, 0);
                let to = &mut self.wheels[w];
                let alone = match prescribed.rollers[j] {
                    Some(phi) => phi,
                    None => {
                        turning -= row.turning * row.turning.transpose() / row.own;
                        let mut meets = to.chassis.fixed_rows_mut::<3>(0);
                        meets -= row.turning * (row.wheel / row.own);
                        to.own -= row.wheel * row.wheel / row.own;
                        row.right / row.own
                    }
                };
                let mut moment = self.right.fixed_rows_mut::<3>(0);
                moment -= row.turning * alone;
                to.right -= row.wheel * alone;
            }
            let row = self.wheels[w];
            let alone = match prescribed.wheels[w] {
                Some(q) => q,
                None => {
                    self.chassis -= row.chassis * row.chassis.transpose() / row.own;
                    row.right / row.own
                }
            };
            self.right -= row.chassis * alone;
        }
        let Some(cholesky) = self.chassis.cholesky() else {
            return false;
        };
        let x = cholesky.solve(&self.right);
        accelerations.angular = x.fixed_rows::<3>(0).into();
        accelerations.linear = x.fixed_rows::<3>(3).into();
        for (w, wheel) in tree.wheels.iter().enumerate() {
            let row = &self.wheels[w];
            let left = row.right - row.chassis.dot(&x);
            (accelerations.wheels[w], reactions.wheels[w]) = match prescribed.wheels[w] {
                Some(q) => (q, row.own * q - left),
                None => (left / row.own, 0.0),
            };
            for j in wheel.rollers.clone() {
                let row = &self.rollers[j];
                let left = row.right
                    - row.turning.dot(&accelerations.angular)
                    - row.wheel * accelerations.wheels[w];
                (accelerations.rollers[j], reactions.rollers[j]) = match prescribed.rollers[j] {
                    Some(phi) => (phi, row.own * phi - left),
                    None => (left / row.own, 0.0),
                };
            }
        }
        true
    }
}

/// Momenta and kinetic energy, summed body by body: no mass matrix enters.
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
        let (omega, v) = (&speeds.angular, &speeds.linear);
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
        let c = &tree.chassis;
        add(
            c.mass,
            &c.about_center,
            &c.center,
            v + omega.cross(&c.center),
            *omega,
        );
        for (w, wheel) in tree.wheels.iter().enumerate() {
            let spin = wheel.axis_in_body * speeds.wheels[w];
            let (s, i) = &posture.hubs[w];
            let r = wheel.origin_in_body + s;
            add(
                wheel.hub.mass,
                i,
                &r,
                v + omega.cross(&r) + spin.cross(s),
                omega + spin,
            );
            for j in wheel.rollers.clone() {
                let (roller, a, r) = (&tree.rollers[j], &posture.axes[j], &posture.centers[j]);
                let i = roller_inertia(roller.axial_inertia, roller.transverse_inertia, a);
                let v = v + omega.cross(r) + spin.cross(&(r - wheel.origin_in_body));
                add(roller.mass, &i, r, v, omega + spin + a * speeds.rollers[j]);
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
