//! `ilon inspect --limits`: the speeds and accelerations that the robot can reach.

use std::path::PathBuf;

use clap::builder::ArgPredicate;
use ilon_files::FileAccess;
use ilon_robot::Robot;
use serde_json::Value;

use super::failure::Failure;
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
    /// How hard the robot may be driven: accelerations without sliding or missing torque, by
    /// direction and speed, with the limiting wheel and the reason. `--svg` and `--html` draw them.
    #[arg(long, help_heading = "Limits", default_value_ifs = NEED_LIMITS.map(|needs| (needs, ArgPredicate::IsPresent, "true")))]
    pub limits: bool,
    #[command(flatten)]
    conditions: Conditions,
}

/// Options without meaning unless limits are requested.
const NEED_LIMITS: [&str; 5] = [
    "pathplanner",
    "choreo",
    "road_runner",
    "pedro",
    "identified",
];

/// Keys of a scenario that say under what.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Limits")]
struct Conditions {
    #[command(flatten)]
    settings: Settings,
    /// `identified.json` of `ilon identify`: fitted keys become conditions, and `--road-runner`
    /// uses the sideways factor. `--set` overrides.
    #[arg(long, value_name = "FILE")]
    identified: Option<PathBuf>,
}

/// Largest file of identification results, in bytes; chosen.
const MAX_BYTES: u64 = 64 << 20;

impl Conditions {
    /// The identification results; `Null` if no file is named.
    fn identified(&self, files: &FileAccess) -> Result<Value, Error> {
        let Some(path) = &self.identified else {
            return Ok(Value::Null);
        };
        let text = files.read_text(path, MAX_BYTES);
        let text = text.map_err(|fault| Error::read(path, &fault))?;
        let found: Option<Value> = serde_json::from_str(&text).ok();
        found
            .filter(|found| found["parameters"].is_object())
            .ok_or_else(|| {
                Error::invalid(
                    format!("`{}` is no `identified.json`", path.display()),
                    "name the file that `ilon identify` wrote into its folder of results",
                )
            })
    }

    /// The fitted keys of a scenario, then the settings that override them.
    fn settings(&self, files: &FileAccess) -> Result<Vec<Setting>, Error> {
        /// Tables of a scenario that describe the driving conditions.
        const TABLES: [&str; 3] = ["world.", "rollers.", "motors."];
        let found = self.identified(files)?;
        let fitted = found["parameters"].as_object().into_iter().flatten();
        let of_scenario =
            fitted.filter(|(key, _)| TABLES.iter().any(|table| key.starts_with(table)));
        let settings = of_scenario.filter_map(|(key, found)| {
            let value = found["value"].as_f64()?;
            Some(Setting::new(key, &toml::Value::from(value)))
        });
        Ok(settings
            .chain(self.settings.settings.iter().cloned())
            .collect())
    }
}

impl Asked {
    /// The changed keys as a shell takes them, each behind a space.
    pub fn settings_in_words(&self) -> String {
        self.conditions.settings.words()
    }

    /// Adds the limits to an inspection, if they are requested. The conditions are a scenario of a
    /// standing robot, changed by the settings.
    ///
    /// # Errors
    /// If a key is unknown or a condition is invalid.
    pub fn add_to(
        &self,
        inspection: Inspection,
        robot: &Robot,
        files: &FileAccess,
    ) -> Result<Inspection, Error> {
        if !self.limits {
            return Ok(inspection);
        }
        inspection.with_limits_under(&self.conditions.settings(files)?, robot, files)
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
        conditions(&self.conditions.settings(files)?, robot, files)
    }

    /// The identified ratio of sideways to forward distance, if there is one.
    ///
    /// # Errors
    /// If the file does not contain it.
    pub fn sideways_over_ahead(&self, files: &FileAccess) -> Result<Option<f64>, Error> {
        let found = self.conditions.identified(files)?;
        Ok(found["gains"]["sideways_over_ahead"]["value"].as_f64())
    }

    /// The conditions as a scenario with a standing robot.
    ///
    /// # Errors
    /// As [`Self::add_to`].
    pub fn scenario(&self, files: &FileAccess) -> Result<Scenario, Error> {
        standing(&self.conditions.settings.settings, files)
    }

    /// Whether there are settings without effect: without limits, only those of the robot's joints
    /// matter.
    pub fn are_idle(&self) -> bool {
        let settings = &self.conditions.settings.settings;
        let is_of_joint = |setting: &Setting| setting.key().starts_with("robot.joints.");
        !self.limits && !settings.iter().all(is_of_joint)
    }
}

/// Checks that there are accelerations for planners; a planner given zeros would not move.
///
/// # Errors
/// If some direction has none.
pub(super) fn must_give(limits: &Limits, flag: &str) -> Result<(), Failure> {
    if !limits.acceleration_box.contains(&0.0) {
        return Ok(());
    }
    let why = match limits.remarks.as_slice() {
        [] => String::new(),
        remarks => format!(": {}", remarks.join("; ")),
    };
    Err(Failure::usage(
        format!("there is no acceleration to give to planners{why}"),
        format!(
            "leave {flag} out, or set conditions under which the robot can speed up in all directions"
        ),
    ))
}

/// The limits as text.
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
        _ => "independent wheel loops",
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
    let mut text = String::new();
    for remark in &limits.remarks {
        text.push_str(&format!("{remark}\n\n"));
    }
    text.push_str(&table.to_string());
    if !limits.left_out.is_empty() {
        text.push_str(&format!("\nleft out: {}\n", limits.left_out.join(", ")));
    }
    text
}
