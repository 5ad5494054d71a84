//! Drives of the simulated robot under commanded body twists.

use std::f64::consts::TAU;

use ilon_control::{Kinematics, SpeedLimits};
use ilon_robot::{Robot, Twist};
use nalgebra::Vector3;

use crate::Error;
use crate::scenario::Scenario;
use crate::simulate::{Driver, Plant, WheelCommand, resolve_for};

/// Largest commanded wheel rate, in sqrt(g / radius); a robot at this rate is fast for its size. At
/// most nine tenths of the wheels' own limit. Both chosen.
const FASTEST: f64 = 1.5;
const SHARE_OF_LIMIT: f64 = 0.9;

/// A robot at rest, for repeated drives.
pub(super) struct Track {
    fresh: Plant,
    kinematics: Kinematics,
    limits: SpeedLimits,
    /// The largest commanded wheel rate, in rad/s.
    pub wheel_rate_rad_s: f64,
    /// Time between two samples, in seconds: the physics step.
    pub dt_s: f64,
    /// The robot's unit of time, sqrt(radius / g), in seconds.
    pub unit_s: f64,
}

/// Commanded and reached twists, one pair per step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlanarDrive {
    /// The commanded body twists, in m/s, m/s and rad/s.
    pub asked: Vec<Vector3<f64>>,
    /// The body's twists at the end of each step.
    pub came: Vec<Vector3<f64>>,
}

pub(super) fn twist(of: Vector3<f64>) -> Twist {
    Twist::new(of.x, of.y, of.z)
}

pub(super) fn vector(of: Twist) -> Vector3<f64> {
    Vector3::new(of.vx_m_s, of.vy_m_s, of.omega_rad_s)
}

impl Track {
    /// A robot with the floor, motors and wheel loops of a scenario.
    pub fn new(scenario: &Scenario, robot: &Robot) -> Result<Self, Error> {
        let resolved = resolve_for(scenario, robot, Driver::Own)?;
        let fresh = Plant::new(&resolved, robot)?;
        let kinematics = fresh.kinematics().clone();
        let radius_m = robot.mean_wheel_radius_m();
        let unit_s = libm::sqrt(radius_m / scenario.world.gravity_m_s2.max(1e-3));
        let limit_rad_s = resolved.wheel_rate_limit_rad_s();
        let wheel_rate_rad_s = (SHARE_OF_LIMIT * limit_rad_s).min(FASTEST / unit_s);
        Ok(Self {
            limits: SpeedLimits::uniform(&kinematics, wheel_rate_rad_s),
            fresh,
            kinematics,
            wheel_rate_rad_s,
            dt_s: resolved.physics_dt_s(),
            unit_s,
        })
    }

    /// The fastest twist along a direction.
    pub fn fastest(&self, direction: Vector3<f64>) -> Vector3<f64> {
        direction / self.limits.share(twist(direction))
    }

    /// The robot at rest.
    pub fn plant(&self) -> Plant {
        self.fresh.clone()
    }

    /// Advances by one physics step with the wheel rates of a twist, and returns the body's twist
    /// after it.
    pub fn step(&self, plant: &mut Plant, asked: Vector3<f64>) -> Result<Vector3<f64>, Error> {
        let mut rates_rad_s = vec![0.0; self.kinematics.wheel_count()];
        self.kinematics.wheel_rates(twist(asked), &mut rates_rad_s);
        plant.advance(WheelCommand::Rates(&rates_rad_s), self.dt_s)?;
        Ok(vector(plant.truth().twist_in_body))
    }

    /// The number of steps in a time given in the robot's units.
    pub fn steps(&self, units: f64) -> usize {
        (units * self.unit_s / self.dt_s).ceil() as usize
    }

    /// A drive from rest.
    pub fn drive(&self, asked: Vec<Vector3<f64>>) -> Result<PlanarDrive, Error> {
        let mut plant = self.plant();
        let came = asked.iter().map(|asked| self.step(&mut plant, *asked));
        Ok(PlanarDrive {
            came: came.collect::<Result<_, _>>()?,
            asked,
        })
    }

    /// A pseudo-random drive: twists in all directions up to a share of the fastest, each held for
    /// a while. The same number gives the same drive.
    pub fn by_chance(&self, number: usize, units: f64) -> Vec<Vector3<f64>> {
        /// The generalised golden ratio of four dimensions, the root of x^5 = x + 1: its powers
        /// fill the cube evenly (Roberts 2018).
        const RATIO: f64 = 1.167_303_978_261_418_7;
        const MOST: f64 = 0.6;
        const HELD: [f64; 2] = [4.0, 16.0];
        let mut asked = Vec::new();
        let steps = self.steps(units);
        let mut piece = 1 + 1000 * number;
        while asked.len() < steps {
            let [around, up, size, long] =
                [1, 2, 3, 4].map(|power| (piece as f64 / RATIO.powi(power)).fract());
            let height = 2.0 * up - 1.0;
            let (sin, cos) = libm::sincos(TAU * around);
            let level = libm::sqrt(1.0 - height * height);
            let tops = self.tops();
            let way = Vector3::new(level * cos, level * sin, height).component_mul(&tops);
            let twist = self.fastest(way) * (MOST * size);
            let held = self.steps(HELD[0] + (HELD[1] - HELD[0]) * long);
            asked.extend(std::iter::repeat_n(twist, held));
            piece += 1;
        }
        asked.truncate(steps);
        asked
    }

    /// The top speed along each axis.
    pub fn tops(&self) -> Vector3<f64> {
        let along = |axis: usize| self.fastest(Vector3::ith(axis, 1.0))[axis];
        Vector3::new(along(0), along(1), along(2))
    }
}
