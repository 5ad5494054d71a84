//! Keeps traces and scenarios of chosen runs.

use std::path::{Path, PathBuf};

use ilon_trace::file::write_text;
use rayon::prelude::*;

use crate::evaluate::{self, evaluate, scenario_of};
use crate::file::Keep;
use crate::options::{Options, Stop};
use crate::row::{Row, Status, figure_index};
use crate::shard;
use crate::store::Store;
use crate::study::Study;
use ilon_sim::Error;

/// Repeats the runs whose traces are to be kept and are missing; runs are deterministic.
pub(crate) fn keep(study: &Study, store: &Store, options: &Options) -> Result<(), Error> {
    let Some(folder) = store.folder() else {
        return Ok(());
    };
    if options.shard.is_some() && matches!(study.file().keep, Keep::Worst(_)) {
        // The worst runs are known only once all are finished.
        return Ok(());
    }
    let rows = store.rows();
    let mut places = shard::folders_in(folder)?;
    places.push(folder.to_owned());
    chosen(study, &rows).par_iter().try_for_each(|row| {
        let is_kept = |place: &PathBuf| {
            let kept = kept_folder(place, row.run);
            let is_there = |name: &str| kept.join(name).exists();
            is_there("summary.json") || (row.status == Status::Failed && is_there("scenario.toml"))
        };
        if places.iter().any(is_kept) {
            return Ok(());
        }
        keep_again(study, row, &kept_folder(folder, row.run), &options.stop)
    })
}

/// Repeats the task of a row, and writes its result into a folder.
fn keep_again(study: &Study, row: &Row, kept: &Path, stop: &Stop) -> Result<(), Error> {
    let task = study.task_of(row);
    let (again, finished) = evaluate(study, &task, stop)?;
    if again.status != row.status || again.trace_hash != row.trace_hash {
        let why = again
            .error
            .map_or(String::new(), |error| format!(": {error}"));
        return Err(Error::invalid(
            format!(
                "run {} does not give the results of its row again{why}",
                row.run
            ),
            "a file of its robot has changed or is gone; bring it back, or run the study anew in another folder",
        ));
    }
    match finished {
        Some(finished) => evaluate::write(&finished, kept),
        // For a run that cannot be simulated its scenario is kept, if valid.
        None => match scenario_of(study, &task) {
            Ok(scenario) => {
                std::fs::create_dir_all(kept).map_err(Error::io("create", kept))?;
                let text = scenario.moved_to(kept).to_toml()?;
                Ok(write_text(&kept.join("scenario.toml"), &text)?)
            }
            Err(_) => Ok(()),
        },
    }
}

/// Returns the rows whose traces a study keeps, once all are finished.
fn chosen<'r>(study: &Study, rows: &'r [Row]) -> Vec<&'r Row> {
    match study.file().keep {
        Keep::None => Vec::new(),
        // These were kept during the runs, unless a worker without access to the folder made them.
        Keep::All => rows
            .iter()
            .filter(|row| row.status == Status::Done)
            .collect(),
        Keep::Failed => {
            let breaks = |row: &Row| {
                study.expect().any(|(name, bound)| {
                    let value = figure_index(name).and_then(|index| row.figure(index));
                    !value.is_some_and(|value| bound.bound().holds(value))
                })
            };
            let is_chosen = |row: &&Row| row.status == Status::Failed || breaks(row);
            rows.iter().filter(is_chosen).collect()
        }
        Keep::Worst(count) => {
            let Some(index) = study
                .quantities()
                .first()
                .and_then(|name| figure_index(name))
            else {
                return Vec::new();
            };
            let mut ranked: Vec<(&Row, f64)> = rows
                .iter()
                .filter_map(|row| Some((row, row.figure(index)?)))
                .collect();
            ranked.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.run.cmp(&b.0.run)));
            ranked.into_iter().take(count).map(|(row, _)| row).collect()
        }
    }
}

/// Returns the folder of a run's trace.
pub(crate) fn kept_folder(folder: &Path, run: u64) -> PathBuf {
    folder.join("kept").join(format!("run_{run:06}"))
}
