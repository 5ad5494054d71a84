//! The plant: a robot in its world with motors, wheel loops, sensors and faults.

mod interventions;

use std::sync::Arc;

use ilon_control::{BodySense, Desired, Kinematics, TorqueShares};
use ilon_robot::{Pose, Robot};
use ilon_trace::{Storage, Truth};
use ilon_world::rapier3d::prelude::PhysicsWorld;
use ilon_world::{Floor, MotorTorque, Settings, SharedRobot, WheelTally, World};
use nalgebra::Vector3;

use crate::bodies;
use crate::clock::Clock;
use crate::faults::disturbances::Disturbances;
use crate::faults::{Faults, LostMotor};
use crate::ground::floor;
use crate::sensing::sensors::{Measurements, Sensors};
use crate::storage::StorageAccount;
use crate::wheels::drive::{Drive, WheelRates};
use ilon_scenario::course::command::WheelCommand;
use ilon_scenario::course::joint_targets::JointTargets;
use ilon_scenario::scenario;
use ilon_scenario::{Error, Resolved};

/// The most physics steps per call: days of simulated time. More are a mistake. Chosen.
const MOST_STEPS: f64 = 1e9;

/// The shortest time by which a plant is advanced, as a share of its step. Chosen.
const SHORTEST_PART: f64 = 1e-3;

/// A shorter part of a step counts as zero: far above the rounding of a sum of steps, and far below
/// any intended time. Chosen.
const NO_TIME: f64 = 1e-6;

/// The outcome of an advance.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Outcome {
    /// Torques of the motors on the wheels, in N m: the mean over the time.
    pub torques_n_m: Vec<f64>,
    /// Means and extremes of each wheel, its motor and its contact over the time.
    pub wheels: Vec<WheelTally>,
    /// Largest residual of the laws of contact, in m/s: the speed of a motion that the laws forbid.
    pub contact_residual_m_s: f64,
    /// Acceleration of the body frame's origin in the world frame, in m/s^2: the mean over the
    /// time.
    pub acceleration_in_world_m_s2: [f64; 3],
    /// The share of each task that the torque law could give in the last step; `None` for a law
    /// that weighs no tasks.
    pub torque_shares: Option<TorqueShares>,
}

/// A robot that can be driven step by step from outside: robot, world, motors and wheel loops,
/// sensors and faults.
///
/// ```no_run
/// use ilon_plant::{Plant, Scenario, WheelCommand};
///
/// let scenario = Scenario::load("assets/scenarios/mecanum4_lateral.toml")?;
/// let mut plant = Plant::of_scenario(&scenario)?;
/// for _ in 0..100 {
///     let seen = plant.observe();
///     let rates_rad_s = if seen.pose.x_m < 0.5 { [5.0; 4] } else { [0.0; 4] };
///     plant.advance(WheelCommand::Rates(&rates_rad_s), 0.01)?;
/// }
/// println!("{:?}", plant.truth());
/// # Ok::<(), ilon_plant::Error>(())
/// ```
///
/// It keeps no record and decides nothing. It may move to another thread, and its copies continue
/// identically to the bit.
///
/// A fleet is a list of copies: they share scenario, robot and rollers' shapes, and
/// [`Plant::reset`] places each at its start. A thread advances many plants fastest by a whole
/// control period each, because then a plant's data are loaded into the processor's cache once a
/// period and not once a step. A plant of a robot of 36 rollers holds 20 kB: 10,000 of them 200 MB.
#[derive(Clone)]
pub struct Plant {
    /// The constant part, shared by all copies.
    plan: Arc<Plan>,
    clock: Clock,
    world: World,
    sensors: Sensors,
    drive: Drive,
    faults: Faults,
    disturbances: Disturbances,
    joint_targets: JointTargets,
    motors: Vec<MotorTorque>,
    /// For a passive wheel law.
    storage: Option<StorageAccount>,
    /// The physics step of the last measurement, counted from 1; 0 before the first.
    sensed: u64,
    outcome: Outcome,
}

/// The description from which a plant is built at each reset.
struct Plan {
    resolved: Resolved,
    robot: SharedRobot,
    /// Of the robot that the controller believes in.
    kinematics: Kinematics,
    floor: Floor,
    settings: Settings,
}

impl Plan {
    /// The scenario's reference at a time in seconds.
    fn desired(&self, t_s: f64) -> Option<Desired> {
        Some(self.resolved.reference()?.at(t_s))
    }

    /// Whether two plans describe the same scenario and the same robot, so that their plants differ
    /// only in state.
    fn is_that_of(&self, other: &Arc<Self>) -> Result<bool, Error> {
        if std::ptr::eq(self, Arc::as_ptr(other)) {
            return Ok(true);
        }
        let (ours, theirs) = (self.resolved.scenario(), other.resolved.scenario());
        // Compared as text, which includes every default and exact numbers; and the robot, because
        // its file may have changed.
        let (robot, their_robot): (&Robot, &Robot) = (&self.robot, &other.robot);
        Ok(robot == their_robot
            && self.floor == other.floor
            && ours.to_toml()? == theirs.to_toml()?)
    }
}

/// The storage account of a passive wheel law, if the scenario has one.
fn storage_account(resolved: &Resolved, wheels: usize) -> Option<StorageAccount> {
    let passive = resolved.scenario().wheel_loop.passive.as_ref()?;
    let along = passive.stiffness_n_m?;
    let stiffness = Vector3::new(along, along, passive.heading_stiffness_n_m_rad?);
    let point_m = resolved.reference_point_m();
    Some(StorageAccount::new(stiffness, point_m, wheels))
}

/// The state of a plant at one moment.
#[derive(Clone)]
pub struct Snapshot(Box<Plant>);

impl Plant {
    /// Places a robot in the world of a scenario that was resolved for it, at rest.
    ///
    /// # Errors
    /// If the robot cannot stand at its start, or a setting is invalid.
    pub fn new(resolved: &Resolved, robot: &Robot) -> Result<Self, Error> {
        let floor = floor::floor(
            resolved.scenario(),
            robot,
            resolved.choices().uneven.as_deref(),
        )?;
        Self::on_floor(resolved, robot, floor)
    }

    /// Places a robot on the caller's ground instead of the scenario's: measured heights, boxes,
    /// patches.
    ///
    /// # Errors
    /// Like [`Plant::new`], and if the ground is invalid.
    pub fn on_floor(resolved: &Resolved, robot: &Robot, floor: Floor) -> Result<Self, Error> {
        let plan = Plan {
            kinematics: resolved.kinematics(resolved.believed(robot))?.0,
            floor,
            settings: resolved.world_settings(),
            resolved: resolved.clone(),
            robot: SharedRobot::from(&resolved.choices().joint_targets.begun(robot)),
        };
        let seed = resolved.scenario().sensors.seed;
        Self::build(Arc::new(plan), seed, resolved.start())
    }

    fn build(plan: Arc<Plan>, seed: u64, start: Pose) -> Result<Self, Error> {
        let Plan {
            resolved,
            robot,
            kinematics,
            floor,
            settings,
        } = &*plan;
        let scenario = resolved.scenario();
        let physics_dt_s = resolved.physics_dt_s();
        let wheel_count = robot.wheels.len();
        let mut world = World::new(robot, floor, start, settings)?;
        bodies::put_in(scenario, &mut world)?;
        let drive = Drive::new(resolved, robot)?;
        let section = scenario::Sensors {
            seed,
            ..scenario.sensors.clone()
        };
        Ok(Self {
            clock: Clock::new(&scenario.run, physics_dt_s),
            world,
            sensors: Sensors::new(
                &section,
                start,
                (resolved.believed(robot), kinematics),
                scenario,
            )?,
            storage: storage_account(resolved, wheel_count),
            drive,
            faults: Faults::new(&scenario.faults, robot)?,
            disturbances: Disturbances::new(scenario, robot)?,
            joint_targets: resolved.choices().joint_targets.clone(),
            motors: vec![MotorTorque::constant(0.0); wheel_count],
            sensed: 0,
            outcome: Outcome {
                torques_n_m: vec![0.0; wheel_count],
                wheels: vec![WheelTally::default(); wheel_count],
                ..Outcome::default()
            },
            plan,
        })
    }

    /// Restarts: time zero, the robot at rest at a pose in the ground plane, noise from a seed.
    ///
    /// # Errors
    /// If the robot cannot stand there; the plant is then unchanged.
    pub fn reset(&mut self, seed: u64, pose: Pose) -> Result<(), Error> {
        let numbers = [pose.x_m, pose.y_m, pose.heading_rad];
        // The same limit as in a scenario. NaN fails it.
        let most = *scenario::SIZES.end();
        if !numbers.iter().all(|number| number.abs() <= most) {
            return Err(Error::invalid(
                format!("a robot cannot start at {pose:?}"),
                format!("give metres and radians of no more than {most:e}"),
            ));
        }
        *self = Self::build(Arc::clone(&self.plan), seed, pose)?;
        Ok(())
    }

    /// The current measurements of the robot's sensors. Repeated calls at the same moment return
    /// the same.
    pub fn observe(&mut self) -> &Measurements {
        let moment = self.clock.moments() + 1;
        if self.sensed != moment {
            self.sensed = moment;
            self.sensors.sense(
                self.clock.time_s(),
                self.clock.control_is_due(),
                &self.world,
                &self.faults,
            );
        }
        self.sensors.seen()
    }

    /// Advances the robot under a command by a time in seconds. If it ends within a physics step, a
    /// part of that step is taken, and the next advance first takes the rest: the plant's steps
    /// stay in place, whatever the host's steps are. Sampled and late wheel loops take
    /// only whole steps.
    ///
    /// Sensors with a rate or a delay continue meanwhile; others are sampled at multiples of the
    /// scenario's control period.
    ///
    /// # Errors
    /// [`Error::Invalid`] if the command is not one finite number per wheel, or the time is not a
    /// valid one: then nothing has happened. [`Error::Diverged`] if the robot's motion has become
    /// NaN or infinite.
    pub fn advance(&mut self, command: WheelCommand<'_>, period_s: f64) -> Result<&Outcome, Error> {
        self.advance_watched(command, period_s, |_, _| ())
    }

    /// Like [`Plant::advance`]; passes the world and the length of the step in seconds to `watch`
    /// after each physics step.
    ///
    /// # Errors
    /// Like [`Plant::advance`].
    pub fn advance_watched(
        &mut self,
        command: WheelCommand<'_>,
        period_s: f64,
        mut watch: impl FnMut(&World, f64),
    ) -> Result<&Outcome, Error> {
        self.check(command)?;
        self.check_period(period_s)?;
        self.outcome.wheels.fill(WheelTally::default());
        self.outcome.contact_residual_m_s = 0.0;
        let before_m_s = self.velocity_in_world_m_s();
        let mut left_s = period_s;
        while left_s > NO_TIME * self.clock.physics_dt_s() {
            let part_s = self.next_part_s(left_s);
            left_s -= part_s;
            self.actuate_for(command, part_s);
            self.step_for(part_s);
            let acted = self.world.robot().wheel_tallies();
            for (sum, step) in self.outcome.wheels.iter_mut().zip(acted) {
                sum.add(step);
            }
            let residual_m_s = self.world.contact_residual_m_s();
            let worst_m_s = &mut self.outcome.contact_residual_m_s;
            *worst_m_s = worst_m_s.max(residual_m_s);
            watch(&self.world, part_s);
        }
        for (mean_n_m, wheel) in (self.outcome.torques_n_m.iter_mut()).zip(&self.outcome.wheels) {
            *mean_n_m = wheel.torque_mean_n_m();
        }
        self.outcome.torque_shares = self.drive.shares();
        let gained_m_s = self.velocity_in_world_m_s() - before_m_s;
        self.outcome.acceleration_in_world_m_s2 = (gained_m_s / period_s).into();
        if !self.is_finite() {
            return Err(Error::Diverged {
                t_s: self.clock.time_s(),
            });
        }
        Ok(&self.outcome)
    }

    /// Checks a command for this robot.
    fn check(&self, command: WheelCommand<'_>) -> Result<(), Error> {
        let (found, wheels) = (command.numbers().len(), self.motors.len());
        if found != wheels {
            return Err(Error::invalid(
                format!("a command of {found} numbers was given to a robot of {wheels} wheels"),
                "give one number a wheel, in the robot's order",
            ));
        }
        let wild = command.numbers().iter().find(|number| !number.is_finite());
        match wild {
            Some(number) => Err(Error::invalid(
                format!("a wheel was commanded {number}"),
                "give finite numbers",
            )),
            None => Ok(()),
        }
    }

    /// Refuses a time in seconds by which the plant cannot be advanced.
    fn check_period(&self, period_s: f64) -> Result<(), Error> {
        let physics_dt_s = self.clock.physics_dt_s();
        let steps = period_s / physics_dt_s;
        let is_whole = (steps - steps.round()).abs() <= NO_TIME * steps.round();
        let takes_parts = !(self.plan.resolved.scenario().wheel_loop).takes_whole_steps();
        let is_time = (SHORTEST_PART..=MOST_STEPS).contains(&steps);
        if is_time && (is_whole || takes_parts) {
            return Ok(());
        }
        let (why, help) = match is_time {
            false => (
                "this is not a time to advance by".to_owned(),
                "advance by at least a thousandth of a step and at most 1e9 steps",
            ),
            true => (
                format!("its wheel loops act in steps of {physics_dt_s} s"),
                "advance by a whole number of steps, such as the control period, or set `run.physics_dt_s`",
            ),
        };
        Err(Error::invalid(
            format!("the plant cannot be advanced by {period_s} s: {why}"),
            help,
        ))
    }

    /// The next part of a remaining time, in seconds: up to what begins or ends within the step, or
    /// the rest of the step, or the remaining time if that is shorter.
    fn next_part_s(&self, left_s: f64) -> f64 {
        let part_s = self.part_s();
        // Times that differ only by rounding count as the step.
        if left_s > part_s - NO_TIME * self.clock.physics_dt_s() {
            part_s
        } else {
            left_s
        }
    }

    /// How far the plant steps next, in seconds: to the end of its step, or to where a fault, a
    /// patch or a push begins or ends within it. Sampled and late wheel loops take only whole
    /// steps.
    pub(crate) fn part_s(&self) -> f64 {
        let (t_s, of_step_s) = (self.clock.time_s(), self.clock.left_s());
        if (self.plan.resolved.scenario().wheel_loop).takes_whole_steps() {
            return of_step_s;
        }
        let least_s = SHORTEST_PART * self.clock.physics_dt_s();
        let change_s = self.disturbances.next_change_s(t_s + least_s);
        match change_s < t_s + of_step_s - least_s {
            true => change_s - t_s,
            false => of_step_s,
        }
    }

    /// By how much each wheel's encoder counts wrong now: what it counts over what it should, where
    /// it is not lost.
    pub(crate) fn encoder_scales(&self) -> impl Iterator<Item = f64> + '_ {
        let wheels = 0..self.motors.len();
        wheels.map(|wheel| self.faults.encoder_scale(self.clock.time_s(), wheel))
    }

    /// Converts a command to the motors' actions in the coming physics step, or part of one.
    pub fn actuate(&mut self, command: WheelCommand<'_>) {
        self.actuate_for(command, self.part_s());
    }

    /// Like [`Self::actuate`], for a part of a step, in seconds.
    fn actuate_for(&mut self, command: WheelCommand<'_>, part_s: f64) {
        self.observe();
        let middle_s = self.clock.time_s() + 0.5 * part_s;
        if self.clock.control_is_due() {
            let robot = self.world.robot();
            (self.drive).stand(robot.joint_positions(), robot.joint_targets());
        }
        let rates = WheelRates {
            real_rad_s: self.world.robot().wheel_rates_rad_s(),
            seen_rad_s: &self.sensors.seen().wheel_rates_rad_s,
        };
        let known = BodySense {
            angles_rad: &self.sensors.seen().wheel_angles_rad,
            gravity_in_body_m_s2: self.sensors.gravity_in_body_m_s2(),
        };
        let torques = self.drive.torques(
            command,
            (rates, &known),
            self.faults.supply_share(middle_s),
            part_s,
        );
        self.motors.copy_from_slice(torques);
        for (wheel, motor) in self.motors.iter_mut().enumerate() {
            // A lost motor has no loop.
            match self.faults.lost_motor(middle_s, wheel) {
                Some(LostMotor::Free) => *motor = MotorTorque::constant(0.0),
                Some(LostMotor::Shorted) => {
                    *motor = self.drive.shorted(wheel, rates.real_rad_s[wheel]);
                }
                None => {}
            }
        }
    }

    /// Takes a physics step with the current motor actions, or a part of one where something begins
    /// or ends within it, and returns its length in seconds.
    pub fn step(&mut self) -> f64 {
        let part_s = self.part_s();
        self.step_for(part_s);
        part_s
    }

    /// Like [`Self::step`], for a part of a step, in seconds.
    fn step_for(&mut self, dt_s: f64) {
        let t_s = self.clock.time_s();
        self.joint_targets
            .send(t_s + 0.5 * dt_s, dt_s, &mut self.world);
        self.disturbances.act(t_s, dt_s, &mut self.world);
        self.world.robot_mut().drive(&self.motors);
        if let (Some(storage), Some(effort)) = (&mut self.storage, self.drive.passive_effort()) {
            let desired = self.plan.desired(t_s);
            storage.before(&self.world, &effort, desired.as_ref());
        }
        self.world.step_for(dt_s);
        if let (Some(storage), Some(effort)) = (&mut self.storage, self.drive.passive_effort()) {
            let desired = self.plan.desired(t_s + dt_s);
            storage.after(&self.world, &effort, desired.as_ref(), dt_s);
        }
        if dt_s < self.clock.left_s() {
            self.clock.tick_part(dt_s);
        } else {
            self.clock.tick();
        }
    }

    /// Whether the wheel loops have rate targets: a passive law has none.
    pub fn has_rate_targets(&self) -> bool {
        self.drive.passive_effort().is_none()
    }

    /// Storage and supply of a passive wheel law after its last decision; `None` for other laws.
    pub fn storage(&self) -> Option<Storage> {
        let (storage, effort) = (self.storage.as_ref()?, self.drive.passive_effort()?);
        let desired = self.plan.desired(self.clock.time_s());
        Some(storage.now(&self.world, &effort, desired.as_ref()))
    }

    /// Coulomb friction coefficient with which the floor was built, outside patches; for a floor of
    /// a material, with the rollers of the first wheel.
    pub fn floor_friction(&self) -> f64 {
        self.plan.floor.friction
    }

    /// The last measurements of the sensors.
    pub fn seen(&self) -> &Measurements {
        self.sensors.seen()
    }

    /// The share of each task that the torque law gave last; `None` for a law that weighs no tasks.
    pub fn torque_shares(&self) -> Option<TorqueShares> {
        self.drive.shares()
    }

    /// The clock of the run.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// Simulated time since the start or the last reset, in seconds.
    pub fn time_s(&self) -> f64 {
        self.clock.time_s()
    }

    /// The robot's true pose and motion.
    pub fn truth(&self) -> Truth {
        let body = self.world.robot().state();
        Truth {
            pose: body.pose,
            height_m: body.height_m,
            roll_rad: body.roll_rad,
            pitch_rad: body.pitch_rad,
            twist_in_body: body.twist_in_body,
        }
    }

    /// Velocity of the body frame's origin in the world frame, in m/s.
    fn velocity_in_world_m_s(&self) -> Vector3<f64> {
        let body = self.world.robot().state();
        body.world_from_body * body.velocity_in_body_m_s
    }

    fn is_finite(&self) -> bool {
        // A sum is finite only where all of its terms are.
        let (now, twist) = (self.truth(), self.truth().twist_in_body);
        let place_m = now.pose.position_m().sum() + now.height_m;
        let angles_rad = now.pose.heading_rad + now.roll_rad + now.pitch_rad;
        let speeds = twist.linear_m_s().sum() + twist.omega_rad_s;
        [place_m, angles_rad, speeds]
            .into_iter()
            .all(f64::is_finite)
    }

    /// The outcome of the last advance; zeros before the first.
    pub fn outcome(&self) -> &Outcome {
        &self.outcome
    }

    /// The current world: contacts, energies, rollers.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Rapier's world, for user bodies that interact with the robot: see [`World::rapier_mut`].
    ///
    /// # Errors
    /// [`Error::World`] if rapier solves the robot's contacts.
    pub fn rapier_mut(&mut self) -> Result<&mut PhysicsWorld, Error> {
        Ok(self.world.rapier_mut()?)
    }

    /// The robot.
    pub fn robot(&self) -> &Robot {
        &self.plan.robot
    }

    /// The kinematics about the robot's origin, of the robot that the controller believes in: wheel
    /// rates for a twist, and back.
    pub fn kinematics(&self) -> &Kinematics {
        &self.plan.kinematics
    }

    /// The scenario with every default and every choice written out.
    pub fn resolved(&self) -> &Resolved {
        &self.plan.resolved
    }

    /// Saves the current state.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot(Box::new(self.clone()))
    }

    /// Returns to a snapshot of this plant, or of another one of the same scenario and robot; from
    /// there it continues identically to the bit.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a snapshot of another scenario or robot; the plant is then unchanged.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), Error> {
        if !self.plan.is_that_of(&snapshot.0.plan)? {
            return Err(Error::invalid(
                format!(
                    "the snapshot is of another simulation, of `{}` with the robot `{}`: this one is of `{}` with `{}`",
                    snapshot.0.plan.resolved.scenario().name,
                    snapshot.0.plan.robot.name,
                    self.plan.resolved.scenario().name,
                    self.plan.robot.name,
                ),
                "go back to a snapshot of the same scenario, with the same keys and the same robot",
            ));
        }
        *self = (*snapshot.0).clone();
        Ok(())
    }
}

impl std::fmt::Debug for Plant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Plant")
            .field("robot", &self.plan.robot.name)
            .field("time_s", &self.time_s())
            .field("truth", &self.truth())
            .finish_non_exhaustive()
    }
}

impl std::fmt::Debug for Snapshot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Snapshot").field(&self.0).finish()
    }
}
