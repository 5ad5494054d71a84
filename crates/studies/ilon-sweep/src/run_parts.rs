//! Independent parts of a study, for the workers of a cluster.

use std::path::Path;

use rayon::prelude::*;

use crate::engine::{Sweep, most_runs, searches};
use crate::options::Options;
use crate::row::Row;
use crate::shard::Shard;
use crate::store::Store;
use crate::study::{Question, Study};
use ilon_sim::Error;

impl Study {
    /// Returns the number of parts that depend only on the study: its runs, or with `[find]` the
    /// searches, one at each point of the axes, or with `[minimise]` the starts.
    pub fn parts(&self) -> u64 {
        match self.question() {
            Question::Table { runs } => runs,
            Question::Find(_) => searches(self),
            Question::Minimise(minimise) => u64::from(minimise.starts),
        }
    }

    /// Returns the largest number of runs, of a shard or of all of it.
    pub fn most_runs(&self, shard: Option<Shard>) -> u64 {
        most_runs(self, shard)
    }

    /// Returns the parts with missing rows in a store, of a shard or of all of it.
    pub fn missing_parts(&self, store: &Store, shard: Option<Shard>) -> Vec<u64> {
        let options = Options::default();
        let seen = Sweep::new(self, store, &options).looking_only();
        let is_missing = |part: &u64| match self.question() {
            Question::Table { .. } => !store.holds(*part),
            // Evaluated with the available rows.
            Question::Find(_) | Question::Minimise(_) => seen.part(*part).is_err(),
        };
        (0..self.parts())
            .filter(|part| shard.is_none_or(|shard| shard.holds(*part)))
            .filter(is_missing)
            .collect()
    }

    /// Makes parts of the study, a number of runs in parallel. The rows are in the order of their
    /// runs, and equal wherever they are made. `folder` is that of the study's results: if
    /// accessible, traces are written there when all are kept.
    ///
    /// # Errors
    /// For an unknown part, if a kept trace cannot be written, and [`Error::Stopped`].
    pub fn run_parts(
        &self,
        parts: &[u64],
        options: &Options,
        folder: Option<&Path>,
    ) -> Result<Vec<Row>, Error> {
        let count = self.parts();
        if let Some(beyond) = parts.iter().find(|part| **part >= count) {
            return Err(Error::invalid(
                format!("there is no part {beyond}: the study has {count} parts, counted from 0"),
                "name parts that there are",
            ));
        }
        let folder = folder.filter(|folder| Store::holds_rows_of(folder, self));
        let store = Store::in_memory();
        let sweep = Sweep::new(self, &store, options).keeping_in(folder);
        options.pool()?.install(|| {
            let parts = parts.par_iter().with_max_len(1);
            parts.try_for_each(|part| sweep.part(*part))
        })?;
        Ok(store.rows())
    }
}
