//! The robots of a folder side by side on one page.

use crate::support;

use support::{Folder, ended_with, stderr, stdout};

/// A folder with a valid robot, one that needs an option, an invalid one, and files that are no
/// robots.
fn collection() -> Folder {
    let folder = Folder::new();
    let robot = folder.read("robot.urdf");
    folder.write("in/good.urdf", &robot);
    let heavy = robot.replacen("<mass value=", "<mass unknown=", 1);
    folder.write("in/deeper/<b>odd.urdf", &heavy);
    folder.write(
        "in/arm.urdf",
        "<robot name=\"arm\"><link name=\"a\"/></robot>",
    );
    folder.write("in/settings.xml", "<launch/>");
    folder.write("in/.hidden/robot.urdf", &robot);
    folder.write("in/notes.txt", "none");
    folder
}

#[test]
fn the_robots_of_a_folder_stand_on_one_page() {
    let folder = collection();
    let shown = folder.ilon(&["inspect", "in", "--html", "robots.html"]);
    ended_with(0, &shown);
    let said = stdout(&shown);
    assert!(said.contains("good.urdf: 3 wheels\n"), "{said}");
    assert!(
        said.contains("odd.urdf: 3 wheels, with options\n"),
        "{said}"
    );
    assert!(said.contains("arm.urdf: refused: "), "{said}");
    assert!(
        !said.contains("settings.xml") && !said.contains("hidden"),
        "{said}"
    );
    let page = folder.read("robots.html");
    for fact in [
        "<b>1</b> read without options",
        "<b>1</b> with options",
        "<b>1</b> refused",
    ] {
        assert!(page.contains(fact), "{fact}");
    }
    // Two robots are drawn, and the working options are named; names are not markup.
    assert_eq!(page.matches("seen from above").count(), 2);
    assert!(page.contains("--repair`"));
    assert!(!page.contains("<b>odd"));
    // The page is self-contained.
    assert!(page.len() < 200_000, "{}", page.len());
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http"));
}

/// A folder in which no robot is read has no table of robots, and says why each is refused.
#[test]
fn a_folder_of_refused_robots_has_no_empty_table() {
    let folder = Folder::new();
    folder.write(
        "in/arm.urdf",
        "<robot name=\"arm\"><link name=\"a\"/></robot>",
    );
    ended_with(0, &folder.ilon(&["inspect", "in", "--html", "robots.html"]));
    let page = folder.read("robots.html");
    assert!(page.contains("<b>1</b> refused") && !page.contains("<table"));
}

#[test]
fn one_robot_may_be_shown_alone_and_a_folder_only_as_a_page() {
    let folder = collection();
    ended_with(
        0,
        &folder.ilon(&["inspect", "in/good.urdf", "--html", "one.html"]),
    );
    let page = folder.read("one.html");
    assert!(page.contains("id=\"scene-data\"") && page.contains("ilonScene"));
    assert!(page.contains("seen from above") && page.contains("How far the rollers let it go"));
    // One turn of the wheels in 240 parts.
    assert!(page.contains("\"count\":241"));
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http"));
    let refused = folder.ilon(&["inspect", "in"]);
    ended_with(2, &refused);
    assert!(
        stderr(&refused).contains("--html FILE"),
        "{}",
        stderr(&refused)
    );
    folder.write("empty/notes.txt", "");
    let refused = folder.ilon(&["inspect", "empty", "--html", "none.html"]);
    ended_with(2, &refused);
    assert!(
        stderr(&refused).contains("holds no robots"),
        "{}",
        stderr(&refused)
    );
    assert!(!folder.path("none.html").exists());
}

#[cfg(unix)]
#[test]
fn a_folder_that_leads_into_itself_has_an_end() {
    let folder = collection();
    std::os::unix::fs::symlink(folder.path("in"), folder.path("in/deeper/again")).unwrap();
    let shown = folder.ilon(&["inspect", "in", "--html", "robots.html"]);
    ended_with(0, &shown);
    assert_eq!(stdout(&shown).matches("good.urdf").count(), 1);
}
