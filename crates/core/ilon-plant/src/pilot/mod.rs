//! What decides the wheel rates: the guidance on a reference, a twist in open loop, or a log.

pub(crate) mod contradiction;
mod foresight;
mod guidance;
mod twist_profile;

pub use foresight::{FeasibilityInTime, RateAsked, motion_of};
pub use guidance::guidance;
pub use twist_profile::TwistProfile;

use std::sync::Arc;

use ilon_control::{
    Command, ContactKinematics, Desired, Guidance, Kinematics, Reference, Task, TaskShare,
};
use ilon_robot::{Pose, Robot, Twist};
use nalgebra::Vector2;

use crate::sensing::hubs::Hubs;
use crate::sensing::sensors::Measurements;
use ilon_scenario::course::command::{Commanded, Decided, WheelCommand};
use ilon_scenario::course::playback::{Asked, Log, Placing};
use ilon_scenario::scenario::{self, ReferencePoint, Scenario};
use ilon_scenario::{Error, Resolved};

/// What decides the wheel rates.
pub struct Pilot {
    motion: Planned,
    guidance: Guidance,
    /// Which part of a twist keeps its wheel rates in saturation; where none is said both give way together.
    priority: Option<ilon_control::Priority>,
    /// Present where the wheel rates are those of the touching rollers.
    contact: Option<ContactKinematics>,
    /// The wheel rates decided on, in rad/s; zero where torques were.
    wheel_rates_rad_s: Vec<f64>,
    /// The torques decided on, in N m, where a controller commands torques.
    torques_n_m: Vec<f64>,
    commanded: Commanded,
    /// As it is believed to be.
    robot: Robot,
    /// About the robot's origin.
    kinematics: Kinematics,
    /// Of a robot whose joints move its wheels.
    hubs: Option<Hubs>,
    /// How long a control period is, in seconds.
    period_s: f64,
    decision: Decision,
    /// The log of the scenario, if it has one.
    log: Option<Arc<Log>>,
    /// Of a log that says only later where the real robot was: where it said so first, and where the simulated robot was then.
    placing: Option<Placing>,
}

enum Planned {
    Reference(Box<Reference>),
    Twist(TwistProfile),
    /// What a log asks of the wheels, or of the body.
    Log(Arc<Log>),
    /// A controller of the caller's, and the reference that the scenario names, if it does.
    Own(Box<dyn Controller>, Option<Box<Reference>>),
}

/// A controller of one's own, in place of the guidance: it sees what the robot's sensors see and commands the wheels.
///
/// It is called once a control period, and may go with its run to another thread.
pub trait Controller: Send {
    /// Decides what the wheels shall do: writes one number a wheel, in the robot's order, into `wheels`, which are zero before,
    /// and says what the numbers are.
    fn command(&mut self, now: &Moment<'_>, wheels: &mut [f64]) -> Commanded;
}

/// What a [`Controller`] knows when it decides.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Moment<'a> {
    /// Time since the start of the run, in seconds.
    pub t_s: f64,
    /// What the robot's sensors say.
    pub seen: &'a Measurements,
    /// The scenario's `[reference]` at the time, if it has one.
    pub desired: Option<&'a Desired>,
    /// The robot, as the controller is to believe it.
    pub robot: &'a Robot,
    /// Its kinematics about its origin: wheel rates for a twist, and back.
    pub kinematics: &'a Kinematics,
}

/// Stands for a controller of which nothing is known yet.
pub struct Idle;

impl Controller for Idle {
    fn command(&mut self, _now: &Moment<'_>, _wheels: &mut [f64]) -> Commanded {
        Commanded::Rates
    }
}

/// The last decision, as it is recorded.
#[derive(Clone, Debug, Default)]
struct Decision {
    pub desired: Option<Desired>,
    pub command_twist_in_body: Twist,
    pub granted_twist_in_body: Twist,
    /// The twists that the tasks asked for, highest priority first; empty in open loop.
    pub tasks: Vec<TaskShare>,
    /// Whether a limit on wheel rates took anything of what was asked.
    pub is_limited: bool,
}

impl Pilot {
    /// What decides the wheel rates of a resolved scenario: a controller of the caller's, or where there is none the scenario's guidance.
    ///
    /// # Errors
    /// Where this robot cannot be guided so.
    pub fn of(
        resolved: &Resolved,
        robot: &Robot,
        controller: Option<Box<dyn Controller>>,
    ) -> Result<Self, Error> {
        let known = resolved.believed(robot);
        let tracked = (
            resolved.reference().cloned(),
            resolved.choices().played.log.clone(),
        );
        let kinematics = resolved.kinematics(known)?;
        Self::new(resolved.scenario(), tracked, kinematics, known, controller)
    }

    /// What a resolved scenario says about how its robot is driven, by what is believed of the robot and its kinematics; `tracked` is its reference, and
    /// `log` its log.
    pub fn new(
        scenario: &Scenario,
        (tracked, log): (Option<Reference>, Option<Arc<Log>>),
        (kinematics, contact_kinematics): (Kinematics, ContactKinematics),
        robot: &Robot,
        controller: Option<Box<dyn Controller>>,
    ) -> Result<Self, Error> {
        let section = &scenario.guidance;
        let wheel_count = kinematics.wheel_count();
        let tracked = tracked.map(Box::new);
        let twist = scenario.twist.clone().unwrap_or_default();
        let motion = match (controller, tracked, &log) {
            (Some(controller), tracked, _) => Planned::Own(controller, tracked),
            (None, Some(reference), _) => Planned::Reference(reference),
            (None, None, Some(log)) => Planned::Log(Arc::clone(log)),
            (None, None, None) => Planned::Twist(TwistProfile::new(&twist)),
        };
        let about_origin = kinematics.clone();
        // A twist in open loop, as any twist of a scenario, is the origin's.
        let kinematics = match (&motion, section.reference_point) {
            (Planned::Twist(_) | Planned::Log(_), _) | (_, ReferencePoint::Origin) => kinematics,
            (_, point) => kinematics.about(point_m(point, &kinematics))?,
        };
        Ok(Self {
            motion,
            guidance: guidance(section, kinematics)?,
            priority: section.priority.map(Into::into),
            contact: match section.kinematics {
                scenario::Kinematics::Ideal => None,
                scenario::Kinematics::Contact => Some(contact_kinematics),
            },
            wheel_rates_rad_s: vec![0.0; wheel_count],
            torques_n_m: vec![0.0; wheel_count],
            commanded: Commanded::Rates,
            robot: robot.clone(),
            kinematics: about_origin,
            hubs: Hubs::that_move(robot),
            period_s: scenario.run.control_dt_s,
            decision: Decision::default(),
            log,
            placing: None,
        })
    }

    /// Decides anew, from the time and what the robot knows.
    pub fn decide(&mut self, t_s: f64, seen: &Measurements) {
        self.stand(&seen.joint_positions);
        if let Some(contact) = &mut self.contact {
            contact.update(&seen.wheel_angles_rad);
        }
        match &mut self.motion {
            Planned::Reference(reference) => {
                let desired = reference.at(t_s);
                let command = match &self.contact {
                    Some(contact) => self
                        .guidance
                        .update_on_contact(&seen.pose, &desired, contact),
                    None => self.guidance.update(&seen.pose, &desired),
                };
                self.wheel_rates_rad_s
                    .copy_from_slice(&command.wheel_rates_rad_s);
                self.decision.take(command, Some(desired));
                self.roll_along();
                let point_m = self.guidance.kinematics().reference_point_m();
                self.decision.move_to_origin(point_m);
            }
            Planned::Twist(profile) => {
                let twist = profile.at(t_s);
                self.command_twist(twist);
            }
            Planned::Log(log) => {
                let asked = log.ask(t_s, &seen.wheel_angles_rad, &mut self.torques_n_m);
                match asked {
                    Asked::Twist(twist) => self.command_twist(twist),
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

    /// Ends the run at a time in seconds: the last decision stands, and what is desired is that of the end.
    pub fn end(&mut self, t_s: f64) {
        if let Planned::Reference(reference) | Planned::Own(_, Some(reference)) = &self.motion {
            self.decision.desired = Some(reference.at(t_s));
        }
    }

    /// Asks for a twist of the body's origin, in the body frame, from the next decision on, in place of the scenario's twist.
    pub fn steer(&mut self, twist_in_body: Twist) {
        self.motion = Planned::Twist(TwistProfile::of(twist_in_body));
    }

    /// Commands the rates of a twist of the body's origin.
    fn command_twist(&mut self, twist_in_body: Twist) {
        let tasks = Task::of_twist(twist_in_body, self.priority);
        let command = match &self.contact {
            Some(contact) => self.guidance.command_on_contact(&tasks, contact),
            None => self.guidance.command(&tasks),
        };
        self.wheel_rates_rad_s
            .copy_from_slice(&command.wheel_rates_rad_s);
        self.decision.take(command, None);
        self.roll_along();
    }

    /// Takes up where the joints between bodies have the wheels, in rad or m. Where no twist follows from the rates of wheels that stand so, they count as
    /// they stood before.
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
        if let Some(contact) = &mut self.contact
            && let Ok(posed) = ContactKinematics::new(&hubs.posed())
        {
            *contact = posed;
        }
    }

    /// Lets the wheels roll along where joints carry them, at the speed of the last control period.
    fn roll_along(&mut self) {
        if let Some(hubs) = &self.hubs {
            let rates = self.wheel_rates_rad_s.iter_mut().zip(hubs.carried_rad());
            rates.for_each(|(rate_rad_s, carried)| *rate_rad_s -= carried / self.period_s);
        }
    }

    /// Commands the wheels by the numbers that stand in `torques_n_m`, whatever they are.
    fn command_wheels(&mut self, commanded: Commanded) {
        self.commanded = commanded;
        match commanded {
            Commanded::Rates => self.wheel_rates_rad_s.copy_from_slice(&self.torques_n_m),
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

    /// What the wheels shall do.
    pub fn command(&self) -> WheelCommand<'_> {
        match self.commanded {
            Commanded::Torques => WheelCommand::Torques(&self.torques_n_m),
            Commanded::Rates => WheelCommand::Rates(&self.wheel_rates_rad_s),
        }
    }

    /// Where a log says that the real robot was at a time in seconds, while the simulated robot is at a pose.
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

    /// Whether a log says anything of where the real robot was.
    pub fn is_measured(&self) -> bool {
        self.log.as_ref().is_some_and(|log| log.has_measured())
    }

    /// What was decided last, for a recorder at a time in seconds, while the simulated robot is at a pose.
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

    /// Names of the guidance's tasks, highest priority first; none in open loop.
    pub fn task_names(&self) -> Vec<&'static str> {
        match &self.motion {
            Planned::Reference(_) => self.guidance.task_names().collect(),
            Planned::Twist(_) | Planned::Log(_) | Planned::Own(..) => Vec::new(),
        }
    }

    /// From when on means are taken, in seconds.
    pub fn measure_from_s(&self) -> f64 {
        match &self.motion {
            Planned::Reference(_) | Planned::Log(_) | Planned::Own(..) => 0.0,
            Planned::Twist(profile) => profile.settled_s(),
        }
    }
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
}

impl Decision {
    /// Turns twists of a point of the body frame into those of its origin, eq. (2): all that is recorded is the origin's.
    fn move_to_origin(&mut self, point_m: Vector2<f64>) {
        let moved = |twist: &mut Twist| {
            twist.vx_m_s += twist.omega_rad_s * point_m.y;
            twist.vy_m_s -= twist.omega_rad_s * point_m.x;
        };
        moved(&mut self.command_twist_in_body);
        moved(&mut self.granted_twist_in_body);
        for task in &mut self.tasks {
            moved(&mut task.twist_in_body);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../assets/robots");
    /// Of the body, in metres.
    const POINT_M: [f64; 2] = [0.2, -0.1];

    /// The pilot of a reference that a point beside the body's origin follows.
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
            (resolved.reference().cloned(), None),
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

    /// A point at c that goes round a circle at v and looks along it turns at omega = v / r, and so does the origin, at
    /// (v + omega c_y, -omega c_x) in the body's own axes: all the time the same, so that nothing changes there. A reference's acceleration is a quotient
    /// over 10 us, half of which times the jerk, v omega^2, is 5e-7 m/s^2.
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

    /// Where the heading turns by itself the rate is the derivative of the twist in the body's axes, to half of the 10 us over which an acceleration is
    /// taken times a jerk of at most 1 m/s^3: the speed's share of it, 0.6 m/s, times the square of (2 pi / 8 s + 40 deg/s).
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
