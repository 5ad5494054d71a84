//! A checked study and its tasks.

mod fingerprint;

use std::path::{Path, PathBuf};

use ilon_files::FileAccess;
use ilon_files::toml::flat;
use serde::{Deserialize, Serialize};
use toml::Value;

use crate::axis::{Axis, Values, grid_points, text_of};
use crate::base::Base;
use crate::check::{self, Draft};
use crate::file::{Find, Method, Minimise, SEED, ShareBound, StudyFile};
use crate::robots::Robots;
use crate::row::{Row, Task};
use crate::sample::{Sample, generator, unit};
use crate::value_names;
use ilon_sim::Error;
use ilon_sim::scenario::{Scenario, Setting, read_text};

/// Many runs of one scenario, or of several, with varied keys.
#[derive(Debug)]
pub struct Study {
    pub(crate) name: String,
    pub(crate) path: PathBuf,
    pub(crate) text: String,
    pub(crate) file: StudyFile,
    pub(crate) axes: Vec<Axis>,
    pub(crate) bases: Vec<Base>,
    fixed: Vec<Setting>,
    columns: Vec<Column>,
    sample: Option<Sample>,
    quantities: Vec<String>,
    fingerprint: String,
    files: FileAccess,
    pub(crate) robots: Robots,
}

/// A key that differs between runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// Dotted key of the scenario.
    pub key: String,
    /// Whether all its values are numbers.
    pub is_numeric: bool,
}

/// The question of a study.
#[derive(Clone, Copy, Debug)]
pub enum Question<'s> {
    /// The results of a number of runs that are known beforehand.
    Table {
        /// Number of runs.
        runs: u64,
    },
    /// The crossings of a value: each run depends on earlier ones.
    Find(&'s Find),
    /// The minimum of a quantity: each run depends on earlier ones.
    Minimise(&'s Minimise),
}

impl Study {
    /// Reads a study and all files that it names.
    ///
    /// # Errors
    /// If a file cannot be read, and if the study is invalid: an unknown key or quantity, an axis
    /// without values, an invalid scenario. Faults name their place.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        Self::load_within(path, &FileAccess::anywhere())
    }

    /// Reads a study; all files of it and its scenarios must be among the accessible ones.
    ///
    /// # Errors
    /// Like [`Self::load`].
    pub fn load_within(path: impl AsRef<Path>, files: &FileAccess) -> Result<Self, Error> {
        let path = path.as_ref();
        let text = read_text(path, files)?;
        Self::from_toml(text, path, files)
    }

    /// Reads a study from the text of a file, with the name and relative paths of the file at
    /// `path`. All files of it and its scenarios must be among the accessible ones.
    ///
    /// # Errors
    /// Like [`Self::load`].
    pub fn from_toml(
        text: String,
        path: impl AsRef<Path>,
        files: &FileAccess,
    ) -> Result<Self, Error> {
        let path = path.as_ref();
        let file = check::parse(&text, path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let named = file.scenario.paths().iter();
        let bases = named.map(|named| Base::read(folder.join(named), files));
        let bases = bases.collect::<Result<Vec<_>, _>>()?;
        let mut study = Self::of(text, path.to_owned(), file, bases, files.clone())?;
        study.draft().keys(&study.fixed, files)?;
        study.fingerprint = fingerprint::of(&study.draft(), &study.fixed, files)?;
        Ok(study)
    }

    /// Returns the stored study of a folder of results, independent of the current files.
    pub(crate) fn as_it_was(
        text: String,
        path: PathBuf,
        bases: Vec<Base>,
        fingerprint: String,
    ) -> Result<Self, Error> {
        let file = check::parse(&text, &path)?;
        let mut study = Self::of(text, path, file, bases, FileAccess::anywhere())?;
        study.fingerprint = fingerprint;
        Ok(study)
    }

    fn draft(&self) -> Draft<'_> {
        Draft {
            text: &self.text,
            path: &self.path,
            file: &self.file,
            axes: &self.axes,
            bases: &self.bases,
        }
    }

    fn of(
        text: String,
        path: PathBuf,
        file: StudyFile,
        bases: Vec<Base>,
        files: FileAccess,
    ) -> Result<Self, Error> {
        let axes = check::axes(&text, &path, &file)?;
        let draft = Draft {
            text: &text,
            path: &path,
            file: &file,
            axes: &axes,
            bases: &bases,
        };
        draft.check()?;
        let sample = match (file.method, file.points) {
            (Method::Grid, _) => None,
            (method, points) => Some(Sample::new(
                method,
                file.seed,
                points.unwrap_or_default(),
                axes.len(),
            )),
        };
        let column = |axis: &Axis| Column {
            key: axis.key.clone(),
            is_numeric: axis.is_numeric(),
        };
        let mut columns: Vec<Column> = axes.iter().map(column).collect();
        let number = |key: &str| Column {
            key: key.to_owned(),
            is_numeric: true,
        };
        columns.extend(file.find.as_ref().map(|find| number(&find.key)));
        let fixed = flat(&file.set);
        let is_seeded = fixed.iter().any(|(key, _)| key == SEED)
            || columns.iter().any(|column| column.key == SEED);
        if (file.method.is_sample() || file.repetitions > 1) && !is_seeded {
            columns.push(number(SEED));
        }
        let mut study = Self {
            name: path
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            path,
            text,
            axes,
            bases,
            fixed: fixed
                .iter()
                .map(|(key, value)| Setting::new(key, value))
                .collect(),
            columns,
            sample,
            quantities: file.quantities.clone(),
            file,
            fingerprint: String::new(),
            files,
            robots: Robots::default(),
        };
        study.quantities = study.looked_at();
        Ok(study)
    }

    /// Its name: that of its file, without the extension.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Path of its file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The text of its file.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The content of the file.
    pub fn file(&self) -> &StudyFile {
        &self.file
    }

    /// The varied keys.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Returns the name of a value of a key: for a table what distinguishes it from the others of
    /// its axis, otherwise its text.
    pub fn name_of(&self, key: &str, value: &Value) -> String {
        let axis = self.axes.iter().find(|axis| axis.key == key);
        let (Value::Table(_), Some(Values::List(values))) = (value, axis.map(|axis| &axis.values))
        else {
            return text_of(value);
        };
        let place = values.iter().position(|other| other == value);
        place.map_or_else(
            || text_of(value),
            |place| value_names::names(values).swap_remove(place),
        )
    }

    /// The keys that differ between runs: the axes, the key of `[find]`, and `sensors.seed` if each
    /// run has its own.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The quantities of interest, the most important first.
    pub fn quantities(&self) -> &[String] {
        &self.quantities
    }

    /// The bounds that its runs must keep.
    pub fn expect(&self) -> impl Iterator<Item = (&str, &ShareBound)> {
        self.file
            .expect
            .iter()
            .map(|(name, bound)| (name.as_str(), bound))
    }

    /// Returns a hash of everything that its rows depend on: its axes and seeds, its scenarios with
    /// their robots and all files of these, and the version of ilon.
    pub fn fingerprint(&self) -> &str {
        &self.fingerprint
    }

    /// The names of its scenarios.
    pub fn scenario_names(&self) -> impl Iterator<Item = &str> {
        self.bases.iter().map(|base| base.name.as_str())
    }

    /// Returns the path of one of its scenarios.
    pub fn scenario_path(&self, scenario: usize) -> &Path {
        &self.bases[scenario].path
    }

    /// Returns its question.
    pub fn question(&self) -> Question<'_> {
        match (&self.file.find, &self.file.minimise) {
            (Some(find), _) => Question::Find(find),
            (None, Some(minimise)) => Question::Minimise(minimise),
            (None, None) => Question::Table {
                runs: self.bases.len() as u64 * self.points() * u64::from(self.file.repetitions),
            },
        }
    }

    /// The number of points on its axes.
    pub fn points(&self) -> u64 {
        match &self.sample {
            Some(sample) => sample.len(),
            None => grid_points(&self.axes),
        }
    }

    /// Returns a run of a study whose runs are known beforehand, as a function of its number and
    /// the study.
    pub fn task(&self, run: u64) -> Task {
        let repetitions = u64::from(self.file.repetitions);
        let (place, repetition) = (run / repetitions, (run % repetitions) as u32);
        let points = self.points();
        let (scenario, point) = ((place / points) as usize, place % points);
        self.task_at(run, scenario, point, repetition, self.values_at(point))
    }

    /// Returns the task of a row of this study.
    pub fn task_of(&self, row: &Row) -> Task {
        let scenario = self.scenario_names().position(|name| name == row.scenario);
        Task {
            run: row.run,
            scenario: scenario.unwrap_or(0),
            point: row.point,
            repetition: row.repetition,
            values: row.values.clone(),
        }
    }

    /// Returns a run with these values on the axes, and on the searched key, if any.
    pub(crate) fn task_at(
        &self,
        run: u64,
        scenario: usize,
        point: u64,
        repetition: u32,
        mut values: Vec<Value>,
    ) -> Task {
        if self.columns.len() > values.len() {
            values.push(Value::Integer(i64::from(self.seed_of(run, repetition))));
        }
        Task {
            run,
            scenario,
            point,
            repetition,
            values,
        }
    }

    /// Returns the value on each axis at a point.
    pub(crate) fn values_at(&self, point: u64) -> Vec<Value> {
        match &self.sample {
            Some(sample) => {
                let place = sample.at(point);
                self.axes
                    .iter()
                    .zip(place)
                    .map(|(axis, share)| axis.at(share))
                    .collect()
            }
            None => {
                let mut rest = point;
                let mut values: Vec<Value> = Vec::with_capacity(self.axes.len());
                for axis in self.axes.iter().rev() {
                    let count = axis.count().unwrap_or(1);
                    values.push(axis.nth(rest % count));
                    rest /= count;
                }
                values.reverse();
                values
            }
        }
    }

    /// Returns the positions of the points on the axes, as shares; `None` for a grid.
    pub(crate) fn sample(&self) -> Option<&Sample> {
        self.sample.as_ref()
    }

    /// Returns the noise seed of a run. Each draw of a sample has its own noise; otherwise all
    /// points have the same noise, so that only the varied keys make a difference.
    fn seed_of(&self, run: u64, repetition: u32) -> u32 {
        let (purpose, number) = if self.file.method.is_sample() {
            (3, run)
        } else {
            (4, u64::from(repetition))
        };
        let mut rng = generator(self.file.seed, purpose, number);
        (unit(&mut rng) * f64::from(u32::MAX)) as u32
    }

    pub(crate) fn scenario_name(&self, scenario: usize) -> &str {
        &self.bases[scenario].name
    }

    /// Returns the settings of a run beyond its scenario's file.
    pub fn settings(&self, task: &Task) -> Vec<Setting> {
        let varied = self.columns.iter().zip(&task.values);
        let varied = varied.map(|(column, value)| Setting::new(&column.key, value));
        self.fixed.iter().cloned().chain(varied).collect()
    }

    /// Returns one of its scenarios with changed keys.
    pub(crate) fn scenario_with(
        &self,
        scenario: usize,
        settings: &[Setting],
    ) -> Result<Scenario, Error> {
        self.bases[scenario].with(settings, &self.files)
    }

    /// Returns the quantities that the study names, by default those of its scenario.
    fn looked_at(&self) -> Vec<String> {
        let mut names = self.file.quantities.clone();
        let asked = [
            self.file.find.as_ref().map(|find| &find.quantity),
            self.file
                .minimise
                .as_ref()
                .map(|minimise| &minimise.quantity),
        ];
        let kept = self
            .file
            .minimise
            .iter()
            .flat_map(|of| of.subject_to.keys());
        let asked = asked.into_iter().flatten().chain(kept);
        let asked = asked.chain(self.file.expect.keys());
        for name in asked {
            if !names.contains(name) {
                names.push(name.clone());
            }
        }
        if names.is_empty() {
            let is_tracked = self
                .bases
                .first()
                .is_some_and(|base| base.text.contains("[reference"));
            let usual: &[&str] = if !self.file.physics {
                &[
                    "design.condition",
                    "design.speed_least_m_s",
                    "design.acceleration_least_m_s2",
                ]
            } else if is_tracked {
                &[
                    "position_error_max_m",
                    "position_error_rms_m",
                    "slip_energy_j",
                ]
            } else {
                &[
                    "slip_energy_j",
                    "slip_speed_rms_m_s",
                    "odometry_drift_m_per_m",
                ]
            };
            names.extend(usual.iter().map(|name| (*name).to_owned()));
        }
        names
    }
}
