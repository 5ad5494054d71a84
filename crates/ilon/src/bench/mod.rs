//! How right and how fast the simulation is on this machine: five open-loop drives, at several steps and headings.
//!
//! What is measured is the whole loop as `ilon run` runs it: sensors, wheel loops, motors, world and recording.
//!
//! - **Error** of a drive: the worst deviation of its mean twist from the contact kinematics, over the components that
//!   were asked for, in per cent; the worst over the headings. 1 s of rest, 0.5 s of ramp, 4 s held, of which the last 3 s
//!   count.
//! - **Speed**: simulated time over the CPU time of the one thread that simulates, while the twist is held, after a second
//!   of warm-up; the best of several stretches of at least a simulated second each, with a row of the trace a second.
//! - **Treads**: the time of a step on rollers that give over that on rigid ones, timed like speed and in turn.
//! - **Sliding**: drives in which wheels slide, under contacts that ilon solves and under such that rapier does: course, heat,
//!   energy balance, against ilon's own at a quarter of the step.
//! - **Many robots**: simulated time of all together over wall clock, all of them alive in one process and stepped from outside, each
//!   by a control period of 50 ms at a time: sensors, wheel loops, motors and world, without a record.

mod configuration;
mod fleet;
mod machine;
mod transients;
mod tread;

use std::collections::BTreeMap;

use ilon_robot::Robot;
use serde::Serialize;

use crate::Error;
use crate::scenario::{Contacts, RollerBodies, Scenario, Step, Twist};
use crate::world::WorldError;

use configuration::{Accuracy, Timing};
use tread::TreadTiming;

pub use configuration::{Configuration, Drive, Heading};
pub use fleet::{RATE_HZ as FLEET_RATE_HZ, Throughput};
pub use machine::Machine;
pub use transients::{Slide, Transient};
pub use tread::TreadCost;

/// The drives: forward, lateral, yaw, diagonal, arc; m/s, m/s and rad/s.
pub const DRIVES: [(&str, [f64; 3]); 5] = [
    ("D1", [0.3, 0.0, 0.0]),
    ("D2", [0.0, 0.3, 0.0]),
    ("D3", [0.0, 0.0, 1.0]),
    ("D4", [0.2, 0.2, 0.0]),
    ("D5", [0.3, 0.0, 0.5]),
];

/// The robots that are built in, and their files.
pub const ROBOTS: [(&str, &str); 2] = [
    ("mecanum4", include_str!("mecanum4.urdf")),
    ("volksbot", include_str!("volksbot.urdf")),
];

/// Physics steps a second with the shapes of all rollers in the world.
const ALL_RATES_HZ: [f64; 7] = [1000.0, 500.0, 240.0, 120.0, 60.0, 30.0, 20.0];
/// Physics steps a second in the contact window.
const NEAR_RATES_HZ: [f64; 10] = [
    1000.0, 500.0, 240.0, 120.0, 60.0, 40.0, 30.0, 20.0, 15.0, 10.0,
];
/// Physics steps a second with contacts that rapier solves.
const RAPIER_RATES_HZ: [f64; 3] = [1000.0, 500.0, 240.0];
/// The error up to which a configuration may be the headline, in per cent.
const HEADLINE_ERROR_PCT: f64 = 0.1;

/// Which rollers are looked at, and who solves their contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// All of them; ilon.
    All,
    /// Those near the ground; ilon.
    Near,
    /// All of them; rapier itself.
    Rapier,
}

/// What to measure.
#[derive(Clone, Debug)]
pub struct Options {
    /// The robots, each by a name that no other has.
    pub robots: Vec<(String, Robot)>,
    /// Which rollers are looked at, or who solves their contacts, and at how many steps a second (> 0), in the order of
    /// measurement.
    pub configurations: Vec<(Kind, f64)>,
    /// Bandwidth of the wheel loops on the ground, in rad/s; a scenario's own where none is given.
    pub bandwidth_rad_s: Option<f64>,
    /// Headings at which the accuracy is measured, in degrees, at least one; speed is measured at the first.
    pub headings_deg: Vec<f64>,
    /// In how many rounds, at least 1, all configurations are timed: a stretch of each drive or more a round, of which the
    /// best counts.
    pub rounds: usize,
    /// How many robots simulate at once in one process; none to leave that out.
    pub fleets: Vec<usize>,
    /// On how many threads they do so.
    pub threads: Vec<usize>,
}

impl Options {
    /// All that there is to measure, with both built-in robots: some three minutes.
    ///
    /// # Errors
    /// None of the built-in robots has a fault; an error is one of this program.
    pub fn full() -> Result<Self, Error> {
        let all = ALL_RATES_HZ.map(|rate_hz| (Kind::All, rate_hz));
        let near = NEAR_RATES_HZ.map(|rate_hz| (Kind::Near, rate_hz));
        let rapier = RAPIER_RATES_HZ.map(|rate_hz| (Kind::Rapier, rate_hz));
        let robots = ROBOTS.map(|(name, _)| Ok((name.to_owned(), Self::built_in(name)?)));
        Ok(Self {
            robots: robots.into_iter().collect::<Result<_, Error>>()?,
            configurations: all.into_iter().chain(near).chain(rapier).collect(),
            bandwidth_rad_s: None,
            headings_deg: vec![0.0, 20.0],
            rounds: 5,
            fleets: vec![1, 10, 100],
            threads: vec![1, 2],
        })
    }

    /// A first look, in a tenth of the time.
    ///
    /// # Errors
    /// Like [`Self::full`].
    pub fn quick() -> Result<Self, Error> {
        let near = [240.0, 60.0, 20.0].map(|rate_hz| (Kind::Near, rate_hz));
        Ok(Self {
            configurations: [(Kind::All, 240.0)].into_iter().chain(near).collect(),
            headings_deg: vec![20.0],
            rounds: 3,
            fleets: vec![1, 10],
            ..Self::full()?
        })
    }

    /// A built-in robot by its name.
    ///
    /// # Errors
    /// Where there is none of that name.
    pub fn built_in(name: &str) -> Result<Robot, Error> {
        let known = ROBOTS.iter().find(|(known, _)| *known == name);
        let (name, urdf) = known.ok_or_else(|| {
            Error::invalid(
                format!("there is no built-in robot `{name}`"),
                "choose `mecanum4` or `volksbot`, or name a robot's file",
            )
        })?;
        Ok(Robot::from_urdf_str(urdf, name)?)
    }
}

/// Everything that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Bench {
    /// Where, when and with what.
    pub machine: Machine,
    /// The headings at which accuracy was measured, in degrees.
    pub headings_deg: Vec<f64>,
    /// By robot.
    pub robots: BTreeMap<String, RobotBench>,
    /// Many robots in one process.
    pub throughput: Vec<Throughput>,
}

/// What was measured with one robot.
#[derive(Clone, Debug, Serialize)]
pub struct RobotBench {
    /// Worst error of the headline configuration, in per cent: the fastest one that is off by 0.1 % at most, or the most
    /// accurate one where none is.
    pub worst_error_pct: f64,
    /// Physics steps a CPU second of the headline configuration.
    pub steps_per_cpu_s: Option<f64>,
    /// Simulated seconds a CPU second of the headline configuration.
    pub sim_s_per_cpu_s: Option<f64>,
    /// Which configuration that is.
    pub headline: String,
    /// Its drives, by name.
    pub drives: BTreeMap<String, Drive>,
    /// All configurations.
    pub configurations: Vec<Configuration>,
    /// What was left out, and why.
    pub remarks: Vec<String>,
    /// What treads cost; `None` where none was timed.
    pub tread: Option<TreadCost>,
    /// Drives in which wheels slide; empty where rapier's contacts are not among what is measured, or know not all of the robot.
    pub transients: Vec<Transient>,
}

impl Bench {
    /// Measures everything and tells of each part before it starts. Contacts that rapier solves are left out, with a remark, for a robot
    /// that they do not know all of, where there is something else to measure.
    ///
    /// # Errors
    /// Where a robot cannot drive: no rollers, wheels that leave a direction without control, a step it cannot take.
    pub fn measure(options: &Options, mut tell: impl FnMut(&str)) -> Result<Self, Error> {
        let heading_deg = options.headings_deg.first().copied().unwrap_or(0.0);
        let bandwidth_rad_s = options.bandwidth_rad_s;
        let mut measured = Vec::new();
        let kinds = || options.configurations.iter().map(|(kind, _)| *kind);
        let by_rapier_alone = kinds().all(|kind| kind == Kind::Rapier);
        let mut left_out: BTreeMap<&str, String> = BTreeMap::new();
        for (name, robot) in &options.robots {
            for (kind, rate_hz) in &options.configurations {
                if *kind == Kind::Rapier && left_out.contains_key(name.as_str()) {
                    continue;
                }
                tell(&format!("{name}: {}", describe(kind.word(), *rate_hz)));
                let headings_deg = &options.headings_deg;
                let accuracy =
                    Accuracy::measure(robot, (*kind, *rate_hz), bandwidth_rad_s, headings_deg);
                let accuracy = match accuracy {
                    Err(Error::World(fault @ WorldError::NotInRapier { .. }))
                        if !by_rapier_alone =>
                    {
                        let remark = format!("contacts by rapier are left out: {fault}");
                        tell(&format!("{name}: {remark}"));
                        left_out.insert(name, remark);
                        continue;
                    }
                    measured => measured?,
                };
                let timing =
                    Timing::warmed_up(robot, (*kind, *rate_hz), bandwidth_rad_s, heading_deg)?;
                measured.push((name, accuracy, timing));
            }
        }
        let mut transients: BTreeMap<String, Vec<Transient>> = BTreeMap::new();
        if kinds().any(|kind| kind == Kind::Rapier) {
            for (name, robot) in &options.robots {
                if left_out.contains_key(name.as_str()) {
                    continue;
                }
                tell(&format!("{name}: sliding"));
                transients.insert(name.clone(), Transient::measure(robot)?);
            }
        }
        let mut treads: BTreeMap<String, TreadTiming> = BTreeMap::new();
        // Contacts that rapier solves know no tread.
        if !by_rapier_alone {
            for (name, robot) in &options.robots {
                // Rollers with the shapes of their file have none either.
                if let Ok(timing) = TreadTiming::warmed_up(robot, bandwidth_rad_s, heading_deg) {
                    treads.insert(name.clone(), timing);
                }
            }
        }
        // All configurations in turn, so that what else the machine does for a while does not meet all stretches of one.
        for round in 1..=options.rounds {
            tell(&format!("timing, round {round} of {}", options.rounds));
            for (_, _, timing) in &mut measured {
                timing.round();
            }
            treads.values_mut().for_each(TreadTiming::round);
        }
        let mut configurations: BTreeMap<String, Vec<Configuration>> = BTreeMap::new();
        for (name, accuracy, timing) in measured {
            let of = configurations.entry(name.clone()).or_default();
            of.push(Configuration::of(accuracy, timing));
        }
        let robots = configurations.into_iter();
        let robots = robots.map(|(name, all)| {
            let tread = treads.remove(&name).and_then(TreadTiming::cost);
            let transients = transients.remove(&name).unwrap_or_default();
            let remarks = left_out.remove(name.as_str()).into_iter().collect();
            (
                name,
                RobotBench {
                    remarks,
                    tread,
                    transients,
                    ..RobotBench::of(all)
                },
            )
        });
        let robots = robots.collect();
        let throughput = match options.robots.first() {
            Some((name, robot)) => fleet::measure(name, robot, options, &mut tell)?,
            None => Vec::new(),
        };
        Ok(Self {
            machine: Machine::this(),
            headings_deg: options.headings_deg.clone(),
            robots,
            throughput,
        })
    }
}

impl RobotBench {
    fn of(configurations: Vec<Configuration>) -> Self {
        let speed = |c: &Configuration| c.sim_s_per_cpu_s.unwrap_or(0.0);
        let within = configurations
            .iter()
            .filter(|c| c.worst_error_pct <= HEADLINE_ERROR_PCT)
            .filter(|c| c.roller_bodies != Kind::Rapier.word())
            .max_by(|a, b| speed(a).total_cmp(&speed(b)));
        let most_accurate = || {
            configurations
                .iter()
                .min_by(|a, b| a.worst_error_pct.total_cmp(&b.worst_error_pct))
        };
        let headline = within.or_else(most_accurate);
        Self {
            worst_error_pct: headline.map_or(f64::NAN, |c| c.worst_error_pct),
            steps_per_cpu_s: headline.and_then(|c| c.steps_per_cpu_s),
            sim_s_per_cpu_s: headline.and_then(|c| c.sim_s_per_cpu_s),
            headline: headline.map(Configuration::describe).unwrap_or_default(),
            drives: headline.map(|c| c.drives.clone()).unwrap_or_default(),
            configurations,
            remarks: Vec::new(),
            tread: None,
            transients: Vec::new(),
        }
    }
}

/// A configuration in a few words.
fn describe(kind: &str, rate_hz: f64) -> String {
    if kind == Kind::Rapier.word() {
        format!("contacts by rapier, {rate_hz} steps a second")
    } else {
        format!("{kind} rollers, {rate_hz} steps a second")
    }
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::All, Self::Near, Self::Rapier];

    /// The kind in a word, as a scenario writes it.
    pub fn word(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Near => "near",
            Self::Rapier => "rapier",
        }
    }
}

/// The scenario of a drive, at a heading in degrees, with a step in seconds: a second of rest, half a second of ramp, then
/// held to the end. Control is due some hundred times a second, as often as the steps allow.
fn scenario(
    [vx_m_s, vy_m_s, omega_rad_s]: [f64; 3],
    heading_deg: f64,
    kind: Kind,
    rate_hz: f64,
    bandwidth_rad_s: Option<f64>,
) -> Result<Scenario, Error> {
    const BASE: &str = "[robot]\nfile = \"\"\n[twist]\n[run]\nduration_s = 5.5\n";
    let physics_dt_s = 1.0 / rate_hz;
    let mut scenario = Scenario::from_toml(BASE, "bench", "")?;
    scenario.robot.roller_bodies = match kind {
        Kind::All | Kind::Rapier => RollerBodies::All,
        Kind::Near => RollerBodies::Near,
    };
    if kind == Kind::Rapier {
        scenario.world.solver.contacts = Contacts::Rapier;
    }
    scenario.robot.heading_deg = heading_deg;
    if let Some(bandwidth_rad_s) = bandwidth_rad_s {
        scenario.wheel_loop.bandwidth_rad_s = bandwidth_rad_s;
    }
    scenario.twist = Some(Twist {
        vx_m_s,
        vy_m_s,
        omega_rad_s,
        ..scenario.twist.unwrap_or_default()
    });
    scenario.run.physics_dt_s = Step::Seconds(physics_dt_s);
    scenario.run.control_dt_s = physics_dt_s * (0.01 * rate_hz).round().max(1.0);
    Ok(scenario)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn configuration(rate_hz: f64, error_pct: f64, speed: f64) -> Configuration {
        Configuration {
            roller_bodies: "near".to_owned(),
            physics_dt_s: 1.0 / rate_hz,
            worst_error_pct: error_pct,
            hub_ripple_m: None,
            slip_speed_rms_m_s: None,
            rate_shortfall_pct: 0.0,
            sim_s_per_cpu_s: Some(speed),
            steps_per_cpu_s: Some(speed * rate_hz),
            speed_spread_pct: None,
            drives: BTreeMap::new(),
        }
    }

    #[test]
    fn the_headline_is_the_fastest_within_its_bound_or_the_most_accurate() {
        let fast_but_wrong = configuration(10.0, 3.0, 900.0);
        let right = configuration(100.0, 0.09, 90.0);
        let slow = configuration(1000.0, 0.01, 9.0);
        let bench = RobotBench::of(vec![slow.clone(), fast_but_wrong.clone(), right]);
        assert_eq!(
            (bench.worst_error_pct, bench.sim_s_per_cpu_s),
            (0.09, Some(90.0))
        );
        assert_eq!(bench.headline, "near rollers, 100 steps a second");
        let none_within = configuration(50.0, 0.2, 400.0);
        let bench = RobotBench::of(vec![fast_but_wrong, none_within]);
        assert_eq!(bench.worst_error_pct, 0.2);
    }
}
