//! Idioms that non-native readers would not understand are neither printed nor on a page.

use std::path::Path;
use std::process::Command;

/// Idioms of earlier versions, each with a plain equivalent.
const WORDS: [(&str, &str); 33] = [
    ("one's own", "your own"),
    ("whoever", "anybody who"),
    ("what comes of", "the result of"),
    ("what came of", "the result of"),
    ("comes to nothing", "has no effect"),
    ("is told", "is reported"),
    ("told of", "reported"),
    ("gives out", "reaches its limit"),
    ("took back", "corrected"),
    ("such as nothing", "none"),
    ("of its kin", "of this kind"),
    ("was asked for", "was commanded"),
    ("were asked for", "were commanded"),
    ("asks for more than there is", "is too fast"),
    ("nobody asked", "without a command"),
    ("the robot did", "it reached"),
    ("wheels turned for", "wheel speeds give"),
    ("slid up to", "slid by up to"),
    ("way made", "distance achieved"),
    ("makes least of", "falls shortest"),
    ("waited longest", "was held back longest"),
    ("as it is understood", "as read"),
    ("hold each against", "test"),
    ("lets it go on", "continues"),
    ("in its place)", "replaced by"),
    ("drive nothing else", "can only roll and turn"),
    ("which may be nothing", "within its uncertainty"),
    ("leave it open", "do not determine"),
    ("way to their angles", "steering error"),
    ("what takes it", "read it with"),
    ("more no further", "more by less"),
    ("put its end", "moved its end"),
    ("as it was asked", "as set"),
];

/// The commands that have a help of their own.
const COMMANDS: [&str; 14] = [
    "demo", "run", "explain", "report", "inspect", "check", "sweep", "identify", "compare",
    "generate", "export", "bench", "live", "schema",
];

/// Runs with different answers: open and closed loop, slip, a box, a push, weak motors, a joint.
const SCENARIOS: [&str; 8] = [
    "mecanum4_lateral",
    "mecanum4_wet_floor",
    "mecanum4_push_box",
    "mecanum4_push",
    "mecanum4_weak_motors_by_priority",
    "mecanum4_arm_swing",
    "swerve4_skew",
    "differential_turn_and_back",
];

fn ilon(folder: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_ilon"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the command runs");
    let [out, err] =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    out + &err
}

/// The visible text of a page, without scripts, styles, data and tags.
fn read(html: &str) -> String {
    let mut text = String::new();
    let mut rest = html;
    while let Some(at) = rest.find('<') {
        text += &rest[..at];
        let skipped = ["script", "style", "pre"]
            .into_iter()
            .find(|tag| rest[at + 1..].starts_with(tag));
        let end = match skipped {
            Some(tag) => rest[at..].find(&format!("</{tag}>")),
            None => rest[at..].find('>'),
        };
        rest = end.map_or("", |end| &rest[at + end + 1..]);
    }
    text + rest
}

/// Asserts that none of the words is in a text, with spaces and line breaks equivalent.
fn assert_plain(of: &str, text: &str) {
    let text = text
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
        .to_lowercase();
    let is_letter = |c: Option<char>| c.is_some_and(char::is_alphabetic);
    for (word, plainly) in WORDS {
        for (at, _) in text.match_indices(word) {
            let (before, after) = (&text[..at], &text[at + word.len()..]);
            let is_part = is_letter(before.chars().next_back()) || is_letter(after.chars().next());
            let around: String = before
                .chars()
                .rev()
                .take(60)
                .collect::<Vec<_>>()
                .into_iter()
                .rev()
                .collect();
            assert!(is_part, "{of} says \"{around}{word}\": say \"{plainly}\"");
        }
    }
}

#[test]
fn help_is_in_plain_words() {
    let here = Path::new(".");
    assert_plain("ilon --help", &ilon(here, &["--help"]));
    for command in COMMANDS {
        assert_plain(command, &ilon(here, &[command, "--help"]));
    }
}

#[test]
fn docs_are_in_plain_words() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let docs = std::fs::read_dir(root.join("docs")).expect("the docs");
    let docs = docs.map(|entry| entry.expect("an entry").path());
    let docs = docs.filter(|path| path.extension().is_some_and(|end| end == "md"));
    for page in docs.chain([root.join("README.md")]) {
        let text = std::fs::read_to_string(&page).expect("a page");
        assert_plain(&page.display().to_string(), &text);
    }
}

#[test]
fn answers_and_reports_are_in_plain_words() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../assets");
    for name in SCENARIOS {
        let scenario = assets
            .join(format!("scenarios/{name}.toml"))
            .display()
            .to_string();
        let said = ilon(
            folder.path(),
            &["run", &scenario, "--no-twins", "--table", "--out", name],
        );
        assert_plain(name, &said);
        let page = std::fs::read_to_string(folder.path().join(name).join("report.html"))
            .expect("a report");
        assert_plain(&format!("the report of {name}"), &read(&page));
    }
    let [one, other] = [SCENARIOS[0], SCENARIOS[2]];
    assert_plain("compare", &ilon(folder.path(), &["compare", one, other]));
    let page = std::fs::read_to_string(folder.path().join("out/compare.html")).expect("a page");
    assert_plain("the comparison", &read(&page));
    let robot = assets.join("robots/mecanum4.urdf").display().to_string();
    let said = ilon(
        folder.path(),
        &["inspect", &robot, "--limits", "--html", "robot.html"],
    );
    assert_plain("inspect", &said);
    let page = std::fs::read_to_string(folder.path().join("robot.html")).expect("a page");
    assert_plain("the page of a robot", &read(&page));
}
