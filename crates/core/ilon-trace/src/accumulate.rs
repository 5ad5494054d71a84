//! The figures of a run as they grow.

use ilon_robot::{Twist, wrap_angle};

use crate::balance::Balance;
use crate::design::Design;
use crate::effects::Effects;
use crate::fold::{Largest, Mean, Rms, finite};
use crate::header::Header;
use crate::joint_travel::JointAccumulator;
use crate::ledger::{Ledger, Terms};
use crate::metrics::{Settings, Summary, TwistRatio};
use crate::odometry;
use crate::record::{Record, WheelSample};
use crate::rows::Rows;
use crate::slip::WheelAccumulator;
use crate::trace::Trace;
use crate::twin::Convergence;

impl Summary {
    /// The figures of a trace.
    pub fn of(trace: &Trace, settings: &Settings) -> Self {
        let Ok(summary) = Self::of_rows(trace, settings);
        summary
    }

    /// The figures of a run whose rows need not lie in memory. Where not each control period has a
    /// row they are those that the header has, whatever the thresholds.
    ///
    /// # Errors
    /// Where the rows cannot be read.
    pub fn of_rows<R: Rows>(rows: &R, settings: &Settings) -> Result<Self, R::Error> {
        let header = rows.header();
        let mut summary = match &header.figures {
            Some(figures) => Self::clone(figures),
            None => {
                let mut figures = Figures::new(header, settings);
                rows.each_batch(&mut |chunk| {
                    for (record, samples) in chunk.steps() {
                        figures.add(header, record, samples);
                    }
                })?;
                figures.finish(header)
            }
        };
        summary.trace_hash = crate::hash::hash_of_rows(rows)?;
        summary.converge = Convergence::of(&summary, header);
        summary.effects = Effects::of(&summary, header);
        Ok(summary)
    }
}

impl Figures {
    /// The figures of what was added, but for the trace's hash and what twins say.
    pub fn finish(self, header: &Header) -> Summary {
        let twist_mean = self.twist.get();
        let last_s = self.last.map(|last| last.t_s);
        let duration_s = last_s.map_or(0.0, |last_s| header.row_end_s(last_s));
        let (twist_ideal_mean, twist_contact_mean) =
            (self.twist_ideal.get(), self.twist_contact.get());
        let turned = self.driven(twist_ideal_mean);
        let twist_asked_mean = self.twist_asked.get();
        let asked = self.driven(twist_asked_mean);
        // A share of a component that was not asked for says nothing beside one that was.
        let any_asked = asked.contains(&true);
        let driven = std::array::from_fn(|axis| turned[axis] && (asked[axis] || !any_asked));
        let chassis_load_share = self.chassis_load_share();
        let reckoning = self.reckoning.finish();
        let slips = header.wheels.iter().zip(self.wheels);
        let wheels: Vec<_> = slips
            .map(|(wheel, accumulator)| accumulator.finish(wheel))
            .collect();
        Summary {
            scenario: header.scenario_name.clone(),
            robot: header.robot_name.clone(),
            duration_s,
            steps: physics_steps(duration_s, header.physics_dt_s),
            physics_dt_s: header.physics_dt_s,
            control_dt_s: header.control_dt_s,
            sim_seconds_per_cpu_second: None,
            trace_hash: String::new(),
            position_error_rms_m: self.position.rms.get(),
            position_error_max_m: self.position.largest.map(|(error, _)| error),
            position_error_max_at_s: self.position.largest.map(|(_, t_s)| t_s),
            position_error_final_m: self.position.last,
            heading_error_rms_rad: self.heading.rms.get(),
            heading_error_max_rad: self.heading.largest.map(|(error, _)| error),
            heading_error_max_at_s: self.heading.largest.map(|(_, t_s)| t_s),
            heading_error_final_rad: self.heading.last,
            position_converged_s: self.position.converged_s,
            heading_converged_s: self.heading.converged_s,
            seen_position_error_rms_m: self.seen_m.get(),
            seen_heading_error_rms_rad: self.seen_rad.get(),
            wheel_rate_error_rms_rad_s: self.all_wheels.rate_error_rad_s.get(),
            wheel_rate_command_max_rad_s: self.all_wheels.command_rad_s.get(),
            wheel_torque_max_n_m: self.all_wheels.torque_n_m.get(),
            rate_conflict_share: self.conflict.get(),
            saturated_share: self.saturated.get(),
            twist_asked_mean,
            twist_mean,
            twist_ripple: twist_mean
                .filter(|_| header.open_loop)
                .map(|mean| self.ripple.about(mean)),
            twist_ideal_mean,
            twist_contact_mean,
            twist_ratio_asked: ratio(twist_mean, twist_asked_mean, asked),
            twist_ratio_ideal: ratio(twist_mean, twist_ideal_mean, driven),
            twist_ratio_contact: ratio(twist_mean, twist_contact_mean, driven),
            slip_speed_rms_m_s: self.all_wheels.slip_m_s.get(),
            slip_speed_max_m_s: self.all_wheels.slip_largest_m_s.get(),
            slip_energy_j: self.last.and_then(|r| finite(r.slip_energy_j)),
            wheel_slip_energy_j: finite(wheels.iter().map(|wheel| wheel.energy_j).sum()),
            friction_used_max: wheels
                .iter()
                .filter_map(|wheel| wheel.friction_used_max)
                .reduce(f64::max),
            airborne_share: self.all_wheels.airborne.get(),
            chassis_load_share,
            contact_residual_max_m_s: self.residual_m_s.get(),
            storage_rise_j: self.storage_rise_j.get(),
            odometry_drift_m_per_m: reckoning.ideal.m_per_m,
            odometry_drift_rad_per_m: reckoning.ideal.rad_per_m,
            odometry_joints_m: self.last.and_then(|last| {
                let posed = last.odometry_posed?;
                Some((posed.position_m() - last.odometry_ideal.position_m()).norm())
            }),
            hub_ripple_m: wheels
                .iter()
                .filter_map(|wheel| wheel.hub_ripple_m)
                .reduce(f64::max),
            end_x_m: self.last.map(|last| last.truth.pose.x_m),
            end_y_m: self.last.map(|last| last.truth.pose.y_m),
            end_heading_rad: self.last.map(|last| last.truth.pose.heading_rad),
            travelled_m: reckoning.travelled_m,
            turned_rad: reckoning.turned_rad,
            odometry_ideal: reckoning.ideal,
            odometry_contact: reckoning.contact,
            ledger: self.last.map_or_else(Ledger::default, |last| last.ledger),
            energy: self.balance.finish(header),
            converge: Convergence::default(),
            effects: Effects::default(),
            design: Design::default(),
            wheels,
            joints: self.joints.travels(header),
        }
    }
}

/// The figures of a run as they grow: row by row, or control period by control period where fewer
/// have a row.
pub struct Figures {
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
    driven_share: f64,
    ideal_speed_m_s: Rms,
    ripple: Ripple,
    reckoning: odometry::Accumulator,
    residual_m_s: Largest,
    storage_rise_j: Largest,
    balance: Balance,
    /// Load on the wheels and on the chassis, integrated over time, in N s.
    carried_n_s: [f64; 2],
    /// The last row within the window of the means.
    measured: Option<Record>,
    last: Option<Record>,
    wheels: Vec<WheelAccumulator>,
    all_wheels: AllWheels,
    joints: JointAccumulator,
}

impl Figures {
    /// Of a run of which nothing was added yet.
    pub fn new(header: &Header, settings: &Settings) -> Self {
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
            driven_share: settings.driven_share,
            ideal_speed_m_s: Rms::default(),
            ripple: Ripple::default(),
            reckoning: odometry::Accumulator::default(),
            residual_m_s: Largest::default(),
            storage_rise_j: Largest::default(),
            balance: Balance::default(),
            carried_n_s: [0.0; 2],
            measured: None,
            last: None,
            wheels: WheelAccumulator::of_each(header),
            all_wheels: AllWheels::default(),
            joints: JointAccumulator::default(),
        }
    }

    /// Adds the next row, or control period, with the samples of its wheels.
    pub fn add(&mut self, header: &Header, record: &Record, samples: &[WheelSample]) {
        let since_s = self.last.map_or(0.0, |last| record.t_s - last.t_s);
        self.conflict.add(record, samples, since_s);
        for (wheel, sample) in self.wheels.iter_mut().zip(samples) {
            wheel.add(header, record, sample);
            self.all_wheels.add(record, sample, since_s);
        }
        self.add_record(header, record, since_s);
    }

    fn add_record(&mut self, header: &Header, record: &Record, since_s: f64) {
        let off = header.tracking_error(record);
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
            // The first row is a control instant too.
            let instants = (since_s / header.control_dt_s).round().max(1.0);
            self.saturated
                .add_weighted(record.saturated_share, instants);
        }
        if header.is_measured(record.t_s) {
            // The mean twist follows from the displacement since the last row, not from the current
            // velocity: rollers that hand over between two rows change the velocity.
            if let Some(before) = self.measured.replace(*record) {
                self.add_motion(&before, record);
            }
            let v = record.twist_ideal;
            let speed_m_s = libm::hypot(v.vx_m_s, v.vy_m_s);
            self.ideal_speed_m_s
                .add(libm::hypot(speed_m_s, self.arm_m * v.omega_rad_s));
            self.ripple.add(record.truth.twist_in_body);
        }
        self.reckoning.add(record);
        self.joints.add(header, record);
        self.residual_m_s.add(record.contact_residual_m_s);
        if let Some(storage) = record.storage {
            self.storage_rise_j.add(storage.rise_j);
        }
        if let Some(support) = record.support {
            self.carried_n_s[0] += support.wheels_n * since_s;
            self.carried_n_s[1] += support.chassis_n * since_s;
        }
        self.balance.add(record);
        self.last = Some(*record);
    }

    /// Adds the displacement from one row to the next, and the displacements of the ledger's chain.
    fn add_motion(&mut self, before: &Record, record: &Record) {
        let span_s = record.t_s - before.t_s;
        let real = before.truth.pose.displacement_to(&record.truth.pose);
        let terms = Terms::between(before, record);
        let contact =
            real + (terms.incline + terms.slip + terms.conflict + terms.lift_off).scaled(span_s);
        self.twist.add(real, span_s);
        self.twist_asked
            .add(real + terms.total.scaled(span_s), span_s);
        self.twist_contact.add(contact, span_s);
        self.twist_ideal
            .add(contact + terms.geometry.scaled(span_s), span_s);
    }

    /// The share of the total load that rests on the chassis; `None` if there is no load or it is
    /// unknown.
    fn chassis_load_share(&self) -> Option<f64> {
        let [wheels_n_s, chassis_n_s] = self.carried_n_s;
        let sum_n_s = wheels_n_s + chassis_n_s;
        (sum_n_s > 0.0).then(|| chassis_n_s / sum_n_s)
    }

    /// Which components of a mean twist count as driven; the twist is the commanded one or that of
    /// the wheels.
    fn driven(&self, mean: Option<Twist>) -> [bool; 3] {
        // A slower robot counts as standing: a micrometre per second. Chosen.
        const STANDING_M_S: f64 = 1e-6;
        let (Some(mean), Some(speed_rms)) = (mean, self.ideal_speed_m_s.get()) else {
            return [false; 3];
        };
        [mean.vx_m_s, mean.vy_m_s, self.arm_m * mean.omega_rad_s]
            .map(|component| component.abs() > (self.driven_share * speed_rms).max(STANDING_M_S))
    }
}

/// The part of the wheel rates that no motion of the body explains: time integrals of squared
/// rates, in rad^2/s.
#[derive(Default)]
struct Conflict {
    of_no_motion: f64,
    of_all: f64,
}

impl Conflict {
    fn add(&mut self, record: &Record, samples: &[WheelSample], since_s: f64) {
        let rates = samples.iter().map(|sample| sample.rate_rad_s);
        let of_row = rates.map(|rate| rate * rate).sum::<f64>() * since_s;
        self.of_all += of_row;
        self.of_no_motion += of_row * record.rate_conflict_share * record.rate_conflict_share;
    }

    fn get(&self) -> Option<f64> {
        (self.of_all > 0.0).then(|| (self.of_no_motion / self.of_all).sqrt())
    }
}

/// An error over the run, and the time from which on it stays small.
struct ErrorAccumulator {
    threshold: f64,
    rms: Rms,
    last: Option<f64>,
    /// The largest error, and the time in seconds when it first occurs.
    largest: Option<(f64, f64)>,
    /// The time from which on the error stays below the threshold; `None` if it does not, or if a
    /// row had no reference.
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

    /// Adds the error of a row, which includes the largest error since the previous row.
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
    /// Adds a displacement in the body frame over `time_s` seconds.
    fn add(&mut self, moved: Twist, time_s: f64) {
        self.moved = self.moved + moved;
        self.time_s += time_s;
    }

    fn get(self) -> Option<Twist> {
        (self.time_s > 0.0).then(|| self.moved.scaled(1.0 / self.time_s))
    }
}

/// Figures over all wheels.
#[derive(Default)]
struct AllWheels {
    rate_error_rad_s: Rms,
    command_rad_s: Largest,
    torque_n_m: Largest,
    slip_m_s: Rms,
    slip_largest_m_s: Largest,
    airborne: Mean,
}

impl AllWheels {
    fn add(&mut self, record: &Record, sample: &WheelSample, since_s: f64) {
        self.rate_error_rad_s
            .add_weighted(sample.rate_error_rms_rad_s, since_s);
        self.command_rad_s.add(sample.target_peak_rad_s);
        self.torque_n_m.add(sample.torque_peak_n_m());
        if record.has_contacts() {
            self.airborne
                .add_weighted(1.0 - sample.touching_share, since_s);
        }
        if sample.touched() {
            self.slip_m_s
                .add_weighted(sample.slip_speed_rms_m_s, since_s * sample.touching_share);
            self.slip_largest_m_s.add(sample.slip_speed_max_m_s);
        }
    }
}

/// How far the real twist is from a mean, component by component: Welford's sums, as the mean is
/// known only at the end.
#[derive(Default)]
struct Ripple {
    rows: f64,
    mean: [f64; 3],
    squares: [f64; 3],
}

impl Ripple {
    fn add(&mut self, twist: Twist) {
        self.rows += 1.0;
        let components = [twist.vx_m_s, twist.vy_m_s, twist.omega_rad_s];
        let sums = self.mean.iter_mut().zip(&mut self.squares);
        for ((mean, squares), component) in sums.zip(components) {
            let off = component - *mean;
            *mean += off / self.rows;
            *squares += off * (component - *mean);
        }
    }

    /// Root mean squares about another mean.
    fn about(&self, mean: Twist) -> Twist {
        let about = [mean.vx_m_s, mean.vy_m_s, mean.omega_rad_s];
        let [vx_m_s, vy_m_s, omega_rad_s] = std::array::from_fn(|axis| {
            let off = self.mean[axis] - about[axis];
            (self.squares[axis] / self.rows + off * off).sqrt()
        });
        Twist::new(vx_m_s, vy_m_s, omega_rad_s)
    }
}

/// Number of physics steps in the run; 0 if the step is unknown.
fn physics_steps(duration_s: f64, physics_dt_s: f64) -> u64 {
    if physics_dt_s > 0.0 {
        (duration_s / physics_dt_s).round() as u64
    } else {
        0
    }
}

/// Real over modelled twist, for the driven components.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// 0.3 / 0.1 is below 3 by rounding.
    #[test]
    fn steps_are_counted_whole_whatever_the_division_rounds_to() {
        assert_eq!([physics_steps(0.3, 0.1), physics_steps(0.3, 0.0)], [3, 0]);
    }
}
