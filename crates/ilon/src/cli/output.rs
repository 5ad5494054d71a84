//! The folder of results. Files appear whole or not at all, and the summary last: where there is one, all is there.

use std::path::{Path, PathBuf};

use crate::simulate::Run;
use crate::{Error, report};

/// A folder that results can be written to.
#[derive(Debug)]
pub(super) struct OutputFolder {
    path: PathBuf,
}

impl OutputFolder {
    /// Makes sure, before anything is simulated, that the folder is there and can be written to.
    pub fn prepare(path: PathBuf) -> Result<Self, Error> {
        std::fs::create_dir_all(&path).map_err(|source| Error::write(&path, &source))?;
        let probe = path.join(format!(".ilon-{}", std::process::id()));
        std::fs::write(&probe, b"")
            .and_then(|()| std::fs::remove_file(&probe))
            .map_err(|source| Error::write(&path, &source))?;
        Ok(Self { path })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes scenario, trace, report and summary.
    pub fn write(&self, run: &Run) -> Result<(), Error> {
        let summary_path = self.path.join("summary.json");
        // An older summary would make the new files look complete before they are.
        if summary_path.exists() {
            std::fs::remove_file(&summary_path)
                .map_err(|source| Error::write(&summary_path, &source))?;
        }
        let text =
            |name: &str, text: &str| ilon_trace::file::write_text(&self.path.join(name), text);
        text(
            "scenario.toml",
            &run.scenario.moved_to(&self.path).to_toml()?,
        )?;
        run.trace.write_parquet(&self.path.join("trace.parquet"))?;
        report::write(&self.path.join("report.html"), &run.trace, &run.summary)?;
        text("summary.json", &self.summary_json(run)?)?;
        Ok(())
    }

    /// The content of `summary.json`.
    pub fn summary_json(&self, run: &Run) -> Result<String, Error> {
        let json = serde_json::to_string_pretty(&run.summary)
            .map_err(|error| Error::invalid(error.to_string(), ""))?;
        Ok(json + "\n")
    }
}
