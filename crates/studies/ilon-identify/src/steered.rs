//! Steered tyres as wheels that are not steered, so that their robot has one map from wheel rates to
//! twists.
//!
//! A tyre that turns by dq and stands at the angle d moves the axis of its steering by
//! `r dq (cos d, sin d)`, along and across its direction at the angle 0. Two wheels with transverse
//! rollers in the place of the axis, one in each of these directions, move it likewise where they
//! turn by `dq cos d` and `dq sin d`. Both have the name of the tyre. Where its hub lies at o beside
//! the axis, the hub's turning about it, `(dtheta + dd) k x R(d) o`, is taken off before.
//!
//! A tyre without a motor and without a column of the log holds the robot along its axle and drives
//! nothing: a wheel that rolls along the axle and never turns. It has no name.

use std::collections::BTreeMap;

use ilon_robot::{Robot, Wheel, wrap_angle};
use ilon_sim::Error;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector2, Vector3};

use crate::log::Log;

/// A wheel of a log, and what stands for it.
#[derive(Clone, Debug, PartialEq)]
enum Part {
    /// A wheel that is not steered, by its index in the robot.
    Plain(usize),
    /// A steered tyre.
    Steered(Module),
    /// A tyre without a motor and without a column.
    Hold,
}

/// A steered tyre.
#[derive(Clone, Debug, PartialEq)]
struct Module {
    /// Its index in the robot.
    wheel: usize,
    /// Its steering joint, by its index in the robot.
    joint: usize,
    /// 1 for a joint that counts counter-clockwise from above, else -1.
    sign: f64,
    /// Where the hub lies from the axis at the angle 0, along and across the tyre's direction, over
    /// the radius.
    offset: [f64; 2],
}

/// A robot's wheels without their steering.
#[derive(Clone, Debug)]
pub(crate) struct Unsteered {
    /// The robot with the wheels that stand for its own.
    pub robot: Robot,
    parts: Vec<Part>,
}

/// Whether the kinematics of a robot depends on steering angles.
pub(crate) fn is_steered(robot: &Robot) -> bool {
    robot
        .wheels
        .iter()
        .any(|wheel| robot.steering_of(wheel).is_some())
}

/// Whether a wheel stands for a tyre's hold along its axle alone.
pub(crate) fn is_hold(wheel: &Wheel) -> bool {
    wheel.name.is_empty()
}

/// The joints that steer a robot's tyres, by their indices, without those that follow others.
pub(crate) fn steering_joints(robot: &Robot) -> Vec<usize> {
    let leads = |joint: &usize| robot.couplings.iter().all(|of| of.joint != *joint);
    let mut leader_of: Vec<usize> = robot
        .wheels
        .iter()
        .filter_map(|wheel| robot.steering_of(wheel))
        .map(|joint| {
            let followed = |at: &usize| {
                let coupling = robot.couplings.iter().find(|of| of.joint == *at);
                coupling.map(|of| of.follows)
            };
            std::iter::successors(Some(joint), followed)
                .find(leads)
                .unwrap_or(joint)
        })
        .collect();
    leader_of.sort_unstable();
    leader_of.dedup();
    leader_of
}

/// Whether a log must have a column of a wheel: where others are steered, not of casters, nor of
/// tyres without a motor that nothing steers.
pub(crate) fn needs_column(robot: &Robot, wheel: &Wheel) -> bool {
    let is_pulled =
        wheel.has_tyre() && wheel.motor.effort_n_m == 0.0 && robot.steering_of(wheel).is_none();
    !(is_steered(robot) && (robot.swivels(wheel) || is_pulled))
}

/// Whether a log whose columns of wheels are these has that of a wheel, or must have it.
pub(crate) fn has_column<T>(robot: &Robot, wheel: &Wheel, columns: &BTreeMap<String, T>) -> bool {
    needs_column(robot, wheel) || columns.contains_key(&wheel.name)
}

impl Unsteered {
    /// Returns the wheels that stand for those of a robot in logs that have columns of these.
    ///
    /// # Errors
    /// A steered wheel on rollers.
    pub fn new<T>(robot: &Robot, columns: &BTreeMap<String, T>) -> Result<Self, Error> {
        if !is_steered(robot) {
            let parts = (0..robot.wheels.len()).map(Part::Plain).collect();
            let robot = robot.clone();
            return Ok(Self { robot, parts });
        }
        let mut parts = Vec::new();
        let mut wheels = Vec::new();
        for (index, wheel) in robot.wheels.iter().enumerate() {
            match robot.steering_of(wheel) {
                _ if robot.swivels(wheel) => {}
                Some(_) if !wheel.has_tyre() => {
                    return Err(Error::invalid(
                        format!(
                            "`{}` is steered and has rollers: its effect depends on its angle in another way than that of a tyre",
                            wheel.name
                        ),
                        "fit robots whose rollers stand at fixed angles; of steered wheels those with tyres",
                    ));
                }
                Some(joint) => {
                    let (module, pair) = module(robot, index, joint);
                    parts.push(Part::Steered(module));
                    wheels.extend(pair);
                }
                None if !has_column(robot, wheel, columns) => {
                    parts.push(Part::Hold);
                    wheels.push(Wheel {
                        name: String::new(),
                        ..across(wheel)
                    });
                }
                None => {
                    parts.push(Part::Plain(index));
                    wheels.push(wheel.clone());
                }
            }
        }
        let mut robot = robot.clone();
        // What carried the wheels does not turn them any more.
        wheels.iter_mut().for_each(|wheel| wheel.carrier = None);
        robot.wheels = wheels;
        robot.joints.clear();
        robot.couplings.clear();
        Ok(Self { robot, parts })
    }

    /// Returns a log of the robot as one of the wheels that stand for its own.
    pub fn log(&self, log: &Log, built: &Robot) -> Log {
        if !is_steered(built) {
            return log.clone();
        }
        let mut angles = vec![0.0; self.robot.wheels.len()];
        let mut unsteered = log.clone();
        unsteered.steering_rad.clear();
        unsteered.begun_rad.clear();
        unsteered.angles_rad = vec![angles.clone()];
        for row in 0..log.len().saturating_sub(1) {
            let steps = self.parts.iter().flat_map(|part| part.steps(log, row));
            angles
                .iter_mut()
                .zip(steps)
                .for_each(|(angle, step)| *angle += step);
            unsteered.angles_rad.push(angles.clone());
        }
        unsteered
    }
}

impl Part {
    /// Returns by how much the wheels that stand for it turn from one row of a log to the next, in
    /// radians.
    fn steps(&self, log: &Log, row: usize) -> Vec<f64> {
        let turned = |wheel: usize| log.angles_rad[row + 1][wheel] - log.angles_rad[row][wheel];
        match self {
            Self::Plain(wheel) => vec![turned(*wheel)],
            Self::Hold => vec![0.0],
            Self::Steered(module) => {
                let [from, to] = [row, row + 1].map(|row| log.steering_rad[row][module.joint]);
                let steered = module.sign * wrap_angle(to - from);
                let (s, c) = libm::sincos(module.sign * from + 0.5 * steered);
                let swung = log.poses[row + 1][2] - log.poses[row][2] + steered;
                let [ahead, across] = module.offset;
                let rolled = turned(module.wheel);
                vec![
                    rolled * c + swung * (ahead * s + across * c),
                    rolled * s - swung * (ahead * c - across * s),
                ]
            }
        }
    }
}

/// Returns a steered tyre, and the two wheels that stand for it.
fn module(robot: &Robot, index: usize, joint: usize) -> (Module, [Wheel; 2]) {
    let wheel = &robot.wheels[index];
    let frame = &robot.joints[joint].body_from_joint;
    let along = ahead(wheel);
    let offset_m = wheel.position_m().xy() - frame.translation.vector.xy();
    let module = Module {
        wheel: index,
        joint,
        sign: (frame.rotation * Vector3::z()).z.signum(),
        offset: [offset_m.dot(&along), along.perp(&offset_m)].map(|m| m / wheel.radius_m),
    };
    let mut first = bare(wheel);
    first.body_from_hub.translation.vector.x = frame.translation.vector.x;
    first.body_from_hub.translation.vector.y = frame.translation.vector.y;
    let second = across(&first);
    (module, [first, second])
}

/// The direction in which a wheel rolls that turns forwards.
pub(crate) fn ahead(wheel: &Wheel) -> Vector2<f64> {
    let n = wheel.axis();
    Vector2::new(n.y, -n.x)
}

/// A wheel that rolls where another one stands, but freely sideways.
fn bare(wheel: &Wheel) -> Wheel {
    Wheel {
        rollers: Vec::new(),
        ..wheel.clone()
    }
}

/// The same a quarter of a turn further to the left.
fn across(wheel: &Wheel) -> Wheel {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
    let hub = &wheel.body_from_hub;
    Wheel {
        body_from_hub: Isometry3::from_parts(
            Translation3::from(hub.translation.vector),
            turn * hub.rotation,
        ),
        ..bare(wheel)
    }
}
