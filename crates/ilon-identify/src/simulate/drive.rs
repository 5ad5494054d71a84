//! One simulated drive.

use ilon_sim::scenario::{Scenario, Setting};
use ilon_sim::simulate::Driver;
use ilon_sim::{Error, Plant, WheelCommand, load_robot, resolve_for};
use nalgebra::Matrix3xX;
use toml::Value as Toml;

use super::free::Free;
use crate::log::Log;
use crate::motion::window;
use crate::study::{Simulate, Study, flat};

/// How long the simulated wheels turn before what they do counts, in seconds.
const SETTLE_S: f64 = 0.7;

/// The way that the simulated robot makes along and across the direction that its wheels ask for, over the way that they ask for by the
/// study's robot; `None` where these values cannot be simulated.
pub(super) fn ways(
    study: &Study,
    section: &Simulate,
    free: &[Free],
    values: &[f64],
    rates: &[f64],
    nominal: &Matrix3xX<f64>,
) -> Result<Option<[f64; 2]>, Error> {
    let mut settings: Vec<Setting> = flat(&study.file.set)
        .iter()
        .map(|(key, value)| Setting::new(key, value))
        .collect();
    for (free, value) in free.iter().zip(values) {
        settings.push(Setting::new(&free.key, &Toml::Float(*value)));
    }
    let text = crate::study::scenario_text(&study.file.robot);
    let scenario = Scenario::from_text(&text, &study.path, &settings, &study.files)?;
    let robot = load_robot(&scenario)?;
    let resolved = resolve_for(&scenario, &robot, Driver::Own)?;
    let mut plant = Plant::new(&resolved, &robot)?;
    let period_s = scenario.run.control_dt_s;
    let rows = (section.drive_s / period_s).ceil().max(2.0) as usize;
    let settle = (SETTLE_S / period_s).ceil() as usize;
    let mut log = Log::default();
    for row in 0..settle + rows {
        match plant.advance(WheelCommand::Rates(rates), period_s) {
            Ok(_) => {}
            Err(Error::Diverged { .. }) => return Ok(None),
            Err(error) => return Err(error),
        }
        if row >= settle {
            let pose = plant.truth().pose;
            log.times_s.push((row - settle) as f64 * period_s);
            log.angles_rad
                .push(plant.observe().wheel_angles_rad.clone());
            log.poses.push([pose.x_m, pose.y_m, pose.heading_rad]);
        }
    }
    for row in 1..log.poses.len() {
        let last = log.poses[row - 1][2];
        log.poses[row][2] = last + ilon_robot::wrap_angle(log.poses[row][2] - last);
    }
    let whole = window(&log, 0, 0, log.len() - 1);
    let asked = whole.of_wheels(nominal);
    let size = libm::hypot(asked[0], asked[1]);
    if size <= 0.0 {
        return Ok(None);
    }
    let seen = whole.seen;
    Ok(Some([
        (seen[0] * asked[0] + seen[1] * asked[1]) / (size * size),
        (seen[1] * asked[0] - seen[0] * asked[1]) / (size * size),
    ]))
}
