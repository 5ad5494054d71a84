//! A study as written by a user: the robot, the logs of its drives, and the free parameters.

use std::path::{Path, PathBuf};

use ilon_files::FileAccess;
use ilon_files::toml::flat;
use ilon_robot::Robot;
use ilon_sim::scenario::{Scenario, Setting, read_text, read_toml};
use ilon_sim::{Error, load_robot};
use toml::{Table, Value};

pub use crate::simulate::{
    BesideFile, CurrentsFile, HeadingFile, Logged, Phases, RippleFile, Simulate,
};
use crate::steered::Unsteered;
pub use crate::study_file::{ModelFile, RunFile, StudyFile};

/// A study with its robot.
#[derive(Debug)]
pub struct Study {
    /// Path of its file.
    pub path: PathBuf,
    /// Content of the file.
    pub file: StudyFile,
    /// The robot before the fit.
    pub robot: Robot,
    pub(crate) unsteered: Unsteered,
    pub(crate) files: FileAccess,
}

impl Study {
    /// Reads a study and its robot.
    ///
    /// # Errors
    /// If a file cannot be read, or the study is invalid.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        Self::load_within(path, &FileAccess::anywhere())
    }

    /// Reads a study and its robot; all files must be among the accessible ones.
    ///
    /// # Errors
    /// Like [`Self::load`].
    pub fn load_within(path: impl AsRef<Path>, files: &FileAccess) -> Result<Self, Error> {
        let path = path.as_ref();
        Self::from_toml(&read_text(path, files)?, path, files)
    }

    /// Reads a study from the text of a file, with the name and relative paths of the file at
    /// `path`.
    ///
    /// # Errors
    /// Like [`Self::load`].
    pub fn from_toml(text: &str, path: &Path, files: &FileAccess) -> Result<Self, Error> {
        let file: StudyFile = read_toml(text, path)?;
        let robot = robot_of(&file.robot, &file.set, path, files)?;
        let study = Self {
            path: path.to_owned(),
            unsteered: Unsteered::new(&robot, &file.log.wheels)?,
            robot,
            file,
            files: files.clone(),
        };
        study.check()?;
        Ok(study)
    }

    /// Its name: that of its file, without the extension.
    pub fn name(&self) -> String {
        let stem = self.path.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }

    /// Returns a path of the study relative to the study's folder.
    pub fn resolve(&self, path: &Path) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(path)
    }

    /// Returns all other files that it reads.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let logs = self.file.runs.iter().map(|run| self.resolve(&run.file));
        std::iter::once(self.resolve(&self.file.robot))
            .chain(logs)
            .collect()
    }

    /// Returns two runs that overlap in one log: what counts twice makes intervals too narrow, and
    /// fits what is held out.
    fn same_part(&self) -> Option<[usize; 2]> {
        let runs = self.file.runs.iter().enumerate();
        let mut parts: Vec<_> = runs
            .map(|(index, run)| {
                let path = self.resolve(&run.file);
                (path.canonicalize().unwrap_or(path), run, index)
            })
            .collect();
        parts.sort_by(|(one, a, _), (other, b, _)| {
            one.cmp(other).then(a.from_s.total_cmp(&b.from_s))
        });
        parts.windows(2).find_map(|two| match two {
            [(one, a, i), (other, b, k)] => {
                let overlap = one == other && a.to_s.is_none_or(|to_s| b.from_s < to_s);
                overlap.then(|| [*i.min(k), *i.max(k)])
            }
            _ => None,
        })
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
        if let Some([one, other]) = self.same_part() {
            return invalid(
                format!(
                    "runs {} and {} hold the same part of `{}`",
                    one + 1,
                    other + 1,
                    file.runs[other].file.display()
                ),
                "name each log once, or let its parts follow each other by `from_s` and `to_s`",
            );
        }
        if !(file.window_s.is_finite() && file.window_s > 0.0) {
            return invalid(
                format!("`window_s` = {} is no length", file.window_s),
                "give it seconds above 0",
            );
        }
        if let Some(section) = &file.simulate {
            crate::simulate::check(section, file, &self.robot)?;
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
            crate::model::Model::new(&self.unsteered.robot, &model.free)?;
        }
        crate::log::check(&file.log, &self.robot)
    }
}

/// Returns the text of a scenario with a robot, to which keys are added.
pub(crate) fn scenario_text(robot: &Path) -> String {
    let mut section = Table::new();
    let path = robot.display().to_string();
    section.insert("file".to_owned(), Value::String(path));
    let robot = Table::from_iter([("robot".to_owned(), Value::Table(section))]);
    format!("{robot}\n[twist]\nvx_m_s = 0.1\n\n[run]\nduration_s = 1000.0\n")
}

/// Returns a robot as a scenario would read it.
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
