//! The wheel pushes that an acceleration needs, and the pushes that motors and grip allow.

use ilon_robot::{Robot, Twist, bisected};
use nalgebra::{Matrix3, Vector2, Vector3};

use super::loads::WheelLoads;
use super::model::{DynamicModel, WheelSpin, wheel_spin};
use super::traction::{PushRange, TractionSet};
use crate::ControlError;
use crate::actuation::motor::TorqueRange;
use crate::kinematics::matrix::{twist_of, vector_of};

/// A robot's masses, loads and pushes, with buffers for the results: nothing is allocated after
/// construction.
#[derive(Clone, Debug)]
pub(crate) struct Capacity {
    pub model: DynamicModel,
    pub set: TractionSet,
    loads: WheelLoads,
    gravity_m_s2: f64,
    /// Coulomb's friction coefficient; infinite to ignore grip.
    friction: f64,
    mass_kg: f64,
    center_of_mass_m: Vector2<f64>,
    /// Gravity component along the ground, in the body frame, in m/s^2; zero on level ground.
    downhill_m_s2: Vector2<f64>,
    /// The body's force per acceleration beyond the wheels' own: R^T (I - diag(J)) R.
    pub(super) body: Matrix3<f64>,
    /// The touching rollers, for robots whose axle friction depends on the load; otherwise empty.
    on_axles: Vec<WheelSpin>,
    // Buffers of one number per wheel.
    resistance_n_m: Vec<f64>,
    accelerations_rad_s2: Vec<f64>,
    /// Loads of the wheels at the last acceleration, in N.
    pub loads_n: Vec<f64>,
    /// Torque that each wheel needs for itself at the last acceleration, in N m.
    pub own_n_m: Vec<f64>,
    /// Pushes that the motors can give beside it.
    pub motor: Vec<PushRange>,
    /// Largest pushes that grip allows, in N.
    pub grips_n: Vec<f64>,
}

/// A state of the robot at which accelerations are evaluated.
pub(crate) struct Moment<'a> {
    pub rates: &'a [f64],
    /// Rates whose signs dry friction opposes.
    pub towards: &'a [f64],
    pub limits: &'a [TorqueRange],
    pub nu: Twist,
}

/// A friction coefficient so large that it never limits.
const UNLIMITED: f64 = 1e3;

impl Capacity {
    /// Builds the model on level ground, with a friction coefficient (infinite to ignore grip) and
    /// gravity in m/s^2, both checked by the caller.
    pub fn new(robot: &Robot, friction: f64, gravity_m_s2: f64) -> Result<Self, ControlError> {
        let model = DynamicModel::new(robot)?;
        let n = model.kinematics().wheel_count();
        let r = model.kinematics().rate_matrix();
        let mut beyond_own = model.inertia().clone();
        for (h, own) in model.wheel_inertias_kg_m2().iter().enumerate() {
            beyond_own[(h, h)] -= own;
        }
        let body: Matrix3<f64> = (r.transpose() * beyond_own * r)
            .fixed_view::<3, 3>(0, 0)
            .into();
        let spins: Result<Vec<_>, _> = robot.wheels.iter().map(wheel_spin).collect();
        let mut on_axles = spins?;
        if on_axles.iter().all(|spin| spin.axle_drag_m == 0.0) {
            on_axles.clear();
        }
        Ok(Self {
            on_axles,
            loads: WheelLoads::new(robot, gravity_m_s2),
            set: TractionSet::new(model.kinematics()),
            gravity_m_s2,
            friction,
            mass_kg: robot.mass_kg(),
            center_of_mass_m: robot.center_of_mass_m().xy(),
            downhill_m_s2: Vector2::zeros(),
            body,
            resistance_n_m: vec![0.0; n],
            accelerations_rad_s2: vec![0.0; n],
            loads_n: vec![0.0; n],
            own_n_m: vec![0.0; n],
            motor: vec![PushRange::default(); n],
            grips_n: vec![0.0; n],
            model,
        })
    }

    /// Returns the model in another pose of the robot's joints, on the same ground.
    pub fn posed(&self, posed: &Robot) -> Result<Self, ControlError> {
        Ok(Self {
            downhill_m_s2: self.downhill_m_s2,
            ..Self::new(posed, self.friction, self.gravity_m_s2)?
        })
    }

    /// Sets the gravity component along the ground, in the body frame, in m/s^2; the normal
    /// component was set at construction.
    pub fn pull_downhill(&mut self, downhill_m_s2: Vector2<f64>) {
        self.downhill_m_s2 = downhill_m_s2;
    }

    /// Gravity component normal to the ground, in m/s^2.
    pub fn gravity_m_s2(&self) -> f64 {
        self.gravity_m_s2
    }

    /// [`WheelLoads::margin_m`] at an acceleration without rotation, on this ground.
    pub fn margin_m(&self, acceleration_m_s2: Vector2<f64>) -> f64 {
        self.loads.margin_m(acceleration_m_s2 - self.downhill_m_s2)
    }

    /// Computes what does not depend on the acceleration; call it first at each new moment.
    pub fn begin(&mut self, moment: &Moment<'_>) {
        self.model
            .resistance_towards(moment.rates, moment.towards, &mut self.resistance_n_m);
    }

    /// Whether the wheels can give the pushes that an acceleration needs.
    pub fn within(&mut self, moment: &Moment<'_>, nu_rate: Vector3<f64>) -> bool {
        let force = self.weigh(moment, nu_rate);
        let ranges = self
            .motor
            .iter()
            .zip(&self.grips_n)
            .map(|(motor, grip_n)| motor.within(PushRange::of_grip(*grip_n)));
        // 1e-9 N: rounding at the boundary must not reduce a task.
        self.set.reaches(&force, ranges, 1e-9)
    }

    /// Returns the largest weight in [0, 1] with which `task` can be added to the acceleration
    /// `given`.
    pub fn weight(&mut self, moment: &Moment<'_>, given: Vector3<f64>, task: Vector3<f64>) -> f64 {
        if self.within(moment, given + task) {
            return 1.0;
        }
        // The set is convex and its ranges are linear in the acceleration (except for a lifted
        // wheel's load), so the feasible weights form an interval from zero. Thirty bisections
        // leave 1e-9 of the task.
        let fits = |weight: f64| self.within(moment, given + weight * task);
        bisected((0.0, 1.0), 30, fits).0
    }

    /// Returns the force on the body that an acceleration needs. Also computes the torque that each
    /// wheel needs for itself, and the pushes that motors and grip leave.
    pub fn weigh(&mut self, moment: &Moment<'_>, nu_rate: Vector3<f64>) -> Vector3<f64> {
        let kinematics = self.model.kinematics();
        kinematics.wheel_rates(twist_of(nu_rate), &mut self.accelerations_rad_s2);
        self.model
            .own_resistance(moment.rates, moment.towards, &mut self.own_n_m);

        let mut force = self.body * nu_rate;
        let rows = kinematics.rate_matrix().row_iter();
        for (row, (resistance, own)) in rows.zip(self.resistance_n_m.iter().zip(&self.own_n_m)) {
            force += row.transpose() * (resistance - own);
        }
        let (down, c) = (self.downhill_m_s2, self.center_of_mass_m);
        force -= self.mass_kg * Vector3::new(down.x, down.y, c.x * down.y - c.y * down.x);
        let inertias = self.model.wheel_inertias_kg_m2();
        for (h, own) in self.own_n_m.iter_mut().enumerate() {
            *own += inertias[h] * self.accelerations_rad_s2[h];
            let lever_m = kinematics.lever_m()[h];
            self.motor[h] = PushRange::beside(*own, &moment.limits[h], lever_m);
        }

        // v' + omega k x v: the acceleration in space, which shifts the load, less the downhill
        // gravity.
        let omega = moment.nu.omega_rad_s;
        let turning = omega * Vector2::new(-moment.nu.vy_m_s, moment.nu.vx_m_s);
        self.loads
            .fill_n(nu_rate.xy() + turning - down, &mut self.loads_n);
        if !self.on_axles.is_empty() {
            let towards = vector_of(kinematics.twist(moment.towards));
            for (spin, load_n) in self.on_axles.iter().zip(&self.loads_n) {
                let drag_n_m = spin.axle_drag_m * load_n.max(0.0) * spin.way(&towards);
                force += drag_n_m * spin.roller.transpose();
            }
        }
        // Without a friction coefficient any grip proportional to the loads gives the same
        // distribution.
        let friction = if self.friction.is_finite() {
            self.friction
        } else {
            UNLIMITED
        };
        for (grip_n, load_n) in self.grips_n.iter_mut().zip(&self.loads_n) {
            *grip_n = friction * load_n;
        }
        force
    }
}
