//! Files of strangers: what they may read, and what reading them may cost.

mod common;

use std::fs;
use std::path::Path;

use common::{line_of, small};
use ilon_robot::{Fault, FileAccess, LoadOptions, Robot, Spec};

fn confined(folder: &Path) -> LoadOptions {
    LoadOptions {
        files: FileAccess::below([folder]).expect("it is there"),
        ..LoadOptions::default()
    }
}

#[test]
fn a_confined_robot_is_read_and_one_outside_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("in")).unwrap();
    fs::write(at("in/robot.urdf"), small()).unwrap();
    fs::write(at("robot.urdf"), small()).unwrap();
    let options = confined(&at("in"));
    assert!(Robot::load_with(at("in/robot.urdf"), &options).is_ok());
    let refused = Robot::load_with(at("in/../robot.urdf"), &options).unwrap_err();
    let told = refused.to_string();
    assert!(
        told.contains("it lies outside of what may be read here"),
        "{told}"
    );
}

/// A robot whose rollers are meshes of one triangle, which are read before they are found to be no rollers.
fn with_mesh(mesh: &str) -> String {
    let roller = roller_geometry();
    small().replace(&roller, &format!("<mesh filename=\"{mesh}\"/>"))
}

/// The geometry of the rollers of the small robot, which all have the same.
fn roller_geometry() -> String {
    let text = small();
    let start = text
        .find("<sphere")
        .expect("its rollers are stacks of spheres");
    let end = start + text[start..].find("/>").expect("it is closed") + 2;
    text[start..end].to_owned()
}

#[test]
fn the_meshes_of_a_confined_robot_are_confined_too() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("in")).unwrap();
    let triangle = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
                    endsolid a\n";
    for name in ["in/a.stl", "secret.stl"] {
        fs::write(at(name), triangle).unwrap();
    }
    let told = |mesh: &str, options: &LoadOptions| {
        fs::write(at("in/robot.urdf"), with_mesh(mesh)).unwrap();
        match Robot::load_with(at("in/robot.urdf"), options) {
            Ok(_) => String::new(),
            Err(error) => error.to_string(),
        }
    };
    let outside = "it lies outside of what may be read here";
    let absolute = format!("file://{}", at("secret.stl").display());
    let package = "package://p/../secret.stl";
    let options = LoadOptions {
        packages: vec![ilon_robot::Package {
            name: "p".to_owned(),
            folder: at("in"),
        }],
        ..confined(&at("in"))
    };
    for mesh in ["../secret.stl", absolute.as_str(), package] {
        let told = told(mesh, &options);
        assert!(told.contains(outside), "{mesh}: {told}");
    }
    // Inside it is read, and so is the other where all may be.
    let anywhere = LoadOptions::default();
    for (mesh, options) in [("a.stl", &options), ("../secret.stl", &anywhere)] {
        let told = told(mesh, options);
        assert!(!told.contains(outside), "{mesh}: {told}");
    }
}

#[cfg(feature = "xacro")]
#[test]
fn a_confined_xacro_file_is_not_expanded_for_what_it_includes_is_not_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("robot.urdf.xacro");
    let text = "<robot name=\"x\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:include filename=\"/etc/passwd\"/></robot>";
    fs::write(&path, text).unwrap();
    let refused = Robot::load_with(&path, &confined(folder.path())).unwrap_err();
    let told = refused.to_string();
    assert!(told.contains("xacro files may not be expanded"), "{told}");
}

#[test]
fn an_element_with_very_many_attributes_is_refused_before_they_are_compared() {
    let attributes =
        |count: usize| -> String { (0..count).map(|i| format!(" a{i}=\"{i}\"")).collect() };
    let with = |count| {
        small().replacen(
            "<link name=",
            &format!("<link{} name=", attributes(count)),
            1,
        )
    };
    // Compared pair by pair they would take half a minute.
    let text = with(200_000);
    let refused = Robot::from_urdf_str(&text, "small.urdf").unwrap_err();
    assert!(matches!(refused.fault(), Fault::TooLarge { .. }));
    assert_eq!(
        refused.to_string(),
        format!(
            "small.urdf:{}: too large to be read: an element with more than 1000 attributes, where at most 1000 are read",
            line_of(&text, "<link a0")
        )
    );
    assert!(Robot::from_urdf_str(&with(999), "small.urdf").is_ok());
    // Signs in a comment are no attributes.
    let comment = format!("<!-- {} --><link name=", attributes(5000));
    let commented = small().replacen("<link name=", &comment, 1);
    assert!(Robot::from_urdf_str(&commented, "small.urdf").is_ok());
}

#[cfg(unix)]
#[test]
fn a_description_without_an_end_is_refused() {
    let refused = Spec::load("/dev/zero").unwrap_err();
    assert_eq!(
        refused.to_string(),
        "/dev/zero: cannot be read: it is a device, not a file"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("big.toml");
    fs::File::create(&path).unwrap().set_len(1 << 30).unwrap();
    let told = Spec::load(&path).unwrap_err().to_string();
    assert!(
        told.ends_with("it is larger than 1 MB, the most that is read"),
        "{told}"
    );
}
