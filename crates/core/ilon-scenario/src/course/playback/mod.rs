//! Logs that drive the robot.

mod bag;
mod csv;
mod joint_log;
mod series;
mod wanted;

use std::cell::RefCell;
use std::sync::Arc;

use ilon_control::{Heading, Reference};
use ilon_robot::{JointKind, Pose, Robot, Twist};
use nalgebra::Vector2;

pub use self::joint_log::JointLog;
pub use self::series::Placing;
use self::series::{Series, is_wrapped, longest_gap_s, place, unwrap};
use self::wanted::{LogContents, Wanted};
use crate::Error;
use crate::scenario::{Drives, Scenario, TIME_SLACK_S};

/// Points of a path are at least this far apart, in seconds: a spline through closer poses follows
/// their noise. Chosen.
const PATH_STEP_S: f64 = 0.25;

/// The motion of a log, and the real robot's poses.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    drives: Drives,
    /// The places in the robot of the wheels that it drives.
    wheels: Vec<usize>,
    driving: Series,
    /// x, y and heading, unwrapped.
    measured: Option<Measured>,
    angle_gain_per_s: f64,
    control_dt_s: f64,
}

/// The real robot's poses.
#[derive(Clone, Debug, PartialEq)]
struct Measured {
    poses: Series,
    /// Whether they are placed at the simulated robot's start. That requires a log with a pose from
    /// the beginning.
    is_placed: bool,
}

/// The result of reading a log.
#[derive(Clone, Debug, Default)]
pub struct Played {
    /// The motion of wheels or body; `None` for a log that drives only joints.
    pub log: Option<Arc<Log>>,
    /// Joint indices, and the commands to their servos.
    pub joints: Vec<(usize, Arc<JointLog>)>,
    /// The end of its motion, in seconds of the run.
    pub end_s: f64,
    /// Whether the recording was cut short: it is played as far as it goes.
    pub is_cut_short: bool,
    /// The beginning and end of its longest gap, in seconds of the run; `None` without one.
    pub gap_s: Option<[f64; 2]>,
}

impl Played {
    /// Returns warnings about a recording that was cut short, or has a gap.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        let end_s = self.end_s;
        let said = format!(
            "a file of the bag of `playback` was cut short, and messages may be missing: it is played up to {end_s:.2} s"
        );
        let gap = self.gap_s.map(|[from_s, to_s]| {
            let over_it = match self.log.as_deref().is_some_and(Log::holds) {
                true => "the row before it holds until then",
                false => "it is bridged on a straight line",
            };
            format!("the log of `playback` has no rows from {from_s:.2} to {to_s:.2} s: {over_it}")
        });
        self.is_cut_short.then_some(said).into_iter().chain(gap)
    }
}

/// The demand of a log on the wheels at a time.
pub enum Asked {
    /// Rates, in rad/s.
    Rates,
    /// Torques, in N m.
    Torques,
    /// The rates of a twist in the body frame.
    Twist(Twist),
}

/// Reads the log that a scenario names, for a robot that starts at a pose; empty if it names none.
///
/// # Errors
/// If the log cannot be read, or lacks the data that drive the robot.
pub fn read(scenario: &Scenario, robot: &Robot, start: Pose) -> Result<Played, Error> {
    let Some(section) = &scenario.playback else {
        return Ok(Played::default());
    };
    let path = scenario.resolve(&section.file);
    // A log need not have the wheels that no motor drives.
    let wheels: Vec<(usize, &str)> = robot
        .wheels
        .iter()
        .enumerate()
        .filter(|(_, wheel)| wheel.motor.effort_n_m > 0.0)
        .map(|(index, wheel)| (index, wheel.name.as_str()))
        .collect();
    let moved = joints_without_aim(scenario, robot);
    let joints: Vec<(&str, JointKind)> = moved
        .iter()
        .map(|index| {
            (
                robot.joints[*index].name.as_str(),
                robot.joints[*index].kind,
            )
        })
        .collect();
    let wanted = Wanted {
        section,
        wheels: &wheels,
        all_wheels: robot.wheels.iter().map(|wheel| &wheel.name[..]).collect(),
        joints: &joints,
        path: &path,
        asked: RefCell::default(),
    };
    let said = match section.is_csv() {
        true => csv::read(&wanted, &scenario.files)?,
        false => bag::read(&wanted, &scenario.files)?,
    };
    let LogContents {
        mut driving,
        measured,
        mut joints,
        is_whole,
    } = said;
    let all = [Some(&driving), measured.as_ref()].into_iter().flatten();
    all.chain(&joints)
        .try_for_each(|series| grows(&wanted, series))?;
    let alone = section.drives == Drives::Joints;
    let first_s = match alone {
        true => joints
            .iter()
            .filter_map(|series| series.times_s.first().copied())
            .reduce(f64::min),
        false => driving.times_s.first().copied(),
    };
    let Some(first_s) = first_s else {
        if alone {
            return Err(moves_no_joint(&wanted));
        }
        return Err(wanted.fault(
            "it holds nothing that could drive the robot",
            "see `playback.drives` and `playback.topic`",
        ));
    };
    // Time counts from the first data that drive the robot.
    let shift_s = -first_s - section.from_s;
    joints
        .iter_mut()
        .for_each(|series| series.shift_times(shift_s));
    let mut told = Vec::new();
    for (index, series) in moved.into_iter().zip(&joints) {
        let log = JointLog::new(&wanted, &robot.joints[index].name, series)?;
        told.extend(log.map(|log| (index, Arc::new(log))));
    }
    let asks = alone || section.joint_topic.is_some() || section.joints_by.is_some();
    if told.is_empty() && asks {
        return Err(moves_no_joint(&wanted));
    }
    if alone {
        let ends_s = told.iter().map(|(_, log)| log.end_s());
        return Ok(Played {
            log: None,
            end_s: ends_s.fold(0.0, f64::max),
            joints: told,
            is_cut_short: !is_whole,
            gap_s: None,
        });
    }
    driving.shift_times(shift_s);
    let log = Log::new(
        &wanted,
        (driving, measured),
        shift_s,
        scenario.run.control_dt_s,
        start,
    )?;
    Ok(Played {
        end_s: log.end_s(),
        gap_s: longest_gap_s(&log.driving.times_s),
        log: Some(Arc::new(log)),
        joints: told,
        is_cut_short: !is_whole,
    })
}

/// The joints that a log may drive: those with a servo and without a target in the scenario.
fn joints_without_aim(scenario: &Scenario, robot: &Robot) -> Vec<usize> {
    let is_free = |index: &usize| {
        let joint = &robot.joints[*index];
        let asked = scenario.robot.joints.get(&joint.name);
        joint.servo().is_some()
            && asked
                .is_none_or(|asked| asked.setpoints.is_empty() && asked.options.target().is_none())
    };
    (0..robot.joints.len()).filter(is_free).collect()
}

/// The error for a log that should drive joints, but has no data for any.
fn moves_no_joint(wanted: &Wanted<'_>) -> Error {
    let names: Vec<String> = wanted
        .joints
        .iter()
        .map(|(joint, _)| format!("`{}`", wanted.name(joint)))
        .collect();
    let help = match (names.is_empty(), wanted.section.is_csv()) {
        (true, _) => "give a joint role = \"driven\", and neither a target nor setpoints, in [robot.joints.NAME]".to_owned(),
        (false, true) => format!(
            "looked for are columns such as {0}_position_rad, {0}_rate_rad_s and {0}_torque_n_m, or _position_m, _rate_m_s and _force_n of a joint that slides, of {1}; \
             `playback.names` says what a joint is called",
            wanted.name(wanted.joints[0].0),
            names.join(", ")
        ),
        (false, false) => format!(
            "looked for are positions, velocities and efforts of {}; `playback.names` says what a joint is called",
            names.join(", ")
        ),
    };
    wanted.fault("it drives no joint of the robot", help)
}

/// Refuses times that do not increase.
fn grows(wanted: &Wanted<'_>, series: &Series) -> Result<(), Error> {
    let times_s = &series.times_s;
    let Some(row) = times_s.windows(2).position(|pair| pair[1] <= pair[0]) else {
        return Ok(());
    };
    Err(wanted.fault(
        format!(
            "its times do not increase: {1} s comes after {0} s",
            times_s[row],
            times_s[row + 1]
        ),
        "sort its rows by time, and keep each time once",
    ))
}

impl Log {
    /// A log whose rows have the times of the run; the real robot's poses keep the log's times
    /// until they are shifted by the same amount.
    fn new(
        wanted: &Wanted<'_>,
        (mut driving, measured): (Series, Option<Series>),
        shift_s: f64,
        control_dt_s: f64,
        start: Pose,
    ) -> Result<Self, Error> {
        let section = wanted.section;
        if driving.len() == 1 {
            return Err(wanted.fault(
                "it has only one row, and no time at which it ends",
                "add a row at the time at which it ends",
            ));
        }
        if driving.end_s() <= 0.0 {
            return Err(wanted.fault(
                format!(
                    "`playback.from_s` = {} leaves nothing of it",
                    section.from_s
                ),
                format!("it is {:.3} s long", driving.end_s() + section.from_s),
            ));
        }
        let measured = match measured {
            None => None,
            Some(poses) if poses.len() == 0 => {
                return Err(wanted.fault(
                    "it has no poses of the real robot",
                    "see `playback.pose_topic`",
                ));
            }
            Some(mut poses) => {
                poses.shift_times(shift_s);
                unwrap(&mut poses, 2);
                let is_placed = poses.times_s[0] <= TIME_SLACK_S;
                if is_placed {
                    place(&mut poses, start);
                }
                Some(Measured { poses, is_placed })
            }
        };
        if section.drives == Drives::Path {
            unwrap(&mut driving, 2);
            place(&mut driving, start);
        }
        if section.drives == Drives::WheelAngles {
            for column in 0..driving.width {
                if is_wrapped(&driving, column) {
                    unwrap(&mut driving, column);
                }
                // Angles count from the values at the start of the run.
                let first = driving.between(0.0, column);
                let values = driving.values.iter_mut().skip(column);
                values
                    .step_by(driving.width)
                    .for_each(|angle| *angle -= first);
            }
        }
        Ok(Self {
            drives: section.drives,
            wheels: wanted.wheels.iter().map(|(wheel, _)| *wheel).collect(),
            driving,
            measured,
            angle_gain_per_s: section.angle_gain_per_s(),
            control_dt_s,
        })
    }

    /// The end of the robot's motion, in seconds of the run: if rows hold until the next, the time
    /// at which the last one has lasted for the usual interval; otherwise the time of the last row.
    pub fn end_s(&self) -> f64 {
        match self.holds() {
            true => self.driving.end_s(),
            false => self.driving.times_s.last().copied().unwrap_or(0.0),
        }
    }

    /// Whether each row holds until the next.
    fn holds(&self) -> bool {
        matches!(
            self.drives,
            Drives::WheelRates | Drives::WheelTorques | Drives::Twist
        )
    }

    /// The path of the log as a reference, if it is one.
    pub fn reference(&self) -> Option<Result<Reference, ilon_control::ControlError>> {
        if self.drives != Drives::Path {
            return None;
        }
        let (mut times_s, mut points_m, mut headings_rad) = (Vec::new(), Vec::new(), Vec::new());
        let rows = self.driving.len();
        for (index, (t_s, row)) in self.driving.rows().enumerate() {
            let far = times_s.last().is_none_or(|last| t_s - last >= PATH_STEP_S);
            if t_s >= 0.0 && (far || index + 1 == rows) {
                // The last point replaces one that is too near to it.
                if !far && times_s.len() > 1 {
                    times_s.pop();
                    points_m.pop();
                    headings_rad.pop();
                }
                times_s.push(t_s);
                points_m.push(Vector2::new(row[0], row[1]));
                headings_rad.push(row[2]);
            }
        }
        Some(Reference::waypoints(
            &times_s,
            points_m,
            Heading::Waypoints { headings_rad },
        ))
    }

    /// The demand for the control period that begins at a time, in seconds; rates or torques are written to `wheels`. `angles_rad` are
    /// the measured wheel angles.
    pub fn ask(&self, t_s: f64, angles_rad: &[f64], wheels: &mut [f64]) -> Asked {
        wheels.fill(0.0);
        match self.drives {
            Drives::WheelRates | Drives::WheelTorques => {
                for (column, wheel) in self.wheels.iter().enumerate() {
                    wheels[*wheel] = self.over_period(column, t_s);
                }
                match self.drives {
                    Drives::WheelTorques => Asked::Torques,
                    _ => Asked::Rates,
                }
            }
            Drives::WheelAngles => {
                for (column, wheel) in self.wheels.iter().enumerate() {
                    let now = self.driving.between(t_s, column);
                    let next = self.driving.between(t_s + self.control_dt_s, column);
                    wheels[*wheel] = (next - now) / self.control_dt_s
                        + self.angle_gain_per_s * (now - angles_rad[*wheel]);
                }
                Asked::Rates
            }
            Drives::Twist | Drives::Path | Drives::Joints => {
                let twist = [0, 1, 2].map(|column| match self.drives {
                    Drives::Twist => self.over_period(column, t_s),
                    _ => 0.0,
                });
                Asked::Twist(Twist::new(twist[0], twist[1], twist[2]))
            }
        }
    }

    /// The mean of a column over the control period that begins at a time in seconds: of a log with
    /// more rows than periods none is left out.
    fn over_period(&self, column: usize, t_s: f64) -> f64 {
        self.driving.mean(column, t_s, t_s + self.control_dt_s)
    }

    /// Writes the wheel rates at a time, in seconds, of wheels that follow the log; `false` if the
    /// log commands something else.
    pub fn rates_alone(&self, t_s: f64, rates_rad_s: &mut [f64]) -> bool {
        let mut angles = vec![0.0; rates_rad_s.len()];
        match self.drives {
            Drives::WheelRates => {}
            Drives::WheelAngles => {
                for (column, wheel) in self.wheels.iter().enumerate() {
                    angles[*wheel] = self.driving.between(t_s, column);
                }
            }
            _ => return false,
        }
        matches!(self.ask(t_s, &angles, rates_rad_s), Asked::Rates)
    }

    /// The real robot's pose at a time, in seconds; `None` if the log has none. In the frame of the
    /// log unless [`Log::measured_is_placed`].
    pub fn measured_at(&self, t_s: f64) -> Option<Pose> {
        let poses = &self.measured.as_ref()?.poses;
        let (first, last) = (poses.times_s.first()?, poses.times_s.last()?);
        let within = t_s >= first - TIME_SLACK_S && t_s <= last + TIME_SLACK_S;
        within.then(|| Pose {
            x_m: poses.between(t_s, 0),
            y_m: poses.between(t_s, 1),
            heading_rad: poses.between(t_s, 2),
        })
    }

    /// Whether the log has the real robot's pose at the start, so that its poses are placed at the
    /// simulated robot's start. Otherwise they are to be placed where the simulated robot is at the
    /// time of the first pose.
    pub fn measured_is_placed(&self) -> bool {
        self.measured
            .as_ref()
            .is_some_and(|measured| measured.is_placed)
    }

    /// Whether it has poses of the real robot.
    pub fn has_measured(&self) -> bool {
        self.measured.is_some()
    }

    /// The fastest wheel rate that the log commands, in rad/s, if it commands rates; `rates`
    /// converts a twist.
    pub fn fastest_rate_rad_s(
        &self,
        rates: impl Fn(Twist, &mut [f64]),
        wheel_count: usize,
    ) -> Option<f64> {
        let largest = |row: &[f64]| row.iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
        match self.drives {
            Drives::WheelTorques | Drives::Path | Drives::Joints => None,
            Drives::WheelRates => Some(largest(&self.driving.values)),
            Drives::WheelAngles => {
                let rows: Vec<(f64, &[f64])> = self.driving.rows().collect();
                let fastest = rows.windows(2).map(|pair| {
                    let dt_s = (pair[1].0 - pair[0].0).max(self.control_dt_s);
                    let turned = pair[0]
                        .1
                        .iter()
                        .zip(pair[1].1)
                        .map(|(a, b)| ((b - a) / dt_s).abs());
                    turned.fold(0.0, f64::max)
                });
                Some(fastest.fold(0.0, f64::max))
            }
            Drives::Twist => {
                let mut wheels = vec![0.0; wheel_count];
                let fastest = self.driving.rows().map(|(_, row)| {
                    rates(Twist::new(row[0], row[1], row[2]), &mut wheels);
                    largest(&wheels)
                });
                Some(fastest.fold(0.0, f64::max))
            }
        }
    }
}
