//! A folder in which scenarios are run.

pub mod urdf;

use std::path::{Path, PathBuf};

use ilon_sim::Error;

/// A folder with a scenario of half a second, and the description of its robot.
pub struct Folder(tempfile::TempDir);

pub const SCENARIO: &str = "robot.file = \"mecanum4.toml\"\n[twist]\nvy_m_s = 0.3\nrest_s = 0.1\nramp_s = 0.1\nsettle_s = 0.1\n\
                        [run]\nduration_s = 0.5\n";

impl Folder {
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots");
        std::fs::copy(robots.join("mecanum4.toml"), folder.path("mecanum4.toml")).unwrap();
        folder.write("base.toml", SCENARIO);
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        std::fs::write(self.path(name), text).unwrap();
        self.path(name)
    }
}

pub fn message(result: Result<impl std::fmt::Debug, Error>) -> (String, String) {
    match result.unwrap_err() {
        Error::Scenario(fault) => (fault.message.clone(), fault.help.clone()),
        Error::Invalid { message, help } => (message, help),
        other => (other.to_string(), String::new()),
    }
}
