//! Many robots in one process, on one thread and on several.

use std::sync::Barrier;
use std::time::Instant;

use ilon_report::bench::{DRIVES, FLEET_RATE_HZ as RATE_HZ, Throughput};
use ilon_robot::{Pose, Robot, Twist};

use super::options::{ContactMode, Options};
use super::scenario::scenario;
use crate::Error;
use crate::simulate::{CpuTime, Plant, WheelCommand, resolve};

/// Control period, in seconds: each robot advances by it in turn, as in a program that reads all of
/// them once per period.
const PERIOD_S: f64 = 0.05;
/// Simulated time before timing starts, in seconds.
const WARM_UP_S: f64 = 1.0;
/// Length of a timed stretch, in simulated seconds summed over the robots; chosen.
const ROBOT_SECONDS: f64 = 60.0;

/// Measures each number of robots on each number of threads.
pub(super) fn measure(
    name: &str,
    robot: &Robot,
    options: &Options,
    tell: &mut impl FnMut(&str),
) -> Result<Vec<Throughput>, Error> {
    let mut all: Vec<Throughput> = Vec::new();
    for &threads in &options.threads {
        for &robots in &options.fleets {
            tell(&format!("{name}: {robots} robots on {threads} threads"));
            let best = best_of(options.rounds, robot, robots, threads)?;
            all.push(Throughput {
                robot: name.to_owned(),
                robots,
                threads,
                sim_s_per_wall_s: 1.0 / best.wall_s,
                sim_s_per_cpu_s: best.cpu_s.map(|cpu_s| 1.0 / cpu_s),
                cores: best.cpu_s.map(|cpu_s| cpu_s / best.wall_s),
                efficiency: None,
            });
        }
    }
    let alone: Vec<_> = all.iter().filter(|t| t.threads == 1).cloned().collect();
    for of in &mut all {
        let mut alone = alone.iter().filter(|_| of.threads <= of.robots);
        let one = alone.find(|one| one.robots == of.robots);
        of.efficiency =
            one.map(|one| of.sim_s_per_wall_s / one.sim_s_per_wall_s / of.threads as f64);
    }
    Ok(all)
}

/// Time per simulated second of one robot, in seconds.
struct Cost {
    wall_s: f64,
    cpu_s: Option<f64>,
}

/// Start, end and CPU seconds of one thread in one stretch.
type Span = (Instant, Instant, Option<f64>);

/// Returns the best stretch by wall clock. Every thread sets up its share of the robots, and all
/// threads begin each stretch together.
fn best_of(stretches: usize, robot: &Robot, robots: usize, threads: usize) -> Result<Cost, Error> {
    let fleet = Fleet::of(robot)?;
    let barrier = Barrier::new(threads);
    let stretch_s = (ROBOT_SECONDS / robots as f64).max(1.0).round();
    let shares: Vec<Vec<Span>> = std::thread::scope(|scope| {
        let started: Vec<_> = (0..threads)
            .map(|thread| {
                let (barrier, fleet) = (&barrier, &fleet);
                let share = (thread..robots).step_by(threads);
                scope.spawn(move || {
                    let plants = share.map(|index| fleet.robot(index)).collect();
                    fleet.work(plants, stretches, stretch_s, barrier)
                })
            })
            .collect();
        let ended = started.into_iter().map(|thread| match thread.join() {
            Ok(share) => share,
            Err(panic) => std::panic::resume_unwind(panic),
        });
        ended.collect::<Result<_, Error>>()
    })?;
    let sim_s = stretch_s * robots as f64;
    let costs = (0..stretches).map(|index| {
        let of = || shares.iter().map(move |share| share[index]);
        let wall_s = match (of().map(|s| s.0).min(), of().map(|s| s.1).max()) {
            (Some(begin), Some(end)) => end.duration_since(begin).as_secs_f64(),
            _ => f64::INFINITY,
        };
        Cost {
            wall_s: wall_s / sim_s,
            cpu_s: of()
                .map(|s| s.2)
                .sum::<Option<f64>>()
                .map(|cpu_s| cpu_s / sim_s),
        }
    });
    let best = costs.min_by(|a, b| a.wall_s.total_cmp(&b.wall_s));
    best.ok_or_else(|| Error::invalid("no stretch was timed", "time at least one"))
}

/// Copies of one robot that drive sideways.
struct Fleet {
    one: Plant,
    rates_rad_s: Vec<f64>,
}

impl Fleet {
    fn of(robot: &Robot) -> Result<Self, Error> {
        let [vx_m_s, vy_m_s, omega_rad_s] = DRIVES[1].1;
        let scenario = scenario(DRIVES[1].1, 0.0, ContactMode::Near, RATE_HZ, None)?;
        let one = Plant::new(&resolve(&scenario, robot)?, robot)?;
        let mut rates_rad_s = vec![0.0; robot.wheels.len()];
        let twist = Twist::new(vx_m_s, vy_m_s, omega_rad_s);
        one.kinematics().wheel_rates(twist, &mut rates_rad_s);
        Ok(Self { one, rates_rad_s })
    }

    /// Returns a warmed-up robot of the fleet. Each has another heading, so that no two runs are
    /// equal.
    fn robot(&self, index: usize) -> Result<Plant, Error> {
        let mut plant = self.one.clone();
        let heading_rad = ((7 * index % 360) as f64).to_radians();
        let start = Pose {
            heading_rad,
            ..Pose::default()
        };
        plant.reset(index as u64, start)?;
        self.drive(&mut plant, WARM_UP_S)?;
        Ok(plant)
    }

    fn drive(&self, plant: &mut Plant, time_s: f64) -> Result<(), Error> {
        plant.advance(WheelCommand::Rates(&self.rates_rad_s), time_s)?;
        Ok(())
    }

    /// Advances all robots of a thread in turn, one control period at a time.
    fn work(
        &self,
        plants: Result<Vec<Plant>, Error>,
        stretches: usize,
        stretch_s: f64,
        barrier: &Barrier,
    ) -> Result<Vec<Span>, Error> {
        let periods = (stretch_s / PERIOD_S).round() as usize;
        let (mut plants, mut fault) = match plants {
            Ok(plants) => (plants, None),
            Err(fault) => (Vec::new(), Some(fault)),
        };
        let mut done = Vec::with_capacity(stretches);
        for _ in 0..stretches {
            // The other threads wait here, also for a thread without robots.
            barrier.wait();
            let (begin, cpu) = (Instant::now(), CpuTime::now());
            for _ in 0..periods {
                for plant in &mut plants {
                    if let Err(diverged) = self.drive(plant, PERIOD_S) {
                        fault.get_or_insert(diverged);
                    }
                }
            }
            done.push((begin, Instant::now(), cpu.elapsed_s()));
        }
        fault.map_or(Ok(done), Err)
    }
}
