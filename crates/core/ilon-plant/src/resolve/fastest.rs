//! The share of grip of a path as fast as grip allows: the largest at which the simulated robot
//! hardly slides.
//!
//! Statics about the middles of the wheels give the time for a path within a share of grip and
//! torques. How much slides at that share depends on effects that statics ignore: rollers touch off
//! the middles of their wheels, wheels strain one another, loops follow targets that come in steps,
//! springs and joints move. So the plant itself is driven along the path, under the scenario's
//! guidance, and the share is lowered until it hardly slides.

use ilon_robot::{Pose, Robot, Twist, wrap_angle};
use ilon_trace::significant;

use crate::limits::share::{Drive, MAY_SLIDE, ShareSearch};
use crate::pilot::Pilot;
use crate::plant::Plant;
use crate::resolve::{Driver, resolve_as_given};
use ilon_scenario::robot::load_robot;
use ilon_scenario::scenario::{Controller, Fault, Scenario, Sensors};
use ilon_scenario::{Error, Resolved};

/// Makes every choice that a scenario leaves to the program, for a robot under the scenario's own
/// guidance.
///
/// It reads the files of waypoints, of a log and of a height map that the scenario names, and no
/// others.
///
/// # Errors
/// If the scenario is impossible, also for this robot.
pub fn resolve(scenario: &Scenario, robot: &Robot) -> Result<Resolved, Error> {
    resolve_for(scenario, robot, Driver::Guidance)
}

/// Like [`resolve`], for any driver.
///
/// # Errors
/// Like [`resolve`].
pub fn resolve_for(scenario: &Scenario, robot: &Robot, driver: Driver) -> Result<Resolved, Error> {
    choose(scenario, robot, driver).map_err(|error| scenario.source.placed(error))
}

fn choose(scenario: &Scenario, robot: &Robot, driver: Driver) -> Result<Resolved, Error> {
    let section = scenario.reference.as_ref();
    let open = section.filter(|it| it.timing.is_some() && it.share_of_grip.is_none());
    let Some(section) = open else {
        return resolve_as_given(scenario, robot, driver);
    };
    scenario.validate()?;
    let most = section.share_of_limits();
    let planned = as_planned(scenario);
    let found = largest_share(most, |share| {
        let given = with_share(&planned, share);
        drive(&resolve_as_given(&given, robot, Driver::Guidance)?, robot)
    })?;
    let mut resolved = resolve_as_given(&with_share(scenario, found.share), robot, driver)?;
    let off = starts_off(&resolved);
    for remark in off.into_iter().chain(found.remark(most)) {
        resolved.remark_first(remark);
    }
    Ok(resolved)
}

/// The pose of the body at which it is on the beginning of its path.
fn beginning(resolved: &Resolved) -> Option<Pose> {
    let point_m = resolved.reference_point_m();
    let from_point = Twist::new(-point_m.x, -point_m.y, 0.0);
    Some(resolved.reference()?.at(0.0).pose.moved(from_point))
}

/// A remark, if the robot does not start where its path begins: the way there is not tried.
fn starts_off(resolved: &Resolved) -> Option<String> {
    /// Nearer starts are on the path, in metres and radians. Chosen.
    const NEAR_M: f64 = 0.01;
    const NEAR_RAD: f64 = 0.05;
    let (start, path) = (resolved.start(), beginning(resolved)?);
    let off_m = libm::hypot(path.x_m - start.x_m, path.y_m - start.y_m);
    let off_rad = wrap_angle(path.heading_rad - start.heading_rad).abs();
    (off_m > NEAR_M || off_rad > NEAR_RAD).then(|| {
        let off_deg = off_rad.to_degrees();
        format!(
            "the robot starts {off_m:.2} m and {off_deg:.0} deg off its path: the way to it was not tried, and may slide. To begin on the path, set `robot.x_m = {}`, `robot.y_m = {}` \
             and `robot.heading_deg = {}`",
            significant(path.x_m, 6),
            significant(path.y_m, 6),
            significant(path.heading_rad.to_degrees(), 6)
        )
    })
}

impl Plant {
    /// The plant of a scenario and its robot, for external commands: [`load_robot`],
    /// [`resolve_for`] and [`Plant::new`] in one.
    ///
    /// # Errors
    /// If the robot's file or the scenario is invalid, or the robot cannot stand at its start.
    pub fn of_scenario(scenario: &Scenario) -> Result<Self, Error> {
        let robot = load_robot(scenario)?;
        Self::new(&resolve_for(scenario, &robot, Driver::Own)?, &robot)
    }
}

/// The scenario for which the path is timed: without faults, measurement errors and false beliefs,
/// with the payloads of the start.
fn as_planned(scenario: &Scenario) -> Scenario {
    let mut planned = scenario.clone();
    planned
        .faults
        .retain(|fault| matches!(fault, Fault::Payload { .. }) && fault.is_on(0.0));
    planned.controller = Controller::default();
    planned.sensors = Sensors {
        imu: planned.sensors.imu,
        ..Sensors::default()
    };
    planned
}

fn with_share(scenario: &Scenario, share: f64) -> Scenario {
    let mut given = scenario.clone();
    if let Some(section) = &mut given.reference {
        section.share_of_grip = Some(share);
    }
    given
}

impl Drive {
    /// A remark, if the path may use more than it does.
    fn remark(&self, most: f64) -> Option<String> {
        let percent = |share: f64| (1e4 * share).round() / 1e2;
        let whole = (1e2 * most).round();
        let taken = match self.share < most {
            true => format!(
                "the path takes {:.0} % of grip and torques, not {whole} %",
                100.0 * self.share
            ),
            false => format!("the path takes {whole} % of grip and torques"),
        };
        if self.slid > MAY_SLIDE {
            return Some(format!(
                "{taken}, and still loses {} % of the motors' work to sliding: more than {} % at any share",
                percent(self.slid),
                percent(MAY_SLIDE)
            ));
        }
        (self.share < most).then(|| {
            format!(
                "{taken}: at more, over {} % of the motors' work would be lost to sliding",
                percent(MAY_SLIDE)
            )
        })
    }
}

/// The largest share of grip and torques, up to `most`, at which no more slides than may: see
/// [`ShareSearch`].
fn largest_share(
    most: f64,
    mut drive: impl FnMut(f64) -> Result<Drive, Error>,
) -> Result<Drive, Error> {
    /// Of `most`: the least share.
    const LEAST: f64 = 0.02;
    const MOST_DRIVES: usize = 16;

    let mut search = ShareSearch::new(most, LEAST * most);
    let first = drive(most)?;
    search.learn(first);
    for _ in 1..MOST_DRIVES {
        let Some(share) = search.next() else {
            break;
        };
        match drive(share) {
            Ok(now) => search.learn(now),
            Err(_) => search.learn_too_little(share),
        }
    }
    Ok(search.found().unwrap_or(first))
}

/// Drives the path of a scenario, from its beginning, for the whole run.
fn drive(resolved: &Resolved, robot: &Robot) -> Result<Drive, Error> {
    let scenario = resolved.scenario();
    let section = scenario.reference.as_ref();
    let mut drive = Drive {
        share: section.and_then(|it| it.share_of_grip).unwrap_or(1.0),
        slid: 0.0,
        takes_s: 0.0,
    };
    let Some(reference) = resolved.reference() else {
        return Ok(drive);
    };
    drive.takes_s = reference.nothing_new_from_s().unwrap_or(0.0);
    let (duration_s, period_s) = (scenario.run.duration_s, resolved.control_dt_s());
    let mut plant = Plant::new(resolved, robot)?;
    if let Some(pose) = beginning(resolved) {
        plant.reset(scenario.sensors.seed, pose)?;
    }
    let mut pilot = Pilot::of(resolved, robot, None)?;
    while plant.time_s() < duration_s - 0.5 * period_s {
        let t_s = plant.time_s();
        pilot.decide(t_s, plant.observe());
        plant.steer(pilot.steering());
        plant.advance(pilot.command(), period_s)?;
    }
    let work_j = plant.world().motor_positive_energy_j();
    if work_j > 0.0 {
        drive.slid = plant.world().slip_energy_j() / work_j;
    }
    Ok(drive)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot whose sliding is a power of the share, with a lap time of one over its root.
    fn slides(share: f64, slid: f64) -> Result<Drive, Error> {
        Ok(Drive {
            share,
            slid,
            takes_s: 1.0 / share.sqrt(),
        })
    }

    /// For any power, and any limit: the found share slides no more than the limit, and its lap is
    /// within 3 % of the shortest, which is 6 % of the share. That takes few drives.
    #[test]
    fn the_largest_share_is_found_in_few_drives() {
        for power in [0.3, 0.75, 1.5, 3.0, 6.0, 12.0, 20.0] {
            for largest in [0.03, 0.1, 0.3, 0.6, 0.85] {
                let mut drives = 0;
                let found = largest_share(0.9, |share| {
                    drives += 1;
                    slides(share, MAY_SLIDE * libm::pow(share / largest, power))
                })
                .expect("it is driven");
                let of_largest = found.share / largest;
                assert!(found.slid <= MAY_SLIDE, "{power} {largest}: {found:?}");
                assert!(of_largest > 0.94, "{power} {largest}: {of_largest}");
                assert!(drives <= 7, "{power} {largest}: {drives}");
            }
        }
    }

    /// Sliding that varies with the share by a tenth, because rollers come down at other places:
    /// the found share slides no more than the limit.
    #[test]
    fn what_ripples_is_found_too() {
        for power in [0.75, 3.0, 12.0] {
            for largest in [0.05, 0.3, 0.8] {
                let slid_at = |share: f64| {
                    let ripple = 1.0 + 0.1 * libm::sin(300.0 * libm::log(share));
                    MAY_SLIDE * libm::pow(share / largest, power) * ripple
                };
                let found = largest_share(0.9, |share| slides(share, slid_at(share)));
                let found = found.expect("it is driven");
                assert!(found.slid <= MAY_SLIDE, "{power} {largest}: {found:?}");
                // A tenth more sliding at a power of 0.75 corresponds to 14 % of the share.
                let least = libm::pow(0.9, 1.0 / power) * 0.94;
                assert!(
                    found.share > least * largest,
                    "{power} {largest}: {found:?}"
                );
            }
        }
    }

    /// If nothing slides, the whole share is used at once; if sliding does not depend on the share,
    /// the share with the least sliding is used and remarked. If a share does not hold the robot on
    /// its slope, one that does is used.
    #[test]
    fn what_no_share_avoids_is_said() {
        let none = largest_share(0.9, |share| slides(share, 0.0)).expect("it is driven");
        assert_eq!((none.share, none.remark(0.9)), (0.9, None));
        let always = largest_share(0.9, |share| slides(share, 0.02 - 0.01 * share));
        let always = always.expect("it is driven");
        assert_eq!(always.share, 0.9);
        let said = always.remark(0.9).expect("a remark");
        assert!(said.contains("1.1 % of the motors' work"), "{said}");
        for (holds_from, slides_less_from) in [(0.5, true), (0.2, false)] {
            let steep = largest_share(0.9, |share| match share > holds_from {
                true => slides(share, 0.02 * share),
                false => Err(Error::invalid("too steep", "level it")),
            });
            let steep = steep.expect("nine tenths hold it");
            assert_eq!(steep.slid > MAY_SLIDE, slides_less_from, "{steep:?}");
            assert!(steep.share > holds_from, "{steep:?}");
        }
        assert!(largest_share(0.9, |_| Err(Error::invalid("it falls over", "widen it"))).is_err());
    }

    #[test]
    fn a_share_that_is_less_than_may_be_taken_is_said_in_percent() {
        let drive = Drive {
            share: 0.8,
            slid: 0.0,
            takes_s: 1.0,
        };
        let said = drive.remark(0.9).expect("less than nine tenths");
        let begins = "the path takes 80 % of grip and torques, not 90 %: at more";
        assert!(said.starts_with(begins), "{said}");
    }
}
