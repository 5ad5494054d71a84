//! The robots that ship with the project are what the generator writes from the descriptions beside them.
//!
//! After a change of a description or of the generator, write them again with
//! `cargo test -p ilon-robot --test assets -- --ignored` and look at what changed.

use std::path::{Path, PathBuf};

use ilon_robot::{Spec, generate};

const NAMES: [&str; 3] = ["mecanum4", "volksbot", "mecanum6"];

fn asset(name: &str, extension: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../assets/robots")
        .join(format!("{name}.{extension}"))
}

fn generated(name: &str) -> String {
    let spec = Spec::load(asset(name, "toml")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(spec.name, name, "a description is named as its file");
    generate(&spec).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn committed_robots_are_what_the_generator_writes() {
    for name in NAMES {
        let committed = std::fs::read_to_string(asset(name, "urdf")).expect("a committed robot");
        assert!(
            committed == generated(name),
            "assets/robots/{name}.urdf differs from what is generated from {name}.toml"
        );
    }
}

#[test]
#[ignore = "writes the robots again"]
fn write_committed_robots_again() {
    for name in NAMES {
        std::fs::write(asset(name, "urdf"), generated(name)).expect("writable assets");
    }
}
