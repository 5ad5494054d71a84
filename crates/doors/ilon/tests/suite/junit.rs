//! The output of `ilon check --junit` conforms to Jenkins's schema junit-10.xsd (xunit-plugin),
//! restated here as rules.

use std::path::Path;
use std::process::Command;

use roxmltree::{Document, Node};

/// The schema's rule for an element: its attributes and whether they are required, its children,
/// and whether it may hold text. Only elements that `ilon check` uses are listed.
struct Rule {
    element: &'static str,
    attributes: &'static [(&'static str, bool)],
    children: &'static [&'static str],
    may_hold_text: bool,
}

const REASON: &[(&str, bool)] = &[("type", false), ("message", false)];

const RULES: [Rule; 6] = [
    Rule {
        element: "testsuites",
        attributes: &[
            ("name", false),
            ("time", false),
            ("tests", false),
            ("failures", false),
            ("errors", false),
        ],
        children: &["testsuite"],
        may_hold_text: false,
    },
    Rule {
        element: "testsuite",
        attributes: &[
            ("name", true),
            ("tests", true),
            ("failures", true),
            ("errors", true),
            ("group", false),
            ("time", false),
            ("skipped", false),
            ("timestamp", false),
            ("hostname", false),
            ("id", false),
            ("package", false),
            ("file", false),
            ("log", false),
            ("url", false),
        ],
        children: &["testcase"],
        may_hold_text: false,
    },
    Rule {
        element: "testcase",
        attributes: &[
            ("name", true),
            ("time", false),
            ("classname", false),
            ("group", false),
        ],
        children: &["skipped", "error", "failure"],
        may_hold_text: false,
    },
    Rule {
        element: "failure",
        attributes: REASON,
        children: &[],
        may_hold_text: true,
    },
    Rule {
        element: "error",
        attributes: REASON,
        children: &[],
        may_hold_text: true,
    },
    Rule {
        element: "skipped",
        attributes: REASON,
        children: &[],
        may_hold_text: true,
    },
];

/// Violations of the schema by an element and all below it.
fn breaches(node: Node, found: &mut Vec<String>) {
    let name = node.tag_name().name();
    let Some(rule) = RULES.iter().find(|rule| rule.element == name) else {
        found.push(format!("<{name}> is unknown"));
        return;
    };
    for attribute in node.attributes() {
        let known = rule
            .attributes
            .iter()
            .any(|(known, _)| *known == attribute.name());
        if !known {
            found.push(format!("<{name} {}> is unknown", attribute.name()));
        }
        // Digits with at most one point: the schema allows any text in a test case, but a time is
        // meant.
        if attribute.name() == "time" && attribute.value().parse::<f64>().is_err() {
            found.push(format!("{} is no time", attribute.value()));
        }
    }
    for (needed, _) in rule.attributes.iter().filter(|(_, is_needed)| *is_needed) {
        if !node.has_attribute(*needed) {
            found.push(format!("<{name}> lacks {needed}"));
        }
    }
    for child in node.children() {
        if child.is_element() {
            if !rule.children.contains(&child.tag_name().name()) {
                found.push(format!("<{}> stands in <{name}>", child.tag_name().name()));
            }
            breaches(child, found);
        } else if !rule.may_hold_text && child.text().is_some_and(|text| !text.trim().is_empty()) {
            found.push(format!("<{name}> holds text"));
        }
    }
}

/// Runs `ilon check` in a folder with scenarios that hold, fail and cannot run; returns what it
/// wrote.
fn junit(further: &[&str]) -> String {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets/robots/volksbot.urdf");
    let scenario = |expect: &str| {
        format!(
            "[robot]\nfile = '{}'\nroller_bodies = 'near'\n[twist]\nvx_m_s = 0\n[run]\nduration_s = 0.1\n\
             [expect]\nduration_s = {{ {expect} }}\n",
            robot.display()
        )
    };
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("a scenario");
    };
    // In the order of their names, which is the order in which one thread begins them.
    write("1_held <&>.toml", &scenario("max = 0.2"));
    write("2_fails.toml", &scenario("min = 1"));
    // Quotes, brackets and a control character, which XML cannot hold at all.
    write(
        "3_broken.toml",
        "[robot]\nfile = \"<a&'\\\"\\u001B[31m>.urdf\"\n[twist]\n[run]\nduration_s = 1\n",
    );
    Command::new(env!("CARGO_BIN_EXE_ilon"))
        .current_dir(folder.path())
        .env("RAYON_NUM_THREADS", "1")
        .args(["check", ".", "--junit", "results.xml"])
        .args(further)
        .output()
        .expect("the command runs");
    std::fs::read_to_string(folder.path().join("results.xml")).expect("it was written")
}

/// The kinds of results, in the order of the test cases.
fn endings(document: &Document) -> Vec<String> {
    let cases = document
        .descendants()
        .filter(|node| node.has_tag_name("testcase"));
    cases
        .map(|case| {
            let ending = case.first_element_child();
            ending
                .map_or("held", |child| child.tag_name().name())
                .to_owned()
        })
        .collect()
}

#[test_case::test_case(&[], &["held", "failure", "error"], ["3", "1", "1", "0"]; "all")]
#[test_case::test_case(&["--fail-fast"], &["held", "failure", "skipped"], ["3", "1", "0", "1"]; "fail fast")]
fn what_is_written_keeps_to_the_schema_and_counts_right(
    further: &[&str],
    expected: &[&str],
    counts: [&str; 4],
) {
    let text = junit(further);
    let document = Document::parse(&text).expect("well-formed XML");
    let root = document.root_element();
    assert_eq!(root.tag_name().name(), "testsuites");
    let mut found = Vec::new();
    breaches(root, &mut found);
    assert!(found.is_empty(), "{found:?}\n{text}");

    assert_eq!(endings(&document), expected, "{text}");
    let suite = root.first_element_child().expect("a suite");
    let told = ["tests", "failures", "errors", "skipped"].map(|name| suite.attribute(name));
    assert_eq!(told, counts.map(Some), "{text}");
    let name = suite
        .first_element_child()
        .and_then(|case| case.attribute("name"));
    assert_eq!(name, Some("1_held <&>"));
}

#[test]
fn the_rules_notice_what_the_schema_forbids() {
    for (text, breach) in [
        (
            "<testsuites skipped='0'/>",
            "<testsuites skipped> is unknown",
        ),
        (
            "<testsuites><testsuite name='a' tests='0' errors='0'/></testsuites>",
            "<testsuite> lacks failures",
        ),
        (
            "<testsuites><testcase name='a' time='0.1'/></testsuites>",
            "<testcase> stands in <testsuites>",
        ),
        ("<testsuites>text</testsuites>", "<testsuites> holds text"),
    ] {
        let document = Document::parse(text).expect("well-formed XML");
        let mut found = Vec::new();
        breaches(document.root_element(), &mut found);
        assert_eq!(found, [breach]);
    }
}
