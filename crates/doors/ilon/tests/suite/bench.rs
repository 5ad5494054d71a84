//! `ilon bench`: the table, the JSON and the page agree, and no file is left half written.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn ilon(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ilon"))
        .current_dir(folder)
        .arg("bench")
        .args(arguments)
        .output()
        .expect("the command runs")
}

fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder is there");
    let mut names: Vec<_> = entries
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .into_string()
                .expect("UTF-8")
        })
        .collect();
    names.sort();
    names
}

fn printed(stream: &[u8]) -> String {
    String::from_utf8_lossy(stream).into_owned()
}

/// One robot, two long steps in the contact window, and the minimum of everything else.
const LITTLE: [&str; 11] = [
    "--robot",
    "volksbot",
    "--rollers",
    "near",
    "--rates",
    "40,20",
    "--headings",
    "0,-15.5",
    "--rounds",
    "1",
    "--quick",
];

#[test]
fn table_json_and_page_say_the_same() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let mut arguments = LITTLE.to_vec();
    arguments.extend(["--fleets", "1,2", "--threads", "1,2", "--out", "a/b"]);
    let output = ilon(folder.path(), &arguments);
    let table = printed(&output.stdout);
    assert!(
        output.status.success(),
        "{table}{}",
        printed(&output.stderr)
    );
    let out = folder.path().join("a/b");
    assert_eq!(names_in(&out), ["bench.html", "bench.json"]);
    assert_eq!(names_in(folder.path()), ["a"]);

    let read = |name: &str| std::fs::read_to_string(out.join(name)).expect("it was written");
    let json: Value = serde_json::from_str(&read("bench.json")).expect("it is JSON");
    let page = read("bench.html");
    let carried = page
        .split("id=\"bench\">")
        .nth(1)
        .expect("the page carries its numbers");
    let carried = carried.split("</script>").next().expect("a closed element");
    let carried: Value =
        serde_json::from_str(&carried.replace("\\u003c", "<")).expect("numbers as JSON");
    assert_eq!(carried, json);

    let configurations = json["robots"]["volksbot"]["configurations"]
        .as_array()
        .expect("a list");
    let rows: Vec<Vec<&str>> = table
        .lines()
        .map(|line| line.split_whitespace().collect())
        .filter(|words: &Vec<_>| words.first() == Some(&"near"))
        .collect();
    assert_eq!((rows.len(), configurations.len()), (2, 2), "{table}");
    for (row, of) in rows.iter().zip(configurations) {
        let number = |key: &str| of[key].as_f64().expect("a number");
        let drives = ["D1", "D2", "D3", "D4", "D5"].map(|name| &of["drives"][name]);
        let mut expected = vec![
            format!("{:.0}", 1.0 / number("physics_dt_s")),
            format!("{:.4}", number("worst_error_pct")),
        ];
        let errors = drives
            .iter()
            .map(|drive| drive["error_pct"].as_f64().expect("a number"));
        expected.extend(errors.clone().map(|pct| format!("{pct:.4}")));
        expected.push(format!("{:.4}", 1e3 * number("hub_ripple_m")));
        expected.push(format!("{:.2}", 1e3 * number("slip_speed_rms_m_s")));
        expected.push(format!("{:.1}", number("sim_s_per_cpu_s")));
        expected.push(format!("{:.0}", number("steps_per_cpu_s")));
        assert_eq!(row[1..row.len() - 1], expected, "{table}");
        // The worst error is that of the drives, and a drive's that of its headings.
        assert_eq!(errors.reduce(f64::max), Some(number("worst_error_pct")));
        for drive in drives {
            let headings = drive["headings"].as_array().expect("a list");
            let at: Vec<_> = headings.iter().map(|h| h["heading_deg"].as_f64()).collect();
            assert_eq!(at, [Some(0.0), Some(-15.5)]);
            let worst = headings
                .iter()
                .filter_map(|h| h["error_pct"].as_f64())
                .reduce(f64::max);
            assert_eq!(worst, drive["error_pct"].as_f64());
        }
        // The robot did drive: at 20 steps per second the error is 0.08 %, and it slips.
        assert!(number("worst_error_pct") < 0.5 && number("slip_speed_rms_m_s") > 0.0);
    }
    let throughput = json["throughput"].as_array().expect("a list");
    let of = |t: &Value| {
        (
            t["robots"].as_u64(),
            t["threads"].as_u64(),
            t["efficiency"].is_null(),
        )
    };
    let expected = [(1, 1, false), (2, 1, false), (1, 2, true), (2, 2, false)];
    let expected = expected.map(|(robots, threads, none)| (Some(robots), Some(threads), none));
    assert_eq!(throughput.iter().map(of).collect::<Vec<_>>(), expected);
}

#[test]
fn json_stands_alone_on_standard_output_and_nothing_is_written_unasked() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let mut arguments = LITTLE.to_vec();
    arguments.extend(["--fleets", "0", "--json"]);
    let output = ilon(folder.path(), &arguments);
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    assert!(json["robots"]["volksbot"]["sim_s_per_cpu_s"].as_f64() > Some(1.0));
    assert_eq!(json["throughput"], Value::Array(Vec::new()));
    assert!(names_in(folder.path()).is_empty());
}

/// Contacts solved by rapier support neither treads nor rollers that slide along their axles.
#[test_case::test_case("tread.stiffness_n_m = 1e5", "a tread"; "treads")]
#[test_case::test_case("axial_play_m = 2e-4", "play"; "play")]
fn of_a_robot_that_rapier_does_not_know_all_of_the_rest_is_measured(key: &str, named: &str) {
    let folder = tempfile::tempdir().expect("a folder to work in");
    let described = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../assets/robots/volksbot.toml"
    );
    let described = std::fs::read_to_string(described).expect("a shipped robot");
    let described = described.replacen("[rollers]\n", &format!("[rollers]\n{key}\n"), 1);
    std::fs::write(folder.path().join("own.toml"), described).expect("a file to write");
    let little = [
        "--robot",
        "own.toml",
        "--rates",
        "240",
        "--headings",
        "0",
        "--rounds",
        "1",
        "--fleets",
        "0",
    ];
    let output = ilon(folder.path(), &[&little[..], &["--json"]].concat());
    let said = printed(&output.stderr);
    assert!(output.status.success(), "{said}");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    let own = &json["robots"]["own"];
    let configurations = own["configurations"].as_array().expect("a list");
    let kinds = configurations.iter().map(|c| c["roller_bodies"].as_str());
    assert_eq!(kinds.collect::<Vec<_>>(), [Some("all"), Some("near")]);
    let remark = own["remarks"][0].as_str().expect("a remark");
    assert!(
        remark.contains("rapier") && remark.contains(named) && said.contains(remark),
        "{remark}: {said}"
    );

    // Requested alone, they are refused.
    let output = ilon(
        folder.path(),
        &[&little[..], &["--rollers", "rapier"]].concat(),
    );
    let said = printed(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains(named) && output.stdout.is_empty(), "{said}");
}

#[test_case::test_case(&["--robot", "mecanum5"], "no built-in robot `mecanum5`"; "no robot")]
#[test_case::test_case(&["--robot", "none/base.urdf"], "none/base.urdf"; "no file")]
#[test_case::test_case(&["--robot", "volksbot", "--robot", "volksbot"], "two robots are called `volksbot`"; "twice")]
#[test_case::test_case(&["--rates", "240,0"], "give a number of steps a second from 1 to 100000"; "no rate")]
#[test_case::test_case(&["--headings", "nan"], "give a number of degrees from -360 to 360"; "not a number")]
#[test_case::test_case(&["--rollers", "some"], "name `all` rollers, those `near` the ground, or `rapier`"; "no kind")]
#[test_case::test_case(&["--rounds", "0"], "give a whole number from 1 to 10000"; "no round")]
#[test_case::test_case(&["--threads", "0"], "give a whole number from 1 to 10000"; "no thread")]
#[test_case::test_case(&["--fleets", "1.5"], "give a whole number, 10000 at most"; "half a robot")]
#[test_case::test_case(&["--out", "taken"], "cannot write `taken`"; "no folder")]
fn what_cannot_be_measured_is_refused_in_words_before_anything_is(arguments: &[&str], words: &str) {
    let folder = tempfile::tempdir().expect("a folder to work in");
    std::fs::write(folder.path().join("taken"), "").expect("a file in the way");
    let output = ilon(folder.path(), arguments);
    let said = printed(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains(words), "{said}");
    assert!(!said.contains("panicked") && output.stdout.is_empty());
    assert_eq!(names_in(folder.path()), ["taken"]);
}

#[test]
fn a_page_that_cannot_be_written_leaves_nothing_that_looks_whole() {
    let folder = tempfile::tempdir().expect("a folder to work in");
    // A folder in place of the page, and older figures in place of the new ones.
    std::fs::create_dir(folder.path().join("bench.html")).expect("a folder in the way");
    std::fs::write(folder.path().join("bench.json"), "{}").expect("an older file");
    let mut arguments = LITTLE.to_vec();
    arguments.extend(["--fleets", "0", "--out", "."]);
    let output = ilon(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(2));
    assert!(printed(&output.stderr).contains("bench.html"));
    assert_eq!(names_in(folder.path()), ["bench.html"]);
}
