//! One way to simulate a robot: its error, drive by drive, and its speed.

use std::collections::BTreeMap;

use super::figures::{BenchDrive, Configuration, DRIVES, Heading};
use ilon_robot::{Robot, Twist};
use ilon_trace::Summary;
use rayon::prelude::*;

use super::options::ContactMode;
use super::scenario::scenario;
use crate::Error;
use crate::scenario::Scenario;
use crate::simulate::{CpuTime, Simulation};

/// Simulated time before timing starts, in seconds: the ramp and half a second at the held twist.
const WARM_UP_S: f64 = 1.0;
/// Least CPU time of a timed stretch, in seconds; chosen as thousands of ticks of the CPU clock.
const STRETCH_CPU_S: f64 = 0.02;
/// Least CPU time of all drives of a configuration in one round, in seconds. Short stretches are
/// repeated until it is reached, so that at least one of them runs undisturbed; chosen.
const ROUND_CPU_S: f64 = 0.3;
/// The longest stretch, in simulated seconds; chosen.
const LONGEST_STRETCH_S: f64 = 100.0;

/// The accuracy of a configuration, measured before its speed.
pub(super) struct Accuracy {
    kind: ContactMode,
    rate_hz: f64,
    /// The result at each heading, with its drive's name.
    outcomes: Vec<(&'static str, Heading)>,
}

impl Accuracy {
    /// Simulates all drives at all headings, on all threads: other load on the machine does not
    /// change accuracy.
    pub fn measure(
        robot: &Robot,
        (kind, rate_hz): (ContactMode, f64),
        bandwidth_rad_s: Option<f64>,
        headings_deg: &[f64],
    ) -> Result<Self, Error> {
        let tasks: Vec<_> = DRIVES
            .iter()
            .flat_map(|(name, twist)| headings_deg.iter().map(move |deg| (*name, *twist, *deg)))
            .collect();
        let outcomes = tasks
            .into_par_iter()
            .map(|(name, twist, heading_deg)| {
                let scenario = scenario(twist, heading_deg, kind, rate_hz, bandwidth_rad_s)?;
                let run = Simulation::with_robot(&scenario, robot)?.run();
                Ok((name, heading(&run.summary, twist, heading_deg)))
            })
            .collect::<Result<_, Error>>()?;
        Ok(Self {
            kind,
            rate_hz,
            outcomes,
        })
    }
}

/// Combines the accuracy and the speed of a configuration.
pub(super) fn configuration(accuracy: Accuracy, timing: Timing) -> Configuration {
    let Accuracy {
        kind,
        rate_hz,
        outcomes,
    } = accuracy;
    let speeds: Vec<Option<Speed>> = timing.drives.into_iter().map(HeldRun::speed).collect();
    let drives = DRIVES.iter().zip(&speeds).map(|((name, _), speed)| {
        let headings = outcomes.iter().filter(|(of, _)| of == name);
        let headings = headings.map(|(_, heading)| heading.clone()).collect();
        let cpu_s = speed.as_ref().map(|speed| speed.cpu_s_per_sim_s);
        ((*name).to_owned(), drive(headings, cpu_s))
    });
    let drives: BTreeMap<_, _> = drives.collect();
    let headings = || drives.values().flat_map(|drive| &drive.headings);
    let largest = |of: fn(&Heading) -> Option<f64>| headings().filter_map(of).reduce(f64::max);
    let cpu_s = speeds
        .iter()
        .map(|speed| Some(speed.as_ref()?.cpu_s_per_sim_s))
        .sum::<Option<f64>>();
    let speed = cpu_s.map(|cpu_s| DRIVES.len() as f64 / cpu_s);
    let spreads = speeds.iter().flatten().map(|speed| speed.spread_pct);
    Configuration {
        roller_bodies: kind.word().to_owned(),
        physics_dt_s: 1.0 / rate_hz,
        worst_error_pct: largest(|h| Some(h.error_pct)).unwrap_or(f64::NAN),
        hub_ripple_m: largest(|h| h.hub_ripple_m),
        slip_speed_rms_m_s: largest(|h| h.slip_speed_rms_m_s),
        rate_shortfall_pct: largest(|h| Some(h.rate_shortfall_pct)).unwrap_or(f64::NAN),
        sim_s_per_cpu_s: speed,
        steps_per_cpu_s: speed.map(|speed| speed * rate_hz),
        speed_spread_pct: spreads.reduce(f64::max),
        drives,
    }
}

fn drive(headings: Vec<Heading>, cpu_s_per_sim_s: Option<f64>) -> BenchDrive {
    let worst = headings
        .iter()
        .max_by(|a, b| a.error_pct.total_cmp(&b.error_pct));
    BenchDrive {
        error_pct: worst.map_or(f64::NAN, |h| h.error_pct),
        ratio_ideal: worst.map_or(f64::NAN, |h| h.ratio_ideal),
        hub_ripple_m: headings
            .iter()
            .filter_map(|h| h.hub_ripple_m)
            .reduce(f64::max),
        sim_s_per_cpu_s: cpu_s_per_sim_s.map(|cpu_s| 1.0 / cpu_s),
        headings,
    }
}

fn heading(summary: &Summary, asked: [f64; 3], heading_deg: f64) -> Heading {
    let (contact, ideal) = (&summary.twist_ratio_contact, &summary.twist_ratio_ideal);
    let reached = summary.twist_ideal_mean.as_ref().map(|mean: &Twist| {
        let mean = [mean.vx_m_s, mean.vy_m_s, mean.omega_rad_s];
        std::array::from_fn(|i| Some(mean[i] / asked[i]))
    });
    let off_pct = |ratio: f64| 100.0 * (ratio - 1.0).abs();
    Heading {
        heading_deg,
        error_pct: off_pct(worst([contact.vx, contact.vy, contact.omega], asked)),
        ratio_ideal: worst([ideal.vx, ideal.vy, ideal.omega], asked),
        hub_ripple_m: summary.hub_ripple_m,
        slip_speed_rms_m_s: summary.slip_speed_rms_m_s,
        rate_shortfall_pct: off_pct(worst(reached.unwrap_or_default(), asked)),
    }
}

/// Returns the ratio farthest from 1, over the commanded components.
fn worst(ratios: [Option<f64>; 3], asked: [f64; 3]) -> f64 {
    ratios
        .into_iter()
        .zip(asked)
        .filter(|(_, asked)| *asked != 0.0)
        // A commanded component without a ratio did not move, or its velocity diverged.
        .map(|(ratio, _)| ratio.filter(|ratio| ratio.is_finite()).unwrap_or(0.0))
        .max_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs()))
        .unwrap_or(1.0)
}

/// The speed of a drive.
struct Speed {
    /// CPU seconds per simulated second in the best stretch.
    cpu_s_per_sim_s: f64,
    /// How much longer the median stretch took than the best, in per cent.
    spread_pct: f64,
}

/// The drives of a configuration at their held twists, timed in rounds.
pub(super) struct Timing {
    drives: Vec<HeldRun>,
}

impl Timing {
    /// Starts all drives of a robot and warms them up.
    pub fn warmed_up(
        robot: &Robot,
        (kind, rate_hz): (ContactMode, f64),
        bandwidth_rad_s: Option<f64>,
        heading_deg: f64,
    ) -> Result<Self, Error> {
        let drives = DRIVES.iter().map(|(_, twist)| {
            let scenario = held(scenario(
                *twist,
                heading_deg,
                kind,
                rate_hz,
                bandwidth_rad_s,
            )?);
            let simulation = Simulation::with_robot(&scenario, robot)?;
            Ok(HeldRun::warmed_up(simulation, rate_hz))
        });
        Ok(Self {
            drives: drives.collect::<Result<_, Error>>()?,
        })
    }

    /// Times at least one stretch of each drive, and more until the round's CPU time is reached.
    pub fn round(&mut self) {
        let cpu = CpuTime::now();
        loop {
            for drive in &mut self.drives {
                drive.time_a_stretch();
            }
            // Without a CPU clock there is nothing to time.
            if cpu.elapsed_s().is_none_or(|cpu_s| cpu_s >= ROUND_CPU_S) {
                return;
            }
        }
    }
}

/// A drive's scenario for timing: without rest, and with one row of the trace per second.
pub(super) fn held(mut scenario: Scenario) -> Scenario {
    scenario.run.duration_s = WARM_UP_S + LONGEST_STRETCH_S;
    scenario.run.record_every = (1.0 / scenario.run.control_dt_s).round().max(1.0) as u32;
    if let Some(twist) = &mut scenario.twist {
        twist.rest_s = 0.0;
    }
    scenario
}

/// Advances a run by a time, in seconds, at a rate in steps per second.
pub(super) fn advance(simulation: &mut Simulation, time_s: f64, rate_hz: f64) {
    for _ in 0..(time_s * rate_hz).round().max(1.0) as u64 {
        simulation.step();
    }
}

/// A run at its held twist.
struct HeldRun {
    simulation: Simulation,
    rate_hz: f64,
    stretch_s: f64,
    cpu_s: Vec<Option<f64>>,
}

impl HeldRun {
    fn warmed_up(mut simulation: Simulation, rate_hz: f64) -> Self {
        advance(&mut simulation, 0.5 * WARM_UP_S, rate_hz);
        let cpu = CpuTime::now();
        advance(&mut simulation, 0.5 * WARM_UP_S, rate_hz);
        let second_cpu_s = cpu.elapsed_s().unwrap_or(0.0) / (0.5 * WARM_UP_S);
        // Whole simulated seconds; one without a CPU clock.
        let stretch_s = if second_cpu_s > 0.0 {
            (STRETCH_CPU_S / second_cpu_s)
                .ceil()
                .clamp(1.0, LONGEST_STRETCH_S)
        } else {
            1.0
        };
        Self {
            simulation,
            rate_hz,
            stretch_s,
            cpu_s: Vec::new(),
        }
    }

    fn time_a_stretch(&mut self) {
        let cpu = CpuTime::now();
        advance(&mut self.simulation, self.stretch_s, self.rate_hz);
        self.cpu_s.push(cpu.elapsed_s());
    }

    fn speed(self) -> Option<Speed> {
        let mut cpu_s: Vec<f64> = self.cpu_s.into_iter().collect::<Option<_>>()?;
        cpu_s.sort_by(f64::total_cmp);
        let (best_s, middle_s) = (*cpu_s.first()?, cpu_s[cpu_s.len() / 2]);
        (best_s > 0.0).then(|| Speed {
            cpu_s_per_sim_s: best_s / self.stretch_s,
            spread_pct: 100.0 * (middle_s / best_s - 1.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_asked_for_counts_and_what_flew_off_is_all_wrong() {
        let diagonal = [0.2, 0.2, 0.0];
        assert_eq!(worst([Some(1.01), Some(0.97), Some(7.0)], diagonal), 0.97);
        assert_eq!(worst([Some(1.0), Some(f64::NAN), None], diagonal), 0.0);
        assert_eq!(worst([Some(1.0), None, None], diagonal), 0.0);
        assert_eq!(worst([Some(1.0); 3], [0.0, 0.0, 1.0]), 1.0);
    }
}
