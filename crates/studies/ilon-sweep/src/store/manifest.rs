//! The study to which the rows in a folder belong.

use std::path::{Path, PathBuf};

use ilon_files::FileAccess;
use serde::{Deserialize, Serialize};

use crate::base::Base;
use crate::study::Study;
use crate::table::write_json;
use ilon_sim::Error;

const NAME: &str = "study.json";

/// Largest size of a manifest, in bytes: a study and its scenarios, each of which is limited.
const MOST_BYTES: u64 = 256 << 20;

/// The complete study of a folder: merging needs none of its files.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Manifest {
    /// The version of ilon.
    ilon: String,
    name: String,
    fingerprint: String,
    path: PathBuf,
    study: String,
    scenarios: Vec<Base>,
}

impl Manifest {
    pub fn of(study: &Study) -> Self {
        Self {
            ilon: env!("CARGO_PKG_VERSION").to_owned(),
            name: study.name().to_owned(),
            fingerprint: study.fingerprint().to_owned(),
            path: study.path.clone(),
            study: study.text.clone(),
            scenarios: study.bases.clone(),
        }
    }

    /// Returns the manifest of a folder, if it has one.
    pub fn read(folder: &Path) -> Result<Option<Self>, Error> {
        let path = folder.join(NAME);
        if !path.exists() {
            return Ok(None);
        }
        let bytes = FileAccess::anywhere().read(&path, MOST_BYTES);
        let bytes = bytes.map_err(|fault| Error::read(&path, &fault))?;
        let manifest = serde_json::from_slice(&bytes);
        manifest.map(Some).map_err(|error| {
            Error::invalid(
                format!("`{}` was not written by a study: {error}", path.display()),
                "choose another folder; this one is not touched",
            )
        })
    }

    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        write_json(&folder.join(NAME), "the study", self)
    }

    /// Returns the study as stored.
    pub fn study(&self) -> Result<Study, Error> {
        let Self {
            study,
            path,
            scenarios,
            fingerprint,
            ..
        } = self;
        Study::as_it_was(
            study.clone(),
            path.clone(),
            scenarios.clone(),
            fingerprint.clone(),
        )
    }

    /// Rejects rows that cannot belong to a study.
    pub fn must_be(&self, study: &Study, folder: &Path) -> Result<(), Error> {
        let folder = folder.display();
        let running = env!("CARGO_PKG_VERSION");
        let message = if self.ilon != running {
            format!(
                "`{folder}` holds rows of ilon {}, and this is ilon {running}: they are not mixed",
                self.ilon
            )
        } else if self.name != study.name() {
            format!(
                "`{folder}` holds the results of another study, `{}`",
                self.name
            )
        } else if self.fingerprint != study.fingerprint() {
            format!(
                "`{folder}` holds the results of `{}` before it, its scenarios or its robots were changed",
                self.name
            )
        } else {
            return Ok(());
        };
        Err(Error::invalid(
            message,
            "choose another folder, or remove this one; nothing in it was touched",
        ))
    }
}
