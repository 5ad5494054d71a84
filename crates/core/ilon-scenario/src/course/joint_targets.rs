//! Targets of the servos of joints between bodies: positions, rates, or torques and forces, from
//! the scenario's setpoints, a log, or the program that drives the plant.
//!
//! A rate u moves the target on from the joint's position, dq_t/dt = u, so that the servo follows
//! without sagging more and more. If the joint is blocked, by a stop or a load beyond its effort,
//! the target leads by no more than the effort can hold, effort / stiffness.

use std::sync::Arc;

use ilon_robot::{BodyJoint, JointKind, JointRole, JointServo, Robot};
use ilon_world::{World, WorldError};

use crate::Error;
use crate::course::command::JointCommand;
use crate::course::playback::{JointLog, Played};
use crate::scenario::{Between, Joint, JointSetpoint, Quantity, Scenario};

/// The targets of the joints that servos drive.
#[derive(Clone, Debug)]
pub struct JointTargets {
    joints: Vec<Driven>,
}

/// A joint driven by a servo.
#[derive(Clone, Debug)]
struct Driven {
    /// Its index among the robot's joints.
    index: usize,
    aim: Aim,
    /// Its servo, whose target is the start position, and its limits.
    servo: JointServo,
    limits: [f64; 2],
    /// The target under a rate command; `None` before the first one.
    runs_at: Option<f64>,
}

/// The source of its commands.
#[derive(Clone, Debug)]
enum Aim {
    /// Setpoints: times in seconds and numbers, their quantity, and the interpolation. At least
    /// one.
    Setpoints(Arc<[[f64; 2]]>, Quantity, Between),
    /// The rows of a log.
    Logged(Arc<JointLog>),
    /// Commands of the caller.
    Given(JointCommand),
}

impl Aim {
    /// A description for messages.
    fn words(&self) -> &'static str {
        match self {
            Self::Setpoints(..) => "the setpoints",
            Self::Logged(_) => "the log's rows",
            Self::Given(_) => "commands",
        }
    }
}

impl JointTargets {
    /// The targets of a robot's joints by a scenario and its log.
    ///
    /// # Errors
    /// [`Error::Invalid`] for setpoints in the unit of the other kind of joint, or beyond its
    /// limits.
    pub fn new(scenario: &Scenario, played: &Played, robot: &Robot) -> Result<Self, Error> {
        let mut joints = Vec::new();
        for (index, of) in robot.joints.iter().enumerate() {
            let Some(servo) = of.servo() else {
                continue;
            };
            let asked = scenario.robot.joints.get(&of.name);
            let asked = asked.filter(|asked| !asked.setpoints.is_empty());
            let logged = played.joints.iter().find(|(joint, _)| *joint == index);
            let mut servo = *servo;
            let aim = match (asked, logged) {
                (Some(asked), _) => {
                    let (quantity, points) = points(asked, of)?;
                    Aim::Setpoints(points.into(), quantity, asked.between)
                }
                (None, Some((_, log))) => {
                    let begins = log.starts().map(|position| (0.0, position));
                    let mut positions = begins.into_iter().chain(log.positions());
                    positions.try_for_each(|(t_s, position)| check(of, t_s, position))?;
                    servo.target = log.starts().unwrap_or(servo.target);
                    Aim::Logged(Arc::clone(log))
                }
                (None, None) => Aim::Given(JointCommand::Position {
                    position: servo.target,
                    rate: 0.0,
                }),
            };
            joints.push(Driven {
                index,
                aim,
                servo,
                limits: of.limits,
                runs_at: None,
            });
        }
        Ok(Self { joints })
    }

    /// The robot with its joints at the start of their servos, and joint positions counted from
    /// there.
    pub fn standing(&self, robot: &Robot) -> Robot {
        robot.posed(&self.at(0.0, robot))
    }

    /// The robot with its servos at their first targets: a log is read after the robot.
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

    /// The servo targets of a robot's joints at a time, in rad or m; zero for a joint that is
    /// neither driven nor coupled to one. Under a rate, torque or force command, the start position
    /// counts.
    pub fn at(&self, t_s: f64, robot: &Robot) -> Vec<f64> {
        let mut positions = vec![0.0; robot.joints.len()];
        for driven in &self.joints {
            positions[driven.index] = match driven.command_at(t_s) {
                JointCommand::Position { position, .. } => position,
                _ => driven.servo.target,
            };
        }
        robot.couple(&mut positions);
        positions
    }

    /// Remarks joints whose setpoints or log move the target faster than the servo's rate limit.
    pub fn beyond_rate_limits(&self, robot: &Robot) -> Vec<String> {
        let remark = |driven: &Driven| {
            let limit = driven.servo.rate_limit;
            let (fastest, from_s) = driven.fastest();
            // Rows of a log are rounded.
            (fastest > limit * (1.0 + 1e-6)).then(|| {
                let of = &robot.joints[driven.index];
                let (unit, key) = match of.kind {
                    JointKind::Turns => ("rad/s", "rate_limit_rad_s"),
                    JointKind::Slides => ("m/s", "rate_limit_m_s"),
                };
                let (asks, name) = (driven.aim.words(), &of.name);
                format!(
                    "{asks} of the joint `{name}` need {fastest:.3} {unit} from {from_s:.2} s on, but its servo's rate limit is \
                     {limit:.3} {unit}: it will be late; give it more time, or raise `robot.joints.{name}.{key}`"
                )
            })
        };
        self.joints.iter().filter_map(remark).collect()
    }

    /// Commands a joint's servo from now on.
    pub fn give(&mut self, joint: usize, command: JointCommand) {
        let mut joints = self.joints.iter_mut();
        if let Some(driven) = joints.find(|driven| driven.index == joint) {
            driven.aim = Aim::Given(command);
        }
    }

    /// Commands the servos for a step of length `dt_s` with its middle at `middle_s`, in seconds.
    pub fn send(&mut self, middle_s: f64, dt_s: f64, world: &mut World) {
        for driven in &mut self.joints {
            let sent = driven.send(middle_s, dt_s, world);
            debug_assert!(sent.is_ok(), "what no servo can do was refused before");
        }
    }
}

impl Driven {
    /// The command at a time in seconds.
    fn command_at(&self, t_s: f64) -> JointCommand {
        let (points, quantity, between) = match &self.aim {
            Aim::Setpoints(points, quantity, between) => (points, quantity, *between),
            Aim::Logged(log) => return log.command_at(t_s),
            Aim::Given(command) => return *command,
        };
        let [number, rate] = at_time(points, between, t_s);
        match quantity {
            Quantity::Position => JointCommand::Position {
                position: number,
                rate,
            },
            Quantity::Rate => JointCommand::Rate(number),
            Quantity::Effort => JointCommand::Effort(number),
        }
    }

    /// The command for a step of length `dt_s` with its middle at `middle_s`, in seconds, and the
    /// target's acceleration. For setpoints and logs the target has its positions at the beginning,
    /// in the middle and at the end of the step, so that it never jumps.
    fn command_over(&self, middle_s: f64, dt_s: f64) -> (JointCommand, f64) {
        let command = self.command_at(middle_s);
        let is_given = matches!(self.aim, Aim::Given(_));
        let at = |share: f64| match self.command_at(middle_s + share * dt_s) {
            JointCommand::Position { position, .. } if !is_given => Some(position),
            _ => None,
        };
        match (command, at(-0.5), at(0.5)) {
            (JointCommand::Position { position, .. }, Some(from), Some(to)) => {
                let rate = (to - from) / dt_s;
                let bend = 4.0 * (to - 2.0 * position + from) / (dt_s * dt_s);
                (JointCommand::Position { position, rate }, bend)
            }
            _ => (command, 0.0),
        }
    }

    /// The fastest target rate of setpoints or log, in rad/s or m/s, and its start, in seconds.
    fn fastest(&self) -> (f64, f64) {
        let faster = |one: (f64, f64), other: (f64, f64)| if other.0 > one.0 { other } else { one };
        let moves = |from: [f64; 2], to: [f64; 2]| (to[1] - from[1]).abs() / (to[0] - from[0]);
        match &self.aim {
            Aim::Setpoints(points, Quantity::Position, between) => {
                let ways = points.windows(2);
                ways.map(|way| (between.peak() * moves(way[0], way[1]), way[0][0]))
                    .fold((0.0, 0.0), faster)
            }
            Aim::Setpoints(points, Quantity::Rate, _) => {
                let rates = points.iter().map(|[t_s, rate]| (rate.abs(), *t_s));
                rates.fold((0.0, 0.0), faster)
            }
            Aim::Logged(log) => log.fastest(),
            Aim::Setpoints(_, Quantity::Effort, _) | Aim::Given(_) => (0.0, 0.0),
        }
    }

    fn send(&mut self, t_s: f64, dt_s: f64, world: &mut World) -> Result<(), WorldError> {
        let (command, bend) = self.command_over(t_s, dt_s);
        if !matches!(command, JointCommand::Rate(_)) {
            self.runs_at = None;
        }
        match command {
            JointCommand::Position { position, rate } => {
                let aim = [position, rate, bend];
                world.robot_mut().aim_joint_along(self.index, aim)
            }
            JointCommand::Rate(rate) => {
                let limit = self.servo.rate_limit;
                self.run(rate.clamp(-limit, limit), dt_s, world)
            }
            JointCommand::Effort(effort) => world.robot_mut().load_joint(self.index, effort),
        }
    }

    /// Moves the target on at a rate for a step.
    fn run(&mut self, rate: f64, dt_s: f64, world: &mut World) -> Result<(), WorldError> {
        let robot = world.robot();
        let at = robot.joint_positions()[self.index];
        let ahead = self.servo.effort / self.servo.stiffness;
        let [lower, upper] = self.limits;
        // The initial target includes the deflection by the current load.
        let target = || robot.joint_targets().nth(self.index).unwrap_or(at);
        let from = self.runs_at.unwrap_or_else(target);
        // Not `clamp`, which panics on NaN: a diverged simulation reports that itself.
        let held = |place: f64| {
            let near = place.max(at - ahead).min(at + ahead);
            near.max(lower).min(upper)
        };
        let (from, to) = (held(from), held(from + rate * dt_s));
        self.runs_at = Some(to);
        let moves = if to == from { 0.0 } else { rate };
        let middle = 0.5 * (from + to);
        world.robot_mut().aim_joint(self.index, middle, moves)
    }
}

/// The start positions of the joints between a robot's bodies in a scenario without a log, in rad
/// or m: the first targets of driven joints, zero for all others.
///
/// # Errors
/// [`Error::Invalid`] for setpoints in the unit of the other kind of joint, or beyond its limits.
pub fn start_positions(scenario: &Scenario, robot: &Robot) -> Result<Vec<f64>, Error> {
    let targets = JointTargets::new(scenario, &Played::default(), robot)?;
    Ok(targets.at(0.0, robot))
}

/// The setpoints of a joint, in its unit.
fn points(asked: &Joint, of: &BodyJoint) -> Result<(Quantity, Vec<[f64; 2]>), Error> {
    let turns = of.kind == JointKind::Turns;
    let said = asked.setpoints.first().map(JointSetpoint::values);
    let said = said.and_then(|values| values.into_iter().find(|(.., value)| value.is_some()));
    let quantity = said.map_or(Quantity::Position, |(quantity, ..)| quantity);
    let point = |point: &JointSetpoint| {
        let all = point.values();
        let key = all
            .iter()
            .find(|(of, turning, ..)| *of == quantity && *turning == turns);
        let (key, number) = key.map_or(("", None), |(_, _, key, number)| (*key, *number));
        let Some(number) = number else {
            let moves = if turns { "turns" } else { "slides" };
            return Err(Error::invalid(
                format!(
                    "the joint `{}` {moves}, and a setpoint of it has no `{key}`",
                    of.name
                ),
                format!("write `{key}` in its setpoints"),
            ));
        };
        if quantity == Quantity::Position {
            check(of, point.t_s, number)?;
        }
        Ok([point.t_s, number])
    };
    let points: Result<_, _> = asked.setpoints.iter().map(point).collect();
    Ok((quantity, points?))
}

/// Refuses a setpoint outside a joint's range.
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

/// The interpolated value at a time, and its rate.
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

    /// The rate is the derivative of the positions; the target rests at smooth setpoints, and is
    /// constant before the first and after the last.
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

    fn driven(aim: Aim) -> Driven {
        Driven {
            index: 0,
            aim,
            servo: JointServo::for_inertia(1.0),
            limits: [-9.0, 9.0],
            runs_at: None,
        }
    }

    /// A step in which the target's rate changes uses the mean rate over it, wherever the change
    /// is, and begins and ends where the neighbouring steps do: at 0.500 and 0.504, 5 ms from its
    /// middle.
    #[test]
    fn a_step_over_a_setpoint_has_the_mean_rate() {
        let points = [[0.0, 0.0], [0.504, 0.504], [1.0, 0.504]];
        let aim = Aim::Setpoints(points.into(), Quantity::Position, Between::Linear);
        let (command, bend) = driven(aim).command_over(0.505, 0.01);
        let JointCommand::Position { position, rate } = command else {
            panic!("{command:?}");
        };
        assert!(
            (position - 0.504).abs() < 1e-12 && (rate - 0.4).abs() < 1e-9,
            "{rate}"
        );
        for (at_s, there) in [(-0.005, 0.500), (0.005, 0.504)] {
            let moved: f64 = position + (rate + 0.5 * bend * at_s) * at_s;
            assert!((moved - there).abs() < 1e-12, "{moved}");
        }
    }

    /// The least-jerk profile peaks at 15/8 of the mean rate.
    #[test]
    fn the_greatest_rate_of_setpoints_is_found() {
        let points = [[0.5, 0.0], [1.1, 1.5], [3.0, -0.5]];
        for (between, fastest) in [(Between::Smooth, 4.6875), (Between::Linear, 2.5)] {
            let aim = Aim::Setpoints(points.into(), Quantity::Position, between);
            let (found, from_s) = driven(aim).fastest();
            assert!((found - fastest).abs() < 1e-12 && from_s == 0.5, "{found}");
        }
        let rates = Aim::Setpoints(points.into(), Quantity::Rate, Between::Linear);
        assert_eq!(driven(rates).fastest(), (1.5, 1.1));
        // However slow it is: a tenth in two seconds.
        let slow = [[1.0, 0.0], [3.0, 0.1]].into();
        let slow = Aim::Setpoints(slow, Quantity::Position, Between::Linear);
        assert_eq!(driven(slow).fastest(), (0.05, 1.0));
    }
}
