//! The share of grip that a path as fast as grip allows takes: the largest at which the simulated robot hardly slides.
//!
//! Statics about the middles of the wheels say in which time a path can be driven within a share of grip and torques. How much slides at that share depends
//! on what statics leave out: rollers touch off the middles of their wheels, wheels strain one another, loops answer to targets that come in steps, springs
//! and joints move. So the plant itself is driven along the path, under the scenario's guidance, and the share is lowered until it hardly slides.

use ilon_robot::{Robot, Twist};

use super::plant::Plant;
use super::resolve::{Driver, Resolved, resolve_as_given};
use crate::Error;
use crate::scenario::{Fault, Scenario, Sensors};

/// Of the motors' positive work, the share that may be lost to sliding.
const MAY_SLIDE: f64 = 0.005;

/// Of what a run loses, what a trial shows at least: a trial begins on the path and ends after two laps, and the run comes to the path from where it
/// stands.
const OF_A_TRIAL: f64 = 0.9;

/// Makes every choice that a scenario leaves to the program, for a robot under the scenario's own guidance.
///
/// It reads the files of waypoints, of a log and of a height map that the scenario names, and touches nothing else.
///
/// # Errors
/// Where the scenario asks for something that cannot be, or this robot cannot do.
pub fn resolve(scenario: &Scenario, robot: &Robot) -> Result<Resolved, Error> {
    resolve_for(scenario, robot, Driver::Guidance)
}

/// Like [`resolve`], for any driver.
///
/// # Errors
/// Like [`resolve`].
pub fn resolve_for(scenario: &Scenario, robot: &Robot, driver: Driver) -> Result<Resolved, Error> {
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
        let slid = share_slid(&resolve_as_given(&given, robot, Driver::Guidance)?, robot)?;
        Ok(slid / OF_A_TRIAL)
    })?;
    let mut resolved = resolve_as_given(&with_share(scenario, found.share), robot, driver)?;
    if let Some(remark) = found.remark(most) {
        resolved.remark_first(remark);
    }
    Ok(resolved)
}

/// The scenario as far as it is known when the path is timed: nothing goes wrong, nothing is measured wrongly, and payloads are those of the beginning.
fn as_planned(scenario: &Scenario) -> Scenario {
    let mut planned = scenario.clone();
    planned
        .faults
        .retain(|fault| matches!(fault, Fault::Payload { .. }) && fault.is_on(0.0));
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

/// A share of grip and torques, and what the robot loses at it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Found {
    share: f64,
    /// To sliding, of the motors' positive work.
    slid: f64,
}

impl Found {
    /// It in words, where the path may take more than it takes.
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

/// The largest share of grip and torques at which no more slides than may, up to `most`; where there is none, the share at which least slides. A lap takes
/// about as long as one over the root of the share: it is found to within 3 %.
///
/// What slides grows as some power of the share, from 1 of robots whose wheels strain one another to 20 of those that slide for being driven hard.
fn largest_share(
    most: f64,
    mut slid_at: impl FnMut(f64) -> Result<f64, Error>,
) -> Result<Found, Error> {
    /// The power where it is not known yet, and the range in which it is believed.
    const POWER: f64 = 5.0;
    const POWERS: [f64; 2] = [0.7, 20.0];
    /// Of what may slide, what is aimed at: at first, and once two drives have shown the power.
    const AIM: f64 = 0.8;
    const AIM_ON: f64 = 0.97;
    /// Of the share: shares that differ by less are the same.
    const SAME: f64 = 0.05;
    const MOST_RUNS: usize = 8;
    /// Of what the path may take. What slides at less does not slide for being driven hard.
    const LEAST: f64 = 0.02;

    let mut beyond = Found {
        share: most,
        slid: slid_at(most)?,
    };
    if beyond.slid <= MAY_SLIDE {
        return Ok(beyond);
    }
    let (mut within, mut gentlest) = (None::<Found>, beyond);
    let (mut power, mut aim) = (POWER, AIM);
    for _ in 1..MOST_RUNS {
        let guess = beyond.share * libm::pow(aim * MAY_SLIDE / beyond.slid, 1.0 / power);
        let least = within.map_or(LEAST * most, |found| found.share * (1.0 + 0.5 * SAME));
        let share = guess.max(least).min(beyond.share / (1.0 + 0.5 * SAME));
        aim = AIM_ON;
        // A share may be too small to hold the robot on its slope.
        let Ok(slid) = slid_at(share) else {
            break;
        };
        let now = Found { share, slid };
        let before = within.unwrap_or(beyond);
        let found = libm::log(now.slid / before.slid) / libm::log(now.share / before.share);
        if found.is_finite() {
            power = found.clamp(POWERS[0], POWERS[1]);
        }
        if slid < gentlest.slid {
            gentlest = now;
        }
        match slid <= MAY_SLIDE {
            true => within = Some(now),
            false => beyond = now,
        }
        let Some(within) = within else {
            if share <= LEAST * most {
                break;
            }
            continue;
        };
        let room = libm::pow(MAY_SLIDE / within.slid, 1.0 / power);
        if room.min(beyond.share / within.share) < 1.0 + SAME {
            break;
        }
    }
    Ok(within.unwrap_or(gentlest))
}

/// Of the motors' positive work, the share that a robot loses to sliding on the path of a scenario.
///
/// Of a path that repeats laps two are driven, of which the second stands for all that follow. Where far too much slides it ends early.
fn share_slid(resolved: &Resolved, robot: &Robot) -> Result<f64, Error> {
    /// Of the whole, what is driven at least; and what slides then, over what may, where the rest does not matter.
    const AT_LEAST: f64 = 0.25;
    const FAR_TOO_MUCH: f64 = 4.0;
    let Some(reference) = resolved.reference() else {
        return Ok(0.0);
    };
    let duration_s = resolved.scenario().run.duration_s;
    let period_s = resolved.control_dt_s();
    let new_until_s = reference.nothing_new_from_s().unwrap_or(duration_s);
    let until_s = new_until_s.min(duration_s);
    let mut plant = Plant::new(resolved, robot)?;
    let begin = reference.at(0.0).pose;
    let point_m = resolved.reference_point_m();
    plant.reset(
        resolved.scenario().sensors.seed,
        begin.moved(Twist::new(-point_m.x, -point_m.y, 0.0)),
    )?;
    let mut pilot = resolved.pilot(robot, None)?;
    let so_far = |plant: &Plant| {
        let world = plant.world();
        (world.slip_energy_j(), world.motor_positive_energy_j())
    };
    let mut half = (0.0, 0.0);
    while plant.time_s() < until_s - 0.5 * period_s {
        let t_s = plant.time_s();
        pilot.decide(t_s, plant.observe());
        plant.advance(pilot.command(), period_s)?;
        let (slid_j, work_j) = so_far(&plant);
        if t_s < 0.5 * until_s {
            half = (slid_j, work_j);
        }
        if t_s > AT_LEAST * until_s && slid_j > FAR_TOO_MUCH * MAY_SLIDE * work_j {
            return Ok(slid_j / work_j);
        }
    }
    let (slid_j, work_j) = so_far(&plant);
    let after = reference.at(new_until_s + period_s).velocity_in_world;
    let goes_on = after.linear_m_s().norm() + after.omega_rad_s.abs() > 0.0;
    let laps = match goes_on {
        true => 2.0 * (duration_s / until_s - 1.0),
        false => 0.0,
    };
    let whole = |all: f64, first: f64| all + laps * (all - first);
    let (slid_j, work_j) = (whole(slid_j, half.0), whole(work_j, half.1));
    match work_j > 0.0 {
        true => Ok(slid_j / work_j),
        false => Ok(0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever power of the share slides, and wherever it is what may: the share that is found slides no more, and is within 5 % of the largest. Three drives
    /// show the power and hit it.
    #[test]
    fn the_largest_share_is_found_in_few_drives() {
        for power in [0.75, 1.5, 3.0, 6.0, 12.0, 20.0] {
            for largest in [0.03, 0.1, 0.3, 0.6, 0.85] {
                let mut drives = 0;
                let found = largest_share(0.9, |share| {
                    drives += 1;
                    Ok(MAY_SLIDE * libm::pow(share / largest, power))
                })
                .expect("it is driven");
                let of_largest = found.share / largest;
                assert!(found.slid <= MAY_SLIDE, "{power} {largest}: {found:?}");
                assert!(of_largest > 0.95, "{power} {largest}: {of_largest}");
                assert!(drives <= 3, "{power} {largest}: {drives}");
            }
        }
    }

    /// Where nothing slides all is taken at once; where as much slides at any share, or a share does not hold the robot on its slope, the least that slides is
    /// taken, and said.
    #[test]
    fn what_no_share_avoids_is_said() {
        let none = largest_share(0.9, |_| Ok(0.0)).expect("it is driven");
        assert_eq!((none.share, none.remark(0.9)), (0.9, None));
        let always = largest_share(0.9, |share| Ok(0.02 - 0.01 * share)).expect("it is driven");
        assert_eq!(always.share, 0.9);
        let said = always.remark(0.9).expect("a remark");
        assert!(said.contains("1.1 % of the motors' work"), "{said}");
        let steep = largest_share(0.9, |share| match share > 0.5 {
            true => Ok(0.02 * share),
            false => Err(Error::invalid("too steep", "level it")),
        });
        let steep = steep.expect("nine tenths hold it");
        assert!(steep.share > 0.5 && steep.slid > MAY_SLIDE, "{steep:?}");
        assert!(largest_share(0.9, |_| Err(Error::invalid("it falls over", "widen it"))).is_err());
    }
}
