//! Test cases for both engines.

use ilon_formats::LoadRobot;
use ilon_oracle::{ContactLaw, Plate};
use ilon_robot::{Robot, Twist, Wheel};
use nalgebra::Vector3;

/// Period at which commands change and rows are recorded, in seconds.
pub const TICK_S: f64 = 0.005;

/// Torque of a wheel per lag behind its target rate, in N m s/rad. No integral, no limit.
pub const GAIN_N_M_S: f64 = 0.3;

/// The drive of the wheels.
#[derive(Clone, Debug, PartialEq)]
pub enum Wheels {
    /// Each follows the rate that the ideal kinematics gives for this twist of the body.
    Follow(Twist),
    /// Each follows its rate, in rad/s, but those that no motor drives.
    At(Vec<f64>),
    /// None.
    Free,
}

/// A force on the chassis's centre of mass.
#[derive(Clone, Copy, Debug)]
pub struct Shove {
    pub force_in_world_n: Vector3<f64>,
    pub from_s: f64,
    pub until_s: f64,
}

/// A test case.
pub struct Case {
    pub name: String,
    pub robot: Robot,
    pub friction: f64,
    pub duration_s: f64,
    pub wheels: Box<dyn Fn(f64) -> Wheels + Sync>,
    pub locked_wheel: Option<usize>,
    pub shove: Option<Shove>,
    /// The direction of a nap in the world, in radians, and friction across it over that along it.
    pub nap: Option<(f64, f64)>,
    /// Plates on the floor.
    pub plates: Vec<Plate>,
    /// Damping along normals and across them, over that of [`ContactLaw::stiff`].
    pub damped: [f64; 2],
}

/// A robot of the project's assets.
pub fn robot(name: &str) -> Robot {
    let root = env!("CARGO_MANIFEST_DIR");
    Robot::load(format!("{root}/../../../assets/robots/{name}.urdf")).expect("a shipped robot")
}

impl Case {
    /// A drive on a floor.
    pub fn new(
        name: impl Into<String>,
        robot: Robot,
        friction: f64,
        duration_s: f64,
        wheels: impl Fn(f64) -> Wheels + Sync + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            robot,
            friction,
            duration_s,
            wheels: Box::new(wheels),
            locked_wheel: None,
            shove: None,
            nap: None,
            plates: Vec::new(),
            damped: [1.0; 2],
        }
    }

    /// The law of contacts with springs of a stiffness in N/m.
    pub fn contact(&self, stiffness_n_m: f64) -> ContactLaw {
        let stiff = ContactLaw::stiff(stiffness_n_m, self.friction, &self.robot);
        let [along, across] = self.damped;
        ContactLaw {
            normal_damping_n_s_m: along * stiff.normal_damping_n_s_m,
            bristle_damping_n_s_m: across * stiff.bristle_damping_n_s_m,
            ..stiff
        }
    }

    /// Number of ticks of the case.
    pub fn ticks(&self) -> usize {
        (self.duration_s / TICK_S).round() as usize
    }

    /// Target rates of the wheels in the tick that starts at `t_s`, in rad/s; `None` if they are
    /// free.
    pub fn targets_rad_s(&self, t_s: f64) -> Option<Vec<f64>> {
        match (self.wheels)(t_s + 1e-9) {
            Wheels::Follow(twist) => {
                let rate = |wheel| rate_of(wheel, twist);
                Some(self.robot.wheels.iter().map(rate).collect())
            }
            Wheels::At(rates_rad_s) => Some(rates_rad_s),
            Wheels::Free => None,
        }
    }

    /// Whether a motor drives a wheel.
    pub fn drives(&self, wheel: usize) -> bool {
        self.locked_wheel != Some(wheel) && self.robot.wheels[wheel].motor.effort_n_m > 0.0
    }

    /// The force in the tick that starts at `t_s`, in N.
    pub fn force_n(&self, t_s: f64) -> Option<Vector3<f64>> {
        let shove = self.shove?;
        let acts = (shove.from_s..shove.until_s).contains(&(t_s + 0.5 * TICK_S));
        acts.then_some(shove.force_in_world_n)
    }

    /// Point of application of the force in the body frame, in metres.
    pub fn pushed_at_m(&self) -> Vector3<f64> {
        self.robot.chassis.mass.center_of_mass_m
    }

    /// The largest distance of a wheel from the body's origin, in metres: its displacement per
    /// radian of the robot's turn.
    pub fn arm_m(&self) -> f64 {
        let arms = self.robot.wheels.iter().map(|w| w.position_m().xy().norm());
        arms.fold(0.0, f64::max)
    }
}

/// The rate at which a wheel's lowest roller does not slide along its axis **a** while the body
/// moves with a twist, in rad/s: **a** . (v + omega x **b** + q' **p**) = 0, with **p** the
/// velocity of the wheel's lowest point at unit rate.
fn rate_of(wheel: &Wheel, twist: Twist) -> f64 {
    let (a, b, n) = (wheel.roller_axis(), wheel.position_m(), wheel.axis());
    let velocity = Vector3::new(
        twist.vx_m_s - twist.omega_rad_s * b.y,
        twist.vy_m_s + twist.omega_rad_s * b.x,
        0.0,
    );
    let lowest = Vector3::new(0.0, 0.0, -wheel.radius_m);
    let p = Vector3::new(n.x, n.y, 0.0).cross(&lowest);
    -a.dot(&velocity.xy()) / a.dot(&p.xy())
}

/// From rest to `end`, starting at `from_s`, at constant acceleration within `ramp_s`.
pub fn ramp(end: Twist, from_s: f64, ramp_s: f64) -> impl Fn(f64) -> Twist {
    move |t_s| end.scaled(((t_s - from_s) / ramp_s).clamp(0.0, 1.0))
}
