//! The dynamic model (11) of a robot with N >= 3 wheels, derived from its own masses.
//!
//! **Coordinates.** nu = (v_c, omega) is the body's twist about the origin of its frame, q' the
//! wheel rates. While the wheels roll, q' = R nu with R the matrix of eq. (9), and nu = P q' with P
//! its left inverse.
//!
//! **The rigid part.** All masses (chassis, bodies on joints, hubs, rollers) move with the body,
//! with the joints fixed. With the mass m, the common centre of mass c and the inertia J_z about
//! the vertical through the origin, Newton and Euler in the body frame give for the force f and the
//! moment mu on it
//!
//!   f  = m (v' + omega k x v + omega' k x c - omega^2 c),
//!   mu = J_z omega' + m c x (v' + omega k x v),
//!
//! that is f = G nu' + omega S nu with, writing the plane's components out,
//!
//!   G = [ m 0 -m c_y; 0 m m c_x; -m c_y m c_x J_z ],
//!   S = [ 0 -m -m c_x; m 0 -m c_y; m c_x m c_y 0 ].
//!
//! G is symmetric positive definite, S is skew.
//!
//! **The wheels' spin.** Each wheel turns about its axis with the inertia J_h of hub and rollers: a
//! torque J_h q''_h.
//!
//! **The touching rollers' spin.** By eq. (3) the roller has the velocity alpha = n . v_h /
//! cos(gamma) along u_gamma, so it spins with alpha / r about n_gamma against its hub: a row t_h
//! nu. About its own axis it turns with t_h nu + (n . n_gamma) q'_h in space, with the axial
//! inertia J_r, and against its bearing with t_h nu, where the bearing's damping and friction act.
//! A spin is a scalar coordinate: by d'Alembert it adds its inertia times its row's square to the
//! inertia matrix and nothing to the Coriolis matrix. The other rollers turn with their hub. This
//! mean model neglects the loss of spinning up each new roller.
//!
//! **Together**, with nu = P q' and the body's equation multiplied by P^T:
//!
//!   I = diag(J_h) + P^T G P + sum of the spins,
//!   C(omega) = omega P^T S P,   F = diag(wheel damping),
//!
//! I symmetric positive definite, C skew and linear in omega, F diagonal: the structure that the
//! paper names. Roller damping is a full matrix D = sum d_r (t_h P)^T (t_h P), symmetric and
//! positive semidefinite, which does not fit the paper's diagonal F; it is kept apart.
//!
//! **N > 3.** Rolling leaves q' only three freedoms, while (11) has N equations. The N - 3 others
//! are not motion but forces between the wheels: torques tau with R^T tau = 0 strain the floor and
//! accelerate nothing. Equation (11) must be read after multiplication by R^T, and
//! [`DynamicModel::accelerations`] solves it that way. Solving (11) as printed, q'' = I^-1 (tau -
//! ...), would let the wheels of a rolling robot accelerate out of the range of M.

use ilon_robot::{Robot, Twist, Wheel};
use nalgebra::{Cholesky, Const, DMatrix, Matrix3, MatrixXx3, RowVector3, Vector3};

use crate::kinematics::matrix::multiply;
use crate::{ControlError, Kinematics};

/// The matrices I, C(omega) and F of eq. (11), and their components.
#[derive(Clone, Debug)]
pub struct DynamicModel {
    kinematics: Kinematics,
    /// I.
    inertia: DMatrix<f64>,
    /// C(1).
    coriolis: DMatrix<f64>,
    /// The diagonal of F, in N m s/rad.
    damping_n_m_s: Vec<f64>,
    /// Dry friction of the wheels' joints, in N m.
    friction_n_m: Vec<f64>,
    /// D.
    bearing_drag: DMatrix<f64>,
    /// t_h P, N x N: the touching rollers' spins from the wheel rates.
    roller_spins: DMatrix<f64>,
    /// Dry friction of the touching rollers' joints, in N m.
    roller_friction_n_m: Vec<f64>,
    /// R^T I R, factorised: the inertia of the body with all rotating parts; of motions that tyres
    /// hold far more.
    body_inertia: Cholesky<f64, Const<3>>,
    /// The inertia of each wheel alone, in kg m^2.
    wheel_inertias_kg_m2: Vec<f64>,
}

/// Mass of motions that tyres hold, over the robot's: they accelerate by less than rounding shows.
const HELD: f64 = 1e9;

impl DynamicModel {
    /// Builds the model of a robot on flat ground, with its joints between bodies at zero; for
    /// other poses pass the result of [`Robot::posed`].
    ///
    /// # Errors
    /// Those of [`Kinematics::new`]; [`ControlError::NoRollers`]; [`ControlError::NotPositive`] if
    /// the inertia is not positive definite.
    pub fn new(robot: &Robot) -> Result<Self, ControlError> {
        let kinematics = Kinematics::new(robot)?;
        let n = kinematics.wheel_count();
        let p = kinematics.twist_matrix();
        let spins: Vec<_> = robot
            .wheels
            .iter()
            .map(wheel_spin)
            .collect::<Result<_, _>>()?;

        let body = rigid_part(robot);
        let mut inertia = p.transpose() * body.g * p;
        let coriolis = p.transpose() * body.s * p;
        let roller_spins =
            MatrixXx3::from_rows(&spins.iter().map(|spin| spin.roller).collect::<Vec<_>>()) * p;
        let mut bearing_drag = DMatrix::zeros(n, n);
        for (h, spin) in spins.iter().enumerate() {
            let against_hub = roller_spins.row(h);
            let mut in_space = against_hub.clone_owned();
            in_space[h] += spin.roller_on_axis;
            inertia[(h, h)] += spin.wheel_inertia_kg_m2;
            inertia += in_space.transpose() * &in_space * spin.roller_inertia_kg_m2;
            bearing_drag += against_hub.transpose() * against_hub * spin.roller_damping_n_m_s;
        }
        let r = kinematics.rate_matrix();
        let body_inertia: Matrix3<f64> = (r.transpose() * &inertia * r)
            .fixed_view::<3, 3>(0, 0)
            .into();
        let held = kinematics.held_rows().iter();
        let held: Matrix3<f64> = held.map(|row| row * row.transpose()).sum();
        let body_inertia = body_inertia + held * (HELD * body.g[(0, 0)]);
        let smallest = body_inertia.symmetric_eigenvalues().min();
        let body_inertia = body_inertia
            .cholesky()
            .ok_or_else(|| ControlError::NotPositive {
                what: "the smallest eigenvalue of the robot's inertia".to_owned(),
                value: smallest,
            })?;
        let alone = spins.iter().map(|spin| spin.wheel_inertia_kg_m2).collect();
        Ok(Self {
            inertia,
            coriolis,
            damping_n_m_s: robot.wheels.iter().map(|w| w.joint.damping_n_m_s).collect(),
            friction_n_m: robot.wheels.iter().map(Wheel::dry_friction_n_m).collect(),
            bearing_drag,
            roller_spins,
            roller_friction_n_m: spins.iter().map(|spin| spin.roller_friction_n_m).collect(),
            body_inertia,
            wheel_inertias_kg_m2: alone,
            kinematics,
        })
    }

    /// The kinematics of the robot, about the origin of the body frame.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// I of eq. (11), N x N, in kg m^2: symmetric positive definite.
    pub fn inertia(&self) -> &DMatrix<f64> {
        &self.inertia
    }

    /// C(omega) of eq. (11), N x N, in N m s/rad: skew, linear in omega (rad/s).
    pub fn coriolis(&self, omega_rad_s: f64) -> DMatrix<f64> {
        &self.coriolis * omega_rad_s
    }

    /// The diagonal of F of eq. (11), in N m s/rad: the viscous damping of the wheels' joints.
    pub fn damping_n_m_s(&self) -> &[f64] {
        &self.damping_n_m_s
    }

    /// D, N x N, in N m s/rad: the viscous damping of the touching rollers' bearings, seen from the
    /// wheels; symmetric positive semidefinite.
    pub fn bearing_drag(&self) -> &DMatrix<f64> {
        &self.bearing_drag
    }

    /// The largest inertia that a wheel's loop can feel, in kg m^2: the largest eigenvalue of I.
    pub fn ground_inertia_kg_m2(&self) -> f64 {
        self.inertia.symmetric_eigenvalues().max()
    }

    /// The smallest inertia of a wheel in the air, in kg m^2.
    pub fn air_inertia_kg_m2(&self) -> f64 {
        let inertias = self.wheel_inertias_kg_m2.iter().copied();
        inertias.fold(f64::INFINITY, f64::min)
    }

    /// Returns the bandwidth in rad/s of a law for the whole robot, limited for torques held over
    /// `dt_s` seconds to J_air / (J_ground dt), so that wheels that slide or hang in the air do not
    /// oscillate.
    pub fn bandwidth_rad_s(&self, asked_rad_s: f64, dt_s: f64) -> f64 {
        let air_share = self.air_inertia_kg_m2() / self.ground_inertia_kg_m2();
        asked_rad_s.min(air_share / dt_s)
    }

    /// The inertia of each wheel alone about its axis, J_h of the module's derivation, in kg m^2.
    pub fn wheel_inertias_kg_m2(&self) -> &[f64] {
        &self.wheel_inertias_kg_m2
    }

    /// Computes the torques in N m for wheel rates in rad/s and accelerations in rad/s^2: eq. (11),
    /// with the rollers' drag and all dry friction added to F q'.
    pub fn torques(&self, rates_rad_s: &[f64], accelerations_rad_s2: &[f64], out: &mut [f64]) {
        self.resistance(rates_rad_s, out);
        self.add_inertia_times(accelerations_rad_s2, out);
    }

    /// Computes the torques that keep the wheel rates constant, in N m: (C(omega) + F) q' of eq.
    /// (11), with the rollers' drag and all dry friction.
    pub fn resistance(&self, rates_rad_s: &[f64], out: &mut [f64]) {
        self.resistance_towards(rates_rad_s, rates_rad_s, out);
    }

    /// Like [`Self::resistance`], with dry friction against `towards_rad_s` instead of the rates.
    pub(crate) fn resistance_towards(
        &self,
        rates_rad_s: &[f64],
        towards_rad_s: &[f64],
        out: &mut [f64],
    ) {
        let omega = self.kinematics.twist(rates_rad_s).omega_rad_s;
        let inputs = rates_rad_s.iter().zip(towards_rad_s);
        for ((h, out), (rate, towards)) in out.iter_mut().enumerate().zip(inputs) {
            *out = omega * dot(self.coriolis.row(h).iter(), rates_rad_s)
                + self.damping_n_m_s[h] * rate
                + self.friction_n_m[h] * sign(*towards)
                + dot(self.bearing_drag.row(h).iter(), rates_rad_s);
        }
        for (spin_row, friction_n_m) in self.roller_spins.row_iter().zip(&self.roller_friction_n_m)
        {
            let torque = friction_n_m * sign(dot(spin_row.iter(), towards_rad_s));
            for (out, share) in out.iter_mut().zip(spin_row.iter()) {
                *out += torque * share;
            }
        }
    }

    /// Computes the part of the resistance from the wheels' own joints, in N m: damping, and dry
    /// friction against `towards_rad_s`.
    pub(crate) fn own_resistance(
        &self,
        rates_rad_s: &[f64],
        towards_rad_s: &[f64],
        out: &mut [f64],
    ) {
        let inputs = rates_rad_s.iter().zip(towards_rad_s);
        for ((h, out), (rate, towards)) in out.iter_mut().enumerate().zip(inputs) {
            *out = self.damping_n_m_s[h] * rate + self.friction_n_m[h] * sign(*towards);
        }
    }

    /// out += I y.
    pub(crate) fn add_inertia_times(&self, y_rad_s2: &[f64], out: &mut [f64]) {
        for (out, row) in out.iter_mut().zip(self.inertia.row_iter()) {
            *out += dot(row.iter(), y_rad_s2);
        }
    }

    /// Returns the accelerations in rad/s^2 of wheels that roll at `rates_rad_s` under torques in N
    /// m: eq. (11) solved in the range of M. `scratch` holds one number per wheel.
    pub fn accelerations(
        &self,
        rates_rad_s: &[f64],
        torques_n_m: &[f64],
        scratch: &mut [f64],
        out: &mut [f64],
    ) {
        let twist_rate = self.twist_rate(rates_rad_s, torques_n_m, scratch);
        multiply(self.kinematics.rate_matrix(), twist_rate, out);
    }

    /// Returns the rate of change of the body's twist under torques, d/dt of (v_c, omega) as
    /// components in the body frame, in m/s^2 and rad/s^2: (R^T I R) nu' = R^T (tau - (C + F) q').
    ///
    /// These are derivatives of components. The acceleration of the origin in space is v' + omega k
    /// x v.
    pub fn twist_rate(
        &self,
        rates_rad_s: &[f64],
        torques_n_m: &[f64],
        scratch: &mut [f64],
    ) -> Twist {
        self.resistance(rates_rad_s, scratch);
        let mut force = Vector3::zeros();
        let rows = self.kinematics.rate_matrix().row_iter();
        for ((row, torque_n_m), resistance) in rows.zip(torques_n_m).zip(scratch) {
            force += row.transpose() * (torque_n_m - *resistance);
        }
        let rate = self.body_inertia.solve(&force);
        Twist::new(rate.x, rate.y, rate.z)
    }

    /// Kinetic energy at wheel rates in rad/s, in J: q'^T I q' / 2.
    pub fn kinetic_energy_j(&self, rates_rad_s: &[f64]) -> f64 {
        let rows = self.inertia.row_iter().zip(rates_rad_s);
        0.5 * rows
            .map(|(row, rate)| rate * dot(row.iter(), rates_rad_s))
            .sum::<f64>()
    }
}

/// G and S of the module's derivation.
struct RigidPart {
    g: Matrix3<f64>,
    s: Matrix3<f64>,
}

/// Combines all masses of the robot into one rigid body in the plane, about the origin of the body
/// frame.
fn rigid_part(robot: &Robot) -> RigidPart {
    let chassis = &robot.chassis.mass;
    let mut m = chassis.mass_kg;
    let mut mc = m * chassis.center_of_mass_m.xy();
    let mut j_z = chassis.inertia_kg_m2.m33 + m * chassis.center_of_mass_m.xy().norm_squared();
    for joint in &robot.joints {
        let body = joint.body.mass.moved(&joint.body_from_joint);
        let at_m = body.center_of_mass_m.xy();
        m += body.mass_kg;
        mc += body.mass_kg * at_m;
        j_z += body.inertia_kg_m2.m33 + body.mass_kg * at_m.norm_squared();
    }
    for wheel in &robot.wheels {
        let (wheel_kg, tensor) = wheel_about_center(wheel);
        // As the wheel turns, its inertia about the vertical oscillates about the mean of the two
        // across its axis.
        let across = 0.5 * (tensor.m11 + tensor.m22);
        let b = wheel.position_m().xy();
        m += wheel_kg;
        mc += wheel_kg * b;
        j_z += across + wheel_kg * b.norm_squared();
    }
    let (mx, my) = (mc.x, mc.y);
    RigidPart {
        g: Matrix3::new(m, 0.0, -my, 0.0, m, mx, -my, mx, j_z),
        s: Matrix3::new(0.0, -m, -mx, m, 0.0, -my, mx, my, 0.0),
    }
}

/// Returns the mass of a wheel with its rollers in kg and its inertia about its centre along the
/// hub frame's axes, in kg m^2, with its centre of mass assumed on the hub axis (balanced wheels).
fn wheel_about_center(wheel: &Wheel) -> (f64, Matrix3<f64>) {
    let center = Vector3::zeros();
    let mut mass_kg = wheel.hub.mass_kg;
    let mut tensor = wheel.hub.inertia_about(&center);
    for r in &wheel.rollers {
        tensor += r.mass_in_hub().inertia_about(&center);
        mass_kg += r.mass_kg;
    }
    (mass_kg, tensor)
}

/// Inertia and friction of a turning wheel and its touching roller.
#[derive(Clone, Debug)]
pub(super) struct WheelSpin {
    /// J_h: the wheel about its axis, without the touching roller's rotation about its own axis, in
    /// kg m^2.
    wheel_inertia_kg_m2: f64,
    /// t_h: the touching roller's spin against its hub per twist, in rad/s.
    pub roller: RowVector3<f64>,
    /// n . n_gamma: the hub axis's component along the roller's axis.
    pub roller_on_axis: f64,
    pub roller_inertia_kg_m2: f64,
    pub roller_damping_n_m_s: f64,
    pub roller_friction_n_m: f64,
    /// Friction torque on the roller's axle per load, in N m/N. The dynamic model has no loads and
    /// leaves it out.
    pub axle_drag_m: f64,
}

impl WheelSpin {
    /// Returns the direction in which the roller turns against its hub as the robot moves: -1, 0 or
    /// 1; 0 if the spin is only rounding.
    pub fn way(&self, twist: &Vector3<f64>) -> f64 {
        /// Products of unit vectors below this count as zero.
        const ROUNDING: f64 = 1e-12;
        let spin = (self.roller * twist)[0];
        let is_none = spin.abs() <= ROUNDING * self.roller.norm() * twist.norm();
        if is_none { 0.0 } else { spin.signum() }
    }

    /// Returns the torque of all dry friction of the roller, of joint and axle, in N m, under a
    /// load in N.
    pub fn dry_n_m(&self, load_n: f64) -> f64 {
        self.roller_friction_n_m + self.axle_drag_m * load_n.max(0.0)
    }
}

pub(super) fn wheel_spin(wheel: &Wheel) -> Result<WheelSpin, ControlError> {
    // All rollers of a wheel are alike in any robot that rolls; the first represents the touching
    // one.
    let Some(roller) = wheel.rollers.first() else {
        return Err(ControlError::NoRollers {
            wheel: wheel.name.clone(),
        });
    };
    let (n, n_g, b) = (wheel.axis(), wheel.roller_axis(), wheel.position_m().xy());
    let (_, tensor) = wheel_about_center(wheel);
    let roller_on_axis = n.dot(&n_g);
    let j_r = roller.axial_inertia_kg_m2;
    // n . v_h / (r cos gamma) with v_h of eq. (2).
    let per_m_s = 1.0 / (roller.radius_m * libm::cos(wheel.gamma_rad));
    Ok(WheelSpin {
        wheel_inertia_kg_m2: tensor.m33 - j_r * roller_on_axis * roller_on_axis
            + wheel.drive.reflected_inertia_kg_m2(),
        roller: RowVector3::new(n.x, n.y, b.x * n.y - b.y * n.x) * per_m_s,
        roller_on_axis,
        roller_inertia_kg_m2: j_r,
        roller_damping_n_m_s: roller.joint.damping_n_m_s,
        roller_friction_n_m: roller.joint.friction_n_m,
        axle_drag_m: wheel.surface.axle_drag_n_m(1.0),
    })
}

/// Dot product; surplus elements of the longer operand are ignored.
fn dot<'a>(left: impl Iterator<Item = &'a f64>, right: &[f64]) -> f64 {
    left.zip(right).map(|(a, b)| a * b).sum()
}

/// Returns -1, 0 or 1: at rest friction is zero here, since its value is whatever holds the joint.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::joints::{driven, joint};
    use crate::tests::robots::mecanum4;

    /// An arm's mass and inertia enter I at the arm's pose: 3 kg, 0.5 m from a pivot at (0.1,
    /// 0.05), by parallel axes, and its part of the momentum.
    #[test]
    fn eq_11_inertia_is_that_of_the_pose() {
        let (arm_kg, out_m) = (3.0, 0.5);
        let pivot_m = Vector3::new(0.1, 0.05, 0.2);
        let own_kg_m2 = 0.4 * arm_kg * 0.1 * 0.1;
        let bare = DynamicModel::new(&mecanum4()).unwrap();
        let mut robot = mecanum4();
        let mass = (arm_kg, out_m * Vector3::x());
        robot
            .joints
            .push(driven(joint(pivot_m, Vector3::z(), mass)));
        for angle_rad in [0.0, 0.9, -2.1] {
            let model = DynamicModel::new(&robot.posed(&[angle_rad])).unwrap();
            let (sin, cos) = f64::sin_cos(angle_rad);
            let (x, y) = (pivot_m.x + out_m * cos, pivot_m.y + out_m * sin);
            for [vx, vy, omega] in [
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
                [0.3, -0.2, 2.0],
            ] {
                let mut rates = [0.0; 4];
                bare.kinematics()
                    .wheel_rates(Twist::new(vx, vy, omega), &mut rates);
                let added_j = model.kinetic_energy_j(&rates) - bare.kinetic_energy_j(&rates);
                let (ax, ay) = (vx - omega * y, vy + omega * x);
                let expected_j = 0.5 * (arm_kg * (ax * ax + ay * ay) + own_kg_m2 * omega * omega);
                assert!((added_j / expected_j - 1.0).abs() < 1e-9, "{added_j}");
            }
        }
    }

    /// Wheels moved outward by a joint turn the robot with their new lever arms: the rates of a
    /// rotation on the spot grow with the arm l + w of the mecanum matrix.
    #[test]
    fn eq_9_takes_wheels_where_their_joints_have_them() {
        let mut robot = mecanum4();
        for (index, side) in [(0, 1.0), (1, -1.0)] {
            robot.joints.push(driven(ilon_robot::BodyJoint {
                kind: ilon_robot::JointKind::Slides,
                ..joint(
                    Vector3::zeros(),
                    side * Vector3::y(),
                    (0.1, Vector3::zeros()),
                )
            }));
            for wheel in &mut robot.wheels {
                if wheel.position_m().y * side > 0.0 {
                    wheel.carrier = Some(index);
                }
            }
        }
        let rates = |robot: &Robot| {
            let mut rates = [0.0; 4];
            let model = DynamicModel::new(robot).unwrap();
            model
                .kinematics()
                .wheel_rates(Twist::new(0.0, 0.0, 1.0), &mut rates);
            rates
        };
        let (before, after) = (rates(&robot), rates(&robot.posed(&[0.08, 0.08])));
        for (before, after) in before.iter().zip(after) {
            let expected = before * (0.15 + 0.16 + 0.08) / (0.15 + 0.16);
            assert!((after / expected - 1.0).abs() < 1e-12, "{after} {expected}");
        }
    }

    /// The rotor turns with its wheel: a rotor of 2e-6 kg m^2 behind a gear of 30 counts 900 times
    /// at the wheel: 1.8e-3 kg m^2 more.
    #[test]
    fn a_wheel_turns_its_rotor_too() {
        let mut robot = mecanum4();
        let bare = wheel_spin(&robot.wheels[0]).unwrap();
        robot.wheels[0].drive.gear_ratio = 30.0;
        robot.wheels[0].drive.rotor_inertia_kg_m2 = 2e-6;
        let geared = wheel_spin(&robot.wheels[0]).unwrap();
        let more = geared.wheel_inertia_kg_m2 - bare.wheel_inertia_kg_m2;
        // The sums are only about a thousand times 1.8e-3, so rounding is far smaller.
        assert!((more - 1.8e-3).abs() < 1e-12, "{more}");
    }
}
