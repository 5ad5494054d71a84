//! `ilon inspect --limits`: how hard the robot may be driven.

use ilon_files::FileAccess;
use ilon_robot::Robot;

use super::options::Settings;
use super::table::Table;
use crate::inspect::{Inspection, conditions, standing};
use crate::pages::limits::by_motion;
use crate::scenario::Setting;
use crate::simulate::Limits;
use crate::{Error, Scenario};

/// Which limits are asked for.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct Asked {
    /// How hard the robot may be driven: the accelerations at which no wheel slides and no motor lacks torque, by direction, at rest
    /// and at speed, with the wheel that gives out first and why. With `--svg` they are drawn by direction, and `--html` has them too.
    #[arg(long, help_heading = "Limits")]
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
        inspection.with_limits_under(&self.conditions.settings.settings, robot, files)
    }

    /// The conditions as a scenario, and the robot under them.
    ///
    /// # Errors
    /// As [`Self::add_to`].
    pub fn conditions(
        &self,
        robot: &Robot,
        files: &FileAccess,
    ) -> Result<(Scenario, Robot), Error> {
        conditions(&self.conditions.settings.settings, robot, files)
    }

    /// The conditions as a scenario in which some robot stands.
    ///
    /// # Errors
    /// As [`Self::add_to`].
    pub fn scenario(&self, files: &FileAccess) -> Result<Scenario, Error> {
        standing(&self.conditions.settings.settings, files)
    }

    /// Whether there are settings that nothing asks for: without limits, those of the robot's joints alone say something of it.
    pub fn are_idle(&self) -> bool {
        let settings = &self.conditions.settings.settings;
        let is_of_joint = |setting: &Setting| setting.key().starts_with("robot.joints.");
        !self.limits && !settings.iter().all(is_of_joint)
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
    let found = by_motion(limits);
    let mut table = Table::new();
    table.heading(&format!(
        "{name}: accelerations without slip, friction {}, {slope}, {sharing}: {}",
        limits.friction, found.title
    ));
    table.words("", found.head.get(1..).unwrap_or_default());
    for row in &found.rows {
        if let Some((motion, words)) = row.split_first() {
            table.words(motion, words);
        }
    }
    let mut text = table.to_string();
    if !limits.left_out.is_empty() {
        text.push_str(&format!("\nleft out: {}\n", limits.left_out.join(", ")));
    }
    text
}
