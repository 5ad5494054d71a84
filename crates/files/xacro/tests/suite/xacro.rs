//! Expansion of the cases in `tests/cases` equals that of ROS xacro (`tests/real.py` compares the
//! two), and endless input is refused.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use roxmltree::{Document, Node};
use xacro_expand::{ExpandError, LocalHost, Settings, expand};

const HEAD: &str = r#"<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">"#;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")
}

fn with_package() -> LocalHost {
    LocalHost {
        packages: [("a_robot".to_owned(), folder().join("packages/a_robot"))].into(),
    }
}

fn expanded(
    path: &Path,
    host: &LocalHost,
    arguments: BTreeMap<String, String>,
) -> Result<String, Box<ExpandError>> {
    let settings = Settings {
        arguments,
        ..Settings::default()
    };
    let text = fs::read_to_string(path).expect("a text");
    expand(path, &text, &settings, host).map(|expanded| expanded.text)
}

/// A text in JSON quotes.
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

fn arguments_of(text: &str) -> BTreeMap<String, String> {
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
        let arguments = arguments_of(&fs::read_to_string(&path).unwrap());
        let text = expanded(&path, &with_package(), arguments).unwrap_or_else(|e| panic!("{e:?}"));
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
        match expanded(&path, &with_package(), BTreeMap::new()) {
            Ok(text) => panic!("{line} is expanded to {text}"),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}

/// A nested expression of a number of levels.
fn nested(innermost: &str, around: &str, levels: usize) -> String {
    (0..levels).fold(innermost.to_owned(), |inner, _| {
        around.replace("{}", &inner)
    })
}

/// Ten times ten times ... the same: one kilobyte that expands to gigabytes.
fn alias_bomb() -> String {
    let level = |i: usize| {
        let aliases = vec![format!("*a{i}"); 10].join(", ");
        format!("a{0}: &a{0} [{aliases}]\n", i + 1)
    };
    "a0: &a0 [0]\n".to_owned() + &(0..12).map(level).collect::<String>()
}

/// Lists within lists by way of aliases, none of them deep in its line.
fn deep_aliases() -> String {
    let level = |i: usize| format!("a{0}: &a{0} [*a{i}]\n", i + 1);
    "a0: &a0 [0]\n".to_owned() + &(0..50_000).map(level).collect::<String>()
}

/// Bodies of robots whose expansion never ends, or ends much too late, and the message for each.
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
        ("a list of a list", link("[[0] * 10000] * 100000"), "steps"),
        (
            "a dictionary of dictionaries",
            link(&format!(
                "dict(a={0}, b={0})",
                nested("dict(a=[0]*9999)", "[{} for i in range(99)]", 3)
            )),
            "steps",
        ),
        (
            "a text of lists",
            link("'%s' % ([['ab'] * 9999] * 99999,)"),
            "steps",
        ),
        (
            "a text of a list",
            link("str([[0] * 9999] * 99999)"),
            "steps",
        ),
        (
            "joined texts",
            link("len('a'.join(['b' * 9999] * 999999))"),
            "steps",
        ),
        (
            "lists that are compared",
            link("[[[0] * 99999] * 999 == [[0] * 99999] * 999 for i in range(99999)]"),
            "steps",
        ),
        (
            "a list that is looked for in lists",
            link("[[[0] * 9999] * 99] in [[[[0] * 9999] * 99]] * 99999"),
            "steps",
        ),
        (
            "keys of rows of rows",
            link(&format!(
                "dict([({}, 1)])",
                nested("tuple(range(99))", "tuple([{} for i in range(99)])", 4)
            )),
            "",
        ),
        (
            "texts that are measured",
            "<xacro:property name=\"t\" value=\"${'a' * 40000000}\"/>".to_owned()
                + &link("[len(t) for i in range(300000)]"),
            "steps",
        ),
        (
            "texts that are looked through",
            "<xacro:property name=\"t\" value=\"${'a' * 40000000}\"/>".to_owned()
                + &link("['b' in t for i in range(300000)]"),
            "steps",
        ),
        (
            "texts that are taken apart",
            link("len(('\\n' * 60000000).splitlines())"),
            "steps",
        ),
        (
            "functions that keep what is around them",
            link(
                "(lambda a, b, c, d, e, f, g, h: len([lambda: a for i in range(1200000)]))(1, 2, 3, 4, 5, 6, 7, 8)",
            ),
            "steps",
        ),
        (
            "a text that is repeated in an attribute",
            "<xacro:property name=\"t\" value=\"${'a' * 4000000}\"/>".to_owned()
                + &format!("<link name=\"{}\"/>", "${t}".repeat(4000)),
            "steps",
        ),
        (
            "an argument that is repeated in an attribute",
            "<xacro:arg name=\"t\" default=\"${'a' * 4000000}\"/>".to_owned()
                + &format!("<link name=\"{}\"/>", "$(arg t)".repeat(4000)),
            "steps",
        ),
        (
            "a long tag in a macro",
            format!(
                "<xacro:macro name=\"m\" params=\"n\"><a{}/>",
                "a".repeat(100_000)
            ) + "<xacro:if value=\"${n > 0}\"><xacro:m n=\"${n - 1}\"/><xacro:m n=\"${n - 1}\"/></xacro:if></xacro:macro>"
                + "<xacro:m n=\"30\"/>",
            "steps",
        ),
        (
            "text as it is in a macro",
            format!(
                "<xacro:macro name=\"m\" params=\"n\"><a><![CDATA[{}]]></a>",
                "a".repeat(100_000)
            ) + "<xacro:if value=\"${n > 0}\"><xacro:m n=\"${n - 1}\"/><xacro:m n=\"${n - 1}\"/></xacro:if></xacro:macro>"
                + "<xacro:m n=\"30\"/>",
            "steps",
        ),
        (
            "a long default in a macro",
            format!(
                "<xacro:macro name=\"m\" params=\"n a:='{}'\">",
                "a".repeat(100_000)
            ) + "<xacro:if value=\"${n > 0}\"><xacro:m n=\"${n - 1}\" a=\"1\"/><xacro:m n=\"${n - 1}\" a=\"1\"/></xacro:if></xacro:macro>"
                + "<xacro:m n=\"30\"/>",
            "steps",
        ),
        (
            "lists that nest by being zipped",
            (0..200)
                .map(|i| {
                    let name = format!("<xacro:property name=\"z{}\"", i + 1);
                    format!("{name} value=\"${{python.list(python.zip(z{i}))}}\"/>")
                })
                .fold(
                    "<xacro:property name=\"z0\" value=\"${[1]}\"/>".to_owned(),
                    |all, z| all + &z,
                )
                + &link("z200"),
            "nested",
        ),
        (
            "aliases",
            "<link name=\"${xacro.load_yaml('bomb.yaml')}\"/>".to_owned(),
            "steps",
        ),
        (
            "aliases that are compared",
            "<link name=\"${xacro.load_yaml('bomb.yaml') == xacro.load_yaml('bomb.yaml')}\"/>"
                .to_owned(),
            "steps",
        ),
        (
            "aliases that nest",
            "<link name=\"${xacro.load_yaml('deep.yaml')}\"/>".to_owned(),
            "nested",
        ),
        (
            "elements within each other",
            "<xacro:if value=\"1\">".repeat(5000) + &"</xacro:if>".repeat(5000),
            "deep",
        ),
    ]
}

/// Each is refused within seconds even without optimisation.
#[test]
fn what_has_no_end_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.xacro");
    fs::write(folder.path().join("bomb.yaml"), alias_bomb()).unwrap();
    fs::write(folder.path().join("deep.yaml"), deep_aliases()).unwrap();
    for (what, body, said) in endless() {
        fs::write(&path, format!("{HEAD}{body}</robot>")).unwrap();
        let start = std::time::Instant::now();
        let error = expanded(&path, &LocalHost::default(), BTreeMap::new()).expect_err(what);
        let words = format!("{error:?}");
        assert!(words.contains(said), "{what}: {words}");
        // Without optimisation, with other load on the machine.
        println!("{what}: {:?}", start.elapsed());
        assert!(
            start.elapsed().as_secs() < 60,
            "{what}: {:?}",
            start.elapsed()
        );
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
        expanded(&path, &LocalHost::default(), BTreeMap::new()).expect_err(name);
    }
}

/// A sum is not nested, however long it is.
#[test]
fn three_thousand_terms_are_added() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.xacro");
    let sum = "1+".repeat(3000) + "1";
    fs::write(&path, format!("{HEAD}<link name=\"${{{sum}}}\"/></robot>")).unwrap();
    let text = expanded(&path, &LocalHost::default(), BTreeMap::new()).unwrap();
    assert!(text.contains("name=\"3001\""), "{text}");
}

/// Two expansions of the same file are the same bytes.
#[test]
fn the_same_file_is_expanded_the_same() {
    for name in ["wheels", "collections", "yaml"] {
        let path = folder().join(format!("cases/{name}.xacro"));
        let once = expanded(&path, &with_package(), BTreeMap::new()).unwrap();
        assert_eq!(
            once,
            expanded(&path, &with_package(), BTreeMap::new()).unwrap()
        );
    }
}

/// Elements without a prefix, as until 2014: by default they are kept, and errors that result
/// mention it; with the option they expand as the same file with prefixes does.
#[test]
fn elements_without_a_prefix_are_read_as_until_2014_where_that_is_asked_for() {
    let old = r#"<robot><property name="r" value="0.05"/><macro name="ball" params="at"><sphere radius="${r}" at="${at}"/></macro>
        <if value="1"><ball at="${2 * r}"/></if><unless value="1"><ball at="9"/></unless><material name="m"/></robot>"#;
    let new = r#"<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="r" value="0.05"/><xacro:macro name="ball" params="at"><sphere radius="${r}" at="${at}"/></xacro:macro>
        <xacro:if value="1"><xacro:ball at="${2 * r}"/></xacro:if><xacro:unless value="1"><xacro:ball at="9"/></xacro:unless><material name="m"/></robot>"#;
    let text = |text: &str, before_2014| {
        let settings = Settings {
            before_2014,
            ..Settings::default()
        };
        let path = folder().join("old.xacro");
        expand(&path, text, &settings, &LocalHost::default())
    };
    let failure = text(old, false).unwrap_err();
    assert!(failure.of_before_2014, "{}", failure.reason);
    let read = text(old, true).unwrap();
    assert_eq!(read.notes.len(), 1);
    let shape = |text: &str| {
        let document = Document::parse(text).unwrap();
        let mut lines = String::new();
        normal(text, document.root_element(), 0, &mut lines);
        lines
    };
    let meant = text(new, false).unwrap();
    assert_eq!(shape(&read.text), shape(&meant.text));
    assert!(read.text.contains(r#"at="0.1""#), "{}", read.text);
    // A foreign element with the name of a macro is not a call of it: it has other parameters, or
    // too few.
    for other in [
        r#"<ball type="ray"/>"#,
        "<ball/>",
        r#"<ball at="1" type="ray"/>"#,
    ] {
        let beside =
            |file: &str| file.replace("</robot>", &format!("<gazebo>{other}</gazebo></robot>"));
        let read = text(&beside(old), true).unwrap();
        let meant = text(&beside(new), false).unwrap();
        assert_eq!(shape(&read.text), shape(&meant.text));
    }
}
