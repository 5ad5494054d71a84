//! Collects everything that the report needs from all rows in one pass, so that the rows need not
//! be in memory.

use std::f64::consts::TAU;

use ilon_robot::{Twist, wrap_angle};
use ilon_trace::ledger::TERMS;
use ilon_trace::slip::constraint_residual_m_s;
use ilon_trace::{Header, MAX_TASKS, Record, Rows, Trace, WheelHeader, WheelSample};

use super::decimate::{Envelope, Evenly, MAX_POINTS};
use super::story::{Event, Integrator, Measured, OffCourse, Standing, Watch, apart};

/// Quantities of the robot that are drawn over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OfRobot {
    /// Distance of the real pose from the desired one, in metres.
    PositionError,
    /// Desired minus actual heading, in degrees.
    HeadingError,
    /// Distance of the pose estimated by the robot from the desired one, in metres.
    SeenPositionError,
    /// Desired minus estimated heading, in degrees.
    SeenHeadingError,
    /// A component of one of the twists: 0 ahead and 1 to the left, in m/s, 2 the yaw rate in
    /// rad/s.
    Twist(TwistOf, usize),
    /// Distance of dead reckoning by the ideal kinematics from the truth, in metres.
    IdealDrift,
    /// Distance of dead reckoning by the contacts from the truth, in metres.
    ContactDrift,
    /// Distance of the actual pose from the one in a measured log, in metres.
    MeasuredDistance,
    /// Actual minus measured heading, in degrees.
    MeasuredTurn,
    /// Share of the commanded linear acceleration of the reference point that the torques give.
    PositionTorqueWeight,
    /// Share of the commanded angular acceleration that the torques give.
    HeadingTorqueWeight,
    /// The weight of a task.
    TaskWeight(usize),
    /// The capacity of a task, in rad/s.
    TaskCapacity(usize),
    /// The energy supplied, in J.
    PutIn,
    /// The solver's own energy error, in J.
    Unexplained,
}

/// Twists that are drawn, in the body frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TwistOf {
    /// The actual twist.
    Real,
    /// The commanded twist, before saturation.
    Asked,
    /// Indiveri 2009, eq. (7), from the actual wheel rates.
    Ideal,
    /// From the touching rollers.
    Contact,
}

/// Quantities of each wheel that are drawn over time, in the units of the trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OfWheel {
    /// Sliding speed.
    SlipSpeed,
    /// Energy lost to sliding.
    SlipEnergy,
    /// Normal force.
    NormalForce,
    /// Tangential force.
    TangentialForce,
    /// Used share of the friction cone; NaN without contact force.
    GripUsed,
    /// Residual of Indiveri 2009, eq. (5).
    Residual,
    /// The roller's spin, actual minus ideal.
    SpinError,
    /// The actual wheel rate.
    Rate,
    /// The commanded wheel rate.
    Target,
    /// The motor's torque.
    Torque,
}

impl OfRobot {
    /// Returns all quantities that a run can have.
    fn all(header: &Header) -> Vec<Self> {
        use TwistOf::{Asked, Contact, Ideal, Real};
        let tasks = 0..header.task_names.len().min(MAX_TASKS);
        let twists = [Real, Asked, Ideal, Contact].into_iter();
        [
            Self::PositionError,
            Self::HeadingError,
            Self::SeenPositionError,
            Self::SeenHeadingError,
            Self::IdealDrift,
            Self::ContactDrift,
            Self::MeasuredDistance,
            Self::MeasuredTurn,
            Self::PositionTorqueWeight,
            Self::HeadingTorqueWeight,
            Self::PutIn,
            Self::Unexplained,
        ]
        .into_iter()
        .chain(twists.flat_map(|twist| (0..3).map(move |axis| Self::Twist(twist, axis))))
        .chain(tasks.flat_map(|task| [Self::TaskWeight(task), Self::TaskCapacity(task)]))
        .collect()
    }

    /// Returns the value in a row; `None` if the row has none. `first` is the run's first record.
    fn of(self, header: &Header, first: &Record, record: &Record) -> Option<f64> {
        let point = |pose| header.reference_point_at(pose);
        let off = |pose| Some((record.desired?.pose, point(pose)));
        let off_m = |pose| {
            let (desired, pose) = off(pose)?;
            Some((desired.position_m() - pose.position_m()).norm())
        };
        let off_deg = |pose| {
            let (desired, pose) = off(pose)?;
            Some(wrap_angle(desired.heading_rad - pose.heading_rad).to_degrees())
        };
        let (truth, seen) = (record.truth.pose, record.seen_pose);
        let task = |index: usize| record.tasks.get(index);
        Some(match self {
            Self::PositionError => off_m(truth)?,
            Self::HeadingError => off_deg(truth)?,
            Self::SeenPositionError => off_m(seen)?,
            Self::SeenHeadingError => off_deg(seen)?,
            Self::Twist(twist, axis) => {
                let Twist {
                    vx_m_s,
                    vy_m_s,
                    omega_rad_s,
                } = twist.of(record);
                [vx_m_s, vy_m_s, omega_rad_s][axis]
            }
            Self::IdealDrift => (record.odometry_ideal.position_m() - truth.position_m()).norm(),
            Self::ContactDrift => {
                (record.odometry_contact.position_m() - truth.position_m()).norm()
            }
            Self::MeasuredDistance => apart(truth, record.measured?).0,
            Self::MeasuredTurn => apart(truth, record.measured?).1.to_degrees(),
            Self::PositionTorqueWeight => record.torque_weight_position,
            Self::HeadingTorqueWeight => record.torque_weight_heading,
            Self::TaskWeight(index) => task(index)?.weight,
            Self::TaskCapacity(index) => task(index)?.capacity_rad_s,
            Self::PutIn => record.motor_energy_j + record.outside_energy_j,
            Self::Unexplained => {
                let stored_j = |r: &Record| r.kinetic_energy_j + r.potential_energy_j;
                let put_in_j = record.motor_energy_j + record.outside_energy_j;
                let lost_j = record.slip_energy_j
                    + record.spin_up_energy_j
                    + record.bearing_energy_j
                    + record.impact_energy_j;
                put_in_j - lost_j - (stored_j(record) - stored_j(first))
            }
        })
    }
}

impl TwistOf {
    fn of(self, record: &Record) -> Twist {
        match self {
            Self::Real => record.truth.twist_in_body,
            Self::Asked => record.command_twist_in_body,
            Self::Ideal => record.twist_ideal,
            Self::Contact => record.twist_contact,
        }
    }
}

impl OfWheel {
    const ALL: [Self; 10] = [
        Self::SlipSpeed,
        Self::SlipEnergy,
        Self::NormalForce,
        Self::TangentialForce,
        Self::GripUsed,
        Self::Residual,
        Self::SpinError,
        Self::Rate,
        Self::Target,
        Self::Torque,
    ];

    fn of(self, wheel: &WheelHeader, record: &Record, sample: &WheelSample) -> f64 {
        match self {
            Self::SlipSpeed => sample.slip_speed_rms_m_s,
            Self::SlipEnergy => sample.slip_energy_j,
            Self::NormalForce => sample.normal_force_n,
            Self::TangentialForce => sample.tangential_force_n(),
            Self::GripUsed => sample.friction_used().unwrap_or(f64::NAN),
            Self::Residual => {
                let twist = record.truth.twist_in_body;
                constraint_residual_m_s(wheel, twist, sample.rate_rad_s).unwrap_or(f64::NAN)
            }
            Self::SpinError => sample.roller_spin_rad_s - sample.roller_spin_ideal_rad_s,
            Self::Rate => sample.rate_rad_s,
            Self::Target => sample.target_rad_s,
            Self::Torque => sample.torque_n_m,
        }
    }
}

/// Data collected from all rows of a run.
pub(super) struct Accumulated {
    /// Number of rows of the run.
    pub row_count: usize,
    /// Whether the robot's estimated pose ever differs from the actual one.
    pub sees_otherwise: bool,
    /// Distance of the robot from the one in a measured log.
    pub measured: Measured,
    robot: Vec<(OfRobot, Envelope)>,
    wheels: Vec<OneWheel>,
    grown: Evenly<Grown>,
    /// Events for the story.
    pub watch: Watch,
    integrator: Integrator,
    /// What leads from the ledger to the error at the end.
    pub off_course: OffCourse,
    standings: Evenly<Option<Standing>>,
    /// The parts of the error, at evenly spaced instants.
    pub stood: Vec<Standing>,
    first: Option<Record>,
    last_s: f64,
    /// The robot's speed at the end, in m/s.
    pub ends_at_m_s: f64,
}

/// Data collected for one wheel.
struct OneWheel {
    curves: Vec<(OfWheel, Envelope)>,
    slip_around: Bins<SECTORS>,
    load_in_pitch: Bins<PITCH_BINS>,
    slip_in_pitch: Bins<PITCH_BINS>,
}

/// Accumulated displacement of a term of the ledger, in millimetres, and its rotation in degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Way {
    pub way_mm: f64,
    pub turn_deg: f64,
}

/// The terms of the ledger at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Grown {
    pub t_s: f64,
    pub ways: [Way; TERMS],
}

/// Sectors of a wheel's turn.
pub(super) const SECTORS: usize = 72;
/// Number of bins of a roller's pitch.
pub(super) const PITCH_BINS: usize = 40;
/// Number of instants at which the ledger's growth is drawn.
const GROWTH_POINTS: usize = 600;
/// Number of instants for the error budget.
const BUDGET_POINTS: usize = 4000;

impl Accumulated {
    /// Reads all rows.
    pub fn of<R: Rows>(rows: &R) -> Result<Self, R::Error> {
        let header = rows.header();
        let row_count = rows.row_count();
        let outline = || Envelope::new(row_count, MAX_POINTS);
        let robot = OfRobot::all(header).into_iter();
        let wheel = || OneWheel {
            curves: OfWheel::ALL.map(|what| (what, outline())).into(),
            slip_around: Bins::default(),
            load_in_pitch: Bins::default(),
            slip_in_pitch: Bins::default(),
        };
        let mut gathered = Self {
            row_count,
            sees_otherwise: false,
            measured: Measured::default(),
            robot: robot.map(|what| (what, outline())).collect(),
            wheels: header.wheels.iter().map(|_| wheel()).collect(),
            grown: Evenly::new(row_count, GROWTH_POINTS),
            watch: Watch::new(header),
            integrator: Integrator::default(),
            off_course: OffCourse::default(),
            standings: Evenly::new(row_count, BUDGET_POINTS),
            stood: Vec::new(),
            first: None,
            last_s: 0.0,
            ends_at_m_s: 0.0,
        };
        rows.each_batch(&mut |chunk| gathered.add(header, chunk))?;
        gathered.stood = gathered
            .standings
            .kept()
            .iter()
            .copied()
            .flatten()
            .collect();
        Ok(gathered)
    }

    fn add(&mut self, header: &Header, chunk: &Trace) {
        for (record, samples) in chunk.steps() {
            self.add_record(header, record);
            self.watch.add(header, record, samples);
            self.standings.add(self.integrator.add(header, record));
            let wheels = self.wheels.iter_mut().zip(&header.wheels).zip(samples);
            for ((gathered, wheel), sample) in wheels {
                gathered.add(wheel, record, sample);
            }
        }
    }

    fn add_record(&mut self, header: &Header, record: &Record) {
        let first = *self.first.get_or_insert(*record);
        self.last_s = record.t_s;
        self.ends_at_m_s = record.truth.twist_in_body.linear_m_s().norm();
        self.sees_otherwise |= record.seen_pose != record.truth.pose;
        self.measured.add(record);
        self.off_course.add(header, record);
        for (what, outline) in &mut self.robot {
            if let Some(value) = what.of(header, &first, record) {
                outline.add((record.t_s, value));
            }
        }
        self.grown.add(Grown {
            t_s: record.t_s,
            ways: record.ledger.terms().map(|term| Way {
                way_mm: 1e3 * term.path_m,
                turn_deg: term.turned_rad.to_degrees(),
            }),
        });
    }

    /// The times of the first and the last row, in seconds; empty for a run without rows.
    pub fn ends_s(&self) -> impl Iterator<Item = f64> {
        let first = self.first.iter();
        first.flat_map(|first| [first.t_s, self.last_s])
    }

    /// Returns a quantity of the robot over time: the time in seconds and the value, reduced to its
    /// envelope.
    pub fn robot(&self, what: OfRobot) -> impl Iterator<Item = (f64, f64)> {
        let found = self.robot.iter().find(|(known, _)| *known == what);
        found.into_iter().flat_map(|(_, outline)| outline.points())
    }

    /// Returns a quantity of a wheel over time: the time in seconds and the value, reduced to its
    /// envelope.
    pub fn wheel(&self, index: usize, what: OfWheel) -> impl Iterator<Item = (f64, f64)> {
        let curves = self.wheels.get(index).map(|wheel| &wheel.curves);
        let mut curves = curves.into_iter().flatten();
        let found = curves.find(|(known, _)| *known == what);
        found.into_iter().flat_map(|(_, outline)| outline.points())
    }

    /// Returns the largest value of a quantity over all wheels and the run, at least 0. The
    /// envelope preserves it.
    pub fn largest(&self, what: OfWheel) -> f64 {
        let values = (0..self.wheels.len()).flat_map(|index| self.wheel(index, what));
        values.map(|(_, value)| value).fold(0.0, f64::max)
    }

    /// Returns all events, in the order of time.
    pub fn events(&self, header: &Header) -> Vec<Event> {
        self.watch.events(header)
    }

    /// The growth of the ledger's terms.
    pub fn grown(&self) -> &[Grown] {
        self.grown.kept()
    }

    /// Returns the mean square of a wheel's sliding speed over the sectors of its turn, in (m/s)^2;
    /// NaN where it never touched.
    pub fn slip_around(&self, index: usize) -> [f64; SECTORS] {
        self.wheels[index].slip_around.means()
    }

    /// Returns the mean load share of a wheel's carrying roller over the wheel's angle within a
    /// roller pitch.
    pub fn load_in_pitch(&self, index: usize) -> [f64; PITCH_BINS] {
        self.wheels[index].load_in_pitch.means()
    }

    /// Returns the mean square of a wheel's sliding speed over the wheel's angle within a roller
    /// pitch, in (mm/s)^2.
    pub fn slip_in_pitch(&self, index: usize) -> [f64; PITCH_BINS] {
        self.wheels[index].slip_in_pitch.means()
    }
}

impl OneWheel {
    fn add(&mut self, wheel: &WheelHeader, record: &Record, sample: &WheelSample) {
        for (what, outline) in &mut self.curves {
            outline.add((record.t_s, what.of(wheel, record, sample)));
        }
        if !sample.touching {
            return;
        }
        let turns = sample.angle_rad.rem_euclid(TAU) / TAU;
        self.slip_around
            .add(turns, sample.slip_speed_rms_m_s.powi(2));
        let rollers = wheel.roller_count.max(1) as f64;
        let pitches = (sample.angle_rad * rollers / TAU).rem_euclid(1.0);
        self.load_in_pitch.add(pitches, sample.load_share);
        self.slip_in_pitch
            .add(pitches, (1e3 * sample.slip_speed_rms_m_s).powi(2));
    }
}

/// Means over equal parts of a turn.
struct Bins<const N: usize>([(f64, u32); N]);

impl<const N: usize> Default for Bins<N> {
    fn default() -> Self {
        Self([(0.0, 0); N])
    }
}

impl<const N: usize> Bins<N> {
    /// Adds a value at a part of the turn, in [0, 1].
    fn add(&mut self, turn: f64, value: f64) {
        // A turn of 1 - 1e-17 rounds to 1.
        let (sum, count) = &mut self.0[((turn * N as f64) as usize).min(N - 1)];
        *sum += value;
        *count += 1;
    }

    /// Returns the means; NaN for empty bins.
    fn means(&self) -> [f64; N] {
        self.0.map(|(sum, count)| sum / f64::from(count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folding_lays_all_pitches_of_a_turn_over_each_other() {
        let header = Header {
            wheels: vec![WheelHeader {
                roller_count: 4,
                ..WheelHeader::default()
            }],
            ..Header::default()
        };
        let mut trace = Trace::with_capacity(header, 5);
        // 6 deg into the first, second and third pitch of 90 deg, and backwards 6 deg into the
        // last; one in the air.
        for (angle_deg, load_share, touching) in [
            (6.0, 0.5, true),
            (96.0, 0.7, true),
            (186.0, 0.9, true),
            (-84.0, 0.5, true),
            (6.0, 0.0, false),
        ] {
            let sample = WheelSample {
                angle_rad: f64::to_radians(angle_deg),
                load_share,
                touching,
                ..WheelSample::default()
            }
            .steady();
            trace.push(Record::default(), &[sample]);
        }
        let Ok(gathered) = Accumulated::of(&trace);
        let shares = gathered.load_in_pitch(0);
        // Bins of 2.25 deg: 6 deg lies in the third. Four numbers below 1: rounding below 1e-15.
        assert!((shares[2] - 0.65).abs() < 1e-15);
        assert_eq!(shares.iter().filter(|share| share.is_finite()).count(), 1);
    }

    /// Each axis of a twist with three different numbers returns its own, row by row.
    #[test]
    fn a_quantity_of_the_robot_is_its_own() {
        let mut trace = Trace::with_capacity(Header::default(), 3);
        for row in 0..3 {
            let mut record = Record {
                t_s: 0.1 * f64::from(row),
                ..Record::default()
            };
            record.truth.twist_in_body = Twist::new(0.1, 0.2, 0.3);
            trace.push(record, &[]);
        }
        let Ok(gathered) = Accumulated::of(&trace);
        for (axis, value) in [0.1, 0.2, 0.3].into_iter().enumerate() {
            let what = OfRobot::Twist(TwistOf::Real, axis);
            let values: Vec<f64> = gathered.robot(what).map(|(_, value)| value).collect();
            assert_eq!(values, [value; 3]);
        }
    }
}
