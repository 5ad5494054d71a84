//! Runs a study on all cores and computes its findings.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};

use rayon::prelude::*;
use toml::Value;

use crate::evaluate::{self, evaluate};
use crate::file::{Find, Keep, Minimise};
use crate::findings::{Findings, FoundAt, MinimumAt};
use crate::keep_traces::{keep, kept_folder};
use crate::minimise::Trial;
use crate::options::{Options, Progress, Stop};
use crate::row::{Row, Status, Task, figure_index};
use crate::shard::Shard;
use crate::store::Store;
use crate::study::{Question, Study};
use crate::table::{write_json, write_runs};
use ilon_sim::Error;

/// State of a running study, shared by all threads.
pub(crate) struct Sweep<'s> {
    study: &'s Study,
    store: &'s Store,
    watch: &'s (dyn Fn(Progress) + Sync),
    stop: &'s Stop,
    /// Folder for traces that are kept during the runs.
    folder: Option<&'s Path>,
    /// Whether missing runs are made; if not, the first one ends with [`Error::Stopped`].
    may_run: bool,
    done: AtomicU64,
    failed: AtomicU64,
    found: u64,
    /// Expected number of runs; searches correct it.
    likely: AtomicI64,
}

/// Makes all runs of a study that are not in the store, and returns the findings. A run's error is
/// stored in its row.
///
/// `watch` is called from several threads, after each run.
///
/// # Errors
/// If rows or kept traces cannot be written, or a search would be divided; [`Error::Stopped`] if
/// stopped.
pub fn sweep(
    study: &Study,
    store: &Store,
    options: &Options,
    watch: &(dyn Fn(Progress) + Sync),
) -> Result<Findings, Error> {
    if options.shard.is_some() && !matches!(study.question(), Question::Table { .. }) {
        return Err(Error::invalid(
            "a study that searches cannot be divided: each of its runs follows from those before it",
            "run it whole; it uses all cores of a machine",
        ));
    }
    let pool = options.pool()?;
    let sweep = Sweep {
        watch,
        ..Sweep::new(study, store, options)
    };
    sweep.tell();
    let result = pool.install(|| sweep.answer(options.shard));
    store.sync()?;
    let findings = result?;
    pool.install(|| keep(study, store, options))?;
    Ok(findings)
}

/// Writes the missing traces that a completed study keeps, by repeating these runs, which are
/// deterministic.
///
/// # Errors
/// If they cannot be written, or if a run differs because the files of its robot have changed;
/// [`Error::Stopped`] if stopped.
pub fn keep_traces(study: &Study, store: &Store, options: &Options) -> Result<(), Error> {
    options.pool()?.install(|| keep(study, store, options))
}

/// Writes `runs.parquet` and `findings.json` into the store's folder, if it has one.
///
/// # Errors
/// If they cannot be written.
pub fn write_results(study: &Study, store: &Store, findings: &Findings) -> Result<(), Error> {
    let Some(folder) = store.folder() else {
        return Ok(());
    };
    write_runs(&folder.join("runs.parquet"), study, &store.rows())?;
    write_json(&folder.join("findings.json"), "the findings", findings)
}

/// Returns the findings of a completed study from the rows of a store.
pub fn findings(study: &Study, store: &Store) -> Findings {
    Findings::of(study, &store.rows())
}

/// Returns the number of searches of a study with `[find]`.
pub(crate) fn searches(study: &Study) -> u64 {
    study.scenario_names().count() as u64 * study.points()
}

/// Returns the largest number of runs of a study, of a shard or of all of it.
pub(crate) fn most_runs(study: &Study, shard: Option<Shard>) -> u64 {
    let repetitions = u64::from(study.file().repetitions);
    match study.question() {
        Question::Table { runs } => (0..runs)
            .filter(|run| shard.is_none_or(|shard| shard.holds(*run)))
            .count() as u64,
        Question::Find(find) => searches(study) * find.most_trials() * repetitions,
        Question::Minimise(minimise) => minimise.most_trials() * repetitions,
    }
}

/// Returns the number of runs of a study if each search along a key finds one crossing.
fn likely_runs(study: &Study, shard: Option<Shard>) -> u64 {
    match study.question() {
        Question::Find(find) => {
            searches(study) * find.likely_trials() * u64::from(study.file().repetitions)
        }
        _ => most_runs(study, shard),
    }
}

impl<'s> Sweep<'s> {
    /// A study with possibly some rows in the store, without a watcher.
    pub fn new(study: &'s Study, store: &'s Store, options: &'s Options) -> Self {
        let before = store.rows();
        let found = before.len() as u64;
        let failed = before.iter().filter(|row| row.status == Status::Failed);
        Self {
            study,
            store,
            watch: &|_| (),
            stop: &options.stop,
            folder: store.folder(),
            may_run: true,
            done: AtomicU64::new(found),
            failed: AtomicU64::new(failed.count() as u64),
            found,
            likely: AtomicI64::new(likely_runs(study, options.shard) as i64),
        }
    }

    /// Keeps traces in a folder other than the store's.
    pub fn keeping_in(mut self, folder: Option<&'s Path>) -> Self {
        self.folder = folder;
        self
    }

    /// Makes no runs: a missing row ends with [`Error::Stopped`].
    pub fn looking_only(mut self) -> Self {
        self.may_run = false;
        self
    }

    /// Makes the missing runs of a part, one of [`Study::parts`].
    pub fn part(&self, part: u64) -> Result<(), Error> {
        match self.study.question() {
            Question::Table { .. } => self.row(&self.study.task(part)).map(drop),
            Question::Find(find) => self.find(find, part).map(drop),
            Question::Minimise(minimise) => {
                let trial = self.trial(minimise)?;
                let (axes, seed) = (self.study.axes().len(), self.study.file().seed);
                minimise.search_from(part, axes, seed, &|_| (), trial)
            }
        }
    }

    fn tell(&self) {
        (self.watch)(Progress {
            done: self.done.load(Ordering::Relaxed),
            found: self.found,
            failed: self.failed.load(Ordering::Relaxed),
            likely: self
                .likely
                .load(Ordering::Relaxed)
                .unsigned_abs()
                .max(self.done.load(Ordering::Relaxed)),
            is_search: !matches!(self.study.question(), Question::Table { .. }),
        });
    }

    /// Reduces the expected number of runs by the trials that a search did not need.
    fn spare(&self, trials: i64) {
        let runs = trials * i64::from(self.study.file().repetitions);
        self.likely.fetch_sub(runs, Ordering::Relaxed);
    }

    /// Returns the row of a task, after running it if necessary.
    fn row(&self, task: &Task) -> Result<Row, Error> {
        if let Some(row) = self.store.row_of(task) {
            return Ok(row);
        }
        if !self.may_run {
            return Err(Error::Stopped);
        }
        let (row, finished) = evaluate(self.study, task, self.stop)?;
        if self.study.file().keep == Keep::All
            && let (Some(finished), Some(folder)) = (&finished, self.folder)
        {
            // Before its row, so that no row lacks its trace.
            evaluate::write(finished, &kept_folder(folder, task.run))?;
        }
        self.store.put(row.clone())?;
        self.done.fetch_add(1, Ordering::Relaxed);
        if row.status == Status::Failed {
            self.failed.fetch_add(1, Ordering::Relaxed);
        }
        self.tell();
        Ok(row)
    }

    fn answer(&self, shard: Option<Shard>) -> Result<Findings, Error> {
        let (study, store) = (self.study, self.store);
        match study.question() {
            Question::Table { runs } => {
                let is_meant = |run: &u64| shard.is_none_or(|shard| shard.holds(*run));
                let missing: Vec<u64> = (0..runs)
                    .filter(is_meant)
                    .filter(|run| !store.holds(*run))
                    .collect();
                // One by one: the runs of a study may take very different times.
                missing
                    .par_iter()
                    .with_max_len(1)
                    .try_for_each(|run| self.row(&study.task(*run)).map(drop))?;
                Ok(Findings::of(study, &store.rows()))
            }
            Question::Find(find) => {
                let searches: Vec<u64> = (0..searches(study)).collect();
                let found = searches.par_iter().map(|search| self.find(find, *search));
                let found = found.collect::<Result<Vec<_>, Error>>()?;
                let mut findings = Findings::of(study, &store.rows());
                findings.found = found;
                Ok(findings)
            }
            Question::Minimise(minimise) => {
                let minimum = self.minimise(minimise)?;
                let mut findings = Findings::of(study, &store.rows());
                findings.minimum = Some(minimum);
                Ok(findings)
            }
        }
    }

    /// Returns the rows of all repetitions at a point; the first is run `first`.
    fn rows_at(
        &self,
        scenario: usize,
        point: u64,
        trial: u64,
        values: &[Value],
    ) -> Result<Vec<Row>, Error> {
        let repetitions = self.study.file().repetitions;
        let tasks: Vec<Task> = (0..repetitions)
            .map(|repetition| {
                let run = trial * u64::from(repetitions) + u64::from(repetition);
                self.study
                    .task_at(run, scenario, point, repetition, values.to_vec())
            })
            .collect();
        tasks.par_iter().map(|task| self.row(task)).collect()
    }

    fn find(&self, find: &Find, search: u64) -> Result<FoundAt, Error> {
        let (study, points) = (self.study, self.study.points());
        let (scenario, point) = ((search / points) as usize, search % points);
        let on_axes = study.values_at(point);
        let Some(quantity) = figure_index(&find.quantity) else {
            return Err(no_quantity(&find.quantity));
        };
        let spare = |trials| self.spare(trials);
        let found = find.search(&spare, |trial, key| {
            let mut values = on_axes.clone();
            values.push(Value::Float(key));
            let trial = search * find.most_trials() + trial;
            let rows = self.rows_at(scenario, point, trial, &values)?;
            Ok::<_, Error>(mean(&rows, quantity))
        })?;
        let keys = study.axes().iter().map(|axis| axis.key.clone());
        Ok(FoundAt {
            scenario: study.scenario_name(scenario).to_owned(),
            values: keys.zip(on_axes).collect(),
            found,
        })
    }

    /// Returns the result of a trial of a study with `[minimise]`, at a point given as a share of
    /// each axis.
    fn trial(
        &self,
        minimise: &Minimise,
    ) -> Result<impl Fn(u64, &[f64]) -> Result<Trial, Error> + Sync, Error> {
        let Some(quantity) = figure_index(&minimise.quantity) else {
            return Err(no_quantity(&minimise.quantity));
        };
        let bounded = minimise
            .subject_to
            .keys()
            .map(|name| figure_index(name).ok_or_else(|| no_quantity(name)));
        let bounded = bounded.collect::<Result<Vec<_>, Error>>()?;
        Ok(move |trial: u64, place: &[f64]| {
            let rows = self.rows_at(0, trial, trial, &values_on(self.study, place))?;
            let values = bounded
                .iter()
                .map(|index| mean(&rows, *index))
                .collect::<Option<Vec<_>>>();
            Ok(mean(&rows, quantity).zip(values))
        })
    }

    fn minimise(&self, minimise: &Minimise) -> Result<MinimumAt, Error> {
        let study = self.study;
        let trial = self.trial(minimise)?;
        let spare = |trials| self.spare(trials);
        let minimum = minimise.search(study.axes().len(), study.file().seed, &spare, trial)?;
        let keys = study.axes().iter().map(|axis| axis.key.clone());
        let values: BTreeMap<String, Value> = keys.zip(values_on(study, &minimum.place)).collect();
        let first = |trial: u64| trial * u64::from(study.file().repetitions);
        let run = minimum.trial.map(first);
        let best = self
            .store
            .rows()
            .into_iter()
            .find(|row| Some(row.run) == run);
        let figure = |quantity: &String| best.as_ref()?.figure(figure_index(quantity)?);
        let bounded = minimise.subject_to.keys();
        let bounded = bounded.filter_map(|quantity| Some((quantity.clone(), figure(quantity)?)));
        Ok(MinimumAt {
            quantity: minimise.quantity.clone(),
            values,
            run,
            subject_to: bounded.collect(),
            notes: best.as_ref().map_or_else(Vec::new, |row| row.notes.clone()),
            minimum,
        })
    }
}

/// Returns the value on each axis at a point, given as a share of each.
fn values_on(study: &Study, place: &[f64]) -> Vec<Value> {
    let axes = study.axes().iter().zip(place);
    axes.map(|(axis, share)| axis.at(*share)).collect()
}

/// Returns the mean of a quantity over rows; `None` if one of them lacks it.
fn mean(rows: &[Row], quantity: usize) -> Option<f64> {
    let values = rows
        .iter()
        .map(|row| row.figure(quantity))
        .collect::<Option<Vec<f64>>>()?;
    Some(values.iter().sum::<f64>() / values.len() as f64)
}

fn no_quantity(name: &str) -> Error {
    Error::invalid(
        format!("there is no quantity `{name}`"),
        "name one of `summary.json`",
    )
}
