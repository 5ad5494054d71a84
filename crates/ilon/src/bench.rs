//! How right and how fast the simulation is: five open-loop drives on two robots, at several steps.
//!
//! What is measured is the whole loop as `ilon run` runs it: wheel loops, world and recording. The error of a drive is
//! the worst deviation of its mean twist from the contact kinematics, over the components that were asked for; speed is
//! simulated time over the CPU time of the thread that simulates.

use std::collections::BTreeMap;
use std::time::Instant;

use ilon_robot::Robot;
use ilon_trace::Summary;
use rayon::prelude::*;
use serde::Serialize;

use crate::scenario::{RollerBodies, Scenario, Step, Twist};
use crate::simulate::Simulation;
use crate::{Error, Run};

/// The drives: forward, lateral, yaw, diagonal, arc; m/s, m/s and rad/s.
const DRIVES: [(&str, [f64; 3]); 5] = [
    ("D1", [0.3, 0.0, 0.0]),
    ("D2", [0.0, 0.3, 0.0]),
    ("D3", [0.0, 0.0, 1.0]),
    ("D4", [0.2, 0.2, 0.0]),
    ("D5", [0.3, 0.0, 0.5]),
];

/// Physics steps a second with every roller a body; finer ones only cost more.
const ALL_RATES_HZ: [f64; 3] = [1000.0, 500.0, 240.0];
/// Physics steps a second in the contact window.
const NEAR_RATES_HZ: [f64; 8] = [1000.0, 500.0, 240.0, 120.0, 60.0, 40.0, 30.0, 20.0];
/// The robots, their files, and the error up to which a configuration counts for the headline, in per cent.
const ROBOTS: [(&str, &str, f64); 2] = [
    (
        "mecanum4",
        include_str!("../../../assets/robots/mecanum4.urdf"),
        0.2,
    ),
    (
        "volksbot",
        include_str!("../../../assets/robots/volksbot.urdf"),
        0.1,
    ),
];

/// Everything that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Bench {
    /// By robot.
    pub robots: BTreeMap<String, RobotBench>,
    /// Many robots in one process.
    pub throughput: Vec<Throughput>,
}

/// What was measured with one robot.
#[derive(Clone, Debug, Serialize)]
pub struct RobotBench {
    /// Worst error of the headline configuration, in per cent: the fastest one within the robot's bound.
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
}

/// One way to simulate a robot.
#[derive(Clone, Debug, Serialize)]
pub struct Configuration {
    /// Which rollers are bodies: `all` or `near`.
    pub roller_bodies: String,
    /// Length of a physics step, in seconds.
    pub physics_dt_s: f64,
    /// The worst error over all drives, in per cent.
    pub worst_error_pct: f64,
    /// The largest ripple of a hub's height over all drives, in metres.
    pub hub_ripple_m: Option<f64>,
    /// The largest sliding speed, rms over a drive, in m/s.
    pub slip_speed_rms_m_s: Option<f64>,
    /// Simulated seconds a CPU second, over all drives.
    pub sim_s_per_cpu_s: Option<f64>,
    /// Physics steps a CPU second, over all drives.
    pub steps_per_cpu_s: Option<f64>,
    /// The drives, by name.
    #[serde(skip)]
    pub drives: BTreeMap<String, Drive>,
}

/// What one drive came to.
#[derive(Clone, Debug, Serialize)]
pub struct Drive {
    /// Worst deviation of a driven component from the contact kinematics, in per cent.
    pub error_pct: f64,
    /// Real over ideal twist, the worst driven component.
    pub ratio_ideal: f64,
    /// Ripple of the hubs' height, in metres.
    pub hub_ripple_m: Option<f64>,
    /// Simulated seconds a CPU second.
    pub sim_s_per_cpu_s: Option<f64>,
}

/// Many independent robots in one process.
#[derive(Clone, Debug, Serialize)]
pub struct Throughput {
    /// How many robots.
    pub robots: usize,
    /// On how many threads.
    pub threads: usize,
    /// Simulated seconds of all robots together a second of wall clock.
    pub sim_s_per_wall_s: f64,
}

impl Bench {
    /// Measures everything and tells of each configuration before it starts.
    ///
    /// # Errors
    /// None of the built-in robots and drives has a fault; an error is one of this program.
    pub fn measure(mut tell: impl FnMut(&str)) -> Result<Self, Error> {
        let mut robots = BTreeMap::new();
        for (name, urdf, bound_pct) in ROBOTS {
            let robot = Robot::from_urdf_str(urdf, name)?;
            let all = ALL_RATES_HZ.map(|hz| (RollerBodies::All, hz));
            let near = NEAR_RATES_HZ.map(|hz| (RollerBodies::Near, hz));
            let mut configurations = Vec::new();
            for (bodies, rate_hz) in all.into_iter().chain(near) {
                let configuration = Configuration::measure(&robot, bodies, rate_hz)?;
                tell(&format!("{name}: {}", configuration.describe()));
                configurations.push(configuration);
            }
            robots.insert(name.to_owned(), RobotBench::of(configurations, bound_pct));
        }
        let robot = Robot::from_urdf_str(ROBOTS[0].1, ROBOTS[0].0)?;
        let mut throughput = Vec::new();
        for threads in [1, 2] {
            for robots in [1, 10, 100] {
                tell(&format!("{robots} robots on {threads} threads"));
                throughput.push(Throughput::measure(&robot, robots, threads)?);
            }
        }
        Ok(Self { robots, throughput })
    }
}

impl RobotBench {
    fn of(configurations: Vec<Configuration>, bound_pct: f64) -> Self {
        let speed = |c: &Configuration| c.sim_s_per_cpu_s.unwrap_or(0.0);
        let within = configurations
            .iter()
            .filter(|c| c.worst_error_pct <= bound_pct)
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
        }
    }
}

impl Configuration {
    fn measure(robot: &Robot, bodies: RollerBodies, rate_hz: f64) -> Result<Self, Error> {
        let mut drives = BTreeMap::new();
        let (mut cpu_s, mut sim_s, mut slip) = (0.0, 0.0, Vec::new());
        for (name, twist) in DRIVES {
            let run = drive(robot, twist, bodies, rate_hz)?;
            sim_s += run.summary.duration_s;
            cpu_s += run
                .summary
                .sim_seconds_per_cpu_second
                .map_or(f64::NAN, |speed| run.summary.duration_s / speed);
            slip.extend(run.summary.slip_speed_rms_m_s);
            drives.insert(name.to_owned(), Drive::of(&run.summary, twist));
        }
        let speed = (cpu_s > 0.0).then(|| sim_s / cpu_s);
        let ripples = drives.values().filter_map(|d| d.hub_ripple_m);
        Ok(Self {
            roller_bodies: match bodies {
                RollerBodies::All => "all".to_owned(),
                RollerBodies::Near => "near".to_owned(),
            },
            physics_dt_s: 1.0 / rate_hz,
            worst_error_pct: drives.values().map(|d| d.error_pct).fold(0.0, f64::max),
            hub_ripple_m: ripples.reduce(f64::max),
            slip_speed_rms_m_s: slip.into_iter().reduce(f64::max),
            sim_s_per_cpu_s: speed,
            steps_per_cpu_s: speed.map(|speed| speed * rate_hz),
            drives,
        })
    }

    /// The configuration in a few words.
    pub fn describe(&self) -> String {
        let rate_hz = 1.0 / self.physics_dt_s;
        format!(
            "{} rollers, {rate_hz:.0} steps a second",
            self.roller_bodies
        )
    }
}

impl Drive {
    fn of(summary: &Summary, twist: [f64; 3]) -> Self {
        let worst = |ratios: [Option<f64>; 3]| {
            ratios
                .into_iter()
                .zip(twist)
                .filter(|(_, asked)| *asked != 0.0)
                // A component that was driven and has no ratio did not move at all.
                .map(|(ratio, _)| ratio.unwrap_or(0.0))
                .max_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs()))
                .unwrap_or(1.0)
        };
        let (contact, ideal) = (&summary.twist_ratio_contact, &summary.twist_ratio_ideal);
        Self {
            error_pct: 100.0 * (worst([contact.vx, contact.vy, contact.omega]) - 1.0).abs(),
            ratio_ideal: worst([ideal.vx, ideal.vy, ideal.omega]),
            hub_ripple_m: summary.hub_ripple_m,
            sim_s_per_cpu_s: summary.sim_seconds_per_cpu_second,
        }
    }
}

impl Throughput {
    fn measure(robot: &Robot, robots: usize, threads: usize) -> Result<Self, Error> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| {
                Error::invalid(error.to_string(), "free some of this machine's threads")
            })?;
        let clock = Instant::now();
        let sim_s: f64 = pool.install(|| {
            (0..robots)
                .into_par_iter()
                .map(|_| {
                    let run = drive(robot, DRIVES[1].1, RollerBodies::Near, 240.0)?;
                    Ok(run.summary.duration_s)
                })
                .sum::<Result<f64, Error>>()
        })?;
        Ok(Self {
            robots,
            threads,
            sim_s_per_wall_s: sim_s / clock.elapsed().as_secs_f64(),
        })
    }
}

/// One drive: 1 s of rest, 0.5 s of ramp, 4 s held, of which the last 3 s are measured.
fn drive(
    robot: &Robot,
    [vx_m_s, vy_m_s, omega_rad_s]: [f64; 3],
    roller_bodies: RollerBodies,
    rate_hz: f64,
) -> Result<Run, Error> {
    const BASE: &str = "[robot]\nfile = \"\"\n[twist]\n[run]\nduration_s = 5.5\n";
    let physics_dt_s = 1.0 / rate_hz;
    let mut scenario = Scenario::from_toml(BASE, "bench", "")?;
    scenario.robot.roller_bodies = roller_bodies;
    scenario.twist = Some(Twist {
        vx_m_s,
        vy_m_s,
        omega_rad_s,
        ..scenario.twist.unwrap_or_default()
    });
    scenario.run.physics_dt_s = Step::Seconds(physics_dt_s);
    // About a hundred records a second, however long the step.
    scenario.run.control_dt_s = physics_dt_s * (0.01 * rate_hz).round().max(1.0);
    Ok(Simulation::with_robot(&scenario, robot)?.run())
}
