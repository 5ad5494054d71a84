//! The archive.

use std::io::{Cursor, Read};
use std::path::Path;

use ilon_files::FileAccess;
use ilon_fmi::{Instance, MARK, package};
use zip::ZipArchive;

use super::instance::scenario;

/// A stand-in for the library, with what an exporter checks.
fn library(folder: &Path) -> std::path::PathBuf {
    let path = folder.join("library.so");
    std::fs::write(&path, format!("of {MARK}, and more")).unwrap();
    path
}

fn packed(path: &Path, library: &Path) -> Result<Vec<u8>, String> {
    package(path, &[], &FileAccess::anywhere(), library).map_err(|error| error.to_string())
}

#[test]
fn what_is_unpacked_elsewhere_is_the_same_robot() {
    let folder = tempfile::tempdir().unwrap();
    // A robot with meshes or waypoints beside it, a robot description in TOML, and the paper's
    // robot.
    for name in [
        "mecanum4_waypoints.toml",
        "optiodom_lateral.toml",
        "volksbot_position_first.toml",
    ] {
        let bytes = packed(&scenario(name), &library(folder.path())).unwrap();
        let mut archive = ZipArchive::new(Cursor::new(bytes)).unwrap();
        let there = folder.path().join(name);
        archive.extract(&there).unwrap();
        let license = archive.by_name("documentation/licenses/LICENSE-APACHE");
        assert!(license.unwrap().size() > 9_000, "the whole text");
        let mut xml = String::new();
        archive
            .by_name("modelDescription.xml")
            .unwrap()
            .read_to_string(&mut xml)
            .unwrap();
        let document = roxmltree::Document::parse(&xml).unwrap();
        let root = document.root_element();
        let token = root.attribute("instantiationToken").unwrap();
        let instance = Instance::open(&there.join("resources"), token).unwrap();
        let described = root
            .descendants()
            .filter(|node| node.has_attribute("causality"));
        let described: Vec<_> = described
            .map(|node| node.attribute("name").unwrap())
            .collect();
        let held: Vec<_> = instance
            .variables()
            .iter()
            .map(|of| of.name.as_str())
            .collect();
        assert_eq!(described, held);
        // Parameters have the unit of their key, and each unit is defined.
        let units = root.descendants().filter(|node| node.has_tag_name("Unit"));
        let defined: Vec<_> = units.filter_map(|unit| unit.attribute("name")).collect();
        for of in root.descendants() {
            let unit = of.attribute("unit");
            assert!(unit.is_none_or(|unit| defined.contains(&unit)), "{unit:?}");
            let is_real = of.has_tag_name("Float64");
            match of.attribute("name").unwrap_or_default() {
                name if is_real && name.starts_with("scenario.") && name.ends_with("_m") => {
                    assert!(
                        ["m", "N.m", "N/m", "N.s/m"].contains(&unit.unwrap()),
                        "{name}"
                    );
                }
                name if name.starts_with("scenario.") && name.ends_with(".friction") => {
                    assert_eq!(unit, None);
                }
                _ => {}
            }
        }
        assert!(Instance::open(&there.join("resources"), "{0}").is_err());
        // The archive holds no path of this machine.
        let text = std::fs::read_to_string(there.join("resources/scenario.toml")).unwrap();
        assert!(!text.contains(".."), "{text}");
    }
}

#[test]
fn the_same_input_makes_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let library = library(folder.path());
    let path = scenario("mecanum4_lateral.toml");
    assert_eq!(
        packed(&path, &library).unwrap(),
        packed(&path, &library).unwrap()
    );
}

#[test]
fn a_library_of_something_else_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.so");
    let scenario = scenario("mecanum4_lateral.toml");
    assert!(packed(&scenario, &path).unwrap_err().contains("other.so"));
    std::fs::write(&path, "ilon functional mock-up unit 0.0.1").unwrap();
    assert!(
        packed(&scenario, &path)
            .unwrap_err()
            .contains("not ilon's library of version")
    );
}
