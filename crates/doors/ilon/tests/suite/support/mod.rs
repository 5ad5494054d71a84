//! A working folder with scenarios and a robot, and the command run in it.

// Each test file uses a part of it.
#![allow(dead_code)]

pub mod browser;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A run of half a second without special events.
pub const SCENARIO: &str = "\
[robot]
file = \"ROBOT\"

[twist]
vx_m_s = 0.2
rest_s = 0.1
ramp_s = 0.1
settle_s = 0.1

[run]
duration_s = 0.5
";

/// An expectation that every such run meets.
pub const HOLDS: &str = "\n[expect]\ntwist_ratio_contact.vx = { min = 0.9, max = 1.1 }\n";

/// An expectation that none meets.
pub const FAILS: &str = "\n[expect]\ntwist_ratio_contact.vx = { max = -1 }\n";

/// A Python with these packages of `tests/requirements.txt`: that of `ILON_PYTHON`, or `python3`.
/// Without one it prints that the test is skipped.
pub fn python(packages: &str) -> Option<String> {
    let named = std::env::var("ILON_PYTHON").ok();
    let python = named.clone().unwrap_or("python3".into());
    let tried = Command::new(&python)
        .args(["-c", &format!("import {packages}")])
        .output();
    if tried.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    assert!(
        named.is_none(),
        "{python}, named by ILON_PYTHON, lacks {packages} of crates/doors/ilon/tests/requirements.txt"
    );
    println!("skipped: {python} lacks {packages} of crates/doors/ilon/tests/requirements.txt");
    None
}

pub struct Folder(tempfile::TempDir);

impl Folder {
    /// A folder with the scenario `good.toml`, which meets its expectation, and its robot.
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder to work in"));
        let robot =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots/volksbot.urdf");
        std::fs::copy(robot, folder.path("robot.urdf")).expect("the Volksbot");
        folder.scenario("good.toml", HOLDS);
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).expect("a file of the folder")
    }

    pub fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        let above = path.parent().expect("it is in the folder");
        std::fs::create_dir_all(above).expect("a folder of the folder");
        std::fs::write(path, text).expect("a file of the folder");
    }

    /// Writes a scenario with additional text.
    pub fn scenario(&self, name: &str, further: &str) {
        let robot = self.path("robot.urdf").display().to_string();
        let text = SCENARIO.replace("ROBOT", &robot);
        self.write(name, &format!("{text}{further}"));
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ilon"));
        command
            .current_dir(self.0.path())
            .args(arguments)
            .env_remove("CLICOLOR_FORCE");
        command
    }

    pub fn ilon(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the command runs")
    }

    /// The names in a subfolder, including hidden ones, in order.
    pub fn names(&self, name: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(name)).expect("a folder of the folder");
        let mut names: Vec<String> = entries
            .map(|entry| {
                let name = entry.expect("it can be read").file_name();
                name.to_string_lossy().into_owned()
            })
            .collect();
        names.sort();
        names
    }
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Asserts the exit code and returns the printed text.
pub fn ended_with(code: i32, output: &Output) -> String {
    let all = format!("{}{}", stdout(output), stderr(output));
    assert_eq!(output.status.code(), Some(code), "{all}");
    all
}
