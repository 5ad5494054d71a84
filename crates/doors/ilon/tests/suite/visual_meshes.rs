//! The visual meshes of a robot are stored with its trace, and change nothing else.

use crate::support;

use support::{Folder, ended_with};

const MESH: &str = "<visual><geometry><mesh filename=\"part.obj\"/></geometry></visual>";

fn hash(folder: &Folder, run: &str) -> String {
    let summary: serde_json::Value =
        serde_json::from_str(&folder.read(&format!("{run}/summary.json"))).expect("a summary");
    summary["trace_hash"].as_str().expect("a hash").to_owned()
}

#[test]
fn a_picture_needs_nothing_but_the_trace_and_the_hash_does_not_know_of_it() {
    let folder = Folder::new();
    ended_with(0, &folder.ilon(&["run", "good.toml", "--out", "plain"]));
    let robot = folder.read("robot.urdf");
    let shown = robot.replacen("<visual>", &format!("{MESH}<visual>"), 1);
    assert_ne!(robot, shown);
    folder.write("robot.urdf", &shown);
    folder.write(
        "part.obj",
        "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n",
    );
    ended_with(0, &folder.ilon(&["run", "good.toml", "--out", "seen"]));
    assert_eq!(hash(&folder, "plain"), hash(&folder, "seen"));
    let carried = |page: &str| folder.read(page).contains("\"name\":\"part.obj\"");
    assert!(carried("seen/report.html") && !carried("plain/report.html"));

    std::fs::remove_file(folder.path("part.obj")).expect("it is there");
    ended_with(0, &folder.ilon(&["report", "seen"]));
    assert!(carried("seen/report.html"), "the trace has it");

    ended_with(0, &folder.ilon(&["run", "good.toml", "--out", "gone"]));
    let page = folder.read("gone/report.html");
    assert!(page.contains("The mesh `part.obj` is not drawn: there is no such file"));
    assert_eq!(hash(&folder, "plain"), hash(&folder, "gone"));
}
