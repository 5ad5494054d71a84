//! `ilon inspect --limits`: how hard the robot may be driven.

use ilon_files::FileAccess;
use ilon_robot::Robot;

use super::options::Settings;
use super::table::Table;
use crate::Error;
use crate::inspect::Inspection;
use crate::scenario::Scenario;
use crate::simulate::{Limit, LimitRow, Limits};

/// Which limits are asked for.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct Asked {
    /// How hard the robot may be driven: the accelerations at which no wheel slides and no motor lacks torque, by direction, at rest
    /// and at speed, with the wheel that gives out first and why.
    #[arg(long, conflicts_with = "html", help_heading = "Limits")]
    pub limits: bool,
    #[command(flatten)]
    conditions: Conditions,
}

/// Keys of a scenario that say under what.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Limits")]
struct Conditions {
    #[command(flatten)]
    settings: Settings,
}

/// A scenario in which a robot does nothing.
const STANDING: &str = "robot.file = \"\"\ntwist = {}\nrun.duration_s = 1.0\n";

impl Asked {
    /// The inspection with the limits, where they are asked for: under a scenario that the settings make of one in which the robot stands.
    ///
    /// # Errors
    /// A key that no scenario has, and conditions that make no sense.
    pub fn add_to(
        &self,
        inspection: Inspection,
        robot: &Robot,
        files: &FileAccess,
    ) -> Result<Inspection, Error> {
        if !self.limits {
            return Ok(inspection);
        }
        let settings = &self.conditions.settings.settings;
        let scenario = Scenario::from_toml_with(STANDING, "the conditions", "", settings, files)?;
        scenario.validate()?;
        let mut robot = robot.clone();
        scenario.motors.apply(&mut robot);
        scenario.rollers.apply(&mut robot)?;
        inspection.with_limits(&scenario, &robot)
    }

    /// Whether there are settings that nothing asks for.
    pub fn are_idle(&self) -> bool {
        !self.limits && !self.conditions.settings.settings.is_empty()
    }
}

/// The limits in words.
pub(super) fn text(name: &str, limits: &Limits) -> String {
    let slope = match limits.slope_deg == 0.0 {
        true => "on level ground".to_owned(),
        false => format!(
            "on a slope of {} deg that falls at {} deg from where the robot looks",
            limits.slope_deg, limits.downhill_deg
        ),
    };
    let sharing = match limits.sharing {
        "by_grip" => "the wheels share pushes by grip",
        _ => "each wheel's loop by itself",
    };
    let mut table = Table::new();
    table.heading(&format!(
        "{name}: accelerations without slip, friction {}, {slope}, {sharing}: speed in m/s, speeding up and slowing down in m/s^2; \
         turns in rad/s and rad/s^2",
        limits.friction
    ));
    let words = |words: [&str; 7]| words.map(str::to_owned);
    table.words(
        "",
        &words(["speed", "up", "by", "wheel", "down", "by", "wheel"]),
    );
    for row in &limits.rows {
        table.words(&row.motion, &cells(row));
    }
    let mut text = table.to_string();
    if !limits.left_out.is_empty() {
        text.push_str(&format!("\nleft out: {}\n", limits.left_out.join(", ")));
    }
    text
}

fn cells(row: &LimitRow) -> Vec<String> {
    let of = |limit: &Limit| {
        [
            format!("{:.3}", limit.largest),
            limit.cause.to_owned(),
            limit.wheel.clone(),
        ]
    };
    let speed = [format!("{:.2}", row.speed)];
    let (up, down) = (of(&row.speeding_up), of(&row.slowing_down));
    speed.into_iter().chain(up).chain(down).collect()
}
