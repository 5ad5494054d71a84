//! Decides the wheel rates: by guidance on a reference, an open-loop twist, or a log.

pub(crate) mod contradiction;
mod foresight;
mod guidance;
mod modules;
mod twist_profile;

pub use foresight::{FeasibilityInTime, RateAsked, motion_of};
pub use guidance::guidance;
pub use twist_profile::TwistProfile;

use std::sync::Arc;

use ilon_control::{
    Command, ContactKinematics, Desired, Guidance, Kinematics, PathTracking, Reference, Task,
    TaskShare,
};
use ilon_robot::{Pose, Robot, Twist, wrap_angle};
use nalgebra::Vector2;

use crate::pilot::modules::Modules;
use crate::sensing::hubs::Hubs;
use crate::sensing::sensors::Measurements;
use ilon_scenario::course::command::{Commanded, Decided, JointCommand, WheelCommand};
use ilon_scenario::course::playback::{Asked, Log, Placing, Played};
use ilon_scenario::scenario::{self, ReferencePoint, Scenario};
use ilon_scenario::{Error, Resolved};

/// Decides the wheel rates.
pub struct Pilot {
    motion: Planned,
    guidance: Guidance,
    /// The part of a twist that keeps its wheel rates in saturation; `None` scales both together.
    priority: Option<ilon_control::Priority>,
    /// Present if the wheel rates are computed by contact kinematics.
    contact: Option<ContactKinematics>,
    /// The decided wheel rates, in rad/s; zero if torques were decided.
    wheel_rates_rad_s: Vec<f64>,
    /// The decided torques, in N m, if a controller commands torques.
    torques_n_m: Vec<f64>,
    commanded: Commanded,
    /// The robot that the controller believes in.
    robot: Robot,
    /// About the robot's origin.
    kinematics: Kinematics,
    /// For a robot whose joints move its wheels.
    hubs: Option<Hubs>,
    /// Of a robot with steered wheels.
    modules: Option<Modules>,
    /// Whether the last decision sent them anywhere.
    aims: bool,
    /// Of a robot that follows a reference and cannot move sideways.
    tracking: Option<PathTracking>,
    /// Gains, limits and tasks of the guidance.
    section: scenario::Guidance,
    /// Control period, in seconds.
    period_s: f64,
    decision: Decision,
    /// The scenario's log, if it has one.
    log: Option<Arc<Log>>,
    /// For a log whose poses of the real robot begin late: the first of these, and the simulated
    /// robot's pose at that time.
    placing: Option<Placing>,
}

enum Planned {
    Reference(Box<Reference>),
    Twist(TwistProfile),
    /// Constant wheel rates, in rad/s.
    Rates(Vec<f64>),
    /// The commands of a log to the wheels or the body.
    Log(Arc<Log>),
    /// A caller's controller, and the scenario's reference, if it has one.
    Own(Box<dyn Controller>, Option<Box<Reference>>),
}

/// What a person has the robot follow, in place of what the scenario asks.
#[derive(Clone, Copy, Debug)]
pub enum Followed<'a> {
    /// A reference, under the guidance.
    Reference(&'a Reference),
    /// A twist of the body's origin, in the body frame.
    Twist(Twist),
    /// Wheel rates, in rad/s; steered wheels stay where they are sent.
    Rates(&'a [f64]),
}

/// A controller written by the caller, in place of the guidance. It receives the measurements of
/// the robot's sensors and commands the wheels.
///
/// It is called once a control period, and may move with its run to another thread.
pub trait Controller: Send {
    /// Decides the commands: writes one number per wheel, in the robot's order, into `wheels`,
    /// which are zero before, and returns their kind.
    fn command(&mut self, now: &Moment<'_>, wheels: &mut [f64]) -> Commanded;
}

/// The input of a [`Controller`].
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Moment<'a> {
    /// Time since the start of the run, in seconds.
    pub t_s: f64,
    /// The measurements of the robot's sensors.
    pub seen: &'a Measurements,
    /// The scenario's `[reference]` at this time, if it has one.
    pub desired: Option<&'a Desired>,
    /// The robot that the controller believes in.
    pub robot: &'a Robot,
    /// Its kinematics about its origin: wheel rates for a twist, and back.
    pub kinematics: &'a Kinematics,
}

/// A placeholder for a controller that is not known yet.
pub struct Idle;

impl Controller for Idle {
    fn command(&mut self, _now: &Moment<'_>, _wheels: &mut [f64]) -> Commanded {
        Commanded::Rates
    }
}

/// The recorded part of the last decision.
#[derive(Clone, Debug, Default)]
struct Decision {
    pub desired: Option<Desired>,
    pub command_twist_in_body: Twist,
    pub granted_twist_in_body: Twist,
    /// The twists that the tasks commanded, highest priority first; empty in open loop.
    pub tasks: Vec<TaskShare>,
    /// Whether a limit on wheel rates took anything of what was asked.
    pub is_limited: bool,
}

impl Pilot {
    /// The pilot of a resolved scenario: a caller's controller, or by default the scenario's
    /// guidance.
    ///
    /// # Errors
    /// If this robot cannot be guided like this.
    pub fn of(
        resolved: &Resolved,
        robot: &Robot,
        controller: Option<Box<dyn Controller>>,
    ) -> Result<Self, Error> {
        let known = resolved.believed(robot);
        let tracked = (resolved.reference().cloned(), &resolved.choices().played);
        let kinematics = resolved.kinematics(known)?;
        Self::new(resolved.scenario(), tracked, kinematics, known, controller)
    }

    /// The pilot of a resolved scenario, for the believed robot and its kinematics; `tracked` is
    /// the reference, and `played` the log.
    pub fn new(
        scenario: &Scenario,
        (tracked, played): (Option<Reference>, &Played),
        (kinematics, contact_kinematics): (Kinematics, ContactKinematics),
        robot: &Robot,
        controller: Option<Box<dyn Controller>>,
    ) -> Result<Self, Error> {
        let wheel_count = kinematics.wheel_count();
        let tracked = tracked.map(Box::new);
        let twist = scenario.twist.clone().unwrap_or_default();
        let motion = match (controller, tracked, &played.log) {
            (Some(controller), tracked, _) => Planned::Own(controller, tracked),
            (None, Some(reference), _) => Planned::Reference(reference),
            (None, None, Some(log)) => Planned::Log(Arc::clone(log)),
            (None, None, None) => Planned::Twist(TwistProfile::new(&twist)),
        };
        let section = &scenario.guidance;
        let (guidance, tracking) = law(&motion, section, &kinematics)?;
        Ok(Self {
            motion,
            guidance,
            priority: section.priority,
            contact: match section.kinematics {
                scenario::Kinematics::Ideal => None,
                scenario::Kinematics::Contact => Some(contact_kinematics),
            },
            wheel_rates_rad_s: vec![0.0; wheel_count],
            torques_n_m: vec![0.0; wheel_count],
            commanded: Commanded::Rates,
            robot: robot.clone(),
            kinematics,
            hubs: Hubs::that_move(robot),
            modules: Modules::of(robot, scenario, played),
            aims: false,
            tracking,
            section: section.clone(),
            period_s: scenario.run.control_dt_s,
            decision: Decision::default(),
            log: played.log.clone(),
            placing: None,
        })
    }

    /// Makes a new decision from the time and the measurements.
    pub fn decide(&mut self, t_s: f64, seen: &Measurements) {
        self.stand(&seen.joint_positions);
        self.aims = false;
        if let Some(contact) = &mut self.contact {
            contact.update(&seen.wheel_angles_rad);
        }
        match &mut self.motion {
            Planned::Reference(reference) => {
                let desired = reference.at(t_s);
                let command = match (&self.tracking, &self.contact) {
                    (Some(tracking), _) => {
                        let twist = tracking.twist(&seen.pose, &reference.path_at(t_s));
                        self.guidance.command(&Task::of_twist(twist, self.priority))
                    }
                    (None, Some(contact)) => self
                        .guidance
                        .update_on_contact(&seen.pose, &desired, contact),
                    (None, None) => self.guidance.update(&seen.pose, &desired),
                };
                self.wheel_rates_rad_s
                    .copy_from_slice(&command.wheel_rates_rad_s);
                self.decision.take(command, Some(desired));
                self.roll_along();
                let point_m = self.guidance.kinematics().reference_point_m();
                self.decision.move_to_origin(point_m);
                self.aim_modules(&seen.joint_positions);
            }
            Planned::Twist(profile) => {
                let twist = profile.at(t_s);
                self.command_twist(twist, &seen.joint_positions);
            }
            Planned::Rates(rates) => {
                self.torques_n_m.copy_from_slice(rates);
                self.command_wheels(Commanded::Rates);
            }
            Planned::Log(log) => {
                let asked = log.ask(t_s, &seen.wheel_angles_rad, &mut self.torques_n_m);
                match asked {
                    Asked::Twist(twist) => self.command_twist(twist, &seen.joint_positions),
                    Asked::Rates => self.command_wheels(Commanded::Rates),
                    Asked::Torques => self.command_wheels(Commanded::Torques),
                }
            }
            Planned::Own(controller, reference) => {
                let desired = reference.as_ref().map(|reference| reference.at(t_s));
                let now = Moment {
                    t_s,
                    seen,
                    desired: desired.as_ref(),
                    robot: &self.robot,
                    kinematics: &self.kinematics,
                };
                let numbers = &mut self.torques_n_m;
                numbers.fill(0.0);
                let commanded = controller.command(&now, numbers);
                self.command_wheels(commanded);
                self.decision.desired = desired;
            }
        }
    }

    /// Ends the run at a time in seconds: the last decision is kept, and the reference is evaluated
    /// at the end.
    pub fn end(&mut self, t_s: f64) {
        if let Planned::Reference(reference) | Planned::Own(_, Some(reference)) = &self.motion {
            self.decision.desired = Some(reference.at(t_s));
        }
    }

    /// Commands a twist of the body's origin, in the body frame, from the next decision on, instead
    /// of the scenario's twist.
    pub fn steer(&mut self, twist_in_body: Twist) {
        self.motion = Planned::Twist(TwistProfile::of(twist_in_body));
    }

    /// Follows something else from the next decision on.
    ///
    /// # Errors
    /// If the robot cannot be guided like this.
    pub fn follow(&mut self, followed: Followed<'_>) -> Result<(), Error> {
        match (&mut self.motion, followed) {
            (Planned::Reference(_), Followed::Reference(_)) => return Ok(()),
            (Planned::Twist(_), Followed::Twist(twist)) => {
                self.steer(twist);
                return Ok(());
            }
            (Planned::Rates(held), Followed::Rates(rates)) if held.len() == rates.len() => {
                held.copy_from_slice(rates);
                return Ok(());
            }
            (_, Followed::Reference(reference)) => {
                self.motion = Planned::Reference(Box::new(reference.clone()));
            }
            (_, Followed::Twist(twist)) => self.steer(twist),
            (_, Followed::Rates(rates)) => self.motion = Planned::Rates(rates.to_vec()),
        }
        (self.log, self.decision) = (None, Decision::default());
        self.commanded = Commanded::Rates;
        self.tune(&self.section.clone())
    }

    /// Guides by other gains, limits and tasks from the next decision on.
    ///
    /// # Errors
    /// If the robot cannot be guided like this.
    pub fn tune(&mut self, section: &scenario::Guidance) -> Result<(), Error> {
        (self.guidance, self.tracking) = law(&self.motion, section, &self.kinematics)?;
        self.priority = section.priority;
        self.section = section.clone();
        Ok(())
    }

    /// Commands the rates of a twist of the body's origin, and the angles of steered wheels.
    fn command_twist(&mut self, twist_in_body: Twist, joint_positions: &[f64]) {
        let twist_in_body = self.kinematics.reachable(twist_in_body);
        let tasks = Task::of_twist(twist_in_body, self.priority);
        let command = match &self.contact {
            Some(contact) => self.guidance.command_on_contact(&tasks, contact),
            None => self.guidance.command(&tasks),
        };
        self.wheel_rates_rad_s
            .copy_from_slice(&command.wheel_rates_rad_s);
        self.decision.take(command, None);
        self.roll_along();
        self.aim_modules(joint_positions);
    }

    /// Updates the wheels' places from the positions of joints between bodies, in rad or m. If no
    /// twist follows from the rates of the wheels there, their previous places are kept.
    fn stand(&mut self, joint_positions: &[f64]) {
        let Some(hubs) = &mut self.hubs else {
            return;
        };
        if !hubs.see(joint_positions) {
            return;
        }
        let Some(kinematics) = hubs.kinematics() else {
            return;
        };
        if self.guidance.stand(kinematics).is_ok() {
            self.kinematics = kinematics.clone();
        }
        if let Some(contact) = &mut self.contact {
            contact.stand(kinematics);
        }
    }

    /// Adds the rates at which the wheels roll while joints carry them, at the speed of the last
    /// control period.
    fn roll_along(&mut self) {
        if let Some(hubs) = &self.hubs {
            let rates = self.wheel_rates_rad_s.iter_mut().zip(hubs.carried_rad());
            rates.for_each(|(rate_rad_s, carried)| *rate_rad_s -= carried / self.period_s);
        }
    }

    /// Sends steered wheels where the granted twist wants them.
    fn aim_modules(&mut self, joint_positions: &[f64]) {
        if let (Some(modules), Some(hubs)) = (&mut self.modules, &self.hubs) {
            let twist = self.decision.granted_twist_in_body;
            let known = (&self.kinematics, hubs.body_from_hubs());
            modules.aim(twist, known, (joint_positions, self.period_s));
            self.aims = true;
            for (wheel, rate_rad_s) in modules.turning_along(&self.kinematics) {
                // In place of what was measured of it, which is late.
                let measured_rad_s = -hubs.carried_rad()[wheel] / self.period_s;
                self.wheel_rates_rad_s[wheel] += rate_rad_s - measured_rad_s;
            }
        }
    }

    /// Whether it steers wheels at all.
    pub fn steers(&self) -> bool {
        self.modules.is_some()
    }

    /// Where the pilot sends the joints that steer wheels, by their indices among the robot's
    /// joints; nowhere if wheel rates, a log of wheels or a user's controller drives.
    pub fn steering(&self) -> impl Iterator<Item = (usize, JointCommand)> {
        let modules = self.modules.iter().filter(|_| self.aims);
        modules.flat_map(Modules::commands)
    }

    /// A remark if a robot that cannot move sideways follows a reference whose heading is not that
    /// of its path; `duration_s` is that of the run.
    pub fn heading_beside_path(&self, duration_s: f64) -> Option<String> {
        /// Places along the way that are compared (chosen).
        const PLACES: usize = 200;
        /// A smaller angle is not remarked, in radians (chosen).
        const REMARKED_RAD: f64 = 0.05;
        let (Some(_), Planned::Reference(reference)) = (&self.tracking, &self.motion) else {
            return None;
        };
        let beside_rad = |place: usize| {
            let t_s = duration_s * place as f64 / PLACES as f64;
            let (path, desired) = (reference.path_at(t_s), reference.at(t_s));
            wrap_angle(path.direction_rad - desired.pose.heading_rad).abs()
        };
        let most_rad = (0..=PLACES).map(beside_rad).fold(0.0, f64::max);
        (most_rad > REMARKED_RAD).then(|| {
            format!(
                "the reference's heading is up to {:.1} deg beside the direction of its path, which tyres do not let the robot hold: its heading follows the path; \
                 write `reference.heading = \"along_path\"`",
                most_rad.to_degrees()
            )
        })
    }

    /// A remark on the first twist of a schedule to which a module cannot turn from where it
    /// starts; `None` if all can, and without a schedule.
    pub fn beyond_steering(&self) -> Option<String> {
        let Planned::Twist(profile) = &self.motion else {
            return None;
        };
        let positions = self.robot.start_positions();
        let hubs = self.robot.body_from_hubs(&positions);
        let beyond = |twist: Twist| {
            let twist = self.kinematics.reachable(twist);
            let known = (&self.kinematics, &hubs[..]);
            let joint = self.modules.clone()?.aim(twist, known, (&positions, 0.0))?;
            Some((twist, joint))
        };
        let (twist, joint) = profile.held().find_map(beyond)?;
        let joint = &self.robot.joints[joint];
        let [lower_deg, upper_deg] = joint.limits.map(f64::to_degrees);
        Some(format!(
            "`{}` cannot turn to where its wheel would roll along [twist] (vx_m_s = {}, vy_m_s = {}, omega_rad_s = {}): its limits are {lower_deg:.1} and \
             {upper_deg:.1} deg; it stays there, and the robot goes another way",
            joint.name, twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s
        ))
    }

    /// A remark if the planned motion turns modules faster than they can for more than a moment of a
    /// run, in seconds: on the one that is asked for the most.
    pub fn beyond_steering_rates(&self, duration_s: f64) -> Option<String> {
        /// Times that are looked at, and the share of them that is more than a moment (chosen).
        const TIMES: usize = 1000;
        const MOMENT: f64 = 0.01;
        // Such a robot does not hold the reference's heading.
        if self.heading_beside_path(duration_s).is_some() {
            return None;
        }
        let modules = self.modules.as_ref()?;
        let limit_rad_s = |joint: usize| {
            let servo = self.robot.joints[joint].servo();
            servo.map_or(f64::INFINITY, |servo| servo.rate_limit)
        };
        let mut beyond = vec![(0, 0.0_f64); self.robot.joints.len()];
        for time in 0..TIMES {
            let (twist, rate) = self.planned(duration_s * time as f64 / TIMES as f64)?;
            for (joint, rate_rad_s) in modules.turning_rad_s(&self.robot, [twist, rate]) {
                if rate_rad_s.abs() > limit_rad_s(joint) * (1.0 + 1e-6) {
                    let (times, most_rad_s) = &mut beyond[joint];
                    *times += 1;
                    *most_rad_s = most_rad_s.max(rate_rad_s.abs());
                }
            }
        }
        let share = |times: usize| times as f64 / TIMES as f64;
        let lasting = beyond.into_iter().enumerate();
        let lasting = lasting.filter(|(_, (times, _))| share(*times) > MOMENT);
        let (joint, (times, most_rad_s)) =
            lasting.reduce(|a, b| if b.1.1 > a.1.1 { b } else { a })?;
        let name = &self.robot.joints[joint].name;
        Some(format!(
            "the motion takes up to {most_rad_s:.3} rad/s of the module `{name}`, whose limit is {:.3} rad/s, and more than that for {:.0} % of the run: its wheel \
             stands beside its way, and no limit of wheel rates slows the motion down for it; slow it down, or raise `robot.joints.{name}.rate_limit_rad_s`",
            limit_rad_s(joint),
            100.0 * share(times)
        ))
    }

    /// Commands the wheels by the numbers in `torques_n_m`, of either kind.
    fn command_wheels(&mut self, commanded: Commanded) {
        self.commanded = commanded;
        match commanded {
            Commanded::Rates => {
                self.wheel_rates_rad_s.copy_from_slice(&self.torques_n_m);
                let kinematics = self.guidance.kinematics();
                kinematics.roll_idle(&mut self.wheel_rates_rad_s);
            }
            Commanded::Torques => self.wheel_rates_rad_s.fill(0.0),
        }
        let kinematics = self.guidance.kinematics();
        let twist_in_body = kinematics.twist(&self.wheel_rates_rad_s);
        let point_m = kinematics.reference_point_m();
        self.decision.desired = None;
        self.decision.command_twist_in_body = twist_in_body;
        self.decision.granted_twist_in_body = twist_in_body;
        self.decision.is_limited = false;
        self.decision.tasks.clear();
        self.decision.move_to_origin(point_m);
    }

    /// The kinematics about the robot's origin.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// The point of the body that follows the reference, in the body frame, in metres.
    pub fn reference_point_m(&self) -> Vector2<f64> {
        self.guidance.kinematics().reference_point_m()
    }

    /// The current command to the wheels.
    pub fn command(&self) -> WheelCommand<'_> {
        match self.commanded {
            Commanded::Torques => WheelCommand::Torques(&self.torques_n_m),
            Commanded::Rates => WheelCommand::Rates(&self.wheel_rates_rad_s),
        }
    }

    /// The real robot's pose in a log at a time in seconds, while the simulated robot is at
    /// `truth`.
    fn measured_at(&mut self, t_s: f64, truth: Pose) -> Option<Pose> {
        let log = self.log.as_ref()?;
        let measured = log.measured_at(t_s)?;
        if log.measured_is_placed() {
            return Some(measured);
        }
        let placing = self.placing.get_or_insert(Placing {
            from: measured,
            to: truth,
        });
        Some(placing.of(measured))
    }

    /// Whether a log has poses of the real robot.
    pub fn is_measured(&self) -> bool {
        self.log.as_ref().is_some_and(|log| log.has_measured())
    }

    /// The last decision, for a recorder at a time in seconds, while the simulated robot is at
    /// `truth`.
    pub fn decided(&mut self, t_s: f64, truth: Pose) -> Decided<'_> {
        Decided {
            measured: self.measured_at(t_s, truth),
            desired: self.decision.desired,
            command_twist_in_body: self.decision.command_twist_in_body,
            granted_twist_in_body: self.decision.granted_twist_in_body,
            tasks: &self.decision.tasks,
            is_limited: self.decision.is_limited,
            wheel_rates_rad_s: &self.wheel_rates_rad_s,
            commanded: self.commanded,
        }
    }

    /// Names of the guidance's tasks, highest priority first; empty in open loop.
    pub fn task_names(&self) -> Vec<&'static str> {
        match &self.motion {
            Planned::Reference(_) => self.guidance.task_names().collect(),
            _ => Vec::new(),
        }
    }

    /// Start of the window of the means, in seconds.
    pub fn measure_from_s(&self) -> f64 {
        match &self.motion {
            Planned::Twist(profile) => profile.settled_s(),
            _ => 0.0,
        }
    }
}

/// The guidance of a motion, about the point that it moves, for kinematics about the origin.
fn law(
    motion: &Planned,
    section: &scenario::Guidance,
    kinematics: &Kinematics,
) -> Result<(Guidance, Option<PathTracking>), Error> {
    let tracking = match motion {
        Planned::Reference(_) => PathTracking::new(kinematics, section.position_gain_per_s)?,
        _ => None,
    };
    // Any other motion than a reference is that of the origin.
    let point_m = match (motion, &tracking) {
        (Planned::Reference(_), Some(tracking)) => tracking.point_m(),
        (Planned::Reference(_) | Planned::Own(..), None) => {
            point_m(section.reference_point, kinematics)
        }
        _ => Vector2::zeros(),
    };
    let guidance = guidance(section, kinematics.about(point_m)?)?;
    Ok((guidance, tracking))
}

/// A point of the body frame, in metres.
pub fn point_m(point: ReferencePoint, kinematics: &Kinematics) -> Vector2<f64> {
    match point {
        ReferencePoint::Origin => Vector2::zeros(),
        ReferencePoint::Decoupling => kinematics.decoupling_point_m(),
        ReferencePoint::At { x_m, y_m } => Vector2::new(x_m, y_m),
    }
}

impl Decision {
    fn take(&mut self, command: &Command, desired: Option<Desired>) {
        self.desired = desired;
        self.command_twist_in_body = command.twist_in_body;
        self.granted_twist_in_body = command.saturated_twist_in_body;
        self.is_limited = command.is_limited;
        self.tasks.clear();
        if desired.is_some() {
            self.tasks.extend_from_slice(&command.tasks);
        }
    }

    /// Converts twists of a point of the body frame to those of its origin: all recorded twists are
    /// those of the origin.
    fn move_to_origin(&mut self, point_m: Vector2<f64>) {
        let tasks = self.tasks.iter_mut().map(|task| &mut task.twist_in_body);
        let twists = [
            &mut self.command_twist_in_body,
            &mut self.granted_twist_in_body,
        ];
        for twist in tasks.chain(twists) {
            *twist = twist.at(-point_m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
    /// Of the body, in metres.
    const POINT_M: [f64; 2] = [0.2, -0.1];

    /// The pilot of a reference that is followed by a point beside the body's origin.
    fn pilot(reference: &str) -> Pilot {
        let [x_m, y_m] = POINT_M;
        let text = format!(
            "robot.file = \"mecanum4.urdf\"\nreference.{reference}\n\
             guidance.reference_point.at = {{ x_m = {x_m}, y_m = {y_m} }}\nrun.duration_s = 4\n"
        );
        let scenario = Scenario::from_toml(&text, "planned", ROBOTS).expect("a scenario");
        let robot = ilon_scenario::robot::load_robot(&scenario).expect("a shipped robot");
        let resolved = crate::resolve(&scenario, &robot).expect("it can be run");
        let kinematics = Kinematics::new(&robot).expect("it drives");
        let contact = ContactKinematics::new(&robot).expect("it drives");
        Pilot::new(
            resolved.scenario(),
            (resolved.reference().cloned(), &Played::default()),
            (kinematics, contact),
            &robot,
            None,
        )
        .expect("a pilot")
    }

    fn off(one: Twist, other: Twist) -> f64 {
        let off = one + other.scaled(-1.0);
        off.linear_m_s().norm() + off.omega_rad_s.abs()
    }

    /// A point at c that goes round a circle at v and looks along it turns at omega = v / r, and so
    /// does the origin, at (v + omega c_y, -omega c_x) in the body frame: constant, so its rate is
    /// zero. A reference's acceleration is a quotient over 10 us, half of which times the jerk, v
    /// omega^2, is 5e-7 m/s^2.
    #[test]
    fn round_a_circle_along_it_the_origins_twist_stays_as_it_is() {
        let (radius_m, speed_m_s) = (0.8, 0.4);
        let pilot = pilot(&format!(
            "circle = {{ radius_m = {radius_m}, speed_m_s = {speed_m_s}, heading = \"along_path\" }}"
        ));
        let (omega, [x_m, y_m]) = (speed_m_s / radius_m, POINT_M);
        let expected = Twist::new(speed_m_s + omega * y_m, -omega * x_m, omega);
        for t_s in [0.0, 0.9, 2.3, 3.7] {
            let (twist, rate) = pilot.planned(t_s).expect("a reference is planned");
            // Sines and cosines of numbers of about one.
            assert!(off(twist, expected) < 1e-12, "{twist:?} at {t_s} s");
            assert!(off(rate, Twist::default()) < 2e-6, "{rate:?} at {t_s} s");
        }
    }

    /// If the heading turns independently, the rate is the derivative of the twist in the body
    /// frame, to half of the 10 us over which an acceleration is taken times a jerk of at most 1
    /// m/s^3: the speed's part of it, 0.6 m/s, times the square of (2 pi / 8 s + 40 deg/s).
    #[test]
    fn how_a_planned_twist_changes_is_its_derivative() {
        const H_S: f64 = 1e-4;
        let pilot = pilot(
            "figure_eight = { half_width_m = 0.8, period_s = 8, heading = { turning = { rate_deg_s = 40 } } }",
        );
        for t_s in [0.3, 1.1, 2.9] {
            let twist = |t_s: f64| pilot.planned(t_s).expect("a reference is planned").0;
            let (_, rate) = pilot.planned(t_s).expect("a reference is planned");
            let expected = (twist(t_s + H_S) + twist(t_s - H_S).scaled(-1.0)).scaled(0.5 / H_S);
            assert!(expected.linear_m_s().norm() > 0.1);
            assert!(off(rate, expected) < 1e-5, "{rate:?} {expected:?}");
        }
    }
}
