//! Records a run, once a control period or less often.

use ilon_control::{ContactKinematics, Kinematics};
use ilon_robot::{Pose, Robot, Twist};
use ilon_trace::{
    Desired, Figures, Header, Joined, MAX_TASKS, Record, Settings, TaskShare, Trace, WheelSample,
};
use ilon_world::World;

use crate::pilot::{Idle, Pilot};
use crate::plant::Plant;
use crate::record::budget::Budget;
use crate::record::header::{Appearance, header};
use crate::record::period::Period;
use crate::sensing::hubs::Hubs;
use crate::sensing::reckoning::Reckoning;
use ilon_scenario::course::command::{Commanded, Decided};
use ilon_scenario::scenario::TIME_SLACK_S;
use ilon_scenario::{Error, Resolved};

/// Writes down what happens to a [`Plant`]: the growing trace, and what has to be summed between
/// its rows.
///
/// For a loop of a program around a plant, once a control period: [`Recorder::reckon`] with the
/// angles that were seen, decide, [`Recorder::record`] (or [`Recorder::hold`] where no row is
/// wanted), and [`Recorder::count`] after every physics step of [`Plant::advance_watched`].
pub struct Recorder {
    trace: Trace,
    /// Of the real robot, not of the believed one.
    kinematics: Kinematics,
    contact_kinematics: ContactKinematics,
    /// For a robot with wheels moved by joints that it measures, and whose controller believes in
    /// another robot: the wheels' places under these.
    hubs: Option<Hubs>,
    /// The last positions of the joints between bodies, in rad or m. Empty before the first.
    positions: Vec<f64>,
    /// The controller's dead reckoning.
    reckoning: Reckoning,
    /// From row to row.
    row_period_s: f64,
    /// The energy lost at each wheel since the start.
    lost: Vec<Lost>,
    /// Since the last control instant.
    period: Period,
    /// Since the last row.
    joined: Joined,
    /// Of all control periods, where fewer have a row.
    figures: Option<Figures>,
    /// Since the start.
    budget: Budget,
    samples: Vec<WheelSample>,
    /// Seconds between samples of the rollers' angles, where they are recorded, and how many have
    /// been taken.
    rollers_every_s: Option<f64>,
    rollers_taken: u64,
}

/// The energy lost at a wheel since the start, in J.
#[derive(Clone, Copy, Debug, Default)]
struct Lost {
    slip_j: f64,
    spin_up_j: f64,
}

impl Recorder {
    /// For a robot that starts at a pose; with `header.record_every` control periods per row, and
    /// memory for a number of rows.
    pub fn new(
        header: Header,
        resolved: &Resolved,
        robot: &Robot,
        start: Pose,
        rows: usize,
    ) -> Result<Self, Error> {
        let (scenario, believed) = (resolved.scenario(), resolved.believed(robot));
        let (kinematics, contact_kinematics) = resolved.kinematics(robot)?;
        let wheel_count = robot.wheels.len();
        let of_encoders = (
            scenario.sensors.encoders.rate_noise_rad_s,
            header.control_dt_s,
        );
        let of_belief = resolved.kinematics(believed)?;
        let weight_n = header.mass_kg * scenario.world.gravity_m_s2;
        let is_uneven = header.has_term("incline");
        let roller_angles_hz = scenario.run.roller_angles_hz;
        let figures =
            (header.record_every > 1).then(|| Figures::new(&header, &Settings::default()));
        Ok(Self {
            row_period_s: header.control_dt_s * f64::from(header.record_every.max(1)),
            trace: Trace::with_capacity(header, rows),
            kinematics,
            contact_kinematics,
            hubs: (!std::ptr::eq(believed, robot))
                .then(|| Hubs::that_move(robot))
                .flatten(),
            positions: Vec::new(),
            reckoning: Reckoning::new(believed, of_belief, start, of_encoders),
            lost: vec![Lost::default(); wheel_count],
            period: Period::new(wheel_count, robot.joints.len()),
            joined: Joined::default(),
            figures,
            budget: Budget::new(start, wheel_count, weight_n, is_uneven),
            samples: vec![WheelSample::default(); wheel_count],
            rollers_every_s: roller_angles_hz.map(|rate_hz| 1.0 / rate_hz),
            rollers_taken: 0,
        })
    }

    /// For a loop of a program around this plant, which stands at its start: its rows are once a
    /// control period, and time counts from zero. `urdf` is [`ilon_formats::Loaded::urdf`], or
    /// empty.
    ///
    /// # Errors
    /// [`Error`] if the scenario cannot be written as text.
    pub fn of_plant(plant: &Plant, urdf: &str) -> Result<Self, Error> {
        let (resolved, robot) = (plant.resolved(), plant.robot());
        let pilot = Pilot::of(resolved, robot, Some(Box::new(Idle)))?;
        let header = Header {
            // One row per control period, without a known end.
            record_every: 1,
            control_periods: 0,
            ..header(resolved, robot, Appearance::by(urdf), &pilot)?
        };
        let start = plant.truth().pose;
        Self::new(header, resolved, robot, start, 1)
    }

    /// Sums the results of the last physics step.
    pub fn count(&mut self, world: &World, dt_s: f64) {
        for (lost, contact) in self.lost.iter_mut().zip(world.robot().contacts()) {
            lost.slip_j += contact.slip_power_w * dt_s;
            lost.spin_up_j += contact.spin_up_power_w * dt_s;
        }
        self.period.count(world, dt_s);
        let kinematics = (&self.kinematics, &mut self.contact_kinematics);
        self.budget.count(world, dt_s, kinematics);
        self.positions.clear();
        (self.positions).extend_from_slice(world.robot().joint_positions());
    }

    /// Takes in a control instant that has no row: what happened since the one before goes into the
    /// next row.
    pub fn hold(&mut self, t_s: f64, plant: &Plant, decided: &Decided<'_>) {
        let record = self.of_instant(t_s, plant, decided);
        if let Some(figures) = &mut self.figures {
            figures.add(&self.trace.header, &record, &self.samples);
        }
        self.joined.add(&record, &self.samples);
    }

    /// Adds a row: the state now, what was decided on it, and what happened since the last row.
    pub fn record(&mut self, t_s: f64, plant: &Plant, decided: &Decided<'_>) {
        self.hold(t_s, plant, decided);
        let (record, samples) = self.joined.take();
        self.trace.push(*record, samples);
        self.record_rollers(t_s, plant.world());
    }

    /// Puts the figures of all control periods into the header of the trace, where fewer of them
    /// have a row.
    pub(crate) fn end(&mut self) {
        if let Some(figures) = self.figures.take() {
            let summary = figures.finish(&self.trace.header);
            self.trace.header.figures = Some(Box::new(summary));
        }
    }

    /// Ends the span of the budget at a control instant, and begins the next with what was decided.
    fn decide(&mut self, plant: &Plant, decided: &Decided<'_>) {
        let kinematics = (&self.kinematics, &mut self.contact_kinematics);
        self.budget.end_span(plant.world(), kinematics);
        let has_targets = plant.has_rate_targets() && decided.commanded == Commanded::Rates;
        let twists = has_targets.then(|| {
            [
                decided.command_twist_in_body,
                decided.granted_twist_in_body,
                self.reckoning.twist(decided.wheel_rates_rad_s),
                self.kinematics.twist(decided.wheel_rates_rad_s) + self.by_casters(),
            ]
        });
        let by_casters = self.by_casters();
        let period_s = self.trace.header.control_dt_s;
        let hubs = self.hubs.as_ref().or(self.reckoning.hubs());
        let along = hubs.into_iter().flat_map(Hubs::carried_of_pairs_rad);
        let moved = (by_casters, along.map(|rad| rad / period_s));
        self.budget.decide(twists, moved, plant.encoder_scales());
    }

    /// The twist by the joints of active casters in the last control period.
    fn by_casters(&self) -> Twist {
        let hubs = self.hubs.as_ref().or(self.reckoning.hubs());
        let moved = hubs.map(Hubs::moved_by_pairs);
        (moved.unwrap_or_default()).scaled(1.0 / self.trace.header.control_dt_s)
    }

    /// The row of a control instant: the state now, what was decided on it, and what happened since
    /// the instant before. The samples of its wheels are in `samples`.
    fn of_instant(&mut self, t_s: f64, plant: &Plant, decided: &Decided<'_>) -> Record {
        self.decide(plant, decided);
        let (world, seen, shares) = (plant.world(), plant.seen(), plant.torque_shares());
        let angles_rad = world.robot().wheel_angles_rad();
        let rates_rad_s = world.robot().wheel_rates_rad_s();
        let by_casters = self.by_casters();
        let twist_contact = self.contact_kinematics.twist(angles_rad, rates_rad_s) + by_casters;

        let mut tasks = [TaskShare::default(); MAX_TASKS];
        for (share, task) in tasks.iter_mut().zip(decided.tasks) {
            *share = TaskShare {
                asked_rad_s: task.asked_rad_s,
                capacity_rad_s: task.capacity_rad_s,
                weight: task.weight,
                asked_twist_in_body: task.twist_in_body,
            };
        }
        let energy = world.energy();
        let mut record = Record {
            t_s,
            truth: plant.truth(),
            twist_ideal: self.kinematics.twist(rates_rad_s) + by_casters,
            twist_contact,
            seen_pose: seen.pose,
            odometry_ideal: self.reckoning.ideal(),
            odometry_contact: self.reckoning.contact(),
            odometry_posed: self.reckoning.posed(),
            desired: decided.desired.map(|desired| Desired {
                pose: desired.pose,
                velocity_in_world: desired.velocity_in_world,
                ..Desired::default()
            }),
            measured: decided.measured,
            command_twist_in_body: decided.command_twist_in_body,
            granted_twist_in_body: decided.granted_twist_in_body,
            twist_target_ideal: self.kinematics.twist(decided.wheel_rates_rad_s) + by_casters,
            saturated_share: f64::from(u8::from(decided.is_limited)),
            tasks,
            joints: self.period.joints(world),
            bodies: self.period.bodies(world),
            torque_weight_position: shares.map_or(1.0, |shares| shares.position),
            torque_weight_heading: shares.map_or(1.0, |shares| shares.heading),
            ledger: *self.budget.ledger(),
            slip_energy_j: world.slip_energy_j(),
            spin_up_energy_j: world.spin_up_energy_j(),
            motor_energy_j: world.motor_energy_j(),
            motor_positive_energy_j: world.motor_positive_energy_j(),
            bearing_energy_j: world.bearing_energy_j(),
            impact_energy_j: world.impact_energy_j(),
            outside_energy_j: world.outside_energy_j(),
            kinetic_energy_j: energy.kinetic_j,
            potential_energy_j: energy.potential_j,
            contact_residual_m_s: self.period.residual_m_s,
            rate_conflict_share: self.budget.take_conflict_share(),
            support: Some(self.period.support(plant.truth().pose.heading_rad)),
            reckoned: (self.reckoning).reckoned(&seen.wheel_rates_rad_s, self.row_period_s),
            imu: seen.imu,
            storage: plant.storage(),
        };
        let off = self.trace.header.tracking_error(&record);
        if let (Some(desired), Some((off_m, off_rad))) = (&mut record.desired, off) {
            (desired.position_error_max_m, desired.heading_error_max_rad) = (off_m, off_rad);
        }
        self.sample_wheels(world, decided.wheel_rates_rad_s);
        self.period.clear();
        record
    }

    /// Puts the rollers' angles into the last row where they are due: at most once a row, and on
    /// the mean as often as asked.
    fn record_rollers(&mut self, t_s: f64, world: &World) {
        let Some(every_s) = self.rollers_every_s else {
            return;
        };
        let due = ((t_s + TIME_SLACK_S) / every_s).floor() as u64 + 1;
        if due > self.rollers_taken {
            self.rollers_taken = due;
            let wheels = 0..self.samples.len();
            let angles = wheels.flat_map(|wheel| world.robot().roller_angles_rad(wheel));
            self.trace.push_roller_angles(angles);
        }
    }

    /// A remark on inconsistent wheel rates of the run; `None` if they were consistent.
    pub fn contradiction_remark(&self, robot: &Robot) -> Option<String> {
        let found = self.budget.contradiction();
        found.remark(&self.kinematics, robot, "the rates of the wheels")
    }

    /// The trace so far.
    pub fn trace(&self) -> &Trace {
        &self.trace
    }

    /// The pose by dead reckoning with Indiveri 2009, eq. (7), from the true pose at the start.
    pub fn odometry(&self) -> Pose {
        self.reckoning.ideal()
    }

    /// The trace so far, from which rows can be taken.
    pub fn trace_mut(&mut self) -> &mut Trace {
        &mut self.trace
    }

    /// Removes and returns all rows.
    pub fn take_trace(&mut self) -> Trace {
        let none = Trace::with_capacity(self.trace.header.clone(), 0);
        std::mem::replace(&mut self.trace, none)
    }

    /// Dead reckoning from the wheels' rotation since the last control period, by both kinematics,
    /// like a robot with encoders once a control period.
    pub fn reckon(&mut self, angles_rad: &[f64]) {
        let moved = self.reckoning.reckon(angles_rad, &self.positions);
        let kinematics = match &mut self.hubs {
            Some(hubs) => {
                let positions = self.reckoning.positions();
                let moved = !positions.is_empty() && hubs.see(positions);
                hubs.kinematics().filter(|_| moved)
            }
            None => moved.then(|| self.reckoning.kinematics()),
        };
        if let Some(kinematics) = kinematics {
            self.kinematics.clone_from(kinematics);
            self.contact_kinematics.stand(kinematics);
        }
    }

    fn sample_wheels(&mut self, world: &World, targets_rad_s: &[f64]) {
        let robot = world.robot();
        let contacts = robot.contacts().iter().enumerate();
        for (sample, (wheel, contact)) in self.samples.iter_mut().zip(contacts) {
            let rate_rad_s = robot.wheel_rates_rad_s()[wheel];
            // Nothing commands a caster.
            let commanded = (!self.kinematics.swivels(wheel)).then(|| targets_rad_s[wheel]);
            let target_rad_s = commanded.unwrap_or(rate_rad_s);
            *sample = WheelSample {
                target_rad_s,
                target_peak_rad_s: target_rad_s.abs(),
                rate_rad_s,
                angle_rad: robot.wheel_angles_rad()[wheel],
                hub_height_m: robot.hub_height_m(wheel),
                roller: contact.roller as u32,
                touching: contact.touching,
                slip_energy_j: self.lost[wheel].slip_j,
                spin_up_energy_j: self.lost[wheel].spin_up_j,
                ..WheelSample::default()
            };
            if contact.touching {
                sample.load_share = contact.load_share;
                sample.roller_spin_rad_s = contact.roller_spin_rad_s;
                sample.roller_spin_ideal_rad_s = contact.roller_spin_ideal_rad_s;
            }
            self.period.put_wheel(wheel, sample);
            self.period.command(wheel, commanded, rate_rad_s);
        }
    }
}
