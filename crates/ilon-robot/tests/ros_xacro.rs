//! Which files the xacro of ROS is asked about, where a program has it: those whose language ilon's own expander does not know, and no
//! others.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use ilon_robot::{FileAccess, FindPackage, LoadOptions, use_ros_xacro};

/// A file that it was asked about, with the arguments, and where the package `near` lies.
type Asked = (PathBuf, BTreeMap<String, String>, Option<PathBuf>);

static ASKED: Mutex<Vec<Asked>> = Mutex::new(Vec::new());

const EXPANDED: &str = "<robot name=\"by_ros\"><link name=\"a\"/></robot>";

/// Expands every file to the same robot, but for those that are called so.
fn expand(
    path: &Path,
    arguments: &BTreeMap<String, String>,
    find: FindPackage,
) -> Option<(String, String)> {
    let mut asked = ASKED.lock().expect("no test broke down");
    asked.push((path.to_owned(), arguments.clone(), find("near")));
    let refuses = path.ends_with("refused.xacro");
    (!refuses).then(|| (EXPANDED.to_owned(), "xacro 0".to_owned()))
}

/// What a file expands to in a folder of its own, and whether the xacro of ROS was asked.
fn expanded(
    name: &str,
    body: &str,
    options: impl Fn(&Path) -> LoadOptions,
) -> (Result<String, String>, bool) {
    use_ros_xacro(expand);
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("near")).expect("a folder");
    let path = folder.path().join(name);
    let text =
        format!("<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">{body}</robot>");
    std::fs::write(&path, text).expect("a file");
    let result = ilon_robot::urdf_text(&path, &options(folder.path()));
    let asked = ASKED.lock().expect("no test broke down");
    let mine = asked.iter().find(|(asked, ..)| *asked == path);
    if let Some((_, _, near)) = mine {
        assert_eq!(near.as_deref(), Some(folder.path().join("near").as_path()));
    }
    (result.map_err(|error| error.to_string()), mine.is_some())
}

/// What only Python itself knows.
const OF_PYTHON: &str = "<link name=\"${int('0x10', 16)}\"/>";

fn usual(_: &Path) -> LoadOptions {
    LoadOptions::default()
}

#[test]
fn it_is_asked_about_a_language_that_is_not_known() {
    assert_eq!(
        expanded("a.xacro", OF_PYTHON, usual),
        (Ok(EXPANDED.to_owned()), true)
    );
}

#[test]
fn what_is_expanded_here_is_not_shown_to_it() {
    let (text, asked) = expanded("a.xacro", "<link name=\"${1 + 1}\"/>", usual);
    assert!(text.is_ok_and(|text| text.contains("\"2\"")) && !asked);
}

#[test]
fn what_it_refuses_too_is_refused_in_the_words_of_this_one() {
    let (text, asked) = expanded("refused.xacro", OF_PYTHON, usual);
    assert!(asked);
    let words = text.unwrap_err();
    assert!(words.contains("invalid literal for int()"), "{words}");
}

#[test_case::test_case("<xacro:include filename=\"gone.xacro\"/>"; "missing")]
#[test_case::test_case("<xacro:include filename=\"gone.xacro\"/><xacro:wheel/>"; "missing by a name")]
#[test_case::test_case("<link name=\"$(arg undeclared)\"/>"; "argument")]
#[test_case::test_case("<link name=\"a\">"; "no xml")]
fn what_is_missing_or_no_xml_is_not_shown_to_it(body: &str) {
    let (text, asked) = expanded("a.xacro", body, usual);
    assert!(text.is_err() && !asked, "{text:?}");
}

#[test]
fn a_file_of_a_sandbox_is_not_shown_to_it() {
    let confined = |folder: &Path| {
        let mut options = LoadOptions::default();
        options.files = FileAccess::below([folder]).expect("the folder is there");
        options
    };
    let (text, asked) = expanded("a.xacro", OF_PYTHON, confined);
    assert!(text.is_err() && !asked);
}
