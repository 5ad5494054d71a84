//! From a file and `--set` to a checked [`Scenario`], and back to text.

use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use miette::{NamedSource, SourceSpan};
use serde::Deserialize;
use toml::de::{DeTable, DeValue};

use super::{Motion, Robot, RollerBodies, Rollers, Scenario, Step, keys};
use crate::{Error, ScenarioFault};

/// A key changed from outside the file: `--set KEY=VALUE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    key: String,
    value: String,
}

impl std::str::FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() && !value.trim().is_empty() => Ok(Self {
                key: key.trim().to_owned(),
                value: value.trim().to_owned(),
            }),
            _ => Err("write KEY=VALUE, such as world.floor.friction=0.2".to_owned()),
        }
    }
}

impl std::fmt::Display for Setting {
    /// As it is written on the command line.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}", self.key, self.value)
    }
}

impl Setting {
    /// The setting as a line of TOML. A value that is no TOML is taken as text, so that no quotes are needed in a shell.
    fn as_toml(&self) -> String {
        let Self { key, value } = self;
        let as_is = format!("{key} = {value}");
        match DeTable::parse(&as_is) {
            Ok(_) => as_is,
            Err(_) => format!("{key} = {}", toml::Value::from(value.as_str())),
        }
    }
}

impl Scenario {
    /// Reads a scenario file.
    ///
    /// # Errors
    /// Where the file cannot be read, is no TOML, or holds a key or value that it may not.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        Self::load_with(path, &[])
    }

    /// Reads a scenario file with some of its keys changed.
    ///
    /// # Errors
    /// Like [`Self::load`]; a fault in a setting is shown in the setting.
    pub fn load_with(path: impl AsRef<Path>, settings: &[Setting]) -> Result<Self, Error> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|source| Error::read(path, &source))?;
        let mut scenario = parse(&text, &path.display().to_string(), settings)?;
        scenario.name = match path.file_stem() {
            Some(stem) => stem.to_string_lossy().into_owned(),
            None => "scenario".to_owned(),
        };
        scenario.folder = path.parent().map(PathBuf::from).unwrap_or_default();
        Ok(scenario)
    }

    /// Reads a scenario from text; its relative paths start from `folder`.
    ///
    /// # Errors
    /// Like [`Self::load`].
    pub fn from_toml(text: &str, name: &str, folder: impl Into<PathBuf>) -> Result<Self, Error> {
        let mut scenario = parse(text, name, &[])?;
        scenario.name = name.to_owned();
        scenario.folder = folder.into();
        Ok(scenario)
    }

    /// The scenario as TOML, with every default spelled out.
    pub fn to_toml(&self) -> Result<String, Error> {
        toml::to_string(self).map_err(|source| Error::invalid(source.to_string(), ""))
    }

    /// A path of the scenario, from its own folder.
    pub fn resolve(&self, path: &Path) -> PathBuf {
        self.folder.join(path)
    }

    /// The same scenario for a file in another folder: its paths start from there, as far as they can.
    pub fn moved_to(&self, folder: &Path) -> Self {
        let mut moved = self.clone();
        let from_there = |path: &mut PathBuf| {
            let absolute = std::path::absolute(self.resolve(path));
            let there = std::path::absolute(folder);
            if let (Ok(absolute), Ok(there)) = (absolute, there) {
                *path = relative(&normal(&absolute), &normal(&there));
            }
        };
        from_there(&mut moved.robot.file);
        moved.robot.packages.values_mut().for_each(from_there);
        if let Some(super::Reference::Waypoints { file, .. }) = &mut moved.reference {
            from_there(file);
        }
        moved.folder = folder.to_owned();
        moved
    }

    /// Checks what no single key can say: what must stand together, and how the time steps divide.
    ///
    /// # Errors
    /// [`Error::Invalid`], with the keys at fault.
    pub fn validate(&self) -> Result<(), Error> {
        match self.motion() {
            Some(Motion::OpenLoop(twist)) => check_schedule(twist)?,
            Some(Motion::Tracked(_)) => {}
            None => {
                let stands = if self.twist.is_some() {
                    "both `[reference]` and `[twist]` stand"
                } else {
                    "neither `[reference]` nor `[twist]` stands"
                };
                return Err(Error::invalid(
                    format!("{stands}, but a scenario asks for exactly one motion"),
                    "write `[reference.circle]` or one of its kin for closed loop, `[twist]` for open loop",
                ));
            }
        }
        let Robot {
            rollers,
            roller_bodies,
            ..
        } = self.robot;
        if (rollers, roller_bodies) == (Rollers::AsModelled, RollerBodies::Near) {
            return Err(Error::invalid(
                "`robot.rollers` = \"as_modelled\" and `robot.roller_bodies` = \"near\" do not go together: which rollers \
                 can touch the ground is known of barrels only",
                "put the shapes of all rollers into the world, `robot.roller_bodies` = \"all\", or take barrels",
            ));
        }
        if let Step::Seconds(dt_s) = self.run.physics_dt_s {
            let steps = self.run.control_dt_s / dt_s;
            // A part in 10^9 forgives the rounding of periods such as 1/240 s written with ten digits.
            if steps.round() < 1.0 || (steps - steps.round()).abs() > 1e-9 * steps {
                return Err(Error::invalid(
                    format!(
                        "`run.control_dt_s` = {} is {steps:.6} physics steps of `run.physics_dt_s` = {dt_s}, \
                         but must be a whole number of them",
                        self.run.control_dt_s
                    ),
                    format!(
                        "set `run.physics_dt_s` to {}, which divides it",
                        self.run.control_dt_s / steps.ceil().max(1.0)
                    ),
                ));
            }
        }
        if self.wheel_loop.friction.is_some()
            && self.wheel_loop.law != super::WheelLaw::PrioritisedTorque
        {
            return Err(Error::invalid(
                "`wheel_loop.friction` is of no use to `wheel_loop.law`, which knows of no grip",
                "write law = \"prioritised_torque\", or leave the friction out",
            ));
        }
        if self.run.duration_s < self.run.control_dt_s {
            return Err(Error::invalid(
                format!(
                    "`run.duration_s` = {} is shorter than one control period, `run.control_dt_s` = {}",
                    self.run.duration_s, self.run.control_dt_s
                ),
                "lengthen the run or shorten the control period",
            ));
        }
        self.check_length()
    }

    /// Refuses runs that no memory holds or that never end.
    fn check_length(&self) -> Result<(), Error> {
        let periods = self.run.duration_s / self.run.control_dt_s;
        let rows = periods / f64::from(self.run.record_every.max(1));
        if rows > MOST_ROWS {
            return Err(Error::invalid(
                format!(
                    "`run.duration_s` = {} makes {rows:.1e} rows of the trace, where at most {MOST_ROWS:.0e} are kept",
                    self.run.duration_s
                ),
                format!(
                    "shorten the run, or record less often: `run.record_every` = {:.0}",
                    (periods / MOST_ROWS).ceil()
                ),
            ));
        }
        let Step::Seconds(dt_s) = self.run.physics_dt_s else {
            return Ok(());
        };
        let steps = self.run.duration_s / dt_s;
        if steps > MOST_STEPS {
            return Err(Error::invalid(
                format!(
                    "`run.duration_s` = {} takes {steps:.1e} physics steps of `run.physics_dt_s` = {dt_s}, where at most \
                     {MOST_STEPS:.0e} are taken",
                    self.run.duration_s
                ),
                "shorten the run or lengthen its steps",
            ));
        }
        Ok(())
    }
}

/// The most rows of a trace: ten gigabytes or so, and a day at 100 Hz.
const MOST_ROWS: f64 = 1e7;
/// The most physics steps of a run: weeks of computing.
const MOST_STEPS: f64 = 1e11;

/// A path without `.` and, where what they undo is known, `..`.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir
                if matches!(normal.components().next_back(), Some(Component::Normal(_))) =>
            {
                normal.pop();
            }
            part => normal.push(part),
        }
    }
    normal
}

/// The way to an absolute path from an absolute folder; the path itself where they share no root.
fn relative(path: &Path, folder: &Path) -> PathBuf {
    let shared = path
        .components()
        .zip(folder.components())
        .take_while(|(a, b)| a == b)
        .count();
    if shared == 0 {
        return path.to_owned();
    }
    let up = folder
        .components()
        .skip(shared)
        .map(|_| Component::ParentDir);
    up.chain(path.components().skip(shared)).collect()
}

fn check_schedule(twist: &super::Twist) -> Result<(), Error> {
    let mut before_s = twist.rest_s;
    for (index, next) in twist.schedule.iter().enumerate() {
        if next.from_s < before_s + twist.ramp_s {
            return Err(Error::invalid(
                format!(
                    "`twist.schedule.{index}` begins at {} s, while the ramp before it lasts until {} s",
                    next.from_s,
                    before_s + twist.ramp_s
                ),
                "order the schedule by `from_s` and leave each ramp its time",
            ));
        }
        before_s = next.from_s;
    }
    Ok(())
}

fn parse(text: &str, name: &str, settings: &[Setting]) -> Result<Scenario, Error> {
    let mut document = DeTable::parse(text)
        .map_err(|error| Error::toml(&error, NamedSource::new(name, text.to_owned())))?;
    let lines: Vec<String> = settings.iter().map(Setting::as_toml).collect();
    let mut origins = Origins {
        file: (name, text),
        settings: Vec::new(),
    };
    for line in &lines {
        let setting = DeTable::parse(line)
            .map_err(|error| Error::toml(&error, NamedSource::new("--set", line.clone())))?;
        origins
            .settings
            .push((dotted_keys(setting.get_ref()), line));
        merge(document.get_mut(), setting.into_inner());
    }
    let schema = Scenario::json_schema();
    keys::check(&document, &schema).map_err(|fault| {
        let (source, span) = origins.of(&fault.path, fault.span);
        Error::Scenario(Box::new(ScenarioFault {
            message: fault.message,
            help: fault.help,
            source_code: source,
            span,
        }))
    })?;
    let scenario = Scenario::deserialize(toml::Deserializer::from(document))
        .map_err(|error| Error::toml(&error, NamedSource::new(name, text.to_owned())))?;
    scenario.validate()?;
    Ok(scenario)
}

/// Where each key of the merged document was written.
struct Origins<'t> {
    file: (&'t str, &'t str),
    settings: Vec<(Vec<String>, &'t str)>,
}

impl Origins<'_> {
    /// The text that holds a key, and a span in it.
    fn of(&self, path: &[String], span: Range<usize>) -> (NamedSource<String>, SourceSpan) {
        // A key at fault may be one on the way to the key that was set; it is the file's own where the file has it.
        let (name, text) = self.file;
        let in_file = DeTable::parse(text).is_ok_and(|document| holds(document.get_ref(), path));
        let setting = self
            .settings
            .iter()
            .rev()
            .find(|(keys, _)| path.starts_with(keys) || (!in_file && keys.starts_with(path)));
        match setting {
            Some((_, line)) => (NamedSource::new("--set", (*line).to_owned()), span.into()),
            None => (NamedSource::new(name, text.to_owned()), span.into()),
        }
    }
}

/// Whether a table holds a key, given from the outermost table in.
fn holds(table: &DeTable<'_>, path: &[String]) -> bool {
    let Some((first, rest)) = path.split_first() else {
        return true;
    };
    table
        .iter()
        .find(|(key, _)| key.get_ref() == first)
        .is_some_and(|(_, value)| {
            rest.is_empty()
                || value
                    .get_ref()
                    .as_table()
                    .is_some_and(|inner| holds(inner, rest))
        })
}

/// The keys of a document with a single value, from the outermost table in.
fn dotted_keys(table: &DeTable<'_>) -> Vec<String> {
    let mut keys = Vec::new();
    let mut table = Some(table);
    while let Some(inner) = table.take() {
        if inner.len() != 1 {
            break;
        }
        if let Some((key, value)) = inner.iter().next() {
            keys.push(key.get_ref().to_string());
            table = value.get_ref().as_table();
        }
    }
    keys
}

/// Lays one table over another. The value of a setting replaces the value that it names; tables on the way are merged.
fn merge<'i>(below: &mut DeTable<'i>, above: DeTable<'i>) {
    for (key, value) in above {
        let existing = below
            .iter_mut()
            .find(|(known, _)| known.get_ref() == key.get_ref());
        match (existing, value.get_ref()) {
            (Some((_, slot)), DeValue::Table(_)) => {
                let span = slot.span();
                match (slot.get_mut(), value.into_inner()) {
                    (DeValue::Table(slot), DeValue::Table(value)) => merge(slot, value),
                    (slot, value) => *slot = value,
                }
                let _ = span;
            }
            (Some((_, slot)), _) => *slot = value,
            (None, _) => {
                below.insert(key, value);
            }
        }
    }
}

/// Where a TOML error stands, or the whole text where it does not say.
pub(crate) fn toml_span(error: &toml::de::Error) -> SourceSpan {
    match error.span() {
        Some(span) => span.into(),
        None => SourceSpan::from(0..0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CIRCLE: &str = r#"
[robot]
file = "robot.urdf"

[reference.circle]
radius_m = 1.0
speed_m_s = 0.2

[run]
duration_s = 30
"#;

    fn told(text: &str, settings: &[&str]) -> (String, String, usize) {
        let settings: Vec<Setting> = settings.iter().map(|s| s.parse().unwrap()).collect();
        match parse(text, "test.toml", &settings) {
            Err(Error::Scenario(fault)) => (
                fault.message.clone(),
                fault.help.clone(),
                fault.span.offset(),
            ),
            Err(Error::Invalid { message, help }) => (message, help, 0),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_is_left_out_takes_its_documented_default() {
        let scenario = parse(CIRCLE, "test.toml", &[]).unwrap();
        assert_eq!(scenario.world.floor.friction, 0.6);
        assert_eq!(scenario.run.physics_dt_s, Step::default());
    }

    #[test]
    fn a_scenario_written_out_loads_again_to_the_same_text() {
        let once = parse(CIRCLE, "test.toml", &[]).unwrap().to_toml().unwrap();
        let twice = parse(&once, "test.toml", &[]).unwrap().to_toml().unwrap();
        assert_eq!(once, twice);
        assert!(once.contains("friction = 0.6"), "{once}");
    }

    #[test]
    fn a_setting_changes_any_key_and_needs_no_quotes() {
        let settings = [
            "world.floor.friction=0.2",
            "robot.roller_bodies=near",
            "robot.x_m = -1",
        ]
        .map(|s| s.parse().unwrap());
        let scenario = parse(CIRCLE, "test.toml", &settings).unwrap();
        assert_eq!(scenario.world.floor.friction, 0.2);
        assert_eq!(
            scenario.robot.roller_bodies,
            super::super::RollerBodies::Near
        );
        assert_eq!(scenario.robot.x_m, -1.0);
        assert_eq!(scenario.robot.file, Path::new("robot.urdf"));
    }

    #[test]
    fn an_unknown_key_is_refused_with_the_nearest_known_one_and_its_place() {
        let text = format!("{CIRCLE}\n[world.floor]\nfrction = 0.2\n");
        let (message, help, at) = told(&text, &[]);
        assert_eq!(message, "unknown key `world.floor.frction`");
        assert_eq!(help, "did you mean `friction`?");
        assert_eq!(at, text.find("frction").unwrap());
        assert_eq!(
            told(CIRCLE, &["wrld.floor.friction=1"]).1,
            "did you mean `world`?"
        );
    }

    #[test]
    fn a_fault_in_a_setting_is_shown_in_the_setting() {
        for (setting, offset) in [("world.flor.friction=1", 6), ("run.duration_s=x", 17)] {
            let settings = [setting.parse().unwrap()];
            match parse(CIRCLE, "test.toml", &settings) {
                Err(Error::Scenario(fault)) => {
                    assert_eq!(fault.source_code.name(), "--set");
                    assert_eq!(fault.span.offset(), offset);
                }
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn a_wrong_type_says_what_was_found_and_what_is_wanted() {
        let (message, ..) = told(CIRCLE, &["reference.circle.radius_m=wide"]);
        assert_eq!(
            message,
            "`reference.circle.radius_m` is a text, but must be a number"
        );
        let (message, help, _) = told(CIRCLE, &["guidance.priority=positon"]);
        assert_eq!(message, "`guidance.priority` cannot be \"positon\"");
        assert_eq!(help, "did you mean \"position\"?");
        let (message, ..) = told(CIRCLE, &["world.floor=0.2"]);
        assert_eq!(message, "`world.floor` is a number, but must be a table");
    }

    #[test]
    fn numbers_must_be_finite_and_within_their_bounds() {
        for not_finite in ["nan", "inf", "-inf"] {
            let (message, ..) = told(CIRCLE, &[&format!("run.duration_s={not_finite}")]);
            assert_eq!(message, "`run.duration_s` is not a finite number");
        }
        let (message, ..) = told(CIRCLE, &["run.physics_dt_s=0"]);
        assert_eq!(
            message,
            "`run.physics_dt_s` is 0, but must be greater than 0"
        );
        let (message, ..) = told(CIRCLE, &["run.control_dt_s=-0.01"]);
        assert_eq!(
            message,
            "`run.control_dt_s` is -0.01, but must be greater than 0"
        );
        let (message, ..) = told(CIRCLE, &["world.floor.friction=-1"]);
        assert_eq!(
            message,
            "`world.floor.friction` is -1, but must be 0 or more"
        );
    }

    #[test]
    fn numbers_are_of_a_size_to_compute_with_but_for_what_is_expected() {
        for (setting, told_of) in [
            ("run.duration_s=1e30", "`run.duration_s` is 1e30"),
            ("robot.x_m=-1e10", "`robot.x_m` is -1e10"),
            (
                "world.floor.friction=1e-300",
                "`world.floor.friction` is 1e-300",
            ),
        ] {
            let (message, help, _) = told(CIRCLE, &[setting]);
            assert!(message.starts_with(told_of), "{message}");
            assert_eq!(
                help,
                "write 0 or a number whose size is between 1e-12 and 1e9"
            );
        }
        let expected = ["expect.slip_energy_j={max=1e-20}".parse().unwrap()];
        assert!(parse(CIRCLE, "t", &expected).is_ok());
    }

    #[test]
    fn a_control_period_is_a_whole_number_of_physics_steps() {
        let (message, help, _) = told(CIRCLE, &["run.physics_dt_s=0.003"]);
        assert_eq!(
            message,
            "`run.control_dt_s` = 0.01 is 3.333333 physics steps of `run.physics_dt_s` = 0.003, but must be a whole \
             number of them"
        );
        assert_eq!(help, "set `run.physics_dt_s` to 0.0025, which divides it");
        let longer = parse(CIRCLE, "t", &["run.physics_dt_s=0.02".parse().unwrap()]);
        assert!(longer.is_err());
    }

    #[test]
    fn a_run_that_no_memory_holds_is_refused_with_what_would_do() {
        // 1e8 s at 100 Hz are 1e10 rows: a thousand times too many.
        let (message, help, _) = told(CIRCLE, &["run.duration_s=1e8"]);
        assert_eq!(
            message,
            "`run.duration_s` = 100000000 makes 1.0e10 rows of the trace, where at most 1e7 are kept"
        );
        assert!(help.ends_with("`run.record_every` = 1000"), "{help}");
        let thinned = ["run.duration_s=1e8", "run.record_every=1000"].map(|s| s.parse().unwrap());
        assert!(parse(CIRCLE, "t", &thinned).is_ok());
        let (message, ..) = told(CIRCLE, &["run.physics_dt_s=1e-12"]);
        assert!(message.contains("3.0e13 physics steps"), "{message}");
    }

    #[test]
    fn a_scenario_moved_to_another_folder_names_the_same_files() {
        let mut scenario = parse(CIRCLE, "test.toml", &[]).unwrap();
        scenario.folder = PathBuf::from("/home/a/scenarios");
        scenario.robot.file = PathBuf::from("../robots/x.urdf");
        let packages = &mut scenario.robot.packages;
        packages.insert("x".to_owned(), PathBuf::from("../meshes"));
        let moved = scenario.moved_to(Path::new("/home/b/out"));
        assert_eq!(moved.robot.file, Path::new("../../a/robots/x.urdf"));
        assert_eq!(moved.robot.packages["x"], Path::new("../../a/meshes"));
    }

    #[test]
    fn exactly_one_motion_is_asked_for() {
        let (message, ..) = told(CIRCLE, &["twist.vx_m_s=0.3"]);
        assert!(
            message.starts_with("both `[reference]` and `[twist]` stand"),
            "{message}"
        );
        let none = CIRCLE.replace("[reference.circle]\nradius_m = 1.0\nspeed_m_s = 0.2\n", "");
        let (message, ..) = told(&none, &[]);
        assert!(
            message.starts_with("neither `[reference]` nor"),
            "{message}"
        );
    }

    #[test]
    fn a_missing_key_is_named_with_what_it_is_for() {
        let (message, help, _) = told("[run]\nduration_s = 1\n[twist]\n", &[]);
        assert_eq!(message, "the key `robot` is missing");
        assert_eq!(help, "add `robot`: Which robot, and how it starts.");
    }

    #[test]
    fn an_expectation_names_a_quantity_that_exists() {
        let (message, help, _) = told(CIRCLE, &["expect.position_eror_final_m={max=1}"]);
        assert_eq!(message, "unknown key `expect.position_eror_final_m`");
        assert_eq!(help, "did you mean `position_error_final_m`?");
        let (message, ..) = told(CIRCLE, &["expect.twist_ratio_contact.vx={mx=1}"]);
        assert_eq!(message, "unknown key `expect.twist_ratio_contact.vx.mx`");
        let settings = ["expect.twist_ratio_contact.vx={min=0.9,max=1.1}"
            .parse()
            .unwrap()];
        let scenario = parse(CIRCLE, "t", &settings).unwrap();
        let bound = scenario.expect.bounds["twist_ratio_contact.vx"];
        assert_eq!((bound.min, bound.max), (Some(0.9), Some(1.1)));
    }
}
