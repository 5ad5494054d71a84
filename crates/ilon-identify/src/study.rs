//! What a person writes down about an identification: the robot, the logs of its drives, and what is free.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use ilon_robot::{FileAccess, Robot};
use ilon_sim::scenario::{MAX_BYTES, Scenario, Setting, read_toml};
use ilon_sim::{Error, load_robot};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::log::Format;

/// An identification as it stands in its file. Paths are relative to the file.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "IdentifyStudy")]
pub struct StudyFile {
    /// The robot as it is known so far: its description in TOML, or any file that a scenario can name.
    pub robot: PathBuf,
    /// Keys of the scenario in which the robot is simulated, and of `[robot]` where its file needs more to be read.
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: Table,
    /// How the logs are written.
    pub log: Format,
    /// The logs.
    pub runs: Vec<RunFile>,
    /// Over how long a stretch displacements are compared, in seconds.
    #[serde(default = "one")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub window_s: f64,
    /// What of the tracker is not known, beside the parameters of the models: `"x_m"` and `"y_m"` of the point that it follows, in the
    /// body frame, and `"heading_deg"`, by which its heading is ahead of the body's.
    #[serde(default = "tracker")]
    pub tracker: Vec<String>,
    /// Models of the kinematics, each with what is free in it. The one with the least error on what was not fitted is chosen.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub models: Vec<ModelFile>,
    /// Keys of the scenario that are fitted by simulating the runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulate: Option<Simulate>,
    /// Resamples from which intervals are drawn.
    #[serde(default = "resamples")]
    #[schemars(range(min = 50, max = 100_000))]
    pub resamples: u32,
    /// The seed of the resamples.
    #[serde(default)]
    pub seed: u32,
}

/// One log, or a part of one.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunFile {
    /// The file of the log.
    pub file: PathBuf,
    /// Kept back: nothing is fitted to it, and models are judged by it.
    #[serde(default)]
    pub held_out: bool,
    /// Runs of one series share how the tracker saw the robot.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub series: String,
    /// How much of the beginning is left out, in seconds.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub from_s: f64,
    /// Where it ends, in seconds from the log's beginning.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub to_s: Option<f64>,
}

/// A model of the kinematics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelFile {
    /// What it is called.
    pub name: String,
    /// Its parameters: `"radius_m"`, `"radius_m.WHEEL"` or `"radius_m.*"`, `"lever_m"`, `"gamma_deg"`, `"gain.ahead"`, `"gain.sideways"`,
    /// `"gain.turn"`, `"rows_lost"`.
    pub free: Vec<String>,
}

/// What is fitted by simulating.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Simulate {
    /// Keys of the scenario that are free, each from a least to a largest value.
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub free: Table,
    /// How long each steady drive of the logs is simulated, in seconds.
    #[serde(default = "three")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub drive_s: f64,
    /// Whether one common factor on all measured ways is free too: where rows were lost, or the tracker's scale is not known.
    #[serde(default)]
    pub free_scale: bool,
    /// Ways are believed to no better than this, over the way asked for: what changes from run to run, and what no value of the free keys
    /// explains. Where a model misses by more than the logs scatter, an honest figure keeps the few drives that scatter least from
    /// deciding all.
    #[serde(default = "least_error")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub least_error: f64,
    /// From how many wheel angles each drive is simulated, spread evenly over a roller: what depends on the angles from which the
    /// wheels began is then averaged as it is in a log. With 1, wheels begin as the robot's file has them.
    #[serde(default = "once")]
    #[schemars(range(min = 1, max = 1000))]
    pub phases: u32,
    /// What wheels and body do once a roller is compared too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ripple: Option<RippleFile>,
    /// How the drift of the heading is compared; left out, it is shown and not fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heading: Option<HeadingFile>,
    /// How the currents of the log's motors are compared, as torques of the wheels; left out, they are not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub currents: Option<CurrentsFile>,
    /// Other values of keys that are simulated beside what is fitted, without being fitted themselves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beside: Vec<BesideFile>,
    /// Most steps of the search.
    #[serde(default = "twelve")]
    #[schemars(range(min = 1, max = 1000))]
    pub steps: u32,
}

/// How the ripple of a log is compared with that of a simulation: the amplitudes of the wheels' rates and of the body's way at the rate
/// at which rollers pass.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RippleFile {
    /// Over how long a stretch an amplitude is taken, in seconds: some five rollers of the slowest wheel.
    #[serde(default = "three")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stretch_s: f64,
    /// Wheels whose rollers touch in phase, as far as that is known, in groups of their names: where left and right wheels of an axle are in
    /// phase, the body ripples along its way and not across it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub together: Vec<Vec<String>>,
}

/// How the heading's drift is compared: by how much the robot turns beyond what its wheels ask for, over the way that they ask for.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeadingFile {
    /// Whether the free keys are fitted to it too, and not to the ways alone.
    #[serde(default)]
    pub fitted: bool,
    /// It is believed to no better than this, in rad/m.
    #[serde(default = "least_drift")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub least_error_rad_per_m: f64,
}

/// How a motor's current I becomes the torque on its wheel: (k I - f) n, against the motor's own friction f.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurrentsFile {
    /// k: torque of the motor for its current, in N m/A.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub torque_constant_n_m_a: f64,
    /// f: friction of the motor and its gear at the motor, in N m.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub friction_n_m: f64,
    /// n: turns of the motor for a turn of the wheel; left out, what the robot's file says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub gear_ratio: Option<f64>,
    /// Whether the log has the size of the currents alone: the motors are then taken to push as their wheels turn.
    #[serde(default)]
    pub unsigned: bool,
    /// Whether the free keys are fitted to the torques too, and not to the ways alone.
    #[serde(default)]
    pub fitted: bool,
    /// Torques are believed to no better than this, in N m at the wheel.
    #[serde(default = "least_torque")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub least_error_n_m: f64,
}

/// Other values of keys, simulated beside what was fitted.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BesideFile {
    /// What it is called.
    pub name: String,
    /// The keys that are otherwise, of the scenario or of the robot's description below `robot.spec`.
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub set: Table,
}

fn least_drift() -> f64 {
    0.03
}

fn least_torque() -> f64 {
    0.02
}

fn least_error() -> f64 {
    3e-3
}

fn once() -> u32 {
    1
}

fn one() -> f64 {
    1.0
}

fn three() -> f64 {
    3.0
}

fn twelve() -> u32 {
    12
}

fn resamples() -> u32 {
    1000
}

fn tracker() -> Vec<String> {
    ["x_m", "y_m", "heading_deg"].map(str::to_owned).to_vec()
}

/// The longest drive that is simulated, in seconds.
const MOST_DRIVE_S: f64 = 600.0;

/// The most wheel angles from which a drive is simulated.
const MOST_PHASES: u32 = 1000;

/// A study that was read, with the robot that it names.
#[derive(Debug)]
pub struct Study {
    /// Its file.
    pub path: PathBuf,
    /// What stands in it.
    pub file: StudyFile,
    /// The robot as it is known before the fit.
    pub robot: Robot,
    pub(crate) files: FileAccess,
}

impl Study {
    /// Reads a study and its robot.
    ///
    /// # Errors
    /// Where a file cannot be read, or the study asks for what cannot be.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        Self::load_within(path, &FileAccess::anywhere())
    }

    /// Reads a study and its robot; all files must be among those that may be read.
    ///
    /// # Errors
    /// Like [`Self::load`].
    pub fn load_within(path: impl AsRef<Path>, files: &FileAccess) -> Result<Self, Error> {
        let path = path.as_ref();
        let text = files.read_text(path, MAX_BYTES);
        let text = text.map_err(|fault| Error::read(path, &fault))?;
        let file: StudyFile = read_toml(&text, path)?;
        let study = Self {
            path: path.to_owned(),
            robot: robot_of(&file.robot, &file.set, path, files)?,
            file,
            files: files.clone(),
        };
        study.check()?;
        Ok(study)
    }

    /// Its name: that of its file, without the ending.
    pub fn name(&self) -> String {
        let stem = self.path.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }

    /// A path of the study, from its own folder.
    pub fn resolve(&self, path: &Path) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(path)
    }

    /// All files that it reads beside itself.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let logs = self.file.runs.iter().map(|run| self.resolve(&run.file));
        std::iter::once(self.resolve(&self.file.robot))
            .chain(logs)
            .collect()
    }

    fn check(&self) -> Result<(), Error> {
        let file = &self.file;
        let invalid = |message: String, help: &str| Err(Error::invalid(message, help));
        if file.runs.iter().all(|run| run.held_out) {
            return invalid(
                "the study holds no run to fit".to_owned(),
                "name logs in `[[runs]]`, and leave `held_out` out of some",
            );
        }
        for (index, run) in file.runs.iter().enumerate() {
            if run.to_s.is_some_and(|to_s| to_s <= run.from_s) {
                return invalid(
                    format!("run {} ends before it begins", index + 1),
                    "let `to_s` be after `from_s`",
                );
            }
        }
        if !(file.window_s.is_finite() && file.window_s > 0.0) {
            return invalid(
                format!("`window_s` = {} is no length", file.window_s),
                "give it seconds above 0",
            );
        }
        if let Some(section) = &file.simulate
            && !(section.drive_s > 0.0 && section.drive_s <= MOST_DRIVE_S)
        {
            return invalid(
                format!(
                    "`simulate.drive_s` = {} is no length of a drive",
                    section.drive_s
                ),
                "give it seconds above 0 and up to 600",
            );
        }
        if let Some(section) = &file.simulate {
            self.check_simulate(section)?;
        }
        if !(50..=100_000).contains(&file.resamples) {
            return invalid(
                format!("{} resamples give no intervals", file.resamples),
                "let `resamples` be from 50 to 100000",
            );
        }
        for name in &file.tracker {
            if !["x_m", "y_m", "heading_deg"].contains(&name.as_str()) {
                return invalid(
                    format!("`{name}` is nothing of the tracker"),
                    "`tracker` may hold \"x_m\", \"y_m\" and \"heading_deg\"",
                );
            }
        }
        for model in &file.models {
            let twice = |other: &&ModelFile| other.name == model.name;
            if file.models.iter().filter(twice).count() > 1 {
                return invalid(
                    format!("two models are called `{}`", model.name),
                    "give each a `name` of its own",
                );
            }
            crate::model::Model::new(&self.robot, &model.free)?;
        }
        crate::log::check(&file.log, &self.robot)
    }

    /// What is compared beside the ways must have numbers that can be.
    fn check_beside(&self, section: &Simulate) -> Result<(), Error> {
        let mut numbers = Vec::new();
        if let Some(heading) = &section.heading {
            let error = heading.least_error_rad_per_m;
            numbers.push(("heading.least_error_rad_per_m", error, true));
        }
        if let Some(currents) = &section.currents {
            if self.file.log.currents.is_empty() {
                return Err(Error::invalid(
                    "`[simulate.currents]` stands, but the log has no currents",
                    "name their columns in `[log.currents]`, or leave the section out",
                ));
            }
            let gear_ratio = currents.gear_ratio.unwrap_or(1.0);
            let constant = currents.torque_constant_n_m_a;
            numbers.push(("currents.torque_constant_n_m_a", constant, true));
            numbers.push(("currents.gear_ratio", gear_ratio, true));
            numbers.push(("currents.friction_n_m", currents.friction_n_m, false));
            let error = currents.least_error_n_m;
            numbers.push(("currents.least_error_n_m", error, true));
        }
        let is_bad = |(_, value, positive): &(&str, f64, bool)| {
            !(value.is_finite() && (*value > 0.0 || (!positive && *value == 0.0)))
        };
        if let Some((key, value, positive)) = numbers.into_iter().find(is_bad) {
            let range = if positive { "above 0" } else { "0 or more" };
            return Err(Error::invalid(
                format!("`simulate.{key}` = {value} cannot be"),
                format!("give it a number that is {range}"),
            ));
        }
        for (index, beside) in section.beside.iter().enumerate() {
            let twice = section.beside[..index]
                .iter()
                .any(|b| b.name == beside.name);
            if twice || beside.name.trim().is_empty() {
                return Err(Error::invalid(
                    format!(
                        "`[[simulate.beside]]` {} needs a name of its own",
                        index + 1
                    ),
                    "give each another `name`",
                ));
            }
        }
        Ok(())
    }

    fn check_simulate(&self, section: &Simulate) -> Result<(), Error> {
        let invalid = |message: String, help: String| Err(Error::invalid(message, help));
        if !(1..=MOST_PHASES).contains(&section.phases) {
            return invalid(
                format!("`simulate.phases` = {} cannot be simulated", section.phases),
                format!("let it be from 1 to {MOST_PHASES}"),
            );
        }
        if !(section.least_error.is_finite() && section.least_error > 0.0) {
            return invalid(
                format!(
                    "`simulate.least_error` = {} is no error",
                    section.least_error
                ),
                "give it a share of the way above 0, such as 0.003".to_owned(),
            );
        }
        self.check_beside(section)?;
        let Some(ripple) = &section.ripple else {
            return Ok(());
        };
        if !(ripple.stretch_s > 0.0 && ripple.stretch_s <= section.drive_s) {
            return invalid(
                format!(
                    "`simulate.ripple.stretch_s` = {} does not fit into a drive of {} s",
                    ripple.stretch_s, section.drive_s
                ),
                "let it be above 0 and no more than `simulate.drive_s`".to_owned(),
            );
        }
        let wheels = &self.robot.wheels;
        for name in ripple.together.iter().flatten() {
            if !wheels.iter().any(|wheel| wheel.name == *name) {
                let names: Vec<&str> = wheels.iter().map(|wheel| wheel.name.as_str()).collect();
                return invalid(
                    format!("`simulate.ripple.together`: the robot has no wheel `{name}`"),
                    format!("its wheels are {}", names.join(", ")),
                );
            }
        }
        Ok(())
    }
}

/// The text of a scenario with a robot, to which keys are added.
pub(crate) fn scenario_text(robot: &Path) -> String {
    let mut section = Table::new();
    let path = robot.display().to_string();
    section.insert("file".to_owned(), Value::String(path));
    let robot = Table::from_iter([("robot".to_owned(), Value::Table(section))]);
    format!("{robot}\n[twist]\nvx_m_s = 0.1\n\n[run]\nduration_s = 1000.0\n")
}

/// A robot as a scenario would read it.
pub(crate) fn robot_of(
    robot: &Path,
    set: &Table,
    beside: &Path,
    files: &FileAccess,
) -> Result<Robot, Error> {
    let settings: Vec<Setting> = flat(set)
        .iter()
        .map(|(key, value)| Setting::new(key, value))
        .collect();
    let text = scenario_text(robot);
    load_robot(&Scenario::from_text(&text, beside, &settings, files)?)
}

/// The keys of nested tables, with dots.
pub(crate) fn flat(table: &Table) -> Vec<(String, Value)> {
    let mut flat_keys = Vec::new();
    for (key, value) in table {
        match value {
            Value::Table(inner) => flat_keys.extend(
                flat(inner)
                    .into_iter()
                    .map(|(below, value)| (format!("{key}.{below}"), value)),
            ),
            value => flat_keys.push((key.clone(), value.clone())),
        }
    }
    flat_keys
}
