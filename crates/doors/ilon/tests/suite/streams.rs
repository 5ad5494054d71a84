//! Standard output and standard error in pipes and on full disks: a closed or full stream never
//! costs a run.

use crate::support;

use std::fs::File;
use std::process::{Command, Stdio};

use support::{Folder, HOLDS};

/// The four files of a complete run.
const WHOLE: [&str; 4] = [
    "report.html",
    "scenario.toml",
    "summary.json",
    "trace.parquet",
];

/// Runs a command whose standard error is closed, as behind `2>&1 | head -1`; returns its exit
/// code.
fn unheard(mut command: Command) -> Option<i32> {
    let mut child = command
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command runs");
    drop(child.stderr.take());
    child.wait().expect("it ends").code()
}

#[test]
fn a_run_that_nobody_listens_to_writes_all_its_results() {
    let folder = Folder::new();
    let code = unheard(folder.command(&["run", "good.toml", "--out", "results"]));
    assert_eq!(code, Some(0));
    assert_eq!(folder.names("results"), WHOLE);
}

#[test]
fn what_is_wrong_ends_with_its_code_though_nobody_reads_what_it_is() {
    let folder = Folder::new();
    let bad: [&[&str]; 5] = [
        &["run", "nowhere.toml"],
        &["check", "good.toml", "nowhere.toml"],
        &["inspect", "good.toml"],
        &["compare", "good.toml", "nowhere"],
        &["generate", "good.toml"],
    ];
    for arguments in bad {
        assert_eq!(unheard(folder.command(arguments)), Some(2), "{arguments:?}");
    }
    assert_eq!(unheard(folder.command(&["check", "good.toml"])), Some(0));
    let measured = [
        "bench",
        "--robot",
        "robot.urdf",
        "--rates",
        "20",
        "--rounds",
        "1",
        "--headings",
        "0",
    ];
    assert_eq!(unheard(folder.command(&measured)), Some(0));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_standard_error_costs_nothing_and_behind_standard_output_is_told() {
    let folder = Folder::new();
    let full = || {
        File::options()
            .write(true)
            .open("/dev/full")
            .expect("it takes nothing")
    };
    let mut run = folder.command(&["run", "good.toml", "--out", "a"]);
    let status = run.stdout(Stdio::null()).stderr(full()).status();
    assert_eq!(status.expect("it runs").code(), Some(0));
    assert_eq!(folder.names("a"), WHOLE);
    let mut run = folder.command(&["run", "good.toml", "--out", "b"]);
    let status = run.stdout(full()).stderr(Stdio::null()).status();
    assert_eq!(status.expect("it runs").code(), Some(2));
    // The results exist; only the table could not be printed.
    assert_eq!(folder.names("b"), WHOLE);
    // Help and version are requested output, too.
    for asked in [
        &["--help"][..],
        &["--version"],
        &["help"],
        &["run", "--help"],
    ] {
        let mut help = folder.command(asked);
        let status = help.stdout(full()).stderr(Stdio::null()).status();
        assert_eq!(status.expect("it runs").code(), Some(2), "{asked:?}");
    }
}

#[test]
fn a_reader_of_standard_output_that_has_gone_is_no_fault() {
    let folder = Folder::new();
    folder.scenario("again.toml", HOLDS);
    let mut child = folder
        .command(&["check", "good.toml", "again.toml"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command runs");
    drop(child.stdout.take());
    assert_eq!(child.wait().expect("it ends").code(), Some(0));
}
