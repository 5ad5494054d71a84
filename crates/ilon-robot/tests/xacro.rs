//! xacro: what ilon makes of the cases in `tests/xacro` is what the xacro of ROS makes of them (`real.py` there compares the two), and
//! what has no end is ended.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::options;
use ilon_robot::{LoadOptions, Package, urdf_text};
use roxmltree::{Document, Node};

const HEAD: &str = r#"<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">"#;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/xacro")
}

fn with_package() -> LoadOptions {
    options(|o| {
        o.packages.push(Package {
            name: "a_robot".to_owned(),
            folder: folder().join("packages/a_robot"),
        });
    })
}

/// A text in quotes, as JSON has it.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            '\n' => quoted.push_str("\\n"),
            '\t' => quoted.push_str("\\t"),
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

/// The lines of an element in the normal form that `real.py` describes.
fn normal(text: &str, node: Node, depth: usize, lines: &mut String) {
    let qualified = |at: usize| {
        let rest = &text[at..];
        let end = rest.find(|c: char| c.is_whitespace() || "=/>".contains(c));
        rest[..end.unwrap_or(rest.len())].to_owned()
    };
    let mut attributes: Vec<(String, &str)> = node
        .attributes()
        .map(|a| (qualified(a.range().start), a.value()))
        .collect();
    attributes.sort();
    let indent = "  ".repeat(depth);
    lines.push_str(&indent);
    lines.push_str(&qualified(node.range().start + 1));
    for (name, value) in attributes {
        lines.push_str(&format!(" {name}={}", quoted(value)));
    }
    lines.push('\n');
    let mut words = String::new();
    let say = |words: &mut String, lines: &mut String| {
        let said: Vec<&str> = words.split_whitespace().collect();
        if !said.is_empty() {
            lines.push_str(&format!("{indent}  {}\n", quoted(&said.join(" "))));
        }
        words.clear();
    };
    for child in node.children() {
        if child.is_element() {
            say(&mut words, lines);
            normal(text, child, depth + 1, lines);
        } else if child.is_text() {
            words.push_str(child.text().unwrap_or_default());
        }
    }
    say(&mut words, lines);
}

fn arguments_of(text: &str) -> Vec<(String, String)> {
    let said = text
        .strip_prefix("<!-- arguments: ")
        .and_then(|rest| rest.split_once(" -->"));
    let words = said.map_or("", |(said, _)| said).split_whitespace();
    words
        .filter_map(|word| word.split_once(":="))
        .map(|(name, value)| (name.to_owned(), value.to_owned()))
        .collect()
}

#[test]
fn every_case_is_expanded_as_the_xacro_of_ros_expands_it() {
    let here = folder().display().to_string();
    let mut count = 0;
    for entry in fs::read_dir(folder().join("cases")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "xacro") {
            continue;
        }
        count += 1;
        let mut options = with_package();
        options
            .arguments
            .extend(arguments_of(&fs::read_to_string(&path).unwrap()));
        let text = urdf_text(&path, &options).unwrap_or_else(|e| panic!("{e:?}"));
        let mut found = String::new();
        let document = Document::parse(&text).unwrap();
        normal(&text, document.root_element(), 0, &mut found);
        let kept = fs::read_to_string(path.with_extension("expected")).unwrap();
        let found = found.replace(&here, "HERE");
        for (found, kept) in found.lines().zip(kept.lines()) {
            assert_eq!(found, kept, "{}", path.display());
        }
        assert_eq!(found, kept, "{}", path.display());
    }
    assert!(count >= 17, "{count} cases");
}

#[test]
fn what_xacro_refuses_is_refused() {
    let folder_of_files = tempfile::tempdir().unwrap();
    let path = folder_of_files.path().join("r.xacro");
    let refused = fs::read_to_string(folder().join("refused.txt")).unwrap();
    for line in refused.lines().filter(|line| !line.starts_with('#')) {
        fs::write(&path, format!("{HEAD}{line}</robot>")).unwrap();
        match urdf_text(&path, &with_package()) {
            Ok(text) => panic!("{line} is expanded to {text}"),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}

/// Bodies of robots that never end, or end much too late, and what is said of each.
fn endless() -> Vec<(&'static str, String, &'static str)> {
    let macro_of =
        |body: &str| format!("<xacro:macro name=\"m\" params=\"n\">{body}</xacro:macro>");
    let doubling: String = (0..60)
        .map(|i| {
            format!(
                "<xacro:property name=\"p{}\" value=\"${{p{i} + p{i}}}\"/>",
                i + 1
            )
        })
        .collect();
    let blocks: String = (0..40)
        .map(|i| {
            format!(
                "<xacro:property name=\"b{}\"><e><xacro:insert_block name=\"b{i}\"/><xacro:insert_block name=\"b{i}\"/></e></xacro:property>",
                i + 1
            )
        })
        .collect();
    let link = |inner: &str| format!("<link name=\"${{{inner}}}\"/>");
    vec![
        (
            "a macro that calls itself",
            macro_of("<xacro:m n=\"${n}\"/>") + "<xacro:m n=\"1\"/>",
            "deep",
        ),
        (
            "a macro that calls itself twice",
            macro_of(
                "<xacro:if value=\"${n &lt; 60}\"><xacro:m n=\"${n + 1}\"/><xacro:m n=\"${n + 1}\"/></xacro:if>",
            ) + "<xacro:m n=\"1\"/>",
            "steps",
        ),
        (
            "texts that double",
            format!(
                "<xacro:property name=\"p0\" value=\"ab\"/>{doubling}<link name=\"${{p60}}\"/>"
            ),
            "steps",
        ),
        (
            "blocks that double",
            format!(
                "<xacro:property name=\"b0\"><e/></xacro:property>{blocks}<xacro:insert_block name=\"b40\"/>"
            ),
            "",
        ),
        ("a long list", link("list(range(10 ** 12))"), "steps"),
        ("a long product", link("'ab' * 10 ** 12"), "steps"),
        ("a list of lists", link("[0] * 10 ** 9"), "steps"),
        ("a power", link("10 ** 10 ** 10"), ""),
        (
            "comprehensions",
            link("[1 for a in range(9999) for b in range(9999) for c in range(9999)]"),
            "steps",
        ),
        (
            "brackets",
            link(&("(".repeat(20_000) + "1" + &")".repeat(20_000))),
            "",
        ),
        (
            "square brackets",
            link(&("[".repeat(8000) + &"]".repeat(8000))),
            "",
        ),
        ("signs", link(&("-".repeat(8000) + "1")), ""),
        (
            "a function that calls itself",
            link("(lambda f: f(f))(lambda f: f(f))"),
            "deep",
        ),
        (
            "a sort with a slow key",
            link("sorted(range(10 ** 7), key=lambda i: -i)"),
            "steps",
        ),
        ("wide formats", link("'%999999999d' % 1"), "wider"),
        (
            "elements within each other",
            "<xacro:if value=\"1\">".repeat(5000) + &"</xacro:if>".repeat(5000),
            "deep",
        ),
    ]
}

/// Nothing is expanded for long: each is refused within seconds even without optimization, where an endless one would never be.
#[test]
fn what_has_no_end_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.xacro");
    for (what, body, said) in endless() {
        fs::write(&path, format!("{HEAD}{body}</robot>")).unwrap();
        let error = urdf_text(&path, &LoadOptions::default()).expect_err(what);
        let words = format!("{error:?}");
        assert!(words.contains(said), "{what}: {words}");
    }
}

#[test]
fn a_file_that_includes_itself_or_no_file_at_all_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.xacro");
    let devices: &[&str] = if cfg!(unix) {
        &["/dev/zero", "/dev/stdin", "/proc/self/environ"]
    } else {
        &[]
    };
    for name in [&["r.xacro", ".", "*.xacro"], devices].concat() {
        let include = format!("<xacro:include filename=\"{name}\"/>");
        fs::write(&path, format!("{HEAD}{include}</robot>")).unwrap();
        urdf_text(&path, &LoadOptions::default()).expect_err(name);
    }
}

/// A sum is not nested, however long it is.
#[test]
fn three_thousand_terms_are_added() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.xacro");
    let sum = "1+".repeat(3000) + "1";
    fs::write(&path, format!("{HEAD}<link name=\"${{{sum}}}\"/></robot>")).unwrap();
    let text = urdf_text(&path, &LoadOptions::default()).unwrap();
    assert!(text.contains("name=\"3001\""), "{text}");
}

/// Two expansions of the same file are the same to the byte.
#[test]
fn the_same_file_is_expanded_the_same() {
    for name in ["wheels", "collections", "yaml"] {
        let path = folder().join(format!("cases/{name}.xacro"));
        let once = urdf_text(&path, &with_package()).unwrap();
        assert_eq!(once, urdf_text(&path, &with_package()).unwrap());
    }
}
