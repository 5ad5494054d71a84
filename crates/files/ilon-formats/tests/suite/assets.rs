//! The shipped robots are the generator's output for the descriptions beside them.
//!
//! After a change of a description or of the generator, write them again with
//! `cargo test -p ilon-robot --test suite assets:: -- --ignored` and check the changes.

use std::path::{Path, PathBuf};

use ilon_formats::{Spec, generate};

const NAMES: [&str; 9] = [
    "mecanum4",
    "mecanum4_6_rollers",
    "mecanum4_12_rollers",
    "mecanum4_payload",
    "mecanum4_hard_rollers",
    "volksbot",
    "mecanum6",
    "optiodom",
    "mecanum4_arms",
];

fn asset(name: &str, extension: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../assets/robots")
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
        if let Some((wrote, holds)) = first_difference(&generated(name), &committed) {
            panic!(
                "assets/robots/{name}.urdf holds {holds} where {wrote} is generated from {name}.toml"
            );
        }
    }
}

/// The first words that differ, numbers by more than a relative 1e-13: sines and roots may be
/// rounded differently on another machine, and the files hold fifteen digits.
fn first_difference<'a>(p: &'a str, q: &'a str) -> Option<(&'a str, &'a str)> {
    let words = |text: &'a str| text.split([' ', '"', '\n']);
    let alike = |(a, b): &(&str, &str)| {
        a == b
            || matches!((a.parse::<f64>(), b.parse::<f64>()), (Ok(x), Ok(y)) if (x - y).abs() <= 1e-13 * x.abs())
    };
    let ends = [("the end", "more"), ("more", "the end")];
    let by_length = match words(p).count().cmp(&words(q).count()) {
        std::cmp::Ordering::Equal => None,
        std::cmp::Ordering::Less => Some(ends[0]),
        std::cmp::Ordering::Greater => Some(ends[1]),
    };
    words(p)
        .zip(words(q))
        .find(|pair| !alike(pair))
        .or(by_length)
}

#[test]
#[ignore = "writes the robots again"]
fn write_committed_robots_again() {
    for name in NAMES {
        std::fs::write(asset(name, "urdf"), generated(name)).expect("writable assets");
    }
}
