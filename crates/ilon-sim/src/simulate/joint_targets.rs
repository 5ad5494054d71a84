//! Where the servos of joints between bodies are sent: by the scenario's setpoints, or by whoever drives the plant.

use std::sync::Arc;

use ilon_robot::{BodyJoint, JointKind, JointRole, Robot};
use ilon_world::World;

use super::playback::Played;
use crate::Error;
use crate::scenario::{Between, Joint, Scenario};

/// The targets of the joints that servos drive.
#[derive(Clone, Debug)]
pub(super) struct JointTargets {
    joints: Vec<Driven>,
}

/// A joint that a servo drives.
#[derive(Clone, Debug)]
struct Driven {
    /// Its place among the robot's joints.
    index: usize,
    aim: Aim,
}

/// What sends its servo.
#[derive(Clone, Debug)]
enum Aim {
    /// Setpoints: time in seconds and position, and how the target goes between them. At least one.
    Setpoints(Arc<[[f64; 2]]>, Between),
    /// Somebody from outside: position and rate.
    Given([f64; 2]),
}

impl JointTargets {
    /// Where a scenario, and its log, send a robot's joints.
    ///
    /// # Errors
    /// [`Error::Invalid`] for setpoints in the other kind of joint's unit, or beyond its limits.
    pub fn new(scenario: &Scenario, played: &Played, robot: &Robot) -> Result<Self, Error> {
        let mut joints = Vec::new();
        for (index, of) in robot.joints.iter().enumerate() {
            let Some(servo) = of.servo() else {
                continue;
            };
            let asked = scenario.robot.joints.get(&of.name);
            let asked = asked.filter(|asked| !asked.setpoints.is_empty());
            let logged = played.joints.iter().find(|(joint, _)| *joint == index);
            let aim = match (asked, logged) {
                (Some(asked), _) => {
                    Aim::Setpoints(points(asked, robot, index)?.into(), asked.between)
                }
                (None, Some((_, rows))) => {
                    rows.iter()
                        .try_for_each(|[t_s, position]| check(of, *t_s, *position))?;
                    Aim::Setpoints(rows.as_slice().into(), Between::Linear)
                }
                (None, None) => Aim::Given([servo.target, 0.0]),
            };
            joints.push(Driven { index, aim });
        }
        Ok(Self { joints })
    }

    /// A robot as its servos start it, its joints counted from there.
    pub fn standing(&self, robot: &Robot) -> Robot {
        robot.posed(&self.at(0.0, robot))
    }

    /// A robot whose servos begin where they are sent first: a log is read after the robot.
    pub fn begun(&self, robot: &Robot) -> Robot {
        let mut robot = robot.clone();
        let positions = self.at(0.0, &robot);
        for (joint, position) in robot.joints.iter_mut().zip(positions) {
            if let JointRole::Driven(servo) = &mut joint.role {
                servo.target = position;
            }
        }
        robot
    }

    /// Where the servos send a robot's joints at a time, in rad or m; zero of a joint that nothing drives.
    pub fn at(&self, t_s: f64, robot: &Robot) -> Vec<f64> {
        let mut positions = vec![0.0; robot.joints.len()];
        for driven in &self.joints {
            positions[driven.index] = driven.aim_at(t_s)[0];
        }
        positions
    }

    /// Sends a joint's servo somewhere from now on: position and rate.
    pub fn give(&mut self, joint: usize, at: [f64; 2]) {
        let mut joints = self.joints.iter_mut();
        if let Some(driven) = joints.find(|driven| driven.index == joint) {
            driven.aim = Aim::Given(at);
        }
    }

    /// Tells the servos where they go in a step whose middle is at a time in seconds.
    pub fn send(&self, middle_s: f64, world: &mut World) {
        for driven in &self.joints {
            let [position, rate] = driven.aim_at(middle_s);
            let sent = world.robot_mut().aim_joint(driven.index, position, rate);
            debug_assert!(sent.is_ok(), "what no servo can do was refused before");
        }
    }
}

impl Driven {
    /// Where it is sent at a time in seconds: position and rate.
    fn aim_at(&self, t_s: f64) -> [f64; 2] {
        match &self.aim {
            Aim::Setpoints(points, between) => at_time(points, *between, t_s),
            Aim::Given(at) => *at,
        }
    }
}

/// The setpoints of a joint in its unit.
fn points(asked: &Joint, robot: &Robot, index: usize) -> Result<Vec<[f64; 2]>, Error> {
    let of = &robot.joints[index];
    let (key, moves) = match of.kind {
        JointKind::Turns => ("position_rad", "turns"),
        JointKind::Slides => ("position_m", "slides"),
    };
    let point = |point: &crate::scenario::JointSetpoint| {
        let position = match of.kind {
            JointKind::Turns => point.position_rad,
            JointKind::Slides => point.position_m,
        };
        let Some(position) = position else {
            return Err(Error::invalid(
                format!(
                    "the joint `{}` {moves}, and a setpoint of it has no `{key}`",
                    of.name
                ),
                format!("write `{key}` in its setpoints"),
            ));
        };
        check(of, point.t_s, position)?;
        Ok([point.t_s, position])
    };
    asked.setpoints.iter().map(point).collect()
}

/// Refuses a setpoint that a joint cannot be at.
fn check(of: &BodyJoint, t_s: f64, position: f64) -> Result<(), Error> {
    let [lower, upper] = of.limits;
    if (lower..=upper).contains(&position) {
        return Ok(());
    }
    Err(Error::invalid(
        format!(
            "a setpoint of the joint `{}` at {t_s} s is {position}, beyond its limits of {lower} and {upper}",
            of.name
        ),
        "give one between them, or correct the limits in the robot's file",
    ))
}

/// Position and rate at a time.
fn at_time(points: &[[f64; 2]], between: Between, t_s: f64) -> [f64; 2] {
    let next = points.partition_point(|point| point[0] <= t_s);
    if next == 0 || next == points.len() {
        let at = if next == 0 { 0 } else { next - 1 };
        return [points[at][1], 0.0];
    }
    let ([from_s, from], [to_s, to]) = (points[next - 1], points[next]);
    let takes_s = to_s - from_s;
    let share = (t_s - from_s) / takes_s;
    let (way, rate) = match between {
        Between::Smooth => (
            share.powi(3) * (10.0 - share * (15.0 - 6.0 * share)),
            30.0 * (share * (1.0 - share)).powi(2),
        ),
        Between::Linear => (share, 1.0),
    };
    [from + way * (to - from), rate * (to - from) / takes_s]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rate is that of the positions, the target rests at smooth setpoints, and stays before the first and after the last.
    #[test]
    fn a_target_goes_through_its_setpoints() {
        let points = [[1.0, 0.2], [2.0, 0.5], [4.0, -0.5]];
        for between in [Between::Smooth, Between::Linear] {
            let at = |t_s: f64| at_time(&points, between, t_s);
            for [t_s, position] in points {
                assert!((at(t_s)[0] - position).abs() < 1e-12);
            }
            assert_eq!([at(0.0), at(9.0)], [[0.2, 0.0], [-0.5, 0.0]]);
            for t_s in [1.1, 1.5, 1.9, 2.5, 3.7] {
                let by = (at(t_s + 1e-5)[0] - at(t_s - 1e-5)[0]) / 2e-5;
                assert!((by - at(t_s)[1]).abs() < 1e-6, "{by} {:?}", at(t_s));
            }
        }
        assert_eq!(at_time(&points, Between::Smooth, 2.0)[1], 0.0);
    }
}
