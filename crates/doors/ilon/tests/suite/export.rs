//! `ilon export`: the written files, and refusals before anything is written.

use crate::support::{Folder, ended_with};

/// A stand-in for the library, with what the exporter checks.
fn with_library() -> Folder {
    let folder = Folder::new();
    folder.write("library.so", &format!("of {}, and more", ilon_fmi::MARK));
    folder
}

#[test]
fn an_fmu_is_written_beside_the_caller_and_nothing_else() {
    let folder = with_library();
    let export = ["export", "--fmu", "good.toml", "--library", "library.so"];
    let said = ended_with(0, &folder.ilon(&export));
    assert!(said.contains("good.fmu"), "{said}");
    let mut names = folder.names(".");
    names.sort();
    assert_eq!(names, ["good.fmu", "good.toml", "library.so", "robot.urdf"]);
    let bytes = std::fs::read(folder.path("good.fmu")).unwrap();
    assert_eq!(bytes[..4], *b"PK\x03\x04");
    // A changed key is changed in the FMU.
    let other = [
        &export[..],
        &["--set", "world.floor.friction=0.3", "--out", "other.fmu"],
    ]
    .concat();
    ended_with(0, &folder.ilon(&other));
    assert_ne!(std::fs::read(folder.path("other.fmu")).unwrap(), bytes);
}

#[test]
fn what_cannot_be_exported_is_refused_in_words_and_nothing_is_written() {
    let folder = with_library();
    for (arguments, words) in [
        (
            &["--fmu", "good.toml", "--library", "none.so"][..],
            "none.so",
        ),
        (
            &["--fmu", "good.toml", "--library", "robot.urdf"],
            "not ilon's library",
        ),
        (
            &["--fmu", "none.toml", "--library", "library.so"],
            "none.toml",
        ),
        (
            &["--fmu", "robot.urdf", "--library", "library.so"],
            "robot.urdf",
        ),
        (
            &[
                "--fmu",
                "good.toml",
                "--library",
                "library.so",
                "--out",
                "good.toml",
            ],
            "good.toml",
        ),
        (
            &[
                "--fmu",
                "good.toml",
                "--library",
                "library.so",
                "--sandbox",
                "elsewhere",
            ],
            "elsewhere",
        ),
        (&[], "--fmu"),
    ] {
        let said = ended_with(2, &folder.ilon(&[&["export"], arguments].concat()));
        assert!(said.contains(words), "{arguments:?}: {said}");
    }
    // Without a built library, the message says how to build it.
    let command = std::path::Path::new(env!("CARGO_BIN_EXE_ilon"));
    let name = format!(
        "{}ilon_c{}",
        std::env::consts::DLL_PREFIX,
        std::env::consts::DLL_SUFFIX
    );
    if !command.with_file_name(name).exists() {
        let said = ended_with(2, &folder.ilon(&["export", "--fmu", "good.toml"]));
        assert!(said.contains("cargo build --release -p ilon-c"), "{said}");
    }
    assert!(!folder.path("good.fmu").exists() && folder.read("good.toml").contains("robot"));
}
