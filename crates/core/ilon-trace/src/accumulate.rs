//! The figures of a run as they grow, row by row.

use ilon_robot::{Twist, wrap_angle};

use crate::balance::Balance;
use crate::design::Design;
use crate::effects::Effects;
use crate::fold::{Largest, Mean, Rms, finite};
use crate::header::Header;
use crate::joint_travel::JointAccumulator;
use crate::ledger::{Ledger, Terms};
use crate::metrics::{Settings, Summary, TwistRatio, error};
use crate::odometry;
use crate::projection::Projection;
use crate::record::{Record, WheelSample};
use crate::rows::Rows;
use crate::slip::WheelAccumulator;
use crate::trace::Trace;
use crate::twin::Convergence;

impl Summary {
    /// The figures of a run whose rows need not lie in memory.
    ///
    /// # Errors
    /// Where the rows cannot be read.
    pub fn of_rows<R: Rows>(rows: &R, settings: &Settings) -> Result<Self, R::Error> {
        let header = rows.header();
        let Counted {
            run,
            all_wheels,
            twist_ripple,
            trace_hash,
        } = Counted::of(rows, settings)?;

        let twist_mean = run.twist.get();
        let last_s = run.last.map(|last| last.t_s);
        let duration_s = last_s.map_or(0.0, |last_s| header.row_end_s(last_s));
        let (twist_ideal_mean, twist_contact_mean) =
            (run.twist_ideal.get(), run.twist_contact.get());
        let turned = run.driven(twist_ideal_mean, settings.driven_share);
        let twist_asked_mean = run.twist_asked.get();
        let asked = run.driven(twist_asked_mean, settings.driven_share);
        // A share of a component that was not asked for says nothing beside one that was.
        let any_asked = asked.contains(&true);
        let driven = std::array::from_fn(|axis| turned[axis] && (asked[axis] || !any_asked));
        let chassis_load_share = run.chassis_load_share();
        let reckoning = run.reckoning.finish();
        let slips = header.wheels.iter().zip(run.wheels);
        let wheels: Vec<_> = slips
            .map(|(wheel, accumulator)| accumulator.finish(wheel))
            .collect();
        let mut summary = Self {
            scenario: header.scenario_name.clone(),
            robot: header.robot_name.clone(),
            duration_s,
            steps: physics_steps(duration_s, header.physics_dt_s),
            physics_dt_s: header.physics_dt_s,
            control_dt_s: header.control_dt_s,
            sim_seconds_per_cpu_second: None,
            trace_hash,
            position_error_rms_m: run.position.rms.get(),
            position_error_max_m: run.position.largest.map(|(error, _)| error),
            position_error_max_at_s: run.position.largest.map(|(_, t_s)| t_s),
            position_error_final_m: run.position.last,
            heading_error_rms_rad: run.heading.rms.get(),
            heading_error_max_rad: run.heading.largest.map(|(error, _)| error),
            heading_error_max_at_s: run.heading.largest.map(|(_, t_s)| t_s),
            heading_error_final_rad: run.heading.last,
            position_converged_s: run.position.converged_s,
            heading_converged_s: run.heading.converged_s,
            seen_position_error_rms_m: run.seen_m.get(),
            seen_heading_error_rms_rad: run.seen_rad.get(),
            wheel_rate_error_rms_rad_s: all_wheels.rate_error_rad_s.get(),
            wheel_rate_command_max_rad_s: all_wheels.command_rad_s.get(),
            wheel_torque_max_n_m: all_wheels.torque_n_m.get(),
            rate_conflict_share: run.conflict.get(),
            saturated_share: run.saturated.get(),
            twist_asked_mean,
            twist_mean,
            twist_ripple,
            twist_ideal_mean,
            twist_contact_mean,
            twist_ratio_asked: ratio(twist_mean, twist_asked_mean, asked),
            twist_ratio_ideal: ratio(twist_mean, twist_ideal_mean, driven),
            twist_ratio_contact: ratio(twist_mean, twist_contact_mean, driven),
            slip_speed_rms_m_s: all_wheels.slip_m_s.get(),
            slip_speed_max_m_s: all_wheels.slip_largest_m_s.get(),
            slip_energy_j: run.last.and_then(|r| finite(r.slip_energy_j)),
            wheel_slip_energy_j: finite(wheels.iter().map(|wheel| wheel.energy_j).sum()),
            friction_used_max: wheels
                .iter()
                .filter_map(|wheel| wheel.friction_used_max)
                .reduce(f64::max),
            airborne_share: all_wheels.airborne.get(),
            chassis_load_share,
            contact_residual_max_m_s: run.residual_m_s.get(),
            storage_rise_j: run.storage_rise_j.get(),
            odometry_drift_m_per_m: reckoning.ideal.m_per_m,
            odometry_drift_rad_per_m: reckoning.ideal.rad_per_m,
            odometry_joints_m: run.last.and_then(|last| {
                let posed = last.odometry_posed?;
                Some((posed.position_m() - last.odometry_ideal.position_m()).norm())
            }),
            hub_ripple_m: wheels
                .iter()
                .filter_map(|wheel| wheel.hub_ripple_m)
                .reduce(f64::max),
            end_x_m: run.last.map(|last| last.truth.pose.x_m),
            end_y_m: run.last.map(|last| last.truth.pose.y_m),
            end_heading_rad: run.last.map(|last| last.truth.pose.heading_rad),
            travelled_m: reckoning.travelled_m,
            turned_rad: reckoning.turned_rad,
            odometry_ideal: reckoning.ideal,
            odometry_contact: reckoning.contact,
            ledger: run.last.map_or_else(Ledger::default, |last| last.ledger),
            energy: run.balance.finish(header),
            converge: Convergence::default(),
            effects: Effects::default(),
            design: Design::default(),
            wheels,
            joints: run.joints.travels(header),
        };
        summary.converge = Convergence::of(&summary, header);
        summary.effects = Effects::of(&summary, header);
        Ok(summary)
    }
}

/// What the passes over a run's rows count.
struct Counted {
    run: Accumulator,
    all_wheels: AllWheels,
    /// Of a run in open loop.
    twist_ripple: Option<Twist>,
    trace_hash: String,
}

impl Counted {
    fn of<R: Rows>(rows: &R, settings: &Settings) -> Result<Self, R::Error> {
        let header = rows.header();
        let mut run = Accumulator::new(header, settings);
        rows.each_batch(Projection::All, &mut |chunk| run.add(header, chunk))?;
        let mut all_wheels = AllWheels::default();
        for wheel in 0..header.wheels.len() {
            all_wheels.before_s = 0.0;
            rows.each_batch(Projection::Wheel(wheel), &mut |chunk| {
                all_wheels.add(chunk, wheel);
            })?;
        }
        let mut twist_ripple = None;
        if let Some(mean) = run.twist.get().filter(|_| header.open_loop) {
            let mut ripple = Ripple::default();
            rows.each_batch(Projection::Robot, &mut |chunk| {
                ripple.add(header, chunk, mean)
            })?;
            twist_ripple = Some(ripple.get());
        }
        Ok(Self {
            run,
            all_wheels,
            twist_ripple,
            trace_hash: crate::hash::hash_of_rows(rows)?,
        })
    }
}

/// What is counted in one pass over all rows.
struct Accumulator {
    position: ErrorAccumulator,
    heading: ErrorAccumulator,
    seen_m: Rms,
    seen_rad: Rms,
    saturated: Mean,
    conflict: Conflict,
    twist: MeanTwist,
    twist_asked: MeanTwist,
    twist_ideal: MeanTwist,
    twist_contact: MeanTwist,
    /// The farthest wheel's distance from the body's origin, in metres.
    arm_m: f64,
    ideal_speed_m_s: Rms,
    reckoning: odometry::Accumulator,
    residual_m_s: Largest,
    storage_rise_j: Largest,
    balance: Balance,
    /// What the wheels and the chassis carried, over time, in N s.
    carried_n_s: [f64; 2],
    /// The last row within the window of the means.
    measured: Option<Record>,
    last: Option<Record>,
    wheels: Vec<WheelAccumulator>,
    joints: JointAccumulator,
}

impl Accumulator {
    fn new(header: &Header, settings: &Settings) -> Self {
        Self {
            position: ErrorAccumulator::new(settings.position_threshold_m),
            heading: ErrorAccumulator::new(settings.heading_threshold_rad),
            seen_m: Rms::default(),
            seen_rad: Rms::default(),
            saturated: Mean::default(),
            conflict: Conflict::default(),
            twist: MeanTwist::default(),
            twist_asked: MeanTwist::default(),
            twist_ideal: MeanTwist::default(),
            twist_contact: MeanTwist::default(),
            arm_m: header.arm_m(),
            ideal_speed_m_s: Rms::default(),
            reckoning: odometry::Accumulator::default(),
            residual_m_s: Largest::default(),
            storage_rise_j: Largest::default(),
            balance: Balance::default(),
            carried_n_s: [0.0; 2],
            measured: None,
            last: None,
            wheels: WheelAccumulator::of_each(header),
            joints: JointAccumulator::default(),
        }
    }

    fn add(&mut self, header: &Header, chunk: &Trace) {
        for (record, samples) in chunk.steps() {
            self.conflict.add(header, record, samples);
            self.add_record(header, record);
            for (wheel, sample) in self.wheels.iter_mut().zip(samples) {
                wheel.add(header, record, sample);
            }
        }
    }

    fn add_record(&mut self, header: &Header, record: &Record) {
        let off = error(header, record);
        let most = record
            .desired
            .map(|desired| [desired.position_error_max_m, desired.heading_error_max_rad]);
        let errors = off.zip(most).map(|((off_m, off_rad), [most_m, most_rad])| {
            ((off_m, most_m.max(off_m)), (off_rad, most_rad.max(off_rad)))
        });
        let (off_m, off_rad) = errors.unzip();
        self.position.add(record.t_s, off_m);
        self.heading.add(record.t_s, off_rad);

        let (seen, truth) = (record.seen_pose, record.truth.pose);
        self.seen_m
            .add((seen.position_m() - truth.position_m()).norm());
        self.seen_rad
            .add(wrap_angle(seen.heading_rad - truth.heading_rad));

        if header.open_loop || !header.task_names.is_empty() {
            self.saturated
                .add_weighted(record.saturated_share, header.periods_up_to(record.t_s));
        }
        if header.is_measured(record.t_s) {
            // By how the robot moved since the last row, and not how it moves now: rollers that hand over between two rows change its
            // velocity.
            if let Some(before) = self.measured.replace(*record) {
                self.add_motion(&before, record);
            }
            let v = record.twist_ideal;
            let speed_m_s = libm::hypot(v.vx_m_s, v.vy_m_s);
            self.ideal_speed_m_s
                .add(libm::hypot(speed_m_s, self.arm_m * v.omega_rad_s));
        }
        self.reckoning.add(record);
        self.joints.add(header, record);
        self.residual_m_s.add(record.contact_residual_m_s);
        if let Some(storage) = record.storage {
            self.storage_rise_j.add(storage.rise_j);
        }
        if let (Some(support), Some(before)) = (record.support, &self.last) {
            let since_s = record.t_s - before.t_s;
            self.carried_n_s[0] += support.wheels_n * since_s;
            self.carried_n_s[1] += support.chassis_n * since_s;
        }
        self.balance.add(record);
        self.last = Some(*record);
    }

    /// Adds how the robot moved from one row to the next, and how it would have by the chain of the ledger.
    fn add_motion(&mut self, before: &Record, record: &Record) {
        let span_s = record.t_s - before.t_s;
        let real = before.truth.pose.displacement_to(&record.truth.pose);
        let terms = Terms::between(before, record);
        let contact = real + (terms.slip + terms.conflict + terms.lift_off).scaled(span_s);
        self.twist.add(real, span_s);
        self.twist_asked
            .add(real + terms.total.scaled(span_s), span_s);
        self.twist_contact.add(contact, span_s);
        self.twist_ideal
            .add(contact + terms.geometry.scaled(span_s), span_s);
    }

    /// The share of all that is carried that rests on the chassis; `None` where nothing is, or that is not known.
    fn chassis_load_share(&self) -> Option<f64> {
        let [wheels_n_s, chassis_n_s] = self.carried_n_s;
        let sum_n_s = wheels_n_s + chassis_n_s;
        (sum_n_s > 0.0).then(|| chassis_n_s / sum_n_s)
    }

    /// Which components of a mean twist, that the wheels turn for or that was asked for, are driven.
    fn driven(&self, mean: Option<Twist>, share: f64) -> [bool; 3] {
        // A micrometre per second: nothing drives a robot that stands.
        const STANDING_M_S: f64 = 1e-6;
        let (Some(mean), Some(speed_rms)) = (mean, self.ideal_speed_m_s.get()) else {
            return [false; 3];
        };
        [mean.vx_m_s, mean.vy_m_s, self.arm_m * mean.omega_rad_s]
            .map(|component| component.abs() > (share * speed_rms).max(STANDING_M_S))
    }
}

/// How much of the wheels' rates belongs to no one motion: sums over time of squares of rates, in rad^2/s.
#[derive(Default)]
struct Conflict {
    of_no_motion: f64,
    of_all: f64,
}

impl Conflict {
    fn add(&mut self, header: &Header, record: &Record, samples: &[WheelSample]) {
        let rates = samples.iter().map(|sample| sample.rate_rad_s);
        let of_row = rates.map(|rate| rate * rate).sum::<f64>() * header.row_span_s(record.t_s);
        self.of_all += of_row;
        self.of_no_motion += of_row * record.rate_conflict_share * record.rate_conflict_share;
    }

    fn get(&self) -> Option<f64> {
        (self.of_all > 0.0).then(|| (self.of_no_motion / self.of_all).sqrt())
    }
}

/// An error over the run, and since when it is small for good.
struct ErrorAccumulator {
    threshold: f64,
    rms: Rms,
    last: Option<f64>,
    /// The largest error and when it first was so large, in seconds.
    largest: Option<(f64, f64)>,
    /// The time from which on the error has stayed below the threshold; `None` where it has not, or where some row had
    /// no reference.
    converged_s: Option<f64>,
    without_reference: bool,
}

impl ErrorAccumulator {
    fn new(threshold: f64) -> Self {
        Self {
            threshold,
            rms: Rms::default(),
            last: None,
            largest: None,
            converged_s: None,
            without_reference: false,
        }
    }

    /// Adds the error of a row, and the largest since the row before.
    fn add(&mut self, t_s: f64, error: Option<(f64, f64)>) {
        if let Some((error, most)) = error {
            self.rms.add(error);
            self.last = Some(error);
            if self.largest.is_none_or(|(largest, _)| most > largest) {
                self.largest = Some((most, t_s));
            }
        } else {
            self.without_reference = true;
        }
        let is_small = error.is_some_and(|(_, most)| most < self.threshold);
        if is_small && !self.without_reference {
            self.converged_s.get_or_insert(t_s);
        } else {
            self.converged_s = None;
        }
    }
}

/// A mean twist over time, component by component.
#[derive(Clone, Copy, Default)]
struct MeanTwist {
    moved: Twist,
    time_s: f64,
}

impl MeanTwist {
    /// Adds a displacement in the body frame over a time in seconds.
    fn add(&mut self, moved: Twist, time_s: f64) {
        self.moved = self.moved + moved;
        self.time_s += time_s;
    }

    fn get(self) -> Option<Twist> {
        (self.time_s > 0.0).then(|| self.moved.scaled(1.0 / self.time_s))
    }
}

/// Figures over all wheels, which are counted one wheel after the other.
#[derive(Default)]
struct AllWheels {
    /// The time of the row before, in seconds.
    before_s: f64,
    rate_error_rad_s: Rms,
    command_rad_s: Largest,
    torque_n_m: Largest,
    slip_m_s: Rms,
    slip_largest_m_s: Largest,
    airborne: Mean,
}

impl AllWheels {
    fn add(&mut self, chunk: &Trace, wheel: usize) {
        for (record, sample) in chunk.records().iter().zip(chunk.wheel(wheel)) {
            let period_s = record.t_s - std::mem::replace(&mut self.before_s, record.t_s);
            self.rate_error_rad_s
                .add(sample.target_rad_s - sample.rate_rad_s);
            self.command_rad_s.add(sample.target_peak_rad_s);
            self.torque_n_m.add(sample.torque_peak_n_m());
            if record.has_contacts() {
                self.airborne
                    .add_weighted(1.0 - sample.touching_share, period_s);
            }
            if sample.touched() {
                self.slip_m_s
                    .add_weighted(sample.slip_speed_rms_m_s, period_s * sample.touching_share);
                self.slip_largest_m_s.add(sample.slip_speed_max_m_s);
            }
        }
    }
}

/// Rms deviation of the real twist from its mean within the window of the means, component by component.
#[derive(Default)]
struct Ripple([Rms; 3]);

impl Ripple {
    fn add(&mut self, header: &Header, chunk: &Trace, mean: Twist) {
        for record in chunk.records() {
            if header.is_measured(record.t_s) {
                let off = record.truth.twist_in_body - mean;
                let components = [off.vx_m_s, off.vy_m_s, off.omega_rad_s];
                for (rms, component) in self.0.iter_mut().zip(components) {
                    rms.add(component);
                }
            }
        }
    }

    fn get(&self) -> Twist {
        let [vx_m_s, vy_m_s, omega_rad_s] = self.0.map(|rms| rms.get().unwrap_or(0.0));
        Twist::new(vx_m_s, vy_m_s, omega_rad_s)
    }
}

/// Number of physics steps in the run; 0 where the step is unknown.
fn physics_steps(duration_s: f64, physics_dt_s: f64) -> u64 {
    if physics_dt_s > 0.0 {
        (duration_s / physics_dt_s).round() as u64
    } else {
        0
    }
}

/// Real over modelled, for the driven components.
fn ratio(real: Option<Twist>, modelled: Option<Twist>, driven: [bool; 3]) -> TwistRatio {
    let (Some(real), Some(modelled)) = (real, modelled) else {
        return TwistRatio::default();
    };
    let of = |driven: bool, real: f64, modelled: f64| {
        (driven && modelled != 0.0).then(|| real / modelled)
    };
    TwistRatio {
        vx: of(driven[0], real.vx_m_s, modelled.vx_m_s),
        vy: of(driven[1], real.vy_m_s, modelled.vy_m_s),
        omega: of(driven[2], real.omega_rad_s, modelled.omega_rad_s),
    }
}
