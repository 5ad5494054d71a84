//! Untrusted files: which files they may read, and the cost of reading them.

use crate::common;

use std::fs;
use std::path::Path;

use common::{line_of, small};
use ilon_files::FileAccess;
use ilon_formats::{Fault, LoadOptions, LoadRobot, Spec};
use ilon_robot::Robot;

fn confined(folder: &Path) -> LoadOptions {
    let mut options = LoadOptions::default();
    options.files = FileAccess::below([folder]).expect("it is there");
    options
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

/// A robot whose rollers are meshes of one triangle, which are read before they are found to be no
/// rollers.
fn with_mesh(mesh: &str) -> String {
    let roller = roller_geometry();
    small().replace(&roller, &format!("<mesh filename=\"{mesh}\"/>"))
}

/// The geometry of the rollers of the small robot, which is the same for all.
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
    let mut options = confined(&at("in"));
    options.packages = vec![ilon_formats::Package {
        name: "p".to_owned(),
        folder: at("in"),
    }];
    for mesh in ["../secret.stl", absolute.as_str(), package] {
        let told = told(mesh, &options);
        assert!(told.contains(outside), "{mesh}: {told}");
    }
    // Inside it is read, and so is the other if all files may be.
    let anywhere = LoadOptions::default();
    for (mesh, options) in [("a.stl", &options), ("../secret.stl", &anywhere)] {
        let told = told(mesh, options);
        assert!(!told.contains(outside), "{mesh}: {told}");
    }
}

/// A xacro file: the small robot with additional content.
fn xacro(more: &str) -> String {
    let text = small().replacen(
        "<robot ",
        "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" ",
        1,
    );
    text.replace("</robot>", &format!("{more}</robot>"))
}

#[test]
fn what_a_confined_xacro_file_includes_is_confined_too() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("in/p")).unwrap();
    fs::create_dir_all(at("q")).unwrap();
    let part = "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><link name=\"more\"/></robot>";
    for name in [
        "in/part.xacro",
        "in/p/part.xacro",
        "q/part.xacro",
        "part.xacro",
    ] {
        fs::write(at(name), part).unwrap();
    }
    for name in ["in/some.yaml", "some.yaml"] {
        fs::write(at(name), "a: 1").unwrap();
    }
    let path = at("in/robot.xacro");
    let read = |more: &str, options: &LoadOptions| {
        fs::write(&path, xacro(more)).unwrap();
        Robot::load_with(&path, options).map_err(|error| error.to_string())
    };
    let include = |name: &str| format!("<xacro:include filename=\"{name}\"/>");
    let yaml = |name: &str| {
        format!("<xacro:property name=\"x\" value=\"${{xacro.load_yaml('{name}')}}\"/>${{x}}")
    };
    let absolute = at("part.xacro").display().to_string();
    let options = confined(&at("in"));
    for outside in [
        include("../part.xacro"),
        include(&absolute),
        include("$(find p)/../../part.xacro"),
        yaml("../some.yaml"),
    ] {
        let refused = read(&outside, &options).expect_err(&outside);
        assert!(
            refused.contains("lies outside of what may be read"),
            "{outside}: {refused}"
        );
        // If all files may be read, it is no fault.
        let anywhere = read(&outside, &LoadOptions::default());
        assert!(
            !anywhere.is_err_and(|e| e.contains("lies outside")),
            "{outside}"
        );
    }
    // A package outside is not found, and patterns find nothing there.
    let refused = read(&include("$(find q)/part.xacro"), &options).unwrap_err();
    assert!(refused.contains("`q`"), "{refused}");
    let pattern = read(&include("../*.xacro"), &options).unwrap();
    let said = |words: &str| pattern.robot.remarks.iter().any(|r| r.text.contains(words));
    assert!(said("no file matches"));
    for inside in [
        include("part.xacro"),
        include("$(find p)/part.xacro"),
        yaml("some.yaml"),
    ] {
        let refused = read(&inside, &options).err();
        assert!(
            !refused
                .as_ref()
                .is_some_and(|e| e.contains("outside") || e.contains("not known")),
            "{inside}: {refused:?}"
        );
    }
}

#[test]
fn a_confined_xacro_file_sees_nothing_of_the_environment() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("robot.xacro");
    for secret in [
        "$(env PATH)",
        "$(optenv PATH none)",
        "$(optenv NOT_THERE none)",
        "$(cwd)",
    ] {
        fs::write(&path, xacro(&format!("<material name=\"{secret}\"/>"))).unwrap();
        assert!(
            Robot::load_with(&path, &LoadOptions::default()).is_ok(),
            "{secret}"
        );
        let refused = Robot::load_with(&path, &confined(folder.path())).unwrap_err();
        assert!(
            refused
                .to_string()
                .contains("where only some files may be read"),
            "{refused}"
        );
    }
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
            "small.urdf:{}: too large to be read: an element with more than 200 attributes, where at most 200 are read",
            line_of(&text, "<link a0")
        )
    );
    assert!(Robot::from_urdf_str(&with(199), "small.urdf").is_ok());
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
