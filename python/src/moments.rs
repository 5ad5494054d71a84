//! The state of a robot at one moment, with numpy arrays for vectors.

use ilon::robot::{Pose, Twist};
use ilon::simulate::{Measurements, Plant};
use ilon::trace;
use ilon::world::{BodyState, FreeBodyState, WheelTally};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

use crate::typed::Floats;

type Array<'py> = Floats<'py>;

fn array<'py>(py: Python<'py>, numbers: &[f64]) -> Array<'py> {
    PyArray1::from_slice(py, numbers).into()
}

/// A pose as three numbers: x and y in metres, heading in radians.
fn of_pose(pose: &Pose) -> [f64; 3] {
    [pose.x_m, pose.y_m, pose.heading_rad]
}

/// A twist as three numbers: in m/s, m/s and rad/s.
fn of_twist(twist: &Twist) -> [f64; 3] {
    [twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s]
}

/// Defines the getters of a class, one per line: docstring, name, type, and expression in terms of
/// the object and the interpreter, which are named first. The other methods follow after the `;`.
macro_rules! getters {
    (
        $class:ident |$me:ident, $py:ident|
        $($(#[$about:meta])* $name:ident: $type:ty = $read:expr;)*
        ;
        $($others:tt)*
    ) => {
        #[pymethods]
        impl $class {
            $(
                $(#[$about])*
                #[getter]
                fn $name<'py>(&self, $py: Python<'py>) -> $type {
                    let ($me, _) = (self, $py);
                    $read
                }
            )*

            $($others)*
        }
    };
}

/// What a robot's sensors say at one moment.
#[pyclass(frozen, module = "ilon")]
pub struct Observation {
    /// Simulated time in seconds.
    #[pyo3(get)]
    t_s: f64,
    seen: Measurements,
}

impl Observation {
    /// The measurements at a time in seconds.
    pub fn new(t_s: f64, seen: Measurements) -> Self {
        Self { t_s, seen }
    }
}

getters! { Observation |me, py|
    /// The newest pose that has arrived, in the world frame: x in m, y in m, heading in rad.
    pose: Array<'py> = array(py, &of_pose(&me.seen.pose));
    /// The wheels' rates in rad/s, in the robot's order.
    wheel_rates_rad_s: Array<'py> = array(py, &me.seen.wheel_rates_rad_s);
    /// The wheels' angles since the start in rad, as the encoders counted them.
    wheel_angles_rad: Array<'py> = array(py, &me.seen.wheel_angles_rad);
    /// What the inertial measurement unit said last; None without `[sensors.imu]`.
    imu: Option<Imu> = me.seen.imu.map(Imu);
    ;

    fn __repr__(&self) -> String {
        let [x_m, y_m, heading_rad] = of_pose(&self.seen.pose);
        format!(
            "Observation(t_s={:.4}, pose=[{x_m:.4}, {y_m:.4}, {heading_rad:.4}])",
            self.t_s
        )
    }
}

/// What an inertial measurement unit says, in the body frame.
#[pyclass(frozen, module = "ilon")]
pub struct Imu(trace::ImuSample);

getters! { Imu |me, py|
    /// The rate of turn about x, y and z in rad/s.
    rate_rad_s: Array<'py> = array(py, me.0.rate_rad_s.as_slice());
    /// The specific force along x, y and z in m/s^2: acceleration less gravity, upwards at rest.
    specific_force_m_s2: Array<'py> = array(py, me.0.specific_force_m_s2.as_slice());
    /// Roll against gravity in rad, by the robot's filter.
    roll_rad: f64 = me.0.roll_rad;
    /// Pitch against gravity in rad, by the robot's filter.
    pitch_rad: f64 = me.0.pitch_rad;
    ;

    fn __repr__(&self) -> String {
        let (roll_rad, pitch_rad) = (self.0.roll_rad, self.0.pitch_rad);
        format!("Imu(roll_rad={roll_rad:.4}, pitch_rad={pitch_rad:.4})")
    }
}

/// Where the robot really is and how it really moves, whatever its sensors say.
#[pyclass(frozen, module = "ilon")]
pub struct Truth(pub trace::Truth);

getters! { Truth |me, py|
    /// The body's pose in the world frame: x in m, y in m, heading in rad.
    pose: Array<'py> = array(py, &of_pose(&me.0.pose));
    /// The body's twist in its own frame: vx in m/s, vy in m/s, yaw rate in rad/s.
    twist_in_body: Array<'py> = array(py, &of_twist(&me.0.twist_in_body));
    /// Height of the body's origin above the floor, in m.
    height_m: f64 = me.0.height_m;
    /// Roll in rad.
    roll_rad: f64 = me.0.roll_rad;
    /// Pitch in rad.
    pitch_rad: f64 = me.0.pitch_rad;
    ;

    fn __repr__(&self) -> String {
        let [x_m, y_m, heading_rad] = of_pose(&self.0.pose);
        let [vx, vy, omega] = of_twist(&self.0.twist_in_body);
        format!(
            "Truth(pose=[{x_m:.4}, {y_m:.4}, {heading_rad:.4}], twist_in_body=[{vx:.4}, {vy:.4}, {omega:.4}])"
        )
    }
}

/// The robot's body in three dimensions, as it really is.
#[pyclass(frozen, module = "ilon")]
pub struct Body {
    state: BodyState,
    acceleration_in_world_m_s2: [f64; 3],
    gravity_in_world_m_s2: [f64; 3],
}

impl Body {
    /// The current state of a plant's body.
    pub fn of(plant: &Plant) -> Self {
        Self {
            state: plant.world().robot().state(),
            acceleration_in_world_m_s2: plant.outcome().acceleration_in_world_m_s2,
            gravity_in_world_m_s2: plant.world().gravity_in_world_m_s2().into(),
        }
    }
}

getters! { Body |me, py|
    /// The body frame's origin in the world: x, y, z in m.
    position_m: Array<'py> = {
        let BodyState { pose, height_m, .. } = &me.state;
        array(py, &[pose.x_m, pose.y_m, *height_m])
    };
    /// How the body is turned in the world: a unit quaternion w, x, y, z.
    quaternion_wxyz: Array<'py> = {
        let [x, y, z, w] = me.state.world_from_body.coords.into();
        array(py, &[w, x, y, z])
    };
    /// Velocity of the body frame's origin, in the world frame, in m/s.
    velocity_in_world_m_s: Array<'py> = {
        let velocity_m_s = me.state.world_from_body * me.state.velocity_in_body_m_s;
        array(py, velocity_m_s.as_slice())
    };
    /// Rates about the axes of the body frame, in rad/s.
    angular_in_body_rad_s: Array<'py> = array(py, me.state.angular_in_body_rad_s.as_slice());
    /// Acceleration of the body frame's origin in the world frame, in m/s^2: the mean over the last
    /// advance.
    acceleration_in_world_m_s2: Array<'py> = array(py, &me.acceleration_in_world_m_s2);
    /// The acceleration of gravity in the world frame, in m/s^2. On a slope it leans.
    gravity_in_world_m_s2: Array<'py> = array(py, &me.gravity_in_world_m_s2);
    ;

    fn __repr__(&self) -> String {
        let BodyState { pose, height_m, .. } = &self.state;
        let Pose { x_m, y_m, .. } = pose;
        format!("Body(position_m=[{x_m:.4}, {y_m:.4}, {height_m:.4}])")
    }
}

/// The robot's wheels and their contacts, as they really are, in the robot's order.
#[pyclass(frozen, module = "ilon")]
pub struct Wheels {
    angles_rad: Vec<f64>,
    rates_rad_s: Vec<f64>,
    over: Vec<WheelTally>,
}

impl Wheels {
    /// The current state of a plant's wheels.
    pub fn of(plant: &Plant) -> Self {
        let robot = plant.world().robot();
        Self {
            angles_rad: robot.wheel_angles_rad().to_vec(),
            rates_rad_s: robot.wheel_rates_rad_s().to_vec(),
            over: plant.outcome().wheels.clone(),
        }
    }

    fn each<'py>(&self, py: Python<'py>, of: impl Fn(&WheelTally) -> f64) -> Array<'py> {
        array(py, &self.over.iter().map(of).collect::<Vec<_>>())
    }

    fn rows<'py, const N: usize>(
        &self,
        py: Python<'py>,
        row: impl Fn(&WheelTally) -> [f64; N],
    ) -> PyResult<Floats<'py>> {
        let flat = self.over.iter().flat_map(row).collect::<Vec<_>>();
        let rows = PyArray1::from_vec(py, flat).reshape([self.over.len(), N])?;
        Ok(rows.into())
    }
}

getters! { Wheels |me, py|
    /// Angles about the wheels' axes since the start, in rad, not wrapped.
    angles_rad: Array<'py> = array(py, &me.angles_rad);
    /// Rates about the wheels' axes, in rad/s.
    rates_rad_s: Array<'py> = array(py, &me.rates_rad_s);
    /// The ground's normal forces in N: means over the last advance.
    loads_n: Array<'py> = me.each(py, WheelTally::normal_force_mean_n);
    /// The largest share of its friction limit that each wheel used in the last advance; 1 where it
    /// slid.
    friction_used_max: Array<'py> = me.each(py, |wheel| wheel.friction_used_max);
    /// The largest sliding speed of each wheel in the last advance, in m/s.
    slip_speed_max_m_s: Array<'py> = me.each(py, |wheel| wheel.sliding_max_m_s);
    /// The ground's tangential forces: a row of x and y in the body frame for each wheel, in N:
    /// means over the last advance.
    forces_in_body_n: PyResult<Floats<'py>> = me.rows(py, |wheel| wheel.force_mean_in_body_n().into());
    /// Velocities of the rollers' surfaces over the ground: a row of x and y in the body frame for
    /// each wheel, in m/s: means over the time of the last advance in which the wheel touched.
    slip_in_body_m_s: PyResult<Floats<'py>> = me.rows(py, |wheel| wheel.sliding_mean_in_body_m_s().into());
    ;

    fn __repr__(&self) -> String {
        format!("Wheels(rates_rad_s={:.4?})", self.rates_rad_s)
    }
}

/// A free body of the scenario, as it really is.
#[pyclass(frozen, module = "ilon")]
pub struct FreeBody(FreeBodyState);

impl FreeBody {
    /// The current state of a plant's free bodies with their names, in the scenario's order.
    pub fn all_of(plant: &Plant) -> impl Iterator<Item = (&str, Self)> {
        let world = plant.world();
        world.free_bodies().iter().filter_map(|id| {
            let (name, state) = (world.free_body_name(*id)?, world.free_body(*id)?);
            Some((name, Self(state)))
        })
    }
}

getters! { FreeBody |me, py|
    /// Its middle in the world: x, y, z in m.
    position_m: Array<'py> = array(py, me.0.place_m.as_slice());
    /// How it is turned in the world: a unit quaternion w, x, y, z.
    quaternion_wxyz: Array<'py> = {
        let [x, y, z, w] = me.0.rotation.coords.into();
        array(py, &[w, x, y, z])
    };
    /// Velocity of its middle, in the world frame, in m/s.
    velocity_in_world_m_s: Array<'py> = array(py, me.0.velocity_m_s.as_slice());
    /// Its angular velocity, in the world frame, in rad/s.
    angular_in_world_rad_s: Array<'py> = array(py, me.0.angular_rad_s.as_slice());
    /// The robot's force on it in the world frame, in N: the mean over the last physics step.
    force_of_robot_n: Array<'py> = array(py, me.0.force_from_robots_n.as_slice());
    /// Work that the robot has done on it since the start, in J: less what it did on the robot.
    work_of_robot_j: f64 = me.0.work_of_robots_j;
    /// Whether it rests, and is left alone until something comes near.
    sleeps: bool = me.0.sleeps;
    ;

    fn __repr__(&self) -> String {
        let [x_m, y_m, z_m] = self.0.place_m.into();
        format!("FreeBody(position_m=[{x_m:.4}, {y_m:.4}, {z_m:.4}])")
    }
}

/// Where a reference wants the robot, and how fast.
#[pyclass(frozen, module = "ilon")]
pub struct Desired(pub ilon::control::Desired);

getters! { Desired |me, py|
    /// The pose in the world frame: x in m, y in m, heading in rad, which is not wrapped.
    pose: Array<'py> = array(py, &of_pose(&me.0.pose));
    /// Its time derivative in the world frame: in m/s, m/s and rad/s.
    velocity_in_world: Array<'py> = array(py, &of_twist(&me.0.velocity_in_world));
    ;

    fn __repr__(&self) -> String {
        let [x_m, y_m, heading_rad] = of_pose(&self.0.pose);
        format!("Desired(pose=[{x_m:.4}, {y_m:.4}, {heading_rad:.4}])")
    }
}

/// What came of an advance.
#[pyclass(frozen, module = "ilon")]
pub struct Outcome {
    /// Mean torques in N m.
    pub torques_n_m: Vec<f64>,
    /// By how much the laws of contact were broken at worst, in m/s: the speed of what moves and
    /// should not.
    #[pyo3(get)]
    pub contact_residual_m_s: f64,
}

getters! { Outcome |me, py|
    /// The torques that the motors put on the wheels in N m: the mean over the time.
    torques_n_m: Array<'py> = array(py, &me.torques_n_m);
    ;

    fn __repr__(&self) -> String {
        format!("Outcome(torques_n_m={:.4?})", self.torques_n_m)
    }
}
