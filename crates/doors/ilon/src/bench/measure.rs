//! Runs all parts of the measurement.

use std::collections::BTreeMap;

use super::configuration::{Accuracy, Timing, configuration};
use super::figures::{Bench, Configuration, RobotBench, describe};
use super::machine::this_machine;
use super::options::{ContactMode, Options};
use crate::Error;
use crate::world::WorldError;

/// Largest error of a configuration that may be the headline, in per cent; chosen.
const HEADLINE_ERROR_PCT: f64 = 0.1;

/// Runs the whole measurement; `tell` receives the name of each part before it starts. Contacts
/// solved by rapier are left out, with a remark, if they do not support a property of the robot and
/// other configurations remain.
///
/// # Errors
/// If the robot cannot drive: no rollers, a direction of motion that the wheels do not control, or
/// a step that its scenario refuses.
pub fn measure(options: &Options, mut tell: impl FnMut(&str)) -> Result<Bench, Error> {
    let heading_deg = options.headings_deg.first().copied().unwrap_or(0.0);
    let bandwidth_rad_s = options.bandwidth_rad_s;
    let mut measured = Vec::new();
    let kinds = || options.configurations.iter().map(|(kind, _)| *kind);
    let by_rapier_alone = kinds().all(|kind| kind == ContactMode::Rapier);
    let mut left_out: BTreeMap<&str, String> = BTreeMap::new();
    for (name, robot) in &options.robots {
        for (kind, rate_hz) in &options.configurations {
            if *kind == ContactMode::Rapier && left_out.contains_key(name.as_str()) {
                continue;
            }
            tell(&format!("{name}: {}", describe(kind.word(), *rate_hz)));
            let headings_deg = &options.headings_deg;
            let accuracy =
                Accuracy::measure(robot, (*kind, *rate_hz), bandwidth_rad_s, headings_deg);
            let accuracy = match accuracy {
                Err(Error::World(fault @ WorldError::NotInRapier { .. })) if !by_rapier_alone => {
                    let remark = format!("contacts by rapier are left out: {fault}");
                    tell(&format!("{name}: {remark}"));
                    left_out.insert(name, remark);
                    continue;
                }
                measured => measured?,
            };
            let timing = Timing::warmed_up(robot, (*kind, *rate_hz), bandwidth_rad_s, heading_deg)?;
            measured.push((name, accuracy, timing));
        }
    }
    // All configurations in turn, so that a temporary load on the machine does not affect every
    // stretch of one.
    for round in 1..=options.rounds {
        tell(&format!("timing, round {round} of {}", options.rounds));
        for (_, _, timing) in &mut measured {
            timing.round();
        }
    }
    let mut configurations: BTreeMap<String, Vec<Configuration>> = BTreeMap::new();
    for (name, accuracy, timing) in measured {
        let of = configurations.entry(name.clone()).or_default();
        of.push(configuration(accuracy, timing));
    }
    let robots = configurations.into_iter();
    let robots = robots.map(|(name, all)| {
        let remarks = left_out.remove(name.as_str()).into_iter().collect();
        (
            name,
            RobotBench {
                remarks,
                ..of_robot(all)
            },
        )
    });
    Ok(Bench {
        machine: this_machine(),
        headings_deg: options.headings_deg.clone(),
        robots: robots.collect(),
    })
}

fn of_robot(configurations: Vec<Configuration>) -> RobotBench {
    let speed = |c: &Configuration| c.sim_s_per_cpu_s.unwrap_or(0.0);
    // A curve that dips at one step is no more accurate there: all shorter steps count too.
    let worst_pct = |of: &Configuration| {
        let shorter = configurations
            .iter()
            .filter(|c| c.roller_bodies == of.roller_bodies && c.physics_dt_s <= of.physics_dt_s);
        shorter.map(|c| c.worst_error_pct).fold(0.0, f64::max)
    };
    let within = configurations
        .iter()
        .filter(|c| worst_pct(c) <= HEADLINE_ERROR_PCT)
        .filter(|c| c.roller_bodies != ContactMode::Rapier.word())
        .max_by(|a, b| speed(a).total_cmp(&speed(b)));
    let most_accurate = || {
        configurations
            .iter()
            .min_by(|a, b| a.worst_error_pct.total_cmp(&b.worst_error_pct))
    };
    let headline = within.or_else(most_accurate);
    RobotBench {
        worst_error_pct: headline.map_or(f64::NAN, worst_pct),
        steps_per_cpu_s: headline.and_then(|c| c.steps_per_cpu_s),
        sim_s_per_cpu_s: headline.and_then(|c| c.sim_s_per_cpu_s),
        headline: headline.map(Configuration::describe).unwrap_or_default(),
        drives: headline.map(|c| c.drives.clone()).unwrap_or_default(),
        configurations,
        remarks: Vec::new(),
    }
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
        let bench = of_robot(vec![slow.clone(), fast_but_wrong.clone(), right]);
        assert_eq!(
            (bench.worst_error_pct, bench.sim_s_per_cpu_s),
            (0.09, Some(90.0))
        );
        assert_eq!(bench.headline, "near rollers, 100 steps a second");
        let none_within = configuration(50.0, 0.2, 400.0);
        let bench = of_robot(vec![fast_but_wrong, none_within]);
        // 3 % at ten steps a second does not count at fifty.
        assert_eq!(bench.worst_error_pct, 0.2);
        let dips = configuration(20.0, 0.03, 800.0);
        let [steep, right] = [
            configuration(60.0, 0.19, 400.0),
            configuration(240.0, 0.03, 200.0),
        ];
        let bench = of_robot(vec![right, steep, dips]);
        assert_eq!(bench.headline, "near rollers, 240 steps a second");
    }
}
